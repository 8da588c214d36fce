//! The program works from any folder: it reads nothing from the folder it was built in, and writes only below the current one or
//! where it is told to.

use crate::program::rimbench;
use assert_cmd::Command;
use rimbench::perf::History;
use std::collections::BTreeSet;
use std::path::Path;

fn called(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = rimbench();
    command.current_dir(folder).args(arguments);
    command
}

/// Files below a folder.
fn files(folder: &Path) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for path in std::fs::read_dir(next).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else {
                found.insert(path.strip_prefix(folder).unwrap().to_string_lossy().replace('\\', "/"));
            }
        }
    }
    found
}

fn said(output: &std::process::Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[test]
fn the_history_of_another_folder_is_neither_read_nor_drawn() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [&["perf", "plot"] as &[&str], &["perf", "show"], &["perf", "compare", "previous", "latest"]] {
        let output = called(folder.path(), arguments).assert().code(2).get_output().clone();
        assert!(said(&output).contains("results/perf/history.csv"), "{arguments:?}: {}", said(&output));
    }
    assert_eq!(files(folder.path()), BTreeSet::new());
    let record = ["perf", "record", "--benchmark", "kernel/lcp-warm", "--rounds", "0", "--without-instructions"];
    called(folder.path(), &record).assert().success();
    called(folder.path(), &["perf", "plot"]).assert().success();
    let names = ["csv", "png", "svg"].map(|extension| format!("results/perf/history.{extension}"));
    assert_eq!(files(folder.path()), BTreeSet::from(names));
    assert_eq!(History::read(&folder.path().join("results/perf/history.csv")).unwrap().records().len(), 1);
}

#[test]
fn the_corpus_and_the_figures_are_those_that_the_program_carries() {
    let folder = tempfile::tempdir().unwrap();
    let solvers = ["solvers", "--source", "wedge-box rim-nonsmooth", "--solver", "active-set", "--out", "mine"];
    called(folder.path(), &solvers).assert().success();
    let written = files(folder.path());
    assert!(written.iter().all(|file| file.starts_with("mine/")) && written.contains("mine/work.csv"), "{written:?}");
    // Without results there is nothing to draw, which is said of the folder here.
    let output = called(folder.path(), &["report", "--figures"]).assert().code(2).get_output().clone();
    assert!(said(&output).contains("results: is no folder of results"), "{}", said(&output));
    std::fs::create_dir(folder.path().join("results")).unwrap();
    let output = called(folder.path(), &["report", "--figures"]).assert().success().get_output().clone();
    assert!(said(&output).contains("not drawn: fig1: no results in results/paper/fig1"), "{}", said(&output));
    assert_eq!(files(folder.path()), written, "nothing is made for figures without results");
}

#[test]
fn a_list_of_figures_of_ones_own_is_drawn_and_a_picture_that_is_out_of_date_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let results = folder.path().join("results/mine/sweep");
    std::fs::create_dir_all(results.join("figures")).unwrap();
    let runs = "run_id,case,set,label,macro_step_s,phase,outcome,error\n1,box,,rim-smooth,0.001,1.0,completed,0.1\n\
                2,box,,rim-smooth,0.002,1.0,completed,0.2\n";
    std::fs::write(results.join("runs.csv"), runs).unwrap();
    rimbench::checksums::write(&results, ["runs.csv".to_owned()]).unwrap();
    let list = |metric: &str| {
        let text = format!(
            "[[figure]]\nid = \"errors\"\nkind = \"sweep\"\nexperiment = \"mine/sweep\"\n[[figure.panels]]\nmetric = \"{metric}\"\n"
        );
        std::fs::write(folder.path().join("my.toml"), text).unwrap();
        called(folder.path(), &["report", "--figures", "--file", "my.toml"])
    };
    list("error").assert().success();
    assert!(results.join("figures/errors.svg").is_file());
    let output = list("no_such_metric").assert().code(1).get_output().clone();
    let text = said(&output);
    assert!(text.contains("errors cannot be drawn: ") && text.contains("no_such_metric"), "{text}");
    assert!(text.contains("errors.svg is older"), "{text}");
}

/// In the project's folder the files there are what counts, as they may have been edited.
#[test]
fn in_the_projects_folder_its_own_files_are_read() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(folder.path().join("experiments/paper")).unwrap();
    std::fs::create_dir_all(folder.path().join("paper")).unwrap();
    std::fs::write(folder.path().join("paper/figures.toml"), "[[figure]]\n").unwrap();
    let output = called(folder.path(), &["report", "--figures"]).assert().code(2).get_output().clone();
    assert!(said(&output).contains("paper/figures.toml: "), "{}", said(&output));
    let output = called(folder.path(), &["reproduce", "--quick"]).assert().code(2).get_output().clone();
    assert!(said(&output).contains("experiments/paper: holds no experiment"), "{}", said(&output));
}
