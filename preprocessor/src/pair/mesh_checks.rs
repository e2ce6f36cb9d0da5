//! What can only be said of the gears as built and of the pair in mesh.

use super::error::{Refusal, ensure, refusal};
use super::file::PairFile;
use super::interference::{assembles_radially, tip_corner_clearance};
use super::resolve::{MM, UM, gear_file};
use super::slips;
use gearmesh::gear::{
    Gear, GearKind, LEAST_WALL, PairGeometry, ProfileError, ToothProfile, inverse_involute,
};
use gearmesh::words::{number, rounded};

/// "gear1.<field>" or "gear2.<field>".
pub(super) fn field(i: usize, name: &str) -> String {
    format!("gear{}.{name}", i + 1)
}

/// The field that sets the tip circle, and its value.
fn tip_field(file: &PairFile, gear: &Gear, i: usize) -> (String, String) {
    let g = gear_file(file, i);
    let (name, value) = match (g.tip_diameter_mm, g.addendum_coefficient) {
        (Some(mm), _) => ("tip_diameter_mm", mm.to_string()),
        (None, Some(addendum)) => ("addendum_coefficient", addendum.to_string()),
        (None, None) => (
            "tip_diameter_mm",
            format!("{:.3} (default)", 2.0 * gear.tip_radius / MM),
        ),
    };
    (field(i, name), value)
}

/// Builds the tooth profile of gear `i` and checks it against bore or rim.
pub(super) fn check_gear(file: &PairFile, gear: &Gear, i: usize) -> Result<ToothProfile, Refusal> {
    let profile = ToothProfile::new(gear).map_err(|error| profile_refusal(file, gear, i, error))?;
    // No more than the tip leaves of a tooth, and no less than a rounding of the file.
    ensure!((-1e-9..0.5 * gear.normal_module).contains(&gear.tip_chamfer),
        field(i, "tip_form_diameter_mm") => 2.0 * gear.tip_form_radius() / MM;
        "is the end of the involute of tips with the diameter {:.3} mm", 2.0 * gear.tip_radius / MM;
        "give the diameter at which the chamfer begins, at most half a module of height from the tip diameter");
    check_held_surface(gear, i)?;
    Ok(profile)
}

/// Smallest bore over the root diameter. About a bore held rigidly the body turns the farther the smaller it is, here
/// thousands of times as far as teeth bend; of less rounding leaves nothing.
const LEAST_BORE: f64 = 1e-3;

/// The held surface leaves a wall to the root circle, and is no point.
fn check_held_surface(gear: &Gear, i: usize) -> Result<(), Refusal> {
    let (root, held) = (2.0 * gear.root_radius() / MM, 2.0 * gear.held_radius / MM);
    let wall = 2.0 * LEAST_WALL * gear.normal_module / MM;
    match gear.kind {
        GearKind::External => {
            let other = "give the diameter of the hub or shaft at which the gear is held";
            let meant = slips::diameter(held, 0.5 * root);
            let remedy = slips::remedy(meant, "give the bore in millimetres", other);
            ensure!((LEAST_BORE * root..=root - wall).contains(&held),
                field(i, "bore_diameter_mm") => number(rounded(held));
                "lies outside a thousandth of the root diameter, {root:.3} mm, to half a normal module below it";
                "{remedy}");
        }
        GearKind::Ring => {
            let other = "give the outer diameter at which the ring is held";
            let meant = slips::diameter(held, 1.1 * root);
            let remedy = slips::remedy(meant, "give the outer diameter in millimetres", other);
            ensure!(held >= root + wall, field(i, "rim_diameter_mm") => held;
                "is less than {:.3} mm, half a normal module above the root diameter of the ring", root + wall;
                "{remedy}");
        }
    }
    Ok(())
}

fn profile_refusal(file: &PairFile, gear: &Gear, i: usize, error: ProfileError) -> Refusal {
    let problem = error.to_string();
    let base = 2.0 * gear.base_radius() / MM;
    let slip = gear_file(file, i)
        .tip_diameter_mm
        .and_then(|mm| slips::diameter(mm, 2.0 * usual_tip_radius(gear) / MM));
    let remedy = match error {
        _ if let Some(other) = slip => format!("give the diameter in millimetres: {other}"),
        ProfileError::PointedTooth => {
            let limit = match gear.kind {
                GearKind::External => {
                    let alpha = inverse_involute(gear.half_base_angle());
                    format!("below {:.3}", base / alpha.cos())
                }
                GearKind::Ring => "larger".into(),
            };
            format!("choose a tip diameter {limit} mm, or another `profile_shift`")
        }
        ProfileError::NoInvolute => {
            "check the tip diameter, `dedendum_coefficient` and `profile_shift`".into()
        }
        ProfileError::TipInsideBase => {
            format!("choose a tip diameter above {base:.3} mm, or more teeth")
        }
        ProfileError::RoundTooLarge => {
            return refusal!(field(i, "tool_tip_radius_coefficient") => gear.tool_tip_radius_coefficient;
                "{problem}"; "choose a smaller radius or a smaller `dedendum_coefficient`");
        }
        ProfileError::RootCircle => {
            return refusal!(field(i, "dedendum_coefficient") => gear.dedendum_coefficient;
                "{problem}"; "choose another dedendum, more teeth or another `profile_shift`");
        }
    };
    let (tip, value) = tip_field(file, gear, i);
    refusal!(tip => value; "{problem}"; "{remedy}")
}

/// Radius of tips with an addendum of one module, m.
fn usual_tip_radius(gear: &Gear) -> f64 {
    gear.reference_radius() + gear.normal_module * (gear.profile_shift + gear.kappa())
}

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
    let default = || format!("{:.4} (default)", geometry.center_distance / MM);
    let nominal = InMesh {
        file,
        geometry,
        profiles,
        center_distance: geometry.center_distance,
        field: "center_distance_mm",
        value: file
            .center_distance_mm
            .map_or_else(default, |mm| mm.to_string()),
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
        let there = format!("at a centre distance offset of {um} um");
        if let Err(refusal) = end.check_contact() {
            notes.push(format!("{there}: {}", refusal.problem));
        }
        // Below a micrometre it is the rounding of a drawing.
        let backlash = geometry.backlash(end.center_distance) / UM;
        if backlash < -1.0 {
            notes.push(format!(
                "{there} both flanks press: the backlash on the line of action is {backlash:.1} um"
            ));
        }
    }
    Ok(notes)
}

/// A tip of gear `i` may dip this far below the start of the involute, in normal modules of roll: the
/// fillet leaves the involute as a tangent, which is far below a micrometre there. A corner left by
/// undercut gets no such allowance.
const DIP_INTO_FILLET: f64 = 0.01;

/// An addendum below this, in normal modules, is a slip where something fails for it.
const SHORT_ADDENDUM: f64 = 0.5;

/// Field, value and problem of the shorter tooth, if it is so short that it is probably a slip.
pub(super) fn short_tooth(
    file: &PairFile,
    geometry: &PairGeometry,
) -> Option<(String, String, String)> {
    let addendum = |i: usize| {
        let gear = &geometry.gears[i];
        let above = (gear.tip_radius - gear.reference_radius()) / gear.normal_module;
        gear.kappa() * (above - gear.profile_shift)
    };
    let i = usize::from(addendum(1) < addendum(0));
    let given = gear_file(file, i);
    let is_default = given.tip_diameter_mm.is_none() && given.addendum_coefficient.is_none();
    if is_default || addendum(i) >= SHORT_ADDENDUM {
        return None;
    }
    let gear = &geometry.gears[i];
    let (tip, value) = tip_field(file, gear, i);
    let problem = format!(
        "the addendum is {:.3} modules, while one module asks for a tip diameter of {:.3} mm",
        addendum(i),
        2.0 * usual_tip_radius(gear) / MM
    );
    Some((tip, value, problem))
}

impl InMesh<'_> {
    /// Contact on the involutes of both gears, and enough of it.
    fn check_contact(&self) -> Result<(), Refusal> {
        self.check_active_profile(0)?;
        self.check_active_profile(1)?;
        let transverse = self.geometry.transverse_contact_ratio(self.center_distance);
        let total = transverse + self.geometry.overlap_ratio();
        let is_enough = transverse > 0.0 && total >= 1.0;
        if let Some((tip, value, problem)) = short_tooth(self.file, self.geometry) {
            ensure!(is_enough, tip => value;
                "{problem}, and the total contact ratio is {total:.3}";
                "give the diameter of the tips; check module and tooth number, too");
        }
        ensure!(is_enough, self.field => &self.value;
            "the total contact ratio is {total:.3}, and below 1 teeth lose contact";
            "choose larger tip diameters, a smaller centre distance or, with helical teeth, a wider face");
        Ok(())
    }

    /// Tip circle against the mate's root circle.
    fn check_clearance(&self) -> Result<(), Refusal> {
        for (i, gear) in self.geometry.gears.iter().enumerate() {
            let clearance = self.geometry.tip_clearance(i, self.center_distance);
            let (tip, value) = tip_field(self.file, gear, i);
            ensure!(clearance > 0.0, tip => value;
                "the tip clearance to gear {} is {:.3} mm at `{}` = {}", 2 - i, clearance / MM, self.field, self.value;
                "shorten the tooth, deepen the mate's `dedendum_coefficient` or change the centre distance");
        }
        Ok(())
    }

    /// The mate's tip must meet the involute of gear `i`, not its fillet.
    fn check_active_profile(&self, i: usize) -> Result<(), Refusal> {
        let (geometry, profile, center_distance) =
            (self.geometry, &self.profiles[i], self.center_distance);
        let (gear, mate) = (&geometry.gears[i], &geometry.gears[1 - i]);
        let form_roll = profile.form_roll();
        let start = geometry.active_start_roll(i, center_distance);
        let dip = match profile.is_undercut() {
            true => 0.0,
            false => DIP_INTO_FILLET * gear.normal_module,
        };
        if gear.kappa() * (start - form_roll) >= -dip {
            return Ok(());
        }
        // The mate's tip diameter that would just reach the start of the involute.
        let side = if i == 0 { gear.kappa() } else { -gear.kappa() };
        let xi = (form_roll - geometry.roll_at(i, center_distance, 0.0)) / side;
        let limit = mate.radius_at_roll(geometry.roll_at(1 - i, center_distance, xi).max(0.0));
        let bound = match mate.kind {
            GearKind::External => "at most",
            GearKind::Ring => "at least",
        };
        let limit = 2.0 * limit / MM;
        let limit = format!(
            "a `tip_diameter_mm` of {bound} {limit:.3} mm for gear {}",
            2 - i
        );
        let form = 2.0 * profile.form_radius() / MM;
        if profile.is_undercut() {
            return Err(refusal!(field(i, "profile_shift") => gear.profile_shift;
                "undercut reaches the active profile: the involute starts at diameter {form:.3} mm, contact at {:.3} mm",
                2.0 * gear.base_radius().hypot(start) / MM;
                "choose a larger profile shift, more teeth, or {limit}"));
        }
        let (tip, value) = tip_field(self.file, mate, 1 - i);
        Err(refusal!(tip => value;
            "tip interference: it runs into the fillet of gear {}, whose involute starts at diameter {form:.3} mm, \
             contact at {:.3} mm", i + 1, 2.0 * gear.base_radius().hypot(start) / MM;
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
    ensure!(clearance >= 0.0, field(ring, "teeth") => z_ring;
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
        let land = profiles[i].tip_land();
        let name = format!("gear {}", i + 1);
        if land < 0.2 * gear.normal_module {
            let mm = land / MM;
            out.push(format!(
                "{name}: the tip land is {mm:.3} mm, below 0.2 modules"
            ));
        }
        let wall = gear.kappa() * (gear.root_radius() - gear.held_radius);
        if wall < gear.normal_module && gear.foundation.is_none() {
            let held = if gear.kind == GearKind::Ring {
                "rim"
            } else {
                "bore"
            };
            let mm = wall / MM;
            out.push(format!(
                "{name}: only {mm:.3} mm, less than a module, between root and {held}, which is held rigidly"
            ));
        }
        if profiles[i].is_undercut() {
            let mm = 2.0 * profiles[i].form_radius() / MM;
            out.push(format!(
                "{name}: undercut, the involute starts at diameter {mm:.3} mm"
            ));
        }
    }
    if !assembles_radially(geometry) {
        out.push("the pinion can be assembled with the ring axially only".into());
    }
    out
}
