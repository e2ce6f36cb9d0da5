use super::*;
use crate::compliance::ToothCompliance;
use crate::gear::Refinement;
use crate::samples;
use approx::assert_relative_eq;
use gearmesh::contact::Segment;
use gearmesh::gear::{Gear, GearKind};

fn spur(teeth: u32, module: f64, bore_ratio: f64) -> Gear {
    let gear = samples::gear(GearKind::External, teeth, 1.0, 0.0, 0.0);
    let mut gear = samples::with_module(gear, module);
    gear.face_width = 6.0 * module;
    gear.held_radius = bore_ratio * gear.root_radius();
    gear
}

/// A segment of `gear` between the ends `z` (m) at the radius `radius` (m).
pub(super) fn segment(gear: &Gear, tooth: i32, z: [f64; 2], radius: f64) -> Segment {
    let roll = [gear.roll_length(radius); 2];
    Segment { tooth, z, roll }
}

pub(super) fn model(gear: &Gear, settings: &Settings) -> FiniteElementCompliance {
    let model = FiniteElementCompliance::new(gear, settings, None, &|_, _| true);
    model.unwrap().0
}

/// Settings of a model in plane strain.
pub(super) fn plane(refinement: Refinement, reach: usize) -> Settings {
    Settings {
        plane_strain: true,
        ..Settings::new(refinement, reach)
    }
}

#[test]
fn tooth_compliance_in_plane_strain_is_that_of_two_independent_codes() {
    // A kernel too narrow to matter, in place of a point load.
    let mut settings = plane(Refinement::Fine, 0);
    settings.discretization.flank_element = 0.06;
    settings.discretization.kernel_half_width = 0.06;
    // docs: bore = root radius / 1.4, module 1 mm, micrometres per N/mm.
    for (teeth, radius, expected) in [
        (17, 8.0023, 0.01626),
        (17, 8.5, 0.02226),
        (43, 21.5, 0.02085),
        (43, 22.4434, 0.05411),
    ] {
        let gear = spur(teeth, 1e-3, 1.0 / 1.4);
        let found = centre_line_compliance(&gear, &settings, 1e-3 * radius).unwrap();
        assert_relative_eq!(1e9 * found, expected, max_relative = 5e-3);
    }
}

/// Displacement of line loads at `radii` (m) on their own flank, Hertz contact of half-width 50 um
/// included, m²/N.
fn with_hertz(gear: &Gear, element: f64, kernel: f64, radii: &[f64]) -> Vec<f64> {
    let mut settings = plane(Refinement::Normal, 0);
    settings.discretization.flank_element = element;
    settings.discretization.kernel_half_width = kernel;
    let model = model(gear, &settings);
    let segments: Vec<Segment> = (radii.iter())
        .map(|r| segment(gear, 0, [0.0, 1.0], *r))
        .collect();
    let bulk = model.bulk(&segments).unwrap();
    let nu = gear.poisson_ratio;
    let local = 2.0 * (1.0 - nu * nu) / (std::f64::consts::PI * gear.youngs_modulus);
    let lengths = model.reference_lengths(&segments);
    (0..radii.len())
        .map(|i| bulk[(i, i)] + local * ((2.0 * lengths[i] / 50e-6).ln() + 0.5))
        .collect()
}

#[test]
fn kernel_width_from_0_3_to_1_mm_does_not_matter_to_a_pair() {
    // 20/20 teeth, module 4 mm, tips at 44 mm, C = 80 mm: approach of both flanks at points of the path of
    // contact. 0.2 %; within 0.7 mm of a tip edge 1 %, but not nearer to it than a third of the kernel's
    // half-width: from there on the load stays behind (1.1 % at 0.2 mm with a kernel of 1 mm).
    let gear = spur(20, 4e-3, 0.5);
    let radii = [40e-3, 41e-3, 42e-3, 43.0e-3, 43.5e-3, 43.8e-3];
    let both_rolls = 80e-3 * gear.normal_pressure_angle.sin();
    let mates = radii.map(|r| gear.radius_at_roll(both_rolls - gear.roll_length(r)));
    let approach = |kernel: f64| -> Vec<f64> {
        let own = with_hertz(&gear, 0.05, kernel, &radii);
        let mate = with_hertz(&gear, 0.05, kernel, &mates);
        own.iter().zip(&mate).map(|(a, b)| a + b).collect()
    };
    let narrow = approach(0.075);
    for (width, points) in [(0.1, 6), (0.15, 6), (0.25, 5)] {
        for (i, (a, b)) in approach(width).iter().zip(&narrow).enumerate().take(points) {
            let bar = if radii[i] < 43.2e-3 { 2e-3 } else { 1e-2 };
            assert_relative_eq!(a, b, max_relative = bar);
        }
    }
}

#[test]
fn normal_mesh_resolves_its_kernel() {
    let gear = spur(20, 4e-3, 0.5);
    let radii = [38e-3, 39e-3, 40e-3, 41e-3, 42e-3, 43.0e-3, 43.5e-3];
    let reference = with_hertz(&gear, 0.03, 0.1, &radii);
    let sizes = Discretization::of(Refinement::Normal);
    let normal = with_hertz(&gear, sizes.flank_element, sizes.kernel_half_width, &radii);
    for (a, b) in normal.iter().zip(&reference) {
        assert_relative_eq!(a, b, max_relative = 1e-3);
    }
}

#[test]
fn influence_matrix_of_segments_on_three_teeth_is_positive_definite() {
    let mut gear = spur(20, 4e-3, 0.5);
    gear.helix_angle = 13f64.to_radians();
    let settings = Settings::new(Refinement::Coarse, 2);
    let model = model(&gear, &settings);
    let tip = gear.roll_length(gear.tip_radius);
    let segments: Vec<Segment> = (0..3)
        .flat_map(|tooth| {
            (0..30).map(move |i| {
                let end = |k: i32| 24e-3 * f64::from(k) / 30.0;
                let roll = |z: f64| tip - 1e-3 - 3e-3 * f64::from(tooth) - 0.2 * z;
                Segment {
                    tooth,
                    z: [end(i), end(i + 1)],
                    roll: [roll(end(i)), roll(end(i + 1))],
                }
            })
        })
        .collect();
    let matrix = model.bulk(&segments).unwrap();
    assert_eq!(matrix, matrix.transpose());
    let least = matrix.symmetric_eigenvalues().min();
    assert!(least > 0.0, "least eigenvalue {least:e} m/N");
    let mut far = segments[0];
    far.tooth = 3;
    let refused = model.bulk(&[segments[0], far]).unwrap_err();
    assert_eq!((refused.distance, refused.reach), (3, 2));
}

#[test]
fn uniform_load_without_lateral_contraction_is_the_plane_problem() {
    // With nu = 0 nothing happens along z: the solid spur gear repeats its section.
    let mut gear = spur(20, 4e-3, 0.5);
    gear.poisson_ratio = 0.0;
    let solid = model(&gear, &Settings::new(Refinement::Coarse, 0));
    let plane = model(&gear, &plane(Refinement::Coarse, 0));
    let whole = segment(&gear, 0, [0.0, gear.face_width], 41e-3);
    let part = segment(&gear, 0, [3e-3, 5e-3], 41e-3);
    let expected = plane.bulk(&[whole]).unwrap()[(0, 0)];
    let matrix = solid.bulk(&[whole, part]).unwrap();
    // Loads act along the normals at the nodes, and 20-node elements weigh those unevenly along z: an
    // error of the square of the angle between neighbouring normals.
    assert_relative_eq!(matrix[(0, 0)], expected, max_relative = 1e-4);
    // The whole face moves evenly under it.
    assert_relative_eq!(matrix[(0, 1)], expected, max_relative = 3e-4);
}

#[test]
fn cancelling_stops_with_that_error() {
    let (gear, settings) = (spur(20, 4e-3, 0.5), plane(Refinement::Coarse, 0));
    let until_ring = |stage, _| stage != Stage::Ring;
    let stopped = FiniteElementCompliance::new(&gear, &settings, None, &until_ring);
    assert!(matches!(stopped, Err(FiniteElementError::Cancelled)));
}
