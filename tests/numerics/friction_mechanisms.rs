//! The woodpecker toy and the slider–crank with play: against statics, against what is published, and their invariants.

use crate::support::*;
use rimbench::cases::Crank;
use rimbench::cosim::StopFlag;
use rimbench::mechanics::monolithic;

const G: f64 = 9.81;
// The toy: masses of sleeve and bird, inertia of the bird, radii of pole and sleeve, half height of the sleeve, levers,
// and the spring.
const M_M: f64 = 3e-4;
const M_S: f64 = 4.5e-3;
const J_S: f64 = 7e-7;
const R_O: f64 = 2.5e-3;
const R_M: f64 = 3.1e-3;
const H_M: f64 = 5.8e-3;
const L_M: f64 = 1e-2;
const L_G: f64 = 1.5e-2;
const C: f64 = 5.6e-3;

#[test]
fn a_woodpecker_at_rest_must_hang_from_a_coefficient_of_theory_on_and_slide_below_it() {
    let weight = (M_M + M_S) * G;
    let least = H_M * weight / (M_S * G * (L_M + L_G) - R_M * weight);
    assert!((least - 0.28519).abs() < 5e-6, "{least}");
    let angle = (-(R_M - R_O) / H_M - M_S * L_G * G / C).to_string();
    for (factor, holds) in [(1.0 + 1e-6, true), (1.0 - 1e-2, false)] {
        let mu = factor * least;
        let friction = mu.to_string();
        let set = [
            ("friction", &*friction),
            ("bird_angle_rad", &*angle),
            ("sleeve_velocity_m_s", "0"),
            ("bird_rate_rad_s", "0"),
            ("restitution", "0"),
        ];
        let (h, steps) = (1e-6, 1000);
        let run = march("woodpecker", &set, h, steps, steps);
        let [start, end] = <[f64; 2]>::try_from(column(&run, "sleeve_y_m")).unwrap();
        // While the sleeve slides and the spring is as it was, the bird turns back by m_S l_G/(J_S + m_S l_G²) of what
        // it falls.
        let free = 1.0 - M_S * L_G * L_G / (J_S + M_S * L_G * L_G);
        let levers = H_M + R_M * mu;
        let inertia = M_M + M_S * free - mu * M_S * L_M * free / levers;
        let acceleration = (mu * M_S * G * (L_M + L_G) / levers - weight) / inertia;
        let n = f64::from(steps as u32);
        let fall = if holds { 0.0 } else { -0.5 * acceleration * h * h * n * (n + 1.0) };
        // In 1 ms the spring changes its torque by (ω t)²/12 of what it could, ω² = c/(J_S + m_S l_G²) = (57 1/s)²;
        // rounding of angles over h.
        let bound = 3e-3 * fall + 1e-12;
        assert!((start - end - fall).abs() <= bound, "μ = {mu}: {} m, not {fall} m", start - end);
        assert!(holds || fall > 1e-8, "{fall}");
    }
}

/// Times and heights of the pecks of the beak.
fn pecks(set: &[(&str, &str)], h: f64, duration: f64) -> Vec<[f64; 2]> {
    let run = march("woodpecker", set, h, (duration / h) as usize, 1);
    let [time, y, beak] = ["time_s", "sleeve_y_m", "contact_force_beak_n"].map(|name| column(&run, name));
    let mut pecks: Vec<[f64; 2]> = Vec::new();
    for k in 1..beak.len() {
        // A beak that rebounds by half may touch again: what comes within 20 ms is the same peck.
        if beak[k] > 0.0 && pecks.last().is_none_or(|[last, _]| time[k] - last > 0.02) {
            pecks.push([time[k], y[k]]);
        }
    }
    pecks
}

/// Glocker 1995 and Leine, Glocker, van Campen 2001: e = 0.5 at the beak, else 0; 0.1460 s and 19.45 mm a hop.
#[test]
fn a_woodpecker_must_descend_in_the_hops_that_are_published_and_without_rebound_fall() {
    let hops = |e: &str, h: f64| {
        let pecks = pecks(&[("restitution", e)], h, 3.1);
        pecks.windows(2).map(|p| [p[1][0] - p[0][0], p[0][1] - p[1][1]]).collect::<Vec<_>>()
    };
    let mean = |hops: &[[f64; 2]], of: usize| hops.iter().map(|hop| hop[of]).sum::<f64>() / hops.len() as f64;
    // Twenty hops, one like the other but for the steps that impacts fall on either side of: half a step each, of which
    // some dozen make a hop, and 0.6 m/s or less in between.
    let h = 1e-5;
    let published = hops("0.5", h);
    let spread = |of: usize| largest(published.iter().map(|hop| (hop[of] - mean(&published, of)).abs()));
    assert_eq!(published.len(), 20);
    assert!(spread(0) <= 30.0 * h && spread(1) <= 30.0 * h * 0.6, "{} s, {} m", spread(0), spread(1));
    // Their mean is what is printed, to its last digit and half a step an impact.
    let ([period, descent], late) = ([mean(&published, 0), mean(&published, 1)], 12.0 * 0.5 * h);
    assert!((period - 0.1460).abs() <= 0.5e-4 + late, "{period} s");
    assert!((descent - 19.45e-3).abs() <= 0.5e-5 + 0.6 * late, "{descent} m");
    // From jam to jam it falls 0.25 m.
    let fall = largest(hops("0", 2e-5).iter().map(|hop| hop[1]));
    assert!(fall > 0.2, "{fall}");
}

#[test]
fn the_published_start_of_the_woodpecker_must_come_back_after_a_hop() {
    let h = 2e-6;
    let run = march("woodpecker", &[], h, 73_000, 1);
    let [sleeve, bird, y] = ["sleeve_angle_rad", "bird_angle_rad", "sleeve_y_m"].map(|name| column(&run, name));
    let rate = |x: &[f64], k: usize| (x[k] - x[k - 1]) / h;
    let end = sleeve.len() - 1;
    // Printed to four digits, the hop to 0.1 ms, in which the bird turns by 7.5e-4 rad and is braked by 0.7 % of its
    // speed.
    assert!((sleeve[end] - sleeve[0]).abs() <= 1e-9 && rate(&sleeve, end).abs() <= 1e-9);
    assert!((bird[end] - bird[0]).abs() <= 1.5 * 7.5e-4, "{}", bird[end]);
    assert!((rate(&bird, end) / -7.4583 - 1.0).abs() <= 0.01, "{}", rate(&bird, end));
    assert!((rate(&y, end) / -0.3411 - 1.0).abs() <= 0.02, "{}", rate(&y, end));
}

/// Restitution along the normal alone can create energy with friction. The account says so: here it does not.
#[test]
fn contacts_that_rebound_along_the_normal_alone_must_take_energy_from_toy_and_crank() {
    for (case, h, steps) in [("woodpecker", 1e-5, 30_000), ("slider-crank", 5e-6, 20_000)] {
        let (case, parameters) = case_with(case, &[]);
        let mut system = (case.build)(&parameters, solver()).unwrap();
        let (mut taken, mut most) = (0.0, 0.0_f64);
        monolithic(system.sides.lend(), reference_steps(h, steps, 1), StopFlag::never(), &mut |point| {
            let account = point.sides.mechanics.capabilities().energy_account().unwrap();
            let lost = account.contact + account.friction;
            most = most.max(taken - lost);
            taken = lost;
        })
        .unwrap();
        assert!(taken > 0.0 && most <= 1e-3 * taken, "{}: {most} J created in a step, {taken} J taken", case.name);
    }
}

/// Angles and rates of crank and rod after `duration` from Lagrange's equations, by Runge and Kutta's rule of the
/// fourth order.
fn without_guide(duration: f64, steps: u32) -> [f64; 4] {
    let p: Crank = defaults("slider-crank");
    let [m1, m2, m3] = [p.crank_mass_kg, p.rod_mass_kg, p.slider_mass_kg];
    let ([j1, j2], [l1, l2]) = ([p.crank_inertia_kg_m2, p.rod_inertia_kg_m2], [p.crank_length_m, p.rod_length_m]);
    let rate = |x: [f64; 4]| {
        let k = (0.5 * m2 + m3) * l1 * l2;
        let (m11, m22) = (j1 + (0.25 * m1 + m2 + m3) * l1 * l1, j2 + (0.25 * m2 + m3) * l2 * l2);
        let (m12, turned) = (k * (x[0] - x[1]).cos(), k * (x[0] - x[1]).sin());
        let f1 = -(0.5 * m1 + m2 + m3) * G * l1 * x[0].cos() - turned * x[3] * x[3];
        let f2 = -(0.5 * m2 + m3) * G * l2 * x[1].cos() + turned * x[2] * x[2];
        let determinant = m11 * m22 - m12 * m12;
        [x[2], x[3], (m22 * f1 - m12 * f2) / determinant, (m11 * f2 - m12 * f1) / determinant]
    };
    let h = duration / f64::from(steps);
    let ahead = |x: [f64; 4], k: [f64; 4], by: f64| [0, 1, 2, 3].map(|i| x[i] + by * k[i]);
    let mut x = [0.0, 0.0, 150.0, -75.0];
    for _ in 0..steps {
        let k1 = rate(x);
        let k2 = rate(ahead(x, k1, 0.5 * h));
        let k3 = rate(ahead(x, k2, 0.5 * h));
        let k4 = rate(ahead(x, k3, h));
        x = [0, 1, 2, 3].map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
    }
    x
}

#[test]
fn a_slider_crank_that_touches_nothing_must_move_as_lagranges_equations_say() {
    // Without motor; the slider meets its guide after 2.8 ms.
    let (alone, duration) = ([("shaft_stiffness_n_m", "0"), ("shaft_damping_n_s_m", "0")], 2.1e-3);
    let wanted = without_guide(duration, 2100);
    let found = |steps: usize| {
        let run = march("slider-crank", &alone, duration / steps as f64, steps, steps);
        ["crank_angle_rad", "rod_angle_rad", "crank_rate_rad_s", "rod_rate_rad_s"]
            .map(|name| *column(&run, name).last().unwrap())
    };
    let (coarse, fine) = (found(2100), found(4200));
    for (at, wanted) in wanted.into_iter().enumerate() {
        let [coarse, fine] = [coarse[at], fine[at]].map(|found| (found - wanted) / wanted);
        // Of the first order with 1e-6 s at 150 rad/s; twice the finer one less the other is of the second.
        assert!(coarse.abs() < 1e-3 && (2.0 * fine - coarse).abs() < 1e-6, "{at}: {coarse:e} {fine:e}");
    }
}

#[test]
fn a_slider_must_stay_in_its_guide_and_rub_as_coulomb_says() {
    let (h, steps) = (2e-6, 50_000);
    let run = march("slider-crank", &[("friction", "0.1")], h, steps, 10);
    let corners = ["upper_rear", "upper_front", "lower_rear", "lower_front"];
    let mut touched = 0;
    for corner in corners {
        let of = |head: &str, tail: &str| column(&run, &format!("{head}_{corner}{tail}"));
        let (gap, normal, along) = (of("gap", "_m"), of("contact_force", "_n"), of("friction_force", "_n"));
        // A corner goes into a wall by its convective term, l₁ ω² = 3.5e3 m/s², times h² a step, of which a fifth goes
        // back in each.
        assert!(smallest(gap.iter().copied()) > -5.0 * 3.5e3 * h * h * 10.0, "{corner}: {}", smallest(gap));
        for (normal, along) in normal.iter().zip(&along) {
            assert!(*normal >= 0.0 && along.abs() <= 0.1 * normal * (1.0 + 1e-9) + 1e-9, "{corner}: {normal} {along}");
            touched += usize::from(*normal > 0.0);
        }
    }
    assert!(touched > 1000, "{touched}");
}

/// The slider's corners are thrown from wall to wall: that is hit, though the rows turn, and takes energy. It took 0.64
/// J in steps of 0.5 ms when open corners counted as ones that rest, and takes 1.4 J in short steps.
#[test]
fn corners_that_are_thrown_into_a_wall_must_be_hit_though_their_rows_turn() {
    let options = [("macro_step_s", "5e-4")];
    let set = [("restitution", "0.4"), ("tangential_restitution", "0.4")];
    let run = run(&spec_with("slider-crank", "rim-nonsmooth-gap", &options, &set));
    let lost = run.report.audit.accounts.mechanics.unwrap().contact;
    assert!(lost > 0.95 && lost < 1.5, "{lost} J");
}

/// At 150 rad/s the slider crosses its play of 2 mm in a millisecond or two: what one wall throws back would be through the other
/// within the step.
#[test]
fn a_slider_that_is_thrown_back_further_than_its_play_must_go_on_and_lose_energy() {
    for (macro_step, restitution) in [("7e-4", "0.1"), ("1e-3", "0.4"), ("7e-4", "0.8")] {
        let set = [("restitution", restitution)];
        let run = run(&spec_with("slider-crank", "rim-nonsmooth", &[("macro_step_s", macro_step)], &set));
        assert_eq!(run.report.outcome, Outcome::Completed, "{macro_step} s, e = {restitution}");
        let lost = run.report.audit.accounts.mechanics.unwrap().contact;
        assert!(lost > 0.0, "{lost} J");
    }
}
