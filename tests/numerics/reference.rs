//! Why the monolithic reference can be trusted: its order, its agreement with co-simulation at a tiny macro step, and
//! an independent route that shares no line of code with it.

use crate::support::*;
use rimbench_independent::event_driven_wedge_box::{Run, Sample, run};
use std::sync::{Arc, OnceLock};

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

/// Root mean square difference of a reference at these times from what they show.
fn off(reference: &Reference, name: &str, times: &[f64], theirs: &[f64]) -> f64 {
    rms_difference(&column(&reference.judged.resampled(times.iter().copied()), name), theirs)
}

/// A run is judged at its own instants, of which few are those of rows.
#[test]
fn between_its_rows_too_the_reference_must_be_the_independent_route_to_its_own_uncertainty() {
    // Every 29.3 µs, which a row of 50 µs meets each 128th time.
    let (h, every) = (2.5 / 256_000.0, 3);
    let exact = run(h, 2.5, every);
    let reference = wedge_box_reference();
    let times: Vec<f64> = (0..exact.samples.len()).map(|k| (every * k) as f64 * h).collect();
    for (name, theirs, own) in [
        ("actuator_length_m", pick(&exact, |s| s.length), 1e-11),
        ("actuator_force_n", pick(&exact, |s| s.force), 1e-5),
    ] {
        let (off, uncertainty) = (off(reference, name, &times, &theirs), reference.uncertainty_of(name).unwrap());
        assert!(off <= 1.5 * uncertainty + own, "{name}: off by {off}, uncertainty {uncertainty}");
    }
    // Each impact has two rows, where the independent route has it, and the force jumps as there.
    let (events, force) = (&reference.events, column(&reference.events, "actuator_force_n"));
    let jumps: Vec<(f64, f64)> = (0..events.len() / 2)
        .map(|k| (events.row(2 * k)[0], force[2 * k + 1] - force[2 * k]))
        .filter(|(_, jump)| jump.abs() > 1.0)
        .collect();
    assert!((jumps[0].0 - exact.touch_down).abs() < 1e-8, "{jumps:?} {}", exact.touch_down);
    let largest_of = |jumps: Vec<f64>| largest(jumps.into_iter().map(f64::abs));
    let (ours, theirs) = (largest_of(jumps.iter().map(|jump| jump.1).collect()), largest_of(exact.jumps));
    assert!((ours - theirs).abs() < 1e-3 * theirs, "{ours} {theirs}");
}

/// Time (s), length (m), velocity (m/s) and force (N) of the actuator of the rocking block by an implementation in
/// Python that knows the machine from a page of text: classical Runge–Kutta steps of 50 µs, events located by bisection,
/// plastic impacts by projection. No time is that of a row.
#[rustfmt::skip]
const ROCKING_BLOCK: [[f64; 4]; 26] = [
    [0.003819660113, 1.8052394498103, -0.00340008562, 268.068107],
    [0.038819660113, 1.8051921770239, -0.00118320959, 253.439173],
    [0.083819660113, 1.8051436166743, -0.00086878077, 187.821247],
    [0.088819660113, 1.8051394283117, -0.00080542334, 176.008192],
    [0.093819660113, 1.8052918018612, -0.00018179884, -3595.698707],
    [0.103819660113, 1.8052137788203, 0.01627608439, -230.442038],
    [0.123819660113, 1.8054960716382, 0.02182477711, -103.495526],
    [0.158819660113, 1.8068937575711, 0.05684574285, -91.646649],
    [0.163819660113, 1.8071761421282, 0.03035350246, 499.676571],
    [0.168819660113, 1.8074213457341, 0.07203824521, 1558.784790],
    [0.173819660113, 1.807805668226, 0.0721945769, -441.544432],
    [0.193819660113, 1.8093493117998, 0.08698558434, 531.820300],
    [0.198819660113, 1.8098013799378, 0.0932817657, 419.404965],
    [0.203819660113, 1.8103245512326, 0.09977226529, -971.318404],
    [0.208819660113, 1.8107941586902, 0.09276312931, -27.397886],
    [0.213819660113, 1.8112778112866, 0.09968917192, -207.538173],
    [0.218819660113, 1.8117363507276, 0.09168051888, 515.024737],
    [0.223819660113, 1.8122266247382, 0.10024360325, -209.657030],
    [0.228819660113, 1.8127099773297, 0.09372020267, -97.528447],
    [0.233819660113, 1.8131813246744, 0.09584036035, 140.495157],
    [0.248819660113, 1.814622082119, 0.09596560068, 25.492862],
    [0.298819660113, 1.8194163887992, 0.09587118514, -0.130090],
    [0.398819660113, 1.8290035503959, 0.09587165255, -0.000115],
    [0.598819660113, 1.8481778809066, 0.09587165255, -0.000108],
    [0.898819660113, 1.8769393766668, 0.09587165252, -0.000103],
    [1.298819660113, 1.9152880376695, 0.09587165249, -0.000097],
];

#[test]
fn between_its_rows_the_reference_of_the_rocking_block_must_be_that_of_another_hand() {
    let reference =
        Reference::compute(&usual_spec("rocking-block", "zero-order-hold", 1e-3), StopFlag::never()).unwrap();
    let times = ROCKING_BLOCK.map(|row| row[0]);
    // What is looked at lies in the first quarter second for the most part, where all of the uncertainty is.
    let denser = (18.0 / 26.0 * 1.5 / 0.25_f64).sqrt();
    for (name, place, own) in
        [("actuator_length_m", 1, 1e-12), ("actuator_velocity_m_s", 2, 1e-10), ("actuator_force_n", 3, 1e-5)]
    {
        let off = off(&reference, name, &times, &ROCKING_BLOCK.map(|row| row[place]));
        let uncertainty = reference.uncertainty_of(name).unwrap();
        assert!(off <= denser * uncertainty + own, "{name}: off by {off}, uncertainty {uncertainty}");
    }
}

/// Where an independent solution is not at hand: by rows that are four times as dense, of the same steps.
#[test]
fn what_lies_between_rows_must_be_within_the_uncertainty_that_is_told() {
    for case in ["half-car", "rocking-block-friction"] {
        let spec = usual_spec(case, "zero-order-hold", 1e-3);
        let reference = Reference::compute(&spec, StopFlag::never()).unwrap();
        let mut denser = Case::clone(&spec.case);
        denser.defaults.reference_step_s /= 4.0;
        denser.defaults.reference_sampling_s /= 4.0;
        let denser = spec.changed(|own| own.case = Arc::new(denser));
        let dense = Reference::solution(&denser, 1, StopFlag::never()).unwrap().rows;
        let times = column(&dense, "time_s");
        for row in &spec.case.interface_columns {
            for name in [&row.position, &row.velocity, &row.force] {
                let (off, told) =
                    (off(&reference, name, &times, &column(&dense, name)), reference.uncertainty_of(name).unwrap());
                assert!(off <= told, "{case}: {name} is off by {off}, uncertainty {told}");
            }
        }
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
