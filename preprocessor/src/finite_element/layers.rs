//! Layers of the mesh along the axis, and which parts of the body lie in each.

use super::grading::graded_from_both;
use super::section::Row;
use super::settings::Discretization;
use gearmesh::gear::{Body, Gear};
use std::ops::Range;

/// Growth of the layers away from the ends of the face and from the faces of a web.
const GROWTH: f64 = 1.6;

/// Depth below the root over the thickness of merged layers, and face width over it: what loads on the flank change
/// along the face decays with the depth, what a helix's thrust bends does not and needs some layers. Measured on
/// gears without and with helix and on rings: with these the mean influence of a flank changes by 2e-4 or less.
const DEPTH_OVER_LAYER: f64 = 1.0;
const FACE_OVER_LAYER: f64 = 8.0;

/// Layers at either end that stay by themselves: they were made thin for what the free ends change.
const THIN_AT_AN_END: usize = 2;

/// `layers` in pairs from both ends on, but for the thin ones at the ends, with what is left in the middle as one.
fn merged(layers: &[Range<usize>]) -> Vec<Range<usize>> {
    let thin = THIN_AT_AN_END.min(layers.len() / 2);
    let side = thin + (layers.len() - 2 * thin) / 4 * 2;
    let (low, rest) = layers.split_at(side);
    let (middle, high) = rest.split_at(layers.len() - 2 * side);
    let mut all = low[..thin].to_vec();
    all.extend(low[thin..].chunks(2).map(whole));
    all.extend((!middle.is_empty()).then(|| whole(middle)));
    all.extend(high[..side - thin].chunks(2).map(whole));
    all.extend_from_slice(&high[side - thin..]);
    all
}

/// From the first to the last of `layers`.
fn whole(layers: &[Range<usize>]) -> Range<usize> {
    layers[0].start..layers[layers.len() - 1].end
}

/// Layers along z.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layers {
    /// Ends of the layers, m from the z = 0 face, ascending. Those of the hub may lie beyond the face.
    pub stations: Vec<f64>,
    /// The layers within the face.
    pub face: Range<usize>,
    body: Option<Body>,
}

impl Layers {
    /// Layers of `gear`, graded to both ends of the face and, if it has a web, to both faces of that.
    pub fn new(gear: &Gear, sizes: &Discretization) -> Layers {
        let (face, m) = (gear.face_width, gear.normal_module);
        let Some(body) = gear.body else {
            let stations = sizes.stations(face, m);
            return Layers {
                face: 0..stations.len() - 1,
                stations,
                body: None,
            };
        };
        let close = |a: f64, b: f64| (a - b).abs() < 1e-9;
        let [layer, end] = [sizes.middle_layer(face, m), sizes.end_layer].map(|size| size * m);
        let at_web = layer.min(0.5 * (body.web[1] - body.web[0]));
        let mut stops = vec![(0.0, end), (face, end)];
        for z in body.web {
            if !stops.iter().any(|(stop, _)| close(*stop, z)) {
                stops.push((z, at_web));
            }
        }
        for z in body.hub {
            if !stops.iter().any(|(stop, _)| close(*stop, z)) {
                stops.push((z, layer));
            }
        }
        stops.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut stations = vec![stops[0].0];
        for ends in stops.windows(2) {
            let [(low, first), (high, last)] = [ends[0], ends[1]];
            // A shaft is round beyond the face, and as coarse as that.
            let beyond = body.is_shaft() && (high <= 0.0 || low >= face);
            let largest = if beyond {
                layer.max(0.5 * body.hub_radius)
            } else {
                layer
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
            body: Some(body),
        }
    }

    /// Ends of the layers within the face, m.
    pub fn of_face(&self) -> &[f64] {
        &self.stations[self.face.start..=self.face.end]
    }

    /// Whether the end of a layer with this number is an end of a shaft that is held.
    pub fn is_held(&self, station: usize) -> bool {
        let [low, high] = self.body.map_or([false; 2], |body| body.held_ends);
        (low && station == 0) || (high && station == self.stations.len() - 1)
    }

    /// Every layer by itself.
    pub fn single(&self) -> Vec<Range<usize>> {
        (1..self.stations.len()).map(|end| end - 1..end).collect()
    }

    /// Layers of each of the `rows` below the root: merged as far as
    /// [`DEPTH_OVER_LAYER`] allows. The same seen from the other end of the face; each row's layers are made of whole
    /// ones of the row above.
    pub fn of_rows(&self, rows: &[Row]) -> Vec<Vec<Range<usize>>> {
        let single = self.single();
        let merged = merged(&single);
        let thickness =
            |layer: &Range<usize>| self.stations[layer.end] - self.stations[layer.start];
        let thickest = merged.iter().map(thickness).fold(0.0, f64::max);
        let face = self.stations[self.face.end] - self.stations[self.face.start];
        let merges = self.body.is_none() && thickest * FACE_OVER_LAYER <= face;
        let is_deep = |row: &Row| merges && row.depth >= DEPTH_OVER_LAYER * thickest;
        let of_row = |row: &Row| if is_deep(row) { &merged } else { &single }.clone();
        rows.iter().map(of_row).collect()
    }

    /// Whether there is material of a row of this [`Row::width`] in the layer `layer`.
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

    fn row(depth: f64) -> Row {
        Row { depth, width: None }
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
    fn deep_rows_have_layers_made_of_whole_ones_that_mirror() {
        let sizes = Discretization::of(Refinement::Normal);
        for face in [50e-3, 60e-3, 63e-3, 66e-3, 69e-3, 150e-3] {
            let gear = Gear {
                face_width: face,
                ..samples::gear(GearKind::External, 80, 1.0, 0.0, 0.0)
            };
            let layers = Layers::new(&gear, &sizes);
            let rows = layers.of_rows(&[0.0, 1e-3, 1.0].map(row));
            let (all, deep) = (layers.single(), &rows[2]);
            assert_eq!([&rows[0], &rows[1]], [&all; 2]);
            assert!(deep.len() <= all.len() / 2 + 3);
            assert_eq!(deep[0].start, 0);
            assert_eq!(deep[deep.len() - 1].end, all.len());
            assert!(deep.windows(2).all(|two| two[0].end == two[1].start));
            let mirrored = deep
                .iter()
                .rev()
                .map(|l| all.len() - l.end..all.len() - l.start);
            assert!(mirrored.eq(deep.iter().cloned()));
        }
        let narrow = Layers::new(
            &samples::gear(GearKind::External, 80, 1.0, 0.0, 0.0),
            &sizes,
        );
        assert_eq!(narrow.of_rows(&[row(1.0)]), [narrow.single()]);
        let body = Layers::new(&self::gear([4e-3, 9e-3], [0.0, 25e-3]), &sizes);
        assert_eq!(body.of_rows(&[row(1.0)]), [body.single()]);
    }

    #[test]
    fn wide_faces_have_thicker_layers_instead_of_more_but_for_the_thin_ones_at_the_ends() {
        let layers = |modules: f64| {
            let sizes = Discretization::of(Refinement::Normal);
            sizes.stations(4e-3 * modules, 4e-3)
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
