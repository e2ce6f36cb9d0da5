//! What a study varies: fields of the pair file and the load, on a grid or drawn within an interval.

use std::collections::HashSet;

use gearmesh::random::Random;
use gearmesh::words::rounded;
use gearmesh_preprocessor::gear::Pair;
use gearmesh_preprocessor::gear::tolerance;
use gearmesh_preprocessor::pair::PairDraft;
use serde::Serialize;

use crate::error::Result;
use crate::limits;

/// A varied field with the ends of its values.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Variation {
    /// Path in the pair file, or torque_nm, misalignment_mrad or center_distance_offset_um; on a grid also several with commas
    /// between them, which share a value.
    pub field: String,
    pub low: f64,
    pub high: f64,
    /// Values from `low` to `high` on a grid; None: drawn evenly between them, or optimized.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<usize>,
    /// Whether the optimizer chooses the values.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub optimized: bool,
}

/// `FIELD`, `FIELD=LOW..HIGH`, `FIELD=+-TOLERANCE`, `FIELD,FIELD=LOW..HIGH/POINTS` or `FIELD,FIELD=LOW..HIGH/optimize` of the command line.
#[derive(Debug, Clone, PartialEq)]
pub struct Requested {
    variation: Variation,
    ends: Ends,
}

/// What the ends of a variation are.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Ends {
    Values,
    /// Counted from the value in the pair file.
    Tolerance,
    /// The limits that the pair file has.
    OfFile,
}

impl Requested {
    pub fn parse(text: &str) -> Result<Requested, String> {
        Requested::of(text).ok_or_else(|| {
            format!(
                "`{text}`: give FIELD=LOW..HIGH, FIELD=+-TOLERANCE, FIELD alone for the limits of the file, FIELD=LOW..HIGH/POINTS with 2 to 1000 points or \
                 FIELD=LOW..HIGH/optimize, such as gear1.lead_slope_um=+-8, misalignment_mrad=-0.5..0.5, \
                 gear1.lead_crowning_um=0..10/11 or gear1.tip_relief.amount_um=0..40/optimize"
            )
        })
    }

    fn of(text: &str) -> Option<Requested> {
        let Some((fields, range)) = text.split_once('=') else {
            let is_field = !text.is_empty() && !text.contains([',', ' ']);
            return is_field.then(|| Requested {
                variation: Variation::new(text.into(), [f64::NAN; 2], None),
                ends: Ends::OfFile,
            });
        };
        let field = fields.replace(' ', "");
        let (mut points, mut optimized) = (None, false);
        let tolerance = range.strip_prefix("+-").or(range.strip_prefix('±'));
        let [low, high] = if let Some(tolerance) = tolerance {
            let high = limits::finite(tolerance).ok()?.abs();
            [-high, high]
        } else {
            let (low, mut high) = range.split_once("..")?;
            if let Some((end, count)) = high.split_once('/') {
                high = end;
                optimized = count.trim() == "optimize";
                if !optimized {
                    let count = count.trim().parse().ok();
                    points = Some(count.filter(|n| (2..=1000).contains(n))?);
                }
            }
            [limits::finite(low).ok()?, limits::finite(high).ok()?]
        };
        // Drawn fields share no value.
        let is_named = field.split(',').all(|field| !field.is_empty())
            && (!field.contains(',') || points.is_some() || optimized);
        let is_range = low < high || (low == high && !optimized);
        (is_named && is_range).then_some(Requested {
            variation: Variation {
                optimized,
                ..Variation::new(field, [low, high], points)
            },
            ends: tolerance.map_or(Ends::Values, |_| Ends::Tolerance),
        })
    }
}

/// Fields that say how thick teeth are, or what backlash they leave.
const THICKNESSES: [&str; 5] = [
    "normal_tooth_thickness_mm",
    "span_measurement_mm",
    "dimension_over_balls_mm",
    "backlash_um",
    "normal_backlash_um",
];

impl Variation {
    fn new(field: String, [low, high]: [f64; 2], points: Option<usize>) -> Variation {
        Variation {
            field,
            low,
            high,
            points,
            optimized: false,
        }
    }

    /// Whether it changes the thickness of teeth, so that every value has its own elastic model.
    pub fn is_thickness(&self) -> bool {
        self.fields().all(|field| {
            let name = field.rsplit('.').next().unwrap_or(field);
            THICKNESSES.contains(&name)
        })
    }

    fn is_drawn(&self) -> bool {
        self.points.is_none() && !self.optimized
    }

    pub fn fields(&self) -> impl Iterator<Item = &str> {
        self.field.split(',')
    }

    /// The field in a listing: what both gears share stands once.
    pub fn label(&self) -> String {
        let parts: Vec<_> = self.fields().map(|field| field.split_once('.')).collect();
        let tails = parts.iter().map(|part| part.map(|(_, tail)| tail));
        let tails: HashSet<_> = tails.collect();
        match parts[..] {
            [Some((_, tail)), ..] if tails.len() == 1 && self.field.contains(',') => {
                let gears: Vec<&str> = parts.iter().flatten().map(|(gear, _)| *gear).collect();
                format!("{tail} of {}", gears.join(", "))
            }
            _ => self.field.replace(',', ", "),
        }
    }

    pub fn value(&self, i: usize) -> f64 {
        let steps = self.points.map_or(1, |points| points - 1) as f64;
        rounded(self.low + (self.high - self.low) * i as f64 / steps)
    }

    /// The values on the grid, none where there is no grid.
    pub fn nodes(&self) -> Vec<f64> {
        let all = 0..self.points.unwrap_or(0);
        all.map(|i| self.value(i)).collect()
    }

    /// The value at this share of the range, with no more decimals than a thousandth of the range has.
    pub fn at_share(&self, share: f64) -> f64 {
        let range = self.high - self.low;
        let step = 10_f64.powf((1e-3 * range).log10().floor());
        let value = ((self.low + range * share) / step).round() * step;
        rounded(value.clamp(self.low, self.high))
    }
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct Plan {
    /// What tells the points apart: all on a grid, or all optimized.
    pub axes: Vec<Variation>,
    /// Drawn within intervals; about a point where the field is on an axis, too.
    pub drawn: Vec<Variation>,
    /// Every varied field once, with its value as drawn.
    pub fields: Vec<(String, f64)>,
    /// Of each point that the optimizer tried its values of the axes.
    pub tried: Vec<Vec<f64>>,
}

impl Plan {
    /// The requested variations, about `torque` (N m) and the values of `draft`, and the slopes of both gears' flanks within the
    /// tolerance class `class` of ISO 1328-1, if there is one. A field that is varied twice is refused, and none at all.
    pub fn new(
        requested: &[Requested],
        class: Option<u8>,
        draft: &PairDraft,
        pair: &Pair,
        torque: f64,
    ) -> Result<Plan> {
        let mut plan = Plan::default();
        let as_drawn = |field: &str| match field {
            "torque_nm" => torque,
            _ => draft.number(field).unwrap_or(0.0),
        };
        for r in requested {
            let (mut variation, mut about) = (r.variation.clone(), 0.0);
            let field = &r.variation.field;
            match r.ends {
                Ends::Values => {}
                Ends::Tolerance => about = as_drawn(field),
                Ends::OfFile => {
                    let Some(limits) = draft.limits(field) else {
                        refuse!(
                            "--vary {field}: the pair file has no limits of it; give them there as [lower, upper], or here as \
                             {field}=LOW..HIGH"
                        );
                    };
                    [variation.low, variation.high] = limits;
                }
            }
            plan.add(variation, about)?;
        }
        if plan.is_optimized()
            && let Some(axis) = plan.axes.iter().find(|axis| !axis.optimized)
        {
            refuse!(
                "--vary {}: on a grid beside fields to optimize; give all of them POINTS, or /optimize",
                axis.field
            );
        }
        for (i, gear) in pair.geometry.gears.iter().enumerate() {
            let Some(class) = class else { break };
            // What the loaded flank has of its own takes precedence over what both flanks have.
            for (name, tolerance) in [
                ("profile_slope_um", tolerance::profile_slope(gear, class)),
                ("lead_slope_um", tolerance::helix_slope(gear, class)),
            ] {
                let own = format!("gear{}.drive_flank.{name}", i + 1);
                let both = format!("gear{}.{name}", i + 1);
                let field = draft.number(&own).map_or(both, |_| own);
                let about = as_drawn(&field);
                let ends = [-1e6 * tolerance, 1e6 * tolerance];
                plan.add(Variation::new(field, ends, None), about)?;
            }
        }
        let varied: Vec<Variation> = plan.all().cloned().collect();
        for field in varied.iter().flat_map(Variation::fields) {
            if !plan.is_varied(field) {
                plan.fields.push((field.into(), as_drawn(field)));
            }
        }
        if plan.fields.is_empty() {
            refuse!("nothing is varied: name fields with --vary, or a class with --iso-1328-class");
        }
        Ok(plan)
    }

    /// Adds `variation` with its ends counted from `about`.
    fn add(&mut self, mut variation: Variation, about: f64) -> Result<()> {
        let all = match variation.is_drawn() {
            false => &mut self.axes,
            true => &mut self.drawn,
        };
        if let Some(twice) = variation
            .fields()
            .find(|field| all.iter().any(|v| v.fields().any(|known| known == *field)))
        {
            refuse!("`{twice}` is varied twice; leave one out");
        }
        let ends = [variation.low, variation.high];
        [variation.low, variation.high] = ends.map(|end| rounded(about + end));
        all.push(variation);
        Ok(())
    }

    pub fn all(&self) -> impl Iterator<Item = &Variation> {
        self.axes.iter().chain(&self.drawn)
    }

    pub fn is_varied(&self, field: &str) -> bool {
        self.fields.iter().any(|(varied, _)| varied == field)
    }

    pub fn is_on_axis(&self, field: &str) -> bool {
        let mut axes = self.axes.iter();
        axes.any(|axis| axis.fields().any(|own| own == field))
    }

    pub fn is_optimized(&self) -> bool {
        self.axes.iter().any(|axis| axis.optimized)
    }

    /// Number of points, of the grid or tried so far; 0 where there is no axis.
    pub fn points(&self) -> usize {
        if self.is_optimized() {
            return self.tried.len();
        }
        let points = self.axes.iter().filter_map(|axis| axis.points);
        points.reduce(usize::saturating_mul).unwrap_or(0)
    }

    /// Number of the value of each axis of the grid at `point`, from 1.
    pub fn indices(&self, point: usize) -> Vec<usize> {
        let mut rest = point - 1;
        let points = self.axes.iter().filter_map(|axis| axis.points);
        points
            .map(|points| {
                let i = rest % points;
                rest /= points;
                i
            })
            .collect()
    }

    /// The value of each axis at `point`, from 1.
    pub fn at(&self, point: usize) -> Vec<f64> {
        if self.is_optimized() {
            return self.tried[point - 1].clone();
        }
        let axes = self.axes.iter().zip(self.indices(point));
        axes.map(|(axis, i)| axis.value(i)).collect()
    }

    /// The value of each axis where the fields have `values`.
    pub fn axes_of(&self, values: &[f64]) -> Vec<f64> {
        self.axes
            .iter()
            .map(|axis| {
                let mut fields = self.fields.iter().zip(values);
                let own = fields.find(|((field, _), _)| axis.fields().any(|f| f == field));
                own.map_or(f64::NAN, |(_, value)| *value)
            })
            .collect()
    }

    /// Values of the fields where the axes have `values`, the rest as drawn.
    pub fn placed(&self, values: &[f64]) -> Vec<f64> {
        self.fields
            .iter()
            .map(|(field, drawn)| {
                let mut axes = self.axes.iter().zip(values);
                axes.find(|(axis, _)| axis.fields().any(|f| f == field))
                    .map_or(*drawn, |(_, value)| *value)
            })
            .collect()
    }

    /// Values of the fields at `point` (0: as drawn) of sample `number` (0: the point itself), the same in every run.
    pub fn values(&self, point: usize, number: usize, seed: u64) -> Vec<f64> {
        let mut values = match point {
            0 => self.placed(&[]),
            point => self.placed(&self.at(point)),
        };
        if number > 0 {
            for (variation, value) in self.drawn.iter().zip(draw(&self.drawn, seed, number)) {
                let index = (self.fields.iter()).position(|(known, _)| *known == variation.field);
                if let Some(k) = index {
                    values[k] = rounded(value + (values[k] - self.fields[k].1));
                }
            }
        }
        values
    }

    /// Lowest and highest value of `field`, 0 included, over all that is varied.
    pub fn range(&self, field: &str) -> [f64; 2] {
        let varied = self.all().filter(|v| v.fields().any(|f| f == field));
        varied.fold([0.0; 2], |[low, high], v| {
            [low.min(v.low), high.max(v.high)]
        })
    }
}

/// Bits all over for neighbouring numbers (splitmix64, Steele, Lea, Flood, OOPSLA 2014).
fn mixed(number: u64) -> u64 {
    let mut x = number.wrapping_add(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

/// The values of sample `number` (from 1): the same whichever samples were drawn before.
fn draw(variations: &[Variation], seed: u64, number: usize) -> Vec<f64> {
    let mut random = Random::new(mixed(mixed(seed) ^ number as u64).max(1));
    variations
        .iter()
        .map(|v| rounded(random.within([v.low, v.high])))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_tolerances_and_grids_are_read_and_anything_else_is_refused() {
        for (text, ends, is_tolerance, points) in [
            ("a.b_um=-1..2", [-1.0, 2.0], false, None),
            ("a=+-8", [-8.0, 8.0], true, None),
            ("a=±0.5", [-0.5, 0.5], true, None),
            ("a, b=1..3/5", [1.0, 3.0], false, Some(5)),
        ] {
            let found = Requested::of(text).unwrap();
            let Variation { low, high, .. } = found.variation;
            assert_eq!(([low, high], found.variation.points), (ends, points));
            assert_eq!(found.ends == Ends::Tolerance, is_tolerance);
            assert!(!found.variation.optimized);
        }
        for (field, label) in [
            ("gear1.a_um", "gear1.a_um"),
            ("gear1.a.b_um,gear2.a.b_um", "a.b_um of gear1, gear2"),
            ("gear1.a,gear2.b", "gear1.a, gear2.b"),
        ] {
            let found = Requested::of(&format!("{field}=0..1/2")).unwrap();
            assert_eq!(found.variation.label(), label);
        }
        let optimized = Requested::of("a,b=0..9/optimize").unwrap().variation;
        assert!(optimized.optimized && optimized.points.is_none() && !optimized.is_drawn());
        assert_eq!(Requested::of("gear1.a_mm").unwrap().ends, Ends::OfFile);
        let wrong = "|a,b|a b|a=1|a=2..1|a=x..1|=1..2|a=+-nan|a=0..inf|a=0..1/1|a,b=0..1|a,=0..1/3|a=0..1/optimise|a=2..2/optimize|a=+-2/optimize";
        for wrong in wrong.split('|') {
            assert!(Requested::of(wrong).is_none(), "{wrong}");
        }
    }

    #[test]
    fn samples_stay_in_their_intervals_fill_them_and_do_not_depend_on_their_order() {
        let drawn = |field: &str, ends| Variation::new(field.into(), ends, None);
        let variations = [drawn("a", [-2.0, 6.0]), drawn("b", [0.0, 1.0])];
        let samples: Vec<Vec<f64>> = (1..=2000).map(|n| draw(&variations, 7, n)).collect();
        let mean = |k: usize| samples.iter().map(|s| s[k]).sum::<f64>() / 2000.0;
        assert!((mean(0) - 2.0).abs() < 0.2 && (mean(1) - 0.5).abs() < 0.03);
        assert!(samples.iter().all(|s| (-2.0..=6.0).contains(&s[0])));
        let both: f64 = samples.iter().map(|s| (s[0] - 2.0) * (s[1] - 0.5)).sum();
        assert!((both / 2000.0 / (8.0 * 1.0 / 12.0)).abs() < 0.1);
        assert_eq!(draw(&variations, 7, 1234), samples[1233]);
        assert_ne!(draw(&variations, 8, 1234), samples[1233]);
    }

    #[test]
    fn a_grid_has_every_combination_once_and_tolerances_lie_about_each_of_its_points() {
        let axis = |field: &str, ends, points| Variation::new(field.into(), ends, points);
        let plan = Plan {
            axes: vec![
                axis("a,b", [0.0, 2.0], Some(3)),
                axis("c", [5.0, 6.0], Some(2)),
            ],
            drawn: vec![axis("a", [9.0, 11.0], None)],
            fields: [("a", 10.0), ("b", 20.0), ("c", 0.0)]
                .map(|(f, v)| (f.into(), v))
                .into(),
            tried: vec![],
        };
        let all: Vec<Vec<f64>> = (1..=plan.points()).map(|p| plan.values(p, 0, 1)).collect();
        let expected = [5.0, 6.0]
            .map(|c| [0.0, 1.0, 2.0].map(|a| vec![a, a, c]))
            .concat();
        assert_eq!(all, expected);
        assert_eq!(plan.values(0, 0, 1), [10.0, 20.0, 0.0]);
        let [drawn, moved] = [0, 3].map(|point| plan.values(point, 4, 1));
        assert!((drawn[0] - 10.0).abs() <= 1.0 && drawn[0] != 10.0);
        assert!((moved[0] - 2.0 - (drawn[0] - 10.0)).abs() < 1e-9);
        assert_eq!(moved[1..], [2.0, 5.0]);
    }

    #[test]
    fn optimized_values_reach_both_ends_in_steps_of_a_thousandth_of_their_range_at_most() {
        let range = |ends| Variation::new("a".into(), ends, None);
        for ([low, high], step) in [
            ([0.0, 60.0], 0.01),
            ([-3.0, 4.0], 0.001),
            ([151.0, 153.5], 0.001),
        ] {
            let range = range([low, high]);
            assert_eq!([0.0, 1.0].map(|share| range.at_share(share)), [low, high]);
            let values = (0..=7000).map(|i| range.at_share(f64::from(i) / 7000.0));
            let values: Vec<f64> = values.collect();
            let gaps = values.windows(2).map(|w| w[1] - w[0]);
            assert!(gaps.fold(0.0, f64::max) < 1.001 * (high - low) / 1000.0);
            assert!(
                values
                    .iter()
                    .all(|v| ((v / step).round() - v / step).abs() < 1e-6)
            );
        }
    }
}
