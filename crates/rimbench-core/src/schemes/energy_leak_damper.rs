//! `energy-leak-damper`: count the energy that the interface creates, and dissipate it in a virtual damper.
//!
//! Between the sides stands a hold. What the mechanics receives as work and what the actuator sends differ; the difference
//! accumulates in a pool. As long as the pool is positive, a damper on the interface takes it out of the mechanics, never more
//! per macro step than it holds, and never with more force than a share of the coupling force.
//!
//! ```text
//! received  Σ u_λ · ½ (w⁻ + w⁺) δ_m        sent  Σ λ_j · ½ (w_j⁻ + w_j⁺) δ        pool E ← E + received − sent
//! damper    f = −μ w(t_k),   μ = E⁺ / (H w(t_k)²),   |f| ≤ γ |λ(t_k)|           u_λ = λ(t_k) + f
//! ```
//! The work of the damper is part of what is received, so a joule taken out leaves E by itself. −E is the interface
//! residual of the energy audit, to round-off where the interface row `A_i` is constant; where it turns, the audit has the row of
//! the start of a step and the pool, which sees velocities only, that of both ends. [`SchemeReport::dissipated_j`] says how much the damper took: the ledger.
//! **Needs** a force–displacement coupling and force return `held`, else its force would not arrive. **Order** 1 in H, that of
//! the hold, up to a logarithm (error ∝ H ln(1/H)): the force that takes a given energy out grows as the interface slows down.
//! **Known weakness**: acts after the harm is done and only on moving
//! interfaces; a negative pool (energy lost) is not given back, only counted against later gains; the bound, which keeps the
//! explicit damper from adding energy itself, decides how much it can do.
//! **Source**: González et al. 2019 (energy-leak monitoring and correction), Rodríguez et al. 2022; deviations are in
//! `docs/schemes/energy-leak-damper.md`.

use super::entry::{Gain, SchemeEntry};
use super::requirement::Requirement;
use crate::cosim::{CouplingScheme, MicroStep, Sample, SchemeReport, Side};
use crate::error::Failure;

/// Default of γ (ours).
const BOUND: f64 = 0.1;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        needs: vec![Requirement::ForceDisplacement, Requirement::HeldReturn],
        gain: Some(Gain {
            about: "γ, most damper force per coupling force".into(), default: BOUND, range: [0.0, 1.0]
        }),
        ..SchemeEntry::new(
            "energy-leak-damper",
            "Hold; energy created at the interface is counted and dissipated in a bounded virtual damper",
            |construction| Ok(Box::new(EnergyLeakDamper::new(construction.interface(), construction.gain))),
        )
    }
}

/// One row of the interface.
#[derive(Debug, Clone, Copy, Default)]
struct Row {
    /// Force of the actuator, and that of the damper.
    force: f64,
    damping: f64,
    /// Velocity of the mechanics at the start of its step, whose work is still to be counted.
    velocity_before: f64,
}

#[derive(Clone)]
struct EnergyLeakDamper {
    /// γ.
    bound: f64,
    /// Position and velocity of the last sample.
    motion: Vec<f64>,
    rows: Vec<Row>,
    /// Length of the mechanics' step whose work is still to be counted, s; 0 if there is none.
    open: f64,
    sent: f64,
    received: f64,
    dissipated: f64,
}

impl EnergyLeakDamper {
    fn new(rows: usize, bound: f64) -> Self {
        EnergyLeakDamper {
            bound,
            motion: vec![0.0; 2 * rows],
            rows: vec![Row::default(); rows],
            open: 0.0,
            sent: 0.0,
            received: 0.0,
            dissipated: 0.0,
        }
    }

    /// E, J: what the interface has created (above 0) or lost.
    fn energy(&self) -> f64 {
        self.received - self.sent
    }

    /// Sets the damper for the macro step of length `h`.
    fn damp(&mut self, h: f64) {
        let energy = self.energy().max(0.0);
        let velocity = &self.motion[self.rows.len()..];
        let squares: f64 = velocity.iter().map(|velocity| velocity * velocity).sum();
        for (row, velocity) in self.rows.iter_mut().zip(velocity) {
            let wanted = -energy * velocity / (h * squares);
            let most = self.bound * row.force.abs();
            // Over an interface that rests, or all but rests, the quotient is no number.
            row.damping = if wanted.is_finite() { wanted.clamp(-most, most) } else { 0.0 };
        }
    }

    /// Counts the work of the mechanics' last step, now that it is known with which velocity it ended.
    #[inline]
    fn close_step(&mut self, velocities: &[f64]) {
        if self.open > 0.0 {
            for (row, velocity) in self.rows.iter().zip(velocities) {
                let way = 0.5 * (row.velocity_before + velocity) * self.open;
                self.received += (row.force + row.damping) * way;
                self.dissipated -= row.damping * way;
            }
        }
        self.open = 0.0;
    }
}

impl CouplingScheme for EnergyLeakDamper {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        match from {
            Side::Mechanics => {
                self.close_step(&sample.y[self.rows.len()..]);
                self.motion.copy_from_slice(sample.y);
            }
            Side::Actuator => {
                if !sample.y.iter().all(|force| force.is_finite()) {
                    return Err(Failure::non_finite("coupling force"));
                }
                for (row, force) in self.rows.iter_mut().zip(sample.y) {
                    row.force = *force;
                }
                self.damp(sample.step.length);
            }
        }
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        let m = self.rows.len();
        if to == Side::Mechanics {
            self.close_step(&own[m..]);
            for ((row, velocity), u) in self.rows.iter_mut().zip(&own[m..]).zip(u) {
                *u = row.force + row.damping;
                row.velocity_before = *velocity;
            }
            self.open = at.length;
            return Ok(());
        }
        for ((force, before), now) in own.iter().zip(&u[m..]).zip(&self.motion[m..]) {
            self.sent += force * 0.5 * (before + now) * at.length;
        }
        u.copy_from_slice(&self.motion);
        Ok(())
    }

    fn report(&mut self) -> SchemeReport {
        SchemeReport { dissipated_j: Some(self.dissipated), ..SchemeReport::default() }
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cosim::{
        Capabilities, CommunicationGrid, ExchangeData, ForceReturn, MacroStep, MechanicsSteps, PerSide, Port, Ports,
        Quantity, RunControl, Sequence, Setup, Subsystem, cosimulate, subsystem_methods,
    };

    /// One exchange and one step of each side, H = 1; returns the force on the mechanics.
    fn macro_step(scheme: &mut EnergyLeakDamper, index: usize, w: f64, force: f64) -> f64 {
        let step = MacroStep { index, start: index as f64, length: 1.0 };
        let y = [0.0, w];
        let sample = Sample::of_outputs(step, &y, 1.0);
        scheme.receive(Side::Mechanics, &sample).unwrap();
        scheme.receive(Side::Actuator, &Sample { y: &[force], ..sample }).unwrap();
        let at = MicroStep::new(step, 0, 1);
        let mut u = [0.0, w];
        scheme.input(Side::Actuator, at, &[force], &mut u).unwrap();
        assert_eq!(u, [0.0, w]);
        let mut u = [force];
        scheme.input(Side::Mechanics, at, &y, &mut u).unwrap();
        u[0]
    }

    #[test]
    fn a_joule_created_is_a_joule_taken_out_worked_by_hand() {
        let mut scheme = EnergyLeakDamper::new(1, 0.5);
        // Held force 4 N, velocity 1 → 1.5 m/s: received 4 · 1.25, sent 4 · 1: one joule from nowhere.
        assert_eq!(macro_step(&mut scheme, 0, 1.0, 4.0), 4.0);
        // 1 J over 1.5 m of way wants 2/3 N, less than half of 4 N.
        approx::assert_relative_eq!(
            macro_step(&mut scheme, 1, 1.5, 4.0),
            4.0 - 1.0 / 1.5,
            epsilon = 4.0 * f64::EPSILON
        );
        // The velocity stays: the damper took 2/3 N · 1.5 m, and the pool is empty up to the rounding of 2/3.
        assert!((macro_step(&mut scheme, 2, 1.5, 4.0) - 4.0).abs() <= 16.0 * f64::EPSILON);
        approx::assert_relative_eq!(scheme.report().dissipated_j.unwrap(), 1.0, epsilon = 4.0 * f64::EPSILON);
    }

    const MASS: f64 = 2.0;
    const STIFFNESS: f64 = 50.0;

    /// A mass, stepped semi-implicitly; or a massless spring to the ground that answers with its force.
    struct Half {
        ports: Ports,
        state: [f64; 2],
        work: f64,
        /// Sum of the magnitudes that were added up in `work`, J.
        turnover: f64,
    }

    impl Subsystem for Half {
        subsystem_methods!(ports capabilities no_counters no_clone);

        fn outputs(&mut self, _u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
            match y {
                [force] => *force = -STIFFNESS * self.state[0],
                _ => y.copy_from_slice(&self.state),
            }
            Ok(())
        }

        fn step(&mut self, _t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
            match *u {
                [force] => {
                    let before = self.state[1];
                    self.state[1] += h * force / MASS;
                    self.state[0] += h * self.state[1];
                    let way = 0.5 * (before + self.state[1]) * h;
                    self.work += force * way;
                    self.turnover += (force * way).abs();
                }
                _ => self.state[0] = u[0] + h * u[1],
            }
            Ok(())
        }
    }

    impl Capabilities for Half {
        fn interface_work(&mut self) -> Option<f64> {
            Some(self.work)
        }
    }

    #[test]
    fn the_pool_is_the_interface_residual_of_the_audit() {
        let motion = vec![Port::new("position_m", Quantity::Position), Port::new("velocity_m_s", Quantity::Velocity)];
        let force = vec![Port::new("force_n", Quantity::Force)];
        let half = |inputs: &Vec<Port>, outputs: &Vec<Port>, state| Half {
            ports: Ports { inputs: inputs.clone(), outputs: outputs.clone(), direct_feedthrough: false },
            state,
            work: 0.0,
            turnover: 0.0,
        };
        let (mut mass, mut spring) = (half(&force, &motion, [0.1, 0.3]), half(&motion, &force, [0.1, 0.0]));
        let mut scheme = EnergyLeakDamper::new(1, 0.3);
        // A phase, several steps of the mechanics and a last step that is shorter: all have to be counted.
        let grid = CommunicationGrid::new(1e-2, 0.4, 3.003).unwrap();
        let mechanics_steps = MechanicsSteps::count(2).unwrap();
        let setup = Setup { mechanics_steps, ..Setup::new(grid, 2e-3, Sequence::Jacobi, ForceReturn::Held) };
        let sides = PerSide { mechanics: &mut mass as &mut dyn Subsystem, actuator: &mut spring };
        let (nothing, nobody) = (ExchangeData::default(), RunControl::default());
        let report = cosimulate(&setup, sides, &mut scheme, nothing, nobody, &mut |_| {});
        let residual = report.audit.interface_residual().unwrap();
        assert!(residual.abs() > 1e-3, "{residual} J: there must be something to count");
        assert!(scheme.report().dissipated_j.unwrap() > 0.0);
        // Both add up the same products, half steps apart: a rounding of the sum for each, some 5 per macro step on each side.
        let terms = 2.0 * 5.0 * report.work.cosim.macro_steps as f64;
        let round_off = terms * f64::EPSILON * 2.0 * mass.turnover;
        assert!((scheme.energy() + residual).abs() <= round_off, "{} J in the pool, {residual} J", scheme.energy());
    }

    #[test]
    fn the_damper_never_pushes_harder_than_its_share_of_the_coupling_force() {
        let mut scheme = EnergyLeakDamper::new(1, 0.5);
        macro_step(&mut scheme, 0, 1.0, 4.0);
        // 4 · (11 − 2)/2 = 18 J in the pool want 18/10 N; the coupling force has dropped to 2 N.
        assert_eq!(macro_step(&mut scheme, 1, 10.0, 2.0), 1.0);
        assert_eq!(macro_step(&mut EnergyLeakDamper::new(1, 0.0), 0, 10.0, 2.0), 2.0);
    }

    #[test]
    fn energy_lost_is_not_given_back() {
        let mut scheme = EnergyLeakDamper::new(1, 0.5);
        macro_step(&mut scheme, 0, 1.0, -4.0);
        assert_eq!(macro_step(&mut scheme, 1, 1.5, -4.0), -4.0);
        // One joule lost in the first macro step; gained in the second, which pays for it: the pool is empty again.
        assert_eq!(macro_step(&mut scheme, 2, 1.0, -4.0), -4.0);
        assert_eq!(scheme.report().dissipated_j, Some(0.0));
    }
}
