//! A CAN interface of Linux, as a master's end of the bus behind it.

use core::time::Duration;
use std::io;
use std::os::fd::AsFd;

use rustix::event::{PollFd, PollFlags};
use socketcan::{CanFrame, CanSocket, EmbeddedFrame, ExtendedId, Socket, StandardId};

use super::CanEndpoint;
use crate::can_bus::can::{Content, Frame, Id};
use crate::host::Stop;
use crate::host::link::poll_readable;

/// An open interface. Its rate is set by `ip link`, not here.
#[derive(Debug)]
pub struct SocketCanEndpoint {
    socket: CanSocket,
}

impl SocketCanEndpoint {
    /// Opens the interface of that name: `can0`, `vcan0`.
    ///
    /// # Errors
    /// There is no such interface, it is no CAN interface, or the kernel has no CAN.
    pub(crate) fn open(name: &str) -> io::Result<Self> {
        let socket = CanSocket::open(name)?;
        socket.set_nonblocking(true)?;
        Ok(Self { socket })
    }
}

impl CanEndpoint for SocketCanEndpoint {
    /// A full queue of the interface loses the frame, as a full bus does: who sent it asks again.
    fn send(&mut self, frame: &Frame) -> io::Result<()> {
        let Some(frame) = to_socket(frame) else { return Err(io::ErrorKind::InvalidInput.into()) };
        match self.socket.write_frame(&frame) {
            Err(error) if is_full(&error) => Ok(()),
            sent @ (Ok(()) | Err(_)) => sent,
        }
    }

    fn receive(&mut self) -> io::Result<Option<Frame>> {
        loop {
            match self.socket.read_frame() {
                Ok(frame) => {
                    if let Some(frame) = from_socket(&frame) {
                        return Ok(Some(frame));
                    }
                }
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(None),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }

    fn wait(&mut self, timeout: Option<Duration>, stop: &Stop) -> io::Result<()> {
        let socket = self.socket.as_fd();
        poll_readable(&mut [PollFd::new(stop, PollFlags::IN), PollFd::new(&socket, PollFlags::IN)], timeout)
    }
}

fn is_full(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::WouldBlock
        || error.raw_os_error() == Some(rustix::io::Errno::NOBUFS.raw_os_error())
}

fn to_socket(frame: &Frame) -> Option<CanFrame> {
    let id = match frame.id() {
        Id::Base(id) => socketcan::Id::Standard(StandardId::new(id.number())?),
        Id::Extended(id) => socketcan::Id::Extended(ExtendedId::new(id.number())?),
    };
    match frame.content() {
        Content::Data(octets) => CanFrame::new(id, octets),
        Content::Remote { dlc } => CanFrame::new_remote(id, dlc.into()),
    }
}

/// `None` for an error frame.
fn from_socket(frame: &CanFrame) -> Option<Frame> {
    let id = match frame.id() {
        socketcan::Id::Standard(id) => Id::base(id.as_raw()),
        socketcan::Id::Extended(id) => Id::extended(id.as_raw()),
    };
    match frame {
        CanFrame::Data(frame) => Frame::data(id.ok()?, frame.data()).ok(),
        CanFrame::Remote(frame) => Frame::remote(id.ok()?, u8::try_from(frame.dlc()).ok()?).ok(),
        CanFrame::Error(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_frame_comes_back_from_the_form_of_the_kernel(id in 0_u32..=0x1FFF_FFFF, remote: bool, dlc in 0_u8..=8, data: [u8; 8]) {
            for id in [Id::extended(id), Id::base(u16::try_from(id & 0x7FF).unwrap())] {
                let id = id.unwrap();
                let one = if remote { Frame::remote(id, dlc) } else { Frame::data(id, &data[..usize::from(dlc)]) };
                let one = one.unwrap();
                prop_assert_eq!(from_socket(&to_socket(&one).unwrap()), Some(one));
            }
        }
    }

    #[test]
    fn an_interface_that_is_not_there_is_an_error() {
        assert!(SocketCanEndpoint::open("no-such-can0").is_err());
    }
}
