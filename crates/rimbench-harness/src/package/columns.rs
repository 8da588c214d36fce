//! What stands in the columns of result files: kind, unit, and what it is.

use crate::claims::CLAIM_COLUMNS;
use rimbench_cases::cases::{unit_of, without_unit};
use rimbench_cases::metrics::METRICS;
use rimbench_cases::runs::RunRequest;
use rimbench_core::mechanics::CONTACT_STATE;

/// What the cells of a column are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Text,
    Number,
    Integer,
    Boolean,
}

impl Kind {
    /// Its name in a Table Schema.
    pub(super) fn name(self) -> &'static str {
        match self {
            Kind::Text => "string",
            Kind::Number => "number",
            Kind::Integer => "integer",
            Kind::Boolean => "boolean",
        }
    }
}

/// A column of a result file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Column {
    pub(super) kind: Kind,
    /// `-` for a pure number; empty for a text.
    pub(super) unit: String,
    pub(super) about: String,
}

use Kind::{Boolean, Integer, Number, Text};

/// What every table may have besides settings and metrics.
const KNOWN: [(&str, Kind, &str); 56] = [
    ("run_id", Text, "Identifies what determines the run: 16 hexadecimal digits of a hash"),
    ("label", Text, "Name of the scheme's row in the experiment file"),
    ("set", Text, "Parameters of the case that were set, by name"),
    ("outcome", Text, "How the run ended; only what is `completed` reached its end within bounds"),
    ("outcome_at_s", Number, "Simulated time at which the run diverged or failed"),
    ("reason", Text, "Why it did not complete"),
    ("ended_at_s", Number, "Time of the last communication point reached"),
    ("model_exact", Boolean, "Whether the reduced interface model was the mechanics itself"),
    ("reference_force_uncertainty_n", Number, "Rms uncertainty of the reference's interface force"),
    ("reference_position_uncertainty_m", Number, "Rms uncertainty of the reference's interface position"),
    ("macro_steps", Integer, "Macro steps taken"),
    ("repeated_macro_steps", Integer, "Macro steps that were taken back and repeated"),
    ("exchanges", Integer, "Exchanges between the two sides"),
    ("mechanics_micro_steps", Integer, "Steps of the mechanics"),
    ("actuator_micro_steps", Integer, "Micro steps of the actuator"),
    ("eliminations", Integer, "Reduced interface models made"),
    ("mechanics_lcp_solves", Integer, "Contact problems that the mechanics solved"),
    ("mechanics_lcp_pivots", Integer, "Pivots or changes of the active set in them"),
    ("mechanics_lcp_factorisations", Integer, "Factorisations in them"),
    ("mechanics_lcp_fallbacks", Integer, "Those that the fallback had to solve"),
    ("scheme_lcp_solves", Integer, "Contact problems that the scheme solved"),
    ("scheme_lcp_pivots", Integer, "Pivots or changes of the active set in them"),
    ("scheme_lcp_factorisations", Integer, "Factorisations in them"),
    ("scheme_lcp_fallbacks", Integer, "Those that the fallback had to solve"),
    ("scheme_parametric_steps", Integer, "Micro steps that went on with the last active set, without solving"),
    ("audit", Text, "Whether there is an account of what the interface model created"),
    ("wall_limit_s", Number, "Wall time that the run was given and that was not enough"),
    ("trace", Text, "File of its trace below `traces/`"),
    ("wall_s", Number, "Wall time of the macro loop, on the machine of `provenance.csv`"),
    ("real_time_factor", Number, "Simulated time over wall time"),
    ("latency_p50_s", Number, "Median wall time of a macro step"),
    ("latency_p99_s", Number, "99th percentile of the wall time of a macro step"),
    ("latency_max_s", Number, "Longest wall time of a macro step"),
    ("missed_deadlines", Integer, "Macro steps that took longer than they simulate"),
    ("git_revision", Text, "Revision of the source that was built"),
    ("git_dirty", Text, "Whether the source had changes that are not in that revision"),
    ("lock_hash", Text, "Hash of the lock file of dependencies"),
    ("version", Text, "Version of rimbench"),
    ("rustc", Text, "Compiler"),
    ("cpu", Text, "Processor"),
    ("load_1_min", Number, "Load average of the machine over a minute when the run ended; its own threads count"),
    ("target", Text, "Target triple"),
    ("target_cpu", Text, "Processor that the compiler was told to build for"),
    ("governor", Text, "How the processor's frequency is governed, where the machine tells"),
    ("other_load", Number, "Processors that other programs kept busy"),
    ("machine_load", Text, "Whether times of this run may be compared: `quiet`, `loaded` or `unknown`"),
    ("parameter", Text, "Parameter of the case"),
    ("value", Text, "Its value: a number or a choice"),
    ("unit", Text, "Its unit"),
    ("source", Text, "Where the value comes from"),
    ("interface_frequency_rad_s", Number, "Frequency ω of the coupling linearised at the start; Ω = H ω"),
    ("interface_damping_ratio", Number, "Its damping ratio ζ, of the actuator's feedthrough"),
    ("rejected_draws", Number, "Draws rejected before a setting that has the event asked for; empty where none is"),
    ("column", Text, "Column of the trajectory"),
    ("rms_uncertainty", Number, "Rms uncertainty of the reference in this column, in its unit"),
    ("observed_order", Number, "Order at which its refinements approach each other"),
    ("finest_step_s", Number, "Finest step of the reference"),
];

/// Settings that are numbers without a unit.
const PURE: [&str; 3] = ["gain", "phase", "step_tolerance"];

/// A column of `runs.csv`, `cost.csv`, `provenance.csv`, `parameters.csv`, `settings.csv`, `reference.csv` or `claims.csv`; none for a name that none
/// of them has.
pub(super) fn column(name: &str) -> Option<Column> {
    if let Some(metric) = METRICS.iter().find(|metric| metric.name == name) {
        return Some(Column { kind: Number, unit: metric.unit.to_owned(), about: metric.about.to_owned() });
    }
    let of = |kind: Kind, about: &str| {
        let unit = if kind == Text { "" } else { unit_of(name) };
        Column { kind, unit: unit.to_owned(), about: about.to_owned() }
    };
    if let Some((_, kind, about)) = KNOWN.iter().find(|known| known.0 == name) {
        return Some(of(*kind, about));
    }
    if let Some((_, is_number, about)) = CLAIM_COLUMNS.iter().find(|known| known.0 == name) {
        return Some(of(if *is_number { Number } else { Text }, about));
    }
    let option = RunRequest::OPTIONS.iter().find(|option| option.key == name)?;
    let number = PURE.contains(&name) || unit_of(name) != "-";
    Some(of(if number { Number } else { Text }, option.about))
}

/// A column of a trace: all of them are numbers, and their names say what they are.
pub(super) fn trace_column(name: &str) -> Column {
    let words = without_unit(name).0.replace('_', " ");
    let about = match name {
        "time_s" => "Time of the communication point".to_owned(),
        _ if name.starts_with(CONTACT_STATE) => format!("{words}: 0 open, 1 sticks, 2 slides forwards, 3 backwards"),
        _ => words,
    };
    Column { kind: Number, unit: unit_of(name).to_owned(), about }
}
