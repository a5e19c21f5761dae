//! Defects of a piece of JSON, in the terms of JSON and not of the program that reads it.

use std::fmt::Display;

use serde::de::DeserializeOwned;

/// A value as a type, or its defect: `its ior is "1.5", but must be a number`.
pub(crate) fn read<T: DeserializeOwned>(value: &serde_json::Value) -> Result<T, String> {
    // Only a refused value pays for the second pass that tracks the path.
    T::deserialize(value).map_err(|quick| match serde_path_to_error::deserialize::<_, T>(value) {
        Err(e) if e.path().iter().next().is_some() => {
            let path = e.path().to_string();
            let element = if path.starts_with('[') { "element " } else { "" };
            format!("its {element}{path} {}", fault(e.inner()))
        }
        _ => format!("it {}", fault(&quick)),
    })
}

/// A parser's error, as a predicate of the place: `is "3", but must be a whole number (line 2,
/// column 61)`.
pub(crate) fn fault(error: &impl Display) -> String {
    let text = error.to_string();
    let (message, position) = match text.rsplit_once(" at line ") {
        Some((message, at)) => (message, format!(" (line {})", at.replace(" column", ", column"))),
        None => (text.as_str(), String::new()),
    };
    let words = |prefix: &str| message.strip_prefix(prefix).and_then(|rest| rest.split_once(", expected "));
    let quoted = |prefix: &str| message.strip_prefix(prefix).map(|rest| rest.trim_matches('`'));
    let said = if let Some((found, wanted)) = words("invalid type: ").or_else(|| words("invalid value: ")) {
        format!("is {}, but must be {}", shown_value(found), wanted_value(wanted))
    } else if let Some((length, wanted)) = words("invalid length ") {
        format!("has {length} elements, but must be {}", wanted_value(wanted))
    } else if let Some(field) = quoted("missing field ") {
        format!("lacks the property {field}")
    } else if let Some(field) = quoted("duplicate field ") {
        format!("has the property {field} twice")
    } else if let Some((found, wanted)) = words("unknown variant ") {
        format!("is {}, but must be {}", found.replace('`', "\""), wanted.replace('`', "\""))
    } else {
        format!("cannot be read: {message}")
    };
    said + &position
}

/// A value as a parser names it.
fn shown_value(found: &str) -> String {
    const MAX_LENGTH: usize = 60;
    let plain = match found {
        "map" => "an object",
        "sequence" => "an array",
        "unit value" => "null",
        other => other,
    };
    let kinds = ["string ", "integer ", "floating point ", "boolean ", "character "];
    let value = kinds.iter().find_map(|kind| plain.strip_prefix(kind)).unwrap_or(plain).trim_matches('`');
    match value.char_indices().nth(MAX_LENGTH) {
        Some((end, _)) => format!("{}…", &value[..end]),
        None => value.to_owned(),
    }
}

/// A type as a parser names it.
fn wanted_value(wanted: &str) -> &str {
    match wanted {
        "f32" | "f64" => "a number",
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number, 0 or above",
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number",
        "a sequence" => "an array",
        "a map" => "an object",
        "a borrowed string" => "a string",
        other if other.starts_with("struct ") => "an object",
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde::Deserialize;
    use serde_json::json;

    use super::*;

    #[derive(Debug, Deserialize)]
    struct Item {
        #[expect(dead_code)]
        count: u32,
        #[expect(dead_code)]
        at: Option<[f32; 3]>,
    }

    fn wrong<T: DeserializeOwned + std::fmt::Debug>(value: serde_json::Value) -> String {
        read::<T>(&value).unwrap_err()
    }

    #[test]
    fn faults_are_reported_in_terms_of_json() {
        for (found, text) in [
            (wrong::<Item>(json!({"count": "3"})), "its count is \"3\", but must be a whole number, 0 or above"),
            (wrong::<Item>(json!({"count": 2.5})), "its count is 2.5, but must be a whole number, 0 or above"),
            (wrong::<Item>(json!({"count": 1, "at": ["x", 0, 0]})), "its at[0] is \"x\", but must be a number"),
            (wrong::<Item>(json!({"count": 1, "at": [0]})), "its at has 1 elements, but must be an array of length 3"),
            (
                wrong::<Vec<Item>>(json!([{"count": null}])),
                "its element [0].count is null, but must be a whole number, 0 or above",
            ),
            (wrong::<Item>(json!({})), "it lacks the property count"),
            (wrong::<Item>(json!(null)), "it is null, but must be an object"),
            (wrong::<Vec<u8>>(json!({})), "it is an object, but must be an array"),
            (wrong::<BTreeMap<String, f64>>(json!([])), "it is an array, but must be an object"),
        ] {
            assert_eq!(found, text);
        }
        let error = serde_json::from_str::<u32>("\n \"x\"").unwrap_err();
        assert_eq!(fault(&error), "is \"x\", but must be a whole number, 0 or above (line 2, column 4)");
        let long = wrong::<u32>(json!("x".repeat(1000)));
        assert!(long.len() < 200, "{long}");
    }
}
