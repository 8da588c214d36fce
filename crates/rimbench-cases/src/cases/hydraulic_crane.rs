//! `hydraulic-crane`: a two-link crane lifted by one hydraulic cylinder, the multirate benchmark of the field.
//!
//! ```text
//!                    ___●  m_p  (end of link 1, length L, rod of mass m)
//!               ___--P   \
//!          ___--    ╱     \  link 2, length L_h, massless
//!     O ●--θ₁     ╱ s      \
//!   ════╧════════●══════    ●  m_h
//!                B = (√3/2, 0)
//! ```
//! Two degrees of freedom (the angles of the links), two pressures, no contact. The cylinder pushes from B to P, the
//! middle of link 1. It starts in static equilibrium: the pressures balance the weight, and the spool is where both
//! chambers rest,
//!
//! ```text
//! p₁,₂ = ½(p_P + p_T) ∓ F/(2A)        κ₀ = √(p₁ − p_T) / (√(p_P − p₁) + √(p₁ − p_T))
//! ```
//! which gives the published 3 170 846.1538 Pa, 4 529 153.8462 Pa and 0.454345589598 for the default parameters.
//!
//! **Manoeuvres.** `m1`: κ₀ until 2 s; −0.01 within 1 ms; at 6 s +0.03 within 2 ms. `m2`: κ₀(1 − A(t) sin(4πt)) with A
//! rising to 0.1 within 1 s, held until 8 s, falling to 0 at 9 s. (The published document calls the 2 of 4π = 2π·2 an
//! angular frequency in rad/s; it is a frequency in Hz, as the code and the published trace have it.)
//!
//! **Couplings.** `force-displacement`: the cylinder puts out its force and has direct feedthrough through its viscous
//! friction. `pressure-displacement`: it puts out its pressures, and the mechanics makes the force; no feedthrough, and
//! no reduced interface model.
//!
//! **Reference**: the whole system by the trapezoidal rule, finest step 0.05 ms as published; its own uncertainty by
//! refinement. **Trusted**: agrees with the published monolithic solution to the published digits (see
//! `tests/published_data.rs`), and so do co-simulations with `published_driver=true`.
//!
//! **Published driver.** `stale_feedthrough=true`: the force at a communication point is made with the velocity the
//! hydraulics was given for the step before. `published_driver=true`: that, and the hydraulics is one of its own micro
//! steps ahead, and rows are stamped one macro step late (for every H; where the micro step is H the two cancel, as the
//! manoeuvre starts from rest). Off by default: they are faults, not the benchmark. With fresh feedthrough and a
//! zero-order hold, `force-displacement` is the same map as `pressure-displacement`: what separates the published
//! stability limits of the two is the stale velocity alone.
//!
//! **Source**: Laboratorio de Ingeniería Mecánica, Univ. da Coruña, `fgonzalezLIM/cosim-benchmarks` (MIT); Naya et al.
//! 2011; used in Peiret et al. 2018. `rimbench list parameters --case hydraulic-crane` prints the parameter table.

use super::case::{Case, CaseDefaults, CoupledSystem, DerivedColumn};
use super::cylinder;
use super::fluid::{self, NAYA};
use super::hydraulic_crane_reference::solve;
use super::hydraulics;
use super::parameters::{Parameter, Parameters, Range, number as p};
use super::reference_method::ReferenceMethod;
use crate::models::{
    Crane, CraneGeometry, HydraulicCylinder, PressureDrivenMechanics, PressureOutput, PublishedClock, Spool,
    StaleFeedthrough,
};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::cosim::{PerSide, Subsystem};
use rimbench_core::error::Result;
use rimbench_core::mechanics::{ContactLaw, NonSmoothMechanics};
use rimbench_core::name::names;
use std::sync::Arc;

pub(super) fn entry() -> Case {
    Case {
        parameters: parameters(),
        trace_columns: names(&[
            "time_s",
            "actuator_length_m",
            "actuator_velocity_m_s",
            "actuator_force_n",
            "pressure_1_pa",
            "pressure_2_pa",
            "spool",
            "theta_1_rad",
            "theta_2_rad",
        ]),
        interface_columns: vec![cylinder::interface()],
        reference: Arc::new(own_reference),
        ..Case::new(
            "hydraulic-crane",
            "Two-link crane with one hydraulic cylinder (LIM benchmark; published monolithic and Jacobi data)",
            CaseDefaults {
                duration_s: 10.0,
                macro_step_s: 1e-3,
                micro_step_s: 2e-4,
                reference_step_s: 2e-4,
                reference_sampling_s: 2e-4,
            },
            build,
        )
    }
}

const LIM: &str = "LIM cosim-benchmarks";

fn parameters() -> Vec<Parameter> {
    use Range::{Finite, NotNegative, Positive};
    [
        vec![
            Parameter::choice("manoeuvre", ["m1", "m2"], "steps (m1) or sine (m2) of the spool", LIM),
            Parameter::choice(
                "coupling",
                ["force-displacement", "pressure-displacement"],
                "what the cylinder puts out: its force or its pressures",
                LIM,
            ),
            Parameter::choice(
                "stale_feedthrough",
                ["false", "true"],
                "make the force with the velocity given for the step before",
                LIM,
            ),
            Parameter::choice(
                "published_driver",
                ["false", "true"],
                "all quirks of the published driver: stale feedthrough, hydraulics one micro step ahead, rows late",
                LIM,
            ),
            p("link_1_length_m", "m", 1.0, Positive, "length L of link 1", LIM),
            p("link_2_length_m", "m", 0.5, Positive, "length L_h of link 2", LIM),
            p("rod_mass_kg", "kg", 200.0, Positive, "mass m of link 1, a uniform rod", LIM),
            p("joint_mass_kg", "kg", 250.0, NotNegative, "point mass m_p at the end of link 1", LIM),
            p("end_mass_kg", "kg", 100.0, Positive, "point mass m_h at the end of link 2", LIM),
            p("pin_x_m", "m", 0.866_025_403_784_438_6, Positive, "x of the actuator's fixed end B; its y is 0", LIM),
            p("theta_1_start_rad", "rad", std::f64::consts::FRAC_PI_6, Finite, "angle of link 1 at the start", LIM),
            p("theta_2_start_rad", "rad", -std::f64::consts::FRAC_PI_2, Finite, "angle of link 2 at the start", LIM),
            p("piston_area_m2", "m²", 65e-4, Positive, "piston area A", NAYA),
            p("cylinder_length_m", "m", 0.442, Positive, "length l of both chambers together", NAYA),
            p("viscous_friction_n_s_m", "N·s/m", 1e5, NotNegative, "viscous friction c of the cylinder", NAYA),
            p("valve_area_m2", "m²", 5e-4, Positive, "valve area a_v", NAYA),
        ],
        fluid::parameters(),
        vec![p("gravity_m_s2", "m/s²", 9.81, NotNegative, "gravity", LIM)],
    ]
    .concat()
}

/// What both the co-simulation and the reference are made from.
#[derive(Clone)]
pub(super) struct Parts {
    pub(super) crane: Crane,
    pub(super) cylinder: HydraulicCylinder,
    pub(super) spool: Spool,
    pub(super) piston_area: f64,
    pub(super) viscous_friction: f64,
}

fn parts(parameters: &Parameters) -> Result<Parts> {
    let get = |name: &str| parameters.number(name);
    let crane = Crane::new(CraneGeometry {
        link_1_length: get("link_1_length_m"),
        link_2_length: get("link_2_length_m"),
        rod_mass: get("rod_mass_kg"),
        joint_mass: get("joint_mass_kg"),
        end_mass: get("end_mass_kg"),
        pin_x: get("pin_x_m"),
        attachment: 0.5 * get("link_1_length_m"),
        start_angles: [get("theta_1_start_rad"), get("theta_2_start_rad")],
        gravity: get("gravity_m_s2"),
    })?;
    let (pressures, centre) = hydraulics::equilibrium(parameters, crane.equilibrium_force())?;
    let spool = match parameters.choice("manoeuvre") {
        "m2" => Spool::sine(centre, 2.0, vec![(0.0, 0.0), (1.0, 0.1), (8.0, 0.1), (9.0, 0.0)]),
        _ => Spool::new(vec![(2.0, centre), (2.001, centre - 0.01), (6.0, centre - 0.01), (6.002, centre + 0.02)]),
    };
    Ok(Parts {
        cylinder: hydraulics::of_any_stroke(parameters, crane.start_length(), pressures, spool.clone()),
        crane,
        spool,
        piston_area: get("piston_area_m2"),
        viscous_friction: get("viscous_friction_n_s_m"),
    })
}

/// The whole crane by the trapezoidal rule.
fn own_reference(parameters: &Parameters) -> Result<ReferenceMethod> {
    let parts = parts(parameters)?;
    Ok(ReferenceMethod::Own(Box::new(move |steps, stop, out| solve(&parts, steps, stop, out))))
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let Parts { crane, cylinder, piston_area, viscous_friction, .. } = parts(parameters)?;
    let law = ContactLaw { stabilisation: 0.0, restitution: 0.0, spring: None };
    let mechanics = NonSmoothMechanics::new(crane, law, cylinder.ports().facing(), solver.checked(0));
    let published = parameters.choice("published_driver") == "true";
    let mut system = if parameters.choice("coupling") == "pressure-displacement" {
        // No feedthrough that could be stale.
        let actuator = driven(PressureOutput::new(cylinder), published, false);
        let mechanics = Box::new(PressureDrivenMechanics::new(mechanics, piston_area, viscous_friction));
        let mut system = CoupledSystem::of(PerSide { mechanics, actuator });
        system.derived.push(DerivedColumn::new(
            "actuator_force_n",
            ["pressure_1_pa", "pressure_2_pa", "actuator_velocity_m_s"],
            move |row| (row[1] - row[0]) * piston_area - viscous_friction * row[2],
        ));
        system
    } else {
        let stale = published || parameters.choice("stale_feedthrough") == "true";
        CoupledSystem::of(PerSide { mechanics: Box::new(mechanics), actuator: driven(cylinder, published, stale) })
    };
    system.late_rows = published;
    Ok(system)
}

/// The hydraulics with the quirks asked for.
fn driven(hydraulics: impl Subsystem + Clone + 'static, published: bool, stale: bool) -> Box<dyn Subsystem> {
    match (published, stale) {
        (false, false) => Box::new(hydraulics),
        (false, true) => Box::new(StaleFeedthrough::new(hydraulics)),
        (true, false) => Box::new(PublishedClock::new(hydraulics)),
        (true, true) => Box::new(StaleFeedthrough::new(PublishedClock::new(hydraulics))),
    }
}
