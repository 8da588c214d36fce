//! Which of many contacts push, found for all of them at once: the guess from which
//! [`SparseActiveSet`](super::SparseActiveSet) goes on.
//!
//! One proximal step of the contact problem, from the impulses `p_0`, is the problem of contacts that give way a
//! little:
//!
//! ```text
//! w = H P + b,   w + μ (P − p_0) ≥ 0 ⟂ P ≥ 0        μ = 1e-4 max H_ii
//! ```
//! Contacts that depend on each other do not trouble it: `H + μ` is regular. Newton's method on the equivalent minimum
//!
//! ```text
//! φ(P) = ½ Pᵀ H P + 1/(2μ) Σ max(0, μ p_0 − w)²
//! ```
//! changes all wrong contacts at once, and goes along each direction as far as φ decreases: φ is convex and made of
//! parabolas, so that the exact minimum takes one pass over the contacts that change on the way. Without that, contacts
//! of a heap throw each other over.
//! # Source
//! Rockafellar, *Monotone operators and the proximal point algorithm*, SIAM J. Control Optim. 14 (1976); the Newton
//! method with the exact search is that of Qi, Sun, *A nonsmooth version of Newton's method*, Math. Programming 58
//! (1993), on a quadratic made of pieces.

use crate::linear_algebra::{SparseFactor, SymmetricPattern, SymmetricRows, largest_entry};

/// μ as a part of the largest entry of the diagonal.
const SOFTNESS: f64 = 1e-4;
/// A guess need not be better than what so many directions give.
const DIRECTIONS: u32 = 40;
/// Up to one in so many contacts enters or leaves the factor by itself, rather than all of it being computed anew.
const ONE_BY_ONE: usize = 8;

/// Below this part of the largest `b`, what a contact has too much or too little is rounding, and changes nothing.
const ROUNDING: f64 = 1e-13;

/// Room to guess in.
#[derive(Debug, Clone)]
pub(super) struct ProximalGuess {
    factor: SparseFactor,
    /// `μ p_0`, the velocities, and by how much the direction changes impulses and velocities.
    centre: Vec<f64>,
    w: Vec<f64>,
    dp: Vec<f64>,
    dw: Vec<f64>,
    /// Where on a direction a contact begins or ends to push, and which.
    bends: Vec<(f64, u32)>,
}

impl ProximalGuess {
    /// Makes room for problems with matrices of this pattern.
    pub(super) fn new(pattern: &SymmetricPattern) -> Self {
        let n = pattern.size();
        ProximalGuess {
            factor: SparseFactor::new(pattern),
            centre: vec![0.0; n],
            w: vec![0.0; n],
            dp: vec![0.0; n],
            dw: vec![0.0; n],
            bends: Vec::with_capacity(n),
        }
    }

    /// Goes over to matrices of another pattern of equal size.
    pub(super) fn change_pattern(&mut self, pattern: &SymmetricPattern) {
        self.factor.change_pattern(pattern);
    }

    /// Writes the impulses of the proximal step from `p_0` to `P`, looked for from the contacts of which `pushes` says
    /// so; returns the number of factorisations.
    pub(super) fn find(
        &mut self,
        h: SymmetricRows<'_>,
        b: &[f64],
        pushes: impl Fn(usize) -> bool,
        p_0: &[f64],
        p: &mut [f64],
    ) -> u32 {
        let n = b.len();
        let mu = SOFTNESS * (0..n).fold(0.0, |most: f64, i| most.max(h.diagonal(i)));
        let rounding = ROUNDING * largest_entry(b);
        let Self { factor, centre, w, dp, dw, .. } = self;
        centre.iter_mut().zip(p_0).for_each(|(centre, p_0)| *centre = mu * p_0);
        factor.factorise(h, mu, 0.0, pushes);
        minimum_of_piece(h, b, centre, factor, p, w);
        let mut factorisations = 1;
        for _ in 0..DIRECTIONS {
            let changes = |factor: &SparseFactor, i: usize| {
                let excess = centre[i] - w[i];
                if factor.contains(i) { excess < -rounding } else { excess > rounding }
            };
            let count = (0..n).filter(|&i| changes(factor, i)).count();
            if count == 0 {
                break;
            }
            if count * ONE_BY_ONE <= n {
                for i in 0..n {
                    if changes(factor, i) {
                        if factor.contains(i) { factor.leave(i) } else { factor.enter(h, i, mu) }
                    }
                }
            } else {
                // Marked beforehand, as the factor cannot be asked for its set while it is replaced.
                dp.iter_mut().enumerate().for_each(|(i, dp)| *dp = f64::from(factor.contains(i) != changes(factor, i)));
                factor.factorise(h, mu, 0.0, |i| dp[i] != 0.0);
                factorisations += 1;
            }
            minimum_of_piece(h, b, centre, factor, dp, dw);
            dp.iter_mut().zip(&*p).for_each(|(dp, p)| *dp -= p);
            dw.iter_mut().zip(&*w).for_each(|(dw, w)| *dw -= w);
            let way = way_to_minimum(&mut self.bends, mu, centre, [p, w, dp, dw]);
            p.iter_mut().zip(&*dp).for_each(|(p, dp)| *p += way * dp);
            w.iter_mut().zip(&*dw).for_each(|(w, dw)| *w += way * dw);
        }
        for (p, (centre, w)) in p.iter_mut().zip(centre.iter().zip(&*w)) {
            let excess = centre - w;
            *p = if excess > rounding { excess / mu } else { 0.0 };
        }
        factorisations
    }
}

/// Writes where φ would be least if the contacts in the factor pushed, and no others: `P = (H + μ)_AA⁻¹ (μ p_0 − b)_A`
/// and `w = H P + b`.
fn minimum_of_piece(
    h: SymmetricRows<'_>,
    b: &[f64],
    centre: &[f64],
    factor: &mut SparseFactor,
    p: &mut [f64],
    w: &mut [f64],
) {
    for (p, (centre, b)) in p.iter_mut().zip(centre.iter().zip(b)) {
        *p = centre - b;
    }
    factor.solve(p);
    w.copy_from_slice(b);
    for (i, &p) in p.iter().enumerate() {
        if p != 0.0 {
            h.add_row(i, p, w);
        }
    }
}

/// The part of a direction up to which φ decreases, at most all of it.
///
/// ```text
/// dφ/ds = P·dw + s dP·dw − 1/μ Σ max(0, c − s dw) dw        c = μ p_0 − w
/// ```
fn way_to_minimum(bends: &mut Vec<(f64, u32)>, mu: f64, centre: &[f64], [p, w, dp, dw]: [&[f64]; 4]) -> f64 {
    let (mut slope, mut rise) = (0.0, 0.0);
    bends.clear();
    for i in 0..centre.len() {
        let (c, dw) = (centre[i] - w[i], dw[i]);
        slope += p[i] * dw;
        rise += dp[i] * dw;
        if c > 0.0 || c == 0.0 && dw < 0.0 {
            slope -= c * dw / mu;
            rise += dw * dw / mu;
        }
        if c * dw > 0.0 && c.abs() < dw.abs() {
            bends.push((c / dw, i as u32));
        }
    }
    bends.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for &(at, i) in &*bends {
        if slope + rise * at >= 0.0 {
            break;
        }
        let (c, dw) = (centre[i as usize] - w[i as usize], dw[i as usize]);
        let sign = if c > 0.0 { 1.0 } else { -1.0 };
        slope += sign * c * dw / mu;
        rise -= sign * dw * dw / mu;
    }
    if slope + rise < 0.0 || rise <= 0.0 { 1.0 } else { (-slope / rise).clamp(0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn a_direction_is_followed_to_where_the_derivative_vanishes_or_to_its_end() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(5);
        let (mu, mut ends) = (0.1, 0);
        for turn in 0..300 {
            let mut draw = || (0..6).map(|_| rng.random_range(-1.0..1.0)).collect::<Vec<f64>>();
            // With H = 1 both change alike.
            let (centre, p, w, mut dw) = (draw(), draw(), draw(), draw());
            let slope = |dw: &[f64], s: f64| -> f64 {
                let of = |i: usize| p[i] + s * dw[i] - (centre[i] - w[i] - s * dw[i]).max(0.0) / mu;
                (0..6).map(|i| of(i) * dw[i]).sum()
            };
            if slope(&dw, 0.0) > 0.0 {
                dw.iter_mut().for_each(|dw| *dw = -*dw);
            }
            let way = way_to_minimum(&mut Vec::new(), mu, &centre, [&p, &w, &dw, &dw]);
            let left = slope(&dw, way);
            ends += usize::from(way == 1.0);
            // Six terms of at most 30, to their rounding.
            assert!(left.abs() < 1e-13 || way == 1.0 && left < 0.0, "{turn}: {left:e} at {way}");
        }
        assert!(ends > 20 && ends < 280, "{ends}");
    }

    /// Contacts of few bodies, so that many depend on each other.
    #[test]
    fn the_guess_is_the_minimum_for_contacts_that_give_way() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(4);
        for (n, coordinates) in [(12, 5), (60, 30), (60, 80)] {
            let pattern = SymmetricPattern::new(&vec![(0..n).collect(); n]);
            let mut guess = ProximalGuess::new(&pattern);
            for _ in 0..20 {
                // One coordinate opens all contacts: no impulse grows beyond bounds as contacts get stiffer.
                let mut row =
                    || (0..coordinates).map(|k| rng.random_range(if k == 0 { 0.3 } else { -1.0 }..1.0)).collect();
                let a: Vec<Vec<f64>> = (0..n).map(|_| row()).collect();
                let dot = |i: usize, j: usize| a[i].iter().zip(&a[j]).map(|(a, b)| a * b).sum::<f64>();
                let entries: Vec<f64> = (0..n * n).map(|at| dot(at / n, at % n)).collect();
                let h = SymmetricRows { pattern: &pattern, entries: &entries };
                let mut draw = |from: f64| (0..n).map(|_| rng.random_range(from..1.0)).collect::<Vec<f64>>();
                let (b, p_0, start) = (draw(-1.0), draw(0.0), draw(-1.0));
                let mut p = vec![0.0; n];
                guess.find(h, &b, |i| start[i] > 0.0, &p_0, &mut p);
                let mu = SOFTNESS * (0..n).fold(0.0, |most: f64, i| most.max(h.diagonal(i)));
                assert!(p.iter().any(|p| *p > 0.0));
                for i in 0..n {
                    let w = b[i] + h.row(i).map(|(j, h)| h * p[j]).sum::<f64>() + mu * (p[i] - p_0[i]);
                    // What counts as rounding of a velocity, through μ in each impulse.
                    let rounding = ROUNDING / mu * h.row(i).map(|(_, h)| h.abs()).sum::<f64>();
                    let holds = p[i] >= 0.0 && w >= -rounding && (p[i] == 0.0 || w <= rounding);
                    assert!(holds && rounding < 1e-6, "{n} {i}: {} and {w:e} beyond {rounding:e}", p[i]);
                }
            }
        }
    }
}
