//! The pair file as it is written: JSON, the unit in every name.
//!
//! These types say which fields there are and what is optional; [`super::Pair`] is the checked result in SI.

use gearmesh::gear::ReliefShape;
use gearmesh::pair::Refinement;
use gearmesh::words::rounded;
use serde::{Deserialize, Serialize};

/// Metres in a millimetre.
pub(super) const MM: f64 = 1e-3;
/// Metres in a micrometre.
pub(super) const UM: f64 = 1e-6;

/// A dimension of a drawing: a number, or its limits, of which the middle counts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged, try_from = "serde_json::Value")]
pub enum Dimension {
    Nominal(f64),
    Limits([f64; 2]),
}

impl TryFrom<serde_json::Value> for Dimension {
    type Error = String;

    fn try_from(value: serde_json::Value) -> Result<Dimension, String> {
        let limit = |i: usize| value.get(i)?.as_f64();
        let count = value.as_array().map_or(0, Vec::len);
        match (value.as_f64(), count, limit(0), limit(1)) {
            (Some(number), ..) => Ok(Dimension::Nominal(number)),
            (_, 2, Some(a), Some(b)) if a <= b => Ok(Dimension::Limits([a, b])),
            (_, 2, Some(_), Some(_)) => {
                Err(format!("`{value}`; the lower limit first is expected"))
            }
            _ => Err(format!(
                "`{value}`; a bare number or [lower, upper] is expected"
            )),
        }
    }
}

impl Dimension {
    pub fn middle(self) -> f64 {
        match self {
            Dimension::Nominal(value) => value,
            Dimension::Limits([low, high]) => 0.5 * (low + high),
        }
    }

    pub(super) fn slack(self) -> f64 {
        match self {
            Dimension::Nominal(_) => 0.0,
            Dimension::Limits([low, high]) => 0.5 * (high - low),
        }
    }
}

impl std::fmt::Display for Dimension {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match *self {
            Dimension::Nominal(value) => write!(f, "{}", rounded(value)),
            Dimension::Limits([low, high]) => write!(f, "[{}, {}]", rounded(low), rounded(high)),
        }
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PairFile {
    /// Name of the pair, used for files and titles.
    pub name: String,
    /// Where the numbers come from; free text.
    pub source: Option<String>,
    pub meshing: Meshing,
    pub normal_module_mm: f64,
    /// Normal pressure angle of the basic rack, degrees.
    pub normal_pressure_angle_deg: f64,
    /// Helix angle at the reference cylinder, degrees; > 0: gear 1 right-handed. Default: that of `lead_mm`, else 0.
    pub helix_angle_deg: Option<f64>,
    /// Default: the centre distance without backlash that follows from the profile shifts.
    pub center_distance_mm: Option<f64>,
    /// Circumferential backlash at the operating pitch circle and nominal centre distance, both gears
    /// together. Default: what centre distance and profile shifts leave.
    pub backlash_um: Option<f64>,
    /// Backlash normal to the flanks j_bn in place of `backlash_um`.
    pub normal_backlash_um: Option<Dimension>,
    /// z of gear 2's z = 0 face minus gear 1's. Default 0.
    pub face_offset_mm: Option<f64>,
    pub gear1: GearFile,
    pub gear2: GearFile,
    /// Loads and deviations to be covered.
    pub operating: OperatingFile,
    /// Elastic model. Default: normal refinement.
    #[serde(default)]
    pub compliance: ComplianceFile,
    /// Whether contact of tip corners outside the path of contact is counted. Default true.
    #[serde(default = "yes")]
    pub tip_corner_contact: bool,
    /// Coefficient of friction. Default: the constant 0.05.
    pub friction: Option<FrictionFile>,
}

impl PairFile {
    /// Gear `i`, 0 or 1.
    pub fn gear(&self, i: usize) -> &GearFile {
        [&self.gear1, &self.gear2][i]
    }

    /// Which gear is the ring: gear 2 of an internal pair, or gear 1 when it alone has a rim.
    pub fn ring(&self) -> Option<usize> {
        let has_rim = |g: &GearFile| g.rim_diameter_mm.is_some();
        let ring = usize::from(has_rim(&self.gear2) || !has_rim(&self.gear1));
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
            /// Profile crowning: removal at both ends of the active profile. Default 0.
            pub profile_crowning_um: Option<f64>,
            /// Profile slope: removal at the tip minus that at the start of the active profile, -C_Ha. Default 0.
            pub profile_slope_um: Option<f64>,
            /// Bias: profile slope at z = face width minus that at z = 0. Default 0.
            pub bias_um: Option<f64>,
            /// Lead crowning: removal at both ends of the face. Default 0.
            pub lead_crowning_um: Option<f64>,
            /// Removal at the z = face width end minus that at z = 0, zero at mid-face. Default 0.
            pub lead_slope_um: Option<f64>,
            /// End relief at both ends. Default none.
            pub end_relief: Option<EndReliefFile>,
            /// End relief at z = 0 instead of `end_relief`.
            pub lower_end_relief: Option<EndReliefFile>,
            /// End relief at z = face width instead of `end_relief`.
            pub upper_end_relief: Option<EndReliefFile>,
            /// CSV file of a measured or designed flank, in addition to all others. Default none.
            pub topography_file: Option<String>,
        }
    };
}

with_modifications! {
    /// One gear of the file.
    pub struct GearFile {
        /// Number of teeth, positive for a ring, too.
        pub teeth: u32,
        /// Profile shift coefficient; > 0 thickens teeth, widens the spaces of a ring. Default: what the quantities of the
        /// drawing say, else 0.
        pub profile_shift: Option<f64>,
        /// Profile shift coefficient in the sign of ISO 21771 in its place: > 0 thickens the teeth of a ring, too.
        pub profile_shift_iso_21771: Option<f64>,
        /// Normal tooth thickness s_n on the reference circle.
        pub normal_tooth_thickness_mm: Option<Dimension>,
        /// Span W_k over `span_teeth` teeth (ring: spaces).
        pub span_measurement_mm: Option<Dimension>,
        pub span_teeth: Option<u32>,
        /// Dimension over balls (ring: between balls) M_dK.
        pub dimension_over_balls_mm: Option<Dimension>,
        pub ball_diameter_mm: Option<f64>,
        /// Root diameter d_f, in place of the dedendum.
        pub root_diameter_mm: Option<Dimension>,
        /// Lead p_z, > 0 right-handed, in place of the helix angle.
        pub lead_mm: Option<f64>,
        pub face_width_mm: f64,
        /// Tip diameter (ring: inner). Default: from `addendum_coefficient`.
        pub tip_diameter_mm: Option<f64>,
        /// Diameter at which chamfer or rounding of the tips begins and the involute ends, d_Fa. Default: the tip
        /// diameter.
        pub tip_form_diameter_mm: Option<f64>,
        /// Addendum over the normal module. Default 1.0; only without `tip_diameter_mm`.
        pub addendum_coefficient: Option<f64>,
        /// Dedendum of the basic rack over the normal module. Default: that of `root_diameter_mm`, else 1.25.
        pub dedendum_coefficient: Option<f64>,
        /// Tip radius of the tool (ring: radius of the fillet) over the normal module. Default 0.38.
        #[serde(default = "default_tool_tip_radius")]
        pub tool_tip_radius_coefficient: f64,
        /// Bore, held rigidly; external gears only. Default: half of the root diameter.
        pub bore_diameter_mm: Option<f64>,
        /// Outer diameter, held rigidly; makes this gear the ring of an internal pair. Default for gear 2
        /// of an internal pair: root diameter + 7 normal modules, a rim of 3.5 modules.
        pub rim_diameter_mm: Option<f64>,
        /// Radial thickness of the rim below the root circle; external gears, with `web_thickness_mm`. Default: a full
        /// disc.
        pub rim_thickness_mm: Option<f64>,
        pub web_thickness_mm: Option<f64>,
        /// z of the middle of the web less mid-face. Default 0.
        pub web_offset_mm: Option<f64>,
        /// Outer diameter of the hub. Default: no hub, the web reaches the bore.
        pub hub_diameter_mm: Option<f64>,
        /// Axial length of the hub. Default: the face width.
        pub hub_width_mm: Option<f64>,
        /// z of the middle of the hub less mid-face. Default 0.
        pub hub_offset_mm: Option<f64>,
        /// The shaft that the teeth are cut from, in place of rim, web and hub; external gears. `bore_diameter_mm` is then its
        /// bore, free; default: solid.
        pub shaft: Option<ShaftFile>,
        /// Elastic foundation on which the outside of a ring rests, N/mm per mm² in every direction. Default: rigid.
        pub rim_foundation_n_per_mm3: Option<f64>,
        #[serde(default = "default_youngs_modulus")]
        pub youngs_modulus_gpa: f64,
        #[serde(default = "default_poisson_ratio")]
        pub poisson_ratio: f64,
        /// Modifications of the drive flank instead of those of the gear.
        pub drive_flank: Option<FlankFile>,
        /// Modifications of the coast flank instead of those of the gear.
        pub coast_flank: Option<FlankFile>,
        /// Teeth that differ from each other. Default: all are alike.
        pub tooth_errors: Option<ToothErrorsFile>,
    }
}

with_modifications! {
    /// Modifications of one flank: those of [`GearFile`], which it replaces one by one.
    #[derive(Default)]
    pub struct FlankFile {}
}

impl GearFile {
    /// Its modifications, those of both flanks.
    pub fn modifications(&self) -> FlankFile {
        macro_rules! copied {
            ($($field:ident)*) => { FlankFile { $($field: self.$field.clone(),)* } };
        }
        copied! {
            tip_relief root_relief profile_crowning_um profile_slope_um bias_um lead_crowning_um lead_slope_um
            end_relief lower_end_relief upper_end_relief topography_file
        }
    }

    /// Every place at which modifications stand, with the start of the path of its fields.
    pub fn flanks(&self) -> Vec<(&'static str, FlankFile)> {
        let mut all = vec![("", self.modifications())];
        for (prefix, flank) in [
            ("drive_flank.", &self.drive_flank),
            ("coast_flank.", &self.coast_flank),
        ] {
            all.extend(flank.clone().map(|flank| (prefix, flank)));
        }
        all
    }
}

/// `shaft` of a gear: its pieces on both sides of the face, up to where the shaft of the multibody model takes over.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShaftFile {
    pub lower: Option<ShaftPieceFile>,
    pub upper: Option<ShaftPieceFile>,
    /// Which ends are held. Default: that of the only piece; of two it must be said.
    pub held: Option<HeldEnds>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShaftPieceFile {
    /// Diameter, below the root diameter.
    pub diameter_mm: f64,
    /// Length from the face.
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
    /// Where it starts. Default `pitch_point`.
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
    /// Removal at the end of the face.
    pub amount_um: f64,
    /// Reach into the face from that end.
    pub length_mm: f64,
    #[serde(default)]
    pub shape: ReliefShape,
}

/// `operating` of the file. Ranges hold zero and count from the nominal state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OperatingFile {
    pub nominal_torque_nm: f64,
    /// Highest torque on gear 1 that tables cover.
    pub maximum_torque_nm: f64,
    /// Lowest and highest deviation from the nominal centre distance.
    pub center_distance_offset_um: [f64; 2],
    /// Lowest and highest misalignment in the plane of action.
    pub misalignment_mrad: [f64; 2],
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
    /// How the coefficient follows from load and speed. Default `constant`.
    #[serde(default)]
    pub law: FrictionLawFile,
    /// `constant`: the coefficient. Default 0.05.
    pub coefficient: Option<f64>,
    /// Dynamic viscosity at the oil's temperature; required by `schlenk` and `xu_kahraman`.
    pub dynamic_viscosity_mpa_s: Option<f64>,
    /// `schlenk`: X_L of a gear oil: a mineral one 0.846, PAO and ester 0.65, polyglycol 0.585. Default 0.846.
    pub lubricant_factor: Option<f64>,
    /// Arithmetic mean roughness Ra of gear 1 and gear 2; required by `schlenk` and `xu_kahraman`.
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

fn default_tool_tip_radius() -> f64 {
    0.38
}

fn default_youngs_modulus() -> f64 {
    206.0
}

fn default_poisson_ratio() -> f64 {
    0.3
}
