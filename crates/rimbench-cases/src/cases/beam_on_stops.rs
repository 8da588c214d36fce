//! `beam-on-stops`: a flexible beam in N modes that a shaken spring presses against two stops. The mechanics' own step is stable below 2/ω_N.
//! Shown in `docs/cases/beam-on-stops.md`; modes from Blevins, numbers *ours*.

use super::prelude::*;
use std::f64::consts::PI;

choices! { for BeamSupport { Clamped = "clamped", Pinned = "pinned", } }
parameters! {
    /// A beam, its stops and what shakes it.
    struct Beam from "ours" {
        beam_support: BeamSupport [Clamped, Pinned], "clamped at one end, or pinned at both";
        modes: u32 = 4, 1..=20, "number of modes N";
        length_m: f64 = 2.0, Positive, "length L";
        width_m: f64 = 0.04, Positive, "width of the section";
        thickness_m: f64 = 0.008, Positive, "thickness of the section";
        youngs_modulus_pa: f64 = 210e9, Positive, "Young's modulus E" from "steel";
        density_kg_m3: f64 = 7800.0, Positive, "density ρ" from "steel";
        damping_ratio: f64 = 0.01, NotNegative, "damping ratio ζ of all modes";
        actuator_position_m: f64 = 1.2, NotNegative, "where the actuator holds the beam, from the left end";
        stop_1_position_m: f64 = 2.0, NotNegative, "where stop 1 is, from the left end";
        stop_1_clearance_m: f64 = 0.05, NotNegative, "distance of stop 1 below the straight beam";
        stop_2_position_m: f64 = 0.8, NotNegative, "where stop 2 is, from the left end";
        stop_2_clearance_m: f64 = 0.03, NotNegative, "distance of stop 2 below the straight beam";
        carriage: Carriage {
            spring_stiffness_n_m = 2000.0;
            spring_damping_n_s_m = 2.0;
            carriage_mass_kg = 0.5;
            base_stiffness_n_m = 4000.0;
            base_damping_n_s_m = 10.0;
            base_position_m = -0.05;
            base_amplitude_m = 0.05;
            base_frequency_hz = 1.0;
            base_phase_rad = 1.5707963267948966;
        };
        contacts: Contacts only { stabilisation; restitution };
    }
}

/// Frames of the drawn beam: one moves with the deflection at the actuator, and one in it with that at the end.
const BENT: [[&str; 2]; 8] =
    [["a", "A"], ["b", "B"], ["c", "C"], ["d", "D"], ["e", "E"], ["f", "F"], ["g", "G"], ["h", "H"]];

impl Beam {
    /// Shares of the deflections at the actuator and at the end in that at x: of the cubic that leaves the clamp straight and has both, or
    /// of the half sine between two pins.
    fn bent(&self, x: f64) -> [f64; 2] {
        let (a, l) = (self.actuator_position_m, self.length_m);
        match self.beam_support {
            BeamSupport::Pinned => [libm::sin(PI * x / l) / libm::sin(PI * a / l), 0.0],
            BeamSupport::Clamped if 0.0 < a && a < l => {
                [(x / a).powi(2) * (l - x) / (l - a), (x / l).powi(2) * (x - a) / (l - a)]
            }
            BeamSupport::Clamped => [0.0, (x / l).powi(2)],
        }
    }
}

pub(super) fn entry() -> Case {
    Case {
        trace_columns: carriage::trace_columns(
            "carriage_position_m end_deflection_m effective_mass_kg gap_stop_1_m gap_stop_2_m closed_contacts rank_h_uu",
        ),
        drawing_columns: words("carriage_velocity_m_s contact_force_stop_1_n contact_force_stop_2_n"),
        interface_columns: carriage::interface(),
        reference: reference(),
        drawing: drawn(|p: &Beam| {
            let (mut frames, mut shapes) = carriage::springs([p.actuator_position_m, 0.0], [0.0, 1.0], 0.25, Some(0.0));
            let stop = |x: f64, clearance: f64| wall([x - 0.02, -clearance - 0.2], [x + 0.02, -clearance]);
            // Through the deflections at the actuator and at the end.
            for (k, [held, bent]) in BENT.into_iter().enumerate() {
                let share = (k + 1) as f64 / BENT.len() as f64;
                let [actuator, end] = p.bent(share * p.length_m);
                let along = |column, gain| Channel::Column(column, gain, 0.0);
                frames.push(frame(held, share * p.length_m, along("interface_position_m", actuator), 0.0));
                let pose = [0.0.into(), along("end_deflection_m", end), 0.0.into()];
                frames.push(Frame { name: bent, parent: Some(held), pose });
            }
            let half = 0.5 * p.thickness_m;
            let side = |y: f64| BENT.map(|[_, bent]| ([0.0, y], Some(bent)));
            let upper = side(half).into_iter().rev().chain([([0.0, half], None), ([0.0, -half], None)]);
            let beam = side(-half).into_iter().chain(upper).collect();
            shapes.extend([
                wall([-0.08, -0.15], [0.0, 0.15]),
                stop(p.stop_1_position_m, p.stop_1_clearance_m),
                stop(p.stop_2_position_m, p.stop_2_clearance_m),
                Shape::Polygon(beam, Fill::Scheme),
            ]);
            let title = ["Beam on stops", "A shaken spring bends a clamped beam onto two stops."];
            Some(Drawing::of(title, [[-0.15, p.length_m + 0.15], [-0.3, 0.6]], frames, shapes))
        }),
        ..Case::new(
            "beam-on-stops",
            "Bending beam in N modes, pressed against two stops by a carriage on springs",
            times(3.0, 2e-3, 2e-4, [5e-5, 2e-4]),
            build,
        )
    }
}

fn build(p: &Beam, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let (width, thickness) = (p.width_m, p.thickness_m);
    let stop = |position, clearance| BeamStop { position, clearance };
    let model = ModalBeam::new(BeamGeometry {
        support: p.beam_support,
        length: p.length_m,
        bending_stiffness: p.youngs_modulus_pa * width * thickness.powi(3) / 12.0,
        mass_per_length: p.density_kg_m3 * width * thickness,
        damping_ratio: p.damping_ratio,
        modes: p.modes as usize,
        stops: [stop(p.stop_1_position_m, p.stop_1_clearance_m), stop(p.stop_2_position_m, p.stop_2_clearance_m)],
        actuator_position: p.actuator_position_m,
    })?;
    assembly.couple(model, p.carriage.actuator()?, &p.contacts)
}
