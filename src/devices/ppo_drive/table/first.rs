//! Another first value for one drive: several drives can have one table and differ in a few values.

use thiserror::Error;

use super::{Kind, Table, Tie};

/// Why a parameter cannot begin with a value.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FirstValueError {
    /// The table has no such parameter.
    #[error("there is no parameter {pnu}")]
    Unknown {
        /// Its number.
        pnu: u16,
    },
    /// The array has no such element.
    #[error("the array has the elements 1 to {count}, got {got:?}")]
    Element {
        /// Its elements.
        count: u8,
        /// What was named; `None`: no element.
        got: Option<u8>,
    },
    /// It is no array.
    #[error("it is no array: leave the element out")]
    NotAnArray,
    /// What it is tied to can only be read.
    #[error("what it is tied to can only be read")]
    ReadOnly,
    /// The value is outside its limits.
    #[error("{got} is outside {low} to {high} (min and max, as numbers on the bus)")]
    Outside {
        /// The smallest value.
        low: f64,
        /// The largest value.
        high: f64,
        /// The value.
        got: f64,
    },
    /// The parameter counts.
    #[error("{got} is no whole number, and {kind} counts: give the number on the bus")]
    NotWhole {
        /// What the parameter is.
        kind: Kind,
        /// The value.
        got: f64,
    },
}

impl Table {
    /// The element (from 1; `None` of a single value) of a parameter begins with this value, as a number on the bus, and
    /// not with its default. Also one that a master can only read, if it is tied to nothing.
    ///
    /// # Errors
    /// [`FirstValueError`]; nothing is changed then.
    pub(crate) fn begin_with(
        &mut self,
        pnu: u16,
        element: Option<u8>,
        value: f64,
    ) -> Result<(), FirstValueError> {
        let (row, kept) = self.rows.get_mut(&pnu).ok_or(FirstValueError::Unknown { pnu })?;
        let place = match (row.elements, element) {
            (None, None) => 0,
            (None, Some(_)) => return Err(FirstValueError::NotAnArray),
            (Some(count), Some(got)) if (1..=count).contains(&got) => usize::from(got) - 1,
            (Some(count), got) => return Err(FirstValueError::Element { count, got }),
        };
        if row.tie != Tie::None && !row.tie.is_settable() {
            return Err(FirstValueError::ReadOnly);
        }
        if !(row.low..=row.high).contains(&value) {
            return Err(FirstValueError::Outside { low: row.low, high: row.high, got: value });
        }
        if row.kind != Kind::Float && value.fract() != 0.0 {
            return Err(FirstValueError::NotWhole { kind: row.kind, got: value });
        }
        let bits = row.kind.bits(value);
        kept.iter_mut().skip(place).take(1).for_each(|kept| *kept = bits);
        let defaults = row.default.get_or_insert_with(|| vec![0.0; usize::from(row.elements.unwrap_or(1))]);
        defaults.iter_mut().skip(place).take(1).for_each(|default| *default = value);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Fields, Row};
    use super::*;
    use crate::devices::ppo_drive::{Drive, Quantity, Settings};

    fn table() -> Table {
        let row = |fields: &[(&str, &str)]| Row::of(&Fields::new(1, fields.iter().copied())).unwrap();
        let ramp =
            [("pnu", "2"), ("name", "ramp"), ("type", "uint16"), ("scale", "0.1"), ("tie", "ramp-up-time")];
        let fixed = [("pnu", "30"), ("name", "fixed"), ("type", "int32"), ("elements", "3"), ("max", "9")];
        let shown = [("pnu", "10"), ("name", "speed"), ("type", "int16"), ("tie", "actual-speed")];
        let kind = [("pnu", "11"), ("name", "kind"), ("type", "uint16"), ("access", "r")];
        Table::new([row(&ramp), row(&fixed), row(&shown), row(&kind)]).unwrap()
    }

    #[test]
    fn a_drive_begins_with_its_own_values() {
        let mut table = table();
        table.begin_with(2, None, 5.0).unwrap();
        table.begin_with(30, Some(3), -7.0).unwrap();
        table.begin_with(11, None, 42.0).unwrap();
        let mut drive = Drive::new(Settings::DEFAULT);
        table.set_up(&mut drive).unwrap();
        assert!((drive.quantity(Quantity::RampUp, 1) - 0.5).abs() < 1e-9);
        assert_eq!((table.kept(30, 2), table.kept(30, 0)), (Some((-7_i32).cast_unsigned()), Some(0)));
        assert_eq!(table.kept(11, 0), Some(42));
    }

    #[test]
    fn what_a_parameter_cannot_begin_with_is_told() {
        let mut table = table();
        let refused = [
            (1, None, 0.0, FirstValueError::Unknown { pnu: 1 }),
            (2, Some(1), 0.0, FirstValueError::NotAnArray),
            (2, None, 65536.0, FirstValueError::Outside { low: 0.0, high: 65535.0, got: 65536.0 }),
            (2, None, 0.5, FirstValueError::NotWhole { kind: Kind::Uint16, got: 0.5 }),
            (30, None, 0.0, FirstValueError::Element { count: 3, got: None }),
            (30, Some(4), 0.0, FirstValueError::Element { count: 3, got: Some(4) }),
            (10, None, 0.0, FirstValueError::ReadOnly),
        ];
        for (pnu, element, value, error) in refused {
            assert_eq!(table.begin_with(pnu, element, value), Err(error), "{error}");
        }
        assert!(table.begin_with(2, None, f64::NAN).is_err());
        assert_eq!(table.kept(2, 0), Some(0));
    }
}
