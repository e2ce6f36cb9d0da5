//! The grid of one flank in memory: axes and samples, before any interpolant.

use super::file::rounded;
use super::interpolation::{Block, at_zero};
use super::{Query, TableError};
use serde::{Deserialize, Serialize};

/// A coordinate of the grid, in the order of [`Axes::lengths`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Centre distance.
    CenterDistance,
    /// Misalignment.
    Misalignment,
    /// Displacement.
    Displacement,
    /// Mesh position.
    MeshPosition,
}

impl Axis {
    /// Its name in files and messages.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Axis::CenterDistance => "center_distance_offset_m",
            Axis::Misalignment => "misalignment_rad",
            Axis::Displacement => "displacement_fraction",
            Axis::MeshPosition => "mesh_position",
        }
    }
}

/// Nodes of the grid, SI. An axis with one node is not there: nothing depends on that coordinate.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axes {
    /// u = (delta - D0) / (D1 - D0) with D0 the no-load and D1 the top-load approach; ascending,
    /// above 0, the last one 1. The force at u = 0 is zero by definition and not stored.
    pub displacement_fraction: Vec<f64>,
    /// Actual minus nominal centre distance, m.
    #[serde(rename = "center_distance_offset_m")]
    pub center_distance_offset: Vec<f64>,
    /// Misalignment in the plane of action, rad.
    #[serde(rename = "misalignment_rad")]
    pub misalignment: Vec<f64>,
    /// Mesh position, in [0, 1), periodic.
    pub mesh_position: Vec<f64>,
}

impl Axes {
    /// Whether centre distance, misalignment and mesh position have an axis.
    pub fn present(&self) -> [bool; 3] {
        [
            self.center_distance_offset.len() > 1,
            self.misalignment.len() > 1,
            self.mesh_position.len() > 1,
        ]
    }

    /// Lengths in the order of the samples: centre distance, misalignment, displacement, mesh position.
    pub fn lengths(&self) -> [usize; 4] {
        [
            self.center_distance_offset.len(),
            self.misalignment.len(),
            self.displacement_fraction.len(),
            self.mesh_position.len(),
        ]
    }

    /// The nodes along `axis`.
    pub fn along_mut(&mut self, axis: Axis) -> &mut Vec<f64> {
        match axis {
            Axis::CenterDistance => &mut self.center_distance_offset,
            Axis::Misalignment => &mut self.misalignment,
            Axis::Displacement => &mut self.displacement_fraction,
            Axis::MeshPosition => &mut self.mesh_position,
        }
    }
}

/// Samples of one flank. Arrays run over (centre distance, misalignment, displacement, mesh position),
/// the last index fastest; the approaches have no displacement index.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FlankGrid {
    /// Nodes. Files hold them once for all flanks, see [`FlankGrid::on`]: they are empty where a flank is part of one.
    #[serde(skip)]
    pub axes: Axes,
    /// D0: approach at which the first points touch, m, on the line of action at mid-face.
    #[serde(rename = "no_load_approach_m")]
    pub no_load_approach: Vec<f64>,
    /// D1: approach at the top load, m.
    #[serde(rename = "top_load_approach_m")]
    pub top_load_approach: Vec<f64>,
    /// Transverse force on the line of action, N.
    #[serde(rename = "loa_force_n")]
    pub loa_force: Vec<f64>,
    /// F_bt (z_c - z_ref), N m, z_c where the resultant crosses the pitch plane; `None` where it is not known or shuttling is
    /// off.
    #[serde(rename = "moment_nm")]
    pub moment: Option<Vec<f64>>,
}

impl FlankGrid {
    /// These samples, part of a file, on its `axes`.
    #[must_use]
    pub fn on(&self, axes: &Axes) -> FlankGrid {
        FlankGrid {
            axes: axes.clone(),
            ..self.clone()
        }
    }

    /// The samples as part of a file, rounded to decimals far below the error of interpolation: forces and moments
    /// to a millionth of the largest at least, approaches to a ten-millionth. That halves the size on disk.
    #[must_use]
    pub fn for_file(&self) -> FlankGrid {
        FlankGrid {
            axes: Axes::default(),
            no_load_approach: rounded(&self.no_load_approach, 1e-7),
            top_load_approach: rounded(&self.top_load_approach, 1e-7),
            loa_force: rounded(&self.loa_force, 1e-6),
            moment: self.moment.as_deref().map(|m| rounded(m, 1e-6)),
        }
    }

    /// Largest force in the table, N.
    pub fn top_force(&self) -> f64 {
        self.loa_force.iter().copied().fold(0.0, f64::max)
    }

    /// Where the sample at the index (centre distance, misalignment, displacement, mesh position) stands.
    pub fn query(&self, [c, m, u, p]: [usize; 4]) -> Query {
        let axes = &self.axes;
        let column = (c * axes.misalignment.len() + m) * axes.mesh_position.len() + p;
        let (low, high) = (
            self.no_load_approach[column],
            self.top_load_approach[column],
        );
        Query {
            delta: low + axes.displacement_fraction[u] * (high - low),
            center_distance_offset: axes.center_distance_offset[c],
            misalignment: axes.misalignment[m],
            mesh_position: axes.mesh_position[p],
        }
    }

    pub(crate) fn force_block(&self) -> Block {
        Block {
            lengths: self.axes.lengths(),
            values: self.loa_force.clone(),
        }
    }

    pub(crate) fn moment_block(&self) -> Option<Block> {
        self.moment.as_ref().map(|values| Block {
            lengths: self.axes.lengths(),
            values: values.clone(),
        })
    }

    /// No-load approach (row 0) and span (row 1).
    pub(crate) fn field_block(&self) -> Block {
        let [nc, nm, _, np] = self.axes.lengths();
        let mut values = Vec::with_capacity(2 * nc * nm * np);
        let rows = self.no_load_approach.chunks(np);
        for (low, high) in rows.zip(self.top_load_approach.chunks(np)) {
            values.extend_from_slice(low);
            values.extend(high.iter().zip(low).map(|(h, l)| h - l));
        }
        Block {
            lengths: [nc, nm, 2, np],
            values,
        }
    }

    /// How far misalignment moves the first touch of the mesh cycle, m, over (centre distance, misalignment).
    pub(crate) fn touch_shift(&self) -> Result<Vec<f64>, TableError> {
        let [nc, nm, _, np] = self.axes.lengths();
        let first: Vec<f64> = self
            .no_load_approach
            .chunks(np)
            .map(|row| row.iter().copied().fold(f64::INFINITY, f64::min))
            .collect();
        if nm == 1 {
            return Ok(vec![0.0; nc]);
        }
        let first = Block {
            lengths: [nc, nm, 1, 1],
            values: first,
        };
        let name = Axis::Misalignment.name();
        let aligned = at_zero(&first, 1, &self.axes.misalignment, name)?;
        let rows = first.values.chunks(nm).zip(aligned.values);
        Ok(rows
            .flat_map(|(row, zero)| row.iter().map(move |f| f - zero))
            .collect())
    }

    /// The grid without `axis`, centre distance or misalignment, at its value 0 (nominal centre distance, parallel axes),
    /// by the spline along this axis: at a node this is the plane of samples itself.
    ///
    /// # Errors
    /// 0 lies outside the axis.
    pub fn sliced(&self, axis: Axis) -> Result<FlankGrid, TableError> {
        let nodes = self.axes.clone().along_mut(axis).clone();
        if nodes.len() == 1 {
            return Ok(self.clone());
        }
        self.mapped(axis, vec![0.0], |block| {
            at_zero(block, axis as usize, &nodes, axis.name())
        })
    }

    /// The grid with only the nodes number `chosen`, ascending, along `axis`. The last displacement, the top
    /// load, must be among them.
    pub fn with_nodes(&self, axis: Axis, chosen: &[usize]) -> FlankGrid {
        let mut axes = self.axes.clone();
        let nodes = axes.along_mut(axis);
        let nodes = chosen.iter().map(|&k| nodes[k]).collect();
        let pick = |block: &Block| -> Result<Block, std::convert::Infallible> {
            Ok(block.mapped(axis as usize, chosen.len(), |line| {
                chosen.iter().map(|&k| line[k]).collect()
            }))
        };
        let Ok(grid) = self.mapped(axis, nodes, pick);
        grid
    }

    /// The grid with other `nodes` along `axis`; `map` takes samples to those there.
    fn mapped<E>(
        &self,
        axis: Axis,
        nodes: Vec<f64>,
        map: impl Fn(&Block) -> Result<Block, E>,
    ) -> Result<FlankGrid, E> {
        let mut axes = self.axes.clone();
        *axes.along_mut(axis) = nodes;
        let full = self.axes.lengths();
        let [nc, nm, _, np] = full;
        let mapped = |values: &[f64], lengths| {
            let values = values.to_vec();
            Ok(map(&Block { lengths, values })?.values)
        };
        let approach = |values: &[f64]| match axis {
            Axis::Displacement => Ok(values.to_vec()),
            _ => mapped(values, [nc, nm, 1, np]),
        };
        Ok(FlankGrid {
            axes,
            no_load_approach: approach(&self.no_load_approach)?,
            top_load_approach: approach(&self.top_load_approach)?,
            loa_force: mapped(&self.loa_force, full)?,
            moment: (self.moment.as_deref())
                .map(|m| mapped(m, full))
                .transpose()?,
        })
    }
}
