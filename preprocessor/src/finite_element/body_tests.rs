//! Rims, webs, hubs and foundations against an independent model of the whole gear and against closed forms.

use super::mesh::Mesh;
use super::*;
use crate::samples;
use approx::assert_relative_eq;
use gearmesh::gear::{Body, GearKind, Stub};
use gearmesh::pair::Refinement;
use serde::Deserialize;
use std::f64::consts::PI;

/// What scripts/thin_rim.py writes.
#[derive(Deserialize)]
struct Data {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    name: String,
    teeth: u32,
    normal_module_mm: f64,
    helix_angle_deg: f64,
    face_width_mm: f64,
    rim_thickness_mm: f64,
    web_z_mm: [f64; 2],
    hub_diameter_mm: f64,
    hub_z_mm: [f64; 2],
    bore_diameter_mm: f64,
    #[serde(default)]
    held_z_mm: Vec<f64>,
    kernel_half_width_mm: f64,
    #[serde(rename = "strips")]
    segments: Vec<Place>,
    influence_nm_per_n: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
struct Place {
    tooth: i32,
    z_mm: [f64; 2],
    diameter_mm: [f64; 2],
}

impl Case {
    fn gear(&self) -> Gear {
        let mut gear = samples::gear(
            GearKind::External,
            self.teeth,
            1.0,
            self.helix_angle_deg,
            0.0,
        );
        gear = samples::with_module(gear, 1e-3 * self.normal_module_mm);
        gear.face_width = 1e-3 * self.face_width_mm;
        gear.tip_radius = gear.reference_radius() + gear.normal_module;
        gear.held_radius = 0.5e-3 * self.bore_diameter_mm;
        gear.body = Some(Body {
            rim_radius: gear.root_radius() - 1e-3 * self.rim_thickness_mm,
            web: self.web_z_mm.map(|z| 1e-3 * z),
            hub_radius: 0.5e-3 * self.hub_diameter_mm,
            hub: self.hub_z_mm.map(|z| 1e-3 * z),
            held_ends: self.hub_z_mm.map(|z| self.held_z_mm.contains(&z)),
        });
        gear
    }

    fn segments(&self, gear: &Gear) -> Vec<Segment> {
        let segment = |place: &Place| Segment {
            tooth: place.tooth,
            z: place.z_mm.map(|z| 1e-3 * z),
            roll: place.diameter_mm.map(|d| gear.roll_length(0.5e-3 * d)),
        };
        self.segments.iter().map(segment).collect()
    }
}

#[test]
fn thin_rims_and_pinion_shafts_give_way_like_an_independent_model_of_the_whole_gear() {
    let text = include_str!("../../../tests/data/thin_rim.json");
    let data: Data = serde_json::from_str(text).unwrap();
    for case in data.cases {
        let gear = case.gear();
        let mut settings = Settings::new(Refinement::Normal, 2);
        settings.discretization.kernel_half_width =
            case.kernel_half_width_mm / case.normal_module_mm;
        let model = FiniteElementCompliance::new(&gear, &settings, &|_, _| true).unwrap();
        let found = 1e9 * model.bulk(&case.segments(&gear)).unwrap();
        let worst = case
            .influence_nm_per_n
            .iter()
            .enumerate()
            .flat_map(|(i, row)| row.iter().enumerate().map(move |(j, v)| (i, j, *v)))
            .map(|(i, j, expected)| (found[(i, j)] / expected - 1.0, i, j))
            .max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
            .unwrap();
        assert!(worst.0.abs() < 1e-2, "{}: {worst:?}", case.name);
        if !case.held_z_mm.is_empty() {
            continue;
        }
        // A full disc is another gear.
        let disc = Gear { body: None, ..gear };
        let disc = FiniteElementCompliance::new(&disc, &settings, &|_, _| true).unwrap();
        let stiffer = 1e9 * disc.bulk(&case.segments(&case.gear())).unwrap()[(0, 0)];
        assert!(stiffer < 0.8 * found[(0, 0)], "{stiffer} {}", found[(0, 0)]);
    }
}

fn webbed(helix_deg: f64) -> Gear {
    Gear {
        body: Some(Body {
            rim_radius: 28e-3,
            web: [4e-3, 9e-3],
            hub_radius: 20e-3,
            hub: [-3e-3, 21e-3],
            held_ends: [false; 2],
        }),
        ..samples::gear(GearKind::External, 20, 1.0, helix_deg, 0.0)
    }
}

fn model_at(gear: &Gear, refinement: Refinement) -> FiniteElementCompliance {
    FiniteElementCompliance::new(gear, &Settings::new(refinement, 1), &|_, _| true).unwrap()
}

fn model(gear: &Gear) -> FiniteElementCompliance {
    model_at(gear, Refinement::Coarse)
}

#[test]
fn parts_as_wide_as_the_face_are_the_full_disc() {
    let disc = Gear {
        face_width: 12e-3,
        ..samples::gear(GearKind::External, 20, 1.0, 13.0, 0.0)
    };
    let face = [0.0, disc.face_width];
    let parts = Gear {
        body: Some(Body {
            rim_radius: 28e-3,
            web: face,
            hub_radius: 20e-3,
            hub: face,
            held_ends: [false; 2],
        }),
        ..disc.clone()
    };
    let roll = disc.roll_length(40e-3);
    let segments = [0, 1].map(|tooth| Segment {
        tooth,
        z: [2e-3, 7e-3],
        roll: [roll, roll - 1e-3],
    });
    let [a, b] =
        [&disc, &parts].map(|gear| model_at(gear, Refinement::Normal).bulk(&segments).unwrap());
    // Another mesh of the same gear.
    for (a, b) in a.iter().zip(b.iter()) {
        assert_relative_eq!(a, b, max_relative = 3e-3);
    }
}

#[test]
fn volume_of_rim_web_and_hub_is_that_of_their_rings() {
    let gear = webbed(20.0);
    let disc = Gear {
        body: None,
        ..gear.clone()
    };
    for refinement in [Refinement::Coarse, Refinement::Normal, Refinement::Fine] {
        let settings = Settings::new(refinement, 1);
        let [(with, quality), (without, _)] = [&gear, &disc].map(|gear| {
            let model = Model::new(gear, &settings).unwrap();
            Mesh::new(&model).volume_and_quality()
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
fn flank_and_fillet_lie_where_the_outline_has_them() {
    let webbed = webbed(20.0);
    let disc = Gear {
        body: None,
        ..webbed.clone()
    };
    for gear in [disc, webbed] {
        let mesh = Mesh::new(&Model::new(&gear, &Settings::new(Refinement::Normal, 0)).unwrap());
        let (root, reference, tip) = (
            gear.root_radius() - 1e-9,
            gear.reference_radius() + 1e-9,
            gear.tip_radius + 1e-9,
        );
        assert!(mesh.fillet.len() > 50 && mesh.flank.len() > 50);
        let fillet = mesh.fillet.iter().map(|node| (*node, root..reference));
        let flank = mesh.flank.iter().map(|flank| (flank.node, root..tip));
        for (node, radii) in fillet.chain(flank) {
            let [x, y, z] = mesh.points[node];
            assert!(radii.contains(&x.hypot(y)) && (-1e-12..25e-3 + 1e-12).contains(&z));
        }
    }
}

#[test]
fn segments_seen_from_the_other_end_meet_the_body_turned_round() {
    // Right-handed with the web near z = 0, and its mirror image: mirrored segments on the model of the turned body.
    let gear = webbed(0.0);
    let own = model(&gear);
    let segments = |mirror: bool| -> Vec<Segment> {
        [(0, 0.0, 2e-3), (0, 7e-3, 8.3e-3), (1, 2e-3, 2.7e-3)]
            .map(|(tooth, low, high)| Segment {
                tooth,
                z: if mirror {
                    [gear.face_width - high, gear.face_width - low]
                } else {
                    [low, high]
                },
                roll: [gear.roll_length(40e-3); 2],
            })
            .to_vec()
    };
    let here = own.bulk(&segments(false)).unwrap();
    let turned = own.turned().unwrap().bulk(&segments(true)).unwrap();
    assert!((&here - turned).amax() < 1e-9 * here.amax());
    assert!((&here - own.bulk(&segments(true)).unwrap()).amax() > 1e-2 * here.amax());
    assert!(model(&Gear { body: None, ..gear }).turned().is_none());
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
        let model = FiniteElementCompliance::new(&gear, &settings, &|_, _| true).unwrap();
        let roll = gear.roll_length(gear.reference_radius());
        let segments = [0, 1, 2].map(|tooth| Segment {
            tooth,
            z: [0.0, gear.face_width],
            roll: [roll; 2],
        });
        let found = model.bulk(&segments).unwrap();
        let area = 2.0 * PI * gear.held_radius * gear.face_width;
        let turn = (gear.base_radius() / gear.held_radius).powi(2);
        for k in 0..3 {
            let angle = 2.0 * PI * k as f64 / gear.z();
            let expected = (angle.cos() + turn) / (stiffness * area);
            assert_relative_eq!(found[(k, 0)], expected, max_relative = 1e-3);
        }
    }
}

#[test]
fn a_hard_foundation_is_a_rigid_one() {
    let rigid = samples::gear(GearKind::Ring, 40, 1.0, 10.0, 0.0);
    let hard = Gear {
        foundation: Some(1e20),
        ..rigid.clone()
    };
    let segment = Segment {
        tooth: 0,
        z: [0.0, 10e-3],
        roll: [rigid.roll_length(rigid.reference_radius()); 2],
    };
    let [a, b] = [&rigid, &hard].map(|gear| model(gear).bulk(&[segment]).unwrap()[(0, 0)]);
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
    gear.body = Some(Body::shaft(
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
        let settings = Settings::new(Refinement::Coarse, 16);
        let model = FiniteElementCompliance::new(&gear, &settings, &|_, _| true).unwrap();
        let segments: Vec<Segment> = (0..17)
            .map(|tooth| Segment {
                tooth,
                z: [0.0, gear.face_width],
                roll: [gear.roll_length(gear.reference_radius()); 2],
            })
            .collect();
        let bulk = model.bulk(&segments).unwrap();
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
    assert_relative_eq!(
        compliances[1][0] - compliances[0][0],
        twist,
        max_relative = 5e-3
    );
    // Cantilevers under a force at mid-face; Cowper's factor of a round section.
    let bending = |length: f64| {
        let half = 0.5 * gear.face_width;
        let factor = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu);
        ((length + half).powi(3) - half.powi(3)) / (3.0 * e * 0.25 * PI * fourth)
            + length / (factor * shear * PI * (r * r - hole * hole))
    };
    let expected = bending(lengths[1]) - bending(lengths[0]);
    assert_relative_eq!(
        compliances[1][1] - compliances[0][1],
        expected,
        max_relative = 2e-2
    );
    // What the estimates say of the whole.
    let [twist, bent] = [pinion_shaft(60e-3)].map(|gear| {
        [
            gear.base_radius().powi(2) * gear.body_twist(),
            gear.body_tilt_and_foundation(),
        ]
    })[0];
    assert_relative_eq!(compliances[1][0], twist, max_relative = 0.3);
    assert_relative_eq!(compliances[1][1], bent, max_relative = 0.3);
}

#[test]
fn bodies_that_do_not_join_and_plane_sections_of_webs_are_refused() {
    let sound = webbed(0.0);
    let settings = Settings::new(Refinement::Coarse, 0);
    let refused = |change: fn(&mut Body)| {
        let mut gear = sound.clone();
        gear.body.as_mut().map(change);
        let error = FiniteElementCompliance::new(&gear, &settings, &|_, _| true).unwrap_err();
        matches!(error, FiniteElementError::Body { .. })
    };
    assert!(refused(|b| b.rim_radius = 36e-3));
    assert!(refused(|b| b.rim_radius = f64::NAN));
    assert!(refused(|b| b.hub_radius = 29e-3));
    assert!(refused(|b| b.web = [9e-3, 9e-3]));
    assert!(refused(|b| b.web = [-5e-3, 9e-3]));
    assert!(refused(|b| b.hub = [5e-3, 9e-3]));
    let plane = Settings {
        plane_strain: true,
        ..settings
    };
    let error = FiniteElementCompliance::new(&sound, &plane, &|_, _| true).unwrap_err();
    assert!(matches!(error, FiniteElementError::PlaneBody), "{error}");
}
