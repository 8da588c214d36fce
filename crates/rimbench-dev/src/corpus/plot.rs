//! The performance profile as a figure.

use super::replay::{Replay, Start};
use rimbench_core::name::Name;
use rimbench_figures::chart::{Axis, Figure, LegendPlace, Mode, Panel, Series};
use rimbench_figures::drawing::Drawing;
use rimbench_figures::style::style_in_list;
use rimbench_statistics::{performance_ratios, share_within};

/// 180 mm, two columns of a page.
const WIDTH: f64 = 680.0;
const HEIGHT: f64 = 360.0;
/// Factors per decade: closer than the line is wide.
const PER_DECADE: f64 = 60.0;
/// Decades shown at most.
const DECADES: f64 = 6.0;

/// Draws the profile of the warm replays, up to the power of ten from which on no solver gains a thousandth.
///
/// A solver has the same line in every such figure, whichever others are beside it, by its place among all that are `known`; the
/// line ends where it has solved all problems.
pub fn draw_profile(replays: &[Replay], known: &[Name]) -> Drawing {
    let warm: Vec<&Replay> = replays.iter().filter(|replay| replay.start == Start::Warm).collect();
    let costs: Vec<Vec<f64>> = warm.iter().map(|replay| replay.costs()).collect();
    let (problems, ratios) = (costs.first().map_or(0, Vec::len), performance_ratios(&costs));
    let factors: Vec<f64> =
        (0..=(DECADES * PER_DECADE) as u32).map(|k| 10_f64.powf(f64::from(k) / PER_DECADE)).collect();
    let within = |factor: f64| -> Vec<f64> { ratios.iter().map(|ratios| share_within(ratios, factor)).collect() };
    let shares: Vec<Vec<f64>> = factors.iter().map(|&factor| within(factor)).collect();
    let solved = within(f64::INFINITY);
    let settled = |shares: &Vec<f64>| shares.iter().zip(&solved).all(|(share, solved)| solved - share < 1e-3);
    let last = shares.iter().position(settled).map_or(factors[factors.len() - 1], |at| factors[at]);
    let end = 10_f64.powf(last.log10().ceil().max(1.0));

    let x = Axis::log10("time over that of the fastest solver on the same problem").range(1.0, end);
    let y = Axis::linear("share of problems solved").range(-0.02, 1.02);
    let mut panel = Panel::new(format!("{problems} contact problems, warm"), x, y);
    for (solver, replay) in warm.iter().enumerate() {
        // Where everything is solved the lines would only hide each other: NaN ends them.
        let mut all = false;
        let share = |share: f64| if std::mem::replace(&mut all, share >= 1.0) { f64::NAN } else { share };
        let curve = factors.iter().copied().zip(shares.iter().map(|row| row[solver]).map(share)).collect();
        let in_list = known.iter().position(|name| *name == replay.solver).unwrap_or(known.len());
        let (name, style) = (&*replay.solver, style_in_list(in_list));
        panel = panel.series(Series::new(name, curve, style).mode(Mode::LineMarkers));
    }
    Figure::new(WIDTH, HEIGHT).columns(1).legend(LegendPlace::Lines).panel(panel).draw()
}
