//! Gears and housing at their operating temperature. The drawing is that at 20 °C.
//!
//! A gear that grows by the share epsilon in all directions moves its flank by epsilon r, whose part along the line of action is epsilon times the
//! length of roll. What both gears grow by in the mean is a larger module. By what one grows beyond it, material grows linearly towards its
//! tip, a profile slope, and its teeth get thicker: gears of different base pitches.

use super::checks::{ABOVE_0, Refusal, check, ensure, in_gear, refusal};
use super::file::{GearFile, PairFile, UM};
use gearmesh::gear::{Gear, Microgeometry, PairGeometry, PairMicrogeometry, ProfileSlope};
use gearmesh::words::{rounded, significant};

/// Temperature of the drawing (ISO 1), °C.
pub(super) const OF_DRAWING: f64 = 20.0;

/// Of the mesh, °C.
pub(super) fn temperature(file: &PairFile) -> f64 {
    file.operating.temperature_c.unwrap_or(OF_DRAWING)
}

fn check_expansion(file: &PairFile, field: &str, um: Option<f64>) -> Result<(), Refusal> {
    let Some(um) = um else { return Ok(()) };
    ensure!(file.operating.temperature_c.is_some(), field => um;
        "nothing says how warm the gears are"; "give `operating.temperature_c`, or leave it out");
    check(field, um, [0.0, 500.0])
}

/// A note on a temperature on which nothing depends, or at which some parts grow and others, of which nothing is said, do not.
pub(super) fn note(file: &PairFile) -> Option<String> {
    let celsius = file.operating.temperature_c.filter(|t| *t != OF_DRAWING)?;
    let expansions = [
        (
            "gear1.thermal_expansion_um_per_m_k",
            file.gear1.thermal_expansion_um_per_m_k,
        ),
        (
            "gear2.thermal_expansion_um_per_m_k",
            file.gear2.thermal_expansion_um_per_m_k,
        ),
        (
            "housing_thermal_expansion_um_per_m_k",
            file.housing_thermal_expansion_um_per_m_k,
        ),
    ];
    let (given, open): (Vec<_>, Vec<_>) = expansions.iter().partition(|(_, um)| um.is_some());
    let names = |fields: Vec<&(&str, Option<f64>)>| {
        let names: Vec<String> = fields.iter().map(|(name, _)| format!("`{name}`")).collect();
        names.join(" and ")
    };
    if !given.is_empty() {
        let (given, open) = (names(given), (!open.is_empty()).then(|| names(open))?);
        return Some(format!(
            "{open} = 0 assumed beside {given}: what has no expansion stays as cold as on the drawing"
        ));
    }
    let depends = [&file.gear1, &file.gear2]
        .iter()
        .any(|gear| gear.youngs_modulus_over_temperature.is_some());
    (!depends).then(|| {
        format!(
            "`operating.temperature_c` = {celsius} changes nothing: no thermal expansion is given, and no Young's modulus over the temperature"
        )
    })
}

/// Checks the fields that this module reads.
pub(super) fn check_fields(file: &PairFile) -> Result<(), Refusal> {
    if let Some(celsius) = file.operating.temperature_c {
        check("operating.temperature_c", celsius, [-100.0, 400.0])?;
    }
    let field = "housing_thermal_expansion_um_per_m_k";
    check_expansion(file, field, file.housing_thermal_expansion_um_per_m_k)?;
    for i in 0..2 {
        let gear = file.gear(i);
        let field = in_gear(i, "thermal_expansion_um_per_m_k");
        check_expansion(file, &field, gear.thermal_expansion_um_per_m_k)?;
        let Some(table) = &gear.youngs_modulus_over_temperature else {
            continue;
        };
        let field = in_gear(i, "youngs_modulus_over_temperature");
        if let Some(gpa) = gear.youngs_modulus_gpa {
            return Err(refusal!(in_gear(i, "youngs_modulus_gpa") => gpa;
                "`youngs_modulus_over_temperature` says the same"; "give only one of them"));
        }
        let ascends = table.windows(2).all(|w| w[0][0] < w[1][0]);
        ensure!(table.len() >= 2 && ascends, field => format!("{table:?}");
            "is no table over ascending temperatures"; "give at least two pairs [°C, GPa], the coldest first");
        for [_, modulus] in table {
            check(&field, *modulus, [ABOVE_0, 1e6])?;
        }
        let ends = [table[0][0], table[table.len() - 1][0]];
        let celsius = temperature(file);
        ensure!((ends[0]..=ends[1]).contains(&celsius), field => format!("{table:?}");
            "does not hold {} °C, the temperature of the gears", rounded(celsius);
            "give `operating.temperature_c` within the table, or measure farther");
    }
    Ok(())
}

/// Young's modulus of gears of which nothing is said, GPa.
const STEEL: f64 = 206.0;

/// Young's modulus of gear `g` at its temperature, GPa; linear between those of its table.
pub(super) fn youngs_modulus(file: &PairFile, g: &GearFile) -> f64 {
    // One that is too short is refused.
    let table = g
        .youngs_modulus_over_temperature
        .as_ref()
        .filter(|table| table.len() >= 2);
    let Some(table) = table else {
        return g.youngs_modulus_gpa.unwrap_or(STEEL);
    };
    let celsius = temperature(file);
    let above = table.partition_point(|[at, _]| *at <= celsius);
    let last = above.clamp(1, table.len() - 1);
    let ([t0, e0], [t1, e1]) = (table[last - 1], table[last]);
    e0 + (e1 - e0) * (celsius - t0) / (t1 - t0)
}

/// Lets gears and centre distance grow from the temperature of the drawing to that of the mesh. Face widths stay.
pub(super) fn expand(
    file: &PairFile,
    geometry: &mut PairGeometry,
    microgeometry: &mut PairMicrogeometry,
) -> Result<(), Refusal> {
    let [growth1, growth2, of_housing] = [
        file.gear1.thermal_expansion_um_per_m_k,
        file.gear2.thermal_expansion_um_per_m_k,
        file.housing_thermal_expansion_um_per_m_k,
    ]
    .map(|um| um.unwrap_or(0.0) * UM * (temperature(file) - OF_DRAWING));
    let growth = [growth1, growth2];
    if growth == [0.0; 2] && of_housing == 0.0 {
        return Ok(());
    }
    geometry.center_distance *= 1.0 + of_housing;
    let common = 0.5 * (growth[0] + growth[1]);
    for (gear, growth) in geometry.gears.iter_mut().zip(growth) {
        expand_gear(gear, growth, common);
    }
    let cos_beta_b = geometry.base_helix_angle().cos();
    for (i, growth) in growth.into_iter().enumerate() {
        let beyond = growth - common;
        let gear = &geometry.gears[i];
        let start = geometry.active_start_roll(i, geometry.center_distance);
        let rolls = [start, gear.tip_form_roll()];
        // Both flanks of a tooth at mid-profile, on the line of action.
        let thicker = gear.kappa() * beyond * (rolls[0] + rolls[1]);
        let steepness = -gear.kappa() * beyond * cos_beta_b;
        for flank in [&mut microgeometry.drive[i], &mut microgeometry.coast[i]] {
            expand_rolls(flank, common);
            if beyond != 0.0 {
                let slope = flank.profile_slope.get_or_insert(ProfileSlope {
                    amount: 0.0,
                    bias: 0.0,
                    rolls,
                });
                slope.amount += steepness * (slope.rolls[1] - slope.rolls[0]);
            }
        }
        geometry.gears[i].tooth_thinning -= thicker;
    }
    let backlash = geometry.backlash(geometry.center_distance);
    // Without backlash, gears and housing that grow alike leave a rounding.
    ensure!(backlash >= -1e-3 * UM, "operating.temperature_c" => temperature(file);
        "the warm teeth jam by {} um on the line of action", significant(-backlash / UM, 2);
        "give more backlash, or the expansion of the housing");
    Ok(())
}

/// The teeth of `gear` grow by the share `common`, its circles by `growth`.
fn expand_gear(gear: &mut Gear, growth: f64, common: f64) {
    let root = gear.root_radius() * (1.0 + growth);
    gear.normal_module *= 1.0 + common;
    gear.tooth_thinning *= 1.0 + common;
    gear.dedendum_coefficient += gear.kappa() * (gear.root_radius() - root) / gear.normal_module;
    for radius in [
        &mut gear.tip_radius,
        &mut gear.tip_chamfer,
        &mut gear.held_radius,
    ] {
        *radius *= 1.0 + growth;
    }
    gear.root_form_radius = gear.root_form_radius.map(|radius| radius * (1.0 + growth));
}

/// Places along the profile of `flank` where base circles grow by the share `common`; a topography stays as it was measured.
fn expand_rolls(flank: &mut Microgeometry, common: f64) {
    let reliefs = flank.tip_relief.iter_mut().chain(&mut flank.root_relief);
    let starts_and_ends = reliefs.flat_map(|relief| [&mut relief.start_roll, &mut relief.end_roll]);
    let crowning = flank.profile_crowning.iter_mut();
    let slope = flank.profile_slope.iter_mut();
    let of_whole = crowning
        .map(|c| &mut c.rolls)
        .chain(slope.map(|s| &mut s.rolls));
    for roll in starts_and_ends.chain(of_whole.flatten()) {
        *roll *= 1.0 + common;
    }
}

#[cfg(test)]
mod tests {
    use crate::gear::Pair;
    use crate::pair::from_json;
    use approx::assert_relative_eq;

    /// A plastic wheel on a steel pinion at `celsius`; expansions of pinion, wheel and housing, um/(m K).
    fn warm(celsius: f64, expansions: [f64; 3]) -> Result<Pair, String> {
        warm_with_backlash(120.0, celsius, expansions)
    }

    /// The same with a backlash in um.
    fn warm_with_backlash(
        backlash: f64,
        celsius: f64,
        expansions: [f64; 3],
    ) -> Result<Pair, String> {
        let [pinion, wheel, housing] = expansions;
        let text = format!(
            r#"{{"name": "plastic", "meshing": "external", "normal_module_mm": 1.0, "normal_pressure_angle_deg": 20.0,
                 "helix_angle_deg": 0.0, "backlash_um": {backlash}, "housing_thermal_expansion_um_per_m_k": {housing},
                 "gear1": {{"teeth": 20, "face_width_mm": 10.0, "thermal_expansion_um_per_m_k": {pinion}}},
                 "gear2": {{"teeth": 40, "face_width_mm": 10.0, "thermal_expansion_um_per_m_k": {wheel},
                     "youngs_modulus_over_temperature": [[-40, 3.6], [20, 3.0], [80, 1.5]], "poisson_ratio": 0.35}},
                 "operating": {{"nominal_torque_nm": 0.5, "maximum_torque_nm": 1.0, "temperature_c": {celsius},
                     "center_distance_offset_um": [-10.0, 10.0], "misalignment_mrad": [-1.0, 1.0]}}}}"#
        );
        from_json(&text).map_err(|error| error.to_string())
    }

    /// Material that grew on both flanks where they touch at `part` of the path of contact, m on the line of action.
    fn grown(pair: &Pair, part: f64) -> f64 {
        let (g, c) = (&pair.geometry, pair.geometry.center_distance);
        let path = g.path_of_contact(c);
        let xi = path.start + part * path.length();
        let removal = |i: usize| {
            let gear = &g.gears[i];
            pair.microgeometry.drive[i].removal(gear, g.roll_at(i, c, xi), 0.0)
        };
        -(removal(0) + removal(1))
    }

    #[test]
    fn gears_and_housing_that_grow_alike_mesh_as_before_but_larger() {
        let share = 60e-6 * 60.0;
        let [cold, hot] = [20.0, 80.0].map(|celsius| warm(celsius, [60.0; 3]).unwrap());
        let lengths = |pair: &Pair| {
            let (g, c) = (&pair.geometry, pair.geometry.center_distance);
            let path = g.path_of_contact(c);
            let [first, second] = &g.gears;
            let radii = [first.root_radius(), second.tip_radius, second.held_radius];
            [
                g.backlash(c),
                path.start,
                path.end,
                radii[0],
                radii[1],
                radii[2],
            ]
        };
        for (hot, cold) in lengths(&hot).into_iter().zip(lengths(&cold)) {
            assert_relative_eq!(hot, cold * (1.0 + share), max_relative = 1e-9);
        }
        assert!(hot.microgeometry.drive[0].profile_slope.is_none());
    }

    #[test]
    fn a_wheel_that_grows_alone_has_the_larger_base_pitch_and_less_backlash() {
        let share = 90e-6 * 60.0;
        let (cold, hot) = (
            warm(20.0, [0.0; 3]).unwrap(),
            warm(80.0, [0.0, 90.0, 0.0]).unwrap(),
        );
        let path = hot.geometry.path_of_contact(hot.geometry.center_distance);
        // Towards the root of the wheel, where gear 1 goes out of mesh, less of it has grown.
        let rise = (grown(&hot, 0.0) - grown(&hot, 1.0)) / path.length();
        assert_relative_eq!(rise, share, max_relative = 1e-9);
        let tips = [&cold, &hot].map(|pair| pair.geometry.gears[1].tip_radius);
        assert_relative_eq!(tips[1] / tips[0], 1.0 + share, max_relative = 1e-12);
        // Two flanks at the middle of the path; to first order in the growth, what the pressure angle changes by is of the second.
        let backlash = |pair: &Pair| pair.geometry.backlash(pair.geometry.center_distance);
        let (g, c) = (&cold.geometry, cold.geometry.center_distance);
        let path = g.path_of_contact(c);
        let closed = 2.0 * share * g.roll_at(1, c, 0.5 * (path.start + path.end));
        let left = backlash(&hot) - 2.0 * grown(&hot, 0.5);
        assert_relative_eq!(left, backlash(&cold) - closed, max_relative = 3e-2);
    }

    #[test]
    fn the_modulus_is_that_of_the_temperature_and_what_makes_no_sense_is_refused() {
        for (celsius, gpa) in [(20.0, 3.0), (50.0, 2.25), (-10.0, 3.3), (80.0, 1.5)] {
            let pair = warm(celsius, [0.0; 3]).unwrap();
            let modulus = pair.geometry.gears[1].youngs_modulus;
            assert_relative_eq!(modulus, 1e9 * gpa, max_relative = 1e-12);
        }
        for (celsius, expansions, part) in [
            (90.0, [0.0; 3], "does not hold 90 °C"),
            (1000.0, [0.0; 3], "operating.temperature_c"),
            (80.0, [-1.0, 0.0, 0.0], "gear1.thermal_expansion_um_per_m_k"),
            (80.0, [200.0, 200.0, 0.0], "the warm teeth jam"),
        ] {
            let error = warm(celsius, expansions).unwrap_err();
            assert!(error.contains(part), "{error}");
        }
    }

    #[test]
    fn warm_tips_are_checked_against_root_and_fillet_of_the_mate_as_cold_ones_are() {
        let warm = |wheel, housing| warm_with_backlash(400.0, 80.0, [110.0, wheel, housing]);
        for (wheel, part) in [
            // By hand: 11 (1 + 60 * 110e-6) + 18.75 (1 + 60 * 180e-6) = 30.025.
            (180.0, "the tip clearance to gear 2 is -0.025 mm"),
            (140.0, "tip interference"),
        ] {
            let error = warm(wheel, 0.0).unwrap_err();
            let parts = ["`operating.temperature_c` = 80", part];
            assert!(parts.iter().all(|part| error.contains(part)), "{error}");
            warm(wheel, 100.0).unwrap();
        }
    }
}
