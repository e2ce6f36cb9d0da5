//! The level `teeth` of a pair, for examples.

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use gearmesh::contact::{ContactFile, ContactSetup, ContactSolver};
use gearmesh::gear::{Flank, PairTeeth, ToothErrors};
use gearmesh::pair::Pair;
use gearmesh::table::plan::Coverage;
use gearmesh::table::sweep::Watch;
use gearmesh::table::{
    Effects, Interpolation, Load, TeethFlank, TeethRecord, TeethSweep, default_teeth_axes,
};

type Failure = Box<dyn Error>;

/// Random operating points at which the error of the record is measured.
const POINTS: usize = 1000;

/// The record of the pair with the index errors `index` on gear 1, and its contact.
pub fn record(
    pair: &Pair,
    solver: &ContactSolver,
    file: &ContactFile,
    index: Vec<f64>,
) -> Result<(TeethRecord, ContactFile), Failure> {
    let first = ToothErrors {
        index,
        ..ToothErrors::default()
    };
    let contact = with_errors(file, first);
    let sweep = TeethSweep {
        solver,
        contact: &contact,
        coverage: &coverage(pair),
        coast_mirrors_drive: true,
    };
    let record = sweep.record(&default_teeth_axes(&coverage(pair)), POINTS, &quiet())?;
    Ok((record, contact))
}

/// The contact of `file` with the errors `first` of gear 1's teeth on the drive flank.
pub fn with_errors(file: &ContactFile, first: ToothErrors) -> ContactFile {
    let teeth = PairTeeth {
        drive: [first, ToothErrors::default()],
        ..PairTeeth::default()
    };
    ContactFile {
        setup: Arc::new(ContactSetup {
            teeth,
            ..(*file.setup).clone()
        }),
        ..file.clone()
    }
}

/// The operating range of the pair file.
pub fn coverage(pair: &Pair) -> Coverage {
    let operating = &pair.operating;
    Coverage {
        center_distance_offset: Some(operating.center_distance_offset),
        misalignment: Some(operating.misalignment),
        nominal_torque: operating.nominal_torque,
        maximum_torque: operating.maximum_torque,
    }
}

/// Nobody watches.
pub fn quiet() -> Watch<'static> {
    static GO_ON: AtomicBool = AtomicBool::new(false);
    Watch {
        progress: &|_, _| (),
        cancel: &GO_ON,
    }
}

/// The drive flank of `record` with all of its effects.
pub fn level(record: &TeethRecord, pair: &Pair) -> Result<TeethFlank, Failure> {
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
