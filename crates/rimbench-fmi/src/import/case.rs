//! The case that a case file and its FMUs make.

use super::case_file::{CaseFile, ProcessKind, SHORTEST_ANSWER, check_parameter, columns, parameters};
use super::member::{FmuMember, Process};
use crate::export::side_name;
use rimbench_cases::cases::{Case, CaseDefaults, CoupledSystem, InterfaceColumns, Parameters, PossibleSteps};
use rimbench_core::cosim::{PerSide, Side, check_coupling};
use rimbench_core::error::{Error, Result};
use rimbench_core::name::{Name, check_new_name};
use rimbench_core::solver_entry::SolverEntry;
use rimbench_results::checksums::hex;
use rimbench_results::input::read_text;
use rimbench_results::text_place::said_at;
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

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
    let digest = hex(&hash.finalize()[..8]);
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
