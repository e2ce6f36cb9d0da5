//! What a mesh cycle says beside its positions: harmonics, stiffness over the cycle, load along the face.

use std::f64::consts::TAU;

use super::mesh_cycle::MeshCycle;
use gearmesh::contact::SegmentLoad;

/// Harmonics of the mesh frequency that are reported.
pub const HARMONICS: usize = 10;

/// One harmonic of a quantity over the mesh cycle: amplitude cos(2 pi order mesh_position + phase).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
    /// Unit of the quantity.
    pub amplitude: f64,
    /// rad, in (-pi, pi].
    pub phase: f64,
}

/// Harmonics 1 to [`HARMONICS`] of `values` at even positions over one cycle; None for those that so few
/// positions cannot tell apart (from half their number on).
pub fn harmonics(values: &[f64]) -> [Option<Harmonic>; HARMONICS] {
    let n = values.len();
    std::array::from_fn(|h| {
        let order = h + 1;
        if 2 * order >= n {
            return None;
        }
        let (mut cos, mut sin) = (0.0, 0.0);
        for (i, value) in values.iter().enumerate() {
            let angle = TAU * (order * i % n) as f64 / n as f64;
            cos += value * angle.cos();
            sin += value * angle.sin();
        }
        Some(Harmonic {
            amplitude: 2.0 / n as f64 * cos.hypot(sin),
            phase: (-sin).atan2(cos),
        })
    })
}

/// Load per face width along the face: the mean over the mesh cycle of the transverse force on the line of
/// action of all tooth pairs.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceLoad {
    /// Middles of the stations, m in gear 1's frame.
    pub z: Vec<f64>,
    /// N/m.
    pub load: Vec<f64>,
}

impl FaceLoad {
    /// Face load factor K_Hbeta in the sense of ISO 6336-1: the largest load per face width over the mean. 0 without
    /// load.
    pub fn face_load_factor(&self) -> f64 {
        let mean = self.load.iter().sum::<f64>() / self.load.len() as f64;
        let largest = self.load.iter().copied().fold(0.0, f64::max);
        if mean > 0.0 { largest / mean } else { 0.0 }
    }
}

impl MeshCycle {
    /// Harmonics of the STE, m.
    pub fn harmonics(&self) -> [Option<Harmonic>; HARMONICS] {
        harmonics(&self.ste())
    }

    /// Tangent mesh stiffness dF_bt / d STE at each position, N/m in the transverse plane along the line of action.
    pub fn stiffness(&self) -> Vec<f64> {
        let results = self.results.iter();
        results.map(|r| r.tangent.force_by_approach).collect()
    }

    /// Tooth pairs that bear load anywhere in the cycle, ascending.
    pub fn tooth_pairs(&self) -> Vec<i32> {
        let shares = self.results.iter().flat_map(|r| &r.load_share);
        let mut pairs: Vec<i32> = shares.filter(|s| s.1 > 0.0).map(|s| s.0).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// Load along the face whose ends are `ends` (m in gear 1's frame), in `stations` equal pieces, those of the
    /// solver; `cos_base_helix` turns normal forces into those in the transverse plane.
    pub fn face_load(&self, ends: [f64; 2], stations: usize, cos_base_helix: f64) -> FaceLoad {
        let step = (ends[1] - ends[0]) / stations as f64;
        let mut load = vec![0.0; stations];
        let middle = |segment: &SegmentLoad| 0.5 * (segment.z[0] + segment.z[1]);
        for segment in self.loads.iter().flatten() {
            let station = (middle(segment) - ends[0]) / step;
            load[(station as usize).min(stations - 1)] += segment.force * cos_base_helix;
        }
        let per_width = step * self.loads.len() as f64;
        load.iter_mut().for_each(|load| *load /= per_width);
        FaceLoad {
            z: (0..stations)
                .map(|i| ends[0] + step * (i as f64 + 0.5))
                .collect(),
            load,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn harmonics_rebuild_what_they_were_made_of() {
        let wave =
            |tau: f64| 3.0 + 0.5 * (TAU * tau + 0.3).cos() + 0.2 * (TAU * 10.0 * tau - 2.0).cos();
        let values: Vec<f64> = (0..32).map(|i| wave(f64::from(i) / 32.0)).collect();
        let found = harmonics(&values);
        let [first, tenth] = [found[0].unwrap(), found[9].unwrap()];
        assert!((first.amplitude - 0.5).abs() < 1e-14 && (first.phase - 0.3).abs() < 1e-13);
        assert!((tenth.amplitude - 0.2).abs() < 1e-14 && (tenth.phase + 2.0).abs() < 1e-13);
        assert!(found[1..9].iter().all(|h| h.unwrap().amplitude < 1e-14));
    }

    #[test]
    fn harmonics_above_half_the_positions_are_not_told() {
        let found = harmonics(&[1.0, 2.0, 3.0, 2.0]);
        assert!(found[0].is_some() && found[1..].iter().all(Option::is_none));
    }

    #[test]
    fn an_even_load_has_the_factor_one_and_a_triangle_two() {
        let of = |load: Vec<f64>| FaceLoad { z: vec![], load }.face_load_factor();
        assert_eq!(of(vec![2.0; 5]), 1.0);
        assert!((of((0..=1000).map(f64::from).collect()) - 2.0).abs() < 1e-12);
        assert_eq!(of(vec![0.0; 5]), 0.0);
    }
}
