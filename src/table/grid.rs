//! The grid of one flank in memory: axes and samples, before any interpolant.

use super::TableError;
use super::interpolation::{Basis, Block, Ends, breaks, row_at};

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

/// Nodes of the grid, SI. An axis with one node is not there: nothing depends on that coordinate.
#[derive(Debug, Clone, PartialEq)]
pub struct Axes {
    /// u = (delta - D0) / (D1 - D0) with D0 the no-load and D1 the top-load approach; ascending,
    /// above 0, the last one 1. The force at u = 0 is zero by definition and not stored.
    pub displacement_fraction: Vec<f64>,
    /// Actual minus nominal centre distance, m.
    pub center_distance_offset: Vec<f64>,
    /// Misalignment in the plane of action, rad.
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

    /// Number of axes there beside the displacement.
    pub fn dimensions(&self) -> usize {
        self.present().iter().filter(|p| **p).count()
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
#[derive(Debug, Clone, PartialEq)]
pub struct FlankGrid {
    /// Nodes.
    pub axes: Axes,
    /// D0: approach at which the first points touch, m, on the line of action at mid-face.
    pub no_load_approach: Vec<f64>,
    /// D1: approach at the top load, m.
    pub top_load_approach: Vec<f64>,
    /// Transverse force on the line of action, N.
    pub loa_force: Vec<f64>,
    /// F_bt (z_c - z_ref), N m; `None` if shuttling is not wanted.
    pub moment: Option<Vec<f64>>,
}

impl FlankGrid {
    /// Largest force in the table, N.
    pub fn top_force(&self) -> f64 {
        self.loa_force.iter().copied().fold(0.0, f64::max)
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
        let aligned = value_row(&self.axes.misalignment, "misalignment_rad")?;
        Ok(first
            .chunks(nm)
            .flat_map(|row| {
                let zero: f64 = row.iter().zip(aligned.iter()).map(|(f, w)| f * w).sum();
                row.iter().map(move |f| f - zero).collect::<Vec<_>>()
            })
            .collect())
    }

    /// The grid without `axis`, which the displacement fraction and the mesh position are not, at its value 0
    /// (nominal centre distance, parallel axes), by the spline along this axis: at a node this is the plane of
    /// samples itself.
    ///
    /// # Errors
    /// 0 lies outside the axis.
    pub fn sliced(&self, axis: Axis) -> Result<FlankGrid, TableError> {
        let nodes = self.axes.clone().along_mut(axis).clone();
        if nodes.len() == 1 {
            return Ok(self.clone());
        }
        if let Some(k) = nodes.iter().position(|&x| x == 0.0) {
            return Ok(self.with_nodes(axis, &[k]));
        }
        let name = match axis {
            Axis::CenterDistance => "center_distance_offset_m",
            Axis::Misalignment => "misalignment_rad",
            Axis::Displacement => "displacement_fraction",
            Axis::MeshPosition => "mesh_position",
        };
        let row = value_row(&nodes, name)?;
        Ok(self.mapped(axis, vec![0.0], |values, lengths| {
            let values = values.to_vec();
            let block = Block { lengths, values };
            block.combined(axis as usize, &row).values
        }))
    }

    /// The grid with only the nodes number `chosen`, ascending, along `axis`. The last displacement, the top
    /// load, must be among them.
    pub fn with_nodes(&self, axis: Axis, chosen: &[usize]) -> FlankGrid {
        let mut axes = self.axes.clone();
        let nodes = axes.along_mut(axis);
        let nodes = chosen.iter().map(|&k| nodes[k]).collect();
        self.mapped(axis, nodes, |values, lengths| {
            let stride: usize = lengths[axis as usize + 1..].iter().product();
            values
                .chunks(stride * lengths[axis as usize])
                .flat_map(|block| chosen.iter().map(move |&i| &block[i * stride..][..stride]))
                .flatten()
                .copied()
                .collect()
        })
    }

    /// The grid with other `nodes` along `axis`; `map` takes samples and their lengths before to samples there.
    fn mapped(
        &self,
        axis: Axis,
        nodes: Vec<f64>,
        map: impl Fn(&[f64], [usize; 4]) -> Vec<f64>,
    ) -> FlankGrid {
        let mut axes = self.axes.clone();
        *axes.along_mut(axis) = nodes;
        let full = self.axes.lengths();
        let [nc, nm, _, np] = full;
        let approach = |values: &[f64]| match axis {
            Axis::Displacement => values.to_vec(),
            _ => map(values, [nc, nm, 1, np]),
        };
        FlankGrid {
            axes,
            no_load_approach: approach(&self.no_load_approach),
            top_load_approach: approach(&self.top_load_approach),
            loa_force: map(&self.loa_force, full),
            moment: self.moment.as_deref().map(|m| map(m, full)),
        }
    }
}

/// Factors of the samples along a bounded axis that give the spline's value at 0.
pub(super) fn value_row(nodes: &[f64], name: &str) -> Result<Vec<f64>, TableError> {
    if let Some(k) = nodes.iter().position(|&x| x == 0.0) {
        let mut row = vec![0.0; nodes.len()];
        row[k] = 1.0;
        return Ok(row);
    }
    if !(nodes[0] < 0.0 && nodes[nodes.len() - 1] > 0.0) {
        return Err(TableError::field(
            name,
            format!("{nodes:?}"),
            "the nominal value 0 lies outside this axis, so its effect cannot be switched off",
            "make tables whose range includes 0",
        ));
    }
    let basis = Basis::<4>::new(&breaks(nodes, 3, Ends::Bounded), Ends::Bounded);
    row_at(&basis, nodes, Ends::Bounded, 0.0, name)
}
