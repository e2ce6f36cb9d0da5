//! What a pair is, in the figures an engineer checks first against the drawing.

use std::fmt::Write;

use gearmesh::gear::{Gear, GearKind, ToothProfile};
use gearmesh::pair::Pair;
use gearmesh::words::{fixed, rounded};

use crate::flank_summary::{modifications, tooth_errors};
use crate::output::Listing;

/// The pair in text: geometry in mesh, each gear, its modifications, the ranges to be covered.
pub fn pair_summary(pair: &Pair) -> String {
    let mut text = format!("{}\n", pair.name);
    let _ = write!(text, "{}", in_mesh(pair));
    for i in 0..2 {
        let _ = write!(text, "\ngear {}\n{}", i + 1, gear(pair, i));
    }
    let _ = write!(text, "\noperating\n{}", operating(pair));
    for warning in &pair.warnings {
        let _ = writeln!(text, "\nnote: {warning}");
    }
    text
}

/// Rows on the two gears in mesh.
pub fn in_mesh(pair: &Pair) -> Listing {
    let g = &pair.geometry;
    let c = g.center_distance;
    let transverse = g.transverse_contact_ratio(c);
    let phi = g.operating_pressure_angle(c);
    let loa_force = pair.operating.nominal_torque / g.gears[0].base_radius();
    let mut rows = Listing::default();
    rows.row(
        "meshing",
        if g.ring().is_some() {
            "internal"
        } else {
            "external"
        },
    )
    .row(
        "normal module",
        format!("{:.4} mm", g.gears[0].normal_module * 1e3),
    )
    .row(
        "helix angle at the reference cylinder",
        format!(
            "{:.3} deg{}",
            g.gears[0].helix_angle.to_degrees(),
            match (g.gears[0].helix_angle > 0.0, g.gears[0].hand > 0.0) {
                (false, _) => "",
                (true, true) => ", gear 1 right-handed",
                (true, false) => ", gear 1 left-handed",
            }
        ),
    )
    .row("centre distance", format!("{:.4} mm", c * 1e3))
    .row(
        "operating transverse pressure angle",
        format!("{:.4} deg", phi.to_degrees()),
    )
    .row("transverse contact ratio", format!("{transverse:.4}"))
    .row("overlap ratio", format!("{:.4}", g.overlap_ratio()))
    .row(
        "total contact ratio",
        format!("{:.4}", transverse + g.overlap_ratio()),
    )
    .row(
        "common face width",
        format!("{:.3} mm", g.face_overlap().1 * 1e3),
    )
    .row(
        "base pitch, transverse",
        format!("{:.4} mm", g.base_pitch() * 1e3),
    )
    .row(
        "backlash on the line of action",
        format!("{} um", fixed(g.backlash(c) * 1e6, 1)),
    )
    .row(
        "backlash at the operating pitch circle",
        format!("{} um", fixed(g.backlash(c) / phi.cos() * 1e6, 1)),
    )
    .row(
        "normal force at nominal torque",
        format!("{:.1} N", loa_force / g.base_helix_angle().cos()),
    );
    rows
}

fn gear(pair: &Pair, i: usize) -> Listing {
    let g = &pair.geometry.gears[i];
    let mm = |name: &str, radius: f64, rows: &mut Listing| {
        rows.row(
            format!("{name} diameter"),
            format!("{:.4} mm", 2e3 * radius),
        );
    };
    let mut rows = Listing::default();
    rows.row(
        "teeth",
        match g.kind {
            GearKind::External => format!("{}", g.teeth),
            GearKind::Ring => format!("{}, ring", g.teeth),
        },
    )
    .row(
        "profile shift coefficient",
        format!("{:.4}", g.profile_shift),
    )
    .row(
        "face",
        format!(
            "{} mm wide, z {} to {} mm in the frame of gear 1",
            fixed(g.face_width * 1e3, 3),
            fixed(g.face_offset * 1e3, 3),
            fixed((g.face_offset + g.face_width) * 1e3, 3)
        ),
    );
    mm("tip", g.tip_radius, &mut rows);
    if g.tip_chamfer > 0.0 {
        mm("tip form (chamfer)", g.tip_form_radius(), &mut rows);
    }
    mm(
        "operating pitch",
        pair.geometry
            .operating_pitch_radius(i, pair.geometry.center_distance),
        &mut rows,
    );
    mm(
        "active profile start",
        g.radius_at_roll(
            pair.geometry
                .active_start_roll(i, pair.geometry.center_distance),
        ),
        &mut rows,
    );
    // A pair that was read has passed the checks that generate this profile.
    if let Ok(profile) = ToothProfile::new(g) {
        mm("involute start", profile.form_radius(), &mut rows);
        rows.row("tip land", format!("{:.4} mm", profile.tip_land() * 1e3));
        if profile.is_undercut() {
            rows.row("undercut", "yes");
        }
    }
    mm("base", g.base_radius(), &mut rows);
    mm("root", g.root_radius(), &mut rows);
    mm(
        match g.kind {
            GearKind::External => "bore (held)",
            GearKind::Ring if g.foundation.is_some() => "rim (on a foundation)",
            GearKind::Ring => "rim (held)",
        },
        g.held_radius,
        &mut rows,
    );
    body(g, &mut rows);
    rows.row(
        "material",
        format!(
            "E {:.1} GPa, Poisson ratio {}",
            g.youngs_modulus * 1e-9,
            g.poisson_ratio
        ),
    );
    modifications(pair, i, &mut rows);
    tooth_errors(pair, i, &mut rows);
    rows
}

/// Rim, web, hub and foundation, where the body is no full disc held rigidly.
fn body(g: &Gear, rows: &mut Listing) {
    let z = |z: [f64; 2]| {
        format!(
            "{} mm wide, z {} to {} mm from the z = 0 face of the gear",
            fixed((z[1] - z[0]) * 1e3, 3),
            fixed(z[0] * 1e3, 3),
            fixed(z[1] * 1e3, 3)
        )
    };
    if let Some(body) = g.body {
        let thickness = g.root_radius() - body.rim_radius;
        rows.row(
            "rim",
            format!(
                "{} mm ({} normal modules) below the root circle, inner diameter {:.4} mm",
                fixed(thickness * 1e3, 3),
                fixed(thickness / g.normal_module, 2),
                2e3 * body.rim_radius
            ),
        )
        .row("web", z(body.web));
        if body.hub_radius > g.held_radius {
            rows.row(
                "hub",
                format!("diameter {:.4} mm, {}", 2e3 * body.hub_radius, z(body.hub)),
            );
        }
    }
    if let Some(stiffness) = g.foundation {
        rows.row(
            "outside rests on",
            format!("{} N/mm3 in every direction", rounded(stiffness * 1e-9)),
        );
    }
}

fn operating(pair: &Pair) -> Listing {
    let o = &pair.operating;
    let mut rows = Listing::default();
    rows.row(
        "torque on gear 1",
        format!(
            "nominal {} N m, up to {} N m",
            rounded(o.nominal_torque),
            rounded(o.maximum_torque)
        ),
    )
    .row(
        "centre distance offset",
        format!(
            "{} to {} um",
            rounded(o.center_distance_offset[0] * 1e6),
            rounded(o.center_distance_offset[1] * 1e6)
        ),
    )
    .row(
        "misalignment",
        format!(
            "{} to {} mrad",
            rounded(o.misalignment[0] * 1e3),
            rounded(o.misalignment[1] * 1e3)
        ),
    )
    .row("friction", pair.friction.to_string());
    rows
}
