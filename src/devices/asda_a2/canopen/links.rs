//! Which setting of the drive an object is: the names in the rows of the settings, by their places.

use crate::can_bus::canopen::Address;
use crate::devices::asda_a2::on_canopen::Name;
use crate::devices::asda_a2::{Level, Setting, Settings};

/// A setting by one of its names.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    pub(super) setting: Setting,
    pub(super) name: Name,
}

/// The links of both levels, sorted by place.
pub(super) static LINKS: [Link; count()] = links();

impl Link {
    /// The link of an object.
    pub(super) fn of(level: Level, at: Address) -> Option<&'static Self> {
        let first = LINKS.partition_point(|link| link.name.object.at < at.pair());
        let from = LINKS.get(first..)?;
        from.iter().take_while(|link| link.name.object.at == at.pair()).find(|link| link.name.is_of(level))
    }

    /// Whether it is an object of its own in a level; the others are in an array or a record.
    pub(super) const fn is_alone(&self, level: Level) -> bool {
        self.name.object.at.1 == 0 && self.name.is_of(level)
    }

    /// The value of the object.
    pub(super) fn read(&self, settings: &Settings) -> i64 {
        self.name.form.of_setting(settings.of(self.setting))
    }

    /// The setting after `value` was written to the object.
    pub(super) fn write(&self, settings: &Settings, value: i64) -> i64 {
        self.name.form.to_setting(settings.of(self.setting), value)
    }

    /// What [`accepts`](Self::accepts) looks at, as the end of "1 was written, but".
    pub(super) fn needs(&self) -> Option<&'static str> {
        self.name.digits.map(|digits| digits.must)
    }

    /// Whether the digits of the value can be written.
    pub(super) fn accepts(&self, settings: &Settings, value: i64) -> bool {
        self.name.digits.is_none_or(|digits| digits.take(self.write(settings, value)))
    }
}

#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn count() -> usize {
    let (mut count, mut row) = (0, 0);
    while row < Setting::ALL.len() {
        count += Setting::ALL[row].names().len();
        row += 1;
    }
    count
}

#[expect(clippy::indexing_slicing, reason = "runs in the compiler only")]
const fn links<const N: usize>() -> [Link; N] {
    let first = Setting::ALL[0];
    let mut links = [Link { setting: first, name: first.names()[0] }; N];
    let (mut count, mut row) = (0, 0);
    while row < Setting::ALL.len() {
        let setting = Setting::ALL[row];
        let mut names = setting.names();
        while let [name, rest @ ..] = names {
            let mut place = count;
            while place > 0 && key(&links[place - 1].name) > key(name) {
                links[place] = links[place - 1];
                place -= 1;
            }
            links[place] = Link { setting, name: *name };
            count += 1;
            names = rest;
        }
        row += 1;
    }
    links
}

/// What the links are sorted by.
const fn key(name: &Name) -> u32 {
    let (index, sub) = name.object.at;
    (index as u32) << 8 | sub as u32
}
