//! How exact static contact is on so many segments along the face, on coarse elements at random poses in the ranges of the
//! pairs, at the approach that 160 segments find for the torque.

use super::PAIRS;
use crate::data::{Data, largest, rms};
use crate::setup::{Setup, models, shipped_at, solver};
use crate::{Context, Result};
use gearmesh::gear::Flank;
use gearmesh::random::Random;
use gearmesh_preprocessor::finite_element::Settings;
use gearmesh_preprocessor::gear::Refinement;
use gearmesh_preprocessor::static_contact::contact_settings;

/// Segments, and the share of a segment's own contact in what changes along it; the first is the reference.
const CASES: [(usize, f64); 5] = [(160, 0.45), (40, 1.0), (20, 0.45), (22, 0.45), (40, 0.45)];

pub fn report(context: &Context, data: &Data) -> Result<()> {
    let (pairs, poses) = if context.quick { (1, 10) } else { (4, 400) };
    let mut rows = vec![];
    for name in &PAIRS[..pairs] {
        let pair = shipped_at(name, Refinement::Coarse)?;
        let models = models(&pair, &Settings::for_pair(&pair))?;
        let mut solvers = vec![];
        for (stations, own_share) in CASES {
            let mut contact = contact_settings(&pair);
            (contact.stations, contact.own_share) = (stations, own_share);
            solvers.push(solver(&pair, &models, contact)?);
        }
        let setup = Setup {
            pair,
            solver: solvers.remove(0),
        };
        let (nominal, half_face) = (setup.nominal_force(), setup.half_face());
        // Of force, moment and stiffness.
        let mut errors: Vec<[Vec<f64>; 3]> = vec![Default::default(); solvers.len()];
        let mut random = Random::new(1);
        for _ in 0..poses {
            let (torque, query) = setup.draw(&mut random);
            let exact = setup.solve(torque, &query)?;
            let [_, offset, misalignment, tau] = query.coordinates();
            let stiffness = exact.tangent.force_by_approach;
            for (solver, errors) in solvers.iter().zip(&mut errors) {
                let position = solver.position(Flank::Drive, tau, offset)?;
                let found = position.solve_approach(exact.approach, misalignment, None)?;
                let force = (found.loa_force - exact.loa_force) / nominal;
                let moment = (found.moment - exact.moment) / (nominal * half_face);
                let stiffness = found.tangent.force_by_approach / stiffness - 1.0;
                for (errors, error) in errors.iter_mut().zip([force, moment, stiffness]) {
                    errors.push(100.0 * error);
                }
            }
        }
        for ((segments, own_share), errors) in CASES[1..].iter().zip(errors) {
            let worst = largest(errors[0].iter().copied()).abs();
            let [force, moment, stiffness] = errors.map(rms);
            let errors = format!("{force:.3} | {worst:.2} | {moment:.3} | {stiffness:.2}");
            rows.push(format!("{name} | {segments} | {own_share} | {errors}"));
        }
    }
    let head = "pair | segments | own share | force rms, % | largest, % | moment rms, % | stiffness rms, %";
    data.table("stations", head, &rows)
}
