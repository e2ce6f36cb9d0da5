//! Mesh, flank grid, kernel, face stations, layers and coupling: what each changes.

use super::{paper, thick_spur};
use crate::data::{Data, fixed, percent};
use crate::setup::{solver, ste};
use crate::timing::timed;
use crate::{Context, Result, row};
use gearmesh::compliance::{BeyondModel, Strip, ToothCompliance};
use gearmesh::contact::{ContactSettings, ContactSolver};
use gearmesh::pair::{Pair, Refinement};
use gearmesh_preprocessor::finite_element::{Discretization, FiniteElementCompliance, Settings};
use nalgebra::DMatrix;
use std::sync::Arc;

const TORQUE: f64 = 100.0;

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let pairs = [
        ("convergence-spur", thick_spur()?),
        ("convergence-unmodified", paper(false, 30.0)?),
        ("convergence-modified", paper(true, 30.0)?),
    ];
    for (part, pair) in pairs.iter().take(if context.quick { 1 } else { 3 }) {
        eprintln!("    {part}");
        one_pair(context, data, part, pair)?;
    }
    Ok(())
}

/// Sizes and stations along the face, the finest ones first, level normal second.
fn variants(quick: bool) -> Vec<(&'static str, Discretization, usize)> {
    let [coarse, n, fine] = [Refinement::Coarse, Refinement::Normal, Refinement::Fine].map(Discretization::of);
    let section = Discretization {
        flank_element: n.flank_element / 1.5,
        tooth_element: n.tooth_element / 1.5,
        root_element: n.root_element / 1.5,
        growth: n.growth.powf(1.0 / 1.5),
        ..n
    };
    let layers = Discretization { layer: n.layer / 1.5, end_layer: n.end_layer / 1.5, ..n };
    let mut all = vec![
        ("finest", if quick { n } else { fine }, 80),
        ("level normal", n, 40),
        ("level fine", fine, 40),
        ("level coarse", coarse, 40),
        ("section x 2/3", section, 40),
        ("flank grid alone x 2/3", Discretization { flank_element: n.flank_element / 1.5, ..n }, 40),
        ("layers x 2/3", layers, 40),
        ("kernel 0.12", Discretization { kernel_half_width: 0.12, ..n }, 40),
        ("kernel 0.25", Discretization { kernel_half_width: 0.25, ..n }, 40),
        ("20 segments along the face", n, 20),
        ("80 segments along the face", n, 80),
    ];
    if quick {
        all.retain(|v| v.1 == n || v.1 == coarse);
    }
    all
}

/// The table of a pair.
fn one_pair(context: &Context, data: &Data, part: &str, pair: &Pair) -> Result<()> {
    let default = Settings::for_pair(pair);
    let stations = |stations| ContactSettings { stations, ..ContactSettings::default() };
    let mut found = vec![];
    for (name, discretization, n) in variants(context.quick) {
        let (models, seconds) = timed(|| context.models.get(pair, &Settings { discretization, ..default }));
        found.push((name, ste(&solver(pair, &models?, stations(n))?, TORQUE, 32)?, seconds));
    }
    let alone = context.models.get(pair, &default)?.gears;
    let alone = alone.map(|gear| Arc::new(SingleTeeth(gear)) as Arc<dyn ToothCompliance>);
    let alone = ContactSolver::new(pair, alone, stations(40))?;
    found.push(("neighbours ignored", ste(&alone, TORQUE, 32)?, 0.0));

    let finest = found[0].1;
    let mut rows = vec![];
    for (name, [mean, swing], seconds) in &found {
        let differences = row![percent(*mean, finest[0]), percent(*swing, finest[1])];
        // Where it is new.
        let seconds = if *seconds > 0.05 { fixed(*seconds, 1) } else { String::new() };
        rows.push([row![name, fixed(*mean, 4), fixed(*swing, 4)], differences, row![seconds]].concat());
    }
    data.table(part, &["setting", "mean µm", "p-p µm", "mean %", "p-p %", "compliance s, where it is new"], &rows)
}

/// A model without the influence of one tooth on another.
struct SingleTeeth(Arc<FiniteElementCompliance>);

impl ToothCompliance for SingleTeeth {
    fn bulk(&self, strips: &[Strip]) -> std::result::Result<DMatrix<f64>, BeyondModel> {
        let mut matrix = self.0.bulk(strips)?;
        for i in 0..strips.len() {
            for j in 0..strips.len() {
                if strips[i].tooth != strips[j].tooth {
                    matrix[(i, j)] = 0.0;
                }
            }
        }
        Ok(matrix)
    }

    fn reference_lengths(&self, strips: &[Strip]) -> Vec<f64> {
        self.0.reference_lengths(strips)
    }
}
