//! What criterion needs to draw its figures where the system has no fonts.

use criterion::Criterion;
use plotters::style::{FontStyle, register_font};

/// Criterion as it comes, with the typeface of this project under the family that its figures ask for.
pub fn criterion_with_typeface() -> Criterion {
    let regular = include_bytes!("../../crates/rimbench-figures/src/font/Inter-Regular.otf");
    assert!(register_font("sans-serif", FontStyle::Normal, regular).is_ok(), "the typeface is an OpenType file");
    Criterion::default()
}
