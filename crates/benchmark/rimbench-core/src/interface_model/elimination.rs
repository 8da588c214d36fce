//! From Eq. 3 to Eq. 4: velocities and bilateral impulses are eliminated once, and can be recovered afterwards.

mod two_bodies;
mod two_in_space;

use super::linearisation::{Linearisation, MassMatrix};
use super::local_elimination::LocalElimination;
use super::reduced_interface_model::ReducedInterfaceModel;
use crate::error::{Cause, Failure};
use rimbench_contact::linear_algebra::{Cholesky, SymmetricPattern};
use std::ops::Range;
use std::sync::Arc;

/// Eliminates velocities and bilateral impulses, leaving the model at the interface; then maps impulses back.
///
/// ```text
/// S   = A_b M⁻¹ A_bᵀ = L Lᵀ        Y = L⁻¹ A_b M⁻¹         G = M⁻¹ − M⁻¹ A_bᵀ S⁻¹ A_b M⁻¹ = M⁻¹ − Yᵀ Y
/// v̂   = v − Yᵀ s                   s = L⁻¹ (A_b v + γ g_b / h)       start velocity, consistent with the joints
/// α   = M⁻¹ f − Yᵀ r               r = L⁻¹ (A_b M⁻¹ f + Ȧ_b v)       free acceleration
/// C_x = A_x Yᵀ                     G A_xᵀ = M⁻¹ A_xᵀ − Yᵀ C_xᵀ
/// H_xy = A_x G A_yᵀ     w_x = A_x v̂     a_x = A_x α + Ȧ_x v          x, y ∈ {u, i}
/// v⁺  = v̂ + h α + G A_uᵀ P_u + G A_iᵀ h λ_i          P_b = −L⁻ᵀ (s + h r + C_uᵀ P_u + C_iᵀ h λ_i)
/// ```
/// With friction there are tangential rows between the two, handled alike.
///
/// With `Y` no row needs a solve of its own: two products with `n_b` rows replace forward and backward substitution.
///
/// Rows are handled in blocks of `L` velocities, `L` known to the compiler: 3 is a planar body, and a row has few of
/// the bodies in its support, so that other blocks are skipped; one or two bodies are a single block, unrolled, three
/// times as fast as loops of unknown length; any other system has blocks of 1. One text serves all but the wedge boxes
/// in the plane and in space, whose sizes are written out in `two_bodies` and `two_in_space`, to the same bits.
/// # Shapes and units
/// `M` n×n (kg); `A_x` n_x×n; `H_xy` n_x×n_y (1/kg); `w_x` (m/s); `a_x` (m/s²).
/// # Errors
/// [`Cause::Singular`] if the bilateral rows are dependent. Dependent unilateral rows are allowed.
/// # Source
/// Raoofian, Kövecses, Teichmann, Eqs. 3–4; the joint drift term `γ g_b / h` is ours.
#[derive(Debug, Clone)]
pub struct Elimination {
    velocities: usize,
    bilateral: usize,
    rows: usize,
    mass_factor: Option<Cholesky>,
    /// `M⁻¹` where it is diagonal: one division per velocity instead of one per entry of `A`.
    inverse_mass: Vec<f64>,
    schur: Cholesky,
    /// `Y`, n_b×n.
    y: Vec<f64>,
    /// In place of all that follows, where `H_uu` is sparse.
    local: Option<LocalElimination>,
    /// `G A_xᵀ`, transposed; (n_u+n_i)×n.
    g_rows: Vec<f64>,
    /// `C_xᵀ`, n_b×(n_u+n_i).
    coupling: Vec<f64>,
    /// Blocks between the first and the last that is not zero, row by row.
    supports: Vec<Range<usize>>,
    /// `v̂`.
    pub start_velocity: Vec<f64>,
    /// `α`.
    pub free_acceleration: Vec<f64>,
    /// `s` and `r`.
    joint_start: Vec<f64>,
    joint_free: Vec<f64>,
}

impl Elimination {
    /// Makes the workspace for systems of the size of `linearisation`.
    pub fn new(linearisation: &Linearisation) -> Self {
        Self::with_pattern(linearisation, Self::delassus_pattern(linearisation).as_deref())
    }

    /// Makes the elimination for a system whose [pattern](Self::delassus_pattern) is known.
    pub fn with_pattern(linearisation: &Linearisation, pattern: Option<&SymmetricPattern>) -> Self {
        let (n, n_b) = (linearisation.velocities(), linearisation.bilateral.len());
        let rows = linearisation.unilateral.len() + linearisation.tangential.len() + linearisation.interface.len();
        let local = pattern.and_then(|pattern| LocalElimination::new(linearisation, pattern));
        let rows = if local.is_some() { 0 } else { rows };
        Elimination {
            local,
            velocities: n,
            bilateral: n_b,
            rows,
            mass_factor: matches!(linearisation.mass, MassMatrix::Dense(_)).then(|| Cholesky::new(n)),
            inverse_mass: vec![0.0; n],
            schur: Cholesky::new(n_b),
            y: vec![0.0; n_b * n],
            g_rows: vec![0.0; rows * n],
            coupling: vec![0.0; rows * n_b],
            supports: vec![0..0; rows],
            start_velocity: vec![0.0; n],
            free_acceleration: vec![0.0; n],
            joint_start: vec![0.0; n_b],
            joint_free: vec![0.0; n_b],
        }
    }

    /// Returns the pattern of `H_uu`, if unilateral rows of Eq. 3 keep only their non-zeros; the mass must be diagonal,
    /// there must be no joints, and the model that is filled must have this pattern.
    pub fn delassus_pattern(linearisation: &Linearisation) -> Option<Arc<SymmetricPattern>> {
        LocalElimination::delassus_pattern(&linearisation.unilateral, linearisation.velocities()).map(Arc::new)
    }

    /// Fills `model` from Eq. 3 at velocity `v`, for a mechanics step `h` (s) with joint stabilisation `γ`.
    ///
    /// # Errors
    /// If the mass matrix is not positive definite or bilateral rows depend on each other.
    pub fn reduce(
        &mut self,
        eq3: &Linearisation,
        v: &[f64],
        h: f64,
        stabilisation: f64,
        model: &mut ReducedInterfaceModel,
    ) -> Result<(), Failure> {
        model.stabilisation = stabilisation;
        model.mechanics_step = h;
        if let Some(reduced) = self.reduce_two_bodies(eq3, v, [h, stabilisation], model) {
            return reduced;
        }
        if let Some(local) = &mut self.local {
            self.start_velocity.copy_from_slice(v);
            local.reduce(eq3, v, &mut self.free_acceleration, model);
        } else {
            self.reduce_all(eq3, v, h, stabilisation, model)?;
        }
        model.gap.copy_from_slice(&eq3.unilateral.position);
        model.position.copy_from_slice(&eq3.interface.position);
        Ok(())
    }

    #[inline]
    fn reduce_all(
        &mut self,
        eq3: &Linearisation,
        v: &[f64],
        h: f64,
        stabilisation: f64,
        model: &mut ReducedInterfaceModel,
    ) -> Result<(), Failure> {
        self.invert_mass(&eq3.mass)?;
        let (b, rows) = (self.bilateral, self.rows);
        match (self.velocities, b, rows) {
            two_in_space::SIZES if self.mass_factor.is_none() => {
                self.reduce_two_in_space(eq3, v, [h, stabilisation], model)
            }
            (3, ..) => self.reduce_in_blocks::<3>([1, b, rows], false, eq3, v, [h, stabilisation], model),
            (6, ..) => self.reduce_in_blocks::<6>([1, b, rows], false, eq3, v, [h, stabilisation], model),
            (n, ..) if n % 3 == 0 => {
                self.reduce_in_blocks::<3>([n / 3, b, rows], false, eq3, v, [h, stabilisation], model)
            }
            (n, ..) => self.reduce_in_blocks::<1>([n, b, rows], false, eq3, v, [h, stabilisation], model),
        }
    }

    /// Recovers `v⁺` after a step `h` from the stacked impulses `[P_u; h λ_i]` (N·s).
    pub fn velocity_after(&mut self, h: f64, impulses: &[f64], v: &mut [f64]) {
        if let Some(local) = &self.local {
            for (v, (start, free)) in v.iter_mut().zip(self.start_velocity.iter().zip(&self.free_acceleration)) {
                *v = start + h * free;
            }
            return local.add_impulses(impulses, v);
        }
        if self.velocity_of_two_bodies(h, impulses, v).is_some() {
            return;
        }
        match self.velocities {
            3 => self.velocity_in_blocks::<3>(1, h, impulses, v),
            6 => self.velocity_in_blocks::<6>(1, h, impulses, v),
            12 => self.velocity_in_blocks::<12>(1, h, impulses, v),
            n => self.velocity_in_blocks::<1>(n, h, impulses, v),
        }
    }

    /// Recovers the bilateral impulses `P_b` (N·s) of that step.
    pub fn bilateral_impulses(&mut self, h: f64, impulses: &[f64], p_b: &mut [f64]) {
        match (self.bilateral, self.rows) {
            (2, 5) => self.bilateral_of(2, 5, h, impulses, p_b),
            (3, 19) => self.bilateral_of(3, 19, h, impulses, p_b),
            (b, rows) => self.bilateral_of(b, rows, h, impulses, p_b),
        }
        self.schur.backward(p_b);
    }

    /// Writes `−(s + h r + Cᵀ P)` of so many joint rows and others, which the compiler may know.
    #[inline(always)]
    fn bilateral_of(&self, n_b: usize, rows: usize, h: f64, impulses: &[f64], p_b: &mut [f64]) {
        let (impulses, p_b) = (&impulses[..rows], &mut p_b[..n_b]);
        let (start, free) = (&self.joint_start[..n_b], &self.joint_free[..n_b]);
        let coupling = &self.coupling[..n_b * rows];
        for (b, out) in p_b.iter_mut().enumerate() {
            let row = &coupling[b * rows..(b + 1) * rows];
            let from_rows: f64 = impulses.iter().zip(row).map(|(impulse, c)| impulse * c).sum();
            *out = -(start[b] + h * free[b] + from_rows);
        }
    }

    fn invert_mass(&mut self, mass: &MassMatrix) -> Result<(), Failure> {
        match (mass, &mut self.mass_factor) {
            (MassMatrix::Diagonal(mass), _) => {
                for (inverse, m) in self.inverse_mass.iter_mut().zip(mass) {
                    *inverse = 1.0 / m;
                }
                Ok(())
            }
            (MassMatrix::Dense(mass), Some(factor)) => {
                factor.l.copy_from_slice(mass);
                Ok(factor.factor("mass matrix")?)
            }
            (MassMatrix::Dense(_), None) => Err(Cause::Singular { matrix: "mass matrix" }.into()),
        }
    }

    /// Reduces a system of `k` blocks of `L` velocities, with `n_b` joint rows and so many others; `diagonal` if its
    /// mass is known to be.
    #[inline(always)]
    fn reduce_in_blocks<const L: usize>(
        &mut self,
        [k, n_b, rows]: [usize; 3],
        diagonal: bool,
        eq3: &Linearisation,
        v: &[f64],
        [h, stabilisation]: [f64; 2],
        model: &mut ReducedInterfaceModel,
    ) -> Result<(), Failure> {
        let mass_factor = if diagonal { &None } else { &self.mass_factor };
        eliminate_bilateral::<L>(
            [k, n_b],
            eq3,
            v,
            [h, stabilisation],
            (&self.inverse_mass[..k * L], mass_factor),
            Joints {
                schur: &mut self.schur,
                y: &mut self.y[..n_b * k * L],
                start: &mut self.joint_start[..n_b],
                free: &mut self.joint_free[..n_b],
            },
            [&mut self.start_velocity[..k * L], &mut self.free_acceleration[..k * L]],
        )?;
        let n_u = model.contacts();
        let first = model.interface_start();
        let (start, free) = (blocks::<L>(&self.start_velocity[..k * L]), blocks::<L>(&self.free_acceleration[..k * L]));
        let (y, inverse_mass) = (blocks::<L>(&self.y[..n_b * k * L]), blocks::<L>(&self.inverse_mass[..k * L]));
        // Then a row of G A_xᵀ has the support of its row of A, and rows without a common body have `H_xy = 0`.
        let local = n_b == 0 && mass_factor.is_none();
        // Once for all rows: in the loop the compiler would look up where each of them lies at every entry.
        let (model_h, model_w, model_a) = (&mut model.h[..rows * rows], &mut model.w[..rows], &mut model.a[..rows]);
        let (coupling, supports) = (&mut self.coupling[..n_b * rows], &mut self.supports[..rows]);
        let g_rows = &mut self.g_rows.as_chunks_mut::<L>().0[..rows * k];
        // Copies of single blocks stay in registers: no entry that is written could be one of theirs.
        let single = k == 1;
        let ([mut of_start, mut of_free, mut of_mass, mut of_a], mut of_g) = ([[[0.0; L]]; 4], [[0.0; L]]);
        let start = if single { kept(&mut of_start, start) } else { start };
        let free = if single { kept(&mut of_free, free) } else { free };
        let inverse_mass = if single { kept(&mut of_mass, inverse_mass) } else { inverse_mass };
        for row in 0..rows {
            let (source, index) = if row < n_u {
                (&eq3.unilateral, row)
            } else if row >= first {
                (&eq3.interface, row - first)
            } else {
                (&eq3.tangential, row - n_u)
            };
            let a = row_of(blocks::<L>(&source.jacobian), index, k);
            let a = if single { kept(&mut of_a, a) } else { a };
            let support = support(a);
            let a_x = &a[support.clone()];
            model_w[row] = dot(a_x, &start[support.clone()]);
            model_a[row] = dot(a_x, &free[support.clone()]) + source.convective[index];

            let (finished, rest) = g_rows.split_at_mut(row * k);
            let g = if single { &mut of_g[..] } else { &mut rest[..k] };
            multiply_by_inverse_mass(inverse_mass, mass_factor, a, g);
            for b in 0..n_b {
                let y = row_of(y, b, k);
                let c = dot(a_x, &y[support.clone()]);
                add_multiple(g, -c, y);
                coupling[b * rows + row] = c;
            }
            // Only one triangle is computed, so that H is symmetric to the bit.
            for column in 0..row {
                let other = &supports[column];
                let apart = local && (other.end <= support.start || support.end <= other.start);
                let entry = if apart { 0.0 } else { dot(a_x, &row_of(finished, column, k)[support.clone()]) };
                model_h[row * rows + column] = entry;
                model_h[column * rows + row] = entry;
            }
            model_h[row * rows + row] = dot(a_x, &g[support.clone()]);
            if single {
                rest[0] = of_g[0];
            }
            supports[row] = support;
        }
        Ok(())
    }

    #[inline(always)]
    fn velocity_in_blocks<const L: usize>(&self, k: usize, h: f64, impulses: &[f64], v: &mut [f64]) {
        let v = &mut v.as_chunks_mut::<L>().0[..k];
        v.copy_from_slice(&blocks(&self.start_velocity)[..k]);
        add_multiple(v, h, blocks(&self.free_acceleration));
        for (row, &impulse) in impulses.iter().enumerate() {
            if impulse != 0.0 {
                add_multiple(v, impulse, row_of(blocks(&self.g_rows), row, k));
            }
        }
    }
}

/// What is kept of the bilateral rows.
struct Joints<'a> {
    schur: &'a mut Cholesky,
    y: &'a mut [f64],
    start: &'a mut [f64],
    free: &'a mut [f64],
}

/// Fills `L`, `Y`, `s`, `r`, `v̂` and `α`.
#[inline(always)]
fn eliminate_bilateral<const L: usize>(
    [k, n_b]: [usize; 2],
    eq3: &Linearisation,
    v: &[f64],
    [h, gamma]: [f64; 2],
    (inverse_mass, mass_factor): (&[f64], &Option<Cholesky>),
    Joints { schur, y, start: joint_start, free: joint_free }: Joints<'_>,
    [start, free]: [&mut [f64]; 2],
) -> Result<(), Failure> {
    let (inverse_mass, rows) = (blocks::<L>(inverse_mass), blocks::<L>(&eq3.bilateral.jacobian));
    let (start, free) = (start.as_chunks_mut::<L>().0, free.as_chunks_mut::<L>().0);
    start.copy_from_slice(&blocks(v)[..k]);
    multiply_by_inverse_mass(inverse_mass, mass_factor, &blocks(&eq3.force)[..k], free);
    if n_b == 0 {
        return Ok(());
    }
    let y = y.as_chunks_mut::<L>().0;
    for b in 0..n_b {
        let (a_b, y_b) = (row_of(rows, b, k), &mut y[b * k..(b + 1) * k]);
        multiply_by_inverse_mass(inverse_mass, mass_factor, a_b, y_b);
        for c in 0..=b {
            schur.l[b * n_b + c] = dot(y_b, row_of(rows, c, k));
        }
        joint_start[b] = dot(a_b, start) + gamma * eq3.bilateral.position[b] / h;
        joint_free[b] = dot(a_b, free) + eq3.bilateral.convective[b];
    }
    schur.factor("A_b M⁻¹ A_bᵀ")?;
    schur.forward(joint_start);
    schur.forward(joint_free);
    for b in 0..n_b {
        let (finished, rest) = y.split_at_mut(b * k);
        let y_b = &mut rest[..k];
        let l = &schur.l[b * n_b..=b * n_b + b];
        for (c, l) in l[..b].iter().enumerate() {
            add_multiple(y_b, -l, row_of(finished, c, k));
        }
        let scale = 1.0 / l[b];
        y_b.as_flattened_mut().iter_mut().for_each(|y| *y *= scale);
        add_multiple(start, -joint_start[b], y_b);
        add_multiple(free, -joint_free[b], y_b);
    }
    Ok(())
}

#[inline(always)]
fn blocks<const L: usize>(entries: &[f64]) -> &[[f64; L]] {
    entries.as_chunks().0
}

/// A copy of a single block.
#[inline(always)]
fn kept<'a, const L: usize>(copy: &'a mut [[f64; L]; 1], of: &[[f64; L]]) -> &'a [[f64; L]] {
    copy[0] = of[0];
    copy
}

/// One row of a matrix with `k` blocks per row.
#[inline(always)]
fn row_of<const L: usize>(matrix: &[[f64; L]], index: usize, k: usize) -> &[[f64; L]] {
    &matrix[index * k..index * k + k]
}

#[inline(always)]
fn dot<const L: usize>(a: &[[f64; L]], b: &[[f64; L]]) -> f64 {
    let mut sum = 0.0;
    for (a, b) in a.iter().zip(b) {
        // Two independent halves, because each addition has to wait for the one before.
        let (mut even, mut odd) = (0.0, 0.0);
        for l in 0..L {
            if l % 2 == 0 { even += a[l] * b[l] } else { odd += a[l] * b[l] }
        }
        sum += even + odd;
    }
    sum
}

/// `target += factor · x`.
#[inline(always)]
fn add_multiple<const L: usize>(target: &mut [[f64; L]], factor: f64, x: &[[f64; L]]) {
    for (target, x) in target.iter_mut().zip(x) {
        // A block at a time through a copy: the compiler then knows that `x` does not change on the way.
        let mut sum = *target;
        for l in 0..L {
            sum[l] += factor * x[l];
        }
        *target = sum;
    }
}

/// `out = M⁻¹ x`.
#[inline(always)]
fn multiply_by_inverse_mass<const L: usize>(
    inverse: &[[f64; L]],
    factor: &Option<Cholesky>,
    x: &[[f64; L]],
    out: &mut [[f64; L]],
) {
    if let Some(factor) = factor {
        out.copy_from_slice(x);
        return factor.solve(out.as_flattened_mut());
    }
    for (out, (x, inverse)) in out.iter_mut().zip(x.iter().zip(inverse)) {
        *out = std::array::from_fn(|l| x[l] * inverse[l]);
    }
}

/// The blocks from the first that is not zero to the last.
#[inline(always)]
fn support<const L: usize>(row: &[[f64; L]]) -> Range<usize> {
    // A single block is taken as it is: to search it would cost more than the products it saves.
    if row.len() == 1 {
        return 0..1;
    }
    let occupied = |block: &[f64; L]| block.iter().any(|&x| x != 0.0);
    let first = row.iter().position(occupied).unwrap_or(row.len());
    first..row.iter().rposition(occupied).map_or(first, |last| last + 1)
}
