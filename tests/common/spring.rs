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
    fn stiffness(q: &Query) -> [f64; 4] {
        let [_, c, m, p] = q.coordinates();
        let (t, k) = (TAU * p, 1e6);
        [
            k * (1.0 + 0.3 * t.cos() + 800.0 * c + 4e3 * m * m),
            k * 800.0,
            k * 8e3 * m,
            -k * 0.3 * TAU * t.sin(),
        ]
    }

    fn onset(q: &Query) -> [f64; 4] {
        let [_, c, m, p] = q.coordinates();
        let t = TAU * p;
        [
            UNIT * (0.5 * t.sin() + 3e3 * c - 2e5 * m * m),
            UNIT * 3e3,
            -UNIT * 4e5 * m,
            UNIT * 0.5 * TAU * t.cos(),
        ]
    }

    /// Exact W and gradient.
    pub fn potential(q: &Query) -> Potential {
        let [k, k_y @ ..] = Self::stiffness(q);
        let [d0, d0_y @ ..] = Self::onset(q);
        let d = (q.delta - d0).max(0.0) / UNIT;
        let force = k * UNIT * d.powi(3);
        let mut out = Potential {
            value: k * UNIT * UNIT * d.powi(4) / 4.0,
            ..Potential::default()
        };
        out.gradient[0] = force;
        for i in 0..3 {
            out.gradient[i + 1] = k_y[i] * UNIT * UNIT * d.powi(4) / 4.0 - force * d0_y[i];
        }
        out.hessian[0][0] = 3.0 * k * d * d;
        out
    }

    /// Samples of it; the top load is reached 8 µm (and a little, varying) after the onset.
    pub fn grid(counts: [usize; 4]) -> FlankGrid {
        let axes = axes(counts);
        let [mut lows, mut highs, mut forces, mut moments] = [const { Vec::new() }; 4];
        for &c in &axes.center_distance_offset {
            for &m in &axes.misalignment {
                let ends = |p: f64| {
                    let low = Self::onset(&Query::from([0.0, c, m, p]))[0];
                    (low, low + UNIT * (8.0 + (TAU * p).cos() + 5e2 * m))
                };
                for &p in &axes.mesh_position {
                    lows.push(ends(p).0);
                    highs.push(ends(p).1);
                }
                for &u in &axes.displacement_fraction {
                    for &p in &axes.mesh_position {
                        let (low, high) = ends(p);
                        let w = Self::potential(&Query::from([low + u * (high - low), c, m, p]));
                        forces.push(w.gradient[0]);
                        moments.push(w.gradient[2]);
                    }
                }
            }
        }
        FlankGrid {
            axes,
            no_load_approach: lows,
            top_load_approach: highs,
            loa_force: forces,
            moment: Some(moments),
            sliding: None,
        }
    }
}
