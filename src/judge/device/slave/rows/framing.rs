//! Telegrams and addresses: who is answered, and who is not.

use super::{row, softer};
use crate::judge::device::course::{Course, broken};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::request::{Request, with_wrong_end, with_wrong_fcs};
use crate::judge::device::slave::tester::Prm;
use crate::judge::requirement::Confidence::U;
use crate::profibus::dp::Service;
use crate::profibus::fdl::{Address, FrameCount, ReplyStatus};

pub(super) const GROUP: Group<Tester> = Group {
    title: "Telegrams and addresses",
    rows: &[
        row(
            "S-F01",
            "FDL status is answered in each state: SD1, FC 00, right addresses",
            "a request for FDL status is answered with 10 DA SA 00 FCS 16 in every state, before parameterisation too (3)",
            &["S-X01"],
            By::Trial(f01),
        ),
        row(
            "S-F02",
            "requests to another address are not answered",
            "a station answers what has its own address as DA, and nothing else (2.1)",
            &[],
            By::Trial(f02),
        ),
        row(
            "S-F03",
            "a wrong checksum: silence, and nothing is done",
            "on any error the telegram is dropped; there is no negative answer to a damaged one (1)",
            &["S-X01"],
            By::Trial(f03),
        ),
        row(
            "S-F04",
            "a wrong end delimiter: silence, and nothing is done",
            "ED is 16; on any error the telegram is dropped (1, 2 rule 3)",
            &["S-X01"],
            By::Trial(f04),
        ),
        row(
            "S-F05",
            "LE and LEr differ, LE is 3 or 250, the fourth octet is not 68: silence",
            "LE and LEr are the same, 4 to 249, and the fourth octet is 68 again (2 rules 1 and 3)",
            &["S-X01"],
            By::Trial(f05),
        ),
        row(
            "S-F06",
            "an octet with wrong parity: silence",
            "each octet is checked for start, stop and parity (1)",
            &[],
            By::Nothing("no link of the judge sends an octet with wrong parity"),
        ),
        row(
            "S-F07",
            "a broken telegram, T_SYN, a good one: the good one is answered",
            "T_SYN of idle line begins a request, whatever came before (1)",
            &["S-F01", "S-F03"],
            By::Trial(f07),
        ),
        row(
            "S-F09",
            "single octets 10, 68, A2, DC, E5, then idle line, then a good telegram: it is answered",
            "noise is dropped, and the next request after T_SYN is heard (1)",
            &["S-F07"],
            By::Trial(f09),
        ),
        softer(
            row(
                "S-F18",
                "a request that has the slave's own address, or 127, as SA: no reply",
                "a station does not ask itself, and nobody has address 127 (2.1)",
                &["S-F01"],
                By::Trial(f18),
            ),
            2,
            U,
        ),
    ],
};

/// The status request, answered as it must be.
fn status(tester: &mut Tester, sa: u8, when: &str) -> Course {
    let request = Request::status(tester.slave(), sa);
    let answer = tester.must_answer(&request)?;
    if answer.is_status(ReplyStatus::Ok) {
        return Ok(());
    }
    broken(format!("{when} it is answered with {}, expected OK (FC 00)", answer.words()))
}

fn f01(tester: &mut Tester) -> Course {
    let (owner, other) = (tester.owner(), tester.other());
    status(tester, owner, "in WAIT-PRM")?;
    let prm = tester.prm();
    tester.set_prm(&prm)?;
    status(tester, owner, "in WAIT-CFG")?;
    tester.chk_cfg()?;
    tester.ready()?;
    tester.exchanged_zeros()?;
    for sa in [owner, other] {
        status(tester, sa, "in DATA-EXCH")?;
    }
    Ok(())
}

fn f02(tester: &mut Tester) -> Course {
    let (nobody, owner) = (tester.setup.nobody(), tester.owner());
    let neighbour = tester.slave() ^ 1;
    let taken = [owner, tester.other(), 126, 127];
    for da in [nobody, neighbour].into_iter().filter(|da| !taken.contains(da)) {
        let diag = Request::of(da, owner, Service::SlaveDiag, FrameCount::First, &[]);
        let exchange = Request::of(da, owner, Service::DataExchange, FrameCount::First, &tester.zeros());
        for request in [Request::status(da, owner), diag, exchange] {
            let what = format!("{} to address {da}", request.name());
            tester.unanswered(owner, &request.octets(), &what)?;
        }
    }
    Ok(())
}

/// Requests of every format that would do something if they were right: SD1, SD2 and, where it is one, SD3.
fn three_formats(tester: &mut Tester) -> Vec<(&'static str, Vec<u8>)> {
    let (slave, owner) = (tester.slave(), tester.owner());
    let wrong_prm = Prm::lock(!tester.ident, Vec::new());
    let prm = Request::of(slave, owner, Service::SetPrm, FrameCount::First, &wrong_prm.octets());
    let mut cfg = Request::of(slave, owner, Service::ChkCfg, FrameCount::First, &[0; 6]);
    cfg.as_sd3 = true;
    vec![
        ("an FDL status request (SD1)", Request::status(slave, owner).octets()),
        ("a Set_Prm (SD2)", prm.octets()),
        ("a Chk_Cfg (SD3)", cfg.octets()),
    ]
}

fn none_is_taken(tester: &mut Tester, what: &str, broken_so: impl Fn(&[u8]) -> Vec<u8>) -> Course {
    tester.start()?;
    for (name, octets) in three_formats(tester) {
        let name = format!("{name} with {what}");
        tester.unanswered(tester.owner(), &broken_so(&octets), &name)?;
        tester.wire.recover()?;
    }
    // Whether this one is heard S-F07 judges.
    tester.ask(&Request::status(tester.slave(), tester.owner()))?;
    tester.still_exchanges(&format!("telegrams with {what}"))
}

fn f03(tester: &mut Tester) -> Course {
    none_is_taken(tester, "a wrong checksum", with_wrong_fcs)
}

fn f04(tester: &mut Tester) -> Course {
    none_is_taken(tester, "a wrong end delimiter", with_wrong_end)
}

fn f05(tester: &mut Tester) -> Course {
    tester.start()?;
    let (slave, owner) = (tester.slave(), tester.owner());
    let good = Request::of(slave, owner, Service::SlaveDiag, FrameCount::First, &[]).octets();
    let with = |place: usize, octet: u8| {
        let mut octets = good.clone();
        if let Some(place) = octets.get_mut(place) {
            *place = octet;
        }
        octets
    };
    let both = |le: u8| {
        let mut octets = with(1, le);
        if let Some(place) = octets.get_mut(2) {
            *place = le;
        }
        octets
    };
    for (what, octets) in [
        ("LEr that is not LE", with(2, 6)),
        ("LE that is not LEr", with(1, 6)),
        ("LE = 3", both(3)),
        ("LE = 250", both(250)),
        ("a fourth octet that is not 68", with(3, 0x10)),
    ] {
        tester.unanswered(owner, &octets, &format!("a telegram with {what}"))?;
        tester.wire.recover()?;
    }
    tester.ask(&Request::status(slave, owner))?;
    tester.still_exchanges("telegrams with wrong lengths")
}

fn f07(tester: &mut Tester) -> Course {
    let (slave, owner) = (tester.slave(), tester.owner());
    let good = Request::of(slave, owner, Service::SlaveDiag, FrameCount::First, &[]).octets();
    let half = good.get(..good.len() / 2).unwrap_or_default();
    for broken_one in [with_wrong_fcs(&good), half.to_vec()] {
        tester.unanswered(owner, &broken_one, "a broken telegram")?;
        tester.wire.recover()?;
        status(tester, owner, "after a broken telegram")?;
    }
    Ok(())
}

fn f09(tester: &mut Tester) -> Course {
    let owner = tester.owner();
    for octet in [0x10, 0x68, 0xA2, 0xDC, 0xE5, 0x00, 0xFF] {
        tester.unanswered(owner, &[octet], &format!("the octet {octet:02X}"))?;
        tester.wire.recover()?;
        status(tester, owner, &format!("after the octet {octet:02X}"))?;
    }
    Ok(())
}

fn f18(tester: &mut Tester) -> Course {
    let (slave, owner) = (tester.slave(), tester.owner());
    for sa in [slave, Address::BROADCAST.number()] {
        let request = Request::status(slave, sa);
        tester.unanswered(owner, &request.octets(), &format!("an FDL status request with SA {sa}"))?;
    }
    Ok(())
}
