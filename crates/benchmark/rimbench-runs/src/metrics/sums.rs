//! What is kept of the rows of a run: sums, extremes and events, block by block. A run may have more rows than there is
//! memory.

use super::contact_phase::{CHATTER, CLOSES_AT, ContactIntervals};
use super::friction_phase::FrictionPhases;
use super::impulse::{ImpulseError, RECEIVED, impulse_column};
use rimbench_core::cosim::{MechanicsSteps, Trajectory};
use rimbench_statistics::Line;
use std::ops::Range;

/// A contact of the reference with a gap below this counts as closed, m.
const CLOSED_IN_REFERENCE: f64 = 1e-6;

/// From here on what was wrong at the start may have been learned, s.
const SETTLED_S: f64 = 1.0;

/// One row of the interface in run and reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InterfaceRow {
    /// Column of the position.
    pub position: usize,
    /// Column of the velocity.
    pub velocity: usize,
    /// Column of the force.
    pub force: usize,
    /// Largest magnitude of the force in the whole reference, N; none where there is no force to speak of.
    pub reference_force_peak: Option<f64>,
    /// The same of the reference's touch-downs, N; none where there are none.
    pub reference_touch_down_peak: Option<f64>,
}

/// Which columns are which, and what of the case the sums depend on.
#[derive(Debug, Clone, Default)]
pub struct Columns {
    /// The rows of the interface.
    pub interface: Vec<InterfaceRow>,
    /// Of the effective mass, where the case has one.
    pub effective_mass: Option<usize>,
    /// Of the gaps of one contact each.
    pub gaps: Vec<usize>,
    /// Of the least gap of several contacts.
    pub least_gaps: Vec<usize>,
    /// Of what contacts with friction do.
    pub states: Vec<usize>,
    /// Times at which a touch-down of the reference shows, from and to, s.
    pub touch_downs: Vec<[f64; 2]>,
    /// Steps of the mechanics within a macro step, and the micro step (s); none where its rule is of second order.
    pub first_order: Option<(MechanicsSteps, f64)>,
    /// Keep the force error of each row, for a run whose model's defect sets its steps.
    pub each_force_error: bool,
}

/// Sums over pairs (own, reference).
#[derive(Debug, Clone, Copy)]
pub(super) struct Errors {
    count: usize,
    magnitudes: f64,
    squares: f64,
    largest: f64,
    last: f64,
}

impl Default for Errors {
    fn default() -> Self {
        // `NaN.max(x)` is x.
        Errors { count: 0, magnitudes: 0.0, squares: 0.0, largest: f64::NAN, last: f64::NAN }
    }
}

impl Errors {
    #[inline]
    fn add(&mut self, error: f64) {
        self.count += 1;
        self.magnitudes += error.abs();
        self.squares += error.powi(2);
        self.largest = self.largest.max(error.abs());
        self.last = error;
    }

    pub(super) fn largest(&self) -> Option<f64> {
        (self.count > 0).then_some(self.largest)
    }

    pub(super) fn last(&self) -> Option<f64> {
        (self.count > 0).then_some(self.last)
    }

    pub(super) fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.magnitudes / self.count as f64)
    }

    pub(super) fn rms(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.squares / self.count as f64).sqrt())
    }
}

#[inline]
fn larger(most: Option<f64>, value: f64) -> Option<f64> {
    Some(most.map_or(value, |most| most.max(value)))
}

/// Of one row of the interface.
#[derive(Debug, Clone, Default)]
pub(super) struct OfInterface {
    pub(super) force: Errors,
    /// Of the force, from 1 s on.
    pub(super) settled: Errors,
    pub(super) velocity: Errors,
    pub(super) position: Errors,
    pub(super) aligned: Errors,
    pub(super) force_peak: Option<f64>,
    pub(super) last_velocity: Option<f64>,
    /// Near touch-downs: own peak, that of the reference, errors.
    pub(super) near: (Option<f64>, Option<f64>, Errors),
    /// Inside macro steps: force at the start of a micro step, position in its middle.
    pub(super) inside: [Errors; 2],
    pub(super) impulse: Option<ImpulseError>,
    /// The two parts of the force error, run minus centre and centre minus reference, and the sum of the products of the
    /// first and the whole.
    pub(super) parts: [Errors; 2],
    with_coupling: f64,
}

impl OfInterface {
    /// Computes the coupling's share of the square of the force error, by projection; none where not all of it is
    /// divided.
    ///
    /// ```text
    /// ⟨e, a⟩ / |e|²          e the error, a the coupling's part: with ⟨e, b⟩ / |e|² they sum to 1
    /// ```
    pub(super) fn coupling_share(&self) -> Option<f64> {
        (self.parts[0].count == self.force.count && self.force.squares > 0.0)
            .then(|| self.with_coupling / self.force.squares)
    }
}

/// Sums over the rows of a run.
#[derive(Debug, Clone, Default)]
pub struct Sums {
    pub(super) columns: Columns,
    /// Forces of the run's centre, row by row of the interface, where there is one.
    pub(crate) centre: Vec<Vec<f64>>,
    pub(super) end: Option<f64>,
    /// The longest macro step, and what counts as chatter at least, s.
    pub(super) chatter: f64,
    pub(super) interface: Vec<OfInterface>,
    pub(super) pressure_near: Option<f64>,
    pub(super) growth: Option<f64>,
    pub(super) masses: Option<[f64; 2]>,
    pub(super) lifted: Option<f64>,
    pub(super) lowest: Option<f64>,
    /// The most by which closed contacts exceed the rank of their normal rows.
    pub(super) redundant: Option<f64>,
    /// Contacts that are closed in the last row; none without a row.
    pub(super) closed: Option<usize>,
    contacts: Vec<ContactIntervals>,
    friction: Vec<FrictionPhases>,
    residual: Option<f64>,
    pub(super) residual_in_impacts: f64,
    pub(super) drift: Line,
    pub(super) force_errors: Vec<f64>,
}

impl Sums {
    /// Makes those of no row.
    pub fn new(columns: Columns) -> Self {
        Sums {
            chatter: CHATTER,
            interface: vec![OfInterface::default(); columns.interface.len()],
            contacts: vec![ContactIntervals::default(); columns.gaps.len()],
            friction: vec![FrictionPhases::default(); columns.states.len()],
            columns,
            ..Sums::default()
        }
    }

    /// Returns which columns are which.
    pub fn columns(&self) -> &Columns {
        &self.columns
    }

    /// Returns when each contact is closed, in the order of the columns of gaps.
    pub fn contacts(&self) -> impl Iterator<Item = &ContactIntervals> {
        self.contacts.iter()
    }

    /// Returns what each contact with friction does, in the order of their columns.
    pub fn friction(&self) -> impl Iterator<Item = &FrictionPhases> {
        self.friction.iter()
    }

    /// Takes `rows` of a run, the reference at their times, or at more behind them, and the interface residual there,
    /// J, if it is counted.
    pub fn add(&mut self, run: &Trajectory, rows: Range<usize>, reference: &Trajectory, residuals: &[f64]) {
        if rows.is_empty() {
            return;
        }
        let own = |column: usize| run.column_of(rows.clone(), column);
        let times = || own(0);
        let pairs = |column: usize| {
            let exact = reference.index_of(&run.columns()[column]);
            let most = if exact.is_some() { usize::MAX } else { 0 };
            own(column).zip(reference.column(exact.unwrap_or(0)).take(most))
        };
        let columns = &self.columns;
        let is_near = |t: f64| columns.touch_downs.iter().any(|[from, to]| (*from..=*to).contains(&t));
        let near: Vec<bool> = times().map(is_near).collect();
        let of_near = |column: usize| own(column).zip(&near).filter(|(_, near)| **near).map(|(own, _)| own);
        // The steps that end at these rows; nothing has been stepped at the start.
        let befores = self.end.into_iter().chain(times()).take(rows.len());
        let skipped = usize::from(self.end.is_none());
        let lengths: Vec<f64> = std::iter::repeat_n(f64::NAN, skipped)
            .chain(times().skip(skipped).zip(befores).map(|(end, start)| end - start))
            .collect();
        for (index, (row, sums)) in columns.interface.iter().zip(&mut self.interface).enumerate() {
            for ((own, exact), time) in pairs(row.force).zip(times()) {
                sums.force.add(own - exact);
                if time >= SETTLED_S {
                    sums.settled.add(own - exact);
                }
            }
            if let Some(centre) = self.centre.get(index) {
                let begun = sums.parts[0].count;
                for ((own, exact), centre) in pairs(row.force).zip(centre.iter().skip(begun)) {
                    sums.parts[0].add(own - centre);
                    sums.parts[1].add(centre - exact);
                    sums.with_coupling += (own - exact) * (own - centre);
                }
            }
            pairs(row.velocity).for_each(|(own, exact)| sums.velocity.add(own - exact));
            let half = |length: f64| match columns.first_order {
                Some((steps, micro)) if !length.is_nan() => 0.5 * length / steps.within(length, micro) as f64,
                _ => 0.0,
            };
            for ((own, exact), (length, velocity)) in pairs(row.position).zip(lengths.iter().zip(own(row.velocity))) {
                sums.position.add(own - exact);
                sums.aligned.add(own - half(*length) * velocity - exact);
            }
            own(row.force).for_each(|force| sums.force_peak = larger(sums.force_peak, force.abs()));
            sums.last_velocity = own(row.velocity).last();
            of_near(row.force).for_each(|force| sums.near.0 = larger(sums.near.0, force.abs()));
            for ((own, exact), _) in pairs(row.force).zip(&near).filter(|(_, near)| **near) {
                sums.near.1 = larger(sums.near.1, exact.abs());
                sums.near.2.add(own - exact);
            }
            let received = RECEIVED.get(index).and_then(|name| run.index_of(name));
            let impulse = reference.index_of(&impulse_column(&run.columns()[row.force]));
            if let (Some(received), Some(impulse)) = (received, impulse) {
                let error = sums.impulse.get_or_insert_default();
                let rows = times().zip(own(received)).zip(reference.column(impulse));
                rows.for_each(|((time, force), exact)| error.add(time, force, exact));
            }
        }
        if columns.each_force_error {
            let before = self.force_errors.len();
            self.force_errors.resize(before + rows.len(), 0.0);
            for row in &columns.interface {
                for (most, (own, exact)) in self.force_errors[before..].iter_mut().zip(pairs(row.force)) {
                    *most = most.max((own - exact).abs());
                }
            }
        }
        if let Some(pressure) = run.index_of("pressure_1_pa") {
            of_near(pressure).for_each(|value| self.pressure_near = larger(self.pressure_near, value.abs()));
        }
        if let Some(growth) = run.index_of("energy_growth") {
            self.growth = Some(own(growth).fold(self.growth.unwrap_or(0.0), f64::max));
        }
        for mass in columns.effective_mass.into_iter().flat_map(own).filter(|mass| !mass.is_nan()) {
            let [low, high] = self.masses.unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
            self.masses = Some([low.min(mass), high.max(mass)]);
        }
        for &gap in &columns.gaps {
            let down = pairs(gap).filter(|(_, exact)| *exact <= CLOSED_IN_REFERENCE);
            down.for_each(|(own, _)| self.lifted = larger(self.lifted, own));
        }
        for gap in columns.gaps.iter().chain(&columns.least_gaps).flat_map(|&gap| own(gap)) {
            self.lowest = Some(self.lowest.map_or(gap, |lowest| lowest.min(gap)));
        }
        if let [Some(closed), Some(rank)] = ["closed_contacts", "rank_h_uu"].map(|name| run.index_of(name)) {
            let beyond = own(closed).zip(own(rank)).map(|(closed, rank)| closed - rank);
            beyond.filter(|count| !count.is_nan()).for_each(|count| self.redundant = larger(self.redundant, count));
        }
        let last = run.row(rows.end - 1);
        self.closed = Some(columns.gaps.iter().filter(|gap| last[**gap] <= CLOSES_AT).count());
        for (&state, phases) in columns.states.iter().zip(&mut self.friction) {
            times().zip(own(state)).for_each(|(time, state)| phases.add(time, state));
        }
        for row in rows.clone() {
            let values = run.row(row);
            let contacts = columns.gaps.iter().zip(&mut self.contacts);
            let closes = contacts.fold(false, |any, (&gap, contact)| contact.add(values[0], values[gap]) | any);
            if let Some(&residual) = residuals.get(row - rows.start) {
                self.drift.add([values[0], residual]);
                if let (true, Some(before)) = (closes, self.residual) {
                    self.residual_in_impacts += residual - before;
                }
                self.residual = Some(residual);
            }
        }
        self.chatter = lengths.iter().copied().fold(self.chatter, f64::max);
        self.end = Some(last[0]);
    }

    /// Takes micro steps of the actuator, see [`Report::inside`](rimbench_core::cosim::Report::inside), of a run with
    /// these columns, and the reference at the first two columns of the log, or at more behind them: at the start of
    /// each micro step, and in its middle.
    pub fn add_inside(&mut self, names: &[String], log: &Trajectory, reference: [&Trajectory; 2]) {
        for (row, sums) in self.columns.interface.iter().zip(&mut self.interface) {
            for ((column, reference), errors) in
                [row.force, row.position].into_iter().zip(reference).zip(&mut sums.inside)
            {
                // A coupling may exchange something else.
                if let (Some(own), Some(exact)) = (log.index_of(&names[column]), reference.index_of(&names[column])) {
                    // A copy stays in registers.
                    let mut sums = *errors;
                    log.column(own).zip(reference.column(exact)).for_each(|(own, exact)| sums.add(own - exact));
                    *errors = sums;
                }
            }
        }
    }

    /// Tells whether the interface residual is counted.
    pub(super) fn counts_residual(&self) -> bool {
        self.residual.is_some()
    }
}
