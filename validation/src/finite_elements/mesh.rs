//! The transverse section of the mesh that a page of theory shows.

use crate::data::Data;
use crate::setup::shipped;
use crate::{Context, Result};
use gearmesh_preprocessor::finite_element::{Settings, sector_section};

/// The chapter: gear 1 of the paper's pair at level normal, a row for each quadrilateral.
pub fn report(_: &Context, data: &Data) -> Result<()> {
    let pair = shipped("palermo2013")?;
    let section = sector_section(&pair.geometry.gears[0], &Settings::for_pair(&pair))?;
    let rows = section.iter().map(|around| {
        let places = around.map(|[x, y]| format!("{:.4} | {:.4}", 1e3 * x, 1e3 * y));
        places.join(" | ")
    });
    let head = (1..=8).map(|node| format!("x {node}, mm | y {node}, mm"));
    let head = head.collect::<Vec<_>>().join(" | ");
    data.table("mesh", &head, &rows.collect::<Vec<_>>())
}
