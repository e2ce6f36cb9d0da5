//! Changes of JSON, CSV and bytes.

use gearmesh::random::Random;
use serde_json::Value;

/// Numbers in odd corners.
const ODD: [f64; 12] = [
    0.0, -0.0, 1.0, -1.0, 1e-15, 1e-9, 1e5, 1e9, 1e15, 1e-300, 1e300, 2e9,
];

/// A number below `count`, which is not 0.
pub fn below(count: usize, random: &mut Random) -> usize {
    (random.next() * count as f64) as usize
}

/// A number near `old` more often than not.
fn number(old: f64, random: &mut Random) -> f64 {
    match below(8, random) {
        0..=4 => old * random.within([0.9, 1.1]),
        5 => old * random.within([-3.0, 3.0]),
        6 => ODD[below(ODD.len(), random)],
        _ => old * ODD[below(ODD.len(), random)],
    }
}

/// JSON with one to three places changed; bytes of what is no JSON.
pub fn json(data: &[u8], random: &mut Random) -> Vec<u8> {
    let Ok(mut document) = serde_json::from_slice::<Value>(data) else {
        return bytes(data, random);
    };
    for _ in 0..=below(3, random) {
        change(&mut document, random);
    }
    document.to_string().into_bytes()
}

/// One item taken out, doubled, exchanged with the first, or all from it on taken out.
fn list<T: Clone>(items: &mut Vec<T>, random: &mut Random) {
    let i = below(items.len(), random);
    match below(4, random) {
        0 => drop(items.remove(i)),
        1 => items.insert(i, items[i].clone()),
        2 => items.swap(0, i),
        _ => items.truncate(i),
    }
}

fn string(text: &str, random: &mut Random) -> String {
    String::from_utf8_lossy(&bytes(text.as_bytes(), random)).into_owned()
}

/// Goes down at random, so that a field counts as much as a long array, and changes what it meets.
fn change(value: &mut Value, random: &mut Random) {
    let stop = below(10, random) == 0;
    match value {
        Value::Array(items) if !items.is_empty() && stop => list(items, random),
        Value::Array(items) if !items.is_empty() => {
            let i = below(items.len(), random);
            change(&mut items[i], random);
        }
        Value::Object(fields) if !fields.is_empty() => {
            let names: Vec<String> = fields.keys().cloned().collect();
            let name = &names[below(names.len(), random)];
            match below(3, random) {
                0 if stop => drop(fields.remove(name)),
                1 if stop => {
                    let other = &names[below(names.len(), random)];
                    fields[name] = fields[other].clone();
                }
                2 if stop => fields[name] = Value::Null,
                _ => change(&mut fields[name], random),
            }
        }
        Value::Number(old) => {
            let new = number(old.as_f64().unwrap_or(0.0), random);
            *value = if old.is_f64() {
                Value::from(new)
            } else {
                Value::from((new as i64).saturating_add(below(3, random) as i64 - 1))
            };
        }
        Value::Bool(flag) => *flag = !*flag,
        Value::String(text) => *text = string(text, random),
        // Null, empty array, empty object.
        _ => {
            let others = [Value::from(1.0), Value::Array(vec![]), Value::from("text")];
            *value = others[below(3, random)].clone();
        }
    }
}

/// CSV with one to three cells or lines changed; bytes of what is no text.
pub fn csv(data: &[u8], random: &mut Random) -> Vec<u8> {
    let Ok(text) = str::from_utf8(data) else {
        return bytes(data, random);
    };
    let mut lines: Vec<Vec<String>> = text
        .lines()
        .map(|line| line.split(',').map(str::to_owned).collect())
        .collect();
    for _ in 0..=below(3, random) {
        if lines.is_empty() {
            break;
        }
        if below(3, random) == 0 {
            list(&mut lines, random);
            continue;
        }
        let i = below(lines.len(), random);
        let k = below(lines[i].len(), random);
        let cell = &mut lines[i][k];
        *cell = match cell.trim().parse::<f64>() {
            Ok(old) => number(old, random).to_string(),
            Err(_) => string(cell, random),
        };
    }
    let lines: Vec<String> = lines.iter().map(|cells| cells.join(",")).collect();
    (lines.join("\n") + "\n").into_bytes()
}

/// XML with one to three texts or elements changed; bytes of what is no text.
pub fn xml(data: &[u8], random: &mut Random) -> Vec<u8> {
    let Ok(text) = str::from_utf8(data) else {
        return bytes(data, random);
    };
    // Each with what follows it up to the next one.
    let mut tags: Vec<String> = text.split('<').map(str::to_owned).collect();
    for _ in 0..=below(3, random) {
        if tags.is_empty() {
            break;
        }
        let i = below(tags.len(), random);
        let changed = match tags[i].split_once('>') {
            Some((tag, text)) if !text.trim().is_empty() => {
                let text = match text.trim().parse::<f64>() {
                    Ok(old) => number(old, random).to_string(),
                    Err(_) => string(text, random),
                };
                format!("{tag}>{text}")
            }
            // Few elements go, and few names change: most that is left is then refused.
            _ if below(4, random) == 0 => {
                list(&mut tags, random);
                continue;
            }
            _ if below(4, random) == 0 => string(&tags[i], random),
            _ => continue,
        };
        tags[i] = changed;
    }
    tags.join("<").into_bytes()
}

/// One byte changed, taken out or put in, or the rest cut off.
pub fn bytes(data: &[u8], random: &mut Random) -> Vec<u8> {
    let mut data = data.to_vec();
    let i = below(data.len() + 1, random);
    let byte = below(256, random) as u8;
    match below(4, random) {
        0 if i < data.len() => data[i] = byte,
        1 if i < data.len() => drop(data.remove(i)),
        2 => data.truncate(i),
        _ => data.insert(i, byte),
    }
    data
}
