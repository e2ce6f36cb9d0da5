//! Four pairs of the FZG at the centre distance 91.5 mm whose loss factors are known from another program
//! (loads shared by rigid teeth: evenly along all contact lines).

use super::gears::{gear, with_module};
use gearmesh::gear::{GearKind, PairGeometry};

/// Name, teeth, normal module in mm, helix angle in degrees, profile shifts, face width in mm, tip diameters in
/// mm, loss factor of Ohlendorf and of the even line load.
pub(crate) struct Fzg(
    &'static str,
    [u32; 2],
    f64,
    f64,
    [f64; 2],
    f64,
    [f64; 2],
    [f64; 2],
);

/// Tip diameters: addendum of one module, shortened for the clearance of the basic rack.
pub(crate) const FZG: [Fzg; 4] = [
    Fzg(
        "C14",
        [16, 24],
        4.5,
        0.0,
        [0.1817, 0.1715],
        14.0,
        [82.45, 118.35],
        [0.1986, 0.1946],
    ),
    Fzg(
        "H501",
        [20, 30],
        3.5,
        15.0,
        [0.1809, 0.0891],
        23.0,
        [80.67, 116.26],
        [0.1639, 0.1869],
    ),
    Fzg(
        "H701",
        [28, 42],
        2.5,
        15.0,
        [0.2290, 0.1489],
        17.0,
        [78.55, 114.39],
        [0.1225, 0.1404],
    ),
    Fzg(
        "H951",
        [38, 57],
        1.75,
        15.0,
        [1.6915, 2.0003],
        21.24,
        [76.23, 111.73],
        [0.0739, 0.0688],
    ),
];

impl Fzg {
    /// Name, pair, contact ratio, and both loss factors.
    pub(crate) fn pair(&self) -> (&'static str, PairGeometry, f64, f64, f64) {
        let Fzg(name, teeth, module, helix, shift, width, tips, [even_pairs, even_lines]) = *self;
        let gears = [0, 1].map(|i| {
            let hand = [1.0, -1.0][i];
            let plain = gear(GearKind::External, teeth[i], hand, helix, shift[i]);
            let mut gear = with_module(plain, 1e-3 * module);
            gear.face_width = 1e-3 * width;
            gear.tip_radius = 0.5e-3 * tips[i];
            gear.held_radius = 0.5 * gear.root_radius();
            gear
        });
        let pair = PairGeometry {
            gears,
            center_distance: 91.5e-3,
        };
        let ratio = pair.transverse_contact_ratio(pair.center_distance);
        (name, pair, ratio, even_pairs, even_lines)
    }
}

/// The FZG pair C.
pub(crate) fn c14() -> PairGeometry {
    FZG[0].pair().1
}
