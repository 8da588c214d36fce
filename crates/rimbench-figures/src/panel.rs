//! Draws one panel: axes, data, guides, notes, inset.

use super::axes::{BELOW, LABEL_SIZE, TICK, TICK_SIZE, axes, fitting_ticks, label_width, labels};
use super::chart::{DIVERGED, Guide, NO_ANSWER, Panel, Scale, Series};
use super::clip::Rect;
use super::data::{self, BAND, Frame};
use super::drawing::{Anchor, Color, Drawing, PanelData, Text};
use super::guides;
use super::scale::{AxisMap, interval};
use super::ticks::{Ticks, power_of_ten};
use super::{filled_band, inset};

/// What stands beside the band of runs without a value.
fn lost(panel: &Panel) -> &'static str {
    let failed = panel.losses.iter().flat_map(|losses| &losses.points).any(|(_, loss)| loss.failed > 0.0);
    if failed { DIVERGED } else { NO_ANSWER }
}

/// A panel whose intervals and vertical ticks are settled, before its place is.
pub struct Prepared<'a> {
    panel: &'a Panel,
    x: (f64, f64),
    y: (f64, f64),
    y_ticks: Ticks,
    band: f64,
    infinite: bool,
}

impl<'a> Prepared<'a> {
    /// Settles intervals and vertical ticks for about this height of the plotting area (band included).
    pub fn new(panel: &'a Panel, height: f64) -> Self {
        let (x, y) = intervals(panel);
        let infinite = panel.series.iter().flat_map(|s| &s.points).any(|p| p.1 == f64::INFINITY && !p.0.is_nan());
        let band = match (infinite, panel.losses.is_empty()) {
            (false, true) => 0.0,
            (true, true) => BAND,
            (_, false) => data::height_of_rows(panel.losses.len()),
        };
        let height = height - band;
        let map = AxisMap { scale: panel.y.scale, low: y.0, high: y.1, start: 0.0, end: 1.0 };
        let y_ticks = map.ticks((height / 26.0) as usize);
        Prepared { panel, x, y, y_ticks, band, infinite }
    }

    /// Whether infinite values are shown.
    pub fn infinite(&self) -> bool {
        self.infinite
    }

    /// Room needed left of the plotting area for tick labels and the axis label, px.
    pub fn left(&self) -> f64 {
        let widest = self.y_ticks.ticks.iter().map(|tick| label_width(&tick.label)).fold(0.0, f64::max);
        let exponent = label_width(&times(self.y_ticks.exponent));
        let band = match (self.band > 0.0, self.infinite) {
            (true, false) => label_width(lost(self.panel)),
            _ => 0.0,
        };
        widest.max(exponent).max(band)
            + TICK
            + 5.0
            + if self.panel.y.label.is_empty() { 0.0 } else { LABEL_SIZE + 10.0 }
    }

    /// Draws the panel into its plotting area (band included). Returns the height at which each series ends.
    pub fn draw(&self, drawing: &mut Drawing, place: Rect) -> Vec<(String, f64)> {
        let panel = self.panel;
        let area = Rect { top: place.top + self.band, ..place };
        let frame = Frame {
            area,
            band: self.band,
            band_label: if self.infinite { "∞" } else { lost(panel) },
            x: AxisMap { scale: panel.x.scale, low: self.x.0, high: self.x.1, start: area.left, end: area.right },
            y: AxisMap { scale: panel.y.scale, low: self.y.0, high: self.y.1, start: area.bottom, end: area.top },
        };
        let x_ticks = fitting_ticks(&frame.x);
        axes(drawing, &frame, &x_ticks, &self.y_ticks);
        for band in &panel.bands {
            filled_band::draw(drawing, &frame, band);
        }
        for guide in &panel.guides {
            guides::draw(drawing, &frame, guide);
        }
        for (index, series) in panel.series.iter().enumerate() {
            let later = &panel.series[index + 1..];
            data::draw(drawing, &frame, series, (index, panel.series.len()), later);
        }
        drawing.data.push(PanelData {
            title: panel.title.clone(),
            x: panel.x.label.clone(),
            y: panel.y.label.clone(),
            series: panel.series.iter().map(|series| data::exact(&frame, series)).collect(),
        });
        data::draw_losses(drawing, &frame, &panel.losses);
        data::draw_tags(drawing, &frame, &panel.series);
        for guide in &panel.guides {
            guides::label(drawing, &frame, guide);
        }
        for (number, note) in panel.notes.iter().enumerate() {
            guides::note(drawing, &frame, number, note);
        }
        if let Some(inset) = &panel.inset {
            inset::draw(drawing, &frame, panel, inset);
        }
        self.labels(drawing, &frame, &x_ticks);
        let end = |series: &Series| (series.label.clone(), data::end(&frame, series).unwrap_or(place.top));
        panel.series.iter().map(end).collect()
    }

    fn labels(&self, drawing: &mut Drawing, frame: &Frame, x_ticks: &Ticks) {
        let (panel, whole) = (self.panel, frame.whole());
        labels(drawing, &whole, &panel.title, &panel.x.label);
        let centre = whole.centre().1;
        let y_label = Text::new(&panel.y.label, (whole.left - self.left() + 0.5 * LABEL_SIZE, centre), LABEL_SIZE);
        drawing.text(y_label.anchored(Anchor::Middle).upwards().centred());
        let small = |text: Text| text.anchored(Anchor::End).colored(Color::SOFT_INK);
        let exponent = Text::new(times(self.y_ticks.exponent), (whole.left - TICK - 4.0, whole.top - 6.0), TICK_SIZE);
        drawing.text(small(exponent));
        let exponent = Text::new(times(x_ticks.exponent), (whole.right, whole.bottom + BELOW - 6.0), TICK_SIZE);
        drawing.text(small(exponent));
    }
}

fn intervals(panel: &Panel) -> ((f64, f64), (f64, f64)) {
    let slopes = panel.guides.iter().filter_map(|guide| match guide {
        Guide::Slope { order, from, to_x } => Some([*from, (*to_x, from.1 * (to_x / from.0).powf(*order))]),
        _ => None,
    });
    let extra: Vec<(f64, f64)> = slopes.flatten().collect();
    let lost: Vec<(f64, f64)> =
        panel.losses.iter().flat_map(|losses| &losses.points).map(|p| (p.0, f64::NAN)).collect();
    let edges = panel.bands.iter().flat_map(|band| &band.points);
    let edges: Vec<(f64, f64)> = edges.flat_map(|&(x, [low, high])| [(x, low), (x, high)]).collect();
    let bars = panel.series.iter().flat_map(|series| &series.bars);
    let bars: Vec<(f64, f64)> = bars.flat_map(|&(x, ends)| ends.map(|y| (x, y))).collect();
    let points = || {
        let series = panel.series.iter().flat_map(|series| &series.points);
        series.chain(&bars).chain(&edges).chain(&extra).chain(&lost).copied()
    };
    let tight = panel.x.scale != Scale::Log10;
    let x = interval(&panel.x, points().map(|p| p.0), if tight { 0.0 } else { 0.05 });
    // What a fixed x interval hides does not widen y.
    let seen = points().filter(|p| (x.0..=x.1).contains(&p.0));
    (x, interval(&panel.y, seen.map(|p| p.1), 0.05))
}

fn times(exponent: i32) -> String {
    if exponent == 0 { String::new() } else { format!("×{}", power_of_ten(exponent)) }
}
