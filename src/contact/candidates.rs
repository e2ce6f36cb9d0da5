//! The strips that may touch at one position of the mesh.

use super::closest::{Flanks, LeastGap};
use super::four::Four;
use super::local::GapProfile;
use super::transverse::{TransversePoint, TransverseSection};
use crate::compliance::Strip;
use crate::f64x4::F64x4;
use crate::gear::teeth::{Counts, Passing};
use crate::gear::{Flank, Microgeometry, PairGeometry};
use crate::table::widest;

/// Points of a strip at which the local contact is evaluated apart, so that the edge of the contact crosses
/// a strip in small steps: at the middles of equal parts.
pub const POINTS: usize = 4;

/// A strip of one contact line that may carry load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Tooth pair, counted in the sense in which contact moves; 0 touches at the pitch point at mid-face
    /// at mesh position 0.
    pub tooth_pair: i32,
    /// Station along the face, from the lower end of the overlap of both faces.
    pub station: usize,
    /// Ends in gear 1's frame, m, ascending.
    pub z: [f64; 2],
    /// Length of roll on gear 1 and gear 2 at mid-strip, where the flanks come closest, m.
    pub roll: [f64; 2],
    /// Gaps along the line of action before load and misalignment at the points of the strip, ascending in z,
    /// m: microgeometry of both flanks and the separation off the path of contact; as local contact sees them, see
    /// [`super::ContactSettings::own_share`].
    pub gap: [f64; POINTS],
    /// What a misalignment closes of [`Candidate::gap`] over its size, at the points as local contact sees
    /// them, m, ascending; by the same levers the forces act on it.
    pub levers: [f64; POINTS],
    /// Relative radius of curvature of the involutes in the normal section, m.
    pub radius: f64,
    /// The gap about the closest point of mid-strip.
    pub(super) profile: GapProfile,
    /// Arms of the force about the axes of gear 1 and gear 2, in the transverse plane over their base radii; at
    /// mid-strip.
    pub arms: [f64; 2],
}

impl Candidate {
    /// What it is known by in all positions of the mesh.
    pub fn name(&self) -> (i32, usize) {
        (self.tooth_pair, self.station)
    }

    /// The gear, 0 or 1, whose tip edge is nearest.
    pub fn edge_gear(&self) -> usize {
        let [of_second, of_first] = self.profile.edges;
        usize::from(-of_second < of_first)
    }

    /// Middle of the strip in gear 1's frame, m.
    pub fn middle(&self) -> f64 {
        0.5 * (self.z[0] + self.z[1])
    }

    /// Length along the contact line, m, at the cosine of the base helix angle `cos_beta_b`.
    pub fn length(&self, cos_beta_b: f64) -> f64 {
        (self.z[1] - self.z[0]) / cos_beta_b
    }

    /// Points in gear 1's frame, m, ascending.
    pub fn points(&self) -> [f64; POINTS] {
        points(self.z)
    }
}

/// How fast a strip changes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StripRates {
    /// Rates of [`Candidate::gap`].
    pub gap: [f64; POINTS],
    /// Rate of the logarithm of the radius of curvature where the flanks come closest, removals included.
    pub log_radius: f64,
}

/// What changes along a strip by `values` at its points, as local contact sees it, which takes up `own_share` of the change.
pub(super) fn along_strip(values: [f64; POINTS], own_share: f64) -> [f64; POINTS] {
    if own_share == 1.0 {
        return values;
    }
    let mean = (values[0] + values[1] + values[2] + values[3]) * (1.0 / POINTS as f64);
    values.map(|value| mean + own_share * (value - mean))
}

fn points(z: [f64; 2]) -> [f64; POINTS] {
    std::array::from_fn(|q| z[0] + (z[1] - z[0]) * (q as f64 + 0.5) / POINTS as f64)
}

/// What does not change with the position of the mesh.
pub struct ContactLines<'a> {
    /// The pair.
    pub geometry: &'a PairGeometry,
    /// Modifications of both gears.
    pub microgeometry: &'a [Microgeometry; 2],
    /// Transverse section at the centre distance.
    pub section: &'a TransverseSection,
    /// Loaded flank of gear 1.
    pub flank: Flank,
    /// Number of equal stations over the overlap of both faces.
    pub stations: usize,
    /// See [`super::ContactSettings::own_share`].
    pub own_share: f64,
    /// Teeth that differ; `None`: all are alike.
    pub teeth: Option<TeethAt<'a>>,
}

/// Teeth that differ, and those that are in mesh.
#[derive(Debug, Clone, Copy)]
pub struct TeethAt<'a> {
    /// All of them.
    pub passing: &'a Passing,
    /// Mesh cycles counted.
    pub counts: Counts,
}

/// Flanks at one place of a contact line, and where they come closest.
pub(super) type Place<'a> = (Flanks<'a>, LeastGap);

/// What is known of the middle of a strip.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Middle {
    /// Where the flanks come closest.
    Known(LeastGap),
    /// Nothing.
    Sought,
    /// That it may lie beyond the reach of contact, where it is taken as if it lay at its end.
    Held,
}

/// Pieces shorter than this fraction of a station are left out where a path end cuts it: what they could
/// carry is below the rounding of the load.
const SHORTEST: f64 = 1e-9;

impl ContactLines<'_> {
    /// All candidates at the mesh position `tau`, tooth pair by tooth pair, ascending in z.
    pub fn candidates(&self, tau: f64) -> Vec<Candidate> {
        self.pairs(tau, 0.0)
            .flat_map(|k| self.of_pair(tau, k))
            .collect()
    }

    /// Those of tooth pair `k` alone.
    pub fn of_pair(&self, tau: f64, k: i32) -> impl Iterator<Item = Candidate> {
        (0..self.stations).filter_map(move |station| self.strip(tau, (k, station)))
    }

    /// Mesh positions between which tooth pair 0 comes within the reach of contact.
    pub fn passage(&self) -> [f64; 2] {
        let numbers = self.section.numbers();
        let tilt = 0.5 * numbers.face[1] * numbers.tan_beta_b;
        let [first, last] = self.section.reach();
        [first - tilt, last + tilt].map(|end| end / numbers.base_pitch)
    }

    /// Whether a strip is its whole station.
    pub fn is_whole(&self, strip: &Candidate) -> bool {
        strip.z == self.station(strip.station)
    }

    /// Tooth pairs that come within `margin` (m) of the reach of contact.
    pub(super) fn pairs(&self, tau: f64, margin: f64) -> std::ops::RangeInclusive<i32> {
        let numbers = self.section.numbers();
        let pitch = numbers.base_pitch;
        let tilt = 0.5 * numbers.face[1] * numbers.tan_beta_b + margin;
        let [first, last] = self.section.reach();
        ((first - tilt) / pitch - tau).floor() as i32..=((last + tilt) / pitch - tau).ceil() as i32
    }

    pub(super) fn contact_line(&self, tau: f64, k: i32, z: f64) -> f64 {
        self.section.numbers().contact_line(self.flank, tau, k, z)
    }

    /// Ends of a station, m.
    pub(super) fn station(&self, station: usize) -> [f64; 2] {
        let [low, width] = self.section.numbers().face;
        let step = width / self.stations as f64;
        [0, 1].map(|end| low + step * (station + end) as f64)
    }

    /// Middle of a station, m.
    pub(super) fn middle(&self, station: usize) -> f64 {
        let [low, high] = self.station(station);
        0.5 * (low + high)
    }

    /// Four places `z` (m) of tooth pair `k` at once, where [`Four`] holds them.
    #[inline]
    pub(super) fn four(&self, tau: f64, k: i32, z: F64x4) -> Option<Four> {
        let numbers = self.section.numbers();
        let [at_middle, next] =
            [0.0, 1.0].map(|z| numbers.contact_line(self.flank, tau, k, numbers.z_ref + z));
        let xi = (z - numbers.z_ref) * (next - at_middle) + at_middle;
        let microgeometry = self.microgeometry_of(k);
        widest(
            #[inline(always)]
            || Four::new(self.geometry, self.section, microgeometry, xi, z),
        )
    }

    /// The strip of this name at the mesh position `tau`, if it lies within the reach of contact.
    pub fn strip(&self, tau: f64, (k, station): (i32, usize)) -> Option<Candidate> {
        let z = self.carrying(tau, k, self.station(station))?;
        Some(self.candidate(tau, (k, station), z, Middle::Sought, None).0)
    }

    /// `strip` with the gap about the closest point at the part `at` of its length from its middle, at the mesh position `tau`.
    pub(super) fn along(&self, tau: f64, strip: &Candidate, at: f64) -> Candidate {
        let z = strip.middle() + at * (strip.z[1] - strip.z[0]);
        let (flanks, least) = self.place(tau, strip.tooth_pair, z, false);
        let profile = flanks.closest_point_at(&least).profile;
        Candidate { profile, ..*strip }
    }

    /// The part of the station `whole` in which tooth pair `k` lies within the reach of contact, if it is long enough to
    /// carry.
    pub(super) fn carrying(&self, tau: f64, k: i32, whole: [f64; 2]) -> Option<[f64; 2]> {
        let z = self.within_reach(tau, k, whole)?;
        (z[1] - z[0] > SHORTEST * (whole[1] - whole[0])).then_some(z)
    }

    /// Rates of the logarithm of the radius of curvature of `candidate`, whose middle is `middle`, while the lengths of roll
    /// change by each of `rolls`; `None` as in [`Flanks::rates`].
    fn radius_rates(
        &self,
        candidate: &Candidate,
        (flanks, least): &Place<'_>,
        rolls: [[f64; 2]; 2],
    ) -> Option<[f64; 2]> {
        let numbers = self.section.numbers();
        let rates = flanks.rates(least, rolls)?;
        Some(rates.map(|(_, moved, bend)| {
            let involutes = (0..2)
                .map(|i| numbers.kappa[i] * moved[i] / (candidate.roll[i] * candidate.roll[i]))
                .sum::<f64>()
                * numbers.cos_beta_b;
            (involutes - bend) / candidate.profile.curvature
        }))
    }

    /// Whole strips, those up to `margin` (m, along the path) beyond the reach of contact, too, as if they lay at its end.
    pub fn strips_beyond(&self, tau: f64, margin: f64) -> Vec<Candidate> {
        let [first, last] = self.section.reach();
        let mut all = vec![];
        for k in self.pairs(tau, margin) {
            for station in 0..self.stations {
                let z = self.station(station);
                let xi = z.map(|z| self.contact_line(tau, k, z));
                let (low, high) = (xi[0].min(xi[1]), xi[0].max(xi[1]));
                if high >= first - margin && low <= last + margin {
                    all.push(self.candidate(tau, (k, station), z, Middle::Held, None).0);
                }
            }
        }
        all
    }

    /// The part of `z` in which tooth pair `k` lies within the reach of contact.
    fn within_reach(&self, tau: f64, k: i32, z: [f64; 2]) -> Option<[f64; 2]> {
        let xi = z.map(|z| self.contact_line(tau, k, z));
        let [first, last] = self.section.reach();
        if xi.iter().all(|xi| first <= *xi && *xi <= last) {
            return Some(z);
        }
        let slope = xi[1] - xi[0];
        if slope.abs() <= 1e-12 * (last - first) {
            // A spur pair: the whole strip or nothing.
            let middle = 0.5 * (xi[0] + xi[1]);
            return (first <= middle && middle <= last).then_some(z);
        }
        // Fractions of the strip at which its line crosses the limits.
        let at = |limit: f64| (limit - xi[0]) / slope;
        let (a, b) = if slope > 0.0 {
            (at(first), at(last))
        } else {
            (at(last), at(first))
        };
        let (a, b) = (a.max(0.0), b.min(1.0));
        (a < b).then(|| [z[0] + a * (z[1] - z[0]), z[0] + b * (z[1] - z[0])])
    }

    /// The point that may touch of tooth pair `k` in the plane `z`; `held`: where it lies beyond the reach of contact, that at
    /// its end.
    fn point(&self, tau: f64, k: i32, z: f64, held: bool) -> TransversePoint {
        let [first, last] = self.section.reach();
        let mut xi = self.contact_line(tau, k, z);
        if held {
            xi = xi.clamp(first, last);
        }
        self.section.point(xi)
    }

    /// Both flanks of tooth pair `k` in the plane `z` about [`ContactLines::point`].
    fn flanks(&self, tau: f64, k: i32, z: f64, held: bool) -> Flanks<'_> {
        self.flanks_about(self.point(tau, k, z, held), k, z)
    }

    fn flanks_about(&self, point: TransversePoint, k: i32, z: f64) -> Flanks<'_> {
        let microgeometry = self.microgeometry_of(k);
        Flanks::new(self.geometry, self.section, microgeometry, point, z)
    }

    /// Modifications of the flanks of tooth pair `k`.
    fn microgeometry_of(&self, k: i32) -> [&Microgeometry; 2] {
        [0, 1].map(|i| {
            let own = self
                .teeth
                .and_then(|teeth| teeth.passing.own_flank(i, teeth.counts, k));
            own.unwrap_or(&self.microgeometry[i])
        })
    }

    /// What differing teeth close of the gaps of tooth pair `k`, m, and its rate, m per cycle.
    pub(super) fn closing(&self, tau: f64, k: i32) -> [f64; 2] {
        match self.teeth {
            Some(teeth) => teeth.passing.closing(teeth.counts, k, tau),
            None => [0.0; 2],
        }
    }

    pub(super) fn place(&self, tau: f64, k: i32, z: f64, held: bool) -> Place<'_> {
        let flanks = self.flanks(tau, k, z, held);
        (flanks, flanks.least_gap())
    }

    /// The strip of tooth pair `k` at `station` with the ends `z`, of whose middle `middle` is known, and how fast it changes
    /// with the lengths of roll by `rolls`, if that is asked for.
    pub(super) fn candidate(
        &self,
        tau: f64,
        (k, station): (i32, usize),
        z: [f64; 2],
        middle: Middle,
        rolls: Option<[[f64; 2]; 2]>,
    ) -> (Candidate, Option<[StripRates; 2]>) {
        let numbers = self.section.numbers();
        let held = middle == Middle::Held;
        let [closing, closing_rate] = self.closing(tau, k);
        let at = points(z);
        let four = if held {
            None
        } else {
            self.four(tau, k, F64x4(at))
        };
        let at_middle = 0.5 * (z[0] + z[1]);
        let about = self.point(tau, k, at_middle, held);
        let flanks = self.flanks_about(about, k, at_middle);
        let least = match middle {
            Middle::Known(least) => least,
            _ => flanks.least_gap(),
        };
        // Rates are those of the gaps with the lengths of roll.
        let (gaps, gap_rates) = match &four {
            Some(four) => (four.gap.0, rolls.map(|rolls| four.rates(rolls))),
            None => {
                // All points of a strip of a spur pair lie at one place of the path.
                let is_one = numbers.tan_beta_b == 0.0;
                let mut gaps = [0.0; POINTS];
                let mut rates = rolls.map(|_| [[0.0; POINTS]; 2]);
                for (q, z) in at.into_iter().enumerate() {
                    let flanks = match is_one {
                        true => self.flanks_about(about, k, z),
                        false => self.flanks(tau, k, z, held),
                    };
                    let least = flanks.least_gap();
                    gaps[q] = least.gap;
                    rates = rates
                        .zip(rolls)
                        .and_then(|([mut by_tau, mut by_center], rolls)| {
                            let [tau, center] = flanks.rates(&least, rolls)?;
                            (by_tau[q], by_center[q]) = (tau.0, center.0);
                            Some([by_tau, by_center])
                        });
                }
                (gaps, rates)
            }
        };
        let closest = flanks.closest_point_at(&least);
        let along = |values| along_strip(values, self.own_share);
        let gap = along(gaps).map(|gap| gap - closing);
        let cos_beta_b = numbers.cos_beta_b;
        // Curvatures in the normal section: kappa cos beta_b / rho_t, negative for a ring.
        let curvature: f64 = (0..2)
            .map(|i| numbers.kappa[i] * cos_beta_b / closest.roll[i])
            .sum();
        let candidate = Candidate {
            tooth_pair: k,
            station,
            z,
            roll: closest.roll,
            gap,
            levers: along(at.map(|z| numbers.lever(self.flank, tau, k, z))),
            radius: curvature.recip(),
            profile: closest.profile,
            arms: closest.arms,
        };
        let rates = gap_rates
            .zip(rolls)
            .and_then(|([by_tau, by_center], rolls)| {
                let by_tau = along(by_tau).map(|rate| rate - closing_rate);
                let gap = [by_tau, along(by_center)];
                let log_radius = self.radius_rates(&candidate, &(flanks, least), rolls)?;
                Some([0, 1].map(|axis| StripRates {
                    gap: gap[axis],
                    log_radius: log_radius[axis],
                }))
            });
        (candidate, rates)
    }

    /// The strip of tooth pair `k` with the ends `z` at the mesh position `tau` in the canonical coordinates of gear 1 and
    /// gear 2; `held` as it was made.
    pub fn seen_by_gears(&self, tau: f64, (k, z): (i32, [f64; 2]), held: bool) -> [Strip; 2] {
        let ends = z.map(|z| self.flanks(tau, k, z, held).closest_point());
        [0, 1].map(|i| self.canonical(i, k, z, [ends[0].roll[i], ends[1].roll[i]]))
    }

    /// See [`PairGeometry::is_mirrored`].
    pub fn is_mirrored(&self, i: usize) -> bool {
        self.geometry.is_mirrored(self.flank, i)
    }

    /// The strip as gear `i` sees it once it is mirrored so. Tooth pair k lies k pitches ahead in the sense of
    /// rotation: tooth s k on gear 1 and -e s k on gear 2, after the mirror k and -k.
    fn canonical(&self, i: usize, k: i32, z: [f64; 2], roll: [f64; 2]) -> Strip {
        let gear = &self.geometry.gears[i];
        let tooth = if i == 0 { k } else { -k };
        let own = z.map(|z| (z - gear.face_offset).clamp(0.0, gear.face_width));
        if self.is_mirrored(i) {
            let b = gear.face_width;
            Strip {
                tooth,
                z: [b - own[1], b - own[0]],
                roll: [roll[1], roll[0]],
            }
        } else {
            Strip {
                tooth,
                z: own,
                roll,
            }
        }
    }
}
