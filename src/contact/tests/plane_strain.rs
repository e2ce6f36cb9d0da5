use super::*;
use crate::gear::Flank;

/// Mean and peak-to-peak STE, um, of a spur pair in plane strain, contact on the path only, at `line_load`
/// (N/mm).
fn ste(pair: &Pair, line_load: f64) -> (f64, f64) {
    let settings = ContactSettings {
        stations: 4,
        tip_corner_contact: false,
        reach: None,
    };
    let solver = solver(pair, AxialState::PlaneStrain, settings);
    let (_, width) = pair.geometry.face_overlap();
    let input = CycleInput {
        flank: Flank::Drive,
        torque: 1e3 * line_load * width * pair.geometry.gears[0].base_radius(),
        center_distance_offset: 0.0,
        misalignment: 0.0,
        positions: 128,
    };
    let cycle = MeshCycle::solve(&solver, &input).unwrap();
    (1e6 * cycle.mean_ste(), 1e6 * cycle.peak_to_peak_ste())
}

#[test]
fn ste_in_plane_strain_is_that_of_two_dimensional_finite_elements() {
    let standard = [1.0, 1.25, 0.38];
    let cases = [
        (
            spur_pair(3.175, [28, 28], 20.0, [1.0, 1.25, 0.3]),
            250.0,
            12.222,
            5.854,
        ),
        (
            spur_pair(3.0, [50, 50], 20.0, standard),
            177.0,
            8.110,
            3.803,
        ),
        (
            spur_pair(1.0, [17, 43], 20.0, standard),
            100.0,
            4.947,
            2.373,
        ),
        // The paper's transverse section: lengths of the normal section over the transverse module.
        (
            spur_pair(
                4.1052,
                [20, 20],
                20.4833,
                [1.0, 5.0 / 4.1052, 1.52 / 4.1052],
            ),
            104.0,
            5.671,
            2.706,
        ),
    ];
    for (pair, load, mean, peak_to_peak) in cases {
        let (m, p) = ste(&pair, load);
        let (of_mean, of_peak) = (m / mean - 1.0, p / peak_to_peak - 1.0);
        assert!(of_mean.abs() < 0.06, "mean {m} instead of {mean}");
        assert!(of_peak.abs() < 0.07, "p-p {p} instead of {peak_to_peak}");
    }
}
