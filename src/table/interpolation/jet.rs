//! Numbers with first and second derivatives by the coordinates, and what a node contributes in them.

/// Coordinates: centre distance, misalignment, displacement, mesh position.
pub const DIMENSIONS: usize = 4;
/// Pairs (i, j) with i <= j.
pub(super) const PAIRS: usize = 10;
/// Distance, in node spacings, at which a node's weight vanishes. The middle of a four-dimensional cell is 1 away
/// from its corners; half a cell beyond the edge, it is 1 again.
pub(super) const REACH: f64 = 1.75;
/// Where the second derivative by coordinates i and j stands.
pub const PAIR: [[usize; 4]; 4] = [[0, 1, 2, 3], [1, 4, 5, 6], [2, 5, 7, 8], [3, 6, 8, 9]];

/// The displacement among the coordinates.
pub(super) const U: usize = 2;

/// Value with first and second derivatives, and the derivatives of the second one by the displacement.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Jet4 {
    /// Value.
    pub value: f64,
    /// First derivatives.
    pub gradient: [f64; DIMENSIONS],
    /// Second derivatives, see [`PAIR`].
    pub second: [f64; PAIRS],
    /// Of `second[PAIR[2][2]]` by the coordinates: the stiffness has a gradient, too.
    pub third: [f64; DIMENSIONS],
}

/// A node's quadratic: value and derivatives there, by ways in spacings of the node.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Quadratic {
    pub value: f64,
    pub gradient: [f64; DIMENSIONS],
    pub second: [f64; PAIRS],
}

/// A node that reaches the point along one axis.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Near {
    /// Index in the grid.
    pub index: usize,
    /// Way from the node, in its spacings.
    pub way: f64,
    pub scale: f64,
}

/// A node as seen from the point.
pub(super) struct Place {
    pub index: [usize; DIMENSIONS],
    /// Way from the node, in its spacings, and 1 / these.
    pub way: [f64; DIMENSIONS],
    pub scale: [f64; DIMENSIONS],
}

impl Place {
    pub fn of(axes: [&Near; DIMENSIONS]) -> Self {
        Place {
            index: axes.map(|n| n.index),
            way: axes.map(|n| n.way),
            scale: axes.map(|n| n.scale),
        }
    }
}

pub(super) const ONE: Jet4 = Jet4 {
    value: 1.0,
    gradient: [0.0; DIMENSIONS],
    second: [0.0; PAIRS],
    third: [0.0; DIMENSIONS],
};

/// Calls `f(i, j)` for the second derivatives that are wanted.
#[inline(always)]
pub(super) fn pairs<const H: bool>(mut f: impl FnMut(usize, usize)) {
    if H {
        for i in 0..DIMENSIONS {
            for j in i..DIMENSIONS {
                f(i, j);
            }
        }
    } else {
        f(U, U);
    }
}

/// A node's quadratic at the point.
#[inline(always)]
pub(super) fn local<const H: bool>(q: &Quadratic, at: &Place) -> Jet4 {
    let (way, scale) = (&at.way, &at.scale);
    let mut out = Jet4 {
        value: q.value,
        ..Jet4::default()
    };
    for i in 0..DIMENSIONS {
        let bend: f64 = (0..DIMENSIONS).map(|j| q.second[PAIR[i][j]] * way[j]).sum();
        out.value += way[i] * (q.gradient[i] + 0.5 * bend);
        out.gradient[i] = (q.gradient[i] + bend) * scale[i];
    }
    pairs::<H>(|i, j| out.second[PAIR[i][j]] = q.second[PAIR[i][j]] * scale[i] * scale[j]);
    out
}

/// A function f of the distance d from a node.
pub(super) struct Radial {
    value: f64,
    /// f'.
    slope: f64,
    /// f' / d.
    across: f64,
    /// f'' - f' / d.
    along: f64,
    /// That over d.
    along_over: f64,
    /// d² times the derivative of (f'' - f' / d) / d².
    third: f64,
}

impl Radial {
    /// Over the coordinates, at the distance `d`.
    #[inline(always)]
    fn jet<const H: bool>(&self, d: f64, at: &Place) -> Jet4 {
        let scale = &at.scale;
        // At the node itself there is no direction, and nothing that is smooth there has need of one.
        let per = if d > 0.0 { 1.0 / d } else { 0.0 };
        let e = at.way.map(|w| w * per);
        let mut out = Jet4 {
            value: self.value,
            ..Jet4::default()
        };
        for i in 0..DIMENSIONS {
            out.gradient[i] = self.slope * e[i] * scale[i];
        }
        pairs::<H>(|i, j| {
            let across = if i == j { self.across } else { 0.0 };
            out.second[PAIR[i][j]] = (across + self.along * e[i] * e[j]) * scale[i] * scale[j];
        });
        if H {
            for i in 0..DIMENSIONS {
                let own = if i == U { 2.0 * e[U] } else { 0.0 };
                let sum = self.along_over * (e[i] + own) + self.third * e[i] * e[U] * e[U];
                out.third[i] = sum * scale[i] * scale[U] * scale[U];
            }
        }
        out
    }
}

/// (1/d - 1/R)³, d > 0.
#[inline(always)]
pub(super) fn weight<const H: bool>(d: f64, at: &Place) -> Jet4 {
    let per = 1.0 / d;
    let x = per - 1.0 / REACH;
    let (per2, per3) = (per * per, per * per * per);
    let radial = Radial {
        value: x * x * x,
        slope: -3.0 * x * x * per2,
        across: -3.0 * x * x * per3,
        along: x * per3 * (6.0 * per + 9.0 * x),
        along_over: x * per2 * per2 * (6.0 * per + 9.0 * x),
        third: -per2 * per2 * (6.0 * per2 + 54.0 * x * per + 45.0 * x * x),
    };
    radial.jet::<H>(d, at)
}

/// 1 / (1/d - 1/R)³, d < R.
#[inline(always)]
pub(super) fn inverse_weight<const H: bool>(d: f64, at: &Place) -> Jet4 {
    let r = 1.0 / (1.0 - d / REACH);
    let (r3, r4) = (r * r * r, r * r * r * r);
    let radial = Radial {
        value: r3 * d * d * d,
        slope: 3.0 * r4 * d * d,
        across: 3.0 * r4 * d,
        along: r4 * (12.0 * r - 9.0) * d,
        along_over: r4 * (12.0 * r - 9.0),
        third: r4 * ((60.0 * r - 108.0) * r + 45.0),
    };
    radial.jet::<H>(d, at)
}

/// Adds the product of two.
#[inline(always)]
pub(super) fn add<const H: bool>(sum: &mut Jet4, a: &Jet4, b: &Jet4) {
    sum.value += a.value * b.value;
    for i in 0..DIMENSIONS {
        sum.gradient[i] += a.gradient[i] * b.value + a.value * b.gradient[i];
    }
    pairs::<H>(|i, j| {
        let n = PAIR[i][j];
        sum.second[n] += a.second[n] * b.value
            + a.gradient[i] * b.gradient[j]
            + a.gradient[j] * b.gradient[i]
            + a.value * b.second[n];
    });
    if H {
        let uu = PAIR[U][U];
        for i in 0..DIMENSIONS {
            let iu = PAIR[i][U];
            sum.third[i] += a.third[i] * b.value
                + a.second[uu] * b.gradient[i]
                + 2.0 * (a.second[iu] * b.gradient[U] + a.gradient[U] * b.second[iu])
                + a.gradient[i] * b.second[uu]
                + a.value * b.third[i];
        }
    }
}

/// a / b.
#[inline(always)]
pub(super) fn quotient<const H: bool>(a: &Jet4, b: &Jet4) -> Jet4 {
    let per = 1.0 / b.value;
    let mut out = Jet4 {
        value: a.value * per,
        ..Jet4::default()
    };
    for i in 0..DIMENSIONS {
        out.gradient[i] = (a.gradient[i] - out.value * b.gradient[i]) * per;
    }
    pairs::<H>(|i, j| {
        let n = PAIR[i][j];
        out.second[n] = (a.second[n]
            - out.value * b.second[n]
            - out.gradient[i] * b.gradient[j]
            - out.gradient[j] * b.gradient[i])
            * per;
    });
    if H {
        let uu = PAIR[U][U];
        for i in 0..DIMENSIONS {
            let iu = PAIR[i][U];
            out.third[i] = (a.third[i]
                - out.second[uu] * b.gradient[i]
                - 2.0 * (out.second[iu] * b.gradient[U] + out.gradient[U] * b.second[iu])
                - out.gradient[i] * b.second[uu]
                - out.value * b.third[i])
                * per;
        }
    }
    out
}
