//! `gripper`: two opposed cylinders close on a box. Two interface rows, six contacts of rank four, over-constrained when closed. Shown in
//! `docs/cases/gripper.md`; numbers *ours*, the fluid is that of Naya et al. 2011.

use super::prelude::*;

parameters! {
    /// A box, two jaws and their cylinders.
    struct Clamp from "ours" {
        jaw_mass_kg: f64 = 30.0, Positive, "mass of each jaw with its piston";
        box_mass_kg: f64 = 50.0, Positive, "mass of the box";
        box_width_m: f64 = 0.3, Positive, "width of the box";
        box_height_m: f64 = 0.4, Positive, "height of the box";
        lower_pad_m: f64 = 0.1, Finite, "height of the lower pads";
        upper_pad_m: f64 = 0.3, Finite, "height of the upper pads";
        left_clearance_m: f64 = 0.02, Finite, "distance of the left jaw from the box at the start";
        right_clearance_m: f64 = 0.05, Finite, "distance of the right jaw from the box at the start";
        actuator_length_m: f64 = 0.6, Positive, "length of both actuators at the start";
        cylinder: Cylinder {
            piston_area_m2 = 1e-3 from "ours";
            cylinder_length_m = 0.6 from "ours";
            viscous_friction_n_s_m = 5e3, "viscous friction c of a cylinder" from "ours";
            valve_area_m2 = 4e-6 from "ours";
        };
        start_pressure_pa: f64 = 3.85e6, Positive, "pressure in all chambers at the start";
        spool_close: f64 = 0.4, Fraction, "spool command while closing; below 0.5 extends";
        spool_open: f64 = 0.6, Fraction, "spool command while opening";
        close_start_s: f64 = 0.1, NotNegative, "start of closing";
        open_start_s: f64 = 1.5, NotNegative, "start of opening";
        spool_ramp_s: f64 = 0.02, Positive, "time in which the spools move";
        oil: Oil;
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity" from "standard";
        contacts: Contacts only { stabilisation; restitution = 0.0, "restitution e of pads and corners" from "ours" };
    }
}

pub(super) fn entry() -> Case {
    Case {
        trace_columns: words(
            "time_s left_jaw_x_m right_jaw_x_m box_x_m box_y_m box_angle_rad left_length_m right_length_m \
             left_velocity_m_s right_velocity_m_s left_force_n right_force_n force_to_mechanics_n \
             force_2_to_mechanics_n effective_mass_kg gap_left_lower_pad_m gap_left_upper_pad_m gap_right_lower_pad_m \
             gap_right_upper_pad_m gap_left_corner_m gap_right_corner_m closed_contacts rank_h_uu",
        ),
        drawing_columns: words(
            "left_pressure_1_pa left_pressure_2_pa right_pressure_1_pa right_pressure_2_pa \
             contact_force_left_lower_pad_n contact_force_left_upper_pad_n contact_force_right_lower_pad_n \
             contact_force_right_upper_pad_n contact_force_left_corner_n contact_force_right_corner_n",
        ),
        interface_columns: vec![
            InterfaceColumns::new("left_length_m", "left_velocity_m_s", "left_force_n"),
            InterfaceColumns::new("right_length_m", "right_velocity_m_s", "right_force_n"),
        ],
        constant_mechanics: true,
        reference: reference(),
        drawing: drawn(|p: &Clamp| Some(drawing(p))),
        ..Case::new(
            "gripper",
            "Two opposed cylinders squeeze a box (two interface rows, redundant contacts, over-constrained when closed)",
            times(2.0, 5e-3, 5e-5, [5e-5, 1e-4]),
            build,
        )
    }
}

const NAMES: [ActuatorNames; 2] = [
    ActuatorNames {
        position: "left_length_m",
        velocity: "left_velocity_m_s",
        force: "left_force_n",
        observables: &["left_pressure_1_pa", "left_pressure_2_pa", "left_spool"],
    },
    ActuatorNames {
        position: "right_length_m",
        velocity: "right_velocity_m_s",
        force: "right_force_n",
        observables: &["right_pressure_1_pa", "right_pressure_2_pa", "right_spool"],
    },
];

fn drawing(p: &Clamp) -> Drawing {
    let [width, height] = [p.box_width_m, p.box_height_m];
    let (lower, upper, reach) = (p.lower_pad_m, p.upper_pad_m, p.actuator_length_m);
    let middle = (lower + upper) / 2.0;
    // A jaw with its two pads, to the side that `out` points away from the box.
    let jaw = |name: &'static str, out: f64| {
        let outline = [
            [0.0, lower - 0.01],
            [0.0, lower + 0.01],
            [0.03 * out, lower + 0.03],
            [0.03 * out, upper - 0.03],
            [0.0, upper - 0.01],
            [0.0, upper + 0.01],
            [0.03 * out, upper + 0.03],
            [0.06 * out, upper + 0.03],
            [0.06 * out, lower - 0.03],
            [0.03 * out, lower - 0.03],
        ];
        Shape::Polygon(points(name, outline), Fill::Metal)
    };
    let cylinder = |name: &'static str, out: f64, start: f64| Shape::Cylinder {
        from: ([start + out * reach, middle], None),
        to: ([0.06 * out, middle], Some(name)),
        barrel: 0.75 * reach,
        width: 0.07,
    };
    let push = |column, name, pad, along: f64| Shape::Arrow {
        column,
        at: ([0.0, pad], Some(name)),
        along: [along, 0.0],
        scale: 6e-5,
    };
    Drawing {
        view: [[-0.75, 0.8], [-0.1, 0.6]],
        frames: vec![
            frame("left jaw", "left_jaw_x_m", 0.0, 0.0),
            frame("right jaw", "right_jaw_x_m", 0.0, 0.0),
            frame("box", "box_x_m", "box_y_m", "box_angle_rad"),
        ],
        shapes: vec![
            ground(&[[-3.0, 0.0], [3.0, 0.0]]),
            cylinder("left jaw", -1.0, -width / 2.0 - p.left_clearance_m),
            cylinder("right jaw", 1.0, width / 2.0 + p.right_clearance_m),
            jaw("left jaw", -1.0),
            jaw("right jaw", 1.0),
            Shape::Polygon(rectangle("box", [0.0, 0.0], [width, height]), Fill::Scheme),
            push("contact_force_left_lower_pad_n", "left jaw", lower, 1.0),
            push("contact_force_left_upper_pad_n", "left jaw", upper, 1.0),
            push("contact_force_right_lower_pad_n", "right jaw", lower, -1.0),
            push("contact_force_right_upper_pad_n", "right jaw", upper, -1.0),
        ],
        title: ["Gripper", "Two cylinders close two jaws on a box, squeeze it, and let it go."],
        force: "left cylinder's force",
        in_kilonewtons: true,
        schemes: ["rim-smooth", "rim-nonsmooth"],
        ..Drawing::default()
    }
}

fn build(p: &Clamp, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let length = p.actuator_length_m;
    let model = Gripper::new(GripperGeometry {
        jaw_mass: p.jaw_mass_kg,
        box_mass: p.box_mass_kg,
        box_size: [p.box_width_m, p.box_height_m],
        pad_heights: [p.lower_pad_m, p.upper_pad_m],
        clearances: [p.left_clearance_m, p.right_clearance_m],
        actuator_length: length,
        gravity: p.gravity_m_s2,
    })?;
    let ((closing, close), (opening, open)) = (named!(p.close_start_s), named!(p.open_start_s));
    let spool = hydraulics::spool(&[
        (closing, close, 0.5),
        (closing, close + p.spool_ramp_s, p.spool_close),
        (opening, open, p.spool_close),
        (opening, open + p.spool_ramp_s, p.spool_open),
    ])?;
    let pressures = [p.start_pressure_pa; 2];
    let unit = || p.cylinder.starting_at(length, &p.oil, pressures, spool.clone());
    assembly.couple(model, ActuatorGroup::new(vec![unit()?, unit()?], &NAMES), &p.contacts)
}
