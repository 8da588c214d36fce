//! `modelDescription.xml` as far as it is needed.

use super::attributes::{Of, check, check_start, truth, uncoupled};
use super::host::{Limits, Type};
use roxmltree::{Document, Node};
use std::collections::{BTreeMap, BTreeSet};

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

/// A unit with one letter for micro: its sign, U+00B5, is the Greek one, U+03BC.
pub(super) fn one_micro(unit: &str) -> String {
    unit.replace('\u{b5}', "\u{3bc}")
}

/// A variable of an FMU.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FmuVariable {
    pub(super) name: String,
    pub(super) reference: u32,
    pub(super) kind: Type,
    pub(super) causality: String,
    /// Whether it may be given a value before a run.
    pub(super) settable: bool,
    /// An output that begins with its start value.
    pub(super) exact: bool,
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
    /// What its values may be, in its own unit.
    pub(super) limits: Limits,
    /// Whether it changes at events alone.
    pub(super) discrete: bool,
    /// An attribute that says what it may not: it matters where the variable is used.
    pub(super) fault: Option<String>,
    /// Why it may not be coupled.
    pub(super) uncoupled: Option<String>,
    /// The clocks with which it counts alone.
    pub(super) clocks: Option<String>,
    /// Attributes that FMI has none of.
    pub(super) unknown: Vec<String>,
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
    /// It drives a tool that must be here.
    pub(super) needs_tool: bool,
    /// Its time when a run begins, in its unit of time.
    pub(super) begin: f64,
    /// What is odd about it and has no effect.
    pub(super) notes: Vec<String>,
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
#[derive(Default, Clone)]
struct DeclaredType<'a> {
    unit: Option<&'a str>,
    relative: bool,
    limits: Limits,
    /// What of it says what it may not.
    fault: Option<String>,
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
        let two = version == "2.0";
        check(Of::Model, root, two)?;
        let child = |name: &str| root.children().find(|node| node.has_tag_name(name));
        let needed = |node: Node<'_, '_>, name: &str| {
            let missing = || format!("<{}> has no {name}", node.tag_name().name());
            node.attribute(name).map(str::to_owned).ok_or_else(missing)
        };
        needed(root, "fmiVersion")?;
        let slave = child("CoSimulation").ok_or("it is not for co-simulation: there is no <CoSimulation>")?;
        let flag = |name: &str| slave.attribute(name).and_then(truth) == Some(true);
        let mut notes = Vec::new();
        let experiment = child("DefaultExperiment");
        for (of, node) in [(Of::CoSimulation, Some(slave)), (Of::DefaultExperiment, experiment)] {
            let Some(node) = node else { continue };
            let element = node.tag_name().name();
            for name in check(of, node, two).map_err(|what| format!("<{element}> {what}"))? {
                notes
                    .push(format!("<{element}> has {name}, which is no attribute of FMI {version}, and has no effect"));
            }
        }
        let number = |node: Option<Node<'_, '_>>, name: &str| -> Option<f64> {
            node.and_then(|node| node.attribute(name)?.trim().parse().ok())
        };
        let units = child("UnitDefinitions").map(|list| read_units(list, &mut notes)).transpose()?.unwrap_or_default();
        let types = child("TypeDefinitions").map(|list| read_types(list, two)).unwrap_or_default();
        let mut variables = Vec::new();
        let mut sizes = Vec::new();
        let elements =
            || child("ModelVariables").into_iter().flat_map(|list| list.children()).filter(|node| node.is_element());
        for node in elements() {
            let variable = read_variable(node, &units, &types, two)?;
            if variable.causality == "structuralParameter" {
                sizes.push((variable.reference, variable.start.first().and_then(|text| text.trim().parse().ok())));
            }
            variables.push(variable);
        }
        for (variable, node) in variables.iter_mut().zip(elements()) {
            for extent in node.children().filter(|node| node.has_tag_name("Dimension")) {
                match read_extent(extent, &sizes) {
                    Some(extent) => variable.dimensions.push(extent),
                    None => {
                        variable.dimensions.push(0);
                        let said = ["start", "valueReference"].map(|name| extent.attribute(name).unwrap_or("none"));
                        variable.fault.get_or_insert_with(|| {
                            format!(
                                "<Dimension> start = {:?}, valueReference = {:?} is not valid; valid: a whole number, or a structural \
                                 parameter with one",
                                said[0], said[1]
                            )
                        });
                    }
                }
            }
            let size = variable.dimensions.iter().try_fold(1, |size: usize, extent| size.checked_mul(*extent));
            if size.is_none_or(|size| size > MOST_VALUES) {
                variable.fault.get_or_insert_with(|| {
                    format!("<Dimension> {:?} is not valid; valid: at most {MOST_VALUES} values", variable.dimensions)
                });
                variable.dimensions = vec![0];
            }
            let (count, size) = (variable.start.len(), variable.size());
            if !matches!(variable.kind, Type::Text | Type::Other)
                && count > 1
                && count != size
                && variable.fault.is_none()
            {
                let (first, most) = (&variable.start[..count.min(3)].join(" "), if count > 3 { " …" } else { "" });
                variable.fault = Some(format!(
                    "start = {first}{most} is {count} values and not valid; valid: one value{}",
                    if size > 1 { format!(", or {size}") } else { String::new() }
                ));
            }
        }
        let time_unit = unit_of_time(&variables)?;
        // FMI 2.0 refers to variables by their place, from 1, and not by their reference.
        let references: Vec<u32> = variables.iter().map(|variable| variable.reference).collect();
        let mut places = BTreeMap::new();
        for (place, variable) in variables.iter_mut().enumerate() {
            let first = *places.entry(variable.reference).or_insert(place);
            if !two && first != place {
                let wrong = || format!("valueReference = {} is that of another variable as well", variable.reference);
                variable.fault.get_or_insert_with(wrong);
            }
        }
        let named = |text: &str| -> Option<(usize, u32)> {
            let number: u32 = text.trim().parse().ok()?;
            let place = if two { (number as usize).checked_sub(1)? } else { *places.get(&number)? };
            Some((place, *references.get(place)?))
        };
        let valid = if two { "places of variables, from 1" } else { "value references of variables" };
        for (own, node) in elements().enumerate() {
            let Some(text) = of_type(node, two).and_then(|inner| inner.attribute("derivative")) else { continue };
            let found = named(text);
            let wrong = match found {
                Some((place, _)) => no_rate(&variables[own], &variables[place]),
                None => Some(format!("names no variable; valid: one of the {valid}")),
            };
            variables[own].derivative = found.map(|(_, reference)| reference);
            if let Some(wrong) = wrong {
                variables[own].fault.get_or_insert(format!("derivative = {text} {wrong}"));
            }
        }
        let mut aliases = Vec::new();
        for (variable, node) in variables.iter().zip(elements()) {
            for alias in node.children().filter(|node| node.has_tag_name("Alias")) {
                let name =
                    alias.attribute("name").ok_or_else(|| format!("an alias of `{}` has no name", variable.name))?;
                aliases.push(FmuVariable { name: name.to_owned(), ..variable.clone() });
            }
        }
        let mut dependencies = BTreeMap::new();
        for output in child("ModelStructure").into_iter().flat_map(|list| list.descendants()) {
            let key = match output.tag_name().name() {
                "Output" if !two => "valueReference",
                "Unknown" if two && output.parent().is_some_and(|parent| parent.has_tag_name("Outputs")) => "index",
                _ => continue,
            };
            let own = needed(output, key)?;
            let wrong = |what: String| format!("<{} {key}=\"{own}\"> {what}", output.tag_name().name());
            check(Of::Output, output, two).map_err(&wrong)?;
            let of = |name: &str, text: &str| {
                named(text).ok_or_else(|| wrong(format!("{name} = {text} names no variable; valid: {valid}")))
            };
            let (place, reference) = of(key, &own)?;
            let FmuVariable { name, causality, .. } = &variables[place];
            if causality != "output" {
                notes.push(wrong(format!("is `{name}` of causality {causality}, and no output")));
            }
            let list = |name: &str| output.attribute(name).map(|text| text.split_whitespace().collect::<Vec<_>>());
            let (on, kinds) = (list("dependencies"), list("dependenciesKind"));
            if let Some(kinds) = kinds.filter(|kinds| on.as_ref().is_none_or(|on| on.len() != kinds.len())) {
                let on = on.map_or(0, |on| on.len());
                return Err(wrong(format!(
                    "dependenciesKind has {} words; valid: one for each of {on} dependencies",
                    kinds.len()
                )));
            }
            let Some(on) = on else { continue };
            let on: Vec<(usize, u32)> =
                on.into_iter().map(|text| of("dependencies", text)).collect::<Result<_, _>>()?;
            // In FMI 2.0 whole numbers have references of their own, which may be those of numbers.
            let is_number = |place: usize| !two || variables[place].kind == Type::Float64;
            if is_number(place) {
                let on = on.into_iter().filter(|(place, _)| is_number(*place));
                dependencies.insert(reference, on.map(|(_, reference)| reference).collect());
            }
        }
        notes.extend(notes_on_faults(&variables));
        variables.append(&mut aliases);
        let mut names = BTreeSet::new();
        if let Some(twice) = variables.iter().find(|variable| !names.insert(&variable.name)) {
            return Err(format!("two variables have the name `{}`; valid: a name of its own for each", twice.name));
        }
        Ok(Description {
            token: needed(root, if two { "guid" } else { "instantiationToken" })?,
            identifier: needed(slave, "modelIdentifier")?,
            keeps_state: flag(if two { "canGetAndSetFMUstate" } else { "canGetAndSetFMUState" }),
            derivatives: flag(if two { "providesDirectionalDerivative" } else { "providesDirectionalDerivatives" }),
            any_step: flag("canHandleVariableCommunicationStepSize"),
            internal_step: number(Some(slave), "fixedInternalStepSize")
                .map(|step| step * time_unit)
                .filter(|step| *step > 0.0),
            time_unit,
            only_once: flag("canBeInstantiatedOnlyOncePerProcess"),
            needs_tool: flag("needsExecutionTool"),
            begin: number(experiment, "startTime").unwrap_or(0.0),
            notes,
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

/// Most values of a variable, far beyond any use.
const MOST_VALUES: usize = 100_000_000;

/// Faults of variables that are told.
const TOLD: usize = 5;

/// What is to be said of variables at fault that are not used: those that are used are refused.
fn notes_on_faults(variables: &[FmuVariable]) -> Vec<String> {
    let faults = || variables.iter().filter_map(|variable| Some((&variable.name, variable.fault.as_ref()?)));
    let told = faults().take(TOLD);
    let mut notes: Vec<String> =
        told.map(|(name, fault)| format!("variable `{name}`, which is not used: {fault}")).collect();
    let more = faults().count().saturating_sub(TOLD);
    if more > 0 {
        notes.push(format!("{more} more variables that are not used say what they may not"));
    }
    notes
}

/// Why a variable is not the derivative of another.
fn no_rate(rate: &FmuVariable, of: &FmuVariable) -> Option<String> {
    if rate.name == of.name {
        return Some("is the variable itself; valid: another".to_owned());
    }
    if !matches!(of.kind, Type::Float64 | Type::Float32) {
        let (name, kind) = (&of.name, of.kind.name());
        return Some(format!("names `{name}`, which is of type {kind}; valid: a variable of type Float64 (Real)"));
    }
    let (own, mut wanted) = (rate.exponents?, of.exponents?);
    wanted[2] -= 1;
    // A radian is 1.
    let differs = own.iter().zip(&wanted).zip(BASE).any(|((own, wanted), base)| base != "rad" && own != wanted);
    differs.then(|| {
        let (name, unit) = (&of.name, &of.unit);
        format!("names `{name}` in `{unit}`, and its own unit is `{}`; valid: that of `{name}` per second", rate.unit)
    })
}

/// Declared types by their names.
fn read_types<'a>(list: Node<'a, '_>, two: bool) -> Types<'a> {
    let types = list.children().filter(Node::is_element);
    let read = |node: Node<'a, '_>| {
        let inner = of_type(node, two)?;
        let items = || inner.children().filter(|node| node.has_tag_name("Item")).map(|item| item.attribute("value"));
        let whole = |text: &str| text.trim().parse::<i64>().ok();
        let wrong_item = items()
            .find(|value| value.and_then(whole).is_none())
            .map(|value| format!("<Item> value = {} is not valid; valid: a whole number", value.unwrap_or("nothing")));
        let items = items().flatten().filter_map(whole).collect();
        let name = node.attribute("name")?;
        let fault = check(Of::Variable, inner, two).err().or(wrong_item);
        let declared = DeclaredType {
            fault: fault.map(|what| format!("its declared type `{name}` has {what}")),
            unit: inner.attribute("unit"),
            relative: is_true(inner, "relativeQuantity"),
            limits: Limits { least: limit(inner, "min"), most: limit(inner, "max"), items },
        };
        Some((name, declared))
    };
    types.filter_map(read).collect()
}

/// The element that has the attributes of a type: in FMI 2.0 one of its own.
fn of_type<'a, 'b>(node: Node<'a, 'b>, two: bool) -> Option<Node<'a, 'b>> {
    if two { node.children().find(Node::is_element) } else { Some(node) }
}

fn limit(node: Node<'_, '_>, name: &str) -> Option<f64> {
    node.attribute(name)?.trim().parse().ok().filter(|limit: &f64| limit.is_finite())
}

fn is_true(node: Node<'_, '_>, attribute: &str) -> bool {
    node.attribute(attribute).and_then(truth) == Some(true)
}

/// An extent: a number, or what a structural parameter is at the start.
fn read_extent(extent: Node<'_, '_>, sizes: &[(u32, Option<usize>)]) -> Option<usize> {
    if let Some(said) = extent.attribute("start") {
        return said.trim().parse().ok();
    }
    let reference: u32 = extent.attribute("valueReference")?.trim().parse().ok()?;
    sizes.iter().find(|(known, _)| *known == reference)?.1
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

fn read_units(list: Node<'_, '_>, notes: &mut Vec<String>) -> Result<BTreeMap<String, Unit>, String> {
    let mut units = BTreeMap::new();
    for node in list.children().filter(|node| node.has_tag_name("Unit")) {
        let base = node.children().find(|node| node.has_tag_name("BaseUnit"));
        let name = node.attribute("name").ok_or("a <Unit> has no name")?;
        let known = |attribute: &str| BASE.contains(&attribute) || ["factor", "offset"].contains(&attribute);
        for odd in base.iter().flat_map(Node::attributes).filter(|attribute| !known(attribute.name())) {
            notes.push(format!(
                "unit `{name}` has {} = {}, which is no base unit, and has no effect",
                odd.name(),
                odd.value()
            ));
        }
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
        if units.insert(one_micro(name), unit).is_some() {
            return Err(format!("two units have the name `{name}`; valid: a name of its own for each"));
        }
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
    let said = node.attribute("valueReference").ok_or_else(|| format!("variable `{name}` has no valueReference"))?;
    let reference = said.trim().parse().map_err(|_| {
        format!(
            "variable `{name}`: valueReference = {said:?} is not valid; valid: a whole number from 0 to {}",
            u32::MAX
        )
    })?;
    let inner = of_type(node, two).ok_or_else(|| format!("variable `{name}` has no type"))?;
    let kind = Type::of_element(inner.tag_name().name(), two);
    let declared = match inner.attribute("declaredType") {
        None => DeclaredType::default(),
        Some(wanted) => types.get(wanted).cloned().ok_or_else(|| {
            format!("variable `{name}` is of the declared type `{wanted}`, which is not among <TypeDefinitions>")
        })?,
    };
    let unit = inner.attribute("unit").or(declared.unit).unwrap_or_default().to_owned();
    let known = units.get(&one_micro(&unit));
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
    let start: Vec<String> =
        written.unwrap_or_else(|| texts().filter_map(|node| node.attribute("value")).map(str::to_owned).collect());
    let limits = Limits {
        least: limit(inner, "min").or(declared.limits.least),
        most: limit(inner, "max").or(declared.limits.most),
        items: declared.limits.items,
    };
    let (mut fault, mut unknown) = (None, Vec::new());
    for element in [Some(node), Some(inner).filter(|_| two)].into_iter().flatten() {
        match check(Of::Variable, element, two) {
            Ok(names) => unknown.extend(names),
            Err(what) => fault = fault.or(Some(what)),
        }
    }
    let limited = match (limits.least, limits.most) {
        (Some(least), Some(most)) if least > most => Some(format!("min = {least} is above max = {most}")),
        _ => None,
    };
    let outside = || start.iter().find_map(|text| Some((text, limits.check(text.trim().parse().ok()?).err()?)));
    let fault = fault.or(declared.fault).or_else(|| check_start(kind, &start).err()).or(limited);
    let fault = fault.or_else(|| outside().map(|(text, valid)| format!("start = {text} is not valid; valid: {valid}")));
    Ok(FmuVariable {
        reference,
        kind,
        causality: causality.to_owned(),
        settable,
        exact: causality == "output" && settable && node.attribute("initial") == Some("exact"),
        factor: known.map_or(1.0, |unit| unit.factor),
        offset: known.map_or(0.0, |unit| if relative { 0.0 } else { unit.offset }),
        exponents: known.and_then(|unit| unit.exponents).or_else(coherent),
        unit,
        derivative: None,
        dimensions: Vec::new(),
        start,
        limits,
        discrete: node.attribute("variability") == Some("discrete"),
        fault,
        uncoupled: uncoupled(node, two),
        clocks: node.attribute("clocks").filter(|_| !two).map(str::to_owned),
        unknown,
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
                "<fmiModelDescription fmiVersion=\"{version}\" guid=\"x\" instantiationToken=\"x\"><CoSimulation modelIdentifier=\"x\" fixedInternalStepSize=\"1e-3\"/>\
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
        let text = "<fmiModelDescription fmiVersion=\"3.0\" instantiationToken=\"x\"><CoSimulation modelIdentifier=\"x\"/><ModelVariables>\
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
