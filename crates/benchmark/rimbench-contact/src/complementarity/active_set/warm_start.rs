//! The usual case of a simulation, for few contacts: the active set of the last problem is that of this one.

use super::{ActiveSet, DEPENDENT, NEGLIGIBLE};
use crate::complementarity::Lcp;
use crate::known_size;

/// Outcome of a start from the last active set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum WarmStart {
    /// `b ≥ 0`: no contact pushes.
    Zero,
    /// Its members push and no other contact closes: solved.
    Confirmed,
    /// Another set, or not looked at; nothing is written.
    Rejected,
}

impl ActiveSet {
    /// Solves the problem if the active set of the last one does, for up to eight contacts of which up to four push.
    ///
    /// `H_AA` is factorised anew each time: for four members that takes less than finding out whether `H` is the matrix
    /// of the last problem. Sizes known to the compiler make it straight-line code on registers. The operations are
    /// those of [`Factor`](crate::linear_algebra::Factor) in its order, so that the digits are its own.
    #[inline(always)]
    pub(super) fn solve_few(&self, lcp: Lcp<'_>, p: &mut [f64]) -> WarmStart {
        let (h, b) = (lcp.h(), lcp.b);
        known_size!(
            b.len(),
            N if N <= 8 => self.of_size::<N>(h, b, p),
            0 => WarmStart::Zero,
            _ => WarmStart::Rejected,
        )
    }

    /// Takes slices one by one, for the problem as one would go through memory.
    #[inline(never)]
    fn of_size<const N: usize>(&self, h: &[f64], b: &[f64], p: &mut [f64]) -> WarmStart {
        let (rows, _) = h.as_chunks::<N>();
        let (Ok(h), Ok(b), Ok(p)) = (rows.try_into(), b.try_into(), p.try_into()) else { return WarmStart::Rejected };
        let (h, b, p): (&[[f64; N]; N], &[f64; N], &mut [f64; N]) = (h, b, p);
        let (mut nonnegative, mut not_finite) = (true, 0.0);
        for b in b {
            nonnegative &= *b >= 0.0;
            not_finite += b * 0.0;
        }
        if nonnegative && not_finite == 0.0 {
            *p = [0.0; N];
            return WarmStart::Zero;
        }
        let confirmed = known_size!(self.len, K if K <= 4 && K <= N => self.confirm::<N, K>(h, b, p), _ => None);
        if confirmed.is_some() { WarmStart::Confirmed } else { WarmStart::Rejected }
    }

    /// Writes the solution on the active set of `K` members if it is one.
    #[inline(always)]
    fn confirm<const N: usize, const K: usize>(&self, h: &[[f64; N]; N], b: &[f64; N], p: &mut [f64; N]) -> Option<()> {
        let set: &[usize; K] = self.set.first_chunk()?;
        let p_a = members(set, h, b)?;
        let mut w = *b;
        for (&p, &a) in p_a.iter().zip(set) {
            for (w, h) in w.iter_mut().zip(&h[a]) {
                *w += h * p;
            }
        }
        let b_max = b.iter().fold(0.0, |max: f64, b| if b.abs() > max { b.abs() } else { max });
        let mut holds = p_a.iter().fold(true, |pushes, p| pushes & (*p >= 0.0));
        for (w, is_active) in w.iter().zip(self.is_active.first_chunk::<N>()?) {
            // Members have w = 0 up to rounding.
            holds &= is_active | (*w >= -NEGLIGIBLE * b_max);
        }
        if !holds {
            return None;
        }
        *p = [0.0; N];
        for (&p_a, &a) in p_a.iter().zip(set) {
            p[a] = p_a;
        }
        Some(())
    }
}

/// `P_A = −H_AA⁻¹ b_A` by `H_AA = L D Lᵀ`; `None` if a member depends on those before it.
#[inline(always)]
fn members<const N: usize, const K: usize>(set: &[usize; K], h: &[[f64; N]; N], b: &[f64; N]) -> Option<[f64; K]> {
    let mut l = [[0.0; K]; K];
    let (mut d_inverse, mut x) = ([0.0; K], [0.0; K]);
    for k in 0..K {
        let row = h.get(set[k])?;
        let (mut y, mut d, mut known) = ([0.0; K], row[set[k]], 0.0);
        let dependent = DEPENDENT * d;
        for i in 0..k {
            let mut done = 0.0;
            for j in 0..i {
                done += l[i][j] * y[j];
            }
            y[i] = row[set[i]] - done;
            l[k][i] = y[i] * d_inverse[i];
            d -= y[i] * l[k][i];
            known += l[k][i] * x[i];
        }
        // The general way reports a NaN.
        if d.is_nan() || d <= dependent {
            return None;
        }
        d_inverse[k] = 1.0 / d;
        x[k] = -b[set[k]] - known;
    }
    for k in (0..K).rev() {
        x[k] *= d_inverse[k];
        for i in k + 1..K {
            x[k] -= l[i][k] * x[i];
        }
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::complementarity::{ComplementaritySolver, SolveStats};

    /// The last contact just touches, with w = 0.
    #[test]
    fn the_last_set_is_confirmed_by_one_factorisation_of_up_to_four_members_and_of_more_by_none() {
        let h: Vec<f64> = (0..64).map(|at| if at % 9 == 0 { 2.0 } else { 0.0 }).collect();
        for members in 1..8 {
            let mut solver = ActiveSet::new(8);
            for (turn, push) in [1.0, 3.0, 5.0].into_iter().enumerate() {
                let b: [f64; 8] = std::array::from_fn(|i| if i < members { -push } else { 0.0 });
                let mut p = [f64::NAN; 8];
                let stats = solver.attempt(Lcp::new(&h, &b), &mut p).unwrap();
                assert_eq!(p, b.map(|b| -0.5 * b));
                if turn > 0 {
                    let factorisations = u32::from(members <= 4);
                    assert_eq!(stats, SolveStats { factorisations, ..SolveStats::default() }, "{members}");
                }
            }
        }
    }
}
