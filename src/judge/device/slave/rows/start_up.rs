//! Set_Prm, Chk_Cfg and the first Data_Exchange: what nearly every other row needs.

use super::row;
use crate::judge::device::course::{Course, broken, missed};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Bench;
use crate::profibus::dp::DiagBit;

pub(super) const GROUP: Group<Bench> = Group {
    title: "Start-up",
    rows: &[
        row(
            "S-P01",
            "Set_Prm with watchdog: SC, then 02 0C and the master in the diagnosis",
            "all good: Master_Add = SA, watchdog on, Prm_Req and Prm_Fault 0, to WAIT-CFG (5.2 step 10)",
            &["S-K01"],
            By::Trial(p01),
        ),
        row(
            "S-G01",
            "Chk_Cfg with its configuration: SC, and the diagnosis says ready",
            "match: to DATA-EXCH, Station_Not_Ready 0 (6.1, 7 row 8)",
            &["S-P01"],
            By::Trial(g01),
        ),
        row(
            "S-X01",
            "Data_Exchange with the right length, low and high priority, gives the inputs",
            "the request has exactly the configured outputs, the reply exactly the configured inputs (6.6)",
            &["S-G01"],
            By::Trial(x01),
        ),
    ],
};

fn p01(bench: &mut Bench) -> Course {
    bench.leads_to_exchange(parameterised)
}

fn g01(bench: &mut Bench) -> Course {
    bench.leads_to_exchange(configured)
}

fn x01(bench: &mut Bench) -> Course {
    bench.leads_to_exchange(exchanged)
}

fn parameterised(bench: &mut Bench) -> Course {
    let prm = bench.prm().watched([100, 10]);
    bench.set_prm(&prm)?;
    let diagnosis = bench.diag()?;
    let has_prm = bench.setup.gsd.is_some() || bench.setup.prm.is_some();
    if diagnosis.is(DiagBit::PrmFault) && !has_prm && diagnosis.ident() == bench.ident {
        return missed("it accepts no Set_Prm without user parameters; give them with gsd= or prm=");
    }
    let wrong = [DiagBit::PrmReq, DiagBit::PrmFault, DiagBit::NotSupported];
    if wrong.iter().any(|bit| diagnosis.is(*bit)) {
        return broken(format!("the diagnosis says {}", diagnosis.words()));
    }
    if !diagnosis.is(DiagBit::WdOn) {
        return broken("WD_On of the diagnosis is 0 after a Set_Prm with watchdog");
    }
    if diagnosis.master() != bench.owner() {
        return broken(format!("Master_Add is {}, expected {}", diagnosis.master(), bench.owner()));
    }
    Ok(())
}

fn configured(bench: &mut Bench) -> Course {
    let prm = bench.prm();
    bench.set_prm(&prm)?;
    bench.chk_cfg()?;
    bench.ready().map(|_| ())
}

fn exchanged(bench: &mut Bench) -> Course {
    let prm = bench.prm();
    bench.start_with(&prm)?;
    bench.exchanged_zeros().map(|_| ())
}
