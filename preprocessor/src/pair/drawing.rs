//! Quantities of a drawing: tooth thickness in its three forms, root diameter and lead, to and from what the gear is built
//! from; centre distance and backlash. Formulas and names of ISO 21771-1.

use std::f64::consts::PI;

use super::checks::{Refusal, about, ensure, in_gear, refusal, remedy};
use super::dimension::Dimension;
use super::file::{GearFile, MM, PairFile, UM, radius_of};
use super::gears::{set_circles, unshifted};
use gearmesh::gear::{Gear, GearKind, PairGeometry, inverse_involute, involute};
use gearmesh::words::{fixed, rounded};

/// A form in which drawings give the thickness of the teeth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Measure {
    /// Normal tooth thickness s_n on the reference circle.
    Thickness,
    /// Span W_k over so many teeth (ring: spaces).
    Span(u32),
    /// Dimension over balls (ring: between them) M_dK of this diameter, m.
    Balls(f64),
}

impl Measure {
    /// This measure of `gear`, m; none where no gauge touches: spans of a ring with helical teeth, balls that do not fit.
    pub fn of(self, gear: &Gear) -> Option<f64> {
        let (rb, psi) = (gear.base_radius(), gear.half_base_angle());
        let cos_b = gear.base_helix_angle().cos();
        let value = match self {
            Measure::Thickness => thickness_on_base(gear, psi),
            Measure::Span(_) if !has_span(gear) => f64::NAN,
            Measure::Span(k) => cos_b * (2.0 * rb * (psi + f64::from(k - 1) * PI / gear.z())),
            Measure::Balls(ball) => {
                let part = ball / (2.0 * rb * cos_b);
                let involute = match gear.kind {
                    GearKind::External => psi + part - PI / gear.z(),
                    GearKind::Ring => psi - part,
                };
                let center = 2.0 * rb / inverse_involute(involute).cos();
                center * chord(gear) + gear.kappa() * ball
            }
        };
        (!value.is_nan()).then_some(value)
    }

    /// s_n (m) of teeth of which this measure is `value` (m); NaN where there are none.
    fn thickness(self, gear: &Gear, value: f64) -> f64 {
        let (rb, cos_b) = (gear.base_radius(), gear.base_helix_angle().cos());
        let psi = match self {
            Measure::Thickness => return value,
            Measure::Span(k) => value / (2.0 * rb * cos_b) - f64::from(k - 1) * PI / gear.z(),
            Measure::Balls(ball) => {
                let center = involute((2.0 * rb / ball_circle(gear, ball, value)).acos());
                let part = ball / (2.0 * rb * cos_b);
                match gear.kind {
                    GearKind::External => center - part + PI / gear.z(),
                    GearKind::Ring => center + part,
                }
            }
        };
        thickness_on_base(gear, psi)
    }

    /// Radius at which a gauge touches that measures `value` (m), m; none for the thickness itself, NaN where it does not.
    pub fn contact_radius(self, gear: &Gear, value: f64) -> Option<f64> {
        let cos_b = gear.base_helix_angle().cos();
        let roll = match self {
            Measure::Thickness => return None,
            Measure::Span(_) => 0.5 * value * cos_b,
            Measure::Balls(ball) => {
                let center = gear.roll_length(0.5 * ball_circle(gear, ball, value));
                center - gear.kappa() * 0.5 * ball * cos_b
            }
        };
        Some(gear.radius_at_roll(roll))
    }
}

/// s_n of teeth (ring: of spaces) with the half angle `psi` on the base circle.
fn thickness_on_base(gear: &Gear, psi: f64) -> f64 {
    let involute = psi - involute(gear.transverse_pressure_angle());
    let width = 2.0 * gear.reference_radius() * involute * gear.helix_angle.cos();
    match gear.kind {
        GearKind::External => width,
        GearKind::Ring => PI * gear.normal_module - width,
    }
}

/// No span touches the helical teeth of a ring.
fn has_span(gear: &Gear) -> bool {
    gear.kind == GearKind::External || gear.helix_angle == 0.0
}

/// Diameter of the circle of the centres of the balls, m.
fn ball_circle(gear: &Gear, ball: f64, over: f64) -> f64 {
    (over - gear.kappa() * ball) / chord(gear)
}

/// Two balls of an odd number of teeth do not face each other.
fn chord(gear: &Gear) -> f64 {
    match gear.teeth % 2 {
        0 => 1.0,
        _ => (0.5 * PI / gear.z()).cos(),
    }
}

/// Profile shift coefficient with which teeth of the thickness s_n (m) are generated.
pub fn generating_profile_shift(gear: &Gear, thickness: f64) -> f64 {
    gear.kappa() * (thickness / gear.normal_module - 0.5 * PI)
        / (2.0 * gear.normal_pressure_angle.tan())
}

/// Lead p_z, m, > 0 right-handed; infinite for spur teeth.
pub fn lead(gear: &Gear) -> f64 {
    gear.hand * gear.z() * PI * gear.normal_module / gear.helix_angle.sin()
}

/// In words: spur, right or left.
pub fn hand(gear: &Gear) -> &'static str {
    match (gear.helix_angle > 0.0, gear.hand > 0.0) {
        (false, _) => "spur",
        (true, true) => "right",
        (true, false) => "left",
    }
}

/// With what the tooth thickness of a gear is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gauges {
    /// Number k of teeth (ring: of spaces) in the span.
    pub span_teeth: u32,
    /// Diameter D_M of the balls, m.
    pub ball_diameter: f64,
}

impl Gauges {
    /// Those that touch next to the middle of the teeth of `gear`, the circle r + x m_n: k, and D_M to a quarter of a
    /// millimetre, below 2 mm to a twentieth.
    pub fn usual(gear: &Gear) -> Gauges {
        let middle = gear.reference_radius() + gear.profile_shift * gear.normal_module;
        let (rb, psi) = (gear.base_radius(), gear.half_base_angle());
        let cos_b = gear.base_helix_angle().cos();
        let roll = gear.roll_length(middle.max(rb));
        let k = (2.0 * roll / cos_b.powi(2) - 2.0 * rb * psi) * gear.z() / (2.0 * PI * rb) + 1.0;
        // Half of the space there, and the pressure angle at the centre of the ball, which holds for spur teeth.
        let space = match gear.kind {
            GearKind::External => PI / gear.z() - psi,
            GearKind::Ring => -psi,
        } + involute((roll / rb).atan());
        let center = (roll / rb).atan() + space;
        let diameter = gear.kappa() * 2.0 * (rb * center.tan() - roll) / cos_b;
        let step = if diameter < 2.0 * MM { 0.05 } else { 0.25 } * MM;
        Gauges {
            span_teeth: k.round().clamp(1.0, gear.z()) as u32,
            ball_diameter: (diameter / step).round().max(1.0) * step,
        }
    }

    /// Those that the file names, else the usual ones.
    pub(super) fn of(given: &GearFile, gear: &Gear) -> Gauges {
        let (usual, ball) = (Gauges::usual(gear), given.ball_diameter_mm);
        Gauges {
            span_teeth: given.span_teeth.map_or(usual.span_teeth, i32::unsigned_abs),
            ball_diameter: ball.map_or(usual.ball_diameter, |mm| mm * MM),
        }
    }
}

/// Two measures of one tooth thickness are rounded to a micrometre each, m.
const ROUNDING: f64 = 2.0 * UM;
/// Root diameters are rounded to a hundredth of a millimetre, m.
const ROUNDING_OF_ROOT: f64 = 0.01 * MM;
/// Helix angles are rounded to a hundredth of a degree.
const ROUNDING_OF_HELIX: f64 = 0.006;
/// Teeth are thinner than their profile shift makes them by less than this, in normal modules: else it is another one.
const MOST_THINNING: f64 = 0.25;

/// The helix angle, degrees: the file's, which the leads must fit, or that of the first lead.
pub(super) fn helix(file: &PairFile) -> Result<f64, Refusal> {
    let mut known = file.helix_angle_deg;
    for i in 0..2 {
        let g = file.gear(i);
        let Some(mm) = g.lead_mm else { continue };
        let name = in_gear(i, "lead_mm");
        let is_other_hand = i == 1 && file.ring().is_none();
        let side = if is_other_hand { -1.0 } else { 1.0 };
        let per_sine = f64::from(g.number_of_teeth()) * PI * file.normal_module_mm;
        let angle = side * (per_sine / mm).asin().to_degrees();
        ensure!(known != Some(0.0), name => mm;
            "the teeth are spur teeth: `helix_angle_deg` = 0"; "leave one of them out");
        ensure!(angle.abs() <= 60.0, name => mm;
            "is no lead of {} teeth of this module: a helix of 60 degrees has {:.3} mm",
            g.number_of_teeth(), per_sine / 60f64.to_radians().sin();
            "give the axial length of a whole turn of the helix in millimetres, negative for left-handed teeth");
        let helix = *known.get_or_insert(angle);
        let right = side * per_sine / helix.to_radians().sin();
        ensure!((angle - helix).abs() <= ROUNDING_OF_HELIX, name => mm;
            "belongs to a helix of {angle:.4} degrees on gear 1, and {helix:.4} are given";
            "give {right:.4} (> 0 right-handed, < 0 left-handed), or another `helix_angle_deg`");
    }
    Ok(known.unwrap_or(0.0))
}

/// A tooth thickness as the drawing gives it: the measure, its field and its value.
type Given = (Measure, &'static str, Dimension);

/// The tooth thicknesses given for gear `i`.
fn thicknesses(g: &GearFile, gear: &Gear, i: usize) -> Result<Vec<Given>, Refusal> {
    let mut all: Vec<Given> = Vec::new();
    if let Some(value) = g.normal_tooth_thickness_mm {
        all.push((Measure::Thickness, "normal_tooth_thickness_mm", value));
    }
    let mut add = |field, value: Option<Dimension>, gauge, measure: Option<(Measure, f64)>| {
        let (name, alone, other) = match (value, measure) {
            (None, None) => return Ok(()),
            (Some(value), Some((measure, _))) => {
                let is_possible = !matches!(measure, Measure::Span(_)) || has_span(gear);
                ensure!(is_possible, in_gear(i, field) => value;
                    "no span can be measured on the helical teeth of a ring"; "give `dimension_over_balls_mm`");
                all.push((measure, field, value));
                return Ok(());
            }
            (Some(value), None) => (field, value.to_string(), gauge),
            (None, Some((_, size))) => (gauge, rounded(size).to_string(), field),
        };
        Err(refusal!(in_gear(i, name) => alone;
            "`{other}` is not given, and neither says anything alone"; "give both, or none"))
    };
    let span = g
        .span_teeth
        .map(|k| (Measure::Span(k.unsigned_abs()), f64::from(k)));
    add(
        "span_measurement_mm",
        g.span_measurement_mm,
        "span_teeth",
        span,
    )?;
    let (over, balls) = (g.dimension_over_balls_mm, g.ball_diameter_mm);
    let balls = balls.map(|mm| (Measure::Balls(mm * MM), mm));
    add("dimension_over_balls_mm", over, "ball_diameter_mm", balls)?;
    Ok(all)
}

/// Gear `i` with the profile shift, the thinning of the teeth and the dedendum that the drawing says, and a helix angle of
/// `helix` degrees on gear 1; without a body.
pub(super) fn gear(file: &PairFile, i: usize, helix: f64) -> Result<Gear, Refusal> {
    let given = file.gear(i);
    let mut g = unshifted(file, i, helix);
    let thicknesses = thicknesses(given, &g, i)?;
    let (x, iso) = (given.profile_shift, given.profile_shift_iso_21771);
    if let (Some(x), Some(iso)) = (x, iso) {
        let right = rounded(g.kappa() * x);
        ensure!((x - g.kappa() * iso).abs() <= 1e-9, in_gear(i, "profile_shift_iso_21771") => iso;
            "`profile_shift` = {x} says otherwise"; "give one of them, or {right}");
    }
    let mut shift = x.or(iso.map(|x| g.kappa() * x));
    if let Some(&(measure, first, value)) = thicknesses.first() {
        let path = in_gear(i, first);
        let s = measure.thickness(&g, value.middle() * MM);
        let right = |g: &Gear| measure.of(g).unwrap_or(f64::NAN) / MM;
        let generating = generating_profile_shift(&g, s);
        ensure!(generating.is_finite(), path => value; "is no measure of this gear with its gauge";
            "check both, `span_teeth` or `ball_diameter_mm`");
        let usual = match right(&g) {
            mm if mm.is_finite() => format!("without profile shift it would be {mm:.4}"),
            _ => "its gauge fits no tooth without profile shift".into(),
        };
        ensure!((-3.0..=3.0).contains(&generating), path => value;
            "belongs to no tooth of this gear (profile shift {generating:.3}); {usual}";
            "check it and its gauge, `span_teeth` or `ball_diameter_mm`");
        // Read from a root diameter the profile shift is no finer than that.
        let of_root = given.root_diameter_mm.filter(|_| shift.is_none());
        let slack = of_root.map_or(value.slack() * MM, |root| {
            (ROUNDING_OF_ROOT + root.slack() * MM) * g.normal_pressure_angle.tan()
        }) + ROUNDING;
        // The root circle gives the nominal profile shift where nothing else does: a thinned tooth has another one.
        let at_root = (of_root.zip(given.dedendum_coefficient)).map(|(root, dedendum)| {
            let above = radius_of(root.middle()) - g.reference_radius();
            above / g.normal_module + g.kappa() * dedendum
        });
        let nominal = shift.or(at_root).unwrap_or(generating);
        g.profile_shift = nominal;
        let thinner = thickness_on_base(&g, g.half_base_angle()) - s;
        ensure!(thinner >= -slack && thinner <= MOST_THINNING * g.normal_module, path => value;
            "makes the teeth {} um {} than their profile shift, {nominal:.4}, does, which gives {:.4} mm",
            fixed(thinner.abs() / UM, 1), if thinner > 0.0 { "thinner" } else { "thicker" }, right(&g);
            "give {:.4} or the measure of teeth a little thinner, or a `profile_shift` of {generating:.4}", right(&g));
        if thinner < 0.0 {
            g.profile_shift = generating;
        }
        g.tooth_thinning =
            thinner.max(0.0) * g.transverse_pressure_angle().cos() / g.helix_angle.cos();
        shift = Some(g.profile_shift);
        for (measure, field, other) in &thicknesses {
            let right = measure.of(&g).unwrap_or(f64::NAN);
            let most = 2.0 * ROUNDING + other.slack() * MM;
            ensure!((right - other.middle() * MM).abs() <= most, in_gear(i, field) => other;
                "does not fit `{first}` = {value}"; "give {:.4}", right / MM);
        }
    }
    g.profile_shift = shift.unwrap_or(0.0);
    g.dedendum_coefficient = dedendum(given, &g, i)?;
    set_circles(given, &mut g);
    let (root, tip) = (g.root_radius(), g.tip_radius);
    let [low, high] = [root.min(tip), root.max(tip)].map(|radius| 2.0 * radius / MM);
    for (measure, field, value) in thicknesses {
        if let Some(radius) = measure.contact_radius(&g, value.middle() * MM) {
            let touches = 2.0 * radius / MM;
            ensure!((low..=high).contains(&touches), in_gear(i, field) => value;
                "its gauge touches at diameter {touches:.3} mm, and the teeth reach from {low:.3} to {high:.3} mm";
                "check the gauge, `tip_diameter_mm` and `root_diameter_mm`");
        }
    }
    Ok(g)
}

/// The dedendum coefficient of `g`, or that of the root diameter, which must fit one that is given.
fn dedendum(given: &GearFile, g: &Gear, i: usize) -> Result<f64, Refusal> {
    let Some(root) = given.root_diameter_mm else {
        return Ok(g.dedendum_coefficient);
    };
    let name = in_gear(i, "root_diameter_mm");
    let (x, right) = (g.profile_shift, 2.0 * g.root_radius());
    if let Some(dedendum) = given.dedendum_coefficient {
        let most = ROUNDING_OF_ROOT + root.slack() * MM;
        ensure!((root.middle() * MM - right).abs() <= most, name => root;
            "does not fit `dedendum_coefficient` = {dedendum} and the profile shift {x:.4}, which give {:.3} mm", right / MM;
            "give {:.3}, or leave `dedendum_coefficient` out", right / MM);
    }
    let deep = g.kappa() * (g.reference_radius() + g.normal_module * x - radius_of(root.middle()))
        / g.normal_module;
    ensure!(deep > 0.0 && deep <= 3.0, name => root;
        "means a dedendum of {deep:.3} modules with the profile shift {x:.4}, and must be above 0 and at most 3";
        "check it: a dedendum of {} gives {:.3} mm", g.dedendum_coefficient, right / MM);
    Ok(deep)
}

/// A centre distance on a drawing is rounded to a micrometre: one that is short of the backlash-free
/// one by less is taken as that without backlash.
const ROUNDING_OF_CENTER_DISTANCE: f64 = 1e-6;
/// Profile shifts are rounded to three digits at least: both together are off by less than this.
const ROUNDING_OF_SHIFTS: f64 = 1e-3;
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

/// Thins the teeth of which the drawing does not give the thickness, alike, so that the backlash of the file results. A note
/// where rounded profile shifts leave less than none.
pub(super) fn set_backlash(
    file: &PairFile,
    geometry: &mut PairGeometry,
) -> Result<Option<String>, Refusal> {
    let given = [&file.gear1, &file.gear2].map(|g| {
        let measured = g.span_measurement_mm.or(g.dimension_over_balls_mm);
        g.normal_tooth_thickness_mm.or(measured).is_some()
    });
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
        // On the line of action, as `natural`.
        let gear = &geometry.gears[0];
        let of_shifts = 2.0
            * ROUNDING_OF_SHIFTS
            * gear.normal_module
            * gear.normal_pressure_angle.tan()
            * gear.transverse_pressure_angle().cos()
            / gear.helix_angle.cos();
        let are_rounded = given == [false; 2] && -natural < of_shifts;
        ensure!(natural >= 0.0 || is_rounding || are_rounded, "center_distance_mm" => c / MM;
            "the teeth jam by {:.1} um at the operating pitch circle", -natural / cos_phi / UM;
            "give {:.4} or {}, or thin the teeth by `backlash_um`",
            free / MM, if geometry.e() > 0.0 { "more" } else { "less" });
        thin(geometry, given, -natural);
        return Ok((natural < 0.0 && !is_rounding).then(|| {
            format!(
                "the profile shifts lack {:.1} um of play at the operating pitch circle, as rounding may leave them; the teeth are \
                 thinned by it to no backlash, and `backlash_um` gives them some",
                -natural / cos_phi / UM
            )
        }));
    };
    let [um, left] = [rounded(wanted / UM * scale), natural / UM * scale];
    let thinning = wanted - natural;
    if given == [true; 2] {
        let slack = file.normal_backlash_um.map_or(0.0, |j| j.slack()) * UM;
        ensure!(thinning.abs() <= ROUNDING_OF_BACKLASH + slack, name => um;
            "tooth thicknesses and centre distance leave {left:.1} um"; "give {left:.1}, or leave it out");
        return Ok(None);
    }
    let otherwise = "give at least that, or change `center_distance_mm` or `profile_shift`";
    let remedy = remedy(name, um, [left, f64::INFINITY], otherwise);
    // A billionth of a metre: rounding of the file, no thicker teeth.
    ensure!(thinning >= -1e-9, name => um;
        "centre distance and profile shifts alone give {left:.1} um"; "{remedy}");
    thin(geometry, given, thinning);
    Ok(None)
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

/// `length` (m) in whole micrometres.
fn um(length: f64) -> String {
    fixed(length / UM, 0)
}

/// A note on teeth whose thickness does not fit the centre distance.
pub(super) fn odd_thickness(file: &PairFile, geometry: &PairGeometry) -> Option<String> {
    let (c, gears) = (geometry.center_distance, &geometry.gears);
    let module = gears[0].normal_module;
    let phi = geometry.operating_pressure_angle(c);
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
