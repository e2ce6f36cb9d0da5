//! Where contact lies on bent teeth.
//!
//! A loaded tooth bends and tilts its flank; contact moves along the profile to where the flanks are closest then. With xi the place of a
//! segment (m towards the tip of gear 1, from where the undeformed flanks come closest), F its force, A(xi) the bulk matrix with loads and
//! displacements at these places and g the gap about the closest point, the mesh has the potential
//!
//! Pi = delta sum c_i F_i - [1/2 F' A(xi) F + sum g_i(xi_i) F_i + local energy(F)],
//!
//! which is stationary in xi, too: g_i'(xi_i) = tau_i, tau_i = -sum_j B_ij F_j - C_i xi_i F_i the tilt of the flanks, A(xi) and its slopes B and C
//! as in [`Motion`]. So xi_i is the least of the tilted gap. At a parabola of the relative radius of curvature R it is R tau. The law of local contact,
//! which shares out what a segment bears, is that of the gap about xi = 0, or about places that are known from a solution before.
//!
//! Forces and M_i = xi_i F_i are the conjugates of the closing and the tilt of a segment: what follows from the potential - energy, force,
//! shuttling moment, their slopes - keeps its form.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::bulk::Motion;
use super::candidates::Candidate;
use super::gap::GapProfile;
use super::local_law::POINTS;

/// The segments of a position, which may move.
#[derive(Clone, Copy)]
pub struct Movable<'a> {
    pub motion: &'a Motion,
    pub segments: &'a [Candidate],
}

/// Places of the segments, and the gaps there.
#[derive(Debug, Clone)]
pub struct Placed {
    /// Places along the profile, m.
    pub places: DVector<f64>,
    /// Tilts of the flanks, rad.
    pub tilts: DVector<f64>,
    /// Gaps at the points of each segment along the normal, m.
    pub gap: Vec<[f64; POINTS]>,
}

impl Placed {
    /// At the places `places` (m), where the flanks are tilted by `tilts` (rad).
    fn new(
        movable: Movable<'_>,
        gap: &[[f64; POINTS]],
        places: DVector<f64>,
        tilts: DVector<f64>,
    ) -> Placed {
        let mut placed = Placed {
            gap: vec![],
            places,
            tilts,
        };
        let opened = gap.iter().enumerate().map(|(i, gap)| {
            let by = placed.opened(i, &movable.segments[i].profile);
            gap.map(|gap| gap + by)
        });
        placed.gap = opened.collect();
        placed
    }

    /// Contact of undeformed flanks with the gaps `gap` (m).
    pub fn undeformed(movable: Movable<'_>, gap: &[[f64; POINTS]]) -> Placed {
        let still = DVector::zeros(gap.len());
        Placed::new(movable, gap, still.clone(), still)
    }

    /// The places under `forces` (N), `share` of the way from the present ones.
    pub fn under(
        &self,
        movable: Movable<'_>,
        gap: &[[f64; POINTS]],
        forces: &DVector<f64>,
        share: f64,
    ) -> Placed {
        let pressing = forces.map(|force| force.max(0.0));
        let tilted = -product(&movable.motion.tilt, &pressing);
        // Moments of the segment itself turn it back: as if its gap were so much more curved.
        let turned_back = movable.motion.bend.component_mul(&pressing);
        let least = |i: usize| {
            let profile = movable.segments[i].profile;
            let curvature = profile.curvature + turned_back[i];
            GapProfile {
                curvature,
                ..profile
            }
            .least_under(tilted[i])
        };
        let moves = DVector::from_fn(tilted.len(), |i, _| least(i) - self.places[i]);
        // Forces far from equilibrium say little about the places.
        let share = share * (movable.motion.step / moves.amax()).min(1.0);
        let places = &self.places + moves * share;
        let tilts = tilted - turned_back.component_mul(&places);
        Placed::new(movable, gap, places, tilts)
    }

    /// How much farther apart flanks with the gap `profile` are at the place of segment `i` than where they come closest undeformed, m.
    pub fn opened(&self, i: usize, profile: &GapProfile) -> f64 {
        let least = profile.least_under(self.tilts[i]);
        // On the way to its place a segment sees the tilted flank.
        profile.gap(least) + self.tilts[i] * (self.places[i] - least)
    }
}

/// Bulk matrix A(xi) and gaps at the present places.
#[derive(Clone, Copy)]
pub struct System<'a> {
    /// A, m/N, of contact that stays.
    pub bulk: &'a DMatrix<f64>,
    /// Gaps at the points of each segment along the normal, m.
    pub gap: &'a [[f64; POINTS]],
    /// Slopes of A and the places, m; `None`: contact stays.
    pub moved: Option<(&'a Motion, &'a DVector<f64>)>,
}

impl System<'_> {
    /// Displacements A(xi) F under the forces `forces` (N), m.
    pub fn displaced(&self, forces: &DVector<f64>) -> DVector<f64> {
        let mut displaced = product(self.bulk, forces);
        if let Some((Motion { tilt, bend, .. }, places)) = self.moved {
            let moments = places.component_mul(forces);
            let tilts = product(tilt, forces) + bend.component_mul(&moments);
            displaced += tilts.component_mul(places);
            displaced.gemv_tr(1.0, tilt, &moments, 1.0);
        }
        displaced
    }

    /// A(xi) of the segments `active`, lower triangle.
    pub fn of_active(&self, active: &[usize]) -> DMatrix<f64> {
        let n = active.len();
        let mut matrix = DMatrix::zeros(n, n);
        for (column, &j) in active.iter().enumerate() {
            for (row, &i) in active.iter().enumerate().skip(column) {
                matrix[(row, column)] = self.bulk[(i, j)];
                if let Some((Motion { tilt, .. }, places)) = self.moved {
                    matrix[(row, column)] += places[i] * tilt[(i, j)] + places[j] * tilt[(j, i)];
                }
            }
            if let Some((Motion { bend, .. }, places)) = self.moved {
                matrix[(column, column)] += places[j] * places[j] * bend[j];
            }
        }
        matrix
    }
}

/// `matrix` times `forces`, most of which are zero.
fn product(matrix: &DMatrix<f64>, forces: &DVector<f64>) -> DVector<f64> {
    let mut out = DVector::zeros(matrix.nrows());
    for (column, force) in matrix.column_iter().zip(forces) {
        if *force != 0.0 {
            out.axpy(*force, &column, 1.0);
        }
    }
    out
}

/// The linear response about a solution whose segments may move.
#[derive(Debug, Clone)]
pub struct Response {
    /// B over the segments in contact, with C xi on the diagonal.
    tilt: DMatrix<f64>,
    /// R F / (1 + R F C), N m: by how much F xi of a segment changes per tilt by others.
    mobility: DVector<f64>,
}

/// Steps after which the response is taken as it is.
const STEPS: usize = 100;

impl Response {
    /// About the places `placed` under `forces` (N) of the segments `active`.
    pub fn new(
        movable: Movable<'_>,
        placed: &Placed,
        forces: &DVector<f64>,
        active: &[usize],
    ) -> Response {
        let Motion { tilt, bend, .. } = movable.motion;
        let mut tilt = tilt.select_rows(active).select_columns(active);
        let mobility = DVector::from_fn(active.len(), |number, _| {
            let i = active[number];
            tilt[(number, number)] += bend[i] * placed.places[i];
            let moves =
                forces[i].max(0.0) * movable.segments[i].profile.radius_at(placed.places[i]);
            moves / (1.0 + moves * bend[i])
        });
        Response { tilt, mobility }
    }

    /// Forces by which the closings of the segments in contact grow by `closing`, `factor` that of D + A at places that stay. With N the change of
    /// F xi but for that of F, the system
    ///
    /// ```text
    /// [ D + A    B'         ] [ F ]   [ closing ]
    /// [ B     C + 1 / (F R) ] [ N ] = [ 0       ]
    /// ```
    ///
    /// is solved by eliminating N, whose part is small, by repetition, to the relative error `tolerance`.
    pub fn solve(
        &self,
        factor: &Cholesky<f64, Dyn>,
        closing: &DVector<f64>,
        tolerance: f64,
    ) -> DVector<f64> {
        let mut forces = factor.solve(closing);
        for _ in 0..STEPS {
            let moments = self.mobility.component_mul(&(&self.tilt * &forces));
            let next = factor.solve(&(closing + self.tilt.tr_mul(&moments)));
            let change = (&next - &forces).amax();
            forces = next;
            if change <= tolerance * forces.amax() {
                break;
            }
        }
        forces
    }
}
