//! The contact at run time of a unit: refused, or solves that give numbers or refusals.
//!
//! An input is the head of a file. Influence matrices of a file that is accepted, as many as the head asks for, stand behind
//! it, and its checksum is put right.

use gearmesh_preprocessor::contact::contact_file;
use gearmesh_preprocessor::pair;
use std::sync::{Arc, LazyLock};

use gearmesh::contact::{CondensedFlank, ContactFile, ContactSettings, ContactSolver, Warm};
use gearmesh::fmi::resources::Resources;
use gearmesh::gear::{
    EndRelief, Flank, Microgeometry, OwnFlank, ProfileSlope, ReliefShape, Runout, ToothErrors,
    Topography, WeakTooth,
};
use gearmesh::pair::Refinement;
use gearmesh_preprocessor::finite_element::{PairCompliance, Settings};
use serde::Deserialize;
use serde_json::Value;
use sha2::{Digest, Sha256};

use super::unit_file::{run, unit};
use super::{Target, change};

/// Pairs with all that a contact may hold, and with as little as it can.
pub const TARGET: Target = Target {
    name: "contact_file",
    seeds: || HEADS.clone(),
    change: change::json,
    check,
};

/// Bytes before the checksum, before the length of the head, before the head.
const BEFORE: [usize; 3] = [32, 64, 72];

/// Those of the solver.
static FILES: LazyLock<[ContactFile; 2]> = LazyLock::new(|| {
    let text = include_str!("../../resources/pairs/palermo2013.json");
    let mut helical = pair::from_json(text).expect("a shipped pair");
    let removal: Vec<Vec<f64>> = (0..4)
        .map(|i| (0..3).map(|j| 1e-6 * f64::from(i * j)).collect())
        .collect();
    let measured = Topography::new(
        vec![5e-3, 10e-3, 15e-3, 20e-3],
        vec![0.0, 10e-3, 25e-3],
        removal,
    );
    let own = Microgeometry {
        topography: Some(Arc::new(measured.expect("a grid"))),
        ..Microgeometry::default()
    };
    helical.microgeometry.drive[1] = Microgeometry {
        profile_slope: Some(ProfileSlope {
            amount: 2e-6,
            bias: 1e-6,
            rolls: [8e-3, 20e-3],
        }),
        lead_slope: 3e-6,
        end_relief: [
            Some(EndRelief {
                amount: 5e-6,
                length: 3e-3,
                shape: ReliefShape::Parabolic,
            }),
            None,
        ],
        ..own.clone()
    };
    helical.teeth.drive[0] = ToothErrors {
        index: (0..20).map(|i| 1e-6 * f64::from(i % 7)).collect(),
        runout: Some(Runout {
            amount: 10e-6,
            angle: 0.3,
        }),
        flanks: vec![OwnFlank {
            tooth: 3,
            microgeometry: own,
        }],
        weak: vec![WeakTooth {
            tooth: 2,
            factor: 1.5,
        }],
    };
    let text = include_str!("../../resources/pairs/planet-ring-27-84.json");
    let mut ring = pair::from_json(text).expect("a shipped pair");
    ring.operating.center_distance_offset = [0.0; 2];
    [helical, ring].map(|mut pair| {
        pair.refinement = Refinement::Coarse;
        let settings = ContactSettings {
            stations: 4,
            ..ContactSettings::default()
        };
        let elements = Settings::for_pair(&pair);
        let models = PairCompliance::new(&pair.geometry, &elements, None, &|_, _, _| true);
        let [first, second] = models.expect("elastic models").gears;
        let solver = ContactSolver::new(&pair, [first, second], settings);
        contact_file(&pair, &solver.expect("a solver")).expect("a contact")
    })
});

static HEADS: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let head = |file: &ContactFile| {
        let bytes = file.to_bytes();
        let length = bytes[BEFORE[1]..BEFORE[2]]
            .try_into()
            .map(u64::from_le_bytes);
        bytes[BEFORE[2]..][..length.expect("eight bytes") as usize].to_vec()
    };
    FILES.iter().map(head).collect()
});

/// See [`Target::check`].
pub fn check(data: &[u8]) -> bool {
    let Some(values) = values(data) else {
        return false;
    };
    static MAGIC: LazyLock<Vec<u8>> = LazyLock::new(|| FILES[0].to_bytes()[..BEFORE[0]].to_vec());
    let length = (data.len() as u64).to_le_bytes();
    let content = [&length, data, &values].concat();
    let bytes = [&MAGIC, &Sha256::digest(&content)[..], &content].concat();
    match ContactFile::from_bytes(&bytes) {
        Ok(file) => {
            solve(&file);
            let starts = [
                ("stiffnessModel", 3.0),
                ("centerDistance", 1.0),
                ("misalignment", 1.0),
            ];
            let unit = unit("contact", file.setup.geometry.clone(), &starts);
            if let Ok(resources) = Resources::new(unit, None, Some(file)) {
                run(&Arc::new(resources));
            }
            true
        }
        Err(reason) => {
            assert!(!reason.is_empty() && reason.len() < 500, "{reason}");
            false
        }
    }
}

/// Values of the first file, over and over, as many as the flanks of a head ask for.
fn values(head: &[u8]) -> Option<Vec<u8>> {
    let head: Value = serde_json::from_slice(head).ok()?;
    let count = |flank: &Value| {
        let flank = CondensedFlank::deserialize(flank).ok()?;
        flank.value_count().filter(|count| *count < 1 << 20)
    };
    let flanks = [&head["drive"], &head["coast"]];
    let counts = flanks.map(|flank| {
        if flank.is_null() {
            Some(0)
        } else {
            count(flank)
        }
    });
    let count = counts[0].unwrap_or(0) + counts[1].unwrap_or(0);
    let values = FILES[0].drive.values.iter().cycle().take(count);
    Some(values.flat_map(|value| value.to_le_bytes()).collect())
}

/// Poses over both flanks and far beyond the mesh of both.
fn solve(file: &ContactFile) {
    for flank in [Flank::Drive, Flank::Coast] {
        let Some(contact) = file.flank(flank) else {
            continue;
        };
        let mut warm = Warm::default();
        for i in 0..12 {
            let [a, b, c] = [3, 5, 7].map(|prime| f64::from(i % prime) / f64::from(prime - 1));
            let at = [
                60e-6 * (a - 0.2),
                4e-4 * (b - 0.5),
                8e-3 * (c - 0.5),
                3.0 * a - 1.0,
            ];
            // What is no number here is refused by the unit.
            let _ = contact.potential(at, [i64::from(i), 0], &mut warm);
        }
    }
}
