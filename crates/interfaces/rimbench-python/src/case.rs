//! A case of which Python makes one side or both.

use crate::errors::{self, RimbenchError, exception, with_raised};
use crate::everything;
use crate::numbers::{given as given_as, number, wrong_kind};
use crate::subsystem::{Doubted, PySubsystem};
use pyo3::exceptions::PyRuntimeWarning;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rimbench::cases::{
    BuildSide, Case, CaseDefaults, CoupledSystem, Doubts, Fault, InterfaceColumns, Remedy, Scale, Tried, doubts_of,
    first_outputs,
};
use rimbench::cosim::{PerSide, Port, Ports, Quantity, Side, Subsystem};
use rimbench::error::{Error, Result};
use rimbench::fmi::import::{Programs, SideNotes, read_case, serve};
use rimbench::name::Name;
use rimbench::parameter::{Parameter, Parameters, Range, Value};
use rimbench::runs::{Reference, RunRequest, RunSpec};
use std::ffi::CString;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// Hash of the code that makes sides, or why there is none.
type Code = std::result::Result<String, String>;

/// A case of which Python makes one side or both.
#[pyclass(frozen, subclass, name = "Case", module = "rimbench._native")]
pub struct PyCase {
    pub case: Case,
    /// Hash of the code that makes its sides, or why there is none.
    code: Code,
    /// References of this case, for as long as it lives: on disk there are none of code that may change.
    references: Mutex<Vec<(RunSpec, Arc<Reference>)>>,
}

impl PyCase {
    /// The reference of a run of this case, if it has been computed.
    pub fn reference(&self, spec: &RunSpec) -> Option<Arc<Reference>> {
        let known = self.references.lock().unwrap_or_else(PoisonError::into_inner);
        known.iter().find(|(of, _)| of.shares_reference_with(spec)).map(|(_, reference)| reference.clone())
    }

    /// The case as one whose results are kept: a parameter says from which code it is made, as of a case file.
    pub fn to_be_kept(&self) -> Result<Case> {
        let mut case = self.case.clone();
        if case.from_outside {
            let digest = self.code.clone().map_err(|why| {
                Error::Incompatible(format!(
                    "case {}: results are kept, and nothing tells when its code changes: {why}; valid: classes in a file",
                    case.name
                ))
            })?;
            let about = "hash of the code that makes the sides; not to be set";
            case.parameters.push(Parameter::choice(CODE, [digest], about, "the code itself"));
            case.from_outside = false;
        }
        Ok(case)
    }

    /// Keeps a reference.
    pub fn keep(&self, spec: &RunSpec, reference: &Arc<Reference>) {
        let mut known = self.references.lock().unwrap_or_else(PoisonError::into_inner);
        known.push((spec.clone(), reference.clone()));
    }
}

/// The parameter that says from which code a case is made.
const CODE: &str = "code_digest";

/// One side, made by calling `make` with the parameters.
fn side(name: &str, side: Side, make: Py<PyAny>, doubted: &Arc<Doubted>) -> BuildSide {
    let doubted = doubted.clone();
    let which = if side == Side::Mechanics { "mechanics" } else { "actuator" };
    let whose = format!("the {which} of case {name}");
    Arc::new(move |parameters: &Parameters, ports: &Ports| {
        let built = |py: Python<'_>| -> PyResult<PySubsystem> {
            let values = PyDict::new(py);
            for (parameter, value) in parameters.iter().filter(|(parameter, _)| parameter.name != CODE) {
                match value {
                    Value::Number(number) => values.set_item(&*parameter.name, number)?,
                    Value::Choice(choice) => values.set_item(&*parameter.name, &**choice)?,
                }
            }
            PySubsystem::new(&make.bind(py).call1((values,))?, ports, &whose, doubted.clone())
        };
        let built = Python::attach(|py| built(py).map_err(|error| errors::error(py, error)))?;
        Ok(Box::new(built) as Box<dyn Subsystem>)
    })
}

/// Tries a case of which Python makes the sides that are `given`, by a few steps, and notes what is not to be believed
/// of them. Returns what is odd and may be meant.
fn tried(case: &Case, given: PerSide<bool>, doubted: &PerSide<Arc<Doubted>>) -> Result<Vec<String>> {
    let solver = everything().solvers()[0].clone();
    let parameters = case.default_parameters().lasting(case.defaults.duration_s);
    let step = case.defaults.micro_step_s;
    let mut system = (case.build)(&parameters, &solver)?;
    let (any_step, probed) = (PerSide::from_fn(|_| true), PerSide::from_fn(|_| false));
    let declared = given.actuator && system.sides.actuator.ports().direct_feedthrough;
    let tried = Tried { h: step, any_step, probed, declared };
    let Doubts { failed, state, model, mut faults, notes, first_outputs: first } =
        doubts_of(system.sides.lend(), tried);
    let wrong = |words: String| Err(Error::Incompatible(format!("case {}: {words}", case.name)));
    if let Some((side, failure)) = failed.filter(|(side, _)| given[*side]) {
        let which = if side == Side::Mechanics { "mechanics" } else { "actuator" };
        return wrong(format!("the {which} fails in its first steps: {failure}"));
    }
    let mut twin = (case.build)(&parameters, &solver)?;
    let again = first_outputs(twin.sides.lend(), system.sides.lend(), step);
    for (side, which) in [(Side::Mechanics, "mechanics"), (Side::Actuator, "actuator")] {
        let bits =
            |list: &[PerSide<Vec<f64>>]| list.iter().flat_map(|y| &y[side]).map(|y| y.to_bits()).collect::<Vec<_>>();
        if given[side] && bits(&first) != bits(&again) {
            return wrong(format!(
                "a second {which} does not put out the same as the first: they share what they are made of (a mutable class attribute, a \
                 global), or leave something to chance"
            ));
        }
        if let Some(words) = state[side].clone().filter(|_| given[side]) {
            let _ = doubted[side].copies.set(words);
        }
    }
    if let Some(words) = model.filter(|_| given.mechanics) {
        let _ = doubted.mechanics.model.set(words);
    }
    match Side::BOTH.into_iter().filter(|side| given[*side]).find_map(|side| faults[side].take()) {
        Some(Fault { words, remedy: Some(Remedy { quantity, factor, .. }) }) => {
            let quantity = format!("{quantity:?}").to_lowercase();
            wrong(format!("{words}; valid: the {quantity} times {factor} in what the object takes or puts out"))
        }
        Some(Fault { words, .. }) => wrong(words),
        None => Ok(notes),
    }
}

/// What starts FMUs and classes of Python in processes of their own, by an interpreter.
pub fn programs(python: PathBuf) -> Programs {
    let worker = "from rimbench import _native; _native.fmu_worker()";
    let worker = Some(vec![python.clone(), "-c".into(), worker.into()]);
    Programs { worker, python: Some(python), notes: SideNotes::default() }
}

/// Opens a case file, its FMUs and classes of Python in processes of their own that `python` starts.
#[pyfunction]
pub fn open_case(file: &Bound<'_, PyAny>, python: PathBuf) -> PyResult<PyCase> {
    let file: PathBuf = given_as("file", file, "the path of a case file")?;
    let wrong = |error: Error| RimbenchError::new_err(error.to_string());
    let case = read_case(&file, programs(python)).map_err(wrong)?;
    everything().clone().add_case(case.clone()).map_err(|error| wrong(Error::file(&file, error)))?;
    Ok(PyCase { case, code: Ok(String::new()), references: Mutex::default() })
}

/// Is a worker that drives one FMU through its standard input.
#[pyfunction]
pub fn fmu_worker(py: Python<'_>) -> PyResult<()> {
    py.detach(serve).map_err(|error| RimbenchError::new_err(error.to_string()))
}

/// Whether a call would take a setting of this name for something else than a parameter of the case.
fn is_option(name: &str) -> bool {
    const OF_CALLS: [&str; 12] = [
        "from_s",
        "to_s",
        "per_decade",
        "phases",
        "relative_tolerance",
        "method",
        "progress",
        "error",
        "real_time",
        "model",
        "feedback",
        "costs",
    ];
    name == CODE || RunRequest::OPTIONS.iter().any(|option| option.key == name) || OF_CALLS.contains(&name)
}

/// What is said of a case that is like no other.
struct Description {
    parameters: Vec<(String, f64)>,
    interface: Vec<(String, String, String)>,
    times: CaseDefaults,
}

/// A case both sides of which are made here.
fn of_both(name: &str, description: Description, [mechanics, actuator]: [BuildSide; 2]) -> Result<Case> {
    let Description { parameters, interface, times } = description;
    let port = |name: &String, quantity| Port::new(name.clone(), quantity);
    let positions = interface.iter().map(|(position, ..)| port(position, Quantity::Position));
    let velocities = interface.iter().map(|(_, velocity, _)| port(velocity, Quantity::Velocity));
    let motion = positions.chain(velocities).collect();
    let forces = interface.iter().map(|(.., force)| port(force, Quantity::Force)).collect();
    let ports = Ports { inputs: motion, outputs: forces, direct_feedthrough: false };
    let build = {
        let ports = ports.clone();
        move |parameters: &Parameters, _: &_| -> Result<CoupledSystem> {
            let sides =
                PerSide { mechanics: mechanics(parameters, &ports.facing())?, actuator: actuator(parameters, &ports)? };
            Ok(CoupledSystem { bounded_by_motion: true, ..CoupledSystem::of(sides) })
        }
    };
    let given = |(name, default): (String, f64)| {
        Parameter::number(name, "-", default, Range::Finite, "a parameter from Python", "given in Python")
    };
    let row = |(position, velocity, force): (String, String, String)| InterfaceColumns::new(position, velocity, force);
    let parameters = parameters.into_iter().map(given).collect();
    let mut case = Case {
        interface_columns: interface.into_iter().map(row).collect(),
        from_outside: true,
        waits: true,
        ..Case::with_parameters(name.to_owned(), "A case written in Python", times, parameters, build)
    };
    let solver = everything().solvers()[0].clone();
    let mut system = (case.build)(&case.default_parameters(), &solver)?;
    case.trace_columns.extend(ports.inputs.iter().chain(&ports.outputs).map(|port| port.name.clone()));
    case.trace_columns.push(Name::from("force_to_mechanics_n"));
    for side in Side::BOTH {
        case.trace_columns.extend_from_slice(system.sides[side].capabilities().observables());
    }
    Ok(case)
}

#[pymethods]
impl PyCase {
    #[new]
    fn new(
        py: Python<'_>,
        name_reference_and_code: (Bound<'_, PyAny>, Bound<'_, PyAny>, (Option<String>, String)),
        like: Option<&Bound<'_, PyAny>>,
        sides: (Option<Py<PyAny>>, Option<Py<PyAny>>),
        parameters: Option<&Bound<'_, PyAny>>,
        interface: Option<&Bound<'_, PyAny>>,
        times_and_scale: ([Option<Bound<'_, PyAny>>; 4], Option<Bound<'_, PyAny>>),
    ) -> PyResult<Self> {
        let (times_s, scale) = times_and_scale;
        let ((name, reference, code), (mechanics, actuator)) = (name_reference_and_code, sides);
        let code = code.0.ok_or(code.1);
        let name: String = given_as("name", &name, "a name, in kebab-case")?;
        let reference: String = given_as("reference", &reference, "own, original")?;
        let like: Option<String> =
            like.map(|like| given_as("like", like, "the name of a built-in case")).transpose()?;
        for (key, make) in [("mechanics", &mechanics), ("actuator", &actuator)] {
            if let Some(make) = make.as_ref().map(|make| make.bind(py)).filter(|make| !make.is_callable()) {
                return Err(wrong_kind(key, make, "what makes the side, called with the parameters"));
            }
        }
        let rows = "a sequence of (position, velocity, force), three names each";
        let interface: Option<Vec<(String, String, String)>> =
            interface.map(|interface| given_as("interface", interface, rows)).transpose()?;
        let named = "a dictionary of names and defaults";
        let parameters =
            parameters.map(|given| given.cast::<PyDict>().map_err(|_| wrong_kind("parameters", given, named)));
        let parameters = parameters.transpose()?;
        let keys = ["duration_s", "macro_step_s", "micro_step_s", "reference_step_s"];
        let mut times = [None; 4];
        for ((time, key), given) in times.iter_mut().zip(keys).zip(times_s) {
            *time = given.map(|given| number(key, &given)).transpose()?;
        }
        let [duration_s, macro_step_s, micro_step_s, reference_step_s] = times;
        let refused = |message: String| RimbenchError::new_err(message);
        let magnitudes = "three numbers above 0, of positions (m), velocities (m/s) and forces (N)";
        let scale: Option<[f64; 3]> = scale.map(|scale| given_as("scale", &scale, magnitudes)).transpose()?;
        if let Some(scale) = scale.filter(|scale| !scale.iter().all(|of| of.is_finite() && *of > 0.0)) {
            return Err(refused(Error::invalid("scale", format!("{scale:?}"), magnitudes).to_string()));
        }
        let wrong = |error: Error| exception(py, &error, None);
        let make = || -> PyResult<(Case, Code)> {
            if !["own", "original"].contains(&&*reference) {
                return Err(refused(Error::invalid("reference", &reference, "own, original").to_string()));
            }
            let given = PerSide { mechanics, actuator };
            let are_given = given.as_ref().map(Option::is_some);
            let doubted = PerSide::from_fn(|_| Arc::new(Doubted::default()));
            let mut case = match like.as_deref() {
                Some(like) => {
                    if parameters.is_some() || interface.is_some() {
                        let message = "parameters and interface are those of the case that it is like: give neither";
                        return Err(refused(message.to_owned()));
                    }
                    let original = everything().case(like).map_err(wrong)?;
                    let mut case = Case::clone(original);
                    for which in Side::BOTH {
                        let make = if which == Side::Mechanics { &given.mechanics } else { &given.actuator };
                        if let Some(make) = make {
                            let made = side(&name, which, make.clone_ref(py), &doubted[which]);
                            case = case.with_side(name.clone(), which, made).map_err(wrong)?;
                        }
                    }
                    if !case.from_outside {
                        return Err(refused(
                            "a case like another needs a mechanics or an actuator of its own".to_owned(),
                        ));
                    }
                    case.judged_by = (reference == "original").then(|| original.clone());
                    case.about = Name::from(format!("{like}, with a side written in Python"));
                    case.defaults.duration_s = duration_s.unwrap_or(case.defaults.duration_s);
                    case.defaults.macro_step_s = macro_step_s.unwrap_or(case.defaults.macro_step_s);
                    case.defaults.micro_step_s = micro_step_s.unwrap_or(case.defaults.micro_step_s);
                    case.defaults.reference_step_s = reference_step_s.unwrap_or(case.defaults.reference_step_s);
                    case
                }
                None => {
                    let (Some(mechanics), Some(actuator), Some(interface), Some(duration_s), Some(macro_step_s)) =
                        (given.mechanics, given.actuator, interface, duration_s, macro_step_s)
                    else {
                        let message = "a case that is like no other needs mechanics, actuator, interface, duration_s and macro_step_s";
                        return Err(refused(message.to_owned()));
                    };
                    if reference == "original" {
                        return Err(refused("reference = original: the case is like no other".to_owned()));
                    }
                    let micro_step_s = micro_step_s.unwrap_or(macro_step_s);
                    let times = CaseDefaults {
                        duration_s,
                        macro_step_s,
                        micro_step_s,
                        reference_step_s: reference_step_s.unwrap_or(micro_step_s),
                        reference_sampling_s: macro_step_s.max(micro_step_s),
                    };
                    let parameters: Vec<(String, f64)> = parameters.map_or(Ok(Vec::new()), |given| {
                        let read = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
                            let key: String = given_as("a name in parameters", &key, "a text")?;
                            let value = number(&key, &value)?;
                            Ok((key, value))
                        };
                        given.iter().map(read).collect::<PyResult<_>>()
                    })?;
                    if let Some((name, _)) = parameters.iter().find(|(name, _)| is_option(name)) {
                        return Err(refused(format!(
                            "parameter `{name}`: an option of a run or of a call has that name; valid: another"
                        )));
                    }
                    let description = Description { parameters, interface, times };
                    let sides = [(Side::Mechanics, mechanics), (Side::Actuator, actuator)];
                    of_both(&name, description, sides.map(|(which, make)| side(&name, which, make, &doubted[which])))
                        .map_err(wrong)?
                }
            };
            case.name = Name::from(name);
            if let Some([position_m, velocity_m_s, force_n]) = scale {
                case.scale = Some(Scale { position_m, velocity_m_s, force_n });
            }
            let (built, scale) = (case.build.clone(), case.scale.map(|scale| scale.force_n));
            case.build = Arc::new(move |parameters, solver| built(parameters, solver)?.agreed(scale));
            // A name that cannot be is found here and not in every run.
            everything().clone().add_case(case.clone()).map_err(wrong)?;
            for note in tried(&case, are_given, &doubted).map_err(wrong)? {
                PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &CString::new(note)?, 2)?;
            }
            let _ = doubted.mechanics.tried.set(());
            let digests = [doubted.mechanics.made_from.get(), doubted.actuator.made_from.get()];
            let code = code.map(|code| digests.into_iter().flatten().fold(code, |all, digest| all + "-" + digest));
            Ok((case, code))
        };
        let (made, raised) = with_raised(make);
        let (case, code) = made.inspect_err(|error| {
            if raised.is_some() {
                error.set_cause(py, raised);
            }
        })?;
        Ok(PyCase { case, code, references: Mutex::default() })
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.case.name
    }

    fn __repr__(&self) -> String {
        format!("rimbench.Case({:?})", self.case.name)
    }
}
