//! What static contact says over a mesh cycle and in the tooth roots, and the elastic models of a pair condensed to what a solve at
//! run time needs.

mod body_orders;
mod mesh_cycle;
mod models;
mod revolution;
mod root_stress;

use std::sync::Arc;

use rayon::prelude::*;

use crate::finite_element::RootStress;
use crate::gear::Pair;
use crate::static_contact::{ContactError, ContactSolver};
use gearmesh::contact::{CondensedFlank, CondensedRoots, ContactFile, ContactSetup};
use gearmesh::gear::Flank;

pub use body_orders::body_orders;
pub use mesh_cycle::{
    CycleInput, ENOUGH_SEGMENTS, FaceLoad, HARMONICS, Harmonic, LoadCase, MeshCycle, harmonics,
};
pub use models::{ElasticModels, ModelError, ModelSettings, RootModels, StageProgress};
pub use revolution::{Order, Revolution};
pub use root_stress::{GearRoots, PositionRoots, ToothRoot};

/// The contact of `flank` with the elastic models of `solver`, at the centre distance offsets `offsets` (m).
///
/// # Errors
/// As [`ContactSolver::position`].
pub fn condensed_flank(
    solver: &ContactSolver,
    flank: Flank,
    offsets: &[f64],
) -> Result<CondensedFlank, ContactError> {
    let places = CondensedFlank::grid(offsets).into_par_iter();
    let nodes = places.map(|place| solver.node(flank, place));
    let nodes = nodes.collect::<Result<Vec<_>, _>>()?;
    let (stations, shares) = (solver.settings().stations, solver.tooth_shares(flank)?);
    Ok(CondensedFlank::from_nodes(
        stations, shares, offsets, &nodes,
    ))
}

/// What `models` of gear 1 and gear 2 give of the stress in the tooth roots at run time, by loads on the stations of `solver` on
/// `flank`.
///
/// # Errors
/// As [`ContactSolver::stations`].
pub fn condensed_roots(
    solver: &ContactSolver,
    flank: Flank,
    models: &[Arc<RootStress>; 2],
) -> Result<[CondensedRoots; 2], ContactError> {
    let stations = solver.stations(flank)?;
    Ok([0, 1].map(|i| {
        let seen: Vec<_> = stations.iter().map(|station| station[i]).collect();
        models[i].condensed(&seen)
    }))
}

/// The contact of `pair` with the elastic models of `solver`, its condensed models at the middle and the ends
/// of the range of centre distances.
///
/// # Errors
/// As [`condensed_flank`]; a pair whose tip edges are not followed.
pub fn contact_file(pair: &Pair, solver: &ContactSolver) -> Result<ContactFile, ContactError> {
    let settings = solver.settings();
    if !settings.tip_corner_contact {
        let remedy = "contact at run time follows tip edges: set it to true";
        return Err(ContactError::input("tip_corner_contact", 0.0, remedy));
    }
    let [low, high] = pair.operating.center_distance_offset;
    let offsets = if low < high {
        vec![low, 0.5 * (low + high), high]
    } else {
        vec![0.0]
    };
    Ok(ContactFile {
        setup: Arc::new(ContactSetup {
            teeth: pair.teeth.clone(),
            ..solver.setup().clone()
        }),
        drive: Arc::new(condensed_flank(solver, Flank::Drive, &offsets)?),
        coast: match pair.coast_mirrors_drive() && pair.teeth.are_alike() {
            true => None,
            false => Some(Arc::new(condensed_flank(solver, Flank::Coast, &offsets)?)),
        },
        error: None,
    })
}
