//! Bodies that stop coming.

use std::sync::{Arc, OnceLock};

use axum::body::{Body, HttpBody};
use axum::extract::{Request, State};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use futures_util::{StreamExt, stream};

use crate::service::http::HttpState;
use crate::service::wire::{Problem, ProblemKind};

/// Cuts a body off that sends nothing for too long, or is still being sent when the process ends. The handler sees a
/// broken body; the client is told the cause, whatever the handler makes of that.
pub(super) async fn guard(State(state): State<HttpState>, request: Request, next: Next) -> Response {
    if request.body().is_end_stream() {
        return next.run(request).await;
    }
    let cause = Arc::new(OnceLock::new());
    let told = Arc::clone(&cause);
    let answer = next.run(request.map(|body| guarded(body, state, told))).await;
    cause.get().map_or(answer, |problem: &Problem| problem.clone().into_response())
}

fn guarded(body: Body, state: HttpState, cause: Arc<OnceLock<Problem>>) -> Body {
    let chunks = stream::unfold((body.into_data_stream(), state, cause), |(mut data, state, cause)| async move {
        let stalled = state.jobs.limits.stalled;
        let problem = tokio::select! {
            chunk = data.next() => return chunk.map(|chunk| (chunk, (data, state, cause))),
            () = tokio::time::sleep(stalled) => {
                let detail = format!("The body sent nothing for {} s.", stalled.as_secs_f64());
                Problem::new(ProblemKind::RequestTimeout, detail)
            }
            () = state.stop.cancelled() => {
                Problem::new(ProblemKind::ShuttingDown, "The process is stopping; send the request again.")
            }
        };
        let error = axum::Error::new(problem.clone());
        let _ = cause.set(problem);
        Some((Err(error), (data, state, cause)))
    });
    Body::from_stream(chunks)
}
