//! From the text of a pair file to its fields: JSON, in which comments, commas before a closing bracket and a
//! byte-order mark are allowed, and what is wrong with it in the words of its author.

use std::io::Read;
use std::path::Path;

use serde::de::DeserializeOwned;

use super::error::PairError;
use super::file::{FrictionFile, GearFile, OperatingFile, PairFile, ToothErrorsFile};
use gearmesh::words::shown;

/// Longest pair file or topography, bytes.
const LONGEST: u64 = 4 << 20;

/// The text of the file at `path`, of at most 4 MiB.
pub(super) fn read(path: &Path) -> std::io::Result<String> {
    let file = std::fs::File::open(path)?;
    let mut bytes = Vec::new();
    // One byte more than allowed tells a longer file, even where no length is known.
    let length = file.take(LONGEST + 1).read_to_end(&mut bytes)?;
    let other = |what: String| Err(std::io::Error::other(what));
    if bytes.starts_with(b"PK") {
        return other("it is an archive, such as an FMU, and no text".into());
    }
    if length as u64 > LONGEST {
        return other(format!(
            "it is longer than {} MiB, and a pair file has a few thousand bytes",
            LONGEST >> 20
        ));
    }
    String::from_utf8(bytes).or_else(|_| other("it is no text in UTF-8".into()))
}

/// The fields of the file at `path`.
///
/// # Errors
/// [`PairError::Read`] when the file cannot be read, else as [`parse`].
pub(super) fn read_fields(path: &Path) -> Result<PairFile, PairError> {
    let text = read(path).map_err(|source| PairError::Read {
        path: path.to_owned(),
        source,
    })?;
    parse(&text)
}

/// The fields of `text`.
///
/// # Errors
/// [`PairError::Form`] with path, line and column.
pub(super) fn parse(text: &str) -> Result<PairFile, PairError> {
    let text = text.trim_start_matches('\u{feff}');
    let mut plain = text.as_bytes().to_vec();
    // A lone `/` ends it early, and what is left of it is an error of the parser at its place.
    let _ = json_strip_comments::strip_slice(&mut plain);
    // Blanks take the place of comments; with their ends of lines, too, places in the file stay what they are.
    for (byte, before) in plain.iter_mut().zip(text.bytes()) {
        if before == b'\n' {
            *byte = before;
        }
    }
    let mut json = serde_json::Deserializer::from_slice(&plain);
    let file = serde_path_to_error::deserialize(&mut json)
        .map_err(|error| form(text, &error.path().to_string(), error.inner()))?;
    json.end().map_err(|error| form(text, ".", &error))?;
    Ok(file)
}

fn form(text: &str, path: &str, error: &serde_json::Error) -> PairError {
    let (line, column) = (error.line(), error.column());
    // The path ends in `?` where a name could not be read.
    let path = match path.trim_end_matches(['?', '.']) {
        "" => ".",
        path => path,
    };
    let told = error.to_string();
    let told = told
        .strip_suffix(&format!(" at line {line} column {column}"))
        .unwrap_or(&told);
    let (field, message) = if error.is_data() {
        of_data(path, told)
    } else {
        of_syntax(text, path, told, [line, column])
    };
    PairError::Form {
        field: shown(&field),
        message: if line == 0 {
            message
        } else {
            format!("{message} (line {line}, column {column})")
        },
    }
}

/// Field and message of text that is no JSON.
fn of_syntax(text: &str, path: &str, told: &str, [line, column]: [usize; 2]) -> (String, String) {
    if let Some((field, comma)) = decimal_comma(text, line, column) {
        let field = match path {
            "." => field,
            _ if path.ends_with(&field) => path.to_owned(),
            _ => format!("{path}.{field}"),
        };
        return (field, decimal_point(&comma));
    }
    let message = match told {
        "expected value" if let Some(value) = value_at(text, line, column) => {
            return (path.to_owned(), no_name(path, &value));
        }
        "expected value" => {
            "no value that JSON knows stands here; give a number such as 4.0, text in double quotes, true or false"
        }
        "key must be a string" => "the name of a field in double quotes is expected here",
        "invalid number" => "this is no number; write 4.0 or 0.5, without leading zeros",
        "number out of range" => "the number is out of range",
        "EOF while parsing a string"
        | "control character (\\u0000-\\u001F) found while parsing a string" => {
            "a text is not closed by a double quote on its line"
        }
        "EOF while parsing a value" if path == "." => {
            "there are no fields; `gearmesh new` writes a file to start from"
        }
        _ if told.starts_with("EOF") => {
            "the file ends before its last bracket is closed; it may have been cut"
        }
        "trailing characters" if path != "." => {
            "there are more than two numbers; [lowest, highest] are expected, with a decimal point in each, such as \
             [-0.5, 0.5]"
        }
        "trailing characters" => "something stands after the closing bracket",
        other => other,
    };
    (path.to_owned(), message.to_owned())
}

/// The text of `line` from `column` on, and what is before; both count from 1.
fn split_at(text: &str, line: usize, column: usize) -> Option<(&str, &str)> {
    let line = text.lines().nth(line.checked_sub(1)?)?;
    line.split_at_checked(column.checked_sub(1)?)
}

/// The number, list or other value of JSON at `column` of `line`.
fn value_at(text: &str, line: usize, column: usize) -> Option<String> {
    let (_, rest) = split_at(text, line, column)?;
    let value = rest.split([',', '}']).next()?.trim();
    let is_value = |v: &str| serde_json::from_str::<serde_json::Value>(v).is_ok();
    (is_value(value) || value.starts_with('[')).then(|| value.to_owned())
}

/// What to say of a value where a field takes names.
fn no_name(path: &str, value: &str) -> String {
    let given = shown(value);
    if !path.ends_with("start") {
        return format!("`{given}`; one of the names of this field in double quotes is expected");
    }
    let diameter = value.parse().unwrap_or(88.0);
    format!(
        "`{given}` is no start of a relief; give {{ \"diameter_mm\": {diameter} }} or \"pitch_point\""
    )
}

/// The field and the number where the text around `column` of `line` is a number with a decimal comma.
fn decimal_comma(text: &str, line: usize, column: usize) -> Option<(String, String)> {
    let (before, rest) = split_at(text, line, column)?;
    let digits = |c: char| c.is_ascii_digit();
    let fraction: String = rest.chars().take_while(|&c| digits(c)).collect();
    let whole_and_name = before.trim_end().strip_suffix(',')?;
    let (name, whole) = whole_and_name.rsplit_once(':')?;
    let whole = whole.trim();
    let is_whole = |text: &str| !text.is_empty() && text.chars().all(digits);
    if !is_whole(whole.strip_prefix('-').unwrap_or(whole)) || fraction.is_empty() {
        return None;
    }
    let name = name.trim().strip_suffix('"')?.rsplit('"').next()?;
    Some((name.to_owned(), format!("{whole},{fraction}")))
}

fn decimal_point(number: &str) -> String {
    format!(
        "{number} has a decimal comma; write {} with a point",
        number.replace(',', ".")
    )
}

/// Field and message of JSON that is no pair file.
fn of_data(path: &str, told: &str) -> (String, String) {
    let names: Vec<&str> = told.split('`').skip(1).step_by(2).collect();
    let mut field = path.to_owned();
    let message = match (&names[..], told.split_once(", expected ")) {
        ([given, expected @ ..], _) if told.starts_with("unknown field") => {
            unknown_field(given, expected)
        }
        ([given, expected @ ..], _) if told.starts_with("unknown variant") => {
            let meant = match nearest(given, expected) {
                Some(name) => format!("; did you mean \"{name}\"?"),
                None => String::new(),
            };
            let (given, all) = (shown(given), listed(expected));
            format!("\"{given}\" is none of its values{meant} There are {all}")
        }
        ([name, ..], _) if told.starts_with("missing field") => {
            field = match path {
                "." => (*name).to_owned(),
                _ => format!("{path}.{name}"),
            };
            "this field is required and missing".into()
        }
        _ if told.starts_with("duplicate field") => {
            "this field stands twice; leave one of them out".into()
        }
        (_, Some((given, "an array of length 2"))) if given.starts_with("invalid length") => {
            "two numbers are expected, [lowest, highest]".into()
        }
        (_, Some((given, expected))) => {
            let given = given.split_once(": ").map_or(given, |(_, given)| given);
            mistyped(given, expected)
        }
        _ => told.to_owned(),
    };
    (field, message)
}

/// What to say of a field that a part of the file does not have.
fn unknown_field(given: &str, expected: &[&str]) -> String {
    let name_given = shown(given);
    if let Some(name) = nearest(given, expected) {
        return format!("there is no field `{name_given}`; did you mean `{name}`?");
    }
    // A field of another part of the file.
    let parts = [
        ("the whole pair, outside of the gears", names::<PairFile>()),
        ("`gear1` and `gear2`", names::<GearFile>()),
        ("`tooth_errors`", names::<ToothErrorsFile>()),
        ("`operating`", names::<OperatingFile>()),
        ("`friction`", names::<FrictionFile>()),
    ];
    for (part, fields) in parts {
        let fields: Vec<&str> = fields.iter().map(String::as_str).collect();
        if let Some(name) = nearest(given, &fields) {
            return format!("there is no field `{name_given}` here; `{name}` is a field of {part}");
        }
    }
    let all = listed(expected);
    format!("there is no field `{name_given}`; there are {all}")
}

/// Names of the fields of a part of the file, as its deserialiser lists them when it refuses one.
fn names<T: DeserializeOwned>() -> Vec<String> {
    // Read as `parse` does, so that the deserialisers are compiled once.
    let mut json = serde_json::Deserializer::from_slice(br#"{"": 0}"#);
    let refused = serde_path_to_error::deserialize::<_, T>(&mut json).err();
    let told = refused.map_or_else(String::new, |error| error.inner().to_string());
    let names = told.split('`').skip(3).step_by(2);
    names.map(str::to_owned).collect()
}

/// The letters of drawings and standards, and what they have in place of a field.
const LETTERS: &[(&str, &str)] = &[
    ("a", "center_distance_mm"),
    ("alpha", "normal_pressure_angle_deg"),
    ("b", "face_width_mm"),
    ("beta", "helix_angle_deg"),
    ("da", "tip_diameter_mm"),
    ("df", "root_diameter_mm"),
    ("dm", "ball_diameter_mm"),
    ("jbn", "normal_backlash_um"),
    ("mdk", "dimension_over_balls_mm"),
    ("pz", "lead_mm"),
    ("sn", "normal_tooth_thickness_mm"),
    ("wk", "span_measurement_mm"),
    ("e", "youngs_modulus_gpa"),
    ("m", "normal_module_mm"),
    ("mn", "normal_module_mm"),
    ("nu", "poisson_ratio"),
    ("x", "profile_shift"),
    ("z", "teeth"),
];

/// The name that `given` is probably meant to be.
fn nearest<'a>(given: &str, names: &[&'a str]) -> Option<&'a str> {
    let given = given.to_lowercase().replace("centre", "center");
    let letter = given.replace('_', "");
    if let Some((_, meant)) = LETTERS.iter().find(|(other, _)| *other == letter)
        && let Some(name) = names.iter().find(|name| *name == meant)
    {
        return Some(name);
    }
    // Slips of the hand, and names of which a part is missing.
    let alike = |a: &[&str], b: &[&str]| {
        let (a, b) = (a.concat(), b.concat());
        let slip = strsim::normalized_damerau_levenshtein(&a, &b);
        slip.max(strsim::sorensen_dice(&a, &b))
    };
    let words: Vec<&str> = given.split('_').collect();
    let likeness = |name: &str| {
        let other: Vec<&str> = name.split('_').collect();
        let shared = words.iter().rev().zip(other.iter().rev());
        let shared = shared.take_while(|(a, b)| a == b).count();
        let [a, b] = [&words, &other].map(|all| &all[..all.len() - shared]);
        // A unit in common does not make a name.
        if !a.is_empty() && !b.is_empty() && alike(a, b) < 0.5 {
            return 0.0;
        }
        alike(&words, &other)
    };
    // The first of those that are equally near.
    names
        .iter()
        .rev()
        .map(|name| (likeness(name), *name))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(likeness, _)| *likeness >= 0.6)
        .map(|(_, name)| name)
}

fn listed(names: &[&str]) -> String {
    format!("`{}`", names.join("`, `"))
}

/// What to say of a value of another kind, from the words of the deserialiser.
fn mistyped(given: &str, expected: &str) -> String {
    if let Some(text) = given.strip_prefix("string ")
        && matches!(
            expected,
            "f64" | "u32" | "u8" | "a number, or [lower, upper]"
        )
    {
        let number = text.trim_matches('"');
        let pointed = number.replace(',', ".");
        let shown = shown(text);
        return match (pointed.parse::<f64>(), number.contains(',')) {
            (Err(_), _) => format!(
                "{shown} is text; write a bare number, its unit is that of the field's name"
            ),
            (Ok(_), true) => format!("{} and without quotes: {pointed}", decimal_point(number)),
            (Ok(_), false) => format!("write it without quotes: {pointed}"),
        };
    }
    let expected = match expected {
        "f64" => "a number",
        "u32" => "a whole number, 0 to 4294967295",
        "u8" => "a whole number, 0 to 255",
        "a sequence" => "a list in brackets",
        "newtype variant" => "a value in braces, such as { \"diameter_mm\": 88.0 },",
        "a string" | "string" => "a text in double quotes",
        "a boolean" => "true or false",
        "an array of length 2" => "[lowest, highest]",
        part if part.starts_with("struct") => "fields in braces, { ... }",
        other => other,
    };
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
