//! One run beside its reference: motion, force, and when contacts are closed.

use crate::chart::{Axis, Figure, Mode, Plot, Series};
use crate::drawing::Drawing;
use crate::line_style::LineStyle;
use crate::style::Styles;
use rimbench_cases::parameter::without_unit;
use rimbench_core::cosim::Trajectory;
use rimbench_core::error::Result;
use rimbench_runs::metrics::CLOSES_AT;
use rimbench_runs::{EvaluatedRun, Reference, RunSpec};

/// Draws position and force of each row of the interface, and contacts where they are recorded, of a run that has its
/// trace.
///
/// # Errors
/// [`Error::Incompatible`](rimbench_core::error::Error::Incompatible) where there is no room for so many rows.
pub fn plot(spec: &RunSpec, run: &EvaluatedRun, reference: &Reference, styles: &Styles) -> Result<Drawing> {
    let name = styles.shown_name(&spec.scheme.name);
    let shown = [
        ("reference", "reference", &reference.trajectory, styles.of_label("reference")),
        (&*spec.scheme.name, &*name, &run.trajectory, styles.of_label(&spec.scheme.name)),
    ];
    let rows = &spec.case.interface_columns;
    let columns = rows.iter().flat_map(|row| [&row.position, &row.force]);
    let time = || Axis::linear("time t (s)");
    let series = |(id, name, points, style): (&str, &str, Vec<(f64, f64)>, LineStyle)| Series {
        name: id.to_owned(),
        ..Series::new(name, points, style).mode(Mode::Line)
    };
    let mut panels: Vec<Plot> = Vec::new();
    for column in columns {
        let (words, unit) = without_unit(column);
        let label = format!("{} ({unit})", words.replace('_', " "));
        let mut panel = Plot::new("", time(), Axis::linear(&label));
        // A run that is gone leaves the frame of what is true.
        let peak = reference.trajectory.index_of(column).map_or(0.0, |column| reference.largest[column]);
        for (id, name, trajectory, style) in shown {
            let points = pairs(trajectory, column);
            let points = points.into_iter().take_while(|(_, y)| peak == 0.0 || y.abs() <= 4.0 * peak).collect();
            panel = panel.layer(series((id, name, points, style)));
        }
        panels.push(panel);
    }
    let contacts: Vec<&String> =
        run.trajectory.columns().iter().filter(|name| name.starts_with("gap_") && name.ends_with("_m")).collect();
    if !contacts.is_empty() {
        let count = contacts.len() as f64;
        let mut panel = Plot::new("", time(), Axis::linear("contact closed").within(Some([0.3, count + 0.7])));
        for (shift, (id, name, trajectory, style)) in [0.12, -0.12].into_iter().zip(shown) {
            let of_contact = |(index, column): (usize, &&String)| {
                let y = index as f64 + 1.0 + shift;
                let closed = |(t, gap): (f64, f64)| (t, if gap <= CLOSES_AT { y } else { f64::NAN });
                pairs(trajectory, column).into_iter().map(closed).chain([(f64::NAN, f64::NAN)]).collect::<Vec<_>>()
            };
            let points = contacts.iter().enumerate().flat_map(of_contact).collect();
            panel = panel.layer(series((id, name, points, style)));
        }
        let words = contacts.iter().enumerate().map(|(index, gap)| {
            format!("{} {}", index + 1, gap.trim_start_matches("gap_").trim_end_matches("_m").replace('_', " "))
        });
        panel.notes = vec![words.collect::<Vec<_>>().join(" · ")];
        panels.push(panel);
    }
    let height = 60.0 + 200.0 * panels.len() as f64;
    let figure = panels.into_iter().fold(Figure::new(680.0, height, Some(1)), Figure::panel);
    let step = 1e3 * spec.macro_step;
    let about = format!("{} · {name} · H = {step} ms · {}", spec.case.name, run.outcome.name());
    Ok(figure.draw()?.headed(&about, ""))
}

fn pairs(trajectory: &Trajectory, column: &str) -> Vec<(f64, f64)> {
    let values = trajectory.index_of(column).map(|column| trajectory.column(column));
    values.into_iter().flatten().zip(trajectory.column(0)).map(|(value, time)| (time, value)).collect()
}
