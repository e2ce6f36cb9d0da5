//! The contact of a pair in the resources of a unit: what a solve at run time needs.
//!
//! [`sealed`]: length of the head, head (JSON), influence matrices (32-bit floats); little endian.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::condensed::CondensedFlank;
use super::runtime::RuntimeContact;
use super::setup::ContactSetup;
use crate::gear::Flank;
use crate::sealed;
use crate::table::InterpolationError;

/// Changes with the layout.
const MAGIC: &[u8; 32] = b"gearmesh condensed contact v002\n";

/// Contact of both flanks.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactFile {
    /// The pair without its elastic model.
    pub setup: Arc<ContactSetup>,
    /// Drive flank.
    pub drive: Arc<CondensedFlank>,
    /// Coast flank, if it is not the drive flank's mirror image.
    pub coast: Option<Arc<CondensedFlank>>,
    /// How far force and shuttling moment are, all teeth taken as alike, from those of static contact on more stations; `None`:
    /// not measured.
    pub error: Option<InterpolationError>,
}

/// The head, in which the matrices are empty.
#[derive(Serialize, Deserialize)]
struct Head {
    setup: ContactSetup,
    drive: CondensedFlank,
    coast: Option<CondensedFlank>,
    #[serde(default)]
    error: Option<InterpolationError>,
}

impl ContactFile {
    /// The contact of `flank`; `None`: the drive flank's, mirrored.
    pub fn flank(&self, flank: Flank) -> Option<RuntimeContact> {
        let condensed = match flank {
            Flank::Drive => &self.drive,
            Flank::Coast => self.coast.as_ref()?,
        };
        let (setup, condensed) = (self.setup.clone(), condensed.clone());
        Some(RuntimeContact::new(setup, condensed, flank))
    }

    /// The bytes of the file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let bare = |flank: &CondensedFlank| CondensedFlank {
            values: Vec::new(),
            ..flank.clone()
        };
        let head = Head {
            setup: (*self.setup).clone(),
            drive: bare(&self.drive),
            coast: self.coast.as_deref().map(bare),
            error: self.error,
        };
        let head = serde_json::to_vec(&head).expect("plain structs become JSON");
        let mut bytes = (head.len() as u64).to_le_bytes().to_vec();
        bytes.extend(head);
        for flank in [Some(&self.drive), self.coast.as_ref()]
            .into_iter()
            .flatten()
        {
            bytes.extend(flank.values.iter().flat_map(|value| value.to_le_bytes()));
        }
        sealed::seal(MAGIC, &bytes)
    }

    /// Reads the bytes of a file.
    ///
    /// # Errors
    /// What is wrong with them, as text.
    pub fn from_bytes(bytes: &[u8]) -> Result<ContactFile, String> {
        let bytes = sealed::open(MAGIC, bytes)?;
        let (length, rest) = bytes.split_first_chunk::<8>().ok_or("it has no head")?;
        let (head, values) = usize::try_from(u64::from_le_bytes(*length))
            .ok()
            .and_then(|length| rest.split_at_checked(length))
            .ok_or("the head is longer than the file")?;
        let head: Head = serde_json::from_slice(head).map_err(|e| e.to_string())?;
        head.setup.check()?;
        let mut rest = values.chunks_exact(4);
        let mut filled = |mut flank: CondensedFlank| -> Result<Arc<CondensedFlank>, String> {
            let count = flank.value_count().ok_or("a grid without nodes")?;
            let stations = head.setup.settings.stations;
            if flank.stations != stations {
                return Err(format!(
                    "{} stations of a flank are not the {stations} of the contact",
                    flank.stations
                ));
            }
            flank.values = rest
                .by_ref()
                .take(count)
                .map(|v| f32::from_le_bytes([v[0], v[1], v[2], v[3]]))
                .collect();
            if flank.values.len() != count || flank.values.iter().any(|v| !v.is_finite()) {
                return Err(format!("{count} finite values of a flank are not there"));
            }
            Ok(Arc::new(flank))
        };
        let (drive, coast) = (
            filled(head.drive)?,
            head.coast.map(&mut filled).transpose()?,
        );
        if rest.next().is_some() || !rest.remainder().is_empty() {
            return Err("there are more values than those of its flanks".into());
        }
        Ok(ContactFile {
            drive,
            coast,
            setup: Arc::new(head.setup),
            error: head.error,
        })
    }
}
