//! Set_Prm: what is accepted, what is refused, who may.

use super::{row, softer};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::answer::{Answer, NO_MASTER};
use crate::judge::device::slave::tester::{FREEZE, LOCK, Prm, SYNC, UNLOCK};
use crate::judge::device::slave::wire::Sight;
use crate::judge::requirement::Confidence::{A, B, U};
use crate::profibus::dp::{DiagBit, Service};
use core::time::Duration;

pub(super) const GROUP: Group<Tester> = Group {
    title: "Set_Prm",
    rows: &[
        row(
            "S-P02",
            "a wrong ident number: SC, then Prm_Fault, Prm_Req and no master, also in data exchange",
            "ident wrong: Prm_Fault = 1, to WAIT-PRM; the reply is SC in all cases (5.2 step 5)",
            &["S-X01", "S-D01"],
            By::Trial(p02),
        ),
        row(
            "S-P03",
            "a wrong length: SC, then Prm_Fault",
            "fewer than 7 octets, or user parameters of a wrong length: Prm_Fault = 1 (5.2 steps 1 and 9)",
            &["S-P02"],
            By::Trial(p03),
        ),
        softer(
            row(
                "S-P04",
                "Unlock releases the slave, with and without Lock; neither bit leaves it as it is",
                "01 and 11: released, unlock wins; 00: only min T_SDR may change (5.2)",
                &["S-X01", "S-D01"],
                By::Trial(p04),
            ),
            1,
            A,
        ),
        softer(
            row(
                "S-P05",
                "neither Lock nor Unlock, another ident number: data exchange goes on",
                "00 is carried out even when the ident number does not match, and changes min T_SDR only (5.2)",
                &["S-P04"],
                By::Trial(p05),
            ),
            1,
            A,
        ),
        row(
            "S-P06",
            "min T_SDR 0: the one before is kept",
            "octet 4: 0 = leave as it is (5.1)",
            &["S-P07"],
            By::Trial(p06),
        ),
        softer(
            row(
                "S-P07",
                "min T_SDR up to max T_SDR: no reply comes earlier",
                "the slave starts its reply at or after min T_SDR (1.1)",
                &["S-X01"],
                By::Trial(p07),
            ),
            2,
            B,
        ),
        row(
            "S-P08",
            "Set_Prm of another master while it is locked: nothing changes for its master",
            "locked by a different master: no effect on state or parameters (5.2 step 2)",
            &["S-X01"],
            By::Trial(p08),
        ),
        row(
            "S-P09",
            "another master is accepted after Unlock",
            "after unlock the new Set_Prm of any master is taken (5.2)",
            &["S-P04"],
            By::Trial(p09),
        ),
        row(
            "S-P10",
            "the same Set_Prm twice, in data exchange too: no fault",
            "valid content again from the owner must raise no diagnosis (5.2)",
            &["S-X01"],
            By::Trial(p10),
        ),
        row(
            "S-P11",
            "Set_Prm of two masters one right after the other: the first keeps it, without fault",
            "two masters in quick succession must leave a sane slave, the first owner stays (5.2)",
            &["S-P08"],
            By::Trial(p11),
        ),
        softer(
            row(
                "S-P12",
                "Sync_Req or Freeze_Req to a slave that has neither: Not_Supported",
                "Sync_Req or Freeze_Req but unsupported: Not_Supported = 1 (5.2 step 7)",
                &["S-P01"],
                By::Trial(p12),
            ),
            2,
            B,
        ),
        softer(
            row(
                "S-P13",
                "reserved bits of Station_Status: Prm_Fault",
                "bits 2 to 0 must be 0; controllers of slaves check it unless told not to (5.1)",
                &["S-P02"],
                By::Trial(p13),
            ),
            2,
            U,
        ),
        softer(
            row(
                "S-P14",
                "watchdog on with a factor of zero: Prm_Fault",
                "WD_On and a factor of 0: parameter fault (5.1)",
                &["S-P02"],
                By::Trial(p14),
            ),
            2,
            U,
        ),
        row(
            "S-P15",
            "a good Set_Prm after a wrong one clears Prm_Fault",
            "all good: Prm_Req = 0, Prm_Fault = 0 (5.2 step 10)",
            &["S-P02"],
            By::Trial(p15),
        ),
        row(
            "S-P16",
            "Group_Ident is taken over with Lock only",
            "octet 7 is taken over only when Lock_Req is set (5.1)",
            &["S-S05", "S-P04"],
            By::Trial(p16),
        ),
        softer(
            row(
                "S-P17",
                "WD_Base of DPV1_Status: the watchdog counts in milliseconds",
                "with WD_Base = 1 the unit of the watchdog is 1 ms (5.1)",
                &["S-W01"],
                By::Trial(p17),
            ),
            2,
            B,
        ),
    ],
};

/// Set_Prm leads to Prm_Fault, and the slave waits for another one.
pub(super) fn is_fault(tester: &mut Tester, what: &str) -> Course {
    let diagnosis = tester.waits_for_prm(what)?;
    if !diagnosis.is(DiagBit::PrmFault) {
        return broken(format!("Prm_Fault is 0 after {what}: {}", diagnosis.words()));
    }
    if diagnosis.master() != NO_MASTER {
        return broken(format!("Master_Add is {} after {what}, expected 255", diagnosis.master()));
    }
    Ok(())
}

fn p02(tester: &mut Tester) -> Course {
    let wrong = Prm { ident: !tester.ident, ..tester.prm() };
    tester.set_prm(&wrong)?;
    is_fault(tester, "a Set_Prm with another ident number")?;
    tester.must_start()?;
    tester.set_prm(&wrong)?;
    is_fault(tester, "a Set_Prm with another ident number in data exchange")
}

fn p03(tester: &mut Tester) -> Course {
    let right = tester.prm().octets();
    let short = right.get(..6).unwrap_or_default().to_vec();
    tester.acknowledged(Service::SetPrm, &short)?;
    is_fault(tester, "a Set_Prm of 6 octets")?;
    let Some(gsd) = tester.setup.gsd.clone() else { return Ok(()) };
    let (least, most) = gsd.user_prm_lengths();
    if least > 0 && !tester.setup.user_prm().is_empty() {
        let octets = right.get(..7 + usize::from(least) - 1).unwrap_or_default().to_vec();
        tester.acknowledged(Service::SetPrm, &octets)?;
        is_fault(tester, &format!("a Set_Prm with {} octets of user parameters", least - 1))?;
    }
    // Many files that have no parameters are of slaves that take any.
    if most > 0 && most < 237 {
        let mut octets = right;
        octets.resize(7 + usize::from(most) + 1, 0);
        tester.acknowledged(Service::SetPrm, &octets)?;
        is_fault(tester, &format!("a Set_Prm with {} octets of user parameters", most + 1))?;
    }
    Ok(())
}

fn p04(tester: &mut Tester) -> Course {
    tester.start()?;
    let (ident, user) = (tester.ident, tester.setup.user_prm());
    let none = Prm { status: 0, ..Prm::lock(ident, user.clone()) };
    tester.set_prm(&none)?;
    tester.still_exchanges("a Set_Prm with neither Lock nor Unlock")?;
    for bits in [UNLOCK, LOCK | UNLOCK] {
        let prm = Prm { status: bits, ..Prm::unlock(ident, user.clone()) };
        tester.set_prm(&prm)?;
        let diagnosis = tester.waits_for_prm(&format!("a Set_Prm with Station_Status {bits:02X}"))?;
        if diagnosis.master() != NO_MASTER {
            return broken(format!("Master_Add is {} after Unlock, expected 255", diagnosis.master()));
        }
        if bits == UNLOCK {
            tester.must_start()?;
        }
    }
    Ok(())
}

fn p05(tester: &mut Tester) -> Course {
    tester.start()?;
    let prm = Prm { status: 0, ident: !tester.ident, user: Vec::new(), ..tester.prm() };
    tester.set_prm(&prm)?;
    tester.still_exchanges("a Set_Prm with neither Lock nor Unlock and another ident number")?;
    let diagnosis = tester.diag()?;
    if diagnosis.is(DiagBit::PrmFault) || diagnosis.master() != tester.owner() {
        return broken(format!("the diagnosis says {}", diagnosis.words()));
    }
    Ok(())
}

/// Whether times are seen well enough to tell one min T_SDR from another.
fn sees_tsdr(tester: &Tester) -> Course {
    if tester.wire.sight == Sight::Untimed {
        return inapplicable("needs a real line or virtual time: no bit times are seen on this link");
    }
    Ok(())
}

/// No reply begins earlier than so many bit times after the request.
fn not_before(tester: &mut Tester, bits: u16, what: &str) -> Course {
    let least = tester.wire.baud.bit_times(bits.into());
    let zeros = tester.zeros();
    for _ in 0..3 {
        let request = tester.request(tester.owner(), Service::DataExchange, &zeros);
        let heard = tester.exchange_octets(request.sa, &request.octets())?;
        let Some(heard) = heard else { return tester.silent("Data_Exchange") };
        if heard.after < least {
            return broken(format!(
                "{what}, a reply begins {} us after its request, expected {} us or more",
                heard.after.as_micros(),
                least.as_micros()
            ));
        }
    }
    Ok(())
}

/// A min T_SDR that this slave can be given.
fn high_tsdr(tester: &Tester) -> u8 {
    let max = tester.wire.baud.max_tsdr_bits();
    let of_file = tester.setup.gsd.as_ref().and_then(|gsd| gsd.rates.max_tsdr(tester.wire.baud));
    u8::try_from(of_file.unwrap_or(max).max(12)).unwrap_or(u8::MAX)
}

fn p06(tester: &mut Tester) -> Course {
    sees_tsdr(tester)?;
    let high = high_tsdr(tester);
    let prm = Prm { min_tsdr: high, ..tester.prm() };
    tester.begin_with(&prm)?;
    let prm = Prm { min_tsdr: 0, ..tester.prm() };
    tester.set_prm(&prm)?;
    tester.chk_cfg()?;
    tester.ready()?;
    not_before(tester, high.into(), &format!("with min T_SDR {high}, then 0"))?;
    let prm = tester.prm();
    tester.set_prm(&prm)
}

fn p07(tester: &mut Tester) -> Course {
    sees_tsdr(tester)?;
    let high = high_tsdr(tester);
    for bits in [11, high.midpoint(11), high] {
        let prm = Prm { min_tsdr: bits, ..tester.prm() };
        tester.begin_with(&prm)?;
        not_before(tester, bits.into(), &format!("with min T_SDR {bits}"))?;
    }
    let prm = tester.prm();
    tester.set_prm(&prm)
}

fn p08(tester: &mut Tester) -> Course {
    tester.start()?;
    let (owner, other) = (tester.owner(), tester.other());
    for prm in [
        tester.prm(),
        Prm::unlock(tester.ident, tester.setup.user_prm()),
        Prm { ident: !tester.ident, ..tester.prm() },
    ] {
        // What it is answered with is open; silence is not.
        tester.serve(other, Service::SetPrm, &prm.octets())?;
        tester.still_exchanges("a Set_Prm of another master")?;
        let diagnosis = tester.diag()?;
        if diagnosis.master() != owner || diagnosis.is(DiagBit::PrmFault) {
            return broken(format!(
                "after a Set_Prm of master {other}, the diagnosis says {}",
                diagnosis.words()
            ));
        }
    }
    Ok(())
}

fn p09(tester: &mut Tester) -> Course {
    tester.start()?;
    let unlock = Prm::unlock(tester.ident, tester.setup.user_prm());
    tester.set_prm(&unlock)?;
    let (other, prm) = (tester.other(), tester.prm());
    let answer = tester.serve(other, Service::SetPrm, &prm.octets())?;
    let diagnosis = tester.diag_of(other)?;
    if answer != Answer::Acknowledged || diagnosis.master() != other || diagnosis.is(DiagBit::PrmReq) {
        return broken(format!(
            "Set_Prm of master {other} is answered with {}, and the diagnosis says {}",
            answer.words(),
            diagnosis.words()
        ));
    }
    Ok(())
}

fn p10(tester: &mut Tester) -> Course {
    let prm = tester.prm();
    tester.set_prm(&prm)?;
    tester.set_prm(&prm)?;
    tester.chk_cfg()?;
    tester.ready()?;
    tester.exchanged_zeros()?;
    tester.set_prm(&prm)?;
    let diagnosis = tester.diag()?;
    let faults = [DiagBit::PrmReq, DiagBit::PrmFault, DiagBit::CfgFault];
    if faults.iter().any(|bit| diagnosis.is(*bit)) {
        return broken(format!("after a second Set_Prm the diagnosis says {}", diagnosis.words()));
    }
    tester.chk_cfg()?;
    tester.ready()?;
    tester.still_exchanges("a second start-up")
}

fn p11(tester: &mut Tester) -> Course {
    let (owner, other, prm) = (tester.owner(), tester.other(), tester.prm());
    tester.set_prm(&prm)?;
    tester.serve(other, Service::SetPrm, &prm.octets())?;
    let diagnosis = tester.diag()?;
    if diagnosis.master() != owner || diagnosis.is(DiagBit::PrmFault) || diagnosis.is(DiagBit::PrmReq) {
        return broken(format!("the diagnosis says {}", diagnosis.words()));
    }
    tester.chk_cfg()?;
    tester.ready()?;
    tester.still_exchanges("Set_Prm of two masters")
}

fn p12(tester: &mut Tester) -> Course {
    let Some(gsd) = tester.setup.gsd.as_ref() else {
        return inapplicable("needs the device file: gsd=");
    };
    let (sync, freeze) = (gsd.flags.sync, gsd.flags.freeze);
    if sync && freeze {
        return inapplicable("the slave has Sync and Freeze");
    }
    for (bit, name, offered) in [(SYNC, "Sync_Req", sync), (FREEZE, "Freeze_Req", freeze)] {
        if offered {
            continue;
        }
        let prm = tester.prm().with(bit);
        tester.set_prm(&prm)?;
        let diagnosis = tester.diag()?;
        if !diagnosis.is(DiagBit::NotSupported) {
            return broken(format!("Not_Supported is 0 after {name}: {}", diagnosis.words()));
        }
        tester.release()?;
    }
    Ok(())
}

fn p13(tester: &mut Tester) -> Course {
    for bit in [0x01, 0x02, 0x04] {
        let prm = tester.prm().with(bit);
        tester.set_prm(&prm)?;
        is_fault(tester, &format!("a Set_Prm with the reserved bit {bit:02X}"))?;
    }
    Ok(())
}

fn p14(tester: &mut Tester) -> Course {
    for factors in [[0, 10], [10, 0]] {
        let prm = tester.prm().watched(factors);
        tester.set_prm(&prm)?;
        is_fault(tester, &format!("a watchdog of {} times {}", factors[0], factors[1]))?;
    }
    Ok(())
}

fn p15(tester: &mut Tester) -> Course {
    let wrong = Prm { ident: !tester.ident, ..tester.prm() };
    tester.set_prm(&wrong)?;
    let right = tester.prm();
    tester.set_prm(&right)?;
    let diagnosis = tester.diag()?;
    if diagnosis.is(DiagBit::PrmFault) || diagnosis.is(DiagBit::PrmReq) {
        return broken(format!("after a good Set_Prm the diagnosis says {}", diagnosis.words()));
    }
    Ok(())
}

fn p16(tester: &mut Tester) -> Course {
    let effect = tester.effect_of_control()?;
    let prm = Prm { groups: 0x01, ..tester.prm().with(effect.request_bits()) };
    tester.begin_with(&prm)?;
    let other = Prm { status: 0, groups: 0x02, ..tester.prm() };
    tester.set_prm(&other)?;
    effect.try_group(tester, 0x02, false, "group 2, set without Lock")?;
    effect.try_group(tester, 0x01, true, "group 1, set with Lock")
}

/// The watchdog in P17: 100 ms where it counts in milliseconds, else a second.
const FACTORS: [u8; 2] = [100, 1];
const WD_BASE: u8 = 0x04;

fn p17(tester: &mut Tester) -> Course {
    let offers = tester.setup.gsd.as_ref().is_some_and(|gsd| gsd.flags.dpv1 && gsd.flags.watchdog_1ms);
    if !offers {
        return inapplicable("the device file has no WD_Base_1ms_supp of DP-V1");
    }
    let mut prm = tester.prm().watched(FACTORS);
    if let Some(status) = prm.user.first_mut() {
        *status |= WD_BASE;
    }
    tester.begin_with(&prm)?;
    tester.pause(Duration::from_millis(250))?;
    tester.waits_for_prm("a pause of 250 ms with a watchdog of 100 ms").map(|_| ())
}
