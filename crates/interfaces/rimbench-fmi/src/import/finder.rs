//! Looks up in an FMU what a case file names.

use super::archive::Unpacked;
use super::attributes::truth;
use super::description::{ENERGY, Exponents, FORCE, FmuVariable, LENGTH, VELOCITY};
use super::host::{Element, ModelVariables, Scaled, Start, Type, Values};
use crate::export::side_name;
use crate::model_parts::ModelSize;
use rimbench_core::cosim::Side;
use rimbench_core::error::{Error, Result};

/// Most rows of an interface model, whose square must have room.
const MOST_ROWS: usize = 4096;

/// What stands for a length, a velocity and a force where something turns: with the radian or without.
const TURNING: [(Exponents, [Exponents; 2]); 3] = [
    (LENGTH, [[0, 0, 0, 1, 0, 0, 0, 0], [0; 8]]),
    (VELOCITY, [[0, 0, -1, 1, 0, 0, 0, 0], [0, 0, -1, 0, 0, 0, 0, 0]]),
    (FORCE, [ENERGY, [1, 2, -2, -1, 0, 0, 0, 0]]),
];

/// A variable, or an element of one.
pub(super) struct Found<'a> {
    pub(super) variable: &'a FmuVariable,
    pub(super) element: Option<Element>,
}

impl Found<'_> {
    /// Whether it is one value.
    fn is_one(&self) -> bool {
        self.element.is_some() || self.variable.dimensions.is_empty()
    }

    /// As a number that crosses the boundary.
    pub(super) fn scaled(&self, factor: f64) -> Scaled {
        let FmuVariable { reference, kind, .. } = *self.variable;
        let (own, offset) = (self.variable.factor, self.variable.offset);
        Scaled { reference, kind, element: self.element, factor: factor * own, offset: factor * offset }
    }
}

/// Looks variables up in an FMU.
pub(super) struct Finder<'a> {
    pub(super) unpacked: &'a Unpacked,
}

impl Finder<'_> {
    pub(super) fn wrong(&self, message: String) -> Error {
        Error::file(&self.unpacked.file, message)
    }

    /// A variable by its name, or an element of one, `name[2]` or `name[1,3]`; of others those with `causality` are
    /// offered instead.
    pub(super) fn find(&self, name: &str, causality: &str) -> Result<Found<'_>> {
        let found = self.look_up(name, causality)?;
        match &found.variable.fault {
            Some(fault) => Err(self.wrong(format!("variable `{name}`: {fault}"))),
            None => Ok(found),
        }
    }

    fn look_up(&self, name: &str, causality: &str) -> Result<Found<'_>> {
        let description = &self.unpacked.description;
        if let Some(variable) = description.variable(name) {
            return Ok(Found { variable, element: None });
        }
        if let Some((array, indices)) = name.strip_suffix(']').and_then(|name| name.rsplit_once('['))
            && let Some(variable) = description.variable(array).filter(|variable| !variable.dimensions.is_empty())
        {
            let indices: Vec<usize> = indices.split(',').map(|index| index.trim().parse().unwrap_or(0)).collect();
            let inside = |(index, extent): (&usize, &usize)| (1..=*extent).contains(index);
            let extents = &variable.dimensions;
            if indices.len() != extents.len() || !indices.iter().zip(extents).all(inside) {
                return Err(self.wrong(format!(
                    "variable `{array}` has no element `{name}`; valid: indices from 1 to {extents:?}"
                )));
            }
            let at = indices.iter().zip(extents).fold(0, |at, (index, extent)| at * extent + index - 1);
            return Ok(Found { variable, element: Some(Element { at, of: variable.size() }) });
        }
        let others = description.variables.iter().filter(|variable| variable.causality == causality);
        Err(self.wrong(Error::unknown("variable", name, others.map(|variable| &*variable.name)).to_string()))
    }

    /// A coupling variable, and what the case file multiplies it by.
    pub(super) fn coupling(
        &self,
        (name, factor): (&str, Option<f64>),
        causality: &str,
        side: Side,
        exponents: Exponents,
        unit: &str,
    ) -> Result<Scaled> {
        let found = self.find(name, causality)?;
        let variable = found.variable;
        if variable.causality != causality {
            let side = side_name(side);
            let message = format!(
                "variable `{name}` is of causality {}; as a coupling variable of the {side} it must be {causality}",
                variable.causality
            );
            return Err(self.wrong(message));
        }
        if let Some(why) = &variable.uncoupled {
            return Err(self.wrong(format!("variable `{name}` has {why}")));
        }
        self.check_number(name, &found)?;
        let turns = TURNING
            .iter()
            .any(|(of, turning)| *of == exponents && variable.exponents.is_some_and(|own| turning.contains(&own)));
        if variable.exponents.is_some_and(|own| own != exponents) && !(turns && factor.is_some()) {
            let way_out = if turns {
                format!(
                    "; valid where it turns: the lever as a factor, {{ variable = \"{name}\", factor = … }}, in m for an angle and its \
                     velocity, in 1/m for a torque"
                )
            } else {
                String::new()
            };
            let unit_of_it = &variable.unit;
            return Err(
                self.wrong(format!("variable `{name}` is in `{unit_of_it}`, which is no unit like {unit}{way_out}"))
            );
        }
        if variable.is_in_unknown_unit() && factor.is_none() {
            return Err(self.wrong(format!(
                "variable `{name}` is in `{}`, which the FMU does not define by SI base units; valid: a unit that it defines, or a factor \
                 to {unit}, {{ variable = \"{name}\", factor = … }}",
                variable.unit
            )));
        }
        Ok(found.scaled(factor.unwrap_or(1.0)))
    }

    /// Refuses what is not one number with digits behind the point.
    fn check_number(&self, name: &str, found: &Found<'_>) -> Result<()> {
        let FmuVariable { kind, dimensions, .. } = found.variable;
        if !kind.is_real() {
            let message = format!("variable `{name}` is of type {}; valid: Float64 (Real), Float32", kind.name());
            return Err(self.wrong(message));
        }
        if !found.is_one() {
            let first = vec!["1"; dimensions.len()].join(",");
            let message = format!(
                "variable `{name}` is an array of {dimensions:?}; valid: an element, such as `{name}[{first}]`"
            );
            return Err(self.wrong(message));
        }
        Ok(())
    }

    /// What is odd about a coupling variable and has no effect, or less than one may think.
    pub(super) fn notes(&self, name: &str) -> Vec<String> {
        let Ok(Found { variable, .. }) = self.look_up(name, "output") else { return Vec::new() };
        let version = &self.unpacked.description.version;
        let unknown = variable.unknown.iter().map(|attribute| {
            format!("variable `{name}` has {attribute}, which is no attribute of FMI {version}, and has no effect")
        });
        let short = (variable.kind == Type::Float32).then(|| {
            format!("variable `{name}` is of type Float32: its values are converted, and have some seven digits")
        });
        unknown.chain(short).collect()
    }

    /// A variable that can be set before a run.
    pub(super) fn settable(&self, name: &str) -> Result<Found<'_>> {
        let found = self.find(name, "parameter")?;
        let variable = found.variable;
        if variable.causality == "structuralParameter" {
            return Err(self.wrong(format!(
                "variable `{name}` is a structural parameter, which changes the sizes of others: it stays what the FMU has it; valid: a \
                 parameter"
            )));
        }
        if variable.settable {
            return Ok(found);
        }
        Err(self.wrong(format!(
            "variable `{name}` is of causality {} and has no start value that may be set; what is set at the start must be a parameter, an \
             input, or have initial = exact or approx",
            variable.causality
        )))
    }

    /// Adds a start value, or the values of an array, which go to the FMU as they are, in the FMU's own unit.
    pub(super) fn start(&self, side: Side, name: &str, value: &toml::Value, starts: &mut Vec<Start>) -> Result<()> {
        let found = self.settable(name)?;
        let size = if found.element.is_some() { 1 } else { found.variable.size() };
        let list = match value {
            toml::Value::Array(list) if !found.is_one() => flat(list),
            one if found.is_one() => vec![one],
            _ => Vec::new(),
        };
        if list.len() != size {
            return Err(self.wrong(format!(
                "variable `{name}` has {} values, and its start has {}; valid: a list of {size}",
                found.variable.size(),
                if list.is_empty() { "one".to_owned() } else { list.len().to_string() }
            )));
        }
        let values = self.values(side, name, found.variable.kind, &list)?;
        values.check(&found.variable.limits).map_err(|(value, valid)| {
            self.wrong(format!("variable `{name}` = {value} is not valid; valid: {valid}"))
        })?;
        self.put_start(&found, name, values, starts)
    }

    /// Puts values among those that are set before a run: those of a variable, or one of an array that is set as a
    /// whole.
    pub(super) fn put_start(
        &self,
        found: &Found<'_>,
        name: &str,
        values: Values,
        starts: &mut Vec<Start>,
    ) -> Result<()> {
        let FmuVariable { reference, kind, exact, .. } = *found.variable;
        let same = |start: &Start| start.reference == reference && start.kind == kind;
        let known = starts.iter().position(same);
        let Some(Element { at, .. }) = found.element else {
            if known.is_some() {
                return Err(self.wrong(format!("variable `{name}` is set twice")));
            }
            starts.push(Start { variable: name.to_owned(), reference, kind, values, exact });
            return Ok(());
        };
        let place = match known {
            Some(place) => place,
            None => {
                let written: Vec<toml::Value> =
                    found.variable.start.iter().map(|text| as_written(kind, text)).collect();
                if written.len() != found.variable.size() {
                    return Err(self.wrong(format!(
                        "variable `{name}` is an element of an array of which the FMU says no start values; valid: the array as a whole"
                    )));
                }
                let whole = self.values(Side::Mechanics, name, kind, &written.iter().collect::<Vec<_>>())?;
                starts.push(Start { variable: name.to_owned(), reference, kind, values: whole, exact });
                starts.len() - 1
            }
        };
        starts[place].values.put(at, values);
        Ok(())
    }

    /// Values of a type.
    fn values(&self, side: Side, name: &str, kind: Type, list: &[&toml::Value]) -> Result<Values> {
        let wrong = |value: &toml::Value, wanted: &str| {
            self.wrong(format!("variable `{name}`: its start value is of type {}; valid: {wanted}", value.type_str()))
        };
        if kind.is_real() {
            let number = |value: &&toml::Value| match *value {
                toml::Value::Float(number) if !number.is_finite() => Err(Error::Incompatible(format!(
                    "start of [{}]: {name} = {number} is not valid; valid: a finite number",
                    side_name(side)
                ))),
                toml::Value::Float(number) => Ok(*number),
                toml::Value::Integer(number) => Ok(*number as f64),
                other => Err(wrong(other, "a number")),
            };
            return list.iter().map(number).collect::<Result<_>>().map(Values::Numbers);
        }
        if let Some([least, most]) = kind.whole() {
            let whole = |value: &&toml::Value| match *value {
                toml::Value::Integer(number) if (least..=most).contains(&i128::from(*number)) => Ok(*number),
                toml::Value::Integer(number) => {
                    Err(self.wrong(format!("variable `{name}` = {number} is not valid; valid: {least} to {most}")))
                }
                other => Err(wrong(other, "a whole number")),
            };
            return list.iter().map(whole).collect::<Result<_>>().map(Values::Whole);
        }
        match kind {
            Type::Boolean => {
                let truth = |value: &&toml::Value| value.as_bool().ok_or_else(|| wrong(value, "true or false"));
                list.iter().map(truth).collect::<Result<_>>().map(Values::Truths)
            }
            Type::Text => {
                let text =
                    |value: &&toml::Value| value.as_str().map(str::to_owned).ok_or_else(|| wrong(value, "a text"));
                list.iter().map(text).collect::<Result<_>>().map(Values::Texts)
            }
            _ => Err(self.wrong(format!("variable `{name}` is of a type that cannot be set here"))),
        }
    }

    /// A number to be looked at, in the FMU's own unit; a truth is 1 or 0.
    pub(super) fn observed(&self, name: &str) -> Result<Scaled> {
        Ok(Scaled { factor: 1.0, offset: 0.0, ..self.readable(name)? })
    }

    /// The heading of what is observed: its name, with its unit unless the name ends in it.
    pub(super) fn heading(&self, name: &str) -> String {
        let unit = self.look_up(name, "output").map_or(String::new(), |found| found.variable.unit.trim().to_owned());
        let ending = unit.replace(|c: char| !c.is_alphanumeric(), "_");
        // Columns are named with `n` for N; in lower case units with a prefix would be ambiguous (MPa, mPa).
        let ending = if ["N", "J", "Pa", "W", "K", "N.m"].contains(&&*unit) { ending.to_lowercase() } else { ending };
        let says = |ending: &str| name.strip_suffix(ending).is_some_and(|before| before.ends_with('_'));
        if ["", "1", "-"].contains(&&*unit) || says(&ending) { name.to_owned() } else { format!("{name} [{unit}]") }
    }

    /// A number to be looked at, in SI.
    fn readable(&self, name: &str) -> Result<Scaled> {
        let found = self.find(name, "output")?;
        if let Some(clocks) = &found.variable.clocks {
            return Err(self.wrong(format!(
                "variable `{name}` has clocks = {clocks}: it counts when these clocks tick, and clocks take event mode, which is not used; \
                 valid: a variable without clocks"
            )));
        }
        let kind = found.variable.kind;
        if !(kind.is_real() || kind.whole().is_some() || kind == Type::Boolean) || !found.is_one() {
            let kind = if found.is_one() { kind.name() } else { "an array" };
            return Err(self.wrong(format!("variable `{name}` is of type {kind}; valid: one number or truth")));
        }
        Ok(found.scaled(1.0))
    }

    /// An account of work, in J.
    pub(super) fn work(&self, name: &str) -> Result<Scaled> {
        let scaled = self.readable(name)?;
        let found = self.find(name, "output")?;
        self.check_number(name, &found)?;
        let variable = found.variable;
        if variable.exponents.is_some_and(|own| own != ENERGY) || variable.is_in_unknown_unit() {
            return Err(self.wrong(format!(
                "variable `{name}` is in `{}`, which is no unit like J; as interface_work it must be an energy",
                variable.unit
            )));
        }
        Ok(scaled)
    }

    /// The interface model of our proposal.
    pub(super) fn model(&self, rows: usize) -> Result<ModelVariables> {
        let description = &self.unpacked.description;
        let extent = |name: &str| match description.variable(name).map(|variable| &*variable.dimensions) {
            Some(&[extent]) => Ok(extent),
            _ => Err(self.wrong(format!("its interface model has no variable `{name}` with one dimension"))),
        };
        let has = |name: &str| description.variable(name).is_some();
        let (n, interface) = (extent("rim.a")?, extent("rim.position")?);
        // With friction each contact has two rows.
        let friction = has("rim.friction");
        let rows_each = if friction { 2 } else { 1 };
        let contacts = n.checked_sub(interface).filter(|of_contacts| of_contacts.is_multiple_of(rows_each));
        let Some(contacts) = contacts.filter(|_| interface == rows).map(|of_contacts| of_contacts / rows_each) else {
            return Err(self.wrong(format!(
                "its interface model has {n} rows, {interface} of them of the interface, and the case has {rows}"
            )));
        };
        if n > MOST_ROWS {
            return Err(self.wrong(format!("its interface model has {n} rows; at most {MOST_ROWS} make sense")));
        }
        let size = ModelSize { contacts, interface, friction, plastic: has("rim.plastic"), engine: false };
        let find = |name: &str, kind: Type, dimensions: &[usize]| {
            let found = description.variable(name);
            let found = found.filter(|variable| variable.kind == kind && variable.dimensions == dimensions);
            found.map(|variable| variable.reference).ok_or_else(|| {
                self.wrong(format!(
                    "its interface model has no variable `{name}` with dimensions {dimensions:?} and the right type"
                ))
            })
        };
        let references = size.parts().map(|part| find(part.name, part.part_type.into(), &part.dimensions(size)));
        let references = references.collect::<Result<_>>()?;
        Ok(ModelVariables { step: find("rim.step", Type::Float64, &[])?, size, references })
    }
}

/// The numbers of a list of lists, row by row.
fn flat(list: &[toml::Value]) -> Vec<&toml::Value> {
    list.iter().flat_map(|value| value.as_array().map_or_else(|| vec![value], |inner| flat(inner))).collect()
}

/// A start value as a description has it.
fn as_written(kind: Type, text: &str) -> toml::Value {
    let value = match kind {
        Type::Boolean => Some(toml::Value::Boolean(truth(text) == Some(true))),
        Type::Text => None,
        _ if kind.is_real() => text.parse().ok().map(toml::Value::Float),
        _ => text.parse().ok().map(toml::Value::Integer),
    };
    value.unwrap_or_else(|| toml::Value::String(text.to_owned()))
}

/// A number as a value of some type.
///
/// # Errors
/// What would be valid.
pub(super) fn number_as(kind: Type, number: f64) -> std::result::Result<Values, String> {
    match kind.whole() {
        Some([least, most]) if number.fract() != 0.0 || !(least..=most).contains(&(number as i128)) => {
            Err(format!("a whole number from {least} to {most}"))
        }
        Some(_) => Ok(Values::Whole(vec![number as i64])),
        None if kind == Type::Boolean && (number == 0.0 || number == 1.0) => Ok(Values::Truths(vec![number == 1.0])),
        None if kind == Type::Boolean => Err("0 or 1".to_owned()),
        None if kind.is_real() => Ok(Values::Numbers(vec![number])),
        None => Err("nothing: it takes no number".to_owned()),
    }
}
