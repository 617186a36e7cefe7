//! What the panel serves: the page, and every operation that its description lists.

use crate::panel;

use panel::Emulator;
use serde_json::json;

/// There is no station at this address, and no fault of this number.
const NOBODY: &str = "88";

/// A described path with something for each of its parts.
fn described(path: &str, station: &str) -> String {
    let parts = [
        ("{line}", "line"),
        ("{address}", station),
        ("{key}", "1004"),
        ("{index}", "1017"),
        ("{sub}", "0"),
        ("{slot}", "1"),
        ("{octet}", "0"),
        ("{type}", "bit0"),
        ("{number}", NOBODY),
    ];
    parts.iter().fold(path.to_owned(), |path, (name, value)| path.replace(name, value))
}

#[test]
fn the_page_is_served_with_a_policy_that_lets_nothing_foreign_in() {
    let emulator = Emulator::start();
    for path in ["/", "/page/index.html", "/page/panel.js", "/page/panel.css"] {
        let answer = emulator.request("GET", path, "", "");
        assert_eq!(answer.status, 200, "{path}");
        assert!(
            answer.head.contains("content-security-policy: default-src 'none'; script-src 'self'"),
            "{path}"
        );
        assert!(answer.head.contains("x-content-type-options: nosniff"), "{path}");
        assert!(!answer.body.is_empty(), "{path}");
    }
    for path in ["/page/passwd", "/page/..%2F..%2FCargo.toml", "/page/", "/index.html"] {
        assert_eq!(emulator.request("GET", path, "", "").status, 404, "{path}");
    }
}

#[test]
fn every_described_operation_is_there_and_refers_to_what_is_described() {
    let emulator = Emulator::start();
    let description = emulator.get("/api/v1/openapi.json");
    assert!(description["openapi"].as_str().unwrap().starts_with("3.1"));
    let text = description.to_string();
    for reference in text.split("\"#/components/schemas/").skip(1) {
        let name = reference.split('"').next().unwrap();
        assert!(description["components"]["schemas"][name].is_object(), "{name} is not described");
    }
    let mut operations = 0;
    for (path, methods) in description["paths"].as_object().unwrap() {
        let path = described(path, NOBODY);
        for method in methods.as_object().unwrap().keys().filter(|method| *method != "parameters") {
            operations += 1;
            if path.ends_with("/events") {
                drop(emulator.stream(""));
                continue;
            }
            let answer = emulator.send(&method.to_ascii_uppercase(), &path, &json!({}));
            let unknown = answer.status == 405 || answer.body.contains("there is nothing at");
            assert!(!unknown && answer.status < 500, "{method} {path}: {}", answer.body);
            let described = &methods[method]["responses"][answer.status.to_string()];
            assert!(described.is_object(), "{method} {path}: {} is not described", answer.status);
        }
    }
    assert!(operations >= 22, "{operations}");
}

#[test]
fn a_parameter_that_an_operation_does_not_know_is_refused_and_nothing_is_changed() {
    let emulator = Emulator::start();
    let before = emulator.get("/api/v1/lines/line");
    let description = emulator.get("/api/v1/openapi.json");
    let mut operations = 0;
    for (path, methods) in description["paths"].as_object().unwrap() {
        for (method, operation) in methods.as_object().unwrap() {
            operations += 1;
            let path = described(path, "5");
            let answer = emulator.send(&method.to_ascii_uppercase(), &format!("{path}?x=1"), &json!({}));
            assert_eq!(answer.status, 400, "{method} {path}: {}", answer.body);
            assert!(answer.detail().contains('x'), "{method} {path}: {}", answer.detail());
            assert!(operation["responses"]["400"].is_object(), "{method} {path}");
        }
    }
    assert!(operations >= 22, "{operations}");
    assert_eq!(emulator.get("/api/v1/lines/line")["stations"], before["stations"]);
    let refused = emulator.request("GET", "/api/v1/lines/line?x=1", "", "");
    let sentence = "/api/v1/lines/line knows no parameter behind its '?', got 'x=1'; the API is described at \
                    /api/v1/openapi.json";
    assert_eq!(refused.detail(), sentence);
    assert_eq!(emulator.request("GET", "/api/v1/lines/line?", "", "").status, 200);
    assert_eq!(emulator.request("GET", "/api/v1/events/recent?line=line&address=5", "", "").status, 200);
}
