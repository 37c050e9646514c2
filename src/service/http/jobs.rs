//! `/v1/jobs`: one job: submit, look at, cancel, delete.

use std::time::Duration;

use axum::Json;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};

use crate::service::http::HttpState;
use crate::service::http::extract::{Id, no_job, text, wait_seconds};
use crate::service::http::submit::{AssetJob, JobForm, Submission};
use crate::service::http::view::{job_body, job_row, wait_for_job};
use crate::service::jobs::JobRequest;
use crate::service::store::{Cancelling, JobRow};
use crate::service::wire::{JobBody, Problem, ProblemKind, Urls};

const MAX_KEY_LENGTH: usize = 255;
/// How long a cancel request waits for the run to stop. If it stops in time, the response is 200 with the final state,
/// otherwise 202.
const CANCEL_WAIT: Duration = Duration::from_secs(1);

/// Submits a mesh.
///
/// The body is multipart/form-data with the file in the part `mesh` and an optional JSON part `spec`, or JSON that names
/// an asset. A file that cannot be read and a spec that cannot be used are refused at once.
#[utoipa::path(post, path = "/v1/jobs", tag = "jobs", operation_id = "submit_job",
    request_body(content(
        (JobForm = "multipart/form-data", example = json!({
            "mesh": ["v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"],
            "spec": {"target": {"quads": 100}, "deadline_s": 10, "tags": ["example"]},
        })),
        (AssetJob = "application/json", example = json!({
            "asset": "0198c0de-0000-7000-8000-000000000001",
            "spec": {"target": {"edge_length": 0.02}, "deadline_s": 10},
        })),
    )),
    params(
        ("Prefer" = Option<String>, Header, example = "wait=30",
            description = "`wait=N`: answer when the job is done, after N ≤ 60 s at the latest"),
        ("Idempotency-Key" = Option<String>, Header, min_length = 1, max_length = 255, pattern = "^[!-~]([ -~]*[!-~])?$",
            description = "A repeated request with the same key and body returns the job of the first one"),
    ),
    responses(
        (status = 200, description = "The job is finished (after `Prefer: wait`, or for a repeated key)", body = JobBody,
            headers(("Location" = String, description = "The job"))),
        (status = 202, description = "Accepted", body = JobBody, headers(("Location" = String, description = "The job"))),
    ))]
pub(super) async fn submit_job(State(state): State<HttpState>, request: Request) -> Result<Response, Problem> {
    let wait = wait_seconds(request.headers());
    let idempotency_key = idempotency_key(request.headers())?;
    let Submission { mesh, spec } = Submission::read(&state, request).await?;
    let accepted = state.jobs.submit(JobRequest { mesh, spec, idempotency_key }).await?;
    let mut job = accepted.job;
    if let Some(seconds) = wait {
        job = wait_for_job(&state, job.id, Duration::from_secs(seconds)).await?;
    }
    let status = if job.status.is_final() { StatusCode::OK } else { StatusCode::ACCEPTED };
    let mut response = described(&state, status, job).await?;
    if wait.is_some() {
        let applied = HeaderName::from_static("preference-applied");
        response.headers_mut().insert(applied, HeaderValue::from_static("wait"));
    }
    if !accepted.fresh {
        let replayed = HeaderName::from_static("idempotent-replayed");
        response.headers_mut().insert(replayed, HeaderValue::from_static("true"));
    }
    Ok(response)
}

fn idempotency_key(headers: &HeaderMap) -> Result<Option<String>, Problem> {
    if !headers.contains_key("idempotency-key") {
        return Ok(None);
    }
    match text(headers, "idempotency-key") {
        Some(key) if !key.is_empty() && key.len() <= MAX_KEY_LENGTH => Ok(Some(key.to_owned())),
        _ => {
            let detail = format!("Idempotency-Key must be 1 to {MAX_KEY_LENGTH} visible ASCII characters.");
            Err(Problem::new(ProblemKind::InvalidRequest, detail))
        }
    }
}

async fn described(state: &HttpState, status: StatusCode, job: JobRow) -> Result<Response, Problem> {
    let location = Urls::of(&job.id.to_string()).self_;
    let body = job_body(state, job).await?;
    Ok((status, [(header::LOCATION, location)], Json(body)).into_response())
}

/// Shows a job.
#[utoipa::path(get, path = "/v1/jobs/{id}", tag = "jobs", operation_id = "get_job",
    params(("id" = Uuid, Path, description = "Id of the job")),
    responses(
        (status = 200, description = "The job", body = JobBody),
    ))]
pub(super) async fn get_job(State(state): State<HttpState>, Id(id): Id) -> Result<Json<JobBody>, Problem> {
    let job = job_row(&state, id).await?;
    Ok(Json(job_body(&state, job).await?))
}

/// Cancels a job; a finished one stays as it is.
#[utoipa::path(post, path = "/v1/jobs/{id}/cancel", tag = "jobs", operation_id = "cancel_job",
    params(("id" = Uuid, Path, description = "Id of the job")),
    responses(
        (status = 200, description = "The job is finished, cancelled or not", body = JobBody),
        (status = 202, description = "The run is about to stop", body = JobBody),
    ))]
pub(super) async fn cancel_job(State(state): State<HttpState>, Id(id): Id) -> Result<Response, Problem> {
    let job = match state.jobs.cancel(id).await? {
        Cancelling::Unknown => return Err(no_job(id)),
        Cancelling::Asked => wait_for_job(&state, id, CANCEL_WAIT).await?,
        Cancelling::Done | Cancelling::Finished => job_row(&state, id).await?,
    };
    let status = if job.status.is_final() { StatusCode::OK } else { StatusCode::ACCEPTED };
    described(&state, status, job).await
}

/// Deletes a job and its files, cancelling it first if needed.
#[utoipa::path(delete, path = "/v1/jobs/{id}", tag = "jobs", operation_id = "delete_job",
    params(("id" = Uuid, Path, description = "Id of the job")),
    responses(
        (status = 204, description = "The job is deleted"),
    ))]
pub(super) async fn delete_job(State(state): State<HttpState>, Id(id): Id) -> Result<StatusCode, Problem> {
    if state.jobs.delete(id).await? { Ok(StatusCode::NO_CONTENT) } else { Err(no_job(id)) }
}
