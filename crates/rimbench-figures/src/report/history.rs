//! The program's own performance: what was, what is, and the revisions in between.

use crate::days::day_of;
use crate::vector::escaped;
use rimbench_results::results_table::{ResultsTable, read_table};
use std::fmt::Write;
use std::path::Path;

/// The section of what a folder of results records; empty where it records nothing.
pub(super) fn sections(folder: &Path) -> String {
    read_table(&folder.join("perf/history.csv")).ok().and_then(|history| performance(&history)).unwrap_or_default()
}

/// A change of this many percent of instructions is worth a row; less comes and goes with the compiler.
const SIGNIFICANT: f64 = 1.0;

/// One row per benchmark that changed: from the first record to the last, with a line through all. Times of several sessions and
/// machines are not comparable, and are not shown.
fn performance(history: &ResultsTable) -> Option<String> {
    let of = |name: &str| history.column(name).ok();
    let (record, revision, benchmark) = (of("record")?, of("git_revision")?, of("benchmark")?);
    let instructions = of("instructions")?;
    let mut names: Vec<&str> = Vec::new();
    let recorded = of("recorded_at_unix_s");
    let mut records: Vec<(&str, &str, String)> = Vec::new();
    for row in 0..history.len() {
        let name = history.text(row, benchmark);
        if !names.contains(&name) {
            names.push(name);
        }
        let own = history.text(row, record);
        if !records.iter().any(|(known, ..)| *known == own) {
            let day = recorded.map_or_else(String::new, |column| day_of(history.number(row, column).max(0.0) as u64));
            records.push((own, history.text(row, revision), day));
        }
    }
    let (first, last) = (records.first()?, records.last()?);
    let (mut rows, mut steady) = (String::new(), 0);
    for name in names {
        let own = history.rows_where(benchmark, name).into_iter().map(|row| history.number(row, instructions));
        let values: Vec<f64> = own.filter(|value| value.is_finite()).collect();
        let Some((old, new)) = values.first().zip(values.last()) else { continue };
        let change = 100.0 * (new / old - 1.0);
        if change.abs() < SIGNIFICANT {
            steady += 1;
            continue;
        }
        let _ = writeln!(
            rows,
            "<tr><th scope=\"row\">{}</th><td>{} → {}</td><td>{}{:.0} %</td><td>{}</td></tr>",
            escaped(&name.replace('/', " ")),
            grouped(*old),
            grouped(*new),
            if change < 0.0 { "−" } else { "+" },
            change.abs(),
            sparkline(&values)
        );
    }
    let steady = match steady {
        0 => String::new(),
        count => format!(" Not shown: {count} benchmarks that changed by less than {SIGNIFICANT} %."),
    };
    Some(format!(
        "<section id=\"performance\"><h2>Performance</h2>\n<p>The program’s own benchmarks from record {} (revision <code>{}</code>, {}) \
         to record {} (revision <code>{}</code>, {}), {} records, in instructions, which are exact. \
         Fewer is better; each line is drawn over its own range.{steady}</p>\n<div class=\"table\" tabindex=\"0\" role=\"region\" aria-label=\"Performance\"><table class=\"numbers\"><thead><tr><th>benchmark</th><th>instructions</th><th>change</th><th>records</th></tr></thead><tbody>\n{rows}</tbody></table></div></section>\n",
        escaped(first.0),
        escaped(first.1),
        first.2,
        escaped(last.0),
        escaped(last.1),
        last.2,
        records.len(),
    ))
}

/// A whole number with its digits in threes.
fn grouped(value: f64) -> String {
    let digits = format!("{value:.0}");
    let mut spaced = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index) % 3 == 0 {
            spaced.push('\u{202f}');
        }
        spaced.push(digit);
    }
    spaced
}

/// A line through the values, over their own range.
fn sparkline(values: &[f64]) -> String {
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let place = |(index, value): (usize, &f64)| {
        let across = 2.0 + 96.0 * index as f64 / (values.len() - 1).max(1) as f64;
        let up = if high > low { (value - low) / (high - low) } else { 0.5 };
        format!("{across:.1},{:.1}", 20.0 - 16.0 * up)
    };
    let points: Vec<String> = values.iter().enumerate().map(place).collect();
    format!(
        "<svg class=\"spark\" viewBox=\"0 0 100 24\" width=\"100\" height=\"24\" aria-hidden=\"true\"><polyline points=\"{}\"/></svg>",
        points.join(" ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_stand_in_threes() {
        assert_eq!(grouped(1_234_567.0), "1\u{202f}234\u{202f}567");
    }

    #[test]
    fn a_line_of_one_value_is_a_point_in_the_middle() {
        assert!(sparkline(&[3.0]).contains("points=\"2.0,12.0\""));
        assert!(sparkline(&[1.0, 2.0]).contains("points=\"2.0,20.0 98.0,4.0\""));
    }
}
