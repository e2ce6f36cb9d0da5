//! The grid of one flank: axes and samples, before any interpolant, and what they must fulfil.

use super::axes::{check_values, least_distance};
use super::block::{Block, rounded, rounded_to};
use super::error::refused;
use super::interpolation::at_zero;
use super::records::SlidingSamples;
use super::{Axes, Axis, Query, TableError};
use crate::gear::PairGeometry;
use serde::{Deserialize, Serialize};

/// Digits of moments, and of forces at least.
const DIGITS: usize = 5;
/// Those that a double holds.
const MOST_DIGITS: usize = 15;
/// Largest part of half the face by which the digits of forces may move the place of the force.
const PLACE: f64 = 5e-3;

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
    /// How the load slides, for friction of tooth pairs one by one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sliding: Option<SlidingSamples>,
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

    /// The samples as part of a file, rounded below the error of interpolation: moments to five digits (2e-5 of each, rms), forces to
    /// five or as many as their place along the face of `pair` takes, none beyond a tenth of the last digit of the largest;
    /// approaches to a ten-millionth of the largest. All digits would take more than twice the room.
    #[must_use]
    pub fn for_file(&self, pair: &PairGeometry) -> FlankGrid {
        let digits = self.digits_of_force(0.5 * pair.face_overlap().1);
        FlankGrid {
            axes: Axes::default(),
            no_load_approach: rounded(&self.no_load_approach, 1e-7),
            top_load_approach: rounded(&self.top_load_approach, 1e-7),
            loa_force: rounded_to(digits, &self.loa_force),
            moment: self.moment.as_deref().map(|m| rounded_to(DIGITS, m)),
            sliding: self.sliding.clone(),
        }
    }

    /// Digits of the force that leave the place of the force within [`PLACE`] of `half_face` (m). It is a derivative over the misalignment of
    /// the potential, the integral of the force: forces that are off by a share e move it by up to e (D1 - D0) over the distance of the nodes.
    fn digits_of_force(&self, half_face: f64) -> usize {
        let apart = least_distance(&self.axes.misalignment);
        let [_, span] = self.fields();
        let span = span.values.into_iter().fold(0.0, f64::max);
        let share = PLACE * half_face * apart / span;
        // The last of n digits of 1 is 10^(1 - n), and rounding is off by half of it.
        let digits = (1.0 - (2.0 * share).log10()).ceil();
        digits.clamp(DIGITS as f64, MOST_DIGITS as f64) as usize
    }

    /// Largest force in the table, N.
    pub fn top_force(&self) -> f64 {
        self.loa_force.iter().copied().fold(0.0, f64::max)
    }

    /// Coordinates of the sample at the index (centre distance, misalignment, displacement, mesh position).
    pub fn query(&self, [c, m, u, p]: [usize; 4]) -> Query {
        let [cs, ms, us, ps] = self.axes.nodes();
        let column = (c * ms.len() + m) * ps.len() + p;
        let low = self.no_load_approach[column];
        let span = self.top_load_approach[column] - low;
        Query::from([low + us[u] * span, cs[c], ms[m], ps[p]])
    }

    /// `values` of this grid, samples or approaches, with their lengths.
    pub(crate) fn block(&self, values: &[f64]) -> Block {
        let [nc, nm, _, np] = self.axes.lengths();
        Block {
            lengths: [nc, nm, values.len() / (nc * nm * np).max(1), np],
            values: values.to_vec(),
        }
    }

    /// No-load approach, and span from there to the top load.
    pub(crate) fn fields(&self) -> [Block; 2] {
        let ends = self.top_load_approach.iter().zip(&self.no_load_approach);
        let span: Vec<f64> = ends.map(|(high, low)| high - low).collect();
        [&self.no_load_approach, &span].map(|values| self.block(values))
    }

    /// How far misalignment moves the first touch of the mesh cycle, m, over (centre distance, misalignment).
    pub(crate) fn touch_shift(&self) -> Result<Vec<f64>, TableError> {
        let [nc, nm, _, np] = self.axes.lengths();
        if nm == 1 {
            return Ok(vec![0.0; nc]);
        }
        let aligned = at_zero(&self.axes.misalignment, Axis::Misalignment.name())?;
        let least = |row: &[f64]| row.iter().copied().fold(f64::INFINITY, f64::min);
        let first: Vec<f64> = self.no_load_approach.chunks(np).map(least).collect();
        let shifts = first.chunks(nm).flat_map(|row| {
            let zero = aligned(row);
            row.iter().map(move |f| f - zero)
        });
        Ok(shifts.collect())
    }

    /// The grid without `axis`, centre distance or misalignment, at its value 0 (nominal centre distance, parallel axes),
    /// by the spline along this axis: at a node this is the plane of samples itself.
    ///
    /// # Errors
    /// 0 lies outside the axis.
    pub fn sliced(&self, axis: Axis) -> Result<FlankGrid, TableError> {
        let nodes = self.axes.nodes()[axis as usize];
        if nodes.len() == 1 {
            return Ok(self.clone());
        }
        let zero = at_zero(nodes, axis.name())?;
        Ok(self.mapped(axis, vec![0.0], |line| vec![zero(&line)]))
    }

    /// The grid with only the nodes number `chosen`, ascending, along `axis`. The last displacement, the top
    /// load, must be among them.
    pub fn with_nodes(&self, axis: Axis, chosen: &[usize]) -> FlankGrid {
        let pick = |line: Vec<f64>| chosen.iter().map(|&k| line[k]).collect();
        let nodes = pick(self.axes.nodes()[axis as usize].to_vec());
        self.mapped(axis, nodes, pick)
    }

    /// The grid with other `nodes` along `axis`, without sliding; `map` takes a line of samples to those there.
    fn mapped(&self, axis: Axis, nodes: Vec<f64>, map: impl Fn(Vec<f64>) -> Vec<f64>) -> FlankGrid {
        let mapped = |values: &Vec<f64>| {
            let block = self.block(values);
            match block.lengths[axis as usize] {
                1 => block.values,
                _ => (block.mapped(axis as usize, nodes.len(), &map)).values,
            }
        };
        let mut all = self.axes.nodes().map(<[f64]>::to_vec);
        all[axis as usize].clone_from(&nodes);
        FlankGrid {
            axes: Axes::from(all),
            no_load_approach: mapped(&self.no_load_approach),
            top_load_approach: mapped(&self.top_load_approach),
            loa_force: mapped(&self.loa_force),
            moment: self.moment.as_ref().map(mapped),
            sliding: None,
        }
    }

    /// Checks lengths, order and finiteness of all that is there, and that the force does not fall
    /// over the displacement. `flank` names it in messages.
    ///
    /// # Errors
    /// The first defect, by field and index.
    pub fn check(&self, flank: &str) -> Result<(), TableError> {
        self.axes.check()?;
        let [nc, nm, nu, np] = self.axes.lengths();
        let (columns, samples) = (nc * nm * np, nc * nm * nu * np);
        for (name, values, length) in [
            ("no_load_approach_m", Some(&self.no_load_approach), columns),
            (
                "top_load_approach_m",
                Some(&self.top_load_approach),
                columns,
            ),
            ("loa_force_n", Some(&self.loa_force), samples),
            ("moment_nm", self.moment.as_ref(), samples),
        ] {
            if let Some(values) = values {
                check_values(&format!("{flank}.{name}"), values, length)?;
            }
        }
        for (name, values) in self.sliding.iter().flat_map(SlidingSamples::columns) {
            check_values(&format!("{flank}.sliding.{name}"), values, samples)?;
        }
        let ends = self.no_load_approach.iter().zip(&self.top_load_approach);
        if let Some((i, (low, high))) = ends.enumerate().find(|(_, (low, high))| high <= low) {
            let reason = format!(
                "not above the no-load approach {low}; make the tables again; of imported samples, check the sign of ste_loa_um"
            );
            return refused(format!("{flank}.top_load_approach_m[{i}]"), high, reason);
        }
        for start in self.block(&self.loa_force).lines(2) {
            let mut below = 0.0;
            for u in 0..nu {
                let i = start + u * np;
                let force = self.loa_force[i];
                if force < below || (u + 1 == nu && force <= 0.0) {
                    let reason = format!(
                        "the force must not fall with the displacement (before it: {below}); make the tables again; of \
                         imported samples, remove the falling one"
                    );
                    return refused(format!("{flank}.loa_force_n[{i}]"), force, reason);
                }
                below = force;
            }
        }
        Ok(())
    }
}
