//! The levels of detail side by side.

use crate::cases::{self, Models, SHIPPED, shipped, solver};
use crate::page::{Outcome, percent, table};
use gearmesh::compliance::finite_element::Settings;
use gearmesh::contact::{ContactSettings, ContactSolver};
use gearmesh::pair::Refinement;
use std::path::Path;

const POSITIONS: usize = 32;

/// The chapter.
pub fn report(models: &Models, _: &Path) -> Outcome<String> {
    let mut rows = vec![];
    for name in SHIPPED {
        eprintln!("    {name}");
        let pair = shipped(name)?;
        let normal = models.solver(&pair)?;
        let mut rough = pair.clone();
        rough.refinement = Refinement::Coarse;
        let coarse = models.get(&rough, &Settings::for_pair(&rough))?;
        let coarse = solver(&rough, &coarse, ContactSettings::for_pair(&rough))?;
        let operating = &pair.operating;
        for torque in [
            0.4 * operating.nominal_torque,
            operating.nominal_torque,
            operating.maximum_torque,
        ] {
            let of = |solver: &ContactSolver| cases::ste(solver, torque, POSITIONS);
            let [n, c] = [of(&normal)?, of(&coarse)?];
            rows.push([
                name.to_owned(),
                format!("{torque:.0}"),
                format!("{:.3}", n[0]),
                format!("{:.3}", n[1]),
                percent(c[0], n[0]),
                percent(c[1], n[1]),
            ]);
        }
    }
    Ok(format!(
        "Differences to level normal in %, at 40 % of the nominal torque, at the nominal and at the largest torque. The mean \
         contains the modifications, which all levels share; the peak-to-peak near the design load is a small difference.\n\n{}",
        table(
            [
                "pair",
                "N m",
                "normal mean, µm",
                "p-p, µm",
                "coarse mean",
                "p-p",
            ],
            &rows
        )
    ))
}
