//! The watchdog, and a master that goes and comes back.

use super::{row, softer};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::answer::NO_MASTER;
use crate::judge::device::slave::request::Request;
use crate::judge::device::slave::tester::Prm;
use crate::judge::device::slave::wire::Sight;
use crate::judge::requirement::Confidence::B;
use crate::profibus::dp::{DiagBit, Service};
use crate::profibus::fdl::FrameCount;
use core::time::Duration;

pub(super) const GROUP: Group<Tester> = Group {
    title: "Watchdog and bus events",
    rows: &[
        row(
            "S-W01",
            "its master stops, watchdog on: it leaves its master, with outputs cleared",
            "expiry: Leave-Master, outputs cleared, to WAIT-PRM (7 row 15, 8)",
            &["S-X01", "S-D01"],
            By::Trial(w01),
        ),
        row(
            "S-W02",
            "its master stops, watchdog off: state and outputs are held, data exchange goes on",
            "without watchdog nothing ends data exchange (7)",
            &["S-X01"],
            By::Trial(w02),
        ),
        row(
            "S-W03",
            "traffic of other masters, and to other slaves, does not feed the watchdog",
            "the watchdog is fed by telegrams of Master_Add, not of others (8)",
            &["S-W01", "S-F02"],
            By::Trial(w03),
        ),
        row(
            "S-W04",
            "the watchdog time is 10 ms times both factors",
            "T_WD = 10 ms * WD_Fact_1 * WD_Fact_2 (5.1)",
            &["S-W01"],
            By::Trial(w04),
        ),
        row(
            "S-W05",
            "a power cycle in data exchange: it waits for Set_Prm, and its master starts it again",
            "power-on: outputs cleared, Prm_Req, to WAIT-PRM (7 row 1)",
            &["S-X01"],
            By::Trial(w05),
        ),
        row(
            "S-W06",
            "the line is away for less than the watchdog: it goes on; for more: it is started again",
            "DX resumes without parameterisation before expiry; after it a new start-up (8)",
            &["S-W04"],
            By::Trial(w06),
        ),
        softer(
            row(
                "S-W07",
                "watchdog off: another master takes it over only after it was released",
                "locked by a different master: no effect, however long that is silent (5.2 step 2)",
                &["S-P08", "S-P09"],
                By::Trial(w07),
            ),
            2,
            B,
        ),
        softer(
            row(
                "S-W08",
                "the rate of the line changes: a slave with Auto_Baud finds it",
                "BAUD_SEARCH: error-free telegrams lead to BAUD_CONTROL (8)",
                &[],
                By::Nothing("S-R01 to S-R11 judge it, at each rate of --baud"),
            ),
            2,
            B,
        ),
        softer(
            row(
                "S-W09",
                "an application that stands still: it leaves its master",
                "the user watchdog leads to Leave-Master (8)",
                &[],
                By::Nothing("an application cannot be stopped from outside"),
            ),
            2,
            B,
        ),
    ],
};

/// The watchdog of most rows: 100 ms.
const FACTORS: [u8; 2] = [10, 1];

/// In data exchange with this watchdog.
fn with_watchdog(tester: &mut Tester, factors: [u8; 2]) -> Course<Duration> {
    let prm = tester.prm().watched(factors);
    tester.begin_with(&prm)?;
    Ok(prm.watchdog())
}

/// The diagnosis of a slave that its master has left.
fn has_left(tester: &mut Tester, after: &str) -> Course {
    let diagnosis = tester.waits_for_prm(after)?;
    let wrong = [DiagBit::WdOn, DiagBit::PrmFault, DiagBit::CfgFault];
    if wrong.iter().any(|bit| diagnosis.is(*bit)) || !diagnosis.is(DiagBit::StationNotReady) {
        return broken(format!("after {after} the diagnosis says {}", diagnosis.words()));
    }
    if diagnosis.master() != NO_MASTER {
        return broken(format!("after {after} Master_Add is {}, expected 255", diagnosis.master()));
    }
    Ok(())
}

/// Longer than a watchdog of this time may take.
pub(super) fn over(tester: &Tester, watchdog: Duration) -> Duration {
    let margin = match tester.wire.sight {
        Sight::Exact => Duration::from_millis(1),
        Sight::Measured | Sight::Untimed => Duration::from_millis(50),
    };
    watchdog + watchdog / 5 + margin
}

fn w01(tester: &mut Tester) -> Course {
    let watchdog = with_watchdog(tester, FACTORS)?;
    let sees_outputs = tester.lengths.outputs > 0 && tester.setup.moves_allowed;
    let pattern = tester.pattern(0x55);
    if sees_outputs {
        tester.exchanged(&pattern)?;
    }
    tester.pause(over(tester, watchdog))?;
    has_left(tester, "the watchdog time")?;
    if sees_outputs {
        let prm = tester.prm();
        tester.set_prm(&prm)?;
        tester.chk_cfg()?;
        tester.ready()?;
        let zeros = tester.zeros();
        match tester.outputs_are(&zeros, "after the watchdog has expired and a new start-up") {
            // Whoever cannot show his outputs is not accused.
            Err(crate::judge::device::course::Halt::Missed(_)) => {}
            course => course?,
        }
        tester.exchanged(&zeros)?;
    }
    Ok(())
}

fn w02(tester: &mut Tester) -> Course {
    tester.start()?;
    let pattern = tester.pattern(0x55);
    let sees_outputs = tester.lengths.outputs > 0 && tester.setup.moves_allowed;
    if sees_outputs {
        tester.exchanged(&pattern)?;
    }
    let time = if tester.setup.quick { 300 } else { 1500 };
    tester.pause(Duration::from_millis(time))?;
    if sees_outputs {
        match tester.outputs_are(&pattern, "after a pause without watchdog") {
            Err(crate::judge::device::course::Halt::Missed(_)) => {}
            course => course?,
        }
    }
    tester.still_exchanges("a pause without watchdog")
}

fn w03(tester: &mut Tester) -> Course {
    let watchdog = with_watchdog(tester, FACTORS)?;
    let (slave, other, owner, nobody) =
        (tester.slave(), tester.other(), tester.owner(), tester.setup.nobody());
    let begun = tester.wire.now();
    let until = begun.saturating_add(over(tester, watchdog));
    while tester.wire.now() < until {
        tester.diag_of(other)?;
        for request in [
            Request::status(nobody, owner),
            Request::of(nobody, owner, Service::SlaveDiag, FrameCount::First, &[]),
            Request::of(slave, nobody, Service::GetCfg, FrameCount::First, &[]),
        ] {
            if request.da == slave {
                tester.must_answer(&request)?;
            } else {
                let side = crate::judge::moment::Side::Master;
                tester.wire.send(&request.octets(), side)?;
                tester.wire.pass(tester.wire.now().saturating_add(Duration::from_millis(3)))?;
            }
        }
    }
    let diagnosis = tester.diag_of(other)?;
    if diagnosis.is(DiagBit::PrmReq) {
        return Ok(());
    }
    broken(format!(
        "its master is silent for {} ms with a watchdog of {} ms, and the diagnosis says {}",
        tester.wire.now().saturating_since(begun).as_millis(),
        watchdog.as_millis(),
        diagnosis.words()
    ))
}

fn w04(tester: &mut Tester) -> Course {
    let pairs: &[[u8; 2]] = match (tester.wire.sight, tester.setup.quick) {
        (Sight::Exact, false) => &[[1, 1], [1, 255], [255, 1], [255, 255], [7, 9]],
        (Sight::Exact | Sight::Measured | Sight::Untimed, true) => &[[1, 20]],
        (Sight::Measured | Sight::Untimed, false) => &[[1, 20], [20, 1], [7, 9]],
    };
    for factors in pairs {
        let watchdog = with_watchdog(tester, *factors)?;
        let words = format!("{} times {}", factors[0], factors[1]);
        tester.exchanged_zeros()?;
        tester.pause(watchdog * 4 / 5)?;
        tester.still_exchanges(&format!("four fifths of a watchdog of {words}"))?;
        tester.pause(over(tester, watchdog))?;
        tester.waits_for_prm(&format!("a watchdog of {words}"))?;
    }
    Ok(())
}

fn w05(tester: &mut Tester) -> Course {
    if !tester.is_attended() {
        return inapplicable("needs --ask: power-cycle");
    }
    tester.start()?;
    tester.power_cycle()?;
    tester.waits_for_prm("a power cycle")?;
    tester.must_start()
}

fn w06(tester: &mut Tester) -> Course {
    let watchdog = with_watchdog(tester, FACTORS)?;
    for _ in 0..3 {
        tester.pause(watchdog / 2)?;
        tester.still_exchanges("half of the watchdog time")?;
    }
    tester.pause(watchdog * 2)?;
    tester.waits_for_prm("twice the watchdog time")?;
    tester.must_start()
}

fn w07(tester: &mut Tester) -> Course {
    tester.start()?;
    let (owner, other, prm) = (tester.owner(), tester.other(), tester.prm());
    tester.pause(Duration::from_millis(300))?;
    tester.serve(other, Service::SetPrm, &prm.octets())?;
    let diagnosis = tester.diag_of(other)?;
    if diagnosis.master() != owner {
        return broken(format!("master {other} takes it from a silent master: {}", diagnosis.words()));
    }
    tester.still_exchanges("a Set_Prm of another master after a pause")?;
    let unlock = Prm::unlock(tester.ident, tester.setup.user_prm());
    tester.set_prm(&unlock)?;
    tester.serve(other, Service::SetPrm, &prm.octets())?;
    let diagnosis = tester.diag_of(other)?;
    if diagnosis.master() == other {
        return Ok(());
    }
    broken(format!("master {other} does not get it after Unlock: {}", diagnosis.words()))
}
