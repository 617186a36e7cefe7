//! Set_Prm, Chk_Cfg and the first Data_Exchange: what nearly every other row needs.

use super::row;
use crate::judge::device::course::{Course, broken, missed};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::profibus::dp::DiagBit;

pub(super) const GROUP: Group<Tester> = Group {
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

fn p01(tester: &mut Tester) -> Course {
    tester.leads_to_exchange(parameterised)
}

fn g01(tester: &mut Tester) -> Course {
    tester.leads_to_exchange(configured)
}

fn x01(tester: &mut Tester) -> Course {
    tester.leads_to_exchange(exchanged)
}

fn parameterised(tester: &mut Tester) -> Course {
    let prm = tester.prm().watched([100, 10]);
    tester.set_prm(&prm)?;
    let diagnosis = tester.diag()?;
    let has_prm = tester.setup.gsd.is_some() || tester.setup.prm.is_some();
    if diagnosis.is(DiagBit::PrmFault) && !has_prm && diagnosis.ident() == tester.ident {
        return missed("it accepts no Set_Prm without user parameters; give them with gsd= or prm=");
    }
    let wrong = [DiagBit::PrmReq, DiagBit::PrmFault, DiagBit::NotSupported];
    if wrong.iter().any(|bit| diagnosis.is(*bit)) {
        return broken(format!("the diagnosis says {}", diagnosis.words()));
    }
    if !diagnosis.is(DiagBit::WdOn) {
        return broken("WD_On of the diagnosis is 0 after a Set_Prm with watchdog");
    }
    if diagnosis.master() != tester.owner() {
        return broken(format!("Master_Add is {}, expected {}", diagnosis.master(), tester.owner()));
    }
    Ok(())
}

fn configured(tester: &mut Tester) -> Course {
    let prm = tester.prm();
    tester.set_prm(&prm)?;
    tester.chk_cfg()?;
    tester.ready().map(|_| ())
}

fn exchanged(tester: &mut Tester) -> Course {
    let prm = tester.prm();
    tester.start_with(&prm)?;
    tester.exchanged_zeros().map(|_| ())
}
