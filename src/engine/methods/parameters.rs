//! The parameters of a method, as data: reading them from a request, their schema, flags and help follow from the
//! declaration.

use std::sync::Arc;

use crate::engine::methods::{Data, Shape};

/// One parameter of a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name, `snake_case`, stable.
    pub name: &'static str,
    /// What it does, its unit and where its default comes from, in one or two sentences.
    pub help: &'static str,
    /// What it may be.
    pub range: Range,
}

/// The values that a parameter may have, and its default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// A finite number, ends included.
    Number {
        /// Least value.
        least: f64,
        /// Greatest value.
        most: f64,
        /// Where nothing is said.
        default: f64,
    },
    /// A whole number, ends included.
    Whole {
        /// Least value.
        least: i64,
        /// Greatest value.
        most: i64,
        /// Where nothing is said.
        default: i64,
    },
    /// On or off.
    Switch {
        /// Where nothing is said.
        default: bool,
    },
    /// One of some names, each with one line of help; the first is the default.
    Choice(&'static [(&'static str, &'static str)]),
    /// Structured data of this shape, or nothing, which is the default.
    Data(&'static Shape),
}

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Of a [`Range::Number`].
    Number(f64),
    /// Of a [`Range::Whole`].
    Whole(i64),
    /// Of a [`Range::Switch`].
    Switch(bool),
    /// Of a [`Range::Choice`].
    Choice(&'static str),
    /// Of a [`Range::Data`].
    Data(Arc<Data>),
}

impl Range {
    /// The value where nothing is said.
    pub fn default(&self) -> Value {
        match *self {
            Self::Number { default, .. } => Value::Number(default),
            Self::Whole { default, .. } => Value::Whole(default),
            Self::Switch { default } => Value::Switch(default),
            Self::Choice(names) => Value::Choice(names.first().map_or("", |(name, _)| name)),
            Self::Data(_) => Value::Data(Arc::default()),
        }
    }

    /// Whether a value is one of these.
    pub fn contains(&self, value: &Value) -> bool {
        match (*self, value) {
            (Self::Number { least, most, .. }, Value::Number(x)) => (least..=most).contains(x),
            (Self::Whole { least, most, .. }, Value::Whole(n)) => (least..=most).contains(n),
            (Self::Switch { .. }, Value::Switch(_)) => true,
            (Self::Choice(names), Value::Choice(name)) => names.iter().any(|(known, _)| known == name),
            (Self::Data(shape), Value::Data(data)) => **data == Data::None || (shape.check)(data).is_empty(),
            _ => false,
        }
    }
}

/// The parameters of one method that differ from their defaults.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parameters(Vec<(&'static str, Value)>);

impl Parameters {
    /// Sets a parameter; `false` if the method has no such parameter or the value is out of its range.
    #[must_use]
    pub fn set(&mut self, declared: &'static [Parameter], name: &str, value: Value) -> bool {
        let Some(parameter) = declared.iter().find(|p| p.name == name && p.range.contains(&value)) else {
            return false;
        };
        self.0.retain(|(known, _)| *known != parameter.name);
        if value == parameter.range.default() {
            return true;
        }
        self.0.push((parameter.name, value));
        self.0.sort_by_key(|(name, _)| *name);
        true
    }

    /// The value of a declared parameter.
    pub fn get(&self, parameter: &Parameter) -> Value {
        let given = self.0.iter().find(|(name, _)| *name == parameter.name);
        given.map_or_else(|| parameter.range.default(), |(_, value)| value.clone())
    }

    /// The value of a [`Range::Number`] parameter.
    pub fn number(&self, parameter: &Parameter) -> f64 {
        match self.get(parameter) {
            Value::Number(x) => x,
            Value::Whole(n) => n as f64,
            Value::Switch(_) | Value::Choice(_) | Value::Data(_) => f64::NAN,
        }
    }

    /// The value of a [`Range::Data`] parameter; nothing of any other.
    pub fn data(&self, parameter: &Parameter) -> Arc<Data> {
        match self.get(parameter) {
            Value::Data(data) => data,
            _ => Arc::default(),
        }
    }

    /// The value of a [`Range::Switch`] parameter.
    pub fn is_on(&self, parameter: &Parameter) -> bool {
        self.get(parameter) == Value::Switch(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WEIGHT: Parameter =
        Parameter { name: "weight", help: "A weight.", range: Range::Number { least: 0.0, most: 2.0, default: 0.5 } };
    const ROUNDS: Parameter =
        Parameter { name: "rounds", help: "Rounds.", range: Range::Whole { least: 1, most: 9, default: 3 } };
    const KIND: Parameter =
        Parameter { name: "kind", help: "Kind.", range: Range::Choice(&[("a", "A."), ("b", "B.")]) };
    const DECLARED: &[Parameter] = &[WEIGHT, ROUNDS, KIND];

    #[test]
    fn what_is_not_given_has_its_default_and_what_is_out_of_range_is_refused() {
        let mut parameters = Parameters::default();
        assert_eq!((parameters.number(&WEIGHT), parameters.get(&KIND)), (0.5, Value::Choice("a")));
        assert!(parameters.set(DECLARED, "weight", Value::Number(2.0)));
        assert!(parameters.set(DECLARED, "kind", Value::Choice("b")));
        for (name, value) in [
            ("weight", Value::Number(2.1)),
            ("weight", Value::Number(f64::NAN)),
            ("rounds", Value::Whole(0)),
            ("rounds", Value::Number(2.0)),
            ("kind", Value::Choice("c")),
            ("other", Value::Switch(true)),
        ] {
            assert!(!parameters.set(DECLARED, name, value.clone()), "{name} {value:?}");
        }
        assert_eq!((parameters.number(&WEIGHT), parameters.get(&KIND)), (2.0, Value::Choice("b")));
        assert_eq!(parameters.get(&ROUNDS), Value::Whole(3));
    }

    #[test]
    fn the_order_in_which_parameters_are_given_does_not_matter() {
        let (mut a, mut b) = (Parameters::default(), Parameters::default());
        assert!(a.set(DECLARED, "weight", Value::Number(1.0)) && a.set(DECLARED, "rounds", Value::Whole(2)));
        assert!(b.set(DECLARED, "rounds", Value::Whole(7)) && b.set(DECLARED, "weight", Value::Number(1.0)));
        assert_ne!(a, b);
        assert!(b.set(DECLARED, "rounds", Value::Whole(2)));
        assert_eq!(a, b);
    }
}
