//! What a study varies: fields of the pair file and the load, each within an interval.

use std::str::FromStr;

use gearmesh::gear::tolerance;
use gearmesh::pair::Pair;
use gearmesh::random::Random;
use gearmesh::words::rounded;
use gearmesh_preprocessor::pair::PairDraft;
use serde::Serialize;

use crate::Error;
use crate::limits;

/// `FIELD=LOW..HIGH` or `FIELD=+-TOLERANCE` of the command line.
#[derive(Debug, Clone, PartialEq)]
pub struct Requested {
    field: String,
    range: Range,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Range {
    Between([f64; 2]),
    About(f64),
}

impl FromStr for Requested {
    type Err = String;

    fn from_str(text: &str) -> Result<Requested, String> {
        let wrong = || {
            format!(
                "`{text}`: give FIELD=LOW..HIGH or FIELD=+-TOLERANCE, such as gear1.lead_slope_um=+-8 or \
                 misalignment_mrad=-0.5..0.5"
            )
        };
        let (field, range) = text.split_once('=').ok_or_else(wrong)?;
        let number = |text: &str| limits::finite(text).map_err(|_| wrong());
        let tolerance = range.strip_prefix("+-").or(range.strip_prefix('±'));
        let range = match (tolerance, range.split_once("..")) {
            (Some(tolerance), _) => Range::About(number(tolerance)?.abs()),
            (None, Some((low, high))) => Range::Between([number(low)?, number(high)?]),
            (None, None) => return Err(wrong()),
        };
        match range {
            Range::Between([low, high]) if low > high => Err(wrong()),
            _ if field.trim().is_empty() => Err(wrong()),
            range => Ok(Requested {
                field: field.trim().into(),
                range,
            }),
        }
    }
}

/// One varied field and the interval in which its value is drawn, evenly.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Variation {
    /// Path in the pair file, or where the contact is solved: torque_nm, misalignment_mrad or center_distance_offset_um.
    pub field: String,
    pub low: f64,
    pub high: f64,
}

impl Variation {
    /// The variations asked for, about `torque` (N m) and the values of `draft`, and the slopes of both gears' flanks within the
    /// tolerance class `class` of ISO 1328-1, if there is one.
    ///
    /// # Errors
    /// A field that is varied twice.
    pub fn all(
        requested: &[Requested],
        class: Option<u8>,
        draft: &PairDraft,
        pair: &Pair,
        torque: f64,
    ) -> Result<Vec<Variation>, Error> {
        let mut all = Vec::new();
        let about = |field: &str, tolerance: f64| {
            let middle = match field {
                "torque_nm" => torque,
                _ => draft.number(field).unwrap_or(0.0),
            };
            [middle - tolerance, middle + tolerance]
        };
        let mut add = |field: String, [low, high]: [f64; 2]| -> Result<(), Error> {
            if all.iter().any(|v: &Variation| v.field == field) {
                return Err(format!("`{field}` is varied twice; leave one out").into());
            }
            all.push(Variation {
                field,
                low: rounded(low),
                high: rounded(high),
            });
            Ok(())
        };
        for request in requested {
            let range = match request.range {
                Range::Between(range) => range,
                Range::About(tolerance) => about(&request.field, tolerance),
            };
            add(request.field.clone(), range)?;
        }
        for (i, gear) in pair.geometry.gears.iter().enumerate() {
            let Some(class) = class else { break };
            // What the loaded flank has of its own takes precedence over what both flanks have.
            for (name, tolerance) in [
                ("profile_slope_um", tolerance::profile_slope(gear, class)),
                ("lead_slope_um", tolerance::helix_slope(gear, class)),
            ] {
                let own = format!("gear{}.drive_flank.{name}", i + 1);
                let field = match draft.number(&own) {
                    Some(_) => own,
                    None => format!("gear{}.{name}", i + 1),
                };
                let range = about(&field, 1e6 * tolerance);
                add(field, range)?;
            }
        }
        if all.is_empty() {
            return Err(
                "nothing is varied: name fields with --vary, or a class with --iso-1328-class"
                    .into(),
            );
        }
        Ok(all)
    }
}

/// The values of sample `number` (from 1) of the study with the seed `seed`: the same in every run, whichever
/// samples were drawn before.
pub fn draw(variations: &[Variation], seed: u64, number: usize) -> Vec<f64> {
    // Bits all over for neighbouring numbers and seeds (splitmix64, Steele, Lea, Flood, OOPSLA 2014).
    let mix = |mut x: u64| {
        x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        x ^ (x >> 31)
    };
    let mut random = Random::new(mix(mix(seed) ^ number as u64).max(1));
    variations
        .iter()
        .map(|v| rounded(random.within([v.low, v.high])))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_and_tolerances_are_read_and_anything_else_is_refused() {
        let of = |text: &str| text.parse::<Requested>();
        assert_eq!(
            of("a.b_um=-1..2").unwrap().range,
            Range::Between([-1.0, 2.0])
        );
        assert_eq!(of("a=+-8").unwrap().range, Range::About(8.0));
        assert_eq!(of("a=±0.5").unwrap().range, Range::About(0.5));
        for wrong in [
            "a", "a=1", "a=2..1", "a=x..1", "=1..2", "a=+-nan", "a=0..inf",
        ] {
            assert!(of(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn samples_stay_in_their_intervals_fill_them_and_do_not_depend_on_their_order() {
        let variations = [("a", -2.0, 6.0), ("b", 0.0, 1.0)].map(|(field, low, high)| Variation {
            field: field.into(),
            low,
            high,
        });
        let samples: Vec<Vec<f64>> = (1..=2000).map(|n| draw(&variations, 7, n)).collect();
        let mean = |k: usize| samples.iter().map(|s| s[k]).sum::<f64>() / 2000.0;
        assert!((mean(0) - 2.0).abs() < 0.2 && (mean(1) - 0.5).abs() < 0.03);
        assert!(samples.iter().all(|s| (-2.0..=6.0).contains(&s[0])));
        let both: f64 = samples.iter().map(|s| (s[0] - 2.0) * (s[1] - 0.5)).sum();
        assert!((both / 2000.0 / (8.0 * 1.0 / 12.0)).abs() < 0.1);
        assert_eq!(draw(&variations, 7, 1234), samples[1233]);
        assert_ne!(draw(&variations, 8, 1234), samples[1233]);
    }
}
