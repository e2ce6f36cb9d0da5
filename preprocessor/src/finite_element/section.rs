//! One tooth in the transverse section: the structured mesh of its sector of 8-node
//! quadrilaterals.
//!
//! ```text
//!        tip
//!       +---+
//!       | A |  <- loaded flank, elements graded towards it
//!   CL _/---\_ CR
//!  +---+-----+---+   root circle; the blocks meet in the middle of the fillets
//!  |   |  B  |   |
//!  +---+-----+---+   held surface
//! ```
//!
//! Both sides of the sector lie in the middle of a space and carry the same radii, so that the
//! sector repeats around the gear. In a ring the same figure stands on its head. Where the body has a web, rows
//! end at the inside of the rim and at the hub.

use super::element::QUAD8;
use super::outline::{Outline, Polar};
use super::settings::{Discretization, divide, graded, graded_from_both, halved};
use gearmesh::gear::Gear;

/// Least radius of curvature of a fillet, in modules, along which elements for its stress have the size of their level; along sharper ones
/// they are as much smaller. Else a fillet of 0.09 modules would bear 5 % too little at level normal.
const SHARP_FILLET: f64 = 0.42;

/// Elements along the flank over the one at the tip edge, where the load kernel is narrower.
const FLANK_OVER_TIP: f64 = 4.0;

/// Mesh of the section of one sector, tooth centre line at angle 0.
#[derive(Debug, Clone, Default)]
pub(super) struct Section {
    /// Nodes in polar coordinates (m, rad).
    pub nodes: Vec<Polar>,
    /// Corners, then mid-edges, as [`super::element::QUAD8`].
    pub quads: Vec<[usize; 8]>,
    /// (column, row) of each quadrilateral in the figure above, along which the matrix ordering cuts.
    pub cells: Vec<[i32; 2]>,
    /// Nodes along the loaded flank from the middle of the fillet to the tip (corner, mid-edge,
    /// corner, ...) with their arc length.
    pub flank: Vec<(usize, f64)>,
    /// Nodes along root circle and fillet from the middle of the space to the form point (corner, mid-edge,
    /// corner, ...) with their arc length.
    pub fillet: Vec<(usize, f64)>,
    /// Ends along z, m, of the web or the hub to which a row of quadrilaterals belongs, for each row below the root; None: as wide as
    /// the face.
    pub widths: Vec<Option<[f64; 2]>>,
    /// Nodes on the sector's sides at -half pitch and +half pitch in the same order, rigidly held ones
    /// left out.
    pub sides: [Vec<usize>; 2],
    pub held: Vec<usize>,
    /// The first of the quadrilaterals of the body, of which few stand for a pitch.
    pub body: usize,
    /// Nodes that lie on the edges of those.
    pub hanging: Vec<Hanging>,
}

/// A node on the edge of a quadrilateral, of which it is no node: its displacement is that of the edge.
#[derive(Debug, Clone)]
pub(super) struct Hanging {
    pub node: usize,
    /// First corner, middle and second corner of the edge.
    pub edge: [usize; 3],
    /// Place on the edge, -1 at its first corner, 1 at its second.
    pub xi: f64,
}

/// A row of nodes below the root.
struct Depth {
    /// Share of the way from the root to the radius `target`, m.
    t: f64,
    target: f64,
    /// Share of the whole way to the held surface, about.
    share: f64,
    /// As in [`Section::widths`], above this row.
    width: Option<[f64; 2]>,
}

impl Depth {
    /// Radius of this row under the root at `radius`.
    fn below(&self, radius: f64) -> f64 {
        radius + self.t * (self.target - radius)
    }
}

/// Index of the row where the body begins, `depth` (m) below the root at the radius `corner`: that and the rows below are round, those above
/// run into it. The last one where less than two rows of elements would be left.
fn body_begins(rows: &mut [Depth], corner: f64, depth: f64) -> usize {
    let last = rows.len() - 1;
    let mut ends = (0..=last).step_by(2);
    let first = ends.find(|i| (rows[*i].below(corner) - corner).abs() >= depth);
    let Some(first) = first.filter(|first| first + 4 <= last) else {
        return last;
    };
    let (t, target) = (rows[first].t, rows[first].below(corner));
    let (above, below) = rows.split_at_mut(first);
    if t < 1.0 {
        for row in above {
            (row.t, row.target) = (row.t / t, target);
        }
    }
    for row in below {
        (row.t, row.target) = (1.0, row.below(corner));
    }
    first
}

/// Largest angle, rad, that an element of the body spans, and the least number of them in a pitch.
const BODY_ANGLE: f64 = 0.25;
const BODY_ELEMENTS: f64 = 2.0;

/// Node numbers of a block by column and row, both at half-element steps.
type Grid = Vec<Vec<usize>>;

/// In a [`Grid`]: not yet a node, or never one, in the middle of an element.
const NO_NODE: usize = usize::MAX;

/// Arc lengths along the loaded flank at half-element steps: from `corner` in elements of the size `fillet` to the form point (a
/// node), from there of the size `involute` to the tip, and at its edge of the size `tip`.
fn along_flank(outline: &Outline, corner: f64, [fillet, involute, tip]: [f64; 3]) -> Vec<f64> {
    let mut arcs = halved(&divide(corner, 0.0, fillet));
    let mut above = divide(0.0, outline.tip_arc, involute);
    // To a fifth of rounding in the number of steps.
    while above[above.len() - 1] - above[above.len() - 2] > 1.2 * tip {
        let last = above.len() - 1;
        above.insert(last, 0.5 * (above[last - 1] + above[last]));
    }
    arcs.extend(&halved(&above)[1..]);
    arcs
}

/// Places of the rows below the root, at half-element steps; the blocks meet at the radius `corner`.
fn below_root(gear: &Gear, corner: f64, first: f64, growth: f64) -> Vec<Depth> {
    let held = gear.held_radius;
    let depth = (corner - held).abs();
    let inside_rim = gear.body.map_or(held, |body| body.rim_radius);
    let height = (corner - inside_rim).abs();
    let rim = graded(height, first, growth, height);
    let mut rows: Vec<Depth> = halved(&rim)
        .into_iter()
        .map(|t| Depth {
            t,
            target: inside_rim,
            share: t * height / depth,
            width: None,
        })
        .collect();
    let Some(body) = gear.body else {
        return rows;
    };
    let mut annulus = |[outer, inner]: [f64; 2], width: [f64; 2], first: [f64; 2]| {
        let length = outer - inner;
        if length <= 0.0 {
            return;
        }
        let ends = graded_from_both(length, first, growth, length);
        rows.extend(halved(&ends).into_iter().skip(1).map(|t| {
            let target = outer - t * length;
            Depth {
                t: 1.0,
                target,
                share: (corner - target) / depth,
                width: Some(width),
            }
        }));
    };
    // At the corners between rim, web and hub half of what is thin there; along a shaft displacements go as the radius does.
    let last = height * (1.0 - rim[rim.len() - 2]);
    let [half, at_bore] = match body.is_shaft() {
        true => [last, 0.25 * body.hub_radius],
        false => [
            0.5 * (body.web[1] - body.web[0]),
            0.25 * (body.hub[1] - body.hub[0]),
        ],
    };
    annulus(
        [body.rim_radius, body.hub_radius],
        body.web,
        [half.min(last), half],
    );
    annulus([body.hub_radius, held], body.hub, [half, at_bore]);
    rows
}

impl Section {
    pub fn new(gear: &Gear, outline: &Outline, sizes: &Discretization) -> Section {
        let module = gear.normal_module;
        let flank = sizes.flank_element * module;
        let involute = sizes.involute_element.map_or(flank, |size| size * module);
        let (fillet, root) = match sizes.fillet_element {
            Some(size) => {
                let sharpest = outline.sharpest() / SHARP_FILLET;
                let size = size * sharpest.min(module);
                (size, size)
            }
            None => (flank, sizes.root_element * module),
        };
        let corner_arc = outline.fillet_middle();
        let corner = outline.point(corner_arc);
        let sizes_along = [fillet, involute, flank / FLANK_OVER_TIP];
        let arcs = along_flank(outline, corner_arc, sizes_along);
        // From the unloaded flank (0) to the loaded one (1).
        let (width, largest) = (2.0 * corner[0] * corner[1], sizes.tooth_element * module);
        let across = graded(width, fillet.min(flank), sizes.growth, largest);
        let across: Vec<f64> = across.iter().rev().map(|t| 1.0 - t).collect();
        let across = halved(&across);
        let mut depths = below_root(gear, corner[0], root, sizes.growth);
        let space = outline.point(outline.space_arc());
        let fine_depth = sizes.fine_depth * 2.0 * space[1] * corner[0];
        let begin = body_begins(&mut depths, corner[0], fine_depth);
        let land = corner_arc - outline.space_arc();
        let columns = halved(&divide(0.0, land, root.min(0.5 * land)));

        let mut section = Section::default();
        // Block A stands on a curve that sags below the corners.
        let [radius, angle] = corner;
        let sag = 0.067 * 2.0 * radius * angle * outline.kappa;
        let bottom = |u: f64| [radius - 4.0 * sag * u * (1.0 - u), angle * (2.0 * u - 1.0)];
        let tip = outline.point(outline.tip_arc);
        let top = |u: f64| [tip[0], tip[1] * (2.0 * u - 1.0)];
        let height = outline.tip_arc - corner_arc;
        let a = vec![vec![NO_NODE; arcs.len()]; across.len()];
        let a = section.block([0, 1], a, |i, j| {
            let right = outline.point(arcs[j]);
            let (u, v) = (across[i], (arcs[j] - corner_arc) / height);
            let ends = [
                [bottom(0.0), bottom(u), bottom(1.0)],
                [top(0.0), top(u), top(1.0)],
            ];
            transfinite(u, v, [[right[0], -right[1]], right], ends)
        });
        // Block B shares the lowest row of A.
        let mut b = vec![vec![NO_NODE; begin + 1]; across.len()];
        (b.iter_mut().zip(&a)).for_each(|(b, a)| b[0] = a[0]);
        let b = section.block([0, -1], b, |i, j| {
            let [radius, angle] = bottom(across[i]);
            [depths[j].below(radius), angle]
        });
        // Blocks C share the outermost columns of B.
        let last = across.len() - 1;
        let mut under_space = |shared: usize, first: i32, side: f64| {
            let mut c = vec![vec![NO_NODE; begin + 1]; columns.len()];
            c[0].clone_from(&b[shared]);
            section.block([first, -1], c, |i, j| {
                let w = columns[i] / land;
                let [radius, angle] = outline.point(corner_arc - columns[i]);
                let end = corner[1] + w * (space[1] - corner[1]);
                let angle = angle + depths[j].share * (end - angle);
                [depths[j].below(radius), side * angle]
            })
        };
        let right = under_space(last, last as i32 / 2, 1.0);
        let left = under_space(0, -1, -1.0);

        let loaded = arcs.iter().zip(&a[last]);
        section.flank = loaded.map(|(arc, node)| (*node, *arc)).collect();
        let below = columns.iter().zip(&right).skip(1).rev();
        let below = below.map(|(away, column)| (column[0], corner_arc - away));
        let above = section.flank.iter().copied();
        let above = above.take_while(|(_, arc)| *arc <= 0.0);
        section.fillet = below.chain(above).collect();
        let below = depths.iter().skip(1).step_by(2);
        section.widths = below.map(|depth| depth.width).collect();
        let [mut left_side, mut right_side] =
            [&left, &right].map(|grid| grid[columns.len() - 1].clone());
        let lowest = depths.len() - 1;
        // The body from the left side to the right one, with edges on which the nodes above it hang.
        section.body = section.quads.len();
        let mut lowest_row: Vec<usize> = left
            .iter()
            .chain(&b)
            .chain(&right)
            .map(|column| column[begin])
            .collect();
        if begin < lowest {
            let radii = depths[begin..].iter().map(|depth| depth.below(corner[0]));
            let ends = [left_side[begin], right_side[begin]];
            let body = section.add_body(&radii.collect::<Vec<_>>(), space[1], ends, &lowest_row);
            let end = body.len() - 1;
            left_side.extend(&body[0][1..]);
            right_side.extend(&body[end][1..]);
            lowest_row = body.iter().map(|column| column[lowest - begin]).collect();
        }
        // A bore or the outside of a ring that rests on a foundation is free to move, and so is the bore of a shaft.
        let is_shaft = gear.body.is_some_and(|body| body.is_shaft());
        let free = lowest + usize::from(is_shaft || gear.foundation.is_some());
        section.sides = [left_side, right_side].map(|side| side[..free].to_vec());
        if !is_shaft {
            section.held = lowest_row;
        }
        section.held.sort_unstable();
        section.held.dedup();
        section
    }

    /// Adds the body at these `radii` (m, at half steps) between the sides at -`half_pitch` and `half_pitch` (rad), which it meets in the nodes
    /// `ends`. The other nodes of the row `above` hang on its edges.
    fn add_body(
        &mut self,
        radii: &[f64],
        half_pitch: f64,
        ends: [usize; 2],
        above: &[usize],
    ) -> Grid {
        let count = (2.0 * half_pitch / BODY_ANGLE).ceil().max(BODY_ELEMENTS);
        let angles = halved(&divide(-half_pitch, half_pitch, 2.0 * half_pitch / count));
        let last = angles.len() - 1;
        let mut grid = vec![vec![NO_NODE; radii.len()]; angles.len()];
        [grid[0][0], grid[last][0]] = ends;
        let row = -1 - (self.widths.len() - radii.len() / 2) as i32;
        let grid = self.block([0, row], grid, |i, j| [radii[j], angles[i]]);
        let mut above: Vec<usize> = above
            .iter()
            .copied()
            .filter(|n| !ends.contains(n))
            .collect();
        above.sort_unstable();
        above.dedup();
        for node in above {
            let angle = self.nodes[node][1];
            // Corners between the edges before it.
            let corners = angles[2..last].iter().step_by(2);
            let first = 2 * corners.take_while(|corner| **corner <= angle).count();
            self.hanging.push(Hanging {
                node,
                edge: [0, 1, 2].map(|i| grid[first + i][0]),
                xi: (angle - angles[first + 1]) / (angles[first + 1] - angles[first]),
            });
        }
        grid
    }

    /// A sector of the body of `gear` from the `radius` (m) on, without teeth, at these `angles` (rad, ascending, at half steps); `ends` gives
    /// the radii where elements end between two of them.
    pub fn of_body(
        gear: &Gear,
        radius: f64,
        angles: &[f64],
        ends: impl Fn([f64; 2]) -> Vec<f64>,
    ) -> Section {
        let web = gear.body.map_or(gear.held_radius, |body| body.hub_radius);
        let parts = [
            ([radius, web], gear.body.map(|body| body.web)),
            ([web, gear.held_radius], gear.body.map(|body| body.hub)),
        ];
        let mut radii = vec![radius];
        let mut section = Section::default();
        for (part, width) in parts.into_iter().filter(|([a, b], _)| a != b) {
            let ends = ends(part);
            section.widths.extend(vec![width; ends.len() - 1]);
            radii.extend(&halved(&ends)[1..]);
        }
        let grid = vec![vec![NO_NODE; radii.len()]; angles.len()];
        let grid = section.block([0, -1], grid, |i, j| [radii[j], angles[i]]);
        section.body = section.quads.len();
        let lowest = radii.len() - 1;
        section.sides = [&grid[0], &grid[angles.len() - 1]].map(|side| side[..=lowest].to_vec());
        section.held = grid.iter().map(|column| column[lowest]).collect();
        section.held.sort_unstable();
        section
    }

    /// Adds a block of elements, and at `place` (column, row) the nodes that `grid` does not have yet. Cells count on from `first`
    /// away from cell (0, 0).
    fn block(
        &mut self,
        first: [i32; 2],
        mut grid: Grid,
        place: impl Fn(usize, usize) -> Polar,
    ) -> Grid {
        for (i, column) in grid.iter_mut().enumerate() {
            for (j, number) in column.iter_mut().enumerate() {
                if *number == NO_NODE && (i % 2 == 0 || j % 2 == 0) {
                    *number = self.nodes.len();
                    self.nodes.push(place(i, j));
                }
            }
        }
        for i in (0..grid.len() - 1).step_by(2) {
            for j in (0..grid[0].len() - 1).step_by(2) {
                let half = |c: f64| (1.0 + c) as usize;
                let mut quad = QUAD8.map(|c| grid[i + half(c[0])][j + half(c[1])]);
                if self.signed_area(&quad) < 0.0 {
                    // The same corner first, the other way round.
                    quad[1..4].reverse();
                    quad[4..].reverse();
                }
                self.quads.push(quad);
                let away = |from: i32, steps: usize| {
                    let steps = steps as i32 / 2;
                    if from < 0 { from - steps } else { from + steps }
                };
                self.cells.push([away(first[0], i), away(first[1], j)]);
            }
        }
        grid
    }

    /// Ends along z of the part of the body to which the elements of `row` belong, see [`Section::widths`].
    pub fn width(&self, row: i32) -> Option<[f64; 2]> {
        let below = usize::try_from(-1 - row).ok()?;
        self.widths[below]
    }

    fn signed_area(&self, quad: &[usize; 8]) -> f64 {
        let corners = [0, 1, 2, 3].map(|k| {
            let [r, theta] = self.nodes[quad[k]];
            [r * theta.cos(), r * theta.sin()]
        });
        let sides = (0..4).map(|k| (corners[k], corners[(k + 1) % 4]));
        sides.map(|(p, q)| 0.5 * (p[0] * q[1] - p[1] * q[0])).sum()
    }
}

/// Transfinite interpolation (Gordon, Hall 1973) between two sides and two ends; `ends[k]` holds
/// the bottom (0) and top (1) curve at u = 0, u and 1.
fn transfinite(u: f64, v: f64, sides: [Polar; 2], ends: [[Polar; 3]; 2]) -> Polar {
    std::array::from_fn(|d| {
        let across = (1.0 - u) * sides[0][d] + u * sides[1][d];
        let along = (1.0 - v) * ends[0][1][d] + v * ends[1][1][d];
        let corners = (1.0 - v) * ((1.0 - u) * ends[0][0][d] + u * ends[0][2][d])
            + v * ((1.0 - u) * ends[1][0][d] + u * ends[1][2][d]);
        across + along - corners
    })
}
