//! The energy audit: buckets booked one by one must close, and what the solvers create must vanish with their step.

use crate::support::*;
use rimbench::models::Oil;
use rimbench::parameter::ParameterSet;

/// Moves the wedge box's cylinder as `s(t) = s₀ + 0.01 (1 − cos 12 t)` through `n` steps of 0.4 s together, valve ramp
/// and all.
fn prescribed(n: usize) -> (EnergyAccount, [f64; 2]) {
    let mut cylinder = wedge_box_cylinder();
    let h = 0.4 / n as f64;
    let start = 2.516;
    for j in 0..n {
        let t = j as f64 * h;
        let u = [start + 0.01 * (1.0 - (12.0 * t).cos()), 0.12 * (12.0 * t).sin()];
        cylinder.step(t, &u, h).unwrap();
    }
    let mut observed = [0.0; 3];
    cylinder.capabilities().observe(h, &mut observed);
    (cylinder.capabilities().energy_account().unwrap(), [observed[0], observed[1]])
}

#[test]
fn what_explicit_euler_creates_in_the_cylinder_must_vanish_at_first_order_and_the_rest_must_not() {
    let accounts: Vec<_> = [1000, 2000, 4000, 8000, 16000].map(|n| (0.4 / n as f64, prescribed(n).0)).to_vec();
    for (_, account) in &accounts {
        // Some thirty roundings per step of energies of up to 100 kJ (pump and tank), which partly average out.
        assert!(account.closure().abs() < 1e-9, "{:e}", account.closure());
    }
    let residuals: Vec<(f64, f64)> = accounts.iter().map(|(h, account)| (*h, account.integration.abs())).collect();
    let order = order_of_convergence(&residuals).unwrap();
    assert!((order - 1.0).abs() < 0.1, "{order}: {residuals:?}");
    // The other buckets go to limits of their own, which are large against the residual.
    let [coarse, fine] = [accounts[3].1, accounts[4].1];
    type Bucket = (&'static str, fn(&EnergyAccount) -> f64);
    let buckets: [Bucket; 6] = [
        ("stored", |account| account.stored),
        ("interface", |account| account.interface),
        ("viscous", |account| account.viscous),
        ("pump", |account| account.pump),
        ("valve", |account| account.valve),
        ("tank", |account| account.tank),
    ];
    for (name, bucket) in buckets {
        assert!((bucket(&coarse) - bucket(&fine)).abs() < 1e-2 * bucket(&fine).abs(), "{name} does not converge");
        assert!(bucket(&fine).abs() > 10.0 * fine.integration.abs(), "{name} is no larger than the residual");
    }
}

#[test]
fn buckets_of_the_cylinder_must_be_the_integrals_that_physics_says() {
    let (account, [p1, p2]) = prescribed(16000);
    // c ∫ ṡ² = c 0.0144 (0.2 − sin(9.6)/48) by hand.
    let friction = 1e4 * 0.0144 * (0.2 - 9.6_f64.sin() / 48.0);
    approx::assert_relative_eq!(account.viscous, friction, max_relative = 1e-3);
    // What is stored is a function of where it ended: V ε(p), V from 1 m on either side.
    let fluid = Oil::defaults();
    let moved = 0.01 * (1.0 - (12.0_f64 * (0.4 - 2.5e-5)).cos());
    let (l1, l2) = (1.0 - moved, 1.0 + moved);
    let (e1, e2, e0) = (fluid.elastic_energy(p1), fluid.elastic_energy(p2), fluid.elastic_energy(3.85e6));
    approx::assert_relative_eq!(account.stored, 0.0065 * (l1 * e1 + l2 * e2 - 2.0 * e0), max_relative = 0.05);
    // A valve only loses.
    assert!(account.valve > 0.0);
}

#[test]
fn the_audit_must_close_for_every_scheme_whatever_becomes_of_the_run() {
    let mut astray = 0;
    for scheme in schemes() {
        for macro_step in [1e-3, 2e-2] {
            let case = if scheme.bonds.is_some() { "gripper" } else { "wedge-box" };
            let result = run(&usual_spec(case, &scheme.name, macro_step));
            let audit = result.report.audit;
            let name = format!("{} H={macro_step} ({})", scheme.name, result.report.outcome);
            let scale = scale(&audit);
            let closure = audit.closure().unwrap();
            let steps =
                (result.report.work.sides.mechanics.micro_steps + result.report.work.sides.actuator.micro_steps) as f64;
            assert!(closure.abs() <= 8.0 * f64::EPSILON * steps * scale, "{name}: {closure:e} J of {scale:e} J");
            astray += usize::from(result.report.outcome != Outcome::Completed);
            // One value per exchange, the last that of the report.
            let last = *result.interface_residual.last().unwrap();
            assert_eq!(result.interface_residual.len(), result.trajectory.len());
            if result.report.outcome == Outcome::Completed {
                assert_eq!(Some(last), result.report.audit.work.residual_j());
            }
            assert_eq!(result.report.latencies.as_ref().unwrap().count(), result.report.work.cosim.macro_steps);
        }
    }
    assert!(astray > 0, "no run went astray: the audit was only tested where it is easy");
}

/// Sum of the magnitudes of all buckets, J: what rounding is relative to.
fn scale(audit: &EnergyAudit) -> f64 {
    // The potential energy of box and disc stands on both sides.
    gross(audit).unwrap() + 2e3
}

/// What is booked of both sides, whatever its sign; none of sides without accounts.
pub fn gross(audit: &EnergyAudit) -> Option<f64> {
    audit.total(|a| {
        let buckets = [a.stored, a.interface, a.contact, a.viscous, a.pump, a.valve, a.tank, a.integration];
        buckets.map(f64::abs).iter().sum::<f64>()
    })
}

#[test]
fn what_the_solvers_create_must_vanish_with_all_steps_together() {
    let residuals: Vec<(f64, f64)> = [4e-4, 2e-4, 1e-4, 5e-5]
        .into_iter()
        .map(|step| {
            let spec = wedge_box_spec("rim-nonsmooth-gap", step)
                .changed(|own| (own.micro_step, own.duration) = (0.25 * step, 1.6));
            let audit = run(&spec).report.audit;
            (step, audit.integration().unwrap().abs())
        })
        .collect();
    let order = order_of_convergence(&residuals).unwrap();
    assert!((order - 1.0).abs() < 0.15, "{order}: {residuals:?}");
}
