//! A master on a line with noise and with masters that say anything at any time: nothing that arrives ends the program,
//! and noise is no station.

use core::cell::RefCell;
use core::time::Duration;
use std::collections::VecDeque;
use std::io;
use std::rc::Rc;

use profidrive::host::{Clock, Link, Received, Stop};
use profidrive::master::{Session, SessionError, Settings};
use profidrive::profibus::fdl::{Address, StationType};
use profidrive::time::{BaudRate, Instant};
use proptest::prelude::*;

const SHORT_ACKNOWLEDGE: u8 = 0xE5;
const TOKEN: u8 = 0xDC;
/// Station 1 to master 0: a master that waits for the token.
const READY_FOR_THE_RING: [u8; 6] = [0x10, 0x00, 0x01, 0x20, 0x21, 0x16];

/// What answers a telegram of the master.
type Answer = Box<dyn FnMut(&[u8]) -> Vec<u8>>;

/// A line on which waiting lets time pass, and its clock.
#[derive(Clone)]
struct Noisy(Rc<RefCell<(Instant, VecDeque<u8>, Answer)>>);

impl Noisy {
    fn new(answer: impl FnMut(&[u8]) -> Vec<u8> + 'static) -> Self {
        Self(Rc::new(RefCell::new((Instant::ZERO, VecDeque::new(), Box::new(answer)))))
    }

    /// profirust words its warnings only where somebody reads them, and has failed at one.
    #[cfg(feature = "emulator")]
    fn read_warnings() {
        // Another test may have done it.
        let _ = tracing_subscriber::fmt().with_writer(io::sink).try_init();
    }

    #[cfg(not(feature = "emulator"))]
    fn read_warnings() {}

    fn session(&self) -> Session<Self, Self> {
        Self::read_warnings();
        let settings = Settings::untimed(Address::from_octet(0), BaudRate::K500);
        Session::new(self.clone(), self.clone(), Stop::new().unwrap(), settings).unwrap()
    }
}

impl Clock for Noisy {
    fn now(&self) -> Instant {
        self.0.borrow().0
    }
}

impl Link for Noisy {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        let incoming = &mut self.0.borrow_mut().1;
        let count = buf.len().min(incoming.len());
        for (to, octet) in buf.iter_mut().zip(incoming.drain(..count)) {
            *to = octet;
        }
        Ok(if count == 0 { Received::Nothing } else { Received::Octets(count) })
    }

    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        let (_, incoming, answer) = &mut *self.0.borrow_mut();
        incoming.extend(answer(telegram));
        Ok(())
    }

    fn wait(&mut self, timeout: Option<Duration>, _: &Stop) -> io::Result<()> {
        let now = &mut self.0.borrow_mut().0;
        *now = now.saturating_add(timeout.unwrap_or(Duration::from_millis(1)));
        Ok(())
    }
}

fn addresses(last: u8) -> impl Iterator<Item = Address> {
    (1..=last).map(Address::from_octet)
}

/// Who is found.
fn found(line: &Noisy, last: u8) -> Result<Vec<(u8, StationType)>, SessionError> {
    let mut found = Vec::new();
    line.session().find(addresses(last), |address, station| {
        found.extend(station.map(|station| (address.number(), station)));
    })?;
    Ok(found)
}

#[test]
fn a_short_acknowledge_behind_a_passed_token_ends_no_master() {
    let line = Noisy::new(|telegram| match telegram {
        [0x10, 1, ..] => READY_FOR_THE_RING.into(),
        [TOKEN, 1, 0] => vec![SHORT_ACKNOWLEDGE],
        [..] => Vec::new(),
    });
    assert_eq!(found(&line, 20).unwrap(), [(1, StationType::MasterReady)]);
}

#[test]
fn noise_is_no_station_and_a_search_beside_it_is_as_short_as_without() {
    let silent = Noisy::new(|_| Vec::new());
    assert_eq!(found(&silent, 126).unwrap(), []);
    let noisy =
        Noisy::new(|telegram| if telegram[0] == TOKEN { Vec::new() } else { vec![SHORT_ACKNOWLEDGE] });
    assert_eq!(found(&noisy, 126).unwrap(), []);
    let longest = silent.now().saturating_since(Instant::ZERO) + Duration::from_secs(1);
    let took = noisy.now().saturating_since(Instant::ZERO);
    assert!(took <= longest, "{took:?}, without noise {longest:?}");
}

#[test]
fn a_station_is_found_beside_noise() {
    let mut turns = 0;
    let line = Noisy::new(move |telegram| {
        turns += 1;
        match telegram {
            // Every other request is hit.
            [0x10, ..] if turns % 2 == 0 => vec![SHORT_ACKNOWLEDGE],
            [0x10, 5, ..] => vec![0x10, 0x00, 0x05, 0x00, 0x05, 0x16],
            [..] => Vec::new(),
        }
    });
    assert_eq!(found(&line, 20).unwrap(), [(5, StationType::Slave)]);
}

/// Something on the line.
fn piece() -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        Just(vec![SHORT_ACKNOWLEDGE]),
        Just(READY_FOR_THE_RING.to_vec()),
        (0..4_u8, 0..4_u8).prop_map(|(da, sa)| vec![TOKEN, da, sa]),
        any::<[u8; 2]>().prop_map(|[da, sa]| vec![TOKEN, da, sa]),
        (0..4_u8, 0..6_u8, any::<u8>()).prop_map(|(da, sa, fc)| {
            let sum = da.wrapping_add(sa).wrapping_add(fc);
            vec![0x10, da, sa, fc, sum, 0x16]
        }),
        // Slave_Diag of station 5 with any octets.
        any::<[u8; 6]>().prop_map(|octets| {
            let body = [&[0x80, 0x85, 0x08, 0x3E, 0x3C][..], &octets].concat();
            let sum = body.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
            [&[0x68, 11, 11, 0x68][..], &body, &[sum, 0x16]].concat()
        }),
        proptest::collection::vec(any::<u8>(), 0..12),
    ]
}

proptest! {
    #![proptest_config(crate::long::cases(12, 100))]

    #[test]
    fn whatever_arrives_the_program_goes_on(pieces in proptest::collection::vec(piece(), 1..60)) {
        let mut left = VecDeque::from(pieces);
        let line = Noisy::new(move |telegram| match (left.pop_front(), telegram) {
            (Some(piece), _) => piece,
            (None, [0x10, 1, ..]) => READY_FOR_THE_RING.into(),
            (None, _) => Vec::new(),
        });
        let mut session = line.session();
        let outcomes = [
            session.find(addresses(8), |_, _| {}),
            session.diagnosis(Address::from_octet(5)).map(drop),
            session.start(Address::from_octet(5)),
            session.release(),
        ];
        let failed = outcomes.iter().any(|outcome| matches!(outcome, Err(SessionError::Library(_))));
        prop_assert!(!failed, "{outcomes:?}");
    }
}
