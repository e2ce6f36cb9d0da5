//! Grids from formulas, for tests and benchmarks: a spring whose potential is known exactly.

#![allow(dead_code)] // none needs all of it

use gearmesh::table::{Axes, FlankGrid, Potential, Query};
use std::f64::consts::TAU;

/// Axes with `counts` = (displacement, centre distance, misalignment, mesh position) nodes; 1 leaves an axis out.
pub fn axes([nu, nc, nm, np]: [usize; 4]) -> Axes {
    let span = |n: usize, half: f64| -> Vec<f64> {
        if n == 1 {
            return vec![0.0];
        }
        (0..n)
            .map(|i| half * (2.0 * i as f64 / (n - 1) as f64 - 1.0))
            .collect()
    };
    Axes {
        displacement_fraction: (1..=nu).map(|i| (i as f64 / nu as f64).powf(1.6)).collect(),
        center_distance_offset: span(nc, 100e-6),
        misalignment: span(nm, 3e-3),
        mesh_position: (0..np).map(|i| i as f64 / np as f64).collect(),
    }
}

/// W = K (delta - D0)^4 / (4 (1 µm)²) with smooth K(C, M, PMC) and D0(C, M, PMC) of the size of a gear pair's.
pub struct Spring;

const UNIT: f64 = 1e-6;

impl Spring {
    /// K and D0, each with its slopes by C, M and PMC.
    fn terms(q: &Query) -> [[f64; 4]; 2] {
        let (c, m) = (q.center_distance_offset, q.misalignment);
        let (sin, cos) = (TAU * q.mesh_position).sin_cos();
        let stiffness = [
            1.0 + 0.3 * cos + 800.0 * c + 4e3 * m * m,
            800.0,
            8e3 * m,
            -0.3 * TAU * sin,
        ];
        let onset = [
            0.5 * sin + 3e3 * c - 2e5 * m * m,
            3e3,
            -4e5 * m,
            0.5 * TAU * cos,
        ];
        [stiffness.map(|x| 1e6 * x), onset.map(|x| UNIT * x)]
    }

    /// Exact W and gradient.
    pub fn potential(q: &Query) -> Potential {
        let [[k, k_y @ ..], [d0, d0_y @ ..]] = Self::terms(q);
        let d = (q.delta - d0).max(0.0) / UNIT;
        let force = k * UNIT * d.powi(3);
        let by_stiffness = UNIT * UNIT * d.powi(4) / 4.0;
        let mut out = Potential {
            value: k * by_stiffness,
            ..Potential::default()
        };
        out.gradient[0] = force;
        for i in 0..3 {
            out.gradient[i + 1] = k_y[i] * by_stiffness - force * d0_y[i];
        }
        out.hessian[0][0] = 3.0 * k * d * d;
        out
    }

    /// Samples of it; the top load is reached 8 µm (and a little, varying) after the onset.
    pub fn grid(counts: [usize; 4]) -> FlankGrid {
        let axes = axes(counts);
        let [nc, nm, nu, np] = axes.lengths();
        let columns = (0..nc * nm * np).map(|n| {
            let (c, m) = (
                axes.center_distance_offset[n / np / nm],
                axes.misalignment[n / np % nm],
            );
            let p = axes.mesh_position[n % np];
            let low = Self::terms(&Query::from([0.0, c, m, p]))[1][0];
            (low, low + UNIT * (8.0 + (TAU * p).cos() + 5e2 * m))
        });
        let (no_load_approach, top_load_approach) = columns.unzip();
        let mut grid = FlankGrid {
            no_load_approach,
            top_load_approach,
            loa_force: vec![],
            moment: None,
            sliding: None,
            axes,
        };
        let node = |n: usize| grid.query([n / np / nu / nm, n / np / nu % nm, n / np % nu, n % np]);
        let loads = (0..nc * nm * nu * np).map(|n| Self::potential(&node(n)).gradient);
        let (forces, moments) = loads.map(|gradient| (gradient[0], gradient[2])).unzip();
        (grid.loa_force, grid.moment) = (forces, Some(moments));
        grid
    }
}
