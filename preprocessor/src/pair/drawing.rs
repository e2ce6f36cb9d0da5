//! Quantities of a drawing: tooth thickness in its four forms, root diameter and lead, to and from what the gear is built
//! from. Formulas and names of ISO 21771-1.

use serde::de::{self, Deserializer, SeqAccess, Visitor};
use serde::{Deserialize, Serialize, Serializer};
use std::f64::consts::PI;

use super::error::{Refusal, ensure, refusal};
use super::file::{GearFile, PairFile};
use super::mesh_checks::field;
use super::resolve::{MM, UM, gear, gear_file, ring_index};
use gearmesh::gear::{Gear, GearKind, inverse_involute, involute};
use gearmesh::words::{fixed, rounded};

/// A dimension of a drawing: a number, or its limits, of which the middle counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Dimension {
    /// Without tolerance.
    Nominal(f64),
    /// Lower and upper limit.
    Limits([f64; 2]),
}

impl Dimension {
    /// The number that counts.
    pub fn middle(self) -> f64 {
        match self {
            Dimension::Nominal(value) => value,
            Dimension::Limits([low, high]) => 0.5 * (low + high),
        }
    }

    /// Half of the tolerance.
    pub(super) fn slack(self) -> f64 {
        match self {
            Dimension::Nominal(_) => 0.0,
            Dimension::Limits([low, high]) => 0.5 * (high - low),
        }
    }

    fn shown(self) -> String {
        match self {
            Dimension::Nominal(value) => rounded(value).to_string(),
            Dimension::Limits([low, high]) => format!("[{}, {}]", rounded(low), rounded(high)),
        }
    }
}

impl Serialize for Dimension {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        match self {
            Dimension::Nominal(value) => value.serialize(to),
            Dimension::Limits(limits) => limits.serialize(to),
        }
    }
}

impl<'a> Deserialize<'a> for Dimension {
    // An untagged enum would lose what is wrong with either form.
    fn deserialize<D: Deserializer<'a>>(from: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'a> Visitor<'a> for Either {
            type Value = Dimension;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a number, or [lower, upper]")
            }
            fn visit_f64<E: de::Error>(self, value: f64) -> Result<Dimension, E> {
                Ok(Dimension::Nominal(value))
            }
            fn visit_u64<E: de::Error>(self, value: u64) -> Result<Dimension, E> {
                Ok(Dimension::Nominal(value as f64))
            }
            fn visit_i64<E: de::Error>(self, value: i64) -> Result<Dimension, E> {
                Ok(Dimension::Nominal(value as f64))
            }
            fn visit_seq<A: SeqAccess<'a>>(self, mut seq: A) -> Result<Dimension, A::Error> {
                let mut limits = [0.0; 2];
                for (i, limit) in limits.iter_mut().enumerate() {
                    let missing = || de::Error::invalid_length(i, &self);
                    *limit = seq.next_element()?.ok_or_else(missing)?;
                }
                match seq.next_element::<f64>()? {
                    Some(_) => Err(de::Error::invalid_length(3, &self)),
                    None => Ok(Dimension::Limits(limits)),
                }
            }
        }
        from.deserialize_any(Either)
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
        let kappa = gear.kappa();
        // Half of the space there, and the pressure angle at the centre of the ball, which holds for spur teeth.
        let space = match gear.kind {
            GearKind::External => PI / gear.z() - psi,
            GearKind::Ring => -psi,
        } + involute((roll / rb).atan());
        let center = (roll / rb).atan() + space;
        let diameter = kappa * 2.0 * (rb * center.tan() - roll) / cos_b;
        let step = if diameter < 2.0 * MM {
            0.05 * MM
        } else {
            0.25 * MM
        };
        Gauges {
            span_teeth: k.round().clamp(1.0, gear.z()) as u32,
            ball_diameter: (diameter / step).round().max(1.0) * step,
        }
    }
}

/// Normal tooth thickness s_n on the reference circle, m.
pub fn normal_tooth_thickness(gear: &Gear) -> f64 {
    thickness_of(gear, gear.half_base_angle())
}

/// s_n of teeth (ring: of spaces) with the half angle `psi` on the base circle.
fn thickness_of(gear: &Gear, psi: f64) -> f64 {
    let involute = psi - involute(gear.transverse_pressure_angle());
    let width = 2.0 * gear.reference_radius() * involute * gear.helix_angle.cos();
    match gear.kind {
        GearKind::External => width,
        GearKind::Ring => PI * gear.normal_module - width,
    }
}

/// Profile shift coefficient with which teeth of the thickness s_n (m) are generated.
pub fn generating_profile_shift(gear: &Gear, thickness: f64) -> f64 {
    gear.kappa() * (thickness / gear.normal_module - 0.5 * PI)
        / (2.0 * gear.normal_pressure_angle.tan())
}

/// Span W_k over `k` teeth (ring: spaces), m; none for the helical teeth of a ring, which no span can touch.
pub fn span(gear: &Gear, k: u32) -> Option<f64> {
    let along =
        2.0 * gear.base_radius() * (gear.half_base_angle() + f64::from(k - 1) * PI / gear.z());
    has_span(gear).then(|| gear.base_helix_angle().cos() * along)
}

fn has_span(gear: &Gear) -> bool {
    gear.kind == GearKind::External || gear.helix_angle == 0.0
}

/// Radius at which a span of the length `span` (m) touches, m.
pub fn span_contact_radius(gear: &Gear, span: f64) -> f64 {
    gear.radius_at_roll(0.5 * span * gear.base_helix_angle().cos())
}

/// Dimension over balls (ring: between them) M_dK of the diameter `ball` (m), m; none where the ball does not fit between
/// the flanks.
pub fn over_balls(gear: &Gear, ball: f64) -> Option<f64> {
    let part = ball / (2.0 * gear.base_radius() * gear.base_helix_angle().cos());
    let involute = match gear.kind {
        GearKind::External => gear.half_base_angle() + part - PI / gear.z(),
        GearKind::Ring => gear.half_base_angle() - part,
    };
    let center = 2.0 * gear.base_radius() / inverse_involute(involute).cos();
    let over = center * chord(gear) + gear.kappa() * ball;
    (!over.is_nan()).then_some(over)
}

/// Radius at which balls of the diameter `ball` with the dimension `over` touch, m; NaN where they do not.
pub fn ball_contact_radius(gear: &Gear, ball: f64, over: f64) -> f64 {
    let center = gear.roll_length(0.5 * ball_circle(gear, ball, over));
    gear.radius_at_roll(center - gear.kappa() * 0.5 * ball * gear.base_helix_angle().cos())
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

/// Lead p_z, m, > 0 right-handed; infinite for spur teeth.
pub fn lead(gear: &Gear) -> f64 {
    gear.hand * gear.z() * PI * gear.normal_module / gear.helix_angle.sin()
}

/// A tooth thickness as the drawing gives it.
#[derive(Clone, Copy)]
enum Measure {
    Thickness,
    Span(u32),
    Balls(f64),
}

impl Measure {
    /// Those given for a gear, each with its field and value.
    fn all(g: &GearFile, i: usize) -> Result<Vec<(Measure, &'static str, Dimension)>, Refusal> {
        let mut all: Vec<_> = g
            .normal_tooth_thickness_mm
            .into_iter()
            .map(|s| (Measure::Thickness, "normal_tooth_thickness_mm", s))
            .collect();
        let alone = |name: &str, value: String, other: &str| refusal!(field(i, name) => value; "`{other}` is not given, and neither says anything alone"; "give both, or none");
        match (g.span_measurement_mm, g.span_teeth) {
            (Some(w), Some(k)) => all.push((Measure::Span(k), "span_measurement_mm", w)),
            (Some(w), None) => return Err(alone("span_measurement_mm", w.shown(), "span_teeth")),
            (None, Some(k)) => {
                return Err(alone("span_teeth", k.to_string(), "span_measurement_mm"));
            }
            (None, None) => {}
        }
        match (g.dimension_over_balls_mm, g.ball_diameter_mm) {
            (Some(m), Some(ball)) => {
                all.push((Measure::Balls(ball * MM), "dimension_over_balls_mm", m))
            }
            (Some(m), None) => {
                return Err(alone(
                    "dimension_over_balls_mm",
                    m.shown(),
                    "ball_diameter_mm",
                ));
            }
            (None, Some(ball)) => {
                return Err(alone(
                    "ball_diameter_mm",
                    ball.to_string(),
                    "dimension_over_balls_mm",
                ));
            }
            (None, None) => {}
        }
        Ok(all)
    }

    /// s_n (m) of teeth with this measure, m; NaN where there are none.
    fn thickness(self, gear: &Gear, value: f64) -> f64 {
        let (rb, cos_b) = (gear.base_radius(), gear.base_helix_angle().cos());
        match self {
            Measure::Thickness => value,
            Measure::Span(k) => thickness_of(
                gear,
                value / (2.0 * rb * cos_b) - f64::from(k - 1) * PI / gear.z(),
            ),
            Measure::Balls(ball) => {
                let center = involute((2.0 * rb / ball_circle(gear, ball, value)).acos());
                let part = ball / (2.0 * rb * cos_b);
                thickness_of(
                    gear,
                    match gear.kind {
                        GearKind::External => center - part + PI / gear.z(),
                        GearKind::Ring => center + part,
                    },
                )
            }
        }
    }

    /// This measure of `gear`, m; NaN where it has none.
    fn of(self, gear: &Gear) -> f64 {
        match self {
            Measure::Thickness => Some(normal_tooth_thickness(gear)),
            Measure::Span(k) => span(gear, k),
            Measure::Balls(ball) => over_balls(gear, ball),
        }
        .unwrap_or(f64::NAN)
    }

    /// Radius at which the gauge touches, m; none for the thickness itself.
    fn contact_radius(self, gear: &Gear, value: f64) -> Option<f64> {
        match self {
            Measure::Thickness => None,
            Measure::Span(_) => Some(span_contact_radius(gear, value)),
            Measure::Balls(ball) => Some(ball_contact_radius(gear, ball, value)),
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

/// The file with helix angle, profile shifts and dedenda in place of what gives them, and the thinning of the teeth of both
/// gears on the base circle, m, where the drawing has it.
pub(super) fn settle(file: &PairFile) -> Result<(PairFile, [Option<f64>; 2]), Refusal> {
    let mut file = file.clone();
    file.helix_angle_deg = Some(helix(&file)?);
    let thinning = [settle_gear(&mut file, 0)?, settle_gear(&mut file, 1)?];
    Ok((file, thinning))
}

/// The helix angle, degrees: the file's, which the leads must fit, or that of the first lead.
fn helix(file: &PairFile) -> Result<f64, Refusal> {
    let mut known = file.helix_angle_deg;
    for i in 0..2 {
        let Some(mm) = gear_file(file, i).lead_mm else {
            continue;
        };
        let name = field(i, "lead_mm");
        let g = gear(file, i, ring_index(file) == Some(i));
        let (per_sine, side) = (
            g.z() * PI * file.normal_module_mm,
            if i == 1 && ring_index(file).is_none() {
                -1.0
            } else {
                1.0
            },
        );
        let angle = side * (per_sine / mm).asin().to_degrees();
        ensure!(known != Some(0.0), name => mm;
            "the teeth are spur teeth: `helix_angle_deg` = 0"; "leave one of them out");
        ensure!(angle.abs() <= 60.0, name => mm;
            "is no lead of {} teeth of this module: a helix of 60 degrees has {:.3} mm", g.teeth, per_sine / 60f64.to_radians().sin();
            "give the axial length of a whole turn of the helix in millimetres, negative for left-handed teeth");
        let helix = *known.get_or_insert(angle);
        let right = side * per_sine / helix.to_radians().sin();
        ensure!((angle - helix).abs() <= ROUNDING_OF_HELIX, name => mm;
            "belongs to a helix of {angle:.4} degrees on gear 1, and {helix:.4} are given";
            "give {right:.4} (> 0 right-handed, < 0 left-handed), or another `helix_angle_deg`");
    }
    Ok(known.unwrap_or(0.0))
}

fn settle_gear(file: &mut PairFile, i: usize) -> Result<Option<f64>, Refusal> {
    let given = gear_file(file, i).clone();
    let mut g = gear(file, i, ring_index(file) == Some(i));
    let module = g.normal_module;
    let mut shift = given_shift(&given, g.kappa(), i)?;
    let is_named = shift.is_some();
    let measures = Measure::all(&given, i)?;
    for (measure, name, value) in &measures {
        ensure!(!matches!(measure, Measure::Span(_)) || has_span(&g), field(i, name) => value.shown();
            "no span can be measured on the helical teeth of a ring"; "give `dimension_over_balls_mm`");
    }
    let thickness = |g: &Gear| {
        let (measure, name, value) = *measures.first()?;
        Some((
            measure,
            name,
            value,
            measure.thickness(g, value.middle() * MM),
        ))
    };
    let thickness = thickness(&g);
    // The root circle tells the nominal profile shift where nothing else does: a thinned tooth has another one.
    if let (None, Some(root), Some(dedendum), Some(_)) = (
        shift,
        given.root_diameter_mm,
        given.dedendum_coefficient,
        thickness,
    ) {
        let at_root = 0.5 * root.middle() * MM - g.reference_radius();
        shift = Some(at_root / module + g.kappa() * dedendum);
    }
    let mut thinning = None;
    if let Some((measure, name, value, s)) = thickness {
        let generating = generating_profile_shift(&g, s);
        ensure!((-3.0..=3.0).contains(&generating), field(i, name) => value.shown();
        "belongs to no tooth of this gear (profile shift {generating:.3}); without profile shift it would be {:.4}",
        measure.of(&g) / MM;
        "check it{}", match measure {
            Measure::Thickness => "",
            Measure::Span(_) => " and `span_teeth`",
            Measure::Balls(_) => " and `ball_diameter_mm`",
        });
        let nominal = shift.unwrap_or(generating);
        g.profile_shift = nominal;
        let full = normal_tooth_thickness(&g);
        let right = measure.of(&g) / MM;
        let slack = match (is_named, given.root_diameter_mm) {
            // Read from a root diameter the profile shift is no finer than that.
            (false, Some(root)) => {
                (ROUNDING_OF_ROOT + root.slack() * MM) * g.normal_pressure_angle.tan() + ROUNDING
            }
            _ => ROUNDING + value.slack() * MM,
        };
        let [thinner, most] = [full - s, MOST_THINNING * module];
        ensure!(thinner >= -slack && thinner <= most, field(i, name) => value.shown();
            "makes the teeth {} um {} than their profile shift, {nominal:.4}, does, which gives {right:.4} mm",
            fixed(thinner.abs() / UM, 1), if thinner > 0.0 { "thinner" } else { "thicker" };
            "give {right:.4} or the measure of teeth a little thinner, or a `profile_shift` of {generating:.4}");
        if thinner < 0.0 {
            g.profile_shift = generating;
        }
        g.tooth_thinning =
            thinner.max(0.0) * g.transverse_pressure_angle().cos() / g.helix_angle.cos();
        thinning = Some(g.tooth_thinning);
        shift = Some(g.profile_shift);
    }
    for (measure, name, value) in &measures {
        let (right, given) = (measure.of(&g), value.middle() * MM);
        ensure!((right - given).abs() <= 2.0 * ROUNDING + value.slack() * MM, field(i, name) => value.shown();
            "does not fit `{}` = {}", measures[0].1, measures[0].2.shown(); "give {:.4}", right / MM);
    }
    g.profile_shift = shift.unwrap_or(0.0);
    let dedendum = dedendum(&given, &g, i)?;
    let target = if i == 0 {
        &mut file.gear1
    } else {
        &mut file.gear2
    };
    (target.profile_shift, target.profile_shift_iso_21771) = (shift, None);
    target.dedendum_coefficient = dedendum;
    let built = gear(file, i, g.kind == GearKind::Ring);
    for (measure, name, value) in &measures {
        let Some(radius) = measure.contact_radius(&g, value.middle() * MM) else {
            continue;
        };
        let within = [built.root_radius(), built.tip_radius];
        let (low, high) = (within[0].min(within[1]), within[0].max(within[1]));
        ensure!((low..=high).contains(&radius), field(i, name) => value.shown();
            "its gauge touches at diameter {:.3} mm, and the teeth reach from {:.3} to {:.3} mm",
            2.0 * radius / MM, 2.0 * low / MM, 2.0 * high / MM;
            "check the gauge, `tip_diameter_mm` and `root_diameter_mm`");
    }
    Ok(thinning)
}

/// The profile shift given by either of its fields, > 0 as in `profile_shift`.
fn given_shift(given: &GearFile, kappa: f64, i: usize) -> Result<Option<f64>, Refusal> {
    let iso = given.profile_shift_iso_21771.map(|x| (x, kappa * x));
    if let (Some(x), Some((iso, same))) = (given.profile_shift, iso) {
        ensure!((x - same).abs() <= 1e-9, field(i, "profile_shift_iso_21771") => iso;
            "`profile_shift` = {x} says otherwise"; "give one of them, or {}", rounded(kappa * x));
    }
    Ok(given.profile_shift.or(iso.map(|(_, x)| x)))
}

/// The dedendum coefficient given, or that of the root diameter, which must fit.
fn dedendum(given: &GearFile, g: &Gear, i: usize) -> Result<Option<f64>, Refusal> {
    let Some(root) = given.root_diameter_mm else {
        return Ok(given.dedendum_coefficient);
    };
    let depth = |radius: f64| {
        g.kappa() * (g.reference_radius() + g.normal_module * g.profile_shift - radius)
            / g.normal_module
    };
    let deep = depth(0.5 * root.middle() * MM);
    let name = field(i, "root_diameter_mm");
    let usual = Gear {
        dedendum_coefficient: given.dedendum_coefficient.unwrap_or(1.25),
        ..g.clone()
    };
    let right = 2.0 * usual.root_radius();
    if given.dedendum_coefficient.is_some() {
        let most = ROUNDING_OF_ROOT + root.slack() * MM;
        ensure!((root.middle() * MM - right).abs() <= most, &name => root.shown();
            "does not fit `dedendum_coefficient` = {} and the profile shift {:.4}, which give {:.3} mm",
            usual.dedendum_coefficient, g.profile_shift, right / MM;
            "give {:.3}, or leave `dedendum_coefficient` out", right / MM);
    }
    ensure!(deep > 0.0 && deep <= 3.0, &name => root.shown();
        "means a dedendum of {deep:.3} modules with the profile shift {:.4}, and must be above 0 and at most 3", g.profile_shift;
        "check it: a dedendum of {} gives {:.3} mm", usual.dedendum_coefficient, right / MM);
    Ok(Some(deep))
}
