//! `rim-fixed-mass`: the actuator pushes a constant mass instead of a reduced interface model. An ablation.
//!
//! ```text
//! w_i⁺ = w_i + δ Ĥ_ii(t_0) λ      s⁺ = s + δ w_i⁺
//! ```
//! `Ĥ_ii(t_0)` is the inverse effective mass at the start, with the contacts bilateral that are closed there. No free
//! acceleration, no contacts, nothing that moves: what is missing against `rim-smooth` is what the model contributes.
//! **Needs** an interface model of the mechanics, once. **Order** 1 in H: the velocity at the end of the macro step lacks the
//! free acceleration. **Known weakness**: on purpose, all of it; at rest under load the mass falls a little within each macro
//! step.
//! **Source**: ablation, ours.

use super::entry::{Family, SchemeEntry};
use super::need::Need;
use crate::cosim::{CouplingScheme, Diagnostics, MicroStep, Sample, Sequence, Side};
use crate::error::Failure;
use crate::interface_model::{Condensation, Redundancy, condense};

pub(super) const ENTRY: SchemeEntry = SchemeEntry {
    name: "rim-fixed-mass",
    about: "Constant effective mass of the start, no free acceleration, no contacts (ablation)",
    family: Family::Model,
    order: 1,
    samples: 1,
    sequence: Sequence::GaussSeidel { first: Side::Actuator },
    needs: &[Need::ForceDisplacement, Need::InterfaceModel],
    gain: None,
    build: |_mechanics, actuator, options| {
        let interface = actuator.outputs.len();
        Box::new(FixedMass {
            redundancy: options.redundancy,
            mobility: None,
            position: vec![0.0; interface],
            velocity: vec![0.0; interface],
            force: vec![0.0; interface],
        })
    },
};

#[derive(Clone)]
struct FixedMass {
    redundancy: Redundancy,
    /// `Ĥ_ii(t_0)`.
    mobility: Option<Condensation>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    force: Vec<f64>,
}

impl CouplingScheme for FixedMass {
    fn wants_interface_model(&self) -> bool {
        true
    }

    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        let n_i = self.force.len();
        match from {
            Side::Mechanics => {
                self.position.copy_from_slice(&sample.y[..n_i]);
                self.velocity.copy_from_slice(&sample.y[n_i..]);
                if let (None, Some(model)) = (&self.mobility, sample.model) {
                    let mut closed = Vec::with_capacity(model.contacts());
                    model.closed_contacts(&mut closed);
                    let mobility = self.mobility.insert(Condensation::new(model.contacts(), n_i));
                    condense(model, &closed, self.redundancy, mobility);
                }
            }
            Side::Actuator => self.force.copy_from_slice(sample.y),
        }
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        if to == Side::Mechanics {
            u.copy_from_slice(&self.force);
            return Ok(());
        }
        let n_i = self.force.len();
        let mobility = self.mobility.as_ref().map_or(&[][..], |mobility| &mobility.h);
        for (row, (velocity, position)) in self.velocity.iter_mut().zip(&mut self.position).enumerate() {
            let h = mobility.get(row * n_i..(row + 1) * n_i).unwrap_or_default();
            *velocity += at.length * h.iter().zip(own).map(|(h, force)| h * force).sum::<f64>();
            *position += at.length * *velocity;
        }
        u[..n_i].copy_from_slice(&self.position);
        u[n_i..].copy_from_slice(&self.velocity);
        Ok(())
    }

    fn diagnostics(&mut self) -> Diagnostics {
        Diagnostics { effective_mass: self.mobility.as_ref().map(|mobility| mobility.effective_mass) }
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosim::MacroStep;
    use crate::interface_model::ReducedInterfaceModel;

    #[test]
    fn the_mass_of_the_start_stays_whatever_the_model_says_later() {
        let mut scheme = FixedMass {
            redundancy: Redundancy::Drop,
            mobility: None,
            position: vec![0.0],
            velocity: vec![0.0],
            force: vec![0.0],
        };
        let step = MacroStep { index: 0, start: 0.0, length: 1.0 };
        // 2 kg at first, then 1/2 kg; the free acceleration is never used.
        for (mass, y) in [(2.0, [1.0, 3.0]), (0.5, [4.0, -1.0])] {
            let mut model = ReducedInterfaceModel::zeros(0, 1);
            (model.h[0], model.a[0], model.w[0]) = (1.0 / mass, 7.0, y[1]);
            let sample = Sample { time: 0.0, y: &y, model: Some(&model), rates: None, step, actuator_micro_step: 0.5 };
            scheme.receive(Side::Mechanics, &sample).unwrap();
            assert_eq!(scheme.diagnostics().effective_mass, Some(2.0));
            let mut u = [0.0; 2];
            for (index, [x, v]) in
                [[y[0] + 0.5 * (y[1] + 1.0), y[1] + 1.0], [y[0] + y[1] + 1.5, y[1] + 2.0]].into_iter().enumerate()
            {
                scheme.input(Side::Actuator, MicroStep::new(step, index, 2), &[4.0], &mut u).unwrap();
                assert_eq!(u, [x, v]);
            }
        }
    }
}
