//! The history as a pcapng file, for Wireshark.

use std::path::Path;

use super::{Line, Master, Sender};
use crate::host::capture::{Capture, CaptureError, Interface};
use crate::host::link::tap::{Batch, Direction};

impl<M: Master> Line<M> {
    /// Writes what has passed and is [kept](Line::keep) to a pcapng file. Virtual time zero is so long ago as virtual time
    /// has passed. Stations are "sent", masters are "heard".
    ///
    /// # Errors
    /// [`CaptureError`].
    pub fn save(&self, path: &Path) -> Result<(), CaptureError> {
        let baud = Some(self.baud());
        let line = Interface { name: "bench", description: "a line in virtual time", baud };
        let mut capture = Capture::create(path, &line, self)?;
        let mut batch = Batch::default();
        for passed in self.history() {
            let direction = match passed.sender {
                Sender::Master | Sender::Test => Direction::Heard,
                Sender::Station => Direction::Sent,
            };
            batch.push(passed.end, direction, &passed.octets);
        }
        capture.write(&batch).map_err(|source| CaptureError::File { path: path.to_path_buf(), source })
    }
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::bench::ScriptedMaster;
    use crate::devices::ag03::profibus::Config;
    use crate::host::capture;
    use crate::profibus::fdl::Address;
    use crate::time::BaudRate;

    #[test]
    fn a_capture_of_virtual_time_reads_back_with_times_and_directions() {
        let mut line = Line::new(BaudRate::K500);
        line.add_drive(Config::new(Address::from_octet(5))).unwrap();
        let mut master = ScriptedMaster::new(Address::from_octet(2));
        assert!(master.fdl_status(&mut line, Address::from_octet(5)).unwrap());
        line.wait(core::time::Duration::from_secs(3600)).unwrap();
        line.send(&[1, 2]).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bench.pcapng");
        line.save(&path).unwrap();

        let packets: Vec<_> = capture::read(&path).unwrap().map(Result::unwrap).collect();
        let [request, reply, noise] = &packets[..] else { panic!("{packets:?}") };
        assert_eq!(request.octets, [0x10, 0x05, 0x02, 0x49, 0x50, 0x16]);
        assert_eq!((request.direction, reply.direction), (Some(Direction::Heard), Some(Direction::Sent)));
        assert!(noise.comment.as_deref().is_some_and(|comment| comment.starts_with("invalid: ")));
        // 11 T_bit until the reply begins, 66 that it lasts.
        let took = reply.time.checked_sub(request.time).unwrap();
        assert_eq!(took, BaudRate::K500.bit_times(77));
    }
}
