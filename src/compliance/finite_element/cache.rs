//! Computed models kept in files, keyed by exactly what they depend on.
//!
//! File: magic line, SHA-256 key, length of the body, SHA-256 of the body, body; little endian. A file that
//! is cut, altered or of another version is recomputed and replaced, with a note; it never gives a
//! result. A half-written one is never found.

use super::flank::FlankGrid;
use super::{Cost, FiniteElementCompliance, FiniteElementError, Progress, Settings};
use crate::gear::{Gear, GearKind};
use crate::storage::{hex, write_whole};
use nalgebra::DMatrix;
use sha2::{Digest, Sha256};
use std::fs;
use std::path::{Path, PathBuf};

/// Changes whenever mesh, kernel or file layout do.
const MAGIC: &[u8; 32] = b"gearmesh finite elements v0002\r\n";

/// How a model was obtained.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// Computed; no cache asked for.
    Computed,
    /// Computed and stored.
    Stored,
    /// Read from the cache.
    Loaded,
    /// The cached file was unusable for this reason; computed anew and stored.
    Replaced(String),
    /// Computed; the cache could not be written for this reason.
    NotStored(String),
}

impl FiniteElementCompliance {
    /// As [`FiniteElementCompliance::new`], by way of the cache `directory`, which is created if it does
    /// not exist. An unusable cache costs the time of a computation and is told by [`Origin`].
    ///
    /// # Errors
    /// Those of [`FiniteElementCompliance::new`].
    pub fn cached(
        gear: &Gear,
        settings: &Settings,
        directory: &Path,
        progress: &Progress<'_>,
    ) -> Result<(Self, Origin), FiniteElementError> {
        let key = key(gear, settings);
        let path = file_path(directory, &key);
        let mut reason = None;
        match fs::read(&path) {
            Ok(bytes) => match decode(&bytes, &key, gear, settings) {
                Ok(model) => return Ok((model, Origin::Loaded)),
                Err(fault) => reason = Some(format!("{}: {fault}", path.display())),
            },
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            Err(error) => reason = Some(format!("{}: {error}", path.display())),
        }
        let model = FiniteElementCompliance::new(gear, settings, progress)?;
        let origin = match (store(&path, &encode(&model, &key)), reason) {
            (Err(error), _) => Origin::NotStored(format!("{}: {error}", path.display())),
            (Ok(()), Some(reason)) => Origin::Replaced(reason),
            (Ok(()), None) => Origin::Stored,
        };
        Ok((model, origin))
    }
}

/// Whether both gears have the same model in canonical coordinates: hand, axial position and
/// microgeometry do not matter.
pub(super) fn same_model(a: &Gear, b: &Gear) -> bool {
    canonical_bytes(a) == canonical_bytes(b)
}

fn canonical_bytes(gear: &Gear) -> Vec<u8> {
    // Taken apart by name, so that a new field cannot be forgotten.
    let Gear {
        kind,
        teeth,
        hand: _,
        normal_module,
        normal_pressure_angle,
        helix_angle,
        profile_shift,
        face_width,
        face_offset: _,
        tip_radius,
        // Ends the flank; the body is meshed to the tip circle.
        tip_chamfer: _,
        dedendum_coefficient,
        tool_tip_radius_coefficient,
        held_radius,
        tooth_thinning,
        youngs_modulus,
        poisson_ratio,
    } = gear;
    let mut bytes = vec![u8::from(*kind == GearKind::Ring)];
    bytes.extend(teeth.to_le_bytes());
    for value in [
        normal_module,
        normal_pressure_angle,
        helix_angle,
        profile_shift,
        face_width,
        tip_radius,
        dedendum_coefficient,
        tool_tip_radius_coefficient,
        held_radius,
        tooth_thinning,
        youngs_modulus,
        poisson_ratio,
    ] {
        bytes.extend(value.to_le_bytes());
    }
    bytes
}

fn key(gear: &Gear, settings: &Settings) -> [u8; 32] {
    let Settings {
        discretization: d,
        plane_strain,
        reach,
    } = settings;
    let mut hash = Sha256::new();
    hash.update(MAGIC);
    hash.update(canonical_bytes(gear));
    hash.update([u8::from(*plane_strain)]);
    hash.update((*reach as u64).to_le_bytes());
    for value in d.mesh_sizes() {
        hash.update(value.to_le_bytes());
    }
    hash.finalize().into()
}

fn file_path(directory: &Path, key: &[u8; 32]) -> PathBuf {
    directory.join(format!("{}.compliance", hex(&key[..12])))
}

fn store(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    if let Some(directory) = path.parent() {
        fs::create_dir_all(directory)?;
    }
    write_whole(path, bytes)
}

fn encode(model: &FiniteElementCompliance, key: &[u8; 32]) -> Vec<u8> {
    let FiniteElementCompliance {
        grid,
        influence,
        plane_strain: _,
        cos_base_helix,
        cost,
    } = model;
    let mut body = Vec::new();
    let counts = [
        grid.arcs.len(),
        grid.stations.len(),
        influence.len(),
        cost.elements,
        cost.unknowns,
        cost.factor_entries,
        cost.flank_nodes,
        cost.memory_bytes,
    ];
    for count in counts {
        body.extend((count as u64).to_le_bytes());
    }
    let scalars = [grid.form_roll, grid.arc_per_roll_squared, *cos_base_helix];
    let numbers = grid
        .arcs
        .iter()
        .chain(&grid.stations)
        .chain(&scalars)
        .chain(&cost.seconds)
        .chain(influence.iter().flat_map(|c| c.as_slice()));
    for number in numbers {
        body.extend(number.to_le_bytes());
    }
    let mut bytes = MAGIC.to_vec();
    bytes.extend(key);
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.extend(Sha256::digest(&body));
    bytes.extend(body);
    bytes
}

/// Reads a stored model; the error says what is wrong with the file.
fn decode(
    bytes: &[u8],
    key: &[u8; 32],
    gear: &Gear,
    settings: &Settings,
) -> Result<FiniteElementCompliance, &'static str> {
    const CUT: &str = "the file is cut off";
    let mut rest = bytes;
    let mut take = |count: usize| -> Result<&[u8], &'static str> {
        let (head, tail) = rest.split_at_checked(count).ok_or(CUT)?;
        rest = tail;
        Ok(head)
    };
    if take(32)? != MAGIC {
        return Err("not a compliance file of this version");
    }
    if take(32)? != key {
        return Err("the file belongs to another gear or other settings");
    }
    let length = u64::from_le_bytes(take(8)?.try_into().map_err(|_| CUT)?);
    let checksum = take(32)?;
    let body = rest;
    if body.len() as u64 != length {
        return Err(CUT);
    }
    if Sha256::digest(body).as_slice() != checksum {
        return Err("the checksum does not match");
    }
    let mut words = body
        .chunks_exact(8)
        .map(|w| u64::from_le_bytes(std::array::from_fn(|i| w[i])));
    let mut count = || words.next().map(|n| n as usize).ok_or(CUT);
    let (arcs, stations, matrices) = (count()?, count()?, count()?);
    let (elements, unknowns) = (count()?, count()?);
    let (factor_entries, flank_nodes, memory_bytes) = (count()?, count()?, count()?);
    let mut numbers = words.map(f64::from_bits);
    let mut list = |n: usize| -> Result<Vec<f64>, &'static str> {
        let values: Vec<f64> = numbers.by_ref().take(n).collect();
        if values.len() == n {
            Ok(values)
        } else {
            Err(CUT)
        }
    };
    let (arcs, stations) = (list(arcs)?, list(stations)?);
    let scalars = list(3)?;
    let seconds = list(3)?;
    let grid = FlankGrid {
        arcs,
        stations,
        form_roll: scalars[0],
        arc_per_roll_squared: scalars[1],
        kernel_half_width: settings.discretization.kernel_half_width * gear.normal_module,
    };
    let n = grid.len();
    let influence = (0..matrices)
        .map(|_| Ok(DMatrix::from_vec(n, n, list(n * n)?)))
        .collect::<Result<Vec<_>, &'static str>>()?;
    Ok(FiniteElementCompliance {
        grid,
        influence,
        plane_strain: settings.plane_strain,
        cos_base_helix: scalars[2],
        cost: Cost {
            elements,
            unknowns,
            factor_entries,
            flank_nodes,
            seconds: [seconds[0], seconds[1], seconds[2]],
            memory_bytes,
        },
    })
}

#[cfg(test)]
#[path = "cache_tests.rs"]
mod tests;
