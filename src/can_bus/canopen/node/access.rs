//! How a node reads and writes an entry, whoever keeps it: the order of checks, and the code of each refusal.
//!
//! ```text
//! object exists ─▶ sub-index exists ─▶ access ─▶ [state] ─▶ length ─▶ range ─▶ state ─▶ who keeps it
//! 06020000h        06090011h           0601000xh            0607001xh 0609003xh 08000022h  his own checks
//! ```

use super::Node;
use crate::can_bus::canopen::abort::Abort;
use crate::can_bus::canopen::address::Address;
use crate::can_bus::canopen::application::{Application, Part, Source, Written};
use crate::can_bus::canopen::dictionary::{self, Entry, Home, Limits, Place, Writable};
use crate::can_bus::canopen::event::Event;
use crate::can_bus::canopen::nmt::NmtState;
use crate::can_bus::canopen::parameter::Parameter;
use crate::can_bus::canopen::policy::{OutOfRange, Policy, StateCheck, WrongLength};
use crate::can_bus::canopen::refusal::{Broken, Change, Refusal, Rule};
use crate::can_bus::canopen::value::{DataType, Value};
use crate::time::Instant;

impl Node {
    /// The entry at an address.
    pub(super) fn entry(&self, at: Address) -> Result<&'static Entry, Abort> {
        dictionary::entry(self.objects, at)
    }

    /// Reads an entry as a client does and calls `take` with its octets. What is off has no entries before its first start.
    ///
    /// # Errors
    /// The abort code that a client would get, or that of `take`.
    pub fn read_with<R>(
        &self,
        at: Address,
        app: &dyn Application,
        take: impl FnOnce(&[u8]) -> Result<R, Abort>,
    ) -> Result<R, Abort> {
        let entry = self.entry(at)?;
        if !entry.readable() {
            return Err(Abort::WRITE_ONLY);
        }
        self.value_with(at, entry, app, take)
    }

    /// Reads an entry whatever a client may do.
    pub(super) fn value_with<R>(
        &self,
        at: Address,
        entry: &'static Entry,
        app: &dyn Application,
        take: impl FnOnce(&[u8]) -> Result<R, Abort>,
    ) -> Result<R, Abort> {
        match entry.home {
            Home::Default => entry.default_value(self.node_id).with_octets(take),
            Home::Node => {
                let parameter = Parameter::of(at).ok_or(Abort::INTERNAL)?;
                let number = self.parameter(parameter)?;
                Value::whole(entry.data, number.into()).ok_or(Abort::INTERNAL)?.with_octets(take)
            }
            Home::Application => {
                let value = app.read(at)?;
                value.with_octets(|octets| match entry.data.octets() {
                    Some(len) if len != octets.len() => Err(Abort::INTERNAL),
                    Some(_) | None => take(octets),
                })
            }
            Home::Alias(to) => {
                let target = self.entry(to)?;
                match target.home {
                    // One step only: tables cannot make a circle.
                    Home::Alias(_) => Err(Abort::INTERNAL),
                    Home::Default | Home::Node | Home::Application => self.value_with(to, target, app, take),
                }
            }
        }
    }

    /// Writes an entry as a client does, while no client waits for an answer: somebody who has the device in front of him. What
    /// a client waits for goes on. Counts as a `handle_*` call.
    ///
    /// # Errors
    /// What a client would be told; nothing is changed then.
    pub fn write_without_bus(
        &mut self,
        now: Instant,
        at: Address,
        octets: &[u8],
        app: &mut dyn Application,
    ) -> Result<(), Refusal> {
        let written = self.write_unanswered(now, at, octets, Source::Sdo, app);
        let _nobody_waits = written.map_err(|broken| self.refusal_of_write(at, broken, octets, app))?;
        self.handle_change(now, app);
        Ok(())
    }

    /// Writes an entry as a client does. A refused write changes nothing.
    pub(super) fn write(
        &mut self,
        now: Instant,
        at: Address,
        octets: &[u8],
        source: Source,
        app: &mut dyn Application,
    ) -> Result<Written, Broken> {
        let before = self.generation();
        let written = self.write_unanswered(now, at, octets, source, app)?;
        Ok(self.hold(before, written))
    }

    /// Writes a part of a long value as a client does.
    pub(super) fn write_part(
        &mut self,
        now: Instant,
        at: Address,
        part: Part<'_>,
        app: &mut dyn Application,
    ) -> Result<Written, Broken> {
        let before = self.generation();
        let entry = self.entry(at)?;
        if part.last {
            self.judge_state(entry)?;
        }
        let written = app.write_part(now, at, part)?;
        if !part.last {
            return Ok(written);
        }
        self.note_written(entry.stored);
        self.tell(Event::Written(Change::new(at, Some(entry), part.octets, "")));
        Ok(self.hold(before, written))
    }

    fn write_unanswered(
        &mut self,
        now: Instant,
        at: Address,
        octets: &[u8],
        source: Source,
        app: &mut dyn Application,
    ) -> Result<Written, Broken> {
        let entry = self.entry(at)?;
        if !entry.is_writable() {
            return Err(Abort::READ_ONLY.into());
        }
        self.judge(entry, octets)?;
        let written = match entry.home {
            Home::Alias(to) => {
                let target = self.entry(to)?;
                if !target.is_writable() {
                    return Err(Abort::READ_ONLY.into());
                }
                self.judge(target, octets)?;
                self.write_home(now, to, target, octets, source, app)?
            }
            Home::Default | Home::Node | Home::Application => {
                self.write_home(now, at, entry, octets, source, app)?
            }
        };
        self.sdo_wrote(at, octets);
        let unit = unit(Some(entry), at, app);
        self.tell(Event::Written(Change::new(at, Some(entry), octets, unit)));
        Ok(written)
    }

    /// Writes an entry that passed the checks of its table.
    pub(super) fn write_home(
        &mut self,
        now: Instant,
        at: Address,
        entry: &'static Entry,
        octets: &[u8],
        source: Source,
        app: &mut dyn Application,
    ) -> Result<Written, Broken> {
        let value = entry.data.decode(octets).ok_or(Abort::INTERNAL)?;
        match entry.home {
            Home::Application => {
                let written = app.write(now, at, value, source);
                let written = written.map_err(|code| Broken { code, rule: app.rule(at, value) })?;
                self.note_written(entry.stored);
                Ok(written)
            }
            Home::Node => {
                let parameter = Parameter::of(at).ok_or(Abort::INTERNAL)?;
                let number = value.number().and_then(|number| u32::try_from(number).ok());
                let written =
                    self.write_parameter(now, parameter, entry, number.ok_or(Abort::INTERNAL)?, app);
                written
                    .map_err(|broken| Broken { rule: broken.rule.or_else(|| app.rule(at, value)), ..broken })
            }
            // Tables with such an entry are faulty: there is nobody to take the value.
            Home::Default | Home::Alias(_) => Err(Abort::INTERNAL.into()),
        }
    }

    /// What to tell of a write that was refused.
    pub(super) fn refusal_of_write(
        &self,
        at: Address,
        broken: Broken,
        octets: &[u8],
        app: &dyn Application,
    ) -> Refusal {
        let entry = self.entry(at).ok();
        Refusal::broken(at, broken, entry, octets, unit(entry, at, app))
    }

    fn judge(&self, entry: &'static Entry, octets: &[u8]) -> Result<(), Broken> {
        if self.policy.state_check == StateCheck::BeforeLength {
            self.judge_state(entry)?;
        }
        self.judge_length(entry, octets.len())?;
        if entry.data == DataType::Boolean && octets.iter().any(|octet| *octet > 1) {
            let rule = Rule::Limits(Limits::Range(0, 1));
            return Err(Broken::rule(self.policy.refusal(Place::Above), rule));
        }
        if let Some(value) = entry.data.decode(octets) {
            self.policy.judge_range(entry, value)?;
        }
        self.judge_state(entry)
    }

    pub(super) fn judge_length(&self, entry: &'static Entry, len: usize) -> Result<(), Broken> {
        let (fewest, most) = entry.lengths();
        let broken = |code| Broken::rule(code, Rule::Length(fewest, most));
        if len > most {
            Err(broken(self.policy.too_long()))
        } else if len < fewest {
            Err(broken(self.policy.too_short()))
        } else {
            Ok(())
        }
    }

    fn judge_state(&self, entry: &'static Entry) -> Result<(), Broken> {
        const EXPECTED: NmtState = NmtState::PreOperational;
        let code = self.policy.wrong_state;
        match (entry.writable, self.state) {
            (Writable::Always, _) | (Writable::PreOperational, Some(EXPECTED)) => Ok(()),
            (Writable::PreOperational, Some(state)) => Err(Broken::rule(code, Rule::State(EXPECTED, state))),
            (Writable::PreOperational, None) => Err(code.into()),
        }
    }
}

impl Policy {
    pub(super) const fn too_long(&self) -> Abort {
        match self.wrong_length {
            WrongLength::TooLongTooShort => Abort::TOO_LONG,
            WrongLength::One(code) => code,
        }
    }

    pub(super) const fn too_short(&self) -> Abort {
        match self.wrong_length {
            WrongLength::TooLongTooShort => Abort::TOO_SHORT,
            WrongLength::One(code) => code,
        }
    }

    pub(super) fn judge_range(&self, entry: &'static Entry, value: Value<'_>) -> Result<(), Broken> {
        match entry.place(value) {
            Place::Inside => Ok(()),
            place @ (Place::Below | Place::Above | Place::Gap) => {
                Err(Broken::rule(self.refusal(place), Rule::Limits(entry.limits)))
            }
        }
    }

    /// The answer to a value at that place.
    const fn refusal(&self, place: Place) -> Abort {
        match (place, self.out_of_range) {
            (_, OutOfRange::One(code)) => code,
            (Place::Below, OutOfRange::TooHighTooLow) => Abort::TOO_LOW,
            (Place::Above, OutOfRange::TooHighTooLow) => Abort::TOO_HIGH,
            (Place::Gap | Place::Inside, OutOfRange::TooHighTooLow) => Abort::RANGE,
        }
    }
}

/// What a number in an entry counts; empty if nothing is known.
fn unit(entry: Option<&Entry>, at: Address, app: &dyn Application) -> &'static str {
    match entry.map(|entry| entry.home) {
        Some(Home::Application) => app.unit(at),
        Some(Home::Alias(to)) => app.unit(to),
        Some(Home::Default | Home::Node) | None => "",
    }
}
