//! Requirements of a scheme on the subsystems and on the options of a run, and whether they are met.

use crate::cosim::{NO_INTERFACE_MODEL, NO_OIL_LINES, NO_OUTPUT_RATES, OutputRates, Port, Quantity, Sides, Subsystem};
use crate::error::{Cause, Failure};
use crate::interface_model::ReducedInterfaceModel;

/// Something a scheme cannot do without.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Requirement {
    /// Forces to the mechanics, and the positions and velocities of that interface back.
    ForceDisplacement,
    /// A reduced interface model of the mechanics.
    InterfaceModel,
    /// Contacts that the reduced interface model lists: a smooth one, which has them within, will not do.
    ListedContacts,
    /// Contacts without friction, where there is a reduced interface model: for a scheme of others that reads no
    /// tangential rows.
    NoFriction,
    /// An interface of at most so many rows.
    Rows(usize),
    /// Directional derivatives of the actuator's outputs.
    OutputRates,
    /// Output rates of an actuator with direct feedthrough; one without has none to know.
    OutputRatesIfFeedthrough,
    /// Volumes of oil in the actuator that lines can replace.
    TransmissionLines,
    /// The force that the scheme hands to the mechanics must be used: force return `held`. Refused before any run.
    HeldReturn,
    /// The actuator steps before the mechanics has, or beside it: sequence `gauss-seidel` or `jacobi`. Refused before
    /// any run.
    NotMechanicsFirst,
    /// The actuator has stepped before the mechanics does, and its force is that of the whole macro step: sequence
    /// `gauss-seidel`. Refused before any run.
    ActuatorFirst,
    /// A mechanics that can be copied, so that a step of it can be tried.
    Trials,
    /// Both subsystems can be copied, so that a step can be taken again.
    Copies,
}

impl Requirement {
    /// Says why two subsystems do not offer this, if they do not.
    pub fn unmet(self, Sides { mechanics, actuator }: Sides<'_>) -> Option<String> {
        let ports = actuator.ports();
        let (inputs, outputs) = (ports.inputs.len(), ports.outputs.len());
        let (met, reason) = match self {
            Requirement::ForceDisplacement => (
                is_force_displacement(mechanics, actuator),
                "a force-displacement coupling is needed: forces to the mechanics, their positions and velocities back",
            ),
            Requirement::InterfaceModel => {
                let capabilities = mechanics.capabilities();
                if capabilities.empty_interface_model().is_none() {
                    let asked = capabilities.interface_model(0.0, &mut ReducedInterfaceModel::zeros(0, 0));
                    return Some(missing(NO_INTERFACE_MODEL, &asked));
                }
                return None;
            }
            Requirement::ListedContacts => (
                mechanics.capabilities().empty_interface_model().is_none_or(|model| !model.smooth),
                "the mechanics' interface model is a smooth one, whose contacts neither open nor close: use a scheme whose contacts are \
                 bilateral, such as rim-smooth",
            ),
            Requirement::NoFriction => (
                mechanics.capabilities().empty_interface_model().is_none_or(|model| !model.has_friction()),
                "its picture of the contacts knows no friction, as it reads no tangential rows: use a scheme of rimbench, or one without a model",
            ),
            Requirement::TransmissionLines => (actuator.capabilities().oil_lines().is_some(), NO_OIL_LINES),
            Requirement::Rows(most) if outputs > most => {
                return Some(format!("the interface has more than {most} rows"));
            }
            Requirement::Rows(_)
            | Requirement::HeldReturn
            | Requirement::NotMechanicsFirst
            | Requirement::ActuatorFirst => return None,
            Requirement::Trials => {
                let copied = mechanics.try_clone();
                return copied.is_err().then(|| missing(NO_TRIALS, &copied));
            }
            Requirement::OutputRatesIfFeedthrough if !ports.direct_feedthrough => return None,
            Requirement::OutputRates | Requirement::OutputRatesIfFeedthrough => {
                let mut rates = OutputRates::zeros(outputs, inputs);
                let offered = actuator.capabilities().output_rates(0.0, &vec![0.0; inputs], &mut rates);
                if matches!(&offered, Err(failure) if matches!(failure.cause(), Cause::NotOffered { .. })) {
                    return Some(missing(NO_OUTPUT_RATES, &offered));
                }
                // An error here is no refusal: the run will fail with it and say why.
                (offered.unwrap_or(true), NO_OUTPUT_RATES)
            }
            Requirement::Copies => {
                let refused = [mechanics, actuator].into_iter().map(|side| side.try_clone()).find(Result::is_err)?;
                return Some(missing("a subsystem cannot be copied, and so no step can be taken again", &refused));
            }
        };
        (!met).then(|| reason.to_owned())
    }
}

/// Why no step can be tried.
const NO_TRIALS: &str = "the mechanics cannot be copied, and so no step of it can be tried; what remains are schemes that neither iterate nor \
                         try steps, such as zero-order-hold";

/// Why something is not offered, with what the subsystem itself says of it, if it says anything.
fn missing<T>(reason: &str, asked: &Result<T, Failure>) -> String {
    match asked.as_ref().map_err(Failure::cause) {
        Err(Cause::NotOffered { what }) => format!("{reason}: {what}"),
        _ => reason.to_owned(),
    }
}

fn is_force_displacement(mechanics: &dyn Subsystem, actuator: &dyn Subsystem) -> bool {
    let count = |ports: &[Port], quantity| ports.iter().filter(|port| port.quantity == quantity).count();
    let (inputs, outputs) = (&actuator.ports().inputs, &actuator.ports().outputs);
    let forces = count(outputs, Quantity::Force);
    forces > 0
        && forces == outputs.len()
        && count(inputs, Quantity::Position) == forces
        && count(inputs, Quantity::Velocity) == forces
        && inputs.len() == 2 * forces
        && mechanics.ports().outputs == *inputs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosim::{Capabilities, Ports, subsystem_methods};

    struct Ported {
        ports: Ports,
    }

    impl Subsystem for Ported {
        subsystem_methods!(ports capabilities no_counters no_clone);

        fn outputs(&mut self, _: &[f64], _: &mut [f64]) -> Result<(), Failure> {
            Ok(())
        }

        fn step(&mut self, _: f64, _: &[f64], _: f64) -> Result<(), Failure> {
            Ok(())
        }
    }

    impl Capabilities for Ported {}

    #[test]
    fn a_force_displacement_coupling_has_a_position_and_a_velocity_for_each_force_and_nothing_else() {
        use Quantity::{Force, Position, Velocity};
        for (outputs, inputs, fits) in [
            (&[Force][..], &[Position, Velocity][..], true),
            (&[Force, Force], &[Position, Position, Velocity, Velocity], true),
            (&[], &[], false),
            (&[Force], &[Velocity], false),
            (&[Force], &[Position], false),
            (&[Force, Velocity], &[Position, Velocity], false),
            (&[Force], &[Position, Velocity, Force], false),
        ] {
            let of = |list: &[Quantity]| list.iter().map(|quantity| Port::new("row", *quantity)).collect::<Vec<_>>();
            let ports = Ports { inputs: of(inputs), outputs: of(outputs), direct_feedthrough: false };
            let (mechanics, actuator) = (Ported { ports: ports.facing() }, Ported { ports });
            assert_eq!(is_force_displacement(&mechanics, &actuator), fits, "{outputs:?} {inputs:?}");
        }
    }
}
