//! `elastic-bar`: a bar of N lumped elements falls on a rigid floor and leaves again after a wave has run up and down. The mechanics' own step is
//! stable below the time in which a wave crosses an element, L/(N c). Shown in `docs/cases/elastic-bar.md`; numbers of the impacting bar of the
//! literature (Doyen, Ern, Piperno 2011), the actuator is *ours*.

use super::prelude::*;

const BAR: &str = "source: impacting-bar benchmark
    elements | - | 20.0 | whole 1..500 | number of elements N | ours
    length_m | m | 1.0 | positive | length L
    section_m2 | m² | 3.14e-4 | positive | cross-section S
    youngs_modulus_pa | Pa | 210e9 | positive | Young's modulus E
    density_kg_m3 | kg/m³ | 7800.0 | positive | density ρ
    start_gap_m | m | 5e-5 | not negative | gap between bar and floor at the start
    start_velocity_m_s | m/s | -0.1 | finite | velocity of the bar at the start, upwards
";
const CHANGED: &str = "
    spring_stiffness_n_m = 1e6
    carriage_mass_kg = 0.5
    base_stiffness_n_m = 1e5
    base_position_m = 1.00005
    carriage_position_m = 1.00005
    carriage_velocity_m_s = -0.1
    restitution = 0.0 | plastic node
";

pub(super) fn entry() -> Case {
    Case {
        parameters: table(&[BAR, CARRIAGE, RESTITUTION, STABILISATION, CHANGED]),
        trace_columns: carriage::trace_columns(
            "carriage_position_m effective_mass_kg bottom_x_m bottom_velocity_m_s gap_floor_m contact_force_floor_n \
             closed_contacts",
        ),
        drawing_columns: words("carriage_velocity_m_s"),
        interface_columns: carriage::interface(),
        reference: reference(),
        ..Case::new(
            "elastic-bar",
            "Elastic bar of N elements that falls on a rigid floor under a carriage on springs (wave theory)",
            times(1.2e-3, 5e-6, 5e-7, [5e-7, 1e-6]),
            build,
        )
    }
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let count = parameters.whole("elements");
    let n = count as usize;
    let element = get("length_m") / f64::from(count);
    let element_mass = get("density_kg_m3") * get("section_m2") * element;
    let node = |index: usize| LineMass {
        mass: if index == 0 || index == n { 0.5 * element_mass } else { element_mass },
        start: [get("start_gap_m") + index as f64 * element, get("start_velocity_m_s")],
        ..LineMass::default()
    };
    let spring = |index: usize| LineSpring {
        between: [index, index + 1],
        stiffness: get("youngs_modulus_pa") * get("section_m2") / element,
        length: element,
    };
    let model = LineMasses::new(LineDescription {
        masses: (0..=n).map(node).collect(),
        springs: (0..n).map(spring).collect(),
        joints: Vec::new(),
        contacts: vec![LineContact { below: None, above: Some(0), distance: 0.0 }],
        driven: n,
        state_names: words("bottom_x_m bottom_velocity_m_s"),
        gap_names: words("gap_floor_m"),
        contact_force_names: words("contact_force_floor_n"),
    })?;
    coupled(model, carriage::actuator(parameters)?, parameters, solver)
}
