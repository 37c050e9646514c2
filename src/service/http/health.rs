//! `/healthz`, `/readyz`, `/metrics`.

use axum::Json;
use axum::extract::State;
use axum::http::{HeaderName, header};
use serde::Serialize;
use utoipa::ToSchema;

use crate::service::http::HttpState;
use crate::service::http::metrics;
use crate::service::wire::{Problem, ProblemKind};

/// A sign of life.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct HealthBody {
    /// Always `ok`.
    status: &'static str,
    /// Version of the program.
    version: &'static str,
}

impl HealthBody {
    const OK: Self = Self { status: "ok", version: env!("CARGO_PKG_VERSION") };
}

/// Says that the process is alive.
#[utoipa::path(get, path = "/healthz", tag = "about", operation_id = "healthz",
    responses((status = 200, description = "Alive", body = HealthBody)))]
pub(super) async fn healthz() -> Json<HealthBody> {
    Json(HealthBody::OK)
}

/// Says whether work can be taken: uploads, rows and blobs can be written, and the process is not stopping.
#[utoipa::path(get, path = "/readyz", tag = "about", operation_id = "readyz",
    responses(
        (status = 200, description = "Ready", body = HealthBody),
    ))]
pub(super) async fn readyz(State(state): State<HttpState>) -> Result<Json<HealthBody>, Problem> {
    if state.stop.is_cancelled() {
        return Err(Problem::new(ProblemKind::ShuttingDown, "The process is stopping and takes no new work."));
    }
    state.readiness.check(&state.jobs.store, state.uploads.clone()).await?;
    Ok(Json(HealthBody::OK))
}

/// Shows the metrics as Prometheus text.
#[utoipa::path(get, path = "/metrics", tag = "about", operation_id = "metrics",
    responses((status = 200, description = "Prometheus text format", body = String, content_type = "text/plain")))]
pub(super) async fn metrics(
    State(state): State<HttpState>,
) -> Result<([(HeaderName, &'static str); 1], String), Problem> {
    let counts = state.jobs.store.count_jobs().await?;
    Ok(([(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], metrics::render(&counts)))
}
