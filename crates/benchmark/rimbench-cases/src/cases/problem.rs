//! A case as a page of text, from which it can be built again without this program: the texts of its models, with its
//! numbers in them. A text lies beside the code that it is about and is its documentation as well.

use super::case::Case;
use crate::parameter::{Parameters, Value};
use rimbench_core::error::{Error, Result};

const CONTACTS: &str = include_str!("contacts.md");
const COMPLIANT: &str = include_str!("compliant.md");
const CARRIAGE: &str = include_str!("../models/carriage.md");
const CYLINDER: &str = include_str!("../models/hydraulic_cylinder.md");
const RAMP: &str = include_str!("spool_ramp.md");
const EQUILIBRIUM: &str = include_str!("equilibrium.md");
const WEDGE_BOX: &str = include_str!("../models/wedge_box.md");
const LOADER: &str = include_str!("loader.md");

/// The texts of a case, by its name; none where they are not written yet.
fn texts(case: &str) -> Vec<&'static str> {
    let springs = |mass: &'static str| vec![mass, CONTACTS, CARRIAGE];
    let pushed = |parts: &[&'static str]| [parts, &[CONTACTS, COMPLIANT, CYLINDER, RAMP]].concat();
    match case {
        "rocking-block" => pushed(&[include_str!("rocking_block.md")]),
        "wedge-box" => pushed(&[WEDGE_BOX, include_str!("friction.md")]),
        "n-wedge-box" => pushed(&[WEDGE_BOX, include_str!("many_wedges.md")]),
        "wedge-box-two-ledges" => pushed(&[include_str!("two_ledges.md")]),
        "bouncing-ball" => springs(include_str!("ball.md")),
        "impact-oscillator" => springs(include_str!("shaken.md")),
        "slider-between-stops" => springs(include_str!("slider.md")),
        "beam-on-stops" => springs(include_str!("beam_on_stops.md")),
        "cradle" => springs(include_str!("cradle.md")),
        "elastic-bar" => springs(include_str!("elastic_bar.md")),
        "half-car" => vec![include_str!("half_car.md"), CONTACTS, include_str!("../models/strut.md")],
        "gripper" => vec![include_str!("gripper.md"), CONTACTS, CYLINDER],
        "excavator-arm" => vec![include_str!("excavator_arm.md"), CONTACTS, CYLINDER, EQUILIBRIUM],
        "disc-row" => vec![LOADER, include_str!("disc_row.md"), CONTACTS, CYLINDER],
        "disc-pile" => vec![LOADER, include_str!("disc_pile.md"), CONTACTS, CYLINDER],
        "hydraulic-crane" => {
            vec![include_str!("../models/crane.md"), include_str!("hydraulic_crane.md"), CYLINDER, EQUILIBRIUM]
        }
        "crane-set-down" => {
            let crane = include_str!("../models/crane_with_rope.md");
            vec![crane, include_str!("crane_set_down.md"), CONTACTS, CYLINDER, EQUILIBRIUM]
        }
        _ => Vec::new(),
    }
}

/// Returns what a case with these parameters is: equations, laws of contact and impact, frames and signs, start, and the
/// shape of the command, each parameter with its value and unit.
///
/// # Errors
/// [`Error::Incompatible`] for a case that has no text.
pub fn problem_text(case: &Case, parameters: &Parameters) -> Result<String> {
    let texts = texts(&case.name);
    if texts.is_empty() {
        let message =
            format!("case {}: there is no text of its equations yet; see its page below docs/cases", case.name);
        return Err(Error::Incompatible(message));
    }
    let mut page = format!("# {}\n\n{}.\n\n{}", case.name, case.about, texts.join("\n"));
    for (parameter, value) in parameters.iter() {
        let value = match value {
            Value::Number(number) => format!("{number:?}"),
            Value::Choice(choice) => choice.to_string(),
        };
        let unit = if &*parameter.unit == "-" { "" } else { &parameter.unit };
        page = page.replace(&format!("{{{}}}", parameter.name), format!("{value} {unit}").trim_end());
    }
    Ok(page)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases::standard_cases;
    use std::collections::BTreeSet;

    #[test]
    fn a_text_names_every_parameter_of_its_case_and_none_that_is_not() {
        let mut written = 0;
        for case in standard_cases() {
            let text = texts(&case.name).concat();
            let places = text.split('{').skip(1).map(|rest| rest.split_once('}').unwrap().0.to_owned());
            let named: BTreeSet<String> = places.collect();
            let known: BTreeSet<String> = case.parameters.iter().map(|parameter| parameter.name.to_string()).collect();
            let page = problem_text(&case, &case.default_parameters());
            assert_eq!(page.is_err(), text.is_empty());
            let Ok(page) = page else { continue };
            assert_eq!(named, known, "{}", case.name);
            assert!(!page.contains(['{', '}']), "{page}");
            written += 1;
        }
        assert_eq!(written, 17);
    }

    #[test]
    fn numbers_that_are_set_stand_in_the_text_with_their_units() {
        let case = standard_cases().into_iter().find(|case| &*case.name == "rocking-block").unwrap();
        let mut parameters = case.default_parameters();
        parameters.set("start_angle_rad", "0.04").unwrap();
        let page = problem_text(&case, &parameters).unwrap();
        assert!(page.starts_with("# rocking-block\n\nBlock that rocks"), "{page}");
        let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(page.contains("α = 0.04 rad"), "{page}");
        assert!(page.contains("a = 6.53e-10 1/Pa and b = -1.19e-18 1/Pa²"), "{page}");
    }
}
