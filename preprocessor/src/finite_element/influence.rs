//! Influence matrices of the flank nodes: how they are kept, and combinations of them.

use std::ops::Range;

use gearmesh::vector::Lanes;
use nalgebra::DMatrix;

use super::cache::Stored;
use super::flank::Weights;

/// The unit is the largest entry over this. The largest one, a node in a corner of the flank under a load of its
/// own, is some hundred times the usual ones: these are kept to 1e-7, and segments average over many nodes.
pub(super) const LARGEST_ENTRY: f64 = (1_u32 << 30) as f64;

/// Influence matrices in whole numbers of a small unit: half the memory of `f64`, a third to a sixth of it in files.
///
/// Neighbouring nodes move nearly alike, so that what is left of an entry after its neighbours in row and column
/// (`c_ij - c_i-1,j - c_i,j-1 + c_i-1,j-1`) mostly fits into one byte. A model is the same numbers whether it was
/// computed or read.
///
/// C_k, m/N (plane strain: m²/N, per force per metre of depth): rows tooth k, columns tooth 0.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Influence {
    /// Of the entries, m/N.
    unit: f64,
    nodes: usize,
    entries: Vec<i32>,
}

impl Influence {
    pub fn new(matrices: &[DMatrix<f64>]) -> Influence {
        let entries = matrices.iter().flat_map(|m| m.as_slice());
        let largest = entries.clone().fold(0.0f64, |m, v| m.max(v.abs()));
        let unit = if largest > 0.0 {
            largest / LARGEST_ENTRY
        } else {
            1.0
        };
        Influence {
            unit,
            nodes: matrices.first().map_or(0, DMatrix::nrows),
            entries: entries.map(|v| (v / unit).round() as i32).collect(),
        }
    }

    pub fn teeth(&self) -> usize {
        self.entries.len() / (self.nodes * self.nodes).max(1)
    }

    /// Displacements of the nodes of tooth `k` by a load on `node` of tooth 0, in units.
    fn column(&self, k: usize, node: usize) -> &[i32] {
        let start = (k * self.nodes + node) * self.nodes;
        &self.entries[start..start + self.nodes]
    }

    /// Displacements that the weights `observed` see, columns, by those of `loads`, rows, on a tooth `offset` teeth before.
    pub fn displacements(
        &self,
        offset: usize,
        loads: &[&Weights],
        observed: &[&Weights],
    ) -> DMatrix<f64> {
        let [(nodes, loads), (seen, observed)] = [loads, observed].map(compact);
        // Of the nodes, rows, by forces on each of the loaded ones.
        let mut influence = Vec::with_capacity(seen.len() * nodes.len());
        let runs = runs(&seen);
        Lanes::widest().run(
            #[inline(always)]
            |_| {
                for node in &nodes {
                    let whole = self.column(offset, *node);
                    for run in &runs {
                        let entries = whole[run.clone()].iter();
                        influence.extend(entries.map(|entry| self.unit * f64::from(*entry)));
                    }
                }
            },
        );
        let influence = DMatrix::from_vec(seen.len(), nodes.len(), influence);
        let displaced = combined(&influence, &loads).transpose();
        combined(&displaced, &observed)
    }
}

/// The nodes of `weights`, ascending, and the weights with nodes counted among them.
fn compact(weights: &[&Weights]) -> (Vec<usize>, Vec<Weights>) {
    let all = weights.iter().flat_map(|weights| weights.iter());
    let end = all.clone().map(|(node, _)| node + 1).max().unwrap_or(0);
    let mut place = vec![0; end];
    all.for_each(|(node, _)| place[*node] = 1);
    let nodes: Vec<usize> = (0..end).filter(|node| place[*node] > 0).collect();
    for (i, node) in nodes.iter().enumerate() {
        place[*node] = i;
    }
    let counted = weights.iter().map(|weights| {
        let weights = weights.iter();
        weights.map(|(node, w)| (place[*node], *w)).collect()
    });
    let counted = counted.collect();
    (nodes, counted)
}

/// The columns of `matrix` in combinations of the weights `weights`.
fn combined(matrix: &DMatrix<f64>, weights: &[Weights]) -> DMatrix<f64> {
    let n = matrix.nrows();
    let mut sums = DMatrix::zeros(n, weights.len());
    Lanes::widest().run(
        #[inline(always)]
        |_| {
            for (weights, mut sums) in weights.iter().zip(sums.column_iter_mut()) {
                let sums = sums.as_mut_slice();
                for (column, weight) in weights {
                    let column = &matrix.as_slice()[column * n..][..n];
                    for (sum, value) in sums.iter_mut().zip(column) {
                        *sum += weight * value;
                    }
                }
            }
        },
    );
    sums
}

/// The ascending `nodes` as ranges of neighbours: a contact line crosses a part of the flank.
fn runs(nodes: &[usize]) -> Vec<Range<usize>> {
    let neighbours = nodes.chunk_by(|a, b| a + 1 == *b);
    neighbours
        .map(|run| run[0]..run[run.len() - 1] + 1)
        .collect()
}

impl Stored for Influence {
    fn encode(&self) -> Vec<u8> {
        let mut out = self.unit.to_le_bytes().to_vec();
        out.extend((self.nodes as u64).to_le_bytes());
        let nothing = vec![0; self.nodes];
        for matrix in self.entries.chunks((self.nodes * self.nodes).max(1)) {
            let mut left = &nothing[..];
            for column in matrix.chunks(self.nodes) {
                let mut above = 0;
                for (entry, left) in column.iter().zip(left) {
                    let here = i64::from(*entry) - i64::from(*left);
                    put(here - above, &mut out);
                    above = here;
                }
                left = column;
            }
        }
        out
    }

    fn decode(mut bytes: &[u8]) -> Option<Influence> {
        let unit = f64::from_bits(word(&mut bytes)?);
        let nodes = usize::try_from(word(&mut bytes)?).ok()?;
        // Every entry takes a byte at least.
        let size = nodes.checked_mul(nodes)?;
        if size == 0 || size > bytes.len() {
            return None;
        }
        let mut entries: Vec<i32> = Vec::new();
        while !bytes.is_empty() {
            let is_first = entries.len().is_multiple_of(size);
            let mut here = 0;
            for row in entries.len()..entries.len() + nodes {
                here += take(&mut bytes)?;
                let left = if is_first { 0 } else { entries[row - nodes] };
                entries.push(i32::try_from(here + i64::from(left)).ok()?);
            }
        }
        entries.len().is_multiple_of(size).then_some(Influence {
            unit,
            nodes,
            entries,
        })
    }
}

fn word(bytes: &mut &[u8]) -> Option<u64> {
    let (head, tail) = bytes.split_first_chunk()?;
    *bytes = tail;
    Some(u64::from_le_bytes(*head))
}

/// Signed LEB128 with the sign in the lowest bit: seven bits a byte, the lowest first, the highest bit set where
/// more follow.
fn put(value: i64, out: &mut Vec<u8>) {
    let mut rest = ((value << 1) ^ (value >> 63)) as u64;
    while rest >= 0x80 {
        out.push(rest as u8 | 0x80);
        rest >>= 7;
    }
    out.push(rest as u8);
}

fn take(bytes: &mut &[u8]) -> Option<i64> {
    let mut value = 0;
    // Differences of 32-bit numbers need 34 bits and the sign.
    for shift in (0..35).step_by(7) {
        let (byte, tail) = bytes.split_first()?;
        *bytes = tail;
        value |= u64::from(byte & 0x7f) << shift;
        if byte & 0x80 == 0 {
            return Some((value >> 1) as i64 ^ -((value & 1) as i64));
        }
    }
    None
}

#[cfg(test)]
#[path = "influence_tests.rs"]
mod tests;
