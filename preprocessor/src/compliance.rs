//! How far a loaded flank deflects: bulk compliance (bending, shear, base, blank, neighbours) apart
//! from the local contact, whose width depends on the load.

use std::ops::Range;
use std::sync::Arc;

use gearmesh::contact::Segment;
use nalgebra::DMatrix;

use thiserror::Error;

/// Two segments lie on teeth farther apart than the elastic model goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error(
    "segments lie {distance} teeth apart, but the elastic model holds the influence of teeth on each other up to \
     {reach} teeth apart only; compute it with a larger `reach`"
)]
pub struct BeyondModel {
    /// Difference of the tooth numbers.
    pub distance: usize,
    /// Largest difference the model holds.
    pub reach: usize,
}

/// Forces on segments of one tooth that act together: numbers of the segments, and the forces on them, N.
pub type Load = Vec<(usize, f64)>;

/// Elastic model of one gear.
///
/// The approach of the two flanks of segment i, along the flank normal, is
/// `sum_j (bulk_1 + bulk_2)_ij F_j + sum over both gears of local_i`, F_j the normal force on segment j, with
/// `local_i = 2 (1 - nu^2) / (pi E) * F_i / l_i * (ln(2 L_i / b_i) + 1/2)`:
/// the centre displacement of a half-plane under the Hertz pressure of half-width b_i
/// (Johnson, Contact Mechanics, 1985, section 4.2 and app. 5) relative to the length L_i, and l_i the
/// length of the segment along the contact line. What L_i is depends on the bulk model: a bulk part that
/// includes more of the local displacement has the smaller L_i.
pub trait ToothCompliance: Send + Sync {
    /// Symmetric influence matrix, m/N: displacement of segment i into its own flank along the inward
    /// normal, averaged over the segment, per unit normal force on segment j.
    ///
    /// # Errors
    /// [`BeyondModel`] for segments on teeth so far apart that the model knows nothing of them.
    fn bulk(&self, segments: &[Segment]) -> Result<DMatrix<f64>, BeyondModel>;

    /// What each of `loads[0]`, the rows, works on the displacements by each of `loads[1]`, the columns, m N: with the matrix of
    /// [`ToothCompliance::bulk`] of `segments` a' bulk b. `wanted` are the columns of each row that are asked for; zero for the others.
    ///
    /// # Errors
    /// Those of [`ToothCompliance::bulk`].
    fn work(
        &self,
        segments: &[Segment],
        loads: [&[Load]; 2],
        wanted: &[Range<usize>],
    ) -> Result<DMatrix<f64>, BeyondModel> {
        Ok(work(&self.bulk(segments)?, loads, wanted))
    }

    /// The length L_i of every segment, m, that completes `bulk` with the local contact.
    fn reference_lengths(&self, segments: &[Segment]) -> Vec<f64>;

    /// The model of the same gear turned end for end, where that is another one: the contact solver takes it for
    /// segments that it had to mirror in z. None for bodies that are the same from both ends of the face.
    fn turned(&self) -> Option<&dyn ToothCompliance> {
        None
    }

    /// The model of the same gear with tooth 0 of [`Segment::tooth`] its tooth `tooth`, counted in canonical coordinates from the tooth at body +x (of a
    /// ring from that before the space there), where teeth deflect in another way from tooth to tooth. None where they are alike;
    /// of others this model is the mean.
    fn at_tooth(&self, _tooth: i32) -> Option<Arc<dyn ToothCompliance>> {
        None
    }

    /// What the body adds to the work of the columns of `forces` (N on each segment) on the displacements by each other beyond the mean of all
    /// teeth, m N, with each of `teeth` as that of [`ToothCompliance::at_tooth`]. None where teeth are alike.
    ///
    /// # Errors
    /// Those of [`ToothCompliance::bulk`].
    fn beyond_mean_body(
        &self,
        _segments: &[Segment],
        _forces: &DMatrix<f64>,
        _teeth: &[i32],
    ) -> Result<Option<Vec<DMatrix<f64>>>, BeyondModel> {
        Ok(None)
    }

    /// Distance from the tip edge, m, down to which the model holds how a tooth deflects under a load: under one closer to the
    /// edge it deflects as under one at this distance. Zero for a model of half-planes, which knows no edge.
    fn corner_resolution(&self) -> f64 {
        0.0
    }

    /// Length along z within which the model does not tell loads apart, m; zero for one that tells all.
    fn lengthwise_resolution(&self) -> f64 {
        0.0
    }
}

/// Of [`ToothCompliance::work`] between `n` loads and themselves the columns that are wanted of a symmetric matrix.
pub fn lower_triangle(n: usize) -> Vec<Range<usize>> {
    (0..n).map(|row| 0..row + 1).collect()
}

/// [`ToothCompliance::work`] of segments with the matrix `bulk` (m/N).
pub fn work(
    bulk: &DMatrix<f64>,
    [rows, columns]: [&[Load]; 2],
    wanted: &[Range<usize>],
) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(rows.len(), columns.len());
    for (r, row) in rows.iter().enumerate() {
        for c in wanted[r].clone() {
            let of_row = row.iter().flat_map(|(i, a)| {
                let of_column = columns[c].iter();
                of_column.map(move |(j, b)| a * b * bulk[(*i, *j)])
            });
            all[(r, c)] = of_row.sum();
        }
    }
    all
}
