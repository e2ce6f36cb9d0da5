//! From the text of a pair file to its fields: JSON, in which comments, commas before a closing bracket and a
//! byte-order mark are allowed, and what is wrong with it in the words of its author.

use std::io::Read;
use std::path::Path;

use serde::de::DeserializeOwned;

use super::error::PairError;
use super::file::{FrictionFile, GearFile, OperatingFile, PairFile, ToothErrorsFile};
use crate::words::shown;

/// Longest pair file or topography, bytes.
const LONGEST: u64 = 4 << 20;

/// The text of the file at `path`, of at most 4 MiB.
pub(super) fn read(path: &Path) -> std::io::Result<String> {
    let file = std::fs::File::open(path)?;
    let mut text = String::new();
    // One byte more than allowed tells a longer file, even where no length is known.
    if file.take(LONGEST + 1).read_to_string(&mut text)? as u64 > LONGEST {
        return Err(std::io::Error::other(format!(
            "it is longer than {} MiB, and a pair file has a few thousand bytes",
            LONGEST >> 20
        )));
    }
    Ok(text)
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
        "key must be a string" => {
            "the name of a field in double quotes is expected here".to_owned()
        }
        "expected value" => "no value that JSON knows stands here; give a number such as 4.0, text in double \
                             quotes, true or false"
            .into(),
        "invalid number" => "this is no number; write 4.0 or 0.5, without leading zeros".into(),
        "number out of range" => "the number is out of range".into(),
        "EOF while parsing a string"
        | "control character (\\u0000-\\u001F) found while parsing a string" => {
            "a text is not closed by a double quote on its line".into()
        }
        "EOF while parsing a value" if path == "." => {
            "there are no fields; `gearmesh new` writes a file to start from".into()
        }
        _ if told.starts_with("EOF") => {
            "the file ends before its last bracket is closed; it may have been cut".into()
        }
        "trailing characters" if path != "." => {
            "there are more than two numbers; [lowest, highest] are expected, with a decimal point in each, \
             such as [-0.5, 0.5]"
                .into()
        }
        "trailing characters" => "something stands after the closing bracket".into(),
        other => other.to_owned(),
    };
    (path.to_owned(), message)
}

/// The field and the number where the text around `column` of `line` is a number with a decimal comma.
fn decimal_comma(text: &str, line: usize, column: usize) -> Option<(String, String)> {
    let line = text.lines().nth(line.checked_sub(1)?)?;
    let digits = |c: char| c.is_ascii_digit();
    let before = line.get(..column.checked_sub(1)?)?;
    let fraction: String = line[before.len()..]
        .chars()
        .take_while(|&c| digits(c))
        .collect();
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
    let parent = path.rsplit_once('.').map_or("", |(parent, _)| parent);
    let names: Vec<&str> = told.split('`').skip(1).step_by(2).collect();
    if told.starts_with("unknown field") {
        let [given, expected @ ..] = &names[..] else {
            return (path.to_owned(), told.to_owned());
        };
        return (path.to_owned(), unknown_field(parent, given, expected));
    }
    if told.starts_with("unknown variant") {
        let [given, expected @ ..] = &names[..] else {
            return (path.to_owned(), told.to_owned());
        };
        let message = match nearest(given, expected) {
            Some(name) => format!("\"{given}\" is none of its values; did you mean \"{name}\"?"),
            None => format!("\"{}\" is none of its values", shown(given)),
        };
        return (
            path.to_owned(),
            format!("{message} There are {}", listed(expected)),
        );
    }
    if let (Some(name), true) = (names.first(), told.starts_with("missing field")) {
        let field = match path {
            "." => (*name).to_owned(),
            _ => format!("{path}.{name}"),
        };
        return (field, "this field is required and missing".into());
    }
    if told.starts_with("duplicate field") {
        return (
            path.to_owned(),
            "this field stands twice; leave one of them out".into(),
        );
    }
    let message = match told.split_once(", expected ") {
        Some((given, "an array of length 2")) if given.starts_with("invalid length") => {
            "two numbers are expected, [lowest, highest]".to_owned()
        }
        Some((given, expected)) => {
            let given = given.split_once(": ").map_or(given, |(_, given)| given);
            mistyped(given, expected)
        }
        None => told.to_owned(),
    };
    (path.to_owned(), message)
}

/// What to say of a field that a part of the file does not have.
fn unknown_field(parent: &str, given: &str, expected: &[&str]) -> String {
    let name_given = shown(given);
    if let Some(name) = nearest(given, expected) {
        return format!("there is no field `{name_given}`; did you mean `{name}`?");
    }
    // A field of another part of the file.
    let parts = [
        (
            "the whole pair, outside of the gears",
            "",
            names::<PairFile>(),
        ),
        ("`gear1` and `gear2`", "gear", names::<GearFile>()),
        ("`tooth_errors`", "gear", names::<ToothErrorsFile>()),
        ("`operating`", "operating", names::<OperatingFile>()),
        ("`friction`", "friction", names::<FrictionFile>()),
    ];
    for (part, prefix, fields) in parts {
        let here = match prefix {
            "" => parent.is_empty(),
            _ => parent.starts_with(prefix),
        };
        let fields: Vec<&str> = fields.iter().map(String::as_str).collect();
        if !here && let Some(name) = nearest(given, &fields) {
            return format!("there is no field `{name_given}` here; `{name}` is a field of {part}");
        }
    }
    format!(
        "there is no field `{name_given}`; there are {}",
        listed(expected)
    )
}

/// Names of the fields of a part of the file, as its deserialiser lists them when it refuses one.
fn names<T: DeserializeOwned>() -> Vec<String> {
    // Read as `parse` does, so that the deserialisers are compiled once.
    let mut json = serde_json::Deserializer::from_slice(br#"{"": 0}"#);
    match serde_path_to_error::deserialize::<_, T>(&mut json) {
        Ok(_) => Vec::new(),
        Err(error) => error
            .inner()
            .to_string()
            .split('`')
            .skip(3)
            .step_by(2)
            .map(str::to_owned)
            .collect(),
    }
}

/// The letters of drawings and standards.
const LETTERS: &[(&str, &str)] = &[
    ("a", "center_distance_mm"),
    ("alpha", "normal_pressure_angle_deg"),
    ("b", "face_width_mm"),
    ("beta", "helix_angle_deg"),
    ("da", "tip_diameter_mm"),
    ("e", "youngs_modulus_gpa"),
    ("m", "normal_module_mm"),
    ("mn", "normal_module_mm"),
    ("nu", "poisson_ratio"),
    ("x", "profile_shift"),
    ("z", "teeth"),
];

/// The name that `given` is probably meant to be.
fn nearest<'a>(given: &str, names: &[&'a str]) -> Option<&'a str> {
    let plain = |name: &str| {
        name.to_lowercase()
            .replace("centre", "center")
            .replace('_', "")
    };
    let given = plain(given);
    if let Some((_, meant)) = LETTERS.iter().find(|(letter, _)| *letter == given)
        && let Some(name) = names.iter().find(|name| *name == meant)
    {
        return Some(name);
    }
    // Slips of the hand, and names of which a part is missing.
    let likeness = |name: &str| {
        let name = plain(name);
        let slip = strsim::normalized_damerau_levenshtein(&given, &name);
        slip.max(strsim::sorensen_dice(&given, &name))
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
    names
        .iter()
        .map(|name| format!("`{name}`"))
        .collect::<Vec<_>>()
        .join(", ")
}

/// What to say of a value of another kind, from the words of the deserialiser.
fn mistyped(given: &str, expected: &str) -> String {
    let is_number = matches!(expected, "f64" | "u32");
    if let Some(text) = given.strip_prefix("string ")
        && is_number
    {
        let number = text.trim_matches('"');
        return if number.replace(',', ".").parse::<f64>().is_ok() {
            let note = if number.contains(',') {
                decimal_point(number) + " and"
            } else {
                "write it".into()
            };
            format!("{note} without quotes: {}", number.replace(',', "."))
        } else {
            format!(
                "{} is text; write a bare number, its unit is that of the field's name",
                shown(text)
            )
        };
    }
    let expected = match expected {
        "f64" => "a number",
        "u32" if is_above(given, u32::MAX.into()) => "a whole number, at most 4294967295",
        "u32" => "a whole number, at least 0",
        "a string" | "string" => "a text in double quotes",
        "a boolean" => "true or false",
        "an array of length 2" => "[lowest, highest]",
        part if part.starts_with("struct") => "fields in braces, { ... }",
        other => other,
    };
    format!("{}; {expected} is expected", kind(given))
}

/// Whether the deserialiser's words `given` hold a number above `most`.
fn is_above(given: &str, most: f64) -> bool {
    let number = given.split('`').nth(1);
    number.is_some_and(|number| number.parse().is_ok_and(|number: f64| number > most))
}

/// The deserialiser's words for a value.
fn kind(given: &str) -> String {
    match given {
        "map" => "fields in braces".into(),
        "sequence" => "a list in brackets".into(),
        "null" | "unit value" => "null is no value".into(),
        other => shown(
            other
                .trim_start_matches("floating point ")
                .trim_start_matches("integer ")
                .trim_start_matches("boolean "),
        ),
    }
}
