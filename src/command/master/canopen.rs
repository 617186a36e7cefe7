//! A drive on CANopen: `read`, `write`, `status`, `move`, `home`, `stop`, `ack`, `faults`.

use crate::can_bus::can::{BitRate, Frame};
use crate::can_bus::canopen::cob_id;
use crate::can_bus::canopen::{Abort, Address, Entry, NodeId, Object, Refusal, Value, dictionary};
use crate::client::{NodeClient, NodeGoal, NodeLimits, NodeOutcome, NodeTrouble};
use crate::devices::Vocabulary;
use crate::devices::vocabulary::CIA_402;
use crate::explain::canopen::Network;
use crate::explain::hex;
use crate::host::can::{CanEndpoint, Product, SlcanEndpoint, open_slcan, open_socketcan};
use crate::host::link::tcp::Connection;
use crate::host::list::Choices;
use crate::host::list::node_files::product_of_file;
use crate::host::{Clock, Stop, SystemClock};
use serde_json::json;
use tracing::warn;

use super::confirm::{Confirmed, confirm};
use super::device::{self, Commissioned, Shown};
use super::say;
use crate::command::Failure;
use crate::command::args::{Asked, CanPlace, Master, Motion, Quantity, find_parameter, plain};
use crate::command::signals;

mod status;

/// Octets of a value, at most as many as the client gives.
type Octets = Vec<u8>;

/// What has come of an access or of a goal; of a goal and of a write no octets.
type Answer = Result<Octets, NodeTrouble>;

const DEVICE_TYPE: Address = Address::new(0x1000, 0);
const VENDOR: Address = Address::new(0x1018, 1);
const GUARD_TIME: Address = Address::new(0x100C, 0);
const POSITION: Address = Address::new(0x6064, 0);
const NEWEST_ERROR: Address = Address::new(0x1003, 1);

/// Does what is asked, once.
pub(super) fn master(args: &Master, place: &CanPlace) -> Result<(), Failure> {
    let node = args.can_node().map_err(Failure::Usage)?;
    let leave = confirm(args)?;
    // Before the drive is enabled, so that no signal ends the process with the drive moving.
    let stop = signals::stop_at_end().map_err(|error| Failure::from_error(&error))?;
    let of_file = match &args.eds {
        Some(file) => Some(product_of_file(file).map_err(Failure::Usage)?),
        None => None,
    };
    let rate = args.baud.and_then(|baud| baud.can()).unwrap_or(BitRate::K500);
    let bus = open(place, rate)?;
    let limits = NodeLimits { life: args.watchdog, ..NodeLimits::default() };
    let mut drive = Drive {
        bus,
        clock: SystemClock::new(),
        stop,
        node,
        client: NodeClient::new(node, limits),
        network: Network::default(),
        product: None,
    };
    drive.identify(of_file)?;
    device::act(&mut drive, &args.action, leave, args.json)
}

/// The bus behind an adapter or an interface.
pub(in crate::command) fn open(place: &CanPlace, rate: BitRate) -> Result<Box<dyn CanEndpoint>, Failure> {
    let failed = |error: std::io::Error| Failure::Other(format!("cannot open the bus: {error}"));
    Ok(match place {
        CanPlace::Terminal(path) => open_slcan(path, rate).map_err(|error| Failure::from_error(&error))?,
        CanPlace::Tcp(place) => {
            let link = Connection::open(place).map_err(|error| Failure::from_error(&error))?;
            Box::new(SlcanEndpoint::open(link, rate).map_err(failed)?)
        }
        CanPlace::Socket(name) => open_socketcan(name).map_err(|error| Failure::from_error(&error))?,
    })
}

/// A node, and what is known of it.
struct Drive {
    bus: Box<dyn CanEndpoint>,
    clock: SystemClock,
    stop: Stop,
    node: NodeId,
    client: NodeClient,
    network: Network,
    product: Option<&'static Product>,
}

impl Drive {
    /// Waits for what comes of the request, the octets of a read; `None`: somebody wants it to end.
    fn outcome(&mut self) -> Result<Option<Answer>, Failure> {
        let lost = |error: std::io::Error| Failure::Other(format!("the bus is lost: {error}"));
        loop {
            while let Some(frame) = self.client.poll_transmit() {
                self.network.frame(&frame);
                self.bus.send(&frame).map_err(lost)?;
            }
            if let Some(outcome) = self.client.poll_outcome() {
                return Ok(Some(match outcome {
                    NodeOutcome::Read(octets, len) => Ok(octets.get(..len).unwrap_or_default().into()),
                    NodeOutcome::Written | NodeOutcome::Done => Ok(Vec::new()),
                    NodeOutcome::Failed(trouble) => Err(trouble),
                }));
            }
            if self.stop.is_requested() {
                return Ok(None);
            }
            match self.bus.receive().map_err(lost)? {
                Some(frame) => {
                    self.network.frame(&frame);
                    self.client.handle_frame(self.clock.now(), &frame);
                }
                None => {
                    let due = self.client.poll_timeout();
                    let timeout = due.map(|due| due.saturating_since(self.clock.now()));
                    self.bus.wait(timeout, &self.stop).map_err(lost)?;
                }
            }
            self.client.handle_timeout(self.clock.now());
        }
    }

    fn get(&mut self, at: Address) -> Result<Answer, Failure> {
        self.client.read(self.clock.now(), at);
        self.outcome()?.ok_or_else(interrupted)
    }

    fn put(&mut self, at: Address, octets: &[u8]) -> Result<Answer, Failure> {
        self.client.write(self.clock.now(), at, octets);
        self.outcome()?.ok_or_else(interrupted)
    }

    /// As [`get`](Self::get), for what must be there.
    fn must_get(&mut self, at: Address) -> Result<Octets, Failure> {
        self.get(at)?.map_err(|trouble| self.failure(trouble))
    }

    fn failure(&self, trouble: NodeTrouble) -> Failure {
        let NodeTrouble::Refused { at, code } = trouble else { return Failure::Other(trouble.to_string()) };
        let refusal = Refusal::new(at, code, self.entry(at));
        let name = self.network.named(self.node, at);
        Failure::Other(format!("the node refuses {name}: {}", refusal.reason()))
    }

    /// With what was written, and the limits of the dictionary.
    fn refused_write(&mut self, at: Address, code: Abort, octets: &[u8]) -> Result<Failure, Failure> {
        let objects = self.objects()?;
        let unit = (self.words().parameter)(at).map_or("", |parameter| parameter.unit.name());
        let refusal = Refusal::of_write(at, code, dictionary::entry(objects, at).ok(), octets, unit);
        let name = self.network.named(self.node, at);
        Ok(Failure::Other(format!("the node refuses {name}: {}", refusal.reason())))
    }

    /// The dictionary with the limits of this very device: of a drive with gears those of its own.
    fn objects(&mut self) -> Result<&'static [Object], Failure> {
        let Some(product) = self.product else { return Ok(self.words().objects) };
        let mut choices = Choices::default();
        if let Some((at, told)) = product.tells
            && let Ok(octets) = self.get(at)?
            && let Some((key, value)) = told(number(&octets))
        {
            choices = product.chosen(key, value).unwrap_or(choices);
        }
        Ok(product.objects(&choices))
    }

    /// Which device it is: that of the file, else by device type and vendor. Also asks for the NMT state.
    fn identify(&mut self, of_file: Option<&'static Product>) -> Result<(), Failure> {
        if let Ok(frame) = Frame::remote(cob_id::of_node(cob_id::ERROR_CONTROL, self.node), 1) {
            self.bus.send(&frame).map_err(|error| Failure::Other(format!("the bus is lost: {error}")))?;
        }
        if let Some(product) = of_file {
            self.warn_of_another(product)?;
        }
        let device_type = number(&self.must_get(DEVICE_TYPE)?);
        let vendor = self.get(VENDOR)?.ok().map(|octets| number(&octets));
        let product = Product::all().find(|product| {
            let objects = product.objects(&Choices::default());
            let default =
                dictionary::entry(objects, DEVICE_TYPE).map(|entry| entry.default_value(self.node).number());
            default == Ok(Some(device_type)) && vendor == Some(product.sheet.vendor_number.into())
        });
        self.product = of_file.or(product);
        if let Some(product) = self.product {
            self.network.know(self.node, product.vocabulary);
        }
        Ok(())
    }

    /// Says what the node is that the file does not say.
    fn warn_of_another(&mut self, product: &'static Product) -> Result<(), Failure> {
        let objects = product.objects(&Choices::default());
        for at in [VENDOR, Address::new(0x1018, 2)] {
            let said =
                dictionary::entry(objects, at).ok().and_then(|entry| entry.default_value(self.node).number());
            let got = self.get(at)?.ok().map(|octets| number(&octets));
            if let (Some(said @ 1..), Some(got)) = (said, got)
                && said != got
            {
                warn!(
                    "the file is of another device: {at} is {got:08X}h in the node and {said:08X}h in the file"
                );
            }
        }
        Ok(())
    }

    fn words(&self) -> &'static Vocabulary {
        self.product.map_or(&CIA_402, |product| product.vocabulary)
    }

    /// The entry by index and sub-index, by name, or by the name of the parameter of the drive.
    fn place(&self, text: &str) -> Result<Address, Failure> {
        if let Some(at) = address(text) {
            return Ok(at);
        }
        let words = self.words();
        let wanted = plain(text);
        let entries = || {
            words.objects.iter().flat_map(|object| {
                object
                    .entries
                    .iter()
                    .map(move |entry| (Address { index: object.index, sub: entry.sub }, entry))
            })
        };
        let parameter = find_parameter(text).ok();
        let is_parameter = |at| parameter.is_some() && (words.parameter)(at) == parameter;
        let named: Vec<Address> = [
            entries().filter(|(at, _)| is_parameter(*at)).map(|(at, _)| at).take(1).collect::<Vec<_>>(),
            entries().filter(|(_, entry)| plain(entry.name) == wanted).map(|(at, _)| at).collect(),
            entries().filter(|(_, entry)| plain(entry.name).starts_with(&wanted)).map(|(at, _)| at).collect(),
        ]
        .into_iter()
        .find(|found| !found.is_empty() && !wanted.is_empty())
        .unwrap_or_default();
        match named[..] {
            [at] => Ok(at),
            [] => Err(Failure::Usage(format!(
                "'{text}' is neither an index such as 6041 or 2410:05 nor the name of an object of the {}",
                words.name
            ))),
            [..] => {
                let which: Vec<_> =
                    named.iter().take(5).map(|at| self.network.named(self.node, *at)).collect();
                Err(Failure::Usage(format!("'{text}' is the name of several objects: {}", which.join(", "))))
            }
        }
    }

    fn shown(&self, at: Address, octets: &[u8]) -> Shown {
        let name = self.network.named(self.node, at);
        let text = self.network.in_words(self.node, at, octets).to_string();
        let number = json!(self.decoded(at, octets).and_then(Value::number));
        let json = json!({
            "object": at.to_string(),
            "name": name.strip_prefix(&at.to_string()).unwrap_or_default().trim(),
            "value": number,
            "octets": hex(octets),
            "text": text,
        });
        Shown { head: format!("{name} ="), text, number, json }
    }

    fn entry(&self, at: Address) -> Option<&'static Entry> {
        dictionary::entry(self.words().objects, at).ok()
    }

    fn decoded<'a>(&self, at: Address, octets: &'a [u8]) -> Option<Value<'a>> {
        self.entry(at)?.data.decode(octets)
    }

    /// The octets of a number: by the type in the dictionary, else as many as the entry has.
    fn octets_of(&self, at: Address, value: i64, before: Option<&[u8]>) -> Result<Octets, Failure> {
        let data = self.entry(at).map(|entry| entry.data);
        let len = data.and_then(|data| data.octets()).or(before.map(<[u8]>::len)).unwrap_or(4).min(8);
        let (low, high) = match (data.and_then(|data| data.range()), len) {
            (Some(range), _) => range,
            (None, 8) => (i64::MIN, i64::MAX),
            (None, len) => (-1 << (8 * len - 1).min(62), (1 << (8 * len).min(62)) - 1),
        };
        if !(low..=high).contains(&value) {
            let name = self.network.named(self.node, at);
            return Err(Failure::Usage(format!("{name} takes {low} to {high}, got {value}")));
        }
        Ok(value.to_le_bytes().get(..len).unwrap_or_default().into())
    }

    fn device(&self) -> &'static str {
        self.product.map_or("a device that is not known", |product| product.vocabulary.name)
    }

    fn pursue(&mut self, goal: NodeGoal) -> Result<Option<Answer>, Failure> {
        self.client.pursue(self.clock.now(), goal);
        self.outcome()
    }

    /// Why a travel is not done; of a fault the newest entry of the error history.
    fn reason(&mut self, trouble: NodeTrouble) -> Result<String, Failure> {
        let text = self.failure(trouble).into_line();
        if !matches!(trouble, NodeTrouble::Fault { .. }) {
            return Ok(text);
        }
        Ok(match self.get(NEWEST_ERROR)? {
            Ok(octets) => format!("{text}: {}", self.network.in_words(self.node, NEWEST_ERROR, &octets)),
            Err(_) => text,
        })
    }

    fn position(&mut self) -> String {
        match self.get(POSITION) {
            Ok(Ok(octets)) => format!("position {}", self.network.in_words(self.node, POSITION, &octets)),
            Ok(Err(_)) | Err(_) => "position unknown".into(),
        }
    }
}

impl Commissioned for Drive {
    fn read(&mut self, asked: &Asked, json: bool) -> Result<(), Failure> {
        let at = self.place(&asked.0)?;
        let octets = self.must_get(at)?;
        self.shown(at, &octets).say(json)
    }

    /// What can only be written is not read, and what reads as something else is not compared.
    fn write(&mut self, asked: &Asked, value: Quantity, json: bool) -> Result<(), Failure> {
        let value = value.plain().map_err(Failure::Usage)?;
        let at = self.place(&asked.0)?;
        let before = match self.get(at)? {
            Ok(octets) => Some(octets),
            Err(NodeTrouble::Refused { code: Abort::WRITE_ONLY, .. }) => None,
            Err(trouble) => return Err(self.failure(trouble)),
        };
        let octets = self.octets_of(at, value, before.as_deref())?;
        match self.put(at, &octets)? {
            Ok(_) => {}
            Err(NodeTrouble::Refused { code, .. }) => return Err(self.refused_write(at, code, &octets)?),
            Err(trouble) => return Err(self.failure(trouble)),
        }
        let Some(before) = before.filter(|_| !at.takes_signature()) else {
            if json {
                return self.shown(at, &octets).say(json);
            }
            return say(format_args!("{} written", self.network.named(self.node, at)));
        };
        let after = self.must_get(at)?;
        if after != octets {
            let name = self.network.named(self.node, at);
            let got = self.network.in_words(self.node, at, &after);
            return Err(Failure::Other(format!(
                "{name} was written, but reads back as {got} instead of {value}"
            )));
        }
        self.shown(at, &after).say_changed(&self.shown(at, &before), "", json)
    }

    fn status(&mut self, json: bool) -> Result<(), Failure> {
        self.show_status(json)
    }

    fn faults(&mut self, clear: bool, json: bool) -> Result<(), Failure> {
        self.show_faults(clear, json)
    }

    fn acknowledge(&mut self, json: bool) -> Result<(), Failure> {
        self.clear_fault(json)
    }

    /// Quick stop, standstill, no torque.
    fn stop(&mut self, json: bool) -> Result<(), Failure> {
        self.pursue(NodeGoal::Stop)?.ok_or_else(interrupted)?.map_err(|trouble| self.failure(trouble))?;
        let at = self.position();
        if json { say(json!({ "outcome": "stopped" })) } else { say(format_args!("stopped; {at}")) }
    }

    /// Travels, and leaves the drive as it was.
    fn motion(&mut self, motion: Motion, _: Confirmed, json: bool) -> Result<(), Failure> {
        let goal = match motion {
            Motion::Move { position, .. } => NodeGoal::MoveTo(position.position().map_err(Failure::Usage)?),
            Motion::Home { .. } => NodeGoal::Home,
            Motion::Enable { .. } | Motion::Jog { .. } | Motion::Velocity { .. } => {
                return device::not_here();
            }
        };
        if let Err(NodeTrouble::Refused { code: Abort::NO_OBJECT, .. }) = self.get(GUARD_TIME)? {
            warn!("the node has no node guarding (100Ch): if this master is lost, it goes on");
        }
        let reached = self.pursue(goal)?;
        self.stop.clear();
        let why = match reached {
            Some(Err(trouble)) => Some(self.reason(trouble)?),
            Some(Ok(_)) => None,
            None => Some("interrupted".into()),
        };
        if why.is_some() {
            self.pursue(NodeGoal::Stop)?;
        }
        let left = self.pursue(NodeGoal::Leave)?;
        let at = self.position();
        if let Some(why) = why {
            return Err(Failure::Other(format!("{why}; the motor is released, {at}")));
        }
        if let Some(Err(trouble)) = left {
            return Err(self.failure(trouble));
        }
        if !json {
            return say(format_args!("reached; {at}"));
        }
        let octets = self.must_get(POSITION)?;
        let position = self.decoded(POSITION, &octets).and_then(Value::number);
        say(json!({ "outcome": "reached", "position": position }))
    }
}

fn interrupted() -> Failure {
    Failure::Other("interrupted".into())
}

/// Up to four octets, low octet first.
fn number(octets: &[u8]) -> i64 {
    octets.iter().take(4).rev().fold(0, |number, octet| number << 8 | i64::from(*octet))
}

/// `6041`, `6041h`, `0x6041`, `2410:05`, `2410h:0A`: in hexadecimal, the sub-index 0 if it is left out.
fn address(text: &str) -> Option<Address> {
    let (index, sub) = text.split_once(':').unwrap_or((text, "0"));
    let plain = |text: &'_ str| {
        let text = text.strip_prefix("0x").unwrap_or(text);
        String::from(text.strip_suffix(['h', 'H']).unwrap_or(text))
    };
    let (index, sub) = (plain(index), plain(sub));
    let is_hex = |text: &str| !text.is_empty() && text.bytes().all(|digit| digit.is_ascii_hexdigit());
    if index.len() != 4 || !is_hex(&index) || !is_hex(&sub) {
        return None;
    }
    Some(Address::new(u16::from_str_radix(&index, 16).ok()?, u8::from_str_radix(&sub, 16).ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_is_hexadecimal_with_or_without_sub_index() {
        for (text, at) in [
            ("6041", Some((0x6041, 0))),
            ("6041h", Some((0x6041, 0))),
            ("0x6041", Some((0x6041, 0))),
            ("2410:05", Some((0x2410, 5))),
            ("2410h:0A", Some((0x2410, 10))),
            ("2410:A", Some((0x2410, 10))),
            ("v-Pos", None),
            ("604", None),
            ("6041:", None),
            ("6041:100", None),
        ] {
            assert_eq!(address(text).map(Address::pair), at, "{text}");
        }
    }
}
