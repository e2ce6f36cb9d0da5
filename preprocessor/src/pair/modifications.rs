//! Microgeometry of the file, resolved to lengths of roll.

use std::path::Path;
use std::sync::Arc;

use super::error::{Refusal, ensure};
use super::file::{EndReliefFile, FlankFile, PairFile, ReliefFile, ReliefStart, Shape};
use super::mesh_checks::{field, short_tooth};
use super::resolve::{MM, UM, gear_file};
use super::{slips, topography};
use gearmesh::gear::{
    EndRelief, Flank, Gear, Microgeometry, PairGeometry, ProfileCrowning, ProfileRelief,
    ProfileSlope, ReliefShape,
};
use gearmesh::words::{number, rounded};

/// Removal over the length of roll or of the face within which it grows, at most.
pub(super) const STEEPEST: f64 = 0.1;

/// The flanks of gear `i` that `flank` loads.
pub(super) struct Flanks<'a> {
    pub file: &'a PairFile,
    pub geometry: &'a PairGeometry,
    /// Where files are sought.
    pub folder: &'a Path,
    pub i: usize,
    pub flank: Flank,
}

impl Flanks<'_> {
    /// Modifications, field by field: what the flank has of its own, else what the gear has for both.
    ///
    /// The active profile runs from where the mate's tip touches at the nominal centre distance to the end of this
    /// gear's involute at the tip.
    pub fn microgeometry(&self) -> Result<Microgeometry, Refusal> {
        let gear_file = gear_file(self.file, self.i);
        let (name, own) = match self.flank {
            Flank::Drive => ("drive_flank", &gear_file.drive_flank),
            Flank::Coast => ("coast_flank", &gear_file.coast_flank),
        };
        // What the flank has of its own, then what the gear has for both, each with its place in the file.
        let sources = [
            (format!("{name}."), own.clone().unwrap_or_default()),
            (String::new(), gear_file.modifications()),
        ];
        let tip = self.gear().tip_form_roll();
        let start = self
            .geometry
            .active_start_roll(self.i, self.geometry.center_distance);
        let rolls = [start, tip];
        let relief = |of: fn(&FlankFile) -> &Option<ReliefFile>, name: &str, end: f64| {
            let given = (sources.iter()).find_map(|(place, f)| Some((place, of(f).as_ref()?)));
            let Some((place, given)) = given else {
                return Ok(None);
            };
            let relief = self.profile_relief(given, &self.path(place, name), rolls, end)?;
            Ok((relief.amount > 0.0).then_some(relief))
        };
        let um = |of: fn(&FlankFile) -> Option<f64>| {
            sources.iter().find_map(|(_, f)| of(f)).unwrap_or(0.0) * UM
        };
        let end = |of: fn(&FlankFile) -> &Option<EndReliefFile>| {
            let mut all = sources.iter();
            let relief = all.find_map(|(_, f)| of(f).as_ref().or(f.end_relief.as_ref()));
            relief.map(end_relief).filter(|r| r.amount > 0.0)
        };
        let (crowning, slope, bias) = (
            um(|f| f.profile_crowning_um),
            um(|f| f.profile_slope_um),
            um(|f| f.bias_um),
        );
        let named =
            |(place, f): &(String, FlankFile)| Some((place.clone(), f.topography_file.clone()?));
        let topography = match sources.iter().find_map(named) {
            Some((place, name)) => {
                let (file, path) = (self.folder.join(name), self.path(&place, "topography_file"));
                let grid = topography::read(&file, &path, self.gear(), rolls)?;
                Some(Arc::new(grid))
            }
            None => None,
        };
        Ok(Microgeometry {
            tip_relief: relief(|f| &f.tip_relief, "tip_relief", tip)?,
            root_relief: relief(|f| &f.root_relief, "root_relief", start)?,
            profile_crowning: (crowning != 0.0).then_some(ProfileCrowning {
                amount: crowning,
                rolls,
            }),
            profile_slope: (slope != 0.0 || bias != 0.0).then_some(ProfileSlope {
                amount: slope,
                bias,
                rolls,
            }),
            lead_crowning: um(|f| f.lead_crowning_um),
            lead_slope: um(|f| f.lead_slope_um),
            end_relief: [end(|f| &f.lower_end_relief), end(|f| &f.upper_end_relief)],
            topography,
        })
    }

    fn gear(&self) -> &Gear {
        &self.geometry.gears[self.i]
    }

    /// Path of the field `name` at `place` of the gear.
    fn path(&self, place: &str, name: &str) -> String {
        field(self.i, &format!("{place}{name}"))
    }

    fn profile_relief(
        &self,
        r: &ReliefFile,
        path: &str,
        active: [f64; 2],
        end_roll: f64,
    ) -> Result<ProfileRelief, Refusal> {
        let gear = self.gear();
        let (start_roll, value) = match r.start {
            ReliefStart::PitchPoint => (
                self.geometry
                    .roll_at(self.i, self.geometry.center_distance, 0.0),
                "pitch_point".to_owned(),
            ),
            ReliefStart::DiameterMm(mm) => (
                gear.roll_length(0.5 * mm * MM),
                format!("{{\"diameter_mm\": {mm}}}"),
            ),
            ReliefStart::RollLengthMm(mm) => (mm * MM, format!("{{\"roll_length_mm\": {mm}}}")),
            ReliefStart::RollAngleDeg(deg) => (
                gear.base_radius() * deg.to_radians(),
                format!("{{\"roll_angle_deg\": {deg}}}"),
            ),
            ReliefStart::FromTipMm(mm) => (
                gear.tip_form_roll() - gear.kappa() * mm * MM,
                format!("{{\"from_tip_mm\": {mm}}}"),
            ),
        };
        let (low, high) = (active[0].min(active[1]), active[0].max(active[1]));
        let diameter = |roll: f64| 2.0 * gear.radius_at_roll(roll) / MM;
        let is_within = start_roll > low && start_roll < high;
        if let Some((tip, value, problem)) = short_tooth(self.file, self.geometry) {
            ensure!(is_within, tip => value;
                "{problem}, and the start of `{path}` is not on the active profile";
                "give the diameter of the tips, or another start of the relief");
        }
        let meant = match r.start {
            ReliefStart::DiameterMm(mm) => slips::diameter(mm, diameter(0.5 * (low + high))),
            _ => None,
        };
        let other = "give {\"diameter_mm\": ...} within it";
        let remedy = slips::remedy(meant, "give the diameter in millimetres", other);
        ensure!(is_within, format!("{path}.start") => value;
            "lies outside the active profile, diameters {:.3} to {:.3} mm, lengths of roll {:.3} to {:.3} mm",
            diameter(low), diameter(high), low / MM, high / MM;
            "{remedy}");
        let length = (end_roll - start_roll).abs();
        ensure!(r.amount_um * UM <= STEEPEST * length, format!("{path}.start") => value;
            "leaves {} mm of roll for {} um, steeper than one in ten: a chamfer, and no relief",
            number(rounded(length / MM)), r.amount_um;
            "give a start at least {} mm of roll before the end of the relief, or end the involute there by \
             `tip_form_diameter_mm`", rounded(r.amount_um * UM / STEEPEST / MM));
        Ok(ProfileRelief {
            amount: r.amount_um * UM,
            start_roll,
            end_roll,
            shape: shape(r.shape),
        })
    }
}

fn end_relief(r: &EndReliefFile) -> EndRelief {
    EndRelief {
        amount: r.amount_um * UM,
        length: r.length_mm * MM,
        shape: shape(r.shape),
    }
}

fn shape(shape: Shape) -> ReliefShape {
    match shape {
        Shape::Linear => ReliefShape::Linear,
        Shape::Parabolic => ReliefShape::Parabolic,
        Shape::Arc => ReliefShape::Arc,
    }
}
