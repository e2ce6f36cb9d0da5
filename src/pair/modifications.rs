//! Microgeometry of the file, resolved to lengths of roll.

use std::path::Path;
use std::sync::Arc;

use super::checks::require;
use super::error::Refusal;
use super::file::{EndReliefFile, FlankFile, GearFile, PairFile, ReliefFile, ReliefStart, Shape};
use super::mesh_checks::{field, short_tooth};
use super::resolve::{MM, UM, gear_file};
use super::{slips, topography};
use crate::gear::{
    EndRelief, Flank, Gear, Microgeometry, PairGeometry, ProfileCrowning, ProfileRelief,
    ProfileSlope, ReliefShape,
};

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
        let of_both = self.gear_file().both_flanks();
        let (_, own) = self.own();
        let tip = self.gear().tip_form_roll();
        let start = self
            .geometry
            .active_start_roll(self.i, self.geometry.center_distance);
        let rolls = [start, tip];
        let relief = |of: fn(&FlankFile) -> &Option<ReliefFile>, name: &str, end: f64| {
            let given = of(&own).as_ref().map(|r| (true, r));
            match given.or_else(|| of(&of_both).as_ref().map(|r| (false, r))) {
                Some((is_own, r)) => self
                    .profile_relief(r, &self.path(is_own, name), rolls, end)
                    .map(|relief| (relief.amount > 0.0).then_some(relief)),
                None => Ok(None),
            }
        };
        let um = |of: fn(&FlankFile) -> Option<f64>| of(&own).or(of(&of_both)).unwrap_or(0.0) * UM;
        let end = |of: fn(&FlankFile) -> &Option<EndReliefFile>| {
            let either = |flank: &FlankFile| of(flank).clone().or(flank.end_relief.clone());
            either(&own)
                .or_else(|| either(&of_both))
                .map(|r| end_relief(&r))
                .filter(|r| r.amount > 0.0)
        };
        let (crowning, slope, bias) = (
            um(|f| f.profile_crowning_um),
            um(|f| f.profile_slope_um),
            um(|f| f.bias_um),
        );
        let file = own.topography_file.as_ref().map(|name| (true, name));
        let topography = match file.or(of_both.topography_file.as_ref().map(|name| (false, name))) {
            Some((is_own, name)) => Some(Arc::new(topography::read(
                &self.folder.join(name),
                &self.path(is_own, "topography_file"),
                self.gear(),
                rolls,
            )?)),
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

    fn gear_file(&self) -> &GearFile {
        gear_file(self.file, self.i)
    }

    fn gear(&self) -> &Gear {
        &self.geometry.gears[self.i]
    }

    /// What the flank has of its own, with its name in the file.
    fn own(&self) -> (&'static str, FlankFile) {
        let gear = self.gear_file();
        let (name, flank) = match self.flank {
            Flank::Drive => ("drive_flank", &gear.drive_flank),
            Flank::Coast => ("coast_flank", &gear.coast_flank),
        };
        (name, flank.clone().unwrap_or_default())
    }

    /// Path of the field `name`, of the flank alone or of the gear.
    fn path(&self, is_own: bool, name: &str) -> String {
        match is_own {
            true => field(self.i, &format!("{}.{name}", self.own().0)),
            false => field(self.i, name),
        }
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
        };
        let (low, high) = (active[0].min(active[1]), active[0].max(active[1]));
        let diameter = |roll: f64| 2.0 * gear.radius_at_roll(roll) / MM;
        let is_within = start_roll > low && start_roll < high;
        if !is_within && let Some((tip, value, problem)) = short_tooth(self.file, self.geometry) {
            return Err(Refusal::new(
                tip,
                value,
                format!("{problem}, and the start of `{path}` is not on the active profile"),
                "give the diameter of the tips, or another start of the relief",
            ));
        }
        let other = match r.start {
            ReliefStart::DiameterMm(mm) => slips::diameter(mm, diameter(0.5 * (low + high))),
            ReliefStart::PitchPoint => None,
        };
        require(
            is_within,
            format!("{path}.start"),
            value,
            format!(
                "lies outside the active profile, diameters {:.3} to {:.3} mm",
                diameter(low),
                diameter(high)
            ),
            match other {
                Some(other) => format!("give the diameter in millimetres: {other}"),
                None => "give {\"diameter_mm\": ...} within it".into(),
            },
        )?;
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
