//! What a grid must fulfil before an interpolant is put on it.

use super::{Axes, FlankGrid, TableError};

/// Fewest nodes of an axis that is there: the C2 spline needs four.
const FEWEST: usize = 4;

/// Most nodes of an axis, beyond any use: four such axes still have a number of samples that can be counted.
const MOST: usize = 10_000;

/// Beyond all lengths, forces and moments of gears; products of a few of them with one another stay finite.
const LARGEST: f64 = 1e15;

impl FlankGrid {
    /// Checks lengths, order and finiteness of all that is there, and that the force does not fall
    /// over the displacement. `flank` names it in messages.
    ///
    /// # Errors
    /// The first defect, by field and index.
    pub fn check(&self, flank: &str) -> Result<(), TableError> {
        let axes = &self.axes;
        axes.check()?;
        let [nc, nm, nu, np] = axes.lengths();
        let named = |name: &str| format!("{flank}.{name}");
        let (columns, samples) = (nc * nm * np, nc * nm * nu * np);
        let mut all = vec![
            ("no_load_approach_m", &self.no_load_approach, columns),
            ("top_load_approach_m", &self.top_load_approach, columns),
            ("loa_force_n", &self.loa_force, samples),
        ];
        all.extend(self.moment.iter().map(|m| ("moment_nm", m, samples)));
        for (name, values, length) in all {
            check_values(&named(name), values, length)?;
        }
        let ends = self.no_load_approach.iter().zip(&self.top_load_approach);
        for (i, (low, high)) in ends.enumerate() {
            if high <= low {
                return Err(TableError::field(
                    named(&format!("top_load_approach_m[{i}]")),
                    high,
                    format!("not above the no-load approach {low}"),
                    "make the tables again; of imported samples, check the sign of ste_loa_um",
                ));
            }
        }
        for block in 0..nc * nm {
            for p in 0..np {
                let mut below = 0.0;
                for u in 0..nu {
                    let i = (block * nu + u) * np + p;
                    let force = self.loa_force[i];
                    if force < below || (u + 1 == nu && force <= 0.0) {
                        return Err(TableError::field(
                            named(&format!("loa_force_n[{i}]")),
                            force,
                            format!(
                                "the force must not fall with the displacement (before it: {below})"
                            ),
                            "make the tables again; of imported samples, remove the falling one",
                        ));
                    }
                    below = force;
                }
            }
        }
        Ok(())
    }
}

impl Axes {
    fn check(&self) -> Result<(), TableError> {
        let u = &self.displacement_fraction;
        check_axis("axes.displacement_fraction", u)?;
        if u.len() < FEWEST {
            return Err(too_few("axes.displacement_fraction", u.len()));
        }
        if u[0] <= 0.0 || u[u.len() - 1] != 1.0 {
            return Err(TableError::field(
                "axes.displacement_fraction",
                format!("{} ... {}", u[0], u[u.len() - 1]),
                "it must begin above 0 and end at 1",
                "make the tables again",
            ));
        }
        // The spline's first cell begins at the onset of contact, which imports round over a few millionths.
        check_spacing(
            "axes.displacement_fraction",
            &[&[0.0], u.as_slice()].concat(),
            1e-6,
        )?;
        for (name, nodes) in [
            (
                "axes.center_distance_offset_m",
                &self.center_distance_offset,
            ),
            ("axes.misalignment_rad", &self.misalignment),
            ("axes.mesh_position", &self.mesh_position),
        ] {
            check_axis(name, nodes)?;
        }
        check_mesh_position("axes.mesh_position", &self.mesh_position)
    }
}

/// Checks what sets the periodic axis apart from others; `name` with its path, as in all of these.
pub(super) fn check_mesh_position(name: &str, nodes: &[f64]) -> Result<(), TableError> {
    let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
    if first < 0.0 || last >= 1.0 {
        return Err(TableError::field(
            name,
            format!("{first} ... {last}"),
            "a mesh position lies in [0, 1)",
            "leave out the repeated end 1; the axis is periodic",
        ));
    }
    // The last cell ends at the first node of the next cycle.
    check_spacing(name, &[nodes, &[first + 1.0]].concat(), 1e-5)
}

pub(super) fn too_few(name: &str, count: usize) -> TableError {
    TableError::field(
        name,
        format!("{count} values"),
        format!("a cubic spline needs at least {FEWEST}"),
        "add values, or give a single one to leave this axis out",
    )
}

pub(super) fn check_axis(name: &str, nodes: &[f64]) -> Result<(), TableError> {
    if nodes.is_empty() || (2..FEWEST).contains(&nodes.len()) {
        return Err(too_few(name, nodes.len()));
    }
    if nodes.len() > MOST {
        return Err(TableError::field(
            name,
            format!("{} values", nodes.len()),
            format!("an axis has at most {MOST}"),
            "leave some of them out",
        ));
    }
    check_values(name, nodes, nodes.len())?;
    for (i, pair) in nodes.windows(2).enumerate() {
        if pair[1] <= pair[0] {
            return Err(TableError::field(
                format!("{name}[{}]", i + 1),
                pair[1],
                format!("not above the value before it, {}", pair[0]),
                "sort the axis ascending and let each value stand once",
            ));
        }
    }
    check_spacing(name, nodes, 1e-5)
}

/// Cells of a spline between `ends`, ascending: one narrower than `least` of the range costs memory without bound where
/// cells are found by equal buckets.
fn check_spacing(name: &str, ends: &[f64], least: f64) -> Result<(), TableError> {
    let range = ends[ends.len() - 1] - ends[0];
    match ends.windows(2).find(|w| w[1] - w[0] < least * range) {
        Some(pair) => Err(TableError::field(
            name,
            format!("{} and {}", pair[0], pair[1]),
            format!("closer than {least:e} of the range"),
            "leave one of them out",
        )),
        None => Ok(()),
    }
}

pub(super) fn check_values(name: &str, values: &[f64], length: usize) -> Result<(), TableError> {
    if values.len() != length {
        return Err(TableError::field(
            name,
            format!("{} values", values.len()),
            format!("the axes ask for {length}"),
            "the file is incomplete; make the tables again",
        ));
    }
    match values.iter().position(|v| v.is_nan() || v.abs() > LARGEST) {
        Some(i) => Err(TableError::field(
            format!("{name}[{i}]"),
            values[i],
            format!("a number no larger than {LARGEST:e} is wanted"),
            "make the tables again",
        )),
        None => Ok(()),
    }
}
