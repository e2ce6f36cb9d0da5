//! What can be said of each field on its own, before any geometry is built from it.

use super::error::Refusal;
use super::file::{EndReliefFile, FlankFile, GearFile, Meshing, PairFile};
use super::slips;
use crate::words::{number, rounded};

/// Refuses unless `ok`; a comparison with NaN is not ok.
pub(super) fn require(
    ok: bool,
    field: impl Into<String>,
    value: impl std::fmt::Display,
    problem: impl Into<String>,
    remedy: impl Into<String>,
) -> Result<(), Refusal> {
    if ok {
        Ok(())
    } else {
        Err(Refusal::new(field, value, problem, remedy))
    }
}

/// A number within [low, high], both as the file writes them. `probably` is what a value outside may be meant as.
pub(super) fn within(
    field: impl Into<String>,
    value: f64,
    low: f64,
    high: f64,
    probably: Option<String>,
) -> Result<(), Refusal> {
    let problem = format!("lies outside {} to {}", rounded(low), rounded(high));
    require(
        (low..=high).contains(&value),
        field,
        value,
        problem,
        unit_remedy(probably),
    )
}

/// A number in (0, high].
fn positive(
    field: impl Into<String>,
    value: f64,
    high: f64,
    probably: Option<String>,
) -> Result<(), Refusal> {
    require(
        value > 0.0 && value <= high,
        field,
        value,
        format!("must be above 0 and at most {high}"),
        unit_remedy(probably),
    )
}

fn unit_remedy(probably: Option<String>) -> String {
    match probably {
        Some(probably) => format!("give it in the unit of the name: {probably}"),
        None => "give a value in that range, in the unit of the name".into(),
    }
}

/// Normal modules, mm. Smaller ones than any tooth has are metres.
const MODULES: [f64; 2] = [0.02, 1000.0];

/// Face widths over the normal module. Beyond the upper one the elastic model outgrows memory.
const FACE_OVER_MODULE: [f64; 2] = [0.05, 100.0];

/// Torques on gear 1 other than 0, N m. Below, the rounding of lengths outweighs what the teeth give way.
pub const TORQUES: [f64; 2] = [1e-9, 1e9];

/// Checks every field of the file by itself.
pub(super) fn check_fields(file: &PairFile) -> Result<(), Refusal> {
    let printable = |c: char| !c.is_control() && !"/\\:*?\"<>|".contains(c);
    require(
        !file.name.trim().is_empty()
            && file.name.chars().count() <= 100
            && file.name.chars().all(printable),
        "name",
        format!("{:?}", file.name),
        "cannot serve as a file name",
        "give 1 to 100 characters without / \\ : * ? \" < > |",
    )?;
    let (module, alpha) = (file.normal_module_mm, file.normal_pressure_angle_deg);
    within(
        "normal_module_mm",
        module,
        MODULES[0],
        MODULES[1],
        slips::module(module),
    )?;
    within(
        "normal_pressure_angle_deg",
        alpha,
        10.0,
        35.0,
        slips::degrees(alpha),
    )?;
    within("helix_angle_deg", file.helix_angle_deg, -60.0, 60.0, None)?;
    if let Some(mm) = file.center_distance_mm {
        positive("center_distance_mm", mm, 1e5, None)?;
    }
    if let Some(um) = file.backlash_um {
        within("backlash_um", um, 0.0, 250.0 * module, None)?;
    }
    within(
        "face_offset_mm",
        file.face_offset_mm.unwrap_or(0.0),
        -1e4,
        1e4,
        None,
    )?;
    for (name, gear) in [("gear1", &file.gear1), ("gear2", &file.gear2)] {
        check_gear(name, gear, file.normal_module_mm)?;
    }
    check_held_surfaces(file)?;
    check_operating(file)
}

fn check_gear(name: &str, g: &GearFile, module_mm: f64) -> Result<(), Refusal> {
    let field = |f: &str| format!("{name}.{f}");
    require(
        (4..=5000).contains(&g.teeth),
        field("teeth"),
        g.teeth,
        "lies outside 4 to 5000",
        "give the number of teeth, positive for a ring, too",
    )?;
    within(field("profile_shift"), g.profile_shift, -3.0, 3.0, None)?;
    positive(field("face_width_mm"), g.face_width_mm, 1e4, None)?;
    within(
        field("face_width_mm"),
        g.face_width_mm,
        FACE_OVER_MODULE[0] * module_mm,
        FACE_OVER_MODULE[1] * module_mm,
        slips::face_width(g.face_width_mm, module_mm),
    )?;
    if let Some(mm) = g.tip_diameter_mm {
        positive(field("tip_diameter_mm"), mm, 1e5, None)?;
        if let Some(addendum) = g.addendum_coefficient {
            return Err(Refusal::new(
                field("addendum_coefficient"),
                addendum,
                format!("`tip_diameter_mm` = {mm} says the same"),
                "give only one of them",
            ));
        }
    }
    if let Some(addendum) = g.addendum_coefficient {
        positive(field("addendum_coefficient"), addendum, 3.0, None)?;
    }
    positive(
        field("dedendum_coefficient"),
        g.dedendum_coefficient,
        3.0,
        None,
    )?;
    within(
        field("tool_tip_radius_coefficient"),
        g.tool_tip_radius_coefficient,
        0.0,
        1.0,
        None,
    )?;
    if let Some(mm) = g.bore_diameter_mm {
        positive(field("bore_diameter_mm"), mm, 1e5, None)?;
    }
    if let Some(mm) = g.rim_diameter_mm {
        positive(field("rim_diameter_mm"), mm, 1e5, None)?;
    }
    let modulus = g.youngs_modulus_gpa;
    positive(
        field("youngs_modulus_gpa"),
        modulus,
        2000.0,
        slips::modulus(modulus),
    )?;
    within(field("poisson_ratio"), g.poisson_ratio, 0.0, 0.49, None)?;
    check_amounts(name, g, module_mm)
}

/// Amounts of microgeometry: no more than a twentieth of the module, beyond which the flank is another flank and
/// no modification; those that only take material off not negative.
fn check_amounts(name: &str, g: &GearFile, module_mm: f64) -> Result<(), Refusal> {
    let most = 50.0 * module_mm;
    for (prefix, flank) in g.flanks() {
        for (field, um, low) in amounts(&flank, -most) {
            require(
                um >= low && um <= most,
                format!("{name}.{prefix}{field}"),
                um,
                if um >= low || low < 0.0 {
                    format!(
                        "exceeds a twentieth of the normal module, {} um",
                        rounded(most)
                    )
                } else {
                    "adds material".into()
                },
                "give the removal normal to the flank in micrometres, positive, as for a \
                 modification of the flank",
            )?;
        }
        let longest = 0.5 * g.face_width_mm;
        for (field, relief) in end_reliefs(&flank) {
            require(
                relief.length_mm > 0.0 && relief.length_mm <= longest,
                format!("{name}.{prefix}{field}.length_mm"),
                relief.length_mm,
                format!(
                    "must be above 0 and at most half of the face width, {} mm",
                    rounded(longest)
                ),
                "shorten the end relief, or use `lead_crowning_um` over the whole face",
            )?;
        }
    }
    Ok(())
}

fn end_reliefs(flank: &FlankFile) -> impl Iterator<Item = (&'static str, &EndReliefFile)> {
    [
        ("end_relief", &flank.end_relief),
        ("lower_end_relief", &flank.lower_end_relief),
        ("upper_end_relief", &flank.upper_end_relief),
    ]
    .into_iter()
    .filter_map(|(field, relief)| Some((field, relief.as_ref()?)))
}

/// Field, amount in um and least amount of every modification that is given; those of either sign may go down to
/// `least`.
pub(super) fn amounts(flank: &FlankFile, least: f64) -> Vec<(String, f64, f64)> {
    let mut all = Vec::new();
    for (field, relief) in [
        ("tip_relief", &flank.tip_relief),
        ("root_relief", &flank.root_relief),
    ] {
        all.extend(
            relief
                .iter()
                .map(|r| (format!("{field}.amount_um"), r.amount_um, 0.0)),
        );
    }
    all.extend(
        end_reliefs(flank).map(|(field, r)| (format!("{field}.amount_um"), r.amount_um, 0.0)),
    );
    for (field, um, low) in [
        ("profile_crowning_um", flank.profile_crowning_um, 0.0),
        ("profile_slope_um", flank.profile_slope_um, least),
        ("bias_um", flank.bias_um, least),
        ("lead_crowning_um", flank.lead_crowning_um, 0.0),
        ("lead_slope_um", flank.lead_slope_um, least),
    ] {
        all.extend(um.map(|um| (field.to_owned(), um, low)));
    }
    all
}

/// Bore or rim: which of them a gear may have says whether it is a ring.
fn check_held_surfaces(file: &PairFile) -> Result<(), Refusal> {
    let gears = [("gear1", &file.gear1), ("gear2", &file.gear2)];
    for (name, g) in gears {
        if let (Some(bore), Some(rim)) = (g.bore_diameter_mm, g.rim_diameter_mm) {
            return Err(Refusal::new(
                format!("{name}.rim_diameter_mm"),
                rim,
                format!("the gear also has a `bore_diameter_mm` = {bore}"),
                "give a bore for an external gear, a rim for a ring",
            ));
        }
    }
    match (
        file.meshing,
        file.gear1.rim_diameter_mm,
        file.gear2.rim_diameter_mm,
    ) {
        (Meshing::External, Some(rim), _) => Err(rim_of_external("gear1", rim)),
        (Meshing::External, _, Some(rim)) => Err(rim_of_external("gear2", rim)),
        (Meshing::Internal, Some(rim), Some(_)) => Err(Refusal::new(
            "gear1.rim_diameter_mm",
            rim,
            "gear 2 has a rim, too, and an internal pair has one ring",
            "give the external gear a `bore_diameter_mm` instead",
        )),
        (Meshing::Internal, None, None) => match file.gear2.bore_diameter_mm {
            Some(bore) => Err(Refusal::new(
                "gear2.bore_diameter_mm",
                bore,
                "gear 2 is the ring of this internal pair and is held at its outer rim",
                "give it `rim_diameter_mm`, or give that to gear 1 if gear 1 is the ring",
            )),
            None => Ok(()),
        },
        _ => Ok(()),
    }
}

fn rim_of_external(name: &str, rim: f64) -> Refusal {
    Refusal::new(
        format!("{name}.rim_diameter_mm"),
        rim,
        "both gears of an external pair are held at their bore",
        "give `bore_diameter_mm`, or say `\"meshing\": \"internal\"`",
    )
}

fn check_operating(file: &PairFile) -> Result<(), Refusal> {
    let o = &file.operating;
    let [least, most] = TORQUES;
    require(
        (least..=most).contains(&o.nominal_torque_nm),
        "operating.nominal_torque_nm",
        number(o.nominal_torque_nm),
        format!("lies outside {least:e} to {most:e}"),
        "give the torque on gear 1 in N m, above 0",
    )?;
    require(
        o.maximum_torque_nm >= o.nominal_torque_nm && o.maximum_torque_nm <= most,
        "operating.maximum_torque_nm",
        o.maximum_torque_nm,
        format!(
            "is no limit above the nominal torque, {}",
            o.nominal_torque_nm
        ),
        "give at least the nominal torque, on gear 1",
    )?;
    let ranges = [
        (
            "center_distance_offset_um",
            o.center_distance_offset_um,
            1e4,
        ),
        ("misalignment_mrad", o.misalignment_mrad, 20.0),
    ];
    for (name, [low, high], most) in ranges {
        let field = format!("operating.{name}");
        let value = format!("[{low}, {high}]");
        require(
            low <= high,
            &field,
            &value,
            "is reversed",
            "give the lower end first",
        )?;
        require(
            low <= 0.0 && high >= 0.0,
            &field,
            &value,
            "does not contain zero, the nominal state",
            "give deviations from nominal, such as [-1.0, 1.0] or [0.0, 0.0]",
        )?;
        require(
            low >= -most && high <= most,
            &field,
            &value,
            format!("goes beyond {most} on one side"),
            "narrow the range; check the unit in the name",
        )?;
    }
    Ok(())
}
