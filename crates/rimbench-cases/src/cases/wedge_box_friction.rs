//! `wedge-box-friction`: the wedge box with Coulomb friction at all its contacts, pushed and pulled until it sticks.
//!
//! ```text
//!                      ┌───────────────┐ box
//!   ╠═══════[▒▒]───────┤● attachment   │            κ = κ₀ − A sin(2π f (t − t₀))
//!   pin    cylinder    │       +       │
//!              ╭───╮   │    centre     │
//!              │ o─┼───┤               │
//!   ledge ─────╰───╯─● └──╲╱───────╲╱──┘
//!      μ               ╲  left     right wedge  μ
//!   ═════════════════════╲════════════════════════  floor y = 0
//! ```
//! **Manoeuvre.** The spool swings about its middle, so that the force of the cylinder changes sign again and again. The wedge on the floor sticks
//! until the force has grown beyond what friction holds, slides, and sticks again at each reversal. A sticking wedge and the disc on its ledge hold a
//! box that has one way left to go: the interface is locked, with no choice of a margin. A model that keeps contacts as they are for a whole macro
//! step pushes against a wall that gives way inside it, or lets through what should hold.
//!
//! On the ledge mass matrix and Jacobians of the interface are constant, so the reduced model is all but exact there; the case separates *when* it is
//! decided what sticks.
//!
//! **Direct feedthrough** of the actuator, through its viscous friction. **Reference**: monolithic, h, h/2, h/4, semi-implicit: the event-driven steps do
//! not locate where a contact starts to slide.
//!
//! Geometry, masses, cylinder and valve are those of the wedge box; what is new is *ours*. It was chosen because it sticks.

use super::case::{Case, CoupledSystem};
use super::contact_parameters;
use super::hydraulics;
use super::parameters::{Parameter, Parameters, Range, number as p};
use super::wedge_box;
use crate::models::{Spool, WedgeBox};
use rimbench_core::complementarity::SolverEntry;
use rimbench_core::error::{Error, Result};
use rimbench_core::name::names;

pub(super) fn entry() -> Case {
    let mut case = wedge_box::recorded(Case {
        parameters: parameters(),
        reference: contact_parameters::reference(),
        ..Case::new(
            "wedge-box-friction",
            "Wedge box with friction at its contacts, pushed and pulled by a swinging spool until it sticks",
            wedge_box::DEFAULTS,
            build,
        )
    });
    case.trace_columns.extend(names(&[
        "contact_state_right_wedge",
        "contact_state_left_wedge",
        "contact_state_disc_ledge",
        "contact_state_disc_floor",
        "sticking_contacts",
    ]));
    case
}

const OURS: &str = "ours";

/// What the manoeuvre of the wedge box needs, and this one does not; friction has another default.
const NOT_HERE: [&str; 6] =
    ["spool_start", "spool_final", "spool_ramp_start_s", "spool_ramp_end_s", "friction", "tangential_restitution"];

fn parameters() -> Vec<Parameter> {
    use Range::{Fraction, NotNegative, Positive, Whole};
    let own = [
        p("spool_centre", "-", 0.5, Positive, "spool command κ₀ at first, and in the middle of its swing", OURS),
        p("spool_amplitude", "-", 0.3, Fraction, "amplitude A of the spool's swing", OURS),
        p("spool_frequency_hz", "Hz", 1.5, Positive, "frequency f of the spool's swing", OURS),
        p(
            "spool_swings",
            "-",
            4.0,
            Whole(1, 100),
            "number of whole swings, after which the spool rests in the middle",
            OURS,
        ),
        p("spool_swing_start_s", "s", 0.1, NotNegative, "when the spool starts to swing, towards extension", OURS),
    ];
    let known = wedge_box::parameters().into_iter().filter(|known| !NOT_HERE.contains(&&*known.name));
    known.chain(own).chain(contact_parameters::friction(0.3)).collect()
}

fn build(parameters: &Parameters, solver: &SolverEntry) -> Result<CoupledSystem> {
    let get = |name: &str| parameters.number(name);
    let model = WedgeBox::new(wedge_box::wedge_box_geometry(parameters))?;
    let (centre, amplitude) = (get("spool_centre"), get("spool_amplitude"));
    if centre - amplitude < 0.0 || centre + amplitude > 1.0 {
        let least = centre.min(1.0 - centre);
        return Err(Error::invalid(
            "spool_amplitude",
            amplitude,
            format!("at most {least}: the spool must stay within [0, 1]"),
        ));
    }
    let spool = swinging(
        [get("spool_swing_start_s"), centre, amplitude, get("spool_frequency_hz")],
        parameters.whole("spool_swings"),
    );
    let pressures = [get("start_pressure_pa"); 2];
    let cylinder = hydraulics::of_any_stroke(parameters, model.start_length(), pressures, spool);
    contact_parameters::coupled(model, cylinder, parameters, solver)
}

/// The command from its start `t₀` (s) on for a number of whole swings, drawn in straight pieces: within 1.3e-6 of the amplitude.
fn swinging([start, centre, amplitude, frequency]: [f64; 4], swings: u32) -> Spool {
    const PIECES: u32 = 2000;
    let points = (0..=swings * PIECES).map(|piece| {
        let turns = f64::from(piece) / f64::from(PIECES);
        (start + turns / frequency, centre - amplitude * libm::sin(std::f64::consts::TAU * turns))
    });
    Spool::new(points.collect())
}
