//! Why the monolithic reference can be trusted: its order, its agreement with co-simulation at a tiny macro step, and
//! an independent route that shares no line of code with it.

use crate::support::*;
use rimbench_independent::event_driven_wedge_box::{Run, Sample, run};
use std::sync::OnceLock;

/// The independent route at 10 µs, sampled every 50 µs; computed once.
fn independent() -> &'static Run {
    static RUN: OnceLock<Run> = OnceLock::new();
    RUN.get_or_init(|| run(1e-5, 2.5, 5))
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
    let (fine, coarse) = (independent(), run(2.5e-5, 2.5, 2));
    let force = max_difference(&pick(fine, |s| s.force), &pick(&coarse, |s| s.force));
    let length = max_difference(&pick(fine, |s| s.length), &pick(&coarse, |s| s.length));
    // Runge–Kutta of order 4 with ω h ≈ 300 rad/s × 25 µs: (ω h)⁴/120 ≈ 3e-11 of 1 kN per step, over the 2000 steps
    // that the oscillation lasts: 5e-5 N. Rounding: 2.5 m × ε on an oil spring of 2e7 N/m gives 1e-8 N per step.
    assert!(force < 5e-5, "{force} N");
    assert!(length < 1e-11, "{length} m");
    assert!((fine.touch_down - coarse.touch_down).abs() < 1e-10);
    // Contacts are held by accelerations alone, yet they do not drift; an event is located below 0.1 pm.
    assert!(fine.drift < 1e-12, "{}", fine.drift);
    // The story: over the corner, onto the ramp, left wedge down; there both other contacts open, and the box rattles
    // from wedge to wedge until it stands on both. The disc never comes back.
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
        // Contacts close at the end of a step (≤ h), and the motion itself is ahead or behind by the error of the
        // length over the speed, ½ h for semi-implicit Euler.
        assert!(shift.abs() <= 1.5 * h, "touch-down {} is not {}", level.touch_down, exact.touch_down);
        // Semi-implicit Euler is the exact motion shifted by ½ h, to first order: ½ h × speed 0.3 m/s.
        assert!(position <= 0.5 * h * 0.3, "length {position}");
        // Force before the touch-down: shifted by ½ h, where it changes by at most 1 kN × 290 rad/s / 2.7 (the first
        // swing).
        assert!(error(0.0, 1.69) <= 0.5 * h * 1.1e5, "force {}", error(0.0, 1.69));
        // After it: velocities are wrong by h × 800 N / 250 kg for each of the impacts that count (they shrink), c
        // times that.
        assert!(error(1.70, 1.80) <= 4.0 * h * 3.2 * 1e4, "force {}", error(1.70, 1.80));
        // Then the difference has decayed.
        assert!(error(1.80, 2.5) <= 0.1 * 0.5 * h * 1.1e5, "force {}", error(1.80, 2.5));
        // Over all: each jump of the force stands at the wrong place for up to 1.5 h, and is spread over one step, in
        // 2.5 s.
        let jumps: f64 = exact.jumps.iter().map(|jump| jump * jump).sum();
        assert!(whole <= (jumps * 2.5 * h / 2.5).sqrt() + 0.5 * h * 1.1e5, "rms {whole}");
    }
    // Richardson's extrapolation of the lengths must land on the independent route: what is left is second order, and
    // the irregular share of the impacts.
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
    // The dip follows a jump within a fraction of a millisecond; sampled every 50 µs, it moves by up to 1.5 h of 1e6
    // N/s.
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
