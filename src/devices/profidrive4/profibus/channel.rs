//! The parameter channel of telegrams 353 and 354: jobs of PKW on the parameters of record 47.
//!
//! Numbers from 2000 on have a page in the low octet of IND, elements count from 0 in the high one, and jobs 1 to 3 are 6
//! to 8 ([`docs/profidrive.md`](../../../../docs/profidrive.md#sources), P).

use super::event::Event;
use super::parameters::{
    Known, LIMITS, NO_ARRAY, NO_PARAMETER, NO_RIGHT, NO_SUBINDEX, ONLY_ZERO, Parameters, READ_ONLY, Wrong,
};
use super::requests;
use super::table::Entry;
use super::value;
use crate::profibus::pkw::{self, Config, JobError, Pages, SubindexOctet, Value, Width, Written};

/// How the channel works.
pub(super) const CONFIG: Config = Config {
    latency: 0,
    subindex: SubindexOctet::High,
    read_element_by_plain_job: false,
    pages: Pages::OfMaker,
    from_zero: false,
    keeping_jobs: false,
    same_jobs: true,
};

/// The octets of a word, and of a double word.
const WORD: usize = 2;
const DOUBLE_WORD: usize = 4;

/// The parameters, for one cycle.
pub(super) struct Channel<'a> {
    pub(super) parameters: &'a mut Parameters,
    pub(super) known: &'a Known,
    pub(super) told: &'a mut Vec<Event>,
}

impl Channel<'_> {
    fn entry(&self, pnu: u16) -> Result<&Entry, JobError> {
        self.parameters.table.entry(pnu).ok_or(JobError::UnknownParameter { got: pnu })
    }

    /// The parameter, and which of its elements.
    fn place(&self, pnu: u16, element: Option<u8>) -> Result<(&Entry, u16), JobError> {
        let entry = self.entry(pnu)?;
        let place = element.unwrap_or_default().into();
        let checked = self.parameters.check_elements(entry, self.known, (place, 1));
        checked.map_err(|wrong| self.cause(entry, wrong, 0.0))?;
        Ok((entry, place))
    }

    /// Why a job is refused, as the channel says it.
    fn cause(&self, entry: &Entry, (error, info): Wrong, got: f64) -> JobError {
        let (low, high) = entry.limits;
        let count = self.parameters.count(entry, self.known).unwrap_or(1);
        match error {
            NO_PARAMETER => JobError::UnknownParameter { got: info },
            READ_ONLY => JobError::ReadOnly,
            LIMITS => JobError::outside(low, high, got),
            NO_SUBINDEX => JobError::SubindexOutOfRange { count: short(count), got: short(info) },
            NO_ARRAY => JobError::NotAnArray,
            ONLY_ZERO => JobError::OnlyZero,
            NO_RIGHT => JobError::NoRight,
            _ => JobError::NotNow("the drive is switched on"),
        }
    }
}

fn short(number: u16) -> u8 {
    u8::try_from(number).unwrap_or(u8::MAX)
}

fn size(entry: &Entry) -> usize {
    entry.format.size().unwrap_or(1)
}

impl pkw::Parameters for Channel<'_> {
    fn read(&self, pnu: u16, element: Option<u8>) -> Result<Value, JobError> {
        let (entry, place) = self.place(pnu, element)?;
        let bits = value::bits(entry.format, self.parameters.value(entry, self.known, place));
        Ok(if size(entry) > WORD {
            Value::Double(bits)
        } else {
            // An octet, and a number with its sign, is a word.
            let [_, _, high, low] = bits.to_be_bytes();
            Value::Word(u16::from_be_bytes([high, low]))
        })
    }

    fn write(&mut self, pnu: u16, element: Option<u8>, given: Value) -> Result<Written, JobError> {
        let (entry, place) = self.place(pnu, element)?;
        let expected = if size(entry) > WORD { Width::Double } else { Width::Word };
        if given.width() != expected {
            return Err(JobError::WrongWidth { expected, got: given.width() });
        }
        let new = value::of_bits(entry.format, given.bits());
        let checked = self.parameters.check_writable(entry, self.known, place);
        let checked = checked.and_then(|()| self.parameters.check_value(entry, place, new));
        checked.map_err(|wrong| self.cause(entry, wrong, new))?;
        self.parameters.set(pnu, place, new);
        self.told.push(Event::Written { pnu, element: place });
        Ok(Written::at_once(given))
    }

    fn elements(&self, pnu: u16) -> Result<Option<u8>, JobError> {
        Ok(self.parameters.count(self.entry(pnu)?, self.known).map(short))
    }

    fn describe(&self, pnu: u16, element: u8) -> Result<u32, JobError> {
        let entry = self.entry(pnu)?;
        let Some(place) = element.checked_sub(1) else { return Err(JobError::DescriptionTooLong) };
        let all = requests::elements_of(self.parameters, self.known, entry);
        let count = short(u16::try_from(all.len()).unwrap_or(u16::MAX));
        let missing = JobError::SubindexOutOfRange { count, got: element };
        let (_, octets) = all.get(usize::from(place)).ok_or(missing)?;
        if octets.len() > DOUBLE_WORD {
            return Err(JobError::NameTooLong);
        }
        Ok(octets.iter().fold(0, |all, octet| all << 8 | u32::from(*octet)))
    }
}
