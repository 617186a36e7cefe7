//! A device whose replies are changed on their way.

use profidrive::devices::StationEvent;
use profidrive::host::Participant;
use profidrive::profibus::fdl::{Address, MAX_TELEGRAM_LEN, Telegram};
use profidrive::time::{BaudRate, Instant};

/// What becomes of the data of a reply, beside the data that were asked last.
pub(crate) type Change = fn(&[u8], &mut [u8]);

/// Changes the replies at one SAP; `None`: those to Data_Exchange.
pub(crate) struct Changed<P> {
    inner: P,
    sap: Option<u8>,
    change: Change,
    asked: Vec<u8>,
    is_asked: bool,
}

impl<P> Changed<P> {
    pub(crate) const fn new(inner: P, sap: Option<u8>, change: Change) -> Self {
        Self { inner, sap, change, asked: Vec::new(), is_asked: false }
    }
}

impl<P: Participant> Participant for Changed<P> {
    fn address(&self) -> Address {
        self.inner.address()
    }

    fn set_baud(&mut self, baud: BaudRate) {
        self.inner.set_baud(baud);
    }

    fn handle_telegram(&mut self, now: Instant, telegram: &Telegram<'_>, news: &mut dyn FnMut(StationEvent)) {
        self.is_asked = false;
        if let Telegram::Data(data) = telegram {
            self.is_asked = data.dsap.map(|sap| sap.number()) == self.sap;
            if self.is_asked && (!data.data.is_empty() || self.sap.is_none()) {
                self.asked = data.data.to_vec();
            }
        }
        self.inner.handle_telegram(now, telegram, news);
    }

    fn handle_timeout(&mut self, now: Instant, news: &mut dyn FnMut(StationEvent)) {
        self.inner.handle_timeout(now, news);
    }

    fn poll_transmit(
        &mut self,
        now: Instant,
        buf: &mut [u8; MAX_TELEGRAM_LEN],
        news: &mut dyn FnMut(StationEvent),
    ) -> Option<usize> {
        let len = self.inner.poll_transmit(now, buf, news)?;
        // SD2: the data begin behind FC and the SAPs.
        let begin = if self.sap.is_some() { 9 } else { 7 };
        if len > begin + 2
            && self.is_asked
            && !self.asked.is_empty()
            && (buf[4] >= 0x80) == self.sap.is_some()
        {
            (self.change)(&self.asked, &mut buf[begin..len - 2]);
            buf[len - 2] = buf[4..len - 2].iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
        }
        Some(len)
    }

    fn poll_timeout(&self) -> Option<Instant> {
        self.inner.poll_timeout()
    }

    fn watchdog_on(&self) -> bool {
        self.inner.watchdog_on()
    }
}
