//! `hydraulic-crane`: a two-link crane lifted by one hydraulic cylinder, the multirate benchmark of the field (Laboratorio de Ingeniería Mecánica,
//! Univ. da Coruña, `fgonzalezLIM/cosim-benchmarks`; Naya et al. 2011). Two degrees of freedom, two pressures, no contact. Shown in
//! `docs/cases/hydraulic-crane.md`.
//!
//! `stale_feedthrough=true`: the force at a communication point is made with the velocity the hydraulics was given for the step before.
//! `published_driver=true`: that, and the hydraulics is one of its own micro steps ahead, and rows are stamped one macro step late (for every H;
//! where the micro step is H the two cancel, as the manoeuvre starts from rest). Off by default: they are faults, not the benchmark. With fresh
//! feedthrough and a zero-order hold, `force-displacement` is the same map as `pressure-displacement`: what separates the published stability limits
//! of the two is the stale velocity alone.

use super::hydraulic_crane_reference::solve;
use super::prelude::*;
use rimbench_core::cosim::{PerSide, Subsystem};
use rimbench_core::mechanics::{ContactLaw, NonSmoothMechanics};

const PARAMETERS: &str = "source: LIM cosim-benchmarks
    manoeuvre | - | m1, m2 | choice | steps (m1) or sine (m2) of the spool
    coupling | - | force-displacement, pressure-displacement | choice | what the cylinder puts out: its force or its pressures
    stale_feedthrough | - | false, true | choice | make the force with the velocity given for the step before
    published_driver | - | false, true | choice | all quirks of the published driver: stale feedthrough, hydraulics one micro step ahead, rows late
    link_1_length_m | m | 1.0 | positive | length L of link 1
    link_2_length_m | m | 0.5 | positive | length L_h of link 2
    rod_mass_kg | kg | 200.0 | positive | mass m of link 1, a uniform rod
    joint_mass_kg | kg | 250.0 | not negative | point mass m_p at the end of link 1
    end_mass_kg | kg | 100.0 | positive | point mass m_h at the end of link 2
    pin_x_m | m | 0.8660254037844386 | positive | x of the actuator's fixed end B; its y is 0
    theta_1_start_rad | rad | 0.5235987755982989 | finite | angle of link 1 at the start
    theta_2_start_rad | rad | -1.5707963267948966 | finite | angle of link 2 at the start
    source: Naya et al. 2011
    piston_area_m2 | m² | 65e-4 | positive | piston area A
    cylinder_length_m | m | 0.442 | positive | length l of both chambers together
    viscous_friction_n_s_m | N·s/m | 1e5 | not negative | viscous friction c of the cylinder
    valve_area_m2 | m² | 5e-4 | positive | valve area a_v
";
const GRAVITY: &str = "gravity_m_s2 | m/s² | 9.81 | not negative | gravity | LIM cosim-benchmarks";

pub(super) fn entry() -> Case {
    Case {
        parameters: table(&[PARAMETERS, FLUID, GRAVITY]),
        trace_columns: words(
            "time_s actuator_length_m actuator_velocity_m_s actuator_force_n pressure_1_pa pressure_2_pa \
             spool theta_1_rad theta_2_rad",
        ),
        interface_columns: hydraulics::interface(),
        reference: Arc::new(own_reference),
        ..Case::new(
            "hydraulic-crane",
            "Two-link crane with one hydraulic cylinder (LIM benchmark; published monolithic and Jacobi data)",
            times(10.0, 1e-3, 2e-4, [2e-4, 2e-4]),
            build,
        )
    }
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
