//! `impact-oscillator`: a mass that a shaken spring drives against one stop. Grazing, and orbits of period n.
//!
//! ```text
//!   base ▒▒──k──( m )      │ stop x = d, restitution e
//!   A sin(ωt + φ)   x →    │                              F > 0 pushes the mass to the right
//! ```
//! One velocity, one contact. With the carriage fixed to the base (`carriage_mass_kg = 0`, the default) and no damping the mass is
//! a linear oscillator with Ω² = (k + k₀)/m and the steady amplitude X = (k A/m)/(Ω² − ω²). It does not touch for |X| < d and
//! *grazes* at |X| = d. Beyond, orbits with one impact every n periods of the base, T = 2πn/ω, have the closed form
//!
//! ```text
//! X² = [d + (1 + e) V cot(ΩT/2)/(2Ω)]² + [(1 − e) V/(2ω)]²        V: velocity before the impact
//! X sin φ = d + (1 + e) V cot(ΩT/2)/(2Ω),    X ω cos φ = (1 − e) V/2    φ: phase of the base at the impact
//! ```
//! **Direct feedthrough** of the actuator, through its spring. **Reference**: exact, from impact to impact by matrix
//! exponentials; checked against the closed form.
//!
//! **Source**: Shaw and Holmes 1983 (the closed form follows from two conditions at the ends of one period); numbers *ours*.

use super::carriage;
use super::case::{Case, CaseDefaults, CoupledSystem};
use super::contact_parameters;
use super::driven_mass::{self, StopNames};
use super::event_driven::{DrivenMass, Stop};
use super::parameters::{Parameter, Parameters, Range, number as p};
use super::reference_method::{ExactSolution, ReferenceMethod};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::Result;
use rimbench_core::name::names;
use std::sync::Arc;

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: carriage::trace_columns(&[
            "carriage_position_m",
            "carriage_velocity_m_s",
            "effective_mass_kg",
            "gap_stop_m",
            "closed_contacts",
        ]),
        interface_columns: vec![carriage::interface()],
        reference: Arc::new(|parameters| exact(parameters).map(ReferenceMethod::Exact)),
        constant_mechanics: true,
        ..Case::new(
            "impact-oscillator",
            "Mass driven by a shaken spring against a stop (exact between impacts; closed form of period-n orbits)",
            CaseDefaults {
                duration_s: 4.0,
                macro_step_s: 5e-3,
                micro_step_s: 5e-4,
                reference_step_s: 1e-4,
                reference_sampling_s: 2e-4,
            },
            build,
        )
    }
}

const OURS: &str = "ours";

fn parameters() -> Vec<Parameter> {
    vec![
        p("mass_kg", "kg", 1.0, Range::Positive, "mass m", OURS),
        p(
            "stiffness_n_m",
            "N/m",
            0.0,
            Range::NotNegative,
            "stiffness k₀ of a spring to the ground, relaxed at x = 0",
            OURS,
        ),
        p("damping_n_s_m", "N·s/m", 0.0, Range::NotNegative, "damping beside it", OURS),
        p("stop_position_m", "m", 0.05, Range::Finite, "position d of the stop", OURS),
        p("start_position_m", "m", 0.0, Range::Finite, "position of the mass at the start", OURS),
        p("start_velocity_m_s", "m/s", 0.0, Range::Finite, "velocity of the mass at the start", OURS),
        carriage::stiffness(100.0),
        carriage::damping(0.0),
        carriage::mass(0.0),
        carriage::base_stiffness(0.0),
        carriage::base_damping(0.0),
        carriage::base_position(0.0),
        carriage::base_amplitude(0.1),
        carriage::base_frequency(2.4),
        carriage::base_phase(0.0),
        carriage::start_position(0.0),
        carriage::start_velocity(0.0),
        contact_parameters::restitution(0.8, OURS),
        contact_parameters::stabilisation(),
    ]
}

fn mass(parameters: &Parameters) -> Result<DrivenMass> {
    let get = |name: &str| parameters.number(name);
    let mass = DrivenMass {
        mass: get("mass_kg"),
        stiffness: get("stiffness_n_m"),
        damping: get("damping_n_s_m"),
        load: 0.0,
        start: [get("start_position_m"), get("start_velocity_m_s")],
        stops: vec![Stop { side: -1.0, position: get("stop_position_m") }],
        restitution: get("restitution"),
        actuator: carriage::of(parameters),
    };
    driven_mass::check_start(&mass, "start_position_m")?;
    Ok(mass)
}

fn exact(parameters: &Parameters) -> Result<ExactSolution> {
    Ok(driven_mass::solution(mass(parameters)?))
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let names = StopNames { gaps: names(&["gap_stop_m"]), forces: names(&["contact_force_stop_n"]) };
    driven_mass::system(mass(parameters)?, &names, parameters, solver)
}

#[cfg(test)]
mod tests {
    use super::super::event_driven::{DrivenMass, EventDriven};
    use super::*;
    use std::f64::consts::TAU;

    /// The closed form of the module doc: `V` and φ of the orbit with one impact every `n` periods.
    fn orbit(parameters: &Parameters, n: f64) -> (f64, f64) {
        let (get, omega) = (|name: &str| parameters.number(name), TAU * parameters.number("base_frequency_hz"));
        let (e, d) = (get("restitution"), get("stop_position_m"));
        let own = (get("spring_stiffness_n_m") / get("mass_kg")).sqrt();
        let steady = own * own * get("base_amplitude_m") / (own * own - omega * omega);
        let slope = (1.0 + e) / (2.0 * own * libm::tan(own * TAU * n / (2.0 * omega)));
        let side = (1.0 - e) / (2.0 * omega);
        // (slope² + side²) V² + 2 d slope V + d² − X² = 0, the larger root.
        let (a, b, c) = (slope * slope + side * side, 2.0 * d * slope, d * d - steady * steady);
        let v = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
        (v, libm::atan2((d + slope * v) / steady, side * v / steady))
    }

    /// The case at a frequency (Hz), started just after the impact of that orbit.
    fn on_orbit(n: f64, frequency: f64) -> (DrivenMass, f64) {
        let mut parameters = entry().default_parameters();
        parameters.set("base_frequency_hz", &format!("{frequency:?}")).unwrap();
        let (v, phase) = orbit(&parameters, n);
        let values = [
            ("base_phase_rad", phase),
            ("start_position_m", parameters.number("stop_position_m")),
            ("start_velocity_m_s", -parameters.number("restitution") * v),
        ];
        for (key, value) in values {
            parameters.set(key, &format!("{value:?}")).unwrap();
        }
        (mass(&parameters).unwrap(), v)
    }

    #[test]
    fn the_solution_from_impact_to_impact_keeps_the_period_n_orbits_of_the_closed_form() {
        // Frequencies at which the orbit stays on its side of the stop.
        for (n, frequency) in [(1.0, 2.4), (2.0, 5.0), (3.0, 7.6)] {
            let (mass, v) = on_orbit(n, frequency);
            let period = TAU * n / mass.actuator.base.angular_frequency;
            let mut solution = EventDriven::new(mass);
            let impacts = solution.impacts(3.5 * period);
            assert_eq!(impacts.len(), 3);
            // Bisection to round-off of a gap of 0.05 m at 1 m/s or more; the orbits are stable with multipliers of modulus e.
            for (k, impact) in impacts.iter().enumerate() {
                approx::assert_relative_eq!(impact.time, (k + 1) as f64 * period, epsilon = 1e-11);
                approx::assert_relative_eq!(impact.velocity, v, epsilon = 1e-10);
            }
        }
    }

    #[test]
    fn a_steady_oscillation_touches_the_stop_just_beyond_grazing_and_not_just_before() {
        for (excess, touches) in [(-1e-6, false), (1e-6, true)] {
            let mut parameters = entry().default_parameters();
            let (k, omega) = (100.0, TAU * parameters.number("base_frequency_hz"));
            // X = d (1 + excess), in antiphase to the base above resonance.
            let steady = -0.05 * (1.0 + excess);
            let amplitude = steady * (k - omega * omega) / k;
            for (key, value) in [("base_amplitude_m", amplitude), ("start_velocity_m_s", omega * steady)] {
                parameters.set(key, &format!("{value:?}")).unwrap();
            }
            let mut solution = EventDriven::new(mass(&parameters).unwrap());
            assert_eq!(!solution.impacts(2.0).is_empty(), touches, "{excess}");
        }
    }
}
