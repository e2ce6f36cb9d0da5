//! What can only be said of the gears as built and of the pair in mesh.

use super::checks::{Refusal, ensure, in_gear, note, refusal, remedy};
use super::file::{MM, PairFile, UM, radius_of};
use super::gears::{self, tip_field, usual_tip_radius};
use super::temperature;
use crate::gear::ToothProfile;
use gearmesh::contact::STIFFNESS_OVER_MODULUS;
use gearmesh::gear::{Gear, GearKind, PairGeometry, involute};
use gearmesh::words::{number, rounded};

/// The ring's default tip: where an addendum of one module would run into the pinion's fillet at some
/// centre distance of the range, the ring's teeth are shortened so that contact starts at least 0.02
/// modules of roll above it. A note if they are.
pub(super) fn shorten_default_ring(
    file: &PairFile,
    geometry: &mut PairGeometry,
) -> Result<Option<String>, Refusal> {
    let Some(ring) = geometry
        .ring()
        .filter(|ring| file.gear(*ring).has_default_tip())
    else {
        return Ok(None);
    };
    let pinion = 1 - ring;
    let form = gears::profile(file, &geometry.gears[pinion], pinion)?.usable_roll();
    let start = form + 0.02 * geometry.gears[pinion].normal_module;
    let standard = geometry.gears[ring].tip_radius;
    for um in file.operating.center_distance_offset_um {
        let c = geometry.center_distance + um * UM;
        // Not a number where the addendum ends inside the ring's base circle: shortened, too.
        if geometry.active_start_roll(pinion, c) >= start {
            continue;
        }
        let xi = geometry.distance_at_roll(pinion, c, start);
        let tip = geometry.gears[ring].radius_at_roll(geometry.roll_at(ring, c, xi));
        geometry.gears[ring].tip_radius = tip;
    }
    let shortened = &mut geometry.gears[ring];
    if shortened.tip_radius == standard {
        return Ok(None);
    }
    if let Some(mm) = file.gear(ring).tip_form_diameter_mm {
        shortened.tip_chamfer = radius_of(mm) - shortened.tip_radius;
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
pub(super) fn check_faces(
    file: &PairFile,
    geometry: &PairGeometry,
) -> Result<Vec<String>, Refusal> {
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

/// Line load per module (Pa) that is odd where it is less on steel teeth, which carry some hundred times as much, and
/// beyond all materials.
const USUAL_LOADS: [f64; 2] = [0.3e6, 1e9];
/// No material carries a line load per module above this share of its Young's modulus: the root stress is three
/// times as high.
const IMPOSSIBLE_LOAD: f64 = 0.02;

/// Refuses torques that no teeth of the material could carry; notes where hardly any load is, and where teeth deflect so far that
/// linear elasticity ends.
pub(super) fn check_torques(
    file: &PairFile,
    geometry: &PairGeometry,
) -> Result<Vec<String>, Refusal> {
    let [gear, mate] = &geometry.gears;
    let modulus = gear.youngs_modulus.min(mate.youngs_modulus);
    let most = IMPOSSIBLE_LOAD * modulus;
    let shared = geometry.face_overlap().1;
    // Torque on gear 1 under which the line load per module is one pascal over `width` of the face.
    let per_load = |width: f64| gear.base_radius() * width * gear.normal_module;
    let (nominal, maximum) = (
        file.operating.nominal_torque_nm,
        file.operating.maximum_torque_nm,
    );
    for (kind, torque) in [("nominal", nominal), ("maximum", maximum)] {
        let name = format!("operating.{kind}_torque_nm");
        let load = torque / per_load(shared);
        // Whole faces would carry it, or so little is no face.
        let whole = torque / per_load(gear.face_width.min(mate.face_width));
        ensure!(load <= most || (whole > most && shared >= MM * file.normal_module_mm),
            "face_offset_mm" => file.face_offset_mm.unwrap_or(0.0);
            "leaves {} mm of the faces, {} and {} mm wide, in common, too little for `{name}` = {torque}",
            number(rounded(shared / MM)), file.gear1.face_width_mm, file.gear2.face_width_mm;
            "check it, gear 2's z = 0 face minus gear 1's, and both `face_width_mm`, in millimetres");
        let usual = USUAL_LOADS.map(|load| load * per_load(shared));
        let otherwise = "give the torque on gear 1 in N m, or wider faces";
        let remedy = remedy(&name, torque, usual, otherwise);
        ensure!(load <= most, name => torque;
            "means {:.0} N per mm of face and mm of module, and no tooth of this material carries above {:.0}",
            load * UM, most * UM;
            "{remedy}");
    }
    let least = USUAL_LOADS[0] * modulus / 206e9 * per_load(shared);
    let small = note("operating.nominal_torque_nm", nominal, least);
    let both = 2.0 / (gear.youngs_modulus.recip() + mate.youngs_modulus.recip());
    let deflection = maximum / per_load(shared) / (STIFFNESS_OVER_MODULUS * both);
    let large = (deflection > LARGEST_DEFLECTION).then(|| {
        format!(
            "under `operating.maximum_torque_nm` = {maximum} the teeth deflect by some {:.0} % of the module, beyond linear elasticity, \
             from which all results are; it holds up to {:.0} %",
            100.0 * deflection,
            100.0 * LARGEST_DEFLECTION
        )
    });
    Ok(small.into_iter().chain(large).collect())
}

/// Deflection over the normal module up to which teeth count as undeformed: from there on the contact has moved so far along the bent
/// flanks that deflections of undeformed ones err by about this part.
pub const LARGEST_DEFLECTION: f64 = 0.05;

/// The pair at one centre distance, m, with the field and value of the file that set it.
struct InMesh<'a> {
    file: &'a PairFile,
    geometry: &'a PairGeometry,
    profiles: &'a [ToothProfile; 2],
    center_distance: f64,
    field: &'a str,
    value: String,
}

/// Checks the mesh at the nominal centre distance and at both ends of its range. What would be refused
/// at nominal is a note at the ends, unless the gears cannot mesh there at all.
pub(super) fn check_center_distances(
    file: &PairFile,
    geometry: &PairGeometry,
    profiles: &[ToothProfile; 2],
) -> Result<Vec<String>, Refusal> {
    let value = match file.center_distance_mm {
        Some(mm) => mm.to_string(),
        None => format!("{:.4} (default)", geometry.center_distance / MM),
    };
    let nominal = InMesh {
        file,
        geometry,
        profiles,
        center_distance: geometry.center_distance,
        field: "center_distance_mm",
        value,
    };
    nominal.check_clearance()?;
    nominal.check_contact()?;
    let mut notes = Vec::new();
    for um in file.operating.center_distance_offset_um {
        let end = InMesh {
            center_distance: geometry.center_distance + um * UM,
            field: "operating.center_distance_offset_um",
            value: um.to_string(),
            ..nominal
        };
        ensure!(end.center_distance > geometry.base_radius_sum(), end.field => &end.value;
            "the base circles allow no mesh there"; "narrow the range");
        end.check_clearance()?;
        let mut of_offset = notes_on_offset(geometry, um * UM);
        if let Err(refusal) = end.check_contact() {
            of_offset.insert(0, format!("{}: {}", at_offset(um), refusal.problem));
            of_offset.dedup();
        }
        notes.extend(of_offset);
    }
    Ok(notes)
}

/// The total contact ratio at `center_distance` (m) in words, if it does not keep teeth in contact.
fn lost_contact(geometry: &PairGeometry, center_distance: f64) -> Option<String> {
    let transverse = geometry.transverse_contact_ratio(center_distance);
    let total = transverse + geometry.overlap_ratio();
    let holds = transverse > 0.0 && total >= 1.0;
    (!holds).then(|| format!("the total contact ratio is {total:.3}"))
}

/// Start of a note on the mesh at the deviation `um` from the nominal centre distance.
fn at_offset(um: f64) -> String {
    format!("at a centre distance offset of {} um", rounded(um))
}

/// What is legal but worth knowing of the mesh of `geometry` at the deviation `offset` (m) from the nominal centre distance: that it loses
/// contact, or that both flanks press.
pub fn notes_on_offset(geometry: &PairGeometry, offset: f64) -> Vec<String> {
    let center_distance = geometry.center_distance + offset;
    let there = at_offset(offset / UM);
    let backlash = geometry.backlash(center_distance) / UM;
    let parts = lost_contact(geometry, center_distance)
        .map(|ratio| format!("{there}: {ratio}, and below 1 teeth lose contact"));
    // Below a micrometre it is the rounding of a drawing.
    let press = (backlash < -1.0).then(|| {
        format!("{there} both flanks press: the backlash on the line of action is {backlash:.1} um")
    });
    parts.into_iter().chain(press).collect()
}

/// Checks the mesh of the warm pair, `geometry`, as that of the drawing was checked: what would be refused there is refused of the temperature.
/// Adds to `notes` those that the cold pair does not have.
pub(super) fn check_warm(
    file: &PairFile,
    geometry: &PairGeometry,
    notes: &mut Vec<String>,
) -> Result<(), Refusal> {
    let celsius = temperature::temperature(file);
    if celsius == temperature::OF_DRAWING {
        return Ok(());
    }
    let [one, two] = &geometry.gears;
    let found = gears::profile(file, one, 0)
        .and_then(|one| Ok([one, gears::profile(file, two, 1)?]))
        .and_then(|profiles| check_center_distances(file, geometry, &profiles))
        .and_then(|notes| check_tooth_difference(geometry).map(|()| notes));
    let warm = found.map_err(|found| {
        refusal!("operating.temperature_c" => celsius;
            "the gears of the drawing mesh, but as warm as that they do not: `{}` = {}: {}",
            found.field, found.value, found.problem;
            "give `housing_thermal_expansion_um_per_m_k`, shorter teeth, another centre distance, a narrower \
             `center_distance_offset_um` or a temperature nearer 20 °C")
    })?;
    let new = warm.into_iter().filter(|note| !notes.contains(note));
    let new: Vec<String> = new
        .map(|note| format!("at {} °C: {note}", rounded(celsius)))
        .collect();
    notes.extend(new);
    Ok(())
}

/// A tip may dip this far below the start of the involute, in normal modules of roll, unless undercut left a corner: the
/// fillet leaves the involute as a tangent, far below a micrometre there.
const DIP_INTO_FILLET: f64 = 0.01;

/// An addendum below this, in normal modules, is a slip where something fails for it.
const SHORT_ADDENDUM: f64 = 0.5;

/// Refuses the shorter tooth where something fails, if it is so short that it is probably a slip.
pub(super) fn short_tooth(
    file: &PairFile,
    geometry: &PairGeometry,
    failure: &str,
    otherwise: &str,
) -> Result<(), Refusal> {
    let addendum = [0, 1].map(|i| {
        let gear = &geometry.gears[i];
        let above = (gear.tip_radius - gear.reference_radius()) / gear.normal_module;
        gear.kappa() * (above - gear.profile_shift)
    });
    let i = usize::from(addendum[1] < addendum[0]);
    let (given, gear) = (file.gear(i), &geometry.gears[i]);
    let (tip, value) = tip_field(file, gear, i);
    ensure!(given.has_default_tip() || addendum[i] >= SHORT_ADDENDUM, tip => value;
        "the addendum is {:.3} modules, while one module asks for a tip diameter of {:.3} mm, and {failure}",
        addendum[i], 2.0 * usual_tip_radius(gear) / MM;
        "give the diameter of the tips{otherwise}");
    Ok(())
}

impl InMesh<'_> {
    /// Contact on the involutes of both gears, and enough of it.
    fn check_contact(&self) -> Result<(), Refusal> {
        self.check_active_profile(0)?;
        self.check_active_profile(1)?;
        let Some(problem) = lost_contact(self.geometry, self.center_distance) else {
            return Ok(());
        };
        let otherwise = "; check module and tooth number, too";
        short_tooth(self.file, self.geometry, &problem, otherwise)?;
        Err(refusal!(self.field => &self.value;
            "{problem}, and below 1 teeth lose contact";
            "choose larger tip diameters, a smaller centre distance or, with helical teeth, a wider face"))
    }

    /// Tip circle against the mate's root circle.
    fn check_clearance(&self) -> Result<(), Refusal> {
        for (i, gear) in self.geometry.gears.iter().enumerate() {
            let clearance = self.geometry.tip_clearance(i, self.center_distance);
            let (tip, value) = tip_field(self.file, gear, i);
            let (field, at, mate) = (self.field, &self.value, 2 - i);
            if let Some(root) = self
                .file
                .gear(1 - i)
                .root_diameter_mm
                .filter(|_| clearance <= 0.0)
            {
                return Err(refusal!(in_gear(1 - i, "root_diameter_mm") => root;
                    "leaves the tips of gear {}, `{tip}` = {value}, a clearance of {:.3} mm at `{field}` = {at}",
                    i + 1, clearance / MM;
                    "check it: give a deeper root, shorten the teeth of gear {} or change the centre distance", i + 1));
            }
            ensure!(clearance > 0.0, tip => value;
                "the tip clearance to gear {mate} is {:.3} mm at `{field}` = {at}", clearance / MM;
                "shorten the tooth, deepen the mate's `dedendum_coefficient` or change the centre distance");
        }
        Ok(())
    }

    /// The mate's tip must meet the involute of gear `i`, not its fillet.
    fn check_active_profile(&self, i: usize) -> Result<(), Refusal> {
        let (geometry, profile, c) = (self.geometry, &self.profiles[i], self.center_distance);
        let (gear, mate) = (&geometry.gears[i], &geometry.gears[1 - i]);
        let form_roll = profile.usable_roll();
        let start = geometry.active_start_roll(i, c);
        let is_undercut = profile.is_undercut();
        let dip = if is_undercut { 0.0 } else { DIP_INTO_FILLET };
        if gear.kappa() * (start - form_roll) >= -dip * gear.normal_module {
            return Ok(());
        }
        // The mate's tip diameter that would just reach the start of the involute.
        let xi = geometry.distance_at_roll(i, c, form_roll);
        let limit = 2.0 * mate.radius_at_roll(geometry.roll_at(1 - i, c, xi).max(0.0)) / MM;
        let bound = match mate.kind {
            GearKind::Ring => "least",
            GearKind::External => "most",
        };
        let number = 2 - i;
        let limit = format!("a `tip_diameter_mm` of at {bound} {limit:.3} mm for gear {number}");
        let form = 2.0 * profile.usable_radius() / MM;
        let begins = 2.0 * gear.base_radius().hypot(start) / MM;
        if is_undercut {
            return Err(refusal!(in_gear(i, "profile_shift") => gear.profile_shift;
                "undercut reaches the active profile: the involute starts at diameter {form:.3} mm, contact at {begins:.3} mm";
                "choose a larger profile shift, more teeth, or {limit}"));
        }
        if let Some(root) = self.file.gear(i).root_form_diameter_mm {
            return Err(refusal!(in_gear(i, "root_form_diameter_mm") => root;
                "contact begins below it, at diameter {begins:.3} mm";
                "choose a tool that leaves more involute, or {limit}"));
        }
        let (tip, value) = tip_field(self.file, mate, 1 - i);
        Err(refusal!(tip => value;
            "tip interference: it runs into the fillet of gear {}, whose involute starts at diameter {form:.3} mm, \
             contact at {begins:.3} mm", i + 1;
            "choose {limit}, or another `profile_shift`"))
    }
}

/// Tooth difference of an internal pair, once the mesh itself is in order.
pub(super) fn check_tooth_difference(geometry: &PairGeometry) -> Result<(), Refusal> {
    let Some(ring) = geometry.ring() else {
        return Ok(());
    };
    let (z_ring, z_pinion) = (geometry.gears[ring].teeth, geometry.gears[1 - ring].teeth);
    let clearance = tip_corner_clearance(geometry).unwrap_or(0.0);
    ensure!(clearance >= 0.0, in_gear(ring, "teeth") => z_ring;
        "the tooth difference, {z_ring} - {z_pinion} = {}, is too small: tip corners foul each other by {:.3} mm \
         where the tip circles cross",
        i64::from(z_ring) - i64::from(z_pinion), -clearance * geometry.gears[ring].tip_radius / MM;
        "choose a larger difference, shorter teeth or a larger operating pressure angle");
    Ok(())
}

/// What is legal but worth knowing.
pub(super) fn warnings(geometry: &PairGeometry, profiles: &[ToothProfile; 2]) -> Vec<String> {
    let mut out = Vec::new();
    for (i, gear) in geometry.gears.iter().enumerate() {
        let (m, profile) = (gear.normal_module / MM, &profiles[i]);
        let n = i + 1;
        let (land, form) = (profile.tip_land() / MM, 2.0 * profile.form_radius() / MM);
        let wall = gear.kappa() * (gear.root_radius() - gear.held_radius) / MM;
        if land < 0.2 * m {
            out.push(format!(
                "gear {n}: the tip land is {land:.3} mm in the transverse section, below 0.2 modules"
            ));
        }
        if wall < m && gear.foundation.is_none() {
            out.push(format!("gear {n}: only {wall:.3} mm, less than a module, between the root and the held surface"));
        }
        let body = gear.body.filter(|body| !body.is_shaft());
        let rim = body.map(|body| (gear.root_radius() - body.rim_radius) / MM);
        // Half a micrometre is the rounding of a drawing.
        if let Some(rim) = rim.filter(|rim| *rim < m - 5e-4) {
            out.push(format!(
                "gear {n}: a rim of {rim:.3} mm, less than a module, under the roots"
            ));
        }
        if profile.is_undercut() {
            out.push(format!(
                "gear {n}: undercut, the involute starts at diameter {form:.3} mm"
            ));
        }
    }
    if !assembles_radially(geometry) {
        out.push("the pinion can be assembled with the ring axially only".into());
    }
    out
}

/// External gear and ring of an internal pair, and their pressure angles at the tip.
fn internal(geometry: &PairGeometry) -> Option<[(&Gear, f64); 2]> {
    let ring = geometry.ring()?;
    Some([1 - ring, ring].map(|i| {
        let gear = &geometry.gears[i];
        (gear, (gear.base_radius() / gear.tip_radius).acos())
    }))
}

/// Clearance between the tip corners of pinion and ring where the tip circles cross, as an angle of the ring, rad;
/// negative: they foul (trochoid interference). None for an external pair, and where the tip circles do not cross.
///
/// Backlash is no help: both corners belong to a pair of flanks that touch elsewhere, and only the flanks across
/// have the backlash as additional clearance. Under load of either sign one pair touches.
///
/// KHK, Gear Technical Reference, "Interference of internal gears"; DIN 3993-1.
fn tip_corner_clearance(geometry: &PairGeometry) -> Option<f64> {
    let [(p, alpha_p), (r, alpha_r)] = internal(geometry)?;
    let (ap, ar, c) = (p.tip_radius, r.tip_radius, geometry.center_distance);
    let at_pinion = ((ar * ar - ap * ap - c * c) / (2.0 * c * ap)).acos();
    let at_ring = ((c * c + ar * ar - ap * ap) / (2.0 * c * ar)).acos();
    let inv_w = involute(geometry.operating_pressure_angle(c));
    let turned = (at_pinion + involute(alpha_p) - inv_w) * p.z() / r.z();
    let clearance = turned + inv_w - involute(alpha_r) - at_ring;
    (!clearance.is_nan()).then_some(clearance)
}

/// Whether the pinion can be brought into mesh radially (no trimming interference); true for an
/// external pair. Same sources as [`tip_corner_clearance`].
fn assembles_radially(geometry: &PairGeometry) -> bool {
    let Some([(p, alpha_p), (r, alpha_r)]) = internal(geometry) else {
        return true;
    };
    let ratio = p.z() / r.z();
    let cosines = alpha_p.cos() / alpha_r.cos();
    let of_pinion = (1.0 - cosines.powi(2)) / (1.0 - ratio.powi(2));
    let of_ring = (cosines.powi(-2) - 1.0) / (ratio.powi(-2) - 1.0);
    let [at_pinion, at_ring] = [of_pinion, of_ring].map(|square| square.sqrt().asin());
    let inv_w = involute(geometry.operating_pressure_angle(geometry.center_distance));
    let pinion = at_pinion + involute(alpha_p) - inv_w;
    let ring = (at_ring + involute(alpha_r) - inv_w) / ratio;
    // Not a number: the corners never pass each other on the way in.
    pinion >= ring || pinion.is_nan() || ring.is_nan()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gear::ToothProfile;
    use crate::gear::half_thickness_angle;
    use crate::samples;
    use gearmesh::gear::GearKind;

    /// Pinion of `teeth` in a ring of 60, module 1, without backlash.
    fn internal(teeth: u32) -> PairGeometry {
        let gear = |kind, teeth, tip_radius| Gear {
            tip_radius,
            tool_tip_radius_coefficient: 0.2,
            ..samples::with_module(samples::gear(kind, teeth, 1.0, 0.0, 0.0), 1e-3)
        };
        PairGeometry {
            gears: [
                gear(GearKind::External, teeth, 0.5e-3 * f64::from(teeth) + 1e-3),
                gear(GearKind::Ring, 60, 29.2e-3),
            ],
            center_distance: 0.5e-3 * (60.0 - f64::from(teeth)),
        }
    }

    /// Half angles at the tips of pinion tooth and ring space.
    fn half_angles(p: &PairGeometry) -> [f64; 2] {
        let half = |i: usize| {
            let profile = ToothProfile::new(&p.gears[i]).unwrap();
            half_thickness_angle(&profile, p.gears[i].tip_radius).unwrap()
        };
        [half(0), std::f64::consts::PI / 60.0 - half(1)]
    }

    /// Least clearance, as an angle of the ring, of the leading pinion corner from the wall of its space,
    /// found by turning both gears; ring centre at the origin, pinion at (C, 0), mesh on the +x side.
    fn clearance_by_turning(p: &PairGeometry) -> f64 {
        let [tooth, _] = half_angles(p);
        let ring = ToothProfile::new(&p.gears[1]).unwrap();
        let (ratio, r) = (p.gears[0].z() / 60.0, p.gears[0].tip_radius);
        (0..200_000)
            .filter_map(|k| {
                let turned = 1e-5 * f64::from(k);
                let (y, x) = (turned + tooth).sin_cos();
                let (x, y) = (p.center_distance + r * x, r * y);
                // None: inside the ring's tip circle, where the corner is free.
                let tooth_of_ring = half_thickness_angle(&ring, x.hypot(y))?;
                let space = ring.half_pitch() - tooth_of_ring;
                Some(space - (y.atan2(x) - turned * ratio))
            })
            .fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn tip_corners_foul_where_turning_the_gears_shows_it() {
        let mut seen = [false; 2];
        for teeth in (24..=54).step_by(2) {
            let p = internal(teeth);
            let formula = tip_corner_clearance(&p).unwrap();
            let turned = clearance_by_turning(&p);
            assert_eq!(formula < 0.0, turned < -1e-7, "{teeth}: {formula} {turned}");
            seen[usize::from(formula < 0.0)] = true;
        }
        assert_eq!(seen, [true; 2]);
    }

    #[test]
    fn radial_assembly_agrees_with_pushing_the_pinion_in() {
        let mut seen = [false; 2];
        for teeth in (24..=54).step_by(2) {
            let p = internal(teeth);
            let [tooth, space] = half_angles(&p);
            let ratio = p.gears[0].z() / 60.0;
            let r = p.gears.each_ref().map(|g| g.tip_radius);
            // Corners move parallel to the line of centres: none may stand wider than the corner of its
            // space, wherever on the pinion the tooth stands.
            let free = (0..=10_000)
                .map(|k| f64::from(k) * 1e-4 * (std::f64::consts::FRAC_PI_2 - tooth))
                .all(|t| r[1] * (t * ratio + space).sin() >= r[0] * (t + tooth).sin() - 1e-12);
            assert_eq!(assembles_radially(&p), free, "{teeth}");
            seen[usize::from(free)] = true;
        }
        assert_eq!(seen, [true; 2]);
    }
}
