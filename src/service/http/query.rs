//! Queries, as they are and as types; what is wrong with one is a problem.

use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use serde::de::DeserializeOwned;

use crate::service::wire::{Problem, ProblemKind};

/// The query as a type; unknown keys are refused where the type refuses them.
#[derive(Debug)]
pub(super) struct Query<T>(pub(super) T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequestParts<S> for Query<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Problem> {
        axum::extract::Query::try_from_uri(&parts.uri)
            .map(|axum::extract::Query(query)| Self(query))
            .map_err(|rejection| invalid(rejection.body_text()))
    }
}

/// The pairs of a query that nobody has taken yet, for queries in which keys may repeat.
#[derive(Debug)]
pub(super) struct Pairs {
    pairs: Vec<(String, String)>,
    known: Vec<&'static str>,
}

impl<S: Send + Sync> FromRequestParts<S> for Pairs {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Problem> {
        Ok(Self::of(parts.uri.query().unwrap_or_default()))
    }
}

fn invalid(detail: String) -> Problem {
    Problem::new(ProblemKind::InvalidRequest, detail)
}

impl Pairs {
    fn of(query: &str) -> Self {
        Self { pairs: form_urlencoded::parse(query.as_bytes()).into_owned().collect(), known: Vec::new() }
    }

    fn take(&mut self, key: &'static str) -> Vec<String> {
        self.known.push(key);
        let (taken, left) = std::mem::take(&mut self.pairs).into_iter().partition(|(known, _)| known == key);
        self.pairs = left;
        let taken: Vec<(String, String)> = taken;
        taken.into_iter().map(|(_, value)| value).collect()
    }

    /// The value of a key that may come once.
    pub(super) fn one(&mut self, key: &'static str) -> Result<Option<String>, Problem> {
        let mut values = self.take(key);
        if values.len() > 1 {
            return Err(invalid(format!("{key} comes more than once.")));
        }
        Ok(values.pop())
    }

    /// All values of a key, which are joined by commas or come one by one.
    pub(super) fn list(&mut self, key: &'static str) -> Vec<String> {
        let values = self.take(key);
        let single = values.iter().flat_map(|value| value.split(',')).map(str::trim);
        single.filter(|value| !value.is_empty()).map(str::to_owned).collect()
    }

    /// Every key that nobody asked for is refused.
    pub(super) fn finish(self) -> Result<(), Problem> {
        match self.pairs.first() {
            None => Ok(()),
            Some((key, _)) => Err(invalid(format!("Unknown key `{key}`; known are {}.", self.known.join(", ")))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_joined_or_repeated_and_nothing_is_overlooked() {
        let mut pairs = Pairs::of("tag=a,b%2Cc&limit=3&tag=d&tag=&x=1");
        assert_eq!(pairs.list("tag"), ["a", "b", "c", "d"]);
        assert_eq!(pairs.one("limit").unwrap().as_deref(), Some("3"));
        assert_eq!(pairs.one("cursor").unwrap(), None);
        assert!(pairs.finish().is_err());
        assert!(Pairs::of("limit=1&limit=2").one("limit").is_err());
    }
}
