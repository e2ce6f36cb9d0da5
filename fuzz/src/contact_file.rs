//! The contact at run time of a unit: refused, or solves that give numbers or refusals.
//!
//! An input is the head of a file. Influence matrices of a file that is accepted, as many as the head asks for, stand behind
//! it, and its checksum is put right.

use gearmesh_preprocessor::contact::{condensed_roots, contact_file};
use gearmesh_preprocessor::pair;
use std::sync::{Arc, LazyLock};

use gearmesh::contact::{CondensedFlank, CondensedRoots, ContactFile, ContactSettings, Warm};
use gearmesh::fmi::resources::Resources;
use gearmesh::gear::{Flank, Microgeometry, OwnFlank, Topography};
use gearmesh::sealed;
use gearmesh_preprocessor::finite_element::{PairCompliance, Settings, pair_root_stress};
use gearmesh_preprocessor::gear::Refinement;
use gearmesh_preprocessor::static_contact::ContactSolver;
use serde::Deserialize;
use serde_json::{Value, json};

use super::unit_file::{run, unit};
use super::{Target, accepted, change};

/// Pairs with all that a contact may hold, and with as little as it can.
pub const TARGET: Target = Target {
    seeds: || HEADS.clone(),
    change: change::json,
    check,
};

/// Bytes of the length of the head.
const LENGTH: usize = 8;

/// Those of the solver.
static FILES: LazyLock<[ContactFile; 2]> = LazyLock::new(|| {
    let text = include_str!("../../resources/pairs/palermo2013.json");
    let mut fields: Value = serde_json::from_str(text).expect("JSON");
    fields["gear2"]["profile_slope_um"] = json!(2.0);
    fields["gear2"]["bias_um"] = json!(1.0);
    fields["gear2"]["lead_slope_um"] = json!(3.0);
    fields["gear2"]["lower_end_relief"] =
        json!({ "amount_um": 5.0, "length_mm": 3.0, "shape": "parabolic" });
    fields["gear1"]["tooth_errors"] = json!({
        "drive_flank": { "pitch_class": 6 },
        "runout_um": 10.0,
        "runout_angle_deg": 17.0,
        "teeth": [{ "tooth": 2, "compliance_factor": 1.5 }],
    });
    let mut helical = pair::from_json(&fields.to_string()).expect("a pair");
    let (rolls, zs) = (vec![5e-3, 10e-3, 15e-3, 20e-3], vec![0.0, 10e-3, 25e-3]);
    let line = |i: i32| (0..3).map(|j| 1e-6 * f64::from(i * j)).collect();
    let measured = Topography::new(rolls, zs, (0..4).map(line).collect());
    let measured = Some(measured.expect("a grid"));
    helical.microgeometry.drive[1].topography = measured.clone();
    let own = Microgeometry {
        topography: measured,
        ..Microgeometry::default()
    };
    helical.teeth.drive[0].flanks = vec![OwnFlank {
        tooth: 3,
        microgeometry: own,
    }];
    let text = include_str!("../../resources/pairs/planet-ring-27-84.json");
    let mut ring = pair::from_json(text).expect("a shipped pair");
    ring.operating.center_distance_offset = [0.0; 2];
    [(helical, false), (ring, true)].map(|(mut pair, root_stress)| {
        pair.refinement = Refinement::Coarse;
        let settings = ContactSettings {
            stations: 4,
            ..ContactSettings::default()
        };
        let elements = Settings::for_pair(&pair);
        let models = PairCompliance::new(&pair.geometry, &elements, None, &|_, _, _| true);
        let [first, second] = models.expect("elastic models").gears;
        let solver = ContactSolver::new(&pair, [first, second], settings).expect("a solver");
        let mut file = contact_file(&pair, &solver).expect("a contact");
        if root_stress {
            let drive = Flank::Drive;
            let models = pair_root_stress(&pair.geometry, drive, &elements, None, &|_, _, _| true);
            let models = models.expect("fillets").gears;
            let roots = condensed_roots(&solver, drive, &models).expect("stations");
            Arc::make_mut(&mut file.drive).roots = Some(roots);
        }
        file
    })
});

static HEADS: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let head = |file: &ContactFile| {
        let bytes = file.to_bytes().split_off(sealed::HEAD);
        let length = u64::from_le_bytes(*bytes.first_chunk().expect("a length"));
        bytes[LENGTH..][..length as usize].to_vec()
    };
    FILES.iter().map(head).collect()
});

/// See [`Target::check`].
pub fn check(data: &[u8]) -> bool {
    static MAGIC: LazyLock<[u8; 32]> =
        LazyLock::new(|| *FILES[0].to_bytes().first_chunk().expect("a head"));
    let Some(values) = values(data) else {
        return false;
    };
    let length = (data.len() as u64).to_le_bytes();
    let bytes = sealed::seal(&MAGIC, &[&length, data, &values].concat());
    accepted(ContactFile::from_bytes(&bytes), |file| {
        solve(&file);
        let starts = [
            ("stiffnessModel", 3.0),
            ("centerDistanceEffect", 1.0),
            ("misalignmentEffect", 1.0),
            (
                "rootStress",
                f64::from(u8::from(file.drive.roots.is_some())),
            ),
        ];
        let unit = unit("contact", file.setup.geometry.clone(), &starts);
        if let Ok(resources) = Resources::new(unit, None, Some(file)) {
            run(&Arc::new(resources));
        }
    })
}

/// Values of the first file, over and over, as many as the flanks of a head ask for.
fn values(head: &[u8]) -> Option<Vec<u8>> {
    let head: Value = serde_json::from_slice(head).ok()?;
    let count = |flank: &Value| {
        let flank = CondensedFlank::deserialize(flank).ok()?;
        let roots = flank.roots.iter().flatten();
        let counts = roots.map(CondensedRoots::value_count);
        let counts: Option<Vec<usize>> = counts.chain([flank.value_count()]).collect();
        let small = |count: &usize| *count < 1 << 20;
        Some(counts?.into_iter().filter(small).sum())
    };
    let counts = [&head["drive"], &head["coast"]].map(|flank| match flank {
        Value::Null => 0,
        flank => count(flank).unwrap_or(0),
    });
    let count = counts[0] + counts[1];
    let values = FILES[0].drive.values.iter().cycle().take(count);
    Some(values.flat_map(|value| value.to_le_bytes()).collect())
}

/// Poses over both flanks and far beyond the mesh of both.
fn solve(file: &ContactFile) {
    for flank in [Flank::Drive, Flank::Coast] {
        let Some(contact) = file.flank(flank) else {
            continue;
        };
        let contact = contact.with_root_stress();
        let mut warm = Warm::default();
        for i in 0..12 {
            let [a, b, c] = [3, 5, 7].map(|prime| f64::from(i % prime) / f64::from(prime - 1));
            let at = [
                60e-6 * (a - 0.2),
                4e-4 * (b - 0.5),
                8e-3 * (c - 0.5),
                3.0 * a - 1.0,
            ];
            // NaN is refused by the unit.
            let _ = contact.potential(at, [i64::from(i), 0], &mut warm);
        }
    }
}
