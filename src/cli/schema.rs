//! The schema of each JSON object that a command prints: its name and its version.
//!
//! A version rises when a key is removed, renamed or changes its meaning; a new key leaves it.

use serde_json::Value;

/// `object` with the key `schema`: `"verify/1"` and so on.
pub fn object(schema: &str, mut object: Value) -> Value {
    if let Some(object) = object.as_object_mut() {
        object.insert("schema".into(), schema.into());
    }
    object
}
