//! JSON that may be long.

use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;

use crate::service::jobs::run_blocking;
use crate::service::wire::Problem;

/// An answer whose JSON is written on a blocking thread of tokio: its own threads serve other connections.
pub(super) async fn large_json<T: Serialize + Send + 'static>(
    status: StatusCode,
    body: T,
) -> Result<Response, Problem> {
    let bytes = run_blocking(move || {
        serde_json::to_vec(&body).map_err(|error| {
            tracing::error!(%error, "an answer cannot be written as JSON");
            Problem::internal()
        })
    })
    .await?;
    Ok((status, [(header::CONTENT_TYPE, "application/json")], bytes).into_response())
}
