//! The table of claims as Markdown.

use rimbench_results::claims::CheckedClaim;
use std::fmt::Write;

/// Makes the Markdown table of claims.
pub fn claims_markdown(claims: &[CheckedClaim]) -> String {
    let mut text = String::from("| claim | by | measured | expected | verdict | experiment |\n");
    text.push_str("|---|---|---|---|---|---|\n");
    for claim in claims {
        // The reason is in claims.csv.
        let mut more = if claim.superseded.is_empty() { String::new() } else { " *(superseded)*".to_owned() };
        if !claim.variant_of.is_empty() {
            let _ = write!(more, " *(variant of {})*", claim.variant_of);
        }
        let measured = shown(claim, claim.measured.unwrap_or(f64::NAN), 3) + &trust(claim);
        let [by, verdict] = [claim.by.to_string(), claim.verdict.to_string()];
        let cells = [&(claim.text.clone() + &more), &by, &measured, &claim.expected, &verdict];
        let cells = cells.map(|cell| cell.replace('|', "\\|")).join(" | ");
        let _ = writeln!(text, "| {cells} | {} |", claim.experiment);
    }
    text
}

/// How far a value can be trusted, where that is known.
fn trust(claim: &CheckedClaim) -> String {
    let known = |value: Option<f64>| value.filter(|value| !value.is_nan());
    let interval = known(claim.low)
        .zip(known(claim.high))
        .map_or_else(String::new, |(low, high)| format!(" [{}, {}]", shown(claim, low, 3), shown(claim, high, 3)));
    let without = known(claim.without_exact).map(|value| format!("; {} without exact models", shown(claim, value, 3)));
    interval + &without.unwrap_or_default()
}

/// A value of a claim beside its bound, with so many significant digits or as many as tell them apart.
pub(crate) fn shown(claim: &CheckedClaim, value: f64, digits: usize) -> String {
    significant(value, claim.digits(value, digits))
}

/// So many significant digits, for reading; the CSV holds all of them.
pub(crate) fn significant(value: f64, digits: usize) -> String {
    if value.is_nan() {
        "–".to_owned()
    } else if value.is_infinite() {
        "∞".to_owned()
    } else if value == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e5).contains(&value.abs()) {
        // Rounding may carry into a new digit: 9.96 has two digits as 10, not as 10.0.
        let rounded: f64 = format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
        let decimals = (digits as i32 - 1 - rounded.abs().log10().floor() as i32).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.*e}", digits - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_for_reading() {
        for (value, text) in [
            (0.0, "0"),
            (19.5678, "19.6"),
            (0.0416, "0.0416"),
            (1.0, "1.00"),
            (2.5e-6, "2.50e-6"),
            (f64::INFINITY, "∞"),
        ] {
            assert_eq!(significant(value, 3), text);
        }
        assert_eq!(significant(f64::NAN, 3), "–");
        assert_eq!(significant(1234.5, 3), "1234");
    }
}
