//! How the program writes JSON.
//!
//! JSON knows no infinities and nothing that is not a number. Here a key whose value is a number is a number or `null`,
//! never a text: where the value is infinite or not a number it is `null`, and the object has one more key,
//! `not_finite`, that says so:
//!
//! ```text
//! {"audit_worst_j": 0.25, "effective_mass_ratio": null, "not_finite": {"effective_mass_ratio": "inf"}}
//! ```
//! The texts are `inf`, `-inf` and `nan`. A `null` that `not_finite` does not name means that there is no value: the
//! quantity does not apply. An object in which all is finite has no `not_finite`.

use rimbench::runs::{Fact, FactValue};
use serde_json::{Map, Value};

/// The key that names what is `null` because it is not finite.
pub(super) const NOT_FINITE: &str = "not_finite";

/// An object under construction, its keys in the order in which they are put.
#[derive(Debug, Default)]
pub(super) struct Object {
    entries: Map<String, Value>,
    not_finite: Map<String, Value>,
}

impl Object {
    /// Puts anything but a number with a fraction.
    pub(super) fn put(&mut self, key: impl Into<String>, value: impl Into<Value>) {
        self.entries.insert(key.into(), value.into());
    }

    /// Puts a number, if there is one.
    pub(super) fn number(&mut self, key: impl Into<String>, value: impl Into<Option<f64>>) {
        let key = key.into();
        let value = value.into();
        if let Some(value) = value.filter(|value| !value.is_finite()) {
            self.not_finite.insert(key.clone(), format!("{value}").to_lowercase().into());
        }
        self.entries.insert(key, value.map_or(Value::Null, Value::from));
    }

    /// Puts what may be said of a run, under its name.
    pub(super) fn fact(&mut self, fact: &Fact) {
        self.value(fact.name, fact.value.as_ref());
    }

    /// Puts a text, a number, a count or a truth.
    pub(super) fn value(&mut self, key: impl Into<String>, value: Option<&FactValue>) {
        match value {
            None => self.put(key, Value::Null),
            Some(FactValue::Text(text)) => self.put(key, text.as_str()),
            Some(FactValue::Number(number)) => self.number(key, *number),
            Some(FactValue::Count(count)) => self.put(key, *count),
            Some(FactValue::Truth(truth)) => self.put(key, *truth),
        }
    }
}

impl From<Object> for Value {
    fn from(mut object: Object) -> Value {
        if !object.not_finite.is_empty() {
            object.entries.insert(NOT_FINITE.to_owned(), Value::Object(object.not_finite));
        }
        Value::Object(object.entries)
    }
}
