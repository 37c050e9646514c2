//! Numbers, switches, and values that may be missing.

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use serde_json::value::RawValue;
use utoipa::openapi::schema::{KnownFormat, ObjectBuilder, OneOfBuilder, SchemaFormat, SchemaType, Type};
use utoipa::openapi::{RefOr, Schema};

use crate::service::wire::fields::Violations;
use crate::service::wire::spec::field::{Component, FlagText, Kind, Values, json};

/// A number within limits.
#[derive(Clone, Copy)]
pub(super) struct Number {
    /// Values must lie above it; the limit itself is allowed where `or_equal`.
    low: f64,
    or_equal: bool,
    /// Values must not lie above it; none for any.
    high: Option<f64>,
}

impl Number {
    /// From `low` to `high`.
    pub(super) const fn within(low: f64, high: f64) -> Self {
        Self { low, or_equal: true, high: Some(high) }
    }

    /// Above `low`, at most `high`.
    pub(super) const fn above_to(low: f64, high: f64) -> Self {
        Self { low, or_equal: false, high: Some(high) }
    }

    /// Above `low`.
    pub(super) const fn above(low: f64) -> Self {
        Self { low, or_equal: false, high: None }
    }

    /// At least `low`.
    pub(super) const fn from(low: f64) -> Self {
        Self { low, or_equal: true, high: None }
    }

    fn contains(self, value: f64) -> bool {
        let is_low = if self.or_equal { value < self.low } else { value <= self.low };
        value.is_finite() && !is_low && self.high.is_none_or(|high| value <= high)
    }
}

impl Values for Number {
    fn allowed(&self) -> String {
        match (self.or_equal, self.high) {
            (true, Some(high)) => format!("{} to {high}", self.low),
            (false, Some(high)) => format!("above {} to {high}", self.low),
            (true, None) => format!("at least {}", self.low),
            (false, None) => format!("above {}", self.low),
        }
    }

    fn schema(&self) -> RefOr<Schema> {
        let (minimum, above) = if self.or_equal { (Some(self.low), None) } else { (None, Some(self.low)) };
        ObjectBuilder::new()
            .schema_type(Type::Number)
            .format(Some(SchemaFormat::KnownFormat(KnownFormat::Double)))
            .minimum(minimum)
            .exclusive_minimum(above)
            .maximum(self.high)
            .into()
    }
}

impl Kind for Number {
    type Value = f64;

    fn read(&self, json: &str, violations: &mut Violations<'_>) -> Option<f64> {
        let value = violations.parse(json)?;
        if !self.contains(value) {
            violations.add("", format!("must be {}, not {value}", self.allowed()));
            return None;
        }
        Some(value)
    }

    fn write(&self, value: &f64) -> serde_json::Result<Box<RawValue>> {
        json(value)
    }
}

/// A whole number within limits.
#[derive(Clone, Copy)]
pub(super) struct Whole<T> {
    /// The least.
    pub(super) low: T,
    /// The greatest; the schema is silent about it where it is the greatest there is.
    pub(super) high: T,
}

/// Whole numbers that the spec has.
pub(super) trait Integer: Copy + Ord + Sync + std::fmt::Display + Serialize + DeserializeOwned {
    /// The greatest there is.
    const GREATEST: Self;
    /// Format of the schema.
    const FORMAT: KnownFormat;
    /// For the limits of the schema.
    fn limit(self) -> isize;
}

impl Integer for u64 {
    const GREATEST: Self = u64::MAX;
    const FORMAT: KnownFormat = KnownFormat::Int64;
    fn limit(self) -> isize {
        isize::try_from(self).unwrap_or(isize::MAX)
    }
}

impl Integer for i32 {
    const GREATEST: Self = i32::MAX;
    const FORMAT: KnownFormat = KnownFormat::Int32;
    fn limit(self) -> isize {
        isize::try_from(self).unwrap_or(isize::MAX)
    }
}

impl<T: Integer> Values for Whole<T> {
    fn allowed(&self) -> String {
        let high = if self.high == T::GREATEST { "or more".to_owned() } else { format!("to {}", self.high) };
        format!("{} {high}", self.low)
    }

    fn schema(&self) -> RefOr<Schema> {
        let high = (self.high != T::GREATEST).then(|| self.high.limit());
        ObjectBuilder::new()
            .schema_type(Type::Integer)
            .format(Some(SchemaFormat::KnownFormat(T::FORMAT)))
            .minimum(Some(self.low.limit()))
            .maximum(high)
            .into()
    }
}

impl<T: Integer> Kind for Whole<T> {
    type Value = T;

    fn read(&self, json: &str, violations: &mut Violations<'_>) -> Option<T> {
        let value: T = violations.parse(json)?;
        if value < self.low || value > self.high {
            violations.add("", format!("must be a whole number, {}, not {value}", self.allowed()));
            return None;
        }
        Some(value)
    }

    fn write(&self, value: &T) -> serde_json::Result<Box<RawValue>> {
        json(value)
    }
}

/// `true` or `false`.
pub(super) struct Switch;

impl Values for Switch {
    fn allowed(&self) -> String {
        "`true` or `false`".to_owned()
    }

    fn schema(&self) -> RefOr<Schema> {
        ObjectBuilder::new().schema_type(Type::Boolean).into()
    }

    fn flag_text(&self) -> FlagText {
        FlagText::Switch
    }
}

impl Kind for Switch {
    type Value = bool;

    fn read(&self, json: &str, violations: &mut Violations<'_>) -> Option<bool> {
        violations.parse(json)
    }

    fn write(&self, value: &bool) -> serde_json::Result<Box<RawValue>> {
        json(value)
    }
}

/// A value that may be left open; `null` then.
pub(super) struct Maybe<K>(pub(super) K);

impl<K: Values> Values for Maybe<K> {
    fn allowed(&self) -> String {
        self.0.allowed()
    }

    fn choices(&self) -> Vec<(&'static str, &'static str)> {
        self.0.choices()
    }

    fn schema(&self) -> RefOr<Schema> {
        match self.0.schema() {
            RefOr::T(Schema::Object(mut object)) => {
                if let SchemaType::Type(kind) = object.schema_type {
                    object.schema_type = SchemaType::from_iter([kind, Type::Null]);
                }
                Schema::Object(object).into()
            }
            other => OneOfBuilder::new().item(ObjectBuilder::new().schema_type(Type::Null)).item(other).into(),
        }
    }

    fn components(&self) -> Vec<Component> {
        self.0.components()
    }

    fn flag_text(&self) -> FlagText {
        self.0.flag_text()
    }
}

impl<K: Kind> Kind for Maybe<K> {
    type Value = Option<K::Value>;

    fn read(&self, json: &str, violations: &mut Violations<'_>) -> Option<Self::Value> {
        self.0.read(json, violations).map(Some)
    }

    fn write(&self, value: &Self::Value) -> serde_json::Result<Box<RawValue>> {
        value.as_ref().map_or_else(|| json(&Value::Null), |value| self.0.write(value))
    }
}
