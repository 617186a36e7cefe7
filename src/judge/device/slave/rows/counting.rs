//! The frame count bit: what is a retry, and what is not.

use super::{row, softer};
use crate::judge::device::course::{Course, broken};
use crate::judge::device::row::{By, Entry, Group};
use crate::judge::device::slave::Bench;
use crate::judge::device::slave::answer::Answer;
use crate::judge::device::slave::request::Request;
use crate::judge::requirement::Confidence::{A, B, U};
use crate::profibus::dp::Service;
use crate::profibus::fdl::{FrameCount, ReplyStatus};

pub(super) const GROUP: Group<Bench> = Group {
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
const fn sure(entry: Entry<Bench>) -> Entry<Bench> {
    softer(entry, 1, A)
}

/// Slave_Diag and Get_Cfg in turn: whose answer is whose shows which request was carried out.
fn asks(bench: &mut Bench, sa: u8, service: Service, count: FrameCount) -> Course<Request> {
    let request = Request::of(bench.slave(), sa, service, count, &[]);
    let answer = bench.must_answer(&request)?;
    let cfg = bench.cfg.clone();
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

fn c01(bench: &mut Bench) -> Course {
    // Of a master that it has not heard before.
    let other = bench.other();
    asks(bench, other, Service::SlaveDiag, FrameCount::First).map(|_| ())
}

fn c02(bench: &mut Bench) -> Course {
    let owner = bench.owner();
    asks(bench, owner, Service::SlaveDiag, FrameCount::First)?;
    for _ in 0..4 {
        asks(bench, owner, Service::GetCfg, FrameCount::Even)?;
        asks(bench, owner, Service::SlaveDiag, FrameCount::Odd)?;
    }
    Ok(())
}

/// Sends a request once more, and says whether the answer is the same.
fn again(bench: &mut Bench, request: &Request, first: &Answer) -> Course {
    let answer = bench.must_answer(request)?;
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

fn c03(bench: &mut Bench) -> Course {
    bench.start()?;
    for _ in 0..3 {
        let zeros = bench.zeros();
        let request = bench.request(bench.owner(), Service::DataExchange, &zeros);
        for _ in 0..3 {
            // The inputs may be newer: controllers of slaves send what is newest.
            let answer = bench.must_answer(&request)?;
            bench.inputs_of(answer)?;
        }
    }
    Ok(())
}

fn c04(bench: &mut Bench) -> Course {
    for _ in 0..2 {
        let request = bench.request(bench.owner(), Service::SlaveDiag, &[]);
        let first = bench.must_answer(&request)?;
        again(bench, &request, &first)?;
        again(bench, &request, &first)?;
    }
    if !bench.is_attended() {
        return Ok(());
    }
    // An event that is told once.
    bench.start()?;
    bench.raise_diagnosis()?;
    let request = bench.request(bench.owner(), Service::SlaveDiag, &[]);
    let first = bench.must_answer(&request)?;
    again(bench, &request, &first)?;
    bench.drop_diagnosis()
}

fn c05(bench: &mut Bench) -> Course {
    let prm = bench.prm().octets();
    let cfg = bench.cfg.clone();
    for (service, data) in [(Service::SetPrm, prm), (Service::ChkCfg, cfg)] {
        let request = bench.request(bench.owner(), service, &data);
        let first = bench.must_answer(&request)?;
        again(bench, &request, &first)?;
    }
    bench.ready()?;
    bench.still_exchanges("retries of Set_Prm and Chk_Cfg")
}

fn c06(bench: &mut Bench) -> Course {
    let (owner, other) = (bench.owner(), bench.other());
    asks(bench, owner, Service::SlaveDiag, FrameCount::First)?;
    asks(bench, owner, Service::SlaveDiag, FrameCount::Even)?;
    asks(bench, other, Service::GetCfg, FrameCount::Even)?;
    asks(bench, owner, Service::SlaveDiag, FrameCount::Even)?;
    Ok(())
}

fn c07(bench: &mut Bench) -> Course {
    let owner = bench.owner();
    for service in [Service::SlaveDiag, Service::GetCfg, Service::SlaveDiag] {
        asks(bench, owner, service, FrameCount::First)?;
    }
    Ok(())
}

fn c08(bench: &mut Bench) -> Course {
    let owner = bench.owner();
    asks(bench, owner, Service::SlaveDiag, FrameCount::First)?;
    asks(bench, owner, Service::SlaveDiag, FrameCount::Even)?;
    asks(bench, owner, Service::GetCfg, FrameCount::Even).map(|_| ())
}

fn c09(bench: &mut Bench) -> Course {
    for count in [FrameCount::Even, FrameCount::Odd] {
        bench.power_cycle()?;
        let owner = bench.owner();
        asks(bench, owner, Service::SlaveDiag, count)?;
    }
    Ok(())
}

fn c10(bench: &mut Bench) -> Course {
    let owner = bench.owner();
    asks(bench, owner, Service::SlaveDiag, FrameCount::First)?;
    let request = asks(bench, owner, Service::SlaveDiag, FrameCount::Even)?;
    let status = Request::status(bench.slave(), owner);
    if !bench.must_answer(&status)?.is_status(ReplyStatus::Ok) {
        return broken("FDL status is not answered with OK");
    }
    let answer = bench.must_answer(&request)?;
    if matches!(answer, Answer::Data(..)) {
        return Ok(());
    }
    broken(format!("the retry is answered with {}", answer.words()))
}
