//! What the tables file holds of tooth pairs one by one.

use super::pairs::MOST;
use crate::friction::FrictionLaw;
use crate::gear::{Flank, PairGeometry, PairTeeth, Runout, ToothErrors};
use crate::table::error;
use crate::table::{Axes, FlankGrid, InterpolationError, TableError};
use serde::{Deserialize, Serialize};
use std::fmt::Display;

/// Largest gain that is taken: at 1 loads are no longer distinct.
const LARGEST_GAIN: f64 = 0.95;

/// Beyond all errors of teeth, m.
const LARGEST_ERROR: f64 = 0.1;

/// Tooth pairs one by one, as the tables file holds them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TeethRecord {
    /// Nodes; the mesh position is the place of the tooth pair, 0 at `first_place`, 1 at `last_place`.
    pub axes: Axes,
    /// Where the range of places begins, base pitches from where the tooth pair touches at the pitch point at mid-face.
    pub first_place: f64,
    /// Where it ends; nothing touches there.
    pub last_place: f64,
    /// What a force on a tooth pair takes of the approach of others, m/N: of neighbours, of those two base pitches away, and so
    /// on, each at each misalignment, or one number for all of them.
    pub coupling_m_per_n: Vec<Vec<f64>>,
    /// One tooth pair alone on the drive flank.
    pub drive: FlankGrid,
    /// On the coast flank, if it is not the drive flank mirrored.
    pub coast: Option<FlankGrid>,
    /// What others take there; absent: the same.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coast_coupling_m_per_n: Option<Vec<Vec<f64>>>,
    /// How the drive flanks of gear 1 and gear 2 differ.
    pub drive_errors: [GearTeethRecord; 2],
    /// How their coast flanks do.
    pub coast_errors: [GearTeethRecord; 2],
    /// Law of friction, which weights the sliding in the samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<FrictionLaw>,
    /// Error against contact at run time, interpolation included.
    pub error: InterpolationError,
}

/// What distinguishes the teeth of one gear on one flank, see [`ToothErrors`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GearTeethRecord {
    /// Index error of every tooth along the line of action; empty: none.
    pub index_m: Vec<f64>,
    /// Radial run-out, twice the eccentricity.
    pub runout_m: f64,
    /// Body angle from the centre of tooth 0 in +theta to where the teeth stand out most.
    pub runout_angle_rad: f64,
}

impl From<&ToothErrors> for GearTeethRecord {
    /// Flanks and compliances of single teeth are left out.
    fn from(errors: &ToothErrors) -> Self {
        GearTeethRecord {
            index_m: errors.index.clone(),
            runout_m: errors.runout.map_or(0.0, |r| r.amount),
            runout_angle_rad: errors.runout.map_or(0.0, |r| r.angle),
        }
    }
}

/// A refusal of the field teeth.`field`.
fn refused<T>(field: &str, value: impl ToString, reason: impl Display) -> Result<T, TableError> {
    let reason = format!("{reason}; make the tables again with `gearmesh tables --teeth`");
    error::refused(format!("teeth.{field}"), value, reason)
}

impl GearTeethRecord {
    fn errors(&self) -> ToothErrors {
        ToothErrors {
            index: self.index_m.clone(),
            runout: (self.runout_m != 0.0).then_some(Runout {
                amount: self.runout_m,
                angle: self.runout_angle_rad,
            }),
            ..ToothErrors::default()
        }
    }

    fn check(&self, name: &str, teeth: u32) -> Result<(), TableError> {
        let count = self.index_m.len();
        if count != 0 && count != teeth as usize {
            let (field, value) = (format!("{name}.index_m"), format!("{count} numbers"));
            return refused(&field, value, format!("the gear has {teeth} teeth"));
        }
        let lengths = (self.index_m.iter().enumerate()).map(|(i, x)| (format!("index_m[{i}]"), *x));
        for (field, length) in lengths.chain([("runout_m".to_owned(), self.runout_m)]) {
            if length.is_nan() || length.abs() > LARGEST_ERROR {
                let reason = format!("errors of teeth are at most {LARGEST_ERROR} m");
                return refused(&format!("{name}.{field}"), length, reason);
            }
        }
        if !self.runout_angle_rad.is_finite() {
            let field = format!("{name}.runout_angle_rad");
            return refused(&field, self.runout_angle_rad, "it must be finite");
        }
        Ok(())
    }
}

impl TeethRecord {
    /// Whether the teeth of a gear differ.
    pub fn tells_apart(&self) -> bool {
        let mut gears = self.drive_errors.iter().chain(&self.coast_errors);
        gears.any(|errors| *errors != GearTeethRecord::default())
    }

    /// Refuses teeth that tooth pairs one by one do not tell apart.
    ///
    /// # Errors
    /// A tooth with a flank or a compliance of its own.
    pub fn takes(teeth: &PairTeeth) -> Result<(), TableError> {
        for gears in [&teeth.drive, &teeth.coast] {
            for (i, errors) in gears.iter().enumerate() {
                let flank = errors.flanks.first().map(|own| own.tooth);
                let weak = errors.weak.first().map(|own| own.tooth);
                let (field, tooth) = match (flank, weak) {
                    (Some(tooth), _) => ("topography_file", tooth),
                    (_, Some(tooth)) => ("compliance_factor", tooth),
                    _ => continue,
                };
                return error::refused(
                    format!("gear{}.tooth_errors.teeth: {field}", i + 1),
                    format!("tooth {tooth}"),
                    "stiffnessModel = teeth takes index errors and run-out alone; build without --teeth, with --contact, and set \
                     stiffnessModel = contact, which takes it",
                );
            }
        }
        Ok(())
    }

    /// Checks all fields against each other and against the pair `geometry`.
    ///
    /// # Errors
    /// The first defect, by field.
    pub fn check(&self, geometry: &PairGeometry) -> Result<(), TableError> {
        let length = self.last_place - self.first_place;
        if !(length > 0.0 && length <= (MOST - 1) as f64 && self.first_place.abs() < 100.0) {
            let value = format!("{} to {}", self.first_place, self.last_place);
            let reason = format!("places ascend by {} at most", MOST - 1);
            return refused("first_place, last_place", value, reason);
        }
        self.grid(Flank::Drive).check("teeth.drive")?;
        self.grid(Flank::Coast).check("teeth.coast")?;
        let nodes = self.axes.misalignment.len();
        for flank in [Flank::Drive, Flank::Coast] {
            let (name, rows) = self.named_coupling(flank);
            if rows.is_empty() || rows.len() >= MOST {
                let reason = format!("tooth pairs are 1 to {} base pitches apart", MOST - 1);
                return refused(name, format!("{} lists", rows.len()), reason);
            }
            if let Some(row) = rows.iter().find(|row| ![1, nodes].contains(&row.len())) {
                let reason = format!("there are {nodes} misalignments");
                return refused(name, format!("{} numbers", row.len()), reason);
            }
            if let Some(value) = rows.iter().flatten().find(|c| !(0.0..1.0).contains(*c)) {
                let reason = "a force on one tooth pair takes of the approach of the others";
                return refused(name, value, reason);
            }
        }
        for (i, gear) in geometry.gears.iter().enumerate() {
            self.drive_errors[i].check(&format!("drive_errors[{i}]"), gear.teeth)?;
            self.coast_errors[i].check(&format!("coast_errors[{i}]"), gear.teeth)?;
        }
        Ok(())
    }

    fn named_coupling(&self, flank: Flank) -> (&'static str, &[Vec<f64>]) {
        match (flank, &self.coast_coupling_m_per_n) {
            (Flank::Coast, Some(own)) => ("coast_coupling_m_per_n", own),
            _ => ("coupling_m_per_n", &self.coupling_m_per_n),
        }
    }

    /// What tooth pairs take of each other on `flank`, from neighbours on, at each misalignment, m/N.
    pub(super) fn coupling(&self, flank: Flank) -> Vec<Vec<f64>> {
        let row = |row: &Vec<f64>| match row[..] {
            [value] => vec![value; self.axes.misalignment.len()],
            _ => row.clone(),
        };
        self.named_coupling(flank).1.iter().map(row).collect()
    }

    /// Refuses a coupling on `flank` that is too large: of loads that cancel, the others must take less than a tooth pair deflects under its own.
    /// `gain`: the largest ratio of the two.
    pub(super) fn check_gain(&self, flank: Flank, gain: f64) -> Result<(), TableError> {
        if gain <= LARGEST_GAIN {
            return Ok(());
        }
        let (name, rows) = self.named_coupling(flank);
        let largest = rows.iter().flatten().fold(0.0, |l: f64, c| l.max(*c));
        error::refused(
            format!("teeth.{name}"),
            format!("{largest:.3e}"),
            format!(
                "other tooth pairs would take {gain:.2} times what one deflects under its own load, and only below {LARGEST_GAIN} are loads \
                 distinct; for this pair build without --teeth, with --contact, and set stiffnessModel = contact"
            ),
        )
    }

    /// Samples of `flank`; the coast flank without its own: those of the drive flank.
    pub fn grid(&self, flank: Flank) -> FlankGrid {
        let samples = match (flank, &self.coast) {
            (Flank::Coast, Some(own)) => own,
            _ => &self.drive,
        };
        samples.on(&self.axes)
    }

    /// Errors of the teeth.
    pub fn teeth(&self) -> PairTeeth {
        PairTeeth {
            drive: self.drive_errors.each_ref().map(GearTeethRecord::errors),
            coast: self.coast_errors.each_ref().map(GearTeethRecord::errors),
        }
    }
}
