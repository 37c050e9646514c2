//! The spec fields `method` and `params`. Method names, parameter schemas and limits are read from the engine's table
//! of methods, not repeated here.

use std::borrow::Cow;
use std::fmt::Write;
use std::sync::Arc;

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::value::RawValue;
use serde_json::{Map, Value, json};
use utoipa::openapi::schema::{AdditionalProperties, Object, ObjectBuilder, Type};
use utoipa::openapi::{Ref, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

use crate::engine::methods::{
    self, Data, Method, MethodRef, Parameter, Parameters, Range, STANDARD, Shape, Value as Given,
};
use crate::service::wire::data::{data_of, json_of};
use crate::service::wire::fields::Violations;
use crate::service::wire::spec::ResolvedSpec;
use crate::service::wire::spec::field::{Component, Field, Flag, FlagText, Kind, Values, json as raw};

const SCHEMA: &str = "MethodName";
const PARAMS: &str = "ParamsBody";
/// Names reserved for methods of later versions; they are refused with a message that says so.
const RESERVED_NAMES: &[&str] = &["layout"];

/// A method by name, as in a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MethodName(pub MethodRef);

impl MethodName {
    fn of_name(name: &str) -> Result<Self, String> {
        if let Some(method) = methods::by_name(name) {
            return Ok(Self(method));
        }
        let names: Vec<&str> = methods::all().iter().map(|method| method.name()).collect();
        let names = names.join(", ");
        if RESERVED_NAMES.contains(&name) {
            return Err(format!("{name} is not available in this version; there is {names}"));
        }
        Err(format!("unknown; there is {names}"))
    }
}

impl Serialize for MethodName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.name())
    }
}

impl<'de> Deserialize<'de> for MethodName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = Cow::<'de, str>::deserialize(deserializer)?;
        Self::of_name(&name).map_err(D::Error::custom)
    }
}

impl PartialSchema for MethodName {
    fn schema() -> RefOr<Schema> {
        let lines: Vec<String> = STANDARD.iter().map(|m| format!("* `{}`: {}", m.name(), m.summary())).collect();
        let description = format!("Which system runs.\n\n{}", lines.join("\n"));
        let names: Vec<&str> = STANDARD.iter().map(|method| method.name()).collect();
        ObjectBuilder::new().schema_type(Type::String).enum_values(Some(names)).description(Some(description)).into()
    }
}

impl ToSchema for MethodName {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed(SCHEMA)
    }
}

/// One of the methods.
pub(super) struct OneMethod;

impl Values for OneMethod {
    fn allowed(&self) -> String {
        let names: Vec<String> = STANDARD.iter().map(|method| format!("`{}`", method.name())).collect();
        names.join(", ")
    }

    fn choices(&self) -> Vec<(&'static str, &'static str)> {
        STANDARD.iter().map(|method| (method.name(), method.summary())).collect()
    }

    fn schema(&self) -> RefOr<Schema> {
        Ref::from_schema_name(SCHEMA).into()
    }

    fn components(&self) -> Vec<Component> {
        vec![(SCHEMA.to_owned(), MethodName::schema())]
    }

    fn flag_text(&self) -> FlagText {
        FlagText::Name
    }
}

impl Kind for OneMethod {
    type Value = MethodRef;

    fn read(&self, json: &str, violations: &mut Violations<'_>) -> Option<MethodRef> {
        let name = violations.parse::<String>(json)?;
        MethodName::of_name(&name).map(|name| name.0).map_err(|message| violations.add("", message)).ok()
    }

    fn write(&self, value: &MethodRef) -> serde_json::Result<Box<RawValue>> {
        raw(&value.name())
    }
}

/// The value of `params`: an object with the parameters of the chosen method.
struct MethodParams;

/// The row `params` of the table of spec fields. It must come after the row `method`: reading it needs the method that
/// was chosen there.
pub(super) const PARAMETERS: Field = Field {
    name: "params",
    help: "Parameters of the method itself; see /v1/methods.",
    flags: &[Flag::new("param", "NAME=VALUE")],
    values: &MethodParams,
    read: |json, violations, spec| {
        let declared = spec.spec.method.0.parameters();
        let mut given = Parameters::default();
        let read = violations.object(json, |fields| {
            for parameter in declared {
                if let Some(json) = fields.take(parameter.name) {
                    read_one(declared, parameter, json, &mut fields.violations(parameter.name), &mut given);
                }
            }
        });
        if read.is_some() {
            spec.spec.parameters = given;
        }
    },
    write: |spec| raw(&values(spec.spec.method.0, &spec.spec.parameters)),
    summary: |spec| outlines(spec.spec.method.0, &spec.spec.parameters).into(),
};

fn read_one(
    declared: &'static [Parameter],
    parameter: &Parameter,
    json: &str,
    violations: &mut Violations<'_>,
    given: &mut Parameters,
) {
    let value = match parameter.range {
        Range::Number { .. } => violations.parse(json).map(Given::Number),
        Range::Whole { .. } => violations.parse(json).map(Given::Whole),
        Range::Switch { .. } => violations.parse(json).map(Given::Switch),
        Range::Choice(names) => violations.parse::<String>(json).map(|name| {
            let known = names.iter().find(|(known, _)| *known == name);
            Given::Choice(known.map_or("", |(known, _)| known))
        }),
        Range::Data(shape) => violations.parse::<Value>(json).and_then(|json| {
            let data = data_of(json);
            let wrong = if data == Data::None { Vec::new() } else { (shape.check)(&data) };
            wrong.iter().for_each(|(pointer, must)| violations.add(pointer, must));
            wrong.is_empty().then(|| Given::Data(Arc::new(data)))
        }),
    };
    if let Some(value) = value
        && !given.set(declared, parameter.name, value)
    {
        violations.add("", format!("must be {}", allowed(&parameter.range)));
    }
}

/// For people, as in "0 to 100".
fn allowed(range: &Range) -> String {
    match *range {
        Range::Number { least, most, .. } => format!("{least} to {most}"),
        Range::Whole { least, most, .. } => format!("a whole number, {least} to {most}"),
        Range::Switch { .. } => "`true` or `false`".to_owned(),
        Range::Choice(names) => {
            let names: Vec<String> = names.iter().map(|(name, _)| format!("`{name}`")).collect();
            names.join(" or ")
        }
        Range::Data(_) => "data of its schema".to_owned(),
    }
}

fn value(given: Given) -> Value {
    match given {
        Given::Number(x) => json!(x),
        Given::Whole(n) => json!(n),
        Given::Switch(on) => json!(on),
        Given::Choice(name) => json!(name),
        Given::Data(data) => json_of(&data),
    }
}

/// Every parameter of a method with its value: the given one, or else the default.
fn values(method: &dyn Method, given: &Parameters) -> Map<String, Value> {
    method.parameters().iter().map(|p| (p.name.to_owned(), value(given.get(p)))).collect()
}

/// The same, with numbers of elements in the place of lists inside structured data, which may be long.
fn outlines(method: &dyn Method, given: &Parameters) -> Map<String, Value> {
    let outline = |p: &Parameter| match given.get(p) {
        Given::Data(data) => outline(&data),
        other => value(other),
    };
    method.parameters().iter().map(|p| (p.name.to_owned(), outline(p))).collect()
}

fn outline(data: &Data) -> Value {
    match data {
        Data::List(values) => json!(values.len()),
        Data::Record(fields) => {
            fields.iter().map(|(name, data)| (name.clone(), outline(data))).collect::<Map<_, _>>().into()
        }
        other => json_of(other),
    }
}

/// The schema that structured data declares; that of any object if it is not one of OpenAPI, which a test would show.
fn declared_schema(shape: &Shape) -> ObjectBuilder {
    let object = serde_json::from_str::<Object>(shape.schema);
    object.map_or_else(|_| ObjectBuilder::new().schema_type(Type::Object), ObjectBuilder::from)
}

fn schema_of(parameter: &Parameter) -> ObjectBuilder {
    if let Range::Data(shape) = parameter.range {
        return declared_schema(shape);
    }
    let object = ObjectBuilder::new().default(Some(value(parameter.range.default())));
    match parameter.range {
        Range::Number { least, most, .. } => object.schema_type(Type::Number).minimum(Some(least)).maximum(Some(most)),
        Range::Whole { least, most, .. } => {
            object.schema_type(Type::Integer).minimum(Some(least as f64)).maximum(Some(most as f64))
        }
        Range::Switch { .. } => object.schema_type(Type::Boolean),
        Range::Choice(names) => object.schema_type(Type::String).enum_values(Some(names.iter().map(|(name, _)| *name))),
        Range::Data(_) => object,
    }
}

/// One parameter and its help, for people.
fn help_with_choices(parameter: &Parameter) -> String {
    let mut help = parameter.help.to_owned();
    if let Range::Choice(names) = parameter.range {
        for (name, line) in names {
            let _ = write!(help, " `{name}`: {line}");
        }
    }
    help
}

/// The JSON Schema of a method's own parameters.
pub(in crate::service) fn own_schema(method: MethodRef) -> RefOr<Schema> {
    let mut object = ObjectBuilder::new().description(Some("Parameters of the method itself."));
    for parameter in method.0.parameters() {
        object = object.property(parameter.name, schema_of(parameter).description(Some(help_with_choices(parameter))));
    }
    object.additional_properties(Some(AdditionalProperties::FreeForm(false))).into()
}

/// The methods that have a parameter of this name.
fn methods_with_parameter(name: &str) -> String {
    let has = |method: &&&dyn Method| method.parameters().iter().any(|p| p.name == name);
    STANDARD.iter().filter(has).map(|method| method.name()).collect::<Vec<_>>().join(", ")
}

/// The parameters of all standard methods, one per name. If methods share a parameter name, the first declaration is
/// kept.
fn distinct_parameters() -> Vec<&'static Parameter> {
    let mut all: Vec<&'static Parameter> = Vec::new();
    for parameter in STANDARD.iter().flat_map(|method| method.parameters()) {
        if all.iter().all(|known| known.name != parameter.name) {
            all.push(parameter);
        }
    }
    all
}

impl Values for MethodParams {
    fn allowed(&self) -> String {
        let names: Vec<String> = distinct_parameters()
            .iter()
            .map(|p| format!("`{}` ({}): {}", p.name, methods_with_parameter(p.name), allowed(&p.range)))
            .collect();
        names.join("; ")
    }

    fn schema(&self) -> RefOr<Schema> {
        Ref::from_schema_name(PARAMS).into()
    }

    fn components(&self) -> Vec<Component> {
        let mut object = ObjectBuilder::new()
            .description(Some("Parameters of the method itself: those that it has; /v1/methods tells which."));
        for parameter in distinct_parameters() {
            let help = format!("Of {}. {}", methods_with_parameter(parameter.name), help_with_choices(parameter));
            object = object.property(parameter.name, schema_of(parameter).description(Some(help)));
        }
        vec![(PARAMS.to_owned(), object.into())]
    }

    fn flag_text(&self) -> FlagText {
        FlagText::Members
    }
}

/// A spec with this method and the default of every other field.
pub(in crate::service) fn defaults_of(method: MethodRef) -> ResolvedSpec {
    let mut defaults = ResolvedSpec::default();
    defaults.spec.method = method;
    defaults
}
