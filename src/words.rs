//! Numbers and names as messages and listings show them.

/// `value` with ten digits: without those that a change of unit adds, and without the sign of a zero.
pub fn rounded(value: f64) -> f64 {
    // Adding 0 turns -0 into 0.
    format!("{value:.9e}").parse().unwrap_or(value) + 0.0
}

/// `value` with `digits` decimals, a zero without a sign; with an exponent where a double has no such digits.
pub fn fixed(value: f64, digits: usize) -> String {
    if value.abs() >= 1e15 {
        return format!("{value:.digits$e}");
    }
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.chars().all(|c| c == '0' || c == '.') => zero.to_owned(),
        _ => text,
    }
}

/// `value` to `digits` significant digits as tables of quantities show it: with an exponent below 0.01 and from 100 000 on.
pub fn significant(value: f64, digits: usize) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-2..1e5).contains(&size) {
        return format!("{value:.0$e}", digits - 1);
    }
    let before = if size > 0.0 {
        size.log10().floor() as i32 + 1
    } else {
        digits as i32
    };
    fixed(value, (digits as i32 - before).max(0) as usize)
}

/// `value` > 0 to `digits` significant digits, by `round` of whole numbers.
pub fn to_digits(value: f64, digits: i32, round: fn(f64) -> f64) -> f64 {
    let exponent = value.log10().floor() as i32 - digits + 1;
    // Through the decimals, so that what is written is what is meant.
    format!("{:.0}e{exponent}", round(value / 10f64.powi(exponent)))
        .parse()
        .unwrap_or(value)
}

/// A number and what it counts: `1 node`, `3 nodes`.
pub fn count(number: usize, of: &str) -> String {
    let s = if number == 1 { "" } else { "s" };
    format!("{number} {of}{s}")
}

/// Longest name or value that is repeated, in characters.
const LONGEST: usize = 300;

/// Longest row of a listing, in characters: sentences with their numbers, but no file's worth of them.
const LONGEST_ROW: usize = 3000;

/// Most digits in which a number is written out: a double needs 17, sign, point and leading zeros come to it.
const DIGITS: usize = 24;

/// Text from a file: control characters escaped, cut where it is too long for a line; a number of many digits with
/// an exponent.
pub fn shown(text: &str) -> String {
    cut(text, LONGEST)
}

/// The same for a row of a listing, which may hold whole sentences.
pub fn shown_in_full(text: &str) -> String {
    cut(text, LONGEST_ROW)
}

fn cut(text: &str, longest: usize) -> String {
    if text.len() > DIGITS
        && let Ok(number) = text.parse::<f64>()
    {
        return format!("{number:e}");
    }
    let mut out = String::new();
    for (i, c) in text.chars().enumerate() {
        if i == longest {
            out.push_str("...");
            break;
        }
        if c.is_control() {
            out.extend(c.escape_default());
        } else {
            out.push(c);
        }
    }
    out
}

/// `value` with an exponent where it had many digits or zeros without.
pub fn number(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-9 {
        return format!("{value:e}");
    }
    shown(&value.to_string())
}

/// What is wrong with JSON, and where; of an unknown field without the list of all that there are.
pub fn json_problem(error: &serde_json::Error) -> String {
    let text = error.to_string();
    match text.split_once(", expected one of ") {
        Some((problem, _)) => format!(
            "{problem} at line {} column {}",
            error.line(),
            error.column()
        ),
        None => text,
    }
}

/// `bytes` in hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_no_digits_that_a_change_of_unit_or_a_double_adds_and_zeros_no_sign() {
        for (shown, text) in [
            (rounded(60e-6 * 1e6).to_string(), "60"),
            (rounded(59.99999999999999).to_string(), "60"),
            (rounded(-0.0).to_string(), "0"),
            (rounded(82.104).to_string(), "82.104"),
            (rounded(f64::NAN).to_string(), "NaN"),
            (fixed(3.3357e305, 2), "3.34e305"),
            (fixed(-1e-9, 2), "0.00"),
            (fixed(-0.06, 1), "-0.1"),
            (fixed(0.0, 0), "0"),
            (significant(0.0, 4), "0"),
            (significant(0.25, 4), "0.2500"),
            (significant(1034.6, 4), "1035"),
            (significant(2.5e8, 4), "2.500e8"),
            (significant(-0.001, 4), "-1.000e-3"),
            (to_digits(1.2999e-6, 2, f64::floor).to_string(), "0.0000012"),
            (to_digits(1034.6, 3, f64::round).to_string(), "1030"),
            (to_digits(9.996, 3, f64::round).to_string(), "10"),
            (number(1e300), "1e300"),
            (number(-2.5e-300), "-2.5e-300"),
            (number(1e-20), "1e-20"),
            (number(0.0), "0"),
            (number(0.08210400000000001), "0.08210400000000001"),
            (count(1, "misalignment"), "1 misalignment"),
            (count(0, "node"), "0 nodes"),
        ] {
            assert_eq!(shown, text);
        }
    }

    #[test]
    fn names_are_counted_in_characters_and_move_no_cursor() {
        assert_eq!(shown("齿轮\n\u{1b}[2J"), "齿轮\\n\\u{1b}[2J");
        assert_eq!(shown(&"齿".repeat(1000)).chars().count(), LONGEST + 3);
        assert_eq!(shown(&"齿".repeat(LONGEST)).chars().count(), LONGEST);
        assert_eq!(shown_in_full(&"a".repeat(1000)).len(), 1000);
        assert_eq!(shown_in_full(&"a".repeat(9000)).len(), LONGEST_ROW + 3);
    }
}
