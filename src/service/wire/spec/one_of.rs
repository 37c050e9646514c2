//! Fields whose values are one or some of the names of a type.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt;
use std::marker::PhantomData;

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::value::RawValue;
use utoipa::openapi::schema::ArrayBuilder;
use utoipa::openapi::{Ref, RefOr, Schema};

use crate::service::wire::fields::Violations;
use crate::service::wire::spec::choice::{Choice, Chosen, choice_schema, names};
use crate::service::wire::spec::field::{Component, FlagText, Kind, Values, json};

fn with_help<T: Choice>() -> Vec<(&'static str, &'static str)> {
    T::ALL.iter().map(|&(_, name, help)| (name, help)).collect()
}

fn quoted<T: Choice>() -> Vec<String> {
    names::<T>().iter().map(|name| format!("`{name}`")).collect()
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
