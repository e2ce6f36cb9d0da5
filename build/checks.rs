//! What the public checkers of FMUs miss.

use roxmltree::Node;

use crate::{Result, Variable, attribute, child, elements};

/// Inputs have a start and no `initial`, parameters are exact with a start, outputs are calculated
/// without one.
pub fn check_role(
    causality: &str,
    variability: &str,
    initial: Option<&str>,
    has_start: bool,
) -> Result<()> {
    let (expected, start) = match (causality, variability) {
        ("input", "continuous") => (None, true),
        ("parameter", "fixed" | "tunable") => (Some("exact"), true),
        ("output", "continuous") => (Some("calculated"), false),
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
pub fn check_blocks(variables: &[Variable]) -> Result<()> {
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
/// ascend and name inputs only, in the initialization parameters, too.
pub fn check_structure(root: Node, variables: &[Variable]) -> Result<()> {
    let structure = child(root, "ModelStructure")?;
    let outputs: Vec<usize> = (1..=variables.len())
        .filter(|&i| variables[i - 1].causality == "output")
        .collect();
    for (block, sources) in [
        ("Outputs", ["input"].as_slice()),
        ("InitialUnknowns", &["input", "parameter"]),
    ] {
        let mut listed = Vec::new();
        for unknown in elements(child(structure, block)?) {
            let index: usize = attribute(unknown, "index")?.parse()?;
            listed.push(index);
            let mut last = 0;
            for word in attribute(unknown, "dependencies")?.split_whitespace() {
                let known: usize = word.parse()?;
                if known <= last {
                    return Err(format!("{block}, {index}: dependencies must ascend").into());
                }
                if variables
                    .get(known - 1)
                    .is_none_or(|v| !sources.contains(&v.causality.as_str()))
                {
                    let sources = sources.join(" or ");
                    return Err(format!("{block}, {index}: {known} is no {sources}").into());
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

pub fn check_capabilities(root: Node) -> Result<()> {
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
