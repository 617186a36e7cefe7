//! Refusals: problem details (RFC 9457) with a sentence that says what to do.

use axum::Json;
use axum::body::Bytes;
use axum::extract::rejection::{BytesRejection, JsonRejection, PathRejection, QueryRejection};
use axum::extract::{FromRequest, FromRequestParts, Path, Query, Request};
use axum::http::request::Parts;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Why a request was refused. Nothing was changed.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(utoipa::ToSchema))]
pub(crate) struct Problem {
    /// The HTTP status.
    status: u16,
    /// The HTTP status in words.
    title: String,
    /// What is wrong, and what to do.
    detail: String,
}

impl Problem {
    pub(crate) fn new(status: StatusCode, detail: impl ToString) -> Self {
        let title = status.canonical_reason().unwrap_or_default().into();
        Self { status: status.as_u16(), title, detail: detail.to_string() }
    }

    /// A value that cannot be.
    pub(super) fn value(detail: impl ToString) -> Self {
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, detail)
    }

    /// Not in the state the drive or the bus is in.
    pub(super) fn conflict(detail: impl ToString) -> Self {
        Self::new(StatusCode::CONFLICT, detail)
    }

    pub(crate) fn not_found(detail: impl ToString) -> Self {
        Self::new(StatusCode::NOT_FOUND, detail)
    }

    pub(super) fn busy() -> Self {
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "too many requests wait for the bus; try again")
    }

    pub(super) fn ended() -> Self {
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "the emulator is ending")
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let mut response = (status, Json(self)).into_response();
        let media_type = HeaderValue::from_static("application/problem+json");
        response.headers_mut().insert(header::CONTENT_TYPE, media_type);
        response
    }
}

/// A body in JSON.
pub(super) struct Body<T>(pub(super) T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequest<S> for Body<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, state: &S) -> Result<Self, Problem> {
        let (parts, body) = request.into_parts();
        let body = Bytes::from_request(Request::from_parts(parts.clone(), body), state).await?;
        // A list would be taken for the fields in their order.
        if body.iter().find(|octet| !octet.is_ascii_whitespace()).is_some_and(|first| *first != b'{') {
            return Err(Problem::value("the body must be a JSON object, {...}"));
        }
        let Json(body) = Json::from_request(Request::from_parts(parts, body.into()), state).await?;
        Ok(Self(body))
    }
}

impl From<BytesRejection> for Problem {
    fn from(rejection: BytesRejection) -> Self {
        Self::new(rejection.status(), rejection.body_text())
    }
}

impl From<JsonRejection> for Problem {
    fn from(rejection: JsonRejection) -> Self {
        if let JsonRejection::MissingJsonContentType(_) = rejection {
            let detail = "the body must be JSON: send the header Content-Type: application/json";
            return Self::new(rejection.status(), detail);
        }
        Self::new(rejection.status(), in_plain_words(&rejection.body_text()))
    }
}

/// What the parser of JSON or of a query says, without the names of its own types.
fn in_plain_words(said: &str) -> String {
    let begins = [
        ("Failed to deserialize the JSON body into the target type: ", "the body does not fit: "),
        ("Failed to parse the request body as JSON: ", "the body is no JSON: "),
        ("Failed to deserialize query string: ", "the part behind '?' does not fit: "),
    ];
    let ours = begins.iter().find_map(|(theirs, ours)| Some(format!("{ours}{}", said.strip_prefix(theirs)?)));
    let said = ours.unwrap_or_else(|| said.into());
    let said = match said.rsplit_once(" at line 1 column ") {
        Some((what, column)) => format!("{what} (octet {column})"),
        None => said,
    };
    said.replace("unknown variant", "unknown value")
        .replace("invalid digit found in string", "no whole number")
        .replace("expected f64", "expected a number")
        .replace("EOF while parsing a value", "it is empty, expected an object {...}")
}

/// Parts of the path.
pub(super) struct PathOf<T>(pub(super) T);

impl<T: DeserializeOwned + Send, S: Send + Sync> FromRequestParts<S> for PathOf<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let Path(path) = Path::from_request_parts(parts, state)
            .await
            .map_err(|rejection: PathRejection| Problem::new(rejection.status(), rejection.body_text()))?;
        Ok(Self(path))
    }
}

/// What stands behind the question mark.
pub(super) struct QueryOf<T>(pub(super) T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequestParts<S> for QueryOf<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        let plain = |rejection: QueryRejection| {
            Problem::new(rejection.status(), in_plain_words(&rejection.body_text()))
        };
        let Query(query) = Query::from_request_parts(parts, state).await.map_err(plain)?;
        Ok(Self(query))
    }
}
