//! What may be asked, as it is typed.

use crate::grid::logarithmic_grid;
use crate::stability::{longest_macro_step, possible_steps, shortest_macro_step};
use rimbench_core::error::{Error, Result};
use rimbench_runs::RunRequest;
use rimbench_runs::catalogue::Catalogue;

/// Spreads macro steps (s) evenly in logarithms, of as few digits as keep them apart; the ends are those of a scan
/// unless they are given. Sides that take multiples of a step are offered multiples of it.
///
/// # Errors
/// An unknown case, ends that are none, or beyond the duration.
pub fn steps_to_try(
    catalogue: &Catalogue,
    fixed: &RunRequest,
    [from, to]: [Option<f64>; 2],
    per_decade: usize,
) -> Result<Vec<f64>> {
    let usual = catalogue.case(fixed.case.as_deref().unwrap_or_default())?.defaults.duration_s;
    let duration = fixed.duration_s.unwrap_or(usual);
    let to = to.unwrap_or_else(|| longest_macro_step(duration));
    if to > duration {
        return Err(Error::invalid("to", to, format!("at most the duration, {duration} s")));
    }
    let from = from.unwrap_or_else(|| shortest_macro_step(to));
    let digits = if per_decade <= 12 { 1 } else { 4 };
    let short = |step: f64| format!("{step:.digits$e}").parse().unwrap_or(step).clamp(from, to);
    let mut rounded: Vec<f64> = logarithmic_grid(from, to, per_decade)?.into_iter().map(short).collect();
    rounded.dedup();
    possible_steps(catalogue, fixed, rounded, [from, to])
}

/// Reads `1%` or `0.01`; a number without the sign is below 1, because `1` may mean either.
///
/// # Errors
/// What is no share above 0.
pub fn share_of_peak(text: &str) -> Result<f64> {
    let (number, unit) = text.trim().strip_suffix('%').map_or((text.trim(), 1.0), |number| (number.trim(), 0.01));
    let number: Option<f64> = number.parse().ok().map(|number: f64| number * unit);
    let most = if unit < 1.0 { 1.0 } else { 1.0_f64.next_down() };
    number.filter(|share| *share > 0.0 && *share <= most).ok_or_else(|| {
        let expected = "a share of the peak force above 0, as `1%` (at most `100%`) or as a number below 1, 0.01";
        Error::invalid("error", text, expected)
    })
}
