//! JSON Schemas of file formats, derived from the types that read them.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::Value;

/// Derives the schema of a format, in the dialect of 2020-12, with nothing behind references.
pub fn schema_of<T: JsonSchema>() -> Value {
    let settings = SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
    let mut schema = settings.into_generator().into_root_schema_for::<T>().to_value();
    without_null(&mut schema);
    schema
}

/// Takes out that a key may be null: TOML has none, what is absent is left out.
fn without_null(schema: &mut Value) {
    match schema {
        Value::Object(keys) => {
            if let Some(Value::Array(types)) = keys.get_mut("type") {
                types.retain(|name| name != "null");
                if let [only] = &types[..] {
                    keys["type"] = only.clone();
                }
            }
            for name in ["anyOf", "enum"] {
                if let Some(Value::Array(choices)) = keys.get_mut(name) {
                    choices.retain(|choice| !choice.is_null() && choice["type"] != "null");
                }
            }
            keys.values_mut().for_each(without_null);
        }
        Value::Array(values) => values.iter_mut().for_each(without_null),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_may_be_absent_is_not_required_and_never_null() {
        /// One.
        #[derive(JsonSchema)]
        #[allow(dead_code)]
        struct Inner {
            /// How many.
            count: Option<u32>,
        }
        #[derive(JsonSchema)]
        #[allow(dead_code)]
        struct Outer {
            inner: Option<Inner>,
            name: String,
        }
        let schema = schema_of::<Outer>();
        assert_eq!(schema["required"], serde_json::json!(["name"]));
        let count = &schema["properties"]["inner"]["properties"]["count"];
        assert_eq!((&count["type"], &count["description"]), (&"integer".into(), &"How many.".into()));
    }
}
