//! Nodes that a file describes: each file is read once, and its tables are held until the program ends.

use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::{Choices, Device, NodeFile, Wrong};
use crate::can_bus::canopen::NodeId;
use crate::can_bus::canopen::eds::Sheet;
use crate::can_bus::canopen::parameter::MAX_CONSUMERS;
use crate::can_bus::canopen::pdo::{self, MAX_PDOS};
use crate::device_file::Level;
use crate::devices::CanopenDevice;
use crate::devices::from_eds::{Dictionary, FromEds};
use crate::eds::{Content, Eds};
use crate::host::can::Product;
use crate::host::device_file::{domain_of_file, eds_octets_of_file, eds_of_file};

/// The number that a configuration file gives its node.
///
/// # Errors
/// What is wrong with the file.
pub(super) fn number(file: &Path) -> Result<Option<u8>, String> {
    let node = eds_of_file(file)?.commissioning.and_then(|commissioning| commissioning.node);
    Ok(node.map(NodeId::number))
}

/// The device of the file that is chosen.
///
/// # Errors
/// What is wrong with the file.
pub(super) fn product(of: &NodeFile, choices: &Choices) -> Result<&'static Product, Wrong> {
    let file = choices.file("eds").unwrap_or(Path::new(""));
    let is_memory = choices.word("profile") == Some("none");
    of.held(file, is_memory).map_err(|words| Wrong::at("eds", words))
}

/// The device of a file, with what its profile asks for.
///
/// # Errors
/// What is wrong with the file.
pub(crate) fn product_of_file(file: &Path) -> Result<&'static Product, String> {
    Device::of_file().ok_or_else(|| "no device of a file".to_owned())?.held(file, false)
}

impl NodeFile {
    fn held(&self, file: &Path, is_memory: bool) -> Result<&'static Product, String> {
        let octets = eds_octets_of_file(file)?;
        let mut shelf = SHELF.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(held) = shelf.held.iter().find(|held| held.is_of(file, &octets, is_memory)) {
            return Ok(held.product);
        }
        let in_file = |error: &dyn core::fmt::Display| format!("{}: {error}", file.display());
        let mut eds = Eds::read(&octets).map_err(|error| in_file(&error))?;
        for hint in eds.hints.iter().filter(|hint| hint.level == Level::Warning) {
            tracing::warn!("{}: {hint}", file.display());
        }
        for odd in read_domains(&mut eds, file) {
            tracing::warn!("{}: {odd}", file.display());
        }
        for added in eds.complete() {
            tracing::info!("{}: {added}", file.display());
        }
        for plain in without_service(&eds) {
            tracing::info!("{}: {plain}", file.display());
        }
        let cost = cost(&eds, octets.len());
        if shelf.cost.saturating_add(cost) > MOST_HELD {
            let files = shelf.held.len();
            return Err(in_file(&format_args!(
                "no room for its tables beside those of {files} other files; use fewer files, or start the program anew"
            )));
        }
        shelf.cost += cost;
        let dictionary = if is_memory { Dictionary::hold_as_memory(eds) } else { Dictionary::hold(eds) };
        let product = self.made(dictionary, file);
        shelf.held.push(Held { file: file.to_owned(), octets, is_memory, product });
        Ok(product)
    }

    fn made(&self, dictionary: &'static Dictionary, file: &Path) -> &'static Product {
        let device = &dictionary.eds.device;
        let stem = || file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let product_name = if device.product.is_empty() { stem().leak() } else { &*device.product };
        let sheet =
            Sheet { vendor_name: &device.vendor, product_name, kilobits: &device.kilobits, ..Sheet::PLAIN };
        let product = Product {
            name: self.name,
            sheet,
            vocabulary: &dictionary.vocabulary,
            choices: self.choices,
            tells: None,
            story: &[],
            objects: Box::leak(Box::new(move |_: &Choices| dictionary.objects)),
            quirks: Vec::new,
            make: Box::leak(Box::new(move |node, _: &Choices, memory, _| -> Box<dyn CanopenDevice> {
                Box::new(FromEds::on_node(dictionary, node, memory))
            })),
        };
        Box::leak(Box::new(product))
    }
}

/// Files whose tables are held.
struct Shelf {
    held: Vec<Held>,
    cost: usize,
}

struct Held {
    file: PathBuf,
    octets: Vec<u8>,
    is_memory: bool,
    product: &'static Product,
}

impl Held {
    fn is_of(&self, file: &Path, octets: &[u8], is_memory: bool) -> bool {
        self.file == file && self.octets == octets && self.is_memory == is_memory
    }
}

static SHELF: Mutex<Shelf> = Mutex::new(Shelf { held: Vec::new(), cost: 0 });

/// The most octets of all that is held, about.
const MOST_HELD: usize = 256 << 20;
/// Octets of the tables of one entry, about.
const OF_ENTRY: usize = 512;

/// What is more than a node has: it can be read and written, and does nothing.
fn without_service(eds: &Eds) -> Vec<String> {
    let mut all = Vec::new();
    for (name, first) in [("RPDOs", 0x1400), ("TPDOs", 0x1800)] {
        let indices = eds.objects.range(first..first + pdo::OBJECTS).map(|(index, _)| index);
        let mut rest = indices.skip(MAX_PDOS).peekable();
        if let Some(index) = rest.peek().copied() {
            let count = rest.count();
            all.push(format!("{count} {name} from {index:04X}h on are values only: a node has {MAX_PDOS}"));
        }
    }
    let consumers = eds.objects.get(&0x1016).map_or(0, |object| object.entries.range(1..).count());
    if consumers > MAX_CONSUMERS {
        all.push(format!("1016h has {consumers} entries: the first {MAX_CONSUMERS} supervise a node"));
    }
    all
}

fn cost(eds: &Eds, file: usize) -> usize {
    let entries = eds.objects.values().flat_map(|object| object.entries.values());
    entries.fold(2 * file, |cost, entry| match &entry.content {
        Content::Octets(octets) => cost + OF_ENTRY + octets.len(),
        Content::None | Content::Whole(_) | Content::Real(_) => cost + OF_ENTRY,
    })
}

/// The contents of domains that are files beside this one; says which stay empty, and why. A file that comes from elsewhere
/// must not show what is not its own.
fn read_domains(eds: &mut Eds, file: &Path) -> Vec<String> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let mut odd = Vec::new();
    for entry in eds.objects.values_mut().flat_map(|object| object.entries.values_mut()) {
        let Some(name) = &entry.file else { continue };
        let is_beside = Path::new(name).components().all(|part| matches!(part, Component::Normal(_)));
        let read = if is_beside {
            domain_of_file(&folder.join(name))
        } else {
            Err(format!("'{name}' is not in the folder of this file"))
        };
        match read {
            Ok(octets) => entry.content = Content::Octets(octets),
            Err(why) => odd.push(format!("{}: {why}: the domain is empty", entry.place)),
        }
    }
    odd
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODE: NodeFile = NodeFile { name: "eds-node", choices: &[], number, product };

    #[test]
    fn the_tables_of_a_file_are_held_once() {
        let file = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/eds/pump.eds"));
        let (one, other) = (NODE.held(file, false).unwrap(), NODE.held(file, false).unwrap());
        assert!(core::ptr::eq(one, other));
        assert!(!core::ptr::eq(one, NODE.held(file, true).unwrap()));
        assert_eq!((one.sheet.product_name, one.sheet.kilobits), ("Pump", &[125, 250, 500, 1000][..]));
    }

    #[test]
    fn what_is_more_than_a_node_has_is_said() {
        let pdos: String = (0x1400..0x1441).map(|index| format!("[{index:04X}]\nDataType=7\n")).collect();
        let rest = "[18C0]\nDataType=7\n[1016]\nDataType=7\nCompactSubObj=9\n";
        let eds = Eds::read((pdos + rest).as_bytes()).unwrap();
        assert_eq!(
            without_service(&eds),
            [
                "1 RPDOs from 1440h on are values only: a node has 64",
                "1016h has 9 entries: the first 8 supervise a node"
            ]
        );
    }

    #[test]
    fn a_domain_is_a_file_of_the_same_folder_or_empty() {
        let outside = tempfile::tempdir().unwrap();
        let folder = outside.path().join("machine");
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join("program.bin"), b"program").unwrap();
        std::fs::write(outside.path().join("secret.bin"), b"secret").unwrap();
        let absolute = outside.path().join("secret.bin").display().to_string();
        let names = ["program.bin", "absent.bin", "../secret.bin", &absolute];
        let text: String = (0x2000..)
            .zip(names)
            .map(|(index, name)| {
                format!("[{index:X}]\nObjectType=2\nDataType=15\nAccessType=ro\nUploadFile={name}\n")
            })
            .collect();
        let mut eds = Eds::read(text.as_bytes()).unwrap();
        let odd = read_domains(&mut eds, &folder.join("node.dcf"));
        let held = |index| eds.entry(index, 0).unwrap().content.clone();
        assert_eq!(held(0x2000), Content::Octets(b"program".to_vec()));
        assert_eq!([held(0x2001), held(0x2002), held(0x2003)], [Content::None, Content::None, Content::None]);
        assert_eq!(odd.len(), 3, "{odd:?}");
        assert!(
            odd[0].starts_with("line 6, column 1: cannot read") && odd[0].ends_with(": the domain is empty")
        );
        let why = "line 11, column 1: '../secret.bin' is not in the folder of this file: the domain is empty";
        assert_eq!(odd[1], why);
    }
}
