//! The quantities by which a drawing describes a gear, for text and JSON.

use gearmesh::gear::{Flank, Gear, GearKind, ProfileSlope, ToothProfile};
use gearmesh::pair::Pair;
use gearmesh_preprocessor::pair::Gauges;
use gearmesh_preprocessor::pair::drawing::{Measure, generating_profile_shift, lead};
use serde_json::{Map, Value, json};

use crate::columns::{Column, columns, object};

/// The hand of the teeth.
pub fn hand(gear: &Gear) -> &'static str {
    match (gear.helix_angle > 0.0, gear.hand > 0.0) {
        (false, _) => "spur",
        (true, true) => "right",
        (true, false) => "left",
    }
}

/// Tooth thickness in its four forms and what else a drawing says of gear `i`. None of the values is that of a tolerance:
/// all belong to the gear as it is computed.
pub fn quantities(pair: &Pair, i: usize, gauges: Gauges) -> Vec<Column<'_, ()>> {
    let mesh = &pair.geometry;
    let g = &mesh.gears[i];
    let mm = |length: f64| (1e3 * length).is_finite().then_some(1e3 * length);
    let s = Measure::Thickness.of(g).unwrap_or(f64::NAN);
    let (k, ball) = (gauges.span_teeth, gauges.ball_diameter);
    let [teeth, over] = match g.kind {
        GearKind::External => ["teeth", "over"],
        GearKind::Ring => ["spaces", "between"],
    };
    let hand = hand(g);
    let span = Measure::Span(k).of(g).and_then(mm);
    let balls = Measure::Balls(ball).of(g).and_then(mm);
    let (lead, x) = (mm(lead(g)), g.profile_shift);
    let (root, base) = (mm(2.0 * g.root_radius()), g.base_radius());
    let generating = generating_profile_shift(g, s);
    let rolls = [
        ToothProfile::new(g).ok().map(|profile| profile.form_roll()),
        Some(mesh.active_start_roll(i, mesh.center_distance)),
        Some(g.tip_form_roll()),
    ];
    let length = rolls.map(|roll| roll.and_then(mm));
    let angle = rolls.map(|roll| roll.map(|roll| (roll / base).to_degrees()));
    let kappa = g.kappa();
    columns! { |_: &()|
        "hand", ["hand", "", None] => hand;
        "lead_mm", ["lead", "mm", 4] => lead;
        "profile_shift" => x;
        "profile_shift_iso_21771", ["profile shift in the sign of ISO 21771", "", 4] => kappa * x;
        "generating_profile_shift", ["generating profile shift, of the tooth thickness", "", 4] => generating;
        "normal_tooth_thickness_mm", ["normal tooth thickness s_n", "mm", 4] => mm(s);
        "span_teeth" => k;
        "span_measurement_mm", [format!("span W_k over {k} {teeth}"), "mm", 4] => span;
        "ball_diameter_mm" => mm(ball);
        "dimension_over_balls_mm", [format!("dimension M_dK {over} balls of {} mm", gearmesh::words::rounded(1e3 * ball)), "mm", 4] => balls;
        "root_diameter_mm" => root;
        "base_diameter_mm" => mm(2.0 * base);
        "tip_diameter_mm" => mm(2.0 * g.tip_radius);
        "involute_start_roll_length_mm", ["roll length at the involute's start", "mm", 4] => length[0];
        "involute_start_roll_angle_deg", ["roll angle there", "deg", 3] => angle[0];
        "active_start_roll_length_mm", ["roll length at the start of the active profile", "mm", 4] => length[1];
        "active_start_roll_angle_deg", ["roll angle there", "deg", 3] => angle[1];
        "tip_form_roll_length_mm", ["roll length at the end of the involute", "mm", 4] => length[2];
        "tip_form_roll_angle_deg", ["roll angle there", "deg", 3] => angle[2];
    }
}

/// Modifications of gear `i`, tip and root relief with start and end in every form of a drawing.
fn reliefs(pair: &Pair, i: usize) -> Value {
    let g = &pair.geometry.gears[i];
    let place = |roll: f64| {
        json!({
            "diameter_mm": 2e3 * g.radius_at_roll(roll), "roll_length_mm": 1e3 * roll,
            "roll_angle_deg": (roll / g.base_radius()).to_degrees(),
            "from_tip_mm": 1e3 * (g.tip_form_roll() - roll).abs(),
        })
    };
    let flank = |flank: Flank| {
        let m = &pair.microgeometry.flank(flank)[i];
        let slope = |p: ProfileSlope| [p.amount, p.bias];
        let [profile_slope, bias] = m.profile_slope.map_or([0.0; 2], slope);
        let mut all = json!({
            "profile_crowning_um": 1e6 * m.profile_crowning.map_or(0.0, |c| c.amount),
            "profile_slope_um": 1e6 * profile_slope, "bias_um": 1e6 * bias,
            "lead_crowning_um": 1e6 * m.lead_crowning, "lead_slope_um": 1e6 * m.lead_slope,
        });
        for (name, relief) in [("tip_relief", m.tip_relief), ("root_relief", m.root_relief)] {
            if let Some(r) = relief {
                all[name] = json!({ "amount_um": 1e6 * r.amount, "start": place(r.start_roll), "end": place(r.end_roll) });
            }
        }
        let [lower, upper] = m.end_relief;
        for (name, relief) in [("lower_end_relief", lower), ("upper_end_relief", upper)] {
            if let Some(r) = relief {
                all[name] = json!({ "amount_um": 1e6 * r.amount, "length_mm": 1e3 * r.length, "shape": r.shape });
            }
        }
        all
    };
    json!({ "drive_flank": flank(Flank::Drive), "coast_flank": flank(Flank::Coast) })
}

/// The pair as JSON: what is in mesh, both gears, notes.
pub fn as_json(pair: &Pair, gauges: [Gauges; 2]) -> Value {
    let mesh = &pair.geometry;
    let c = mesh.center_distance;
    let backlash = 1e6 * mesh.backlash(c);
    let phi = mesh.operating_pressure_angle(c);
    let gear = |i: usize| {
        let g = &mesh.gears[i];
        let mut all = Map::from_iter([("teeth".to_owned(), Value::from(g.teeth))]);
        all.extend(object(&quantities(pair, i, gauges[i]), &()));
        all.insert("reliefs".into(), reliefs(pair, i));
        all
    };
    json!({
        "name": pair.name,
        "normal_module_mm": 1e3 * mesh.gears[0].normal_module,
        "helix_angle_deg": mesh.gears[0].hand * mesh.gears[0].helix_angle.to_degrees(),
        "center_distance_mm": 1e3 * c,
        "operating_transverse_pressure_angle_deg": phi.to_degrees(),
        "transverse_contact_ratio": mesh.transverse_contact_ratio(c),
        "overlap_ratio": mesh.overlap_ratio(),
        "backlash_um": backlash / phi.cos(),
        "normal_backlash_um": backlash * mesh.base_helix_angle().cos(),
        "gear1": gear(0),
        "gear2": gear(1),
        "notes": pair.warnings,
    })
}
