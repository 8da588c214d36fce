//! How many micro steps of many contacts go by without any of them being looked at.
//!
//! While the active set stays the same, a contact follows sums that all contacts have in common:
//!
//! ```text
//! w_k = w_0 + k δâ + Σσ v_r + Σλ v_λ        g_k = g_0 + δ Σ w_j        P_k = p + σ_k p_r + λ_k p_λ
//! ```
//! After a micro step that has looked at all of them, bounds of these say of each whether it can do anything in the K micro steps to
//! come, as long as the force stays within D of the present one, |λ − λ₀| ≤ D, and σ decreases to zero:
//!
//! ```text
//! open     w ≥ w_0 + K min(0, δâ + λ₀ v_λ − D |v_λ| + min(0, σ v_r)),  g likewise          w + t(g) must be ≥ 0
//! member   P ≥ p + λ₀ p_λ − D |p_λ| + min(0, σ p_r)                                          must be ≥ 0
//!          |w + t| ≤ |s_1| + K |s_2 − s_1|   while it is penetrated                          must be rounding
//! ```
//! s being `w + t`, which of a penetrated member changes by the same in each micro step, as `σ` shrinks by `1 − γδ/h`. Contacts for which
//! bounds do not suffice are watched: looked at in every micro step. The others get velocity and gap once one is needed.

use super::{GapMotion, ParametricStep, SetFactor};

/// D, as a part of the force.
const RANGE: f64 = 0.125;
/// Beyond D it is this many times what went beyond.
const WIDER: f64 = 4.0;
/// With more than one in so many contacts to be watched nothing is saved.
const FEW: usize = 8;
/// Fewer micro steps to come are not worth it.
const SHORT: usize = 4;
/// Micro steps that look at every contact between two attempts that were in vain, at most.
const LONGEST_PAUSE: u32 = 32;

/// A contact that is looked at in every micro step.
#[derive(Debug, Clone, Copy)]
struct Watched {
    contact: u32,
    w: f64,
    next: f64,
    gap: f64,
}

/// What has been found out about the micro steps to come, and what has become of it.
#[derive(Debug, Clone)]
pub(super) struct Outlook {
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
    watched: Vec<Watched>,
    /// Micro steps until the next attempt, and after the next in vain.
    wait: u32,
    pause: u32,
}

impl Outlook {
    pub(super) fn new(contacts: usize) -> Self {
        Outlook {
            steps: 0,
            taken: 0,
            force: 0.0,
            range: 0.0,
            forces: [0.0; 2],
            sigmas: [0.0; 2],
            w: vec![0.0; contacts],
            watched: Vec::with_capacity(contacts / FEW + 1),
            wait: 1,
            pause: 1,
        }
    }

    /// Says that model or active set are others.
    pub(super) fn forget(&mut self) {
        (self.steps, self.taken, self.wait, self.pause, self.range) = (0, 0, 1, 1, 0.0);
    }
}

/// Columns of what an impulse or a velocity is made of: of the free motion, of r, of the force.
fn columns(of: &[f64], rows: usize) -> [&[f64]; 3] {
    [0, 1, 2].map(|at| &of[at * rows..(at + 1) * rows])
}

impl ParametricStep {
    /// Tells whether there is an outlook.
    #[inline]
    pub(in super::super) fn looks_ahead(&self) -> bool {
        if let SetFactor::Sparse(many) = &self.factor { many.outlook.steps > 0 } else { false }
    }

    /// Takes a micro step by the outlook, if it still holds: of `next` then only the interface row, behind those of the contacts, is
    /// that at its end.
    pub(in super::super) fn go_on(&mut self, motion: &GapMotion, force: f64, w: &[f64], next: &mut [f64]) -> bool {
        let sigma = self.factor_of_r * self.decay;
        let tolerance = self.tolerance_with(sigma, &[force]);
        let accepted = self.accepted(tolerance);
        let n = self.contacts;
        let SetFactor::Sparse(many) = &mut self.factor else { return false };
        let (outlook, member) = (&mut many.outlook, &many.member);
        // A force that is not finite is within no range.
        let within = (force - outlook.force).abs() <= outlook.range;
        if outlook.taken >= outlook.steps || !within {
            return false;
        }
        let ([free, of_r, of_force], [p, p_of_r, p_of_force]) =
            (columns(&self.velocities, n + 1), columns(&many.impulses, n));
        let velocity = |w: f64, row: usize| w + free[row] + sigma * of_r[row] + force * of_force[row];
        for watched in &mut outlook.watched {
            let row = watched.contact as usize;
            watched.next = velocity(watched.w, row);
            let slack = watched.next + motion.rates.velocity(watched.gap);
            let pulls = || p[row] + sigma * p_of_r[row] + force * p_of_force[row] < 0.0;
            if slack < -accepted || member[row] != 0.0 && (slack.abs() > tolerance || pulls()) {
                return false;
            }
        }
        for watched in &mut outlook.watched {
            watched.w = watched.next;
            watched.gap += motion.advance * watched.next;
        }
        next[n] = velocity(w[n], n);
        outlook.taken += 1;
        for (sums, addend) in [(&mut outlook.forces, force), (&mut outlook.sigmas, sigma)] {
            sums[0] += addend;
            sums[1] += sums[0];
        }
        self.factor_of_r = sigma;
        self.steps += 1;
        true
    }

    /// Ends the outlook: velocities and gaps of all contacts are then those after the last micro step.
    #[inline(never)]
    pub(in super::super) fn catch_up(&mut self, motion: &GapMotion, w: &mut [f64], gap: &mut [f64]) {
        let n = self.contacts;
        let SetFactor::Sparse(many) = &mut self.factor else { return };
        let outlook = &mut many.outlook;
        if outlook.taken > 0 {
            let taken = f64::from(outlook.taken);
            let ([sum, sums], [sigma, sigmas]) = (outlook.forces, outlook.sigmas);
            let [free, of_r, of_force] = columns(&self.velocities, n + 1);
            let half = 0.5 * taken * (taken + 1.0);
            for (i, (w, gap)) in w[..n].iter_mut().zip(&mut gap[..n]).enumerate() {
                let start = outlook.w[i];
                *w = start + (taken * free[i] + sigma * of_r[i] + sum * of_force[i]);
                *gap += motion.advance * (taken * start + half * free[i] + sigmas * of_r[i] + sums * of_force[i]);
            }
            for watched in &outlook.watched {
                (w[watched.contact as usize], gap[watched.contact as usize]) = (watched.w, watched.gap);
            }
        }
        (outlook.steps, outlook.taken) = (0, 0);
    }

    /// Looks for an outlook over up to `steps` micro steps, after one under the force `lambda` that ended with velocities `w` and gaps
    /// `gap`.
    #[inline(never)]
    pub(in super::super) fn look_ahead(
        &mut self,
        motion: &GapMotion,
        lambda: &[f64],
        steps: usize,
        w: &[f64],
        gap: &[f64],
    ) {
        let &[force] = lambda else { return };
        let (n, decay, sigma) = (self.contacts, self.decay, self.factor_of_r);
        let SetFactor::Sparse(many) = &mut self.factor else { return };
        let outlook = &mut many.outlook;
        outlook.wait = outlook.wait.saturating_sub(1);
        if outlook.wait > 0 || steps < SHORT || motion.restitution > 0.0 || !(0.0..=1.0).contains(&decay) || sigma < 0.0
        {
            return;
        }
        let beyond = if outlook.range > 0.0 { (force - outlook.force).abs() } else { 0.0 };
        let range = (RANGE * force.abs()).max(WIDER * beyond);
        (outlook.force, outlook.range) = (force, range);
        // That of the smallest force.
        let tolerance = self.negligible * (self.scales[0] + (force.abs() - range).max(0.0) * self.scales[2]);
        let accepted = self.accepted * tolerance + super::AS_LEFT * self.left;
        let (rates, count) = (motion.rates, steps as f64);
        let (first, second) = (sigma * decay, sigma * decay * decay);
        let (mut to_come, mut all) = (first, 0.0);
        for _ in 0..steps {
            all += to_come;
            to_come *= decay;
        }
        let ([free, of_r, of_force], [p, p_of_r, p_of_force]) =
            (columns(&self.velocities, n + 1), columns(&many.impulses, n));
        outlook.watched.clear();
        for i in 0..n {
            let (w, gap) = (w[i], gap[i]);
            let safe = if many.member[i] == 0.0 {
                let least = free[i] + force * of_force[i] - range * of_force[i].abs() + (first * of_r[i]).min(0.0);
                let w = w + count * least.min(0.0);
                let gap = gap + count * motion.advance * w.min(0.0);
                w + rates.velocity(gap) >= -accepted
            } else {
                let impulse = p[i] + force * p_of_force[i] - range * p_of_force[i].abs() + (first * p_of_r[i]).min(0.0);
                let at_end = w + all * of_r[i];
                let off = if gap + count * motion.advance * w.max(at_end).max(0.0) <= 0.0 {
                    let next = w + first * of_r[i];
                    let change = second * of_r[i] + rates.closed * motion.advance * next;
                    (next + rates.velocity(gap)).abs() + count * change.abs()
                } else {
                    let w = w.abs().max(at_end.abs());
                    w + rates.open * (gap.abs() + count * motion.advance * w)
                };
                impulse >= 0.0 && off <= tolerance
            };
            if !safe {
                if (outlook.watched.len() + 1) * FEW > n {
                    (outlook.wait, outlook.pause) = (outlook.pause + 1, (2 * outlook.pause).min(LONGEST_PAUSE));
                    return;
                }
                outlook.watched.push(Watched { contact: i as u32, w, next: w, gap });
            }
        }
        outlook.w.copy_from_slice(&w[..n]);
        (outlook.steps, outlook.taken, outlook.wait) = (steps as u32, 0, 0);
        (outlook.forces, outlook.sigmas) = ([0.0; 2], [0.0; 2]);
    }
}
