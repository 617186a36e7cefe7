//! A line inside the process, for tests and examples.

use core::time::Duration;
use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use crate::host::{Link, Received, Stop};

/// Octets an end keeps for its owner at most. When more arrive, the oldest are lost, as in a full receive buffer.
pub(crate) const QUEUE_LEN: usize = 4096;

/// How long a sleeping end takes at most to notice a stop request.
const STOP_LATENCY: Duration = Duration::from_millis(10);

/// A line with any number of ends. Each end hears every octet the others send, in one order.
///
/// Octets take no time and never collide. Ends can be used from one thread or from several.
#[derive(Clone, Debug, Default)]
pub struct Wire {
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    inboxes: Mutex<Vec<Inbox>>,
    arrived: Condvar,
}

/// What one end has not read yet.
#[derive(Debug)]
struct Inbox {
    end: u64,
    octets: VecDeque<u8>,
    lost: u64,
}

impl Wire {
    /// A line without ends.
    pub fn new() -> Self {
        Self::default()
    }

    /// A new end. It hears what is sent from now on, and is disconnected when dropped.
    pub fn end(&self) -> End {
        let mut inboxes = self.shared.lock();
        let end = inboxes.iter().map(|inbox| inbox.end).max().map_or(0, |newest| newest + 1);
        inboxes.push(Inbox { end, octets: VecDeque::new(), lost: 0 });
        drop(inboxes);
        End { shared: Arc::clone(&self.shared), end }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Vec<Inbox>> {
        // No call here panics halfway through a change: a poisoned lock guards whole data.
        self.inboxes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// One end of a [`Wire`].
#[derive(Debug)]
pub struct End {
    shared: Arc<Shared>,
    end: u64,
}

impl End {
    /// How many octets for this end were lost because nobody read it.
    pub fn lost(&self) -> u64 {
        self.with_inbox(|inbox| inbox.lost)
    }

    fn with_inbox<T: Default>(&self, look: impl FnOnce(&mut Inbox) -> T) -> T {
        self.shared.lock().iter_mut().find(|inbox| inbox.end == self.end).map(look).unwrap_or_default()
    }
}

impl Link for End {
    fn receive(&mut self, buf: &mut [u8]) -> io::Result<Received> {
        let count = self.with_inbox(|inbox| {
            let count = buf.len().min(inbox.octets.len());
            for (to, octet) in buf.iter_mut().zip(inbox.octets.drain(..count)) {
                *to = octet;
            }
            count
        });
        Ok(if count == 0 { Received::Nothing } else { Received::Octets(count) })
    }

    fn send(&mut self, telegram: &[u8]) -> io::Result<()> {
        for inbox in self.shared.lock().iter_mut().filter(|inbox| inbox.end != self.end) {
            inbox.octets.extend(telegram);
            let excess = inbox.octets.len().saturating_sub(QUEUE_LEN);
            inbox.octets.drain(..excess);
            inbox.lost += excess as u64;
        }
        self.shared.arrived.notify_all();
        Ok(())
    }

    /// See [`Link::wait`]. Only another thread can end this sleep with octets.
    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        let asleep = Instant::now();
        let mut inboxes = self.shared.lock();
        loop {
            let silent = inboxes.iter().any(|inbox| inbox.end == self.end && inbox.octets.is_empty());
            let left = timeout.map_or(STOP_LATENCY, |timeout| timeout.saturating_sub(asleep.elapsed()));
            if !silent || left.is_zero() || stop.is_requested() {
                return Ok(());
            }
            let slept = self.shared.arrived.wait_timeout(inboxes, left.min(STOP_LATENCY));
            (inboxes, _) = slept.unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl Drop for End {
    fn drop(&mut self) {
        self.shared.lock().retain(|inbox| inbox.end != self.end);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(end: &mut End) -> Vec<u8> {
        let mut buf = [0xA5; QUEUE_LEN + 1];
        match end.receive(&mut buf).unwrap() {
            Received::Octets(count) => buf[..count].to_vec(),
            Received::BrokenOff(_) | Received::Reset | Received::Rate(_) | Received::Nothing => Vec::new(),
        }
    }

    #[test]
    fn every_end_hears_the_others_and_not_itself() {
        let wire = Wire::new();
        let (mut a, mut b, mut c) = (wire.end(), wire.end(), wire.end());
        a.send(&[1, 2]).unwrap();
        b.send(&[3]).unwrap();
        assert_eq!(heard(&mut a), [3]);
        assert_eq!(heard(&mut b), [1, 2]);
        assert_eq!(heard(&mut c), [1, 2, 3]);
        assert_eq!(heard(&mut c), [0; 0]);
    }

    #[test]
    fn a_short_buffer_takes_octets_in_order_and_leaves_the_rest() {
        let wire = Wire::new();
        let (mut a, mut b) = (wire.end(), wire.end());
        a.send(&[1, 2, 3]).unwrap();
        let mut buf = [0; 2];
        assert_eq!(b.receive(&mut buf).unwrap(), Received::Octets(2));
        assert_eq!(buf, [1, 2]);
        assert_eq!(heard(&mut b), [3]);
    }

    #[test]
    fn an_end_that_is_never_read_loses_the_oldest_octets_and_counts_them() {
        let wire = Wire::new();
        let (mut a, mut b) = (wire.end(), wire.end());
        for _ in 0..QUEUE_LEN {
            a.send(&[0]).unwrap();
        }
        a.send(&[7, 8, 9]).unwrap();
        assert_eq!(b.lost(), 3);
        let octets = heard(&mut b);
        assert_eq!(octets.len(), QUEUE_LEN);
        assert_eq!(octets[QUEUE_LEN - 4..], [0, 7, 8, 9]);
        assert_eq!(a.lost(), 0);
    }

    #[test]
    fn a_dropped_end_keeps_nothing_and_a_new_end_starts_empty() {
        let wire = Wire::new();
        let (mut a, b) = (wire.end(), wire.end());
        drop(b);
        a.send(&[1]).unwrap();
        assert_eq!(heard(&mut wire.end()), [0; 0]);
        assert_eq!(wire.shared.lock().len(), 1);
    }

    #[test]
    fn another_thread_ends_a_sleep_with_octets_or_with_a_stop_request() {
        let wire = Wire::new();
        let (mut a, mut b) = (wire.end(), wire.end());
        let stop = Stop::new().unwrap();
        std::thread::scope(|scope| {
            scope.spawn(|| a.send(&[1]).unwrap());
            b.wait(None, &stop).unwrap();
        });
        assert_eq!(heard(&mut b), [1]);
        std::thread::scope(|scope| {
            scope.spawn(|| stop.request());
            b.wait(None, &stop).unwrap();
        });
        assert!(stop.is_requested());
    }
}
