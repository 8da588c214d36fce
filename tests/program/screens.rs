//! What commands print at 80 columns, in files that a person can read: `tests/program/screens/*.txt`. A line that
//! begins with `$` is a command, and what follows is what it prints, with its exit code if that is not 0.
//! `RIMBENCH_UPDATE_SCREENS=1` writes them.

use crate::conveniences::{commands, said};
use crate::program::{files, read, rimbench, root};
use crate::reproduction::{Quick, quick};
use std::path::Path;

/// The experiment that the commands find in their folder.
pub const SMALL: &str = include_str!("small.toml");

#[test]
fn commands_print_what_their_files_show() {
    let mut faults = Vec::new();
    for file in files(&root().join("tests/program/screens")) {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("small.toml"), SMALL).unwrap();
        let shown = read(&file);
        let made: Vec<String> =
            shown.lines().filter(|line| line.starts_with("$ ")).map(|line| screen(folder.path(), line)).collect();
        for screen in &made {
            if screen.starts_with("$ rimbench list") && screen.contains('…') {
                faults.push(format!("{}: a list cuts its texts", file.display()));
            }
            faults.extend(too_large(screen).map(|fault| format!("{}: {fault}", file.display())));
        }
        let made = made.join("\n");
        if std::env::var_os("RIMBENCH_UPDATE_SCREENS").is_some() {
            std::fs::write(&file, made).unwrap();
        } else if let Some((number, (wanted, found))) = shown
            .lines()
            .chain([""])
            .zip(made.lines().chain([""]))
            .enumerate()
            .find(|(_, (wanted, found))| wanted != found)
        {
            faults.push(format!("{}:{}:\n  shown   {wanted}\n  printed {found}", file.display(), number + 1));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_help_of_every_command_fits_on_a_screen() {
    for command in commands() {
        assert_eq!(too_wide(said(&[&command, "-h"]).lines()), None, "{command}");
    }
}

/// What has no file here: the same rule at 100 columns, for whatever else can be printed in a moment.
#[test]
fn nothing_that_a_command_prints_is_wider_than_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    for line in [
        "list cases --long",
        "list schemes --long",
        "list solvers --long",
        "list metrics --long",
        "list parameters --case wedge-box --long",
        "list figure-keys",
        "run small.toml --dry-run",
        "run small.toml --out rows",
        "verify small.toml --results rows --all",
        "limit --case wedge-box --scheme zero-order-hold --phases 2",
        "advise --case wedge-box --scheme rim-nonsmooth --duration 0.2 --error 5% --phases 2",
        "simulate --case wedge-box --scheme rim-nonsmooth --all",
        "simulate --case wedge-box --scheme rim-nonsmooth --audit",
        "simulate --case wedge-box --scheme rim-smooth --contact-detection margin:1e-3",
        "simulate --case wedge-box --scheme zero-order-hold --trace a-file-with-a-long-name-in-this-folder.csv",
        "perf compare previous latest --history HISTORY",
    ] {
        let words = line.split(' ').map(|word| match word {
            "HISTORY" => root().join("results/perf/history.csv").display().to_string(),
            _ => word.to_owned(),
        });
        std::fs::write(folder.path().join("small.toml"), SMALL).unwrap();
        let output = rimbench().current_dir(folder.path()).env("COLUMNS", "100").args(words).output().unwrap();
        assert_narrow(line, &String::from_utf8([output.stdout, output.stderr].concat()).unwrap());
    }
    let Quick { printed, progress, .. } = quick();
    assert_narrow("reproduce --quick", &format!("{printed}{progress}"));
}

fn assert_narrow(command: &str, text: &str) {
    let is_wide = |line: &&str| line.chars().count() > 100 && line.trim().contains(' ');
    assert!(text.lines().count() > 1, "{command}: {text}");
    assert_eq!(text.lines().find(is_wide), None, "{command}");
}

/// A command, what it prints, and its exit code.
fn screen(folder: &Path, line: &str) -> String {
    let results = root().join("results").display().to_string();
    let words = line.trim_start_matches("$ rimbench ").split_whitespace();
    let words = words.map(|word| word.replace("RESULTS", &results).trim_matches('\'').to_owned());
    let mut command = rimbench();
    command.current_dir(folder).env_remove("COLUMNS").args(words);
    let output = command.output().unwrap();
    let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    let code = match output.status.code() {
        Some(0) => String::new(),
        code => format!("(exit code {})\n", code.unwrap()),
    };
    // What only a busy machine is told.
    let busy = ["runs were timed on a busy machine", ": at work for "];
    let lines = text.lines().filter(|line| !busy.iter().any(|told| line.contains(told)));
    let printed: String = lines.map(|line| masked(line).trim_end().to_owned() + "\n").collect();
    format!("{line}\n{printed}{code}")
}

/// Times depend on the machine, run ids on the version of the numerics, and whether there are rows on what has run
/// here.
fn masked(line: &str) -> String {
    if let Some((before, _)) = line.split_once(" (").filter(|_| line.ends_with(" from summaries)")) {
        return before.to_owned();
    }
    if line.starts_with("  computing time") {
        return "  computing time    (of this machine)".to_owned();
    }
    if let Some((before, _)) = line.split_once("processor time") {
        return format!("{before}processor time    (of this machine)");
    }
    let is_id = |word: &str| word.len() == 16 && word.bytes().all(|byte| byte.is_ascii_hexdigit());
    // How many metrics, counters, or schemes to advise there are is not what a screen is about.
    if let Some((_, others)) = line.split_once(" runs · ").filter(|_| line.ends_with(" for the others")) {
        return format!("N runs · {others}");
    }
    let mut words: Vec<&str> =
        line.split(' ').map(|word| if is_id(word) { "0123456789abcdef" } else { word }).collect();
    for index in 1..words.len() {
        if ["metrics", "counters"].contains(&words[index]) && words[index - 1].parse::<usize>().is_ok() {
            words[index - 1] = "N";
        }
    }
    words.join(" ")
}

/// The first line that is too wide; an error is one line, however long, and a word that is longer has a line of its
/// own.
fn too_wide<'a>(mut lines: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let is_free = |line: &str| line.starts_with("error: ") || line.starts_with("help: ") || !line.trim().contains(' ');
    lines.find(|line| line.chars().count() > 80 && !is_free(line))
}

/// What is too wide; read by a program, a line of a list is whole.
fn too_large(screen: &str) -> Option<String> {
    let (command, printed) = screen.split_once('\n')?;
    let wide = too_wide(printed.lines()).filter(|_| !command.starts_with("$ rimbench list "));
    wide.map(|wide| format!("wider than 80: {wide}"))
}
