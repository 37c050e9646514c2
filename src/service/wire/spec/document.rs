//! A valid spec as text: the whole of it with all defaults, and a summary whose size does not depend on the model.

use serde::{Deserialize, Serialize, Serializer};
use serde_json::value::RawValue;
use serde_json::{Map, Value};
use sha2::{Digest, Sha256};

use crate::service::wire::Problem;
use crate::service::wire::spec::{FIELDS, ResolvedSpec};

/// A spec with all defaults filled in, where long lists are given by their length.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct SpecSummary(pub(super) Map<String, Value>);

/// A valid spec as it is kept.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecDocument {
    /// JSON with all defaults filled in.
    pub text: String,
    /// SHA-256 of the text.
    pub sha256: [u8; 32],
    /// For lists and events.
    pub summary: SpecSummary,
    /// Name of the method.
    pub method: &'static str,
    /// Seconds of run time.
    pub deadline_s: f64,
    /// Labels for listing.
    pub tags: Vec<String>,
    /// −100 to 100; higher runs earlier.
    pub priority: i32,
}

impl SpecDocument {
    /// Writes a spec down. With long lists this takes a while.
    ///
    /// # Errors
    /// None that a spec could cause.
    pub fn of(spec: &ResolvedSpec) -> Result<Self, Problem> {
        let text = spec.to_json().map_err(|error| {
            tracing::error!(%error, "a spec cannot be written as JSON");
            Problem::internal()
        })?;
        Ok(Self {
            sha256: Sha256::digest(&text).into(),
            text,
            summary: spec.summary(),
            method: spec.spec.method.name(),
            deadline_s: spec.options.deadline_s,
            tags: spec.options.tags.clone(),
            priority: spec.options.priority,
        })
    }
}

impl ResolvedSpec {
    /// The whole spec as JSON, in the order of the table.
    fn to_json(&self) -> serde_json::Result<String> {
        let mut text = String::from("{");
        let mut open = None;
        for field in FIELDS {
            let (group, name) = field.path();
            if group != open {
                text.push_str(if open.is_some() { "}" } else { "" });
            }
            text.push_str(if text.ends_with('{') { "" } else { "," });
            if group != open
                && let Some(group) = group
            {
                text.push_str(&format!("\"{group}\":{{"));
            }
            open = group;
            text.push_str(&format!("\"{name}\":"));
            text.push_str((field.write)(self)?.get());
        }
        text.push_str(if open.is_some() { "}}" } else { "}" });
        Ok(text)
    }

    /// The spec with lists by their length.
    pub fn summary(&self) -> SpecSummary {
        let mut summary = Map::new();
        for field in FIELDS {
            let value = (field.summary)(self);
            match field.path() {
                (None, name) => {
                    summary.insert(name.to_owned(), value);
                }
                (Some(group), name) => {
                    if let Value::Object(members) = summary.entry(group).or_insert_with(|| Map::new().into()) {
                        members.insert(name.to_owned(), value);
                    }
                }
            }
        }
        SpecSummary(summary)
    }
}

impl Serialize for ResolvedSpec {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::Error;
        let text = self.to_json().and_then(RawValue::from_string).map_err(S::Error::custom)?;
        text.serialize(serializer)
    }
}
