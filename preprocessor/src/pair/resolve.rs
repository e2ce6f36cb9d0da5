//! From the file's units and defaults to a [`Pair`] in SI.

use std::path::Path;

use super::checks::check_fields;
use super::drawing::settle;
use super::error::{Refusal, ensure, refusal};
use super::file::{GearFile, Meshing, PairFile};
use super::friction::friction;
use super::mesh_checks::{
    check_center_distances, check_gear, check_tooth_difference, field, warnings,
};
use super::modifications::Flanks;
use super::teeth::teeth;
use super::{Operating, Pair, bodies, slips};
use gearmesh::gear::{
    Flank, Gear, GearKind, PairGeometry, PairMicrogeometry, inverse_involute, involute,
};
use gearmesh::words::{fixed, number, rounded};

pub(super) const MM: f64 = 1e-3;
pub(super) const UM: f64 = 1e-6;

/// A centre distance on a drawing is rounded to a micrometre: one that is short of the backlash-free
/// one by less is taken as that without backlash.
const ROUNDING_OF_CENTER_DISTANCE: f64 = 1e-6;

/// Fills in defaults, checks, converts.
pub(super) fn resolve(file: &PairFile, folder: &Path) -> Result<Pair, Refusal> {
    check_fields(file)?;
    let (file, thinning) = &settle(file)?;
    resolve_checked(file, *thinning, folder)
        .map_err(|refusal| helix_in_radians(file).unwrap_or(refusal))
}

/// The helix angle, where in degrees instead of radians it would fit the centre distance of a pair that is refused.
fn helix_in_radians(file: &PairFile) -> Option<Refusal> {
    let (given, mm) = (file.helix_angle_deg?, file.center_distance_mm?);
    let degrees = slips::degrees(given)?;
    let free = |helix_angle_deg: f64| {
        let other = PairFile {
            helix_angle_deg: Some(helix_angle_deg),
            ..file.clone()
        };
        let geometry = unplaced_gears(&other).ok()?;
        Some(backlash_free_center_distance(&geometry) / MM)
    };
    let (now, then) = (free(given)?, free(given.to_degrees())?);
    let modules = |free: f64| (mm - free).abs() / file.normal_module_mm;
    (modules(then) < 0.25 && modules(then) + 0.05 < modules(now)).then(|| {
        refusal!("helix_angle_deg" => given;
            "asks for a centre distance of {now:.4} mm without backlash, and the file has {mm}";
            "give it in the unit of the name: {degrees}")
    })
}

/// `thinning`: that of the teeth of both gears on the base circle, m, where the drawing has it.
fn resolve_checked(
    file: &PairFile,
    thinning: [Option<f64>; 2],
    folder: &Path,
) -> Result<Pair, Refusal> {
    let mut notes = Vec::new();
    let mut geometry = unplaced_gears(file)?;
    place(file, &mut geometry)?;
    set_backlash(file, &mut geometry, thinning)?;
    shorten_default_ring(file, &mut geometry, &mut notes)?;
    let profiles = [
        check_gear(file, &geometry.gears[0], 0)?,
        check_gear(file, &geometry.gears[1], 1)?,
    ];
    for (i, gear) in geometry.gears.iter_mut().enumerate() {
        bodies::complete(file, gear, i)?;
    }
    notes.extend(check_faces(file, &geometry)?);
    check_torques(file, &geometry)?;
    notes.extend(slips::notes(file, &geometry));
    notes.extend(odd_thickness(file, &geometry));
    notes.extend(warnings(&geometry, &profiles));
    notes.extend(check_center_distances(file, &geometry, &profiles)?);
    check_tooth_difference(&geometry)?;
    let modified = |i, flank| {
        let geometry = &geometry;
        let flanks = Flanks {
            file,
            geometry,
            folder,
            i,
            flank,
        };
        flanks.microgeometry()
    };
    let microgeometry = PairMicrogeometry {
        drive: [modified(0, Flank::Drive)?, modified(1, Flank::Drive)?],
        coast: [modified(0, Flank::Coast)?, modified(1, Flank::Coast)?],
    };
    let (teeth, differ) = teeth(file, &geometry, &microgeometry, folder)?;
    notes.extend(differ);
    Ok(Pair {
        name: file.name.clone(),
        teeth,
        operating: Operating {
            nominal_torque: file.operating.nominal_torque_nm,
            maximum_torque: file.operating.maximum_torque_nm,
            center_distance_offset: file.operating.center_distance_offset_um.map(|v| v * UM),
            misalignment: file.operating.misalignment_mrad.map(|v| v * 1e-3),
        },
        refinement: file.compliance.refinement,
        tip_corner_contact: file.tip_corner_contact,
        friction: friction(file.friction.as_ref())?,
        warnings: notes,
        geometry,
        microgeometry,
    })
}

/// Gear `i` (0 or 1) of the file.
pub(super) fn gear_file(file: &PairFile, i: usize) -> &GearFile {
    if i == 0 { &file.gear1 } else { &file.gear2 }
}

/// Both gears, the centre distance still open.
fn unplaced_gears(file: &PairFile) -> Result<PairGeometry, Refusal> {
    let ring = ring_index(file);
    if let Some(ring) = ring {
        let (teeth, mate) = (gear_file(file, ring).teeth, gear_file(file, 1 - ring).teeth);
        ensure!(teeth > mate, field(ring, "teeth") => teeth;
            "the ring needs more teeth than the gear in it, {mate}";
            "choose a larger tooth difference, or give `rim_diameter_mm` to the other gear");
    }
    Ok(PairGeometry {
        gears: [0, 1].map(|i| gear(file, i, ring == Some(i))),
        center_distance: f64::NAN,
    })
}

/// Sets the centre distance: the file's, or that without backlash.
fn place(file: &PairFile, geometry: &mut PairGeometry) -> Result<(), Refusal> {
    let least = geometry.base_radius_sum();
    let free = backlash_free_center_distance(geometry);
    geometry.center_distance = file.center_distance_mm.map_or(free, |mm| mm * MM);
    let is_mesh = geometry.center_distance > least;
    if let Some(mm) = file.center_distance_mm {
        let meant = slips::length(mm, free / MM);
        let remedy = slips::remedy(
            meant,
            "give it in the unit of the name",
            check_distance(geometry),
        );
        ensure!(is_mesh, "center_distance_mm" => mm;
            "the base circles allow no mesh below {:.4} mm", least / MM; "{remedy}");
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

/// Torques that teeth of the material could carry.
fn check_torques(file: &PairFile, geometry: &PairGeometry) -> Result<(), Refusal> {
    let modulus = geometry.gears.iter().map(|g| g.youngs_modulus);
    let most = slips::IMPOSSIBLE_LOAD * modulus.fold(f64::INFINITY, f64::min);
    let shared = geometry.face_overlap().1;
    let [face1, face2] = geometry.gears.each_ref().map(|g| g.face_width);
    let torques = [
        ("nominal_torque_nm", file.operating.nominal_torque_nm),
        ("maximum_torque_nm", file.operating.maximum_torque_nm),
    ];
    for (name, torque) in torques {
        let load = slips::load(geometry, shared, torque);
        // Whole faces would carry it, or so little is no face.
        let whole = slips::load(geometry, face1.min(face2), torque);
        ensure!(load <= most || (whole > most && shared >= MM * file.normal_module_mm),
            "face_offset_mm" => file.face_offset_mm.unwrap_or(0.0);
            "leaves {} mm of the faces, {} and {} mm wide, in common, too little for `operating.{name}` = {torque}",
            number(rounded(shared / MM)), file.gear1.face_width_mm, file.gear2.face_width_mm;
            "check it, gear 2's z = 0 face minus gear 1's, and both `face_width_mm`, in millimetres");
        let other = "give the torque on gear 1 in N m, or wider faces";
        let remedy = slips::remedy(slips::torque(geometry, torque), "give N m on gear 1", other);
        ensure!(load <= most, format!("operating.{name}") => torque;
            "means {:.0} N per mm of face and mm of module, and no tooth of this material carries above {:.0}",
            load * UM, most * UM;
            "{remedy}");
    }
    Ok(())
}

/// The ring's default tip: where an addendum of one module would run into the pinion's fillet at some
/// centre distance of the range, the ring's teeth are shortened so that contact starts at least 0.02
/// modules of roll above it.
fn shorten_default_ring(
    file: &PairFile,
    geometry: &mut PairGeometry,
    notes: &mut Vec<String>,
) -> Result<(), Refusal> {
    let Some(ring) = geometry.ring() else {
        return Ok(());
    };
    let given = gear_file(file, ring);
    if given.tip_diameter_mm.is_some() || given.addendum_coefficient.is_some() {
        return Ok(());
    }
    let pinion = 1 - ring;
    let form = check_gear(file, &geometry.gears[pinion], pinion)?.form_roll();
    let start = form + 0.02 * geometry.gears[pinion].normal_module;
    let standard = geometry.gears[ring].tip_radius;
    for um in file.operating.center_distance_offset_um {
        let c = geometry.center_distance + um * UM;
        // Not a number where the addendum ends inside the ring's base circle: shortened, too.
        if geometry.active_start_roll(pinion, c) >= start {
            continue;
        }
        let side = if pinion == 0 { 1.0 } else { -1.0 };
        let xi = (start - geometry.roll_at(pinion, c, 0.0)) * side;
        let tip = geometry.gears[ring].radius_at_roll(geometry.roll_at(ring, c, xi));
        geometry.gears[ring].tip_radius = tip;
    }
    let shortened = &mut geometry.gears[ring];
    if shortened.tip_radius != standard {
        if let Some(mm) = given.tip_form_diameter_mm {
            shortened.tip_chamfer = 0.5 * mm * MM - shortened.tip_radius;
        }
        notes.push(format!(
            "gear {}: the tips of the ring are shortened from {:.3} to {:.3} mm diameter to clear the fillets of the \
             pinion; `tip_diameter_mm` says otherwise",
            ring + 1,
            2.0 * standard / MM,
            2.0 * shortened.tip_radius / MM
        ));
    }
    Ok(())
}

/// Faces that share no part are refused; what is said of faces of different width that are flush at one end because
/// nothing else was given, and of those that share less than half of the narrower one.
fn check_faces(file: &PairFile, geometry: &PairGeometry) -> Result<Vec<String>, Refusal> {
    let offset = file.face_offset_mm.unwrap_or(0.0);
    let [b1, b2] = [file.gear1.face_width_mm, file.gear2.face_width_mm];
    let shared = geometry.face_overlap().1 / MM;
    ensure!(shared > 0.0, "face_offset_mm" => offset;
        "the faces, {b1} mm and {b2} mm wide, do not overlap";
        "give gear 2's z = 0 face minus gear 1's, so that the faces share a part");
    let mut notes = Vec::new();
    if b1 != b2 && file.face_offset_mm.is_none() {
        let middle = rounded(0.5 * (b1 - b2));
        notes.push(format!(
            "the faces, {b1} and {b2} mm wide, are flush at z = 0; `face_offset_mm` = {middle} lets them share their middle"
        ));
    }
    if shared < 0.5 * b1.min(b2) {
        let shared = rounded(shared);
        notes.push(format!(
            "`face_offset_mm` = {offset} leaves only {shared} mm of the faces in mesh, {b1} and {b2} mm wide"
        ));
    }
    Ok(notes)
}

/// Which gear is the ring: gear 2 of an internal pair, or gear 1 when it alone has a rim.
pub(super) fn ring_index(file: &PairFile) -> Option<usize> {
    let has_rim = |g: &GearFile| g.rim_diameter_mm.is_some();
    let ring = usize::from(has_rim(&file.gear2) || !has_rim(&file.gear1));
    (file.meshing == Meshing::Internal).then_some(ring)
}

pub(super) fn gear(file: &PairFile, i: usize, is_ring: bool) -> Gear {
    let g = gear_file(file, i);
    let helix_angle = file.helix_angle_deg.unwrap_or(0.0);
    let hand1 = if helix_angle < 0.0 { -1.0 } else { 1.0 };
    // Gear 2 of an external pair has the other hand.
    let is_other = i == 1 && file.meshing == Meshing::External;
    let offset = if i == 0 { None } else { file.face_offset_mm };
    let kind = [GearKind::External, GearKind::Ring][usize::from(is_ring)];
    let mut gear = Gear {
        kind,
        teeth: g.teeth,
        hand: if is_other { -hand1 } else { hand1 },
        normal_module: file.normal_module_mm * MM,
        normal_pressure_angle: file.normal_pressure_angle_deg.to_radians(),
        helix_angle: helix_angle.abs().to_radians(),
        profile_shift: g.profile_shift.unwrap_or(0.0),
        face_width: g.face_width_mm * MM,
        face_offset: offset.unwrap_or(0.0) * MM,
        tip_radius: 0.0,
        dedendum_coefficient: g.dedendum_coefficient.unwrap_or(1.25),
        tool_tip_radius_coefficient: g.tool_tip_radius_coefficient,
        held_radius: 0.0,
        body: None,
        foundation: None,
        tooth_thinning: 0.0,
        tip_chamfer: 0.0,
        youngs_modulus: g.youngs_modulus_gpa * 1e9,
        poisson_ratio: g.poisson_ratio,
    };
    let radius = |diameter_mm: f64| 0.5 * diameter_mm * MM;
    let addendum = gear.kappa() * g.addendum_coefficient.unwrap_or(1.0);
    let tip = gear.reference_radius() + gear.normal_module * (gear.profile_shift + addendum);
    gear.tip_radius = g.tip_diameter_mm.map_or(tip, radius);
    if let Some(mm) = g.tip_form_diameter_mm {
        gear.tip_chamfer = gear.kappa() * (gear.tip_radius - radius(mm));
    }
    let (held, usual) = match gear.kind {
        GearKind::External => (g.bore_diameter_mm, 0.5 * gear.root_radius()),
        GearKind::Ring => {
            let rim = 3.5 * gear.normal_module;
            (g.rim_diameter_mm, gear.root_radius() + rim)
        }
    };
    gear.held_radius = held.map_or(usual, radius);
    gear
}

/// Centre distance at which teeth without thinning mesh without backlash, m. NaN when the shifts allow
/// none.
fn backlash_free_center_distance(geometry: &PairGeometry) -> f64 {
    geometry.base_radius_sum() / inverse_involute(geometry.backlash_free_involute()).cos()
}

/// Thins the teeth as the drawing says, and those of which it does not alike, so that the backlash wanted results.
fn set_backlash(
    file: &PairFile,
    geometry: &mut PairGeometry,
    given: [Option<f64>; 2],
) -> Result<(), Refusal> {
    let c = geometry.center_distance;
    let cos_phi = geometry.operating_pressure_angle(c).cos();
    let cos_b = geometry.base_helix_angle().cos();
    for (gear, given) in geometry.gears.iter_mut().zip(given) {
        gear.tooth_thinning = given.unwrap_or(0.0);
    }
    // On the line of action, that of teeth that are full as far as nothing is known.
    let natural = geometry.backlash(c);
    let circumferential = file.backlash_um.map(|um| um * UM * cos_phi);
    let normal = file.normal_backlash_um.map(|j| j.middle() * UM / cos_b);
    let in_field = |k: usize, backlash: f64| backlash / UM * [1.0 / cos_phi, cos_b][k];
    let [name1, name2] = ["backlash_um", "normal_backlash_um"];
    if let (Some(first), Some(second)) = (circumferential, normal) {
        ensure!((first - second).abs() <= 2.0 * UM, name2 => in_field(1, second);
            "`{name1}` = {} says otherwise", in_field(0, first); "give one of them, or {:.1}", in_field(1, first));
    }
    let k = usize::from(circumferential.is_none());
    let wanted = circumferential.or(normal);
    let name = [name1, name2][k];
    // Beyond half a module it is no backlash, but another centre distance.
    let out_of_place = 0.5 * geometry.gears[0].normal_module * cos_phi;
    ensure!(wanted.is_none_or(|j| (natural - j).abs() <= out_of_place), "center_distance_mm" => c / MM;
        "module, tooth numbers and profile shifts leave a backlash of {:.3} mm there", natural / cos_phi / MM;
        "{}", check_distance(geometry));
    let free = backlash_free_center_distance(geometry);
    let is_rounding = geometry.e() * (free - c) < ROUNDING_OF_CENTER_DISTANCE;
    let Some(wanted) = wanted else {
        ensure!(natural >= 0.0 || is_rounding, "center_distance_mm" => c / MM;
            "the teeth jam by {:.1} um at the operating pitch circle", -natural / cos_phi / UM;
            "give {:.4} or {}, or thin the teeth by `backlash_um`",
            free / MM, if geometry.e() > 0.0 { "more" } else { "less" });
        thin(geometry, given, -natural);
        return Ok(());
    };
    let um = rounded(in_field(k, wanted));
    let thinning = wanted - natural;
    let left = in_field(k, natural);
    if given.iter().all(Option::is_some) {
        let slack = file.normal_backlash_um.map_or(0.0, |j| j.slack()) * UM;
        ensure!(thinning.abs() <= ROUNDING_OF_BACKLASH + slack, name => um;
            "tooth thicknesses and centre distance leave {left:.1} um"; "give {left:.1}, or leave it out");
        return Ok(());
    }
    let other = "give at least that, or change `center_distance_mm` or `profile_shift`";
    let remedy = slips::remedy(
        slips::micrometres(um),
        "give it in the unit of the name",
        other,
    );
    // A billionth of a metre: rounding of the file, no thicker teeth.
    ensure!(thinning >= -1e-9, name => um;
        "centre distance and profile shifts alone give {left:.1} um"; "{remedy}");
    thin(geometry, given, thinning);
    Ok(())
}

/// Backlash that is given beside both tooth thicknesses is rounded, m.
const ROUNDING_OF_BACKLASH: f64 = 5.0 * UM;

/// Thins the teeth, together by `thinning` (m) on the line of action if that is positive: those of gears whose thickness
/// is not `given`, else those of both.
fn thin(geometry: &mut PairGeometry, given: [Option<f64>; 2], thinning: f64) {
    let is_open = given.map(|j| j.is_none());
    let share = match is_open {
        [true, false] | [false, true] => 1.0,
        _ => 0.5,
    };
    for (gear, is_open) in geometry.gears.iter_mut().zip(is_open) {
        if is_open || share == 0.5 {
            gear.tooth_thinning += share * thinning.max(0.0);
        }
    }
}

/// Backlash over the least recommended one, from which on it is out of proportion.
const ODD_BACKLASH: f64 = 3.0;

/// Play that profile shifts lack, in normal modules at the operating pitch circle, from which on it is no rounding of a
/// drawing.
const ODD_SHIFT: f64 = 0.02;

/// Teeth whose thickness does not fit the centre distance.
fn odd_thickness(file: &PairFile, geometry: &PairGeometry) -> Option<String> {
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
        return Some(format!(
            "the profile shifts do not fit the centre distance: x1 {} x2 = {}, and {} leaves no backlash there; \
             {} thins each tooth by {} um, {} um of it to make room",
            if e > 0.0 { "+" } else { "-" },
            fixed(shifts, 3),
            fixed(shifts - excess, 3),
            file.backlash_um
                .map_or("the thickness given".into(), |um| format!(
                    "`backlash_um` = {}",
                    rounded(um)
                )),
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
