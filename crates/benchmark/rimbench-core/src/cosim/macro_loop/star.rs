//! A star: one mechanics, the hub, and bonds around it, each with actuators of its own.
//!
//! A bond is a pair as everywhere else, [`CoupledPair`] with a scheme, a state and a setup of its own. Its actuator side
//! has the bond's actuators on their rows, and on those of other bonds stand-ins: what it knows of them. Bonds of one
//! stage exchange before any of them steps (Jacobi), stages follow each other (Gauss–Seidel).
//!
//! ```text
//! for each part of a macro step, stage by stage:   each bond that is due is told of the others, then exchanges with the hub
//!                                                  each bond that is due steps
//! the hub, once in a macro step:                   steps with the force that each bond returns on its own rows
//! ```

mod plan;
mod share;
mod stand_in;

pub use self::plan::{Every, Known, MicroSteps, Order, Partition, Share, StarPlan, Tells};

use self::plan::{Layout, Schedule, numbers};
use self::share::SharedModel;
use self::stand_in::{BondSide, Law, NOT_APART, Room, StandIn, actuator_of};
use super::log::{End, Log};
use super::{View, macro_steps};
use crate::cosim::communication_grid::{CommunicationGrid, MacroStep, MicroStep, division};
use crate::cosim::communication_point::CommunicationPoint;
use crate::cosim::coupled_pair::{CoupledPair, watch_bounds};
use crate::cosim::coupling_scheme::{CouplingScheme, Sample, SchemeReport};
use crate::cosim::exchange_data::{ExchangeData, NO_INTERFACE_MODEL};
use crate::cosim::force_return::{ForceReturn, Sequence};
use crate::cosim::interface_work::InterfaceWork;
use crate::cosim::mechanics_steps::MechanicsSteps;
use crate::cosim::micro_log::micro_log;
use crate::cosim::outcome::Outcome;
use crate::cosim::output_rates::OutputRates;
use crate::cosim::pair_state::PairState;
use crate::cosim::report::Report;
use crate::cosim::run_control::{RunControl, StopFlag};
use crate::cosim::setup::{Bounds, Setup};
use crate::cosim::side::{PerSide, Side};
use crate::cosim::step_size_control::MacroInterval;
use crate::cosim::subsystem::{Sides, Subsystem};
use crate::cosim::trajectory::Trajectory;
use crate::cosim::work::{CosimCounters, Work};
use crate::cosim::work_meter::WorkMeter;
use crate::error::{Cause, Failure, Result};
use crate::interface_model::{Correlation, InterfaceCorrelation, ReducedInterfaceModel};

/// One bond of a star.
struct Bond {
    rows: Vec<usize>,
    /// Parts of a macro step of the hub between two times at which it steps, and between two exchanges with the hub.
    every: usize,
    long: usize,
    setup: Setup,
    scheme: Box<dyn CouplingScheme>,
    state: PairState,
    others: Vec<Option<StandIn>>,
    clock: f64,
    /// Its present step, which began at part `from` and takes `length`; the part up to which it has come.
    step: MacroStep,
    from: usize,
    length: usize,
    done: usize,
    /// Work that the hub has received of it, J.
    work_received: f64,
    /// Its last mean, and its force now, on all rows.
    mean: Vec<f64>,
    now: Vec<f64>,
    /// Of one actuator.
    rates: OutputRates,
    room: Room,
}

/// A mechanics and its bonds, ready to run.
pub struct Star {
    plan: StarPlan,
    schedule: Schedule,
    told: usize,
    bonds: Vec<Bond>,
    state: StarState,
}

/// What all bonds have in common.
struct StarState {
    time: f64,
    counters: CosimCounters,
    y: PerSide<Vec<f64>>,
    u: Vec<f64>,
    received: Vec<f64>,
    /// The hub reduced to its interface at the last communication point, if a bond needs that.
    model: Option<ReducedInterfaceModel>,
    /// Of the free hub, and with the contacts closed that push.
    correlation: Correlation,
    loaded: Correlation,
    diverged: Option<Outcome>,
    inside: Option<Trajectory>,
    booked: [u64; 2],
    /// Room for what is reported of each bond.
    work: Vec<InterfaceWork>,
}

/// A star between two calls of the loop.
pub(crate) struct RunningStar<'a> {
    setup: &'a Setup,
    sides: Sides<'a>,
    star: &'a mut Star,
    stop: StopFlag<'a>,
}

impl Star {
    /// Divides the actuator side among bonds; `couple` builds the scheme of one for hub and bond, and what they exchange
    /// besides outputs.
    ///
    /// # Errors
    /// Those of the plan and of `couple`.
    pub fn new(
        setup: &Setup,
        plan: &StarPlan,
        sides: Sides<'_>,
        mut couple: impl FnMut(usize, Sides<'_>) -> Result<(Box<dyn CouplingScheme>, ExchangeData)>,
    ) -> Result<Self> {
        let ports = sides.ports().map(Clone::clone);
        let n = ports.actuator.outputs.len();
        let layout = plan.layout(n)?;
        let room = || vec![0.0; n];
        let mut bonds: Vec<Bond> = Vec::with_capacity(layout.rows.len());
        for (index, rows) in layout.rows.iter().enumerate() {
            let setup = setup_of(setup, plan, &layout, index)?;
            let mut others: Vec<Option<StandIn>> = vec![Some(StandIn::new(0)); n];
            rows.iter().for_each(|&row| others[row] = None);
            let mut clock = 0.0;
            let mut own = Room::new(n, &mut *sides.actuator);
            let side =
                &mut BondSide { whole: &mut *sides.actuator, others: &mut others, now: &mut clock, room: &mut own };
            let mut pair = PerSide { mechanics: &mut *sides.mechanics as &mut dyn Subsystem, actuator: side };
            let (scheme, exchange) = couple(index, pair.lend())?;
            let mut state = PairState::new(&setup, pair, exchange);
            state.work_sent = WorkMeter::of_rows(&ports.actuator, rows);
            // Other bonds are told of its forces.
            state.keeps_history = true;
            let share = (plan.share, plan.factor(index, &layout));
            let scheme = SharedModel::of(scheme, share, rows, n, plan.known == Known::Nothing);
            bonds.push(Bond {
                rows: rows.clone(),
                every: layout.every[index],
                long: layout.every[index].max(layout.told),
                step: setup.grid.step(0),
                setup,
                scheme,
                state,
                others,
                clock,
                from: 0,
                length: 0,
                done: 0,
                work_received: 0.0,
                mean: room(),
                now: room(),
                rates: OutputRates::zeros(1, 2),
                room: own,
            });
        }
        for index in 0..bonds.len() {
            let (rows, parts) = (bonds[index].rows.clone(), bonds[index].most_micro_steps());
            for bond in &mut bonds {
                for &row in rows.iter().filter(|row| bond.rows.iter().all(|own| own != *row)) {
                    bond.others[row] = Some(StandIn::new(parts));
                }
            }
        }
        let model = bonds.iter().find_map(|bond| bond.state.model.as_ref().map(|own| own.model.clone()));
        let state = StarState {
            time: 0.0,
            counters: CosimCounters::default(),
            y: PerSide { mechanics: vec![0.0; ports.mechanics.outputs.len()], actuator: room() },
            u: room(),
            received: room(),
            model,
            correlation: Correlation::new(n),
            loaded: Correlation::new(n),
            diverged: None,
            inside: None,
            booked: [0; 2],
            work: Vec::with_capacity(bonds.len()),
        };
        Ok(Star { plan: plan.clone(), schedule: layout.schedule, told: layout.told, bonds, state })
    }

    /// Runs hub and bonds, and calls `observe` at each communication point of the hub: what
    /// [`cosimulate`](crate::cosim::cosimulate) does with a pair.
    pub fn run(
        mut self,
        setup: &Setup,
        mut sides: Sides<'_>,
        control: RunControl<'_>,
        observe: &mut dyn FnMut(CommunicationPoint<'_>),
    ) -> Report {
        let alike = self.bonds.iter().all(|bond| bond.long == self.told && bond.setup.micro_step == setup.micro_step);
        if let Some(most) = control.inside.filter(|_| alike) {
            self.state.inside = Some(micro_log(setup, &sides, most));
            for bond in &mut self.bonds {
                let most = bond.most_micro_steps();
                bond.state.inside = Some(micro_log(&bond.setup, &sides, most));
            }
        }
        let mut log = Log::new(control.timer, setup);
        let mut running = RunningStar { setup, sides: sides.lend(), star: &mut self, stop: control.stop };
        let advance = |running: &mut RunningStar<'_>, interval| running.advance(interval);
        let steps = (MacroInterval::whole, advance);
        let ended = macro_steps(&mut running, |running| View::Star(running.lend()), steps, &mut log, observe);
        running.report(log, ended)
    }
}

/// The setup of one bond.
fn setup_of(hub: &Setup, plan: &StarPlan, layout: &Layout, index: usize) -> Result<Setup> {
    let mut setup = Setup { bounds: Bounds::default(), ..hub.clone() };
    let long = layout.every[index].max(layout.told) / layout.told;
    if long > 1 {
        let duration = hub.grid.duration();
        setup.grid = CommunicationGrid::new((long as f64 * hub.grid.macro_step()).min(duration), 1.0, duration)?;
        if let MechanicsSteps::Count(count) = hub.mechanics_steps {
            let count = count.get().saturating_mul(u32::try_from(long).unwrap_or(u32::MAX));
            setup.mechanics_steps = MechanicsSteps::count(count).unwrap_or(MechanicsSteps::ONE);
        }
    }
    if let Some(&micro_step) = plan.micro_steps.0.get(index) {
        setup.micro_step = micro_step;
    }
    let stage = layout.schedule.stages.iter().position(|stage| stage.contains(&index));
    if stage.is_some_and(|stage| stage >= layout.schedule.hub_at) {
        (setup.sequence, setup.force_return) = (Sequence::GaussSeidel { first: Side::Mechanics }, ForceReturn::Held);
    }
    Ok(setup)
}

impl Bond {
    fn most_micro_steps(&self) -> usize {
        division(self.setup.grid.macro_step(), self.setup.micro_step)
    }

    /// Lends the pair that the bond is.
    fn pair<'a>(
        &'a mut self,
        hub: &'a mut (dyn Subsystem + '_),
        whole: &'a mut (dyn Subsystem + '_),
        stop: StopFlag<'a>,
        act: impl FnOnce(CoupledPair<'_>) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let side = &mut BondSide { whole, others: &mut self.others, now: &mut self.clock, room: &mut self.room };
        act(CoupledPair {
            setup: &self.setup,
            sides: PerSide { mechanics: hub, actuator: side },
            scheme: &mut *self.scheme,
            state: &mut self.state,
            stop,
        })
    }

    /// Finds its forces at a part of the star: those of its actuators with the hub's `motion` where it exchanges, else
    /// those that it has run ahead with.
    fn speak(&mut self, part: usize, motion: Option<&[f64]>, whole: &mut (dyn Subsystem + '_)) -> Result<(), Failure> {
        if let Some(motion) = motion {
            self.state.u.actuator.copy_from_slice(motion);
        } else if self.done > part {
            let micro_steps = self.state.history.rows().len();
            let at = (part - self.from) * micro_steps / (self.done - self.from);
            self.now.copy_from_slice(self.state.history.at(at));
            return Ok(());
        }
        for &row in &self.rows {
            self.room.ask(whole, row, &self.state.u.actuator, &mut self.now)?;
        }
        if part == 0 {
            self.mean.copy_from_slice(&self.now);
        }
        Ok(())
    }

    /// How the force of one of its actuators moves, at `time` (s).
    fn law(&mut self, row: usize, time: f64, whole: &mut (dyn Subsystem + '_)) -> Result<Option<Law>, Failure> {
        let (u, n) = (&self.state.u.actuator, self.now.len());
        let (at, rates) = ([u[row], u[n + row]], &mut self.rates);
        let known = actuator_of(whole, row)?.capabilities().output_rates(time, &at, rates)?;
        let pair = |values: &[f64]| [values[0], values[1]];
        let law = || Law {
            rate: rates.rate[0],
            feedthrough: pair(&rates.feedthrough),
            rate_gain: pair(&rates.rate_gain),
            at,
        };
        Ok(known.then(law))
    }

    /// Takes the mean over its last micro steps, from the first of these on.
    fn take_mean(&mut self, first: usize) {
        self.mean.fill(0.0);
        let rows = self.state.history.rows().skip(first);
        let count = rows.len() as f64;
        for y in rows {
            self.mean.iter_mut().zip(y).for_each(|(mean, y)| *mean += y);
        }
        self.mean.iter_mut().for_each(|mean| *mean /= count);
    }
}

impl RunningStar<'_> {
    /// Lends the star.
    pub(crate) fn lend(&mut self) -> RunningStar<'_> {
        RunningStar { setup: self.setup, sides: self.sides.lend(), star: &mut *self.star, stop: self.stop }
    }

    pub(crate) fn setup(&self) -> &Setup {
        self.setup
    }

    /// The time (s) at a part of a macro step of the hub.
    fn time(&self, step: MacroStep, part: usize) -> f64 {
        step.start + part as f64 * (step.length / self.star.told as f64)
    }

    /// Exchanges at a communication point of the hub: outputs of all, then with the bonds that step first; at the last
    /// one with all.
    pub(crate) fn exchange(&mut self, step: MacroStep) -> Result<(), Failure> {
        let is_last = step.index >= self.setup.grid.macro_steps();
        let part = step.index * self.star.told;
        let Star { bonds, state, schedule, .. } = &mut *self.star;
        state.time = step.start;
        self.sides.mechanics.outputs(&state.u, &mut state.y.mechanics)?;
        for bond in bonds {
            let motion = (part.is_multiple_of(bond.long) || is_last).then_some(&state.y.mechanics[..]);
            bond.speak(part, motion, self.sides.actuator)?;
            bond.rows.iter().for_each(|&row| state.y.actuator[row] = bond.now[row]);
        }
        state.u.copy_from_slice(&state.y.actuator);
        if step.index == 0 {
            state.received.copy_from_slice(&state.y.actuator);
        }
        let StarState { y, time, diverged, .. } = state;
        watch_bounds(&self.sides, y, (&self.setup.bounds, *time), diverged)?;
        state.counters.exchanges += 1;
        if let Some(model) = &mut state.model {
            if !self.sides.mechanics.capabilities().interface_model(self.setup.mechanics_step(step), model)? {
                return Err(Cause::NotOffered { what: NO_INTERFACE_MODEL.into() }.into());
            }
            let first = model.interface_start();
            state.correlation.look_at(|i, j| model.entry(first + i, first + j));
        }
        let (stages, hub_at) = (schedule.stages.len(), schedule.hub_at);
        let at_once = if is_last || hub_at == 0 { stages } else { 1 };
        (0..at_once).try_for_each(|stage| self.begin_stage(step, 0, stage))
    }

    /// Tells the bonds of a stage that are due of the others, and exchanges with the hub where it is time to.
    fn begin_stage(&mut self, step: MacroStep, part: usize, stage: usize) -> Result<(), Failure> {
        self.tell(step, part, stage)?;
        let now = step.index * self.star.told + part;
        let (setup, stop) = (self.setup, self.stop);
        let Star { bonds, state, schedule, told, .. } = &mut *self.star;
        let is_last = step.index >= setup.grid.macro_steps();
        for &index in &schedule.stages[stage] {
            let bond = &mut bonds[index];
            if !(now.is_multiple_of(bond.long) || (is_last && part == 0)) {
                continue;
            }
            (bond.from, bond.done, bond.length) = (now, now, bond.long);
            bond.step = step;
            let whole = bond.long / *told;
            if whole > 1 {
                let (grid, k) = (&setup.grid, step.index);
                let count = grid.macro_steps();
                let length = match k + whole <= count {
                    true => grid.time(k + whole) - grid.time(k),
                    false => grid.time(count) - grid.time(k),
                };
                let full = whole as f64 * grid.macro_step();
                // Full steps are equally long to the bit.
                let length = if k + whole < count || is_last { full } else { length };
                bond.length = whole.min(count.saturating_sub(k)) * *told;
                bond.step = MacroStep { index: k / whole, start: step.start, length };
            }
            bond.state.u.mechanics.copy_from_slice(&state.u);
            if let (Some(own), Some(model)) = (&mut bond.state.model, &state.model) {
                own.take(model);
            }
            let begun = bond.step;
            bond.pair(self.sides.mechanics, self.sides.actuator, stop, |mut pair| pair.exchange(begun))?;
        }
        for &index in &schedule.stages[stage] {
            let (bond, n) = (&mut bonds[index], state.u.len());
            if bond.from != now {
                continue;
            }
            match bond.scheme.loaded_mobility() {
                Some(mobility) => state.loaded.look_at(|i, j| mobility[i * n + j]),
                None => state.loaded.lambda = f64::NAN,
            }
        }
        Ok(())
    }

    /// Tells the bonds of a stage that are due what they may know of the others.
    fn tell(&mut self, step: MacroStep, part: usize, stage: usize) -> Result<(), Failure> {
        let (time, now) = (self.time(step, part), step.index * self.star.told + part);
        let Star { bonds, schedule, plan, .. } = &mut *self.star;
        for &index in &schedule.stages[stage] {
            if !now.is_multiple_of(bonds[index].every) {
                continue;
            }
            bonds[index].clock = time;
            for other in (0..bonds.len()).filter(|other| *other != index) {
                let Ok([bond, other]) = bonds.get_disjoint_mut([index, other]) else { continue };
                for at in 0..other.rows.len() {
                    let row = other.rows[at];
                    let law = match plan.known {
                        Known::Law => other.law(row, time, self.sides.actuator)?,
                        _ => None,
                    };
                    let force = match plan.known {
                        Known::Nothing => 0.0,
                        Known::Mean => other.mean[row],
                        Known::Held | Known::Law => other.now[row],
                    };
                    let Some(stand_in) = &mut bond.others[row] else { continue };
                    stand_in.know(force, law);
                    if other.done > now && plan.tells == Tells::Profile && plan.known != Known::Nothing {
                        let length = other.step.length / other.setup.actuator_steps(other.step) as f64;
                        stand_in.hear(other.step.start, length, other.state.history.rows().map(|y| y[row]));
                    }
                }
            }
        }
        Ok(())
    }

    /// Lets all cover a macro step of the hub.
    pub(crate) fn advance(&mut self, interval: MacroInterval) -> Result<(), Failure> {
        let step = interval.step;
        let (stages, hub_at) = (self.star.schedule.stages.len(), self.star.schedule.hub_at);
        for part in 0..self.star.told {
            let now = step.index * self.star.told + part;
            for bond in self.star.bonds.iter_mut().filter(|_| part > 0) {
                bond.speak(now, None, self.sides.actuator)?;
            }
            for stage in 0..stages {
                if stage == hub_at {
                    // Bonds after the hub take what it then sends.
                    for after in (stage..stages).filter(|_| hub_at > 0) {
                        self.begin_stage(step, part, after)?;
                    }
                    self.advance_hub(step)?;
                    self.send_fresh(interval)?;
                } else if stage < hub_at && (part, stage) != (0, 0) {
                    self.begin_stage(step, part, stage)?;
                }
                if stage > hub_at {
                    self.tell(step, part, stage)?;
                }
                self.advance_stage(now, stage)?;
            }
        }
        if hub_at >= stages {
            self.advance_hub(step)?;
        }
        self.star.state.counters.macro_steps += 1;
        self.log_inside();
        Ok(())
    }

    /// Lets the bonds of a stage that are due cover their step, or the part of it up to where they are told again.
    fn advance_stage(&mut self, now: usize, stage: usize) -> Result<(), Failure> {
        let Star { bonds, schedule, state, .. } = &mut *self.star;
        let mut longest = 0;
        for &index in &schedule.stages[stage] {
            let bond = &mut bonds[index];
            if !now.is_multiple_of(bond.every) {
                continue;
            }
            let (step, count) = (bond.step, bond.setup.actuator_steps(bond.step));
            let to = (now + bond.every).min(bond.from + bond.length);
            let [first, end] = [now, to].map(|at| (at - bond.from) * count / bond.length);
            let advance = |mut pair: CoupledPair<'_>| pair.advance_actuator_part(step, first..end);
            bond.pair(self.sides.mechanics, self.sides.actuator, self.stop, advance)?;
            bond.done = to;
            longest = longest.max(end - first);
            state.booked[1] += (end - first) as u64;
            if end > first {
                bond.take_mean(first);
            }
        }
        state.booked[0] += longest as u64;
        Ok(())
    }

    /// Lets the hub cover a macro step with the forces that its bonds return.
    fn advance_hub(&mut self, step: MacroStep) -> Result<(), Failure> {
        let (count, stop) = (self.setup.own_mechanics_steps(step), self.stop);
        let Star { bonds, state, told, .. } = &mut *self.star;
        state.received.fill(0.0);
        let now = step.index * *told;
        for i in 0..count {
            stop.check()?;
            let at = MicroStep::new(step, i, count);
            for bond in &mut *bonds {
                let (parts, index) = (bond.length.div_ceil(*told) * count, (now - bond.from) / *told * count + i);
                let begun = bond.step;
                let of_bond = MicroStep::new(begun, index, parts);
                let returns = |mut pair: CoupledPair<'_>| pair.return_force(begun, of_bond);
                bond.pair(self.sides.mechanics, self.sides.actuator, stop, returns)?;
                bond.rows.iter().for_each(|&row| state.u[row] = bond.state.u.mechanics[row]);
            }
            // The first half with the velocities before the step, the second with those after it.
            let mut account = |y: &[f64]| {
                for bond in &mut *bonds {
                    let power = bond.rows.iter().map(|&row| state.u[row] * y[state.u.len() + row]).sum::<f64>();
                    bond.work_received += 0.5 * at.length * power;
                }
            };
            if i == 0 {
                // With direct feedthrough they are others under the new forces.
                self.sides.mechanics.outputs(&state.u, &mut state.y.mechanics)?;
            }
            account(&state.y.mechanics);
            self.sides.mechanics.step(at.start, &state.u, at.length)?;
            self.sides.mechanics.outputs(&state.u, &mut state.y.mechanics)?;
            account(&state.y.mechanics);
            for (received, u) in state.received.iter_mut().zip(&state.u) {
                *received += u / count as f64;
            }
        }
        Ok(())
    }

    /// Sends what the hub puts out at the end of its step to the bonds that follow it.
    fn send_fresh(&mut self, MacroInterval { step, end }: MacroInterval) -> Result<(), Failure> {
        let Star { bonds, state, schedule, .. } = &mut *self.star;
        self.sides.mechanics.outputs(&state.u, &mut state.y.mechanics)?;
        for &index in schedule.stages[schedule.hub_at..].iter().flatten() {
            let bond = &mut bonds[index];
            let length = bond.setup.actuator_micro_step(step);
            let sample = Sample { time: end, ..Sample::of_outputs(step, &state.y.mechanics, length) };
            bond.scheme.receive(Side::Mechanics, &sample)?;
        }
        Ok(())
    }

    /// Puts the micro steps of all bonds together.
    fn log_inside(&mut self) {
        let Star { bonds, state, .. } = &mut *self.star;
        let (Some(log), n) = (&mut state.inside, state.u.len()) else { return };
        let count = bonds[0].state.inside.as_ref().map_or(0, Trajectory::len);
        for j in 0..count {
            let row = log.push_row();
            for bond in &*bonds {
                let Some(own) = bond.state.inside.as_ref().map(|own| own.row(j)) else { continue };
                row[..2].copy_from_slice(&own[..2]);
                for &of in &bond.rows {
                    for column in [2 + of, 2 + n + of, 2 + 2 * n + of] {
                        row[column] = own[column];
                    }
                }
            }
        }
        bonds.iter_mut().filter_map(|bond| bond.state.inside.as_mut()).for_each(|own| own.forget(count));
    }

    /// Shows the communication point at which `step` starts.
    pub(crate) fn show(
        &mut self,
        step: MacroStep,
        effective_mass: Option<f64>,
        observe: &mut dyn FnMut(CommunicationPoint<'_>),
    ) {
        let interface_residual = self.interface_work().residual_j();
        let state = &mut self.star.state;
        observe(CommunicationPoint {
            time: state.time,
            y: state.y.as_ref().map(Vec::as_slice),
            received: &state.received,
            effective_mass,
            audit: None,
            mechanics_step: self.setup.mechanics_step(step),
            interface_residual,
            interface_lambda: state.model.as_ref().map(|_| state.correlation.lambda.max(state.loaded.lambda)),
            inside: state.inside.as_mut(),
            sides: self.sides.lend(),
        });
    }

    pub(crate) fn interface_work(&mut self) -> InterfaceWork {
        let received_j = self.sides.mechanics.capabilities().interface_work();
        let sent = self.star.bonds.iter().map(|bond| bond.state.work_sent.sent());
        InterfaceWork { sent_j: sent.sum(), received_j }
    }

    /// The effective mass that the first bond reports, kg.
    pub(crate) fn effective_mass(&mut self) -> Option<f64> {
        self.star.bonds[0].scheme.report().effective_mass
    }

    /// What all schemes report: the first one, with the work of all.
    fn scheme_report(&mut self) -> SchemeReport {
        let StarState { correlation, loaded, model, .. } = &self.star.state;
        let [free, loaded] = [correlation.found, loaded.found];
        let interface = model.as_ref().map(|_| InterfaceCorrelation {
            lambda: free.lambda.max(loaded.lambda),
            largest: free.largest.max(loaded.largest),
        });
        let reports = self.star.bonds.iter_mut().map(|bond| bond.scheme.report());
        let sum = reports.reduce(|mut sum, report| {
            sum.counters.add(&report.counters);
            sum
        });
        SchemeReport { interface, ..sum.unwrap_or_default() }
    }

    fn report(mut self, log: Log, ended: std::result::Result<End, Failure>) -> Report {
        let scheme = self.scheme_report();
        let work = Work {
            cosim: self.star.state.counters,
            sides: PerSide::from_fn(|side| self.sides[side].counters()),
            scheme: scheme.counters,
        };
        let interface_work = self.interface_work();
        let work_of =
            |bond: &Bond| InterfaceWork { sent_j: bond.state.work_sent.sent(), received_j: Some(bond.work_received) };
        let mut bonds = std::mem::take(&mut self.star.state.work);
        bonds.extend(self.star.bonds.iter().map(work_of));
        let StarState { time, diverged, inside, booked, .. } = &mut self.star.state;
        let (inside, booked_micro_steps) = (inside.take(), *booked);
        let outcome = log.outcome(*time, diverged.take(), ended);
        let report = log.of_sides(outcome, *time, self.sides, interface_work);
        Report { work, scheme, inside, bonds, booked_micro_steps, ..report }
    }
}

/// Says why the actuators of these sides cannot be divided among bonds by a plan, if they cannot.
pub fn cannot_divide(plan: &StarPlan, sides: Sides<'_>) -> Option<String> {
    let rows = sides.actuator.ports().outputs.len();
    if rows < 2 {
        return Some("the interface has one row, so that there is nothing to split: use rim-nonsmooth-gap".to_owned());
    }
    let bonds = plan.partition.rows(rows).unwrap_or_default();
    (0..rows).find_map(|row| {
        let actuators = sides.actuator.capabilities();
        if actuators.actuator_of_row(row).is_none() {
            return Some(NOT_APART.to_owned());
        }
        let of = actuators.rows_beside(row);
        let divided = bonds.iter().any(|bond| bond.contains(&row) && !of.iter().all(|row| bond.contains(row)));
        let named = || numbers(of.iter().copied(), ", ");
        let whole =
            divided.then(|| format!("partition = {} divides an actuator, that of rows {}", plan.partition, named()));
        let law = || {
            let what = format!("known = law takes actuators of one row each, and one has rows {}", named());
            (of.len() > 1 && plan.known == Known::Law).then_some(what)
        };
        whole.or_else(law)
    })
}
