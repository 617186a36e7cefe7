//! What is noticed of a row while others are judged.

use crate::map::Map;

use crate::judge::moment::Telegram;

/// Occasions, and the first breach, by row.
#[derive(Debug, Default)]
pub(super) struct Notes {
    occasions: Map<&'static str, u32>,
    breaches: Map<&'static str, Breach>,
}

#[derive(Clone, Debug)]
struct Breach {
    why: String,
    shown: Vec<Telegram>,
    times: u32,
}

impl Notes {
    /// An occasion to judge a row.
    pub(super) fn occasion(&mut self, row: &'static str) {
        *self.occasions.or_default(row) += 1;
    }

    /// How many there were.
    pub(super) fn occasions(&self, row: &'static str) -> u32 {
        self.occasions.get(row).copied().unwrap_or_default()
    }

    /// A row is broken.
    pub(super) fn breach(&mut self, row: &'static str, why: impl FnOnce() -> (String, Vec<Telegram>)) {
        if let Some(breach) = self.breaches.get_mut(row) {
            breach.times += 1;
        } else {
            let (why, shown) = why();
            self.breaches.insert(row, Breach { why, shown, times: 1 });
        }
    }

    /// What is held against a row that is broken at least so many times.
    pub(super) fn against(&self, row: &str, least: u32) -> Option<(String, Vec<Telegram>)> {
        let breach = self.breaches.get(row).filter(|breach| breach.times >= least)?;
        let times = if breach.times > 1 { format!(" ({} times)", breach.times) } else { String::new() };
        Some((format!("{}{times}", breach.why), breach.shown.clone()))
    }
}
