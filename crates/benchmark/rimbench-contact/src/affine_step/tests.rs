use super::*;
use crate::complementarity::{SparseLcp, SparseSolver};
use crate::contact_law::GapRates;
use crate::friction::ContactState;
use crate::linear_algebra::SymmetricPattern;
use rand::{RngExt, SeedableRng};
use std::sync::Arc;

const CONTACTS: usize = 60;
const DELTA: f64 = 5e-5;
const PULL: f64 = 10.0;

/// Contacts side by side, each with its two neighbours: pressed and at rest up to `active`, and open from there on.
/// Model, its law, and the response of those at rest.
fn row_of(active: usize) -> (DiscretisedModel, StepContactLaw, AffineStep<SparseSetFactor>) {
    let neighbours: Vec<Vec<usize>> =
        (0..CONTACTS).map(|i| vec![i.saturating_sub(1), (i + 1).min(CONTACTS - 1)]).collect();
    let pattern = Arc::new(SymmetricPattern::new(&neighbours));
    let (mut h, mut a) = (vec![0.0; pattern.entries() + CONTACTS + 1], vec![0.0; CONTACTS + 1]);
    let mut at = 0;
    for i in 0..CONTACTS {
        for &j in pattern.columns(i) {
            h[at] = if i == j as usize { 2.0 } else { 0.5 };
            at += 1;
        }
    }
    // The interface pushes the first contact, and pulls the last two.
    h[at] = -0.5;
    h[at + CONTACTS - 2] = 0.3;
    h[at + CONTACTS - 1] = -0.4;
    h[at + CONTACTS] = 1.0;
    for (i, a) in a[..CONTACTS].iter_mut().enumerate() {
        // Of those that are open every second one falls.
        *a = if i < active { -PULL } else { [0.4 * PULL, -0.4 * PULL][i % 2] };
    }
    let mut discretised = DiscretisedModel::by_pattern(pattern.clone(), 1);
    let model =
        LinearModel { h: &h, a: &a, contact_rows: CONTACTS, interface: 1, pattern: Some(&pattern), unsymmetric: false };
    discretised.discretise(model, &(0..CONTACTS).collect::<Vec<_>>(), DELTA);
    let law = StepContactLaw {
        rates: GapRates { open: 1.0 / DELTA, closed: 40.0 },
        gap_step: DELTA,
        ..StepContactLaw::default()
    };
    let mut solver = SparseSolver::new(&pattern, 1e-9);
    let mut impulses = vec![0.0; CONTACTS];
    let mut q = discretised.free_increment(CONTACTS).to_vec();
    q[active..].fill(1.0);
    solver.solve(SparseLcp::by_pattern(discretised.contact_rows().unwrap(), &q), &mut impulses).unwrap();
    let mut step = AffineStep::new(CONTACTS, 1, SparseSetFactor::new(solver.solver.factor(), CONTACTS, 1));
    step.linearise(&discretised, &law, (solver.solver.factor(), &impulses), 0.0);
    assert!(step.is_known());
    assert_eq!(impulses.iter().filter(|impulse| **impulse > 0.0).count(), active);
    (discretised, law, step)
}

/// Takes a micro step as a scheme does, with a bound over `ahead` more; tells whether it was one without a look at the
/// contacts.
fn go(
    step: &mut AffineStep<SparseSetFactor>,
    (discretised, law): (&DiscretisedModel, &StepContactLaw),
    force: f64,
    ahead: usize,
    state: &mut ModelState,
) -> Option<bool> {
    let lambda = [force];
    let skipped = step.skip(law, &lambda, state);
    let went = skipped || step.step(discretised, law, &lambda, ahead + 1, state);
    if went {
        std::mem::swap(&mut state.w, &mut state.w_plus);
    }
    went.then_some(skipped)
}

/// Velocities that a micro step takes for rounding add up in the gap, which the next one looks at.
#[test]
fn a_drift_that_each_micro_step_takes_for_rounding_is_seen_once_gaps_have_added_it_up() {
    let (discretised, law, step) = row_of(CONTACTS);
    let rounding = SparseSetFactor::NEGLIGIBLE * DELTA * PULL;
    for (drift, ahead) in [0.4, 0.01, -0.4].into_iter().flat_map(|part| [(part * rounding, 0), (part * rounding, 98)]) {
        let mut step = step.clone();
        let mut state = ModelState::new(CONTACTS, CONTACTS, 1);
        state.w[7] = drift;
        let mut farthest = 0.0_f64;
        for k in 0..20_000 {
            go(&mut step, (&discretised, &law), 0.0, ahead, &mut state).expect("contacts stay");
            if k % 100 == 99 {
                let ModelState { w, gap, .. } = &mut state;
                step.end_skips(&law, w, gap);
                farthest = farthest.max(gap[7].abs());
                assert!(w[7].abs() <= 2.0 * rounding, "{drift:e}: {:e} m/s", w[7]);
            }
        }
        // Where the gap term of a penetration is rounding, which is the smaller one.
        let seen = rounding / law.rates.closed;
        assert!(farthest <= 1.01 * seen, "{drift:e}: {farthest:e} m of {seen:e}");
        let unseen = 20_000.0 * DELTA * drift.abs();
        assert!(drift.abs() < 0.1 * rounding || unseen > 10.0 * seen, "{drift:e}: it would be seen anyway");
    }
}

/// A contact that opens by a little more than what is rounding, among others whose penetrations go on as foreseen.
#[test]
fn rounding_of_one_contact_is_not_corrected_back_and_forth() {
    let (discretised, law, step) = row_of(CONTACTS);
    let rounding = SparseSetFactor::NEGLIGIBLE * DELTA * PULL;
    let decay = 1.0 - DELTA * law.rates.closed;
    // The interface at the end, without the one contact first.
    let mut interface = None;
    for part in [0.0, 0.3, 0.55, 0.8, 0.95, 1.2, 3.0] {
        let mut step = step.clone();
        let mut state = ModelState::new(CONTACTS, CONTACTS, 1);
        for (i, (gap, w)) in state.gap.iter_mut().zip(&mut state.w).enumerate() {
            *gap = -1e-6 * (1.0 + libm::sin(i as f64));
            *w = -law.rates.velocity(*gap);
        }
        (state.w[7], state.gap[7]) = (part * rounding, part * rounding * DELTA);
        for _ in 0..50 {
            go(&mut step, (&discretised, &law), 0.0, 0, &mut state).expect("contacts stay");
        }
        let ModelState { w, gap, .. } = state;
        let off = (w[CONTACTS] - *interface.get_or_insert(w[CONTACTS])).abs();
        assert!(off <= 10.0 * rounding, "{part}: the interface is off by {off:e} m/s");
        assert!(w[7].abs() <= 2.0 * rounding && gap[7].abs() <= 1e3 * rounding * DELTA, "{part}: {:e} m/s", w[7]);
        // σ starts at one each time that r is solved for.
        let since = libm::log(step.sigma) / libm::log(decay);
        assert!(since > 44.0, "{part}: solved for {since} micro steps ago");
    }
}

/// Micro steps with and without a bound on skips, under forces that end the set sooner or later.
#[test]
fn micro_steps_without_a_look_at_the_contacts_go_as_far_as_those_with_one_and_end_as_they_do() {
    let mut rng = rand_pcg::Pcg64::seed_from_u64(8);
    let active = CONTACTS - 12;
    let (discretised, law, start) = row_of(active);
    let (mut ahead_of_all, mut ended) = (0, 0);
    for turn in 0..400 {
        let (pitch, size) = (rng.random_range(0.0..0.2), rng.random_range(0.0..25.0));
        let phase = rng.random_range(0.0..6.0);
        let force = |k: usize| size * libm::sin(phase + pitch * k as f64);
        let [mut of_all, mut of_few] = [(); 2].map(|()| (start.clone(), ModelState::new(CONTACTS, CONTACTS, 1)));
        for ModelState { w, gap, .. } in [&mut of_all.1, &mut of_few.1] {
            let mut rng = rand_pcg::Pcg64::seed_from_u64(turn);
            // Penetrations that are pushed out, and open contacts of which some are on their way in.
            for (i, (w, gap)) in w.iter_mut().zip(gap).enumerate() {
                if i < active {
                    *gap = if turn % 3 == 0 { 0.0 } else { -rng.random_range(0.0..1e-4) };
                    *w = -law.rates.velocity(*gap);
                } else {
                    *gap = rng.random_range(0.0..1e-3);
                    *w = rng.random_range(-0.02..0.3);
                }
            }
        }
        for k in 0..100 {
            let [all, few] = [(&mut of_all, 0), (&mut of_few, 98_usize.saturating_sub(k))]
                .map(|((step, state), ahead)| go(step, (&discretised, &law), force(k), ahead, state));
            assert_eq!(all.is_some(), few.is_some(), "{turn}: micro step {k}");
            ahead_of_all += usize::from(few == Some(true));
            assert_eq!(of_all.1.w[CONTACTS].to_bits(), of_few.1.w[CONTACTS].to_bits(), "the interface");
            if all.is_none() {
                ended += 1;
                break;
            }
        }
        let (step, ModelState { w, gap, .. }) = &mut of_few;
        step.end_skips(&law, w, gap);
        for i in 0..CONTACTS {
            let [all, few] = [&of_all.1, &of_few.1].map(|state| (state.w[i], state.gap[i]));
            let off = (all.0 - few.0).abs().max((all.1 - few.1).abs() / DELTA);
            assert!(off < 1e-12, "{turn}: contact {i}: {few:?} instead of {all:?}");
        }
    }
    println!("{ahead_of_all} of 40000 micro steps without a look, {ended} sets ended");
    assert!(ahead_of_all > 10_000 && ended > 100 && ended < 350, "{ahead_of_all} {ended}");
}

#[test]
fn a_bound_is_for_four_micro_steps_or_more_and_leaves_at_most_one_contact_in_eight_to_be_looked_at() {
    let active = CONTACTS - 12;
    let (discretised, law, step) = row_of(active);
    let rounding = SparseSetFactor::NEGLIGIBLE * DELTA * PULL;
    for (drifting, drift, accepted, ahead, skips) in [
        (7, -0.95, 0.5, 98, true),
        (8, -0.95, 0.5, 98, false),
        (6, -0.95, 1.1, 98, false),
        (0, 0.0, 0.5, 3, false),
        (0, 0.0, 0.5, 4, true),
        // What opens at a tenth of rounding adds up to six tenths.
        (active, 0.1, 0.5, 4, true),
        (active, 0.1, 0.5, 20, false),
    ] {
        let mut step = step.clone();
        let mut state = ModelState::new(CONTACTS, CONTACTS, 1);
        state.gap[active..].fill(1.0);
        // Rounding now, if need be more after fifty micro steps.
        state.w[..drifting].fill(drift * rounding);
        // One that opens still moves inwards, by a part of what is accepted.
        let increment = step.velocities[active];
        (state.gap[active], state.w[active]) = (0.0, -increment - accepted * step.accepted(rounding));
        let mut go = |ahead| go(&mut step, (&discretised, &law), 0.0, ahead, &mut state);
        let stays = accepted < 1.0;
        assert_eq!(
            (go(ahead), go(ahead - 1)),
            (stays.then_some(false), stays.then_some(skips)),
            "{drifting} {drift} {ahead}"
        );
    }
}

/// Pressed by 10 N with μ = 0.5, it sticks up to 5 N along the surface, of which it gets half.
#[test]
fn a_contact_that_sticks_is_followed_up_to_the_border_of_its_cone() {
    let (h, a) = ([1.0, 0.0, 0.0, 0.0, 1.0, 0.5, 0.0, 0.5, 1.0], [-PULL, 0.0, 0.0]);
    let mut discretised = DiscretisedModel::new(2, 1);
    let model = LinearModel { h: &h, a: &a, contact_rows: 2, interface: 1, pattern: None, unsymmetric: false };
    discretised.discretise(model, &[0, 1], DELTA);
    let law = StepContactLaw { gap_step: DELTA, ..StepContactLaw::default() };
    let mut step = AffineStep::new(2, 1, ModeFactor::new(1));
    step.linearise(&discretised, &law, (&[ContactState::Stick], &[0.5]), 0.0);
    for (force, sticks) in [(0.0, true), (9.9, true), (10.1, false), (-9.9, true), (-10.1, false)] {
        let mut state = ModelState::new(1, 2, 1);
        assert_eq!(step.step(&discretised, &law, &[force], 0, &mut state), sticks, "{force} N");
        if sticks {
            approx::assert_relative_eq!(state.impulses[0], DELTA * PULL, max_relative = 1e-14);
            approx::assert_relative_eq!(state.impulses[1], -0.5 * DELTA * force, max_relative = 1e-14);
        }
    }
}

/// As above, two of them, each with a force of its own along the surface.
#[test]
fn forces_keep_the_set_as_long_as_each_contact_sticks() {
    let (mut h, a) = ([0.0; 36], [-PULL, -PULL, 0.0, 0.0, 0.0, 0.0]);
    (0..6).for_each(|row| h[7 * row] = 1.0);
    for (row, column) in [(2, 4), (3, 5)] {
        (h[6 * row + column], h[6 * column + row]) = (0.5, 0.5);
    }
    let mut discretised = DiscretisedModel::new(4, 2);
    let model = LinearModel { h: &h, a: &a, contact_rows: 4, interface: 2, pattern: None, unsymmetric: false };
    discretised.discretise(model, &[0, 1, 2, 3], DELTA);
    let law = StepContactLaw::default();
    let mut step = AffineStep::new(4, 2, ModeFactor::new(2));
    step.linearise(&discretised, &law, (&[ContactState::Stick; 2], &[0.5; 2]), 0.0);
    let (state, mut region) = (ModelState::new(2, 4, 2), ForceRegion::new(4, 2));
    step.find_force_region(&discretised, &law, (&state.w, &state.gap), &[0.0; 2], &mut region);
    for (forces, keep) in [([0.0, 0.0], true), ([9.9, -9.9], true), ([10.1, 0.0], false), ([0.0, -10.1], false)] {
        assert_eq!(region.contains(&forces), keep, "{forces:?} N");
    }
}
