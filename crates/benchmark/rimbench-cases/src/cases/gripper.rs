//! `gripper`: two opposed cylinders close on a box. Two interface rows, six contacts of rank four, over-constrained
//! when closed. Shown in `docs/cases/gripper.md`; numbers *ours*, the fluid is that of Naya et al. 2011.

use super::prelude::*;
use crate::models::rotation::rotation;
use nalgebra::{Rotation2, Vector2};
use rimbench_core::interface_model::Rows;
use rimbench_core::mechanics::{MechanicalModel, ModelNames, ModelSize};

parameters! {
    /// A box, two jaws and their cylinders.
    pub struct Clamp from "ours" {
        jaw_mass_kg: f64 = 30.0, Positive, "mass of each jaw with its piston";
        box_mass_kg: f64 = 50.0, Positive, "mass of the box";
        box_width_m: f64 = 0.3, Positive, "width of the box";
        box_height_m: f64 = 0.4, Positive, "height of the box";
        lower_pad_m: f64 = 0.1, Finite, "height of the lower pads";
        upper_pad_m: f64 = 0.3, Finite, "height of the upper pads";
        left_clearance_m: f64 = 0.02, Finite, "distance of the left jaw from the box at the start".gap();
        right_clearance_m: f64 = 0.05, Finite, "distance of the right jaw from the box at the start".gap();
        actuator_length_m: f64 = 0.6, Positive, "length of both actuators at the start";
        /// Both cylinders.
        cylinder: Cylinder with |set| set
            .default("piston_area_m2", 1e-3).source("piston_area_m2", "ours").default("cylinder_length_m", 0.6)
            .source("cylinder_length_m", "ours").default("viscous_friction_n_s_m", 5e3)
            .about("viscous_friction_n_s_m", "viscous friction c of a cylinder")
            .source("viscous_friction_n_s_m", "ours").default("valve_area_m2", 4e-6)
            .source("valve_area_m2", "ours");
        start_pressure_pa: f64 = 3.85e6, Positive, "pressure in all chambers at the start";
        spool_close: f64 = 0.4, Fraction, "spool command while closing; below 0.5 extends";
        spool_open: f64 = 0.6, Fraction, "spool command while opening";
        close_start_s: f64 = 0.1, NotNegative, "start of closing";
        open_start_s: f64 = 1.5, NotNegative, "start of opening";
        spool_ramp_s: f64 = 0.02, Positive, "time in which the spools move";
        /// Their fluid.
        oil: Oil;
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity".from("standard");
        /// The contact law.
        contacts: Contacts with |set| set
            .only(&["stabilisation", "restitution"]).default("restitution", 0.0)
            .about("restitution", "restitution e of pads and corners").source("restitution", "ours");
    }
}

pub(super) fn entry() -> Case {
    Case {
        trace_columns: of_contacts(
            &CONTACTS,
            "time_s left_jaw_x_m right_jaw_x_m box_x_m box_y_m box_angle_rad left_length_m right_length_m \
             left_velocity_m_s right_velocity_m_s left_force_n right_force_n force_to_mechanics_n \
             force_2_to_mechanics_n effective_mass_kg gap_*_m closed_contacts rank_h_uu",
        ),
        drawing_columns: of_contacts(
            &CONTACTS,
            "left_pressure_1_pa left_pressure_2_pa right_pressure_1_pa right_pressure_2_pa contact_force_*_n",
        ),
        interface_columns: InterfaceColumns::of(&NAMES),
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

const CONTACTS: [&str; 6] =
    ["left_lower_pad", "left_upper_pad", "right_lower_pad", "right_upper_pad", "left_corner", "right_corner"];

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
        ..Drawing::default()
    }
}

fn build(p: &Clamp, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let length = p.actuator_length_m;
    let ((closing, close), (opening, open)) = (named!(p.close_start_s), named!(p.open_start_s));
    let spool = hydraulics::spool(&[
        (closing, close, 0.5),
        (closing, close + p.spool_ramp_s, p.spool_close),
        (opening, open, p.spool_close),
        (opening, open + p.spool_ramp_s, p.spool_open),
    ])?;
    let pressures = [p.start_pressure_pa; 2];
    let unit = || p.cylinder.starting_at(length, &p.oil, pressures, spool.clone());
    assembly.couple(Gripper::new(*p)?, ActuatorGroup::new(vec![unit()?, unit()?], &NAMES), &p.contacts)
}

/// Jaws and box. Coordinates: x of the pads of left and right jaw, box `(x, y, φ)`.
///
#[doc = include_str!("gripper.md")]
///
/// ```text
/// A = [n_x (jaw), −n_x, −n_y, (p − c)·n_⊥]     Ȧv = 2φ̇ (ṗ − ċ)·n_⊥ − φ̇² (p − c)·n
/// ```
/// Four pad contacts and two corners on the floor hold a box with three freedoms between two jaws: six rows of rank
/// four, and the jaws can only move together.
/// # Source
/// Ours.
#[derive(Debug, Clone)]
pub struct Gripper {
    p: Clamp,
    mass: [f64; 5],
    /// x of the actuators' fixed ends.
    anchors: [f64; 2],
    rotation: Rotation2<f64>,
}

const VELOCITIES: usize = 5;
const BOX: usize = 2;

impl Gripper {
    /// Places the box at x = 0 between the jaws, its lower side at y = 0.
    ///
    /// # Errors
    /// [`Error::Incompatible`] if a jaw would start inside the box or a pad beside its faces.
    pub fn new(p: Clamp) -> Result<Self> {
        let [width, height] = [p.box_width_m, p.box_height_m];
        for (side, clearance) in [("left", p.left_clearance_m), ("right", p.right_clearance_m)] {
            if clearance < 0.0 {
                return Err(Error::Incompatible(format!(
                    "impossible geometry: the {side} jaw would start {clearance:.6} m from the box, inside it"
                )));
            }
        }
        if let Some(pad) = [p.lower_pad_m, p.upper_pad_m].iter().find(|pad| !(0.0..=height).contains(*pad)) {
            return Err(Error::Incompatible(format!(
                "impossible geometry: a pad at {pad} m is beside the box, which reaches from 0 to {height} m"
            )));
        }
        let inertia = p.box_mass_kg * (width * width + height * height) / 12.0;
        let (left, right) = Self::start_of_jaws(&p);
        Ok(Gripper {
            mass: [p.jaw_mass_kg, p.jaw_mass_kg, p.box_mass_kg, p.box_mass_kg, inertia],
            anchors: [left - p.actuator_length_m, right + p.actuator_length_m],
            rotation: Rotation2::identity(),
            p,
        })
    }

    /// Outward normal of the face that a pad presses.
    fn outward(&self, pad: usize) -> Vector2<f64> {
        self.rotation * Vector2::new(if pad < 2 { -1.0 } else { 1.0 }, 0.0)
    }

    fn start_of_jaws(p: &Clamp) -> (f64, f64) {
        let half = 0.5 * p.box_width_m;
        (-half - p.left_clearance_m, half + p.right_clearance_m)
    }
}

impl MechanicalModel for Gripper {
    fn size(&self) -> ModelSize {
        ModelSize { velocities: VELOCITIES, unilateral: 6, interface: 2, constant_mass: true, ..ModelSize::default() }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        let (left, right) = Self::start_of_jaws(&self.p);
        (vec![left, right, 0.0, 0.5 * self.p.box_height_m, 0.0], vec![0.0; VELOCITIES])
    }

    fn prepare(&mut self, q: &[f64], _v: &[f64]) {
        self.rotation = rotation(q[4]);
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        mass.copy_from_slice(&self.mass);
    }

    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        force.copy_from_slice(&[0.0, 0.0, 0.0, -self.p.box_mass_kg * self.p.gravity_m_s2, 0.0]);
    }

    fn unilateral(&self, q: &[f64], v: &[f64], rows: &mut Rows) {
        let [width, height] = [self.p.box_width_m, self.p.box_height_m];
        let pad_heights = [self.p.lower_pad_m, self.p.upper_pad_m];
        let spin = v[4];
        for row in 0..4 {
            let (jaw, pad) = (row / 2, row % 2);
            let normal = self.outward(row);
            let across = Vector2::new(-normal.y, normal.x);
            let arm = Vector2::new(q[jaw], pad_heights[pad]) - Vector2::new(q[2], q[3]);
            let rate: Vector2<f64> = Vector2::new(v[jaw], 0.0) - Vector2::new(v[2], v[3]);
            let at = VELOCITIES * row;
            rows.jacobian[at + jaw] = normal.x;
            rows.jacobian[at + BOX..at + VELOCITIES].copy_from_slice(&[-normal.x, -normal.y, arm.dot(&across)]);
            rows.position[row] = arm.dot(&normal) - 0.5 * width;
            rows.convective[row] = 2.0 * spin * rate.dot(&across) - spin * spin * arm.dot(&normal);
        }
        for (row, side) in [(4, -0.5), (5, 0.5)] {
            let arm = self.rotation * Vector2::new(side * width, -0.5 * height);
            rows.set_planar_body(row, BOX, Vector2::new(0.0, 1.0), arm);
            rows.position[row] = q[3] + arm.y;
            rows.convective[row] = -spin * spin * arm.y;
        }
    }

    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        rows.jacobian[0] = 1.0;
        rows.position[0] = q[0] - self.anchors[0];
        rows.jacobian[VELOCITIES + 1] = -1.0;
        rows.position[1] = self.anchors[1] - q[1];
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        self.p.gravity_m_s2 * self.p.box_mass_kg * q[3]
    }

    fn names(&self) -> ModelNames {
        ModelNames::of(&["left_jaw_x_m", "right_jaw_x_m", "box_x_m", "box_y_m", "box_angle_rad"], &CONTACTS)
    }
}
