//! Heartbeat, guarding, life time, heartbeats of others.

use core::time::Duration;

use super::{row, sure};
use crate::can_bus::can::{Frame, Id};
use crate::can_bus::canopen::{Abort, NmtState, NodeId, cob_id};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::node::Tester;
use crate::judge::device::node::wire::Passed;
use crate::judge::device::row::{By, Group};
use crate::judge::requirement::Confidence::{B, U};

pub(super) const GROUP: Group<Tester> = Group {
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

fn a_heartbeat(tester: &mut Tester) -> Course {
    tester.may_write()?;
    if tester.is_writable(0x1017, 0)? { Ok(()) } else { inapplicable("it has no 1017h to write to") }
}

fn set_period(tester: &mut Tester, millis: u16) -> Course {
    tester.set(0x1017, 0, &millis.to_le_bytes())?;
    tester.known.heartbeat = (millis > 0).then(|| Duration::from_millis(millis.into()));
    Ok(())
}

fn e01(tester: &mut Tester) -> Course {
    a_heartbeat(tester)?;
    let id = tester.id(cob_id::ERROR_CONTROL);
    let periods: &[(u16, u32)] =
        if tester.setup.quick { &[(50, 3)] } else { &[(50, 10), (100, 5), (1000, 1)] };
    for (millis, count) in periods {
        set_period(tester, *millis)?;
        let period = Duration::from_millis((*millis).into());
        let margin = period / 10 + tester.wire.latency;
        let mut before = None;
        for _ in 0..=*count {
            let heard = tester.find(period * 2 + tester.silence(), |frame| frame.id() == id)?;
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
    set_period(tester, 0)?;
    tester.collect(tester.wire.latency)?;
    match tester.find(Duration::from_millis(200), |frame| frame.id() == id)? {
        None => Ok(()),
        Some(_) => broken("1017h is 0, and heartbeats go on"),
    }
}

fn e02(tester: &mut Tester) -> Course {
    a_heartbeat(tester)?;
    set_period(tester, 50)?;
    let id = tester.id(cob_id::ERROR_CONTROL);
    for state in [NmtState::Operational, NmtState::Stopped, NmtState::PreOperational] {
        tester.enter(state)?;
        tester.drain()?;
        tester.collect(tester.wire.latency)?;
        let heard = tester.find(Duration::from_millis(150), |frame| frame.id() == id)?;
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

fn e09(tester: &mut Tester) -> Course {
    a_heartbeat(tester)?;
    set_period(tester, 0)?;
    set_period(tester, 200)?;
    let (id, set) = (tester.id(cob_id::ERROR_CONTROL), tester.wire.now());
    let heard = tester.find(Duration::from_millis(500), |frame| frame.id() == id)?;
    let after = heard.map(|passed| passed.at.saturating_since(set));
    let margin = Duration::from_millis(20) + tester.wire.latency;
    match after {
        Some(after) if after + margin >= Duration::from_millis(200) => Ok(()),
        Some(after) => {
            broken(format!("1017h is set to 200, and a heartbeat comes {} ms later", after.as_millis()))
        }
        None => broken("no heartbeat within 500 ms"),
    }
}

fn e03(tester: &mut Tester) -> Course {
    if tester.known.own_heartbeat.is_some() {
        return inapplicable(
            "it produces heartbeats after a reset of the communication, and those end guarding",
        );
    }
    if !tester.guarded {
        return inapplicable("it answers no guarding request");
    }
    tester.reset()?;
    let count = if tester.setup.quick { 12 } else { 60 };
    for number in 0..count {
        let state = match number / 4 % 3 {
            0 => NmtState::PreOperational,
            1 => NmtState::Operational,
            _third => NmtState::Stopped,
        };
        if number % 4 == 0 {
            tester.enter(state)?;
        }
        let expected = state.octet() | if number % 2 == 0 { 0 } else { 0x80 };
        match tester.guard()? {
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
pub(super) fn emergencies(tester: &mut Tester, id: Id, time: Duration) -> Course<Vec<u16>> {
    let all = tester.collect(time)?.into_iter().map(|passed| passed.frame);
    let code = |frame: Frame| match frame.octets() {
        [low, high, ..] if frame.id() == id => Some(u16::from_le_bytes([*low, *high])),
        _other => None,
    };
    Ok(all.filter_map(code).collect())
}

/// The first emergency in this time whose code is wanted.
fn first_event(
    tester: &mut Tester,
    id: Id,
    time: Duration,
    wanted: impl Fn(u16) -> bool,
) -> Course<Option<u16>> {
    let code = |frame: &Frame| match frame.octets() {
        [low, high, ..] if frame.id() == id => u16::from_le_bytes([*low, *high]),
        _other => 0,
    };
    let heard = tester.find(time, |frame| wanted(code(frame)))?;
    Ok(heard.map(|passed| code(&passed.frame)))
}

/// The identifier of emergencies.
pub(super) fn emergency_id(tester: &mut Tester) -> Course<Id> {
    let number = tester.number_if(0x1014, 0)?;
    let cob_id = number.and_then(|number| u32::try_from(number).ok()).map(cob_id::CobId);
    Ok(cob_id.and_then(cob_id::CobId::active).unwrap_or_else(|| tester.id(cob_id::EMCY)))
}

const LIFE_GUARDING: u16 = 0x8130;

fn e04(tester: &mut Tester) -> Course {
    tester.may_write()?;
    if !tester.is_writable(0x100C, 0)? || !tester.is_writable(0x100D, 0)? {
        return inapplicable("it has no 100Ch and 100Dh to write to");
    }
    if !tester.guarded {
        return inapplicable("it answers no guarding request, or produces heartbeats");
    }
    tester.leaves_errors();
    tester.reset()?;
    let guard = tester.supervision();
    tester.set(0x100C, 0, &millis(guard))?;
    tester.set(0x100D, 0, &[3])?;
    let id = emergency_id(tester)?;
    if emergencies(tester, id, guard * 4)?.contains(&LIFE_GUARDING) {
        return broken("EMCY 8130h before the first guarding request");
    }
    for _ in 0..if tester.setup.quick { 2 } else { 4 } {
        if tester.guard()?.is_none() {
            return broken("a guarding request is not answered while 100Ch and 100Dh are set");
        }
        if emergencies(tester, id, guard)?.contains(&LIFE_GUARDING) {
            return broken("EMCY 8130h although guarding requests come in time");
        }
    }
    if first_event(tester, id, guard * 6 + tester.wire.latency, |code| code == LIFE_GUARDING)?.is_some() {
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
fn producer(tester: &Tester) -> NodeId {
    tester.other()
}

fn heartbeat_of(tester: &mut Tester, node: NodeId) -> Course {
    tester.send(cob_id::of_node(cob_id::ERROR_CONTROL, node), &[0x05])
}

/// Has it supervise another node.
fn lose(tester: &mut Tester) -> Course {
    tester.may_write()?;
    if !tester.is_writable(0x1016, 1)? {
        return inapplicable("it has no 1016h:1 to write to");
    }
    tester.leaves_errors();
    let consumer = consumer(tester);
    tester.set(0x1016, 1, &consumer)
}

/// An entry of 1016h for the node whose heartbeats stop.
pub(super) fn consumer(tester: &Tester) -> [u8; 4] {
    let [low, high] = millis(tester.supervision());
    [low, high, producer(tester).number(), 0]
}

fn e05(tester: &mut Tester) -> Course {
    lose(tester)?;
    let (node, id, time) = (producer(tester), emergency_id(tester)?, tester.supervision());
    let ms = time.as_millis();
    if event(&emergencies(tester, id, time * 4)?).is_some() {
        return broken("an emergency before the first heartbeat of the node that it supervises");
    }
    for _ in 0..5 {
        heartbeat_of(tester, node)?;
        if event(&emergencies(tester, id, time / 2)?).is_some() {
            return broken(format!(
                "an emergency although heartbeats come in time, and 1016h:1 says {ms} ms"
            ));
        }
    }
    let Some(code) = first_event(tester, id, time * 4 + tester.wire.latency, |code| code != 0)? else {
        return broken(format!(
            "no emergency within {} ms after the last heartbeat, and 1016h:1 says {ms} ms",
            ms * 4
        ));
    };
    let (register, bits) = (tester.number(0x1001, 0)?, if code == LIFE_GUARDING { 0x11 } else { 0x01 });
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

fn e06(tester: &mut Tester) -> Course {
    tester.may_write()?;
    if !tester.is_writable(0x1029, 1)? {
        return inapplicable("it has no 1029h:1 to write to");
    }
    tester.show_state()?;
    for (behaviour, state) in
        [(0, NmtState::PreOperational), (1, NmtState::Operational), (2, NmtState::Stopped)]
    {
        if tester.try_set(0x1029, 1, &[behaviour])?.is_err() {
            continue;
        }
        lose(tester)?;
        tester.enter(NmtState::Operational)?;
        let node = producer(tester);
        heartbeat_of(tester, node)?;
        tester.collect(tester.supervision() * 2 + tester.wire.latency)?;
        tester.must_be(state, &format!("after the loss of a heartbeat with 1029h:1 = {behaviour}"))?;
        tester.enter(NmtState::PreOperational)?;
    }
    Ok(())
}

fn e07(tester: &mut Tester) -> Course {
    if !tester.is_writable(0x1016, 2)? {
        return inapplicable("it has no 1016h:2 to write to");
    }
    lose(tester)?;
    let consumer = consumer(tester);
    let got = tester.try_set(0x1016, 2, &consumer)?;
    tester.must_refuse(got, &[Abort::PARAMETER.code()], "a second entry of 1016h with the same node")
}
