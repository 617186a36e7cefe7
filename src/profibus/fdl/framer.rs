//! A stream of octets, cut anywhere, into telegrams; and the rule for finding back after noise.
//!
//! What ends a telegram is said once, in [`decode`]; three callers cut with it, because each keeps something else. This
//! one is for stations: it drops noise, copies nothing that came whole, and needs no allocator.
//! `host::link::pieces` gives back every octet of a sender in order, noise too, for links that pass them on.
//! `explain::Decoder` has no clock and looks for the next telegram whose checksum is right.

use core::time::Duration;

use super::telegram::{Decoded, FrameError, MAX_TELEGRAM_LEN, Telegram, decode, extent};
use crate::time::{BITS_PER_OCTET, BaudRate, Instant, SYN_BITS, nanos};

/// How to find the next telegram after octets that are none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resync {
    /// For a line whose timing can be seen: after an invalid telegram everything is ignored until the line was
    /// idle for T_SYN (33 T_bit), which every request has before it. Nothing inside the data of a damaged
    /// telegram can pose as a telegram.
    Idle(BaudRate),
    /// For a pseudo-terminal, TCP or a USB adapter, where idle time cannot be seen: look again behind the wrong
    /// octet. A telegram that stays unfinished for the given time is given up, and what follows its first octet
    /// is looked at again.
    Scan(Duration),
}

impl Resync {
    /// [`Resync::Scan`] with 50 ms: longer than a scheduler delays the rest of a telegram, shorter than the time
    /// after which a person or a test tries again.
    pub const SCAN: Self = Self::Scan(Duration::from_millis(50));

    /// The silence that ends an unfinished telegram.
    const fn silence(self) -> Duration {
        match self {
            Self::Idle(baud) => baud.bit_times(SYN_BITS),
            Self::Scan(silence) => silence,
        }
    }
}

/// Collects octets until they are telegrams. Takes 255 octets of memory, never more.
#[derive(Clone, Debug)]
pub struct Framer {
    resync: Resync,
    /// In ns, as [`Instant`] counts: on a small processor each [`Duration`] and each bit time is a long division.
    silence: u64,
    /// How long an octet takes on the line, where that is known, in ns.
    octet: u64,
    /// The unfinished telegram.
    octets: [u8; MAX_TELEGRAM_LEN],
    len: usize,
    last_octet: Instant,
    /// [`Resync::Idle`] after an invalid telegram: the line must fall silent first.
    wait_for_idle: bool,
    refused: Refused,
}

/// What the octets that come next still belong to: a damaged telegram is refused once, not octet by octet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Refused {
    /// Nothing: the last octets were a telegram, or the line was silent.
    Nothing,
    /// A refused telegram of which so many octets are still to come; with none left, the noise behind it.
    Telegram(usize),
}

impl Refused {
    /// Notes a refusal at the front of `octets`, of which `skip` are done with. Whether it is news: another start
    /// delimiter behind the end of what was refused before.
    fn note(&mut self, octets: &[u8], skip: usize) -> bool {
        let extent = extent(octets);
        let (rest, is_news) = match *self {
            Self::Nothing => (extent, true),
            Self::Telegram(0) => (extent, extent > 1),
            Self::Telegram(rest) => (rest, false),
        };
        *self = Self::Telegram(rest.saturating_sub(skip));
        is_news
    }
}

impl Framer {
    /// A framer that has heard nothing yet.
    pub const fn new(resync: Resync) -> Self {
        let octet = match resync {
            Resync::Idle(baud) => nanos(baud.bit_times(BITS_PER_OCTET)),
            Resync::Scan(_) => 0,
        };
        Self {
            resync,
            silence: nanos(resync.silence()),
            octet,
            octets: [0; MAX_TELEGRAM_LEN],
            len: 0,
            last_octet: Instant::ZERO,
            wait_for_idle: false,
            refused: Refused::Nothing,
        }
    }

    /// Takes `octets`, the last of which ended at `now`, and hands over each telegram and each refusal in order,
    /// with the time its last octet was heard. A damaged telegram is one refusal, and so are octets without a start
    /// delimiter that follow each other. Telegrams that lie whole in `octets` are not copied.
    pub fn handle_bytes(
        &mut self,
        now: Instant,
        octets: &[u8],
        mut sink: impl FnMut(Instant, Result<Telegram<'_>, FrameError>),
    ) {
        // Nearly always octets are one telegram and nothing is left of what was before.
        if self.is_clear()
            && let Decoded::Telegram { telegram, len } = decode(octets)
            && len == octets.len()
        {
            // `last_octet` is of no use while nothing is unfinished.
            return sink(now, Ok(telegram));
        }
        self.handle_pieces(now, octets, &mut sink);
    }

    /// As [`Framer::handle_bytes`], for octets that may be anything.
    #[inline(never)]
    fn handle_pieces(
        &mut self,
        now: Instant,
        octets: &[u8],
        sink: &mut impl FnMut(Instant, Result<Telegram<'_>, FrameError>),
    ) {
        self.hear_silence(now, octets.len(), sink);
        if octets.is_empty() {
            return;
        }
        self.last_octet = now;
        if self.wait_for_idle {
            return;
        }
        let mut octets = octets;
        while self.len > 0 && !octets.is_empty() {
            octets = self.append(octets);
            self.cut_buffer(now, sink);
            if self.wait_for_idle {
                return;
            }
        }
        let Cut { rest, wait_for_idle } = cut(self.resync, now, octets, &mut self.refused, sink);
        self.wait_for_idle = wait_for_idle;
        self.append(rest);
    }

    /// An octet that ended at `now` had a wrong parity or stop bit: no telegram holds it (`dp-v0.md` 1).
    ///
    /// Under [`Resync::Idle`] the line must fall silent before the next telegram; under [`Resync::Scan`] the next
    /// octet may begin one.
    pub fn handle_damaged(
        &mut self,
        now: Instant,
        mut sink: impl FnMut(Instant, Result<Telegram<'_>, FrameError>),
    ) {
        self.hear_silence(now, 1, &mut sink);
        self.last_octet = now;
        if !self.wait_for_idle {
            self.len = 0;
            match self.resync {
                Resync::Scan(_) => self.refused = Refused::Telegram(0),
                Resync::Idle(_) => self.wait_for_idle = true,
            }
            sink(now, Err(FrameError::Parity));
        }
    }

    /// Time has passed without octets: gives up an unfinished telegram whose time is over.
    pub fn handle_timeout(
        &mut self,
        now: Instant,
        mut sink: impl FnMut(Instant, Result<Telegram<'_>, FrameError>),
    ) {
        if !self.is_clear() {
            self.hear_silence(now, 0, &mut sink);
        }
    }

    /// When to call [`Framer::handle_timeout`]. Changes with every call that takes octets or time.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        (self.len > 0).then(|| Instant::from_nanos(self.last_octet.as_nanos().saturating_add(self.silence)))
    }

    /// Forgets an unfinished telegram: the other end of the line has changed.
    pub(crate) fn clear(&mut self) {
        self.len = 0;
        self.wait_for_idle = false;
        self.refused = Refused::Nothing;
    }

    /// Nothing is unfinished, and nothing refused or ignored lasts: silence ends nothing, the next octet begins a
    /// telegram.
    fn is_clear(&self) -> bool {
        self.len == 0 && !self.wait_for_idle && self.refused == Refused::Nothing
    }

    /// Ends what the silence before the newest `arrived` octets ends.
    #[inline(never)]
    fn hear_silence(
        &mut self,
        now: Instant,
        arrived: usize,
        sink: &mut impl FnMut(Instant, Result<Telegram<'_>, FrameError>),
    ) {
        if self.is_clear() {
            return;
        }
        let passed = now.as_nanos().saturating_sub(self.last_octet.as_nanos());
        match self.resync {
            Resync::Idle(_) => {
                let arrived = u64::try_from(arrived).unwrap_or(u64::MAX);
                let silence = passed.saturating_sub(arrived.saturating_mul(self.octet));
                if silence >= self.silence {
                    self.wait_for_idle = false;
                    if self.len > 0 {
                        let error = broken_off(self.octets.get(..self.len).unwrap_or_default());
                        self.len = 0;
                        sink(self.last_octet, Err(error));
                    }
                }
            }
            Resync::Scan(_) => {
                if passed < self.silence {
                    return;
                }
                while self.len > 0 {
                    let held = self.octets.get(..self.len).unwrap_or_default();
                    if self.refused.note(held, 1) {
                        sink(self.last_octet, Err(broken_off(held)));
                    }
                    self.drop_front(1);
                    self.cut_buffer(self.last_octet, sink);
                }
                self.refused = Refused::Nothing;
            }
        }
    }

    /// Hands over everything that is whole at the front of the buffer.
    fn cut_buffer(&mut self, at: Instant, sink: &mut impl FnMut(Instant, Result<Telegram<'_>, FrameError>)) {
        let held = self.octets.get(..self.len).unwrap_or_default();
        let Cut { rest, wait_for_idle } = cut(self.resync, at, held, &mut self.refused, sink);
        let used = self.len - rest.len();
        self.wait_for_idle = wait_for_idle;
        self.drop_front(used);
    }

    /// Appends as many octets as there is room for and returns the others.
    fn append<'a>(&mut self, octets: &'a [u8]) -> &'a [u8] {
        let room = self.octets.get_mut(self.len..).unwrap_or_default();
        let (taken, rest) = octets.split_at(octets.len().min(room.len()));
        if let Some(room) = room.get_mut(..taken.len()) {
            room.copy_from_slice(taken);
        }
        self.len += taken.len();
        rest
    }

    fn drop_front(&mut self, octets: usize) {
        // Nearly always: an octet that does not end its telegram.
        if octets == 0 {
            return;
        }
        let Some(held) = self.octets.get_mut(..self.len) else { return };
        let octets = octets.min(held.len());
        held.copy_within(octets.., 0);
        self.len -= octets;
    }
}

fn broken_off(octets: &[u8]) -> FrameError {
    FrameError::BrokenOff { octets: u8::try_from(octets.len()).unwrap_or(u8::MAX) }
}

/// What is left after cutting.
struct Cut<'a> {
    /// The beginning of an unfinished telegram.
    rest: &'a [u8],
    /// An invalid telegram was met and silence must follow.
    wait_for_idle: bool,
}

/// Hands over everything that is whole at the front of `octets`.
fn cut<'a>(
    resync: Resync,
    at: Instant,
    mut octets: &'a [u8],
    refused: &mut Refused,
    sink: &mut impl FnMut(Instant, Result<Telegram<'_>, FrameError>),
) -> Cut<'a> {
    while !octets.is_empty() {
        let used = match decode(octets) {
            Decoded::Incomplete => break,
            Decoded::Telegram { telegram, len } => {
                *refused = Refused::Nothing;
                sink(at, Ok(telegram));
                len
            }
            Decoded::Invalid { error, skip } => match resync {
                Resync::Scan(_) => {
                    if refused.note(octets, skip) {
                        sink(at, Err(error));
                    }
                    skip
                }
                Resync::Idle(_) => {
                    sink(at, Err(error));
                    return Cut { rest: &[], wait_for_idle: true };
                }
            },
        };
        octets = octets.get(used..).unwrap_or_default();
    }
    Cut { rest: octets, wait_for_idle: false }
}

/// What can be known of the time of octets on a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timing {
    /// Octets come when they come on the line: a simulated line or a UART. After noise the line must fall
    /// silent ([`Resync::Idle`]), and a reply is dropped once max T_SDR is over.
    True,
    /// Octets come when a scheduler delivers them: pseudo-terminal, TCP, USB adapter. Noise is skipped
    /// ([`Resync::SCAN`]), and a reply is sent however late, because the master's patience is set for such links.
    Untrue,
}

impl Timing {
    /// The rule for finding the next telegram on a line at `baud`.
    pub const fn resync(self, baud: BaudRate) -> Resync {
        match self {
            Self::True => Resync::Idle(baud),
            Self::Untrue => Resync::SCAN,
        }
    }
}

#[cfg(test)]
mod tests;
