//! How much a single threshold explains: the baseline of every rule that says from when on something fails.

use crate::by_abscissa;

/// Returns the share of the runs of which one threshold per group says whether they hold: those up to it do, those
/// beyond it do not. Each group has the threshold that is right most often, chosen after the fact; none without runs.
///
/// # Shapes and units
/// Groups of pairs (abscissa in any unit, whether the run holds); what has no finite abscissa is left out.
pub fn share_told_by_threshold(groups: impl IntoIterator<Item = Vec<(f64, bool)>>) -> Option<f64> {
    let (mut right, mut all) = (0, 0);
    for group in groups {
        let points = by_abscissa(group);
        let held = |runs: &[bool]| runs.iter().filter(|holds| **holds).count();
        // With the threshold below all of them, those that fail are told; it takes a point at a time from there.
        let mut told: usize = points.iter().map(|(_, runs)| runs.len() - held(runs)).sum();
        let mut most = told;
        for (_, runs) in &points {
            told = told + held(runs) - (runs.len() - held(runs));
            most = most.max(told);
        }
        right += most;
        all += points.iter().map(|(_, runs)| runs.len()).sum::<usize>();
    }
    (all > 0).then(|| right as f64 / all as f64)
}
