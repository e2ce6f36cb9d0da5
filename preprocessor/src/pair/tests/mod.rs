use super::*;

mod accepted;
mod drawings;
mod flanks;
mod refused;
mod signs;

const PAPER: &str = include_str!("../../../../resources/pairs/palermo2013.json");
const UNMODIFIED: &str = include_str!("../../../../resources/pairs/palermo2013-unmodified.json");
const SPUR: &str = include_str!("../../../../resources/pairs/fzg-c.json");
const HELICAL: &str = include_str!("../../../../resources/pairs/helical-25-47.json");
const INTERNAL: &str = include_str!("../../../../resources/pairs/planet-ring-27-84.json");

/// `text` with the fields of `patch` (a JSON object) put over it; null removes a field.
fn patched(text: &str, patch: &str) -> String {
    fn merge(into: &mut Value, patch: Value) {
        match patch {
            Value::Object(fields) if into.is_object() => {
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

/// The pair of `text` under `patch`.
fn pair(text: &str, patch: &str) -> Pair {
    from_json(&patched(text, patch)).unwrap_or_else(|error| panic!("{patch}: {error}"))
}

/// Why `text` under `patch` is refused: all that is found.
fn refusals(text: &str, patch: &str) -> Vec<Refusal> {
    match from_json(&patched(text, patch)) {
        Err(PairError::Refused(refusals)) => refusals.all().to_vec(),
        other => panic!("{patch}: {other:?}"),
    }
}

/// The first of them.
fn refusal(text: &str, patch: &str) -> Refusal {
    refusals(text, patch).swap_remove(0)
}

/// Whether a note of `pair` has these words.
fn is_noted(pair: &Pair, words: &str) -> bool {
    pair.warnings.iter().any(|note| note.contains(words))
}

/// The file of this name in a table of cases.
fn named(name: &str) -> String {
    match name {
        "paper" => PAPER.into(),
        "spur" => SPUR.into(),
        "helical" => HELICAL.into(),
        "internal" => INTERNAL.into(),
        "webbed" => patched(PAPER, accepted::WEBBED),
        "shaft" => patched(PAPER, accepted::SHAFT),
        "bearings" => patched(PAPER, accepted::ON_BEARINGS),
        "large mate" => patched(SPUR, refused::LARGE_MATE),
        "drawing" => drawings::drawings()[0]["file"].to_string(),
        other => panic!("{other}"),
    }
}

/// Rows of a table with bars between its columns; lines that begin with # say what they are.
fn rows<const N: usize>(table: &str) -> impl Iterator<Item = [&str; N]> {
    let lines = table.lines().filter(|line| !line.starts_with('#'));
    lines.map(|line| {
        let cells: Vec<&str> = line.split(" | ").collect();
        cells.try_into().unwrap_or_else(|_| panic!("{line}"))
    })
}
