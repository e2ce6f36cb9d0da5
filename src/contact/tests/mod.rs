//! Claims about what solutions do not show; those about solutions stand in tests/contact.

mod closest;
mod deflection;
mod not_a_number;
mod separation;

use crate::friction::FrictionLaw;
use crate::gear::{PairMicrogeometry, PairTeeth, ProfileRelief, ReliefShape};
use crate::pair::{Operating, Pair, Refinement};
use crate::table::TableFile;

/// The shipped pair `name` without modifications, by the geometry in its tables.
pub(super) fn plain_pair(name: &str) -> Pair {
    let tables = concat!(env!("CARGO_MANIFEST_DIR"), "/resources/tables");
    let text = std::fs::read_to_string(format!("{tables}/{name}.json")).unwrap();
    let tables: TableFile = serde_json::from_str(&text).unwrap();
    Pair {
        name: name.to_owned(),
        geometry: tables.geometry,
        microgeometry: PairMicrogeometry::default(),
        teeth: PairTeeth::default(),
        operating: Operating {
            nominal_torque: 100.0,
            maximum_torque: 200.0,
            center_distance_offset: [-100e-6, 100e-6],
            misalignment: [-3e-3, 3e-3],
        },
        refinement: Refinement::Coarse,
        tip_corner_contact: true,
        friction: FrictionLaw::default(),
        warnings: vec![],
    }
}

/// The same with `amount` (m) of tip relief on both gears over the last part `share` of the path.
pub(super) fn relieved(name: &str, amount: f64, share: f64) -> Pair {
    let mut pair = plain_pair(name);
    let g = &pair.geometry;
    let c = g.center_distance;
    let path = g.path_of_contact(c);
    let starts = [
        path.end - share * path.length(),
        path.start + share * path.length(),
    ];
    for (i, xi) in starts.into_iter().enumerate() {
        pair.microgeometry.drive[i].tip_relief = Some(ProfileRelief {
            amount,
            start_roll: g.roll_at(i, c, xi),
            end_roll: g.gears[i].roll_length(g.gears[i].tip_radius),
            shape: ReliefShape::Linear,
        });
    }
    pair
}
