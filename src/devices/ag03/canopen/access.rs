//! What reads and writes of objects do to the device (`canopen-ag03.md` 11, 12).

use super::objects::{objects, parameter, reading};
use super::part::Part;
use super::words::ControlWord;
use crate::can_bus::canopen::dictionary::Limits;
use crate::can_bus::canopen::{
    Abort, Address, Application, ErrorNames, NmtState, NodeId, Notice, Object, Request, Rule, Source, Sub,
    Value, Written, dictionary,
};
use crate::devices::ag03::drive::Fault;
use crate::devices::ag03::param::{DefaultSet, NotNow, ParamError, Parameter, Unit, Write};
use crate::devices::ag03::profibus::words::general_status;
use crate::time::Instant;

use super::errors;

impl Application for Part {
    fn objects(&self) -> &'static [Object] {
        objects(self.unit.parameters().gear())
    }

    fn error_names(&self) -> &'static ErrorNames {
        &super::vocabulary::ERRORS
    }

    fn node_id(&self) -> NodeId {
        self.node_id
    }

    fn read(&self, at: Address) -> Result<Value<'_>, Abort> {
        // What the TPDOs carry needs no look into the dictionary.
        match at.pair() {
            (0x6041, 0) => return Ok(Value::U16(self.status_word())),
            (0x6064, 0) => return Ok(Value::I32(self.unit.status().position)),
            (0x606C, 0) => return Ok(Value::I32(self.unit.status().velocity)),
            (0.., 0..) => {}
        }
        let number = self.number(at)?;
        let data = dictionary::entry(self.objects(), at)?.data;
        Value::whole(data, number).ok_or(Abort::INTERNAL)
    }

    fn write(
        &mut self,
        _now: Instant,
        at: Address,
        value: Value<'_>,
        source: Source,
    ) -> Result<Written, Abort> {
        let number = value.number().and_then(|number| i32::try_from(number).ok()).ok_or(Abort::RANGE)?;
        match (at.pair(), source) {
            ((0x2100, 0), Source::Sdo | Source::Rpdo(_) | Source::Image) => {
                let rate = u8::try_from(number).map_err(|_| Abort::RANGE)?;
                let before = core::mem::replace(&mut self.rate, rate);
                if source != Source::Image {
                    self.rate_before.get_or_insert(before);
                }
            }
            // The unit has the others in its own image.
            (_, Source::Image) => {}
            ((0x6040, 0), Source::Sdo | Source::Rpdo(_)) => {
                if self.nmt != Some(NmtState::Operational) {
                    return Err(Abort::DEVICE_STATE);
                }
                let [low, high, ..] = number.to_le_bytes();
                let word = ControlWord(u16::from_le_bytes([low, high]));
                match source {
                    Source::Rpdo(_) => self.received = Some(word),
                    Source::Sdo | Source::Image => {
                        self.on_word(word);
                        self.look_at_target(true);
                    }
                }
            }
            ((0x607A, 0), Source::Sdo | Source::Rpdo(_)) => self.target = number,
            ((0x60FF, 0), Source::Sdo | Source::Rpdo(_)) => {
                let most = i32::from(self.unit.parameters().gear().max_rpm());
                self.velocity = number.clamp(-most, most);
                if source == Source::Sdo {
                    self.evaluate();
                }
            }
            ((0x1003, 0), Source::Sdo | Source::Rpdo(_)) => {
                self.execute(Write::ClearFaults)?;
                self.faults = self.unit.drive().faults().count();
            }
            ((0x6060, 0), Source::Sdo | Source::Rpdo(_)) => {
                let context = self.unit.write_context();
                if context.moving || context.job_active {
                    return Err(Abort::DEVICE_STATE);
                }
                self.execute(Write::Set(Parameter::OperatingMode, mode(number)))?;
            }
            (pair, Source::Sdo | Source::Rpdo(_)) => {
                let parameter = parameter(pair).ok_or(Abort::INTERNAL)?;
                self.judge_limits(parameter, number)?;
                self.execute(Write::Set(parameter, number))?;
            }
        }
        Ok(Written::Done)
    }

    fn rule(&self, at: Address, value: Value<'_>) -> Option<Rule> {
        let number = i32::try_from(value.number()?).ok()?;
        let context = self.unit.write_context();
        match at.pair() {
            (0x6040, 0) => self.nmt.map(|state| Rule::State(NmtState::Operational, state)),
            (0x6060, 0) if context.moving => Some(Rule::But(NotNow::Moving.words())),
            (0x6060, 0) => context.job_active.then(|| Rule::But(NotNow::JobActive.words())),
            (0x1011, group) => self.rule_of(load(group)?),
            pair @ (0.., 0..) => {
                let parameter = parameter(pair)?;
                let limit = |of| i64::from(self.unit.parameters().value(of));
                match (parameter, self.judge_limits(parameter, number)) {
                    (Parameter::Limit1, Err(_)) => Some(Rule::AtLeast(limit(Parameter::Limit2), LIMIT_2)),
                    (Parameter::Limit2, Err(_)) => Some(Rule::AtMost(limit(Parameter::Limit1), LIMIT_1)),
                    (parameter, Ok(()) | Err(_)) => self.rule_of(Write::Set(parameter, number)),
                }
            }
        }
    }

    fn unit(&self, at: Address) -> &'static str {
        let increments = self.unit.parameters().value(Parameter::SpindlePitch) == 0;
        match super::vocabulary::entry(at).map(|entry| entry.unit) {
            Some(Unit::Position | Unit::Window) if increments => Unit::Increments.name(),
            Some(Unit::Position | Unit::Window) => "0.01 mm",
            Some(unit) => unit.name(),
            None => "",
        }
    }

    fn product(&self) -> &str {
        "ag03-1"
    }

    fn notice(&mut self, _now: Instant, notice: Notice) {
        self.on_notice(notice);
    }

    fn poll_request(&mut self) -> Option<Request> {
        self.next_request()
    }

    fn load_defaults(&mut self, _now: Instant, group: Sub) -> Result<Written, Abort> {
        self.execute(load(group.0).ok_or(Abort::NO_SUB)?)?;
        Ok(Written::Done)
    }

    /// The unit's own image has everything but the bit rate.
    fn kept(&self, at: Address) -> Result<Value<'_>, Abort> {
        match at.pair() {
            (0x2100, 0) => self.read(at),
            (0.., 0..) => Err(Abort::NO_DATA),
        }
    }
}

/// What loading a group of defaults (1011h) does.
const fn load(group: u8) -> Option<Write> {
    Some(match group {
        1 => Write::Load(DefaultSet::All),
        2 => Write::Load(DefaultSet::Standard),
        3 => Write::Load(DefaultSet::Controller),
        4 => Write::Calibrate,
        0 | 5.. => return None,
    })
}

const LIMIT_1: Address = Address::new(0x607D, 2);
const LIMIT_2: Address = Address::new(0x607D, 1);

impl Part {
    /// The rule that a write breaks now.
    fn rule_of(&self, write: Write) -> Option<Rule> {
        match self.unit.parameters().clone().apply(write, &self.unit.write_context()).err()? {
            ParamError::OutOfRange { low, high, .. } => {
                Some(Rule::Limits(Limits::Range(low.into(), high.into())))
            }
            ParamError::NotNow(now) => Some(Rule::But(now.words())),
            ParamError::ReadOnly
            | ParamError::UnknownParameter { .. }
            | ParamError::SubindexOutOfRange { .. }
            | ParamError::NotAnArray
            | ParamError::IsArray { .. }
            | ParamError::WrongWidth { .. } => None,
        }
    }

    /// The value of an entry that is not constant.
    fn number(&self, at: Address) -> Result<i64, Abort> {
        let store = self.unit.parameters();
        Ok(match at.pair() {
            (0x6040, 0) => self.word.0.into(),
            (0x607A, 0) => self.target.into(),
            (0x60FF, 0) => self.velocity.into(),
            (0x1002, 0) => self.system_status().into(),
            (0x1003, sub) => self.history(sub).into(),
            (0x2100, 0) => self.rate.into(),
            (0x2101, 0) => self.node_id.number().into(),
            (0x2420, 0) => general_status(self.unit.status()).into(),
            (0x2422, 0) => self.unit.status().torque_tripped.into(),
            (0x6060, 0) => mode(store.value(Parameter::OperatingMode)).into(),
            pair @ (0.., 0..) => match reading(pair) {
                Some(reading) => {
                    let value = self.unit.measure(reading).map_err(|_of_bus| Abort::INTERNAL)?;
                    // Double words that are no position have no sign.
                    if reading.entry().signed { value.into() } else { value.cast_unsigned().into() }
                }
                None => store.value(parameter(pair).ok_or(Abort::INTERNAL)?).into(),
            },
        })
    }

    /// 1003h: the ring of PNU 945 as EMCY codes, the newest first; beyond the last one 0 (CN-29).
    fn history(&self, sub: u8) -> u32 {
        let codes = self.unit.drive().faults().codes();
        let mut kept = codes.iter().filter_map(|code| Fault::of_code(*code));
        match usize::from(sub).checked_sub(1) {
            None => u32::try_from(kept.count()).unwrap_or_default(),
            Some(place) => kept.nth(place).map_or(0, |fault| errors::code(fault).into()),
        }
    }

    /// Limit 2 must not be above limit 1 (CN-37).
    fn judge_limits(&self, parameter: Parameter, value: i32) -> Result<(), Abort> {
        let store = self.unit.parameters();
        let wrong = parameter == Parameter::Limit1 && value < store.value(Parameter::Limit2)
            || parameter == Parameter::Limit2 && value > store.value(Parameter::Limit1);
        if wrong && !self.quirks.limits_in_any_order { Err(Abort::MAX_BELOW_MIN) } else { Ok(()) }
    }

    fn execute(&mut self, write: Write) -> Result<(), Abort> {
        let _waits_with_the_image = self.unit.write_safely(write).map_err(abort)?;
        self.evaluate();
        Ok(())
    }
}

/// 6060h of parameter no. 20, and the other way: 1 and 2 are exchanged.
pub(super) const fn mode(number: i32) -> i32 {
    3 - number
}

const fn abort(error: ParamError) -> Abort {
    match error {
        ParamError::OutOfRange { .. } => Abort::RANGE,
        ParamError::NotNow(_) => Abort::DEVICE_STATE,
        ParamError::ReadOnly => Abort::READ_ONLY,
        ParamError::UnknownParameter { .. }
        | ParamError::SubindexOutOfRange { .. }
        | ParamError::NotAnArray
        | ParamError::IsArray { .. }
        | ParamError::WrongWidth { .. } => Abort::INTERNAL,
    }
}
