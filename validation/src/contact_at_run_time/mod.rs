//! Contact at run time: teeth that differ, tooth pair by tooth pair, segments, cost and error.

mod cost;
mod index_errors;
mod stations;
mod teeth;

use crate::setup::Setup;
use crate::{Chapter, Result};
use gearmesh::contact::{ContactFile, ContactSetup};
use gearmesh::gear::{Flank, PairTeeth, ToothErrors};
use gearmesh::pair::Pair;
use gearmesh::table::{Effects, Interpolation, Load, TeethFlank, TeethRecord};
use std::sync::Arc;

pub const CHAPTERS: [(&str, Chapter); 4] = [
    ("index-errors", index_errors::report),
    ("teeth", teeth::report),
    ("stations", stations::report),
    ("cost", cost::report),
];

/// The pair of the teeth that differ, and the flank tolerance class of ISO 1328-1 and seed of gear 1's index errors.
const PAIR: &str = "palermo2013";
const CLASS: u8 = 6;
const SEED: u32 = 1;

/// The shipped pairs that segments and cost are measured on.
const PAIRS: [&str; 4] = ["palermo2013", "fzg-c", "helical-25-47", "planet-ring-27-84"];

/// The contact of `file` with the errors `first` of gear 1's teeth on the drive flank.
fn with_errors(file: &ContactFile, first: ToothErrors) -> ContactFile {
    let drive = [first, ToothErrors::default()];
    let teeth = PairTeeth {
        drive,
        ..PairTeeth::default()
    };
    let setup = Arc::new(ContactSetup {
        teeth,
        ..(*file.setup).clone()
    });
    ContactFile {
        setup,
        ..file.clone()
    }
}

/// The record of the level `teeth` with the index errors `index` on gear 1.
fn record(
    setup: &Setup,
    file: &ContactFile,
    index: Vec<f64>,
    points: usize,
) -> Result<TeethRecord> {
    let contact = with_errors(
        file,
        ToothErrors {
            index,
            ..ToothErrors::default()
        },
    );
    setup.teeth_record(&contact, points)
}

/// The drive flank of `record` with all of its effects.
fn level(record: &TeethRecord, pair: &Pair) -> Result<TeethFlank> {
    let effects = Effects {
        interpolation: Interpolation::Spline,
        load: Load::Variable,
        center_distance: true,
        misalignment: true,
        shuttling: true,
        friction: false,
        root_stress: false,
        teeth: true,
    };
    Ok(TeethFlank::new(
        record,
        &pair.geometry,
        Flank::Drive,
        &effects,
    )?)
}
