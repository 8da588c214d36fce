//! Energy return: what the coupling created is taken out again, never more, and never into what cannot move.

use crate::support::*;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const H: f64 = 1e-2;

/// A mechanics with a pool in front of it, and the energy that was put there.
struct Pooled {
    mechanics: NonSmoothMechanics<LinearModel>,
    pool: EnergyPool,
    model: ReducedInterfaceModel,
    /// Work of the forces without the impulses, minus what was created, J.
    sent: f64,
    /// Sum of the magnitudes of all works, J.
    turnover: f64,
}

impl Pooled {
    fn new(model: LinearModel) -> Self {
        let mut mechanics = stepper(model, PLASTIC);
        let empty = mechanics.empty_interface_model().unwrap();
        let pool = EnergyPool::new(EnergyReturn::Pool, &empty, solver()).unwrap();
        Pooled { mechanics, pool, model: empty, sent: 0.0, turnover: 0.0 }
    }

    /// The coupling creates so much.
    fn create(&mut self, energy: f64) {
        self.sent -= energy;
        self.turnover += energy;
        self.note();
    }

    fn note(&mut self) {
        let received_j = self.mechanics.interface_work();
        self.pool.note_work(InterfaceWork { sent_j: Some(self.sent), received_j });
    }

    /// One step under `force`, with nothing created; returns the impulse.
    fn step(&mut self, force: &[f64]) -> Vec<f64> {
        self.mechanics.interface_model(H, &mut self.model).unwrap();
        let before = self.mechanics.interface_displacement().unwrap().to_vec();
        let mut u = force.to_vec();
        self.pool.give(&self.model, &mut u, &before).unwrap();
        let impulse: Vec<f64> = u.iter().zip(force).map(|(u, force)| (u - force) * H).collect();
        self.mechanics.step(0.0, &u, H).unwrap();
        let after = self.mechanics.interface_displacement().unwrap().to_vec();
        self.pool.take_back(H, &mut u, &after);
        assert_eq!(u, force, "what is held goes on without the impulse");
        for (row, force) in force.iter().enumerate() {
            let way = after[row] - before[row];
            self.sent += force * way;
            self.turnover += (force * way).abs() + (impulse[row] * way / H).abs();
        }
        self.note();
        impulse
    }

    fn kinetic(&self) -> f64 {
        self.mechanics.energy()
    }
}

/// A point of mass `m` at velocity `w`, free or on a floor.
fn point(m: f64, w: f64, floor: Option<f64>) -> LinearModel {
    let free = LinearModel::new(&[m], &[0.0], &[(&[1.0], 0.0)]).moving(&[w]);
    match floor {
        Some(gap) => free.over(&[(&[1.0], gap)]),
        None => free,
    }
}

#[test]
fn the_impulse_of_a_free_mass_is_that_of_the_formula_and_takes_out_what_was_created() {
    let (m, w, force, energy) = (2.0, -1.5, 40.0, 0.3);
    let mut pooled = Pooled::new(point(m, w, None));
    let before = pooled.kinetic();
    pooled.create(energy);
    let impulse = pooled.step(&[force]);
    let mean = w + 0.5 * H * force / m;
    let expected = -2.0 * energy / (mean + mean.signum() * (mean * mean - 2.0 * energy / m).sqrt());
    approx::assert_relative_eq!(impulse[0], expected, max_relative = 1e-12);
    let books = pooled.pool.books();
    approx::assert_relative_eq!(books.removed_j, energy, max_relative = 1e-12);
    // The kinetic energy is that of the force's work, less what was taken out.
    let way = pooled.mechanics.interface_displacement().unwrap()[0];
    approx::assert_relative_eq!(pooled.kinetic() - before, force * way - energy, max_relative = 1e-10);
}

#[test]
fn more_than_there_is_stays_in_the_pool() {
    let (m, w) = (2.0, 0.1);
    let mut pooled = Pooled::new(point(m, w, None));
    pooled.create(1.0);
    let impulse = pooled.step(&[0.0]);
    approx::assert_relative_eq!(impulse[0], -m * w, max_relative = 1e-12);
    approx::assert_relative_eq!(pooled.pool.books().pool_j(), 1.0 - 0.5 * m * w * w, max_relative = 1e-12);
    // Then it rests, and gives nothing.
    let impulse = pooled.step(&[0.0]);
    assert!(impulse[0].abs() <= 4.0 * f64::EPSILON * m * w, "{impulse:?}");
}

#[test]
fn several_rows_share_the_impulse_as_the_formula_says() {
    let rows: [(&[f64], f64); 2] = [(&[1.0, 0.0], 0.0), (&[1.0, -1.0], 0.0)];
    let model = LinearModel::new(&[2.0, 3.0], &[0.0, 0.0], &rows).moving(&[0.5, -0.8]);
    let mut pooled = Pooled::new(model);
    pooled.create(0.2);
    let impulse = pooled.step(&[0.0, 0.0]);
    // H = [1/2 1/2; 1/2 1/2+1/3], w̃ = (0.5, 1.3); H⁻¹ by hand.
    let w = [0.5, 1.3];
    let determinant: f64 = 0.5 * (0.5 + 1.0 / 3.0) - 0.25;
    let solved = [((0.5 + 1.0 / 3.0) * w[0] - 0.5 * w[1]) / determinant, (-0.5 * w[0] + 0.5 * w[1]) / determinant];
    let alpha = 1.0 - (1.0 - 0.4 / (w[0] * solved[0] + w[1] * solved[1])).sqrt();
    for row in 0..2 {
        approx::assert_relative_eq!(impulse[row], -alpha * solved[row], max_relative = 1e-12);
    }
    approx::assert_relative_eq!(pooled.pool.books().removed_j, 0.2, max_relative = 1e-12);
}

#[test]
fn a_locked_interface_gives_nothing() {
    let mut pooled = Pooled::new(point(2.0, 0.0, Some(0.0)));
    pooled.create(1.0);
    for _ in 0..3 {
        assert_eq!(pooled.step(&[-50.0]), [0.0]);
    }
    // It comes down, and is locked within the step in which it gives nothing either.
    let mut pooled = Pooled::new(point(2.0, -1.0, Some(1e-3)));
    pooled.create(1e-3);
    assert_eq!(pooled.step(&[-50.0]), [0.0]);
    assert_eq!(pooled.pool.books().removed_j, 0.0);
}

/// Two points on one rail with a contact between them, the first driven by `force`: what is taken out of each energy.
fn removed(mass: [f64; 2], contact: (&[f64], f64), force: f64, energies: &[f64]) -> Vec<f64> {
    let model = LinearModel::new(&mass, &[0.0, 0.0], &[(&[1.0, 0.0], 0.0)]).over(&[contact]).moving(&[1.0, 1.0]);
    let of = |energy: &f64| {
        let mut pooled = Pooled::new(model.clone());
        pooled.create(*energy);
        pooled.step(&[force]);
        let books = pooled.pool.books();
        assert!(books.overdrawn_j() <= 1e-12 * energy && books.removed_j > 0.0, "{energy}: {books:?}");
        books.removed_j
    };
    energies.iter().map(of).collect()
}

#[test]
fn an_impulse_that_opens_a_contact_takes_out_no_more_than_was_created() {
    // The first pushes the second, until the impulse holds it back. Energies that leave the contact closed, and such that open it:
    // pushed by 3 N it carries 2 N · 10 ms. The driven point alone has ½ kg · (1 m/s)²: up to about half a joule can be had, and is.
    let energies = [1e-3, 0.1, 0.3, 0.45, 0.6, 10.0];
    let removed = removed([1.0, 2.0], (&[-1.0, 1.0], 0.0), 3.0, &energies);
    for (removed, energy) in removed.iter().zip(&energies[..4]) {
        approx::assert_relative_eq!(removed, energy, max_relative = 1e-9);
    }
}

#[test]
fn an_impulse_that_closes_a_contact_takes_out_no_more_than_was_created() {
    // Slowed until what comes after it is met: held by five kilograms from 0.1 m/s of slowing on, it gives more than its own half joule.
    let energies = [0.01, 0.2, 0.4, 0.8, 1.5];
    for (removed, energy) in removed([1.0, 5.0], (&[1.0, -1.0], 1e-3), 0.0, &energies).iter().zip(&energies) {
        approx::assert_relative_eq!(removed, energy, max_relative = 1e-9);
    }
}

/// Two bodies on rails above a floor, with one interface row or two.
fn any_system() -> impl Strategy<Value = (LinearModel, Vec<Vec<f64>>, f64)> {
    (1_usize..3).prop_flat_map(|rows| {
        let mass = prop::collection::vec(0.1..10.0_f64, 2);
        let v = prop::collection::vec(-2.0..2.0_f64, 2);
        let gaps = prop::collection::vec(prop_oneof![Just(0.0), 0.0..0.02_f64], 3);
        let forces = prop::collection::vec(prop::collection::vec(-100.0..100.0_f64, rows), 12);
        (mass, v, gaps, forces, -3.0..1.0_f64).prop_map(move |(mass, v, gaps, forces, magnitude)| {
            let interface = [(&[1.0, 0.0][..], 0.0), (&[0.5, -1.0][..], 0.0)];
            let unilateral = [(&[1.0, 0.0][..], gaps[0]), (&[0.0, 1.0][..], gaps[1]), (&[-1.0, 1.0][..], gaps[2])];
            let force: Vec<f64> = mass.iter().map(|mass| -9.81 * mass).collect();
            let model = LinearModel::new(&mass, &force, &interface[..rows]).over(&unilateral).moving(&v);
            (model, forces, 10.0_f64.powf(magnitude))
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 256, failure_persistence: None, rng_seed: RngSeed::Fixed(15), ..ProptestConfig::default()
    })]

    #[test]
    fn created_minus_removed_is_the_pool_which_only_shrinks_while_nothing_is_created(
        (model, forces, energy) in any_system(),
    ) {
        let mut pooled = Pooled::new(model);
        pooled.create(energy);
        let mut before = energy;
        for force in &forces {
            let impulse = pooled.step(force);
            let books = pooled.pool.books();
            // Some thirty roundings per step, of works and of velocities that the contact solver gave to its tolerance.
            let round_off = 1e-11 * (pooled.turnover + energy);
            // Removed as the mechanics received it: the interface work less that of the forces, which `sent` has.
            let removed = pooled.sent + energy - pooled.mechanics.interface_work().unwrap();
            prop_assert!((books.removed_j - removed).abs() <= round_off, "{books:?}, {removed} J");
            prop_assert!(books.overdrawn_j() <= round_off, "{books:?}");
            prop_assert!((books.created_j - energy).abs() <= round_off, "{books:?}");
            let pool = books.pool_j();
            prop_assert!(pool >= 0.0 && pool <= before + round_off, "{pool} J after {before} J");
            // An impulse was given only to take something out.
            if impulse.iter().any(|p| p.abs() > 1e-6) && before > 1e3 * round_off {
                prop_assert!(pool < before, "{impulse:?} took nothing out of {before} J");
            }
            before = pool;
        }
    }

    #[test]
    fn the_pool_shrinks_whenever_a_free_interface_moves(
        m in 0.1..10.0_f64, w in -2.0..2.0_f64, force in -100.0..100.0_f64, energy in 1e-3..10.0_f64,
    ) {
        let mut pooled = Pooled::new(point(m, w, None));
        pooled.create(energy);
        let mean = w + 0.5 * H * force / m;
        let there_is = 0.5 * m * mean * mean;
        pooled.step(&[force]);
        let removed = pooled.pool.books().removed_j;
        approx::assert_relative_eq!(removed, there_is.min(energy), max_relative = 1e-9, epsilon = 1e-12 * energy);
    }
}

fn pooled_spec(scheme: &str, macro_step: f64, energy_return: EnergyReturn) -> RunSpec {
    let usual = wedge_box_spec(scheme, macro_step);
    let model = usual.model.clone().map(|model| ModelOptions { energy_return, ..model });
    RunSpec { model, ..usual }
}

#[test]
fn the_audit_must_close_and_the_interface_must_create_no_more_than_the_pool_for_every_scheme_with_a_model() {
    for scheme in schemes().iter().filter(|scheme| scheme.has_model()) {
        for (integrator, kind) in [
            (MechanicsIntegrator::SemiImplicit, EnergyReturn::Pool),
            (MechanicsIntegrator::SemiImplicit, EnergyReturn::Balance),
            (MechanicsIntegrator::EventSplit, EnergyReturn::Pool),
        ] {
            let usual = pooled_spec(&scheme.name, 5e-3, kind);
            let result = run(&RunSpec { mechanics_integrator: integrator, ..usual });
            let name = format!("{} {integrator} {kind} ({})", scheme.name, result.report.outcome);
            let books = result.report.energy_return.unwrap();
            let residual = result.report.audit.work.residual_j().unwrap();
            let closure = result.report.audit.closure().unwrap();
            assert_eq!(result.report.scheme.dissipated_j, Some(books.removed_j), "{name}");
            if result.report.outcome != Outcome::Completed {
                continue;
            }
            let work = result.report.audit.work;
            // Each macro step adds some hundred micro steps of either work.
            let round_off = 1e-9 * (1.0 + work.sent_j.unwrap().abs() + books.created_j);
            assert!(residual >= -books.pool_j() - round_off, "{name}: {residual} J");
            assert!(closure.abs() <= 1e-8 * (2e3 + books.created_j), "{name}: {closure:e} J");
            // The last macro step's is still in the pool, or in the overdraft.
            let balance = books.created_j - books.removed_j;
            assert_eq!(books.pool_j() - books.overdrawn_j(), balance, "{name}");
            if kind == EnergyReturn::Balance {
                assert!((residual + balance).abs() <= round_off, "{name}: {residual} J, {books:?}");
                continue;
            }
            assert!(books.created_j > 0.0, "{name}: nothing was ever created, the test says nothing");
            if integrator == MechanicsIntegrator::SemiImplicit {
                assert!(books.overdrawn_j() <= round_off, "{name}: {books:?}");
            }
        }
    }
}

#[test]
fn energy_can_be_returned_on_every_case_on_which_a_scheme_with_a_model_runs() {
    let mut ran = 0;
    for case in cases() {
        let duration = 4.0 * case.defaults.macro_step_s;
        let usual = RunSpec { duration, ..usual_spec(&case.name, "rim-smooth", case.defaults.macro_step_s) };
        let model = usual.model.clone().map(|model| ModelOptions { energy_return: EnergyReturn::Pool, ..model });
        let skips = |spec: &RunSpec| matches!(run(spec).report.outcome, Outcome::Skipped { .. });
        let without = skips(&usual);
        let returned = RunSpec { model, ..usual };
        if has_friction(&returned.parameters) {
            let refused = simulate(&returned, Bounds::default(), None, StopFlag::never());
            assert!(refused.is_err_and(|error| error.to_string().contains("friction")), "{}", case.name);
            continue;
        }
        assert_eq!(skips(&returned), without, "{}", case.name);
        ran += usize::from(!without);
    }
    assert!(ran > 12, "only {ran} cases");
}

#[test]
fn who_does_not_count_its_way_has_no_energy_returned() {
    let (mut mechanics, mut springs) = (stepper(point(1.0, 1.0, None), PLASTIC), Springs::new(&[1.0], &[0.0]));
    assert!(counts_interface_way(sides(&mut mechanics, &mut springs)));
    // A spring has no way of its own to count.
    let mut other = springs.clone();
    assert!(!counts_interface_way(sides(&mut springs, &mut other)));
}
