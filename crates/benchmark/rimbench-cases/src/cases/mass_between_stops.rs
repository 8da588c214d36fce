//! `mass-between-stops`: a cylinder pushes a mass to and fro between two stops, over a floor that may be rough: it is
//! caught, pressed and let go, and sticks where its velocity turns. Shown in `docs/cases/mass-against-stops.md`; numbers
//! *ours*, cylinder and fluid are those of the wedge box.

use super::prelude::*;
use rimbench_core::interface_model::Rows;
use rimbench_core::mechanics::{MechanicalModel, ModelNames, ModelSize};

parameters! {
    /// A mass, its stops and what moves it.
    struct Between from "ours" {
        mass_kg: f64 = 200.0, Positive, "mass m".study(100.0..400.0);
        clearance_m: f64 = 0.06, NotNegative, "distance d of either stop from the start".gap();
        friction_n: f64 = 0.0, NotNegative, "bound of the friction between mass and floor; 0: none".study(0.0..1500.0);
        actuator_length_m: f64 = 0.8, Positive, "length of the cylinder at the start";
        cylinder: Cylinder with |set| set.default("cylinder_length_m", 1.0).source("cylinder_length_m", "ours");
        start_pressure_pa: f64 = 3.85e6, Positive, "pressure in both chambers at the start".from("as in the wedge box");
        spool_amplitude: f64 = 0.3, NotNegative, "amplitude A of the spool about its middle, 0.5".study(0.1..0.4);
        spool_frequency_hz: f64 = 1.3, Positive, "frequency f of the spool";
        spool_ramp_s: f64 = 0.1, Positive, "time in which its amplitude grows from 0";
        oil: Oil;
        gravity_m_s2: f64 = 9.81, Positive, "gravity".from("standard");
        contacts: Contacts with |set| set
            .only(&["stabilisation", "restitution"]).about("restitution", "restitution e of the stops")
            .source("restitution", "ours");
    }
}

pub(super) fn entry() -> Case {
    Case {
        trace_columns: hydraulics::trace_columns(
            "",
            "gap_lower_stop_m gap_upper_stop_m contact_force_lower_stop_n contact_force_upper_stop_n closed_contacts",
        ),
        interface_columns: hydraulics::interface(),
        constant_mechanics: true,
        reference: Arc::new(|parameters| {
            let rough = Between::read(parameters).friction_n > 0.0;
            Ok(if rough { ReferenceMethod::Refined } else { ReferenceMethod::EventDriven })
        }),
        drawing: drawn(|p: &Between| Some(drawing(p))),
        ..Case::new(
            "mass-between-stops",
            "Mass between two stops, driven by a hydraulic cylinder over a floor that may be rough",
            times(2.0, 2e-3, 5e-5, [5e-5, 2e-4]),
            build,
        )
    }
}

fn build(p: &Between, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    if p.spool_amplitude > 0.5 {
        let expected = "at most 0.5: the spool must stay within [0, 1]";
        return Err(Error::invalid("spool_amplitude", p.spool_amplitude, expected));
    }
    let spool = Spool::sine(0.5, p.spool_frequency_hz, vec![(0.0, 0.0), (p.spool_ramp_s, 2.0 * p.spool_amplitude)]);
    let cylinder = p.cylinder.starting_at(p.actuator_length_m, &p.oil, [p.start_pressure_pa; 2], spool)?;
    let friction = p.friction_n / (p.mass_kg * p.gravity_m_s2);
    assembly.couple(OnFloor(*p), cylinder, &Contacts { friction, ..p.contacts })
}

fn drawing(p: &Between) -> Drawing {
    let (half, length) = (0.08, p.actuator_length_m);
    let edge = p.clearance_m + half;
    let stop = |left: f64, [low, high]: [f64; 2]| wall([left, low], [left + 0.04, high]);
    Drawing {
        in_kilonewtons: true,
        ..Drawing::of(
            ["Mass between stops", "A cylinder pushes a mass to and fro between two stops."],
            [[-length - 0.15, edge + 0.1], [-0.06, 0.3]],
            vec![frame("mass", Channel::Column("actuator_length_m", 1.0, -length), 0.0, 0.0)],
            vec![
                ground(&[[-3.0, 0.0], [3.0, 0.0]]),
                // The rod goes through the stop on its side.
                stop(-edge - 0.04, [0.0, 0.06]),
                stop(-edge - 0.04, [0.14, 0.2]),
                stop(edge, [0.0, 0.2]),
                Shape::Polygon(rectangle("mass", [0.0, 0.1], [2.0 * half, 0.2]), Fill::Scheme),
                Shape::Cylinder {
                    from: ([-half - length, 0.1], None),
                    to: ([-half, 0.1], Some("mass")),
                    barrel: 0.6 * length,
                    width: 0.06,
                },
            ],
        )
    }
}

/// A mass that does not turn. Coordinates: its place x and the height y of its sole above the floor. The floor has
/// friction, whose bound is its coefficient times the weight; the stops have none.
///
/// ```text
/// g = [d + x, d − x, y]     A_t = [0, 0, ẋ]     s = s₀ + x
/// ```
#[derive(Debug, Clone, Copy)]
struct OnFloor(Between);

impl MechanicalModel for OnFloor {
    fn size(&self) -> ModelSize {
        ModelSize {
            velocities: 2,
            unilateral: 3,
            tangential: 3,
            interface: 1,
            constant_mass: true,
            plastic: &[2],
            ..ModelSize::default()
        }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (vec![0.0; 2], vec![0.0; 2])
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        mass.fill(self.0.mass_kg);
    }

    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        force.copy_from_slice(&[0.0, -self.0.mass_kg * self.0.gravity_m_s2]);
    }

    fn unilateral(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian.copy_from_slice(&[1.0, 0.0, -1.0, 0.0, 0.0, 1.0]);
        rows.position.copy_from_slice(&[self.0.clearance_m + q[0], self.0.clearance_m - q[0], q[1]]);
    }

    fn tangential(&self, _q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian[4] = 1.0;
    }

    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian[0] = 1.0;
        rows.position[0] = self.0.actuator_length_m + q[0];
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        self.0.mass_kg * self.0.gravity_m_s2 * q[1]
    }

    fn names(&self) -> ModelNames {
        ModelNames::of(&[], &["lower_stop", "upper_stop", "floor"])
    }
}
