//! The CAN bus of the demo: a master whose frames the story writes, and one device.

use crate::map::Map;
use core::time::Duration;
use std::io::Write;

use crate::can_bus::can::{BitRate, Frame, Id};
use crate::can_bus::canopen::node::storage::Eeprom;
use crate::can_bus::canopen::{Address, NodeId};
use crate::devices::CanopenEvent;
use crate::devices::story::{NodeAct, PLACE};
use crate::explain::Explanation;
use crate::explain::canopen::Network;
use crate::face::Description;
use crate::face::surroundings::Level;
use crate::host::can::{Bus, Product, Seat, StoredNode};
use crate::host::list::Choices;
use crate::time::Instant;

use super::page::{Page, Trouble, unexpected};

const RATE: BitRate = BitRate::K500;
/// How long anything may take on the bus before it is unexpected.
const PATIENCE: Duration = Duration::from_secs(10);
/// How often a master asks or sends SYNC while it waits.
const CYCLE: Duration = Duration::from_millis(10);

/// Master, bus and device, and the page.
pub(super) struct NodeStage<'w> {
    pub(super) page: Page<'w>,
    bus: Bus<CanopenEvent>,
    master: Seat,
    device: Seat,
    words: Network,
    now: Instant,
    /// What was told last of each identifier of the device.
    told: Map<u32, Frame>,
}

impl<'w> NodeStage<'w> {
    /// A master and a device that is just being switched on.
    pub(super) fn open(product: &'static Product, out: &'w mut dyn Write) -> Result<Self, Trouble> {
        let now = Instant::ZERO;
        let node = NodeId::new(PLACE).map_err(unexpected)?;
        let mut bus = Bus::new(RATE);
        let master = bus.connect(now);
        let device = product.make(node, &Choices::default(), Eeprom::Internal, now);
        let device = bus.add(now, Box::new(StoredNode::new(device, now)));
        let mut words = Network::default();
        words.know(node, product.vocabulary);
        let mut page = Page::new(out);
        page.text(&format!(
            "profidrive demo: a CANopen master and an emulated {} as node {PLACE} on a CAN bus at {RATE}, all in memory. \
             A frame is its identifier and its octets, both hexadecimal. Times are milliseconds on the bus.",
            product.sheet.product_name
        ))?;
        Ok(Self { page, bus, master, device, words, now, told: Map::new() })
    }

    /// Plays what happens next.
    pub(super) fn play(&mut self, act: &NodeAct) -> Result<(), Trouble> {
        match *act {
            NodeAct::Title(title) => self.page.title(title),
            NodeAct::Text(text) => self.page.text(text),
            NodeAct::Read(at, says) => self.read(at, says),
            NodeAct::Write(at, octets, says) => self.write(at, octets, says),
            NodeAct::Send(id, octets) => self.send(id, octets),
            NodeAct::Wait(says) => self.wait(says),
            NodeAct::SyncUntil(says) => self.sync_until(says),
            NodeAct::Pass(time) => self.listen(time, |_| false).map(drop),
            NodeAct::Input(name, value) => {
                self.act(|device, now| device.set_input(now, name, Level::Number(value)));
                Ok(())
            }
            NodeAct::Provoke(fault) => self.provoke(fault),
            NodeAct::Repair => {
                self.act(|device, now| device.make_nominal(now));
                Ok(())
            }
            NodeAct::Look(shows) => self.look(shows),
        }
    }

    /// The master sends a frame; whatever the device says in the next milliseconds is told.
    fn send(&mut self, id: u16, octets: &[u8]) -> Result<(), Trouble> {
        let frame = self.offer(id, octets)?;
        let explanation = self.words.frame(&frame);
        self.tell(self.now, "master", &frame, &explanation)?;
        self.listen(Duration::from_millis(3), |_| false).map(drop)
    }

    /// Reads an entry by SDO; the answer has to say this.
    fn read(&mut self, at: Address, says: &str) -> Result<(), Trouble> {
        let (index, sub) = at.pair();
        let [low, high] = index.to_le_bytes();
        self.sdo([0x40, low, high, sub, 0, 0, 0, 0], says)
    }

    /// Writes an entry by SDO, low octet first; the answer has to say this.
    fn write(&mut self, at: Address, octets: &[u8], says: &str) -> Result<(), Trouble> {
        let (index, sub) = at.pair();
        let [low, high] = index.to_le_bytes();
        let mut request = [0x23, low, high, sub, 0, 0, 0, 0];
        let unused = 4_usize.saturating_sub(octets.len());
        if let ([command, ..], Ok(unused)) = (&mut request, u8::try_from(unused)) {
            *command |= unused << 2;
        }
        request.iter_mut().skip(4).zip(octets).for_each(|(to, octet)| *to = *octet);
        self.sdo(request, says)
    }

    fn sdo(&mut self, request: [u8; 8], says: &str) -> Result<(), Trouble> {
        let frame = self.offer(0x600 + u16::from(PLACE), &request)?;
        let explanation = self.words.frame(&frame);
        self.tell(self.now, "master", &frame, &explanation)?;
        self.told.remove(&(0x580 + u32::from(PLACE)));
        self.wait(says)
    }

    /// Tells what the device sends until it says this.
    pub(super) fn wait(&mut self, says: &str) -> Result<(), Trouble> {
        match self.listen(PATIENCE, |explanation| explanation.summary.contains(says))? {
            true => Ok(()),
            false => Err(Trouble::Unexpected(format!("waited {PATIENCE:?} for a frame that says '{says}'"))),
        }
    }

    /// Sends SYNC every 10 ms, tells only the frame of the device that says this, and how many SYNCs it took.
    fn sync_until(&mut self, says: &str) -> Result<(), Trouble> {
        let end = self.now.saturating_add(PATIENCE);
        let mut syncs = 0_u32;
        while self.now < end {
            self.offer(0x080, &[])?;
            syncs += 1;
            let until = self.now.saturating_add(CYCLE);
            while let Some((at, frame)) = self.heard(until) {
                let explanation = self.words.frame(&frame);
                if explanation.summary.contains(says) {
                    self.page.line(
                        at,
                        "master",
                        format_args!("080  SYNC every {CYCLE:?}, the last is number {syncs}"),
                    )?;
                    return self.tell(at, "device", &frame, &explanation);
                }
            }
        }
        Err(Trouble::Unexpected(format!("waited {PATIENCE:?} for a frame that says '{says}'")))
    }

    /// Makes a fault.
    fn provoke(&mut self, fault: &str) -> Result<(), Trouble> {
        let outcome = self.act(|device, now| device.provoke(now, fault));
        match outcome {
            Some(Ok(())) => Ok(()),
            Some(Err(declined)) => Err(Trouble::Unexpected(format!("{fault}: {declined:?}"))),
            None => Err(Trouble::Unexpected("the device is gone".into())),
        }
    }

    /// Tells what a person sees of the device; it has to show this.
    fn look(&mut self, shows: &str) -> Result<(), Trouble> {
        let face = self.act(|device, now| device.face(now)).map(|face| face.to_string()).unwrap_or_default();
        self.page.line(self.now, "shows", format_args!("{face}"))?;
        if face.contains(shows) {
            Ok(())
        } else {
            Err(Trouble::Unexpected(format!("'{face}' lacks '{shows}'")))
        }
    }

    fn act<R>(&mut self, mut act: impl FnMut(&mut dyn Description, Instant) -> R) -> Option<R> {
        let mut result = None;
        self.bus.with(self.now, self.device, |node: &mut StoredNode, now| {
            node.act(now, |device, now| {
                device.act(now, &mut |description| result = Some(act(description, now)));
            });
        });
        result
    }

    /// Puts a frame of the master on the bus.
    fn offer(&mut self, id: u16, octets: &[u8]) -> Result<Frame, Trouble> {
        let frame = Frame::data(Id::base(id).map_err(unexpected)?, octets).map_err(unexpected)?;
        self.bus.send(self.now, self.master, frame).map_err(unexpected)?;
        Ok(frame)
    }

    /// Tells what is new until a frame that was told is what is wanted. Whether it came.
    fn listen(
        &mut self,
        limit: Duration,
        mut wanted: impl FnMut(&Explanation) -> bool,
    ) -> Result<bool, Trouble> {
        let end = self.now.saturating_add(limit);
        while let Some((at, frame)) = self.heard(end) {
            let explanation = self.words.frame(&frame);
            if self.told.insert(frame.id().number(), frame) != Some(frame) {
                self.tell(at, "device", &frame, &explanation)?;
                if wanted(&explanation) {
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// The next frame of the device, if one comes by `end`.
    fn heard(&mut self, end: Instant) -> Option<(Instant, Frame)> {
        loop {
            if let Some(heard) = self.bus.poll_heard(self.master) {
                return Some((heard.at, heard.frame));
            }
            while self.bus.poll_event().is_some() {}
            match self.bus.poll_timeout().filter(|due| *due <= end) {
                Some(due) => {
                    self.now = self.now.max(due);
                    self.bus.handle_timeout(self.now);
                }
                None => {
                    self.now = end;
                    return None;
                }
            }
        }
    }

    fn tell(
        &mut self,
        at: Instant,
        speaker: &str,
        frame: &Frame,
        explanation: &Explanation,
    ) -> Result<(), Trouble> {
        let octets: Vec<String> = frame.octets().iter().map(|octet| format!("{octet:02X}")).collect();
        let id = frame.id().number();
        self.page.line(at, speaker, format_args!("{id:03X}  {}", octets.join(" ")))?;
        self.page.line_without_time("", format_args!("{}", explanation.summary))
    }
}
