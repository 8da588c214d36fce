//! The kernels of one exchange, alone: elimination (Eq. 3 → Eq. 4), condensation, mechanics step, hydraulics step, and the
//! input of `rim-nonsmooth`. Each is checked once against a known answer before it is timed.
//!
//! The state is the start of the wedge box: right wedge and disc-ledge closed, effective mass 250 kg.
//!
//! # Floating-point operations of a mechanics step, counted by hand
//! n = 6 velocities, 2 joint rows over two bodies, 4 contact rows and 1 interface row over one body (3 nonzeros), two
//! contacts and the interface carry impulse. Additions, multiplications, divisions and roots count one, sine and cosine 20
//! each; comparisons nothing.
//!
//! ```text
//! assemble    sin, cos 40 · four arms 24 · joints 20 · contacts 40 · vertex or ramp 15 · interface 30            170
//! eliminate   M⁻¹, M⁻¹f, A_b M⁻¹ 24 · S 33 · A_b v, A_b M⁻¹f 52 · Cholesky 5 · s, r 10 · Y 25 · v̂, α 48          200
//!             five rows of C 10, G 27, w 5, a 6: 240 · fifteen entries of H: 75                                   315
//! contacts    right-hand side 28 · active set of two 14 · w 16 · residual 44                                      100
//! integrate   v⁺ 48 · P_b 32 · v̄, Δv 18 · work of f and five rows 72 · kinetic 18 · account 15 · q⁺ 12           215
//!                                                                                                       total  ≈ 1000
//! ```
//! A core that does two scalar operations per cycle at 4 GHz needs at least 125 ns for them.

#[path = "support/figures.rs"]
mod figures;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use figures::criterion_with_typeface;
use nalgebra::DMatrix;
use rimbench::cases::{Case, CoupledSystem, wedge_box_geometry};
use rimbench::catalogue::Catalogue;
use rimbench::complementarity::SolverEntry;
use rimbench::cosim::{Abilities, CommunicationGrid, MicroStep, PerSide, Sample, Side, Subsystem};
use rimbench::interface_model::{Condensation, Elimination, MassMatrix, ReducedInterfaceModel, Redundancy, condense};
use rimbench::mechanics::{ContactLaw, NonSmoothMechanics};
use rimbench::models::WedgeBox;
use std::hint::black_box;
use std::sync::Arc;

/// kg, at the start of the wedge box.
const EFFECTIVE_MASS: f64 = 250.0;
/// N.
const FORCE: f64 = 250.0;
const STEP: f64 = 2e-4;

fn wedge_box() -> Arc<Case> {
    Catalogue::standard().case("wedge-box").unwrap().clone()
}

fn system() -> CoupledSystem {
    let case = wedge_box();
    (case.build)(&case.default_parameters(), &SolverEntry::active_set()).unwrap()
}

fn mechanics() -> NonSmoothMechanics<WedgeBox> {
    let parameters = wedge_box().default_parameters();
    let model = WedgeBox::new(wedge_box_geometry(&parameters)).unwrap();
    let law = ContactLaw { stabilisation: 0.2, restitution: 0.0, spring: None };
    let ports = system().sides.mechanics.ports().clone();
    NonSmoothMechanics::new(model, law, ports, SolverEntry::active_set().checked(4))
}

fn elimination(c: &mut Criterion) {
    let mechanics = mechanics();
    let (eq3, v) = (mechanics.linearisation(), mechanics.velocity());
    let (n_u, n_i) = (eq3.unilateral.len(), eq3.interface.len());
    let mut elimination = Elimination::new(eq3);
    let mut model = ReducedInterfaceModel::zeros(n_u, n_i);
    elimination.reduce(eq3, v, STEP, 0.2, &mut model).unwrap();

    // G is the upper left block of the inverse of [M A_bᵀ; A_b 0].
    let MassMatrix::Diagonal(mass) = &eq3.mass else { unreachable!("planar bodies in maximal coordinates") };
    let (n, n_b) = (mass.len(), eq3.bilateral.len());
    let mut kkt = DMatrix::zeros(n + n_b, n + n_b);
    for k in 0..n {
        kkt[(k, k)] = mass[k];
        for b in 0..n_b {
            kkt[(n + b, k)] = eq3.bilateral.row(b)[k];
            kkt[(k, n + b)] = eq3.bilateral.row(b)[k];
        }
    }
    let g = kkt.try_inverse().unwrap().view((0, 0), (n, n)).into_owned();
    let a = DMatrix::from_fn(n_u + n_i, n, |row, k| {
        if row < n_u { eq3.unilateral.row(row)[k] } else { eq3.interface.row(row - n_u)[k] }
    });
    let expected = &a * g * a.transpose();
    assert!((0..n_u + n_i).all(|x| (0..n_u + n_i).all(|y| (model.entry(x, y) - expected[(x, y)]).abs() < 1e-15)));

    c.bench_function("kernels/elimination", |bencher| {
        bencher.iter(|| {
            elimination.reduce(black_box(eq3), black_box(v), STEP, 0.2, &mut model).unwrap();
            black_box(&model);
        });
    });
}

fn condensation(c: &mut Criterion) {
    let mut model = ReducedInterfaceModel::zeros(4, 1);
    mechanics().interface_model(STEP, &mut model).unwrap();
    let mut closed = Vec::with_capacity(4);
    model.closed_contacts(&mut closed);
    let mut out = Condensation::new(4, 1);
    condense(&model, &closed, Redundancy::Drop, &mut out);
    assert_eq!(out.rank, 2);
    assert!((out.effective_mass - EFFECTIVE_MASS).abs() < 1e-9);
    c.bench_function("kernels/condense", |bencher| {
        bencher.iter(|| condense(black_box(&model), black_box(&closed), Redundancy::Drop, &mut out));
    });
}

fn mechanics_step(c: &mut Criterion) {
    const STEPS: usize = 100;
    let run = |mechanics: &mut NonSmoothMechanics<WedgeBox>| {
        for step in 0..STEPS {
            mechanics.step(step as f64 * STEP, black_box(&[FORCE]), STEP).unwrap();
        }
    };
    let mut checked = mechanics();
    run(&mut checked);
    let mut y = [0.0; 2];
    checked.outputs(&[FORCE], &mut y).unwrap();
    // The box slides level with itself on wedge and ledge.
    assert!((y[1] - FORCE / EFFECTIVE_MASS * STEPS as f64 * STEP).abs() < 1e-6, "{}", y[1]);
    assert!(checked.ledger().identity_residual < 1e-12);

    let mut group = c.benchmark_group("kernels");
    group.throughput(Throughput::Elements(STEPS as u64));
    group.bench_function("mechanics_step", |bencher| bencher.iter_batched_ref(mechanics, run, BatchSize::SmallInput));
    group.finish();
}

fn hydraulics_step(c: &mut Criterion) {
    let PerSide { mut mechanics, mut actuator } = system().sides;
    let mut y = [0.0; 2];
    mechanics.outputs(&[0.0], &mut y).unwrap();
    // With the spool in the middle the start pressures, half way between pump and tank, are an equilibrium.
    let run = |actuator: &mut dyn Subsystem| actuator.step(0.0, black_box(&y), 5e-5).unwrap();
    run(&mut *actuator);
    let mut force = [f64::NAN];
    actuator.outputs(&y, &mut force).unwrap();
    assert!(force[0].abs() < 1e-6);
    c.bench_function("kernels/hydraulics_step", |bencher| bencher.iter(|| run(&mut *actuator)));
}

fn rim_nonsmooth_input(c: &mut Criterion) {
    const MICRO_STEPS: usize = 100;
    let mut sides = system().sides;
    let coupling = Catalogue::standard().scheme("rim-nonsmooth").unwrap().couple(sides.lend(), None, None).unwrap();
    let (mut scheme, mut model) = (coupling.scheme, coupling.attachments.interface_model.unwrap());
    let mechanics = &mut sides.mechanics;
    mechanics.abilities().interface_model(5e-3, &mut model).unwrap();
    let mut y = [0.0; 2];
    mechanics.outputs(&[0.0], &mut y).unwrap();
    let step = CommunicationGrid::new(5e-3, 1.0, 1.0).unwrap().step(0);
    let mut run = || {
        let sample = Sample { model: Some(&model), ..Sample::of_outputs(step, &y, 5e-5) };
        scheme.receive(Side::Mechanics, &sample).unwrap();
        let mut u = y;
        for index in 0..MICRO_STEPS {
            let at = MicroStep::new(step, index, MICRO_STEPS);
            scheme.input(Side::Actuator, at, black_box(&[FORCE]), &mut u).unwrap();
        }
        u[1]
    };
    assert!((run() - FORCE / EFFECTIVE_MASS * 5e-3).abs() < 1e-12);

    let mut group = c.benchmark_group("kernels");
    group.throughput(Throughput::Elements(MICRO_STEPS as u64));
    group.bench_function("rim_nonsmooth_input", |bencher| bencher.iter(&mut run));
    group.finish();
}

criterion_group! {
    name = benches;
    config = criterion_with_typeface();
    targets = elimination, condensation, mechanics_step, hydraulics_step, rim_nonsmooth_input
}
criterion_main!(benches);
