//! What the boundaries cost: a call of an exported FMU beside the subsystem called directly, and whole runs whose sides are
//! FMUs beside those of the case that they were made from.
//!
//! All in this one process and turn by turn, so that a slow moment of the machine hits all; what counts is the difference of the medians.
//! Both ways give the same digits, which is checked before anything is timed. The library that the FMUs hold is the one that Cargo has
//! built beside this bench; the processes of FMUs are this bench as well. Without `--bench` only the agreement is checked.

#![allow(unsafe_code, reason = "the functions of the library, as another master calls them")]

use rimbench_cases::catalogue::Catalogue;
use rimbench_cases::runs::{RunRequest, RunSpec, simulate};
use rimbench_core::cosim::{Bounds, Outcome, Side, StopFlag};
use rimbench_fmi::export::{Contents, RESOURCE, Variables, build_side, find_library, pack, side_name};
use rimbench_fmi::import::{WORKER, read_case, serve};
use rimbench_statistics::median;
use std::ffi::{CString, c_char, c_void};
use std::hint::black_box;
use std::path::Path;
use std::ptr;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// Turns of which the median is taken.
const TURNS: usize = 15;
/// Macro step, s.
const STEP: f64 = 1e-3;
/// Calls that are timed at once.
const STEPS: usize = 2000;

unsafe extern "C" {
    fn fmi3InstantiateCoSimulation(
        name: *const c_char,
        token: *const c_char,
        resources: *const c_char,
        visible: bool,
        logging: bool,
        event_mode: bool,
        early_return: bool,
        intermediate: *const u32,
        intermediates: usize,
        environment: *mut c_void,
        log: *const c_void,
        update: *const c_void,
    ) -> *mut c_void;
    fn fmi3EnterInitializationMode(
        h: *mut c_void,
        tolerant: bool,
        tolerance: f64,
        t: f64,
        stops: bool,
        end: f64,
    ) -> i32;
    fn fmi3ExitInitializationMode(h: *mut c_void) -> i32;
    fn fmi3SetBoolean(h: *mut c_void, refs: *const u32, n: usize, values: *const u8, count: usize) -> i32;
    fn fmi3SetFloat64(h: *mut c_void, refs: *const u32, n: usize, values: *const f64, count: usize) -> i32;
    fn fmi3GetFloat64(h: *mut c_void, refs: *const u32, n: usize, values: *mut f64, count: usize) -> i32;
    fn fmi3DoStep(
        h: *mut c_void,
        t: f64,
        length: f64,
        no_way_back: bool,
        event: *mut bool,
        terminate: *mut bool,
        early: *mut bool,
        last: *mut f64,
    ) -> i32;
    fn fmi3FreeInstance(h: *mut c_void);
}

/// Time since somebody first asked.
fn clock() -> Duration {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}

/// An exported FMU, as a master calls it.
struct Called {
    instance: *mut c_void,
    inputs: Vec<u32>,
    outputs: Vec<u32>,
}

impl Called {
    fn new(spec: &RunSpec, side: Side, serialisable: bool) -> Self {
        let folder = tempfile::tempdir().unwrap();
        // One step of its own per communication step, as the subsystem beside it takes.
        let contents = Contents { longest_step_s: 0.0, ..Contents::of(spec, side) };
        std::fs::write(folder.path().join(RESOURCE), serde_json::to_string(&contents).unwrap()).unwrap();
        let variables = Variables::of(&spec.case, side, &spec.parameters).unwrap();
        let noted = variables.list.iter().position(|variable| variable.name == "serialisable").unwrap() as u32;
        let token = CString::new(contents.token()).unwrap();
        let place = CString::new(folder.path().display().to_string()).unwrap();
        // SAFETY: texts that end in zero, and null where the standard allows it.
        let instance = unsafe {
            let null = ptr::null();
            let (name, none) = (c"bench".as_ptr(), ptr::null_mut());
            fmi3InstantiateCoSimulation(
                name,
                token.as_ptr(),
                place.as_ptr(),
                false,
                false,
                false,
                false,
                ptr::null(),
                0,
                none,
                null,
                null,
            )
        };
        assert!(!instance.is_null(), "no instance");
        // SAFETY: the instance is alive, and one variable has one value.
        let statuses = unsafe {
            [
                fmi3SetBoolean(instance, &noted, 1, &u8::from(serialisable), 1),
                fmi3EnterInitializationMode(instance, false, 0.0, 0.0, false, 0.0),
                fmi3ExitInitializationMode(instance),
            ]
        };
        assert_eq!(statuses, [0; 3]);
        // Time is the first variable; then come inputs and outputs.
        let references = |from: usize, count: usize| (from as u32..).take(count).collect();
        let (inputs, outputs) = (variables.inputs, variables.outputs);
        Called { instance, inputs: references(1, inputs), outputs: references(1 + inputs, outputs) }
    }

    /// One communication step: inputs set, step done, outputs got.
    fn step(&mut self, t: f64, u: &[f64], y: &mut [f64]) {
        let (mut event, mut terminate, mut early, mut last) = (false, false, false, 0.0);
        // SAFETY: as many values as variables, room for all that is told, and an instance that is alive.
        let statuses = unsafe {
            [
                fmi3SetFloat64(self.instance, self.inputs.as_ptr(), u.len(), u.as_ptr(), u.len()),
                fmi3DoStep(self.instance, t, STEP, true, &mut event, &mut terminate, &mut early, &mut last),
                fmi3GetFloat64(self.instance, self.outputs.as_ptr(), y.len(), y.as_mut_ptr(), y.len()),
            ]
        };
        assert_eq!(statuses, [0; 3]);
    }
}

impl Drop for Called {
    fn drop(&mut self) {
        // SAFETY: nobody has the instance afterwards.
        unsafe { fmi3FreeInstance(self.instance) };
    }
}

/// Nanoseconds per step, and the outputs in the end.
fn timed(outputs: usize, mut step: impl FnMut(f64, &mut [f64])) -> (f64, Vec<f64>) {
    let mut y = vec![0.0; outputs];
    let began = clock();
    for k in 0..STEPS {
        step(black_box(k as f64 * STEP), &mut y);
    }
    (1e9 * (clock() - began).as_secs_f64() / STEPS as f64, y)
}

/// Inputs of a side of the wedge box with which it stays where it begins.
fn inputs(spec: &RunSpec, side: Side) -> Vec<f64> {
    let mut system = (spec.case.build)(&spec.parameters, &spec.solver).unwrap();
    let sides = system.sides.lend();
    let (mut motion, mut force) = (vec![0.0; 2], vec![0.0; 1]);
    sides.mechanics.outputs(&[0.0], &mut motion).unwrap();
    sides.actuator.outputs(&motion, &mut force).unwrap();
    if side == Side::Mechanics { force } else { motion }
}

/// What a call of an exported FMU adds.
fn exported(turns: usize) {
    let spec = RunRequest::of("wedge-box", "zero-order-hold").resolve(&Catalogue::standard()).unwrap();
    for side in Side::BOTH {
        let u = inputs(&spec, side);
        let direct = || {
            let mut subsystem = build_side(&spec.case, side, &spec.parameters).unwrap();
            timed(subsystem.ports().outputs.len(), |t, y| {
                subsystem.step(t, black_box(&u), STEP).unwrap();
                subsystem.outputs(&u, y).unwrap();
            })
        };
        let called = |serialisable: bool| {
            let mut fmu = Called::new(&spec, side, serialisable);
            timed(fmu.outputs.len(), |t, y| fmu.step(t, black_box(&u), y))
        };
        let mut times = [const { Vec::new() }; 3];
        for _ in 0..turns.max(1) {
            let found = [direct(), called(true), called(false)];
            assert!(found[1].1 == found[0].1 && found[2].1 == found[0].1, "{}: other digits", side_name(side));
            times.iter_mut().zip(found).for_each(|(times, (time, _))| times.push(time));
        }
        let [direct, noted, bare] = times.map(|times| median(times).unwrap());
        if turns > 0 {
            println!(
                "exported {}: {direct:.0} ns for step and outputs; fmi3SetFloat64, fmi3DoStep and fmi3GetFloat64 add {:.0} ns, {:.0} ns if it \
                 need not be serialisable",
                side_name(side),
                noted - direct,
                bare - direct
            );
        }
    }
}

/// Times whole runs with the same digits, per macro step, and compares them with the first.
fn compared(catalogue: &Catalogue, compared: &str, runs: &[(&str, RunRequest)], turns: usize) {
    let specs: Vec<RunSpec> = runs.iter().map(|(_, request)| request.resolve(catalogue).unwrap()).collect();
    let mut times = vec![Vec::new(); specs.len()];
    let mut known: Option<Vec<f64>> = None;
    for _ in 0..turns.max(1) {
        for (((what, _), spec), times) in runs.iter().zip(&specs).zip(&mut times) {
            let result = simulate(spec, Bounds::default(), Some(clock), StopFlag::never()).unwrap();
            assert_eq!(result.report.outcome, Outcome::Completed, "{what}");
            let column = result.trajectory.index_of(compared).unwrap();
            let found: Vec<f64> = result.trajectory.column(column).collect();
            assert!(*known.get_or_insert_with(|| found.clone()) == found, "{what}: other digits");
            times.push(1e6 * result.wall.as_secs_f64() / (found.len() - 1) as f64);
        }
    }
    let medians: Vec<f64> = times.into_iter().map(|times| median(times).unwrap()).collect();
    for ((what, _), time) in runs.iter().zip(&medians).filter(|_| turns > 0) {
        let (more, ratio) = (time - medians[0], time / medians[0]);
        println!("{what}: {time:.2} µs per macro step, {more:.2} µs more, {ratio:.1} times");
    }
}

/// The wedge box with one step of each side per macro step, as itself and as FMUs in this process and in others.
fn imported(folder: &Path, turns: usize) {
    let mut catalogue = Catalogue::standard();
    let program = std::env::current_exe().unwrap();
    let request = RunRequest {
        macro_step_s: Some(STEP),
        micro_step_s: Some(STEP),
        duration_s: Some(1.0),
        ..RunRequest::of("wedge-box", "zero-order-hold")
    };
    let spec = request.resolve(&catalogue).unwrap();
    let (_, library) = find_library(None, &program).unwrap();
    for side in Side::BOTH {
        std::fs::write(folder.join(format!("{}.fmu", side_name(side))), pack(&spec, side, &library).unwrap()).unwrap();
    }
    let columns = ["actuator_length_m", "actuator_velocity_m_s", "actuator_force_n"];
    let [position, velocity, force] = columns;
    let ends = format!("position = \"{position}\"\nvelocity = \"{velocity}\"\nforce = \"{force}\"\n");
    let mut runs = vec![("the wedge box itself", request.clone())];
    for (process, what) in [("same", "two FMUs in this process"), ("own", "two FMUs in processes of their own")] {
        let text = format!(
            "name = \"{process}\"\nprocess = \"{process}\"\nduration_s = 1.0\nmacro_step_s = {STEP}\n[mechanics]\n\
             fmu = \"mechanics.fmu\"\n[actuator]\nfmu = \"actuator.fmu\"\n[[interface]]\ncolumns = {columns:?}\n\
             [interface.mechanics]\n{ends}[interface.actuator]\n{ends}"
        );
        let file = folder.join(format!("{process}.toml"));
        std::fs::write(&file, text).unwrap();
        let case = read_case(&file, Some(&program)).unwrap();
        catalogue.add_case(case).unwrap();
        runs.push((what, RunRequest { case: Some(process.to_owned()), ..request.clone() }));
    }
    compared(&catalogue, force, &runs, turns);
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if arguments.iter().any(|argument| argument == WORKER) {
        serve().unwrap();
        return;
    }
    let turns = if arguments.iter().any(|argument| argument == "--bench") { TURNS } else { 0 };
    let folder = tempfile::tempdir().unwrap();
    exported(turns);
    imported(folder.path(), turns);
}
