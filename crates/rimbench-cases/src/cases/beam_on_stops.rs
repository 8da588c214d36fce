//! `beam-on-stops`: a flexible beam in N modes that a shaken spring presses against two stops. The mechanics' own step is stable below 2/ω_N.
//! Shown in `docs/cases/beam-on-stops.md`; modes from Blevins, numbers *ours*.

use super::prelude::*;

const BEAM: &str = "source: ours
    beam_support | - | clamped, pinned | choice | clamped at one end, or pinned at both
    modes | - | 4.0 | whole 1..20 | number of modes N
    length_m | m | 2.0 | positive | length L
    width_m | m | 0.04 | positive | width of the section
    thickness_m | m | 0.008 | positive | thickness of the section
    youngs_modulus_pa | Pa | 210e9 | positive | Young's modulus E | steel
    density_kg_m3 | kg/m³ | 7800.0 | positive | density ρ | steel
    damping_ratio | - | 0.01 | not negative | damping ratio ζ of all modes
    actuator_position_m | m | 1.2 | not negative | where the actuator holds the beam, from the left end
    stop_1_position_m | m | 2.0 | not negative | where stop 1 is, from the left end
    stop_1_clearance_m | m | 0.05 | not negative | distance of stop 1 below the straight beam
    stop_2_position_m | m | 0.8 | not negative | where stop 2 is, from the left end
    stop_2_clearance_m | m | 0.03 | not negative | distance of stop 2 below the straight beam
";
const CHANGED: &str = "
    spring_stiffness_n_m = 2000.0
    spring_damping_n_s_m = 2.0
    carriage_mass_kg = 0.5
    base_stiffness_n_m = 4000.0
    base_damping_n_s_m = 10.0
    base_position_m = -0.05
    base_amplitude_m = 0.05
    base_frequency_hz = 1.0
    base_phase_rad = 1.5707963267948966
";

pub(super) fn entry() -> Case {
    Case {
        parameters: table(&[BEAM, CARRIAGE, CHANGED, STABILISATION, RESTITUTION]),
        trace_columns: carriage::trace_columns(
            "carriage_position_m end_deflection_m effective_mass_kg gap_stop_1_m gap_stop_2_m closed_contacts rank_h_uu",
        ),
        drawing_columns: words("carriage_velocity_m_s contact_force_stop_1_n contact_force_stop_2_n"),
        interface_columns: carriage::interface(),
        reference: reference(),
        ..Case::new(
            "beam-on-stops",
            "Bending beam in N modes, pressed against two stops by a carriage on springs",
            times(3.0, 2e-3, 2e-4, [5e-5, 2e-4]),
            build,
        )
    }
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let modes = parameters.whole("modes");
    let (width, thickness) = (get("width_m"), get("thickness_m"));
    let stop = |position: &str, clearance: &str| BeamStop { position: get(position), clearance: get(clearance) };
    let model = ModalBeam::new(BeamGeometry {
        support: match parameters.choice("beam_support") {
            "pinned" => BeamSupport::Pinned,
            _ => BeamSupport::Clamped,
        },
        length: get("length_m"),
        bending_stiffness: get("youngs_modulus_pa") * width * thickness.powi(3) / 12.0,
        mass_per_length: get("density_kg_m3") * width * thickness,
        damping_ratio: get("damping_ratio"),
        modes: modes as usize,
        stops: [stop("stop_1_position_m", "stop_1_clearance_m"), stop("stop_2_position_m", "stop_2_clearance_m")],
        actuator_position: get("actuator_position_m"),
    })?;
    coupled(model, carriage::actuator(parameters)?, parameters, solver)
}
