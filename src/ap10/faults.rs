//! Battery and speed: what is wrong now, what waits for a person, and what happened (manual 4.2, 4.4, 4.5.3).

use core::fmt;

use heapless::Vec;

/// What can go wrong.
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
    pub const fn name(self) -> &'static str {
        match self {
            Self::BatteryCritical => "battery-critical",
            Self::BatteryEmpty => "battery-empty",
            Self::Speed => "speed",
        }
    }

    /// What it is.
    pub const fn text(self) -> &'static str {
        match self {
            Self::BatteryCritical => "battery critical",
            Self::BatteryEmpty => "battery empty",
            Self::Speed => "speed too high",
        }
    }

    /// The fault with that name.
    pub fn from_name(name: &str) -> Option<Self> {
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

    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text())
    }
}

/// What is left of the battery.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Battery {
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
    present: u8,
    /// Errors nobody acknowledged, gone or not.
    unread: u8,
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
            Fault::BatteryCritical => self.present &= !Fault::BatteryEmpty.bit(),
            Fault::BatteryEmpty => self.present &= !Fault::BatteryCritical.bit(),
            Fault::Speed => {}
        }
        self.present |= fault.bit();
        if fault.is_error() {
            self.unread |= fault.bit();
        }
        let before = self.log.iter().position(|logged| logged.fault == fault);
        let count = before.map_or(0, |place| self.log.remove(place).count).saturating_add(1);
        let _ = self.log.insert(0, Logged { fault, count });
        true
    }

    /// The cause of a fault is gone. Says whether it was there.
    pub(super) const fn end(&mut self, fault: Fault) -> bool {
        let was = self.has(fault);
        self.present &= !fault.bit();
        was
    }

    pub(super) const fn has(&self, fault: Fault) -> bool {
        self.present & fault.bit() != 0
    }

    pub(super) const fn any(&self) -> bool {
        self.present != 0
    }

    pub(super) const fn battery(&self) -> Battery {
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
    pub(super) const fn kept(&self) -> [u8; 2] {
        [self.present & !Fault::Speed.bit(), self.unread]
    }

    /// Takes over what was kept; bits of no fault are left out.
    pub(super) fn recall(&mut self, [present, unread]: [u8; 2]) {
        let known = |bits: u8, fault: &Fault| bits & fault.bit() != 0;
        for fault in Fault::ALL.into_iter().filter(|fault| known(present, fault)) {
            self.begin(fault);
        }
        self.unread = 0;
        for fault in Fault::ALL.into_iter().filter(|fault| fault.is_error() && known(unread, fault)) {
            self.unread |= fault.bit();
        }
    }

    /// Whether an error is on the display.
    pub(super) const fn is_unread(&self, fault: Fault) -> bool {
        self.unread & fault.bit() != 0
    }

    /// Whether the position may be wrong: an error is there or nobody acknowledged it.
    pub(super) const fn is_position_invalid(&self) -> bool {
        (self.present | self.unread) & (Fault::BatteryEmpty.bit() | Fault::Speed.bit()) != 0
    }

    pub(super) const fn any_unread(&self) -> bool {
        self.unread != 0
    }

    /// A person acknowledges: errors whose cause is gone leave the display.
    pub(super) const fn acknowledge(&mut self) {
        self.unread &= self.present;
    }

    /// What happened, the newest first.
    pub(super) fn log(&self) -> &[Logged] {
        &self.log
    }
}
