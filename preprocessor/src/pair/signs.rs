//! A ring in the signs of ISO 21771 and DIN 3960: negative teeth are the switch for all quantities of the gear and the centre
//! distance.

use super::checks::{Refusal, Refusals, ensure, every, in_gear};
use super::dimension::Dimension;
use super::file::{GearFile, PairFile, ReliefFile, ReliefStart};
use gearmesh::words::number;

/// A length of a file that is negative for a ring in the signs of DIN 3960.
enum Length<'a> {
    Number(&'a mut f64),
    Dimension(&'a mut Dimension),
}

impl Length<'_> {
    fn middle(&self) -> f64 {
        match self {
            Length::Number(mm) => **mm,
            Length::Dimension(mm) => mm.middle(),
        }
    }

    fn negate(&mut self) {
        match self {
            Length::Number(mm) => **mm = -**mm,
            Length::Dimension(mm) => **mm = -**mm,
        }
    }

    fn shown(&self) -> String {
        match self {
            Length::Number(mm) => mm.to_string(),
            Length::Dimension(mm) => mm.to_string(),
        }
    }
}

/// Lengths of gear `g` that have the sign of its teeth, by field.
fn lengths(g: &mut GearFile) -> Vec<(String, Length<'_>)> {
    let numbers = [
        ("tip_diameter_mm", &mut g.tip_diameter_mm),
        ("tip_form_diameter_mm", &mut g.tip_form_diameter_mm),
        ("root_form_diameter_mm", &mut g.root_form_diameter_mm),
    ];
    let dimensions = [
        ("root_diameter_mm", &mut g.root_diameter_mm),
        ("span_measurement_mm", &mut g.span_measurement_mm),
        ("dimension_over_balls_mm", &mut g.dimension_over_balls_mm),
    ];
    let [drive, coast] = [&mut g.drive_flank, &mut g.coast_flank].map(Option::as_mut);
    let mut reliefs = vec![
        ("tip_relief".to_owned(), &mut g.tip_relief),
        ("root_relief".to_owned(), &mut g.root_relief),
    ];
    for (flank, own) in [("drive_flank", drive), ("coast_flank", coast)] {
        let Some(own) = own else { continue };
        reliefs.push((format!("{flank}.tip_relief"), &mut own.tip_relief));
        reliefs.push((format!("{flank}.root_relief"), &mut own.root_relief));
    }
    let numbers = (numbers.into_iter())
        .filter_map(|(field, mm)| Some((field.to_owned(), Length::Number(mm.as_mut()?))));
    let dimensions = (dimensions.into_iter())
        .filter_map(|(field, mm)| Some((field.to_owned(), Length::Dimension(mm.as_mut()?))));
    let starts = (reliefs.into_iter())
        .filter_map(|(field, relief)| Some((format!("{field}.start"), start(relief.as_mut()?)?)));
    numbers.chain(dimensions).chain(starts).collect()
}

/// Where a relief starts, if that is a diameter or a length of roll.
fn start(relief: &mut ReliefFile) -> Option<Length<'_>> {
    match &mut relief.start {
        ReliefStart::DiameterMm(mm) | ReliefStart::RollLengthMm(mm) => Some(Length::Number(mm)),
        _ => None,
    }
}

/// The file without the signs of ISO 21771, but for that of the teeth, which names the ring: lengths are positive, and the
/// profile shift of a ring is that which widens its spaces. Lengths of a ring with negative teeth are all negative, as in DIN 3960, or all positive, as in
/// ISO 21771:2007.
///
/// # Errors
/// Negative teeth of a gear that is no ring, and lengths of both signs.
pub(super) fn without(file: &PairFile) -> Result<PairFile, Refusals> {
    let mut file = file.clone();
    let ring = file.ring();
    every((0..2).map(|i| {
        let teeth = file.gear(i).teeth;
        ensure!(teeth >= 0 || ring == Some(i), in_gear(i, "teeth") => teeth;
            "is negative, and the gear is no ring";
            "give {}; negative teeth are the sign of the ring of an internal pair in ISO 21771", teeth.unsigned_abs());
        Ok::<(), Refusal>(())
    }))?;
    let Some(ring) = ring else { return Ok(file) };
    let g = if ring == 0 {
        &mut file.gear1
    } else {
        &mut file.gear2
    };
    let (teeth, has_signs) = (g.teeth, g.teeth < 0);
    if has_signs {
        g.profile_shift = g.profile_shift.map(|x| -x);
        g.span_teeth = g.span_teeth.map(i32::abs);
        g.rim_diameter_mm = g.rim_diameter_mm.map(f64::abs);
    }
    let mut signed: Vec<(String, Length)> = (lengths(g).into_iter())
        .map(|(field, length)| (in_gear(ring, &field), length))
        .collect();
    let distance = file.center_distance_mm.as_mut();
    signed.extend(distance.map(|mm| ("center_distance_mm".to_owned(), Length::Number(mm))));
    let Some((first, is_negative, value)) =
        (signed.first()).map(|(field, mm)| (field.clone(), mm.middle() < 0.0, mm.shown()))
    else {
        return Ok(file);
    };
    every(signed.iter_mut().map(|(field, length)| {
        let (shown, sign) = (length.shown(), length.middle() < 0.0);
        if sign {
            length.negate();
        }
        ensure!(!sign || has_signs, field.clone() => shown;
            "is negative, and `{}` = {teeth} is not", in_gear(ring, "teeth");
            "give {}, or {} teeth for a ring in the signs of ISO 21771, which then hold for all its quantities and the centre \
             distance", length.shown(), -teeth);
        ensure!(sign == is_negative, field.clone() => shown;
            "has not the sign of `{first}` = {value}";
            "give all lengths of a ring with negative teeth, and the centre distance, one sign: negative as in DIN 3960, or positive \
             as in ISO 21771:2007");
        Ok::<(), Refusal>(())
    }))?;
    Ok(file)
}

/// The refusal of a `file` in the signs of ISO 21771 with its value as it is given, where it was made without them.
pub(super) fn as_given(file: &PairFile, refusal: Refusal) -> Refusal {
    let Some(ring) = file.ring().filter(|ring| file.gear(*ring).teeth < 0) else {
        return refusal;
    };
    let is_signed =
        refusal.field.starts_with(&in_gear(ring, "")) || refusal.field == "center_distance_mm";
    if !is_signed {
        return refusal;
    }
    let path = format!("/{}", refusal.field.replace('.', "/"));
    let fields = serde_json::to_value(file).unwrap_or_default();
    let given = fields.pointer(&path).and_then(serde_json::Value::as_f64);
    Refusal {
        value: given.map_or(refusal.value, number),
        remedy: format!(
            "{} (without the signs of ISO 21771 that the file has)",
            refusal.remedy
        ),
        ..refusal
    }
}
