//! `profidrive demo`: profirust's DP master and an emulated drive on a bus in memory, explained step by step.
//!
//! A story is data in the folder of its device ([`SlaveAct`](crate::devices::story::SlaveAct)); here is the stage that it
//! is played on. What octets and bits mean is known to `crate::explain`.
//!
//! | file | holds |
//! | --- | --- |
//! | `stage` | PROFIBUS: what happens in a story there |
//! | `nodes` | the stories of the devices on CANopen |
//! | `node_stage` | CANopen: what happens in those |
//! | `page` | the words on the page |
//! | `chart` | a travel as a picture |

mod chart;
mod node_stage;
mod nodes;
mod page;
mod stage;

use std::io::{self, BufWriter, Write};

use crate::host::list::{DEVICES, Device};

use super::Failure;
use super::args::Demo;
use page::Trouble;
use stage::Stage;

/// Plays the demo to stdout. Nobody need read it to the end.
pub(super) fn demo(args: &Demo) -> Result<(), Failure> {
    let mut out = BufWriter::new(io::stdout().lock());
    let played = match args.device {
        Some(product) => nodes::play(product, &mut out),
        None => play(&mut out),
    };
    // What was seen before something went wrong belongs to the story.
    let written = out.flush();
    match played.and(written.map_err(Trouble::Out)) {
        Ok(()) => Ok(()),
        Err(Trouble::Out(error)) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        Err(Trouble::Out(error)) => Err(Failure::Other(format!("cannot write to stdout: {error}"))),
        Err(Trouble::Unexpected(line)) => Err(Failure::Other(line)),
    }
}

/// The usual device with a story on PROFIBUS.
fn play(out: &mut dyn Write) -> Result<(), Trouble> {
    for device in DEVICES {
        if let Device::Slave(slave) = device
            && !slave.story.is_empty()
        {
            let mut stage = Stage::open(device, out)?;
            slave.story.iter().try_for_each(|act| stage.play(act))?;
            stage.page.title("That is all")?;
            return stage.page.text(
                "The same drive on a terminal that any PROFIBUS-DP master can open: profidrive emulate. \
                 Everything about it: profidrive emulate --help.",
            );
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn story() -> String {
        let mut out = Vec::new();
        play(&mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn the_story_is_told_to_its_end_on_a_page_of_80_columns() {
        let story = story();
        assert!(story.lines().all(|line| line.chars().count() <= 80), "{story}");
        assert!(!story.contains('\u{1b}'), "plain text");
        let mut rest = &story[..];
        for part in [
            "Slave_Diag request",
            "68 0C 0C 68 85 82 5C 3D 3E B8 01 14 0B 0A C5 00",
            "Chk_Cfg: 14 octets of outputs and 14 of inputs",
            "diagnosis: ready for data",
            "13FA 0000 0000 0000",
            "23FA 0000 0000 2710",
            "33F8 0000 0003 D090",
            "23F8 0000 0003 D090",
            "error 2, value outside the limits",
            "enabled, ready to travel",
            "job accepted",
            "^start",
            "^there",
            "setpoint is above the upper",
            "fault F (internal error)",
            "turn-on disabled",
            "disable operation",
            "ready to turn on",
        ] {
            let found = rest.find(part).unwrap_or_else(|| panic!("no '{part}' in\n{rest}"));
            rest = &rest[found..];
        }
    }

    #[test]
    fn the_story_is_always_the_same() {
        assert_eq!(story(), story());
    }

    #[test]
    fn a_page_that_cannot_be_written_ends_the_story() {
        struct Full(usize);
        impl Write for Full {
            fn write(&mut self, buf: &[u8]) -> io::Result<usize> {
                self.0 = self.0.checked_sub(1).ok_or(io::ErrorKind::BrokenPipe)?;
                Ok(buf.len())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        for lines in [0, 1, 50, 200] {
            let ended = play(&mut Full(lines)).unwrap_err();
            assert!(matches!(ended, Trouble::Out(error) if error.kind() == io::ErrorKind::BrokenPipe));
        }
    }
}
