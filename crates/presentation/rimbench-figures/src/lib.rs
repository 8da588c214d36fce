//! From results on disk to figures, tables, numbers in pages and the page of results.
//!
//! This room reads results and never simulates; its toolkit knows nothing of experiments. A figure is described
//! ([`chart::Figure`]), drawn into a display list (`draw()` gives a [`drawing::Drawing`]) and written
//! ([`render::write`]). Equal descriptions give equal bytes.
//!
//! | file | concept |
//! |---|---|
//! | [`style`] | one colour, dash and marker per scheme, everywhere |
//! | [`chart`] | what a chart is: plots with layers, axes, marks and notes, in a grid under one legend |
//! | `figure`, `axes`, `data`, `rows`, `guides`, `legend` | how it is drawn, from the grid of panels to the clipped line or the row |
//! | `scale`, [`ticks`], `clip`, `marker` | value to position, round numbers, edges, signs |
//! | `run_plot` | one run beside its reference |
//! | [`case_picture`] | a case as it says that it looks: every picture of one is drawn from that |
//! | [`film`] | a case in motion: its stills, shown one after the other |
//! | [`days`] | days from seconds |
//! | [`drawing`] | the display list: paths and text on a page |
//! | `vector` | the display list as SVG: true dashes, a named group per series |
//! | `paint`, `dash`, `font` | the display list drawn by plotters as smooth pixels; the embedded typeface |
//! | [`render`] | files: SVG, PNG, PDF |
//!
//! plotters draws the pixels: every shape becomes one of its elements on a drawing area over its bitmap backend,
//! letters are its text in a registered font. What is left to us is layout, because plotters' charts have no band for
//! infinite values, no rows, no legend outside the data and no cutting at the frame, and what its backends lack: dash
//! patterns, and positions and widths between pixels, which a finer grid makes up for; its SVG has neither dashes nor
//! groups, so that is written here.
//!
//! On top of the toolkit stand the figures of the report ([`FigureList`], from `paper/figures.toml`), read from result
//! files by [`ResultsTable`](rimbench_results::results_table::ResultsTable), and the page of a results folder
//! ([`report`]) with the part that simulates (`live_part`).

pub mod case_picture;
pub mod chart;
pub mod days;
pub mod drawing;
pub mod film;
pub mod line_style;
pub mod number;
pub mod render;
pub mod report;
pub mod scheme_picture;
pub mod style;
pub mod ticks;

mod axes;
mod claims_table;
mod clip;
mod dash;
mod data;
mod figure;
mod figures;
mod font;
mod guides;
mod legend;
mod live_part;
mod marker;
mod pages;
mod paint;
mod rows;
mod run_plot;
mod scale;
mod seven_bits;
mod tables;
mod vector;

pub use claims_table::claims_markdown;
pub use figures::{FigureEntry, FigureKind, FigureList, Head, MadeFigures, figure_keys, preview};
pub use pages::{fill_page, has_markers};
pub use run_plot::plot;
pub use tables::TableList;
