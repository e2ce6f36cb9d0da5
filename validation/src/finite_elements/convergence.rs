//! Mesh, flank grid, kernel, segments along the face, layers and coupling: what each changes.

use super::{paper, thick_spur};
use crate::data::{Data, percent};
use crate::setup::{models, solver, ste};
use crate::{Context, Result};
use gearmesh::contact::ContactSettings;
use gearmesh::contact::Segment;
use gearmesh_preprocessor::compliance::{BeyondModel, ToothCompliance};
use gearmesh_preprocessor::finite_element::{Discretization, FiniteElementCompliance, Settings};
use gearmesh_preprocessor::gear::{Pair, Refinement};
use gearmesh_preprocessor::static_contact::ContactSolver;
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
        one_pair(context.quick, data, part, pair)?;
    }
    Ok(())
}

/// Sizes and segments along the face, the finest ones first, level normal second.
fn variants(quick: bool) -> Vec<(&'static str, Discretization, usize)> {
    let levels = [Refinement::Coarse, Refinement::Normal, Refinement::Fine];
    let [coarse, n, fine] = levels.map(Discretization::of);
    let changed = |change: fn(&mut Discretization)| {
        let mut changed = n;
        change(&mut changed);
        changed
    };
    let section = changed(|d| {
        d.flank_element /= 1.5;
        d.tooth_element /= 1.5;
        d.root_element /= 1.5;
        d.growth = d.growth.powf(1.0 / 1.5);
    });
    let layers = changed(|d| {
        d.layer /= 1.5;
        d.end_layer /= 1.5;
    });
    let mut all = vec![
        ("finest", if quick { n } else { fine }, 80),
        ("level normal", n, 40),
        ("level fine", fine, 40),
        ("level coarse", coarse, 40),
        ("section x 2/3", section, 40),
        (
            "flank grid alone x 2/3",
            changed(|d| d.flank_element /= 1.5),
            40,
        ),
        ("layers x 2/3", layers, 40),
        ("kernel 0.12", changed(|d| d.kernel_half_width = 0.12), 40),
        ("kernel 0.25", changed(|d| d.kernel_half_width = 0.25), 40),
        ("20 segments along the face", n, 20),
        ("80 segments along the face", n, 80),
    ];
    if quick {
        all.retain(|v| v.1 == n || v.1 == coarse);
    }
    all
}

/// The table of a pair.
fn one_pair(quick: bool, data: &Data, part: &str, pair: &Pair) -> Result<()> {
    let default = Settings::for_pair(pair);
    let contact = |stations| ContactSettings {
        stations,
        ..ContactSettings::default()
    };
    let mut found = vec![];
    for (name, discretization, n) in variants(quick) {
        let settings = Settings {
            discretization,
            ..default
        };
        let solver = solver(pair, &models(pair, &settings)?, contact(n))?;
        found.push((name, ste(&solver, TORQUE, 32)?));
    }
    let alone = models(pair, &default)?.gears;
    let alone = alone.map(|gear| Arc::new(SingleTeeth(gear)) as Arc<dyn ToothCompliance>);
    let alone = ContactSolver::new(pair, alone, contact(40))?;
    found.push(("neighbours ignored", ste(&alone, TORQUE, 32)?));

    let finest = found[0].1;
    let row = |(name, [mean, swing]): &(&str, [f64; 2])| {
        let (of_mean, of_swing) = (percent(*mean, finest[0]), percent(*swing, finest[1]));
        format!("{name} | {mean:.4} | {swing:.4} | {of_mean:+.2} | {of_swing:+.2}")
    };
    let rows: Vec<_> = found.iter().map(row).collect();
    let head = "setting | mean µm | p-p µm | mean % | p-p %";
    data.table(part, head, &rows)
}

/// A model without the influence of one tooth on another.
struct SingleTeeth(Arc<FiniteElementCompliance>);

impl ToothCompliance for SingleTeeth {
    fn bulk(&self, segments: &[Segment]) -> std::result::Result<DMatrix<f64>, BeyondModel> {
        let all = self.0.bulk(segments)?;
        let same = |i: usize, j: usize| segments[i].tooth == segments[j].tooth;
        Ok(all.map_with_location(|i, j, x| if same(i, j) { x } else { 0.0 }))
    }

    fn reference_lengths(&self, segments: &[Segment]) -> Vec<f64> {
        self.0.reference_lengths(segments)
    }
}
