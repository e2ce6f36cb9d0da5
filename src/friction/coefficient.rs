//! Laws of the coefficient of friction.

use serde::{Deserialize, Serialize};

use crate::gear::PairGeometry;
use crate::words::rounded;

/// Sum of the rolling speeds below which the coefficient no longer rises, m/s: v becomes
/// sqrt(v² + this²). Both measured laws have negative powers of the speed and were fitted above 1 m/s.
pub const LOWEST_ROLLING_SPEED: f64 = 0.1;

/// Rms over arithmetic mean of a rough profile whose heights are normally distributed: sqrt(pi / 2).
const RMS_OVER_MEAN: f64 = 1.253_314_137_315_5;

/// How the coefficient of friction of dry or lubricated flanks follows from the state of the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "law", rename_all = "snake_case")]
pub enum FrictionLaw {
    /// The same everywhere.
    Constant {
        /// mu, >= 0.
        coefficient: f64,
    },
    /// Mean over the mesh cycle by Schlenk, as in ISO/TR 14179-2:
    /// mu = 0.048 (F_bt/b / (v_sum rho_C))^0.2 eta^-0.05 Ra^0.25 X_L, F_bt N, b mm, v_sum m/s and rho_C mm at the
    /// pitch point, eta mPa s, Ra um.
    Schlenk {
        /// eta at the oil's temperature, Pa s.
        dynamic_viscosity_pa_s: f64,
        /// Ra, mean of both gears, m.
        roughness_ra_m: f64,
        /// X_L. Values of particular gear oils, not those of the standard: in the library of the program GEARpie (C. Fernandes) a
        /// mineral oil has 0.846, PAO and ester 0.65, polyglycol 0.585.
        lubricant_factor: f64,
    },
    /// Local coefficient of every segment by Xu and Kahraman, Journal of Mechanical Design 129 (2007), 58-68:
    /// mu = exp(f) P^1.03303 |SR|^1.036077 Ve^-0.100601 nu^0.752755 R^-0.390958,
    /// f = -8.916465 - 0.354068 |SR| P lg(nu) + 2.812084 exp(-|SR| P lg(nu)) + 0.620305 exp(S), with P the largest Hertz
    /// pressure GPa, Ve the mean of the rolling speeds m/s, SR their difference over it, nu mPa s, R the
    /// relative radius of curvature m, S the composite rms roughness um. Fitted to an oil 75W90, whose
    /// pressure-viscosity coefficient is part of the constants.
    XuKahraman {
        /// nu at the oil's temperature, Pa s.
        dynamic_viscosity_pa_s: f64,
        /// S, m.
        roughness_rms_m: f64,
    },
}

impl Default for FrictionLaw {
    /// 0.05: what Schlenk's law gives for ground steel in mineral oil at some m/s.
    fn default() -> Self {
        FrictionLaw::Constant { coefficient: 0.05 }
    }
}

impl std::fmt::Display for FrictionLaw {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            FrictionLaw::Constant { coefficient } => {
                write!(f, "constant coefficient {coefficient}")
            }
            FrictionLaw::Schlenk {
                dynamic_viscosity_pa_s,
                roughness_ra_m,
                lubricant_factor,
            } => write!(
                f,
                "Schlenk, {} mPa s, Ra {} um, X_L {lubricant_factor}",
                rounded(1e3 * dynamic_viscosity_pa_s),
                rounded(1e6 * roughness_ra_m)
            ),
            FrictionLaw::XuKahraman {
                dynamic_viscosity_pa_s,
                roughness_rms_m,
            } => write!(
                f,
                "Xu and Kahraman, {} mPa s, composite roughness {} um rms",
                rounded(1e3 * dynamic_viscosity_pa_s),
                rounded(1e6 * roughness_rms_m)
            ),
        }
    }
}

/// Contact on one segment, for laws that look at it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SegmentContact {
    /// Normal force per length of contact line, N/m.
    pub line_load: f64,
    /// Relative radius of curvature in the normal section, m.
    pub radius: f64,
    /// (1 - nu1²)/E1 + (1 - nu2²)/E2, 1/Pa.
    pub plane_compliance: f64,
    /// Rolling speeds of both flanks while those at the pitch point add up to 1 m/s, m/s.
    pub rolling: [f64; 2],
}

/// Coefficient of one pair: `scale` F_bt^`by_load` v_sum^-`by_speed`, times the weights of the segments
/// ([`FrictionLaw::weight`]). F_bt N, v_sum the sum of the rolling speeds at the pitch point, m/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficient {
    /// At 1 N and 1 m/s.
    pub scale: f64,
    /// Exponent of the load.
    pub by_load: f64,
    /// Exponent of the speed, its sign changed.
    pub by_speed: f64,
}

impl FrictionLaw {
    /// Schlenk's law with both roughnesses `ra` (m).
    pub fn schlenk(dynamic_viscosity_pa_s: f64, ra: [f64; 2], lubricant_factor: f64) -> Self {
        FrictionLaw::Schlenk {
            dynamic_viscosity_pa_s,
            roughness_ra_m: 0.5 * (ra[0] + ra[1]),
            lubricant_factor,
        }
    }

    /// Xu and Kahraman's law with both roughnesses `ra` (arithmetic means, m): normally distributed heights.
    pub fn xu_kahraman(dynamic_viscosity_pa_s: f64, ra: [f64; 2]) -> Self {
        FrictionLaw::XuKahraman {
            dynamic_viscosity_pa_s,
            roughness_rms_m: RMS_OVER_MEAN * ra[0].hypot(ra[1]),
        }
    }

    /// Whether segments differ in their coefficients.
    pub fn is_local(&self) -> bool {
        matches!(self, FrictionLaw::XuKahraman { .. })
    }

    /// Part of the coefficient that is a segment's own: 1 for laws of the whole mesh, else the coefficient at
    /// v_sum = 1 m/s. Since both gears turn in a fixed ratio, the speed is a factor of its own.
    pub fn weight(&self, segment: &SegmentContact) -> f64 {
        let FrictionLaw::XuKahraman {
            dynamic_viscosity_pa_s,
            roughness_rms_m,
        } = *self
        else {
            return 1.0;
        };
        let [u1, u2] = segment.rolling;
        let mean = 0.5 * (u1 + u2);
        let ratio = ((u1 - u2) / mean).abs();
        let e_star = segment.plane_compliance.recip();
        let pressure = 1e-9
            * (segment.line_load.max(0.0) * e_star / (std::f64::consts::PI * segment.radius))
                .sqrt();
        let viscosity = 1e3 * dynamic_viscosity_pa_s;
        let work = ratio * pressure * viscosity.log10();
        let f = -8.916_465 - 0.354_068 * work
            + 2.812_084 * (-work).exp()
            + 0.620_305 * (1e6 * roughness_rms_m).exp();
        f.exp()
            * pressure.powf(1.033_03)
            * ratio.powf(1.036_077)
            * mean.powf(-0.100_601)
            * viscosity.powf(0.752_755)
            * segment.radius.powf(-0.390_958)
    }

    /// What is left for the load and the speed of the mesh of `pair`.
    pub fn coefficient(&self, pair: &PairGeometry) -> Coefficient {
        match *self {
            FrictionLaw::Constant { coefficient } => Coefficient {
                scale: coefficient,
                by_load: 0.0,
                by_speed: 0.0,
            },
            FrictionLaw::Schlenk {
                dynamic_viscosity_pa_s,
                roughness_ra_m,
                lubricant_factor,
            } => {
                let width_mm = 1e3 * pair.face_overlap().1;
                let radius_mm = 1e3 * pair.pitch_point_radius();
                Coefficient {
                    scale: 0.048
                        * (width_mm * radius_mm).powf(-0.2)
                        * (1e3 * dynamic_viscosity_pa_s).powf(-0.05)
                        * (1e6 * roughness_ra_m).powf(0.25)
                        * lubricant_factor,
                    by_load: 0.2,
                    by_speed: 0.2,
                }
            }
            FrictionLaw::XuKahraman { .. } => Coefficient {
                scale: 1.0,
                by_load: 0.0,
                by_speed: 0.100_601,
            },
        }
    }
}

impl Coefficient {
    /// At the transverse force `loa_force` (N, > 0) on the line of action and the sum `rolling_speed` (m/s) of the
    /// rolling speeds at the pitch point.
    pub fn at(&self, loa_force: f64, rolling_speed: f64) -> f64 {
        self.scale
            * loa_force.powf(self.by_load)
            * rolling_speed
                .hypot(LOWEST_ROLLING_SPEED)
                .powf(-self.by_speed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::testing::c14;
    use approx::assert_relative_eq;

    #[test]
    fn xu_and_kahramans_coefficient_is_the_printed_formula() {
        let law = FrictionLaw::XuKahraman {
            dynamic_viscosity_pa_s: 10e-3,
            roughness_rms_m: 0.5e-6,
        };
        // Chosen so that P = 1 GPa, SR = 0.5, Ve = 1 m/s, R = 5 mm, lg(nu) = 1.
        let segment = SegmentContact {
            line_load: 1e18 * std::f64::consts::PI * 5e-3 * 8.8e-12,
            radius: 5e-3,
            plane_compliance: 8.8e-12,
            rolling: [1.25, 0.75],
        };
        let f: f64 =
            -8.916465 - 0.354068 * 0.5 + 2.812084 * (-0.5f64).exp() + 0.620305 * 0.5f64.exp();
        let mu = f.exp() * 0.5f64.powf(1.036077) * 10f64.powf(0.752755) * 5e-3f64.powf(-0.390958);
        assert_relative_eq!(law.weight(&segment), mu, max_relative = 1e-12);
        assert!((0.01..0.1).contains(&mu), "{mu}");
        let rolling = SegmentContact {
            rolling: [1.0, 1.0],
            ..segment
        };
        assert_eq!(law.weight(&rolling), 0.0);
    }

    #[test]
    fn the_coefficient_stays_finite_at_standstill() {
        let law = FrictionLaw::schlenk(13.28e-3, [0.4e-6, 0.4e-6], 0.846);
        let law = law.coefficient(&c14());
        let [rest, slow] = [0.0, LOWEST_ROLLING_SPEED].map(|v| law.at(5e3, v));
        assert_relative_eq!(rest / slow, 2f64.powf(0.1), max_relative = 1e-12);
    }
}
