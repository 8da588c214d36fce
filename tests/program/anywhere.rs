//! The program works from any folder: it reads nothing from the folder it was built in, and writes only below the
//! current one or where it is told to.

use crate::program::{assert_has, below, copy, read, rimbench, root, said};
use assert_cmd::Command;
use rimbench::perf::History;
use rimbench::shipped::{EXPERIMENTS, experiments_of};
use std::collections::BTreeMap;
use std::path::Path;

fn called(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = rimbench();
    command.current_dir(folder).args(arguments);
    command
}

fn files(folder: &Path) -> Vec<String> {
    crate::program::files(folder).iter().map(|path| below(folder, path)).collect()
}

#[test]
fn the_history_of_another_folder_is_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let compared = said(&mut called(folder.path(), &["perf", "compare", "previous", "latest"]), 2);
    assert_has(&compared, &["results/perf/history.csv"]);
    assert_eq!(files(folder.path()), [""; 0]);
    let record = ["perf", "record", "--benchmark", "kernel/friction-warm", "--without-instructions"];
    called(folder.path(), &record).assert().success();
    assert_eq!(files(folder.path()), ["results/perf/history.csv"]);
    assert_eq!(History::read(&folder.path().join("results/perf/history.csv")).unwrap().rows.len(), 1);
}

#[test]
fn the_figures_are_those_that_the_program_carries() {
    let folder = tempfile::tempdir().unwrap();
    // Without results there is nothing to draw, which is said of the folder here.
    let mut report = called(folder.path(), &["report", "--figures"]);
    assert_has(&said(&mut report, 2), &["results: is not a folder of results"]);
    std::fs::create_dir(folder.path().join("results")).unwrap();
    assert_has(&said(&mut report, 2), &["results: holds no results"]);
    assert_eq!(files(folder.path()), [""; 0], "nothing is made for figures without results");
}

#[test]
fn a_study_a_group_and_all_results_draw_what_has_rows_and_count_the_rest() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join("results").join(name);
    // As in a checkout: of two figures of the paper some rows are kept, of others pictures.
    copy(&root().join("results/paper/fig1"), &place("paper/fig1"));
    for name in ["SHA256SUMS", "cost.csv"] {
        std::fs::remove_file(place("paper/fig1").join(name)).unwrap_or_default();
    }
    copy(&root().join("results/study/wedge_box/figures"), &place("study/wedge_box/figures"));
    std::fs::copy(root().join("results/study/wedge_box/digest.toml"), place("study/wedge_box/digest.toml")).unwrap();
    std::fs::create_dir_all(place("study/mine")).unwrap();
    let runs = "run_id,case,set,label,macro_step_s,phase,outcome,force_error_rms_of_peak\n\
                1,box,,rim-smooth,0.001,1.0,completed,0.1\n2,box,,rim-smooth,0.002,1.0,completed,0.2\n";
    std::fs::write(place("study/mine/runs.csv"), runs).unwrap();
    rimbench::checksums::write(&place("study/mine"), ["runs.csv".to_owned()]).unwrap();
    let says = |arguments: &[&str], code: i32| {
        said(&mut called(folder.path(), &[&["report", "--figures"], arguments].concat()), code)
    };
    let all = says(&[], 0);
    assert_has(
        &all,
        &["study-mine-stability.svg", "study-mine-error.svg", "2 figures drawn, ", "of experiments without rows here"],
    );
    assert!(all.lines().count() == 3 && !all.contains("error:"), "{all}");
    for own in
        [&["results/study/mine"][..], &["results/study"], &["--group", "study"], &["results", "--group", "study"]]
    {
        assert_has(&says(own, 0), &["study-mine-stability.svg", "2 figures drawn"]);
    }
    // What is asked for by name and has no rows is said, and is an exit code.
    assert_has(&says(&["results/study/wedge_box"], 1), &["not drawn: ", "run experiments/study/wedge_box.toml"]);
}

#[test]
fn experiments_are_those_that_the_program_carries_where_there_are_none() {
    let folder = tempfile::tempdir().unwrap();
    let results = root().join("results").display().to_string();
    let claims = |text: &str| text.lines().last().unwrap().to_owned();
    let verified = ["verify", "experiments/paper/fig1.toml", "experiments/paper/phases.toml", "--results", &results];
    let elsewhere = said(&mut called(folder.path(), &verified), 0);
    assert_eq!(claims(&elsewhere), claims(&said(&mut called(root(), &verified), 0)));
    let mut for_programs = verified.to_vec();
    for_programs.extend(["--format", "json"]);
    let listed: serde_json::Value = serde_json::from_str(&said(&mut called(folder.path(), &for_programs), 0)).unwrap();
    assert!(listed.as_array().unwrap().iter().all(|claim| claim["id"].is_string() && claim["verdict"].is_string()));
    let planned = said(&mut called(folder.path(), &["run", "experiments/paper/fig1.toml", "--dry-run"]), 0);
    assert_has(&planned, &["wedge-box"]);
    assert_eq!(files(folder.path()), [""; 0]);
}

#[test]
fn a_list_of_figures_of_ones_own_is_drawn_and_a_picture_that_is_out_of_date_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let results = folder.path().join("results/mine/sweep");
    std::fs::create_dir_all(results.join("figures")).unwrap();
    let runs = "run_id,case,set,label,macro_step_s,phase,outcome,penetration_m\n1,box,,rim-smooth,0.001,1.0,completed,0.1\n\
                2,box,,rim-smooth,0.002,1.0,completed,0.2\n";
    std::fs::write(results.join("runs.csv"), runs).unwrap();
    rimbench::checksums::write(&results, ["runs.csv".to_owned()]).unwrap();
    let list = |metric: &str| {
        let text = format!(
            "[[figure]]\nid = \"errors\"\nkind = \"xy\"\nexperiment = \"mine/sweep\"\n[[figure.panels]]\nmetric = \"{metric}\"\n"
        );
        std::fs::write(folder.path().join("my.toml"), text).unwrap();
        called(folder.path(), &["report", "--figures", "--file", "my.toml"])
    };
    list("penetration_m").assert().success();
    assert!(results.join("figures/errors.svg").is_file());
    let text = said(&mut list("energy_growth"), 1);
    assert_has(&text, &["errors cannot be drawn: ", "energy_growth", "errors.svg is older"]);
    assert_has(
        &said(&mut list("no_such_metric"), 2),
        &["my.toml", "panels 1: metric: unknown column `no_such_metric`"],
    );
}

/// In the project's folder the files there are what counts, as they may have been edited.
#[test]
fn in_the_projects_folder_its_own_files_are_read() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(folder.path().join("experiments/paper")).unwrap();
    std::fs::create_dir_all(folder.path().join("paper")).unwrap();
    std::fs::write(folder.path().join("paper/figures.toml"), "[[figure]]\n").unwrap();
    for (arguments, wanted) in [
        (["report", "--figures"], "paper/figures.toml: "),
        (["reproduce", "--quick"], "experiments/paper: holds no experiment"),
    ] {
        assert_has(&said(&mut called(folder.path(), &arguments), 2), &[wanted]);
    }
}

/// What needs tools that not every machine has says which, before anything runs.
#[test]
fn an_experiment_that_needs_what_is_not_here_is_not_made() {
    let folder = tempfile::tempdir().unwrap();
    let write = |path: &str, text: &str| {
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    };
    let grid = "question = \"?\"\nmacro_steps_s = [1e-3]\ncases = [{ name = \"wedge-box\" }]\nschemes = [{ scheme = \"nepce\" }]\n";
    ["paper", "published"].iter().for_each(|group| write(&format!("experiments/{group}/a.toml"), grid));
    write("experiments/study/a.toml", &format!("needs = {{ modules = [\"json\", \"no_such_module\"] }}\n{grid}"));
    write("experiments/study/b.toml", &format!("needs = {{ data = [\"a/b.xml\"] }}\n{grid}"));
    write("paper/figures.toml", "");
    for (name, wanted) in [
        ("study/a", "experiments/study/a.toml: needs the modules of Python json, no_such_module"),
        ("study/b", "experiments/study/b.toml: needs a/b.xml in the folder that RIMBENCH_DATA_OF_OTHERS names"),
    ] {
        assert_has(&said(&mut called(folder.path(), &["reproduce", "--everything", "--only", name]), 2), &[wanted]);
    }
}

#[test]
fn every_experiment_of_the_source_is_carried_with_its_text() {
    let in_a_group = |path: &String| path.ends_with(".toml") && path.matches('/').count() == 1;
    let there = files(&root().join("experiments")).into_iter().filter(in_a_group);
    let there = there.map(|path| (format!("experiments/{path}"), read(root().join("experiments").join(path))));
    let carried = EXPERIMENTS.iter().map(|(path, text)| ((*path).to_owned(), (*text).to_owned()));
    assert!(there.collect::<BTreeMap<_, _>>() == carried.collect());
    assert!(experiments_of("paper").count() >= 4 && experiments_of("nope").count() == 0);
}
