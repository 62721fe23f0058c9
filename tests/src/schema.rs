//! Validator for the subset of JSON Schema that `bake/docs/schemas.json` uses.

use crate::binary::{Run, workspace};
use serde_json::Value;
use std::sync::LazyLock;

/// JSON schemas of the results of all commands, by name.
static SCHEMAS: LazyLock<Value> = LazyLock::new(|| {
    let path = workspace().join("bake/docs/schemas.json");
    let text = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_slice(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
});

/// Parses the JSON object that a run wrote to stdout, and validates it against the schema `name`.
///
/// # Panics
///
/// If the output is not JSON or violates the schema.
#[track_caller]
pub fn parse_answer(run: &Run, name: &str) -> Value {
    let value: Value = serde_json::from_str(&run.stdout).unwrap_or_else(|e| panic!("{e}: {run:?}"));
    assert_valid(name, &value);
    value
}

/// Validates a value against the schema `name`.
///
/// # Panics
///
/// If the schema does not exist, or the value violates it.
#[track_caller]
pub fn assert_valid(name: &str, value: &Value) {
    check(&SCHEMAS, &SCHEMAS[name], value).unwrap_or_else(|e| panic!("{name}: {e}"));
}

/// Same as [`parse_answer`], but also requires exit code 0.
///
/// # Panics
///
/// Same as [`parse_answer`], and for any exit code other than 0.
#[track_caller]
pub fn parse_success(run: &Run, name: &str) -> Value {
    assert_eq!(run.code, Some(0), "{run:?}");
    parse_answer(run, name)
}

/// Validates `value` against `schema`, and stops at the first violation or unknown keyword.
///
/// * `root`: document in which references are resolved
///
/// # Errors
///
/// JSON pointer to the violation, and the expected value.
pub fn check(root: &Value, schema: &Value, value: &Value) -> Result<(), String> {
    Checker { root }.check("", schema, value)
}

struct Checker<'a> {
    root: &'a Value,
}

impl Checker<'_> {
    fn check(&self, at: &str, schema: &Value, value: &Value) -> Result<(), String> {
        if *schema == Value::Bool(true) {
            return Ok(());
        }
        let rules = schema.as_object().ok_or(format!("{at}: the schema is not an object"))?;
        let no_rules = serde_json::Map::new();
        let properties = rules.get("properties").and_then(Value::as_object).unwrap_or(&no_rules);
        for (word, rule) in rules {
            let fail = |what: String| Err(format!("{at}: {what}, found {value}"));
            let texts = || rule.as_array().cloned().unwrap_or_else(|| vec![rule.clone()]);
            let bound = || rule.as_f64().unwrap_or(f64::NAN);
            let number = value.as_f64();
            let length = value.as_array().map(|items| items.len() as f64);
            match word.as_str() {
                "$schema" | "title" | "description" | "format" => {}
                "$ref" => {
                    let target = rule.as_str().and_then(|rule| self.root.pointer(rule.strip_prefix('#')?));
                    self.check(at, target.ok_or(format!("{at}: {rule} leads nowhere"))?, value)?;
                }
                "anyOf" | "oneOf" => {
                    let tried: Vec<_> = texts().iter().map(|rule| self.check(at, rule, value)).collect();
                    let held = tried.iter().filter(|tried| tried.is_ok()).count();
                    if held == 0 || (word == "oneOf" && held > 1) {
                        return fail(format!("expected {word} of the alternatives ({tried:?})"));
                    }
                }
                "type" if !texts().iter().any(|t| has_type(t, value)) => return fail(format!("expected type {rule}")),
                "enum" if !texts().contains(value) => return fail(format!("expected one of {rule}")),
                "const" if rule != value => return fail(format!("expected {rule}")),
                // Rules for numbers or arrays do not apply to values of other types.
                "minimum" if number.is_some_and(|n| n < bound()) => return fail(format!("expected at least {rule}")),
                "maximum" if number.is_some_and(|n| n > bound()) => return fail(format!("expected at most {rule}")),
                "minItems" if length.is_some_and(|n| n < bound()) => return fail(format!("expected {rule} items")),
                "maxItems" if length.is_some_and(|n| n > bound()) => return fail(format!("expected {rule} items")),
                "type" | "enum" | "const" | "minimum" | "maximum" | "minItems" | "maxItems" => {}
                // Rules for objects do not apply to null.
                "required" if !value.is_object() => {}
                "required" => {
                    for key in texts() {
                        if value.get(key.as_str().unwrap_or_default()).is_none() {
                            return fail(format!("expected key {key}"));
                        }
                    }
                }
                "properties" => {
                    for (key, rule) in properties {
                        if let Some(field) = value.get(key) {
                            self.check(&format!("{at}/{key}"), rule, field)?;
                        }
                    }
                }
                "additionalProperties" => {
                    for (key, field) in value.as_object().into_iter().flatten() {
                        if !properties.contains_key(key) {
                            self.check(&format!("{at}/{key}"), rule, field)?;
                        }
                    }
                }
                "items" => {
                    for (i, item) in value.as_array().into_iter().flatten().enumerate() {
                        self.check(&format!("{at}/{i}"), rule, item)?;
                    }
                }
                other => return Err(format!("{at}: this checker does not know the keyword {other:?}")),
            }
        }
        Ok(())
    }
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
    fn schema_violations_are_found() {
        let schema = json!({
            "type": "object",
            "required": ["list"],
            "properties": {
                "list": {
                    "type": "array",
                    "items": { "type": ["integer", "null"], "enum": [1, 2, null] },
                    "maxItems": 2
                },
                "other": { "anyOf": [{ "$ref": "#/$defs/Small" }, { "type": "null" }] },
                "kind": { "oneOf": [{ "const": "a" }, { "const": "b" }] },
            },
            "additionalProperties": { "type": "integer" },
            "$defs": { "Small": { "type": "integer", "minimum": 1, "maximum": 3 } },
        });
        let check = |value: Value| {
            let mut rules = schema.clone();
            rules.as_object_mut().and_then(|rules| rules.remove("$defs"));
            check(&schema, &rules, &value)
        };
        assert_eq!(check(json!({ "list": [1, null], "more": 1, "other": 3, "kind": "b" })), Ok(()));
        assert_eq!(check(json!({ "list": [], "other": null })), Ok(()));
        let lists = [json!(1), json!([1.5]), json!([3]), json!([1, 1, 1])];
        let objects = [
            json!({ "list": [], "other": 0 }),
            json!({ "list": [], "other": 4 }),
            json!({ "list": [], "kind": "c" }),
            json!({ "list": [], "more": "text" }),
        ];
        let wrong = lists.map(|list| json!({ "list": list })).into_iter().chain(objects);
        for wrong in wrong.chain([json!([]), json!({})]) {
            assert!(check(wrong.clone()).is_err(), "{wrong}");
        }
        for schema in [json!({ "multipleOf": 1 }), json!({ "$ref": "#/$defs/None" }), Value::Null] {
            assert!(super::check(&schema, &schema, &json!(1)).is_err(), "{schema} must not pass");
        }
    }
}
