//! The reports of a judgement: JUnit that CI reads, a page that needs nothing else, docs that name every row.

use profidrive::judge::rows::{Confidence, Place};
use profidrive::judge::{Row, Verdict};
use roxmltree::{Document, Node};

use crate::virtual_time::failed;

fn named<'a, 'i>(document: &'a Document<'i>, name: &'a str) -> impl Iterator<Item = Node<'a, 'i>> {
    document.descendants().filter(move |node| node.has_tag_name(name))
}

#[test]
fn junit_is_well_formed_and_counts_every_row() {
    let report = failed();
    let text = report.junit();
    let document = Document::parse(&text).unwrap();
    let root = document.root_element();
    let count = |name: &str| root.attribute(name).unwrap().parse::<usize>().unwrap();
    // One more says that the judgement came to its end.
    assert_eq!((count("tests"), count("errors")), (Row::ALL.len() + 1, 0));
    assert_eq!(count("failures"), report.count(Verdict::Fail));
    assert_eq!(count("skipped"), report.count(Verdict::NotJudged));
    assert_eq!(named(&document, "testcase").count(), Row::ALL.len() + 1);
    assert_eq!(named(&document, "skipped").count(), report.count(Verdict::NotJudged));
    assert_eq!(named(&document, "failure").count(), report.count(Verdict::Fail));
    let property = |name: &str| {
        let mut properties = named(&document, "property");
        properties
            .find(|node| node.attribute("name") == Some(name))
            .unwrap()
            .attribute("value")
            .unwrap()
            .to_owned()
    };
    assert_eq!(property("station"), "5,ident=1234,cfg=2313,prm=0102,groups=01");
    assert_eq!((property("slot"), property("retries")), ("0.6".into(), "2".into()));
    for failure in named(&document, "failure") {
        assert!(failure.text().unwrap().starts_with("while: "), "{failure:?}");
        assert!(failure.text().unwrap().contains('['), "{failure:?}");
    }
    let seconds = |node: Node| node.attribute("time").unwrap().parse::<f64>().unwrap();
    assert!((seconds(root) - report.took.as_secs_f64()).abs() < 0.001, "{}", report.took.as_secs_f64());
    let retries =
        named(&document, "testcase").find(|case| case.attribute("name").unwrap().starts_with("M-C03"));
    assert!((0.001..seconds(root)).contains(&seconds(retries.unwrap())));
    let of_suites: usize = named(&document, "testsuite")
        .map(|suite| suite.attribute("tests").unwrap().parse::<usize>().unwrap())
        .sum();
    assert_eq!(of_suites, Row::ALL.len() + 1);
}

#[test]
fn the_page_needs_nothing_else_and_draws_each_failure() {
    let report = failed();
    let page = report.html("A <master> & \"its\" stations");
    let begin = page.find("<html").unwrap();
    let document = Document::parse(&page[begin..]).unwrap();
    assert!(page.contains("<th scope=\"row\">station</th><td><code>5,ident=1234,cfg=2313,"), "{page}");
    assert!(page.contains("<p>While: "), "{page}");
    assert!(page.contains("@media print"), "{page}");
    assert_eq!(named(&document, "script").count() + named(&document, "link").count(), 0);
    for node in document.descendants() {
        for attribute in node.attributes() {
            let loads = matches!(attribute.name(), "src" | "href") && !attribute.value().starts_with('#');
            assert!(!loads, "{}", attribute.value());
        }
    }
    assert!(!page.contains("url(") && !page.contains("@import"));
    let drawings = named(&document, "svg").filter(|node| node.attribute("class") == Some("bus")).count();
    let shown = report.judgements.iter().filter(|judgement| !judgement.telegrams.is_empty()).count();
    assert_eq!(drawings, shown);
    for judgement in report.judgements.iter().filter(|judgement| judgement.verdict == Verdict::Fail) {
        let section = named(&document, "section")
            .find(|node| node.attribute("id") == Some(judgement.row.id()))
            .unwrap();
        let telegrams = section.descendants().filter(|node| node.tag_name().name() == "title").count();
        assert_eq!(telegrams, judgement.telegrams.len());
    }
    assert_eq!(
        document.descendants().find(|node| node.has_tag_name("h1")).unwrap().text(),
        Some("A <master> & \"its\" stations")
    );
}

#[test]
fn the_manual_has_every_row() {
    let (_, manual) = include_str!("../../docs/judge.md").split_once("## Every row").unwrap();
    for row in Row::ALL {
        let about = row.about();
        let places: Vec<_> = about.places.iter().map(|place| words(*place)).collect();
        let confidence = match about.confidence {
            Confidence::A => "A",
            Confidence::B => "B",
            Confidence::C => "C",
            Confidence::U => "U",
        };
        let places = if places.is_empty() { "never".into() } else { places.join(", ") };
        let line =
            format!("| {} | {} | {confidence} | {places} | {} |", about.id, about.priority, about.text);
        assert!(manual.lines().any(|written| written == line), "docs/judge.md has not:\n{line}");
    }
    assert_eq!(manual.lines().filter(|line| line.starts_with("| M-")).count(), Row::ALL.len());
}

const fn words(place: Place) -> &'static str {
    match place {
        Place::Pty => "any link",
        Place::Margin => "any link, wide margin",
        Place::Serial => "real line",
        Place::Virtual => "virtual time",
        Place::Ask => "`--ask`",
    }
}
