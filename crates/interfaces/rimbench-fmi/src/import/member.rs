//! The FMU of a side, with all that a case file names in it.

use super::archive::Unpacked;
use super::case_file::{CaseFile, ProcessKind, SideTable};
use super::description::{Description, Exponents, FORCE, LENGTH, VELOCITY, one_micro};
use super::finder::{Finder, number_as};
use super::host::{Element, Host, Limits, ModelVariables, NEEDS_TOOL, Plan, Probe, Scaled, Start, Type};
use super::library::Loaded;
use super::probing::SideNotes;
use super::process::Remote;
use super::side::{ImportedSide, Offers, Shape};
use crate::export::side_name;
use crate::last_words::tell_once;
use crate::model_parts::ModelSize;
use rimbench_cases::cases::WHAT_REMAINS;
use rimbench_cases::parameter::Parameters;
use rimbench_core::cosim::{Port, Ports, Quantity, Side};
use rimbench_core::error::{Error, Result};
use rimbench_core::name::Name;
use rimbench_results::checksums::hex;
use rimbench_results::input::{beside, read_bytes};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Units of positions, velocities and forces.
const UNITS: [(Quantity, Exponents, &str); 3] =
    [(Quantity::Position, LENGTH, "m"), (Quantity::Velocity, VELOCITY, "m/s"), (Quantity::Force, FORCE, "N")];

/// By how much forces are changed where an FMU is probed, of their magnitude: little enough that the same contacts
/// push.
const FORCE_CHANGE: f64 = 1e-3;
/// Likewise positions and velocities: a force that follows a stiff element answers to micrometres.
const MOTION_CHANGE: f64 = 1e-6;
/// Where no micro step is given, the share of the macro step by which an actuator is probed.
const PROBED_SHARE: f64 = 0.1;

/// Why there are no rates of an FMU's outputs.
const NO_RATES: &str = "its FMU has no directional derivatives of them, and cannot be probed for them, which takes states to be kept \
                        and set, steps of any length, and outputs that are continuous and of type Float64";
/// Why there is no interface model.
const NO_MODEL: &str = "its FMU has none, no directional derivatives of how its velocities move, and cannot be probed for them, which \
                        takes states to be kept and set, and outputs that are continuous and of type Float64";

/// A parameter of the case, and the variable that takes it.
struct Taken {
    parameter: String,
    variable: String,
    reference: u32,
    kind: Type,
    element: Option<Element>,
    limits: Limits,
    exact: bool,
}

/// One FMU with what the case makes of it.
pub(super) struct FmuMember {
    pub(super) unpacked: Unpacked,
    /// Hash of what it is made of: the file and the libraries that it needs.
    pub(super) digest: String,
    pub(super) declares_feedthrough: bool,
    plan: Plan,
    pub(super) ports: Ports,
    pub(super) offers: Offers,
    shape: Shape,
    parameters: Vec<Taken>,
}

/// The coupling variables that an FMU has.
struct Coupled {
    outputs: Vec<Scaled>,
    inputs: Vec<Scaled>,
    /// See [`Plan`].
    limits: Vec<(usize, String, Limits)>,
    /// Whether all of them are continuous, and of type Float64.
    continuous: bool,
    notes: Vec<String>,
    ports: Ports,
    shape: Shape,
    /// Whether the FMU lists what its outputs depend on.
    said: bool,
}

/// From what is known how its outputs move, and which interface model follows.
struct Motion {
    /// Variables that are the rates of the outputs.
    rates: Option<Vec<Scaled>>,
    /// How it is probed for them, where it does not say them.
    probe: Option<Probe>,
    /// The interface model that it tells itself.
    model: Option<ModelVariables>,
    /// Whether the interface model is what the rates of the velocities say.
    smooth: bool,
}

impl Motion {
    fn of(file: &CaseFile, finder: &Finder<'_>, side: Side, coupled: &Coupled) -> Result<Self> {
        let Coupled { outputs, inputs, ports, continuous, .. } = coupled;
        let (description, rows) = (&finder.unpacked.description, file.interface.len());
        let mechanics = side == Side::Mechanics;
        let rates = if *continuous { rates(finder, outputs)? } else { None };
        let rates = rates.filter(|_| inputs.iter().all(Scaled::is_single));
        let plain = inputs.iter().chain(outputs).all(|scaled| scaled.factor == 1.0);
        let tells = mechanics && plain && finder.unpacked.layered;
        let model = tells.then(|| finder.model(rows)).transpose()?;
        // A mechanics is asked by steps such as it takes anyway.
        let may_be_probed = *continuous && description.keeps_state && (description.any_step || mechanics);
        let probed = rates.is_none() && model.is_none() && may_be_probed;
        let given = file.side(side).probe_step_s;
        if let Some(step) = given.filter(|_| probed && !description.any_step) {
            return Err(finder.wrong(format!(
                "probe_step_s = {step} of [{}]: it takes no steps of any length (canHandleVariableCommunicationStepSize); valid: none, and \
                 it is probed by the steps that it takes",
                side_name(side)
            )));
        }
        let micro_step = || file.micro_step_s.unwrap_or(PROBED_SHARE * file.macro_step_s);
        let step = given.unwrap_or_else(|| if mechanics { f64::MAX } else { micro_step() });
        let probe = probed.then_some(Probe {
            step,
            change: if mechanics { FORCE_CHANGE } else { MOTION_CHANGE },
            feedthrough: ports.direct_feedthrough,
        });
        // Velocities that jump with a force have no accelerations.
        let motion = Motion { rates, probe, model, smooth: false };
        let smooth = mechanics && motion.model.is_none() && motion.is_known() && !ports.direct_feedthrough;
        Ok(Motion { smooth, ..motion })
    }

    /// Whether anything says how its outputs move.
    fn is_known(&self) -> bool {
        self.rates.is_some() || self.probe.is_some()
    }

    fn offers(&self, side: Side, description: &Description, observables: &[String], work: bool) -> Offers {
        Offers {
            rates: side == Side::Actuator && self.is_known(),
            probed: self.probe.is_some(),
            smooth: self.smooth,
            model_from_s: 0.0,
            without: match side {
                Side::Actuator if !self.is_known() => Some(NO_RATES.into()),
                Side::Mechanics if !self.smooth => Some(format!("{NO_MODEL}; {WHAT_REMAINS}").into()),
                _ => None,
            },
            copies: description.keeps_state,
            without_copies: None,
            work,
            observables: observables.iter().cloned().map(Name::from).collect(),
        }
    }
}

impl FmuMember {
    /// Opens the FMU of a side and finds all that the case file names in it.
    pub(super) fn open((path, file): (&Path, &CaseFile), fmu: &Path, side: Side, rows: &[[String; 3]]) -> Result<Self> {
        let table = file.side(side);
        let unpacked = Unpacked::open(fmu)?;
        if unpacked.description.only_once && file.process == ProcessKind::Same {
            return Err(Error::file(
                fmu,
                "may be in a process only once (canBeInstantiatedOnlyOncePerProcess), and a case is built more often: valid: process = \"own\"",
            ));
        }
        let finder = Finder { unpacked: &unpacked };
        let coupled = coupled(file, &finder, side, rows)?;
        let (starts, parameters) = starts(file, &finder, side)?;
        let observed: Vec<Scaled> = table.observe.iter().map(|name| finder.observed(name)).collect::<Result<_>>()?;
        let headings: Vec<String> = table.observe.iter().map(|name| finder.heading(name)).collect();
        let work = table.interface_work.as_ref().map(|name| finder.work(name)).transpose()?;
        check_roles(&finder, [&coupled.inputs, &[&*coupled.outputs, work.as_slice()].concat()], &starts, &parameters)?;
        let motion = Motion::of(file, &finder, side, &coupled)?;
        let description = &unpacked.description;
        for note in description.notes.iter().chain(&coupled.notes) {
            tell_once(&format!("note: {}: {note}\n", fmu.display()));
        }
        if description.needs_tool {
            tell_once(&format!("note: {}: {NEEDS_TOOL}\n", fmu.display()));
        }
        if description.begin != 0.0 {
            let (begin, file) = (description.begin, fmu.display());
            tell_once(&format!(
                "note: {file}: its time is {begin} when a run begins (startTime of <DefaultExperiment>)\n"
            ));
        }
        let offers = motion.offers(side, description, &headings, work.is_some());
        let Coupled { outputs, inputs, limits, ports, shape, said, .. } = coupled;
        let needs: Vec<PathBuf> = table.needs.iter().map(|library| library_at(path, library)).collect();
        let digest = digest_of(&unpacked.digest, &needs)?;
        let declares_feedthrough = ports.direct_feedthrough && (said || table.direct_feedthrough.is_some());
        let plan = Plan {
            file: unpacked.file.clone(),
            library: unpacked.library.clone(),
            needs: needs.clone(),
            resources: unpacked.folder.path().join("resources"),
            version_2: description.is_version_2(),
            token: description.token.clone(),
            log: table.log,
            side: side_name(side).to_owned(),
            needs_tool: description.needs_tool,
            lodger: false,
            begin: description.begin,
            time_unit: description.time_unit,
            stop: None,
            starts,
            positions: if side == Side::Mechanics { outputs.len() - rows.len() } else { 0 },
            inputs,
            limits,
            outputs,
            rates: motion.rates,
            derivatives: description.derivatives,
            smooth: motion.smooth,
            probe: motion.probe,
            keeps_state: description.keeps_state,
            step: description.variable("rim.step").filter(|_| unpacked.layered).map(|variable| variable.reference),
            model: motion.model,
            observed,
            observed_names: table.observe.clone(),
            work,
        };
        Ok(FmuMember { plan, ports, offers, shape, parameters, unpacked, digest, declares_feedthrough })
    }

    /// The size of the interface model that it tells itself.
    pub(super) fn model(&self) -> Option<ModelSize> {
        self.plan.model.as_ref().map(|model| model.size)
    }

    /// Starts it for a run that ends at `stop` (s), as far as the end of its start values: it waits to be told with
    /// which inputs it begins.
    pub(super) fn side(
        &self,
        parameters: &Parameters,
        process: &Process,
        notes: &SideNotes,
    ) -> Result<ImportedSide, String> {
        let (host, file) = (self.host(parameters, process)?, (&*self.unpacked.file, notes));
        Ok(ImportedSide::new(host, file, self.ports.clone(), self.offers.clone(), self.shape.clone()))
    }

    /// Takes back what it says that it offers, where a check has found that it does not.
    pub(super) fn doubt(&mut self, state: Option<String>, model: Option<String>) {
        if let Some(words) = state {
            if self.offers.probed {
                (self.offers.rates, self.offers.smooth, self.plan.smooth, self.plan.probe) =
                    (false, false, false, None);
                self.offers.probed = false;
                self.offers.without = Some(words.clone().into());
            }
            self.offers.without_copies = Some(words);
        }
        if let Some(words) = model {
            (self.plan.model, self.offers.smooth, self.plan.smooth) = (None, false, false);
            self.offers.without = Some(words.into());
        }
    }

    /// Rows whose position is the integral of the velocity, with where it starts, m.
    pub(super) fn integrals(&self) -> &[(usize, f64)] {
        &self.shape.integrals
    }

    /// Says what a run with these parameters is to do with it.
    pub(super) fn plan(&self, parameters: &Parameters) -> Result<Plan, String> {
        let mut plan = self.plan.clone();
        // Probing at the end of a run goes beyond it; by a macro step, which may be as long as all of it, where that is
        // asked for.
        let beyond = |end: f64, probe: Probe| if probe.step < f64::MAX { probe.step } else { end };
        plan.stop = parameters.duration().map(|end| end + plan.probe.map_or(0.0, |probe| beyond(end, probe)));
        for Taken { parameter, variable, reference, kind, element, limits, exact } in &self.parameters {
            let number =
                parameters.setting(parameter).ok_or_else(|| format!("parameter {parameter} is not one of the case"))?;
            let value = limits.check(number).and_then(|()| number_as(*kind, number)).map_err(|valid| {
                let file = self.unpacked.file.display();
                format!(
                    "{file}: variable `{variable}` = {number} by parameter {parameter} is not valid; valid: {valid}"
                )
            })?;
            let Some(Element { at, .. }) = *element else {
                plan.starts.push(Start {
                    variable: variable.clone(),
                    reference: *reference,
                    kind: *kind,
                    values: value,
                    exact: *exact,
                });
                continue;
            };
            let array = plan.starts.iter_mut().find(|start| start.reference == *reference && start.kind == *kind);
            if let Some(array) = array {
                array.values.put(at, value);
            }
        }
        Ok(plan)
    }

    /// Starts what drives it.
    fn host(&self, parameters: &Parameters, process: &Process) -> Result<Box<dyn Host>, String> {
        let plan = Plan { lodger: matches!(process, Process::Same), ..self.plan(parameters)? };
        match process {
            Process::Same => Ok(Box::new(Loaded::new(plan)?)),
            Process::Own { worker, answer_within } => Ok(Box::new(Remote::start(&plan, worker, *answer_within)?)),
        }
    }
}

/// Where FMUs run.
pub(super) enum Process {
    Same,
    /// Each in one that this command makes.
    Own {
        worker: Vec<PathBuf>,
        answer_within: Duration,
    },
}

/// A library that a case file names: one that lies beside the file, else what the system finds by that name.
fn library_at(file: &Path, library: &Path) -> PathBuf {
    let there = beside(file, library);
    if there.is_file() { std::path::absolute(&there).unwrap_or(there) } else { library.to_owned() }
}

/// Folders in which the system finds libraries by their names, after those of `LD_LIBRARY_PATH`.
const OF_SYSTEM: [&str; 5] = ["/usr/local/lib", "/lib64", "/usr/lib64", "/lib", "/usr/lib"];
/// Most that a library may hold, bytes.
const MOST_OF_LIBRARY: u64 = 4 << 30;

/// Hash of an FMU together with the libraries that it needs; of one that is not where the system finds most, its name.
fn digest_of(fmu: &str, needs: &[PathBuf]) -> Result<String> {
    if needs.is_empty() {
        return Ok(fmu.to_owned());
    }
    let mut hash = Sha256::new();
    hash.update(fmu);
    let multiarch = format!("{}-linux-gnu", std::env::consts::ARCH);
    for library in needs {
        hash.update(library.file_name().unwrap_or_default().as_encoded_bytes());
        let given = std::env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
        let folders = OF_SYSTEM.iter().flat_map(|folder| [PathBuf::from(folder).join(&multiarch), folder.into()]);
        let mut places = std::env::split_paths(&given).chain(folders).map(|folder| folder.join(library));
        // What stands beside the case file has its whole path by now.
        if let Some(found) = places.find(|place| place.is_file()) {
            hash.update(Sha256::digest(read_bytes(&found, MOST_OF_LIBRARY)?));
        }
    }
    Ok(hex(&hash.finalize()[..8]))
}

/// Finds the coupling variables.
fn coupled(file: &CaseFile, finder: &Finder<'_>, side: Side, rows: &[[String; 3]]) -> Result<Coupled> {
    let mechanics = side == Side::Mechanics;
    let [given, taken] = given_and_taken(side, rows.len());
    let found = |&(row, which): &(usize, usize), causality: &str| -> Result<Option<Scaled>> {
        let (_, exponents, unit) = UNITS[which];
        let Some(end) = file.interface[row].end(side, which) else { return Ok(None) };
        finder.coupling(end, causality, side, exponents, unit).map(Some)
    };
    let port = |&(row, which): &(usize, usize)| Port::new(rows[row][which].clone(), UNITS[which].0);
    let outputs: Vec<_> = given.iter().map(|place| found(place, "output")).collect::<Result<_>>()?;
    let inputs: Vec<_> = taken.iter().map(|place| found(place, "input")).collect::<Result<_>>()?;
    let mut shape =
        Shape { taken: (0..inputs.len()).filter(|at| inputs[*at].is_some()).collect(), integrals: Vec::new() };
    if mechanics {
        for (at, row) in file.interface.iter().enumerate() {
            if let Some(start) = row.integral().map_err(Error::Incompatible)? {
                shape.integrals.push((at, start));
            }
        }
    }
    let (outputs, inputs): (Vec<Scaled>, Vec<Scaled>) =
        (outputs.into_iter().flatten().collect(), inputs.into_iter().flatten().collect());
    let description = &finder.unpacked.description;
    let named = |list: &[(usize, usize)]| -> Vec<&str> {
        list.iter().filter_map(|&(row, which)| Some(file.interface[row].end(side, which)?.0)).collect()
    };
    let (names, input_names) = ([named(&given), named(&taken)].concat(), named(&taken));
    let variables: Vec<_> = names.iter().map(|name| finder.find(name, "output")).collect::<Result<_>>()?;
    let continuous = variables[..outputs.len()].iter().all(|found| !found.variable.discrete)
        && variables.iter().all(|found| found.variable.kind == Type::Float64);
    let limits = variables[outputs.len()..].iter().zip(&input_names).enumerate();
    let limits = limits.map(|(at, (found, name))| (at, (*name).to_owned(), found.variable.limits.clone()));
    let limits = limits.filter(|(.., limits)| !limits.is_none()).collect();
    let notes = names.iter().flat_map(|name| finder.notes(name)).collect();
    let said = outputs.iter().all(|output| description.dependencies.contains_key(&output.reference));
    let depends = || {
        let depends = |output: &Scaled, input: &Scaled| description.depends(output.reference, input.reference);
        // Where nothing is said: positions and velocities are states, forces may follow them at once.
        (said || !mechanics) && outputs.iter().any(|output| inputs.iter().any(|input| depends(output, input)))
    };
    let ports = Ports {
        inputs: taken.iter().map(port).collect(),
        outputs: given.iter().map(port).collect(),
        direct_feedthrough: file.side(side).direct_feedthrough.unwrap_or_else(depends),
    };
    Ok(Coupled { outputs, inputs, limits, continuous, notes, ports, shape, said })
}

/// Finds what is set before a run, by the file itself and by parameters of the case.
fn starts(file: &CaseFile, finder: &Finder<'_>, side: Side) -> Result<(Vec<Start>, Vec<Taken>)> {
    let SideTable { start, .. } = file.side(side);
    let (mut starts, mut taken) = (Vec::new(), Vec::<Taken>::new());
    start.iter().try_for_each(|(name, value)| finder.start(side, name, value, &mut starts))?;
    for (parameter, table) in &file.parameters {
        let to = match side {
            Side::Mechanics => table.mechanics.clone(),
            Side::Actuator => table.actuator.as_ref().and_then(|names| names.of(0)),
        };
        let Some(to) = &to else { continue };
        let found = finder.settable(to)?;
        let (variable, element) = (found.variable, found.element);
        if element.is_none() && !variable.dimensions.is_empty() {
            return Err(
                finder.wrong(format!("variable `{to}` is an array; valid: one of its elements, such as `{to}[1]`"))
            );
        }
        let checked = variable.limits.check(table.default).and_then(|()| number_as(variable.kind, table.default));
        let value = checked.map_err(|valid| {
            finder.wrong(format!(
                "variable `{to}` = {} by [parameters.{parameter}] is not valid; valid: {valid}",
                table.default
            ))
        })?;
        let units = [&*table.unit, &*variable.unit].map(|unit| if unit == "-" { "" } else { unit });
        if units.iter().all(|unit| !unit.is_empty()) && one_micro(units[0]) != one_micro(units[1]) {
            return Err(finder.wrong(format!(
                "variable `{to}` is in `{}`, and [parameters.{parameter}] says unit = {:?}; valid: the same, or none, for its values \
                 go to the FMU as they are",
                variable.unit, table.unit
            )));
        }
        let (reference, kind) = (variable.reference, variable.kind);
        let set = |start: &Start| start.reference == reference && start.kind == kind && element.is_none();
        if start.contains_key(to) || starts.iter().any(set) {
            return Err(Error::Incompatible(format!(
                "variable `{to}` is set twice: in start of [{}] and by [parameters.{parameter}]",
                side_name(side)
            )));
        }
        let same = |other: &&Taken| other.reference == reference && other.kind == kind && other.element == element;
        if let Some(Taken { parameter: other, .. }) = taken.iter().find(same) {
            return Err(Error::Incompatible(format!(
                "variable `{to}` of [{}] is set twice: by [parameters.{other}] and [parameters.{parameter}]",
                side_name(side)
            )));
        }
        if element.is_some() {
            finder.put_start(&found, to, value, &mut starts)?;
        }
        let (limits, exact) = (variable.limits.clone(), variable.exact);
        taken.push(Taken {
            parameter: parameter.clone(),
            variable: to.clone(),
            reference,
            kind,
            element,
            limits,
            exact,
        });
    }
    Ok((starts, taken))
}

/// Refuses a variable that stands for two things: coupling variables, the account of work, values that are set. The
/// first value of an output may be set, where the FMU says so.
fn check_roles(
    finder: &Finder<'_>,
    [inputs, outputs]: [&[Scaled]; 2],
    starts: &[Start],
    parameters: &[Taken],
) -> Result<()> {
    let name = |reference: u32, kind: Type| {
        let variables = &finder.unpacked.description.variables;
        let found = variables.iter().find(|variable| variable.reference == reference && variable.kind == kind);
        found.map_or(String::new(), |variable| variable.name.clone())
    };
    let roles = [inputs, outputs].concat();
    for (at, role) in roles.iter().enumerate() {
        let name = || name(role.reference, role.kind);
        let same =
            |other: &Scaled| (other.reference, other.kind, other.element) == (role.reference, role.kind, role.element);
        if roles[..at].iter().any(same) {
            return Err(finder.wrong(format!(
                "variable `{}` is named in two places of the case; valid: one for each quantity",
                name()
            )));
        }
        let set = |reference: u32, kind: Type| at < inputs.len() && reference == role.reference && kind == role.kind;
        let by_start = starts.iter().any(|start| set(start.reference, start.kind)).then(|| "a start value".to_owned());
        let by_parameter = parameters.iter().find(|taken| set(taken.reference, taken.kind));
        let by_parameter = by_parameter.map(|taken| format!("[parameters.{}]", taken.parameter));
        if let Some(by) = by_start.or(by_parameter) {
            return Err(finder.wrong(format!(
                "variable `{}` is coupled and has {by} as well; valid: one of both, for the other side says what it starts with",
                name()
            )));
        }
    }
    Ok(())
}

/// The variables that are the rates of outputs, where each has one and there are directional derivatives.
fn rates(finder: &Finder<'_>, outputs: &[Scaled]) -> Result<Option<Vec<Scaled>>> {
    let description = &finder.unpacked.description;
    if !description.derivatives {
        return Ok(None);
    }
    let numbers = || description.variables.iter().filter(|variable| variable.kind == Type::Float64);
    let rate_of = |output: &Scaled| -> Option<Scaled> {
        let rate = numbers().find(|variable| variable.derivative == Some(output.reference))?;
        // What the case file says of the output holds of its rate; the unit is the rate's own, where it has one.
        let of = numbers().find(|variable| variable.reference == output.reference)?;
        if rate.is_in_unknown_unit() || output.element.is_some() {
            return None;
        }
        let units = if rate.exponents.is_some() { rate.factor / of.factor } else { 1.0 / description.time_unit };
        Some(Scaled { reference: rate.reference, factor: output.factor * units, offset: 0.0, ..*output })
    };
    let rates: Option<Vec<Scaled>> = outputs.iter().map(rate_of).collect();
    for rate in rates.iter().flatten() {
        let variable = numbers().find(|variable| variable.reference == rate.reference);
        if let Some((name, fault)) = variable.and_then(|variable| Some((&variable.name, variable.fault.as_ref()?))) {
            return Err(finder.wrong(format!("variable `{name}`: {fault}")));
        }
    }
    Ok(rates)
}

/// What a side of an interface with so many rows puts out and takes, as pairs of row and variable: positions of all
/// rows, then velocities; forces go the other way.
fn given_and_taken(side: Side, rows: usize) -> [Vec<(usize, usize)>; 2] {
    let list = |which: &[usize]| which.iter().flat_map(|&which| (0..rows).map(move |row| (row, which))).collect();
    let (motion, force) = (list(&[0, 1]), list(&[2]));
    if side == Side::Mechanics { [motion, force] } else { [force, motion] }
}
