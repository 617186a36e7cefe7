//! A drive on PROFIBUS that keeps its address and parameters, as its host asks it.

use crate::face::Description;
use crate::profibus::dp::{Application, Station, StoredAddress};
use crate::profibus::fdl::{Address, MAX_TELEGRAM_LEN, Telegram};
use crate::time::{BaudRate, Instant};

use super::StationEvent;

/// The bits of one element of a parameter: its number, the element from 0.
pub type KeptValue = ((u16, u8), u32);

/// A drive of the profile on PROFIBUS, of whichever version: telegrams and time in, telegrams, news and a deadline out.
pub trait BusDrive: Description {
    /// Who judges what its master sends.
    type Application: Application;

    /// Its station: address, slave, and what is to be kept of both.
    fn station(&self) -> &Station<Self::Application>;

    /// Its station address.
    fn address(&self) -> Address {
        self.station().address()
    }

    /// The line has another rate from now on.
    fn set_baud(&mut self, baud: BaudRate);

    /// Takes one telegram whose last octet ended at `now`.
    fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent));

    /// Time has passed. Spurious calls are harmless.
    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(StationEvent));

    /// The telegram to send at `now`, written to `buf`, if its time has come: how many octets it has.
    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(StationEvent),
    ) -> Option<usize>;

    /// When to call [`BusDrive::handle_timeout`] and [`BusDrive::poll_transmit`] again; `None` = a telegram comes first.
    fn poll_timeout(&self) -> Option<Instant>;

    /// The host keeps its parameters from now on: see [`BusDrive::take_changed`].
    fn keep_parameters(&mut self);

    /// Whether there is something new to be kept, which the host reports with [`BusDrive::handle_stored`].
    fn take_changed(&mut self) -> bool;

    /// Every value to be kept.
    fn to_keep(&self) -> Vec<KeptValue>;

    /// The drive is as it was before it was switched off. Values that its table does not take any more are left out.
    fn recall(&mut self, address: (StoredAddress, &[u8]), kept: Vec<KeptValue>);

    /// What was to be kept is safe, or could not be kept.
    fn handle_stored(&mut self, now: Instant, stored: bool);
}
