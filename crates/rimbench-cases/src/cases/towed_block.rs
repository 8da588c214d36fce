//! `towed-block`: a block on a rough floor, towed by a spring whose end moves on at constant speed: it sticks and slips in turn.
//!
//! ```text
//!      ┌─────┐
//!      │  m  ├──k──────▷ V t          friction μ_s while it sticks, μ_k while it slides
//!      └─────┘
//!   ══════════════════════ floor
//! ```
//! Two velocities, one contact, which never opens. The spring is drawn out until it overcomes the friction at rest; then the block overtakes the
//! mean and sticks anew, for good. With `ω² = k/m`, `Δ = (μ_s − μ_k) m g/k`:
//!
//! ```text
//! slip   e(τ) = μ_k m g/k + Δ cos ωτ + (V/ω) sin ωτ        spring extended by e; ẋ = V − ė
//!        from e = μ_s m g/k, for (π + 2 atan(V/(ω Δ)))/ω, to e = (2 μ_k − μ_s) m g/k
//! stick  ė = V, for 2 Δ/V                                  F = μ_k m g ± k √(Δ² + V²/ω²) at most and least
//! ```
//! **Direct feedthrough** of the actuator, through its spring. **Reference**: that closed form.
//!
//! **Source**: textbook (Den Hartog; Popp and Stelter); numbers *ours*.

use super::carriage;
use super::case::{Case, CaseDefaults, CoupledSystem};
use super::contact_parameters;
use super::parameters::{Parameter, Parameters, Range, number as p};
use super::reference_method::{ExactSolution, ReferenceMethod};
use crate::models::{BaseMotion, SlidingBlock, SpringActuator, SpringActuatorParameters};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;
use std::f64::consts::PI;
use std::sync::Arc;

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: carriage::trace_columns(&[
            "effective_mass_kg",
            "gap_floor_m",
            "contact_force_floor_n",
            "friction_force_floor_n",
            "contact_state_floor",
            "closed_contacts",
        ]),
        interface_columns: vec![carriage::interface()],
        constant_mechanics: true,
        reference: Arc::new(|parameters| exact(parameters).map(ReferenceMethod::Exact)),
        ..Case::new(
            "towed-block",
            "Block towed over a rough floor by a spring: sticks and slips in turn (friction at rest above that in motion; closed form)",
            CaseDefaults {
                duration_s: 4.0,
                macro_step_s: 5e-3,
                micro_step_s: 5e-5,
                reference_step_s: 1e-4,
                reference_sampling_s: 2e-4,
            },
            build,
        )
    }
}

const OURS: &str = "ours";

fn parameters() -> Vec<Parameter> {
    use Range::Positive;
    let own = [
        p("block_mass_kg", "kg", 1.0, Positive, "mass m of the block", OURS),
        p("spring_stiffness_n_m", "N/m", 100.0, Positive, "stiffness k of the spring, relaxed at the start", OURS),
        p("towing_speed_m_s", "m/s", 0.1, Positive, "speed V of the spring's other end", OURS),
        p("gravity_m_s2", "m/s²", 9.81, Positive, "gravity", "standard"),
        contact_parameters::stabilisation(),
    ];
    own.into_iter().chain(contact_parameters::stick_slip(0.5, 0.4)).collect()
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let spring = SpringActuator::new(SpringActuatorParameters {
        stiffness: get("spring_stiffness_n_m"),
        damping: 0.0,
        carriage_mass: 0.0,
        base_stiffness: 0.0,
        base_damping: 0.0,
        base: BaseMotion {
            position: 0.0,
            velocity: get("towing_speed_m_s"),
            amplitude: 0.0,
            angular_frequency: 0.0,
            phase: 0.0,
        },
        start: [0.0; 2],
    })?;
    let block = SlidingBlock { mass: get("block_mass_kg"), gravity: get("gravity_m_s2") };
    contact_parameters::coupled(block, spring, parameters, solver)
}

/// The stick–slip cycle of a block that starts at rest with its spring relaxed.
#[derive(Debug, Clone, Copy)]
struct Cycle {
    mass: f64,
    stiffness: f64,
    speed: f64,
    weight: f64,
    /// Friction at rest and in motion, N.
    friction: [f64; 2],
    omega: f64,
    /// Δ, m.
    drop: f64,
    /// When it first lets go, s.
    first_release: f64,
    /// Lengths of a slip and of a stick, s.
    slip: f64,
    stick: f64,
}

impl Cycle {
    fn of(parameters: &Parameters) -> Self {
        let get = |name: &str| parameters.number(name);
        let (mass, stiffness, speed) = (get("block_mass_kg"), get("spring_stiffness_n_m"), get("towing_speed_m_s"));
        let weight = mass * get("gravity_m_s2");
        let friction = contact_parameters::coefficients(parameters).map(|coefficient| coefficient * weight);
        let omega = (stiffness / mass).sqrt();
        let drop = (friction[0] - friction[1]) / stiffness;
        Cycle {
            mass,
            stiffness,
            speed,
            weight,
            friction,
            omega,
            drop,
            first_release: friction[0] / (stiffness * speed),
            slip: (PI + 2.0 * libm::atan2(speed, omega * drop)) / omega,
            stick: 2.0 * drop / speed,
        }
    }

    /// Extension of the spring, m, velocity of the block, m/s, and whether it sticks.
    fn at(&self, t: f64) -> (f64, f64, bool) {
        let since = t - self.first_release;
        if since <= 0.0 {
            return (self.speed * t, 0.0, true);
        }
        let within = since - (since / (self.slip + self.stick)).floor() * (self.slip + self.stick);
        let [at_rest, in_motion] = self.friction.map(|force| force / self.stiffness);
        if within >= self.slip {
            return (in_motion - self.drop + self.speed * (within - self.slip), 0.0, true);
        }
        if within == 0.0 {
            return (at_rest, 0.0, true);
        }
        let (sin, cos) = libm::sincos(self.omega * within);
        let extension = in_motion + self.drop * cos + self.speed / self.omega * sin;
        (extension, self.speed * (1.0 - cos) + self.omega * self.drop * sin, false)
    }
}

/// The closed form, as rows of the trace.
fn exact(parameters: &Parameters) -> Result<ExactSolution> {
    let cycle = Cycle::of(parameters);
    Ok(Box::new(move |t, row| {
        let (extension, velocity, sticks) = cycle.at(t);
        let force = cycle.stiffness * extension;
        let (effective_mass, friction, state) =
            if sticks { (f64::INFINITY, -force, 1.0) } else { (cycle.mass, -cycle.friction[1], 2.0) };
        row.copy_from_slice(&[
            t,
            cycle.speed * t - extension,
            velocity,
            force,
            force,
            effective_mass,
            0.0,
            cycle.weight,
            friction,
            state,
            1.0,
        ]);
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cycle_has_the_period_and_the_forces_of_theory() {
        let cycle = Cycle::of(&entry().default_parameters());
        let period = cycle.slip + cycle.stick;
        approx::assert_relative_eq!(period, 0.669357, epsilon = 5e-7);
        let forces =
            (0..=100_000).map(|k| cycle.stiffness * cycle.at(cycle.first_release + period * f64::from(k) / 1e5).0);
        let [least, most] = forces.fold([f64::INFINITY, 0.0], |[low, high], force| [force.min(low), force.max(high)]);
        approx::assert_relative_eq!(most, 5.32484, epsilon = 5e-6);
        approx::assert_relative_eq!(least, 2.52316, epsilon = 5e-6);
    }

    /// Force, velocity and their rates fit where a slip begins and ends, and within it the block obeys Newton.
    #[test]
    fn the_closed_form_is_a_motion() {
        for set in [&[][..], &[("static_friction", "0")], &[("static_friction", "0.9"), ("towing_speed_m_s", "0.37")]] {
            let mut parameters = entry().default_parameters();
            set.iter().for_each(|(key, value)| parameters.set(key, value).unwrap());
            let cycle = Cycle::of(&parameters);
            let step = 1e-6;
            for k in 0..2000 {
                let t = f64::from(k) * 1e-3;
                let [(e, v, _), (later, v_later, sticks)] = [t, t + step].map(|t| cycle.at(t));
                // Rates are below 1 m/s and 10 m/s², and change by at most twice that.
                assert!((later - e - step * (cycle.speed - v)).abs() <= 20.0 * step * step, "{t}");
                let rate = (cycle.stiffness * e - cycle.friction[1]) / cycle.mass;
                let wanted = if sticks { 0.0 } else { v + step * rate };
                assert!((v_later - wanted).abs() <= 20.0 * step, "{t}: {v_later}, not {wanted}");
                assert!(cycle.stiffness * e <= cycle.friction[0] * (1.0 + 1e-12) || !sticks, "{t}");
            }
        }
    }
}
