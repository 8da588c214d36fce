//! From numbers to pictures: charts, stability maps and the manoeuvre drawing, written as SVG and PNG.
//!
//! This room reads results and never simulates; its toolkit knows nothing of experiments. A figure is described
//! ([`chart::Figure`]), drawn into a display list (`draw()` gives a [`drawing::Drawing`]) and written
//! ([`render::write`]). Equal descriptions give equal bytes.
//!
//! | file | concept |
//! |---|---|
//! | [`style`] | one colour, dash and marker per scheme, everywhere |
//! | [`chart`] | what a chart is: panels, axes, series, guides, notes, inset, legend |
//! | `figure`, `panel`, `data`, `guides`, `inset`, `legend` | how a chart is drawn, from the grid of panels to the clipped line |
//! | `scale`, [`ticks`], `clip`, `marker`, `hatch` | value to position, round numbers, edges, signs, shading |
//! | [`heatmap`] | stability maps: scheme × step size |
//! | [`manoeuvre`], `wedge_box` | the wedge box at a row of instants |
//! | [`drawing`] | the display list: paths and text on a page |
//! | `svg`, `raster`, `stroke`, `font` | the display list as SVG and as smooth pixels; the embedded typeface |
//! | [`render`] | files: a temporary name first, then the final one |
//!
//! plotters supplies font rendering and the PNG encoder. Its drawing backends round every corner and line width to
//! whole pixels and know no dashes, which shows in a thin curve; hence the display list.
//!
//! On top of the toolkit stand the figures of the report ([`FigureList`], from `paper/figures.toml`), read from result
//! files by [`ResultsTable`], and the report itself ([`write_report`]).

pub mod chart;
pub mod drawing;
pub mod heatmap;
pub mod manoeuvre;
pub mod render;
pub mod style;
pub mod ticks;

mod claims_table;
mod clip;
mod data;
mod figure;
mod figures;
mod font;
mod guides;
mod hatch;
mod inset;
mod legend;
mod marker;
mod page;
mod panel;
mod raster;
mod results_table;
mod scale;
mod stroke;
mod svg;
mod wedge_box;

pub use claims_table::claims_markdown;
pub use figures::{FigureEntry, FigureKind, FigureList};
pub use page::write_report;
pub use results_table::ResultsTable;
