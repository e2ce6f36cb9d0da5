//! The section swept along the helix.
//!
//! Loads on the flank are felt the more evenly along the face the deeper one looks below the root (Saint-Venant), so the
//! layers of the tooth are merged in rows that lie deep enough ([`Layers::of_rows`]). Where a row of thin layers
//! meets one of thick layers, nodes of the thin ones lie within a side of a thick element and move as that side does
//! ([`Mesh::hanging`]): the displacement stays continuous.

use super::element::{QUAD8, shape};
use super::layers::Layers;
use super::mesh::{FlankNode, Mesh};
use super::outline::Outline;
use super::section::Section;
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// A plane across the axis halfway between the ends of the layers from the first to before the second number: with equal numbers the
/// lower end of that layer.
type Plane = [usize; 2];

fn middle(layers: &Range<usize>) -> Plane {
    [layers.start, layers.end]
}

/// The mesh while it grows, with its nodes by node of the section and plane.
struct Extrusion<'a> {
    section: &'a Section,
    stations: &'a [f64],
    twist: f64,
    along: Option<&'a Layers>,
    held: HashSet<usize>,
    numbers: HashMap<(usize, Plane), usize>,
    mesh: Mesh,
}

impl Mesh {
    /// The section itself for plane strain, or swept through the layers `along`, turned by `twist` rad per metre (tan beta_b / rb;
    /// right-handed), without what lies outside of rim, web and hub.
    pub fn new(section: &Section, outline: &Outline, along: Option<&Layers>, twist: f64) -> Mesh {
        let mut extrusion = Extrusion {
            section,
            stations: along.map_or(&[0.0], |along| &along.stations),
            twist: along.map_or(0.0, |_| twist),
            along,
            held: section.held.iter().copied().collect(),
            numbers: HashMap::new(),
            mesh: Mesh {
                dimension: if along.is_some() { 3 } else { 2 },
                ..Mesh::default()
            },
        };
        match along {
            Some(along) => extrusion.add_solid(along),
            None => extrusion.add_plane(),
        }
        extrusion.find_sides();
        extrusion.find_surface(outline, along.map_or(0..0, |along| along.face.clone()));
        extrusion.mesh
    }
}

impl Extrusion<'_> {
    /// Place of a plane, m.
    fn z(&self, plane: Plane) -> f64 {
        0.5 * (self.stations[plane[0]] + self.stations[plane[1]])
    }

    /// Number of the node `node` of the section on `plane`; a new one if there is none yet.
    fn number(&mut self, node: usize, plane: Plane) -> usize {
        let z = self.z(plane);
        let mesh = &mut self.mesh;
        *self.numbers.entry((node, plane)).or_insert_with(|| {
            let [r, theta] = self.section.nodes[node];
            let angle = theta + self.twist * z;
            mesh.points.push([r * angle.cos(), r * angle.sin(), z]);
            mesh.angles.push(angle);
            let is_end = plane[0] == plane[1];
            let at_end = is_end && self.along.is_some_and(|along| along.is_held(plane[0]));
            mesh.held.push(at_end || self.held.contains(&node));
            mesh.points.len() - 1
        })
    }

    fn add_plane(&mut self) {
        let section = self.section;
        for (quad, cell) in section.quads.iter().zip(&section.cells) {
            for node in quad {
                let number = self.number(*node, [0; 2]);
                self.mesh.elements.push(number);
            }
            self.mesh.cells.push([cell[0], cell[1], 0]);
        }
    }

    /// Elements of all layers, merged as far as their row allows.
    fn add_solid(&mut self, along: &Layers) {
        let section = self.section;
        let (rows, thin) = (along.of_rows(&section.rows), along.single());
        for (quad, cell) in section.quads.iter().zip(&section.cells) {
            let (layers, width) = match Section::row_below_root(*cell) {
                Some(row) => (&rows[row], section.rows[row].width),
                None => (&thin, None),
            };
            for layer in layers {
                // Layers are merged in full discs alone.
                if !along.holds(width, layer.start) {
                    continue;
                }
                for end in [layer.start, layer.end] {
                    for node in quad {
                        let number = self.number(*node, [end; 2]);
                        self.mesh.elements.push(number);
                    }
                }
                for node in &quad[..4] {
                    let number = self.number(*node, middle(layer));
                    self.mesh.elements.push(number);
                }
                self.mesh.cells.push([cell[0], cell[1], layer.start as i32]);
            }
        }
        for (upper, layers) in rows.windows(2).enumerate() {
            if layers[0] != layers[1] {
                self.hang(upper, &layers[0], &layers[1]);
            }
        }
    }

    /// Hangs the nodes between the row `upper` with the layers `thin` and the next one with `thick` ones.
    fn hang(&mut self, upper: usize, thin: &[Range<usize>], thick: &[Range<usize>]) {
        let section = self.section;
        let quads_of = |row: usize| {
            let all = section.quads.iter().zip(&section.cells);
            all.filter(move |(_, cell)| Section::row_below_root(**cell) == Some(row))
                .map(|(quad, _)| quad)
        };
        let above: HashSet<usize> = quads_of(upper).flatten().copied().collect();
        for quad in quads_of(upper + 1) {
            let edges = (0..4).map(|k| [quad[k], quad[(k + 1) % 4], quad[4 + k]]);
            for edge in edges.filter(|edge| edge.iter().all(|node| above.contains(node))) {
                for side in thick {
                    let within = thin
                        .iter()
                        .filter(|layer| side.start <= layer.start && layer.end <= side.end);
                    for layer in within.filter(|layer| *layer != side) {
                        self.hang_on(edge, side, middle(layer));
                        if layer.end < side.end {
                            self.hang_on(edge, side, [layer.end; 2]);
                        }
                    }
                }
            }
        }
    }

    /// Hangs the nodes that lie on `plane` within the side over `edge` (both corners, then the middle) and `layers`.
    fn hang_on(&mut self, [a, b, between]: [usize; 3], layers: &Range<usize>, plane: Plane) {
        let ends = [layers.start, layers.end].map(|end| self.stations[end]);
        let zeta = (2.0 * self.z(plane) - ends[0] - ends[1]) / (ends[1] - ends[0]);
        for (node, xi) in [(a, -1.0), (b, 1.0), (between, 0.0)] {
            let Some(at) = self.numbers.get(&(node, plane)).copied() else {
                continue;
            };
            let mut carriers = Vec::new();
            let mut place = [0.0; 3];
            for c in &QUAD8 {
                let share = shape(2, c, &[xi, zeta, 0.0]).0;
                if share == 0.0 {
                    continue;
                }
                let of = match c[0] {
                    0.0 => between,
                    x if x < 0.0 => a,
                    _ => b,
                };
                let plane = match c[1] {
                    0.0 => middle(layers),
                    x if x < 0.0 => [layers.start; 2],
                    _ => [layers.end; 2],
                };
                let carrier = self.number(of, plane);
                carriers.push((carrier, share));
                for (sum, x) in place.iter_mut().zip(self.mesh.points[carrier]) {
                    *sum += share * x;
                }
            }
            // Where the side has it, so that the elements fit without a gap.
            self.mesh.points[at] = place;
            self.mesh.angles[at] = place[1].atan2(place[0]);
            self.mesh.hanging.insert(at, carriers);
        }
    }

    /// Nodes of both sides of the sector.
    fn find_sides(&mut self) {
        let [left, right] = &self.section.sides;
        let twins: HashMap<usize, usize> =
            left.iter().copied().zip(right.iter().copied()).collect();
        let mut all: Vec<_> = self.numbers.iter().collect();
        all.sort_unstable_by_key(|(_, number)| **number);
        for ((node, plane), number) in all {
            if let Some(twin) = twins.get(node)
                && !self.mesh.hanging.contains_key(number)
                && !self.mesh.held[*number]
            {
                self.mesh.sides[0].push(*number);
                self.mesh.sides[1].push(self.numbers[&(*twin, *plane)]);
            }
        }
    }

    /// Nodes of the loaded flank and of the fillet beside it, in the layers `face`.
    fn find_surface(&mut self, outline: &Outline, face: Range<usize>) {
        let section = self.section;
        let planes = face
            .clone()
            .flat_map(|layer| [[layer; 2], [layer, layer + 1]]);
        for plane in planes.chain([[face.end; 2]]) {
            let at = |node: usize| self.numbers.get(&(node, plane)).copied();
            let fillet = section.fillet.iter().map(|(node, _)| *node);
            self.mesh.fillet.extend(fillet.filter_map(at));
            for (node, arc) in &section.flank {
                let Some(number) = at(*node) else {
                    continue;
                };
                // The surface contains the helix direction (0, r twist, 1).
                let [n_r, n_t] = outline.normal(*arc);
                let n_z = -n_t * section.nodes[*node][0] * self.twist;
                let norm = n_z.hypot(1.0);
                self.mesh.flank.push(FlankNode {
                    node: number,
                    normal: [n_r / norm, n_t / norm, n_z / norm],
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::finite_element::model::Model;
    use crate::finite_element::{Discretization, Settings, element};
    use crate::samples;
    use approx::assert_relative_eq;
    use gearmesh::gear::{Body, Gear, GearKind};
    use gearmesh::pair::Refinement;
    use nalgebra::DVector;

    /// Gears whose deep rows have merged layers: without and with helix, and a ring.
    fn gears() -> [Gear; 3] {
        [(0.0, 0.0), (30.0, 0.0), (20.0, 15e-3)].map(|(helix, ring)| {
            let kind = match ring > 0.0 {
                true => GearKind::Ring,
                false => GearKind::External,
            };
            let mut gear = samples::gear(kind, 30, 1.0, helix, 0.0);
            gear.face_width = 82e-3;
            gear.held_radius = match kind {
                GearKind::External => 0.5 * gear.root_radius(),
                GearKind::Ring => gear.held_radius + ring,
            };
            gear
        })
    }

    /// Few nodes on the flank are enough here, in layers thin enough to be merged.
    fn settings() -> Settings {
        let mut settings = Settings::new(Refinement::Coarse, 1);
        let normal = Discretization::of(Refinement::Normal);
        settings.discretization = Discretization {
            flank_element: 0.5,
            layer: normal.layer,
            end_layer: normal.end_layer,
            ..settings.discretization
        };
        settings
    }

    fn model(gear: &Gear) -> Model {
        Model::new(gear, &settings()).unwrap()
    }

    #[test]
    fn even_strain_has_its_energy_across_the_rows_where_layers_merge() {
        let (young, poisson) = (206e9, 0.3);
        let (lambda, mu) = element::lame(young, poisson);
        // Displacement gradient: stretches, shears and a rotation.
        let g = [[1e-4, 3e-4, -3e-4], [-1e-4, -3e-4, 1e-4], [4e-4, 0.0, 3e-4]];
        let trace: f64 = (0..3).map(|i| g[i][i]).sum();
        let both = |i: usize, j: usize| 0.5 * (g[i][j] + g[j][i]);
        let squares: f64 = (0..9).map(|k| both(k / 3, k % 3).powi(2)).sum();
        let density = 0.5 * lambda * trace * trace + mu * squares;
        for gear in gears() {
            let mesh = model(&gear).mesh();
            assert!(mesh.hanging.len() > 20, "{}", mesh.hanging.len());
            let mut energy = 0.0;
            for nodes in mesh.connectivity() {
                let (nodes, k) = mesh.stiffness(nodes, [young, poisson]);
                let u = DVector::from_iterator(
                    3 * nodes.len(),
                    nodes.iter().flat_map(|node| {
                        let (sin, cos) = mesh.angles[*node].sin_cos();
                        let p = mesh.points[*node];
                        let [x, y, z] =
                            g.map(|row| row.iter().zip(p).map(|(a, b)| a * b).sum::<f64>());
                        [cos * x + sin * y, cos * y - sin * x, z]
                    }),
                );
                energy += 0.5 * u.dot(&(k * &u));
            }
            let (volume, _) = mesh.volume_and_quality();
            assert_relative_eq!(energy, density * volume, max_relative = 1e-9);
        }
    }

    #[test]
    fn merged_layers_change_what_flanks_give_by_less_than_a_part_in_three_thousand() {
        for gear in gears() {
            let merged = model(&gear);
            let mut split = model(&gear);
            (split.section.rows.iter_mut()).for_each(|row| row.depth = 0.0);
            assert!(split.mesh().hanging.is_empty());
            assert!(split.mesh().cells.len() > merged.mesh().cells.len());
            let [merged, split] = [merged, split].map(|m| m.influence(1, &|_, _| true).unwrap());
            for (merged, split) in merged.iter().zip(&split) {
                let error = (merged - split).amax();
                assert!(error < 3e-4 * split.amax(), "{}", error / split.amax());
                let (even, all) = ((merged - split).sum(), split.sum());
                assert!(even.abs() < 3e-4 * all, "{}", even / all);
            }
        }
    }

    #[test]
    fn flank_and_fillet_lie_where_the_outline_has_them_with_a_web_too() {
        let disc = samples::gear(GearKind::External, 60, 1.0, 20.0, 0.0);
        let webbed = Gear {
            body: Some(Body {
                rim_radius: disc.root_radius() - 8e-3,
                web: [8e-3, 14e-3],
                hub_radius: 30e-3,
                hub: [-5e-3, 30e-3],
                held_ends: [false; 2],
            }),
            ..disc.clone()
        };
        for gear in [disc, webbed] {
            let mesh = model(&gear).mesh();
            let radius = |node: usize| mesh.points[node][0].hypot(mesh.points[node][1]);
            let on_face = |node: usize| (-1e-12..25e-3 + 1e-12).contains(&mesh.points[node][2]);
            assert!(mesh.fillet.len() > 50 && mesh.flank.len() > 50);
            for node in &mesh.fillet {
                let r = radius(*node);
                assert!(
                    gear.root_radius() - 1e-9 < r && r < gear.reference_radius() + 1e-9,
                    "{r}"
                );
                assert!(on_face(*node));
            }
            for flank in &mesh.flank {
                let r = radius(flank.node);
                assert!(r < gear.tip_radius + 1e-9 && on_face(flank.node), "{r}");
            }
        }
    }
}
