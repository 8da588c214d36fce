//! The energy balance of a stepper.

use super::ContactStepper;
use crate::cosim::EnergyAccount;
use crate::interface_model::{Linearisation, Rows};
use crate::mechanics::energy_ledger::EnergyLedger;
use rimbench_contact::contact_law::ContactSpring;
use rimbench_contact::linear_algebra::body_dot;
use std::array::from_fn;

/// Work and losses since the start.
#[derive(Debug, Clone)]
pub(in crate::mechanics) struct EnergyBalance {
    pub(in crate::mechanics) ledger: EnergyLedger,
    /// Energy that the dampers of compliant contacts took, J.
    pub(super) damper_loss: f64,
    /// `½ (v⁺ + v⁻)` and `v⁺ − v⁻` of the last step.
    v_mean: Vec<f64>,
    v_change: Vec<f64>,
}

impl EnergyBalance {
    /// Reserves `velocities` velocities.
    pub(super) fn new(velocities: usize) -> Self {
        let zeros = vec![0.0; velocities];
        EnergyBalance { ledger: EnergyLedger::default(), damper_loss: 0.0, v_mean: zeros.clone(), v_change: zeros }
    }

    /// Adds the work of one step of `h` (s) with the impulses `[P_u; P_t; h λ_i]` and `P_b` of joints; `slip` is
    /// `Σ w_t⁺ P_t`, J.
    ///
    /// Impulses are paired with `v̄ = ½ (v⁺ + v⁻)`, and `T⁺ − T⁻ = v̄ᵀ M (v⁺ − v⁻)`.
    pub(super) fn book(
        &mut self,
        eq3: &Linearisation,
        (v, v_next): (&[f64], &[f64]),
        (impulses, p_b): (&[f64], &[f64]),
        slip: f64,
        h: f64,
    ) {
        let EnergyBalance { ledger, v_mean, v_change, .. } = self;
        if let (Ok(v), Ok(v_next)) = (<&[f64; 6]>::try_from(v), v_next.try_into()) {
            // Two bodies in the plane.
            let v_next: &[f64; 6] = v_next;
            let v_mean: [f64; 6] = from_fn(|l| 0.5 * (v[l] + v_next[l]));
            let v_change: [f64; 6] = from_fn(|l| v_next[l] - v[l]);
            return book_step(ledger, eq3, [&v_mean, &v_change], (impulses, p_b), slip, h);
        }
        for ((mean, change), (v, v_next)) in v_mean.iter_mut().zip(&mut *v_change).zip(v.iter().zip(v_next)) {
            *mean = 0.5 * (v + v_next);
            *change = v_next - v;
        }
        book_step(ledger, eq3, [v_mean, v_change], (impulses, p_b), slip, h);
    }

    /// Returns the energy account, from changes of kinetic, potential and spring energy since the start (J).
    ///
    /// Of compliant contacts the loss is that of the dampers, and the springs are part of the stored energy. The error
    /// of the step in both is counted as that of the integration.
    fn account(&self, spring: Option<ContactSpring>, kinetic: f64, potential: f64, springs: f64) -> EnergyAccount {
        let account = self.ledger.account(kinetic + potential, potential);
        if spring.is_none() {
            return account;
        }
        EnergyAccount {
            stored: account.stored + springs,
            contact: self.damper_loss,
            integration: account.integration + springs + self.damper_loss - account.contact,
            ..account
        }
    }
}

/// Books a step with these `½ (v⁺ + v⁻)` and `v⁺ − v⁻`, of so many velocities as the compiler may know.
#[inline(always)]
fn book_step(
    ledger: &mut EnergyLedger,
    eq3: &Linearisation,
    [v_mean, v_change]: [&[f64]; 2],
    (impulses, p_b): (&[f64], &[f64]),
    slip: f64,
    h: f64,
) {
    let (normal, rest) = impulses.split_at(eq3.unilateral.len());
    let (tangential, p_i) = rest.split_at(eq3.tangential.len());
    ledger.book(EnergyLedger {
        applied: h * body_dot(&eq3.force, v_mean),
        bilateral: work(&eq3.bilateral, v_mean, p_b),
        contact: work(&eq3.unilateral, v_mean, normal),
        friction: work(&eq3.tangential, v_mean, tangential),
        slip,
        interface: work(&eq3.interface, v_mean, p_i),
        kinetic: eq3.mass.product(v_mean, v_change),
        ..EnergyLedger::default()
    });
}

/// The work of the impulses along these rows, J.
#[inline(always)]
fn work(rows: &Rows, v_mean: &[f64], impulses: &[f64]) -> f64 {
    let mut sum = -0.0;
    // Most contacts are open: no impulse, no work.
    if let (Some(rows), Ok(v_mean)) = (rows.of_two_bodies(), <&[f64; 6]>::try_from(v_mean)) {
        for (row, &impulse) in rows.iter().zip(impulses) {
            if impulse != 0.0 {
                sum += body_dot(row, v_mean) * impulse;
            }
        }
        return sum;
    }
    for (index, &impulse) in impulses.iter().enumerate() {
        if impulse != 0.0 {
            sum += rows.velocity(index, v_mean) * impulse;
        }
    }
    sum
}

impl ContactStepper {
    /// Returns the kinetic energy, J.
    pub(in crate::mechanics) fn kinetic_energy(&self) -> f64 {
        0.5 * self.eq3.mass.product(&self.v, &self.v)
    }

    /// Returns the energy in the springs of compliant contacts, J.
    pub(in crate::mechanics) fn spring_energy(&self) -> f64 {
        let energy = |spring: ContactSpring| self.eq3.unilateral.position.iter().map(|gap| spring.energy(*gap)).sum();
        self.law.spring.map_or(0.0, energy)
    }

    /// Returns the energy account, from changes of kinetic, potential and spring energy since the start (J).
    pub(in crate::mechanics) fn energy_account(&self, kinetic: f64, potential: f64, springs: f64) -> EnergyAccount {
        self.energy.account(self.law.spring, kinetic, potential, springs)
    }
}
