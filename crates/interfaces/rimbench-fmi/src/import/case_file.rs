//! A case file that names FMUs.

use rimbench_cases::parameter::{Parameter, Range};
use rimbench_core::cosim::{Every, ForceReturn, MicroSteps, Partition, Side, StarPlan};
use rimbench_core::error::Error;
use rimbench_core::name::check_new_name;
use rimbench_results::text_place::said_at;
use rimbench_runs::is_taken;
use serde::Deserialize;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{self, Deserializer, MapAccess, SeqAccess, Visitor};
use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

/// A case file as it is written.
#[derive(Debug, Clone, Deserialize)]
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
    /// One, or several with rows of their own.
    #[serde(rename = "actuator", deserialize_with = "one_or_several")]
    pub(super) actuators: Vec<SideTable>,
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
        file.check_rows()?;
        let of_python = file.tables().any(|(_, table)| table.python.is_some());
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
        let own = self.tables().flat_map(|(name, table)| {
            let steps = [("probe_step_s", table.probe_step_s), ("micro_step_s", table.micro_step_s)];
            steps.into_iter().filter_map(move |(key, step)| Some(time(&format!("{key} of {name}"), step?)))
        });
        let magnitude = |(key, value)| (format!("{key} of scale"), value, "a finite number above 0");
        let scale = self.scale.iter().flat_map(|of| {
            [("position_m", of.position_m), ("velocity_m_s", of.velocity_m_s), ("force_n", of.force_n)].map(magnitude)
        });
        let positive = times.into_iter().flatten().chain(own).chain(scale);
        let valid = format!("a finite time of at least {SHORTEST_ANSWER} s");
        positive
            .map(|(key, value, valid)| (key, value, 0.0, valid.to_owned()))
            .chain([("answer_within_s".to_owned(), self.answer_within_s, SHORTEST_ANSWER, valid)])
            .collect()
    }

    /// Refuses paths that are empty, and factors that make nothing of a variable.
    fn check_names_and_factors(&self) -> Result<(), String> {
        for (name, SideTable { fmu, python, needs, .. }) in self.tables() {
            let named = [("fmu", fmu.iter()), ("python", python.iter())];
            let named = named.into_iter().flat_map(|(key, paths)| paths.map(move |path| (key, path)));
            let mut named = named.chain(needs.iter().map(|path| ("needs", path)));
            if let Some((key, path)) = named.find(|(_, path)| path.as_os_str().is_empty()) {
                let key = format!("{key} of {name}");
                return Err(Error::invalid(key, path.display(), "the path of a file").to_string());
            }
        }
        for side in Side::BOTH {
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

    /// The table of a side; of several actuators the first, which is all that a [`part`](Self::part) has.
    pub(super) fn side(&self, side: Side) -> &SideTable {
        if side == Side::Mechanics { &self.mechanics } else { &self.actuators[0] }
    }

    /// All tables of sides, as they are called.
    fn tables(&self) -> impl Iterator<Item = (String, &SideTable)> {
        let mechanics = ("[mechanics]".to_owned(), &self.mechanics);
        std::iter::once(mechanics).chain(self.actuators.iter().enumerate().map(|(at, table)| (self.named(at), table)))
    }

    /// What an actuator is called.
    pub(super) fn named(&self, at: usize) -> String {
        if self.actuators.len() == 1 { "[actuator]".to_owned() } else { format!("[[actuator]] {}", at + 1) }
    }

    /// The rows of an actuator, from 0.
    pub(super) fn rows_of(&self, at: usize) -> Vec<usize> {
        let given = self.actuators[at].rows.as_ref().filter(|_| self.actuators.len() > 1);
        given.map_or_else(|| (0..self.interface.len()).collect(), |rows| rows.iter().map(|row| row - 1).collect())
    }

    /// The file as if it had this actuator and its rows alone.
    pub(super) fn part(&self, at: usize) -> Self {
        let (own, table) = (self.rows_of(at), self.actuators[at].clone());
        let of_actuator = |(name, table): (&String, &ParameterTable)| {
            let actuator = table.actuator.as_ref().and_then(|names| names.of(at)).map(Names::All);
            (name.clone(), ParameterTable { actuator, ..table.clone() })
        };
        CaseFile {
            interface: own.iter().map(|row| self.interface[*row].clone()).collect(),
            micro_step_s: table.micro_step_s.or(self.micro_step_s),
            parameters: self.parameters.iter().map(of_actuator).collect(),
            actuators: vec![table],
            ..self.clone()
        }
    }

    /// Checks that each row has one actuator, and each actuator a step that goes with the others'.
    fn check_rows(&self) -> Result<(), String> {
        let (count, n) = (self.actuators.len(), self.interface.len());
        let mut of_row: Vec<Option<usize>> = vec![None; n];
        for (at, SideTable { rows, every, micro_step_s, .. }) in self.actuators.iter().enumerate() {
            let name = self.named(at);
            if count == 1 {
                let given =
                    [("rows", rows.is_some()), ("every", every.is_some()), ("micro_step_s", micro_step_s.is_some())];
                return given.iter().find(|(_, given)| *given).map_or(Ok(()), |(key, _)| {
                    Err(format!(
                        "{key} of [actuator] is not valid; valid: none, for it has all rows (several are [[actuator]])"
                    ))
                });
            }
            let valid = format!("numbers from 1 to {n}, ascending, of which no other actuator has one, as rows = [1]");
            let Some(rows) = rows.as_ref().filter(|rows| !rows.is_empty()) else {
                return Err(format!("{name} has no rows; valid: {valid}"));
            };
            if !rows.iter().all(|row| (1..=n).contains(row)) || !rows.is_sorted_by(|a, b| a < b) {
                return Err(Error::invalid(format!("rows of {name}"), format!("{rows:?}"), valid).to_string());
            }
            for &row in rows {
                if let Some(other) = of_row[row - 1].replace(at) {
                    return Err(format!(
                        "row {row} of [[interface]] is in rows of {} and of {name}; valid: {valid}",
                        self.named(other)
                    ));
                }
            }
            if let Some(step) = micro_step_s.filter(|step| *step > self.macro_step_s) {
                let valid = format!("at most macro_step_s, {} s", self.macro_step_s);
                return Err(Error::invalid(format!("micro_step_s of {name}"), step, valid).to_string());
            }
            let rate = every.as_ref().map_or(Ok(()), |rate| rate.to_string().parse::<Every>().map(drop));
            rate.map_err(|error| format!("{name}: {error}"))?;
        }
        if let Some(row) = of_row.iter().position(Option::is_none) {
            return Err(format!("row {} of [[interface]] is in rows of no [[actuator]]; valid: of one", row + 1));
        }
        self.bonds()
            .map_or(Ok(()), |plan| plan.check(n, (ForceReturn::Mean, 1.0)))
            .map_err(|error| error.to_string())?;
        self.parameters.iter().try_for_each(|(name, table)| match &table.actuator {
            Some(Names::Each(names)) if names.len() != count => Err(format!(
                "[parameters.{name}] actuator = {names:?} is not valid; valid: a variable that all {count} have, or a list of {count}, \"\" for none"
            )),
            _ => Ok(()),
        })
    }

    /// The bonds that runs of the case have unless they say otherwise, where its actuators have steps of their own.
    pub(super) fn bonds(&self) -> Option<StarPlan> {
        let own = |table: &SideTable| table.every.is_some() || table.micro_step_s.is_some();
        if !self.actuators.iter().any(own) {
            return None;
        }
        let each = |of: &dyn Fn(&SideTable) -> Option<String>| -> String {
            self.actuators.iter().filter_map(of).collect::<Vec<_>>().join(",")
        };
        let every = each(&|table| Some(table.every.as_ref().map_or_else(|| "1".to_owned(), Rate::to_string)));
        let usual = self.micro_step_s();
        let steps = each(&|table| Some(table.micro_step_s.unwrap_or(usual).to_string()));
        let has_steps = self.actuators.iter().any(|table| table.micro_step_s.is_some());
        Some(StarPlan {
            partition: Partition::Of((0..self.actuators.len()).map(|at| self.rows_of(at)).collect()),
            every: every.parse().ok()?,
            micro_steps: if has_steps { steps.parse().ok()? } else { MicroSteps::default() },
            ..StarPlan::default()
        })
    }
}

/// Reads a table, or tables.
fn one_or_several<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<SideTable>, D::Error> {
    struct Tables;
    impl<'de> Visitor<'de> for Tables {
        type Value = Vec<SideTable>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("[actuator], or [[actuator]] several times")
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
            SideTable::deserialize(MapAccessDeserializer::new(map)).map(|table| vec![table])
        }

        fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Self::Value, A::Error> {
            let tables = Vec::deserialize(SeqAccessDeserializer::new(seq))?;
            if tables.is_empty() { Err(de::Error::custom("no actuator; valid: at least one")) } else { Ok(tables) }
        }
    }
    from.deserialize_any(Tables)
}

/// Macro steps of the hub in the step of a bond, as a number or as text.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged, expecting = "valid: a whole number from 1 on, or \"1/n\"")]
pub(super) enum Rate {
    Count(u32),
    Text(String),
}

impl fmt::Display for Rate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Rate::Count(count) => count.fmt(f),
            Rate::Text(text) => text.fmt(f),
        }
    }
}

/// A variable of all actuators, or one of each.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged, expecting = "valid: the name of a variable, or a list with one for each actuator, \"\" for none")]
pub(super) enum Names {
    All(String),
    Each(Vec<String>),
}

impl Names {
    /// That of an actuator.
    pub(super) fn of(&self, at: usize) -> Option<String> {
        match self {
            Names::All(name) => Some(name.clone()),
            Names::Each(names) => names.get(at).filter(|name| !name.is_empty()).cloned(),
        }
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

#[derive(Debug, Clone, Deserialize)]
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
    /// Of one of several actuators: its rows of the interface, from 1.
    pub(super) rows: Option<Vec<usize>>,
    /// Likewise: macro steps in its step.
    pub(super) every: Option<Rate>,
    /// Likewise: its longest step, s.
    pub(super) micro_step_s: Option<f64>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Row {
    pub(super) columns: Option<[String; 3]>,
    pub(super) mechanics: Ends,
    pub(super) actuator: Ends,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Ends {
    /// None: the side knows velocity and force alone.
    pub(super) position: Option<End>,
    pub(super) velocity: End,
    pub(super) force: End,
}

/// A variable, and what its value is multiplied by besides its unit.
#[derive(Debug, Clone, Deserialize)]
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

#[derive(Debug, Clone, Deserialize)]
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
    pub(super) actuator: Option<Names>,
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
            // The actuator takes no position: any value will do.
            None if self.actuator.position.is_none() => Ok(Some(0.0)),
            None => Err("the mechanics has no position, and the actuator takes one; valid: position = \"…\", or position = { start = … }, \
                         from which it is the integral of the velocity".to_owned()),
            _ => Ok(None),
        }
    }
}
