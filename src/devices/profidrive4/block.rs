//! Traversing blocks: what the drive does by itself, block after block.

/// How many blocks there are.
pub(crate) const BLOCKS: usize = 64;

/// A traversing block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Block {
    /// Its number, -1: there is none.
    pub(crate) number: i32,
    /// LU.
    pub(crate) position: i32,
    /// 1000 LU/min.
    pub(crate) velocity: i32,
    /// Percent of the most.
    pub(crate) acceleration: i32,
    /// Percent of the most.
    pub(crate) deceleration: i32,
    pub(crate) task: i32,
    pub(crate) parameter: i32,
    /// Continuation in bits 4 to 7, the way to the position in bits 8 to 11.
    pub(crate) mode: i32,
}

macro_rules! fields {
    ($($field:ident = $pnu:literal: $place:ident, $name:literal, $unit:literal, $low:literal, $high:literal, $first:literal;)*) => {
        /// A field of the blocks, an array of 64 each.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum BlockField {
            $($field,)*
        }

        impl BlockField {
            pub(crate) const ALL: &'static [Self] = &[$(Self::$field),*];

            /// The number of its parameter.
            pub(crate) const fn pnu(self) -> u16 {
                match self { $(Self::$field => $pnu,)* }
            }

            pub(crate) const fn name(self) -> &'static str {
                match self { $(Self::$field => $name,)* }
            }

            pub(crate) const fn unit(self) -> &'static str {
                match self { $(Self::$field => $unit,)* }
            }

            pub(crate) const fn limits(self) -> (f64, f64) {
                match self { $(Self::$field => ($low, $high),)* }
            }
        }

        impl Block {
            /// There is none.
            pub(crate) const NONE: Self = Self { $($place: $first,)* };

            pub(crate) const fn of(&self, field: BlockField) -> i32 {
                match field { $(BlockField::$field => self.$place,)* }
            }

            pub(crate) const fn set(&mut self, field: BlockField, value: i32) {
                match field { $(BlockField::$field => self.$place = value,)* }
            }
        }
    };
}

fields! {
    Number = 2616: number, "Block number", "", -1.0, 63.0, -1;
    Position = 2617: position, "Block position", "LU", -2_147_482_648.0, 2_147_482_647.0, 0;
    Velocity = 2618: velocity, "Block velocity", "1000 LU/min", 1.0, 40_000_000.0, 600;
    Acceleration = 2619: acceleration, "Block acceleration", "%", 1.0, 100.0, 100;
    Deceleration = 2620: deceleration, "Block deceleration", "%", 1.0, 100.0, 100;
    Task = 2621: task, "Block task", "", 1.0, 9.0, 1;
    Parameter = 2622: parameter, "Block parameter", "", -2_147_483_648.0, 2_147_483_647.0, 0;
    Mode = 2623: mode, "Block mode", "", 0.0, 65535.0, 0;
}

/// What a block does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BlockTask {
    /// Go to its position.
    Position { relative: bool },
    /// Go on and on.
    Endless { forward: bool },
    /// Wait so many ms.
    Wait { millis: u32 },
    /// Go on with another block.
    GoTo { number: i32 },
    /// Set or reset outputs, bit 0 for the first.
    Output { bits: u8, on: bool },
    /// What this drive does not do: travel to a fixed stop, jerk limitation.
    Unknown,
}

/// What follows a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Continuation {
    End,
    /// The next block, from rest.
    WithStop,
    /// The next block, without stopping.
    Flying,
    /// The next block when the master says so, at the position at the latest.
    External,
    /// The same; at the position the drive waits for it.
    ExternalWait,
    /// The same; at the position it must have been said.
    ExternalAlarm,
}

impl Block {
    pub(crate) const fn what(&self) -> BlockTask {
        let relative = self.mode >> 8 & 0xF == 1;
        match self.task {
            1 => BlockTask::Position { relative },
            3 => BlockTask::Endless { forward: true },
            4 => BlockTask::Endless { forward: false },
            5 => BlockTask::Wait {
                millis: if self.parameter > 0 { self.parameter.cast_unsigned() } else { 0 },
            },
            6 => BlockTask::GoTo { number: self.parameter },
            7 | 8 => BlockTask::Output { bits: self.outputs(), on: self.task == 7 },
            _ => BlockTask::Unknown,
        }
    }

    /// The outputs that its parameter names, bit 0 for the first.
    const fn outputs(&self) -> u8 {
        match self.parameter & 3 {
            1 => 1,
            2 => 2,
            3 => 3,
            _ => 0,
        }
    }

    pub(crate) const fn then(&self) -> Continuation {
        match self.mode >> 4 & 0xF {
            1 => Continuation::WithStop,
            2 => Continuation::Flying,
            3 => Continuation::External,
            4 => Continuation::ExternalWait,
            5 => Continuation::ExternalAlarm,
            _ => Continuation::End,
        }
    }
}

/// The blocks of a drive.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Blocks(pub(crate) [Block; BLOCKS]);

impl Default for Blocks {
    fn default() -> Self {
        Self([Block::NONE; BLOCKS])
    }
}

impl Blocks {
    /// The block of this number.
    pub(crate) fn numbered(&self, number: i32) -> Option<&Block> {
        self.0.iter().find(|block| block.number == number && number >= 0)
    }

    /// The block with the next number.
    pub(crate) fn after(&self, number: i32) -> Option<&Block> {
        self.0.iter().filter(|block| block.number > number).min_by_key(|block| block.number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_follow_by_their_numbers_and_say_what_they_do() {
        let mut blocks = Blocks::default();
        for (place, number) in [(0, 5), (1, 2), (2, 9)] {
            blocks.0[place].number = number;
        }
        assert_eq!(blocks.after(2).map(|block| block.number), Some(5));
        assert_eq!((blocks.after(9), blocks.numbered(3), blocks.numbered(-1)), (None, None, None));
        let mut block = Block::NONE;
        block.set(BlockField::Mode, 0x0110);
        assert_eq!(
            (block.what(), block.then()),
            (BlockTask::Position { relative: true }, Continuation::WithStop)
        );
        block.set(BlockField::Task, 7);
        block.set(BlockField::Parameter, 3);
        assert_eq!(block.what(), BlockTask::Output { bits: 3, on: true });
        assert_eq!(
            BlockField::ALL.iter().map(|field| block.of(*field)).collect::<Vec<_>>(),
            [-1, 0, 600, 100, 100, 7, 3, 0x110]
        );
    }
}
