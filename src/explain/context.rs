//! What a stream teaches about what comes later.

use crate::map::Map;

use super::value::Lengths;
use super::{Explanation, Sender, frame, pkw, ppo};
pub(crate) use crate::devices::ag03::drive::Mode;
use crate::devices::ag03::param::{Model, Models, Parameter, Pnu};
use crate::devices::ag03::profibus::IDENT_NUMBER;
use crate::profibus::dp::Service;
use crate::profibus::fdl::{Address, FrameCount, Sap};
use crate::profibus::pkw::ErrorNumber;
use crate::profibus::ppo::{JobId, Pkw, ReplyId};

/// Explains telegrams and words one after the other, and remembers what helps with the next: which request a response
/// answers, the job a reply belongs to, operating mode and unit of each station as far as PNU 930 and 1012 told, its model
/// as far as a parameter told that only the AG03/1 has.
///
/// Takes memory for at most 127 stations, however long the stream.
#[derive(Clone, Debug, Default)]
pub struct Context {
    mode: Option<Mode>,
    stations: Map<u8, Learned>,
    /// Of words without a telegram around them.
    bare: Learned,
    pub(super) asked: Option<Asked>,
}

/// The operating modes, in each of which the bits of the positioning drives mean something else: name, what it is.
pub(crate) const MODES: [(&str, &str, Mode); 2] = [
    ("positioning", "Positioning mode, PNU 930 = 2", Mode::Positioning),
    ("velocity", "Velocity mode, PNU 930 = 1", Mode::Velocity),
];

/// The last request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Asked {
    pub(super) master: u8,
    pub(super) station: u8,
    pub(super) service: Option<Service>,
    pub(super) fdl: crate::profibus::fdl::Service,
}

/// What is known of one station.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Learned {
    given: Option<Mode>,
    pub(super) heard: Option<Mode>,
    pub(super) model: Option<Model>,
    pub(super) lengths: Lengths,
    /// Ident_Number of the last Set_Prm.
    pub(super) asked_ident: Option<u16>,
    /// Ident_Number that the station itself said, or who knows it.
    pub(super) own_ident: Option<u16>,
    pub(super) stw: u16,
    pub(super) zsw: u16,
    pub(super) job: Option<Pkw>,
    /// How many replies came since the job changed, none of them to it.
    pub(super) unanswered: u32,
    /// Whose parameter channel was looked at last.
    pub(super) last: Option<Sender>,
    /// SAP, slot and index of the last request of DP-V1 that is for a record.
    pub(super) record: Option<(Sap, (u8, u8))>,
    /// Who asked last, and the frame count.
    pub(super) count: Option<(u8, FrameCount)>,
}

impl Context {
    /// A context in which every drive is in this operating mode, whatever is heard of it.
    pub fn with_mode(mode: Mode) -> Self {
        Self { mode: Some(mode), ..Self::default() }
    }

    /// A context for the words of one drive that is known: those without a telegram around them.
    pub(crate) fn of_drive(model: Model, mode: Mode, lengths: Lengths) -> Self {
        let bare = Learned { heard: Some(mode), lengths, model: Some(model), ..Learned::default() };
        Self { bare, ..Self::default() }
    }

    /// Explains one telegram. What is no telegram, or more than one, is [`Mark::Invalid`](super::Mark::Invalid) with
    /// the reason and the octet.
    pub fn telegram(&mut self, octets: &[u8]) -> Explanation {
        frame::explain(octets, self)
    }

    /// Takes from who knows the station (the drive itself) what on the line only PNU 930 and 1012 tell: operating mode
    /// and what positions are counted in; and its model. What is heard later counts again. What an AG03 refuses is then
    /// a [`Mistake`](super::Mark::Mistake) of who sends it there; of other stations it is at most a hint, until they say
    /// their Ident_Number in a diagnosis.
    pub fn know(&mut self, station: Address, model: Model, mode: Mode, lengths: Lengths) {
        let learned = self.stations.or_default(station.number());
        learned.model = Some(model);
        learned.heard = Some(mode);
        learned.lengths = lengths;
        learned.own_ident = Some(IDENT_NUMBER);
    }

    /// Takes a station for one of the device that writes its words in names, in this operating mode.
    pub(crate) fn know_named(&mut self, station: Address, mode: Mode) {
        self.know(station, Model::Ag03_1, mode, Lengths::Unknown);
    }

    /// Takes the Ident_Number of a station from who knows it, until the station says its own: words of other devices are
    /// not taken for those of these drives.
    pub(crate) fn know_ident(&mut self, station: Address, ident: u16) {
        self.stations.or_default(station.number()).own_ident = Some(ident);
    }

    /// Explains words without a telegram: a PPO (14 octets), PKW (8), PZD (6) or one word (2), from the master or
    /// the drive. Without a `sender` the words must tell; `None` for another number of octets.
    pub fn bare(&mut self, octets: &[u8], sender: Option<Sender>) -> Option<Explanation> {
        let mut learned = Learned { given: self.mode, ..self.bare };
        let explanation = ppo::bare(octets, sender, &mut learned);
        self.bare = learned;
        explanation
    }

    pub(super) fn station(&self, station: u8) -> Learned {
        let learned = self.stations.get(&station).copied().unwrap_or_default();
        Learned { given: self.mode, ..learned }
    }

    pub(super) fn learn(&mut self, station: u8, learned: Learned) {
        self.stations.insert(station & 0x7F, learned);
    }
}

impl Learned {
    /// The operating mode: given, heard, or the one of a new drive.
    pub(super) fn mode(&self) -> Mode {
        self.given.or(self.heard).unwrap_or(Mode::Positioning)
    }

    /// Ident_Number as far as known: the station's own, or what a master takes it for.
    pub(super) fn ident(&self) -> Option<u16> {
        self.own_ident.or(self.asked_ident)
    }

    /// Learns what is asked for now.
    pub(super) fn hear_job(&mut self, job: Pkw) {
        if self.job != Some(job) {
            self.unanswered = 0;
        }
        self.job = Some(job);
    }

    /// Learns from a reply of the drive to the last job.
    pub(super) fn hear_reply(&mut self, reply: Pkw) {
        if self.answers(reply) == Some(false) && reply.pke.reply() != ReplyId::NoReply {
            self.unanswered = self.unanswered.saturating_add(1);
        }
        let unknown = ErrorNumber::IllegalParameterNumber.number();
        if reply.pke.reply() == ReplyId::Word {
            self.hear_value(reply.pke.pnu(), Some(reply.word()));
        } else if reply.pke.reply() == ReplyId::NotExecutable && reply.word() == unknown {
            self.hear_value(reply.pke.pnu(), None);
        }
    }

    /// Learns the value of a parameter; `None`: the drive has no such parameter.
    pub(super) fn hear_value(&mut self, number: u16, value: Option<u16>) {
        if pkw::known(number).is_some_and(|entry| matches!(entry.models, Models::OnlyAg03_1)) {
            self.model = Some(if value.is_some() { Model::Ag03_1 } else { Model::Ag03 });
        }
        let (pnu, Some(value)) = (Pnu::from_low_bits(number), value) else { return };
        if pnu == Parameter::OperatingMode.entry().pnu {
            self.heard = Mode::of_number(value).or(self.heard);
        } else if pnu == Parameter::SpindlePitch.entry().pnu {
            self.lengths = Lengths::of_spindle_pitch(value.into());
        }
    }

    /// Whether `reply` can be the answer to the last job.
    pub(super) fn answers(&self, reply: Pkw) -> Option<bool> {
        let job = self.job.filter(|job| job.pke.job() != JobId::NoJob)?;
        Some(Pnu::from_low_bits(job.pke.pnu()) == Pnu::from_low_bits(reply.pke.pnu()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profibus::ppo::{Ind, Pke};

    #[test]
    fn what_is_heard_after_it_was_told_counts_again() {
        let mut context = Context::default();
        let at = Address::station(5).unwrap();
        context.know(at, Model::Ag03, Mode::Velocity, Lengths::HundredthMillimetres);
        let mut learned = context.station(5);
        assert_eq!((learned.mode(), learned.lengths), (Mode::Velocity, Lengths::HundredthMillimetres));
        assert_eq!(context.station(6).mode(), Mode::Positioning);
        for (pnu, value) in [(930, 2), (1012, 0)] {
            // AK 1: a word.
            learned.hear_reply(Pkw::new(Pke::from_raw(0x1000 | pnu), Ind::from_raw(0), value));
        }
        assert_eq!(learned.model, Some(Model::Ag03));
        // The battery voltage, which only an AG03/1 tells; error 0, no such number, is an AG03's.
        learned.hear_reply(Pkw::new(Pke::from_raw(0x1000 | 1042), Ind::from_raw(0), 300));
        assert_eq!(learned.model, Some(Model::Ag03_1));
        learned.hear_reply(Pkw::new(Pke::from_raw(0x7000 | 1042), Ind::from_raw(0), 0));
        assert_eq!(learned.model, Some(Model::Ag03));
        context.learn(5, learned);
        let learned = context.station(5);
        assert_eq!((learned.mode(), learned.lengths), (Mode::Positioning, Lengths::Increments));
    }
}
