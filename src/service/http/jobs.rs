//! `/v1/jobs`: submit, list, look at, cancel, delete.

use std::time::Duration;

use axum::Json;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use base64::Engine;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use serde::Deserialize;
use utoipa::IntoParams;
use uuid::Uuid;

use crate::service::http::HttpState;
use crate::service::http::extract::{Id, Query, no_job, text, wait_seconds};
use crate::service::http::submit::{AssetJob, JobForm, Submission};
use crate::service::http::view::{job_body, job_row, wait_for_job};
use crate::service::jobs::Order;
use crate::service::store::{Cancelling, JobFilter, JobRow};
use crate::service::wire::{JobBody, JobList, JobStatus, MethodName, Problem, ProblemBody, ProblemKind, Urls};

const LONGEST_KEY: usize = 255;
/// How long a request to cancel waits for the run to stop, so that its answer is the final state.
const STOPPING: Duration = Duration::from_secs(1);

/// Submits a mesh.
///
/// The body is multipart/form-data with the file in the part `mesh` and an optional JSON part `spec`, or JSON that names
/// an asset. A file that cannot be read and a spec that cannot be used are refused at once.
#[utoipa::path(post, path = "/v1/jobs", tag = "jobs", operation_id = "submit_job",
    request_body(content(
        (JobForm = "multipart/form-data"),
        (AssetJob = "application/json"),
    )),
    params(
        ("Prefer" = Option<String>, Header, description = "`wait=N`: answer when the job is done, after N ≤ 60 s at the latest"),
        ("Idempotency-Key" = Option<String>, Header, description = "The same key and body lead to the same job, at most 255 characters"),
    ),
    responses(
        (status = 200, description = "The job is finished (after `Prefer: wait`, or for a repeated key)", body = JobBody),
        (status = 202, description = "Accepted; `Location` is the job", body = JobBody),
        (status = "4XX", description = "Refused", body = ProblemBody, content_type = "application/problem+json"),
        (status = 503, description = "Too many jobs wait", body = ProblemBody, content_type = "application/problem+json"),
    ))]
pub(super) async fn submit_job(State(state): State<HttpState>, request: Request) -> Result<Response, Problem> {
    let wait = wait_seconds(request.headers());
    let idempotency_key = idempotency_key(request.headers())?;
    let Submission { mesh, spec } = Submission::read(&state, request).await?;
    let accepted = state.desk.submit(Order { mesh, spec, idempotency_key }).await?;
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
        Some(key) if !key.is_empty() && key.len() <= LONGEST_KEY => Ok(Some(key.to_owned())),
        _ => {
            let detail = format!("Idempotency-Key must be 1 to {LONGEST_KEY} visible ASCII characters.");
            Err(Problem::new(ProblemKind::InvalidRequest, detail))
        }
    }
}

async fn described(state: &HttpState, status: StatusCode, job: JobRow) -> Result<Response, Problem> {
    let location = Urls::of(&job.id.to_string()).self_;
    let body = job_body(state, job).await?;
    Ok((status, [(header::LOCATION, location)], Json(body)).into_response())
}

/// Filters of the list.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct ListQuery {
    /// Only jobs of this status.
    status: Option<JobStatus>,
    /// Only jobs of this method.
    method: Option<MethodName>,
    /// Only jobs with this tag.
    tag: Option<String>,
    /// Jobs per page, 1 to 200; 50 if left out.
    limit: Option<u32>,
    /// `next_cursor` of the page before.
    cursor: Option<String>,
}

/// Lists jobs, newest first.
#[utoipa::path(get, path = "/v1/jobs", tag = "jobs", operation_id = "list_jobs", params(ListQuery),
    responses(
        (status = 200, description = "One page", body = JobList),
        (status = 400, description = "Refused", body = ProblemBody, content_type = "application/problem+json"),
    ))]
pub(super) async fn list_jobs(
    State(state): State<HttpState>,
    Query(query): Query<ListQuery>,
) -> Result<Json<JobList>, Problem> {
    let limit = query.limit.unwrap_or(50);
    if !(1..=200).contains(&limit) {
        return Err(Problem::new(ProblemKind::InvalidRequest, format!("limit must be from 1 to 200, not {limit}.")));
    }
    let filter = JobFilter {
        status: query.status,
        method: query.method.map(|method| method.name().to_owned()),
        tag: query.tag,
        before: query.cursor.as_deref().map(read_cursor).transpose()?,
    };
    // One more than asked for tells whether there is a next page.
    let mut rows = state.desk.store.list_jobs(&filter, limit + 1).await?;
    let more = rows.len() > limit as usize;
    rows.truncate(limit as usize);
    let next_cursor = rows.last().filter(|_| more).map(|last| URL_SAFE_NO_PAD.encode(last.id.as_bytes()));
    let mut jobs = Vec::with_capacity(rows.len());
    for row in rows {
        jobs.push(job_body(&state, row).await?);
    }
    Ok(Json(JobList { jobs, next_cursor }))
}

fn read_cursor(cursor: &str) -> Result<Uuid, Problem> {
    let bytes = URL_SAFE_NO_PAD.decode(cursor).ok();
    bytes.and_then(|bytes| Uuid::from_slice(&bytes).ok()).ok_or_else(|| {
        Problem::new(ProblemKind::InvalidRequest, "The cursor is not one of ours; start again without it.")
    })
}

/// Shows a job.
#[utoipa::path(get, path = "/v1/jobs/{id}", tag = "jobs", operation_id = "get_job",
    params(("id" = String, Path, description = "Id of the job")),
    responses(
        (status = 200, description = "The job", body = JobBody),
        (status = 404, description = "No such job", body = ProblemBody, content_type = "application/problem+json"),
    ))]
pub(super) async fn get_job(State(state): State<HttpState>, Id(id): Id) -> Result<Json<JobBody>, Problem> {
    let job = job_row(&state, id).await?;
    Ok(Json(job_body(&state, job).await?))
}

/// Cancels a job; a finished one stays as it is.
#[utoipa::path(post, path = "/v1/jobs/{id}/cancel", tag = "jobs", operation_id = "cancel_job",
    params(("id" = String, Path, description = "Id of the job")),
    responses(
        (status = 200, description = "The job is finished, cancelled or not", body = JobBody),
        (status = 202, description = "The run is about to stop", body = JobBody),
        (status = 404, description = "No such job", body = ProblemBody, content_type = "application/problem+json"),
    ))]
pub(super) async fn cancel_job(State(state): State<HttpState>, Id(id): Id) -> Result<Response, Problem> {
    let job = match state.desk.cancel(id).await? {
        Cancelling::Unknown => return Err(no_job(id)),
        Cancelling::Asked => wait_for_job(&state, id, STOPPING).await?,
        Cancelling::Done | Cancelling::Finished => job_row(&state, id).await?,
    };
    let status = if job.status.is_final() { StatusCode::OK } else { StatusCode::ACCEPTED };
    described(&state, status, job).await
}

/// Deletes a job and its files, cancelling it first if needed.
#[utoipa::path(delete, path = "/v1/jobs/{id}", tag = "jobs", operation_id = "delete_job",
    params(("id" = String, Path, description = "Id of the job")),
    responses(
        (status = 204, description = "Gone"),
        (status = 404, description = "No such job", body = ProblemBody, content_type = "application/problem+json"),
    ))]
pub(super) async fn delete_job(State(state): State<HttpState>, Id(id): Id) -> Result<StatusCode, Problem> {
    if state.desk.delete(id).await? { Ok(StatusCode::NO_CONTENT) } else { Err(no_job(id)) }
}
