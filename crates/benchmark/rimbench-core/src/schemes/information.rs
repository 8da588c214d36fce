//! The knowledge that a scheme needs of the other side: the class in which it competes.

use super::entry::SchemeEntry;
use super::requirement::Requirement;
use crate::iterative::IterativeDriver;
use crate::name::by_name;

/// The knowledge that a scheme needs, from little to all. More of it makes the task easier, so that only schemes of one
/// class are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum InformationClass {
    /// The data of communication points: outputs, and nothing of how they come about.
    Samples,
    /// Also how outputs of the actuator follow its inputs: directional derivatives.
    Derivatives,
    /// Also what the actuator is made of: its volumes of oil.
    Inside,
    /// Also the mechanics reduced to its interface.
    Model,
    /// Also what comes of a step, before it is taken for good: steps can be taken again.
    Repetition,
    /// Both sides in one: no co-simulation at all.
    Whole,
}

impl InformationClass {
    /// Names and kinds, in the order of the variants.
    pub const LIST: [(&'static str, InformationClass); 6] = [
        ("samples", InformationClass::Samples),
        ("derivatives", InformationClass::Derivatives),
        ("inside", InformationClass::Inside),
        ("model", InformationClass::Model),
        ("repetition", InformationClass::Repetition),
        ("whole", InformationClass::Whole),
    ];

    /// Returns the class of a scheme, as its entry has it. Control of the macro step takes steps again, whatever the
    /// scheme: that is for the caller to add.
    pub fn of(scheme: &SchemeEntry) -> Self {
        let of_need = |need: &Requirement| match need {
            Requirement::InterfaceModel | Requirement::ListedContacts => InformationClass::Model,
            Requirement::TransmissionLines => InformationClass::Inside,
            Requirement::OutputRates | Requirement::OutputRatesIfFeedthrough => InformationClass::Derivatives,
            Requirement::Copies | Requirement::Trials => InformationClass::Repetition,
            Requirement::ForceDisplacement
            | Requirement::NoFriction
            | Requirement::Rows(_)
            | Requirement::HeldReturn
            | Requirement::NotMechanicsFirst
            | Requirement::ActuatorFirst => InformationClass::Samples,
        };
        let of_driver = match scheme.driver {
            IterativeDriver::NonIterative | IterativeDriver::AtOwnSteps(_) => InformationClass::Samples,
            IterativeDriver::Iterated(_) => InformationClass::Repetition,
            IterativeDriver::Monolithic => InformationClass::Whole,
        };
        scheme.needs.iter().map(of_need).fold(of_driver, Self::max)
    }
}

by_name!(InformationClass, LIST, "class of information");
