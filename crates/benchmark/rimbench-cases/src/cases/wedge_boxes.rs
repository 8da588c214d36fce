//! The wedge boxes: a hydraulic cylinder pushes a box on wedges, with discs on ledges beside it.
//! `docs/cases/wedge-box.md` shows the first, the example of the source paper; the others differ from it in how many
//! wedges and discs there are, where it starts, and what the spool does.
//!
//! Geometry and masses are *ours*, the hydraulic constants those of Naya et al. 2011.

use super::prelude::*;

parameters! {
    /// The box with its two wedges and its disc, the ledge, and where the actuator is held.
    struct Body from "ours" {
        box_mass_kg: f64 = 200.0, Positive, "mass of the box".study(100.0..400.0);
        box_width_m: f64 = 1.0, Positive, "width of the box (its inertia is that of a rectangle)";
        box_height_m: f64 = 0.6, Positive, "height of the box";
        disc_mass_kg: f64 = 50.0, Positive, "mass of the disc".study(20.0..100.0);
        disc_radius_m: f64 = 0.2, Positive, "radius of the disc";
        disc_pin_x_m: f64 = -0.8, Finite, "joint of the disc in the box frame, x";
        disc_pin_y_m: f64 = -0.19, Finite, "joint of the disc in the box frame, y";
        wedge_tip_x_m: f64 = 0.4, Positive, "right wedge tip in the box frame, x (the left one is mirrored)";
        wedge_tip_y_m: f64 = -0.4, Finite, "wedge tips in the box frame, y";
        ledge_height_m: f64 = 0.06, NotNegative, "height of the ledge above the floor";
        ledge_lead_m: f64 = 0.1, NotNegative, "distance of the ledge's corner ahead of the disc's centre at the start".gap();
        ramp_slope: f64 = 0.15, NotNegative, "fall over run of the ramp".study(0.08..0.3);
        attachment_x_m: f64 = -0.5, Finite, "actuator's end on the box, box frame, x";
        attachment_y_m: f64 = 0.3, Finite, "actuator's end on the box, box frame, y";
        ground_pin_x_m: f64 = -3.0, Finite, "actuator's fixed end, x; its height is the attachment's at the start";
    }
}
parameters! {
    /// What the box of the paper meets.
    struct Surroundings from "ours" {
        oil: Oil;
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity".from("standard");
        contacts: Contacts with |set| set
            .only(&["stabilisation", "restitution", "contact_compliance_m_n", "contact_damping_n_s_m"])
            .source("restitution", "plastic, as in the paper");
    }
}
parameters! {
    /// The box of the paper, pushed by a ramp of the spool.
    struct WithRamp from "ours" {
        body: Body;
        cylinder: Cylinder with |set| set
            .source("cylinder_length_m", "ours").source("viscous_friction_n_s_m", "ours")
            .source("valve_area_m2", "ours");
        ramp: Ramp with |set| set.from("ours");
        rest: Surroundings;
        rough: Contacts with |set| set.only(&["friction", "tangential_restitution"]);
    }
}
parameters! {
    /// The box of the paper with friction, pushed and pulled by a swinging spool.
    struct WithFriction from "ours" {
        body: Body;
        cylinder: Cylinder with |set| set
            .source("cylinder_length_m", "ours").source("viscous_friction_n_s_m", "ours")
            .source("valve_area_m2", "ours");
        ramp: Ramp with |set| set.from("ours").only(&["start_pressure_pa"]);
        rest: Surroundings;
        rough: Contacts with |set| set
            .only(&["friction", "tangential_restitution"]).default("friction", 0.3).within("friction", Positive);
        spool_centre: f64 = 0.5, Positive, "spool command κ₀ at first, and in the middle of its swing";
        spool_amplitude: f64 = 0.3, Fraction, "amplitude A of the spool's swing".study(0.1..0.45);
        spool_frequency_hz: f64 = 1.5, Positive, "frequency f of the spool's swing".study(0.5..3.0);
        spool_swings: u32 = 4, 1..=100, "number of whole swings, after which the spool rests in the middle";
        spool_swing_start_s: f64 = 0.1, NotNegative, "when the spool starts to swing, towards extension";
    }
}
parameters! {
    /// The box of the paper against its ramp, held by a cylinder that pulls.
    struct AgainstRamp from "ours" {
        body: Body with |set| set
            .only(&["box_mass_kg", "box_width_m", "box_height_m", "disc_mass_kg", "disc_radius_m", "disc_pin_x_m", "disc_pin_y_m", "wedge_tip_x_m", "wedge_tip_y_m", "ledge_height_m", "ramp_slope", "attachment_x_m", "attachment_y_m", "ground_pin_x_m"]);
        cylinder: Cylinder with |set| set
            .source("cylinder_length_m", "ours").source("viscous_friction_n_s_m", "ours")
            .source("valve_area_m2", "ours");
        ramp: Ramp with |set| set.from("ours").only(&["spool_final"]);
        rest: Surroundings;
        rough: Contacts with |set| set.only(&["friction", "tangential_restitution"]);
        holding_pull_n: f64 = 90.0, Positive, "force with which the cylinder pulls at first";
        reversal_start_s: f64 = 0.3, NotNegative, "start of the spool's ramp to its final command";
        reversal_end_s: f64 = 0.4, NotNegative, "end of the spool's ramp";
    }
}

impl Body {
    /// The box with its wedges and no disc yet.
    fn without_disc(&self, gravity: f64) -> WedgeBoxGeometry {
        let [x, y] = [self.wedge_tip_x_m, self.wedge_tip_y_m];
        WedgeBoxGeometry {
            box_mass: self.box_mass_kg,
            box_size: [self.box_width_m, self.box_height_m],
            wedges: vec![[x, y], [-x, y]],
            wedge_name: "support",
            attachment: [self.attachment_x_m, self.attachment_y_m],
            ground_pin_x: self.ground_pin_x_m,
            gravity,
            ..WedgeBoxGeometry::default()
        }
    }

    /// A disc with its joint at this x of the box, and its ledge.
    fn disc(&self, pin_x: f64, ledge_height: f64, ledge_lead: f64) -> LedgeDisc {
        LedgeDisc {
            mass: self.disc_mass_kg,
            radius: self.disc_radius_m,
            pin: [pin_x, self.disc_pin_y_m],
            ledge_height,
            ledge_lead,
            ramp_slope: self.ramp_slope,
        }
    }

    /// The box with its disc.
    fn geometry(&self, gravity: f64) -> WedgeBoxGeometry {
        WedgeBoxGeometry {
            discs: vec![self.disc(self.disc_pin_x_m, self.ledge_height_m, self.ledge_lead_m)],
            ..self.without_disc(gravity)
        }
    }

    /// The box of the paper, whose supports are called wedges.
    fn of_the_paper(&self, rest: &Surroundings) -> WedgeBoxGeometry {
        WedgeBoxGeometry { wedge_name: "wedge", ..self.geometry(rest.gravity_m_s2) }
    }
}

/// A box, what pushes it, and how its contacts behave.
type Parts = (WedgeBox, HydraulicCylinder, Contacts);

/// A case that is made of this.
fn entry<P: ParameterSet>(
    [name, about]: [&'static str; 2],
    text: [&'static str; 2],
    times: CaseDefaults,
    parts: fn(&P) -> Result<Parts>,
) -> Case {
    let build = move |p: &P, assembly: &Assembly<'_>| {
        let (model, cylinder, contacts) = parts(p)?;
        assembly.couple(model, cylinder, &contacts)
    };
    Case {
        interface_columns: hydraulics::interface(),
        reference: reference(),
        drawing: drawn(move |p| parts(p).ok().map(|(model, cylinder, _)| drawing(&model, cylinder.length(), text))),
        ..Case::new(name, about, times, build)
    }
}

/// The box of the paper: two wedges, one disc on a ledge.
fn of_the_paper<P: ParameterSet>(
    duration: f64,
    names: [&'static str; 2],
    text: [&'static str; 2],
    parts: fn(&P) -> Result<Parts>,
) -> Case {
    Case {
        trace_columns: hydraulics::trace_columns(
            "box_x_m box_y_m box_angle_rad",
            "gap_right_wedge_m gap_left_wedge_m gap_disc_ledge_m gap_disc_floor_m closed_contacts rank_h_uu",
        ),
        drawing_columns: words(
            "disc_ledge_normal_rad contact_force_right_wedge_n contact_force_left_wedge_n contact_force_disc_ledge_n \
             contact_force_disc_floor_n",
        ),
        ..entry(names, text, times(duration, 5e-3, 5e-5, [2.5e-5, 5e-5]), parts)
    }
}

/// Starts tilted on its right wedge, the disc on the ledge.
pub(super) fn wedge_box() -> Case {
    let about = "Box on two wedges with a disc on a ledge, pushed by a hydraulic cylinder (the source paper's example)";
    let text =
        ["Wedge box", "A hydraulic cylinder pushes a box; its disc rolls off a ledge and both wedges touch down."];
    of_the_paper(2.5, ["wedge-box", about], text, |p: &WithRamp| {
        let model = WedgeBox::new(p.body.of_the_paper(&p.rest))?;
        let (pressures, spool) = (p.ramp.start_pressures(), p.ramp.spool()?);
        let cylinder = p.cylinder.starting_at(model.start_length(), &p.rest.oil, pressures, spool)?;
        Ok((model, cylinder, p.rest.contacts))
    })
}

/// What a box on wedges looks like, with its discs on their ledges.
fn drawing(model: &WedgeBox, barrel: f64, [title, about]: [&'static str; 2]) -> Drawing {
    let g = model.geometry();
    let [width, height] = g.box_size;
    let mut frames = vec![frame("box", "box_x_m", "box_y_m", "box_angle_rad")];
    let mut shapes = Vec::new();
    let mut floor = vec![[-9.0, 0.0], [9.0, 0.0]];
    for (disc, corner) in g.discs.iter().zip(model.ledge_corners()) {
        // The right disc rolls off a ledge that lies between the two.
        let foot = [corner[0] + corner[1] / disc.ramp_slope, 0.0];
        floor = match disc.pin[0] < 0.0 {
            true => vec![[-9.0, corner[1]], corner, foot, [9.0, 0.0]],
            false => [&floor[..floor.len() - 1], &[[corner[0] - 0.01, 0.0], corner, foot, [9.0, 0.0]]].concat(),
        };
    }
    shapes.push(ground(&floor));
    shapes.push(Shape::Cylinder {
        from: (model.ground_pin(), None),
        to: (g.attachment, Some("box")),
        barrel,
        width: 0.1,
    });
    for (name, disc) in ["left disc", "right disc"].into_iter().zip(&g.discs) {
        // Rolling is drawn without slip: the model's discs turn freely.
        let turned = Channel::Column("box_x_m", -1.0 / disc.radius, 0.0);
        frames.push(within("box", frame(name, disc.pin[0], disc.pin[1], turned)));
        let side = disc.pin[0].signum() * width / 2.0;
        let [x, y] = disc.pin;
        let arm = [[side, y + 0.14], [x, y + 0.03], [x, y - 0.03], [side, y - 0.05]];
        shapes.push(Shape::Polygon(points("box", arm), Fill::Scheme));
        shapes.push(wheel(name, disc.radius));
    }
    let base = -height / 2.0;
    let half = 0.1_f64.min(width / (2.0 * g.wedges.len() as f64));
    for &[x, y] in &g.wedges {
        shapes.push(Shape::Polygon(points("box", [[x - half, base], [x, y], [x + half, base]]), Fill::Scheme));
    }
    shapes.push(Shape::Polygon(rectangle("box", [0.0, 0.0], [width, height]), Fill::Scheme));
    // Of many wedges the sum of the forces is known, and no single one.
    let columns = match (g.wedge_name, g.wedges.len()) {
        ("wedge", _) => vec!["contact_force_right_wedge_n", "contact_force_left_wedge_n"],
        (_, 2) => vec!["contact_force_right_support_n", "contact_force_left_support_n"],
        _ => Vec::new(),
    };
    shapes.extend(columns.into_iter().zip(&g.wedges).map(|(column, &tip)| upward(column, (tip, Some("box")), 1.5e-4)));
    let rightmost = g.discs.iter().map(|disc| disc.pin[0] + disc.radius + 0.1).fold(0.3 + width / 2.0, f64::max);
    Drawing {
        view: [[-1.55, rightmost], [-0.16, 0.92]],
        follow: Some("box_x_m"),
        frames,
        shapes,
        title: [title, about],
        force: "cylinder force",
        in_kilonewtons: true,
        contact: Some(["lifts off", "stays down"]),
        ..Drawing::default()
    }
}

/// Returns the geometry of the wedge box as the parameters of the case `wedge-box` say.
pub fn wedge_box_geometry(parameters: &Parameters) -> WedgeBoxGeometry {
    let p = WithRamp::read(parameters);
    p.body.of_the_paper(&p.rest)
}

/// With Coulomb friction, pushed and pulled by a spool that swings about its middle, `κ = κ₀ − A sin(2π f (t − t₀))`.
/// Parameters chosen because it sticks.
pub(super) fn with_friction() -> Case {
    let about = "Wedge box with friction at its contacts, pushed and pulled by a swinging spool until it sticks";
    let text = ["Wedge box with friction", "A swinging spool pushes and pulls the box until it sticks."];
    let mut case = of_the_paper(2.5, ["wedge-box-friction", about], text, |p: &WithFriction| {
        let model = WedgeBox::new(p.body.of_the_paper(&p.rest))?;
        let (centre, amplitude) = (p.spool_centre, p.spool_amplitude);
        if centre - amplitude < 0.0 || centre + amplitude > 1.0 {
            let expected = format!("at most {}: the spool must stay within [0, 1]", centre.min(1.0 - centre));
            return Err(Error::invalid("spool_amplitude", amplitude, expected));
        }
        let (length, pressures) = (model.start_length(), p.ramp.start_pressures());
        Ok((model, p.cylinder.starting_at(length, &p.rest.oil, pressures, p.swing())?, p.rest.contacts))
    });
    case.trace_columns.extend(words(
        "contact_state_right_wedge contact_state_left_wedge contact_state_disc_ledge contact_state_disc_floor \
         sticking_contacts",
    ));
    case
}

impl WithFriction {
    /// The command from its start `t₀` on for a number of whole swings, drawn in straight pieces: within 1.3e-6 of the
    /// amplitude.
    fn swing(&self) -> Spool {
        const PIECES: u32 = 2000;
        let points = (0..=self.spool_swings * PIECES).map(|piece| {
            let turns = f64::from(piece) / f64::from(PIECES);
            let command = self.spool_centre - self.spool_amplitude * libm::sin(std::f64::consts::TAU * turns);
            (self.spool_swing_start_s + turns / self.spool_frequency_hz, command)
        });
        Spool::new(points.collect())
    }
}

/// Held against the ramp on three contacts by a cylinder that pulls at rest, until the spool is reversed, its force
/// passes through zero and the disc leaves the ramp.
pub(super) fn reversal() -> Case {
    let about = "Wedge box held against its ramp on three contacts, until the spool is reversed and one opens";
    let text = [
        "Wedge box held against its ramp",
        "A cylinder holds the box on three contacts, then reverses: one of them opens.",
    ];
    of_the_paper(1.0, ["wedge-box-reversal", about], text, |p: &AgainstRamp| {
        let model = WedgeBox::against_ramp(p.body.of_the_paper(&p.rest))?;
        let (pressures, hold) = p.cylinder.equilibrium(&p.rest.oil, -p.holding_pull_n)?;
        let (start, end) = (named!(p.reversal_start_s), named!(p.reversal_end_s));
        let spool = hydraulics::spool(&[(start.0, start.1, hold), (end.0, end.1, p.ramp.spool_final)])?;
        let cylinder = p.cylinder.starting_at(model.start_length(), &p.rest.oil, pressures, spool)?;
        Ok((model, cylinder, p.rest.contacts))
    })
}

parameters! {
    /// What pushes a box on more wedges or discs than that of the paper.
    struct Pushed from "as in the wedge box" {
        gravity_m_s2: f64 = 9.81, NotNegative, "gravity".from("standard");
        cylinder: Cylinder;
        ramp: Ramp;
        oil: Oil;
        contacts: Contacts with |set| set
            .only(&["stabilisation", "restitution", "contact_compliance_m_n", "contact_damping_n_s_m"])
            .source("restitution", "plastic, as in the paper");
    }
}
parameters! {
    /// A box with a disc on either side.
    struct TwoLedges from "as in the wedge box" {
        body: Body with |set| set
            .from("as in the wedge box")
            .only(&["box_mass_kg", "box_width_m", "box_height_m", "wedge_tip_x_m", "wedge_tip_y_m", "disc_mass_kg", "disc_radius_m", "disc_pin_x_m", "disc_pin_y_m", "ramp_slope", "attachment_x_m", "attachment_y_m", "ground_pin_x_m"])
            .about("disc_mass_kg", "mass of each disc").about("disc_radius_m", "radius of each disc")
            .default("disc_pin_x_m", 0.8).within("disc_pin_x_m", Positive)
            .about("disc_pin_x_m", "joint of the right disc in the box frame, x (the left one is mirrored)")
            .source("disc_pin_x_m", "ours").about("disc_pin_y_m", "joints of the discs in the box frame, y")
            .about("ramp_slope", "fall over run of both ramps");
        left_ledge_height_m: f64 = 0.06, NotNegative, "height of the left disc's ledge above the floor";
        right_ledge_height_m: f64 = 0.06, NotNegative, "height of the right disc's ledge above the floor".from("ours");
        left_ledge_lead_m: f64 = 0.1, NotNegative, "distance of the left ledge's corner ahead of its disc".gap();
        right_ledge_lead_m: f64 = 0.2, NotNegative, "distance of the right ledge's corner ahead of its disc".from("ours").gap();
        pushed: Pushed;
    }
}
parameters! {
    /// A box on many wedges.
    struct ManyWedges from "ours" {
        supports: u32 = 8, 2..=64, "number n of wedges";
        height_spread_m: f64 = 0.0, NotNegative, "largest distance of a wedge tip above that of the rightmost";
        washboard_height_m: f64 = 0.0, NotNegative, "height of the waves of the wedges' floor";
        washboard_length_m: f64 = 0.15, Positive, "length of the waves";
        washboard_lead_m: f64 = 0.05, NotNegative, "distance of the first wave ahead of the right wedge".gap();
        body: Body with |set| set
            .from("as in the wedge box")
            .about("wedge_tip_x_m", "rightmost wedge tip in the box frame, x (the leftmost is mirrored)")
            .about("wedge_tip_y_m", "rightmost wedge tip in the box frame, y");
        pushed: Pushed;
    }
}

impl Pushed {
    /// This box, and what pushes it.
    fn parts(&self, geometry: WedgeBoxGeometry) -> Result<Parts> {
        let model = WedgeBox::new(geometry)?;
        let pressures = self.ramp.start_pressures();
        let cylinder = self.cylinder.starting_at(model.start_length(), &self.oil, pressures, self.ramp.spool()?)?;
        Ok((model, cylinder, self.contacts))
    }
}

/// A disc on either side, each on a ledge of its own: two descents, two touch-downs.
pub(super) fn two_ledges() -> Case {
    let about = "Wedge box with a disc on a ledge at either side (two descents, repeated over-constraint)";
    let text = ["Wedge box on two ledges", "A box with a disc at either side comes down twice."];
    let parts = |p: &TwoLedges| {
        let (pin_x, radius) = (p.body.disc_pin_x_m, p.body.disc_radius_m);
        if pin_x < radius {
            let expected = format!("at least the radius {radius} m, or the discs would overlap");
            return Err(Error::invalid("disc_pin_x_m", pin_x, expected));
        }
        let discs = vec![
            p.body.disc(-pin_x, p.left_ledge_height_m, p.left_ledge_lead_m),
            p.body.disc(pin_x, p.right_ledge_height_m, p.right_ledge_lead_m),
        ];
        p.pushed.parts(WedgeBoxGeometry { discs, ..p.body.without_disc(p.pushed.gravity_m_s2) })
    };
    Case {
        trace_columns: hydraulics::trace_columns(
            "box_x_m box_y_m box_angle_rad",
            "gap_right_support_m gap_left_support_m gap_left_disc_ledge_m gap_left_disc_floor_m gap_right_disc_ledge_m \
             gap_right_disc_floor_m closed_contacts rank_h_uu",
        ),
        drawing_columns: words("contact_force_right_support_n contact_force_left_support_n"),
        ..entry(["wedge-box-two-ledges", about], text, times(3.0, 5e-3, 5e-5, [1e-4, 1e-4]), parts)
    }
}

/// On 2 to 64 wedges in one plane or off it, on a flat or a wavy floor: redundant contacts by the dozen.
pub(super) fn n_wedge_box() -> Case {
    let about = "Wedge box on n coplanar or uneven wedges, on a flat or a wavy floor (redundant contacts)";
    let text = ["Wedge box on eight wedges", "Eight wedges touch down where two would do: redundant contacts."];
    let parts = |p: &ManyWedges| {
        p.pushed.parts(WedgeBoxGeometry {
            wedges: p.tips(),
            washboard: [p.washboard_height_m, p.washboard_length_m],
            washboard_lead: p.washboard_lead_m,
            ..p.body.geometry(p.pushed.gravity_m_s2)
        })
    };
    Case {
        trace_columns: hydraulics::trace_columns(
            "box_x_m box_y_m box_angle_rad",
            "gap_right_support_m gap_left_support_m gap_disc_ledge_m gap_disc_floor_m gap_supports_least_m closed_contacts \
             rank_h_uu",
        ),
        drawing_columns: words("contact_force_sum_n"),
        ..entry(["n-wedge-box", about], text, times(2.5, 5e-3, 5e-5, [1e-4, 1e-4]), parts)
    }
}

const GOLDEN: f64 = 0.618_033_988_749_894_9;

impl ManyWedges {
    /// Tips of the wedges: the rightmost, the leftmost, then those between from right to left.
    fn tips(&self) -> Vec<[f64; 2]> {
        let last = self.supports as usize - 1;
        let [x, y, spread] = [self.body.wedge_tip_x_m, self.body.wedge_tip_y_m, self.height_spread_m];
        // Multiples of the golden ratio fill an interval evenly whatever their number.
        let tip = |k: usize| [x - 2.0 * x * k as f64 / last as f64, y + spread * (k as f64 * GOLDEN).fract()];
        [0, last].into_iter().chain(1..last).map(tip).collect()
    }
}
