//! `status`, `faults` and `ack` of a drive on CANopen.

use crate::can_bus::canopen::{Address, Sub, Value};
use crate::can_bus::cia402::{Controlword, State, Statusword};
use crate::client::{NodeGoal, NodeSigns, NodeTrouble};
use crate::face::Why;
use serde_json::json;

use super::{Drive, NEWEST_ERROR, Octets, POSITION, number, say};
use crate::command::Failure;

const CONTROLWORD: Address = Address::new(0x6040, 0);
const STATUSWORD: Address = Address::new(0x6041, 0);
const MODE: Address = Address::new(0x6060, 0);
const ERRORS: Address = Address::new(0x1003, 0);
/// What `status` shows besides the words of bits, as far as the device has it.
const SHOWN: [Address; 7] = [
    Address::new(0x1001, 0),
    NEWEST_ERROR,
    Address::new(0x6004, 0),
    Address::new(0x6060, 0),
    Address::new(0x6061, 0),
    POSITION,
    Address::new(0x606C, 0),
];

impl Drive {
    /// Words of bits, bit by bit, and actual values.
    pub(super) fn show_status(&mut self, json: bool) -> Result<(), Failure> {
        let words = self.words();
        let bits = words
            .objects
            .iter()
            .filter(|object| (words.bits)(Address { index: object.index, sub: Sub(0) }, 0).is_some());
        let bits: Vec<Address> = bits.map(|object| Address { index: object.index, sub: Sub(0) }).collect();
        let shown: Vec<Address> = SHOWN.into_iter().filter(|at| self.entry(*at).is_some()).collect();
        let mut values = Vec::new();
        for at in shown.into_iter().chain(bits) {
            match self.get(at)? {
                Ok(octets) => values.push((at, octets)),
                Err(NodeTrouble::Refused { .. }) => {}
                Err(trouble) => return Err(self.failure(trouble)),
            }
        }
        let why = self.hindrances(&values);
        let nmt = self.client.nmt().map_or_else(|| "unknown".into(), |state| state.to_string());
        if json {
            let objects: Vec<_> = values
                .iter()
                .map(|(at, octets)| {
                    json!({
                        "object": at.to_string(),
                        "value": self.decoded(*at, octets).and_then(Value::number),
                        "field": self.network.value(self.node, *at, octets),
                    })
                })
                .collect();
            return say(json!({
                "node": self.node.number(),
                "device": self.device(),
                "nmt": nmt,
                "objects": objects,
                "does_not_move": why,
            }));
        }
        say(format_args!("node {}, {}, NMT {nmt}", self.node, self.device()))?;
        for (at, octets) in values {
            let field = self.network.value(self.node, at, &octets);
            say(format_args!("{} = {}", self.network.named(self.node, at), field.meaning))?;
            for bit in field.fields.iter().filter(|bit| bit.len == 2 && bit.raw.len() == 1) {
                let place = bit.bits.map_or_else(String::new, |bits| bits.low.to_string());
                say(format_args!("  {place:>2}  {}  {}", bit.raw, bit.name))?;
            }
        }
        for hindrance in why.iter().flatten() {
            say(format_args!("it does not move: {hindrance}"))?;
        }
        if why.is_some_and(|why| why.is_empty()) {
            say("nothing keeps it from moving")?;
        }
        Ok(())
    }

    /// What keeps it from moving, as far as a master sees it; `None`: it has no drive.
    fn hindrances(&self, values: &[(Address, Octets)]) -> Option<Vec<String>> {
        let word = |wanted: Address| {
            let (_, octets) = values.iter().find(|(at, _)| *at == wanted)?;
            u16::try_from(number(octets)).ok()
        };
        let signs = NodeSigns {
            nmt: self.client.nmt(),
            status: Statusword(word(STATUSWORD)?),
            control: word(CONTROLWORD).map(Controlword),
            mode: word(MODE).map(i64::from),
        };
        let mut why = Vec::new();
        signs.each_reason(&mut |reason| why.push(reason.to_string()));
        Some(why)
    }

    /// The history of errors, newest first.
    pub(super) fn show_faults(&mut self, clear: bool, json: bool) -> Result<(), Failure> {
        if clear {
            self.put(ERRORS, &[0])?.map_err(|trouble| self.failure(trouble))?;
        }
        let count = number(&self.must_get(ERRORS)?);
        let mut errors = Vec::new();
        for sub in 1..=u8::try_from(count).unwrap_or(u8::MAX) {
            let at = Address { sub: Sub(sub), ..ERRORS };
            let octets = self.must_get(at)?;
            errors.push((at, number(&octets), self.network.in_words(self.node, at, &octets).to_string()));
        }
        if json {
            let errors: Vec<_> = errors
                .iter()
                .map(|(at, value, text)| json!({ "object": at.to_string(), "value": value, "text": text }))
                .collect();
            return say(json!({ "count": count, "faults": errors }));
        }
        let cleared = if clear { "cleared; " } else { "" };
        say(format_args!("{cleared}{count} errors in 1003h, newest first:"))?;
        if errors.is_empty() {
            return say("  none");
        }
        for (at, _, text) in errors {
            say(format_args!("  {at} {text}"))?;
        }
        Ok(())
    }

    /// Acknowledges a fault, and leaves the drive as it was otherwise.
    pub(super) fn clear_fault(&mut self, json: bool) -> Result<(), Failure> {
        if self.product.is_some() && self.entry(CONTROLWORD).is_none() {
            return Err(Failure::Usage(format!(
                "the {} has no control word to acknowledge by",
                self.device()
            )));
        }
        let done = self.pursue(NodeGoal::Acknowledge)?;
        let why = match done {
            Some(Err(trouble @ NodeTrouble::Fault { .. })) => {
                Some(format!("{}; its cause is still present", self.reason(trouble)?))
            }
            Some(Err(trouble)) => return Err(self.failure(trouble)),
            Some(Ok(_)) | None => None,
        };
        let word = number(&self.must_get(STATUSWORD)?);
        self.pursue(NodeGoal::Leave)?;
        if let Some(why) = why {
            return Err(Failure::Other(why));
        }
        let status = Statusword(u16::try_from(word).unwrap_or_default());
        let state = State::of(status).map_or_else(|| "unknown".into(), |state| state.to_string());
        if json {
            say(json!({ "outcome": "acknowledged", "state": state }))
        } else {
            say(format_args!("acknowledged; the drive is in '{state}'"))
        }
    }
}
