//! The teeth of a gear: profile shift, thickness, root and tip, from what a REXS file gives of gear, tool and settings.

use gearmesh::gear::{Gear, involute};
use gearmesh::words::rounded;
use serde_json::{Map, Value, json};

use super::account::Head;
use super::draft::Draft;
use super::given::{Given, agreed, first, um};
use super::model::Result;
use crate::gear::protuberance_form_radius;
use crate::pair;

pub(super) type Fields = Map<String, Value>;

/// Tools whose profile cuts the teeth; the last one is there since version 2.0.
pub(super) const TOOLS: [&str; 3] = ["rack_shaped_tool", "cutter_wheel_tool", "profile_tool"];

pub(super) const SETTINGS: &str = "cylindrical_gear_manufacturing_settings";
pub(super) const GENERATED_SHIFT: &str = "generated_addendum_modification_coefficient";

/// What both gears have in common, with the signs of ISO 21771: those of a ring negative.
pub(super) struct Basic {
    pub module: f64,
    /// Normal pressure angle and helix angle, rad.
    pub alpha: f64,
    pub helix: f64,
    pub teeth: [f64; 2],
}

impl Basic {
    pub(super) fn transverse_pressure_angle(&self) -> f64 {
        (self.alpha.tan() / self.helix.cos()).atan()
    }

    /// mm.
    pub(super) fn reference_diameter(&self, i: usize) -> f64 {
        self.teeth[i] * self.module / self.helix.cos()
    }

    /// s_n of teeth with the profile shift `x`, mm.
    fn thickness(&self, x: f64) -> f64 {
        rounded(self.module * (std::f64::consts::FRAC_PI_2 + 2.0 * x * self.alpha.tan()))
    }

    /// Sum of the profile shifts without backlash at the centre distance `a`, mm.
    pub(super) fn shift_sum(&self, a: f64) -> f64 {
        let alpha = self.transverse_pressure_angle();
        let zero = 0.5 * (self.reference_diameter(0) + self.reference_diameter(1));
        let working = (zero.abs() * alpha.cos() / a).acos();
        (self.teeth[0] + self.teeth[1]) * (involute(working) - involute(alpha))
            / (2.0 * self.alpha.tan())
    }
}

/// Difference of the thicknesses that a file and its profile shift give, up to which it is rounding, mm.
const ROUNDING_OF_THICKNESS: f64 = 1e-3;

/// The thickness of teeth that a file gives.
enum Thickness {
    /// That of the profile shift, which leaves the backlash open.
    OfShift,
    /// Limits of s_n, mm.
    Limits([f64; 2]),
}

impl Thickness {
    /// Whether `limits` say nothing else.
    fn fits(&self, limits: [f64; 2]) -> bool {
        match self {
            Thickness::OfShift => true,
            Thickness::Limits([low, high]) => {
                limits[0] - ROUNDING_OF_THICKNESS <= *high
                    && *low <= limits[1] + ROUNDING_OF_THICKNESS
            }
        }
    }
}

/// [lower, upper] of a pair file, one number where both are the same.
fn interval(limits: [f64; 2]) -> Value {
    match limits.map(rounded) {
        [low, high] if low == high => json!(low),
        limits => json!(limits),
    }
}

impl Draft<'_> {
    /// The backlash of the stage as field of a pair file and value, um; none where it has none.
    pub(super) fn backlash(&mut self) -> Result<Option<(&'static str, Value)>> {
        for (section, field) in [
            ("normal", "normal_backlash_um"),
            ("transverse", "backlash_um"),
        ] {
            let [least, most] = ["minimum", "maximum"]
                .map(|end| first(&[self.stage], &[&format!("{end}_{section}_backlash")]));
            let (least, most) = (least?, most?);
            let (head, limits, from) = match (least, most) {
                (None, None) => continue,
                (Some(least), Some(most)) => (
                    Head::Derived,
                    [least.value, most.value],
                    format!("{} and {}", least.origin, most.origin),
                ),
                (Some(one), None) | (None, Some(one)) => (
                    Head::Assumed,
                    [one.value; 2],
                    format!("{}, as the other limit is not given", one.origin),
                ),
            };
            let limits = limits.map(um);
            let value = match section {
                "normal" => interval(limits),
                // The field takes one number.
                _ => json!(rounded(0.5 * (limits[0] + limits[1]))),
            };
            let line = format!("{field} = {value} from {from}");
            self.account.add(head, line);
            return Ok(Some((field, value)));
        }
        Ok(None)
    }

    /// Profile shifts that are not given, from the centre distance.
    pub(super) fn shifts(
        &mut self,
        basic: &Basic,
        distance: Option<f64>,
        gears: &mut [Fields; 2],
    ) -> Result<()> {
        let field = "profile_shift_iso_21771";
        let given = [0, 1].map(|i| gears[i].get(field).and_then(Value::as_f64));
        let sum = distance
            .map(|mm| basic.shift_sum(mm))
            .filter(|sum| sum.is_finite());
        let Some(sum) = sum else {
            for i in [0, 1].into_iter().filter(|i| given[*i].is_none()) {
                self.account
                    .add(Head::Assumed, format!("gear{}.{field} = 0", i + 1));
            }
            return Ok(());
        };
        let values = match given {
            [Some(_), Some(_)] => return Ok(()),
            [Some(x1), None] => [x1, sum - x1],
            [None, Some(x2)] => [sum - x2, x2],
            // A ring takes all of it, so that a pinion of many mates stays what it is.
            [None, None] if self.is_ring(1) => [0.0, sum],
            [None, None] => [0.5 * sum; 2],
        };
        for i in [0, 1].into_iter().filter(|i| given[*i].is_none()) {
            let value = if values[i].abs() < 1e-6 {
                0.0
            } else {
                rounded(values[i])
            };
            gears[i].insert(field.into(), json!(value));
            let (name, mm) = (
                format!("gear{}.{field} = {value}", i + 1),
                distance.unwrap_or(0.0),
            );
            let (head, why) = match given {
                [None, None] => (
                    Head::Assumed,
                    format!(
                        "the sum {sum:.5} follows from the centre distance {mm} mm without backlash, its parts do not"
                    ),
                ),
                _ => (
                    Head::Derived,
                    format!(
                        "from that of the other gear and the centre distance {mm} mm without backlash"
                    ),
                ),
            };
            self.account.add(head, format!("{name}: {why}"));
        }
        Ok(())
    }

    /// Measures of the tooth thickness, else that of the generating profile shift x_E with its limits, else s_n as it stands.
    pub(super) fn tooth_thickness(
        &mut self,
        i: usize,
        basic: &Basic,
        has_backlash: bool,
        fields: &mut Fields,
    ) -> Result<()> {
        let name = ["gear1", "gear2"][i];
        if self.gauged(i, fields)? {
            return Ok(());
        }
        let field = "normal_tooth_thickness_mm";
        let given = self.thickness_given(i, basic, fields)?;
        let x_e = self.generated_shift(i)?;
        let (value, origin) = match (x_e, given) {
            (Some([_, low, high]), given) => {
                let limits = [low, high].map(|x| basic.thickness(x));
                if let Some((_, other)) = given.filter(|(other, _)| !other.fits(limits)) {
                    let line = format!(
                        "{name}.{field}: {other}, but {GENERATED_SHIFT} says {} to {}: the latter counts",
                        limits[0], limits[1]
                    );
                    self.account.add(Head::Warning, line);
                }
                let origin = format!("{GENERATED_SHIFT}, x_E {low} to {high}");
                (interval(limits), origin)
            }
            (None, Some((Thickness::Limits(limits), origin))) => (interval(limits), origin),
            (None, given) => {
                let line = match (given, has_backlash) {
                    (Some((_, origin)), _) => {
                        format!("{name}: teeth of the thickness of the profile shift, as {origin}")
                    }
                    (None, true) => {
                        format!("{name}: teeth of the thickness that the backlash leaves")
                    }
                    (None, false) => format!(
                        "{name}: teeth of the thickness that profile shift and centre distance leave"
                    ),
                };
                self.account.add(Head::Assumed, line);
                return Ok(());
            }
        };
        let line = format!("{name}.{field} = {value} from {origin}");
        self.account.add(Head::Derived, line);
        fields.insert(field.into(), value);
        Ok(())
    }

    /// Whether the file has a span or a size over balls of gear `i` with its gauge, which go to `fields` with their allowances.
    fn gauged(&mut self, i: usize, fields: &mut Fields) -> Result<bool> {
        let name = ["gear1", "gear2"][i];
        for (measure, size, value_of, size_of, allowance) in [
            (
                "span_measurement_mm",
                "span_teeth",
                "span_measurement",
                "number_of_teeth_for_span_measurement",
                "referenced_to_span",
            ),
            (
                "dimension_over_balls_mm",
                "ball_diameter_mm",
                "size_over_balls",
                "diameter_of_measuring_ball_or_pin",
                "balls_or_pins",
            ),
        ] {
            let parts = self.teeth[i].clone();
            let [value, gauge] = [value_of, size_of].map(|attribute| first(&parts, &[attribute]));
            let (Some(value), Some(gauge)) = (value?, gauge?) else {
                continue;
            };
            let number = match size {
                "span_teeth" => json!(gauge.value.abs() as u64),
                _ => json!(gauge.value),
            };
            fields.insert(size.into(), number);
            self.taken(&format!("{name}.{size}"), &gauge);
            let ends =
                ["lower", "upper"].map(|end| format!("{end}_backlash_allowance_{allowance}"));
            let nominal = value.value.abs();
            match self.deviations(i, &ends)? {
                Some(deviations) => {
                    // Of a negative length allowances are those of that number.
                    let [a, b] = deviations.map(|deviation| (value.value + deviation).abs());
                    let limits = interval([a.min(b), a.max(b)]);
                    let line = format!(
                        "{name}.{measure} = {limits} from {} = {nominal} and {}",
                        value.origin,
                        ends.join(", ")
                    );
                    self.account.add(Head::Derived, line);
                    fields.insert(measure.into(), limits);
                }
                None => {
                    self.taken(&format!("{name}.{measure}"), &value);
                    fields.insert(measure.into(), json!(nominal));
                }
            }
            return Ok(true);
        }
        Ok(false)
    }

    /// Deviations of gear `i` under the two names, mm, the lower one first; none, with a warning, where one is missing or they are not in order.
    fn deviations(&mut self, i: usize, names: &[String; 2]) -> Result<Option<[f64; 2]>> {
        let [low, high] = names.each_ref().map(|name| first(&self.teeth[i], &[name]));
        match (low?, high?) {
            (None, None) => return Ok(None),
            (Some(low), Some(high)) if low.value <= high.value => {
                return Ok(Some([low.value, high.value]));
            }
            _ => (),
        }
        let line = format!(
            "{} of gear {} are left out: a lower one and an upper one that is no less are needed",
            names.join(", "),
            i + 1
        );
        self.account.add(Head::Warning, line);
        Ok(None)
    }

    /// s_n of gear `i` with its deviations as the file gives them, in the normal section or the transverse one, and where from.
    fn thickness_given(
        &mut self,
        i: usize,
        basic: &Basic,
        fields: &Fields,
    ) -> Result<Option<(Thickness, String)>> {
        let nominal = basic.thickness(number(fields, "profile_shift_iso_21771").unwrap_or(0.0));
        let cos = basic.helix.cos();
        for (section, ends, scale) in [
            ("normal", "chordal", 1.0),
            ("transverse", "chordal_transverse", cos),
        ] {
            let name = format!("{section}_tooth_thickness_at_reference_diameter");
            let given = first(&self.teeth[i], &[&name])?;
            let names =
                ["lower", "upper"].map(|end| format!("{ends}_tooth_thickness_{end}_deviation"));
            let deviations = self.deviations(i, &names)?;
            let s_n = given
                .as_ref()
                .map_or(nominal, |given| rounded(scale * given.value));
            let is_nominal = (s_n - nominal).abs() <= ROUNDING_OF_THICKNESS;
            let origin = given.map(|given| format!("{} = {}", given.origin, given.value));
            return Ok(Some(match (deviations, origin) {
                (Some(deviations), origin) => {
                    let limits = |base: f64| deviations.map(|d| rounded(base + scale * d));
                    // Programs write the thickness without its deviations, or one that has them.
                    let [low, high] = limits(nominal);
                    let slack = ROUNDING_OF_THICKNESS;
                    let base = if (low - slack..=high + slack).contains(&s_n) {
                        nominal
                    } else {
                        s_n
                    };
                    let origin = origin.unwrap_or_else(|| format!("the profile shift, {nominal}"));
                    (
                        Thickness::Limits(limits(base)),
                        format!("{origin} and {}", names.join(", ")),
                    )
                }
                (None, Some(origin)) if is_nominal => (Thickness::OfShift, origin),
                (None, Some(origin)) => (Thickness::Limits([s_n; 2]), origin),
                (None, None) => continue,
            }));
        }
        Ok(None)
    }

    /// The generating profile shift of gear `i`: as it stands, its lower and its upper limit. Programs write the limits
    /// themselves, or their deviations, under the same names.
    pub(super) fn generated_shift(&self, i: usize) -> Result<Option<[f64; 3]>> {
        let settings = self.beside(i, &[SETTINGS]);
        let Some(x) = first(&settings, &[GENERATED_SHIFT])? else {
            return Ok(None);
        };
        let [low, high] = ["lower", "upper"]
            .map(|end| first(&settings, &[&format!("{GENERATED_SHIFT}_{end}_deviation")]));
        let limits = match (low?, high?) {
            (Some(low), Some(high)) => {
                let slack = 1e-9;
                let is_absolute = low.value - slack <= x.value && x.value <= high.value + slack;
                let zero = if is_absolute { 0.0 } else { x.value };
                [zero + low.value, zero + high.value]
            }
            _ => [x.value; 2],
        };
        Ok(Some([x.value, limits[0], limits[1]]))
    }

    /// Root circle and start of the usable involute: what the file gives, else what the tool cuts with the generating profile
    /// shift and the machining allowance, under a protuberance.
    pub(super) fn root(&mut self, i: usize, basic: &Basic, fields: &mut Fields) -> Result<()> {
        let settings = self.beside(i, &[SETTINGS]);
        let allowance = first(&settings, &["machining_allowance"])?;
        let stock = allowance.map_or(0.0, |q| q.value.max(0.0));
        self.root_circle(i, basic, stock, fields)?;
        self.root_form(i, basic, stock, fields)
    }

    /// The root circle, under a machining allowance of `stock` mm.
    fn root_circle(
        &mut self,
        i: usize,
        basic: &Basic,
        stock: f64,
        fields: &mut Fields,
    ) -> Result<()> {
        let name = ["gear1", "gear2"][i];
        let nominal = number(fields, "profile_shift_iso_21771").unwrap_or(0.0);
        let generating = self.generated_shift(i)?.map_or(nominal, |limits| limits[0]);
        // A tool that leaves an allowance stands farther out.
        let generated = generating + stock / (basic.module * basic.alpha.sin());
        let cut = number(fields, "dedendum_coefficient").map(|dedendum| {
            (basic.reference_diameter(i) + 2.0 * basic.module * (generated - dedendum)).abs()
        });
        match (number(fields, "root_diameter_mm"), cut) {
            (Some(root), Some(cut)) => {
                fields.remove("dedendum_coefficient");
                if (root - cut).abs() > 0.02 {
                    let line = format!(
                        "{name}.root_diameter_mm = {root} of the file, but its tool cuts {cut:.4}: the diameter counts"
                    );
                    self.account.add(Head::Warning, line);
                }
            }
            (None, Some(cut)) if generated != nominal => {
                fields.remove("dedendum_coefficient");
                let root = rounded(cut);
                fields.insert("root_diameter_mm".into(), json!(root));
                let line = format!(
                    "{name}.root_diameter_mm = {root} from the tool at the generating profile shift {generated:.5}{}",
                    if stock > 0.0 {
                        format!(", which a machining allowance of {stock} mm raises")
                    } else {
                        String::new()
                    }
                );
                self.account.add(Head::Derived, line);
            }
            _ => {}
        }
        Ok(())
    }

    /// The start of the usable involute that a protuberance leaves, of which grinding takes off `stock` mm.
    fn root_form(
        &mut self,
        i: usize,
        basic: &Basic,
        stock: f64,
        fields: &mut Fields,
    ) -> Result<()> {
        let (name, tools) = (["gear1", "gear2"][i], self.beside(i, &TOOLS));
        let protuberance = match first(&tools, &["protuberance_amount"])? {
            Some(given) => Some(given),
            None => first(&tools, &["protuberance_amount_factor"])?.map(|factor| Given {
                value: rounded(factor.value * basic.module),
                ..factor
            }),
        };
        let angle = first(&tools, &["protuberance_angle"])?;
        let Some(protuberance) = protuberance
            .filter(|given| given.value > 0.0 && !fields.contains_key("root_form_diameter_mm"))
        else {
            return Ok(());
        };
        let undercut = rounded(protuberance.value - stock);
        let words = format!(
            "protuberance {} mm less machining allowance {stock} mm",
            protuberance.value
        );
        if undercut <= 0.0 {
            let line = format!("{name}: no undercut is left: {words}");
            self.account.add(Head::Derived, line);
            return Ok(());
        }
        let angle = angle.map_or(basic.alpha, |angle| angle.value.to_radians());
        let form = self
            .bare_gear(i, basic, fields)
            .and_then(|gear| protuberance_form_radius(&gear, 1e-3 * undercut, angle));
        match form {
            Some(radius) => {
                let mm = rounded(2e3 * radius);
                fields.insert("root_form_diameter_mm".into(), json!(mm));
                self.account.add(
                    Head::Derived,
                    format!("{name}.root_form_diameter_mm = {mm} from {words}"),
                );
            }
            None => self.account.add(
                Head::Warning,
                format!(
                    "{name}: left out: {words}, for which no start of the usable involute follows"
                ),
            ),
        }
        Ok(())
    }

    /// Gear `i` with these fields, alone: its teeth are what the pair makes of them.
    pub(super) fn bare_gear(&self, i: usize, basic: &Basic, fields: &Fields) -> Option<Gear> {
        if self.is_ring(i) {
            return None;
        }
        let mut alike = json!({
            "teeth": fields.get("teeth"), "face_width_mm": 10.0 * basic.module,
            "profile_shift": fields.get("profile_shift_iso_21771"), "root_diameter_mm": fields.get("root_diameter_mm"),
            "dedendum_coefficient": fields.get("dedendum_coefficient"), "addendum_coefficient": 0.9,
            "tool_tip_radius_coefficient": fields.get("tool_tip_radius_coefficient")
        });
        alike.as_object_mut()?.retain(|_, value| !value.is_null());
        let file = json!({
            "name": "alone", "meshing": "external", "normal_module_mm": basic.module,
            "normal_pressure_angle_deg": basic.alpha.to_degrees(), "helix_angle_deg": basic.helix.to_degrees(),
            "gear1": alike, "gear2": alike,
            "operating": {
                "nominal_torque_nm": 1.0, "maximum_torque_nm": 1.0,
                "center_distance_offset_um": [0.0, 0.0], "misalignment_mrad": [0.0, 0.0],
            },
        });
        let [gear, _] = pair::from_json(&file.to_string()).ok()?.geometry.gears;
        Some(gear)
    }

    /// The tip form circle of a chamfer.
    pub(super) fn tip(&mut self, i: usize, basic: &Basic, fields: &mut Fields) -> Result<()> {
        let name = ["gear1", "gear2"][i];
        let chamfer = agreed(
            &format!("{name}: tooth_tip_chamfer"),
            &self.teeth[i],
            &["tooth_tip_chamfer"],
        )?;
        let Some(chamfer) = chamfer.filter(|c| c.value != 0.0) else {
            return Ok(());
        };
        if fields.contains_key("tip_form_diameter_mm") {
            return Ok(());
        }
        let side = if self.is_ring(i) { -1.0 } else { 1.0 };
        let usual = basic.reference_diameter(i)
            + 2.0 * basic.module * (1.0 + number(fields, "profile_shift_iso_21771").unwrap_or(0.0));
        let tip = number(fields, "tip_diameter_mm").unwrap_or(usual.abs());
        let form = rounded(tip - side * 2.0 * chamfer.value.abs());
        fields.insert("tip_form_diameter_mm".into(), json!(form));
        let line = format!(
            "{name}.tip_form_diameter_mm = {form} from {}: {} at the tip diameter {tip}",
            chamfer.origin, chamfer.value
        );
        self.account.add(Head::Derived, line);
        Ok(())
    }
}

fn number(fields: &Fields, field: &str) -> Option<f64> {
    fields.get(field).and_then(Value::as_f64)
}
