//! Mechanics of the second order: the midpoint rule, and the same from event to event.

use super::contact_stepper::ContactSet;
use super::cubic::HermiteCubic;
use super::energy_ledger::EnergyLedger;
use super::mechanical_model::{MechanicalModel, ModelSize};
use super::non_smooth_mechanics::NonSmoothMechanics;
use crate::cosim::{JointActuator, JointSteps, OutputRates, SecondOrder, Sent};
use crate::error::{Cause, Failure};
use crate::interface_model::{TOUCHING, gap_velocity};

/// Splits of one step beyond which the rest of it is taken with the gap law. A rebound is cut off at [`REST`] of a step, so that even
/// one of 0.95 has no more than this many within a step.
const MOST_SPLITS: u32 = 64;
/// A rebound that would be over within this share of the step counts as rest; what is cut off is a hop of the height
/// `REST² a h²/8`.
const REST: f64 = 0.05;
/// How many times the last local error of a row its gap and velocity may be, to count as closed and at rest.
const CONFIDENCE: f64 = 2.0;
/// Iterations by which force and motion of a piece must agree, and how well (relative to the largest force so far).
const MOST_ITERATIONS: u32 = 50;
const AGREEMENT: f64 = 1e-12;
/// Share of the step from which the local errors of a piece are taken for those of the step.
const TELLING: f64 = 0.1;
/// Rounding of positions and velocities, relative to the largest.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// What a mechanics of the second order remembers, and room to work.
#[derive(Debug, Clone)]
pub(super) struct SecondOrderSteps {
    rule: SecondOrder,
    set: ContactSet,
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
    joint: Joint,
}

/// Force and motion at the interface in a piece.
#[derive(Debug, Clone)]
struct Joint {
    /// `[s; w]` at its start, at its end, and in the mean.
    start: Vec<f64>,
    end: Vec<f64>,
    mean: Vec<f64>,
    /// The actuator's outputs in its middle, with the motion of its start.
    middle_force: Vec<f64>,
    /// What acts, N, and the largest that has acted so far.
    force: Vec<f64>,
    largest: f64,
    rates: OutputRates,
}

/// Where a piece starts.
#[derive(Debug, Clone)]
struct PieceStart {
    q: Vec<f64>,
    v: Vec<f64>,
    gap: Vec<f64>,
    w: Vec<f64>,
    joint_error: Vec<f64>,
    switches: Vec<[f64; 2]>,
    ledger: EnergyLedger,
    displacement: Vec<f64>,
}

/// What ends a piece before the step does.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Event {
    Closing(usize),
    Switch(usize),
}

/// What pushes the mechanics in a step.
pub(super) enum Drive<'a, 'b> {
    /// Interface forces (N) that are held.
    Force(&'a [f64]),
    /// An actuator that takes every piece with the mechanics.
    Together {
        /// The actuator, in the state that belongs to the mechanics'.
        actuator: &'a mut dyn JointActuator,
        /// Time of that state, s.
        time: f64,
        /// Is told length (s), force and mean motion of each piece.
        sent: &'a mut Sent<'b>,
    },
}

/// Which contacts a piece knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Law {
    /// Those that rest.
    Resting,
    /// All, with the gap law of the piece.
    Gap,
}

impl SecondOrderSteps {
    pub(super) fn new<M: MechanicalModel>(rule: SecondOrder, model: &M) -> Self {
        let ModelSize { velocities: n, unilateral: n_u, bilateral: n_b, interface: n_i } = model.size();
        let zeros = |count: usize| vec![0.0; count];
        let switches = vec![[0.0; 2]; model.switches()];
        SecondOrderSteps {
            rule,
            set: ContactSet::new(n_u),
            resting: vec![false; n_u],
            acceleration: zeros(n),
            acceleration_known: false,
            start: PieceStart {
                q: zeros(n),
                v: zeros(n),
                gap: zeros(n_u),
                w: zeros(n_u),
                joint_error: zeros(n_b),
                switches: switches.clone(),
                ledger: EnergyLedger::default(),
                displacement: zeros(n_i),
            },
            row_velocity: zeros(n_u),
            gap_error: zeros(n_u),
            velocity_error: zeros(n_u),
            switches,
            passed: None,
            length: f64::INFINITY,
            middle: [zeros(n), zeros(n)],
            joint: Joint {
                start: zeros(2 * n_i),
                end: zeros(2 * n_i),
                mean: zeros(2 * n_i),
                middle_force: zeros(n_i),
                force: zeros(n_i),
                largest: f64::MIN_POSITIVE,
                rates: OutputRates::zeros(n_i, 2 * n_i),
            },
        }
    }
}

impl<M: MechanicalModel> NonSmoothMechanics<M> {
    /// Advances by `h` (s) by a rule of the second order.
    pub(super) fn step_second_order(
        &mut self,
        steps: &mut SecondOrderSteps,
        mut drive: Drive<'_, '_>,
        h: f64,
    ) -> Result<(), Failure> {
        steps.length = h;
        if !std::mem::replace(&mut steps.acceleration_known, true) {
            self.find_first_acceleration(steps, &mut drive, h)?;
        }
        match steps.rule {
            SecondOrder::Midpoint => {
                self.note_start(steps);
                self.try_piece(steps, &mut drive, h, h, Law::Gap)?;
                self.accept_piece(steps, &mut drive, h)
            }
            SecondOrder::EventSplit => self.step_from_event_to_event(steps, &mut drive, h),
        }
    }

    /// Tries the first piece to know the acceleration in its middle.
    #[cold]
    fn find_first_acceleration(
        &mut self,
        steps: &mut SecondOrderSteps,
        drive: &mut Drive<'_, '_>,
        h: f64,
    ) -> Result<(), Failure> {
        for (resting, gap) in steps.resting.iter_mut().zip(&self.stepper.eq3.unilateral.position) {
            *resting = *gap <= TOUCHING;
        }
        self.note_start(steps);
        let law = if steps.rule == SecondOrder::EventSplit { Law::Resting } else { Law::Gap };
        self.try_piece(steps, drive, h, h, law)?;
        self.note_acceleration(steps, h);
        self.restore(steps);
        Ok(())
    }

    fn step_from_event_to_event(
        &mut self,
        steps: &mut SecondOrderSteps,
        drive: &mut Drive<'_, '_>,
        length: f64,
    ) -> Result<(), Failure> {
        let (mut done, mut splits) = (0.0, 0);
        while done < length {
            let left = length - done;
            self.note_start(steps);
            self.note_rest(steps, length);
            if splits >= MOST_SPLITS {
                self.stepper.note_split_fallback();
                self.try_piece(steps, drive, left, length, Law::Gap)?;
                self.accept_piece(steps, drive, left)?;
                break;
            }
            if self.collides_at_once(steps, length) {
                self.pass_impact(steps, None, length)?;
                splits += 1;
                continue;
            }
            self.try_piece(steps, drive, left, length, Law::Resting)?;
            let Some((time, event)) = self.first_event(steps, left) else {
                self.accept_piece(steps, drive, left)?;
                break;
            };
            splits += 1;
            self.stepper.note_split();
            // At its very end the piece stands as it is; at its very start there is none.
            if time < left * (1.0 - 1e-9) {
                self.restore(steps);
                if time > 1e-9 * length {
                    self.try_piece(steps, drive, time, length, Law::Resting)?;
                    self.accept_piece(steps, drive, time)?;
                }
                done += time;
            } else {
                self.accept_piece(steps, drive, left)?;
                done = length;
            }
            steps.passed = None;
            match event {
                Event::Closing(contact) => self.pass_impact(steps, Some(contact), length)?,
                Event::Switch(switch) => steps.passed = Some(switch),
            }
        }
        self.stepper.set_closed(&steps.resting);
        Ok(())
    }

    /// Notes state, rows and ledger as they stand.
    fn note_start(&mut self, steps: &mut SecondOrderSteps) {
        let PieceStart { q, v, gap, w, joint_error, switches, ledger, displacement } = &mut steps.start;
        let eq3 = &self.stepper.eq3;
        q.copy_from_slice(&self.stepper.q);
        v.copy_from_slice(&self.stepper.v);
        gap.copy_from_slice(&eq3.unilateral.position);
        for (contact, w) in w.iter_mut().enumerate() {
            *w = eq3.unilateral.velocity(contact, v);
        }
        joint_error.copy_from_slice(&eq3.bilateral.position);
        self.model.switch_values(q, v, switches);
        *ledger = self.stepper.ledger;
        displacement.copy_from_slice(self.stepper.interface_displacement());
    }

    /// Takes back the piece since [`note_start`](Self::note_start).
    fn restore(&mut self, steps: &SecondOrderSteps) {
        self.stepper.q.copy_from_slice(&steps.start.q);
        self.stepper.v.copy_from_slice(&steps.start.v);
        self.stepper.ledger = steps.start.ledger;
        self.stepper.set_interface_displacement(&steps.start.displacement);
        self.linearise();
    }

    /// Counts contacts as resting whose gap and velocity are within what the steps themselves make of a resting contact.
    ///
    /// ```text
    /// g ≤ C |e_g| H³ + rounding        |w| ≤ C |e_w| H² + rounding
    /// e_g = (g⁺ − g − ½h (w + w⁺))/h³,  e_w = (A(q⁺) v⁺ − A_m v⁺ − ½h Ȧ v)/h²        of the last piece
    /// ```
    fn note_rest(&self, steps: &mut SecondOrderSteps, length: f64) {
        for contact in 0..steps.resting.len() {
            let [gap, w] = self.tolerances(steps, contact, length);
            steps.resting[contact] |= steps.start.gap[contact] <= gap && steps.start.w[contact].abs() <= w;
        }
    }

    /// Gap (m) and velocity (m/s) up to which a contact cannot be told from one that rests.
    fn tolerances(&self, steps: &SecondOrderSteps, contact: usize, length: f64) -> [f64; 2] {
        let largest = |values: &[f64]| values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let gap = CONFIDENCE * steps.gap_error[contact] * length.powi(3) + ROUNDING * largest(&steps.start.q);
        let w = CONFIDENCE * steps.velocity_error[contact] * length.powi(2) + ROUNDING * largest(&steps.start.v);
        [gap, w.max(gap / length)]
    }

    /// Whether a contact is closed, does not rest, and closes further.
    fn collides_at_once(&self, steps: &SecondOrderSteps, length: f64) -> bool {
        (0..steps.resting.len()).any(|contact| {
            let [gap, w] = self.tolerances(steps, contact, length);
            !steps.resting[contact] && steps.start.gap[contact] <= gap && steps.start.w[contact] < -w
        })
    }

    /// Takes a piece of `h` (s) of a step of `length` (s) from where the system stands, under forces that fit it.
    ///
    /// ```text
    /// λ = y_m + D (ū − u)        y_m = y(x, u) + ½h r,   ū = (s + ½h w̄, w̄),   w̄ = ½ (w + w⁺)
    /// ```
    /// With an actuator, force and motion are found by iteration: they move each other by `½h H_ii D_w`, a small number.
    /// # Errors
    /// [`Cause::NotConverged`] if they do not agree.
    fn try_piece(
        &mut self,
        steps: &mut SecondOrderSteps,
        drive: &mut Drive<'_, '_>,
        h: f64,
        length: f64,
        law: Law,
    ) -> Result<(), Failure> {
        let Drive::Together { actuator, time, .. } = drive else {
            if let Drive::Force(lambda) = drive {
                steps.joint.force.copy_from_slice(lambda);
            }
            return self.advance_piece(steps, h, length, law);
        };
        self.stepper.interface_motion(&mut steps.joint.start);
        let Joint { start, middle_force, force, rates, .. } = &mut steps.joint;
        actuator.outputs_and_rates(*time, start, middle_force, rates)?;
        for (force, rate) in middle_force.iter_mut().zip(&rates.rate) {
            *force += 0.5 * h * rate;
        }
        force.copy_from_slice(middle_force);
        let mut residual = f64::INFINITY;
        for _ in 0..MOST_ITERATIONS {
            self.advance_piece(steps, h, length, law)?;
            residual = self.meet(&mut steps.joint, h);
            if residual <= AGREEMENT {
                return Ok(());
            }
            self.restore(steps);
        }
        Err(Cause::NotConverged { residual, iterations: MOST_ITERATIONS }.into())
    }

    /// Gives the force that belongs to the motion just found; returns by how much the last one was different, relative to the largest so
    /// far.
    fn meet(&mut self, joint: &mut Joint, h: f64) -> f64 {
        let Joint { start, end, mean, middle_force, force, largest, rates } = joint;
        self.stepper.interface_motion(end);
        let n_i = force.len();
        for i in 0..n_i {
            mean[n_i + i] = 0.5 * (start[n_i + i] + end[n_i + i]);
            mean[i] = start[i] + 0.5 * h * mean[n_i + i];
        }
        let mut change = 0.0_f64;
        for (i, force) in force.iter_mut().enumerate() {
            let d = &rates.feedthrough[2 * n_i * i..2 * n_i * (i + 1)];
            let follows: f64 =
                d.iter().zip(mean.iter().zip(&*start)).map(|(d, (mean, start))| d * (mean - start)).sum();
            let met = middle_force[i] + follows;
            change = change.max((met - *force).abs());
            *largest = largest.max(met.abs());
            *force = met;
        }
        change / *largest
    }

    /// Takes a piece of `h` (s) of a step of `length` (s) from where the system stands.
    fn advance_piece(&mut self, steps: &mut SecondOrderSteps, h: f64, length: f64, law: Law) -> Result<(), Failure> {
        let SecondOrderSteps { set, resting, acceleration, start, row_velocity, middle: [q_m, v_m], joint, .. } = steps;
        for (q_m, (q, v)) in q_m.iter_mut().zip(start.q.iter().zip(&start.v)) {
            *q_m = q + 0.5 * h * v;
        }
        v_m.copy_from_slice(&start.v);
        for (v_m, acceleration) in v_m.iter_mut().zip(&*acceleration) {
            *v_m += 0.5 * h * acceleration;
        }
        let before = self.stepper.kinetic_energy();
        self.linearise_at(q_m, v_m);
        let stabilisation = self.stepper.stabilisation();
        // However short a piece is, a drift decays as slowly as in the whole step: a piece of a nanosecond would make metres per
        // second of a nanometre.
        let drift = stabilisation / length;
        set.clear();
        for (contact, &gap) in start.gap.iter().enumerate() {
            match law {
                Law::Resting if resting[contact] => set.push(contact, drift * gap),
                Law::Resting => {}
                Law::Gap => set.push(contact, gap_velocity(gap, h, h, stabilisation)),
            }
        }
        let eq3 = &mut self.stepper.eq3;
        for convective in eq3.bilateral.convective.iter_mut().chain(&mut eq3.unilateral.convective) {
            *convective *= 0.5;
        }
        eq3.bilateral.position.copy_from_slice(&start.joint_error);
        let turned = self.stepper.kinetic_energy() - before;
        self.stepper.advance_from_middle(&joint.force, h, drift, set)?;
        let rows = &self.stepper.eq3.unilateral;
        for (contact, w) in row_velocity.iter_mut().enumerate() {
            *w = rows.velocity(contact, &self.stepper.v) + h * rows.convective[contact];
        }
        let before = self.stepper.kinetic_energy();
        self.linearise();
        self.stepper.ledger.inertia += turned + self.stepper.kinetic_energy() - before;
        Ok(())
    }

    /// Learns from a piece of `h` (s) that stands, and lets an actuator take it too.
    fn accept_piece(&mut self, steps: &mut SecondOrderSteps, drive: &mut Drive<'_, '_>, h: f64) -> Result<(), Failure> {
        self.note_acceleration(steps, h);
        for (&contact, &at_bound) in steps.set.contacts.iter().zip(&steps.set.at_bound) {
            steps.resting[contact] = at_bound;
        }
        let rows = &self.stepper.eq3.unilateral;
        // The errors of a short piece drown in rounding.
        let telling = h > TELLING * steps.length;
        for contact in (0..steps.resting.len()).filter(|_| telling) {
            let (gap, w) = (steps.start.gap[contact], steps.start.w[contact]);
            let (gap_after, w_after) = (rows.position[contact], rows.velocity(contact, &self.stepper.v));
            steps.gap_error[contact] = (gap_after - gap - 0.5 * h * (w + w_after)).abs() / h.powi(3);
            steps.velocity_error[contact] = (w_after - steps.row_velocity[contact]).abs() / h.powi(2);
        }
        steps.passed = None;
        if let Drive::Together { actuator, time, sent } = drive {
            sent(h, &steps.joint.force, &steps.joint.mean);
            actuator.step(*time, &steps.joint.mean, h)?;
            *time += h;
        }
        Ok(())
    }

    fn note_acceleration(&self, steps: &mut SecondOrderSteps, h: f64) {
        let change = self.stepper.v.iter().zip(&steps.start.v);
        for (acceleration, (after, before)) in steps.acceleration.iter_mut().zip(change) {
            *acceleration = (after - before) / h;
        }
    }

    /// Finds what happens first in a piece of `h` (s) that has been tried.
    fn first_event(&self, steps: &mut SecondOrderSteps, h: f64) -> Option<(f64, Event)> {
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
            let course = HermiteCubic::new([start.gap[contact], start.w[contact]], end, h);
            note(course.first_fall(), Event::Closing(contact));
        }
        self.model.switch_values(&stepper.q, &stepper.v, &mut steps.switches);
        for (switch, (from, to)) in start.switches.iter().zip(&steps.switches).enumerate() {
            if steps.passed != Some(switch) {
                note(HermiteCubic::new(*from, *to, h).first_change(), Event::Switch(switch));
            }
        }
        first
    }

    /// Lets all contacts collide that are closed where the system stands, `located` among them, and finds out which rest afterwards.
    fn pass_impact(
        &mut self,
        steps: &mut SecondOrderSteps,
        located: Option<usize>,
        length: f64,
    ) -> Result<(), Failure> {
        self.note_start(steps);
        steps.set.clear();
        for contact in 0..steps.resting.len() {
            let [gap, w] = self.tolerances(steps, contact, length);
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
            let [_, slow] = self.tolerances(steps, contact, length);
            // A hop at velocity w under this acceleration is over after 2 w/a.
            steps.resting[contact] = w <= slow.max(0.5 * REST * length * pressed);
        }
        Ok(())
    }
}

impl<M: MechanicalModel> JointSteps for NonSmoothMechanics<M> {
    fn step_together(
        &mut self,
        actuator: &mut dyn JointActuator,
        time: f64,
        h: f64,
        sent: &mut Sent<'_>,
    ) -> Result<(), Failure> {
        let together = Drive::Together { actuator, time, sent };
        self.with_second_order(|mechanics, steps| mechanics.step_second_order(steps, together, h)).unwrap_or(Ok(()))
    }
}
