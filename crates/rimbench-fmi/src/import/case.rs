//! The case that a case file and its FMUs make.

use super::case_file::{
    CaseFile, ParameterTable, ProcessKind, SHORTEST_ANSWER, ScaleTable, check_parameter, columns, parameters,
};
use super::member::{FmuMember, Process};
use super::probing::SideNotes;
use super::python::PythonMember;
use super::side::ImportedSide;
use crate::export::side_name;
use crate::last_words::tell_once;
use rimbench_cases::cases::{
    Case, CaseDefaults, CoupledSystem, Doubts, InterfaceColumns, Parameters, PossibleSteps, Scale, WHAT_REMAINS,
    doubts_of, first_outputs,
};
use rimbench_core::cosim::{PerSide, Ports, Side, check_coupling};
use rimbench_core::error::{Error, Failure, Result};
use rimbench_core::name::{Name, check_new_name};
use rimbench_results::checksums::hex;
use rimbench_results::input::read_text;
use rimbench_results::text_place::said_at;
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// What sides from outside are started with.
#[derive(Debug, Clone, Default)]
pub struct Programs {
    /// The command that makes a process for an FMU, rimbench with [`WORKER`](super::WORKER); without it FMUs all run in this process.
    pub worker: Option<Vec<PathBuf>>,
    /// The interpreter of Python; `python3` if none is named.
    pub python: Option<PathBuf>,
    /// Takes what is to be said of them after a run.
    pub notes: SideNotes,
}

/// How a side begins a run.
struct Started {
    process: Process,
    notes: SideNotes,
}

/// One side.
enum Member {
    Fmu(Box<FmuMember>),
    Python(Box<PythonMember>),
}

impl Member {
    fn ports(&self) -> &Ports {
        match self {
            Member::Fmu(fmu) => &fmu.ports,
            Member::Python(python) => &python.ports,
        }
    }

    fn observables(&self) -> &[Name] {
        match self {
            Member::Fmu(fmu) => &fmu.offers.observables,
            Member::Python(python) => &python.offers.observables,
        }
    }

    fn file(&self) -> &Path {
        match self {
            Member::Fmu(fmu) => &fmu.unpacked.file,
            Member::Python(python) => &python.file,
        }
    }

    fn digest(&self) -> &str {
        match self {
            Member::Fmu(fmu) => &fmu.unpacked.digest,
            Member::Python(python) => &python.digest,
        }
    }

    /// Whether it takes steps of any length, and its own, s.
    fn steps(&self) -> (bool, Option<f64>) {
        match self {
            Member::Fmu(fmu) => (fmu.unpacked.description.any_step, fmu.unpacked.description.internal_step),
            Member::Python(_) => (true, None),
        }
    }

    fn side(&self, parameters: &Parameters, Started { process, notes }: &Started) -> Result<ImportedSide> {
        let made = match self {
            Member::Fmu(fmu) => fmu.side(parameters, process, notes),
            Member::Python(python) => python.side(parameters, notes),
        };
        made.map_err(Error::Incompatible)
    }

    /// Gives a side that has begun its interface model, which is asked for once, for a step (s).
    fn give_model(&self, side: &mut ImportedSide, step: f64) -> Result<(), String> {
        let (size, smooth) = match self {
            Member::Fmu(fmu) => (fmu.model(), fmu.offers.smooth),
            Member::Python(python) => (python.model, false),
        };
        match size {
            Some(size) => side.give_model(step, size),
            None if smooth => {
                side.give_smooth_model(self.ports().inputs.len());
                Ok(())
            }
            None => Ok(()),
        }
    }

    fn doubt(&mut self, state: Option<String>, model: Option<String>) {
        match self {
            Member::Fmu(fmu) => fmu.doubt(state, model),
            Member::Python(python) => python.doubt(state, model),
        }
    }
}

/// Reads a case file with its sides, and tries both once by a few steps.
///
/// # Errors
/// [`Error::File`] naming the case file or the FMU, what is wrong with it, and what would be valid.
pub fn read_case(path: &Path, programs: Programs) -> Result<Case> {
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
    let scale =
        file.scale.map(|ScaleTable { position_m, velocity_m_s, force_n }| Scale { position_m, velocity_m_s, force_n });
    for (key, value) in scale
        .iter()
        .flat_map(|of| [("position_m", of.position_m), ("velocity_m_s", of.velocity_m_s), ("force_n", of.force_n)])
    {
        if !(value.is_finite() && value > 0.0) {
            return Err(wrong(Error::invalid(format!("{key} of scale"), value, "a finite number above 0").to_string()));
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
    let usual = |digest: &str| {
        let parameters = parameters(&file, digest.to_owned());
        Parameters::defaults(file.name.clone().into(), &parameters).lasting(file.duration_s)
    };
    let python = programs.python.clone().unwrap_or_else(|| "python3".into());
    let member = |side: Side| {
        let table = file.side(side);
        let opened = match (&table.fmu, &table.python, &table.class) {
            (Some(fmu), None, None) => {
                FmuMember::open(&file, &folder.join(fmu), side, &rows).map(|fmu| Member::Fmu(Box::new(fmu)))
            }
            (None, Some(script), Some(class)) => {
                let side = PythonMember::open(&file, (&folder.join(script), class), side, &rows, &python, &usual(""));
                side.map(|python| Member::Python(Box::new(python)))
            }
            _ => {
                let valid = "fmu = \"….fmu\", or python = \"….py\" and class = \"…\"";
                return Err(wrong(format!("[{}] is no side; valid: {valid}", side_name(side))));
            }
        };
        opened.map_err(|error| match error {
            Error::File { .. } => error,
            other => wrong(other.to_string()),
        })
    };
    let of_python = Side::BOTH.into_iter().any(|side| file.side(side).python.is_some());
    let unused = |table: &&ParameterTable| table.mechanics.is_none() && table.actuator.is_none();
    if let Some((name, _)) = file.parameters.iter().find(|(_, table)| !of_python && unused(table)) {
        return Err(wrong(format!("[parameters.{name}] names no variable: mechanics = \"…\" or actuator = \"…\"")));
    }
    let mut members = PerSide { mechanics: member(Side::Mechanics)?, actuator: member(Side::Actuator)? };
    check_coupling(members.as_ref().map(Member::ports)).map_err(|error| {
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
        trace.extend(members[side].observables().iter().cloned());
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
    Side::BOTH.into_iter().for_each(|side| hash.update(members[side].digest()));
    let digest = hex(&hash.finalize()[..8]);
    let own = match (file.process, programs.worker) {
        (ProcessKind::Own, Some(worker)) => Process::Own {
            worker,
            // What is longer is for ever.
            answer_within: Duration::from_secs_f64(patience.min(1e9)),
        },
        _ => Process::Same,
    };
    let started = Started { process: own, notes: programs.notes };
    let steps = members.as_ref().map(|member| {
        let (any, own) = member.steps();
        // Of one that takes steps of any length its own step is a wish.
        PossibleSteps { equal: !any, multiple_of: own.filter(|_| !any) }
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
    note_odd_steps(&members, &defaults);
    let usual = usual(&digest);
    let parameters = parameters(&file, digest);
    let tried =
        if Side::BOTH.into_iter().all(|side| steps[side].allows(micro_step_s)) { micro_step_s } else { macro_step_s };
    let doubts = try_out(&members, &usual, &started, [macro_step_s, tried])?;
    if let Some(words) = doubts.reversed {
        return Err(Error::file(
            members.mechanics.file(),
            format!("{words}; valid: force = {{ variable = \"…\", factor = -1 }}"),
        ));
    }
    for note in doubts.notes {
        tell_once(&format!("note: {}: {note}\n", path.display()));
    }
    let PerSide { mechanics, actuator } = doubts.state;
    members.mechanics.doubt(mechanics, doubts.model);
    members.actuator.doubt(actuator, None);
    let members = Arc::new(members);
    let build = move |parameters: &Parameters, _: &_| -> Result<CoupledSystem> {
        let mut sides = begun(&members, parameters, &started)?;
        for side in Side::BOTH {
            members[side].give_model(&mut sides[side], macro_step_s).map_err(Error::Incompatible)?;
        }
        Ok(CoupledSystem::new(sides.mechanics, sides.actuator))
    };
    let about = if file.about.is_empty() { format!("FMUs of {}", path.display()) } else { file.about.clone() };
    let case = Case {
        trace_columns: trace,
        interface_columns,
        steps,
        scale,
        waits: true,
        ..Case::with_parameters(file.name.clone(), about, defaults, parameters, build)
    };
    Ok(case)
}

/// Most rounds in which both sides tell each other with what they begin.
const ROUNDS: usize = 10;

/// Makes both sides and lets them begin.
///
/// Both are in initialisation mode first. The mechanics says where it is, the actuator takes that and answers with its force, which the
/// mechanics takes, and so on until no force changes any more, or [`ROUNDS`] times. Then the mechanics leaves initialisation mode with
/// that force, and the actuator with where the mechanics is by then.
fn begun(members: &PerSide<Member>, parameters: &Parameters, started: &Started) -> Result<PerSide<ImportedSide>> {
    let mut mechanics = members.mechanics.side(parameters, started)?;
    let mut actuator = members.actuator.side(parameters, started)?;
    let zeros = |member: &Member| vec![0.0; member.ports().outputs.len()];
    let (mut force, mut motion) = (zeros(&members.actuator), zeros(&members.mechanics));
    let mut told = force.clone();
    let mut begin = || -> Result<(), Failure> {
        for _ in 0..ROUNDS {
            mechanics.initial_outputs(&force, &mut motion)?;
            actuator.initial_outputs(&motion, &mut told)?;
            if told == force {
                break;
            }
            force.copy_from_slice(&told);
        }
        mechanics.begin(&force)?;
        mechanics.initial_outputs(&force, &mut motion)?;
        actuator.begin(&motion)
    };
    begin().map_err(|failure| Error::Incompatible(failure.to_string()))?;
    Ok(PerSide { mechanics, actuator })
}

/// Tries both sides by steps of `h` (s); in one process a second time beside them, for sides that share what they are made of.
fn try_out(
    members: &PerSide<Member>,
    parameters: &Parameters,
    started: &Started,
    [macro_step, h]: [f64; 2],
) -> Result<Doubts> {
    let boxed = || -> Result<(CoupledSystem, Option<String>)> {
        let mut sides = begun(members, parameters, started)?;
        let given = members.mechanics.give_model(&mut sides.mechanics, macro_step);
        Ok((CoupledSystem::new(sides.mechanics, sides.actuator), given.err()))
    };
    let (mut system, refused) = boxed()?;
    let mut doubts = doubts_of(system.sides.lend(), h);
    if let Some(words) = refused {
        doubts.model = Some(format!("{words}; {WHAT_REMAINS}"));
    }
    if matches!(started.process, Process::Same) && !doubts.first_outputs.is_empty() {
        let (mut twin, _) = boxed()?;
        let again = first_outputs(twin.sides.lend(), system.sides.lend(), h);
        let differ = |side: Side| {
            let all = |list: &[PerSide<Vec<f64>>]| {
                list.iter().flat_map(|y| &y[side]).map(|y| y.to_bits()).collect::<Vec<_>>()
            };
            all(&again) != all(&doubts.first_outputs)
        };
        if let Some(side) = Side::BOTH.into_iter().find(|side| differ(*side)) {
            return Err(Error::file(
                members[side].file(),
                "does not put out the same a second time in this process: instances share what they are made of, or leave something to \
                 chance; valid: process = \"own\"",
            ));
        }
    }
    Ok(doubts)
}

/// Notes steps of a case that are no multiples of what an FMU says is its own.
fn note_odd_steps(members: &PerSide<Member>, times: &CaseDefaults) {
    for member in [&members.mechanics, &members.actuator] {
        let Some(own) = member.steps().1 else { continue };
        let steps = PossibleSteps { equal: false, multiple_of: Some(own) };
        let odd = [
            ("macro_step_s", times.macro_step_s),
            ("micro_step_s", times.micro_step_s),
            // The finest of the three solutions takes a quarter of the step.
            ("a quarter of reference_step_s", 0.25 * times.reference_step_s),
        ];
        let odd: Vec<&str> = odd.iter().filter(|(_, step)| !steps.allows(*step)).map(|(name, _)| *name).collect();
        if !odd.is_empty() {
            let file = member.file().display();
            tell_once(&format!(
                "note: {file} would rather take multiples of its own step of {own:e} s (fixedInternalStepSize): {} are none\n",
                odd.join(", ")
            ));
        }
    }
}

/// Whether a name stands in a table of comma-separated values as it is.
fn can_name_a_column(name: &str) -> bool {
    !name.trim().is_empty() && !name.contains([',', '"']) && !name.contains(char::is_control)
}
