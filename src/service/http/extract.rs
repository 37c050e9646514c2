//! Extractors whose rejections are problems.

use axum::extract::{FromRequestParts, RawPathParams};
use axum::http::HeaderMap;
use axum::http::request::Parts;
use uuid::Uuid;

use crate::service::wire::{Problem, ProblemKind};

/// The id in the path. What is no id names nothing: 404.
#[derive(Clone, Copy, Debug)]
pub(super) struct Id(pub(super) Uuid);

impl<S: Send + Sync> FromRequestParts<S> for Id {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Problem> {
        // What does not decode to text is no id either.
        let params = RawPathParams::from_request_parts(parts, state).await.ok();
        let text = params.as_ref().and_then(|params| params.iter().find(|(name, _)| *name == "id"));
        let id = text.and_then(|(_, id)| id.parse().ok());
        id.map(Self).ok_or_else(|| Problem::new(ProblemKind::NotFound, "The id is not a UUID."))
    }
}

/// The job `id` does not exist.
pub(super) fn no_job(id: Uuid) -> Problem {
    Problem::new(ProblemKind::NotFound, format!("There is no job {id}; it may have expired or been deleted."))
}

/// Text of a header, where it is given once and is text.
pub(super) fn text<'h>(headers: &'h HeaderMap, name: &str) -> Option<&'h str> {
    headers.get(name).and_then(|value| value.to_str().ok()).map(str::trim)
}

/// Seconds of `Prefer: wait=N`, at most 60.
pub(super) fn wait_seconds(headers: &HeaderMap) -> Option<u64> {
    let preferences = headers.get_all("prefer").iter().filter_map(|value| value.to_str().ok());
    let mut waits = preferences.flat_map(|value| value.split([',', ';'])).filter_map(|preference| {
        let (name, value) = preference.split_once('=')?;
        let value = value.trim().trim_matches('"');
        name.trim().eq_ignore_ascii_case("wait").then(|| value.parse::<u64>().ok())?
    });
    waits.next().map(|seconds| seconds.min(60))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preferences_are_read_as_rfc_7240_writes_them() {
        let wait = |value: &'static str| {
            let mut headers = HeaderMap::new();
            headers.insert("prefer", value.parse().unwrap());
            wait_seconds(&headers)
        };
        assert_eq!(wait("wait=5"), Some(5));
        assert_eq!(wait("respond-async, wait=100"), Some(60));
        assert_eq!(wait("Wait = \"7\""), Some(7));
        assert_eq!(wait("respond-async"), None);
        assert_eq!(wait("wait=soon"), None);
    }
}
