//! Structured values of parameters and reports: what JSON can say, without its text.

/// A structured value.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Data {
    /// Nothing.
    #[default]
    None,
    /// True or false.
    Switch(bool),
    /// A finite number.
    Number(f64),
    /// A text.
    Text(String),
    /// Values in order.
    List(Vec<Data>),
    /// Values by name, in order.
    Record(Vec<(String, Data)>),
}

impl Data {
    /// The value of this name; nothing if this is no record or has none.
    pub fn get(&self, name: &str) -> &Data {
        match self {
            Self::Record(fields) => {
                fields.iter().find(|(known, _)| known == name).map_or(&Data::None, |(_, data)| data)
            }
            _ => &Data::None,
        }
    }

    /// The values of a list; none of anything else.
    pub fn list(&self) -> &[Data] {
        match self {
            Self::List(values) => values,
            _ => &[],
        }
    }

    /// The number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(x) => Some(*x),
            _ => None,
        }
    }

    /// The text, if it is one.
    pub fn text(&self) -> Option<&str> {
        match self {
            Self::Text(text) => Some(text),
            _ => None,
        }
    }

    /// A list of numbers.
    pub fn numbers(numbers: impl IntoIterator<Item = f64>) -> Self {
        Self::List(numbers.into_iter().map(Self::Number).collect())
    }
}

/// What structured values a parameter may have.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Its JSON Schema, as JSON text.
    pub schema: &'static str,
    /// What is wrong with a value: JSON pointers below it, each with what must hold there.
    pub check: fn(&Data) -> Vec<(String, String)>,
}

impl PartialEq for Shape {
    fn eq(&self, other: &Self) -> bool {
        self.schema == other.schema
    }
}
