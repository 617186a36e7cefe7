//! Requests of parameters in record 47: what is answered to each (`dp-v1.md` 9.1).

use super::parameters::{Known, NO_PARAMETER, OBJECT, Parameters, Wrong};
use super::table::Entry;
use super::value;
use crate::profibus::dpv1::MAX_DATA;
use crate::profibus::dpv1::base_mode::description::{ARRAY, CANNOT_BE_WRITTEN, HAS_TEXTS, UNITS};
use crate::profibus::dpv1::base_mode::{
    Attribute, Format, HEAD_LEN, Head, MAX_PARAMETERS, ParameterAddress, ParameterError, Service, Values,
};

const TYPE: ParameterError = ParameterError(0x05);
const DESCRIPTION: ParameterError = ParameterError(0x07);
const NO_TEXT: ParameterError = ParameterError(0x0F);
const TOO_LONG: ParameterError = ParameterError(0x15);
const ADDRESS: ParameterError = ParameterError(0x16);
const FORMAT: ParameterError = ParameterError(0x17);
const COUNT: ParameterError = ParameterError(0x18);
const AXIS: ParameterError = ParameterError(0x19);
const TEXT: ParameterError = ParameterError(0x20);
const SERVICE: ParameterError = ParameterError(0x21);
const TOO_MANY: ParameterError = ParameterError(0x23);

/// The most elements of a parameter in a request.
const MAX_ELEMENTS: u8 = 234;
/// The octets of a name or a text.
const TEXT_LEN: usize = 16;
/// The octets that each parameter needs at least in a response: an error.
const LEAST: usize = 4;

/// What became of one parameter, for the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    Changed {
        address: ParameterAddress,
    },
    Failed {
        service: Service,
        address: ParameterAddress,
        error: ParameterError,
        info: u16,
    },
    /// None of its parameters was looked at.
    Whole {
        head: Head,
        error: ParameterError,
    },
}

/// The octets of a parameter in a response.
enum Block {
    Values { format: Format, count: u8, octets: Vec<u8> },
    Changed,
}

/// The response to a request; `None`: it is too short to be one.
pub(super) fn respond(
    parameters: &mut Parameters,
    known: &Known,
    request: &[u8],
    tell: &mut dyn FnMut(Outcome),
) -> Option<Vec<u8>> {
    let (head, rest) = Head::of_request(request)?;
    let whole = |error, tell: &mut dyn FnMut(Outcome)| {
        tell(Outcome::Whole { head, error });
        let head = Head { failed: true, parameters: 1, ..head };
        Some([&head.octets()[..], &error_block((error, 0))].concat())
    };
    let changes = match head.service {
        Service::Read => false,
        Service::Change => true,
        Service::Unknown(_) => return whole(SERVICE, tell),
    };
    match head.parameters {
        0 => return whole(ADDRESS, tell),
        1..=MAX_PARAMETERS => {}
        _ => return whole(TOO_MANY, tell),
    }
    let Some((addresses, mut rest)) = split(head.parameters, rest) else { return whole(ADDRESS, tell) };
    let mut given = Vec::new();
    if changes {
        for _ in &addresses {
            match Values::split(rest) {
                Some((values, behind)) => {
                    given.push(Some(values));
                    rest = behind;
                }
                // Where a value of an unknown format ends nobody knows.
                None if is_unknown(rest) => {
                    given.push(None);
                    break;
                }
                None => return whole(ADDRESS, tell),
            }
        }
    }
    let mut octets = Vec::new();
    let mut failed = false;
    for (place, address) in addresses.iter().enumerate() {
        let behind = addresses.len() - place - 1;
        let room = usize::from(MAX_DATA) - HEAD_LEN - octets.len() - behind * LEAST;
        let result = if head.axis > OBJECT {
            Err((AXIS, 0))
        } else if changes {
            match given.get(place) {
                Some(Some(values)) => change(parameters, known, *address, values),
                Some(None) => Err((FORMAT, 0)),
                None => Err((ADDRESS, 0)),
            }
        } else {
            read(parameters, known, *address)
        };
        match result.and_then(|block| encode(&block, room)) {
            Ok(block) => {
                if changes {
                    tell(Outcome::Changed { address: *address });
                }
                octets.extend(block);
            }
            Err(wrong) => {
                failed = true;
                let (error, info) = wrong;
                tell(Outcome::Failed { service: head.service, address: *address, error, info });
                octets.extend(error_block(wrong));
            }
        }
    }
    let head = Head { failed, ..head };
    // A change that went well is answered by its head alone.
    let behind = if changes && !failed { &[][..] } else { &octets };
    Some([&head.octets()[..], behind].concat())
}

/// So many addresses, and what is behind them.
fn split(count: u8, mut rest: &[u8]) -> Option<(Vec<ParameterAddress>, &[u8])> {
    let mut addresses = Vec::new();
    for _ in 0..count {
        let (address, behind) = ParameterAddress::split(rest)?;
        addresses.push(address);
        rest = behind;
    }
    Some((addresses, rest))
}

fn is_unknown(values: &[u8]) -> bool {
    matches!(values, [format, _, ..] if Format(*format).size().is_none())
}

fn error_block((error, info): Wrong) -> Vec<u8> {
    let words: &[u16] = if error.names_subindex() { &[error.0, info] } else { &[error.0] };
    let count = if error.names_subindex() { 2 } else { 1 };
    let octets = words.iter().flat_map(|word| word.to_be_bytes());
    [Format::ERROR.0, count].into_iter().chain(octets).collect()
}

/// The octets of a block, if there is room.
fn encode(block: &Block, room: usize) -> Result<Vec<u8>, Wrong> {
    let values = match block {
        Block::Values { format, count, octets } => Values { format: *format, count: *count, octets },
        Block::Changed => Values { format: Format::ZERO, count: 0, octets: &[] },
    };
    let mut buf = [0; MAX_DATA as usize];
    let encoded = values.encode(&mut buf).filter(|octets| octets.len() <= room);
    encoded.map(<[u8]>::to_vec).ok_or((TOO_LONG, 0))
}

fn entry_of(parameters: &Parameters, pnu: u16) -> Result<&Entry, Wrong> {
    parameters.table.entry(pnu).ok_or((NO_PARAMETER, 0))
}

fn read(parameters: &Parameters, known: &Known, address: ParameterAddress) -> Result<Block, Wrong> {
    let entry = entry_of(parameters, address.pnu)?;
    match address.attribute {
        Attribute::Value => read_values(parameters, known, entry, address),
        Attribute::Description => describe(parameters, known, entry, address.subindex),
        Attribute::Text => texts(entry, address),
        Attribute::Unknown(_) => Err((ADDRESS, 0)),
    }
}

fn read_values(
    parameters: &Parameters,
    known: &Known,
    entry: &Entry,
    address: ParameterAddress,
) -> Result<Block, Wrong> {
    let ParameterAddress { elements, subindex, .. } = address;
    if elements > MAX_ELEMENTS {
        return Err((ADDRESS, 0));
    }
    parameters.check_elements(entry, known, (subindex, elements))?;
    let count = elements.max(1);
    let places = (0..u16::from(count)).map(|place| subindex.saturating_add(place));
    let value = |place| value::octets(entry.format, parameters.value(entry, known, place));
    Ok(Block::Values { format: entry.format, count, octets: places.flat_map(value).collect() })
}

/// The texts of values, 16 characters each, from that of the value `subindex`.
fn texts(entry: &Entry, address: ParameterAddress) -> Result<Block, Wrong> {
    if entry.texts.is_empty() {
        return Err((NO_TEXT, 0));
    }
    let wanted = usize::from(address.elements.max(1));
    let texts = entry.texts.get(usize::from(address.subindex)..).unwrap_or_default();
    if texts.len() < wanted {
        let count = u16::try_from(entry.texts.len()).unwrap_or(u16::MAX);
        return Err((super::parameters::NO_SUBINDEX, address.subindex.max(count)));
    }
    let octets: Vec<u8> = texts.iter().take(wanted).flat_map(|text| padded(text)).collect();
    let count = u8::try_from(octets.len()).map_err(|_| (TOO_LONG, 0))?;
    Ok(Block::Values { format: Format::VISIBLE_STRING, count, octets })
}

/// A text of 16 characters; what is none of them is a question mark.
fn padded(text: &str) -> impl Iterator<Item = u8> {
    let octet = |character: char| if character.is_ascii() { character as u8 } else { b'?' };
    let blanks = core::iter::repeat(b' ');
    text.chars().map(octet).chain(blanks).take(TEXT_LEN).collect::<Vec<_>>().into_iter()
}

/// One element of a description, or with 0 all of it.
fn describe(parameters: &Parameters, known: &Known, entry: &Entry, element: u16) -> Result<Block, Wrong> {
    let all = elements_of(parameters, known, entry);
    let (format, octets) = match element.checked_sub(1) {
        None => (Format::OCTET_STRING, all.iter().flat_map(|(_, octets)| octets.clone()).collect()),
        Some(place) => {
            let missing = (super::parameters::NO_SUBINDEX, element);
            all.get(usize::from(place)).cloned().ok_or(missing)?
        }
    };
    let size = format.size().unwrap_or(1).max(1);
    let count = u8::try_from(octets.len() / size).map_err(|_| (TOO_LONG, 0))?;
    Ok(Block::Values { format, count, octets })
}

/// The twelve elements of a description (`profidrive-v2.md` 6).
pub(super) fn elements_of(parameters: &Parameters, known: &Known, entry: &Entry) -> [(Format, Vec<u8>); 12] {
    let count = parameters.count(entry, known);
    let when = |set: bool, flag: u16| if set { flag } else { 0 };
    let identifier = u16::from(entry.format.0)
        | when(count.is_some(), ARRAY)
        | when(!entry.texts.is_empty(), HAS_TEXTS)
        | when(!entry.is_writable(known), CANNOT_BE_WRITTEN);
    let word = |word: u16| word.to_be_bytes().to_vec();
    let (low, high) = entry.limits;
    let limit = |value| value::bits(entry.format, value).to_be_bytes().to_vec();
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a factor of single precision is what the profile has"
    )]
    let factor = (entry.scale as f32).to_be_bytes().to_vec();
    [
        (Format::V2, word(identifier)),
        (Format::UNSIGNED16, word(count.unwrap_or(0))),
        (Format::FLOAT, factor),
        (Format::OCTET_STRING, variable(&entry.unit).to_vec()),
        (Format::OCTET_STRING, vec![0; 4]),
        (Format::VISIBLE_STRING, padded(&entry.name).collect()),
        (Format::DOUBLE_WORD, limit(low)),
        (Format::DOUBLE_WORD, limit(high)),
        (Format::OCTET_STRING, vec![0; 2]),
        (Format::V2, word(0)),
        (Format::UNSIGNED16, word(0)),
        (Format::V2, word(0)),
    ]
}

/// Variable index and conversion index of a unit; 0: none.
fn variable(unit: &str) -> [u8; 2] {
    UNITS.iter().find(|(known, _)| *known == unit).map_or([0, 0], |(_, indices)| *indices)
}

fn change(
    parameters: &mut Parameters,
    known: &Known,
    address: ParameterAddress,
    values: &Values<'_>,
) -> Result<Block, Wrong> {
    let entry = entry_of(parameters, address.pnu)?;
    match address.attribute {
        Attribute::Value => {}
        Attribute::Description => return Err((DESCRIPTION, address.subindex)),
        Attribute::Text => return Err((TEXT, 0)),
        Attribute::Unknown(_) => return Err((ADDRESS, 0)),
    }
    let ParameterAddress { pnu, elements, subindex, .. } = address;
    if elements > MAX_ELEMENTS {
        return Err((ADDRESS, 0));
    }
    parameters.check_elements(entry, known, (subindex, elements))?;
    parameters.check_writable(entry, known, subindex)?;
    if !value::fits(entry.format, values.format) {
        return Err((TYPE, 0));
    }
    if values.count != elements.max(1) {
        return Err((COUNT, 0));
    }
    let size = entry.format.size().unwrap_or(1).max(1);
    let octets = values.octets.chunks_exact(size);
    let new: Vec<(u16, f64)> =
        (subindex..=u16::MAX).zip(octets.map(|octets| value::of_octets(entry.format, octets))).collect();
    for (element, value) in &new {
        parameters.check_value(entry, *element, *value)?;
    }
    for (element, value) in new {
        parameters.set(pnu, element, value);
    }
    Ok(Block::Changed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::devices::ppo_drive::table::{Fields, Row};
    use crate::devices::profidrive4::profibus::table::Table;
    use crate::devices::profidrive4::profibus::telegram::Telegram;
    use crate::devices::profidrive4::{Drive, Fault};
    use crate::profibus::fdl::Address;
    use crate::time::{BaudRate, Instant};

    struct Rig {
        parameters: Parameters,
        known: Known,
        told: Vec<Outcome>,
    }

    impl Rig {
        fn new() -> Self {
            let fields =
                [("pnu", "3000"), ("name", "table"), ("type", "int16"), ("elements", "100"), ("max", "500")];
            let rows = [Row::of(&Fields::new(1, fields)).unwrap()];
            let known = Known {
                address: Address::station(7).unwrap(),
                baud: BaudRate::K500,
                ident: 0x5034,
                telegram: Telegram::numbered(1).cloned(),
                stw1: 0x047E,
                zsw1: 0xEB31,
            };
            let parameters = Parameters::new(Drive::new(Instant::ZERO), Table::new(&rows).unwrap());
            Self { parameters, known, told: Vec::new() }
        }

        fn ask(&mut self, request: &[u8]) -> Vec<u8> {
            let Self { parameters, known, told } = self;
            respond(parameters, known, request, &mut |outcome| told.push(outcome)).unwrap()
        }

        /// The response to a change of one element, without its head.
        fn change(&mut self, pnu: u16, subindex: u16, values: &[u8]) -> Vec<u8> {
            let [[p1, p0], [s1, s0]] = [pnu, subindex].map(u16::to_be_bytes);
            let response = self.ask(&[&[9, 2, 1, 1, 0x10, 1, p1, p0, s1, s0], values].concat());
            assert_eq!(response[0], 9);
            response[1..].to_vec()
        }
    }

    #[test]
    fn v1_r88_the_numbers_of_the_profile_are_read_and_the_reference_is_mirrored() {
        let mut rig = Rig::new();
        let identification = rig.ask(&[1, 1, 0, 1, 0x10, 7, 0x03, 0xC4, 0, 0]);
        assert_eq!(identification[..6], [1, 1, 0, 1, 6, 7]);
        assert_eq!(identification[6..10], [0, 0, 0x50, 0x34]);
        assert_eq!(rig.ask(&[2, 1, 1, 1, 0x10, 0, 0x03, 0x9A, 0, 0]), [2, 1, 1, 1, 6, 1, 0, 1]);
        assert_eq!(rig.ask(&[3, 1, 1, 1, 0x10, 2, 0x03, 0xC5, 0, 0]), [3, 1, 1, 1, 0x0A, 2, 3, 0x2A]);
        assert_eq!(rig.ask(&[4, 1, 1, 1, 0x10, 0, 0x03, 0xC7, 0, 0]), [4, 1, 1, 1, 0x23, 1, 0x04, 0x7E]);
        // All numbers, ascending, ended by 0.
        let mut list = Vec::new();
        for first in (0..).step_by(50) {
            let [s1, s0] = u16::to_be_bytes(first);
            let part = rig.ask(&[5, 1, 1, 1, 0x10, 1, 0x03, 0xD4, s1, s0]);
            if part[1] != 1 {
                assert_eq!(part[4..], [0x44, 2, 0, 3, s1, s0]);
                break;
            }
            for place in first..first + 50 {
                let [s1, s0] = place.to_be_bytes();
                let one = rig.ask(&[5, 1, 1, 1, 0x10, 1, 0x03, 0xD4, s1, s0]);
                if one[1] == 1 {
                    list.push(u16::from_be_bytes([one[6], one[7]]));
                }
            }
        }
        assert_eq!(list.pop(), Some(0));
        assert!(list.is_sorted() && list.contains(&3000) && list.contains(&60000));
        assert_eq!(list.len(), rig.parameters.table.entries().count());
    }

    #[test]
    fn v1_r89_each_error_has_its_number_and_its_sub_index() {
        let mut rig = Rig::new();
        let error = |error: u8| vec![0x82, 1, 1, 0x44, 1, 0, error];
        let at = |error: u8, subindex: u8| vec![0x82, 1, 1, 0x44, 2, 0, error, 0, subindex];
        assert_eq!(rig.change(5, 0, &[0x42, 1, 0, 1]), error(0x00));
        assert_eq!(rig.change(964, 1, &[0x42, 1, 0, 1]), at(0x01, 1));
        assert_eq!(rig.change(3000, 4, &[3, 1, 0x01, 0xF5]), at(0x02, 4));
        assert_eq!(rig.change(3000, 100, &[3, 1, 0, 1]), at(0x03, 100));
        assert_eq!(rig.change(2000, 1, &[8, 1, 0x45, 0x3B, 0x80, 0]), error(0x04));
        assert_eq!(rig.change(3000, 0, &[6, 1, 0, 1]), error(0x05));
        assert_eq!(rig.change(952, 0, &[6, 1, 0, 1]), at(0x06, 0));
        assert_eq!(rig.change(3000, 0, &[3, 2, 0, 1, 0, 2]), error(0x18));
        assert_eq!(rig.change(3000, 0, &[0x99, 1, 0, 1]), error(0x17));
        let ask = |rig: &mut Rig, octets: &[u8]| rig.ask(octets)[4..].to_vec();
        assert_eq!(
            ask(&mut rig, &[1, 2, 1, 1, 0x20, 1, 0x0B, 0xB8, 0, 3, 3, 1, 0, 1]),
            [0x44, 2, 0, 7, 0, 3]
        );
        assert_eq!(ask(&mut rig, &[1, 2, 1, 1, 0x30, 1, 0x0B, 0xB8, 0, 0, 3, 1, 0, 1]), [0x44, 1, 0, 0x20]);
        assert_eq!(ask(&mut rig, &[1, 1, 1, 1, 0x30, 1, 0x0B, 0xB8, 0, 0]), [0x44, 1, 0, 0x0F]);
        assert_eq!(ask(&mut rig, &[1, 1, 1, 1, 0x50, 1, 0x0B, 0xB8, 0, 0]), [0x44, 1, 0, 0x16]);
        assert_eq!(ask(&mut rig, &[1, 1, 9, 1, 0x10, 1, 0x0B, 0xB8, 0, 0]), [0x44, 1, 0, 0x19]);
        assert_eq!(ask(&mut rig, &[1, 7, 1, 1, 0x10, 1, 0x0B, 0xB8, 0, 0]), [0x44, 1, 0, 0x21]);
        assert_eq!(ask(&mut rig, &[1, 1, 1, 40, 0x10, 1, 0x0B, 0xB8, 0, 0]), [0x44, 1, 0, 0x23]);
        // Cut off, and none at all.
        for octets in [
            &[1, 1, 1, 0][..],
            &[1, 1, 1, 2, 0x10, 1, 0x0B, 0xB8, 0, 0],
            &[1, 2, 1, 1, 0x10, 1, 0x0B, 0xB8, 0, 0, 3, 1, 0],
        ] {
            assert_eq!(ask(&mut rig, octets), [0x44, 1, 0, 0x16], "{octets:02X?}");
        }
        let Rig { parameters, known, .. } = &mut rig;
        assert_eq!(respond(parameters, known, &[1, 1, 1], &mut |_| {}), None);
        // Nobody may change anything but this right.
        assert_eq!(rig.change(927, 0, &[6, 1, 0, 0]), [2, 1, 1]);
        assert_eq!(rig.change(3000, 0, &[3, 1, 0, 1]), error(0x0B));
        assert_eq!(rig.change(927, 0, &[6, 1, 0, 1]), [2, 1, 1]);
        assert_eq!(rig.change(3000, 0, &[3, 1, 0, 1]), [2, 1, 1]);
    }

    #[test]
    fn v1_r89_the_reference_of_the_speed_is_not_changed_while_the_drive_is_switched_on() {
        let mut rig = Rig::new();
        let mut off = crate::devices::profidrive4::Command::run(0.0);
        off.control.on = false;
        let drive = &mut rig.parameters.drive;
        drive.step(Instant::from_millis(1), Some(&off));
        drive.step(Instant::from_millis(2), Some(&crate::devices::profidrive4::Command::run(0.0)));
        assert_eq!(rig.change(2000, 0, &[8, 1, 0x45, 0x3B, 0x80, 0]), [0x82, 1, 1, 0x44, 1, 0, 0x11]);
        assert_eq!(rig.change(1120, 0, &[8, 1, 0x40, 0, 0, 0]), [2, 1, 1]);
    }

    #[test]
    fn v1_r90_of_several_parameters_the_bad_one_has_its_error_and_a_good_change_has_four_octets() {
        let mut rig = Rig::new();
        let two = [4, 1, 0, 2, 0x10, 0, 0x03, 0x9A, 0, 0, 0x10, 0, 0, 1, 0, 0];
        assert_eq!(rig.ask(&two), [4, 0x81, 0, 2, 6, 1, 0, 1, 0x44, 1, 0, 0]);
        let address = |element: u8| [0x10, 1, 0x0B, 0xB8, 0, element];
        let change =
            [&[5, 2, 1, 2][..], &address(1), &address(2), &[3, 1, 0, 7], &[0x42, 1, 0xFF, 0xFF]].concat();
        assert_eq!(rig.ask(&change), [5, 2, 1, 2]);
        assert_eq!(
            rig.ask(&[6, 1, 1, 1, 0x10, 3, 0x0B, 0xB8, 0, 0]),
            [6, 1, 1, 1, 3, 3, 0, 0, 0, 7, 0xFF, 0xFF]
        );
        // One by one: the first is done.
        let change =
            [&[7, 2, 1, 2][..], &address(1), &[0x10, 1, 0x03, 0xC4, 0, 0], &[3, 1, 0, 8], &[6, 1, 0, 1]]
                .concat();
        assert_eq!(rig.ask(&change), [7, 0x82, 1, 2, 0x40, 0, 0x44, 2, 0, 1, 0, 0]);
        assert_eq!(rig.ask(&[8, 1, 1, 1, 0x10, 1, 0x0B, 0xB8, 0, 1])[6..], [0, 8]);
        assert_eq!(rig.told.len(), 5);
    }

    #[test]
    fn v1_r92_descriptions_texts_padding_and_what_does_not_fit() {
        let mut rig = Rig::new();
        let all = rig.ask(&[1, 1, 1, 1, 0x20, 0, 0x0B, 0xB8, 0, 0]);
        assert_eq!((&all[..6], all.len()), (&[1, 1, 1, 1, 0x0A, 46][..], 6 + 46));
        // An array of 100 of i16, its name, its limits.
        assert_eq!(all[6..10], [0x40, 3, 0, 100]);
        assert_eq!(all[20..36], *b"table           ");
        assert_eq!(all[36..44], [0xFF, 0xFF, 0x80, 0, 0, 0, 0x01, 0xF4]);
        assert_eq!(rig.ask(&[1, 1, 1, 1, 0x20, 0, 0x0B, 0xB8, 0, 2])[4..], [6, 1, 0, 100]);
        assert_eq!(rig.ask(&[1, 1, 1, 1, 0x20, 0, 0x0B, 0xB8, 0, 13])[4..], [0x44, 2, 0, 3, 0, 13]);
        let text = rig.ask(&[1, 1, 1, 1, 0x30, 1, 0x03, 0xA2, 0, 1]);
        assert_eq!((&text[4..6], &text[6..]), (&[9, 16][..], &b"speed, ramp     "[..]));
        assert_eq!(rig.ask(&[1, 1, 1, 1, 0x30, 1, 0x03, 0xA2, 0, 9])[4..], [0x44, 2, 0, 3, 0, 9]);
        // One octet has another one behind it.
        assert_eq!(rig.ask(&[1, 1, 1, 1, 0x10, 1, 0x03, 0xD2, 0, 0])[4..], [5, 1, 1, 0]);
        // Of two parameters, 116 words are what a response has room for: 240 octets.
        let most = rig.ask(&[1, 1, 1, 2, 0x10, 100, 0x0B, 0xB8, 0, 0, 0x10, 16, 0x0B, 0xB8, 0, 0]);
        assert_eq!((most.len(), most[1]), (240, 1));
        for elements in [17, 100] {
            let more = rig.ask(&[1, 1, 1, 2, 0x10, 100, 0x0B, 0xB8, 0, 0, 0x10, elements, 0x0B, 0xB8, 0, 0]);
            assert_eq!((&more[206..], more[1]), (&[0x44, 1, 0, 0x15][..], 0x81));
        }
    }

    #[test]
    fn the_fault_buffer_has_number_time_and_value() {
        let mut rig = Rig::new();
        rig.parameters.drive.step(Instant::from_millis(250), None);
        rig.parameters.drive.raise(Fault::Raised(70), -2);
        let mut read = |pnu: u16| {
            let [p1, p0] = pnu.to_be_bytes();
            rig.ask(&[1, 1, 1, 1, 0x10, 1, p1, p0, 0, 0])[4..].to_vec()
        };
        assert_eq!(read(947), [6, 1, 0, 70]);
        assert_eq!(read(948), [0x0D, 1, 0, 0, 0, 250]);
        assert_eq!(read(949), [4, 1, 0xFF, 0xFF, 0xFF, 0xFE]);
        assert_eq!((read(944), read(952)), (vec![6, 1, 0, 1], vec![6, 1, 0, 1]));
    }

    proptest::proptest! {
        #[test]
        fn whatever_is_written_there_is_an_answer_that_fits(
            octets in proptest::collection::vec(proptest::prelude::any::<u8>(), 0..240),
            known in proptest::prelude::any::<bool>(),
        ) {
            let mut rig = Rig::new();
            let mut octets = octets;
            if let (true, [_, service, axis, count, attribute, ..]) = (known, &mut octets[..]) {
                (*service, *axis, *count, *attribute) = (1 + *service % 2, *axis % 2, 1 + *count % 5, 0x10);
            }
            let Rig { parameters, known, .. } = &mut rig;
            match respond(parameters, known, &octets, &mut |_| {}) {
                None => assert!(octets.len() < HEAD_LEN),
                Some(response) => {
                    assert!((HEAD_LEN..=usize::from(MAX_DATA)).contains(&response.len()));
                    assert_eq!(response[0], octets[0]);
                    let (head, mut rest) = Head::of_response(&response).unwrap();
                    let blocks = if head.failed || head.service == Service::Read { head.parameters } else { 0 };
                    for _ in 0..blocks {
                        (_, rest) = Values::split(rest).unwrap();
                    }
                    assert!(rest.is_empty());
                }
            }
        }
    }
}
