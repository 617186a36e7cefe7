//! Questions to stations before, or instead of, taking one over: is it there, and what does its diagnosis say?

use crate::map::Map;
use std::collections::VecDeque;

use profirust::fdl::{
    DataTelegramHeader, FdlActiveStation, FdlApplication, FrameCountBit, FunctionCode, ResponseState,
    ResponseStatus, Telegram, TelegramTx, TelegramTxResponse,
};
use profirust::time::Instant;

use crate::devices::ag03::profibus::IDENT_NUMBER;
use crate::profibus::dp::{MASTER_SAP, PrmBit, Service};
use crate::profibus::fdl::{Sap, StationType};

/// Unlock_Req, watchdog off with factors of 1, min T_SDR unchanged, ident number, no groups
/// (`dp::set_prm` draws it).
const UNLOCK: [u8; 7] = {
    let [high, low] = IDENT_NUMBER.to_be_bytes();
    [PrmBit::UnlockReq.mask(), 1, 1, 0, high, low, 0]
};

/// One question to one station.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Question {
    /// FDL status.
    Status,
    /// Slave_Diag, which changes nothing and locks nothing.
    Diagnosis,
    /// Set_Prm with Unlock_Req: the slave is no longer ours.
    Release,
    /// Data from one SAP to another, or without SAPs: Data_Exchange. Repeated, it is the same telegram: it runs once.
    Data { saps: Option<(u8, u8)>, data: Vec<u8> },
}

/// What came of a question.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    /// Nothing, however often it was asked.
    Silence,
    /// A station of this type, and the data of its answer.
    Station(StationType, Vec<u8>),
    /// The same, of high priority: the slave has a new diagnosis.
    Urgent(Vec<u8>),
    /// SC.
    ShortAcknowledge,
    /// NR: nothing to say, to data.
    NothingToSay,
    /// RS, to data.
    NotActivated,
    /// RR, to data.
    NoResource,
}

/// A layer on profirust's token: asks what is queued, repeats what is not answered, keeps the answers.
#[derive(Debug, Default)]
pub(super) struct Inquiry {
    questions: VecDeque<(u8, Question)>,
    /// How often the first was asked.
    asked: u8,
    answers: VecDeque<(u8, Answer)>,
    /// The frame count bit of the next telegram to each slave.
    frame_counts: Map<u8, FrameCountBit>,
}

impl Question {
    /// How often it is asked if nobody answers.
    fn tries(&self, retry_limit: u8) -> u8 {
        let most = retry_limit.saturating_add(1);
        match self {
            // Most addresses of a line are free, and each costs all its tries.
            Self::Status => most.min(2),
            Self::Diagnosis | Self::Release | Self::Data { .. } => most,
        }
    }
}

impl Inquiry {
    pub(super) fn ask(&mut self, address: u8, question: Question) {
        self.questions.push_back((address, question));
    }

    pub(super) fn take_answer(&mut self) -> Option<(u8, Answer)> {
        self.answers.pop_front()
    }

    pub(super) fn is_done(&self) -> bool {
        self.questions.is_empty() && self.answers.is_empty()
    }

    /// Forgets what was not asked yet.
    pub(super) fn clear(&mut self) {
        self.questions.clear();
        self.answers.clear();
        self.asked = 0;
    }

    /// What is asked now.
    fn question(&self) -> Option<&Question> {
        self.questions.front().map(|(_, question)| question)
    }

    /// No answer of use: it is asked once more, or that is what has come of it.
    fn unanswered(&mut self, fdl: &FdlActiveStation, address: u8, answer: Answer) {
        if self
            .question()
            .is_some_and(|question| self.asked >= question.tries(fdl.parameters().max_retry_limit))
        {
            self.answered(address, answer);
        }
    }

    fn answered(&mut self, address: u8, answer: Answer) {
        // Anything else is the answer to a question that was taken back.
        if self.questions.front().is_some_and(|(asked, _)| *asked == address) {
            let question = self.questions.pop_front().map(|(_, question)| question);
            let count = self.frame_counts.or_default(address);
            match (question, &answer) {
                (Some(Question::Status) | None, _) => {}
                (Some(_), Answer::Silence) => count.reset(),
                (Some(Question::Diagnosis | Question::Release), _) => {
                    count.reset();
                    count.cycle();
                }
                (Some(Question::Data { .. }), _) => count.cycle(),
            }
            self.asked = 0;
            self.answers.push_back((address, answer));
        }
    }
}

impl FdlApplication for Inquiry {
    fn transmit_telegram(
        &mut self,
        _: Instant,
        fdl: &FdlActiveStation,
        tx: TelegramTx<'_>,
        _: bool,
    ) -> Option<TelegramTxResponse> {
        let (da, question) = self.questions.front()?;
        let da = *da;
        let sa = fdl.parameters().address;
        self.asked = self.asked.saturating_add(1);
        let of = |service: Service| (service.sap().map(Sap::number), MASTER_SAP.map(Sap::number));
        let ((dsap, ssap), data): (_, &[u8]) = match question {
            Question::Status => return Some(tx.send_fdl_status_request(da, sa)),
            Question::Diagnosis => (of(Service::SlaveDiag), &[]),
            Question::Release => (of(Service::SetPrm), &UNLOCK),
            Question::Data { saps, data } => {
                let (dsap, ssap) = saps.map_or((None, None), |(dsap, ssap)| (Some(dsap), Some(ssap)));
                ((dsap, ssap), data)
            }
        };
        let count = match question {
            Question::Status | Question::Diagnosis | Question::Release => FrameCountBit::First,
            Question::Data { .. } => self.frame_counts.get(&da).copied().unwrap_or_default(),
        };
        let fc = FunctionCode::new_srd_low(count);
        let header = DataTelegramHeader { da, sa, dsap, ssap, fc };
        Some(tx.send_data_telegram(header, data.len(), |pdu| {
            for (to, octet) in pdu.iter_mut().zip(data) {
                *to = *octet;
            }
        }))
    }

    fn receive_reply(&mut self, _: Instant, fdl: &FdlActiveStation, address: u8, telegram: Telegram<'_>) {
        let to_data = matches!(self.question(), Some(Question::Data { .. }));
        let answer = match telegram {
            Telegram::Data(data) => match data.h.fc {
                FunctionCode::Response { status: ResponseStatus::NoDataReady, .. } if to_data => {
                    Answer::NothingToSay
                }
                FunctionCode::Response { status: ResponseStatus::NoResources, .. } if to_data => {
                    Answer::NoResource
                }
                FunctionCode::Response {
                    status: ResponseStatus::SapNotEnabled | ResponseStatus::UserError,
                    ..
                } if to_data => Answer::NotActivated,
                FunctionCode::Response { status: ResponseStatus::DataHigh, .. } if to_data => {
                    Answer::Urgent(data.pdu.to_vec())
                }
                FunctionCode::Response { state, .. } => {
                    Answer::Station(station_type(state), data.pdu.to_vec())
                }
                FunctionCode::Request { .. } => return,
            },
            // FDL status is answered by a telegram: this is noise, in which the answer may have been lost.
            Telegram::ShortConfirmation(_) if self.question() == Some(&Question::Status) => {
                return self.unanswered(fdl, address, Answer::Silence);
            }
            Telegram::ShortConfirmation(_) => Answer::ShortAcknowledge,
            Telegram::Token(_) => return,
        };
        self.answered(address, answer);
    }

    fn handle_timeout(&mut self, _: Instant, fdl: &FdlActiveStation, address: u8) {
        self.unanswered(fdl, address, Answer::Silence);
    }
}

const fn station_type(state: ResponseState) -> StationType {
    match state {
        ResponseState::Slave => StationType::Slave,
        ResponseState::MasterNotReady => StationType::MasterNotReady,
        ResponseState::MasterWithoutToken => StationType::MasterReady,
        ResponseState::MasterInRing => StationType::MasterInRing,
    }
}
