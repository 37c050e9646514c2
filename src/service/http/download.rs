//! Finished files: strong entity tags, conditional requests, byte ranges (RFC 9110).

use std::ops::Range;

use axum::body::Body;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;

use crate::service::http::extract::text;
use crate::service::http::names::{Disposition, content_disposition};
use crate::service::store::Blobs;
use crate::service::wire::{Problem, ProblemKind};

/// Where the bytes of a download are.
pub(super) enum Source<'a> {
    /// In the object store under this key.
    Blob(&'a Blobs, &'a str),
    /// Here.
    Bytes(Bytes),
}

/// A file to be downloaded.
pub(super) struct Download<'a> {
    pub(super) source: Source<'a>,
    /// Hexadecimal hash of the bytes, or of all that determines them.
    pub(super) sha256: &'a str,
    /// Length of the whole file.
    pub(super) bytes: u64,
    pub(super) media_type: &'a str,
    /// Name that browsers save it under.
    pub(super) file_name: String,
    /// Whether they save it or show it.
    pub(super) disposition: Disposition,
}

/// The entity tag under which the client of a GET with these headers has the file with this hash.
pub(super) fn known_tag(request: &HeaderMap, sha256: &str) -> Option<String> {
    let (tags, strong) = (text(request, "if-none-match")?, tag(sha256));
    let weak = format!("W/{strong}");
    // Whoever has compressed bytes has a weak tag only, and keeps it.
    let by = |own: &str| tags.split(',').any(|tag| tag.trim() == own);
    if tags == "*" || by(&strong) { Some(strong) } else { by(&weak).then_some(weak) }
}

pub(super) fn tag(sha256: &str) -> String {
    format!("\"{sha256}\"")
}

impl<'a> Download<'a> {
    /// A PNG to be shown in place.
    pub(super) fn picture(png: Bytes, sha256: &'a str, media_type: &'a str, file_name: String) -> Self {
        let bytes = png.len() as u64;
        let disposition = Disposition::Inline;
        Self { source: Source::Bytes(png), sha256, bytes, media_type, file_name, disposition }
    }

    /// The answer to a client that has the file under the entity tag `known`.
    pub(super) fn not_modified(&self, known: &str) -> Response {
        self.headed(StatusCode::NOT_MODIFIED, known, Body::empty())
    }

    /// The answer to a GET with these headers.
    pub(super) async fn respond(self, request: &HeaderMap) -> Result<Response, Problem> {
        if let Some(known) = known_tag(request, self.sha256) {
            return Ok(self.not_modified(&known));
        }
        let etag = tag(self.sha256);
        let fresh = text(request, "if-range").is_none_or(|tag| tag == etag);
        let range = text(request, "range").filter(|_| fresh).and_then(|range| parse_range(range, self.bytes));
        let (status, range) = match range {
            None => (StatusCode::OK, 0..self.bytes),
            Some(Some(range)) => (StatusCode::PARTIAL_CONTENT, range),
            Some(None) => {
                let detail = format!("The file has {} bytes.", self.bytes);
                let mut response = Problem::new(ProblemKind::RangeNotSatisfiable, detail).into_response();
                insert(&mut response, header::CONTENT_RANGE, &format!("bytes */{}", self.bytes));
                return Ok(response);
            }
        };
        let body = match &self.source {
            Source::Blob(blobs, key) => Body::from_stream(blobs.stream(key, range.clone()).await?),
            Source::Bytes(bytes) => Body::from(bytes.slice(range.start as usize..range.end as usize)),
        };
        let mut response = self.headed(status, &etag, body);
        insert(&mut response, header::CONTENT_LENGTH, &(range.end - range.start).to_string());
        if status == StatusCode::PARTIAL_CONTENT {
            let content = format!("bytes {}-{}/{}", range.start, range.end - 1, self.bytes);
            insert(&mut response, header::CONTENT_RANGE, &content);
        }
        Ok(response)
    }

    fn headed(&self, status: StatusCode, etag: &str, body: Body) -> Response {
        let mut response = (status, body).into_response();
        insert(&mut response, header::ETAG, etag);
        insert(&mut response, header::CONTENT_TYPE, self.media_type);
        insert(&mut response, header::ACCEPT_RANGES, "bytes");
        insert(&mut response, header::VARY, "accept, accept-encoding");
        insert(&mut response, header::CACHE_CONTROL, "private, max-age=3600");
        insert(&mut response, header::CONTENT_DISPOSITION, &content_disposition(self.disposition, &self.file_name));
        response
    }
}

pub(super) fn insert(response: &mut Response, name: header::HeaderName, value: &str) {
    if let Ok(value) = HeaderValue::from_str(value) {
        response.headers_mut().insert(name, value);
    }
}

/// One range of a file of `length` bytes. `None`: not one range of bytes, so the whole file is sent. `Some(None)`: outside
/// the file.
fn parse_range(header: &str, length: u64) -> Option<Option<Range<u64>>> {
    let (first, last) = header.strip_prefix("bytes=")?.trim().split_once('-')?;
    let range = match (first.trim(), last.trim()) {
        ("", last) => length.saturating_sub(last.parse().ok()?)..length,
        (first, "") => first.parse().ok()?..length,
        (first, last) => {
            let (first, last): (u64, u64) = (first.parse().ok()?, last.parse().ok()?);
            if last < first {
                return None;
            }
            first..last.saturating_add(1).min(length)
        }
    };
    Some((range.start < range.end).then_some(range))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_follow_rfc_9110() {
        assert_eq!(parse_range("bytes=0-3", 10), Some(Some(0..4)));
        assert_eq!(parse_range("bytes=4-", 10), Some(Some(4..10)));
        assert_eq!(parse_range("bytes=-3", 10), Some(Some(7..10)));
        assert_eq!(parse_range("bytes=-30", 10), Some(Some(0..10)));
        assert_eq!(parse_range("bytes=8-99", 10), Some(Some(8..10)));
        assert_eq!(parse_range("bytes=10-", 10), Some(None));
        assert_eq!(parse_range("bytes=-0", 10), Some(None));
        assert_eq!(parse_range("bytes=3-2", 10), None);
        assert_eq!(parse_range("bytes=0-1,3-4", 10), None);
        assert_eq!(parse_range("lines=0-1", 10), None);
    }

    #[test]
    fn entity_tags_are_compared_weakly() {
        let known = |tags: &'static str| {
            let mut headers = HeaderMap::new();
            headers.insert("if-none-match", HeaderValue::from_static(tags));
            known_tag(&headers, "a")
        };
        assert_eq!(known("\"x\", W/\"a\"").as_deref(), Some("W/\"a\""));
        assert_eq!(known("\"x\",\"a\"").as_deref(), Some("\"a\""));
        assert_eq!(known("*").as_deref(), Some("\"a\""));
        assert_eq!(known("\"b\""), None);
    }
}
