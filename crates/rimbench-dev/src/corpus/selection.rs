//! Which of the thousands of problems of a run are kept.

use std::ops::Range;

/// Problems of a stretch at most, of which some before the one it is kept for, so that a warm start has a past.
const LENGTH: usize = 16;
const LEAD: usize = 4;
/// Stretches of one solver at most.
const MOST: usize = 6;

/// What is remembered of a problem to choose by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mark {
    /// Contacts.
    pub(super) n: usize,
    /// The set of contacts with an impulse is another than in the problem before.
    pub(super) changed: bool,
    /// `b ≥ 0`: solved by no impulse.
    pub(super) trivial: bool,
    /// The matrix is that of the problem before.
    pub(super) same_matrix: bool,
    /// What the matrix takes in the file.
    pub(super) matrix_bytes: usize,
}

/// Chooses stretches around changes of the active set, evenly spread over all of them, and around problems evenly
/// spread over the run, until `budget` bytes are spent.
///
/// Where the budget is too small for whole stretches they become fewer, then shorter; one problem is always kept unless
/// all of them are trivial. The result is sorted and does not overlap.
pub(super) fn select(marks: &[Mark], budget: usize) -> Vec<Range<usize>> {
    let contacts: Vec<usize> = (0..marks.len()).filter(|&k| !marks[k].trivial).collect();
    let changes: Vec<usize> = contacts.iter().copied().filter(|&k| marks[k].changed).collect();
    let mut length = LENGTH;
    while length > 0 {
        for most in (1..=MOST).rev() {
            // Two thirds at changes, the rest anywhere.
            let at_changes = spread(&changes, (2 * most).div_ceil(3));
            let anywhere = spread(&contacts, most - at_changes.len());
            let stretches = merge(at_changes.chain(anywhere).collect(), length, marks.len());
            let spent: usize = stretches.iter().map(|stretch| bytes(&marks[stretch.clone()])).sum();
            if spent <= budget || (most == 1 && length == 1) {
                return stretches;
            }
        }
        length /= 2;
    }
    Vec::new()
}

/// At most `count` members of a list, evenly spread, the first among them.
fn spread(list: &[usize], count: usize) -> impl ExactSizeIterator<Item = usize> {
    let count = count.min(list.len());
    (0..count).map(move |k| list[k * list.len() / count])
}

/// Stretches of `length` around the anchors, joined where they touch.
fn merge(mut anchors: Vec<usize>, length: usize, end: usize) -> Vec<Range<usize>> {
    anchors.sort_unstable();
    let lead = LEAD * length / LENGTH;
    let mut stretches: Vec<Range<usize>> = Vec::new();
    for anchor in anchors {
        let start = anchor.saturating_sub(lead);
        let stretch = start..(start + length).min(end);
        match stretches.last_mut().filter(|last| stretch.start <= last.end) {
            Some(last) => last.end = last.end.max(stretch.end),
            None => stretches.push(stretch),
        }
    }
    stretches
}

/// What the problems of a stretch take in the file.
fn bytes(marks: &[Mark]) -> usize {
    let matrix = |(k, mark): (usize, &Mark)| if k > 0 && mark.same_matrix { 1 } else { mark.matrix_bytes };
    marks.iter().enumerate().map(|(k, mark)| 2 + matrix((k, mark)) + 8 * mark.n).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run that closes a contact at 100 and changes its active set at 200 and 300.
    fn marks(matrix_bytes: usize) -> Vec<Mark> {
        let mark = |k: usize| Mark {
            n: 4,
            changed: [0, 100, 200, 300].contains(&k),
            trivial: k < 100,
            same_matrix: !k.is_multiple_of(10),
            matrix_bytes,
        };
        (0..1000).map(mark).collect()
    }

    #[test]
    fn every_change_is_kept_with_its_past() {
        let chosen = select(&marks(80), 100_000);
        for change in [100, 200, 300] {
            assert!(chosen.iter().any(|stretch| stretch.contains(&(change - 1)) && stretch.contains(&change)));
        }
        assert!(chosen.last().is_some_and(|stretch| stretch.start > 400), "and some without a change: {chosen:?}");
        assert!(chosen.windows(2).all(|pair| pair[0].end < pair[1].start), "{chosen:?}");
    }

    #[test]
    fn a_budget_is_kept_down_to_one_problem() {
        for budget in [20_000, 2000, 500, 120] {
            let marks = marks(80);
            let chosen = select(&marks, budget);
            let spent: usize = chosen.iter().map(|stretch| bytes(&marks[stretch.clone()])).sum();
            assert!(spent <= budget && spent > 0, "{budget}: {spent}");
        }
        assert_eq!(select(&marks(70_000), 1000).iter().map(ExactSizeIterator::len).sum::<usize>(), 1);
    }

    #[test]
    fn a_run_without_contact_leaves_nothing() {
        assert_eq!(select(&marks(80)[..100], 10_000), []);
        assert_eq!(select(&[], 10_000), []);
    }
}
