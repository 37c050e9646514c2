//! The two pages, which load nothing from anywhere else.

use axum::extract::State;
use axum::http::{HeaderName, header};
use axum::response::Html;

use crate::service::http::HttpState;
use crate::service::http::openapi::document;

const INDEX: &str = include_str!("../../../web/index.html");
const DOCS: &str = include_str!("../../../web/docs.html");

/// Scripts and styles are inside the page; nothing comes from elsewhere.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src 'self' blob:; \
                      connect-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'";

type Page = ([(HeaderName, &'static str); 1], Html<&'static str>);

fn page(html: &'static str) -> Page {
    ([(header::CONTENT_SECURITY_POLICY, POLICY)], Html(html))
}

/// The page for people: upload, progress, picture, downloads.
pub(super) async fn index() -> Page {
    page(INDEX)
}

/// The API, browsable.
pub(super) async fn docs() -> Page {
    page(DOCS)
}

/// The document that `/docs` shows.
pub(super) async fn openapi(State(_): State<HttpState>) -> ([(HeaderName, &'static str); 1], &'static str) {
    ([(header::CONTENT_TYPE, "application/json")], document())
}
