//! Centre distance and backlash: how far the gears stand apart, and by how much their teeth are thinned.

use super::checks::{Refusal, about, ensure, remedy};
use super::file::{MM, PairFile, UM};
use gearmesh::gear::{PairGeometry, inverse_involute, involute};
use gearmesh::words::{fixed, rounded};

/// A centre distance on a drawing is rounded to a micrometre: one that is short of the backlash-free
/// one by less is taken as that without backlash.
const ROUNDING_OF_CENTER_DISTANCE: f64 = 1e-6;
/// Backlash that is given beside both tooth thicknesses is rounded, m.
const ROUNDING_OF_BACKLASH: f64 = 5.0 * UM;

/// Sets the centre distance: the file's, or that without backlash.
pub(super) fn set_center_distance(
    file: &PairFile,
    geometry: &mut PairGeometry,
) -> Result<(), Refusal> {
    let least = geometry.base_radius_sum();
    let free = backlash_free_center_distance(geometry);
    geometry.center_distance = file.center_distance_mm.map_or(free, |mm| mm * MM);
    let is_mesh = geometry.center_distance > least;
    if let Some(mm) = file.center_distance_mm {
        let name = "center_distance_mm";
        let remedy = remedy(name, mm, about(free / MM), &check_distance(geometry));
        ensure!(is_mesh, name => mm; "the base circles allow no mesh below {:.4} mm", least / MM; "{remedy}");
    }
    ensure!(is_mesh, "gear1.profile_shift" => geometry.gears[0].profile_shift;
        "the profile shifts of both gears leave no centre distance without backlash";
        "choose a larger sum of profile shifts (internal: gear 2's minus gear 1's for a ring as gear 2), or give \
         `center_distance_mm`");
    Ok(())
}

/// What to compare a centre distance with that does not fit.
fn check_distance(geometry: &PairGeometry) -> String {
    format!(
        "check it against module, tooth numbers and profile shifts, which ask for {:.4} mm without backlash",
        backlash_free_center_distance(geometry) / MM
    )
}

/// Centre distance at which teeth without thinning mesh without backlash, m. NaN when the shifts allow none.
fn backlash_free_center_distance(geometry: &PairGeometry) -> f64 {
    geometry.base_radius_sum() / inverse_involute(geometry.backlash_free_involute()).cos()
}

/// Thins the teeth of which the drawing does not give the thickness, alike, so that the backlash of the file results.
pub(super) fn set_backlash(file: &PairFile, geometry: &mut PairGeometry) -> Result<(), Refusal> {
    let given = [0, 1].map(|i| file.gear(i).has_thickness());
    let c = geometry.center_distance;
    let cos_phi = geometry.operating_pressure_angle(c).cos();
    let cos_b = geometry.base_helix_angle().cos();
    // On the line of action, that of teeth that are full as far as nothing is known.
    let natural = geometry.backlash(c);
    // What both fields ask for on the line of action.
    let circumferential = file.backlash_um.map(|um| um * UM * cos_phi);
    let normal = file.normal_backlash_um.map(|j| j.middle() * UM / cos_b);
    if let (Some(first), Some(second)) = (circumferential, normal) {
        ensure!((first - second).abs() <= 2.0 * UM, "normal_backlash_um" => second / UM * cos_b;
            "`backlash_um` = {} says otherwise", rounded(first / UM / cos_phi);
            "give one of them, or {:.1}", first / UM * cos_b);
    }
    // Field, backlash on the line of action, and the number of the field for one metre there.
    let wanted = match (circumferential, normal) {
        (Some(j), _) => Some(("backlash_um", j, 1.0 / cos_phi)),
        (None, j) => j.map(|j| ("normal_backlash_um", j, cos_b)),
    };
    // Beyond half a module it is no backlash, but another centre distance.
    let out_of_place = 0.5 * geometry.gears[0].normal_module * cos_phi;
    ensure!(wanted.is_none_or(|(_, j, _)| (natural - j).abs() <= out_of_place), "center_distance_mm" => c / MM;
        "module, tooth numbers and profile shifts leave a backlash of {:.3} mm there", natural / cos_phi / MM;
        "{}", check_distance(geometry));
    let Some((name, wanted, scale)) = wanted else {
        let free = backlash_free_center_distance(geometry);
        let is_rounding = geometry.e() * (free - c) < ROUNDING_OF_CENTER_DISTANCE;
        ensure!(natural >= 0.0 || is_rounding, "center_distance_mm" => c / MM;
            "the teeth jam by {:.1} um at the operating pitch circle", -natural / cos_phi / UM;
            "give {:.4} or {}, or thin the teeth by `backlash_um`",
            free / MM, if geometry.e() > 0.0 { "more" } else { "less" });
        thin(geometry, given, -natural);
        return Ok(());
    };
    let [um, left] = [rounded(wanted / UM * scale), natural / UM * scale];
    let thinning = wanted - natural;
    if given == [true; 2] {
        let slack = file.normal_backlash_um.map_or(0.0, |j| j.slack()) * UM;
        ensure!(thinning.abs() <= ROUNDING_OF_BACKLASH + slack, name => um;
            "tooth thicknesses and centre distance leave {left:.1} um"; "give {left:.1}, or leave it out");
        return Ok(());
    }
    let otherwise = "give at least that, or change `center_distance_mm` or `profile_shift`";
    let remedy = remedy(name, um, [left, f64::INFINITY], otherwise);
    // A billionth of a metre: rounding of the file, no thicker teeth.
    ensure!(thinning >= -1e-9, name => um;
        "centre distance and profile shifts alone give {left:.1} um"; "{remedy}");
    thin(geometry, given, thinning);
    Ok(())
}

/// Thins the teeth, together by `thinning` (m) on the line of action if that is positive: those of gears whose thickness
/// is not `given`, else those of both.
fn thin(geometry: &mut PairGeometry, given: [bool; 2], thinning: f64) {
    let both = given[0] == given[1];
    let share = if both { 0.5 } else { 1.0 };
    for (gear, given) in geometry.gears.iter_mut().zip(given) {
        if !given || both {
            gear.tooth_thinning += share * thinning.max(0.0);
        }
    }
}

/// Backlash over the least recommended one, from which on it is out of proportion.
const ODD_BACKLASH: f64 = 3.0;

/// Play that profile shifts lack, in normal modules at the operating pitch circle, from which on it is no rounding of a
/// drawing.
const ODD_SHIFT: f64 = 0.02;

/// A note on teeth whose thickness does not fit the centre distance.
pub(super) fn odd_thickness(file: &PairFile, geometry: &PairGeometry) -> Option<String> {
    let (c, gears) = (geometry.center_distance, &geometry.gears);
    let module = gears[0].normal_module;
    let phi = geometry.operating_pressure_angle(c);
    let um = |length: f64| fixed(length / UM, 0);
    let thinned = (gears[0].tooth_thinning + gears[1].tooth_thinning) / phi.cos();
    let lacking = thinned - geometry.backlash(c) / phi.cos();
    if lacking > ODD_SHIFT * module {
        let e = geometry.e();
        let shifts = gears[0].profile_shift + e * gears[1].profile_shift;
        let excess = (geometry.backlash_free_involute() - involute(phi))
            * (gears[0].z() + e * gears[1].z())
            / (2.0 * gears[0].normal_pressure_angle.tan());
        let cause = match file.backlash_um {
            Some(um) => format!("`backlash_um` = {}", rounded(um)),
            None => "the thickness given".into(),
        };
        return Some(format!(
            "the profile shifts do not fit the centre distance: x1 {} x2 = {}, and {} leaves no backlash there; \
             {cause} thins each tooth by {} um, {} um of it to make room",
            if e > 0.0 { "+" } else { "-" },
            fixed(shifts, 3),
            fixed(shifts - excess, 3),
            um(0.5 * thinned),
            um(0.5 * lacking)
        ));
    }
    let normal = geometry.backlash(c) * geometry.base_helix_angle().cos();
    // ISO/TR 10064-2, annex A, for drives of steel in steel housings.
    let recommended = 2.0 / 3.0 * (60.0 * UM + 0.0005 * c + 0.03 * module);
    (normal > ODD_BACKLASH * recommended).then(|| {
        format!(
            "the backlash normal to the flanks, {} um, is out of proportion: ISO/TR 10064-2 recommends {} um at least \
             for this module and centre distance; check `center_distance_mm`, `profile_shift` and `backlash_um`",
            um(normal),
            um(recommended)
        )
    })
}
