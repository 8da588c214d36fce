//! What schemes believe of the mechanics within one macro step, all from one true state.
//!
//! Both sides come to `t_k` together, micro step by micro step ([`what_happens`]). From copies of them a scheme then lets
//! the actuator cover the macro step alone ([`believed`]). Rows of both have the columns of a run, one per micro step.

use super::RunSpec;
use crate::catalogue::Catalogue;
use rimbench_cases::cases::Recorder;
use rimbench_core::cosim::{
    ActuatorIntegrator, Bounds, CommunicationGrid, CouplingScheme, ExchangeData, ForceReturn, MacroStep,
    MechanicsIntegrator, MicroStep, PerSide, RunControl, Sample, Sequence, Setup, Side, StopFlag, Subsystem,
    Trajectory,
};
use rimbench_core::error::{Error, Failure, Result};
use rimbench_core::interface_model::{IndependentRows, ReducedInterfaceModel};
use rimbench_core::iterative::IterativeDriver;

/// Gap up to which a contact counts as closed, m: that of one that opens in a micro step is larger by orders.
const CLOSED: f64 = 1e-9;

/// Velocity up to which a contact stands still, m/s.
const STILL: f64 = 1e-12;

/// The true state at `t_k`, and what happens from there.
pub struct TrueState {
    sides: PerSide<Box<dyn Subsystem>>,
    at_s: f64,
    /// Both sides together, over the macro step.
    pub happens: Trajectory,
}

/// Lets both sides of a run come to `at_s` (s) and cover its macro step together, at its micro step.
///
/// # Errors
/// A time that is no multiple of the micro step; a case that cannot be built, copied or solved so far.
pub fn what_happens(spec: &RunSpec, catalogue: &Catalogue, at_s: f64, stop: StopFlag<'_>) -> Result<TrueState> {
    let own = spec.setup(Bounds::default());
    let step = MacroStep { index: 0, start: at_s, length: spec.macro_step };
    let micro_step = own.actuator_micro_step(step);
    let first = (at_s / micro_step).round();
    let within = (0.0..=spec.duration - spec.macro_step + 1e-9 * spec.duration).contains(&at_s);
    if !within || (first * micro_step - at_s).abs() > 1e-9 * micro_step.max(at_s) {
        let duration = spec.duration;
        let expected = format!(
            "a multiple of the micro step, {micro_step} s, at which a macro step starts that ends within {duration} s"
        );
        return Err(Error::invalid("believe_at", at_s, expected));
    }
    let mut system = spec.build()?;
    let mut recorder = Recorder::new(&spec.case, &mut system)?;
    let mut happens = Trajectory::with_capacity(spec.case.recorded_columns(), own.actuator_steps(step) + 1);
    let grid = CommunicationGrid::new(micro_step, 1.0, at_s + spec.macro_step)?;
    let setup = Setup::new(grid, micro_step, Sequence::Jacobi, ForceReturn::Held);
    let coupling = catalogue.scheme("monolithic")?.couple(system.sides.lend(), None, None)?;
    let (mut index, mut copies) = (0, None);
    let control = RunControl { stop, ..RunControl::default() };
    let report = coupling.run(&setup, system.sides.lend(), control, &mut |point| {
        if index == first as usize {
            let sides = &point.sides;
            copies = Some((sides.mechanics.try_clone(), sides.actuator.try_clone()));
        }
        if index >= first as usize {
            recorder.record(point, &mut happens);
        }
        index += 1;
    });
    match copies {
        Some((Ok(mechanics), Ok(actuator))) if index == grid.macro_steps() + 1 => {
            Ok(TrueState { sides: PerSide { mechanics, actuator }, at_s, happens })
        }
        Some((Err(failure), _) | (_, Err(failure))) => Err(not_known(spec, &failure)),
        _ => Err(Error::Incompatible(format!(
            "case {}: what happens is known up to {} only ({})",
            spec.case.name,
            setup.grid.time(index.saturating_sub(1)),
            report.outcome.name()
        ))),
    }
}

fn not_known(spec: &RunSpec, failure: &Failure) -> Error {
    Error::Incompatible(format!("case {}, scheme {}: no belief is known: {failure}", spec.case.name, spec.scheme.name))
}

/// Lets the actuator cover a macro step from the true state as its scheme has it; one of the run's length, which need not
/// be that over which it is known what happens.
///
/// Positions, velocities and forces are those between scheme and actuator. Gaps follow the scheme's model, and contact
/// forces are the impulses by which its contacts come to the velocities that they have in it, over the micro step δ that
/// ends in the row (N). Without a model contacts go on as they moved at `t_k`.
///
/// ```text
/// w⁺ = w + δ (a + H_·i λ) + H_·u P_u        g⁺ = g + δ w⁺        w_u⁺ as the scheme's model has it
/// ```
/// With friction, and where only non-zeros of the model are kept, gaps and contact forces are no numbers.
///
/// # Errors
/// [`Error::Incompatible`] for a scheme that is more than its inputs within one macro step: that iterates, tries steps,
/// has late samples, a wrong model, or micro steps of the second order.
pub fn believed(spec: &RunSpec, from: &TrueState) -> Result<Trajectory> {
    let copies = [&from.sides.mechanics, &from.sides.actuator].map(|side| side.try_clone());
    let [mechanics, actuator] = copies.map(|copy| copy.map_err(|failure| not_known(spec, &failure)));
    let mut sides = PerSide { mechanics: mechanics?, actuator: actuator? };
    let coupling = spec.scheme.couple(sides.lend(), spec.model.as_ref(), spec.gain)?;
    let setup = spec.setup(Bounds::default());
    let refused = [
        ("iterates", coupling.driver != IterativeDriver::NonIterative),
        ("tries steps", coupling.exchange.trials),
        ("exchanges lines", coupling.exchange.line_forces.is_some()),
        ("has micro steps of the second order", setup.actuator_integrator != ActuatorIntegrator::default()),
        ("has mechanics of the second order", spec.mechanics_integrator != MechanicsIntegrator::default()),
        ("has late samples", setup.delivery.is_some()),
        ("has a wrong model", setup.belief.is_some() || setup.mass_learning.is_some()),
        ("lets the mechanics step first", setup.sequence == Sequence::GaussSeidel { first: Side::Mechanics }),
    ];
    if let Some((what, _)) = refused.iter().find(|(_, refused)| *refused) {
        let name = &spec.scheme.name;
        return Err(Error::Incompatible(format!(
            "believe_at: {name} {what}; valid: a scheme that neither repeats nor tries steps, with samples in time and the true model"
        )));
    }
    let step = MacroStep { index: 0, start: from.at_s, length: spec.macro_step };
    cover(spec, step, sides, coupling.scheme, coupling.exchange).map_err(|failure| not_known(spec, &failure))
}

fn cover(
    spec: &RunSpec,
    step: MacroStep,
    mut sides: PerSide<Box<dyn Subsystem>>,
    mut scheme: Box<dyn CouplingScheme>,
    mut exchange: ExchangeData,
) -> std::result::Result<Trajectory, Failure> {
    let setup = spec.setup(Bounds::default());
    let ports = sides.as_ref().map(|side| (side.ports().inputs.len(), side.ports().outputs.len()));
    let [mut u, mut y_mechanics] = [ports.mechanics.0, ports.mechanics.1].map(|count| vec![0.0; count]);
    let mut own = vec![0.0; ports.actuator.1];
    // The side without direct feedthrough speaks first.
    if sides.mechanics.ports().direct_feedthrough {
        sides.actuator.outputs(&y_mechanics, &mut u)?;
    }
    sides.mechanics.outputs(&u, &mut y_mechanics)?;
    let mut u = y_mechanics.clone();
    sides.actuator.outputs(&u, &mut own)?;
    let mechanics_step = setup.mechanics_step(step);
    let names = sides.mechanics.capabilities().contact_mechanics().map(|own| own.contact_names().to_vec());
    let mut contacts = Contacts::new(sides.mechanics.capabilities().empty_interface_model());
    if let Some(model) = &mut contacts.model {
        sides.mechanics.capabilities().interface_model(mechanics_step, model)?;
    }
    contacts.begin();
    if let Some(model) = &mut exchange.interface_model {
        sides.mechanics.capabilities().interface_model(mechanics_step, model)?;
    }
    if let Some(rates) = &mut exchange.output_rates {
        sides.actuator.capabilities().output_rates(step.start, &u, rates)?;
    }
    let sample = Sample {
        model: exchange.interface_model.as_ref(),
        mechanics_steps: setup.own_mechanics_steps(step),
        ..Sample::of_outputs(step, &y_mechanics, setup.actuator_micro_step(step))
    };
    scheme.receive(Side::Mechanics, &sample)?;
    let rates = exchange.output_rates.as_ref();
    scheme.receive(Side::Actuator, &Sample { y: &own.clone(), model: None, rates, ..sample })?;

    let count = setup.actuator_steps(step);
    let mut rows = Trajectory::with_capacity(spec.case.recorded_columns(), count + 1);
    let named = |pattern: [&str; 2]| -> Vec<Option<usize>> {
        let name = |contact: &rimbench_core::name::Name| format!("{}{contact}{}", pattern[0], pattern[1]);
        names.iter().flatten().map(|contact| rows.index_of(&name(contact))).collect()
    };
    let (gaps, forces) = (named(["gap_", "_m"]), named(["contact_force_", "_n"]));
    let interface: Vec<[Option<usize>; 3]> = spec
        .case
        .interface_columns
        .iter()
        .map(|row| [&row.position, &row.velocity, &row.force].map(|name| rows.index_of(name)))
        .collect();
    for j in 0..=count {
        sides.actuator.outputs(&u, &mut own)?;
        let at = MicroStep::new(step, j, count);
        let row = rows.push_row();
        row.fill(f64::NAN);
        row[0] = at.start;
        let mut put = |column: Option<usize>, value: f64| column.into_iter().for_each(|column| row[column] = value);
        for (index, columns) in interface.iter().enumerate() {
            let values = [u[index], u[u.len() / 2 + index], own[index]];
            columns.iter().zip(values).for_each(|(column, value)| put(*column, value));
        }
        for (contact, (gap, force)) in gaps.iter().zip(&forces).enumerate() {
            put(*gap, contacts.gap.get(contact).copied().unwrap_or(f64::NAN));
            put(*force, contacts.impulse.get(contact).map_or(f64::NAN, |impulse| impulse / at.length));
        }
        if j < count {
            scheme.input(Side::Actuator, at, &own, &mut u)?;
            contacts.step(&mut *scheme, exchange.interface_model.is_some(), &own, at.length);
            sides.actuator.step(at.start, &u, at.length)?;
        }
    }
    Ok(rows)
}

/// The contacts as a scheme's model moves them.
struct Contacts {
    model: Option<ReducedInterfaceModel>,
    w: Vec<f64>,
    gap: Vec<f64>,
    impulse: Vec<f64>,
}

impl Contacts {
    fn new(model: Option<ReducedInterfaceModel>) -> Self {
        let model = model.filter(|model| !model.has_friction() && model.delassus_pattern().is_none());
        Contacts { model, w: Vec::new(), gap: Vec::new(), impulse: Vec::new() }
    }

    /// Starts from the true state.
    fn begin(&mut self) {
        let Some(model) = &self.model else { return };
        self.w = model.w[..model.contacts()].to_vec();
        self.gap = model.gap.clone();
        self.impulse = vec![0.0; self.gap.len()];
    }

    /// Moves them by a micro step δ (s) under the force λ (N).
    fn step(&mut self, scheme: &mut dyn CouplingScheme, has_model: bool, lambda: &[f64], length: f64) {
        let Some(model) = &self.model else { return };
        if has_model {
            let Some(end) = scheme.model_end() else { return self.gap.fill(f64::NAN) };
            let column = model.interface_start();
            for (row, w) in self.w.iter_mut().enumerate() {
                let driven = lambda.iter().enumerate().map(|(j, force)| model.entry(row, column + j) * force);
                *w += length * (model.a[row] + driven.sum::<f64>());
            }
            let acts = |(row, w): &(usize, f64)| self.gap[*row] + length * w <= CLOSED || w.abs() <= STILL;
            let acting: Vec<(usize, f64)> = end.rows.iter().copied().zip(end.w.iter().copied()).filter(acts).collect();
            let rows: Vec<usize> = acting.iter().map(|(row, _)| *row).collect();
            let mut missing = vec![0.0; self.w.len()];
            acting.iter().for_each(|(row, w)| missing[*row] = w - self.w[*row]);
            let mut independent = IndependentRows::new(rows.len(), model);
            let (rows, impulses) = independent.solve(model, &rows, |row| missing[row]);
            self.impulse.fill(0.0);
            for (&row, &impulse) in rows.iter().zip(impulses) {
                self.impulse[row] = impulse;
                self.w.iter_mut().enumerate().for_each(|(other, w)| *w += model.entry(other, row) * impulse);
            }
        }
        self.gap.iter_mut().zip(&self.w).for_each(|(gap, w)| *gap += length * w);
    }
}
