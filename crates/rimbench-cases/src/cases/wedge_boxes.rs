//! The wedge boxes: a hydraulic cylinder pushes a box on wedges, with discs on ledges beside it. `docs/cases/wedge-box.md` shows the first,
//! the example of the source paper; the others differ from it in how many wedges and discs there are, where it starts, and what the spool does.
//!
//! Geometry and masses are *ours*, the hydraulic constants those of Naya et al. 2011.

use super::prelude::*;

const WEDGE_BOX: &str = "source: ours
    box_mass_kg | kg | 200.0 | positive | mass of the box
    box_width_m | m | 1.0 | positive | width of the box (its inertia is that of a rectangle)
    box_height_m | m | 0.6 | positive | height of the box
    disc_mass_kg | kg | 50.0 | positive | mass of the disc
    disc_radius_m | m | 0.2 | positive | radius of the disc
    disc_pin_x_m | m | -0.8 | finite | joint of the disc in the box frame, x
    disc_pin_y_m | m | -0.19 | finite | joint of the disc in the box frame, y
    wedge_tip_x_m | m | 0.4 | positive | right wedge tip in the box frame, x (the left one is mirrored)
    wedge_tip_y_m | m | -0.4 | finite | wedge tips in the box frame, y
    ledge_height_m | m | 0.06 | not negative | height of the ledge above the floor
    ledge_lead_m | m | 0.1 | not negative | distance of the ledge's corner ahead of the disc's centre at the start
    ramp_slope | - | 0.15 | not negative | fall over run of the ramp
    attachment_x_m | m | -0.5 | finite | actuator's end on the box, box frame, x
    attachment_y_m | m | 0.3 | finite | actuator's end on the box, box frame, y
    ground_pin_x_m | m | -3.0 | finite | actuator's fixed end, x; its height is the attachment's at the start
";
const OUR_CYLINDER: &str = "
    cylinder_length_m = 2.0 | ours
    viscous_friction_n_s_m = 1e4 | ours
    valve_area_m2 = 5e-5 | ours
    spool_start = 0.5 | ours
    spool_final = 0.2 | ours
    spool_ramp_start_s = 0.1 | ours
    spool_ramp_end_s = 0.2 | ours
    start_pressure_pa = 3.85e6 | ours
";
const GRAVITY: &str = "gravity_m_s2 | m/s² | 9.81 | not negative | gravity | standard";
const PLASTIC: &str = "restitution = 0.0 | plastic, as in the paper";

/// The box of the paper, which starts tilted on its right wedge, the disc on the ledge, with what is changed of its parameters.
fn of_the_paper(
    name: &'static str,
    about: &'static str,
    changed: &[&'static str],
    duration: f64,
    build: fn(&Parameters, &SolverEntry) -> Result<CoupledSystem>,
) -> Case {
    let tables = [
        WEDGE_BOX,
        CYLINDER,
        OUR_CYLINDER,
        FLUID,
        GRAVITY,
        STABILISATION,
        RESTITUTION,
        PLASTIC,
        COMPLIANT,
        POSSIBLE_FRICTION,
    ];
    Case {
        parameters: table(&[&tables, changed].concat()),
        trace_columns: hydraulics::trace_columns(
            "box_x_m box_y_m box_angle_rad",
            "gap_right_wedge_m gap_left_wedge_m gap_disc_ledge_m gap_disc_floor_m closed_contacts rank_h_uu",
        ),
        drawing_columns: words(
            "disc_ledge_normal_rad contact_force_right_wedge_n contact_force_left_wedge_n contact_force_disc_ledge_n \
             contact_force_disc_floor_n",
        ),
        interface_columns: hydraulics::interface(),
        reference: reference(),
        ..Case::new(name, about, times(duration, 5e-3, 5e-5, [2.5e-5, 5e-5]), build)
    }
}

pub(super) fn wedge_box() -> Case {
    let about = "Box on two wedges with a disc on a ledge, pushed by a hydraulic cylinder (the source paper's example)";
    of_the_paper("wedge-box", about, &[], 2.5, |parameters, solver| {
        let model = WedgeBox::new(wedge_box_geometry(parameters))?;
        let (spool, pressures) = (hydraulics::ramp(parameters)?, [parameters.number("start_pressure_pa"); 2]);
        pushed(model, pressures, spool, parameters, solver)
    })
}

/// The box of the paper with a cylinder whose stroke is not looked at.
fn pushed(
    model: WedgeBox,
    pressures: [f64; 2],
    spool: Spool,
    parameters: &Parameters,
    solver: &SolverEntry,
) -> Result<CoupledSystem> {
    let cylinder = hydraulics::of_any_stroke(parameters, model.start_length(), pressures, spool);
    coupled(model, cylinder, parameters, solver)
}

/// Returns the geometry of the wedge box as the parameters say, which must be those of the case `wedge-box`.
pub fn wedge_box_geometry(parameters: &Parameters) -> WedgeBoxGeometry {
    geometry(parameters, parameters.number("ledge_lead_m"))
}

/// The geometry as the parameters say, with the corner of the ledge so far ahead of the disc (m).
fn geometry(parameters: &Parameters, ledge_lead: f64) -> WedgeBoxGeometry {
    let get = |name: &str| parameters.number(name);
    WedgeBoxGeometry {
        box_mass: get("box_mass_kg"),
        box_size: ["box_width_m", "box_height_m"].map(get),
        wedge_tip: ["wedge_tip_x_m", "wedge_tip_y_m"].map(get),
        disc_mass: get("disc_mass_kg"),
        disc_radius: get("disc_radius_m"),
        disc_pin: ["disc_pin_x_m", "disc_pin_y_m"].map(get),
        ledge_height: get("ledge_height_m"),
        ledge_lead,
        ramp_slope: get("ramp_slope"),
        attachment: ["attachment_x_m", "attachment_y_m"].map(get),
        ground_pin_x: get("ground_pin_x_m"),
        gravity: get("gravity_m_s2"),
    }
}

/// With Coulomb friction, pushed and pulled by a spool that swings about its middle, `κ = κ₀ − A sin(2π f (t − t₀))`. Parameters chosen
/// because it sticks.
pub(super) fn with_friction() -> Case {
    const CHANGED: &str = "source: ours
        - spool_start spool_final spool_ramp_start_s spool_ramp_end_s friction tangential_restitution
        spool_centre | - | 0.5 | positive | spool command κ₀ at first, and in the middle of its swing
        spool_amplitude | - | 0.3 | fraction | amplitude A of the spool's swing
        spool_frequency_hz | Hz | 1.5 | positive | frequency f of the spool's swing
        spool_swings | - | 4.0 | whole 1..100 | number of whole swings, after which the spool rests in the middle
        spool_swing_start_s | s | 0.1 | not negative | when the spool starts to swing, towards extension
    ";
    let about = "Wedge box with friction at its contacts, pushed and pulled by a swinging spool until it sticks";
    let mut case = of_the_paper("wedge-box-friction", about, &[CHANGED, WITH_FRICTION], 2.5, |parameters, solver| {
        let get = |name: &str| parameters.number(name);
        let model = WedgeBox::new(wedge_box_geometry(parameters))?;
        let (centre, amplitude) = (get("spool_centre"), get("spool_amplitude"));
        if centre - amplitude < 0.0 || centre + amplitude > 1.0 {
            let expected = format!("at most {}: the spool must stay within [0, 1]", centre.min(1.0 - centre));
            return Err(Error::invalid("spool_amplitude", amplitude, expected));
        }
        let swing = [get("spool_swing_start_s"), centre, amplitude, get("spool_frequency_hz")];
        let spool = swinging(swing, parameters.whole("spool_swings"));
        pushed(model, [get("start_pressure_pa"); 2], spool, parameters, solver)
    });
    case.trace_columns.extend(words(
        "contact_state_right_wedge contact_state_left_wedge contact_state_disc_ledge contact_state_disc_floor \
         sticking_contacts",
    ));
    case
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

/// Held against the ramp on three contacts by a cylinder that pulls at rest, until the spool is reversed, its force passes through zero and
/// the disc leaves the ramp.
pub(super) fn reversal() -> Case {
    const CHANGED: &str = "source: ours
        - ledge_lead_m spool_start spool_ramp_start_s spool_ramp_end_s start_pressure_pa
        holding_pull_n | N | 90.0 | positive | force with which the cylinder pulls at first
        reversal_start_s | s | 0.3 | not negative | start of the spool's ramp to its final command
        reversal_end_s | s | 0.4 | not negative | end of the spool's ramp
    ";
    let about = "Wedge box held against its ramp on three contacts, until the spool is reversed and one opens";
    of_the_paper("wedge-box-reversal", about, &[CHANGED], 1.0, |parameters, solver| {
        let get = |name: &str| parameters.number(name);
        let model = WedgeBox::against_ramp(geometry(parameters, 0.0))?;
        let (pressures, hold) = hydraulics::equilibrium(parameters, -get("holding_pull_n"))?;
        let spool = hydraulics::spool(&[
            ("reversal_start_s", get("reversal_start_s"), hold),
            ("reversal_end_s", get("reversal_end_s"), get("spool_final")),
        ])?;
        pushed(model, pressures, spool, parameters, solver)
    })
}

/// A box on the supports and discs that its parameters give, made by [`SupportedBox`].
fn supported(
    name: &'static str,
    about: &'static str,
    own: &'static str,
    duration: f64,
    geometry: fn(&Parameters) -> Result<SupportedBoxGeometry>,
) -> Case {
    let tables = [own, GRAVITY, CYLINDER, FLUID, STABILISATION, RESTITUTION, PLASTIC, COMPLIANT];
    Case {
        parameters: table(&tables),
        interface_columns: hydraulics::interface(),
        reference: reference(),
        ..Case::new(name, about, times(duration, 5e-3, 5e-5, [1e-4, 1e-4]), move |parameters, solver| {
            let get = |name: &str| parameters.number(name);
            let [mass, width, height] = ["box_mass_kg", "box_width_m", "box_height_m"].map(get);
            let model = SupportedBox::new(SupportedBoxGeometry {
                box_mass: mass,
                box_inertia: mass * (width * width + height * height) / 12.0,
                start_angle: 0.0,
                attachment: ["attachment_x_m", "attachment_y_m"].map(get),
                ground_pin_x: get("ground_pin_x_m"),
                gravity: get("gravity_m_s2"),
                ..geometry(parameters)?
            })?;
            let cylinder = hydraulics::ramped_cylinder(parameters, model.start_length())?;
            coupled(model, cylinder, parameters, solver)
        })
    }
}

/// A disc with its joint at this x of the box, and the parameters of its ledge.
fn disc(parameters: &Parameters, pin_x: f64, [height, lead]: [&str; 2]) -> LedgeDisc {
    let get = |name: &str| parameters.number(name);
    LedgeDisc {
        mass: get("disc_mass_kg"),
        radius: get("disc_radius_m"),
        pin: [pin_x, get("disc_pin_y_m")],
        ledge_height: get(height),
        ledge_lead: get(lead),
        ramp_slope: get("ramp_slope"),
    }
}

/// A disc on either side, each on a ledge of its own: two descents, two touch-downs.
pub(super) fn two_ledges() -> Case {
    const OWN: &str = "source: as in the wedge box
        box_mass_kg | kg | 200.0 | positive | mass of the box
        box_width_m | m | 1.0 | positive | width of the box (its inertia is that of a rectangle)
        box_height_m | m | 0.6 | positive | height of the box
        wedge_tip_x_m | m | 0.4 | positive | right wedge tip in the box frame, x (the left one is mirrored)
        wedge_tip_y_m | m | -0.4 | finite | wedge tips in the box frame, y
        disc_mass_kg | kg | 50.0 | positive | mass of each disc
        disc_radius_m | m | 0.2 | positive | radius of each disc
        disc_pin_x_m | m | 0.8 | positive | joint of the right disc in the box frame, x (the left one is mirrored) | ours
        disc_pin_y_m | m | -0.19 | finite | joints of the discs in the box frame, y
        left_ledge_height_m | m | 0.06 | not negative | height of the left disc's ledge above the floor
        right_ledge_height_m | m | 0.06 | not negative | height of the right disc's ledge above the floor | ours
        left_ledge_lead_m | m | 0.1 | not negative | distance of the left ledge's corner ahead of its disc
        right_ledge_lead_m | m | 0.2 | not negative | distance of the right ledge's corner ahead of its disc | ours
        ramp_slope | - | 0.15 | not negative | fall over run of both ramps
        attachment_x_m | m | -0.5 | finite | actuator's end on the box, box frame, x
        attachment_y_m | m | 0.3 | finite | actuator's end on the box, box frame, y
        ground_pin_x_m | m | -3.0 | finite | actuator's fixed end, x; its height is the attachment's
    ";
    let about = "Wedge box with a disc on a ledge at either side (two descents, repeated over-constraint)";
    let geometry = |parameters: &Parameters| {
        let get = |name: &str| parameters.number(name);
        let [x, y, pin_x, radius] = ["wedge_tip_x_m", "wedge_tip_y_m", "disc_pin_x_m", "disc_radius_m"].map(get);
        if pin_x < radius {
            let expected = format!("at least the radius {radius} m, or the discs would overlap");
            return Err(Error::invalid("disc_pin_x_m", pin_x, expected));
        }
        Ok(SupportedBoxGeometry {
            supports: vec![[x, y], [-x, y]],
            discs: vec![
                disc(parameters, -pin_x, ["left_ledge_height_m", "left_ledge_lead_m"]),
                disc(parameters, pin_x, ["right_ledge_height_m", "right_ledge_lead_m"]),
            ],
            ..SupportedBoxGeometry::default()
        })
    };
    Case {
        trace_columns: hydraulics::trace_columns(
            "box_x_m box_y_m box_angle_rad",
            "gap_right_support_m gap_left_support_m gap_left_disc_ledge_m gap_left_disc_floor_m gap_right_disc_ledge_m \
             gap_right_disc_floor_m closed_contacts rank_h_uu",
        ),
        drawing_columns: words("contact_force_right_support_n contact_force_left_support_n"),
        ..supported("wedge-box-two-ledges", about, OWN, 3.0, geometry)
    }
}

/// On 2 to 64 wedges in one plane or off it, on a flat or a wavy floor: redundant contacts by the dozen.
pub(super) fn n_wedge_box() -> Case {
    const OWN: &str = "source: as in the wedge box
        supports | - | 8.0 | whole 2..64 | number n of wedges | ours
        height_spread_m | m | 0.0 | not negative | largest distance of a wedge tip above that of the rightmost | ours
        washboard_height_m | m | 0.0 | not negative | height of the waves of the wedges' floor | ours
        washboard_length_m | m | 0.15 | positive | length of the waves | ours
        washboard_lead_m | m | 0.05 | not negative | distance of the first wave ahead of the right wedge | ours
        box_mass_kg | kg | 200.0 | positive | mass of the box
        box_width_m | m | 1.0 | positive | width of the box (its inertia is that of a rectangle)
        box_height_m | m | 0.6 | positive | height of the box
        wedge_tip_x_m | m | 0.4 | positive | rightmost wedge tip in the box frame, x (the leftmost is mirrored)
        wedge_tip_y_m | m | -0.4 | finite | rightmost wedge tip in the box frame, y
        disc_mass_kg | kg | 50.0 | positive | mass of the disc
        disc_radius_m | m | 0.2 | positive | radius of the disc
        disc_pin_x_m | m | -0.8 | finite | joint of the disc in the box frame, x
        disc_pin_y_m | m | -0.19 | finite | joint of the disc in the box frame, y
        ledge_height_m | m | 0.06 | not negative | height of the ledge above the floor
        ledge_lead_m | m | 0.1 | not negative | distance of the ledge's corner ahead of the disc's centre
        ramp_slope | - | 0.15 | not negative | fall over run of the ramp
        attachment_x_m | m | -0.5 | finite | actuator's end on the box, box frame, x
        attachment_y_m | m | 0.3 | finite | actuator's end on the box, box frame, y
        ground_pin_x_m | m | -3.0 | finite | actuator's fixed end, x; its height is the attachment's
    ";
    let about = "Wedge box on n coplanar or uneven wedges, on a flat or a wavy floor (redundant contacts)";
    let geometry = |parameters: &Parameters| {
        let get = |name: &str| parameters.number(name);
        Ok(SupportedBoxGeometry {
            supports: tips(parameters),
            discs: vec![disc(parameters, get("disc_pin_x_m"), ["ledge_height_m", "ledge_lead_m"])],
            washboard: ["washboard_height_m", "washboard_length_m"].map(get),
            washboard_lead: get("washboard_lead_m"),
            ..SupportedBoxGeometry::default()
        })
    };
    Case {
        trace_columns: hydraulics::trace_columns(
            "box_x_m box_y_m box_angle_rad",
            "gap_right_support_m gap_left_support_m gap_disc_ledge_m gap_disc_floor_m gap_supports_least_m closed_contacts \
             rank_h_uu",
        ),
        drawing_columns: words("contact_force_sum_n"),
        ..supported("n-wedge-box", about, OWN, 2.5, geometry)
    }
}

/// Tips of the wedges: the rightmost, the leftmost, then those between from right to left.
fn tips(parameters: &Parameters) -> Vec<[f64; 2]> {
    let last = parameters.whole("supports") as usize - 1;
    let [x, y, spread] = ["wedge_tip_x_m", "wedge_tip_y_m", "height_spread_m"].map(|name| parameters.number(name));
    // Multiples of the golden ratio fill an interval evenly whatever their number.
    let tip = |k: usize| [x - 2.0 * x * k as f64 / last as f64, y + spread * (k as f64 * GOLDEN).fract()];
    [0, last].into_iter().chain(1..last).map(tip).collect()
}

const GOLDEN: f64 = 0.618_033_988_749_894_9;
