//! `hydraulic-line`: the oil of the actuator itself becomes the line whose travel time is the macro step.
//!
//! Where `transmission-line` adds a line that the system does not have, this one replaces a volume that it has. Each
//! chamber becomes a lossless line from the valve (v) to the piston (p), with the delay T = H:
//!
//! ```text
//! p_p(t) = c_p(t) + Z q_p(t)      c_p(t) = p_v(t − H) + Z q_v(t − H)      q_p: ±A w, oil that the piston displaces
//! p_v(t) = c_v(t) + Z q_v(t)      c_v(t) = p_p(t − H) + Z q_p(t − H)      q_v(p_v): through the valve, solved for
//! Z = β H / (A l) / (1 − α)       frozen at t_k                           c ← α c(t − H) + (1 − α) (…)
//! λ(t) = A (c_2p − c_1p) − (A² (Z_1 + Z_2) + c) w(t)  =  C(t) − Z_x w(t)
//! ```
//! C is known over the whole macro step when it begins, so both sides may step at once and nothing is extrapolated; the
//! three sequences give one result. The actuator keeps the waves
//! ([`TransmissionLines`](crate::cosim::TransmissionLines)); this scheme takes C and Z_x to the mechanics, which makes
//! the force from them anew in each of its own steps. What the actuator is told of the motion within a macro step, the
//! velocity held, is only booked: the oil feels the motion that really was, one travel time later.
//!
//! **Needs** a force–displacement coupling and an actuator whose volumes of oil can be replaced. **Gain** α, the share
//! of the wave before that each wave keeps: damps standing waves, and stiffens Z; 0 by default, as in Hopsan.
//! **Order** 2. **Known weakness**: seen from the piston with a shut valve the line is
//! `Z coth(sH) = (K/s)(1 + s²H²/3 …)`, a spring K = βA/l with an added mass `K H²/3`; the mechanics uses the velocity
//! of the beginning of its own step h, which is explicit: `h Z_x H_ii` must stay below 2. **Source**: transmission line
//! modelling after Krus et al. 1990, as documented by Hopsan and OMTLMSimulator. Ours: motion between communication
//! points as a straight line with the right mean; no guard that enlarges the volumes (Hopsan's keeps K H² below a tenth
//! of the mass), so that the added mass is what it is.

use super::construction::sent_lines;
use super::entry::{Gain, SchemeEntry};
use super::requirement::Requirement;
use crate::cosim::{CouplingScheme, LineForces, MicroStep, Sample, Side};
use crate::error::Failure;

pub(super) fn entry() -> SchemeEntry {
    SchemeEntry {
        order: 2,
        needs: vec![Requirement::ForceDisplacement, Requirement::TransmissionLines, Requirement::HeldReturn],
        gain: Some(Gain {
            about: "α, the share of the wave before that each wave keeps".into(),
            default: 0.0,
            range: [0.0, 0.9],
        }),
        ..SchemeEntry::new(
            "hydraulic-line",
            "The actuator's oil as lines whose travel time is the macro step; waves instead of extrapolation",
            |construction| {
                let rows = construction.interface();
                Ok(Box::new(HydraulicLine { forces: LineForces::new(rows, 0, 0.0), motion: vec![0.0; 2 * rows] }))
            },
        )
    }
}

#[derive(Clone)]
struct HydraulicLine {
    /// Over the present macro step.
    forces: LineForces,
    /// Of the mechanics at `t_k`: positions, then velocities.
    motion: Vec<f64>,
}

impl CouplingScheme for HydraulicLine {
    fn receive(&mut self, from: Side, sample: &Sample<'_>) -> Result<(), Failure> {
        match from {
            // What the mechanics sends ahead, where it goes first, is news one travel time later.
            Side::Mechanics if sample.time > sample.step.start => {}
            Side::Mechanics => self.motion.copy_from_slice(sample.y),
            Side::Actuator => self.forces.copy_from(sent_lines(sample.line_forces)?),
        }
        Ok(())
    }

    #[inline]
    fn input(&mut self, to: Side, at: MicroStep, own: &[f64], u: &mut [f64]) -> Result<(), Failure> {
        let rows = self.motion.len() / 2;
        if to == Side::Actuator {
            u.copy_from_slice(&self.motion);
            for (position, velocity) in u[..rows].iter_mut().zip(&self.motion[rows..]) {
                *position += (at.since_exchange + 0.5 * at.length) * velocity;
            }
            return Ok(());
        }
        self.forces.mean_over(at.index, at.count, u);
        for ((force, impedance), velocity) in u.iter_mut().zip(self.forces.impedance()).zip(&own[rows..]) {
            *force -= impedance * velocity;
        }
        Ok(())
    }

    fn try_clone(&self) -> Option<Box<dyn CouplingScheme>> {
        Some(Box::new(self.clone()))
    }
}
