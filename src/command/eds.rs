//! `profidrive eds`: the electronic data sheet of a device on stdout, and one of another device in words or as JSON.

use std::io::{self, Write};

use serde_json::{Value, json};

use super::Failure;
use super::args;
use super::args::{CheckFile, Sheet};
use super::device_file::{self, Said};
use crate::can_bus::canopen::{DataType, NodeId};
use crate::eds::{Content, Eds, Entry, Limit, Object, Profile};
use crate::host::eds_of_file;

/// Prints it.
pub(crate) fn eds(args: &args::Eds) -> Result<(), Failure> {
    device_file::print(|out| match (&args.check, &args.of) {
        (Some(CheckFile::Check { file }), _) => {
            let eds = eds_of_file(file).map_err(Failure::Usage)?;
            Ok(device_file::check(out, file, &eds.hints))
        }
        (None, Some(Sheet::Device(device))) => Ok((out.write_all(device.eds().as_bytes()), Ok(()))),
        (None, Some(Sheet::File(file))) => {
            let eds = eds_of_file(file).map_err(Failure::Usage)?;
            Ok(said(out, args, &eds))
        }
        (None, None) => Err(device_file::missing("eds")),
    })
}

fn said(out: &mut dyn Write, args: &args::Eds, eds: &Eds) -> Said {
    let said = if args.json {
        writeln!(out, "{}", as_json(eds))
    } else {
        explain(out, eds).and_then(|()| if args.objects { explain_objects(out, eds) } else { Ok(()) })
    };
    (said, Ok(()))
}

/// Services that show in the dictionary.
const SERVICES: [(&str, u16); 8] = [
    ("heartbeat", 0x1017),
    ("guarding", 0x100C),
    ("heartbeat consumer", 0x1016),
    ("SYNC", 0x1005),
    ("EMCY", 0x1014),
    ("TIME", 0x1012),
    ("store", 0x1010),
    ("restore", 0x1011),
];

/// Direction, first communication parameter and first mapping of the PDOs.
const PDOS: [(&str, u16, u16); 2] = [("Receive PDOs", 0x1400, 0x1600), ("Transmit PDOs", 0x1800, 0x1A00)];

/// The most PDOs of one direction.
const MOST_PDOS: u16 = 0x200;

fn explain(out: &mut dyn Write, eds: &Eds) -> io::Result<()> {
    let device = &eds.device;
    writeln!(out, "{} {}, {}", named(&device.vendor), named(&device.product), eds.profile())?;
    let identity: Vec<_> = [
        ("vendor", 1, device.vendor_number),
        ("product", 2, device.product_number),
        ("revision", 3, device.revision_number),
    ]
    .into_iter()
    .map(|(name, sub, otherwise)| match eds.number(0x1018, sub).or(otherwise.map(Into::into)) {
        Some(number) => format!("{name} {number:X}h"),
        None => format!("{name} not given"),
    })
    .collect();
    writeln!(out, "  identity: {}", identity.join(", "))?;
    for (name, text) in [("order code", &device.order_code), ("about", &eds.file.description)] {
        if !text.is_empty() {
            writeln!(out, "  {name}: {text}")?;
        }
    }
    let file = &eds.file;
    let facts = [
        ("file ", &file.name),
        ("version ", &file.version),
        ("of ", &file.date),
        ("by ", &file.created_by),
        ("EDS version ", &file.eds_version),
    ];
    let facts: Vec<_> = facts
        .into_iter()
        .filter(|(_, fact)| !fact.is_empty())
        .map(|(name, fact)| format!("{name}{fact}"))
        .collect();
    writeln!(out, "  {}", [facts, vec![eds.code_page.name().to_owned()]].concat().join(", "))?;
    if let Some(commissioning) = &eds.commissioning {
        let node = commissioning.node.map_or("no node-ID".into(), |node| format!("node {}", node.number()));
        write!(out, "  configured (DCF): {node}")?;
        for name in [&commissioning.node_name, &commissioning.network_name]
            .into_iter()
            .filter(|name| !name.is_empty())
        {
            write!(out, ", {name}")?;
        }
        match commissioning.kilobits {
            Some(rate) => writeln!(out, ", {rate} kbit/s")?,
            None => writeln!(out)?,
        }
    }
    writeln!(out, "Rates: {}", or_none(device.kilobits.iter().map(|rate| format!("{rate} kbit/s"))))?;
    let services = SERVICES
        .iter()
        .filter(|(_, index)| eds.objects.contains_key(index))
        .map(|(name, _)| (*name).to_owned());
    writeln!(out, "Services: {}", or_none(services.chain(device.lss.then(|| "LSS".to_owned()))))?;
    let count = |range: core::ops::RangeInclusive<u16>| eds.objects.range(range).count();
    writeln!(
        out,
        "Objects: {} of communication, {} of the manufacturer, {} of profiles; {} entries",
        count(0x1000..=0x1FFF),
        count(0x2000..=0x5FFF),
        count(0x6000..=0xFFFF),
        eds.objects.values().map(|object| object.entries.len()).sum::<usize>(),
    )?;
    for (name, first, first_mapping) in PDOS {
        if eds.objects.range(first..first + MOST_PDOS).next().is_some() {
            writeln!(out, "{name}")?;
        }
        for index in eds.objects.range(first..first + MOST_PDOS).map(|(index, _)| *index) {
            explain_pdo(out, eds, index, first_mapping + (index - first), index - first + 1)?;
        }
    }
    match device_file::warnings(&eds.hints) {
        0 => Ok(()),
        warnings => writeln!(out, "Warnings: {warnings}; 'profidrive eds check FILE' lists them"),
    }
}

fn explain_pdo(out: &mut dyn Write, eds: &Eds, index: u16, mapping: u16, number: u16) -> io::Result<()> {
    let text = |entry: Option<&Entry>| entry.map_or_else(|| "not given".into(), value_text);
    let identifier = eds.entry(index, 1).map(|entry| (entry, &entry.content));
    let identifier = match identifier {
        Some((_, Content::Whole(number))) if !number.node_id => format!("{:X}h", number.offset),
        Some((entry, Content::Whole(_) | Content::None | Content::Real(_) | Content::Octets(_))) => {
            value_text(entry)
        }
        None => "no identifier".into(),
    };
    let mapped =
        eds.objects.get(&mapping).into_iter().flat_map(|object| object.entries.range(1..)).filter_map(
            |(_, entry)| {
                let Content::Whole(number) = entry.content else { return None };
                let word = u32::try_from(number.offset).ok().filter(|word| *word != 0)?;
                let [high, low, sub, bits] = word.to_be_bytes();
                let index = u16::from_be_bytes([high, low]);
                let name = match eds.objects.get(&index) {
                    Some(object) => object.name.as_str(),
                    None if index < 0x1000 => "gap",
                    None => "unknown",
                };
                Some(format!("{index:04X}h:{sub:02X} {name} ({bits} bits)"))
            },
        );
    writeln!(out, "  {number}: {identifier}, type {}: {}", text(eds.entry(index, 2)), or_none(mapped))
}

fn explain_objects(out: &mut dyn Write, eds: &Eds) -> io::Result<()> {
    writeln!(out, "Object dictionary")?;
    for object in eds.objects.values() {
        let index = object.index.0;
        if let [(0, entry)] = object.entries.iter().map(|(sub, entry)| (*sub, entry)).collect::<Vec<_>>()[..]
        {
            writeln!(out, "  {index:04X}h    {}", entry_text(&object.name, entry))?;
            continue;
        }
        writeln!(out, "  {index:04X}h    {}", object.name)?;
        for (sub, entry) in &object.entries {
            writeln!(out, "  {index:04X}h:{sub:02X} {}", entry_text(&entry.name, entry))?;
        }
    }
    Ok(())
}

/// `Target position: INTEGER32 rw = 0; -100..100, in PDOs`
fn entry_text(name: &str, entry: &Entry) -> String {
    let mut text = format!("{name}: {} {} = {}", entry.data.name(), entry.rights.name(), value_text(entry));
    let limit = |limit: Option<Limit>| limit.map_or_else(String::new, limit_text);
    if entry.low.is_some() || entry.high.is_some() {
        text += &format!("; {}..{}", limit(entry.low), limit(entry.high));
    }
    if entry.mappable {
        text += ", in PDOs";
    }
    text
}

fn value_text(entry: &Entry) -> String {
    match &entry.content {
        Content::None => "not given".into(),
        Content::Whole(number) => number.to_string(),
        Content::Real(number) => number.to_string(),
        Content::Octets(octets) if entry.data == DataType::UnicodeString => {
            format!("{:?}", unicode(octets))
        }
        Content::Octets(octets) => {
            entry.data.decode(octets).map_or_else(String::new, |value| value.to_string())
        }
    }
}

/// The text of a UNICODE_STRING.
fn unicode(octets: &[u8]) -> String {
    let units: Vec<u16> =
        octets.chunks_exact(2).filter_map(|pair| Some(u16::from_le_bytes(pair.try_into().ok()?))).collect();
    String::from_utf16_lossy(&units)
}

fn limit_text(limit: Limit) -> String {
    match limit {
        Limit::Whole(number) => number.to_string(),
        Limit::Real(number) => number.to_string(),
    }
}

fn named(text: &str) -> &str {
    if text.is_empty() { "(no name)" } else { text }
}

fn or_none(texts: impl Iterator<Item = String>) -> String {
    let texts: Vec<_> = texts.collect();
    if texts.is_empty() { "none".into() } else { texts.join(", ") }
}

fn as_json(eds: &Eds) -> Value {
    let device = &eds.device;
    let commissioning = eds.commissioning.as_ref().map(|commissioning| {
        json!({
            "node": commissioning.node.map(NodeId::number),
            "node_name": commissioning.node_name,
            "kilobits": commissioning.kilobits,
            "net_number": commissioning.net_number,
            "network_name": commissioning.network_name,
            "serial_number": commissioning.serial_number,
        })
    });
    json!({
        "vendor": device.vendor,
        "vendor_number": device.vendor_number,
        "product": device.product,
        "product_number": device.product_number,
        "revision_number": device.revision_number,
        "order_code": device.order_code,
        "profile": Some(eds.profile()).filter(|profile| *profile != Profile::None).map(Profile::number),
        "kilobits": device.kilobits,
        "granularity": device.granularity,
        "lss": device.lss,
        "file": {
            "name": eds.file.name,
            "version": eds.file.version,
            "eds_version": eds.file.eds_version,
            "description": eds.file.description,
            "created_by": eds.file.created_by,
            "date": eds.file.date,
            "code_page": eds.code_page.name(),
        },
        "commissioning": commissioning,
        "objects": eds.objects.values().map(object_json).collect::<Vec<_>>(),
        "hints": device_file::hints_json(&eds.hints),
    })
}

fn object_json(object: &Object) -> Value {
    let entries = object.entries.iter().map(|(sub, entry)| {
        json!({
            "sub": sub,
            "name": entry.name,
            "type": entry.data.name(),
            "access": entry.rights.name(),
            "value": value_json(entry),
            "low": entry.low.map(limit_json),
            "high": entry.high.map(limit_json),
            "mappable": entry.mappable,
        })
    });
    json!({
        "index": format!("{:04X}", object.index.0),
        "name": object.name,
        "denotation": object.denotation,
        "entries": entries.collect::<Vec<_>>(),
    })
}

/// A number as a number, a formula and what no JSON number holds as text.
fn value_json(entry: &Entry) -> Value {
    match &entry.content {
        Content::None => Value::Null,
        Content::Whole(number) => whole_json(*number),
        Content::Real(number) => json!(number),
        Content::Octets(octets) if entry.data == DataType::UnicodeString => json!(unicode(octets)),
        Content::Octets(octets) => match core::str::from_utf8(octets) {
            Ok(text) => json!(text),
            Err(_) => json!(octets),
        },
    }
}

fn limit_json(limit: Limit) -> Value {
    match limit {
        Limit::Whole(number) => whole_json(number),
        Limit::Real(number) => json!(number),
    }
}

fn whole_json(number: crate::eds::Number) -> Value {
    match (number.node_id, i64::try_from(number.offset)) {
        (false, Ok(whole)) => json!(whole),
        (true, _) | (false, Err(_)) => json!(number.to_string()),
    }
}
