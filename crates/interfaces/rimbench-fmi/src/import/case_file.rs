//! A case file that names two FMUs.

use crate::export::side_name;
use rimbench_cases::cases::{Parameter, Range};
use rimbench_cases::runs::is_taken;
use rimbench_core::cosim::Side;
use rimbench_core::error::Error;
use rimbench_core::name::check_new_name;
use rimbench_results::text_place::said_at;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A case file as it is written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CaseFile {
    pub(super) name: String,
    /// One line.
    #[serde(default)]
    pub(super) about: String,
    /// Simulated time, s.
    pub(super) duration_s: f64,
    /// Usual H, s.
    pub(super) macro_step_s: f64,
    /// Longest step of the actuator, s.
    pub(super) micro_step_s: Option<f64>,
    /// Coarsest of the three steps of the reference, s.
    pub(super) reference_step_s: Option<f64>,
    /// Magnitudes of the motion at the interface, below a share of which a force or a motion is nothing.
    pub(super) scale: Option<ScaleTable>,
    #[serde(default)]
    pub(super) process: ProcessKind,
    /// After so long without an answer a process is ended, s.
    #[serde(default = "minute")]
    pub(super) answer_within_s: f64,
    pub(super) mechanics: SideTable,
    pub(super) actuator: SideTable,
    pub(super) interface: Vec<Row>,
    #[serde(default)]
    pub(super) parameters: BTreeMap<String, ParameterTable>,
}

impl CaseFile {
    /// Reads the text of a case file and checks what needs no FMU.
    ///
    /// # Errors
    /// What is wrong, where, and what would be valid.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let file: CaseFile = toml::from_str(text)
            .map_err(|error| format!("is no case of FMUs: {}", said_at(text, error.span(), error.message())))?;
        check_new_name("case", &file.name, std::iter::empty()).map_err(|error| error.to_string())?;
        for (key, value, least, valid) in file.numbers() {
            if !(value.is_finite() && value > 0.0 && value >= least) {
                return Err(Error::invalid(key, value, valid).to_string());
            }
        }
        if file.micro_step_s() > file.macro_step_s {
            let valid = format!("at most macro_step_s, {} s", file.macro_step_s);
            return Err(Error::invalid("micro_step_s", file.micro_step_s(), valid).to_string());
        }
        file.parameters.iter().try_for_each(|(name, table)| check_parameter(name, table))?;
        if file.interface.is_empty() {
            return Err("has no [[interface]]: at least one row couples the two sides".to_owned());
        }
        file.check_names_and_factors()?;
        let of_python = Side::BOTH.into_iter().any(|side| file.side(side).python.is_some());
        let unused = |table: &&ParameterTable| table.mechanics.is_none() && table.actuator.is_none();
        match file.parameters.iter().find(|(_, table)| !of_python && unused(table)) {
            Some((name, _)) => {
                Err(format!("[parameters.{name}] names no variable: mechanics = \"…\" or actuator = \"…\""))
            }
            None => Ok(file),
        }
    }

    /// Its times and magnitudes: key, value, least value, what is valid.
    fn numbers(&self) -> Vec<(String, f64, f64, String)> {
        let time = |key: &str, value| (key.to_owned(), value, "a finite time above 0 s");
        let times = [
            Some(time("duration_s", self.duration_s)),
            Some(time("macro_step_s", self.macro_step_s)),
            self.micro_step_s.map(|step| time("micro_step_s", step)),
            self.reference_step_s.map(|step| time("reference_step_s", step)),
        ];
        let probes = Side::BOTH.into_iter().filter_map(|side| {
            Some(time(&format!("probe_step_s of [{}]", side_name(side)), self.side(side).probe_step_s?))
        });
        let magnitude = |(key, value)| (format!("{key} of scale"), value, "a finite number above 0");
        let scale = self.scale.iter().flat_map(|of| {
            [("position_m", of.position_m), ("velocity_m_s", of.velocity_m_s), ("force_n", of.force_n)].map(magnitude)
        });
        let positive = times.into_iter().flatten().chain(probes).chain(scale);
        let valid = format!("a finite time of at least {SHORTEST_ANSWER} s");
        positive
            .map(|(key, value, valid)| (key, value, 0.0, valid.to_owned()))
            .chain([("answer_within_s".to_owned(), self.answer_within_s, SHORTEST_ANSWER, valid)])
            .collect()
    }

    /// Refuses paths that are empty, and factors that make nothing of a variable.
    fn check_names_and_factors(&self) -> Result<(), String> {
        for side in Side::BOTH {
            let SideTable { fmu, python, needs, .. } = self.side(side);
            let named = [("fmu", fmu.iter()), ("python", python.iter())];
            let named = named.into_iter().flat_map(|(key, paths)| paths.map(move |path| (key, path)));
            let mut named = named.chain(needs.iter().map(|path| ("needs", path)));
            if let Some((key, path)) = named.find(|(_, path)| path.as_os_str().is_empty()) {
                let key = format!("{key} of [{}]", side_name(side));
                return Err(Error::invalid(key, path.display(), "the path of a file").to_string());
            }
            let ends = self.interface.iter().flat_map(|row| (0..3).filter_map(move |which| row.end(side, which)));
            for (variable, factor) in ends {
                if let Some(factor) = factor.filter(|factor| !factor.is_finite() || *factor == 0.0) {
                    let key = format!("factor of `{variable}`");
                    return Err(Error::invalid(key, factor, "a finite number but 0").to_string());
                }
            }
        }
        Ok(())
    }

    /// Longest step of the actuator, s.
    pub(super) fn micro_step_s(&self) -> f64 {
        self.micro_step_s.unwrap_or(self.macro_step_s)
    }

    pub(super) fn side(&self, side: Side) -> &SideTable {
        if side == Side::Mechanics { &self.mechanics } else { &self.actuator }
    }
}

fn minute() -> f64 {
    60.0
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ScaleTable {
    pub(super) position_m: f64,
    pub(super) velocity_m_s: f64,
    pub(super) force_n: f64,
}

#[derive(Debug, Default, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ProcessKind {
    /// Each FMU in a process of its own.
    #[default]
    Own,
    /// In this one: faster, and a crash ends everything.
    Same,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SideTable {
    /// The file of an FMU, relative to this one.
    pub(super) fmu: Option<PathBuf>,
    /// Instead of an FMU: a file with a class of Python, relative to this one.
    pub(super) python: Option<PathBuf>,
    /// The class in it.
    pub(super) class: Option<String>,
    /// Whether the log of the FMU is switched on, and shown as it comes.
    #[serde(default)]
    pub(super) log: bool,
    /// Libraries whose symbols the FMU takes for granted, loaded before it.
    #[serde(default)]
    pub(super) needs: Vec<PathBuf>,
    /// Values that are set before a run.
    #[serde(default)]
    pub(super) start: BTreeMap<String, toml::Value>,
    /// Variables that become columns.
    #[serde(default)]
    pub(super) observe: Vec<String>,
    /// The variable that counts the work received, an energy.
    pub(super) interface_work: Option<String>,
    /// Whether outputs follow inputs at once.
    pub(super) direct_feedthrough: Option<bool>,
    /// The longest step by which an FMU without derivatives is probed, s; a mechanics' own step if not given.
    pub(super) probe_step_s: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Row {
    pub(super) columns: Option<[String; 3]>,
    pub(super) mechanics: Ends,
    pub(super) actuator: Ends,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Ends {
    /// None: the side knows velocity and force alone.
    pub(super) position: Option<End>,
    pub(super) velocity: End,
    pub(super) force: End,
}

/// A variable, and what its value is multiplied by besides its unit.
#[derive(Debug, Deserialize)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "valid: the name of a variable, or { variable = \"…\", factor = … }; for the position of a mechanics { start = … } as well"
)]
pub(super) enum End {
    Plain(String),
    /// The integral of the velocity, from this position on, m.
    Integral {
        start: f64,
    },
    Scaled {
        variable: String,
        factor: f64,
    },
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ParameterTable {
    pub(super) default: f64,
    #[serde(default)]
    pub(super) unit: String,
    #[serde(default)]
    pub(super) about: String,
    /// The variable of that side that takes it.
    pub(super) mechanics: Option<String>,
    /// The variable of that side that takes it.
    pub(super) actuator: Option<String>,
}

/// The parameter that says what a case is made from.
pub(super) const DIGEST: &str = "fmu_digest";

/// Shortest time that a process is given for an answer, s.
const SHORTEST_ANSWER: f64 = 1e-3;

/// Checks what of a parameter needs no FMU.
fn check_parameter(name: &str, table: &ParameterTable) -> Result<(), String> {
    if name == DIGEST {
        return Err(format!("[parameters.{name}]: that name is taken by the hash of FMUs"));
    }
    if is_taken(name) {
        return Err(format!(
            "[parameters.{name}]: an option of a run or a column of results has that name; valid: another"
        ));
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
pub(super) fn columns(rows: &[Row]) -> Vec<[String; 3]> {
    let named = rows.iter().enumerate().map(|(index, row)| {
        let number = if rows.len() == 1 { String::new() } else { format!("_{}", index + 1) };
        let usual = || ["position", "velocity", "force"].iter().zip(["m", "m_s", "n"]);
        let usual = usual().map(|(name, unit)| format!("interface{number}_{name}_{unit}")).collect::<Vec<_>>();
        row.columns.clone().unwrap_or_else(|| std::array::from_fn(|at| usual[at].clone()))
    });
    named.collect()
}

/// Parameters of a case: those of its file, and one that says what it is made from, so that results of other FMUs are
/// not taken for its.
pub(super) fn parameters(file: &CaseFile, digest: String) -> Vec<Parameter> {
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
    fn ends(&self, side: Side) -> &Ends {
        if side == Side::Mechanics { &self.mechanics } else { &self.actuator }
    }

    /// What a side calls one of its variables (0: position, 1: velocity, 2: force), and what that is multiplied by, if
    /// that is said; none: the side has no such variable.
    pub(super) fn end(&self, side: Side, which: usize) -> Option<(&str, Option<f64>)> {
        let ends = self.ends(side);
        match [ends.position.as_ref(), Some(&ends.velocity), Some(&ends.force)][which]? {
            End::Plain(variable) => Some((variable, None)),
            End::Scaled { variable, factor } => Some((variable, Some(*factor))),
            End::Integral { .. } => None,
        }
    }

    /// Where the integral of the velocity starts, m, where that is the position of the mechanics.
    ///
    /// # Errors
    /// An integral that is none, or a start that is missing or no number.
    pub(super) fn integral(&self) -> Result<Option<f64>, String> {
        let integral = |end: &Option<End>| matches!(end, Some(End::Integral { .. }));
        let no_integral =
            [&self.mechanics.velocity, &self.mechanics.force, &self.actuator.velocity, &self.actuator.force];
        if no_integral.into_iter().any(|end| matches!(end, End::Integral { .. })) || integral(&self.actuator.position) {
            return Err("{ start = … } stands for the position of the mechanics alone, which is then the integral of its velocity".to_owned());
        }
        match &self.mechanics.position {
            Some(End::Integral { start }) if start.is_finite() => Ok(Some(*start)),
            Some(End::Integral { start }) => Err(format!("position = {{ start = {start} }} is not valid; valid: a finite number")),
            // Nobody looks at it.
            None if self.actuator.position.is_none() => Ok(Some(0.0)),
            None => Err("the mechanics has no position, and the actuator takes one; valid: position = \"…\", or position = { start = … }, \
                         from which it is the integral of the velocity".to_owned()),
            _ => Ok(None),
        }
    }
}
