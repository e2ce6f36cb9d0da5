//! What can be said of each field on its own, before any geometry is built from it.

use super::error::{Refusal, ensure, refusal};
use super::file::{Dimension, EndReliefFile, FlankFile, GearFile, Meshing, PairFile};
use super::modifications::STEEPEST;
use super::slips;
use gearmesh::words::{number, rounded};

/// Numbers that a field may have, as the file writes them.
#[derive(Debug, Clone, Copy)]
pub(super) enum Range {
    /// Both ends included.
    Within(f64, f64),
    /// Above 0.
    UpTo(f64),
}
use Range::{UpTo, Within};

/// A field, its number where it is given, its range, and what a number outside is probably meant as.
pub(super) type Row = (&'static str, Option<f64>, Range, Option<String>);

/// Checks the fields of one part of the file, whose path is `part` with a point, or nothing.
pub(super) fn check(part: &str, rows: &[Row]) -> Result<(), Refusal> {
    for (name, value, range, probably) in rows {
        let Some(value) = *value else { continue };
        let (is_fine, problem) = match *range {
            Within(low, high) => {
                // As they are shown: 0.1 * 1.5 is not quite 0.15.
                let [low, high] = [rounded(low), rounded(high)];
                (
                    (low..=high).contains(&value),
                    format!("lies outside {low} to {high}"),
                )
            }
            UpTo(high) => (
                value > 0.0 && value <= high,
                format!("must be above 0 and at most {high}"),
            ),
        };
        let otherwise = "give a value in that range, in the unit of the name";
        let remedy = slips::remedy(
            probably.clone(),
            "give it in the unit of the name",
            otherwise,
        );
        ensure!(is_fine, format!("{part}{name}") => value; "{problem}"; "{remedy}");
    }
    Ok(())
}

/// Normal modules, mm. Smaller ones than any tooth has are metres.
const MODULES: Range = Within(0.02, 1000.0);

/// Torques on gear 1 other than 0, N m. Below, the rounding of lengths outweighs what the teeth give way.
pub const TORQUES: [f64; 2] = [1e-9, 1e9];

/// Checks every field of the file by itself.
#[rustfmt::skip]
pub(super) fn check_fields(file: &PairFile) -> Result<(), Refusal> {
    let printable = |c: char| !c.is_control() && !"/\\:*?\"<>|".contains(c);
    let name = &file.name;
    ensure!(!name.trim().is_empty() && name.chars().count() <= 100 && name.chars().all(printable),
        "name" => format!("{name:?}");
        "cannot serve as a file name";
        "give 1 to 100 characters without / \\ : * ? \" < > |");
    let (module, alpha) = (file.normal_module_mm, file.normal_pressure_angle_deg);
    check("", &[
        ("normal_module_mm", Some(module), MODULES, slips::module(module)),
        ("normal_pressure_angle_deg", Some(alpha), Within(10.0, 35.0), slips::degrees(alpha)),
        ("helix_angle_deg", file.helix_angle_deg, Within(-60.0, 60.0), None),
        ("center_distance_mm", file.center_distance_mm, UpTo(1e5), None),
        ("backlash_um", file.backlash_um, Within(0.0, 250.0 * module), None),
        ("normal_backlash_um", file.normal_backlash_um.map(Dimension::middle), Within(0.0, 250.0 * module), None),
        ("face_offset_mm", file.face_offset_mm, Within(-1e4, 1e4), None),
    ])?;
    for (name, gear) in [("gear1", &file.gear1), ("gear2", &file.gear2)] {
        check_gear(name, gear, module)?;
    }
    check_held_surfaces(file)?;
    check_operating(file)
}

#[rustfmt::skip]
fn check_gear(name: &str, g: &GearFile, module: f64) -> Result<(), Refusal> {
    ensure!((4..=5000).contains(&g.teeth), format!("{name}.teeth") => g.teeth;
        "lies outside 4 to 5000"; "give the number of teeth, positive for a ring, too");
    if let (Some(addendum), Some(mm)) = (g.addendum_coefficient, g.tip_diameter_mm) {
        return Err(refusal!(format!("{name}.addendum_coefficient") => addendum;
            "`tip_diameter_mm` = {mm} says the same"; "give only one of them"));
    }
    // Beyond a hundred modules of face the elastic model outgrows memory.
    let face = Within(0.05 * module, 100.0 * module);
    check(&format!("{name}."), &[
        ("profile_shift", g.profile_shift, Within(-3.0, 3.0), None),
        ("profile_shift_iso_21771", g.profile_shift_iso_21771, Within(-3.0, 3.0), None),
        ("ball_diameter_mm", g.ball_diameter_mm, UpTo(5.0 * module), None),
        ("span_teeth", g.span_teeth.map(f64::from), Within(1.0, f64::from(g.teeth)), None),
        ("face_width_mm", Some(g.face_width_mm), UpTo(1e4), None),
        ("face_width_mm", Some(g.face_width_mm), face, slips::face_width(g.face_width_mm, module)),
        ("tip_diameter_mm", g.tip_diameter_mm, UpTo(1e5), None),
        ("addendum_coefficient", g.addendum_coefficient, UpTo(3.0), None),
        ("dedendum_coefficient", g.dedendum_coefficient, UpTo(3.0), None),
        ("tool_tip_radius_coefficient", Some(g.tool_tip_radius_coefficient), Within(0.0, 1.0), None),
        ("bore_diameter_mm", g.bore_diameter_mm, UpTo(1e5), None),
        ("rim_diameter_mm", g.rim_diameter_mm, UpTo(1e5), None),
        ("youngs_modulus_gpa", Some(g.youngs_modulus_gpa), UpTo(2000.0), slips::modulus(g.youngs_modulus_gpa)),
        ("poisson_ratio", Some(g.poisson_ratio), Within(0.0, 0.49), None),
    ])?;
    let dimensions = [
        ("normal_tooth_thickness_mm", g.normal_tooth_thickness_mm),
        ("span_measurement_mm", g.span_measurement_mm),
        ("dimension_over_balls_mm", g.dimension_over_balls_mm),
        ("root_diameter_mm", g.root_diameter_mm),
    ];
    for (field, dimension) in dimensions {
        let path = format!("{name}.{field}");
        if let Some(Dimension::Limits([low, high])) = dimension {
            ensure!(low <= high, path => format!("[{low}, {high}]"); "is reversed"; "give the lower limit first");
        }
        check(&path, &[("", dimension.map(Dimension::middle), UpTo(1e5), None)])?;
    }
    check_amounts(name, g, module)
}

/// Amounts of microgeometry: no more than a twentieth of the module, beyond which the flank is another flank and
/// no modification; those that only take material off not negative.
#[rustfmt::skip]
fn check_amounts(name: &str, g: &GearFile, module: f64) -> Result<(), Refusal> {
    let most = 50.0 * module;
    for (prefix, flank) in g.flanks() {
        for (field, um, low) in amounts(&flank, -most) {
            let problem = match um < low && low == 0.0 {
                true => "adds material".into(),
                false => format!("exceeds a twentieth of the normal module, {} um", rounded(most)),
            };
            ensure!(um >= low && um <= most, format!("{name}.{prefix}{field}") => um;
                "{problem}";
                "give the removal normal to the flank in micrometres, positive, as for a modification of the flank");
        }
        for (field, &EndReliefFile { amount_um, length_mm, .. }) in end_reliefs(&flank) {
            let (field, longest) = (format!("{name}.{prefix}{field}.length_mm"), 0.5 * g.face_width_mm);
            ensure!(length_mm > 0.0 && length_mm <= longest, &field => length_mm;
                "must be above 0 and at most half of the face width, {} mm", rounded(longest);
                "shorten the end relief, or use `lead_crowning_um` over the whole face");
            let least = 1e-3 * amount_um / STEEPEST;
            ensure!(length_mm >= least, &field => number(length_mm);
                "is steeper than one in ten under {amount_um} um: a chamfer, and no relief";
                "give at least {} mm, or a smaller amount", rounded(least));
        }
    }
    Ok(())
}

fn end_reliefs(flank: &FlankFile) -> impl Iterator<Item = (&'static str, &EndReliefFile)> {
    let all = [
        ("end_relief", &flank.end_relief),
        ("lower_end_relief", &flank.lower_end_relief),
        ("upper_end_relief", &flank.upper_end_relief),
    ];
    all.into_iter()
        .filter_map(|(field, relief)| Some((field, relief.as_ref()?)))
}

/// Field, amount in um and least amount of every modification that is given; those of either sign may go down to
/// `least`.
#[rustfmt::skip]
pub(super) fn amounts(flank: &FlankFile, least: f64) -> Vec<(String, f64, f64)> {
    let profile = [("tip_relief", &flank.tip_relief), ("root_relief", &flank.root_relief)];
    let profile = profile.into_iter().filter_map(|(field, r)| Some((field, r.as_ref()?.amount_um)));
    let reliefs = profile.chain(end_reliefs(flank).map(|(field, r)| (field, r.amount_um)));
    let numbers = [
        ("profile_crowning_um", flank.profile_crowning_um, 0.0),
        ("profile_slope_um", flank.profile_slope_um, least),
        ("bias_um", flank.bias_um, least),
        ("lead_crowning_um", flank.lead_crowning_um, 0.0),
        ("lead_slope_um", flank.lead_slope_um, least),
    ];
    let numbers = numbers.into_iter().filter_map(|(field, um, low)| Some((field.to_owned(), um?, low)));
    reliefs.map(|(field, um)| (format!("{field}.amount_um"), um, 0.0)).chain(numbers).collect()
}

/// Bore or rim: which of them a gear may have says whether it is a ring.
fn check_held_surfaces(file: &PairFile) -> Result<(), Refusal> {
    let gears = [("gear1", &file.gear1), ("gear2", &file.gear2)];
    for (name, g) in gears {
        let Some(rim) = g.rim_diameter_mm else {
            continue;
        };
        let field = format!("{name}.rim_diameter_mm");
        if let Some(bore) = g.bore_diameter_mm {
            return Err(refusal!(field => rim;
                "the gear also has a `bore_diameter_mm` = {bore}";
                "give a bore for an external gear, a rim for a ring"));
        }
        ensure!(file.meshing == Meshing::Internal, field => rim;
            "both gears of an external pair are held at their bore";
            "give `bore_diameter_mm`, or say `\"meshing\": \"internal\"`");
    }
    if file.meshing == Meshing::External {
        return Ok(());
    }
    match (
        file.gear1.rim_diameter_mm,
        file.gear2.rim_diameter_mm,
        file.gear2.bore_diameter_mm,
    ) {
        (Some(rim), Some(_), _) => Err(refusal!("gear1.rim_diameter_mm" => rim;
            "gear 2 has a rim, too, and an internal pair has one ring";
            "give the external gear a `bore_diameter_mm` instead")),
        (None, None, Some(bore)) => Err(refusal!("gear2.bore_diameter_mm" => bore;
            "gear 2 is the ring of this internal pair and is held at its outer rim";
            "give it `rim_diameter_mm`, or give that to gear 1 if gear 1 is the ring")),
        _ => Ok(()),
    }
}

fn check_operating(file: &PairFile) -> Result<(), Refusal> {
    let (o, [least, most]) = (&file.operating, TORQUES);
    let nominal = o.nominal_torque_nm;
    ensure!((least..=most).contains(&nominal), "operating.nominal_torque_nm" => number(nominal);
        "lies outside {least:e} to {most:e}"; "give the torque on gear 1 in N m, above 0");
    ensure!((nominal..=most).contains(&o.maximum_torque_nm), "operating.maximum_torque_nm" => o.maximum_torque_nm;
        "is no limit above the nominal torque, {nominal}"; "give at least the nominal torque, on gear 1");
    for (name, [low, high], most) in [
        (
            "center_distance_offset_um",
            o.center_distance_offset_um,
            1e4,
        ),
        ("misalignment_mrad", o.misalignment_mrad, 20.0),
    ] {
        let (field, value) = (format!("operating.{name}"), format!("[{low}, {high}]"));
        ensure!(low <= high, field => value; "is reversed"; "give the lower end first");
        ensure!(low <= 0.0 && high >= 0.0, field => value;
            "does not contain zero, the nominal state";
            "give deviations from nominal, such as [-1.0, 1.0] or [0.0, 0.0]");
        ensure!(low >= -most && high <= most, field => value;
            "goes beyond {most} on one side"; "narrow the range; check the unit in the name");
    }
    Ok(())
}
