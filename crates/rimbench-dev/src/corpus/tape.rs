//! The problems of one solver of one run: first marked, then chosen from.

use super::contact_problem::{Problem, Stretch};
use super::format::{matrix_bytes, same_bits};
use super::selection::{Mark, select};
use std::ops::Range;

/// The problems of one solver: first all of them, marked; then those chosen. `S` is what a solution does at its contacts.
pub(super) struct Tape<const FRICTION: bool, S> {
    marks: Vec<Mark>,
    previous: Option<Problem<FRICTION>>,
    done: Option<S>,
    position: usize,
    chosen: Vec<Range<usize>>,
    kept: Vec<Vec<Problem<FRICTION>>>,
}

impl<const FRICTION: bool, S> Default for Tape<FRICTION, S> {
    fn default() -> Self {
        Tape { marks: Vec::new(), previous: None, done: None, position: 0, chosen: Vec::new(), kept: Vec::new() }
    }
}

impl<const FRICTION: bool, S: PartialEq> Tape<FRICTION, S> {
    /// The problem with the matrix of the one before, if it is the same.
    fn take(&mut self, problem: Problem<FRICTION>) -> (Problem<FRICTION>, bool) {
        match self.previous.take().filter(|previous| same_bits(&previous.h, &problem.h)) {
            Some(previous) => (Problem { h: previous.h, ..problem }, true),
            None => (problem, false),
        }
    }

    /// Marks a problem, with what its solution does.
    pub(super) fn mark(&mut self, problem: Problem<FRICTION>, done: S) {
        let (problem, same_matrix) = self.take(problem);
        let matrix_bytes = match self.marks.last() {
            Some(mark) if same_matrix => mark.matrix_bytes,
            _ => matrix_bytes(&problem.h, problem.unknowns()),
        };
        let (n, trivial) = (problem.unknowns(), problem.is_solved_by_zero());
        let changed = self.done.as_ref() != Some(&done);
        self.marks.push(Mark { n, changed, trivial, same_matrix, matrix_bytes });
        (self.previous, self.done) = (Some(problem), Some(done));
    }

    /// Chooses, and goes back to the start.
    pub(super) fn rewind(&mut self, budget: usize) {
        self.chosen = select(&self.marks, budget);
        self.kept = self.chosen.iter().map(|stretch| Vec::with_capacity(stretch.len())).collect();
        (self.marks, self.previous, self.position) = (Vec::new(), None, 0);
    }

    /// Keeps the problem if it was chosen.
    pub(super) fn keep(&mut self, problem: impl FnOnce() -> Problem<FRICTION>) {
        let position = self.position;
        self.position += 1;
        if let Some(slot) = self.chosen.iter().position(|stretch| stretch.contains(&position)) {
            let (problem, _) = self.take(problem());
            self.kept[slot].push(problem.clone());
            self.previous = Some(problem);
        }
    }

    /// Problems without contact need no solver and are left out; they were marked, so that the choice is one of the run.
    pub(super) fn stretches(self, source: &str) -> Vec<Stretch<FRICTION>> {
        let with_contact = |problem: &Problem<FRICTION>| problem.contacts() > 0;
        let stretch = |(range, problems): (Range<usize>, Vec<Problem<FRICTION>>)| {
            let skipped = problems.iter().position(with_contact)?;
            let problems = problems.into_iter().filter(with_contact).collect();
            Some(Stretch { source: source.to_owned(), first: (range.start + skipped) as u64, problems })
        };
        self.chosen.into_iter().zip(self.kept).filter_map(stretch).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn problems_without_contact_are_left_out_and_the_others_keep_their_place() {
        let mut tape: Tape<false, ()> =
            Tape { chosen: vec![3..8, 9..11], kept: vec![Vec::new(); 2], ..Tape::default() };
        for position in 0..12 {
            let (h, b) = ([1.0], [f64::from(position)]);
            let contacts = usize::from(![3, 4, 6, 9, 10].contains(&position));
            tape.keep(|| Problem { h: h[..contacts].into(), b: b[..contacts].to_vec(), friction: Vec::new() });
        }
        let stretches = tape.stretches("ball");
        let b: Vec<f64> = stretches[0].problems.iter().map(|problem| problem.b[0]).collect();
        assert_eq!((stretches.len(), stretches[0].first, b), (1, 5, vec![5.0, 7.0]));
    }
}
