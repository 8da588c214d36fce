//! Writes the columns of a case at each communication point, whatever side they come from.

use super::case::{Case, CoupledSystem, RowFunction};
use rimbench_core::cosim::{CommunicationPoint, Port, Report, Subsystem, Trajectory};
use rimbench_core::error::{Error, Result};
use rimbench_core::name::Name;

/// Columns of an audited run, behind those of its case: what the model has created so far, and how much heavier it was
/// before.
pub const AUDIT_COLUMNS: [&str; 2] = ["created_j", "heaviness"];

/// The column of a run of several bonds, behind those of its case.
pub const LAMBDA_COLUMN: &str = "interface_lambda";

/// How the name of a column begins that is a coordinate of the mechanics; its index follows.
const COORDINATE: &str = "coordinate_";

/// The column of a coordinate of the mechanics: recorded where a case asks for it, whatever its mechanics names.
pub fn coordinate_column(index: usize) -> String {
    format!("{COORDINATE}{index}")
}

/// A derived column: where it goes, and where its arguments stand in the row.
struct Derived {
    column: usize,
    from: Vec<usize>,
    arguments: Vec<f64>,
    value: RowFunction,
}

/// Fills trajectory rows from communication points.
///
/// Everything a communication point shows is laid out one after the other in `seen`; a column is an index into it.
///
/// ```text
/// time | outputs of mechanics, of actuator | received | observables of mechanics, of actuator | room for derived columns
/// ```
pub struct Recorder {
    columns: Vec<usize>,
    seen: Vec<f64>,
    /// Where each part but the time and the derived columns ends in `seen`.
    ends: [usize; 5],
    effective_mass: Option<usize>,
    derived: Vec<Derived>,
    /// Columns of coordinates of the mechanics, and which ones.
    coordinates: Vec<(usize, usize)>,
    /// Of a system whose rows show the values of the row before at their own time: that row.
    late: Option<Vec<f64>>,
    rows: usize,
}

/// The names of everything that a communication point shows, derived columns aside, in the order of [`Recorder`]'s
/// `seen`, with the end of each part.
fn seen(system: &mut CoupledSystem) -> (Vec<Name>, [usize; 5]) {
    let names_of = |ports: &[Port]| -> Vec<Name> { ports.iter().map(|port| port.name.clone()).collect() };
    let observables = |side: &mut Box<dyn Subsystem>| side.capabilities().observables().to_vec();
    let y = system.sides.as_ref().map(|side| names_of(&side.ports().outputs));
    // Of the forces received only the first two have a column.
    let mut received = vec![Name::default(); y.actuator.len()];
    received
        .iter_mut()
        .zip(["force_to_mechanics_n", "force_2_to_mechanics_n"])
        .for_each(|(to, name)| *to = name.into());
    let shown = system.sides.as_mut().map(observables);
    let parts = [y.mechanics, y.actuator, received, shown.mechanics, shown.actuator];
    let mut names = vec![Name::from("time_s")];
    let ends = parts.map(|part| {
        names.extend(part);
        names.len()
    });
    (names, ends)
}

/// The names of the columns that a system can fill without deriving them from others.
pub(super) fn sources(system: &mut CoupledSystem) -> Vec<Name> {
    seen(system).0.into_iter().filter(|name| !name.is_empty()).collect()
}

impl Recorder {
    /// Finds the source of each of the case's columns.
    ///
    /// # Errors
    /// [`Error::Incompatible`] naming a column that neither side offers, with all that there are, or one that is to be
    /// judged or derived from and is not recorded.
    pub fn new(case: &Case, system: &mut CoupledSystem) -> Result<Self> {
        let recorded = case.recorded_columns();
        let place = |wanted: &str| {
            let found = recorded.iter().position(|name| name == wanted);
            found.ok_or_else(|| {
                let text = format!("case {}: column {wanted} is used and not among those recorded", case.name);
                Error::Incompatible(text)
            })
        };
        for row in &case.interface_columns {
            [&row.position, &row.velocity, &row.force].into_iter().try_for_each(|name| place(name).map(drop))?;
        }
        let derived: Vec<Derived> = std::mem::take(&mut system.derived)
            .into_iter()
            .map(|derived| {
                Ok(Derived {
                    column: place(&derived.name)?,
                    from: derived.from.iter().map(|name| place(name)).collect::<Result<_>>()?,
                    arguments: vec![0.0; derived.from.len()],
                    value: derived.value,
                })
            })
            .collect::<Result<_>>()?;
        let (mut names, ends) = seen(system);
        names.extend(derived.iter().map(|derived| recorded[derived.column].clone().into()));
        let mechanics = system.sides.mechanics.capabilities().contact_mechanics();
        let known = mechanics.map_or(0, |mechanics| mechanics.coordinates().len());
        let coordinate = |name: &str| name.strip_prefix(COORDINATE)?.parse().ok().filter(|index| *index < known);
        let mut coordinates = Vec::new();
        let index_of = |(column, name): (usize, &String)| {
            let index = names.iter().position(|known| known == name);
            if let (None, Some(of)) = (index, coordinate(name)) {
                coordinates.push((column, of));
                // Its value is found where it is recorded.
                return Ok(0);
            }
            index.ok_or_else(|| {
                let there_are = names.join(", ");
                Error::Incompatible(format!("case {}: column {name} has no source; there are {there_are}", case.name))
            })
        };
        let columns = recorded.iter().enumerate().map(index_of).collect::<Result<_>>()?;
        Ok(Recorder {
            columns,
            seen: vec![f64::NAN; names.len()],
            ends,
            effective_mass: recorded.iter().position(|name| name == "effective_mass_kg"),
            late: system.late_rows.then(Vec::new),
            rows: 0,
            derived,
            coordinates,
        })
    }

    /// Records as effective mass the one with the contacts that carried impulse in the mechanics' last step: what the
    /// reference shows, which has no scheme.
    pub fn with_active_effective_mass(mut self, system: &mut CoupledSystem) -> Self {
        let active = system
            .sides
            .mechanics
            .capabilities()
            .observables()
            .iter()
            .position(|name| *name == "active_effective_mass_kg");
        if let (Some(column), Some(index)) = (self.effective_mass, active) {
            let [_, _, received, ..] = self.ends;
            self.columns[column] = received + index;
        }
        self
    }

    /// Appends one row. The effective mass in it is the smooth one of the mechanics, until the scheme has said what its
    /// own was in the macro step that starts here.
    pub fn record(&mut self, point: CommunicationPoint<'_>, trajectory: &mut Trajectory) {
        let [y_mechanics, y_actuator, received, mechanics, actuator] = self.ends;
        self.seen[0] = point.time;
        self.seen[1..y_mechanics].copy_from_slice(point.y.mechanics);
        self.seen[y_mechanics..y_actuator].copy_from_slice(point.y.actuator);
        self.seen[y_actuator..received].copy_from_slice(point.received);
        point.sides.mechanics.capabilities().observe(point.mechanics_step, &mut self.seen[received..mechanics]);
        point.sides.actuator.capabilities().observe(point.mechanics_step, &mut self.seen[mechanics..actuator]);
        self.note_effective_mass(point.effective_mass, trajectory);
        self.rows += 1;
        let row = trajectory.push_row();
        for (value, &column) in row.iter_mut().zip(&self.columns) {
            *value = self.seen[column];
        }
        if let (false, Some(mechanics)) =
            (self.coordinates.is_empty(), point.sides.mechanics.capabilities().contact_mechanics())
        {
            let q = mechanics.coordinates();
            self.coordinates.iter().for_each(|&(column, index)| row[column] = q[index]);
        }
        if let Some(audit) = point.audit {
            row[self.columns.len()..].iter_mut().zip(audit).for_each(|(value, audited)| *value = audited);
        }
        if let (Some(lambda), [value, ..]) = (point.interface_lambda, &mut row[self.columns.len()..]) {
            *value = lambda;
        }
        for derived in &mut self.derived {
            for (argument, &column) in derived.arguments.iter_mut().zip(&derived.from) {
                *argument = row[column];
            }
            row[derived.column] = (derived.value)(&derived.arguments);
        }
        if let Some(late) = &mut self.late {
            let (time, first) = (row[0], late.is_empty());
            if first {
                late.extend_from_slice(row);
            } else {
                late.swap_with_slice(row);
                row[0] = time;
            }
            if let (false, Some(column), Some(mass)) = (first, self.effective_mass, point.effective_mass) {
                row[column] = mass;
            }
        }
    }

    /// Completes the rows of a run with what is known at its end.
    pub fn finish(self, report: &Report, trajectory: &mut Trajectory) {
        self.note_effective_mass(report.scheme.effective_mass, trajectory);
    }

    /// Writes what a scheme says of the macro step that began with the last row. That of a late row stands in the row
    /// after it, but for the first.
    fn note_effective_mass(&self, effective_mass: Option<f64>, trajectory: &mut Trajectory) {
        if let (true, Some(column), Some(mass), Some(row)) =
            (self.late.is_none() || self.rows == 1, self.effective_mass, effective_mass, trajectory.last_row_mut())
        {
            row[column] = mass;
        }
    }
}
