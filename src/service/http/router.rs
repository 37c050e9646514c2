//! The whole HTTP service: the routes of the document, the pages, and what lies around them.

use axum::Router;
use axum::http::Uri;
use axum::middleware::from_fn_with_state;
use axum::routing::get;

use crate::service::http::openapi::document;
use crate::service::http::routes::routes;
use crate::service::http::{HttpState, body, layers, pages};
use crate::service::wire::{Problem, ProblemKind};

/// The whole HTTP service.
pub fn router(state: HttpState) -> Router {
    let (api, _) = routes().split_for_parts();
    let access = state.access.clone();
    let all = api
        .route("/openapi.json", get(pages::openapi))
        .route("/docs", get(pages::docs))
        .route("/", get(pages::index))
        .fallback(unknown_route)
        .method_not_allowed_fallback(wrong_method)
        .layer(from_fn_with_state(state.clone(), body::guard))
        .with_state(state);
    layers::wrap(all, &access)
}

/// The OpenAPI document of the handlers, as pretty JSON with a final newline: `api/openapi.json`.
pub fn openapi_json() -> String {
    document().to_owned()
}

async fn unknown_route(uri: Uri) -> Problem {
    Problem::new(ProblemKind::NotFound, format!("There is no route {}; see /docs.", uri.path()))
}

async fn wrong_method(uri: Uri) -> Problem {
    Problem::new(ProblemKind::MethodNotAllowed, format!("{} exists, but not with this method; see /docs.", uri.path()))
}
