//! Rims, webs, hubs and foundations against an independent model of the whole gear and against closed forms.

use super::mesh::Layers;
use super::model::Model;
use super::tests::{model, plane, segment};
use super::*;
use crate::compliance::ToothCompliance;
use crate::gear::body::Stub;
use crate::gear::{BodyShape, HoleCircle, Refinement, UnevenBody, body};
use crate::samples;
use approx::assert_relative_eq;
use gearmesh::contact::Segment;
use gearmesh::gear::{Body, Gear, GearKind};
use nalgebra::DMatrix;
use serde_json::Value;
use std::f64::consts::PI;

/// The gear of a `case` that validation/reference/thin_rim.py writes.
fn gear_of(case: &Value) -> Gear {
    let number = |key: &str| case[key].as_f64().unwrap();
    let ends = |key: &str| [0, 1].map(|i| 1e-3 * case[key][i].as_f64().unwrap());
    let teeth = number("teeth") as u32;
    let helix = number("helix_angle_deg");
    let outside = case["rim_diameter_mm"].as_f64();
    let kind = outside.map_or(GearKind::External, |_| GearKind::Ring);
    let gear = samples::gear(kind, teeth, 1.0, helix, 0.0);
    let mut gear = samples::with_module(gear, 1e-3 * number("normal_module_mm"));
    gear.face_width = 1e-3 * number("face_width_mm");
    gear.tip_radius = gear.reference_radius() + gear.kappa() * gear.normal_module;
    if let Some(outside) = outside {
        gear.held_radius = 0.5e-3 * outside;
        return gear;
    }
    gear.held_radius = 0.5e-3 * number("bore_diameter_mm");
    let held_ends = case["held_z_mm"].as_array();
    let held = |z: &Value| held_ends.is_some_and(|held| held.contains(z));
    gear.body = Some(Body {
        rim_radius: gear.root_radius() - 1e-3 * number("rim_thickness_mm"),
        web: ends("web_z_mm"),
        hub_radius: 0.5e-3 * number("hub_diameter_mm"),
        hub: ends("hub_z_mm"),
        held_ends: [0, 1].map(|i| held(&case["hub_z_mm"][i])),
    });
    gear
}

#[test]
fn thin_rims_and_pinion_shafts_deflect_like_an_independent_model_of_the_whole_gear() {
    let text = include_str!("../../../tests/data/thin_rim.json");
    let data: Value = serde_json::from_str(text).unwrap();
    for case in data["cases"].as_array().unwrap() {
        let gear = gear_of(case);
        let mut settings = Settings::new(Refinement::Normal, 2);
        let kernel = 1e-3 * case["kernel_half_width_mm"].as_f64().unwrap();
        settings.discretization.kernel_half_width = kernel / gear.normal_module;
        let segments = segments_of(case, &gear);
        let bulk = |gear: &Gear| 1e9 * model(gear, &settings).bulk(&segments).unwrap();
        let found = bulk(&gear);
        for (i, row) in found.row_iter().enumerate() {
            for (j, found) in row.iter().enumerate() {
                let expected = case["influence_nm_per_n"][i][j].as_f64().unwrap();
                assert_relative_eq!(*found, expected, max_relative = 1e-2);
            }
        }
        if gear.body.is_some_and(|body| body.held_ends == [false; 2]) {
            // A full disc is another gear.
            let full = disc(&gear);
            let disc = bulk(&full);
            assert!(disc[0] < 0.8 * found[0], "{} {}", disc[0], found[0]);
            assert!(body::twist(&full) < 0.7 * body::twist(&gear));
            assert_eq!(body::tilt_and_foundation(&full), 0.0);
            assert_eq!(
                body::tilt_and_foundation(&gear) > 0.0,
                gear.helix_angle > 0.0
            );
        }
    }
}

/// The segments of a `case` on `gear`.
fn segments_of(case: &Value, gear: &Gear) -> Vec<Segment> {
    let of_strip = |strip: &Value| {
        let ends = |key: &str| [0, 1].map(|i| 1e-3 * strip[key][i].as_f64().unwrap());
        Segment {
            tooth: strip["tooth"].as_i64().unwrap() as i32,
            z: ends("z_mm"),
            roll: ends("diameter_mm").map(|d| gear.roll_length(0.5 * d)),
        }
    };
    case["strips"]
        .as_array()
        .unwrap()
        .iter()
        .map(of_strip)
        .collect()
}

/// The only case of a file, its gear, and its circle of holes or pins, one of them at `angle` (rad).
fn case_of(text: &str, circle: &str, angle: f64) -> (Value, Gear, HoleCircle) {
    let mut data: Value = serde_json::from_str(text).unwrap();
    let case = data["cases"][0].take();
    let gear = gear_of(&case);
    let number = |key: &str| case[circle][key].as_f64().unwrap();
    let circle = HoleCircle {
        count: number("count") as u32,
        circle_radius: 0.5e-3 * number("circle_mm"),
        radius: 0.5e-3 * number("diameter_mm"),
        angle,
    };
    (case, gear, circle)
}

/// Influences of the segments of `case` on `gear` with this `body`, and those expected, nm/N.
fn influences(case: &Value, gear: &Gear, body: &UnevenBody) -> [DMatrix<f64>; 2] {
    let segments = segments_of(case, gear);
    let last = segments.iter().map(|segment| segment.tooth).max().unwrap();
    let mut settings = Settings::new(Refinement::Normal, last as usize);
    let kernel = 1e-3 * case["kernel_half_width_mm"].as_f64().unwrap();
    settings.discretization.kernel_half_width = kernel / gear.normal_module;
    let on_foundation = model(&super::uneven::cut_from(gear, body), &settings);
    let on_body = on_foundation.on_body(gear, body, &settings, None, &|_, _| true);
    let found = on_body.unwrap().at_tooth(0).unwrap().bulk(&segments);
    let expected = DMatrix::from_fn(segments.len(), segments.len(), |i, j| {
        case["influence_nm_per_n"][i][j].as_f64().unwrap()
    });
    [1e9 * found.unwrap(), expected]
}

#[test]
fn teeth_above_and_between_the_holes_of_a_web_deflect_like_an_independent_model_of_the_whole_gear()
{
    let text = include_str!("../../../tests/data/web_holes.json");
    let (case, gear, circle) = case_of(text, "web_holes", 0.0);
    let body = gear.body.unwrap();
    let body = UnevenBody {
        radius: body.rim_radius,
        z: body.web,
        shape: BodyShape::Holes(circle),
    };
    let [found, expected] = influences(&case, &gear, &body);
    for (found, expected) in found.iter().zip(&expected) {
        assert_relative_eq!(*found, *expected, max_relative = 3e-3);
    }
    // Of the teeth themselves 5 % hang on where they stand.
    let varies = |of: &DMatrix<f64>| (of[(1, 1)] - of[(0, 0)]) / of[(0, 0)];
    let modulation = varies(&expected);
    assert!(modulation > 0.04);
    assert_relative_eq!(varies(&found), modulation, max_relative = 3e-2);
}

#[test]
fn teeth_of_a_ring_over_and_between_its_pins_yield_as_in_an_independent_model() {
    let text = include_str!("../../../tests/data/ring_pins.json");
    // A pin lies below the middle of tooth 0, and body +x half a pitch from there.
    let half_pitch = PI / 40.0;
    let (case, gear, circle) = case_of(text, "rim_pins", -half_pitch);
    let body = UnevenBody {
        radius: gear.root_radius() + 1.25 * gear.normal_module,
        z: [0.0, gear.face_width],
        shape: BodyShape::Pins(circle),
    };
    let [found, expected] = influences(&case, &gear, &body);
    let own = expected.diagonal().map(f64::sqrt);
    let error = (&found - &expected).component_div(&(&own * own.transpose()));
    assert!(error.amax() < 1.5e-2, "{error:.4}");
    // Midway between two pins a tooth deflects nearly twice as far as above one.
    assert!(expected[(3, 3)] > 1.8 * expected[(0, 0)]);
}

/// Of 20 teeth, the rim inside at 28 mm, the hub at 20 mm, the bore at 15 mm.
fn with_web(helix_deg: f64, web: [f64; 2], hub: [f64; 2]) -> Gear {
    let mut gear = samples::gear(GearKind::External, 20, 1.0, helix_deg, 0.0);
    gear.body = Some(Body {
        rim_radius: 28e-3,
        web,
        hub_radius: 20e-3,
        hub,
        held_ends: [false; 2],
    });
    gear
}

fn webbed(helix_deg: f64) -> Gear {
    with_web(helix_deg, [4e-3, 9e-3], [-3e-3, 21e-3])
}

fn disc(gear: &Gear) -> Gear {
    Gear {
        body: None,
        ..gear.clone()
    }
}

#[test]
fn layers_end_at_every_face_of_the_body_and_mirror_with_it() {
    let gear = webbed(0.0);
    let layers = |gear: &Gear| Layers::new(gear, &Discretization::of(Refinement::Normal));
    let own = layers(&gear);
    for z in [-3e-3, 0.0, 4e-3, 9e-3, 21e-3, 25e-3] {
        assert!(own.stations.contains(&z), "{z}");
    }
    let face = [own.of_face()[0], own.of_face()[own.face.len()]];
    assert_eq!(face, [0.0, 25e-3]);
    let turned = layers(&body::turned(&gear).unwrap()).stations;
    assert_eq!(turned.len(), own.stations.len());
    for (a, b) in turned.iter().rev().zip(&own.stations) {
        assert!((25e-3 - a - b).abs() < 1e-12);
    }
}

#[test]
fn wide_faces_have_thicker_layers_instead_of_more_but_for_the_thin_ones_at_the_ends() {
    let [narrow, wide, wider] = [60e-3, 120e-3, 240e-3].map(|face_width| {
        let gear = samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0);
        let sizes = Discretization::of(Refinement::Normal);
        let stations = Layers::new(&Gear { face_width, ..gear }, &sizes).stations;
        let end = stations[1] / 4e-3;
        assert!((0.24..0.36).contains(&end), "{end}");
        stations.len()
    });
    assert!(wide <= narrow + 4 && wider <= wide + 4);
}

fn coarse(gear: &Gear) -> FiniteElementCompliance {
    model(gear, &Settings::new(Refinement::Coarse, 1))
}

#[test]
fn parts_as_wide_as_the_face_are_the_full_disc() {
    let face = [0.0, 12e-3];
    let mut parts = with_web(13.0, face, face);
    parts.face_width = face[1];
    let disc = disc(&parts);
    let segments = [0, 1].map(|tooth| {
        let radius = 40e-3 - 2e-3 * f64::from(tooth);
        segment(&disc, tooth, [2e-3, 7e-3], radius)
    });
    let settings = Settings::new(Refinement::Normal, 1);
    let [a, b] = [&disc, &parts].map(|gear| model(gear, &settings).bulk(&segments).unwrap());
    // Another mesh of the same gear.
    for (a, b) in a.iter().zip(b.iter()) {
        assert_relative_eq!(a, b, max_relative = 3e-3);
    }
}

#[test]
fn volume_of_rim_web_and_hub_is_that_of_their_rings() {
    let gear = webbed(20.0);
    let disc = disc(&gear);
    for refinement in [Refinement::Coarse, Refinement::Normal, Refinement::Fine] {
        let settings = Settings::new(refinement, 1);
        let [(with, quality), (without, _)] = [&gear, &disc].map(|gear| {
            let model = Model::new(gear, &settings).unwrap();
            model.mesh().volume_and_quality()
        });
        let rings: f64 = [(15e-3, 20e-3, 1e-3), (20e-3, 28e-3, 20e-3)]
            .iter()
            .map(|(inner, outer, less): &(f64, f64, f64)| {
                PI * (outer * outer - inner * inner) * less
            })
            .sum();
        assert_relative_eq!(without - with, rings / gear.z(), max_relative = 1e-3);
        assert!(quality > 0.05, "{quality}");
    }
}

#[test]
fn segments_seen_from_the_other_end_meet_the_body_turned_round() {
    // Right-handed with the web near z = 0, and its mirror image: mirrored segments on the model of the turned body.
    let gear = webbed(0.0);
    let own = coarse(&gear);
    let segments = |mirror: bool| {
        [(0, 0.0, 2e-3), (0, 7e-3, 8.3e-3), (1, 2e-3, 2.7e-3)].map(|(tooth, low, high)| {
            let z = if mirror {
                [25e-3 - high, 25e-3 - low]
            } else {
                [low, high]
            };
            segment(&webbed(0.0), tooth, z, 40e-3)
        })
    };
    let here = own.bulk(&segments(false)).unwrap();
    let turned = own.turned().unwrap().bulk(&segments(true)).unwrap();
    // The two models leave out other parts of their side loads, under which gears hardly deflect.
    let (error, largest) = ((&here - turned).amax(), here.amax());
    assert!(error < 1e-7 * largest, "{error:e} of {largest:e}");
    assert!((&here - own.bulk(&segments(true)).unwrap()).amax() > 1e-2 * here.amax());
    // A full disc is itself turned round.
    let disc = coarse(&disc(&gear));
    assert!(disc.turned().is_none());
    let [here, turned] = [false, true].map(|mirror| disc.bulk(&segments(mirror)).unwrap());
    assert!((&here - turned).amax() < 1e-9 * here.amax());
}

#[test]
fn a_ring_on_a_soft_foundation_moves_as_a_rigid_body() {
    // Force F along the line of action on one tooth, foundation k per area A = 2 pi r b in every direction: the ring
    // moves by F / (k A) and turns by F rb / (k A r²); teeth displacements along their own normals follow.
    let mut gear = samples::gear(GearKind::Ring, 40, 1.0, 0.0, 0.0);
    gear.face_width = 10e-3;
    for plane_strain in [false, true] {
        let stiffness = 1e6;
        gear.foundation = Some(stiffness);
        let settings = Settings {
            plane_strain,
            ..Settings::new(Refinement::Coarse, 2)
        };
        let face = [0.0, gear.face_width];
        let segments = [0, 1, 2].map(|tooth| segment(&gear, tooth, face, gear.reference_radius()));
        let found = model(&gear, &settings).bulk(&segments).unwrap();
        let area = 2.0 * PI * gear.held_radius * gear.face_width;
        let turn = (gear.base_radius() / gear.held_radius).powi(2);
        for k in 0..3 {
            let angle = 2.0 * PI * k as f64 / gear.z();
            let expected = (angle.cos() + turn) / (stiffness * area);
            assert_relative_eq!(found[(k, 0)], expected, max_relative = 1e-3);
        }
        let softness = (1.0 + turn) / (stiffness * area);
        assert_relative_eq!(
            body::tilt_and_foundation(&gear),
            softness,
            max_relative = 1e-12
        );
    }
}

#[test]
fn a_hard_foundation_is_a_rigid_one() {
    let rigid = samples::gear(GearKind::Ring, 40, 1.0, 10.0, 0.0);
    let hard = Gear {
        foundation: Some(1e20),
        ..rigid.clone()
    };
    let segment = segment(&rigid, 0, [0.0, 10e-3], rigid.reference_radius());
    let [a, b] = [&rigid, &hard].map(|gear| coarse(gear).bulk(&[segment]).unwrap()[(0, 0)]);
    assert_relative_eq!(a, b, max_relative = 1e-6);
}

/// Spur pinion of 17 teeth on a shaft of 20 mm, 12 mm of it at low z and `length` at high z, held there.
fn pinion_shaft(length: f64) -> Gear {
    let mut gear = samples::gear(GearKind::External, 17, 1.0, 0.0, 0.0);
    let stub = |length, held| Stub {
        radius: 10e-3,
        length,
        held,
    };
    gear.body = Some(body::shaft(
        [stub(12e-3, false), stub(length, true)],
        gear.face_width,
    ));
    gear.held_radius = 1e-3;
    gear
}

#[test]
fn a_longer_shaft_twists_and_bends_as_beam_theory_says() {
    let lengths = [20e-3, 60e-3];
    let compliances = lengths.map(|length| {
        let gear = pinion_shaft(length);
        let face = [0.0, gear.face_width];
        let segments = (0..17).map(|tooth| segment(&gear, tooth, face, gear.reference_radius()));
        let model = model(&gear, &Settings::new(Refinement::Coarse, 16));
        let bulk = model.bulk(&segments.collect::<Vec<_>>()).unwrap();
        let harmonic = |k: f64| -> f64 {
            let wave = |tooth: usize| (2.0 * PI * k * tooth as f64 / 17.0).cos();
            (0..17)
                .map(|tooth| bulk[(tooth, 0)] * wave(tooth))
                .sum::<f64>()
                / 17.0
        };
        [harmonic(0.0), 2.0 * harmonic(1.0)]
    });
    let gear = pinion_shaft(20e-3);
    let (e, nu, r, hole) = (gear.youngs_modulus, gear.poisson_ratio, 10e-3_f64, 1e-3_f64);
    let shear = 0.5 * e / (1.0 + nu);
    let fourth = r.powi(4) - hole.powi(4);
    let twist =
        gear.base_radius().powi(2) * (lengths[1] - lengths[0]) / (shear * 0.5 * PI * fourth);
    let more = [0, 1].map(|harmonic| compliances[1][harmonic] - compliances[0][harmonic]);
    assert_relative_eq!(more[0], twist, max_relative = 5e-3);
    // Cantilevers under a force at mid-face; Cowper's factor of a round section.
    let bending = |length: f64| {
        let half = 0.5 * gear.face_width;
        let factor = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu);
        ((length + half).powi(3) - half.powi(3)) / (3.0 * e * 0.25 * PI * fourth)
            + length / (factor * shear * PI * (r * r - hole * hole))
    };
    let expected = bending(lengths[1]) - bending(lengths[0]);
    assert_relative_eq!(more[1], expected, max_relative = 2e-2);
    // What the estimates say of the whole.
    let gear = pinion_shaft(60e-3);
    let twist = gear.base_radius().powi(2) * body::twist(&gear);
    assert_relative_eq!(compliances[1][0], twist, max_relative = 0.3);
    let bent = body::tilt_and_foundation(&gear);
    assert_relative_eq!(compliances[1][1], bent, max_relative = 0.3);
}

#[test]
fn plane_sections_of_webs_are_refused() {
    let plane = plane(Refinement::Coarse, 0);
    let refused = FiniteElementCompliance::new(&webbed(0.0), &plane, None, &|_, _| true);
    let error = refused.unwrap_err();
    assert!(matches!(error, FiniteElementError::PlaneBody), "{error}");
}
