//! Semismooth Newton on the natural map, from the impulses of the last problem.

use super::{SpaceProblem, of, rows, weights};
use crate::complementarity::SolveStats;
use crate::known_size;
use crate::linear_algebra::{eliminate_by_rows, eliminate_few};
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
/// It goes on until the residual is this part of what is accepted.
const WANTED: f64 = 0.1;

/// Newton's method on the natural map of the contacts that are closed, those with `P_n − w_n/H_nn > 0`.
///
/// ```text
/// F_n = w_n / H_nn        F_t = P_t − proj_{|·| ≤ μ P_n}(P_t − w_t / H_tt)        (∂F + ε I) ΔP = −F
/// ```
/// In a simulation almost every problem takes one iteration, as it starts from the impulses of the last one.
/// # Source
/// Alart, Curnier, *A mixed formulation for frictional contact problems prone to Newton like solution methods* (1991); proximal term and
/// damping are ours.
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
        let size = problem.b.len();
        self.grow(size);
        let mut residual = problem.measure(impulses, &mut self.w[..size]);
        self.best[..size].copy_from_slice(impulses);
        let (mut best, mut iterations, mut stalls) = (residual, 0, 0);
        while residual > WANTED * tolerance && iterations < MOST_ITERATIONS && stalls < MOST_STALLS {
            iterations += 1;
            let rows = self.linearise(problem, impulses);
            let (jacobian, step) = (&mut self.jacobian[..rows * rows], &mut self.step[..rows]);
            let solved = known_size!(
                rows,
                N if N.is_multiple_of(3) => eliminate_few::<N>(jacobian, step),
                _ => eliminate_by_rows(jacobian, step, &mut self.row),
            );
            if !solved {
                break;
            }
            let Some(after) = self.search(problem, residual, iterations <= FREE_ITERATIONS, impulses) else { break };
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

    /// Takes the step, halved until the residual falls, except a full one that is `free` to raise it; returns the new residual.
    fn search(&mut self, problem: SpaceProblem<'_>, residual: f64, free: bool, impulses: &mut [f64]) -> Option<f64> {
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
            let after = problem.measure(&self.trial[..size], &mut self.w[..size]);
            if after < residual || (length == 1.0 && free && after.is_finite()) {
                impulses.copy_from_slice(&self.trial[..size]);
                return Some(after);
            }
            length *= 0.5;
        }
        None
    }

    /// Writes Jacobian and right-hand side over the closed contacts, three rows each; returns the number of rows.
    fn linearise(&mut self, problem: SpaceProblem<'_>, impulses: &[f64]) -> usize {
        let (n, size, h) = (problem.contacts(), problem.b.len(), problem.delassus.h);
        self.closed.clear();
        for (contact, (p_n, w_n)) in impulses[..n].iter().zip(&self.w).enumerate() {
            if p_n - w_n / weights(problem, contact).0 > 0.0 {
                self.closed.push(contact);
            }
        }
        let width = 3 * self.closed.len();
        for (slot, &contact) in self.closed.iter().enumerate() {
            let (h_nn, h_tt) = weights(problem, contact);
            let [at_n, at_1, at_2] = rows(contact, n).map(|row| &h[row * size..(row + 1) * size]);
            let ([p_n, p_1, p_2], w) = (of(contact, n, impulses), of(contact, n, &self.w));
            let mu = problem.cone.friction[contact];
            let ball = Ball::project(mu * if p_n > 0.0 { p_n } else { 0.0 }, [p_1 - w[1] / h_tt, p_2 - w[2] / h_tt]);
            let lines = &mut self.jacobian[3 * slot * width..3 * (slot + 1) * width];
            let (normal, tangential) = lines.split_at_mut(width);
            let (first, second) = tangential.split_at_mut(width);
            let d = ball.derivative.map(|line| line.map(|entry| entry / h_tt));
            for (at, &other) in self.closed.iter().enumerate() {
                for (axis, column) in rows(other, n).into_iter().enumerate() {
                    normal[3 * at + axis] = at_n[column] / h_nn;
                    first[3 * at + axis] = d[0][0] * at_1[column] + d[0][1] * at_2[column];
                    second[3 * at + axis] = d[1][0] * at_1[column] + d[1][1] * at_2[column];
                }
            }
            normal[3 * slot] += PROXIMAL;
            self.step[3 * slot] = -w[0] / h_nn;
            for (axis, (line, p)) in [first, second].into_iter().zip([p_1, p_2]).enumerate() {
                line[3 * slot + 1] -= ball.derivative[axis][0];
                line[3 * slot + 2] -= ball.derivative[axis][1];
                line[3 * slot + 1 + axis] += 1.0 + PROXIMAL;
                if p_n > 0.0 {
                    line[3 * slot] -= mu * ball.outwards[axis];
                }
                self.step[3 * slot + 1 + axis] = ball.projected[axis] - p;
            }
        }
        width
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
