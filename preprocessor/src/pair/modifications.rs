//! Flank modifications in words, as summaries and tables files have them.

use crate::gear::Pair;
use gearmesh::gear::{Flank, Gear, Microgeometry, PairGeometry, ReliefShape};
use gearmesh::words::fixed;

const BOTH: &str = "both flanks";

/// Name and description of each modification of gear `i` (0 or 1), both flanks as one where they are alike.
pub fn modifications(pair: &Pair, i: usize) -> Vec<(String, String)> {
    let gear = &pair.geometry.gears[i];
    let mut rows = Vec::new();
    for (name, m) in flanks(pair, i) {
        if *m != Microgeometry::default() {
            add_profile_modifications(name, gear, m, &mut rows);
            add_lead_modifications(name, m, &mut rows);
        } else if name == BOTH {
            rows.push(("modifications".to_owned(), "none".to_owned()));
        } else {
            rows.push((name.to_owned(), "unmodified".to_owned()));
        }
    }
    rows.extend(topographies(pair, i));
    rows
}

/// Name and description of each flank of gear `i` that has a topography.
pub fn topographies(pair: &Pair, i: usize) -> Vec<(String, String)> {
    let mut rows = Vec::new();
    for (name, m) in flanks(pair, i) {
        if let Some(words) = topography(&pair.geometry, i, m) {
            rows.push((format!("{name}: topography"), words));
        }
    }
    rows
}

/// The topography of `m` on gear `i` of `geometry` in words; None: it has none.
pub fn topography(geometry: &PairGeometry, i: usize, m: &Microgeometry) -> Option<String> {
    let grid = m.topography.as_ref()?;
    let gear = &geometry.gears[i];
    let [rolls, zs] = grid.range();
    let [along, across] = grid.size();
    let tip = gear.tip_form_roll();
    let start = geometry.active_start_roll(i, geometry.center_distance);
    let active = [start.min(tip), start.max(tip)];
    let [least, largest] = grid.extremes(active, [0.0, gear.face_width]);
    let at_tip = grid.removal(tip, 0.5 * gear.face_width);
    let [least, largest, at_tip] =
        [least[2], largest[2], at_tip].map(|removal| fixed(1e6 * removal, 2));
    let [from, to] = diameters(gear, rolls);
    let [low, high] = zs.map(|z| fixed(1e3 * z, 3));
    Some(format!(
        "removal {least} to {largest} um on the active flank, {at_tip} um at the tip at mid-face; {along} x {across} points, \
         diameters {from} to {to} mm, z {low} to {high} mm, bicubic"
    ))
}

/// The flanks of gear `i` with their names; one where they are alike.
fn flanks(pair: &Pair, i: usize) -> Vec<(&'static str, &Microgeometry)> {
    let drive = &pair.microgeometry.flank(Flank::Drive)[i];
    let coast = &pair.microgeometry.flank(Flank::Coast)[i];
    match drive == coast {
        true => vec![(BOTH, drive)],
        false => vec![("drive flank", drive), ("coast flank", coast)],
    }
}

fn add_profile_modifications(
    name: &str,
    gear: &Gear,
    m: &Microgeometry,
    rows: &mut Vec<(String, String)>,
) {
    for (what, relief) in [("tip relief", m.tip_relief), ("root relief", m.root_relief)] {
        let Some(r) = relief else { continue };
        let rolls = [r.start_roll, r.end_roll];
        let [d1, d2] = diameters(gear, rolls);
        let [l1, l2] = rolls.map(|roll| fixed(1e3 * roll, 4));
        let [a1, a2] = rolls.map(|roll| fixed((roll / gear.base_radius()).to_degrees(), 3));
        rows.push((
            format!("{name}: {what}"),
            format!(
                "{} um, {} from diameter {d1} to {d2} mm, roll length {l1} to {l2} mm, roll angle {a1} to {a2} deg",
                um(r.amount),
                shape(r.shape)
            ),
        ));
    }
    if let Some(c) = m.profile_crowning {
        let [from, to] = diameters(gear, c.rolls);
        rows.push((
            format!("{name}: profile crowning"),
            format!(
                "{} um at diameters {from} and {to} mm, parabolic, 0 at mid-roll",
                um(c.amount)
            ),
        ));
    }
    let Some(p) = m.profile_slope else { return };
    if p.amount != 0.0 {
        let [from, to] = diameters(gear, p.rolls);
        let c_ha = um(-p.amount / gear.base_helix_angle().cos());
        rows.push((
            format!("{name}: profile slope"),
            format!(
                "{} um more at diameter {to} than at {from} mm (C_Ha {c_ha} um), linear, 0 at mid-roll",
                um(p.amount)
            ),
        ));
    }
    if p.bias != 0.0 {
        rows.push((
            format!("{name}: bias"),
            format!(
                "{} um more profile slope at the large-z end than at z = 0, 0 at mid-face",
                um(p.bias)
            ),
        ));
    }
}

fn add_lead_modifications(name: &str, m: &Microgeometry, rows: &mut Vec<(String, String)>) {
    if m.lead_crowning != 0.0 {
        rows.push((
            format!("{name}: lead crowning"),
            format!(
                "{} um at both ends of the face, parabolic, 0 at mid-face",
                um(m.lead_crowning)
            ),
        ));
    }
    if m.lead_slope != 0.0 {
        rows.push((
            format!("{name}: lead slope"),
            format!(
                "{} um more at the large-z end than at z = 0, linear, 0 at mid-face",
                um(m.lead_slope)
            ),
        ));
    }
    let ends = match m.end_relief {
        [low, high] if low == high => vec![("end relief, both ends", low)],
        [low, high] => vec![
            ("end relief at z = 0", low),
            ("end relief at the large-z end", high),
        ],
    };
    for (what, relief) in ends {
        let Some(r) = relief else { continue };
        let mm = fixed(1e3 * r.length, 3);
        rows.push((
            format!("{name}: {what}"),
            format!(
                "{} um, {} over the last {mm} mm",
                um(r.amount),
                shape(r.shape)
            ),
        ));
    }
}

/// Diameters at roll lengths, mm.
fn diameters(gear: &Gear, rolls: [f64; 2]) -> [String; 2] {
    rolls.map(|roll| fixed(2e3 * gear.radius_at_roll(roll), 3))
}

fn um(amount: f64) -> String {
    fixed(amount * 1e6, 1)
}

fn shape(shape: ReliefShape) -> String {
    format!("{shape:?}").to_lowercase()
}
