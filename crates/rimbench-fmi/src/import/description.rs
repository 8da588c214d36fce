//! `modelDescription.xml` as far as it is needed.

use super::host::Type;
use roxmltree::{Document, Node};
use std::collections::BTreeMap;

/// Base units of the SI and the radian, by the names of their exponents.
const BASE: [&str; 8] = ["kg", "m", "s", "rad", "A", "K", "mol", "cd"];

/// Exponents of [`BASE`].
pub(super) type Exponents = [i32; BASE.len()];

pub(super) const LENGTH: Exponents = [0, 1, 0, 0, 0, 0, 0, 0];
pub(super) const VELOCITY: Exponents = [0, 1, -1, 0, 0, 0, 0, 0];
pub(super) const FORCE: Exponents = [1, 1, -2, 0, 0, 0, 0, 0];
pub(super) const ENERGY: Exponents = [1, 2, -2, 0, 0, 0, 0, 0];
const TIME: Exponents = [0, 0, 1, 0, 0, 0, 0, 0];

/// Units of the SI that need no definition.
const COHERENT: [(&str, Exponents); 8] = [
    ("s", TIME),
    ("m", LENGTH),
    ("m/s", VELOCITY),
    ("m/s2", [0, 1, -2, 0, 0, 0, 0, 0]),
    ("N", FORCE),
    ("N/s", [1, 1, -3, 0, 0, 0, 0, 0]),
    ("J", ENERGY),
    ("N.m", ENERGY),
];

/// A variable of an FMU.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FmuVariable {
    pub(super) name: String,
    pub(super) reference: u32,
    pub(super) kind: Type,
    pub(super) causality: String,
    /// Whether it may be given a value before a run.
    pub(super) settable: bool,
    /// What one of its unit is in SI base units; 1 where it says none.
    pub(super) factor: f64,
    pub(super) offset: f64,
    /// Exponents of [`BASE`], where its unit says them.
    pub(super) exponents: Option<Exponents>,
    /// Its own unit or that of its declared type; empty where there is none.
    pub(super) unit: String,
    /// The value reference of the variable that this one is the derivative of.
    pub(super) derivative: Option<u32>,
    /// Extents as they are before a run; none: one value.
    pub(super) dimensions: Vec<usize>,
    /// Start values, as they are written.
    pub(super) start: Vec<String>,
}

/// What an FMU says of itself.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Description {
    pub(super) version: String,
    pub(super) token: String,
    pub(super) identifier: String,
    pub(super) keeps_state: bool,
    pub(super) derivatives: bool,
    /// Steps of any length may be taken.
    pub(super) any_step: bool,
    /// Its own step, s, of which all steps should be multiples.
    pub(super) internal_step: Option<f64>,
    /// What one of its unit of time is, s.
    pub(super) time_unit: f64,
    /// Only one instance of it may be in a process.
    pub(super) only_once: bool,
    pub(super) variables: Vec<FmuVariable>,
    /// For an output with dependencies that are listed, the value references that it depends on.
    pub(super) dependencies: BTreeMap<u32, Vec<u32>>,
}

struct Unit {
    factor: f64,
    offset: f64,
    exponents: Option<Exponents>,
}

/// What a declared type says.
#[derive(Default, Clone, Copy)]
struct DeclaredType<'a> {
    unit: Option<&'a str>,
    relative: bool,
}

type Types<'a> = BTreeMap<&'a str, DeclaredType<'a>>;

impl FmuVariable {
    /// How many values it has.
    pub(super) fn size(&self) -> usize {
        self.dimensions.iter().product()
    }

    /// Whether it is in a unit of which the FMU does not say what it is in SI base units.
    pub(super) fn is_in_unknown_unit(&self) -> bool {
        !self.unit.is_empty() && self.exponents.is_none()
    }
}

impl Description {
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let document = Document::parse(text).map_err(|error| error.to_string())?;
        let root = document.root_element();
        if root.tag_name().name() != "fmiModelDescription" {
            return Err(format!("its root is `{}`, not `fmiModelDescription`", root.tag_name().name()));
        }
        let version = root.attribute("fmiVersion").unwrap_or_default().to_owned();
        if !version.starts_with("3.") && version != "2.0" {
            return Err(format!("fmiVersion = {version} is not valid; valid: 2.0, 3.0"));
        }
        let two = version == "2.0";
        let child = |name: &str| root.children().find(|node| node.has_tag_name(name));
        let slave = child("CoSimulation").ok_or("it is not for co-simulation: there is no <CoSimulation>")?;
        let needed =
            |name: &str| slave.attribute(name).map(str::to_owned).ok_or(format!("<CoSimulation> has no {name}"));
        let flag = |name: &str| slave.attribute(name).is_some_and(|value| value == "true" || value == "1");
        let units = child("UnitDefinitions").map(read_units).transpose()?.unwrap_or_default();
        let types = child("TypeDefinitions").map(|list| read_types(list, two)).unwrap_or_default();
        let mut variables = Vec::new();
        let mut sizes = Vec::new();
        for node in child("ModelVariables").into_iter().flat_map(|list| list.children()).filter(Node::is_element) {
            let variable = read_variable(node, &units, &types, two)?;
            if variable.causality == "structuralParameter" {
                sizes.push((variable.reference, variable.start.first().and_then(|text| text.parse().ok())));
            }
            variables.push(variable);
        }
        let mut aliases = Vec::new();
        let nodes = child("ModelVariables").into_iter().flat_map(|list| list.children()).filter(Node::is_element);
        for (variable, node) in variables.iter_mut().zip(nodes) {
            let extents = node.children().filter(|node| node.has_tag_name("Dimension"));
            variable.dimensions = extents.map(|extent| read_extent(extent, &sizes)).collect();
            for alias in node.children().filter(|node| node.has_tag_name("Alias")) {
                let name =
                    alias.attribute("name").ok_or_else(|| format!("an alias of `{}` has no name", variable.name))?;
                aliases.push(FmuVariable { name: name.to_owned(), ..variable.clone() });
            }
        }
        let time_unit = unit_of_time(&variables)?;
        if two {
            // In FMI 2.0 a derivative names the place of its variable, from 1.
            let references: Vec<u32> = variables.iter().map(|variable| variable.reference).collect();
            for variable in &mut variables {
                let place = variable.derivative.and_then(|place| (place as usize).checked_sub(1));
                variable.derivative = place.and_then(|place| references.get(place).copied());
            }
        }
        let mut dependencies = BTreeMap::new();
        for output in child("ModelStructure").into_iter().flat_map(|list| list.descendants()) {
            let (place, given) = match output.tag_name().name() {
                "Output" => (output.attribute("valueReference"), output.attribute("dependencies")),
                "Unknown" if output.parent().is_some_and(|parent| parent.has_tag_name("Outputs")) => {
                    (output.attribute("index"), output.attribute("dependencies"))
                }
                _ => continue,
            };
            let reference = |text: &str| -> Option<u32> {
                let number: u32 = text.parse().ok()?;
                if two {
                    // Whole numbers have references of their own, which may be those of numbers.
                    let variable: &FmuVariable = variables.get((number as usize).checked_sub(1)?)?;
                    (variable.kind == Type::Float64).then_some(variable.reference)
                } else {
                    Some(number)
                }
            };
            if let (Some(place), Some(given)) = (place.and_then(reference), given) {
                dependencies.insert(place, given.split_whitespace().filter_map(reference).collect());
            }
        }
        variables.append(&mut aliases);
        Ok(Description {
            token: root.attribute(if two { "guid" } else { "instantiationToken" }).unwrap_or_default().to_owned(),
            identifier: needed("modelIdentifier")?,
            keeps_state: flag(if two { "canGetAndSetFMUstate" } else { "canGetAndSetFMUState" }),
            derivatives: flag(if two { "providesDirectionalDerivative" } else { "providesDirectionalDerivatives" }),
            any_step: flag("canHandleVariableCommunicationStepSize"),
            internal_step: slave
                .attribute("fixedInternalStepSize")
                .and_then(|text| text.parse().ok())
                .map(|step: f64| step * time_unit)
                .filter(|step: &f64| step.is_finite() && *step > 0.0),
            time_unit,
            only_once: flag("canBeInstantiatedOnlyOncePerProcess"),
            version,
            variables,
            dependencies,
        })
    }

    pub(super) fn is_version_2(&self) -> bool {
        self.version == "2.0"
    }

    pub(super) fn variable(&self, name: &str) -> Option<&FmuVariable> {
        self.variables.iter().find(|variable| variable.name == name)
    }

    /// Whether one variable may depend on another at once; where nothing is said it may.
    pub(super) fn depends(&self, output: u32, input: u32) -> bool {
        self.dependencies.get(&output).is_none_or(|known| known.contains(&input))
    }
}

/// Declared types by their names.
fn read_types<'a>(list: Node<'a, '_>, two: bool) -> Types<'a> {
    let types = list.children().filter(Node::is_element);
    let read = |node: Node<'a, '_>| {
        let inner = if two { node.children().find(Node::is_element)? } else { node };
        let declared = DeclaredType { unit: inner.attribute("unit"), relative: is_true(inner, "relativeQuantity") };
        Some((node.attribute("name")?, declared))
    };
    types.filter_map(read).collect()
}

fn is_true(node: Node<'_, '_>, attribute: &str) -> bool {
    node.attribute(attribute).is_some_and(|value| value == "true" || value == "1")
}

/// An extent: a number, or what a structural parameter is at the start; 0 where neither is known.
fn read_extent(extent: Node<'_, '_>, sizes: &[(u32, Option<usize>)]) -> usize {
    let said = extent.attribute("start").and_then(|text| text.parse().ok());
    let by_reference = || {
        let reference: u32 = extent.attribute("valueReference")?.parse().ok()?;
        sizes.iter().find(|(known, _)| *known == reference)?.1
    };
    said.or_else(by_reference).unwrap_or(0)
}

/// What one of the unit of the independent variable is, s.
fn unit_of_time(variables: &[FmuVariable]) -> Result<f64, String> {
    let Some(time) = variables.iter().find(|variable| variable.causality == "independent") else { return Ok(1.0) };
    match time.exponents {
        None if time.unit.is_empty() => Ok(1.0),
        Some(TIME) if time.offset == 0.0 && time.factor > 0.0 => Ok(time.factor),
        _ => Err(format!(
            "the independent variable `{}` is in `{}`, which is not defined as a time; valid: s, or a unit that has a BaseUnit with s = 1, \
             a factor above 0 and no offset",
            time.name, time.unit
        )),
    }
}

fn read_units(list: Node<'_, '_>) -> Result<BTreeMap<String, Unit>, String> {
    let mut units = BTreeMap::new();
    for node in list.children().filter(|node| node.has_tag_name("Unit")) {
        let base = node.children().find(|node| node.has_tag_name("BaseUnit"));
        let name = node.attribute("name").unwrap_or_default();
        let given = |attribute: &str| base.and_then(|base| base.attribute(attribute)).map(str::trim);
        let wrong = |attribute: &str, text: &str, valid: &str| {
            format!("unit `{name}`: {attribute} = {text} is not valid; valid: {valid}")
        };
        let number = |attribute: &str, usual: f64, valid: &str, is_valid: fn(f64) -> bool| match given(attribute) {
            None => Ok(usual),
            Some(text) => text
                .parse()
                .ok()
                .filter(|number: &f64| number.is_finite() && is_valid(*number))
                .ok_or_else(|| wrong(attribute, text, valid)),
        };
        let mut exponents = [0; BASE.len()];
        for (exponent, attribute) in exponents.iter_mut().zip(BASE) {
            if let Some(text) = given(attribute) {
                *exponent = text.parse().map_err(|_| wrong(attribute, text, "a whole number"))?;
            }
        }
        let unit = Unit {
            factor: number("factor", 1.0, "a finite number but 0", |number| number != 0.0)?,
            offset: number("offset", 0.0, "a finite number", |_| true)?,
            exponents: base.map(|_| exponents),
        };
        units.insert(name.to_owned(), unit);
    }
    Ok(units)
}

fn read_variable(
    node: Node<'_, '_>,
    units: &BTreeMap<String, Unit>,
    types: &Types<'_>,
    two: bool,
) -> Result<FmuVariable, String> {
    let name = node.attribute("name").ok_or("a variable has no name")?.to_owned();
    let reference = node.attribute("valueReference").and_then(|text| text.parse().ok());
    let reference = reference.ok_or_else(|| format!("variable `{name}` has no value reference"))?;
    let inner = if two { node.children().find(Node::is_element) } else { Some(node) };
    let inner = inner.ok_or_else(|| format!("variable `{name}` has no type"))?;
    let kind = Type::of_element(inner.tag_name().name(), two);
    let declared = match inner.attribute("declaredType") {
        None => DeclaredType::default(),
        Some(wanted) => *types.get(wanted).ok_or_else(|| {
            format!("variable `{name}` is of the declared type `{wanted}`, which is not among <TypeDefinitions>")
        })?,
    };
    let unit = inner.attribute("unit").or(declared.unit).unwrap_or_default().to_owned();
    let known = units.get(&unit);
    let coherent = || COHERENT.iter().find(|(name, _)| *name == unit).map(|(_, exponents)| *exponents);
    // Of a difference, such as a change of temperature, the offset of its unit is no part.
    let relative = if inner.attribute("relativeQuantity").is_some() {
        is_true(inner, "relativeQuantity")
    } else {
        declared.relative
    };
    let causality = node.attribute("causality").unwrap_or("local");
    let given = matches!(node.attribute("initial"), Some("exact" | "approx"));
    let settable = match causality {
        _ if node.attribute("variability") == Some("constant") => false,
        "parameter" | "input" => true,
        "local" => given || node.attribute("initial").is_none(),
        "output" => given,
        _ => false,
    };
    let written = inner.attribute("start").map(|text| text.split_whitespace().map(str::to_owned).collect());
    let texts = || node.children().filter(|node| node.has_tag_name("Start"));
    Ok(FmuVariable {
        reference,
        kind,
        causality: causality.to_owned(),
        settable,
        factor: known.map_or(1.0, |unit| unit.factor),
        offset: known.map_or(0.0, |unit| if relative { 0.0 } else { unit.offset }),
        exponents: known.and_then(|unit| unit.exponents).or_else(coherent),
        unit,
        derivative: inner.attribute("derivative").and_then(|text| text.parse().ok()),
        dimensions: Vec::new(),
        start: written
            .unwrap_or_else(|| texts().filter_map(|node| node.attribute("value")).map(str::to_owned).collect()),
        name,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_is_the_variables_or_its_types_and_known_only_where_it_is_defined() {
        let units = "<UnitDefinitions><Unit name=\"mm\"><BaseUnit m=\"1\" factor=\"0.001\"/></Unit><Unit name=\"kN\"/></UnitDefinitions>";
        let described = |version: &str, types: &str, variables: &str| {
            let text = format!(
                "<fmiModelDescription fmiVersion=\"{version}\"><CoSimulation modelIdentifier=\"x\" fixedInternalStepSize=\"1e-3\"/>\
                 {units}<TypeDefinitions>{types}</TypeDefinitions><ModelVariables>{variables}</ModelVariables></fmiModelDescription>"
            );
            Description::parse(&text).unwrap()
        };
        let two = described(
            "2.0",
            "<SimpleType name=\"Length\"><Real unit=\"mm\"/></SimpleType>",
            "<ScalarVariable name=\"a\" valueReference=\"1\"><Real declaredType=\"Length\"/></ScalarVariable>\
             <ScalarVariable name=\"b\" valueReference=\"2\"><Real unit=\"kN\"/></ScalarVariable>\
             <ScalarVariable name=\"c\" valueReference=\"3\"><Real unit=\"banana\" declaredType=\"Length\"/></ScalarVariable>\
             <ScalarVariable name=\"d\" valueReference=\"4\"><Real unit=\"N\"/></ScalarVariable>\
             <ScalarVariable name=\"e\" valueReference=\"5\"><Real/></ScalarVariable>",
        );
        let three = described(
            "3.0",
            "<Float64Type name=\"Length\" unit=\"mm\"/>",
            "<Float64 name=\"a\" valueReference=\"1\" declaredType=\"Length\"/>",
        );
        for (description, name, factor, unknown) in [
            (&two, "a", 1e-3, false),
            (&two, "b", 1.0, true),
            (&two, "c", 1.0, true),
            (&two, "d", 1.0, false),
            (&two, "e", 1.0, false),
            (&three, "a", 1e-3, false),
        ] {
            let variable = description.variable(name).unwrap();
            assert_eq!((variable.factor, variable.is_in_unknown_unit()), (factor, unknown), "{name}");
        }
        assert_eq!((three.internal_step, three.any_step), (Some(1e-3), false));
    }

    #[test]
    fn what_may_be_set_and_how_large_it_is_is_read_with_aliases_and_structural_parameters() {
        let text = "<fmiModelDescription fmiVersion=\"3.0\"><CoSimulation modelIdentifier=\"x\"/><ModelVariables>\
             <UInt64 name=\"n\" valueReference=\"1\" causality=\"structuralParameter\" start=\"3\"/>\
             <Float64 name=\"table\" valueReference=\"2\" causality=\"parameter\" start=\"1 2 3 4 5 6\"><Dimension valueReference=\"1\"/>\
             <Dimension start=\"2\"/><Alias name=\"map\"/></Float64>\
             <Float64 name=\"exact\" valueReference=\"3\" causality=\"output\" initial=\"exact\" start=\"1\"/>\
             <Float64 name=\"calculated\" valueReference=\"4\" causality=\"output\"/>\
             <Int8 name=\"constant\" valueReference=\"5\" causality=\"output\" variability=\"constant\" start=\"1\"/>\
             </ModelVariables></fmiModelDescription>";
        let description = Description::parse(text).unwrap();
        let of = |name: &str| description.variable(name).unwrap();
        assert_eq!((&*of("map").dimensions, of("map").size(), of("map").start.len()), (&[3, 2][..], 6, 6));
        assert_eq!((of("map").reference, of("constant").kind), (2, Type::Int8));
        let settable = ["table", "exact", "calculated", "constant"].map(|name| of(name).settable);
        assert_eq!(settable, [true, true, false, false]);
    }
}
