//! Digital inputs and outputs of CiA 401: 1024 lines of each, whichever objects show them.
//!
//! ```text
//! terminal ─▶ filter 6003h ─▶ polarity 6002h ─▶ 6000h ─▶ masks 6006h, 6007h, 6008h ─▶ 6005h ─▶ event
//! 6200h ─▶ filter mask 6208h ─▶ polarity 6202h ─▶ error mode 6206h, error value 6207h ─▶ terminal
//! ```

use core::time::Duration;

use crate::can_bus::canopen::Address;
use crate::can_bus::canopen::value::DataType;
use crate::time::Instant;

/// Words of a bank.
const WORDS: usize = 16;
/// A filtered input has a new level when it has stood for so long.
pub(super) const FILTER_TIME: Duration = Duration::from_millis(10);

/// What an object says of its lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum What {
    /// 6000h.
    Input,
    /// 6002h.
    InputPolarity,
    /// 6003h.
    InputFilter,
    /// 6006h.
    AnyChange,
    /// 6007h.
    Rising,
    /// 6008h.
    Falling,
    /// 6200h.
    Output,
    /// 6202h.
    OutputPolarity,
    /// 6206h.
    ErrorMode,
    /// 6207h.
    ErrorValue,
    /// 6208h.
    OutputFilter,
}

const KINDS: usize = What::OutputFilter as usize + 1;

/// The lines of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Block {
    pub(crate) what: What,
    first: usize,
    count: u32,
}

impl Block {
    /// That of an entry: objects of 8, 16 and 32 lines in an entry, and of one.
    pub(super) fn of(at: Address, data: DataType) -> Option<Self> {
        let (index, sub) = at.pair();
        let number = usize::from(sub.checked_sub(1)?);
        let (what, count, first) = match index {
            0x6020..=0x6027 => (What::Input, 1, index - 0x6020),
            0x6030..=0x6037 => (What::InputPolarity, 1, index - 0x6030),
            0x6038..=0x603F => (What::InputFilter, 1, index - 0x6038),
            0x6050..=0x6057 => (What::AnyChange, 1, index - 0x6050),
            0x6060..=0x6067 => (What::Rising, 1, index - 0x6060),
            0x6070..=0x6077 => (What::Falling, 1, index - 0x6070),
            0x6220..=0x6227 => (What::Output, 1, index - 0x6220),
            0x6240..=0x6247 => (What::OutputPolarity, 1, index - 0x6240),
            0x6250..=0x6257 => (What::ErrorMode, 1, index - 0x6250),
            0x6260..=0x6267 => (What::ErrorValue, 1, index - 0x6260),
            0x6270..=0x6277 => (What::OutputFilter, 1, index - 0x6270),
            0x6000..=0x6008 => (input(index - 0x6000)?, 8, 0),
            0x6100..=0x6108 => (input(index - 0x6100)?, 16, 0),
            0x6120..=0x6128 => (input(index - 0x6120)?, 32, 0),
            0x6200..=0x6208 => (output(index - 0x6200)?, 8, 0),
            0x6300..=0x6308 => (output(index - 0x6300)?, 16, 0),
            0x6320..=0x6328 => (output(index - 0x6320)?, 32, 0),
            _ => return None,
        };
        let bits = if data == DataType::Boolean { 1 } else { data.octets()? * 8 };
        let first = usize::from(first) * 128 + number * bits;
        let is_there =
            u32::try_from(bits) == Ok(count) && first + bits <= WORDS * 64 && data.kind().is_whole();
        is_there.then_some(Self { what, first, count })
    }

    const fn mask(self) -> u64 {
        (1 << self.count) - 1
    }
}

const fn input(place: u16) -> Option<What> {
    Some(match place {
        0 => What::Input,
        2 => What::InputPolarity,
        3 => What::InputFilter,
        6 => What::AnyChange,
        7 => What::Rising,
        8 => What::Falling,
        _ => return None,
    })
}

const fn output(place: u16) -> Option<What> {
    Some(match place {
        0 => What::Output,
        2 => What::OutputPolarity,
        6 => What::ErrorMode,
        7 => What::ErrorValue,
        8 => What::OutputFilter,
        _ => return None,
    })
}

/// One bit for each line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Bank([u64; WORDS]);

impl Bank {
    pub(super) const LOW: Self = Self([0; WORDS]);
    const HIGH: Self = Self([u64::MAX; WORDS]);

    /// The lines of an entry, the first one as bit 0. Entries begin at a multiple of their length, so none is in two words.
    pub(super) fn of(&self, block: Block) -> u64 {
        let word = self.0.get(block.first / 64).copied().unwrap_or_default();
        word >> (block.first % 64) & block.mask()
    }

    fn set(&mut self, block: Block, lines: u64) {
        if let Some(word) = self.0.get_mut(block.first / 64) {
            let place = block.first % 64;
            *word = *word & !(block.mask() << place) | (lines & block.mask()) << place;
        }
    }

    fn combine<const N: usize>(banks: [&Self; N], of: impl Fn([u64; N]) -> u64) -> Self {
        Self(core::array::from_fn(|word| of(banks.map(|bank| bank.0.get(word).copied().unwrap_or_default()))))
    }
}

/// The lines of a device.
#[derive(Clone, Debug)]
pub(super) struct Lines {
    /// What the objects say, by [`What`].
    said: [Bank; KINDS],
    /// 6005h.
    pub(super) events_on: bool,
    /// Levels at the terminals of the inputs.
    levels: Bank,
    /// Those behind the filter.
    steady: Bank,
    filter_ends: Option<Instant>,
    /// Outputs that have their error value at the terminal, whatever their polarity is.
    failed: Bank,
}

impl Lines {
    pub(super) const fn new() -> Self {
        Self {
            said: [Bank::LOW; KINDS],
            events_on: true,
            levels: Bank::LOW,
            steady: Bank::LOW,
            filter_ends: None,
            failed: Bank::LOW,
        }
    }

    fn bank(&self, what: What) -> &Bank {
        self.said.get(what as usize).unwrap_or(&Bank::LOW)
    }

    fn bank_mut(&mut self, what: What) -> Option<&mut Bank> {
        self.said.get_mut(what as usize)
    }

    /// What an object reads.
    pub(super) fn read(&self, block: Block) -> u64 {
        self.bank(block.what).of(block)
    }

    /// Power-on and reset: everything is as objects that are not there would say. The terminals of inputs stay.
    pub(super) fn restart(&mut self, has: impl Fn(What) -> bool) {
        self.said = [Bank::LOW; KINDS];
        self.events_on = true;
        self.failed = Bank::LOW;
        let by_edges = has(What::Rising) || has(What::Falling);
        for what in [What::AnyChange, What::OutputFilter] {
            let is_high = what == What::OutputFilter || !by_edges;
            if let (true, Some(bank)) = (is_high, self.bank_mut(what)) {
                *bank = Bank::HIGH;
            }
        }
    }

    /// Takes the value of an object over, without events.
    pub(super) fn load(&mut self, block: Block, lines: u64) {
        if let Some(bank) = self.bank_mut(block.what) {
            bank.set(block, lines);
        }
        self.steady = self.levels;
        self.filter_ends = None;
        self.show();
    }

    /// A master writes an object. Says which inputs have an event.
    pub(super) fn write(&mut self, block: Block, lines: u64) -> Bank {
        let mask = self.bank(What::OutputFilter).of(block);
        let before = self.read(block);
        let is_output = block.what == What::Output;
        let lines = if is_output { before & !mask | lines & mask } else { lines };
        if let Some(bank) = self.bank_mut(block.what) {
            bank.set(block, lines);
        }
        if is_output {
            let failed = self.failed.of(block) & !mask;
            self.failed.set(block, failed);
        }
        self.show()
    }

    /// Levels at the terminals of the inputs of an entry.
    pub(super) fn levels(&self, block: Block) -> u64 {
        self.levels.of(block)
    }

    /// Changes them. Says which inputs have an event.
    pub(super) fn set_levels(&mut self, now: Instant, block: Block, levels: u64) -> Bank {
        if self.levels.of(block) == levels & block.mask() {
            return Bank::LOW;
        }
        self.levels.set(block, levels);
        let filter = *self.bank(What::InputFilter);
        let through = |[new, old, filter]: [u64; 3]| new & !filter | old & filter;
        self.steady = Bank::combine([&self.levels, &self.steady, &filter], through);
        self.filter_ends = (self.steady != self.levels).then(|| now.saturating_add(FILTER_TIME));
        self.show()
    }

    pub(super) const fn due(&self) -> Option<Instant> {
        self.filter_ends
    }

    /// Filtered levels that have stood long enough. Says which inputs have an event.
    pub(super) fn advance(&mut self, now: Instant) -> Bank {
        if self.filter_ends.is_none_or(|due| due > now) {
            return Bank::LOW;
        }
        self.filter_ends = None;
        self.steady = self.levels;
        self.show()
    }

    /// Brings 6000h up to date. Says which inputs have an event.
    fn show(&mut self) -> Bank {
        let before = *self.bank(What::Input);
        let value = Bank::combine([&self.steady, self.bank(What::InputPolarity)], |[level, polarity]| {
            level ^ polarity
        });
        if let Some(bank) = self.bank_mut(What::Input) {
            *bank = value;
        }
        if !self.events_on || value == before {
            return Bank::LOW;
        }
        let masks = [What::AnyChange, What::Rising, What::Falling].map(|what| self.bank(what));
        let [any, rising, falling] = masks;
        Bank::combine([&before, &value, any, rising, falling], |[old, new, any, rising, falling]| {
            (old ^ new) & any | new & !old & rising | old & !new & falling
        })
    }

    /// The device fails or is stopped: outputs go to their error value where 6206h says so.
    pub(super) fn fail(&mut self) {
        let mode = *self.bank(What::ErrorMode);
        let to = |[out, mode, value]: [u64; 3]| out & !mode | value & mode;
        let outputs = Bank::combine([self.bank(What::Output), &mode, self.bank(What::ErrorValue)], to);
        if let Some(bank) = self.bank_mut(What::Output) {
            *bank = outputs;
        }
        self.failed = Bank::combine([&self.failed, &mode], |[failed, mode]| failed | mode);
    }

    /// Levels at the terminals of the outputs of an entry.
    pub(super) fn terminals(&self, block: Block) -> u64 {
        let (outputs, polarity) = (self.read(block), self.bank(What::OutputPolarity).of(block));
        outputs ^ polarity & !self.failed.of(block)
    }
}
