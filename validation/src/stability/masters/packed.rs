//! The packed pair that all meshes have, its unit by its coupling, and that unit as it meshes.

use crate::{Result, in_repository};
use gearmesh::element::Coupling;
use gearmesh::fmi::instance::Instance;
use gearmesh::fmi::lifecycle::Interface;
use gearmesh::fmi::resources::{Resources, UNIT_VERSION, UnitFile};
use gearmesh::fmi::variables::{Kind, VARIABLES, index};
use gearmesh::table::TableFile;
use gearmesh_preprocessor::package::Starts;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The packed pair that all meshes have, and its unit by its coupling.
pub struct Packed {
    /// In the order of `Coupling` and of its numbers in modelDescription.xml.
    pub(super) units: Vec<Arc<Resources>>,
    /// Of gear 1, m.
    pub(super) base_radius: f64,
    pub(super) teeth: f64,
    pub(super) ratio: f64,
    /// Effective mass, kg, of both gears; stiffness, N/m, and load, N, on the line of action.
    pub(super) mass: f64,
    pub(super) stiffness: f64,
    pub(super) load: f64,
    /// Packed step, s.
    pub step: f64,
}

impl Packed {
    /// The shipped pair `name` with both flanks.
    pub fn new(name: &str) -> Result<Self> {
        Self::with_damping(name, 1.0)
    }

    /// The same with `share` of the packed damping.
    pub fn with_damping(name: &str, share: f64) -> Result<Self> {
        let tables = TableFile::read(in_repository(&format!("resources/tables/{name}.json")))?;
        let geometry = tables.geometry.clone();
        let dynamics = Starts::of_tables(&tables)?.dynamics(&geometry);
        let cosine = geometry
            .operating_pressure_angle(geometry.center_distance)
            .cos();
        let starts = [
            (index::STIFFNESS_MODEL, 2.0),
            (index::NOMINAL_TORQUE, tables.nominal_torque_nm),
            (index::CONSTANT_STIFFNESS, dynamics.stiffness.mean),
            (index::GEAR2_POSITION_1, geometry.center_distance),
            (index::GEAR2_POSITION_3, geometry.gears[1].face_offset),
            (index::DAMPING, share * dynamics.damping),
            (index::EFFECTIVE_MASS, dynamics.effective_mass),
            (index::LOADED_FLANK, 3.0),
            (index::BACKLASH, 100e-6),
        ];
        let units = [1.0, 2.0, 3.0, 4.0].map(|coupling| {
            let starts = starts.into_iter().chain([(index::COUPLING, coupling)]);
            let starts: BTreeMap<_, _> = starts
                .map(|(i, value)| (VARIABLES[i].name.to_owned(), value))
                .collect();
            let unit = UnitFile {
                version: UNIT_VERSION,
                guid: String::new(),
                name: name.into(),
                starts,
                geometry: geometry.clone(),
            };
            Resources::new(unit, Some(tables.clone()), None).map(Arc::new)
        });
        Ok(Self {
            units: units.into_iter().collect::<std::result::Result<_, _>>()?,
            base_radius: geometry.gears[0].base_radius(),
            teeth: geometry.gears[0].z(),
            ratio: -geometry.e() * geometry.gears[0].z() / geometry.gears[1].z(),
            mass: dynamics.effective_mass,
            stiffness: dynamics.stiffness.mean / cosine.powi(2),
            load: tables.nominal_torque_nm / geometry.gears[0].base_radius(),
            step: dynamics.step(),
        })
    }

    pub(super) fn omega(&self) -> f64 {
        (self.stiffness / self.mass).sqrt()
    }

    /// Both gears as steel bodies, of equal masses.
    pub(super) fn gear(&self) -> f64 {
        2.0 * self.mass
    }
}

/// One unit and its gear 1 and gear 2 as they turn.
pub(super) struct Mesh {
    unit: Instance,
}

impl Mesh {
    pub(super) fn new(p: &Packed, coupling: Coupling) -> Result<Self> {
        let resources = p.units[coupling as usize].clone();
        let mut unit = Instance::new(resources, Interface::CoSimulation);
        unit.setup(0.0, None)?;
        unit.exit_initialization()?;
        Ok(Self { unit })
    }

    /// Force on the line of action for a step of `step` s at the `approach` and its rate, while both gears turn by `angle` at `speed`.
    pub(super) fn step(
        &mut self,
        p: &Packed,
        [angle, speed]: [f64; 2],
        [approach, rate]: [f64; 2],
        step: f64,
        derivatives: bool,
    ) -> Result<f64> {
        let inputs = [
            (index::GEAR1_ANGLES_3, angle + approach / p.base_radius),
            (
                index::GEAR1_ANGULAR_VELOCITY_3,
                speed + rate / p.base_radius,
            ),
            (index::GEAR2_ANGLES_3, p.ratio * angle),
            (index::GEAR2_ANGULAR_VELOCITY_3, p.ratio * speed),
        ];
        let references = inputs.map(|(i, _)| VARIABLES[i].value_reference);
        self.unit
            .set(Kind::Real, &references, &inputs.map(|(_, x)| x))?;
        if derivatives {
            let angles = [references[0], references[2]];
            let speeds = [inputs[1].1, inputs[3].1];
            self.unit.set_input_derivatives(&angles, &[1, 1], &speeds)?;
        }
        self.unit.do_step(self.unit.time(), step)?;
        let mut moment = 0.0;
        let reference = [VARIABLES[index::GEAR1_MOMENT_3].value_reference];
        self.unit.get(Kind::Real, &reference, |x| moment = x[0])?;
        Ok(-moment / p.base_radius)
    }
}
