//! Semismooth Newton on the natural map, from the impulses of the last problem.

use super::{SpaceProblem, by_axis, of, rows, weights};
use crate::complementarity::SolveStats;
use crate::known_size;
use crate::linear_algebra::{LowRank, eliminate_by_rows, eliminate_few};
use crate::problem::norm;

/// Iterations of one call.
const MOST_ITERATIONS: u32 = 40;
/// Full steps are taken at first, whatever the residual.
const FREE_ITERATIONS: u32 = 3;
/// Iterations that gain less than a tenth, after which it gives up.
const MOST_STALLS: u32 = 3;
/// Halvings of a step that does not lessen the residual.
const MOST_HALVINGS: u32 = 6;
/// Proximal term, in parts of the diagonal: redundant contacts leave the Jacobian singular.
const PROXIMAL: f64 = 1e-9;
/// So many rows for each degree of freedom make the factor of H pay.
const ROWS_PER_RANK: usize = 3;
/// It goes on until the residual is this part of what is accepted.
const WANTED: f64 = 0.1;

/// Newton's method on the natural map of the contacts that are closed, those with `P_n − w_n/H_nn > 0`.
///
/// ```text
/// F_n = w_n / H_nn        F_t = P_t − proj_{|·| ≤ μ P_n}(P_t − w_t / H_tt)        (∂F + ε I) ΔP = −F
/// ```
/// Where H has low rank, as of many feet of one body, `H = L Lᵀ` and only `Lᵀ ΔP` is unknown: without H the Jacobian is
/// one block A per contact, and `∂F = A + B L Lᵀ` has the inverse of Sherman, Morrison and Woodbury.
///
/// In a simulation almost every problem takes one iteration, as it starts from the impulses of the last one.
/// # Source
/// Alart, Curnier, *A mixed formulation for frictional contact problems prone to Newton like solution methods* (1991);
/// proximal term and damping are ours.
#[derive(Debug, Clone, Default)]
pub struct SemismoothNewton {
    /// Impulses of the last problem, N·s.
    pub(super) last: Vec<f64>,
    /// Rows of the last problem.
    pub(super) len: usize,
    jacobian: Vec<f64>,
    step: Vec<f64>,
    row: Vec<f64>,
    w: Vec<f64>,
    trial: Vec<f64>,
    best: Vec<f64>,
    closed: Vec<usize>,
    factor: LowRank,
    /// Whether the factor is that of H, if it was tried.
    pub(super) has_factor: Option<bool>,
    blocks: Vec<Block>,
}

/// The Jacobian of one closed contact.
#[derive(Debug, Clone, Copy)]
struct Block {
    /// What stands before the rows of H: that of the normal row, and of the tangential ones.
    of_h: (f64, [[f64; 2]; 2]),
    /// What is added: `∂F_t / ∂P_n`, and `∂F_t / ∂P_t`; of the normal row the proximal term.
    tangential: ([f64; 2], [[f64; 2]; 2]),
}

impl SemismoothNewton {
    /// Reserves this many contacts.
    pub fn new(contacts: usize) -> Self {
        let mut newton = Self::default();
        newton.grow(3 * contacts);
        newton
    }

    pub(super) fn grow(&mut self, rows: usize) {
        if rows > self.w.len() {
            self.jacobian.resize(rows * rows, 0.0);
            for buffer in [&mut self.last, &mut self.step, &mut self.row, &mut self.w, &mut self.trial, &mut self.best]
            {
                buffer.resize(rows, 0.0);
            }
            self.closed.reserve(rows / 3);
            self.blocks.reserve(rows / 3);
            self.factor.grow(rows, rows / ROWS_PER_RANK);
        }
    }

    /// Sets the impulses from which the next problem starts, N·s.
    pub fn start_from(&mut self, impulses: &[f64]) {
        self.grow(impulses.len());
        self.len = impulses.len();
        self.last[..self.len].copy_from_slice(impulses);
    }

    /// Multiplies the impulses from which the next problem starts, as its step is longer.
    pub fn scale_start(&mut self, factor: f64) {
        for impulse in &mut self.last[..self.len] {
            *impulse *= factor;
        }
    }

    /// Goes on from `impulses` and writes the best found; the stats have its residual, never above that of the start.
    pub fn iterate(&mut self, problem: SpaceProblem<'_>, tolerance: f64, impulses: &mut [f64]) -> SolveStats {
        self.has_factor = None;
        self.iterate_on(problem, tolerance, impulses)
    }

    /// Does so with the factor of H that it has, if any.
    pub(super) fn iterate_on(&mut self, problem: SpaceProblem<'_>, tolerance: f64, impulses: &mut [f64]) -> SolveStats {
        let size = problem.b.len();
        self.grow(size);
        let mut residual = problem.measure(impulses, &mut self.w[..size]);
        // Then so is H: what is not finite reaches w, and the residual.
        let finite = residual.is_finite();
        self.best[..size].copy_from_slice(impulses);
        let (mut best, mut iterations, mut stalls) = (residual, 0, 0);
        while residual > WANTED * tolerance && iterations < MOST_ITERATIONS && stalls < MOST_STALLS {
            iterations += 1;
            self.linearise(problem, impulses);
            if !(if self.is_of_low_rank(problem) { self.step_by_factor(size) } else { self.step_by_rows(problem) }) {
                break;
            }
            let Some(after) = self.search(problem, (residual, finite), iterations <= FREE_ITERATIONS, impulses) else {
                break;
            };
            stalls = if after > 0.9 * residual { stalls + 1 } else { 0 };
            residual = after;
            if residual < best {
                best = residual;
                self.best[..size].copy_from_slice(impulses);
            }
        }
        impulses.copy_from_slice(&self.best[..size]);
        SolveStats { pivots: iterations, factorisations: iterations, residual: best, ..SolveStats::default() }
    }

    /// Takes the step, halved until the residual falls, except a full one that is `free` to raise it; returns the new
    /// residual.
    fn search(
        &mut self,
        problem: SpaceProblem<'_>,
        (residual, finite): (f64, bool),
        free: bool,
        impulses: &mut [f64],
    ) -> Option<f64> {
        let (n, size) = (problem.contacts(), problem.b.len());
        let mut length = 1.0;
        for _ in 0..MOST_HALVINGS {
            // Open contacts go to zero.
            for (trial, impulse) in self.trial.iter_mut().zip(&*impulses) {
                *trial = impulse * (1.0 - length);
            }
            for (&contact, step) in self.closed.iter().zip(self.step.as_chunks::<3>().0) {
                for (row, step) in rows(contact, n).into_iter().zip(step) {
                    self.trial[row] = impulses[row] + length * step;
                }
            }
            let (trial, w) = (&self.trial[..size], &mut self.w[..size]);
            let after = if finite { problem.measure_finite(trial, w) } else { problem.measure(trial, w) };
            if after < residual || (length == 1.0 && free && after.is_finite()) {
                impulses.copy_from_slice(&self.trial[..size]);
                return Some(after);
            }
            length *= 0.5;
        }
        None
    }

    /// Writes what the Jacobian of each closed contact is made of, and the right-hand side.
    fn linearise(&mut self, problem: SpaceProblem<'_>, impulses: &[f64]) {
        let n = problem.contacts();
        let [impulses, velocities] = [impulses, &self.w].map(|vector| by_axis(vector, n));
        self.closed.clear();
        self.blocks.clear();
        for contact in 0..n {
            let (h_nn, h_tt) = weights(problem, contact);
            let [[p_n, p_1, p_2], w] = [impulses, velocities].map(|axes| axes.map(|axis| axis[contact]));
            let pushes = p_n - w[0] / h_nn > 0.0;
            if !pushes {
                continue;
            }
            let mu = problem.cone.friction[contact];
            let ball = Ball::project(mu * if p_n > 0.0 { p_n } else { 0.0 }, [p_1 - w[1] / h_tt, p_2 - w[2] / h_tt]);
            let [[a, b], [c, d]] = ball.derivative;
            self.blocks.push(Block {
                of_h: (h_nn, ball.derivative.map(|line| line.map(|entry| entry / h_tt))),
                tangential: (
                    if p_n > 0.0 { ball.outwards.map(|outwards| -(mu * outwards)) } else { [0.0; 2] },
                    [[(1.0 + PROXIMAL) - a, -b], [-c, (1.0 + PROXIMAL) - d]],
                ),
            });
            let step = [-w[0] / h_nn, ball.projected[0] - p_1, ball.projected[1] - p_2];
            self.step[3 * self.closed.len()..][..3].copy_from_slice(&step);
            self.closed.push(contact);
        }
    }

    /// Solves for the step with all entries of the Jacobian; false if it is singular.
    fn step_by_rows(&mut self, problem: SpaceProblem<'_>) -> bool {
        let (n, size, h) = (problem.contacts(), problem.b.len(), problem.delassus.h);
        let width = 3 * self.closed.len();
        for (slot, (&contact, block)) in self.closed.iter().zip(&self.blocks).enumerate() {
            let [at_n, at_1, at_2] = rows(contact, n).map(|row| by_axis(&h[row * size..(row + 1) * size], n));
            let lines = &mut self.jacobian[3 * slot * width..3 * (slot + 1) * width];
            let (normal, tangential) = lines.split_at_mut(width);
            let (first, second) = tangential.split_at_mut(width);
            let (h_nn, d) = block.of_h;
            let of_others = self.closed.iter().zip(normal.as_chunks_mut::<3>().0);
            let tangential = first.as_chunks_mut::<3>().0.iter_mut().zip(second.as_chunks_mut::<3>().0);
            for ((&other, normal), (first, second)) in of_others.zip(tangential) {
                let [of_n, of_1, of_2] = [at_n, at_1, at_2].map(|line| line.map(|axis| axis[other]));
                for axis in 0..3 {
                    normal[axis] = of_n[axis] / h_nn;
                    first[axis] = d[0][0] * of_1[axis] + d[0][1] * of_2[axis];
                    second[axis] = d[1][0] * of_1[axis] + d[1][1] * of_2[axis];
                }
            }
            normal[3 * slot] += PROXIMAL;
            let (by_normal, by_tangential) = block.tangential;
            for (axis, line) in [first, second].into_iter().enumerate() {
                line[3 * slot] += by_normal[axis];
                line[3 * slot + 1] += by_tangential[axis][0];
                line[3 * slot + 2] += by_tangential[axis][1];
            }
        }
        let (jacobian, step) = (&mut self.jacobian[..width * width], &mut self.step[..width]);
        known_size!(
            width,
            N if N.is_multiple_of(3) => eliminate_few::<N>(jacobian, step),
            _ => eliminate_by_rows(jacobian, step, &mut self.row),
        )
    }

    /// Tells whether the closed contacts have many more rows than H has rank.
    fn is_of_low_rank(&mut self, problem: SpaceProblem<'_>) -> bool {
        let (size, width) = (problem.b.len(), 3 * self.closed.len());
        // With 12 rows or fewer even rank 4 does not pay.
        if width <= 4 * ROWS_PER_RANK {
            return false;
        }
        let factor = &mut self.factor;
        let known =
            *self.has_factor.get_or_insert_with(|| factor.factorise(problem.delassus.h, size, size / ROWS_PER_RANK));
        known && width >= ROWS_PER_RANK * self.factor.rank()
    }

    /// Solves for the step with `Lᵀ ΔP` as unknowns: `(I + Lᵀ A⁻¹ B L) Lᵀ ΔP = Lᵀ A⁻¹ f`; false if that is singular.
    fn step_by_factor(&mut self, size: usize) -> bool {
        let (n, rank, width) = (size / 3, self.factor.rank(), 3 * self.closed.len());
        let (known, rest) = self.jacobian.split_at_mut(rank * width);
        let (matrix, y) = rest[..rank * rank + rank].split_at_mut(rank * rank);
        // Columns of A⁻¹ B L.
        for (column, known) in self.factor.columns(size).zip(known.chunks_exact_mut(width)) {
            for ((&contact, block), known) in self.closed.iter().zip(&self.blocks).zip(known.as_chunks_mut::<3>().0) {
                *known = block.solve(block.times(of(contact, n, column)));
            }
        }
        for (i, column) in self.factor.columns(size).enumerate() {
            let inner = |vector: &[f64]| {
                let pairs = self.closed.iter().zip(vector.as_chunks::<3>().0);
                pairs.fold(0.0, |sum, (&contact, v)| {
                    let l = of(contact, n, column);
                    sum + (l[0] * v[0] + l[1] * v[1] + l[2] * v[2])
                })
            };
            for (j, known) in known.chunks_exact(width).enumerate() {
                matrix[i * rank + j] = inner(known) + if i == j { 1.0 } else { 0.0 };
            }
            let solved = self.row.split_at_mut(width).0;
            for ((block, solved), f) in
                self.blocks.iter().zip(solved.as_chunks_mut::<3>().0).zip(self.step.as_chunks::<3>().0)
            {
                *solved = block.solve(*f);
            }
            y[i] = inner(solved);
        }
        if !eliminate_by_rows(matrix, y, &mut self.row) {
            return false;
        }
        for ((&contact, block), step) in self.closed.iter().zip(&self.blocks).zip(self.step.as_chunks_mut::<3>().0) {
            let mut moved = [0.0; 3];
            for (column, y) in self.factor.columns(size).zip(&*y) {
                let l = of(contact, n, column);
                moved = std::array::from_fn(|axis| moved[axis] + l[axis] * y);
            }
            let by_others = block.times(moved);
            *step = block.solve(std::array::from_fn(|axis| step[axis] - by_others[axis]));
        }
        true
    }
}

impl Block {
    /// Returns `B_i v`.
    #[inline(always)]
    fn times(&self, [n, t1, t2]: [f64; 3]) -> [f64; 3] {
        let (h_nn, d) = self.of_h;
        [n / h_nn, d[0][0] * t1 + d[0][1] * t2, d[1][0] * t1 + d[1][1] * t2]
    }

    /// Returns `A_i⁻¹ v`.
    #[inline(always)]
    fn solve(&self, [n, t1, t2]: [f64; 3]) -> [f64; 3] {
        let (by_normal, [[a, b], [c, d]]) = self.tangential;
        let n = n / PROXIMAL;
        let (t1, t2) = (t1 - by_normal[0] * n, t2 - by_normal[1] * n);
        let determinant = a * d - b * c;
        [n, (d * t1 - b * t2) / determinant, (a * t2 - c * t1) / determinant]
    }
}

/// The projection onto the ball of radius r, its derivative, and that by r.
struct Ball {
    projected: [f64; 2],
    derivative: [[f64; 2]; 2],
    outwards: [f64; 2],
}

impl Ball {
    fn project(radius: f64, point: [f64; 2]) -> Self {
        let length = norm(point);
        if length <= radius && radius > 0.0 {
            return Ball { projected: point, derivative: [[1.0, 0.0], [0.0, 1.0]], outwards: [0.0; 2] };
        }
        if length == 0.0 {
            return Ball { projected: [0.0; 2], derivative: [[0.0; 2]; 2], outwards: [0.0; 2] };
        }
        let [u, v] = point.map(|entry| entry / length);
        let k = radius / length;
        let derivative = [[k * (1.0 - u * u), -k * u * v], [-k * u * v, k * (1.0 - v * v)]];
        Ball { projected: [radius * u, radius * v], derivative, outwards: [u, v] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_halved_until_the_residual_falls_unless_a_full_one_may_raise_it() {
        let h = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let problem = SpaceProblem::with_friction(&h, &[-1.0, 0.0, 0.0], &[0.0]);
        let mut newton = SemismoothNewton::new(1);
        newton.closed.push(0);
        let mut search = |step, free| {
            // 1 solves it, and the residual is the distance from there.
            let mut impulses = [0.5, 0.0, 0.0];
            newton.step[0] = step;
            (newton.search(problem, (0.5, false), free, &mut impulses), impulses[0])
        };
        assert_eq!(search(2.0, true), (Some(1.5), 2.5));
        assert_eq!(search(2.0, false), (Some(0.0), 1.0));
        // What is not finite is no step, and one that leads away has none that helps.
        assert_eq!(search(f64::NAN, true), (None, 0.5));
        assert_eq!(search(-1.0, false), (None, 0.5));
    }

    #[test]
    fn many_feet_of_one_body_are_stepped_by_their_factor_to_where_all_entries_lead() {
        for feet in [6_usize, 16, 40] {
            let size = 3 * feet;
            let row = |row: usize| {
                let angle = (row % feet) as f64 * 6.0 / feet as f64 + 0.4;
                let (y, x) = (libm::sin(angle), libm::cos(angle));
                [[0.0, 0.0, 1.0, y, -x, 0.0], [1.0, 0.0, 0.0, 0.0, -0.8, -y], [0.0, 1.0, 0.0, 0.8, 0.0, x]][row / feet]
            };
            let product = |a: [f64; 6], b: [f64; 6]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let h: Vec<f64> = (0..size * size).map(|k| product(row(k / size), row(k % size))).collect();
            let b: Vec<f64> = (0..size).map(|k| product(row(k), [0.3, 0.1, -1.0, 0.05, 0.1, 0.02])).collect();
            let friction = vec![0.3; feet];
            let problem = SpaceProblem::with_friction(&h, &b, &friction);
            let mut newton = SemismoothNewton::new(feet);
            // Some stick and some slide.
            let impulses: Vec<f64> = (0..size).map(|k| if k < feet { 1.0 / feet as f64 } else { 0.0 }).collect();
            problem.measure(&impulses, &mut newton.w);
            newton.linearise(problem, &impulses);
            assert!(newton.is_of_low_rank(problem) && newton.factor.rank() == 6);
            let start = newton.step.clone();
            assert!(newton.step_by_factor(size));
            let by_factor = std::mem::replace(&mut newton.step, start);
            assert!(newton.step_by_rows(problem));
            for (by_factor, by_rows) in by_factor.iter().zip(&newton.step).take(3 * newton.closed.len()) {
                approx::assert_abs_diff_eq!(by_factor, by_rows, epsilon = 1e-6);
            }
        }
    }
}
