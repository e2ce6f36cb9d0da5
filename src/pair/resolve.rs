//! From the file's units and defaults to a [`Pair`] in SI.

use super::error::Refusal;
use super::file::{EndReliefFile, GearFile, Meshing, PairFile, ReliefFile, ReliefStart, Shape};
use super::{ComplianceChoice, Operating, Pair};
use crate::gear::{
    EndRelief, Gear, GearKind, Microgeometry, PairGeometry, ProfileCrowning, ProfileRelief,
    ReliefShape, inverse_involute,
};

const MM: f64 = 1e-3;
const UM: f64 = 1e-6;

/// A centre distance on a drawing is rounded to a micrometre: one that is short of the backlash-free
/// one by less is taken as that without backlash.
const ROUNDING_OF_CENTER_DISTANCE: f64 = 1e-6;

/// Fills in defaults, checks, converts.
pub(super) fn resolve(file: &PairFile) -> Result<Pair, Refusal> {
    let ring = ring_index(file);
    let mut geometry = PairGeometry {
        gears: [
            gear(file, 0, ring == Some(0)),
            gear(file, 1, ring == Some(1)),
        ],
        center_distance: 0.0,
    };
    geometry.center_distance = match file.center_distance_mm {
        Some(mm) => mm * MM,
        None => backlash_free_center_distance(&geometry),
    };
    set_backlash(file, &mut geometry)?;
    let microgeometry = [0, 1].map(|i| microgeometry(file, &geometry, i));
    Ok(Pair {
        name: file.name.clone(),
        operating: Operating {
            nominal_torque: file.operating.nominal_torque_nm,
            maximum_torque: file.operating.maximum_torque_nm,
            center_distance_offset: file.operating.center_distance_offset_um.map(|v| v * UM),
            misalignment: file.operating.misalignment_mrad.map(|v| v * 1e-3),
        },
        compliance: ComplianceChoice {
            method: file.compliance.method,
            refinement: file.compliance.refinement,
        },
        tip_corner_contact: file.tip_corner_contact,
        warnings: Vec::new(),
        geometry,
        microgeometry,
    })
}

/// Which gear is the ring: gear 2 of an internal pair, or gear 1 when it alone has a rim.
fn ring_index(file: &PairFile) -> Option<usize> {
    match file.meshing {
        Meshing::External => None,
        Meshing::Internal => {
            let rim = |g: &GearFile| g.rim_diameter_mm.is_some();
            Some(usize::from(rim(&file.gear2) || !rim(&file.gear1)))
        }
    }
}

fn gear(file: &PairFile, i: usize, is_ring: bool) -> Gear {
    let g = [&file.gear1, &file.gear2][i];
    let e = match file.meshing {
        Meshing::External => 1.0,
        Meshing::Internal => -1.0,
    };
    let hand1 = if file.helix_angle_deg < 0.0 {
        -1.0
    } else {
        1.0
    };
    let mut gear = Gear {
        kind: if is_ring {
            GearKind::Ring
        } else {
            GearKind::External
        },
        teeth: g.teeth,
        hand: if i == 0 { hand1 } else { -e * hand1 },
        normal_module: file.normal_module_mm * MM,
        normal_pressure_angle: file.normal_pressure_angle_deg.to_radians(),
        helix_angle: file.helix_angle_deg.abs().to_radians(),
        profile_shift: g.profile_shift,
        face_width: g.face_width_mm * MM,
        face_offset: if i == 0 {
            0.0
        } else {
            file.face_offset_mm * MM
        },
        tip_radius: 0.0,
        dedendum_coefficient: g.dedendum_coefficient,
        tool_tip_radius_coefficient: g.tool_tip_radius_coefficient,
        held_radius: 0.0,
        tooth_thinning: 0.0,
        youngs_modulus: g.youngs_modulus_gpa * 1e9,
        poisson_ratio: g.poisson_ratio,
    };
    gear.tip_radius = match g.tip_diameter_mm {
        Some(mm) => 0.5 * mm * MM,
        None => {
            let addendum = g.addendum_coefficient.unwrap_or(1.0);
            gear.reference_radius()
                + gear.normal_module * (g.profile_shift + gear.kappa() * addendum)
        }
    };
    gear.held_radius = match gear.kind {
        GearKind::External => match g.bore_diameter_mm {
            Some(mm) => 0.5 * mm * MM,
            None => 0.5 * gear.root_radius(),
        },
        GearKind::Ring => match g.rim_diameter_mm {
            Some(mm) => 0.5 * mm * MM,
            None => gear.root_radius() + 3.5 * gear.normal_module,
        },
    };
    gear
}

/// Centre distance at which teeth without thinning mesh without backlash, m. NaN when the shifts allow
/// none.
fn backlash_free_center_distance(geometry: &PairGeometry) -> f64 {
    geometry.base_radius_sum() / inverse_involute(geometry.backlash_free_involute()).cos()
}

/// Thins both gears alike so that the file's backlash results.
fn set_backlash(file: &PairFile, geometry: &mut PairGeometry) -> Result<(), Refusal> {
    let c = geometry.center_distance;
    let cos_phi = geometry.operating_pressure_angle(c).cos();
    // Of full teeth, on the line of action.
    let natural = geometry.backlash(c);
    let thinning = match file.backlash_um {
        Some(um) => um * UM * cos_phi - natural,
        None => {
            let shortfall = geometry.e() * (backlash_free_center_distance(geometry) - c);
            if natural < 0.0 && shortfall < ROUNDING_OF_CENTER_DISTANCE {
                -natural
            } else if natural < 0.0 {
                return Err(Refusal::new(
                    "center_distance_mm",
                    c / MM,
                    format!(
                        "the teeth jam by {:.1} um at the operating pitch circle",
                        -natural / cos_phi / UM
                    ),
                    format!(
                        "give {:.4} or {}, or thin the teeth by `backlash_um`",
                        backlash_free_center_distance(geometry) / MM,
                        if geometry.e() > 0.0 { "more" } else { "less" }
                    ),
                ));
            } else {
                0.0
            }
        }
    };
    // A billionth of a metre: rounding of the file, no thicker teeth.
    if thinning < -1e-9 {
        return Err(Refusal::new(
            "backlash_um",
            file.backlash_um.unwrap_or(0.0),
            format!(
                "centre distance and profile shifts alone give {:.1} um",
                natural / cos_phi / UM
            ),
            "give at least that, or change `center_distance_mm` or `profile_shift`",
        ));
    }
    for gear in &mut geometry.gears {
        gear.tooth_thinning = 0.5 * thinning.max(0.0);
    }
    Ok(())
}

fn microgeometry(file: &PairFile, geometry: &PairGeometry, i: usize) -> Microgeometry {
    let g = [&file.gear1, &file.gear2][i];
    let gear = &geometry.gears[i];
    let tip_roll = gear.roll_length(gear.tip_radius);
    let path = geometry.path_of_contact(geometry.center_distance);
    // Where the mate's tip touches: gear 1 at the start of the path, gear 2 at its end.
    let active_start = geometry.roll_at(
        i,
        geometry.center_distance,
        if i == 0 { path.start } else { path.end },
    );
    let relief = |r: &ReliefFile, end_roll: f64| ProfileRelief {
        amount: r.amount_um * UM,
        start_roll: match r.start {
            ReliefStart::PitchPoint => geometry.roll_at(i, geometry.center_distance, 0.0),
            ReliefStart::DiameterMm(d) => gear.roll_length(0.5 * d * MM),
        },
        end_roll,
        shape: shape(r.shape),
    };
    Microgeometry {
        tip_relief: g.tip_relief.as_ref().map(|r| relief(r, tip_roll)),
        root_relief: g.root_relief.as_ref().map(|r| relief(r, active_start)),
        profile_crowning: (g.profile_crowning_um != 0.0).then_some(ProfileCrowning {
            amount: g.profile_crowning_um * UM,
            rolls: [active_start, tip_roll],
        }),
        lead_crowning: g.lead_crowning_um * UM,
        lead_slope: g.lead_slope_um * UM,
        end_relief: g.end_relief.as_ref().map(end_relief),
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
    }
}
