//! `tooth_errors` of a gear in the pair file: teeth that differ from each other.

use std::path::Path;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::checks::{Range::Within, check};
use super::error::{Refusal, ensure, refusal};
use super::file::PairFile;
use super::mesh_checks::field;
use super::resolve::{UM, gear_file};
use super::topography;
use gearmesh::gear::tolerance::{CLASSES, random_index_errors};
use gearmesh::gear::{
    Flank, Microgeometry, OwnFlank, PairGeometry, PairMicrogeometry, PairTeeth, Runout,
    ToothErrors, WeakTooth,
};
use gearmesh::words::rounded;

/// `tooth_errors` of a gear.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToothErrorsFile {
    /// Index errors of the drive flanks. Default none.
    pub drive_flank: Option<IndexFile>,
    /// Index errors of the coast flanks. Default none.
    pub coast_flank: Option<IndexFile>,
    /// Radial run-out F_r, of both flanks. Default 0.
    #[serde(default)]
    pub runout_um: f64,
    /// Where the teeth stand out most, from tooth 0 in +theta. Default 0.
    #[serde(default)]
    pub runout_angle_deg: f64,
    /// Single teeth. Default none.
    #[serde(default)]
    pub teeth: Vec<ToothFile>,
}

/// Index errors of one flank: a list, or a class with a seed.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IndexFile {
    /// Cumulative pitch deviation of every tooth.
    pub cumulative_pitch_um: Option<Vec<f64>>,
    /// Flank tolerance class of ISO 1328-1 that random errors use up.
    pub pitch_class: Option<u8>,
    /// Which random errors. Default 0.
    #[serde(default)]
    pub seed: u32,
}

/// One tooth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToothFile {
    /// Its number, from 0 in +theta.
    pub tooth: u32,
    /// Compliance under its own load over that of the others. Default 1.
    #[serde(default = "one")]
    pub compliance_factor: f64,
    /// CSV file of its flank, instead of that of the gear. Default: that of the gear.
    pub topography_file: Option<String>,
    /// The flank with that file. Default both.
    #[serde(default)]
    pub flank: ToothFlank,
}

/// `flank` of a tooth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ToothFlank {
    /// Both.
    #[default]
    Both,
    /// The drive flank.
    Drive,
    /// The coast flank.
    Coast,
}

fn one() -> f64 {
    1.0
}

/// Largest compliance factor: a tooth that is all but gone.
const LARGEST_FACTOR: f64 = 100.0;

/// What is to be known of results that take all `teeth` as alike; `None` where they are. It is one of the [`gearmesh::pair::Pair::warnings`], too.
pub fn note_on_teeth(teeth: &PairTeeth) -> Option<&'static str> {
    let text = "the teeth differ (`tooth_errors`): solve, report, study and tables take them as all alike, with the nominal flanks; \
                `stiffnessModel = teeth` of a unit built with --teeth takes index errors and run-out, `contact` of one built with \
                --contact all of them";
    (!teeth.are_alike()).then_some(text)
}

/// Tooth errors of both gears, and what is to be known of them.
pub(super) fn teeth(
    file: &PairFile,
    geometry: &PairGeometry,
    microgeometry: &PairMicrogeometry,
    folder: &Path,
) -> Result<(PairTeeth, Vec<String>), Refusal> {
    let mut all = PairTeeth::default();
    let flanks = [
        (Flank::Drive, &mut all.drive),
        (Flank::Coast, &mut all.coast),
    ];
    for (flank, errors) in flanks {
        for (i, errors) in errors.iter_mut().enumerate() {
            if let Some(given) = &gear_file(file, i).tooth_errors {
                let gear = Teeth {
                    given,
                    geometry,
                    folder,
                    i,
                    flank,
                };
                *errors = gear.errors(&microgeometry.flank(flank)[i])?;
            }
        }
    }
    let notes = note_on_teeth(&all).into_iter().map(str::to_owned).collect();
    Ok((all, notes))
}

/// One flank of one gear.
struct Teeth<'a> {
    given: &'a ToothErrorsFile,
    geometry: &'a PairGeometry,
    folder: &'a Path,
    i: usize,
    flank: Flank,
}

impl Teeth<'_> {
    fn field(&self, name: &str) -> String {
        field(self.i, &format!("tooth_errors.{name}"))
    }

    fn errors(&self, nominal: &Microgeometry) -> Result<ToothErrors, Refusal> {
        let gear = &self.geometry.gears[self.i];
        let most = 0.05 * gear.normal_module / UM;
        let (amount, angle) = (self.given.runout_um, self.given.runout_angle_deg);
        let rows = [
            ("runout_um", Some(amount), Within(0.0, most), None),
            ("runout_angle_deg", Some(angle), Within(-360.0, 360.0), None),
        ];
        check(&self.field(""), &rows)?;
        let mut errors = ToothErrors {
            index: self.index(most)?,
            runout: (amount > 0.0).then(|| Runout {
                amount: amount * UM,
                angle: angle.to_radians(),
            }),
            ..ToothErrors::default()
        };
        for (place, tooth) in self.given.teeth.iter().enumerate() {
            let name = |name: &str| self.field(&format!("teeth[{place}].{name}"));
            let number = tooth.tooth;
            ensure!(number < gear.teeth, name("tooth") => number;
                "is no tooth of a gear of {}", gear.teeth; "give a number from 0 to {}", gear.teeth - 1);
            let is_again = self.given.teeth[..place].iter().any(|t| t.tooth == number);
            ensure!(!is_again, name("tooth") => number;
                "stands in the list twice"; "give a tooth once, with all that is its own");
            let factor = tooth.compliance_factor;
            let row = (
                "compliance_factor",
                Some(factor),
                Within(1.0, LARGEST_FACTOR),
                None,
            );
            check(&name(""), &[row])?;
            if factor > 1.0 {
                let tooth = number;
                errors.weak.push(WeakTooth { tooth, factor });
            }
            let other =
                [ToothFlank::Coast, ToothFlank::Drive][usize::from(self.flank == Flank::Coast)];
            if let Some(file) = tooth
                .topography_file
                .as_ref()
                .filter(|_| tooth.flank != other)
            {
                let g = self.geometry;
                let start = g.active_start_roll(self.i, g.center_distance);
                let rolls = [start, gear.tip_form_roll()];
                let path = self.folder.join(file);
                let read = topography::read(&path, &name("topography_file"), gear, rolls)?;
                errors.flanks.push(OwnFlank {
                    tooth: number,
                    microgeometry: Microgeometry {
                        topography: Some(Arc::new(read)),
                        ..nominal.clone()
                    },
                });
            }
        }
        Ok(errors)
    }

    /// Index errors of the flank, m; `most` is the largest, um.
    fn index(&self, most: f64) -> Result<Vec<f64>, Refusal> {
        let gear = &self.geometry.gears[self.i];
        let (part, given) = match self.flank {
            Flank::Drive => ("drive_flank", &self.given.drive_flank),
            Flank::Coast => ("coast_flank", &self.given.coast_flank),
        };
        let Some(given) = given else {
            return Ok(Vec::new());
        };
        let name = |name: &str| self.field(&format!("{part}.{name}"));
        match (&given.cumulative_pitch_um, given.pitch_class) {
            (Some(list), None) => {
                ensure!(list.len() == gear.teeth as usize,
                    name("cumulative_pitch_um") => format!("{} numbers", list.len());
                    "the gear has {} teeth", gear.teeth; "give one number for every tooth");
                for (tooth, um) in list.iter().enumerate() {
                    let field = name(&format!("cumulative_pitch_um[{tooth}]"));
                    check(&field, &[("", Some(*um), Within(-most, most), None)])?;
                }
                let all_zero = list.iter().all(|um| *um == 0.0);
                let errors = list.iter().filter(|_| !all_zero).map(|um| um * UM);
                Ok(errors.collect())
            }
            (None, Some(class)) => {
                ensure!(CLASSES.contains(&class), name("pitch_class") => class;
                    "is no flank tolerance class of ISO 1328-1";
                    "give one from {} to {}", CLASSES.start(), CLASSES.end());
                let errors = random_index_errors(gear, class, given.seed);
                let largest = errors.iter().fold(0.0f64, |m, e| m.max(e.abs())) / UM;
                ensure!(largest <= most, name("pitch_class") => class;
                    "gives index errors above a twentieth of the normal module, {} um", rounded(most);
                    "give a finer class");
                Ok(errors)
            }
            (given, _) => {
                let (value, problem) = match given {
                    Some(_) => (
                        "two sources",
                        "`cumulative_pitch_um` and `pitch_class` both say what the errors are",
                    ),
                    None => ("{}", "says nothing of the errors"),
                };
                Err(refusal!(self.field(part) => value; "{problem}";
                    "give `cumulative_pitch_um`, one number for every tooth, or `pitch_class` with a `seed`"))
            }
        }
    }
}
