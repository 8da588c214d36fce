//! Named parameters of a case: what can be set, to what, and what it was set to.

use rimbench_core::error::{Error, Result};
use rimbench_core::name::Name;
use std::fmt;
use std::sync::{Arc, OnceLock};

/// The value of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number in the parameter's unit.
    Number(f64),
    /// One of a list of names.
    Choice(Name),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Number(number) => write!(f, "{number:?}"),
            Value::Choice(name) => f.write_str(name),
        }
    }
}

/// What a parameter may be.
#[derive(Debug, Clone, PartialEq)]
pub enum Range {
    /// Any finite number.
    Finite,
    /// A finite number above zero.
    Positive,
    /// A finite number, zero or above.
    NotNegative,
    /// A number in [0, 1].
    Fraction,
    /// A whole number within these bounds.
    Whole(u32, u32),
    /// One of these names.
    OneOf(Vec<Name>),
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Range::Finite => f.write_str("a finite number"),
            Range::Positive => f.write_str("a finite number above 0"),
            Range::NotNegative => f.write_str("a finite number, 0 or above"),
            Range::Fraction => f.write_str("a number in [0, 1]"),
            Range::Whole(least, most) => write!(f, "a whole number from {least} to {most}"),
            Range::OneOf(names) => write!(f, "one of {}", names.join(", ")),
        }
    }
}

impl Range {
    /// Accepts a number or says no.
    fn admits(&self, number: f64) -> bool {
        number.is_finite()
            && match self {
                Range::Finite => true,
                Range::Positive => number > 0.0,
                Range::NotNegative => number >= 0.0,
                Range::Fraction => (0.0..=1.0).contains(&number),
                Range::Whole(least, most) => {
                    number.fract() == 0.0 && (f64::from(*least)..=f64::from(*most)).contains(&number)
                }
                Range::OneOf(_) => false,
            }
    }

    /// Reads a value from text.
    fn parse(&self, key: &str, text: &str) -> Result<Value> {
        let invalid = || Error::invalid(key, text, self.to_string());
        if let Range::OneOf(names) = self {
            let found = names.iter().find(|name| *name == text);
            return found.cloned().map(Value::Choice).ok_or_else(invalid);
        }
        let number = text.trim().parse::<f64>().map_err(|_| invalid())?;
        if self.admits(number) { Ok(Value::Number(number)) } else { Err(invalid()) }
    }
}

/// One named parameter of a case.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Name with unit, as it stands in `--set` and in experiment files.
    pub name: Name,
    /// Unit; `-` for a pure number or a name.
    pub unit: Name,
    /// Default.
    pub default: Value,
    /// What is valid.
    pub range: Range,
    /// One line.
    pub about: Name,
    /// Where the default comes from.
    pub source: Name,
}

/// Parameters written as tables, one after the other. A line is one of
///
/// ```text
/// source: where the defaults of the lines below come from, in tables below as well
/// name | unit | default | range | one line about it           and | source, if it is another
/// name | - | default, other, other | choice | one line about it
/// name = default                                              of one above; and | source | one line about it
/// - name name                                                 takes some above away
/// ```
/// # Panics
/// If it is none of these, or a default is out of its range: a defect of the case.
pub(super) fn table(texts: &[&'static str]) -> Vec<Parameter> {
    let mut all: Vec<Parameter> = Vec::new();
    let mut source = "";
    for text in texts {
        for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
            let cells: Vec<&'static str> = line.split('|').map(str::trim).collect();
            if let Some(of_lines_below) = line.strip_prefix("source: ") {
                source = of_lines_below;
            } else if let Some(gone) = line.strip_prefix("- ") {
                let before = all.len();
                all.retain(|known| !gone.split(' ').any(|name| known.name == name));
                assert_eq!(before - all.len(), gone.split(' ').count(), "not all of these are above: {line}");
            } else if let Some((name, default)) = cells[0].split_once(" = ") {
                let known = all.iter_mut().find(|known| known.name == name);
                let known = known.unwrap_or_else(|| panic!("no {name} above: {line}"));
                known.default = default_of(&known.range, name, default);
                cells.get(1).into_iter().for_each(|source| known.source = (*source).into());
                cells.get(2).into_iter().for_each(|about| known.about = (*about).into());
            } else {
                let [name, unit, default, range, about, ref own_source @ ..] = cells[..] else {
                    panic!("neither a parameter nor a change of one: {line}");
                };
                let source = own_source.first().copied().unwrap_or(source);
                all.push(if range == "choice" {
                    Parameter::choice(name, default.split(", "), about, source)
                } else {
                    let range = range_of(range);
                    let default = default_of(&range, name, default);
                    let (name, unit, about, source) = (name.into(), unit.into(), about.into(), source.into());
                    Parameter { name, unit, default, range, about, source }
                });
            }
        }
    }
    all
}

fn default_of(range: &Range, name: &str, text: &str) -> Value {
    range.parse(name, text).unwrap_or_else(|error| panic!("default of a parameter: {error}"))
}

fn range_of(text: &str) -> Range {
    match text {
        "finite" => Range::Finite,
        "positive" => Range::Positive,
        "not negative" => Range::NotNegative,
        "fraction" => Range::Fraction,
        _ => {
            let bounds = text.strip_prefix("whole ").and_then(|bounds| bounds.split_once(".."));
            let bounds = bounds.and_then(|(least, most)| Some((least.parse().ok()?, most.parse().ok()?)));
            let (least, most) = bounds.unwrap_or_else(|| panic!("no range of a parameter: {text}"));
            Range::Whole(least, most)
        }
    }
}

impl Parameter {
    /// Declares a numeric parameter.
    pub fn number(
        name: impl Into<Name>,
        unit: impl Into<Name>,
        default: f64,
        range: Range,
        about: impl Into<Name>,
        source: impl Into<Name>,
    ) -> Self {
        let (name, unit, about, source) = (name.into(), unit.into(), about.into(), source.into());
        Parameter { name, unit, default: Value::Number(default), range, about, source }
    }

    /// Declares a parameter that is one of `names`; the first is the default.
    ///
    /// # Panics
    /// If there is no name.
    pub fn choice(
        name: impl Into<Name>,
        names: impl IntoIterator<Item = impl Into<Name>>,
        about: impl Into<Name>,
        source: impl Into<Name>,
    ) -> Self {
        let names: Vec<Name> = names.into_iter().map(Into::into).collect();
        let default = Value::Choice(names[0].clone());
        Parameter {
            name: name.into(),
            unit: "-".into(),
            default,
            range: Range::OneOf(names),
            about: about.into(),
            source: source.into(),
        }
    }
}

/// The parameters of a case with their values. Equal are those with equal values, whoever gave them.
#[derive(Debug, Clone)]
pub struct Parameters {
    case: Name,
    /// Shared by the many runs of a plan that differ in other things, as are the values.
    declared: Arc<[Parameter]>,
    values: Arc<Vec<Value>>,
    /// Which of them were set, to whatever value.
    given: Arc<Vec<bool>>,
    /// All of them as text, made when it is first asked for and shared as well: a plan asks once per run.
    text: Arc<OnceLock<String>>,
}

impl PartialEq for Parameters {
    fn eq(&self, other: &Self) -> bool {
        self.case == other.case && self.declared == other.declared && self.values == other.values
    }
}

/// Parameters that have a use with one choice only: case, parameter, the choice and its value.
const ONLY_WITH: [(&str, &str, &str, &str); 2] =
    [("linear-oscillator", "damping_n_s_m", "variant", "1"), ("quarter-car", "damper_shape", "damper", "nonlinear")];

impl Parameters {
    /// Sets all to their defaults.
    pub fn defaults(case: Name, declared: &[Parameter]) -> Self {
        let values = Arc::new(declared.iter().map(|parameter| parameter.default.clone()).collect());
        let given = Arc::new(vec![false; declared.len()]);
        Parameters { case, declared: declared.into(), values, given, text: Arc::default() }
    }

    /// Returns the name of the case.
    pub fn case(&self) -> &str {
        &self.case
    }

    /// Sets one parameter from text.
    ///
    /// # Errors
    /// [`Error::UnknownName`] for a key the case does not have, [`Error::InvalidValue`] for a value out of range.
    pub fn set(&mut self, key: &str, text: &str) -> Result<()> {
        let index =
            self.declared.iter().position(|parameter| parameter.name == key).ok_or_else(|| Error::UnknownName {
                kind: "parameter",
                found: key.to_owned(),
                valid: self.declared.iter().map(|parameter| parameter.name.clone().into_owned()).collect(),
            })?;
        let value = match self.declared[index].range.parse(key, text)? {
            // −0 is 0, and no other run.
            Value::Number(number) => Value::Number(number + 0.0),
            choice => choice,
        };
        Arc::make_mut(&mut self.values)[index] = value;
        Arc::make_mut(&mut self.given)[index] = true;
        self.text = Arc::default();
        Ok(())
    }

    /// Checks that every parameter that is not at its default has a use with the choices made.
    ///
    /// # Errors
    /// [`Error::Incompatible`], naming the parameter and the choice that it belongs to.
    pub fn check_used(&self) -> Result<()> {
        let changed = |name: &str| {
            let mut all = self.iter();
            all.find(|(parameter, value)| parameter.name == name && parameter.default != **value)
                .map(|(_, value)| value)
        };
        for (_, name, choice, needed) in ONLY_WITH.iter().filter(|(case, ..)| *case == self.case) {
            let (Some(value), chosen) = (changed(name), self.choice(choice)) else { continue };
            if chosen != *needed {
                let message =
                    format!("{name} = {value} has no effect with {choice} = {chosen}: set {choice} = {needed}");
                return Err(Error::Incompatible(message));
            }
        }
        Ok(())
    }

    /// Returns a number by name. The name must be one the case declares: anything else is a defect of the case.
    pub fn number(&self, name: &str) -> f64 {
        match self.value(name) {
            Value::Number(number) => *number,
            Value::Choice(_) => panic!("parameter {name} of case {} is not a number", self.case),
        }
    }

    /// A whole number by name. The name must be one the case declares with [`Range::Whole`]: anything else is a defect of the case.
    pub fn whole(&self, name: &str) -> u32 {
        self.number(name) as u32
    }

    /// Returns a choice by name. The name must be one the case declares: anything else is a defect of the case.
    pub fn choice(&self, name: &str) -> &str {
        match self.value(name) {
            Value::Choice(choice) => choice,
            Value::Number(_) => panic!("parameter {name} of case {} is not a choice", self.case),
        }
    }

    /// Returns all parameters with their values.
    pub fn iter(&self) -> impl Iterator<Item = (&Parameter, &Value)> + '_ {
        self.declared.iter().zip(self.values.iter())
    }

    /// All parameters with their values, one `name = value` per line.
    pub(crate) fn text(&self) -> &str {
        self.text
            .get_or_init(|| self.iter().map(|(parameter, value)| format!("{} = {value}\n", parameter.name)).collect())
    }

    /// Those that were set, also to their defaults, as `key=value` separated by spaces.
    pub fn given(&self) -> String {
        written(self.iter().zip(self.given.iter()).filter(|(_, given)| **given).map(|(pair, _)| pair))
    }

    /// Returns those that differ from their defaults, as `key=value` separated by spaces.
    pub fn changed(&self) -> String {
        written(self.iter().filter(|(parameter, value)| **value != parameter.default))
    }

    fn value(&self, name: &str) -> &Value {
        match self.iter().find(|(parameter, _)| parameter.name == name) {
            Some((_, value)) => value,
            None => panic!("case {} declares no parameter {name}", self.case),
        }
    }
}

fn written<'a>(pairs: impl Iterator<Item = (&'a Parameter, &'a Value)>) -> String {
    pairs.map(|(parameter, value)| format!("{}={value}", parameter.name)).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_checked_and_errors_say_what_is_valid() {
        let declared = [
            Parameter::number("mass_kg", "kg", 1.0, Range::Positive, "mass", "ours"),
            Parameter::choice("coupling", ["force", "pressure"], "coupling", "ours"),
            Parameter::number("wheels", "-", 4.0, Range::Whole(2, 8), "wheels", "ours"),
        ];
        let mut parameters = Parameters::defaults("test".into(), &declared);
        parameters.set("mass_kg", "2.5").unwrap();
        parameters.set("coupling", "pressure").unwrap();
        assert_eq!((parameters.number("mass_kg"), parameters.choice("coupling")), (2.5, "pressure"));
        for (key, text, wanted) in [
            ("mass_kg", "-1", "mass_kg = -1 is not valid; valid: a finite number above 0"),
            ("mass_kg", "NaN", "mass_kg = NaN is not valid; valid: a finite number above 0"),
            ("wheels", "2.5", "wheels = 2.5 is not valid; valid: a whole number from 2 to 8"),
            ("wheels", "9", "wheels = 9 is not valid; valid: a whole number from 2 to 8"),
            ("mass_kg", "ten", "mass_kg = ten is not valid; valid: a finite number above 0"),
            ("coupling", "forse", "coupling = forse is not valid; valid: one of force, pressure"),
            ("mass_k", "1", "unknown parameter `mass_k` (did you mean `mass_kg`?); valid: mass_kg, coupling, wheels"),
        ] {
            assert_eq!(parameters.set(key, text).unwrap_err().to_string(), wanted);
        }
        assert_eq!(parameters.changed(), "mass_kg=2.5 coupling=pressure");
        assert_eq!(parameters.text(), "mass_kg = 2.5\ncoupling = pressure\nwheels = 4.0\n");
        let before = parameters.clone();
        parameters.set("wheels", "3").unwrap();
        assert!(before.text().ends_with("wheels = 4.0\n") && parameters.text().ends_with("wheels = 3.0\n"));
    }

    #[test]
    fn what_was_set_to_its_default_is_the_same_and_is_said() {
        let declared = [Parameter::number("mass_kg", "kg", 1.0, Range::Positive, "mass", "ours")];
        let usual = Parameters::defaults("test".into(), &declared);
        let mut set = usual.clone();
        set.set("mass_kg", "1").unwrap();
        assert_eq!(set, usual);
        assert_eq!((set.given(), set.changed()), ("mass_kg=1.0".to_owned(), String::new()));
        assert_eq!(usual.given(), "");
    }
}
