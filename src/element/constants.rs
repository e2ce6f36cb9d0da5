//! Numbers of a pair that never change, worked out once.

use super::motion::ElementError;
use super::parameters::Parameters;
use crate::gear::{Flank, PairGeometry, PairNumbers, involute};
use crate::root::bisection;
use crate::words::{fixed, number};

/// Constants of the pair for the element, symbols as in the crate's table.
#[derive(Debug, Clone)]
pub(crate) struct Constants {
    pub e: f64,
    /// sc: side of O1 on which the mesh lies.
    pub sc: f64,
    /// Teeth.
    pub z: [f64; 2],
    pub base_radius: [f64; 2],
    pub kappa: [f64; 2],
    /// h: hand of gear 1 (gear 2 has -e h).
    pub hand: f64,
    /// Pitch point over O1 -> O2: z1 / (z1 + e z2).
    pub pitch_fraction: f64,
    /// abs(rb1 + e rb2), m.
    pub base_radius_sum: f64,
    /// Nominal centre distance, m.
    pub center_distance: f64,
    /// cos phi at the nominal centre distance.
    pub cos_phi: f64,
    pub tan_beta_b: f64,
    pub per_cos_beta_b: f64,
    /// tan beta / r1, 1/m: times r_w1 it is tan beta_w.
    pub tan_beta_per_radius: f64,
    /// Mid-face of the nominal overlap in gear 1's frame, m.
    pub z_ref: f64,
    /// Nominal axial position of gear 2 against gear 1, m.
    pub face_offset: f64,
    /// Ends of the common face at the nominal pose, in gear 1's frame, m.
    pub common_face: [f64; 2],
    /// Where the teeth come out of mesh.
    pub radial_engagement: RadialEngagement,
    /// Face widths, m.
    pub face_width: [f64; 2],
    /// theta_p1 = 2 pi / z1, rad.
    pub pitch_angle: f64,
    /// Penetration on the line of action per tooth angle, m/rad: rb1 / z1 = base_radius_sum / tooth_sum.
    pub per_tooth_angle: f64,
    /// One base pitch, m.
    pub base_pitch: f64,
    /// -sum kappa rb psi, m, less whole half pitches, backlash override included: half the gap on the
    /// line of action is this plus sum kappa rb inv(rho).
    pub half_gap: f64,
    /// The half pitches taken from it, rad of tooth angle.
    pub tooth_zero: f64,
    /// Circumferential backlash at the nominal operating pitch circle, m.
    pub backlash: f64,
    /// Mesh position of both flanks where theta1 = gamma, in the `absolute` reference.
    pub mesh_zero: [f64; 2],
    /// Nominal force on the line of action, N.
    pub nominal_force: f64,
    /// See [`PairGeometry::disc_mass`].
    pub disc_mass: f64,
}

/// Index of the flank in arrays: drive, coast.
pub(crate) const FLANKS: [Flank; 2] = [Flank::Drive, Flank::Coast];

impl Constants {
    pub(crate) fn new(pair: &PairGeometry, parameters: &Parameters) -> Result<Self, ElementError> {
        let g = &pair.gears;
        let numbers = PairNumbers::new(pair);
        let (e, c) = (numbers.e, pair.center_distance);
        let phi = pair.operating_pressure_angle(c);
        if phi.is_nan() {
            return Err(no_line_of_action(c, numbers.base_radius_sum, c));
        }
        let [z1, z2] = [g[0].z(), g[1].z()];
        let tooth_sum = z1 + e * z2;
        let nominal_backlash = pair.backlash(c);
        let backlash = parameters
            .backlash
            .map_or(nominal_backlash, |j| j * phi.cos());
        let half_pitch = 0.5 * numbers.base_pitch;
        if backlash >= half_pitch {
            let value = format!("{} m", number(backlash / phi.cos()));
            let remedy = "give a backlash in metres, well below half a pitch";
            return Err(ElementError::parameter("backlash", &value, remedy));
        }
        // H = sum kappa rb (inv - psi) is half the backlash up to whole half pitches: at zero angles a tooth
        // may face a tooth. Those go into the tooth angle, so that the gap is centred on it.
        let [r1, r2] = g.each_ref().map(|g| g.kappa() * g.base_radius());
        let turn_to_gap = -r1 * g[0].half_base_angle() - r2 * g[1].half_base_angle();
        let whole_gap = turn_to_gap + (r1 + r2) * involute(phi);
        let half_pitches = ((whole_gap - 0.5 * nominal_backlash) / half_pitch).round();
        let half_gap =
            turn_to_gap - half_pitches * half_pitch + 0.5 * (backlash - nominal_backlash);
        let pitch_angle = std::f64::consts::TAU / z1;
        let [low, width] = numbers.face;
        // The flank of gear 1 stands at theta = eta + h z tan(beta_b)/rb - s kappa inv(rho) in its
        // body; PMC = 0 where that is the direction of the pitch point at mid-face.
        let helix_turn = numbers.hand * numbers.z_ref * numbers.tan_beta_b / numbers.base_radius[0];
        let half_tooth = g[0].kappa() * (g[0].half_base_angle() - involute(phi));
        let mesh_zero = FLANKS
            .map(|f| (f.sign() * (helix_turn - behind(z1 / tooth_sum)) + half_tooth) / pitch_angle);
        Ok(Self {
            e,
            sc: pair.sc(),
            z: [z1, z2],
            base_radius: numbers.base_radius,
            kappa: numbers.kappa,
            hand: numbers.hand,
            pitch_fraction: z1 / tooth_sum,
            base_radius_sum: numbers.base_radius_sum,
            center_distance: c,
            cos_phi: phi.cos(),
            tan_beta_b: numbers.tan_beta_b,
            per_cos_beta_b: 1.0 / numbers.cos_beta_b,
            tan_beta_per_radius: g[0].helix_angle.tan() / g[0].reference_radius(),
            z_ref: numbers.z_ref,
            disc_mass: pair.disc_mass(),
            face_offset: numbers.face_offset[1],
            common_face: [low, low + width],
            radial_engagement: RadialEngagement::new(pair),
            face_width: [g[0].face_width, g[1].face_width],
            pitch_angle,
            per_tooth_angle: g[0].base_radius() / z1,
            base_pitch: numbers.base_pitch,
            half_gap,
            tooth_zero: half_pitches * std::f64::consts::PI,
            backlash: backlash / phi.cos(),
            mesh_zero,
            nominal_force: parameters.nominal_torque / g[0].base_radius(),
        })
    }

    /// Whether there is a line of action at the centre distance `c`; false: the gears are out of mesh.
    /// Errors: base circles without a common tangent, except for an internal pair pulled apart so far that its
    /// teeth have already left each other.
    #[inline(always)]
    pub(crate) fn has_line_of_action(&self, c: f64) -> Result<bool, ElementError> {
        if c > self.base_radius_sum {
            return Ok(true);
        }
        let apart =
            self.e < 0.0 && self.radial_engagement.none > self.base_radius_sum * (1.0 + 1e-6);
        // The direction O1 -> O2 must be more than rounding.
        if apart && c > 1e-6 * self.center_distance {
            return Ok(false);
        }
        Err(no_line_of_action(
            c,
            self.base_radius_sum,
            self.center_distance,
        ))
    }
}

/// The base circles overlap (external) or do not contain one another (internal) at the centre distance `c`, m.
#[cold]
fn no_line_of_action(c: f64, limit: f64, nominal: f64) -> ElementError {
    ElementError::Pose(format!(
        "centre distance {} mm is below {} mm, where the base circles leave no common tangent; move the gears apart or check \
         which gear is which (with gear 1 at the origin gear2.position[1] starts as {} m: a host that fills all inputs with \
         zeros must set it)",
        fixed(1e3 * c, 6),
        fixed(1e3 * limit, 6),
        number(nominal)
    ))
}

/// Direction of the pitch point seen from O1, which lies at this fraction of O1 -> O2: 0, or pi behind O1, rad.
pub(crate) fn behind(fraction: f64) -> f64 {
    if fraction < 0.0 {
        std::f64::consts::PI
    } else {
        0.0
    }
}

/// Centre distances between which the teeth come out of mesh, m.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RadialEngagement {
    /// Where the factor is zero: farther out for external pairs, nearer for internal ones. Below the distance at
    /// which the base circles touch: it never gets there.
    pub none: f64,
    /// 1 / (where the factor starts to fall - `none`), 1/m.
    pub per_span: f64,
}

impl RadialEngagement {
    /// From the lengths of the path of contact at the centre distances of `pair`.
    pub(crate) fn new(pair: &PairGeometry) -> Self {
        let nominal = pair.center_distance;
        let half = 0.5 * pair.transverse_contact_ratio(nominal).min(1.0);
        // Outwards: external gears part, internal ones come together until the base circles touch.
        let end = if pair.e() > 0.0 {
            2.0 * nominal
        } else {
            pair.base_radius_sum() * (1.0 + 1e-9)
        };
        // Share of half the path that is left at the end; of many internal pairs some, of those with few teeth
        // between them all of it.
        let left = (pair.transverse_contact_ratio(end) / half).max(0.0);
        if left >= 1.0 {
            // No centre distance lies below that of the base circles.
            return Self {
                none: 0.0,
                per_span: 1.0 / pair.base_radius_sum(),
            };
        }
        // Where the transverse contact ratio falls to `ratio`.
        let crossing = |ratio: f64| {
            bisection([nominal, end], 60, |c| {
                pair.transverse_contact_ratio(c) > ratio
            })
        };
        let full = crossing(half);
        // Where some is left the factor is to be as much at the end, so that no pair falls steeply there.
        let none = if left > 0.0 {
            (end - left * full) / (1.0 - left)
        } else {
            crossing(0.0)
        };
        Self {
            none,
            per_span: 1.0 / (full - none),
        }
    }
}
