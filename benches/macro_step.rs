//! Whole runs of the wedge box with recording, per macro step: the reference, and the two non-smooth schemes at 5 ms.
//!
//! Each run is checked once against the force peaks it is known to have before it is timed.

#[path = "support/figures.rs"]
mod figures;
mod support;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use figures::criterion_with_typeface;
use std::hint::black_box;
use support::{DURATION, wedge_box};

/// Scheme, macro step (s), least and greatest actuator force (N).
const RUNS: [(&str, f64, [f64; 2]); 3] = [
    ("zero-order-hold", 2e-4, [-771.8, 1040.7]),
    ("rim-nonsmooth", 5e-3, [-578.1, 991.4]),
    ("rim-nonsmooth-gap", 5e-3, [-411.7, 991.4]),
];

fn macro_step(c: &mut Criterion) {
    let mut group = c.benchmark_group("macro_step");
    for (scheme, macro_step, [least, greatest]) in RUNS {
        let trajectory = wedge_box(scheme, macro_step);
        let force = trajectory.index_of("actuator_force_n").unwrap();
        let peaks = trajectory.column(force).fold([0.0, 0.0], |[low, high]: [f64; 2], f| [low.min(f), high.max(f)]);
        assert!((peaks[0] - least).abs() < 0.06 && (peaks[1] - greatest).abs() < 0.06, "{scheme}: {peaks:?}");

        group.throughput(Throughput::Elements((DURATION / macro_step).round() as u64));
        group.sample_size(20);
        group.bench_function(format!("{scheme}/{:.1}ms", 1e3 * macro_step), |bencher| {
            bencher.iter(|| wedge_box(black_box(scheme), black_box(macro_step)));
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = criterion_with_typeface();
    targets = macro_step
}
criterion_main!(benches);
