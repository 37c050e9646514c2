//! Lists: each has its limit while it is read, so that what a client sends cannot grow in memory.

use std::fmt;
use std::marker::PhantomData;

use glam::DVec3;
use serde::de::{DeserializeOwned, Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::Value;
use serde_json::value::RawValue;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};
use utoipa::openapi::{Ref, RefOr, Schema};

use crate::service::wire::fields::Violations;
use crate::service::wire::spec::field::{Component, Kind, Values, json};

const MAX_FEATURE_EDGES: usize = 1_000_000;
const MAX_STROKE_POINTS: usize = 100_000;
/// Every stroke has at least two points.
const MAX_STROKES: usize = MAX_STROKE_POINTS / 2;
const MAX_TAGS: usize = 16;
const MAX_TAG_LENGTH: usize = 64;
const COUNT_SCHEMA: &str = "ListSummary";

/// A list of at most `N` items; reading stops at the one too many.
struct AtMost<T, const N: usize>(Vec<T>);

impl<'de, T: Deserialize<'de>, const N: usize> Deserialize<'de> for AtMost<T, N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader<T, const N: usize>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>, const N: usize> Visitor<'de> for Reader<T, N> {
            type Value = AtMost<T, N>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a list of at most {N}")
            }

            fn visit_seq<S: SeqAccess<'de>>(self, mut list: S) -> Result<AtMost<T, N>, S::Error> {
                let mut items = Vec::new();
                while let Some(item) = list.next_element()? {
                    if items.len() == N {
                        return Err(S::Error::custom(format!("must be a list of at most {N}")));
                    }
                    items.push(item);
                }
                Ok(AtMost(items))
            }
        }
        deserializer.deserialize_seq(Reader(PhantomData))
    }
}

/// Reads a list of at most `N`.
pub(super) fn read_list<T: DeserializeOwned, const N: usize>(
    json: &str,
    violations: &mut Violations<'_>,
) -> Option<Vec<T>> {
    violations.parse::<AtMost<T, N>>(json).map(|list| list.0)
}

/// A list is its length in summaries.
pub(super) fn count(n: usize) -> Value {
    serde_json::json!({ "count": n })
}

pub(super) fn count_reference() -> RefOr<Schema> {
    Ref::from_schema_name(COUNT_SCHEMA).into()
}

pub(super) fn count_component() -> Component {
    let schema = ObjectBuilder::new()
        .property("count", ObjectBuilder::new().schema_type(Type::Integer).minimum(Some(0)))
        .required("count")
        .description(Some("How long a list is; the list itself is in the whole spec, `/v1/jobs/{id}/spec`."));
    (COUNT_SCHEMA.to_owned(), schema.into())
}

/// Labels for listing.
pub(super) struct Labels;

impl Values for Labels {
    fn allowed(&self) -> String {
        format!("list of at most {MAX_TAGS}, each of 1 to {MAX_TAG_LENGTH} characters")
    }

    fn schema(&self) -> RefOr<Schema> {
        let tag = ObjectBuilder::new().schema_type(Type::String).min_length(Some(1)).max_length(Some(MAX_TAG_LENGTH));
        ArrayBuilder::new().items(tag).max_items(Some(MAX_TAGS)).into()
    }
}

impl Kind for Labels {
    type Value = Vec<String>;

    fn read(&self, json: &str, violations: &mut Violations<'_>) -> Option<Vec<String>> {
        let tags = read_list::<String, MAX_TAGS>(json, violations)?;
        for (i, tag) in tags.iter().enumerate() {
            let length = tag.chars().count();
            if length == 0 || length > MAX_TAG_LENGTH {
                violations.add(&format!("/{i}"), format!("must have 1 to {MAX_TAG_LENGTH} characters, not {length}"));
            }
        }
        Some(tags)
    }

    fn write(&self, value: &Vec<String>) -> serde_json::Result<Box<RawValue>> {
        json(value)
    }
}

/// Pairs of vertices of the input.
pub(super) struct Edges;

impl Values for Edges {
    fn allowed(&self) -> String {
        format!("list of at most {MAX_FEATURE_EDGES} pairs `[a, b]`")
    }

    fn schema(&self) -> RefOr<Schema> {
        let vertex = ObjectBuilder::new().schema_type(Type::Integer).minimum(Some(0)).maximum(Some(u32::MAX as usize));
        let pair = ArrayBuilder::new().items(vertex).min_items(Some(2)).max_items(Some(2));
        ArrayBuilder::new().items(pair).max_items(Some(MAX_FEATURE_EDGES)).into()
    }

    fn summary_schema(&self) -> RefOr<Schema> {
        count_reference()
    }

    fn components(&self) -> Vec<Component> {
        vec![count_component()]
    }

    fn is_long(&self) -> bool {
        true
    }
}

impl Kind for Edges {
    type Value = Vec<[u32; 2]>;

    fn read(&self, json: &str, violations: &mut Violations<'_>) -> Option<Self::Value> {
        read_list::<[u32; 2], MAX_FEATURE_EDGES>(json, violations)
    }

    fn write(&self, value: &Self::Value) -> serde_json::Result<Box<RawValue>> {
        json(value)
    }

    fn summary(&self, value: &Self::Value) -> Value {
        count(value.len())
    }
}

/// Polylines in model units.
pub(super) struct Strokes;

impl Values for Strokes {
    fn allowed(&self) -> String {
        format!("list of polylines `[[x, y, z], …]`, at most {MAX_STROKE_POINTS} points in all")
    }

    fn schema(&self) -> RefOr<Schema> {
        let coordinate = ObjectBuilder::new().schema_type(Type::Number);
        let point = ArrayBuilder::new().items(coordinate).min_items(Some(3)).max_items(Some(3));
        let line = ArrayBuilder::new().items(point).min_items(Some(2));
        ArrayBuilder::new().items(line).max_items(Some(MAX_STROKES)).into()
    }

    fn summary_schema(&self) -> RefOr<Schema> {
        count_reference()
    }

    fn components(&self) -> Vec<Component> {
        vec![count_component()]
    }

    fn is_long(&self) -> bool {
        true
    }
}

impl Kind for Strokes {
    type Value = Vec<Vec<DVec3>>;

    fn read(&self, json: &str, violations: &mut Violations<'_>) -> Option<Self::Value> {
        let lines = read_list::<AtMost<[f64; 3], MAX_STROKE_POINTS>, MAX_STROKES>(json, violations)?;
        let points: usize = lines.iter().map(|line| line.0.len()).sum();
        if points > MAX_STROKE_POINTS {
            violations.add("", format!("must have at most {MAX_STROKE_POINTS} points in all, not {points}"));
        }
        for (i, _) in lines.iter().enumerate().filter(|(_, line)| line.0.len() < 2) {
            violations.add(&format!("/{i}"), "must have at least two points");
        }
        Some(lines.into_iter().map(|line| line.0.into_iter().map(DVec3::from_array).collect()).collect())
    }

    fn write(&self, value: &Self::Value) -> serde_json::Result<Box<RawValue>> {
        json(&value.iter().map(|line| line.iter().map(DVec3::to_array).collect()).collect::<Vec<Vec<_>>>())
    }

    fn summary(&self, value: &Self::Value) -> Value {
        count(value.len())
    }
}
