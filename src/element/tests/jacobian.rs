//! Exact derivatives against finite differences.

use super::*;
use crate::table::{FlankTable, samples::Spring};
use nalgebra::SVector;

fn moved_along(x: &Inputs, d: &Direction, h: f64) -> Inputs {
    let nudged = |m: &Motion, first: usize| {
        let part = |k: usize| d.fixed_rows::<3>(first + k) * h;
        Motion {
            p: m.p + part(0),
            r: Rotation3::new(part(3)).matrix() * m.r,
            v: m.v + part(6),
            w: m.w + part(9),
        }
    };
    Inputs {
        gears: [0, 1].map(|i| nudged(&x.gears[i], i * BODY_COLUMNS)),
        carrier: nudged(&x.carrier, 2 * BODY_COLUMNS),
    }
}

/// Exact derivatives at `inputs` along a random direction, against finite
/// differences, all rows but `mesh.stiffness` to `bar` of their scale, that one to `stiffness_bar`.
fn compare(element: &Element, inputs: &Inputs, noise: &mut Noise, bar: f64, stiffness_bar: f64) {
    const STIFFNESS_ROW: usize = 22;
    let phase = nominal_phase(element);
    let scales = [1.0, 10.0, 100.0, 100.0];
    let direction = Direction::from_fn(|i, _| scales[i % BODY_COLUMNS / 3] * noise.next());
    let mut jacobian = Jacobian::zeros();
    element.jacobian(&phase, inputs, &mut jacobian).unwrap();
    let exact = jacobian * direction;
    // Truncation, of fourth order, stays below the bound at every pose of the sequence, and rounding far below.
    let h = 1e-8;
    let side = |h: f64| {
        let out = element.evaluate(&phase, &moved_along(inputs, &direction, h));
        SVector::from(out.unwrap().to_array())
    };
    let rough = (8.0 * (side(h) - side(-h)) - (side(2.0 * h) - side(-2.0 * h))) / (12.0 * h);
    let value = side(0.0);
    // Outputs of one kind share a scale: forces, moments, then each scalar its own. It is that of the terms
    // which add up to the derivative, or of the value where that is larger.
    let scale = |i: usize| {
        let terms = jacobian.row(i).transpose().component_mul(&direction);
        terms.abs().sum().max(value[i].abs())
    };
    for row in 0..CONTINUOUS_OUTPUTS {
        let first = row / 3 * 3;
        let group = if row < 15 {
            first..first + 3
        } else {
            row..row + 1
        };
        let scale = group.map(scale).fold(0.0, f64::max);
        let bar = if row == STIFFNESS_ROW {
            stiffness_bar
        } else {
            bar
        };
        let (found, known, law) = (exact[row], rough[row], element.parameters.formulation);
        assert!(
            (found - known).abs() <= bar * scale,
            "{law:?} {row}: {found} {known}"
        );
    }
}

#[test]
fn derivatives_with_friction_and_root_stress_agree_with_finite_differences() {
    let mut noise = Noise::new(8);
    for (formulation, pair) in formulations_and_pairs(1.0) {
        for law in LAWS {
            let parameters = Parameters {
                damping: 1e5,
                friction_transition_speed: 0.05,
                root_stress: true,
                ..rubbing(formulation, LoadedFlank::Drive)
            };
            let table = rubbing_table(&pair, law, false);
            let element = Element::new(&pair, &parameters, Some(table)).unwrap();
            for _ in 0..4 {
                let mut inputs = compressed(&element, 1.0, 8e-6 + 1e-6 * noise.next());
                set_velocities(&mut inputs, &mut noise, 1e-3, 10.0);
                // Where the faces are flush the paper's (19) has a kink.
                inputs.gears[1].p.z += 2e-4;
                compare(&element, &inputs, &mut noise, 2e-6, 2e-3);
            }
        }
    }
}

#[test]
fn derivatives_on_a_table_agree_with_finite_differences() {
    let grid = Spring::grid([10, 7, 9, 16]);
    let drive = Arc::new(FlankTable::new(&grid, Interpolation::Spline).unwrap());
    let mut noise = Noise::new(6);
    let mut tried = 0;
    for (formulation, pair) in formulations_and_pairs(-1.0) {
        for (flank, s, _) in SINGLE_FLANKS {
            let parameters = Parameters {
                damping: 1e5,
                ..undamped(formulation, flank)
            };
            let element = Element::with_laws(&pair, &parameters, drive.clone(), None).unwrap();
            for _ in 0..6 {
                // Inside the table: +-3 mrad, +-100 um, some 8 um above the first touch.
                let mut inputs = compressed(&element, s, 6e-6 + 1e-6 * noise.next());
                let tilt = noise.vector(1e-4);
                inputs.gears[1].r = Rotation3::new(tilt).matrix() * inputs.gears[1].r;
                inputs.gears[1].p += noise.vector(1e-6);
                set_velocities(&mut inputs, &mut noise, 1e-3, 1e-2);
                let out = at(&element, &inputs);
                if out.flank != 0 && !out.out_of_range {
                    tried += 1;
                    // mesh.stiffness: a second derivative of a C2 force, differentiated itself.
                    compare(&element, &inputs, &mut noise, 1e-6, 1e-3);
                }
            }
        }
    }
    assert!(
        tried >= 36,
        "only {tried} poses in contact inside the table"
    );
}
