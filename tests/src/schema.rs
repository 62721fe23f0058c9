//! A checker for the part of JSON Schema that `bake/tool/src/schema/` uses: `type`, `required`, `properties`, `items`, `enum`.

use crate::binary::{Run, workspace};
use serde_json::Value;

/// The one JSON object that a run wrote to stdout, held against the schema `name` of `bake/tool/src/schema/`.
///
/// # Panics
///
/// Where it is no JSON, or breaks the schema.
#[track_caller]
pub fn answer(run: &Run, name: &str) -> Value {
    let value: Value = serde_json::from_str(&run.stdout).unwrap_or_else(|e| panic!("{e}: {run:?}"));
    hold(name, &value);
    value
}

/// Holds a value against the schema `name`.
///
/// # Panics
///
/// Where it breaks it.
#[track_caller]
pub fn hold(name: &str, value: &Value) {
    let path = workspace().join(format!("bake/tool/src/schema/{name}.json"));
    let text = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let schema = serde_json::from_slice(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    check(&schema, value).unwrap_or_else(|e| panic!("{name}: {e}"));
}

/// The same of a run that did what it was asked for.
///
/// # Panics
///
/// As [`answer`], and for any exit code but 0.
#[track_caller]
pub fn done(run: &Run, name: &str) -> Value {
    assert_eq!(run.code, Some(0), "{run:?}");
    answer(run, name)
}

/// The first place where `value` breaks `schema`, or a schema word that this checker does not know: a rule that is not
/// understood must not pass for one that holds.
///
/// # Errors
///
/// JSON pointer and what was expected there.
pub fn check(schema: &Value, value: &Value) -> Result<(), String> {
    check_at("", schema, value)
}

fn check_at(at: &str, schema: &Value, value: &Value) -> Result<(), String> {
    let rules = schema.as_object().ok_or(format!("{at}: the schema is no object"))?;
    for (word, rule) in rules {
        let fail = |what: String| Err(format!("{at}: {what}, found {value}"));
        let texts = || rule.as_array().cloned().unwrap_or_else(|| vec![rule.clone()]);
        match word.as_str() {
            "$schema" | "title" | "description" => {}
            "type" if !texts().iter().any(|t| has_type(t, value)) => return fail(format!("expected type {rule}")),
            "enum" if !texts().contains(value) => return fail(format!("expected one of {rule}")),
            "type" | "enum" => {}
            // As in JSON Schema, a rule about objects says nothing of null.
            "required" if !value.is_object() => {}
            "required" => {
                for key in texts() {
                    if value.get(key.as_str().unwrap_or_default()).is_none() {
                        return fail(format!("expected key {key}"));
                    }
                }
            }
            "properties" => {
                for (key, rule) in rule.as_object().into_iter().flatten() {
                    if let Some(field) = value.get(key) {
                        check_at(&format!("{at}/{key}"), rule, field)?;
                    }
                }
            }
            "items" => {
                for (i, item) in value.as_array().into_iter().flatten().enumerate() {
                    check_at(&format!("{at}/{i}"), rule, item)?;
                }
            }
            other => return Err(format!("{at}: schema word {other:?} is not one that this checker knows")),
        }
    }
    Ok(())
}

fn has_type(name: &Value, value: &Value) -> bool {
    match name.as_str() {
        Some("object") => value.is_object(),
        Some("array") => value.is_array(),
        Some("string") => value.is_string(),
        Some("boolean") => value.is_boolean(),
        Some("number") => value.is_number(),
        Some("integer") => value.is_u64() || value.is_i64(),
        Some("null") => value.is_null(),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_breaks_a_schema_is_found() {
        let schema = json!({
            "type": "object",
            "required": ["list"],
            "properties": { "list": { "type": "array", "items": { "type": ["integer", "null"], "enum": [1, 2, null] } } },
        });
        assert_eq!(check(&schema, &json!({ "list": [1, null], "more": 1 })), Ok(()));
        for wrong in [json!([]), json!({}), json!({ "list": 1 }), json!({ "list": [1.5] }), json!({ "list": [3] })] {
            assert!(check(&schema, &wrong).is_err(), "{wrong}");
        }
        assert!(check(&json!({ "minimum": 1 }), &json!(1)).is_err(), "an unknown word must not pass");
    }
}
