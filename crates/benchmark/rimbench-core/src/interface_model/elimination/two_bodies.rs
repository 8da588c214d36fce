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
        let joint: &[[f64; N]; N_B] = known(eq3.bilateral.of_two_bodies()?)?;
        let [u_1, u_2, u_3, u_4]: &[[f64; N]; N_U] = known(eq3.unilateral.of_two_bodies()?)?;
        let [i_1]: &[[f64; N]; N_I] = known(eq3.interface.of_two_bodies()?)?;
        let rows = [u_1, u_2, u_3, u_4, i_1];
        let inverse_mass = inverse(six(known(mass)?));
        let (mut start, mut free) = (six(known(v)?), product(six(known(&eq3.force)?), inverse_mass));
        *known_mut::<_, N_U>(&mut model.gap)? = *known(&eq3.unilateral.position)?;
        *known_mut::<_, N_I>(&mut model.position)? = *known(&eq3.interface.position)?;

        let a_b = [six(&joint[0]), six(&joint[1])];
        let mut y = [product(a_b[0], inverse_mass), product(a_b[1], inverse_mass)];
        let schur: &mut [f64; N_B * N_B] = known_mut(&mut self.schur.l)?;
        [schur[0], schur[3]] = [dot(y[0], a_b[0]), dot(y[1], a_b[1])];
        schur[2] = dot(y[1], a_b[0]);
        let errors: &[f64; N_B] = known(&eq3.bilateral.position)?;
        let convective: &[f64; N_B] = known(&eq3.bilateral.convective)?;
        let first = dots(a_b[0], start, free) + f64x2::new([gamma * errors[0] / h, convective[0]]);
        let second = dots(a_b[1], start, free) + f64x2::new([gamma * errors[1] / h, convective[1]]);
        if let Err(singular) = self.schur.factor_few::<N_B>("A_b M⁻¹ A_bᵀ") {
            return Some(Err(singular.into()));
        }
        let &[l_00, _, l_10, l_11] = known(&self.schur.l)?;
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
        put(start, known_mut(&mut self.start_velocity)?);
        put(free, known_mut(&mut self.free_acceleration)?);

        let (model_h, model_w, model_a) = (
            known_mut::<_, { ROWS * ROWS }>(&mut model.h)?,
            known_mut::<_, ROWS>(&mut model.w)?,
            known_mut::<_, ROWS>(&mut model.a)?,
        );
        let coupling: &mut [f64; N_B * ROWS] = known_mut(&mut self.coupling)?;
        let g_rows: &mut [[f64; N]; ROWS] = known_mut(self.g_rows.as_chunks_mut().0)?;
        let ([u_1, u_2, u_3, u_4], [i_1]): (&[f64; N_U], &[f64; N_I]) =
            (known(&eq3.unilateral.convective)?, known(&eq3.interface.convective)?);
        let convective = [u_1, u_2, u_3, u_4, i_1];
        let mut g = [[f64x2::ZERO; 3]; ROWS];
        each_row!(ROW => {
            let a = six(rows[ROW]);
            let [w, acceleration] = dots(a, start, free).to_array();
            model_w[ROW] = w;
            model_a[ROW] = acceleration + convective[ROW];
            let [c_0, c_1] = dots(a, y[0], y[1]).to_array();
            [coupling[ROW], coupling[ROWS + ROW]] = [c_0, c_1];
            g[ROW] = less(less(product(a, inverse_mass), c_0, y[0]), c_1, y[1]);
            put(g[ROW], &mut g_rows[ROW]);
            // Only one triangle is computed, so that H is symmetric to the bit.
            for column in (0..=ROW).step_by(2) {
                let next = next_to(column, ROW);
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
        let impulses: &[f64; ROWS] = known(impulses)?;
        let rows: &[[f64; N]; ROWS] = known(self.g_rows.as_chunks().0)?;
        let start = six(known(&self.start_velocity)?);
        let mut next = less(start, -h, six(known(&self.free_acceleration)?));
        for (row, &impulse) in rows.iter().zip(impulses) {
            if impulse != 0.0 {
                next = less(next, -impulse, six(row));
            }
        }
        put(next, known_mut(v)?);
        Some(())
    }
}

/// The next column, if it is not beyond the last.
#[inline(always)]
fn next_to(column: usize, last: usize) -> usize {
    last.min(column + 1)
}

/// As many entries as the compiler knows of; none if there are more or fewer.
#[inline(always)]
fn known<T, const COUNT: usize>(entries: &[T]) -> Option<&[T; COUNT]> {
    entries.try_into().ok()
}

#[inline(always)]
fn known_mut<T, const COUNT: usize>(entries: &mut [T]) -> Option<&mut [T; COUNT]> {
    entries.try_into().ok()
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
