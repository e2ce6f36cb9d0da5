//! Fields of a pair file that have another form: all that can be found in one go, in the words of its author.

use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use serde_path_to_error::{Path, Segment};

use super::file::{FrictionFile, GearFile, OperatingFile, PairFile, ToothErrorsFile};
use gearmesh::words::shown;

/// A field of another form.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Misformed {
    /// Path of the field, such as `gear1.tip_relief.shape`; `.` is the whole file.
    pub field: String,
    /// What is wrong, the names expected, and the place in the file.
    pub message: String,
}

/// Most fields of another form in one message.
const MOST_MISFORMED: usize = 20;

type FormError = serde_path_to_error::Error<serde_json::Error>;

/// The `first` error of `text`, and those that are left once it is mended, one after the other. `plain` is the text without comments.
pub(super) fn all_misformed(text: &str, plain: &[u8], first: FormError) -> Vec<Misformed> {
    let mut found = vec![form(text, &first.path().to_string(), first.inner())];
    let Ok(mut fields) = serde_json::from_slice::<Value>(plain) else {
        return found;
    };
    let mut error = first;
    for _ in 1..MOST_MISFORMED {
        let next = match mended(&mut fields, &error) {
            Some(Err(next)) => next,
            Some(Ok(_)) | None => break,
        };
        let field = next.path().to_string();
        let mut more = form(text, &field, next.inner());
        let line = line_of(plain, next.path());
        more.message = format!("{} (line {line})", more.message);
        // A required value that had to be taken out is missing then.
        if found.iter().all(|known| known.field != more.field) {
            found.push(more);
        }
        error = next;
    }
    found
}

/// `fields` as a pair file after `error` has been taken out of them, with the next error; None where that cannot be done.
fn mended(fields: &mut Value, error: &FormError) -> Option<Result<PairFile, FormError>> {
    let said = error.inner().to_string();
    let quoted: Vec<&str> = said.split('`').skip(1).step_by(2).collect();
    let steps = pointer(error.path());
    let [given, known @ ..] = &quoted[..] else {
        return with_another_value(fields, &steps, &[]);
    };
    if said.starts_with("missing field") {
        return with_another_value(fields, &[&steps[..], &[(*given).to_owned()]].concat(), &[]);
    }
    if !said.starts_with("unknown field") {
        return with_another_value(fields, &steps, known);
    }
    let (last, group) = steps.split_last()?;
    let group = fields.pointer_mut(&joined(group))?.as_object_mut()?;
    let value = group.remove(last)?;
    // A slip of the pen has a value of the right form, and leaves no required field out.
    if let Some(meant) = nearest(given, known).filter(|meant| !group.contains_key(*meant)) {
        group.insert(meant.to_owned(), value);
    }
    Some(serde_path_to_error::deserialize(&*fields))
}

/// Whether `error` is about the field `at`, or one in it.
fn stands_at(error: &FormError, at: &[String]) -> bool {
    let said = error.inner().to_string();
    let mut there = pointer(error.path());
    if said.starts_with("missing field") {
        there.extend(said.split('`').nth(1).map(str::to_owned));
    }
    there.starts_with(at)
}

/// `fields` with a value at `at` that has the right form, one of `known` names, or without any there: the first that leads to no error
/// there.
fn with_another_value(
    fields: &mut Value,
    at: &[String],
    known: &[&str],
) -> Option<Result<PairFile, FormError>> {
    let (last, group) = at.split_last()?;
    let group = joined(group);
    let mut values = vec![json!(1), json!(true), json!([0, 1]), json!("name")];
    values.extend(known.iter().map(|name| json!(name)));
    if let Value::Array(list) = fields.pointer(&group)? {
        // Another entry of the list has the right form, or its error has been named.
        values.extend(list.iter().find(|value| value.is_object()).cloned());
    }
    for value in values.into_iter().map(Some).chain([None]) {
        match (fields.pointer_mut(&group)?, value) {
            (Value::Object(group), Some(value)) => drop(group.insert(last.clone(), value)),
            (Value::Object(group), None) => drop(group.remove(last)),
            (Value::Array(list), Some(value)) => {
                *list.get_mut(last.parse::<usize>().ok()?)? = value;
            }
            _ => return None,
        }
        match serde_path_to_error::deserialize(&*fields) {
            Err(error) if stands_at(&error, at) => (),
            read => return Some(read),
        }
    }
    None
}

/// The steps of `path` into the fields.
fn pointer(path: &Path) -> Vec<String> {
    path.iter()
        .filter_map(|segment| match segment {
            Segment::Map { key } => Some(key.clone()),
            Segment::Seq { index } => Some(index.to_string()),
            Segment::Enum { .. } | Segment::Unknown => None,
        })
        .collect()
}

fn joined(steps: &[String]) -> String {
    steps
        .iter()
        .map(|step| format!("/{}", step.replace('~', "~0").replace('/', "~1")))
        .collect()
}

/// Line of `plain` on which the last name of `path` stands that is found after the names before it.
fn line_of(plain: &[u8], path: &Path) -> usize {
    let text = String::from_utf8_lossy(plain);
    let mut at = 0;
    for segment in path.iter() {
        if let Segment::Map { key } = segment {
            let name = Value::from(key.as_str()).to_string();
            at = text[at..].find(&name).map_or(at, |further| at + further);
        }
    }
    text[..at].matches('\n').count() + 1
}

/// The error in plain words, with the path of its field and the text about its place.
pub(super) fn form(text: &str, path: &str, error: &serde_json::Error) -> Misformed {
    let (line, column) = (error.line(), error.column());
    let here = text.lines().nth(line.saturating_sub(1)).unwrap_or_default();
    let error = error.to_string();
    let said = error.split(" at line ").next().unwrap_or(&error);
    let quoted: Vec<&str> = said.split('`').skip(1).step_by(2).collect();
    // The path ends in `?` where a name could not be read.
    let path = path.trim_end_matches(['?', '.']);
    let mut field = if path.is_empty() { "." } else { path }.to_owned();
    let message = match &quoted[..] {
        [given, known @ ..] if said.starts_with("unknown field") => unknown_field(given, known),
        [given, known @ ..] if said.starts_with("unknown variant") => {
            unknown_name(given, known, "name")
        }
        [name, ..] if said.starts_with("missing field") => {
            let group = if path.is_empty() { "" } else { "." };
            field = format!("{path}{group}{name}");
            "this field is required and missing".into()
        }
        _ if said == "expected value" && is_a_value(here, column, &field) => {
            "this value has no meaning here; one of the names of this field in double quotes is expected, or fields in braces such \
             as { \"diameter_mm\": 88.0 } where it has some".into()
        }
        _ if said == "expected value" && field.ends_with("start") && has_second_name(here, column) => {
            "one name with its value is expected in these braces, such as { \"diameter_mm\": 88.0 }; leave the others out".into()
        }
        [name, ..] if said.starts_with("duplicate field") => {
            format!("`{name}` stands twice; leave one of them out")
        }
        _ => match said.split_once(", expected ") {
            Some((given, "an array of length 2")) => mistyped(given, two_numbers(&field)),
            Some((given, expected)) => mistyped(given, expected),
            None if field == "." && text.trim_start().starts_with('<') => {
                "this is XML and no pair file; `gearmesh new --rexs` makes a pair file of a REXS file".into()
            }
            None if said == "trailing characters" && field != "." => format!(
                "there are more than two numbers; {} is expected, with a decimal point in each, such as [-0.5, 0.5]",
                two_numbers(&field)
            ),
            None => in_plain_words(said, &field).to_owned(),
        },
    };
    let about: String = (here.chars())
        .skip(column.saturating_sub(50))
        .take(70)
        .collect();
    let about = shown(about.trim());
    let place = format!(" (line {line}, column {column}: {about})");
    Misformed {
        field: shown(&field),
        message: if line == 0 { message } else { message + &place },
    }
}

/// Whether a value of `field` itself begins at that byte of the line `here`, counted from 1.
fn is_a_value(here: &str, column: usize, field: &str) -> bool {
    let Some((before, value)) = here.split_at_checked(column.saturating_sub(1)) else {
        return false;
    };
    let name = field.rsplit('.').next().unwrap_or(field);
    let before = before.trim_end().strip_suffix(':').map(str::trim_end);
    before.is_some_and(|before| before.ends_with(&format!("\"{name}\"")))
        && value.starts_with(|c: char| c.is_ascii_digit() || "-tfn[".contains(c))
}

/// Whether a value ends with that many bytes of the line `here`, and a comma stands where braces should close.
fn has_second_name(here: &str, column: usize) -> bool {
    here.split_at_checked(column)
        .is_some_and(|(before, after)| {
            before.ends_with(|c: char| c.is_ascii_digit() || c == '"')
                && after.trim_start().starts_with(',')
        })
}

/// What the two numbers of `field` are.
fn two_numbers(field: &str) -> &'static str {
    match field {
        _ if field.contains("_over_temperature") => "a pair [°C, GPa]",
        _ if field.ends_with("_ra_um") => "[gear 1, gear 2]",
        _ => "[lowest, highest]",
    }
}

/// What to say of text that is no JSON.
fn in_plain_words<'a>(said: &'a str, field: &str) -> &'a str {
    match said {
        "expected value" => {
            "no value of this field stands here; give a number such as 4.0, text or a name in double quotes, true or \
             false, or fields in braces such as { \"diameter_mm\": 88.0 }"
        }
        "key must be a string" => {
            "the name of a field in double quotes is expected here; numbers have a decimal point, no comma"
        }
        "trailing characters" => "something stands after the closing bracket",
        "invalid number" => "this is no number; write 4.0 or 0.5, without leading zeros",
        "number out of range" => "the number is out of range",
        "EOF while parsing a string"
        | "control character (\\u0000-\\u001F) found while parsing a string" => {
            "a text is not closed by a double quote on its line"
        }
        "EOF while parsing a value" if field == "." => {
            "there are no fields; `gearmesh new` writes a file to start from"
        }
        _ if said.starts_with("EOF") => {
            "the file ends before its last bracket is closed; it may have been cut"
        }
        other => other,
    }
}

/// What to say of a field that a part of the file does not have.
fn unknown_field(given: &str, known: &[&str]) -> String {
    // It may be a field of another part of the file.
    let parts = [
        ("the whole pair, outside of the gears", names::<PairFile>()),
        ("`gear1` and `gear2`", names::<GearFile>()),
        ("`tooth_errors`", names::<ToothErrorsFile>()),
        ("`operating`", names::<OperatingFile>()),
        ("`friction`", names::<FrictionFile>()),
    ];
    let is_near = nearest(given, known).is_some();
    for (part, fields) in parts.iter().filter(|_| !is_near) {
        let fields: Vec<&str> = fields.iter().map(String::as_str).collect();
        if let Some(name) = nearest(given, &fields) {
            let given = shown(given);
            return format!("there is no field `{given}` here; `{name}` is a field of {part}");
        }
    }
    unknown_name(given, known, "field")
}

/// What to say of a name that is none of those `known`.
fn unknown_name(given: &str, known: &[&str], what: &str) -> String {
    // The path has it in full.
    let name = shown(&given.chars().take(60).collect::<String>());
    let meant = nearest(given, known).map(|meant| format!("did you mean `{meant}`?"));
    // Names of older files begin with a capital.
    let known: Vec<&str> = known
        .iter()
        .filter(|name| name.starts_with(char::is_lowercase))
        .copied()
        .collect();
    let hint = meant.unwrap_or_else(|| format!("there are `{}`", known.join("`, `")));
    format!("there is no {what} `{name}` here; {hint}")
}

/// Names of the fields of a part of the file, as its deserialiser lists them when it refuses one.
fn names<T: DeserializeOwned>() -> Vec<String> {
    // Read as `parse` does, so that the deserialisers are compiled once.
    let mut json = serde_json::Deserializer::from_slice(br#"{"": 0}"#);
    let refused = serde_path_to_error::deserialize::<_, T>(&mut json).err();
    let said = refused.map_or_else(String::new, |error| error.inner().to_string());
    let names = said.split('`').skip(3).step_by(2);
    names.map(str::to_owned).collect()
}

/// Letters of drawings and standards, each before the field that it stands for.
const LETTERS: &str = "a center_distance_mm alpha normal_pressure_angle_deg b face_width_mm beta helix_angle_deg \
    da tip_diameter_mm df root_diameter_mm dm ball_diameter_mm e youngs_modulus_gpa jbn normal_backlash_um \
    m normal_module_mm mdk dimension_over_balls_mm mn normal_module_mm nu poisson_ratio pz lead_mm \
    sn normal_tooth_thickness_mm wk span_measurement_mm x profile_shift z teeth";

/// From 0 to 1, by slips of the hand and by parts that are missing.
fn likeness(a: &str, b: &str) -> f64 {
    strsim::normalized_damerau_levenshtein(a, b).max(strsim::sorensen_dice(a, b))
}

/// The name that `given` is probably meant to be.
fn nearest<'a>(given: &str, names: &[&'a str]) -> Option<&'a str> {
    let given = given.to_lowercase().replace("centre", "center");
    let letter = given.replace('_', "");
    let mut words = LETTERS.split(' ');
    let meant = words
        .position(|word| word == letter)
        .and_then(|_| words.next());
    if let Some(name) = names.iter().find(|name| Some(**name) == meant) {
        return Some(name);
    }
    // The first of those that are equally near.
    let rated = names.iter().rev().map(|&name| {
        // Words in common at the end, such as the unit, do not make a name.
        let shared = given.rsplit('_').zip(name.rsplit('_'));
        let shared: usize = (shared.take_while(|(a, b)| a == b))
            .map(|(word, _)| word.len() + 1)
            .sum();
        let [a, b] = [&given[..], name].map(|all| &all[..all.len().saturating_sub(shared)]);
        let likeness = match !a.is_empty() && !b.is_empty() && likeness(a, b) < 0.5 {
            true => 0.0,
            false => likeness(&given, name),
        };
        (likeness, name)
    });
    let best = rated.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 >= 0.6).then_some(best.1)
}

/// What to say of a value of another kind, from the words of the deserialiser.
fn mistyped(given: &str, expected: &str) -> String {
    let given = given.split_once(": ").map_or(given, |(_, given)| given);
    let expected = match expected {
        "f64" => "a bare number in the unit of the field's name",
        "u32" => "a whole number, 0 to 4294967295",
        "i32" => "a whole number",
        "u8" => "a whole number, 0 to 255",
        "a sequence" => "a list in brackets",
        "newtype variant" => "a value in braces, such as { \"diameter_mm\": 88.0 },",
        "a string" | "string" => "a text in double quotes",
        "a boolean" => "true or false",
        part if part.starts_with("struct") => "fields in braces, { ... }",
        other => other,
    };
    if let Some(text) = given.strip_prefix("string ") {
        let number = text.trim_matches('"').replace(',', ".");
        return match number.parse::<f64>() {
            Ok(_) => format!("{text} is text; write it without quotes: {number}"),
            Err(_) => format!("{} is text; {expected} is expected", shown(text)),
        };
    }
    let given = match given {
        "map" => "fields in braces".into(),
        "sequence" => "a list in brackets".into(),
        "unit variant" => "the name alone".into(),
        "null" | "unit value" => "null is no value".into(),
        // A kind, and the value in backticks.
        other => shown(other.find('`').map_or(other, |value| &other[value..])),
    };
    format!("{given}; {expected} is expected")
}
