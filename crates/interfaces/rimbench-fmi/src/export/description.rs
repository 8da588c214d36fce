//! `modelDescription.xml`.

use super::units::{BASE, exponents};
use super::variables::{Kind, Variable, Variables, is_choice};
use super::{Contents, text};
use crate::model_parts::PartType;
use rimbench_cases::cases::Parameters;
use rimbench_cases::runs::RunSpec;
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
    let Contents { case, side, .. } = contents;
    writeln!(
        xml,
        "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{case} {side}\" instantiationToken=\"{}\" description=\"{}: the {side}\" \
         generationTool=\"rimbench {}\" variableNamingConvention=\"structured\">",
        contents.token(),
        escaped(&spec.case.about),
        env!("CARGO_PKG_VERSION"),
    )?;
    let derivatives = variables.rates || !variables.feedthrough;
    writeln!(
        xml,
        "  <CoSimulation modelIdentifier=\"{}\" canHandleVariableCommunicationStepSize=\"true\" canGetAndSetFMUState=\"{1}\" \
         canSerializeFMUState=\"{1}\" providesDirectionalDerivatives=\"{derivatives}\"/>",
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
    write_structure(xml, variables)?;
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
            more = of.map_or(String::new(), |of| format!(" derivative=\"{of}\""));
            "causality=\"output\" variability=\"continuous\""
        }
        Kind::Parameter(k) => {
            if let Some((_, value)) = parameters.iter().nth(k) {
                if is_choice(value) {
                    kind = "String";
                    inner = format!("<Start value=\"{}\"/>", escaped(&text(value)));
                } else {
                    start = Some(text(value));
                }
            }
            "causality=\"parameter\" variability=\"fixed\""
        }
        Kind::LongestStep => {
            start = Some(format!("{:?}", contents.longest_step_s));
            more = " min=\"0\"".to_owned();
            "causality=\"parameter\" variability=\"tunable\""
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
        Kind::Model(_) | Kind::Observable(_) | Kind::InterfaceWork => "causality=\"local\" variability=\"continuous\"",
    };
    for extent in &variable.dimensions {
        inner += &format!("<Dimension start=\"{extent}\"/>");
    }
    write!(
        xml,
        "    <{kind} name=\"{}\" valueReference=\"{reference}\" {causality} description=\"{}\"",
        escaped(&variable.name),
        escaped(&variable.about)
    )?;
    if !variable.unit.is_empty() {
        write!(xml, " unit=\"{}\"", escaped(&variable.unit))?;
    }
    write!(xml, "{more}")?;
    if let Some(start) = start {
        write!(xml, " start=\"{start}\"")?;
    }
    if inner.is_empty() { writeln!(xml, "/>") } else { writeln!(xml, ">{inner}</{kind}>") }
}

fn write_structure(xml: &mut String, variables: &Variables) -> std::fmt::Result {
    let list = || variables.list.iter().enumerate();
    let inputs: Vec<String> =
        list().filter(|(_, other)| matches!(other.kind, Kind::Input(_))).map(|(at, _)| at.to_string()).collect();
    let outputs = || list().filter(|(_, other)| matches!(other.kind, Kind::Output(_) | Kind::Rate(_)));
    writeln!(xml, "  <ModelStructure>")?;
    for (at, variable) in outputs() {
        match variable.kind {
            Kind::Output(_) if !variables.feedthrough => {
                writeln!(xml, "    <Output valueReference=\"{at}\" dependencies=\"\"/>")?
            }
            _ => writeln!(xml, "    <Output valueReference=\"{at}\" dependencies=\"{}\"/>", inputs.join(" "))?,
        }
    }
    for (at, _) in outputs() {
        writeln!(xml, "    <InitialUnknown valueReference=\"{at}\"/>")?;
    }
    writeln!(xml, "  </ModelStructure>")
}
