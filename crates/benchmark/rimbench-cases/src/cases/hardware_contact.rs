//! `hardware-contact`: a simulated mass whose contacts are hardware. It flies to and fro between two of them, or holds
//! to one that is shaken. Shown in `docs/cases/hardware-contact.md`; mass and contact *published* with a delay of 108
//! ms at steps of 2 ms, play and start *ours*.

use super::prelude::*;

parameters! {
    /// A mass and the hardware that it touches.
    struct Hardware from "rpiRobotics/Hybrid-Simulation" {
        mass_kg: f64 = 500.0, Positive, "mass m, which is simulated";
        play_m: f64 = 0.05, NotNegative, "distance of a contact on either side; 0: one contact, which also pulls".from("ours");
        start_velocity_m_s: f64 = 0.1, Finite, "velocity of the mass at the start, in the middle".from("ours");
        contact: Carriage with |set| set
            .only(&["spring_stiffness_n_m", "spring_damping_n_s_m", "base_amplitude_m", "base_frequency_hz"])
            .from("rpiRobotics/Hybrid-Simulation").within("spring_stiffness_n_m", Positive)
            .default("spring_stiffness_n_m", 11691.0).about("spring_stiffness_n_m", "stiffness k of a contact")
            .default("spring_damping_n_s_m", 131.4).about("spring_damping_n_s_m", "damping c of a contact")
            .source("base_amplitude_m", "ours").default("base_frequency_hz", 0.25);
    }
}

pub(super) fn entry() -> Case {
    Case {
        trace_columns: carriage::trace_columns("carriage_position_m effective_mass_kg"),
        interface_columns: carriage::interface(),
        constant_mechanics: true,
        drawing: drawn(|p: &Hardware| Some(drawing(p))),
        ..Case::new(
            "hardware-contact",
            "Simulated mass that flies to and fro between contacts that are hardware (published mass, contact and delay)",
            times(6.0, 2e-3, 5e-4, [2e-4, 1e-3]),
            |p: &Hardware, assembly| {
                let body = LineMass { mass: p.mass_kg, start: [0.0, p.start_velocity_m_s], ..LineMass::default() };
                let model = LineMasses::new(LineDescription { masses: vec![body], ..LineDescription::default() })?;
                let contact = SpringActuator::new(p.contact)?.with_play(p.play_m);
                assembly.couple(model, contact, &Contacts::defaults())
            },
        )
    }
}

fn drawing(p: &Hardware) -> Drawing {
    let base = |x: f64| Channel::Column("carriage_position_m", 1.0, x);
    let (half, reach) = (0.06, 0.06 + p.play_m);
    let mut frames = vec![frame("mass", "interface_position_m", 0.0, 0.0)];
    let mut shapes = vec![Shape::Polygon(rectangle("mass", [0.0, 0.0], [2.0 * half, 2.0 * half]), Fill::Scheme)];
    for (name, side) in [("left", -1.0), ("right", 1.0)] {
        frames.push(frame(name, base(side * (reach + 0.08)), 0.0, 0.0));
        let plate = rectangle(name, [-side * 0.07, 0.0], [0.02, 0.1]);
        let block = rectangle(name, [side * 0.02, 0.0], [0.04, 0.16]);
        shapes.push(Shape::Spring(([-side * 0.07, 0.0], Some(name)), ([0.0, 0.0], Some(name)), 0.03));
        shapes.extend([Shape::Polygon(plate, Fill::Metal), Shape::Polygon(block, Fill::Ground)]);
    }
    let about = "A simulated mass flies to and fro between two contacts that are hardware.";
    let view = reach + 0.2 + p.contact.base_amplitude_m;
    let drawing = Drawing::of(["Contact in hardware", about], [[-view, view], [-0.14, 0.14]], frames, shapes);
    Drawing { schemes: ["first-order-hold", "monolithic"], ..drawing }
}
