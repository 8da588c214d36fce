//! The wedge box against closed forms: pose, statics, effective mass, Jacobians; and the facts of its manoeuvre.

use crate::support::*;
use nalgebra::{Rotation2, Vector2};
use rimbench::cosim::Subsystem;
use rimbench::interface_model::{Condensation, condense};
use rimbench::mechanics::{ContactLaw, MechanicalModel};
use rimbench::models::{Ledge, LedgeDisc, WedgeBox, WedgeBoxGeometry};

const RIGHT: usize = 0;
const LEFT: usize = 1;
const DISC_LEDGE: usize = 2;

/// The wedge box at its defaults, and where it starts.
fn usual() -> (WedgeBoxGeometry, WedgeBox, Vec<f64>) {
    let model = WedgeBox::new(wedge_box_geometry()).unwrap();
    (model.geometry().clone(), model.clone(), model.initial_state().0)
}

/// A pose `(x, y, θ)` of the box as coordinates of box and disc, the disc on its pin.
fn pose(g: &WedgeBoxGeometry, x: f64, y: f64, angle: f64) -> [f64; 6] {
    let pin = Rotation2::new(angle) * Vector2::from(g.discs[0].pin);
    [x, y, angle, x + pin.x, y + pin.y, 0.0]
}

/// The pose with the right wedge's tip on the floor at an angle.
fn on_right_wedge(g: &WedgeBoxGeometry, x: f64, angle: f64) -> [f64; 6] {
    pose(g, x, -(Rotation2::new(angle) * Vector2::from(g.wedges[0])).y, angle)
}

fn effective_mass(model: &mut WedgeBox, q: &[f64; 6], closed: &[usize]) -> Condensation {
    let eq3 = linearise(model, q, &[0.0; 6]);
    for &contact in closed {
        let gap = eq3.unilateral.position[contact];
        assert!(gap.abs() < 1e-12, "contact {contact} is not closed: {gap}");
    }
    let (_, reduced) = reduce(&eq3, &[0.0; 6], 1e-3, 0.0);
    let mut out = Condensation::new(4, 1);
    condense(&reduced, closed, &mut out);
    out
}

/// Unit vector of the actuator and the arm of its end on the box.
fn actuator(g: &WedgeBoxGeometry, start_height: f64, q: &[f64; 6]) -> (Vector2<f64>, Vector2<f64>) {
    let arm = Rotation2::new(q[2]) * Vector2::from(g.attachment);
    ((Vector2::new(q[0], q[1]) + arm - Vector2::new(g.ground_pin_x, start_height)).normalize(), arm)
}

/// Height of the actuator's fixed end: that of the attachment at the start.
fn start_height(g: &WedgeBoxGeometry, start: &[f64]) -> f64 {
    start[1] + (Rotation2::new(start[2]) * Vector2::from(g.attachment)).y
}

fn corner_x(g: &WedgeBoxGeometry, start: &[f64]) -> f64 {
    start[3] + g.discs[0].ledge_lead
}

#[test]
fn the_box_must_start_in_the_pose_that_rests_on_wedge_and_ledge() {
    let g = wedge_box_geometry();
    let mut model = WedgeBox::new(g.clone()).unwrap();
    let (q, v) = model.initial_state();
    // −1.2 sin θ + 0.21 cos θ = 0.26, solved here by Newton's method and not by inverse functions.
    let mut angle = 0.0_f64;
    for _ in 0..20 {
        let residual = -1.2 * angle.sin() + 0.21 * angle.cos() - 0.26;
        angle -= residual / (-1.2 * angle.cos() - 0.21 * angle.sin());
    }
    assert!((q[2] - angle).abs() < 4.0 * f64::EPSILON);
    // As published: −2.3968° (four digits), left wedge 33 mm up, actuator horizontal.
    assert!((q[2].to_degrees() + 2.3968).abs() < 5e-5, "{}", q[2].to_degrees());
    let eq3 = linearise(&mut model, &q, &v);
    let gap = &eq3.unilateral.position;
    assert!(gap[RIGHT].abs() < 1e-15 && gap[DISC_LEDGE].abs() < 1e-15, "{gap:?}");
    // The tips are 0.8 m apart: the left one is 0.8 sin 2.3968° up.
    approx::assert_relative_eq!(gap[LEFT], -0.8 * angle.sin(), epsilon = 1e-15);
    assert!((gap[LEFT] - 0.033).abs() < 5e-4, "{}", gap[LEFT]);
    assert!(v.iter().all(|v| *v == 0.0));
    assert_eq!(eq3.interface.row(0)[..2], [1.0, 0.0], "the actuator must start horizontal");
    assert!(eq3.bilateral.position.iter().all(|error| error.abs() < 1e-15));
}

#[test]
fn on_the_ledge_the_actuator_must_feel_box_and_disc_as_one_mass() {
    let (g, mut model, start) = usual();
    // Tip and disc both keep their height, at different arms: ẏ = ω = 0, everything translates.
    for forward in [0.0, 0.03, 0.09] {
        let q = pose(&g, start[0] + forward, start[1], start[2]);
        let found = effective_mass(&mut model, &q, &[RIGHT, DISC_LEDGE]);
        // The sums behind it are of order 1/m with condition ≈ (1.2 m)² m / I ≈ 10.
        approx::assert_relative_eq!(found.effective_mass, 250.0, max_relative = 1e-13);
        assert_eq!(found.rank, 2);
    }
}

#[test]
fn on_two_wedges_the_actuator_must_feel_the_mass_along_its_own_direction() {
    let (g, mut model, start) = usual();
    let height = start_height(&g, &start);
    for x in [0.45, 0.66] {
        let q = pose(&g, x, 0.4, 0.0);
        // Two wedges hold ẏ and ω. The interface velocity is d_x ẋ: T = ½ 250 ẋ² = ½ (250 / d_x²) w².
        let (d, _) = actuator(&g, height, &q);
        let found = effective_mass(&mut model, &q, &[RIGHT, LEFT]);
        approx::assert_relative_eq!(found.effective_mass, 250.0 / (d.x * d.x), max_relative = 1e-13);
        assert!(found.effective_mass > 250.01, "the attachment has risen, the actuator is no longer horizontal");
    }
}

/// Effective mass with the right wedge on the floor and the disc on the ramp, in minimal coordinates.
///
/// ```text
/// tip:   ẏ = −r_t.x ω            disc: u = (ẋ − r_p.y ω, ẏ + r_p.x ω),  (s, 1)·u = 0
/// ⇒      ω = −s ẋ / (r_p.x − r_t.x − s r_p.y)
/// 2T = m_b (ẋ² + ẏ²) + I ω² + m_d u²      w = d·(ẋ − r_a.y ω, ẏ + r_a.x ω)      m_eff = 2T / w²
/// ```
fn mass_on_the_ramp(g: &WedgeBoxGeometry, height: f64, q: &[f64; 6]) -> f64 {
    let turn = Rotation2::new(q[2]);
    let (tip, pin) = (turn * Vector2::from(g.wedges[0]), turn * Vector2::from(g.discs[0].pin));
    let (d, arm) = actuator(g, height, q);
    let omega = -g.discs[0].ramp_slope / (pin.x - tip.x - g.discs[0].ramp_slope * pin.y);
    let (x, y) = (1.0, -tip.x * omega);
    let disc = Vector2::new(x - pin.y * omega, y + pin.x * omega);
    let inertia = g.box_inertia();
    let twice_t = g.box_mass * (x * x + y * y) + inertia * omega * omega + g.discs[0].mass * disc.norm_squared();
    twice_t / d.dot(&Vector2::new(x - arm.y * omega, y + arm.x * omega)).powi(2)
}

/// The pose at `angle` with the right wedge on the floor and the disc on the ramp.
fn on_the_ramp(g: &WedgeBoxGeometry, corner_x: f64, angle: f64) -> [f64; 6] {
    let down = Vector2::new(1.0, -g.discs[0].ramp_slope).normalize();
    let normal = Vector2::new(-down.y, down.x);
    let at_zero = on_right_wedge(g, 0.0, angle);
    // (c − corner)·n = R with c.x = at_zero.x + x.
    let above =
        Vector2::new(at_zero[3] - corner_x, at_zero[4] - g.discs[0].ledge_height).dot(&normal) - g.discs[0].radius;
    on_right_wedge(g, -above / normal.x, angle)
}

#[test]
fn on_the_ramp_the_effective_mass_must_be_that_of_the_minimal_coordinates() {
    let (g, mut model, start) = usual();
    let height = start_height(&g, &start);
    for angle in [-0.037, -0.02575, -0.01, -0.001] {
        let q = on_the_ramp(&g, corner_x(&g, &start), angle);
        let found = effective_mass(&mut model, &q, &[RIGHT, DISC_LEDGE]);
        approx::assert_relative_eq!(found.effective_mass, mass_on_the_ramp(&g, height, &q), max_relative = 1e-13);
    }
    // At t = 1 s the box stands at θ = −0.0258 rad (from the reference): 275.6 kg.
    let at_one_second = on_the_ramp(&g, corner_x(&g, &start), -0.02575);
    assert!((mass_on_the_ramp(&g, height, &at_one_second) - 275.6).abs() < 0.1);
}

#[test]
fn three_contacts_with_the_disc_on_the_ramp_must_lock_the_actuator() {
    let (g, mut model, start) = usual();
    let q = on_the_ramp(&g, corner_x(&g, &start), 0.0);
    let locked = effective_mass(&mut model, &q, &[RIGHT, LEFT, DISC_LEDGE]);
    assert_eq!((locked.effective_mass, locked.rank), (f64::INFINITY, 3));
    for two in [[RIGHT, LEFT], [RIGHT, DISC_LEDGE], [LEFT, DISC_LEDGE]] {
        let mass = effective_mass(&mut model, &q, &two).effective_mass;
        assert!(mass > 0.0 && mass < 500.0, "contacts {two:?} alone must not lock: {mass}");
    }
    // On the flat ledge three contacts are redundant and lock nothing: a box that stood level with a disc on a ledge.
    let level = WedgeBoxGeometry { discs: vec![LedgeDisc { ledge_height: 0.01, ..g.discs[0] }], ..g.clone() };
    let mut flat = WedgeBox::new(level.clone()).unwrap();
    let found = effective_mass(&mut flat, &pose(&level, 0.0, 0.4, 0.0), &[RIGHT, LEFT, DISC_LEDGE]);
    assert_eq!(found.rank, 2);
    approx::assert_relative_eq!(found.effective_mass, 250.0, max_relative = 1e-13);
}

#[test]
fn at_rest_the_contacts_must_carry_the_weight_with_the_right_moment() {
    let (g, _, start) = usual();
    let mut mechanics = wedge_box_mechanics(PLASTIC);
    let h = 1e-3;
    mechanics.step(0.0, &[0.0], h).unwrap();
    let force: Vec<f64> = mechanics.contact_impulses().iter().map(|impulse| impulse / h).collect();
    let tip_x = start[0] + (Rotation2::new(start[2]) * Vector2::from(g.wedges[0])).x;
    // Moments about the right tip: N_disc (x_d − x_t) = g (m_box (x − x_t) + m_disc (x_d − x_t)).
    let disc = g.gravity * (g.discs[0].mass + g.box_mass * (start[0] - tip_x) / (start[3] - tip_x));
    let right = g.gravity * (g.box_mass + g.discs[0].mass) - disc;
    for (found, wanted) in force.iter().zip([right, 0.0, disc, 0.0]) {
        approx::assert_abs_diff_eq!(found, &wanted, epsilon = 1e-10);
    }
    for step in 1..1000 {
        mechanics.step(step as f64 * h, &[0.0], h).unwrap();
    }
    // Nothing pushes, nothing moves. Each step may round the balance of 10 m/s² × 1 ms by ε; they add up over 1 s.
    let worst = mechanics.position().iter().zip(&start).map(|(q, start)| (q - start).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-12, "moved by {worst} m");
}

#[test]
fn the_ground_under_the_disc_must_be_plane_vertex_plane() {
    let ledge = Ledge::new(2.0, 0.06, 0.15);
    let (radius, normal) = (0.2, Vector2::new(0.15, 1.0).normalize());
    for (centre, gap, wanted) in [
        (Vector2::new(1.7, 0.30), 0.04, Vector2::new(0.0, 1.0)),
        (Vector2::new(2.0, 0.26), 0.0, Vector2::new(0.0, 1.0)),
        // 3-4-5 triangle, but within the vertex region only for directions between (0, 1) and (0.148, 0.989).
        (
            Vector2::new(2.0, 0.06) + 0.25 * Vector2::new(0.08, 0.9968).normalize(),
            0.05,
            Vector2::new(0.08, 0.9968).normalize(),
        ),
        (Vector2::new(2.0, 0.06) + 0.5 * Vector2::new(1.0, -0.15).normalize() + 0.19 * normal, -0.01, normal),
    ] {
        let contact = ledge.contact(centre, radius);
        approx::assert_abs_diff_eq!(contact.gap, gap, epsilon = 1e-15);
        approx::assert_abs_diff_eq!(contact.normal, wanted, epsilon = 1e-14);
    }
}

#[test]
fn an_impossible_geometry_must_be_refused_with_its_numbers() {
    let g = wedge_box_geometry();
    let refused = |geometry: WedgeBoxGeometry| WedgeBox::new(geometry).unwrap_err().to_string();
    let on_ledge =
        |ledge_height| WedgeBoxGeometry { discs: vec![LedgeDisc { ledge_height, ..g.discs[0] }], ..g.clone() };
    // Without a ledge the box leans to the left, on its left wedge and the disc: −0.4 sin θ + 0.21 cos θ = 0.2, and the
    // right tip is 0.8 sin θ up.
    let (start, _) = WedgeBox::new(on_ledge(0.0)).unwrap().initial_state();
    assert!((-0.4 * start[2].sin() + 0.21 * start[2].cos() - 0.2).abs() < 1e-15 && start[2] > 0.0, "{start:?}");
    approx::assert_relative_eq!(start[1], 0.4 * start[2].sin() + 0.4 * start[2].cos(), epsilon = 1e-15);
    let (start, _) = WedgeBox::new(g.clone()).unwrap().initial_state();
    let attachment_x = start[0] + (Rotation2::new(start[2]) * Vector2::from(g.attachment)).x;
    let short = refused(WedgeBoxGeometry { ground_pin_x: attachment_x, ..g.clone() });
    assert!(short.contains("no length"), "{short}");
}

#[test]
fn contacts_that_are_never_touched_must_not_matter() {
    // The floor below the disc is 9 cm away at its nearest: with it or with a floor law of another γ, the same run.
    let mut plain = wedge_box_mechanics(PLASTIC);
    let mut stabilised = wedge_box_mechanics(ContactLaw { stabilisation: 1.0, ..PLASTIC });
    for step in 0..100 {
        plain.step(step as f64 * 1e-3, &[500.0], 1e-3).unwrap();
        stabilised.step(step as f64 * 1e-3, &[500.0], 1e-3).unwrap();
    }
    let difference = max_difference(plain.position(), stabilised.position());
    assert!(difference < 1e-13, "{difference}");
    assert!(plain.position()[0] > 0.005, "it must have moved");
}
