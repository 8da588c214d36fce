//! Contacts with friction closed for good inside the model: those that stick stand still, those that slide push as they
//! press.

use super::contact_modes::ContactModes;
use super::reduced_interface_model::ReducedInterfaceModel;
use rimbench_contact::friction::{ContactState, StateSystem};

/// Room to condense a model with friction.
///
/// ```text
/// Ĥ_ij = H_ij − H_i· F_σ K⁻¹ E_σ H_·j        â_i = a_i − H_i· F_σ K⁻¹ E_σ a        ŵ_i = w_i − H_i· F_σ K⁻¹ E_σ w
/// ```
#[derive(Debug, Clone)]
pub(super) struct StateWork {
    system: StateSystem,
    states: Vec<ContactState>,
    directions: Vec<[f64; 2]>,
    x: Vec<f64>,
    symmetric: Vec<f64>,
}

impl StateWork {
    pub(super) fn new(model: &ReducedInterfaceModel) -> Self {
        let (n, n_i) = (model.contacts(), model.interface());
        StateWork {
            system: StateSystem::with_tangents(n, model.tangents()),
            states: vec![ContactState::Open; n],
            directions: model.directions.clone(),
            x: vec![0.0; model.interface_start()],
            symmetric: vec![0.0; n_i * n_i],
        }
    }

    /// Returns `½ (Ĥ + Ĥᵀ)`, of which the heaviest direction of the interface is taken.
    pub(super) fn symmetric_part(&mut self, h: &[f64]) -> &[f64] {
        let n = h.len().isqrt();
        for (at, entry) in self.symmetric.iter_mut().enumerate() {
            *entry = 0.5 * (h[at] + h[at % n * n + at / n]);
        }
        &self.symmetric
    }

    /// Writes `Ĥ_ii`, `â_i`, `ŵ_i` with the contacts `closed` in these modes; returns the rank of `K`.
    pub(super) fn condense(
        &mut self,
        model: &ReducedInterfaceModel,
        modes: ContactModes<'_>,
        closed: &[usize],
        [h, a, w]: [&mut [f64]; 3],
    ) -> usize {
        let (n_i, first) = (model.interface(), model.interface_start());
        let StateWork { system, states, directions, x, .. } = self;
        modes.close(&model.w, closed, states, directions);
        system.factorise_along(modes.friction, states, directions, |row| model.row(row));
        // Right-hand sides: the interface columns, then a, then w.
        for column in 0..n_i + 2 {
            let of = |row: usize| match column.checked_sub(n_i) {
                None => model.row(row)[first + column],
                Some(0) => model.a[row],
                Some(_) => model.w[row],
            };
            for (x, &row) in x.iter_mut().zip(system.rows()) {
                *x = of(row);
            }
            system.solve(x);
            for i in 0..n_i {
                let pushed = |k: usize| system.column_of(k, model.row(first + i));
                let known: f64 = x[..system.rows().len()].iter().enumerate().map(|(k, x)| pushed(k) * x).sum();
                let left = of(first + i) - known;
                match column.checked_sub(n_i) {
                    None => h[i * n_i + column] = left,
                    Some(0) => a[i] = left,
                    Some(_) => w[i] = left,
                }
            }
        }
        system.rank()
    }
}
