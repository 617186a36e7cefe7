//! The three keys (manual 3.4). Which picture is which key is reconstructed (CN-104).

use core::time::Duration;

use super::indicator::{Event, Indicator};
use super::menu::{Choice, Menu};
use super::set_point::Slot;
use super::settings::{Mode, Setting};
use crate::time::Instant;

/// A key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Key {
    /// Incremental measurement; takes the new number of Auto-ID; chooses a digit.
    Left,
    /// Calibrates; acknowledges an error; changes a value.
    Up,
    /// Shows number and rate; held it opens the menu; confirms.
    Star,
}

impl Key {
    /// Every key.
    pub const ALL: [Self; 3] = [Self::Left, Self::Up, Self::Star];

    /// Its name in commands.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Up => "up",
            Self::Star => "star",
        }
    }

    /// The key with that name.
    pub(crate) fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|key| key.name() == name)
    }
}

/// Which keys are down.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pressed {
    pub(super) left: bool,
    pub(super) up: bool,
    pub(super) star: bool,
    /// The star key shows number and rate since then.
    pub(super) star_since: Option<Instant>,
}

impl Pressed {
    fn set(&mut self, key: Key, down: bool) -> bool {
        let place = match key {
            Key::Left => &mut self.left,
            Key::Up => &mut self.up,
            Key::Star => &mut self.star,
        };
        core::mem::replace(place, down) != down
    }
}

impl Indicator {
    /// A key goes down. It acts at once; a second press of a key that is down does nothing.
    pub(crate) fn press(&mut self, now: Instant, key: Key) {
        if !self.pressed.set(key, true) {
            return;
        }
        if let Some(number) = self.auto_id {
            if key == Key::Left {
                self.auto_id = None;
                self.tell(Event::AutoId(number));
            }
        } else if let Some(menu) = self.menu.take() {
            let (menu, choice) = menu.key(key, self.faults.log().len());
            self.menu = menu;
            if let Some(choice) = choice {
                self.choose(choice);
            }
        } else {
            match key {
                Key::Left => self.left(),
                Key::Up => self.up(),
                Key::Star => self.star(now),
            }
        }
        self.watch();
    }

    /// A key goes up.
    pub(crate) fn release(&mut self, key: Key) {
        self.pressed.set(key, false);
        if key == Key::Star {
            self.pressed.star_since = None;
        }
    }

    /// When the star key opens the menu.
    pub(super) fn menu_due(&self) -> Option<Instant> {
        if self.menu.is_some() || self.auto_id.is_some() || !self.settings.is_on(Setting::ConfigurationByKey)
        {
            return None;
        }
        let seconds = self.settings.value(Setting::KeyEnableTime).unsigned_abs();
        Some(self.pressed.star_since?.saturating_add(Duration::from_secs(seconds.into())))
    }

    fn left(&mut self) {
        match (self.settings.mode(), self.acknowledges_one_by_one()) {
            (Mode::Alphanumeric, true) => self.set_point_mut(Slot::Two).acknowledge(),
            (Mode::Alphanumeric, false) => {}
            (Mode::Absolute | Mode::Difference | Mode::Modulo, _) => {
                if self.settings.is_on(Setting::IncrementalByKey) {
                    self.encoder.toggle_incremental();
                }
            }
        }
    }

    fn up(&mut self) {
        if self.faults.any_unread() {
            self.faults.acknowledge();
            return;
        }
        match (self.settings.mode(), self.acknowledges_one_by_one()) {
            (Mode::Alphanumeric, true) => self.set_point_mut(Slot::One).acknowledge(),
            (Mode::Alphanumeric, false) | (Mode::Absolute | Mode::Difference | Mode::Modulo, _) => {
                if self.settings.is_on(Setting::CalibrationByKey) {
                    self.calibrate();
                }
            }
        }
    }

    fn star(&mut self, now: Instant) {
        self.pressed.star_since = Some(now);
        if self.settings.mode() == Mode::Alphanumeric && !self.acknowledges_one_by_one() {
            for slot in Slot::ALL {
                if self.set_point(slot).is_pending() {
                    self.set_point_mut(slot).acknowledge();
                }
            }
        }
    }

    /// Up acknowledges set point 1 and left set point 2, the rows from above (which one is not stated).
    fn acknowledges_one_by_one(&self) -> bool {
        self.settings.value(Setting::AcknowledgeKey) == 2
    }

    fn choose(&mut self, choice: Choice) {
        match choice {
            Choice::NodeId(number) => self.choose_setting(Setting::NodeId, number),
            Choice::Rate(number) => self.choose_setting(Setting::BaudRate, number),
            Choice::Restore(restore) => self.tell(Event::Restore(restore)),
        }
    }

    fn choose_setting(&mut self, setting: Setting, value: i32) {
        if value != self.settings.value(setting) && self.settings.set(setting, value) {
            self.tell(Event::Chosen(setting));
        }
    }

    /// The star key was held long enough.
    pub(super) fn open_menu(&mut self) {
        self.pressed.star_since = None;
        self.menu = Some(Menu::open(&self.settings));
    }
}
