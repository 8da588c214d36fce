//! The wedge box again, from scratch: minimal coordinates, contacts bilateral while a phase lasts, events located,
//! plastic impacts by projection. The numbers are those of the case's table.

use super::plain_wedge_box::{
    ATTACHMENT, FRICTION, GRAVITY, LEDGE_HEIGHT, MASS, OTHER_TIP, PIN, PISTON_AREA, RADIUS, TIP, pressure_rates,
};
use nalgebra::{Matrix3, Rotation2, SVector, Vector2, Vector3};

const BOX_MASS: f64 = MASS[0];
const DISC_MASS: f64 = MASS[3];
const SLOPE: f64 = 0.15;

/// `x, y, θ, ẋ, ẏ, ω, p₁, p₂` of the box (the disc's centre sits on its pin, its spin stays zero) and the cylinder.
type State = SVector<f64, 8>;

#[derive(Debug, Clone, Copy, PartialEq)]
#[rustfmt::skip]
enum Contact { Right, Left, Flat, Vertex, Ramp }
use Contact::{Flat, Left, Ramp, Right, Vertex};

/// The state at one time.
pub struct Sample {
    /// x, y (m) and θ (rad) of the box.
    pub pose: [f64; 3],
    /// Length of the actuator, m.
    pub length: f64,
    /// Its force, N.
    pub force: f64,
}

/// A solution with its events.
#[derive(Default)]
pub struct Run {
    /// In order of time.
    pub samples: Vec<Sample>,
    /// Time and kind of each event.
    pub events: Vec<(f64, String)>,
    /// When the left wedge lands first, s.
    pub touch_down: f64,
    /// Kinetic energy lost in all impacts together, J.
    pub lost_in_all: f64,
    /// Jump of the actuator's force in each impact, N.
    pub jumps: Vec<f64>,
    /// Largest gap or joint velocity of a contact that should be closed, m and m/s.
    pub drift: f64,
}

struct Machine {
    corner: Vector2<f64>,
    ground: Vector2<f64>,
    start_length: f64,
}

fn turned(point: Vector2<f64>, angle: f64) -> Vector2<f64> {
    Rotation2::new(angle) * point
}

fn velocity(s: &State) -> Vector3<f64> {
    s.fixed_rows::<3>(3).into_owned()
}

/// From the corner of the ledge to the disc's centre.
fn off_corner(machine: &Machine, s: &State) -> Vector2<f64> {
    Vector2::new(s[0], s[1]) + turned(PIN, s[2]) - machine.corner
}

/// `(p, row, bias)` of a contact: gap, Jacobian, acceleration at zero acceleration of the coordinates.
fn contact(machine: &Machine, kind: Contact, s: &State) -> (f64, Vector3<f64>, f64) {
    let omega2 = s[5] * s[5];
    let row = |n: Vector2<f64>, arm: Vector2<f64>| Vector3::new(n.x, n.y, arm.perp(&n));
    if let Right | Left = kind {
        let arm = turned(if kind == Right { TIP } else { OTHER_TIP }, s[2]);
        return (s[1] + arm.y, row(Vector2::y(), arm), -omega2 * arm.y);
    }
    let (arm, off) = (turned(PIN, s[2]), off_corner(machine, s));
    let (n, height, curvature) = match kind {
        Flat => (Vector2::y(), off.y, 0.0),
        Ramp => {
            let n = Vector2::new(SLOPE, 1.0).normalize();
            (n, off.dot(&n), 0.0)
        }
        _ => (off.normalize(), off.norm(), 1.0 / off.norm()),
    };
    let along = Vector2::new(s[3] - arm.y * s[5], s[4] + arm.x * s[5]).perp(&n);
    (height - RADIUS, row(n, arm), -omega2 * n.dot(&arm) + curvature * along * along)
}

/// Which part of the ground the disc is over: signs of the distances from the two borders of the vertex region.
fn region(machine: &Machine, s: &State) -> Contact {
    let off = off_corner(machine, s);
    if off.x <= 0.0 {
        Flat
    } else if off.x - SLOPE * off.y < 0.0 {
        Vertex
    } else {
        Ramp
    }
}

fn mass_matrix(s: &State) -> Matrix3<f64> {
    let (r, m) = (turned(PIN, s[2]), DISC_MASS);
    let [both, about] = [BOX_MASS + m, MASS[2] + m * r.norm_squared()];
    Matrix3::new(both, 0.0, -m * r.y, 0.0, both, m * r.x, -m * r.y, m * r.x, about)
}

fn kinetic_energy(s: &State) -> f64 {
    0.5 * velocity(s).dot(&(mass_matrix(s) * velocity(s)))
}

/// Length, direction in the coordinates, and force of the actuator.
fn actuator(machine: &Machine, s: &State) -> (f64, Vector3<f64>, f64) {
    let arm = turned(ATTACHMENT, s[2]);
    let from = Vector2::new(s[0], s[1]) + arm - machine.ground;
    let n = from.normalize();
    let direction = Vector3::new(n.x, n.y, arm.perp(&n));
    (from.norm(), direction, (s[7] - s[6]) * PISTON_AREA - FRICTION * direction.dot(&velocity(s)))
}

/// Solves `M x − Σ rowₖ fₖ = load`, `rowₖ x = −share biasₖ` for x and what the contacts do; none where they depend on
/// each other.
fn held(
    machine: &Machine,
    s: &State,
    closed: &[Contact],
    load: Vector3<f64>,
    share: f64,
) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let inverse = mass_matrix(s).try_inverse()?;
    let free = inverse * load;
    let (mut rows, mut a, mut b) = (Matrix3::zeros(), Matrix3::identity(), Vector3::zeros());
    for (k, &kind) in closed.iter().enumerate() {
        let (_, row, bias) = contact(machine, kind, s);
        rows.set_row(k, &row.transpose());
        b[k] = -share * bias - row.dot(&free);
    }
    let effect = inverse * rows.transpose();
    let n = closed.len();
    a.view_mut((0, 0), (n, n)).copy_from(&(rows * effect).view((0, 0), (n, n)));
    // Each entry some 1/100 kg⁻¹.
    let independent = a.determinant() > 1e-9 * a.diagonal().product();
    let f = a.try_inverse().filter(|_| independent)? * b;
    Some((free + effect * f, f))
}

/// Accelerations and contact forces with the contacts of `closed` held.
fn accelerations(machine: &Machine, s: &State, closed: &[Contact]) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let (_, direction, force) = actuator(machine, s);
    let r = turned(PIN, s[2]);
    // Weight and centrifugal force of the disc, at the pin.
    let at_pin = DISC_MASS * (s[5] * s[5] * r - Vector2::new(0.0, GRAVITY));
    let load = Vector3::new(at_pin.x, at_pin.y - BOX_MASS * GRAVITY, r.perp(&at_pin)) + force * direction;
    held(machine, s, closed, load, 1.0)
}

fn rate(machine: &Machine, t: f64, s: &State, closed: &[Contact]) -> State {
    let (a, _) = accelerations(machine, s, closed).expect("contacts of a phase are independent");
    let (length, direction, _) = actuator(machine, s);
    let [p1, p2] = pressure_rates(t, [s[6], s[7]], length - machine.start_length, direction.dot(&velocity(s)));
    State::from([s[3], s[4], s[5], a.x, a.y, a.z, p1, p2])
}

fn runge_kutta(machine: &Machine, t: f64, s: &State, closed: &[Contact], h: f64) -> State {
    let k1 = rate(machine, t, s, closed);
    let k2 = rate(machine, t + 0.5 * h, &(s + 0.5 * h * k1), closed);
    let k3 = rate(machine, t + 0.5 * h, &(s + 0.5 * h * k2), closed);
    let k4 = rate(machine, t + h, &(s + h * k3), closed);
    s + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
}

fn subsets(of: &[Contact]) -> impl Iterator<Item = Vec<Contact>> + '_ {
    (0..1 << of.len()).map(move |bits: usize| (0..of.len()).filter(|i| bits >> i & 1 == 1).map(|i| of[i]).collect())
}

/// Plastic impact of the contacts `touching`: the projection whose impulses push and whose other contacts part.
fn impact(machine: &Machine, s: &State, touching: &[Contact]) -> State {
    for set in subsets(touching) {
        let Some((v, p)) = held(machine, s, &set, mass_matrix(s) * velocity(s), 0.0) else { continue };
        let parts = touching.iter().all(|&kind| contact(machine, kind, s).1.dot(&v) >= -1e-12);
        if parts && p.iter().take(set.len()).all(|p| *p >= 0.0) {
            let mut after = *s;
            after.fixed_rows_mut::<3>(3).copy_from(&v);
            return after;
        }
    }
    panic!("no plastic impact found");
}

/// The contacts that stay closed: of those at rest, the set whose forces push and whose others accelerate away.
fn active_set(machine: &Machine, s: &State, touching: &[Contact]) -> Vec<Contact> {
    let rests = |kind: &Contact| contact(machine, *kind, s).1.dot(&velocity(s)).abs() < 1e-9;
    let resting: Vec<Contact> = touching.iter().copied().filter(rests).collect();
    for set in subsets(&resting) {
        let Some((a, force)) = accelerations(machine, s, &set) else { continue };
        let parts = resting.iter().filter(|kind| !set.contains(kind)).all(|&kind| {
            let (_, row, bias) = contact(machine, kind, s);
            row.dot(&a) + bias >= 0.0
        });
        if parts && force.iter().take(set.len()).all(|force| *force >= 0.0) {
            return set;
        }
    }
    panic!("no consistent set of contacts");
}

#[derive(Debug, Clone, PartialEq)]
enum Event {
    Region(Contact),
    Closes(Contact),
    Opens(Contact),
}

/// The first thing wrong with `after` as a continuation of a phase.
fn event(machine: &Machine, after: &State, closed: &[Contact], disc: Contact) -> Option<Event> {
    let (_, force) = accelerations(machine, after, closed).expect("contacts of a phase are independent");
    let over = region(machine, after);
    if over != disc {
        return Some(Event::Region(over));
    }
    let opens = closed.iter().zip(&force).find(|(_, force)| **force < 0.0).map(|(&kind, _)| Event::Opens(kind));
    let closes = [Right, Left, over]
        .into_iter()
        .find(|kind| {
            let (gap, row, _) = contact(machine, *kind, after);
            !closed.contains(kind) && gap < -1e-13 && row.dot(&velocity(after)) < 0.0
        })
        .map(Event::Closes);
    opens.or(closes)
}

/// Solves `duration` (s) by Runge and Kutta's method of order four with steps of `h` (s), and keeps every so-manieth
/// state.
///
/// # Panics
/// Where no set of contacts is consistent, or events do not end.
pub fn run(h: f64, duration: f64, every: usize) -> Run {
    let mut angle = 0.0_f64;
    for _ in 0..20 {
        let across = turned(PIN - TIP, angle);
        angle -= (across.y - LEDGE_HEIGHT - RADIUS) / across.x;
    }
    let y = -turned(TIP, angle).y;
    let corner = Vector2::new(turned(PIN, angle).x + 0.1, LEDGE_HEIGHT);
    let ground = Vector2::new(-3.0, y + turned(ATTACHMENT, angle).y);
    let mut s = State::from([0.0, y, angle, 0.0, 0.0, 0.0, 3.85e6, 3.85e6]);
    let mut machine = Machine { corner, ground, start_length: 0.0 };
    machine.start_length = actuator(&machine, &s).0;
    let (mut disc, mut closed) = (Flat, vec![Right, Flat]);
    let mut out = Run { touch_down: f64::NAN, ..Run::default() };
    let steps = (duration / h).round() as usize;
    for step in 0..=steps {
        if step % every == 0 {
            let (length, _, force) = actuator(&machine, &s);
            out.samples.push(Sample { pose: [s[0], s[1], s[2]], length, force });
        }
        // One step of the grid, in parts where events lie inside.
        let (start, mut done) = (step as f64 * h, 0.0);
        while done < h {
            let attempt = |part: f64| runge_kutta(&machine, start + done, &s, &closed, part);
            let whole = attempt(h - done);
            if event(&machine, &whole, &closed, disc).is_none() {
                s = whole;
                break;
            }
            let (mut before, mut after) = (0.0, h - done);
            while after - before > 1e-17 {
                let middle = 0.5 * (before + after);
                if middle <= before || middle >= after {
                    break;
                }
                match event(&machine, &attempt(middle), &closed, disc) {
                    None => before = middle,
                    Some(_) => after = middle,
                }
            }
            let at = attempt(after);
            let what = event(&machine, &at, &closed, disc).expect("the bracket holds an event");
            s = at;
            done += after;
            out.events.push((start + done, format!("{what:?}")));
            assert!(out.events.len() < 100, "events without end: {:?}", &out.events[80..]);
            match what {
                Event::Region(new) => {
                    closed.iter_mut().filter(|kind| **kind == disc).for_each(|kind| *kind = new);
                    disc = new;
                }
                Event::Opens(kind) => {
                    let kept = active_set(&machine, &s, &closed);
                    assert!(!kept.contains(&kind), "{kind:?} must open");
                    closed = kept;
                }
                Event::Closes(kind) => {
                    let mut touching = closed.clone();
                    touching.push(kind);
                    let (before, force) = (kinetic_energy(&s), actuator(&machine, &s).2);
                    s = impact(&machine, &s, &touching);
                    closed = active_set(&machine, &s, &touching);
                    out.events.push((start + done, format!("then {closed:?}")));
                    out.lost_in_all += before - kinetic_energy(&s);
                    out.jumps.push(actuator(&machine, &s).2 - force);
                    if kind == Left && out.touch_down.is_nan() {
                        out.touch_down = start + done;
                    }
                }
            }
        }
        for &kind in &closed {
            let (gap, row, _) = contact(&machine, kind, &s);
            out.drift = out.drift.max(gap.abs()).max(row.dot(&velocity(&s)).abs());
        }
    }
    out
}
