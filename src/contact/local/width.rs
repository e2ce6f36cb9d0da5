//! How wide the contacts of a pair become.

use super::constants::STIFFNESS_OVER_MODULUS;
use crate::pair::Pair;

/// Estimate of the largest Hertz half-width of the pair, m: the maximum torque on one tooth pair, spread
/// over the face evenly or, with misalignment, as a triangle on an elastic foundation.
pub fn widest_contact(pair: &Pair) -> f64 {
    let g = &pair.geometry;
    let c = g.center_distance;
    let path = g.path_of_contact(c);
    let radius = (0..=20)
        .map(|i| {
            let xi = path.start + path.length() * f64::from(i) / 20.0;
            let rho = [0, 1].map(|k| g.gears[k].kappa() * g.roll_at(k, c, xi));
            1.0 / (1.0 / rho[0] + 1.0 / rho[1])
        })
        .fold(0.0, f64::max)
        / g.base_helix_angle().cos();
    let force = pair.operating.maximum_torque / g.gears[0].base_radius();
    let modulus = g
        .gears
        .iter()
        .map(|g| g.youngs_modulus)
        .fold(f64::INFINITY, f64::min);
    let misalignment = pair
        .operating
        .misalignment
        .iter()
        .fold(0.0f64, |m, v| m.max(v.abs()));
    let triangle = (2.0 * force * STIFFNESS_OVER_MODULUS * modulus * misalignment).sqrt();
    let line_load = (force / g.face_overlap().1).max(triangle);
    let softness: f64 = g
        .gears
        .iter()
        .map(|g| (1.0 - g.poisson_ratio * g.poisson_ratio) / g.youngs_modulus)
        .sum();
    (4.0 * line_load * radius * softness / std::f64::consts::PI).sqrt()
}
