//! The energy that contacts in an interface model create (docs/method/no-heavier-than-the-mechanics.md): the jump at
//! the communication point to round-off, models that lose, three ways to create, and shares of a body.

use crate::random_bodies::*;
use crate::support::*;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rimbench::complementarity::{Checked, Lcp};
use rimbench::contact_law::{GapRates, gap_velocity};

/// What the contacts of a model may do.
#[derive(Clone, Copy, PartialEq)]
enum Law {
    /// `0 ≤ w ⟂ P ≥ 0`.
    Unilateral,
    /// With gaps that move along, and this fraction γ of a penetration removed in a step of the mechanics.
    Gaps(f64),
    /// `w = 0`.
    Bilateral,
}

/// The model of a macro step computed on the whole body: its end velocity v̂, its contact impulses P̂, their work and
/// `a_c · ∫ t dP̂`, how far its contacts travel, its interface velocities.
struct Replay {
    v: DVector<f64>,
    impulses: Vec<f64>,
    travel: Vec<f64>,
    work: f64,
    moment: f64,
    interface: Vec<Vec<f64>>,
}

fn kinetic(model: &LinearModel, v: &DVector<f64>) -> f64 {
    0.5 * model.mass.iter().zip(v.iter()).map(|(m, v)| m * v * v).sum::<f64>()
}

fn replay(model: &LinearModel, set: &[usize], law: Law, forces: &[Vec<f64>]) -> Replay {
    let (n, delta) = (model.mass.len(), H / forces.len() as f64);
    let inverse_mass = DMatrix::from_diagonal(&DVector::from_iterator(n, model.mass.iter().map(|m| 1.0 / m)));
    let (a_i, a_c) = (matrix(&model.interface, n), matrix(&model.unilateral, n).select_rows(set));
    let h_cc = &a_c * &inverse_mass * a_c.transpose();
    let force = DVector::from_column_slice(&model.force);
    let mut gap: Vec<f64> = set.iter().map(|&contact| model.unilateral.offset[contact]).collect();
    let mut solver = solver().checked(set.len());
    let mut replay = Replay {
        v: DVector::from_column_slice(&model.v),
        impulses: vec![0.0; model.unilateral.offset.len()],
        travel: vec![0.0; set.len()],
        work: 0.0,
        moment: 0.0,
        interface: Vec::new(),
    };
    let answer = |v: &mut DVector<f64>, solver: &mut Checked, gap: &mut [f64]| {
        let b = &a_c * &*v;
        let mut p = DVector::zeros(set.len());
        if law == Law::Bilateral {
            p = -h_cc.clone().pseudo_inverse(1e-10).unwrap() * b;
        } else if !set.is_empty() {
            let rates = match law {
                Law::Gaps(stabilisation) => GapRates::new(delta, H, stabilisation),
                _ => GapRates::default(),
            };
            let b: Vec<f64> = b.iter().zip(&*gap).map(|(b, gap)| b + rates.velocity(*gap)).collect();
            solver.solve(Lcp::new(h_cc.as_slice(), &b), p.as_mut_slice()).unwrap();
        }
        *v += &inverse_mass * a_c.transpose() * &p;
        gap.iter_mut().zip((&a_c * &*v).iter()).for_each(|(gap, w)| *gap += delta * w);
        p
    };
    let mut p = DVector::zeros(set.len());
    let mut before = &a_c * &replay.v;
    if law == Law::Bilateral {
        p = answer(&mut replay.v, &mut solver, &mut gap);
    }
    for (j, lambda) in forces.iter().enumerate() {
        replay.v += delta * &inverse_mass * (&force + a_i.transpose() * DVector::from_column_slice(lambda));
        p += answer(&mut replay.v, &mut solver, &mut gap);
        let after = &a_c * &replay.v;
        replay.work += 0.5 * p.dot(&(&before + &after));
        replay.moment += (j as f64 + 0.5) * delta * p.dot(&(&a_c * &inverse_mass * &force));
        replay.travel.iter_mut().zip((&before + &after).iter()).for_each(|(way, w)| *way += 0.5 * delta * w);
        set.iter().zip(p.iter()).for_each(|(&contact, p)| replay.impulses[contact] += p);
        (before, p) = (after, DVector::zeros(set.len()));
        replay.interface.push((&a_i * &replay.v).as_slice().to_vec());
    }
    replay
}

/// A jump from the end of a model to that of the mechanics, J, and what both theorems say of it.
struct Jump {
    change: f64,
    identity: f64,
    /// `Σ d (P̂ − P)`, d the gap terms of the mechanics' step.
    bound: f64,
    scale: f64,
}

fn jump(model: &LinearModel, stabilisation: f64, end: &Replay, mechanics: &NonSmoothMechanics<LinearModel>) -> Jump {
    let v = DVector::from_column_slice(mechanics.velocity());
    let w = matrix(&model.unilateral, v.len()) * &v;
    let impulses = mechanics.contact_impulses();
    let (mut identity, mut bound) = (-kinetic(model, &(&end.v - &v)), 0.0);
    let start = DVector::from_column_slice(&model.v);
    let mut scale = kinetic(model, &v) + kinetic(model, &end.v) + kinetic(model, &start);
    for (contact, (p, p_model)) in impulses.iter().zip(&end.impulses).enumerate() {
        let term = gap_velocity(model.unilateral.offset[contact], H, H, stabilisation);
        identity += w[contact] * (p - p_model);
        bound += term * (p_model - p);
        scale += (w[contact].abs() + term.abs()) * (p.abs() + p_model.abs());
    }
    Jump { change: kinetic(model, &v) - kinetic(model, &end.v), identity, bound, scale }
}

/// Runs a scheme and its replay over one macro step, which must agree.
fn run_and_replay(
    rng: &mut Pcg64,
    (model, stabilisation): (&LinearModel, f64),
    (scheme, options): (&str, &ModelOptions),
    (set, law): (&[usize], Law),
) -> Jump {
    let interface = model.interface.offset.len();
    let mut mechanics = stepper(model.clone(), ContactLaw { stabilisation, ..PLASTIC });
    let mut played = Played::random(rng, 8, interface);
    let report = macro_step((&mut mechanics, &mut played), (scheme, options), (8, 1, ForceReturn::Mean));
    let end = replay(model, set, law, &played.forces);
    for (one, other) in velocities(&report, interface).iter().zip(&end.interface) {
        let size = end.v.amax() + 1.0;
        assert!(max_difference(one, other) < 1e-9 * size, "{scheme}: {one:?}, replayed {other:?}");
    }
    let found = jump(model, stabilisation, &end, &mechanics);
    // The account that the program keeps, from what it knows at the interface: each part is that of the whole body.
    let created = report.audit.model.unwrap();
    let (n, before) = (model.mass.len(), DVector::from_column_slice(&model.v));
    let (a_c, after) = (matrix(&model.unilateral, n), DVector::from_column_slice(mechanics.velocity()));
    let own = DVector::from_column_slice(mechanics.contact_impulses());
    let difference = H * &own - 2.0 * H * DVector::from_column_slice(&end.impulses);
    let free = DVector::from_iterator(n, model.force.iter().zip(&model.mass).map(|(force, mass)| force / mass));
    let contacts =
        end.work - end.moment - own.dot(&(&a_c * 0.5 * (before + after))) - 0.5 * difference.dot(&(&a_c * free));
    let sum = created.jump + created.first_moment + created.contacts + created.unfrozen;
    let residual = report.audit.work.residual_j().unwrap();
    for (name, one, other) in [
        ("jump", created.jump, found.change),
        ("contacts", created.contacts, contacts),
        ("unfrozen", created.unfrozen, 0.0),
        ("sum", sum, -residual),
    ] {
        assert!((one - other).abs() < 1e-9 * (1.0 + found.scale), "{scheme}, {name}: {one:e}, not {other:e}");
    }
    found
}

fn margin(width: f64) -> ModelOptions {
    ModelOptions { detection: Some(ContactDetection::Margin { width }), ..ModelOptions::default() }
}

/// The mechanics' contact problem is a minimum of kinetic energy over impulses P ≥ 0, and the model's are a competitor.
#[test]
fn models_whose_contacts_push_where_the_mechanics_has_contacts_lose_energy_at_the_communication_point() {
    let rng = &mut Pcg64::seed_from_u64(4);
    let usual = ModelOptions::default();
    let mut lost = 0;
    for case in 0..300 {
        let (contacts, interface) = (rng.random_range(1..4), rng.random_range(1..3));
        let model = body(rng, contacts, interface);
        let all: Vec<usize> = (0..contacts).collect();
        let Jump { change, identity, scale, .. } =
            run_and_replay(rng, (&model, 0.0), ("rim-nonsmooth", &usual), (&all, Law::Unilateral));
        assert!((change - identity).abs() < ROUND_OFF * scale, "case {case}: {change:e}, not {identity:e}");
        assert!(change <= ROUND_OFF * scale, "case {case}: {change:e} J created");
        lost += usize::from(change < -1e-3 * scale);

        // With gaps and penetrations no more than what moves through them.
        let model = independent(rng, interface);
        let contacts = model.unilateral.offset.len();
        let all: Vec<usize> = (0..contacts).collect();
        let offset = draw(rng, contacts, 0.2);
        let apart = LinearModel { unilateral: ConstantRows { offset, ..model.unilateral.clone() }, ..model };
        let Jump { change, identity, bound, scale } =
            run_and_replay(rng, (&apart, 0.3), ("rim-nonsmooth-gap", &usual), (&all, Law::Gaps(0.3)));
        assert!((change - identity).abs() < ROUND_OFF * scale, "case {case}: {change:e}, not {identity:e}");
        assert!(change <= bound + ROUND_OFF * scale, "case {case}: {change:e} J created, bound {bound:e}");
    }
    assert!(lost > 30, "{lost}: nothing was at stake");
}

/// A mechanics that takes several steps under the mean force is not one minimum, and may end with more energy than the
/// model.
#[test]
fn several_steps_of_the_mechanics_in_a_macro_step_are_not_covered() {
    let rng = &mut Pcg64::seed_from_u64(8);
    let mut created = 0;
    for _ in 0..300 {
        let model = body(rng, 2, 1);
        let mut mechanics = stepper(model.clone(), PLASTIC);
        let mut played = Played::random(rng, 12, 1);
        let usual = ModelOptions::default();
        macro_step((&mut mechanics, &mut played), ("rim-nonsmooth", &usual), (12, 12, ForceReturn::Mean));
        let end = replay(&model, &[0, 1], Law::Unilateral, &played.forces);
        let Jump { change, scale, .. } = jump(&model, 0.0, &end, &mechanics);
        created += usize::from(change > 1e-3 * scale);
    }
    assert!(created > 0, "a theorem may be missing");
}

#[test]
fn the_jump_of_bilateral_and_premature_contacts_obeys_the_same_identity_and_creates_energy() {
    let rng = &mut Pcg64::seed_from_u64(5);
    let mut created = [0; 2];
    for case in 0..300 {
        let interface = rng.random_range(1..3);
        let model = independent(rng, interface);
        let contacts = model.unilateral.offset.len();
        let all: Vec<usize> = (0..contacts).collect();
        let smooth = run_and_replay(rng, (&model, 0.0), ("rim-smooth", &margin(0.0)), (&all, Law::Bilateral));
        let offset = vec![0.4; contacts];
        let apart = LinearModel { unilateral: ConstantRows { offset, ..model.unilateral.clone() }, ..model };
        let early = run_and_replay(rng, (&apart, 0.0), ("rim-nonsmooth", &margin(0.4)), (&all, Law::Unilateral));
        for (count, jump) in created.iter_mut().zip([smooth, early]) {
            let Jump { change, identity, scale, .. } = jump;
            assert!((change - identity).abs() < ROUND_OFF * scale, "case {case}: {change:e}, not {identity:e}");
            *count += usize::from(change > 1e-3 * scale);
        }
    }
    assert!(created.iter().all(|count| *count > 30), "{created:?}");
}

/// Any impulses of a model under Coulomb friction: energy is created only where the mechanics slides and the model
/// pushes along the surface by more than the mechanics' own friction.
#[test]
fn with_friction_impulses_within_the_cone_of_the_mechanics_create_nothing() {
    let rng = &mut Pcg64::seed_from_u64(6);
    let (mut slid, mut created, mu) = (0, 0, 0.4);
    for case in 0..400 {
        let mut model = body(rng, 1, 1);
        model.tangential = rows(rng, 1, model.mass.len());
        let friction = Friction { coefficient: mu, at_rest: mu, restitution: 0.0 };
        let mut mechanics = stepper(model.clone(), PLASTIC).with_friction(friction, solver()).unwrap();
        let force = draw(rng, 1, 6.0);
        // Rows at random may jam; then there is no step to speak of.
        if mechanics.step(0.0, &force, H).is_err() {
            continue;
        }
        let n = model.mass.len();
        let (a_n, a_t, a_i) = (matrix(&model.unilateral, n), matrix(&model.tangential, n), matrix(&model.interface, n));
        let inverse = |x: DVector<f64>| DVector::from_iterator(n, x.iter().zip(&model.mass).map(|(x, m)| x / m));
        let pushed = H * (DVector::from_column_slice(&model.force) + a_i.transpose() * force[0]);
        let (p_n, p_t) = (mechanics.contact_impulses()[0], mechanics.friction_impulses()[0]);
        let v = DVector::from_column_slice(mechanics.velocity());
        let [w_n, w_t] = [&a_n, &a_t].map(|rows| (rows * &v)[0]);
        // Within the cone, and anywhere.
        for within in [true, false] {
            let model_n = rng.random_range(0.0..2.0);
            let model_t = rng.random_range(-1.0..1.0) * if within { mu * p_n } else { 2.0 };
            let end = DVector::from_column_slice(&model.v)
                + inverse(pushed.clone() + a_n.transpose() * model_n + a_t.transpose() * model_t);
            let change = kinetic(&model, &v) - kinetic(&model, &end);
            let wanted = -kinetic(&model, &(&end - &v)) - w_n * model_n - w_t * model_t - mu * p_n * w_t.abs();
            let scale = kinetic(&model, &v) + kinetic(&model, &end) + 1.0;
            assert!((change - wanted).abs() < ROUND_OFF * scale, "case {case}: {change:e}, not {wanted:e}");
            assert!(!within || change <= ROUND_OFF * scale, "case {case}: {change:e} J created");
            created += usize::from(change > 1e-3 * scale);
        }
        slid += usize::from(p_n > 1e-3 && w_t.abs() > 1e-3 && p_t.abs() > 0.0);
    }
    assert!(slid > 50 && created > 10, "{slid} slid, {created} created");
}

/// The smooth model of a contact that sticks or slides for the whole macro step, against the whole body.
#[test]
fn the_jump_of_a_bilateral_contact_with_friction_is_that_of_the_whole_body() {
    let rng = &mut Pcg64::seed_from_u64(10);
    let (mut stuck, mut slid, mut locked, mu) = (0, 0, 0, 0.4);
    for case in 0..400 {
        let mut model = body(rng, 1, 1);
        let n = model.mass.len();
        model.tangential = rows(rng, 1, n);
        if case % 2 == 0 {
            model.v = vec![0.0; n];
        }
        let friction = Friction { coefficient: mu, at_rest: mu, restitution: 0.0 };
        let start = || stepper(model.clone(), PLASTIC).with_friction(friction, solver()).unwrap();
        let mut played = Played::random(rng, 8, 1);
        let mean = played.forces.iter().map(|force| force[0] / 8.0).sum::<f64>();
        let inverse = |x: DVector<f64>| DVector::from_iterator(n, x.iter().zip(&model.mass).map(|(x, m)| x / m));
        let [a_n, a_t, a_i] = [&model.unilateral, &model.tangential, &model.interface].map(|rows| matrix(rows, n));
        let before = DVector::from_column_slice(&model.v);
        let slides = (&a_t * &before)[0];
        // E K⁻¹ F: what pushes, and which rows stand still.
        let (pushes, still) = match slides == 0.0 {
            true => [(); 2].map(|()| DMatrix::from_fn(2, n, |row, j| if row == 0 { a_n[j] } else { a_t[j] })).into(),
            false => (&a_n - mu * slides.signum() * &a_t, a_n.clone()),
        };
        let k =
            &still * DMatrix::from_columns(&pushes.row_iter().map(|row| inverse(row.transpose())).collect::<Vec<_>>());
        // Rows at random may jam, or all but jam; then there is no step to speak of.
        if k.singular_values().min() < 0.05 || start().step(0.0, &[mean], H).is_err() {
            continue;
        }
        let x = &before + H * inverse(DVector::from_column_slice(&model.force) + a_i.transpose() * mean);
        let end = &x - inverse(pushes.transpose() * k.clone().lu().solve(&(&still * &x)).unwrap());

        let mut mechanics = start();
        let how = (8, 1, ForceReturn::Mean);
        let report = macro_step((&mut mechanics, &mut played), ("rim-smooth", &margin(0.0)), how);
        let last = &velocities(&report, 1)[7];
        let (v, size) = (DVector::from_column_slice(mechanics.velocity()), 1.0 + end.amax());
        let by_force = inverse(a_i.transpose().column(0).into());
        let left = &by_force - inverse(pushes.transpose() * k.clone().lu().solve(&(&still * &by_force)).unwrap());
        // Locked by its own friction the model is no body.
        if (&a_i * left)[0] < -1e-12 * (&a_i * &by_force)[0] {
            assert!(report.audit.model.is_none(), "case {case}");
            locked += 1;
            continue;
        }
        assert!((last[0] - (&a_i * &end)[0]).abs() < 1e-9 * size, "case {case}: {last:?}");
        let audit = report.audit.model.unwrap();
        let change = kinetic(&model, &v) - kinetic(&model, &end);
        let sum = audit.jump + audit.first_moment + audit.contacts + audit.unfrozen;
        let scale = 1.0 + kinetic(&model, &v) + kinetic(&model, &end);
        for (name, one, other) in [("jump", audit.jump, change), ("sum", sum, -report.audit.work.residual_j().unwrap())]
        {
            assert!((one - other).abs() < 1e-9 * scale, "case {case}, {name}: {one:e}, not {other:e}");
        }
        stuck += usize::from(audit.largest.is_some_and(|jump| jump.by == Creation::Stick));
        slid += usize::from(slides != 0.0);
    }
    assert!(stuck > 20 && slid > 50 && locked > 0, "{stuck} stuck too long, {slid} slid, {locked} locked");
}

/// Bounds of before the first run, that of 1 J for 10 ms, where the smooth model creates 0.11 J, then for 20 ms, where
/// it diverges.
#[test]
fn on_the_wedge_box_with_friction_a_model_that_decides_once_per_macro_step_sticks_too_long() {
    let [smooth, pushes] = ["rim-smooth-active", "rim-nonsmooth"].map(|scheme| {
        let spec = spec_with("wedge-box-friction", scheme, &[("macro_step_s", "2e-2")], &[("friction", "0.3")]);
        run(&spec.changed(|own| own.audit = true))
            .report
            .audit
            .model
            .unwrap()
            .largest
            .map(|jump| (jump.energy, jump.by))
    });
    assert!(smooth.is_some_and(|(energy, by)| energy >= 1.0 && by == Creation::Stick), "{smooth:?}");
    assert!(pushes.is_none_or(|(energy, _)| energy <= 0.1), "{pushes:?}");
}

/// A margin, a bilateral contact and stick kept too long, each with a force that the model holds while the mechanics
/// gives way; the non-smooth model with the contacts that are closed creates nothing.
#[test]
fn there_are_three_ways_to_create_energy_with_contacts() {
    let (mass, impulse) = (2.0, 0.12);
    let constant = |force: f64| Played::new(vec![vec![force]; 8]);
    let created =
        |mechanics: &mut NonSmoothMechanics<LinearModel>, force: f64, scheme: &str, options: &ModelOptions| {
            let report = macro_step((mechanics, &mut constant(force)), (scheme, options), (8, 1, ForceReturn::Mean));
            let by = report.audit.model.and_then(|model| model.largest).map(|jump| jump.by);
            let heavier = report.audit.model.is_some_and(|model| model.heaviness > ROUND_OFF);
            (-report.audit.work.residual_j().unwrap(), by, heavier)
        };
    let over = |gap: f64| stepper(LinearModel::new(&[mass], &[0.0], &[(&[1.0], 0.0)]).over(&[(&[1.0], gap)]), PLASTIC);
    let usual = ModelOptions::default();
    let nothing = (0.0, None, false);
    let close = |one: (f64, Option<Creation>, bool), other: (f64, Option<Creation>, bool)| {
        (one.0 - other.0).abs() < 1e-14 && (one.1, one.2) == (other.1, other.2)
    };
    // Pushed through a gap by as much as the step can close: the bound ½ m (g/H)².
    let gap = impulse / mass * H;
    let bound = 0.5 * mass * (gap / H).powi(2);
    assert!(close(
        created(&mut over(gap), -impulse / H, "rim-nonsmooth", &margin(gap)),
        (bound, Some(Creation::Gap), true)
    ));
    assert!(close(created(&mut over(gap), -impulse / H, "rim-nonsmooth", &usual), nothing));
    // Pulled off: ½ m x² of the velocity x by which the contact opens.
    let opened = (0.5 * impulse * impulse / mass, Some(Creation::Pull), true);
    assert!(close(created(&mut over(0.0), impulse / H, "rim-smooth", &margin(0.0)), opened));
    assert!(close(created(&mut over(0.0), impulse / H, "rim-nonsmooth", &usual), nothing));
    // What the mechanics pushes out of a penetration, and the model holds.
    let penetrated = LinearModel::new(&[mass], &[0.0], &[(&[1.0], 0.0)]).over(&[(&[1.0], -1e-5)]);
    let mut penetrated = stepper(penetrated, ContactLaw { stabilisation: 0.2, ..PLASTIC });
    let (_, by, _) = created(&mut penetrated, -impulse / H, "rim-smooth", &margin(0.0));
    assert_eq!(by, Some(Creation::Push));
    // Pulled along a surface by twice what friction holds.
    let block = || {
        let weight = 0.5 * impulse / (0.4 * H);
        let block = LinearModel::new(&[mass; 2], &[0.0, -weight], &[(&[1.0, 0.0], 0.0)]);
        let block = block.over(&[(&[0.0, 1.0], 0.0)]).along(&[(&[1.0, 0.0], 0.0)]);
        stepper(block, PLASTIC)
            .with_friction(Friction { coefficient: 0.4, at_rest: 0.4, restitution: 0.0 }, solver())
            .unwrap()
    };
    let slides = 0.5 * impulse / mass;
    assert!(close(
        created(&mut block(), impulse / H, "rim-smooth", &margin(0.0)),
        (0.5 * impulse * slides, Some(Creation::Stick), false)
    ));
    assert!(close(created(&mut block(), impulse / H, "rim-nonsmooth", &usual), nothing));
}

/// Cut the body into shares, let each move with its own actuator, and weld them together again: welding loses energy.
#[test]
fn models_of_shares_of_a_body_create_nothing_however_many_actuators_there_are() {
    let rng = &mut Pcg64::seed_from_u64(7);
    let mut heavier = 0;
    for case in 0..200 {
        let (contacts, spokes) = (rng.random_range(0..4), rng.random_range(2..6));
        let model = body(rng, contacts, spokes);
        let all: Vec<usize> = (0..contacts).collect();
        let parts: Vec<f64> = (0..spokes).map(|_| rng.random_range(0.2..1.0)).collect();
        let (mut impulses, mut before) = (Vec::new(), 0.0);
        let start = kinetic(&model, &DVector::from_column_slice(&model.v));
        for (spoke, part) in parts.iter().enumerate() {
            let share = part / parts.iter().sum::<f64>();
            let scaled = |values: &[f64]| values.iter().map(|value| share * value).collect::<Vec<f64>>();
            let interface = ConstantRows { jacobian: vec![model.interface.jacobian[spoke].clone()], offset: vec![0.0] };
            let own =
                LinearModel { mass: scaled(&model.mass), force: scaled(&model.force), interface, ..model.clone() };
            let forces: Vec<Vec<f64>> = (0..8).map(|_| draw(rng, 1, 6.0)).collect();
            before += kinetic(&own, &replay(&own, &all, Law::Unilateral, &forces).v);
            impulses.push(forces.iter().map(|force| force[0] / 8.0).sum::<f64>());
        }
        let port = |index: usize, quantity| Port::new(format!("port_{index}"), quantity);
        let of = |quantity| (0..spokes).map(move |index| port(index, quantity));
        let ports = Ports {
            inputs: of(Quantity::Force).collect(),
            outputs: of(Quantity::Position).chain(of(Quantity::Velocity)).collect(),
            direct_feedthrough: false,
        };
        let mut mechanics = NonSmoothMechanics::new(model.clone(), PLASTIC, ports, solver().checked(contacts));
        mechanics.step(0.0, &impulses, H).unwrap();
        let after = kinetic(&model, &DVector::from_column_slice(mechanics.velocity()));
        assert!(after <= before + ROUND_OFF * (before + start), "case {case}: {after} J of {before} J");

        // Own mobilities over the shares, or times the row sums of the correlations, are no heavier; own mobilities
        // alone are.
        let bare = LinearModel { unilateral: ConstantRows::default(), ..model };
        let (_, eq4) = reduce(&linearise(&mut bare.clone(), &bare.q, &bare.v), &bare.v, H, 0.0);
        let h = DMatrix::from_row_slice(spokes, spokes, &eq4.h);
        let own = |factor: &dyn Fn(usize) -> f64| {
            let told = DMatrix::from_diagonal(&DVector::from_fn(spokes, |i, _| factor(i) * h[(i, i)]));
            (told - &h).symmetric_eigenvalues().min() / h.trace()
        };
        let row_sum = |i: usize| (0..spokes).map(|j| h[(i, j)].abs() / (h[(i, i)] * h[(j, j)]).sqrt()).sum::<f64>();
        assert!(own(&|i| parts.iter().sum::<f64>() / parts[i]) > -ROUND_OFF, "case {case}");
        assert!(own(&row_sum) > -ROUND_OFF, "case {case}");
        heavier += usize::from(own(&|_| 1.0) < -1e-3);
    }
    assert!(heavier > 190, "{heavier}");
}

/// Energy created has one meaning: that of a trace is minus the interface residual of the same run, and a jump is only
/// a bound.
#[test]
fn energy_created_in_a_trace_must_be_minus_the_interface_residual() {
    for detection in ["margin:1e-3", "active"] {
        let options = [("macro_step_s", "5e-3"), ("contact_detection", detection)];
        let spec = spec_with("wedge-box", "rim-nonsmooth", &options, &[]).audited().unwrap();
        let run = completed(&spec);
        let (audit, created) = (run.report.audit, *column(&run.trajectory, "created_j").last().unwrap());
        let (model, residual) = (audit.model.unwrap(), audit.interface_residual().unwrap());
        let sent = audit.work.sent_j.unwrap().abs();
        assert!((created + residual).abs() < 1e-11 * (sent + model.jump.abs()), "{created} J, residual {residual} J");
        assert_eq!(created, model.created());
        // Across the gap of a margin the model's contacts take nearly all that the jumps gain; closed ones gain nothing
        // by jumps.
        let bounded = if detection == "active" { model.jump < 0.0 } else { model.jump > 10.0 * created.abs() };
        assert!(bounded, "{detection}: jumps {} J, created {created} J", model.jump);
    }
}
