//! What determines a run, as one list: run id, tables, JSON and plans all read it.

use super::spec::{RunSettings, RunSpec};
use crate::metrics::{METRICS, Only};
use rimbench_core::cosim::StepControl;
use rimbench_core::numerics_version::NUMERICS_VERSION;
use sha2::{Digest, Sha256};
use std::fmt::{self, Write};

/// What a fact says.
#[derive(Debug, Clone, PartialEq)]
pub enum FactValue {
    /// A name or a sentence; empty where there is nothing to say.
    Text(String),
    /// A number; infinite or not a number where it is so.
    Number(f64),
    /// A count.
    Count(u64),
}

impl fmt::Display for FactValue {
    /// Writes numbers as the shortest text that reads back to the same bits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FactValue::Text(text) => f.write_str(text),
            FactValue::Number(number) => write!(f, "{number:?}"),
            FactValue::Count(count) => count.fmt(f),
        }
    }
}

/// One fact about a run: its name in data, with the unit, and what it says; nothing where it does not apply.
#[derive(Debug, Clone, PartialEq)]
pub struct Fact {
    /// Name of the column.
    pub name: &'static str,
    /// What it says.
    pub value: Option<FactValue>,
    /// Whether a run without it has the id, and a table of such runs the columns, that it had before there was such an option.
    pub of_some_runs: bool,
}

impl Fact {
    /// States what applies to some runs only.
    pub fn new(name: &'static str, value: Option<FactValue>) -> Self {
        Fact { name, value, of_some_runs: false }
    }

    /// States a name, if it applies.
    fn if_any(name: &'static str, text: Option<impl fmt::Display>) -> Self {
        Fact::new(name, text.map(|text| FactValue::Text(text.to_string())))
    }

    /// Makes it one of some runs: those without it stay as they were.
    fn of_some_runs(self) -> Self {
        Fact { of_some_runs: true, ..self }
    }

    /// States a name or a sentence.
    pub fn text(name: &'static str, text: impl Into<String>) -> Self {
        Fact::new(name, Some(FactValue::Text(text.into())))
    }

    /// States a number, if it applies.
    pub fn number(name: &'static str, number: impl Into<Option<f64>>) -> Self {
        Fact::new(name, number.into().map(FactValue::Number))
    }

    /// States a count.
    pub fn count(name: &'static str, count: u64) -> Self {
        Fact::new(name, Some(FactValue::Count(count)))
    }

    /// Writes it as a cell of a table; empty where it does not apply.
    pub fn cell(&self) -> String {
        self.value.as_ref().map(FactValue::to_string).unwrap_or_default()
    }
}

/// Finds the runs that a metric or a counter, by its column in tables, says something of; none where these are all.
pub fn only_of(column: &str) -> Option<Only> {
    let metric = METRICS.iter().find(|metric| metric.name == column);
    metric.map_or_else(|| (column == "catch_up_steps").then_some(Only::Late), |metric| metric.only)
}

impl RunSpec {
    /// Tells whether a table of this run has a column that is of `only` such runs; of what is claimed the claims tell.
    pub fn has_column(&self, column: &str, only: Only) -> bool {
        match only {
            Only::Split => self.scheme.splits,
            Only::Audit => self.audit,
            Only::Late => self.delivery.is_some(),
            Only::Column => self.case.trace_columns.iter().any(|own| own == column),
            Only::Friction | Only::Claimed => true,
        }
    }

    /// Lists everything that determines the run.
    pub fn facts(&self) -> Vec<Fact> {
        let RunSettings {
            case,
            parameters,
            scheme,
            model,
            gain,
            solver,
            sequence,
            force_return,
            mechanics_steps,
            mechanics_integrator,
            actuator_integrator,
            delivery,
            belief,
            macro_step,
            step_control,
            phase,
            micro_step,
            duration,
            audit,
            // Neither says anything of how the run goes.
            predict_growth: _,
            wall_limit: _,
        } = &**self;
        let (model, delivery, rule) = (model.as_ref(), delivery.as_ref(), step_control.as_ref());
        let rows = model.filter(|_| self.has_slip_rows()).map(|model| model.friction_rows);
        vec![
            Fact::text("case", case.name.clone()),
            Fact::text("set", parameters.given()),
            Fact::text("scheme", scheme.name.clone()),
            Fact::text("sequence", sequence.to_string()),
            Fact::text("force_return", force_return.to_string()),
            Fact::text("mechanics_steps", mechanics_steps.to_string()),
            Fact::text("mechanics_integrator", mechanics_integrator.to_string()),
            Fact::text("actuator_integrator", actuator_integrator.to_string()),
            Fact::if_any("redundancy", model.map(|model| model.redundancy)),
            Fact::if_any("model_motion", model.map(|model| model.motion)),
            Fact::if_any("contact_detection", model.and_then(|model| model.detection)),
            Fact::if_any("split", model.filter(|_| scheme.splits).map(|model| model.split)).of_some_runs(),
            Fact::if_any("friction_rows", rows).of_some_runs(),
            Fact::if_any("delivery_up", delivery.map(|delivery| &delivery.up)).of_some_runs(),
            Fact::if_any("delivery_down", delivery.map(|delivery| &delivery.down)).of_some_runs(),
            Fact::if_any("late_samples", delivery.map(|delivery| delivery.late)).of_some_runs(),
            Fact::if_any("late_forces", delivery.map(|delivery| delivery.bridge)).of_some_runs(),
            Fact::if_any("belief", belief.as_ref()).of_some_runs(),
            Fact::text("solver", solver.name.clone()),
            Fact::number("gain", *gain),
            Fact::number("macro_step_s", *macro_step),
            Fact::text("step_control", rule.map_or(StepControl::None, |rule| rule.control).to_string()),
            Fact::number("step_tolerance", rule.map(|rule| rule.tolerance)),
            Fact::number("min_macro_step_s", rule.map(|rule| rule.shortest)),
            Fact::number("phase", *phase),
            Fact::number("micro_step_s", *micro_step),
            Fact::number("duration_s", *duration),
            Fact::if_any("audit", audit.then_some(audit)).of_some_runs(),
        ]
    }

    /// Hash of everything that determines the run, 16 hexadecimal digits: all facts, every parameter, and the version of the
    /// numerics. A parameter that is set to its default is as one that is not set.
    pub fn id(&self) -> String {
        let mut text = format!("numerics {NUMERICS_VERSION}\n");
        let mut line = |name: &str, value: &dyn fmt::Display| {
            // Writing to memory cannot fail.
            let _ = writeln!(text, "{name} = {value}");
        };
        for fact in self.facts() {
            match &fact.value {
                None if fact.of_some_runs => {}
                _ if fact.name == "set" => line(fact.name, &self.parameters.changed()),
                Some(value) => line(fact.name, value),
                None => line(fact.name, &""),
            }
        }
        text += self.parameters.text();
        let hash = Sha256::digest(text)[..8].iter().fold(0_u64, |hash, &byte| hash << 8 | u64::from(byte));
        format!("{hash:016x}")
    }
}

#[cfg(test)]
mod tests {
    use super::super::request::RunRequest;
    use super::*;
    use crate::catalogue::Catalogue;
    use std::collections::HashMap;

    /// A value of each option that differs from the usual one, and the scheme that takes it.
    const CHANGES: &[(&str, &str, &str)] = &[
        ("case", "wedge-box-two-ledges", "rim-smooth"),
        ("scheme", "rim-nonsmooth", "rim-smooth"),
        ("sequence", "jacobi", "rim-smooth"),
        ("force_return", "end", "rim-smooth"),
        ("mechanics_steps", "all", "rim-smooth"),
        ("mechanics_integrator", "midpoint", "rim-smooth"),
        ("actuator_integrator", "midpoint", "rim-smooth"),
        ("redundancy", "regularised:1e-6", "rim-smooth"),
        ("model_motion", "extrapolated", "rim-smooth"),
        ("contact_detection", "margin:1e-3", "rim-nonsmooth"),
        ("split", "joint", "rim-split"),
        ("friction_rows", "slip-direction", "rim-nonsmooth"),
        ("delivery_up", "delay:1", "rim-smooth"),
        ("delivery_down", "loss:0.1", "rim-smooth"),
        ("late_samples", "raw", "rim-smooth"),
        ("late_forces", "linear", "rim-smooth"),
        ("belief", "mass:1.2", "rim-smooth"),
        ("solver", "lemke", "rim-smooth"),
        ("gain", "0.25", "nepce"),
        ("macro_step_s", "1e-3", "rim-smooth"),
        ("phase", "0.5", "rim-smooth"),
        ("micro_step_s", "1e-5", "rim-smooth"),
        ("duration_s", "1.25", "rim-smooth"),
        ("step_control", "energy-residual", "zero-order-hold"),
        ("step_tolerance", "0.01", "zero-order-hold"),
        ("min_macro_step_s", "1e-4", "zero-order-hold"),
    ];

    #[test]
    fn every_option_changes_the_fact_of_its_name_and_the_id() {
        let catalogue = Catalogue::standard();
        let resolved = |request: &RunRequest| request.resolve(&catalogue).unwrap();
        let by_name = |request: &RunRequest| -> HashMap<&str, String> {
            resolved(request).facts().into_iter().map(|fact| (fact.name, fact.cell())).collect()
        };
        for &(key, text, scheme) in CHANGES {
            let mut usual = RunRequest::of(if key == "friction_rows" { "tripod" } else { "wedge-box" }, scheme);
            if ["step_tolerance", "min_macro_step_s"].contains(&key) {
                usual.put("step_control", "energy-residual").unwrap();
                usual.put("step_tolerance", "0.1").unwrap();
            }
            if key.starts_with("late_") {
                usual.put("delivery_down", "delay:1").unwrap();
            }
            let mut changed = usual.clone();
            changed.put(key, text).unwrap();
            if key == "step_control" {
                changed.put("step_tolerance", "0.1").unwrap();
            }
            assert_ne!(by_name(&usual)[key], by_name(&changed)[key], "{key}");
            assert_ne!(resolved(&usual).id(), resolved(&changed).id(), "{key}");
        }
        // All but the wall limit, which is no part of what a run is.
        let usual = resolved(&RunRequest::of("wedge-box", "rim-smooth"));
        assert_ne!(usual.clone().audited().unwrap().id(), usual.id());
        let missing: Vec<&str> = RunRequest::OPTIONS
            .iter()
            .map(|option| option.key)
            .filter(|key| !CHANGES.iter().any(|(changed, ..)| changed == key))
            .collect();
        assert_eq!(missing, ["wall_limit_s"]);
    }

    #[test]
    fn a_parameter_of_the_case_changes_the_id() {
        let catalogue = Catalogue::standard();
        let usual = RunRequest::of("wedge-box", "rim-smooth");
        let set = vec![("box_mass_kg".to_owned(), "250".to_owned())];
        let changed = RunRequest { set, ..usual.clone() }.resolve(&catalogue).unwrap();
        assert_ne!(usual.resolve(&catalogue).unwrap().id(), changed.id());
        assert_eq!(changed.facts()[1], Fact::text("set", "box_mass_kg=250.0"));
        // The default, said aloud: told apart in the table, and still the same run.
        let set = vec![("box_mass_kg".to_owned(), "200".to_owned())];
        let said = RunRequest { set, ..usual.clone() }.resolve(&catalogue).unwrap();
        assert_eq!(said.facts()[1], Fact::text("set", "box_mass_kg=200.0"));
        assert_eq!(said.id(), usual.resolve(&catalogue).unwrap().id());
    }
}
