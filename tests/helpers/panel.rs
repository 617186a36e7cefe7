//! A running `emulate --panel`, and a client for it that does exactly what it is told.
#![allow(dead_code, reason = "each test file uses its part")]

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;

use serde_json::{Value, json};

pub(crate) use crate::patience::PATIENCE;

/// An emulator with a panel, ended with the test.
pub(crate) struct Emulator {
    pub(crate) process: Child,
    pub(crate) panel: SocketAddr,
    /// Of the metrics, if they were asked for.
    pub(crate) metrics: Option<SocketAddr>,
    terminal: PathBuf,
}

impl Emulator {
    /// One AG03/1 at address 5.
    pub(crate) fn start() -> Self {
        Self::with(&[])
    }

    pub(crate) fn with(arguments: &[&str]) -> Self {
        Self::run(&[&["--panel", "127.0.0.1:0"], arguments].concat())
    }

    /// The one line of a file, which has a panel.
    pub(crate) fn of_file(file: &str) -> Self {
        Self::run(&["--line", file])
    }

    /// For comparison: nobody listens at `panel`.
    pub(crate) fn without_panel() -> Self {
        Self::run(&[])
    }

    /// As [`with`](Self::with); [`log`](Self::log) has what it logs.
    pub(crate) fn logging(arguments: &[&str]) -> Self {
        Self::run_with(&[&["--panel", "127.0.0.1:0"], arguments].concat(), Stdio::piped())
    }

    /// Ends it: the lines that it has logged, without their times.
    pub(crate) fn log(mut self) -> Vec<String> {
        let end = format!("kill -TERM {}", self.process.id());
        assert!(Command::new("sh").args(["-c", &end]).status().unwrap().success());
        let mut log = String::new();
        self.process.stderr.take().expect("logging").read_to_string(&mut log).unwrap();
        log.lines()
            .map(|line| line.split_once(' ').map_or(line, |(_, rest)| rest).trim().to_owned())
            .collect()
    }

    /// `profidrive try` without a browser.
    pub(crate) fn trying(arguments: &[&str]) -> Self {
        Self::command(&[&["try", "--no-browser"], arguments].concat(), Stdio::null())
    }

    /// As [`with`](Self::with), where no file can have more than so many units of 512 octets.
    pub(crate) fn with_small_files(units: u32, arguments: &[&str]) -> Self {
        let limit = format!("trap '' XFSZ; ulimit -f {units}; exec \"$0\" \"$@\"");
        let mut shell = Command::new("sh");
        shell.args(["-c", &limit, env!("CARGO_BIN_EXE_profidrive"), "emulate", "--panel", "127.0.0.1:0"]);
        Self::spawn(shell, arguments, Stdio::null())
    }

    fn run(arguments: &[&str]) -> Self {
        Self::run_with(arguments, Stdio::null())
    }

    fn run_with(arguments: &[&str], log: Stdio) -> Self {
        Self::command(&[&["emulate"], arguments].concat(), log)
    }

    fn command(arguments: &[&str], log: Stdio) -> Self {
        Self::spawn(Command::new(env!("CARGO_BIN_EXE_profidrive")), arguments, log)
    }

    fn spawn(mut program: Command, arguments: &[&str], log: Stdio) -> Self {
        let mut process = program
            .args(arguments)
            .env_remove("RUST_LOG")
            .env("NO_COLOR", "1")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(log)
            .spawn()
            .unwrap();
        let mut ready = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut ready).unwrap();
        let part = |name: &str| ready.split_whitespace().find_map(|part| part.strip_prefix(name));
        let panel =
            part("panel=http://").map_or(SocketAddr::from(([0; 4], 0)), |panel| panel.parse().unwrap());
        let terminal = part("link=").unwrap_or_else(|| panic!("not ready: {ready:?}")).into();
        let metrics =
            part("metrics=http://").map(|url| url.strip_suffix("/metrics").unwrap().parse().unwrap());
        Self { process, panel, metrics, terminal }
    }

    pub(crate) fn terminal(&self) -> &Path {
        &self.terminal
    }

    pub(crate) fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.panel).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// Sends these octets and reads until the end.
    pub(crate) fn raw(&self, octets: &[u8]) -> Answer {
        let mut stream = self.connect();
        // A server that has refused the beginning need not read the rest.
        let _ = stream.write_all(octets);
        Answer::read(stream)
    }

    /// One request with these further lines of the head and this body.
    pub(crate) fn request(&self, method: &str, path: &str, head: &str, body: &str) -> Answer {
        let host = if head.contains("Host:") { String::new() } else { format!("Host: {}\r\n", self.panel) };
        let length = body.len();
        let request = format!(
            "{method} {path} HTTP/1.1\r\n{host}{head}Content-Length: {length}\r\nConnection: close\r\n\r\n{body}"
        );
        self.raw(request.as_bytes())
    }

    /// A request with a body in JSON.
    pub(crate) fn send(&self, method: &str, path: &str, body: &Value) -> Answer {
        self.request(method, path, "Content-Type: application/json\r\n", &body.to_string())
    }

    /// The JSON at a path.
    pub(crate) fn get(&self, path: &str) -> Value {
        let answer = self.request("GET", path, "", "");
        assert_eq!(answer.status, 200, "GET {path}: {}", answer.body);
        answer.json()
    }

    /// Sends what must succeed.
    pub(crate) fn set(&self, method: &str, path: &str, body: &Value) -> Value {
        let answer = self.send(method, path, body);
        assert!(
            (200..300).contains(&answer.status),
            "{method} {path} {body}: {} {}",
            answer.status,
            answer.body
        );
        if answer.body.is_empty() { Value::Null } else { answer.json() }
    }

    /// Looks at the station at address 5 until it is as wanted.
    pub(crate) fn wait_for(&self, what: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        loop {
            let state = self.get("/api/v1/stations/5");
            if wanted(&state) {
                return state;
            }
            assert!(start.elapsed() < PATIENCE, "never {what}: {state}");
        }
    }

    /// Reads the live stream.
    pub(crate) fn stream(&self, query: &str) -> Stream {
        self.connect_stream(query).0
    }

    /// Reads the live stream, of which somebody else can close the socket.
    pub(crate) fn connect_stream(&self, query: &str) -> (Stream, TcpStream) {
        let mut stream = self.connect();
        let socket = stream.try_clone().unwrap();
        write!(stream, "GET /api/v1/events{query} HTTP/1.1\r\nHost: {}\r\n\r\n", self.panel).unwrap();
        let mut stream = BufReader::new(stream);
        let mut line = String::new();
        stream.read_line(&mut line).unwrap();
        assert!(line.starts_with("HTTP/1.1 200"), "{line}");
        (Stream { stream }, socket)
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// What came back.
#[derive(Clone, Debug)]
pub(crate) struct Answer {
    pub(crate) status: u16,
    /// In lower case.
    pub(crate) head: String,
    pub(crate) body: String,
}

impl Answer {
    pub(crate) fn read(mut stream: TcpStream) -> Self {
        let mut octets = Vec::new();
        // The other side may have closed with something of ours unread.
        let _ = stream.read_to_end(&mut octets);
        // A capture is no text.
        let text = String::from_utf8_lossy(&octets);
        let (head, body) = text.split_once("\r\n\r\n").unwrap_or((text.as_ref(), ""));
        let status = head.split_whitespace().nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
        Self { status, head: head.to_ascii_lowercase(), body: body.to_owned() }
    }

    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap_or_else(|error| panic!("{error}: {}", self.body))
    }

    /// The sentence of a refusal.
    pub(crate) fn detail(&self) -> String {
        assert!(self.head.contains("content-type: application/problem+json"), "{self:?}");
        let problem = self.json();
        assert_eq!(problem["status"], json!(self.status));
        problem["detail"].as_str().unwrap().to_owned()
    }
}

/// A live stream.
pub(crate) struct Stream {
    stream: BufReader<TcpStream>,
}

impl Stream {
    /// The next event: its name and its data. `None` at the end.
    pub(crate) fn next(&mut self) -> Option<(String, Value)> {
        let mut event = None;
        loop {
            let mut line = String::new();
            if self.stream.read_line(&mut line).unwrap() == 0 {
                return None;
            }
            if let Some(name) = line.strip_prefix("event: ") {
                event = Some(name.trim().to_owned());
            }
            if let Some(data) = line.strip_prefix("data: ") {
                return Some((event.unwrap(), serde_json::from_str(data).unwrap()));
            }
        }
    }

    /// The next event of this name of which something holds.
    pub(crate) fn find(&mut self, name: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        loop {
            let (event, data) = self.next().expect("the stream ended");
            if event == name && wanted(&data) {
                return data;
            }
            assert!(start.elapsed() < PATIENCE, "no {name} as wanted");
        }
    }
}

/// What the state of a station tells in its lists.
pub(crate) trait State {
    /// The entry of the list whose `key` is this.
    fn entry(&self, list: &str, key: &str, name: &str) -> &Value;

    /// A value by its key.
    fn value(&self, name: &str) -> &Value {
        &self.entry("values", "key", name)["value"]
    }

    /// What acts on it from outside.
    fn input(&self, name: &str) -> &Value {
        &self.entry("inputs", "input", name)["value"]
    }

    /// A fault that can be provoked.
    fn fault(&self, name: &str) -> &Value {
        self.entry("faults", "fault", name)
    }

    /// A word with its bits.
    fn word(&self, name: &str) -> &Value {
        self.entry("words", "key", name)
    }

    /// Words, PDOs, octets of modules.
    fn process(&self, name: &str) -> &Value {
        self.entry("process", "key", name)
    }

    /// A counter by its key.
    fn counter(&self, name: &str) -> &Value {
        &self.entry("counters", "key", name)["value"]
    }

    /// A lamp of its display.
    fn led(&self, name: &str) -> &Value;

    /// A row of its display.
    fn row(&self, place: usize) -> &str;
}

impl State for Value {
    fn entry(&self, list: &str, key: &str, name: &str) -> &Value {
        let entries = self[list].as_array().unwrap_or_else(|| panic!("no {list}: {self}"));
        let found = entries.iter().find(|entry| entry[key] == json!(name));
        found.unwrap_or_else(|| panic!("no {name} in {list}: {}", self[list]))
    }

    fn led(&self, name: &str) -> &Value {
        self["display"].entry("leds", "led", name)
    }

    fn row(&self, place: usize) -> &str {
        self["display"]["rows"][place]["text"].as_str().unwrap_or_default()
    }
}
