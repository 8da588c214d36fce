//! The energy that an interface model without contacts creates (docs/method/no-heavier-than-the-mechanics.md): the
//! identity to round-off, and no growth if and only if the model is no heavier than the mechanics.

use crate::random_bodies::*;
use crate::support::*;
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// `Σ_j P_jᵀ(H_mech − H_model)…` telescopes: the total impulse alone counts, and of the bias the first moment within
/// each piece.
#[test]
fn without_contacts_the_energy_created_is_that_of_the_mass_and_of_the_first_moment() {
    let rng = &mut Pcg64::seed_from_u64(1);
    for case in 0..200 {
        let (interface, pieces) = (rng.random_range(1..3), rng.random_range(1..4_u32));
        let model = body(rng, 0, interface);
        let mut played = Played::random(rng, 12, interface);
        let forces = played.forces.clone();
        let wrong = semidefinite(rng, interface, interface);
        let difference = wrong.clone();
        let mut mechanics = Misreported {
            inner: stepper(model.clone(), PLASTIC),
            change: move |model: &mut ReducedInterfaceModel| {
                model.h.iter_mut().zip(wrong.iter()).for_each(|(h, more)| *h = 0.5 * *h + more);
            },
        };
        let profile = case % 2 == 0;
        let force_return = if profile { ForceReturn::Profile } else { ForceReturn::Mean };
        let report = macro_step(
            (&mut mechanics, &mut played),
            ("rim-nonsmooth", &ModelOptions::default()),
            (12, pieces, force_return),
        );
        let created = -report.audit.work.residual_j().unwrap();

        let (_, eq4) = reduce(&linearise(&mut model.clone(), &model.q, &model.v), &model.v, H, 0.0);
        let own = DMatrix::from_row_slice(interface, interface, &eq4.h);
        let a = DVector::from_column_slice(&eq4.a);
        let (delta, h) = (H / 12.0, H / f64::from(pieces));
        let impulse = |force: &[f64]| delta * DVector::from_column_slice(force);
        let total: DVector<f64> = forces.iter().map(|force| impulse(force)).sum();
        let mut wanted = 0.5 * total.dot(&((&own - 0.5 * &own - &difference) * &total));
        // ½ h_j p_j − ∫ (t − t_j) λ dt, with the mean force spread over all pieces.
        for (index, force) in forces.iter().enumerate() {
            let piece = (index * pieces as usize) / 12;
            let middle = (index as f64 + 0.5) * delta - piece as f64 * h;
            wanted +=
                a.dot(&impulse(force)) * if profile { 0.5 * h - middle } else { 0.5 * H - middle - piece as f64 * h };
        }
        let scale = wanted.abs() + total.norm_squared() + a.norm() * total.norm();
        assert!((created - wanted).abs() < ROUND_OFF * scale, "case {case}: {created:e}, not {wanted:e}");
        // The account tells both apart: what the mechanics' own mass adds is not that of the frozen model.
        let model = report.audit.model.unwrap();
        let mass = 0.5 * total.dot(&((&own - 0.5 * &own - &difference) * &total));
        for (name, one, other) in [
            ("jump", model.jump, 0.0),
            ("first moment", model.first_moment, wanted - mass),
            ("contacts", model.contacts, 0.0),
            ("unfrozen", model.unfrozen, mass),
        ] {
            assert!((one - other).abs() < 10.0 * ROUND_OFF * scale, "case {case}, {name}: {one:e}, not {other:e}");
        }
    }
}

/// A spring `f' = −K w` whose micro step conserves `½ fᵀK⁻¹f` plus the energy of a model of mobility `h`: the implicit
/// midpoint rule, solved with that mobility.
struct Spring {
    stiffness: Matrix2<f64>,
    h: Matrix2<f64>,
    length: f64,
    force: Vector2<f64>,
    before: Vector2<f64>,
    ports: Ports,
}

impl Capabilities for Spring {}

impl Subsystem for Spring {
    subsystem_methods!(ports capabilities no_counters no_clone);

    fn outputs(&mut self, u: &[f64], y: &mut [f64]) -> Result<(), Failure> {
        self.before = Vector2::new(u[2], u[3]);
        let half = 0.5 * self.length;
        let left = Matrix2::identity() + half * half * self.stiffness * self.h;
        let mean = left.lu().solve(&(self.force - half * self.stiffness * self.before)).unwrap();
        y.copy_from_slice(mean.as_slice());
        Ok(())
    }
    fn step(&mut self, _t: f64, u: &[f64], h: f64) -> Result<(), Failure> {
        self.force -= 0.5 * h * self.stiffness * (self.before + Vector2::new(u[2], u[3]));
        Ok(())
    }
}

/// Velocity and force after one macro step of a mechanics of mobility `own` with a model of mobility `told`.
fn after_one_step(
    own: Matrix2<f64>,
    told: Matrix2<f64>,
    stiffness: Matrix2<f64>,
    start: [Vector2<f64>; 2],
) -> [Vector2<f64>; 2] {
    // Two masses of 1 kg seen through the square root of the mobility.
    let half = own.cholesky().unwrap().l();
    let rows = [[half[(0, 0)], half[(0, 1)]], [half[(1, 0)], half[(1, 1)]]];
    let v = half.lu().solve(&start[0]).unwrap();
    let model = LinearModel::new(&[1.0; 2], &[0.0; 2], &[(&rows[0], 0.0), (&rows[1], 0.0)]).moving(v.as_slice());
    let inner = stepper(model, PLASTIC);
    let mut mechanics = Misreported {
        inner,
        change: move |model: &mut ReducedInterfaceModel| model.h.copy_from_slice(told.transpose().as_slice()),
    };
    let (micro_steps, zero) = (8, Vector2::zeros());
    let length = H / micro_steps as f64;
    let ports = force_displacement_ports(2).1;
    let mut spring = Spring { stiffness, h: told, length, force: start[1], before: zero, ports };
    let plain = ("rim-nonsmooth", &ModelOptions::default());
    macro_step((&mut mechanics, &mut spring), plain, (micro_steps, 1, ForceReturn::Mean));
    [half * Vector2::from_column_slice(mechanics.inner.velocity()), spring.force]
}

#[test]
fn a_model_is_passive_for_every_spring_if_and_only_if_it_is_no_heavier_than_the_mechanics() {
    let rng = &mut Pcg64::seed_from_u64(3);
    let square = |matrix: DMatrix<f64>| Matrix2::from_iterator(matrix.iter().copied());
    let definite = |rng: &mut Pcg64| square(semidefinite(rng, 2, 2)) + 0.1 * Matrix2::identity();
    let vector = |rng: &mut Pcg64| Vector2::from_vec(draw(rng, 2, 1.0));
    let inverse = |matrix: &Matrix2<f64>| matrix.try_inverse().unwrap();
    for case in 0..100 {
        let own = definite(rng);
        // No heavier in any direction, equal in one: no spring gains energy.
        let lighter = own + square(semidefinite(rng, 2, 1));
        let stiffness = 10.0_f64.powf(rng.random_range(-1.0..3.0)) * definite(rng);
        let energy =
            |[w, f]: [Vector2<f64>; 2]| 0.5 * (w.dot(&(inverse(&own) * w)) + f.dot(&(inverse(&stiffness) * f)));
        let start = [vector(rng), 5.0 * vector(rng)];
        let end = after_one_step(own, lighter, stiffness, start);
        assert!(energy(end) <= energy(start) * (1.0 + ROUND_OFF), "case {case}: {} > {}", energy(end), energy(start));

        // Heavier by ρ in one direction: a spring along it grows by det = ρ + (1 − ρ) cos Ω per macro step.
        let u = vector(rng).normalize();
        let mobility = u.dot(&(own * u));
        let rho = rng.random_range(1.05..4.0);
        let heavier = own - (1.0 - 1.0 / rho) * own * u * (own * u).transpose() / mobility;
        let told = u.dot(&(heavier * u));
        assert!((mobility / told / rho - 1.0).abs() < 1e-9);
        let k = rng.random_range(0.1..400.0);
        // The angle of a conserving micro step, eight times.
        let angle = 16.0 * (0.5 * H / 8.0 * (k * told).sqrt()).atan();
        let map = [[u, Vector2::zeros()], [Vector2::zeros(), u]]
            .map(|start| after_one_step(own, heavier, k * u * u.transpose(), start).map(|vector| u.dot(&vector)));
        let (trace, determinant) = (map[0][0] + map[1][1], map[0][0] * map[1][1] - map[0][1] * map[1][0]);
        let wanted = [1.0 - rho + (1.0 + rho) * angle.cos(), rho + (1.0 - rho) * angle.cos()];
        assert!((trace - wanted[0]).abs() < 1e-10 * rho, "case {case}: trace {trace}, not {}", wanted[0]);
        assert!((determinant - wanted[1]).abs() < 1e-10 * rho, "case {case}: {determinant}, not {}", wanted[1]);
        assert!(determinant > 1.0 + 1e-6, "it grows");
    }
}
