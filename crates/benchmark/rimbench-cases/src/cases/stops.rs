//! One mass against stops, moved by a carriage on springs: `bouncing-ball`, `impact-oscillator`,
//! `slider-between-stops`. One velocity; the solution is exact from impact to impact. Shown in
//! `docs/cases/mass-against-stops.md`.

use super::event_driven::{DrivenMass, EventDriven, Stop};
use super::prelude::*;
use rimbench_core::interface_model::TOUCHING;
use rimbench_core::name::names;
use std::sync::{Mutex, PoisonError};

parameters! {
    /// A ball on the floor.
    struct Ball from "textbook" {
        ball_mass_kg: f64 = 1.0, Positive, "mass of the ball".from("ours");
        start_height_m: f64 = 1.0, Finite, "height of the ball at the start";
        start_velocity_m_s: f64 = 0.0, Finite, "velocity of the ball at the start, upwards";
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity".from("standard");
        carriage: Carriage with |set| set
            .default("spring_stiffness_n_m", 2.0).default("carriage_mass_kg", 0.1)
            .default("base_stiffness_n_m", 5.0).default("base_position_m", 1.0).default("carriage_position_m", 1.0);
        contacts: Contacts with |set| set
            .only(&["restitution", "stabilisation"]).default("restitution", 0.9).source("restitution", "textbook");
    }
}
parameters! {
    /// A mass before one stop.
    struct Shaken from "ours" {
        mass_kg: f64 = 1.0, Positive, "mass m";
        stiffness_n_m: f64 = 0.0, NotNegative, "stiffness k₀ of a spring to the ground, relaxed at x = 0";
        damping_n_s_m: f64 = 0.0, NotNegative, "damping beside it";
        stop_position_m: f64 = 0.05, Finite, "position d of the stop".gap();
        start_position_m: f64 = 0.0, Finite, "position of the mass at the start";
        start_velocity_m_s: f64 = 0.0, Finite, "velocity of the mass at the start";
        carriage: Carriage with |set| set
            .default("spring_stiffness_n_m", 100.0).default("base_amplitude_m", 0.1)
            .default("base_frequency_hz", 2.4);
        contacts: Contacts with |set| set
            .only(&["restitution", "stabilisation"]).default("restitution", 0.8).source("restitution", "ours");
    }
}
parameters! {
    /// A mass between two stops.
    struct Slider from "ours" {
        mass_kg: f64 = 2.0, Positive, "mass m of the slider";
        damping_n_s_m: f64 = 0.0, NotNegative, "damping between slider and ground";
        clearance_m: f64 = 0.1, NotNegative, "distance d of either stop from x = 0".gap();
        start_position_m: f64 = 0.0, Finite, "position of the slider at the start";
        start_velocity_m_s: f64 = 0.0, Finite, "velocity of the slider at the start";
        carriage: Carriage with |set| set
            .default("spring_stiffness_n_m", 500.0).default("spring_damping_n_s_m", 5.0)
            .default("carriage_mass_kg", 0.5).default("base_stiffness_n_m", 1000.0)
            .default("base_damping_n_s_m", 20.0).default("base_amplitude_m", 0.25)
            .default("base_frequency_hz", 1.0);
        contacts: Contacts with |set| set
            .only(&["restitution", "stabilisation"]).default("restitution", 0.5).source("restitution", "ours");
    }
}

/// A case of one mass between stops: `start` is the parameter that says where it starts, `stops` are the ends of the
/// names of their columns.
fn entry<P: ParameterSet>(
    name: &'static str,
    about: &'static str,
    duration: f64,
    (start, stops): (&'static str, &'static [&'static str]),
    mass: fn(&P) -> DrivenMass,
    drawing: fn(&P) -> Drawing,
) -> Case {
    let checked = move |p: &P| {
        let mass = mass(p);
        check_start(&mass, start).map(|()| mass)
    };
    let more = "carriage_position_m carriage_velocity_m_s effective_mass_kg gap_*_m closed_contacts";
    Case {
        trace_columns: trace_of(&carriage::interface(), "", stops, more),
        interface_columns: carriage::interface(),
        reference: Arc::new(move |parameters| Ok(ReferenceMethod::Exact(solution(checked(&P::read(parameters))?)))),
        constant_mechanics: true,
        drawing: drawn(move |p: &P| Some(drawing(p))),
        ..Case::new(name, about, times(duration, 5e-3, 5e-4, [1e-4, 2e-4]), move |p: &P, assembly| {
            let mass = checked(p)?;
            let model = model(&mass, names(stops))?;
            assembly.couple(model, SpringActuator::new(mass.actuator)?, &Contacts::read(assembly.parameters))
        })
    }
}

fn model(mass: &DrivenMass, contact_names: Vec<Name>) -> Result<LineMasses> {
    let contact = |stop: &Stop| LineContact {
        below: (stop.side < 0.0).then_some(0),
        above: (stop.side > 0.0).then_some(0),
        distance: stop.side * stop.position,
    };
    LineMasses::new(LineDescription {
        masses: vec![mass.body],
        contacts: mass.stops.iter().map(contact).collect(),
        contact_names,
        ..LineDescription::default()
    })
}

/// The solution: rows of time, interface position and velocity, force of the actuator, force received, carriage
/// position and velocity, effective mass, gaps, number of closed contacts.
///
/// What the mechanics received is the force itself, and the effective mass is infinite while a stop holds the mass.
fn solution(mass: DrivenMass) -> ExactSolution {
    let solved = Mutex::new(EventDriven::new(mass.clone()));
    let stops = mass.stops.len();
    Box::new(move |t, stop, row| {
        let (z, stuck) = solved.lock().unwrap_or_else(PoisonError::into_inner).at(t, stop);
        let force = mass.force(&z);
        let effective_mass = if stuck { f64::INFINITY } else { mass.body.mass };
        row[..8].copy_from_slice(&[t, z[0], z[1], force, force, z[2], z[3], effective_mass]);
        let (gaps, closed) = row[8..].split_at_mut(stops);
        for (gap, stop) in gaps.iter_mut().zip(&mass.stops) {
            *gap = stop.gap(z[0]);
        }
        closed[0] = gaps.iter().filter(|gap| **gap <= TOUCHING).count() as f64;
    })
}

/// Refuses a start outside the stops, by the name of its parameter.
fn check_start(mass: &DrivenMass, key: &str) -> Result<()> {
    for stop in &mass.stops {
        let gap = stop.gap(mass.body.start[0]);
        if gap < 0.0 {
            let bound = if stop.side > 0.0 { "at least" } else { "at most" };
            return Err(Error::invalid(
                key,
                mass.body.start[0],
                format!("{bound} {} m, where the stop is; it would start {} m inside", stop.position, -gap),
            ));
        }
    }
    Ok(())
}

/// A ball on the floor under the carriage: impacts that add up (Acary and Brogliato 2008; the actuator is ours).
pub(super) fn bouncing_ball() -> Case {
    entry(
        "bouncing-ball",
        "Ball that bounces under a carriage on springs (exact between impacts; published times without the springs)",
        3.0,
        ("start_height_m", &["floor"]),
        ball,
        |p| {
            let (frames, mut shapes) =
                carriage::springs([0.0, 0.06], [0.0, 1.0], 0.3, Some(p.carriage.base_position_m));
            shapes.extend([ground(&[[-5.0, 0.0], [5.0, 0.0]]), disc(([0.0, 0.0], Some("body")), 0.06, Fill::Scheme)]);
            let about = "A ball on two springs falls and bounces on the floor.";
            Drawing::of(["Bouncing ball", about], [[-1.0, 1.0], [-0.15, 1.75]], frames, shapes)
        },
    )
}

fn ball(p: &Ball) -> DrivenMass {
    DrivenMass {
        body: LineMass {
            mass: p.ball_mass_kg,
            load: -p.ball_mass_kg * p.gravity_m_s2,
            start: [p.start_height_m, p.start_velocity_m_s],
            ..LineMass::default()
        },
        stops: vec![Stop { side: 1.0, position: 0.0 }],
        restitution: p.contacts.restitution,
        actuator: p.carriage,
    }
}

/// A shaken spring drives the mass against one stop: grazing, and orbits of period n (Shaw and Holmes 1983; numbers
/// ours).
///
/// ```text
/// X² = [d + (1 + e) V cot(ΩT/2)/(2Ω)]² + [(1 − e) V/(2ω)]²        V: velocity before the impact, T = 2πn/ω
/// X sin φ = d + (1 + e) V cot(ΩT/2)/(2Ω),    X ω cos φ = (1 − e) V/2    φ: phase of the base at the impact
/// ```
pub(super) fn impact_oscillator() -> Case {
    entry(
        "impact-oscillator",
        "Mass driven by a shaken spring against a stop (exact between impacts; closed form of period-n orbits)",
        4.0,
        ("start_position_m", &["stop"]),
        shaken,
        |p| {
            let (frames, mut shapes) = carriage::springs([0.0, 0.0], [-1.0, 0.0], 0.4, None);
            // The edge of the mass comes to the stop.
            let edge = p.stop_position_m + 0.06;
            shapes.extend([
                wall([edge, -0.16], [edge + 0.04, 0.16]),
                Shape::Polygon(rectangle("body", [0.0, 0.0], [0.12, 0.12]), Fill::Scheme),
            ]);
            let about = "A shaken spring drives a mass against a stop.";
            let drawing = Drawing::of(["Mass against a stop", about], [[-0.6, 0.3], [-0.2, 0.2]], frames, shapes);
            drawing.with(LIMITED_BY_ITS_STEP)
        },
    )
}

fn shaken(p: &Shaken) -> DrivenMass {
    DrivenMass {
        body: LineMass {
            mass: p.mass_kg,
            stiffness: p.stiffness_n_m,
            damping: p.damping_n_s_m,
            start: [p.start_position_m, p.start_velocity_m_s],
            ..LineMass::default()
        },
        stops: vec![Stop { side: -1.0, position: p.stop_position_m }],
        restitution: p.contacts.restitution,
        actuator: p.carriage,
    }
}

/// Pushed to and fro between two stops: caught, bounced, pressed against a stop and let go; numbers ours.
pub(super) fn slider() -> Case {
    entry(
        "slider-between-stops",
        "Slider between two stops, driven by a carriage on springs (exact between impacts)",
        3.0,
        ("start_position_m", &["lower_stop", "upper_stop"]),
        |p: &Slider| DrivenMass {
            body: LineMass {
                mass: p.mass_kg,
                damping: p.damping_n_s_m,
                start: [p.start_position_m, p.start_velocity_m_s],
                ..LineMass::default()
            },
            stops: [1.0, -1.0].map(|side| Stop { side, position: -side * p.clearance_m }).to_vec(),
            restitution: p.contacts.restitution,
            actuator: p.carriage,
        },
        |p| {
            let (frames, mut shapes) =
                carriage::springs([0.0, 0.0], [-1.0, 0.0], 0.35, Some(p.carriage.base_position_m));
            let edge = p.clearance_m + 0.06;
            // The springs go past the left stop.
            shapes.extend([
                wall([-edge - 0.04, 0.07], [-edge, 0.16]),
                wall([-edge - 0.04, -0.16], [-edge, -0.07]),
                wall([edge, -0.16], [edge + 0.04, 0.16]),
                Shape::Polygon(rectangle("body", [0.0, 0.0], [0.12, 0.24]), Fill::Scheme),
            ]);
            let about = "A shaken carriage throws a slider to and fro between two stops.";
            let drawing = Drawing::of(["Slider between stops", about], [[-0.85, 0.35], [-0.22, 0.22]], frames, shapes);
            drawing.with(["zero-order-hold", "rim-nonsmooth-gap"])
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimbench_core::cosim::StopFlag;
    use std::f64::consts::TAU;

    #[test]
    fn without_the_actuator_the_exact_solution_gives_the_published_times() {
        let mut free = Ball::defaults();
        free.carriage.spring_stiffness_n_m = 0.0;
        let mut solution = EventDriven::new(ball(&free));
        let impacts = solution.impacts(9.0).to_vec();
        approx::assert_relative_eq!(impacts[0].time, 0.451523641, epsilon = 5e-10);
        // Rebounds below 1 µm/s are cut off: what is left of the sum is 2 · 1e-6/g/(1 − e) = 2e-6 s; and those 146 or
        // so that are not are each rounded to 1e-14 m, at 1 µm/s 1e-8 s.
        approx::assert_relative_eq!(impacts[impacts.len() - 1].time, 8.578949, epsilon = 4e-6);
        for (n, impact) in impacts.iter().enumerate().take(100) {
            approx::assert_relative_eq!(impact.velocity, -4.429447 * 0.9_f64.powi(n as i32), max_relative = 1e-6);
        }
        let (rest, stuck) = solution.at(9.0, StopFlag::never());
        assert!(stuck && rest[0] == 0.0 && rest[1] == 0.0);
    }

    #[test]
    fn between_impacts_the_coupled_solution_keeps_its_energy_and_loses_the_right_part_in_each() {
        // No damping: energy of ball, carriage and springs is constant but for ½ m (1 − e²) V² per impact.
        let energy = |solution: &mut EventDriven, t: f64| {
            let (z, _) = solution.at(t, StopFlag::never());
            let kinetic = 0.5 * z[1] * z[1] + 0.05 * z[3] * z[3];
            kinetic + 9.81 * z[0] + (z[2] - z[0]).powi(2) + 2.5 * (z[2] - 1.0).powi(2)
        };
        let mut solution = EventDriven::new(ball(&Ball::defaults()));
        let start = energy(&mut solution, 0.0);
        for t in [0.2, 1.0, 2.0, 3.0, 5.0] {
            let lost: f64 = solution.impacts(t).iter().map(|impact| 0.5 * 0.19 * impact.velocity.powi(2)).sum();
            approx::assert_relative_eq!(energy(&mut solution, t) + lost, start, epsilon = 1e-9);
        }
    }

    /// The closed form of [`impact_oscillator`]: `V` and φ of the orbit with one impact every `n` periods.
    fn orbit(p: &Shaken, n: f64) -> (f64, f64) {
        let omega = TAU * p.carriage.base_frequency_hz;
        let (e, d) = (p.contacts.restitution, p.stop_position_m);
        let own = (p.carriage.spring_stiffness_n_m / p.mass_kg).sqrt();
        let steady = own * own * p.carriage.base_amplitude_m / (own * own - omega * omega);
        let slope = (1.0 + e) / (2.0 * own * libm::tan(own * TAU * n / (2.0 * omega)));
        let side = (1.0 - e) / (2.0 * omega);
        // (slope² + side²) V² + 2 d slope V + d² − X² = 0, the larger root.
        let (a, b, c) = (slope * slope + side * side, 2.0 * d * slope, d * d - steady * steady);
        let v = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
        (v, libm::atan2((d + slope * v) / steady, side * v / steady))
    }

    /// The case at a frequency (Hz), started just after the impact of that orbit.
    fn on_orbit(n: f64, frequency: f64) -> (DrivenMass, f64) {
        let mut p = Shaken::defaults();
        p.carriage.base_frequency_hz = frequency;
        let (v, phase) = orbit(&p, n);
        p.carriage.base_phase_rad = phase;
        (p.start_position_m, p.start_velocity_m_s) = (p.stop_position_m, -p.contacts.restitution * v);
        (shaken(&p), v)
    }

    #[test]
    fn the_solution_from_impact_to_impact_keeps_the_period_n_orbits_of_the_closed_form() {
        // Frequencies at which the orbit stays on its side of the stop.
        for (n, frequency) in [(1.0, 2.4), (2.0, 5.0), (3.0, 7.6)] {
            let (mass, v) = on_orbit(n, frequency);
            let period = TAU * n / mass.actuator.angular_frequency();
            let mut solution = EventDriven::new(mass);
            let impacts = solution.impacts(3.5 * period);
            assert_eq!(impacts.len(), 3);
            // Bisection to round-off of a gap of 0.05 m at 1 m/s or more; the orbits are stable with multipliers of
            // modulus e.
            for (k, impact) in impacts.iter().enumerate() {
                approx::assert_relative_eq!(impact.time, (k + 1) as f64 * period, epsilon = 1e-11);
                approx::assert_relative_eq!(impact.velocity, v, epsilon = 1e-10);
            }
        }
    }

    #[test]
    fn a_steady_oscillation_touches_the_stop_just_beyond_grazing_and_not_just_before() {
        for (excess, touches) in [(-1e-6, false), (1e-6, true)] {
            let mut p = Shaken::defaults();
            let (k, omega) = (100.0, TAU * p.carriage.base_frequency_hz);
            // X = d (1 + excess), in antiphase to the base above resonance.
            let steady = -0.05 * (1.0 + excess);
            p.carriage.base_amplitude_m = steady * (k - omega * omega) / k;
            p.start_velocity_m_s = omega * steady;
            let mut solution = EventDriven::new(shaken(&p));
            assert_eq!(!solution.impacts(2.0).is_empty(), touches, "{excess}");
        }
    }
}
