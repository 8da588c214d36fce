//! `tripod`: a machine on three feet in space, pushed and pulled by two cylinders across each other until its slip turns round. Shown in
//! `docs/cases/tripod.md`; numbers *ours*, the fluid is that of Naya et al. 2011.

use super::prelude::*;
use nalgebra::Vector3;

parameters! {
    /// A box on three feet, and its two cylinders.
    struct Machine from "ours" {
        body_mass_kg: f64 = 300.0, Positive, "mass of the box" study 150.0..600.0;
        body_size_x_m: f64 = 1.0, Positive, "size of the box along x (its inertia is that of a cuboid)";
        body_size_y_m: f64 = 1.0, Positive, "size of the box along y";
        body_size_z_m: f64 = 0.5, Positive, "height of the box";
        foot_distance_m: f64 = 0.5, Positive, "distance of the feet from the vertical through the centre of mass";
        foot_depth_m: f64 = 0.4, Positive, "depth of the feet below the centre of mass";
        foot_1_angle_deg: f64 = 90.0, Finite, "direction of the first foot, from x towards y";
        foot_2_angle_deg: f64 = 210.0, Finite, "direction of the second foot";
        foot_3_angle_deg: f64 = 330.0, Finite, "direction of the third foot";
        pin_1_x_m: f64 = -0.3, Finite, "end of the first cylinder on the box, x";
        pin_1_y_m: f64 = -0.2, Finite, "end of the first cylinder on the box, y";
        pin_2_x_m: f64 = 0.1, Finite, "end of the second cylinder on the box, x";
        pin_2_y_m: f64 = -0.3, Finite, "end of the second cylinder on the box, y";
        pin_z_m: f64 = -0.1, Finite, "ends of both cylinders on the box, z";
        fixed_1_x_m: f64 = -2.0, Finite, "fixed end of the first cylinder, which lies along x at the start";
        fixed_2_y_m: f64 = -2.0, Finite, "fixed end of the second cylinder, which lies along y at the start";
        cylinder: Cylinder;
        ramp: Ramp only { start_pressure_pa };
        spool_centre: f64 = 0.5, Positive, "spool commands κ₀ in the middle of their swing";
        spool_amplitude: f64 = 0.3, Fraction, "amplitude A of the spools' swing" study 0.15..0.4;
        spool_1_frequency_hz: f64 = 1.5, Positive, "frequency of the first spool, a sine" study 0.6..2.4;
        spool_2_frequency_hz: f64 = 1.1, Positive, "frequency of the second spool, a cosine" study 0.6..2.4;
        spool_ramp_s: f64 = 0.2, Positive, "time in which the swing grows to its amplitude";
        oil: Oil;
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity" from "standard";
        contacts: Contacts only { stabilisation; friction = 0.3 in Positive };
    }
}

const NAMES: [ActuatorNames; 2] = [
    ActuatorNames {
        position: "length_1_m",
        velocity: "velocity_1_m_s",
        force: "force_1_n",
        observables: &["cylinder_1_pressure_1_pa", "cylinder_1_pressure_2_pa", "cylinder_1_spool"],
    },
    ActuatorNames {
        position: "length_2_m",
        velocity: "velocity_2_m_s",
        force: "force_2_n",
        observables: &["cylinder_2_pressure_1_pa", "cylinder_2_pressure_2_pa", "cylinder_2_spool"],
    },
];

pub(super) fn entry() -> Case {
    let own = words("time_s body_x_m body_y_m body_z_m yaw_rad pitch_rad roll_rad");
    let exchanged = words("length_1_m velocity_1_m_s force_1_n length_2_m velocity_2_m_s force_2_n");
    let shared = words(
        "force_to_mechanics_n effective_mass_kg gap_foot_1_m gap_foot_2_m gap_foot_3_m contact_force_foot_1_n \
         contact_force_foot_2_n contact_force_foot_3_n friction_force_foot_1_n friction_force_foot_2_n friction_force_foot_3_n \
         contact_state_foot_1 contact_state_foot_2 contact_state_foot_3 slip_angle_foot_1_rad slip_angle_foot_2_rad \
         slip_angle_foot_3_rad sticking_contacts closed_contacts",
    );
    Case {
        trace_columns: [own, exchanged, shared].concat(),
        interface_columns: NAMES.iter().map(|of| InterfaceColumns::new(of.position, of.velocity, of.force)).collect(),
        drawing: drawn(|p: &Machine| Some(drawing(p))),
        ..Case::new(
            "tripod",
            "Machine on three feet in space, pushed and pulled by two cylinders across each other: slides, yaws, turns its slip round",
            times(2.5, 5e-3, 5e-5, [2.5e-5, 1e-4]),
            build,
        )
    }
}

impl Machine {
    /// Feet from the centre of mass.
    fn feet(&self) -> [[f64; 3]; 3] {
        [self.foot_1_angle_deg, self.foot_2_angle_deg, self.foot_3_angle_deg].map(|degrees| {
            let (sin, cos) = libm::sincos(degrees.to_radians());
            [self.foot_distance_m * cos, self.foot_distance_m * sin, -self.foot_depth_m]
        })
    }

    /// Ends of the cylinders on the box.
    fn pins(&self) -> [[f64; 3]; 2] {
        [[self.pin_1_x_m, self.pin_1_y_m, self.pin_z_m], [self.pin_2_x_m, self.pin_2_y_m, self.pin_z_m]]
    }

    fn model(&self) -> Result<SpatialBody> {
        let (x, y, z) = (self.body_size_x_m, self.body_size_y_m, self.body_size_z_m);
        let [first, second] = self.pins();
        let height = self.foot_depth_m;
        let pin = |arm: [f64; 3], fixed: [f64; 2]| Pin {
            fixed: Vector3::new(fixed[0], fixed[1], height + arm[2]),
            arm: arm.into(),
        };
        SpatialBody::new(SpatialBodyGeometry {
            mass: self.body_mass_kg,
            inertia: [y * y + z * z, x * x + z * z, x * x + y * y].map(|square| self.body_mass_kg * square / 12.0),
            position: [0.0, 0.0, height],
            orientation: [1.0, 0.0, 0.0, 0.0],
            velocity: [0.0; 6],
            gravity: self.gravity_m_s2,
            feet: self.feet().map(Foot::over_floor).to_vec(),
            pins: vec![pin(first, [self.fixed_1_x_m, first[1]]), pin(second, [second[0], self.fixed_2_y_m])],
        })
    }
}

fn build(p: &Machine, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let (centre, amplitude) = (p.spool_centre, p.spool_amplitude);
    if centre - amplitude < 0.0 || centre + amplitude > 1.0 {
        let expected = format!("at most {}: the spools must stay within [0, 1]", centre.min(1.0 - centre));
        return Err(Error::invalid("spool_amplitude", amplitude, expected));
    }
    let model = p.model()?;
    let swings = [(p.spool_1_frequency_hz, 0.0), (p.spool_2_frequency_hz, 0.25)];
    let units = swings.iter().enumerate().map(|(row, &(frequency, turns))| {
        let spool = Spool::swing(centre, amplitude, frequency, turns, p.spool_ramp_s);
        p.cylinder.starting_at(model.start_length(row), &p.oil, p.ramp.start_pressures(), spool)
    });
    let units = units.collect::<Result<Vec<_>>>()?;
    assembly.couple(model, ActuatorGroup::new(units, &NAMES), &p.contacts)
}

/// From the side, and from above to the right of it.
fn drawing(p: &Machine) -> Drawing {
    let (reach, top) = (2.0_f64.max(-p.fixed_1_x_m), 2.2 + 2.0_f64.max(-p.fixed_1_x_m));
    let (half, below) = (0.5 * p.body_size_z_m, -0.5 * p.body_size_z_m);
    let [first, second] = p.pins();
    let cylinder = |from: [f64; 2], to: [f64; 2], frame: &'static str| Shape::Cylinder {
        from: (from, None),
        to: (to, Some(frame)),
        barrel: 0.55 * (reach - 0.3),
        width: 0.08,
    };
    let mut shapes = vec![wall([-reach - 0.1, -0.08], [0.9, 0.0])];
    shapes.push(cylinder([p.fixed_1_x_m, p.foot_depth_m + first[2]], [first[0], first[2]], "side"));
    for [x, _, z] in p.feet() {
        shapes.push(Shape::Polygon(points("side", [[x - 0.05, below], [x, z], [x + 0.05, below]]), Fill::Metal));
    }
    shapes.push(Shape::Polygon(rectangle("side", [0.0, 0.0], [p.body_size_x_m, 2.0 * half]), Fill::Scheme));
    shapes.push(cylinder([top + p.fixed_1_x_m, first[1]], [first[0], first[1]], "above"));
    shapes.push(cylinder([top + second[0], p.fixed_2_y_m], [second[0], second[1]], "above"));
    shapes.push(Shape::Polygon(rectangle("above", [0.0, 0.0], [p.body_size_x_m, p.body_size_y_m]), Fill::Scheme));
    shapes.extend(p.feet().map(|[x, y, _]| disc(([x, y], Some("above")), 0.05, Fill::Metal)));
    let columns = ["contact_force_foot_1_n", "contact_force_foot_2_n", "contact_force_foot_3_n"];
    shapes.extend(columns.iter().zip(p.feet()).map(|(column, [x, _, z])| upward(column, ([x, z], Some("side")), 2e-4)));
    Drawing {
        view: [[-reach - 0.1, top + 0.9], [p.fixed_2_y_m - 0.1, 0.9]],
        frames: vec![
            frame("side", "body_x_m", "body_z_m", Channel::Column("pitch_rad", -1.0, 0.0)),
            frame("above", Channel::Column("body_x_m", 1.0, top), "body_y_m", "yaw_rad"),
        ],
        shapes,
        title: ["Tripod", "Two cylinders push and pull a machine on three feet, seen from the side and from above."],
        force: "first cylinder's force",
        in_kilonewtons: true,
        contact: Some(["lifts off", "stays down"]),
        schemes: ["zero-order-hold", "rim-nonsmooth-gap"],
        ..Drawing::default()
    }
}
