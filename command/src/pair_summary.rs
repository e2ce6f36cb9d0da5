//! What a pair is, in the figures an engineer checks first against the drawing.

use gearmesh_preprocessor::pair::{self, Gauges};
use std::fmt::Write;

use gearmesh::gear::{Gear, GearKind, ToothProfile};
use gearmesh::pair::Pair;
use gearmesh::words::{fixed, rounded};

use crate::columns;
use crate::drawing::{hand, quantities};
use crate::flank_summary::{modifications, tooth_errors, topographies};
use crate::output::{Listing, rows};

/// The pair in text: geometry in mesh, each gear, its modifications, the ranges to be covered.
pub fn pair_summary(pair: &Pair, gauges: [Gauges; 2]) -> String {
    let mut text = format!("{}\n", pair.name);
    let _ = write!(text, "{}", in_mesh(pair));
    for (i, gauges) in gauges.into_iter().enumerate() {
        let _ = write!(text, "\ngear {}\n{}", i + 1, gear(pair, i, gauges));
    }
    let _ = write!(text, "\noperating\n{}", operating(pair));
    for warning in &pair.warnings {
        let _ = writeln!(text, "\nnote: {warning}");
    }
    text
}

/// What a build prints of the pair, one line each: thickness of the teeth, topographies, and what is worth knowing but for the
/// differences between teeth.
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
    let [first, second] = g
        .gears
        .each_ref()
        .map(|g| fixed(g.tooth_thinning / cos_phi * 1e6, 1));
    let by = match first == second {
        true => format!("each thinned by {first} um"),
        false => format!("thinned by {first} um on gear 1 and {second} um on gear 2,"),
    };
    format!(
        "{by} at the operating pitch circle, from the thickness without backlash that its profile shift gives"
    )
}

/// Rows on the two gears in mesh.
pub fn in_mesh(pair: &Pair) -> Listing {
    let g = &pair.geometry;
    let c = g.center_distance;
    let transverse = g.transverse_contact_ratio(c);
    let overlap = g.overlap_ratio();
    let phi = g.operating_pressure_angle(c);
    let loa_force = pair.operating.nominal_torque / g.gears[0].base_radius();
    let hand = match g.gears.each_ref().map(hand) {
        ["spur", _] => String::new(),
        [one, two] => format!(", gear 1 {one}-handed, gear 2 {two}-handed"),
    };
    let meshing = g.ring().map_or("external", |_| "internal");
    let backlash = |share: f64| fixed(g.backlash(c) * share * 1e6, 1);
    let mut rows = Listing::default();
    rows! { rows;
        "meshing" => "{meshing}";
        "normal module" => "{:.4} mm", g.gears[0].normal_module * 1e3;
        "helix angle at the reference cylinder" => "{:.3} deg{hand}", g.gears[0].helix_angle.to_degrees();
        "centre distance" => "{:.4} mm", c * 1e3;
        "operating transverse pressure angle" => "{:.4} deg", phi.to_degrees();
        "transverse contact ratio" => "{transverse:.4}";
        "overlap ratio" => "{overlap:.4}";
        "total contact ratio" => "{:.4}", transverse + overlap;
        "common face width" => "{:.3} mm", g.face_overlap().1 * 1e3;
        "base pitch, transverse" => "{:.4} mm", g.base_pitch() * 1e3;
        "backlash on the line of action" => "{} um", backlash(1.0);
        "backlash at the operating pitch circle" => "{} um", backlash(1.0 / phi.cos());
        "backlash normal to the flanks j_bn" => "{} um", backlash(g.base_helix_angle().cos());
        "teeth" => "{}", thinning(pair);
        "normal force at nominal torque" => "{:.1} N", loa_force / g.base_helix_angle().cos();
    }
    rows
}

fn gear(pair: &Pair, i: usize, gauges: Gauges) -> Listing {
    let mesh = &pair.geometry;
    let g = &mesh.gears[i];
    let ring = if g.kind == GearKind::Ring {
        ", ring"
    } else {
        ""
    };
    let held = match g.kind {
        GearKind::External => "bore (held)",
        GearKind::Ring if g.foundation.is_some() => "rim (on a foundation)",
        GearKind::Ring => "rim (held)",
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
    columns::list(&mut rows, &quantities(pair, i, gauges), &());
    body(g, &mut rows);
    rows! { rows;
        "material" => "E {:.1} GPa, Poisson ratio {}", g.youngs_modulus * 1e-9, g.poisson_ratio;
    }
    modifications(pair, i, &mut rows);
    tooth_errors(pair, i, &mut rows);
    rows
}

fn diameter(radius: f64) -> String {
    format!("{:.4} mm", 2e3 * radius)
}

/// Width and ends of a range of z, m.
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
