//! Bodies that are no solids of revolution.

use super::super::model::Model;
use super::super::tests::segment;
use super::super::{FiniteElementCompliance, Settings};
use super::*;
use crate::compliance::ToothCompliance;
use crate::samples;
use gearmesh::contact::Segment;
use gearmesh::gear::GearKind;

fn wheel(body: Option<Body>) -> Gear {
    let mut gear = samples::gear(GearKind::External, 36, 1.0, 15.0, 0.0);
    gear.held_radius = 20e-3;
    gear.body = body;
    gear
}

fn webbed() -> Gear {
    wheel(Some(Body {
        rim_radius: 58e-3,
        web: [6e-3, 14e-3],
        hub_radius: 28e-3,
        hub: [0.0, 25e-3],
        held_ends: [false; 2],
    }))
}

fn holes(gear: &Gear, radius: f64, angle: f64) -> UnevenBody {
    UnevenBody {
        radius: gear.body.map_or(58e-3, |body| body.rim_radius),
        z: gear.body.map_or([0.0, gear.face_width], |body| body.web),
        shape: BodyShape::Holes(HoleCircle {
            count: 6,
            circle_radius: 43e-3,
            radius,
            angle,
        }),
    }
}

fn model(gear: &Gear) -> FiniteElementCompliance {
    let settings = Settings::new(Refinement::Coarse, 3);
    FiniteElementCompliance::new(gear, &settings, None, &|_, _| true)
        .unwrap()
        .0
}

/// Loads at three places of neighbouring teeth.
fn segments(gear: &Gear) -> Vec<Segment> {
    let part = |tooth, a: f64, radius| segment(gear, tooth, [a, a + 0.2 * gear.face_width], radius);
    let [low, middle] = [
        gear.reference_radius() - 1e-3,
        gear.reference_radius() + 1e-3,
    ];
    vec![
        part(0, 0.0, low),
        part(0, 12e-3, middle),
        part(1, 20e-3, low),
        part(3, 10e-3, middle),
    ]
}

#[test]
fn a_constant_body_below_the_cut_gives_the_model_without_a_cut() {
    let mut settings = Settings::new(Refinement::Coarse, 3);
    // As fine as the mesh of the body.
    let sizes = &mut settings.discretization;
    (sizes.root_element, sizes.growth, sizes.layer) = (0.4, 1.2, 0.5);
    let model = |gear: &Gear| {
        let model = FiniteElementCompliance::new(gear, &settings, None, &|_, _| true);
        model.unwrap().0
    };
    for gear in [webbed(), wheel(None)] {
        let body = holes(&gear, 8e-3, 0.0);
        let basis = basis(&gear, &body);
        let BodyShape::Holes(circle) = body.shape else {
            unreachable!()
        };
        let foundation = basis.foundation(&gear);
        let pattern = Pattern::of_circle(&circle, false);
        let mut mesh = pattern.mesh(&gear, &basis).unwrap();
        mesh.hole = None;
        let stiffness = basis.stiffness(&mesh, 6, foundation).unwrap();
        let cut_gear = cut_from(&gear, &body);
        let mesh = Model::new(&cut_gear, &settings).unwrap().mesh();
        let cut = Cut::new(&basis, &mesh, gear.teeth, &|_| true).unwrap();
        let cut = Arc::new(cut);
        let change = BodyChange::new(&gear, basis, &stiffness, cut, false).unwrap();
        let on_foundation = model(&cut_gear);
        let segments = segments(&gear);
        let weights: Vec<Weights> = segments
            .iter()
            .map(|s| on_foundation.grid.weights(s))
            .collect();
        let loads = segments.iter().map(|s| s.tooth).zip(&weights);
        let loads = change.coordinates(loads);
        let change = change.work(&loads, &loads);
        assert!(change.amax() > 5e-10);
        let found = on_foundation.bulk(&segments).unwrap() + change;
        let expected = model(&gear).bulk(&segments).unwrap();
        let own = expected.diagonal().map(f64::sqrt);
        let error = (&found - &expected).component_div(&(&own * own.transpose()));
        // The meshes of the body are not the same.
        assert!(error.amax() < 1e-3, "{error:.5}");
    }
}

#[test]
fn pins_of_a_quarter_of_the_size_take_less_than_twice_the_elements() {
    let mut ring = samples::gear(GearKind::Ring, 72, 1.0, 0.0, 0.0);
    let radius = ring.root_radius() + 5e-3;
    ring.held_radius = radius + 18e-3;
    let elements = [4e-3, 1e-3].map(|pin| {
        let circle = HoleCircle {
            count: 4,
            circle_radius: radius + 9e-3,
            radius: pin,
            angle: 0.0,
        };
        let basis = Basis::new(&ring, radius, [0.0, ring.face_width]);
        let mesh = Pattern::of_circle(&circle, true).mesh(&ring, &basis);
        mesh.unwrap().elements.len()
    });
    assert!(elements[1] < 2 * elements[0], "{elements:?}");
}

#[test]
fn influences_come_again_with_the_holes_and_are_symmetric_and_mirrored() {
    let gear = webbed();
    let on_foundation = model(&cut_from(&gear, &holes(&gear, 9e-3, 0.0)));
    let settings = Settings::new(Refinement::Coarse, 3);
    let pierced = |hand: f64, degrees: f64| {
        let gear = Gear {
            hand,
            ..gear.clone()
        };
        let body = holes(&gear, 9e-3, degrees.to_radians());
        on_foundation
            .on_body(&gear, &body, &settings, None, &|_, _| true)
            .unwrap()
    };
    let segments = segments(&gear);
    let at = |model: &FiniteElementCompliance, tooth| {
        model.at_tooth(tooth).unwrap().bulk(&segments).unwrap()
    };
    let model = pierced(1.0, 0.0);
    let first = at(&model, 0);
    let differs = |other: &DMatrix<f64>| (other - &first).amax() / first.amax();
    assert!(differs(&at(&model, 36)) < 1e-10);
    assert!(differs(&at(&model, -6)) < 1e-10);
    assert!(differs(&first.transpose()) < 1e-10);
    assert!(differs(&at(&model, 3)) > 5e-3);
    let sum = (0..6)
        .map(|tooth| at(&model, tooth))
        .fold(0.0 * &first, |a, b| a + b);
    let mean = (sum / 6.0 - model.bulk(&segments).unwrap()).amax();
    // Harmonics 18 and -18 are one to 36 teeth.
    assert!(mean < 1e-6 * first.amax());
    // A pitch is 10 degrees.
    assert!(differs(&at(&pierced(1.0, 20.0), 2)) < 1e-10);
    let [left, right] = [pierced(-1.0, 7.0), pierced(1.0, -7.0)].map(|model| at(&model, 1));
    assert!((left - right).amax() < 1e-10 * first.amax());
}

#[test]
fn a_ring_is_the_softer_the_fewer_its_supports_are_and_stiffest_where_it_is_held() {
    let mut ring = samples::gear(GearKind::Ring, 72, 1.0, 0.0, 0.0);
    ring.face_width = 12e-3;
    let settings = Settings::new(Refinement::Coarse, 1);
    let radius = ring.root_radius() + 5e-3;
    let segments = vec![segment(
        &ring,
        0,
        [0.0, ring.face_width],
        ring.reference_radius(),
    )];
    let rigid = model(&ring).bulk(&segments).unwrap()[0];
    let own = |shape: BodyShape| {
        let body = UnevenBody {
            radius,
            z: [0.0, ring.face_width],
            shape,
        };
        let on_foundation = model(&cut_from(&ring, &body));
        let held = on_foundation
            .on_body(&ring, &body, &settings, None, &|_, _| true)
            .unwrap();
        (0..72)
            .map(|tooth| held.at_tooth(tooth).unwrap().bulk(&segments).unwrap()[0])
            .collect::<Vec<f64>>()
    };
    let supports = |count, degrees: f64| BodyShape::Supports {
        count,
        width: degrees.to_radians(),
        angle: 0.0,
    };
    let pins = BodyShape::Pins(HoleCircle {
        count: 4,
        circle_radius: radius + 5e-3,
        radius: 2.5e-3,
        angle: 0.0,
    });
    let ends = |shape: BodyShape| {
        let own = own(shape).into_iter().map(|own| own / rigid);
        own.fold([f64::INFINITY, 0.0f64], |[least, most], own| {
            [least.min(own), most.max(own)]
        })
    };
    // Held nearly all over; between three supports the rim bends like a beam.
    let all_over = ends(supports(12, 28.5));
    assert!(all_over[0] > 1.0 && all_over[1] < 1.01, "{all_over:?}");
    let three = ends(supports(3, 20.0));
    assert!(
        (1.0..1.1).contains(&three[0]) && three[1] > 5.0,
        "{three:?}"
    );
    let four_pins = ends(pins);
    assert!(
        (1.1..1.5).contains(&four_pins[0]) && four_pins[1] > 5.0,
        "{four_pins:?}"
    );
}
