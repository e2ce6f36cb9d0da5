//! The radius at which the gear is fixed, and the one that gives the mean STE of the paper.

use super::paper;
use crate::data::{Data, last_that_holds};
use crate::setup::{Setup, ste};
use crate::{Context, Result};
use gearmesh_preprocessor::gear::{Pair, Refinement};

const TORQUE: f64 = 100.0;
const POSITIONS: usize = 16;
/// Bores, mm; the last leaves 1 mm of rim, the least that is meshed.
const BORES: [f64; 7] = [15.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.1];
/// Mean STE that the mean stiffnesses of the paper's Table 2 mean, um.
const PAPER: [f64; 2] = [5.4, 5.1];

/// STE at 100 N m, mean and p-p, and the mean without load, um.
struct Solved {
    mean: f64,
    swing: f64,
    unloaded: f64,
}

fn solved(modified: bool, bore_mm: f64, refinement: Refinement) -> Result<Solved> {
    let pair = paper(modified, bore_mm)?;
    let pair = Pair { refinement, ..pair };
    let solver = Setup::new(pair, None)?.solver;
    let [mean, swing] = ste(&solver, TORQUE, POSITIONS)?;
    let [unloaded, _] = ste(&solver, 0.0, POSITIONS)?;
    Ok(Solved {
        mean,
        swing,
        unloaded,
    })
}

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let (mut rows, mut curve) = (vec![], vec![]);
    for &bore in if context.quick { &BORES[..2] } else { &BORES } {
        eprintln!("    bore {bore} mm");
        let plain = solved(false, bore, Refinement::Coarse)?;
        let modified = solved(true, bore, Refinement::Coarse)?;
        let plain_row = format!("{:.3} | {:.3}", plain.mean, plain.swing);
        let (mean, swing) = (modified.mean, modified.swing);
        let loaded = mean - modified.unloaded;
        rows.push(format!(
            "{bore} | {plain_row} | {mean:.3} | {loaded:.3} | {swing:.3}"
        ));
        curve.push([bore, plain.mean]);
    }
    let head = "bore, mm | unmodified mean, µm | p-p, µm | modified mean, µm \
        | mean less that without load, µm | p-p, µm";
    data.table("bores", head, &rows)?;

    let mut rows = vec![];
    for target in PAPER {
        rows.push(match bore_for(&curve, target)? {
            Some((bore, Solved { mean, swing, .. })) => {
                format!("{target} | {bore:.1} | {mean:.3} | {swing:.3}")
            }
            None => format!("{target} | none ||"),
        });
    }
    let head = "mean of the paper, µm | bore of the unmodified pair, mm | mean there, µm | p-p, µm";
    data.table("hub", head, &rows)
}

/// The bore (mm) with the mean `target` (um) of the unmodified pair on `curve` (bore, mean), solved at level normal.
fn bore_for(curve: &[[f64; 2]], target: f64) -> Result<Option<(f64, Solved)>> {
    let holds = |w: &&[[f64; 2]]| w[0][1] >= target && target >= w[1][1];
    let Some(w) = curve.windows(2).find(holds) else {
        return Ok(None);
    };
    let ([near, near_mean], [far, far_mean]) = (w[0], w[1]);
    let mean = |bore: f64, level| Ok::<_, crate::Error>(solved(false, bore, level)?.mean);
    // The level normal differs from coarse by a nearly constant share, so search on coarse for the target less that.
    let start = near + (far - near) * (near_mean - target) / (near_mean - far_mean);
    let share = mean(start, Refinement::Coarse)? / mean(start, Refinement::Normal)?;
    let above = |bore| Ok(mean(bore, Refinement::Coarse)? > target * share);
    let [low, high] = last_that_holds([near, far], 7, above)?;
    let bore = 0.5 * (low + high);
    Ok(Some((bore, solved(false, bore, Refinement::Normal)?)))
}
