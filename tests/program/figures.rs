//! Every kind of figure is written, complete and reproducible. The data are synthetic; no run is needed.
//!
//! Set `RIMBENCH_FIGURES_DIR` to an existing folder to keep the figures and look at them.

use crate::support::solvers;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use rimbench::checksums;
use rimbench::complementarity::{SolveStats, SolverEntry};
use rimbench::corpus::{Replay, Solve, Start, draw_profile};
use rimbench::error::Error;
use rimbench::figures::chart::{Axis, Figure, Guide, Inset, LegendPlace, Mode, Panel, Series};
use rimbench::figures::drawing::{Drawing, Shape};
use rimbench::figures::heatmap::{Cell, Heatmap, Row};
use rimbench::figures::manoeuvre::{ContactForce, Manoeuvre, ManoeuvreRow, Pose, WedgeBoxGeometry};
use rimbench::figures::render;
use rimbench::figures::style::{SeriesStyle, Styles};
use rimbench::figures::{FigureKey, FigureList, figure_keys};
use rimbench::name::Name;

/// Every solver on 60 made-up problems, warm and cold: each slower than the one before, and the last three fail on some.
fn replays() -> Vec<Replay> {
    let replay = |(index, solver): (usize, &Arc<SolverEntry>), start| {
        let solve = |problem: usize| Solve {
            n: 4,
            stats: SolveStats::default(),
            solved: index + 3 < solvers().len() || problem % 5 < 3,
            refused: false,
            time_ns: 50.0 * 1.7_f64.powi(index as i32) * (1.0 + ((7 * problem + 3 * index) % 11) as f64),
        };
        Replay { solver: solver.name.clone(), start, solves: (0..60).map(solve).collect(), mean_ns: 100.0, panic: None }
    };
    solvers()
        .iter()
        .enumerate()
        .flat_map(|entry| [Start::Warm, Start::Cold].map(|start| replay(entry, start)))
        .collect()
}

fn solver_names() -> Vec<Name> {
    solvers().iter().map(|solver| solver.name.clone()).collect()
}

/// The style of a built-in scheme, or a variant of one.
fn style_of(label: &str) -> SeriesStyle {
    Styles::standard().of_label(label)
}

const TOUCH_DOWN_S: f64 = 1.693;

#[test]
fn force_and_effective_mass() {
    let drawing = force_and_mass().draw();
    check(
        &drawing,
        "force-and-mass",
        &["(a) actuator force", "rim-nonsmooth-gap", "effective mass (kg)", "∞", "infinite"],
    );
}

#[test]
fn errors_over_step_sizes() {
    let drawing = convergence().draw();
    check(
        &drawing,
        "convergence",
        &["macro step H (ms)", "zero-order-hold", "rim-nonsmooth/profile", "below reference"],
    );
}

#[test]
fn stability_map() {
    let drawing = stability().draw();
    check(&drawing, "stability", &["zero-order-hold", "fraction stable", "skipped: needs a model", "stable but wrong"]);
}

#[test]
fn manoeuvre_sequence() {
    let drawing = manoeuvre().draw();
    check(&drawing, "manoeuvre", &["t = 0.000 s", "t = 1.700 s", "rim-smooth", "rim-nonsmooth", "F = +19.64 kN"]);
}

#[test]
fn performance_profile_of_all_solvers() {
    let drawing = draw_profile(&replays(), &solver_names());
    let mut labels = vec!["60 contact problems, warm", "share of problems solved"];
    labels.extend(solvers().iter().map(|entry| &*entry.name));
    check(&drawing, "solver-profile", &labels);
    // A solver keeps its line when others are left out.
    let alone = draw_profile(&replays()[4..6], &solver_names());
    let lines = |drawing: &Drawing| {
        let stroke = |shape: &Shape| match shape {
            Shape::Path { stroke, closed: false, .. } => stroke.filter(|stroke| stroke.width > 1.0),
            _ => None,
        };
        drawing.shapes.iter().filter_map(stroke).map(|stroke| (stroke.color, stroke.dash)).collect::<Vec<_>>()
    };
    let (all, alone) = (lines(&drawing), lines(&alone));
    assert!(!alone.is_empty() && alone.iter().all(|line| all.contains(line)), "{alone:?}");
}

#[test]
fn an_empty_figure_is_an_empty_page() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let files = render::write(&Figure::new(200.0, 100.0).draw(), place.path(), "empty").expect("a writable folder");
    assert!(files.svg.is_file() && files.png.is_file());
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let file = place.path().join("file");
    std::fs::write(&file, "").expect("a writable folder");
    let error = render::write(&Drawing::new(10.0, 10.0), &file, "figure").expect_err("a file is no folder");
    assert!(matches!(error, Error::File { path, .. } if path.starts_with(&file)));
}

/// Results of a made-up experiment `study/made-up`: two schemes, two macro steps, two phases, two margins.
fn made_up_results(folder: &Path) {
    let folder = folder.join("study/made-up");
    std::fs::create_dir_all(&folder).unwrap();
    let mut runs = String::from(
        "run_id,case,set,label,mechanics_steps,macro_step_s,phase,outcome,error,residual_j,reference_error,\
         actuator_micro_steps,mechanics_steps\n",
    );
    let mut cost = String::from("run_id,wall_s\n");
    let mut id = 0;
    for (label, scale, limit) in [("rim-smooth", 9.0, 2e-3), ("rim-nonsmooth-gap/profile", 1.0, 1.0)] {
        for set in ["", "margin_m=0.1"] {
            for step in [1e-3, 5e-3] {
                for phase in [1.0, 0.4] {
                    let outcome = if step > limit && phase < 0.9 { "diverged" } else { "completed" };
                    let (error, residual) = (scale * step * phase, if label.contains('/') { -step } else { step });
                    runs += &format!(
                        "{id:x},box,{set},{label},all,{step},{phase},{outcome},{error},{residual},1e-4,500,{}\n",
                        (1.0 / step) as u64
                    );
                    cost += &format!("{id:x},{}\n", 1e-2 / step);
                    id += 1;
                }
            }
        }
    }
    let parameters = "case,set,parameter,value\nbox,,margin_m,0.01\nbox,margin_m=0.1,margin_m,0.1\n";
    for (name, text) in [("runs.csv", runs.as_str()), ("cost.csv", cost.as_str()), ("parameters.csv", parameters)] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    seal(&folder);
}

/// Says of made-up results that they are as they were written.
fn seal(folder: &Path) {
    checksums::write(folder, ["runs.csv", "cost.csv", "parameters.csv"].map(str::to_owned)).unwrap();
}

/// A list with one figure of each kind that reads the made-up results, and some that cannot be drawn.
const MADE_UP_FIGURES: &str = r#"
[[figure]]
id = "map"
kind = "stability-map"
experiment = "study/made-up"
source = "runs.csv"
caption = "…"
title = "made up"
metric = "error"
only = { set = "all" }
wrong_above = 5e-3
hatch_label = "stable but wrong"
width = 700
height = 240

[[figure]]
id = "sweep"
kind = "sweep"
experiment = "study/made-up"
source = "runs.csv"
caption = "…"
width = 600
height = 400
[[figure.panels]]
title = "created"
metric = "residual_j"
only = { set = "all" }
part = "negative"
label = "minus residual (J)"
range = [1e-6, 1e-1]
floor = "reference_error"
slope = [1.0, [2.0, 1e-3]]

[[figure]]
id = "work"
kind = "work-precision"
experiment = "study/made-up"
source = "runs.csv, cost.csv"
caption = "…"
metric = "error"
label = "error (N)"
range = [1e-4, 1.0]
width = 800
height = 400
[[figure.panels]]
title = "(a)"
only = { set = "all" }
cost = "wall_s"
label = "wall time (s)"
[[figure.panels]]
title = "(b)"
only = { case = "box", set = "all" }
cost = "actuator_micro_steps + mechanics_steps"
label = "steps"

[[figure]]
id = "margin"
kind = "parameter-sweep"
experiment = "study/made-up"
source = "runs.csv, parameters.csv"
caption = "…"
parameter = "margin_m"
x_label = "margin (m)"
width = 800
height = 400
[[figure.panels]]
title = "(a)"
metric = "error"
label = "error (N)"
range = [1e-4, 1.0]
macro_step_s = 5e-3
[[figure.panels]]
title = "(b)"
metric = "fraction_stable"
macro_step_s = 5e-3
label = "fraction stable"
range = [0.0, 1.0]
labels = ["rim-smooth"]

[[figure]]
id = "latency"
kind = "latency"
experiment = "study/made-up"
source = "runs.csv, cost.csv"
caption = "…"
width = 1000
height = 400
range_us = [1.0, 1e5]
only = { set = "all" }

[[figure]]
id = "other"
kind = "latency"
experiment = "paper/not-run"
source = "runs.csv, cost.csv"
caption = "…"
width = 1000
height = 400
range_us = [1.0, 1e5]
"#;

#[test]
fn figures_are_drawn_from_stored_results_and_those_that_cannot_be_are_named() {
    let place = tempfile::tempdir().expect("a temporary folder");
    made_up_results(place.path());
    let list = place.path().join("figures.toml");
    std::fs::write(&list, MADE_UP_FIGURES).unwrap();
    let figures = FigureList::read(&list).unwrap();
    let made = figures.make_all(place.path(), Some("study"), &Styles::standard()).unwrap();
    assert_eq!((made.files.len(), made.missing.len()), (4, 0), "{:?}", made.failed);
    let texts = |id: &str| {
        let svg = read(&place.path().join(format!("study/made-up/figures/{id}.svg")));
        texts_of(&String::from_utf8(svg).unwrap())
    };
    for (id, labels) in [
        ("map", &["stable but wrong", "rim-smooth", "0.50", "1", "5"] as &[&str]),
        ("sweep", &["created", "uncertainty of the reference", "rim-nonsmooth-gap, profile, order 1.00"]),
        ("sweep", &["diverged", "some runs diverged"]),
        ("work", &["rim-smooth: some runs diverged"]),
        ("work", &["wall time (s)", "steps", "rim-nonsmooth-gap, profile"]),
        ("margin", &["margin (m)", "fraction stable", "rim-smooth", "rim-nonsmooth-gap, profile"]),
    ] {
        let texts = texts(id);
        for label in labels {
            assert!(texts.contains_key(*label), "{label} in {id}: {texts:?}");
        }
    }
    // The results are older than the columns that the figure needs; the reason names file and column.
    let [(id, reason)] = &made.failed[..] else { panic!("{:?}", made.failed) };
    assert!(id == "latency" && reason.contains("cost.csv") && reason.contains("latency_p50_s"), "{reason}");

    // With the columns it is drawn, and without a group the experiment that was not run is named.
    let cost = place.path().join("study/made-up/cost.csv");
    let rows = std::fs::read_to_string(&cost).unwrap();
    let longer = |(k, row): (usize, &str)| {
        let more = if k == 0 { ",latency_p50_s,latency_p99_s,latency_max_s" } else { ",1e-5,3e-5,2e-3" };
        format!("{row}{more}\n")
    };
    std::fs::write(&cost, rows.lines().enumerate().map(longer).collect::<String>()).unwrap();
    seal(&place.path().join("study/made-up"));
    let made = figures.make_all(place.path(), None, &Styles::standard()).unwrap();
    assert_eq!(made.files.len(), 5);
    assert!(made.missing.len() == 1 && made.missing[0].1.contains("experiments/paper/not-run.toml"));
    assert!(texts("latency").contains_key("deadline: real time"));
}

#[test]
fn an_unknown_column_or_parameter_is_named() {
    let place = tempfile::tempdir().expect("a temporary folder");
    made_up_results(place.path());
    let list = place.path().join("figures.toml");
    let wrong = MADE_UP_FIGURES.replace("actuator_micro_steps +", "pivots +").replace("\"margin_m\"", "\"mass_kg\"");
    std::fs::write(&list, wrong).unwrap();
    let made = FigureList::read(&list).unwrap().make_all(place.path(), Some("study"), &Styles::standard()).unwrap();
    let reason_of = |id: &str| &made.failed.iter().find(|(failed, _)| failed == id).expect("not drawn").1;
    assert!(reason_of("work").contains("pivots"), "{}", reason_of("work"));
    assert!(reason_of("margin").contains("mass_kg"), "{}", reason_of("margin"));
    assert!(
        FigureList::read(&list).unwrap().make_all(&place.path().join("nowhere"), None, &Styles::standard()).is_err()
    );
}

/// A panel may show one case of several; one that is not there is named with those that are.
#[test]
fn a_figure_of_one_case_has_only_its_runs() {
    let place = tempfile::tempdir().expect("a temporary folder");
    made_up_results(place.path());
    let list = place.path().join("figures.toml");
    let one = |set: &str| MADE_UP_FIGURES.replacen("{ set = \"all\" }", &format!("{{ set = \"{set}\" }}"), 1);
    std::fs::write(&list, one("margin_m=0.1")).unwrap();
    let runs = place.path().join("study/made-up/runs.csv");
    // Both phases of rim-smooth at 5 ms stay stable in the set that is shown, and in that only.
    let kept = |row: &str| {
        if row.contains("margin_m=0.1,rim-smooth") { row.replace("diverged", "completed") } else { row.into() }
    };
    let rows: String = std::fs::read_to_string(&runs).unwrap().lines().map(|row| kept(row) + "\n").collect();
    std::fs::write(&runs, rows).unwrap();
    seal(&place.path().join("study/made-up"));
    let values = |list: &Path| {
        let made = FigureList::read(list).unwrap().make_all(place.path(), Some("study"), &Styles::standard()).unwrap();
        let svg = read(&place.path().join("study/made-up/figures/map.svg"));
        (made, texts_of(&String::from_utf8(svg).unwrap()))
    };
    // The colour bar may say the same.
    let three_quarters = |list: &Path| values(list).1.get("0.75").copied().unwrap_or_default();
    let of_one = three_quarters(&list);
    std::fs::write(&list, MADE_UP_FIGURES).unwrap();
    assert_eq!(three_quarters(&list), of_one + 1, "three of the four runs of both sets are stable");

    std::fs::write(&list, one("margin_m=0.2")).unwrap();
    let (made, _) = values(&list);
    let reason = &made.failed.iter().find(|(failed, _)| failed == "map").expect("not drawn").1;
    assert!(reason.contains("map.svg is older"), "a picture of other results is left: {reason}");
    assert!(reason.contains("margin_m=0.2") && reason.contains("margin_m=0.1"), "{reason}");
}

/// Reads a list with one figure of a kind, and returns what is wrong with it.
fn refused(figure: &str) -> String {
    FigureList::parse(Path::new("my.toml"), figure).unwrap_err().to_string()
}

const LEAST_SWEEP: &str = "[[figure]]\nid = \"mine\"\nkind = \"sweep\"\nexperiment = \"study/made-up\"\n";
const LEAST_PANEL: &str = "[[figure.panels]]\nmetric = \"error\"\n";
/// The same of the made-up results, which have two sets of parameters.
const POOLED_PANEL: &str = "[[figure.panels]]\nmetric = \"error\"\nonly = { set = \"all\" }\n";

#[test]
fn what_is_wrong_with_a_list_is_told_all_at_once_with_lines_and_nothing_panics() {
    for (line, wanted) in [
        ("width = 0", "width = 0 is not valid; valid: a number of px from 240 to 4000"),
        ("width = 1", "width = 1 is"),
        ("width = -1", "width = -1 is"),
        ("width = 1e9", "width = 1000000000.0 is"),
        ("width = nan", "width = NaN is"),
        ("width = \"wide\"", "width = \"wide\" is"),
        ("height = inf", "height = inf is"),
        ("widht = 700", "unknown key `widht` (did you mean `width`?)"),
        ("columns = 0", "columns = 0 is"),
    ] {
        let message = refused(&format!("{LEAST_SWEEP}{line}\n{LEAST_PANEL}"));
        assert!(message.contains("my.toml: [[figure]] in line 1 (`mine`): ") && message.contains(wanted), "{message}");
    }
    for (line, wanted) in [
        (
            "range = [1.0, 1e-3]",
            "panels 1: range = [1.0, 0.001] is not valid; valid: [low, high], finite, 0 < low < high",
        ),
        ("range = [0.0, 1.0]", "panels 1: range = "),
        ("range = [1.0]", "panels 1: range = "),
        ("part = \"upper\"", "panels 1: part = "),
        ("slope = [1.0, [0.0, 1.0]]", "panels 1: slope = "),
        ("only = { caze = \"box\" }", "panels 1: only: unknown key `caze` (did you mean `case`?)"),
        ("labels = [1, 2]", "panels 1: labels = [1, 2] is"),
    ] {
        let message = refused(&format!("{LEAST_SWEEP}{LEAST_PANEL}{line}\n"));
        assert!(message.contains(wanted), "{message}");
    }
    for id in ["../mine", "/mine", "a/b", "", ".", "..", ".hidden", "a b", "\u{e9}", &"x".repeat(400_000)] {
        let message = refused(&format!("{}{LEAST_PANEL}", LEAST_SWEEP.replace("mine", id)));
        assert!(message.contains("id = ") && message.contains("a file name of letters"), "{message}");
        assert!(message.len() < 600, "{} characters", message.len());
    }
    for experiment in ["made-up", "../study/made-up", "/study/made-up", "study/..", "study/a/b"] {
        let message = refused(&format!("{}{LEAST_PANEL}", LEAST_SWEEP.replace("study/made-up", experiment)));
        assert!(message.contains("experiment = "), "{message}");
    }
    // All at once, and those of the second figure with its line.
    let twice = format!("{LEAST_SWEEP}width = 0\nheight = 0\n[[figure.panels]]\n{LEAST_SWEEP}{LEAST_PANEL}");
    let message = refused(&twice);
    for wanted in
        ["3 things are wrong", "width = 0", "height = 0", "panels 1: key `metric` is missing: a column of runs.csv"]
    {
        assert!(message.contains(wanted), "{wanted}: {message}");
    }
    let message = refused(&format!("{LEAST_SWEEP}{LEAST_PANEL}{LEAST_SWEEP}{LEAST_PANEL}"));
    assert!(message.contains("[[figure]] in line 7 (`mine`): another figure has this id"), "{message}");
    let message = refused("[[figure]]\n");
    assert!(message.contains("key `id` is missing") && message.contains("key `kind` is missing: "), "{message}");
    assert!(refused("[[figures]]\n").contains("line 1, column 3"), "{}", refused("[[figures]]\n"));
}

#[test]
fn what_may_be_left_out_has_a_default_and_the_figure_is_drawn() {
    let place = tempfile::tempdir().expect("a temporary folder");
    made_up_results(place.path());
    let figures = FigureList::parse(Path::new("my.toml"), &format!("{LEAST_SWEEP}{POOLED_PANEL}")).unwrap();
    let made = figures.make_all(place.path(), None, &Styles::standard()).unwrap();
    assert_eq!((made.files.len(), &made.failed[..]), (1, &[][..]));
    let svg = String::from_utf8(read(&place.path().join("study/made-up/figures/mine.svg"))).unwrap();
    assert!(svg.contains("viewBox=\"0 0 680 330\""), "{}", &svg[..200]);
    assert!(texts_of(&svg).contains_key("error"), "the label is the metric");
}

#[test]
fn a_label_that_no_run_has_and_panels_without_room_are_told() {
    let place = tempfile::tempdir().expect("a temporary folder");
    made_up_results(place.path());
    let drawn = |text: &str| {
        let figures = FigureList::parse(Path::new("my.toml"), text).unwrap();
        figures.make_all(place.path(), None, &Styles::standard()).unwrap()
    };
    let made = drawn(&format!("{LEAST_SWEEP}{POOLED_PANEL}labels = [\"rim-smooth\", \"rim-smoth\"]\n"));
    assert!(made.failed[0].1.contains("unknown label `rim-smoth` (did you mean `rim-smooth`?)"), "{:?}", made.failed);
    let narrow = format!("{LEAST_SWEEP}width = 240\nheight = 240\n{}", POOLED_PANEL.repeat(12));
    let made = drawn(&narrow);
    assert!(made.failed[0].1.contains("width = 240 px leaves"), "{:?}", made.failed);
    assert!(!place.path().join("study/made-up/figures").exists(), "nothing is made for a figure that cannot be drawn");
}

#[test]
fn every_key_of_a_figure_is_in_the_documentation() {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("paper/README.md")).unwrap();
    let row = |key: &FigureKey| {
        let cells = [key.takes.as_str(), key.absent.as_str(), key.about].map(|cell| cell.replace('|', "\\|"));
        format!("| {} | `{}` | {} |", key.place, key.name, cells.join(" | "))
    };
    let rows: Vec<String> = figure_keys().iter().map(row).collect();
    let missing: Vec<&String> = rows.iter().filter(|row| !text.contains(row.as_str())).collect();
    assert!(
        missing.is_empty(),
        "paper/README.md lacks:\n{}",
        missing.iter().map(|row| format!("{row}\n")).collect::<String>()
    );
    let told = text.lines().filter(|line| line.starts_with("| ") && line.contains("| `")).count();
    assert_eq!(told, rows.len(), "paper/README.md tells of keys that there are not");
}

#[test]
fn a_figure_that_would_pool_cases_sets_or_macro_steps_without_a_word_is_refused() {
    let place = tempfile::tempdir().expect("a temporary folder");
    made_up_results(place.path());
    let list = place.path().join("figures.toml");
    let reason_of = |text: &str, id: &str| {
        std::fs::write(&list, text).unwrap();
        let figures = FigureList::read(&list).unwrap();
        let made = figures.make_all(place.path(), Some("study"), &Styles::standard()).unwrap();
        made.failed.into_iter().find(|(failed, _)| failed == id).expect("not drawn").1
    };
    let silent = MADE_UP_FIGURES.replace("only = { set = \"all\" }\n", "");
    for id in ["map", "sweep", "work", "latency"] {
        let reason = reason_of(&silent, id);
        assert!(reason.contains("drawn as one") && reason.contains("\"margin_m=0.1\""), "{id}: {reason}");
    }
    let reason = reason_of(&MADE_UP_FIGURES.replace("macro_step_s = 5e-3\n", ""), "margin");
    assert!(reason.contains("several values of macro_step_s"), "{reason}");
    // A second case with the same margins.
    let folder = place.path().join("study/made-up");
    let rows = std::fs::read_to_string(folder.join("runs.csv")).unwrap();
    let half = |row: (usize, &str)| {
        if row.0.is_multiple_of(2) && row.0 > 0 { row.1.replace(",box,", ",ball,") } else { row.1.into() }
    };
    std::fs::write(folder.join("runs.csv"), rows.lines().enumerate().map(|row| half(row) + "\n").collect::<String>())
        .unwrap();
    let parameters = std::fs::read_to_string(folder.join("parameters.csv")).unwrap();
    std::fs::write(
        folder.join("parameters.csv"),
        format!("{parameters}ball,,margin_m,0.01\nball,margin_m=0.1,margin_m,0.1\n"),
    )
    .unwrap();
    seal(&folder);
    for (id, wanted) in [("map", "case = …"), ("margin", "case and set")] {
        let reason = reason_of(MADE_UP_FIGURES, id);
        assert!(reason.contains(wanted) && reason.contains("ball"), "{id}: {reason}");
    }
}

#[test]
fn half_a_file_or_an_edited_one_is_no_source_of_a_figure() {
    let place = tempfile::tempdir().expect("a temporary folder");
    made_up_results(place.path());
    let (list, folder) = (place.path().join("figures.toml"), place.path().join("study/made-up"));
    std::fs::write(&list, MADE_UP_FIGURES).unwrap();
    let reasons = || {
        let figures = FigureList::read(&list).unwrap();
        figures.make_all(place.path(), Some("study"), &Styles::standard()).unwrap().failed
    };
    let whole = std::fs::read_to_string(folder.join("runs.csv")).unwrap();
    let rows: Vec<&str> = whole.lines().collect();
    for other in
        [rows[..2].join("\n"), whole.replacen("diverged", "completed", 1), rows[..].join("\n") + "\n" + rows[1] + "\n"]
    {
        std::fs::write(folder.join("runs.csv"), other).unwrap();
        let missing = reasons();
        assert!(missing.len() == 5 && missing[0].1.contains("runs.csv has been changed"), "{missing:?}");
    }
    std::fs::write(folder.join("runs.csv"), whole).unwrap();
    std::fs::remove_file(folder.join("SHA256SUMS")).unwrap();
    assert!(reasons()[0].1.contains("run the experiment again"));
    let figures = FigureList::read(&list).unwrap();
    let message = figures.make_all(place.path(), Some("nope"), &Styles::standard()).unwrap_err().to_string();
    assert!(message.contains("unknown group of figures `nope`") && message.contains("study"), "{message}");
}

/// Writes a drawing twice and checks: both files, equal bytes, each label once, nothing outside the page.
fn check(drawing: &Drawing, name: &str, labels: &[&str]) {
    let place = tempfile::tempdir().expect("a temporary folder");
    let files = render::write(drawing, place.path(), name).expect("a writable folder");
    let (svg, png) = (read(&files.svg), read(&files.png));
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
    let again = render::write(drawing, place.path(), name).expect("a writable folder");
    assert!(svg == read(&again.svg) && png == read(&again.png), "{name} is not reproducible");

    let svg = String::from_utf8(svg).expect("an SVG is text");
    let texts = texts_of(&svg);
    for label in labels {
        assert_eq!(texts.get(*label), Some(&1), "{label} in {name}: {texts:?}");
    }
    for shape in &drawing.shapes {
        let corners = match shape {
            Shape::Path { points, .. } => points.clone(),
            Shape::Disc { centre: (x, y), radius, .. } => vec![(x - radius, y - radius), (x + radius, y + radius)],
            Shape::Open(_) | Shape::Close => continue,
            Shape::Text(text) => {
                let (back, forth) = (text.lead(), text.width() - text.lead());
                let along = |d: f64| {
                    if text.upwards { (text.at.0, text.at.1 - d) } else { (text.at.0 + d, text.at.1) }
                };
                vec![along(-back), along(forth)]
            }
        };
        for (x, y) in corners {
            let inside = (0.0..=drawing.width).contains(&x) && (0.0..=drawing.height).contains(&y);
            assert!(inside, "({x}, {y}) of {shape:?} is outside {name}");
        }
    }
    if let Ok(folder) = std::env::var("RIMBENCH_FIGURES_DIR") {
        render::write(drawing, Path::new(&folder), name).expect("a writable folder");
    }
}

fn read(path: &Path) -> Vec<u8> {
    std::fs::read(path).expect("a written figure")
}

/// Counts the text elements of an SVG and checks that all its elements are known and tags are balanced.
fn texts_of(svg: &str) -> BTreeMap<String, usize> {
    let mut texts = BTreeMap::new();
    assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
    let mut open: Vec<&str> = Vec::new();
    for tag in svg.split('<').skip(1) {
        let (inside, after) = tag.split_once('>').expect("a tag has an end");
        assert!(!inside.contains("NaN") && !inside.contains("inf"), "{tag}");
        if let Some(name) = inside.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "{tag}");
            continue;
        }
        let name = inside.split([' ', '/']).next().unwrap_or_default();
        assert!(["svg", "title", "path", "g", "text"].contains(&name), "{tag}");
        if name == "text" {
            let plain = after.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&");
            *texts.entry(plain).or_default() += 1;
        }
        if !inside.ends_with('/') {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "{open:?}");
    texts
}

/// Something like the paper's Fig. 2.
fn force_and_mass() -> Figure {
    let force_at = |t: f64| {
        let start = if t > 0.1 { 1000.0 * (-(t - 0.2f64).powi(2) / 0.003).exp() } else { 0.0 };
        let descent = if (0.35..TOUCH_DOWN_S).contains(&t) { -181.0 * (1.0 - (-(t - 0.35) / 0.05).exp()) } else { 0.0 };
        let s = t - TOUCH_DOWN_S;
        let blow = if s > 0.0 { -800.0 * (-s / 0.06).exp() * (s * 90.0).cos() } else { 0.0 };
        start + descent + blow
    };
    let mass_at = |t: f64| match t {
        t if t < 0.4 => 250.0,
        t if t < TOUCH_DOWN_S => 275.6,
        t if t < TOUCH_DOWN_S + 0.02 => f64::INFINITY,
        _ => 250.0,
    };
    let sample = |step: f64, f: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        (0..=(2.5 / step).round() as usize).map(|k| (k as f64 * step, f(k as f64 * step))).collect()
    };
    let spiky = |t: f64| {
        let s = t - TOUCH_DOWN_S;
        let ringing = if s > 0.0 { 21_000.0 * (-s / 0.012).exp() * (s * 700.0).sin() } else { 0.0 };
        force_at(t) + ringing
    };
    let late = |t: f64| force_at(t - 0.004) + 25.0 * (40.0 * t).sin();
    let hold = |t: f64| if t > 0.3 { f64::NAN } else { 40.0 * (t / 0.04).exp() * (900.0 * t).sin() };
    let gap = |t: f64| force_at(t - 0.001);
    let forces = [
        Series::new("reference", sample(0.0002, &force_at), style_of("reference")),
        Series::new("zero-order-hold", sample(0.005, &hold), style_of("zero-order-hold")),
        Series::new("rim-smooth", sample(0.005, &spiky), style_of("rim-smooth")),
        Series::new("rim-nonsmooth", sample(0.005, &late), style_of("rim-nonsmooth")),
        Series::new("rim-nonsmooth-gap", sample(0.005, &gap), style_of("rim-nonsmooth-gap")),
    ];
    let light = |t: f64| if mass_at(t).is_infinite() { 310.0 } else { mass_at(t) };
    let masses = [
        Series::new("rim-smooth", sample(0.005, &mass_at), style_of("rim-smooth")).mode(Mode::Steps),
        Series::new("rim-nonsmooth", sample(0.005, &light), style_of("rim-nonsmooth")).mode(Mode::Steps),
    ];
    let time = || Axis::linear("time t (s)");
    let force = Panel::new("(a) actuator force", time(), Axis::linear("actuator force F (N)").range(-2000.0, 2000.0));
    let mass =
        Panel::new("(b) effective mass at the interface", time(), Axis::log10("effective mass (kg)").range(100.0, 1e4));
    let zoom_x = Axis::linear("time t (s), touch-down").range(1.66, 1.78);
    let zoom =
        Panel::new("(c) force at touch-down", zoom_x, Axis::linear("actuator force F (N)").range(-2000.0, 2000.0));
    let touch_down = || Guide::Vertical { x: TOUCH_DOWN_S, label: "touch-down".to_owned() };
    let with = |panel: Panel, series: &[Series]| series.iter().cloned().fold(panel, Panel::series);
    Figure::new(1180.0, 400.0)
        .columns(3)
        .panel(with(force, &forces).guide(Guide::Horizontal { y: 0.0, label: String::new() }))
        .panel(with(mass, &masses).inset(Inset { x: (1.65, 1.76), y: (230.0, 340.0), place: [0.16, 0.52, 0.42, 0.36] }))
        .panel(with(zoom, &forces).guide(touch_down()))
}

fn convergence() -> Figure {
    let steps = [0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0];
    let error = |scale: f64, order: f64, floor: f64| -> Vec<(f64, f64)> {
        steps.iter().map(|&h| (h, (scale * f64::powf(h, order)).hypot(floor))).collect()
    };
    let mut held = error(30.0, 1.0, 0.0);
    held[5].1 = f64::INFINITY;
    held[6].1 = f64::INFINITY;
    let series =
        |label: &str, points: Vec<(f64, f64)>| Series::new(label, points, style_of(label)).mode(Mode::LineMarkers);
    let y = Axis::log10("force error, rms (N)");
    let panel = Panel::new("(a) force", Axis::log10("macro step H (ms)"), y)
        .series(series("zero-order-hold", held))
        .series(series("rim-smooth", error(12.0, 0.5, 0.0)))
        .series(series("rim-nonsmooth", error(4.0, 1.0, 3.0)))
        .series(series("rim-nonsmooth/profile", error(0.3, 1.0, 0.0)))
        .series(series("rim-nonsmooth-gap", error(0.02, 2.0, 0.0)))
        .series(series("my-scheme", error(1.5, 1.0, 0.0)))
        .guide(Guide::Slope { order: 1.0, from: (6.0, 0.12), to_x: 15.0 })
        .guide(Guide::Slope { order: 2.0, from: (1.0, 3.5e-3), to_x: 2.5 })
        .guide(Guide::Horizontal { y: 2e-3, label: "below reference".to_owned() });
    let position = Panel::new("(b) position", Axis::log10("H (ms)"), Axis::log10("position error, rms (m)"))
        .series(series("rim-smooth", error(1e-5, 1.0, 1e-6)))
        .series(series("rim-nonsmooth", error(1e-7, 2.0, 0.0)))
        .note("slopes as declared", (0.04, 0.94));
    Figure::new(980.0, 420.0).legend(LegendPlace::Right).panel(panel).panel(position)
}

fn stability() -> Heatmap {
    let columns = vec![0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 50.0, 100.0];
    let names =
        ["zero-order-hold", "first-order-hold", "rim-smooth", "rim-nonsmooth", "rim-nonsmooth-gap", "rim-fixed-mass"];
    let limits = [2.4, 1.2, 9.0, 45.0, 120.0, 16.0];
    let row = |(name, limit): (&str, f64)| {
        let cell = |(column, &h): (usize, &f64)| {
            let value = (1.0 / (1.0 + (h / limit).powi(3))).clamp(0.0, 1.0);
            let skipped = name == "first-order-hold" && column > 8;
            Cell {
                value: (!skipped).then_some((20.0 * value).round() / 20.0),
                shown: None,
                hatched: name == "rim-smooth" && (3.0..20.0).contains(&h),
            }
        };
        Row {
            label: name.to_owned(),
            color: style_of(name).color,
            cells: columns.iter().enumerate().map(cell).collect(),
        }
    };
    Heatmap {
        width: 860.0,
        height: 330.0,
        title: "Wedge box: fraction of phases that stay stable".to_owned(),
        x_label: "macro step H (ms)".to_owned(),
        value_label: "fraction stable".to_owned(),
        skipped_label: "skipped: needs a model".to_owned(),
        hatch_label: "stable but wrong".to_owned(),
        show_values: true,
        rows: names.into_iter().zip(limits).map(row).collect(),
        columns: columns.clone(),
        names: Vec::new(),
    }
}

fn manoeuvre() -> Manoeuvre {
    let geometry = WedgeBoxGeometry::default();
    let start_angle = f64::to_radians(-2.3968);
    let pose = |time_s: f64, x: f64, share: f64, lift: f64, forces: &[f64], actuator: f64| {
        let angle = start_angle * (1.0 - share);
        let (sin, cos) = angle.sin_cos();
        // The lower of the two wedge tips is `lift` above the floor.
        let tip = geometry.wedge_tips.iter().map(|t| sin * t.0 + cos * t.1).fold(f64::INFINITY, f64::min);
        let mut pose = Pose {
            time_s,
            box_x_m: x,
            box_y_m: lift - tip,
            box_angle_rad: angle,
            disc_angle_rad: -x / 0.2,
            contact_forces: Vec::new(),
            actuator_force_n: actuator,
        };
        let disc = pose.world(geometry.disc_pin);
        let (right, left) = (pose.world(geometry.wedge_tips[0]), pose.world(geometry.wedge_tips[1]));
        let slant = geometry.ramp_slope.atan();
        let on_ramp = disc.0 > geometry.ledge_corner_x_m;
        let n = if on_ramp { (slant.sin(), slant.cos()) } else { (0.0, 1.0) };
        let at = [right, left, (disc.0 - 0.2 * n.0, disc.1 - 0.2 * n.1)];
        for (index, &newtons) in forces.iter().enumerate().filter(|(_, newtons)| **newtons > 0.0) {
            let (nx, ny) = if index == 2 { n } else { (0.0, 1.0) };
            let (x_m, y_m) = at[index];
            pose.contact_forces.push(ContactForce { x_m, y_m, fx_n: newtons * nx, fy_n: newtons * ny });
        }
        pose
    };
    let smooth = vec![
        pose(0.0, 0.0, 0.0, 0.0, &[1600.0, 0.0, 850.0], 0.0),
        pose(0.6, 0.16, 0.25, 0.0, &[1640.0, 0.0, 820.0], -181.0),
        pose(1.7, 0.44, 1.0, 0.0032, &[0.0, 9800.0, 900.0], 19_640.0),
        pose(1.8, 0.52, 1.05, 0.0058, &[0.0, 0.0, 0.0], -13_200.0),
        pose(2.4, 0.98, 1.0, 0.0, &[1460.0, 990.0, 0.0], 0.0),
    ];
    let nonsmooth = vec![
        pose(0.0, 0.0, 0.0, 0.0, &[1600.0, 0.0, 850.0], 0.0),
        pose(0.6, 0.16, 0.26, 0.0, &[1640.0, 0.0, 820.0], -181.0),
        pose(1.7, 0.44, 1.0, 0.0, &[1300.0, 900.0, 250.0], -790.0),
        pose(1.8, 0.52, 1.0, 0.0, &[1460.0, 990.0, 0.0], -60.0),
        pose(2.4, 0.98, 1.0, 0.0, &[1460.0, 990.0, 0.0], 0.0),
    ];
    let row = |scheme: &str, poses| ManoeuvreRow { scheme: scheme.to_owned(), color: style_of(scheme).color, poses };
    let rows = vec![row("rim-smooth", smooth), row("rim-nonsmooth", nonsmooth)];
    Manoeuvre { width: 1180.0, geometry, arrow_force_n: 2000.0, rows }
}

/// Results of an experiment that no list names: schemes on cases, each with macro steps of its own, that diverge at the largest.
fn unlisted_results(folder: &Path, name: &str, cases: &[(&str, [f64; 3])], schemes: usize) {
    let folder = folder.join(name);
    std::fs::create_dir_all(&folder).unwrap();
    let mut runs = String::from("run_id,case,set,label,scheme,macro_step_s,phase,outcome,force_error_rms_of_peak\n");
    let mut id = 0;
    for (case, steps) in cases {
        for scheme in 0..schemes {
            for (index, step) in steps.iter().enumerate() {
                let lost = index == 2 && scheme == 0;
                let (outcome, error) =
                    if lost { ("diverged", f64::NAN) } else { ("completed", 0.01 * (index + scheme + 1) as f64) };
                runs += &format!("{id:x},{case},,row-{scheme}/1um,rim-smooth,{step},1.0,{outcome},{error}\n");
                id += 1;
            }
        }
    }
    std::fs::write(folder.join("runs.csv"), runs).unwrap();
    checksums::write(&folder, ["runs.csv".to_owned()]).unwrap();
}

#[test]
fn an_experiment_that_no_list_names_has_a_map_of_its_stability_and_its_errors() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let steps = [1e-3, 2e-3, 5e-3];
    unlisted_results(place.path(), "mine/few", &[("box", steps)], 3);
    unlisted_results(place.path(), "mine/many", &[("box", steps), ("bar", [1e-6, 2e-6, 5e-6])], 20);
    std::fs::create_dir_all(place.path().join("mine/broken")).unwrap();
    std::fs::write(place.path().join("mine/broken/runs.csv"), "a,b\n1,2\n").unwrap();
    let none = FigureList { figures: Vec::new() };
    let (list, failed) = none.completed(place.path(), None);
    let [(name, reason)] = &failed[..] else { panic!("{failed:?}") };
    assert!(name == "mine/broken" && reason.contains("label"), "{reason}");
    let made = list.make_all(place.path(), None, &Styles::standard()).unwrap();
    assert!(made.failed.is_empty() && made.files.len() == 4, "{made:?}");
    let texts = |name: &str, id: &str| {
        texts_of(&String::from_utf8(read(&place.path().join(format!("{name}/figures/{id}.svg")))).unwrap())
    };
    let few = texts("mine/few", "mine-few-error");
    let says = |words: &str| few.keys().any(|text| text.starts_with(words));
    assert!(says("diverged") && says("row-0, margin 1 µm"), "{few:?}");
    // Of many schemes rows, with the cases' own macro steps; a map by case has the largest stable one.
    let many = texts("mine/many", "mine-many-error");
    assert!(many.contains_key("row-19, margin 1 µm") && many.contains_key("(b) box"), "{many:?}");
    let map = texts("mine/many", "mine-many-stability");
    assert!(map.contains_key("bar (µs)") && map.contains_key("box") && map["2"] == 2 && map["5"] == 38, "{map:?}");
    // A list that names an experiment says all of it.
    let named = format!(
        "{}[[figure.panels]]\nmetric = \"force_error_rms_of_peak\"\n",
        LEAST_SWEEP.replace("study/made-up", "mine/few")
    );
    let (list, _) = FigureList::parse(Path::new("my.toml"), &named).unwrap().completed(place.path(), Some("mine"));
    assert!(!list.figures.iter().any(|figure| figure.id.starts_with("mine-few")), "{:?}", list.figures);
}

#[test]
fn a_picture_that_leaves_cases_out_says_so_itself() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let names: Vec<String> = (0..14).map(|case| format!("case-{case:02}")).collect();
    let cases: Vec<(&str, [f64; 3])> = names.iter().map(|name| (name.as_str(), [1e-3, 2e-3, 5e-3])).collect();
    unlisted_results(place.path(), "mine/lines", &cases, 3);
    unlisted_results(place.path(), "mine/rows", &cases, 20);
    unlisted_results(place.path(), "mine/all", &cases[..12], 20);
    let (list, failed) = FigureList { figures: Vec::new() }.completed(place.path(), None);
    let made = list.make_all(place.path(), None, &Styles::standard()).unwrap();
    assert!(failed.is_empty() && made.failed.is_empty(), "{failed:?} {made:?}");
    for (name, left_out) in [("lines", true), ("rows", true), ("all", false)] {
        let svg = read(&place.path().join(format!("mine/{name}/figures/mine-{name}-error.svg")));
        let texts = texts_of(&String::from_utf8(svg).unwrap());
        let said = texts.keys().any(|text| text.starts_with("2 more cases are not drawn"));
        assert_eq!(said, left_out, "{name}: {texts:?}");
        assert!(texts.contains_key("(l) case-11"), "{texts:?}");
    }
}

#[test]
fn ranked_rows_signed_axes_and_lost_phases_say_what_they_show() {
    let place = tempfile::tempdir().expect("a temporary folder");
    made_up_results(place.path());
    let drawn = |text: &str, id: &str| {
        let list = FigureList::parse(Path::new("my.toml"), text).unwrap();
        let made = list.make_all(place.path(), None, &Styles::standard()).unwrap();
        assert!(made.failed.is_empty(), "{:?}", made.failed);
        texts_of(&String::from_utf8(read(&place.path().join(format!("study/made-up/figures/{id}.svg")))).unwrap())
    };
    let kind = |kind: &str| LEAST_SWEEP.replace("\"sweep\"", &format!("\"{kind}\""));
    let dots = drawn(&format!("{}{POOLED_PANEL}", kind("dots")), "mine");
    for wanted in ["rim-nonsmooth-gap, profile", "H = 1 ms", "H = 5 ms", "diverged", "some runs diverged"] {
        assert!(dots.contains_key(wanted), "{wanted}: {dots:?}");
    }
    let panel = "[[figure.panels]]\nmetric = \"residual_j\"\nonly = { set = \"all\" }\nsymlog = [1e-4, 1.0]\n";
    let signed = drawn(&format!("{LEAST_SWEEP}{panel}"), "mine");
    assert!(["−10⁰", "0", "10⁰"].iter().all(|tick| signed.contains_key(*tick)), "{signed:?}");
    let at = format!("{}at = [1, 2]\n[[figure.panels]]\ncost = \"wall_s\"\n", kind("performance-profile"));
    // Durations are part of a problem.
    let runs = place.path().join("study/made-up/runs.csv");
    let rows = std::fs::read_to_string(&runs).unwrap();
    let longer = |(k, row): (usize, &str)| format!("{row}{}\n", if k == 0 { ",duration_s" } else { ",1.0" });
    std::fs::write(&runs, rows.lines().enumerate().map(longer).collect::<String>()).unwrap();
    seal(&place.path().join("study/made-up"));
    let profile = drawn(&at, "mine");
    assert!(profile.contains_key("is the best (τ = 1)") && profile.contains_key("within τ = 2"), "{profile:?}");
    // A run that broke off has no value, and that is said.
    let one = |row: &str| row.starts_with("run_id") || row.contains(",0.005,");
    let rows = std::fs::read_to_string(&runs).unwrap();
    std::fs::write(&runs, rows.lines().filter(|row| one(row)).map(|row| format!("{row}\n")).collect::<String>())
        .unwrap();
    seal(&place.path().join("study/made-up"));
    let phases = drawn(&format!("{}only = {{ set = \"all\" }}\n{LEAST_PANEL}", kind("phases")), "mine");
    assert!(phases.contains_key("diverged") && phases.contains_key("all runs diverged"), "{phases:?}");
}

/// Every figure of the list: in the legend no two rows have the same line and sign.
#[test]
#[ignore = "needs the rows of all experiments, which `rimbench reproduce --everything` makes; part of .ci/all"]
fn no_two_rows_of_a_shipped_figure_look_the_same() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let list = FigureList::read(&root.join("paper/figures.toml")).unwrap();
    let mut compared = 0;
    for figure in list.figures.iter().filter(|figure| figure.experiment != "study/wedge_box") {
        let drawing = figure.drawn(&root.join("results"), &Styles::standard()).unwrap();
        let (mut groups, mut open): (Vec<(String, Vec<&Shape>)>, bool) = (Vec::new(), false);
        for shape in &drawing.shapes {
            match shape {
                Shape::Open(name) => {
                    groups.push((name.clone(), Vec::new()));
                    open = true;
                }
                Shape::Close => open = false,
                shape if open => groups.last_mut().unwrap().1.push(shape),
                _ => {}
            }
        }
        // An entry of the legend begins with a level line of 27 px; its shapes are compared wherever it stands.
        let mut looks: BTreeMap<String, String> = BTreeMap::new();
        for (name, shapes) in groups {
            let Some(Shape::Path { points, closed: false, .. }) = shapes.first() else { continue };
            let [from, to] = points[..] else { continue };
            if from.1 != to.1 || (to.0 - from.0 - 27.0).abs() > 1e-9 {
                continue;
            }
            let at = |point: (f64, f64)| format!("{:.3} {:.3}", point.0 - from.0, point.1 - from.1);
            let look: String = shapes
                .iter()
                .map(|shape| match shape {
                    Shape::Path { points, closed, fill, stroke } => {
                        let points: Vec<String> = points.iter().map(|&point| at(point)).collect();
                        format!("{points:?} {closed} {fill:?} {stroke:?};")
                    }
                    Shape::Disc { centre, radius, fill, stroke } => {
                        format!("{} {radius} {fill:?} {stroke:?};", at(*centre))
                    }
                    _ => String::new(),
                })
                .collect();
            compared += 1;
            let other = looks.insert(look, name.clone());
            assert!(other.as_ref().is_none_or(|other| *other == name), "{}: {name} and {other:?}", figure.id);
        }
    }
    assert!(compared > 100, "{compared}");
}
