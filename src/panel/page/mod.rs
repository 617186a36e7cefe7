//! The page: files that are part of the program, so that it needs no other host.

use std::format;

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
    File {
        name: "panel.js",
        media_type: "text/javascript; charset=utf-8",
        octets: include_bytes!("panel.js"),
    },
    File { name: "panel.css", media_type: "text/css; charset=utf-8", octets: include_bytes!("panel.css") },
];

/// Scripts only from here, and nothing from anywhere else.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; \
    connect-src 'self'; font-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

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
