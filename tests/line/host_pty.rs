//! The pseudo-terminal link, seen from the terminal that a master opens.

use core::time::Duration;
use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Read, Write};
use std::os::unix::fs::{OpenOptionsExt, symlink};
use std::path::Path;
use std::thread;
use std::time::Instant;

use profidrive::host::link::pty::Pty;
use profidrive::host::{Error, Link, PathOccupant, Received, Stop};
use profidrive::time::BaudRate;
use rustix::fs::OFlags;
use rustix::termios::{ControlModes, InputModes, LocalModes, OptionalActions, OutputModes, SpecialCodeIndex};

use crate::patience::PATIENCE;

/// A program that has the terminal open and, unless a test says so, changes no setting.
struct Master(File);

impl Master {
    fn open(path: &Path) -> Self {
        let flags = (OFlags::NOCTTY | OFlags::NONBLOCK).bits().cast_signed();
        Self(OpenOptions::new().read(true).write(true).custom_flags(flags).open(path).unwrap())
    }

    fn write(&mut self, octets: &[u8]) {
        self.0.write_all(octets).unwrap();
    }

    /// What can be read now.
    fn read(&mut self) -> Vec<u8> {
        let mut octets = Vec::new();
        match self.0.read_to_end(&mut octets) {
            Err(error) if error.kind() == ErrorKind::WouldBlock => octets,
            // So it is with VMIN = 0.
            Ok(_) => octets,
            Err(error) => panic!("{error} after {octets:02X?}"),
        }
    }

    /// What can be read once there is something.
    fn read_some(&mut self) -> Vec<u8> {
        soon(|| Some(self.read()).filter(|octets| !octets.is_empty()))
    }

    /// The settings of a serial program: raw, 8 data bits, even parity, this rate.
    fn set_serial(&self, rate: u32) {
        let mut settings = rustix::termios::tcgetattr(&self.0).unwrap();
        settings.make_raw();
        settings.control_modes |= ControlModes::PARENB | ControlModes::CLOCAL | ControlModes::CREAD;
        settings.special_codes[SpecialCodeIndex::VMIN] = 0;
        settings.set_speed(rate).unwrap();
        rustix::termios::tcsetattr(&self.0, OptionalActions::Now, &settings).unwrap();
    }
}

/// The kernel hands octets over in its own time, in a worker: waits for them, but not for ever.
fn soon<T>(mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        match look() {
            Some(found) => return found,
            None if start.elapsed() > PATIENCE => panic!("nothing came"),
            None => thread::yield_now(),
        }
    }
}

/// What the drives hear next.
fn next(pty: &mut Pty, stop: &Stop) -> Vec<u8> {
    let mut buf = [0; 1024];
    soon(|| {
        pty.wait(Some(Duration::from_millis(10)), stop).unwrap();
        match pty.receive(&mut buf).unwrap() {
            Received::Octets(count) => Some(buf[..count].to_vec()),
            Received::BrokenOff(_) | Received::Reset | Received::Rate(_) | Received::Nothing => None,
        }
    })
}

/// The drives hear exactly this, in one piece or several.
fn hears(pty: &mut Pty, octets: &[u8]) {
    let stop = Stop::new().unwrap();
    let mut heard = Vec::new();
    while heard.len() < octets.len() {
        heard.extend(next(pty, &stop));
    }
    assert_eq!(heard, octets);
}

fn reads(master: &mut Master, octets: &[u8]) {
    let mut read = Vec::new();
    while read.len() < octets.len() {
        read.extend(master.read_some());
    }
    assert_eq!(read, octets);
}

fn every_octet() -> Vec<u8> {
    (0..=255).collect()
}

fn transparent(pty: &mut Pty, master: &mut Master) {
    master.write(&every_octet());
    hears(pty, &every_octet());
    pty.send(&every_octet()).unwrap();
    reads(master, &every_octet());
    let mut buf = [0; 8];
    assert_eq!(pty.receive(&mut buf).unwrap(), Received::Nothing, "no echo");
}

#[test]
fn every_octet_passes_both_ways_without_any_setting_by_the_master() {
    let mut pty = Pty::open(None).unwrap();
    let mut master = Master::open(pty.path());
    transparent(&mut pty, &mut master);
    assert_eq!(pty.lost(), 0);
}

#[test]
fn every_octet_passes_whatever_rate_and_parity_the_master_sets_and_the_rate_is_followed() {
    let mut pty = Pty::open(None).unwrap();
    pty.follow_rate(true);
    assert_eq!(pty.speed().unwrap(), None);
    let mut master = Master::open(pty.path());
    for rate in BaudRate::ALL {
        master.set_serial(rate.bits_per_second());
        assert_eq!(pty.speed().unwrap(), Some(rate.bits_per_second()));
        assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Rate(rate));
        assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Nothing, "said once");
        transparent(&mut pty, &mut master);
    }
    master.set_serial(38_400);
    assert_eq!(pty.speed().unwrap(), Some(38_400));
    assert_eq!(
        pty.receive(&mut [0; 8]).unwrap(),
        Received::Nothing,
        "no rate of PROFIBUS: the last one stays"
    );
}

#[test]
fn a_rate_is_not_mentioned_unless_it_is_to_be_followed() {
    let mut pty = Pty::open(None).unwrap();
    let master = Master::open(pty.path());
    master.set_serial(19_200);
    assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Nothing);
}

#[test]
fn several_masters_one_after_the_other_are_served() {
    let mut pty = Pty::open(None).unwrap();
    for _ in 0..20 {
        let mut master = Master::open(pty.path());
        master.set_serial(500_000);
        transparent(&mut pty, &mut master);
    }
}

#[test]
fn half_a_telegram_of_one_master_does_not_reach_the_next() {
    let mut pty = Pty::open(None).unwrap();
    let mut first = Master::open(pty.path());
    first.write(&[0x68, 0x0B, 0x0B]);
    drop(first);
    let mut second = Master::open(pty.path());
    assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Reset);
    assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Nothing);
    second.write(&[0x10, 0x05]);
    hears(&mut pty, &[0x10, 0x05]);
}

#[test]
fn a_master_that_writes_and_leaves_at_once_is_heard_and_then_the_line_is_reset() {
    let mut pty = Pty::open(None).unwrap();
    for _ in 0..3 {
        Master::open(pty.path()).write(&[0x68, 0x0B]);
        let mut buf = [0; 8];
        assert_eq!(pty.receive(&mut buf).unwrap(), Received::Octets(2));
        pty.send(&[0xE5]).unwrap();
        assert_eq!(pty.receive(&mut buf).unwrap(), Received::Reset);
        assert_eq!(pty.receive(&mut buf).unwrap(), Received::Nothing, "said once");
    }
    assert_eq!(pty.lost(), 3);
}

#[test]
fn octets_of_two_masters_in_one_queue_come_after_the_reset() {
    let mut pty = Pty::open(None).unwrap();
    Master::open(pty.path()).write(&[0x68]);
    let mut second = Master::open(pty.path());
    second.write(&[0x10, 0x05]);
    assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Reset);
    hears(&mut pty, &[0x68, 0x10, 0x05]);
    pty.send(&[7]).unwrap();
    reads(&mut second, &[7]);
}

#[test]
fn a_hasty_second_master_loses_nothing_if_the_first_left_nothing_behind() {
    let mut pty = Pty::open(None).unwrap();
    let mut first = Master::open(pty.path());
    transparent(&mut pty, &mut first);
    drop(first);
    let mut second = Master::open(pty.path());
    second.write(&[1, 2, 3]);
    assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Reset);
    hears(&mut pty, &[1, 2, 3]);
}

#[test]
fn what_is_sent_while_nobody_has_the_terminal_open_is_lost_and_counted() {
    let mut pty = Pty::open(None).unwrap();
    pty.send(&[1, 2, 3]).unwrap();
    assert_eq!(pty.lost(), 3);
    let mut master = Master::open(pty.path());
    pty.send(&[4]).unwrap();
    reads(&mut master, &[4]);
    assert_eq!(pty.lost(), 3);
}

#[test]
fn what_one_master_did_not_read_does_not_reach_the_next() {
    let mut pty = Pty::open(None).unwrap();
    for len in [1, 255, 200_000] {
        let first = Master::open(pty.path());
        pty.send(&vec![0x55; len]).unwrap();
        drop(first);
        let mut second = Master::open(pty.path());
        assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Reset);
        pty.send(&[7]).unwrap();
        reads(&mut second, &[7]);
        assert_eq!(second.read(), [0; 0]);
        drop(second);
        assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Reset);
    }
}

#[test]
fn a_reply_to_a_master_that_left_is_not_sent_to_the_next() {
    let mut pty = Pty::open(None).unwrap();
    let mut first = Master::open(pty.path());
    first.write(&[1]);
    hears(&mut pty, &[1]);
    drop(first);
    let mut second = Master::open(pty.path());
    // A reply at once is that of a turn that began before.
    let opened = Instant::now();
    while opened.elapsed() < Duration::from_millis(1) {}
    pty.send(&[0xE5]).unwrap();
    assert_eq!(pty.lost(), 1);
    assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Reset);
    pty.send(&[2]).unwrap();
    reads(&mut second, &[2]);
}

#[test]
fn a_second_program_on_the_terminal_is_no_new_master() {
    let mut pty = Pty::open(None).unwrap();
    for _ in 0..3 {
        // Opened and closed by several at once, without a look in between.
        let (first, mut last, second) =
            (Master::open(pty.path()), Master::open(pty.path()), Master::open(pty.path()));
        drop(first);
        drop(second);
        for _ in 0..3 {
            drop((Master::open(pty.path()), Master::open(pty.path())));
        }
        pty.send(&[1]).unwrap();
        assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Nothing);
        reads(&mut last, &[1]);
        drop(last);
        assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Reset);
        pty.send(&[2]).unwrap();
    }
    assert_eq!(pty.lost(), 3);
}

#[test]
fn the_terminal_is_raw_again_after_a_master_that_left_it_cooked() {
    let mut pty = Pty::open(None).unwrap();
    let first = Master::open(pty.path());
    let mut cooked = rustix::termios::tcgetattr(&first.0).unwrap();
    cooked.local_modes |= LocalModes::ICANON | LocalModes::ECHO | LocalModes::ISIG;
    cooked.input_modes |= InputModes::ICRNL | InputModes::IXON;
    cooked.output_modes |= OutputModes::OPOST | OutputModes::ONLCR;
    cooked.set_speed(9_600).unwrap();
    rustix::termios::tcsetattr(&first.0, OptionalActions::Now, &cooked).unwrap();
    drop(first);
    assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Reset);
    assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Nothing);
    let stop = Stop::new().unwrap();
    soon(|| {
        pty.wait(Some(Duration::from_secs(1)), &stop).unwrap();
        assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Nothing);
        pty.speed().unwrap().is_none().then_some(())
    });
    let mut second = Master::open(pty.path());
    transparent(&mut pty, &mut second);
}

#[test]
fn settings_equal_to_those_of_the_master_before_are_a_change_all_the_same() {
    let mut pty = Pty::open(None).unwrap();
    let stop = Stop::new().unwrap();
    for _ in 0..3 {
        let master = Master::open(pty.path());
        let settings = || rustix::termios::tcgetattr(&master.0).unwrap();
        assert!(settings().local_modes.contains(LocalModes::ECHONL));
        master.set_serial(9_600);
        assert!(!settings().local_modes.contains(LocalModes::ECHONL));
        soon(|| {
            pty.wait(Some(Duration::from_secs(1)), &stop).unwrap();
            assert!(!matches!(pty.receive(&mut [0; 8]).unwrap(), Received::Octets(_)));
            settings().local_modes.contains(LocalModes::ECHONL).then_some(())
        });
        assert_eq!(pty.speed().unwrap(), Some(9_600), "nothing else is touched");
    }
}

#[test]
fn a_master_that_does_not_read_never_blocks_the_drives() {
    let mut pty = Pty::open(None).unwrap();
    let _master = Master::open(pty.path());
    for _ in 0..4096 {
        pty.send(&[0x55; 255]).unwrap();
    }
    assert!(pty.lost() > 500_000, "{} octets lost", pty.lost());
}

#[test]
fn an_idle_line_sleeps_and_an_open_a_write_and_a_stop_wake_it() {
    let mut pty = Pty::open(None).unwrap();
    let stop = Stop::new().unwrap();
    let terminal = pty.path().to_owned();
    // Before and after a master: no hang-up may end the sleep.
    for _ in 0..2 {
        let start = Instant::now();
        let mut wakes = 0;
        while let Some(left) = Duration::from_millis(50).checked_sub(start.elapsed()) {
            pty.wait(Some(left), &stop).unwrap();
            assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Nothing);
            wakes += 1;
        }
        // The other tests open terminals too, and each of those wakes this one.
        assert!(wakes < 500, "woken {wakes} times in 50 ms");
        thread::scope(|scope| {
            let opener = scope.spawn(|| Master::open(&terminal));
            pty.wait(None, &stop).unwrap();
            let mut master = opener.join().unwrap();
            assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Nothing);
            let writer = scope.spawn(move || {
                master.write(&[1]);
                master
            });
            pty.wait(None, &stop).unwrap();
            hears(&mut pty, &[1]);
            drop(writer.join().unwrap());
        });
        pty.wait(None, &stop).unwrap();
        assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Reset);
        assert_eq!(pty.receive(&mut [0; 8]).unwrap(), Received::Nothing);
    }
    thread::scope(|scope| {
        scope.spawn(|| stop.request());
        pty.wait(None, &stop).unwrap();
    });
}

#[test]
fn the_symbolic_link_leads_to_the_terminal_and_goes_with_it() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bus");
    let mut pty = Pty::open(Some(&path)).unwrap();
    assert_eq!(pty.path(), path);
    let mut master = Master::open(&path);
    transparent(&mut pty, &mut master);
    drop(pty);
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
}

#[test]
fn a_dangling_link_is_replaced() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bus");
    symlink(dir.path().join("gone"), &path).unwrap();
    let pty = Pty::open(Some(&path)).unwrap();
    drop(Master::open(&path));
    drop(pty);
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
}

#[test]
fn nothing_else_is_replaced() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("file");
    fs::write(&file, "precious").unwrap();
    let used = dir.path().join("used");
    symlink(&file, &used).unwrap();
    for (path, expected) in [
        (file.as_path(), PathOccupant::File),
        (used.as_path(), PathOccupant::LinkInUse),
        (dir.path(), PathOccupant::Directory),
    ] {
        match Pty::open(Some(path)) {
            Err(Error::PathTaken { found, .. }) => assert_eq!(found, expected, "{path:?}"),
            other => panic!("{path:?}: {other:?}"),
        }
    }
    assert_eq!(fs::read_to_string(&used).unwrap(), "precious");
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2);
}

#[test]
fn the_name_of_a_running_line_is_not_taken_over() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bus");
    let mut first = Pty::open(Some(&path)).unwrap();
    assert!(matches!(Pty::open(Some(&path)), Err(Error::PathTaken { found: PathOccupant::LinkInUse, .. })));
    let mut master = Master::open(&path);
    transparent(&mut first, &mut master);
}

#[test]
fn a_link_that_somebody_else_put_there_since_is_left_alone() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bus");
    let pty = Pty::open(Some(&path)).unwrap();
    fs::remove_file(&path).unwrap();
    symlink("/elsewhere", &path).unwrap();
    drop(pty);
    assert_eq!(fs::read_link(&path).unwrap(), Path::new("/elsewhere"));
}

#[test]
fn a_link_in_a_missing_directory_fails_by_name() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("missing/bus");
    assert!(matches!(Pty::open(Some(&path)), Err(Error::Symlink { path: named, .. }) if named == path));
}

#[cfg(feature = "serial")]
mod serial {
    use super::*;
    use profidrive::host::link::serial::Serial;

    /// A terminal takes the settings of a serial port, so the other side of one can stand for an adapter.
    #[test]
    fn a_serial_port_passes_every_octet_both_ways_and_belongs_to_one_process() {
        let mut adapter = Pty::open(None).unwrap();
        let device = adapter.path().to_str().unwrap().to_owned();
        let stop = Stop::new().unwrap();
        let mut serial = Serial::open(&device, BaudRate::K93_75).unwrap();
        assert_eq!(adapter.speed().unwrap(), Some(93_750));

        serial.send(&every_octet()).unwrap();
        hears(&mut adapter, &every_octet());
        adapter.send(&every_octet()).unwrap();
        let mut heard = Vec::new();
        while heard.len() < 256 {
            serial.wait(None, &stop).unwrap();
            let mut buf = [0; 300];
            if let Received::Octets(count) = serial.receive(&mut buf).unwrap() {
                heard.extend_from_slice(&buf[..count]);
            }
        }
        assert_eq!(heard, every_octet());
        assert_eq!(serial.receive(&mut [0; 8]).unwrap(), Received::Nothing);
        assert_eq!(serial.lost(), 0);
        assert!(Serial::open(&device, BaudRate::K93_75).is_err(), "somebody has it");
        drop(serial);
        adapter.wait(None, &stop).unwrap();
        assert_eq!(adapter.receive(&mut [0; 8]).unwrap(), Received::Reset);
        Serial::open(&device, BaudRate::K500).unwrap();
    }

    #[test]
    fn a_device_that_is_gone_ends_the_link_with_an_error() {
        let adapter = Pty::open(None).unwrap();
        let mut serial = Serial::open(adapter.path().to_str().unwrap(), BaudRate::K500).unwrap();
        drop(adapter);
        serial.wait(None, &Stop::new().unwrap()).unwrap();
        assert!(serial.receive(&mut [0; 8]).is_err());
    }

    /// What the drives hear next on a serial port.
    fn heard(serial: &mut Serial) -> Vec<u8> {
        let stop = Stop::new().unwrap();
        let mut buf = [0; 300];
        soon(|| {
            serial.wait(Some(Duration::from_millis(10)), &stop).unwrap();
            match serial.receive(&mut buf).unwrap() {
                Received::Octets(count) => Some(buf[..count].to_vec()),
                _ => None,
            }
        })
    }

    #[test]
    fn an_adapter_that_hears_itself_is_not_heard() {
        let mut adapter = Pty::open(None).unwrap();
        let mut serial = Serial::open(adapter.path().to_str().unwrap(), BaudRate::K19_2).unwrap();
        let (reply, request) = ([0x10, 0x02, 0x05, 0x00, 0x07, 0x16], [0x10, 0x05, 0x02, 0x49, 0x50, 0x16]);
        for echo in [true, true, false, true, false] {
            serial.send(&reply).unwrap();
            hears(&mut adapter, &reply);
            if echo {
                adapter.send(&reply[..2]).unwrap();
                adapter.send(&reply[2..]).unwrap();
            }
            adapter.send(&request).unwrap();
            let mut all = heard(&mut serial);
            while all.len() < request.len() {
                all.extend(heard(&mut serial));
            }
            assert_eq!(all, request);
        }
    }

    #[test]
    fn a_device_that_is_unplugged_is_opened_again_when_it_is_back() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("ttyUSB0");
        let mut adapter = Pty::open(Some(&path)).unwrap();
        let mut serial = Serial::open(path.to_str().unwrap(), BaudRate::K19_2).unwrap();
        serial.reopen(true);
        let stop = Stop::new().unwrap();
        for round in 0..2 {
            adapter.send(&[1, round]).unwrap();
            assert_eq!(heard(&mut serial)[0], 1);
            drop(adapter);
            serial.wait(None, &stop).unwrap();
            soon(|| (serial.receive(&mut [0; 8]).unwrap() == Received::Reset).then_some(()));
            let lost = serial.lost();
            serial.send(&[0xE5; 3]).unwrap();
            assert_eq!(serial.lost(), lost + 3);
            // Gone is no reason to stay awake.
            let (start, mut wakes) = (Instant::now(), 0);
            while start.elapsed() < Duration::from_millis(50) {
                serial.wait(Some(Duration::from_millis(50)), &stop).unwrap();
                assert_eq!(serial.receive(&mut [0; 8]).unwrap(), Received::Nothing, "said once");
                wakes += 1;
            }
            assert!(wakes < 10, "woken {wakes} times in 50 ms");
            adapter = Pty::open(Some(&path)).unwrap();
            soon(|| {
                serial.wait(Some(Duration::from_millis(10)), &stop).unwrap();
                assert_eq!(serial.receive(&mut [0; 8]).unwrap(), Received::Nothing);
                (adapter.speed().unwrap() == Some(19_200)).then_some(())
            });
            serial.send(&[2]).unwrap();
            hears(&mut adapter, &[2]);
        }
    }

    #[test]
    fn every_rate_is_set_exactly() {
        for rate in BaudRate::ALL {
            let adapter = Pty::open(None).unwrap();
            let _serial = Serial::open(adapter.path().to_str().unwrap(), rate).unwrap();
            assert_eq!(adapter.speed().unwrap(), Some(rate.bits_per_second()));
        }
    }

    #[test]
    fn what_does_not_open_as_a_serial_port_is_refused_with_advice() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("file");
        fs::write(&file, "no device").unwrap();
        for (device, advice) in [
            (dir.path().join("missing"), "plugged in"),
            (file, "name a serial device"),
            (dir.path().to_owned(), "name a serial device"),
        ] {
            let error = Serial::open(device.to_str().unwrap(), BaudRate::K500).unwrap_err();
            assert!(error.to_string().contains(advice), "{error}");
        }
    }
}
