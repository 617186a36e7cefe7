//! The frame count bit: what is a retry, and what is not.

use super::{row, softer};
use crate::judge::device::course::{Course, broken};
use crate::judge::device::row::{By, Entry, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::answer::Answer;
use crate::judge::device::slave::request::Request;
use crate::judge::requirement::Confidence::{A, B, U};
use crate::profibus::dp::Service;
use crate::profibus::fdl::{FrameCount, ReplyStatus};

pub(super) const GROUP: Group<Tester> = Group {
    title: "Frame count bit",
    rows: &[
        sure(row(
            "S-C01",
            "a first request, FCV 0 and FCB 1, is carried out",
            "FCV = 0, FCB = 1 is a first cycle: processed as new, and stored (2.3 rule 1)",
            &[],
            By::Trial(c01),
        )),
        sure(row(
            "S-C02",
            "requests with FCV 1 and an FCB that toggles are each carried out",
            "the same SA and a toggled FCB is a new cycle (2.3 rule 2)",
            &["S-C01"],
            By::Trial(c02),
        )),
        sure(row(
            "S-C03",
            "a repeated Data_Exchange is answered as before",
            "the same FCB from the same SA is a retry: the reply is sent again (2.3 rule 4)",
            &["S-X01", "S-C04"],
            By::Trial(c03),
        )),
        sure(row(
            "S-C04",
            "a repeated Slave_Diag gives the same diagnosis",
            "a retry of Slave_Diag returns the same octets and consumes no second event (6.2 rule 6)",
            &["S-C02"],
            By::Trial(c04),
        )),
        sure(row(
            "S-C05",
            "a repeated Set_Prm and Chk_Cfg: SC again, and nothing is done twice",
            "the service is not run again, no state changes (2.3 rule 4)",
            &["S-X01", "S-C04"],
            By::Trial(c05),
        )),
        sure(row(
            "S-C06",
            "the same FCB from another master is new",
            "another SA: the stored FCB is not evaluated (2.3 rule 3)",
            &["S-C01", "S-C02"],
            By::Trial(c06),
        )),
        sure(row(
            "S-C07",
            "two first requests one after the other are both new",
            "FCV = 0, FCB = 1 is always a first cycle (2.3 rule 1)",
            &["S-C01"],
            By::Trial(c07),
        )),
        softer(
            row(
                "S-C08",
                "the same FCB from the same master with another service is new",
                "masters lose count after lost replies: whoever compares the octets, too, does not answer an old question (2.3)",
                &["S-C02"],
                By::Trial(c08),
            ),
            2,
            U,
        ),
        softer(
            row(
                "S-C09",
                "the first request after power on is new, with FCV 1 and either FCB, too",
                "a restarted slave has nothing stored (2.3)",
                &["S-C02"],
                By::Trial(c09),
            ),
            2,
            B,
        ),
        softer(
            row(
                "S-C10",
                "a retry after an FDL status request between: the reply again, or a new one",
                "whether FDL status drops the stored reply is open (2.3)",
                &["S-C02", "S-F01"],
                By::Trial(c10),
            ),
            2,
            U,
        ),
    ],
};

/// A page of the standard says it.
const fn sure(entry: Entry<Tester>) -> Entry<Tester> {
    softer(entry, 1, A)
}

/// Slave_Diag and Get_Cfg in turn: whose answer is whose shows which request was carried out.
fn asks(tester: &mut Tester, sa: u8, service: Service, count: FrameCount) -> Course<Request> {
    let request = Request::of(tester.slave(), sa, service, count, &[]);
    let answer = tester.must_answer(&request)?;
    let cfg = tester.cfg.clone();
    let fits = match (&answer, service) {
        (Answer::Data(_, octets), Service::GetCfg) => *octets == cfg,
        (Answer::Data(_, octets), _) => octets.len() >= 6 && *octets != cfg,
        (Answer::Silence | Answer::Acknowledged | Answer::Status(_) | Answer::Wrong(_), _) => false,
    };
    if fits {
        Ok(request)
    } else {
        broken(format!(
            "{} with FC {:02X} is answered with {} that are not its answer",
            service.name(),
            crate::profibus::fdl::FunctionCode::request(request.service, count).octet(),
            answer.words()
        ))
    }
}

fn c01(tester: &mut Tester) -> Course {
    // Of a master that it has not heard before.
    let other = tester.other();
    asks(tester, other, Service::SlaveDiag, FrameCount::First).map(|_| ())
}

fn c02(tester: &mut Tester) -> Course {
    let owner = tester.owner();
    asks(tester, owner, Service::SlaveDiag, FrameCount::First)?;
    for _ in 0..4 {
        asks(tester, owner, Service::GetCfg, FrameCount::Even)?;
        asks(tester, owner, Service::SlaveDiag, FrameCount::Odd)?;
    }
    Ok(())
}

/// Sends a request once more, and says whether the answer is the same.
fn again(tester: &mut Tester, request: &Request, first: &Answer) -> Course {
    let answer = tester.must_answer(request)?;
    if answer == *first {
        return Ok(());
    }
    broken(format!(
        "{} is answered with {}, and its retry with {}",
        request.name(),
        first.words(),
        answer.words()
    ))
}

fn c03(tester: &mut Tester) -> Course {
    tester.start()?;
    for _ in 0..3 {
        let zeros = tester.zeros();
        let request = tester.request(tester.owner(), Service::DataExchange, &zeros);
        for _ in 0..3 {
            // The inputs may be newer: controllers of slaves send what is newest.
            let answer = tester.must_answer(&request)?;
            tester.inputs_of(answer)?;
        }
    }
    Ok(())
}

fn c04(tester: &mut Tester) -> Course {
    for _ in 0..2 {
        let request = tester.request(tester.owner(), Service::SlaveDiag, &[]);
        let first = tester.must_answer(&request)?;
        again(tester, &request, &first)?;
        again(tester, &request, &first)?;
    }
    if !tester.is_attended() {
        return Ok(());
    }
    // An event that is told once.
    tester.start()?;
    tester.raise_diagnosis()?;
    let request = tester.request(tester.owner(), Service::SlaveDiag, &[]);
    let first = tester.must_answer(&request)?;
    again(tester, &request, &first)?;
    tester.drop_diagnosis()
}

fn c05(tester: &mut Tester) -> Course {
    let prm = tester.prm().octets();
    let cfg = tester.cfg.clone();
    for (service, data) in [(Service::SetPrm, prm), (Service::ChkCfg, cfg)] {
        let request = tester.request(tester.owner(), service, &data);
        let first = tester.must_answer(&request)?;
        again(tester, &request, &first)?;
    }
    tester.ready()?;
    tester.still_exchanges("retries of Set_Prm and Chk_Cfg")
}

fn c06(tester: &mut Tester) -> Course {
    let (owner, other) = (tester.owner(), tester.other());
    asks(tester, owner, Service::SlaveDiag, FrameCount::First)?;
    asks(tester, owner, Service::SlaveDiag, FrameCount::Even)?;
    asks(tester, other, Service::GetCfg, FrameCount::Even)?;
    asks(tester, owner, Service::SlaveDiag, FrameCount::Even)?;
    Ok(())
}

fn c07(tester: &mut Tester) -> Course {
    let owner = tester.owner();
    for service in [Service::SlaveDiag, Service::GetCfg, Service::SlaveDiag] {
        asks(tester, owner, service, FrameCount::First)?;
    }
    Ok(())
}

fn c08(tester: &mut Tester) -> Course {
    let owner = tester.owner();
    asks(tester, owner, Service::SlaveDiag, FrameCount::First)?;
    asks(tester, owner, Service::SlaveDiag, FrameCount::Even)?;
    asks(tester, owner, Service::GetCfg, FrameCount::Even).map(|_| ())
}

fn c09(tester: &mut Tester) -> Course {
    for count in [FrameCount::Even, FrameCount::Odd] {
        tester.power_cycle()?;
        let owner = tester.owner();
        asks(tester, owner, Service::SlaveDiag, count)?;
    }
    Ok(())
}

fn c10(tester: &mut Tester) -> Course {
    let owner = tester.owner();
    asks(tester, owner, Service::SlaveDiag, FrameCount::First)?;
    let request = asks(tester, owner, Service::SlaveDiag, FrameCount::Even)?;
    let status = Request::status(tester.slave(), owner);
    if !tester.must_answer(&status)?.is_status(ReplyStatus::Ok) {
        return broken("FDL status is not answered with OK");
    }
    let answer = tester.must_answer(&request)?;
    if matches!(answer, Answer::Data(..)) {
        return Ok(());
    }
    broken(format!("the retry is answered with {}", answer.words()))
}
