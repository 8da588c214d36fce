//! `wedge-box-space`: the wedge box in space, on four wedges, with a ball on a ledge and its cylinder off-centre. Shown
//! in `docs/cases/wedge-box-space.md`; numbers *ours*, the fluid is that of Naya et al. 2011.

use super::prelude::*;
use nalgebra::Vector3;

parameters! {
    /// The box on its wedges with its ball, and what pushes it.
    struct Machine from "as in the wedge box" {
        box_mass_kg: f64 = 200.0, Positive, "mass of the box".study(100.0..400.0);
        box_size_x_m: f64 = 1.0, Positive, "size of the box along x (its inertia is that of a cuboid)";
        box_size_y_m: f64 = 0.8, Positive, "size of the box along y".from("ours");
        box_size_z_m: f64 = 0.6, Positive, "height of the box";
        wedge_x_m: f64 = 0.4, Positive, "tips of the front wedges in the box frame, x (the rear ones are mirrored)";
        wedge_y_m: f64 = 0.3, Positive, "tips of the left wedges in the box frame, y (the right ones are mirrored)".from("ours");
        wedge_z_m: f64 = -0.4, Finite, "wedge tips in the box frame, z";
        short_wedge_m: f64 = 4e-3, NotNegative, "by how much the rear left wedge is shorter".from("ours");
        ball_mass_kg: f64 = 50.0, Positive, "mass of the ball".study(20.0..100.0);
        ball_radius_m: f64 = 0.2, Positive, "radius of the ball, which is solid";
        ball_pin_x_m: f64 = -0.8, Finite, "joint of the ball in the box frame, x";
        ball_pin_y_m: f64 = 0.15, Finite, "joint of the ball in the box frame, y".from("ours");
        ball_pin_z_m: f64 = -0.19, Finite, "joint of the ball in the box frame, z";
        ledge_height_m: f64 = 0.06, NotNegative, "height of the ledge above the floor";
        ledge_lead_m: f64 = 0.05, NotNegative, "distance of the ledge's corner ahead of the ball's centre at the start".from("ours").gap();
        ramp_slope: f64 = 0.25, NotNegative, "fall over run of the ramp".study(0.15..0.3).from("ours");
        attachment_x_m: f64 = -0.5, Finite, "actuator's end on the box, box frame, x";
        attachment_y_m: f64 = -0.1, Finite, "actuator's end on the box, box frame, y".study(-0.3..0.3).from("ours");
        attachment_z_m: f64 = 0.3, Finite, "actuator's end on the box, box frame, z";
        ground_pin_x_m: f64 = -3.0, Finite, "actuator's fixed end, x; the rest is the attachment's at the start";
        cylinder: Cylinder;
        ramp: Ramp;
        oil: Oil;
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity".from("standard");
        contacts: Contacts with |set| set
            .only(&["stabilisation", "friction", "contact_compliance_m_n", "contact_damping_n_s_m"])
            .default("friction", 0.3).within("friction", Positive).source("friction", "ours");
    }
}

pub(super) fn entry() -> Case {
    let own = "body_x_m body_y_m body_z_m yaw_rad pitch_rad roll_rad ball_x_m ball_y_m ball_z_m";
    let mut trace_columns = hydraulics::trace_columns(own, "sticking_contacts closed_contacts rank_h_uu");
    let contacts = ["foot_1", "foot_2", "foot_3", "foot_4", "ball_ledge", "ball_floor"];
    trace_columns.extend(of_contacts(&contacts, "gap_*_m contact_force_*_n contact_state_* slip_angle_*_rad"));
    let about = "Wedge box in space, on four wedges with a ball on a ledge, pushed off its middle: yaws, lands, lifts a loaded foot";
    Case {
        trace_columns,
        interface_columns: hydraulics::interface(),
        drawing: drawn(|p: &Machine| drawing(p).ok()),
        ..Case::new("wedge-box-space", about, times(2.5, 5e-3, 5e-5, [2.5e-5, 5e-5]), build)
    }
}

impl Machine {
    fn size(&self) -> [f64; 3] {
        [self.box_size_x_m, self.box_size_y_m, self.box_size_z_m]
    }

    /// Tips of the wedges: front right, front left, rear right, rear left.
    fn wedges(&self) -> [[f64; 3]; 4] {
        let (x, y, z) = (self.wedge_x_m, self.wedge_y_m, self.wedge_z_m);
        [[x, -y, z], [x, y, z], [-x, -y, z], [-x, y, z + self.short_wedge_m]]
    }

    /// Starts tilted on its front wedges, the ball on the ledge.
    fn model(&self) -> Result<SpatialBody> {
        let at_rest = self.ledge_height_m + self.ball_radius_m;
        let up = level_angle([self.wedge_x_m, self.wedge_z_m], [self.ball_pin_x_m, self.ball_pin_z_m], at_rest)?;
        let ((sin, cos), (half_sin, half_cos)) = (libm::sincos(up), libm::sincos(0.5 * up));
        let height = -(self.wedge_x_m * sin + self.wedge_z_m * cos);
        let place = |[x, y, z]: [f64; 3]| Vector3::new(x * cos - z * sin, y, height + x * sin + z * cos);
        let pin = [self.ball_pin_x_m, self.ball_pin_y_m, self.ball_pin_z_m];
        let attachment = [self.attachment_x_m, self.attachment_y_m, self.attachment_z_m];
        let fixed = Vector3::new(self.ground_pin_x_m, place(attachment).y, place(attachment).z);
        SpatialBody::new(SpatialBodyGeometry {
            position: [0.0, 0.0, height],
            // Up at the front is a turn against y.
            orientation: [half_cos, 0.0, -half_sin, 0.0],
            feet: self.wedges().map(Foot::over_floor).to_vec(),
            pins: vec![Pin { fixed, arm: attachment.into() }],
            ball: Some(LedgeBall {
                mass: self.ball_mass_kg,
                radius: self.ball_radius_m,
                pin: pin.into(),
                ledge: Ledge::new(place(pin).x + self.ledge_lead_m, self.ledge_height_m, self.ramp_slope),
            }),
            ..SpatialBodyGeometry::cuboid(self.box_mass_kg, self.size(), self.gravity_m_s2)
        })
    }
}

fn build(p: &Machine, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let model = p.model()?;
    let (pressures, spool) = (p.ramp.start_pressures(), p.ramp.spool()?);
    let cylinder = p.cylinder.starting_at(model.start_length(0), &p.oil, pressures, spool)?;
    assembly.couple(model, cylinder, &p.contacts)
}

fn drawing(p: &Machine) -> Result<Drawing> {
    let model = p.model()?;
    let SpatialBodyGeometry { pins, ball, .. } = model.geometry();
    let rest = [Channel::Fixed(0.0); 6];
    let mut more = vec![Solid {
        pose: body_in_space(),
        form: Form::Rod(pins[0].fixed.into(), pins[0].arm.into(), 0.08),
        fill: Fill::Metal,
        gap: None,
    }];
    if let Some(ball) = ball {
        let [x, z] = ball.ledge.corner();
        let profile = [[-2.0, 0.0], [x + z / p.ramp_slope.max(0.02), 0.0], [x, z], [-2.0, z]];
        let form = prism(&profile, [p.ball_pin_y_m - 0.15, p.ball_pin_y_m + 0.15]);
        more.push(Solid { pose: rest, form, fill: Fill::Ground, gap: None });
        let mut pose = rest;
        pose[..3].copy_from_slice(&["ball_x_m", "ball_y_m", "ball_z_m"].map(Channel::from));
        more.push(Solid { pose, form: Form::Ball(ball.radius), fill: Fill::Metal, gap: None });
    }
    let floor = [[-2.0, -1.0], [1.5, 1.0]];
    Ok(Drawing {
        title: [
            "Wedge box in space",
            "A cylinder off its middle pushes a box on four wedges; its ball rolls off a ledge.",
        ],
        force: "cylinder force",
        ..machine_in_space(p.size(), &p.wedges(), more, floor)
    })
}
