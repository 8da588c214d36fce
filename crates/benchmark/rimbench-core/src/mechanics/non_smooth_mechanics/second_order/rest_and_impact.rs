//! The contacts in a piece of a step: those that rest, those that close, and the impacts of those that collide.

use super::SecondOrderSteps;
use super::excitation::Excitation;
use super::sub_step::SubStepContacts;
use crate::error::Failure;
use crate::mechanics::NonSmoothMechanics;
use crate::mechanics::cubic::HermiteCubic;
use crate::mechanics::mechanical_model::MechanicalModel;

/// A rebound that would be over within this share of the step counts as rest; what is cut off is a hop of the height
/// `REST² a h²/8`.
const REST: f64 = 0.05;
/// How many times the last local error of a row its gap and velocity may be, to count as closed and at rest.
const CONFIDENCE: f64 = 2.0;
/// Times that an event is looked for again at most, and within which share of the step it must be found again.
const MOST_CORRECTIONS: u32 = 3;
const CLOSE: f64 = 1e-6;

/// The event that ends a piece before the step does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Event {
    Closing(usize),
    Switch(usize),
}

impl SecondOrderSteps {
    /// Counts contacts as resting whose gap and velocity are within what the steps themselves make of a resting
    /// contact.
    ///
    /// ```text
    /// g ≤ C |e_g| H³ + rounding        |w| ≤ C |e_w| H² + rounding
    /// e_g = (g⁺ − g − ½h (w + w⁺))/h³,  e_w = (A(q⁺) v⁺ − A_m v⁺ − ½h Ȧ v)/h²        of the last piece
    /// ```
    pub(super) fn note_rest(&mut self) {
        for contact in 0..self.resting.len() {
            let [gap, w] = self.tolerances(contact);
            self.resting[contact] |= self.start.gap[contact] <= gap && self.start.w[contact].abs() <= w;
        }
    }

    /// Gap (m) and velocity (m/s) up to which a contact cannot be told from one that rests.
    fn tolerances(&self, contact: usize) -> [f64; 2] {
        let [of_gap, of_velocity] = self.start.rounding;
        let gap = CONFIDENCE * self.gap_error[contact] * self.length.powi(3) + of_gap;
        let w = CONFIDENCE * self.velocity_error[contact] * self.length.powi(2) + of_velocity;
        [gap, w.max(gap / self.length)]
    }

    /// Tells whether a contact is closed, does not rest, and closes further.
    pub(super) fn collides_at_once(&self) -> bool {
        (0..self.resting.len()).any(|contact| {
            let [gap, w] = self.tolerances(contact);
            !self.resting[contact] && self.start.gap[contact] <= gap && self.start.w[contact] < -w
        })
    }
}

impl<M: MechanicalModel> NonSmoothMechanics<M> {
    /// Takes a piece up to the first event within `left` (s), and says after what time (s) that is and what it is;
    /// where there is none it takes all of it.
    pub(super) fn go_to_event(
        &mut self,
        steps: &mut SecondOrderSteps,
        drive: &mut Excitation<'_, '_>,
        left: f64,
    ) -> Result<Option<(f64, Event)>, Failure> {
        self.try_piece(steps, drive, left, SubStepContacts::Resting)?;
        let mut tried = left;
        let mut found = self.first_event(steps, left);
        for _ in 0..=MOST_CORRECTIONS {
            let Some((time, _)) = found else { break };
            // An event in the last billionth of a piece is one at its end.
            let time = if time < left * (1.0 - 1e-9) { time } else { left };
            if time == tried {
                break;
            }
            self.restore(steps);
            // At its very start there is none. Under a force that is held the time has passed nevertheless; one that
            // varies acts in full.
            if time <= 1e-9 * steps.length {
                return Ok(found.map(|(_, event)| (if drive.varies() { 0.0 } else { time }, event)));
            }
            self.try_piece(steps, drive, time, SubStepContacts::Resting)?;
            tried = time;
            if drive.varies() {
                found = self.find_again(steps, (time, left), found);
            }
        }
        self.accept_piece(steps, drive, tried)?;
        Ok(found.map(|(_, event)| (tried, event)))
    }

    /// Looks for the first event again in a piece of `time` (s) whose force is not that of the piece in which it was
    /// found.
    fn find_again(
        &self,
        steps: &mut SecondOrderSteps,
        (time, left): (f64, f64),
        found: Option<(f64, Event)>,
    ) -> Option<(f64, Event)> {
        let close = CLOSE * steps.length;
        if let Some(earlier) = self.first_event(steps, time).filter(|(earlier, _)| *earlier < time - close) {
            return Some(earlier);
        }
        let (_, event) = found?;
        let (before, [value, rate]) = match event {
            Event::Closing(contact) => {
                let rows = &self.stepper.eq3.unilateral;
                (steps.start.gap[contact], [rows.position[contact], rows.velocity(contact, &self.stepper.v)])
            }
            Event::Switch(switch) => (steps.start.switches[switch][0], steps.switches[switch]),
        };
        // Under this force it may turn back before it gets there.
        let turned = before * value > 0.0 && value * rate >= 0.0;
        let later = if turned { f64::INFINITY } else { -value / rate };
        match later > close {
            // Beyond the end of the step.
            true if time >= left => None,
            true => Some(((time + later).min(left), event)),
            false => Some((time, event)),
        }
    }

    /// Finds what happens first in a piece of `h` (s) that has been tried.
    pub(super) fn first_event(&self, steps: &mut SecondOrderSteps, h: f64) -> Option<(f64, Event)> {
        let (stepper, start) = (&self.stepper, &steps.start);
        let mut first: Option<(f64, Event)> = None;
        let mut note = |time: Option<f64>, event: Event| {
            if let Some(time) = time
                && first.is_none_or(|(earliest, _)| time < earliest)
            {
                first = Some((time, event));
            }
        };
        for contact in (0..steps.resting.len()).filter(|&contact| !steps.resting[contact]) {
            let rows = &stepper.eq3.unilateral;
            let end = [rows.position[contact], rows.velocity(contact, &stepper.v)];
            let gap = HermiteCubic::new([start.gap[contact], start.w[contact]], end, h);
            note(gap.first_fall(), Event::Closing(contact));
        }
        self.model.switch_values(&stepper.q, &stepper.v, &mut steps.switches);
        for (switch, (from, to)) in start.switches.iter().zip(&steps.switches).enumerate() {
            if steps.passed != Some(switch) {
                note(HermiteCubic::new(*from, *to, h).first_change(), Event::Switch(switch));
            }
        }
        first
    }

    /// Lets all contacts collide that are closed where the system stands, `located` among them, and finds out which
    /// rest afterwards.
    pub(super) fn pass_impact(&mut self, steps: &mut SecondOrderSteps, located: Option<usize>) -> Result<(), Failure> {
        self.note_start(steps);
        steps.set.clear();
        for contact in 0..steps.resting.len() {
            let [gap, w] = steps.tolerances(contact);
            let closed = steps.start.gap[contact] <= gap && steps.start.w[contact] <= w;
            if steps.resting[contact] || closed || located == Some(contact) {
                steps.set.push(contact, 0.0);
            }
        }
        self.stepper.collide(&mut steps.set)?;
        self.linearise();
        for slot in 0..steps.set.contacts.len() {
            let contact = steps.set.contacts[slot];
            let w = self.stepper.eq3.unilateral.velocity(contact, &self.stepper.v);
            let pressed = -self.stepper.free_acceleration(contact, &steps.joint.force);
            let [_, slow] = steps.tolerances(contact);
            // A hop at velocity w under this acceleration is over after 2 w/a.
            steps.resting[contact] = w <= slow.max(0.5 * REST * steps.length * pressed);
        }
        Ok(())
    }
}
