//! The contact of one pair: settings, and the problem of every position of the mesh.

use std::sync::Arc;

use super::candidates::{Candidate, ContactLines, along_strip};
use super::condensed::StripName;
use super::deflection::Deflection;
use super::error::ContactError;
use super::influence::Influence;
use super::local::constants::{
    FEWEST_STATIONS, MOST_STATIONS, OWN_SHARE_ALONG_STRIP, REFERENCE_OVER_HERTZ, RUN_TIME_STATIONS,
    STRIP_OVER_WIDTH,
};
use super::local::widest_contact;
use super::numbers::PairNumbers;
use super::position::PositionProblem;
use super::reach;
use super::setup::{ContactSettings, ContactSetup};
use super::transverse::TransverseSection;
use crate::compliance::{Strip, ToothCompliance};
use crate::friction::FrictionLaw;
use crate::gear::{Flank, PairGeometry, PairTeeth, ToothProfile};
use crate::pair::{Pair, Refinement};

/// Elements of level coarse over those of level normal; strips shorter than the elements follow no load of
/// their own either.
const COARSE_OVER_NORMAL: f64 = 5.0 / 3.0;

impl ContactSettings {
    /// Settings for `pair`: 40 stations, or as many as leave each as long as the widest contact of the
    /// pair's loads and misalignments is wide, but at least 10; tip corners as the pair file says.
    pub fn for_pair(pair: &Pair) -> ContactSettings {
        let elements = match pair.refinement {
            Refinement::Coarse => COARSE_OVER_NORMAL,
            Refinement::Normal | Refinement::Fine => 1.0,
        };
        let least = elements * STRIP_OVER_WIDTH * 2.0 * widest_contact(pair);
        let (_, face) = pair.geometry.face_overlap();
        ContactSettings {
            stations: ((face / least) as usize).clamp(FEWEST_STATIONS, MOST_STATIONS),
            tip_corner_contact: pair.tip_corner_contact,
            ..ContactSettings::default()
        }
    }
}

/// Static contact of one pair of gears.
///
/// Clones share nothing mutable; one solver serves all threads.
#[derive(Clone)]
pub struct ContactSolver {
    pub(super) setup: ContactSetup,
    pub(super) numbers: PairNumbers,
    compliance: [Arc<dyn ToothCompliance>; 2],
    friction: FrictionLaw,
    deflection: Deflection,
}

impl ContactSolver {
    /// A solver for `pair` on the elastic models of gear 1 and gear 2.
    ///
    /// # Errors
    /// [`ContactError::Setting`] for no stations or a reach that is not positive,
    /// [`ContactError::Profile`] for a gear without a usable tooth.
    pub fn new(
        pair: &Pair,
        compliance: [Arc<dyn ToothCompliance>; 2],
        settings: ContactSettings,
    ) -> Result<ContactSolver, ContactError> {
        if settings.stations == 0 {
            return Err(ContactError::Setting {
                field: "stations",
                value: 0.0,
                remedy: "give at least 1",
            });
        }
        let mut form_rolls = [0.0; 2];
        for (roll, gear) in form_rolls.iter_mut().zip(&pair.geometry.gears) {
            // The tip edge of the mate stays off the base circle, where the involute has its cusp.
            *roll = ToothProfile::new(gear)?
                .form_roll()
                .max(1e-3 * gear.base_radius());
        }
        let reach = settings
            .reach
            .unwrap_or_else(|| reach::estimate(pair, form_rolls));
        if !(reach.is_finite() && reach > 0.0) {
            return Err(ContactError::Setting {
                field: "reach",
                value: reach,
                remedy: "give a positive length in m",
            });
        }
        let corner_resolution = compliance.each_ref().map(|gear| gear.corner_resolution());
        let solver = ContactSolver {
            numbers: PairNumbers::new(&pair.geometry).with_corners(corner_resolution),
            setup: ContactSetup {
                geometry: pair.geometry.clone(),
                microgeometry: pair.microgeometry.clone(),
                teeth: PairTeeth::default(),
                settings,
                reach,
                reference_length: REFERENCE_OVER_HERTZ * widest_contact(pair),
                corner_resolution,
                form_rolls,
            },
            compliance,
            friction: pair.friction,
            deflection: Deflection::default(),
        };
        if settings.reach.is_some() || !settings.tip_corner_contact {
            return Ok(solver);
        }
        Ok(reach::followed_as_needed(solver, pair))
    }

    /// The same pair with tip edges followed up to the approach `reach`, m.
    #[must_use]
    pub fn followed_to(mut self, reach: f64) -> ContactSolver {
        self.setup.reach = reach;
        self
    }

    /// The same pair on as few stations as contact at run time needs, with the share along a strip that makes them enough.
    #[must_use]
    pub fn at_run_time(mut self) -> ContactSolver {
        let settings = &mut self.setup.settings;
        settings.stations = RUN_TIME_STATIONS.min(settings.stations);
        settings.own_share = OWN_SHARE_ALONG_STRIP;
        self
    }

    /// The same pair with its flanks deflected along the face.
    #[must_use]
    pub fn with_deflection(mut self, deflection: Deflection) -> ContactSolver {
        let [least, largest] = deflection.range(self.face(), self.beside_pitch_line());
        // Tip edges are followed by what the deflection closes, and the approach that bears the load grows by its
        // range.
        self.setup.reach += largest.max(0.0) + largest - least;
        self.deflection = deflection;
        self
    }

    /// Ends of the overlap of both faces, m in gear 1's frame.
    fn face(&self) -> [f64; 2] {
        let (low, width) = self.setup.geometry.face_overlap();
        [low, low + width]
    }

    /// Largest sigma y of contact on the path at the nominal centre distance, m.
    fn beside_pitch_line(&self) -> f64 {
        let geometry = &self.setup.geometry;
        let path =
            geometry.base_pitch() * geometry.transverse_contact_ratio(geometry.center_distance);
        self.numbers.tan_beta_b * path
    }

    /// The pair's geometry.
    pub fn geometry(&self) -> &PairGeometry {
        &self.setup.geometry
    }

    /// The pair's law of friction; no solution depends on it.
    pub fn friction(&self) -> &FrictionLaw {
        &self.friction
    }

    /// The settings it was made with.
    pub fn settings(&self) -> &ContactSettings {
        &self.setup.settings
    }

    /// The problem at `mesh_position` (base pitches; 0: a tooth pair touches at the pitch point at
    /// mid-face) and at the deviation `center_distance_offset` (m) from the nominal centre distance. It
    /// holds the influence matrix and serves all loads and misalignments.
    ///
    /// # Errors
    /// [`ContactError::Input`] for numbers that are not finite, [`ContactError::OutOfMesh`] where teeth
    /// cannot meet, [`ContactError::BeyondModel`] where more teeth may than the elastic models hold.
    pub fn position(
        &self,
        flank: Flank,
        mesh_position: f64,
        center_distance_offset: f64,
    ) -> Result<PositionProblem, ContactError> {
        for (field, value) in [
            ("mesh_position", mesh_position),
            ("center_distance_offset", center_distance_offset),
        ] {
            if !value.is_finite() {
                return Err(ContactError::Input {
                    field,
                    value,
                    remedy: "give a finite number",
                });
            }
        }
        let geometry = &self.setup.geometry;
        let center_distance = geometry.center_distance + center_distance_offset;
        if (0..2).any(|i| geometry.tip_clearance(i, center_distance) <= 0.0) {
            return Err(ContactError::Input {
                field: "center_distance_offset",
                value: center_distance_offset,
                remedy: "give one (m) at which no tip reaches the root of its mate",
            });
        }
        let section = self.section(center_distance_offset)?;
        let lines = self.setup.lines(flank, &section);
        // One base pitch later everything is the same again.
        let tau = mesh_position - mesh_position.floor();
        let candidates = lines.candidates(tau, section.reach());
        self.problem(&lines, tau, candidates, center_distance_offset)
    }

    /// The problem of `candidates`, which lie on `lines` at the mesh position `tau`.
    pub(super) fn problem(
        &self,
        lines: &ContactLines<'_>,
        tau: f64,
        mut candidates: Vec<Candidate>,
        center_distance_offset: f64,
    ) -> Result<PositionProblem, ContactError> {
        let own_share = self.setup.settings.own_share;
        for candidate in &mut candidates {
            let closed = candidate.points().map(|z| {
                let [closing, slope] = self.deflection.closing(z);
                let y = lines.contact_line(tau, candidate.tooth_pair, z);
                closing + slope * self.numbers.lean(lines.flank) * y
            });
            for (gap, closed) in candidate.gap.iter_mut().zip(along_strip(closed, own_share)) {
                *gap -= closed;
            }
        }
        if candidates.is_empty() {
            return Err(self.setup.out_of_mesh(center_distance_offset));
        }
        let seen = |c: &Candidate| lines.seen_by_gears(tau, (c.tooth_pair, c.z), false);
        let seen: Vec<_> = candidates.iter().map(seen).collect();
        let influence = self.influence_of(lines, &candidates, &seen, center_distance_offset)?;
        let mut limits = self.setup.limits(center_distance_offset);
        // Compared with approach and misalignment alone.
        let [_, largest] = self.deflection.range(self.face(), self.beside_pitch_line());
        limits.reach = limits.reach.map(|reach| reach - largest.max(0.0));
        let mut problem = PositionProblem::with(&self.numbers, candidates, influence, limits);
        problem.look_along(&self.numbers, lines, tau);
        Ok(problem)
    }

    /// Strips at the mesh position `tau` in [0, 1), each by its tooth pair and its ends (m in gear 1's frame), as gear 1 and gear 2 see them.
    ///
    /// # Errors
    /// [`ContactError::OutOfMesh`] where teeth cannot meet.
    pub fn seen_by_gears(
        &self,
        flank: Flank,
        tau: f64,
        center_distance_offset: f64,
        strips: impl Iterator<Item = (i32, [f64; 2])>,
    ) -> Result<Vec<[Strip; 2]>, ContactError> {
        let section = self.section(center_distance_offset)?;
        let lines = self.setup.lines(flank, &section);
        Ok(strips
            .map(|strip| lines.seen_by_gears(tau, strip, false))
            .collect())
    }

    /// What the contact knows without the elastic models.
    pub fn setup(&self) -> &ContactSetup {
        &self.setup
    }

    /// Influence of whole strips at the mesh position `tau` in [0, 1), those up to `margin` (base pitches) beyond the reach of
    /// contact, too.
    pub(super) fn influence(
        &self,
        flank: Flank,
        tau: f64,
        center_distance_offset: f64,
        margin: f64,
    ) -> Result<(Vec<StripName>, Influence), ContactError> {
        let section = self.section(center_distance_offset)?;
        let lines = self.setup.lines(flank, &section);
        let strips = lines.strips_beyond(tau, margin * self.setup.geometry.base_pitch());
        let seen = |c: &Candidate| lines.seen_by_gears(tau, (c.tooth_pair, c.z), true);
        let seen: Vec<_> = strips.iter().map(seen).collect();
        let influence = self.influence_of(&lines, &strips, &seen, center_distance_offset)?;
        Ok((strips.iter().map(|c| c.name()).collect(), influence))
    }

    /// Shares of gear 1 and gear 2 in the bulk displacement of a tooth pair at the pitch point under a uniform load on itself.
    pub(super) fn tooth_shares(&self, flank: Flank) -> Result<[f64; 2], ContactError> {
        let section = self.section(0.0)?;
        let lines = self.setup.lines(flank, &section);
        let mut strips = lines.strips_beyond(0.0, 0.0);
        strips.retain(|strip| strip.tooth_pair == 0);
        let mut sums = [0.0; 2];
        for (i, sum) in sums.iter_mut().enumerate() {
            let seen: Vec<Strip> = strips
                .iter()
                .map(|strip| lines.seen_by_gears(0.0, (strip.tooth_pair, strip.z), true)[i])
                .collect();
            *sum = match self.models(&lines)[i].bulk(&seen) {
                Ok(bulk) => bulk.sum(),
                Err(model) => {
                    return Err(ContactError::BeyondModel {
                        center_distance_offset_um: 0.0,
                        model,
                    });
                }
            };
        }
        let all = sums[0] + sums[1];
        Ok(sums.map(|sum| sum / all))
    }

    /// The transverse section at a centre distance offset, m.
    pub(super) fn section(&self, offset: f64) -> Result<TransverseSection, ContactError> {
        self.setup.section(&self.numbers, offset)
    }

    /// The elastic models of both gears, turned where the gear is seen from its other end.
    fn models(&self, lines: &ContactLines<'_>) -> [&dyn ToothCompliance; 2] {
        [0, 1].map(|i| {
            let model: &dyn ToothCompliance = &*self.compliance[i];
            match model.turned() {
                Some(turned) if lines.is_mirrored(i) => turned,
                _ => model,
            }
        })
    }

    fn influence_of(
        &self,
        lines: &ContactLines<'_>,
        candidates: &[Candidate],
        seen: &[[Strip; 2]],
        center_distance_offset: f64,
    ) -> Result<Influence, ContactError> {
        let reference = self.setup.reference_length;
        let models = self.models(lines);
        Influence::new(&self.numbers, models, candidates, seen, reference).map_err(|model| {
            ContactError::BeyondModel {
                center_distance_offset_um: 1e6 * center_distance_offset,
                model,
            }
        })
    }
}
