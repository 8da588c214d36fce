//! The table of claims as Markdown, from `claims.csv`.

use rimbench_core::error::Result;
use rimbench_results::results_table::{ResultsTable, read_table};
use std::fmt::Write;
use std::path::Path;

/// Makes the Markdown table of the claims in a `claims.csv`.
///
/// # Errors
/// [`Error::File`](rimbench_core::error::Error::File) for a file or column that is not there.
pub fn claims_markdown(path: &Path) -> Result<String> {
    let claims = read_table(path)?;
    let names = ["text", "by", "quantity", "measured", "expected", "verdict", "experiment"];
    let columns: Vec<usize> = names.iter().map(|name| claims.column(name)).collect::<Result<_>>()?;
    // Results of earlier versions do not have it.
    let superseded = claims.column("superseded").ok();
    let variant_of = claims.column("variant_of").ok();
    let said = |row: usize, column: Option<usize>, of: &str| {
        let text = column.map(|column| claims.text(row, column)).filter(|text| !text.is_empty());
        text.map(|text| format!(" *({of} {text})*")).unwrap_or_default()
    };
    let mut text = String::from("| claim | by | quantity | measured | expected | verdict | experiment |\n");
    text.push_str("|---|---|---|---|---|---|---|\n");
    for row in 0..claims.len() {
        let cells = columns.iter().zip(names).map(|(&column, name)| match name {
            "measured" => significant(claims.number(row, column), 3) + &trust(&claims, row),
            "text" => {
                let more = said(row, superseded, "superseded:") + &said(row, variant_of, "variant of");
                format!("{}{more}", claims.text(row, column)).replace('|', "\\|")
            }
            "verdict" => claims.text(row, column).replace('-', " "),
            _ => claims.text(row, column).replace('|', "\\|"),
        });
        let _ = writeln!(text, "| {} |", cells.collect::<Vec<_>>().join(" | "));
    }
    Ok(text)
}

/// How far a value can be trusted, where that is known: results of earlier versions do not have it.
fn trust(claims: &ResultsTable, row: usize) -> String {
    let number = |name: &str| claims.column(name).ok().map(|column| claims.number(row, column)).filter(|x| !x.is_nan());
    let interval = number("low").zip(number("high"));
    let interval = interval
        .map_or_else(String::new, |(low, high)| format!(" [{}, {}]", significant(low, 3), significant(high, 3)));
    let without = number("without_exact")
        .map_or_else(String::new, |value| format!("; {} without exact models", significant(value, 3)));
    interval + &without
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
