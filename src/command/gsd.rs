//! `profidrive gsd`: a device file in words or as JSON, and what a master sends for chosen modules.

mod configured;

use std::io::{self, Write};
use std::path::Path;

use crate::gsd::{DiagArea, DiagBit, Gsd, Module, Parameter, Policy, PrmPart, Station};
use crate::host::gsd_of_file;
use crate::profibus::dp::IoLengths;
use serde_json::{Value, json};

use self::configured::Configured;
use super::Failure;
use super::args;
use super::device_file::{self, Said};

/// With more modules or parameters than these they are shown when they are asked for.
const SHOWN: usize = 16;
/// The same of the texts of one parameter, and of all bits and areas of a diagnosis.
const SHOWN_TEXTS: usize = 8;
const SHOWN_DIAGNOSIS: usize = 40;

pub(crate) fn gsd(args: &args::Gsd) -> Result<(), Failure> {
    device_file::print(|out| match (&args.check, &args.file) {
        (Some(args::Check::Check { file }), _) => check(out, file),
        (None, Some(file)) => {
            let gsd = read(file)?;
            let said = match (&args.modules[..], args.json) {
                ([], true) => writeln!(out, "{}", as_json(&gsd)),
                ([], false) => match &args.list {
                    Some(text) => list(out, &gsd, text),
                    None => explain(out, &gsd),
                },
                (names, json) => {
                    let configured = Configured::of(gsd, &names.join(","), &args.set)?;
                    if json { writeln!(out, "{}", configured.json()) } else { configured.say(out) }
                }
            };
            Ok((said, Ok(())))
        }
        (None, None) => Err(device_file::missing("gsd")),
    })
}

/// A file, read: what is wrong with it is an error of the command line.
pub(super) fn read(file: &Path) -> Result<Gsd, Failure> {
    gsd_of_file(file).map_err(Failure::Usage)
}

fn check(out: &mut dyn Write, file: &Path) -> Result<Said, Failure> {
    let gsd = read(file)?;
    let (said, outcome) = device_file::check(out, file, &gsd.hints);
    if let Err(error) = Station::new(gsd, Policy::PROPOSED) {
        return Ok((said, Err(Failure::Other(format!("{}: {error}", file.display())))));
    }
    Ok((said, outcome))
}

fn explain(out: &mut dyn Write, gsd: &Gsd) -> io::Result<()> {
    writeln!(out, "{} {}, ident 0x{:04X}", gsd.vendor, gsd.model, gsd.ident)?;
    let (hardware, software) = (&gsd.hardware, &gsd.software);
    writeln!(out, "  revision {}, hardware {hardware}, software {software}", gsd.revision)?;
    writeln!(out, "  GSD revision {}, {}", gsd.gsd_revision, gsd.code_page.name())?;
    for (name, text) in [("order number", &gsd.order_number), ("about", &gsd.info)] {
        if !text.is_empty() {
            writeln!(out, "  {name}: {text}")?;
        }
    }
    writeln!(out, "Rates")?;
    for rate in gsd.rates.iter() {
        writeln!(
            out,
            "  {rate}, replies begin within {} bit times",
            gsd.rates.max_tsdr(rate).unwrap_or_default()
        )?;
    }
    let on = gsd.flags.by_keyword().into_iter().filter(|flag| flag.1).map(|flag| flag.0);
    writeln!(out, "Supports: {}", on.collect::<Vec<_>>().join(", "))?;
    writeln!(out, "Lengths")?;
    for (name, len) in [
        ("Max_Module", gsd.max_module),
        ("Max_Input_Len", gsd.max_input_len),
        ("Max_Output_Len", gsd.max_output_len),
        ("Max_Data_Len", gsd.max_data_len),
    ] {
        writeln!(out, "  {name} {}", len.map_or("not given".into(), |len| len.to_string()))?;
    }
    let (least, most) = gsd.user_prm_lengths();
    writeln!(out, "  user parameters {least} to {most} octets, diagnosis {} octets", gsd.max_diag_len)?;
    let kind =
        if gsd.is_modular() { "Modules, to choose from" } else { "Modules, all of them in this order" };
    if gsd.modules.len() > SHOWN {
        let count = gsd.modules.len();
        writeln!(out, "{kind}: {count}; --list prints them, --list TEXT those whose names contain TEXT")?;
    } else {
        writeln!(out, "{kind}")?;
        modules(out, gsd, "", SHOWN_TEXTS)?;
    }
    for slot in &gsd.slots {
        let list: Vec<_> = slot.references.iter().map(|(first, last)| format!("{first}-{last}")).collect();
        writeln!(out, "Slot {} {}: module references {}", slot.number, slot.name, list.join(", "))?;
    }
    writeln!(out, "User parameters of the station, by default {}", hex(&gsd.default_user_prm(&[])))?;
    let count = gsd.user_prm.fields(gsd).count();
    if count > SHOWN {
        writeln!(
            out,
            "  {count} parameters; --list prints them, --list TEXT those whose names contain TEXT"
        )?;
    } else {
        explain_part(out, gsd, &gsd.user_prm, "  ", SHOWN_TEXTS)?;
    }
    let has_texts = !(gsd.diag_bits.is_empty() && gsd.diag_areas.is_empty());
    if has_texts || !(gsd.diag_types.is_empty() && gsd.channel_diag.is_empty()) {
        writeln!(out, "Diagnosis")?;
    }
    let statuses = gsd.diag_types.iter().map(|status| texts_of(&status.bits, &status.areas));
    let count = texts_of(&gsd.diag_bits, &gsd.diag_areas) + statuses.sum::<usize>() + gsd.channel_diag.len();
    if count > SHOWN_DIAGNOSIS {
        writeln!(out, "  {count} texts; --list prints them, --list TEXT those that contain TEXT")?;
    } else {
        diagnosis(out, gsd, "")?;
    }
    if !gsd.hints.is_empty() {
        writeln!(out, "Odd")?;
    }
    gsd.hints.iter().try_for_each(|hint| writeln!(out, "  {hint}"))
}

fn texts_of(bits: &[DiagBit], areas: &[DiagArea]) -> usize {
    bits.len() + areas.iter().map(|area| area.values.len()).sum::<usize>()
}

/// The texts of the diagnosis that contain this.
fn diagnosis(out: &mut dyn Write, gsd: &Gsd, text: &str) -> io::Result<()> {
    explain_texts(out, &gsd.diag_bits, &gsd.diag_areas, "  ", text)?;
    for status in &gsd.diag_types {
        if text.is_empty() {
            writeln!(out, "  status blocks of type {}", status.number)?;
        }
        explain_texts(out, &status.bits, &status.areas, "    ", text)?;
    }
    for (number, said) in gsd.channel_diag.iter().filter(|(_, said)| contains(said, text)) {
        writeln!(out, "  channel error {number}: {said}")?;
    }
    Ok(())
}

fn contains(name: &str, text: &str) -> bool {
    name.to_lowercase().contains(&text.to_lowercase())
}

/// Modules, parameters of the station and texts of the diagnosis that contain this.
fn list(out: &mut dyn Write, gsd: &Gsd, text: &str) -> io::Result<()> {
    let (mut found, mut parameters, mut texts) = (Vec::new(), Vec::new(), Vec::new());
    modules(&mut found, gsd, text, usize::MAX)?;
    for field in gsd.user_prm.fields(gsd).filter(|field| contains(&field.1.name, text)) {
        explain_field(&mut parameters, gsd, field, "  ", usize::MAX)?;
    }
    diagnosis(&mut texts, gsd, text)?;
    let parts = [("Modules", found), ("User parameters of the station", parameters), ("Diagnosis", texts)];
    for (heading, lines) in parts.iter().filter(|(_, lines)| !lines.is_empty()) {
        writeln!(out, "{heading}")?;
        out.write_all(lines)?;
    }
    Ok(())
}

/// The modules whose names contain this.
fn modules(out: &mut dyn Write, gsd: &Gsd, text: &str, shown_texts: usize) -> io::Result<()> {
    for module in gsd.modules.iter().filter(|module| contains(&module.name, text)) {
        let preset = if module.preset { ", preset" } else { "" };
        let IoLengths { outputs, inputs } = module.lengths;
        writeln!(out, "  {}: {}; {outputs} out, {inputs} in{preset}", module.name, hex(&module.identifiers))?;
        explain_part(out, gsd, &module.prm, "    ", shown_texts)?;
    }
    Ok(())
}

fn explain_texts(
    out: &mut dyn Write,
    bits: &[DiagBit],
    areas: &[DiagArea],
    indent: &str,
    wanted: &str,
) -> io::Result<()> {
    for bit in bits.iter().filter(|bit| contains(&bit.text, wanted)) {
        writeln!(out, "{indent}bit {}{}: {}", bit.bit, if bit.inverted { " is 0" } else { "" }, bit.text)?;
    }
    for area in areas {
        for (value, text) in area.values.iter().filter(|(_, text)| contains(text, wanted)) {
            writeln!(out, "{indent}bits {}-{} = {value}: {text}", area.first, area.last)?;
        }
    }
    Ok(())
}

fn explain_part(
    out: &mut dyn Write,
    gsd: &Gsd,
    part: &PrmPart,
    indent: &str,
    shown_texts: usize,
) -> io::Result<()> {
    part.fields(gsd).try_for_each(|field| explain_field(out, gsd, field, indent, shown_texts))
}

fn explain_field(
    out: &mut dyn Write,
    gsd: &Gsd,
    (offset, parameter): (usize, &Parameter),
    indent: &str,
    shown_texts: usize,
) -> io::Result<()> {
    let Parameter { name, field, default, allowed, .. } = parameter;
    write!(out, "{indent}octet {offset}, {field}: {name} = {default}")?;
    if let Some(text) = gsd.text_of(parameter, *default) {
        write!(out, " ({text})")?;
    }
    writeln!(out, "; {allowed}")?;
    let texts = parameter.text_ref.and_then(|texts| gsd.texts.get(&texts));
    match texts {
        Some(texts) if texts.len() > shown_texts => {
            writeln!(out, "{indent}  {} texts; --list prints them", texts.len())
        }
        Some(texts) => texts.iter().try_for_each(|(value, text)| writeln!(out, "{indent}  {value} = {text}")),
        None => Ok(()),
    }
}

fn as_json(gsd: &Gsd) -> Value {
    let rates = gsd.rates.iter().map(
        |rate| json!({ "bits_per_second": rate.bits_per_second(), "max_tsdr": gsd.rates.max_tsdr(rate) }),
    );
    let slots = gsd
        .slots
        .iter()
        .map(|slot| json!({ "number": slot.number, "name": slot.name, "references": slot.references }));
    let modules = gsd.modules.iter().map(|module| module_json(gsd, module));
    let types = gsd.diag_types.iter().map(|status| {
        json!({ "type": status.number, "bits": bits_json(&status.bits), "areas": areas_json(&status.areas) })
    });
    let flags = gsd.flags.by_keyword().into_iter().map(|(keyword, on)| (keyword.to_owned(), Value::from(on)));
    json!({
        "vendor": gsd.vendor,
        "model": gsd.model,
        "revision": gsd.revision,
        "hardware": gsd.hardware,
        "software": gsd.software,
        "order_number": gsd.order_number,
        "info": gsd.info,
        "ident": gsd.ident,
        "gsd_revision": gsd.gsd_revision,
        "code_page": gsd.code_page.name(),
        "rates": rates.collect::<Vec<_>>(),
        "flags": flags.collect::<serde_json::Map<_, _>>(),
        "modular": gsd.is_modular(),
        "max_module": gsd.max_module,
        "max_input_len": gsd.max_input_len,
        "max_output_len": gsd.max_output_len,
        "max_data_len": gsd.max_data_len,
        "max_diag_len": gsd.max_diag_len,
        "user_prm_lengths": gsd.user_prm_lengths(),
        "default_user_prm": gsd.default_user_prm(&[]),
        "parameters": part_json(gsd, &gsd.user_prm),
        "modules": modules.collect::<Vec<_>>(),
        "slots": slots.collect::<Vec<_>>(),
        "diag_bits": bits_json(&gsd.diag_bits),
        "diag_areas": areas_json(&gsd.diag_areas),
        "diag_types": types.collect::<Vec<_>>(),
        "channel_diag": gsd.channel_diag,
        "hints": device_file::hints_json(&gsd.hints),
    })
}

fn bits_json(bits: &[DiagBit]) -> Value {
    bits.iter().map(|bit| json!({ "bit": bit.bit, "inverted": bit.inverted, "text": bit.text })).collect()
}

fn areas_json(areas: &[DiagArea]) -> Value {
    areas
        .iter()
        .map(|area| json!({ "first": area.first, "last": area.last, "values": area.values }))
        .collect()
}

fn module_json(gsd: &Gsd, module: &Module) -> Value {
    json!({
        "name": module.name,
        "identifiers": module.identifiers,
        "outputs": module.lengths.outputs,
        "inputs": module.lengths.inputs,
        "reference": module.reference,
        "preset": module.preset,
        "default_prm": module.prm.default_octets(gsd),
        "parameters": part_json(gsd, &module.prm),
    })
}

fn part_json(gsd: &Gsd, part: &PrmPart) -> Vec<Value> {
    let one = |(offset, parameter): (usize, &Parameter)| {
        let texts = parameter.text_ref.and_then(|texts| gsd.texts.get(&texts));
        json!({
            "offset": offset,
            "name": parameter.name,
            "type": parameter.field.to_string(),
            "default": parameter.default,
            "allowed": parameter.allowed.to_string(),
            "texts": texts,
        })
    };
    part.fields(gsd).map(one).collect()
}

fn hex(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02X}")).collect::<Vec<_>>().join(" ")
}
