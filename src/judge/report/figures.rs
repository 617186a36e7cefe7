//! The figures of the traffic: a line for a terminal, an object in JSON, a table and a plot on the page.

use core::fmt::{self, Write};
use core::time::Duration;

use super::ReportOf;
use crate::judge::figures::{Figures, Part, Spread};
use crate::judge::requirement::Requirement;

/// The plot, in pixels: its size, and where the curves of the cycle and the bars of what was lost are.
const WIDTH: f64 = 1000.0;
const LEFT: f64 = 64.0;
const TOP: f64 = 22.0;
const CYCLE_HEIGHT: f64 = 180.0;
const BARS_TOP: f64 = TOP + CYCLE_HEIGHT + 34.0;
const BARS_HEIGHT: f64 = 70.0;
const HEIGHT: f64 = BARS_TOP + BARS_HEIGHT + 26.0;
/// Lines with a number beside them.
const TICKS: u32 = 4;

/// Milliseconds.
fn millis(time: Duration) -> f64 {
    time.as_secs_f64() * 1000.0
}

impl fmt::Display for Spread {
    /// `2.104 ms (2.001 to 2.990, standard deviation 0.120)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [mean, least, most, deviation] =
            [self.mean(), self.shortest(), self.longest(), self.deviation()].map(millis);
        write!(f, "{mean:.3} ms ({least:.3} to {most:.3}, standard deviation {deviation:.3})")
    }
}

impl<R: Requirement> ReportOf<R> {
    /// The traffic in figures, if a cycle was measured.
    fn traffic(&self) -> Option<&Figures> {
        Some(&self.figures).filter(|figures| figures.cycle_time().count() > 0)
    }

    pub(super) fn write_figures_line(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(figures) = self.traffic() else { return Ok(()) };
        let (retries, losses) = (figures.retries(), figures.losses());
        writeln!(f, "cycle {}, {retries} retries, {losses} stations lost", figures.cycle_time())
    }

    pub(super) fn write_figures_json(&self, text: &mut String) {
        let Some(figures) = self.traffic() else { return };
        let cycle = figures.cycle_time();
        let [mean, least, most, deviation] =
            [cycle.mean(), cycle.shortest(), cycle.longest(), cycle.deviation()].map(millis);
        let _ = writeln!(
            text,
            "\"figures\":{{\"cycles\":{},\"mean_ms\":{mean:.3},\"shortest_ms\":{least:.3},\"longest_ms\":{most:.3},\
             \"deviation_ms\":{deviation:.3},\"retries\":{},\"losses\":{}}},",
            cycle.count(),
            figures.retries(),
            figures.losses()
        );
    }

    pub(super) fn write_figures_page(&self, page: &mut String) {
        let Some(figures) = self.traffic() else { return };
        let _ = write!(
            page,
            "<h2>Traffic</h2>\n<table class=\"configuration\">\n<tbody>\n\
             <tr><th scope=\"row\">cycle</th><td>{}</td></tr>\n\
             <tr><th scope=\"row\">cycles</th><td>{}</td></tr>\n\
             <tr><th scope=\"row\">retries</th><td>{}</td></tr>\n\
             <tr><th scope=\"row\">stations lost</th><td>{}</td></tr>\n</tbody>\n</table>\n",
            figures.cycle_time(),
            figures.cycle_time().count(),
            figures.retries(),
            figures.losses()
        );
        page.push_str("<div class=\"scroll\">\n");
        write_plot(page, figures);
        page.push_str("</div>\n");
    }
}

/// Where things are on the plot.
struct Scale {
    /// The whole time, the longest cycle, and the most retries of a part.
    seconds: f64,
    millis: f64,
    count: f64,
}

impl Scale {
    fn of(figures: &Figures) -> Self {
        let length = figures.part_length().as_secs_f64();
        let seconds = figures.parts().last().map_or(length, |(at, _)| at.as_secs_f64() + length);
        let most = figures.parts().map(|(_, part)| part.retries.max(part.losses)).max().unwrap_or_default();
        let longest = millis(figures.cycle_time().longest()).max(0.001);
        Self { seconds, millis: longest, count: number(most.max(1)) }
    }

    fn x(&self, at: Duration) -> f64 {
        LEFT + at.as_secs_f64() / self.seconds * (WIDTH - LEFT - 12.0)
    }

    fn cycle_y(&self, time: Duration) -> f64 {
        TOP + CYCLE_HEIGHT * (1.0 - millis(time) / self.millis)
    }

    fn bar(&self, count: u64) -> f64 {
        BARS_HEIGHT * number(count) / self.count
    }
}

/// Counts of a plot are small.
fn number(count: u64) -> f64 {
    f64::from(u32::try_from(count).unwrap_or(u32::MAX))
}

/// Over the time: the shortest to the longest cycle as an area, the mean as a line; below, what was repeated and lost.
fn write_plot(page: &mut String, figures: &Figures) {
    let scale = Scale::of(figures);
    let _ = writeln!(
        page,
        "<svg class=\"plot\" role=\"img\" aria-label=\"Cycle, retries and lost stations over the time\" \
         viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" xmlns=\"http://www.w3.org/2000/svg\">"
    );
    let _ = writeln!(
        page,
        "<text x=\"0\" y=\"12\">cycle in ms: mean, shortest to longest</text>\n\
         <text x=\"0\" y=\"{:.0}\">in {} s each: retries, <tspan class=\"loss\">lost stations</tspan></text>",
        BARS_TOP - 10.0,
        figures.part_length().as_secs_f64()
    );
    for tick in 0..=TICKS {
        let share = f64::from(tick) / f64::from(TICKS);
        let y = TOP + CYCLE_HEIGHT * (1.0 - share);
        let _ = writeln!(
            page,
            "<path class=\"axis\" d=\"M{LEFT} {y:.1}H{:.0}\"/><text class=\"y\" x=\"{:.0}\" y=\"{:.1}\">{:.2}</text>\
             <text class=\"x\" x=\"{:.1}\" y=\"{:.0}\">{:.0} s</text>",
            WIDTH - 12.0,
            LEFT - 6.0,
            y + 4.0,
            share * scale.millis,
            scale.x(Duration::from_secs_f64(share * scale.seconds)),
            HEIGHT - 6.0,
            share * scale.seconds
        );
    }
    let _ = writeln!(
        page,
        "<path class=\"axis\" d=\"M{LEFT} {0:.0}H{1:.0}\"/><text class=\"y\" x=\"{2:.0}\" y=\"{3:.0}\">{4}</text>",
        BARS_TOP + BARS_HEIGHT,
        WIDTH - 12.0,
        LEFT - 6.0,
        BARS_TOP + 10.0,
        scale.count
    );
    write_curves(page, figures, &scale);
    write_bars(page, figures, &scale);
    page.push_str("</svg>\n");
}

/// The parts of the time in which a cycle was measured.
fn measured(figures: &Figures) -> impl DoubleEndedIterator<Item = (Duration, &Part)> {
    let measured: Vec<_> = figures.parts().filter(|(_, part)| part.cycle.count() > 0).collect();
    measured.into_iter()
}

fn write_curves(page: &mut String, figures: &Figures, scale: &Scale) {
    let middle = figures.part_length() / 2;
    let point =
        |at: Duration, time: Duration| format!("{:.1},{:.1} ", scale.x(at + middle), scale.cycle_y(time));
    let line = |time: fn(&Spread) -> Duration| -> String {
        measured(figures).map(|(at, part)| point(at, time(&part.cycle))).collect()
    };
    let back: String = measured(figures).rev().map(|(at, part)| point(at, part.cycle.shortest())).collect();
    let _ = writeln!(page, "<polygon class=\"spread\" points=\"{}{back}\"/>", line(Spread::longest));
    let _ = writeln!(page, "<polyline class=\"mean\" points=\"{}\"/>", line(Spread::mean));
}

fn write_bars(page: &mut String, figures: &Figures, scale: &Scale) {
    let width = (scale.x(figures.part_length()) - LEFT).max(1.0);
    for (at, part) in figures.parts() {
        for (class, count) in [("retry", part.retries), ("loss", part.losses)] {
            if count > 0 {
                let (x, height) = (scale.x(at), scale.bar(count));
                let y = BARS_TOP + BARS_HEIGHT - height;
                let _ = writeln!(
                    page,
                    "<rect class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
                );
            }
        }
    }
}
