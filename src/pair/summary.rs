//! What a drawing would tabulate of a pair, for `gearmesh inspect`.

use std::fmt;

use super::Pair;
use crate::gear::{GearKind, ToothProfile};

/// Derived quantities of a pair at its nominal centre distance, for people: lengths in mm and um, angles
/// in degrees. Printed as a table by `Display`.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Name of the pair.
    pub name: String,
    /// Whether one of the gears is a ring.
    pub internal: bool,
    /// Nominal centre distance.
    pub center_distance_mm: f64,
    /// Operating transverse pressure angle.
    pub operating_pressure_angle_deg: f64,
    /// Base helix angle.
    pub base_helix_angle_deg: f64,
    /// Transverse contact ratio, tip to tip.
    pub transverse_contact_ratio: f64,
    /// Overlap ratio of the common face.
    pub overlap_ratio: f64,
    /// Transverse base pitch.
    pub base_pitch_mm: f64,
    /// Common part of both faces.
    pub common_face_width_mm: f64,
    /// Circumferential backlash at the operating pitch circle.
    pub backlash_um: f64,
    /// Normal tooth force at the nominal torque, no friction.
    pub nominal_normal_force_n: f64,
    /// Gear 1 and gear 2.
    pub gears: [GearSummary; 2],
    /// Warnings of the pair.
    pub warnings: Vec<String>,
}

/// Derived quantities of one gear of a [`Summary`].
#[derive(Debug, Clone, PartialEq)]
pub struct GearSummary {
    /// "external" or "ring".
    pub kind: &'static str,
    /// Number of teeth.
    pub teeth: u32,
    /// Profile shift coefficient.
    pub profile_shift: f64,
    /// "spur", "right" or "left".
    pub hand: &'static str,
    /// Reference diameter.
    pub reference_diameter_mm: f64,
    /// Base diameter.
    pub base_diameter_mm: f64,
    /// Operating pitch diameter.
    pub operating_pitch_diameter_mm: f64,
    /// Tip diameter.
    pub tip_diameter_mm: f64,
    /// Diameter where the mate's tip touches.
    pub active_start_diameter_mm: f64,
    /// Diameter where the involute starts.
    pub form_diameter_mm: f64,
    /// Root diameter.
    pub root_diameter_mm: f64,
    /// Bore, or outer diameter of a ring: held rigidly.
    pub held_diameter_mm: f64,
    /// Tooth thickness at the tip, along the arc.
    pub tip_land_mm: f64,
    /// Whether the rack has cut away the start of the involute.
    pub undercut: bool,
    /// Face width.
    pub face_width_mm: f64,
}

impl Pair {
    /// Derived quantities, for people.
    pub fn summary(&self) -> Summary {
        let g = &self.geometry;
        let c = g.center_distance;
        let phi = g.operating_pressure_angle(c);
        Summary {
            name: self.name.clone(),
            internal: g.ring().is_some(),
            center_distance_mm: c * 1e3,
            operating_pressure_angle_deg: phi.to_degrees(),
            base_helix_angle_deg: g.base_helix_angle().to_degrees(),
            transverse_contact_ratio: g.transverse_contact_ratio(c),
            overlap_ratio: g.overlap_ratio(),
            base_pitch_mm: g.base_pitch() * 1e3,
            common_face_width_mm: g.face_overlap().1 * 1e3,
            backlash_um: g.backlash(c) / phi.cos() * 1e6,
            nominal_normal_force_n: self.operating.nominal_torque
                / g.gears[0].base_radius()
                / g.base_helix_angle().cos(),
            gears: [self.gear_summary(0), self.gear_summary(1)],
            warnings: self.warnings.clone(),
        }
    }

    fn gear_summary(&self, i: usize) -> GearSummary {
        let gear = &self.geometry.gears[i];
        let c = self.geometry.center_distance;
        let diameter_mm = |radius: f64| 2e3 * radius;
        let active = gear.radius_at_roll(self.geometry.active_start_roll(i, c));
        // A `Pair` has passed the checks that build this profile; its fields are public, so a caller can
        // spoil them, and then there is nothing to print.
        let profile = ToothProfile::new(gear).ok();
        let of_profile =
            |f: fn(&ToothProfile) -> f64| profile.as_ref().map_or(f64::NAN, |p| f(p) * 1e3);
        GearSummary {
            kind: match gear.kind {
                GearKind::External => "external",
                GearKind::Ring => "ring",
            },
            teeth: gear.teeth,
            profile_shift: gear.profile_shift,
            hand: match (gear.helix_angle == 0.0, gear.hand > 0.0) {
                (true, _) => "spur",
                (false, true) => "right",
                (false, false) => "left",
            },
            reference_diameter_mm: diameter_mm(gear.reference_radius()),
            base_diameter_mm: diameter_mm(gear.base_radius()),
            operating_pitch_diameter_mm: diameter_mm(self.geometry.operating_pitch_radius(i, c)),
            tip_diameter_mm: diameter_mm(gear.tip_radius),
            active_start_diameter_mm: diameter_mm(active),
            form_diameter_mm: 2.0 * of_profile(ToothProfile::form_radius),
            root_diameter_mm: diameter_mm(gear.root_radius()),
            held_diameter_mm: diameter_mm(gear.held_radius),
            tip_land_mm: of_profile(ToothProfile::tip_land),
            undercut: profile.as_ref().is_some_and(ToothProfile::is_undercut),
            face_width_mm: gear.face_width * 1e3,
        }
    }
}

/// What a line of the table shows of each gear.
type Column<T> = fn(&GearSummary) -> T;

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let meshing = if self.internal {
            "internal"
        } else {
            "external"
        };
        writeln!(f, "{}: {meshing} gear pair", self.name)?;
        let total = self.transverse_contact_ratio + self.overlap_ratio;
        let pair: [(&str, f64, usize); 10] = [
            ("centre distance, mm", self.center_distance_mm, 4),
            (
                "operating pressure angle, transverse, deg",
                self.operating_pressure_angle_deg,
                4,
            ),
            ("base helix angle, deg", self.base_helix_angle_deg, 4),
            ("transverse contact ratio", self.transverse_contact_ratio, 4),
            ("overlap ratio", self.overlap_ratio, 4),
            ("total contact ratio", total, 4),
            ("base pitch, transverse, mm", self.base_pitch_mm, 4),
            ("common face width, mm", self.common_face_width_mm, 3),
            (
                "backlash at the operating pitch circle, um",
                self.backlash_um,
                1,
            ),
            (
                "normal force at nominal torque, N",
                self.nominal_normal_force_n,
                1,
            ),
        ];
        for (label, value, digits) in pair {
            writeln!(f, "  {label:<44}{value:>12.digits$}")?;
        }
        writeln!(f, "  {:<44}{:>12}{:>12}", "", "gear 1", "gear 2")?;
        let texts: [(&str, Column<String>); 4] = [
            ("kind", |g| g.kind.into()),
            ("hand", |g| g.hand.into()),
            ("teeth", |g| g.teeth.to_string()),
            ("undercut", |g| if g.undercut { "yes" } else { "no" }.into()),
        ];
        for (label, text) in texts {
            let [a, b] = &self.gears;
            writeln!(f, "  {label:<44}{:>12}{:>12}", text(a), text(b))?;
        }
        let numbers: [(&str, Column<f64>); 11] = [
            ("profile shift coefficient", |g| g.profile_shift),
            ("face width, mm", |g| g.face_width_mm),
            ("tip diameter, mm", |g| g.tip_diameter_mm),
            ("operating pitch diameter, mm", |g| {
                g.operating_pitch_diameter_mm
            }),
            ("reference diameter, mm", |g| g.reference_diameter_mm),
            ("active profile starts at diameter, mm", |g| {
                g.active_start_diameter_mm
            }),
            ("involute starts at diameter, mm", |g| g.form_diameter_mm),
            ("base diameter, mm", |g| g.base_diameter_mm),
            ("root diameter, mm", |g| g.root_diameter_mm),
            ("held at diameter (bore or rim), mm", |g| g.held_diameter_mm),
            ("tooth thickness at the tip, mm", |g| g.tip_land_mm),
        ];
        for (label, number) in numbers {
            let [a, b] = &self.gears;
            writeln!(f, "  {label:<44}{:>12.4}{:>12.4}", number(a), number(b))?;
        }
        for warning in &self.warnings {
            writeln!(f, "  warning: {warning}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn the_summary_of_the_papers_pair_is_its_table_1() {
        let text = include_str!("../../resources/pairs/palermo2013.json");
        let summary = Pair::from_json(text).unwrap().summary();
        // Nominal normal force from the geometry at 100 N m.
        assert_abs_diff_eq!(summary.nominal_normal_force_n, 2660.4, epsilon = 0.1);
        assert_abs_diff_eq!(summary.transverse_contact_ratio, 1.540, epsilon = 1e-3);
        assert_abs_diff_eq!(
            summary.gears[1].operating_pitch_diameter_mm,
            82.104,
            epsilon = 1e-9
        );
        let printed = summary.to_string();
        for part in [
            "centre distance, mm",
            "82.1040",
            "right",
            "left",
            "involute starts",
        ] {
            assert!(printed.contains(part), "{printed}");
        }
        assert!(!printed.contains("NaN"));
    }
}
