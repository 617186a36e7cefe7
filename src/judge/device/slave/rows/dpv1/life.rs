//! When MS1 opens and ends.

use super::channel::is_of_read;
use super::{configuration, expected, likely, open, row, watchdog};
use crate::judge::device::course::{Course, broken};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Bench;
use crate::judge::device::slave::answer::Answer;
use crate::judge::device::slave::bench::{CLEAR, Channel, Prm};
use crate::profibus::dp::Service;
use crate::profibus::fdl::{Address, ReplyStatus};

pub(super) const GROUP: Group<Bench> = Group {
    title: "DP-V1: life of MS1",
    rows: &[
        row(
            "V1-R34",
            "Unlock while a job runs: RS at SAP 51, and behind a new start there is no old response",
            "leaving data exchange drops job and response; nothing of it comes back (dp-v1 3.2)",
            &["V1-R01", "V1-R06", "V1-R08", "S-P04"],
            By::Trial(r34),
        ),
        row(
            "V1-R35",
            "the watchdog expires: RS at SAP 51",
            "leaving data exchange closes the SAPs (dp-v1 3.2)",
            &["V1-R01", "V1-R06", "S-W01"],
            By::Trial(r35),
        ),
        row(
            "V1-R36",
            "a wrong Set_Prm or Chk_Cfg in data exchange: RS at SAP 51",
            "leaving data exchange closes the SAPs (dp-v1 3.2)",
            &["V1-R01", "V1-R06", "S-P02", "S-G05"],
            By::Trial(r36),
        ),
        open(row(
            "V1-R37",
            "a good Set_Prm and Chk_Cfg in data exchange: no old response, and a new Read works",
            "the channel starts anew: the job is dropped (dp-v1 3.2)",
            &["V1-R06", "V1-R08"],
            By::Trial(r37),
        )),
        likely(row(
            "V1-R38",
            "Clear: a Read works",
            "Clear, Sync and Freeze have no effect on MS1 (dp-v1 3.2)",
            &["V1-R06"],
            By::Trial(r38),
        )),
        open(row(
            "V1-R39",
            "Read in WAIT-CFG: RS or SC",
            "MS1 in WAIT-CFG: open or not (dp-v1 12 O-02)",
            &["V1-R02"],
            By::Trial(r39),
        )),
        expected(row(
            "V1-R40",
            "another master starts it: that one is served, the one before gets RS",
            "the owner is served (dp-v1 1, 3.2)",
            &["V1-R06", "V1-R34", "S-P09"],
            By::Trial(r40),
        )),
    ],
};

fn r34(bench: &mut Bench) -> Course {
    let channel = bench.open()?;
    bench.taken(channel, &Bench::probe(), "a Read at SAP 51")?;
    let unlock = Prm::unlock(bench.ident, bench.setup.user_prm());
    bench.set_prm(&unlock)?;
    bench.closed(channel, &[], "a poll at SAP 51 behind Unlock")?;
    bench.open()?;
    bench.taken(channel, &[], "the first poll behind a new start")
}

fn r35(bench: &mut Bench) -> Course {
    let channel = bench.has_ms1()?;
    let prm = bench.prm_v1().watched([10, 1]);
    bench.begin_with(&prm)?;
    bench.carried_out(channel, &Bench::probe())?;
    bench.exchanged_zeros()?;
    let time = watchdog::over(bench, prm.watchdog());
    bench.pause(time)?;
    bench.closed(channel, &Bench::probe(), "a Read at SAP 51 behind the watchdog time")
}

fn r36(bench: &mut Bench) -> Course {
    let channel = bench.open()?;
    let wrong = Prm { ident: !bench.ident, ..bench.prm_v1() };
    bench.set_prm(&wrong)?;
    bench.closed(channel, &Bench::probe(), "a Read at SAP 51 behind a wrong Set_Prm")?;
    if let Some((_, cfg)) = configuration::wrong_ones(bench).into_iter().next() {
        bench.open()?;
        bench.acknowledged(Service::ChkCfg, &cfg)?;
        bench.closed(channel, &Bench::probe(), "a Read at SAP 51 behind a wrong Chk_Cfg")?;
    }
    Ok(())
}

fn r37(bench: &mut Bench) -> Course {
    let channel = bench.open()?;
    bench.taken(channel, &Bench::probe(), "a Read at SAP 51")?;
    let prm = bench.prm_v1();
    bench.set_prm(&prm)?;
    bench.chk_cfg()?;
    bench.ready()?;
    bench.exchanged_zeros()?;
    if let Answer::Data(_, octets) = bench.put(channel, &[])? {
        let octets = crate::explain::hex(&octets);
        return broken(format!("the response to a Read of before comes behind the new Set_Prm: {octets}"));
    }
    let octets = bench.carried_out(channel, &Bench::probe())?;
    is_of_read(&octets)
}

fn r38(bench: &mut Bench) -> Course {
    let channel = bench.open()?;
    bench.control(CLEAR, 0)?;
    let octets = bench.carried_out(channel, &Bench::probe())?;
    bench.control(0, 0)?;
    is_of_read(&octets)
}

fn r39(bench: &mut Bench) -> Course {
    let channel = bench.has_ms1()?;
    let prm = bench.prm_v1();
    bench.set_prm(&prm)?;
    let answer = bench.put(channel, &Bench::probe())?;
    if answer == Answer::Acknowledged || answer.is_status(ReplyStatus::NotActivated) {
        return Ok(());
    }
    broken(format!("a Read in WAIT-CFG is answered with {}, expected RS or SC", answer.words()))
}

fn r40(bench: &mut Bench) -> Course {
    bench.open()?;
    let unlock = Prm::unlock(bench.ident, bench.setup.user_prm());
    bench.set_prm(&unlock)?;
    let (first, second) = (bench.owner(), bench.other());
    bench.setup.owner = Address::from_octet(second);
    let course = is_of(bench, first);
    let released = bench.release();
    bench.setup.owner = Address::from_octet(first);
    course.and(released)
}

/// The new owner is served, the old one not.
fn is_of(bench: &mut Bench, before: u8) -> Course {
    let channel = bench.open()?;
    let octets = bench.carried_out(channel, &Bench::probe())?;
    is_of_read(&octets)?;
    let old = Channel::ms1(before);
    bench.closed(old, &Bench::probe(), &format!("a Read of master {before}, which owned it before"))
}
