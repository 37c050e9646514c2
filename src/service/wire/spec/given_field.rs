//! A given field: vectors per polygon of the input.

use std::sync::Arc;

use glam::DVec3;
use serde_json::value::RawValue;
use serde_json::{Value, json};
use utoipa::openapi::schema::{AdditionalProperties, ArrayBuilder, ObjectBuilder, OneOfBuilder, Type};
use utoipa::openapi::{Ref, RefOr, Schema};

use crate::engine::pipeline::{GivenBranchPoints, GivenField, GivenMatching, GivenVectors};
use crate::service::wire::fields::Violations;
use crate::service::wire::spec::field::{Component, FlagText, Kind, Values, json as raw};
use crate::service::wire::spec::lists::{count, count_component, count_reference, read_list};
use crate::service::wire::spec::one_of::one_of;

const SCHEMA: &str = "FieldBody";
/// Most polygons that a field is for: as many as a model may have.
const MAX_POLYGONS: usize = 10_000_000;
/// Triangles have half as many edges again.
const MAX_MATCHINGS: usize = 15_000_000;

/// `{"crosses": […]}` or `{"frames": […]}`, with `matchings` and `branch_points`; or nothing.
pub(super) struct Given;

fn numbers(least: usize) -> ArrayBuilder {
    let number = ObjectBuilder::new().schema_type(Type::Number);
    ArrayBuilder::new().items(number).min_items(Some(least)).max_items(Some(least))
}

impl Values for Given {
    fn allowed(&self) -> String {
        "`{\"crosses\": [[x, y, z], …]}` or `{\"frames\": [[[x, y, z], [x, y, z]], …]}`, one entry per polygon of the input, \
         with `matchings` and `branch_points` where wanted"
            .to_owned()
    }

    fn schema(&self) -> RefOr<Schema> {
        let null = ObjectBuilder::new().schema_type(Type::Null);
        OneOfBuilder::new().item(null).item(Ref::from_schema_name(SCHEMA)).into()
    }

    fn summary_schema(&self) -> RefOr<Schema> {
        let null = ObjectBuilder::new().schema_type(Type::Null);
        OneOfBuilder::new().item(null).item(count_reference()).into()
    }

    fn components(&self) -> Vec<Component> {
        let list = |items: ArrayBuilder, most: usize, help: &str| {
            ArrayBuilder::new().items(items).max_items(Some(most)).description(Some(help))
        };
        let pair = ArrayBuilder::new().items(numbers(3)).min_items(Some(2)).max_items(Some(2));
        let whole = ObjectBuilder::new().schema_type(Type::Integer).minimum(Some(0));
        let matching = ArrayBuilder::new().items(whole).min_items(Some(3)).max_items(Some(3));
        let schema = ObjectBuilder::new()
            .description(Some(
                "A field to follow instead of one from curvature: exactly one of `crosses` and `frames`, an entry per \
                 polygon of the input in the order of its file.",
            ))
            .property("crosses", list(numbers(3), MAX_POLYGONS, "One direction of each cross, of any length but 0."))
            .property(
                "frames",
                list(pair, MAX_POLYGONS, "The gradients of u and v up to one factor, of any length but 0 and not parallel."),
            )
            .property(
                "matchings",
                list(
                    matching,
                    MAX_MATCHINGS,
                    "Triples `[f, g, k]` of neighbouring polygons: direction d of f goes on as d + k of g, where directions 0 \
                     to 3 are the first, the second, and both reversed. Other pairs are matched by the smallest turn.",
                ),
            )
            .property("branch_points", one_of::<GivenBranchPoints>().schema())
            .additional_properties(Some(AdditionalProperties::FreeForm(false)));
        let mut components = vec![(SCHEMA.to_owned(), schema.into()), count_component()];
        components.extend(one_of::<GivenBranchPoints>().components());
        components
    }

    fn flag_text(&self) -> FlagText {
        FlagText::FieldFile
    }

    fn is_long(&self) -> bool {
        true
    }
}

impl Kind for Given {
    type Value = Option<Arc<GivenField>>;

    fn read(&self, json: &str, violations: &mut Violations<'_>) -> Option<Self::Value> {
        const MEMBERS: [&str; 4] = ["crosses", "frames", "matchings", "branch_points"];
        let [crosses, frames, matchings, branch_points] =
            violations.object(json, |fields| MEMBERS.map(|name| fields.take(name)))?;
        let vectors = match (crosses, frames) {
            (Some(crosses), None) => {
                let mut below = violations.below("crosses");
                let vectors = read_list::<[f64; 3], MAX_POLYGONS>(crosses, &mut below)?;
                refuse_zero(vectors.iter().map(|vector| vector.as_slice()), &mut below);
                GivenVectors::Crosses(vectors.into_iter().map(DVec3::from_array).collect())
            }
            (None, Some(frames)) => {
                let mut below = violations.below("frames");
                let frames = read_list::<[[f64; 3]; 2], MAX_POLYGONS>(frames, &mut below)?;
                for k in 0..2 {
                    refuse_zero(frames.iter().map(|frame| frame[k].as_slice()), &mut below);
                }
                GivenVectors::Frames(frames.into_iter().map(|frame| frame.map(DVec3::from_array)).collect())
            }
            _ => {
                violations.add("", "must have exactly one of crosses, frames");
                return None;
            }
        };
        let mut below = violations.below("matchings");
        let triples = match matchings {
            Some(matchings) => read_list::<[u32; 3], MAX_MATCHINGS>(matchings, &mut below)?,
            None => Vec::new(),
        };
        for (i, triple) in triples.iter().enumerate().filter(|(_, triple)| triple[2] > 3) {
            below.add(&format!("/{i}"), format!("quarter turns are 0 to 3, not {}", triple[2]));
        }
        let matching = |[from, to, quarters]: [u32; 3]| GivenMatching { from, to, quarters: quarters.min(3) as u8 };
        let branch_points = match branch_points {
            Some(name) => one_of::<GivenBranchPoints>().read(name, &mut violations.below("branch_points"))?,
            None => GivenBranchPoints::default(),
        };
        let matchings = triples.into_iter().map(matching).collect();
        Some(Some(Arc::new(GivenField { vectors, matchings, branch_points })))
    }

    fn write(&self, value: &Self::Value) -> serde_json::Result<Box<RawValue>> {
        let Some(field) = value else { return raw(&Value::Null) };
        let (name, vectors) = match &field.vectors {
            GivenVectors::Crosses(vectors) => {
                ("crosses", raw(&vectors.iter().map(DVec3::to_array).collect::<Vec<_>>())?)
            }
            GivenVectors::Frames(frames) => {
                let frames: Vec<_> = frames.iter().map(|[x, y]| [x.to_array(), y.to_array()]).collect();
                ("frames", raw(&frames)?)
            }
        };
        let triples: Vec<_> = field.matchings.iter().map(|m| [m.from, m.to, u32::from(m.quarters)]).collect();
        let branch_points = one_of::<GivenBranchPoints>().write(&field.branch_points)?;
        let text = format!(
            "{{\"{name}\":{},\"matchings\":{},\"branch_points\":{}}}",
            vectors.get(),
            raw(&triples)?.get(),
            branch_points.get()
        );
        RawValue::from_string(text)
    }

    fn summary(&self, value: &Self::Value) -> Value {
        value.as_ref().map_or(json!(null), |field| count(field.vectors.len()))
    }
}

/// Notes vectors that are zero.
fn refuse_zero<'v>(vectors: impl Iterator<Item = &'v [f64]>, violations: &mut Violations<'_>) {
    for (i, _) in vectors.enumerate().filter(|(_, vector)| vector.iter().all(|x| *x == 0.0)) {
        violations.add(&format!("/{i}"), "must not be zero");
    }
}

/// The JSON of a given field, as in a spec.
pub(in crate::service) fn json_of_field(field: GivenField) -> serde_json::Result<String> {
    Given.write(&Some(Arc::new(field))).map(|json| json.get().to_owned())
}
