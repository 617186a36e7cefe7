//! Masters in Data_Exchange beside clients that stall, flood and send noise.

use super::*;

/// A master with one drive, which filters by address what it hears.
struct Master {
    client: Client,
    own: u8,
    slave: u8,
    count: FrameCount,
    heard: Vec<u8>,
}

impl Master {
    fn new(address: SocketAddr, own: u8, slave: u8) -> Self {
        Self { client: Client::connect(address), own, slave, count: FrameCount::First, heard: Vec::new() }
    }

    fn request(&mut self, dsap: Option<u8>, data: &[u8]) {
        let fc = FunctionCode::request(Service::SrdHigh, self.count);
        self.count = match self.count {
            FrameCount::Even => FrameCount::Odd,
            FrameCount::First | FrameCount::Odd | FrameCount::Unused => FrameCount::Even,
        };
        self.client.write(&telegram(self.slave, self.own, fc, dsap, data));
    }

    /// The data of the next reply from our slave to us.
    fn reply(&mut self) -> Vec<u8> {
        loop {
            while let Decoded::Telegram { telegram, len } = decode(&self.heard) {
                let (own, slave) = (self.own, self.slave);
                let data = match telegram {
                    Telegram::Data(t) if t.da.number() == own && t.sa.number() == slave => {
                        Some(t.data.to_vec())
                    }
                    _ => None,
                };
                self.heard.drain(..len);
                if let Some(data) = data {
                    return data;
                }
            }
            assert!(!matches!(decode(&self.heard), Decoded::Invalid { .. }), "{:02X?}", self.heard);
            let mut buf = [0; 4096];
            let count = self.client.0.read(&mut buf).unwrap();
            assert!(count > 0, "master {} was dropped", self.own);
            self.heard.extend_from_slice(&buf[..count]);
        }
    }

    /// SC is anybody's: the diagnosis says what came of Set_Prm and Chk_Cfg.
    fn start_up(&mut self) {
        let prm = [0x88, 250, 100, 11, IDENT[0], IDENT[1], 0];
        for (dsap, data) in [(61, &prm[..]), (62, &CFG[..])] {
            self.request(Some(dsap), data);
            self.request(Some(60), &[]);
            self.reply();
        }
        self.request(Some(60), &[]);
        assert_eq!(self.reply()[..4], [0, 0x0C, 0, self.own]);
    }

    fn exchange(&mut self) {
        self.request(None, &[0; 14]);
        assert_eq!(self.reply().len(), 14);
    }
}

fn with_drives(addresses: &[u8], play: impl FnOnce(SocketAddr)) {
    let mut tcp = bind();
    let address = tcp.address();
    let stop = Stop::new().unwrap();
    let addresses = addresses.to_vec();
    thread::scope(|scope| {
        let ending = stop.clone();
        scope.spawn(move || {
            let clock = SystemClock::new();
            let mut bus = Bus::new();
            for number in addresses {
                let config = Config::new(Address::station(number).unwrap());
                bus.add(Device::new(config, clock.now())).unwrap();
            }
            run(&mut tcp, &mut bus, &clock, &ending, &mut |_| {}).unwrap();
        });
        let _ending = Ending(stop);
        play(address);
    });
}

/// How long the stall lasts; the minute with `PROFIDRIVE_STALL_MS=60000`.
fn stall() -> Duration {
    let millis = std::env::var("PROFIDRIVE_STALL_MS").ok().and_then(|millis| millis.parse().ok());
    Duration::from_millis(millis.unwrap_or(500))
}

#[test]
fn two_masters_share_the_line_and_one_that_stalls_does_not_delay_the_other() {
    with_drives(&[5, 6], |address| {
        let (mut a, mut b) = (Master::new(address, 2, 5), Master::new(address, 3, 6));
        a.start_up();
        b.start_up();
        // Both at once.
        thread::scope(|scope| {
            for master in [&mut a, &mut b] {
                scope.spawn(move || (0..300).for_each(|_| master.exchange()));
            }
        });
        // One stalls in the middle of a telegram, and reads nothing.
        a.client.write(&[0x68, 0x11, 0x11, 0x68, 5]);
        let (start, mut took) = (Instant::now(), Vec::new());
        while start.elapsed() < stall() || took.len() < 21 {
            let asked = Instant::now();
            b.exchange();
            took.push(asked.elapsed());
            thread::sleep(Duration::from_millis(1));
        }
        took.sort_unstable();
        // A busy machine delays some of them; what waits for the rest of the telegram waits 50 ms each time.
        let usual = took[took.len() / 2];
        assert!(usual < Duration::from_millis(50), "{usual:?}");
        println!("{} exchanges beside a stalled master, usually in {usual:?}", took.len());
    });
}

#[test]
fn a_master_exchanges_data_beside_resets_floods_and_a_hundred_connections() {
    with_drives(&[5], |address| {
        let mut master = Master::new(address, 2, 5);
        master.start_up();
        let mut others = Vec::new();
        for round in 0..100 {
            let mut other = Client::connect(address);
            // It may be turned away already.
            let _ = other.0.write(&[round; 300]);
            match round % 3 {
                0 => drop(other),
                1 => others.push(other),
                _ => {
                    other.0.set_nonblocking(true).unwrap();
                    while matches!(other.0.write(&[0x10; 65536]), Ok(1..)) {}
                    others.push(other);
                }
            }
            master.heard.clear();
            master.request(None, &[0; 14]);
            // Noise of the others lies between the telegrams.
            let start = Instant::now();
            let own = [0x68, 0x11, 0x11, 0x68, 2, 5, 0x08];
            while !master.heard.windows(7).any(|octets| octets == own) {
                let mut buf = [0; 65536];
                let count = master.client.0.read(&mut buf).unwrap();
                assert!(count > 0, "the master was dropped");
                master.heard.extend_from_slice(&buf[..count]);
                assert!(start.elapsed() < PATIENCE, "round {round}");
            }
        }
    });
}

/// Octets without pattern, the same in every run.
struct Noise(u64);

impl Noise {
    fn octets(&mut self, count: usize) -> Vec<u8> {
        let mut next = || {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            self.0.to_le_bytes()[4]
        };
        (0..count).map(|_| next()).collect()
    }
}

/// Octets before and behind each of 2000 requests: as many as nobody is dropped for, however fast the exchanges are.
const NOISE: usize = 64;
const _: () = assert!(2000 * 2 * NOISE < MAX_BURST as usize);

/// Chance start delimiters, tokens and SC among them, before, behind and instead of what others say.
#[test]
fn every_request_is_answered_beside_a_client_that_sends_random_octets() {
    with_drives(&[5], |address| {
        let mut master = Master::new(address, 2, 5);
        master.start_up();
        master.client.0.set_read_timeout(Some(PATIENCE)).unwrap();
        let (mut flooder, mut noise) = (Client::connect(address), Noise(0x9E37_79B9_7F4A_7C15));
        let own = [0x68, 0x11, 0x11, 0x68, 2, 5, 0x08];
        let (mut unanswered, mut most) = (0, 0);
        for _ in 0..2000 {
            flooder.write(&noise.octets(NOISE));
            master.heard.clear();
            master.request(None, &[0; 14]);
            flooder.write(&noise.octets(NOISE));
            let reply_at = loop {
                let heard = &master.heard;
                if let Some(at) = heard.windows(7).position(|octets| octets == own) {
                    break Some(at);
                }
                let mut buf = [0; 65536];
                match master.client.0.read(&mut buf) {
                    Ok(count) => master.heard.extend_from_slice(&buf[..count]),
                    Err(_) => break None,
                }
            };
            unanswered += usize::from(reply_at.is_none());
            most = most.max(reply_at.unwrap_or_default());
        }
        assert_eq!(unanswered, 0, "of 2000 requests");
        // One turn of the other, and what it had said before the request came.
        assert!(most <= 2 * 4096 + 2 * NOISE, "{most} octets of noise before a reply");
    });
}
