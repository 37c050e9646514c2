//! Reads a JSON object field by field, so that all violations are found and not only the first.
//!
//! serde stops at the first error of a document. Here the object is cut into the texts of its fields, which costs one
//! pass and no tree, and each text is read on its own with the limits of its type; an error is noted under the field's
//! JSON pointer. What is left over at the end is an unknown field.

use std::borrow::Cow;
use std::fmt;

use serde::de::{DeserializeOwned, Deserializer, IgnoredAny, MapAccess, Visitor};
use serde_json::value::RawValue;

use crate::service::wire::violation::Violation;

/// Most fields that an object may have: far above every object that is known.
const MOST_FIELDS: usize = 100;
/// Most violations that are told at once.
const MOST_VIOLATIONS: usize = 100;
/// Most characters of a client's text that are repeated in a violation.
const MOST_REPEATED: usize = 100;

/// Notes violations at and below one JSON pointer.
pub(in crate::service) struct Violations<'a> {
    pointer: String,
    found: &'a mut Vec<Violation>,
}

impl<'a> Violations<'a> {
    /// Notes in `found` what is wrong at `pointer`.
    pub(in crate::service) fn at(pointer: impl Into<String>, found: &'a mut Vec<Violation>) -> Self {
        Self { pointer: pointer.into(), found }
    }

    /// Notes a violation at the path `below` the pointer; empty is the pointer itself.
    pub(in crate::service) fn add(&mut self, below: &str, message: impl Into<String>) {
        if self.found.len() < MOST_VIOLATIONS {
            self.found.push(Violation::new(format!("{}{below}", self.pointer), message));
        }
    }

    /// The same, at the field `name` below.
    pub(in crate::service) fn below(&mut self, name: &str) -> Violations<'_> {
        Violations::at(format!("{}/{}", self.pointer, escaped(name)), self.found)
    }

    /// Reads the fields of an object; `None` and violations if it is none, or has other fields.
    pub(in crate::service) fn object<'j, T>(
        &mut self,
        json: &'j str,
        read: impl FnOnce(&mut Fields<'j, '_>) -> T,
    ) -> Option<T> {
        let before = self.found.len();
        let mut fields = Fields::of(json, &self.pointer, self.found);
        let value = read(&mut fields);
        fields.finish();
        (self.found.len() == before).then_some(value)
    }

    /// Reads JSON as `T`; `None` and a violation if it is something else.
    pub(in crate::service) fn parse<T: DeserializeOwned>(&mut self, json: &str) -> Option<T> {
        serde_json::from_str(json).map_err(|error| self.add("", in_words(&error))).ok()
    }
}

/// The fields of one object that have not been read yet.
pub(in crate::service) struct Fields<'j, 'f> {
    members: Vec<(Cow<'j, str>, &'j RawValue)>,
    pointer: String,
    known: Vec<&'static str>,
    found: &'f mut Vec<Violation>,
}

impl<'j, 'f> Fields<'j, 'f> {
    /// Starts on the text of an object that lies at the JSON pointer `pointer`; anything else is a violation, and `null`
    /// is an object without fields.
    pub(in crate::service) fn of(json: &'j str, pointer: &str, found: &'f mut Vec<Violation>) -> Self {
        let mut fields = Self { members: Vec::new(), pointer: pointer.to_owned(), known: Vec::new(), found };
        match serde_json::from_str::<&RawValue>(json) {
            Err(error) => fields.note("", format!("not JSON: {error}")),
            Ok(value) => match kind(value.get()) {
                "null" => {}
                "an object" => {
                    let mut reader = serde_json::Deserializer::from_str(value.get());
                    if let Err(error) = reader.deserialize_map(Cut(&mut fields)) {
                        fields.note("", in_words(&error));
                    }
                }
                kind => fields.note("", format!("must be an object, not {kind}")),
            },
        }
        fields
    }

    /// The text of the field `name`; `null` counts as absent.
    pub(in crate::service) fn take(&mut self, name: &'static str) -> Option<&'j str> {
        self.known.push(name);
        self.take_quietly(name)
    }

    /// The same without counting the name among the known ones.
    pub(in crate::service) fn take_quietly(&mut self, name: &str) -> Option<&'j str> {
        let place = self.members.iter().position(|(key, _)| key == name)?;
        let text = self.members.swap_remove(place).1.get();
        (text != "null").then_some(text)
    }

    /// Reads the field `name` into `slot`, which keeps its default when the field is absent or wrong.
    pub(in crate::service) fn read<T: DeserializeOwned>(&mut self, name: &'static str, slot: &mut T) {
        if let Some(json) = self.take(name)
            && let Some(read) = self.violations(name).parse(json)
        {
            *slot = read;
        }
    }

    /// Where to note what is wrong with the field `name`.
    pub(in crate::service) fn violations(&mut self, name: &str) -> Violations<'_> {
        Violations::at(format!("{}/{}", self.pointer, escaped(name)), self.found)
    }

    /// Every field that nobody asked for is a violation.
    pub(in crate::service) fn finish(mut self) {
        let message = format!("unknown field; known are {}", self.known.join(", "));
        for (name, _) in std::mem::take(&mut self.members) {
            self.note(&name, message.clone());
        }
    }

    fn note(&mut self, name: &str, message: String) {
        if name.is_empty() {
            Violations::at(self.pointer.clone(), self.found).add("", message);
        } else {
            self.violations(name).add("", message);
        }
    }
}

/// Cuts an object into its fields.
struct Cut<'c, 'j, 'f>(&'c mut Fields<'j, 'f>);

impl<'j> Visitor<'j> for Cut<'_, 'j, '_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<M: MapAccess<'j>>(self, mut map: M) -> Result<(), M::Error> {
        let fields = self.0;
        while let Some(Name(name)) = map.next_key()? {
            if fields.members.len() >= MOST_FIELDS {
                fields.note("", format!("has more than {MOST_FIELDS} fields; the others were not looked at"));
                map.next_value::<IgnoredAny>()?;
                while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
                break;
            }
            let value = map.next_value::<&RawValue>()?;
            if fields.members.iter().any(|(known, _)| *known == name) {
                fields.note(&name, "is given more than once".to_owned());
            } else {
                fields.members.push((name, value));
            }
        }
        Ok(())
    }
}

/// A key, borrowed where it has no escapes.
#[derive(serde::Deserialize)]
struct Name<'a>(#[serde(borrow)] Cow<'a, str>);

/// A part of a JSON pointer (RFC 6901), cut where it is long.
fn escaped(name: &str) -> String {
    shortened(name).replace('~', "~0").replace('/', "~1")
}

/// What serde says, without the place within the field's text, which clients cannot see.
fn in_words(error: &serde_json::Error) -> String {
    let text = error.to_string();
    let place = format!(" at line {} column {}", error.line(), error.column());
    shortened(text.strip_suffix(&place).unwrap_or(&text))
}

/// At most [`MOST_REPEATED`] characters from the front and the back: errors repeat what clients sent in between.
fn shortened(text: &str) -> String {
    let n = text.chars().count();
    if n <= 2 * MOST_REPEATED {
        return text.to_owned();
    }
    let front = text.chars().take(MOST_REPEATED);
    front.chain("…".chars()).chain(text.chars().skip(n - MOST_REPEATED)).collect()
}

/// What a text of valid JSON is, by its first character.
fn kind(json: &str) -> &'static str {
    match json.trim_start().as_bytes().first() {
        Some(b'{') => "an object",
        Some(b'[') => "an array",
        Some(b'"') => "a string",
        Some(b't' | b'f') => "a boolean",
        Some(b'n') => "null",
        _ => "a number",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn violations(json: &str, read: impl FnOnce(&mut Fields<'_, '_>)) -> Vec<Violation> {
        let mut found = Vec::new();
        let mut fields = Fields::of(json, "", &mut found);
        read(&mut fields);
        fields.finish();
        found
    }

    #[test]
    fn fields_that_come_twice_are_refused_whatever_their_spelling() {
        let found = violations(r#"{"a": 1, "b": 2, "\u0061": 1, "b": [2]}"#, |fields| {
            let mut value = 0;
            fields.read("a", &mut value);
            assert_eq!(value, 1);
            fields.read("b", &mut value);
        });
        assert_eq!(found.iter().map(|v| v.pointer.as_str()).collect::<Vec<_>>(), ["/a", "/b"]);
    }

    #[test]
    fn names_that_need_it_are_escaped_in_pointers() {
        let found = violations(r#"{"a/b~c": null}"#, |_| {});
        assert_eq!(found.iter().map(|v| v.pointer.as_str()).collect::<Vec<_>>(), ["/a~1b~0c"]);
    }

    #[test]
    fn what_a_client_sent_is_not_echoed_in_bulk() {
        let many: Vec<String> = (0..10_000).map(|n| format!("\"{n}\": 0")).collect();
        let long = "x".repeat(1 << 20);
        for json in [format!("{{{}}}", many.join(",")), format!("{{\"{long}\": 0}}"), format!("{{\"a\": \"{long}\"}}")]
        {
            let found = violations(&json, |fields| fields.read("a", &mut 0));
            let bytes: usize = found.iter().map(|v| v.pointer.len() + v.message.len()).sum();
            assert!(!found.is_empty() && bytes < 20_000, "{bytes}");
        }
    }

    #[test]
    fn what_is_no_object_is_one_violation() {
        for json in ["7", "[{}]", "\"{}\"", "{\"a\": 1", "{}}", "{\"a\" 1}", ""] {
            assert_eq!(violations(json, |fields| fields.read("a", &mut 0)).len(), 1, "{json}");
        }
        assert!(violations(" null ", |_| {}).is_empty());
    }
}
