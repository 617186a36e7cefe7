//! Forms of requests: formats, priorities, SAPs, lengths, and telegrams that are no requests to this slave.

use super::{row, softer};
use crate::chance::Random;
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::answer::Answer;
use crate::judge::device::slave::request::{MASTER_SAP, Request};
use crate::judge::device::slave::wire::Sight;
use crate::judge::moment::{Side, split};
use crate::judge::requirement::Confidence::U;
use crate::profibus::dp::{DiagBit, Service};
use crate::profibus::fdl;
use crate::profibus::fdl::{
    Address, DataTelegram, FrameCount, FunctionCode, MAX_TELEGRAM_LEN, ReplyStatus, Sap,
};

pub(super) const GROUP: Group<Tester> = Group {
    title: "Forms of requests",
    rows: &[
        row(
            "S-F08",
            "a telegram cut into pieces, and two telegrams at once, are heard as if they came one by one",
            "a receiver makes telegrams of octets, however they arrive (1)",
            &["S-F01"],
            By::Trial(f08),
        ),
        softer(
            row(
                "S-F10",
                "two requests with less than T_SYN between them: never a wrong answer",
                "T_SYN of idle line comes before every request; what comes earlier may be dropped (1)",
                &["S-F01"],
                By::Trial(f10),
            ),
            2,
            U,
        ),
        row(
            "S-F11",
            "a request with eight octets as SD3 does what it does as SD2; replies are SD2",
            "a receiver accepts SD1, SD2 and SD3; masters send a PDU of eight octets as SD3 (2 rule 4)",
            &["S-G02"],
            By::Trial(f11),
        ),
        row(
            "S-F12",
            "SRD low does the same as SRD high, in every service",
            "low and high are accepted alike; never match the whole FC (2.2)",
            &["S-X01", "S-G08"],
            By::Trial(f12),
        ),
        row(
            "S-F13",
            "a request to a SAP that is not there: RS",
            "RS: service or SAP not activated (2.2)",
            &["S-X01"],
            By::Trial(f13),
        ),
        row(
            "S-F14",
            "a reply is a telegram of a slave with the addresses and SAPs of the request exchanged, SSAP other than 62 too",
            "DA = SA of the request, SA = own address, DSAP = SSAP, SSAP = DSAP; station type 00 (2.1, 2.2)",
            &[],
            By::Trial(f14),
        ),
        row(
            "S-F15",
            "SRD to 127, and SDN to 127 of the SAP of Slave_Diag: silence",
            "127 is for SDN only; a slave never replies to it (2.1)",
            &["S-X01"],
            By::Trial(f15),
        ),
        row(
            "S-F16",
            "replies of other slaves, to any address, its own too: ignored",
            "b6 = 0 is a reply; a slave does not answer replies (2.2)",
            &["S-X01"],
            By::Trial(f16),
        ),
        softer(
            row(
                "S-F17",
                "a token to its address: ignored",
                "a slave takes no token (2)",
                &["S-X01"],
                By::Trial(f17),
            ),
            2,
            crate::judge::requirement::Confidence::B,
        ),
        softer(
            row(
                "S-F19",
                "Ident and LSAP status requests: RS or valid data",
                "optional services: data, or RS if they are not offered (2.2, 3)",
                &[],
                By::Trial(f19),
            ),
            2,
            U,
        ),
        softer(
            row(
                "S-F20",
                "SDA to the SAP of Slave_Diag: RS, and the state does not change",
                "SDA is not used by DP-V0; the SAP takes SRD only (2.2)",
                &["S-X01"],
                By::Trial(f20),
            ),
            2,
            U,
        ),
        row(
            "S-F21",
            "a request with LE = 249 is answered",
            "LE is 4 to 249, the PDU up to 246 octets with its SAPs (2 rule 1)",
            &["S-P01"],
            By::Trial(f21),
        ),
        row(
            "S-F22",
            "its own reply heard again on the line: ignored",
            "a line may echo; a reply is no request (2.2)",
            &["S-X01"],
            By::Trial(f22),
        ),
        row(
            "S-F23",
            "random octets and damaged requests: no reply to any, and the slave is as before",
            "what is no telegram is dropped, whatever the octets (1, 2)",
            &["S-F03", "S-F04", "S-F05", "S-F09"],
            By::Trial(f23),
        ),
    ],
};

fn f08(tester: &mut Tester) -> Course {
    if tester.wire.sight != Sight::Untimed {
        return inapplicable("on a real line a pause ends a telegram; a terminal or TCP cuts where it likes");
    }
    let request = Request::of(tester.slave(), tester.owner(), Service::SlaveDiag, FrameCount::First, &[]);
    let octets = request.octets();
    for at in [1, 4, octets.len() / 2, octets.len() - 1] {
        let (front, rest) = octets.split_at(at.min(octets.len()));
        let side = Side::Master;
        tester.wire.send(front, side)?;
        tester.wire.send_at_once(rest, side)?;
        let heard = tester.wire.reply()?.map_or(Answer::Silence, |heard| Answer::of(&heard.octets));
        if !matches!(heard, Answer::Data(..)) {
            return broken(format!(
                "Slave_Diag in two pieces, cut at {at}, is answered with {}",
                heard.words()
            ));
        }
    }
    Ok(())
}

fn f10(tester: &mut Tester) -> Course {
    let request = Request::status(tester.slave(), tester.owner()).octets();
    let side = Side::Master;
    tester.wire.send(&request, side)?;
    tester.wire.send_at_once(&request, side)?;
    let mut heard = tester.wire.reply()?.map(|heard| heard.octets);
    while let Some(octets) = heard {
        for octets in split(&octets) {
            let answer = Answer::of(octets);
            if !answer.is_status(ReplyStatus::Ok) {
                return broken(format!("two requests at once are answered with {}", answer.words()));
            }
        }
        heard = tester.wire.silence()?;
    }
    tester.wire.take_unasked();
    Ok(())
}

fn f11(tester: &mut Tester) -> Course {
    let prm = tester.prm();
    tester.set_prm(&prm)?;
    let mut request = tester.request(tester.owner(), Service::ChkCfg, &[0x7F; 6]);
    request.as_sd3 = true;
    let answer = tester.must_answer(&request)?;
    if answer != Answer::Acknowledged {
        return broken(format!("Chk_Cfg as SD3 is answered with {}, expected SC", answer.words()));
    }
    let diagnosis = tester.diag()?;
    if !diagnosis.is(DiagBit::CfgFault) {
        return broken(format!("a wrong Chk_Cfg as SD3 leads to no Cfg_Fault: {}", diagnosis.words()));
    }
    Ok(())
}

/// The same service as SRD low.
fn low(tester: &mut Tester, service: Service, data: &[u8]) -> Course<Answer> {
    let mut request = tester.request(tester.owner(), service, data);
    request.service = fdl::Service::SrdLow;
    tester.must_answer(&request)
}

fn f12(tester: &mut Tester) -> Course {
    let (prm, cfg, zeros) = (tester.prm().octets(), tester.cfg.clone(), tester.zeros());
    let cases: [(Service, &[u8], bool); 4] = [
        (Service::SetPrm, &prm, false),
        (Service::ChkCfg, &cfg, false),
        (Service::SlaveDiag, &[], true),
        (Service::GetCfg, &[], true),
    ];
    for (service, data, wants_data) in cases {
        let answer = low(tester, service, data)?;
        let is_right = match &answer {
            Answer::Acknowledged => !wants_data,
            Answer::Data(..) => wants_data,
            Answer::Silence | Answer::Status(_) | Answer::Wrong(_) => false,
        };
        if !is_right {
            return broken(format!("{} as SRD low is answered with {}", service.name(), answer.words()));
        }
        if service == Service::ChkCfg {
            tester.ready()?;
        }
    }
    for _ in 0..2 {
        let answer = low(tester, Service::DataExchange, &zeros)?;
        tester.inputs_of(answer)?;
    }
    Ok(())
}

/// SAPs at which neither DP-V0 nor DP-V1 listens.
const NO_SAPS: [u8; 2] = [40, 52];

fn f13(tester: &mut Tester) -> Course {
    for exchanging in [false, true] {
        if exchanging {
            tester.start()?;
        }
        for sap in NO_SAPS {
            let mut request = tester.request(tester.owner(), Service::SlaveDiag, &[]);
            request.dsap = Some(sap);
            let answer = tester.must_answer(&request)?;
            if !answer.is_status(ReplyStatus::NotActivated) {
                return broken(format!("SAP {sap} answers with {}, expected RS", answer.words()));
            }
        }
    }
    tester.still_exchanges("requests to SAPs that are not there")
}

fn f14(tester: &mut Tester) -> Course {
    for ssap in [MASTER_SAP, 40, 0, 63] {
        let mut request = tester.request(tester.owner(), Service::SlaveDiag, &[]);
        request.ssap = Some(ssap);
        let answer = tester.must_answer(&request)?;
        let refused = ssap != MASTER_SAP && answer.is_status(ReplyStatus::NotActivated);
        if !refused && !matches!(answer, Answer::Data(..)) {
            return broken(format!("Slave_Diag from SSAP {ssap} is answered with {}", answer.words()));
        }
    }
    Ok(())
}

fn f15(tester: &mut Tester) -> Course {
    tester.start()?;
    let (owner, everybody) = (tester.owner(), Address::BROADCAST.number());
    let srd = Request::of(everybody, owner, Service::SlaveDiag, FrameCount::First, &[]);
    let mut sdn = Request::of(everybody, owner, Service::SlaveDiag, FrameCount::Unused, &[]);
    sdn.service = fdl::Service::SdnHigh;
    let exchange = Request::of(everybody, owner, Service::DataExchange, FrameCount::First, &tester.zeros());
    let status = Request::status(everybody, owner);
    for (what, request) in [
        ("SRD of Slave_Diag to 127", srd),
        ("SDN to SAP 60 of 127", sdn),
        ("Data_Exchange to 127", exchange),
        ("an FDL status request to 127", status),
    ] {
        tester.unanswered(owner, &request.octets(), what)?;
    }
    tester.still_exchanges("requests to 127")
}

/// A reply of this slave to this master, with two octets.
fn reply(sa: u8, da: u8, status: ReplyStatus, dsap: Option<u8>) -> Vec<u8> {
    let dsap = dsap.and_then(Sap::new);
    let ssap = dsap.and_then(|_| Sap::new(60));
    let data = [0x12, 0x34];
    let telegram = DataTelegram {
        format: DataTelegram::customary_format(dsap, ssap, &data),
        da: Address::from_octet(da),
        sa: Address::from_octet(sa),
        dsap,
        ssap,
        fc: FunctionCode::response(status),
        data: &data,
    };
    let mut buf = [0; MAX_TELEGRAM_LEN];
    telegram.encode(&mut buf).map(<[u8]>::to_vec).unwrap_or_default()
}

fn f16(tester: &mut Tester) -> Course {
    tester.start()?;
    let (slave, owner, nobody) = (tester.slave(), tester.owner(), tester.setup.nobody());
    for (what, octets) in [
        ("the reply of another slave", reply(nobody, owner, ReplyStatus::DataLow, None)),
        ("a reply of another slave to this one", reply(nobody, slave, ReplyStatus::DataLow, None)),
        (
            "a reply from a SAP of another slave to this one",
            reply(nobody, slave, ReplyStatus::DataHigh, Some(60)),
        ),
        ("SC", vec![0xE5]),
    ] {
        tester.unanswered(nobody, &octets, what)?;
    }
    tester.still_exchanges("replies of other slaves")
}

fn f17(tester: &mut Tester) -> Course {
    tester.start()?;
    let (slave, owner) = (tester.slave(), tester.owner());
    for (da, sa) in [(slave, owner), (tester.other(), owner), (slave, slave)] {
        tester.unanswered(owner, &[0xDC, da, sa], &format!("a token from {sa} to {da}"))?;
    }
    tester.still_exchanges("tokens")
}

fn f19(tester: &mut Tester) -> Course {
    for service in [fdl::Service::Ident, fdl::Service::LsapStatus] {
        let mut request = Request::status(tester.slave(), tester.owner());
        request.service = service;
        if service == fdl::Service::LsapStatus {
            (request.dsap, request.ssap) = (Some(60), Some(MASTER_SAP));
        }
        let answer = tester.must_answer(&request)?;
        let is_right = matches!(
            answer,
            Answer::Status(ReplyStatus::NotActivated | ReplyStatus::UserError | ReplyStatus::NoResource)
                | Answer::Data(ReplyStatus::DataLow, _)
        );
        if !is_right {
            return broken(format!(
                "{} is answered with {}, expected RS or DL",
                request.name(),
                answer.words()
            ));
        }
    }
    Ok(())
}

fn f20(tester: &mut Tester) -> Course {
    tester.start()?;
    for service in [fdl::Service::SdaLow, fdl::Service::SdaHigh] {
        let mut request = tester.request(tester.owner(), Service::SlaveDiag, &[]);
        request.service = service;
        let answer = tester.ask(&request)?;
        if !answer.is_status(ReplyStatus::NotActivated) {
            return broken(format!("SDA to SAP 60 is answered with {}, expected RS", answer.words()));
        }
    }
    tester.still_exchanges("SDA")
}

/// Set_Prm that fills a telegram.
const LONGEST_PRM: usize = 244;

fn f21(tester: &mut Tester) -> Course {
    let mut octets = tester.prm().octets();
    octets.resize(LONGEST_PRM, 0);
    tester.acknowledged(Service::SetPrm, &octets)?;
    tester.diag().map(|_| ())
}

fn f22(tester: &mut Tester) -> Course {
    tester.start()?;
    for service in [Service::DataExchange, Service::SlaveDiag] {
        let data = if service == Service::DataExchange { tester.zeros() } else { Vec::new() };
        tester.serve(tester.owner(), service, &data)?;
        let echo = tester.last_reply.clone();
        tester.unanswered(tester.slave(), &echo, &format!("its own reply to {}", service.name()))?;
    }
    tester.still_exchanges("its own replies")
}

/// How many damaged telegrams are sent.
const FUZZED: u32 = 200;
const FUZZED_QUICKLY: u32 = 30;

fn f23(tester: &mut Tester) -> Course {
    tester.start()?;
    let (slave, owner) = (tester.slave(), tester.owner());
    let mut chance = Random::new(23);
    let zeros = tester.zeros();
    let good = [
        Request::status(slave, owner).octets(),
        Request::of(slave, owner, Service::SlaveDiag, FrameCount::First, &[]).octets(),
        Request::of(slave, owner, Service::DataExchange, FrameCount::First, &zeros).octets(),
        Request::of(slave, owner, Service::SetPrm, FrameCount::First, &tester.prm().octets()).octets(),
    ];
    let rounds = if tester.setup.quick { FUZZED_QUICKLY } else { FUZZED };
    for round in 0..rounds {
        let mut octets = match good.get(chance.below(good.len() * 2)) {
            Some(good) => good.clone(),
            None => (0..chance.below(40) + 1).map(|_| chance.octet()).collect(),
        };
        // One bit: with a Hamming distance of 4 that is never a telegram.
        let (at, bit) = (chance.below(octets.len()), chance.below(8));
        if let Some(octet) = octets.get_mut(at) {
            *octet ^= 1 << bit;
        }
        if is_heard(&octets) {
            continue;
        }
        tester.unanswered(owner, &octets, &format!("damaged telegram {round}"))?;
        tester.wire.recover()?;
    }
    tester.still_exchanges("damaged telegrams")
}

/// Whether octets that were damaged have a telegram in them all the same.
fn is_heard(octets: &[u8]) -> bool {
    use crate::profibus::fdl::telegram::{Decoded, decode};
    (0..octets.len()).any(|at| {
        let rest = octets.get(at..).unwrap_or_default();
        matches!(decode(rest), Decoded::Telegram { .. })
    })
}
