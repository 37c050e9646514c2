//! Answers are compressed by `Accept-Encoding`, as they are sent: a few KiB at a time, so that no thread is kept from its
//! other connections.
//!
//! What is compressed has other bytes than the file, so its entity tag is only a weak one and it has no ranges; a range of
//! the file is never compressed.

use axum::Router;
use axum::http::{Extensions, HeaderMap, HeaderValue, StatusCode, Version, header};
use axum::middleware::map_response;
use axum::response::Response;
use tower_http::CompressionLevel;
use tower_http::compression::CompressionLayer;
use tower_http::compression::predicate::{Predicate, SizeAbove};

use crate::service::http::extract::text;

/// Bytes below which compression costs more than it saves.
const WORTHWHILE: u64 = 1024;

/// Compresses the answers of `routes`.
pub(super) fn wrap(routes: Router) -> Router {
    let layer = CompressionLayer::new()
        .quality(CompressionLevel::Fastest)
        .compress_when(SizeAbove::new(WORTHWHILE).and(of_text));
    routes.layer(map_response(note_status)).layer(layer).layer(map_response(relabel))
}

/// Whether files of this media type shrink. Pictures, archives and GLB hardly do; events must not wait for each other.
pub(super) fn shrinks(media_type: &str) -> bool {
    let name = media_type.split(';').next().unwrap_or_default().trim();
    matches!(name, "application/json" | "application/problem+json" | "application/ply" | "model/obj" | "model/vnd.usda")
        || (name.starts_with("text/") && name != "text/event-stream")
}

fn of_text(_: StatusCode, _: Version, headers: &HeaderMap, _: &Extensions) -> bool {
    text(headers, "content-type").is_some_and(shrinks)
}

/// The status before compression.
#[derive(Clone, Copy)]
struct OriginalStatus(StatusCode);

async fn note_status(mut response: Response) -> Response {
    let status = response.status();
    response.extensions_mut().insert(OriginalStatus(status));
    response
}

/// The layer turns answers into 406 whose client takes no encoding at all, though what was asked for has been done by
/// then: they are sent as they are, which RFC 9110, 12.5.3, allows.
async fn relabel(mut response: Response) -> Response {
    if let Some(OriginalStatus(status)) = response.extensions_mut().remove() {
        *response.status_mut() = status;
    }
    let encoded = response.headers().contains_key(header::CONTENT_ENCODING);
    let tag = text(response.headers(), "etag").filter(|tag| encoded && !tag.starts_with("W/"));
    if let Some(weak) = tag.and_then(|tag| HeaderValue::from_str(&format!("W/{tag}")).ok()) {
        response.headers_mut().insert(header::ETAG, weak);
    }
    response
}
