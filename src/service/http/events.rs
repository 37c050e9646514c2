//! `/v1/jobs/{id}/events`: what happens to a job, as server-sent events.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::time::Duration;

use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::Stream;
use futures_util::stream::unfold;
use serde_json::json;
use tokio::sync::broadcast;
use uuid::Uuid;

use crate::service::http::HttpState;
use crate::service::http::extract::{Id, text};
use crate::service::http::view::{job_body, job_row};
use crate::service::store::EventRow;
use crate::service::wire::{JobStatus, Problem};

/// Longest time until an event of another process is seen.
const POLL: Duration = Duration::from_secs(1);
const HEARTBEAT: Duration = Duration::from_secs(10);

/// Follows a job.
///
/// `progress` and `stage` events, then `succeeded`, `failed` or `cancelled` with the job object, after which the stream
/// ends. With `Last-Event-ID` it goes on after that event; if nothing is left, the answer is 204.
#[utoipa::path(get, path = "/v1/jobs/{id}/events", tag = "jobs", operation_id = "job_events",
    params(
        ("id" = Uuid, Path, description = "Id of the job"),
        ("Last-Event-ID" = Option<String>, Header, description = "Number of the last event that was seen"),
    ),
    responses(
        (status = 200, description = "The events", body = String, content_type = "text/event-stream"),
        (status = 204, description = "The job is finished and there is nothing after the last event"),
    ))]
pub(super) async fn job_events(
    State(state): State<HttpState>,
    Id(id): Id,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let changes = state.jobs.live.subscribe();
    let job = job_row(&state, id).await?;
    let after = text(&headers, "last-event-id").and_then(|id| id.parse().ok()).unwrap_or(0);
    let waiting: VecDeque<_> = state.jobs.store.events_after(id, after).await?.into();
    if job.status.is_final() && waiting.is_empty() {
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    // Followers of a waiting job see at once how far it is; what they see is no event of the job, so it has no number.
    let first = (after == 0 && waiting.is_empty()).then(|| {
        let now = json!({"progress": f64::from(job.progress) / 1000.0, "stage": job.stage});
        Event::default().event("progress").data(now.to_string())
    });
    let follower = Follower { state, id, changes, after, first, waiting, over: false };
    let keep_alive = KeepAlive::new().interval(HEARTBEAT).text("heartbeat");
    Ok(Sse::new(follower.stream()).keep_alive(keep_alive).into_response())
}

struct Follower {
    state: HttpState,
    id: Uuid,
    changes: broadcast::Receiver<Uuid>,
    after: i64,
    first: Option<Event>,
    waiting: VecDeque<EventRow>,
    over: bool,
}

impl Follower {
    fn stream(self) -> impl Stream<Item = Result<Event, Infallible>> {
        unfold(self, |mut follower| async move {
            let event = follower.next().await?;
            Some((Ok(event), follower))
        })
    }

    async fn next(&mut self) -> Option<Event> {
        if let Some(first) = self.first.take() {
            return Some(first);
        }
        while !self.over {
            if let Some(row) = self.waiting.pop_front() {
                self.after = row.seq;
                let is_last = JobStatus::from_name(&row.kind).is_some_and(JobStatus::is_final);
                let data = if is_last { self.final_data().await? } else { row.data };
                self.over = is_last;
                return Some(Event::default().id(row.seq.to_string()).event(row.kind).data(data));
            }
            self.waiting = self.state.jobs.store.events_after(self.id, self.after).await.ok()?.into();
            if self.waiting.is_empty() {
                self.wait_for_news().await?;
            }
        }
        None
    }

    /// Waits until there may be news; ends when the process does, or the job is deleted.
    async fn wait_for_news(&mut self) -> Option<()> {
        let news = async { while self.changes.recv().await.is_ok_and(|changed| changed != self.id) {} };
        tokio::select! {
            () = self.state.stop.cancelled() => return None,
            () = news => {}
            () = tokio::time::sleep(POLL) => {}
        }
        self.state.jobs.store.job(self.id).await.ok()?.map(|_| ())
    }

    async fn final_data(&self) -> Option<String> {
        let job = self.state.jobs.store.job(self.id).await.ok()??;
        let body = job_body(&self.state, job).await.ok()?;
        serde_json::to_string(&body).ok()
    }
}
