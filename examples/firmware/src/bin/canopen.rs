//! The drive AG03/1 on CANopen as node 5. The board has no CAN controller: an adapter of slcan stands in front of the node, its
//! serial line is the UART, and between the two is nothing but a bus of one node.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use profidrive::can_bus::can::Frame;
use profidrive::can_bus::can::slcan::{Adapter, Effect};
use profidrive::can_bus::canopen::NodeId;
use profidrive::devices::CanopenDevice;
use profidrive::devices::ag03::canopen::{Ag03Node, Config};
use profidrive::devices::ag03::profibus::DipSwitches;
use profidrive::time::Instant;
use profidrive_firmware::board::{Board, Heard};
use profidrive_firmware::{ended, say};

#[entry]
fn main() -> ! {
    let mut board = Board::start();
    let Ok(id) = NodeId::new(5) else { ended("no such node\n") };
    // They lie in this frame, which is never left.
    let mut node = Ag03Node::new(Config::new(DipSwitches::from(id)), Instant::ZERO);
    let mut adapter = Adapter::new();
    CanopenDevice::power_on(&mut node, board.now());
    say("ready\n");
    loop {
        while let Some((at, heard)) = board.receive() {
            match heard {
                Heard::Octet(octet) => hear(&mut board, &mut adapter, &mut node, at, octet),
                // A line that lacks a character is none.
                Heard::Damaged => adapter.break_line(),
            }
        }
        let now = board.now();
        if CanopenDevice::poll_timeout(&node).is_some_and(|due| due <= now) {
            CanopenDevice::handle_timeout(&mut node, now);
        }
        while let Some(frame) = CanopenDevice::poll_transmit(&mut node, now) {
            pass_on(&mut board, &adapter, now, &frame);
        }
        // A firmware with a log would write them there.
        while CanopenDevice::poll_event(&mut node).is_some() {}
        let due = CanopenDevice::poll_timeout(&node);
        board.sleep(due);
    }
}

/// A character of the master, which may end a line.
fn hear(board: &mut Board, adapter: &mut Adapter, node: &mut Ag03Node, now: Instant, octet: u8) {
    let Some(reaction) = adapter.handle_octet(octet, true) else { return };
    match reaction.effect {
        Some(Effect::Transmit(frame)) => {
            CanopenDevice::handle_frame(node, now, &frame);
        }
        // The bus has one rate, and frames wait nowhere.
        Some(Effect::Rate(_) | Effect::Channel(_)) | None => {}
    }
    let answer = reaction.answer.as_octets();
    board.send(answer);
}

/// A frame of the node, if the master listens.
fn pass_on(board: &mut Board, adapter: &Adapter, now: Instant, frame: &Frame) {
    if let Some(line) = adapter.frame(now, frame) {
        board.send(line.as_octets());
    }
}
