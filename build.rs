//! Generates the FMU's variable table from modelDescription.xml, its one source, so that the
//! library and the file that hosts read cannot drift. What the public checkers of FMUs miss is
//! refused here, at compile time.

#[path = "build/checks.rs"]
mod checks;
#[path = "build/emit.rs"]
mod emit;

use std::collections::{HashMap, HashSet};
use std::error::Error;
use std::path::Path;
use std::{env, fs};

use roxmltree::{Document, Node};

const SOURCE: &str = "modelDescription.xml";

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Enumeration types in their order: name and items.
type Enumerations = Vec<(String, Vec<String>)>;

fn main() {
    println!("cargo::rerun-if-changed={SOURCE}");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=build");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("linux") {
        // Line tables serve the command and the tests; in every FMU they would weigh twenty times the code.
        println!("cargo::rustc-cdylib-link-arg=-Wl,--strip-debug");
        // What dependencies export for themselves is none of the unit's interface. zig, which links for old
        // systems, has no --exclude-libs; there the last version script counts.
        let linker = env::var("RUSTC_LINKER").unwrap_or_default();
        let rest = if linker.contains("zigcc") {
            let folder = env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
            format!("--version-script={folder}/build/exports.map")
        } else {
            "--exclude-libs,ALL".to_owned()
        };
        println!("cargo::rustc-cdylib-link-arg=-Wl,{rest}");
    }
    if let Err(error) = generate() {
        println!("cargo::error={SOURCE}: {error}");
        std::process::exit(1);
    }
}

fn generate() -> Result<()> {
    let text = fs::read_to_string(SOURCE)?;
    let document = Document::parse(&text)?;
    let root = document.root_element();
    let version = env::var("CARGO_PKG_VERSION")?;
    if root.attribute("version") != Some(version.as_str()) {
        return Err(format!("version is not that of Cargo.toml, {version}").into());
    }
    let units = units(root)?;
    let enumerations = enumerations(root)?;
    let variables = variables(root, &units, &enumerations)?;
    checks::check_blocks(&variables)?;
    checks::check_structure(root, &variables)?;
    checks::check_capabilities(root)?;
    let code = emit::emit(root, &variables, &enumerations)?;
    let out = env::var("OUT_DIR")?;
    fs::write(Path::new(&out).join("model_description.rs"), code)?;
    Ok(())
}

/// One ScalarVariable with its checked attributes.
struct Variable {
    name: String,
    reference: u32,
    kind: String,
    causality: String,
    variability: String,
    start: Option<f64>,
    start_range: Option<(usize, usize)>,
    min: Option<f64>,
    max: Option<f64>,
    nominal: f64,
    unit: String,
    enumeration: Option<String>,
    description: String,
}

fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Result<Node<'a, 'i>> {
    node.children()
        .find(|n| n.has_tag_name(name))
        .ok_or_else(|| format!("<{}> has no <{name}>", node.tag_name().name()).into())
}

fn elements<'a, 'i>(node: Node<'a, 'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(Node::is_element)
}

fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Result<&'a str> {
    node.attribute(name)
        .ok_or_else(|| format!("<{}> has no {name}", node.tag_name().name()).into())
}

/// Unit names, each with its display units.
fn units(root: Node) -> Result<HashMap<String, Vec<String>>> {
    let mut units = HashMap::new();
    for unit in elements(child(root, "UnitDefinitions")?) {
        let name = attribute(unit, "name")?.to_owned();
        let display = elements(unit)
            .filter(|n| n.has_tag_name("DisplayUnit"))
            .map(|n| attribute(n, "name").map(str::to_owned))
            .collect::<Result<_>>()?;
        if units.insert(name.clone(), display).is_some() {
            return Err(format!("unit {name} is defined twice").into());
        }
    }
    Ok(units)
}

/// The enumeration types; items count from 1 without gaps.
fn enumerations(root: Node) -> Result<Enumerations> {
    elements(child(root, "TypeDefinitions")?)
        .map(|simple| {
            let name = attribute(simple, "name")?;
            let items = elements(child(simple, "Enumeration")?)
                .enumerate()
                .map(|(i, item)| {
                    if attribute(item, "value")?.parse::<usize>()? != i + 1 {
                        return Err(format!("items of {name} do not count from 1").into());
                    }
                    Ok(attribute(item, "name")?.to_owned())
                })
                .collect::<Result<_>>()?;
            Ok((name.to_owned(), items))
        })
        .collect()
}

fn variables(
    root: Node,
    units: &HashMap<String, Vec<String>>,
    enumerations: &Enumerations,
) -> Result<Vec<Variable>> {
    let variables = elements(child(root, "ModelVariables")?)
        .map(|node| {
            let name = attribute(node, "name")?;
            variable(node, units, enumerations).map_err(|e| format!("{name}: {e}").into())
        })
        .collect::<Result<Vec<_>>>()?;
    let (mut names, mut references) = (HashSet::new(), HashSet::new());
    for v in &variables {
        if !names.insert(v.name.as_str()) {
            return Err(format!("{}: the name is used twice", v.name).into());
        }
        if !references.insert(v.reference) {
            let reference = v.reference;
            return Err(format!("{}: value reference {reference} is used twice", v.name).into());
        }
    }
    Ok(variables)
}

fn variable(
    node: Node,
    units: &HashMap<String, Vec<String>>,
    enumerations: &Enumerations,
) -> Result<Variable> {
    let typed = elements(node).next().ok_or("has no type")?;
    let kind = typed.tag_name().name();
    let (causality, variability) = (
        attribute(node, "causality")?,
        attribute(node, "variability")?,
    );
    let number = |name: &str| -> Result<Option<f64>> {
        Ok(match typed.attribute(name) {
            None => None,
            Some("false") if kind == "Boolean" => Some(0.0),
            Some("true") if kind == "Boolean" => Some(1.0),
            Some(text) => Some(
                text.parse::<f64>()
                    .map_err(|_| format!("{name} is not a number"))?,
            ),
        })
    };
    let (start, mut min, mut max) = (number("start")?, number("min")?, number("max")?);
    checks::check_role(
        causality,
        variability,
        node.attribute("initial"),
        start.is_some(),
    )?;
    if variability == "continuous" && kind != "Real" {
        return Err("only a Real is continuous".into());
    }
    let unit = typed.attribute("unit").unwrap_or("");
    if kind == "Real" {
        let display = units
            .get(unit)
            .ok_or("its unit is missing or not defined")?;
        if let Some(name) = typed.attribute("displayUnit")
            && !display.iter().any(|d| d == name)
        {
            return Err(format!("display unit {name} is not defined").into());
        }
        if !unit.is_ascii() || !typed.attribute("displayUnit").is_none_or(str::is_ascii) {
            return Err("units are spelled in ASCII: importers read no others".into());
        }
        if number("nominal")?.is_none_or(|n| n <= 0.0) {
            return Err("a Real needs a positive nominal".into());
        }
    }
    let enumeration = typed.attribute("declaredType");
    if kind == "Enumeration" {
        let (_, items) = enumerations
            .iter()
            .find(|(name, _)| Some(name.as_str()) == enumeration)
            .ok_or("its enumeration is not defined")?;
        (min, max) = (Some(1.0), Some(items.len() as f64));
    }
    if let Some(start) = start
        && (min.is_some_and(|m| start < m) || max.is_some_and(|m| start > m))
    {
        return Err(format!("start {start} lies outside min and max").into());
    }
    Ok(Variable {
        name: attribute(node, "name")?.to_owned(),
        reference: attribute(node, "valueReference")?.parse()?,
        kind: kind.to_owned(),
        causality: causality.to_owned(),
        variability: variability.to_owned(),
        start,
        start_range: typed.attribute_node("start").map(|a| {
            let range = a.range_value();
            (range.start, range.end)
        }),
        min,
        max,
        nominal: number("nominal")?.unwrap_or(1.0),
        unit: unit.to_owned(),
        enumeration: enumeration.map(str::to_owned),
        description: attribute(node, "description")?.to_owned(),
    })
}
