//! How much a single threshold explains: the baseline of every rule that says from when on something fails.

use crate::by_abscissa;

/// Returns the share of the runs of which one threshold per group says whether they hold: those up to it do, those beyond it do not. Each
/// group has the threshold that is right most often, chosen after the fact; none without runs.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_threshold_tells_what_is_in_order_and_half_of_what_is_not() {
        let group =
            |holds: [bool; 4]| holds.into_iter().enumerate().map(|(k, holds)| (k as f64, holds)).collect::<Vec<_>>();
        let share = |groups: &[[bool; 4]]| share_told_by_threshold(groups.iter().copied().map(group));
        assert_eq!(share(&[[true, true, false, false]]), Some(1.0));
        assert_eq!([share(&[[true; 4]]), share(&[[false; 4]])], [Some(1.0); 2]);
        assert_eq!(share(&[[false, false, true, true]]), Some(0.5));
        // Two groups have a threshold each, and one for both is right less often.
        let (early, late) = ([true, false, false, false], [true, true, true, false]);
        assert_eq!(share(&[early, late]), Some(1.0));
        assert_eq!(share_told_by_threshold([[group(early), group(late)].concat()]), Some(0.75));
        assert_eq!(share(&[]), None);
    }
}
