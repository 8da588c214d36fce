//! Lays the panels of a figure out in a grid and draws them: axes, data, guides, notes, insets.

use super::axes::{BELOW, LABEL_SIZE, TICK, TICK_SIZE, TITLE_SIZE, axes, crisp, fitting_ticks, label_width, labels};
use super::chart::{FAILED, Figure, Guide, Mode, NO_ANSWER, Plot, Scale, Series};
use super::clip::Rect;
use super::data::{self, BAND, Frame};
use super::drawing::{Anchor, Color, Drawing, PanelData, SeriesData, Text};
use super::legend::Legend;
use super::line_style::LineStyle;
use super::scale::{AxisMap, interval};
use super::style::told_apart;
use super::ticks::{Ticks, power_of_ten};
use super::{guides, rows};
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
    /// Draws the figure if its panels have room in it. Plotting areas of one column have equal edges, all areas equal sizes.
    /// Series that would look the same are told apart.
    ///
    /// # Errors
    /// [`Error::Incompatible`] with the size that it would need, or for a panel with more lines than can be told apart.
    pub fn draw(&self) -> Result<Drawing> {
        let too_many = |panel: &&Plot| panel.layers.len() > MOST_LINES && !panel.has_rows();
        if let Some(panel) = self.panels.iter().find(too_many) {
            let (title, count) = (&panel.title, panel.layers.len());
            let message =
                format!("panel `{title}` has {count} lines, and {MOST_LINES} can be told apart: choose `labels`");
            return Err(Error::Incompatible(message));
        }
        let (drawing, [width, height]) = self.told_apart().drawn(true);
        fits(&[("width", self.width, width), ("height", self.height, height)])?;
        Ok(drawing.noted(&self.note))
    }

    /// The figure with no two lines of one look.
    fn told_apart(&self) -> Self {
        let mut figure = self.clone();
        let lines = figure.panels.iter_mut().filter(|panel| !panel.has_rows()).flat_map(|panel| &mut panel.layers);
        let mut lines: Vec<&mut Series> = lines.collect();
        let labels: Vec<String> = lines.iter().map(|series| series.data_name().to_owned()).collect();
        let labels: Vec<&str> = labels.iter().map(String::as_str).collect();
        let mut styles: Vec<LineStyle> = lines.iter().map(|series| series.style).collect();
        told_apart(&labels, &mut styles);
        lines.iter_mut().zip(styles).for_each(|(series, style)| series.style = style);
        figure
    }

    /// Whether the same series are in all panels.
    fn has_one_set_of_lines(&self) -> bool {
        let labels = |panel: &Plot| panel.layers.iter().map(|series| series.label.clone()).collect::<Vec<_>>();
        self.panels.iter().all(|panel| labels(panel) == labels(&self.panels[0]))
    }

    /// The drawing, and width and height of a plotting area in it; without room nothing is drawn. The legend of lines with
    /// signs stands right of the last panel, each entry where its line ends, if that is wanted and leaves room enough.
    fn drawn(&self, at_lines: bool) -> (Drawing, [f64; 2]) {
        let mut drawing = Drawing::new(self.width, self.height);
        drawing.title = self.panels.iter().map(|panel| panel.title.as_str()).collect::<Vec<_>>().join("; ");
        if self.panels.is_empty() {
            return (drawing, [self.width, self.height]);
        }
        let columns = self.columns.clamp(1, self.panels.len());
        let lines = self.panels.len().div_ceil(columns);
        let infinite = self.panels.iter().any(|panel| Prepared::new(panel, self.height).infinite);
        let inner = self.width - 2.0 * MARGIN;
        let has_markers = |series: &Series| series.mode == Mode::LineMarkers;
        let at_lines = at_lines && lines == 1 && self.panels.iter().flat_map(|panel| &panel.layers).any(has_markers);
        let legend = Legend::of(&self.panels, infinite);
        let (beside, under) = match at_lines && self.has_one_set_of_lines() {
            true => legend.split(),
            false => (Legend::default(), legend),
        };
        let legend_right = beside.column_width() + if beside.column_width() > 0.0 { BEFORE_LEGEND } else { 0.0 };
        let legend_below = under.rows_height(inner);
        let below = if legend_below > 0.0 { legend_below + BEFORE_LEGEND } else { 0.0 };

        let titled = |line: &[Plot]| line.iter().any(|panel| !panel.title.is_empty());
        let above: Vec<f64> =
            self.panels.chunks(columns).map(|line| if titled(line) { TITLE_SIZE + 9.0 } else { 8.0 }).collect();
        let taken = above.iter().sum::<f64>() + lines as f64 * BELOW + (lines - 1) as f64 * BETWEEN_ROWS;
        let of_rows = self.panels.iter().map(rows::height).fold(0.0, f64::max);
        if of_rows > 0.0 {
            drawing.height = lines as f64 * of_rows + taken + below + 2.0 * MARGIN - 6.0;
        }
        let height = (drawing.height - 2.0 * MARGIN + 6.0 - below - taken) / lines as f64;

        let prepared: Vec<Prepared<'_>> = self.panels.iter().map(|panel| Prepared::new(panel, height)).collect();
        let left_of = |column: usize| {
            let own = prepared.iter().skip(column).step_by(columns);
            own.map(|panel| panel.left(column)).fold(0.0, f64::max)
        };
        let lefts: Vec<f64> = (0..columns).map(left_of).collect();
        let lost = self.panels.iter().map(rows::lost_width).fold(0.0, f64::max);
        let once = rows::lose_the_same(&self.panels);
        let says_lost = |column: usize| lost > 0.0 && (column + 1 == columns || !once);
        let rights: Vec<f64> =
            (0..columns).map(|column| if says_lost(column) { lost + RIGHT_OF_PANEL } else { RIGHT_OF_PANEL }).collect();
        let taken = lefts.iter().chain(&rights).sum::<f64>() + (columns - 1) as f64 * BETWEEN_COLUMNS + legend_right;
        let room = inner - taken;
        // Equal parts, or in proportion to the columns of cells.
        let counts: Option<Vec<usize>> = self.panels.iter().map(rows::columns).collect();
        let widths: Vec<f64> = match counts {
            Some(counts) if lines == 1 => {
                let step = (room / counts.iter().sum::<usize>().max(1) as f64).min(rows::WIDEST_COLUMN);
                counts.into_iter().map(|count| step * count as f64).collect()
            }
            _ => vec![room / columns as f64; columns],
        };
        let width = widths.iter().copied().fold(f64::INFINITY, f64::min);
        if legend_right > 0.0 && (width < LEAST_BESIDE || height < beside.column_height()) {
            return self.drawn(false);
        }
        if width < 1.0 || height < 1.0 {
            return (drawing, [width, height]);
        }

        let (mut ends, mut last) = (Vec::new(), [0.0, 0.0]);
        for (index, panel) in prepared.iter().enumerate() {
            let (line, column) = (index / columns, index % columns);
            let before = (0..column).map(|before| widths[before] + rights[before] + BETWEEN_COLUMNS).sum::<f64>();
            let left = MARGIN + lefts[..=column].iter().sum::<f64>() + before;
            let top = MARGIN - 6.0 + above[..=line].iter().sum::<f64>() + line as f64 * (height + BELOW + BETWEEN_ROWS);
            let place = Rect { left, top, right: left + widths[column], bottom: top + height };
            let [left, top, right, bottom] = [place.left, place.top, place.right, place.bottom].map(crisp);
            let place = Rect { left, top, right, bottom };
            if panel.panel.has_rows() {
                let series = rows::draw(&mut drawing, panel.panel, &place, [column == 0, says_lost(column)]);
                panel.keep(&mut drawing, series);
                continue;
            }
            ends = panel.draw(&mut drawing, place);
            last = [top, bottom];
        }
        beside.draw_at_lines(&mut drawing, self.width - MARGIN - beside.column_width(), last, &ends);
        let bottom = drawing.height - MARGIN + 4.0 - legend_below;
        under.draw_rows(&mut drawing, MARGIN, bottom, inner);
        // Rows take the height that they need.
        (drawing, [width, if of_rows > 0.0 { LEAST } else { height }])
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
fn lost(panel: &Plot) -> &'static str {
    let failed = panel.layers.iter().flat_map(|series| &series.lost).any(|(_, loss)| loss.failed > 0.0);
    if failed { FAILED } else { NO_ANSWER }
}

/// A panel whose intervals and vertical ticks are settled, before its place is.
struct Prepared<'a> {
    panel: &'a Plot,
    x: (f64, f64),
    y: (f64, f64),
    y_ticks: Ticks,
    band: f64,
    infinite: bool,
}

impl<'a> Prepared<'a> {
    /// Settles intervals and vertical ticks for about this height of the plotting area (band included).
    fn new(panel: &'a Plot, height: f64) -> Self {
        let (x, y) = intervals(panel);
        let infinite = panel.layers.iter().flat_map(|s| &s.points).any(|p| p.1 == f64::INFINITY && !p.0.is_nan());
        let band = match (infinite, data::lossy(&panel.layers).count()) {
            (false, 0) => 0.0,
            (true, 0) => BAND,
            (_, rows) => data::height_of_rows(rows),
        };
        let height = height - band;
        let map = AxisMap { scale: panel.axes[1].scale, low: y.0, high: y.1, start: 0.0, end: 1.0 };
        let y_ticks = map.ticks((height / 26.0) as usize);
        Prepared { panel, x, y, y_ticks, band, infinite }
    }

    /// Room needed left of the plotting area for tick labels and the axis label, px.
    fn left(&self, column: usize) -> f64 {
        if self.panel.has_rows() {
            return if column == 0 { rows::labels_width(self.panel) } else { 0.0 };
        }
        let widest = self.y_ticks.ticks.iter().map(|tick| label_width(&tick.label)).fold(0.0, f64::max);
        let exponent = label_width(&times(self.y_ticks.exponent));
        let band = match (self.band > 0.0, self.infinite) {
            (true, false) => label_width(lost(self.panel)),
            _ => 0.0,
        };
        widest.max(exponent).max(band)
            + TICK
            + 5.0
            + if self.panel.axes[1].label.is_empty() { 0.0 } else { LABEL_SIZE + 10.0 }
    }

    /// Draws the panel into its plotting area (band included). Returns the height at which each series ends.
    fn draw(&self, drawing: &mut Drawing, place: Rect) -> Vec<(String, f64)> {
        let panel = self.panel;
        let area = Rect { top: place.top + self.band, ..place };
        let frame = Frame {
            area,
            band: self.band,
            band_label: if self.infinite { "∞" } else { lost(panel) },
            x: AxisMap { scale: panel.axes[0].scale, low: self.x.0, high: self.x.1, start: area.left, end: area.right },
            y: AxisMap { scale: panel.axes[1].scale, low: self.y.0, high: self.y.1, start: area.bottom, end: area.top },
        };
        let x_ticks = fitting_ticks(&frame.x);
        axes(drawing, &frame, &x_ticks, &self.y_ticks);
        for guide in &panel.marks {
            guides::draw(drawing, &frame, guide);
        }
        for (index, series) in panel.layers.iter().enumerate() {
            let later = &panel.layers[index + 1..];
            data::draw(drawing, &frame, series, (index, panel.layers.len()), later);
        }
        let exact = |series| data::exact(series, |index| frame.place(series, index));
        self.keep(drawing, panel.layers.iter().map(exact).collect());
        data::draw_losses(drawing, &frame, &panel.layers);
        data::draw_tags(drawing, &frame, &panel.layers);
        for guide in &panel.marks {
            guides::label(drawing, &frame, guide);
        }
        for (number, note) in panel.notes.iter().enumerate() {
            guides::note(drawing, &frame, number, note);
        }
        self.labels(drawing, &frame, &x_ticks);
        let end =
            |series: &Series| (series.label.clone(), data::end(&frame, series, &panel.layers).unwrap_or(place.top));
        panel.layers.iter().map(end).collect()
    }

    /// Keeps the data behind the panel.
    fn keep(&self, drawing: &mut Drawing, series: Vec<SeriesData>) {
        let ([x, y], title) = (self.panel.axes.each_ref().map(|axis| axis.label.clone()), self.panel.title.clone());
        drawing.data.push(PanelData { title, x, y, series });
    }

    fn labels(&self, drawing: &mut Drawing, frame: &Frame, x_ticks: &Ticks) {
        let (panel, whole) = (self.panel, frame.whole());
        labels(drawing, &whole, &panel.title, &panel.axes[0].label);
        let centre = whole.centre().1;
        let y_label =
            Text::new(&panel.axes[1].label, (whole.left - self.left(0) + 0.5 * LABEL_SIZE, centre), LABEL_SIZE);
        drawing.text(y_label.anchored(Anchor::Middle).upwards().centred());
        let small = |text: Text| text.anchored(Anchor::End).colored(Color::SOFT_INK);
        let exponent = Text::new(times(self.y_ticks.exponent), (whole.left - TICK - 4.0, whole.top - 6.0), TICK_SIZE);
        drawing.text(small(exponent));
        let exponent = Text::new(times(x_ticks.exponent), (whole.right, whole.bottom + BELOW - 6.0), TICK_SIZE);
        drawing.text(small(exponent));
    }
}

fn intervals(panel: &Plot) -> ((f64, f64), (f64, f64)) {
    let slopes = panel.marks.iter().filter_map(|guide| match guide {
        Guide::Slope { order, from, to_x } => Some([*from, (*to_x, from.1 * (to_x / from.0).powf(*order))]),
        _ => None,
    });
    let extra: Vec<(f64, f64)> = slopes.flatten().collect();
    let lost: Vec<(f64, f64)> = panel.layers.iter().flat_map(|series| &series.lost).map(|p| (p.0, f64::NAN)).collect();
    let bars = panel.layers.iter().flat_map(|series| &series.bars);
    let bars: Vec<(f64, f64)> = bars.flat_map(|&(x, ends)| ends.map(|y| (x, y))).collect();
    let points = || {
        let series = panel.layers.iter().flat_map(|series| &series.points);
        series.chain(&bars).chain(&extra).chain(&lost).copied()
    };
    let [across, upwards] = &panel.axes;
    let tight = across.scale != Scale::Log10;
    let x = interval(across, points().map(|p| p.0), if tight { 0.0 } else { 0.05 });
    // What a fixed x interval hides does not widen y.
    let seen = points().filter(|p| (x.0..=x.1).contains(&p.0));
    (x, interval(upwards, seen.map(|p| p.1), 0.05))
}

fn times(exponent: i32) -> String {
    if exponent == 0 { String::new() } else { format!("×{}", power_of_ten(exponent)) }
}
