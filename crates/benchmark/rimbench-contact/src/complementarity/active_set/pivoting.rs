//! Keller's pivots: from the active set at hand to one that solves the problem.

use super::{ActiveSet, DEPENDENT, NEGLIGIBLE, NO_MOTION, RAY_NOISE};
use crate::complementarity::{Lcp, SolveStats, Unsolved};

/// How a drive ended.
enum Drive {
    Completed,
    Unblocked,
    OutOfPivots,
}

impl ActiveSet {
    /// Removes the member at `position`.
    fn drop_member(&mut self, position: usize) {
        self.factor.remove(position);
        self.is_active[self.set[position]] = false;
        self.set.copy_within(position + 1..self.len, position);
        self.p_a.copy_within(position + 1..self.len, position);
        self.forward_known = self.forward_known.min(position);
        self.len -= 1;
        self.age = self.age.map(|age| age + 1);
    }

    /// Computes `P_A = −H_AA⁻¹ b_A`, dropping the most negative member until none is; returns the number dropped.
    #[inline]
    fn make_feasible(&mut self, lcp: Lcp<'_>) -> u32 {
        let mut dropped = 0;
        loop {
            // Forward substitution is repeated only for rows of the factor that have changed.
            let (known, forward) = (self.forward_known, &mut self.forward[..self.len]);
            for (forward, &i) in forward.iter_mut().zip(&self.set[..]).skip(known) {
                *forward = -lcp.b[i];
            }
            self.factor.solve_forward(forward, known);
            self.forward_known = self.len;
            let p_a = &mut self.p_a[..self.len];
            p_a.copy_from_slice(forward);
            self.factor.solve_backward(p_a);
            let (mut worst, mut position) = (0.0, None);
            for (k, &p) in p_a.iter().enumerate() {
                if p < 0.0 {
                    let i = self.set[k];
                    let score = p * p * lcp.h()[i * self.n + i];
                    if position.is_none() || score > worst {
                        (worst, position) = (score, Some(k));
                    }
                }
            }
            let Some(position) = position else { return dropped };
            self.drop_member(position);
            dropped += 1;
        }
    }

    /// Computes `w = H P + b` and picks the contact to take in: the one that promises the largest decrease of the
    /// objective, `w_j²/2M_jj`, or with `bland` the first. Violations within the rounding of `w` do not count.
    #[inline]
    fn most_violated(&mut self, lcp: Lcp<'_>, negligible: f64, bland: bool) -> Option<usize> {
        let n = self.n;
        let w = &mut self.w[..n];
        w.copy_from_slice(lcp.b);
        for (&p, &a) in self.p_a[..self.len].iter().zip(&self.set[..]) {
            if self.rows_read && self.rows.holds() {
                for (j, h) in self.rows.row(a) {
                    w[j] += h * p;
                }
                continue;
            }
            for (w, h) in w.iter_mut().zip(&lcp.h()[a * n..(a + 1) * n]) {
                *w += h * p;
            }
        }
        let mut best: Option<usize> = None;
        for j in 0..n {
            if self.w[j] >= -negligible || self.is_active[j] {
                continue;
            }
            let row = &lcp.h()[j * n..(j + 1) * n];
            if !best.is_none_or(|b| self.w[j].powi(2) * lcp.h()[b * n + b] > self.w[b].powi(2) * row[j]) {
                continue;
            }
            let summed: f64 = self.active_set().iter().zip(&self.p_a[..]).map(|(&a, p)| row[a].abs() * p).sum();
            if self.w[j] >= -negligible - 16.0 * f64::EPSILON * summed {
                continue;
            }
            best = Some(j);
            if bland {
                break;
            }
        }
        best
    }

    /// Raises `P_j` until `w_j = 0`, removing the members that reach zero on the way.
    fn drive(&mut self, lcp: Lcp<'_>, j: usize, pivots: &mut u32, bound: u32) -> Drive {
        let (n, h_jj) = (self.n, lcp.h()[j * self.n + j]);
        let (mut p_j, mut w_j) = (0.0, self.w[j]);
        loop {
            let len = self.len;
            let d = self.factor.border(lcp.h(), &self.set[..len], j);
            self.factor.direction(&mut self.y[..len]);
            let independent = d > DEPENDENT * h_jj;
            let mut t = if independent { -w_j / d } else { f64::INFINITY };
            let mut blocking = None;
            for k in 0..len {
                let (y, a) = (self.y[k], self.set[k]);
                if y > 0.0 && y * y * lcp.h()[a * n + a] > NO_MOTION * h_jj && self.p_a[k] < t * y {
                    (t, blocking) = (self.p_a[k] / y, Some(k));
                }
            }
            if blocking.is_none() && !independent {
                return Drive::Unblocked;
            }
            if *pivots >= bound {
                return Drive::OutOfPivots;
            }
            *pivots += 1;
            for (p, y) in self.p_a[..len].iter_mut().zip(&self.y[..]) {
                *p = (*p - t * y).max(0.0);
            }
            p_j += t;
            match blocking {
                Some(k) => {
                    w_j += t * d.max(0.0);
                    self.drop_member(k);
                }
                None => {
                    self.factor.push(d);
                    self.set[len] = j;
                    self.p_a[len] = p_j;
                    self.is_active[j] = true;
                    self.len += 1;
                    self.age = self.age.map(|age| age + 1);
                    return Drive::Completed;
                }
            }
        }
    }

    /// Pivots from the active set at hand.
    pub(super) fn pivot_to_solution(
        &mut self,
        lcp: Lcp<'_>,
        p: &mut [f64],
        mut stats: SolveStats,
    ) -> Result<SolveStats, Unsolved> {
        let n = self.n;
        self.forward_known = 0;
        let b_max = lcp.b.iter().fold(0.0_f64, |max, b| max.max(b.abs()));
        let (bland_after, bound) = (10 + 5 * n as u32, 50 * n as u32 + (1 << n.min(12)));
        loop {
            stats.pivots += self.make_feasible(lcp);
            let Some(j) = self.most_violated(lcp, NEGLIGIBLE * b_max, stats.pivots > bland_after) else { break };
            match self.drive(lcp, j, &mut stats.pivots, bound) {
                Drive::Completed => {}
                Drive::Unblocked if self.w[j] >= -RAY_NOISE * b_max => break,
                Drive::Unblocked | Drive::OutOfPivots => return Err(self.give_up(p)),
            }
        }
        self.write(p);
        Ok(stats)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::complementarity::ComplementaritySolver;

    #[test]
    fn the_contact_that_promises_the_largest_decrease_enters_and_by_the_rule_of_bland_the_first() {
        let (h, mut solver) = ([4.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 9.0], ActiveSet::new(3));
        solver.resize(3);
        // w²/H is 1 for the first, and 2.25 or 1.21 for the others.
        for (b, largest) in [([-2.0, -1.5, -3.3], 1), ([-2.0, -1.1, -4.5], 2), ([-2.0, -0.9, -2.7], 0)] {
            let lcp = Lcp::new(&h, &b);
            assert_eq!([false, true].map(|bland| solver.most_violated(lcp, 0.0, bland)), [Some(largest), Some(0)]);
        }
    }

    #[test]
    fn a_drive_that_a_member_blocks_goes_on_to_the_solution_of_the_set_that_is_left() {
        let h = [2.0, 0.0, -0.5, 0.0, 2.0, 1.0, -0.5, 1.0, 2.0];
        let mut solver = ActiveSet::new(3);
        solver.attempt(Lcp::new(&h, &[-4.0, -0.2, 10.0]), &mut [0.0; 3]).unwrap();
        let lcp = Lcp::new(&h, &[-4.0, -0.2, -2.1]);
        solver.forward_known = 0;
        assert_eq!((solver.make_feasible(lcp), solver.most_violated(lcp, 0.0, false)), (0, Some(2)));
        let mut pivots = 0;
        assert!(matches!(solver.drive(lcp, 2, &mut pivots, 9), Drive::Completed));
        assert_eq!((pivots, solver.active_set()), (2, &[0, 2][..]));
        let driven = solver.p_a.clone();
        assert_eq!(solver.make_feasible(lcp), 0);
        for (driven, solved) in driven[..2].iter().zip(&solver.p_a[..2]) {
            approx::assert_relative_eq!(driven, solved, max_relative = 1e-14);
        }
    }
}
