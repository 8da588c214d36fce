//! A case file that names two FMUs.

use super::archive::Unpacked;
use super::description::{ENERGY, Exponents, FORCE, FmuVariable, LENGTH, Type, VELOCITY};
use super::host::{Host, ModelVariables, Plan, Probe, Scaled, Start};
use super::library::Loaded;
use super::process::Remote;
use super::side::{ImportedSide, ModelSize, Offers};
use crate::export::side_name;
use rimbench_cases::cases::{
    Case, CaseDefaults, CoupledSystem, InterfaceColumns, Parameter, Parameters, PossibleSteps, Range,
};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::cosim::{PerSide, Port, Ports, Quantity, Side, Subsystem, check_coupling};
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
struct CaseFile {
    #[schemars(extend("pattern" = "^[a-z][a-z0-9]*(-[a-z0-9]+)*$"))]
    name: String,
    /// One line.
    #[serde(default)]
    about: String,
    /// Simulated time, s.
    #[schemars(extend("exclusiveMinimum" = 0))]
    duration_s: f64,
    /// Usual H, s.
    #[schemars(extend("exclusiveMinimum" = 0))]
    macro_step_s: f64,
    /// Longest step of the actuator, s.
    #[schemars(extend("exclusiveMinimum" = 0))]
    micro_step_s: Option<f64>,
    /// Coarsest of the three steps of the reference, s.
    #[schemars(extend("exclusiveMinimum" = 0))]
    reference_step_s: Option<f64>,
    #[serde(default)]
    process: ProcessKind,
    /// After so long without an answer a process is ended, s.
    #[serde(default = "minute")]
    #[schemars(range(min = SHORTEST_ANSWER))]
    answer_within_s: f64,
    mechanics: SideTable,
    actuator: SideTable,
    #[schemars(length(min = 1))]
    interface: Vec<Row>,
    #[serde(default)]
    parameters: BTreeMap<String, ParameterTable>,
}

/// Returns the JSON Schema of a case file.
pub fn case_file_schema() -> serde_json::Value {
    schema_of::<CaseFile>()
}

impl CaseFile {
    fn side(&self, side: Side) -> &SideTable {
        if side == Side::Mechanics { &self.mechanics } else { &self.actuator }
    }
}

fn minute() -> f64 {
    60.0
}

#[derive(Debug, Default, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum ProcessKind {
    /// Each FMU in a process of its own.
    #[default]
    Own,
    /// In this one: faster, and a crash ends everything.
    Same,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct SideTable {
    /// The file, relative to this one.
    fmu: PathBuf,
    /// Libraries whose symbols the FMU takes for granted, loaded before it.
    #[serde(default)]
    needs: Vec<PathBuf>,
    /// Values that are set before a run.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    start: BTreeMap<String, toml::Value>,
    /// Variables that become columns.
    #[serde(default)]
    observe: Vec<String>,
    /// The variable that counts the work received, an energy.
    interface_work: Option<String>,
    /// Whether outputs follow inputs at once.
    direct_feedthrough: Option<bool>,
    /// The longest step by which an FMU without derivatives is probed, s.
    #[schemars(extend("exclusiveMinimum" = 0))]
    probe_step_s: Option<f64>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Row {
    columns: Option<[String; 3]>,
    mechanics: Ends,
    actuator: Ends,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Ends {
    position: End,
    velocity: End,
    force: End,
}

/// A variable, and what its value is multiplied by besides its unit.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "valid: the name of a variable, or { variable = \"…\", factor = … }"
)]
enum End {
    Plain(String),
    Scaled {
        variable: String,
        #[schemars(extend("not" = { "const": 0 }))]
        factor: f64,
    },
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ParameterTable {
    default: f64,
    #[serde(default)]
    unit: String,
    #[serde(default)]
    about: String,
    /// The variable of that side that takes it.
    mechanics: Option<String>,
    /// The variable of that side that takes it.
    actuator: Option<String>,
}

/// Units of positions, velocities and forces.
const UNITS: [(Quantity, Exponents, &str); 3] =
    [(Quantity::Position, LENGTH, "m"), (Quantity::Velocity, VELOCITY, "m/s"), (Quantity::Force, FORCE, "N")];

/// The parameter that says what a case is made from.
const DIGEST: &str = "fmu_digest";

/// Shortest time that a process is given for an answer, s.
const SHORTEST_ANSWER: f64 = 1e-3;

/// By how much forces are changed where an FMU is probed, of their magnitude: little enough that the same contacts push.
const FORCE_CHANGE: f64 = 1e-3;
/// Likewise positions and velocities: a force that follows a stiff element answers to micrometres.
const MOTION_CHANGE: f64 = 1e-6;
/// Where no micro step is given, the share of the macro step by which an FMU is probed.
const PROBED_SHARE: f64 = 0.1;

/// Why there are no rates of an FMU's outputs.
const NO_RATES: &str = "its FMU has no directional derivatives of them, and cannot be probed for them, which takes states to be kept \
                        and set, and steps of any length";
/// Why there is no interface model.
const NO_MODEL: &str = "its FMU has none, no directional derivatives of how its velocities move, and cannot be probed for them, which \
                        takes states to be kept and set, and steps of any length";

/// Most rows of an interface model, whose square must have room.
const MOST_ROWS: usize = 4096;

/// One FMU with what the case makes of it.
struct FmuMember {
    unpacked: Unpacked,
    plan: Plan,
    ports: Ports,
    offers: Offers,
    /// The size of its interface model.
    model: Option<ModelSize>,
    /// Parameters of the case with the variables that take them.
    parameters: Vec<(String, Scaled)>,
}

impl FmuMember {
    /// Makes the side for a run; `step` (s) is one for which it may be asked for its interface model.
    fn side(&self, parameters: &Parameters, process: &Process, step: f64) -> Result<Box<dyn Subsystem>, String> {
        let side = ImportedSide::new(self.host(parameters, process)?, self.ports.clone(), self.offers.clone());
        let side = side.of_file(&self.unpacked.file);
        Ok(Box::new(match self.model {
            Some(size) => side.with_model(step, size)?,
            None if self.offers.smooth => side.with_smooth_model(self.ports.inputs.len()),
            None => side,
        }))
    }

    /// Starts what drives it.
    fn host(&self, parameters: &Parameters, process: &Process) -> Result<Box<dyn Host>, String> {
        let mut plan = self.plan.clone();
        for (name, variable) in &self.parameters {
            let number = parameters.setting(name).ok_or_else(|| format!("parameter {name} is not one of the case"))?;
            plan.starts.push(Start::Number(variable.reference, variable.inwards(number)));
        }
        match process {
            Process::Same => Ok(Box::new(Loaded::new(plan)?)),
            Process::Own { program, answer_within } => Ok(Box::new(Remote::start(&plan, program, *answer_within)?)),
        }
    }
}

/// Where FMUs run.
enum Process {
    Same,
    Own { program: PathBuf, answer_within: Duration },
}

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
        fmu_member(&file, &folder.join(&file.side(side).fmu), side, &rows).map_err(|error| match error {
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
    fn end(&self, side: Side, which: usize) -> (&str, Option<f64>) {
        let ends = if side == Side::Mechanics { &self.mechanics } else { &self.actuator };
        match [&ends.position, &ends.velocity, &ends.force][which] {
            End::Plain(variable) => (variable, None),
            End::Scaled { variable, factor } => (variable, Some(*factor)),
        }
    }
}

/// What a side of an interface with so many rows puts out and takes, as pairs of row and variable: positions of all rows, then
/// velocities; forces go the other way.
fn given_and_taken(side: Side, rows: usize) -> [Vec<(usize, usize)>; 2] {
    let list = |which: &[usize]| which.iter().flat_map(|&which| (0..rows).map(move |row| (row, which))).collect();
    let (motion, force) = (list(&[0, 1]), list(&[2]));
    if side == Side::Mechanics { [motion, force] } else { [force, motion] }
}

/// Opens the FMU of a side and finds all that the case file names in it.
fn fmu_member(file: &CaseFile, fmu: &Path, side: Side, rows: &[[String; 3]]) -> Result<FmuMember> {
    let table = file.side(side);
    let unpacked = Unpacked::open(fmu)?;
    if unpacked.description.only_once && file.process == ProcessKind::Same {
        return Err(Error::file(
            fmu,
            "may be in a process only once (canBeInstantiatedOnlyOncePerProcess), and a case is built more often: valid: process = \"own\"",
        ));
    }
    let finder = Finder { unpacked: &unpacked };
    let [given, taken] = given_and_taken(side, rows.len());
    let coupled = |list: &[(usize, usize)], causality: &str| -> Result<Vec<(Port, Scaled)>> {
        let one = |&(row, which): &(usize, usize)| {
            let (quantity, exponents, unit) = UNITS[which];
            let (name, factor) = file.interface[row].end(side, which);
            let variable = finder.coupling(name, causality, side, exponents, unit)?;
            if variable.is_in_unknown_unit() && factor.is_none() {
                return Err(finder.wrong(format!(
                    "variable `{name}` is in `{}`, which the FMU does not define by SI base units; valid: a unit that it defines, or a \
                     factor to {unit}, {{ variable = \"{name}\", factor = … }}",
                    variable.unit
                )));
            }
            let factor = factor.unwrap_or(1.0);
            if !(factor.is_finite() && factor != 0.0) {
                return Err(finder.wrong(format!(
                    "variable `{name}`: factor = {factor} is not valid; valid: a finite number but 0"
                )));
            }
            let scaled = Scaled {
                reference: variable.reference,
                factor: factor * variable.factor,
                offset: factor * variable.offset,
            };
            Ok((Port::new(rows[row][which].clone(), quantity), scaled))
        };
        list.iter().map(one).collect()
    };
    let outputs = coupled(&given, "output")?;
    let inputs = coupled(&taken, "input")?;
    let description = &unpacked.description;
    let depends = || {
        let depends = |output: &Scaled, input: &Scaled| description.depends(output.reference, input.reference);
        let said = outputs.iter().all(|(_, output)| description.dependencies.contains_key(&output.reference));
        // Where nothing is said: positions and velocities are states, forces may follow them at once.
        if !said && side == Side::Mechanics {
            return false;
        }
        outputs.iter().any(|(_, output)| inputs.iter().any(|(_, input)| depends(output, input)))
    };
    let ports = Ports {
        inputs: inputs.iter().map(|(port, _)| port.clone()).collect(),
        outputs: outputs.iter().map(|(port, _)| port.clone()).collect(),
        direct_feedthrough: table.direct_feedthrough.unwrap_or_else(depends),
    };
    let starts = table.start.iter().map(|(name, value)| finder.start(side, name, value)).collect::<Result<_>>()?;
    let mut parameters: Vec<(String, Scaled)> = Vec::new();
    for (name, parameter) in &file.parameters {
        let to = if side == Side::Mechanics { &parameter.mechanics } else { &parameter.actuator };
        if parameter.mechanics.is_none() && parameter.actuator.is_none() {
            return Err(Error::Incompatible(format!(
                "[parameters.{name}] names no variable: mechanics = \"…\" or actuator = \"…\""
            )));
        }
        if let Some(to) = to {
            let variable = finder.settable(to)?;
            if variable.kind != Type::Number {
                return Err(finder.wrong(format!("variable `{to}` is no Float64: parameters of a case are numbers")));
            }
            let units = [&*parameter.unit, &*variable.unit].map(|unit| if unit == "-" { "" } else { unit });
            if units.iter().all(|unit| !unit.is_empty()) && units[0] != units[1] {
                return Err(finder.wrong(format!(
                    "variable `{to}` is in `{}`, and [parameters.{name}] says unit = {:?}; valid: the same, or none, for its values \
                     go to the FMU as they are",
                    variable.unit, parameter.unit
                )));
            }
            if table.start.contains_key(to) {
                return Err(Error::Incompatible(format!(
                    "variable `{to}` is set twice: in start of [{}] and by [parameters.{name}]",
                    side_name(side)
                )));
            }
            if let Some((other, _)) = parameters.iter().find(|(_, scaled)| scaled.reference == variable.reference) {
                return Err(Error::Incompatible(format!(
                    "variable `{to}` of [{}] is set twice: by [parameters.{other}] and [parameters.{name}]",
                    side_name(side)
                )));
            }
            parameters.push((name.clone(), Scaled { reference: variable.reference, factor: 1.0, offset: 0.0 }));
        }
    }
    let observed: Vec<Scaled> = table.observe.iter().map(|name| finder.readable(name)).collect::<Result<_>>()?;
    let work = table.interface_work.as_ref().map(|name| finder.work(name)).transpose()?;
    let rate_of = |(_, output): &(Port, Scaled)| -> Option<Scaled> {
        let rate = description.variables.iter().find(|variable| variable.derivative == Some(output.reference))?;
        // What the case file says of the output holds of its rate; the unit is the rate's own, where it has one.
        let of = description.variables.iter().find(|variable| variable.reference == output.reference)?;
        if rate.is_in_unknown_unit() {
            return None;
        }
        let units = if rate.exponents.is_some() { rate.factor / of.factor } else { 1.0 };
        Some(Scaled { reference: rate.reference, factor: output.factor * units, offset: 0.0 })
    };
    let rates: Option<Vec<Scaled>> =
        outputs.iter().map(rate_of).collect::<Option<_>>().filter(|_| description.derivatives);
    let plain = inputs.iter().chain(&outputs).all(|(_, scaled)| scaled.factor == 1.0);
    let model = if side == Side::Mechanics && plain && unpacked.layered { finder.model(rows.len())? } else { None };
    let mechanics = side == Side::Mechanics;
    let probe =
        (rates.is_none() && model.is_none() && description.keeps_state && description.any_step).then(|| Probe {
            step: table.probe_step_s.or(file.micro_step_s).unwrap_or(PROBED_SHARE * file.macro_step_s),
            change: if mechanics { FORCE_CHANGE } else { MOTION_CHANGE },
            feedthrough: ports.direct_feedthrough,
        });
    let moves = rates.is_some() || probe.is_some();
    // Velocities that jump with a force have no accelerations.
    let smooth = mechanics && model.is_none() && moves && !ports.direct_feedthrough;
    let offers = Offers {
        rates: !mechanics && moves,
        probed: probe.is_some(),
        smooth,
        without: match (mechanics, moves) {
            (false, false) => Some(NO_RATES),
            (true, _) if !smooth => Some(NO_MODEL),
            _ => None,
        },
        copies: description.keeps_state,
        work: work.is_some(),
        observables: table.observe.iter().cloned().map(Name::from).collect(),
    };
    let model_size = model.as_ref().map(|(_, size)| *size);
    let plan = Plan {
        file: unpacked.file.clone(),
        library: unpacked.library.clone(),
        needs: table.needs.clone(),
        resources: unpacked.folder.path().join("resources"),
        version_2: description.is_version_2(),
        token: description.token.clone(),
        starts,
        inputs: inputs.into_iter().map(|(_, scaled)| scaled).collect(),
        outputs: outputs.into_iter().map(|(_, scaled)| scaled).collect(),
        rates,
        derivatives: description.derivatives,
        smooth,
        probe,
        keeps_state: description.keeps_state,
        step: description.variable("rim.step").filter(|_| unpacked.layered).map(|variable| variable.reference),
        model: model.map(|(model, _)| model),
        observed,
        work,
    };
    Ok(FmuMember { plan, ports, offers, model: model_size, parameters, unpacked })
}

/// Looks variables up in an FMU.
struct Finder<'a> {
    unpacked: &'a Unpacked,
}

impl Finder<'_> {
    fn wrong(&self, message: String) -> Error {
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
    fn coupling(
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
    fn settable(&self, name: &str) -> Result<&FmuVariable> {
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
    fn start(&self, side: Side, name: &str, value: &toml::Value) -> Result<Start> {
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
    fn readable(&self, name: &str) -> Result<Scaled> {
        let variable = self.variable(name, "output")?;
        if variable.kind != Type::Number || !variable.dimensions.is_empty() {
            return Err(self.wrong(format!("variable `{name}` is not one number of type Float64 (Real)")));
        }
        Ok(Scaled { reference: variable.reference, factor: variable.factor, offset: variable.offset })
    }

    /// An account of work, in J.
    fn work(&self, name: &str) -> Result<Scaled> {
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
    fn model(&self, rows: usize) -> Result<Option<(ModelVariables, ModelSize)>> {
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
            numbers.push(number("rim.own_approach", &[contacts])?);
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
