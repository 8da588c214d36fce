//! `excavator-arm`: boom, stick and bucket, with a cylinder and a row of the interface each. The boom is lowered until
//! the bucket's tip presses on the ground; then it lifts, and stick and bucket curl. Shown in
//! `docs/cases/excavator-arm.md`; numbers *ours*, the fluid is that of Naya et al. 2011.

use super::prelude::*;
use crate::models::rotation::rotation;
use nalgebra::{Matrix3, Rotation2, Vector2, Vector3};
use rimbench_core::interface_model::{MatrixForm, Rows};
use rimbench_core::mechanics::{MechanicalModel, ModelNames, ModelSize};

parameters! {
    /// An arm, its cylinders and what they do.
    struct Arm from "ours" {
        boom_length_m: f64 = 2.0, Positive, "length L₁ of the boom".study(1.8..2.2);
        stick_length_m: f64 = 1.1, Positive, "length L₂ of the stick".study(1.0..1.2);
        bucket_length_m: f64 = 0.6, Positive, "length L₃ of the bucket, from its joint to its tip";
        boom_mass_kg: f64 = 180.0, Positive, "mass m₁ of the boom, a uniform rod".study(120.0..250.0);
        stick_mass_kg: f64 = 90.0, Positive, "mass m₂ of the stick, a uniform rod".study(60.0..130.0);
        bucket_mass_kg: f64 = 80.0, Positive, "mass m₃ of the bucket, a uniform rod".study(50.0..120.0);
        base_height_m: f64 = 0.45, Finite, "height h of the boom's foot above the ground";
        boom_angle_rad: f64 = 0.6, Finite, "angle of the boom at the start";
        stick_angle_rad: f64 = -1.1, Finite, "angle of the stick at the start";
        bucket_angle_rad: f64 = -1.9, Finite, "angle of the bucket at the start";
        cylinder: Cylinder with |set| set.default("cylinder_length_m", 0.8).source("cylinder_length_m", "ours");
        spool_lower: f64 = 0.04, Finite, "change of the boom's spool from rest that lowers".study(0.02..0.06);
        spool_lift: f64 = 0.06, Finite, "change of the boom's spool that lifts";
        spool_curl: f64 = 0.02, Finite, "change of the spools of stick and bucket that curls";
        lower_start_s: f64 = 0.1, NotNegative, "start of lowering";
        lower_end_s: f64 = 0.8, NotNegative, "end of lowering, with the tip pressed on the ground";
        lift_start_s: f64 = 1.0, NotNegative, "start of lifting and curling";
        spool_ramp_s: f64 = 0.02, Positive, "time in which the spools move";
        oil: Oil;
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity".from("standard");
        contacts: Contacts with |set| set
            .only(&["stabilisation", "restitution"]).default("restitution", 0.0)
            .about("restitution", "restitution e of the ground").source("restitution", "ours");
    }
}

/// Names of one cylinder.
macro_rules! cylinder {
    ($of:literal) => {
        ActuatorNames {
            position: concat!($of, "_length_m"),
            velocity: concat!($of, "_velocity_m_s"),
            force: concat!($of, "_force_n"),
            observables: &[concat!($of, "_pressure_1_pa"), concat!($of, "_pressure_2_pa"), concat!($of, "_spool")],
        }
    };
}

const NAMES: [ActuatorNames; 3] = [cylinder!("boom"), cylinder!("stick"), cylinder!("bucket")];

pub(super) fn entry() -> Case {
    let (interface, own) = (InterfaceColumns::of(&NAMES), "boom_angle_rad stick_angle_rad bucket_angle_rad");
    let more = "effective_mass_kg gap_*_m contact_force_*_n closed_contacts";
    Case {
        trace_columns: trace_of(&interface, own, &["tip"], more),
        interface_columns: interface,
        reference: reference(),
        drawing: drawn(|p: &Arm| Some(drawing(p))),
        ..Case::new(
            "excavator-arm",
            "Boom, stick and bucket with a cylinder each; the bucket's tip presses on the ground (three interface rows)",
            times(1.6, 2e-3, 5e-5, [5e-5, 1e-4]),
            build,
        )
    }
}

/// Where a cylinder's ends are: the first at a fixed place, in the boom or in the stick, the second one link further;
/// from the joint that a link turns about, along the link and across, m.
const PINS: [[[f64; 2]; 2]; 3] =
    [[[0.35, -0.35], [0.9, 0.0]], [[0.9, 0.25], [-0.3, 0.1]], [[0.25, 0.22], [0.05, 0.22]]];

fn drawing(p: &Arm) -> Drawing {
    let turned_back = |column| Channel::Column(column, -1.0, 0.0);
    let frames = vec![
        frame("boom", 0.0, p.base_height_m, "boom_angle_rad"),
        within("boom", frame("boom end", p.boom_length_m, 0.0, turned_back("boom_angle_rad"))),
        within("boom end", frame("stick", 0.0, 0.0, "stick_angle_rad")),
        within("stick", frame("stick end", p.stick_length_m, 0.0, turned_back("stick_angle_rad"))),
        within("stick end", frame("bucket", 0.0, 0.0, "bucket_angle_rad")),
    ];
    let links = [None, Some("boom"), Some("stick"), Some("bucket")];
    let cylinders = PINS.iter().enumerate().map(|(at, &[[x, y], to])| {
        let from = if at == 0 { [x, y + p.base_height_m] } else { [x, y] };
        Shape::Cylinder { from: (from, links[at]), to: (to, links[at + 1]), barrel: 0.6, width: 0.08 }
    });
    let boom = rectangle("boom", [p.boom_length_m / 2.0, 0.0], [p.boom_length_m, 0.16]);
    let tail = PINS[1][1][0] - 0.05;
    let stick =
        [[tail, 0.05], [0.0, -0.06], [p.stick_length_m, -0.06], [p.stick_length_m, 0.06], [0.0, 0.1], [tail, 0.15]];
    let bucket = [[0.0, -0.05], [p.bucket_length_m, 0.0], [0.5 * p.bucket_length_m, 0.25], [0.0, 0.28]];
    Drawing {
        view: [[-0.5, 3.0], [-0.15, 2.2]],
        frames,
        shapes: [ground(&[[-3.0, 0.0], [6.0, 0.0]]), wall([-0.4, 0.0], [0.5, p.base_height_m])]
            .into_iter()
            .chain([
                Shape::Polygon(boom, Fill::Metal),
                Shape::Polygon(points("stick", stick), Fill::Metal),
                Shape::Polygon(points("bucket", bucket), Fill::Scheme),
            ])
            .chain(cylinders)
            .chain([upward("contact_force_tip_n", ([p.bucket_length_m, 0.0], Some("bucket")), 3e-5)])
            .collect(),
        title: ["Excavator arm", "A boom lowers a bucket until its tip presses on the ground, and lifts it again."],
        force: "boom cylinder's force",
        in_kilonewtons: true,
        ..Drawing::default()
    }
}

#[doc = include_str!("excavator_arm.md")]
#[derive(Debug, Clone)]
struct Links {
    lengths: [f64; 3],
    /// `n_j` and `m_j/3 + Σ_{k > j} m_k`, kg.
    carried: [f64; 3],
    turned: [f64; 3],
    height: f64,
    gravity: f64,
    start: [f64; 3],
    /// What the boom's cylinder begins at, and the parts of each cylinder in two links, m.
    parts: [[(usize, Vector2<f64>); 2]; 3],
    foot: Vector2<f64>,
    rotations: [Rotation2<f64>; 3],
}

impl Links {
    fn new(p: &Arm) -> Self {
        let lengths = [p.boom_length_m, p.stick_length_m, p.bucket_length_m];
        let masses = [p.boom_mass_kg, p.stick_mass_kg, p.bucket_mass_kg];
        let beyond = |link: usize| masses[link + 1..].iter().sum::<f64>();
        let [foot, stick, bucket] = PINS.map(|[from, _]| Vector2::from(from));
        let [boom_end, stick_end, bucket_end] = PINS.map(|[_, to]| Vector2::from(to));
        let along = |link: usize| Vector2::new(lengths[link], 0.0);
        let mut links = Links {
            lengths,
            carried: std::array::from_fn(|link| 0.5 * masses[link] + beyond(link)),
            turned: std::array::from_fn(|link| masses[link] / 3.0 + beyond(link)),
            height: p.base_height_m,
            gravity: p.gravity_m_s2,
            start: [p.boom_angle_rad, p.stick_angle_rad, p.bucket_angle_rad],
            parts: [
                [(0, boom_end), (1, Vector2::zeros())],
                [(0, along(0) - stick), (1, stick_end)],
                [(1, along(1) - bucket), (2, bucket_end)],
            ],
            foot,
            rotations: [Rotation2::identity(); 3],
        };
        links.prepare(&links.start.clone(), &[0.0; 3]);
        links
    }

    /// `n_max(j,k) L_j L_k`, kg·m².
    fn coupling(&self, j: usize, k: usize) -> f64 {
        self.carried[j.max(k)] * self.lengths[j] * self.lengths[k]
    }

    /// Turns a vector of a link into the world.
    fn world(&self, (link, place): (usize, Vector2<f64>)) -> Vector2<f64> {
        self.rotations[link] * place
    }

    /// A cylinder from its first to its second end.
    fn span(&self, cylinder: usize) -> Vector2<f64> {
        let parts: Vector2<f64> = self.parts[cylinder].iter().map(|&part| self.world(part)).sum();
        if cylinder == 0 { parts - self.foot } else { parts }
    }

    /// `∂s/∂θ_j` of a cylinder, m.
    fn levers(&self, cylinder: usize) -> [f64; 3] {
        let along = self.span(cylinder).normalize();
        let mut levers = [0.0; 3];
        self.parts[cylinder].iter().for_each(|&part| levers[part.0] += self.world(part).perp(&along));
        levers
    }

    /// Forces that hold the arm at rest where it stands, N.
    fn holding_forces(&self) -> Option<[f64; 3]> {
        let mut weight = [0.0; 3];
        self.forces(&[], &[0.0; 3], &mut weight);
        let levers = Matrix3::from_fn(|link, cylinder| self.levers(cylinder)[link]);
        levers.lu().solve(&-Vector3::from(weight)).map(Into::into)
    }
}

impl MechanicalModel for Links {
    fn size(&self) -> ModelSize {
        ModelSize { velocities: 3, unilateral: 1, interface: 3, mass: MatrixForm::Dense, ..ModelSize::default() }
    }

    fn initial_state(&self) -> (Vec<f64>, Vec<f64>) {
        (self.start.to_vec(), vec![0.0; 3])
    }

    fn prepare(&mut self, q: &[f64], _v: &[f64]) {
        self.rotations.iter_mut().zip(q).for_each(|(turn, angle)| *turn = rotation(*angle));
    }

    fn mass_matrix(&self, _q: &[f64], mass: &mut [f64]) {
        for j in 0..3 {
            for k in 0..3 {
                mass[3 * j + k] = if j == k {
                    self.turned[j] * self.lengths[j].powi(2)
                } else {
                    let [a, b] = [j, k].map(|link| self.world((link, Vector2::x())));
                    self.coupling(j, k) * a.dot(&b)
                };
            }
        }
    }

    fn forces(&self, _q: &[f64], v: &[f64], force: &mut [f64]) {
        let along = [0, 1, 2].map(|link| self.world((link, Vector2::x())));
        for j in 0..3 {
            let weight = -self.carried[j] * self.gravity * self.lengths[j] * along[j].x;
            // sin(θ_j − θ_k)
            let turns = (0..3).map(|k| self.coupling(j, k) * along[k].perp(&along[j]) * v[k] * v[k]);
            force[j] = weight - turns.sum::<f64>();
        }
    }

    fn unilateral(&self, _q: &[f64], v: &[f64], rows: &mut Rows) {
        (rows.position[0], rows.convective[0]) = (self.height, 0.0);
        for (link, rate) in v.iter().enumerate() {
            let reach = self.lengths[link] * self.world((link, Vector2::x()));
            rows.jacobian[link] = reach.x;
            rows.position[0] += reach.y;
            rows.convective[0] -= rate * rate * reach.y;
        }
    }

    fn interface(&self, _q: &[f64], v: &[f64], rows: &mut Rows) {
        for cylinder in 0..3 {
            let span = self.span(cylinder);
            let (length, levers) = (span.norm(), self.levers(cylinder));
            let along = span / length;
            rows.jacobian[3 * cylinder..3 * cylinder + 3].copy_from_slice(&levers);
            rows.position[cylinder] = length;
            let speed: f64 = levers.iter().zip(v).map(|(lever, rate)| lever * rate).sum();
            let (mut moved, mut bent) = (Vector2::zeros(), 0.0);
            for &part in &self.parts[cylinder] {
                let (arm, rate) = (self.world(part), v[part.0]);
                moved += rate * Vector2::new(-arm.y, arm.x);
                bent -= rate * rate * arm.dot(&along);
            }
            rows.convective[cylinder] = (moved.norm_squared() - speed * speed) / length + bent;
        }
    }

    fn potential_energy(&self, q: &[f64]) -> f64 {
        let high = |link: usize| self.carried[link] * self.lengths[link] * libm::sin(q[link]);
        self.gravity * (0..3).map(high).sum::<f64>()
    }

    fn names(&self) -> ModelNames {
        ModelNames::of(&["boom_angle_rad", "stick_angle_rad", "bucket_angle_rad"], &["tip"])
    }
}

fn build(p: &Arm, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let links = Links::new(p);
    let forces = links.holding_forces().filter(|forces| forces.iter().all(|force| force.is_finite()));
    let Some(forces) = forces else {
        return Err(Error::Incompatible("impossible geometry: a cylinder would start in a dead centre".to_owned()));
    };
    let lowered = [(named!(p.lower_start_s), p.spool_lower), (named!(p.lower_end_s), 0.0)];
    let lifted = [(named!(p.lift_start_s), -p.spool_lift)];
    let curled = [(named!(p.lift_start_s), -p.spool_curl)];
    let moves = [[&lowered[..], &lifted].concat(), curled.to_vec(), curled.to_vec()];
    let units = moves.iter().enumerate().map(|(at, moves)| {
        let (pressures, centre) = p.cylinder.equilibrium(&p.oil, forces[at])?;
        let spool = hydraulics::moved_spool(centre, 1.0, p.spool_ramp_s, moves)?;
        p.cylinder.starting_at(links.span(at).norm(), &p.oil, pressures, spool)
    });
    let units = units.collect::<Result<Vec<_>>>()?;
    assembly.couple(links, ActuatorGroup::new(units, &NAMES), &p.contacts)
}
