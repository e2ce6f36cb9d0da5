//! From the text of a pair file to its fields: JSON, in which comments, commas before a closing bracket and a
//! byte-order mark are allowed, and what is wrong with it in the words of its author.

use std::io::Read;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;

use super::checks::Refusals;
use super::file::{FrictionFile, GearFile, OperatingFile, PairFile, ToothErrorsFile};
use gearmesh::words::shown;

/// A pair file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PairError {
    /// The file cannot be read.
    #[error(
        "cannot read the pair file {}: {source}; name a pair file that exists and that you may read",
        path.display()
    )]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// Not JSON, or JSON of another form: unknown or missing field, wrong type.
    #[error("pair file, at `{field}`: {message}; docs/pair-file.md has every field and its form")]
    Form {
        /// Path of the field, such as `gear1.tip_relief.shape`; `.` is the whole file.
        field: String,
        /// What is wrong, the names expected, line and column.
        message: String,
    },
    /// Well-formed, but no gear pair that works.
    #[error(transparent)]
    Refused(#[from] Refusals),
}

/// Longest pair file or topography, bytes.
const LONGEST: u64 = 4 << 20;

/// The text of the file at `path`, of at most 4 MiB.
pub(super) fn read(path: &Path) -> std::io::Result<String> {
    let mut bytes = Vec::new();
    // One byte more than allowed shows a longer file, even where no length is known.
    let mut file = crate::storage::open(path)?.take(LONGEST + 1);
    let is_long = file.read_to_end(&mut bytes)? as u64 > LONGEST;
    let problem = match String::from_utf8(bytes) {
        Err(error) if error.as_bytes().starts_with(b"PK") => {
            "an archive, such as an FMU, and no text"
        }
        _ if is_long => "longer than 4 MiB, and a pair file has a few thousand bytes",
        Err(_) => "no text in UTF-8",
        Ok(text) => return Ok(text),
    };
    Err(std::io::Error::other(format!("it is {problem}")))
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
    let text = &with_line_feeds(text.trim_start_matches('\u{feff}'));
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

/// `text` with a line feed in place of each carriage return that ends a line alone, as old editors write them: a comment
/// ends there.
fn with_line_feeds(text: &str) -> String {
    let windows = text.replace("\r\n", " \n");
    windows.replace('\r', "\n")
}

/// The error in plain words, with the path of its field and the text about its place.
fn form(text: &str, path: &str, error: &serde_json::Error) -> PairError {
    let (line, column) = (error.line(), error.column());
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
        _ => match said.split_once(", expected ") {
            Some((given, expected)) => mistyped(given, expected),
            None => in_plain_words(said, &field).to_owned(),
        },
    };
    let about: String = (text.lines().nth(line.saturating_sub(1)).unwrap_or_default())
        .chars()
        .skip(column.saturating_sub(50))
        .take(70)
        .collect();
    let about = shown(about.trim());
    let place = format!(" (line {line}, column {column}: {about})");
    PairError::Form {
        field: shown(&field),
        message: if line == 0 { message } else { message + &place },
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
        "trailing characters" if field == "." => "something stands after the closing bracket",
        "trailing characters" => {
            "there are more than two numbers; [lowest, highest] are expected, with a decimal point in each, such as \
             [-0.5, 0.5]"
        }
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
        _ if said.starts_with("duplicate field") => {
            "this field stands twice; leave one of them out"
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
    let is_current = |name: &&&str| name.starts_with(char::is_lowercase);
    let known: Vec<&str> = known.iter().filter(is_current).copied().collect();
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
    // Slips of the hand, and names of which a part is missing.
    let alike = |a: &str, b: &str| {
        strsim::normalized_damerau_levenshtein(a, b).max(strsim::sorensen_dice(a, b))
    };
    let likeness = |name: &str| {
        // Words in common at the end, such as the unit, do not make a name.
        let shared = given.rsplit('_').zip(name.rsplit('_'));
        let shared: usize = (shared.take_while(|(a, b)| a == b))
            .map(|(word, _)| word.len() + 1)
            .sum();
        let [a, b] = [&given[..], name].map(|all| &all[..all.len().saturating_sub(shared)]);
        match !a.is_empty() && !b.is_empty() && alike(a, b) < 0.5 {
            true => 0.0,
            false => alike(&given, name),
        }
    };
    // The first of those that are equally near.
    let rated = names.iter().rev().map(|name| (likeness(name), *name));
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
        "an array of length 2" => "[lowest, highest]",
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
