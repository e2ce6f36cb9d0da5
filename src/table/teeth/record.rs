//! What the tables file holds of tooth pairs one by one.

use serde::{Deserialize, Serialize};

use crate::gear::{Flank, PairGeometry, PairTeeth, Runout, ToothErrors};
use crate::table::{Axes, FlankGrid, InterpolationError, TableError};

use super::pairs::MOST;

/// Largest gain that is taken: at 1 loads are no longer told apart.
const LARGEST_GAIN: f64 = 0.95;

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
    /// What a force on a tooth pair takes of the approach of the others.
    pub coupling_m_per_n: CouplingRecord,
    /// One tooth pair alone on the drive flank.
    pub drive: FlankGrid,
    /// On the coast flank, if it is not the drive flank mirrored.
    pub coast: Option<FlankGrid>,
    /// What others take there; absent: the same.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coast_coupling_m_per_n: Option<CouplingRecord>,
    /// How the drive flanks of gear 1 and gear 2 differ.
    pub drive_errors: [GearTeethRecord; 2],
    /// How their coast flanks do.
    pub coast_errors: [GearTeethRecord; 2],
    /// Error against contact at run time, interpolation included.
    pub error: InterpolationError,
}

/// What tooth pairs take of each other, m/N: neighbours, those two base pitches apart, and so on, each at each node of the
/// misalignment, or one number for all of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(from = "CouplingForms")]
pub struct CouplingRecord(pub Vec<Vec<f64>>);

/// Older files hold neighbours alone, the same at all misalignments or at each.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "coupling_m_per_n: one number, one at each misalignment, or a list of these for each distance"
)]
enum CouplingForms {
    Same(f64),
    Each(Vec<f64>),
    Apart(Vec<Vec<f64>>),
}

impl From<CouplingForms> for CouplingRecord {
    fn from(form: CouplingForms) -> Self {
        CouplingRecord(match form {
            CouplingForms::Same(value) => vec![vec![value]],
            CouplingForms::Each(values) => vec![values],
            CouplingForms::Apart(rows) => rows,
        })
    }
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
    /// Teeth with flanks or compliances of their own are not told apart.
    fn from(errors: &ToothErrors) -> Self {
        GearTeethRecord {
            index_m: errors.index.clone(),
            runout_m: errors.runout.map_or(0.0, |r| r.amount),
            runout_angle_rad: errors.runout.map_or(0.0, |r| r.angle),
        }
    }
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
        let refuse = |field: &str, value: String, reason: String| {
            let field = format!("teeth.{name}.{field}");
            Err(TableError::field(field, value, reason, AGAIN))
        };
        let count = self.index_m.len();
        if count != 0 && count != teeth as usize {
            let reason = format!("the gear has {teeth} teeth");
            return refuse("index_m", format!("{count} numbers"), reason);
        }
        let mut lengths = vec![("runout_m".to_owned(), self.runout_m)];
        let index = self.index_m.iter().enumerate();
        lengths.extend(index.map(|(i, x)| (format!("index_m[{i}]"), *x)));
        for (field, length) in lengths {
            if length.is_nan() || length.abs() > LARGEST_ERROR {
                let reason = format!("errors of teeth are at most {LARGEST_ERROR} m");
                return refuse(&field, length.to_string(), reason);
            }
        }
        if !self.runout_angle_rad.is_finite() {
            let reason = "no angle".to_owned();
            return refuse(
                "runout_angle_rad",
                self.runout_angle_rad.to_string(),
                reason,
            );
        }
        Ok(())
    }
}

const AGAIN: &str = "make the tables again with `gearmesh tables --teeth`";

/// Beyond all errors of teeth, m.
const LARGEST_ERROR: f64 = 0.1;

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
                let own = [
                    (
                        "topography_file",
                        errors.flanks.first().map(|own| own.tooth),
                    ),
                    (
                        "compliance_factor",
                        errors.weak.first().map(|own| own.tooth),
                    ),
                ];
                if let Some((field, tooth)) = own.iter().find_map(|(f, t)| Some((f, (*t)?))) {
                    return Err(TableError::field(
                        format!("gear{}.tooth_errors.teeth: {field}", i + 1),
                        format!("tooth {tooth}"),
                        "stiffnessModel = teeth takes index errors and run-out alone",
                        "build without --teeth, with --contact, and set stiffnessModel = contact, which takes it",
                    ));
                }
            }
        }
        Ok(())
    }

    /// Checks all fields against each other and against the pair `geometry`.
    ///
    /// # Errors
    /// The first defect, by field.
    pub fn check(&self, geometry: &PairGeometry) -> Result<(), TableError> {
        let refuse = |field: &str, value: String, reason: &str| {
            Err(TableError::field(
                format!("teeth.{field}"),
                value,
                reason,
                AGAIN,
            ))
        };
        let length = self.last_place - self.first_place;
        if !(length > 0.0 && length <= (MOST - 1) as f64 && self.first_place.abs() < 100.0) {
            let value = format!("{} to {}", self.first_place, self.last_place);
            let reason = format!("places ascend by {} at most", MOST - 1);
            return refuse("first_place, last_place", value, &reason);
        }
        self.grid(Flank::Drive).check("teeth.drive")?;
        self.grid(Flank::Coast).check("teeth.coast")?;
        for flank in [Flank::Drive, Flank::Coast] {
            let (name, rows) = self.coupling(flank);
            let nodes = self.axes.misalignment.len();
            if rows.is_empty() || rows.len() >= MOST {
                let count = format!("{} lists", rows.len());
                let reason = format!("tooth pairs are 1 to {} base pitches apart", MOST - 1);
                return refuse(name, count, &reason);
            }
            for values in rows {
                if ![1, nodes].contains(&values.len()) {
                    let count = format!("{} numbers", values.len());
                    let reason = format!("there are {nodes} misalignments");
                    return refuse(name, count, &reason);
                }
                if let Some(value) = values.iter().find(|c| !(0.0..1.0).contains(*c)) {
                    let reason = "a force on one tooth pair takes of the approach of the others";
                    return refuse(name, value.to_string(), reason);
                }
            }
        }
        for (name, gears) in [
            ("drive_errors", &self.drive_errors),
            ("coast_errors", &self.coast_errors),
        ] {
            for (i, gear) in gears.iter().enumerate() {
                gear.check(&format!("{name}[{i}]"), geometry.gears[i].teeth)?;
            }
        }
        Ok(())
    }

    /// What tooth pairs take of each other on `flank`, from neighbours on, at each misalignment, m/N, and the name of the field
    /// that says so.
    pub(super) fn coupling(&self, flank: Flank) -> (&'static str, Vec<Vec<f64>>) {
        let (name, coupling) = match (flank, &self.coast_coupling_m_per_n) {
            (Flank::Coast, Some(own)) => ("coast_coupling_m_per_n", own),
            _ => ("coupling_m_per_n", &self.coupling_m_per_n),
        };
        let nodes = self.axes.misalignment.len();
        let row = |row: &Vec<f64>| match row[..] {
            [value] => vec![value; nodes],
            _ => row.clone(),
        };
        let rows = coupling.0.iter().map(row).collect();
        (name, rows)
    }

    /// Refuses a coupling on `flank` that is too large: of loads that cancel, the others must take less than a tooth pair gives way.
    /// `gain`: the largest ratio of the two.
    ///
    /// # Errors
    /// It is.
    pub(super) fn check_gain(&self, flank: Flank, gain: f64) -> Result<(), TableError> {
        if gain <= LARGEST_GAIN {
            return Ok(());
        }
        let (name, rows) = self.coupling(flank);
        Err(TableError::field(
            format!("teeth.{name}"),
            format!("{:.3e}", rows.concat().into_iter().fold(0.0, f64::max)),
            format!(
                "other tooth pairs would take {gain:.2} times what one gives way, and only below {LARGEST_GAIN} loads are told apart"
            ),
            "for this pair build without --teeth, with --contact, and set stiffnessModel = contact",
        ))
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
