//! Jobs and replies of the parameter channel.

use crate::explain::Sender;
use crate::host::list::named::{OnChannel, on_channel};
use crate::profibus::ppo::{Ind, JobId, Pke, Pkw, ReplyId};

use crate::command::Failure;
use crate::command::args::{self, Octet, Parameter, WidthSpec};

/// The words, and who says them if that is not for the words to tell.
pub(super) fn build(what: &args::Pkw, force: bool) -> Result<(Pkw, Option<Sender>), Failure> {
    let job = |id: JobId, target: &Target, pwe| {
        Ok((Pkw::new(Pke::of_job(id, target.pnu), target.ind, pwe), Some(Sender::Master)))
    };
    let reply = |id: ReplyId, target: &Target, pwe| {
        Ok((Pkw::new(Pke::of_reply(id, target.pnu), target.ind, pwe), Some(Sender::Slave)))
    };
    match what {
        args::Pkw::None => Ok((Pkw::ZERO, Some(Sender::Master))),
        args::Pkw::Read { parameter } => {
            let target = Target::of(parameter, force)?.with_element()?;
            let id = if target.array { JobId::ReadElement } else { JobId::Read };
            job(id, &target, 0)
        }
        args::Pkw::Write { parameter, value, width } => {
            let target = Target::of(parameter, force)?.with_element()?;
            let width = target.width(width.given, *value);
            let id = match (width, target.array) {
                (WidthSpec::Word, false) => JobId::WriteWord,
                (WidthSpec::Double, false) => JobId::WriteDoubleWord,
                (WidthSpec::Word, true) => JobId::WriteElementWord,
                (WidthSpec::Double, true) => JobId::WriteElementDoubleWord,
            };
            job(id, &target, target.pwe(*value, width)?)
        }
        args::Pkw::Count { parameter } => job(JobId::ReadElementCount, &Target::of(parameter, force)?, 0),
        args::Pkw::Raw { ak, parameter, value, spm } => {
            let target = Target::of(parameter, true)?;
            let spm = if *spm { SPM } else { 0 };
            let pke = Pke::from_raw(u16::from(*ak) << 12 | spm | (target.pnu & PNU));
            Ok((Pkw::new(pke, target.ind, target.pwe(*value, WidthSpec::Double)?), None))
        }
        args::Pkw::Reply { parameter, value, width } => {
            let target = Target::of(parameter, force)?;
            let width = target.width(width.given, *value);
            let id = match (width, target.array) {
                (WidthSpec::Word, false) => ReplyId::Word,
                (WidthSpec::Double, false) => ReplyId::DoubleWord,
                (WidthSpec::Word, true) => ReplyId::ElementWord,
                (WidthSpec::Double, true) => ReplyId::ElementDoubleWord,
            };
            reply(id, &target, target.pwe(*value, width)?)
        }
        args::Pkw::ReplyCount { parameter, count } => {
            reply(ReplyId::ElementCount, &Target::of(parameter, force)?, (*count).into())
        }
        args::Pkw::Refuse { parameter, error } => {
            // A drive refuses numbers it does not know.
            reply(ReplyId::NotExecutable, &Target::of(parameter, true)?, (*error).into())
        }
    }
}

/// Bit 11 of PKE.
const SPM: u16 = 0x0800;
/// Bits 10 to 0 of PKE.
const PNU: u16 = 0x07FF;

/// Which parameter, and which element of it.
struct Target {
    pnu: u16,
    ind: Ind,
    /// An element of an array is meant.
    array: bool,
    entry: Option<OnChannel>,
    /// Build it although it is a mistake.
    force: bool,
}

impl Target {
    /// What the text names; with `force` also a number that no drive has.
    fn of(parameter: &Parameter, force: bool) -> Result<Self, Failure> {
        let text = parameter.text.as_str();
        let split = text.rsplit_once('.').and_then(|(name, element)| Some((name, element.parse().ok()?)));
        let (name, element) = match split {
            Some((name, element)) => (name, Some(element)),
            None => (text, None),
        };
        let (pnu, entry) = match (on_channel(name), name.parse()) {
            (Ok(entry), _) => (entry.number, Some(entry)),
            (Err(_), Ok(number @ 0..=PNU)) if force => (number, None),
            (Err(_), Ok(number)) if force => {
                return Err(Failure::Usage(format!("a parameter number is at most {PNU}, got {number}")));
            }
            (Err(error), Ok(_)) => {
                return Err(Failure::Usage(format!("{error}; --force builds it nevertheless")));
            }
            (Err(error), Err(_)) => return Err(Failure::Usage(error)),
        };
        let subindex: u8 = element.unwrap_or(0);
        let ind = match parameter.ind {
            Octet::High => Ind::in_high_octet(subindex),
            Octet::Low => Ind::from_raw(subindex.into()),
        };
        Ok(Self { pnu, ind, array: element.is_some(), entry, force })
    }

    /// The same, unless it is an array of which an element must be named.
    fn with_element(self) -> Result<Self, Failure> {
        match self.entry.and_then(|entry| Some((entry, entry.elements?))) {
            Some((entry, count)) if !self.array && !self.force => Err(Failure::Usage(format!(
                "{} is an array of {count}: name the element, for example {}.0; --force builds it nevertheless",
                entry.name, self.pnu
            ))),
            Some(_) | None => Ok(self),
        }
    }

    /// As given, as the parameter is wide, or as wide as the value of an unknown one needs.
    fn width(&self, given: Option<WidthSpec>, value: i64) -> WidthSpec {
        match (given, self.entry) {
            (Some(width), _) => width,
            (None, Some(entry)) if entry.double => WidthSpec::Double,
            (None, Some(_)) => WidthSpec::Word,
            (None, None) if u16::try_from(value).is_ok() => WidthSpec::Word,
            (None, None) => WidthSpec::Double,
        }
    }

    /// The value in two's complement; a word in word 4.
    fn pwe(&self, value: i64, width: WidthSpec) -> Result<u32, Failure> {
        let name = self.entry.map_or(format!("PNU {}", self.pnu), |entry| entry.name.to_string());
        // In two's complement it would be a large number.
        if let Some(entry) = self.entry
            && value < 0
            && !entry.signed
            && !self.force
        {
            let takes = match entry.range {
                Some((low, high)) => format!("takes {low} to {high}"),
                None => "is never negative".into(),
            };
            return Err(Failure::Usage(format!(
                "{name} {takes}, got {value}; --force builds it nevertheless"
            )));
        }
        let fits = match width {
            WidthSpec::Word => {
                let signed = i16::try_from(value).map(|value| u32::from(value.cast_unsigned()));
                u16::try_from(value).map(u32::from).or(signed)
            }
            WidthSpec::Double => {
                let signed = i32::try_from(value).map(i32::cast_unsigned);
                u32::try_from(value).or(signed)
            }
        };
        let (width, low, high) = match width {
            WidthSpec::Word => ("word", i64::from(i16::MIN), i64::from(u16::MAX)),
            WidthSpec::Double => ("double word", i64::from(i32::MIN), i64::from(u32::MAX)),
        };
        fits.map_err(|_| {
            Failure::Usage(format!(
                "{value} does not fit {name}, which is a {width}: expected {low} to {high}"
            ))
        })
    }
}
