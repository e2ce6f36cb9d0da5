use super::*;
use proptest::prelude::*;

fn smooth() -> Vec<DMatrix<f64>> {
    let entry = |k: usize| {
        move |i: usize, j: usize| {
            let apart = (i as f64 - j as f64).abs();
            2e-9 / (1.0 + 0.1 * apart + 10.0 * k as f64)
        }
    };
    (0..3).map(|k| DMatrix::from_fn(60, 60, entry(k))).collect()
}

#[test]
fn entries_are_kept_to_a_billionth_of_the_largest() {
    let matrices = smooth();
    let influence = Influence::new(&matrices);
    assert_eq!(influence.teeth(), 3);
    for (k, matrix) in matrices.iter().enumerate() {
        for j in 0..60 {
            for (i, value) in influence.column(k, j).iter().enumerate() {
                let error = f64::from(*value) * influence.unit - matrix[(i, j)];
                assert!(error.abs() < 2e-9 * 1e-9, "{error}");
            }
        }
    }
}

#[test]
fn what_is_cut_or_too_long_is_not_read() {
    let mut bytes = Influence::new(&smooth()).encode();
    for length in [0, 8, 15, 16, bytes.len() - 1] {
        assert_eq!(Influence::decode(&bytes[..length]), None, "{length}");
    }
    bytes.push(0);
    assert_eq!(Influence::decode(&bytes), None);
}

proptest! {
    #[test]
    fn any_numbers_come_back(entries in proptest::collection::vec(any::<i32>(), 18)) {
        let influence = Influence { unit: 1e-15, nodes: 3, entries };
        prop_assert_eq!(Influence::decode(&influence.encode()), Some(influence));
    }
}
