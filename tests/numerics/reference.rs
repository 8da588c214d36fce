//! Why the monolithic reference can be trusted: its order, its agreement with co-simulation at a tiny macro step, and an
//! independent route that shares no line of code with it.

use crate::support::*;

/// The wedge box again, from scratch: minimal coordinates, contacts bilateral while a phase lasts, events located, plastic
/// impacts by projection. Nothing here comes from the crate; the numbers are those of the case's table.
mod event_driven {
    use crate::plain_wedge_box::{
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

    pub struct Sample {
        pub pose: [f64; 3],
        pub length: f64,
        pub force: f64,
    }

    #[derive(Default)]
    pub struct Run {
        pub samples: Vec<Sample>,
        /// Time and kind of each event.
        pub events: Vec<(f64, String)>,
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

    /// Solves `M x − Σ rowₖ fₖ = load`, `rowₖ x = −share biasₖ` for x and what the contacts do; none where they depend on each other.
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
}

use event_driven::{Run, Sample};
use std::sync::OnceLock;

/// The independent route at 10 µs, sampled every 50 µs; computed once.
fn independent() -> &'static Run {
    static RUN: OnceLock<Run> = OnceLock::new();
    RUN.get_or_init(|| event_driven::run(1e-5, 2.5, 5))
}

fn pick(run: &Run, what: impl Fn(&Sample) -> f64) -> Vec<f64> {
    run.samples.iter().map(what).collect()
}

/// The monolithic reference sampled every 50 µs, at h, h/2, h/4.
struct Level {
    h: f64,
    force: Vec<f64>,
    length: Vec<f64>,
    touch_down: f64,
}

fn levels() -> &'static [Level; 3] {
    static LEVELS: OnceLock<[Level; 3]> = OnceLock::new();
    LEVELS.get_or_init(|| {
        [2.5e-5, 1.25e-5, 6.25e-6].map(|h| {
            let gap = wedge_box_case().recorded_columns().iter().position(|name| name == "gap_left_wedge_m").unwrap();
            let mut touch_down = f64::NAN;
            let trajectory = wedge_box_monolithic(h, 5e-5, 2.5, |t, row| {
                // The wedge lands on the floor to round-off; a step earlier it is 30 mm/s × h ≥ 0.2 µm above it.
                if touch_down.is_nan() && row[gap] < 1e-9 {
                    touch_down = t;
                }
            });
            Level {
                h,
                force: column(&trajectory, "actuator_force_n"),
                length: column(&trajectory, "actuator_length_m"),
                touch_down,
            }
        })
    })
}

/// Part of a list that lies between two times.
fn between(values: &[f64], from: f64, to: f64) -> &[f64] {
    &values[(from / 5e-5).round() as usize..(to / 5e-5).round() as usize]
}

#[test]
fn the_independent_route_must_not_depend_on_its_own_step() {
    let (fine, coarse) = (independent(), event_driven::run(2.5e-5, 2.5, 2));
    let force = max_difference(&pick(fine, |s| s.force), &pick(&coarse, |s| s.force));
    let length = max_difference(&pick(fine, |s| s.length), &pick(&coarse, |s| s.length));
    // Runge–Kutta of order 4 with ω h ≈ 300 rad/s × 25 µs: (ω h)⁴/120 ≈ 3e-11 of 1 kN per step, over the 2000 steps that
    // the oscillation lasts: 5e-5 N. Rounding: 2.5 m × ε on an oil spring of 2e7 N/m gives 1e-8 N per step.
    assert!(force < 5e-5, "{force} N");
    assert!(length < 1e-11, "{length} m");
    assert!((fine.touch_down - coarse.touch_down).abs() < 1e-10);
    // Contacts are held by accelerations alone, yet they do not drift; an event is located below 0.1 pm.
    assert!(fine.drift < 1e-12, "{}", fine.drift);
    // The story: over the corner, onto the ramp, left wedge down; there both other contacts open, and the box rattles from
    // wedge to wedge until it stands on both. The disc never comes back.
    let story: Vec<&str> = fine.events.iter().map(|(_, what)| what.as_str()).collect();
    assert_eq!(story[..4], ["Region(Vertex)", "Region(Ramp)", "Closes(Left)", "then [Left]"]);
    assert_eq!(story[story.len() - 1], "then [Right, Left]");
    assert!(!story[4..].iter().any(|what| what.contains("Ramp") || what.contains("Vertex")), "{story:?}");
}

#[test]
fn the_monolithic_reference_must_converge_at_first_order() {
    let [a, b, c] = levels();
    let order =
        |values: [&[f64]; 3]| (max_difference(values[0], values[1]) / max_difference(values[1], values[2])).log2();
    // Before the touch-down everything is smooth but for kinks of the spool and of the ground, which cost order 2.
    for (from, to) in [(0.0, 0.35), (0.65, 1.65)] {
        let force = order([a, b, c].map(|level| between(&level.force, from, to)));
        let length = order([a, b, c].map(|level| between(&level.length, from, to)));
        // The next term is of order (ω h)² of the first one's ω h ≈ 7e-3: orders differ from 1 by about 1 %.
        assert!((force - 1.0).abs() < 0.05, "force {force}");
        assert!((length - 1.0).abs() < 0.05, "length {length}");
    }
    // Overall, impacts are moved by up to a step, at first order too but not smoothly; positions integrate over that.
    let rms = [(a, b), (b, c)].map(|(x, y)| rms_difference(&x.length, &y.length));
    assert!(((rms[0] / rms[1]).log2() - 1.0).abs() < 0.1, "{rms:?}");
}

#[test]
fn the_monolithic_reference_must_agree_with_the_independent_route() {
    let exact = independent();
    let (force, length) = (pick(exact, |s| s.force), pick(exact, |s| s.length));
    for level in levels() {
        let h = level.h;
        let error = |from: f64, to: f64| max_difference(between(&level.force, from, to), between(&force, from, to));
        let shift = level.touch_down - exact.touch_down;
        let position = max_difference(&level.length, &length);
        let whole = rms_difference(&level.force, &force);
        // Contacts close at the end of a step (≤ h), and the motion itself is ahead or behind by the error of the length
        // over the speed, ½ h for semi-implicit Euler.
        assert!(shift.abs() <= 1.5 * h, "touch-down {} is not {}", level.touch_down, exact.touch_down);
        // Semi-implicit Euler is the exact motion shifted by ½ h, to first order: ½ h × speed 0.3 m/s.
        assert!(position <= 0.5 * h * 0.3, "length {position}");
        // Force before the touch-down: shifted by ½ h, where it changes by at most 1 kN × 290 rad/s / 2.7 (the first swing).
        assert!(error(0.0, 1.69) <= 0.5 * h * 1.1e5, "force {}", error(0.0, 1.69));
        // After it: velocities are wrong by h × 800 N / 250 kg for each of the impacts that count (they shrink), c times that.
        assert!(error(1.70, 1.80) <= 4.0 * h * 3.2 * 1e4, "force {}", error(1.70, 1.80));
        // Then the difference has decayed.
        assert!(error(1.80, 2.5) <= 0.1 * 0.5 * h * 1.1e5, "force {}", error(1.80, 2.5));
        // Over all: each jump of the force stands at the wrong place for up to 1.5 h, and is spread over one step, in 2.5 s.
        let jumps: f64 = exact.jumps.iter().map(|jump| jump * jump).sum();
        assert!(whole <= (jumps * 2.5 * h / 2.5).sqrt() + 0.5 * h * 1.1e5, "rms {whole}");
    }
    // Richardson's extrapolation of the lengths must land on the independent route: what is left is second order, and the
    // irregular share of the impacts.
    let [_, b, c] = levels();
    let extrapolated: Vec<f64> = c.length.iter().zip(&b.length).map(|(fine, coarse)| 2.0 * fine - coarse).collect();
    let own = rms_difference(&b.length, &c.length);
    let left = rms_difference(&extrapolated, &length);
    assert!(left < 0.02 * own, "{left} of {own}");
    // And the reference's own estimate of its uncertainty must be the truth, to a tenth.
    let truth = rms_difference(&c.length, &length);
    assert!((truth / own - 1.0).abs() < 0.1, "estimated {own}, true {truth}");
    let (peak, dip) = (largest(force.iter().copied()), smallest(force.iter().copied()));
    let (found, lowest) = (largest(c.force.iter().copied()), smallest(c.force.iter().copied()));
    assert!((found - peak).abs() < 0.05, "peak {found} is not {peak}");
    // The dip follows a jump within a fraction of a millisecond; sampled every 50 µs, it moves by up to 1.5 h of 1e6 N/s.
    assert!((lowest - dip).abs() < 1.5 * c.h * 1e6, "dip {lowest} is not {dip}");
}

#[test]
fn the_event_driven_reference_must_be_the_independent_route_to_its_own_uncertainty() {
    let exact = independent();
    let reference = wedge_box_reference();
    for (column, theirs) in [
        ("actuator_length_m", pick(exact, |s| s.length)),
        ("actuator_force_n", pick(exact, |s| s.force)),
        ("box_angle_rad", pick(exact, |s| s.pose[2])),
    ] {
        let index = reference.trajectory.index_of(column).unwrap();
        let ours: Vec<f64> = reference.trajectory.column(index).collect();
        let (off, uncertainty) = (rms_difference(&ours, &theirs), reference.uncertainty[index]);
        // The independent route is itself certain to 1e-11 m and 1e-5 N rms.
        let own = if column == "actuator_force_n" { 1e-5 } else { 1e-11 };
        assert!(off <= 1.5 * uncertainty + own, "{column}: off by {off}, uncertainty {uncertainty}");
    }
}

#[test]
fn the_impact_of_the_touch_down_must_cost_what_projection_says() {
    // Contacts of the wedge box do work in impacts only, but for the discretisation: it vanishes with h.
    let exact = independent();
    let spent = |h: f64| {
        let mut mechanics = wedge_box_mechanics(PLASTIC);
        let mut cylinder = wedge_box_cylinder();
        let steps = (2.5 / h).round() as usize;
        let sides = PerSide { mechanics: &mut mechanics as &mut dyn Subsystem, actuator: &mut *cylinder };
        monolithic(sides, reference_steps(h, steps, steps), StopFlag::never(), &mut |_| {}).unwrap();
        -mechanics.ledger().contact
    };
    let [coarse, fine] = [5e-5, 2.5e-5].map(spent);
    // What is left is the irregular share of the impact times, as large as the change from one step to the other.
    assert!((fine - exact.lost_in_all).abs() <= 2.0 * (coarse - fine).abs() + 0.01 * exact.lost_in_all);
}
