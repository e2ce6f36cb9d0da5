//! Modifications of the flanks, each with its start, amount and shape.

use gearmesh::gear::{EndRelief, Flank, Gear, Microgeometry, ReliefShape};
use gearmesh::pair::Pair;
use gearmesh::words::fixed;

use crate::output::{Listing, rows};

/// Rows on what distinguishes the teeth of gear `i`.
pub fn tooth_errors(pair: &Pair, i: usize, rows: &mut Listing) {
    for (name, flank) in [("drive flank", Flank::Drive), ("coast flank", Flank::Coast)] {
        let errors = &pair.teeth.flank(flank)[i];
        let ends = [f64::min, f64::max].map(|end| errors.index.iter().copied().reduce(end));
        if let [Some(least), Some(largest)] = ends.map(|end| end.map(um)) {
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

pub fn modifications(pair: &Pair, i: usize, rows: &mut Listing) {
    let gear = &pair.geometry.gears[i];
    for (name, m) in flanks(pair, i) {
        if *m == Microgeometry::default() {
            match name {
                BOTH => rows.row("modifications", "none"),
                _ => rows.row(name, "unmodified"),
            }
        }
        flank(name, gear, m, rows);
    }
    for (name, words) in topographies(pair, i) {
        rows.row(name, words);
    }
}

/// Flanks of gear `i` with a topography, and what is to be known of it.
pub fn topographies(pair: &Pair, i: usize) -> Vec<(String, String)> {
    let words = |(name, m)| Some((format!("{name}: topography"), topography(pair, i, m)?));
    flanks(pair, i).into_iter().filter_map(words).collect()
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
    let diameters = |rolls: [f64; 2]| rolls.map(|roll| fixed(2e3 * gear.radius_at_roll(roll), 3));
    let named = |what: &str| format!("{name}: {what}");
    for (what, relief) in [("tip relief", m.tip_relief), ("root relief", m.root_relief)] {
        let Some(r) = relief else { continue };
        let rolls = [r.start_roll, r.end_roll];
        let [d1, d2] = diameters(rolls);
        let [l1, l2] = rolls.map(|roll| fixed(1e3 * roll, 4));
        let [a1, a2] = rolls.map(|roll| fixed((roll / gear.base_radius()).to_degrees(), 3));
        rows! { rows;
            named(what) => "{} um, {} from diameter {d1} to {d2} mm, roll length {l1} to {l2} mm, roll angle {a1} to {a2} deg", um(r.amount), shape(r.shape);
        }
    }
    if let Some(c) = m.profile_crowning {
        let [from, to] = diameters(c.rolls);
        rows! { rows;
            named("profile crowning") => "{} um at diameters {from} and {to} mm, parabolic, 0 at mid-roll", um(c.amount);
        }
    }
    if let Some(p) = m.profile_slope.filter(|p| p.amount != 0.0) {
        let ([from, to], c_ha) = (diameters(p.rolls), um(-p.amount));
        rows! { rows;
            named("profile slope") => "{} um more at diameter {to} than at {from} mm (C_Ha {c_ha} um), linear, 0 at mid-roll", um(p.amount);
        }
    }
    let bias = m.profile_slope.map_or(0.0, |p| p.bias);
    if bias != 0.0 {
        rows! { rows; named("bias") => "{} um more profile slope at the large-z end than at z = 0, 0 at mid-face", um(bias); }
    }
    if m.lead_crowning != 0.0 {
        rows! { rows; named("lead crowning") => "{} um at both ends of the face, parabolic, 0 at mid-face", um(m.lead_crowning); }
    }
    if m.lead_slope != 0.0 {
        rows! { rows; named("lead slope") => "{} um more at the large-z end than at z = 0, linear, 0 at mid-face", um(m.lead_slope); }
    }
    let [low, high] = m.end_relief;
    let both = low.filter(|_| low == high);
    let own = |end: Option<EndRelief>| end.filter(|_| both.is_none());
    for (what, relief) in [
        ("end relief, both ends", both),
        ("end relief at z = 0", own(low)),
        ("end relief at the large-z end", own(high)),
    ] {
        let Some(r) = relief else { continue };
        let (shape, mm) = (shape(r.shape), fixed(1e3 * r.length, 3));
        rows! { rows; named(what) => "{} um, {shape} over the last {mm} mm", um(r.amount); }
    }
}

fn um(amount: f64) -> String {
    fixed(amount * 1e6, 1)
}

fn shape(shape: ReliefShape) -> String {
    format!("{shape:?}").to_lowercase()
}
