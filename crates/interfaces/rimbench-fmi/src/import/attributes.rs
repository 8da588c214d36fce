//! Attributes of a description: what each may say, and what is done about it. What is not in the table has no effect,
//! and a note says so.

use super::host::Type;
use roxmltree::Node;

/// The element that has an attribute.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Of {
    Model,
    CoSimulation,
    DefaultExperiment,
    /// A variable: `ScalarVariable` with its type, or the type alone as FMI 3.0 has it.
    Variable,
    /// What an output depends on: `Unknown` of `Outputs`, or `Output`.
    Output,
}

/// What an attribute may say.
#[derive(Debug, Clone, Copy)]
pub(super) enum Valid {
    Text,
    /// The name of a file in the archive.
    FileName,
    Truth,
    Number,
    /// A time of 0 or more, and finite.
    Time,
    /// A finite number.
    Finite,
    /// A reference or a place.
    Whole,
    OneOf(&'static [&'static str]),
    /// A list of the same.
    ListOf(&'static [&'static str]),
    Version,
}

/// A reason why a coupled variable of some causality may not say so.
type Refusal = fn(value: &str, causality: &str) -> Option<&'static str>;

/// One attribute.
pub(super) struct Attribute {
    pub(super) of: Of,
    pub(super) name: &'static str,
    /// In which versions of FMI it is, 2 and 3.
    versions: &'static [u8],
    pub(super) valid: Valid,
    /// Why a coupled variable may not have it.
    coupled: Option<Refusal>,
}

const BOTH: &[u8] = &[2, 3];
const TWO: &[u8] = &[2];
const THREE: &[u8] = &[3];

const CAUSALITY: &[&str] =
    &["parameter", "calculatedParameter", "structuralParameter", "input", "output", "local", "independent"];
const KINDS: &[&str] = &["dependent", "constant", "fixed", "tunable", "discrete"];

const fn row(of: Of, name: &'static str, versions: &'static [u8], valid: Valid) -> Attribute {
    Attribute { of, name, versions, valid, coupled: None }
}

const fn refused(name: &'static str, versions: &'static [u8], valid: Valid, coupled: Refusal) -> Attribute {
    Attribute { of: Of::Variable, name, versions, valid, coupled: Some(coupled) }
}

/// All of them. The remark behind a row says what it does here.
#[rustfmt::skip]
pub(super) const ATTRIBUTES: &[Attribute] = &[
    row(Of::Model, "fmiVersion", BOTH, Valid::Version),
    row(Of::Model, "guid", TWO, Valid::Text),                      // wanted; handed to the instance
    row(Of::Model, "instantiationToken", THREE, Valid::Text),      // likewise
    row(Of::Model, "variableNamingConvention", BOTH, Valid::OneOf(&["flat", "structured"])),
    row(Of::CoSimulation, "modelIdentifier", BOTH, Valid::FileName), // wanted; the name of the library
    row(Of::CoSimulation, "needsExecutionTool", BOTH, Valid::Truth), // a note, and the reason where no instance can be made
    row(Of::CoSimulation, "canHandleVariableCommunicationStepSize", BOTH, Valid::Truth), // without it steps are equal
    row(Of::CoSimulation, "canBeInstantiatedOnlyOncePerProcess", BOTH, Valid::Truth),    // needs a process of its own
    row(Of::CoSimulation, "canNotUseMemoryManagementFunctions", TWO, Valid::Truth),      // it need not use ours
    row(Of::CoSimulation, "canGetAndSetFMUstate", TWO, Valid::Truth),  // copies, iterations, probing
    row(Of::CoSimulation, "canGetAndSetFMUState", THREE, Valid::Truth),
    row(Of::CoSimulation, "canSerializeFMUstate", TWO, Valid::Truth),  // never asked for, like the following
    row(Of::CoSimulation, "canSerializeFMUState", THREE, Valid::Truth),
    row(Of::CoSimulation, "canInterpolateInputs", TWO, Valid::Truth),
    row(Of::CoSimulation, "canRunAsynchronuously", TWO, Valid::Truth), // spelt so; it is told that nothing waits for it
    row(Of::CoSimulation, "maxOutputDerivativeOrder", BOTH, Valid::Whole),
    row(Of::CoSimulation, "recommendedIntermediateInputSmoothness", THREE, Valid::Finite),
    row(Of::CoSimulation, "providesIntermediateUpdate", THREE, Valid::Truth), // it is told that there is none, like the following
    row(Of::CoSimulation, "mightReturnEarlyFromDoStep", THREE, Valid::Truth),
    row(Of::CoSimulation, "canReturnEarlyAfterIntermediateUpdate", THREE, Valid::Truth),
    row(Of::CoSimulation, "hasEventMode", THREE, Valid::Truth),
    row(Of::CoSimulation, "providesEvaluateDiscreteStates", THREE, Valid::Truth),
    row(Of::CoSimulation, "providesAdjointDerivatives", THREE, Valid::Truth),
    row(Of::CoSimulation, "providesPerElementDependencies", THREE, Valid::Truth),
    row(Of::CoSimulation, "providesDirectionalDerivative", TWO, Valid::Truth), // rates, where a variable is the derivative of an output
    row(Of::CoSimulation, "providesDirectionalDerivatives", THREE, Valid::Truth),
    row(Of::CoSimulation, "fixedInternalStepSize", BOTH, Valid::Time),      // of which steps are multiples
    row(Of::DefaultExperiment, "startTime", BOTH, Valid::Finite),           // its time then, when a run begins
    row(Of::DefaultExperiment, "stopTime", BOTH, Valid::Finite),            // the case file says how long a run is
    row(Of::DefaultExperiment, "tolerance", BOTH, Valid::Finite),           // its own, as none is given
    row(Of::DefaultExperiment, "stepSize", BOTH, Valid::Finite),            // the case file says the steps
    row(Of::Variable, "name", BOTH, Valid::Text),
    row(Of::Variable, "valueReference", BOTH, Valid::Whole),
    row(Of::Variable, "description", BOTH, Valid::Text),
    row(Of::Variable, "causality", BOTH, Valid::OneOf(CAUSALITY)),          // that of its place in the case file
    refused("variability", BOTH, Valid::OneOf(&["constant", "fixed", "tunable", "discrete", "continuous"]),
        |value, causality| match (value, causality) {                       // what is discrete has no rates
            ("fixed" | "tunable", _) => Some("a coupling variable changes from step to step; valid: discrete, continuous"),
            ("constant", "input") => Some("an input is set in each step; valid: discrete, continuous"),
            _ => None,
        }),
    refused("initial", BOTH, Valid::OneOf(&["exact", "approx", "calculated"]),       // whether `start` of a side may name it
        |value, causality| match (value, causality) {
            ("calculated", "input") => Some("the other side says what an input begins with; valid: none"),
            _ => None,
        }),
    refused("clocks", THREE, Valid::Text,
        |_, _| Some("it counts when these clocks tick, and clocks take event mode, which is not used; valid: a variable without clocks")),
    row(Of::Variable, "previous", THREE, Valid::Whole),                     // the FMU's own business
    row(Of::Variable, "intermediateUpdate", THREE, Valid::Truth),           // there is none
    row(Of::Variable, "canHandleMultipleSetPerTimeInstant", BOTH, Valid::Truth),     // of model exchange, like `reinit`
    row(Of::Variable, "reinit", BOTH, Valid::Truth),
    row(Of::Variable, "declaredType", BOTH, Valid::Text),                   // one that is there; what it says and the variable does not
    row(Of::Variable, "quantity", BOTH, Valid::Text),
    row(Of::Variable, "unit", BOTH, Valid::Text),                           // one that is defined
    row(Of::Variable, "displayUnit", BOTH, Valid::Text),
    row(Of::Variable, "relativeQuantity", BOTH, Valid::Truth),              // without the offset of its unit
    row(Of::Variable, "unbounded", BOTH, Valid::Truth),
    row(Of::Variable, "min", BOTH, Valid::Number),                          // an input below is the end of a run, a start is refused
    row(Of::Variable, "max", BOTH, Valid::Number),                          // likewise above
    row(Of::Variable, "nominal", BOTH, Valid::Number),
    row(Of::Variable, "start", BOTH, Valid::Text),                          // of its type; where it begins, the FMU knows
    row(Of::Variable, "derivative", BOTH, Valid::Whole),                    // a variable that is there
    row(Of::Output, "index", TWO, Valid::Whole),                            // a variable that is there
    row(Of::Output, "valueReference", THREE, Valid::Whole),
    row(Of::Output, "dependencies", BOTH, Valid::Text),                     // variables that are there; direct feedthrough
    row(Of::Output, "dependenciesKind", BOTH, Valid::ListOf(KINDS)),        // as many as dependencies; each of them is one
];

impl Valid {
    fn admits(self, text: &str) -> bool {
        let text = text.trim();
        let number = || text.parse::<f64>().ok().filter(|number| !number.is_nan());
        match self {
            Valid::Text => true,
            Valid::FileName => !text.is_empty() && !text.contains(['/', '\\']),
            Valid::Truth => truth(text).is_some(),
            Valid::Number => number().is_some(),
            Valid::Finite => number().is_some_and(f64::is_finite),
            Valid::Time => number().is_some_and(|number| number.is_finite() && number >= 0.0),
            Valid::Whole => text.parse::<u32>().is_ok(),
            Valid::OneOf(words) => words.contains(&text),
            Valid::ListOf(words) => text.split_whitespace().all(|word| words.contains(&word)),
            Valid::Version => {
                let minor = text.strip_prefix("3.").map(|rest| rest.split('.'));
                text == "2.0" || minor.is_some_and(|mut parts| parts.all(|part| part.parse::<u32>().is_ok()))
            }
        }
    }

    fn words(self) -> String {
        match self {
            Valid::Text => "a text".to_owned(),
            Valid::FileName => "a name without / and \\".to_owned(),
            Valid::Truth => "true, false".to_owned(),
            Valid::Number => "a number".to_owned(),
            Valid::Finite => "a finite number".to_owned(),
            Valid::Time => "a finite time of 0 or more".to_owned(),
            Valid::Whole => format!("a whole number from 0 to {}", u32::MAX),
            Valid::OneOf(words) => words.join(", "),
            Valid::ListOf(words) => format!("a list of {}", words.join(", ")),
            Valid::Version => "2.0, 3.0, a later 3.x".to_owned(),
        }
    }
}

impl Attribute {
    fn is_of(&self, of: Of, two: bool) -> bool {
        self.of == of && self.versions.contains(if two { &2 } else { &3 })
    }

    /// # Errors
    /// What it says instead of what is valid.
    fn check(&self, value: &str) -> Result<(), String> {
        if self.valid.admits(value) {
            return Ok(());
        }
        Err(format!("{} = {value} is not valid; valid: {}", self.name, self.valid.words()))
    }
}

/// A truth of XML.
pub(super) fn truth(text: &str) -> Option<bool> {
    match text.trim() {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}

/// Attributes that the table has none of.
type Unknown = Vec<String>;

/// Checks the attributes of an element.
///
/// # Errors
/// The first that says what it may not.
pub(super) fn check(of: Of, node: Node<'_, '_>, two: bool) -> Result<Unknown, String> {
    let mut unknown = Vec::new();
    for attribute in node.attributes().filter(|attribute| attribute.namespace().is_none()) {
        match ATTRIBUTES.iter().find(|row| row.is_of(of, two) && row.name == attribute.name()) {
            Some(row) => row.check(attribute.value())?,
            None => unknown.push(attribute.name().to_owned()),
        }
    }
    Ok(unknown)
}

/// Why a variable may not be coupled, by its attributes.
pub(super) fn uncoupled(node: Node<'_, '_>, two: bool) -> Option<String> {
    let causality = node.attribute("causality").unwrap_or("local");
    ATTRIBUTES.iter().filter(|row| row.is_of(Of::Variable, two)).find_map(|row| {
        let value = node.attribute(row.name)?;
        let why = row.coupled?(value.trim(), causality)?;
        Some(format!("{} = {value}: {why}", row.name))
    })
}

/// Checks start values against a type.
///
/// # Errors
/// What would be valid.
pub(super) fn check_start(kind: Type, values: &[String]) -> Result<(), String> {
    let is_valid = |text: &String| match kind {
        Type::Float64 | Type::Float32 => Valid::Number.admits(text) || text.trim() == "NaN",
        Type::Boolean => truth(text).is_some(),
        _ => match kind.whole() {
            Some([least, most]) => text.trim().parse::<i128>().is_ok_and(|number| (least..=most).contains(&number)),
            None => true,
        },
    };
    let Some(wrong) = values.iter().find(|text| !is_valid(text)) else { return Ok(()) };
    let valid = match (kind, kind.whole()) {
        (Type::Boolean, _) => "true, false".to_owned(),
        (_, Some([least, most])) => format!("a whole number from {least} to {most}"),
        _ => "a number".to_owned(),
    };
    Err(format!("start = {wrong} is not valid; valid: {valid}"))
}

#[cfg(test)]
mod tests {
    use super::super::description::Description;
    use super::*;

    /// A description with an attribute in its place, instead of one that may be there already.
    fn described(row: &Attribute, value: &str, two: bool) -> String {
        let at = |of: Of, usual: &[(&str, &str)]| {
            let own = (row.of == of).then_some((row.name, value));
            let usual = usual.iter().filter(|(name, _)| own.is_none_or(|(own, _)| own != *name)).copied();
            usual.chain(own).map(|(name, value)| format!(" {name}=\"{value}\"")).collect::<String>()
        };
        let version = if two { "2.0" } else { "3.0" };
        let variable = [("name", "f"), ("valueReference", "1"), ("causality", "output")];
        let variable = if two
            && ["min", "max", "nominal", "start", "derivative", "relativeQuantity", "unbounded", "reinit"]
                .contains(&row.name)
        {
            format!(
                "<ScalarVariable name=\"f\" valueReference=\"1\" causality=\"output\"><Real {}=\"{value}\"/></ScalarVariable>",
                row.name
            )
        } else if two {
            format!("<ScalarVariable{}><Real/></ScalarVariable>", at(Of::Variable, &variable))
        } else {
            format!("<Float64{}/>", at(Of::Variable, &variable))
        };
        let output = at(Of::Output, &[(if two { "index" } else { "valueReference" }, "1"), ("dependencies", "1")]);
        let output = if two { format!("<Outputs><Unknown{output}/></Outputs>") } else { format!("<Output{output}/>") };
        format!(
            "<fmiModelDescription{}><CoSimulation{}/><DefaultExperiment{}/><ModelVariables>{variable}</ModelVariables>\
             <ModelStructure>{output}</ModelStructure></fmiModelDescription>",
            at(Of::Model, &[("fmiVersion", version), (if two { "guid" } else { "instantiationToken" }, "x")]),
            at(Of::CoSimulation, &[("modelIdentifier", "x")]),
            at(Of::DefaultExperiment, &[]),
        )
    }

    #[test]
    fn each_attribute_that_says_what_it_may_not_is_named_with_what_is_valid() {
        let mut tried = 0;
        for row in ATTRIBUTES {
            for two in row.versions.iter().map(|version| *version == 2) {
                let bad: &[&str] = match (row.valid, row.name) {
                    (Valid::Text, "start") => &["x", "1,0"],
                    (Valid::Text, "dependencies") => &["77", "two"],
                    (Valid::Text, "declaredType") if !two => &["Force"],
                    // A text may be any, or what it means is tried with the library (tests/interfaces/attributes.rs).
                    (Valid::Text, _) => continue,
                    (Valid::FileName, _) => &["", "../x", "/etc/x", "a\\x"],
                    (Valid::Truth, _) => &["maybe", "yes", ""],
                    (Valid::Number, _) => &["low", "NaN"],
                    (Valid::Finite, _) => &["soon", "INF"],
                    (Valid::Time, _) => &["-1", "INF", "short"],
                    (Valid::Whole, _) => &["two", "-1", "1.5"],
                    (Valid::OneOf(_), _) => &["sideways", "Input"],
                    (Valid::ListOf(_), _) => &["perhaps", "dependent dependent"],
                    (Valid::Version, _) => &["1.0", "3.0-beta.2", "3", "2.1", "3.x", "4.0"],
                };
                for value in bad {
                    let text = described(row, value, two);
                    let said = match Description::parse(&text) {
                        Err(message) => message,
                        Ok(description) => description.variables[0].fault.clone().unwrap_or_default(),
                    };
                    let named = said.contains(row.name) || said.contains("declared type");
                    assert!(
                        named && said.contains(value) || said.contains("2 words"),
                        "{} = {value}, {two}: {said:?}",
                        row.name
                    );
                    assert!(said.contains("valid: ") || said.contains("not among"), "{} = {value}: {said}", row.name);
                    tried += 1;
                }
            }
        }
        assert!(tried > 100, "{tried}");
        // Values that the standard allows are accepted.
        for (of, name, value) in [
            (Of::Model, "fmiVersion", "3.1"),
            (Of::Model, "fmiVersion", "3.0.2"),
            (Of::CoSimulation, "needsExecutionTool", "0"),
            (Of::DefaultExperiment, "startTime", "-1.5"),
            (Of::Variable, "max", "INF"),
            (Of::Variable, "start", "1e3"),
            (Of::Output, "dependenciesKind", "fixed"),
        ] {
            let row = ATTRIBUTES.iter().find(|row| row.of == of && row.name == name).unwrap();
            let description = Description::parse(&described(row, value, false)).unwrap();
            assert_eq!((&description.variables[0].fault, description.notes.len()), (&None, 0), "{name}");
        }
    }

    #[test]
    fn what_a_coupled_variable_may_not_be_is_named_and_what_it_may_be_is_taken() {
        for (name, value, causality, refused) in [
            ("variability", "constant", "input", true),
            ("variability", "constant", "output", false),
            ("variability", "fixed", "output", true),
            ("variability", "tunable", "input", true),
            ("variability", "discrete", "input", false),
            ("initial", "calculated", "input", true),
            ("initial", "exact", "input", false),
            ("initial", "calculated", "output", false),
            ("clocks", "5", "output", true),
            ("clocks", "5", "input", true),
        ] {
            let text = format!("<Float64 name=\"f\" causality=\"{causality}\" {name}=\"{value}\"/>");
            let document = roxmltree::Document::parse(&text).unwrap();
            let said = uncoupled(document.root_element(), false);
            assert_eq!(said.is_some(), refused, "{text}: {said:?}");
            assert!(said.is_none_or(|said| said.contains(&format!("{name} = {value}")) && said.contains("valid: ")));
        }
    }
}
