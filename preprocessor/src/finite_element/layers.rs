//! Layers of the mesh along the axis, and which parts of the body lie in each.

use super::grading::graded_from_both;
use super::settings::Discretization;
use gearmesh::gear::{Body, Gear};
use std::ops::Range;

/// Growth of the layers away from the ends of the face and from the faces of a web.
const GROWTH: f64 = 1.6;

/// Face width, in normal modules, beyond which the layers in its middle grow with it, so that their number does not: loads change
/// along the face on the scale of its width. Measured with faces of 17 and 23 modules: the mean transmission error changes by 5e-5
/// aligned and 1.5e-4 under half a milliradian, its peak-to-peak by 1 nm, z_c by 1e-4 of the face width.
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
            let parts = web
                .map(|z| (z, at_web))
                .into_iter()
                .chain(hub.map(|z| (z, layer)));
            for (z, size) in parts {
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
        let index = |z: f64| stations.partition_point(|s| *s < z - 1e-12);
        Layers {
            face: index(0.0)..index(face),
            stations,
            body: gear.body,
        }
    }

    pub fn of_face(&self) -> &[f64] {
        &self.stations[self.face.start..=self.face.end]
    }

    /// Whether the end of a layer with this number is an end of a shaft that is held.
    pub fn is_held(&self, station: usize) -> bool {
        let [low, high] = self.body.map_or([false; 2], |body| body.held_ends);
        (low && station == 0) || (high && station == self.stations.len() - 1)
    }

    /// Whether there is material of this width (see [`super::section::Section::widths`]) in the layer `layer`.
    pub fn holds(&self, width: Option<[f64; 2]>, layer: usize) -> bool {
        let middle = 0.5 * (self.stations[layer] + self.stations[layer + 1]);
        match width {
            None => self.face.contains(&layer),
            Some([low, high]) => low < middle && middle < high,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples;
    use gearmesh::gear::GearKind;
    use gearmesh::pair::Refinement;

    fn gear(web: [f64; 2], hub: [f64; 2]) -> Gear {
        Gear {
            body: Some(Body {
                rim_radius: 28e-3,
                web,
                hub_radius: 20e-3,
                hub,
                held_ends: [false; 2],
            }),
            ..samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0)
        }
    }

    #[test]
    fn layers_end_at_every_face_of_the_body_and_mirror_with_it() {
        let sizes = Discretization::of(Refinement::Normal);
        let gear = gear([4e-3, 9e-3], [-5e-3, 21e-3]);
        let layers = Layers::new(&gear, &sizes);
        for z in [-5e-3, 0.0, 4e-3, 9e-3, 21e-3, 25e-3] {
            assert!(layers.stations.contains(&z), "{z}");
        }
        assert_eq!(layers.of_face().first(), Some(&0.0));
        assert_eq!(layers.of_face().last(), Some(&25e-3));
        let turned = Gear {
            body: gear.body.map(|b| b.mirrored(gear.face_width)),
            ..gear.clone()
        };
        let turned = Layers::new(&turned, &sizes);
        assert_eq!(turned.stations.len(), layers.stations.len());
        for (a, b) in turned.stations.iter().rev().zip(&layers.stations) {
            assert!((25e-3 - a - b).abs() < 1e-12);
        }
    }

    #[test]
    fn wide_faces_have_thicker_layers_instead_of_more_but_for_the_thin_ones_at_the_ends() {
        let sizes = Discretization::of(Refinement::Normal);
        let layers = |modules: f64| {
            let gear = samples::gear(GearKind::External, 20, 1.0, 0.0, 0.0);
            let face_width = modules * gear.normal_module;
            Layers::new(&Gear { face_width, ..gear }, &sizes).stations
        };
        let [narrow, wide, wider] = [15.0, 30.0, 60.0].map(layers);
        assert!(wide.len() <= narrow.len() + 4);
        assert!(wider.len() <= wide.len() + 4);
        let end = |stations: &[f64]| stations[1] / 4e-3;
        for stations in [&narrow, &wide, &wider] {
            assert!((0.24..0.36).contains(&end(stations)), "{}", end(stations));
        }
    }

    #[test]
    fn a_body_as_wide_as_the_face_has_the_layers_of_its_parts_alone() {
        let face = [0.0, 25e-3];
        let layers = Layers::new(&gear(face, face), &Discretization::of(Refinement::Normal));
        assert_eq!(layers.face, 0..layers.stations.len() - 1);
        for width in [None, Some(face)] {
            assert!((0..layers.stations.len() - 1).all(|layer| layers.holds(width, layer)));
        }
    }
}
