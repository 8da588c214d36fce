//! What the harness costs on top of the runs: overhead per run, gain from a second core, memory over many runs, start on a
//! large store.
//!
//! Everything is compared within this process. Ratios matter; times are printed beside them.

use rimbench::catalogue::Catalogue;
use rimbench::cosim::{Bounds, StopFlag};
use rimbench::harness::{Cache, Experiment, Job, Record, Store, monotonic_clock, run_job};
use rimbench::runs::{RunRequest, RunSpec, simulate};
use rimbench::statistics::median;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

/// 400 runs of the shortest kind: signal-based and diverging early would be shorter, but is no run to speak of.
const EXPERIMENT: &str = r#"
question = "What does the harness cost?"
macro_steps_s = [5e-3]
phases = 400

[[cases]]
name = "wedge-box"

[[schemes]]
scheme = "rim-smooth"
"#;

/// Short runs, to be many.
fn many(runs: usize) -> String {
    format!("duration_s = 0.05\n{}", EXPERIMENT.replace("phases = 400", &format!("phases = {runs}")))
}

/// Most memory this process has held so far, kB, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.split_whitespace().next()?.parse().ok()
}

fn seconds(task: impl FnOnce()) -> f64 {
    let start = Instant::now();
    task();
    start.elapsed().as_secs_f64()
}

fn main() {
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let cache = Cache::in_folder(folder.path().join("cache"));
    // First, because the most memory ever held is what the system tells.
    memory(folder.path(), &cache);
    overhead(folder.path(), &cache);
    large_store(folder.path());
}

/// Memory over many runs.
fn memory(folder: &Path, cache: &Cache) {
    let peaks = [1_000, 10_000].map(|runs| {
        let file = folder.join(format!("many-{runs}.toml"));
        std::fs::write(&file, many(runs)).expect("the experiment can be written");
        let experiment = Experiment::read(&file).expect("the experiment is valid");
        let results = folder.join(format!("many-{runs}"));
        let job = Job {
            experiment: &experiment,
            catalogue: &Catalogue::standard(),
            folder: &results,
            quick: false,
            fresh: true,
            shard: None,
            cache,
            build: &rimbench::BUILD,
        };
        let summary = run_job(job, &|_| {}, StopFlag::never()).expect("the sweep runs");
        assert_eq!((summary.computed, summary.missing), (runs, 0));
        peak_memory()
    });
    match peaks {
        [Some(few), Some(many)] => println!(
            "peak memory: {:.1} MB after 1000 runs, {:.1} MB after 10 000: {:.2} kB for each run more (plan and index)",
            few as f64 / 1024.0,
            many as f64 / 1024.0,
            (many - few) as f64 / 9000.0
        ),
        _ => println!("peak memory: this system does not tell"),
    }
}

/// Overhead per run, and gain from a second core.
fn overhead(folder: &Path, cache: &Cache) {
    let experiment = |runs: usize| {
        let file = folder.join(format!("overhead-{runs}.toml"));
        let text = EXPERIMENT.replace("phases = 400", &format!("phases = {runs}"));
        std::fs::write(&file, text).expect("the experiment can be written");
        Experiment::read(&file).expect("the experiment is valid")
    };
    let (whole, tenth) = (experiment(400), experiment(40));
    let sweep = |experiment: &Experiment, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let results = folder.join(experiment.name());
        let job = Job {
            experiment,
            catalogue: &Catalogue::standard(),
            folder: &results,
            quick: false,
            fresh: true,
            shard: None,
            cache,
            build: &rimbench::BUILD,
        };
        pool.install(|| run_job(job, &|_| {}, StopFlag::never()).expect("the sweep runs"));
    };
    let request = RunRequest { macro_step_s: Some(5e-3), ..RunRequest::of("wedge-box", "rim-smooth") };
    let usual = request.resolve(&Catalogue::standard()).expect("the run is valid");
    let specs: Vec<RunSpec> =
        rimbench::harness::phase_ensemble(400).into_iter().map(|phase| RunSpec { phase, ..usual.clone() }).collect();
    let bare = || {
        for spec in &specs {
            let run = simulate(spec, Bounds::default(), Some(monotonic_clock), StopFlag::never());
            black_box(run.expect("the run is valid"));
        }
    };
    // The reference is in the cache before anything is timed.
    sweep(&whole, 2);
    let (mut bares, mut ones, mut tenths, mut twos) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for _ in 0..7 {
        bares.push(seconds(bare));
        ones.push(seconds(|| sweep(&whole, 1)));
        tenths.push(seconds(|| sweep(&tenth, 1)));
        twos.push(seconds(|| sweep(&whole, 2)));
    }
    let [bare, one, tenth, two] = [bares, ones, tenths, twos].map(|times| median(times).unwrap());
    // What a sweep costs once, to read the reference and to ask git, is not what a run costs.
    let per_run = (one - tenth) / 360.0;
    println!("400 runs at 5 ms: bare {bare:.3} s, harness with one thread {one:.3} s, with two {two:.3} s");
    println!("overhead of the harness: {:.1} % of each run", 100.0 * (per_run / (bare / 400.0) - 1.0));
    println!("once per sweep: {:.0} ms (reference, revision, files)", 1e3 * (one - 400.0 * per_run));
    println!("two threads: {:.2} times as fast as one", one / two);
}

/// Start on a large store.
fn large_store(folder: &Path) {
    let records = folder.join("large");
    let store = Store::open(&records, "large", "columns").expect("an empty store");
    let append = seconds(|| {
        for index in 0..100_000_u64 {
            let run_id = format!("{index:016x}");
            let row = |width: usize| format!("{run_id}{}", ",0.123456789012345".repeat(width));
            let (findings, costs, provenance) = (row(40), row(5), row(7));
            let record = Record { run_id, findings, costs, provenance, trace: None, wall_limit_s: None };
            store.append(&record).expect("a record is appended");
        }
    });
    let open = seconds(|| {
        let store = Store::open(&records, "large", "columns").expect("the store opens");
        assert_eq!((store.len(), store.damaged), (100_000, 0));
    });
    println!("store of 100 000 records: appended in {append:.2} s, opened in {open:.2} s");
}
