//! Poses of the two gears as a solver would hand them in.

use crate::document::Error;
use gearmesh::element::{Element, Inputs, Latch};
use gearmesh::random::Random;
use nalgebra::{Rotation3, Vector3};

/// How far poses spread.
#[derive(Debug, Clone, Copy)]
pub struct Spread {
    /// Centre distance offset up to this, m.
    pub center_distance: f64,
    /// Tilt of gear 2 about each axis across it up to this, rad.
    pub tilt: f64,
    /// Normal force between these, N.
    pub normal_force: [f64; 2],
}

/// `n` random poses of `spread` with gear 1 turned so that the mesh carries the force drawn for it.
pub fn random(
    element: &Element,
    latch: &Latch,
    teeth: [f64; 2],
    spread: &Spread,
    n: usize,
) -> Result<Vec<Inputs>, Error> {
    let mut random = Random::new(0x2545_F491_4F6C_DD1D);
    let mut both = |x: f64| random.within([-x, x]);
    let mut poses = vec![];
    for _ in 0..n {
        let mut inputs = element.nominal_inputs();
        inputs.gears[1].p += Vector3::new(both(spread.center_distance), both(1e-5), both(1e-5));
        let tilt = Rotation3::from_euler_angles(both(spread.tilt), both(spread.tilt), 0.0);
        let turn = both(3.0);
        let spin = |angle: f64| *Rotation3::from_axis_angle(&Vector3::z_axis(), angle).matrix();
        inputs.gears[1].r = tilt.matrix() * spin(-turn * teeth[0] / teeth[1]);
        let [low, high] = spread.normal_force;
        let force = 0.5 * (low + high) + 0.5 * both(high - low);
        let turned = |angle: f64| {
            let mut x = inputs;
            x.gears[0].r = spin(turn + angle);
            x
        };
        // Force rises with the angle; half a base pitch at most lies between contact and no contact.
        let (mut free, mut deep) = (-5e-3, 5e-3);
        for _ in 0..40 {
            let middle = 0.5 * (free + deep);
            if element.evaluate(latch, &turned(middle))?.normal_force < force {
                free = middle;
            } else {
                deep = middle;
            }
        }
        let mut x = turned(0.5 * (free + deep));
        for (i, speed) in [100.0, -100.0 * teeth[0] / teeth[1]]
            .into_iter()
            .enumerate()
        {
            x.gears[i].w = Vector3::z() * speed;
            x.gears[i].v = Vector3::new(both(1e-3), both(1e-3), both(1e-3));
        }
        poses.push(x);
    }
    Ok(poses)
}
