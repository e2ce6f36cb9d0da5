//! What a pair is, in the figures an engineer checks first against the drawing: as text and as JSON.

use gearmesh::gear::{Flank, Gear, GearKind, ProfileSlope, ToothProfile};
use gearmesh::pair::Pair;
use gearmesh::words::{fixed, rounded};
use gearmesh_preprocessor::pair::drawing::{Measure, generating_profile_shift, lead};
use gearmesh_preprocessor::pair::{self, Gauges};
use serde_json::{Value, json};

use crate::columns::{Column, columns, list, object};
use crate::flank_summary::{modifications, tooth_errors, topographies};
use crate::output::{Listing, rows};

/// The pair in text: geometry in mesh, each gear, its modifications, the ranges to be covered.
pub fn pair_summary(pair: &Pair, gauges: [Gauges; 2]) -> String {
    let mut mesh = Listing::default();
    list(&mut mesh, &in_mesh(pair), &());
    let [one, two] = [0, 1].map(|i| gear(pair, i, gauges[i]));
    let (name, operating) = (&pair.name, operating(pair));
    let notes = pair.warnings.iter().map(|note| format!("\nnote: {note}\n"));
    let notes: String = notes.collect();
    format!("{name}\n{mesh}\ngear 1\n{one}\ngear 2\n{two}\noperating\n{operating}{notes}")
}

pub fn as_json(pair: &Pair, gauges: [Gauges; 2]) -> Value {
    let mut all = object(&in_mesh(pair), &());
    for (i, name) in ["gear1", "gear2"].into_iter().enumerate() {
        let mut gear = object(&quantities(pair, i, gauges[i]), &());
        gear.insert("reliefs".into(), reliefs(pair, i));
        all.insert(name.into(), gear.into());
    }
    all.insert("notes".into(), json!(pair.warnings));
    all.into()
}

/// What a build prints of the pair, a line each: tooth thickness, topographies, notes but for that on the teeth.
pub fn at_build(pair: &Pair) -> Vec<String> {
    let mut lines = vec![format!("teeth: {}", thinning(pair))];
    for i in 0..2 {
        let rows = topographies(pair, i).into_iter();
        lines.extend(rows.map(|(name, words)| format!("gear {}, {name}: {words}", i + 1)));
    }
    let notes = pair.warnings.iter().map(String::as_str);
    let notes = notes.filter(|&note| Some(note) != pair::note_on_teeth(&pair.teeth));
    lines.extend(notes.map(|note| format!("note: {note}")));
    lines
}

/// By how much the teeth are thinner than their profile shifts make them.
fn thinning(pair: &Pair) -> String {
    let g = &pair.geometry;
    let cos_phi = g.operating_pressure_angle(g.center_distance).cos();
    let thinned = |i: usize| fixed(g.gears[i].tooth_thinning / cos_phi * 1e6, 1);
    let by = match [0, 1].map(thinned) {
        [first, second] if first == second => format!("each thinned by {first} um"),
        [first, second] => format!("thinned by {first} um on gear 1 and {second} um on gear 2,"),
    };
    by + " at the operating pitch circle, from the thickness without backlash that its profile shift gives"
}

fn in_mesh(pair: &Pair) -> Vec<Column<'_, ()>> {
    let g = &pair.geometry;
    let c = g.center_distance;
    let first = &g.gears[0];
    let transverse = g.transverse_contact_ratio(c);
    let overlap = g.overlap_ratio();
    let phi = g.operating_pressure_angle(c);
    let cos_beta_b = g.base_helix_angle().cos();
    let helix = first.helix_angle.to_degrees();
    let hands = match g.gears.each_ref().map(hand) {
        ["spur", _] => String::new(),
        [one, two] => format!(", gear 1 {one}-handed, gear 2 {two}-handed"),
    };
    let backlash = 1e6 * g.backlash(c);
    columns! { |_: &()|
        "name" => pair.name.clone();
        "", ["meshing", "", None] => g.ring().map_or("external", |_| "internal");
        "normal_module_mm", ["normal module", "mm", 4] => 1e3 * first.normal_module;
        "", ["helix angle at the reference cylinder", "", None] => format!("{helix:.3} deg{hands}");
        "helix_angle_deg" => first.hand * helix;
        "center_distance_mm", ["centre distance", "mm", 4] => 1e3 * c;
        "operating_transverse_pressure_angle_deg", ["operating transverse pressure angle", "deg", 4] => phi.to_degrees();
        "transverse_contact_ratio", ["transverse contact ratio", "", 4] => transverse;
        "overlap_ratio", ["overlap ratio", "", 4] => overlap;
        "", ["total contact ratio", "", 4] => transverse + overlap;
        "", ["common face width", "mm", 3] => 1e3 * g.face_overlap().1;
        "", ["base pitch, transverse", "mm", 4] => 1e3 * g.base_pitch();
        "", ["backlash on the line of action", "um", 1] => backlash;
        "backlash_um", ["backlash at the operating pitch circle", "um", 1] => backlash / phi.cos();
        "normal_backlash_um", ["backlash normal to the flanks j_bn", "um", 1] => backlash * cos_beta_b;
        "", ["teeth", "", None] => thinning(pair);
        "", ["normal force at nominal torque", "N", 1] => pair.operating.nominal_torque / first.base_radius() / cos_beta_b;
    }
}

fn gear(pair: &Pair, i: usize, gauges: Gauges) -> Listing {
    let mesh = &pair.geometry;
    let g = &mesh.gears[i];
    let [ring, held] = match g.kind {
        GearKind::External => ["", "bore (held)"],
        GearKind::Ring if g.foundation.is_some() => [", ring", "rim (on a foundation)"],
        GearKind::Ring => [", ring", "rim (held)"],
    };
    let face = between([g.face_offset, g.face_offset + g.face_width]);
    let active = g.radius_at_roll(mesh.active_start_roll(i, mesh.center_distance));
    let mut rows = Listing::default();
    rows! { rows;
        "teeth" => "{}{ring}", g.teeth;
        "profile shift coefficient" => "{:.4}", g.profile_shift;
        "face" => "{face} in the frame of gear 1";
        "tip diameter" => "{}", diameter(g.tip_radius);
    }
    if g.tip_chamfer > 0.0 {
        rows.row("tip form (chamfer) diameter", diameter(g.tip_form_radius()));
    }
    rows! { rows;
        "operating pitch diameter" => "{}", diameter(mesh.operating_pitch_radius(i, mesh.center_distance));
        "active profile start diameter" => "{}", diameter(active);
    }
    // A pair that was read has passed the checks that generate this profile.
    if let Ok(profile) = ToothProfile::new(g) {
        rows! { rows;
            "involute start diameter" => "{}", diameter(profile.form_radius());
            "tip land" => "{:.4} mm", profile.tip_land() * 1e3;
        }
        if profile.is_undercut() {
            rows.row("undercut", "yes");
        }
    }
    rows! { rows;
        "base diameter" => "{}", diameter(g.base_radius());
        "root diameter" => "{}", diameter(g.root_radius());
    }
    if !g.body.is_some_and(|body| body.is_shaft()) {
        rows.row(format!("{held} diameter"), diameter(g.held_radius));
    }
    list(&mut rows, &quantities(pair, i, gauges), &());
    body(g, &mut rows);
    rows! { rows;
        "material" => "E {:.1} GPa, Poisson ratio {}", g.youngs_modulus * 1e-9, g.poisson_ratio;
    }
    modifications(pair, i, &mut rows);
    tooth_errors(pair, i, &mut rows);
    rows
}

fn hand(gear: &Gear) -> &'static str {
    match (gear.helix_angle > 0.0, gear.hand > 0.0) {
        (false, _) => "spur",
        (true, true) => "right",
        (true, false) => "left",
    }
}

/// Tooth thickness in its four forms and what else a drawing says of gear `i`, as it is computed.
fn quantities(pair: &Pair, i: usize, gauges: Gauges) -> Vec<Column<'_, ()>> {
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
        "teeth" => g.teeth;
        "hand", ["hand", "", None] => hand;
        "lead_mm", ["lead", "mm", 4] => lead;
        "profile_shift" => x;
        "profile_shift_iso_21771", ["profile shift in the sign of ISO 21771", "", 4] => kappa * x;
        "generating_profile_shift", ["generating profile shift, of the tooth thickness", "", 4] => generating;
        "normal_tooth_thickness_mm", ["normal tooth thickness s_n", "mm", 4] => mm(s);
        "span_teeth" => k;
        "span_measurement_mm", [format!("span W_k over {k} {teeth}"), "mm", 4] => span;
        "ball_diameter_mm" => mm(ball);
        "dimension_over_balls_mm", [format!("dimension M_dK {over} balls of {} mm", rounded(1e3 * ball)), "mm", 4] => balls;
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
    let forms = |roll: f64| {
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
                all[name] = json!({ "amount_um": 1e6 * r.amount, "start": forms(r.start_roll), "end": forms(r.end_roll) });
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

fn diameter(radius: f64) -> String {
    format!("{:.4} mm", 2e3 * radius)
}

fn between([low, high]: [f64; 2]) -> String {
    let [width, low, high] = [high - low, low, high].map(|z| fixed(z * 1e3, 3));
    format!("{width} mm wide, z {low} to {high} mm")
}

/// Rim, web, hub and foundation, where the body is no full disc held rigidly.
fn body(g: &Gear, rows: &mut Listing) {
    let z = |z| between(z) + " from the z = 0 face of the gear";
    if let Some(body) = g.body.filter(|body| body.is_shaft()) {
        let ends = ["lower end", "upper end"].into_iter().zip(body.held_ends);
        let held: Vec<&str> = ends.filter_map(|(end, held)| held.then_some(end)).collect();
        rows! { rows;
            "shaft" => "diameters {} and {}, {}", diameter(body.rim_radius), diameter(body.hub_radius), z(body.hub);
            "shaft held at" => "{}", held.join(" and ");
        }
    } else if let Some(body) = g.body {
        let thickness = g.root_radius() - body.rim_radius;
        let [mm, modules] =
            [(1e-3, 3), (g.normal_module, 2)].map(|(unit, d)| fixed(thickness / unit, d));
        rows! { rows;
            "rim" => "{mm} mm ({modules} normal modules) below the root circle, inner diameter {}", diameter(body.rim_radius);
            "web" => "{}", z(body.web);
        }
        if body.hub_radius > g.held_radius {
            rows! { rows; "hub" => "diameter {}, {}", diameter(body.hub_radius), z(body.hub); }
        }
    }
    if let Some(stiffness) = g.foundation {
        rows! { rows; "outside rests on" => "{} N/mm3 in every direction", rounded(stiffness * 1e-9); }
    }
}

fn operating(pair: &Pair) -> Listing {
    let o = &pair.operating;
    let [nominal, most] = [o.nominal_torque, o.maximum_torque].map(rounded);
    let [nearest, farthest] = o.center_distance_offset.map(|offset| rounded(offset * 1e6));
    let [least, largest] = o.misalignment.map(|angle| rounded(angle * 1e3));
    let mut rows = Listing::default();
    rows! { rows;
        "torque on gear 1" => "nominal {nominal} N m, up to {most} N m";
        "centre distance offset" => "{nearest} to {farthest} um";
        "misalignment" => "{least} to {largest} mrad";
        "friction" => "{}", pair.friction;
    }
    rows
}
