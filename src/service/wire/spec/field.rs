//! What the table of the spec says about one field, and the small trait behind the kinds of values.

use serde::Serialize;
use serde_json::Value;
use serde_json::value::{RawValue, to_raw_value};
use utoipa::openapi::{RefOr, Schema};

use crate::service::wire::fields::Violations;
use crate::service::wire::spec::ResolvedSpec;

/// A named schema of the OpenAPI document.
pub(super) type Component = (String, RefOr<Schema>);

/// One row of the table.
pub(in crate::service) struct Field {
    /// Its name in JSON; with a dot, the name of its group before it.
    pub(in crate::service) name: &'static str,
    /// In one line.
    pub(in crate::service) help: &'static str,
    /// Its flags on the command line.
    pub(in crate::service) flags: &'static [Flag],
    /// Which values there are.
    pub(in crate::service) values: &'static dyn Values,
    /// Reads JSON into its place.
    pub(super) read: fn(&str, &mut Violations<'_>, &mut ResolvedSpec),
    /// Its value as JSON.
    pub(super) write: fn(&ResolvedSpec) -> serde_json::Result<Box<RawValue>>,
    /// Its value in summaries.
    pub(super) summary: fn(&ResolvedSpec) -> Value,
}

impl Field {
    /// The group, where it is in one, and the name within it.
    pub(super) fn path(&self) -> (Option<&'static str>, &'static str) {
        self.name.split_once('.').map_or((None, self.name), |(group, name)| (Some(group), name))
    }

    /// The default as people write it; `None` if nothing is.
    pub(in crate::service) fn default_text(&self) -> Option<String> {
        match (self.summary)(&ResolvedSpec::default()) {
            Value::Null => None,
            Value::String(text) => Some(text),
            // Without the .0 of whole numbers.
            Value::Number(number) => number.as_f64().map(|number| number.to_string()),
            Value::Array(items) if items.is_empty() => None,
            Value::Object(parts) if parts.get("count").is_some() => None,
            Value::Array(items) => Some(items.iter().filter_map(Value::as_str).collect::<Vec<_>>().join(",")),
            other => Some(other.to_string()),
        }
    }
}

/// A flag of the command line that sets a field.
pub(in crate::service) struct Flag {
    /// Without its dashes.
    pub(in crate::service) name: &'static str,
    /// What stands for the value in the help.
    pub(in crate::service) value: &'static str,
    /// The member of the field that it sets, where the field is an object of one member.
    pub(in crate::service) member: Option<&'static str>,
    /// In one line, where the field's own line does not fit.
    pub(in crate::service) help: Option<&'static str>,
}

impl Flag {
    /// The flag `name` for the whole field.
    pub(super) const fn new(name: &'static str, value: &'static str) -> Self {
        Self { name, value, member: None, help: None }
    }

    /// The flag `name` for one member of the field.
    pub(super) const fn member(
        name: &'static str,
        value: &'static str,
        member: &'static str,
        help: &'static str,
    ) -> Self {
        Self { name, value, member: Some(member), help: Some(help) }
    }
}

/// Fields that stand together in an object.
pub(super) struct Group {
    /// Its name in JSON.
    pub(super) name: &'static str,
    /// Name of its schema.
    pub(super) component: &'static str,
    /// Name of its schema in summaries.
    pub(super) summary_component: &'static str,
    /// In one line.
    pub(super) help: &'static str,
}

/// How the text of a flag becomes JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::service) enum FlagText {
    /// A number; what is none is refused by the judge, which sees a string.
    Number,
    /// `true` or `false`; true if nothing is said.
    Switch,
    /// A name.
    Name,
    /// Names with commas between them.
    Names,
    /// The same, or this name in the place of a list.
    NamesOr(&'static str),
    /// A file with a given field, which is read as its ending says.
    FieldFile,
    /// Members of an object, each as `name=value`.
    Members,
}

/// Which values a field takes: everything but the type in Rust.
pub(in crate::service) trait Values: Sync {
    /// For people, as in "0 to 100".
    fn allowed(&self) -> String;
    /// Names among which to choose, each with its help; empty where values are no names.
    fn choices(&self) -> Vec<(&'static str, &'static str)> {
        Vec::new()
    }
    /// The JSON Schema.
    fn schema(&self) -> RefOr<Schema>;
    /// The JSON Schema in summaries.
    fn summary_schema(&self) -> RefOr<Schema> {
        self.schema()
    }
    /// Named schemas that the two refer to.
    fn components(&self) -> Vec<Component> {
        Vec::new()
    }
    /// How the text of a flag becomes JSON.
    fn flag_text(&self) -> FlagText {
        FlagText::Number
    }
    /// Whether it is a list of the model's own size, which only the whole spec repeats.
    fn is_long(&self) -> bool {
        false
    }
}

/// A kind of values as Rust holds them.
pub(super) trait Kind: Values {
    /// The type in Rust.
    type Value;
    /// Reads JSON; `None` and violations if it cannot be used.
    fn read(&self, json: &str, violations: &mut Violations<'_>) -> Option<Self::Value>;
    /// As JSON.
    fn write(&self, value: &Self::Value) -> serde_json::Result<Box<RawValue>>;
    /// As JSON in summaries.
    fn summary(&self, value: &Self::Value) -> Value {
        self.write(value).and_then(|json| serde_json::from_str(json.get())).unwrap_or_default()
    }
}

/// JSON of what serde knows.
pub(super) fn json(value: &impl Serialize) -> serde_json::Result<Box<RawValue>> {
    to_raw_value(value)
}

/// A row: name, place in [`ResolvedSpec`], kind of values, flags, help.
macro_rules! field {
    ($name:literal, $($place:ident).+, $kind:expr, $flags:expr, $help:literal) => {
        $crate::service::wire::spec::field::Field {
            name: $name,
            help: $help,
            flags: &$flags,
            values: &$kind,
            read: |json, violations, spec| {
                if let Some(value) = Kind::read(&$kind, json, violations) {
                    spec.$($place).+ = value;
                }
            },
            write: |spec| Kind::write(&$kind, &spec.$($place).+),
            summary: |spec| Kind::summary(&$kind, &spec.$($place).+),
        }
    };
}
pub(super) use field;
