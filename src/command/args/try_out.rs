//! `profidrive try`: which device.

use crate::host::list::{DEVICES, Device, Group, Spec};

use super::emulate::{Emulate, Tried, panel_place};
use super::link::LinkSpec;
use super::{examples, nearest};

/// The place of the device on its bus.
const PLACE: u8 = 5;

/// Tries a device without a master of your own: a device, a small master and the panel in one program
///
/// Opens the panel in a browser. There the master in this program enables, moves, jogs, stops and acknowledges, reads and
/// writes parameters, sends NMT commands or octets of outputs; each with the words that it sends. The line is a TCP port, so
/// that your own master can connect to it, too. Ctrl-C ends it.
#[derive(Debug, clap::Args)]
#[command(after_help = examples(EXAMPLES))]
pub(crate) struct Try {
    #[arg(value_name = "DEVICE[,OPTION...]", help = device_help())]
    device: Option<String>,

    /// The device of this name on CANopen, if there is one on PROFIBUS too
    #[arg(long)]
    canopen: bool,

    /// Opens no browser; the address of the panel is printed
    #[arg(long)]
    no_browser: bool,

    /// Where the panel is served, ADDR:PORT; a free port unless given
    #[arg(long, value_name = "ADDR:PORT", value_parser = panel_place, default_value = "127.0.0.1:0")]
    panel: String,
}

const EXAMPLES: &str = "\
Examples:
  profidrive try                                a drive on PROFIBUS
  profidrive try {node.3}                        a servo drive on CANopen
  profidrive try {node.1} --canopen               a drive of either bus on CANopen
  profidrive try {station.1},gsd=valves.gsd     a station from its device file
  profidrive try {node.4},eds=pump.eds          a node from its EDS";

/// What the help says of the device: every name of the list.
fn device_help() -> String {
    let mut names: Vec<&str> = DEVICES.iter().map(Device::name).collect();
    names.sort_unstable();
    names.dedup();
    format!(
        "The device: {}; with its options as of --drive, --station or --node of 'profidrive emulate'",
        names.join(", ")
    )
}

impl Try {
    /// What `emulate` is told.
    ///
    /// # Errors
    /// There is no such device, or an option is wrong.
    pub(crate) fn emulate(&self) -> Result<Emulate, String> {
        let text = match &self.device {
            Some(text) => text.as_str(),
            None => DEVICES.first().map_or("", Device::name),
        };
        let (name, options) =
            text.split_once(',').map_or((text, None), |(name, options)| (name, Some(options)));
        let spec = self.spec(name, options)?;
        let group = spec.device.group();
        let link = if group.is_on_can() { "slcan-tcp:127.0.0.1:0" } else { "tcp:127.0.0.1:0" };
        let mut emulate = Emulate::on(link.parse::<LinkSpec>()?);
        emulate.devices.push(spec);
        emulate.panel = Some(self.panel.clone());
        emulate.bench = true;
        emulate.tried = Some(Tried { browser: !self.no_browser });
        emulate.check()?;
        Ok(emulate)
    }

    fn spec(&self, name: &str, options: Option<&str>) -> Result<Spec, String> {
        let named = || DEVICES.iter().filter(|device| device.name() == name);
        let device = named().find(|device| (device.group() == Group::Node) == self.canopen).or_else(|| {
            // On the only bus that it has.
            named().next()
        });
        let device = device.ok_or_else(|| {
            let names: Vec<&str> = DEVICES.iter().map(Device::name).collect();
            let near = nearest(name, names.iter().copied());
            format!("there is no device '{name}'; {near}{}", device_help().to_lowercase())
        })?;
        let group = device.group();
        let which = match &*group.names() {
            [_] | [] => String::new(),
            [..] if device.product().is_none() && group == Group::Node => String::new(),
            [..] => format!(",{}={name}", group.device_key()),
        };
        let options = options.map(|options| format!(",{options}")).unwrap_or_default();
        Spec::parse(group, &format!("{PLACE}{which}{options}")).map_err(|wrong| wrong.words)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tried(device: &str, canopen: bool) -> Result<Emulate, String> {
        let panel = "127.0.0.1:0".to_owned();
        Try { device: Some(device.into()), canopen, no_browser: true, panel }.emulate()
    }

    #[test]
    fn each_device_that_needs_no_file_is_tried_by_its_name() {
        for device in DEVICES.iter().filter(|device| device.choices().iter().all(|choice| !choice.required)) {
            let is_node = device.group() == Group::Node;
            let emulate = tried(device.name(), is_node).unwrap();
            let spec = emulate.slaves().first().or_else(|| emulate.nodes().first()).unwrap();
            assert_eq!(spec.device, device);
            assert!(emulate.bench && emulate.panel.is_some());
        }
    }

    #[test]
    fn another_name_is_refused_with_the_nearest_and_an_option_with_its_words() {
        let error = tried("asda-a3", false).unwrap_err();
        assert!(error.contains("'asda-a3'") && error.contains("did you mean"), "{error}");
        assert!(tried("ag03,gear=7", false).unwrap_err().contains("gear"));
        assert!(tried("gsd-station", false).unwrap_err().contains("gsd"));
    }
}
