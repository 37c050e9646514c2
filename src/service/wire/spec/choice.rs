//! Values that are names: one list per type of what each name stands for.

use std::borrow::Cow;
use std::collections::BTreeSet;

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use utoipa::openapi::schema::{ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

/// A type whose values have names.
pub trait Choice: Copy + 'static {
    /// Name of the schema.
    const SCHEMA: &'static str;
    /// What is chosen, in one line.
    const HELP: &'static str;
    /// All values with their names and one line of help.
    const ALL: &'static [(Self, &'static str, &'static str)];
    /// Names that are refused as not available in this version.
    const LATER: &'static [&'static str];

    /// The name.
    fn name(self) -> &'static str;

    /// The value of this name, or why there is none.
    fn of_name(name: &str) -> Result<Self, String> {
        if let Some(&(value, ..)) = Self::ALL.iter().find(|(_, known, _)| *known == name) {
            return Ok(value);
        }
        let names: Vec<&str> = Self::ALL.iter().map(|(_, name, _)| *name).collect();
        let names = names.join(", ");
        if Self::LATER.contains(&name) {
            return Err(format!("{name} is not available in this version; there is {names}"));
        }
        Err(format!("unknown; there is {names}"))
    }
}

/// Gives the values of a type their names: `Type as "Schema": "help", later [names]; Value = "name": "help"; …`.
macro_rules! choices {
    ($type:ty as $schema:literal: $help:literal, later $later:expr; $($value:ident = $name:literal: $line:literal;)+) => {
        impl $crate::service::wire::spec::choice::Choice for $type {
            const SCHEMA: &'static str = $schema;
            const HELP: &'static str = $help;
            const ALL: &'static [(Self, &'static str, &'static str)] = &[$((<$type>::$value, $name, $line),)+];
            const LATER: &'static [&'static str] = &$later;

            fn name(self) -> &'static str {
                match self { $(<$type>::$value => $name,)+ }
            }
        }
    };
}
pub(in crate::service) use choices;

/// The names of all values.
pub(super) fn names<T: Choice>() -> Vec<&'static str> {
    T::ALL.iter().map(|(_, name, _)| *name).collect()
}

/// The schema of the names of a type, with their help.
pub(in crate::service) fn choice_schema<T: Choice>() -> RefOr<Schema> {
    let lines: Vec<String> = T::ALL.iter().map(|(_, name, help)| format!("* `{name}`: {help}")).collect();
    let description = format!("{}\n\n{}", T::HELP, lines.join("\n"));
    ObjectBuilder::new().schema_type(Type::String).enum_values(Some(names::<T>())).description(Some(description)).into()
}

/// Names that are chosen together, and how the engine holds them.
pub(super) trait Chosen: Choice + Ord {
    /// Several of them.
    type Held;
    /// From the names.
    fn hold(chosen: BTreeSet<Self>) -> Self::Held;
    /// Back to the names.
    fn chosen(held: &Self::Held) -> BTreeSet<Self>;
}

/// A choice on its own, as in a query or a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Named<T>(pub T);

impl<T: Choice> Serialize for Named<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.name())
    }
}

impl<'de, T: Choice> Deserialize<'de> for Named<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = Cow::<'de, str>::deserialize(deserializer)?;
        T::of_name(&name).map(Self).map_err(D::Error::custom)
    }
}

impl<T: Choice> PartialSchema for Named<T> {
    fn schema() -> RefOr<Schema> {
        choice_schema::<T>()
    }
}

impl<T: Choice> ToSchema for Named<T> {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed(T::SCHEMA)
    }
}
