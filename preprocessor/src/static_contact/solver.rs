//! The contact of one pair: the problem of every position of the mesh.

use std::sync::Arc;

use super::deflection::Deflection;
use super::error::ContactError;
use super::influence::influence;
use super::position::{ContactResult, PositionProblem};
use super::settings::estimated_approach;
use crate::compliance::{BeyondModel, ToothCompliance};
use crate::gear::{Pair, ToothProfile};
use gearmesh::contact::{
    Candidate, CondensedFlank, CondensedNode, ContactLines, ContactProblem, ContactSettings,
    ContactSetup, Influence, Segment, along_segment, finite,
};
use gearmesh::friction::{FrictionLaw, Sliding, SlidingSums};
use gearmesh::gear::{Flank, PairGeometry, PairNumbers, PairTeeth, first_teeth};
use nalgebra::DMatrix;

/// Stations at most of contact at run time (docs/theory/contact.md). Loads need no more, the pressure along the face does.
const RUN_TIME_STATIONS: usize = 22;

/// Share of the change of a gap along a segment that local contact takes up at run time: a smaller share makes force and
/// moment more exact, a larger one the stiffness.
const OWN_SHARE_AT_RUN_TIME: f64 = 0.45;

/// Static contact of one pair of gears.
///
/// Clones share nothing mutable; one solver serves all threads.
#[derive(Clone)]
pub struct ContactSolver {
    pub(super) setup: ContactSetup,
    numbers: PairNumbers,
    compliance: [Arc<dyn ToothCompliance>; 2],
    deflection: Deflection,
    is_mirrored: bool,
}

impl ContactSolver {
    /// A solver for `pair` on the elastic models of gear 1 and gear 2.
    ///
    /// # Errors
    /// [`Input`](gearmesh::contact::ContactError::Input) for no stations or a followed approach that is not positive,
    /// [`ContactError::Profile`] for a gear without a usable tooth.
    pub fn new(
        pair: &Pair,
        compliance: [Arc<dyn ToothCompliance>; 2],
        settings: ContactSettings,
    ) -> Result<ContactSolver, ContactError> {
        if settings.stations == 0 {
            return Err(ContactError::input("stations", 0.0, "give at least 1"));
        }
        let mut form_rolls = [0.0; 2];
        for (roll, gear) in form_rolls.iter_mut().zip(&pair.geometry.gears) {
            // The tip edge of the mate stays off the base circle, where the involute has its cusp.
            let form_roll = ToothProfile::new(gear)?.usable_roll();
            *roll = form_roll.max(1e-3 * gear.base_radius());
        }
        let followed_approach =
            (settings.followed_approach).unwrap_or_else(|| estimated_approach(pair, form_rolls));
        if !(followed_approach.is_finite() && followed_approach > 0.0) {
            let remedy = "give a positive length in m";
            return Err(ContactError::input(
                "followed_approach",
                followed_approach,
                remedy,
            ));
        }
        let corner_resolution = compliance.each_ref().map(|gear| gear.corner_resolution());
        let solver = ContactSolver {
            numbers: PairNumbers::new(&pair.geometry),
            setup: ContactSetup {
                geometry: pair.geometry.clone(),
                microgeometry: pair.microgeometry.clone(),
                teeth: PairTeeth::default(),
                settings,
                followed_approach,
                // The local law then holds up to 2.25 times the line load that was estimated.
                reference_length: pair.largest_half_width(),
                corner_resolution,
                form_rolls,
                friction: Some(pair.friction),
                bodies: None,
            },
            compliance,
            deflection: Deflection::default(),
            is_mirrored: pair.is_mirrored_at_mid_face(),
        };
        let solver = match settings.followed_approach.is_some() || !settings.tip_corner_contact {
            true => solver,
            false => solver.followed_as_needed(pair),
        };
        Ok(solver.bent_as_needed(pair))
    }

    /// The same pair with tip edges followed up to `approach` (m).
    #[must_use]
    pub fn followed_to(mut self, approach: f64) -> ContactSolver {
        self.setup.followed_approach = approach;
        self
    }

    /// The same pair on as few stations as contact at run time needs, with the share along a segment that makes them enough.
    #[must_use]
    pub fn at_run_time(mut self) -> ContactSolver {
        let settings = &mut self.setup.settings;
        settings.stations = RUN_TIME_STATIONS.min(settings.stations);
        settings.own_share = OWN_SHARE_AT_RUN_TIME;
        self
    }

    /// The same pair after so many mesh cycles of `gear` (0 or 1), loaded on `flank`: its body is turned on by as many teeth where it
    /// is no solid of revolution.
    #[must_use]
    pub fn after(mut self, flank: Flank, gear: usize, cycles: u32) -> ContactSolver {
        let tooth = self.first_tooth(flank, gear, cycles);
        if let Some(turned) = self.compliance[gear].at_tooth(tooth) {
            self.compliance[gear] = turned;
        }
        self
    }

    /// The tooth of `gear`, in canonical coordinates, that the model takes as tooth 0 after so many mesh cycles.
    fn first_tooth(&self, flank: Flank, gear: usize, cycles: u32) -> i32 {
        let geometry = &self.setup.geometry;
        let sense = flank.sign() * if gear == 0 { 1.0 } else { geometry.e() };
        let first = first_teeth(geometry, flank)[gear] * sense as i32;
        // Pair k is tooth k of gear 1 and tooth -k of gear 2 in canonical coordinates, and one less each cycle.
        first + [-1, 1][gear] * cycles as i32
    }

    /// What the body of `gear` adds to the work of the columns of `forces` (N on each segment of `problem`, which is loaded on `flank`) on the
    /// displacements by each other beyond its mean over all angles, m N, after each number of mesh cycles of a turn. None of a solid of
    /// revolution.
    ///
    /// # Errors
    /// [`ContactError::BeyondModel`] where more teeth are in mesh than the elastic models hold.
    pub fn beyond_mean_body(
        &self,
        flank: Flank,
        problem: &PositionProblem,
        gear: usize,
        forces: &DMatrix<f64>,
    ) -> Result<Option<Vec<DMatrix<f64>>>, ContactError> {
        let teeth: Vec<i32> = (0..self.setup.geometry.gears[gear].teeth)
            .map(|cycle| self.first_tooth(flank, gear, cycle))
            .collect();
        let seen: Vec<Segment> = problem.seen.iter().map(|both| both[gear]).collect();
        let found = self
            .model(flank, gear)
            .beyond_mean_body(&seen, forces, &teeth);
        found.map_err(|model| ContactError::BeyondModel {
            center_distance_offset: problem.contact.center_distance_offset,
            model,
        })
    }

    /// The same pair with its flanks deflected along the face.
    #[must_use]
    pub fn with_deflection(mut self, deflection: Deflection) -> ContactSolver {
        let [least, largest] = self.deflection_range(&deflection);
        // The approach that bears the load grows by the range of the deflection.
        self.setup.followed_approach += largest.max(0.0) + largest - least;
        self.deflection = deflection;
        self.is_mirrored = false;
        self
    }

    /// Least and largest closing of `deflection` over the overlap of both faces, m.
    fn deflection_range(&self, deflection: &Deflection) -> [f64; 2] {
        let (geometry, [low, width]) = (&self.setup.geometry, self.numbers.face);
        let ratio = geometry.transverse_contact_ratio(geometry.center_distance);
        let path = geometry.base_pitch() * ratio;
        deflection.range([low, low + width], self.numbers.tan_beta_b * path)
    }

    /// The pair's geometry.
    pub fn geometry(&self) -> &PairGeometry {
        &self.setup.geometry
    }

    /// Whether mid-face mirrors the pair: solutions at misalignments of one sign are those at the other, mirrored.
    pub fn is_mirrored_at_mid_face(&self) -> bool {
        self.is_mirrored
    }

    /// The pair's law of friction; no solution depends on it.
    pub fn friction(&self) -> FrictionLaw {
        self.setup.friction.unwrap_or_default()
    }

    /// The settings it was made with.
    pub fn settings(&self) -> &ContactSettings {
        &self.setup.settings
    }

    /// What the contact knows without the elastic models.
    pub fn setup(&self) -> &ContactSetup {
        &self.setup
    }

    /// The problem at `mesh_position` (base pitches; 0: a tooth pair touches at the pitch point at mid-face) and at the deviation
    /// `center_distance_offset` (m) from the nominal centre distance. It serves all loads and misalignments.
    ///
    /// # Errors
    /// [`Input`](gearmesh::contact::ContactError::Input) for numbers that are not finite, [`OutOfMesh`](gearmesh::contact::ContactError::OutOfMesh) where teeth cannot meet,
    /// [`ContactError::BeyondModel`] where more teeth may than the elastic models hold.
    pub fn position(
        &self,
        flank: Flank,
        mesh_position: f64,
        center_distance_offset: f64,
    ) -> Result<PositionProblem, ContactError> {
        finite("mesh_position", mesh_position)?;
        finite("center_distance_offset", center_distance_offset)?;
        let geometry = &self.setup.geometry;
        let center_distance = geometry.center_distance + center_distance_offset;
        if (0..2).any(|i| geometry.tip_clearance(i, center_distance) <= 0.0) {
            let remedy = "give one (m) at which no tip reaches the root of its mate";
            let (field, value) = ("center_distance_offset", center_distance_offset);
            return Err(ContactError::input(field, value, remedy));
        }
        // One base pitch later everything is the same again.
        let tau = mesh_position - mesh_position.floor();
        let lines = self.lines(flank, tau, center_distance_offset)?;
        self.problem(&lines, lines.candidates())
    }

    /// As [`ContactSolver::position`] of tooth pair 0 alone, all other teeth out of the way, at `place` base pitches from where it
    /// touches at the pitch point at mid-face.
    ///
    /// # Errors
    /// As there; [`OutOfMesh`](gearmesh::contact::ContactError::OutOfMesh) where it is not on the extended path of contact.
    pub fn tooth_pair(
        &self,
        flank: Flank,
        place: f64,
        center_distance_offset: f64,
    ) -> Result<PositionProblem, ContactError> {
        let lines = self.lines(flank, place, center_distance_offset)?;
        self.problem(&lines, lines.of_pair(0).collect())
    }

    /// Places between which a tooth pair lies on the extended path of contact at the deviation `center_distance_offset` (m).
    ///
    /// # Errors
    /// [`OutOfMesh`](gearmesh::contact::ContactError::OutOfMesh) where teeth cannot meet.
    pub fn passage(&self, center_distance_offset: f64) -> Result<[f64; 2], ContactError> {
        let section = self.setup.section(&self.numbers, center_distance_offset)?;
        Ok(section.passage())
    }

    /// Approach at which tooth pair 0, alone, first touches at `place` and `misalignment` (rad), m; infinite where it is
    /// not on the extended path of contact.
    ///
    /// # Errors
    /// As [`ContactSolver::passage`].
    pub fn first_touch(
        &self,
        flank: Flank,
        place: f64,
        center_distance_offset: f64,
        misalignment: f64,
    ) -> Result<f64, ContactError> {
        let lines = self.lines(flank, place, center_distance_offset)?;
        let touches = lines.of_pair(0).flat_map(|segment| {
            let points = segment.levers.into_iter().zip(segment.gap);
            points.map(move |(lever, gap)| (gap - misalignment * lever) / segment.arm())
        });
        Ok(touches.fold(f64::INFINITY, f64::min))
    }

    fn problem(
        &self,
        lines: &ContactLines<'_>,
        candidates: Vec<Candidate>,
    ) -> Result<PositionProblem, ContactError> {
        if candidates.is_empty() {
            return Err(self.setup.out_of_mesh(lines.center_distance_offset).into());
        }
        let seen = lines.all_seen_by_gears(&candidates);
        let influence = self.influence_of(lines, &candidates, &seen)?;
        let mut problem = PositionProblem {
            contact: ContactProblem::new(lines, self.setup.local_bodies(), candidates, influence),
            seen,
            along: vec![],
        };
        problem.sample_along(lines);
        self.apply(
            &mut problem,
            lines,
            &Deflection::default(),
            &self.deflection,
        );
        Ok(problem)
    }

    /// Deflects the flanks of `problem`, made by [`ContactSolver::position`] for `flank` and `mesh_position`, from `present` to `next`.
    ///
    /// # Errors
    /// [`OutOfMesh`](gearmesh::contact::ContactError::OutOfMesh) where teeth cannot meet.
    pub fn deflect(
        &self,
        problem: &mut PositionProblem,
        (flank, mesh_position): (Flank, f64),
        [present, next]: [&Deflection; 2],
    ) -> Result<(), ContactError> {
        let tau = mesh_position - mesh_position.floor();
        let lines = self.lines(flank, tau, problem.contact.center_distance_offset)?;
        self.apply(problem, &lines, present, next);
        Ok(())
    }

    fn apply(
        &self,
        problem: &mut PositionProblem,
        lines: &ContactLines<'_>,
        present: &Deflection,
        next: &Deflection,
    ) {
        let own_share = self.setup.settings.own_share;
        for candidate in &mut problem.contact.candidates {
            let closed = candidate.points().map(|z| {
                let y = lines.contact_line(candidate.tooth_pair, z);
                let [next, present] = [next, present].map(|by| {
                    let [closing, slope] = by.closing(z);
                    closing + slope * lines.lean() * y
                });
                next - present
            });
            let closed = along_segment(closed, own_share);
            for (gap, closed) in candidate.gap.iter_mut().zip(closed) {
                *gap -= closed;
            }
        }
        // Compared with approach and misalignment alone.
        let [next, present] = [next, present].map(|by| match by == &Deflection::default() {
            true => 0.0,
            false => self.deflection_range(by)[1].max(0.0),
        });
        let more = next - present;
        if let Some(followed) = &mut problem.contact.followed_approach {
            *followed -= more;
        }
    }

    /// Sliding of `result`, a solution of `problem`, weighted by `law`.
    pub fn sliding(
        &self,
        problem: &PositionProblem,
        result: &ContactResult,
        law: &FrictionLaw,
    ) -> Sliding {
        let sums = SlidingSums::new(self.geometry(), law);
        let forces = result.segments.iter().map(|segment| segment.force);
        problem.contact.sliding(&sums, forces, result.loa_force)
    }

    /// The stations along the face as gear 1 and gear 2 see them where tooth pair 0 touches at the pitch point at mid-face.
    ///
    /// # Errors
    /// [`OutOfMesh`](gearmesh::contact::ContactError::OutOfMesh) where teeth cannot meet.
    pub fn stations(&self, flank: Flank) -> Result<Vec<[Segment; 2]>, ContactError> {
        let lines = self.lines(flank, 0.0, 0.0)?.clamped();
        let stations = 0..self.setup.settings.stations;
        let seen = stations.map(|station| lines.seen_by_gears(0, lines.station(station)));
        Ok(seen.collect())
    }

    /// Influence of whole segments of `flank` at a place of [`CondensedFlank::grid`]. Nodes do not depend on each other.
    ///
    /// # Errors
    /// As [`ContactSolver::position`].
    pub fn node(
        &self,
        flank: Flank,
        [tau, center_distance_offset]: [f64; 2],
    ) -> Result<CondensedNode, ContactError> {
        let lines = self.lines(flank, tau, center_distance_offset)?.clamped();
        let segments = lines.segments_beyond(CondensedFlank::MARGIN * self.numbers.base_pitch);
        let seen = lines.all_seen_by_gears(&segments);
        let influence = self.influence_of(&lines, &segments, &seen)?;
        Ok(CondensedNode {
            segments,
            influence,
        })
    }

    /// Shares of gear 1 and gear 2 in the bulk displacement of a tooth pair at the pitch point under a uniform load on itself.
    ///
    /// # Errors
    /// As [`ContactSolver::position`].
    pub fn tooth_shares(&self, flank: Flank) -> Result<[f64; 2], ContactError> {
        let lines = self.lines(flank, 0.0, 0.0)?.clamped();
        let mut segments = lines.segments_beyond(0.0);
        segments.retain(|segment| segment.tooth_pair == 0);
        let seen = lines.all_seen_by_gears(&segments);
        let mut sums = [0.0; 2];
        for (i, sum) in sums.iter_mut().enumerate() {
            let seen: Vec<Segment> = seen.iter().map(|both| both[i]).collect();
            let bulk = self.model(flank, i).bulk(&seen);
            *sum = bulk.map_err(|model| beyond(&lines, model))?.sum();
        }
        let all = sums[0] + sums[1];
        Ok(sums.map(|sum| sum / all))
    }

    fn lines(
        &self,
        flank: Flank,
        tau: f64,
        center_distance_offset: f64,
    ) -> Result<ContactLines<'_>, ContactError> {
        Ok(ContactLines {
            setup: &self.setup,
            center_distance_offset,
            section: self.setup.section(&self.numbers, center_distance_offset)?,
            flank,
            tau,
            teeth: None,
            clamped: false,
        })
    }

    /// The elastic model of gear `i`, turned where the gear is seen from its other end.
    fn model(&self, flank: Flank, i: usize) -> &dyn ToothCompliance {
        let model: &dyn ToothCompliance = &*self.compliance[i];
        match model.turned() {
            Some(turned) if self.setup.geometry.is_mirrored(flank, i) => turned,
            _ => model,
        }
    }

    /// Influence of `segments`, which the gears see as `seen`.
    fn influence_of(
        &self,
        lines: &ContactLines<'_>,
        segments: &[Candidate],
        seen: &[[Segment; 2]],
    ) -> Result<Influence, ContactError> {
        let models = [0, 1].map(|i| self.model(lines.flank, i));
        influence(lines, models, segments, seen).map_err(|model| beyond(lines, model))
    }
}

fn beyond(lines: &ContactLines<'_>, model: BeyondModel) -> ContactError {
    ContactError::BeyondModel {
        center_distance_offset: lines.center_distance_offset,
        model,
    }
}
