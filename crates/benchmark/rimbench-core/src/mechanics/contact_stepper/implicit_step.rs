//! The step by the midpoint rule with stiff forces taken implicitly, and the interface model that belongs to it.

use super::ContactStepper;
use crate::error::Failure;
use crate::interface_model::{Elimination, Linearisation, MassMatrix, MatrixForm};
use crate::mechanics::stiff_forces::StiffForces;
use rimbench_contact::linear_algebra::Cholesky;

/// How far the limit of the explicit rule must be from a step that it takes: at `hω = 2/1.25` both rules are equally
/// wrong.
const MARGIN: f64 = 1.25;

/// The `M̂` and `f̂ = f_a − ĉ` of Eq. 1 where stiff forces are taken implicitly, in steps too long for the explicit
/// rule.
///
/// ```text
/// M (v⁺ − v) = h f(q̄, v̄) + Aᵀ P            q̄ = q + ½h v̄,  v̄ = ½ (v + v⁺)
/// f(q̄, v̄)   ≈ f̂ − (½D + ¼hK) (v⁺ − v)      f̂ = f(q_m, v_m) + D (v_m − v),  q_m = q + ½h v
/// M̂ (v⁺ − v) = h f̂ + Aᵀ P                  M̂ = M + ½hD + ¼h²K
/// ```
/// Forces that are linear in `K` and `D` are so taken by the implicit midpoint rule, stable for every h; `v_m` is a
/// guess that only matters for the others.
///
/// Shorter steps stay explicit. That rule is stable while `M − hD − ¼h²K` is positive definite (of one mode: `hω < 2`
/// without damping, `hd/m < 1` without stiffness; the characteristic polynomial, with `v_m` from the step before, is
/// `λ³ + (y² + 1.5x − 2) λ² + (1 − 2x) λ + ½x`, `y = hω`, `x = hd/m`). Its oscillations are off by `+h²ω²/24` of their
/// frequency for small h, half of the `−h²ω²/12` of the implicit rule, and as much as those (16 %) at `hω = 1.6`: there
/// the implicit rule takes over.
#[derive(Debug, Clone)]
pub(in crate::mechanics) struct ImplicitPart {
    /// `K` and `D` where the forces are taken.
    pub(in crate::mechanics) forces: StiffForces,
    /// `M̂` and its elimination; `M` and that of `M` while those are in use.
    mass: MassMatrix,
    elimination: Elimination,
    /// Whether a step of the length asked for last takes the forces implicitly.
    is_in_use: bool,
    factor: Cholesky,
    /// `f`, while `f̂` stands for it; differences of velocities.
    force: Vec<f64>,
    change: Vec<f64>,
}

impl ImplicitPart {
    /// Makes room for systems of the size of `eq3` with these forces.
    pub(in crate::mechanics) fn new(eq3: &Linearisation, forces: StiffForces) -> Self {
        let n = eq3.velocities();
        let diagonal =
            [&eq3.mass, &forces.stiffness, &forces.damping].iter().all(|matrix| matrix.form() == MatrixForm::Diagonal);
        let zeros = MassMatrix::zeros(n, if diagonal { MatrixForm::Diagonal } else { MatrixForm::Dense });
        let sized = Linearisation { mass: zeros.clone(), ..eq3.clone() };
        ImplicitPart {
            forces,
            mass: zeros,
            elimination: Elimination::new(&sized),
            is_in_use: false,
            factor: Cholesky::new(if diagonal { 0 } else { n }),
            force: vec![0.0; n],
            change: vec![0.0; n],
        }
    }

    /// Returns the part, if there is one and the step needs it.
    fn in_use(part: &mut Option<Box<Self>>) -> Option<&mut Self> {
        part.as_deref_mut().filter(|part| part.is_in_use)
    }

    /// Fills `M + d D + k K`.
    fn add_up(&mut self, mass: &MassMatrix, d: f64, k: f64) {
        self.mass.entries_mut().fill(0.0);
        self.mass.add(1.0, mass);
        self.mass.add(d, &self.forces.damping);
        self.mass.add(k, &self.forces.stiffness);
    }

    /// Finds out whether a step of `h` (s) is too long for the explicit rule.
    fn choose(&mut self, mass: &MassMatrix, h: f64) {
        let h = MARGIN * h;
        self.add_up(mass, -h, -0.25 * h * h);
        self.is_in_use = match &self.mass {
            MassMatrix::Diagonal(entries) => !entries.iter().all(|entry| *entry > 0.0),
            MassMatrix::Dense(entries) => {
                self.factor.l.copy_from_slice(entries);
                self.factor.factor("M − hD − ¼h²K").is_err()
            }
        };
    }

    /// Exchanges `M̂` and `M`.
    fn exchange(&mut self, mass: &mut MassMatrix, elimination: &mut Elimination) {
        std::mem::swap(&mut self.mass, mass);
        std::mem::swap(&mut self.elimination, elimination);
    }

    /// Fills `M̂` of a step `h` (s) and puts it in the place of `M`.
    fn begin(&mut self, h: f64, mass: &mut MassMatrix, elimination: &mut Elimination) {
        self.add_up(mass, 0.5 * h, 0.25 * h * h);
        self.exchange(mass, elimination);
    }
}

impl ContactStepper {
    /// Finds out whether a step of `h` (s) takes stiff forces implicitly; they must be those of the present state.
    pub(in crate::mechanics) fn choose_implicit(&mut self, h: f64) {
        if let Some(part) = self.implicit.as_deref_mut() {
            part.choose(&self.eq3.mass, h);
        }
    }

    /// Puts `M̂` and `f̂` of a step of `h` (s) in the place of `M` and `f`, where stiff forces are taken implicitly;
    /// Eq. 3 must be that of the middle, its forces taken at `v_m`.
    pub(super) fn begin_implicit(&mut self, h: f64, v_m: &[f64]) {
        let Some(part) = ImplicitPart::in_use(&mut self.implicit) else { return };
        for (change, (v_m, v)) in part.change.iter_mut().zip(v_m.iter().zip(&self.v)) {
            *change = v_m - v;
        }
        part.forces.damping.add_product(1.0, &part.change, &mut self.eq3.force);
        part.begin(h, &mut self.eq3.mass, &mut self.elimination);
    }

    /// Puts `M` back, and in the place of `f̂` the force that has acted, `f̂ − (½D + ¼hK) (v⁺ − v)`: the work of the
    /// step is that of this force.
    pub(super) fn end_implicit(&mut self, h: f64) {
        let Some(part) = ImplicitPart::in_use(&mut self.implicit) else { return };
        part.exchange(&mut self.eq3.mass, &mut self.elimination);
        for (change, (after, before)) in part.change.iter_mut().zip(self.v_next.iter().zip(&self.v)) {
            *change = after - before;
        }
        part.forces.damping.add_product(-0.5, &part.change, &mut self.eq3.force);
        part.forces.stiffness.add_product(-0.25 * h, &part.change, &mut self.eq3.force);
    }

    /// Reduces Eq. 3 at the present state to Eq. 4 with the `M̂` of a step of `h` (s), unless that is done.
    ///
    /// ```text
    /// f̂ = f − ½h K v        force in the middle of the step, without the part in M̂
    /// ```
    /// Over the whole step the model then ends where the step does, to the order of the step.
    pub(super) fn reduce_for_model(&mut self, h: f64) -> Result<(), Failure> {
        if self.reduced_for == Some(h) {
            return Ok(());
        }
        self.choose_implicit(h);
        let Some(part) = ImplicitPart::in_use(&mut self.implicit) else { return self.reduce(h) };
        part.force.copy_from_slice(&self.eq3.force);
        part.forces.stiffness.add_product(-0.5 * h, &self.v, &mut self.eq3.force);
        part.begin(h, &mut self.eq3.mass, &mut self.elimination);
        let reduced = self.reduce(h);
        if let Some(part) = self.implicit.as_deref_mut() {
            part.exchange(&mut self.eq3.mass, &mut self.elimination);
            self.eq3.force.copy_from_slice(&part.force);
        }
        reduced
    }
}
