//! What the words of a station depend on, asked of the station itself.

use super::context::Learned;
use super::value::Lengths;
use super::{Context, Mode, Sender};
use crate::devices::ag03::param::Model;
use crate::face::Description;
use crate::profibus::fdl::Address;
use crate::profibus::ppo::Pkw;

/// What the words of a station depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Known {
    model: Model,
    mode: Mode,
    lengths: Lengths,
}

impl Known {
    /// By the parameters, as whoever reads them on the line knows it: a drive follows within a cycle. `None`: what it
    /// says means the same at any time.
    pub fn of(station: &dyn Description) -> Option<Self> {
        let mut learned = Learned::default();
        station.each_meaning(&mut |number, value| learned.hear_value(number, value));
        let Learned { model, heard, lengths, .. } = learned;
        Some(Self { model: model?, mode: heard?, lengths })
    }

    /// The jobs and replies of the parameter channel at the beginning of outputs and inputs, in words.
    pub fn channel(self, outputs: &[u8], inputs: &[u8]) -> [Option<String>; 2] {
        let Self { model, mode, lengths } = self;
        // One context: a reply is understood by its job.
        let mut context = Context::of_drive(model, mode, lengths);
        [(outputs, Sender::Master), (inputs, Sender::Slave)].map(|(octets, sender)| {
            let words: &[u8; 8] = octets.first_chunk()?;
            let said = context.bare(words, Some(sender))?.summary;
            Some(format!("{}  {said}", Pkw::from_octets(*words)))
        })
    }
}

impl Context {
    /// Takes what is known of a station ([`Context::know`]).
    pub(crate) fn know_station(&mut self, station: Address, Known { model, mode, lengths }: Known) {
        self.know(station, model, mode, lengths);
    }
}
