//! The tables file: versioned JSON with units in its names, the pair it came from, the solver's
//! settings, the interpolation error, and a checksum over all of it.

use super::error::refused;
use super::{
    Axes, FlankGrid, FrictionRecord, RootStressRecord, RootStressSamples, SlidingSamples,
    TableError, TeethRecord,
};
use crate::accuracy::InterpolationError;
use crate::gear::{BodyOrders, Gear, PairGeometry};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

pub const FORMAT: &str = "gearmesh-tables";
/// The version this program writes. It reads version 1, too, which took what a misalignment closes of helical flanks as M z
/// instead of M (z + sigma y): where a file of it depends on that, it is refused.
pub const VERSION: u32 = 2;

const FIRST_VERSION: u32 = 1;

/// Everything in a tables file. Arrays run over (centre distance, misalignment, displacement, mesh
/// position), the last index fastest; the approaches have no displacement index.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableFile {
    /// `FORMAT`.
    pub format: String,
    /// [`VERSION`], or that of the program that wrote it.
    pub version: u32,
    /// Name of the pair.
    pub name: String,
    /// Program and version that made it.
    pub generator: String,
    /// Where the samples come from, in words.
    pub source: String,
    /// SHA-256 in hexadecimal of the file's text with this field empty and without the end of its line.
    pub checksum_sha256: String,
    /// The pair; in the file `gear1`, `gear2` and `center_distance_m`.
    #[serde(with = "by_gear")]
    pub geometry: PairGeometry,
    /// Torque on gear 1 to which errors are related, N m.
    pub nominal_torque_nm: f64,
    /// Largest torque of the table, N m.
    pub maximum_torque_nm: f64,
    /// Settings of the static solver, by name.
    pub solver: BTreeMap<String, serde_json::Value>,
    /// Error of the interpolation against the solver, where it was measured.
    pub interpolation_error: Option<InterpolationError>,
    /// Nodes.
    pub axes: Axes,
    /// Samples of the drive flank.
    pub drive: FlankGrid,
    /// Samples of the coast flank, if its microgeometry differs; otherwise it is the mirrored drive flank.
    pub coast: Option<FlankGrid>,
    /// How the load slides, for the effect `friction`; absent in tables without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<FrictionRecord>,
    /// Stress in the tooth roots, for the outputs of `rootStress`; absent in tables without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub root_stress: Option<RootStressRecord>,
    /// Tooth pairs one by one, for `stiffnessModel = teeth`; absent in tables without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub teeth: Option<TeethRecord>,
    /// How bodies that are no solids of revolution change the compliance with their angle, for the effect `bodyEffect`: all else is of
    /// their mean. Absent in tables of other bodies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bodies: Option<BodyOrders>,
}

/// The geometry of a pair with its gears by name.
mod by_gear {
    use super::{Deserialize, Deserializer, Gear, PairGeometry, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Named {
        gear1: Gear,
        gear2: Gear,
        center_distance_m: f64,
    }

    pub fn serialize<S: Serializer>(pair: &PairGeometry, to: S) -> Result<S::Ok, S::Error> {
        let [gear1, gear2] = pair.gears.clone();
        let center_distance_m = pair.center_distance;
        (Named {
            gear1,
            gear2,
            center_distance_m,
        })
        .serialize(to)
    }

    pub fn deserialize<'d, D: Deserializer<'d>>(from: D) -> Result<PairGeometry, D::Error> {
        let named = Named::deserialize(from)?;
        Ok(PairGeometry {
            gears: [named.gear1, named.gear2],
            center_distance: named.center_distance_m,
        })
    }
}

impl TableFile {
    /// A file around the samples of one or two flanks on the same axes, sealed. `nominal_torque` and
    /// `maximum_torque` in N m on gear 1.
    pub fn new(
        name: &str,
        source: &str,
        geometry: &PairGeometry,
        [nominal_torque, maximum_torque]: [f64; 2],
        drive: &FlankGrid,
        coast: Option<&FlankGrid>,
    ) -> Self {
        let mut file = TableFile {
            format: FORMAT.into(),
            version: VERSION,
            name: name.into(),
            generator: concat!("gearmesh ", env!("CARGO_PKG_VERSION")).into(),
            source: source.into(),
            checksum_sha256: String::new(),
            geometry: geometry.clone(),
            nominal_torque_nm: nominal_torque,
            maximum_torque_nm: maximum_torque,
            solver: BTreeMap::new(),
            interpolation_error: None,
            axes: drive.axes.clone(),
            drive: drive.for_file(geometry),
            coast: coast.map(|coast| coast.for_file(geometry)),
            friction: None,
            root_stress: None,
            teeth: None,
            bodies: None,
        };
        file.seal();
        file
    }

    /// Puts the checksum of the present content in. Call it after every change.
    pub fn seal(&mut self) {
        self.checksum_sha256.clear();
        self.checksum_sha256 = checksum(&self.to_json());
    }

    /// Reads and checks the text of a tables file.
    ///
    /// # Errors
    /// Anything that is not as this program writes it, by field.
    pub fn from_json(text: &str) -> Result<Self, TableError> {
        // Format and version first: a newer file must not fail on a field that this version lacks. Then the checksum: nothing is made
        // of numbers that were altered.
        #[derive(Deserialize)]
        struct Head {
            format: String,
            version: u32,
            #[serde(default)]
            checksum_sha256: String,
        }
        let head: Head = serde_json::from_slice(text.as_bytes())?;
        if head.format != FORMAT {
            let reason =
                format!("a tables file says {FORMAT}; give the file that `gearmesh tables` wrote");
            return refused("format", head.format, reason);
        }
        if !(FIRST_VERSION..=VERSION).contains(&head.version) {
            let reason = format!(
                "this program reads versions {FIRST_VERSION} to {VERSION}; make the tables again with this program, or use the one \
                 that made them"
            );
            return refused("version", head.version, reason);
        }
        let found = format!("{CHECKSUM}{}", head.checksum_sha256);
        let expected = checksum(&text.replacen(&found, CHECKSUM, 1));
        if head.checksum_sha256 != expected {
            let reason = format!(
                "the content gives {expected}, so the file was changed or cut after it was made; make it again with \
                 `gearmesh tables` or `gearmesh import`"
            );
            return refused("checksum_sha256", head.checksum_sha256, reason);
        }
        let file: TableFile = serde_json::from_slice(text.as_bytes())?;
        file.check()?;
        // Whether misalignment or shuttling of helical gears is in it.
        let takes_misalignment = file.axes.misalignment.len() > 1 || file.drive.moment.is_some();
        let is_helical = file.geometry.base_helix_angle() != 0.0;
        if file.version == FIRST_VERSION && is_helical && takes_misalignment {
            let reason = "tables of helical gears of this version take misalignment and shuttling without the slope of the contact \
                          lines in the plane of action, which is off by up to 16 % of the transmission error's variation; make them \
                          again from the pair file with `gearmesh tables` or `gearmesh import`";
            return refused("version", file.version, reason);
        }
        Ok(file)
    }

    /// As [`TableFile::from_json`], from a path.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, TableError> {
        let path = path.as_ref();
        let text = fs::read_to_string(path).map_err(|source| TableError::Io {
            path: path.display().to_string(),
            source,
        })?;
        Self::from_json(&text)
    }

    /// Checks the content, not the checksum.
    ///
    /// # Errors
    /// The first defect, by field.
    pub fn check(&self) -> Result<(), TableError> {
        self.geometry.check()?;
        let (nominal, top) = (self.nominal_torque_nm, self.maximum_torque_nm);
        for (field, torque) in [("nominal_torque_nm", nominal), ("maximum_torque_nm", top)] {
            if !(torque > 0.0 && torque.is_finite()) {
                let reason = "a torque of a table is positive; make the tables again";
                return refused(field, torque, reason);
            }
        }
        self.drive.on(&self.axes).check("drive")?;
        if let Some(coast) = &self.coast {
            coast.on(&self.axes).check("coast")?;
        }
        if let Some(record) = &self.friction {
            let coast = record.coast.as_ref().map(SlidingSamples::columns);
            (record.axes).check("friction", false, record.drive.columns(), coast)?;
        }
        if let Some(record) = &self.root_stress {
            let coast = record.coast.as_ref().map(RootStressSamples::columns);
            (record.axes).check("root_stress", true, record.drive.columns(), coast)?;
        }
        if let Some(bodies) = &self.bodies
            && let Err((value, reason)) = bodies.check()
        {
            return refused("bodies", value, reason);
        }
        self.teeth
            .as_ref()
            .map_or(Ok(()), |teeth| teeth.check(&self.geometry))
    }

    /// The text of the file.
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).expect("plain structs become JSON") + "\n"
    }
}

const CHECKSUM: &str = "\"checksum_sha256\":\"";

fn checksum(unsealed: &str) -> String {
    crate::words::hex(&Sha256::digest(unsealed.trim_end().as_bytes()))
}

#[cfg(test)]
#[path = "file_tests.rs"]
mod tests;
