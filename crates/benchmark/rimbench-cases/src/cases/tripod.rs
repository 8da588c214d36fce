//! `tripod` and `four-legs`: machines on feet in space, pushed and pulled by two cylinders across each other until
//! their slip turns round. Shown in `docs/cases/tripod.md` and `docs/cases/four-legs.md`; numbers *ours*, the fluid is
//! that of Naya et al. 2011.

use super::prelude::*;
use nalgebra::Vector3;

parameters! {
    /// A box on feet.
    struct Body from "ours" {
        body_mass_kg: f64 = 300.0, Positive, "mass of the box".study(150.0..600.0);
        body_size_x_m: f64 = 1.0, Positive, "size of the box along x (its inertia is that of a cuboid)";
        body_size_y_m: f64 = 1.0, Positive, "size of the box along y";
        body_size_z_m: f64 = 0.5, Positive, "height of the box";
        foot_distance_m: f64 = 0.5, Positive, "distance of the feet from the vertical through the centre of mass";
        foot_depth_m: f64 = 0.4, Positive, "depth of the feet below the centre of mass";
    }
}
parameters! {
    /// Its two cylinders.
    struct Push from "ours" {
        pin_1_x_m: f64 = -0.3, Finite, "end of the first cylinder on the box, x";
        pin_1_y_m: f64 = -0.2, Finite, "end of the first cylinder on the box, y";
        pin_2_x_m: f64 = 0.1, Finite, "end of the second cylinder on the box, x";
        pin_2_y_m: f64 = -0.3, Finite, "end of the second cylinder on the box, y";
        pin_z_m: f64 = -0.1, Finite, "ends of both cylinders on the box, z";
        fixed_1_x_m: f64 = -2.0, Finite, "fixed end of the first cylinder, which lies along x at the start";
        fixed_2_y_m: f64 = -2.0, Finite, "fixed end of the second cylinder, which lies along y at the start";
        cylinder: Cylinder;
        ramp: Ramp with |set| set.only(&["start_pressure_pa"]);
        spool_centre: f64 = 0.5, Positive, "spool commands κ₀ in the middle of their swing";
        spool_amplitude: f64 = 0.3, Fraction, "amplitude A of the spools' swing".study(0.15..0.4);
        spool_1_frequency_hz: f64 = 1.5, Positive, "frequency of the first spool, a sine".study(0.6..2.4);
        spool_2_frequency_hz: f64 = 1.1, Positive, "frequency of the second spool, a cosine".study(0.6..2.4);
        spool_ramp_s: f64 = 0.2, Positive, "time in which the swing grows to its amplitude";
        oil: Oil;
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity".from("standard");
    }
}
parameters! {
    /// On three feet, which share the load in one way only.
    struct Tripod from "ours" {
        body: Body;
        foot_1_angle_deg: f64 = 90.0, Finite, "direction of the first foot, from x towards y";
        foot_2_angle_deg: f64 = 210.0, Finite, "direction of the second foot";
        foot_3_angle_deg: f64 = 330.0, Finite, "direction of the third foot";
        spin_rad_s: f64 = 0.0, Finite, "yaw rate at the start".study(0.0..8.0);
        push: Push;
        contacts: Contacts with |set| set
            .only(&["stabilisation", "friction"]).default("friction", 0.3).within("friction", Positive);
    }
}
parameters! {
    /// On the four corners of a square, which give way.
    struct FourLegs from "ours" {
        body: Body;
        long_feet_m: f64 = 0.0, Finite, "by how much the feet on the y axis are longer than those on the x axis";
        push: Push;
        contacts: Contacts with |set| set
            .only(&["stabilisation", "friction", "contact_compliance_m_n", "contact_damping_n_s_m"])
            .default("friction", 0.3).within("friction", Positive).default("contact_compliance_m_n", 1e-7)
            .default("contact_damping_n_s_m", 1e5);
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

/// A machine on its feet.
struct Machine<'a> {
    body: &'a Body,
    push: &'a Push,
    /// From the centre of mass.
    feet: Vec<[f64; 3]>,
    spin: f64,
}

fn case<P: ParameterSet>(
    [name, about]: [&'static str; 2],
    feet: usize,
    text: [&'static str; 2],
    parts: fn(&P) -> (Machine<'_>, Contacts),
) -> Case {
    let (interface, all) = (InterfaceColumns::of(&NAMES), ["foot_1", "foot_2", "foot_3", "foot_4"]);
    let of_feet = "effective_mass_kg gap_*_m contact_force_*_n friction_force_*_n contact_state_* slip_angle_*_rad \
                   sticking_contacts closed_contacts rank_h_uu";
    Case {
        trace_columns: trace_of(
            &interface,
            "body_x_m body_y_m body_z_m yaw_rad pitch_rad roll_rad",
            &all[..feet],
            of_feet,
        ),
        interface_columns: interface,
        drawing: drawn(move |p: &P| Some(Drawing { title: text, ..parts(p).0.drawing() })),
        ..Case::new(name, about, times(2.5, 5e-3, 5e-5, [2.5e-5, 1e-4]), move |p: &P, assembly: &Assembly<'_>| {
            let (machine, contacts) = parts(p);
            machine.build(assembly, &contacts)
        })
    }
}

pub(super) fn entry() -> Case {
    let about = "Machine on three feet in space, pushed and pulled by two cylinders across each other: slides, yaws, turns its slip round";
    let text = ["Tripod", "Two cylinders push and pull a machine on three feet."];
    case(["tripod", about], 3, text, |p: &Tripod| {
        let feet = [p.foot_1_angle_deg, p.foot_2_angle_deg, p.foot_3_angle_deg].map(|degrees| p.body.foot(degrees));
        (Machine { body: &p.body, push: &p.push, feet: feet.to_vec(), spin: p.spin_rad_s }, p.contacts)
    })
}

pub(super) fn four_legs() -> Case {
    let about = "The tripod's machine on four feet, each with a spring and a damper: how they share the load decides how it yaws";
    let text = ["Four legs", "Two cylinders push and pull a machine on four feet that give way a little."];
    case(["four-legs", about], 4, text, |p: &FourLegs| {
        let mut feet = [90.0, 180.0, 270.0, 0.0].map(|degrees| p.body.foot(degrees));
        feet[0][2] -= p.long_feet_m;
        feet[2][2] -= p.long_feet_m;
        (Machine { body: &p.body, push: &p.push, feet: feet.to_vec(), spin: 0.0 }, p.contacts)
    })
}

impl Body {
    fn foot(&self, degrees: f64) -> [f64; 3] {
        let (sin, cos) = libm::sincos(degrees.to_radians());
        [self.foot_distance_m * cos, self.foot_distance_m * sin, -self.foot_depth_m]
    }

    fn size(&self) -> [f64; 3] {
        [self.body_size_x_m, self.body_size_y_m, self.body_size_z_m]
    }
}

impl Machine<'_> {
    /// Ends of the cylinders on the box, and their fixed ends over the floor.
    fn pins(&self) -> [Pin; 2] {
        let (p, height) = (self.push, self.height());
        let pin = |arm: [f64; 3], [x, y]: [f64; 2]| Pin { fixed: Vector3::new(x, y, height + arm[2]), arm: arm.into() };
        [
            pin([p.pin_1_x_m, p.pin_1_y_m, p.pin_z_m], [p.fixed_1_x_m, p.pin_1_y_m]),
            pin([p.pin_2_x_m, p.pin_2_y_m, p.pin_z_m], [p.pin_2_x_m, p.fixed_2_y_m]),
        ]
    }

    /// Height of the centre of mass at the start, on the longest feet.
    fn height(&self) -> f64 {
        -self.feet.iter().fold(f64::INFINITY, |least, foot| least.min(foot[2]))
    }

    fn build(&self, assembly: &Assembly<'_>, contacts: &Contacts) -> Result<CoupledSystem> {
        let p = self.push;
        let (centre, amplitude) = (p.spool_centre, p.spool_amplitude);
        if centre - amplitude < 0.0 || centre + amplitude > 1.0 {
            let expected = format!("at most {}: the spools must stay within [0, 1]", centre.min(1.0 - centre));
            return Err(Error::invalid("spool_amplitude", amplitude, expected));
        }
        let model = SpatialBody::new(SpatialBodyGeometry {
            position: [0.0, 0.0, self.height()],
            velocity: [0.0, 0.0, 0.0, 0.0, 0.0, self.spin],
            feet: self.feet.iter().copied().map(Foot::over_floor).collect(),
            pins: self.pins().to_vec(),
            ..SpatialBodyGeometry::cuboid(self.body.body_mass_kg, self.body.size(), p.gravity_m_s2)
        })?;
        let swings = [(p.spool_1_frequency_hz, 0.0), (p.spool_2_frequency_hz, 0.25)];
        let units = swings.iter().enumerate().map(|(row, &(frequency, turns))| {
            let spool = Spool::swing(centre, amplitude, frequency, turns, p.spool_ramp_s);
            p.cylinder.starting_at(model.start_length(row), &p.oil, p.ramp.start_pressures(), spool)
        });
        let units = units.collect::<Result<Vec<_>>>()?;
        assembly.couple(model, ActuatorGroup::new(units, &NAMES), contacts)
    }

    fn drawing(&self) -> Drawing {
        let rods = self.pins().map(|pin| Solid {
            pose: body_in_space(),
            form: Form::Rod(pin.fixed.into(), pin.arm.into(), 0.06),
            fill: Fill::Metal,
            gap: None,
        });
        let reach = [self.push.fixed_1_x_m.min(-1.0), self.push.fixed_2_y_m.min(-1.0)];
        let drawing = machine_in_space(self.body.size(), &self.feet, rods.to_vec(), [reach, [1.0, 1.0]]);
        Drawing { force: "first cylinder's force", ..drawing }
    }
}
