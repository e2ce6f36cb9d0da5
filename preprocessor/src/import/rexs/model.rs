//! The form of REXS files: components with attributes, and the relations between them, in XML, JSON or a zip archive of one.

use std::cell::Cell;
use std::collections::{HashMap, HashSet};
use std::io::{Cursor, Read};
use std::path::Path;

use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use base64::{Engine, alphabet};
use serde::{Deserialize, Deserializer};
use serde_json::Value;

use crate::pair::PairError;
use crate::storage;

/// What is wrong with a REXS file.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct RexsError(pub(super) String);

impl From<PairError> for RexsError {
    fn from(error: PairError) -> RexsError {
        RexsError(error.to_string())
    }
}

pub(super) type Result<T, E = RexsError> = std::result::Result<T, E>;

pub(super) fn refused<T>(problem: impl Into<String>) -> Result<T> {
    Err(RexsError(problem.into()))
}

/// Longest model, bytes: gearboxes of thousands of parts have a few million.
const LONGEST: u64 = 256 << 20;

/// Attributes of one XML element, at most: those of REXS have a handful, and the parser compares each with all.
const MOST_XML_ATTRIBUTES: usize = 1000;

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Attribute {
    pub id: String,
    pub unit: String,
    #[serde(alias = "floating_point", alias = "integer", alias = "enum")]
    #[serde(alias = "string", alias = "boolean", alias = "floating_point_array")]
    #[serde(alias = "floating_point_array_coded", alias = "integer_array_coded")]
    #[serde(deserialize_with = "plain")]
    pub value: Value,
    /// Whether the pair file has it.
    #[serde(skip)]
    pub is_taken: Cell<bool>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Component {
    #[serde(deserialize_with = "word")]
    pub id: String,
    #[serde(rename = "type")]
    pub kind: String,
    #[serde(deserialize_with = "word")]
    pub name: String,
    pub attributes: Vec<Attribute>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Ref {
    role: String,
    #[serde(deserialize_with = "word")]
    id: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Relation {
    #[serde(rename = "type")]
    pub kind: String,
    refs: Vec<Ref>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Model {
    pub version: String,
    pub components: Vec<Component>,
    pub relations: Vec<Relation>,
    /// Of all load spectra: components again, with their loads and results.
    #[serde(skip)]
    pub load_cases: Vec<LoadCase>,
    /// Why there are none, where the spectra have another form.
    #[serde(skip)]
    pub unread_spectrum: Option<String>,
    /// Places of the components by id.
    #[serde(skip)]
    places: HashMap<String, usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct LoadCase {
    #[serde(deserialize_with = "word")]
    pub id: String,
    pub components: Vec<Component>,
}

/// Those of one load spectrum or of several.
fn load_cases(spectra: Value) -> Result<Vec<LoadCase>, serde_json::Error> {
    #[derive(Default, Deserialize)]
    #[serde(default)]
    struct Spectrum {
        load_cases: Vec<LoadCase>,
    }
    let spectra = match spectra {
        Value::Array(spectra) => spectra,
        Value::Null => Vec::new(),
        one => vec![one],
    };
    let spectra: Result<Vec<Spectrum>, _> =
        spectra.into_iter().map(serde_json::from_value).collect();
    Ok(spectra?.into_iter().flat_map(|s| s.load_cases).collect())
}

/// Ids are numbers or text.
fn word<'de, D: Deserializer<'de>>(from: D) -> Result<String, D::Error> {
    Ok(match Value::deserialize(from)? {
        Value::String(word) => word,
        Value::Null => String::new(),
        other => other.to_string(),
    })
}

/// A value, arrays in Base64 (`{"code": .., "value": ..}`) decoded.
fn plain<'de, D: Deserializer<'de>>(from: D) -> Result<Value, D::Error> {
    let value = Value::deserialize(from)?;
    let decoded = match (&value["code"], &value["value"]) {
        (Value::String(code), Value::String(text)) => decoded(code, text),
        _ => None,
    };
    Ok(decoded.unwrap_or(value))
}

/// With padding or without: programs write both.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The numbers that `text` holds in Base64, `code` their type in the order of little-endian bytes; None of what is none.
fn decoded(code: &str, text: &str) -> Option<Value> {
    let text: String = text.split_ascii_whitespace().collect();
    let bytes = BASE64.decode(text).ok()?;
    let numbers: Vec<f64> = match code {
        "float64" => of_bytes(&bytes, f64::from_le_bytes)?,
        "float32" => of_bytes(&bytes, |word| f64::from(f32::from_le_bytes(word)))?,
        "int32" => of_bytes(&bytes, |word| f64::from(i32::from_le_bytes(word)))?,
        _ => return None,
    };
    Some(numbers.into())
}

/// What `number` makes of each `N` bytes; None where some are left.
fn of_bytes<const N: usize>(bytes: &[u8], number: impl Fn([u8; N]) -> f64) -> Option<Vec<f64>> {
    let words = bytes.chunks(N).map(|word| word.try_into().ok());
    words.map(|word| word.map(&number)).collect()
}

/// How programs write that an attribute has no value.
const NOT_SET: &str = "not-set";

impl Attribute {
    /// The value as it stands in the file.
    pub fn shown(&self) -> String {
        match &self.value {
            Value::String(text) => text.clone(),
            other => other.to_string(),
        }
    }

    pub fn is_empty(&self) -> bool {
        self.value.is_null() || self.value == "" || self.value == NOT_SET
    }
}

impl Component {
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        let mut all = self.attributes.iter();
        all.find(|a| a.id == name && !a.is_empty())
    }
}

impl Relation {
    pub fn role(&self, role: &str) -> Option<&str> {
        let found = self.refs.iter().find(|r| r.role == role)?;
        Some(&found.id)
    }

    pub fn names(&self, id: &str) -> bool {
        self.refs.iter().any(|r| r.id == id)
    }
}

impl Model {
    /// The model in the file at `path`.
    pub fn read(path: &Path) -> Result<Model> {
        let mut bytes = Vec::new();
        let file = storage::open(path);
        let read = file.and_then(|file| file.take(LONGEST + 1).read_to_end(&mut bytes));
        match read {
            Ok(_) => Model::from_bytes(bytes),
            Err(error) => refused(format!("cannot read it: {error}")),
        }
    }

    /// The model in the `bytes` of a file: XML, JSON or a zip archive with one of them.
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Model> {
        let bytes = match bytes.starts_with(b"PK") {
            true => unzipped(bytes)?,
            false => bytes,
        };
        if bytes.len() as u64 > LONGEST {
            return refused(format!("longer than {} MB", LONGEST >> 20));
        }
        let text = String::from_utf8(bytes);
        let text = text.or_else(|_| refused("no text in UTF-8"))?;
        let text = text.trim_start_matches('\u{feff}').trim_start();
        let mut model = match text.starts_with('{') {
            true => Model::from_json(text)?,
            false => Model::from_xml(text)?,
        };
        let ids = model.components.iter().enumerate();
        // The first of those that have one id.
        model.places = ids.rev().map(|(i, c)| (c.id.clone(), i)).collect();
        Ok(model)
    }

    fn from_json(text: &str) -> Result<Model> {
        let mut file: Value = serde_json::from_str(text).map_err(no_rexs)?;
        let Some(fields) = file["model"].as_object_mut() else {
            return refused("it has no `model`, as REXS files in JSON have");
        };
        let spectra = fields.remove("load_spectrum").unwrap_or_default();
        let mut model: Model = serde_json::from_value(file["model"].take()).map_err(no_rexs)?;
        // Geometry does not need them.
        match load_cases(spectra) {
            Ok(cases) => model.load_cases = cases,
            Err(error) => model.unread_spectrum = Some(error.to_string()),
        }
        Ok(model)
    }

    fn from_xml(text: &str) -> Result<Model> {
        for tag in text
            .split('<')
            .filter(|tag| !tag.starts_with(['!', '?', '/']))
        {
            if tag.len() > MOST_XML_ATTRIBUTES && tag.matches('=').count() > MOST_XML_ATTRIBUTES {
                let name: String = tag.chars().take_while(|c| c.is_alphanumeric()).collect();
                return refused(format!(
                    "the element <{name}> has more than {MOST_XML_ATTRIBUTES} XML attributes, and those of REXS have a few"
                ));
            }
        }
        let remedy = "give the .rexs (XML), .rexsj (JSON) or .rexsz (zip) file";
        let document = roxmltree::Document::parse(text)
            .or_else(|error| refused(format!("no REXS file: {error}; {remedy}")))?;
        let root = document.root_element();
        let tag = root.tag_name().name();
        if tag != "model" {
            return refused(format!(
                "its root is <{tag}>, that of a REXS file is <model>"
            ));
        }
        // Load spectra and accumulations list components again, with loads and results.
        let parts = |list: &'static str, part: &'static str| {
            let lists = root.children().filter(move |c| c.has_tag_name(list));
            lists.flat_map(move |l| l.children().filter(move |c| c.has_tag_name(part)))
        };
        Ok(Model {
            version: given(root, "version"),
            components: parts("components", "component").map(component).collect(),
            relations: parts("relations", "relation").map(relation).collect(),
            load_cases: parts("load_spectrum", "load_case").map(load_case).collect(),
            ..Model::default()
        })
    }

    pub fn component(&self, id: &str) -> Option<&Component> {
        self.components.get(*self.places.get(id)?)
    }

    /// Components that stand in a relation with `id`, of a kind of which `is_kind` holds.
    pub fn related(&self, id: &str, is_kind: impl Fn(&str) -> bool) -> Vec<&Component> {
        let relations = self.relations.iter().filter(|r| r.names(id));
        let others = relations.flat_map(|r| &r.refs).filter(|r| r.id != id);
        let mut seen = HashSet::new();
        others
            .filter(|r| seen.insert(&r.id))
            .filter_map(|r| self.component(&r.id))
            .filter(|c| is_kind(&c.kind))
            .collect()
    }
}

fn given(node: roxmltree::Node, name: &str) -> String {
    node.attribute(name).unwrap_or_default().to_owned()
}

fn text(node: roxmltree::Node) -> String {
    node.text().unwrap_or_default().trim().to_owned()
}

fn component(node: roxmltree::Node) -> Component {
    let attributes = node.children().filter(|c| c.has_tag_name("attribute"));
    Component {
        id: given(node, "id"),
        kind: given(node, "type"),
        name: given(node, "name"),
        attributes: attributes.map(attribute).collect(),
    }
}

fn load_case(node: roxmltree::Node) -> LoadCase {
    let components = node.children().filter(|c| c.has_tag_name("component"));
    LoadCase {
        id: given(node, "id"),
        components: components.map(component).collect(),
    }
}

/// One value as text, or the numbers of an array.
fn attribute(node: roxmltree::Node) -> Attribute {
    let array = node.children().find(|c| c.has_tag_name("array"));
    Attribute {
        id: given(node, "id"),
        unit: given(node, "unit"),
        value: match array {
            Some(array) if array.has_attribute("code") => {
                let text = text(array);
                decoded(&given(array, "code"), &text).unwrap_or_else(|| text.into())
            }
            Some(array) => {
                let cells = array.children().filter(roxmltree::Node::is_element);
                Value::Array(cells.map(|cell| text(cell).into()).collect())
            }
            None => text(node).into(),
        },
        is_taken: Cell::new(false),
    }
}

fn relation(node: roxmltree::Node) -> Relation {
    let refs = node.children().filter(|c| c.has_tag_name("ref"));
    Relation {
        kind: given(node, "type"),
        refs: refs
            .map(|r| Ref {
                role: given(r, "role"),
                id: given(r, "id"),
            })
            .collect(),
    }
}

fn is_model(name: &str) -> bool {
    let extension = Path::new(name).extension().map(|e| e.to_ascii_lowercase());
    extension.is_some_and(|e| {
        ["rexs", "rexsj", "xml", "json"]
            .iter()
            .any(|known| e == *known)
    })
}

fn no_rexs(error: serde_json::Error) -> RexsError {
    RexsError(format!("no REXS file: {error}"))
}

fn damaged(error: zip::result::ZipError) -> RexsError {
    RexsError(format!("a damaged archive: {error}"))
}

/// The one model in a zip archive (.rexsz).
fn unzipped(bytes: Vec<u8>) -> Result<Vec<u8>> {
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(damaged)?;
    let models = archive.file_names().filter(|name| is_model(name));
    let models: Vec<String> = models.map(str::to_owned).collect();
    let [name] = &models[..] else {
        return refused(format!(
            "an archive with {} models ({}), and one is expected: a .rexs or .rexsj file",
            models.len(),
            models.join(", ")
        ));
    };
    let mut model = Vec::new();
    let file = archive.by_name(name).map_err(damaged)?;
    match file.take(LONGEST + 1).read_to_end(&mut model) {
        Ok(_) => Ok(model),
        Err(error) => refused(format!("a damaged archive: {name}: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn arrays_in_base64_are_read_from_xml_with_and_without_padding() {
        // 2.5 and -1 as little-endian floats; 7 and -2 as integers.
        let cases = [
            ("float32", "AAAgQAAAgL8=", json!([2.5, -1.0])),
            ("float32", "AAAgQAAAgL8", json!([2.5, -1.0])),
            ("float32", " AAAgQAAA\n gL8= ", json!([2.5, -1.0])),
            ("int32", "BwAAAP7///8=", json!([7.0, -2.0])),
            ("float16", "AAAgQAAAgL8=", json!("AAAgQAAAgL8=")),
            ("float32", "AAAgQAAA", json!("AAAgQAAA")),
        ];
        for (code, text, expected) in cases {
            let xml = format!(
                r#"<model><components><component id="1" type="part"><attribute id="a" unit="mm"><array code="{code}">{text}</array></attribute></component></components></model>"#
            );
            let model = Model::from_bytes(xml.into_bytes()).unwrap();
            let value = &model.component("1").unwrap().attributes[0].value;
            assert_eq!(*value, expected);
        }
    }
}
