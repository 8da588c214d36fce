//! `lift-table`: a box on one to six hydraulic cylinders is lowered unevenly onto two stops, pressed, and lifted. One
//! interface row per cylinder. Shown in `docs/cases/lift-table.md`; numbers *ours*, the fluid is that of Naya et
//! al. 2011.

use super::prelude::*;
use rimbench_core::interface_model::Rows;
use rimbench_core::mechanics::{MechanicalModel, ModelNames, ModelSize};

parameters! {
    /// A box, its cylinders and what they do.
    struct Lift from "ours" {
        cylinders: u32 = 3, 1..=6, "number N of cylinders under the box, evenly spaced, each with a row of the interface";
        outer_cylinder_m: f64 = 0.3, Positive, "distance of the outermost cylinders from the middle; of no use with one cylinder";
        box_mass_kg: f64 = 200.0, Positive, "mass of the box".study(100.0..400.0);
        box_width_m: f64 = 1.0, Positive, "width of the box";
        box_height_m: f64 = 0.6, Positive, "height of the box";
        stop_m: f64 = 0.4, Positive, "distance of each stop from the middle";
        start_height_m: f64 = 0.02, NotNegative, "height of the box above the stops at the start";
        actuator_length_m: f64 = 0.8, Positive, "length of all cylinders at the start";
        cylinder: Cylinder with |set| set.default("cylinder_length_m", 1.0).source("cylinder_length_m", "ours");
        spool_lower: f64 = 0.1, Finite, "change of the spools from rest that lowers".study(0.05..0.15);
        spool_uneven: f64 = 0.02, Finite, "what the spools left of the middle change more, and those right of it less";
        spool_lift: f64 = 0.1, Finite, "change of the spools that lifts; half of it left of the middle";
        lower_start_s: f64 = 0.1, NotNegative, "start of lowering";
        lower_end_s: f64 = 0.9, NotNegative, "end of lowering, with the box pressed on the stops";
        lift_start_s: f64 = 1.0, NotNegative, "start of lifting";
        spool_ramp_s: f64 = 0.02, Positive, "time in which the spools move";
        oil: Oil;
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity".from("standard");
        contacts: Contacts with |set| set
            .only(&["stabilisation", "restitution"]).default("restitution", 0.0)
            .about("restitution", "restitution e of the stops").source("restitution", "ours");
    }
}

/// Names of cylinders, from the left.
macro_rules! cylinders {
    ($($n:literal),+) => {
        [$(ActuatorNames {
            position: concat!("length_", $n, "_m"),
            velocity: concat!("velocity_", $n, "_m_s"),
            force: concat!("force_", $n, "_n"),
            observables: &[
                concat!("cylinder_", $n, "_pressure_1_pa"),
                concat!("cylinder_", $n, "_pressure_2_pa"),
                concat!("cylinder_", $n, "_spool"),
            ],
        }),+]
    };
}

const NAMES: [ActuatorNames; 6] = cylinders!("1", "2", "3", "4", "5", "6");

pub(super) fn entry() -> Case {
    let interface = InterfaceColumns::of(&NAMES);
    let more = "effective_mass_kg gap_*_m contact_force_*_n closed_contacts";
    Case {
        trace_columns: trace_of(&interface, "box_y_m box_angle_rad", &["left_stop", "right_stop"], more),
        interface_columns: interface,
        constant_mechanics: true,
        reference: reference(),
        drawing: drawn(|p: &Lift| Some(drawing(p))),
        ..Case::new(
            "lift-table",
            "A box on one to six cylinders lowered unevenly onto two stops, pressed, lifted (one interface row each)",
            times(1.6, 2e-3, 5e-5, [5e-5, 1e-4]),
            build,
        )
    }
}

impl Lift {
    /// x of each cylinder, from the left.
    fn places(&self) -> Vec<f64> {
        let last = f64::from(self.cylinders - 1);
        let place = |i: u32| if last > 0.0 { self.outer_cylinder_m * (2.0 * f64::from(i) / last - 1.0) } else { 0.0 };
        (0..self.cylinders).map(place).collect()
    }
}

fn drawing(p: &Lift) -> Drawing {
    let (width, height, reach) = (p.box_width_m, p.box_height_m, p.actuator_length_m);
    let bottom = p.start_height_m - reach;
    let cylinder = |x: f64| Shape::Cylinder {
        from: ([x, bottom], None),
        to: ([x, 0.0], Some("box")),
        barrel: 0.7 * reach,
        width: 0.06,
    };
    let stop = |x: f64| wall([x - 0.03, bottom], [x + 0.03, 0.0]);
    Drawing {
        view: [[-0.8, 0.8], [bottom - 0.05, height + 0.1]],
        frames: vec![frame("box", 0.0, "box_y_m", "box_angle_rad")],
        shapes: [ground(&[[-3.0, bottom], [3.0, bottom]]), stop(-p.stop_m), stop(p.stop_m)]
            .into_iter()
            .chain(p.places().into_iter().map(cylinder))
            .chain([
                Shape::Polygon(rectangle("box", [0.0, 0.5 * height], [width, height]), Fill::Scheme),
                upward("contact_force_left_stop_n", ([-p.stop_m, 0.0], Some("box")), 3e-5),
                upward("contact_force_right_stop_n", ([p.stop_m, 0.0], Some("box")), 3e-5),
            ])
            .collect(),
        title: ["Lift table", "Cylinders lower a box unevenly onto two stops, press it down, and lift it again."],
        force: "first cylinder's force",
        in_kilonewtons: true,
        ..Drawing::default()
    }
}

/// A box that moves up and down and turns by small angles: middle of its lower side `y`, angle `φ`.
///
/// ```text
/// g = y ± x_stop φ        s_i = s₀ + y − y₀ + x_i φ        A, M constant
/// ```
#[derive(Debug, Clone, PartialEq)]
struct Table {
    mass: [f64; 2],
    weight: f64,
    start: f64,
    length: f64,
    stop: f64,
    places: Vec<f64>,
}

impl MechanicalModel for Table {
    fn size(&self) -> ModelSize {
        ModelSize {
            velocities: 2,
            unilateral: 2,
            interface: self.places.len(),
            constant_mass: true,
            ..ModelSize::default()
        }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (vec![self.start, 0.0], vec![0.0; 2])
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        mass.copy_from_slice(&self.mass);
    }

    fn forces(&self, _q: &[f64], _v: &[f64], force: &mut [f64]) {
        force.copy_from_slice(&[-self.weight, 0.0]);
    }

    fn unilateral(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        for (row, arm) in [-self.stop, self.stop].into_iter().enumerate() {
            rows.jacobian[2 * row..2 * row + 2].copy_from_slice(&[1.0, arm]);
            rows.position[row] = q[0] + arm * q[1];
        }
    }

    fn interface(&self, q: &[f64], _v: &[f64], rows: &mut Rows) {
        for (row, &arm) in self.places.iter().enumerate() {
            rows.jacobian[2 * row..2 * row + 2].copy_from_slice(&[1.0, arm]);
            rows.position[row] = self.length + q[0] - self.start + arm * q[1];
        }
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        self.weight * q[0]
    }

    fn names(&self) -> ModelNames {
        ModelNames::of(&["box_y_m", "box_angle_rad"], &["left_stop", "right_stop"])
    }
}

fn build(p: &Lift, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let (places, weight) = (p.places(), p.box_mass_kg * p.gravity_m_s2);
    let inertia = p.box_mass_kg * (p.box_width_m.powi(2) + p.box_height_m.powi(2)) / 12.0;
    let (pressures, centre) = p.cylinder.equilibrium(&p.oil, weight / f64::from(p.cylinders))?;
    let unit = |x: &f64| {
        let left = if *x == 0.0 { 0.0 } else { -x.signum() };
        let moves = [
            (named!(p.lower_start_s), p.spool_lower + p.spool_uneven * left),
            (named!(p.lower_end_s), 0.0),
            (named!(p.lift_start_s), -p.spool_lift * if left > 0.0 { 0.5 } else { 1.0 }),
        ];
        let spool = hydraulics::moved_spool(centre, 1.0, p.spool_ramp_s, &moves)?;
        p.cylinder.starting_at(p.actuator_length_m, &p.oil, pressures, spool)
    };
    let units = places.iter().map(unit).collect::<Result<Vec<_>>>()?;
    let names = &NAMES[..places.len()];
    let table = Table {
        mass: [p.box_mass_kg, inertia],
        weight,
        start: p.start_height_m,
        length: p.actuator_length_m,
        stop: p.stop_m,
        places,
    };
    let mut system = assembly.couple(table, ActuatorGroup::new(units, names), &p.contacts)?;
    // Columns of cylinders that the table does not have are zero.
    let absent = NAMES[names.len()..].iter().flat_map(|of| [of.position, of.velocity, of.force]);
    system.derived.extend(absent.map(|column| DerivedColumn::new(column, ["time_s"], |_| 0.0)));
    Ok(system)
}
