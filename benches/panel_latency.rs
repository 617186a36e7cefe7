//! What the panel costs a master: reply latency over the pseudo-terminal, paired runs without and with readers.
//!
//! Two emulators run side by side, one without a panel and one with a panel, a page open in three browsers (each reads
//! states, news and telegrams) and a reader of the stream that never reads. The master measures one, then the other,
//! in many short blocks, the order turned round each time, so that what the machine does meanwhile hits both alike.
//! An exchange begins every 1.2 ms, as long as one takes on a line of 500 kbit/s.
//!
//! ```text
//! cargo bench --features cli --bench panel_latency [BLOCKS]
//! ```
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::std_instead_of_core,
    clippy::wildcard_enum_match_arm,
    reason = "a bench may panic, and has std"
)]

#[cfg(target_os = "linux")]
#[path = "../tests/common/mod.rs"]
mod common;
#[cfg(target_os = "linux")]
#[path = "../tests/panel/mod.rs"]
mod panel;
#[cfg(target_os = "linux")]
#[path = "../tests/common/pty.rs"]
mod pty;

#[cfg(target_os = "linux")]
fn main() {
    use std::io::Read;
    use std::net::TcpStream;
    use std::thread;
    use std::time::{Duration, Instant};

    use panel::Emulator;
    use profidrive::ppo::{Outputs, Pkw, Stw};
    use pty::Master;

    /// Data_Exchange of 14 octets both ways at 500 kbit/s, with T_SYN and T_SDR.
    const PERIOD: Duration = Duration::from_micros(1200);
    const EXCHANGES: u32 = 400;
    /// A page: it asks for everything and reads it.
    const PAGE: &str = "?address=5&kinds=state,news,telegram";

    fn measure(master: &mut Master, times: &mut Vec<Duration>) {
        let outputs = Outputs::octets(Pkw::ZERO, Stw::from_raw(0x003B), 0);
        let mut next = Instant::now();
        for _ in 0..EXCHANGES {
            next += PERIOD;
            thread::sleep(next.saturating_duration_since(Instant::now()));
            let begin = Instant::now();
            master.exchange(&outputs).unwrap();
            times.push(begin.elapsed());
        }
    }

    /// Reads and does nothing with it: what a browser makes of it is not the emulator's doing.
    fn read(mut page: TcpStream) {
        thread::spawn(move || while page.read(&mut [0; 65536]).is_ok_and(|count| count > 0) {});
    }

    fn quantile(times: &mut [Duration], part: f64) -> f64 {
        times.sort_unstable();
        let index = (part * (times.len() - 1) as f64) as usize;
        times[index].as_secs_f64() * 1e6
    }

    // A bench is run with `--bench`, and by `cargo test` without.
    let blocks = std::env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(30);
    let plain = Emulator::without_panel();
    let watched = Emulator::start();
    let mut masters = [Master::open(plain.terminal()), Master::open(watched.terminal())];
    let mut times = [Vec::new(), Vec::new()];
    let (mut medians, mut unread) = (Vec::new(), None);
    for block in 0..blocks {
        let mut of_block = [0.0; 2];
        let order = if block % 2 == 0 { [0, 1] } else { [1, 0] };
        for which in order {
            let pages: Vec<_> =
                if which == 1 { (0..3).map(|_| watched.connect_stream(PAGE)).collect() } else { Vec::new() };
            let sockets: Vec<_> = pages.into_iter().map(|(_, socket)| socket).collect();
            for socket in &sockets {
                read(socket.try_clone().unwrap());
            }
            if which == 1 {
                unread.get_or_insert_with(|| watched.stream(PAGE));
            }
            let mut block_times = Vec::new();
            measure(&mut masters[which], &mut block_times);
            of_block[which] = quantile(&mut block_times, 0.5);
            times[which].append(&mut block_times);
            for socket in sockets {
                let _ = socket.shutdown(std::net::Shutdown::Both);
            }
        }
        medians.push(of_block[1] / of_block[0]);
    }
    for (name, times) in ["without panel", "with panel, 3 pages, 1 unread stream"].into_iter().zip(&mut times)
    {
        let [median, most, worst] = [0.5, 0.99, 0.999].map(|part| quantile(times, part));
        println!(
            "{name:<37} median {median:7.1} us   99 % {most:7.1} us   99.9 % {worst:8.1} us   n {}",
            times.len()
        );
    }
    medians.sort_by(f64::total_cmp);
    let at = |part: f64| medians[(part * (medians.len() - 1) as f64) as usize];
    println!(
        "ratio of medians in {blocks} pairs of blocks: median {:.3}, quartiles {:.3} to {:.3}",
        at(0.5),
        at(0.25),
        at(0.75)
    );
}

#[cfg(not(target_os = "linux"))]
fn main() {
    println!("pseudo-terminals need Linux");
}
