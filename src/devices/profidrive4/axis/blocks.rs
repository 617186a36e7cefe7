//! Blocks of an axis: which one begins, what it does, and which follows.

use super::{Activity, MOST_AT_ONCE, Origin};
use crate::devices::profidrive4::block::{Block, BlockTask, Continuation};
use crate::devices::profidrive4::{Drive, Event, Fault};

impl Drive {
    pub(super) fn begin_block(&mut self, number: i32) {
        let mut next = self.blocks.numbered(number).copied();
        for _ in 0..MOST_AT_ONCE {
            let Some(block) = next else {
                self.tell(Event::NoBlock { number });
                self.give_up();
                return;
            };
            next = self.do_block(&block);
            if next.is_none() {
                return;
            }
        }
        self.tell(Event::NoBlock { number });
        self.give_up();
    }

    /// Begins a block; one without motion is followed by the one that is returned.
    fn do_block(&mut self, block: &Block) -> Option<Block> {
        let by = u8::try_from(block.number).unwrap_or_default();
        let part = |percent: i32| f64::from(percent) / 100.0;
        let ramp = self.ramp(block.velocity.into(), part(block.acceleration), part(block.deceleration));
        match block.what() {
            BlockTask::Position { relative } => {
                let way = f64::from(block.position);
                let target =
                    if relative { self.demand.position + way * self.unit() } else { self.place(way) };
                self.travel(Origin::Block(by), target, ramp, true);
                None
            }
            BlockTask::Endless { forward } => {
                let velocity = if forward { ramp.velocity } else { -ramp.velocity };
                let by = Origin::Block(by);
                (self.axis.activity, self.axis.target) = (Activity::Endless { by, velocity, ramp }, None);
                self.axis.accepted = true;
                None
            }
            BlockTask::Wait { millis } => {
                self.axis.activity = Activity::Waiting { number: by, left: millis };
                self.axis.accepted = true;
                None
            }
            BlockTask::GoTo { number } => match self.blocks.numbered(number) {
                Some(block) => Some(*block),
                None => {
                    self.tell(Event::NoBlock { number });
                    self.give_up();
                    None
                }
            },
            BlockTask::Output { bits, on } => {
                let outputs = self.axis.outputs;
                self.axis.outputs = if on { outputs | bits } else { outputs & !bits };
                self.axis.accepted = true;
                self.following(block)
            }
            BlockTask::Unknown => {
                self.raise(Fault::Block, block.number);
                None
            }
        }
    }

    /// The block that follows one that is done; none at the end.
    fn following(&mut self, block: &Block) -> Option<Block> {
        let next = self.blocks.after(block.number).copied();
        match block.then() {
            Continuation::End => self.axis.activity = Activity::Idle,
            Continuation::WithStop | Continuation::Flying | Continuation::External => {
                if next.is_none() {
                    self.axis.activity = Activity::Idle;
                }
                return next;
            }
            Continuation::ExternalWait => {
                let number = u8::try_from(block.number).unwrap_or_default();
                self.axis.activity = Activity::Held { number };
            }
            Continuation::ExternalAlarm => {
                self.axis.activity = Activity::Idle;
                self.tell(Event::NoChange { number: block.number });
            }
        }
        None
    }

    /// The block of this number is done.
    pub(super) fn block_done(&mut self, number: u8) {
        let Some(block) = self.blocks.numbered(number.into()).copied() else {
            self.axis.activity = Activity::Idle;
            return;
        };
        if let Some(next) = self.following(&block) {
            self.begin_block(next.number);
        }
    }

    /// STW1 bit 13: the next block now.
    pub(super) fn change_block(&mut self) {
        let (number, is_held) = match self.axis.activity {
            Activity::Travel { by: Origin::Block(number), .. }
            | Activity::Endless { by: Origin::Block(number), .. } => (number, false),
            Activity::Held { number } => (number, true),
            Activity::Idle
            | Activity::Travel { .. }
            | Activity::Endless { .. }
            | Activity::Homing(_)
            | Activity::Waiting { .. } => return,
        };
        let then = self.blocks.numbered(number.into()).map(Block::then);
        let takes = matches!(
            then,
            Some(Continuation::External | Continuation::ExternalWait | Continuation::ExternalAlarm)
        );
        if takes || is_held {
            match self.blocks.after(number.into()).map(|block| block.number) {
                Some(next) => self.begin_block(next),
                None => self.give_up(),
            }
        }
    }
}
