//! The experiment most others are made of: gear 1 imposed, gear 2 free to spin alone.

use crate::Result;
use crate::driver::{Gear, INERTIA, Scene, Spin, State};
use crate::setup::ratio;
use gearmesh::element::{Elasticity, Element, LoadedFlank, Parameters};
use gearmesh::gear::PairGeometry;
use gearmesh::gear::teeth::Counts;
use gearmesh::table::{Potential, Query};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Mean stiffness of the springs on the line of action, N/m.
pub const STIFFNESS: f64 = 4.9e8;

/// Linear spring whose stiffness varies over the mesh cycle: W = k (1 + eps cos 2 pi PMC) delta^2 / 2
/// for delta > 0. The law of the textbook problems of gear dynamics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModulatedSpring {
    /// Mean stiffness k on the line of action, N/m.
    pub stiffness: f64,
    /// eps.
    pub depth: f64,
}

impl ModulatedSpring {
    /// Of the mean stiffness [`STIFFNESS`].
    pub fn new(depth: f64) -> Self {
        let stiffness = STIFFNESS;
        Self { stiffness, depth }
    }
}

impl Elasticity for ModulatedSpring {
    fn evaluate(
        &self,
        query: &Query,
        _: Counts,
        _: bool,
    ) -> std::result::Result<Potential, String> {
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
    /// Deflection under the load, F/k, m.
    pub static_deflection: f64,
    /// Base radius of gear 2, m.
    pub base_radius: f64,
    /// Rate of gear 2 over that of gear 1.
    pub ratio: f64,
}

/// y, the deflection over the static one (negative in the gap), and its rate per scaled time.
pub struct Deflection {
    /// y.
    pub y: f64,
    /// y'.
    pub rate: f64,
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
    ) -> Result<Self> {
        let mut parameters = *parameters;
        parameters.loaded_flank = LoadedFlank::Drive;
        let element = Element::with_laws(pair, &parameters, Arc::new(law), None)?;
        let rb = pair.gears[1].base_radius();
        let gears = [
            Gear::new(pair, 0, speed),
            Gear::new(pair, 1, Spin::torque(torque)),
        ];
        Ok(Self {
            scene: Scene::new(element, gears)?,
            omega: (law.stiffness * rb * rb / INERTIA).sqrt(),
            static_deflection: torque / rb / law.stiffness,
            base_radius: rb,
            ratio: ratio(pair),
        })
    }

    /// Gives gear 2 a damper of ratio `zeta` against gear 1's mean motion at `mean_speed`, rad/s, beside its `torque`.
    pub fn damped(mut self, zeta: f64, mean_speed: f64, torque: f64) -> Self {
        let (damping, mean) = (2.0 * zeta * self.omega * INERTIA, self.ratio * mean_speed);
        let load = move |_, w: f64| torque - damping * (w - mean);
        self.scene.gears[1].spin = Spin::Torque(Arc::new(load));
        self
    }

    /// At deflection `y` (in static ones), gear 1 at zero angle and `mean_speed`, with the rate `rate`
    /// of y per scaled time.
    pub fn start(&self, y: f64, rate: f64, mean_speed: f64) -> State {
        let angle = self.static_deflection / self.base_radius;
        let speed = rate * self.omega * angle + self.ratio * mean_speed;
        self.scene
            .with_spin(&self.scene.rest(), 1, y * angle, speed)
    }

    /// The deflection at `state`, from the element's transmission error.
    pub fn deflection(&self, t: f64, state: &State) -> Result<Deflection> {
        let out = self.scene.contact(t, state)?;
        let scale = self.scene.element.line_of_action(out.center_distance) / self.static_deflection;
        let (y, rate) = (
            out.transmission_error * scale,
            out.transmission_error_rate * scale,
        );
        Ok(Deflection {
            y,
            rate: rate / self.omega,
        })
    }
}
