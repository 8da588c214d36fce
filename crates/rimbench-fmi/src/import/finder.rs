//! Looks up in an FMU what a case file names.

use super::archive::Unpacked;
use super::description::{ENERGY, Exponents, FmuVariable, Type};
use super::host::{ModelVariables, Scaled, Start};
use super::side::ModelSize;
use crate::export::side_name;
use rimbench_core::cosim::Side;
use rimbench_core::error::{Error, Result};

/// Most rows of an interface model, whose square must have room.
const MOST_ROWS: usize = 4096;

/// Looks variables up in an FMU.
pub(super) struct Finder<'a> {
    pub(super) unpacked: &'a Unpacked,
}

impl Finder<'_> {
    pub(super) fn wrong(&self, message: String) -> Error {
        Error::file(&self.unpacked.file, message)
    }

    /// A variable by its name; of others those with `causality` are offered instead.
    fn variable(&self, name: &str, causality: &str) -> Result<&FmuVariable> {
        let description = &self.unpacked.description;
        description.variable(name).ok_or_else(|| {
            let others = description.variables.iter().filter(|variable| variable.causality == causality);
            self.wrong(Error::unknown("variable", name, others.map(|variable| &*variable.name)).to_string())
        })
    }

    /// A coupling variable.
    pub(super) fn coupling(
        &self,
        name: &str,
        causality: &str,
        side: Side,
        exponents: Exponents,
        unit: &str,
    ) -> Result<&FmuVariable> {
        let variable = self.variable(name, causality)?;
        if variable.causality != causality {
            let side = side_name(side);
            let message = format!(
                "variable `{name}` is of causality {}; as a coupling variable of the {side} it must be {causality}",
                variable.causality
            );
            return Err(self.wrong(message));
        }
        if variable.kind != Type::Number || !variable.dimensions.is_empty() {
            return Err(self.wrong(format!("variable `{name}` is not one number of type Float64 (Real)")));
        }
        if variable.exponents.is_some_and(|own| own != exponents) {
            return Err(
                self.wrong(format!("variable `{name}` is in `{}`, which is no unit like {unit}", variable.unit))
            );
        }
        Ok(variable)
    }

    /// A variable that can be set before a run.
    pub(super) fn settable(&self, name: &str) -> Result<&FmuVariable> {
        let variable = self.variable(name, "parameter")?;
        if variable.causality == "structuralParameter" {
            return Err(self.wrong(format!(
                "variable `{name}` is a structural parameter, which changes the sizes of others: it stays what the FMU has it; valid: a \
                 parameter"
            )));
        }
        if ["parameter", "input", "local"].contains(&&*variable.causality) && variable.dimensions.is_empty() {
            return Ok(variable);
        }
        Err(self.wrong(format!(
            "variable `{name}` is of causality {}; what is set at the start must be a parameter",
            variable.causality
        )))
    }

    /// A start value, which goes to the FMU as it is, in the FMU's own unit.
    pub(super) fn start(&self, side: Side, name: &str, value: &toml::Value) -> Result<Start> {
        let variable = self.settable(name)?;
        let reference = variable.reference;
        let start = match (variable.kind, value) {
            (Type::Number, toml::Value::Float(number)) if !number.is_finite() => {
                return Err(Error::Incompatible(format!(
                    "start of [{}]: {name} = {number} is not valid; valid: a finite number",
                    side_name(side)
                )));
            }
            (Type::Number, toml::Value::Float(number)) => Start::Number(reference, *number),
            (Type::Number, toml::Value::Integer(number)) => Start::Number(reference, *number as f64),
            (Type::Integer, toml::Value::Integer(number)) => match i32::try_from(*number) {
                Ok(number) => Start::Integer(reference, number),
                Err(_) => return Err(self.wrong(format!("variable `{name}` = {number} has no room in 32 bits"))),
            },
            (Type::Boolean, toml::Value::Boolean(truth)) => Start::Boolean(reference, *truth),
            (Type::Text, toml::Value::String(text)) => Start::Text(reference, text.clone()),
            (kind, value) => {
                let wanted = match kind {
                    Type::Number => "a number",
                    Type::Integer => "a whole number",
                    Type::Boolean => "true or false",
                    Type::Text => "a text",
                    Type::Other => "of a type that cannot be set here",
                };
                return Err(self.wrong(format!(
                    "variable `{name}`: its start value is of type {}; valid: {wanted}",
                    value.type_str()
                )));
            }
        };
        Ok(start)
    }

    /// A number to be looked at, in SI.
    pub(super) fn readable(&self, name: &str) -> Result<Scaled> {
        let variable = self.variable(name, "output")?;
        if variable.kind != Type::Number || !variable.dimensions.is_empty() {
            return Err(self.wrong(format!("variable `{name}` is not one number of type Float64 (Real)")));
        }
        Ok(Scaled { reference: variable.reference, factor: variable.factor, offset: variable.offset })
    }

    /// An account of work, in J.
    pub(super) fn work(&self, name: &str) -> Result<Scaled> {
        let scaled = self.readable(name)?;
        let variable = self.variable(name, "output")?;
        if variable.exponents.is_some_and(|own| own != ENERGY) || variable.is_in_unknown_unit() {
            return Err(self.wrong(format!(
                "variable `{name}` is in `{}`, which is no unit like J; as interface_work it must be an energy",
                variable.unit
            )));
        }
        Ok(scaled)
    }

    /// The interface model of our proposal, with its size.
    pub(super) fn model(&self, rows: usize) -> Result<Option<(ModelVariables, ModelSize)>> {
        let description = &self.unpacked.description;
        let find = |name: &str, kind: Type, dimensions: &[usize]| -> Result<(u32, usize)> {
            let found = description.variable(name);
            let found = found.filter(|variable| variable.kind == kind && variable.dimensions == dimensions);
            let found = found.ok_or_else(|| {
                self.wrong(format!(
                    "its interface model has no variable `{name}` with dimensions {dimensions:?} and the right type"
                ))
            })?;
            Ok((found.reference, dimensions.iter().product()))
        };
        let extent = |name: &str| match description.variable(name).map(|variable| &*variable.dimensions) {
            Some(&[extent]) => Ok(extent),
            _ => Err(self.wrong(format!("its interface model has no variable `{name}` with one dimension"))),
        };
        let (n, interface) = (extent("rim.a")?, extent("rim.position")?);
        // With friction each contact has two rows.
        let has_friction = description.variable("rim.friction").is_some();
        let rows_each = if has_friction { 2 } else { 1 };
        let contacts = n.checked_sub(interface).filter(|of_contacts| of_contacts.is_multiple_of(rows_each));
        let Some(contacts) = contacts.filter(|_| interface == rows).map(|of_contacts| of_contacts / rows_each) else {
            return Err(self.wrong(format!(
                "its interface model has {n} rows, {interface} of them of the interface, and the case has {rows}"
            )));
        };
        if n > MOST_ROWS {
            return Err(self.wrong(format!("its interface model has {n} rows; at most {MOST_ROWS} make sense")));
        }
        let number = |name: &str, dimensions: &[usize]| find(name, Type::Number, dimensions);
        let mut numbers = vec![
            number("rim.H", &[n, n])?,
            number("rim.a", &[n])?,
            number("rim.w", &[n])?,
            number("rim.position", &[interface])?,
        ];
        let mut truths = Vec::new();
        if contacts > 0 {
            numbers.push(number("rim.gap", &[contacts])?);
            numbers.push(number("rim.discretisation_approach", &[contacts])?);
            truths.push(find("rim.at_bound", Type::Boolean, &[contacts])?);
        }
        for name in ["rim.stabilisation", "rim.restitution", "rim.contact_stiffness", "rim.contact_damping"] {
            numbers.push(number(name, &[])?);
        }
        let (mut friction, mut states) = (Vec::new(), Vec::new());
        if has_friction {
            friction.push(number("rim.friction", &[contacts])?);
            for name in ["rim.friction_at_rest", "rim.friction_in_motion", "rim.tangential_restitution"] {
                friction.push(number(name, &[])?);
            }
            for name in ["rim.state", "rim.solved_state"] {
                states.push(find(name, Type::Integer, &[contacts])?);
            }
        }
        let (mut kinks, mut places) = (None, 0);
        if description.variable("rim.kink_count").is_some() {
            places = extent("rim.kink_time")?;
            let parts = [number("rim.kink_time", &[places])?, number("rim.kink_jump", &[places, n])?];
            kinks = Some((find("rim.kink_count", Type::Integer, &[])?.0, parts));
        }
        let step = number("rim.step", &[])?.0;
        let size = ModelSize { contacts, interface, friction: has_friction, kinks: places };
        Ok(Some((ModelVariables { step, numbers, truths, friction, states, kinks }, size)))
    }
}
