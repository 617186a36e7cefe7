//! The specification of a device: one for `a,k=v`, TOML and JSON.

use std::path::Path;

use super::choice::{near, quirk_refusal};
use super::{Choice, Choices, Device, Given, Group, Prepared, Takes, Wrong, objects};
use crate::can_bus::canopen::NodeId;
use crate::can_bus::canopen::node::storage::Eeprom;
use crate::host::can::{NodeSignal, Product};
use crate::profibus::fdl::Address;
use crate::time::Instant;

/// The number that a configuration file gives its node.
fn number_of_file(text: &str, group: Group) -> Result<String, Wrong> {
    let file = text.split(',').find_map(|part| part.strip_prefix("eds=")).filter(|file| !file.is_empty());
    let file = file.ok_or_else(|| group.without_place())?;
    let of_file = Device::of_file().ok_or_else(|| group.without_place())?;
    let number = (of_file.number)(Path::new(file)).map_err(|words| Wrong::at("eds", words))?;
    number.map(|number| number.to_string()).ok_or_else(|| {
        Wrong::whole(format!("{file} has no NodeID; give the number, for example 5,eds={file}"))
    })
}

/// A device as asked for: which, where, and what is chosen about it.
#[derive(Clone, Debug)]
pub struct Spec {
    /// Which.
    pub(crate) device: &'static Device,
    /// Its address, or its node number.
    pub(crate) place: u8,
    /// What is chosen.
    pub(crate) choices: Choices,
}

impl Spec {
    /// A device of which nothing is chosen.
    pub(crate) fn plain(device: &'static Device, place: u8) -> Self {
        Self { device, place, choices: Choices::default() }
    }

    /// Reads `PLACE,key=value,flag`, as on the command line.
    ///
    /// # Errors
    /// [`Wrong`] says which key.
    pub(crate) fn parse(group: Group, text: &str) -> Result<Self, Wrong> {
        let (place, rest) = text.split_once(',').map_or((text, None), |(place, rest)| (place, Some(rest)));
        // A key begins with a letter; anything else is meant as the place.
        let is_key = place.contains('=') && place.starts_with(|first: char| first.is_ascii_alphabetic());
        let (place, rest) = match (is_key, group) {
            (false, _) => (place.to_owned(), rest),
            (true, Group::Node) => (number_of_file(text, group)?, Some(text)),
            (true, Group::Drive | Group::PpoDrive | Group::Profidrive | Group::Station) => {
                return Err(group.without_place());
            }
        };
        let key = group.place_key();
        let place = group.number(&place).map_err(|words| Wrong::at(key, words))?;
        let mut given = vec![(key.to_owned(), Given::Number(place.into()))];
        let inputs = group.choices().into_iter().find(|choice| choice.takes == Takes::Inputs);
        let mut moved = Vec::new();
        for part in rest.into_iter().flat_map(|rest| rest.split(',')) {
            if let Some((_, input)) =
                part.split_once('=').filter(|(key, _)| inputs.is_some_and(|choice| choice.is(key)))
            {
                moved.push(Given::Text(input.to_owned()));
                continue;
            }
            let is_flag = |choice: &&Choice| choice.takes == Takes::Flag && choice.is(part);
            given.push(match part.split_once('=') {
                Some((key, value)) => (key.to_owned(), Given::Text(value.to_owned())),
                None if group.choices().iter().any(is_flag) => (part.to_owned(), Given::Flag(true)),
                None => {
                    let is_number = !part.is_empty() && part.bytes().all(|octet| octet.is_ascii_digit());
                    let again = if is_number { "for another device give the option again; " } else { "" };
                    let words = format!("'{part}' is not understood; {again}{}", group.expected());
                    return Err(Wrong::key(part, words));
                }
            });
        }
        if let Some(choice) = inputs.filter(|_| !moved.is_empty()) {
            given.push((choice.key.to_owned(), Given::List(moved)));
        }
        Self::read(group, &given, Path::new(""))
    }

    /// Reads the keys and values of a table or an object. Paths of files begin in `folder`.
    ///
    /// # Errors
    /// [`Wrong`] says which key.
    pub(crate) fn of_given(group: Group, given: &Given, folder: &Path) -> Result<Self, Wrong> {
        let Given::Table(table) = given else {
            return Err(Wrong::whole(format!("{given} is no {}; {}", group.name(), group.expected())));
        };
        Self::read(group, table, folder)
    }

    /// Reads the files that it names and checks everything that can be checked before anything starts.
    ///
    /// # Errors
    /// [`Wrong`] says which key.
    pub(crate) fn prepare(&self) -> Result<Prepared, Wrong> {
        match self.device {
            Device::Slave(slave) => (slave.prepare)(self),
            Device::Node(_) | Device::NodeFile(_) => {
                Err(Wrong::whole(format!("{} is on CANopen", self.device.name())))
            }
        }
    }

    /// The device on CANopen; reads the file that it names.
    ///
    /// # Errors
    /// [`Wrong`] says which key.
    pub(crate) fn product(&self) -> Result<&'static Product, Wrong> {
        match self.device {
            Device::Node(product) => Ok(product),
            Device::NodeFile(file) => (file.product)(file, &self.choices),
            Device::Slave(slave) => Err(Wrong::whole(format!("{} is on PROFIBUS", slave.name))),
        }
    }

    /// What moves the inputs of the node.
    ///
    /// # Errors
    /// [`Wrong`] says which key.
    pub(crate) fn signals(&self) -> Result<Vec<NodeSignal>, Wrong> {
        let (given, folder) = &self.choices.inputs;
        let product = self.product()?;
        match self.device.choices().iter().find(|choice| choice.takes == Takes::Objects) {
            Some(choice) if !given.is_empty() => {
                let mut device = product.make(self.node(), &self.choices, Eeprom::Internal, Instant::ZERO);
                device.power_on(Instant::ZERO);
                objects::signals(choice.key, given, folder, &*device)
            }
            Some(_) | None => Ok(Vec::new()),
        }
    }

    /// Reads keys and values. Paths of files begin in `folder`.
    ///
    /// # Errors
    /// [`Wrong`] says which key.
    pub(crate) fn read(group: Group, given: &[(String, Given)], folder: &Path) -> Result<Self, Wrong> {
        let is_place = |key: &str| key == group.place_key() || key == "address";
        let place = given.iter().find(|(key, _)| is_place(key));
        let (key, place) = place.ok_or_else(|| Self::without_place(group, given))?;
        if !matches!(place, Given::Number(_)) {
            let words = format!("{key}: expected a number, not the text '{place}'");
            return Err(Wrong::at(key, words));
        }
        let place = group.number(&place.to_string()).map_err(|words| Wrong::at(key, words))?;
        let device = Self::device(group, given)?;
        let mut this = Self::plain(device, place);
        for (before, (key, value)) in given.iter().enumerate() {
            if given.iter().take(before).any(|(known, _)| known == key) {
                return Err(this.twice(key));
            }
            if !is_place(key) && key != group.device_key() {
                this.take(key, value, folder)?;
            }
        }
        this.check_required()?;
        Ok(this)
    }

    /// Why no place is found: another key may have been meant for it.
    fn without_place(group: Group, given: &[(String, Given)]) -> Wrong {
        let device = match Self::device(group, given) {
            Ok(device) => device,
            Err(wrong) => return wrong,
        };
        let is_known =
            |key: &str| key == group.device_key() || device.choices().iter().any(|choice| choice.is(key));
        match given.iter().find(|(key, _)| !is_known(key)) {
            Some((key, _)) => Self::plain(device, 0).no_such(key),
            None => Wrong::whole(format!("'{}' is missing; {}", group.place_key(), group.expected())),
        }
    }

    fn device(group: Group, given: &[(String, Given)]) -> Result<&'static Device, Wrong> {
        let key = group.device_key();
        let named = given.iter().find(|(known, _)| known == key);
        let device = match named {
            Some((_, name)) => group.device(&name.to_string()),
            None => {
                // What only one device cannot be without names it.
                let names = |choice: &Choice| choice.required && given.iter().any(|(key, _)| choice.is(key));
                let named = group.devices().find(|device| device.choices().iter().any(names));
                named.or_else(|| group.devices().next()).ok_or_else(|| "there are no devices".to_owned())
            }
        };
        device.map_err(|words| Wrong::at(key, words))
    }

    fn take(&mut self, key: &str, value: &Given, folder: &Path) -> Result<(), Wrong> {
        let choice = self.device.choices().iter().find(|choice| choice.is(key));
        let choice = choice.ok_or_else(|| self.no_such(key))?;
        match (choice.takes, value) {
            (Takes::Quirks, Given::Table(quirks)) => {
                for (name, value) in quirks {
                    self.choose_quirk(name, &value.to_string())
                        .map_err(|words| Wrong::within(key, name, words))?;
                }
            }
            (Takes::Values, Given::Table(values)) => {
                for (name, value) in values {
                    let Given::Number(number) = value else {
                        return Err(Wrong::within(key, name, format!("'{name}': {value} is no number")));
                    };
                    self.choices.values.push((name.clone(), *number));
                }
            }
            (Takes::Diagnosis, Given::List(rows)) => self.choices.diagnoses.clone_from(rows),
            (Takes::Records, Given::List(rows)) => self.choices.records.clone_from(rows),
            (Takes::Alarms, Given::List(rows)) => self.choices.alarms.clone_from(rows),
            (Takes::Inputs | Takes::Objects, Given::List(inputs)) => {
                self.choices.inputs = (inputs.clone(), folder.to_owned());
            }
            _ => {
                let picked = choice.pick(value, folder).map_err(|words| Wrong::at(key, words))?;
                if self.choices.picked.iter().any(|(known, _)| *known == choice.key) {
                    return Err(self.twice(key));
                }
                self.choices.picked.push((choice.key, picked));
            }
        }
        Ok(())
    }

    fn twice(&self, key: &str) -> Wrong {
        Wrong::key(key, format!("'{key}' is given twice; {}", self.device.group().expected()))
    }

    /// A key that the device does not have.
    fn no_such(&self, key: &str) -> Wrong {
        let group = self.device.group();
        let others: Vec<_> = group
            .devices()
            .filter(|device| device.choices().iter().any(|choice| choice.is(key)))
            .map(Device::name)
            .collect();
        if !others.is_empty() {
            let own = self.device.name();
            let words = format!("{key} is for the device {} only, not for {own}", others.join(" and "));
            return Wrong::key(key, words);
        }
        let known = group.choices();
        let keys = [group.place_key(), group.device_key()];
        // What the other bus calls its places.
        let near = match key {
            "node" | "number" | "id" | "address" => format!("did you mean {}? ", group.place_key()),
            _ => near(key, known.iter().map(|choice| choice.key).chain(keys)),
        };
        Wrong::key(key, format!("'{key}' is unknown; {near}{}", group.expected()))
    }

    fn check_required(&self) -> Result<(), Wrong> {
        let missing = |choice: &&Choice| {
            choice.required && self.choices.picked.iter().all(|(key, _)| *key != choice.key)
        };
        match self.device.choices().iter().find(missing) {
            None => Ok(()),
            Some(Choice { takes: Takes::File(_), .. }) => {
                Err(Wrong::whole(format!("no file is named; {}", self.device.group().expected())))
            }
            Some(Choice { key, .. }) => {
                Err(Wrong::whole(format!("'{key}' is missing; {}", self.device.group().expected())))
            }
        }
    }

    /// Chooses the value of a quirk.
    ///
    /// # Errors
    /// What is wrong, and what there is.
    pub(crate) fn choose_quirk(&mut self, name: &str, value: &str) -> Result<(), String> {
        let rows = self.device.quirks();
        let chosen = self.choices.quirk(&rows, name, value);
        chosen.map_err(|error| quirk_refusal(self.device.name(), &rows, name, value, error))
    }

    /// Chooses a quirk that was given for all devices: those that do not have it stay as they are, and what was chosen for
    /// this one stays.
    ///
    /// # Errors
    /// As [`Spec::choose_quirk`].
    pub(crate) fn choose_common_quirk(&mut self, name: &str, value: &str) -> Result<(), String> {
        let is_its = self.device.quirks().iter().any(|row| row.name == name);
        let is_chosen = self.choices.quirks.iter().any(|(known, _)| *known == name);
        if is_its && !is_chosen { self.choose_quirk(name, value) } else { Ok(()) }
    }

    /// Its address on PROFIBUS.
    pub(crate) const fn address(&self) -> Address {
        Address::from_octet(self.place)
    }

    /// Its node number on CANopen.
    pub(crate) fn node(&self) -> NodeId {
        // Checked when it was read.
        NodeId::new(self.place).unwrap_or(NodeId::MIN)
    }
}

#[cfg(test)]
#[cfg(feature = "eds")]
mod tests {
    use super::*;

    #[test]
    fn a_device_is_its_place_and_what_differs_from_the_usual() {
        for (group, text, place, name, key, word) in [
            (Group::Drive, "5", 5, "ag03-1", "gear", None),
            (Group::Drive, "0,gear=24", 0, "ag03-1", "gear", Some("24")),
            (Group::Drive, "126,model=ag03", 126, "ag03", "gear", None),
            (Group::Drive, "7,gear=48,model=ag03-1", 7, "ag03-1", "gear", Some("48")),
            (Group::Node, "5", 5, "ag03-1", "gear", None),
            (Group::Node, "1,device=ap10,twin", 1, "ap10", "mode", None),
            (Group::Node, "5,mode=half,device=asda-a2", 5, "asda-a2", "mode", Some("half")),
            (Group::PpoDrive, "7,ppo=2,ident=0x80D1,parameters=a.csv", 7, "ppo-drive", "ppo", Some("2")),
            (Group::Node, "eds=tests/eds/servo.dcf,twin", 9, "eds-node", "mode", None),
            (Group::Node, "5,twin,eds=pump.eds", 5, "eds-node", "mode", None),
            (Group::Station, "7,strict,gsd=x.gsd", 7, "gsd-station", "gsd", None),
        ] {
            let spec = Spec::parse(group, text).unwrap();
            assert_eq!(
                (spec.place, spec.device.name(), spec.choices.word(key)),
                (place, name, word),
                "{text}"
            );
        }
        let drive = Spec::parse(Group::PpoDrive, "7,ident=0x80D1,parameters=a.csv").unwrap();
        assert_eq!(drive.choices.hexadecimal("ident"), Some(0x80D1));
        assert_eq!(drive.choices.file("parameters"), Some(Path::new("a.csv")));
        for strict in ["7,gsd=x.gsd,strict", "7,strict,gsd=x.gsd"] {
            let station = Spec::parse(Group::Station, strict).unwrap();
            assert_eq!((station.choices.flag("strict"), station.choices.flag("twin")), (true, false));
            assert_eq!(
                station.choices.file("gsd"),
                Some(Path::new("x.gsd")),
                "a comma ends the name of a file"
            );
        }
    }

    #[test]
    fn a_wrong_specification_is_answered_with_the_wrong_part() {
        for (group, text, path, words) in [
            (
                Group::Drive,
                "",
                "address",
                "'' is no address; expected ADDRESS[,model=ag03|ag03-1][,gear=24|48]",
            ),
            (Group::Drive, "+5", "address", "'+5' is no address"),
            (
                Group::Drive,
                "5-9",
                "address",
                "'5-9' is no address; for several drives use --drives FIRST-LAST; expected",
            ),
            (
                Group::Drive,
                "5,6",
                "6",
                "'6' is not understood; for another device give the option again; expected",
            ),
            (Group::Drive, "5,node=6", "node", "'node' is unknown; did you mean address? expected"),
            (
                Group::Drive,
                "5,model=asda-a2",
                "model",
                "model 'asda-a2' is no device of this kind; it is a device of --node (in a line file [[line.node]]); expected",
            ),
            (Group::Drive, "x,gear=24", "address", "'x' is no address"),
            (Group::Drive, "127", "address", "address 127 is outside 0 to 126"),
            (Group::Drive, "99999999999999999999", "address", "is outside 0 to 126"),
            (Group::Drive, "5,", "", "'' is not understood; expected ADDRESS"),
            (Group::Drive, "5,gear", "gear", "'gear' is not understood"),
            (Group::Drive, "5,gear=36", "gear", "gear '36' is unknown; expected 24 or 48"),
            (
                Group::Drive,
                "5,model=ag04",
                "model",
                "model 'ag04' is unknown; did you mean ag03? expected ag03 or ag03-1",
            ),
            (Group::Drive, "5,color=red", "color", "'color' is unknown; expected ADDRESS"),
            (Group::Drive, "5,gera=24", "gera", "'gera' is unknown; did you mean gear? expected ADDRESS"),
            (Group::Drive, "5,gear=24,gear=48", "gear", "'gear' is given twice"),
            (Group::Drive, "5,gear=24,gear_ratio=24", "gear_ratio", "'gear_ratio' is given twice"),
            (Group::Drive, "5,model=ag03,model=ag03", "model", "'model' is given twice"),
            (
                Group::Node,
                "",
                "id",
                "'' is no node number; expected ID[,device=ag03-1|ap10|asda-a2|eds-node][,gear=24|48][,reset=all|standard|controller][,twin][,mode=full|half][,eds=FILE][,profile=file|none]",
            ),
            (Group::Node, "0", "id", "node number 0 is outside 1 to 127"),
            (Group::Node, "128,device=ap10", "id", "node number 128 is outside 1 to 127"),
            (Group::Node, "5,ap10", "ap10", "'ap10' is not understood"),
            (Group::Node, "5,model=ap10", "model", "'model' is unknown"),
            (
                Group::Node,
                "5,device=ap01",
                "device",
                "device 'ap01' is unknown; did you mean ap10? expected ",
            ),
            (Group::Node, "5,device=asda_a2", "device", "did you mean asda-a2?"),
            (
                Group::Node,
                "5,device=ap10,mode=full",
                "mode",
                "mode is for the device asda-a2 only, not for ap10",
            ),
            (
                Group::Node,
                "5,device=asda-a2,mode=some",
                "mode",
                "mode 'some' is unknown; expected full or half",
            ),
            (
                Group::Node,
                "5,device=asda-a2,gear=24",
                "gear",
                "gear is for the device ag03-1 only, not for asda-a2",
            ),
            (
                Group::Node,
                "5,device=ap10,eds=x.eds",
                "eds",
                "eds is for the device eds-node only, not for ap10",
            ),
            (Group::Node, "device=ap10", "", "the node number is missing; expected ID"),
            (
                Group::Node,
                "eds=tests/eds/pump.eds",
                "",
                "pump.eds has no NodeID; give the number, for example 5,eds=",
            ),
            (Group::Node, "eds=/nowhere.eds", "eds", "cannot read /nowhere.eds"),
            (Group::Node, "5,device=eds-node", "", "no file is named; expected ID"),
            (
                Group::Node,
                "5,eds=x.eds,gear=24",
                "gear",
                "gear is for the device ag03-1 only, not for eds-node",
            ),
            (Group::PpoDrive, "7,ppo=6", "ppo", "ppo '6' is unknown; expected 1, 2, 3, 4 or 5"),
            (Group::PpoDrive, "7,ident=12345", "ident", "ident '12345' is no ident number"),
            (Group::PpoDrive, "7,gsd=", "gsd", "the name of the file of 'gsd' is empty"),
            (Group::PpoDrive, "7,model=x", "model", "'model' is unknown; expected ADDRESS"),
            (Group::PpoDrive, "7,fast", "fast", "'fast' is not understood"),
            (Group::Station, "7", "", "no file is named; expected ADDRESS,gsd=FILE[,strict]"),
            (Group::Station, "gsd=x", "", "the address is missing; expected ADDRESS,gsd=FILE"),
            (Group::Station, "7,gsd=a,b.gsd", "b.gsd", "'b.gsd' is not understood"),
            (Group::Station, "7,file=x", "file", "'file' is unknown"),
        ] {
            let wrong = Spec::parse(group, text).unwrap_err();
            assert!(wrong.words.contains(words), "{text}: {}", wrong.words);
            assert_eq!(wrong.path.join("."), path, "{text}");
        }
    }

    #[test]
    fn a_table_says_the_same_as_a_line_of_text_and_keeps_the_place_of_a_mistake() {
        let number = |number: f64| Given::Number(number);
        let table = |entries: &[(&str, Given)]| -> Vec<(String, Given)> {
            entries.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect()
        };
        let read = |entries: &[(&str, Given)]| Spec::read(Group::Drive, &table(entries), Path::new("dir"));
        let spec = read(&[("address", number(5.0)), ("gear", number(24.0))]).unwrap();
        assert_eq!(spec.choices, Spec::parse(Group::Drive, "5,gear=24").unwrap().choices);
        let quirks = Given::Table(table(&[("off1", Given::Text("x".into()))]));
        let values = Given::Table(table(&[("v-Pos", Given::Text("x".into()))]));
        for (key, value, path, words) in [
            ("gear", Given::Flag(true), "gear", "gear: expected a word or a number, not true"),
            ("gear", number(36.0), "gear", "gear '36' is unknown"),
            ("quirks", quirks, "quirks.off1", "quirk off1 cannot be 'x'; expected release or brake"),
            ("values", values, "values.v-Pos", "'v-Pos': x is no number"),
            ("values", number(1.0), "values", "values: expected a table of names and numbers, not 1"),
        ] {
            let wrong = read(&[("address", number(5.0)), (key, value)]).unwrap_err();
            assert_eq!((wrong.path.join("."), wrong.words.contains(words)), (path.into(), true), "{wrong}");
        }
        let missing = read(&[("gear", number(24.0))]).unwrap_err();
        assert!(missing.words.contains("'address' is missing; expected ADDRESS"), "{missing}");
        let slip = read(&[("gear", number(24.0)), ("adress", number(5.0))]).unwrap_err();
        assert!(slip.words.contains("'adress' is unknown; did you mean address?"), "{slip}");
        assert_eq!((slip.path.join("."), slip.is_key), ("adress".into(), true));
    }

    #[test]
    fn a_quirk_of_all_is_for_those_that_have_it_and_gives_way_to_their_own() {
        let mut drive = Spec::parse(Group::Drive, "5").unwrap();
        drive.choose_quirk("off1", "brake").unwrap();
        drive.choose_common_quirk("off1", "release").unwrap();
        drive.choose_common_quirk("sdo-size", "checked").unwrap();
        assert_eq!(drive.choices.quirks, [("off1", "brake")]);
        assert!(drive.choose_common_quirk("off1", "x").is_ok(), "its own is chosen");
        let mut other = Spec::parse(Group::Drive, "6").unwrap();
        assert!(other.choose_common_quirk("off1", "x").unwrap_err().contains("cannot be 'x'"));
        let unknown = other.choose_quirk("off2", "x").unwrap_err();
        assert!(unknown.contains("quirk 'off2' is unknown; did you mean off1? ag03-1 has "), "{unknown}");
    }
}
