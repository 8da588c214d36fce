//! `rimbench simulate`: one run.

use super::json::Object;
use super::number::{percent, quantity, with_digits};
use super::progress::Heartbeat;
use super::run_options::{RunOptions, seconds, typed};
use super::screen::{Mood, Table, command_row, headline, paragraph, row};
use super::{Format, answered, print, print_json, probe_lines, program, warn_of_cache, with_files};
use clap::Args;
use rimbench::atomic_file::check_writable_file;
use rimbench::catalogue::Catalogue;
use rimbench::cosim::{Creation, Jump, Outcome, OutcomeClass, StopFlag};
use rimbench::error::Error;
use rimbench::figures::style::Styles;
use rimbench::figures::{plot, render};
use rimbench::fmi::import::{ProbeQuality, SideNotes};
use rimbench::harness::{Cache, DeadlineLog, monotonic_clock, obtain_reference, processor_clock};
use rimbench::input::read_text;
use rimbench::metrics::{METRICS, STAYS_DOWN_M};
use rimbench::parameter::{Value as ParameterValue, without_unit};
use rimbench::runs::{EvaluatedRun, FactValue, Reference, RunRequest, RunSpec, believed, what_happens};
use rimbench::trace::{check_place_for_trace, write_trace};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `simulate`.
#[derive(Debug, Args)]
pub struct Simulate {
    #[command(flatten)]
    run: RunOptions<false>,
    /// CSV of missed deadlines to replay: `time_s` and `computing_time_s` of each macro step
    #[arg(long, value_name = "FILE", requires = "deadline")]
    deadline_log: Option<PathBuf>,
    /// Time that a macro step may take
    #[arg(long, value_name = "TIME", value_parser = seconds, requires = "deadline_log")]
    deadline: Option<f64>,
    /// Write a trace, one row per communication point
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Draw motion, force and contacts beside the reference: .svg, .png, or .pdf in a build with `--features pdf`
    #[arg(long, value_name = "FILE", conflicts_with = "believe_at")]
    plot: Option<PathBuf>,
    /// Trace only what the scheme believes in the macro step from this time on, per micro step, from the true state; of
    /// `monolithic`, what happens
    #[arg(long, value_name = "TIME", value_parser = seconds, requires = "trace", conflicts_with_all = ["audit", "deadline_log", "all", "format"])]
    believe_at: Option<f64>,
    /// Account for the energy that the interface model creates, also in the trace
    #[arg(long)]
    audit: bool,
    /// All metrics and counters
    #[arg(long, conflicts_with = "format")]
    all: bool,
    /// How to print
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
}

impl Simulate {
    /// Exit code 1 if the run gave no answer: it was skipped, or took too long.
    pub(super) fn run(self, catalogue: &Catalogue, notes: &SideNotes) -> anyhow::Result<ExitCode> {
        let mut request = self.run.request()?;
        let wrong = |file: &PathBuf, why: String| Error::file(file, why);
        let log = match (&self.deadline_log, self.deadline) {
            (Some(file), Some(deadline)) => {
                let log = DeadlineLog::read(&read_text(file)?, deadline).map_err(|why| wrong(file, why))?;
                Some((file, log))
            }
            _ => None,
        };
        let mut asked = request.clone();
        let catalogue = with_files(catalogue, notes, &mut request.case, &mut request.scheme)?;
        if let Some((file, log)) = log {
            // For its macro steps: what comes late is what the log says.
            let bare = RunRequest { delivery_up: None, delivery_down: None, ..request.clone() };
            let spec = RunRequest { late_samples: None, late_forces: None, ..bare }.resolve(&catalogue)?;
            let grid = *spec.communication_points();
            let channel = request.delivery_up.get_or_insert_default();
            channel.check("delivery_up", grid.macro_steps())?;
            if let Some(note) = log.replay(&grid, channel).map_err(|why| wrong(file, why))? {
                eprintln!("note: {} {note}", file.display());
            }
            asked.delivery_up.clone_from(&request.delivery_up);
        }
        let spec = request.resolve(&catalogue)?;
        if let (Some(at_s), Some(path)) = (self.believe_at, &self.trace) {
            check_place_for_trace(path)?;
            let from = what_happens(&spec, &catalogue, at_s, StopFlag::never())?;
            let alone = spec.scheme.name == "monolithic";
            write_trace(path, &if alone { from.happens } else { believed(&spec, &from)? }, None)?;
            print(&format!("{}: one row per micro step from {at_s} s", path.display()))?;
            return Ok(ExitCode::SUCCESS);
        }
        let spec = if self.audit { spec.audited()? } else { spec };
        let spec = spec.with(|own| own.divide_error = true)?;
        let mut prepared = spec.prepare()?;
        let contacts = prepared.contact_names();
        // A trace that cannot be written is found before anything is computed.
        if let Some(path) = &self.trace {
            check_place_for_trace(path)?;
        }
        if let Some(path) = &self.plot {
            render::check_format(path)?;
            check_writable_file(path)?;
        }
        let stop = StopFlag::never();
        let alive = Heartbeat::of("simulate");
        let cache = Cache::of_user();
        let reference = obtain_reference(&spec, &cache, stop)?;
        warn_of_cache(&cache);
        // Waiting for another program takes no processor time, but counts against a limit.
        let clock = if waits(&spec) { monotonic_clock } else { processor_clock };
        prepared.divide(&reference, Some(clock), stop);
        // Those of the reference, and of what its error is divided by, are not of the run.
        notes.clear();
        let traced = self.trace.is_some() || self.plot.is_some();
        let run = prepared.evaluate(&reference, true, traced, Some(clock), stop)?;
        let (probed, warned) = (notes.probed(), notes.warnings());
        drop(alive);
        if let Some(path) = &self.trace {
            write_trace(path, &run.trajectory, None)?;
        }
        if let Some(path) = &self.plot {
            let styles = Styles::of(catalogue.schemes().iter().map(|scheme| &**scheme));
            render::write(&plot(&spec, &run, &reference, &styles)?, path)?;
        }
        if self.format == Format::Json {
            let mut said = json(&spec, &run, &probed);
            if !warned.is_empty() {
                said["fmu_warnings"] =
                    warned.iter().map(|(file, count)| (file.display().to_string(), *count)).collect();
            }
            print_json(&said)?;
            return Ok(answered(run.outcome.class() != OutcomeClass::NoAnswer));
        }
        let audited = self.audit.then_some(contacts);
        let said = Said { asked: &asked, spec: &spec, run: &run, reference: &reference, trace: self.trace, audited };
        print(&said.first_screen())?;
        if self.all {
            print(&tables(&spec, &run))?;
        }
        let warnings = warned.iter().map(|(file, count)| format!("{} returned Warning {count} times", file.display()));
        probe_lines(&probed).into_iter().chain(warnings).try_for_each(|line| print(&line))?;
        Ok(answered(run.outcome.class() != OutcomeClass::NoAnswer))
    }
}

/// Whether a run is timed by the wall clock.
fn waits(spec: &RunSpec) -> bool {
    spec.wall_limit.is_some() || spec.case.waits || spec.scheme.waits
}

/// Everything that determines the run, everything that was found, everything it cost.
fn json(spec: &RunSpec, run: &EvaluatedRun, probed: &BTreeMap<PathBuf, ProbeQuality>) -> Value {
    let mut object = Object::default();
    object.put("run_id", spec.id());
    spec.facts().iter().for_each(|fact| object.fact(fact));
    let mut parameters = Object::default();
    for (parameter, value) in spec.parameters.iter() {
        match value {
            ParameterValue::Number(number) => parameters.number(&*parameter.name, *number),
            ParameterValue::Choice(choice) => parameters.put(&*parameter.name, choice.as_ref()),
        }
    }
    object.put("parameters", parameters);
    let diverged = matches!(run.outcome, Outcome::Diverged { .. });
    object.number("diverged_at_s", run.outcome.at_s().filter(|_| diverged));
    let of_case: Vec<&str> = run.metrics_of(&spec.case).map(|(metric, _)| metric.name).collect();
    let findings = run.found.facts();
    let is_metric = |name: &str| METRICS.iter().any(|metric| metric.name == name);
    let shown = findings.iter().filter(|fact| of_case.contains(&fact.name) || !is_metric(fact.name));
    shown.chain(&run.costs.facts()).for_each(|fact| object.fact(fact));
    if !probed.is_empty() {
        let of_fmu = |quality: &ProbeQuality| {
            let mut object = Object::default();
            object.put("count", quality.count);
            object.number("error_p50", quality.median);
            object.number("error_max", quality.largest);
            Value::from(object)
        };
        let all = probed.iter().map(|(file, quality)| (file.display().to_string(), of_fmu(quality)));
        object.put("probed_fmus", Value::Object(all.collect()));
    }
    object.into()
}

/// What an audit says that found nothing out.
const NOT_AUDITED: &str =
    "not audited: it moves, or locks by its own friction, or a side does not tell its contact impulses";

/// What the first screen is made from.
struct Said<'a> {
    /// The request as it was typed.
    asked: &'a RunRequest,
    spec: &'a RunSpec,
    run: &'a EvaluatedRun,
    reference: &'a Reference,
    trace: Option<PathBuf>,
    /// Names of the contacts of an audited run.
    audited: Option<Vec<String>>,
}

impl Said<'_> {
    /// The verdict, the numbers that matter most, and what to do next, in at most twelve lines of 80 columns.
    fn first_screen(&self) -> String {
        let Said { spec, run, .. } = self;
        let (case, scheme, step) = (&spec.case.name, &spec.scheme.name, quantity(spec.macro_step, "s"));
        let about = format!("{case} · {scheme} · H = {step}{}", self.lateness());
        let mood = match run.outcome.class() {
            OutcomeClass::Completed => Mood::Good,
            OutcomeClass::Failed => Mood::Bad,
            OutcomeClass::NoAnswer => Mood::Open,
        };
        let verdict = match (&run.outcome, run.outcome.at_s()) {
            (Outcome::Skipped { .. }, _) => "not run".to_owned(),
            (outcome, Some(at_s)) => format!("{} at {}", outcome.name().replace('-', " "), quantity(at_s, "s")),
            (outcome, None) => outcome.name().to_owned(),
        };
        let mut lines = vec![headline(&about, &verdict, mood)];
        if run.outcome != Outcome::Completed {
            // A run goes on for some steps beyond its bounds, and its numbers with it.
            let ended = run.found.ended_at_s;
            let on = run.outcome.at_s().filter(|at_s| *at_s < ended);
            let on = on.map(|_| format!("; what follows is up to {}", quantity(ended, "s"))).unwrap_or_default();
            lines.push(format!("  {}", paragraph(&(self.why() + &on), 2)));
        }
        if spec.end() < spec.duration * (1.0 - 1e-9) && run.outcome.kind().was_run() {
            let [end, whole] = [spec.end(), spec.duration].map(|time| with_digits(time, "s", 7));
            let text = format!("at {end} of {whole}, with the last whole macro step: a side takes steps of one length");
            lines.push(row("ends", &text));
        }
        let metric = |name: &str| run.found.metric(name);
        if let Some(force) = metric("force_error_rms_n") {
            let parts = parts_of_error(spec, run);
            let between = if parts.is_empty() { "" } else { ", " };
            let peak = match metric("force_error_rms_of_peak") {
                Some(share) if run.undivided.is_none() => {
                    format!(", {} of the peak{between}{parts}", percent(share))
                }
                Some(share) => format!(", {} of the peak", percent(share)),
                None => self.reference.without_peak(&spec.case).map_or_else(String::new, |why| format!(", {why}")),
            };
            lines.push(error_row("force error", (force, "N"), &peak, run.found.reference_uncertainty[0]));
            lines.extend(run.undivided.as_ref().map(|_| row("its parts", &parts)));
        }
        if let Some(position) = metric("position_error_rms_m") {
            lines.push(error_row("position error", (position, "m"), "", run.found.reference_uncertainty[1]));
        }
        if let Some(peak) = metric("touch_down_peak_ratio").filter(|peak| peak.is_finite()) {
            let opened = match metric("lift_off_height_m") {
                Some(height) if height > STAYS_DOWN_M => format!(", lifts off {}", quantity(height, "m")),
                Some(height) if height.is_finite() => ", stays down".to_owned(),
                _ => String::new(),
            };
            lines.push(row("touch-down", &format!("peak {} of the reference's{opened}", percent(peak))));
        }
        if let Some(residual) = metric("interface_residual_j") {
            let sent = metric("work_sent_j").filter(|sent| sent.is_finite());
            let sent = sent.map(|sent| format!(", of {} sent", quantity(sent.abs(), "J"))).unwrap_or_default();
            let said = |label: &str| row(label, &format!("{} at the interface{sent}", quantity(residual.abs(), "J")));
            match residual {
                _ if run.found.ended_at_s == 0.0 => {}
                residual if !residual.is_finite() => {
                    lines.push(row("energy", "what the interface created or lost is no finite number"));
                }
                residual if residual < 0.0 => lines.push(said("energy created")),
                _ => lines.push(said("energy lost")),
            }
        }
        if let Some(contacts) = &self.audited {
            let known = metric("heaviness_max").is_some_and(|heaviness| !heaviness.is_nan());
            let whole = |name: &str, what: &str| {
                let created = metric(name).filter(|energy| *energy > 0.0)?;
                Some(format!("; {what} created {} in all", quantity(created, "J")))
            };
            let parts = [whole("created_by_mass_j", "its mass"), whole("created_by_age_j", "its age")];
            let parts: String = parts.into_iter().flatten().collect();
            lines
                .push(row("model", &if known { self.largest_jump(contacts) + &parts } else { NOT_AUDITED.to_owned() }));
        }
        if let (Some(mean), Some(most)) = (metric("trials_per_step"), metric("trials_per_step_max")) {
            let cut = metric("trials_cut").filter(|cut| *cut > 0.0);
            let cut = cut.map(|cut| format!("; {cut} macro steps were cut")).unwrap_or_default();
            let worst = metric("answer_error_max").unwrap_or(0.0);
            let text = format!(
                "asked by {} trial steps per macro step, at most {most}{cut}; its velocity was foreseen within {} of what it moved",
                quantity(mean, "-"),
                percent(worst)
            );
            lines.push(row("mechanics", &text));
        }
        let rigid = spec.parameters.iter().all(|(parameter, value)| {
            &*parameter.name != "contact_compliance_m_n" || *value == ParameterValue::Number(0.0)
        });
        let in_space = rigid && run.trajectory.columns().iter().any(|name| name.starts_with("slip_angle_"));
        if let Some(beyond) = metric("redundant_contacts_max").filter(|beyond| in_space && *beyond > 0.0) {
            let text = format!("up to {beyond} redundant: where they slide, velocities are not unique");
            lines.push(row("contacts", &text));
        }
        let runs_forward = spec.model.is_some() && spec.delivery.as_ref().is_some_and(|own| own.late.catches_up());
        if metric("late_acceleration_correlation").is_some_and(|correlation| runs_forward && correlation < 0.0) {
            let text = "free acceleration turns round while they age: compare raw";
            lines.push(row("late samples", text));
        }
        if let Some(latency) = run.costs.latency {
            let most = quantity(latency.max_s, "s");
            let late = match latency.missed_deadlines {
                0 => String::new(),
                count => format!("; {count} of {} late", run.found.work.cosim.macro_steps),
            };
            let text =
                format!("at most {most} of {} per macro step{late}, on this machine", quantity(spec.macro_step, "s"));
            lines.push(row(if waits(spec) { "wall time" } else { "processor time" }, &text));
        }
        let metrics = run.metrics_of(&spec.case).count();
        let counters = run.found.counters().len();
        let next = match (&run.outcome, &self.trace) {
            (Outcome::Completed, None) => {
                format!("--all for {metrics} metrics and {counters} counters · --trace FILE for the motion")
            }
            (Outcome::Completed, Some(file)) => {
                format!("--all for {metrics} metrics and {counters} counters · motion in {}", file.display())
            }
            _ => format!("--all for {metrics} metrics and {counters} counters"),
        };
        if run.outcome.class() == OutcomeClass::Failed {
            let request = RunRequest { macro_step_s: None, phase: None, ..self.asked.clone() };
            lines.push(command_row("next", &format!("{} limit{}", program(), typed(&request))));
        }
        lines.push(paragraph(&format!("run {} · {next}", spec.id()), 2));
        lines.join("\n")
    }

    /// How late samples and forces are.
    fn lateness(&self) -> String {
        let channels = self.spec.delivery.iter().flat_map(|late| [("samples", &late.up), ("forces", &late.down)]);
        channels.filter(|(_, late)| !late.is_in_time()).map(|(what, late)| format!(" · {what} late, {late}")).collect()
    }

    /// The jump that gained most, which bounds what the model created there, in words.
    fn largest_jump(&self, contacts: &[String]) -> String {
        let Some(Jump { time, energy, contact, by }) = self.run.largest_jump else {
            return "no jump to the mechanics gained energy".to_owned();
        };
        let name = contacts.get(contact).map_or_else(|| format!("contact {contact}"), |name| format!("the {name}"));
        let how = match by {
            Creation::Gap => "it acted across a gap",
            Creation::Pull => "bilateral while the mechanics opened it",
            Creation::Stick => "it stuck while the mechanics slid",
            Creation::Push => "the mechanics pushed it out",
        };
        format!("{name} created at most {} at {}: {how}", quantity(energy, "J"), quantity(time, "s"))
    }

    /// Why the run did not complete, in words.
    fn why(&self) -> String {
        match &self.run.outcome {
            Outcome::Diverged { quantity: name, value, .. } if value.is_finite() => {
                let column = self.reference.trajectory.index_of(name);
                let peak = column.map_or(0.0, |column| self.reference.largest[column]);
                let (_, unit) = column_in_words(name);
                let times = match peak {
                    0.0 => String::new(),
                    peak => format!(
                        ", {} times the reference's peak of {}",
                        quantity(value.abs() / peak, "-"),
                        quantity(peak, unit)
                    ),
                };
                in_words(&self.run.outcome) + &times
            }
            outcome => in_words(outcome),
        }
    }
}

/// Says what of the force error of a run is the coupling's, and what the mechanics' own step's, so that it goes on a
/// sentence, or why that is not told apart; nothing where neither is known.
pub fn parts_of_error(spec: &RunSpec, run: &EvaluatedRun) -> String {
    if let Some(why) = &run.undivided {
        return format!("not told apart: {why}");
    }
    let [Some(coupling), Some(mechanics), Some(share), Some(peak), Some(error)] = [
        "coupling_distance_rms_n",
        "mechanics_distance_rms_n",
        "coupling_share",
        "force_error_rms_of_peak",
        "force_error_rms_n",
    ]
    .map(|name| run.found.metric(name)) else {
        return String::new();
    };
    let steps = spec.mechanics_steps.within(spec.macro_step, spec.micro_step);
    let step = quantity(spec.macro_step / steps as f64, "s");
    let whole = (100.0 * share).round();
    if (0.0..=100.0).contains(&whole) {
        let own = 100.0 - whole;
        return format!("{} % of it coupling, {own} % the mechanics' own step of {step}", whole.abs());
    }
    let [coupling, mechanics] = [coupling, mechanics].map(|part| percent(part * peak / error));
    format!("coupling ({coupling}) and the mechanics' own step of {step} ({mechanics}) cancel in part")
}

/// Why a run did not complete, in words.
pub(super) fn in_words(outcome: &Outcome) -> String {
    let reached = |name: &str, value: f64| {
        let (words, unit) = column_in_words(name);
        format!("the {words} reached {}", quantity(value, unit))
    };
    match outcome {
        Outcome::Diverged { quantity: name, value, .. } if value.is_finite() => reached(name, *value),
        Outcome::Diverged { quantity: name, .. } => format!("the {} is no finite number", column_in_words(name).0),
        Outcome::OutOfRange { quantity: name, value, .. } => {
            format!("{}, outside the range of its model", reached(name, *value))
        }
        outcome => outcome.reason(),
    }
}

/// A column of a trace in words, and its unit: `actuator_force_n` is `actuator force` and `N`.
fn column_in_words(name: &str) -> (String, &'static str) {
    let (words, unit) = without_unit(name);
    (words.replace('_', " "), unit)
}

/// All metrics and counters.
fn tables(spec: &RunSpec, run: &EvaluatedRun) -> String {
    let mut metrics = Table::new(&["metric", "value", "unit"]);
    for (metric, value) in run.metrics_of(&spec.case) {
        let value = value.map_or("–".to_owned(), |value| format!("{value:.6e}"));
        metrics.add_row([metric.name, &value, metric.unit]);
    }
    let mut counters = Table::new(&["counter", "value"]);
    for fact in run.found.counters() {
        counters.add_row([fact.name.to_owned(), fact.cell()]);
    }
    for fact in run.costs.facts() {
        let cell = match fact.value {
            Some(FactValue::Number(number)) => format!("{number:.3e}"),
            _ => fact.cell(),
        };
        counters.add_row([fact.name.to_owned(), cell]);
    }
    format!("\n{metrics}\n\n{counters}")
}

/// Says an rms error, what it is in relation to, and how well the reference is known.
pub(super) fn error_row(label: &str, (error, unit): (f64, &str), relation: &str, uncertainty: Option<f64>) -> String {
    let own = uncertainty.map(|own| format!(" (reference ± {})", quantity(own, unit))).unwrap_or_default();
    row(label, &format!("{} rms{relation}{own}", quantity(error, unit)))
}
