//! Cost against contacts, from the table that `peers.py` writes.

use rimbench::error::{Error, Result};
use rimbench::figures::chart::{Axis, Figure, LegendPlace, Mode, Panel, Series};
use rimbench::figures::render;
use rimbench::figures::style::style_in_list;
use rimbench::results_table::read_table;
use rimbench::statistics::order_of_convergence;
use std::path::Path;

/// 180 mm, two columns of a page.
const SIZE: (f64, f64) = (680.0, 520.0);
const CASES: [(&str, &str); 2] = [("disc-row", "row"), ("disc-pile", "heap")];
const STATES: [&str; 2] = ["settled", "moving"];
/// Columns and what the legend calls them.
const LINES: [(&str, &str); 7] = [
    ("build_us", "building the model"),
    ("take_us", "taking it"),
    ("use_us", "using it, 100 micro steps"),
    ("step_us", "mechanics"),
    ("mujoco_us", "MuJoCo, a step"),
    ("drake_us", "Drake, a step"),
    ("siconos_us", "Siconos, a step"),
];

/// Draws the table beside itself, under its own name. The legend says the exponents from 64 contacts on, row and heap, settled
/// and then moving; where an engine has fewer than two such systems there is none.
///
/// # Errors
/// [`Error::File`] for a table that lacks a column or has no systems, or a folder that cannot be written to.
pub fn draw(path: &Path) -> Result<()> {
    let table = read_table(path)?;
    let (case, state) = (table.column("case")?, table.column("state")?);
    let points = |in_case: &str, in_state: &str, column: &str| -> Result<Vec<(f64, f64)>> {
        let both = |row: &usize| table.text(*row, case) == in_case && table.text(*row, state) == in_state;
        let rows: Vec<usize> = (0..table.len()).filter(both).collect();
        let known = |(_, y): &(f64, f64)| y.is_finite();
        let all = table.pairs("contacts", column)?;
        Ok(rows.iter().map(|&row| all[row]).filter(known).collect())
    };
    let mut labels = Vec::new();
    for (column, name) in LINES {
        let mut exponents = Vec::new();
        for in_state in STATES {
            for (in_case, _) in CASES {
                let mut large = points(in_case, in_state, column)?;
                large.retain(|(contacts, _)| *contacts >= super::LARGE as f64);
                let exponent = order_of_convergence(&large);
                exponents.push(exponent.map_or("–".to_owned(), |exponent| format!("{exponent:.1}")));
            }
        }
        labels.push(format!("{name}: {} {}; {} {}", exponents[0], exponents[1], exponents[2], exponents[3]));
    }
    let mut figure = Figure::new(SIZE.0, SIZE.1).columns(2).legend(LegendPlace::Below);
    let mut drawn = 0;
    for in_state in STATES {
        for (in_case, shown) in CASES {
            let mut panel =
                Panel::new(format!("{shown}, {in_state}"), Axis::log10("possible contacts"), Axis::log10("time, µs"));
            for (index, ((column, _), label)) in LINES.iter().zip(&labels).enumerate() {
                let points = points(in_case, in_state, column)?;
                drawn += points.len();
                if !points.is_empty() {
                    panel = panel.series(Series::new(label, points, style_in_list(index)).mode(Mode::LineMarkers));
                }
            }
            figure = figure.panel(panel);
        }
    }
    if drawn == 0 {
        return Err(Error::file(path, "holds no system of disc-row or disc-pile: there is nothing to draw"));
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let file = render::write(&figure.draw(), path.parent().unwrap_or(Path::new(".")), &name)?;
    println!("{}", file.display());
    Ok(())
}
