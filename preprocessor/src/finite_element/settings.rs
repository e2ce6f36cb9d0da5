//! What the caller chooses: level of refinement, plane strain or solid, kernel width; and lengths divided by sizes of the mesh.

use crate::gear::{Pair, Refinement};

/// Sizes of the mesh and of the load kernel, all in normal modules.
///
/// [`Discretization::of`] gives those of a level of refinement; studies vary single ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Discretization {
    /// Elements along the loaded flank and first elements behind it.
    pub flank_element: f64,
    /// Growth of the elements behind the flank and towards the held surface.
    pub growth: f64,
    /// Largest element inside the tooth.
    pub tooth_element: f64,
    /// First element below the root circle.
    pub root_element: f64,
    /// Layers in the middle of the face; in wider faces than 15 modules they grow with the face width.
    pub layer: f64,
    /// Outermost layers.
    pub end_layer: f64,
    /// Half-width of the kernel that spreads a line load over the flank.
    pub kernel_half_width: f64,
    /// Elements along the fillet where root stress is asked for; None: as flank and root.
    pub fillet_element: Option<f64>,
    /// Elements along the involute where a wide kernel lets them be longer; None: as the flank.
    pub involute_element: Option<f64>,
    /// Depth below the root, in pitches there, from which on few elements stand for a pitch; infinite: none.
    pub fine_depth: f64,
}

/// What neighbouring teeth alone feel has faded to a hundredth there. Measured at level normal on three pairs: the mean transmission error
/// changes by 1e-5, its peak-to-peak by 3e-5 to 6e-5; at a depth of 0.5 by 1e-4 to 2e-4 and 3e-4 to 4e-4.
const FINE_DEPTH: f64 = 0.7;

impl Discretization {
    /// Sizes of a level of refinement.
    pub fn of(refinement: Refinement) -> Discretization {
        let normal = Discretization {
            flank_element: 0.12,
            growth: 1.4,
            tooth_element: 0.45,
            root_element: 0.25,
            layer: 0.75,
            end_layer: 0.3,
            kernel_half_width: 0.15,
            fillet_element: None,
            involute_element: None,
            fine_depth: FINE_DEPTH,
        };
        // The kernel must be resolved: 1.25 elements in its half-width keep the sum of bulk and Hertz
        // within 0.1 % of a ten times finer mesh; see docs.
        let scaled = |by: f64, kernel: f64| Discretization {
            flank_element: by * normal.flank_element,
            growth: normal.growth.powf(by),
            tooth_element: by * normal.tooth_element,
            root_element: by * normal.root_element,
            layer: by * normal.layer,
            end_layer: by * normal.end_layer,
            kernel_half_width: kernel,
            ..normal
        };
        match refinement {
            Refinement::Coarse => scaled(5.0 / 3.0, 0.25),
            Refinement::Normal => normal,
            // Two and a half times the elements and five times the work of normal.
            Refinement::Fine => scaled(0.75, 0.12),
        }
    }
}

/// Half-width of the kernel over that of the widest contact: the kernel's reference length, 0.29 of its
/// half-width, then exceeds that of the contact, and the local contact adds to the bulk.
const KERNEL_OVER_HERTZ: f64 = 4.0;

/// Widest kernel in normal modules: up to it the sum of bulk and local contact does not depend on the width
/// by more than 0.2 %.
const WIDEST_KERNEL: f64 = 0.35;

/// Half-width of a wide kernel over the elements along the involute: at 1.75 the transmission error of a wide pair changes by 1e-4.
const KERNEL_OVER_INVOLUTE_ELEMENT: f64 = 1.75;

/// Outermost layers of helical pairs over those in the middle of the face: their contact lines run over tip edges away from the ends,
/// too. Measured on pairs 20/20 of 25 and 30 degrees with faces of 5 modules, whose tips bear: the peak-to-peak transmission error is
/// too large by 0.016 and 0.027 um instead of 0.032 and 0.044 um.
const HELICAL_END_LAYER: f64 = 0.8;

/// How a compliance is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Mesh and kernel.
    pub discretization: Discretization,
    /// Axial displacement held everywhere: independent transverse slices.
    pub plane_strain: bool,
    /// Largest difference of tooth numbers among segments that bear load at the same time.
    pub reach: usize,
    /// Share of the memory that is left which a model may take; less than 1 beside another.
    pub memory_share: f64,
}

impl Settings {
    /// Solid model for `pair` at its refinement: reach for every tooth that can bear load together with
    /// another, and a load kernel wide enough for the widest Hertz contact of the pair's loads and
    /// misalignments.
    pub fn for_pair(pair: &Pair) -> Settings {
        let geometry = &pair.geometry;
        // Tip corners are followed for half a path of contact beyond either end; the path is longest at the
        // smallest centre distance. Half a pitch more for a centre distance outside the stated range.
        let nearest = geometry.center_distance + pair.operating.center_distance_offset[0].min(0.0);
        let ratio = 2.0 * geometry.transverse_contact_ratio(nearest) + geometry.overlap_ratio();
        let mut settings = Settings::new(pair.refinement, (ratio.max(1.0) + 0.5).ceil() as usize);
        let sizes = &mut settings.discretization;
        let module = geometry.gears[0].normal_module;
        let wide = (KERNEL_OVER_HERTZ * pair.largest_half_width() / module).min(WIDEST_KERNEL);
        sizes.kernel_half_width = sizes.kernel_half_width.max(wide);
        let involute = sizes.kernel_half_width / KERNEL_OVER_INVOLUTE_ELEMENT;
        sizes.involute_element = (involute > sizes.flank_element).then_some(involute);
        if geometry.gears[0].helix_angle != 0.0 {
            sizes.end_layer = HELICAL_END_LAYER * sizes.layer;
        }
        settings
    }

    /// Solid model at `refinement` for contact on up to `reach` + 1 neighbouring teeth.
    pub fn new(refinement: Refinement, reach: usize) -> Settings {
        Settings {
            discretization: Discretization::of(refinement),
            plane_strain: false,
            reach,
            memory_share: 1.0,
        }
    }
}

/// `from` to `to` in equal steps of about `size`.
pub fn divide(from: f64, to: f64, size: f64) -> Vec<f64> {
    let steps = (((to - from).abs() / size).round() as usize).max(1);
    // The last station exactly: rounding must not put it on the other side of a corner.
    let inner = (0..steps).map(|i| from + (to - from) * i as f64 / steps as f64);
    inner.chain([to]).collect()
}

/// Fractions 0 to 1 of `length`, starting with steps of `first` that grow by `growth` up to
/// `largest`; at least two steps.
pub fn graded(length: f64, first: f64, growth: f64, largest: f64) -> Vec<f64> {
    let mut ends = vec![0.0];
    let mut step = first;
    let mut reached = 0.0;
    while reached < length - 0.4 * step || ends.len() < 3 {
        reached += step;
        ends.push(reached);
        step = (step * growth).min(largest);
    }
    ends.iter().map(|x| x / reached).collect()
}

/// Fractions 0 to 1 of `length`, with steps that start from `first` at both ends, grow by `growth` up to `largest` and
/// meet; at least two steps. Seen from the other end they are the same.
pub fn graded_from_both(length: f64, first: [f64; 2], growth: f64, largest: f64) -> Vec<f64> {
    if first[0] == first[1] {
        let half = match 0.5 * length {
            short if short <= 1.4 * first[0] => vec![0.0, 1.0],
            long => graded(long, first[0], growth, largest),
        };
        let up = half.iter().map(|t| 0.5 * t);
        let down = half.iter().rev().skip(1).map(|t| 1.0 - 0.5 * t);
        return up.chain(down).collect();
    }
    let mut next = first.map(|step| step.min(largest));
    let mut steps = [Vec::new(), Vec::new()];
    let mut reached = 0.0;
    loop {
        // The finer end goes ahead, of two that are alike the one that began finer.
        let side = usize::from(next[1] < next[0] || (next[1] == next[0] && first[1] < first[0]));
        let count = steps[0].len() + steps[1].len();
        let short = reached < length - 0.4 * next[side];
        if count >= 2 && !short {
            break;
        }
        reached += next[side];
        steps[side].push(next[side]);
        next[side] = (next[side] * growth).min(largest);
    }
    let [low, high] = steps;
    let all = low.into_iter().chain(high.into_iter().rev());
    let mut sum = 0.0;
    let inner = all.map(|step| {
        sum += step / reached;
        sum
    });
    let mut ends: Vec<f64> = [0.0].into_iter().chain(inner).collect();
    ends.pop();
    ends.push(1.0);
    ends
}

/// The same stations with the middle of each step put in between.
pub fn halved(stations: &[f64]) -> Vec<f64> {
    let steps = stations.windows(2);
    let halves = steps.flat_map(|w| [0.5 * (w[0] + w[1]), w[1]]);
    [stations[0]].into_iter().chain(halves).collect()
}
