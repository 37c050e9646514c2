//! Structured data of methods as JSON.

use serde_json::{Map, Value, json};

use crate::engine::methods::Data;

/// JSON as data. Numbers beyond those that are finite do not occur in JSON.
pub(super) fn data_of(json: Value) -> Data {
    match json {
        Value::Null => Data::None,
        Value::Bool(on) => Data::Switch(on),
        Value::Number(x) => Data::Number(x.as_f64().unwrap_or(f64::NAN)),
        Value::String(text) => Data::Text(text),
        Value::Array(values) => Data::List(values.into_iter().map(data_of).collect()),
        Value::Object(fields) => Data::Record(fields.into_iter().map(|(name, json)| (name, data_of(json))).collect()),
    }
}

/// Data as JSON.
pub(super) fn json_of(data: &Data) -> Value {
    match data {
        Data::None => Value::Null,
        Data::Switch(on) => json!(on),
        Data::Number(x) if x.fract() == 0.0 && x.abs() < 1e15 => json!(*x as i64),
        Data::Number(x) => json!(x),
        Data::Text(text) => json!(text),
        Data::List(values) => values.iter().map(json_of).collect(),
        Data::Record(fields) => {
            fields.iter().map(|(name, data)| (name.clone(), json_of(data))).collect::<Map<_, _>>().into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_comes_back_as_it_was() {
        let json = json!({"a": [1, 2.5, null, true, "x"], "b": {"c": []}, "d": -7});
        assert_eq!(json_of(&data_of(json.clone())), json);
    }
}
