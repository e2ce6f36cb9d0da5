//! The segments of contact lines that may touch at one position of the mesh.

use super::gap::GapProfile;
use super::local_law::POINTS;
use super::segment::Segment;
use super::setup::ContactSetup;
use super::transverse::{MatingFlanks, TransverseSection};
use crate::gear::teeth::{Counts, Passing};
use crate::gear::{Flank, Microgeometry};

/// A segment of one contact line that may carry load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Tooth pair, counted in the sense in which contact moves; 0 touches at the pitch point at mid-face at mesh position 0.
    pub tooth_pair: i32,
    /// Station along the face, from the lower end of the overlap of both faces.
    pub station: usize,
    /// Ends in gear 1's frame, m, ascending.
    pub z: [f64; 2],
    /// Length of roll on gear 1 and gear 2 at the middle, where the flanks come closest, m.
    pub roll: [f64; 2],
    /// Gaps along the line of action before load and misalignment at the points of the segment, ascending in z, m: modifications
    /// and the separation off the path of contact; as local contact sees them, see [`super::ContactSettings::own_share`].
    pub gap: [f64; POINTS],
    /// What a misalignment closes of [`Candidate::gap`] over its size, m; by the same levers the forces act on it.
    pub levers: [f64; POINTS],
    /// The gap about the closest point of the middle.
    pub profile: GapProfile,
    /// Arms of the force at the middle about the axes of gear 1 and gear 2, in the transverse plane over their base radii.
    pub arms: [f64; 2],
}

impl Candidate {
    /// Middle in gear 1's frame, m.
    pub fn middle(&self) -> f64 {
        0.5 * (self.z[0] + self.z[1])
    }

    /// Points in gear 1's frame, m, ascending.
    pub fn points(&self) -> [f64; POINTS] {
        points(self.z)
    }

    /// Arm of the force about the axes of both gears over their base radii, in the mean: by virtual work what the flanks close per approach
    /// on the line of action, half of which either gear turns.
    pub fn arm(&self) -> f64 {
        0.5 * (self.arms[0] + self.arms[1])
    }

    /// Length along the contact line, m, at the cosine of the base helix angle `cos_beta_b`.
    pub fn length(&self, cos_beta_b: f64) -> f64 {
        (self.z[1] - self.z[0]) / cos_beta_b
    }
}

/// What changes along a segment by `values` at its points, as local contact sees it, which takes up `own_share` of the change.
pub fn along_segment(values: [f64; POINTS], own_share: f64) -> [f64; POINTS] {
    if own_share == 1.0 {
        return values;
    }
    let mean = (values[0] + values[1] + values[2] + values[3]) * (1.0 / POINTS as f64);
    values.map(|value| mean + own_share * (value - mean))
}

fn points(z: [f64; 2]) -> [f64; POINTS] {
    std::array::from_fn(|q| z[0] + (z[1] - z[0]) * (q as f64 + 0.5) / POINTS as f64)
}

/// The contact lines of one flank at one position of the mesh.
#[derive(Clone)]
pub struct ContactLines<'a> {
    /// The pair.
    pub setup: &'a ContactSetup,
    /// Deviation from the nominal centre distance, m.
    pub center_distance_offset: f64,
    /// The transverse section at that centre distance.
    pub section: TransverseSection,
    /// Loaded flank of gear 1.
    pub flank: Flank,
    /// Mesh position, base pitches.
    pub tau: f64,
    /// Teeth that differ, and the mesh cycles counted; `None`: all are alike.
    pub teeth: Option<(&'a Passing, Counts)>,
    /// Whether segments beyond the extended path are taken as if they lay at its end.
    pub clamped: bool,
}

/// Pieces shorter than this part of a station are left out where a path end cuts it.
const SHORTEST: f64 = 1e-9;

impl ContactLines<'_> {
    /// The same, with segments beyond the extended path taken as if they lay at its end.
    #[must_use]
    pub fn clamped(mut self) -> Self {
        self.clamped = true;
        self
    }

    /// All segments that may touch.
    pub fn candidates(&self) -> Vec<Candidate> {
        let pairs = self.pairs(0.0);
        pairs.flat_map(|k| self.of_pair(k)).collect()
    }

    /// Those of tooth pair `k`.
    pub fn of_pair(&self, k: i32) -> impl Iterator<Item = Candidate> {
        let stations = 0..self.setup.settings.stations;
        stations.filter_map(move |station| self.segment(k, station))
    }

    /// Tooth pairs that come within `margin` (m) of the extended path.
    fn pairs(&self, margin: f64) -> std::ops::RangeInclusive<i32> {
        let margin = margin / self.section.numbers.base_pitch;
        let [first, last] = self.section.passage();
        (first - margin - self.tau).floor() as i32..=(last + margin - self.tau).ceil() as i32
    }

    /// Distance from the pitch point on the line of action at which tooth pair `k` touches in the plane `z` (m), m, its conjugate
    /// position: (tau + k) p_bt + sigma (z - z_ref). On gear 1 a larger z lies ahead in +theta for a right-handed helix, so
    /// there contact has moved on.
    pub fn contact_line(&self, k: i32, z: f64) -> f64 {
        let numbers = &self.section.numbers;
        (self.tau + f64::from(k)) * numbers.base_pitch + self.lean() * (z - numbers.z_ref)
    }

    /// sigma = s h tan beta_b: slope dy/dz of the contact lines in the plane of action.
    pub fn lean(&self) -> f64 {
        let numbers = &self.section.numbers;
        self.flank.sign() * numbers.hand * numbers.tan_beta_b
    }

    /// Ends of a station, m in gear 1's frame.
    pub fn station(&self, station: usize) -> [f64; 2] {
        let [low, width] = self.section.numbers.face;
        let step = width / self.setup.settings.stations as f64;
        [0, 1].map(|end| low + step * (station + end) as f64)
    }

    /// The segment of tooth pair `k` at `station`, if enough of it lies on the extended path to carry.
    pub fn segment(&self, k: i32, station: usize) -> Option<Candidate> {
        let whole = self.station(station);
        let z = self.on_extended_path(k, whole)?;
        let is_long = z[1] - z[0] > SHORTEST * (whole[1] - whole[0]);
        is_long.then(|| self.candidate(k, station, z))
    }

    /// The gap about the closest point of `segment` at the part `at` of its length from its middle.
    pub fn profile_along(&self, segment: &Candidate, at: f64) -> GapProfile {
        let z = segment.middle() + at * (segment.z[1] - segment.z[0]);
        let flanks = self.flanks(segment.tooth_pair, z);
        flanks.profile(flanks.closest().s)
    }

    /// Whole segments of [`ContactLines::clamped`] lines, also those up to `margin` (m) beyond the extended path.
    pub fn segments_beyond(&self, margin: f64) -> Vec<Candidate> {
        let [first, last] = self.section.extended_path;
        let segment = |k: i32, station: usize| {
            let z = self.station(station);
            let [a, b] = z.map(|z| self.contact_line(k, z));
            let is_near = a.max(b) >= first - margin && a.min(b) <= last + margin;
            is_near.then(|| self.candidate(k, station, z))
        };
        let stations = 0..self.setup.settings.stations;
        let of_pair = |k| (stations.clone()).filter_map(move |station| segment(k, station));
        self.pairs(margin).flat_map(of_pair).collect()
    }

    /// The part of `z` in which tooth pair `k` lies on the extended path.
    fn on_extended_path(&self, k: i32, z: [f64; 2]) -> Option<[f64; 2]> {
        let xi = z.map(|z| self.contact_line(k, z));
        let [first, last] = self.section.extended_path;
        if xi.iter().all(|xi| first <= *xi && *xi <= last) {
            return Some(z);
        }
        let slope = xi[1] - xi[0];
        if slope.abs() <= 1e-12 * (last - first) {
            let middle = 0.5 * (xi[0] + xi[1]);
            return (first <= middle && middle <= last).then_some(z);
        }
        let [a, b] = [first, last].map(|limit| (limit - xi[0]) / slope);
        let (a, b) = (a.min(b).max(0.0), a.max(b).min(1.0));
        (a < b).then(|| [a, b].map(|part| z[0] + part * (z[1] - z[0])))
    }

    fn microgeometry(&self, k: i32) -> [&Microgeometry; 2] {
        [0, 1].map(|i| {
            let own = (self.teeth).and_then(|(passing, counts)| passing.own_flank(i, counts, k));
            own.unwrap_or(&self.setup.microgeometry.flank(self.flank)[i])
        })
    }

    /// Both flanks of tooth pair `k` about the point that may touch in the plane `z`.
    fn flanks(&self, k: i32, z: f64) -> MatingFlanks<'_> {
        let mut xi = self.contact_line(k, z);
        if self.clamped {
            let [first, last] = self.section.extended_path;
            xi = xi.clamp(first, last);
        }
        let (point, microgeometry) = (self.section.point(xi), self.microgeometry(k));
        MatingFlanks::new(&self.setup.geometry, &self.section, microgeometry, point, z)
    }

    /// The segment of tooth pair `k` at `station` with the ends `z`.
    fn candidate(&self, k: i32, station: usize, z: [f64; 2]) -> Candidate {
        let numbers = &self.section.numbers;
        let teeth_close = (self.teeth).map_or(0.0, |(passing, counts)| {
            passing.closing(counts, k, self.tau)[0]
        });
        let both = self.microgeometry(k);
        let middle = self.flanks(k, 0.5 * (z[0] + z[1]));
        let closest = middle.closest();
        let is_even = numbers.tan_beta_b == 0.0 && !both.iter().any(|m| m.varies_along_face());
        let points = points(z);
        let gap = points.map(|z| {
            let least = match is_even {
                true => closest,
                false => self.flanks(k, z).closest(),
            };
            let lead = |i: usize| {
                let own_z = z - numbers.face_offset[i];
                both[i].lead(&self.setup.geometry.gears[i], own_z)
            };
            least.gap + (lead(0) + lead(1)) / numbers.cos_beta_b
        });
        // A tilt turns the generators of the flanks, too: (z - z_ref) + sigma y.
        let levers = points.map(|z| (z - numbers.z_ref) + self.lean() * self.contact_line(k, z));
        let own_share = self.setup.settings.own_share;
        Candidate {
            tooth_pair: k,
            station,
            z,
            roll: middle.rolls(closest.s),
            gap: along_segment(gap, own_share).map(|gap| gap - teeth_close),
            levers: along_segment(levers, own_share),
            profile: middle.profile(closest.s),
            arms: middle.at.arms,
        }
    }

    /// The segment of tooth pair `k` with the ends `z` in the canonical coordinates of gear 1 and gear 2.
    ///
    /// Tooth pair k lies k pitches ahead in the sense of rotation: tooth s k on gear 1 and -e s k on gear 2, after the mirror k
    /// and -k.
    pub fn seen_by_gears(&self, k: i32, z: [f64; 2]) -> [Segment; 2] {
        let ends = z.map(|z| {
            let flanks = self.flanks(k, z);
            flanks.rolls(flanks.closest().s)
        });
        [0, 1].map(|i| self.seen_by_gear(i, k, z, ends.map(|end| end[i])))
    }

    /// The same for gear `i`, with the lengths of roll `roll` (m) at the ends.
    pub fn seen_by_gear(&self, i: usize, k: i32, z: [f64; 2], mut roll: [f64; 2]) -> Segment {
        let gear = &self.setup.geometry.gears[i];
        let b = gear.face_width;
        let mut z = z.map(|z| (z - gear.face_offset).clamp(0.0, b));
        if self.setup.geometry.is_mirrored(self.flank, i) {
            (z, roll) = ([b - z[1], b - z[0]], [roll[1], roll[0]]);
        }
        let tooth = [k, -k][i];
        Segment { tooth, z, roll }
    }

    /// How far contact may move along the profile from `segment` towards the tip of gear 2 (<= 0) and of gear 1 (>= 0), m: to the tip edges
    /// and to the starts of the involutes.
    pub fn room(&self, segment: &Candidate) -> [f64; 2] {
        let (numbers, profile) = (&self.section.numbers, &segment.profile);
        let to_form = |i: usize| {
            let (roll, form) = (segment.roll[i], self.section.form_rolls[i]);
            let above = numbers.kappa[i] * (roll - form) * (roll + form);
            (above / (2.0 * numbers.base_radius[i])).max(0.0)
        };
        [
            profile.edges[0].max(-to_form(0)),
            profile.edges[1].min(to_form(1)),
        ]
    }

    /// `segments` as gear 1 and gear 2 see them.
    pub fn all_seen_by_gears(&self, segments: &[Candidate]) -> Vec<[Segment; 2]> {
        let seen = |s: &Candidate| self.seen_by_gears(s.tooth_pair, s.z);
        segments.iter().map(seen).collect()
    }
}
