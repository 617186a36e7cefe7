//! Heartbeat, guarding, life time, heartbeats of others.

use core::time::Duration;

use super::{row, sure};
use crate::can_bus::can::{Frame, Id};
use crate::can_bus::canopen::{Abort, NmtState, NodeId, cob_id};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::node::Bench;
use crate::judge::device::node::wire::Passed;
use crate::judge::device::row::{By, Group};
use crate::judge::requirement::Confidence::{B, U};

pub(super) const GROUP: Group<Bench> = Group {
    title: "Error control",
    rows: &[
        row(
            "N-E01",
            "a heartbeat every 1017h ms, within 10 %; none with 0",
            "1017h (ms): starts with the write, period from frame to frame; 0 stops (4)",
            &["N-O01"],
            By::Trial(e01),
        ),
        row(
            "N-E02",
            "the heartbeat shows each state: 7F, 05, 04",
            "byte in heartbeat: STOPPED 04h, OPERATIONAL 05h, PRE-OPERATIONAL 7Fh (3)",
            &["N-E01", "N-K02"],
            By::Trial(e02),
        ),
        row(
            "N-E03",
            "guarding: the toggle bit alternates, over changes of state too, and is 0 first after reset communication",
            "answer 1 byte: bit 7 toggle, bits 6..0 state; toggle 0 in the first answer after reset communication (4)",
            &["N-K02", "N-K06"],
            By::Trial(e03),
        ),
        sure(
            row(
                "N-E04",
                "life time: no event before the first request; EMCY 8130h when requests stop",
                "100Ch x 100Dh ms; supervised from the first request on; expiry: life-guarding event; devices differ (4)",
                &["N-E03", "N-O01"],
                By::Trial(e04),
            ),
            U,
        ),
        sure(
            row(
                "N-E05",
                "heartbeats of another node: no event before the first, EMCY 8130h or one of its own when they stop",
                "1016h: supervision begins with the first heartbeat; expiry: EMCY 8130h (4)",
                &["N-O01"],
                By::Trial(e05),
            ),
            B,
        ),
        sure(
            row(
                "N-E06",
                "1029h:1 decides the state after such an event",
                "1029h:1: 0 OPERATIONAL to PRE-OPERATIONAL, 1 none, 2 STOPPED (eds 4)",
                &["N-E05", "N-K02"],
                By::Trial(e06),
            ),
            B,
        ),
        sure(
            row(
                "N-E07",
                "two entries of 1016h with the same node: 06040043h",
                "two entries with the same node: 06040043h (4)",
                &["N-E05"],
                By::Trial(e07),
            ),
            B,
        ),
        sure(
            row(
                "N-E09",
                "the first heartbeat after a write of 1017h comes one period later",
                "first frame after the write of 1017h: one period after (doubt 306)",
                &["N-E01"],
                By::Trial(e09),
            ),
            U,
        ),
    ],
};

fn a_heartbeat(bench: &mut Bench) -> Course {
    bench.may_write()?;
    if bench.is_writable(0x1017, 0)? { Ok(()) } else { inapplicable("it has no 1017h to write to") }
}

fn set_period(bench: &mut Bench, millis: u16) -> Course {
    bench.set(0x1017, 0, &millis.to_le_bytes())?;
    bench.known.heartbeat = (millis > 0).then(|| Duration::from_millis(millis.into()));
    Ok(())
}

fn e01(bench: &mut Bench) -> Course {
    a_heartbeat(bench)?;
    let id = bench.id(cob_id::ERROR_CONTROL);
    let periods: &[(u16, u32)] =
        if bench.setup.quick { &[(50, 3)] } else { &[(50, 10), (100, 5), (1000, 1)] };
    for (millis, count) in periods {
        set_period(bench, *millis)?;
        let period = Duration::from_millis((*millis).into());
        let margin = period / 10 + bench.wire.latency;
        let mut before = None;
        for _ in 0..=*count {
            let heard = bench.find(period * 2 + bench.silence(), |frame| frame.id() == id)?;
            let Some(Passed { at, frame, .. }) = heard else {
                return broken(format!(
                    "1017h is {millis}, and no heartbeat comes within {} ms",
                    (period * 2).as_millis()
                ));
            };
            if frame.octets() != [NmtState::PreOperational.octet()] {
                return broken(format!("the heartbeat in PRE-OPERATIONAL is {frame}"));
            }
            if let Some(before) = before.replace(at) {
                let apart = at.saturating_since(before);
                if apart + margin < period || apart > period + margin {
                    return broken(format!(
                        "1017h is {millis}, and heartbeats are {} ms apart",
                        apart.as_millis()
                    ));
                }
            }
        }
    }
    set_period(bench, 0)?;
    bench.collect(bench.wire.latency)?;
    match bench.find(Duration::from_millis(200), |frame| frame.id() == id)? {
        None => Ok(()),
        Some(_) => broken("1017h is 0, and heartbeats go on"),
    }
}

fn e02(bench: &mut Bench) -> Course {
    a_heartbeat(bench)?;
    set_period(bench, 50)?;
    let id = bench.id(cob_id::ERROR_CONTROL);
    for state in [NmtState::Operational, NmtState::Stopped, NmtState::PreOperational] {
        bench.enter(state)?;
        bench.drain()?;
        bench.collect(bench.wire.latency)?;
        let heard = bench.find(Duration::from_millis(150), |frame| frame.id() == id)?;
        match heard.as_ref().map(|passed| passed.frame.octets()) {
            Some([octet]) if *octet == state.octet() => {}
            Some(octets) => {
                return broken(format!(
                    "the heartbeat in {state} is {octets:02X?}, expected [{:02X}]",
                    state.octet()
                ));
            }
            None => return broken(format!("no heartbeat in {state}")),
        }
    }
    Ok(())
}

fn e09(bench: &mut Bench) -> Course {
    a_heartbeat(bench)?;
    set_period(bench, 0)?;
    set_period(bench, 200)?;
    let (id, set) = (bench.id(cob_id::ERROR_CONTROL), bench.wire.now());
    let heard = bench.find(Duration::from_millis(500), |frame| frame.id() == id)?;
    let after = heard.map(|passed| passed.at.saturating_since(set));
    let margin = Duration::from_millis(20) + bench.wire.latency;
    match after {
        Some(after) if after + margin >= Duration::from_millis(200) => Ok(()),
        Some(after) => {
            broken(format!("1017h is set to 200, and a heartbeat comes {} ms later", after.as_millis()))
        }
        None => broken("no heartbeat within 500 ms"),
    }
}

fn e03(bench: &mut Bench) -> Course {
    if bench.known.own_heartbeat.is_some() {
        return inapplicable(
            "it produces heartbeats after a reset of the communication, and those end guarding",
        );
    }
    if !bench.guarded {
        return inapplicable("it answers no guarding request");
    }
    bench.reset()?;
    let count = if bench.setup.quick { 12 } else { 60 };
    for number in 0..count {
        let state = match number / 4 % 3 {
            0 => NmtState::PreOperational,
            1 => NmtState::Operational,
            _third => NmtState::Stopped,
        };
        if number % 4 == 0 {
            bench.enter(state)?;
        }
        let expected = state.octet() | if number % 2 == 0 { 0 } else { 0x80 };
        match bench.guard()? {
            Some(octet) if octet == expected => {}
            Some(octet) => {
                return broken(format!(
                    "answer {number} to guarding requests is {octet:02X}h, expected {expected:02X}h"
                ));
            }
            None => return broken(format!("guarding request {number} is not answered in {state}")),
        }
    }
    Ok(())
}

/// The codes of emergencies with this identifier that come in this time.
pub(super) fn emergencies(bench: &mut Bench, id: Id, time: Duration) -> Course<Vec<u16>> {
    let all = bench.collect(time)?.into_iter().map(|passed| passed.frame);
    let code = |frame: Frame| match frame.octets() {
        [low, high, ..] if frame.id() == id => Some(u16::from_le_bytes([*low, *high])),
        _other => None,
    };
    Ok(all.filter_map(code).collect())
}

/// The first emergency in this time whose code is wanted.
fn first_event(
    bench: &mut Bench,
    id: Id,
    time: Duration,
    wanted: impl Fn(u16) -> bool,
) -> Course<Option<u16>> {
    let code = |frame: &Frame| match frame.octets() {
        [low, high, ..] if frame.id() == id => u16::from_le_bytes([*low, *high]),
        _other => 0,
    };
    let heard = bench.find(time, |frame| wanted(code(frame)))?;
    Ok(heard.map(|passed| code(&passed.frame)))
}

/// The identifier of emergencies.
pub(super) fn emergency_id(bench: &mut Bench) -> Course<Id> {
    let number = bench.number_if(0x1014, 0)?;
    let cob_id = number.and_then(|number| u32::try_from(number).ok()).map(cob_id::CobId);
    Ok(cob_id.and_then(cob_id::CobId::active).unwrap_or_else(|| bench.id(cob_id::EMCY)))
}

const LIFE_GUARDING: u16 = 0x8130;

fn e04(bench: &mut Bench) -> Course {
    bench.may_write()?;
    if !bench.is_writable(0x100C, 0)? || !bench.is_writable(0x100D, 0)? {
        return inapplicable("it has no 100Ch and 100Dh to write to");
    }
    if !bench.guarded {
        return inapplicable("it answers no guarding request, or produces heartbeats");
    }
    bench.leaves_errors();
    bench.reset()?;
    let guard = bench.supervision();
    bench.set(0x100C, 0, &millis(guard))?;
    bench.set(0x100D, 0, &[3])?;
    let id = emergency_id(bench)?;
    if emergencies(bench, id, guard * 4)?.contains(&LIFE_GUARDING) {
        return broken("EMCY 8130h before the first guarding request");
    }
    for _ in 0..if bench.setup.quick { 2 } else { 4 } {
        if bench.guard()?.is_none() {
            return broken("a guarding request is not answered while 100Ch and 100Dh are set");
        }
        if emergencies(bench, id, guard)?.contains(&LIFE_GUARDING) {
            return broken("EMCY 8130h although guarding requests come in time");
        }
    }
    if first_event(bench, id, guard * 6 + bench.wire.latency, |code| code == LIFE_GUARDING)?.is_some() {
        return Ok(());
    }
    let life = (guard * 3).as_millis();
    broken(format!("no EMCY 8130h in twice the life time, {life} ms, after the last guarding request"))
}

/// A time of an object in ms.
fn millis(time: Duration) -> [u8; 2] {
    u16::try_from(time.as_millis()).unwrap_or(u16::MAX).to_le_bytes()
}

/// The node whose heartbeats it must supervise.
fn producer(bench: &Bench) -> NodeId {
    bench.other()
}

fn heartbeat_of(bench: &mut Bench, node: NodeId) -> Course {
    bench.send(cob_id::of_node(cob_id::ERROR_CONTROL, node), &[0x05])
}

/// Has it supervise another node.
fn lose(bench: &mut Bench) -> Course {
    bench.may_write()?;
    if !bench.is_writable(0x1016, 1)? {
        return inapplicable("it has no 1016h:1 to write to");
    }
    bench.leaves_errors();
    let consumer = consumer(bench);
    bench.set(0x1016, 1, &consumer)
}

/// An entry of 1016h for the node whose heartbeats stop.
pub(super) fn consumer(bench: &Bench) -> [u8; 4] {
    let [low, high] = millis(bench.supervision());
    [low, high, producer(bench).number(), 0]
}

fn e05(bench: &mut Bench) -> Course {
    lose(bench)?;
    let (node, id, time) = (producer(bench), emergency_id(bench)?, bench.supervision());
    let ms = time.as_millis();
    if event(&emergencies(bench, id, time * 4)?).is_some() {
        return broken("an emergency before the first heartbeat of the node that it supervises");
    }
    for _ in 0..5 {
        heartbeat_of(bench, node)?;
        if event(&emergencies(bench, id, time / 2)?).is_some() {
            return broken(format!(
                "an emergency although heartbeats come in time, and 1016h:1 says {ms} ms"
            ));
        }
    }
    let Some(code) = first_event(bench, id, time * 4 + bench.wire.latency, |code| code != 0)? else {
        return broken(format!(
            "no emergency within {} ms after the last heartbeat, and 1016h:1 says {ms} ms",
            ms * 4
        ));
    };
    let (register, bits) = (bench.number(0x1001, 0)?, if code == LIFE_GUARDING { 0x11 } else { 0x01 });
    if register & bits != bits {
        return broken(format!(
            "1001h is {register:02X}h after EMCY {code:04X}h, expected the bits {bits:02X}h"
        ));
    }
    Ok(())
}

/// The first code that says that something is wrong.
pub(super) fn event(codes: &[u16]) -> Option<u16> {
    codes.iter().copied().find(|code| *code != 0)
}

fn e06(bench: &mut Bench) -> Course {
    bench.may_write()?;
    if !bench.is_writable(0x1029, 1)? {
        return inapplicable("it has no 1029h:1 to write to");
    }
    bench.show_state()?;
    for (behaviour, state) in
        [(0, NmtState::PreOperational), (1, NmtState::Operational), (2, NmtState::Stopped)]
    {
        if bench.try_set(0x1029, 1, &[behaviour])?.is_err() {
            continue;
        }
        lose(bench)?;
        bench.enter(NmtState::Operational)?;
        let node = producer(bench);
        heartbeat_of(bench, node)?;
        bench.collect(bench.supervision() * 2 + bench.wire.latency)?;
        bench.must_be(state, &format!("after the loss of a heartbeat with 1029h:1 = {behaviour}"))?;
        bench.enter(NmtState::PreOperational)?;
    }
    Ok(())
}

fn e07(bench: &mut Bench) -> Course {
    if !bench.is_writable(0x1016, 2)? {
        return inapplicable("it has no 1016h:2 to write to");
    }
    lose(bench)?;
    let consumer = consumer(bench);
    let got = bench.try_set(0x1016, 2, &consumer)?;
    bench.must_refuse(got, &[Abort::PARAMETER.code()], "a second entry of 1016h with the same node")
}
