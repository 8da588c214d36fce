//! `rim-fixed-mass`: the actuator pushes a constant mass instead of a reduced interface model. An ablation.
//!
//! ```text
//! w_i⁺ = w_i + δ Ĥ_ii(t_0) λ      s⁺ = s + δ w_i⁺
//! ```
//! `Ĥ_ii(t_0)` is the inverse effective mass at the start, with the contacts bilateral that are closed there (gap ≤ 1
//! nm). No free acceleration, no contacts, nothing that moves: what is missing against `rim-smooth` is what the model
//! contributes. **Needs** an interface model of the mechanics, once. **Order** 1 in H: the velocity at the end of the
//! macro step lacks the free acceleration. **Known weakness**: on purpose, all of it; at rest under load the mass falls
//! a little within each macro step. **Source**: ablation, ours.

use super::construction::{ModelConstruction, sent};
use super::entry::{Family, SchemeEntry};
use super::requirement::Requirement;
use crate::cosim::{CouplingScheme, Forecast, MicroStep, Sample, SchemeReport, Sequence, Side};
use crate::error::Failure;
use crate::interface_model::{Condensation, ReducedInterfaceModel, condense};

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        family: Family::Model,
        sequence: Sequence::GaussSeidel { first: Side::Actuator },
        needs: vec![Requirement::ForceDisplacement, Requirement::InterfaceModel, Requirement::NotMechanicsFirst],
        ..SchemeEntry::new(
            "rim-fixed-mass",
            "Constant effective mass of the start, no free acceleration, no contacts (ablation)",
            |construction| {
                let ModelConstruction { empty, .. } = construction.model()?;
                Ok(Box::new(FixedMass::new(empty)))
            },
        )
    }
}

#[derive(Clone)]
struct FixedMass {
    closed: Vec<usize>,
    /// `Ĥ_ii(t_0)`.
    mobility: Condensation,
    begun: bool,
    position: Vec<f64>,
    velocity: Vec<f64>,
    force: Vec<f64>,
}

impl FixedMass {
    fn new(model: &ReducedInterfaceModel) -> Self {
        let (contacts, interface) = (model.contacts(), model.interface());
        FixedMass {
            closed: Vec::with_capacity(contacts),
            mobility: Condensation::of(model),
            begun: false,
            position: vec![0.0; interface],
            velocity: vec![0.0; interface],
            force: vec![0.0; interface],
        }
    }
}

impl CouplingScheme for FixedMass {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        let n_i = self.force.len();
        match from {
            Side::Mechanics => {
                self.position.copy_from_slice(&sample.y[..n_i]);
                self.velocity.copy_from_slice(&sample.y[n_i..]);
                if !self.begun {
                    let model = sent(sample.model)?;
                    model.closed_contacts(&mut self.closed);
                    condense(model, &self.closed, &mut self.mobility);
                    self.begun = true;
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
        for (row, (velocity, position)) in self.velocity.iter_mut().zip(&mut self.position).enumerate() {
            let h = &self.mobility.h[row * n_i..(row + 1) * n_i];
            *velocity += at.length * h.iter().zip(own).map(|(h, force)| h * force).sum::<f64>();
            *position += at.length * *velocity;
        }
        u[..n_i].copy_from_slice(&self.position);
        u[n_i..].copy_from_slice(&self.velocity);
        Ok(())
    }

    fn forecast(&self) -> Option<Forecast<'_>> {
        Some(Forecast { position: &self.position, next_closing: None })
    }

    fn report(&mut self) -> SchemeReport {
        SchemeReport { effective_mass: Some(self.mobility.effective_mass), ..SchemeReport::default() }
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}
