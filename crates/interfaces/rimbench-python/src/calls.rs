//! What Python calls: lists, one run, the stability limit, an experiment.

use crate::case::{PyCase, programs};
use crate::errors::{RimbenchError, raised_so_far, with_raised};
use crate::everything;
use crate::interruption::interruptible;
use crate::numbers::{count as counted, given, is_truth, number, wrong_kind};
use crate::scheme::PyScheme;
use numpy::PyArray1;
use pyo3::exceptions::{PyRuntimeWarning, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyString};
use rimbench::catalogue::Catalogue;
use rimbench::cosim::{Outcome, StopFlag, Trajectory};
use rimbench::error::{Cause, Error, Result};
use rimbench::fmi::import::{read_case, read_scheme};
use rimbench::harness::{
    Cache, Choice, Experiment, Information, Job, LimitSearch, Question, Scan, StabilityPoint, Step, StopFlags,
    budget_of, monotonic_clock, obtain_reference, prices_of, run_job_until, share_of_peak, spectral_stability_limit,
    stability_limit, steps_to_try,
};
use rimbench::metrics::METRICS;
use rimbench::parameter::Value;
use rimbench::parts_of_error;
use rimbench::runs::{EvaluatedRun, Fact, FactValue, Given, RunRequest, RunSpec};
use serde_json::json;
use std::collections::BTreeMap;
use std::ffi::CString;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;

fn refused(error: Error) -> PyErr {
    RimbenchError::new_err(error.to_string())
}

/// A value of an option or a parameter as the command line would be given it, to the bit.
fn text(key: &str, value: &Bound<'_, PyAny>, valid: &str) -> PyResult<String> {
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(text.to_str()?.to_owned());
    }
    if let (Ok(whole), false) = (value.extract::<i64>(), is_truth(value)?) {
        return Ok(whole.to_string());
    }
    let number = number(key, value).map_err(|error| match error {
        error if error.is_instance_of::<PyTypeError>(value.py()) => wrong_kind(key, value, valid),
        beyond => beyond,
    })?;
    Ok(format!("{number:?}"))
}

/// What a call asks for.
struct Asked {
    catalogue: Catalogue,
    request: RunRequest,
    /// The case, if Python made it.
    case: Option<Py<PyCase>>,
    /// Whether Python made the case or the scheme.
    of_python: bool,
}

impl Asked {
    /// Reads case, scheme, and settings: options of a run and parameters of the case by name. `own` are options that
    /// the call itself sets.
    fn read(
        case: &Bound<'_, PyAny>,
        scheme: Option<&Bound<'_, PyAny>>,
        settings: &Bound<'_, PyDict>,
        own: &[&str],
    ) -> PyResult<Self> {
        let mut asked =
            Asked { catalogue: everything().clone(), request: RunRequest::default(), case: None, of_python: false };
        if let Ok(case) = case.cast::<PyCase>() {
            let made = case.get();
            asked.catalogue.add_case(made.case.clone()).map_err(refused)?;
            asked.request.case = Some(made.case.name.to_string());
            asked.of_python = true;
            asked.case = Some(case.clone().unbind());
        } else {
            asked.request.case = Some(given("case", case, "the name of a case, or a Case")?);
        }
        if let Some(Ok(scheme)) = scheme.map(|scheme| scheme.cast::<PyScheme>()) {
            let made = scheme.get();
            asked.catalogue.add_scheme(made.entry.clone()).map_err(refused)?;
            asked.request.scheme = Some(made.entry.name.to_string());
            asked.of_python = true;
        } else {
            let named = |scheme| given("scheme", scheme, "the name of a scheme, or a Scheme");
            asked.request.scheme = scheme.map(named).transpose()?;
        }
        let known = asked.request.case.as_deref().unwrap_or_default();
        let parameters = &asked.catalogue.case(known).map_err(refused)?.parameters;
        let mut of_run = Vec::new();
        for (key, value) in settings.iter() {
            let key: String = key.extract()?;
            let options = RunRequest::OPTIONS.iter();
            let mut options =
                options.filter(|option| !["case", "scheme"].contains(&option.key) && !own.contains(&option.key));
            if let Some(option) = options.clone().find(|option| option.key == key) {
                let value = text(&key, &value, &format!("a number or a text: {}", option.about))?;
                of_run.push((key, Given::from(&value)));
            } else if let Some(parameter) = parameters.iter().find(|parameter| parameter.name == key) {
                let value = text(&key, &value, &parameter.range.to_string())?;
                asked.request.set.push((key, value));
            } else {
                let options = options.by_ref().map(|option| option.key);
                let names = parameters.iter().map(|parameter| &*parameter.name).chain(options);
                return Err(refused(Error::unknown("parameter or option", &key, names)));
            }
        }
        asked.request.put_all(&of_run).map_err(refused)?;
        Ok(asked)
    }

    /// Runs and evaluates as the command `simulate` does; also returned is what the run is judged by, at its times.
    fn simulate(
        &self,
        divide_error: bool,
        stop: StopFlag<'_>,
        cache: &Cache,
    ) -> Result<(RunSpec, EvaluatedRun, Trajectory)> {
        let spec = self.request.resolve(&self.catalogue)?.with(|own| own.divide_error = divide_error)?;
        let mut prepared = spec.prepare()?;
        let own = self.case.as_ref().map(Py::get).filter(|_| spec.case.judged_by.is_none());
        let reference = match own.and_then(|case| case.reference(&spec)) {
            Some(reference) => reference,
            None => {
                let computed = Arc::new(obtain_reference(&spec, cache, stop)?);
                if let Some(words) = raised_so_far() {
                    return Err(Error::Incompatible(format!("case {} has no reference: {words}", spec.case.name)));
                }
                if let Some(case) = own {
                    case.keep(&spec, &computed);
                }
                computed
            }
        };
        // What is raised in the run that its error is divided by does not end this one.
        with_raised(|| prepared.divide(&reference, Some(monotonic_clock), stop));
        let mut run = prepared.evaluate(&reference, true, true, Some(monotonic_clock), stop)?;
        // Raised where nothing can fail (an observation) and nothing was called any more that could.
        if let (Outcome::Completed, Some(message)) = (&run.outcome, raised_so_far()) {
            let at_s = run.found.ended_at_s;
            run.outcome = Outcome::SubsystemFailed { at_s, cause: Cause::Reported { message } };
        }
        let judged_by = reference.judged.resampled(run.trajectory.column(0));
        if matches!(run.outcome, Outcome::Stopped { .. }) { Err(Error::Stopped) } else { Ok((spec, run, judged_by)) }
    }
}

/// Says that references are computed again by every call, if they are.
fn warn_if_not_kept(py: Python<'_>, cache: &Cache) -> PyResult<()> {
    let Some(fault) = cache.fault() else { return Ok(()) };
    let message = CString::new(format!("references are not kept: {fault}"))?;
    PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &message, 2)
}

/// Facts as a dictionary; what does not apply is `None`.
fn facts<'py>(py: Python<'py>, facts: &[Fact]) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for fact in facts {
        match &fact.value {
            Some(FactValue::Text(text)) => dict.set_item(fact.name, text)?,
            Some(FactValue::Number(number)) => dict.set_item(fact.name, number)?,
            Some(FactValue::Count(count)) => dict.set_item(fact.name, count)?,
            Some(FactValue::Truth(truth)) => dict.set_item(fact.name, truth)?,
            None => dict.set_item(fact.name, py.None())?,
        }
    }
    Ok(dict)
}

/// An array for each column.
fn arrays<'py>(py: Python<'py>, trajectory: &Trajectory) -> PyResult<Bound<'py, PyDict>> {
    let arrays = PyDict::new(py);
    for (index, name) in trajectory.columns().iter().enumerate() {
        let column = PyArray1::from_iter(py, trajectory.column(index));
        // What was found is not to be changed by who looks at it.
        column.getattr("flags")?.setattr("writeable", false)?;
        arrays.set_item(name, column)?;
    }
    Ok(arrays)
}

/// One run, as a dictionary.
#[pyfunction]
pub fn simulate<'py>(
    py: Python<'py>,
    case: &Bound<'py, PyAny>,
    scheme: &Bound<'py, PyAny>,
    settings: &Bound<'py, PyDict>,
    divide_error: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyDict>> {
    let asked = Asked::read(case, Some(scheme), settings, &[])?;
    let divide_error = given("divide_error", divide_error, "True or False")?;
    let cache = Cache::of_user();
    let (found, raised) =
        interruptible(py, asked.of_python, None, |stop, _| asked.simulate(divide_error, stop, &cache))?;
    let (spec, run, judged_by) = found;
    warn_if_not_kept(py, &cache)?;
    let metrics = PyDict::new(py);
    for (metric, value) in run.metrics_of(&spec.case) {
        metrics.set_item(metric.name, value)?;
    }
    let result = PyDict::new(py);
    result.set_item("run_id", spec.id())?;
    result.set_item("outcome", run.outcome.name())?;
    result.set_item("outcome_at_s", run.outcome.at_s())?;
    result.set_item("reason", run.outcome.reason())?;
    result.set_item("ended_at_s", run.found.ended_at_s)?;
    result.set_item("metrics", metrics)?;
    result.set_item("error_parts", parts_of_error(&spec, &run))?;
    result.set_item("trace", arrays(py, &run.trajectory)?)?;
    result.set_item("reference", arrays(py, &judged_by)?)?;
    result.set_item("settings", facts(py, &spec.facts())?)?;
    result.set_item("counters", facts(py, &run.found.counters())?)?;
    result.set_item("costs", facts(py, &run.costs.facts())?)?;
    result.set_item("exception", raised.map(|raised| raised.into_value(py)))?;
    Ok(result)
}

/// Ends of a scan, s, as they are given.
type Ends<'py> = (Option<Bound<'py, PyAny>>, Option<Bound<'py, PyAny>>);

/// The stability limit, as a dictionary.
#[pyfunction]
pub fn limit<'py>(
    py: Python<'py>,
    case: &Bound<'py, PyAny>,
    scheme: &Bound<'py, PyAny>,
    settings: &Bound<'py, PyDict>,
    scan: (Ends<'py>, Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>),
    method: &Bound<'py, PyAny>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let method: &str = &given::<String>("method", method, "run, spectral")?;
    if !["run", "spectral"].contains(&method) {
        return Err(refused(Error::invalid("method", method, "run, spectral")));
    }
    let asked = Asked::read(case, Some(scheme), settings, &["macro_step_s", "phase"])?;
    let ((from, to), per_decade, phases, relative_tolerance) = scan;
    let time = |key: &str, value: Option<Bound<'py, PyAny>>| value.map(|value| number(key, &value)).transpose();
    let relative_tolerance = number("relative_tolerance", &relative_tolerance)?;
    let [per_decade, phases] = [counted("per_decade", &per_decade)?, counted("phases", &phases)?];
    let scan = Scan { from: time("from_s", from)?, to: time("to_s", to)?, per_decade, phases };
    let cache = Cache::of_user();
    let (found, _) = interruptible(py, asked.of_python, progress.as_ref(), |stop, count| {
        let (grid, phases) = scan.resolve(&asked.request, &asked.catalogue)?;
        count.total.store(grid.len(), Ordering::Relaxed);
        let search = LimitSearch {
            request: &asked.request,
            catalogue: &asked.catalogue,
            macro_steps: &grid,
            relative_tolerance,
            progress: &|_| {
                count.done.fetch_add(1, Ordering::Relaxed);
            },
            stop,
        };
        match method {
            "spectral" => spectral_stability_limit(search),
            _ => stability_limit(search, &phases, &cache),
        }
    })?;
    warn_if_not_kept(py, &cache)?;
    let points = PyList::empty(py);
    for StabilityPoint { macro_step, fraction_stable, verdict, spectral_radius } in &found.points {
        let point = PyDict::new(py);
        point.set_item("macro_step_s", macro_step)?;
        point.set_item("fraction_stable", fraction_stable)?;
        point.set_item("failure", verdict.why())?;
        point.set_item("spectral_radius", spectral_radius)?;
        points.append(point)?;
    }
    let result = PyDict::new(py);
    let known = found.first_unstable.is_some() && found.no_answer.is_none();
    result.set_item("stability_limit_s", found.last_stable.filter(|_| known))?;
    result.set_item("last_stable_s", found.last_stable)?;
    result.set_item("first_unstable_s", found.first_unstable)?;
    result.set_item("no_answer_s", found.no_answer)?;
    result.set_item("points", points)?;
    Ok(result)
}

/// A search for the cheapest scheme and step: macro steps, phases, which information there may be (a model, feedback,
/// no step again), and prices.
type Search<'py> = (Ends<'py>, Bound<'py, PyAny>, Bound<'py, PyAny>, [Bound<'py, PyAny>; 3], Option<Bound<'py, PyAny>>);

/// What an exchange, a mechanics step, a micro step and a model solve cost.
fn prices(costs: &Bound<'_, PyAny>) -> PyResult<[f64; 4]> {
    let wrong =
        || wrong_kind("costs", costs, "four numbers: of an exchange, a mechanics step, a micro step and a model solve");
    let items = costs.try_iter().map_err(|_| wrong())?.collect::<PyResult<Vec<_>>>()?;
    let costs = items.iter().map(|cost| number("costs", cost)).collect::<PyResult<Vec<_>>>()?;
    costs.try_into().map_err(|_| wrong())
}

/// The cheapest scheme and its macro step that keep within an error, or what errs least within a budget, as the text of
/// a dictionary in JSON.
#[pyfunction]
pub fn advise(
    py: Python<'_>,
    case: &Bound<'_, PyAny>,
    scheme: Option<&Bound<'_, PyAny>>,
    goal: [Option<Bound<'_, PyAny>>; 2],
    settings: &Bound<'_, PyDict>,
    search: Search<'_>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let mut asked = Asked::read(case, scheme, settings, &["macro_step_s", "phase"])?;
    let [error, exchanges] = goal;
    let ((from, to), per_decade, phases, information, costs) = search;
    let [per_decade, phases] = [counted("per_decade", &per_decade)?, counted("phases", &phases)?];
    let truth = |(key, value)| given::<bool>(key, value, "True or False");
    let mut truths = ["model", "feedback", "real_time"].into_iter().zip(&information).map(truth);
    let mut next = || truths.next().unwrap_or(Ok(false));
    let (model, feedback, repetition) = (next()?, next()?, !next()?);
    let costs = costs.as_ref().map(prices).transpose()?;
    let time = |key: &str, value: Option<Bound<'_, PyAny>>| value.map(|value| number(key, &value)).transpose();
    let ends = [time("from_s", from)?, time("to_s", to)?];
    let valid = "a share of the peak force, \"1%\" or 0.01";
    let error = error.map(|error| text("error", &error, valid)).transpose()?;
    let error = error.map_or(Ok(f64::INFINITY), |error| share_of_peak(&error)).map_err(refused)?;
    let exchanges = exchanges.map(|exchanges| number("exchanges", &exchanges)).transpose()?;
    let within = exchanges.map(|exchanges| budget_of(&asked.catalogue, &mut asked.request, exchanges));
    let within = within.transpose().map_err(refused)?;
    let cache = Cache::of_user();
    let ((advice, prices), _) = interruptible(py, asked.of_python, progress.as_ref(), |stop, count| {
        let Asked { catalogue, request, .. } = &asked;
        let (budget, macro_steps) = match within {
            Some((budget, macro_steps)) => (Some(budget), macro_steps),
            None => (None, steps_to_try(catalogue, request, ends, per_decade)?),
        };
        let prices = costs.map_or_else(|| prices_of(catalogue, request), Ok)?;
        let question = Question {
            catalogue,
            fixed: request,
            error,
            budget,
            information: Information { model, feedback, repetition },
            prices,
            macro_steps: &macro_steps,
            phases,
            cache: &cache,
            progress: &|step| match step {
                Step::ToDo(runs) => count.total.store(runs, Ordering::Relaxed),
                Step::Done(_) => drop(count.done.fetch_add(1, Ordering::Relaxed)),
            },
            stop,
        };
        Ok((rimbench::harness::advise(question)?, prices))
    })?;
    warn_if_not_kept(py, &cache)?;
    let mut told = json!(advice);
    let tell = |told: &mut serde_json::Value, Choice { request, .. }: &Choice| {
        let given = request.given().into_iter().map(|(key, value)| (key.to_owned(), value.to_string()));
        let given = given.filter(|(key, _)| !["case", "scheme"].contains(&&**key)).chain(request.set.clone());
        told["settings"] = json!(given.collect::<BTreeMap<_, _>>());
    };
    for (which, choice) in [("advised", &advice.advised), ("runner_up", &advice.runner_up), ("finer", &advice.finer)] {
        choice.iter().for_each(|choice| tell(&mut told[which], choice));
    }
    for (index, choice) in advice.doubled.iter().flatten().enumerate() {
        tell(&mut told["doubled"][index], choice);
    }
    told["prices"] = json!(prices);
    Ok(told.to_string())
}

/// Runs what is missing of an experiment; returns the folder with the result files.
#[pyfunction]
pub fn run(
    py: Python<'_>,
    file: &Bound<'_, PyAny>,
    out: Option<&Bound<'_, PyAny>>,
    quick: &Bound<'_, PyAny>,
    fresh: &Bound<'_, PyAny>,
    progress: Option<Py<PyAny>>,
    cases_and_schemes: (Bound<'_, PyAny>, Bound<'_, PyAny>),
) -> PyResult<PathBuf> {
    let (cases, schemes) = cases_and_schemes;
    let file: PathBuf = given("file", file, "the path of an experiment file")?;
    let out: Option<PathBuf> = out.map(|out| given("out", out, "the path of a folder")).transpose()?;
    let truth = |key, value| given::<bool>(key, value, "True or False");
    let (quick, fresh) = (truth("quick", quick)?, truth("fresh", fresh)?);
    let case = |case: PyResult<Bound<'_, PyAny>>| given::<Py<PyCase>>("cases", &case?, "a sequence of Case");
    let cases = cases.try_iter().map_err(|_| wrong_kind("cases", &cases, "a sequence of Case"))?;
    let cases = cases.map(case).collect::<PyResult<Vec<_>>>()?;
    let scheme =
        |scheme: PyResult<Bound<'_, PyAny>>| given::<Py<PyScheme>>("schemes", &scheme?, "a sequence of Scheme");
    let schemes = schemes.try_iter().map_err(|_| wrong_kind("schemes", &schemes, "a sequence of Scheme"))?;
    let schemes = schemes.map(scheme).collect::<PyResult<Vec<_>>>()?;
    let mut catalogue = everything().clone();
    let python: PathBuf = py.import("sys")?.getattr("executable")?.extract()?;
    let interpreter = programs(python.clone());
    catalogue.read_schemes_by(move |file| read_scheme(file, &interpreter));
    catalogue.read_cases_by(move |file| read_case(file, programs(python.clone())));
    let mut of_python = !schemes.is_empty();
    for scheme in schemes.iter().map(Py::get) {
        catalogue.add_scheme(scheme.to_be_kept().map_err(refused)?).map_err(refused)?;
    }
    for case in cases.iter().map(Py::get) {
        of_python |= case.case.from_outside;
        catalogue.add_case(case.to_be_kept().map_err(refused)?).map_err(refused)?;
    }
    let cache = Cache::of_user();
    let (folder, _) = interruptible(py, of_python, progress.as_ref(), |stop, count| {
        let experiment = Experiment::read(&file)?;
        let folder = out.unwrap_or_else(|| experiment.results_folder("results".as_ref()));
        let job = Job { quick, fresh, ..Job::new(&experiment, &catalogue, &folder, &cache, &rimbench::BUILD) };
        let told = |step: Step| {
            match step {
                Step::ToDo(runs) => count.total.store(runs, Ordering::Relaxed),
                Step::Done(_) => drop(count.done.fetch_add(1, Ordering::Relaxed)),
            };
        };
        run_job_until(job, &told, StopFlags { soon: stop, now: stop })?;
        Ok(folder)
    })?;
    warn_if_not_kept(py, &cache)?;
    Ok(folder)
}

/// All cases with their parameters.
#[pyfunction]
pub fn cases(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let list = PyList::empty(py);
    for case in everything().cases() {
        let parameters = PyList::empty(py);
        for parameter in &case.parameters {
            let entry = PyDict::new(py);
            entry.set_item("name", &*parameter.name)?;
            entry.set_item("unit", &*parameter.unit)?;
            match &parameter.default {
                Value::Number(number) => entry.set_item("default", number)?,
                Value::Choice(choice) => entry.set_item("default", &**choice)?,
            }
            entry.set_item("valid", parameter.range.to_string())?;
            entry.set_item("about", &*parameter.about)?;
            parameters.append(entry)?;
        }
        let entry = PyDict::new(py);
        entry.set_item("name", &*case.name)?;
        entry.set_item("about", &*case.about)?;
        entry.set_item("duration_s", case.defaults.duration_s)?;
        entry.set_item("macro_step_s", case.defaults.macro_step_s)?;
        entry.set_item("micro_step_s", case.defaults.micro_step_s)?;
        entry.set_item("columns", case.recorded_columns())?;
        entry.set_item("parameters", parameters)?;
        list.append(entry)?;
    }
    Ok(list)
}

/// All schemes.
#[pyfunction]
pub fn schemes(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let list = PyList::empty(py);
    for scheme in everything().schemes() {
        let entry = PyDict::new(py);
        entry.set_item("name", &*scheme.name)?;
        entry.set_item("about", &*scheme.about)?;
        entry.set_item("order", scheme.order)?;
        entry.set_item("sequence", scheme.sequence.to_string())?;
        entry.set_item("gain", scheme.gain.as_ref().map(|gain| gain.default))?;
        entry.set_item("real_time", scheme.real_time())?;
        list.append(entry)?;
    }
    Ok(list)
}

/// Names and units of the metrics, with what they measure.
#[pyfunction]
pub fn metrics(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let list = PyList::empty(py);
    for metric in METRICS {
        let entry = PyDict::new(py);
        entry.set_item("name", metric.name)?;
        entry.set_item("unit", metric.unit)?;
        entry.set_item("about", metric.about)?;
        list.append(entry)?;
    }
    Ok(list)
}
