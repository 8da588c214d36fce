//! A case file that names two FMUs.

use super::member::{FmuMember, Process};
use crate::export::side_name;
use rimbench_cases::cases::{
    Case, CaseDefaults, CoupledSystem, InterfaceColumns, Parameter, Parameters, PossibleSteps, Range,
};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::cosim::{PerSide, Side, check_coupling};
use rimbench_core::error::{Error, Result};
use rimbench_core::name::{Name, check_new_name};
use rimbench_results::input::read_text;
use rimbench_results::schema::schema_of;
use rimbench_results::text_place::said_at;
use schemars::JsonSchema;
use serde::Deserialize;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// A case file as it is written.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Case of rimbench made of FMUs")]
pub(super) struct CaseFile {
    #[schemars(extend("pattern" = "^[a-z][a-z0-9]*(-[a-z0-9]+)*$"))]
    pub(super) name: String,
    /// One line.
    #[serde(default)]
    pub(super) about: String,
    /// Simulated time, s.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(super) duration_s: f64,
    /// Usual H, s.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(super) macro_step_s: f64,
    /// Longest step of the actuator, s.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(super) micro_step_s: Option<f64>,
    /// Coarsest of the three steps of the reference, s.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(super) reference_step_s: Option<f64>,
    #[serde(default)]
    pub(super) process: ProcessKind,
    /// After so long without an answer a process is ended, s.
    #[serde(default = "minute")]
    #[schemars(range(min = SHORTEST_ANSWER))]
    pub(super) answer_within_s: f64,
    pub(super) mechanics: SideTable,
    pub(super) actuator: SideTable,
    #[schemars(length(min = 1))]
    pub(super) interface: Vec<Row>,
    #[serde(default)]
    pub(super) parameters: BTreeMap<String, ParameterTable>,
}

/// Returns the JSON Schema of a case file.
pub fn case_file_schema() -> serde_json::Value {
    schema_of::<CaseFile>()
}

impl CaseFile {
    pub(super) fn side(&self, side: Side) -> &SideTable {
        if side == Side::Mechanics { &self.mechanics } else { &self.actuator }
    }
}

fn minute() -> f64 {
    60.0
}

#[derive(Debug, Default, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ProcessKind {
    /// Each FMU in a process of its own.
    #[default]
    Own,
    /// In this one: faster, and a crash ends everything.
    Same,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SideTable {
    /// The file, relative to this one.
    pub(super) fmu: PathBuf,
    /// Libraries whose symbols the FMU takes for granted, loaded before it.
    #[serde(default)]
    pub(super) needs: Vec<PathBuf>,
    /// Values that are set before a run.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub(super) start: BTreeMap<String, toml::Value>,
    /// Variables that become columns.
    #[serde(default)]
    pub(super) observe: Vec<String>,
    /// The variable that counts the work received, an energy.
    pub(super) interface_work: Option<String>,
    /// Whether outputs follow inputs at once.
    pub(super) direct_feedthrough: Option<bool>,
    /// The longest step by which an FMU without derivatives is probed, s.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(super) probe_step_s: Option<f64>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Row {
    pub(super) columns: Option<[String; 3]>,
    pub(super) mechanics: Ends,
    pub(super) actuator: Ends,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Ends {
    pub(super) position: End,
    pub(super) velocity: End,
    pub(super) force: End,
}

/// A variable, and what its value is multiplied by besides its unit.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "valid: the name of a variable, or { variable = \"…\", factor = … }"
)]
pub(super) enum End {
    Plain(String),
    Scaled {
        variable: String,
        #[schemars(extend("not" = { "const": 0 }))]
        factor: f64,
    },
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ParameterTable {
    pub(super) default: f64,
    #[serde(default)]
    pub(super) unit: String,
    #[serde(default)]
    pub(super) about: String,
    /// The variable of that side that takes it.
    pub(super) mechanics: Option<String>,
    /// The variable of that side that takes it.
    pub(super) actuator: Option<String>,
}

/// The parameter that says what a case is made from.
const DIGEST: &str = "fmu_digest";

/// Shortest time that a process is given for an answer, s.
const SHORTEST_ANSWER: f64 = 1e-3;

/// Reads a case file with its FMUs, and tries both sides once. `program` is rimbench itself, for FMUs in processes of their own; without
/// it they all run in this one.
///
/// # Errors
/// [`Error::File`] naming the case file or the FMU, what is wrong with it, and what would be valid.
pub fn read_case(path: &Path, program: Option<&Path>) -> Result<Case> {
    let wrong = |message: String| Error::file(path, message);
    let text = read_text(path)?;
    let file: CaseFile = toml::from_str(&text)
        .map_err(|error| wrong(format!("is no case of FMUs: {}", said_at(&text, error.span(), error.message()))))?;
    check_new_name("case", &file.name, std::iter::empty()).map_err(|error| wrong(error.to_string()))?;
    let times = [
        ("duration_s".to_owned(), Some(file.duration_s)),
        ("macro_step_s".to_owned(), Some(file.macro_step_s)),
        ("micro_step_s".to_owned(), file.micro_step_s),
        ("reference_step_s".to_owned(), file.reference_step_s),
    ];
    let probes =
        Side::BOTH.map(|side| (format!("probe_step_s of [{}]", side_name(side)), file.side(side).probe_step_s));
    for (key, value) in times.into_iter().chain(probes).filter_map(|(key, value)| Some((key, value?))) {
        if !(value.is_finite() && value > 0.0) {
            return Err(wrong(Error::invalid(key, value, "a finite time above 0 s").to_string()));
        }
    }
    let patience = file.answer_within_s;
    if !(patience.is_finite() && patience >= SHORTEST_ANSWER) {
        let valid = format!("a finite time of at least {SHORTEST_ANSWER} s");
        return Err(wrong(Error::invalid("answer_within_s", patience, valid).to_string()));
    }
    let micro_step_s = file.micro_step_s.unwrap_or(file.macro_step_s);
    if micro_step_s > file.macro_step_s {
        let valid = format!("at most macro_step_s, {} s", file.macro_step_s);
        return Err(wrong(Error::invalid("micro_step_s", micro_step_s, valid).to_string()));
    }
    file.parameters.iter().try_for_each(|(name, table)| check_parameter(name, table)).map_err(wrong)?;
    if file.interface.is_empty() {
        return Err(wrong("has no [[interface]]: at least one row couples the two sides".to_owned()));
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let rows = columns(&file.interface);
    let member = |side: Side| {
        FmuMember::open(&file, &folder.join(&file.side(side).fmu), side, &rows).map_err(|error| match error {
            Error::File { .. } => error,
            other => wrong(other.to_string()),
        })
    };
    let members =
        PerSide { mechanics: Arc::new(member(Side::Mechanics)?), actuator: Arc::new(member(Side::Actuator)?) };
    check_coupling(members.as_ref().map(|member| &member.ports)).map_err(|error| {
        wrong(format!(
            "{error}; `direct_feedthrough = false` says of a side that its outputs do not depend on its inputs at once"
        ))
    })?;
    let interface_columns = rows
        .iter()
        .map(|[position, velocity, force]| InterfaceColumns::new(position.clone(), velocity.clone(), force.clone()));
    let interface_columns = interface_columns.collect();
    let mut trace: Vec<Name> = vec!["time_s".into()];
    trace.extend(rows.iter().flatten().cloned().map(Name::from));
    trace.extend(["force_to_mechanics_n", "force_2_to_mechanics_n"].into_iter().take(rows.len()).map(Name::from));
    for side in Side::BOTH {
        trace.extend(members[side].offers.observables.iter().cloned());
    }
    if let Some(name) = trace.iter().find(|name| !can_name_a_column(name)) {
        return Err(wrong(format!(
            "a column of the trace is named {:?}; valid: a name without commas, quotes and line breaks",
            name.to_string()
        )));
    }
    let mut seen = BTreeSet::new();
    if let Some(twice) = trace.iter().find(|name| !seen.insert((*name).clone())) {
        return Err(wrong(format!("two columns of the trace are named `{twice}`")));
    }
    let mut hash = Sha256::new();
    hash.update(&text);
    Side::BOTH.into_iter().for_each(|side| hash.update(&members[side].unpacked.digest));
    let digest = hash.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    let process = match (file.process, program) {
        (ProcessKind::Own, Some(program)) => Process::Own {
            program: program.to_owned(),
            // What is longer is for ever.
            answer_within: Duration::from_secs_f64(patience.min(1e9)),
        },
        _ => Process::Same,
    };
    let steps = members.as_ref().map(|member| {
        let description = &member.unpacked.description;
        PossibleSteps { equal: !description.any_step, multiple_of: description.internal_step }
    });
    let macro_step_s = file.macro_step_s;
    let reference_step_s = file.reference_step_s.unwrap_or(0.5 * micro_step_s);
    for side in Side::BOTH {
        // The finest of the three solutions takes a quarter of the step.
        if let Some(unit) = steps[side].multiple_of.filter(|_| !steps[side].allows(0.25 * reference_step_s)) {
            let valid = format!(
                "a multiple of {:e} s: the FMU of the {} takes multiples of {unit:e} s",
                4.0 * unit,
                side_name(side)
            );
            return Err(wrong(Error::invalid("reference_step_s", reference_step_s, valid).to_string()));
        }
    }
    let defaults = CaseDefaults {
        duration_s: file.duration_s,
        macro_step_s,
        micro_step_s,
        reference_step_s,
        reference_sampling_s: micro_step_s,
    };
    let build = move |parameters: &Parameters, _: &_| -> Result<CoupledSystem> {
        let made = |side: Side| members[side].side(parameters, &process, macro_step_s).map_err(Error::Incompatible);
        Ok(CoupledSystem::of(PerSide { mechanics: made(Side::Mechanics)?, actuator: made(Side::Actuator)? }))
    };
    let about = if file.about.is_empty() { format!("FMUs of {}", path.display()) } else { file.about.clone() };
    let case = Case {
        trace_columns: trace,
        interface_columns,
        steps,
        ..Case::with_parameters(file.name.clone(), about, defaults, parameters(&file, digest), build)
    };
    (case.build)(&case.default_parameters(), &SolverEntry::active_set())?;
    Ok(case)
}

/// Whether a name stands in a table of comma-separated values as it is.
fn can_name_a_column(name: &str) -> bool {
    !name.trim().is_empty() && !name.contains([',', '"']) && !name.contains(char::is_control)
}

/// Checks what of a parameter needs no FMU.
fn check_parameter(name: &str, table: &ParameterTable) -> std::result::Result<(), String> {
    if name == DIGEST {
        return Err(format!("[parameters.{name}]: that name is taken by the hash of FMUs"));
    }
    if name.is_empty() || name.trim() != name || name.contains(['=', ',', '"']) || name.contains(char::is_control) {
        return Err(format!(
            "[parameters] has {name:?}; valid: a name without =, commas, quotes, line breaks and spaces around it"
        ));
    }
    if !table.default.is_finite() {
        return Err(format!("[parameters.{name}] default = {} is not valid; valid: a finite number", table.default));
    }
    Ok(())
}

/// Names of position, velocity and force of each row.
fn columns(rows: &[Row]) -> Vec<[String; 3]> {
    let named = rows.iter().enumerate().map(|(index, row)| {
        let number = if rows.len() == 1 { String::new() } else { format!("_{}", index + 1) };
        let usual = || ["position", "velocity", "force"].iter().zip(["m", "m_s", "n"]);
        let usual = usual().map(|(name, unit)| format!("interface{number}_{name}_{unit}")).collect::<Vec<_>>();
        row.columns.clone().unwrap_or_else(|| std::array::from_fn(|at| usual[at].clone()))
    });
    named.collect()
}

/// Parameters of a case: those of its file, and one that says what it is made from, so that results of other FMUs are not taken for its.
fn parameters(file: &CaseFile, digest: String) -> Vec<Parameter> {
    let given = file.parameters.iter().map(|(name, table)| {
        let unit = if table.unit.is_empty() { "-" } else { &table.unit };
        let about = if table.about.is_empty() { "a parameter of an FMU" } else { &table.about };
        Parameter::number(
            name.clone(),
            unit.to_owned(),
            table.default,
            Range::Finite,
            about.to_owned(),
            "given in the case file",
        )
    });
    let about = "hash of the case file and what it names; not to be set";
    given.chain([Parameter::choice(DIGEST, [digest], about, "the files themselves")]).collect()
}

impl Row {
    /// What a side calls one of its variables (0: position, 1: velocity, 2: force), and what that is multiplied by, if that is said.
    pub(super) fn end(&self, side: Side, which: usize) -> (&str, Option<f64>) {
        let ends = if side == Side::Mechanics { &self.mechanics } else { &self.actuator };
        match [&ends.position, &ends.velocity, &ends.force][which] {
            End::Plain(variable) => (variable, None),
            End::Scaled { variable, factor } => (variable, Some(*factor)),
        }
    }
}
