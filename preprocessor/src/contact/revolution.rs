//! Static transmission error over a turn of a gear whose body is no solid of revolution.

use std::f64::consts::TAU;

use crate::gear::Shaft;
use crate::static_contact::{ContactError, ContactSolver};

use super::mesh_cycle::{CycleInput, LoadCase, MeshCycle, peak_to_peak};

/// Mesh cycles over a turn of one gear; the other body is in its mean state.
#[derive(Debug, Clone, PartialEq)]
pub struct Revolution {
    /// The gear that makes the turn, 0 or 1.
    pub gear: usize,
    /// Positions of one mesh cycle.
    pub positions: usize,
    /// STE at all positions of the turn, m. It begins with tooth 0 at the pitch point.
    pub ste: Vec<f64>,
}

/// A part of the transmission error that comes again so many times a turn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Order {
    /// Times a turn.
    pub order: usize,
    /// m.
    pub amplitude: f64,
    /// The next harmonic of the mesh, 0 for the body's own orders.
    pub mesh_harmonic: usize,
    /// Order less that harmonic's.
    pub sideband: i64,
}

impl Revolution {
    /// Solves a mesh cycle for each tooth of `gear`; `progress` is told the share that is done.
    ///
    /// # Errors
    /// As [`MeshCycle::solve_all`].
    pub fn solve(
        solver: &ContactSolver,
        shafts: &[Option<Shaft>; 2],
        input: &CycleInput,
        load: LoadCase,
        gear: usize,
        progress: &dyn Fn(f64),
    ) -> Result<Revolution, ContactError> {
        let teeth = solver.geometry().gears[gear].teeth;
        let mut ste = Vec::with_capacity(teeth as usize * input.positions);
        for cycle in 0..teeth {
            let turned = solver.clone().after(input.flank, gear, cycle);
            let solved = MeshCycle::solve_all(&turned, shafts, input, &[load], &|_| ())?;
            ste.extend(solved.iter().flat_map(MeshCycle::ste));
            progress(f64::from(cycle + 1) / f64::from(teeth));
        }
        Ok(Revolution {
            gear,
            positions: input.positions,
            ste,
        })
    }

    /// Highest minus lowest STE, m.
    pub fn peak_to_peak(&self) -> f64 {
        peak_to_peak(&self.ste)
    }

    /// Highest minus lowest mean STE of a mesh cycle, m: what the body modulates.
    pub fn modulation(&self) -> f64 {
        let cycles = self.ste.chunks(self.positions);
        let means = cycles.map(|cycle| cycle.iter().sum::<f64>() / cycle.len() as f64);
        peak_to_peak(&means.collect::<Vec<_>>())
    }

    /// All orders that the positions tell apart, ascending from 1.
    pub fn orders(&self) -> Vec<Order> {
        let (n, teeth) = (self.ste.len(), self.ste.len() / self.positions);
        let orders = 1..n.div_ceil(2);
        let found = orders.map(|order| {
            let (mut cos, mut sin) = (0.0, 0.0);
            for (i, value) in self.ste.iter().enumerate() {
                let (s, c) = (TAU * (order * i % n) as f64 / n as f64).sin_cos();
                cos += value * c;
                sin += value * s;
            }
            let mesh_harmonic = (order + teeth / 2) / teeth;
            Order {
                order,
                amplitude: 2.0 / n as f64 * cos.hypot(sin),
                mesh_harmonic,
                sideband: order as i64 - (mesh_harmonic * teeth) as i64,
            }
        });
        found.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_modulated_mesh_shows_as_its_order_and_as_sidebands() {
        let (teeth, positions) = (12, 16);
        let ste = (0..teeth * positions).map(|i| {
            let turn = TAU * i as f64 / (teeth * positions) as f64;
            3.0 + 0.2 * (4.0 * turn).cos() + (1.0 + 0.1 * (4.0 * turn).cos()) * (12.0 * turn).sin()
        });
        let revolution = Revolution {
            gear: 0,
            positions,
            ste: ste.collect(),
        };
        let orders = revolution.orders();
        let strong: Vec<Order> = orders.into_iter().filter(|o| o.amplitude > 1e-9).collect();
        let found = strong
            .iter()
            .map(|o| (o.order, o.mesh_harmonic, o.sideband));
        let expected = [(4, 0, 4), (8, 1, -4), (12, 1, 0), (16, 1, 4)];
        assert!(found.eq(expected));
        for (order, amplitude) in strong.iter().zip([0.2, 0.05, 1.0, 0.05]) {
            assert!((order.amplitude - amplitude).abs() < 1e-12);
        }
        // Four periods in twelve cycles: each cycle is a third of one.
        assert!(revolution.modulation() > 0.1 && revolution.modulation() < 0.4);
    }
}
