//! A scripted DP master on the terminal of a running `profidrive emulate`.

#![allow(dead_code, reason = "each test file uses its part")]

use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use profidrive::profibus::fdl::{FrameCount, Framer, FunctionCode, Resync, Service, Telegram};
use profidrive::profibus::ppo::{Outputs, PPO_LEN, Pkw, Stw};
use profidrive::time::Instant;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::OFlags;

use crate::drive_line::{CFG, IDENT, MASTER, SLAVE, telegram};

/// A DP master in Data_Exchange with the drive. Every call says `None` once the emulator is gone.
pub(crate) struct Master {
    terminal: File,
    framer: Framer,
    count: FrameCount,
    /// Every telegram sent (`true`) and received (`false`), in this order.
    #[allow(dead_code, reason = "each test file uses its part")]
    pub(crate) log: Vec<(bool, Vec<u8>)>,
}

impl Master {
    pub(crate) fn open(terminal: &Path) -> Self {
        // No watchdog.
        Self::parameterised(terminal, [0x80, 1, 1])
    }

    /// The same with other first octets of Set_Prm: WD_On and the factors of the watchdog.
    pub(crate) fn parameterised(terminal: &Path, [station_status, wd1, wd2]: [u8; 3]) -> Self {
        let flags = (OFlags::NOCTTY | OFlags::NONBLOCK).bits().cast_signed();
        let terminal = OpenOptions::new().read(true).write(true).custom_flags(flags).open(terminal).unwrap();
        let (framer, count, log) = (Framer::new(Resync::SCAN), FrameCount::First, Vec::new());
        let mut master = Self { terminal, framer, count, log };
        let prm = [station_status, wd1, wd2, 11, IDENT[0], IDENT[1], 0];
        assert_eq!(master.request(Some(61), &prm), Some(Vec::new()), "Set_Prm");
        assert_eq!(master.request(Some(62), &CFG), Some(Vec::new()), "Chk_Cfg");
        // WD_On is said where it was asked for.
        let ready = [0, 0x04 | station_status & 0x08];
        assert_eq!(master.request(Some(60), &[]).unwrap()[..2], ready, "ready for Data_Exchange");
        master
    }

    /// The data of the reply.
    fn request(&mut self, dsap: Option<u8>, data: &[u8]) -> Option<Vec<u8>> {
        let fc = FunctionCode::request(Service::SrdHigh, self.count);
        self.count = match self.count {
            FrameCount::First | FrameCount::Odd | FrameCount::Unused => FrameCount::Even,
            FrameCount::Even => FrameCount::Odd,
        };
        self.send(telegram(SLAVE, MASTER, fc, dsap, data))
    }

    /// The last request once more, as if its reply was lost.
    pub(crate) fn retry(&mut self) -> Option<Vec<u8>> {
        let (_, last) = self.log.iter().rev().find(|(sent, _)| *sent).unwrap();
        self.send(last.clone())
    }

    /// Octets to which nobody replies.
    pub(crate) fn noise(&mut self, octets: &[u8]) {
        self.terminal.write_all(octets).unwrap();
    }

    /// Sends a request; the data of the reply.
    fn send(&mut self, request: Vec<u8>) -> Option<Vec<u8>> {
        self.terminal.write_all(&request).ok()?;
        self.log.push((true, request));
        let mut octets = [0; 256];
        let mut reply = None;
        self.log.push((false, Vec::new()));
        while reply.is_none() {
            let mut readable = [PollFd::new(&self.terminal, PollFlags::IN)];
            let patience = Timespec { tv_sec: 5, tv_nsec: 0 };
            assert!(poll(&mut readable, Some(&patience)).unwrap() > 0, "no reply within 5 s");
            let count = self.terminal.read(&mut octets).ok().filter(|count| *count > 0)?;
            self.log.last_mut().unwrap().1.extend(&octets[..count]);
            self.framer.handle_bytes(Instant::ZERO, &octets[..count], |_, result| match result.unwrap() {
                Telegram::Data(telegram) => reply = Some(telegram.data.to_vec()),
                Telegram::ShortAcknowledge => reply = Some(Vec::new()),
                Telegram::Token { .. } => panic!("a slave passes no token"),
            });
        }
        reply
    }

    /// Runs a job to its reply: first job 0 until the reply before is gone.
    pub(crate) fn job(&mut self, job: Pkw) -> Option<Pkw> {
        while self.pkw(Pkw::ZERO)? != Pkw::ZERO {}
        loop {
            let reply = self.pkw(job)?;
            if reply != Pkw::ZERO {
                return Some(reply);
            }
        }
    }

    fn pkw(&mut self, job: Pkw) -> Option<Pkw> {
        let inputs = self.exchange(&Outputs::octets(job, Stw::from_raw(0), 0))?;
        Some(Pkw::from_octets(inputs[..8].try_into().unwrap()))
    }

    /// One Data_Exchange.
    pub(crate) fn exchange(&mut self, outputs: &[u8; PPO_LEN]) -> Option<[u8; PPO_LEN]> {
        Some(self.request(None, outputs)?.try_into().unwrap())
    }
}
