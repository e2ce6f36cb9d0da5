//! What a pair is, in the figures an engineer checks first against the drawing: as text and as JSON.

use gearmesh::gear::{Flank, Gear, GearKind};
use gearmesh::words::{fixed, rounded, significant};
use gearmesh_preprocessor::gear::Pair;
use gearmesh_preprocessor::gear::ToothProfile;
use gearmesh_preprocessor::pair::drawing::{Measure, generating_profile_shift, hand, lead};
use gearmesh_preprocessor::pair::{self, Gauges, modifications, topographies, topography};
use gearmesh_preprocessor::shaft::misalignment_range;
use gearmesh_preprocessor::{NominalContactStress, NominalStiffness};
use serde_json::{Value, json};

use crate::columns::{Column, Listing, columns, list, object, rows};

/// The pair in text: geometry in mesh, each gear, its modifications, the ranges to be covered.
pub fn pair_summary(pair: &Pair, gauges: [Gauges; 2]) -> String {
    let mut mesh = Listing::default();
    list(&mut mesh, &in_mesh(pair), &());
    let [one, two] = [0, 1].map(|i| {
        let mut rows = Listing::default();
        list(&mut rows, &gear(pair, i, gauges[i]), &());
        body(&pair.geometry.gears[i], &mut rows);
        shaft(pair, i, &mut rows);
        for (name, value) in modifications(pair, i) {
            rows.row(name, value);
        }
        tooth_errors(pair, i, &mut rows);
        rows
    });
    let (name, operating) = (&pair.name, operating(pair));
    let notes = pair.warnings.iter().map(|note| format!("\nnote: {note}\n"));
    let notes: String = notes.collect();
    format!("{name}\n{mesh}\ngear 1\n{one}\ngear 2\n{two}\noperating\n{operating}{notes}")
}

pub fn as_json(pair: &Pair, gauges: [Gauges; 2]) -> Value {
    let mut all = object(&in_mesh(pair), &());
    for (i, name) in ["gear1", "gear2"].into_iter().enumerate() {
        let mut gear = object(&gear(pair, i, gauges[i]), &());
        gear.insert("reliefs".into(), reliefs(pair, i));
        all.insert(name.into(), gear.into());
    }
    all.insert("notes".into(), json!(pair.warnings));
    all.into()
}

/// Ends and bearings of the shaft of gear `i`.
fn shaft(pair: &Pair, i: usize, rows: &mut Listing) {
    let Some(shaft) = &pair.shafts[i] else { return };
    let ends = shaft.section_ends();
    let [start, end] = [ends[0], ends[ends.len() - 1]].map(|z| rounded(1e3 * z));
    let bearings = shaft.bearings.iter().map(|b| rounded(1e3 * b.z));
    let places: Vec<String> = bearings.map(|mm| mm.to_string()).collect();
    let side = if shaft.torque_at_upper_end {
        "upper"
    } else {
        "lower"
    };
    rows! { rows;
        "shaft on bearings" => "z {start} to {end} mm, bearings at z {} mm, torque at its {side} end", places.join(", ");
    }
}

/// What a build prints of the pair: tooth thickness, topographies, notes but for that on the teeth.
pub fn at_build(pair: &Pair, rows: &mut Listing) {
    rows.row("teeth", thinning(pair));
    for i in 0..2 {
        for (name, words) in topographies(pair, i) {
            rows.row(format!("gear {}, {name}", i + 1), words);
        }
    }
    let notes = pair.warnings.iter().map(String::as_str);
    for note in notes.filter(|&note| Some(note) != pair::note_on_teeth(&pair.teeth)) {
        rows.row("note", note);
    }
}

/// By how much the teeth are thinner than their profile shifts make them.
fn thinning(pair: &Pair) -> String {
    let g = &pair.geometry;
    let cos_phi = g.operating_pressure_angle(g.center_distance).cos();
    let by = match [0, 1].map(|i| fixed(g.gears[i].tooth_thinning / cos_phi * 1e6, 1)) {
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
    let nominal = pair.operating.nominal_torque;
    let stiffness = NominalStiffness::new(g, nominal);
    let beyond = match stiffness {
        Some(_) => "",
        None => ", which is for x_1 >= x_2 and x_1 + x_2 from -0.5 to 2",
    };
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
        "single_stiffness_iso_6336_n_per_mm_um", [format!("single stiffness c' of ISO 6336-1{beyond}"), "N/(mm um)", 3] => stiffness.map(|s| 1e-9 * s.single);
        "mesh_stiffness_iso_6336_n_per_mm_um", [format!("mesh stiffness c_gamma_alpha of ISO 6336-1{beyond}"), "N/(mm um)", 3] => stiffness.map(|s| 1e-9 * s.mesh);
        "face_mesh_stiffness_iso_6336_n_per_mm_um" => stiffness.map(|s| 1e-9 * s.along_face);
        "sigma_h0_mpa", ["nominal contact stress sigma_H0 of ISO 6336-2", "MPa", 1] => 1e-6 * NominalContactStress::new(&pair.geometry, nominal).stress;
        "", ["normal force at nominal torque", "N", 1] => pair.operating.nominal_torque / first.base_radius() / cos_beta_b;
    }
}

/// What a drawing says of gear `i`, its tooth thickness in four forms, as it is computed.
fn gear(pair: &Pair, i: usize, gauges: Gauges) -> Vec<Column<'_, ()>> {
    let mesh = &pair.geometry;
    let g = &mesh.gears[i];
    let c = mesh.center_distance;
    let [ring, held, teeth, over] = match g.kind {
        GearKind::External => ["", "bore (held) diameter", "teeth", "over"],
        GearKind::Ring if g.foundation.is_some() => [
            ", ring",
            "rim (on a foundation) diameter",
            "spaces",
            "between",
        ],
        GearKind::Ring => [", ring", "rim (held) diameter", "spaces", "between"],
    };
    let is_shaft = g.body.is_some_and(|body| body.is_shaft());
    let profile = ToothProfile::new(g).ok();
    let involute_start = profile.as_ref().and_then(|p| mm(2.0 * p.usable_radius()));
    let tip_land = profile.as_ref().and_then(|p| mm(p.tip_land()));
    let is_undercut = profile.as_ref().is_some_and(|p| p.is_undercut());
    let face = between([g.face_offset, g.face_offset + g.face_width]);
    let s = Measure::Thickness.of(g).unwrap_or(f64::NAN);
    let (k, ball) = (gauges.span_teeth, gauges.ball_diameter);
    let rolls = [
        profile.as_ref().map(|profile| profile.usable_roll()),
        Some(mesh.active_start_roll(i, c)),
        Some(g.tip_form_roll()),
    ];
    let length = rolls.map(|roll| roll.and_then(mm));
    let angle = rolls.map(|roll| roll.map(|roll| (roll / g.base_radius()).to_degrees()));
    columns! { |_: &()|
        "", ["teeth", "", None] => format!("{}{ring}", g.teeth);
        "teeth" => g.teeth;
        "profile_shift", ["profile shift coefficient", "", 4] => g.profile_shift;
        "", ["face", "", None] => format!("{face} in the frame of gear 1");
        "tip_diameter_mm", ["tip diameter", "mm", 4] => mm(2.0 * g.tip_radius);
        "", [head_if(g.tip_chamfer > 0.0, "tip form (chamfer) diameter"), "mm", 4] => mm(2.0 * g.tip_form_radius());
        "", ["operating pitch diameter", "mm", 4] => mm(2.0 * mesh.operating_pitch_radius(i, c));
        "", ["active profile start diameter", "mm", 4] => mm(2.0 * g.radius_at_roll(mesh.active_start_roll(i, c)));
        "", ["involute start diameter", "mm", 4] => involute_start;
        "", ["tip land, transverse", "mm", 4] => tip_land;
        "", [head_if(is_undercut, "undercut"), "", None] => "yes";
        "base_diameter_mm", ["base diameter", "mm", 4] => mm(2.0 * g.base_radius());
        "root_diameter_mm", ["root diameter", "mm", 4] => mm(2.0 * g.root_radius());
        "", [head_if(!is_shaft, held), "mm", 4] => mm(2.0 * g.held_radius);
        "hand", ["hand", "", None] => hand(g);
        "lead_mm", [head_if(g.helix_angle != 0.0, "lead"), "mm", 4] => mm(lead(g));
        "profile_shift_iso_21771", ["profile shift in the sign of ISO 21771", "", 4] => g.kappa() * g.profile_shift;
        "generating_profile_shift", ["generating profile shift, of the tooth thickness", "", 4] => generating_profile_shift(g, s);
        "normal_tooth_thickness_mm", ["normal tooth thickness s_n", "mm", 4] => mm(s);
        "span_teeth" => k;
        "span_measurement_mm", [format!("span W_k over {k} {teeth}"), "mm", 4] => Measure::Span(k).of(g).and_then(mm);
        "ball_diameter_mm" => mm(ball);
        "dimension_over_balls_mm", [format!("dimension M_dK {over} balls of {} mm", rounded(1e3 * ball)), "mm", 4] => Measure::Balls(ball).of(g).and_then(mm);
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
    let [drive, coast] = [Flank::Drive, Flank::Coast].map(|flank| {
        let m = &pair.microgeometry.flank(flank)[i];
        let slope = m.profile_slope;
        let mut all = json!({
            "profile_crowning_um": 1e6 * m.profile_crowning.map_or(0.0, |c| c.amount),
            "profile_slope_um": 1e6 * slope.map_or(0.0, |p| p.amount), "bias_um": 1e6 * slope.map_or(0.0, |p| p.bias),
            "lead_crowning_um": 1e6 * m.lead_crowning, "lead_slope_um": 1e6 * m.lead_slope,
        });
        for (name, relief) in [("tip_relief", m.tip_relief), ("root_relief", m.root_relief)] {
            if let Some(r) = relief {
                all[name] = json!({ "amount_um": 1e6 * r.amount, "start": place(g, r.start_roll), "end": place(g, r.end_roll) });
            }
        }
        let [lower, upper] = m.end_relief;
        for (name, relief) in [("lower_end_relief", lower), ("upper_end_relief", upper)] {
            if let Some(r) = relief {
                all[name] = json!({ "amount_um": 1e6 * r.amount, "length_mm": 1e3 * r.length, "shape": r.shape });
            }
        }
        all
    });
    json!({ "drive_flank": drive, "coast_flank": coast })
}

/// A length of roll (m) on the flank of `g` in every form of a drawing.
fn place(g: &Gear, roll: f64) -> Value {
    json!({
        "diameter_mm": 2e3 * g.radius_at_roll(roll), "roll_length_mm": 1e3 * roll,
        "roll_angle_deg": (roll / g.base_radius()).to_degrees(),
        "from_tip_mm": 1e3 * (g.tip_form_roll() - roll).abs(),
    })
}

/// `head` where the quantity is to stand in the text, too.
fn head_if(is_shown: bool, head: &str) -> &str {
    if is_shown { head } else { "" }
}

/// None where there is no such length.
fn mm(length: f64) -> Option<f64> {
    let mm = 1e3 * length;
    mm.is_finite().then_some(mm)
}

fn diameter_in_words(radius: f64) -> String {
    format!("{:.4} mm", 2e3 * radius)
}

fn between([low, high]: [f64; 2]) -> String {
    let [width, low, high] = [high - low, low, high].map(|z| fixed(z * 1e3, 3));
    format!("{width} mm wide, z {low} to {high} mm")
}

/// Rim, web, hub and foundation, where the body is no full disc held rigidly, and the material.
fn body(g: &Gear, rows: &mut Listing) {
    const FROM_FACE: &str = "from the z = 0 face of the gear";
    if let Some(body) = g.body.filter(|body| body.is_shaft()) {
        let ends = ["lower end", "upper end"].into_iter().zip(body.held_ends);
        let held: Vec<&str> = ends.filter_map(|(end, held)| held.then_some(end)).collect();
        rows! { rows;
            "shaft" => "diameters {} and {}, {} {FROM_FACE}", diameter_in_words(body.rim_radius), diameter_in_words(body.hub_radius), between(body.hub);
            "shaft held at" => "{}", held.join(" and ");
        }
    } else if let Some(body) = g.body {
        let thickness = g.root_radius() - body.rim_radius;
        let mm = fixed(thickness / 1e-3, 3);
        let modules = fixed(thickness / g.normal_module, 2);
        rows! { rows;
            "rim" => "{mm} mm ({modules} normal modules) below the root circle, inner diameter {}", diameter_in_words(body.rim_radius);
            "web" => "{} {FROM_FACE}", between(body.web);
        }
        if body.hub_radius > g.held_radius {
            rows! { rows; "hub" => "diameter {}, {} {FROM_FACE}", diameter_in_words(body.hub_radius), between(body.hub); }
        }
    }
    if let Some(stiffness) = g.foundation {
        rows! { rows; "outside rests on" => "{} N/mm3 in every direction", rounded(stiffness * 1e-9); }
    }
    rows! { rows; "material" => "E {} GPa, Poisson ratio {}", significant(g.youngs_modulus * 1e-9, 4), g.poisson_ratio; }
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
    if let Some(range) = misalignment_range(&pair.geometry, &pair.shafts, o.maximum_torque) {
        let [low, high] = range.map(|angle| rounded(angle * 1e3));
        rows! { rows; "misalignment that the shafts cause" => "{low} to {high} mrad, with a margin"; }
    }
    rows
}

fn tooth_errors(pair: &Pair, i: usize, rows: &mut Listing) {
    for (name, flank) in [("drive flank", Flank::Drive), ("coast flank", Flank::Coast)] {
        let errors = &pair.teeth.flank(flank)[i];
        let ends = [f64::min, f64::max].map(|end| errors.index.iter().copied().reduce(end));
        if let [Some(least), Some(largest)] = ends.map(|end| end.map(um)) {
            rows! { rows; format!("{name}: index errors") => "{least} to {largest} um, > 0 towards the mate"; }
        }
        for own in &errors.flanks {
            let words = topography(&pair.geometry, i, &own.microgeometry).unwrap_or_default();
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

fn um(amount: f64) -> String {
    fixed(amount * 1e6, 1)
}
