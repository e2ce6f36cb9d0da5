//! Structured mesh of one tooth sector in the transverse section: 8-node quadrilaterals.
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
use super::grading::{divide, graded, graded_from_both, halved};
use super::outline::{Outline, Polar};
use super::settings::Discretization;
use gearmesh::gear::Gear;

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
}

/// A place below the root: the shares of the way to the radius `target` and of the whole way to the held surface, about.
#[derive(Debug, Clone, Copy)]
struct Depth {
    t: f64,
    target: f64,
    share: f64,
    /// As in [`Section::widths`], above this place.
    width: Option<[f64; 2]>,
}

/// A block of (columns + 1) x (rows + 1) node numbers at half-element steps.
type Grid = Vec<Vec<usize>>;

/// Stations of the three kinds of block, at half-element steps.
struct Stations<'a> {
    outline: &'a Outline,
    /// Middle of the fillet, where the blocks meet: arc length and place.
    corner_arc: f64,
    corner: Polar,
    arcs: Vec<f64>,
    /// From the unloaded flank (0) to the loaded one (1).
    across: Vec<f64>,
    rows: Vec<Depth>,
    columns: Vec<f64>,
}

impl<'a> Stations<'a> {
    fn new(gear: &Gear, outline: &'a Outline, sizes: &Discretization) -> Self {
        let module = gear.normal_module;
        let flank = sizes.flank_element * module;
        let fillet = sizes.fillet_element.map(|size| size * module);
        let along_involute = sizes.involute_element.map_or(flank, |size| size * module);
        let corner_arc = outline.fillet_middle();
        let corner = outline.point(corner_arc);
        // The form point, at arc length 0, is a node.
        let along_fillet = fillet.unwrap_or(flank);
        let mut arcs = halved(&divide(corner_arc, 0.0, along_fillet));
        let mut involute = divide(0.0, outline.tip_arc, along_involute);
        // To a fifth of rounding in the number of steps.
        let tip = 1.2 * flank / FLANK_OVER_TIP;
        while involute[involute.len() - 1] - involute[involute.len() - 2] > tip {
            let last = involute.len() - 1;
            involute.insert(last, 0.5 * (involute[last - 1] + involute[last]));
        }
        arcs.extend(&halved(&involute)[1..]);
        let width = 2.0 * corner[0] * corner[1];
        let behind = along_fillet.min(flank);
        let root = fillet.unwrap_or(sizes.root_element * module);
        let across = graded(width, behind, sizes.growth, sizes.tooth_element * module);
        let across: Vec<f64> = across.iter().rev().map(|t| 1.0 - t).collect();
        let land = corner_arc - outline.space_arc();
        Stations {
            outline,
            corner_arc,
            corner,
            arcs,
            across: halved(&across),
            rows: below_root(gear, corner[0], root, sizes.growth),
            columns: halved(&divide(0.0, land, root.min(0.5 * land))),
        }
    }

    fn bottom(&self, u: f64) -> Polar {
        let [radius, angle] = self.corner;
        let sag = 0.067 * 2.0 * radius * angle * self.outline.kappa;
        [radius - 4.0 * sag * u * (1.0 - u), angle * (2.0 * u - 1.0)]
    }

    fn down(&self, radius: f64, depth: Depth) -> f64 {
        radius + depth.t * (depth.target - radius)
    }
}

/// Places of the rows below the root, at half-element steps; the blocks meet at the radius `corner`.
fn below_root(gear: &Gear, corner: f64, first: f64, growth: f64) -> Vec<Depth> {
    let held = gear.held_radius;
    let depth = (corner - held).abs();
    let inside_rim = gear.body.map_or(held, |body| body.rim_radius);
    let height = (corner - inside_rim).abs();
    let rim = graded(height, first, growth, height);
    let row = |t| Depth {
        t,
        target: inside_rim,
        share: t * height / depth,
        width: None,
    };
    let mut rows: Vec<Depth> = halved(&rim).into_iter().map(row).collect();
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
        let stations = Stations::new(gear, outline, sizes);
        let mut section = Section::default();
        let tooth = section.tooth(&stations);
        let under = section.under_tooth(&stations, &tooth);
        let last = stations.across.len() - 1;
        let right = section.under_space(&stations, [last as i32 / 2, -1], 1.0, &under[last]);
        let left = section.under_space(&stations, [-1, -1], -1.0, &under[0]);

        let loaded = stations.arcs.iter().zip(&tooth[last]);
        section.flank = loaded.map(|(arc, node)| (*node, *arc)).collect();
        let below = stations.columns.iter().zip(&right).skip(1).rev();
        let below = below.map(|(away, column)| (column[0], stations.corner_arc - away));
        let above = section.flank.iter().copied();
        section.fillet = below
            .chain(above.take_while(|(_, arc)| *arc <= 0.0))
            .collect();
        let below = stations.rows.iter().skip(1).step_by(2);
        section.widths = below.map(|depth| depth.width).collect();
        let lowest = stations.rows.len() - 1;
        // A bore or the outside of a ring that rests on a foundation is free to move, and so is the bore of a shaft.
        let is_shaft = gear.body.is_some_and(|body| body.is_shaft());
        let free = lowest + usize::from(is_shaft || gear.foundation.is_some());
        section.sides =
            [&left, &right].map(|grid| grid[stations.columns.len() - 1][..free].to_vec());
        let columns = left.iter().chain(&under).chain(&right);
        if !is_shaft {
            section.held = columns.map(|column| column[lowest]).collect();
        }
        section.held.sort_unstable();
        section.held.dedup();
        section
    }

    fn tooth(&mut self, at: &Stations) -> Grid {
        let tip = at.outline.point(at.outline.tip_arc);
        let top = |u: f64| [tip[0], tip[1] * (2.0 * u - 1.0)];
        let height = at.outline.tip_arc - at.corner_arc;
        self.block([0, 1], at.across.len(), at.arcs.len(), |i, j| {
            let right = at.outline.point(at.arcs[j]);
            let (u, v) = (at.across[i], (at.arcs[j] - at.corner_arc) / height);
            let ends = [
                [at.bottom(0.0), at.bottom(u), at.bottom(1.0)],
                [top(0.0), top(u), top(1.0)],
            ];
            Err(transfinite(u, v, [[right[0], -right[1]], right], ends))
        })
    }

    /// Block B shares the lowest row of A.
    fn under_tooth(&mut self, at: &Stations, tooth: &Grid) -> Grid {
        self.block([0, -1], at.across.len(), at.rows.len(), |i, j| {
            if j == 0 {
                return Ok(tooth[i][0]);
            }
            let surface = at.bottom(at.across[i]);
            Err([at.down(surface[0], at.rows[j]), surface[1]])
        })
    }

    /// Block C on the `side` +1 or -1 shares the column `shared` of B; its first cell has the number `first`.
    fn under_space(&mut self, at: &Stations, first: [i32; 2], side: f64, shared: &[usize]) -> Grid {
        let land = at.corner_arc - at.outline.space_arc();
        let space = at.outline.point(at.outline.space_arc());
        self.block(first, at.columns.len(), at.rows.len(), |i, j| {
            if i == 0 {
                return Ok(shared[j]);
            }
            let w = at.columns[i] / land;
            let surface = at.outline.point(at.corner_arc - at.columns[i]);
            let depth = at.rows[j];
            let end = at.corner[1] + w * (space[1] - at.corner[1]);
            let angle = surface[1] + depth.share * (end - surface[1]);
            Err([at.down(surface[0], depth), side * angle])
        })
    }

    /// Adds a block whose first cell has the number `first`; columns and rows count on away from cell
    /// (0, 0). `point` gives the number of a node that exists or else the place of a new one; elements have no node at their centre.
    fn block(
        &mut self,
        first: [i32; 2],
        columns: usize,
        rows: usize,
        point: impl Fn(usize, usize) -> Result<usize, Polar>,
    ) -> Grid {
        let mut grid = vec![vec![usize::MAX; rows]; columns];
        for (i, column) in grid.iter_mut().enumerate() {
            for (j, number) in column.iter_mut().enumerate() {
                if i % 2 == 1 && j % 2 == 1 {
                    continue;
                }
                *number = point(i, j).unwrap_or_else(|place| {
                    self.nodes.push(place);
                    self.nodes.len() - 1
                });
            }
        }
        for i in (0..columns - 1).step_by(2) {
            for j in (0..rows - 1).step_by(2) {
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

    /// Ends along z of the part of the body to which an element with the (column, row) `cell` belongs, see [`Section::widths`].
    pub fn width(&self, cell: [i32; 2]) -> Option<[f64; 2]> {
        let row = usize::try_from(-1 - cell[1]).ok()?;
        self.widths[row]
    }

    pub fn cartesian(&self, node: usize) -> [f64; 3] {
        let [r, theta] = self.nodes[node];
        [r * theta.cos(), r * theta.sin(), 0.0]
    }

    fn signed_area(&self, quad: &[usize; 8]) -> f64 {
        (0..4)
            .map(|k| {
                let (p, q) = (self.cartesian(quad[k]), self.cartesian(quad[(k + 1) % 4]));
                0.5 * (p[0] * q[1] - p[1] * q[0])
            })
            .sum()
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
