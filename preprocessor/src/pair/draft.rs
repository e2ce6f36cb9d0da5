//! A pair file whose numbers are changed one by one, for studies of tolerances.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::error::{PairError, refusal};
use super::{Pair, resolve, text};

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
    /// Those of [`super::read`], but for what makes a pair that cannot work.
    pub fn read(path: &Path) -> Result<PairDraft, PairError> {
        let fields = serde_json::to_value(text::read_fields(path)?);
        Ok(PairDraft {
            // Numbers, text and lists under names: they are values of JSON.
            fields: fields.expect("a pair file serialises"),
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
        })
    }

    /// The number at `field`, such as `gear1.tip_relief.amount_um`; the middle of limits; None where there is none.
    pub fn number(&self, field: &str) -> Option<f64> {
        let path = format!("/{}", field.replace('.', "/"));
        let value = self.fields.pointer(&path)?;
        let limit = |i: usize| value.get(i)?.as_f64();
        // Of limits the middle counts.
        value
            .as_f64()
            .or_else(|| Some(0.5 * (limit(0)? + limit(1)?)))
    }

    /// Sets `field` to `value`, in the unit of its name; groups of fields on the way to it are made.
    ///
    /// # Errors
    /// [`PairError::Refused`] where something else than a group of fields stands on the way.
    pub fn set(&mut self, field: &str, value: f64) -> Result<(), PairError> {
        let mut at = &mut self.fields;
        let names: Vec<&str> = field.split('.').collect();
        for (i, name) in names.iter().enumerate() {
            if at.is_null() {
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
    /// Those of [`super::from_json`].
    pub fn pair(&self) -> Result<Pair, PairError> {
        let file = text::parse(&self.fields.to_string())?;
        Ok(resolve::resolve(&file, &self.folder)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pair;

    fn paper() -> PairDraft {
        let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
        PairDraft::read(&root.join("resources/pairs/palermo2013.json")).unwrap()
    }

    #[test]
    fn an_unchanged_draft_is_the_pair() {
        let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
        let pair = pair::read(root.join("resources/pairs/palermo2013.json")).unwrap();
        assert_eq!(paper().pair().unwrap(), pair);
    }

    #[test]
    fn fields_are_changed_by_their_path_and_made_where_they_are_missing() {
        let mut draft = paper();
        assert_eq!(draft.number("gear1.tip_relief.amount_um"), Some(7.0));
        assert_eq!(draft.number("gear1.lead_slope_um"), None);
        draft.set("gear1.tip_relief.amount_um", 9.0).unwrap();
        draft.set("gear1.lead_slope_um", -3.0).unwrap();
        draft
            .set("gear2.drive_flank.profile_slope_um", 2.0)
            .unwrap();
        let drive = &draft.pair().unwrap().microgeometry.drive;
        assert_eq!(drive[0].tip_relief.unwrap().amount, 9e-6);
        assert_eq!(drive[0].lead_slope, -3e-6);
        assert_eq!(drive[1].profile_slope.unwrap().amount, 2e-6);
    }

    #[test]
    fn a_draft_is_written_as_the_pair_file_that_it_is() {
        let mut draft = paper();
        draft.rename("other");
        draft.set("gear2.tip_relief.amount_um", 9.0).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pair.json");
        std::fs::write(&path, draft.to_json()).unwrap();
        let pair = pair::read(&path).unwrap();
        assert_eq!(pair, draft.pair().unwrap());
        assert_eq!(pair.name, "other");
    }

    #[test]
    fn a_name_that_is_no_field_is_refused() {
        let mut draft = paper();
        draft.set("gear1.lead_slop_um", 1.0).unwrap();
        let error = draft.pair().unwrap_err().to_string();
        assert!(error.contains("lead_slop_um"), "{error}");
        let error = draft.set("name.length", 1.0).unwrap_err().to_string();
        assert!(error.contains("`name`"), "{error}");
    }
}
