//! From Eq. 3 to Eq. 4: velocities and bilateral impulses are eliminated once, and can be recovered afterwards.

use super::cholesky::Cholesky;
use super::linearisation::{Linearisation, MassMatrix, Rows, dot};
use super::reduced_interface_model::ReducedInterfaceModel;
use crate::error::Failure;

/// Eliminates velocities and bilateral impulses, leaving the model at the interface; then maps impulses back.
///
/// ```text
/// S   = A_b M⁻¹ A_bᵀ               G = M⁻¹ − M⁻¹ A_bᵀ S⁻¹ A_b M⁻¹
/// v̂   = v − M⁻¹ A_bᵀ S⁻¹ (A_b v + γ g_b / h)          start velocity, consistent with the joints
/// α   = M⁻¹ f − M⁻¹ A_bᵀ S⁻¹ (A_b M⁻¹ f + Ȧ_b v)      free acceleration
/// H_xy = A_x G A_yᵀ     w_x = A_x v̂     a_x = A_x α + Ȧ_x v          x, y ∈ {u, i}
/// v⁺  = v̂ + h α + G A_uᵀ P_u + G A_iᵀ h λ_i
/// ```
/// # Shapes and units
/// `M` n×n (kg); `A_x` n_x×n; `H_xy` n_x×n_y (1/kg); `w_x` (m/s); `a_x` (m/s²).
/// # Errors
/// [`Failure::Singular`] if the bilateral rows are dependent. Dependent unilateral rows are allowed.
/// # Source
/// Raoofian, Kövecses, Teichmann, Eqs. 3–4; the joint drift term `γ g_b / h` is ours.
#[derive(Debug, Clone)]
pub struct Elimination {
    velocities: usize,
    bilateral: usize,
    rows: usize,
    mass_factor: Option<Cholesky>,
    /// `A_b M⁻¹`, n_b×n.
    b_minv: Vec<f64>,
    schur: Cholesky,
    /// `A_x M⁻¹` on the way, `G A_xᵀ` (transposed) in the end; (n_u+n_i)×n.
    g_rows: Vec<f64>,
    /// `A_x M⁻¹ A_bᵀ L⁻ᵀ`, (n_u+n_i)×n_b.
    coupling: Vec<f64>,
    /// `v̂`.
    pub start_velocity: Vec<f64>,
    /// `α`.
    pub free_acceleration: Vec<f64>,
    /// `S⁻¹ (A_b v + γ g_b / h)` and `S⁻¹ (A_b M⁻¹ f + Ȧ_b v)`.
    joint_start: Vec<f64>,
    joint_free: Vec<f64>,
}

impl Elimination {
    /// Makes the workspace for systems of the size of `linearisation`.
    pub fn new(linearisation: &Linearisation) -> Self {
        let n = linearisation.velocities();
        let n_b = linearisation.bilateral.len();
        let rows = linearisation.unilateral.len() + linearisation.interface.len();
        Elimination {
            velocities: n,
            bilateral: n_b,
            rows,
            mass_factor: matches!(linearisation.mass, MassMatrix::Dense(_)).then(|| Cholesky::new(n)),
            b_minv: vec![0.0; n_b * n],
            schur: Cholesky::new(n_b),
            g_rows: vec![0.0; rows * n],
            coupling: vec![0.0; rows * n_b],
            start_velocity: vec![0.0; n],
            free_acceleration: vec![0.0; n],
            joint_start: vec![0.0; n_b],
            joint_free: vec![0.0; n_b],
        }
    }

    /// Fills `model` from Eq. 3 at velocity `v`, for a mechanics step `h` with joint stabilisation `γ`.
    pub fn reduce(
        &mut self,
        eq3: &Linearisation,
        v: &[f64],
        h: f64,
        stabilisation: f64,
        model: &mut ReducedInterfaceModel,
    ) -> Result<(), Failure> {
        self.eliminate_bilateral(eq3, v, h, stabilisation)?;
        let (n, n_b, n_u) = (self.velocities, self.bilateral, model.contacts());
        for row in 0..self.rows {
            let (block, index) = block_of(eq3, row, n_u);
            self.g_rows[row * n..(row + 1) * n].copy_from_slice(block.row(index));
            self.apply_inverse_mass(&eq3.mass, row);
            model.w[row] = dot(block.row(index), &self.start_velocity);
            model.a[row] = dot(block.row(index), &self.free_acceleration) + block.convective[index];
            for b in 0..n_b {
                self.coupling[row * n_b + b] = dot(&self.g_rows[row * n..(row + 1) * n], eq3.bilateral.row(b));
            }
            self.schur.forward(&mut self.coupling[row * n_b..(row + 1) * n_b]);
        }
        // H = A_x M⁻¹ A_yᵀ − (A_x M⁻¹ A_bᵀ L⁻ᵀ)(…)ᵀ, symmetric by construction.
        for row in 0..self.rows {
            let (block, index) = block_of(eq3, row, n_u);
            for column in 0..=row {
                let direct = dot(block.row(index), &self.g_rows[column * n..(column + 1) * n]);
                let joints =
                    dot(&self.coupling[row * n_b..(row + 1) * n_b], &self.coupling[column * n_b..(column + 1) * n_b]);
                model.h[row * self.rows + column] = direct - joints;
                model.h[column * self.rows + row] = direct - joints;
            }
        }
        // G A_xᵀ = M⁻¹ A_xᵀ − M⁻¹ A_bᵀ S⁻¹ (A_b M⁻¹ A_xᵀ), and with it the joint impulses per unit of row impulse.
        for row in 0..self.rows {
            let joint = &mut self.coupling[row * n_b..(row + 1) * n_b];
            self.schur.backward(joint);
            for (b, factor) in joint.iter().enumerate() {
                for (g, y) in self.g_rows[row * n..(row + 1) * n].iter_mut().zip(&self.b_minv[b * n..(b + 1) * n]) {
                    *g -= factor * y;
                }
            }
        }
        model.gap.copy_from_slice(&eq3.unilateral.position);
        model.position.copy_from_slice(&eq3.interface.position);
        model.stabilisation = stabilisation;
        model.mechanics_step = h;
        Ok(())
    }

    /// Recovers `v⁺` after a step `h` from the stacked impulses `[P_u; h λ_i]` (N·s).
    pub fn velocity_after(&self, h: f64, impulses: &[f64], v: &mut [f64]) {
        for (index, out) in v.iter_mut().enumerate() {
            *out = self.start_velocity[index] + h * self.free_acceleration[index];
        }
        for (row, &impulse) in impulses.iter().enumerate() {
            if impulse != 0.0 {
                let g = &self.g_rows[row * self.velocities..(row + 1) * self.velocities];
                for (out, g) in v.iter_mut().zip(g) {
                    *out += impulse * g;
                }
            }
        }
    }

    /// Recovers the bilateral impulses `P_b` (N·s) of the same step.
    pub fn bilateral_impulses(&self, h: f64, impulses: &[f64], p_b: &mut [f64]) {
        for (b, out) in p_b.iter_mut().enumerate() {
            let from_rows: f64 =
                impulses.iter().enumerate().map(|(row, p)| p * self.coupling[row * self.bilateral + b]).sum();
            *out = -self.joint_start[b] - h * self.joint_free[b] - from_rows;
        }
    }

    fn eliminate_bilateral(&mut self, eq3: &Linearisation, v: &[f64], h: f64, gamma: f64) -> Result<(), Failure> {
        let (n, n_b) = (self.velocities, self.bilateral);
        if let (MassMatrix::Dense(mass), Some(factor)) = (&eq3.mass, &mut self.mass_factor) {
            factor.l.copy_from_slice(mass);
            factor.factor("mass matrix")?;
        }
        match (&eq3.mass, &self.mass_factor) {
            (MassMatrix::Diagonal(mass), _) => {
                for (out, (f, m)) in self.free_acceleration.iter_mut().zip(eq3.force.iter().zip(mass)) {
                    *out = f / m;
                }
            }
            (MassMatrix::Dense(_), Some(factor)) => {
                self.free_acceleration.copy_from_slice(&eq3.force);
                factor.solve(&mut self.free_acceleration);
            }
            (MassMatrix::Dense(_), None) => return Err(Failure::Singular { matrix: "mass matrix" }),
        }
        self.start_velocity.copy_from_slice(v);
        if n_b == 0 {
            return Ok(());
        }
        for b in 0..n_b {
            let target = &mut self.b_minv[b * n..(b + 1) * n];
            target.copy_from_slice(eq3.bilateral.row(b));
            match (&eq3.mass, &self.mass_factor) {
                (MassMatrix::Diagonal(mass), _) => target.iter_mut().zip(mass).for_each(|(x, m)| *x /= m),
                (_, Some(factor)) => factor.solve(target),
                _ => {}
            }
            for c in 0..=b {
                self.schur.l[b * n_b + c] = dot(&self.b_minv[b * n..(b + 1) * n], eq3.bilateral.row(c));
            }
            self.joint_start[b] = eq3.bilateral.velocity(b, v) + gamma * eq3.bilateral.position[b] / h;
            self.joint_free[b] = dot(eq3.bilateral.row(b), &self.free_acceleration) + eq3.bilateral.convective[b];
        }
        self.schur.factor("A_b M⁻¹ A_bᵀ")?;
        self.schur.solve(&mut self.joint_start);
        self.schur.solve(&mut self.joint_free);
        for b in 0..n_b {
            let row = &self.b_minv[b * n..(b + 1) * n];
            for (index, y) in row.iter().enumerate() {
                self.start_velocity[index] -= y * self.joint_start[b];
                self.free_acceleration[index] -= y * self.joint_free[b];
            }
        }
        Ok(())
    }

    fn apply_inverse_mass(&mut self, mass: &MassMatrix, row: usize) {
        let target = &mut self.g_rows[row * self.velocities..(row + 1) * self.velocities];
        match (mass, &self.mass_factor) {
            (MassMatrix::Diagonal(mass), _) => target.iter_mut().zip(mass).for_each(|(x, m)| *x /= m),
            (_, Some(factor)) => factor.solve(target),
            _ => {}
        }
    }
}

#[inline]
fn block_of(eq3: &Linearisation, row: usize, n_u: usize) -> (&Rows, usize) {
    if row < n_u { (&eq3.unilateral, row) } else { (&eq3.interface, row - n_u) }
}
