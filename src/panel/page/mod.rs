//! The page: files that are part of the program, so that it needs no other host.

use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};

use super::problem::{PathOf, Problem};

/// A file of the page, served at `/page/NAME`.
struct File {
    name: &'static str,
    media_type: &'static str,
    octets: &'static [u8],
}

const INDEX: File =
    File { name: "index.html", media_type: "text/html; charset=utf-8", octets: include_bytes!("index.html") };

const FILES: &[File] = &[
    INDEX,
    File { name: "panel.css", media_type: "text/css; charset=utf-8", octets: include_bytes!("panel.css") },
    File { name: "icon.svg", media_type: "image/svg+xml", octets: include_bytes!("icon.svg") },
    script("alarms.js", include_bytes!("alarms.js")),
    script("announce.js", include_bytes!("announce.js")),
    script("api.js", include_bytes!("api.js")),
    script("bus.js", include_bytes!("bus.js")),
    script("bus_rates.js", include_bytes!("bus_rates.js")),
    script("connection.js", include_bytes!("connection.js")),
    script("copy.js", include_bytes!("copy.js")),
    script("curve_painting.js", include_bytes!("curve_painting.js")),
    script("curves.js", include_bytes!("curves.js")),
    script("device.js", include_bytes!("device.js")),
    script("diagnosis.js", include_bytes!("diagnosis.js")),
    script("dom.js", include_bytes!("dom.js")),
    script("entries.js", include_bytes!("entries.js")),
    script("faults.js", include_bytes!("faults.js")),
    script("inputs.js", include_bytes!("inputs.js")),
    script("lines.js", include_bytes!("lines.js")),
    script("log.js", include_bytes!("log.js")),
    script("master.js", include_bytes!("master.js")),
    script("overview.js", include_bytes!("overview.js")),
    script("panel.js", include_bytes!("panel.js")),
    script("process.js", include_bytes!("process.js")),
    script("recall.js", include_bytes!("recall.js")),
    script("records.js", include_bytes!("records.js")),
    script("report.js", include_bytes!("report.js")),
    script("scenario.js", include_bytes!("scenario.js")),
    script("settings.js", include_bytes!("settings.js")),
    script("states.js", include_bytes!("states.js")),
    script("station.js", include_bytes!("station.js")),
    script("stream.js", include_bytes!("stream.js")),
    script("telegrams.js", include_bytes!("telegrams.js")),
    script("trigger.js", include_bytes!("trigger.js")),
    script("values.js", include_bytes!("values.js")),
    script("watch.js", include_bytes!("watch.js")),
    script("why.js", include_bytes!("why.js")),
    script("words.js", include_bytes!("words.js")),
];

const fn script(name: &'static str, octets: &'static [u8]) -> File {
    File { name, media_type: "text/javascript; charset=utf-8", octets }
}

/// Files of the page, requests to its server, and nothing else from anywhere.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; \
    base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

pub(super) async fn index() -> Response {
    INDEX.response()
}

pub(super) async fn file(PathOf(name): PathOf<std::string::String>) -> Result<Response, Problem> {
    let file = FILES.iter().find(|file| file.name == name);
    file.map(File::response).ok_or_else(|| Problem::not_found(format!("the page has no file {name}")))
}

impl File {
    fn response(&self) -> Response {
        let headers = [
            (header::CONTENT_TYPE, HeaderValue::from_static(self.media_type)),
            (header::CACHE_CONTROL, HeaderValue::from_static("no-cache")),
            (header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(POLICY)),
        ];
        (headers, self.octets).into_response()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_the_page_is_served() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/panel/page");
        for entry in std::fs::read_dir(folder).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            let served = FILES.iter().any(|file| file.name == name);
            assert_eq!(served, !name.ends_with(".rs"), "{name}");
        }
    }
}
