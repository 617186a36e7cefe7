//! Nodes that a file describes: each file is read once, and its tables are held until the program ends.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::{Choice, Choices, Wrong};
use crate::can_bus::canopen::eds::Sheet;
use crate::device_file::Level;
use crate::devices::CanopenDevice;
use crate::devices::from_eds::{Dictionary, FromEds};
use crate::eds::{Content, Eds};
use crate::host::can::Product;
use crate::host::device_file::{domain_of_file, eds_octets_of_file};

/// A device on CANopen that a file describes.
pub struct NodeFile {
    /// Its name on the command line.
    pub name: &'static str,
    /// What can be chosen about it.
    pub choices: &'static [Choice],
}

impl NodeFile {
    /// The device of the file that is named.
    ///
    /// # Errors
    /// What is wrong with the file.
    pub(super) fn product(&self, choices: &Choices) -> Result<&'static Product, Wrong> {
        let file = choices.file("eds").unwrap_or(Path::new(""));
        self.held(file).map_err(|words| Wrong::at("eds", words))
    }

    fn held(&self, file: &Path) -> Result<&'static Product, String> {
        let octets = eds_octets_of_file(file)?;
        let mut shelf = SHELF.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(held) = shelf.held.iter().find(|held| held.file == file && held.octets == octets) {
            return Ok(held.product);
        }
        let in_file = |error: &dyn core::fmt::Display| format!("{}: {error}", file.display());
        let mut eds = Eds::read(&octets).map_err(|error| in_file(&error))?;
        for hint in eds.hints.iter().filter(|hint| hint.level == Level::Warning) {
            tracing::warn!("{}: {hint}", file.display());
        }
        read_domains(&mut eds, file)?;
        for added in eds.complete() {
            tracing::info!("{}: {added}", file.display());
        }
        let cost = cost(&eds, octets.len());
        if shelf.cost.saturating_add(cost) > MOST_HELD {
            let files = shelf.held.len();
            return Err(in_file(&format_args!(
                "no room for its tables beside those of {files} other files; use fewer files, or start the program anew"
            )));
        }
        shelf.cost += cost;
        let product = self.made(Dictionary::hold(eds), file);
        shelf.held.push(Held { file: file.to_owned(), octets, product });
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
    product: &'static Product,
}

static SHELF: Mutex<Shelf> = Mutex::new(Shelf { held: Vec::new(), cost: 0 });

/// The most octets of all that is held, about.
const MOST_HELD: usize = 256 << 20;
/// Octets of the tables of one entry, about.
const OF_ENTRY: usize = 512;

fn cost(eds: &Eds, file: usize) -> usize {
    let entries = eds.objects.values().flat_map(|object| object.entries.values());
    entries.fold(2 * file, |cost, entry| match &entry.content {
        Content::Octets(octets) => cost + OF_ENTRY + octets.len(),
        Content::None | Content::Whole(_) | Content::Real(_) => cost + OF_ENTRY,
    })
}

/// The contents of domains that are files beside this one.
fn read_domains(eds: &mut Eds, file: &Path) -> Result<(), String> {
    for entry in eds.objects.values_mut().flat_map(|object| object.entries.values_mut()) {
        if let Some(name) = &entry.file {
            let path = file.parent().unwrap_or(Path::new("")).join(name);
            entry.content = Content::Octets(domain_of_file(&path)?);
        }
    }
    Ok(())
}
