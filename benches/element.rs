//! Cost of the whole element, pose to wrench: `cargo bench --bench element`.

use criterion::{Criterion, criterion_group, criterion_main};
use gearmesh::element::{
    Element, FlankLaws, Formulation, Inputs, InputsChange, Interpolation, LoadedFlank,
    MotionChange, Parameters,
};
use gearmesh::gear::{PairGeometry, samples};
use gearmesh::table::{FlankTable, samples::Spring};
use nalgebra::{Rotation3, Vector3};
use std::hint::black_box;
use std::sync::Arc;

/// The paper's pair with a little backlash.
fn pair() -> PairGeometry {
    samples::thinned(samples::paper_pair(1.0), 30e-6)
}

/// Poses along a mesh cycle, pressed and slightly misaligned, turning.
fn poses(element: &Element) -> Vec<Inputs> {
    (0..64)
        .map(|i| {
            let s = f64::from(i) / 64.0;
            let angle = std::f64::consts::TAU / 20.0 * s;
            let mut x = element.nominal_inputs();
            let tilt = Rotation3::from_euler_angles(2e-4 * s, -3e-4 * s, 0.0);
            x.gears[0].r = (tilt
                * Rotation3::from_axis_angle(&Vector3::z_axis(), angle + 6e-6 / 38.5e-3))
            .into_inner();
            x.gears[1].r = Rotation3::from_axis_angle(&Vector3::z_axis(), -angle).into_inner();
            x.gears[1].p += Vector3::new(4e-6 * s, 1e-6, 2e-6);
            x.gears[0].w = Vector3::z() * 300.0;
            x.gears[1].w = Vector3::z() * -300.0;
            x
        })
        .collect()
}

fn element(c: &mut Criterion) {
    let law = |interpolation| {
        let table = FlankTable::new(&Spring::grid([10, 9, 9, 32]), interpolation);
        FlankLaws {
            drive: Arc::new(table.expect("a sampled spring is a legal table")),
            coast: None,
        }
    };
    let (spline, linear) = (law(Interpolation::Spline), law(Interpolation::Linear));
    let with = |formulation, loaded_flank, laws: Option<&FlankLaws>| {
        let parameters = Parameters {
            formulation,
            loaded_flank,
            damping: 1e3,
            ..Parameters::default()
        };
        match laws {
            Some(laws) => Element::with_laws(&pair(), &parameters, laws),
            None => Element::new(&pair(), &parameters, None),
        }
        .expect("legal parameters")
    };
    use Formulation::{Conjugate, Paper};
    use LoadedFlank::{Both, Drive};
    let elements = [
        (
            "conjugate, constant, both flanks",
            with(Conjugate, Both, None),
        ),
        (
            "conjugate, 4-D spline, drive flank",
            with(Conjugate, Drive, Some(&spline)),
        ),
        (
            "conjugate, 4-D spline, both flanks",
            with(Conjugate, Both, Some(&spline)),
        ),
        (
            "conjugate, 4-D linear, both flanks",
            with(Conjugate, Both, Some(&linear)),
        ),
        ("paper, constant, drive flank", with(Paper, Drive, None)),
        (
            "paper, 4-D spline, drive flank",
            with(Paper, Drive, Some(&spline)),
        ),
    ];
    for (name, element) in &elements {
        let latch = element
            .latch(&element.nominal_inputs())
            .expect("a nominal pose");
        let poses = poses(element);
        let mut next = 0;
        let mut pose = move || {
            next = (next + 1) % poses.len();
            poses[next]
        };
        c.bench_function(&format!("value: {name}"), |b| {
            b.iter(|| element.evaluate(&latch, black_box(&pose())));
        });
        let direction = MotionChange {
            p: Vector3::new(1.0, 0.5, -0.2),
            rotation: Vector3::new(0.3, 0.2, 1.0),
            ..MotionChange::default()
        };
        let direction = InputsChange {
            gears: [direction; 2],
            ..InputsChange::default()
        };
        c.bench_function(&format!("directional derivative: {name}"), |b| {
            b.iter(|| element.directional_derivative(&latch, black_box(&pose()), &direction));
        });
        c.bench_function(&format!("jacobian: {name}"), |b| {
            b.iter(|| element.jacobian(&latch, black_box(&pose())));
        });
    }
}

criterion_group!(benches, element);
criterion_main!(benches);
