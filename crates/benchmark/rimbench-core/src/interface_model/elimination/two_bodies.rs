//! The elimination of two bodies in the plane that a joint holds together, with four contacts and one interface row:
//! the size of the wedge box, straight through, with two numbers in each register. To the last bit what the text for
//! any size gives.

use super::Elimination;
use crate::error::Failure;
use crate::interface_model::{Linearisation, MassMatrix, ReducedInterfaceModel};
use wide::f64x2;

/// Velocities, rows of the joint, of contacts and of the interface, and both.
const N: usize = 6;
const N_B: usize = 2;
const N_U: usize = 4;
const N_I: usize = 1;
const ROWS: usize = N_U + N_I;

/// Numbers of six velocities.
type Six = [f64x2; 3];

/// Does something for each of the rows, one after the other in the text.
macro_rules! each_row {
    ($row:ident => $body:expr) => {
        each_row!($row in 0 1 2 3 4 => $body)
    };
    ($row:ident in $($index:literal)* => $body:expr) => {$({
        const $row: usize = $index;
        $body
    })*};
}

impl Elimination {
    /// Reduces a system of this size; none if it has another.
    #[inline(never)]
    pub(super) fn reduce_two_bodies(
        &mut self,
        eq3: &Linearisation,
        v: &[f64],
        [h, gamma]: [f64; 2],
        model: &mut ReducedInterfaceModel,
    ) -> Option<Result<(), Failure>> {
        let MassMatrix::Diagonal(mass) = &eq3.mass else { return None };
        let (mass, joint) = (mass.as_array()?, eq3.bilateral.of_two_bodies()?.as_array::<N_B>()?);
        let contacts = eq3.unilateral.of_two_bodies()?.as_array::<N_U>()?;
        let interface = eq3.interface.of_two_bodies()?.as_array::<N_I>()?;
        let inverse_mass = inverse(six(mass));
        let (mut start, mut free) = (six(v.as_array()?), product(six(eq3.force.as_array()?), inverse_mass));
        *model.gap.as_mut_array::<N_U>()? = *eq3.unilateral.position.as_array()?;
        *model.position.as_mut_array::<N_I>()? = *eq3.interface.position.as_array()?;

        let a_b = [six(&joint[0]), six(&joint[1])];
        let mut y = [product(a_b[0], inverse_mass), product(a_b[1], inverse_mass)];
        let schur: &mut [f64; N_B * N_B] = self.schur.l.as_mut_array()?;
        [schur[0], schur[3]] = [dot(y[0], a_b[0]), dot(y[1], a_b[1])];
        schur[2] = dot(y[1], a_b[0]);
        let (errors, convective) =
            (eq3.bilateral.position.as_array::<N_B>()?, eq3.bilateral.convective.as_array::<N_B>()?);
        let first = dots(a_b[0], start, free) + f64x2::new([gamma * errors[0] / h, convective[0]]);
        let second = dots(a_b[1], start, free) + f64x2::new([gamma * errors[1] / h, convective[1]]);
        if let Err(singular) = self.schur.factor_few::<N_B>("A_b M⁻¹ A_bᵀ") {
            return Some(Err(singular.into()));
        }
        let &[l_00, _, l_10, l_11] = self.schur.l.as_array()?;
        // s and r beside each other.
        let first = first / f64x2::splat(l_00);
        let second = (second - f64x2::splat(l_10) * first) / f64x2::splat(l_11);
        y[0] = scaled(1.0 / l_00, y[0]);
        y[1] = scaled(1.0 / l_11, less(y[1], l_10, y[0]));
        for (b, both) in [first, second].into_iter().enumerate() {
            let [s, r] = both.to_array();
            start = less(start, s, y[b]);
            free = less(free, r, y[b]);
            (self.joint_start[b], self.joint_free[b]) = (s, r);
        }
        put(start, self.start_velocity.as_mut_array()?);
        put(free, self.free_acceleration.as_mut_array()?);

        let (model_h, model_w, model_a) = (
            model.h.as_mut_array::<{ ROWS * ROWS }>()?,
            model.w.as_mut_array::<ROWS>()?,
            model.a.as_mut_array::<ROWS>()?,
        );
        let coupling: &mut [f64; N_B * ROWS] = self.coupling.as_mut_array()?;
        let g_rows = self.g_rows.as_chunks_mut::<N>().0.as_mut_array::<ROWS>()?;
        let convective = [
            eq3.unilateral.convective.as_array::<N_U>()?.as_slice(),
            eq3.interface.convective.as_array::<N_I>()?.as_slice(),
        ];
        let mut g = [[f64x2::ZERO; 3]; ROWS];
        each_row!(ROW => {
            let a = six(if ROW < N_U { &contacts[ROW] } else { &interface[0] });
            let [w, acceleration] = dots(a, start, free).to_array();
            model_w[ROW] = w;
            model_a[ROW] = acceleration + convective[ROW / N_U][ROW % N_U];
            let [c_0, c_1] = dots(a, y[0], y[1]).to_array();
            [coupling[ROW], coupling[ROWS + ROW]] = [c_0, c_1];
            g[ROW] = less(less(product(a, inverse_mass), c_0, y[0]), c_1, y[1]);
            put(g[ROW], &mut g_rows[ROW]);
            // Only one triangle is computed, so that H is symmetric to the bit.
            for column in (0..=ROW).step_by(2) {
                let next = if column < ROW { column + 1 } else { column };
                let [entry, beside] = dots(a, g[column], g[next]).to_array();
                [model_h[ROW * ROWS + column], model_h[column * ROWS + ROW]] = [entry; 2];
                [model_h[ROW * ROWS + next], model_h[next * ROWS + ROW]] = [beside; 2];
            }
        });
        Some(Ok(()))
    }
}

impl Elimination {
    /// Writes `v⁺` of a system of this size; none if it has another.
    #[inline]
    pub(super) fn velocity_of_two_bodies(&self, h: f64, impulses: &[f64], v: &mut [f64]) -> Option<()> {
        let impulses: &[f64; ROWS] = impulses.as_array()?;
        let rows: &[[f64; N]; ROWS] = self.g_rows.as_chunks().0.as_array()?;
        let start = six(self.start_velocity.as_array()?);
        let mut next = less(start, -h, six(self.free_acceleration.as_array()?));
        for (row, &impulse) in rows.iter().zip(impulses) {
            if impulse != 0.0 {
                next = less(next, -impulse, six(row));
            }
        }
        put(next, v.as_mut_array()?);
        Some(())
    }
}

#[inline(always)]
fn six(of: &[f64; N]) -> Six {
    [f64x2::new([of[0], of[1]]), f64x2::new([of[2], of[3]]), f64x2::new([of[4], of[5]])]
}

#[inline(always)]
fn put(numbers: Six, to: &mut [f64; N]) {
    let [[a, b], [c, d], [e, f]] = [numbers[0].to_array(), numbers[1].to_array(), numbers[2].to_array()];
    *to = [a, b, c, d, e, f];
}

#[inline(always)]
fn inverse(of: Six) -> Six {
    [f64x2::ONE / of[0], f64x2::ONE / of[1], f64x2::ONE / of[2]]
}

#[inline(always)]
fn product(a: Six, b: Six) -> Six {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

#[inline(always)]
fn scaled(factor: f64, x: Six) -> Six {
    product([f64x2::splat(factor); 3], x)
}

/// `target − factor · x`.
#[inline(always)]
fn less(target: Six, factor: f64, x: Six) -> Six {
    let part = scaled(factor, x);
    [target[0] - part[0], target[1] - part[1], target[2] - part[2]]
}

/// The sums of the products in even and in odd places.
#[inline(always)]
fn halves(a: Six, b: Six) -> f64x2 {
    let [first, second, third] = product(a, b);
    first + second + third
}

#[inline(always)]
fn dot(a: Six, b: Six) -> f64 {
    let [even, odd] = halves(a, b).to_array();
    // Zero, so that no sum is −0.
    0.0 + (even + odd)
}

/// `[a·b, a·c]`.
#[inline(always)]
fn dots(a: Six, b: Six, c: Six) -> f64x2 {
    let [even, odd] = f64x2::transpose([halves(a, b), halves(a, c)]);
    f64x2::ZERO + (even + odd)
}
