//! A position over time as a small chart of block characters.

use core::fmt::Write;

use crate::time::Instant;

/// Columns of the plot; with the labels it fits 80.
const WIDTH: usize = 64;
/// Rows of the plot.
const HEIGHT: usize = 9;
/// Parts of a cell that the block characters can fill.
const EIGHTHS: usize = 8;
const BLOCKS: [char; EIGHTHS + 1] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// Positions as they were seen, and what happened meanwhile.
#[derive(Default)]
pub(super) struct Recording {
    samples: Vec<(Instant, i32)>,
    marks: Vec<(Instant, &'static str)>,
}

impl Recording {
    /// `position` was seen at `at`, later than everything before.
    pub(super) fn sample(&mut self, at: Instant, position: i32) {
        self.samples.push((at, position));
    }

    /// At `at` something happened that one short word names.
    pub(super) fn mark(&mut self, at: Instant, name: &'static str) {
        self.marks.push((at, name));
    }

    /// The chart, line by line; nothing without samples.
    pub(super) fn lines(&self) -> Vec<String> {
        let (Some((begin, _)), Some((end, _))) = (self.samples.first(), self.samples.last()) else {
            return Vec::new();
        };
        let lowest = self.samples.iter().map(|sample| sample.1).min().unwrap_or_default();
        let highest = self.samples.iter().map(|sample| sample.1).max().unwrap_or_default();
        let duration = millis(*begin, *end).max(1);
        let heights: Vec<usize> = (0..WIDTH)
            .map(|column| self.position(*begin, duration, column))
            .map(|position| height(position, lowest, highest))
            .collect();
        let mut lines: Vec<String> = (0..HEIGHT)
            .rev()
            .map(|row| {
                let label = match row {
                    0 => format!("{lowest:>9}"),
                    _ if row == HEIGHT - 1 => format!("{highest:>9}"),
                    _ => " ".repeat(9),
                };
                let bar: String = heights.iter().map(|height| block(*height, row)).collect();
                format!("{label} |{bar}").trim_end().into()
            })
            .collect();
        lines.extend(self.axis(*begin, duration));
        lines
    }

    /// The position at the middle of a column: the last seen by then.
    fn position(&self, begin: Instant, duration: usize, column: usize) -> i32 {
        let middle = (2 * column + 1) * duration / (2 * WIDTH);
        let seen = self.samples.iter().take_while(|(at, _)| millis(begin, *at) <= middle);
        seen.last().or(self.samples.first()).map_or(0, |sample| sample.1)
    }

    /// The line under the plot, and the lines with seconds and marks.
    fn axis(&self, begin: Instant, duration: usize) -> [String; 3] {
        let column = |millis: usize| (millis * WIDTH / duration).min(WIDTH - 1);
        let mut seconds = Row::default();
        for second in 0..=duration / 1000 {
            seconds.write(column(second * 1000), &format!("{second} s"));
        }
        let mut marks = Row::default();
        let mut ticks = vec!['-'; WIDTH];
        for (at, name) in &self.marks {
            let column = column(millis(begin, *at));
            marks.write(column, &format!("^{name}"));
            if let Some(tick) = ticks.get_mut(column) {
                *tick = '+';
            }
        }
        let ticks: String = ticks.into_iter().collect();
        [format!("{:>10}+{ticks}", ""), format!("{:>11}{}", "", marks.0), format!("{:>11}{}", "", seconds.0)]
    }
}

/// A line written from left to right; what would touch an earlier word is left out.
#[derive(Default)]
struct Row(String);

impl Row {
    fn write(&mut self, column: usize, word: &str) {
        let used = self.0.chars().count();
        if used > 0 && used >= column || column + word.chars().count() > WIDTH + 4 {
            return;
        }
        // Writing to a string does not fail.
        let _ = write!(self.0, "{:1$}{word}", "", column - used);
    }
}

/// How high a position is, in eighths of a row, at least one so that the line is seen.
fn height(position: i32, lowest: i32, highest: i32) -> usize {
    let range = highest.abs_diff(lowest).max(1);
    let full = u64::from(position.abs_diff(lowest)) * (HEIGHT * EIGHTHS - 1) as u64;
    let eighths = usize::try_from(full / u64::from(range)).unwrap_or_default();
    eighths + 1
}

/// What a bar of this height looks like in a row, row 0 at the bottom.
fn block(height: usize, row: usize) -> char {
    let filled = height.saturating_sub(row * EIGHTHS).min(EIGHTHS);
    BLOCKS.get(filled).copied().unwrap_or(' ')
}

fn millis(begin: Instant, at: Instant) -> usize {
    usize::try_from(at.saturating_since(begin).as_millis()).unwrap_or(usize::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_rises_from_the_lower_left_to_the_upper_right() {
        let mut recording = Recording::default();
        for step in 0..=100_i32 {
            recording.sample(Instant::from_millis(step.unsigned_abs().into()), (2 * step).min(100) - 50);
        }
        recording.mark(Instant::from_millis(50), "half");
        let lines = recording.lines();
        assert_eq!(lines.len(), HEIGHT + 3);
        assert!(lines[0].starts_with("       50 |") && lines[0].ends_with('█'), "{}", lines[0]);
        assert!(lines[HEIGHT - 1].starts_with("      -50 |▁"), "{}", lines[HEIGHT - 1]);
        assert_eq!(lines[HEIGHT + 1].find("^half"), Some(11 + 32));
        assert!(lines.iter().all(|line| line.chars().count() <= 80), "{lines:#?}");
    }

    #[test]
    fn extremes_and_nothing_are_drawn_too() {
        assert!(Recording::default().lines().is_empty());
        let mut recording = Recording::default();
        recording.sample(Instant::ZERO, i32::MIN);
        recording.sample(Instant::from_millis(1), i32::MAX);
        recording.mark(Instant::from_millis(9), "late");
        assert_eq!(recording.lines().len(), HEIGHT + 3);
        let mut still = Recording::default();
        still.sample(Instant::ZERO, 7);
        assert_eq!(still.lines()[0].trim(), "7 |");
    }
}
