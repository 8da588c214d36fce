//! Cost of one `input` call of each scheme that is not a ceiling, both ways, for an interface of one row and no contact (what
//! contacts cost is in `kernels` and `scaling`).
//!
//! Each is checked once before it is timed: an interface at rest under load must be left at rest. One iteration is a macro step
//! of 100 calls to the actuator's side, or as many to the mechanics'; the time per element is that of one call.
//!
//! Measured side by side on a shared machine, ns per call beyond the 7.7 ns of the zero-order hold, to the actuator and to the
//! mechanics: first-order hold 15 and 13, second-order hold 18 and 18, transmission line 12 and 1; all other signal-based schemes within 2. Model-based: interface Jacobian −2, fixed mass 7, smooth 9, non-smooth 22.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use rimbench::cosim::{
    CommunicationGrid, CouplingScheme, MicroStep, OutputRates, PerSide, Port, Ports, Quantity, Sample, Side,
};
use rimbench::interface_model::ReducedInterfaceModel;
use rimbench::schemes::{Construction, ModelConstruction, ModelOptions, SchemeEntry, standard_schemes};
use std::hint::black_box;

const MICRO_STEPS: usize = 100;
const REST: [f64; 2] = [0.7, 0.0];
const FORCE: [f64; 1] = [300.0];

/// The scheme after five exchanges over an interface at rest.
fn settled(entry: &SchemeEntry) -> Box<dyn CouplingScheme> {
    let port = |name: &'static str, quantity| Port::new(name, quantity);
    let motion = vec![port("position_m", Quantity::Position), port("velocity_m_s", Quantity::Velocity)];
    let force = vec![port("force_n", Quantity::Force)];
    let mechanics = Ports { inputs: force.clone(), outputs: motion.clone(), direct_feedthrough: false };
    let actuator = Ports { inputs: motion, outputs: force, direct_feedthrough: true };
    let gain = entry.gain_value(None).unwrap().unwrap_or(1.0);
    let mut model = ReducedInterfaceModel::zeros(0, 1);
    let options = ModelOptions::default();
    let construction = Construction {
        ports: PerSide { mechanics: &mechanics, actuator: &actuator },
        model: entry.has_model().then_some(ModelConstruction {
            empty: &model,
            options: &options,
            detection: entry.detection(None).unwrap(),
        }),
        gain,
    };
    let mut scheme = (entry.build)(&construction).unwrap();
    // The load is carried: 300 N on 1 kg against the free acceleration.
    (model.h[0], model.a[0], model.position[0]) = (1.0, -FORCE[0], REST[0]);
    let rates = OutputRates { rate: vec![0.0], feedthrough: vec![0.0, -2.0], rate_gain: vec![0.0, -4.0] };
    let grid = CommunicationGrid::new(1e-3, 1.0, 1.0).unwrap();
    for k in 0..5 {
        let step = grid.step(k);
        let sample = Sample { model: Some(&model), ..Sample::of_outputs(step, &REST, 1e-5) };
        scheme.receive(Side::Mechanics, &sample).unwrap();
        let sample = Sample { y: &FORCE, model: None, rates: Some(&rates), ..sample };
        scheme.receive(Side::Actuator, &sample).unwrap();
        if k < 4 {
            calls(&mut *scheme, k, Side::Actuator);
            calls(&mut *scheme, k, Side::Mechanics);
        }
    }
    scheme
}

/// The calls of macro step `k`; returns the last input.
fn calls(scheme: &mut dyn CouplingScheme, k: usize, to: Side) -> f64 {
    let step = CommunicationGrid::new(1e-3, 1.0, 1.0).unwrap().step(k);
    let (mut u, mut received) = (REST, FORCE);
    for j in 0..MICRO_STEPS {
        let at = MicroStep::new(step, j, MICRO_STEPS);
        match to {
            Side::Actuator => scheme.input(to, at, black_box(&FORCE), &mut u).unwrap(),
            Side::Mechanics => scheme.input(to, at, black_box(&REST), &mut received).unwrap(),
        }
    }
    match to {
        Side::Actuator => u[0],
        Side::Mechanics => received[0],
    }
}

fn input(c: &mut Criterion) {
    for (to, name, expected) in [(Side::Actuator, "to_actuator", REST[0]), (Side::Mechanics, "to_mechanics", FORCE[0])]
    {
        let mut group = c.benchmark_group(format!("input_{name}"));
        group.throughput(Throughput::Elements(MICRO_STEPS as u64));
        for entry in standard_schemes().iter().filter(|entry| entry.real_time()) {
            let mut scheme = settled(entry);
            let found = calls(&mut *scheme, 4, to);
            // The ablation knows no free acceleration and falls: Σ (j + 1) δ² λ over 100 steps of 10 µs.
            let sags = entry.name == "rim-fixed-mass" && to == Side::Actuator;
            let expected = if sags { expected + 300.0 * 1e-10 * 5050.0 } else { expected };
            assert!((found - expected).abs() < 1e-11, "{}: {found} instead of {expected}", entry.name);
            group.bench_function(&*entry.name, |bencher| bencher.iter(|| calls(black_box(&mut *scheme), 4, to)));
        }
        group.finish();
    }
}

criterion_group! {
    name = benches;
    // A scheme whose calls all take the same time leaves nothing to plot.
    config = Criterion::default().without_plots();
    targets = input
}
criterion_main!(benches);
