//! When MS1 opens and ends.

use super::channel::is_of_read;
use super::{configuration, expected, likely, open, row, watchdog};
use crate::judge::device::course::{Course, broken};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::answer::Answer;
use crate::judge::device::slave::tester::{CLEAR, Channel, Prm};
use crate::profibus::dp::Service;
use crate::profibus::fdl::{Address, ReplyStatus};

pub(super) const GROUP: Group<Tester> = Group {
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

fn r34(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    tester.taken(channel, &Tester::probe(), "a Read at SAP 51")?;
    let unlock = Prm::unlock(tester.ident, tester.setup.user_prm());
    tester.set_prm(&unlock)?;
    tester.closed(channel, &[], "a poll at SAP 51 behind Unlock")?;
    tester.open()?;
    tester.taken(channel, &[], "the first poll behind a new start")
}

fn r35(tester: &mut Tester) -> Course {
    let channel = tester.has_ms1()?;
    let prm = tester.prm_v1().watched([10, 1]);
    tester.begin_with(&prm)?;
    tester.carried_out(channel, &Tester::probe())?;
    tester.exchanged_zeros()?;
    let time = watchdog::over(tester, prm.watchdog());
    tester.pause(time)?;
    tester.closed(channel, &Tester::probe(), "a Read at SAP 51 behind the watchdog time")
}

fn r36(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    let wrong = Prm { ident: !tester.ident, ..tester.prm_v1() };
    tester.set_prm(&wrong)?;
    tester.closed(channel, &Tester::probe(), "a Read at SAP 51 behind a wrong Set_Prm")?;
    if let Some((_, cfg)) = configuration::wrong_ones(tester).into_iter().next() {
        tester.open()?;
        tester.acknowledged(Service::ChkCfg, &cfg)?;
        tester.closed(channel, &Tester::probe(), "a Read at SAP 51 behind a wrong Chk_Cfg")?;
    }
    Ok(())
}

fn r37(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    tester.taken(channel, &Tester::probe(), "a Read at SAP 51")?;
    let prm = tester.prm_v1();
    tester.set_prm(&prm)?;
    tester.chk_cfg()?;
    tester.ready()?;
    tester.exchanged_zeros()?;
    if let Answer::Data(_, octets) = tester.put(channel, &[])? {
        let octets = crate::explain::hex(&octets);
        return broken(format!("the response to a Read of before comes behind the new Set_Prm: {octets}"));
    }
    let octets = tester.carried_out(channel, &Tester::probe())?;
    is_of_read(&octets)
}

fn r38(tester: &mut Tester) -> Course {
    let channel = tester.open()?;
    tester.control(CLEAR, 0)?;
    let octets = tester.carried_out(channel, &Tester::probe())?;
    tester.control(0, 0)?;
    is_of_read(&octets)
}

fn r39(tester: &mut Tester) -> Course {
    let channel = tester.has_ms1()?;
    let prm = tester.prm_v1();
    tester.set_prm(&prm)?;
    let answer = tester.put(channel, &Tester::probe())?;
    if answer == Answer::Acknowledged || answer.is_status(ReplyStatus::NotActivated) {
        return Ok(());
    }
    broken(format!("a Read in WAIT-CFG is answered with {}, expected RS or SC", answer.words()))
}

fn r40(tester: &mut Tester) -> Course {
    tester.open()?;
    let unlock = Prm::unlock(tester.ident, tester.setup.user_prm());
    tester.set_prm(&unlock)?;
    let (first, second) = (tester.owner(), tester.other());
    tester.setup.owner = Address::from_octet(second);
    let course = is_of(tester, first);
    let released = tester.release();
    tester.setup.owner = Address::from_octet(first);
    course.and(released)
}

/// The new owner is served, the old one not.
fn is_of(tester: &mut Tester, before: u8) -> Course {
    let channel = tester.open()?;
    let octets = tester.carried_out(channel, &Tester::probe())?;
    is_of_read(&octets)?;
    let old = Channel::ms1(before);
    tester.closed(old, &Tester::probe(), &format!("a Read of master {before}, which owned it before"))
}
