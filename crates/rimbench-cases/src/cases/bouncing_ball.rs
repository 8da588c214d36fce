//! `bouncing-ball`: a ball on the floor, with a carriage on springs above it. Infinitely many impacts in finite time.
//!
//! ```text
//!        base ▒▒▒
//!              ≷ k_b
//!            [m_a] carriage
//!              ≷ k, c             F > 0 pushes the ball up
//!             ( m )  x, start x₀
//!   ════════════════════ floor x = 0, restitution e
//! ```
//! One velocity, one contact. Each impact leaves the fraction e of the velocity; the times between impacts shrink by the same
//! factor, so that they add up: without the actuator (`spring_stiffness_n_m = 0`) the first impact is at √(2x₀/g) =
//! 0.451523641 s and the ball rests after √(2x₀/g) (1 + e)/(1 − e) = 8.578949 s. A time-stepping scheme takes part in the
//! accumulation without harm; an event-driven one cannot pass it, which is why the exact solution cuts rebounds off at 1 µm/s.
//!
//! **Direct feedthrough** of the actuator, through its spring. **Reference**: exact, from impact to impact by matrix
//! exponentials; it reproduces the two published times, which is what validates it for the coupled ball too.
//!
//! **Source**: a textbook example (Acary and Brogliato 2008); the actuator is *ours*.

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
            "gap_floor_m",
            "closed_contacts",
        ]),
        interface_columns: vec![carriage::interface()],
        reference: Arc::new(|parameters| exact(parameters).map(ReferenceMethod::Exact)),
        constant_mechanics: true,
        ..Case::new(
            "bouncing-ball",
            "Ball that bounces under a carriage on springs (exact between impacts; published times without the springs)",
            CaseDefaults {
                duration_s: 3.0,
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
        p("ball_mass_kg", "kg", 1.0, Range::Positive, "mass of the ball", OURS),
        p("start_height_m", "m", 1.0, Range::Finite, "height of the ball at the start", "textbook"),
        p("start_velocity_m_s", "m/s", 0.0, Range::Finite, "velocity of the ball at the start, upwards", "textbook"),
        p("gravity_m_s2", "m/s²", 9.81, Range::NotNegative, "gravity", "standard"),
        carriage::stiffness(2.0),
        carriage::damping(0.0),
        carriage::mass(0.1),
        carriage::base_stiffness(5.0),
        carriage::base_damping(0.0),
        carriage::base_position(1.0),
        carriage::base_amplitude(0.0),
        carriage::base_frequency(0.0),
        carriage::base_phase(0.0),
        carriage::start_position(1.0),
        carriage::start_velocity(0.0),
        contact_parameters::restitution(0.9, "textbook"),
        contact_parameters::stabilisation(),
    ]
}

fn ball(parameters: &Parameters) -> DrivenMass {
    let get = |name: &str| parameters.number(name);
    DrivenMass {
        mass: get("ball_mass_kg"),
        stiffness: 0.0,
        damping: 0.0,
        load: -get("ball_mass_kg") * get("gravity_m_s2"),
        start: [get("start_height_m"), get("start_velocity_m_s")],
        stops: vec![Stop { side: 1.0, position: 0.0 }],
        restitution: get("restitution"),
        actuator: carriage::of(parameters),
    }
}

fn exact(parameters: &Parameters) -> Result<ExactSolution> {
    let ball = ball(parameters);
    driven_mass::check_start(&ball, "start_height_m")?;
    Ok(driven_mass::solution(ball))
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let ball = ball(parameters);
    driven_mass::check_start(&ball, "start_height_m")?;
    let names = StopNames { gaps: names(&["gap_floor_m"]), forces: names(&["contact_force_floor_n"]) };
    driven_mass::system(ball, &names, parameters, solver)
}

#[cfg(test)]
mod tests {
    use super::super::event_driven::EventDriven;
    use super::*;

    #[test]
    fn without_the_actuator_the_exact_solution_gives_the_published_times() {
        let mut parameters = entry().default_parameters();
        parameters.set("spring_stiffness_n_m", "0").unwrap();
        let mut solution = EventDriven::new(ball(&parameters));
        let impacts = solution.impacts(9.0).to_vec();
        approx::assert_relative_eq!(impacts[0].time, 0.451523641, epsilon = 5e-10);
        // Rebounds below 1 µm/s are cut off: what is left of the sum is 2 · 1e-6/g/(1 − e) = 2e-6 s; and those 146 or so
        // that are not are each rounded to 1e-14 m, at 1 µm/s 1e-8 s.
        approx::assert_relative_eq!(impacts[impacts.len() - 1].time, 8.578949, epsilon = 4e-6);
        for (n, impact) in impacts.iter().enumerate().take(100) {
            approx::assert_relative_eq!(impact.velocity, -4.429447 * 0.9_f64.powi(n as i32), max_relative = 1e-6);
        }
        let (rest, stuck) = solution.at(9.0);
        assert!(stuck && rest[0] == 0.0 && rest[1] == 0.0);
    }

    #[test]
    fn between_impacts_the_coupled_solution_keeps_its_energy_and_loses_the_right_part_in_each() {
        // No damping: energy of ball, carriage and springs is constant but for ½ m (1 − e²) V² per impact.
        let parameters = entry().default_parameters();
        let energy = |solution: &mut EventDriven, t: f64| {
            let (z, _) = solution.at(t);
            let kinetic = 0.5 * z[1] * z[1] + 0.05 * z[3] * z[3];
            kinetic + 9.81 * z[0] + (z[2] - z[0]).powi(2) + 2.5 * (z[2] - 1.0).powi(2)
        };
        let mut solution = EventDriven::new(ball(&parameters));
        let start = energy(&mut solution, 0.0);
        for t in [0.2, 1.0, 2.0, 3.0, 5.0] {
            let lost: f64 = solution.impacts(t).iter().map(|impact| 0.5 * 0.19 * impact.velocity.powi(2)).sum();
            approx::assert_relative_eq!(energy(&mut solution, t) + lost, start, epsilon = 1e-9);
        }
    }
}
