//! The pair file: from a drawing in JSON to a checked gear pair in SI.
//!
//! [`from_json`] knows every field (docs/pair-file.md), fills in the defaults and refuses what cannot work, naming field,
//! value and remedy ([`Refusal`]). What is legal but worth knowing comes as [`Pair::warnings`].

mod backlash;
mod checks;
pub mod drawing;
mod error;
mod file;
mod flanks;
mod gears;
mod mesh;
mod resolve;
mod teeth;
mod text;

use std::path::{Path, PathBuf};

pub use checks::TORQUES;
pub use drawing::Gauges;
pub use error::{PairError, Refusal};
pub use resolve::note_on_teeth;

use error::refusal;
use gearmesh::pair::Pair;
use serde_json::Value;

/// Reads and checks the text of a pair file: JSON in which comments (`//`, `/* */`, `#`), commas before a
/// closing bracket and a byte-order mark are allowed. Files it names are sought in the working folder.
///
/// # Errors
/// [`PairError::Form`] for text of another form (unknown, missing or mistyped field),
/// [`PairError::Refused`] for a pair that cannot work.
pub fn from_json(text: &str) -> Result<Pair, PairError> {
    let file = text::parse(text)?;
    Ok(resolve::resolve(&file, Path::new(""))?)
}

/// Reads and checks the pair file at `path`. Files it names are sought in its folder.
///
/// # Errors
/// [`PairError::Read`] when the file cannot be read, else as [`from_json`].
pub fn read(path: impl AsRef<Path>) -> Result<Pair, PairError> {
    Ok(read_with_gauges(path)?.0)
}

/// The pair as [`read`] gives it, and with what the tooth thickness of each gear is measured: what the file names, else what
/// is usual.
///
/// # Errors
/// Those of [`read`].
pub fn read_with_gauges(path: impl AsRef<Path>) -> Result<(Pair, [Gauges; 2]), PairError> {
    let path = path.as_ref();
    let file = text::read_fields(path)?;
    let pair = resolve::resolve(&file, folder(path))?;
    let gauges = [0, 1].map(|i| Gauges::of(file.gear(i), &pair.geometry.gears[i]));
    Ok((pair, gauges))
}

fn folder(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// The fields of a pair file before they are checked.
#[derive(Debug, Clone)]
pub struct PairDraft {
    fields: Value,
    folder: PathBuf,
}

impl PairDraft {
    /// Reads the pair file at `path`.
    ///
    /// # Errors
    /// Those of [`read`], but for what makes a pair that cannot work.
    pub fn read(path: &Path) -> Result<PairDraft, PairError> {
        let fields = serde_json::to_value(text::read_fields(path)?);
        Ok(PairDraft {
            // Numbers, text and lists under names: they are values of JSON.
            fields: fields.expect("a pair file serialises"),
            folder: folder(path).to_owned(),
        })
    }

    /// The number at `field`, such as `gear1.tip_relief.amount_um`; the middle of limits; None where there is none.
    pub fn number(&self, field: &str) -> Option<f64> {
        let path = format!("/{}", field.replace('.', "/"));
        let value = self.fields.pointer(&path)?;
        let limit = |i: usize| value.get(i)?.as_f64();
        (value.as_f64()).or_else(|| Some(0.5 * (limit(0)? + limit(1)?)))
    }

    /// Sets `field` to `value`, in the unit of its name; groups of fields on the way to it are made.
    ///
    /// # Errors
    /// [`PairError::Refused`] where something else than a group of fields stands on the way.
    pub fn set(&mut self, field: &str, value: f64) -> Result<(), PairError> {
        let mut at = &mut self.fields;
        let names: Vec<&str> = field.split('.').collect();
        for (i, name) in names.iter().enumerate() {
            // One form of a relief's start takes the place of another.
            if at.is_null() || i > 0 && names[i - 1] == "start" {
                *at = Value::Object(serde_json::Map::new());
            }
            let Some(fields) = at.as_object_mut() else {
                let group = names[..i].join(".");
                return Err(refusal!(group => "no group of fields";
                    "there is no `{name}` in it"; "docs/pair-file.md has every field")
                .into());
            };
            at = fields.entry(*name).or_insert(Value::Null);
        }
        *at = value.into();
        Ok(())
    }

    /// Gives the pair another name.
    pub fn rename(&mut self, name: &str) {
        self.fields["name"] = name.into();
    }

    /// The text of a pair file with these fields, for any folder: files that it names stand with their whole path.
    pub fn to_json(&self) -> String {
        fn kept(value: &Value, folder: &Path) -> Value {
            let field = |(name, value): (&String, &Value)| match value {
                Value::Null => None,
                Value::String(file) if name.ends_with("_file") => {
                    let path = std::path::absolute(folder.join(file)).unwrap_or(file.into());
                    Some((name.clone(), path.to_string_lossy().into()))
                }
                value => Some((name.clone(), kept(value, folder))),
            };
            match value {
                Value::Object(fields) => Value::Object(fields.iter().filter_map(field).collect()),
                Value::Array(values) => values.iter().map(|value| kept(value, folder)).collect(),
                value => value.clone(),
            }
        }
        format!("{:#}\n", kept(&self.fields, &self.folder))
    }

    /// The checked pair.
    ///
    /// # Errors
    /// Those of [`from_json`].
    pub fn pair(&self) -> Result<Pair, PairError> {
        let file = text::parse(&self.fields.to_string())?;
        Ok(resolve::resolve(&file, &self.folder)?)
    }
}

#[cfg(test)]
mod tests;
