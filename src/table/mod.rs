//! Tables of force and shuttling over (displacement, centre distance, misalignment, mesh position).
//!
//! # Coordinates
//! The displacement delta is scaled between the no-load approach D0(C, M, PMC) and the top-load approach D1(C, M, PMC):
//! u = (delta - D0) / (D1 - D0). The onset of contact is u = 0 everywhere, never inside a cell.
//!
//! # One potential
//! A flank is a potential W(delta, C, M, PMC) (see [`Potential`]): the force is dW/d delta, shuttling dW/dM, and
//! dW/dC and dW/dPMC close the energy balance.

mod axes;
mod axis;
mod block;
mod error;
mod file;
mod grid;
mod interpolation;
mod records;
#[cfg(test)]
#[path = "../../tests/common/spring.rs"]
pub mod samples;
mod teeth;

pub use crate::accuracy::{InterpolationError, RootStressError};
pub use axes::{Axes, least_distance};
pub use axis::Axis;
pub use error::TableError;
pub use file::{TableFile, VERSION};
pub use grid::FlankGrid;
pub use interpolation::{FlankTable, Interpolation, LoadJet, LoadSpline};
pub use records::{
    Columns, FrictionRecord, LoadAxes, RootStressRecord, RootStressSamples, SlidingSamples,
};
pub use teeth::{GearTeethRecord, TeethFlank, TeethRecord};

use crate::gear::Flank;
use std::sync::Arc;

/// A point of the table of one flank (coast flank: after mapping to its own table).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Query {
    /// Approach of the teeth on the line of action at mid-face, m; > 0 in contact.
    pub delta: f64,
    /// Actual minus nominal centre distance, m.
    pub center_distance_offset: f64,
    /// Misalignment in the plane of action, rad; > 0: more penetration at larger z.
    pub misalignment: f64,
    /// Position on the mesh cycle, in base pitches; periodic.
    pub mesh_position: f64,
}

/// Number of coordinates of a [`Query`], in the order of its fields.
pub const COORDINATES: usize = 4;

impl Query {
    /// Its fields, in their order.
    #[inline]
    pub fn coordinates(&self) -> [f64; COORDINATES] {
        [
            self.delta,
            self.center_distance_offset,
            self.misalignment,
            self.mesh_position,
        ]
    }
}

impl From<[f64; COORDINATES]> for Query {
    #[inline]
    fn from([delta, c, m, p]: [f64; COORDINATES]) -> Self {
        Query {
            delta,
            center_distance_offset: c,
            misalignment: m,
            mesh_position: p,
        }
    }
}

/// The potential of one flank and its derivatives by the coordinates of [`Query`] in their order
/// (delta, centre distance offset, misalignment, mesh position). All zero out of contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Potential {
    /// W, J.
    pub value: f64,
    /// First derivatives: F_bt = `gradient[0]`, shuttling moment F_bt (z_c - z_ref) = `gradient[2]`, z_c where the resultant
    /// crosses the pitch plane.
    pub gradient: [f64; COORDINATES],
    /// `hessian[i][j]` = d `gradient[i]` / d coordinate j. `hessian[0][0]`, the tangent stiffness on the
    /// line of action, is always there, the rest zero unless requested. Symmetric, but for row 2 where
    /// the moment is not dW/dM: tables without a misalignment axis, and constant load.
    pub hessian: [[f64; COORDINATES]; COORDINATES],
    /// True where a coordinate lies outside the table's range.
    pub out_of_range: bool,
}

/// How the stiffness depends on the load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load {
    /// Force over displacement as tabulated.
    Variable,
    /// Secant stiffness at this transverse force on the line of action, N, paper (21)-(22).
    Constant {
        /// F_bt.
        loa_force: f64,
    },
}

/// What a table depends on. An effect that is off costs neither time nor memory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effects {
    /// Between the nodes.
    pub interpolation: Interpolation,
    /// Load dependence.
    pub load: Load,
    /// Actual centre distance; off: nominal.
    pub center_distance: bool,
    /// Misalignment; off: parallel axes.
    pub misalignment: bool,
    /// Moment of the axial position of the contact. With misalignment on and variable load it comes with
    /// the potential, otherwise from a table of its own.
    pub shuttling: bool,
    /// How the load slides, for friction.
    pub friction: bool,
    /// Stress in the tooth roots.
    pub root_stress: bool,
    /// Tooth pair by tooth pair, for teeth that differ.
    pub teeth: bool,
}

impl Effects {
    /// The spline and a variable load with all that `axes` have, and of the force alone.
    pub fn of_axes(axes: &Axes) -> Self {
        let [center_distance, misalignment, _] = axes.present();
        Effects {
            interpolation: Interpolation::Spline,
            load: Load::Variable,
            center_distance,
            misalignment,
            shuttling: misalignment,
            friction: false,
            root_stress: false,
            teeth: false,
        }
    }

    fn axes(&self) -> [bool; 2] {
        [self.center_distance, self.misalignment]
    }
}

/// Everything of one pair at run time. Read-only; share it by `Arc`.
#[derive(Debug)]
pub struct Table {
    /// Samples, settings, measured error, and the pair.
    pub file: Arc<TableFile>,
    /// What it answers to.
    pub effects: Effects,
    force: Flanks<FlankTable>,
    sliding: Option<Flanks<LoadSpline>>,
    root_stress: Option<Flanks<LoadSpline>>,
    teeth: Option<[TeethFlank; 2]>,
}

#[derive(Debug)]
struct Flanks<T> {
    drive: T,
    /// `None`: the coast flank is the drive flank mirrored.
    coast: Option<T>,
}

impl<T> Flanks<T> {
    fn new<S>(
        drive: &S,
        coast: &Option<S>,
        make: impl Fn(&S) -> Result<T, TableError>,
    ) -> Result<Self, TableError> {
        Ok(Flanks {
            drive: make(drive)?,
            coast: coast.as_ref().map(make).transpose()?,
        })
    }

    /// That of `flank`, and whether it is the drive flank's, mirrored.
    fn get(&self, flank: Flank) -> (&T, bool) {
        match (flank, &self.coast) {
            (Flank::Drive, _) => (&self.drive, false),
            (Flank::Coast, Some(own)) => (own, false),
            (Flank::Coast, None) => (&self.drive, true),
        }
    }
}

fn if_on<T>(on: bool, record: &Option<T>, missing: TableError) -> Result<Option<&T>, TableError> {
    match on {
        true => record.as_ref().ok_or(missing).map(Some),
        false => Ok(None),
    }
}

impl Table {
    /// With all axes of the checked `file`, the spline, variable load and shuttling.
    ///
    /// # Errors
    /// As [`FlankTable::new`].
    pub fn from_file(file: TableFile) -> Result<Self, TableError> {
        let mut effects = Effects::of_axes(&file.axes);
        effects.shuttling |= file.drive.moment.is_some();
        Self::with_effects(Arc::new(file), effects)
    }

    /// The tables of `file`, which stays shared, with only the dimensions that `effects` switch on.
    ///
    /// # Errors
    /// An effect whose axis is missing; a constant load outside the range.
    pub fn with_effects(file: Arc<TableFile>, effects: Effects) -> Result<Self, TableError> {
        let spline = |axes: &LoadAxes, columns: Columns<'_>| {
            LoadSpline::new(axes.nodes(), &columns, effects.axes())
        };
        // Tooth pairs one by one slide as their own loads do.
        let slides = effects.friction && !effects.teeth;
        let sliding = if_on(slides, &file.friction, TableError::NO_FRICTION)?
            .map(|r| Flanks::new(&r.drive, &r.coast, |s| spline(&r.axes, s.columns())));
        let missing = TableError::NO_ROOT_STRESS;
        let stress = if_on(effects.root_stress, &file.root_stress, missing)?
            .map(|r| Flanks::new(&r.drive, &r.coast, |s| spline(&r.axes, s.columns())));
        let teeth = if_on(effects.teeth, &file.teeth, TableError::NO_TEETH)?
            .map(|record| TeethFlank::both(record, &file.geometry, &effects));
        let flank = |grid: &FlankGrid| Ok(flank_table(grid.on(&file.axes), &effects)?.1);
        Ok(Table {
            force: Flanks::new(&file.drive, &file.coast, flank)?,
            sliding: sliding.transpose()?,
            root_stress: stress.transpose()?,
            teeth: teeth.transpose()?,
            effects,
            file,
        })
    }

    /// The table of `flank`, and whether it is the drive flank's mirrored: then evaluate it at -M and take the opposite moment.
    pub fn flank(&self, flank: Flank) -> (&FlankTable, bool) {
        self.force.get(flank)
    }

    /// How the load of `flank` slides; mirrored, take the opposite axial position. None where the effect is off.
    pub fn sliding(&self, flank: Flank) -> Option<(&LoadSpline, bool)> {
        Some(self.sliding.as_ref()?.get(flank))
    }

    /// Stress in the roots under the load of `flank`, likewise.
    pub fn root_stress(&self, flank: Flank) -> Option<(&LoadSpline, bool)> {
        Some(self.root_stress.as_ref()?.get(flank))
    }

    /// Tooth pairs of `flank` one by one, as [`Table::flank`]. None where the effect is off.
    pub fn teeth(&self, flank: Flank) -> Option<(&TeethFlank, bool)> {
        let [drive, coast] = self.teeth.as_ref()?;
        let own = self.file.teeth.as_ref()?.coast.is_some();
        Some(match flank {
            Flank::Drive => (drive, false),
            Flank::Coast => (coast, !own),
        })
    }
}

/// What is left of `grid` with only the dimensions that `effects` switch on, and its interpolant.
fn flank_table(
    mut grid: FlankGrid,
    effects: &Effects,
) -> Result<(FlankGrid, FlankTable), TableError> {
    let axes = [Axis::CenterDistance, Axis::Misalignment];
    for ((axis, on), missing) in axes
        .into_iter()
        .zip(effects.axes())
        .zip(TableError::NO_AXIS)
    {
        if !on {
            grid = grid.sliced(axis)?;
        } else if !grid.axes.present()[axis as usize] {
            return Err(missing);
        }
    }
    let from_potential = effects.misalignment && effects.load == Load::Variable;
    if !effects.shuttling {
        grid.moment = None;
    } else if grid.moment.is_none() && !from_potential {
        return Err(TableError::NO_MOMENT);
    }
    let table = match effects.load {
        Load::Variable => FlankTable::new(&grid, effects.interpolation)?,
        Load::Constant { loa_force } => {
            FlankTable::constant_load(&grid, effects.interpolation, loa_force)?
        }
    };
    Ok((grid, table))
}
