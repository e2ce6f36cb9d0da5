//! The experiment most others are made of: gear 1 imposed, gear 2 free to spin alone.

use crate::driver::{Gear, INERTIA, Scene, Spin, State};
use gearmesh::element::{Elasticity, Element, ElementError, FlankLaws, LoadedFlank, Parameters};
use gearmesh::gear::PairGeometry;
use gearmesh::gear::teeth::Counts;
use gearmesh::table::{Potential, Query};
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
    fn evaluate(&self, query: &Query, _: Counts, _: bool) -> Result<Potential, String> {
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
        Ok(w)
    }
}

/// Mean stiffness of the springs on the line of action, N/m.
pub const STIFFNESS: f64 = 4.9e8;

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
    /// The linear spring `law` on the drive flank of `pair`, a mean `torque` (N m, > 0: closes the drive flank of an
    /// external pair) on gear 2, gear 1 moving as `speed` says.
    pub fn new(
        pair: &PairGeometry,
        parameters: &Parameters,
        law: ModulatedSpring,
        torque: f64,
        speed: Spin,
    ) -> Result<Self, ElementError> {
        let laws = FlankLaws { drive: Arc::new(law), coast: None };
        let parameters = Parameters { loaded_flank: LoadedFlank::Drive, ..*parameters };
        let element = Element::with_laws(pair, &parameters, &laws)?;
        let rb = pair.gears[1].base_radius();
        let gears = [Gear::new(pair, 0, speed), Gear::new(pair, 1, Spin::torque(torque))];
        Ok(Self {
            scene: Scene::new(element, gears)?,
            omega: (law.stiffness * rb * rb / INERTIA).sqrt(),
            static_elongation: torque / rb / law.stiffness,
            base_radius: rb,
            ratio: pair.e() * pair.gears[0].z() / pair.gears[1].z(),
        })
    }

    /// Gives gear 2 a damper of ratio `zeta` against gear 1's mean motion at `mean_speed`, rad/s, beside its `torque`.
    pub fn damped(mut self, zeta: f64, mean_speed: f64, torque: f64) -> Self {
        let (damping, ratio) = (2.0 * zeta * self.omega * INERTIA, self.ratio);
        let load = move |_, w: f64| torque - damping * (w + ratio * mean_speed);
        self.scene.gears[1].spin = Spin::Torque(Arc::new(load));
        self
    }

    /// At elongation `y` (in static elongations), gear 1 at zero angle and `mean_speed`, with the rate `rate`
    /// of y per scaled time.
    pub fn start(&self, y: f64, rate: f64, mean_speed: f64) -> State {
        let angle = y * self.static_elongation / self.base_radius;
        let w = rate * self.omega * self.static_elongation / self.base_radius;
        let rest = self.scene.rest();
        self.scene.with_spin(&rest, 1, angle, w - self.ratio * mean_speed)
    }

    /// y, the elongation over the static one, from the element's transmission error (negative in the gap).
    pub fn elongation(&self, t: f64, state: &State) -> Result<f64, ElementError> {
        let out = self.scene.contact(t, state)?;
        let k = self.scene.element.line_of_action(out.center_distance);
        Ok(out.transmission_error * k / self.static_elongation)
    }
}
