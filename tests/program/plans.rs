//! Experiment files and the plans made of them.

use crate::program::{assert_has, printed, refused, rimbench};
use rimbench::catalogue::Catalogue;
use rimbench::error::Result;
use rimbench::harness::{Cache, Experiment, Job, prepare_folder};
use rimbench::runs::RunRequest;
use std::path::Path;

#[test]
fn a_log_is_read_beside_the_file_and_its_copy_holds_it() {
    let (folder, catalogue) = (tempfile::tempdir().unwrap(), Catalogue::standard());
    let text = |delivery: &str| {
        format!(
            "question = \"?\"\nmacro_steps_s = [5e-3]\n[[cases]]\nname = \"wedge-box\"\n[[schemes]]\nscheme = \"nepce\"\n\
             delivery.up = {{ {delivery} }}"
        )
    };
    let file = |log: &str| {
        std::fs::write(folder.path().join("times.csv"), log).unwrap();
        let text = text("delay = 1, log = \"times.csv\", deadline_s = 5e-3");
        Experiment::parse(&folder.path().join("a.toml"), text)
    };
    let planned = |of: &Experiment| of.plan(&catalogue, false).unwrap().swap_remove(0);
    let log = "time_s,computing_time_s,\"said \u{7f}\"\r\n0,0.006,\"a\nb\"\r\n0.005,0.001,\r\n";
    let experiment = file(log).unwrap();
    let other = file("time_s,computing_time_s\n0,0.006\n0.005,0.011\n").unwrap();
    assert_ne!(planned(&experiment).id, planned(&other).id);
    let message = file("time_s,computing_time_s\n0.1,0\n0.05,0\n").unwrap_err().to_string();
    let wanted = ["[[schemes]] in line 5", "line 3: time_s = 0.05 goes back"];
    assert!(wanted.iter().all(|wanted| message.contains(wanted)), "{message}");
    // By a link it is beside the file.
    #[cfg(unix)]
    {
        let elsewhere = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.toml"), text("delay = 1, log = \"times.csv\", deadline_s = 5e-3"))
            .unwrap();
        std::fs::write(folder.path().join("times.csv"), log).unwrap();
        std::os::unix::fs::symlink(folder.path().join("a.toml"), elsewhere.path().join("b.toml")).unwrap();
        let linked = Experiment::read(&elsewhere.path().join("b.toml")).unwrap();
        assert_eq!(planned(&linked).id, planned(&experiment).id);
    }
    // The copy in a results folder says the same where the log is not.
    let results = tempfile::tempdir().unwrap();
    let cache = Cache::in_folder(results.path());
    prepare_folder(Job::new(&experiment, &catalogue, results.path(), &cache, &rimbench::BUILD)).unwrap();
    let copy = Experiment::read_from_results(results.path()).unwrap();
    assert!(copy.is_same_as(&experiment));
    let run = planned(&copy);
    assert_eq!(run.id, planned(&experiment).id);
    assert!(run.spec.facts().iter().any(|fact| fact.name == "delivery_up" && fact.cell() == "delay:1,missed:0"));
    for (log, expected) in [("log = \"none.csv\", deadline_s = 1.0", "none.csv"), ("log = \"times.csv\"", "together")] {
        let message = Experiment::parse(Path::new("a.toml"), text(log)).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}

fn parsed(schemes: &str) -> Result<Experiment> {
    let text = format!(
        "question = \"?\"\nmacro_steps_s = [1e-5, 5e-3]\n[[cases]]\nname = \"wedge-box\"\n[[schemes]]\n{schemes}\n"
    );
    Experiment::parse(Path::new("usual.toml"), text)
}

#[test]
fn a_label_is_not_the_name_of_something_else() {
    let plan = |label: &str| {
        parsed(&format!("scheme = \"rim-smooth\"\nlabel = \"{label}\""))
            .and_then(|experiment| experiment.plan(&Catalogue::standard(), false))
    };
    for (label, said) in [
        ("zero-order-hold", "is the name of another scheme"),
        ("reference", "the trace of the reference"),
        (" smooth", "begins or ends with a blank"),
        ("  ", "no label at all"),
        ("", "no label at all"),
    ] {
        let message = plan(label).unwrap_err().to_string();
        assert!(message.contains(said) && message.contains("[[schemes]] in line"), "`{label}`: {message}");
    }
    assert!(plan("rim-smooth").is_ok() && plan("my smooth").is_ok());
}

#[test]
fn a_run_asked_for_by_name_must_be_the_one_that_a_file_with_a_case_and_a_scheme_means() {
    let catalogue = Catalogue::standard();
    for scheme in catalogue.schemes() {
        // Below and above the micro step of the case.
        let planned = parsed(&format!("scheme = \"{}\"", scheme.name)).unwrap().plan(&catalogue, false).unwrap();
        assert_eq!(planned.len(), 2);
        for run in planned {
            let step = run.spec.macro_step;
            let asked = RunRequest { macro_step_s: Some(step), ..RunRequest::of("wedge-box", &*scheme.name) };
            assert_eq!(asked.resolve(&catalogue).unwrap().id(), run.id, "{} at H = {step}", scheme.name);
        }
    }
}

#[test]
fn rows_of_one_scheme_get_labels_of_what_differs() {
    let labels = |schemes: &str| {
        let planned = parsed(schemes).and_then(|experiment| experiment.plan(&Catalogue::standard(), false));
        let mut labels: Vec<String> = planned.unwrap().into_iter().map(|run| run.label).collect();
        labels.dedup();
        labels
    };
    let two =
        "scheme = \"nepce\"\ngain = 0.5\nsolver = \"lemke\"\n[[schemes]]\nsolver = \"lemke\"\nscheme = \"nepce\"\n";
    assert_eq!(labels(two), ["nepce/gain=0.5", "nepce"]);
    assert_eq!(labels(&format!("{two}gain = 1.5\n")), ["nepce/gain=0.5", "nepce/gain=1.5"]);
    assert_eq!(labels("scheme = \"nepce\"\ngain = 0.5\nlabel = \"half\""), ["half"]);
    // One scheme, one setting, other macro steps: one label.
    let steps = "scheme = \"nepce\"\nmacro_steps_s = [1e-3]\n[[schemes]]\nscheme = \"nepce\"\nmacro_steps_s = [2e-3]";
    assert_eq!(labels(steps), ["nepce"]);
}

#[test]
fn a_row_with_several_tolerances_is_run_with_each_at_each_macro_step() {
    let row = |keys: &str| {
        let row = format!(
            "scheme = \"zero-order-hold\"\nstep_control = \"energy-residual\"\nmin_macro_step_s = 1e-5\n{keys}"
        );
        parsed(&row).and_then(|experiment| experiment.plan(&Catalogue::standard(), false))
    };
    let planned = row("step_tolerances = [0.1, 0.01]").unwrap();
    let settings: Vec<_> =
        planned.iter().map(|run| (run.spec.macro_step, run.spec.step_control.unwrap().tolerance)).collect();
    assert_eq!(settings, [(1e-5, 0.1), (1e-5, 0.01), (5e-3, 0.1), (5e-3, 0.01)]);
    assert!(planned.iter().all(|run| run.label == "zero-order-hold"));
    for (keys, wanted) in [
        ("step_tolerances = [0.1]\nstep_tolerance = 0.2", "give one of the two"),
        ("step_tolerances = 0.1", "step_tolerances: invalid type"),
        ("step_tolerances = []", "(`zero-order-hold` on case `wedge-box`): the grid is empty here"),
        ("step_tolerances = [0.1, 0.1]", "the plan holds one run twice"),
        ("step_tolerances = [-1.0]", "step_tolerances = -1 is not valid"),
    ] {
        let message = row(keys).unwrap_err().to_string();
        assert!(message.contains(wanted), "{message}");
    }
}

/// A row, a case or a key that has no effect would be missed in the results, not in the file.
#[test]
fn what_would_have_no_effect_is_refused_with_its_place() {
    const FILE: &str = "question = \"q\"\nmacro_steps_s = [5e-3]\n[[cases]]\nname = \"wedge-box\"\n[[cases]]\nname = \
                        \"bouncing-ball\"\n[[schemes]]\nscheme = \"nepce\"\n[[schemes]]\nscheme = \"zero-order-hold\"\n";
    let plan = |text: &str| {
        let experiment = Experiment::parse(Path::new("a/b.toml"), text.to_owned());
        experiment.and_then(|experiment| experiment.plan(&Catalogue::standard(), false))
    };
    assert_eq!(plan(FILE).unwrap().len(), 4);
    for (after, keys, wanted) in [
        (
            "\"nepce\"",
            "macro_steps_s = []",
            "[[schemes]] in line 7 (`nepce` on case `wedge-box`): the grid is empty here",
        ),
        ("-ball\"", "macro_steps_s = []", "(`nepce` on case `bouncing-ball`): the grid is empty here"),
        ("-ball\"", "set = { ball_mass_kg = [] }", "[[cases]] in line 5 (`bouncing-ball`): the grid is empty here"),
        ("-ball\"", "file = \"nowhere.toml\"", "(`bouncing-ball`): a/nowhere.toml: is a case file"),
        (
            "[5e-3]",
            "traces = [\"nepce\"]",
            "traces = [\"nepce\"] is not valid; valid: labels of schemes, with trace_every_s",
        ),
        ("[5e-3]", "trace_every_s = 0.1\ntraces = []", "traces = [] is not valid"),
        ("[5e-3]", "quick = { phases = 0 }", "[quick]: the grid is empty"),
        ("[5e-3]", "quick = { macro_steps_s = [] }", "[quick]: [[schemes]] in line 8 (`nepce`"),
    ] {
        let message = plan(&FILE.replacen(after, &format!("{after}\n{keys}"), 1)).unwrap_err().to_string();
        assert!(message.contains(wanted), "{keys}: {message}");
    }
}

#[test]
fn what_is_wrong_with_a_row_is_said_with_its_line() {
    let refused = |schemes: &str| {
        let planned = parsed(schemes).and_then(|experiment| experiment.plan(&Catalogue::standard(), false));
        planned.unwrap_err().to_string()
    };
    for (row, wanted) in [
        ("scheme = \"nepce\"\ngian = 0.5", "unknown key of [[schemes]] `gian` (did you mean `gain`?); valid: label, "),
        ("scheme = \"nepce\"\nphase = 0.5", "unknown key of [[schemes]] `phase`"),
        ("scheme = \"nepce\"\ngain = \"high\"", "gain = high is not valid; valid: a number"),
        (
            "scheme = \"nepcee\"",
            "in line 5 (`nepcee` on case `wedge-box`): unknown scheme `nepcee` (did you mean `nepce`?)",
        ),
        ("label = \"mine\"", "scheme = nothing is not valid; valid: the name of a scheme"),
        ("scheme = \"nepce\"\nmacro_steps_s = 3", "macro_steps_s: one macro step is a list of one: [3.0]"),
        ("scheme = \"nepce\"\ngain = 1e300", "(`nepce` on case `wedge-box`): gain = 1e300 is not valid"),
        ("scheme = \"\"", "scheme = nothing"),
    ] {
        let message = refused(row);
        assert!(message.starts_with("usual.toml: [[schemes]] in line 5"), "{message}");
        assert!(message.contains(wanted), "{message}");
    }
    let message = refused("scheme = \"nepce\"\n[[schemes]]\nscheme = \"nepce\"\nlabel = \"nepce\"\ngain = 0.5");
    assert!(message.contains("line 7: label `nepce` is that of line 5"), "{message}");
    let message = refused("scheme = \"nepce\"\nlabel = \"nepce\"\n[[schemes]]\nscheme = \"nepce\"\ngain = 0.5");
    assert!(message.contains("could not be told apart"), "{message}");
}

#[test]
fn a_reference_step_that_is_no_step_is_refused_before_anything_runs() {
    for (step, wanted) in
        [("1.0", "reference_step_s = 1e0"), ("1e-300", "reference_step_s = 1e-300"), ("2.5e299", "5e-5 s")]
    {
        let text = format!(
            "question = \"?\"\nmacro_steps_s = [1e-3]\nreference_step_s = {step}\n[[cases]]\nname = \"wedge-box\"\n\
             [[schemes]]\nscheme = \"nepce\"\n"
        );
        let planned = Experiment::parse(Path::new("usual.toml"), text).unwrap().plan(&Catalogue::standard(), false);
        let message = planned.unwrap_err().to_string();
        assert!(message.contains(wanted), "{message}");
    }
}

#[test]
fn a_value_that_does_not_go_with_the_case_is_refused_before_anything_runs() {
    let folder = tempfile::tempdir().unwrap();
    let run = |case: &str, row: &str| {
        let text = format!(
            "question = \"?\"\nmacro_steps_s = [1e-3]\nduration_s = 0.01\n[[cases]]\n{case}\n[[schemes]]\n\
             scheme = \"rim-nonsmooth\"\n{row}\n"
        );
        std::fs::write(folder.path().join("a.toml"), text).unwrap();
        let mut command = rimbench();
        command.current_dir(&folder).args(["run", "a.toml", "--out", "results"]);
        command
    };
    let stops = "name = \"mass-between-stops\"\nset = { spool_amplitude = [0.6, 0.4] }";
    let wedge_box = "name = \"wedge-box\"";
    for (case, row, wanted) in [
        (wedge_box, "belief = \"missing:99\"", ["belief = missing:99 is not valid", "from missing:0 to missing:3"]),
        (wedge_box, "belief = \"mass:2,closed:4\"", ["belief = closed:4 is not valid", "from closed:0 to closed:3"]),
        ("name = \"quarter-car\"", "belief = \"missing:0\"", ["belief = missing:0", "the model has no contact"]),
        (stops, "", ["[[cases]] in line 4 (`mass-between-stops`): spool_amplitude = 0.6", "at most 0.5"]),
        ("name = \"wedge-box-friction\"", "solver = \"lemke\"", ["[[schemes]] in line 6", "use solver `active-set`"]),
    ] {
        let message = refused(&mut run(case, row));
        assert_has(&message, &[&["a.toml"], &wanted[..]].concat());
        assert!(!folder.path().join("results").exists(), "{case}");
    }
    // What a case does not offer is a row of the results, and so is a machine drawn at random that cannot be.
    let drawn = "name = \"mass-between-stops\"\ndraw = { settings = 4, seed = 1, ranges = { spool_amplitude = [0.4, 0.6], gravity_m_s2 = [9.0, 10.0] } }";
    for (case, row) in [(wedge_box, "belief = \"friction:0.5\""), (drawn, "")] {
        assert_has(&printed(&mut run(case, row)), &["without an answer"]);
    }
}

#[test]
fn a_value_of_the_grid_is_told_by_the_key_of_the_file() {
    let message = |keys: &str, row: &str| {
        let question = if keys.starts_with("question") { "" } else { "question = \"?\"\n" };
        let text = format!(
            "{question}{keys}\nduration_s = 0.1\n[[cases]]\nname = \"wedge-box\"\n[[schemes]]\n\
             scheme = \"rim-nonsmooth\"\n{row}\n"
        );
        let read = Experiment::parse(Path::new("usual.toml"), text);
        read.and_then(|experiment| experiment.plan(&Catalogue::standard(), false)).unwrap_err().to_string()
    };
    let controlled = "step_control = \"model-defect\"\n";
    for (keys, row, wanted) in [
        ("macro_steps_s = [-1.0]", "", "macro_steps_s = -1 is not valid"),
        ("macro_steps_s = [nan]", "", "macro_steps_s = NaN is not valid"),
        ("macro_steps_s = [1e-9]", "", "macro_steps_s = 0.000000001 is not valid; valid: at least 1e-8 s"),
        ("macro_steps_s = [5e-3]", "macro_steps_s = [1.0]", "macro_steps_s = 1 is not valid"),
        ("macro_steps_s = { from = 1e-3, to = 1e-2, per_decade = 0 }", "", "macro_steps_s: per_decade = 0"),
        ("macro_steps_s = [5e-3]\nphases = [2.0]", "", "phases = 2.0 is not valid"),
        // Also where others stand for them.
        ("macro_steps_s = [nan]", "macro_steps_s = [5e-3]", "macro_steps_s = NaN is not valid"),
        ("macro_steps_s = [5e-3]\nquick = { macro_steps_s = [0.0] }", "", "[quick]: macro_steps_s = 0 is not valid"),
        ("macro_steps_s = [5e-3]\nquick = { phases = [nan] }", "", "[quick]: phases = NaN is not valid"),
        (
            "macro_steps_s = [5e-3]",
            &format!("{controlled}step_tolerances = [-1.0]"),
            "step_tolerances = -1 is not valid",
        ),
        ("macro_steps_s = [5e-3]", &format!("{controlled}step_tolerance = -1.0"), "step_tolerance = -1 is not valid"),
        ("question = \" \"\nmacro_steps_s = [5e-3]", "", "question = \" \" is not valid"),
    ] {
        let message = message(keys, row);
        assert!(message.starts_with("usual.toml: ") && message.contains(wanted), "{wanted}: {message}");
    }
}

#[test]
fn a_file_whose_name_is_nothing_but_dots_names_no_experiment() {
    let text =
        "question = \"?\"\nmacro_steps_s = [1e-3]\n[[cases]]\nname = \"wedge-box\"\n[[schemes]]\nscheme = \"nepce\"\n";
    for name in ["..toml", "...toml"] {
        let message = Experiment::parse(Path::new(name), text.to_owned()).unwrap_err().to_string();
        assert!(message.contains("is no name for an experiment"), "{message}");
    }
}

/// The newcomer's most likely slips, and input that is long: one line that says where and what, and how long it was.
#[test]
fn what_is_no_experiment_is_told_by_line_with_what_would_be_valid() {
    let refused = |text: &str| {
        let planned = Experiment::parse(Path::new("mine.toml"), text.to_owned())
            .and_then(|experiment| experiment.plan(&Catalogue::standard(), false));
        planned.unwrap_err().to_string()
    };
    let good =
        "question = \"?\"\nmacro_steps_s = [5e-3]\n[[cases]]\nname = \"wedge-box\"\n[[schemes]]\nscheme = \"nepce\"\n";
    let long = format!("\"{}\"", "x".repeat(400_000));
    for (from, to, wanted) in [
        ("[5e-3]", "5e-3", "line 2, column 17: `macro_steps_s = 5e-3`: one macro step is a list of one: [0.005]"),
        ("[5e-3]", "5", "one macro step is a list of one: [5.0]"),
        ("[5e-3]", "\"5 ms\"", "expected a list of macro steps in s, [1e-3, 5e-3], or a range"),
        ("[5e-3]", "{ from = 1e-3 }", "missing field `to`"),
        ("[5e-3]", "[5e-3]\nphases = 0.5", "line 3, column 10: `phases = 0.5`: one phase is a list of one, [0.5]"),
        ("[5e-3]", "[5e-3]\nphases = -1", "a number of phases is not below 0: -1"),
        ("[5e-3]", "[5e-3]\nphasis = 1", "unknown field `phasis`"),
        ("[5e-3]", "[\"5ms\"]", "invalid type: string \"5ms\", expected a number"),
        ("[5e-3]", "[5e-3]\nduration_s = \"5ms\"", "invalid type: string \"5ms\", expected a number"),
        ("[5e-3]", "[99999999999999999999]", "expected one of at most 9223372036854775807"),
        ("\"wedge-box\"", "\"wedge-box\"\ndraw = 3", "invalid type: integer `3`, expected a table"),
        ("question = \"?\"\n", "", "mine.toml: is no experiment: missing field `question`"),
        ("\"nepce\"", "\"nepce\"\ndelivery.up = { loss = 1.0 }", "delivery.up = loss:1.0 is not valid"),
        ("\"nepce\"", "\"nepce\"\ndelivery.up = { delay = 999 }", "delivery.up = delay:999 is not valid"),
        ("\"nepce\"", "\"nepce\"\ndelivery_up = \"delay:999\"", "delivery_up = delay:999 is not valid"),
        (
            "\"nepce\"",
            "\"nepce\"\ndelivery.up = { log = \"\", deadline_s = 1 }",
            "log of delivery.up = \"\" is not valid; valid: the path of a log",
        ),
        (
            "wedge-box",
            "wedge-bx",
            "[[cases]] in line 3 (`wedge-bx`): unknown case `wedge-bx` (did you mean `wedge-box`?)",
        ),
        (
            "\"wedge-box\"",
            "\"wedge-box\"\nset = { box_mass_kg = -1e300 }",
            "[[cases]] in line 3 (`wedge-box`): box_mass_kg = -1e300 is not valid",
        ),
        (
            "[5e-3]",
            "[1e300]",
            "[[schemes]] in line 5 (`nepce` on case `wedge-box`): macro_steps_s = 1e300 is not valid",
        ),
        ("\"?\"", &long, "unknown"),
        ("[5e-3]", &long, "expected a list of macro steps"),
        ("\"nepce\"", &long, "… (400000 characters)"),
        ("\"wedge-box\"", &long, "… (400000 characters)"),
    ] {
        // A long question is no fault, one without an end is.
        let text = good.replace(from, if wanted == "unknown" { &to[..to.len() - 1] } else { to });
        let message = refused(&text);
        assert!(message.starts_with("mine.toml: "), "{message}");
        assert!(message.contains(wanted) || wanted == "unknown", "{wanted}: {message}");
        assert!(message.len() < 2500 && message.lines().count() == 1, "{} characters: {message}", message.len());
    }
}

/// A grid with settings, rows, macro steps, tolerances and phases.
fn grid(phases: usize) -> Experiment {
    let text = format!(
        "question = \"?\"\nmacro_steps_s = [1e-3, 5e-3]\nphases = {phases}\nduration_s = 0.05\n\
         [[cases]]\nname = \"linear-oscillator\"\nset = {{ mass_1_kg = [1.0, 2.0, 3.0], mass_2_kg = [1.5, 2.5] }}\n\
         [[cases]]\nname = \"wedge-box\"\n\
         [[schemes]]\nscheme = \"zero-order-hold\"\n\
         [[schemes]]\nscheme = \"zero-order-hold\"\nlabel = \"adaptive\"\nstep_control = \"energy-residual\"\n\
         step_tolerances = [1e-2, 1e-3]\n"
    );
    Experiment::parse(Path::new("grid.toml"), text).unwrap()
}

#[test]
fn the_parts_of_a_plan_are_the_plan() {
    let (experiment, catalogue) = (grid(300), Catalogue::standard());
    let whole = experiment.plan(&catalogue, false).unwrap();
    let size = experiment.size(false).unwrap();
    assert_eq!(whole.len(), size);
    assert!(size > 10_000, "{size}: one part");
    let described = |run: &rimbench::harness::PlannedRun| (run.id.clone(), run.label.clone(), run.spec.phase);
    for places in [0..size, 0..1, 17..18, 2_999..3_001, 123..11_456, size - 1..size] {
        let mut at = places.start;
        for part in experiment.parts(&catalogue, false, places.clone()) {
            let (first, runs) = part.unwrap();
            assert!(first == at && (1..=10_000).contains(&runs.len()));
            assert!(runs.iter().map(described).eq(whole[first..first + runs.len()].iter().map(described)), "{first}");
            at += runs.len();
        }
        assert_eq!(at, places.end);
    }
}

#[test]
fn a_run_that_is_there_twice_is_found_across_parts() {
    let text = "question = \"?\"\nmacro_steps_s = [5e-3]\nphases = 20000\n[[cases]]\nname = \"linear-oscillator\"\n\
                [[cases]]\nname = \"linear-oscillator\"\n[[schemes]]\nscheme = \"zero-order-hold\"\n";
    let experiment = Experiment::parse(Path::new("twice.toml"), text.to_owned()).unwrap();
    let catalogue = Catalogue::standard();
    let mut parts = experiment.parts(&catalogue, false, 0..40_000);
    assert!(parts.by_ref().take(2).all(|part| part.is_ok()));
    let message = parts.next().unwrap().unwrap_err().to_string();
    assert!(message.contains("twice.toml") && message.contains("holds one run twice"), "{message}");
}

/// More runs than are planned at once: parts of them are run, divided for Slurm and checked, and what needs all of them
/// is refused.
#[test]
fn more_runs_than_are_planned_at_once_are_planned_in_parts() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("many.toml");
    let text = |phases: usize| {
        format!(
            "question = \"?\"\nmacro_steps_s = [1e-3, 5e-3]\nphases = {phases}\nduration_s = 0.01\n[[cases]]\n\
             name = \"linear-oscillator\"\n[[schemes]]\nscheme = \"zero-order-hold\"\n[[schemes]]\nscheme = \"first-order-hold\"\n"
        )
    };
    std::fs::write(&file, text(25_001)).unwrap();
    let command = |arguments: &str| {
        let mut command = rimbench();
        command.arg("run").arg(&file).arg("--out").arg(folder.path().join("out")).args(arguments.split_whitespace());
        command
    };
    assert_has(&printed(&mut command("--dry-run")), &["100004 runs, 0 claims"]);
    let places = "--places 74998-75007";
    assert_has(&printed(&mut command(places)), &["10 of 10 runs stored: 10 computed now", "records"]);
    assert_has(&printed(&mut command(places)), &["10 of 10 runs stored: 0 computed now", "10 were there"]);
    assert_has(&printed(&mut command("--slurm --dry-run")), &["99994 of 100004 runs are missing"]);
    assert!(!folder.path().join("out/runs.csv").exists());
    for (arguments, says) in [
        (
            "",
            "100004 runs, more than the 100000 that are planned at once: run its parts, by --places, --shard or --slurm",
        ),
        ("--collect", "more than the 100000 that are planned at once"),
        ("--dry-run --all", "more than the 100000 that are planned at once"),
        ("--dry-run --format json", "more than the 100000 that are planned at once"),
        ("--places 5-100004", "places of the plan in order, within 0-100003"),
    ] {
        assert_has(&refused(&mut command(arguments)), &[says]);
    }
    std::fs::write(&file, text(250_001)).unwrap();
    assert_has(
        &refused(&mut command("--dry-run")),
        &["1000004 runs, more than the 1000000 that one experiment may have"],
    );
    // A bad value far behind the first part is found before anything runs.
    std::fs::write(&file, text(25_001).replace("[1e-3, 5e-3]", "[1e-3, -5e-3]")).unwrap();
    assert_has(&refused(&mut command("--dry-run")), &["many.toml", "-0.005"]);
}
