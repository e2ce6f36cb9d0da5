//! Modifications of the flanks, each with its start, amount and shape.

use gearmesh::gear::{EndRelief, Flank, Gear, Microgeometry, ProfileRelief, ReliefShape};
use gearmesh::pair::Pair;
use gearmesh::words::fixed;

use crate::output::Listing;

/// Rows on what distinguishes the teeth of gear `i`.
pub fn tooth_errors(pair: &Pair, i: usize, rows: &mut Listing) {
    let um = |amount: f64| fixed(amount * 1e6, 1);
    for (name, flank) in [("drive flank", Flank::Drive), ("coast flank", Flank::Coast)] {
        let errors = &pair.teeth.flank(flank)[i];
        if !errors.index.is_empty() {
            let fold =
                |f: fn(f64, f64) -> f64| errors.index.iter().copied().reduce(f).unwrap_or(0.0);
            rows.row(
                format!("{name}: index errors"),
                format!(
                    "{} to {} um, > 0 towards the mate",
                    um(fold(f64::min)),
                    um(fold(f64::max))
                ),
            );
        }
        for own in &errors.flanks {
            rows.row(
                format!("{name}: tooth {}", own.tooth),
                "topography of its own".to_owned(),
            );
        }
    }
    let errors = &pair.teeth.drive[i];
    if let Some(runout) = errors.runout {
        rows.row(
            "run-out",
            format!(
                "{} um, out most at {} deg from tooth 0",
                um(runout.amount),
                fixed(runout.angle.to_degrees(), 1)
            ),
        );
    }
    for weak in &errors.weak {
        rows.row(
            format!("tooth {}: compliance", weak.tooth),
            format!("{} times that of the others", fixed(weak.factor, 3)),
        );
    }
}

/// Rows on the modifications of gear `i`.
pub fn modifications(pair: &Pair, i: usize, rows: &mut Listing) {
    let gear = &pair.geometry.gears[i];
    let of = |flank| &pair.microgeometry.flank(flank)[i];
    let (drive, coast) = (of(Flank::Drive), of(Flank::Coast));
    let unmodified = Microgeometry::default();
    if drive == coast {
        if *drive == unmodified {
            rows.row("modifications", "none");
        }
        flank("both flanks", gear, drive, rows);
        return;
    }
    for (name, m) in [("drive flank", drive), ("coast flank", coast)] {
        if *m == unmodified {
            rows.row(name, "unmodified");
        }
        flank(name, gear, m, rows);
    }
}

fn flank(name: &str, gear: &Gear, m: &Microgeometry, rows: &mut Listing) {
    let um = |amount: f64| fixed(amount * 1e6, 1);
    let mut row = |what: &str, text: String| {
        rows.row(format!("{name}: {what}"), text);
    };
    let diameter = |roll: f64| fixed(2e3 * gear.radius_at_roll(roll), 3);
    let relief = |r: ProfileRelief| {
        let [from, to] = [r.start_roll, r.end_roll].map(diameter);
        format!(
            "{} um, {} from diameter {from} to {to} mm",
            um(r.amount),
            shape(r.shape)
        )
    };
    if let Some(r) = m.tip_relief {
        row("tip relief", relief(r));
    }
    if let Some(r) = m.root_relief {
        row("root relief", relief(r));
    }
    if let Some(c) = m.profile_crowning {
        let [from, to] = c.rolls.map(diameter);
        row(
            "profile crowning",
            format!(
                "{} um at diameters {from} and {to} mm, parabolic, 0 at mid-roll",
                um(c.amount)
            ),
        );
    }
    if let Some(p) = m.profile_slope {
        let [from, to] = p.rolls.map(diameter);
        if p.amount != 0.0 {
            row(
                "profile slope",
                format!(
                    "{} um more at diameter {to} than at {from} mm (C_Ha {} um), linear, 0 at mid-roll",
                    um(p.amount),
                    um(-p.amount)
                ),
            );
        }
        if p.bias != 0.0 {
            row(
                "bias",
                format!(
                    "profile slope {} um more at the large-z end than at z = 0, 0 at mid-face",
                    um(p.bias)
                ),
            );
        }
    }
    if m.lead_crowning != 0.0 {
        row(
            "lead crowning",
            format!(
                "{} um at both ends of the face, parabolic, 0 at mid-face",
                um(m.lead_crowning)
            ),
        );
    }
    if m.lead_slope != 0.0 {
        row(
            "lead slope",
            format!(
                "{} um more at the large-z end than at z = 0, linear, 0 at mid-face",
                um(m.lead_slope)
            ),
        );
    }
    let end = |r: EndRelief| {
        format!(
            "{} um, {} over the last {} mm",
            um(r.amount),
            shape(r.shape),
            fixed(1e3 * r.length, 3)
        )
    };
    match m.end_relief {
        [Some(low), Some(high)] if low == high => row("end relief, both ends", end(low)),
        [low, high] => {
            if let Some(r) = low {
                row("end relief at z = 0", end(r));
            }
            if let Some(r) = high {
                row("end relief at the large-z end", end(r));
            }
        }
    }
    if let Some(grid) = &m.topography {
        let [rolls, zs] = grid.range();
        let [along, across] = grid.size();
        row(
            "topography",
            format!(
                "{along} x {across} points, diameters {} to {} mm, z {} to {} mm, bicubic",
                diameter(rolls[0]),
                diameter(rolls[1]),
                fixed(1e3 * zs[0], 3),
                fixed(1e3 * zs[1], 3)
            ),
        );
    }
}

fn shape(shape: ReliefShape) -> &'static str {
    match shape {
        ReliefShape::Linear => "linear",
        ReliefShape::Parabolic => "parabolic",
        ReliefShape::Arc => "arc",
    }
}
