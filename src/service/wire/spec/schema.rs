//! What follows from the table for readers: the JSON Schemas of the whole spec and of its summary, and a table in
//! Markdown.

use std::borrow::Cow;
use std::fmt;

use serde_json::Value;
use utoipa::openapi::schema::{AdditionalProperties, ObjectBuilder};
use utoipa::openapi::{Ref, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

use crate::service::wire::spec::field::{Component, Field, Group};
use crate::service::wire::spec::table::{FIELDS, GROUPS};
use crate::service::wire::spec::{ResolvedSpec, SpecSummary};

/// Whether a schema is of what clients send or of what they get back in short.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// Every field may be left out, others are refused.
    Whole,
    /// Every field is there.
    Summary,
}

impl Form {
    fn component(self, group: &Group) -> &'static str {
        match self {
            Form::Whole => group.component,
            Form::Summary => group.summary_component,
        }
    }

    /// The object of the fields of one group, or of the top.
    fn object(self, group: Option<&Group>, help: &str) -> RefOr<Schema> {
        let mut object = ObjectBuilder::new().description(Some(help));
        for group in GROUPS.iter().filter(|_| group.is_none()) {
            object = object.property(group.name, described(self.reference(group), group.help, None));
            object = self.required(object, group.name);
        }
        for field in FIELDS {
            let (own, name) = field.path();
            if own == group.map(|group| group.name) {
                object = object.property(name, self.property(field));
                object = self.required(object, name);
            }
        }
        if self == Form::Whole {
            object = object.additional_properties(Some(AdditionalProperties::FreeForm(false)));
        }
        object.into()
    }

    fn reference(self, group: &Group) -> RefOr<Schema> {
        Ref::from_schema_name(self.component(group)).into()
    }

    fn required(self, object: ObjectBuilder, name: &str) -> ObjectBuilder {
        if self == Form::Summary { object.required(name) } else { object }
    }

    fn property(self, field: &Field) -> RefOr<Schema> {
        match self {
            Form::Whole => {
                let default = (field.write)(&ResolvedSpec::default()).ok();
                let default = default.and_then(|json| serde_json::from_str(json.get()).ok());
                described(field.values.schema(), field.help, default)
            }
            Form::Summary => described(field.values.summary_schema(), field.help, None),
        }
    }

    fn components(self) -> Vec<Component> {
        let groups =
            GROUPS.iter().map(|group| (self.component(group).to_owned(), self.object(Some(group), group.help)));
        FIELDS.iter().flat_map(|field| field.values.components()).chain(groups).collect()
    }
}

/// A property with its line of help and its default.
fn described(schema: RefOr<Schema>, help: &str, default: Option<Value>) -> RefOr<Schema> {
    match schema {
        RefOr::Ref(mut reference) => {
            reference.description = help.to_owned();
            reference.default = default;
            reference.into()
        }
        RefOr::T(mut schema) => {
            let (text, value) = match &mut schema {
                Schema::Object(object) => (&mut object.description, &mut object.default),
                Schema::Array(array) => (&mut array.description, &mut array.default),
                Schema::OneOf(choice) => (&mut choice.description, &mut choice.default),
                _ => return schema.into(),
            };
            *text = Some(help.to_owned());
            *value = default;
            schema.into()
        }
    }
}

impl PartialSchema for ResolvedSpec {
    fn schema() -> RefOr<Schema> {
        Form::Whole.object(None, "What a client may ask for. Every field may be left out; defaults are filled in.")
    }
}

impl ToSchema for ResolvedSpec {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("RemeshRequest")
    }

    fn schemas(schemas: &mut Vec<Component>) {
        schemas.extend(Form::Whole.components());
    }
}

impl PartialSchema for SpecSummary {
    fn schema() -> RefOr<Schema> {
        Form::Summary.object(None, "The spec with all defaults filled in; long lists are given by their length.")
    }
}

impl ToSchema for SpecSummary {
    fn schemas(schemas: &mut Vec<Component>) {
        schemas.extend(Form::Summary.components());
    }
}

/// The table of fields in Markdown.
#[derive(Clone, Copy, Debug)]
pub struct SpecTable;

impl fmt::Display for SpecTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "| field | values | default | meaning |\n|---|---|---|---|")?;
        for field in FIELDS {
            let default = field.default_text().map_or_else(|| "–".to_owned(), |text| format!("`{text}`"));
            write!(f, "| `{}` | {} | {default} | {}", field.name, field.values.allowed(), field.help)?;
            for (name, help) in field.values.choices() {
                write!(f, " `{name}`: {help}")?;
            }
            writeln!(f, " |")?;
        }
        Ok(())
    }
}
