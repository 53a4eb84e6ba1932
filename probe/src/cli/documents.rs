//! JSON documents compared in tests.

use serde_json::Value;

/// Whether two documents have the same keys, lists, texts and, to nine digits, numbers.
///
/// # Panics
/// At the first place where they differ, with its path.
pub fn assert_same(found: &Value, expected: &Value) {
    same("", found, expected);
}

fn same(path: &str, found: &Value, expected: &Value) {
    match (found, expected) {
        (Value::Object(found), Value::Object(expected)) => {
            assert!(found.keys().eq(expected.keys()), "{path}: {found:?}");
            for (key, value) in found {
                same(&format!("{path}/{key}"), value, &expected[key]);
            }
        }
        (Value::Array(found), Value::Array(expected)) => {
            assert_eq!(found.len(), expected.len(), "{path}");
            for (index, (found, expected)) in found.iter().zip(expected).enumerate() {
                same(&format!("{path}/{index}"), found, expected);
            }
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            assert!((a - b).abs() <= 1e-9 * b.abs(), "{path}: {a} for {b}");
        }
        _ => assert_eq!(found, expected, "{path}"),
    }
}
