use super::file::PairFile;
use super::*;

mod accepted;
mod bodies;
mod drawings;
mod flanks;
mod refused;
mod slips;
mod text;

const PAPER: &str = include_str!("../../../../resources/pairs/palermo2013.json");
const UNMODIFIED: &str = include_str!("../../../../resources/pairs/palermo2013-unmodified.json");
const SPUR: &str = include_str!("../../../../resources/pairs/fzg-c.json");
const HELICAL: &str = include_str!("../../../../resources/pairs/helical-25-47.json");
const INTERNAL: &str = include_str!("../../../../resources/pairs/planet-ring-27-84.json");

/// `text` with the fields of `patch` (a JSON object) put over it; null removes a field.
fn patched(text: &str, patch: &str) -> String {
    fn merge(into: &mut serde_json::Value, patch: serde_json::Value) {
        match patch {
            serde_json::Value::Object(fields) if into.is_object() => {
                for (key, value) in fields {
                    if value.is_null() {
                        into.as_object_mut().unwrap().remove(&key);
                    } else {
                        merge(&mut into[key], value);
                    }
                }
            }
            other => *into = other,
        }
    }
    let mut json = serde_json::from_str(text).unwrap();
    merge(&mut json, serde_json::from_str(patch).unwrap());
    json.to_string()
}
