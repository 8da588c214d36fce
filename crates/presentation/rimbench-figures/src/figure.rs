//! Lays the panels of a figure out in a grid and draws them: axes, data, guides, notes, insets.

use super::axes::{BELOW, LABEL_SIZE, TICK, TICK_SIZE, TITLE_SIZE, axes, crisp, fitting_ticks, label_width, labels};
use super::chart::{FAILED, Figure, Guide, LegendPlace, NO_ANSWER, Panel, Scale, Series};
use super::clip::Rect;
use super::data::{self, BAND, Frame};
use super::drawing::{Anchor, Color, Drawing, PanelData, Text};
use super::legend::Legend;
use super::line_style::LineStyle;
use super::scale::{AxisMap, interval};
use super::style::told_apart;
use super::ticks::{Ticks, power_of_ten};
use super::{filled_band, guides, inset};
use rimbench_core::error::{Error, Result};

const MARGIN: f64 = 8.0;
const RIGHT_OF_PANEL: f64 = 6.0;
const BETWEEN_COLUMNS: f64 = 10.0;
const BETWEEN_ROWS: f64 = 8.0;
const BEFORE_LEGEND: f64 = 6.0;
/// Least width of a plotting area beside labels of lines, px.
const LEAST_BESIDE: f64 = 150.0;
/// Most lines of a panel that can be told apart.
pub(crate) const MOST_LINES: usize = 7;

/// Least width and height of a plotting area, px: below, there is no room for ticks and their labels.
const LEAST: f64 = 40.0;

impl Figure {
    /// Draws the figure if its panels have room in it.
    ///
    /// # Errors
    /// [`Error::Incompatible`] with the size that it would need, or for a panel with more lines than can be told apart.
    pub fn draw_if_it_fits(&self) -> Result<Drawing> {
        if let Some(panel) = self.panels.iter().find(|panel| panel.series.len() > MOST_LINES) {
            let (title, count) = (&panel.title, panel.series.len());
            let message =
                format!("panel `{title}` has {count} lines, and {MOST_LINES} can be told apart: choose `labels`");
            return Err(Error::Incompatible(message));
        }
        let (drawing, [width, height]) = self.told_apart().drawn();
        fits(&[("width", self.width, width), ("height", self.height, height)]).map(|()| drawing)
    }

    /// Draws the figure. Plotting areas of one column have equal edges, all areas equal sizes. Series that would look
    /// the same are told apart.
    pub fn draw(&self) -> Drawing {
        self.told_apart().drawn().0
    }

    /// The figure with no two series of one look.
    fn told_apart(&self) -> Self {
        let mut figure = self.clone();
        let names: Vec<String> =
            self.panels.iter().flat_map(|panel| &panel.series).map(|series| series.data_name().to_owned()).collect();
        let labels: Vec<&str> = names.iter().map(String::as_str).collect();
        let series = || self.panels.iter().flat_map(|panel| &panel.series);
        let mut styles: Vec<LineStyle> = series().map(|series| series.style).collect();
        told_apart(&labels, &mut styles);
        let mut next = styles.into_iter();
        for panel in &mut figure.panels {
            for series in &mut panel.series {
                series.style = next.next().unwrap_or(series.style);
                let own = panel.losses.iter_mut().filter(|losses| losses.name == series.data_name());
                own.for_each(|losses| losses.color = series.style.color);
            }
        }
        figure
    }

    /// Whether the same series are in all panels.
    fn has_one_set_of_lines(&self) -> bool {
        let labels = |panel: &Panel| panel.series.iter().map(|series| series.label.clone()).collect::<Vec<_>>();
        self.panels.iter().all(|panel| labels(panel) == labels(&self.panels[0]))
    }

    /// The drawing, and width and height of a plotting area in it; without room nothing is drawn.
    fn drawn(&self) -> (Drawing, [f64; 2]) {
        let mut drawing = Drawing::new(self.width, self.height);
        drawing.title = self.panels.iter().map(|panel| panel.title.as_str()).collect::<Vec<_>>().join("; ");
        if self.panels.is_empty() {
            return (drawing, [self.width, self.height]);
        }
        let columns = self.columns.clamp(1, self.panels.len());
        let rows = self.panels.len().div_ceil(columns);
        let infinite = self.panels.iter().any(|panel| Prepared::new(panel, self.height).infinite());
        let inner = self.width - 2.0 * MARGIN;
        let (beside, under) = match self.legend {
            LegendPlace::Lines if rows == 1 && self.has_one_set_of_lines() => {
                Legend::of(&self.panels, infinite).split()
            }
            _ => (Legend::default(), Legend::of(&self.panels, infinite)),
        };
        let legend_right = beside.column_width() + if beside.column_width() > 0.0 { BEFORE_LEGEND } else { 0.0 };
        let legend_below = under.rows_height(inner);
        let below = if legend_below > 0.0 { legend_below + BEFORE_LEGEND } else { 0.0 };

        let titled = |row: &[Panel]| row.iter().any(|panel| !panel.title.is_empty());
        let above: Vec<f64> =
            self.panels.chunks(columns).map(|row| if titled(row) { TITLE_SIZE + 9.0 } else { 8.0 }).collect();
        let taken = above.iter().sum::<f64>() + rows as f64 * BELOW + (rows - 1) as f64 * BETWEEN_ROWS;
        let height = (self.height - 2.0 * MARGIN + 6.0 - below - taken) / rows as f64;

        let prepared: Vec<Prepared<'_>> = self.panels.iter().map(|panel| Prepared::new(panel, height)).collect();
        let left_of =
            |column: usize| prepared.iter().skip(column).step_by(columns).map(Prepared::left).fold(0.0, f64::max);
        let lefts: Vec<f64> = (0..columns).map(left_of).collect();
        let taken = lefts.iter().sum::<f64>()
            + columns as f64 * RIGHT_OF_PANEL
            + (columns - 1) as f64 * BETWEEN_COLUMNS
            + legend_right;
        let width = (inner - taken) / columns as f64;
        if legend_right > 0.0 && (width < LEAST_BESIDE || height < beside.column_height()) {
            return Figure { legend: LegendPlace::Below, ..self.clone() }.drawn();
        }
        if width < 1.0 || height < 1.0 {
            return (drawing, [width, height]);
        }

        let (mut ends, mut last) = (Vec::new(), [0.0, 0.0]);
        for (index, panel) in prepared.iter().enumerate() {
            let (row, column) = (index / columns, index % columns);
            let left = MARGIN
                + lefts[..=column].iter().sum::<f64>()
                + column as f64 * (width + RIGHT_OF_PANEL + BETWEEN_COLUMNS);
            let top = MARGIN - 6.0 + above[..=row].iter().sum::<f64>() + row as f64 * (height + BELOW + BETWEEN_ROWS);
            let place = Rect { left, top, right: left + width, bottom: top + height };
            let [left, top, right, bottom] = [place.left, place.top, place.right, place.bottom].map(crisp);
            ends = panel.draw(&mut drawing, Rect { left, top, right, bottom });
            last = [top, bottom];
        }
        beside.draw_at_lines(&mut drawing, self.width - MARGIN - beside.column_width(), last, &ends);
        under.draw_rows(&mut drawing, MARGIN, self.height - MARGIN + 4.0 - legend_below, inner);
        (drawing, [width, height])
    }
}

/// Refuses a picture in which a part has too little room; each entry is an edge, its length, and that of the part along
/// it, px.
pub(crate) fn fits(edges: &[(&str, f64, f64)]) -> Result<()> {
    let narrow = edges.iter().find(|(_, _, part)| *part < LEAST);
    narrow.map_or(Ok(()), |(edge, length, part)| {
        let message = format!("{edge} = {length} px leaves {part:.0} px for each panel, and {LEAST} are needed");
        Err(Error::Incompatible(message))
    })
}

/// What stands beside the band of runs without a value.
fn lost(panel: &Panel) -> &'static str {
    let failed = panel.losses.iter().flat_map(|losses| &losses.points).any(|(_, loss)| loss.failed > 0.0);
    if failed { FAILED } else { NO_ANSWER }
}

/// A panel whose intervals and vertical ticks are settled, before its place is.
struct Prepared<'a> {
    panel: &'a Panel,
    x: (f64, f64),
    y: (f64, f64),
    y_ticks: Ticks,
    band: f64,
    infinite: bool,
}

impl<'a> Prepared<'a> {
    /// Settles intervals and vertical ticks for about this height of the plotting area (band included).
    fn new(panel: &'a Panel, height: f64) -> Self {
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
    fn infinite(&self) -> bool {
        self.infinite
    }

    /// Room needed left of the plotting area for tick labels and the axis label, px.
    fn left(&self) -> f64 {
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
    fn draw(&self, drawing: &mut Drawing, place: Rect) -> Vec<(String, f64)> {
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
        data::draw_losses(drawing, &frame, &panel.losses, &panel.series);
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
        let end =
            |series: &Series| (series.label.clone(), data::end(&frame, series, &panel.losses).unwrap_or(place.top));
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
