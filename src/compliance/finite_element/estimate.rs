//! What a model will take, from its mesh alone.

use super::cache::ModelCache;
use super::model::Model;
use super::{FiniteElementError, Settings, harmonics};
use crate::gear::Gear;

/// What a model will take.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Estimate {
    /// Whether it is kept already, so that it takes no time.
    pub kept: bool,
    /// Time for assembly, condensation and ring on a machine with two cores, s; on others in proportion.
    pub seconds: [f64; 3],
    /// Largest working memory, bytes.
    pub memory_bytes: f64,
    /// Size in the cache, bytes.
    pub file_bytes: f64,
}

/// Time to integrate and assemble one element, s.
const ELEMENT: f64 = 1e-4;
/// Operations per second of dense kernels.
const DENSE: f64 = 30e9;
/// Entries of the factor of the inside over the 1.5th power of the unknowns: nested dissection of a thin solid.
const FILL: f64 = 3.6;
/// Numbers kept at most while a sector is eliminated, over the square of the unknowns and loads of its sides.
const FRONTS: f64 = 1.7;
/// Entries of the stiffness matrix per unknown, lower triangle.
const ENTRIES: f64 = 80.0;
/// Modes in which the loads act on the sides, per load.
const MODES: f64 = 0.45;
/// Bytes of an entry of the influence in a file.
const BYTES: f64 = 1.7;

impl Estimate {
    /// For the model of `gear`, to be kept in `cache` if there is one.
    ///
    /// # Errors
    /// [`FiniteElementError`] for a gear that cannot be meshed.
    pub fn new(
        gear: &Gear,
        settings: &Settings,
        cache: Option<&ModelCache>,
    ) -> Result<Estimate, FiniteElementError> {
        let model = Model::new(gear, settings)?;
        let mesh = &model.mesh;
        let held = mesh.held.iter().filter(|held| **held).count();
        let free = mesh.points.len() - held - mesh.hanging.len();
        let unknowns = (mesh.dimension * free) as f64;
        let loads = mesh.flank.len() as f64;
        let side = (mesh.dimension * mesh.sides[0].len()) as f64;
        let matrices = settings.reach as f64 + 1.0;
        let factor = FILL * unknowns.powf(1.5);
        let last = 2.0 * (side + loads);
        let condensation = factor * (0.25 * factor / unknowns + 0.5 * (side + loads));
        // Complex: four times the operations.
        let few = MODES * loads;
        let harmonic =
            4.0 * (side.powi(3) / 6.0 + 0.5 * side * side * few + 0.5 * side * few * few);
        let harmonics = harmonics::solved(gear.teeth as usize, 0).len() as f64;
        let turned = gear.turned().map(|gear| Model::new(&gear, settings));
        let models = 1.0 + turned.iter().count() as f64;
        let turned = turned.transpose()?;
        Ok(Estimate {
            kept: cache.is_some_and(|cache| {
                let mut all = std::iter::once(&model).chain(&turned);
                all.all(|model| cache.holds(model, settings))
            }),
            seconds: [
                models * ELEMENT * mesh.cells.len() as f64,
                models * condensation / DENSE,
                models * harmonics * harmonic / DENSE,
            ],
            memory_bytes: 8.0
                * (FRONTS * last * last
                    + 2.0 * ENTRIES * unknowns
                    + (1.0 + models) * matrices * loads * loads),
            file_bytes: models * BYTES * matrices * loads * loads,
        })
    }

    /// Time that it will take, s; none for what is kept.
    pub fn total_seconds(&self) -> f64 {
        if self.kept {
            0.0
        } else {
            self.seconds.iter().sum()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compliance::finite_element::FiniteElementCompliance;
    use crate::gear::{GearKind, samples};
    use crate::pair::Refinement;

    #[test]
    fn unknowns_are_counted_and_a_kept_model_takes_no_time() {
        let gear = Gear {
            face_width: 12e-3,
            ..samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0)
        };
        let settings = Settings::new(Refinement::Coarse, 2);
        let folder = tempfile::tempdir().unwrap();
        let cache = ModelCache::new(folder.path(), ModelCache::DEFAULT_LIMIT);
        let before = Estimate::new(&gear, &settings, Some(&cache)).unwrap();
        assert!(!before.kept && before.total_seconds() > 0.0);
        let (model, _) =
            FiniteElementCompliance::cached(&gear, &settings, &cache, &|_, _| true).unwrap();
        let after = Estimate::new(&gear, &settings, Some(&cache)).unwrap();
        assert!(after.kept && after.total_seconds() == 0.0);
        let near = |a: f64, b: f64| (a / b).ln().abs() < 3f64.ln();
        let bytes = cache.models().unwrap()[0].bytes as f64;
        assert!(
            near(before.file_bytes, bytes),
            "{} {bytes}",
            before.file_bytes
        );
        let memory = model.cost().memory_bytes as f64;
        assert!(
            near(before.memory_bytes, memory),
            "{} {memory}",
            before.memory_bytes
        );
    }
}
