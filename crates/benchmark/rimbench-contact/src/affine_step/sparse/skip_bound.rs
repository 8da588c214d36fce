//! How many micro steps of many contacts need no look at any of them (*conservative advancement*).
//!
//! While the active set stays, each contact follows sums that all contacts have in common:
//!
//! ```text
//! w_k = w_0 + k δâ + Σσ v_r + Σλ v_λ        g_k = g_0 + δ Σ w_j        P_k = p + σ_k p_r + λ_k p_λ
//! ```
//! After a micro step that has looked at all contacts, bounds of these tell of each whether it can leave its state in
//! the K micro steps to come, as long as the force stays within D of the present one, |λ − λ₀| ≤ D, and σ decreases to
//! zero:
//!
//! ```text
//! open     w ≥ w_0 + K min(0, δâ + λ₀ v_λ − D |v_λ| + min(0, σ v_r)),  g likewise          w + t(g) must be ≥ 0
//! active   P ≥ p + λ₀ p_λ − D |p_λ| + min(0, σ p_r)                                          must be ≥ 0
//!          |w + t| ≤ |s_1| + K |s_2 − s_1|   while it is penetrated                          must be rounding
//! ```
//! with s = `w + t`, which changes by a constant amount in each micro step of a penetrated active contact, as `σ`
//! shrinks by `1 − γδ/h`. Contacts for which the bounds do not suffice are looked at in every micro step. The others
//! get velocity and gap once one is needed.

use super::super::{ACCEPTED, AS_LEFT, ActiveSetFactor, AffineStep, StepContactLaw};
use super::SparseSetFactor;

/// D, as a part of the force.
const RANGE: f64 = 0.125;
/// Beyond D it is this many times what went beyond.
const WIDER: f64 = 4.0;
/// With more than one unsafe contact in so many nothing is saved.
const FEW: usize = 8;
/// Fewer micro steps to come are not worth it.
const SHORT: usize = 4;
/// Micro steps that look at every contact between two attempts that were in vain, at most.
const LONGEST_PAUSE: u32 = 32;

/// A contact for which no bound suffices: it is looked at in every micro step.
#[derive(Debug, Clone, Copy)]
struct Unsafe {
    row: u32,
    w: f64,
    next: f64,
    gap: f64,
}

/// The bound on micro steps to come, and the sums over those taken.
#[derive(Debug, Clone)]
pub(super) struct SkipBound {
    /// K, and how many of them have been taken.
    steps: u32,
    taken: u32,
    /// λ₀ and D, N.
    force: f64,
    range: f64,
    /// Σλ and Σσ over the micro steps taken, and the sums of these.
    forces: [f64; 2],
    sigmas: [f64; 2],
    /// Velocities of the contacts at the start.
    w: Vec<f64>,
    unsafe_contacts: Vec<Unsafe>,
    /// Micro steps until the next attempt, and after the next in vain.
    wait: u32,
    pause: u32,
}

impl SkipBound {
    pub(super) fn new(contacts: usize) -> Self {
        SkipBound {
            steps: 0,
            taken: 0,
            force: 0.0,
            range: 0.0,
            forces: [0.0; 2],
            sigmas: [0.0; 2],
            w: vec![0.0; contacts],
            unsafe_contacts: Vec::with_capacity(contacts / FEW + 1),
            wait: 1,
            pause: 1,
        }
    }

    /// Forgets the bound: model or active set have changed.
    pub(super) fn reset(&mut self) {
        (self.steps, self.taken, self.wait, self.pause, self.range) = (0, 0, 1, 1, 0.0);
    }

    /// Tells whether there is a bound.
    #[inline]
    pub(super) fn is_open(&self) -> bool {
        self.steps > 0
    }
}

/// Tangents with respect to the free motion, r, and the force.
fn columns(of: &[f64], rows: usize) -> [&[f64]; 3] {
    [0, 1, 2].map(|at| &of[at * rows..(at + 1) * rows])
}

impl AffineStep<SparseSetFactor> {
    /// Takes a micro step without a look at the contacts, if their bounds still hold; of `w_plus` then only the
    /// interface row, behind those of the contacts, is that at its end.
    pub(in super::super) fn skip_one(
        &mut self,
        law: &StepContactLaw,
        force: f64,
        w: &[f64],
        w_plus: &mut [f64],
    ) -> bool {
        let sigma = self.sigma * self.decay;
        let tolerance = self.tolerance(sigma, &[force]);
        let accepted = self.accepted(tolerance);
        let n = self.rows;
        let many = &mut *self.factor.0;
        let (bound, active) = (&mut many.bound, &many.by_contact.active);
        // A force that is not finite is within no range.
        let within = (force - bound.force).abs() <= bound.range;
        if bound.taken >= bound.steps || !within {
            return false;
        }
        let ([free, of_r, of_force], [p, p_of_r, p_of_force]) =
            (columns(&self.velocities, n + 1), columns(&many.by_contact.impulses, n));
        let velocity = |w: f64, row: usize| w + free[row] + sigma * of_r[row] + force * of_force[row];
        for contact in &mut bound.unsafe_contacts {
            let row = contact.row as usize;
            contact.next = velocity(contact.w, row);
            let slack = contact.next + law.rates.velocity(contact.gap);
            let pulls = || p[row] + sigma * p_of_r[row] + force * p_of_force[row] < 0.0;
            if slack < -accepted || active[row] != 0.0 && (slack.abs() > tolerance || pulls()) {
                return false;
            }
        }
        for contact in &mut bound.unsafe_contacts {
            contact.w = contact.next;
            contact.gap += law.gap_step * contact.next;
        }
        w_plus[n] = velocity(w[n], n);
        bound.taken += 1;
        for (sums, addend) in [(&mut bound.forces, force), (&mut bound.sigmas, sigma)] {
            sums[0] += addend;
            sums[1] += sums[0];
        }
        self.sigma = sigma;
        self.steps += 1;
        true
    }

    /// Ends the skips: velocities and gaps of all contacts are then those after the last micro step.
    #[inline(never)]
    pub(in super::super) fn end_skips(&mut self, law: &StepContactLaw, w: &mut [f64], gap: &mut [f64]) {
        let n = self.rows;
        let many = &mut *self.factor.0;
        let bound = &mut many.bound;
        if bound.taken > 0 {
            let taken = f64::from(bound.taken);
            let ([sum, sums], [sigma, sigmas]) = (bound.forces, bound.sigmas);
            let [free, of_r, of_force] = columns(&self.velocities, n + 1);
            let half = 0.5 * taken * (taken + 1.0);
            for (i, (w, gap)) in w[..n].iter_mut().zip(&mut gap[..n]).enumerate() {
                let start = bound.w[i];
                *w = start + (taken * free[i] + sigma * of_r[i] + sum * of_force[i]);
                *gap += law.gap_step * (taken * start + half * free[i] + sigmas * of_r[i] + sums * of_force[i]);
            }
            for contact in &bound.unsafe_contacts {
                (w[contact.row as usize], gap[contact.row as usize]) = (contact.w, contact.gap);
            }
        }
        (bound.steps, bound.taken) = (0, 0);
    }

    /// Finds the bound for up to `steps` micro steps, after one under the force `lambda` that ended with velocities `w`
    /// and gaps `gap`.
    #[inline(never)]
    pub(in super::super) fn find_bound(
        &mut self,
        law: &StepContactLaw,
        lambda: &[f64],
        steps: usize,
        w: &[f64],
        gap: &[f64],
    ) {
        let &[force] = lambda else { return };
        let (n, decay, sigma) = (self.rows, self.decay, self.sigma);
        let many = &mut *self.factor.0;
        let bound = &mut many.bound;
        bound.wait = bound.wait.saturating_sub(1);
        if bound.wait > 0 || steps < SHORT || law.restitution > 0.0 || !(0.0..=1.0).contains(&decay) || sigma < 0.0 {
            return;
        }
        let beyond = if bound.range > 0.0 { (force - bound.force).abs() } else { 0.0 };
        let range = (RANGE * force.abs()).max(WIDER * beyond);
        (bound.force, bound.range) = (force, range);
        // The tolerance of the smallest force.
        let tolerance =
            SparseSetFactor::NEGLIGIBLE * (self.scales[0] + (force.abs() - range).max(0.0) * self.scales[2]);
        let accepted = ACCEPTED / SparseSetFactor::NEGLIGIBLE * tolerance + AS_LEFT * self.violation_left;
        let (rates, count) = (law.rates, steps as f64);
        let (first, second) = (sigma * decay, sigma * decay * decay);
        let (mut to_come, mut all) = (first, 0.0);
        for _ in 0..steps {
            all += to_come;
            to_come *= decay;
        }
        let ([free, of_r, of_force], [p, p_of_r, p_of_force]) =
            (columns(&self.velocities, n + 1), columns(&many.by_contact.impulses, n));
        bound.unsafe_contacts.clear();
        for i in 0..n {
            let (w, gap) = (w[i], gap[i]);
            let safe = if many.by_contact.active[i] == 0.0 {
                let least = free[i] + force * of_force[i] - range * of_force[i].abs() + (first * of_r[i]).min(0.0);
                let w = w + count * least.min(0.0);
                let gap = gap + count * law.gap_step * w.min(0.0);
                w + rates.velocity(gap) >= -accepted
            } else {
                let impulse = p[i] + force * p_of_force[i] - range * p_of_force[i].abs() + (first * p_of_r[i]).min(0.0);
                let at_end = w + all * of_r[i];
                let off = if gap + count * law.gap_step * w.max(at_end).max(0.0) <= 0.0 {
                    let next = w + first * of_r[i];
                    let change = second * of_r[i] + rates.closed * law.gap_step * next;
                    (next + rates.velocity(gap)).abs() + count * change.abs()
                } else {
                    let w = w.abs().max(at_end.abs());
                    w + rates.open * (gap.abs() + count * law.gap_step * w)
                };
                impulse >= 0.0 && off <= tolerance
            };
            if !safe {
                if (bound.unsafe_contacts.len() + 1) * FEW > n {
                    (bound.wait, bound.pause) = (bound.pause + 1, (2 * bound.pause).min(LONGEST_PAUSE));
                    return;
                }
                bound.unsafe_contacts.push(Unsafe { row: i as u32, w, next: w, gap });
            }
        }
        bound.w.copy_from_slice(&w[..n]);
        (bound.steps, bound.taken, bound.wait) = (steps as u32, 0, 0);
        (bound.forces, bound.sigmas) = ([0.0; 2], [0.0; 2]);
    }
}
