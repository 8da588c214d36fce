//! Contact cases with known answers: what theory says must come out of the mechanics, coupled or not.

use crate::support::*;
use rimbench::cosim::Trajectory;

const ROCKING: &str = "rocking-block";

fn column(trajectory: &Trajectory, name: &str) -> usize {
    trajectory.index_of(name).unwrap()
}

#[test]
fn a_ball_must_come_to_rest_when_infinitely_many_impacts_add_up() {
    let h = 2e-5;
    let run = march("bouncing-ball", &[("spring_stiffness_n_m", "0")], h, 460_000, 1);
    let (time, height) = (0, column(&run, "gap_floor_m"));
    let velocity = column(&run, "interface_velocity_m_s");
    // The flight is the exact parabola shifted by ½ g h in velocity; the impact comes within the step in which the gap
    // closes.
    let first = run.rows().find(|row| row[velocity] > 0.0).unwrap()[time];
    assert!((first - 0.451523641).abs() < 2.0 * h, "{first}");
    // With V the speed of the parabola, each impact makes V⁺ = e V + ε, ε ≤ (½ − ½e + 1/e − e) g h = 0.261 g h, so that
    // no speed is off by more than ε/(1 − e) = 2.61 g h and no flight by more than 5.2 h; an impact and the launch
    // after it lie within 2 h. Down to rebounds of 1 µm (4.43 mm/s) it takes 66 impacts: 66 · 7.2 h = 475 h. From there
    // to rest the rebounds of an exact ball take 2 · 4.43e-3/(g (1 − e)) = 9.0 ms; one more or less of them, 1 ms, may
    // be above the level.
    let level = 1e-6;
    let last = run.rows().rfind(|row| row[height] > level).unwrap()[time];
    assert!(last > 8.578949 - 0.0090 - 0.0010 && last < 8.578949 + 475.0 * h, "{last}");
    // What is left of it rattles within 3.4 g h².
    let rest = run.rows().filter(|row| row[time] > 9.1).map(|row| row[height]).fold(0.0, f64::max);
    assert!(rest < 3.5 * 9.81 * h * h + 1e-12, "{rest:e}");
}

#[test]
fn the_coupled_ball_must_follow_its_exact_solution_as_far_as_the_step_allows() {
    let (case, parameters) = case_with("bouncing-ball", &[]);
    let exact = exact_row(case, &parameters, 1.0);
    let (_, loose) = case_with("bouncing-ball", &[("spring_stiffness_n_m", "0")]);
    let coupling = (exact[1] - exact_row(case, &loose, 1.0)[1]).abs();
    for h in [1e-3, 1e-4, 1e-5_f64] {
        let run = march("bouncing-ball", &[], h, (1.0 / h).round() as usize, 10);
        let error = (run.row(run.len() - 1)[1] - exact[1]).abs();
        // One impact at 4.4 m/s: displaced by up to 2 h at a closing speed of (1 + e) V = 8.4 m/s, 17 h; too fast by
        // 0.26 g h for 0.55 s, 1.5 h; parabolas shifted by ½ g h t, 5 h; the springs add less than 3 N to 10 N.
        assert!(error < 1.3 * 24.0 * h, "h = {h}: {error:e}");
    }
    assert!(coupling > 10.0 * 1.3 * 24.0 * 1e-5, "the springs hardly matter: {coupling}");
}

#[test]
fn an_impact_oscillator_started_on_its_period_one_orbit_must_stay_there() {
    // V and φ of the closed form at 2.4 Hz (see the module of the case).
    let set = [
        ("base_phase_rad", "1.7838006134115305"),
        ("start_position_m", "0.05"),
        ("start_velocity_m_s", "-2.0018230699215453"),
    ];
    for h in [1e-4, 1e-5_f64] {
        let run = march("impact-oscillator", &set, h, (2.3 / h).round() as usize, 1);
        let (gap, velocity) = (column(&run, "gap_stop_m"), column(&run, "interface_velocity_m_s"));
        let rows: Vec<&[f64]> = run.rows().collect();
        let impacts: Vec<(f64, f64)> = rows
            .windows(2)
            .filter(|pair| pair[0][velocity] > 1.0 && pair[1][velocity] < 0.0 && pair[1][gap] < 0.01)
            .map(|pair| (pair[1][0], pair[0][velocity]))
            .collect();
        assert_eq!(impacts.len(), 5, "not one impact per period: {impacts:?}");
        for (k, (time, speed)) in impacts.iter().enumerate() {
            // Perturbations of an impact decay with the multiplier e = 0.8, so that they add up to five of them. One:
            // the instant within 2 h, the speed by the acceleration there, (k/m)(A + d) + ω² X ≤ 33 m/s², over 2 h and
            // by what the semi-implicit rule shifts, ½ h · 33; instants and speeds turn into each other at V/a ≈ 0.1 s
            // and back.
            let period = (k + 1) as f64 / 2.4;
            assert!((time - period).abs() < 5.0 * 4.0 * h, "impact {k} at {time}, not {period}");
            assert!((speed - 2.5022788374).abs() < 5.0 * 2.5 * 33.0 * h, "impact {k} with {speed}");
        }
    }
}

#[test]
fn the_slider_must_follow_its_exact_solution_through_bounces_and_rest() {
    let (case, parameters) = case_with("slider-between-stops", &[]);
    let solution = exact_solution(case, &parameters);
    let mut errors = Vec::new();
    for h in [2e-4, 1e-4, 5e-5_f64] {
        let every = (0.03 / h).round() as usize;
        let run = march("slider-between-stops", &[], h, 50 * every, every);
        let mut exact = vec![0.0; run.columns().len()];
        let mut error = |row: &[f64]| {
            solution(row[0], &mut exact);
            (row[1] - exact[1]).abs()
        };
        errors.push(largest(run.rows().map(&mut error)) / h);
    }
    // First order: the error over h is bounded. It is not constant, because the instants of impacts fall anywhere in
    // their steps. Speeds are below 2 m/s: an impact displaced by 2 h costs (1 + e) V 2h = 6 h, its rebounds and the
    // semi-implicit rule no more.
    assert!(errors.iter().all(|ratio| *ratio < 2.0 * 6.0), "{errors:?}");
}

#[test]
fn under_moreaus_law_three_balls_must_leave_with_minus_one_two_and_two_thirds() {
    for (set, meetings) in [(&[("spring_stiffness_n_m", "0")][..], 2), (&[][..], 1)] {
        let h = 1e-5;
        let run = march("cradle", set, h, 100_000, 1);
        let v = ["interface_velocity_m_s", "ball_2_velocity_m_s", "ball_3_velocity_m_s"].map(|name| column(&run, name));
        let rows: Vec<&[f64]> = run.rows().collect();
        let jumps: Vec<[[f64; 3]; 2]> = rows
            .windows(2)
            .map(|pair| [v.map(|index| pair[0][index]), v.map(|index| pair[1][index])])
            .filter(|[before, after]| (after[0] - before[0]).abs() > 0.1)
            .collect();
        assert!(jumps.len() >= meetings);
        let speed = jumps[0][0][0];
        // Swings of 0.1 m at 5 rad/s; the spring of 2 N/m to the carriage pulls the same way, v² ≤ 0.25 + 2 · 0.1².
        assert!(speed > 0.4999 && speed < 0.27_f64.sqrt() + 1e-4, "{speed}");
        let expected = [[-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0], [1.0, 0.0, 0.0]];
        for (jump, expected) in jumps.iter().zip(expected).take(meetings) {
            for (after, expected) in jump[1].iter().zip(expected) {
                // The middle of the swing: pendulum and springs give less than 1 m/s² within a millimetre of it, for
                // two steps. Half a swing later the velocities have turned round, hence the sign.
                let sign = if expected == 1.0 || (expected == 0.0) { -1.0 } else { 1.0 };
                assert!((after - sign * speed * expected).abs() < 20.0 * h, "{jump:?}");
            }
        }
    }
}

/// Start (s) and end (s) of the contact, and its impulse (N·s).
fn bar(elements: usize) -> (f64, f64, f64) {
    let h = 5e-8;
    let count = elements.to_string();
    let set = [("spring_stiffness_n_m", "0"), ("elements", count.as_str()), ("stabilisation", "0")];
    let run = march("elastic-bar", &set, h, 24_000, 1);
    let force = column(&run, "contact_force_floor_n");
    let pushed: Vec<&[f64]> = run.rows().filter(|row| row[force] > 0.0).collect();
    let impulse: f64 = pushed.iter().map(|row| row[force] * h).sum();
    (pushed[0][0], pushed[pushed.len() - 1][0], impulse)
}

#[test]
fn the_bar_must_be_pushed_by_the_force_of_wave_theory_for_the_time_of_a_wave() {
    let (c, force) = ((210e9_f64 / 7800.0).sqrt(), (210e9_f64 * 7800.0).sqrt() * 3.14e-4 * 0.1);
    approx::assert_relative_eq!(force, 1270.83, max_relative = 1e-5);
    approx::assert_relative_eq!(2.0 / c, 3.8545e-4, max_relative = 2e-5);
    for elements in [10, 20, 40, 80] {
        let (start, end, impulse) = bar(elements);
        let (duration, mean) = (end - start, impulse / (end - start));
        // A force in a row belongs to the step before it; the fall takes whole steps.
        assert!((start - 5e-4).abs() < 2.0 * 5e-8 + 1e-12, "{start:e}");
        // The row of lumped masses is dispersive, ω = (2c/Δx) sin(kΔx/2): a front that has run the distance s is (s
        // Δx²/8)^(1/3) wide (Airy). With s = 2L that is 0.315 N^(-2/3) of the path, and within this the contact ends
        // and the impulse falls short, by the plastic node at the start too, which is ½/N of the mass.
        let front = 0.5 * (2.0 / (8.0 * (elements * elements) as f64)).cbrt();
        assert!((duration * c / 2.0 - 1.0).abs() < front, "{duration:e}");
        assert!((impulse * c / (2.0 * force) - 1.0).abs() < front, "{impulse}");
        assert!((mean / force - 1.0).abs() < 2.0 * front, "{mean}");
    }
}

#[test]
fn a_rocking_block_must_lose_at_its_corners_what_two_unilateral_rows_say() {
    for (b, h_block, rocks) in [("0.2", "0.5", true), ("0.3", "0.5", true), ("0.4", "0.5", false)] {
        let h = 4e-6;
        let set = [
            ("half_width_m", b),
            ("half_height_m", h_block),
            ("attachment_x_m", &format!("-{b}")),
            ("stabilisation", "0"),
        ];
        let run = march(ROCKING, &set, h, 200_000, 1);
        let rate = column(&run, "box_rate_rad_s");
        let left = column(&run, "contact_force_left_support_n");
        let rows: Vec<&[f64]> = run.rows().collect();
        let hit = rows.iter().position(|row| row[left] > 0.0).expect("the block never gets level");
        // The step that catches the corner uses up its gap; the impact is complete one step later.
        let [before, after] = [rows[hit - 1][rate], rows[hit + 1][rate]];
        let (b, h_block): (f64, f64) = (b.parse().unwrap(), h_block.parse().unwrap());
        let (inertia, lever) = ((b * b + h_block * h_block) / 3.0, b * b);
        assert_eq!(inertia > lever, rocks);
        let expected = ((inertia - lever) / (inertia + lever)).max(0.0);
        // Three steps of gravity's and the cylinder's moments, (m g b + 5 kN · 0.1 m)/I ≤ 60 rad/s² with I ≥ 19 kg·m²,
        // and an angle at the impact of at most one step of ω.
        assert!((after - expected * before).abs() < 3.0 * 60.0 * h + before.abs() * 2.0 * h, "{before} {after}");
    }
}

#[test]
fn wedges_in_one_plane_must_move_the_box_as_two_wedges_do_however_many_there_are() {
    let of = |supports: &str| march("n-wedge-box", &[("supports", supports)], 2e-4, 10_000, 100);
    let two = of("2");
    let wedge_box = march("wedge-box", &[], 2e-4, 10_000, 100);
    let names = ["box_x_m", "box_y_m", "box_angle_rad", "actuator_length_m"];
    // The same equations in another order of rows: rounding of metres, and solver residuals of 1e-9 relative to
    // velocities of 0.3 m/s over 2 s.
    let same = 1e-8;
    let largest = |a: &Trajectory, b: &Trajectory, name: &str| {
        let (i, j) = (column(a, name), column(b, name));
        a.column(i).zip(b.column(j)).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
    };
    for name in names {
        assert!(largest(&two, &wedge_box, name) < same, "{name}: {:e}", largest(&two, &wedge_box, name));
    }
    for supports in ["3", "8", "64"] {
        let many = of(supports);
        for name in names {
            assert!(largest(&many, &two, name) < same, "{supports}, {name}: {:e}", largest(&many, &two, name));
        }
        // At the end the box slides on all of them: many closed, rank two.
        let last = many.row(many.len() - 1);
        assert_eq!(last[column(&many, "closed_contacts")], supports.parse::<f64>().unwrap());
        assert_eq!(last[column(&many, "rank_h_uu")], 2.0);
    }
}

/// Numbers of a published trajectory: a line `rows columns`, then the rows.
fn siconos(name: &str) -> Option<Vec<Vec<f64>>> {
    let text = std::fs::read_to_string(data_of_others("siconos")?.join(name)).unwrap();
    let numbers = |line: &str| line.split_whitespace().map(|cell| cell.parse().unwrap()).collect();
    Some(text.lines().skip(1).map(numbers).filter(|row: &Vec<f64>| !row.is_empty()).collect())
}

/// The event-driven ball of Siconos, which bounces with 0.9 from 1 m, against the closed form of our case.
#[test]
fn the_exact_ball_is_the_event_driven_one_of_siconos() {
    let Some(rows) = siconos("bouncing_ball_event_driven.ref") else { return };
    assert_eq!(rows.len(), 1788);
    let (case, parameters) = case_with("bouncing-ball", &[("spring_stiffness_n_m", "0")]);
    let height = case.recorded_columns().iter().position(|name| name == "gap_floor_m").unwrap();
    let worst =
        rows.iter().map(|row| (exact_row(case, &parameters, row[0])[height] - row[1]).abs()).fold(0.0, f64::max);
    // Ours goes from grid point to grid point of 0.1 ms, 89 400 of them, each of which rounds a height and a velocity
    // of order one by 1.1e-16: 2e-11 where all add up. (A geometric series in the test's place is off by 2.3e-13.)
    assert!(worst < 2e-11, "{worst:e} m");
}

/// The impacting bar of Siconos: 100 elements, steps of 2 µs, against ours with steps of 50 ns.
#[test]
fn the_bar_leaves_the_floor_as_that_of_siconos_does() {
    let Some(rows) = siconos("impacting_bar.ref") else { return };
    let theirs = 2e-6;
    let h = 5e-8;
    let set = [("spring_stiffness_n_m", "0"), ("elements", "100"), ("stabilisation", "0")];
    let run = march("elastic-bar", &set, h, 30_000, 1);
    let (gap, force) = (column(&run, "gap_floor_m"), column(&run, "contact_force_floor_n"));
    let mut worst = 0.0_f64;
    for row in rows.iter().filter(|row| row[0] <= 1.5e-3) {
        let ours = run.row((row[0] / h).round() as usize);
        worst = worst.max((ours[gap] - row[1]).abs());
    }
    // It closes at 0.1 m/s and opens as fast, each up to a step of theirs late, and leaves with what is left of its
    // speed.
    assert!(worst < 2.5 * theirs * 0.1, "gap off by {worst:e} m");
    let contact = |time: &dyn Fn(usize) -> f64, force: &dyn Fn(usize) -> f64, count: usize| {
        let pushed: Vec<usize> = (0..count).filter(|&row| force(row) > 0.0).collect();
        let duration = time(pushed[pushed.len() - 1]) - time(pushed[0]);
        (duration, pushed.iter().map(|&row| force(row)).sum::<f64>() / pushed.len() as f64)
    };
    let (their_time, their_mean) = contact(&|row| rows[row][0], &|row| rows[row][3], rows.len());
    let (our_time, our_mean) = contact(&|row| run.row(row)[0], &|row| run.row(row)[force], run.len());
    // Contact ends within the front that dispersion has made of the wave by then (see the bar of wave theory above): of
    // either bar, and neither mass matrix is the other's. That they print every 2 µs adds two of these.
    let wave = 2.0 / (210e9_f64 / 7800.0).sqrt();
    let front = 0.5 * (2.0 / (8.0 * 100.0_f64 * 100.0)).cbrt();
    assert!((our_time - their_time).abs() < front * wave + 2.0 * theirs, "{our_time:e} against {their_time:e} s");
    approx::assert_relative_eq!(our_mean, their_mean, max_relative = front);
}
