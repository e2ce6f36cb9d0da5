//! The strips that may touch at one position of the mesh.

use super::closest::Flanks;
use super::local::GapProfile;
use super::transverse::TransverseSection;
use crate::compliance::Strip;
use crate::gear::teeth::{Counts, Passing};
use crate::gear::{Flank, Microgeometry, PairGeometry};

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

/// Pieces shorter than this fraction of a station are left out where a path end cuts it: what they could
/// carry is below the rounding of the load.
const SHORTEST: f64 = 1e-9;

impl ContactLines<'_> {
    /// All candidates at the mesh position `tau` whose contact lines lie at least in part within the conjugate positions
    /// `within` (m), tooth pair by tooth pair, ascending in z.
    pub fn candidates(&self, tau: f64, within: [f64; 2]) -> Vec<Candidate> {
        let names = self
            .pairs(tau, 0.0)
            .flat_map(|k| (0..self.stations).map(move |i| (k, i)));
        let near = names.filter(|(k, station)| {
            let xi = self
                .station(*station)
                .map(|z| self.contact_line(tau, *k, z));
            xi[0].max(xi[1]) >= within[0] && xi[0].min(xi[1]) <= within[1]
        });
        near.filter_map(|name| self.strip(tau, name)).collect()
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

    /// The strip of this name at the mesh position `tau`, if enough of it lies within the reach of contact to carry.
    pub fn strip(&self, tau: f64, name: (i32, usize)) -> Option<Candidate> {
        let whole = self.station(name.1);
        let z = self.within_reach(tau, name.0, whole)?;
        let is_long = z[1] - z[0] > SHORTEST * (whole[1] - whole[0]);
        is_long.then(|| self.candidate(tau, name, z, false))
    }

    /// The gap about the closest point of `strip` at the part `at` of its length from its middle, at the mesh position `tau`.
    pub(super) fn profile_along(&self, tau: f64, strip: &Candidate, at: f64) -> GapProfile {
        let z = strip.middle() + at * (strip.z[1] - strip.z[0]);
        self.flanks(tau, strip.tooth_pair, z, false)
            .closest_point()
            .profile
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
                    all.push(self.candidate(tau, (k, station), z, true));
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

    /// Both flanks of tooth pair `k` in the plane `z` about the point that may touch there; `clamped`: beyond the reach of
    /// contact about that at its end.
    fn flanks(&self, tau: f64, k: i32, z: f64, clamped: bool) -> Flanks<'_> {
        let mut xi = self.contact_line(tau, k, z);
        if clamped {
            let [first, last] = self.section.reach();
            xi = xi.clamp(first, last);
        }
        let microgeometry = [0, 1].map(|i| {
            let own = (self.teeth).and_then(|teeth| teeth.passing.own_flank(i, teeth.counts, k));
            own.unwrap_or(&self.microgeometry[i])
        });
        let point = self.section.point(xi);
        Flanks::new(self.geometry, self.section, microgeometry, point, z)
    }

    /// The strip of tooth pair `k` at `station` with the ends `z`; `clamped` as in [`ContactLines::flanks`].
    fn candidate(
        &self,
        tau: f64,
        (k, station): (i32, usize),
        z: [f64; 2],
        clamped: bool,
    ) -> Candidate {
        let numbers = self.section.numbers();
        let teeth_close = match self.teeth {
            Some(teeth) => teeth.passing.closing(teeth.counts, k, tau)[0],
            None => 0.0,
        };
        let points = points(z);
        let gap = points.map(|z| self.flanks(tau, k, z, clamped).least_gap().gap);
        let middle = self
            .flanks(tau, k, 0.5 * (z[0] + z[1]), clamped)
            .closest_point();
        // Curvatures in the normal section: kappa cos beta_b / rho_t, negative for a ring.
        let curvature: f64 = (0..2)
            .map(|i| numbers.kappa[i] * numbers.cos_beta_b / middle.roll[i])
            .sum();
        Candidate {
            tooth_pair: k,
            station,
            z,
            roll: middle.roll,
            gap: along_strip(gap, self.own_share).map(|gap| gap - teeth_close),
            levers: along_strip(
                points.map(|z| numbers.lever(self.flank, tau, k, z)),
                self.own_share,
            ),
            radius: curvature.recip(),
            profile: middle.profile,
            arms: middle.arms,
        }
    }

    /// The strip of tooth pair `k` with the ends `z` at the mesh position `tau` in the canonical coordinates of gear 1 and
    /// gear 2; `clamped` as in [`ContactLines::flanks`].
    pub fn seen_by_gears(&self, tau: f64, (k, z): (i32, [f64; 2]), clamped: bool) -> [Strip; 2] {
        let ends = z.map(|z| self.flanks(tau, k, z, clamped).closest_point());
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
