//! Two gears, their bearings and what drives them.

use super::state::{GEAR_STATES, GearState, State, gear_state, set_gear_state};
use gearmesh::element::{Element, ElementError, Inputs, Latch, Motion, Outputs};
use nalgebra::{UnitQuaternion, Vector3};
use std::sync::Arc;

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

/// Which freedoms a gear has besides its spin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Freedoms {
    /// Translation along world x, y, z.
    pub translation: [bool; 3],
    /// Tilt about both axes across the gear's.
    pub tilt: bool,
}

impl Freedoms {
    /// All of them: six with the spin.
    pub const ALL: Self = Self {
        translation: [true; 3],
        tilt: true,
    };
}

/// Spring and damper between the gear and its rest position.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bearing {
    /// Translational stiffness along x, y, z, N/m.
    pub stiffness: [f64; 3],
    /// Translational damping along x, y, z, N s/m.
    pub damping: [f64; 3],
    /// Tilt stiffness, N m/rad.
    pub tilt_stiffness: f64,
    /// Tilt damping, N m s/rad.
    pub tilt_damping: f64,
    /// Torsional stiffness against the zero angle, N m/rad; for angles below half a turn.
    pub spin_stiffness: f64,
}

/// One gear as a rigid body.
#[derive(Clone)]
pub struct Gear {
    /// Mass, kg.
    pub mass: f64,
    /// Moment of inertia about the axis, kg m^2.
    pub polar_inertia: f64,
    /// Moment of inertia across the axis, through the centre of mass, kg m^2.
    pub transverse_inertia: f64,
    /// Centre of mass on the axis from the z = 0 face, m.
    pub center_of_mass: f64,
    /// Rest position of the origin, m, W; the axis at rest is world z.
    pub origin: Vector3<f64>,
    /// Bearing.
    pub bearing: Bearing,
    /// Freedoms besides the spin.
    pub freedoms: Freedoms,
    /// Spin.
    pub spin: Spin,
}

/// Two gears coupled by an element.
#[derive(Clone)]
pub struct Scene {
    /// The element.
    pub element: Element,
    /// Its phase zeros.
    pub latch: Latch,
    /// Both gears.
    pub gears: [Gear; 2],
}

impl Scene {
    /// A scene that starts in the element's nominal pose, with its latch taken there.
    ///
    /// # Errors
    /// As [`Element::latch`].
    pub fn new(element: Element, gears: [Gear; 2]) -> Result<Self, ElementError> {
        let latch = element.latch(&element.nominal_inputs())?;
        Ok(Self {
            element,
            latch,
            gears,
        })
    }

    /// At rest, apart from imposed speeds, with zero angles.
    pub fn rest(&self) -> State {
        let mut state = [0.0; 2 * GEAR_STATES];
        for (i, gear) in self.gears.iter().enumerate() {
            let spin = match &gear.spin {
                Spin::Torque(_) => 0.0,
                Spin::Speed(f) => f(0.0),
            };
            set_gear_state(
                &mut state,
                i,
                &GearState {
                    p: gear.origin + Vector3::z() * gear.center_of_mass,
                    q: UnitQuaternion::identity(),
                    v: Vector3::zeros(),
                    l: Vector3::z() * (spin * gear.polar_inertia),
                },
            );
        }
        state
    }

    /// `state` with gear `i` turned about its axis by `angle` (rad) and spinning at `rate` (rad/s).
    pub fn with_spin(&self, state: &State, i: usize, angle: f64, rate: f64) -> State {
        let mut out = *state;
        let mut g = gear_state(state, i);
        g.q *= UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
        let a = g.q * Vector3::z();
        g.l += a * (self.gears[i].polar_inertia * rate - g.l.dot(&a));
        set_gear_state(&mut out, i, &g);
        out
    }

    /// Angular velocity of gear `i`, rad/s, W.
    pub fn angular_velocity(&self, t: f64, i: usize, g: &GearState) -> Vector3<f64> {
        let gear = &self.gears[i];
        let a = g.q * Vector3::z();
        let along = g.l.dot(&a);
        let spin = match &gear.spin {
            Spin::Torque(_) => along / gear.polar_inertia,
            Spin::Speed(f) => f(t),
        };
        let across = if gear.freedoms.tilt {
            (g.l - a * along) / gear.transverse_inertia
        } else {
            Vector3::zeros()
        };
        a * spin + across
    }

    /// The element's inputs at `state`; the carrier is the world.
    pub fn inputs(&self, t: f64, state: &State) -> Inputs {
        Inputs {
            gears: [0, 1].map(|i| {
                let g = gear_state(state, i);
                let w = self.angular_velocity(t, i, &g);
                let r = *g.q.to_rotation_matrix().matrix();
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
    ///
    /// # Errors
    /// As [`Element::evaluate`].
    pub fn contact(&self, t: f64, state: &State) -> Result<Outputs, ElementError> {
        self.element.evaluate(&self.latch, &self.inputs(t, state))
    }

    /// Rates of `state` with the contact's `force` and `moment` (about each gear's origin) given.
    pub fn rates(
        &self,
        t: f64,
        state: &State,
        force: &[Vector3<f64>; 2],
        moment: &[Vector3<f64>; 2],
    ) -> State {
        let mut rates = [0.0; 2 * GEAR_STATES];
        for (i, gear) in self.gears.iter().enumerate() {
            let g = gear_state(state, i);
            let w = self.angular_velocity(t, i, &g);
            let a = g.q * Vector3::z();
            let displacement = g.p - gear.origin - Vector3::z() * gear.center_of_mass;
            let b = &gear.bearing;
            let mut total = force[i];
            for k in 0..3 {
                total[k] -= b.stiffness[k] * displacement[k] + b.damping[k] * g.v[k];
                if !gear.freedoms.translation[k] {
                    total[k] = 0.0;
                }
            }
            let tilt_rate = w - a * w.dot(&a);
            let mut about = moment[i] + (a * gear.center_of_mass).cross(&force[i]) * -1.0;
            about += a.cross(&Vector3::z()) * b.tilt_stiffness - tilt_rate * b.tilt_damping;
            let twist_axis = (a + Vector3::z()) / (1.0 + a.z);
            let mut torque = -b.spin_stiffness * twist(&g.q);
            if let Spin::Torque(f) = &gear.spin {
                torque += f(t, w.dot(&a));
            }
            about += twist_axis * torque;
            if !gear.freedoms.tilt {
                about = a * about.dot(&a);
            }
            if matches!(gear.spin, Spin::Speed(_)) {
                about -= a * about.dot(&a);
            }
            let turn = nalgebra::Quaternion::from_imag(w * 0.5) * g.q.quaternion();
            let s = &mut rates[i * GEAR_STATES..(i + 1) * GEAR_STATES];
            s[0..3].copy_from_slice(g.v.as_slice());
            s[3..7].copy_from_slice(&[turn.w, turn.i, turn.j, turn.k]);
            s[7..10].copy_from_slice((total / gear.mass).as_slice());
            s[10..13].copy_from_slice(about.as_slice());
        }
        rates
    }

    /// Rates of `state` at `t`.
    ///
    /// # Errors
    /// As [`Element::evaluate`].
    pub fn coupled_rates(&self, t: f64, state: &State) -> Result<State, ElementError> {
        let out = self.contact(t, state)?;
        Ok(self.rates(t, state, &out.force, &out.moment))
    }

    /// Kinetic energy, energy of the bearings and elastic energy of the mesh, J.
    ///
    /// # Errors
    /// As [`Element::evaluate`].
    pub fn energy(&self, t: f64, state: &State) -> Result<f64, ElementError> {
        let mut energy = self.contact(t, state)?.energy;
        for (i, gear) in self.gears.iter().enumerate() {
            let g = gear_state(state, i);
            let a = g.q * Vector3::z();
            let w = self.angular_velocity(t, i, &g);
            let displacement = g.p - gear.origin - Vector3::z() * gear.center_of_mass;
            let spin = w.dot(&a);
            let across = (w - a * spin).norm_squared();
            energy += 0.5
                * (gear.mass * g.v.norm_squared()
                    + gear.transverse_inertia * across
                    + gear.polar_inertia * spin * spin);
            let b = &gear.bearing;
            for k in 0..3 {
                energy += 0.5 * b.stiffness[k] * displacement[k].powi(2);
            }
            // Moment a × z times the stiffness is the gradient of 1 - a . z = |a - z|^2 / 2.
            energy += 0.5 * b.tilt_stiffness * (a - Vector3::z()).norm_squared();
            energy += 0.5 * b.spin_stiffness * twist(&g.q).powi(2);
        }
        Ok(energy)
    }
}

/// Angle of rotation about world z (twist of the swing-twist decomposition), [-pi, pi).
pub fn twist(q: &UnitQuaternion<f64>) -> f64 {
    let angle = 2.0 * q.k.atan2(q.w);
    angle - std::f64::consts::TAU * (angle / std::f64::consts::TAU).round()
}
