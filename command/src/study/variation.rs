//! What a study varies: fields of the pair file and the load, on a grid or drawn within an interval.

use gearmesh::gear::tolerance;
use gearmesh::pair::Pair;
use gearmesh::random::Random;
use gearmesh::words::rounded;
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
    /// Values from `low` to `high` on a grid; None: drawn evenly between them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<usize>,
}

/// `FIELD=LOW..HIGH`, `FIELD=+-TOLERANCE` or `FIELD,FIELD=LOW..HIGH/POINTS` of the command line.
#[derive(Debug, Clone, PartialEq)]
pub struct Requested {
    variation: Variation,
    /// Whether the ends are those about the value in the pair file.
    is_tolerance: bool,
}

impl Requested {
    pub fn parse(text: &str) -> Result<Requested, String> {
        Requested::of(text).ok_or_else(|| {
            format!(
                "`{text}`: give FIELD=LOW..HIGH, FIELD=+-TOLERANCE or FIELD=LOW..HIGH/POINTS with 2 to 1000 points, such as \
                 gear1.lead_slope_um=+-8, misalignment_mrad=-0.5..0.5 or gear1.lead_crowning_um=0..10/11"
            )
        })
    }

    fn of(text: &str) -> Option<Requested> {
        let number = |text: &str| limits::finite(text).ok();
        let (fields, range) = text.split_once('=')?;
        let field = fields.replace(' ', "");
        let mut points = None;
        let tolerance = range.strip_prefix("+-").or(range.strip_prefix('±'));
        let [low, high] = if let Some(tolerance) = tolerance {
            let high = number(tolerance)?.abs();
            [-high, high]
        } else {
            let (low, mut high) = range.split_once("..")?;
            if let Some((end, count)) = high.split_once('/') {
                high = end;
                let count = count.trim().parse().ok();
                points = Some(count.filter(|n| (2..=1000).contains(n))?);
            }
            [number(low)?, number(high)?]
        };
        // Fields that share a value are those of a grid.
        let is_named = field.split(',').all(|field| !field.is_empty())
            && (!field.contains(',') || points.is_some());
        (is_named && low <= high).then_some(Requested {
            variation: Variation::new(field, [low, high], points),
            is_tolerance: tolerance.is_some(),
        })
    }
}

impl Variation {
    fn new(field: String, [low, high]: [f64; 2], points: Option<usize>) -> Variation {
        Variation {
            field,
            low,
            high,
            points,
        }
    }

    pub fn fields(&self) -> impl Iterator<Item = &str> {
        self.field.split(',')
    }

    pub fn value(&self, i: usize) -> f64 {
        let steps = self.points.map_or(1, |points| points - 1) as f64;
        rounded(self.low + (self.high - self.low) * i as f64 / steps)
    }
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct Plan {
    pub grid: Vec<Variation>,
    /// Drawn within intervals; about a point of the grid where the field is on it, too.
    pub drawn: Vec<Variation>,
    /// Every varied field once, with its value as drawn.
    pub fields: Vec<(String, f64)>,
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
            let about = as_drawn(&r.variation.field) * f64::from(u8::from(r.is_tolerance));
            plan.add(r.variation.clone(), about)?;
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
        let all = match variation.points {
            Some(_) => &mut self.grid,
            None => &mut self.drawn,
        };
        let is_known = |field: &&str| all.iter().any(|v| v.fields().any(|known| known == *field));
        if let Some(twice) = variation.fields().find(is_known) {
            refuse!("`{twice}` is varied twice; leave one out");
        }
        let ends = [variation.low, variation.high];
        [variation.low, variation.high] = ends.map(|end| rounded(about + end));
        all.push(variation);
        Ok(())
    }

    pub fn all(&self) -> impl Iterator<Item = &Variation> {
        self.grid.iter().chain(&self.drawn)
    }

    pub fn is_varied(&self, field: &str) -> bool {
        self.fields.iter().any(|(varied, _)| varied == field)
    }

    /// Number of points of the grid; 0 where there is none.
    pub fn points(&self) -> usize {
        let points = self.grid.iter().filter_map(|axis| axis.points);
        points.reduce(usize::saturating_mul).unwrap_or(0)
    }

    /// Number of the value of each axis of the grid at `point`, from 1.
    pub fn indices(&self, point: usize) -> Vec<usize> {
        let mut rest = point - 1;
        let index = |points: usize| {
            let i = rest % points;
            rest /= points;
            i
        };
        let points = self.grid.iter().filter_map(|axis| axis.points);
        points.map(index).collect()
    }

    /// Values of the fields at `point` of the grid (0: as drawn) of sample `number` (0: the point itself), the same in every run.
    pub fn values(&self, point: usize, number: usize, seed: u64) -> Vec<f64> {
        let mut values: Vec<f64> = self.fields.iter().map(|(_, drawn)| *drawn).collect();
        let index = |field: &str| self.fields.iter().position(|(known, _)| known == field);
        if point > 0 {
            for (axis, i) in self.grid.iter().zip(self.indices(point)) {
                for k in axis.fields().filter_map(index) {
                    values[k] = axis.value(i);
                }
            }
        }
        if number > 0 {
            for (variation, value) in self.drawn.iter().zip(draw(&self.drawn, seed, number)) {
                if let Some(k) = index(&variation.field) {
                    values[k] = rounded(value + (values[k] - self.fields[k].1));
                }
            }
        }
        values
    }
}

/// The values of sample `number` (from 1): the same whichever samples were drawn before.
fn draw(variations: &[Variation], seed: u64, number: usize) -> Vec<f64> {
    // Bits all over for neighbouring numbers and seeds (splitmix64, Steele, Lea, Flood, OOPSLA 2014).
    let mix = |mut x: u64| {
        x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        x ^ (x >> 31)
    };
    let mut random = Random::new(mix(mix(seed) ^ number as u64).max(1));
    let value = |v: &Variation| rounded(random.within([v.low, v.high]));
    variations.iter().map(value).collect()
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
            assert_eq!(found.is_tolerance, is_tolerance);
        }
        let wrong = "a|a=1|a=2..1|a=x..1|=1..2|a=+-nan|a=0..inf|a=0..1/1|a,b=0..1|a,=0..1/3";
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
            grid: vec![
                axis("a,b", [0.0, 2.0], Some(3)),
                axis("c", [5.0, 6.0], Some(2)),
            ],
            drawn: vec![axis("a", [9.0, 11.0], None)],
            fields: [("a", 10.0), ("b", 20.0), ("c", 0.0)]
                .map(|(f, v)| (f.into(), v))
                .into(),
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
}
