//! What glTF has no place for: the object `ontile` in the extras of nodes and of the file itself.

use gltf::json::Extras;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::document::Document;
use crate::Result;

/// The value of `key` in an element's `ontile` object; `None` if there is none.
pub fn get<T: DeserializeOwned>(
    doc: &Document,
    extras: &Extras,
    element: &str,
    key: &str,
) -> Result<Option<T>> {
    let place = if element.is_empty() { "extras.ontile".into() } else { format!("{element}.extras.ontile") };
    let Some(raw) = extras else { return Ok(None) };
    // Extras may be anything; what is not an object is someone else's.
    let Ok(Value::Object(mut all)) = serde_json::from_str(raw.get()) else { return Ok(None) };
    let Some(ontile) = all.remove("ontile") else { return Ok(None) };
    let Value::Object(mut ours) = ontile else {
        return Err(doc.bad(place, "is no object", "make it one, or remove it"));
    };
    let Some(value) = ours.remove(key) else { return Ok(None) };
    serde_json::from_value(value).map(Some).map_err(|error| {
        doc.bad(format!("{place}.{key}"), format!("cannot be read: {error}"), "correct it, or remove it")
    })
}
