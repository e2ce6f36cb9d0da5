//! The pairs of the experiments, each tooth thinned by 30 um on the base circle.

use gearmesh::gear::samples::{gear, paper_pair, thinned};
use gearmesh::gear::{GearKind, PairGeometry};

const THINNING: f64 = 30e-6;

/// The paper's pair.
pub fn external() -> PairGeometry {
    thinned(paper_pair(1.0), THINNING)
}

/// A ring of 61 teeth as gear 2.
pub fn internal() -> PairGeometry {
    let gears = [
        gear(GearKind::External, 20, 1.0, 13.0, 0.0),
        gear(GearKind::Ring, 61, 1.0, 13.0, 0.0),
    ];
    let center_distance = gears[1].reference_radius() - gears[0].reference_radius();
    let pair = PairGeometry {
        gears,
        center_distance,
    };
    thinned(pair, THINNING)
}

/// The same with the ring as gear 1.
pub fn ring_first() -> PairGeometry {
    let PairGeometry {
        gears: [pinion, ring],
        center_distance,
    } = internal();
    PairGeometry {
        gears: [ring, pinion],
        center_distance,
    }
}
