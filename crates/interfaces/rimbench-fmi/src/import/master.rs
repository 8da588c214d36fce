//! A coupling of two FMUs as a script for FMPy, where the scheme is a hold or an extrapolation.

use super::case_file::{CaseFile, columns};
use super::host::{Plan, Scaled, Start, Type, Values};
use super::member::FmuMember;
use rimbench_core::cosim::{ForceReturn, MechanicsSteps, PerSide, Sequence, Side};
use rimbench_core::error::{Error, Result};
use rimbench_results::input::read_text;
use rimbench_runs::RunSpec;
use std::path::Path;

/// Schemes that a script has, by the degree of their polynomial.
const HOLDS: [&str; 3] = ["zero-order-hold", "first-order-hold", "second-order-hold"];

/// The parts of a script that are the same for all, between lines `# ---`: one side; the mean of a hold and that of a
/// polynomial over a micro step; a macro step up to where both sides step; reference and error. Of a side it takes: file,
/// libraries, start values, inputs (place, reference, factor, offset), outputs, unit and start of its time.
const PARTS: &str = include_str!("master.py");

/// Writes a script of at most 80 lines that couples the two FMUs of a case file as a run does, solves the reference
/// beside it, and prints the rms force error over the reference's peak; `words` say the coupling, `error` what the
/// program found.
///
/// # Errors
/// [`Error::Incompatible`] in one line for a scheme, an option or a side that such a script has not; those of reading
/// the file.
pub fn master_script(path: &Path, run: &RunSpec, words: &str, error: f64) -> Result<String> {
    let refused = |why: &str| Err(Error::Incompatible(format!("no master is written: {why}")));
    let name = &run.scheme.name;
    let Some(degree) = HOLDS.iter().position(|hold| **hold == **name) else {
        let what = match run.scheme.has_model() {
            true => "moves a model of the mechanics: `--no-model` asks for schemes without",
            false => "is more than a hold or an extrapolation",
        };
        return refused(&format!("{name} {what}; --scheme {} asks for one that it can be", HOLDS.join(", ")));
    };
    if run.delivery.is_some() || run.step_control.is_some() || run.force_return == ForceReturn::Pieces {
        return refused("it has no late samples, no step control and no force return `pieces`");
    }
    let text = read_text(path)?;
    let file = CaseFile::parse(&text).map_err(|message| Error::file(path, message))?;
    if file.actuators.len() > 1 {
        return refused("the case has several actuators");
    }
    let rows = columns(&file.interface);
    let side = |side: Side| -> Result<Plan> {
        let Some(fmu) = &file.side(side).fmu else {
            return Err(Error::Incompatible("no master is written: a side is a class of Python".to_owned()));
        };
        let fmu = rimbench_results::input::beside(path, fmu);
        let member = FmuMember::open((path, &file), &fmu, side, &rows)?;
        let feeds = side == Side::Mechanics && member.ports.direct_feedthrough;
        if feeds || !member.integrals().is_empty() {
            let why = "its mechanics has a position that is an integral, or outputs that follow its inputs at once";
            return Err(Error::Incompatible(format!("no master is written: {why}")));
        }
        member.plan(&run.parameters).map_err(Error::Incompatible)
    };
    let plans = PerSide { mechanics: side(Side::Mechanics)?, actuator: side(Side::Actuator)? };
    let all = Side::BOTH.into_iter().flat_map(|side| plans[side].inputs.iter().chain(&plans[side].outputs));
    if !all.clone().all(Scaled::is_single) {
        return refused("a coupling variable is an element of an array, or no Float64");
    }
    let taken = PerSide {
        mechanics: (0..rows.len()).collect(),
        // Positions and velocities of all rows, of which an actuator may take velocities alone.
        actuator: (0..2 * rows.len())
            .filter(|at| file.interface[at % rows.len()].end(Side::Actuator, at / rows.len()).is_some())
            .collect::<Vec<_>>(),
    };
    let (grid, reference) = (run.communication_points(), run.reference_steps());
    let said = format!("rimbench says {:.4} %", 100.0 * error);
    let header = format!(
        "# {words}\n# Couples the two FMUs of {} so, with {name}, and prints the error against a reference of its own. Needs FMPy.\n\
         import ctypes, math, numpy as np\nfrom fmpy import extract, fmi2, fmi3, read_model_description\n\
         MECHANICS = {}\nACTUATOR = {}\n\
         H, PHASE, COUNT, END, STOP, MICRO_STEP, DEGREE = {:?}, {:?}, {}, {:?}, {:?}, {:?}, {degree}\n\
         REFERENCE_STEP, REFERENCE_STEPS, REFERENCE_EVERY = {:?}, {}, {}\n",
        file.name,
        of_side(&plans.mechanics, &taken.mechanics),
        of_side(&plans.actuator, &taken.actuator),
        run.macro_step,
        run.phase,
        grid.macro_steps(),
        grid.duration(),
        run.duration,
        run.micro_step,
        reference.h,
        reference.steps,
        reference.every,
    );
    // With the mechanics first its sample at the end of the macro step is sent already, and replaced at the exchange.
    let fresh = run.sequence == Sequence::GaussSeidel { first: Side::Mechanics };
    let again = if fresh { "[old for old in sent_m if old[0] != t][:DEGREE]" } else { "sent_m[:DEGREE]" };
    let parts: Vec<&str> = PARTS.split("# ---\n").collect();
    let [side, hold, polynomial, exchange, end] = parts[..] else { unreachable!("master.py has five parts") };
    let exchange = exchange.replace("KEPT", again);
    let mean = if degree == 0 { hold } else { polynomial };
    let (actuator, mechanics) = (actuator(run), mechanics(run));
    let steps = if fresh { mechanics + SEND + &actuator } else { actuator + &mechanics };
    let last = format!("print(f\"rms force error {{100 * error:.4f}} % of the peak; {said}\")\n");
    Ok(header + side + mean + &exchange + &steps + end + &last)
}

/// The mechanics' sample at the end of its steps, for an actuator that goes second.
const SEND: &str = "        sent_m = [(times[k + 1], mechanics.read(force))] + sent_m[:DEGREE]\n";

/// The steps of the actuator in a macro step.
fn actuator(run: &RunSpec) -> String {
    let averages = matches!(run.force_return, ForceReturn::Mean | ForceReturn::Profile);
    let (pushed, push) = match averages {
        true => (", pushed", "            pushed.append(actuator.read(motion))\n"),
        false => ("", ""),
    };
    let begin = if averages { ", []" } else { "" };
    let end = if run.force_return == ForceReturn::End { "        force = actuator.read(motion)\n" } else { "" };
    format!(
        "        n{pushed} = division(length, MICRO_STEP){begin}\n        for j in range(n):\n            start, h = t + j * (length / n), length / n\n\
         {push}            motion = mean(sent_m, start, start + h)\n            actuator.step(start, motion, h)\n{end}"
    )
}

/// The steps of the mechanics in a macro step.
fn mechanics(run: &RunSpec) -> String {
    let count = match run.mechanics_steps {
        MechanicsSteps::Count(count) => count.to_string(),
        MechanicsSteps::AsActuator => "division(length, MICRO_STEP)".to_owned(),
        MechanicsSteps::AtMost(step) => format!("division(length, {step:?})"),
    };
    let force = match run.force_return {
        ForceReturn::End => "",
        ForceReturn::Mean => "            force = np.mean(pushed, axis=0)\n",
        ForceReturn::Held => "            force = mean(sent_a, start, start + h)\n",
        ForceReturn::Profile | ForceReturn::Pieces => {
            "            of = lambda i, w: max(0, min(i + 1, (j + 1) * w) - max(i, j * w)) / w\n            \
             force = sum(of(i, len(pushed) / n) * own for i, own in enumerate(pushed))\n"
        }
    };
    format!(
        "        n = {count}\n        for j in range(n):\n            start, h = t + j * (length / n), length / n\n{force}            \
         mechanics.step(start, force, h)\n"
    )
}

/// One side as a literal of Python.
fn of_side(plan: &Plan, taken: &[usize]) -> String {
    let text = |path: &Path| python(&std::path::absolute(path).unwrap_or(path.to_owned()).to_string_lossy());
    let needs: Vec<String> = plan.needs.iter().map(|library| python(&library.to_string_lossy())).collect();
    let starts = plan.starts.iter().map(|Start { reference, kind, values, .. }| {
        let name = match (kind, plan.version_2) {
            (Type::Text, _) => "String".to_owned(),
            (Type::Float64, true) => "Real".to_owned(),
            (Type::Boolean, _) => "Boolean".to_owned(),
            (_, true) => "Integer".to_owned(),
            (kind, false) => format!("{kind:?}"),
        };
        let values: Vec<String> = match values {
            Values::Numbers(values) => values.iter().map(|value| format!("{value:?}")).collect(),
            Values::Whole(values) => values.iter().map(i64::to_string).collect(),
            Values::Truths(values) => {
                values.iter().map(|value| if *value { "True" } else { "False" }.to_owned()).collect()
            }
            Values::Texts(values) => values.iter().map(|value| python(value)).collect(),
        };
        format!("({name:?}, {reference}, [{}])", values.join(", "))
    });
    let inputs = plan.inputs.iter().zip(taken).map(|(Scaled { reference, factor, offset, .. }, place)| {
        format!("({place}, {reference}, {factor:?}, {offset:?})")
    });
    let outputs = plan
        .outputs
        .iter()
        .map(|Scaled { reference, factor, offset, .. }| format!("({reference}, {factor:?}, {offset:?})"));
    let list = |items: Vec<String>| format!("[{}]", items.join(", "));
    format!(
        "({}, {}, {}, {}, {}, {:?}, {:?})",
        text(&plan.file),
        list(needs),
        list(starts.collect()),
        list(inputs.collect()),
        list(outputs.collect()),
        plan.time_unit,
        plan.begin
    )
}

/// A text as a literal of Python.
fn python(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}
