//! Lays the panels of a figure out in a grid and draws them.

use super::axes::{BELOW, TITLE_SIZE, crisp};
use super::chart::{Figure, LegendPlace, Panel};
use super::clip::Rect;
use super::drawing::Drawing;
use super::legend::Legend;
use super::line_style::LineStyle;
use super::panel::Prepared;
use super::style::told_apart;
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

    /// Draws the figure. Plotting areas of one column have equal edges, all areas equal sizes. Series that would look the same are told
    /// apart.
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
        for series in figure.panels.iter_mut().flat_map(|panel| &mut panel.series) {
            series.style = next.next().unwrap_or(series.style);
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

/// Refuses a picture in which a part has too little room; each entry is an edge, its length, and that of the part along it, px.
pub(crate) fn fits(edges: &[(&str, f64, f64)]) -> Result<()> {
    let narrow = edges.iter().find(|(_, _, part)| *part < LEAST);
    narrow.map_or(Ok(()), |(edge, length, part)| {
        let message = format!("{edge} = {length} px leaves {part:.0} px for each panel, and {LEAST} are needed");
        Err(Error::Incompatible(message))
    })
}
