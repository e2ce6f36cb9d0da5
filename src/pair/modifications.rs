//! Microgeometry of the file, resolved to lengths of roll.

use super::checks::require;
use super::error::Refusal;
use super::file::{EndReliefFile, PairFile, ReliefFile, ReliefStart, Shape};
use super::mesh_checks::{field, short_tooth};
use super::resolve::{MM, UM, gear_file};
use super::slips;
use crate::gear::{
    EndRelief, Microgeometry, PairGeometry, ProfileCrowning, ProfileRelief, ReliefShape,
};

/// Modifications of gear `i`. The active profile runs from where the mate's tip touches at the nominal
/// centre distance to this gear's tip.
pub(super) fn microgeometry(
    file: &PairFile,
    geometry: &PairGeometry,
    i: usize,
) -> Result<Microgeometry, Refusal> {
    let g = gear_file(file, i);
    let gear = &geometry.gears[i];
    let tip = gear.roll_length(gear.tip_radius);
    let active_start = geometry.active_start_roll(i, geometry.center_distance);
    let relief = |name: &str, r: &Option<ReliefFile>, end_roll: f64| match r {
        Some(r) => {
            profile_relief(r, file, geometry, i, name, [active_start, tip], end_roll).map(Some)
        }
        None => Ok(None),
    };
    Ok(Microgeometry {
        tip_relief: relief("tip_relief", &g.tip_relief, tip)?,
        root_relief: relief("root_relief", &g.root_relief, active_start)?,
        profile_crowning: (g.profile_crowning_um != 0.0).then_some(ProfileCrowning {
            amount: g.profile_crowning_um * UM,
            rolls: [active_start, tip],
        }),
        lead_crowning: g.lead_crowning_um * UM,
        lead_slope: g.lead_slope_um * UM,
        end_relief: g.end_relief.as_ref().map(end_relief),
    })
}

fn profile_relief(
    r: &ReliefFile,
    file: &PairFile,
    geometry: &PairGeometry,
    i: usize,
    name: &str,
    active: [f64; 2],
    end_roll: f64,
) -> Result<ProfileRelief, Refusal> {
    let gear = &geometry.gears[i];
    let (start_roll, value) = match r.start {
        ReliefStart::PitchPoint => (
            geometry.roll_at(i, geometry.center_distance, 0.0),
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
    if !is_within && let Some((tip, value, problem)) = short_tooth(file, geometry) {
        return Err(Refusal::new(
            tip,
            value,
            format!(
                "{problem}, and the start of `gear{}.{name}` is not on the active profile",
                i + 1
            ),
            "give the diameter of the tips, or another start of the relief",
        ));
    }
    let remedy = match r.start {
        ReliefStart::DiameterMm(mm) => slips::diameter(mm, diameter(0.5 * (low + high))),
        ReliefStart::PitchPoint => None,
    };
    require(
        is_within,
        field(i, &format!("{name}.start")),
        value,
        format!(
            "lies outside the active profile, diameters {:.3} to {:.3} mm",
            diameter(low),
            diameter(high)
        ),
        match remedy {
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
    }
}
