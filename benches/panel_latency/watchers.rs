//! Who has the panel open: three browsers, or readers that stand in for them.

use core::fmt;
use std::io::Read;
use std::net::{Shutdown, TcpStream};
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use std::{env, fs, process, thread};

use rustix::process::{Pid, Signal, kill_process_group};

use crate::panel::Emulator;

const COUNT: usize = 3;
/// How long a browser may take to open the page.
const PATIENCE: Duration = Duration::from_secs(60);

pub(crate) enum Watchers<'a> {
    Browsers(Vec<Browser>),
    Readers { emulator: &'a Emulator, sockets: Vec<TcpStream> },
}

impl<'a> Watchers<'a> {
    /// Opens the panel; returns when everybody sees it.
    pub(crate) fn open(emulator: &'a Emulator) -> Self {
        let chromium = env::var_os("CHROMIUM").map_or("/usr/bin/chromium".into(), PathBuf::from);
        if !chromium.exists() {
            return Self::Readers { emulator, sockets: Vec::new() };
        }
        let page = format!("http://{}/#drive/5", emulator.panel);
        let before = connections(emulator);
        let browsers = (0..COUNT).map(|number| Browser::open(&chromium, number, &page)).collect();
        let start = Instant::now();
        while connections(emulator) < before + COUNT {
            assert!(start.elapsed() < PATIENCE, "the browsers do not open the page");
            thread::sleep(Duration::from_millis(100));
        }
        // What a browser does only once.
        thread::sleep(Duration::from_secs(5));
        Self::Browsers(browsers)
    }

    /// Lets them look, or stand still.
    pub(crate) fn run(&mut self, run: bool) {
        match self {
            Self::Browsers(browsers) => {
                let signal = if run { Signal::CONT } else { Signal::STOP };
                for browser in browsers {
                    kill_process_group(browser.group(), signal).unwrap();
                }
            }
            Self::Readers { emulator, sockets } if run && sockets.is_empty() => {
                *sockets = (0..COUNT).map(|_| reader(emulator)).collect();
            }
            Self::Readers { .. } if run => {}
            Self::Readers { sockets, .. } => {
                sockets.drain(..).for_each(|socket| socket.shutdown(Shutdown::Both).unwrap_or_default());
            }
        }
    }
}

impl fmt::Display for Watchers<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Browsers(browsers) => write!(f, "{} browsers", browsers.len()),
            Self::Readers { .. } => {
                write!(f, "no browser (there is none), but {COUNT} readers of what a page reads")
            }
        }
    }
}

pub(crate) struct Browser {
    process: Child,
    profile: PathBuf,
}

impl Browser {
    fn open(chromium: &PathBuf, number: usize, page: &str) -> Self {
        let profile = env::temp_dir().join(format!("profidrive-latency-{}-{number}", process::id()));
        let process = Command::new(chromium)
            .args([
                "--headless=new",
                "--no-sandbox",
                "--disable-gpu",
                "--disable-dev-shm-usage",
                "--no-first-run",
            ])
            .arg("--remote-debugging-port=0")
            .arg(format!("--user-data-dir={}", profile.display()))
            .arg(page)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .process_group(0)
            .spawn()
            .unwrap();
        Self { process, profile }
    }

    /// The browser and all processes it has started.
    fn group(&self) -> Pid {
        Pid::from_child(&self.process)
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = kill_process_group(self.group(), Signal::KILL);
        let _ = self.process.wait();
        let _ = fs::remove_dir_all(&self.profile);
    }
}

/// Reads what a page reads, and does nothing with it.
fn reader(emulator: &Emulator) -> TcpStream {
    let (_, socket) = emulator.connect_stream("?address=5&kinds=state,news,telegram");
    let mut page = socket.try_clone().unwrap();
    thread::spawn(move || while page.read(&mut [0; 65536]).is_ok_and(|count| count > 0) {});
    socket
}

/// How many sockets the emulator has open.
fn connections(emulator: &Emulator) -> usize {
    let files = fs::read_dir(format!("/proc/{}/fd", emulator.process.id())).unwrap();
    let links = files.filter_map(|file| fs::read_link(file.ok()?.path()).ok());
    links.filter(|link| link.to_string_lossy().starts_with("socket:")).count()
}
