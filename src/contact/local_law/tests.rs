//! Laws against pressures cell by cell, closed forms, and their own derivatives.

use super::*;
use approx::{assert_abs_diff_eq, assert_relative_eq};

const STEEL: f64 = (1.0 - 0.09) / 206e9;
const C: f64 = 4.0 * STEEL / PI;
const RADIUS: f64 = 8e-3;
const REFERENCE: f64 = 0.3e-3;
const LENGTH: f64 = 0.6e-3;
const NO_RELIEF: (f64, f64, f64, f64) = (1.0, 1.0, 0.0, 0.0);

fn law_with(profile: &GapProfile, reference_lengths: [f64; 2], corner: Corner) -> LocalContact {
    let plane_compliance = STEEL;
    let body = LocalBody {
        plane_compliance,
        corner,
    };
    LocalContact::new(&[body; 2], reference_lengths, profile, LENGTH)
}

fn law(profile: &GapProfile) -> LocalContact {
    law_with(profile, [REFERENCE; 2], Corner::NONE)
}

fn corner() -> Corner {
    Corner::new(2.1, STEEL, 0.05e-3)
}

fn far() -> GapProfile {
    GapProfile::parabola(0.0, RADIUS.recip(), [-1.0, 1.0])
}

/// A tip edge `distance` before the closest point, at which the gap has the slope `slope`.
fn near_edge(slope: f64, distance: f64) -> GapProfile {
    GapProfile::parabola(slope, RADIUS.recip(), [-distance, 1.0])
}

/// Slope jumps as those of short strong reliefs, parabolas as those of short ones.
fn relieved() -> [GapProfile; 4] {
    let new = |slope: f64, reliefs| GapProfile::relieved(slope, RADIUS.recip(), reliefs);
    [
        new(0.0, [(0.05e-3, 1.0, 0.012, 0.0), NO_RELIEF]),
        new(-0.006, [(0.0, 1.0, 0.012, 0.0), NO_RELIEF]),
        new(
            0.0,
            [(0.02e-3, 1.0, 0.006, 0.0), (-0.1e-3, -1.0, 0.01, 0.0)],
        ),
        new(
            0.0,
            [(0.06e-3, 1.0, 0.0, 60.0), (-0.08e-3, -1.0, 0.004, 30.0)],
        ),
    ]
}

/// Far from everything, near a tip edge, at one, dug in by it, and with reliefs without and with an edge.
fn profiles() -> Vec<GapProfile> {
    let mut cut_off = relieved()[2];
    cut_off.edges[0] = -0.035e-3;
    let edges = [(0.0, 0.035e-3), (0.0, 0.0), (0.02, 0.0)];
    let edges = edges.map(|(slope, distance)| near_edge(slope, distance));
    [far(), cut_off]
        .into_iter()
        .chain(edges)
        .chain(relieved())
        .collect()
}

/// Line load, root mean square spread and largest value of the pressure at the penetration `x` (m), by pressures that are
/// constant on `n` cells within `range` and fulfil the conditions of contact in their middles.
fn by_cells(profile: &GapProfile, x: f64, range: [f64; 2], n: usize) -> [f64; 3] {
    let h = (range[1] - range[0]) / n as f64;
    let at = |i: usize| range[0] + (i as f64 + 0.5) * h;
    // Integral of ln(L / abs(t)) from -inf on, so that a cell is a difference.
    let primitive = |t: f64| t * (REFERENCE.ln() - t.abs().ln() + 1.0);
    let mut touches = vec![true; n];
    loop {
        let on: Vec<usize> = (0..n).filter(|&i| touches[i]).collect();
        let matrix = nalgebra::DMatrix::from_fn(on.len(), on.len(), |r, s| {
            let t = at(on[r]) - at(on[s]);
            C * (primitive(t + 0.5 * h) - primitive(t - 0.5 * h))
        });
        let right = nalgebra::DVector::from_fn(on.len(), |r, _| x - profile.gap(at(on[r])));
        let pressure = matrix.lu().solve(&right).unwrap();
        let pulls: Vec<usize> = (0..on.len()).filter(|&r| pressure[r] < 0.0).collect();
        if pulls.is_empty() {
            let load: f64 = pressure.iter().sum::<f64>() * h;
            let mean = |power: i32, from: f64| {
                let moments = pressure.iter().zip(&on);
                moments
                    .map(|(p, &i)| p * h * (at(i) - from).powi(power))
                    .sum::<f64>()
                    / load
            };
            let spread = (mean(2, mean(1, 0.0)) + h * h / 12.0).sqrt();
            return [load, spread, pressure.max()];
        }
        // Those that pull least may press once others are open.
        let most = pulls.iter().map(|&r| pressure[r]).fold(0.0, f64::min);
        let open = pulls.iter().filter(|&&r| pressure[r] <= 0.3 * most);
        open.for_each(|&r| touches[on[r]] = false);
    }
}

#[test]
fn load_and_spread_are_those_of_pressures_cell_by_cell() {
    for profile in profiles() {
        let law = law(&profile);
        for x in [2e-6, 4e-6] {
            let range = [f64::max(-0.3e-3, profile.edges[0]), 0.3e-3];
            let [load, spread, _] = by_cells(&profile, x, range, 300);
            let found = law.line_load(x).load;
            assert_relative_eq!(found, load, max_relative = 3e-3);
            if let Some(pressure) = law.pressure(found) {
                let half_width = 2.0 / PI * found / pressure;
                assert_relative_eq!(half_width, 2.0 * spread, max_relative = 1e-2);
            }
        }
    }
}

/// With s the distance from the edge the pressure is sqrt((a - s) / s) (alpha + (s + a / 2) / R) / (pi c) (Johnson).
#[test]
fn contact_that_an_edge_cuts_off_is_that_of_a_punch_with_one_sharp_end() {
    for corner in [Corner::NONE, corner()] {
        for slope in [0.02, 1e-3, 0.0] {
            let law = law_with(&near_edge(slope, 0.0), [REFERENCE; 2], corner);
            for a in [0.1e-3, 0.25e-3, 0.4e-3] {
                let bend = a / RADIUS;
                let (of_slope, of_curvature) =
                    (0.5 * (slope + 0.5 * bend) * a / C, 0.125 * a * bend / C);
                let sum = C + corner.softness;
                let log_end = C * (REFERENCE * 4.0).ln() + corner.softness * f64::ln(0.1e-3);
                let log_end = match corner.softness > 0.0 {
                    true => log_end / sum,
                    false => (REFERENCE * 4.0).ln(),
                };
                let log = log_end - a.ln();
                let x = sum * (of_slope * (log + 1.0) + of_curvature * (log - 0.5));
                let found = law.line_load(x);
                assert_relative_eq!(found.load, of_slope + of_curvature, max_relative = 2e-3);
                assert_relative_eq!(found.slope, (sum * log).recip(), max_relative = 2e-2);
            }
        }
    }
}

#[test]
fn inside_the_flanks_the_law_is_that_of_hertz() {
    let law = law_with(&far(), [1.2e-3, 2.0e-3], Corner::NONE);
    for w in [1e-3, 1.0, 1e3, 1e5, 5e5] {
        let b = (8.0 * w * RADIUS * STEEL / PI).sqrt();
        let each = [1.2e-3, 2.0e-3].map(|l: f64| 0.5 * C * w * ((2.0 * l / b).ln() + 0.5));
        let found = law.line_load(each[0] + each[1]).load;
        assert_relative_eq!(found, w, max_relative = 1e-13);
    }
    // p = sqrt(w E* / (pi R)), 1/E* = 2 (1 - nu^2) / E.
    let p = (1e5 / (2.0 * STEEL) / (PI * RADIUS)).sqrt();
    assert_relative_eq!(law.pressure(1e5).unwrap(), p, max_relative = 1e-13);
    assert!(!law.has_edge(0.0) && !law.has_relief(0.0));
}

#[test]
fn the_inverse_satisfies_its_equation_all_over_the_range() {
    for i in 0..20_000 {
        let t = 1.1 + 60.0 * f64::from(i) / 20_000.0;
        let [v] = inverse([t]);
        let error = (v - v.ln() - t) / (1.0 - v.recip());
        assert!(error.abs() < 1e-13 * v, "{t}: {v} {error}");
    }
}

#[test]
fn slope_and_energy_are_derivative_and_integral_of_the_load_without_jumps() {
    for profile in profiles() {
        let law = law_with(&profile, [0.3e-3, 0.4e-3], corner());
        for x in [1e-8, 1e-6, 5e-6, 2e-5, 1e-4, 1e-3] {
            let d = 1e-4 * x;
            let [below, here, above] = [x - d, x, x + d].map(|x| law.line_load(x));
            let by_energy = (above.energy - below.energy) / (2.0 * d);
            assert_relative_eq!(here.load, by_energy, max_relative = 1e-6);
            let by_load = (above.load - below.load) / (2.0 * d);
            assert_relative_eq!(here.slope, by_load, max_relative = 1e-5);
        }
        assert_eq!(law.line_load(-1e-6), LineLoad::default());
        for at in (0..=NODES)
            .map(|i| law.contact(i).penetration)
            .filter(|x| *x > 0.0)
        {
            let [below, above] = [1.0 - 1e-9, 1.0 + 1e-9].map(|near| law.line_load(near * at));
            assert_relative_eq!(below.load, above.load, max_relative = 1e-7);
            assert_relative_eq!(below.slope, above.slope, max_relative = 1e-7);
            assert_relative_eq!(below.energy, above.energy, max_relative = 1e-7);
        }
    }
}

#[test]
fn between_its_contacts_the_law_is_that_of_the_width_in_between() {
    for profile in relieved() {
        let law = law(&profile);
        let (least, last) = (law.hertz_end.half_width, law.contact(NODES).at);
        let mut m = 0.0f64;
        for step in 1..200 {
            let a = least + (law.widest - least) * f64::from(step) / 200.0;
            m = profile.middle(a, m);
            let means = profile.means(m, a);
            let load = means.by_log_width / C;
            let found = law.line_load(means.gap + load * law.flat_punch(a));
            assert_abs_diff_eq!(found.load, load, epsilon = 1e-3 * last.load);
            let exact = law.flat_punch(a).recip();
            assert_abs_diff_eq!(found.slope, exact, epsilon = 2e-2 * last.slope);
        }
    }
}

#[test]
fn an_edge_behind_the_start_of_a_relief_is_reached_later() {
    let mut profile = relieved()[0];
    let [far, near] = [-1.0, -0.12e-3].map(|edge| {
        profile.edges[0] = edge;
        law(&profile)
    });
    assert_eq!(far.load_at_edge(), f64::INFINITY);
    let w = near.load_at_edge();
    assert!(w > near.contact(0).at.load && w < near.contact(NODES).at.load);
    // Past it the one without an edge carries more at the same penetration.
    let mut contacts = (0..=NODES).map(|i| near.contact(i));
    let reached = contacts.find(|contact| contact.at.load > w).unwrap();
    let [without, with] = [&far, &near].map(|law| law.line_load(2.0 * reached.penetration));
    assert!(without.load > with.load);
}

#[test]
fn the_pressure_is_that_of_a_kink_rounded_over_one_to_one_and_a_quarter_half_widths() {
    let relieved = |reliefs| GapProfile::relieved(0.0, RADIUS.recip(), reliefs);
    for (at, slope) in [(0.05e-3, 0.012), (0.02e-3, 0.003), (0.0, 0.006)] {
        let sharp = law(&relieved([(at, 1.0, slope, 0.0), NO_RELIEF]));
        let w = 400e3;
        let half_width = (2.0 * C * RADIUS * w).sqrt();
        // A parabola in place of the kink, over `share` of the half-width; its pressure under w.
        let rounded = |share: f64| {
            let length = share * half_width;
            let bend = slope / length;
            let [from, to] = [at - 0.5 * length, at + 0.5 * length];
            let profile = relieved([(from, 1.0, 0.0, bend), (to, 1.0, 0.0, -bend)]);
            let [load, _, pressure] = by_cells(&profile, 4e-6, [-0.35e-3, 0.35e-3], 350);
            pressure / sharp.pressure(load).unwrap()
        };
        let [narrow, wide] = [0.9, 1.3].map(rounded);
        assert!(narrow > 1.0 && wide < 1.0, "{at} {slope}: {narrow} {wide}");
    }
}

#[test]
fn overload_is_judged_on_the_pressure_that_is_reported() {
    let most = 0.15 / (4.0 * STEEL);
    let steep = [(0.0, 1.0, 0.2, 0.0), NO_RELIEF];
    let steep = GapProfile::relieved(-0.1, RADIUS.recip(), steep);
    let laws = [far(), steep].map(|profile| law_with(&profile, [0.6e-3; 2], Corner::NONE));
    let mut judged = [0; 2];
    for step in 1..200 {
        let w = 40.0 * f64::from(step) / LENGTH;
        let pressures = laws.each_ref().map(|law| law.pressure(w).unwrap());
        for (law, pressure) in laws.iter().zip(pressures) {
            assert_eq!(law.overload(w), (pressure > most).then_some(pressure));
            judged[usize::from(pressure > most)] += 1;
        }
        // The parabola alone would carry it.
        assert!(pressures[1] > pressures[0]);
    }
    assert!(judged.into_iter().all(|count| count > 20), "{judged:?}");
}
