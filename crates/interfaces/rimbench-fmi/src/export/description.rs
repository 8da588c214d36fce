//! `modelDescription.xml`.

use super::units::{BASE, exponents};
use super::variables::{Kind, Variable, Variables, is_choice};
use super::{Contents, Fmi, text};
use crate::model_parts::PartType;
use rimbench_cases::parameter::Parameters;
use rimbench_runs::RunSpec;
use std::collections::BTreeSet;
use std::fmt::Write;

/// A text as an attribute.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '"' => out.push_str("&quot;"),
            c => out.push(c),
        }
    }
    out
}

/// Writes what a master must know of one side of the case of a run.
pub(super) fn description(spec: &RunSpec, contents: &Contents, variables: &Variables) -> String {
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    // A text grows without fail.
    let _ = write(&mut xml, spec, contents, variables);
    xml
}

fn write(xml: &mut String, spec: &RunSpec, contents: &Contents, variables: &Variables) -> std::fmt::Result {
    let Contents { case, side, fmi, .. } = contents;
    let [version, token, state, derivative] = match fmi {
        Fmi::Two => ["2.0", "guid", "FMUstate", "Derivative"],
        Fmi::Three => ["3.0", "instantiationToken", "FMUState", "Derivatives"],
    };
    writeln!(
        xml,
        "<fmiModelDescription fmiVersion=\"{version}\" modelName=\"{case} {side}\" {token}=\"{}\" description=\"{}: the {side}\" \
         generationTool=\"rimbench {}\" variableNamingConvention=\"structured\">",
        contents.token(),
        escaped(&spec.case.about),
        env!("CARGO_PKG_VERSION"),
    )?;
    let derivatives = variables.rates || !variables.feedthrough;
    writeln!(
        xml,
        "  <CoSimulation modelIdentifier=\"{}\" canHandleVariableCommunicationStepSize=\"true\" canGetAndSet{state}=\"{1}\" \
         canSerialize{state}=\"{1}\" providesDirectional{derivative}=\"{derivatives}\"/>",
        crate::LIBRARY,
        variables.copies,
    )?;
    let units: BTreeSet<&str> =
        variables.list.iter().map(|variable| &*variable.unit).filter(|unit| !unit.is_empty()).collect();
    writeln!(xml, "  <UnitDefinitions>")?;
    for unit in units {
        match exponents(unit) {
            None => writeln!(xml, "    <Unit name=\"{}\"/>", escaped(unit))?,
            Some(exponents) => {
                write!(xml, "    <Unit name=\"{}\"><BaseUnit", escaped(unit))?;
                for (name, exponent) in BASE.iter().zip(exponents).filter(|(_, exponent)| *exponent != 0) {
                    write!(xml, " {name}=\"{exponent}\"")?;
                }
                writeln!(xml, "/></Unit>")?;
            }
        }
    }
    writeln!(xml, "  </UnitDefinitions>")?;
    writeln!(xml, "  <LogCategories><Category name=\"error\" description=\"Why a call failed\"/></LogCategories>")?;
    writeln!(
        xml,
        "  <DefaultExperiment startTime=\"0\" stopTime=\"{:?}\" stepSize=\"{:?}\"/>",
        spec.duration, spec.macro_step
    )?;
    writeln!(xml, "  <ModelVariables>")?;
    for (reference, variable) in variables.list.iter().enumerate() {
        write_variable(xml, reference, variable, contents, &spec.parameters, variables)?;
    }
    writeln!(xml, "  </ModelVariables>")?;
    match fmi {
        Fmi::Two => write_structure_2(xml, variables)?,
        Fmi::Three => write_structure(xml, variables)?,
    }
    writeln!(xml, "</fmiModelDescription>")
}

fn write_variable(
    xml: &mut String,
    reference: usize,
    variable: &Variable,
    contents: &Contents,
    parameters: &Parameters,
    variables: &Variables,
) -> std::fmt::Result {
    let mut kind = "Float64";
    let mut start = None;
    let mut inner = String::new();
    let mut more = String::new();
    let causality = match variable.kind {
        Kind::Time => "causality=\"independent\" variability=\"continuous\"",
        Kind::Input(k) => {
            start = Some(format!("{:?}", contents.input_starts.get(k).copied().unwrap_or(0.0)));
            "causality=\"input\" variability=\"continuous\""
        }
        Kind::Output(_) => "causality=\"output\" variability=\"continuous\"",
        Kind::Rate(k) => {
            let of = variables.list.iter().position(|other| other.kind == Kind::Output(k));
            let place = |of: usize| if contents.fmi == Fmi::Two { of + 1 } else { of };
            more = of.map_or(String::new(), |of| format!(" derivative=\"{}\"", place(of)));
            "causality=\"output\" variability=\"continuous\""
        }
        Kind::Parameter(k) => {
            if let Some((_, value)) = parameters.iter().nth(k) {
                kind = if is_choice(value) { "String" } else { kind };
                start = Some(escaped(&text(value)));
            }
            "causality=\"parameter\" variability=\"fixed\""
        }
        Kind::LongestStep => {
            start = Some(format!("{:?}", contents.longest_step_s));
            more = " min=\"0\"".to_owned();
            "causality=\"parameter\" variability=\"tunable\""
        }
        Kind::Wait => {
            (start, more) = (Some("0.0".to_owned()), " min=\"0\"".to_owned());
            "causality=\"parameter\" variability=\"fixed\""
        }
        Kind::Serialisable => {
            (kind, start) = ("Boolean", Some("true".to_owned()));
            "causality=\"parameter\" variability=\"fixed\""
        }
        Kind::ModelStep => {
            start = Some(format!("{:?}", contents.model_step_s));
            "causality=\"parameter\" variability=\"tunable\""
        }
        // Local, so that a master that reads all outputs as numbers, one each, is not stopped by what it does not know.
        Kind::Model(part) if part.part_type != PartType::Number => {
            kind = if part.part_type == PartType::Truth { "Boolean" } else { "Int32" };
            "causality=\"local\" variability=\"discrete\""
        }
        Kind::Model(_) | Kind::Observable(_) | Kind::InterfaceWork | Kind::WorkSent => {
            "causality=\"local\" variability=\"continuous\""
        }
    };
    if !variable.unit.is_empty() {
        more = format!(" unit=\"{}\"{more}", escaped(&variable.unit));
    }
    if let Some(start) = start {
        match (kind, contents.fmi) {
            ("String", Fmi::Three) => inner = format!("<Start value=\"{start}\"/>"),
            _ => more += &format!(" start=\"{start}\""),
        }
    }
    for extent in &variable.dimensions {
        inner += &format!("<Dimension start=\"{extent}\"/>");
    }
    let (name, about) = (escaped(&variable.name), escaped(&variable.about));
    let said = format!("name=\"{name}\" valueReference=\"{reference}\" {causality} description=\"{about}\"");
    match contents.fmi {
        Fmi::Two => {
            let kind = if kind == "Float64" { "Real" } else { kind };
            writeln!(xml, "    <ScalarVariable {said}><{kind}{more}/></ScalarVariable>")
        }
        Fmi::Three if inner.is_empty() => writeln!(xml, "    <{kind} {said}{more}/>"),
        Fmi::Three => writeln!(xml, "    <{kind} {said}{more}>{inner}</{kind}>"),
    }
}

/// Outputs by their places, each with the places of the inputs that it depends on at once.
fn outputs(variables: &Variables) -> Vec<(usize, Vec<usize>)> {
    let list = || variables.list.iter().enumerate();
    let inputs = || list().filter(|(_, other)| matches!(other.kind, Kind::Input(_))).map(|(at, _)| at);
    list()
        .filter_map(|(at, variable)| match variable.kind {
            Kind::Output(_) if !variables.feedthrough => Some((at, Vec::new())),
            Kind::Output(_) | Kind::Rate(_) => Some((at, inputs().collect())),
            _ => None,
        })
        .collect()
}

fn listed(places: &[usize], first: usize) -> String {
    places.iter().map(|at| (at + first).to_string()).collect::<Vec<_>>().join(" ")
}

fn write_structure(xml: &mut String, variables: &Variables) -> std::fmt::Result {
    let outputs = outputs(variables);
    writeln!(xml, "  <ModelStructure>")?;
    for (at, on) in &outputs {
        writeln!(xml, "    <Output valueReference=\"{at}\" dependencies=\"{}\"/>", listed(on, 0))?;
    }
    for (at, _) in &outputs {
        writeln!(xml, "    <InitialUnknown valueReference=\"{at}\"/>")?;
    }
    writeln!(xml, "  </ModelStructure>")
}

/// Likewise for FMI 2.0, which counts variables from 1.
fn write_structure_2(xml: &mut String, variables: &Variables) -> std::fmt::Result {
    let outputs = outputs(variables);
    writeln!(xml, "  <ModelStructure>\n    <Outputs>")?;
    for (at, on) in &outputs {
        writeln!(xml, "      <Unknown index=\"{}\" dependencies=\"{}\"/>", at + 1, listed(on, 1))?;
    }
    writeln!(xml, "    </Outputs>\n    <InitialUnknowns>")?;
    for (at, _) in &outputs {
        writeln!(xml, "      <Unknown index=\"{}\"/>", at + 1)?;
    }
    writeln!(xml, "    </InitialUnknowns>\n  </ModelStructure>")
}
