//! From the file's units and defaults to a [`Pair`] in SI.

use std::path::Path;

use super::backlash::{odd_thickness, place, set_backlash};
use super::checks::{
    self, LEAST_HELIX, about, check_fields, in_gear, limits, meant, remedy, suspicious,
};
use super::drawing::settle;
use super::error::{Refusal, ensure, refusal};
use super::file::{FrictionFile, FrictionLawFile, MM, PairFile, UM};
use super::flanks::Flanks;
use super::gears::{add_body, gear};
use super::mesh::{check_center_distances, check_gear, check_tooth_difference, warnings};
use super::teeth::tooth_errors;
use gearmesh::friction::FrictionLaw;
use gearmesh::gear::{Flank, PairGeometry, PairMicrogeometry, PairTeeth};
use gearmesh::pair::{Operating, Pair};
use gearmesh::words::{number, rounded};

/// Fills in defaults, checks, converts. Files that the file names are sought in `folder`.
pub(super) fn resolve(file: &PairFile, folder: &Path) -> Result<Pair, Refusal> {
    check_fields(file)?;
    let (file, thinning) = &settle(file)?;
    resolve_checked(file, *thinning, folder).map_err(|refusal| {
        // A helix angle in radians spoils anything.
        let given = file.helix_angle_deg.unwrap_or(0.0);
        match suspicious("helix_angle_deg", given, LEAST_HELIX) {
            Some(meant) => refusal!("helix_angle_deg" => given;
                "fits nothing (`{}` = {}: {})", refusal.field, refusal.value, refusal.problem; "check it: {meant}"),
            None => refusal,
        }
    })
}

/// `thinning`: that of the teeth of both gears on the base circle, m, where the drawing has it.
fn resolve_checked(
    file: &PairFile,
    thinning: [Option<f64>; 2],
    folder: &Path,
) -> Result<Pair, Refusal> {
    let mut notes = Vec::new();
    if let Some(ring) = file.ring() {
        let (teeth, mate) = (file.gear(ring).teeth, file.gear(1 - ring).teeth);
        ensure!(teeth > mate, in_gear(ring, "teeth") => teeth;
            "the ring needs more teeth than the gear in it, {mate}";
            "choose a larger tooth difference, or give `rim_diameter_mm` to the other gear");
    }
    let mut geometry = PairGeometry {
        gears: [gear(file, 0), gear(file, 1)],
        center_distance: f64::NAN,
    };
    place(file, &mut geometry)?;
    set_backlash(file, &mut geometry, thinning)?;
    notes.extend(shorten_default_ring(file, &mut geometry)?);
    let [a, b] = &geometry.gears;
    let profiles = [check_gear(file, a, 0)?, check_gear(file, b, 1)?];
    for (i, gear) in geometry.gears.iter_mut().enumerate() {
        add_body(file.gear(i), gear, i)?;
    }
    notes.extend(check_faces(file, &geometry)?);
    notes.extend(check_torques(file, &geometry)?);
    notes.extend(checks::notes(file));
    notes.extend((0..2).filter_map(|i| small_bore(&geometry, i)));
    notes.extend(odd_thickness(file, &geometry));
    notes.extend(warnings(&geometry, &profiles));
    notes.extend(check_center_distances(file, &geometry, &profiles)?);
    check_tooth_difference(&geometry)?;
    let flanks = [0, 1].map(|i| Flanks {
        file,
        geometry: &geometry,
        folder,
        i,
    });
    let [a, b] = &flanks;
    let modified = |flank| Ok([a.microgeometry(flank)?, b.microgeometry(flank)?]);
    let microgeometry = PairMicrogeometry {
        drive: modified(Flank::Drive)?,
        coast: modified(Flank::Coast)?,
    };
    let errors = |flank| {
        let [m1, m2] = microgeometry.flank(flank);
        Ok([tooth_errors(a, flank, m1)?, tooth_errors(b, flank, m2)?])
    };
    let teeth = PairTeeth {
        drive: errors(Flank::Drive)?,
        coast: errors(Flank::Coast)?,
    };
    notes.extend(note_on_teeth(&teeth).map(str::to_owned));
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

/// What is to be known of results that take all `teeth` as alike; `None` where they are. It is one of the [`Pair::warnings`],
/// too.
pub fn note_on_teeth(teeth: &PairTeeth) -> Option<&'static str> {
    let text = "the teeth differ (`tooth_errors`): solve, report, study and tables take them as all alike, with the nominal flanks; \
                `stiffnessModel = teeth` of an FMU built with --teeth takes index errors and run-out, `contact` of one built with \
                --contact all of them";
    (!teeth.are_alike()).then_some(text)
}

/// Line load per module (Pa) that is odd where it is less on steel teeth, which carry some hundred times as much, and
/// beyond all materials.
const USUAL_LOADS: [f64; 2] = [0.3e6, 1e9];
/// No material carries a line load per module above this share of its Young's modulus: the root stress is three
/// times as high.
const IMPOSSIBLE_LOAD: f64 = 0.02;

/// Refuses torques that no teeth of the material could carry; a note where hardly any load is.
fn check_torques(file: &PairFile, geometry: &PairGeometry) -> Result<Option<String>, Refusal> {
    let [gear, mate] = &geometry.gears;
    let modulus = gear.youngs_modulus.min(mate.youngs_modulus);
    let most = IMPOSSIBLE_LOAD * modulus;
    let shared = geometry.face_overlap().1;
    // Torque on gear 1 under which the line load per module is one pascal over `width` of the face.
    let per_load = |width: f64| gear.base_radius() * width * gear.normal_module;
    let o = &file.operating;
    let (nominal, maximum) = (o.nominal_torque_nm, o.maximum_torque_nm);
    let torques = [
        ("nominal_torque_nm", nominal),
        ("maximum_torque_nm", maximum),
    ];
    for (name, torque) in torques {
        let load = torque / per_load(shared);
        // Whole faces would carry it, or so little is no face.
        let whole = torque / per_load(gear.face_width.min(mate.face_width));
        ensure!(load <= most || (whole > most && shared >= MM * file.normal_module_mm),
            "face_offset_mm" => file.face_offset_mm.unwrap_or(0.0);
            "leaves {} mm of the faces, {} and {} mm wide, in common, too little for `operating.{name}` = {torque}",
            number(rounded(shared / MM)), file.gear1.face_width_mm, file.gear2.face_width_mm;
            "check it, gear 2's z = 0 face minus gear 1's, and both `face_width_mm`, in millimetres");
        let usual = USUAL_LOADS.map(|load| load * per_load(shared));
        let otherwise = "give the torque on gear 1 in N m, or wider faces";
        let remedy = remedy(name, torque, usual, otherwise);
        ensure!(load <= most, format!("operating.{name}") => torque;
            "means {:.0} N per mm of face and mm of module, and no tooth of this material carries above {:.0}",
            load * UM, most * UM;
            "{remedy}");
    }
    let least = USUAL_LOADS[0] * modulus / 206e9 * per_load(shared);
    let name = "operating.nominal_torque_nm";
    Ok(checks::note(name, o.nominal_torque_nm, least))
}

/// A note on a bore that is no more than a pin hole.
fn small_bore(geometry: &PairGeometry, i: usize) -> Option<String> {
    let gear = &geometry.gears[i];
    let [mm, root] = [gear.held_radius, gear.root_radius()].map(|radius| 2e3 * radius);
    let (name, mm) = (in_gear(i, "bore_diameter_mm"), rounded(mm));
    let other = "give the diameter of the hub at which the gear is held, or `shaft` if its teeth are cut from one";
    let meant = meant(&name, mm, about(0.5 * root)).unwrap_or_else(|| other.into());
    (gear.body.is_none() && mm < 0.02 * root)
        .then(|| format!("`{name}` = {mm} is a suspicious value: {meant}"))
}

/// The ring's default tip: where an addendum of one module would run into the pinion's fillet at some
/// centre distance of the range, the ring's teeth are shortened so that contact starts at least 0.02
/// modules of roll above it. A note if they are.
fn shorten_default_ring(
    file: &PairFile,
    geometry: &mut PairGeometry,
) -> Result<Option<String>, Refusal> {
    let is_default = |i: &usize| {
        file.gear(*i).tip_diameter_mm.is_none() && file.gear(*i).addendum_coefficient.is_none()
    };
    let Some(ring) = geometry.ring().filter(is_default) else {
        return Ok(None);
    };
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
    if shortened.tip_radius == standard {
        return Ok(None);
    }
    if let Some(mm) = file.gear(ring).tip_form_diameter_mm {
        shortened.tip_chamfer = 0.5 * mm * MM - shortened.tip_radius;
    }
    Ok(Some(format!(
        "gear {}: the tips of the ring are shortened from {:.3} to {:.3} mm diameter to clear the fillets of the pinion; \
         `tip_diameter_mm` says otherwise",
        ring + 1,
        2.0 * standard / MM,
        2.0 * shortened.tip_radius / MM
    )))
}

/// Faces that share no part are refused; notes on faces of different width that are flush at one end because
/// nothing else was given, and on those that share less than half of the narrower one.
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
        notes.push(format!("the faces, {b1} and {b2} mm wide, are flush at z = 0; `face_offset_mm` = {middle} lets them share their middle"));
    }
    if shared < 0.5 * b1.min(b2) {
        let shared = rounded(shared);
        notes.push(format!("`face_offset_mm` = {offset} leaves only {shared} mm of the faces in mesh, {b1} and {b2} mm wide"));
    }
    Ok(notes)
}

/// X_L of a mineral gear oil: see [`FrictionLaw::Schlenk`].
const MINERAL_OIL: f64 = 0.846;

/// The law of friction that `file` gives, or the default.
pub(super) fn friction(file: Option<&FrictionFile>) -> Result<FrictionLaw, Refusal> {
    let Some(file) = file else {
        return Ok(FrictionLaw::default());
    };
    limits! { "friction.", file;
        coefficient: [0.0, 1.0];
        dynamic_viscosity_mpa_s: [1.01, 1e5];
        lubricant_factor: [0.1, 2.0];
    }
    for ra in file.roughness_ra_um.into_iter().flatten() {
        checks::check("friction.roughness_ra_um", ra, [0.01, 20.0])?;
    }
    if file.law == FrictionLawFile::Constant {
        let constant = |coefficient| FrictionLaw::Constant { coefficient };
        return Ok(file.coefficient.map(constant).unwrap_or_default());
    }
    let missing = |name: &str, remedy: &str| {
        refusal!(format!("friction.{name}") => "none";
            "this law asks for it"; "{remedy}, or leave `law` at `constant`")
    };
    let viscosity = file.dynamic_viscosity_mpa_s.ok_or_else(|| {
        let remedy = "give the dynamic viscosity at the temperature of the oil";
        missing("dynamic_viscosity_mpa_s", remedy)
    })?;
    let ra = (file.roughness_ra_um)
        .ok_or_else(|| missing("roughness_ra_um", "give Ra of both gears as a list of two"))?;
    let (viscosity, ra) = (1e-3 * viscosity, ra.map(|ra| ra * UM));
    Ok(match file.law {
        FrictionLawFile::XuKahraman => FrictionLaw::xu_kahraman(viscosity, ra),
        _ => FrictionLaw::schlenk(viscosity, ra, file.lubricant_factor.unwrap_or(MINERAL_OIL)),
    })
}
