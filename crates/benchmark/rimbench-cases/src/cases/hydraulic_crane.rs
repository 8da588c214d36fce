//! `hydraulic-crane`: a two-link crane lifted by one hydraulic cylinder, the multirate benchmark of the field
//! (Laboratorio de Ingeniería Mecánica, Univ. da Coruña, `fgonzalezLIM/cosim-benchmarks`; Naya et al. 2011). Two
//! degrees of freedom, two pressures, no contact. Shown in `docs/cases/hydraulic-crane.md`.
//!
//! `stale_feedthrough=true`: the force at a communication point is made with the velocity the hydraulics was given for
//! the step before. `published_driver=true`: that, and the hydraulics is one of its own micro steps ahead, and rows are
//! stamped one macro step late (for every H; where the micro step is H the two cancel, as the manoeuvre starts from
//! rest). Off by default: they are faults, not the benchmark. With fresh feedthrough and a zero-order hold,
//! `force-displacement` is the same map as `pressure-displacement`: what separates the published stability limits of
//! the two is the stale velocity alone.

use super::hydraulic_crane_reference::Parts;
use super::prelude::*;
use rimbench_core::cosim::{PerSide, Subsystem};
use rimbench_core::mechanics::{ContactLaw, NonSmoothMechanics};

choices! {
    /// What the spool does.
    enum Manoeuvre {
        M1 = "m1",
        M2 = "m2",
    }
}
choices! {
    /// What the cylinder puts out.
    enum Coupling {
        ForceDisplacement = "force-displacement",
        PressureDisplacement = "pressure-displacement",
    }
}
parameters! {
    /// The crane and its cylinder.
    struct Lift from "LIM cosim-benchmarks" {
        manoeuvre: Manoeuvre [M1, M2], "steps (m1) or sine (m2) of the spool";
        coupling: Coupling [ForceDisplacement, PressureDisplacement], "what the cylinder puts out: its force or its pressures";
        stale_feedthrough: bool = false, [false, true], "make the force with the velocity given for the step before".when(&[["coupling", "force-displacement"], ["published_driver", "false"]]);
        published_driver: bool = false, [false, true], "all quirks of the published driver: stale feedthrough, hydraulics one micro step ahead, rows late";
        link_1_length_m: f64 = 1.0, Positive, "length L of link 1";
        link_2_length_m: f64 = 0.5, Positive, "length L_h of link 2";
        rod_mass_kg: f64 = 200.0, Positive, "mass m of link 1, a uniform rod";
        joint_mass_kg: f64 = 250.0, NotNegative, "point mass m_p at the end of link 1";
        end_mass_kg: f64 = 100.0, Positive, "point mass m_h at the end of link 2";
        pin_x_m: f64 = 0.8660254037844386, Positive, "x of the actuator's fixed end B; its y is 0";
        theta_1_start_rad: f64 = 0.5235987755982989, Finite, "angle of link 1 at the start";
        theta_2_start_rad: f64 = -1.5707963267948966, Finite, "angle of link 2 at the start";
        cylinder: Cylinder with |set| set
            .default("piston_area_m2", 65e-4).default("cylinder_length_m", 0.442)
            .source("cylinder_length_m", "Naya et al. 2011").default("viscous_friction_n_s_m", 1e5)
            .source("viscous_friction_n_s_m", "Naya et al. 2011").default("valve_area_m2", 5e-4)
            .source("valve_area_m2", "Naya et al. 2011");
        oil: Oil;
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity".from("LIM cosim-benchmarks");
    }
}

pub(super) fn entry() -> Case {
    Case {
        trace_columns: words(
            "time_s actuator_length_m actuator_velocity_m_s actuator_force_n pressure_1_pa pressure_2_pa \
             spool theta_1_rad theta_2_rad",
        ),
        interface_columns: hydraulics::interface(),
        reference: Arc::new(own_reference),
        drawing: drawn(|p: &Lift| {
            let length = p.link_1_length_m;
            let frames = vec![
                frame("link 1", 0.0, 0.0, "theta_1_rad"),
                within("link 1", frame("joint", length, 0.0, Channel::Column("theta_1_rad", -1.0, 0.0))),
                within("joint", frame("link 2", 0.0, 0.0, "theta_2_rad")),
            ];
            let end = [p.link_2_length_m, 0.0];
            let shapes = vec![
                Shape::Cylinder {
                    from: ([p.pin_x_m, 0.0], None),
                    to: ([0.5 * length, 0.0], Some("link 1")),
                    barrel: 0.8 * p.cylinder.cylinder_length_m,
                    width: 0.07,
                },
                Shape::Polygon(rectangle("link 1", [length / 2.0, 0.0], [length, 0.06]), Fill::Metal),
                Shape::Line(vec![([0.0, 0.0], Some("link 2")), (end, Some("link 2"))]),
                disc(([0.0, 0.0], None), 0.05, Fill::Metal),
                disc(([length, 0.0], Some("link 1")), 0.05, Fill::Metal),
                disc((end, Some("link 2")), 0.09, Fill::Scheme),
                wall([-0.2, -0.09], [1.2 * p.pin_x_m, -0.05]),
            ];
            let title = ["Two-link crane", "A cylinder lifts a link, from the end of which another swings."];
            Some(Drawing {
                force: "cylinder force",
                in_kilonewtons: true,
                ..Drawing::of(title, [[-0.5, 1.7], [-0.25, 0.95]], frames, shapes)
            })
        }),
        ..Case::new(
            "hydraulic-crane",
            "Two-link crane with one hydraulic cylinder (LIM benchmark; published monolithic and Jacobi data)",
            times(10.0, 1e-3, 2e-4, [2e-4, 2e-4]),
            build,
        )
    }
}

fn parts(p: &Lift) -> Result<Parts> {
    let crane = Crane::new(CraneGeometry {
        link_1_length: p.link_1_length_m,
        link_2_length: p.link_2_length_m,
        rod_mass: p.rod_mass_kg,
        joint_mass: p.joint_mass_kg,
        end_mass: p.end_mass_kg,
        pin_x: p.pin_x_m,
        attachment: 0.5 * p.link_1_length_m,
        start_angles: [p.theta_1_start_rad, p.theta_2_start_rad],
        gravity: p.gravity_m_s2,
    })?;
    let (pressures, centre) = p.cylinder.equilibrium(&p.oil, crane.equilibrium_force())?;
    let spool = match p.manoeuvre {
        Manoeuvre::M2 => Spool::sine(centre, 2.0, vec![(0.0, 0.0), (1.0, 0.1), (8.0, 0.1), (9.0, 0.0)]),
        Manoeuvre::M1 => {
            Spool::new(vec![(2.0, centre), (2.001, centre - 0.01), (6.0, centre - 0.01), (6.002, centre + 0.02)])
        }
    };
    let cylinder = p.cylinder.starting_at(crane.start_length(), &p.oil, pressures, spool)?;
    Ok(Parts { cylinder, crane, size: p.cylinder })
}

/// The whole crane by the trapezoidal rule.
fn own_reference(parameters: &Parameters) -> Result<ReferenceMethod> {
    let parts = parts(&Lift::read(parameters))?;
    Ok(ReferenceMethod::Own(Box::new(move |steps, stop, out| parts.clone().solve(steps, stop, out))))
}

fn build(p: &Lift, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let Parts { crane, cylinder, size } = parts(p)?;
    let law = ContactLaw { stabilisation: 0.0, restitution: 0.0, spring: None };
    let mechanics = NonSmoothMechanics::new(crane, law, cylinder.ports().facing(), assembly.solver.checked(0));
    let published = p.published_driver;
    let mut system = if p.coupling == Coupling::PressureDisplacement {
        // No feedthrough that could be stale.
        let actuator = driven(PressureOutput::new(cylinder), published, false);
        let mechanics = Box::new(PressureDrivenMechanics::new(mechanics, size));
        let mut system = CoupledSystem::of(PerSide { mechanics, actuator });
        system.derived.push(DerivedColumn::new(
            "actuator_force_n",
            ["pressure_1_pa", "pressure_2_pa", "actuator_velocity_m_s"],
            move |row| size.force([row[0], row[1]], row[2]),
        ));
        system
    } else {
        let stale = published || p.stale_feedthrough;
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
