//! Named parameters of a case: what can be set, to what, and what it was set to.

mod declaration;
mod values;

#[doc(hidden)]
pub use declaration::SharedSet;
pub use declaration::{ParameterSet, choices, named, parameters};
pub use values::{Range, Setting, Value, unit_of, without_unit};

use rimbench_core::error::{Error, Result};
use rimbench_core::name::Name;
use std::sync::{Arc, OnceLock};

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
    /// A sensible range for studies, narrower than what is valid, where one is declared.
    pub study: Option<[f64; 2]>,
    /// The values of other parameters, `[name, value]`, without which it has no use.
    pub only_with: &'static [[&'static str; 2]],
    /// Whether it is the distance to what is touched first, so that a contact's gap follows it.
    pub is_gap: bool,
}

impl Parameter {
    /// Declares a parameter with the unit that its name ends in.
    ///
    /// # Panics
    /// If the default is not valid: a defect of the case.
    pub fn of<S: Setting>(
        name: &'static str,
        default: S,
        valid: S::Valid,
        about: &'static str,
        source: &'static str,
    ) -> Self {
        let (default, range) = (default.value(), S::range(valid));
        if let Err(error) = range.parse(name, &default.to_string()) {
            panic!("default of a parameter: {error}");
        }
        let unit = if matches!(range, Range::OneOf(_)) { "-" } else { unit_of(name) };
        let (name, unit, about, source) = (name.into(), unit.into(), about.into(), source.into());
        Parameter { name, unit, default, range, about, source, study: None, only_with: &[], is_gap: false }
    }

    /// Gives it a sensible range for studies.
    #[must_use]
    pub fn study(self, range: std::ops::Range<f64>) -> Self {
        Parameter { study: Some([range.start, range.end]), ..self }
    }

    /// Says of which values of others, `[name, value]`, it has a use.
    #[must_use]
    pub fn when(self, only_with: &'static [[&'static str; 2]]) -> Self {
        Parameter { only_with, ..self }
    }

    /// Says that it is the distance to what is touched first.
    #[must_use]
    pub fn gap(self) -> Self {
        Parameter { is_gap: true, ..self }
    }

    /// Gives it a source of its own.
    #[must_use]
    pub fn from(self, source: &'static str) -> Self {
        Parameter { source: source.into(), ..self }
    }

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
        Parameter {
            name,
            unit,
            default: Value::Number(default),
            range,
            about,
            source,
            study: None,
            only_with: &[],
            is_gap: false,
        }
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
            study: None,
            only_with: &[],
            is_gap: false,
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
    /// How long the run is for which a case is built, s, where that is known. Part of the run and not of what it is set
    /// to.
    duration: Option<f64>,
}

impl PartialEq for Parameters {
    fn eq(&self, other: &Self) -> bool {
        self.case == other.case && self.declared == other.declared && self.values == other.values
    }
}

impl Parameters {
    /// Sets all to their defaults.
    pub fn defaults(case: Name, declared: &[Parameter]) -> Self {
        let values = Arc::new(declared.iter().map(|parameter| parameter.default.clone()).collect());
        let given = Arc::new(vec![false; declared.len()]);
        Parameters { case, declared: declared.into(), values, given, text: Arc::default(), duration: None }
    }

    /// The same for a run of this duration, s: a side from outside is told when it ends.
    #[must_use]
    pub fn lasting(mut self, duration: f64) -> Self {
        self.duration = Some(duration);
        self
    }

    /// Returns how long the run is, s, where that is known.
    pub fn duration(&self) -> Option<f64> {
        self.duration
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
        for (Parameter { name, only_with, .. }, value) in self.iter().filter(|(known, value)| known.default != **value)
        {
            for [choice, needed] in *only_with {
                let chosen =
                    self.iter().find(|(parameter, _)| parameter.name == *choice).map(|(_, chosen)| chosen.to_string());
                if let Some(chosen) = chosen.filter(|chosen| !is_met(chosen, needed)) {
                    let sign = if needed.starts_with('>') { "" } else { "= " };
                    let message =
                        format!("{name} = {value} has no effect with {choice} = {chosen}: set {choice} {sign}{needed}");
                    return Err(Error::Incompatible(message));
                }
            }
        }
        Ok(())
    }

    /// Returns a value by name, if the case declares the name and its kind is this.
    pub fn setting<S: Setting>(&self, name: &str) -> Option<S> {
        self.iter().find(|(parameter, _)| parameter.name == name).and_then(|(_, value)| S::of(value))
    }

    /// Returns all parameters with their values.
    pub fn iter(&self) -> impl Iterator<Item = (&Parameter, &Value)> + '_ {
        self.declared.iter().zip(self.values.iter())
    }

    /// Returns all parameters with their values, one `name = value` per line, sorted: in which order a case declares them is no
    /// part of a run.
    pub fn text(&self) -> &str {
        self.text.get_or_init(|| {
            let line = |(parameter, value): (&Parameter, &Value)| format!("{} = {value}\n", parameter.name);
            let mut lines: Vec<String> = self.iter().map(line).collect();
            lines.sort_unstable();
            lines.concat()
        })
    }

    /// Those that were set, also to their defaults, as `key=value` separated by spaces.
    pub fn given(&self) -> String {
        written(self.iter().zip(self.given.iter()).filter(|(_, given)| **given).map(|(pair, _)| pair))
    }

    /// Returns those that differ from their defaults, as `key=value` separated by spaces.
    pub fn changed(&self) -> String {
        written(self.iter().filter(|(parameter, value)| **value != parameter.default))
    }
}

/// Whether a choice is the one that is needed, or a number above that of `> number`.
fn is_met(chosen: &str, needed: &str) -> bool {
    let above = needed.strip_prefix("> ").and_then(|bound| Some((chosen.parse::<f64>().ok()?, bound.parse().ok()?)));
    above.map_or(chosen == needed, |(number, bound): (f64, f64)| number > bound)
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
        assert_eq!((parameters.setting("mass_kg"), parameters.setting("wheels")), (Some(2.5), Some(4)));
        assert_eq!((parameters.setting::<f64>("coupling"), parameters.setting::<f64>("mass")), (None, None));
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
        assert_eq!(parameters.text(), "coupling = pressure\nmass_kg = 2.5\nwheels = 4.0\n");
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
