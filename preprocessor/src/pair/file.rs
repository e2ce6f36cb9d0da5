//! The pair file as it is written: JSON, the unit in every name.
//!
//! These types say which fields there are, what is optional and what stands in for it; docs/pair-file.md says what they mean.

use super::dimension::Dimension;
use crate::gear::Refinement;
use gearmesh::gear::ReliefShape;
use serde::de::{self, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;
use std::marker::PhantomData;

/// Metres in a millimetre.
pub(super) const MM: f64 = 1e-3;
/// Metres in a micrometre.
pub(super) const UM: f64 = 1e-6;

/// m, of a diameter in mm.
pub(super) fn radius_of(diameter_mm: f64) -> f64 {
    0.5 * diameter_mm * MM
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PairFile {
    pub name: String,
    pub source: Option<String>,
    pub meshing: Meshing,
    pub normal_module_mm: f64,
    pub normal_pressure_angle_deg: f64,
    /// > 0: gear 1 right-handed. Default: that of `lead_mm`, else 0.
    pub helix_angle_deg: Option<f64>,
    /// Default: without backlash.
    pub center_distance_mm: Option<f64>,
    /// Circumferential, at the operating pitch circle. Default: what centre distance and profile shifts leave.
    pub backlash_um: Option<f64>,
    /// j_bn, in place of `backlash_um`.
    pub normal_backlash_um: Option<Dimension>,
    pub face_offset_mm: Option<f64>,
    /// Of the centre distance. Default 0.
    pub housing_thermal_expansion_um_per_m_k: Option<f64>,
    pub gear1: GearFile,
    pub gear2: GearFile,
    pub operating: OperatingFile,
    #[serde(default)]
    pub compliance: ComplianceFile,
    #[serde(default = "yes")]
    pub tip_corner_contact: bool,
    pub friction: Option<FrictionFile>,
}

impl PairFile {
    /// Gear `i`, 0 or 1.
    pub fn gear(&self, i: usize) -> &GearFile {
        [&self.gear1, &self.gear2][i]
    }

    /// Which gear is the ring: gear 2 of an internal pair, or gear 1 when it alone has a rim or negative teeth.
    pub fn ring(&self) -> Option<usize> {
        let [first, second] =
            [&self.gear1, &self.gear2].map(|gear| gear.rim_diameter_mm.is_some() || gear.teeth < 0);
        let ring = usize::from(second || !first);
        (self.meshing == Meshing::Internal).then_some(ring)
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Meshing {
    External,
    Internal,
}

/// A struct with the modifications of a flank after its own fields. One that is flattened into both would lose line and
/// column of what is wrong in it.
macro_rules! with_modifications {
    ($(#[$doc:meta])* pub struct $name:ident { $($own:tt)* }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct $name {
            $($own)*
            pub tip_relief: Option<ReliefFile>,
            pub root_relief: Option<ReliefFile>,
            pub profile_crowning_um: Option<f64>,
            /// Removal at the tip minus that at the start of the active profile, -C_Ha cos beta_b.
            pub profile_slope_um: Option<f64>,
            /// Profile slope at z = face width minus that at z = 0.
            pub bias_um: Option<f64>,
            pub lead_crowning_um: Option<f64>,
            /// Removal at z = face width minus that at z = 0.
            pub lead_slope_um: Option<f64>,
            pub end_relief: Option<EndReliefFile>,
            /// At z = 0 instead of `end_relief`.
            pub lower_end_relief: Option<EndReliefFile>,
            /// At z = face width instead of `end_relief`.
            pub upper_end_relief: Option<EndReliefFile>,
            /// CSV file of a measured or designed flank, in addition to all others.
            pub topography_file: Option<String>,
        }
    };
}

/// Reads a whole number, also one with a fraction of zero, as tools write it that know no other numbers. A visitor, since
/// only what it refuses keeps its line and column.
struct WholeVisitor<N>(PhantomData<N>);

impl<N: TryFrom<i64>> Visitor<'_> for WholeVisitor<N> {
    type Value = N;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(std::any::type_name::<N>())
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<N, E> {
        // Beyond 2^53 there are no fractions.
        let whole = (value.fract() == 0.0 && value.abs() <= 9e15).then_some(value as i64);
        let given = format!("`{value}`");
        whole
            .and_then(|whole| N::try_from(whole).ok())
            .ok_or_else(|| E::invalid_value(Unexpected::Other(&given), &self))
    }

    fn visit_i64<E: de::Error>(self, value: i64) -> Result<N, E> {
        self.visit_f64(value as f64)
    }

    fn visit_u64<E: de::Error>(self, value: u64) -> Result<N, E> {
        self.visit_f64(value as f64)
    }
}

fn whole<'de, D: Deserializer<'de>, N: TryFrom<i64>>(fields: D) -> Result<N, D::Error> {
    fields.deserialize_f64(WholeVisitor(PhantomData))
}

fn some_whole<'de, D: Deserializer<'de>, N: TryFrom<i64>>(
    fields: D,
) -> Result<Option<N>, D::Error> {
    #[derive(Deserialize)]
    #[serde(bound = "N: TryFrom<i64>")]
    struct Whole<N>(#[serde(deserialize_with = "whole")] N);
    Ok(Option::<Whole<N>>::deserialize(fields)?.map(|number| number.0))
}

with_modifications! {
    /// One gear of the file.
    pub struct GearFile {
        /// Negative for a ring in the signs of ISO 21771.
        #[serde(deserialize_with = "whole")]
        pub teeth: i32,
        /// > 0 thickens teeth, widens the spaces of a ring. Default: what the quantities of the drawing say, else 0.
        pub profile_shift: Option<f64>,
        /// In its place: > 0 thickens the teeth of a ring, too.
        pub profile_shift_iso_21771: Option<f64>,
        /// s_n on the reference circle.
        pub normal_tooth_thickness_mm: Option<Dimension>,
        /// W_k over `span_teeth` teeth (ring: spaces).
        pub span_measurement_mm: Option<Dimension>,
        #[serde(default, deserialize_with = "some_whole")]
        pub span_teeth: Option<i32>,
        /// M_dK (ring: between balls).
        pub dimension_over_balls_mm: Option<Dimension>,
        pub ball_diameter_mm: Option<f64>,
        /// In place of the dedendum.
        pub root_diameter_mm: Option<Dimension>,
        /// > 0 right-handed, in place of the helix angle.
        pub lead_mm: Option<f64>,
        pub face_width_mm: f64,
        /// Default: from `addendum_coefficient`.
        pub tip_diameter_mm: Option<f64>,
        /// d_Fa. Default: the tip diameter.
        pub tip_form_diameter_mm: Option<f64>,
        /// d_Ff. Default: where the fillet ends.
        pub root_form_diameter_mm: Option<f64>,
        /// Default 1.0; only without `tip_diameter_mm`.
        pub addendum_coefficient: Option<f64>,
        /// Default: that of `root_diameter_mm`, else 1.25.
        pub dedendum_coefficient: Option<f64>,
        /// Ring: radius of the fillet. Default: 0.38, or the largest that fits.
        pub tool_tip_radius_coefficient: Option<f64>,
        /// External gears. Default: half of the root diameter.
        pub bore_diameter_mm: Option<f64>,
        /// Makes this gear the ring of an internal pair. Default for gear 2 of one: a rim of 3.5 modules.
        pub rim_diameter_mm: Option<f64>,
        /// External gears, with `web_thickness_mm`. Default: a full disc.
        pub rim_thickness_mm: Option<f64>,
        pub web_thickness_mm: Option<f64>,
        /// Middle of the web less mid-face.
        pub web_offset_mm: Option<f64>,
        /// Default: no hub, the web reaches the bore.
        pub hub_diameter_mm: Option<f64>,
        /// Default: the face width.
        pub hub_width_mm: Option<f64>,
        pub hub_offset_mm: Option<f64>,
        /// In place of rim, web and hub; external gears. `bore_diameter_mm` is then its bore, free; default: solid.
        pub shaft: Option<ShaftFile>,
        /// In place of bore, rim, web and hub, and of the rim of a ring.
        pub body_matrix: Option<BodyMatrixFile>,
        /// Through the web, or the disc, of an external gear.
        pub web_holes: Option<HolesFile>,
        /// Of a ring, whose outside is then free.
        pub rim_pins: Option<HolesFile>,
        /// Of a ring, whose outside is held there alone.
        pub rim_supports: Option<SupportsFile>,
        /// Default: rigid.
        pub rim_foundation_n_per_mm3: Option<f64>,
        /// Default 206.
        pub youngs_modulus_gpa: Option<f64>,
        /// [°C, GPa], ascending, in place of `youngs_modulus_gpa`.
        pub youngs_modulus_over_temperature: Option<Vec<[f64; 2]>>,
        /// Linear. Default 0.
        pub thermal_expansion_um_per_m_k: Option<f64>,
        #[serde(default = "default_poisson_ratio")]
        pub poisson_ratio: f64,
        pub drive_flank: Option<FlankFile>,
        pub coast_flank: Option<FlankFile>,
        pub tooth_errors: Option<ToothErrorsFile>,
    }
}

with_modifications! {
    /// Modifications of one flank: those of [`GearFile`], which it replaces one by one.
    #[derive(Default)]
    pub struct FlankFile {}
}

impl FlankFile {
    /// The end reliefs that are given, by field.
    pub fn end_reliefs(&self) -> impl Iterator<Item = (&'static str, &EndReliefFile)> {
        let all = [
            ("end_relief", &self.end_relief),
            ("lower_end_relief", &self.lower_end_relief),
            ("upper_end_relief", &self.upper_end_relief),
        ];
        (all.into_iter()).filter_map(|(field, relief)| Some((field, relief.as_ref()?)))
    }
}

impl GearFile {
    /// Without the sign of a ring.
    pub fn number_of_teeth(&self) -> u32 {
        self.teeth.unsigned_abs()
    }

    /// Whether nothing says where the tips are.
    pub fn has_default_tip(&self) -> bool {
        self.tip_diameter_mm.is_none() && self.addendum_coefficient.is_none()
    }

    /// Modifications of both flanks and of each, with the start of the path of their fields.
    pub fn flanks(&self) -> [(&'static str, FlankFile); 3] {
        macro_rules! copied {
            ($($field:ident)*) => { FlankFile { $($field: self.$field.clone(),)* } };
        }
        let both = copied! {
            tip_relief root_relief profile_crowning_um profile_slope_um bias_um lead_crowning_um lead_slope_um
            end_relief lower_end_relief upper_end_relief topography_file
        };
        [
            ("", both),
            ("drive_flank.", self.drive_flank.clone().unwrap_or_default()),
            ("coast_flank.", self.coast_flank.clone().unwrap_or_default()),
        ]
    }
}

/// `body_matrix` of a gear: the stiffness of its body, supports included, at nodes on a cylinder below the teeth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyMatrixFile {
    /// CSV with x_mm, y_mm, z_mm.
    pub nodes_file: String,
    /// Matrix Market.
    pub stiffness_n_per_mm_file: String,
    /// From body +x of the gear to the x axis of the nodes. Default 0.
    #[serde(default)]
    pub angle_deg: f64,
}

/// Equal round holes, or pins, at equal distances.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HolesFile {
    #[serde(deserialize_with = "whole")]
    pub count: u32,
    /// Through their middles.
    pub circle_diameter_mm: f64,
    pub diameter_mm: f64,
    /// From body +x to one of them. Default 0.
    #[serde(default)]
    pub angle_deg: f64,
}

/// Equal parts of the outside of a ring at equal distances.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SupportsFile {
    #[serde(deserialize_with = "whole")]
    pub count: u32,
    pub width_deg: f64,
    /// From body +x to the middle of one of them. Default 0.
    #[serde(default)]
    pub angle_deg: f64,
}

/// `shaft` of a gear: its pieces on both sides of the face, up to where the shaft of the multibody model takes over, and the
/// whole shaft on its bearings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShaftFile {
    pub lower: Option<ShaftPieceFile>,
    pub upper: Option<ShaftPieceFile>,
    /// Which ends are held. Default: that of the only piece; of two it must be said.
    pub held: Option<HeldEnds>,
    /// The whole shaft from low to high z, for static analyses on its bearings.
    pub sections: Option<Vec<ShaftSectionFile>>,
    /// Lower end of the first section, from the gear's z = 0 face; required with `sections`, as are the next two.
    pub start_mm: Option<f64>,
    pub bearings: Option<Vec<BearingFile>>,
    /// Where the torque enters or leaves.
    pub torque_end: Option<ShaftEnd>,
    /// Diameter up to which the gear stiffens the shaft. Default: root circle, or outside of the hub.
    pub seat_diameter_mm: Option<f64>,
    /// Of the shaft. Default 206.
    pub youngs_modulus_gpa: Option<f64>,
    /// Of the shaft. Default 0.3.
    pub poisson_ratio: Option<f64>,
}

impl ShaftFile {
    /// Whether it says what the finite-element model has of the shaft.
    pub fn has_pieces(&self) -> bool {
        self.lower.is_some() || self.upper.is_some() || self.held.is_some()
    }

    /// What it says of the shaft on bearings first, by field.
    pub fn field_of_bearings(&self) -> Option<&'static str> {
        let fields = [
            ("sections", self.sections.is_some()),
            ("bearings", self.bearings.is_some()),
            ("start_mm", self.start_mm.is_some()),
            ("torque_end", self.torque_end.is_some()),
            ("seat_diameter_mm", self.seat_diameter_mm.is_some()),
        ];
        fields
            .into_iter()
            .find(|(_, given)| *given)
            .map(|(name, _)| name)
    }

    /// Diameter of the section at `z_mm`.
    pub fn diameter_at(&self, z_mm: f64) -> Option<f64> {
        let mut end = self.start_mm?;
        Some(
            self.sections
                .as_ref()?
                .iter()
                .find(|section| {
                    end += section.length_mm;
                    z_mm <= end
                })?
                .diameter_mm,
        )
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShaftSectionFile {
    pub diameter_mm: f64,
    pub length_mm: f64,
    /// Default 0.
    pub inner_diameter_mm: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BearingFile {
    /// From the gear's z = 0 face.
    pub z_mm: f64,
    pub radial_stiffness_n_per_um: f64,
    /// Default 0.
    pub axial_stiffness_n_per_um: Option<f64>,
    /// Default 0.
    pub tilt_stiffness_nm_per_mrad: Option<f64>,
    /// Radial internal clearance of ISO 5753-1. Default 0.
    pub radial_clearance_um: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ShaftEnd {
    Lower,
    Upper,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShaftPieceFile {
    pub diameter_mm: f64,
    /// From the face.
    pub length_mm: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HeldEnds {
    Lower,
    Upper,
    Both,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReliefFile {
    /// Removal at the tip (root relief: at the start of the active profile).
    pub amount_um: f64,
    #[serde(default)]
    pub start: ReliefStart,
    #[serde(default)]
    pub shape: ReliefShape,
}

#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReliefStart {
    /// At the operating pitch circle of the nominal centre distance.
    #[default]
    PitchPoint,
    DiameterMm(f64),
    RollLengthMm(f64),
    /// At this roll angle: the length of roll over the base radius.
    RollAngleDeg(f64),
    /// This length of roll before the end of the involute at the tip.
    FromTipMm(f64),
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EndReliefFile {
    pub amount_um: f64,
    pub length_mm: f64,
    #[serde(default)]
    pub shape: ReliefShape,
}

/// `operating` of the file. Ranges hold zero and count from the nominal state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OperatingFile {
    pub nominal_torque_nm: f64,
    pub maximum_torque_nm: f64,
    pub center_distance_offset_um: [f64; 2],
    /// Default: what the shafts on bearings cause.
    pub misalignment_mrad: Option<[f64; 2]>,
    /// Of the gears and the housing. Default 20, as of the drawing.
    pub temperature_c: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComplianceFile {
    #[serde(default)]
    pub refinement: Refinement,
}

/// `friction` of the file. Fields that the law does not ask for may be there.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionFile {
    #[serde(default)]
    pub law: FrictionLawFile,
    /// Of the law `constant`. Default 0.05.
    pub coefficient: Option<f64>,
    /// Required by the others, as is `roughness_ra_um`.
    pub dynamic_viscosity_mpa_s: Option<f64>,
    /// X_L of `schlenk`. Default: mineral oil.
    pub lubricant_factor: Option<f64>,
    pub roughness_ra_um: Option<[f64; 2]>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FrictionLawFile {
    #[default]
    Constant,
    /// Mean over the mesh, ISO/TR 14179-2.
    Schlenk,
    /// Local, Xu and Kahraman 2007.
    XuKahraman,
}

/// `tooth_errors` of a gear.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToothErrorsFile {
    pub drive_flank: Option<IndexFile>,
    pub coast_flank: Option<IndexFile>,
    #[serde(default)]
    pub runout_um: f64,
    /// Where the teeth stand out most, from tooth 0 in +theta.
    #[serde(default)]
    pub runout_angle_deg: f64,
    #[serde(default)]
    pub teeth: Vec<ToothFile>,
}

/// Index errors of one flank: a list, or a class with a seed.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IndexFile {
    pub cumulative_pitch_um: Option<Vec<f64>>,
    /// Flank tolerance class of ISO 1328-1 that random errors use up.
    #[serde(default, deserialize_with = "some_whole")]
    pub pitch_class: Option<u8>,
    #[serde(default, deserialize_with = "whole")]
    pub seed: u32,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToothFile {
    /// Its number, from 0 in +theta.
    #[serde(deserialize_with = "whole")]
    pub tooth: u32,
    /// Under its own load, over that of the others.
    #[serde(default = "one")]
    pub compliance_factor: f64,
    /// Instead of that of the gear.
    pub topography_file: Option<String>,
    #[serde(default)]
    pub flank: ToothFlank,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ToothFlank {
    #[default]
    Both,
    Drive,
    Coast,
}

fn one() -> f64 {
    1.0
}

fn yes() -> bool {
    true
}

fn default_poisson_ratio() -> f64 {
    0.3
}
