//! The mesh of one sector: the section swept along the helix through layers, and the stiffness of its elements.

use super::element;
use super::outline::Outline;
use super::section::{Hanging, Section};
use super::settings::{Discretization, graded_from_both};
use gearmesh::gear::{Body, Gear};
use nalgebra::DMatrix;
use std::collections::HashMap;
use std::ops::Range;

/// Growth of the layers away from the ends of the face and from the faces of a web.
const GROWTH: f64 = 1.6;

/// Face width, in normal modules, beyond which the layers in its middle grow with it, as the scale of loads does. Measured with
/// faces of 17 and 23 modules: the mean transmission error changes by 5e-5 aligned and 1.5e-4 under half a milliradian, its
/// peak-to-peak by 1 nm, z_c by 1e-4 of the face width.
const WIDE_FACE: f64 = 15.0;

/// Layers along z.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layers {
    /// Ends of the layers, m from the z = 0 face, ascending. Those of the hub may lie beyond the face.
    pub stations: Vec<f64>,
    pub face: Range<usize>,
    body: Option<Body>,
}

impl Layers {
    /// Layers of `gear`, graded to both ends of the face and, if it has a web, to both faces of that.
    pub fn new(gear: &Gear, sizes: &Discretization) -> Layers {
        let (face, m) = (gear.face_width, gear.normal_module);
        let end = sizes.end_layer * m;
        let layer = sizes.layer * (face / WIDE_FACE).max(m);
        let mut stops = vec![(0.0, end), (face, end)];
        if let Some(Body { web, hub, .. }) = gear.body {
            let at_web = layer.min(0.5 * (web[1] - web[0]));
            let parts = [web.map(|z| (z, at_web)), hub.map(|z| (z, layer))];
            for (z, size) in parts.into_iter().flatten() {
                if !stops.iter().any(|(stop, _)| (stop - z).abs() < 1e-9) {
                    stops.push((z, size));
                }
            }
        }
        stops.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut stations = vec![stops[0].0];
        for ends in stops.windows(2) {
            let [(low, first), (high, last)] = [ends[0], ends[1]];
            // A shaft is round beyond the face, and as coarse as that.
            let shaft = gear.body.filter(|body| body.is_shaft());
            let largest = match shaft.filter(|_| high <= 0.0 || low >= face) {
                Some(shaft) => layer.max(0.5 * shaft.hub_radius),
                None => layer,
            };
            let parts = graded_from_both(high - low, [first, last], GROWTH, largest);
            let inner = &parts[1..parts.len() - 1];
            stations.extend(inner.iter().map(|t| low + t * (high - low)));
            stations.push(high);
        }
        let [first, last] = [0.0, face].map(|z| stations.partition_point(|s| *s < z - 1e-12));
        Layers {
            face: first..last,
            stations,
            body: gear.body,
        }
    }

    /// Those above the plane at `z`, m, if it lies between two layers and mirrors all.
    pub fn above(&self, z: f64) -> Option<Layers> {
        let middle = self.stations.len() / 2;
        let mut both = self.stations.iter().zip(self.stations.iter().rev());
        let is_mirrored = self.stations.len() % 2 == 1
            && both.all(|(low, high)| (low + high - 2.0 * z).abs() < 1e-9);
        is_mirrored.then(|| Layers {
            stations: self.stations[middle..].to_vec(),
            face: 0..self.face.end - middle,
            body: self.body.map(|body| Body {
                held_ends: [false, body.held_ends[1]],
                ..body
            }),
        })
    }

    pub fn of_face(&self) -> &[f64] {
        &self.stations[self.face.start..=self.face.end]
    }

    /// Whether an end of a shaft that is held lies `half` half layers from the first station.
    pub fn is_held(&self, half: usize) -> bool {
        let [low, high] = self.body.map_or([false; 2], |body| body.held_ends);
        (low && half == 0) || (high && half == 2 * (self.stations.len() - 1))
    }

    /// Whether there is material of this width (see [`Section::widths`]) in the layer `layer`.
    pub fn holds(&self, width: Option<[f64; 2]>, layer: usize) -> bool {
        let middle = 0.5 * (self.stations[layer] + self.stations[layer + 1]);
        match width {
            None => self.face.contains(&layer),
            Some([low, high]) => low < middle && middle < high,
        }
    }
}

/// A sparse load, or functional of the displacement: (unknown, value), unknowns numbered node by node.
pub(super) type LoadColumn = Vec<(usize, f64)>;

/// One sector of the gear; displacements are in each node's own cylindrical axes, so that both sides of
/// the sector match without a rotation.
#[derive(Debug, Clone, Default)]
pub(super) struct Mesh {
    /// 2: plane strain, per metre of depth; 3: solid.
    pub dimension: usize,
    /// Young's modulus, Pa, and Poisson ratio.
    pub material: [f64; 2],
    /// Cartesian coordinates, m.
    pub points: Vec<[f64; 3]>,
    /// Polar angle of each node, rad.
    pub angles: Vec<f64>,
    /// Nodes of each element.
    pub elements: Vec<Vec<usize>>,
    /// (column, row, layer) of each element.
    pub cells: Vec<[i32; 3]>,
    /// Rigidly held nodes.
    pub held: Vec<bool>,
    /// Nodes on the held surface.
    pub on_held_surface: Vec<bool>,
    /// Stiffness (N/m³, in each direction) of the foundation on which that surface rests, if it does.
    pub foundation: Option<f64>,
    /// A hole along the axis, or a pin in it.
    pub hole: Option<Hole>,
    /// Free nodes of both sides in the same order.
    pub sides: [Vec<usize>; 2],
    /// Unit loads along the outward normals on the nodes of the loaded flank, in the order of [`super::flank::FlankGrid`].
    pub loads: Vec<LoadColumn>,
    /// Nodes of root circle and fillet next to the loaded flank, in the same order.
    pub fillet: Vec<usize>,
    /// The first of the elements of the body, see [`Section::body`].
    pub body: usize,
    /// Nodes that lie on faces of those, with the nodes of the face that move them and their shares.
    pub hanging: HashMap<usize, Vec<(usize, f64)>>,
    /// Nodes on a plane of symmetry, with the components of their displacement that are zero there.
    pub on_plane: HashMap<usize, Range<usize>>,
}

/// A round hole along the axis through elements that know nothing of it: where they are cut, the integration has many points (finite cell
/// method: Parvizian, Duester, Rank, Comput. Mech. 41, 2007).
#[derive(Debug, Clone, Copy)]
pub(super) struct Hole {
    /// x and y of its middle, m.
    pub middle: [f64; 2],
    /// m.
    pub radius: f64,
    /// Whether a rigid pin fills it.
    pub pin: bool,
}

/// Parts, along and across, of an element that the edge of a hole cuts.
const PARTS: usize = 6;
/// What is left of the stiffness in a hole.
const EMPTY: f64 = 1e-7;
/// Stiffness per volume of what holds a pin, over Young's modulus and over the square of its radius.
const PIN: f64 = 1e3;

impl Hole {
    fn is_inside(&self, x: f64, y: f64) -> bool {
        (x - self.middle[0]).hypot(y - self.middle[1]) < self.radius
    }

    /// As [`element::stiffness`] of the element with the nodes `x`.
    fn stiffness(self, x: &[[f64; 3]], material: [f64; 2]) -> DMatrix<f64> {
        let inside = x.iter().filter(|[x, y, _]| self.is_inside(*x, *y));
        let is_cut = ![0, x.len()].contains(&inside.count());
        let mut points = element::integration_points(x, if is_cut { PARTS } else { 1 });
        if self.pin {
            let mut k = element::stiffness(&points, material);
            let spring = PIN * material[0] / self.radius.powi(2);
            let inside = points
                .iter()
                .filter(|p| self.is_inside(p.place.x, p.place.y));
            for point in inside {
                element::add_springs(&point.shapes, spring * point.volume, 3, &mut k);
            }
            return k;
        }
        for point in &mut points {
            if self.is_inside(point.place.x, point.place.y) {
                point.volume *= EMPTY;
            }
        }
        element::stiffness(&points, material)
    }
}

/// How much the section of `gear` turns along z, rad/m; right-handed.
pub(super) fn twist(gear: &Gear) -> f64 {
    gear.base_helix_angle().tan() / gear.base_radius()
}

impl Hanging {
    /// The nodes of the face on which this node hangs `half` half layers from the first station, each a node of the section and a number of
    /// half layers, and the values of their shape functions there.
    fn by_face(&self, half: usize) -> Vec<((usize, usize), f64)> {
        let [first, middle, last] = self.edge;
        let xi = self.xi;
        let between = 1.0 - xi * xi;
        let ends = [(first, 0.5 * (1.0 - xi)), (last, 0.5 * (1.0 + xi))];
        if half.is_multiple_of(2) {
            let [(first, low), (last, high)] = ends;
            return vec![
                ((first, half), low - 0.5 * between),
                ((middle, half), between),
                ((last, half), high - 0.5 * between),
            ];
        }
        // Halfway between two stations.
        let mut shares: Vec<_> = ends.map(|(node, share)| ((node, half), share)).into();
        for half in [half - 1, half + 1] {
            let corners = ends.map(|(node, _)| ((node, half), -0.25 * between));
            shares.extend(corners);
            shares.push(((middle, half), 0.5 * between));
        }
        shares
    }
}

impl Mesh {
    /// The `section` of `gear` itself for plane strain, or swept through `layers` along the helix without what lies outside of
    /// rim, web and hub.
    pub fn new(gear: &Gear, outline: &Outline, section: &Section, layers: Option<&Layers>) -> Mesh {
        let stations = layers.map_or(&[0.0][..], |layers| &layers.stations);
        let twist = layers.map_or(0.0, |_| twist(gear));
        let mut mesh = Mesh {
            dimension: if layers.is_some() { 3 } else { 2 },
            material: [gear.youngs_modulus, gear.poisson_ratio],
            foundation: gear.foundation,
            ..Mesh::default()
        };
        let elements = mesh.take_cells(section, layers);
        // Numbered as they come.
        let mut numbers = HashMap::new();
        let mut places = Vec::new();
        for element in elements {
            let numbered = element.into_iter().map(|place| {
                *numbers.entry(place).or_insert_with(|| {
                    places.push(place);
                    places.len() - 1
                })
            });
            mesh.elements.push(numbered.collect());
        }
        for (node, half) in &places {
            let z = 0.5 * (stations[half / 2] + stations[half.div_ceil(2)]);
            let [r, theta] = section.nodes[*node];
            let angle = theta + twist * z;
            mesh.points.push([r * angle.cos(), r * angle.sin(), z]);
            mesh.angles.push(angle);
            // Where the body is narrower than the face its rim stands free.
            let within = gear.body.is_none_or(|body| {
                let [low, high] = body.hub;
                low - 1e-9 <= z && z <= high + 1e-9
            });
            let on_surface = within && section.held.binary_search(node).is_ok();
            let at_end = layers.is_some_and(|layers| layers.is_held(*half));
            (mesh.held).push(at_end || on_surface && gear.foundation.is_none());
            mesh.on_held_surface.push(on_surface);
        }
        let twins: HashMap<_, _> = section.sides[0].iter().zip(&section.sides[1]).collect();
        for (number, (node, half)) in places.iter().enumerate() {
            if let (Some(twin), false) = (twins.get(node), mesh.held[number]) {
                mesh.sides[0].push(number);
                mesh.sides[1].push(numbers[&(**twin, *half)]);
            }
        }
        for hanging in &section.hanging {
            for half in 0..2 * stations.len() - 1 {
                let Some(node) = numbers.get(&(hanging.node, half)) else {
                    continue;
                };
                let moved_by = hanging.by_face(half);
                let moved_by: Option<Vec<_>> = (moved_by.into_iter())
                    .map(|(place, share)| Some((*numbers.get(&place)?, share)))
                    .collect();
                // Beside a narrower body it is free.
                if let Some(moved_by) = moved_by.filter(|_| !mesh.held[*node]) {
                    mesh.hanging.insert(*node, moved_by);
                }
            }
        }
        let face = layers.map_or(0..0, |layers| layers.face.clone());
        for half in 2 * face.start..=2 * face.end {
            let fillet = section.fillet.iter();
            (mesh.fillet).extend(fillet.filter_map(|(node, _)| numbers.get(&(*node, half))));
            for (node, arc) in &section.flank {
                if let Some(&number) = numbers.get(&(*node, half)) {
                    // The surface contains the helix direction (0, r twist, 1).
                    let [n_r, n_t] = outline.normal(*arc);
                    let n_z = -n_t * section.nodes[*node][0] * twist;
                    let norm = n_z.hypot(1.0);
                    let normal = [n_r / norm, n_t / norm, n_z / norm];
                    let unknowns = mesh.dimension * number..mesh.dimension * (number + 1);
                    mesh.loads.push(unknowns.zip(normal).collect());
                }
            }
        }
        mesh
    }

    /// The cells of the elements of `section`, swept through `layers` if there are any, and where the body begins among them. Gives the nodes
    /// of each element: node of the section and number of half layers below.
    fn take_cells(
        &mut self,
        section: &Section,
        layers: Option<&Layers>,
    ) -> Vec<Vec<(usize, usize)>> {
        let (mut elements, mut body) = (Vec::new(), None);
        for (at, (quad, [column, row])) in section.quads.iter().zip(&section.cells).enumerate() {
            if at == section.body {
                body = Some(elements.len());
            }
            let Some(layers) = layers else {
                elements.push(quad.map(|node| (node, 0)).to_vec());
                self.cells.push([*column, *row, 0]);
                continue;
            };
            let width = section.width(*row);
            let count = layers.stations.len() - 1;
            for layer in (0..count).filter(|i| layers.holds(width, *i)) {
                let mut element = quad.map(|node| (node, 2 * layer)).to_vec();
                element.extend(quad.map(|node| (node, 2 * layer + 2)));
                element.extend(quad[..4].iter().map(|node| (*node, 2 * layer + 1)));
                elements.push(element);
                self.cells.push([*column, *row, layer as i32]);
            }
        }
        self.body = body.unwrap_or(elements.len());
        elements
    }

    /// Keeps `components` of the displacement of all nodes on the plane at `z` (m) at zero; loads along them are left out.
    pub fn fix_on_plane(&mut self, z: f64, components: &Range<usize>) {
        let on_plane = (0..self.points.len()).filter(|node| self.points[*node][2] == z);
        self.on_plane = on_plane.map(|node| (node, components.clone())).collect();
        for load in &mut self.loads {
            load.retain(|(unknown, _)| {
                let fixed = self.on_plane.get(&(unknown / self.dimension));
                fixed.is_none_or(|fixed| !fixed.contains(&(unknown % self.dimension)))
            });
        }
    }

    pub fn coordinates(&self, element: &[usize]) -> Vec<[f64; 3]> {
        element.iter().map(|node| self.points[*node]).collect()
    }

    /// The nodes that move the `element`: its own, in place of those that hang on faces the nodes of these.
    pub fn moving(&self, element: usize) -> Vec<usize> {
        let nodes = &self.elements[element];
        if !self.hangs(nodes) {
            return nodes.clone();
        }
        let mut moving: Vec<usize> = Vec::new();
        for node in nodes {
            match self.hanging.get(node) {
                Some(face) => moving.extend(face.iter().map(|(node, _)| *node)),
                None => moving.push(*node),
            }
        }
        moving.sort_unstable();
        moving.dedup();
        moving
    }

    fn hangs(&self, nodes: &[usize]) -> bool {
        nodes.iter().any(|node| self.hanging.contains_key(node))
    }

    /// Stiffness of the `element`, N/m, by the displacements of the nodes that move it.
    pub fn moved_stiffness(&self, element: usize) -> DMatrix<f64> {
        let moving = self.moving(element);
        let mut k = self.followed_stiffness(element, &moving);
        for (at, node) in moving.iter().enumerate() {
            let fixed = self.on_plane.get(node).cloned().unwrap_or_default();
            for unknown in fixed.map(|component| self.dimension * at + component) {
                // Nothing moves an unknown that has a stiffness of its own and no load.
                let own = k[(unknown, unknown)];
                k.column_mut(unknown).fill(0.0);
                k.row_mut(unknown).fill(0.0);
                k[(unknown, unknown)] = own;
            }
        }
        k
    }

    fn followed_stiffness(&self, element: usize, moving: &[usize]) -> DMatrix<f64> {
        let nodes = &self.elements[element];
        if !self.hangs(nodes) {
            return self.stiffness(nodes);
        }
        let d = self.dimension;
        let mut follow = DMatrix::zeros(d * nodes.len(), d * moving.len());
        for (i, node) in nodes.iter().enumerate() {
            let itself = [(*node, 1.0)];
            for (by, share) in self.hanging.get(node).map_or(&itself[..], |face| face) {
                let j = moving.partition_point(|other| other < by);
                // Cartesian displacements of a face are interpolated: a rigid body's stay those of one.
                let (sin, cos) = (self.angles[*by] - self.angles[*node]).sin_cos();
                let turn = [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]];
                for (row, turn) in turn.iter().take(d).enumerate() {
                    for (column, value) in turn.iter().take(d).enumerate() {
                        follow[(d * i + row, d * j + column)] = share * value;
                    }
                }
            }
        }
        follow.transpose() * (self.stiffness(nodes) * &follow)
    }

    /// Stiffness of the element with `nodes`, N/m, the displacements of each in its own cylindrical axes.
    pub fn stiffness(&self, nodes: &[usize]) -> DMatrix<f64> {
        let x = self.coordinates(nodes);
        let mut k = match self.hole {
            Some(hole) => hole.stiffness(&x, self.material),
            None => element::stiffness(&element::integration_points(&x, 1), self.material),
        };
        if let Some(stiffness) = self.foundation {
            let rests = nodes.iter().map(|node| self.on_held_surface[*node]);
            element::add_foundation(&x, &rests.collect::<Vec<_>>(), stiffness, &mut k);
        }
        // Symmetric: turned columns become rows, and then they are turned, too.
        for _ in 0..2 {
            k.transpose_mut();
            for (first, node) in nodes.iter().enumerate() {
                let (sin, cos) = self.angles[*node].sin_cos();
                let first = self.dimension * first;
                let (mut x, mut y) = k.columns_range_pair_mut(first, first + 1);
                for (x, y) in x.iter_mut().zip(y.iter_mut()) {
                    (*x, *y) = (cos * *x + sin * *y, cos * *y - sin * *x);
                }
            }
        }
        k
    }

    /// Volume (plane: area) of the mesh, and the smallest ratio of an integration point's Jacobian to
    /// the largest one of the same element: positive on a sound mesh.
    pub fn volume_and_quality(&self) -> (f64, f64) {
        let mut volume = 0.0;
        let mut quality = f64::INFINITY;
        for nodes in &self.elements {
            let points = element::integration_points(&self.coordinates(nodes), 1);
            let jacobians = points.iter().map(|point| point.jacobian);
            let largest = jacobians.clone().fold(f64::MIN, f64::max);
            let smallest = jacobians.fold(f64::MAX, f64::min);
            volume += points.iter().map(|point| point.volume).sum::<f64>();
            quality = quality.min(smallest / largest.abs());
        }
        (volume, quality)
    }
}

#[cfg(test)]
mod tests {
    use crate::finite_element::Settings;
    use crate::finite_element::model::Model;
    use crate::gear::Refinement;
    use crate::samples;
    use gearmesh::gear::GearKind;
    use nalgebra::{DVector, Vector3};

    #[test]
    fn a_rigid_body_moves_elements_with_hanging_nodes_without_a_force() {
        let gear = samples::gear(GearKind::External, 37, 1.0, 20.0, 0.0);
        let model = Model::new(&gear, &Settings::new(Refinement::Coarse, 1)).unwrap();
        let mesh = model.mesh();
        let hanging = (0..mesh.elements.len()).filter(|e| mesh.hangs(&mesh.elements[*e]));
        assert!(hanging.clone().count() > 20);
        for element in hanging {
            let (moving, stiffness) = (mesh.moving(element), mesh.moved_stiffness(element));
            for axis in 0..6 {
                let mut displacement = DVector::zeros(3 * moving.len());
                for (at, node) in moving.iter().enumerate() {
                    let place = Vector3::from(mesh.points[*node]);
                    let along = Vector3::ith(axis % 3, gear.reference_radius());
                    let cartesian = match axis {
                        0..3 => along,
                        _ => along.normalize().cross(&place),
                    };
                    let (sin, cos) = mesh.angles[*node].sin_cos();
                    displacement[3 * at] = cos * cartesian.x + sin * cartesian.y;
                    displacement[3 * at + 1] = cos * cartesian.y - sin * cartesian.x;
                    displacement[3 * at + 2] = cartesian.z;
                }
                let force = (&stiffness * &displacement).amax();
                let bound = 1e-5 * stiffness.amax() * displacement.amax();
                assert!(force < bound, "{force:e} of {bound:e}, axis {axis}");
            }
        }
    }
}
