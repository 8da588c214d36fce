//! Mechanics of the second order: the midpoint rule, over whole steps and from event to event.

mod excitation;
mod rest_and_impact;
mod sub_step;

pub(super) use excitation::Excitation;

use super::super::contact_stepper::ActiveProblem;
use super::super::mechanical_model::{MechanicalModel, ModelSize};
use super::NonSmoothMechanics;
use crate::cosim::{JointActuator, SecondOrder, Sent};
use crate::error::Failure;
use crate::interface_model::TOUCHING;
use excitation::InterfaceTrajectory;
use rest_and_impact::Event;
use sub_step::{PieceStart, SubStepContacts};

/// Splits of one step beyond which the rest of it is taken with the gap law. A rebound is cut off at a twentieth of a
/// step, so that even one of 0.95 has no more than this many within a step.
const MOST_SPLITS: u32 = 64;

/// The memory of a mechanics of the second order, and room to work.
#[derive(Debug, Clone)]
pub(super) struct SecondOrderSteps {
    rule: SecondOrder,
    set: ActiveProblem,
    /// Contacts that rest: their rows are kept at velocity level.
    resting: Vec<bool>,
    /// Acceleration of the last smooth piece, and whether there has been one.
    acceleration: Vec<f64>,
    acceleration_known: bool,
    /// State, rows and ledger at the start of a piece.
    start: PieceStart,
    /// Velocities of the contact rows at its end, as the step has them.
    row_velocity: Vec<f64>,
    /// Local errors of gap (m/s³) and of velocity (m/s²) of each row, per `h³` and `h²`.
    gap_error: Vec<f64>,
    velocity_error: Vec<f64>,
    /// Switches at the end of a piece, and the one at which the last piece ended.
    switches: Vec<[f64; 2]>,
    passed: Option<usize>,
    /// Of the whole step, s.
    length: f64,
    middle: [Vec<f64>; 2],
    joint: InterfaceTrajectory,
    /// Of a joint step that stands at an event, with the time of the actuator's state, s.
    interrupted: Option<(Progress, f64)>,
}

/// How far a step from event to event has come.
#[derive(Debug, Clone, Copy, Default)]
struct Progress {
    /// Time that is over, s.
    done: f64,
    splits: u32,
    /// What ended the last piece and has not acted yet.
    met: Option<Met>,
}

/// What happens between two pieces.
#[derive(Debug, Clone, Copy)]
enum Met {
    /// The impact of a contact that was located, or of those that collide where the piece begins.
    Impact(Option<usize>),
    Switch(usize),
}

impl SecondOrderSteps {
    pub(super) fn new<M: MechanicalModel>(rule: SecondOrder, model: &M) -> Self {
        let size = model.size();
        let ModelSize { velocities: n, unilateral: n_u, interface: n_i, .. } = size;
        let zeros = |count: usize| vec![0.0; count];
        SecondOrderSteps {
            rule,
            set: ActiveProblem::new(n_u),
            resting: vec![false; n_u],
            acceleration: zeros(n),
            acceleration_known: false,
            start: PieceStart::new(size),
            row_velocity: zeros(n_u),
            gap_error: zeros(n_u),
            velocity_error: zeros(n_u),
            switches: vec![[0.0; 2]; size.switches],
            passed: None,
            length: f64::INFINITY,
            middle: [zeros(n), zeros(n)],
            joint: InterfaceTrajectory::new(n_i),
            interrupted: None,
        }
    }
}

impl<M: MechanicalModel> NonSmoothMechanics<M> {
    /// Advances by `h` (s) by a rule of the second order.
    pub(super) fn step_second_order(
        &mut self,
        steps: &mut SecondOrderSteps,
        mut drive: Excitation<'_, '_>,
        h: f64,
    ) -> Result<(), Failure> {
        self.begin_step(steps, &mut drive, h)?;
        match steps.rule {
            SecondOrder::Midpoint => {
                self.note_start(steps);
                self.try_piece(steps, &mut drive, h, SubStepContacts::Gap)?;
                self.accept_piece(steps, &mut drive, h)
            }
            SecondOrder::EventSplit => {
                let mut progress = Progress::default();
                while self.go_on(steps, &mut drive, &mut progress)? {}
                self.stepper.set_closed(&steps.resting);
                Ok(())
            }
        }?;
        self.model.check_contact_list(&self.stepper.q)
    }

    /// Advances both sides by `h` (s) from `time`, or to the next event: returns the time (s) of the step that is over
    /// where one is met, before it acts and once more after it, to be called again with the same step until it is over.
    pub(super) fn step_to_event(
        &mut self,
        steps: &mut SecondOrderSteps,
        actuator: &mut dyn JointActuator,
        (time, h): (f64, f64),
        sent: &mut Sent<'_>,
    ) -> Result<Option<f64>, Failure> {
        if steps.rule == SecondOrder::Midpoint {
            return self.step_second_order(steps, Excitation::Together { actuator, time, sent }, h).map(|()| None);
        }
        let interrupted = steps.interrupted.take();
        let (mut progress, time) = interrupted.unwrap_or((Progress::default(), time));
        let mut drive = Excitation::Together { actuator, time, sent };
        if interrupted.is_none() {
            self.begin_step(steps, &mut drive, h)?;
        }
        let at_event = self.go_on(steps, &mut drive, &mut progress)?;
        self.stepper.set_closed(&steps.resting);
        let Excitation::Together { time, .. } = drive else { unreachable!("both sides step together") };
        if at_event {
            steps.interrupted = Some((progress, time));
            return Ok(Some(progress.done));
        }
        self.model.check_contact_list(&self.stepper.q).map(|()| None)
    }

    fn begin_step(
        &mut self,
        steps: &mut SecondOrderSteps,
        drive: &mut Excitation<'_, '_>,
        h: f64,
    ) -> Result<(), Failure> {
        steps.length = h;
        self.choose_implicit(h);
        if !std::mem::replace(&mut steps.acceleration_known, true) {
            self.find_first_acceleration(steps, drive, h)?;
        }
        Ok(())
    }

    /// Tries the first piece to know the acceleration in its middle.
    #[cold]
    fn find_first_acceleration(
        &mut self,
        steps: &mut SecondOrderSteps,
        drive: &mut Excitation<'_, '_>,
        h: f64,
    ) -> Result<(), Failure> {
        for (resting, gap) in steps.resting.iter_mut().zip(&self.stepper.eq3.unilateral.position) {
            *resting = *gap <= TOUCHING;
        }
        self.note_start(steps);
        let law = if steps.rule == SecondOrder::EventSplit { SubStepContacts::Resting } else { SubStepContacts::Gap };
        self.try_piece(steps, drive, h, law)?;
        self.note_acceleration(steps, h);
        self.restore(steps);
        Ok(())
    }

    /// Lets act what ended the last piece, or takes a piece; tells whether an event has been met or has acted, and else
    /// the step is over.
    fn go_on(
        &mut self,
        steps: &mut SecondOrderSteps,
        drive: &mut Excitation<'_, '_>,
        progress: &mut Progress,
    ) -> Result<bool, Failure> {
        let length = steps.length;
        match progress.met.take() {
            Some(Met::Impact(contact)) => return self.pass_impact(steps, contact).map(|()| true),
            Some(Met::Switch(switch)) => {
                steps.passed = Some(switch);
                return Ok(true);
            }
            None if progress.done >= length => return Ok(false),
            None => {}
        }
        let left = length - progress.done;
        self.note_start(steps);
        steps.note_rest();
        if progress.splits >= MOST_SPLITS {
            self.stepper.count_split_fallback();
            self.try_piece(steps, drive, left, SubStepContacts::Gap)?;
            return self.accept_piece(steps, drive, left).map(|()| false);
        }
        if steps.collides_at_once() {
            progress.met = Some(Met::Impact(None));
            progress.splits += 1;
            return Ok(true);
        }
        let Some((time, event)) = self.go_to_event(steps, drive, left)? else { return Ok(false) };
        progress.splits += 1;
        self.stepper.count_split();
        progress.done = if time < left { progress.done + time } else { length };
        steps.passed = None;
        progress.met = Some(match event {
            Event::Closing(contact) => Met::Impact(Some(contact)),
            Event::Switch(switch) => Met::Switch(switch),
        });
        Ok(true)
    }
}
