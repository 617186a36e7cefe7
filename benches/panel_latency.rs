//! What the panel costs a master: reply latency over the pseudo-terminal, paired runs without and with the panel open.
//!
//! Two emulators run side by side, one without a panel and one with a panel, its page open in three browsers (Chromium,
//! headless) and a reader of the stream that never reads. The master measures in many short blocks, the order turned
//! round each time, so that what the machine does meanwhile hits all alike:
//!
//! | block | emulator | browsers |
//! | --- | --- | --- |
//! | alone | without panel | stopped |
//! | beside | without panel | running: what three browsers on this machine cost any program |
//! | watched | with panel | running: what the panel costs on top of that |
//!
//! An exchange begins every 1.2 ms, as long as one takes on a line of 500 kbit/s. Without Chromium (`CHROMIUM` names
//! another than `/usr/bin/chromium`) three readers of what the page reads stand in for the browsers.
//!
//! ```text
//! cargo bench --features cli --bench panel_latency [ROUNDS]
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
#[path = "../tests/helpers/drive_line.rs"]
mod drive_line;
#[cfg(target_os = "linux")]
#[path = "../tests/helpers/panel.rs"]
mod panel;
#[path = "../tests/helpers/patience.rs"]
mod patience;
#[cfg(target_os = "linux")]
#[path = "../tests/helpers/pty.rs"]
mod pty;
#[cfg(target_os = "linux")]
#[path = "../tests/helpers/telegrams.rs"]
mod telegrams;
#[cfg(target_os = "linux")]
#[path = "panel_latency/watchers.rs"]
mod watchers;

#[cfg(target_os = "linux")]
fn main() {
    use std::thread;
    use std::time::{Duration, Instant};

    use panel::Emulator;
    use profidrive::profibus::ppo::{Outputs, Pkw, Stw};
    use pty::Master;
    use watchers::Watchers;

    /// Data_Exchange of 14 octets both ways at 500 kbit/s, with T_SYN and T_SDR.
    const PERIOD: Duration = Duration::from_micros(1200);
    const EXCHANGES: u32 = 400;
    const BLOCKS: [&str; 3] = ["alone", "beside", "watched"];

    fn measure(master: &mut Master) -> Vec<f64> {
        let outputs = Outputs::octets(Pkw::ZERO, Stw::from_raw(0x003B), 0);
        let mut next = Instant::now();
        (0..EXCHANGES)
            .map(|_| {
                next += PERIOD;
                thread::sleep(next.saturating_duration_since(Instant::now()));
                let begin = Instant::now();
                master.exchange(&outputs).unwrap();
                begin.elapsed().as_secs_f64() * 1e6
            })
            .collect()
    }

    fn quantile(values: &mut [f64], part: f64) -> f64 {
        values.sort_by(f64::total_cmp);
        values[(part * (values.len() - 1) as f64) as usize]
    }

    // A bench is run with `--bench`, and by `cargo test` without.
    let rounds = std::env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(30);
    let plain = Emulator::without_panel();
    let watched = Emulator::start();
    let mut masters = [Master::open(plain.terminal()), Master::open(watched.terminal())];
    // Somebody there to be seen, before the pages open.
    masters.iter_mut().for_each(|master| drop(measure(master)));
    let _unread = watched.stream("?address=5&kinds=state,news,telegram");
    let mut watchers = Watchers::open(&watched);
    let mut times: [Vec<f64>; 3] = Default::default();
    let (mut beside_alone, mut watched_beside) = (Vec::new(), Vec::new());
    for round in 0..rounds {
        let mut medians = [0.0; 3];
        let order = if round % 2 == 0 { [0, 1, 2] } else { [2, 1, 0] };
        for block in order {
            watchers.run(block > 0);
            let mut of_block = measure(&mut masters[block / 2]);
            medians[block] = quantile(&mut of_block, 0.5);
            times[block].append(&mut of_block);
        }
        beside_alone.push(medians[1] / medians[0]);
        watched_beside.push(medians[2] / medians[1]);
    }
    println!("the panel open in {watchers}, and a reader of the stream that never reads; {rounds} rounds");
    for (name, times) in BLOCKS.into_iter().zip(&mut times) {
        let [median, most, worst] = [0.5, 0.99, 0.999].map(|part| quantile(times, part));
        println!(
            "{name:<8} median {median:7.1} us   99 % {most:7.1} us   99.9 % {worst:8.1} us   n {}",
            times.len()
        );
    }
    for (name, ratios) in [("beside / alone", beside_alone), ("watched / beside", watched_beside)] {
        let [low, median, high] = [0.25, 0.5, 0.75].map(|part| quantile(&mut ratios.clone(), part));
        println!("ratio of medians, {name:<16} median {median:.3}, quartiles {low:.3} to {high:.3}");
    }
}

#[cfg(not(target_os = "linux"))]
fn main() {
    println!("pseudo-terminals need Linux");
}
