//! Values that are names: one list per type of what each name stands for.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt;
use std::marker::PhantomData;

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::value::RawValue;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};
use utoipa::openapi::{Ref, RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};

use crate::service::wire::fields::Violations;
use crate::service::wire::spec::field::{Component, FlagText, Kind, Values, json};

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

fn names<T: Choice>() -> Vec<&'static str> {
    T::ALL.iter().map(|(_, name, _)| *name).collect()
}

fn with_help<T: Choice>() -> Vec<(&'static str, &'static str)> {
    T::ALL.iter().map(|&(_, name, help)| (name, help)).collect()
}

fn quoted<T: Choice>() -> Vec<String> {
    names::<T>().iter().map(|name| format!("`{name}`")).collect()
}

/// The schema of the names of a type, with their help.
pub(in crate::service) fn choice_schema<T: Choice>() -> RefOr<Schema> {
    let lines: Vec<String> = T::ALL.iter().map(|(_, name, help)| format!("* `{name}`: {help}")).collect();
    let description = format!("{}\n\n{}", T::HELP, lines.join("\n"));
    ObjectBuilder::new().schema_type(Type::String).enum_values(Some(names::<T>())).description(Some(description)).into()
}

pub(super) fn reference<T: Choice>() -> RefOr<Schema> {
    Ref::from_schema_name(T::SCHEMA).into()
}

fn component<T: Choice>() -> Component {
    (T::SCHEMA.to_owned(), choice_schema::<T>())
}

/// One of the values of a type.
pub(super) struct OneOf<T>(PhantomData<fn() -> T>);

pub(super) const fn one_of<T>() -> OneOf<T> {
    OneOf(PhantomData)
}

impl<T: Choice> Values for OneOf<T> {
    fn allowed(&self) -> String {
        let mut names = quoted::<T>();
        let last = names.pop().unwrap_or_default();
        if names.is_empty() { last } else { format!("{} or {last}", names.join(", ")) }
    }

    fn choices(&self) -> Vec<(&'static str, &'static str)> {
        with_help::<T>()
    }

    fn schema(&self) -> RefOr<Schema> {
        reference::<T>()
    }

    fn components(&self) -> Vec<Component> {
        vec![component::<T>()]
    }

    fn flag_text(&self) -> FlagText {
        FlagText::Name
    }
}

impl<T: Choice> Kind for OneOf<T> {
    type Value = T;

    fn read(&self, json: &str, violations: &mut Violations<'_>) -> Option<T> {
        let name = violations.parse::<String>(json)?;
        T::of_name(&name).map_err(|message| violations.add("", message)).ok()
    }

    fn write(&self, value: &T) -> serde_json::Result<Box<RawValue>> {
        json(&value.name())
    }
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

/// Any of the values of a type, in any order; repetitions count once.
pub(super) struct SomeOf<T>(PhantomData<fn() -> T>);

pub(super) const fn some_of<T>() -> SomeOf<T> {
    SomeOf(PhantomData)
}

impl<T: Chosen> Values for SomeOf<T> {
    fn allowed(&self) -> String {
        format!("list of {}", quoted::<T>().join(", "))
    }

    fn choices(&self) -> Vec<(&'static str, &'static str)> {
        with_help::<T>()
    }

    fn schema(&self) -> RefOr<Schema> {
        ArrayBuilder::new().items(reference::<T>()).into()
    }

    fn components(&self) -> Vec<Component> {
        vec![component::<T>()]
    }

    fn flag_text(&self) -> FlagText {
        FlagText::Names
    }
}

impl<T: Chosen> Kind for SomeOf<T> {
    type Value = T::Held;

    fn read(&self, json: &str, violations: &mut Violations<'_>) -> Option<T::Held> {
        violations.parse::<Names<T>>(json).map(|names| T::hold(names.0))
    }

    fn write(&self, value: &T::Held) -> serde_json::Result<Box<RawValue>> {
        json(&T::chosen(value).into_iter().map(T::name).collect::<Vec<_>>())
    }
}

/// A list of names, never longer in memory than there are names.
struct Names<T>(BTreeSet<T>);

impl<'de, T: Choice + Ord> Deserialize<'de> for Names<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader<T>(PhantomData<T>);
        impl<'de, T: Choice + Ord> Visitor<'de> for Reader<T> {
            type Value = Names<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a list of {}", names::<T>().join(", "))
            }

            fn visit_seq<S: SeqAccess<'de>>(self, mut list: S) -> Result<Names<T>, S::Error> {
                let mut chosen = BTreeSet::new();
                while let Some(name) = list.next_element::<Cow<'de, str>>()? {
                    chosen.insert(T::of_name(&name).map_err(S::Error::custom)?);
                }
                Ok(Names(chosen))
            }
        }
        deserializer.deserialize_seq(Reader(PhantomData))
    }
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
