//! `/v1/methods`: what can be asked for.

use axum::Json;
use serde::Serialize;
use serde_json::{Map, Value, json};
use utoipa::{PartialSchema, ToSchema};

use crate::engine::methods::{self, MethodRef};
use crate::service::wire::{ResolvedSpec, defaults_of, own_schema};

/// A method.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct MethodBody {
    /// Value of the field `method` of a spec.
    name: &'static str,
    /// In one sentence.
    summary: &'static str,
    /// What it cannot do in this version.
    cannot: Vec<&'static str>,
    /// JSON Schema of the spec, with the method's own parameters under `params`.
    parameters: Value,
    /// The spec when nothing but the method is said.
    defaults: ResolvedSpec,
}

/// All methods.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct MethodList {
    /// The methods.
    methods: Vec<MethodBody>,
}

/// Lists the methods with their parameters, defaults, and what each one cannot do.
#[utoipa::path(get, path = "/v1/methods", tag = "about", operation_id = "list_methods",
    responses((status = 200, description = "The methods", body = MethodList)))]
pub(super) async fn list_methods() -> Json<MethodList> {
    Json(MethodList { methods: methods::all().into_iter().map(body).collect() })
}

fn body(method: MethodRef) -> MethodBody {
    MethodBody {
        name: method.name(),
        summary: method.0.summary(),
        cannot: method.0.cannot().iter().chain(CANNOT).copied().collect(),
        parameters: spec_schema(method),
        defaults: defaults_of(method),
    }
}

/// What no method can do in this version.
const CANNOT: &[&str] = &[
    "quad-dominant meshes (output)",
    "follow a field that is a second file of an upload (field)",
    "find symmetries other than mirror planes at right angles to each other (symmetry)",
    "symmetry of models further than 5 % of their diagonal from their mirror image (symmetry)",
    "carry animations, morph targets, or what materials of an OBJ are besides their names (preserve)",
];

/// The schema of the spec on its own, with everything it refers to under `$defs`.
fn spec_schema(method: MethodRef) -> Value {
    let mut parts = Vec::new();
    ResolvedSpec::schemas(&mut parts);
    let definitions: Map<String, Value> = parts.into_iter().map(|(name, schema)| (name, json!(schema))).collect();
    let mut schema = json!(ResolvedSpec::schema());
    schema["properties"]["params"] = json!(own_schema(method));
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema".into();
    schema["$defs"] = definitions.into();
    relocate(&mut schema);
    schema
}

/// Points references at `$defs` instead of the components of an OpenAPI document.
fn relocate(value: &mut Value) {
    match value {
        Value::Object(members) => {
            for (name, member) in members.iter_mut() {
                match member {
                    Value::String(target) if name == "$ref" => {
                        *target = target.replace("#/components/schemas/", "#/$defs/");
                    }
                    _ => relocate(member),
                }
            }
        }
        Value::Array(items) => items.iter_mut().for_each(relocate),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn references(value: &Value, found: &mut Vec<String>) {
        match value {
            Value::Object(members) => {
                found.extend(members.get("$ref").and_then(Value::as_str).map(str::to_owned));
                members.values().for_each(|member| references(member, found));
            }
            Value::Array(items) => items.iter().for_each(|item| references(item, found)),
            _ => {}
        }
    }

    #[test]
    fn the_schema_of_the_spec_stands_on_its_own() {
        let schema = spec_schema(MethodRef::default());
        let mut found = Vec::new();
        references(&schema, &mut found);
        assert!(!found.is_empty());
        for reference in found {
            assert!(schema.pointer(reference.trim_start_matches('#')).is_some(), "{reference}");
        }
        assert_eq!(schema.pointer("/properties/params/properties/branch_price/default"), Some(&json!(0.3)));
        let properties = schema["properties"].as_object().unwrap();
        for field in json!(ResolvedSpec::default()).as_object().unwrap().keys() {
            assert!(properties.contains_key(field), "{field}");
        }
    }
}
