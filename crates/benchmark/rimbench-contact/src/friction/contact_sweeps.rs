//! Gauss–Seidel by contact, in the plane and in space: each contact is solved exactly while the others stand still.

use super::{ContactState, FrictionProblem};
use crate::problem::norm;

/// Bisections of the scalar equation of a contact that slides in space.
const MOST_BISECTIONS: u32 = 100;

/// Non-smooth Gauss–Seidel with an exact solution of each contact, which has T tangential rows.
///
/// Converges linearly, for most problems with few redundant contacts; where these stick near the border of their cones
/// it needs thousands of sweeps.
/// # Source
/// Jourdan, Alart, Jean, *A Gauss–Seidel like algorithm to solve frictional contact problems* (1998); the solution of
/// one contact in space by one scalar equation after Bonnefon, Daviet, *Quartic formulation of Coulomb 3D frictional
/// contact* (2011).
#[derive(Debug, Clone, Default)]
pub struct ContactSweeps<const T: usize = 1> {
    w: Vec<f64>,
}

impl<const T: usize> ContactSweeps<T> {
    /// Reserves this many contacts.
    pub fn new(contacts: usize) -> Self {
        ContactSweeps { w: vec![0.0; (1 + T) * contacts] }
    }

    /// Sweeps from `impulses` until the natural residual is at most `tolerance`, at most `most` times; returns sweeps
    /// and residual.
    pub fn sweep(
        &mut self,
        problem: FrictionProblem<'_, T>,
        tolerance: f64,
        most: u32,
        impulses: &mut [f64],
    ) -> (u32, f64) {
        let (n, size) = (problem.contacts(), problem.b.len());
        if self.w.len() < size {
            self.w.resize(size, 0.0);
        }
        let w = &mut self.w[..size];
        let mut residual = problem.measure(impulses, w);
        for sweep in 0..most {
            if residual <= tolerance {
                return (sweep, residual);
            }
            for contact in 0..n {
                // The entries of the contact, in the plane with a zero for the second tangential row.
                let of = |vector: &[f64]| {
                    std::array::from_fn(|axis| if axis <= T { vector[axis * n + contact] } else { 0.0 })
                };
                let line = |row: usize| of(problem.delassus.row(row));
                let block = std::array::from_fn(|axis| if axis <= T { line(axis * n + contact) } else { [0.0; 3] });
                let (before, velocity): ([f64; 3], [f64; 3]) = (of(impulses), of(w));
                let b = std::array::from_fn(|axis| velocity[axis] - product::<T>(block[axis], before));
                let solve = if T == 1 { in_plane } else { in_space };
                let after = solve(block, b, problem.cone.friction[contact]);
                let change = std::array::from_fn(|axis| after[axis] - before[axis]);
                if change == [0.0; 3] {
                    continue;
                }
                for (row, w) in w.iter_mut().enumerate() {
                    *w += product::<T>(line(row), change);
                }
                for (axis, impulse) in after[..=T].iter().enumerate() {
                    impulses[axis * n + contact] = *impulse;
                }
            }
            residual = problem.measure(impulses, w);
        }
        (most, residual)
    }
}

fn product<const T: usize>(a: [f64; 3], b: [f64; 3]) -> f64 {
    (1..=T).fold(a[0] * b[0], |sum, axis| sum + a[axis] * b[axis])
}

/// Returns the impulses of one contact in the plane exactly: the first of open, stick, slip that holds; without
/// friction if none does.
fn in_plane([[a, x, _], [y, d, _], _]: [[f64; 3]; 3], [b_n, b_t, _]: [f64; 3], mu: f64) -> [f64; 3] {
    if b_n >= 0.0 {
        return [0.0; 3];
    }
    let determinant = a * d - x * y;
    if mu > 0.0 && determinant > 1e-14 * a * d {
        let p = [(x * b_t - d * b_n) / determinant, (y * b_n - a * b_t) / determinant];
        if p[0] >= 0.0 && p[1].abs() <= mu * p[0] {
            return [p[0], p[1], 0.0];
        }
    }
    for slip in [ContactState::SlipPositive, ContactState::SlipNegative].map(ContactState::friction) {
        let friction = slip * mu;
        let push = a + friction * x;
        let p_n = -b_n / push;
        let w_t = (y + friction * d) * p_n + b_t;
        if push > 0.0 && slip * w_t <= 0.0 {
            return [p_n, friction * p_n, 0.0];
        }
    }
    [-b_n / a, 0.0, 0.0]
}

/// Returns the impulses of one contact in space exactly: open, sticking, or sliding with `w_t = −α P_t`, whose `α > 0`
/// is the root of `|P_t(α)| = μ P_n(α)` with `(S + α I) P_t = −c`; S and c are H_tt and b_t with `w_n = 0` eliminated.
fn in_space(h: [[f64; 3]; 3], b: [f64; 3], mu: f64) -> [f64; 3] {
    if b[0] >= 0.0 {
        return [0.0; 3];
    }
    let h_nn = h[0][0];
    if mu <= 0.0 {
        return [-b[0] / h_nn, 0.0, 0.0];
    }
    let s = |i: usize, j: usize| h[i][j] - h[i][0] * h[0][j] / h_nn;
    let (s_11, s_12, s_22) = (s(1, 1), s(1, 2), s(2, 2));
    let c = [b[1] - h[1][0] * b[0] / h_nn, b[2] - h[2][0] * b[0] / h_nn];
    let impulses = |alpha: f64| {
        let (p, r) = (s_11 + alpha, s_22 + alpha);
        let determinant = p * r - s_12 * s_12;
        let t = [(s_12 * c[1] - r * c[0]) / determinant, (s_12 * c[0] - p * c[1]) / determinant];
        [-(b[0] + h[0][1] * t[0] + h[0][2] * t[1]) / h_nn, t[0], t[1]]
    };
    // How far beyond the cone.
    let beyond = |p: [f64; 3]| norm([p[1], p[2]]) - mu * p[0];
    let trace = s_11 + s_22;
    let regular = s_11 * s_22 - s_12 * s_12 > 1e-14 * trace * trace;
    let mut low = if regular { 0.0 } else { 1e-12 * trace };
    let mut at_low = beyond(impulses(low));
    if at_low <= 0.0 {
        return impulses(low);
    }
    let mut high = if trace > 0.0 { trace } else { f64::MIN_POSITIVE };
    let mut at_high = beyond(impulses(high));
    for _ in 0..200 {
        if at_high <= 0.0 {
            break;
        }
        (low, at_low, high) = (high, at_high, 2.0 * high);
        at_high = beyond(impulses(high));
    }
    // Regula falsi with the weights of Illinois.
    let mut last_side = 0;
    for _ in 0..MOST_BISECTIONS {
        let secant = (low * at_high - high * at_low) / (at_high - at_low);
        let alpha = if secant > low && secant < high { secant } else { 0.5 * (low + high) };
        let value = beyond(impulses(alpha));
        if value > 0.0 {
            (low, at_low) = (alpha, value);
            at_high *= if last_side == 1 { 0.5 } else { 1.0 };
            last_side = 1;
        } else {
            (high, at_high) = (alpha, value);
            at_low *= if last_side == -1 { 0.5 } else { 1.0 };
            last_side = -1;
        }
        if value == 0.0 || high - low <= 1e-15 * high {
            break;
        }
    }
    let [n, t_1, t_2] = impulses(high);
    // On the cone to the digit.
    let length = norm([t_1, t_2]);
    let shrink = if length > 0.0 { mu * n / length } else { 0.0 };
    [n, t_1 * shrink, t_2 * shrink]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Its tangential row is the normal one, and it comes to rest along it whatever pushes.
    #[test]
    fn a_contact_of_which_no_state_but_a_slip_can_be_told_takes_the_first_that_holds() {
        let dependent = [[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0; 3]];
        assert_eq!(in_plane(dependent, [-1.0, -1.0, 0.0], 2.0), [1.0 / 3.0, 2.0 / 3.0, 0.0]);
        assert_eq!(in_plane(dependent, [-1.0, -1.0, 0.0], 0.5), [2.0, -1.0, 0.0]);
    }
}
