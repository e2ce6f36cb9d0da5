//! Stress in the tooth roots under the elastic load of the flanks.

use super::constants::{Constants, FLANKS};
use super::flank::FlankLoad;
use super::scalar::{Scalar, lift};
use crate::table::Table;

/// Stress in the roots of gear 1 and gear 2 under the loads of both `flanks`, Pa: the larger one.
///
/// The table must have it among its effects. Apart from the loads, which most units compute alone.
#[inline(never)]
pub(crate) fn root_stress<T: Scalar>(
    table: &Table,
    k: &Constants,
    center_distance: T,
    flanks: &[FlankLoad<T>; 2],
) -> [T; 2] {
    let mut largest = [T::from(0.0); 2];
    for (load, flank) in flanks.iter().zip(FLANKS) {
        if load.elastic.re() <= 0.0 {
            continue;
        }
        let Some((stress, mirrored)) = table.root_stress(flank) else {
            continue;
        };
        let offset = center_distance - k.center_distance;
        let q = load.table_coordinates(table.effects(), offset, mirrored);
        let jets = stress.evaluate(q.map(T::re));
        for (largest, jet) in largest.iter_mut().zip(&jets) {
            let here = lift(jet.value, &jet.gradient, &q);
            if here.re() > largest.re() {
                *largest = here;
            }
        }
    }
    largest
}
