//! How exact static contact is on so many stations along the face, on coarse elements at random poses in the ranges of the
//! pairs, at the approach that 160 stations find for the torque.

use crate::data::{Data, fixed, largest, rms};
use crate::setup::{Models, shipped_at, solver};
use crate::{Context, Result, row};
use gearmesh::contact::{ContactResult, ContactSettings};
use gearmesh::gear::Flank;
use gearmesh::pair::Refinement;
use gearmesh::random::Random;
use gearmesh_preprocessor::finite_element::Settings;

/// Stations, and the share of a strip's own contact in what changes along it; the first is what the others are held against.
const CASES: [(usize, f64); 5] = [(160, 0.45), (40, 1.0), (20, 0.45), (22, 0.45), (40, 0.45)];

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let poses = if context.quick { 10 } else { 400 };
    let mut rows = vec![];
    for name in super::PAIRS.into_iter().take(if context.quick { 1 } else { 4 }) {
        let pair = shipped_at(name, Refinement::Coarse)?;
        let models = Models::default().get(&pair, &Settings::for_pair(&pair))?;
        let mut solvers = vec![];
        for (stations, own_share) in CASES {
            let contact = ContactSettings { stations, own_share, ..ContactSettings::for_pair(&pair) };
            solvers.push(solver(&pair, &models, contact)?);
        }
        let operating = &pair.operating;
        let nominal = operating.nominal_torque / pair.geometry.gears[0].base_radius();
        let half_face = 0.5 * pair.geometry.face_overlap().1;
        // Of force, moment and stiffness, by case.
        let mut errors = vec![[(); 3].map(|()| vec![]); CASES.len()];
        let mut random = Random::new(1);
        for _ in 0..poses {
            let offset = random.within(operating.center_distance_offset);
            let misalignment = random.within(operating.misalignment);
            let torque = random.within([0.1, 1.0]) * operating.maximum_torque;
            let tau = random.within([0.0, 1.0]);
            let exact = solvers[0].position(Flank::Drive, tau, offset)?.solve_torque(torque, misalignment, None)?;
            for (solver, errors) in solvers.iter().zip(&mut errors).skip(1) {
                let at = solver.position(Flank::Drive, tau, offset)?;
                let found = at.solve_approach(exact.approach, misalignment, None)?;
                let by = |of: fn(&ContactResult) -> f64| of(&found) - of(&exact);
                errors[0].push(by(|r| r.loa_force) / nominal);
                errors[1].push(by(|r| r.moment) / (nominal * half_face));
                errors[2].push(by(|r| r.tangent.force_by_approach) / exact.tangent.force_by_approach);
            }
        }
        for ((stations, own_share), [force, moment, stiffness]) in CASES.iter().zip(errors).skip(1) {
            let worst = 100.0 * largest(force.iter().copied()).abs();
            let [force, moment, stiffness] = [force, moment, stiffness].map(|errors| 100.0 * rms(errors));
            let cells = [fixed(force, 3), fixed(worst, 2), fixed(moment, 3), fixed(stiffness, 2)];
            rows.push([row![name, stations, own_share], cells.to_vec()].concat());
        }
    }
    let head = ["pair", "segments", "own share", "force rms, %", "largest, %", "moment rms, %", "stiffness rms, %"];
    data.table("stations", &head, &rows)
}
