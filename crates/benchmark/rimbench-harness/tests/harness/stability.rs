//! Stability limits, references within a limit of time, grids, and what is told of results.

use rimbench_cases::cases::Case;
use rimbench_core::cosim::{Channel, CommunicationGrid, StopFlag};
use rimbench_core::error::Error;
use rimbench_harness::*;
use rimbench_runs::RunRequest;
use rimbench_runs::catalogue::Catalogue;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

const USUAL: Scan = Scan { from: None, to: None, per_decade: 3, phases: 2 };

#[test]
fn a_scan_goes_as_far_as_a_tenth_of_the_duration_and_no_further_than_it_fits() {
    let mut request = RunRequest::of("bouncing-ball", "zero-order-hold");
    request.put("duration_s", "0.05").unwrap();
    let (grid, phases) = USUAL.resolve(&request, &Catalogue::standard()).unwrap();
    let (first, last) = (grid[0], grid[grid.len() - 1]);
    approx::assert_relative_eq!(last, 0.005, max_relative = 1e-12);
    approx::assert_relative_eq!(first, 5e-5, max_relative = 1e-12);
    assert_eq!(phases.len(), 2);
    // Shorter than the macro step that the case has.
    request.put("duration_s", "1e-3").unwrap();
    assert!(USUAL.resolve(&request, &Catalogue::standard()).unwrap().0.iter().all(|step| *step <= 1e-4));
    let refused = |scan: Scan| scan.resolve(&request, &Catalogue::standard()).unwrap_err().to_string();
    assert!(refused(Scan { to: Some(1.0), ..USUAL }).starts_with("to = 1 is not valid"));
    assert!(refused(Scan { phases: 0, ..USUAL }).starts_with("phases = 0 is not valid"));
}

/// Nobody waited for the end of a run: that is no instability.
#[test]
fn a_run_that_took_too_long_is_no_answer_and_ends_the_search_there() {
    let (mut request, catalogue) = (RunRequest::of("wedge-box", "rim-nonsmooth-gap"), Catalogue::standard());
    request.put("duration_s", "0.3").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::in_folder(folder.path());
    let search = |request: &RunRequest, macro_steps: &[f64]| {
        let search = LimitSearch {
            request,
            catalogue: &catalogue,
            macro_steps,
            relative_tolerance: 0.1,
            progress: &|_| {},
            stop: StopFlag::never(),
        };
        stability_limit(search, &[1.0], &cache).unwrap()
    };
    let found = search(&request, &[2e-3, 8e-3]);
    assert_eq!((found.last_stable, found.first_unstable, found.no_answer), (Some(8e-3), None, None));
    // A mechanics of a step of its own takes as many as there are, and one in a shorter macro step.
    let own_step = RunRequest { mechanics_step_s: Some(4e-3), ..request.clone() };
    let found = search(&own_step, &[2e-3, 8e-3]);
    assert_eq!((found.last_stable, found.first_unstable, found.no_answer), (Some(8e-3), None, None));
    let too_short = Scan { to: Some(3e-3), ..USUAL }.resolve(&own_step, &catalogue).unwrap_err().to_string();
    assert!(too_short.starts_with("mechanics_step_s = 0.004 is not valid"), "{too_short}");
    let bounds = search(&request, &[2e-3]);
    assert_eq!(bounds.points[0].verdict, StepVerdict::Stable);
    request.put("wall_limit_s", "1e-9").unwrap();
    // The reference is at hand, and no run has time.
    let found = search(&request, &[2e-3, 8e-3]);
    assert_eq!((found.last_stable, found.first_unstable, found.no_answer), (None, None, Some(2e-3)));
    assert!(
        found
            .points
            .iter()
            .all(|point| matches!(&point.verdict, StepVerdict::NoAnswer(why) if why.contains("wall-time limit")))
    );
}

#[test]
fn a_search_that_is_asked_to_stop_does() {
    let (request, catalogue) = (RunRequest::of("bouncing-ball", "zero-order-hold"), Catalogue::standard());
    let (grid, phases) = USUAL.resolve(&request, &catalogue).unwrap();
    let raised = AtomicBool::new(true);
    let search = LimitSearch {
        request: &request,
        catalogue: &catalogue,
        macro_steps: &grid,
        relative_tolerance: 0.1,
        progress: &|_| {},
        stop: StopFlag::new(&raised),
    };
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::in_folder(folder.path());
    assert!(matches!(stability_limit(search, &phases, &cache), Err(Error::Stopped)));
    assert!(matches!(spectral_stability_limit(search), Err(Error::Stopped)));
}

/// Each closed form, and every other reference, is given up when its time is over, in the middle of a piece as well.
#[test]
fn a_limit_holds_for_every_kind_of_reference() {
    let folder = tempfile::tempdir().unwrap();
    for (case, set) in [
        ("bouncing-ball", Some(("gravity_m_s2", "1e30"))),
        ("impact-oscillator", Some(("base_position_m", "1e9"))),
        ("slider-between-stops", Some(("base_position_m", "1e9"))),
        ("linear-oscillator", None),
        ("towed-block", None),
    ] {
        let mut request = RunRequest::of(case, "zero-order-hold");
        request.set = set.into_iter().map(|(key, value)| (key.to_owned(), value.to_owned())).collect();
        let mut spec = request.resolve(&Catalogue::standard()).unwrap();
        spec = spec.with(|own| own.wall_limit = Some(Duration::from_nanos(1))).unwrap();
        let found = obtain_reference(&spec, &Cache::in_folder(folder.path()), StopFlag::never());
        // One that is there before the watchdog has looked is as good; with these settings a closed form takes seconds.
        let quick = found.is_ok() && set.is_none();
        assert!(quick || matches!(found, Err(Error::Overdue { .. })), "{case}: {found:?}");
    }
}

#[test]
fn a_panic_inside_a_reference_with_a_limit_ends_it() {
    let mut spec = RunRequest::of("wedge-box", "zero-order-hold").resolve(&Catalogue::standard()).unwrap();
    let faulty = Case { reference: Arc::new(|_| panic!("a defect")), ..Case::clone(&spec.case) };
    spec = spec.with(|own| (own.case, own.wall_limit) = (Arc::new(faulty), Some(Duration::from_secs(60)))).unwrap();
    let solve = || obtain_reference(&spec, &Cache::in_folder("nowhere"), StopFlag::never());
    assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(solve)).is_err());
}

#[test]
fn a_reference_is_kept_unless_code_from_outside_has_a_part_in_it() {
    let mut catalogue = Catalogue::standard();
    let built_in = catalogue.case("wedge-box").unwrap().clone();
    let outside = Case { name: "outside".into(), from_outside: true, ..Case::clone(&built_in) };
    let judged = Case { name: "judged".into(), judged_by: Some(built_in), ..outside.clone() };
    [outside, judged].into_iter().for_each(|case| catalogue.add_case(case).unwrap());
    let kept = |case: &str, folder: &std::path::Path| {
        let mut request = RunRequest::of(case, "zero-order-hold");
        request.put("duration_s", "0.01").unwrap();
        let spec = request.resolve(&catalogue).unwrap();
        let reference = obtain_reference(&spec, &Cache::in_folder(folder), StopFlag::never()).unwrap();
        (reference, std::fs::read_dir(folder).unwrap().count())
    };
    let folder = tempfile::tempdir().unwrap();
    let (own, after_outside) = kept("outside", folder.path());
    assert_eq!(after_outside, 0);
    let (built_in, after_built_in) = kept("wedge-box", folder.path());
    assert_eq!(after_built_in, 1);
    // That of the case that judges, and so found there.
    let (judged, after_judged) = kept("judged", folder.path());
    assert_eq!(after_judged, 1);
    assert_eq!((&own.trajectory, &judged.trajectory), (&built_in.trajectory, &built_in.trajectory));
}

#[test]
fn the_phase_ensemble_starts_at_one_and_spreads() {
    let phases = phase_ensemble(16);
    assert_eq!(phases[0], 1.0);
    assert!(phases.iter().all(|phase| *phase > 0.0 && *phase <= 1.0));
    let mut sorted = phases.clone();
    sorted.sort_by(f64::total_cmp);
    let largest_hole = sorted.windows(2).map(|pair| pair[1] - pair[0]).fold(sorted[0], f64::max);
    assert!(largest_hole < 2.0 / 16.0 * 1.2, "{largest_hole}");
}

#[test]
fn a_logarithmic_grid_has_both_ends_and_equal_ratios() {
    let grid = logarithmic_grid(1e-3, 1e-1, 4).unwrap();
    assert_eq!((grid.len(), grid[0], grid[8]), (9, 1e-3, 1e-1));
    for pair in grid.windows(2) {
        approx::assert_relative_eq!(pair[1] / pair[0], 10.0_f64.powf(0.25), max_relative = 1e-12);
    }
    assert_eq!(logarithmic_grid(1e-3, 1e-3, 4).unwrap(), [1e-3]);
    assert!(logarithmic_grid(0.0, 1.0, 4).is_err() && logarithmic_grid(1.0, 0.1, 4).is_err());
}

#[test]
fn waiting_takes_no_processor_time() {
    let first = [monotonic_clock(), processor_clock()];
    std::thread::sleep(Duration::from_millis(50));
    let [wall, processor] = [monotonic_clock() - first[0], processor_clock() - first[1]];
    assert!(
        cfg!(not(any(target_os = "linux", target_os = "macos"))) || processor < wall / 2,
        "{processor:?} of {wall:?}"
    );
}

#[test]
fn a_macro_step_is_late_by_the_deadlines_that_it_missed() {
    let log = "time_s, computing_time_s\n0.0, 0.004\n0.005, 0.0051\n0.01, 0.005\n0.015, 0.0121\n";
    let (mut channel, log) = (Channel::default(), DeadlineLog::read(log, 5e-3).unwrap());
    let grid = |duration| CommunicationGrid::new(5e-3, 1.0, duration).unwrap();
    assert_eq!(log.replay(&grid(0.02), &mut channel), Ok(None));
    assert_eq!(channel.missed, [(1, 1), (3, 2)]);
    assert!(log.replay(&grid(0.02), &mut channel).unwrap_err().contains("give one of the two"));
    // A row is that of its time: what lies beyond the run is left out, and what is not in the log is in time, which is
    // said.
    for (duration, missed, words) in
        [(0.015, 1, "4 macro steps and the run 3"), (0.1, 2, "the run 20: those beyond its")]
    {
        let mut channel = Channel::default();
        let note = log.replay(&grid(duration), &mut channel).unwrap().unwrap();
        assert!(note.contains(words) && channel.missed.len() == missed, "{note}: {channel:?}");
    }
    for (rows, words) in [
        ("0,0\n0.01,0.02\n", "line 3: time_s = 0.01 is macro step 2, and macro step 1 has no row"),
        ("0.005,0\n0.01,0.02\n", "line 2: time_s = 0.005 is macro step 1, and macro step 0 has no row"),
        ("0,0\n0.0025,0.02\n", "line 3: time_s = 0.0025 is between macro steps"),
        ("0,0\n0.005,0\n0.0075,0\n", "line 4: time_s = 0.0075 is between"),
    ] {
        let log = DeadlineLog::read(&format!("time_s,computing_time_s\n{rows}"), 5e-3).unwrap();
        let why = log.replay(&grid(0.02), &mut Channel::default()).unwrap_err();
        assert!(why.contains(words), "{rows}: {why}");
    }
}

#[test]
fn a_log_that_is_none_is_refused_with_its_line() {
    let refused = |text: &str| DeadlineLog::read(text, 5e-3).unwrap_err();
    assert!(refused("time_s\n0\n").contains("no column `computing_time_s`"));
    assert!(refused("time_s,computing_time_s\n0.1,0\n0.05,0\n").contains("line 3: time_s = 0.05 goes back"));
    assert!(refused("time_s,computing_time_s\n0.1,x\n").contains("line 2: column `computing_time_s`"));
    assert!(refused("time_s,computing_time_s\n0.1,-1\n").contains("0 or more"));
    assert!(refused("time_s,computing_time_s\n0.1,1e9\n").contains("at most 100000 deadlines"));
    assert!(refused("time_s,computing_time_s\n").contains("has no rows"));
    assert!(refused("time_s,time_s,computing_time_s\n0,0,0\n").contains("two columns `time_s`"));
    assert!(DeadlineLog::read("", 0.0).unwrap_err().contains("above 0 s"));
}
