//! `elastic-bar`: a bar of N lumped elements falls on a rigid floor and leaves again after a wave has run up and down.
//! The mechanics' own step is stable below the time in which a wave crosses an element, L/(N c). Shown in
//! `docs/cases/elastic-bar.md`; numbers of the impacting bar of the literature (Doyen, Ern, Piperno 2011), the actuator
//! is *ours*.

use super::prelude::*;

parameters! {
    /// A bar and what it hangs on.
    struct Bar from "impacting-bar benchmark" {
        elements: u32 = 20, 1..=500, "number of elements N".from("ours");
        length_m: f64 = 1.0, Positive, "length L";
        section_m2: f64 = 3.14e-4, Positive, "cross-section S";
        youngs_modulus_pa: f64 = 210e9, Positive, "Young's modulus E";
        density_kg_m3: f64 = 7800.0, Positive, "density ρ";
        start_gap_m: f64 = 5e-5, NotNegative, "gap between bar and floor at the start".gap();
        start_velocity_m_s: f64 = -0.1, Finite, "velocity of the bar at the start, upwards";
        carriage: Carriage with |set| set
            .default("spring_stiffness_n_m", 1e6).default("carriage_mass_kg", 0.5)
            .default("base_stiffness_n_m", 1e5).default("base_position_m", 1.00005)
            .default("carriage_position_m", 1.00005).default("carriage_velocity_m_s", -0.1);
        contacts: Contacts with |set| set
            .only(&["restitution", "stabilisation"]).default("restitution", 0.0)
            .source("restitution", "plastic node");
    }
}

/// By how much its drawing enlarges motion.
const ENLARGED: f64 = 1000.0;

pub(super) fn entry() -> Case {
    Case {
        trace_columns: carriage::trace_columns(
            "carriage_position_m effective_mass_kg bottom_x_m bottom_velocity_m_s gap_floor_m contact_force_floor_n \
             closed_contacts",
        ),
        drawing_columns: words("carriage_velocity_m_s"),
        interface_columns: carriage::interface(),
        reference: reference(),
        drawing: drawn(|p: &Bar| {
            let (mut frames, mut shapes) =
                carriage::springs([0.0, 0.0], [0.0, 1.0], 0.25, Some(p.carriage.base_position_m));
            // Both ends of the bar move by micrometres, about where the bar is relaxed on the floor.
            for frame in &mut frames {
                if let Channel::Column(column, _, plus) = frame.pose[1] {
                    frame.pose[1] = Channel::Column(column, ENLARGED, plus + (1.0 - ENLARGED) * p.length_m);
                }
            }
            frames.push(frame("bottom", 0.0, Channel::Column("bottom_x_m", ENLARGED, 0.0), 0.0));
            let ends = [("bottom", -0.06), ("bottom", 0.06), ("body", 0.06), ("body", -0.06)];
            shapes.push(ground(&[[-5.0, 0.0], [5.0, 0.0]]));
            shapes.push(Shape::Polygon(ends.map(|(frame, x)| ([x, 0.0], Some(frame))).to_vec(), Fill::Scheme));
            let about = "A bar falls on the floor and leaves with its wave; motion is drawn 1000 times larger.";
            let drawing = Drawing::of(["Elastic bar", about], [[-0.95, 0.95], [-0.12, 1.65]], frames, shapes);
            Some(drawing.with(LIMITED_BY_ITS_STEP))
        }),
        ..Case::new(
            "elastic-bar",
            "Elastic bar of N elements that falls on a rigid floor under a carriage on springs (wave theory)",
            times(1.2e-3, 5e-6, 5e-7, [5e-7, 1e-6]),
            build,
        )
    }
}

fn build(p: &Bar, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let n = p.elements as usize;
    let element = p.length_m / f64::from(p.elements);
    let element_mass = p.density_kg_m3 * p.section_m2 * element;
    let node = |index: usize| LineMass {
        mass: if index == 0 || index == n { 0.5 * element_mass } else { element_mass },
        start: [p.start_gap_m + index as f64 * element, p.start_velocity_m_s],
        ..LineMass::default()
    };
    let spring = |index: usize| LineSpring {
        between: [index, index + 1],
        stiffness: p.youngs_modulus_pa * p.section_m2 / element,
        length: element,
    };
    let model = LineMasses::new(LineDescription {
        masses: (0..=n).map(node).collect(),
        springs: (0..n).map(spring).collect(),
        contacts: vec![LineContact { below: None, above: Some(0), distance: 0.0 }],
        driven: n,
        state_names: words("bottom_x_m bottom_velocity_m_s"),
        contact_names: words("floor"),
    })?;
    assembly.couple(model, SpringActuator::new(p.carriage)?, &p.contacts)
}
