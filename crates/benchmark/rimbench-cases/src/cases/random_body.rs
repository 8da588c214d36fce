//! `random-body`: a plane body drawn at random, with two contacts and a passive actuator of one of six kinds. Shown in
//! `docs/cases/random-body.md`; numbers *ours*.

use super::prelude::*;
use crate::models::force_ports;
use rimbench_core::cosim::{Capabilities, Ports, Subsystem, SubsystemCounters, subsystem_methods};
use rimbench_core::error::Failure;
use rimbench_core::interface_model::Rows;
use rimbench_core::mechanics::{MechanicalModel, ModelNames, ModelSize};
use rimbench_core::name::names;
use rimbench_statistics::latin_hypercube;
use std::array::from_fn;
use std::f64::consts::{PI, TAU};

choices! {
    /// What is added to the actuator's spring.
    enum Kind {
        Spring = "spring",
        Cubic = "cubic",
        Damped = "damped",
        Saturating = "saturating",
        Varying = "varying",
        Active = "active",
    }
}
parameters! {
    /// What is not drawn at random.
    struct Choice from "ours" {
        seed: u32 = 1, 0..=999_999, "seed by which body, contacts, motion and actuator are drawn";
        actuator: Kind [Spring, Cubic, Damped, Saturating, Varying, Active],
            "spring alone, with a cubic part, with a damper, saturating, with a varying damper, with a pump whose work is booked";
        own_frequency_rad_s: f64 = 0.0, NotNegative, "angular frequency of the body's own springs to the ground; 0: none";
        contacts: Contacts with |set| set.only(&["stabilisation", "friction"]);
    }
}

const STATE: [&str; 6] =
    ["body_x_m", "body_y_m", "body_angle_rad", "body_velocity_x_m_s", "body_velocity_y_m_s", "body_spin_rad_s"];
const FORCES: [&str; 2] = ["contact_force_first_n", "contact_force_second_n"];

/// The macro step that the actuator's frequencies are drawn for, s.
const MACRO_STEP: f64 = 0.02;

pub(super) fn entry() -> Case {
    Case {
        trace_columns: carriage::trace_columns(
            "energy_growth effective_mass_kg gap_first_m gap_second_m contact_force_first_n contact_force_second_n closed_contacts",
        ),
        drawing_columns: [names(&STATE), Passive::OBSERVABLES.to_vec()].concat(),
        interface_columns: carriage::interface(),
        constant_mechanics: true,
        drawing: drawn(|p: &Choice| Some(drawing(&Body::drawn(p.seed)))),
        ..Case::new(
            "random-body",
            "A body drawn at random with two contacts and a passive actuator of one of six kinds",
            times(8.0, MACRO_STEP, 1e-4, [1e-3, 2e-3]),
            build,
        )
    }
}

/// A body that moves by small displacements, so that its rows are constant: the corners of a triangle, two with
/// contacts and the third with the actuator, each with the direction in which it is pushed.
#[derive(Debug, Clone)]
struct Body {
    mass: [f64; 3],
    /// Of its own springs: square of their angular frequency.
    own: f64,
    corners: [[f64; 2]; 3],
    directions: [[f64; 2]; 3],
    gaps: [f64; 2],
    velocity: [f64; 3],
    /// Of the actuator, as it would be without contacts: Ω, and damping ratio.
    actuator: [f64; 2],
}

impl Body {
    fn drawn(seed: u32) -> Self {
        let mut numbers = latin_hypercube(1, 14, seed.into()).remove(0).into_iter();
        let mut between = |low: f64, high: f64| low + (high - low) * numbers.next().unwrap_or(0.5);
        let (mass, gyration) = (between(0.3, 3.0), between(0.3, 1.0));
        let first = between(0.0, TAU);
        let angles = [first, first + between(0.2, 0.5) * TAU, first + between(0.6, 0.9) * TAU];
        let unit = |angle: f64| [libm::cos(angle), libm::sin(angle)];
        let turns = [(); 3].map(|()| between(0.0, 2.0));
        let mut body = Body {
            mass: [mass, mass, mass * gyration * gyration],
            own: 0.0,
            corners: angles.map(unit),
            directions: from_fn(|i| unit(angles[i] + turns[i] * PI)),
            gaps: [0.0, between(0.0, 0.03)],
            velocity: [between(-1.0, 1.0), between(-1.0, 1.0), between(-1.0, 1.0) / gyration],
            actuator: [between(0.3, 8.0), between(0.01, 0.3)],
        };
        // The first contact rests or leaves.
        let row = body.row(0, body.directions[0]);
        let approach = row.iter().zip(&body.velocity).map(|(a, v)| a * v).sum::<f64>().min(0.0);
        let square: f64 = row.iter().map(|a| a * a).sum();
        body.velocity.iter_mut().zip(row).for_each(|(v, a)| *v -= a * approach / square);
        body
    }

    /// How a corner moves along a direction.
    fn row(&self, corner: usize, [along, up]: [f64; 2]) -> [f64; 3] {
        let [x, y] = self.corners[corner];
        [along, up, x * up - y * along]
    }

    /// How the actuator's corner moves along its direction.
    fn driven(&self) -> [f64; 3] {
        self.row(2, self.directions[2])
    }

    fn energy(&self, q: &[f64], v: &[f64]) -> f64 {
        let kinetic: f64 = self.mass.iter().zip(v).map(|(m, v)| 0.5 * m * v * v).sum();
        kinetic + self.potential_energy(q)
    }

    fn passive(&self, kind: Kind) -> PassiveParameters {
        let mobility: f64 = self.driven().iter().zip(self.mass).map(|(a, m)| a * a / m).sum();
        let [turns, ratio] = self.actuator;
        let stiffness = (turns / MACRO_STEP).powi(2) / mobility;
        // What deflects at 0.3 m/s, in the spring's own time.
        let far = 0.3 / (stiffness * mobility).sqrt();
        let only = |kinds: &[Kind], value: f64| if kinds.contains(&kind) { value } else { 0.0 };
        PassiveParameters {
            stiffness,
            cubic: only(&[Kind::Cubic], stiffness / (far * far)),
            saturation: if kind == Kind::Saturating { far } else { f64::INFINITY },
            damping: only(&[Kind::Damped, Kind::Varying], 2.0 * ratio * (stiffness / mobility).sqrt()),
            varying: only(&[Kind::Varying], 1.0),
            pump: only(&[Kind::Active], 0.3),
            angular_frequency: 1.0 / (3.7 * MACRO_STEP),
        }
    }
}

fn write(row: [f64; 3], start: f64, q: &[f64], index: usize, rows: &mut Rows) {
    rows.jacobian[3 * index..3 * index + 3].copy_from_slice(&row);
    rows.position[index] = start + row.iter().zip(q).map(|(a, q)| a * q).sum::<f64>();
}

impl MechanicalModel for Body {
    fn size(&self) -> ModelSize {
        ModelSize {
            velocities: 3,
            unilateral: 2,
            tangential: 2,
            interface: 1,
            constant_mass: true,
            ..ModelSize::default()
        }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (vec![0.0; 3], self.velocity.to_vec())
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        mass.copy_from_slice(&self.mass);
    }

    fn forces(&self, q: &[f64], _v: &[f64], force: &mut [f64]) {
        force.iter_mut().zip(self.mass).zip(q).for_each(|((force, mass), q)| *force = -mass * self.own * q);
    }

    fn unilateral(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        for contact in 0..2 {
            write(self.row(contact, self.directions[contact]), self.gaps[contact], q, contact, rows);
        }
    }

    fn tangential(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        for contact in 0..2 {
            let [along, up] = self.directions[contact];
            write(self.row(contact, [up, -along]), 0.0, q, contact, rows);
        }
    }

    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        write(self.driven(), 0.0, q, 0, rows);
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        self.mass.iter().zip(q).map(|(mass, q)| 0.5 * mass * self.own * q * q).sum()
    }

    fn names(&self) -> ModelNames {
        ModelNames::of(&STATE, &["first", "second"])
    }

    fn observe(&self, q: &[f64], v: &[f64], row: &mut [f64]) {
        row[..3].copy_from_slice(q);
        row[3..].copy_from_slice(v);
    }
}

/// Numbers of the actuator.
#[derive(Debug, Clone, Copy)]
struct PassiveParameters {
    /// k, N/m.
    stiffness: f64,
    /// k₃, N/m³.
    cubic: f64,
    /// x₀ beyond which the spring saturates, m; infinite for one that does not.
    saturation: f64,
    /// c, N·s/m.
    damping: f64,
    /// Share of the damping that comes and goes.
    varying: f64,
    /// Amplitude of the velocity of the pump, m/s.
    pump: f64,
    /// Angular frequency Ω of damping and pump, rad/s.
    angular_frequency: f64,
}

/// The actuator; it remembers its deflection and does not ask for positions.
///
/// ```text
/// F = −k x/(1 + |x|/x₀) − k₃ x³ − c (1 + σ sin Ωt) w        ẋ = w + s sin Ωt
/// ```
#[derive(Debug, Clone)]
struct Passive {
    parameters: PassiveParameters,
    deflection: f64,
    time: f64,
    supplied: f64,
    turned_over: f64,
    ports: Ports,
    counters: SubsystemCounters,
}

impl Passive {
    /// Energy stored less that which the pump supplied, and the magnitudes of what it supplied, summed.
    const OBSERVABLES: [Name; 2] = [Name::Borrowed("actuator_energy_j"), Name::Borrowed("turned_over_j")];

    /// Builds the actuator without deflection.
    fn new(parameters: PassiveParameters) -> Self {
        let ports = force_ports("interface_position_m", "interface_velocity_m_s");
        let counters = SubsystemCounters::default();
        Passive { parameters, deflection: 0.0, time: 0.0, supplied: 0.0, turned_over: 0.0, ports, counters }
    }

    fn spring(&self, x: f64) -> f64 {
        let p = &self.parameters;
        p.stiffness * x / (1.0 + x.abs() / p.saturation) + p.cubic * x.powi(3)
    }

    fn swing(&self) -> f64 {
        libm::sin(self.parameters.angular_frequency * self.time)
    }

    fn stored(&self) -> f64 {
        let (p, x) = (&self.parameters, self.deflection);
        let part = x.abs() / p.saturation;
        let spring = match part < 1e-3 {
            true => p.stiffness * x * x * (0.5 - part / 3.0),
            false => p.stiffness * p.saturation.powi(2) * (part - libm::log1p(part)),
        };
        spring + 0.25 * p.cubic * x.powi(4)
    }
}

impl Subsystem for Passive {
    subsystem_methods!(ports capabilities counters clone);

    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        let p = &self.parameters;
        y[0] = -self.spring(self.deflection) - p.damping * (1.0 + p.varying * self.swing()) * u[1];
        Ok(())
    }

    fn step(&mut self, _t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        let pumped = self.parameters.pump * self.swing();
        let way = h * (u[1] + pumped);
        let work = self.spring(self.deflection + 0.5 * way) * h * pumped;
        self.supplied += work;
        self.turned_over += work.abs();
        self.deflection += way;
        self.time += h;
        self.counters.micro_steps += 1;
        let finite = self.deflection.is_finite();
        if finite { Ok(()) } else { Err(Failure::non_finite(Self::OBSERVABLES[0].clone())) }
    }
}

impl Capabilities for Passive {
    fn observables(&mut self) -> &[Name] {
        &Self::OBSERVABLES
    }

    fn observe(&mut self, _h: f64, row: &mut [f64]) {
        row.copy_from_slice(&[self.stored() - self.supplied, self.turned_over]);
    }
}

fn build(p: &Choice, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let body = Body { own: p.own_frequency_rad_s.powi(2), ..Body::drawn(p.seed) };
    let start = body.energy(&[0.0; 3], &body.velocity);
    let mut system = assembly.couple(body.clone(), Passive::new(body.passive(p.actuator)), &p.contacts)?;
    system.unbounded = true;
    let from = names(&STATE).into_iter().chain(Passive::OBSERVABLES);
    system.derived.push(DerivedColumn::new("energy_growth", from, move |row| {
        1.0 + (body.energy(&row[..3], &row[3..6]) + row[6] - start) / (start + row[7])
    }));
    Ok(system)
}

fn drawing(body: &Body) -> Drawing {
    let moved = |i: usize, by: f64| {
        let ([x, y], [along, up]) = (body.corners[i], body.directions[i]);
        move |aside: f64| [x + by * along - aside * up, y + by * up + aside * along]
    };
    let surface = |contact: usize| {
        let [face, back] = [0.0, 0.1].map(|depth| moved(contact, -body.gaps[contact] - depth));
        Shape::Polygon([face(-0.3), face(0.3), back(0.3), back(-0.3)].map(|at| (at, None)).to_vec(), Fill::Ground)
    };
    let corner = |i: usize| (body.corners[i], Some("body"));
    let arrow = |contact: usize| Shape::Arrow {
        column: FORCES[contact],
        at: corner(contact),
        along: body.directions[contact],
        scale: 1e-2,
    };
    let shapes = vec![
        surface(0),
        surface(1),
        Shape::Polygon((0..3).map(corner).collect(), Fill::Scheme),
        Shape::Spring((moved(2, -0.6)(0.0), None), corner(2), 0.06),
        arrow(0),
        arrow(1),
    ];
    let about = "A body drawn at random, two surfaces that it may touch, and a passive actuator.";
    let frames = vec![frame("body", "body_x_m", "body_y_m", "body_angle_rad")];
    let view = [[-2.0, 2.0], [-1.7, 1.7]];
    Drawing { follow: Some("body_x_m"), ..Drawing::of(["Random body", about], view, frames, shapes) }
}
