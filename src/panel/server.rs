//! The HTTP server: bounded in every direction. It rejects cross-origin requests.
//!
//! | bound | value |
//! | --- | --- |
//! | connections | [`MOST_CONNECTIONS`]; more get 503 at once |
//! | time for the head of a request, also of the next on a kept connection | [`HEAD_TIME`] |
//! | time for everything else of a request | [`REQUEST_TIME`] |
//! | octets of the head and of the body | [`HEAD_OCTETS`], [`BODY_OCTETS`] |
//! | time in which a client must take some of what waits for it | [`TAKE_TIME`] |
//! | octets that wait for a reader | [`SEND_BUFFER`] and [`stream`](super::stream) |
//!
//! A web site on the same machine's browser can send requests here, and with a name that leads to 127.0.0.1 (DNS
//! rebinding) even read the answers. So `Host` must be `localhost` or an address in numbers, and `Origin`, which
//! browsers add to what could change something, must be this very server.

mod timed;

use core::net::IpAddr;
use core::time::Duration;
use std::io::{self, Write};
use std::net::TcpListener;
use std::sync::Arc;

use axum::Router;
use axum::extract::{DefaultBodyLimit, Request};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::TcpStream;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};
use tokio::time::{sleep, timeout};

use super::problem::Problem;
use crate::host::Reach;
use timed::Timed;

/// Connections served at a time.
pub(super) const MOST_CONNECTIONS: usize = 64;

/// From the beginning of a connection, or the end of a request, to the end of the next request's head.
pub(super) const HEAD_TIME: Duration = Duration::from_secs(5);

/// From the end of a request's head to its answer.
const REQUEST_TIME: Duration = Duration::from_secs(5);

/// A client that takes nothing for so long, although something waits for it, is cut off.
const TAKE_TIME: Duration = Duration::from_secs(10);

/// The head of a request at most.
const HEAD_OCTETS: usize = 16 * 1024;

/// The body of a request at most.
const BODY_OCTETS: usize = 16 * 1024;

/// Octets that the kernel keeps for a reader at most; it doubles what it is told.
const SEND_BUFFER: usize = 64 * 1024;

/// After the operating system could not accept a connection (no descriptor is left, say).
const ACCEPT_PAUSE: Duration = Duration::from_secs(1);

/// For who comes when all connections are taken.
const FULL: &[u8] = b"HTTP/1.1 503 Service Unavailable\r\ncontent-type: application/problem+json\r\n\
    content-length: 108\r\nconnection: close\r\nretry-after: 5\r\n\r\n\
    {\"status\":503,\"title\":\"Service Unavailable\",\"detail\":\"too many connections; close some, or try again later\"}";

/// Which names `Host` may have where others than this machine are let in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Names {
    /// `localhost` and addresses in numbers, wherever it listens.
    Numbers,
    #[cfg_attr(not(feature = "metrics"), expect(dead_code, reason = "only metrics have it"))]
    /// Any: nothing can be changed here, and whom the network reaches may read.
    Any,
}

/// Serves until `end` is dropped.
pub(super) async fn serve(
    listener: TcpListener,
    trust: (Reach, Names),
    router: Router,
    end: oneshot::Receiver<()>,
) -> io::Result<()> {
    let listener = tokio::net::TcpListener::from_std(listener)?;
    let service = router
        .layer(DefaultBodyLimit::max(BODY_OCTETS))
        .layer(middleware::from_fn(move |request: Request, next: Next| guarded(trust, request, next)));
    let places = Arc::new(Semaphore::new(MOST_CONNECTIONS));
    let accepting = async {
        loop {
            match listener.accept().await {
                Ok((stream, _)) => match Arc::clone(&places).try_acquire_owned() {
                    Ok(place) => drop(tokio::spawn(connection(stream, service.clone(), place))),
                    Err(_) => refuse(stream),
                },
                // That client has gone again.
                Err(error) if error.kind() == io::ErrorKind::ConnectionAborted => {}
                Err(error) => {
                    tracing::warn!("HTTP: cannot accept a connection: {error}");
                    sleep(ACCEPT_PAUSE).await;
                }
            }
        }
    };
    tokio::select! {
        () = accepting => {}
        _ = end => {}
    }
    Ok(())
}

/// Says that there is no room. The answer fits into any fresh socket; tokio does not know yet that it does, and would
/// write nothing.
fn refuse(stream: TcpStream) {
    if let Ok(mut stream) = stream.into_std() {
        let _ = stream.write(FULL);
    }
}

async fn connection(stream: TcpStream, service: Router, _place: OwnedSemaphorePermit) {
    // States are small and shall come when they are; what nobody reads shall not fill the memory of the kernel.
    let _ = stream.set_nodelay(true);
    let _ = rustix::net::sockopt::set_socket_send_buffer_size(&stream, SEND_BUFFER);
    let served = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIME)
        .max_buf_size(HEAD_OCTETS)
        .serve_connection(TokioIo::new(Timed::new(stream, TAKE_TIME)), TowerToHyperService::new(service))
        .await;
    if let Err(error) = served {
        tracing::debug!("HTTP: a connection ended: {error}");
    }
}

/// Answers a request of whom we trust, in time.
async fn guarded(trust: (Reach, Names), request: Request, next: Next) -> Response {
    let mut response = match untrusted_origin(trust, &request).or_else(|| too_large(&request)) {
        Some(problem) => problem.into_response(),
        None => match timeout(REQUEST_TIME, next.run(request)).await {
            Ok(response) => response,
            Err(_) => Problem::new(
                StatusCode::REQUEST_TIMEOUT,
                format!("the request took longer than {REQUEST_TIME:?}; send it whole at once"),
            )
            .into_response(),
        },
    };
    let headers = response.headers_mut();
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    let policy = HeaderName::from_static("cross-origin-resource-policy");
    headers.insert(policy, HeaderValue::from_static("same-origin"));
    response
}

/// A body that says to be too large need not be waited for.
fn too_large(request: &Request) -> Option<Problem> {
    let length = only(request.headers(), &header::CONTENT_LENGTH)?.parse().unwrap_or(usize::MAX);
    let detail = || format!("the body has {length} octets; {BODY_OCTETS} are possible");
    (length > BODY_OCTETS).then(|| Problem::new(StatusCode::PAYLOAD_TOO_LARGE, detail()))
}

/// Why the sender is not trusted.
fn untrusted_origin(trust: (Reach, Names), request: &Request) -> Option<Problem> {
    let headers = request.headers();
    let host = only(headers, &header::HOST);
    let authority = request.uri().authority().map(|authority| authority.as_str());
    let ours = host.is_some_and(|host| is_ours(trust, host))
        && authority.is_none_or(|authority| is_ours(trust, authority));
    if !ours {
        let detail = "Host must be localhost or an address of this machine in numbers, with the port";
        return Some(Problem::new(StatusCode::FORBIDDEN, detail));
    }
    let same_origin = match headers.get_all(header::ORIGIN).iter().count() {
        0 => true,
        _ => only(headers, &header::ORIGIN).and_then(|origin| origin.strip_prefix("http://")) == host,
    };
    if !same_origin {
        let detail =
            "requests of other web sites are refused; use the panel itself, or a program that is no browser";
        return Some(Problem::new(StatusCode::FORBIDDEN, detail));
    }
    None
}

/// The value of a header that is there once.
fn only<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next()?;
    values.next().is_none().then(|| value.to_str().ok())?
}

/// Whether a `Host` names this machine such that no other web site can have chosen it.
fn is_ours(trust: (Reach, Names), host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.parse::<u16>().is_ok() => name,
        Some(_) | None => host,
    };
    let address = match name.strip_prefix('[').and_then(|name| name.strip_suffix(']')) {
        Some(v6) => v6.parse().ok().map(IpAddr::V6),
        None => name.parse().ok().map(IpAddr::V4),
    };
    match (address, trust) {
        (Some(_), (Reach::Network, _)) | (None, (Reach::Network, Names::Any)) => true,
        (Some(address), (Reach::ThisMachine, _)) => address.to_canonical().is_loopback(),
        (None, (Reach::ThisMachine, _) | (Reach::Network, Names::Numbers)) => {
            name.eq_ignore_ascii_case("localhost")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_localhost_and_addresses_in_numbers_are_this_machine() {
        for (host, this_machine, network) in [
            ("localhost", true, true),
            ("LocalHost:8080", true, true),
            ("127.0.0.1:8080", true, true),
            ("127.8.9.1", true, true),
            ("[::1]:8080", true, true),
            ("[::1]", true, true),
            ("192.168.0.7:8080", false, true),
            ("[fe80::1]:80", false, true),
            ("", false, false),
            (":8080", false, false),
            ("example.com", false, false),
            ("localhost.example.com:8080", false, false),
            ("127.0.0.1.example.com", false, false),
            ("127.0.0.1:99999", false, false),
            ("::1", false, false),
            ("2130706433", false, false),
            ("localhost:8080:8080", false, false),
        ] {
            assert_eq!(is_ours((Reach::ThisMachine, Names::Numbers), host), this_machine, "{host}");
            assert_eq!(is_ours((Reach::ThisMachine, Names::Any), host), this_machine, "{host}");
            assert_eq!(is_ours((Reach::Network, Names::Numbers), host), network, "{host}");
            assert!(is_ours((Reach::Network, Names::Any), host), "{host}");
        }
    }

    #[test]
    fn the_answer_of_a_full_server_has_the_length_it_says() {
        let text = core::str::from_utf8(FULL).unwrap();
        let (head, body) = text.split_once("\r\n\r\n").unwrap();
        assert!(head.contains(&format!("content-length: {}\r\n", body.len())), "{}", body.len());
    }
}
