//! Deflection of the shafts along the face on the command line.

use std::path::{Path, PathBuf};

use clap::Args;
use gearmesh::contact::Deflection;
use gearmesh::gear::PairGeometry;
use serde::Deserialize;

use crate::Error;
use crate::limits;
use crate::output;

/// How shafts and housing bend, beside the misalignment.
#[derive(Debug, Args)]
#[command(next_help_heading = "Deflection along the face")]
pub struct DeflectionArgs {
    /// CSV with the columns z_mm (from gear 1's z = 0 face) and closing_um: how far the flanks come closer there on
    /// the line of action before they bear load
    #[arg(long, value_name = "CSV", conflicts_with = "bow_um")]
    deflection: Option<PathBuf>,

    /// How much less both ends of the face close than its middle, um, parabolic, 0 at mid-face
    #[arg(long, default_value_t = 0.0, value_parser = limits::within(-LARGEST_UM..=LARGEST_UM))]
    bow_um: f64,
}

#[derive(Deserialize)]
struct Row {
    z_mm: f64,
    closing_um: f64,
}

/// Largest closing that is read, um: a hundred times what shafts do.
const LARGEST_UM: f64 = 1e4;

impl DeflectionArgs {
    /// The deflection; none where none is asked for.
    pub fn read(&self, geometry: &PairGeometry) -> Result<Option<Deflection>, Error> {
        if let Some(path) = &self.deflection {
            let curve = curve(path).map_err(|error| format!("{}: {error}", path.display()))?;
            return Ok(Some(curve));
        }
        let (low, width) = geometry.face_overlap();
        let bow = Deflection::bow(self.bow_um * 1e-6, [low, low + width])?;
        Ok((self.bow_um != 0.0).then_some(bow))
    }
}

fn curve(path: &Path) -> Result<Deflection, Error> {
    // The reader counts a line only at its \n, after the place of the next one.
    let text = output::read_text(path)?.replace("\r\n", "\n");
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let mut points = Vec::new();
    for row in reader.deserialize() {
        let Row { z_mm, closing_um } = row?;
        limits::check(Some(closing_um), &(-LARGEST_UM..=LARGEST_UM))
            .map_err(|e| format!("closing_um = {closing_um} at z_mm = {z_mm}: {e}"))?;
        points.push([z_mm * 1e-3, closing_um * 1e-6]);
    }
    Ok(Deflection::new(points)?)
}
