//! Which master owns each station, its groups, and what Global_Control holds in it: as the stations tell it.

use core::time::Duration;

use super::{LineHint, is_due};
use crate::profibus::dp::event::Event;
use crate::profibus::dp::global_control::Latch;
use crate::profibus::dp::{ControlBit, GlobalControl};
use crate::profibus::fdl::Address;
use crate::time::Instant;

/// What is held longer was perhaps left so.
const HELD: Duration = Duration::from_secs(5);

/// Every station that a master has parameterised, by address. In steady exchange each look costs a comparison.
#[derive(Debug)]
pub(in crate::host::bus) struct Owned {
    of: Vec<Option<Owner>>,
    /// How many stations hold outputs or inputs.
    holding: u8,
    said: [Option<Instant>; 2],
}

#[derive(Clone, Copy, Debug)]
struct Owner {
    master: Address,
    groups: u8,
    /// Since when Sync holds the outputs, and Freeze the inputs.
    held: [Option<Instant>; 2],
}

impl Default for Owned {
    fn default() -> Self {
        Self { of: vec![None; usize::from(Address::BROADCAST.number())], holding: 0, said: [None; 2] }
    }
}

impl Owned {
    /// A station has told this.
    pub(in crate::host::bus) fn told(&mut self, now: Instant, station: Address, event: &Event) {
        let Some(place) = self.of.get_mut(usize::from(station.number())) else { return };
        match event {
            Event::Parameterised { master, groups, .. } => {
                *place = Some(Owner { master: *master, groups: *groups, held: [None; 2] });
            }
            Event::Controlled { command, .. } => {
                let Some(owner) = place else { return };
                for (held, latch) in owner.held.iter_mut().zip([command.sync, command.freeze]) {
                    match latch {
                        Latch::Keep => {}
                        Latch::Set => *held = Some(now),
                        Latch::Release => *held = None,
                    }
                }
            }
            Event::PrmRejected { .. }
            | Event::Released { .. }
            | Event::CfgRejected { .. }
            | Event::WrongOutputLength { .. }
            | Event::WatchdogExpired { .. }
            | Event::ApplicationSilent { .. }
            | Event::ApplicationAborted { .. } => *place = None,
            Event::PrmForeign { .. }
            | Event::MinTsdrOnly { .. }
            | Event::DataExchange { .. }
            | Event::CfgToJudge { .. }
            | Event::LatchClosed { .. }
            | Event::NotServed { .. }
            | Event::SafeState { .. }
            | Event::Read { .. }
            | Event::AddressSet { .. }
            | Event::AddressRefused { .. } => return,
        }
        let holds = |owner: &&Owner| owner.held.iter().any(Option::is_some);
        self.holding = self.of.iter().flatten().filter(holds).count().try_into().unwrap_or(u8::MAX);
    }

    /// Whether no station holds anything.
    pub(super) const fn holds_nothing(&self) -> bool {
        self.holding == 0
    }

    /// The master exchanges data with a station.
    pub(super) fn exchanged(&mut self, now: Instant, station: Address) -> Option<LineHint> {
        let owner = (*self.of.get(usize::from(station.number()))?)?;
        for ((bit, since), said) in
            [ControlBit::Sync, ControlBit::Freeze].into_iter().zip(owner.held).zip(&mut self.said)
        {
            let time = since.map(|since| now.saturating_since(since)).filter(|time| *time >= HELD);
            if let Some(time) = time
                && is_due(said, now)
            {
                let time = Duration::from_secs(time.as_secs());
                return Some(LineHint::Held { master: owner.master, station, bit, time });
            }
        }
        None
    }

    /// Why a command changes nothing at any station of ours; `None`: one of them obeys, or none is parameterised.
    pub(super) fn in_vain(&self, master: Address, control: GlobalControl, groups: u8) -> Option<LineHint> {
        let mut owners = self.of.iter().flatten().peekable();
        owners.peek()?;
        let mut own = owners.filter(|owner| owner.master == master).peekable();
        if own.peek().is_none() {
            return Some(LineHint::ControlOfOther { master });
        }
        let obeys = own.any(|owner| control.addresses(owner.groups));
        (!obeys).then_some(LineHint::NoSuchGroup { master, groups })
    }
}
