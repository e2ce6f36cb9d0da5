//! The experiment most others are made of: gear 1 imposed, gear 2 free to spin alone.

use crate::driver::{Bearing, Freedoms, Gear, Scene, Spin, State};
use gearmesh::element::{Elasticity, Element, ElementError, FlankLaws, Parameters};
use gearmesh::gear::PairGeometry;
use gearmesh::table::{Potential, Query};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Linear spring whose stiffness varies over the mesh cycle: W = k (1 + eps cos 2 pi PMC) delta^2 / 2
/// for delta > 0. The law of the textbook problems of gear dynamics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModulatedSpring {
    /// Mean stiffness k on the line of action, N/m.
    pub stiffness: f64,
    /// eps.
    pub depth: f64,
}

impl Elasticity for ModulatedSpring {
    fn evaluate(&self, query: &Query, _want_hessian: bool) -> Potential {
        let mut w = Potential::default();
        if query.delta > 0.0 {
            let (sine, cosine) = (TAU * query.mesh_position).sin_cos();
            let delta = query.delta;
            let k = self.stiffness * (1.0 + self.depth * cosine);
            let slope = -self.stiffness * self.depth * TAU * sine;
            let curvature = -self.stiffness * self.depth * TAU * TAU * cosine;
            w.value = 0.5 * k * delta * delta;
            w.gradient = [k * delta, 0.0, 0.0, 0.5 * slope * delta * delta];
            w.hessian[0] = [k, 0.0, 0.0, slope * delta];
            w.hessian[3] = [slope * delta, 0.0, 0.0, 0.5 * curvature * delta * delta];
        }
        w
    }
}

/// Gear 1 imposed, gear 2 spinning freely under a torque; in scaled form
///
/// ```text
/// y'' + 2 zeta y' + k(tau) max(y, 0) = 1,     y = delta / (F/k),   time in 1 / omega
/// ```
pub struct SingleFreedom {
    /// The scene; gear 2's spin is the only freedom.
    pub scene: Scene,
    /// omega = sqrt(k rb2^2 / J), rad/s.
    pub omega: f64,
    /// Elongation under the load, F/k, m.
    pub static_elongation: f64,
    /// Base radius of gear 2, m.
    pub base_radius: f64,
    /// Angle of gear 2 at elongation zero when gear 1 stands at zero, rad.
    pub ratio: f64,
}

impl SingleFreedom {
    /// Spring `law` on both flanks of `pair`, a mean `torque` (N m, > 0: closes the drive flank of an
    /// external pair) on gear 2 of polar inertia `inertia` (kg m^2); gear 1 turns at `speed(t)` and gear 2
    /// has a damper of ratio `zeta` against gear 1's mean motion at `mean_speed`, rad/s.
    ///
    /// # Errors
    /// As [`Element::with_laws`].
    #[allow(clippy::too_many_arguments)] // all of them are physical data of one small scene
    pub fn new(
        pair: &PairGeometry,
        parameters: &Parameters,
        law: ModulatedSpring,
        inertia: f64,
        torque: f64,
        zeta: f64,
        speed: Spin,
        mean_speed: f64,
    ) -> Result<Self, ElementError> {
        let laws = FlankLaws {
            drive: Arc::new(law),
            coast: None,
        };
        let element = Element::with_laws(pair, parameters, &laws)?;
        let rb = pair.gears[1].base_radius();
        let omega = (law.stiffness * rb * rb / inertia).sqrt();
        let ratio = pair.e() * pair.gears[0].z() / pair.gears[1].z();
        let damping = 2.0 * zeta * omega * inertia;
        let load = Spin::Torque(Arc::new(move |_, w| {
            torque - damping * (w + ratio * mean_speed)
        }));
        let gear = |i: usize, spin| Gear {
            mass: 1.0,
            polar_inertia: inertia,
            transverse_inertia: inertia,
            center_of_mass: 0.0,
            origin: Vector3::new(
                i as f64 * pair.center_distance,
                0.0,
                i as f64 * pair.gears[1].face_offset,
            ),
            bearing: Bearing::default(),
            freedoms: Freedoms::default(),
            spin,
        };
        let scene = Scene::new(element, [gear(0, speed), gear(1, load)])?;
        Ok(Self {
            scene,
            omega,
            static_elongation: torque / rb / law.stiffness,
            base_radius: rb,
            ratio,
        })
    }

    /// At elongation `y` (in static elongations), gear 1 at zero angle and `mean_speed`, with the rate `rate`
    /// of y per scaled time.
    pub fn start(&self, y: f64, rate: f64, mean_speed: f64) -> State {
        let angle = y * self.static_elongation / self.base_radius;
        let w = rate * self.omega * self.static_elongation / self.base_radius;
        let rest = self.scene.rest();
        self.scene
            .with_spin(&rest, 1, angle, w - self.ratio * mean_speed)
    }

    /// y, the elongation over the static one, from the element's transmission error (negative in the gap).
    ///
    /// # Errors
    /// As the element's evaluation.
    pub fn elongation(&self, t: f64, state: &State) -> Result<f64, ElementError> {
        let out = self.scene.contact(t, state)?;
        let k = self.scene.element.line_of_action(out.center_distance);
        Ok(out.transmission_error * k / self.static_elongation)
    }
}
