//! A loop over a UART of `embedded-io-async`, for embassy and other executors.

use core::convert::Infallible;
use core::future::{Future, poll_fn};
use core::pin::pin;
use core::task::Poll;

use embedded_hal::digital::OutputPin;
use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{Read, Write};

use super::rs485::CHUNK;
use super::{PortError, Rs485, Slave};
use crate::profibus::fdl::MAX_TELEGRAM_LEN;
use crate::time::{Instant, nanos};

/// What ended the wait.
enum Woken<E> {
    Octets(Result<usize, E>),
    Time,
}

impl<U: Read + Write, P: OutputPin> Rs485<U, P> {
    /// Serves the slave for ever: octets to it, its replies to the line, time when it is due.
    ///
    /// `turn` is called whenever something has come of an octet or a deadline was over: there the application takes outputs
    /// and news and sets inputs. An error of the UART while it receives (parity, framing, overrun) is a damaged octet to the
    /// slave.
    ///
    /// The UART's `read` must keep what it has when it is dropped, as those with a buffer do (embassy's `BufferedUart`). An
    /// octet counts from when the task takes it, so a reply is later by as much as the executor is, never earlier than
    /// min T_SDR.
    ///
    /// # Errors
    /// [`PortError`] if the UART does not send or the pin cannot be set.
    pub async fn serve<S: Slave>(
        &mut self,
        slave: &mut S,
        delay: &mut impl DelayNs,
        mut clock: impl FnMut() -> Instant,
        mut turn: impl FnMut(Instant, &mut S),
    ) -> Result<Infallible, PortError<U::Error, P::Error>> {
        let mut octets = [0; CHUNK];
        loop {
            let wait = slave.poll_timeout().map(|due| due.saturating_since(clock()));
            let wait = wait.map(|wait| u32::try_from(nanos(wait)).unwrap_or(u32::MAX));
            let woken = first(self.uart.read(&mut octets), delay, wait).await;
            let now = clock();
            let news = match woken {
                Woken::Octets(Ok(len)) => slave.handle_bytes(now, octets.get(..len).unwrap_or_default()),
                Woken::Octets(Err(_)) => slave.handle_damaged(now),
                Woken::Time => {
                    slave.handle_timeout(now);
                    true
                }
            };
            if news {
                turn(now, slave);
            }
            let mut buf = [0; MAX_TELEGRAM_LEN];
            if let Some(reply) = slave.poll_transmit(now, &mut buf) {
                self.send_all(reply).await?;
            }
        }
    }

    async fn send_all(&mut self, octets: &[u8]) -> Result<(), PortError<U::Error, P::Error>> {
        self.direction.set_high().map_err(PortError::Direction)?;
        let mut sent = self.uart.write_all(octets).await;
        if sent.is_ok() {
            sent = self.uart.flush().await;
        }
        // Whatever became of it: nobody else could send.
        self.direction.set_low().map_err(PortError::Direction)?;
        sent.map_err(PortError::Send)
    }
}

/// Octets or, if there is a deadline, the end of these nanoseconds. Octets first: a telegram that is complete is not given up.
async fn first<E>(
    read: impl Future<Output = Result<usize, E>>,
    delay: &mut impl DelayNs,
    wait: Option<u32>,
) -> Woken<E> {
    let mut read = pin!(read);
    let Some(wait) = wait else { return Woken::Octets(read.await) };
    let mut time = pin!(delay.delay_ns(wait));
    poll_fn(|context| match read.as_mut().poll(context) {
        Poll::Ready(result) => Poll::Ready(Woken::Octets(result)),
        Poll::Pending => time.as_mut().poll(context).map(|()| Woken::Time),
    })
    .await
}

#[cfg(test)]
mod tests {
    use core::cell::{Cell, RefCell};
    use core::task::{Context, Waker};
    use core::time::Duration;

    use embedded_io_async::{ErrorKind, ErrorType};

    use super::super::NoPin;
    use super::*;
    use crate::devices::ag03::profibus::{Config, Device, Timing};
    use crate::profibus::fdl::Address;
    use crate::time::BaudRate;

    /// Time that passes when everything waits, and octets at their times.
    #[derive(Default)]
    struct World {
        now: Cell<u64>,
        next: Cell<u64>,
        received: RefCell<Vec<(u64, Result<u8, ErrorKind>)>>,
        sent: RefCell<Vec<(u64, Vec<u8>)>>,
    }

    struct Uart<'a>(&'a World);
    struct Delay<'a>(&'a World);

    impl ErrorType for Uart<'_> {
        type Error = ErrorKind;
    }

    impl Read for Uart<'_> {
        async fn read(&mut self, buf: &mut [u8]) -> Result<usize, ErrorKind> {
            let octet = poll_fn(|_| {
                let mut received = self.0.received.borrow_mut();
                match received.first() {
                    Some((at, _)) if *at <= self.0.now.get() => Poll::Ready(received.remove(0).1),
                    Some((at, _)) => {
                        self.0.next.set((*at).min(self.0.next.get()));
                        Poll::Pending
                    }
                    None => Poll::Pending,
                }
            });
            *buf.first_mut().unwrap() = octet.await?;
            Ok(1)
        }
    }

    impl Write for Uart<'_> {
        async fn write(&mut self, buf: &[u8]) -> Result<usize, ErrorKind> {
            self.0.sent.borrow_mut().push((self.0.now.get(), buf.to_vec()));
            Ok(buf.len())
        }
        async fn flush(&mut self) -> Result<(), ErrorKind> {
            Ok(())
        }
    }

    impl DelayNs for Delay<'_> {
        async fn delay_ns(&mut self, ns: u32) {
            let due = self.0.now.get() + u64::from(ns);
            poll_fn(|_| {
                if due <= self.0.now.get() {
                    return Poll::Ready(());
                }
                self.0.next.set(due.min(self.0.next.get()));
                Poll::Pending
            })
            .await;
        }
    }

    /// Runs a drive until 10 ms; how often the application had its turn.
    fn play(world: &World) -> u32 {
        let address = Address::station(5).unwrap();
        let config = Config { baud: BaudRate::K500, timing: Timing::True, ..Config::new(address) };
        let mut slave = Device::new(config, Instant::ZERO);
        let mut port = Rs485::new(Uart(world), NoPin).unwrap();
        let mut turns = 0;
        let mut delay = Delay(world);
        let clock = || Instant::from_nanos(world.now.get());
        {
            let mut serve = pin!(port.serve(&mut slave, &mut delay, clock, |_, _| turns += 1));
            while world.now.get() < 10_000_000 {
                world.next.set(u64::MAX);
                let mut context = Context::from_waker(Waker::noop());
                assert!(serve.as_mut().poll(&mut context).is_pending());
                world.now.set(world.next.get().min(10_000_000));
            }
        }
        turns
    }

    #[test]
    fn the_reply_goes_out_at_min_tsdr_and_a_damaged_request_gets_none() {
        let world = World::default();
        let request = [0x10, 5, 2, 0x49, 0x50, 0x16];
        let octets = request.iter().zip(1..).map(|(octet, number)| (2_000_000 + number * 22_000, Ok(*octet)));
        *world.received.borrow_mut() = octets.collect();
        assert!(play(&world) >= 2);
        let due = 2_000_000 + 6 * 22_000 + u64::try_from(Duration::from_micros(22).as_nanos()).unwrap();
        assert_eq!(world.sent.take(), [(due, std::vec![0x10, 2, 5, 0, 7, 0x16])]);

        let octets = request.iter().zip(1..).map(|(octet, number)| {
            (2_000_000 + number * 22_000, if number == 3 { Err(ErrorKind::InvalidData) } else { Ok(*octet) })
        });
        let damaged = World::default();
        *damaged.received.borrow_mut() = octets.collect();
        play(&damaged);
        assert_eq!(damaged.sent.take(), []);
    }
}
