//! The suite of `rimbench perf` under criterion, and the reference run of the wedge box by a plain compiled
//! implementation.
//!
//! Each benchmark is checked once against the answer it must give. The plain implementation comes in two sizes. With
//! the *same* effort it compares all active sets and records what we record; it is demanded to take 8 times as long as
//! `wedge-box/zero-order-hold`. With the *least* it takes the first active set that fits and records three numbers.
//! That its forces are ours is a test of its own.

use criterion::{Criterion, criterion_group, criterion_main};
use rimbench::perf::BENCHMARKS;
use rimbench_independent::plain_wedge_box::{Effort, PlainWedgeBox};
use std::hint::black_box;

fn suite(c: &mut Criterion) {
    for benchmark in BENCHMARKS {
        let mut repetition = benchmark.prepare().unwrap();
        let fault = benchmark.fault(repetition().unwrap().answer);
        assert!(fault.is_none(), "{}: {fault:?}", benchmark.name);
        c.bench_function(&benchmark.name, |bencher| bencher.iter(|| repetition().unwrap()));
    }
}

fn plain(c: &mut Criterion) {
    for (name, effort) in [("same", Effort::Same), ("least", Effort::Least)] {
        // Macro steps of 0.2 ms, each of four micro steps, for 2.5 s.
        let run = || PlainWedgeBox::new(effort).run(black_box(2e-4), 4, 12_500);
        c.bench_function(&format!("wedge-box/plain, {name} effort"), |bencher| bencher.iter(run));
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = suite, plain
}
criterion_main!(benches);
