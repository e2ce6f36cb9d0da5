//! The finite-element model of one gear as the compliance of its teeth.

use std::ops::Range;
use std::sync::Arc;

use gearmesh::contact::Segment;
use gearmesh::gear::Gear;
use nalgebra::DMatrix;

use super::cache::{self, ModelCache, Origin};
use super::condensation::CondensedSector;
use super::cylinder::{self, Cut};
use super::error::FiniteElementError;
use super::flank::{FlankGrid, Weights};
use super::influence::Influence;
use super::mesh::Mesh;
use super::model::{Model, Progress, Stage};
use super::settings::Settings;
use super::uneven::{self, BodyChange};
use super::work::{FlankLoad, work_between};
use crate::compliance::{self, BeyondModel, Load, ToothCompliance, lower_triangle};
use crate::gear::{BodyShape, UnevenBody, body};

/// Finite-element model of one gear, reduced to its loaded flank.
#[derive(Debug, Clone)]
pub struct FiniteElementCompliance {
    pub(super) grid: FlankGrid,
    influence: Arc<Influence>,
    /// If the gear is cut from its body, which is no solid of revolution.
    body: Option<BodyChange>,
    plane_strain: bool,
    /// Of the base helix; plane strain alone needs it.
    cos_base_helix: f64,
    /// The gear turned end for end, if its body is another one then.
    turned: Option<Box<FiniteElementCompliance>>,
}

impl FiniteElementCompliance {
    /// Computes the model of `gear`, whose body joins its teeth as a pair file's does, or reads it from `cache` if there is one;
    /// microgeometry plays no part.
    ///
    /// # Errors
    /// [`FiniteElementError`]: no usable tooth, memory, or cancelled by `progress`.
    pub fn new(
        gear: &Gear,
        settings: &Settings,
        cache: Option<&ModelCache>,
        progress: &Progress<'_>,
    ) -> Result<(Self, Origin), FiniteElementError> {
        let mut condensed = None;
        let mut one_way_round =
            |gear: &Gear| Self::one_way_round(gear, settings, cache, &mut condensed, progress);
        let (mut model, mut origin) = one_way_round(gear)?;
        if let Some(gear) = body::turned(gear) {
            let (turned, of_turned) = one_way_round(&gear)?;
            // Of a gear with two models the one that was not simply read.
            if of_turned != Origin::Loaded {
                origin = of_turned;
            }
            model.turned = Some(Box::new(turned));
        }
        Ok((model, origin))
    }

    /// The model without that of the gear turned end for end; `condensed` as in [`Model::influence`].
    fn one_way_round(
        gear: &Gear,
        settings: &Settings,
        cache: Option<&ModelCache>,
        condensed: &mut Option<(Mesh, CondensedSector)>,
        progress: &Progress<'_>,
    ) -> Result<(Self, Origin), FiniteElementError> {
        let model = Model::new(gear, settings)?;
        let (influence, origin) = cache::get(cache, &model, "", || {
            Ok(Influence::new(&model.influence(condensed, progress)?))
        })?;
        let found = FiniteElementCompliance {
            grid: model.grid,
            influence: Arc::new(influence),
            body: None,
            plane_strain: settings.plane_strain,
            cos_base_helix: gear.base_helix_angle().cos(),
            turned: None,
        };
        Ok((found, origin))
    }

    /// This model of `gear` without its `uneven_body` on that body; settings and cache as those of this model.
    pub(super) fn on_body(
        &self,
        gear: &Gear,
        uneven_body: &UnevenBody,
        settings: &Settings,
        cache: Option<&ModelCache>,
        progress: &Progress<'_>,
    ) -> Result<Self, FiniteElementError> {
        let basis = uneven::basis(gear, uneven_body);
        let cut = uneven::cut_from(gear, uneven_body);
        // The loads of the basis act below the teeth.
        let mut settings = *settings;
        settings.discretization.fine_depth = f64::INFINITY;
        let of_teeth = |gear: &Gear| {
            let model = Model::new(gear, &settings)?;
            let basis = cylinder::Basis {
                z: gear.body.map_or(basis.z, |body| body.web),
                ..basis
            };
            let (found, _) = cache::get(cache, &model, &format!("{basis:?} "), || {
                Cut::new(&basis, &model.mesh(), gear.teeth, &|share| {
                    progress(Stage::Condensation, share)
                })
            })?;
            Ok::<_, FiniteElementError>(Arc::new(found))
        };
        let own = of_teeth(&cut)?;
        let other = match body::turned(&cut) {
            Some(turned) => of_teeth(&turned)?,
            None => own.clone(),
        };
        let stiffness = match &uneven_body.shape {
            // Read with the pair file.
            BodyShape::Nodes(_) => uneven::stiffness(gear, uneven_body, &basis)?,
            _ => {
                let held = (gear.held_radius, gear.body);
                let what = format!("{basis:?} on {uneven_body:?} {held:?} ");
                let found = cache::get(cache, &Model::new(&cut, &settings)?, &what, || {
                    uneven::stiffness(gear, uneven_body, &basis)
                });
                found?.0
            }
        };
        let mut turned = self.turned.as_deref().unwrap_or(self).clone();
        turned.body = Some(BodyChange::new(gear, basis, &stiffness, other, true)?);
        Ok(FiniteElementCompliance {
            body: Some(BodyChange::new(gear, basis, &stiffness, own, false)?),
            turned: Some(Box::new(turned)),
            ..self.clone()
        })
    }

    /// `loads` on the nodes of the flank.
    fn loads(&self, segments: &[Segment], loads: &[Load]) -> Result<Vec<FlankLoad>, BeyondModel> {
        let teeth = segments.iter().map(|s| s.tooth);
        let (first, last) = (teeth.clone().min(), teeth.max());
        let distance = last.unwrap_or(0).abs_diff(first.unwrap_or(0)) as usize;
        let reach = self.influence.teeth() - 1;
        if distance > reach {
            return Err(BeyondModel { distance, reach });
        }
        let weights: Vec<Weights> = segments.iter().map(|s| self.grid.weights(s)).collect();
        let mut all = Vec::with_capacity(loads.len());
        for load in loads {
            let parts = load.iter().flat_map(|(i, force)| {
                let of_segment = weights[*i].iter();
                of_segment.map(move |(node, weight)| (*node, force * weight))
            });
            all.push(FlankLoad {
                tooth: segments[load[0].0].tooth,
                weights: parts.collect(),
            });
        }
        Ok(all)
    }

    /// Factor of the influence of two segments in plane strain on each other beyond that of their weights.
    fn slice_factor(&self, a: &Segment, b: &Segment) -> f64 {
        // Segments act on each other as far as they lie in the same slices. The force per length of contact line is cos beta_b
        // times that per metre of depth; so is the displacement along the flank normal seen from the transverse plane, but one
        // of the two factors is left to the shorter path of the line load, as the local contact counts it.
        let overlap = (a.z[1].min(b.z[1]) - a.z[0].max(b.z[0])).max(0.0);
        let lengths = (a.z[1] - a.z[0]) * (b.z[1] - b.z[0]);
        self.cos_base_helix * overlap / lengths
    }
}

impl ToothCompliance for FiniteElementCompliance {
    fn bulk(&self, segments: &[Segment]) -> Result<DMatrix<f64>, BeyondModel> {
        let alone: Vec<Load> = (0..segments.len()).map(|i| vec![(i, 1.0)]).collect();
        let loads = self.loads(segments, &alone)?;
        let mut matrix = work_between(
            &self.influence,
            self.body.as_ref(),
            [&loads, &loads],
            &lower_triangle(loads.len()),
        );
        if self.plane_strain {
            for (j, column) in segments.iter().enumerate() {
                for (i, row) in segments.iter().enumerate().skip(j) {
                    matrix[(i, j)] *= self.slice_factor(row, column);
                }
            }
        }
        matrix.fill_upper_triangle_with_lower_triangle();
        Ok(matrix)
    }

    fn at_tooth(&self, tooth: i32) -> Option<Arc<dyn ToothCompliance>> {
        let body = self.body.as_ref()?;
        let turned = self
            .turned
            .as_deref()
            .map(|turned| FiniteElementCompliance {
                body: turned.body.as_ref().map(|body| body.at_tooth(tooth)),
                ..turned.clone()
            });
        Some(Arc::new(FiniteElementCompliance {
            body: Some(body.at_tooth(tooth)),
            turned: turned.map(Box::new),
            ..self.clone()
        }))
    }

    fn beyond_mean_body(
        &self,
        segments: &[Segment],
        forces: &DMatrix<f64>,
        teeth: &[i32],
    ) -> Result<Option<Vec<DMatrix<f64>>>, BeyondModel> {
        let Some(body) = &self.body else {
            return Ok(None);
        };
        let alone: Vec<Load> = (0..segments.len()).map(|i| vec![(i, 1.0)]).collect();
        let loads = self.loads(segments, &alone)?;
        let loads = loads.iter().map(|load| (load.tooth, &load.weights));
        let coordinates = body.coordinates(loads) * forces;
        Ok(Some(body.beyond_mean(&coordinates, teeth)))
    }

    fn work(
        &self,
        segments: &[Segment],
        [rows, columns]: [&[Load]; 2],
        wanted: &[Range<usize>],
    ) -> Result<DMatrix<f64>, BeyondModel> {
        if self.plane_strain {
            // Segments act on each other slice by slice.
            return Ok(compliance::work(
                &self.bulk(segments)?,
                [rows, columns],
                wanted,
            ));
        }
        let loads = self.loads(segments, &[rows, columns].concat())?;
        let (rows, columns) = loads.split_at(rows.len());
        Ok(work_between(
            &self.influence,
            self.body.as_ref(),
            [rows, columns],
            wanted,
        ))
    }

    fn reference_lengths(&self, segments: &[Segment]) -> Vec<f64> {
        segments
            .iter()
            .map(|segment| self.grid.reference_length(segment))
            .collect()
    }

    fn turned(&self) -> Option<&dyn ToothCompliance> {
        Some(self.turned.as_deref()?)
    }

    fn corner_resolution(&self) -> f64 {
        self.grid.edge_resolution()
    }

    fn lengthwise_resolution(&self) -> f64 {
        let layers = self.grid.stations.windows(2).map(|ends| ends[1] - ends[0]);
        layers.fold(0.0, f64::max)
    }
}
