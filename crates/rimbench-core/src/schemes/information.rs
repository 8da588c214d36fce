//! The knowledge that a scheme needs of the other side: the class in which it competes.

use super::entry::SchemeEntry;
use super::requirement::Requirement;
use crate::iterative::IterativeDriver;
use crate::name::by_name;

/// The knowledge that a scheme needs, from little to all. More of it makes the task easier, so that only schemes of one class are compared.
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

    /// Returns the class of a scheme, as its entry has it. Control of the macro step takes steps again, whatever the scheme: that is for the
    /// caller to add.
    pub fn of(scheme: &SchemeEntry) -> Self {
        let of_need = |need: &Requirement| match need {
            Requirement::InterfaceModel | Requirement::ListedContacts => InformationClass::Model,
            Requirement::TransmissionLines => InformationClass::Inside,
            Requirement::OutputRates | Requirement::OutputRatesIfFeedthrough => InformationClass::Derivatives,
            Requirement::Copies => InformationClass::Repetition,
            Requirement::ForceDisplacement
            | Requirement::NoFriction
            | Requirement::Rows(_)
            | Requirement::SeveralRows
            | Requirement::HeldReturn
            | Requirement::NotMechanicsFirst => InformationClass::Samples,
        };
        let of_driver = match scheme.driver {
            IterativeDriver::NonIterative => InformationClass::Samples,
            IterativeDriver::Iterated(_) => InformationClass::Repetition,
            IterativeDriver::Monolithic => InformationClass::Whole,
        };
        scheme.needs.iter().map(of_need).fold(of_driver, Self::max)
    }
}

by_name!(InformationClass, LIST, "class of information");

#[cfg(test)]
mod tests {
    use super::super::standard_schemes;
    use super::*;

    #[test]
    fn the_class_of_a_scheme_is_the_most_that_it_asks_for() {
        let class = |name: &str| {
            let entry = standard_schemes().into_iter().find(|entry| entry.name == name).unwrap();
            InformationClass::of(&entry).to_string()
        };
        for (name, wanted) in [
            ("zero-order-hold", "samples"),
            ("integral-correction-first-order", "derivatives"),
            ("hydraulic-line", "inside"),
            // It asks for derivatives as well.
            ("interface-jacobian", "model"),
            ("rim-nonsmooth-gap", "model"),
            ("iterated-aitken", "repetition"),
            ("monolithic", "whole"),
        ] {
            assert_eq!(class(name), wanted, "{name}");
        }
        assert_eq!("model".parse::<InformationClass>().unwrap(), InformationClass::Model);
        assert!("modell".parse::<InformationClass>().unwrap_err().to_string().contains("did you mean `model`"));
    }
}
