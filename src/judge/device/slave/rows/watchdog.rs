//! The watchdog, and a master that goes and comes back.

use super::{row, softer};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Bench;
use crate::judge::device::slave::answer::NO_MASTER;
use crate::judge::device::slave::bench::Prm;
use crate::judge::device::slave::request::Request;
use crate::judge::device::slave::wire::Sight;
use crate::judge::requirement::Confidence::B;
use crate::profibus::dp::{DiagBit, Service};
use crate::profibus::fdl::FrameCount;
use core::time::Duration;

pub(super) const GROUP: Group<Bench> = Group {
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
fn with_watchdog(bench: &mut Bench, factors: [u8; 2]) -> Course<Duration> {
    let prm = bench.prm().watched(factors);
    bench.begin_with(&prm)?;
    Ok(prm.watchdog())
}

/// The diagnosis of a slave that its master has left.
fn has_left(bench: &mut Bench, after: &str) -> Course {
    let diagnosis = bench.waits_for_prm(after)?;
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
pub(super) fn over(bench: &Bench, watchdog: Duration) -> Duration {
    let margin = match bench.wire.sight {
        Sight::Exact => Duration::from_millis(1),
        Sight::Measured | Sight::Untimed => Duration::from_millis(50),
    };
    watchdog + watchdog / 5 + margin
}

fn w01(bench: &mut Bench) -> Course {
    let watchdog = with_watchdog(bench, FACTORS)?;
    let sees_outputs = bench.lengths.outputs > 0 && bench.setup.moves_allowed;
    let pattern = bench.pattern(0x55);
    if sees_outputs {
        bench.exchanged(&pattern)?;
    }
    bench.pause(over(bench, watchdog))?;
    has_left(bench, "the watchdog time")?;
    if sees_outputs {
        let prm = bench.prm();
        bench.set_prm(&prm)?;
        bench.chk_cfg()?;
        bench.ready()?;
        let zeros = bench.zeros();
        match bench.outputs_are(&zeros, "after the watchdog has expired and a new start-up") {
            // Whoever cannot show his outputs is not accused.
            Err(crate::judge::device::course::Halt::Missed(_)) => {}
            course => course?,
        }
        bench.exchanged(&zeros)?;
    }
    Ok(())
}

fn w02(bench: &mut Bench) -> Course {
    bench.start()?;
    let pattern = bench.pattern(0x55);
    let sees_outputs = bench.lengths.outputs > 0 && bench.setup.moves_allowed;
    if sees_outputs {
        bench.exchanged(&pattern)?;
    }
    let time = if bench.setup.quick { 300 } else { 1500 };
    bench.pause(Duration::from_millis(time))?;
    if sees_outputs {
        match bench.outputs_are(&pattern, "after a pause without watchdog") {
            Err(crate::judge::device::course::Halt::Missed(_)) => {}
            course => course?,
        }
    }
    bench.still_exchanges("a pause without watchdog")
}

fn w03(bench: &mut Bench) -> Course {
    let watchdog = with_watchdog(bench, FACTORS)?;
    let (slave, other, owner, nobody) = (bench.slave(), bench.other(), bench.owner(), bench.setup.nobody());
    let begun = bench.wire.now();
    let until = begun.saturating_add(over(bench, watchdog));
    while bench.wire.now() < until {
        bench.diag_of(other)?;
        for request in [
            Request::status(nobody, owner),
            Request::of(nobody, owner, Service::SlaveDiag, FrameCount::First, &[]),
            Request::of(slave, nobody, Service::GetCfg, FrameCount::First, &[]),
        ] {
            if request.da == slave {
                bench.must_answer(&request)?;
            } else {
                let side = crate::judge::moment::Side::Master;
                bench.wire.send(&request.octets(), side)?;
                bench.wire.pass(bench.wire.now().saturating_add(Duration::from_millis(3)))?;
            }
        }
    }
    let diagnosis = bench.diag_of(other)?;
    if diagnosis.is(DiagBit::PrmReq) {
        return Ok(());
    }
    broken(format!(
        "its master is silent for {} ms with a watchdog of {} ms, and the diagnosis says {}",
        bench.wire.now().saturating_since(begun).as_millis(),
        watchdog.as_millis(),
        diagnosis.words()
    ))
}

fn w04(bench: &mut Bench) -> Course {
    let pairs: &[[u8; 2]] = match (bench.wire.sight, bench.setup.quick) {
        (Sight::Exact, false) => &[[1, 1], [1, 255], [255, 1], [255, 255], [7, 9]],
        (Sight::Exact | Sight::Measured | Sight::Untimed, true) => &[[1, 20]],
        (Sight::Measured | Sight::Untimed, false) => &[[1, 20], [20, 1], [7, 9]],
    };
    for factors in pairs {
        let watchdog = with_watchdog(bench, *factors)?;
        let words = format!("{} times {}", factors[0], factors[1]);
        bench.exchanged_zeros()?;
        bench.pause(watchdog * 4 / 5)?;
        bench.still_exchanges(&format!("four fifths of a watchdog of {words}"))?;
        bench.pause(over(bench, watchdog))?;
        bench.waits_for_prm(&format!("a watchdog of {words}"))?;
    }
    Ok(())
}

fn w05(bench: &mut Bench) -> Course {
    if !bench.is_attended() {
        return inapplicable("needs --ask: power-cycle");
    }
    bench.start()?;
    bench.power_cycle()?;
    bench.waits_for_prm("a power cycle")?;
    bench.must_start()
}

fn w06(bench: &mut Bench) -> Course {
    let watchdog = with_watchdog(bench, FACTORS)?;
    for _ in 0..3 {
        bench.pause(watchdog / 2)?;
        bench.still_exchanges("half of the watchdog time")?;
    }
    bench.pause(watchdog * 2)?;
    bench.waits_for_prm("twice the watchdog time")?;
    bench.must_start()
}

fn w07(bench: &mut Bench) -> Course {
    bench.start()?;
    let (owner, other, prm) = (bench.owner(), bench.other(), bench.prm());
    bench.pause(Duration::from_millis(300))?;
    bench.serve(other, Service::SetPrm, &prm.octets())?;
    let diagnosis = bench.diag_of(other)?;
    if diagnosis.master() != owner {
        return broken(format!("master {other} takes it from a silent master: {}", diagnosis.words()));
    }
    bench.still_exchanges("a Set_Prm of another master after a pause")?;
    let unlock = Prm::unlock(bench.ident, bench.setup.user_prm());
    bench.set_prm(&unlock)?;
    bench.serve(other, Service::SetPrm, &prm.octets())?;
    let diagnosis = bench.diag_of(other)?;
    if diagnosis.master() == other {
        return Ok(());
    }
    broken(format!("master {other} does not get it after Unlock: {}", diagnosis.words()))
}
