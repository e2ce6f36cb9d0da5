//! Generates the FMU's variable table from modelDescription.xml, its one source, so that the
//! library and the file that hosts read cannot drift. What the public checkers of FMUs miss is
//! refused here, at compile time.

use std::collections::{HashMap, HashSet};
use std::error::Error;
use std::fmt::Write as _;
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
    // Line tables serve the command and the tests; in every FMU they would weigh twenty times the code.
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("linux") {
        println!("cargo::rustc-cdylib-link-arg=-Wl,--strip-debug");
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
    check_blocks(&variables)?;
    check_structure(root, &variables)?;
    check_capabilities(root)?;
    let code = emit(root, &variables, &enumerations)?;
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
    check_role(
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
        unit: unit.to_owned(),
        enumeration: enumeration.map(str::to_owned),
        description: attribute(node, "description")?.to_owned(),
    })
}

/// Inputs have a start and no `initial`, parameters are exact with a start, outputs are calculated
/// without one.
fn check_role(
    causality: &str,
    variability: &str,
    initial: Option<&str>,
    has_start: bool,
) -> Result<()> {
    let (expected, start) = match (causality, variability) {
        ("input", "continuous") => (None, true),
        ("parameter", "fixed" | "tunable") => (Some("exact"), true),
        ("output", "continuous" | "discrete") => (Some("calculated"), false),
        _ => return Err(format!("causality {causality} with variability {variability}").into()),
    };
    if initial != expected {
        return Err(format!("{causality} with initial {initial:?}, expected {expected:?}").into());
    }
    if has_start != start {
        let verb = if start { "needs a" } else { "must have no" };
        return Err(format!("{causality} {verb} start value").into());
    }
    Ok(())
}

/// Hosts pass inputs and outputs as blocks: value references ascend, and within one causality they
/// have no gap; the inputs come first, from 0.
fn check_blocks(variables: &[Variable]) -> Result<()> {
    for pair in variables.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        if b.reference <= a.reference {
            return Err(format!("{}: value references must ascend", b.name).into());
        }
        if a.causality == b.causality && b.reference != a.reference + 1 {
            return Err(format!("{}: a gap before it inside the {}s", b.name, b.causality).into());
        }
    }
    if variables
        .first()
        .is_none_or(|v| v.causality != "input" || v.reference != 0)
    {
        return Err("the inputs come first, from value reference 0".into());
    }
    Ok(())
}

/// ModelStructure: every output stands in Outputs and in InitialUnknowns, in order; dependencies
/// ascend and name inputs only.
fn check_structure(root: Node, variables: &[Variable]) -> Result<()> {
    let structure = child(root, "ModelStructure")?;
    let outputs: Vec<usize> = (1..=variables.len())
        .filter(|&i| variables[i - 1].causality == "output")
        .collect();
    for block in ["Outputs", "InitialUnknowns"] {
        let mut listed = Vec::new();
        for unknown in elements(child(structure, block)?) {
            let index: usize = attribute(unknown, "index")?.parse()?;
            listed.push(index);
            let mut last = 0;
            for word in unknown
                .attribute("dependencies")
                .unwrap_or("")
                .split_whitespace()
            {
                let known: usize = word.parse()?;
                if known <= last {
                    return Err(format!("{block}, {index}: dependencies must ascend").into());
                }
                if variables
                    .get(known - 1)
                    .is_none_or(|v| v.causality != "input")
                {
                    return Err(format!("{block}, {index}: {known} is not an input").into());
                }
                last = known;
            }
        }
        if listed != outputs {
            return Err(format!("{block} must list every output once, in order").into());
        }
    }
    Ok(())
}

fn check_capabilities(root: Node) -> Result<()> {
    for interface in
        elements(root).filter(|n| n.has_tag_name("CoSimulation") || n.has_tag_name("ModelExchange"))
    {
        let is = |name: &str| interface.attribute(name) == Some("true");
        if is("canSerializeFMUstate") && !is("canGetAndSetFMUstate") {
            return Err("canSerializeFMUstate needs canGetAndSetFMUstate".into());
        }
        if !is("canNotUseMemoryManagementFunctions") {
            return Err("canNotUseMemoryManagementFunctions must be true: Rust allocates".into());
        }
        if root.attribute("modelName") != Some(attribute(interface, "modelIdentifier")?) {
            return Err("modelIdentifier and modelName differ".into());
        }
    }
    Ok(())
}

/// `gear1.position[1]` -> `GEAR1_POSITION_1`, `mesh.contactZ` -> `MESH_CONTACT_Z`.
fn constant(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        match c {
            '.' | '[' => out.push('_'),
            ']' => {}
            c if c.is_ascii_uppercase() => out.extend(['_', c]),
            c => out.push(c.to_ascii_uppercase()),
        }
    }
    out
}

/// `input` -> `Input`.
fn variant(word: &str) -> String {
    word[..1].to_ascii_uppercase() + &word[1..]
}

fn emit(root: Node, variables: &[Variable], enumerations: &Enumerations) -> Result<String> {
    let mut code = String::from("// Generated by build.rs from modelDescription.xml.\n");
    for (name, key) in [("GUID_RANGE", "guid"), ("DESCRIPTION_RANGE", "description")] {
        let range = root
            .attribute_node(key)
            .ok_or("no guid or description")?
            .range_value();
        let (from, to) = (range.start, range.end);
        writeln!(code, "const {name}: (usize, usize) = ({from}, {to});")?;
    }
    let identifier = attribute(root, "modelName")?;
    writeln!(
        code,
        "/// Model identifier, the base name of the library in the archive.\n\
         pub const MODEL_IDENTIFIER: &str = {identifier:?};"
    )?;
    let inputs = variables.iter().filter(|v| v.causality == "input").count();
    let all = variables.len();
    writeln!(
        code,
        "/// Number of inputs.\npub const INPUT_COUNT: usize = {inputs};"
    )?;
    writeln!(
        code,
        "/// Number of variables.\npub const VARIABLE_COUNT: usize = {all};"
    )?;
    let categories: Vec<&str> = elements(child(root, "LogCategories")?)
        .map(|n| attribute(n, "name"))
        .collect::<Result<_>>()?;
    writeln!(
        code,
        "/// Log categories in the order of modelDescription.xml.\n\
         pub const LOG_CATEGORIES: [&str; {}] = {categories:?};\n\
         /// Index of each variable in [`VARIABLES`].\n\
         pub mod index {{\n    #![allow(missing_docs)]",
        categories.len()
    )?;
    for (i, v) in variables.iter().enumerate() {
        writeln!(code, "    pub const {}: usize = {i};", constant(&v.name))?;
    }
    writeln!(
        code,
        "}}\n/// All variables in the order of modelDescription.xml.\n\
         pub static VARIABLES: [Variable; VARIABLE_COUNT] = ["
    )?;
    for v in variables {
        let items = enumerations
            .iter()
            .find(|e| Some(&e.0) == v.enumeration.as_ref());
        let items = items.map_or(&[] as &[String], |e| &e.1);
        writeln!(
            code,
            "    Variable {{ name: {:?}, value_reference: {}, kind: Kind::{}, \
             causality: Causality::{}, variability: Variability::{}, start: {:?}, min: {:?}, \
             max: {:?}, unit: {:?}, items: &{items:?}, description: {:?}, start_range: {:?} }},",
            v.name,
            v.reference,
            v.kind,
            variant(&v.causality),
            variant(&v.variability),
            v.start,
            v.min,
            v.max,
            v.unit,
            v.description,
            v.start_range
        )?;
    }
    code.push_str("];\n");
    Ok(code)
}
