//! Drives of PROFIdrive 3 and 4: parameters by record 47.

use core::time::Duration;

use super::records::{is_refused, may_write};
use super::{expected, likely, open, row};
use crate::client::{ParameterRefused, ParameterRequest};
use crate::judge::device::course::{Course, broken, inapplicable};
use crate::judge::device::row::{By, Group};
use crate::judge::device::slave::Tester;
use crate::judge::device::slave::tester::Channel;
use crate::profibus::dpv1::base_mode::{Attribute, Format, ParameterAddress, ParameterError, Values};
use crate::profibus::dpv1::{ErrorCode, MAX_DATA, PARAMETER_INDEX};

pub(super) const GROUP: Group<Tester> = Group {
    title: "DP-V1: parameters of a drive (PROFIdrive)",
    rows: &[
        row(
            "V1-R88",
            "PNU 922, 964, 965 and 980 are read, with the reference of the request",
            "record 47: Write the request, Read the response; reference, axis and number mirrored (dp-v1 9.1, 9.5)",
            &["V1-R06"],
            By::Trial(r88),
        ),
        row(
            "V1-R89",
            "a wrong parameter, element, attribute or axis value is refused with its error number",
            "00 no such parameter, 03 no such sub-index, 04 no array, 16 bad address (dp-v1 9.1)",
            &["V1-R88"],
            By::Trial(r89),
        ),
        row(
            "V1-D01",
            "a wrong change is refused: 01 not changeable, 05 wrong type, 18 number of values",
            "01 not changeable, 05 wrong data type, 18 number of values and of elements differ (dp-v1 9.1)",
            &["V1-R88"],
            By::Trial(d01),
        ),
        row(
            "V1-R90",
            "several parameters at once: in order, the good ones with values, the bad one with its error",
            "81 if one fails, the good ones carry values, order as requested (dp-v1 9.1)",
            &["V1-R88"],
            By::Trial(r90),
        ),
        row(
            "V1-D02",
            "a change that goes well is answered with four octets",
            "for a change nothing more if all went well (dp-v1 9.1)",
            &["V1-R88"],
            By::Trial(d02),
        ),
        open(row(
            "V1-R91",
            "Read of record 47 without a Write: B5, state conflict",
            "record 47 read without an earlier write: B5 (dp-v1 2.1)",
            &["V1-R88"],
            By::Trial(r91),
        )),
        expected(row(
            "V1-R92",
            "the description of a parameter has 46 octets; responses have an even number of octets",
            "attribute 20, sub-index 0: 46 octets as octet string; odd values are padded (dp-v1 9.1)",
            &["V1-R88"],
            By::Trial(r92),
        )),
        likely(row(
            "V1-D03",
            "each of the first PNUs of the list 980 can be read, or its description",
            "980: numbers of all parameters, ascending, ended by 0 (dp-v1 9.5)",
            &["V1-R88", "V1-R92"],
            By::Trial(d03),
        )),
    ],
};

/// A request is answered within so long.
const PATIENCE: Duration = Duration::from_secs(5);
const PAUSE: Duration = Duration::from_millis(5);
/// So many parameters of the list are asked for.
const SOME: usize = 40;

/// A drive, its channel, and the slot where its parameters are.
fn drive(tester: &mut Tester) -> Course<(Channel, u8)> {
    tester.has_ms1()?;
    if !tester.setup.profidrive {
        return inapplicable("needs a drive of PROFIdrive 3 or 4: profile=profidrive");
    }
    let channel = tester.open()?;
    let Some(request) = ParameterRequest::read(1, 0, &[value(922, 0, 0)]) else {
        return inapplicable("a request has room for one parameter");
    };
    // Most take slot 0; some slot 1 only.
    let taken = tester.write_record(channel, (0, PARAMETER_INDEX), request.octets())?.is_ok();
    let slot = u8::from(!taken);
    if taken {
        response(tester, channel, slot)?;
    }
    Ok((channel, slot))
}

const fn value(pnu: u16, elements: u8, subindex: u16) -> ParameterAddress {
    ParameterAddress { attribute: Attribute::Value, elements, pnu, subindex }
}

/// Reads record 47 until the response is there.
fn response(tester: &mut Tester, channel: Channel, slot: u8) -> Course<Vec<u8>> {
    let until = tester.wire.now().saturating_add(PATIENCE);
    loop {
        match tester.read_record(channel, (slot, PARAMETER_INDEX), MAX_DATA)? {
            Ok(octets) => return Ok(octets),
            Err(failure) if failure.code == ErrorCode::STATE_CONFLICT && tester.wire.now() < until => {
                tester.pause(PAUSE)?;
            }
            Err(failure) => {
                return broken(format!("record 47 is written, and its Read is refused: {failure}"));
            }
        }
    }
}

/// The response to a request.
fn asked(tester: &mut Tester, (channel, slot): (Channel, u8), request: &[u8]) -> Course<Vec<u8>> {
    if let Err(failure) = tester.write_record(channel, (slot, PARAMETER_INDEX), request)? {
        return broken(format!("Write of record 47 is refused: {failure}"));
    }
    let octets = response(tester, channel, slot)?;
    if octets.len().is_multiple_of(2) {
        return Ok(octets);
    }
    broken(format!("a response of record 47 has {} octets, expected an even number", octets.len()))
}

type Said = Result<(Format, Vec<u8>), ParameterRefused>;

/// What a request says of each parameter.
fn results(
    tester: &mut Tester,
    drive: (Channel, u8),
    request: Option<ParameterRequest>,
) -> Course<(Vec<u8>, Vec<Said>)> {
    let Some(request) = request else { return broken("the request has no room for its parameters") };
    let octets = asked(tester, drive, request.octets())?;
    let said = match request.results(&octets) {
        Ok(results) => {
            results.map(|result| result.map(|values| (values.format, values.octets.to_vec()))).collect()
        }
        Err(error) => return broken(error.to_string()),
    };
    Ok((octets, said))
}

/// What one address gives.
fn read(tester: &mut Tester, drive: (Channel, u8), reference: u8, address: ParameterAddress) -> Course<Said> {
    let (_, said) = results(tester, drive, ParameterRequest::read(reference, 0, &[address]))?;
    match said.into_iter().next() {
        Some(said) => Ok(said),
        None => broken("the response has no value"),
    }
}

fn must_read(
    tester: &mut Tester,
    drive: (Channel, u8),
    reference: u8,
    address: ParameterAddress,
) -> Course<Vec<u8>> {
    match read(tester, drive, reference, address)? {
        Ok((_, octets)) => Ok(octets),
        Err(refused) => broken(format!("PNU {} is refused: {refused}", address.pnu)),
    }
}

fn r88(tester: &mut Tester) -> Course {
    let drive = drive(tester)?;
    let telegram = must_read(tester, drive, 17, value(922, 0, 0))?;
    let device = must_read(tester, drive, 18, value(964, 5, 0))?;
    let profile = must_read(tester, drive, 19, value(965, 2, 0))?;
    for (pnu, octets, len) in [(922, &telegram, 2), (964, &device, 10), (965, &profile, 2)] {
        if octets.len() != len {
            return broken(format!("PNU {pnu} has {} octets, expected {len}", octets.len()));
        }
    }
    if profile.first() != Some(&3) {
        return broken(format!("PNU 965 is {}, expected 03 and a version", crate::explain::hex(&profile)));
    }
    let list = listed(tester, drive)?;
    if list.is_sorted() && [922, 964, 965].iter().all(|pnu| list.contains(pnu)) {
        return Ok(());
    }
    broken("the list 980 is not ascending, or lacks 922, 964 or 965")
}

/// The numbers of the list 980, without those of further lists.
fn listed(tester: &mut Tester, drive: (Channel, u8)) -> Course<Vec<u16>> {
    let mut list = Vec::new();
    // As many as there are: fewer and fewer at a time.
    let mut elements = 100;
    while elements > 0 && list.len() < 1000 {
        let from = u16::try_from(list.len()).unwrap_or(u16::MAX);
        match read(tester, drive, 20, value(980, elements, from))? {
            Ok((_, octets)) => {
                let numbers = octets
                    .chunks_exact(2)
                    .map(|pair| pair.iter().fold(0, |sum, octet| sum << 8 | u16::from(*octet)));
                list.extend(numbers);
                if list.contains(&0) {
                    break;
                }
            }
            Err(_) => elements /= 2,
        }
    }
    let end = list.iter().position(|pnu| *pnu == 0).unwrap_or(list.len());
    list.truncate(end);
    Ok(list)
}

/// One of these errors.
fn is_error(said: Said, errors: &[u16], what: &str) -> Course {
    match said {
        Err(refused) if errors.contains(&refused.error.0) => Ok(()),
        Err(ParameterRefused { error: ParameterError(got), .. }) => {
            let expected: Vec<String> = errors.iter().map(|error| format!("{error:02X}")).collect();
            broken(format!("{what} is refused with error {got:02X}, expected {}", expected.join(" or ")))
        }
        Ok(_) => broken(format!("{what} is carried out")),
    }
}

fn r89(tester: &mut Tester) -> Course {
    let drive = drive(tester)?;
    let other = ParameterAddress { attribute: Attribute::Unknown(0x50), ..value(922, 0, 0) };
    for (address, errors, what) in [
        (value(65535, 0, 0), &[0x00][..], "PNU 65535"),
        (value(964, 1, 200), &[0x03], "element 200 of PNU 964"),
        (value(922, 1, 5), &[0x03, 0x04], "element 5 of PNU 922"),
        (other, &[0x16], "the attribute 50"),
    ] {
        let said = read(tester, drive, 21, address)?;
        is_error(said, errors, what)?;
    }
    Ok(())
}

/// A parameter that can be changed without harm: how many failures of the sign of life are tolerated.
const CHANGED: u16 = 925;

/// What a change says.
fn change(
    tester: &mut Tester,
    drive: (Channel, u8),
    address: ParameterAddress,
    values: Values<'_>,
) -> Course<(usize, Said)> {
    let (octets, said) = results(tester, drive, ParameterRequest::change(22, 0, &[(address, values)]))?;
    match said.into_iter().next() {
        Some(said) => Ok((octets.len(), said)),
        None => broken("the response has no result"),
    }
}

/// What is in the parameter that can be changed.
fn changeable(tester: &mut Tester, drive: (Channel, u8)) -> Course<Vec<u8>> {
    match read(tester, drive, 23, value(CHANGED, 0, 0))? {
        Ok((_, octets)) => Ok(octets),
        Err(_) => inapplicable("the drive has no PNU 925, which can be changed without harm"),
    }
}

fn d01(tester: &mut Tester) -> Course {
    may_write(tester)?;
    let drive = drive(tester)?;
    let word = Values { format: Format::WORD, count: 1, octets: &[0, 1] };
    let (_, said) = change(tester, drive, value(964, 1, 0), word)?;
    is_error(said, &[0x01], "a change of PNU 964")?;
    changeable(tester, drive)?;
    let float = Values { format: Format::FLOAT, count: 1, octets: &[0; 4] };
    let (_, said) = change(tester, drive, value(CHANGED, 0, 0), float)?;
    is_error(said, &[0x05], "a change of PNU 925 to a floating point number")?;
    let two = Values { format: Format::WORD, count: 2, octets: &[0, 1, 0, 1] };
    let (_, said) = change(tester, drive, value(CHANGED, 0, 0), two)?;
    is_error(said, &[0x18], "a change of one element with two values")
}

fn r90(tester: &mut Tester) -> Course {
    let drive = drive(tester)?;
    let addresses = [value(922, 0, 0), value(65535, 0, 0), value(965, 0, 0)];
    let (octets, said) = results(tester, drive, ParameterRequest::read(24, 0, &addresses))?;
    if octets.get(1) != Some(&0x81) {
        return broken(format!(
            "one of three parameters is wrong, and the response is no 81: {}",
            crate::explain::hex(&octets)
        ));
    }
    let alone =
        [must_read(tester, drive, 25, value(922, 0, 0))?, must_read(tester, drive, 26, value(965, 0, 0))?];
    match &said[..] {
        [Ok((_, first)), Err(refused), Ok((_, third))]
            if [first, third] == [&alone[0], &alone[1]] && refused.error == ParameterError(0) =>
        {
            Ok(())
        }
        [..] => broken(format!("the response to three parameters is {}", crate::explain::hex(&octets))),
    }
}

fn d02(tester: &mut Tester) -> Course {
    may_write(tester)?;
    let drive = drive(tester)?;
    let own = changeable(tester, drive)?;
    let values = Values { format: Format::WORD, count: 1, octets: &own };
    match change(tester, drive, value(CHANGED, 0, 0), values)? {
        (4, Ok(_)) => Ok(()),
        (len, Ok(_)) => broken(format!("a change is answered with {len} octets, expected 4")),
        (_, Err(refused)) => broken(format!("a change of PNU 925 to its own value is refused: {refused}")),
    }
}

fn r91(tester: &mut Tester) -> Course {
    drive(tester)?;
    tester.release()?;
    let channel = tester.open()?;
    let result = tester.read_record(channel, (0, PARAMETER_INDEX), MAX_DATA)?;
    is_refused(result, ErrorCode::STATE_CONFLICT, "Read of record 47 without a Write")
}

/// Octets of a description.
const DESCRIPTION: usize = 46;

/// The whole description of a parameter.
fn description(tester: &mut Tester, drive: (Channel, u8), pnu: u16) -> Course<Said> {
    let address = ParameterAddress { attribute: Attribute::Description, elements: 1, pnu, subindex: 0 };
    read(tester, drive, 27, address)
}

fn r92(tester: &mut Tester) -> Course {
    let drive = drive(tester)?;
    match description(tester, drive, 922)? {
        Ok((_, octets)) if octets.len() == DESCRIPTION => Ok(()),
        Ok((_, octets)) => {
            broken(format!("the description of PNU 922 has {} octets, expected 46", octets.len()))
        }
        Err(refused) if refused.error == ParameterError(0x09) => {
            inapplicable("the drive has no description of PNU 922")
        }
        Err(refused) => broken(format!("the description of PNU 922 is refused: {refused}")),
    }
}

fn d03(tester: &mut Tester) -> Course {
    let drive = drive(tester)?;
    let list = listed(tester, drive)?;
    for pnu in list.into_iter().filter(|pnu| !(980..=989).contains(pnu)).take(SOME) {
        if let Err(refused) = read(tester, drive, 28, value(pnu, 0, 0))?
            && refused.error == ParameterError(0x00)
        {
            return broken(format!("PNU {pnu} is in the list 980, and there is no such parameter"));
        }
    }
    Ok(())
}
