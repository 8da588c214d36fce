//! The case that a case file and its FMUs make.

use super::case_file::{CaseFile, ProcessKind, ScaleTable, columns, parameters};
use super::group::Actuators;
use super::member::{FmuMember, Process};
use super::probing::SideNotes;
use super::python::PythonMember;
use super::side::ImportedSide;
use crate::export::side_name;
use crate::last_words::tell_once;
use rimbench_cases::cases::{
    Beginning, Case, CaseDefaults, CoupledSystem, Doubts, Fault, InterfaceColumns, NoBeginning, PossibleSteps, Remedy,
    Scale, Tried, WHAT_REMAINS, apart_in_words, beginning, doubts_of, first_outputs,
};
use rimbench_cases::parameter::Parameters;
use rimbench_core::cosim::{PerSide, Port, Ports, Quantity, Side, check_coupling, division};
use rimbench_core::error::{Error, Failure, Result};
use rimbench_core::name::Name;
use rimbench_results::checksums::hex;
use rimbench_results::input::{beside, path_hint, read_text};
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// What sides from outside are started with.
#[derive(Debug, Clone, Default)]
pub struct Programs {
    /// The command that makes a process for an FMU, rimbench with [`WORKER`](super::WORKER); without it FMUs all run in
    /// this process.
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
    /// Magnitude of forces, N, where the case declares one.
    force_scale: Option<f64>,
    /// What the sides call position, the force that is taken and the one that is told, of each row.
    rows: Vec<[String; 3]>,
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
            Member::Fmu(fmu) => &fmu.digest,
            Member::Python(python) => &python.digest,
        }
    }

    /// Whether it says itself that its outputs follow its inputs at once.
    fn declares_feedthrough(&self) -> bool {
        match self {
            Member::Fmu(fmu) => fmu.declares_feedthrough,
            Member::Python(python) => python.ports.direct_feedthrough,
        }
    }

    /// Its own step, s.
    fn own_step(&self) -> Option<f64> {
        match self {
            Member::Fmu(fmu) => fmu.unpacked.description.internal_step,
            Member::Python(_) => None,
        }
    }

    /// The steps that it takes.
    fn steps(&self) -> PossibleSteps {
        let any = !matches!(self, Member::Fmu(fmu) if !fmu.unpacked.description.any_step);
        // An FMU that takes steps of any length only recommends its own step.
        PossibleSteps { equal: !any, multiple_of: self.own_step().filter(|_| !any) }
    }

    fn side(&self, parameters: &Parameters, Started { process, notes, .. }: &Started) -> Result<ImportedSide> {
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

/// The mechanics, and one actuator or several with their rows.
struct Members {
    mechanics: Member,
    actuators: Vec<(Vec<usize>, Member)>,
    ports: PerSide<Ports>,
}

impl Members {
    /// Those of a side.
    fn of(&self, side: Side) -> impl Iterator<Item = &Member> {
        let (mechanics, actuators) = match side {
            Side::Mechanics => (Some(&self.mechanics), &[][..]),
            Side::Actuator => (None, &self.actuators[..]),
        };
        mechanics.into_iter().chain(actuators.iter().map(|(_, member)| member))
    }

    /// The one of a side that something is said of: it is named, it has the row, or it is the only one.
    fn meant(&self, side: Side, said: &str, row: Option<usize>) -> &Member {
        let named = self.of(side).find(|member| said.starts_with(&member.file().display().to_string()));
        let of_row = self.actuators.iter().find(|(rows, _)| row.is_some_and(|row| rows.contains(&row)));
        let of_row = of_row.map(|(_, member)| member);
        match side {
            Side::Mechanics => &self.mechanics,
            Side::Actuator => named.or(of_row).unwrap_or(&self.actuators[0].1),
        }
    }

    /// The steps of one length for which a side is made, where there are such.
    fn steps(&self, file: &CaseFile) -> PerSide<PossibleSteps> {
        // One with a step of its own is held against that when it is opened.
        let shares = |at: &usize| file.actuators[*at].micro_step_s.is_none();
        let actuators = (0..self.actuators.len()).filter(shares).map(|at| self.actuators[at].1.steps());
        let joint = actuators.reduce(|a, b| PossibleSteps {
            equal: a.equal || b.equal,
            multiple_of: match (a.multiple_of, b.multiple_of) {
                (Some(a), Some(b)) => Some(a.max(b)),
                (a, b) => a.or(b),
            },
        });
        PerSide { mechanics: self.mechanics.steps(), actuator: joint.unwrap_or_default() }
    }

    fn sides(&self, parameters: &Parameters, started: &Started) -> Result<Sides> {
        let mechanics = self.mechanics.side(parameters, started)?;
        let actuators =
            self.actuators.iter().map(|(rows, member)| Ok((rows.clone(), member.side(parameters, started)?)));
        let actuators: Vec<_> = actuators.collect::<Result<_>>()?;
        Ok(Sides { mechanics, actuator: Actuators::new(actuators.into_iter(), &self.ports.actuator) })
    }
}

/// Reads a case file with its sides, and tries both once by a few steps.
///
/// # Errors
/// [`Error::File`] naming the case file or the FMU, what is wrong with it, and what would be valid.
pub fn read_case(path: &Path, programs: Programs) -> Result<Case> {
    let wrong = |message: String| Error::file(path, message);
    check_is_case_file(path)?;
    let text = read_text(path)?;
    let file = CaseFile::parse(&text).map_err(wrong)?;
    let rows = columns(&file.interface);
    let mut members = open_members(path, &file, &rows, programs.python.as_deref())?;
    check_coupling(members.ports.as_ref()).map_err(|error| {
        wrong(format!(
            "{error}; `direct_feedthrough = false` says of a side that its outputs do not depend on its inputs at once"
        ))
    })?;
    let trace_columns = trace_columns(&rows, &members).map_err(wrong)?;
    let mut hash = Sha256::new();
    hash.update(&text);
    Side::BOTH.into_iter().flat_map(|side| members.of(side)).for_each(|member| hash.update(member.digest()));
    let digest = hex(&hash.finalize()[..8]);
    let process = match (file.process, programs.worker) {
        (ProcessKind::Own, Some(worker)) => Process::Own {
            worker,
            // `Duration` has an upper bound.
            answer_within: Duration::from_secs_f64(file.answer_within_s.min(1e9)),
        },
        _ => Process::Same,
    };
    let started = Started {
        process,
        notes: programs.notes,
        force_scale: file.scale.map(|scale| scale.force_n),
        rows: called(&file, &rows),
    };
    let steps = members.steps(&file);
    check_own_steps(&file, &members).map_err(wrong)?;
    let defaults = steps_of_case(&file, &steps).map_err(wrong)?;
    note_odd_steps(&members, &defaults);
    let parameters = parameters(&file, digest);
    let macro_step_s = file.macro_step_s;
    let is_allowed = |side: Side| steps[side].allows(defaults.micro_step_s);
    let tried = if Side::BOTH.into_iter().all(is_allowed) { defaults.micro_step_s } else { macro_step_s };
    let usual = Parameters::defaults(file.name.clone().into(), &parameters).lasting(file.duration_s);
    let doubts = try_out(&members, &usual, &started, [macro_step_s, tried])?;
    if let Some((side, failure)) = doubts.failed {
        let said = failure.to_string();
        let path = members.meant(side, &said, None).file();
        return Err(Error::file(path, format!("fails in its first steps: {}", without_file(&said, path))));
    }
    for side in Side::BOTH {
        if let Some(fault) = &doubts.faults[side] {
            let row = fault.remedy.as_ref().map(|remedy| remedy.row);
            let member = members.meant(side, &fault.words, row);
            return Err(Error::file(member.file(), in_words(fault, &file, side, member)));
        }
    }
    for note in doubts.notes {
        tell_once(&format!("note: {}: {note}\n", path.display()));
    }
    let PerSide { mechanics, actuator } = doubts.state;
    members.mechanics.doubt(mechanics, doubts.model);
    members.actuators.iter_mut().for_each(|(_, member)| member.doubt(actuator.clone(), None));
    let members = Arc::new(members);
    let build = move |parameters: &Parameters, _: &_| -> Result<CoupledSystem> {
        let (mut sides, at) = begun(&members, parameters, &started)?;
        members.mechanics.give_model(&mut sides.mechanics, macro_step_s).map_err(Error::Incompatible)?;
        let mut system = CoupledSystem::new(sides.mechanics, sides.actuator).begun(at);
        // As where both are classes in one process.
        system.bounded_by_motion = members.of(Side::Actuator).all(|member| matches!(member, Member::Python(_)));
        Ok(system)
    };
    let about = if file.about.is_empty() { format!("FMUs of {}", path.display()) } else { file.about.clone() };
    let scale =
        file.scale.map(|ScaleTable { position_m, velocity_m_s, force_n }| Scale { position_m, velocity_m_s, force_n });
    let interface_columns =
        rows.into_iter().map(|[position, velocity, force]| InterfaceColumns::new(position, velocity, force));
    Ok(Case {
        trace_columns,
        interface_columns: interface_columns.collect(),
        steps,
        bonds: file.bonds(),
        scale,
        waits: true,
        ..Case::with_parameters(file.name.clone(), about, defaults, parameters, build)
    })
}

/// Refuses what else may be meant by a case of FMUs.
fn check_is_case_file(path: &Path) -> Result<()> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let kind = match ending.as_deref() {
        Some("fmu") => "an FMU",
        Some("ssp") => "an archive of SSP (System Structure and Parameterization)",
        Some("ssd") => "a system of SSP (System Structure and Parameterization)",
        Some("py") => "a file of Python",
        _ => return Ok(()),
    };
    Err(Error::file(
        path,
        format!(
            "is {kind} and no case file; valid: a file (.toml) that names two FMUs, or classes of Python, and what is coupled \
             (docs/guide/fmi.md)"
        ),
    ))
}

/// Where a file is that the case file names, which must be there.
fn named(path: &Path, file: &Path, side: &str) -> Result<PathBuf> {
    let found = beside(path, file);
    if found.exists() {
        return Ok(found);
    }
    let folder = found.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = std::path::absolute(folder).unwrap_or_default();
    let message = format!(
        "cannot be read: it is not in {}, where {side} of {} names it{}",
        folder.display(),
        path.display(),
        path_hint(file)
    );
    Err(Error::file(found, message))
}

/// What a side says, without the file before it, which is named anyway.
fn without_file<'a>(said: &'a str, file: &Path) -> &'a str {
    said.strip_prefix(&format!("{}: ", file.display())).unwrap_or(said)
}

/// A fault of a side, with what sets it right, where that is known.
fn in_words(Fault { words, remedy }: &Fault, file: &CaseFile, side: Side, member: &Member) -> String {
    let Some(Remedy { row, quantity, factor }) = remedy else { return words.clone() };
    let which = match quantity {
        Quantity::Position => 0,
        Quantity::Velocity => 1,
        Quantity::Force | Quantity::Pressure => 2,
    };
    let name = ["position", "velocity", "force"][which];
    match (member, file.interface[*row].end(side, which)) {
        (Member::Fmu(_), Some((variable, own))) => {
            let now = own.map_or_else(String::new, |own| format!(" (it has factor = {own})"));
            match own.unwrap_or(1.0) * factor {
                1.0 => format!("{words}{now}; valid: {name} = {variable:?}"),
                factor => format!("{words}{now}; valid: {name} = {{ variable = {variable:?}, factor = {factor} }}"),
            }
        }
        _ => format!("{words}; valid: the {name} times {factor} in what the class takes or puts out"),
    }
}

/// What the sides call position, the force that the mechanics takes and the one that the actuator tells, of each row.
fn called(file: &CaseFile, rows: &[[String; 3]]) -> Vec<[String; 3]> {
    let name = |at: usize, side: Side, which: usize| {
        let own = file.interface[at].end(side, which).map(|(variable, _)| format!("`{variable}`"));
        own.unwrap_or_else(|| rows[at][which].clone())
    };
    let ends = [(Side::Mechanics, 0), (Side::Mechanics, 2), (Side::Actuator, 2)];
    (0..rows.len()).map(|at| ends.map(|(side, which)| name(at, side, which))).collect()
}

/// Opens what the file names as its two sides.
fn open_members(path: &Path, file: &CaseFile, rows: &[[String; 3]], python: Option<&Path>) -> Result<Members> {
    let wrong = |message: String| Error::file(path, message);
    let open = |file: &CaseFile, side: Side, called: &str, rows: &[[String; 3]]| {
        let table = file.side(side);
        let opened = match (&table.fmu, &table.python, &table.class) {
            (Some(fmu), None, None) => named(path, fmu, called)
                .and_then(|fmu| FmuMember::open((path, file), &fmu, side, rows))
                .map(|fmu| Member::Fmu(Box::new(fmu))),
            (None, Some(script), Some(class)) => {
                let usual = Parameters::defaults(file.name.clone().into(), &parameters(file, String::new()));
                let (python, usual) = (python.unwrap_or(Path::new("python3")), usual.lasting(file.duration_s));
                named(path, script, called)
                    .and_then(|script| PythonMember::open(file, (&script, class), side, rows, python, &usual))
                    .map(|python| Member::Python(Box::new(python)))
            }
            _ => {
                let valid = "fmu = \"….fmu\", or python = \"….py\" and class = \"…\"";
                return Err(wrong(format!("{called} is no side; valid: {valid}")));
            }
        };
        opened.map_err(|error| match error {
            Error::File { .. } => error,
            other => wrong(other.to_string()),
        })
    };
    let mechanics = open(file, Side::Mechanics, "[mechanics]", rows)?;
    let actuators = (0..file.actuators.len()).map(|at| {
        let own = file.rows_of(at);
        let names: Vec<[String; 3]> = own.iter().map(|row| rows[*row].clone()).collect();
        Ok((own, open(&file.part(at), Side::Actuator, &file.named(at), &names)?))
    });
    let actuators: Vec<(Vec<usize>, Member)> = actuators.collect::<Result<_>>()?;
    let list = |which: usize, quantity| rows.iter().map(move |row| Port::new(row[which].clone(), quantity));
    let actuator = Ports {
        inputs: list(0, Quantity::Position).chain(list(1, Quantity::Velocity)).collect(),
        outputs: list(2, Quantity::Force).collect(),
        direct_feedthrough: actuators.iter().any(|(_, member)| member.ports().direct_feedthrough),
    };
    let ports = PerSide { mechanics: mechanics.ports().clone(), actuator };
    Ok(Members { mechanics, actuators, ports })
}

/// Refuses steps of actuators that these do not take.
fn check_own_steps(file: &CaseFile, members: &Members) -> Result<(), String> {
    for (at, (_, member)) in members.actuators.iter().enumerate() {
        let steps = member.steps();
        let Some((unit, step)) = steps.multiple_of.zip(file.actuators[at].micro_step_s.or(file.micro_step_s)) else {
            continue;
        };
        if file.actuators.len() > 1 && !steps.allows(step) {
            let key = format!("micro_step_s of {}", file.named(at));
            return Err(
                Error::invalid(key, step, format!("a multiple of {unit:e} s: its FMU takes no others")).to_string()
            );
        }
    }
    Ok(())
}

/// Names the columns of the trace: time, the rows of the interface, forces at the mechanics, what the sides let
/// observe.
fn trace_columns(rows: &[[String; 3]], members: &Members) -> Result<Vec<Name>, String> {
    let mut trace: Vec<Name> = vec!["time_s".into()];
    trace.extend(rows.iter().flatten().cloned().map(Name::from));
    trace.extend(["force_to_mechanics_n", "force_2_to_mechanics_n"].into_iter().take(rows.len()).map(Name::from));
    let all = Side::BOTH.into_iter().flat_map(|side| members.of(side));
    trace.extend(all.flat_map(|member| member.observables().iter().cloned()));
    if let Some(name) = trace.iter().find(|name| !can_name_a_column(name)) {
        let name = name.to_string();
        return Err(format!(
            "a column of the trace is named {name:?}; valid: a name without commas, quotes and line breaks"
        ));
    }
    let mut seen = BTreeSet::new();
    match trace.iter().find(|name| !seen.insert((*name).clone())) {
        Some(twice) => Err(format!("two columns of the trace are named `{twice}`")),
        None => Ok(trace),
    }
}

/// The times of the case, if the sides can take steps for its reference.
fn steps_of_case(file: &CaseFile, steps: &PerSide<PossibleSteps>) -> Result<CaseDefaults, String> {
    let micro_step_s = file.micro_step_s();
    let reference_step_s = file.reference_step_s.unwrap_or(0.5 * micro_step_s);
    for side in Side::BOTH {
        // The finest of the three solutions takes a quarter of the step, of which a whole number makes a micro step.
        let finest = 0.25 * micro_step_s / division(micro_step_s, reference_step_s) as f64;
        if let Some(unit) = steps[side].multiple_of.filter(|_| !steps[side].allows(finest)) {
            let (least, side) = (4.0 * unit, side_name(side));
            let valid = format!(
                "a multiple of {least:e} s that divides micro_step_s, {micro_step_s:e} s: the FMU of the {side} takes multiples of {unit:e} s"
            );
            return Err(Error::invalid("reference_step_s", reference_step_s, valid).to_string());
        }
    }
    let times = CaseDefaults {
        duration_s: file.duration_s,
        macro_step_s: file.macro_step_s,
        micro_step_s,
        reference_step_s,
        reference_sampling_s: micro_step_s,
    };
    times.grid(1.0).and_then(|_| times.check_reference()).map_err(|error| error.to_string())?;
    Ok(times)
}

/// Makes both sides and lets them begin where they agree ([`beginning`]).
///
/// Both are in initialisation mode first. The mechanics leaves it with the force that was found, and the actuator with
/// where the mechanics is by then. Where both no longer agree after that, because one comes to what it begins with as
/// its initialisation ends, the force is found by instances that begin, each with another force.
fn begun(members: &Members, parameters: &Parameters, started: &Started) -> Result<(Sides, Beginning)> {
    let made = || members.sides(parameters, started);
    let failed = |(side, failure): (Side, Failure)| {
        let said = failure.to_string();
        let file = members.meant(side, &said, None).file();
        Error::Incompatible(format!("{}: {}", file.display(), without_file(&said, file)))
    };
    let mut sides = made()?;
    let [forces, motions] = [Side::Actuator, Side::Mechanics].map(|side| members.ports[side].outputs.len());
    let scale = started.force_scale;
    let found =
        beginning(forces, motions, scale, |force, motion, told| sides.tell(force, motion, told).map_err(failed));
    let at = found.map_err(|none| apart(none, started))?;
    let mut last = at.clone();
    sides.begin(&mut last).map_err(failed)?;
    if last.agrees(scale) {
        return Ok((sides, at));
    }
    let found = beginning(forces, motions, scale, |force, motion, told| {
        sides = made()?;
        let mut next =
            Beginning { force: force.to_vec(), motion: motion.to_vec(), told: told.to_vec(), follows: false };
        sides.tell(force, &mut next.motion, &mut next.told).and_then(|()| sides.begin(&mut next)).map_err(failed)?;
        motion.copy_from_slice(&next.motion);
        told.copy_from_slice(&next.told);
        last = next;
        Ok(())
    });
    let at = found.map_err(|none| apart(none, started))?;
    if last.force != at.force {
        sides = made()?;
        last = at.clone();
        sides
            .tell(&at.force, &mut last.motion, &mut last.told)
            .and_then(|()| sides.begin(&mut last))
            .map_err(failed)?;
    }
    Ok((sides, at))
}

/// Why both sides do not begin, in the names that they have for what is exchanged.
fn apart(none: NoBeginning<Error>, started: &Started) -> Error {
    match none {
        NoBeginning::Failed(error) => error,
        NoBeginning::Apart(at, row, within) => {
            let names = started.rows[row].each_ref().map(|name| &**name);
            Error::Incompatible(apart_in_words(&at, row, within, names))
        }
    }
}

/// Both sides of a case that are made.
struct Sides {
    mechanics: ImportedSide,
    actuator: Actuators,
}

/// What both tell each other before a run.
trait Begin {
    fn tell(&mut self, force: &[f64], motion: &mut [f64], told: &mut [f64]) -> Result<(), (Side, Failure)>;
    fn begin(&mut self, at: &mut Beginning) -> Result<(), (Side, Failure)>;
}

impl Begin for Sides {
    /// Where the mechanics is under forces, and what the actuator answers.
    fn tell(&mut self, force: &[f64], motion: &mut [f64], told: &mut [f64]) -> Result<(), (Side, Failure)> {
        self.mechanics.initial_outputs(force, motion).map_err(|failure| (Side::Mechanics, failure))?;
        self.actuator.initial_outputs(motion, told).map_err(|failure| (Side::Actuator, failure))
    }

    /// Ends the initialisation of both, and asks once more.
    fn begin(&mut self, at: &mut Beginning) -> Result<(), (Side, Failure)> {
        self.mechanics.begin(&at.force).map_err(|failure| (Side::Mechanics, failure))?;
        self.mechanics.initial_outputs(&at.force, &mut at.motion).map_err(|failure| (Side::Mechanics, failure))?;
        self.actuator.begin(&at.motion).map_err(|failure| (Side::Actuator, failure))?;
        self.actuator.initial_outputs(&at.motion, &mut at.told).map_err(|failure| (Side::Actuator, failure))
    }
}

/// Tries both sides by steps of `h` (s); in one process a second time beside them, for sides that share what they are
/// made of.
fn try_out(members: &Members, parameters: &Parameters, started: &Started, [macro_step, h]: [f64; 2]) -> Result<Doubts> {
    let boxed = || -> Result<(CoupledSystem, Option<String>)> {
        let (mut sides, at) = begun(members, parameters, started)?;
        let given = members.mechanics.give_model(&mut sides.mechanics, macro_step);
        Ok((CoupledSystem::new(sides.mechanics, sides.actuator).begun(at), given.err()))
    };
    let (mut system, refused) = boxed()?;
    let any_step = PerSide::from_fn(|side| members.of(side).all(|member| !member.steps().are_fixed()));
    let is_probed = |member: &Member| matches!(member, Member::Fmu(fmu) if fmu.offers.probed);
    let probed = PerSide::from_fn(|side| members.of(side).any(is_probed));
    let declared = members.of(Side::Actuator).any(Member::declares_feedthrough);
    let mut doubts = doubts_of(system.sides.lend(), Tried { h, any_step, probed, declared });
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
                members.meant(side, "", None).file(),
                "does not put out the same a second time in this process: instances share what they are made of, or leave something to \
                 chance; valid: process = \"own\"",
            ));
        }
    }
    Ok(doubts)
}

/// Notes steps of a case that are no multiples of what an FMU says is its own.
fn note_odd_steps(members: &Members, times: &CaseDefaults) {
    for member in Side::BOTH.into_iter().flat_map(|side| members.of(side)) {
        let Some(own) = member.own_step() else { continue };
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
