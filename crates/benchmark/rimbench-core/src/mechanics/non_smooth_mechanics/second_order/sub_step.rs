//! One piece of a step of the second order: tried, taken back, or taken.

use super::SecondOrderSteps;
use super::excitation::{Excitation, InterfaceTrajectory};
use crate::cosim::JointActuator;
use crate::error::{Cause, Failure};
use crate::mechanics::NonSmoothMechanics;
use crate::mechanics::contact_stepper::MidpointStep;
use crate::mechanics::energy_ledger::EnergyLedger;
use crate::mechanics::mechanical_model::{MechanicalModel, ModelSize};
use rimbench_contact::contact_law::gap_velocity;

/// Iterations by which force and motion of a piece must agree, and how well (relative to the largest force so far).
const MOST_ITERATIONS: u32 = 50;
const AGREEMENT: f64 = 1e-12;
/// Share of the step from which the local errors of a piece are taken for those of the step.
const TELLING: f64 = 0.1;
/// Rounding of positions and velocities, relative to the largest.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Which contacts a piece knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SubStepContacts {
    /// Those that rest.
    Resting,
    /// All, with the gap law of the piece.
    Gap,
}

/// Where a piece starts.
#[derive(Debug, Clone)]
pub(super) struct PieceStart {
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    pub(super) gap: Vec<f64>,
    pub(super) w: Vec<f64>,
    pub(super) joint_error: Vec<f64>,
    pub(super) switches: Vec<[f64; 2]>,
    /// Rounding of positions (m) and velocities (m/s).
    pub(super) rounding: [f64; 2],
    pub(super) ledger: EnergyLedger,
}

impl PieceStart {
    /// Makes room for a piece of a system of this size.
    pub(super) fn new(size: ModelSize) -> Self {
        let zeros = |count: usize| vec![0.0; count];
        PieceStart {
            q: zeros(size.velocities),
            v: zeros(size.velocities),
            gap: zeros(size.unilateral),
            w: zeros(size.unilateral),
            joint_error: zeros(size.bilateral),
            switches: vec![[0.0; 2]; size.switches],
            rounding: [0.0; 2],
            ledger: EnergyLedger::default(),
        }
    }
}

impl<M: MechanicalModel> NonSmoothMechanics<M> {
    /// Notes state, rows and ledger as they stand.
    pub(super) fn note_start(&mut self, steps: &mut SecondOrderSteps) {
        let PieceStart { q, v, gap, w, joint_error, switches, rounding, ledger } = &mut steps.start;
        let eq3 = &self.stepper.eq3;
        q.copy_from_slice(&self.stepper.q);
        v.copy_from_slice(&self.stepper.v);
        gap.copy_from_slice(&eq3.unilateral.position);
        for (contact, w) in w.iter_mut().enumerate() {
            *w = eq3.unilateral.velocity(contact, v);
        }
        joint_error.copy_from_slice(&eq3.bilateral.position);
        self.model.switch_values(q, v, switches);
        let largest = |values: &[f64]| values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        *rounding = [ROUNDING * largest(q), ROUNDING * largest(v)];
        *ledger = self.stepper.energy.ledger;
    }

    /// Takes back the piece since [`note_start`](Self::note_start).
    pub(super) fn restore(&mut self, steps: &SecondOrderSteps) {
        self.stepper.q.copy_from_slice(&steps.start.q);
        self.stepper.v.copy_from_slice(&steps.start.v);
        self.stepper.energy.ledger = steps.start.ledger;
        self.linearise();
    }

    /// Takes a piece of `h` (s) of the step from where the system stands, under forces that fit it.
    ///
    /// ```text
    /// λ = y_m + D (ū − u)        y_m = y(x, u) + ½h r,   ū = (s + ½h w̄, w̄),   w̄ = ½ (w + w⁺)
    /// ```
    /// With an actuator, force and motion are found by iteration: they move each other by `½h H_ii D_w`, a small
    /// number.
    /// # Errors
    /// [`Cause::NotConverged`] if they do not agree.
    pub(super) fn try_piece(
        &mut self,
        steps: &mut SecondOrderSteps,
        drive: &mut Excitation<'_, '_>,
        h: f64,
        law: SubStepContacts,
    ) -> Result<(), Failure> {
        match drive {
            Excitation::Force(lambda) => {
                steps.joint.moment_known = false;
                steps.joint.force.copy_from_slice(lambda);
                self.advance_piece(steps, h, law)
            }
            Excitation::Prescribed { profile, done } => {
                let length = steps.length;
                // Rounding must not leave out the end of the step.
                let to = if *done + h < length * (1.0 - 1e-12) { (*done + h) / length } else { 1.0 };
                let InterfaceTrajectory { force, moment, moment_known, .. } = &mut steps.joint;
                profile.over(*done / length, to, force, moment);
                moment.iter_mut().for_each(|moment| *moment *= length * length);
                *moment_known = true;
                self.advance_piece(steps, h, law)
            }
            Excitation::Together { actuator, time, .. } => {
                steps.joint.moment_known = false;
                self.try_together(steps, *actuator, *time, h, law)
            }
        }
    }

    /// Finds force and motion that fit each other in a piece of `h` (s) that starts at `time` (s).
    fn try_together(
        &mut self,
        steps: &mut SecondOrderSteps,
        actuator: &mut dyn JointActuator,
        time: f64,
        h: f64,
        law: SubStepContacts,
    ) -> Result<(), Failure> {
        self.stepper.interface_motion(&mut steps.joint.start);
        let InterfaceTrajectory { start, middle_force, force, rates, .. } = &mut steps.joint;
        actuator.outputs_and_rates(time, start, middle_force, rates)?;
        for (force, rate) in middle_force.iter_mut().zip(&rates.rate) {
            *force += 0.5 * h * rate;
        }
        force.copy_from_slice(middle_force);
        let mut residual = f64::INFINITY;
        for _ in 0..MOST_ITERATIONS {
            self.advance_piece(steps, h, law)?;
            residual = self.meet(&mut steps.joint, h);
            if residual <= AGREEMENT {
                return Ok(());
            }
            self.restore(steps);
        }
        Err(Cause::NotConverged { residual, iterations: MOST_ITERATIONS }.into())
    }

    /// Gives the force that belongs to the motion just found; returns by how much the last one was different, relative
    /// to the largest so far.
    fn meet(&mut self, joint: &mut InterfaceTrajectory, h: f64) -> f64 {
        let InterfaceTrajectory { start, end, mean, middle_force, force, largest, rates, .. } = joint;
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

    /// Takes a piece of `h` (s) of the step from where the system stands.
    fn advance_piece(&mut self, steps: &mut SecondOrderSteps, h: f64, law: SubStepContacts) -> Result<(), Failure> {
        let SecondOrderSteps {
            set, resting, acceleration, start, row_velocity, length, middle: [q_m, v_m], joint, ..
        } = steps;
        for (q_m, (q, v)) in q_m.iter_mut().zip(start.q.iter().zip(&start.v)) {
            *q_m = q + 0.5 * h * v;
        }
        v_m.copy_from_slice(&start.v);
        for (v_m, acceleration) in v_m.iter_mut().zip(&*acceleration) {
            *v_m += 0.5 * h * acceleration;
        }
        let before = self.stepper.kinetic_energy();
        self.linearise_at(q_m, v_m);
        self.find_stiff_forces(q_m, v_m);
        let stabilisation = self.stepper.law.stabilisation;
        // However short a piece is, a stabilisation_rate decays as slowly as in the whole step: a piece of a nanosecond
        // would make metres per second of a nanometre.
        let stabilisation_rate = stabilisation / *length;
        set.clear();
        for (contact, &gap) in start.gap.iter().enumerate() {
            match law {
                SubStepContacts::Resting if resting[contact] => set.push(contact, stabilisation_rate * gap),
                SubStepContacts::Resting => {}
                SubStepContacts::Gap => set.push(contact, gap_velocity(gap, h, h, stabilisation)),
            }
        }
        let eq3 = &mut self.stepper.eq3;
        for convective in eq3.bilateral.convective.iter_mut().chain(&mut eq3.unilateral.convective) {
            *convective *= 0.5;
        }
        eq3.bilateral.position.copy_from_slice(&start.joint_error);
        let turned = self.stepper.kinetic_energy() - before;
        let moment = joint.moment_known.then_some(&joint.moment[..]);
        self.stepper
            .advance_from_middle(MidpointStep { h, stabilisation_rate, v_m, force: &joint.force, moment }, set)?;
        let rows = &self.stepper.eq3.unilateral;
        for (contact, w) in row_velocity.iter_mut().enumerate() {
            *w = rows.velocity(contact, &self.stepper.v) + h * rows.convective[contact];
        }
        let before = self.stepper.kinetic_energy();
        self.linearise();
        self.stepper.energy.ledger.inertia += turned + self.stepper.kinetic_energy() - before;
        Ok(())
    }

    /// Learns from a piece of `h` (s) that stands, and lets an actuator take it too.
    pub(super) fn accept_piece(
        &mut self,
        steps: &mut SecondOrderSteps,
        drive: &mut Excitation<'_, '_>,
        h: f64,
    ) -> Result<(), Failure> {
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
            let moment_known = steps.joint.moment_known;
            let w_displacement =
                if moment_known { rows.velocity(contact, &self.stepper.v_displacement) } else { w_after };
            steps.gap_error[contact] = (gap_after - gap - 0.5 * h * (w + w_displacement)).abs() / h.powi(3);
            steps.velocity_error[contact] = (w_after - steps.row_velocity[contact]).abs() / h.powi(2);
        }
        steps.passed = None;
        match drive {
            Excitation::Force(_) => {}
            Excitation::Prescribed { done, .. } => *done += h,
            Excitation::Together { actuator, time, sent } => {
                sent(h, &steps.joint.force, &steps.joint.mean);
                actuator.step(*time, &steps.joint.mean, h)?;
                *time += h;
            }
        }
        Ok(())
    }

    pub(super) fn note_acceleration(&self, steps: &mut SecondOrderSteps, h: f64) {
        let change = self.stepper.v.iter().zip(&steps.start.v);
        for (acceleration, (after, before)) in steps.acceleration.iter_mut().zip(change) {
            *acceleration = (after - before) / h;
        }
    }
}
