//! One pass of a loop over a UART of `embedded-io`.

use embedded_hal::digital::OutputPin;
use embedded_io::{Read, ReadReady, Write};

use super::rs485::CHUNK;
use super::{PortError, Rs485, Slave};
use crate::profibus::fdl::MAX_TELEGRAM_LEN;
use crate::time::Instant;

impl<U: Read + ReadReady + Write, P: OutputPin> Rs485<U, P> {
    /// One pass: takes the octets that the UART holds, lets time pass, and sends the reply whose time has come. Call it
    /// again and again, and at the latest at [`Slave::poll_timeout`].
    ///
    /// Returns whether a telegram came, was sent, or a deadline was over: then look at the slave, its outputs and its news.
    /// An error of the UART while it receives (parity, framing, overrun) is a damaged octet to the slave.
    ///
    /// Blocks only while it sends, from the first octet to the end of the last one: the direction pin must not fall before,
    /// and nobody else talks then.
    ///
    /// # Errors
    /// [`PortError`] if the UART does not send or the pin cannot be set.
    pub fn pass<S: Slave>(
        &mut self,
        slave: &mut S,
        mut clock: impl FnMut() -> Instant,
    ) -> Result<bool, PortError<U::Error, P::Error>> {
        let mut news = self.hear(slave, &mut clock);
        let now = clock();
        if slave.poll_timeout().is_some_and(|due| due <= now) {
            slave.handle_timeout(now);
            news = true;
        }
        let mut buf = [0; MAX_TELEGRAM_LEN];
        if let Some(octets) = slave.poll_transmit(now, &mut buf) {
            self.send(octets)?;
            news = true;
        }
        Ok(news)
    }

    /// As much as a UART holds at once, never more: a sender without end does not hold up the replies.
    fn hear<S: Slave>(&mut self, slave: &mut S, clock: &mut impl FnMut() -> Instant) -> bool {
        if !matches!(self.uart.read_ready(), Ok(true)) {
            return false;
        }
        let mut octets = [0; CHUNK];
        match self.uart.read(&mut octets) {
            Ok(len) => slave.handle_bytes(clock(), octets.get(..len).unwrap_or_default()),
            Err(_) => slave.handle_damaged(clock()),
        }
    }

    fn send(&mut self, octets: &[u8]) -> Result<(), PortError<U::Error, P::Error>> {
        self.direction.set_high().map_err(PortError::Direction)?;
        let sent = self.uart.write_all(octets).and_then(|()| self.uart.flush());
        // Whatever became of it: nobody else could send.
        self.direction.set_low().map_err(PortError::Direction)?;
        sent.map_err(PortError::Send)
    }
}

#[cfg(test)]
mod tests {
    use core::convert::Infallible;

    use embedded_hal::digital::ErrorType as PinErrorType;
    use embedded_io::{ErrorKind, ErrorType};

    use super::*;
    use crate::devices::ag03::profibus::{Config, Device, Timing};
    use crate::profibus::dp::{Description, Fixed, Framed, Station};
    use crate::profibus::fdl::{Address, Resync};
    use crate::time::BaudRate;

    /// What the line saw, pin included.
    #[derive(Debug, PartialEq, Eq)]
    enum Seen {
        High,
        Low,
        Octets(Vec<u8>),
        Flushed,
    }

    #[derive(Default)]
    struct Uart {
        received: Vec<Result<u8, ErrorKind>>,
        seen: std::rc::Rc<core::cell::RefCell<Vec<Seen>>>,
        broken: bool,
    }

    struct Pin(std::rc::Rc<core::cell::RefCell<Vec<Seen>>>);

    impl PinErrorType for Pin {
        type Error = Infallible;
    }

    impl OutputPin for Pin {
        fn set_low(&mut self) -> Result<(), Infallible> {
            self.0.borrow_mut().push(Seen::Low);
            Ok(())
        }
        fn set_high(&mut self) -> Result<(), Infallible> {
            self.0.borrow_mut().push(Seen::High);
            Ok(())
        }
    }

    impl ErrorType for Uart {
        type Error = ErrorKind;
    }

    impl ReadReady for Uart {
        fn read_ready(&mut self) -> Result<bool, ErrorKind> {
            Ok(!self.received.is_empty())
        }
    }

    impl Read for Uart {
        fn read(&mut self, buf: &mut [u8]) -> Result<usize, ErrorKind> {
            *buf.first_mut().unwrap() = self.received.remove(0)?;
            Ok(1)
        }
    }

    impl Write for Uart {
        fn write(&mut self, buf: &[u8]) -> Result<usize, ErrorKind> {
            if self.broken {
                return Err(ErrorKind::BrokenPipe);
            }
            self.seen.borrow_mut().push(Seen::Octets(buf.to_vec()));
            Ok(buf.len())
        }
        fn flush(&mut self) -> Result<(), ErrorKind> {
            self.seen.borrow_mut().push(Seen::Flushed);
            Ok(())
        }
    }

    const STATUS: [u8; 6] = [0x10, 5, 2, 0x49, 0x50, 0x16];
    const REPLY: [u8; 6] = [0x10, 2, 5, 0, 7, 0x16];

    fn drive() -> Device {
        let address = Address::station(5).unwrap();
        Device::new(
            Config { baud: BaudRate::K500, timing: Timing::True, ..Config::new(address) },
            Instant::ZERO,
        )
    }

    fn station() -> Framed {
        let application = Fixed { configurations: &[&[0x20, 0x10]], ..Fixed::PLAIN };
        let address = Address::station(5).unwrap();
        Framed::new(
            Resync::Idle(BaudRate::K500),
            Station::new(address, BaudRate::K500, Some(100), Description::PLAIN, application),
        )
    }

    /// Octets that came 22 us apart, then so many passes 1 us apart.
    fn play(slave: &mut impl Slave, received: Vec<Result<u8, ErrorKind>>, broken: bool) -> (Vec<Seen>, bool) {
        let seen = std::rc::Rc::default();
        let count = received.len();
        let uart = Uart { received, seen: std::rc::Rc::clone(&seen), broken };
        let mut port = Rs485::new(uart, Pin(std::rc::Rc::clone(&seen))).unwrap();
        let mut now = Instant::from_millis(1);
        let mut failed = false;
        for pass in 0..count + 60 {
            let step = if pass < count { 22 } else { 1 };
            now = now.saturating_add(core::time::Duration::from_micros(step));
            failed |= port.pass(slave, || now).is_err();
        }
        drop(port);
        (std::rc::Rc::try_unwrap(seen).unwrap().into_inner(), failed)
    }

    #[test]
    fn a_reply_goes_out_between_the_edges_of_the_direction_pin() {
        let replied = [Seen::Low, Seen::High, Seen::Octets(REPLY.into()), Seen::Flushed, Seen::Low];
        let received = || STATUS.map(Ok).into();
        assert_eq!(play(&mut drive(), received(), false), (replied.into(), false));
        let replied = [Seen::Low, Seen::High, Seen::Octets(REPLY.into()), Seen::Flushed, Seen::Low];
        assert_eq!(play(&mut station(), received(), false), (replied.into(), false));
    }

    #[test]
    fn an_octet_with_wrong_parity_gets_no_reply_and_a_uart_that_fails_lets_go_of_the_line() {
        for place in 0..STATUS.len() {
            let mut received = Vec::from(STATUS.map(Ok));
            *received.get_mut(place).unwrap() = Err(ErrorKind::InvalidData);
            assert_eq!(play(&mut drive(), received, false), (std::vec![Seen::Low], false), "octet {place}");
        }
        let (seen, failed) = play(&mut drive(), STATUS.map(Ok).into(), true);
        assert_eq!((seen, failed), (std::vec![Seen::Low, Seen::High, Seen::Low], true));
    }
}
