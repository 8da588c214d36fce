//! Keller's pivots for many contacts of which few are coupled: the method of [`ActiveSet`](super::ActiveSet) on a
//! sparse factor.
//!
//! Unlike the dense one, the factor keeps one order for all sets, so that a contact enters or leaves by a change along
//! its path in the elimination tree; several enter one after the other before velocities are computed anew; whatever
//! would push with the wrong sign after a change of the matrix leaves at once, as long as it is not by far less than
//! the worst; and every answer is measured here by the natural residual. An answer that is not good enough is looked
//! for once more with the set factorised anew, then from the empty set.
//!
//! Where many contacts change at once, and in the first problem, pivots one by one are many. Then a [`ProximalGuess`]
//! tells which contacts push. More may push than can be told apart; of those that depend on others each hands its
//! impulse over to them, along a ray on which no velocity changes, until it has none or another one has none and leaves
//! in its place. From there it goes on as ever.

use super::active_set::{DEPENDENT, NEGLIGIBLE, NO_MOTION, RAY_NOISE};
use super::proximal_guess::ProximalGuess;
use super::{Checked, ProposeImpulses, SolveStats, SparseLcp, Unsolved};
use crate::linear_algebra::{SparseFactor, SymmetricPattern, SymmetricRows, largest_entry};
use crate::problem::Signorini;

/// Members that pull by at least this part of the worst (squared) leave together.
const TOGETHER: f64 = 0.1;
/// Contacts that promise at least this part of the best enter one after the other, before velocities are computed anew.
const ENTER: f64 = 0.5;
/// Changes of the factor before it is computed anew: a change takes a thirtieth of the time and less, and answers are
/// measured.
const REFRESH: u32 = 512;
/// More than one in so many contacts that pull or go too far are too many to be changed one by one. With fewer, in the
/// hard micro steps of a heap, handing impulses over takes what the guess has saved.
const MANY_WRONG: usize = 4;
/// Of the contacts that a guess lets push, what is left of a row when the others are taken out of it must be more than
/// this: a guess is not exact, and those that can hardly be told apart would make thousands of newtons of what is
/// missing.
const NEARLY_DEPENDENT: f64 = 1e-7;

/// With at most so many wrong contacts a set is changed as it is: a factor of another one takes as long as dozens of
/// changes.
const FEW_WRONG: usize = 8;

/// Where the next problem stands in its series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Series {
    /// The first.
    Starts,
    /// The second.
    GoesOn,
    /// A later one, or there is no series.
    Goes,
}

/// Solves contact problems whose matrix has a fixed pattern, from the set of the last one.
#[derive(Debug, Clone)]
pub struct SparseActiveSet {
    factor: SparseFactor,
    /// Changes since the factor was computed; `None` if it is not that of the last matrix.
    age: Option<u32>,
    /// The contacts that push.
    set: Vec<usize>,
    /// The set of the first problem of a series.
    first_set: Vec<usize>,
    /// The set of the last problem of the series before.
    last_set: Vec<usize>,
    /// Of two sets for one problem, the one that it is not looked for from.
    alternative: Vec<usize>,
    /// Where the next problem stands in its series.
    next: Series,
    /// Contacts that may enter.
    violated: Vec<u32>,
    /// `b + H P`, by contacts, m/s.
    w: Vec<f64>,
    /// The direction of a drive, by positions in the factor; or marks, by contacts.
    y: Vec<f64>,
    last_answer: Vec<f64>,
    guess: ProximalGuess,
    /// Whether it has been asked for the present problem.
    guessed: bool,
    /// How many there were, the present one included.
    problems: u64,
}

/// [`SparseActiveSet`] behind the check; it starts from the empty set where its answer is not good enough.
pub type SparseSolver = Checked<SparseActiveSet>;

impl SparseSolver {
    /// Makes room for problems with matrices of this pattern; answers are accepted up to this natural residual.
    pub fn new(pattern: &SymmetricPattern, tolerance: f64) -> Self {
        Checked::wrap(SparseActiveSet::new(pattern), (), tolerance)
    }
}

impl SparseActiveSet {
    /// Makes room for problems with matrices of this pattern.
    pub fn new(pattern: &SymmetricPattern) -> Self {
        let n = pattern.size();
        SparseActiveSet {
            guess: ProximalGuess::new(pattern),
            guessed: false,
            factor: SparseFactor::new(pattern),
            age: None,
            set: Vec::with_capacity(n),
            first_set: Vec::with_capacity(n),
            last_set: Vec::with_capacity(n),
            alternative: Vec::with_capacity(n),
            next: Series::Goes,
            violated: Vec::with_capacity(n),
            w: vec![0.0; n],
            y: vec![0.0; n],
            last_answer: vec![0.0; n],
            problems: 0,
        }
    }

    /// Returns the factor of the last set.
    pub fn factor(&self) -> &SparseFactor {
        &self.factor
    }

    /// Returns `w = H P + b` of the last problem, m/s.
    pub fn velocities(&self) -> &[f64] {
        &self.w
    }

    /// Goes over to matrices of another pattern for as many contacts. Those that pushed in the last problems still are
    /// what the next one is looked for from.
    pub fn change_pattern(&mut self, pattern: &SymmetricPattern) {
        self.factor.change_pattern(pattern);
        self.guess.change_pattern(pattern);
        self.age = None;
    }

    /// Says that the next matrix may be another.
    pub fn forget_matrix(&mut self) {
        self.age = None;
    }

    /// Says that a series of problems with another matrix starts, the first like the first of the last series and the
    /// others like the last of it: each is looked for from the set of the one that it is like, unless that fits badly
    /// and the other one fits better.
    pub fn start_series(&mut self) {
        match self.next {
            Series::Starts => {}
            Series::GoesOn => {
                self.first_set.clone_from(&self.set);
                self.last_set.clone_from(&self.set);
            }
            Series::Goes => {
                std::mem::swap(&mut self.set, &mut self.last_set);
                self.set.clone_from(&self.first_set);
            }
        }
        self.next = Series::Starts;
        self.age = None;
    }

    /// Takes the set that the next problem is looked for from; says whether there is another one for it.
    fn go_on(&mut self) -> bool {
        match self.next {
            Series::Goes => return false,
            Series::Starts => self.next = Series::GoesOn,
            Series::GoesOn => {
                self.next = Series::Goes;
                self.first_set.clone_from(&self.set);
            }
        }
        if self.last_set.is_empty() || self.is_last_set() {
            return false;
        }
        self.alternative.clone_from(&self.last_set);
        if self.next == Series::Goes {
            std::mem::swap(&mut self.set, &mut self.alternative);
            self.age = None;
        }
        true
    }

    /// Whether the set at hand is the last one of the series before.
    fn is_last_set(&mut self) -> bool {
        let Self { set, last_set, y, .. } = self;
        y.fill(0.0);
        set.iter().for_each(|&contact| y[contact] = 1.0);
        set.len() == last_set.len() && last_set.iter().all(|&contact| y[contact] == 1.0)
    }

    /// Takes the other set if many contacts are wrong with the one at hand, and fewer with that; says whether none is,
    /// so that `P` is the answer.
    fn take_closer(&mut self, h: SymmetricRows<'_>, b: &[f64], p: &mut [f64], stats: &mut SolveStats) -> bool {
        let wrong = self.count_wrong(h, b, p, stats);
        if wrong <= FEW_WRONG {
            return wrong == 0;
        }
        std::mem::swap(&mut self.set, &mut self.alternative);
        self.age = None;
        let with_other = self.count_wrong(h, b, p, stats);
        if with_other >= wrong {
            std::mem::swap(&mut self.set, &mut self.alternative);
            self.age = None;
        }
        with_other == 0
    }

    /// Counts the contacts that pull or go too far if those of the set push, and no others.
    fn count_wrong(&mut self, h: SymmetricRows<'_>, b: &[f64], p: &mut [f64], stats: &mut SolveStats) -> usize {
        self.factorise(h, stats);
        self.impulses_of_set(b, p);
        self.compute_velocities_of_others(h, b, p);
        let negligible = NEGLIGIBLE * largest_entry(b);
        let fits = |i: usize| if self.factor.contains(i) { p[i] >= 0.0 } else { self.w[i] >= -negligible };
        // What is not a number fits nowhere.
        let is_wrong = |&i: &usize| !fits(i);
        (0..b.len()).filter(is_wrong).count()
    }

    /// Writes `P_A = −H_AA⁻¹ b_A`.
    fn impulses_of_set(&mut self, b: &[f64], p: &mut [f64]) {
        for (p, b) in p.iter_mut().zip(b) {
            *p = -b;
        }
        self.factor.solve(p);
    }

    /// Pivots from the set at hand; `stats` get the residual of the answer.
    fn attempt(&mut self, problem: SparseLcp<'_>, tolerance: f64, p: &mut [f64], stats: &mut SolveStats) {
        let found = self.pivot(problem.delassus, problem.b, p, stats).is_ok();
        self.measure(problem, found, tolerance, p, stats);
    }

    /// Measures an answer, and keeps a good one for guesses.
    fn measure(&mut self, problem: SparseLcp<'_>, found: bool, tolerance: f64, p: &[f64], stats: &mut SolveStats) {
        let residual = self.residual(problem, p);
        stats.residual = if found { residual } else { f64::INFINITY };
        if stats.residual <= tolerance {
            self.last_answer.copy_from_slice(p);
        }
    }

    /// The natural residual, with `w` computed anew from problem and answer.
    fn residual(&mut self, problem: SparseLcp<'_>, p: &[f64]) -> f64 {
        self.compute_velocities(problem.delassus, problem.b, p);
        problem.residual_of(p, |row| self.w[row])
    }

    fn compute_velocities(&mut self, h: SymmetricRows<'_>, b: &[f64], p: &[f64]) {
        self.w.copy_from_slice(b);
        for (i, &p) in p.iter().enumerate() {
            if p != 0.0 {
                h.add_row(i, p, &mut self.w);
            }
        }
    }

    /// Writes `w` of the contacts that are not in the set; that of the others is zero up to rounding.
    fn compute_velocities_of_others(&mut self, h: SymmetricRows<'_>, b: &[f64], p: &[f64]) {
        // Columns of few members are less than rows of many others.
        if 2 * self.set.len() < b.len() {
            return self.compute_velocities(h, b, p);
        }
        for (i, w) in self.w.iter_mut().enumerate() {
            if !self.factor.contains(i) {
                *w = velocity_of(h, b, p, i);
            }
        }
    }

    /// Brings the factor to matrix and set; members that depend on others are left out. Says whether it had to.
    fn factorise(&mut self, h: SymmetricRows<'_>, stats: &mut SolveStats) -> bool {
        let anew = self.age.is_none_or(|age| age >= REFRESH);
        if anew {
            self.factorise_independent(h, DEPENDENT, stats);
        }
        anew
    }

    /// Factorises the matrix of the set anew, without the members whose pivot is at most `dependent` times their
    /// diagonal.
    fn factorise_independent(&mut self, h: SymmetricRows<'_>, dependent: f64, stats: &mut SolveStats) {
        let Self { factor, set, y, .. } = self;
        y.fill(0.0);
        set.iter().for_each(|&i| y[i] = 1.0);
        factor.factorise(h, 0.0, dependent, |i| y[i] != 0.0);
        set.retain(|&i| factor.contains(i));
        self.age = Some(0);
        stats.factorisations += 1;
    }

    fn changed(&mut self) {
        self.age = self.age.map(|age| age + 1);
    }

    /// Writes `P_A = −H_AA⁻¹ b_A` of a set without pulling members: those at hand but for what has to leave.
    fn make_feasible(&mut self, h: SymmetricRows<'_>, b: &[f64], p: &mut [f64], stats: &mut SolveStats) {
        loop {
            self.impulses_of_set(b, p);
            let pull = |i: usize| if p[i] < 0.0 { p[i] * p[i] * h.diagonal(i) } else { 0.0 };
            let (mut worst, mut pulling) = (0.0_f64, 0);
            for &i in &self.set {
                worst = worst.max(pull(i));
                pulling += usize::from(p[i] < 0.0);
            }
            if worst == 0.0 {
                return;
            }
            if pulling * MANY_WRONG > b.len() && !self.guessed {
                self.start_from_proximal(h, b, p, stats);
                continue;
            }
            let Self { factor, set, .. } = self;
            let before = set.len();
            set.retain(|&i| {
                let leaves = pull(i) >= TOGETHER * worst;
                if leaves {
                    factor.leave(i);
                }
                !leaves
            });
            let left = (before - self.set.len()) as u32;
            stats.pivots += left;
            self.age = self.age.map(|age| age + left);
        }
    }

    fn pivot(
        &mut self,
        h: SymmetricRows<'_>,
        b: &[f64],
        p: &mut [f64],
        stats: &mut SolveStats,
    ) -> Result<(), Unsolved> {
        let n = b.len();
        let b_max = largest_entry(b);
        let (bland_after, bound) = (stats.pivots + 10 + 5 * n as u32, stats.pivots + 50 * n as u32);
        // Whether the impulses are solved for the set, and whether by updates of an earlier solution.
        let (mut solved, mut changed) = (false, false);
        loop {
            if self.factorise(h, stats) || !solved {
                self.make_feasible(h, b, p, stats);
                (solved, changed) = (true, false);
            }
            self.compute_velocities_of_others(h, b, p);
            let (negligible, bland) = (NEGLIGIBLE * b_max, stats.pivots > bland_after);
            let Some(least) = self.list_violated(h, p, negligible, bland) else {
                if !changed {
                    return Ok(());
                }
                // Solve from scratch: updates add up rounding.
                solved = false;
                continue;
            };
            // Of the first problem nothing is known. Where contacts of a wall hold all others few go too far at first,
            // and in the end most of them.
            let knows_nothing = self.problems == 1 && self.set.is_empty();
            if !self.guessed && (knows_nothing || self.violated.len() * MANY_WRONG > n) {
                self.start_from_proximal(h, b, p, stats);
                solved = false;
                continue;
            }
            let (mut entered, mut at) = (false, 0);
            while let Some(&j) = self.violated.get(at) {
                let j = j as usize;
                at += 1;
                if self.age.is_none_or(|age| age >= REFRESH) {
                    break;
                }
                if self.factor.contains(j) {
                    continue;
                }
                // A contact that entered in this round has changed the velocity.
                let w_j = if entered { velocity_of(h, b, p, j) } else { self.w[j] };
                if w_j >= -negligible || w_j * w_j < least * h.diagonal(j) {
                    continue;
                }
                self.w[j] = w_j;
                changed = true;
                if self.drive(h, p, j, stats, bound)? {
                    entered = true;
                    // Bland's rule is one contact at a time.
                    if !bland {
                        self.list_neighbours(h, j);
                    }
                } else if !entered {
                    return if w_j >= -RAY_NOISE * b_max {
                        Ok(())
                    } else {
                        Err(Unsolved::NotFound { residual: f64::INFINITY })
                    };
                } else {
                    solved = false;
                    break;
                }
            }
        }
    }

    /// Lists what is coupled to a contact that has entered: a blow goes on from one to the next.
    fn list_neighbours(&mut self, h: SymmetricRows<'_>, j: usize) {
        for (i, _) in h.row(j) {
            // There is room for as many as there are contacts.
            if !self.factor.contains(i) && self.violated.len() < self.y.len() {
                self.violated.push(i as u32);
            }
        }
    }

    /// Goes over to the contacts that push as far as a guess can tell, without those that depend on others.
    fn start_from_proximal(&mut self, h: SymmetricRows<'_>, b: &[f64], p: &mut [f64], stats: &mut SolveStats) {
        self.guessed = true;
        let Self { guess, factor, last_answer, .. } = self;
        stats.factorisations += guess.find(h, b, |i| factor.contains(i), last_answer, p);
        self.set.clear();
        self.set.extend((0..b.len()).filter(|&i| p[i] > 0.0));
        self.violated.clear();
        self.violated.extend(self.set.iter().map(|&i| i as u32));
        self.factorise_independent(h, NEARLY_DEPENDENT, stats);
        for at in 0..self.violated.len() {
            let j = self.violated[at] as usize;
            if !self.factor.contains(j) && p[j] > 0.0 {
                self.exchange_dependent(h, p, j);
                stats.pivots += 1;
            }
        }
    }

    /// Lowers `P_j` of a contact that depends on the members, which take over what it carries, until it or one of them
    /// carries nothing.
    fn exchange_dependent(&mut self, h: SymmetricRows<'_>, p: &mut [f64], j: usize) {
        self.factor.response(h, j, &mut self.y);
        let (mut t, mut blocking) = (p[j], None);
        for (slot, &i) in self.set.iter().enumerate() {
            let y = self.y[self.factor.position(i)];
            if y < 0.0 && y * y * h.diagonal(i) > NO_MOTION * h.diagonal(j) && p[i] < -t * y {
                (t, blocking) = (-p[i] / y, Some(slot));
            }
        }
        for &i in &self.set {
            p[i] = (p[i] + t * self.y[self.factor.position(i)]).max(0.0);
        }
        p[j] -= t;
        match blocking {
            None => p[j] = 0.0,
            Some(slot) => {
                let left = self.set.swap_remove(slot);
                self.factor.leave(left);
                self.factor.enter(h, j, 0.0);
                self.set.push(j);
                self.changed();
                self.changed();
            }
        }
    }

    /// Lists the contacts that go further than they may, those first that promise the largest decrease of the
    /// objective, `w²/m`, and returns what they must promise to enter together with the first; with `bland` only the
    /// first of all contacts is listed. Violations within the rounding of `w` do not count.
    fn list_violated(&mut self, h: SymmetricRows<'_>, p: &[f64], negligible: f64, bland: bool) -> Option<f64> {
        let Self { violated, w, factor, .. } = self;
        violated.clear();
        for (j, &w) in w.iter().enumerate() {
            if w >= -negligible || factor.contains(j) {
                continue;
            }
            let summed: f64 = h.row(j).map(|(i, h)| h.abs() * p[i]).sum();
            if w >= -negligible - 16.0 * f64::EPSILON * summed {
                continue;
            }
            violated.push(j as u32);
            if bland {
                return Some(0.0);
            }
        }
        let promise = |j: u32| w[j as usize] * w[j as usize] / h.diagonal(j as usize);
        violated.sort_unstable_by(|&a, &b| promise(b).total_cmp(&promise(a)).then(a.cmp(&b)));
        violated.first().map(|&j| ENTER * promise(j))
    }

    /// Raises `P_j` until `w_j = 0`, removing the members that reach zero on the way; false if nothing stops it.
    fn drive(
        &mut self,
        h: SymmetricRows<'_>,
        p: &mut [f64],
        j: usize,
        stats: &mut SolveStats,
        bound: u32,
    ) -> Result<bool, Unsolved> {
        let (h_jj, mut w_j) = (h.diagonal(j), self.w[j]);
        loop {
            let Self { factor, y, .. } = self;
            factor.response(h, j, y);
            let d = h_jj - h.row(j).map(|(i, entry)| entry * y[factor.position(i)]).sum::<f64>();
            let independent = d > DEPENDENT * h_jj;
            // After a tie w_j may be above zero, by rounding.
            let mut t = if independent { (-w_j / d).max(0.0) } else { f64::INFINITY };
            let mut blocking = None;
            // Of others than members it is zero. Where y is not positive nothing is less than its multiple, and no
            // second question is asked: its sign is as good as random.
            for (&y, &i) in y.iter().zip(factor.rows_in_order()) {
                let i = i as usize;
                if p[i] < t * y && y * y * h.diagonal(i) > NO_MOTION * h_jj {
                    (t, blocking) = (p[i] / y, Some(i));
                }
            }
            if blocking.is_none() && !independent {
                return Ok(false);
            }
            if stats.pivots >= bound {
                return Err(Unsolved::NotFound { residual: f64::INFINITY });
            }
            stats.pivots += 1;
            for (&y, &i) in self.y.iter().zip(self.factor.rows_in_order()) {
                let less = p[i as usize] - t * y;
                p[i as usize] = if less > 0.0 { less } else { 0.0 };
            }
            p[j] += t;
            self.changed();
            match blocking {
                Some(left) => {
                    w_j += t * d.max(0.0);
                    self.set.retain(|&member| member != left);
                    self.factor.leave(left);
                    p[left] = 0.0;
                }
                None => {
                    self.factor.enter(h, j, 0.0);
                    self.set.push(j);
                    return Ok(true);
                }
            }
        }
    }
}

/// `w_i = b_i + H_i· P`.
fn velocity_of(h: SymmetricRows<'_>, b: &[f64], p: &[f64], i: usize) -> f64 {
    b[i] + h.row(i).map(|(j, entry)| entry * p[j]).sum::<f64>()
}

impl ProposeImpulses for SparseActiveSet {
    type Delassus<'a> = SymmetricRows<'a>;
    type Cone<'a> = Signorini;
    type Fallback = ();

    fn propose(
        &mut self,
        problem: SparseLcp<'_>,
        same_matrix: bool,
        tolerance: f64,
        p: &mut [f64],
    ) -> Result<SolveStats, Unsolved> {
        let (h, b) = (problem.delassus, problem.b);
        self.problems += 1;
        if !same_matrix {
            self.age = None;
        }
        let mut stats = SolveStats::default();
        let by_zero = problem.is_solved_by_zero()?;
        let has_other = self.go_on();
        if by_zero {
            p.fill(0.0);
            self.w.copy_from_slice(b);
            return Ok(stats);
        }
        self.guessed = false;
        if has_other && self.take_closer(h, b, p, &mut stats) {
            self.measure(problem, true, tolerance, p, &mut stats);
        } else {
            self.attempt(problem, tolerance, p, &mut stats);
        }
        if stats.residual > tolerance {
            // Changes of the factor add up rounding.
            self.age = None;
            self.attempt(problem, tolerance, p, &mut stats);
        }
        Ok(stats)
    }

    /// Looks for an answer from the empty set, contact by contact.
    fn fall_back(
        &mut self,
        (): &mut (),
        turn: u32,
        problem: SparseLcp<'_>,
        tolerance: f64,
        impulses: &mut [f64],
    ) -> Option<Result<SolveStats, Unsolved>> {
        (turn == 0).then(|| {
            let mut stats = SolveStats::default();
            self.reset();
            self.guessed = true;
            self.attempt(problem, tolerance, impulses, &mut stats);
            Ok(stats)
        })
    }

    fn reset(&mut self) {
        self.set.clear();
        self.age = None;
    }
}

#[cfg(test)]
mod tests;
