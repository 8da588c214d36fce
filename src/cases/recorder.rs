//! Writes the columns of a case at each communication point, whatever side they come from.

use super::case::{Case, CoupledSystem, RowFunction};
use crate::cosim::{CommunicationPoint, Port, Trajectory};

/// Where a column comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Source {
    Time,
    MechanicsOutput(usize),
    ActuatorOutput(usize),
    Received(usize),
    MechanicsObservable(usize),
    ActuatorObservable(usize),
    Derived,
}

/// A derived column: where it goes, and where its arguments stand in the row.
struct Derived {
    column: usize,
    from: Vec<usize>,
    arguments: Vec<f64>,
    value: RowFunction,
}

/// Fills trajectory rows from communication points.
pub struct Recorder {
    sources: Vec<Source>,
    effective_mass: Option<usize>,
    mechanics: Vec<f64>,
    actuator: Vec<f64>,
    derived: Vec<Derived>,
    late_rows: bool,
    /// The row before it was made late.
    row: Vec<f64>,
}

impl Recorder {
    /// Finds the source of each of the case's columns. A column without one is a defect of the case.
    pub fn new(case: &Case, system: &mut CoupledSystem) -> Self {
        let columns = case.recorded_columns();
        let place = |wanted: &str| {
            let found = columns.iter().position(|name| name == wanted);
            found.unwrap_or_else(|| panic!("case {}: derived from {wanted}, which is not recorded", case.name))
        };
        let derived: Vec<Derived> = std::mem::take(&mut system.derived)
            .into_iter()
            .map(|derived| Derived {
                column: place(derived.name),
                from: derived.from.iter().map(|name| place(name)).collect(),
                arguments: vec![0.0; derived.from.len()],
                value: derived.value,
            })
            .collect();
        let (mechanics, actuator) = (system.mechanics.observables(), system.actuator.observables());
        let port = |ports: &[Port], name: &str| ports.iter().position(|port| port.name == name);
        let observable = |names: &[&str], name: &str| names.iter().position(|known| *known == name);
        let source_of = |name: &str| match name {
            "time_s" => Some(Source::Time),
            "force_to_mechanics_n" => Some(Source::Received(0)),
            _ if derived.iter().any(|derived| columns[derived.column] == name) => Some(Source::Derived),
            _ => port(&system.mechanics.ports().outputs, name)
                .map(Source::MechanicsOutput)
                .or_else(|| port(&system.actuator.ports().outputs, name).map(Source::ActuatorOutput))
                .or_else(|| observable(mechanics, name).map(Source::MechanicsObservable))
                .or_else(|| observable(actuator, name).map(Source::ActuatorObservable)),
        };
        Recorder {
            sources: columns
                .iter()
                .map(|name| {
                    source_of(name).unwrap_or_else(|| panic!("case {}: no source for column {name}", case.name))
                })
                .collect(),
            effective_mass: columns.iter().position(|name| name == "effective_mass_kg"),
            mechanics: vec![0.0; mechanics.len()],
            actuator: vec![0.0; actuator.len()],
            row: vec![0.0; columns.len()],
            late_rows: system.late_rows,
            derived,
        }
    }

    /// Appends one row. The effective mass is the scheme's own where it has one, else the smooth one of the mechanics.
    pub fn record(&mut self, point: CommunicationPoint<'_>, trajectory: &mut Trajectory) {
        point.mechanics.observe(point.mechanics_step, &mut self.mechanics);
        point.actuator.observe(point.mechanics_step, &mut self.actuator);
        let first = trajectory.is_empty();
        let row = trajectory.push_row();
        for (value, source) in row.iter_mut().zip(&self.sources) {
            *value = match *source {
                Source::Time => point.time,
                Source::MechanicsOutput(index) => point.y_mechanics[index],
                Source::ActuatorOutput(index) => point.y_actuator[index],
                Source::Received(index) => point.received[index],
                Source::MechanicsObservable(index) => self.mechanics[index],
                Source::ActuatorObservable(index) => self.actuator[index],
                Source::Derived => f64::NAN,
            };
        }
        for derived in &mut self.derived {
            for (argument, &column) in derived.arguments.iter_mut().zip(&derived.from) {
                *argument = row[column];
            }
            row[derived.column] = (derived.value)(&derived.arguments);
        }
        if let (Some(column), Some(mass)) = (self.effective_mass, point.diagnostics.effective_mass) {
            row[column] = mass;
        }
        if self.late_rows {
            if first {
                self.row.copy_from_slice(row);
            }
            // Everything but the time is that of the communication point before.
            row[1..].swap_with_slice(&mut self.row[1..]);
        }
    }
}
