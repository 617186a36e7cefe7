//! Points on which a manual contradicts itself or leaves a choice, as tables: one form for every device.

use thiserror::Error;

/// One such point in the configuration `C` of a device.
#[derive(Clone, Copy, Debug)]
pub struct Quirk<C> {
    /// Its name in `NAME=VALUE`.
    pub name: &'static str,
    /// Where the reference of the device discusses it.
    pub register: &'static str,
    /// What it decides.
    pub about: &'static str,
    /// What it may be; the first is the default.
    pub values: &'static [&'static str],
    /// Chooses the value of this index.
    pub(crate) choose: fn(&mut C, usize),
}

/// A quirk that cannot be set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum QuirkError {
    /// No quirk has this name.
    #[error("there is no such quirk")]
    Unknown,
    /// The quirk has no such value.
    #[error("quirk {name} has no such value")]
    Value {
        /// The quirk.
        name: &'static str,
        /// The values it has.
        values: &'static [&'static str],
    },
}

impl<C> Quirk<C> {
    /// Sets a quirk of a table by its name.
    ///
    /// # Errors
    /// [`QuirkError`] if there is no such quirk or value; nothing is changed then.
    pub(crate) fn set(table: &[Self], config: &mut C, name: &str, value: &str) -> Result<(), QuirkError> {
        let quirk = table.iter().find(|quirk| quirk.name == name).ok_or(QuirkError::Unknown)?;
        let Self { name, values, choose, .. } = *quirk;
        let index = values.iter().position(|known| *known == value);
        choose(config, index.ok_or(QuirkError::Value { name, values })?);
        Ok(())
    }
}

/// Every value of every quirk makes another configuration, the first the default, whatever was chosen before.
#[cfg(test)]
#[track_caller]
pub(crate) fn check<C: Copy + core::fmt::Debug + PartialEq>(table: &[Quirk<C>], default: C) {
    for (place, quirk) in table.iter().enumerate() {
        let name = quirk.name;
        assert!(table.iter().skip(place + 1).all(|other| other.name != name), "{name} twice");
        let mut configs = std::vec::Vec::new();
        for value in quirk.values {
            let mut config = default;
            Quirk::set(table, &mut config, name, value).unwrap();
            assert!(!configs.contains(&config), "{name}={value}");
            configs.push(config);
        }
        assert_eq!(configs[0], default, "{name}");
        let mut back = configs[1];
        Quirk::set(table, &mut back, name, quirk.values[0]).unwrap();
        assert_eq!(back, default, "{name}");
        let mut config = default;
        let refused = Err(QuirkError::Value { name, values: quirk.values });
        assert_eq!(Quirk::set(table, &mut config, name, "no such value"), refused);
        assert_eq!(
            Quirk::set(table, &mut config, "no-such-quirk", quirk.values[0]),
            Err(QuirkError::Unknown)
        );
        assert_eq!(config, default);
    }
}
