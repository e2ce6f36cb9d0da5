//! Teeth that differ from each other: index errors, run-out, and single teeth with a flank or a compliance of their own.
//!
//! Teeth are counted from 0 in +theta of their own gear (body frame). Tooth 0 of gear 1 is that at body +x (of a ring, whose
//! space is there, the one before it) in the phase reference `absolute`, else that which touches at the start; tooth 0 of gear 2
//! is that which touches the drive flank of gear 1's tooth 0 (with gears that start elsewhere on the circle: that would, were gear 2
//! turned with its body +x towards gear 1). Errors are positive where
//! the flank stands further out, towards its mate: they close the gap along the line of action.

use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

use super::{BothFlanks, Flank, GearKind, Microgeometry, PairGeometry};

/// Eccentricity of the teeth of a gear against its axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Runout {
    /// Radial run-out F_r, highest reading less lowest, m: twice the eccentricity.
    pub amount: f64,
    /// Body angle from the centre of tooth 0 in +theta to where the teeth stand out most, rad.
    pub angle: f64,
}

/// A tooth with a flank of its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OwnFlank {
    /// Number of the tooth.
    pub tooth: u32,
    /// All its modifications.
    pub microgeometry: Microgeometry,
}

/// A tooth with a compliance of its own.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WeakTooth {
    /// Number of the tooth.
    pub tooth: u32,
    /// Compliance of this tooth under loads on itself over that of the others, >= 1: bending, shear and tilt in
    /// the body, all that the local contact does not hold.
    pub factor: f64,
}

/// What distinguishes the teeth of one gear on one flank.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ToothErrors {
    /// Index error (cumulative pitch deviation) of every tooth along the line of action, m; empty: none.
    pub index: Vec<f64>,
    /// Run-out.
    pub runout: Option<Runout>,
    /// Flanks of their own.
    pub flanks: Vec<OwnFlank>,
    /// Weak teeth.
    pub weak: Vec<WeakTooth>,
}

impl ToothErrors {
    /// Least and largest index error, m; infinite, the wrong way round, where there is none.
    fn index_range(&self) -> [f64; 2] {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        (self.index.iter()).fold(none, |[a, b], x| [a.min(*x), b.max(*x)])
    }

    fn runout_amount(&self) -> f64 {
        self.runout.map_or(0.0, |runout| runout.amount)
    }
}

/// Tooth errors of both gears on both flanks. The default: all teeth are alike.
pub type PairTeeth = BothFlanks<ToothErrors>;

impl PairTeeth {
    /// Whether all teeth are alike.
    pub fn are_alike(&self) -> bool {
        *self == PairTeeth::default()
    }

    /// Bound of how far apart two tooth pairs can be in what errors of both gears close, on either flank, m.
    pub fn spread(&self) -> f64 {
        self.larger_of_flanks(|gear| {
            let [least, largest] = gear.index_range();
            (largest - least).max(0.0) + gear.runout_amount()
        })
    }

    /// Bound of what errors of both gears close together on either flank, m.
    pub fn largest_closing(&self) -> f64 {
        self.larger_of_flanks(|gear| gear.index_range()[1].max(0.0) + 0.5 * gear.runout_amount())
    }

    /// Sum of `bound` over both gears, on the flank where it is larger.
    fn larger_of_flanks(&self, bound: fn(&ToothErrors) -> f64) -> f64 {
        let both = |[a, b]: &[ToothErrors; 2]| bound(a) + bound(b);
        both(&self.drive).max(both(&self.coast))
    }
}

/// Which teeth are in mesh: pair k at the mesh position tau is the k-th ahead of that which touched at the pitch point when
/// as many mesh cycles were counted as stand here for each gear.
pub type Counts = [i64; 2];

/// The teeth of one flank, as they pass.
#[derive(Debug, Clone, PartialEq)]
pub struct Passing([PassingGear; 2]);

#[derive(Debug, Clone, PartialEq)]
struct PassingGear {
    errors: ToothErrors,
    teeth: f64,
    kappa: f64,
    /// Sense of tooth numbers over tooth pairs.
    sense: f64,
    /// Number of the tooth of tooth pair 0 at count 0.
    first: f64,
    /// +1 where the flank faces +theta.
    facing: f64,
    /// Operating pressure angle at the nominal centre distance, rad.
    pressure_angle: f64,
}

/// The teeth of both gears that touch at the pitch point at mesh position 0 when no mesh cycle was counted: on the drive flank tooth 0 of
/// both. On the coast flank external teeth meet the next one of gear 2, those of a pinion in a ring the one before. A ring as gear
/// 1 counts from a space, whose other side is the next tooth.
pub fn first_teeth(geometry: &PairGeometry, flank: Flank) -> [i32; 2] {
    let kinds = geometry.gears.each_ref().map(|gear| gear.kind);
    match (flank, kinds) {
        (Flank::Drive, _) => [0, 0],
        (Flank::Coast, [GearKind::Ring, _]) => [1, 0],
        (Flank::Coast, [_, GearKind::Ring]) => [0, -1],
        (Flank::Coast, _) => [0, 1],
    }
}

impl PassingGear {
    /// Number of its tooth in the tooth pair `k`.
    fn tooth(&self, count: i64, k: i32) -> usize {
        let pair = (i64::from(k) - count) as f64;
        (self.sense * pair + self.first).rem_euclid(self.teeth) as usize
    }

    /// What its run-out closes, m, and its rate, m per cycle.
    fn eccentric(&self, runout: Runout, count: i64, tau: f64) -> [f64; 2] {
        // Number of the flank at the pitch point, with its fraction, then its body angle; teeth are as wide as spaces.
        let per_tooth = TAU / self.teeth;
        let flank = self.first - self.sense * (tau + count as f64);
        let at = (flank + 0.25 * self.facing) * per_tooth;
        // The flank's normal: ahead, and outwards by the pressure angle (ring: inwards).
        let (sin, cos) = (runout.angle - at).sin_cos();
        let (out, ahead) = self.pressure_angle.sin_cos();
        let (out, ahead) = (self.kappa * out, self.facing * ahead);
        let eccentricity = 0.5 * runout.amount;
        // The angle changes by sense * per_tooth per cycle.
        [
            eccentricity * (out * cos + ahead * sin),
            eccentricity * self.sense * per_tooth * (ahead * cos - out * sin),
        ]
    }
}

impl Passing {
    /// Those of `flank` of a pair; `None` where all its teeth are alike.
    pub fn new(geometry: &PairGeometry, teeth: &PairTeeth, flank: Flank) -> Option<Passing> {
        let errors = teeth.flank(flank);
        if errors.iter().all(|e| *e == ToothErrors::default()) {
            return None;
        }
        let (s, e, gears) = (flank.sign(), geometry.e(), &geometry.gears);
        let first = first_teeth(geometry, flank);
        let gear = |i: usize, sense: f64, facing: f64| PassingGear {
            errors: errors[i].clone(),
            teeth: gears[i].z(),
            kappa: gears[i].kappa(),
            sense,
            first: f64::from(first[i]),
            facing,
            pressure_angle: geometry.operating_pressure_angle(geometry.center_distance),
        };
        Some(Passing([gear(0, s, s), gear(1, -e * s, e * s)]))
    }

    /// What the errors of both gears close of the gaps of tooth pair `k` at the mesh position `tau`, along the line of action,
    /// m, and its rate, m per cycle.
    pub fn closing(&self, counts: Counts, k: i32, tau: f64) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for (gear, count) in self.0.iter().zip(counts) {
            if !gear.errors.index.is_empty() {
                sum[0] += gear.errors.index[gear.tooth(count, k)];
            }
            if let Some(runout) = gear.errors.runout {
                let [value, rate] = gear.eccentric(runout, count, tau);
                sum[0] += value;
                sum[1] += rate;
            }
        }
        sum
    }

    /// Second derivative by the mesh position of what the errors of both gears close, m; for all tooth pairs in mesh the same.
    pub fn closing_curvature(&self, counts: Counts, tau: f64) -> f64 {
        let curvature = |i: usize| {
            let per_tooth = TAU / self.0[i].teeth;
            let value = |runout| self.0[i].eccentric(runout, counts[i], tau)[0];
            -per_tooth * per_tooth * self.0[i].errors.runout.map_or(0.0, value)
        };
        curvature(0) + curvature(1)
    }

    /// The modifications of the flank of gear `i` in the tooth pair `k`, where they are its own.
    pub fn own_flank(&self, i: usize, counts: Counts, k: i32) -> Option<&Microgeometry> {
        let tooth = self.0[i].tooth(counts[i], k);
        let mut flanks = self.0[i].errors.flanks.iter();
        let own = flanks.find(|own| own.tooth as usize == tooth);
        own.map(|own| &own.microgeometry)
    }

    /// Compliance of the tooth pair `k` under its own load over that of others; `shares` are those of both gears.
    pub fn compliance(&self, shares: [f64; 2], counts: Counts, k: i32) -> f64 {
        let more = |i: usize| {
            let tooth = self.0[i].tooth(counts[i], k);
            let mut weak = self.0[i].errors.weak.iter();
            let own = weak.find(|weak| weak.tooth as usize == tooth);
            own.map_or(0.0, |weak| shares[i] * (weak.factor - 1.0))
        };
        1.0 + more(0) + more(1)
    }
}

#[cfg(test)]
mod tests {
    use super::super::GearKind::{External, Ring};
    use super::super::samples;
    use super::*;

    fn pair(internal: bool) -> PairGeometry {
        let mate = if internal { (Ring, 50) } else { (External, 30) };
        let gears = [(External, 20), mate].map(|(kind, z)| samples::gear(kind, z, 1.0, 0.0, 0.0));
        let [r1, r2] = [0, 1].map(|i| gears[i].reference_radius());
        PairGeometry {
            center_distance: if internal { r2 - r1 } else { r1 + r2 },
            gears,
        }
    }

    fn numbered(n: u32) -> ToothErrors {
        ToothErrors {
            index: (0..n).map(f64::from).collect(),
            ..ToothErrors::default()
        }
    }

    #[test]
    fn a_tooth_pair_keeps_its_teeth_while_it_passes_and_all_come_round() {
        for internal in [false, true] {
            let geometry = pair(internal);
            let z2 = geometry.gears[1].teeth;
            for flank in [Flank::Drive, Flank::Coast] {
                for (i, z) in [(0, 20), (1, z2)] {
                    let mut errors = PairTeeth::default();
                    let both = match flank {
                        Flank::Drive => &mut errors.drive,
                        Flank::Coast => &mut errors.coast,
                    };
                    both[i] = numbered(z);
                    let passing = Passing::new(&geometry, &errors, flank).unwrap();
                    // One cycle later pair k has become pair k + 1.
                    for k in -3..3 {
                        let now = passing.closing([7, 7], k, 0.2)[0];
                        assert_eq!(now, passing.closing([8, 8], k + 1, 0.2)[0]);
                        let round = [7 + 20, 7 + i64::from(z2)];
                        assert_eq!(now, passing.closing(round, k, 0.2)[0]);
                    }
                    let mut met: Vec<f64> = (0..i64::from(z))
                        .map(|n| passing.closing([n, n], 0, 0.2)[0])
                        .collect();
                    met.sort_by(f64::total_cmp);
                    assert_eq!(met, numbered(z).index);
                }
            }
        }
    }

    #[test]
    fn run_out_is_the_displaced_gear_seen_along_the_line_of_action() {
        // The body turned so that the flank of tooth 0 is at the pitch point; there its normal lies along the line of action.
        for internal in [false, true] {
            let geometry = pair(internal);
            for flank in [Flank::Drive, Flank::Coast] {
                let mut errors = PairTeeth::default();
                for gears in [&mut errors.drive, &mut errors.coast] {
                    gears[0].runout = Some(Runout {
                        amount: 20e-6,
                        angle: 0.3,
                    });
                }
                let passing = Passing::new(&geometry, &errors, flank).unwrap();
                let alpha = geometry.operating_pressure_angle(geometry.center_distance);
                for tau in [0.0, 0.4, 0.9] {
                    // Gear 1 has turned on by s tau pitches: the eccentricity in fixed axes, the pitch point on +x.
                    let s = flank.sign();
                    let pitch = TAU / 20.0;
                    let turned = s * (tau + 3.0) * pitch - s * 0.25 * pitch + 0.3;
                    let shift = [10e-6 * turned.cos(), 10e-6 * turned.sin()];
                    let normal = [alpha.sin(), s * alpha.cos()];
                    let expected = shift[0] * normal[0] + shift[1] * normal[1];
                    let [found, rate] = passing.closing([3, 3], 1, tau);
                    assert!((found - expected).abs() < 1e-18, "{found} {expected}");
                    let [next, _] = passing.closing([3, 3], 1, tau + 1e-6);
                    assert!(((next - found) / 1e-6 - rate).abs() < 1e-5 * 10e-6);
                }
            }
        }
    }
}
