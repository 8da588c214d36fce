//! Writes the columns of a case at each communication point, whatever side they come from.

use super::case::{Case, CoupledSystem};
use crate::cosim::{CommunicationPoint, Port, Trajectory};

/// Fills trajectory rows from communication points.
///
/// Everything a communication point shows is laid out one after the other in `seen`; a column is an index into it.
///
/// ```text
/// time | outputs of mechanics, of actuator | received | observables of mechanics, of actuator
/// ```
pub struct Recorder {
    columns: Vec<usize>,
    seen: Vec<f64>,
    /// Where each part but the time ends in `seen`.
    ends: [usize; 5],
    effective_mass: Option<usize>,
}

impl Recorder {
    /// Finds the source of each of the case's columns. A column without one is a defect of the case.
    pub fn new(case: &Case, system: &CoupledSystem) -> Self {
        let (mechanics, actuator) = (&system.mechanics, &system.actuator);
        let names_of = |ports: &[Port]| -> Vec<&'static str> { ports.iter().map(|port| port.name).collect() };
        let (y_mechanics, y_actuator) = (names_of(&mechanics.ports().outputs), names_of(&actuator.ports().outputs));
        // Of the forces received only the first has a column.
        let mut received = vec![""; y_actuator.len()];
        received.iter_mut().take(1).for_each(|name| *name = "force_to_mechanics_n");
        let parts = [&y_mechanics[..], &y_actuator, &received, mechanics.observables(), actuator.observables()];
        let mut names = vec!["time_s"];
        let ends = parts.map(|part| {
            names.extend_from_slice(part);
            names.len()
        });
        let recorded = case.recorded_columns();
        let index_of = |name: &String| {
            let index = names.iter().position(|known| known == name);
            index.unwrap_or_else(|| panic!("case {}: no source for column {name}", case.name))
        };
        Recorder {
            columns: recorded.iter().map(index_of).collect(),
            seen: vec![0.0; names.len()],
            ends,
            effective_mass: recorded.iter().position(|name| name == "effective_mass_kg"),
        }
    }

    /// Records as effective mass the one with the contacts that carried impulse in the mechanics' last step: what the
    /// reference shows, which has no scheme and no contact margin.
    pub fn with_active_effective_mass(mut self, system: &CoupledSystem) -> Self {
        let active = system.mechanics.observables().iter().position(|name| *name == "active_effective_mass_kg");
        if let (Some(column), Some(index)) = (self.effective_mass, active) {
            let [_, _, received, ..] = self.ends;
            self.columns[column] = received + index;
        }
        self
    }

    /// Appends one row. The effective mass is the scheme's own where it has one, else the smooth one of the mechanics.
    pub fn record(&mut self, point: CommunicationPoint<'_>, trajectory: &mut Trajectory) {
        let [y_mechanics, y_actuator, received, mechanics, actuator] = self.ends;
        self.seen[0] = point.time;
        self.seen[1..y_mechanics].copy_from_slice(point.y_mechanics);
        self.seen[y_mechanics..y_actuator].copy_from_slice(point.y_actuator);
        self.seen[y_actuator..received].copy_from_slice(point.received);
        point.mechanics.observe(point.mechanics_step, &mut self.seen[received..mechanics]);
        point.actuator.observe(point.mechanics_step, &mut self.seen[mechanics..actuator]);
        let row = trajectory.push_row();
        for (value, &column) in row.iter_mut().zip(&self.columns) {
            *value = self.seen[column];
        }
        if let (Some(column), Some(mass)) = (self.effective_mass, point.diagnostics.effective_mass) {
            row[column] = mass;
        }
    }
}
