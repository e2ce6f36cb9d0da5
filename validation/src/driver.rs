//! A small driver for numerical experiments with the element: two gears on bearings, imposed speeds
//! or torques, integrators, and a co-simulation loop.
//!
//! Each gear is a rigid body, axisymmetric about its axis. Its state holds the position of the centre
//! of mass, the orientation as a unit quaternion, the velocity and the angular momentum about the centre of
//! mass, all in the world frame, so the equations have no inertia terms:
//!
//! ```text
//! p' = v,   q' = w q / 2,   m v' = force,   L' = moment,   w = L/J_t + (1/J_p - 1/J_t) (L . a) a
//! ```
//!
//! with J_p about the axis a and J_t across it. A gear without a bearing gets neither force nor moment but about its axis.

use crate::Result;
use gearmesh::element::{
    Coupling, Element, History, Inputs, Loads, Motion, Outputs, PhaseOffset, StepRequest, Workspace,
};
use gearmesh::gear::PairGeometry;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use std::cell::RefCell;
use std::f64::consts::TAU;
use std::sync::Arc;

/// State of one gear, or its rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearState {
    /// Position of the centre of mass, m, W.
    pub p: Vector3<f64>,
    /// Orientation R_WG, not normalised.
    pub q: Quaternion<f64>,
    /// Velocity of the centre of mass, m/s.
    pub v: Vector3<f64>,
    /// Angular momentum about the centre of mass, kg m^2/s, W.
    pub l: Vector3<f64>,
}

/// State of both gears.
pub type State = [GearState; 2];

impl GearState {
    /// R_WG.
    pub fn orientation(&self) -> UnitQuaternion<f64> {
        UnitQuaternion::new_normalize(self.q)
    }

    fn axis(&self) -> Vector3<f64> {
        self.orientation() * Vector3::z()
    }

    /// Angle of rotation about world z (twist of the swing-twist decomposition), [-pi, pi).
    pub fn twist(&self) -> f64 {
        let angle = 2.0 * self.q.k.atan2(self.q.w);
        angle - TAU * (angle / TAU).round()
    }

    fn ahead(&self, rate: &Self, h: f64) -> Self {
        Self {
            p: self.p + rate.p * h,
            q: self.q + rate.q * h,
            v: self.v + rate.v * h,
            l: self.l + rate.l * h,
        }
    }
}

/// What moves or loads a gear about its axis.
#[derive(Clone)]
pub enum Spin {
    /// Free, under a torque f(t, spin rate in rad/s), N m, that works on the twist about world z (half-way
    /// between both axes where the gear is tilted), so that a constant one has a potential.
    Torque(Arc<dyn Fn(f64, f64) -> f64 + Send + Sync>),
    /// The spin rate is imposed: f(t), rad/s.
    Speed(Arc<dyn Fn(f64) -> f64 + Send + Sync>),
}

impl Spin {
    /// Free under a constant torque, N m.
    pub fn torque(torque: f64) -> Self {
        Spin::Torque(Arc::new(move |_, _| torque))
    }

    /// Turning at a constant rate, rad/s.
    pub fn speed(speed: f64) -> Self {
        Spin::Speed(Arc::new(move |_| speed))
    }
}

/// Springs and dampers between a gear and its rest position, on which it moves in six freedoms.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bearing {
    /// Along world x, y, z, N/m and N s/m.
    pub stiffness: [f64; 3],
    pub damping: f64,
    /// Of the tilt, N m/rad and N m s/rad.
    pub tilt_stiffness: f64,
    pub tilt_damping: f64,
}

impl Bearing {
    /// Without damping.
    pub fn springs(stiffness: [f64; 3], tilt_stiffness: f64) -> Self {
        Self {
            stiffness,
            tilt_stiffness,
            ..Self::default()
        }
    }
}

/// Mass, kg, and moments of inertia about and across the axis, kg m^2, of every gear: those behind the paper's Table 2.
pub const MASS: f64 = 0.8;
pub const INERTIA: f64 = 4.213e-4;
pub const TRANSVERSE_INERTIA: f64 = 0.6 * INERTIA;

/// One gear as a rigid body.
#[derive(Clone)]
pub struct Gear {
    /// Centre of mass on the axis from the z = 0 face, m.
    pub center_of_mass: f64,
    /// Rest position of the origin, m, W; the axis at rest is world z.
    pub origin: Vector3<f64>,
    /// Without one it only spins.
    pub bearing: Option<Bearing>,
    pub spin: Spin,
}

impl Gear {
    /// Gear `i` of `pair`, which only spins.
    pub fn new(pair: &PairGeometry, i: usize, spin: Spin) -> Self {
        let origin = Vector3::new(pair.center_distance, 0.0, pair.gears[1].face_offset) * i as f64;
        Self {
            center_of_mass: 0.0,
            origin,
            bearing: None,
            spin,
        }
    }

    fn rest(&self) -> Vector3<f64> {
        self.origin + Vector3::z() * self.center_of_mass
    }
}

/// Two gears coupled by an element.
#[derive(Clone)]
pub struct Scene {
    pub element: Element,
    /// Its phase offsets.
    pub phase: PhaseOffset,
    pub gears: [Gear; 2],
    /// Of the last evaluation of the contact.
    workspace: RefCell<Workspace>,
}

impl Scene {
    /// A scene that starts in the element's nominal pose, with its phase offset taken there.
    pub fn new(element: Element, gears: [Gear; 2]) -> Result<Self> {
        let phase = element.phase_offset(&element.nominal_inputs())?;
        Ok(Self {
            element,
            phase,
            gears,
            workspace: RefCell::default(),
        })
    }

    /// At rest, apart from imposed speeds, with zero angles.
    pub fn rest(&self) -> State {
        self.gears.each_ref().map(|gear| {
            let spin = match &gear.spin {
                Spin::Torque(_) => 0.0,
                Spin::Speed(f) => f(0.0),
            };
            GearState {
                p: gear.rest(),
                q: Quaternion::identity(),
                v: Vector3::zeros(),
                l: Vector3::z() * (spin * INERTIA),
            }
        })
    }

    /// `state` with gear `i` turned about its axis by `angle` (rad) and spinning at `rate` (rad/s).
    pub fn with_spin(&self, state: &State, i: usize, angle: f64, rate: f64) -> State {
        let mut out = *state;
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
        out[i].q *= turn.into_inner();
        let a = out[i].axis();
        out[i].l += a * (INERTIA * rate - out[i].l.dot(&a));
        out
    }

    /// Angular velocity of gear `i`, rad/s, W.
    fn angular_velocity(&self, t: f64, i: usize, g: &GearState) -> Vector3<f64> {
        let (gear, a) = (&self.gears[i], g.axis());
        let along = g.l.dot(&a);
        let spin = match &gear.spin {
            Spin::Torque(_) => along / INERTIA,
            Spin::Speed(f) => f(t),
        };
        let across = (g.l - a * along) / TRANSVERSE_INERTIA;
        if gear.bearing.is_some() {
            a * spin + across
        } else {
            a * spin
        }
    }

    /// The element's inputs at `state`; the carrier is the world.
    pub fn inputs(&self, t: f64, state: &State) -> Inputs {
        Inputs {
            gears: [0, 1].map(|i| {
                let g = &state[i];
                let w = self.angular_velocity(t, i, g);
                let r = *g.orientation().to_rotation_matrix().matrix();
                let arm = r.column(2) * -self.gears[i].center_of_mass;
                Motion {
                    p: g.p + arm,
                    r,
                    v: g.v + w.cross(&arm),
                    w,
                }
            }),
            carrier: Motion::default(),
        }
    }

    /// Contact loads at `state`.
    pub fn contact(&self, t: f64, state: &State) -> Result<Outputs> {
        Ok(self.element.evaluate_from(
            &self.phase,
            &self.inputs(t, state),
            &mut self.workspace.borrow_mut(),
        )?)
    }

    /// Rates of `state` with the contact's `force` and `moment` (about each gear's origin) given.
    pub fn rates(
        &self,
        t: f64,
        state: &State,
        force: &[Vector3<f64>; 2],
        moment: &[Vector3<f64>; 2],
    ) -> State {
        let mut rates = *state;
        for (i, gear) in self.gears.iter().enumerate() {
            let g = &state[i];
            let (w, a) = (self.angular_velocity(t, i, g), g.axis());
            let mut total = force[i];
            let mut about = moment[i] - (a * gear.center_of_mass).cross(&force[i]);
            if let Spin::Torque(f) = &gear.spin {
                about += (a + Vector3::z()) / (1.0 + a.z) * f(t, w.dot(&a));
            }
            if let Some(b) = &gear.bearing {
                total -= Vector3::from(b.stiffness).component_mul(&(g.p - gear.rest()))
                    + g.v * b.damping;
                about += a.cross(&Vector3::z()) * b.tilt_stiffness
                    - (w - a * w.dot(&a)) * b.tilt_damping;
            } else {
                total = Vector3::zeros();
                about = a * about.dot(&a);
            }
            if matches!(gear.spin, Spin::Speed(_)) {
                about -= a * about.dot(&a);
            }
            rates[i] = GearState {
                p: g.v,
                q: Quaternion::from_imag(w * 0.5) * g.orientation().into_inner(),
                v: total / MASS,
                l: about,
            };
        }
        rates
    }

    /// `state` one step `h` (s) of the classical Runge-Kutta method after `t`, the contact evaluated at every stage.
    pub fn step(&self, t: f64, state: &State, h: f64) -> Result<State> {
        runge_kutta_4(t, state, h, |t, y| {
            let out = self.contact(t, y)?;
            Ok(self.rates(t, y, &out.force, &out.moment))
        })
    }

    /// Kinetic energy, energy of the bearings and elastic energy of the mesh, J.
    pub fn energy(&self, t: f64, state: &State) -> Result<f64> {
        let mut energy = self.contact(t, state)?.energy;
        for (i, gear) in self.gears.iter().enumerate() {
            let g = &state[i];
            let (w, a) = (self.angular_velocity(t, i, g), g.axis());
            let spin = w.dot(&a);
            let across = (w - a * spin).norm_squared();
            energy += 0.5
                * (MASS * g.v.norm_squared() + TRANSVERSE_INERTIA * across + INERTIA * spin * spin);
            if let Some(b) = &gear.bearing {
                let displacement = g.p - gear.rest();
                energy += 0.5
                    * displacement.dot(&Vector3::from(b.stiffness).component_mul(&displacement));
                // Moment a × z times the stiffness is the gradient of 1 - a . z = |a - z|^2 / 2.
                energy += 0.5 * b.tilt_stiffness * (a - Vector3::z()).norm_squared();
            }
        }
        Ok(energy)
    }
}

/// One classical Runge-Kutta step of y' = f(t, y).
fn runge_kutta_4(
    t: f64,
    y: &State,
    h: f64,
    f: impl Fn(f64, &State) -> Result<State>,
) -> Result<State> {
    let ahead = |y: &State, k: &State, h: f64| [0, 1].map(|i| y[i].ahead(&k[i], h));
    let k1 = f(t, y)?;
    let k2 = f(t + 0.5 * h, &ahead(y, &k1, 0.5 * h))?;
    let k3 = f(t + 0.5 * h, &ahead(y, &k2, 0.5 * h))?;
    let k4 = f(t + h, &ahead(y, &k3, h))?;
    let weighted = [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)];
    Ok(weighted
        .iter()
        .fold(*y, |y, (k, weight)| ahead(&y, k, weight * h / 6.0)))
}

/// Order in which a master lets both sides step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Master {
    /// The element first: the gears step from t to t + H under the loads of the motion at t.
    Sequential,
    /// Both at once: the gears step from t to t + H under the loads of the motion at t - H.
    Parallel,
}

/// How a master couples, and what the element is told of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scheme {
    pub master: Master,
    /// What the element takes the master for.
    pub coupling: Coupling,
    /// Effective mass that it is told, kg; 0: none.
    pub effective_mass: f64,
}

impl Scheme {
    /// Held loads.
    pub fn held(master: Master) -> Self {
        Self {
            master,
            coupling: Coupling::Held,
            effective_mass: 0.0,
        }
    }

    /// Predicted loads.
    pub fn predicted(master: Master, effective_mass: f64) -> Self {
        let coupling = match master {
            Master::Sequential => Coupling::Sequential,
            Master::Parallel => Coupling::Parallel,
        };
        Self {
            master,
            coupling,
            effective_mass,
        }
    }
}

/// A running co-simulation.
pub struct CoSimulation<'a> {
    scene: &'a Scene,
    scheme: Scheme,
    /// Communication step H, s.
    step: f64,
    /// Runge-Kutta steps of the gears within one communication step.
    substeps: usize,
    /// Time, s.
    pub time: f64,
    /// State of the gears.
    pub state: State,
    /// Those that act in the next step of a parallel master.
    loads: Loads,
    last: Option<History>,
}

impl<'a> CoSimulation<'a> {
    /// Start at `state` and time zero, with communication step `step` (s) that the gears' own integrator
    /// divides into `substeps`.
    pub fn new(
        scene: &'a Scene,
        scheme: Scheme,
        state: State,
        step: f64,
        substeps: usize,
    ) -> Result<Self> {
        let loads = Loads::at(&scene.contact(0.0, &state)?);
        Ok(Self {
            scene,
            scheme,
            step,
            substeps,
            time: 0.0,
            state,
            loads,
            last: None,
        })
    }

    /// One communication step.
    pub fn advance(&mut self) -> Result<()> {
        let request = StepRequest {
            coupling: self.scheme.coupling,
            length: self.step,
            effective_mass: self.scheme.effective_mass,
        };
        let inputs = self.scene.inputs(self.time, &self.state);
        let (element, phase) = (&self.scene.element, &self.scene.phase);
        let workspace = &mut self.scene.workspace.borrow_mut();
        let predicted = element.predict(phase, &inputs, self.last.as_ref(), &request, workspace)?;
        let acting = match self.scheme.master {
            Master::Sequential => predicted.loads,
            Master::Parallel => self.loads,
        };
        (self.last, self.loads) = (predicted.history, predicted.loads);
        let part = |k: usize| Vector3::from_column_slice(&acting.0[k..][..3]);
        let (force, moment) = ([part(0), part(6)], [part(3), part(9)]);
        let h = self.step / self.substeps as f64;
        for n in 0..self.substeps {
            let rates = |t: f64, y: &State| Ok(self.scene.rates(t, y, &force, &moment));
            self.state = runge_kutta_4(self.time + n as f64 * h, &self.state, h, rates)?;
        }
        self.time += self.step;
        Ok(())
    }
}
