//! The alternating direction method of multipliers, with De Saxcé's correction inside.

use super::{SpaceProblem, of, rows};
use crate::linear_algebra::{factor_lower, solve_lower};
use crate::problem::norm;

/// Iterations between two looks at the residual.
const LOOK: u32 = 5;
/// Iterations between two looks at the penalty.
const ADAPT: u32 = 20;
/// Factorisations of one call.
const MOST_FACTORS: u32 = 12;

/// Splits the problem into a linear system and projections onto the cones:
///
/// ```text
/// (H + ρ I) x = ρ z − y − b − s(y)        z = proj_K(x + y/ρ)        y += ρ (x − z)        s_n = μ |y_t|
/// ```
/// At the end `y = −(w + s)`. Slow, but redundant contacts that stick on the border of their cones, where sweeps stall,
/// do not stop it.
/// # Source
/// Boyd et al., *Distributed optimization and statistical learning via the alternating direction method of multipliers*
/// (2011); the correction inside the loop as in Carpentier et al., *From compliant to rigid contact simulation* (2024).
#[derive(Debug, Clone, Default)]
pub struct SpaceAdmm {
    factor: Vec<f64>,
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    w: Vec<f64>,
}

impl SpaceAdmm {
    /// Reserves this many contacts.
    pub fn new(contacts: usize) -> Self {
        let mut admm = Self::default();
        admm.grow(3 * contacts);
        admm
    }

    fn grow(&mut self, rows: usize) {
        if rows > self.x.len() {
            self.factor.resize(rows * rows, 0.0);
            for buffer in [&mut self.x, &mut self.y, &mut self.z, &mut self.w] {
                buffer.resize(rows, 0.0);
            }
        }
    }

    /// Iterates from `impulses` until the natural residual is at most `tolerance`, at most `most` times; returns
    /// iterations, factorisations and residual.
    pub fn iterate(
        &mut self,
        problem: SpaceProblem<'_>,
        tolerance: f64,
        most: u32,
        impulses: &mut [f64],
    ) -> (u32, u32, f64) {
        let (n, size, friction) = (problem.contacts(), problem.b.len(), problem.cone.friction);
        self.grow(size);
        let Self { factor, x, y, z, w } = self;
        let (x, y, z, w) = (&mut x[..size], &mut y[..size], &mut z[..size], &mut w[..size]);
        let mut residual = problem.measure(impulses, w);
        let mean = (0..size).map(|row| problem.delassus.h[row * size + row]).sum::<f64>() / size as f64;
        let mut rho = 0.3 * mean;
        let mut factors = 0;
        let mut refactor = |rho: f64, factor: &mut [f64]| {
            factors += 1;
            factor[..size * size].copy_from_slice(problem.delassus.h);
            (0..size).for_each(|row| factor[row * size + row] += rho);
            if factor_lower(&mut factor[..size * size], size).is_ok() { Some(factors) } else { None }
        };
        let Some(mut made) = refactor(rho, factor) else { return (0, 1, residual) };
        z.copy_from_slice(impulses);
        for (y, w) in y.iter_mut().zip(&*w) {
            *y = -w;
        }
        for contact in 0..n {
            y[contact] -= friction[contact] * norm([w[n + contact], w[2 * n + contact]]);
        }
        for iteration in 1..=most {
            for row in 0..size {
                x[row] = rho * z[row] - y[row] - problem.b[row];
            }
            for contact in 0..n {
                x[contact] -= friction[contact] * norm([y[n + contact], y[2 * n + contact]]);
            }
            solve_lower(&factor[..size * size], size, x);
            let (mut primal, mut dual) = (0.0_f64, 0.0_f64);
            for (contact, mu) in friction.iter().enumerate() {
                let (ours, multipliers) = (of(contact, n, x), of(contact, n, y));
                let point = std::array::from_fn(|axis| ours[axis] + multipliers[axis] / rho);
                let projected = project(*mu, point);
                for (axis, row) in rows(contact, n).into_iter().enumerate() {
                    dual = dual.max((projected[axis] - z[row]).abs());
                    z[row] = projected[axis];
                    primal = primal.max((x[row] - z[row]).abs());
                    y[row] += rho * (x[row] - z[row]);
                }
            }
            if iteration % LOOK == 0 {
                residual = problem.measure(z, w);
                if residual <= tolerance || iteration == most {
                    impulses.copy_from_slice(z);
                    return (iteration, made, residual);
                }
            }
            if iteration % ADAPT == 0 && made < MOST_FACTORS {
                let ratio = (primal / dual.max(f64::MIN_POSITIVE)).sqrt();
                if !(0.33..=3.0).contains(&ratio) {
                    rho *= ratio.clamp(0.1, 10.0);
                    let Some(now) = refactor(rho, factor) else { break };
                    made = now;
                }
            }
        }
        impulses.copy_from_slice(z);
        (most, made, problem.measure(z, w))
    }
}

/// Returns the nearest point of `|P_t| ≤ μ P_n`.
fn project(mu: f64, [n, t_1, t_2]: [f64; 3]) -> [f64; 3] {
    let length = norm([t_1, t_2]);
    if length <= mu * n {
        return [n, t_1, t_2];
    }
    if mu * length <= -n {
        return [0.0; 3];
    }
    let normal = (n + mu * length) / (1.0 + mu * mu);
    [normal, mu * normal * t_1 / length, mu * normal * t_2 / length]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_ends_at_the_first_look_at_the_residual_that_finds_it_accepted() {
        let h = [1.0, 0.2, 0.1, 0.2, 2.0, 0.3, 0.1, 0.3, 3.0];
        let problem = SpaceProblem::with_friction(&h, &[-1.0, 2.0, 0.5], &[0.3]);
        let mut admm = SpaceAdmm::new(1);
        let mut iterate = |most| admm.iterate(problem, 1e-9, most, &mut [0.0; 3]);
        let (iterations, _, residual) = iterate(1000);
        assert!(iterations < 1000 && iterations.is_multiple_of(LOOK) && residual <= 1e-9, "{iterations}");
        let (before, _, residual) = iterate(iterations - LOOK);
        assert!(before == iterations - LOOK && residual > 1e-9, "{residual:e}");
    }
}
