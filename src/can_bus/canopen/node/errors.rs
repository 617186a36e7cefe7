//! Errors of a node: the error register 1001h, the history 1003h and the EMCY service (`canopen-link.md` 7).

use core::time::Duration;

use heapless::Deque;

use super::{Node, Service};
use crate::can_bus::can::Frame;
use crate::can_bus::canopen::application::Application;
use crate::can_bus::canopen::cob_id::CobId;
use crate::can_bus::canopen::emcy::{COMMUNICATION, Emergency};
use crate::can_bus::canopen::event::Event;
use crate::can_bus::canopen::nmt::NmtState;
use crate::time::Instant;

/// The most entries in a history.
pub(crate) const MAX_HISTORY: usize = 16;

/// Messages that wait for the end of the inhibit time. What is more is lost; the history has it.
const MAX_WAITING: usize = 16;

/// Bit 0 of the error register: any error.
const GENERIC: u8 = 1 << 0;
/// A communication error that the node itself sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cause {
    LifeGuarding,
    /// The consumer at this place.
    Heartbeat(usize),
    /// The RPDO at this place.
    RpdoLength(usize),
}

impl Cause {
    const fn bit(self) -> u128 {
        match self {
            Self::LifeGuarding => 1,
            Self::Heartbeat(place) => 1 << (1 + place),
            Self::RpdoLength(place) => 1 << (16 + place),
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Message {
    code: u16,
    register: u8,
    octets: [u8; 5],
}

/// What is wrong, what was wrong, and what is still to be said about it.
#[derive(Clone, Debug)]
pub(super) struct Errors {
    device: u8,
    causes: u128,
    history: Deque<u32, MAX_HISTORY>,
    waiting: Deque<Message, MAX_WAITING>,
    inhibited_until: Instant,
}

impl Errors {
    pub(super) const NONE: Self = Self {
        device: 0,
        causes: 0,
        history: Deque::new(),
        waiting: Deque::new(),
        inhibited_until: Instant::ZERO,
    };

    /// 1001h.
    pub(super) const fn register(&self) -> u8 {
        let communication = if self.causes == 0 { 0 } else { COMMUNICATION };
        match self.device | communication {
            0 => 0,
            bits => bits | GENERIC,
        }
    }

    /// 1003h:0.
    pub(super) fn count(&self) -> u32 {
        u32::try_from(self.history.len()).unwrap_or(u32::MAX)
    }

    /// 1003h:`sub`, the newest is 1.
    pub(super) fn entry(&self, sub: u8) -> Option<u32> {
        let place = usize::from(sub).checked_sub(1)?;
        self.history.iter().nth(place).copied()
    }

    pub(super) fn clear_history(&mut self) {
        self.history.clear();
    }

    /// Takes an entry over from an image; the newest comes first.
    pub(super) fn recall(&mut self, entry: u32) {
        let _ = self.history.push_back(entry);
    }

    pub(super) const fn set_device(&mut self, register: u8) {
        self.device = register;
    }

    /// After power-on nothing is wrong yet.
    pub(super) fn restart(&mut self) {
        self.causes = 0;
        self.quiet();
    }

    /// What waits is not said any more.
    pub(super) fn quiet(&mut self) {
        self.waiting.clear();
        self.inhibited_until = Instant::ZERO;
    }

    /// When the next message may be sent, if one waits.
    pub(super) fn due(&self) -> Option<Instant> {
        if self.waiting.is_empty() { None } else { Some(self.inhibited_until) }
    }
}

impl Node {
    /// An event of the device, or its end.
    pub(super) fn emergency(&mut self, now: Instant, emergency: Emergency, app: &dyn Application) {
        self.errors.device = emergency.register;
        if emergency.in_history && emergency.code != 0 {
            self.record(u32::from(emergency.information) << 16 | u32::from(emergency.code));
        }
        self.say(now, emergency.code, emergency.octets, app);
    }

    /// A communication error begins. One that lasts is said once.
    pub(super) fn error_begins(&mut self, now: Instant, cause: Cause, code: u16, app: &dyn Application) {
        if self.errors.causes & cause.bit() == 0 {
            self.errors.causes |= cause.bit();
            self.record(code.into());
            self.say(now, code, [0; 5], app);
        }
    }

    /// A communication error ends; with the last error the code 0000h is sent.
    pub(super) fn error_ends(&mut self, now: Instant, cause: Cause, app: &dyn Application) {
        if self.errors.causes & cause.bit() != 0 {
            self.errors.causes &= !cause.bit();
            if self.errors.register() == 0 {
                self.say(now, 0, [0; 5], app);
            }
        }
    }

    /// Messages whose inhibit time is over.
    pub(super) fn emcy_timeout(&mut self, now: Instant, app: &dyn Application) {
        while self.errors.due().is_some_and(|due| due <= now) {
            let Some(message) = self.errors.waiting.pop_front() else { return };
            self.send_emcy(now, message, app);
        }
    }

    /// The bus was off and is back: of what waits only emergencies are not old.
    pub(crate) fn bus_is_back(&mut self) {
        for _ in 0..self.frames.len() {
            if let Some(frame) = self.frames.pop_front()
                && self.service_of(&frame) == Some(Service::Emcy)
            {
                let _ = self.frames.push_back(frame);
            }
        }
    }

    /// A frame could not be sent, as the bus is off. An emergency goes out when the bus is back.
    pub(crate) fn take_back(&mut self, frame: Frame) {
        if self.service_of(&frame) == Some(Service::Emcy) {
            let _ = self.frames.push_front(frame);
        }
    }

    fn record(&mut self, entry: u32) {
        if self.history_len == 0 {
            return;
        }
        while self.errors.history.len() >= self.history_len.min(MAX_HISTORY) {
            self.errors.history.pop_back();
        }
        let _ = self.errors.history.push_front(entry);
        if self.history_stored {
            self.storage.changed();
        }
    }

    /// Events of states without EMCY are not sent later (`canopen-link.md` 7).
    fn say(&mut self, now: Instant, code: u16, octets: [u8; 5], app: &dyn Application) {
        if !self.state.is_some_and(NmtState::serves_sdo) {
            return;
        }
        let message = Message { code, register: self.errors.register(), octets };
        if self.errors.waiting.is_empty() && self.errors.inhibited_until <= now {
            self.send_emcy(now, message, app);
        } else {
            let _ = self.errors.waiting.push_back(message);
        }
    }

    fn send_emcy(&mut self, now: Instant, message: Message, app: &dyn Application) {
        let Message { code, register, octets } = message;
        let inhibit = Duration::from_micros(u64::from(self.values.emcy_inhibit) * 100);
        self.errors.inhibited_until = now.saturating_add(inhibit);
        if let Some(id) = CobId(self.values.emcy_id).active() {
            let [first, second] =
                if self.policy.emcy_high_octet_first { code.to_be_bytes() } else { code.to_le_bytes() };
            let [a, b, c, d, e] = octets;
            self.send(Frame::with(id, [first, second, register, a, b, c, d, e]));
            self.tell(Event::Emergency { code, register, octets, names: app.error_names() });
        }
    }
}
