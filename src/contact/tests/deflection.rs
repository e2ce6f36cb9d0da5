//! Deflections along the face.

use crate::contact::{ContactError, Deflection};

#[test]
fn a_curve_is_straight_through_and_beyond_its_points_and_turns_smoothly_from_piece_to_piece() {
    let curve = Deflection::new(vec![[0.0, 1e-6], [10e-3, 3e-6], [20e-3, 2e-6]]).unwrap();
    for (z, closing, slope) in [
        (0.0, 1.0, 200.0),
        (5e-3, 2.0, 200.0),
        (10e-3, 3.0, 50.0),
        (15e-3, 2.5, -100.0),
        (30e-3, 1.0, -100.0),
        (-5e-3, 0.0, 200.0),
    ] {
        let found = curve.closing(z).map(|value| 1e6 * value);
        assert!((found[0] - closing).abs() < 1e-9, "{z} {found:?}");
        assert!((found[1] - slope).abs() < 1e-9, "{z} {found:?}");
    }
    for (beyond, range) in [(0.0, [1.0, 3.0]), (2e-3, [0.6, 3.1])] {
        let found = curve.range([0.0, 20e-3], beyond).map(|value| 1e6 * value);
        let error = (found[0] - range[0]).hypot(found[1] - range[1]);
        assert!(error < 1e-9, "{beyond} {found:?}");
    }
    assert_eq!(Deflection::default().closing(1.0), [0.0; 2]);
}

#[test]
fn a_bow_is_zero_in_the_middle_and_opens_the_ends() {
    let bow = Deflection::bow(4e-6, [2e-3, 22e-3]).unwrap();
    for (z, closing) in [(2e-3, -4.0), (12e-3, 0.0), (17e-3, -1.0), (22e-3, -4.0)] {
        assert!((1e6 * bow.closing(z)[0] - closing).abs() < 1e-9, "{z}");
    }
}

#[test]
fn what_is_no_curve_is_refused() {
    for points in [
        vec![[0.0, 0.0]],
        vec![[0.0, 0.0], [0.0, 1.0]],
        vec![[0.0, 0.0], [1.0, f64::NAN]],
    ] {
        assert!(matches!(
            Deflection::new(points),
            Err(ContactError::Input { .. })
        ));
    }
}
