//! One mesh of the unit: its outputs and their derivatives, made when they are asked for.
//!
//! Both are a pure function of inputs, settings and phase zeros. What was made stays until one of these
//! changes, so that a host may read value by value and ask derivatives column by column.

use nalgebra::{Rotation3, SVector, Vector3};

use super::inputs::{InputValues, Resolution};
use super::layout::MeshVariables;
use super::report::{Refusal, refuse};
use super::resources::Resources;
use super::settings::Settings;
use crate::element::{
    BODY_COLUMNS, CONTINUOUS_OUTPUTS, Element, Formulation, Inputs, Jacobian, Latch, Motion,
    Outputs,
};
use crate::gear::PairGeometry;

/// A direction in the space of the motions of gear 1, gear 2 and carrier, as the columns of
/// [`Jacobian`].
pub(super) type Freedoms = SVector<f64, { 3 * BODY_COLUMNS }>;

/// Outputs at the present inputs.
pub struct Evaluated {
    /// As the element gives them.
    pub all: Outputs,
    /// The continuous ones in the order of their variables.
    pub continuous: [f64; CONTINUOUS_OUTPUTS],
}

/// One mesh.
pub struct Mesh {
    variables: &'static MeshVariables,
    /// What the teeth resolve: gear 1, gear 2, and the orientation of the carrier.
    resolution: [Resolution; 3],
    settings: Settings,
    latch: Option<Latch>,
    element: Option<Element>,
    /// Those of the last look at the inputs.
    motions: Inputs,
    outputs: Option<Evaluated>,
    /// Once they were asked for; whether they are those of the present inputs.
    slopes: Option<Box<Jacobian>>,
    slopes_are_present: bool,
}

impl Mesh {
    /// A mesh of `pair` whose teeth have no phases yet.
    pub fn new(variables: &'static MeshVariables, settings: Settings, pair: &PairGeometry) -> Self {
        let [z1, z2] = [pair.gears[0].z(), pair.gears[1].z()];
        let of = |teeth: f64| Resolution::new(teeth, pair.base_pitch());
        let carrier = Resolution {
            position: f64::INFINITY,
            ..of(z1.max(z2))
        };
        Self {
            variables,
            resolution: [of(z1), of(z2), carrier],
            settings,
            latch: None,
            element: None,
            motions: Inputs::default(),
            outputs: None,
            slopes: None,
            slopes_are_present: false,
        }
    }

    /// Its parameters.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Phase zeros; `None` until [`Mesh::take_phase`].
    pub fn latch(&self) -> Option<Latch> {
        self.latch
    }

    /// Its variables.
    pub fn variables(&self) -> &'static MeshVariables {
        self.variables
    }

    /// Takes other settings and phase zeros; what they leave valid is kept.
    ///
    /// # Errors
    /// A damping without meaning; the element is then made anew, or refused, when it is needed.
    pub fn configure(&mut self, settings: Settings, latch: Option<Latch>) -> Result<(), Refusal> {
        let before = std::mem::replace(&mut self.settings, settings);
        self.latch = latch;
        self.forget();
        if before == self.settings {
            return Ok(());
        }
        let element = self.element.take();
        if let Some(element) = element
            && before.differs_in_damping_alone(&self.settings)
        {
            let damping = self.settings.element.damping;
            self.element = Some(element.with_damping(damping).map_err(refuse)?);
        }
        Ok(())
    }

    /// Inputs have changed.
    #[inline]
    pub fn forget(&mut self) {
        self.outputs = None;
        self.slopes_are_present = false;
    }

    /// Outputs, if they were made since the last change.
    #[inline]
    pub fn present(&self) -> Option<&Evaluated> {
        self.outputs.as_ref()
    }

    fn make_element(&mut self, resources: &Resources) -> Result<(), Refusal> {
        if self.element.is_none() {
            self.element = Some(resources.element(&self.settings.element)?);
        }
        Ok(())
    }

    fn uses_carrier(&self) -> bool {
        self.settings.element.formulation == Formulation::Paper
    }

    /// Whether its outputs depend on the motion of `body`.
    pub fn looks_at(&self, body: usize) -> bool {
        let is_carrier = body == self.variables.carrier && self.uses_carrier();
        is_carrier || self.variables.gears.contains(&body)
    }

    /// Takes the motions that the element looks at from `inputs`.
    fn look(&mut self, inputs: &InputValues) -> Result<(), Refusal> {
        let bodies = self.variables.bodies();
        let with_carrier = self.uses_carrier();
        let (orientation, resolution) = (self.settings.orientation, self.resolution);
        let write = |k: usize, motion: &mut Motion| {
            inputs.write_motion(bodies[k], orientation, resolution[k], motion)
        };
        let Inputs {
            gears: [first, second],
            carrier,
        } = &mut self.motions;
        write(0, first)?;
        write(1, second)?;
        if with_carrier {
            write(2, carrier)?;
            // The place and velocity of its origin cancel out; gear 1's are those that cost no rounding.
            (carrier.p, carrier.v) = (first.p, first.v);
        }
        Ok(())
    }

    /// Element, phase zeros (before they are taken: those of the present pose) and motions.
    fn ready(
        &mut self,
        resources: &Resources,
        inputs: &InputValues,
    ) -> Result<(&Element, Latch, &Inputs), Refusal> {
        self.look(inputs)?;
        let latched = self.latch;
        self.make_element(resources)?;
        let element = self.element.as_ref().expect("made above");
        let latch = match latched {
            Some(latch) => latch,
            None => element.latch(&self.motions).map_err(refuse)?,
        };
        Ok((element, latch, &self.motions))
    }

    /// Keeps the phase zeros of the present pose.
    ///
    /// # Errors
    /// Parameters without meaning, poses that can be no mesh.
    pub fn take_phase(
        &mut self,
        resources: &Resources,
        inputs: &InputValues,
    ) -> Result<(), Refusal> {
        self.latch = None;
        let (element, latch, motions) = self.ready(resources, inputs)?;
        element.check_start(&latch, motions).map_err(refuse)?;
        self.latch = Some(latch);
        self.slopes_are_present = false;
        Ok(())
    }

    /// Outputs at `inputs`; the error is `Ok` inside where it is the number of a continuous output that
    /// is not finite.
    pub fn evaluate(
        &mut self,
        resources: &Resources,
        inputs: &InputValues,
    ) -> Result<&Evaluated, Failure> {
        if self.outputs.is_none() {
            let (element, latch, motions) = self.ready(resources, inputs)?;
            let all = element.evaluate(&latch, motions).map_err(refuse)?;
            let continuous = all.to_array();
            finite(&continuous).map_err(|failure| explained(element, failure))?;
            self.outputs = Some(Evaluated { all, continuous });
        }
        Ok(self.outputs.as_ref().expect("evaluated above"))
    }

    /// What puts the pose of outputs at hand that are out of range there, empty where it is the load alone; `None` where
    /// they are in range or not at hand.
    pub fn out_of_range(&mut self, resources: &Resources, inputs: &InputValues) -> Option<String> {
        let outputs = self.outputs.as_ref().filter(|o| o.all.out_of_range)?.all;
        self.look(inputs).ok()?;
        self.make_element(resources).ok()?;
        let element = self.element.as_ref()?;
        element.out_of_range(&self.motions, &outputs).ok()
    }

    /// Derivatives of the continuous outputs along `direction`.
    pub fn along(
        &mut self,
        resources: &Resources,
        inputs: &InputValues,
        direction: &Freedoms,
    ) -> Result<[f64; CONTINUOUS_OUTPUTS], Failure> {
        let mut slopes = self
            .slopes
            .take()
            .unwrap_or_else(|| Box::new(Jacobian::zeros()));
        if !self.slopes_are_present {
            self.jacobian(resources, inputs, &mut slopes)?;
            self.slopes_are_present = true;
        }
        let by_freedoms: &Jacobian = &slopes;
        let all: [f64; CONTINUOUS_OUTPUTS] = (by_freedoms * direction).into();
        self.slopes = Some(slopes);
        finite(&all).map_err(|failure| match &self.element {
            Some(element) => explained(element, failure),
            None => failure,
        })?;
        Ok(all)
    }

    /// All partial derivatives. While the phase zeros follow the pose, they have a share in them.
    fn jacobian(
        &mut self,
        resources: &Resources,
        inputs: &InputValues,
        jacobian: &mut Jacobian,
    ) -> Result<(), Refusal> {
        let follows = self.latch.is_none();
        let bodies = if self.uses_carrier() { 3 } else { 2 };
        let (element, latch, motions) = self.ready(resources, inputs)?;
        element
            .jacobian(&latch, motions, jacobian)
            .map_err(refuse)?;
        if !follows {
            return Ok(());
        }
        // A change of the phase zeros is a spin of the gears: only gear 1's moves the mesh position,
        // by z1 / 2 pi per radian, and the tooth angle takes z1 and e z2.
        let pair = &resources.unit.geometry;
        let spin = |gear: usize| {
            let axis = motions.gears[gear].r.column(2).into_owned();
            let first = BODY_COLUMNS * gear + ROTATION;
            jacobian.fixed_columns::<3>(first) * axis
        };
        let by_spin = [spin(0), spin(1)];
        for body in 0..bodies {
            for k in 0..ROTATION + 3 {
                let change = latch_rate(element, motions, body, k)?;
                let first = change.mesh_position * std::f64::consts::TAU / pair.gears[0].z();
                let rest = change.tooth_angle - first * pair.gears[0].z();
                let second = rest / (pair.e() * pair.gears[1].z());
                let mut column = jacobian.column_mut(BODY_COLUMNS * body + k);
                column += by_spin[0] * first + by_spin[1] * second;
            }
        }
        Ok(())
    }
}

/// First of a body's rotations among its columns of the Jacobian; translations come before.
const ROTATION: usize = 3;

/// Rate of the phase zeros with freedom `k` (translations, then rotations) of `body`, by central
/// differences: they are two smooth functions of the pose and have no kinks, so that these are good to
/// nine digits.
fn latch_rate(
    element: &Element,
    motions: &Inputs,
    body: usize,
    k: usize,
) -> Result<Latch, Refusal> {
    /// Small against a tooth in metres and in radians, large against rounding.
    const STEP: f64 = 1e-6;
    let at = |h: f64| {
        let mut moved = *motions;
        let motion = match body {
            0 | 1 => &mut moved.gears[body],
            _ => &mut moved.carrier,
        };
        if k < ROTATION {
            motion.p[k] += h;
        } else {
            let turn = Rotation3::new(Vector3::ith(k - ROTATION, h));
            motion.r = turn.matrix() * motion.r;
        }
        element.latch(&moved).map_err(refuse)
    };
    let (before, after) = (at(-STEP)?, at(STEP)?);
    // Angles may jump by whole turns between both sides, mesh positions by whole pitches.
    let rate =
        |change: f64, period: f64| (change - period * (change / period).round()) / (2.0 * STEP);
    Ok(Latch {
        tooth_angle: rate(
            after.tooth_angle - before.tooth_angle,
            std::f64::consts::TAU,
        ),
        mesh_position: rate(after.mesh_position - before.mesh_position, 1.0),
    })
}

/// Why there are no outputs.
#[derive(Debug)]
pub enum Failure {
    /// The element refuses.
    Refused(Refusal),
    /// The continuous output in this place is not finite.
    NotFinite(usize),
}

impl From<Refusal> for Failure {
    fn from(refusal: Refusal) -> Self {
        Failure::Refused(refusal)
    }
}

/// `failure`, or what a law of `element` says of it.
fn explained(element: &Element, failure: Failure) -> Failure {
    let said = element.refusal().map(Refusal::error);
    said.map_or(failure, Failure::Refused)
}

fn finite(all: &[f64; CONTINUOUS_OUTPUTS]) -> Result<(), Failure> {
    let bad = all.iter().position(|x| !x.is_finite());
    bad.map_or(Ok(()), |row| Err(Failure::NotFinite(row)))
}
