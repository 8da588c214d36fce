//! Discs that a cylinder pushes: `disc-row`, `disc-pile`, `packed-box`. 1 + 2n velocities (blade; x and y of n discs:
//! without friction they do not spin). Shown in `docs/cases/disc-row.md` and `docs/cases/packed-box.md`.
//!
//! Numbers *ours*; the fluid is that of Naya et al. 2011.

use super::case::Purpose;
use super::contacts::reference_of;
use super::drawing::centres as places;
use super::prelude::*;
use std::f64::consts::{FRAC_PI_3, FRAC_PI_6};

/// What is recorded of discs: the many contacts show as their least gap, the number closed and the sum of their forces;
/// one at the blade, one at the wall and one between discs by name.
fn recorded(case: Case) -> Case {
    Case {
        trace_columns: hydraulics::trace_columns(
            "blade_x_m disc_momentum_x_kg_m_s",
            "gap_blade_m gap_wall_m gap_pair_m gap_lowest_m closed_contacts contact_force_sum_n largest_displacement_m",
        ),
        drawing_columns: words("contact_force_blade_n contact_force_wall_n contact_force_pair_n"),
        interface_columns: hydraulics::interface(),
        ..case
    }
}

choices! { for ContactList { Neighbours = "neighbours", Start = "start", } }
parameters! {
    /// The discs.
    struct Disc from "ours" {
        disc_radius_m: f64 = 0.1, Positive, "radius R of the discs";
        disc_mass_kg: f64 = 20.0, Positive, "mass of each disc".study(5.0..50.0);
    }
}
parameters! {
    /// A cylinder of the size of a loader's.
    struct Actuator from "ours" {
        actuator_length_m: f64 = 1.5, Positive, "length of the actuator at the start";
        cylinder: Cylinder with |set| set
            .from("ours").default("piston_area_m2", 2e-3).default("cylinder_length_m", 1.0)
            .default("valve_area_m2", 1e-5);
    }
}
parameters! {
    /// What presses on discs has oil and weight, and they touch.
    struct Rest from "ours" {
        oil: Oil;
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity".from("standard");
        contacts: Contacts with |set| set
            .only(&["stabilisation", "restitution"]).about("restitution", "restitution e of all contacts")
            .source("restitution", "ours");
    }
}
parameters! {
    /// Discs before a loader's blade.
    struct Loader from "ours" {
        disc: Disc;
        blade_mass_kg: f64 = 100.0, Positive, "mass of the blade with its piston".study(50.0..200.0);
        blade_velocity_m_s: f64 = 0.0, Finite, "velocity of the blade at the start";
        actuator: Actuator;
        start_pressure_pa: f64 = 3.85e6, Positive, "pressure in both chambers at the start";
        spool_push: f64 = 0.3, Fraction, "spool command while pushing; below 0.5 extends".study(0.1..0.45);
        push_start_s: f64 = 0.1, NotNegative, "start of pushing";
        spool_ramp_s: f64 = 0.05, Positive, "time in which the spool moves";
        rest: Rest;
        wall_gap_m: f64 = 0.02, Finite, "distance of the wall from the discs at the start".gap();
    }
}
parameters! {
    /// A row of discs.
    struct Row from "ours" {
        discs: u32 = 10, 2..=2500, "number of discs";
        disc_gap_m: f64 = 5e-3, Finite, "gap between blade, discs and next discs at the start".gap();
        loader: Loader;
    }
}
parameters! {
    /// A heap of discs.
    struct Pile from "ours" {
        columns: u32 = 6, 2..=60, "discs in the lowest layer";
        layers: u32 = 4, 1..=60, "layers";
        contact_list: ContactList [Start],
            "possible contacts: those near at the start; a run in which discs move farther ends";
        loader: Loader;
    }
}
parameters! {
    /// Discs in a box.
    struct Packed from "ours" {
        columns: u32 = 4, 2..=60, "discs m in the lowest layer and each second one above";
        layers: u32 = 5, 1..=80, "layers";
        packing_angle_rad: f64 = 0.9, Positive, "angle α of contacts above the horizontal, π/6 to π/3".study(0.7..1.0);
        disc: Disc;
        wall_mass_kg: f64 = 100.0, Positive, "mass of the wall on the cylinder, with its piston".study(50.0..200.0);
        actuator: Actuator;
        spool_change: f64 = 0.1, Fraction, "spool away from equilibrium while letting out (+) and pushing (−)";
        release_start_s: f64 = 0.1, NotNegative, "start of letting out";
        release_end_s: f64 = 0.3, NotNegative, "end of letting out";
        push_start_s: f64 = 0.4, NotNegative, "start of pushing";
        spool_ramp_s: f64 = 0.02, Positive, "time in which the spool moves";
        rest: Rest;
    }
}

/// Discs between the blade on its cylinder, the floor and the wall.
fn pushed(title: [&'static str; 2], centres: &[[f64; 2]], radius: f64, wall_x: f64, length: f64) -> Drawing {
    let top = centres.iter().map(|centre| centre[1]).fold(0.0, f64::max) + 1.5 * radius;
    let blade = Some("blade");
    let mut shapes = vec![
        ground(&[[-5.0, 0.0], [wall_x, 0.0], [wall_x, top], [wall_x + 9.0, top]]),
        Shape::Cylinder {
            from: ([-length, radius], None),
            to: ([0.0, radius], blade),
            barrel: 0.65 * length,
            width: 0.12,
        },
        Shape::Polygon(rectangle("blade", [-0.03, 0.5 * top], [0.06, top]), Fill::Metal),
    ];
    // Behind the coordinate of the blade.
    shapes.push(Shape::Discs(places(centres.len(), 1), radius, Fill::Scheme));
    let view = [[-length - 0.1, wall_x + 0.15], [-0.15, top + 0.1]];
    Drawing {
        force: "cylinder force",
        in_kilonewtons: true,
        ..Drawing::of(title, view, vec![frame("blade", "blade_x_m", 0.0, 0.0)], shapes)
    }
}

/// x of the disc farthest to the right, m.
fn last(centres: &[[f64; 2]]) -> f64 {
    centres.iter().map(|centre| centre[0]).fold(f64::NEG_INFINITY, f64::max)
}

impl Loader {
    /// What it looks like.
    fn drawing(&self, title: [&'static str; 2], centres: &[[f64; 2]]) -> Option<Drawing> {
        let radius = self.disc.disc_radius_m;
        Some(pushed(title, centres, radius, last(centres) + radius + self.wall_gap_m, self.actuator.actuator_length_m))
    }

    /// Both sides for discs with these centres before the blade; the wall stands behind the last of them.
    fn push(&self, assembly: &Assembly<'_>, centres: Vec<[f64; 2]>, list: ContactList) -> Result<CoupledSystem> {
        let (radius, length) = (self.disc.disc_radius_m, self.actuator.actuator_length_m);
        let geometry = DiscsGeometry {
            blade_mass: self.blade_mass_kg,
            blade_velocity: self.blade_velocity_m_s,
            disc_mass: self.disc.disc_mass_kg,
            radius,
            wall_x: last(&centres) + radius + self.wall_gap_m,
            actuator_length: length,
            gravity: self.rest.gravity_m_s2,
            centres,
            bumps: Vec::new(),
        };
        let model = Discs::new(geometry, list)?;
        let ((start, from), (ramp, time)) = (named!(self.push_start_s), named!(self.spool_ramp_s));
        let spool = hydraulics::spool(&[(start, from, 0.5), (ramp, from + time, self.spool_push)])?;
        let pressures = [self.start_pressure_pa; 2];
        let cylinder = self.actuator.cylinder.starting_at(length, &self.rest.oil, pressures, spool)?;
        assembly.couple(model, cylinder, &self.rest.contacts)
    }
}

impl Row {
    fn centres(&self) -> Vec<[f64; 2]> {
        let (radius, gap) = (self.loader.disc.disc_radius_m, self.disc_gap_m);
        (0..self.discs).map(|disc| [f64::from(disc) * (2.0 * radius + gap) + gap + radius, radius]).collect()
    }
}

impl Pile {
    fn centres(&self) -> Vec<[f64; 2]> {
        let radius = self.loader.disc.disc_radius_m;
        let mut centres = Vec::new();
        for layer in 0..self.layers {
            // Each second layer lies in the hollows of the one below.
            let shift = layer % 2;
            for column in 0..self.columns - shift {
                let x = radius * f64::from(1 + shift + 2 * column);
                centres.push([x, radius * (1.0 + 3.0_f64.sqrt() * f64::from(layer))]);
            }
        }
        centres
    }
}

/// A row of discs is pushed together and against a wall: each gap closes with an impact.
pub(super) fn row() -> Case {
    recorded(Case {
        drawing: drawn(|p: &Row| {
            let title = ["Row of discs", "A blade pushes a row of discs together and against a wall."];
            p.loader.drawing(title, &p.centres())
        }),
        constant_mechanics: true,
        // Each disc on the floor, and between blade, discs and wall.
        reference: reference_of(|p: &Row| 2 * p.discs as usize + 1),
        ..Case::new(
            "disc-row",
            "A loader's blade pushes a row of discs together and against a wall (a contact chain)",
            times(1.0, 5e-3, 5e-5, [1e-4, 2e-4]),
            |p: &Row, assembly| p.loader.push(assembly, p.centres(), ContactList::Neighbours),
        )
    })
}

/// A hexagonal heap settles between blade and wall and is pushed: some 3n contacts, many more than it can carry (2n)
/// without friction.
pub(super) fn pile() -> Case {
    recorded(Case {
        purpose: Purpose::Speed,
        drawing: drawn(|p: &Pile| {
            p.loader.drawing(["Heap of discs", "A blade pushes a heap of discs against a wall."], &p.centres())
        }),
        ..Case::new(
            "disc-pile",
            "A loader's blade pushes a heap of discs against a wall (62 contacts; thousands by its parameters)",
            times(0.5, 5e-3, 5e-5, [1e-4, 2e-4]),
            |p: &Pile, assembly| p.loader.push(assembly, p.centres(), p.contact_list),
        )
    })
}

/// Layers of m and m − 1 discs in turn between two walls, neighbours of a layer apart, each disc on two below it: as
/// many contacts as unknowns, so that forces at rest are unique.
pub(super) fn packed_box() -> Case {
    recorded(Case {
        purpose: Purpose::Speed,
        drawing: drawn(|p: &Packed| {
            let radius = p.disc.disc_radius_m;
            let [centres, bumps] = packing(p.columns, p.layers, p.packing_angle_rad, radius);
            let title = ["Packed box", "A cylinder holds one wall of a box packed with discs."];
            let mut drawing = pushed(title, &centres, radius, last(&centres) + radius, p.actuator.actuator_length_m);
            drawing.shapes.splice(0..0, bumps.into_iter().map(|bump| disc((bump, None), radius, Fill::Ground)));
            Some(drawing)
        }),
        ..Case::new(
            "packed-box",
            "Discs packed in a box, one wall of which a cylinder holds (36 forces at rest in closed form; thousands by its parameters)",
            times(0.8, 5e-3, 5e-5, [1e-4, 2e-4]),
            build_packed,
        )
    })
}

/// Forces of a wall on the discs that touch it, from the top, N.
///
/// ```text
/// P_j = W cot α (1 + j + ⌊j/(2m − 2)⌋)        j layers above, of those layers that have m discs
/// ```
/// W is the weight of a disc. A disc with the forces A_l and A_r of the discs above it, from the left and from the
/// right, passes on `A_r + W/(2 sin α)` to the lower left and `A_l + W/(2 sin α)` to the lower right; at a wall what
/// comes from the one side leaves on the same side with all of its weight, `A + W/sin α`. So a line of force grows by
/// half a `W/sin α` per layer and by another half each time a wall turns it back, every 2m − 2 layers.
/// # Panics
/// If `columns` is below 2: one disc between two walls has no line of force.
/// # Source
/// Ours.
pub fn wall_forces(columns: u32, layers: u32, angle: f64, weight: f64) -> Vec<f64> {
    let (sin, cos) = libm::sincos(angle);
    let force = |above: u32| weight * cos / sin * f64::from(1 + above + above / (2 * columns - 2));
    (0..layers).filter(|above| (layers - 1 - above).is_multiple_of(2)).map(force).collect()
}

/// Centres of the discs, and of the half discs that they lie on.
fn packing(columns: u32, layers: u32, angle: f64, radius: f64) -> [Vec<[f64; 2]>; 2] {
    let (sin, cos) = libm::sincos(angle);
    // Half the distance of neighbours in a layer, and of layers.
    let (aside, up) = (2.0 * radius * cos, 2.0 * radius * sin);
    // A layer and the one above it in turn, from the left: the first two discs touch.
    let mut centres = Vec::new();
    for below in (0..layers).step_by(2) {
        for place in 0..2 * columns - 1 {
            let layer = below + place % 2;
            if layer < layers {
                centres.push([radius + aside * f64::from(place), up * f64::from(1 + layer)]);
            }
        }
    }
    let bumps = (0..columns - 1).map(|bump| [radius + aside * f64::from(1 + 2 * bump), 0.0]);
    [centres, bumps.collect()]
}

fn build_packed(p: &Packed, assembly: &Assembly<'_>) -> Result<CoupledSystem> {
    let (columns, layers, angle) = (p.columns, p.layers, p.packing_angle_rad);
    if angle <= FRAC_PI_6 || angle >= FRAC_PI_3 {
        let expected = format!(
            "between π/6 = {FRAC_PI_6:.6} and π/3 = {FRAC_PI_3:.6}, where discs of a layer or of each second one meet"
        );
        return Err(Error::invalid("packing_angle_rad", angle, expected));
    }
    // Neighbours of a layer are 4 R cos α apart.
    let flattest = libm::acos(0.25 * (2.0 + Discs::LISTED));
    if layers == 1 && angle <= flattest {
        let expected = format!(
            "above {flattest:.6} where layers = 1: two discs of one layer would start more than {} radii apart, and no pair could ever touch",
            Discs::LISTED
        );
        return Err(Error::invalid("packing_angle_rad", angle, expected));
    }
    let radius = p.disc.disc_radius_m;
    let [centres, bumps] = packing(columns, layers, angle, radius);
    let length = p.actuator.actuator_length_m;
    let geometry = DiscsGeometry {
        blade_mass: p.wall_mass_kg,
        blade_velocity: 0.0,
        disc_mass: p.disc.disc_mass_kg,
        radius,
        wall_x: last(&centres) + radius,
        centres,
        bumps,
        actuator_length: length,
        gravity: p.rest.gravity_m_s2,
    };
    let model = Discs::new(geometry, ContactList::Start)?;
    let weight = p.disc.disc_mass_kg * p.rest.gravity_m_s2;
    let held = wall_forces(columns, layers, angle, weight).iter().sum();
    let (pressures, centre) = p.actuator.cylinder.equilibrium(&p.rest.oil, held)?;
    let moves = [(named!(p.release_start_s), 1.0), (named!(p.release_end_s), 0.0), (named!(p.push_start_s), -1.0)];
    let spool = hydraulics::moved_spool(centre, p.spool_change, p.spool_ramp_s, &moves)?;
    let cylinder = p.actuator.cylinder.starting_at(length, &p.rest.oil, pressures, spool)?;
    assembly.couple(model, cylinder, &p.rest.contacts)
}
