//! The process's metrics. The recorder is global, as the `metrics` crate wants it: servers of one process share it.

use std::sync::OnceLock;
use std::time::Instant;

use axum::extract::{MatchedPath, Request};
use axum::middleware::Next;
use axum::response::Response;
use metrics_exporter_prometheus::{Matcher, PrometheusBuilder, PrometheusHandle};

use crate::service::wire::JobStatus;

const SECONDS: [f64; 10] = [0.005, 0.02, 0.1, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0, 60.0];

static HANDLE: OnceLock<Option<PrometheusHandle>> = OnceLock::new();

/// Starts recording; later calls change nothing.
pub(super) fn start() {
    HANDLE.get_or_init(|| {
        let builder = PrometheusBuilder::new().set_buckets_for_metric(Matcher::Suffix("_seconds".to_owned()), &SECONDS);
        let recorder = match builder {
            Ok(builder) => builder.build_recorder(),
            Err(error) => {
                tracing::error!(%error, "metrics are not recorded");
                return None;
            }
        };
        let handle = recorder.handle();
        metrics::set_global_recorder(recorder).ok().map(|()| handle)
    });
}

/// The Prometheus text, with the number of jobs per status as of now.
pub(super) fn render(jobs: &[(JobStatus, u64)]) -> String {
    use JobStatus::{Cancelled, Failed, Queued, Running, Succeeded};
    for status in [Queued, Running, Succeeded, Failed, Cancelled] {
        let n = jobs.iter().find(|(known, _)| *known == status).map_or(0, |&(_, n)| n);
        metrics::gauge!("quadrille_jobs", "status" => status.name()).set(n as f64);
    }
    HANDLE.get().and_then(Option::as_ref).map(PrometheusHandle::render).unwrap_or_default()
}

/// Counts and times requests by route, not by path: ids would make a series each.
pub(super) async fn measure(request: Request, next: Next) -> Response {
    let route = request.extensions().get::<MatchedPath>().map_or("unknown", MatchedPath::as_str).to_owned();
    let method = request.method().as_str().to_owned();
    let begun = Instant::now();
    let response = next.run(request).await;
    let status = response.status().as_u16().to_string();
    metrics::histogram!("quadrille_http_request_seconds", "route" => route.clone()).record(begun.elapsed());
    metrics::counter!("quadrille_http_requests_total", "route" => route, "method" => method, "status" => status)
        .increment(1);
    response
}
