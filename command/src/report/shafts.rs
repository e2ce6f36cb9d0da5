//! Shafts on their bearings: drawn, bent, and what they do to the contact in both senses of the torque.

use gearmesh::gear::Flank;
use gearmesh_preprocessor::contact::{CycleInput, LoadCase};
use gearmesh_preprocessor::gear::{Pair, Shaft};
use gearmesh_preprocessor::shaft::{ShaftState, misalignment_range};
use gearmesh_preprocessor::static_contact::ContactError;

use super::sections::{Loads, POSITIONS};
use crate::case::{Case, Variant, bearing_columns, bearings, torque_in_words};
use crate::columns::table;
use crate::page::{Curve, Figure, Height, Section, Style, charts};

const TORQUE: &str = "torque on gear 1 (N m)";
const FLANKS: [(Flank, &str); 2] = [(Flank::Drive, "drive flank"), (Flank::Coast, "coast flank")];

/// The section on the shafts of `pair`; None without any.
pub fn section(
    pair: &Pair,
    variant: &Variant,
    loads: &Loads,
) -> Result<Option<Section>, ContactError> {
    let Variant::Pair(solver, shafts, _) = variant else {
        return Ok(None);
    };
    if shafts.iter().all(Option::is_none) {
        return Ok(None);
    }
    let mut torques = loads.survey.clone();
    torques.push(loads.nominal);
    let matrix = LoadCase::matrix(&torques, &[0.0]);
    let mut solved = Vec::new();
    for (flank, name) in FLANKS {
        let input = CycleInput {
            flank,
            center_distance_offset: 0.0,
            positions: POSITIONS,
        };
        let mut cases = Case::solve_all((solver, shafts), None, &input, &matrix, &|_| {})?;
        let nominal = cases.split_off(loads.survey.len());
        solved.push((name, cases, nominal));
    }
    let mut figures = drawing(pair);
    figures.extend(deflections(pair, &solved));
    figures.extend(over_torque(pair, &solved));
    let torque = torque_in_words(loads.nominal);
    let mut text = String::new();
    for (name, _, nominal) in &solved {
        if let Some(state) = nominal[0].shafts.as_ref() {
            let rows = bearings(pair, state);
            text += &format!(
                "Bearings at {torque}, {name}\n{}\n",
                table(&bearing_columns(), rows)
            );
        }
    }
    let maximum = pair.operating.maximum_torque;
    if let Some(range) = misalignment_range(&pair.geometry, &pair.shafts, maximum) {
        let [low, high] = range.map(|m| 1e3 * m);
        text +=
            &format!("Misalignment that tables of this pair need: {low:.2} to {high:.2} mrad\n");
    }
    let note = format!(
        "Shafts as Timoshenko beams on their bearings, in equilibrium with the contact; all of this page is with them. Means over the mesh \
         cycle, deflections at {torque}. Drive, solid: gear 1 turns in its + sense and drives; coast, dashed: the other sense of the torque. The tables of \
         the FMU end at the gears: there the multibody model has shafts and bearings. Forces of the housing on the shaft: x from gear \
         1 to gear 2, y across it, z along the axes."
    );
    Ok(Some(
        Section::new("Shafts and bearings", note, figures).with_text(text),
    ))
}

type Solved<'a> = (&'a str, Vec<Case>, Vec<Case>);

/// Both shafts in their plane, to scale: sections, gears, bearings and where the torques enter.
fn drawing(pair: &Pair) -> Vec<Figure> {
    let g = &pair.geometry;
    let (mut curves, mut torques) = (Vec::new(), Vec::new());
    for (i, shaft) in pair.shafts.iter().enumerate() {
        let gear = &g.gears[i];
        // Gear 2 above gear 1, or inside of it.
        let axis = if i == 0 { 0.0 } else { 1e3 * g.center_distance };
        let z = |own: f64| 1e3 * (own + gear.face_offset);
        let ([low, high], r) = ([0.0, gear.face_width].map(z), 1e3 * gear.tip_radius);
        let corners = [(low, -r), (high, -r), (high, r), (low, r), (low, -r)];
        curves.push(Curve::new(
            format!("gear {}", i + 1),
            corners.map(|(x, y)| (x, axis + y)),
        ));
        let Some(shaft) = shaft else { continue };
        curves.push(Curve::new(
            format!("shaft {}", i + 1),
            profile(shaft)
                .into_iter()
                .map(|(own, r)| (z(own), axis + 1e3 * r)),
        ));
        let half = 0.02 * (shaft.section_ends()[shaft.sections.len()] - shaft.start);
        let marks = shaft.bearings.iter().flat_map(|bearing| {
            let [_, radius] = shaft.radii_at(bearing.z);
            // A triangle under the shaft, and back along its surface.
            let (tip, foot) = (-radius, -radius - 2.0 * half);
            [(0.0, tip), (-half, foot), (half, foot), (0.0, tip)]
                .map(|(x, r)| (z(bearing.z + x), axis + 1e3 * r))
        });
        curves.push(Curve::new(format!("bearings {}", i + 1), marks));
        let ends = shaft.section_ends();
        let end = ends[if shaft.torque_at_upper_end {
            ends.len() - 1
        } else {
            0
        }];
        torques.push((z(end), axis));
    }
    curves.push(Curve {
        style: Style::Dots,
        ..Curve::new("torque enters", torques)
    });
    charts! { "Shafts and bearings to scale", ["z (mm)", "mm"], Height::ToScale => curves; }
}

/// Half outline of `shaft` and its mirror image: (z, radius), m.
fn profile(shaft: &Shaft) -> Vec<(f64, f64)> {
    let ends = shaft.section_ends();
    let mut upper = vec![(ends[0], 0.0)];
    for (section, ends) in shaft.sections.iter().zip(ends.windows(2)) {
        upper.extend([(ends[0], section.radii[1]), (ends[1], section.radii[1])]);
    }
    upper.push((ends[ends.len() - 1], 0.0));
    let lower = upper.iter().rev().map(|(z, r)| (*z, -r));
    let lower: Vec<_> = lower.collect();
    upper.extend(lower);
    upper
}

/// `curve` dashed where it is that of the other sense of the torque, in the colour of its mate.
fn of_flank(curve: Curve, flank: &str) -> Curve {
    match flank == FLANKS[0].1 {
        true => curve,
        false => Curve {
            style: Style::Dashed(flank.into()),
            ..curve
        },
    }
}

/// The axes in the plane of action, and what the shafts close along the face, at the nominal torque.
fn deflections(pair: &Pair, solved: &[Solved]) -> Vec<Figure> {
    let g = &pair.geometry;
    let phi = g.operating_pressure_angle(g.center_distance);
    let mut axes = Vec::new();
    let mut closings = Vec::new();
    for ((name, _, nominal), (flank, _)) in solved.iter().zip(FLANKS) {
        let Some(state) = &nominal[0].shafts else {
            continue;
        };
        let along = [g.e() * phi.sin(), flank.sign() * g.sc() * phi.cos()];
        for (i, axis) in state
            .axes
            .iter()
            .enumerate()
            .filter(|(_, axis)| !axis.is_empty())
        {
            let offset = g.gears[i].face_offset;
            let points = axis.iter().map(|(z, at)| {
                let moved: f64 = along.iter().zip(at.linear).map(|(n, u)| n * u).sum();
                (1e3 * (z + offset), 1e6 * moved)
            });
            axes.push(of_flank(
                Curve::new(format!("axis {}", i + 1), points),
                name,
            ));
        }
        for (label, values) in [("together", &state.closing), ("torsion", &state.torsion)] {
            let points = state.z.iter().zip(values).map(|(z, v)| (1e3 * z, 1e6 * v));
            closings.push(of_flank(Curve::new(label, points), name));
        }
    }
    charts! {
        "Deflection of the axes in the plane of action", ["z (mm)", "along the force on gear 2 (um)"], Height::Curves(0.1) => axes;
        "What the shafts close along the face", ["z (mm)", "closing over mid-face (um)"], Height::Curves(0.1) => closings;
    }
}

/// A curve for each flank: `value` over the torque.
fn flanks(solved: &[Solved], value: impl Fn(&Case, &ShaftState) -> f64) -> Vec<Curve> {
    let curves = solved.iter().map(|(name, cases, _)| {
        let points = cases
            .iter()
            .filter_map(|case| Some((case.load.torque, value(case, case.shafts.as_ref()?))));
        Curve::new(*name, points)
    });
    curves.collect()
}

fn over_torque(pair: &Pair, solved: &[Solved]) -> Vec<Figure> {
    let mut radial = [vec![], vec![]];
    for (i, shaft) in pair.shafts.iter().enumerate() {
        let count = shaft.as_ref().map_or(0, |shaft| shaft.bearings.len());
        for k in 0..count {
            let forces = flanks(solved, |_, state| {
                let [x, y, _] = state.bearings[i][k].linear;
                x.hypot(y)
            });
            for (curve, all) in forces.into_iter().zip(&mut radial) {
                let label = format!("gear {} bearing {}", i + 1, k + 1);
                let flank = curve.label.clone();
                all.push(of_flank(Curve { label, ..curve }, &flank));
            }
        }
    }
    charts! {
        "K_Hbeta over torque", [TORQUE, "K_Hbeta"], Height::Curves(0.1)
            => flanks(solved, |case, _| case.face_load.face_load_factor());
        "Misalignment by the shafts over torque", [TORQUE, "misalignment (mrad)"], Height::Curves(0.01)
            => flanks(solved, |_, state| 1e3 * state.misalignment);
        "Radial forces on the bearings", [TORQUE, "radial force (N)"], Height::FromZero(0.0) => radial.concat();
    }
}
