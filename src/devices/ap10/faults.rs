//! Battery and speed: what is wrong now, what waits for a person, and what happened (manual 4.2, 4.4, 4.5.3).

#![expect(clippy::use_self, reason = "in what the macro `bitflags` writes")]

use core::fmt;

use enumflags2::{BitFlags, bitflags};
use heapless::Vec;

/// What can go wrong.
#[bitflags]
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fault {
    /// The battery is to be replaced: a warning.
    BatteryCritical,
    /// The battery does not keep the count any more.
    BatteryEmpty,
    /// The shaft turned too fast to be counted.
    Speed,
}

impl Fault {
    /// Every fault.
    pub const ALL: [Self; 3] = [Self::BatteryCritical, Self::BatteryEmpty, Self::Speed];

    /// Its name in commands.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::BatteryCritical => "battery-critical",
            Self::BatteryEmpty => "battery-empty",
            Self::Speed => "speed",
        }
    }

    /// What it is.
    pub(crate) const fn text(self) -> &'static str {
        match self {
            Self::BatteryCritical => "battery critical",
            Self::BatteryEmpty => "battery empty",
            Self::Speed => "speed too high",
        }
    }

    /// The fault with that name.
    pub(crate) fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|fault| fault.name() == name)
    }

    /// Its name on the display.
    pub(super) const fn shown(self) -> &'static str {
        match self {
            Self::BatteryCritical => "LoBAT",
            Self::BatteryEmpty => "BAT",
            Self::Speed => "SPEED",
        }
    }

    /// Whether a person has to acknowledge it; a warning ends by itself.
    const fn is_error(self) -> bool {
        match self {
            Self::BatteryCritical => false,
            Self::BatteryEmpty | Self::Speed => true,
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text())
    }
}

/// What is left of the battery.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Battery {
    /// Enough.
    Good,
    /// To be replaced within three months.
    Critical,
    /// Too little.
    Empty,
}

/// All faults.
#[derive(Clone, Debug, Default)]
pub(super) struct Faults {
    present: BitFlags<Fault>,
    /// Errors nobody acknowledged, gone or not.
    unread: BitFlags<Fault>,
    log: Vec<Logged, { Fault::ALL.len() }>,
}

/// A kind of error and how often it came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Logged {
    pub(super) fault: Fault,
    pub(super) count: u16,
}

impl Faults {
    /// A fault begins. Says whether it is new. There is one battery: its two faults end each other.
    pub(super) fn begin(&mut self, fault: Fault) -> bool {
        if self.has(fault) {
            return false;
        }
        match fault {
            Fault::BatteryCritical => self.present.remove(Fault::BatteryEmpty),
            Fault::BatteryEmpty => self.present.remove(Fault::BatteryCritical),
            Fault::Speed => {}
        }
        self.present |= fault;
        if fault.is_error() {
            self.unread |= fault;
        }
        let before = self.log.iter().position(|logged| logged.fault == fault);
        let count = before.map_or(0, |place| self.log.remove(place).count).saturating_add(1);
        let _ = self.log.insert(0, Logged { fault, count });
        true
    }

    /// The cause of a fault is gone. Says whether it was there.
    pub(super) fn end(&mut self, fault: Fault) -> bool {
        let was = self.has(fault);
        self.present.remove(fault);
        was
    }

    pub(super) fn has(&self, fault: Fault) -> bool {
        self.present.contains(fault)
    }

    pub(super) fn any(&self) -> bool {
        !self.present.is_empty()
    }

    pub(super) fn battery(&self) -> Battery {
        if self.has(Fault::BatteryEmpty) {
            Battery::Empty
        } else if self.has(Fault::BatteryCritical) {
            Battery::Critical
        } else {
            Battery::Good
        }
    }

    /// What the battery's state and the display keep without supply: bits of faults present, of errors unread. What turns
    /// the shaft too fast does not outlast it.
    pub(super) fn kept(&self) -> [u8; 2] {
        [self.present & !Fault::Speed, self.unread].map(BitFlags::bits)
    }

    /// Takes over what was kept; bits of no fault are left out.
    pub(super) fn recall(&mut self, [present, unread]: [u8; 2]) {
        for fault in BitFlags::from_bits_truncate(present) {
            self.begin(fault);
        }
        self.unread =
            BitFlags::from_bits_truncate(unread).iter().filter(|fault: &Fault| fault.is_error()).collect();
    }

    /// Whether an error is on the display.
    pub(super) fn is_unread(&self, fault: Fault) -> bool {
        self.unread.contains(fault)
    }

    /// Whether the position may be wrong: an error is there or nobody acknowledged it.
    pub(super) fn is_position_invalid(&self) -> bool {
        (self.present | self.unread).intersects(Fault::BatteryEmpty | Fault::Speed)
    }

    pub(super) fn any_unread(&self) -> bool {
        !self.unread.is_empty()
    }

    /// A person acknowledges: errors whose cause is gone leave the display.
    pub(super) fn acknowledge(&mut self) {
        self.unread &= self.present;
    }

    /// What happened, the newest first.
    pub(super) fn log(&self) -> &[Logged] {
        &self.log
    }
}
