//! Influence matrices in whole numbers of a small unit: half the memory of `f64`, a third to a sixth of it in files.
//!
//! Neighbouring nodes move nearly alike, so that what is left of an entry after its neighbours in row and column
//! (`c_ij - c_i-1,j - c_i,j-1 + c_i-1,j-1`) mostly fits into one byte. A model is the same numbers whether it was
//! computed or read.

use super::cache::Stored;
use nalgebra::DMatrix;

/// The unit is the largest entry over this. The largest one, a node in a corner of the flank under a load of its
/// own, is some hundred times the usual ones: these are kept to 1e-7, and segments average over many nodes.
pub(super) const LARGEST: f64 = (1_u32 << 30) as f64;

/// C_k, m/N (plane strain: m²/N, per force per metre of depth): rows tooth k, columns tooth 0.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Influence {
    /// Of the entries, m/N.
    pub unit: f64,
    nodes: usize,
    entries: Vec<i32>,
}

impl Influence {
    pub fn new(matrices: &[DMatrix<f64>]) -> Influence {
        let entries = || matrices.iter().flat_map(|m| m.as_slice());
        let largest = entries().fold(0.0f64, |m, v| m.max(v.abs()));
        let unit = if largest > 0.0 {
            largest / LARGEST
        } else {
            1.0
        };
        Influence {
            unit,
            nodes: matrices.first().map_or(0, DMatrix::nrows),
            entries: entries().map(|v| (v / unit).round() as i32).collect(),
        }
    }

    pub fn teeth(&self) -> usize {
        self.entries.len() / (self.nodes * self.nodes).max(1)
    }

    /// Displacements of the nodes of tooth `k` by a load on `node` of tooth 0, in units.
    pub fn column(&self, k: usize, node: usize) -> &[i32] {
        let start = (k * self.nodes + node) * self.nodes;
        &self.entries[start..start + self.nodes]
    }
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
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn smooth() -> Vec<DMatrix<f64>> {
        let entry = |k: usize| {
            move |i: usize, j: usize| {
                let apart = (i as f64 - j as f64).abs();
                2e-9 / (1.0 + 0.1 * apart + 10.0 * k as f64)
            }
        };
        (0..3).map(|k| DMatrix::from_fn(60, 60, entry(k))).collect()
    }

    #[test]
    fn entries_are_kept_to_a_billionth_of_the_largest() {
        let matrices = smooth();
        let influence = Influence::new(&matrices);
        assert_eq!(influence.teeth(), 3);
        for (k, matrix) in matrices.iter().enumerate() {
            for j in 0..60 {
                for (i, value) in influence.column(k, j).iter().enumerate() {
                    let error = f64::from(*value) * influence.unit - matrix[(i, j)];
                    assert!(error.abs() < 2e-9 * 1e-9, "{error}");
                }
            }
        }
    }

    #[test]
    fn what_is_cut_or_too_long_is_not_read() {
        let mut bytes = Influence::new(&smooth()).encode();
        for length in [0, 8, 15, 16, bytes.len() - 1] {
            assert_eq!(Influence::decode(&bytes[..length]), None, "{length}");
        }
        bytes.push(0);
        assert_eq!(Influence::decode(&bytes), None);
    }

    proptest! {
        #[test]
        fn any_numbers_come_back(entries in proptest::collection::vec(any::<i32>(), 18)) {
            let influence = Influence { unit: 1e-15, nodes: 3, entries };
            prop_assert_eq!(Influence::decode(&influence.encode()), Some(influence));
        }
    }
}
