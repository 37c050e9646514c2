//! What surrounds every handler.

use std::any::Any;

use axum::Router;
use axum::body::Body;
use axum::extract::DefaultBodyLimit;
use axum::http::{HeaderValue, Request};
use axum::middleware::from_fn;
use axum::response::{IntoResponse, Response};
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::request_id::{MakeRequestId, PropagateRequestIdLayer, RequestId, SetRequestIdLayer};
use tower_http::trace::TraceLayer;
use uuid::Uuid;

use crate::service::http::{Access, compression, metrics, problem};
use crate::service::wire::Problem;

#[derive(Clone, Copy, Debug)]
struct Numbered;

impl MakeRequestId for Numbered {
    fn make_request_id<B>(&mut self, _: &Request<B>) -> Option<RequestId> {
        HeaderValue::from_str(&Uuid::now_v7().to_string()).ok().map(RequestId::new)
    }
}

/// Wraps the routes, innermost layer first.
pub(super) fn wrap(routes: Router, access: &Access) -> Router {
    metrics::start();
    let span = |request: &Request<Body>| {
        let id = request.headers().get("x-request-id").and_then(|id| id.to_str().ok()).unwrap_or_default();
        tracing::debug_span!("request", request.id = id, method = %request.method(), path = request.uri().path())
    };
    let routes = routes
        // Uploads have their own limit and are never held in memory.
        .layer(DefaultBodyLimit::disable())
        .layer(CatchPanicLayer::custom(panicked))
        .route_layer(from_fn(metrics::measure));
    let routes = access.guard(routes).layer(from_fn(problem::finish));
    compression::wrap(routes)
        .layer(access.cors())
        .layer(TraceLayer::new_for_http().make_span_with(span))
        .layer(PropagateRequestIdLayer::x_request_id())
        .layer(SetRequestIdLayer::x_request_id(Numbered))
}

fn panicked(panic: Box<dyn Any + Send>) -> Response {
    let what = panic.downcast_ref::<String>().map(String::as_str);
    let what = what.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
    tracing::error!(panic = what, "a handler panicked");
    Problem::internal().into_response()
}

#[cfg(test)]
mod tests {
    use axum::routing::get;
    use tower::ServiceExt;

    use super::*;
    use crate::service::config::HttpConfig;

    #[tokio::test]
    async fn a_panic_is_a_problem_that_names_the_request() {
        let routes = Router::new().route(
            "/",
            get(|| async {
                if true {
                    panic!("on purpose")
                }
            }),
        );
        let access = Access::new(&HttpConfig::default(), [127, 0, 0, 1].into());
        let response = wrap(routes, &access).oneshot(Request::get("/").body(Body::empty()).unwrap()).await.unwrap();
        assert_eq!(response.status(), 500);
        assert_eq!(response.headers()["content-type"], "application/problem+json");
        let id = response.headers()["x-request-id"].to_str().unwrap().to_owned();
        let body = axum::body::to_bytes(response.into_body(), 1 << 16).await.unwrap();
        let body: serde_json::Value = serde_json::from_slice(&body).unwrap();
        assert_eq!(body["instance"], format!("urn:request:{id}"));
        assert!(!body["detail"].as_str().unwrap().contains("on purpose"));
    }
}
