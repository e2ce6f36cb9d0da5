//! Modifications of the flanks, each with its start, amount and shape.

use gearmesh::gear::{EndRelief, Flank, Gear, Microgeometry, ReliefShape};
use gearmesh::pair::Pair;
use gearmesh::words::fixed;

use crate::output::{Listing, rows};

/// Rows on what distinguishes the teeth of gear `i`.
pub fn tooth_errors(pair: &Pair, i: usize, rows: &mut Listing) {
    let um = |amount: f64| fixed(amount * 1e6, 1);
    for (name, flank) in [("drive flank", Flank::Drive), ("coast flank", Flank::Coast)] {
        let errors = &pair.teeth.flank(flank)[i];
        if !errors.index.is_empty() {
            let index = errors.index.iter().copied();
            let [least, largest] =
                [f64::min, f64::max].map(|of| um(index.clone().reduce(of).unwrap_or(0.0)));
            rows! { rows; format!("{name}: index errors") => "{least} to {largest} um, > 0 towards the mate"; }
        }
        for own in &errors.flanks {
            let words = topography(pair, i, &own.microgeometry).unwrap_or_default();
            rows! { rows; format!("{name}: tooth {}", own.tooth) => "topography of its own, {words}"; }
        }
    }
    let errors = &pair.teeth.drive[i];
    if let Some(runout) = errors.runout {
        let angle = fixed(runout.angle.to_degrees(), 1);
        rows! { rows; "run-out" => "{} um, out most at {angle} deg from tooth 0", um(runout.amount); }
    }
    for weak in &errors.weak {
        let name = format!("tooth {}: compliance", weak.tooth);
        rows! { rows; name => "{} times that of the others", fixed(weak.factor, 3); }
    }
}

/// Rows on the modifications of gear `i`.
pub fn modifications(pair: &Pair, i: usize, rows: &mut Listing) {
    let gear = &pair.geometry.gears[i];
    let unmodified = Microgeometry::default();
    for (name, m) in flanks(pair, i) {
        if *m == unmodified {
            match name {
                BOTH => rows.row("modifications", "none"),
                _ => rows.row(name, "unmodified"),
            };
        }
        flank(name, gear, m, rows);
        if let Some(words) = topography(pair, i, m) {
            rows.row(format!("{name}: topography"), words);
        }
    }
}

/// Flanks of gear `i` with a topography, and what is to be known of it.
pub fn topographies(pair: &Pair, i: usize) -> Vec<(String, String)> {
    let flanks = flanks(pair, i).into_iter();
    let all = flanks
        .filter_map(|(name, m)| Some((format!("{name}: topography"), topography(pair, i, m)?)));
    all.collect()
}

const BOTH: &str = "both flanks";

/// Both flanks of gear `i` as one where they are alike, with their names.
fn flanks(pair: &Pair, i: usize) -> Vec<(&'static str, &Microgeometry)> {
    let of = |flank| &pair.microgeometry.flank(flank)[i];
    let (drive, coast) = (of(Flank::Drive), of(Flank::Coast));
    match drive == coast {
        true => vec![(BOTH, drive)],
        false => vec![("drive flank", drive), ("coast flank", coast)],
    }
}

/// Grid and removal of the topography of a flank of gear `i`.
fn topography(pair: &Pair, i: usize, m: &Microgeometry) -> Option<String> {
    let (grid, g) = (m.topography.as_ref()?, &pair.geometry);
    let gear = &g.gears[i];
    let [rolls, zs] = grid.range();
    let [along, across] = grid.size();
    let tip = gear.tip_form_roll();
    let start = g.active_start_roll(i, g.center_distance);
    let active = [start.min(tip), start.max(tip)];
    let [least, largest] = grid.extremes(active, [0.0, gear.face_width]);
    let um = |removal: f64| fixed(removal * 1e6, 2);
    let [from, to] = rolls.map(|roll| fixed(2e3 * gear.radius_at_roll(roll), 3));
    Some(format!(
        "removal {} to {} um on the active flank, {} um at the tip at mid-face; {along} x {across} points, diameters {from} \
         to {to} mm, z {} to {} mm, bicubic",
        um(least[2]),
        um(largest[2]),
        um(grid.removal(tip, 0.5 * gear.face_width)),
        fixed(1e3 * zs[0], 3),
        fixed(1e3 * zs[1], 3)
    ))
}

fn flank(name: &str, gear: &Gear, m: &Microgeometry, rows: &mut Listing) {
    let um = |amount: f64| fixed(amount * 1e6, 1);
    let of = |what: &str| format!("{name}: {what}");
    let diameters = |rolls: [f64; 2]| rolls.map(|roll| fixed(2e3 * gear.radius_at_roll(roll), 3));
    for (what, relief) in [("tip relief", m.tip_relief), ("root relief", m.root_relief)] {
        let Some(r) = relief else { continue };
        let [from, to] = diameters([r.start_roll, r.end_roll]);
        rows! { rows; of(what) => "{} um, {} from diameter {from} to {to} mm", um(r.amount), shape(r.shape); }
    }
    if let Some(c) = m.profile_crowning {
        let [from, to] = diameters(c.rolls);
        rows! { rows;
            of("profile crowning") => "{} um at diameters {from} and {to} mm, parabolic, 0 at mid-roll", um(c.amount);
        }
    }
    if let Some(p) = m.profile_slope {
        let [from, to] = diameters(p.rolls);
        if p.amount != 0.0 {
            rows! { rows;
                of("profile slope") => "{} um more at diameter {to} than at {from} mm (C_Ha {} um), linear, 0 at mid-roll",
                    um(p.amount), um(-p.amount);
            }
        }
        if p.bias != 0.0 {
            rows! { rows;
                of("bias") => "profile slope {} um more at the large-z end than at z = 0, 0 at mid-face", um(p.bias);
            }
        }
    }
    if m.lead_crowning != 0.0 {
        rows! { rows;
            of("lead crowning") => "{} um at both ends of the face, parabolic, 0 at mid-face", um(m.lead_crowning);
        }
    }
    if m.lead_slope != 0.0 {
        rows! { rows;
            of("lead slope") => "{} um more at the large-z end than at z = 0, linear, 0 at mid-face", um(m.lead_slope);
        }
    }
    let mut end = |what: &str, relief: Option<EndRelief>| {
        let Some(r) = relief else { return };
        let mm = fixed(1e3 * r.length, 3);
        rows! { rows; of(what) => "{} um, {} over the last {mm} mm", um(r.amount), shape(r.shape); }
    };
    match m.end_relief {
        [low, high] if low == high => end("end relief, both ends", low),
        [low, high] => {
            end("end relief at z = 0", low);
            end("end relief at the large-z end", high);
        }
    }
}

fn shape(shape: ReliefShape) -> &'static str {
    match shape {
        ReliefShape::Linear => "linear",
        ReliefShape::Parabolic => "parabolic",
        ReliefShape::Arc => "arc",
    }
}
