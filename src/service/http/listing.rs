//! Many jobs at once: lists, cancelling and deleting by the same filters.

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::Response;
use base64::Engine;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde::de::value::{Error as ValueError, StrDeserializer};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;

use crate::service::http::HttpState;
use crate::service::http::json::large_json;
use crate::service::http::query::Pairs;
use crate::service::http::view::job_body;
use crate::service::store::JobFilter;
use crate::service::wire::{JobList, JobStatus, MethodName, Problem, ProblemKind};

const PAGE: u32 = 50;
const LONGEST_PAGE: u32 = 200;

/// Filters of jobs. Several values of one are joined by commas or given one by one, and a job with any of them passes.
#[derive(Debug, IntoParams)]
#[into_params(parameter_in = Query)]
pub(super) struct FilterQuery {
    /// Only jobs of these statuses; several also as `queued,running`.
    #[param(required = false)]
    status: Vec<JobStatus>,
    /// Only jobs of these methods; several also joined by commas.
    #[param(required = false)]
    method: Vec<MethodName>,
    /// Only jobs with one of these tags; several also joined by commas.
    #[param(required = false)]
    tag: Vec<String>,
    /// Only jobs that were submitted at this time or later, RFC 3339.
    #[param(value_type = Option<String>, format = DateTime)]
    created_after: Option<OffsetDateTime>,
    /// Only jobs that were submitted before this time, RFC 3339.
    #[param(value_type = Option<String>, format = DateTime)]
    created_before: Option<OffsetDateTime>,
}

/// Pages of the list.
#[derive(Debug, IntoParams)]
#[into_params(parameter_in = Query)]
pub(super) struct PageQuery {
    /// Jobs per page; 50 if left out.
    #[param(value_type = Option<u32>, minimum = 1, maximum = 200)]
    limit: u32,
    /// `next_cursor` of the page before.
    cursor: Option<String>,
}

/// How many jobs it was.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct JobCount {
    /// Jobs that were cancelled or are about to stop, or that were deleted.
    jobs: u64,
}

fn invalid(detail: String) -> Problem {
    Problem::new(ProblemKind::InvalidRequest, detail)
}

impl FilterQuery {
    fn take(pairs: &mut Pairs) -> Result<JobFilter, Problem> {
        let query = Self {
            status: pairs.list("status").iter().map(|name| named("status", name)).collect::<Result<_, _>>()?,
            method: pairs.list("method").iter().map(|name| named("method", name)).collect::<Result<_, _>>()?,
            tag: pairs.list("tag"),
            created_after: pairs.one("created_after")?.map(|text| time("created_after", &text)).transpose()?,
            created_before: pairs.one("created_before")?.map(|text| time("created_before", &text)).transpose()?,
        };
        Ok(JobFilter {
            statuses: query.status,
            methods: query.method.iter().map(|method| method.0.name().to_owned()).collect(),
            tags: query.tag,
            created_after: query.created_after.map(milliseconds),
            created_before: query.created_before.map(milliseconds),
            before: None,
        })
    }

    /// The filter of a request that changes jobs: without any, it would be all of them.
    fn only(mut pairs: Pairs) -> Result<JobFilter, Problem> {
        let filter = Self::take(&mut pairs)?;
        pairs.finish()?;
        if filter == JobFilter::default() {
            return Err(invalid("Give at least one of status, method, tag, created_after, created_before.".to_owned()));
        }
        Ok(filter)
    }
}

fn named<T: DeserializeOwned>(key: &str, name: &str) -> Result<T, Problem> {
    T::deserialize(StrDeserializer::<ValueError>::new(name)).map_err(|error| invalid(format!("{key}: {error}.")))
}

fn time(key: &str, text: &str) -> Result<OffsetDateTime, Problem> {
    // In a query a plus sign that is not escaped means a space.
    OffsetDateTime::parse(&text.replace(' ', "+"), &Rfc3339)
        .map_err(|_| invalid(format!("{key} must be a time as RFC 3339 writes it, such as 2026-01-31T12:00:00Z.")))
}

/// Rounded up, so that a time between two milliseconds is not taken for the earlier one.
fn milliseconds(time: OffsetDateTime) -> i64 {
    let nanoseconds = time.unix_timestamp_nanos();
    i64::try_from(-(-nanoseconds).div_euclid(1_000_000)).unwrap_or(i64::MAX)
}

impl PageQuery {
    fn take(pairs: &mut Pairs) -> Result<Self, Problem> {
        let limit = pairs.one("limit")?.map_or(Ok(PAGE), |text| text.parse());
        let limit = limit.ok().filter(|limit| (1..=LONGEST_PAGE).contains(limit));
        let limit = limit.ok_or_else(|| invalid(format!("limit must be a whole number from 1 to {LONGEST_PAGE}.")))?;
        Ok(Self { limit, cursor: pairs.one("cursor")? })
    }
}

/// Lists jobs, newest first.
#[utoipa::path(get, path = "/v1/jobs", tag = "jobs", operation_id = "list_jobs", params(FilterQuery, PageQuery),
    responses((status = 200, description = "One page", body = JobList)))]
pub(super) async fn list_jobs(State(state): State<HttpState>, mut pairs: Pairs) -> Result<Response, Problem> {
    let page = PageQuery::take(&mut pairs)?;
    let mut filter = FilterQuery::take(&mut pairs)?;
    pairs.finish()?;
    filter.before = page.cursor.as_deref().map(read_cursor).transpose()?;
    // One more than asked for tells whether there is a next page.
    let mut rows = state.jobs.store.list_jobs(&filter, page.limit + 1).await?;
    let more = rows.len() > page.limit as usize;
    rows.truncate(page.limit as usize);
    let next_cursor = rows.last().filter(|_| more).map(|last| URL_SAFE_NO_PAD.encode(last.id.as_bytes()));
    let mut jobs = Vec::with_capacity(rows.len());
    for row in rows {
        jobs.push(job_body(&state, row).await?);
    }
    large_json(StatusCode::OK, JobList { jobs, next_cursor }).await
}

fn read_cursor(cursor: &str) -> Result<Uuid, Problem> {
    let bytes = URL_SAFE_NO_PAD.decode(cursor).ok();
    bytes
        .and_then(|bytes| Uuid::from_slice(&bytes).ok())
        .ok_or_else(|| invalid("The cursor is not one of ours; start again without it.".to_owned()))
}

/// Cancels all jobs that pass the filters; at least one filter must be given, and finished jobs stay as they are.
#[utoipa::path(post, path = "/v1/jobs/cancel", tag = "jobs", operation_id = "cancel_jobs", params(FilterQuery),
    responses((status = 200, description = "How many were cancelled or are about to stop", body = JobCount)))]
pub(super) async fn cancel_jobs(State(state): State<HttpState>, pairs: Pairs) -> Result<Json<JobCount>, Problem> {
    let filter = FilterQuery::only(pairs)?;
    Ok(Json(JobCount { jobs: state.jobs.cancel_all(filter).await? }))
}

/// Deletes all jobs that pass the filters with their files, cancelling them first; at least one filter must be given.
#[utoipa::path(delete, path = "/v1/jobs", tag = "jobs", operation_id = "delete_jobs", params(FilterQuery),
    responses((status = 200, description = "How many are gone", body = JobCount)))]
pub(super) async fn delete_jobs(State(state): State<HttpState>, pairs: Pairs) -> Result<Json<JobCount>, Problem> {
    let filter = FilterQuery::only(pairs)?;
    Ok(Json(JobCount { jobs: state.jobs.delete_all(filter).await? }))
}
