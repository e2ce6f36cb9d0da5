//! Four pairs of the FZG at the centre distance 91.5 mm whose loss factors are known from another program
//! (loads shared by rigid teeth: evenly along all contact lines).

use super::gears::{gear, with_module};
use gearmesh::gear::{GearKind, PairGeometry};

/// Name, teeth, normal module in mm, helix angle in degrees, profile shifts, face width in mm, tip diameters in mm, loss factors of
/// Ohlendorf and of the even line load. Tip diameters: addendum of one module, shortened for the clearance of the basic rack.
pub(crate) struct Fzg(&'static str);

pub(crate) const FZG: [Fzg; 4] = [
    Fzg("C14   16 24  4.5   0  0.1817 0.1715  14.0   82.45 118.35  0.1986 0.1946"),
    Fzg("H501  20 30  3.5  15  0.1809 0.0891  23.0   80.67 116.26  0.1639 0.1869"),
    Fzg("H701  28 42  2.5  15  0.2290 0.1489  17.0   78.55 114.39  0.1225 0.1404"),
    Fzg("H951  38 57  1.75 15  1.6915 2.0003  21.24  76.23 111.73  0.0739 0.0688"),
];

impl Fzg {
    /// Name, pair, contact ratio, and both loss factors.
    pub(crate) fn pair(&self) -> (&'static str, PairGeometry, f64, f64, f64) {
        let (name, values) = self.0.split_once(' ').unwrap();
        let values: Vec<f64> = values
            .split_whitespace()
            .map(|value| value.parse().unwrap())
            .collect();
        let gears = [0, 1].map(|i| {
            let hand = [1.0, -1.0][i];
            let (teeth, shift) = (values[i] as u32, values[4 + i]);
            let plain = gear(GearKind::External, teeth, hand, values[3], shift);
            let mut gear = with_module(plain, 1e-3 * values[2]);
            gear.face_width = 1e-3 * values[6];
            gear.tip_radius = 0.5e-3 * values[7 + i];
            gear.held_radius = 0.5 * gear.root_radius();
            gear
        });
        let pair = PairGeometry {
            gears,
            center_distance: 91.5e-3,
        };
        let ratio = pair.transverse_contact_ratio(pair.center_distance);
        (name, pair, ratio, values[9], values[10])
    }
}

/// The FZG pair C.
pub(crate) fn c14() -> PairGeometry {
    FZG[0].pair().1
}
