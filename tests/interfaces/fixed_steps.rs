//! FMUs that take steps of one length only, or multiples of one: what many tools export.
#![cfg(target_os = "linux")]

use crate::faulty_guest::{Guest, MASS, SPRING, case, inside, refused, run};
use crate::program::assert_has;
use serde_json::Value;
use tempfile::TempDir;

/// One of them takes steps of one length, and says so by a failure where it is asked for another.
const EQUAL: [(&str, &str); 1] =
    [("canHandleVariableCommunicationStepSize=\"true\"", "canHandleVariableCommunicationStepSize=\"false\"")];

/// Multiples of 1 ms.
const MULTIPLES: [(&str, &str); 1] = [(
    "canHandleVariableCommunicationStepSize=\"true\"",
    "canHandleVariableCommunicationStepSize=\"false\" fixedInternalStepSize=\"1e-3\"",
)];

fn strict<'a>(guest: Guest<'a>, changes: &'a [(&'a str, &'a str)]) -> Guest<'a> {
    Guest { changes, faults: &["EQUAL_STEPS"], ..guest }
}

/// Both in one process, with times for steps of 1 ms.
fn pair(mass: &Guest<'_>, spring: &Guest<'_>) -> Option<TempDir> {
    let times = [
        (
            "micro_step_s = 1e-3\nreference_step_s = 4e-4",
            "micro_step_s = 4e-3\nreference_step_s = 4e-3\nprocess = \"same\"",
        ),
        ("macro_step_s = 1e-3", "macro_step_s = 4e-3"),
    ];
    case(mass, spring, &times)
}

fn printed(folder: &TempDir, arguments: &str) -> String {
    let output = inside(folder.path()).args(arguments.split_whitespace()).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments}: {said}");
    String::from_utf8(output.stdout).unwrap()
}

fn json(folder: &TempDir, arguments: &str) -> Value {
    serde_json::from_str(&printed(folder, &format!("{arguments} --format json"))).unwrap()
}

#[test]
fn a_side_of_fixed_step_runs_to_its_last_whole_macro_step_and_no_phase_but_one_is_asked_of_it() {
    for sides in [[true, false], [false, true], [true, true]] {
        let of = |guest, fixed: bool| if fixed { strict(guest, &EQUAL) } else { guest };
        let Some(folder) = pair(&of(MASS, sides[0]), &of(SPRING, sides[1])) else { return };
        for (step, end) in [("7e-3", 0.196), ("4e-3", 0.2), ("9e-3", 0.198)] {
            let (said, _) = run(folder.path(), &format!("--scheme zero-order-hold --macro-step {step}"));
            assert_eq!(said["outcome"], "completed", "{sides:?} {step} {said:#}");
            let ended = said["ended_at_s"].as_f64().unwrap();
            assert!((ended - end).abs() < 1e-12, "{sides:?} {step}: {ended}");
        }
        let shown = printed(&folder, "simulate --case case.toml --scheme zero-order-hold --macro-step 7e-3");
        assert_has(&shown, &["196 ms of 200 ms", "last whole macro step"]);
        let (said, _) = run(folder.path(), "--scheme zero-order-hold --macro-step 7e-3 --phase 0.5");
        assert_has(said["reason"].as_str().unwrap(), &["one length only", "a phase below 1"]);
    }
}

#[test]
fn steps_offered_to_a_side_are_multiples_of_its_own_and_the_reference_takes_no_others() {
    let Some(folder) = pair(&strict(MASS, &MULTIPLES), &strict(SPRING, &MULTIPLES)) else { return };
    // Micro steps of 4 ms do not divide 9 ms: three of 3 ms do.
    for (step, end) in [("9ms", 0.198), ("7ms", 0.196), ("10ms", 0.2)] {
        let (said, _) = run(folder.path(), &format!("--scheme zero-order-hold --macro-step {}", &step));
        assert_eq!(said["outcome"], "completed", "{said:#}");
        assert!((said["ended_at_s"].as_f64().unwrap() - end).abs() < 1e-12, "{said:#}");
    }
    // A duration that is no multiple: the reference ends with its last point.
    let (said, _) = run(folder.path(), "--scheme zero-order-hold --macro-step 4ms --duration 0.1507");
    assert!((said["ended_at_s"].as_f64().unwrap() - 0.148).abs() < 1e-12, "{said:#}");
    let (said, _) = run(folder.path(), "--scheme zero-order-hold --macro-step 2.5e-3");
    assert_has(said["reason"].as_str().unwrap(), &["multiples of 1e-3 s only"]);
    // Of the finest of three solutions, as it is taken: 3 ms make two steps in 4 ms, of which a quarter is half a unit.
    let path = folder.path().join("case.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("reference_step_s = 4e-3", "reference_step_s = 3e-3")).unwrap();
    assert_has(&refused(folder.path()), &["reference_step_s = 0.003", "a multiple of 4e-3 s"]);
}

#[test]
fn what_is_skipped_at_one_macro_step_forbids_no_other() {
    let Some(free) = pair(&MASS, &SPRING) else { return };
    let fixed = pair(&strict(MASS, &MULTIPLES), &strict(SPRING, &MULTIPLES)).unwrap();
    let advise = "advise --case case.toml --error 5% --scheme zero-order-hold --from 1ms --to 20ms";
    let [one, other] =
        [(&fixed, "32"), (&free, "1")].map(|(folder, phases)| json(folder, &format!("{advise} --phases {phases}")));
    let best = &one["advised"];
    assert_eq!(one["phases"], 1, "{one:#}");
    assert_eq!(best["form"], other["advised"]["form"], "{one:#}{other:#}");
    // The grid of the free pair, in whole milliseconds.
    let [step, same] = [best, &other["advised"]].map(|choice| choice["macro_step_s"].as_f64().unwrap());
    assert!((step - same).abs() < 1e-3 && (1e3 * step - (1e3 * step).round()).abs() < 1e-9, "{step} {same}");
    assert_has(&one["notes"].to_string(), &["phase 1 alone"]);
    // Steps of at most 4 ms are 4 ms in 20 ms, and 2.5 ms in 5 ms, which is no multiple.
    let few = json(&fixed, &format!("{advise} --error 60% --mechanics-step 4ms").replace("--error 5% ", ""));
    let skipped: u64 = few["skipped"].as_object().unwrap().values().map(|count| count.as_u64().unwrap()).sum();
    assert!(skipped > 0 && few["advised"].is_object(), "{few:#}");
    assert_has(&few["notes"].to_string(), &["Skipped: ", "multiples of 1e-3 s only"]);
    // An experiment has it as well: one phase of four, at every macro step.
    let experiment = "question = \"?\"\nmacro_steps_s = [4e-3, 7e-3]\nphases = 4\n[[cases]]\nfile = \"case.toml\"\n\
                      [[schemes]]\nscheme = \"zero-order-hold\"\n";
    std::fs::write(fixed.path().join("few.toml"), experiment).unwrap();
    let run = inside(fixed.path()).args(["run", "few.toml", "--out", "few", "--jobs", "1"]).output().unwrap();
    assert_has(&String::from_utf8_lossy(&run.stderr), &["last whole macro step, 3 of 4 phases are skipped"]);
    let table = std::fs::read_to_string(fixed.path().join("few/runs.csv")).unwrap();
    assert_eq!(table.matches(",completed,").count(), 2, "{table}");
    let limit = "limit --case case.toml --scheme zero-order-hold --sequence jacobi --from 1ms --to 0.1s --phases 4";
    let (own, free) = (json(&fixed, limit), json(&free, &limit.replace("--phases 4", "--phases 1")));
    let of = |limit: &Value, key: &str| limit[key].as_f64();
    for key in ["last_stable_s", "first_unstable_s"] {
        let both = [of(&own, key), of(&free, key)];
        assert_eq!(both[0].is_some(), both[1].is_some(), "{key}: {own} {free}");
        assert!(both[0].zip(both[1]).is_none_or(|(own, free)| (own - free).abs() <= 2.01e-3), "{key}: {own} {free}");
    }
    // The bracket is halved among multiples, down to two that follow each other.
    if let Some((stable, unstable)) = of(&own, "last_stable_s").zip(of(&own, "first_unstable_s")) {
        assert!(unstable - stable < 1.01e-3_f64.max(0.01 * stable), "{own}");
    }
    for point in own["fraction_stable"].as_array().unwrap() {
        let count = 1e3 * of(point, "macro_step_s").unwrap();
        assert!((count - count.round()).abs() < 1e-6, "{point}");
    }
    // Where there is none it is the reason that is said.
    let none = inside(fixed.path())
        .args(
            "limit --case case.toml --scheme zero-order-hold --step-control energy-residual --step-tolerance 0.1"
                .split(' '),
        )
        .output()
        .unwrap();
    assert_has(&String::from_utf8_lossy(&none.stderr), &["does not apply", "one length only"]);
}

/// Every fixed step of either side, phase and duration: the run ends where it says, or tells the reason.
#[test]
#[ignore = "a sweep of minutes: .ci/sweeps"]
fn fixed_steps_by_phase_and_duration_end_with_a_whole_macro_step_or_a_reason() {
    let unit = |unit: &str| {
        let with = format!("canHandleVariableCommunicationStepSize=\"false\" fixedInternalStepSize=\"{unit}\"");
        [(EQUAL[0].0.to_owned(), with)]
    };
    for (mass, spring) in [("1e-3", "1e-3"), ("1e-3", "5e-4"), ("5e-4", "1e-3"), ("1e-3", "4e-3"), ("1e-3", "1.5e-3")] {
        let [mass, spring] = [mass, spring].map(unit);
        let [of_mass, of_spring] = [&mass, &spring].map(|own| [(own[0].0.as_str(), own[0].1.as_str())]);
        let Some(folder) = pair(&strict(MASS, &of_mass), &strict(SPRING, &of_spring)) else { return };
        let opened = inside(folder.path()).args(["list", "parameters", "--case", "case.toml"]).output().unwrap();
        if !opened.status.success() {
            assert_has(&String::from_utf8_lossy(&opened.stderr), &["reference_step_s", "takes multiples of"]);
            continue;
        }
        for step in [2.0, 2.5, 3.0, 4.0, 6.0, 7.0, 12.0, 90.0] {
            for (phase, duration) in [(1.0, 0.2), (0.5, 0.2), (1.0, 0.1), (1.0, 0.0997), (1.0, 0.1999)] {
                let options =
                    format!("--scheme zero-order-hold --macro-step {step}ms --phase {phase} --duration {duration}");
                let (said, _) = run(folder.path(), &options);
                let end = said["ended_at_s"].as_f64().unwrap();
                match said["outcome"].as_str().unwrap() {
                    "skipped" => assert_has(said["reason"].as_str().unwrap(), &["takes "]),
                    "completed" => {
                        let count = 1e3 * end / step;
                        assert!((count - count.round()).abs() < 1e-6 && end <= duration + 1e-9, "{options}: {end}");
                        assert!(end > duration - 4e-3 - 1e-3 * step, "{options}: {end}");
                        assert!(phase == 1.0, "{options}");
                    }
                    "diverged" => assert!(step > 50.0, "{options}: {said:#}"),
                    other => panic!("{options}: {other} {said:#}"),
                }
            }
        }
    }
}

/// The script itself is run by `.ci/fmi`, where FMPy is.
#[test]
fn the_advice_is_written_as_a_master_of_at_most_eighty_lines_where_it_needs_no_model() {
    let Some(folder) = pair(&strict(MASS, &EQUAL), &SPRING) else { return };
    let advise = "advise --case case.toml --error 50% --from 4ms --to 8ms --write-master master.py";
    let script = folder.path().join("master.py");
    let forms = [
        "--scheme zero-order-hold --sequence jacobi",
        "--scheme first-order-hold --force-return profile --mechanics-steps 3",
        "--scheme second-order-hold --force-return profile --mechanics-step 2ms",
        "--scheme second-order-hold --sequence gauss-seidel-mechanics-first --mechanics-steps all",
        "--scheme zero-order-hold --force-return mean",
    ];
    for form in forms {
        let said = json(&folder, &format!("{advise} {form}"));
        let text = std::fs::read_to_string(&script).unwrap_or_else(|_| panic!("{form}: {said:#}"));
        assert!(text.lines().count() <= 80, "{form}: {}", text.lines().count());
        let error = 100.0 * said["advised"]["worst_error"].as_f64().unwrap();
        assert_has(&text, &[&format!("rimbench says {error:.4} %"), "step actuator by "]);
        std::fs::remove_file(&script).unwrap();
    }
    let said = json(&folder, &format!("{advise} --scheme nepce"));
    assert_has(said["master"].as_str().unwrap(), &["no master is written: nepce is more than a hold"]);
    assert!(!script.exists());
    let of_ours = inside(folder.path())
        .args("advise --case wedge-box --error 1% --write-master master.py".split(' '))
        .output()
        .unwrap();
    assert_eq!(of_ours.status.code(), Some(2));
    assert_has(&String::from_utf8_lossy(&of_ours.stderr), &["wedge-box", "a case file (.toml) that names two FMUs"]);
}
