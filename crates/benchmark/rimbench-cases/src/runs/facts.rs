//! What determines a run, as one list: run id, tables, JSON and plans all read it.

use super::spec::{RunSettings, RunSpec};
use crate::metrics::{METRICS, Only};
use rimbench_core::cosim::{MechanicsSteps, StepControl};
use rimbench_core::numerics_version::NUMERICS_VERSION;
use rimbench_core::schemes::ContactsAct;
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
        let longest = match mechanics_steps {
            MechanicsSteps::AtMost(step) => Some(*step),
            MechanicsSteps::Count(_) | MechanicsSteps::AsActuator => None,
        };
        let rows = model.filter(|_| self.has_slip_rows()).map(|model| model.friction_rows);
        let act = model.map(|model| model.contacts_act).filter(|act| *act != ContactsAct::default());
        vec![
            Fact::text("case", case.name.clone()),
            Fact::text("set", parameters.given()),
            Fact::text("scheme", scheme.name.clone()),
            Fact::text("sequence", sequence.to_string()),
            Fact::text("force_return", force_return.to_string()),
            Fact::if_any("mechanics_steps", longest.is_none().then_some(mechanics_steps)),
            Fact::number("mechanics_step_s", longest).of_some_runs(),
            Fact::text("mechanics_integrator", mechanics_integrator.to_string()),
            Fact::text("actuator_integrator", actuator_integrator.to_string()),
            Fact::if_any("redundancy", model.map(|model| model.redundancy)),
            Fact::if_any("model_motion", model.map(|model| model.motion)),
            Fact::if_any("contact_detection", model.and_then(|model| model.detection)),
            Fact::if_any("split", model.filter(|_| scheme.splits).map(|model| model.split)).of_some_runs(),
            Fact::if_any("friction_rows", rows).of_some_runs(),
            Fact::if_any("contacts_act", act).of_some_runs(),
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
        let counted = self.in_one_form();
        if counted != self.mechanics_steps {
            return self.counting(counted).id();
        }
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
