//! One page for people: what failed first, with a diagram of the telegrams; then every row. No script, nothing loaded.

use core::fmt::Write;

use super::markup::Text;
use super::{PROGRAM, ReportOf};
use crate::judge::requirement::Requirement;
use crate::judge::verdict::{JudgementOf, Verdict};

/// Its style, with colours for light and dark.
const STYLE: &str = include_str!("page.css");

impl<R: Requirement> ReportOf<R> {
    /// The report as one HTML page that needs nothing else. `subject` is what was judged, as the page names it.
    pub fn html(&self, subject: &str) -> String {
        let mut page =
            String::from("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n");
        page.push_str("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n");
        let _ = write!(
            page,
            "<title>Judgement: {}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n",
            Text(subject)
        );
        self.write_summary(&mut page, subject);
        for (verdict, title) in [(Verdict::Fail, "Failures"), (Verdict::Warn, "Warnings")] {
            if self.count(verdict) > 0 {
                let _ = writeln!(page, "<h2>{title}</h2>");
            }
            for judgement in self.judgements.iter().filter(|judgement| judgement.verdict == verdict) {
                self.write_finding(&mut page, judgement);
            }
        }
        self.write_figures_page(&mut page);
        self.write_rows(&mut page);
        let _ = writeln!(
            page,
            "<footer>profidrive {} judge</footer>\n</body>\n</html>",
            env!("CARGO_PKG_VERSION")
        );
        page
    }

    fn write_summary(&self, page: &mut String, subject: &str) {
        let _ = writeln!(page, "<h1>{}</h1>\n<p class=\"counts\">", Text(subject));
        for (verdict, words) in [
            (Verdict::Fail, "failed"),
            (Verdict::Warn, "warnings"),
            (Verdict::Pass, "passed"),
            (Verdict::NotJudged, "not judged"),
        ] {
            let _ =
                writeln!(page, "<span class=\"{}\">{} {words}</span>", verdict.name(), self.count(verdict));
        }
        page.push_str("</p>\n");
        let _ = writeln!(page, "<p>Ended: {}.</p>", Text(&std::format!("{}", self.ending)));
        if let Some(date) = &self.date {
            let took = self.took.as_secs_f64();
            let _ = writeln!(page, "<p>{}, {PROGRAM}, {took:.1} s</p>", Text(date));
        }
        page.push_str("<table class=\"configuration\">\n<tbody>\n");
        for (name, value) in &self.configuration {
            let _ =
                writeln!(page, "<tr><th scope=\"row\">{name}</th><td><code>{}</code></td></tr>", Text(value));
        }
        page.push_str("</tbody>\n</table>\n");
        if let Some(trouble) = self.outcome().trouble() {
            let _ =
                writeln!(page, "<p class=\"fail\">No verdict on the {}: {}.</p>", R::SUBJECT, Text(trouble));
        }
    }

    fn write_finding(&self, page: &mut String, judgement: &JudgementOf<R>) {
        let JudgementOf { row, verdict, reason, telegrams, scenario, .. } = judgement;
        let _ = writeln!(
            page,
            "<section id=\"{id}\" class=\"{class}\">\n<h3><span class=\"{class}\">{class}</span> {id} {text}</h3>\n<p>{reason}</p>",
            id = row.id(),
            class = verdict.name(),
            text = Text(row.text()),
            reason = Text(reason)
        );
        if let Some(rule) = row.rule() {
            let _ = writeln!(page, "<p>The rule: {}</p>", Text(rule));
        }
        if let Some(scenario) = scenario {
            let _ = writeln!(page, "<p>While: {}.</p>", Text(scenario));
        }
        if !telegrams.is_empty() {
            let _ = writeln!(page, "<div class=\"scroll\">\n{}</div>", self.diagram(row.id(), telegrams));
        }
        page.push_str("</section>\n");
    }

    fn write_rows(&self, page: &mut String) {
        page.push_str("<h2>Every row</h2>\n<table>\n<tbody>\n");
        let mut group = None;
        for JudgementOf { row, verdict, reason, telegrams, .. } in &self.judgements {
            if group.replace(row.group()) != Some(row.group()) {
                let _ = writeln!(
                    page,
                    "<tr><th colspan=\"3\" scope=\"colgroup\">{}</th></tr>",
                    Text(row.group())
                );
            }
            let class = verdict.name();
            let id = if telegrams.is_empty() {
                row.id().into()
            } else {
                std::format!("<a href=\"#{0}\">{0}</a>", row.id())
            };
            let _ = writeln!(
                page,
                "<tr><td><span class=\"{class}\">{}</span></td><td>{id}</td><td>{}<br/><small>{}</small></td></tr>",
                class.replace('_', " "),
                Text(row.text()),
                Text(reason)
            );
        }
        page.push_str("</tbody>\n</table>\n");
    }
}
