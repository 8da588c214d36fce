//! Mechanics of the second order: the midpoint rule, over whole steps and from event to event.

mod excitation;
mod rest_and_impact;
mod sub_step;

pub(super) use excitation::Excitation;

use super::super::contact_stepper::{ActiveProblem, ContactStepper};
use super::super::mechanical_model::{MechanicalModel, ModelSize};
use super::NonSmoothMechanics;
use crate::cosim::SecondOrder;
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
        steps.length = h;
        self.choose_implicit(h);
        if !std::mem::replace(&mut steps.acceleration_known, true) {
            self.find_first_acceleration(steps, &mut drive, h)?;
        }
        match steps.rule {
            SecondOrder::Midpoint => {
                self.note_start(steps);
                self.try_piece(steps, &mut drive, h, SubStepContacts::Gap)?;
                self.accept_piece(steps, &mut drive, h)
            }
            SecondOrder::EventSplit => self.step_from_event_to_event(steps, &mut drive),
        }?;
        // Models whose rows change are not stepped here; others say whether what they list still holds.
        let ContactStepper { q, v, .. } = &self.stepper;
        self.model.remap_contacts(q, v, h).map(drop)
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

    fn step_from_event_to_event(
        &mut self,
        steps: &mut SecondOrderSteps,
        drive: &mut Excitation<'_, '_>,
    ) -> Result<(), Failure> {
        let length = steps.length;
        let (mut done, mut splits) = (0.0, 0);
        while done < length {
            let left = length - done;
            self.note_start(steps);
            steps.note_rest();
            if splits >= MOST_SPLITS {
                self.stepper.count_split_fallback();
                self.try_piece(steps, drive, left, SubStepContacts::Gap)?;
                self.accept_piece(steps, drive, left)?;
                break;
            }
            if steps.collides_at_once() {
                self.pass_impact(steps, None)?;
                splits += 1;
                continue;
            }
            let Some((time, event)) = self.go_to_event(steps, drive, left)? else { break };
            splits += 1;
            self.stepper.count_split();
            done = if time < left { done + time } else { length };
            steps.passed = None;
            match event {
                Event::Closing(contact) => self.pass_impact(steps, Some(contact))?,
                Event::Switch(switch) => steps.passed = Some(switch),
            }
        }
        self.stepper.set_closed(&steps.resting);
        Ok(())
    }
}
