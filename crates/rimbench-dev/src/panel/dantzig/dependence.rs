//! Contacts that depend on those in `C`, and what rounding makes of them.
//!
//! `v = (−p, 1)` on `C` and `j`, and the same for any other contact `k`:
//!
//! ```text
//! d_j = vᵀ M v ≥ 0                      zero if row j depends on the rows in C
//! s_k² ≤ d_k d_j                        s_k: rate of w_k; Cauchy–Schwarz in the Schur complement of M_CC
//! w_j = vᵀ q                            if d_j = 0: the same for all impulses with w_C = 0
//! ```
//! So a dependent contact stands still while another is driven, and everything stands still while a dependent one is
//! driven: `z` moves along a ray on which only members of `C` block. If none does, `v ≥ 0`, and `w_j < 0` proves that the
//! problem has no solution. If `w_j = 0` there was nothing to drive: that is so whenever `k` and `j` reach zero at once, `k`
//! enters first, and `j` depends on `C` with it. The impulse `j` has got by then is taken back along the ray.
//!
//! # Rounding
//! What is zero is judged by rounding alone. A factorised positive definite `M_CC` solves a system whose entries are off by
//! no more than `γ √(M_ii M_kk)`, `γ = 4 (|C| + 1) ε`; hence
//!
//! ```text
//! d_j is zero below      γ (Σ_i |v_i| √M_ii)²
//! w_j = vᵀ q below       γ (Σ_i |v_i q_i| + Σ_i |v_i| √M_ii Σ_i |z_i| √M_ii)      z: impulses without that of j
//! ```
//! On the committed corpus every `d` is below a tenth of its bound or above 10⁷ times it. What remains unsolved are problems
//! whose impulses are so large that the rounding of `M z` alone exceeds the accepted residual.
//!
//! # Source
//! The pivots: Cottle, Pang, Stone, *The Linear Complementarity Problem* (1992), section 4.2. Rounding: Higham, *Accuracy and
//! Stability of Numerical Algorithms* (2002), theorem 10.4.

use super::{Dantzig, NO_MOTION};
use rimbench_core::complementarity::Lcp;

impl Dantzig {
    /// Relative error of the entries of the system that the factor solves in truth.
    fn gamma(&self) -> f64 {
        4.0 * (self.len + 1) as f64 * f64::EPSILON
    }

    /// The pivot of contact `j` beside `C`, zero if `j` depends on `C`; writes `bordering`.
    pub(super) fn border(&mut self, m: &[f64], j: usize) -> f64 {
        let set = &self.set[..self.len];
        let d = self.factor.border(m, set, j);
        let p = &mut self.bordering[..set.len()];
        self.factor.direction(p);
        self.bordered = j;
        let ray = self.root[j] + set.iter().zip(p).map(|(&k, p)| p.abs() * self.root[k]).sum::<f64>();
        if d > self.gamma() * ray * ray { d } else { 0.0 }
    }

    /// True if `w_j = vᵀ q` of a dependent contact is not negative, as far as rounding can tell.
    pub(super) fn stands_still(&self, lcp: Lcp<'_>, j: usize, z: &[f64]) -> bool {
        let (mut w, mut terms) = (lcp.q[j], lcp.q[j].abs());
        let (mut ray, mut impulses) = (self.root[j], 0.0);
        for (&k, p) in self.set[..self.len].iter().zip(&self.p[..]) {
            w -= p * lcp.q[k];
            terms += (p * lcp.q[k]).abs();
            ray += p.abs() * self.root[k];
            impulses += (z[k] + p * z[j]).abs() * self.root[k];
        }
        w >= -self.gamma() * (terms + ray * impulses)
    }

    /// Takes the impulse of a dependent contact back along its ray; where a member of `C` reaches zero first, `j` takes its
    /// place.
    pub(super) fn take_back(&mut self, m: &[f64], j: usize, z: &mut [f64], pivots: &mut u32) {
        while z[j] > 0.0 {
            let (mut t, mut leaves) = (z[j], None);
            for (position, (&k, &p)) in self.set[..self.len].iter().zip(&self.p[..]).enumerate() {
                if -p * self.root[k] > NO_MOTION * self.root[j] && z[k] < -t * p {
                    (t, leaves) = (-z[k] / p, Some(position));
                }
            }
            *pivots += 1;
            for (&k, p) in self.set[..self.len].iter().zip(&self.p[..]) {
                z[k] = (z[k] + t * p).max(0.0);
            }
            z[j] -= t;
            let Some(position) = leaves else {
                z[j] = 0.0;
                return;
            };
            let k = self.set[position];
            (z[k], self.w[k]) = (0.0, 0.0);
            self.leave(position);
            let d = self.turn_to(m, j);
            if d > 0.0 {
                return self.enter(m, j, d);
            }
        }
    }
}
