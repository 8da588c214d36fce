//! Walks through the code, measured: how many files a value passes; and what fails in the numerics is not swallowed on its way.

use crate::support::sources;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Text of the code by file, comments and tests aside.
type Code = BTreeMap<String, String>;

fn code() -> Code {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let all = sources(&root.join("crates")).into_iter().chain(sources(&root.join("src")));
    let named = all.map(|(path, text)| {
        let lines: Vec<&str> = text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
        (path.strip_prefix(root).unwrap().to_string_lossy().replace("crates/rimbench-", ""), lines.join("\n"))
    });
    named.filter(|(path, _)| !path.contains("/tests/") && !path.ends_with("tests.rs")).collect()
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The functions of a file: name, and all behind it to its end.
fn functions(text: &str) -> Vec<(&str, &str)> {
    let function = |at: usize| {
        let rest = &text[at + "fn ".len()..];
        let name = rest.split(|c: char| !is_word(c)).next().filter(|name| !name.is_empty())?;
        let line = text[..at].rfind('\n').map_or(0, |end| end + 1);
        let indent = text[line..].len() - text[line..].trim_start().len();
        let (first, declared) = (rest.find('\n').unwrap_or(rest.len()), rest.find(";\n").unwrap_or(rest.len()));
        let end = match rest.find('{') {
            Some(open) if open < declared && rest[..first].ends_with('}') => first,
            Some(open) if open < declared => rest.find(&format!("\n{}}}", " ".repeat(indent))).unwrap_or(rest.len()),
            _ => declared,
        };
        Some((name, &rest[name.len()..end]))
    };
    let heads = text.match_indices("fn ").filter(|(at, _)| text[..*at].ends_with([' ', '\n']));
    heads.filter_map(|(at, _)| function(at)).collect()
}

/// Where a function is called, as `name(` or with what stands before it.
fn calls<'a>(code: &'a str, call: &str) -> impl Iterator<Item = usize> + 'a {
    let found: Vec<usize> = code.match_indices(&format!("{call}(")).map(|(at, _)| at).collect();
    found.into_iter().filter(|&at| !code[..at].ends_with(is_word) && !code[..at].ends_with("fn "))
}

/// What passes how many files at most, and its stays: file, function, and how it is joined to an earlier stay: that calls it, it calls that
/// (`calls`), or both hold a field (`.field`). A function stands as it is called, with its type or what holds it where its name alone says
/// little. One in a file that has been passed needs no joint.
const WALKS: [(&str, usize, &str); 3] = [
    (
        "a macro step, from what is typed to the loop that lays it",
        9,
        "src/cli/simulate.rs run
         src/cli/run_options.rs request
         src/cli/run_options.rs seconds
         cases/src/runs/request.rs put
         cases/src/runs/spec.rs resolve
         cases/src/runs/spec.rs grid
         core/src/cosim/communication_grid.rs CommunicationGrid::new
         cases/src/runs/simulation.rs simulate_inside
         cases/src/runs/simulation.rs run
         core/src/schemes/coupling.rs coupling.run
         core/src/cosim/macro_loop.rs cosimulate
         core/src/cosim/macro_loop.rs macro_steps
         core/src/cosim/step_size_control.rs StepSizeControl::new",
    ),
    (
        "an impulse, from the solver that finds it to the trace that holds its force",
        9,
        "contact/src/complementarity/checked.rs solve
         core/src/mechanics/contact_stepper/step_contacts.rs solve calls
         core/src/mechanics/contact_stepper.rs solve_contacts calls
         core/src/mechanics/contact_stepper/observables.rs observe .impulses
         core/src/mechanics/non_smooth_mechanics.rs observe calls
         core/src/cosim/capabilities.rs observe
         cases/src/cases/recorder.rs record calls
         core/src/cosim/trajectory.rs push_row
         core/src/cosim/trajectory.rs rows
         results/src/trace.rs write_trace calls",
    ),
    (
        "a figure, from its TOML to SVG",
        10,
        "figures/src/figures/mod.rs checked
         figures/src/figures/check.rs check::check
         figures/src/figures/keys.rs keys_of
         figures/src/figures/mod.rs make
         figures/src/figures/mod.rs draw
         figures/src/figures/xy_figure.rs figure.draw
         figures/src/figures/xy_figure.rs medians
         figures/src/figures/xy_figure.rs with_range
         figures/src/figures/statistics.rs over_phases
         figures/src/chart.rs Series::new
         figures/src/figure.rs draw_if_it_fits
         figures/src/figure.rs draw
         figures/src/data.rs data::draw
         figures/src/data.rs draw_inside
         figures/src/drawing.rs drawing.line
         figures/src/vector.rs vector::write",
    ),
];

fn stays(walk: &str) -> impl Iterator<Item = Vec<&str>> {
    walk.lines().map(|stay| stay.trim().split(' ').collect())
}

/// The name of a function as it is called.
fn name(call: &str) -> &str {
    call.rsplit(['.', ':']).next().unwrap_or_default()
}

/// How many files a walk passes; or a stay that is not there, or not joined to what comes before it.
fn walked(code: &Code, walk: &str) -> Result<usize, String> {
    let (mut passed, mut files) = (Vec::<(&str, Vec<&str>)>::new(), BTreeSet::new());
    for stay in stays(walk) {
        let (file, call) = (stay[0], stay[1]);
        let all = code.get(file).map_or(Vec::new(), |text| functions(text));
        let own: Vec<&str> = all.into_iter().filter(|(found, _)| *found == name(call)).map(|(_, body)| body).collect();
        let joined = |(earlier, bodies): &(&str, Vec<&str>)| match stay.get(2) {
            None => bodies.iter().any(|body| calls(body, call).next().is_some()),
            Some(&"calls") => own.iter().any(|body| calls(body, earlier).next().is_some()),
            Some(field) => [&own, bodies].iter().all(|bodies| bodies.iter().any(|body| body.contains(field))),
        };
        let known = files.is_empty() || files.contains(file) || passed.iter().any(joined);
        if own.is_empty() || !known {
            return Err(stay.join(" "));
        }
        files.insert(file);
        passed.push((call, own));
    }
    Ok(files.len())
}

#[test]
fn a_macro_step_and_an_impulse_pass_nine_files_and_a_figure_ten() {
    let code = code();
    for (what, most, walk) in WALKS {
        let files = walked(&code, walk).unwrap_or_else(|stay| panic!("{what}: {stay} is not there or not joined"));
        assert!(files <= most, "{what} passes {files} files, at most {most}");
        // A layer between two files is a joint that is lost.
        let once = |own: &Vec<&str>| stays(walk).filter(|stay| stay[0] == own[0]).count() == 1;
        for stay in stays(walk).skip(1).filter(once).filter(|stay| stay.len() == 2) {
            let between = |text: &String| text.replace(&format!("{}(", stay[1]), "layer(");
            let changed = code.iter().map(|(file, text)| (file.clone(), between(text))).collect();
            assert!(walked(&changed, walk).is_err(), "{what}: a layer before {} is not seen", stay[1]);
        }
    }
}

/// Functions of few lines that have the name of a stay and call one of it: sides that stand for others, and solvers with a solver inside.
/// One more would be a layer that a walk does not count.
const OTHERS: &str =
    "coulomb.rs:solve dense.rs:solve model_contacts.rs:rows pressure_coupling.rs:observe solvers.rs:solve";

#[test]
fn no_function_that_is_walked_is_forwarded_by_one_of_its_name() {
    let all: BTreeSet<(&str, &str)> =
        WALKS.iter().flat_map(|(_, _, walk)| stays(walk)).map(|stay| (stay[0], name(stay[1]))).collect();
    let (code, mut found) = (code(), BTreeSet::new());
    for (file, text) in &code {
        for (own, body) in functions(text).into_iter().filter(|(own, body)| *own != "new" && body.lines().count() <= 4)
        {
            let is_other = all.iter().any(|(_, name)| *name == own) && !all.contains(&(file, own));
            if is_other && calls(body, own).next().is_some() {
                found.insert(format!("{}:{own}", file.rsplit('/').next().unwrap_or_default()));
            }
        }
    }
    assert_eq!(found, OTHERS.split_whitespace().map(str::to_owned).collect());
}

/// Where what fails in the numerics becomes a value: another way to solve a problem; no number in a row, whose next step fails; doubts of
/// sides, which are left to the runs.
const TAKEN: [(&str, &str); 5] = [
    ("contact/src/complementarity/sparse_active_set.rs", "pivot"),
    ("core/src/mechanics/contact_stepper/observables.rs", "reduce_for_model"),
    ("cases/src/cases/opening.rs", "try_sides"),
    ("cases/src/cases/opening.rs", "try_steps"),
    ("cases/src/cases/opening.rs", "step"),
];

/// Functions of the numerics, whose failures end a run, by name; but for names that others have as well.
fn fallible(code: &Code) -> BTreeSet<&str> {
    const OF_OTHERS: [&str; 8] = ["attempt", "check", "copied", "find", "new", "of", "read", "try_clone"];
    let numerics =
        code.iter().filter(|(file, _)| ["contact/", "core/", "cases/"].iter().any(|part| file.starts_with(part)));
    let all = numerics.flat_map(|(file, text)| {
        functions(text).into_iter().filter(move |(_, code)| {
            let head = code.split('{').next().unwrap_or_default();
            let returned = head.rsplit_once("->").map_or("", |(_, returned)| returned);
            let fails = ["Failure>", "Unsolved>"].iter().any(|error| returned.contains(error));
            fails || file.ends_with("predicted_growth.rs") && returned.contains("Result<")
        })
    });
    all.map(|(name, _)| name).filter(|name| !OF_OTHERS.contains(name)).collect()
}

/// Whether a call is followed by what makes a failure a value, or stands where it is dropped.
fn swallows(text: &str, at: usize) -> bool {
    const AFTER: [&str; 6] = [".ok()", ".unwrap_or", ".is_ok", ".is_err()", ".map_or", ".or("];
    let mut depth = 0;
    let end = text[at..].find(|c: char| {
        depth += i32::from("([{".contains(c)) - i32::from(")]}".contains(c));
        depth == 0 && c == ')'
    });
    let after = text[at + end.map_or(0, |end| end + 1)..].trim_start();
    let before = &text[text[..at].rfind([';', '{', '}']).map_or(0, |end| end + 1)..at];
    let dropped = ["let _ =", "let Ok(", "drop("].iter().any(|word| before.contains(word));
    dropped || AFTER.iter().any(|word| after.starts_with(word))
}

#[test]
fn what_fails_in_the_numerics_is_made_a_value_at_five_places_only() {
    let code = code();
    let (fallible, mut taken) = (fallible(&code), BTreeSet::new());
    for (file, text) in code.iter().filter(|(file, _)| !file.starts_with("fmi/") && !file.starts_with("python/")) {
        for name in &fallible {
            taken.extend(calls(text, name).filter(|&at| swallows(text, at)).map(|_| (file.as_str(), *name)));
        }
    }
    assert_eq!(taken, TAKEN.into(), "hand a failure on");
    assert!(fallible.len() > 60, "only {} functions", fallible.len());
    for (bad, text) in [
        (true, "linearise(spec).ok()??"),
        (true, "let _ = linearise((1, 2));"),
        (true, "linearise(a)\n    .unwrap_or_default()"),
        (true, "if let Ok(x) = linearise(a) {"),
        (false, "linearise(spec)?.ok()"),
        (false, "let x = linearise(a).map_err(f)?; let y = z.ok();"),
    ] {
        assert_eq!(calls(text, "linearise").any(|at| swallows(text, at)), bad, "{text}");
    }
}
