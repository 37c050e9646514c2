//! Problems as answers.

use axum::Json;
use axum::extract::Request;
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use serde_json::Value;

use crate::service::wire::{Problem, ProblemBody, ProblemKind};

const MEDIA_TYPE: HeaderValue = HeaderValue::from_static("application/problem+json");

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let mut response = answer(self.kind, self.retry_after, &serde_json::json!(self.body(None)));
        response.extensions_mut().insert(Occurrence(self));
        response
    }
}

/// Remembers the problem until [`finish`] knows the request that it belongs to.
#[derive(Clone)]
struct Occurrence(Problem);

fn answer(kind: ProblemKind, retry_after: Option<u32>, body: &Value) -> Response {
    let status = StatusCode::from_u16(kind.status()).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
    let mut response = (status, Json(body)).into_response();
    response.headers_mut().insert(header::CONTENT_TYPE, MEDIA_TYPE);
    if let Some(seconds) = retry_after {
        response.headers_mut().insert(header::RETRY_AFTER, HeaderValue::from(seconds));
    }
    response
}

/// The answer to a request for a file of a job that has none and never will: 410 with the job's own problem inside.
pub(super) fn gone(job: &str, problem: &ProblemBody) -> Response {
    let detail = format!("{}: {}", problem.title, problem.detail);
    let mut body = serde_json::json!(Problem::new(ProblemKind::JobFailed, detail).body(Some(job.to_owned())));
    body["problem"] = serde_json::json!(problem);
    for member in ["stage", "elements", "errors", "figures"] {
        if let Some(value) = body["problem"].get(member).cloned() {
            body[member] = value;
        }
    }
    answer(ProblemKind::JobFailed, None, &body)
}

/// The outermost layer but one: names the request in the problem and logs what is our fault, once.
pub(super) async fn finish(request: Request, next: Next) -> Response {
    let id = request.headers().get("x-request-id").and_then(|id| id.to_str().ok()).map(str::to_owned);
    let place = format!("{} {}", request.method(), request.uri().path());
    let mut response = next.run(request).await;
    let Some(Occurrence(problem)) = response.extensions_mut().remove::<Occurrence>() else { return response };
    if problem.kind.status() >= 500 {
        tracing::warn!(request.id = id, place, problem = problem.kind.slug(), "the request failed");
    } else {
        tracing::debug!(request.id = id, place, problem = problem.kind.slug(), detail = problem.detail, "refused");
    }
    let body = serde_json::json!(problem.body(id.map(|id| format!("urn:request:{id}"))));
    let mut finished = answer(problem.kind, problem.retry_after, &body);
    for (name, value) in response.headers() {
        // E.g. Allow, which the router adds to 405, and Content-Range of 416.
        if !finished.headers().contains_key(name) && name != header::CONTENT_LENGTH {
            finished.headers_mut().append(name, value.clone());
        }
    }
    finished
}
