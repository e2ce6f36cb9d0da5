//! `tooth_errors` of the pair file: teeth that differ from each other.

use super::checks::{check, in_gear, limits};
use super::error::{Refusal, ensure, refusal};
use super::file::{ToothErrorsFile, ToothFlank, UM};
use super::flanks::Flanks;
use gearmesh::gear::tolerance::{CLASSES, random_index_errors};
use gearmesh::gear::{Flank, Gear, Microgeometry, OwnFlank, Runout, ToothErrors, WeakTooth};
use gearmesh::words::rounded;

/// Largest compliance factor: a tooth that is all but gone.
const LARGEST_FACTOR: f64 = 100.0;

/// Tooth errors of `flank` of the gear of `flanks`, whose other teeth have the flank `nominal`.
pub(super) fn tooth_errors(
    flanks: &Flanks,
    flank: Flank,
    nominal: &Microgeometry,
) -> Result<ToothErrors, Refusal> {
    let Some(given) = &flanks.file.gear(flanks.i).tooth_errors else {
        return Ok(ToothErrors::default());
    };
    let gear = &flanks.geometry.gears[flanks.i];
    let path = in_gear(flanks.i, "tooth_errors.");
    limits! { path, given;
        runout_um: [0.0, largest(gear)];
        runout_angle_deg: [-360.0, 360.0];
    }
    let mut errors = ToothErrors {
        index: index(given, gear, flank, &path)?,
        runout: (given.runout_um > 0.0).then(|| Runout {
            amount: given.runout_um * UM,
            angle: given.runout_angle_deg.to_radians(),
        }),
        ..ToothErrors::default()
    };
    let other = match flank {
        Flank::Drive => ToothFlank::Coast,
        Flank::Coast => ToothFlank::Drive,
    };
    for (place, own) in given.teeth.iter().enumerate() {
        let (path, tooth) = (format!("{path}teeth[{place}]."), own.tooth);
        check(
            &format!("{path}tooth"),
            f64::from(tooth),
            [0.0, gear.z() - 1.0],
        )?;
        let is_again = given.teeth[..place].iter().any(|t| t.tooth == tooth);
        ensure!(!is_again, format!("{path}tooth") => tooth;
            "stands in the list twice"; "give a tooth once, with all that is its own");
        limits! { path, own; compliance_factor: [1.0, LARGEST_FACTOR]; }
        let factor = own.compliance_factor;
        if factor > 1.0 {
            errors.weak.push(WeakTooth { tooth, factor });
        }
        let file = own.topography_file.as_ref();
        if let Some(file) = file.filter(|_| own.flank != other) {
            let topography = flanks.topography(file, &format!("{path}topography_file"))?;
            let mut microgeometry = nominal.clone();
            microgeometry.topography = Some(topography);
            errors.flanks.push(OwnFlank {
                tooth,
                microgeometry,
            });
        }
    }
    Ok(errors)
}

/// Largest index error and run-out, um.
fn largest(gear: &Gear) -> f64 {
    0.05 * gear.normal_module / UM
}

/// Index errors of the flank, m.
fn index(
    given: &ToothErrorsFile,
    gear: &Gear,
    flank: Flank,
    path: &str,
) -> Result<Vec<f64>, Refusal> {
    let (part, given) = match flank {
        Flank::Drive => ("drive_flank", &given.drive_flank),
        Flank::Coast => ("coast_flank", &given.coast_flank),
    };
    let Some(given) = given else {
        return Ok(Vec::new());
    };
    let (path, most) = (format!("{path}{part}"), largest(gear));
    let (list, class) = (&given.cumulative_pitch_um, given.pitch_class);
    let problem = match (list, class) {
        (Some(list), None) => {
            let path = format!("{path}.cumulative_pitch_um");
            ensure!(list.len() == gear.teeth as usize, path => format!("{} numbers", list.len());
                "the gear has {} teeth", gear.teeth; "give one number for every tooth");
            for (tooth, um) in list.iter().enumerate() {
                check(&format!("{path}[{tooth}]"), *um, [-most, most])?;
            }
            let all_zero = list.iter().all(|um| *um == 0.0);
            let errors = list.iter().filter(|_| !all_zero).map(|um| um * UM);
            return Ok(errors.collect());
        }
        (None, Some(class)) => {
            let path = format!("{path}.pitch_class");
            let classes = [*CLASSES.start(), *CLASSES.end()].map(f64::from);
            check(&path, f64::from(class), classes)?;
            let errors = random_index_errors(gear, class, given.seed);
            let largest = errors.iter().fold(0.0f64, |m, e| m.max(e.abs())) / UM;
            ensure!(largest <= most, path => class;
                "gives index errors above a twentieth of the normal module, {} um", rounded(most);
                "give a finer class");
            return Ok(errors);
        }
        (Some(_), Some(_)) => {
            "`cumulative_pitch_um` and `pitch_class` both say what the errors are"
        }
        (None, None) => "says nothing of the errors",
    };
    let value = if list.is_some() { "two sources" } else { "{}" };
    Err(refusal!(path => value; "{problem}";
        "give `cumulative_pitch_um`, one number for every tooth, or `pitch_class` with a `seed`"))
}
