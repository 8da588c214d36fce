//! Numbers for reading: three significant digits and a prefix before the unit.

/// Between a number and its unit, so that no line ends there; printed as a space.
pub const TIED: char = '\u{a0}';

/// Prefixes by their exponents of ten.
const PREFIXES: [(i32, &str); 9] =
    [(-12, "p"), (-9, "n"), (-6, "µ"), (-3, "m"), (0, ""), (3, "k"), (6, "M"), (9, "G"), (12, "T")];

/// Units that take a prefix; all others keep theirs.
const PREFIXED: [&str; 8] = ["s", "m", "m/s", "N", "N s", "J", "W", "Pa"];

/// Writes a quantity with three significant digits, `17.3 N` or `671 µm`.
pub fn quantity(value: f64, unit: &str) -> String {
    with_digits(value, unit, 3)
}

/// Writes a quantity with so many significant digits; zeros behind the last one are left out.
pub fn with_digits(value: f64, unit: &str, digits: usize) -> String {
    let unit = if unit == "-" { "" } else { unit };
    let join = |number: String, prefix: &str| format!("{number}{TIED}{prefix}{unit}").trim_end().to_owned();
    if value == 0.0 || !value.is_finite() {
        let number = if value == 0.0 {
            "0"
        } else if value.is_nan() {
            "not a number"
        } else {
            "infinite"
        };
        return join(number.to_owned(), "");
    }
    // Rounded first: 999.9 is 1.00 thousand.
    let rounded = format!("{value:.*e}", digits - 1);
    let Some((mantissa, Ok(exponent))) = rounded.split_once('e').map(|(m, e)| (m, e.parse::<i32>())) else {
        return join(rounded, "");
    };
    let (shift, prefix) = if PREFIXED.contains(&unit) {
        let engineering = exponent.div_euclid(3) * 3;
        match PREFIXES.iter().find(|(own, _)| *own == engineering) {
            Some((shift, prefix)) => (*shift, *prefix),
            None => return join(rounded, ""),
        }
    } else if (-4..6).contains(&exponent) {
        (0, "")
    } else {
        return join(format!("{}e{exponent}", trimmed(mantissa)), "");
    };
    let places = (digits as i32 - 1 - (exponent - shift)).max(0) as usize;
    // From the rounded text, so that nothing is rounded twice.
    let number: f64 = rounded.parse().unwrap_or(value);
    join(trimmed(&format!("{:.places$}", number / 10_f64.powi(shift))).to_owned(), prefix)
}

/// Writes how many there are of something whose plural ends in s, `1 run`, `2 runs`.
pub fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Writes a share as a percentage of three significant digits.
pub fn percent(share: f64) -> String {
    let share = 100.0 * share;
    if share > 0.0 && share < 1e-3 {
        return format!("{share:.1e}{TIED}%");
    }
    format!("{}{TIED}%", with_digits(share, "-", 3))
}

/// Leaves out zeros behind the last digit after a point.
fn trimmed(number: &str) -> &str {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_have_three_digits_and_a_prefix() {
        for (value, unit, wanted) in [
            (17.2567, "N", "17.3 N"),
            (6.714412e-4, "m", "671 µm"),
            (-8.044971e-3, "J", "-8.04 mJ"),
            (999.96, "N", "1 kN"),
            (5.884722e4, "J", "58.8 kJ"),
            (276.253, "kg", "276 kg"),
            (0.0, "J", "0 J"),
            (f64::INFINITY, "kg", "infinite kg"),
            (1.593377, "-", "1.59"),
            (5e-3, "s", "5 ms"),
            (3.2e-17, "m", "3.20e-17 m"),
            (1.25e7, "-", "1.25e7"),
        ] {
            assert_eq!(quantity(value, unit).replace(TIED, " "), wanted);
        }
        assert_eq!(with_digits(0.036261, "s", 4), "36.26\u{a0}ms");
        assert_eq!(
            [0.0171056, 3.4e-8, 0.5, 1.0].map(percent).map(|text| text.replace(TIED, "")),
            ["1.71%", "3.4e-6%", "50%", "100%"]
        );
    }
}
