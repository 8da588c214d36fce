//! Factorisation of a principal submatrix that gains and loses one index at a time.

use super::buffer::Buffer;
use super::dot::dot;

/// `M_AA = L D Lᵀ` for a growing and shrinking list of indices `A`, `L` unit lower triangular.
///
/// ```text
/// append j:  L y = M_Aj    l = D⁻¹ y    d = M_jj − yᵀ l          new last row l, new pivot d
/// remove k:  L₃₃ D₃ L₃₃ᵀ + d_k l_k l_kᵀ                           a positive rank-one change of what follows k
/// ```
/// `d` is the Schur complement of `M_AA`: zero if row `j` depends on the rows in `A`. Nothing is accepted by this
/// type on its own: [`Factor::border`] returns `d` and the caller decides whether to [`Factor::push`] it. It is
/// a Cholesky factor with Givens rotations, but without square roots, which would be half of the work at n = 4.
///
/// A dense `M_AA` faer would factorise faster, 1.8 times at 16 indices and 3.6 times at 128 (`benches/solvers.rs`). But
/// many independent contacts need many bodies, and then few pairs of contacts share one: in those of the cases at most
/// 3 in 10 entries of an active set of 16 or more differ from zero, less than 1 in 10 from 48 on. There the rows'
/// leading zeros, left out here, are worth as much: 1.5 to 3 times faster than faer at 128, at most twice as slow from
/// 16 to 64. And a factor by rows can be taken further by one contact, and tells which of them depend.
///
/// # Source
/// Gill, Golub, Murray, Saunders, *Methods for modifying matrix factorizations*, Math. Comp. 28 (1974), method C1,
/// arranged by rows.
#[derive(Debug, Clone)]
pub struct Factor {
    l: Buffer<f64, 64>,
    d: Buffer<f64, 8>,
    d_inverse: Buffer<f64, 8>,
    y: Buffer<f64, 8>,
    stride: usize,
    len: usize,
}

impl Factor {
    /// Reserves room for `n` indices.
    pub fn new(n: usize) -> Self {
        let vector = || Buffer::new(n);
        Factor { l: Buffer::new(n * n), d: vector(), d_inverse: vector(), y: vector(), stride: n, len: 0 }
    }

    /// Empties the list and makes room for `n` indices.
    pub fn clear(&mut self, n: usize) {
        self.l.grow(n * n);
        self.d.grow(n);
        self.d_inverse.grow(n);
        self.y.grow(n);
        (self.stride, self.len) = (n, 0);
    }

    /// Computes the row that would append index `j` to `set` and returns its pivot `d`, without accepting it.
    ///
    /// `m` is the whole matrix, `stride×stride`; `set` the indices factorised so far, in their order.
    #[inline]
    pub fn border(&mut self, m: &[f64], set: &[usize], j: usize) -> f64 {
        let (stride, len) = (self.stride, self.len);
        let column = &m[j * stride..(j + 1) * stride];
        let (done, rest) = self.l.split_at_mut(len * stride);
        let row = &mut rest[..len];
        let (y, d_inverse) = (&mut self.y[..len], &self.d_inverse[..len]);
        let mut d = column[j];
        // In a pile row j is coupled to few of the others, and y begins with zeros. A multiple of eight, so that the
        // partial sums of the products do not change.
        let first = if len < 8 { 0 } else { set[..len].iter().take_while(|&&i| column[i] == 0.0).count() / 8 * 8 };
        y[..first].fill(0.0);
        row[..first].fill(0.0);
        for k in first..len {
            let y_k = column[set[k]] - dot(&done[k * stride + first..k * stride + k], &y[first..k]);
            y[k] = y_k;
            row[k] = y_k * d_inverse[k];
            d -= y_k * row[k];
        }
        d
    }

    /// Accepts the row of the last [`Factor::border`] with its pivot.
    #[inline]
    pub fn push(&mut self, d: f64) {
        self.d[self.len] = d;
        self.d_inverse[self.len] = 1.0 / d;
        self.len += 1;
    }

    /// Writes `p = M_AA⁻¹ M_Aj` for the index `j` of the last [`Factor::border`].
    pub fn direction(&self, p: &mut [f64]) {
        let start = self.len * self.stride;
        p.copy_from_slice(&self.l[start..start + self.len]);
        self.backward(p);
    }

    /// Replaces `x` by `M_AA⁻¹ x`.
    #[inline]
    pub fn solve(&self, x: &mut [f64]) {
        self.solve_forward(x, 0);
        self.solve_backward(x);
    }

    /// Replaces `x` by `L⁻¹ x`, whose first entries, so many, are there already.
    #[inline]
    pub fn solve_forward(&self, x: &mut [f64], known: usize) {
        for k in known.max(1)..self.len {
            let start = k * self.stride;
            x[k] -= dot(&self.l[start..start + k], &x[..k]);
        }
    }

    /// Replaces `x` by `L⁻ᵀ D⁻¹ x`.
    #[inline]
    pub fn solve_backward(&self, x: &mut [f64]) {
        let l = &self.l[..];
        if self.len < 8 {
            // Entry by entry: vector loads of what was just stored entry by entry would wait for the stores.
            for k in (0..self.len).rev() {
                let mut x_k = x[k] * self.d_inverse[k];
                for i in k + 1..self.len {
                    x_k -= l[i * self.stride + k] * x[i];
                }
                x[k] = x_k;
            }
        } else {
            for (x, d_inverse) in x.iter_mut().zip(&self.d_inverse[..self.len]) {
                *x *= d_inverse;
            }
            self.backward(x);
        }
    }

    /// Replaces `x` by `L⁻ᵀ x`, one row of `L` at a time.
    #[inline]
    fn backward(&self, x: &mut [f64]) {
        let l = &self.l[..];
        for k in (1..self.len).rev() {
            let start = k * self.stride;
            let (head, tail) = x.split_at_mut(k);
            let x_k = tail[0];
            for (x, l) in head.iter_mut().zip(&l[start..start + k]) {
                *x -= l * x_k;
            }
        }
    }

    /// Removes the index at position `k`; later positions move up by one.
    pub fn remove(&mut self, k: usize) {
        let stride = self.stride;
        // alpha vvᵀ is what is still to be added; (v_j, beta_j) of the finished columns are kept in y and d_inverse.
        let mut alpha = self.d[k];
        for r in k + 1..self.len {
            let (above, below) = self.l.split_at_mut(r * stride);
            let (target, row) = (&mut above[(r - 1) * stride..], &below[..r]);
            target[..k].copy_from_slice(&row[..k]);
            let mut v = row[k];
            for j in k + 1..r {
                v -= self.y[j - 1] * row[j];
                target[j - 1] = row[j] + self.d_inverse[j - 1] * v;
            }
            let (old, new) = (self.d[r], self.d[r] + alpha * v * v);
            self.y[r - 1] = v;
            self.d_inverse[r - 1] = alpha * v / new;
            self.d[r - 1] = new;
            alpha *= old / new;
        }
        self.len -= 1;
        for j in k..self.len {
            self.d_inverse[j] = 1.0 / self.d[j];
        }
    }
}
