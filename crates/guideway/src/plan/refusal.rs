//! Parameters whose values cannot be read: which one it is, and what it may be.

use crate::error::PlanError;
use serde_json::{Value, json};

/// The error for parameters of `name` that `read` refuses with `error`: the first that it does not take by itself.
pub(crate) fn refused(name: &str, given: &Value, read: impl Fn(Value) -> Result<(), serde_json::Error>, error: &serde_json::Error) -> PlanError {
    let alone = |key: &str, value: &Value| read(json!({ key: value })).err();
    for (key, value) in given.as_object().into_iter().flatten() {
        let Some(error) = alone(key, value) else { continue };
        let mut text = error.to_string();
        if expected(&text) == "string or map" {
            // A choice that was given something else than a name: ask with a name that is none of it.
            text = alone(key, &json!("")).map_or(text, |error| error.to_string());
        }
        let shown = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        return PlanError::bad(format!("{name}.{key}"), shown, allowed(&text));
    }
    PlanError::bad(name, "its parameters", error.to_string())
}

/// What was expected, in the words of the reader.
fn expected(text: &str) -> &str {
    text.rsplit_once("expected ").map_or(text, |(_, rest)| rest)
}

/// What is allowed, in ours.
fn allowed(text: &str) -> String {
    let expected = expected(text);
    let names: Vec<&str> = expected.split('`').skip(1).step_by(2).collect();
    match expected {
        _ if !names.is_empty() => format!("one of {}", names.join(", ")),
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number, 0 or more".into(),
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number".into(),
        "f32" | "f64" => "a number".into(),
        "a boolean" => "true or false".into(),
        other => other.into(),
    }
}

#[cfg(test)]
mod tests {
    use crate::plan::planner;
    use serde_json::json;

    #[test]
    fn a_value_that_cannot_be_read_is_named_with_what_it_may_be() {
        for (parameters, expected) in [
            (json!({"ants": 5, "graph": "x"}), "improved-aco.graph = x is not allowed: one of lattice, corners"),
            (json!({"preset": "mine"}), "improved-aco.preset = mine is not allowed: one of default, paper, recommended"),
            (json!({"seeding": 4}), "improved-aco.seeding = 4 is not allowed: one of "),
            (json!({"ants": "many"}), "improved-aco.ants = many is not allowed: a whole number, 0 or more"),
            (json!({"ants": -3}), "improved-aco.ants = -3 is not allowed: a whole number, 0 or more"),
            (json!({"evaporation": "fast"}), "improved-aco.evaporation = fast is not allowed: a number"),
            (json!({"preset": "paper", "o1": 3}), "improved-aco.o1 = 3 is not allowed: true or false"),
        ] {
            let error = planner("improved-aco", parameters.clone()).err().unwrap_or_else(|| panic!("{parameters} is taken"));
            assert_eq!(error.name(), "BadParameter");
            assert!(error.to_string().starts_with(expected), "{error}");
        }
    }
}
