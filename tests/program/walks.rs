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
        (path.strip_prefix(root).unwrap().to_string_lossy().into_owned(), lines.join("\n"))
    });
    named.filter(|(path, _)| !path.contains("/tests/") && !path.ends_with("tests.rs")).collect()
}

/// The functions of a file: name, and all from its head to its end.
fn functions(text: &str) -> Vec<(&str, &str)> {
    let heads = text.match_indices("fn ").filter(|(at, _)| text[..*at].ends_with([' ', '\n']));
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
    heads.filter_map(|(at, _)| function(at)).collect()
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Whether a code calls a function: `name(` that is no longer name, with what stands before it where that is said.
fn calls(code: &str, call: &str) -> bool {
    let called = |at: usize| !code[..at].ends_with(is_word) && !code[..at].ends_with("fn ");
    code.match_indices(&format!("{call}(")).any(|(at, _)| called(at))
}

/// What passes how many files at most, and its stays: file, function, and how it is joined to an earlier stay: that calls it, it calls that
/// (`calls`), or both hold a field (`.field`). A function stands as it is called, with its type or what holds it where the name alone says
/// little. A function of a file that has been passed needs no joint.
const WALKS: [(&str, usize, &str); 3] = [
    (
        "a macro step, from what is typed to the loop that lays it",
        9,
        "src/cli/simulate.rs run
         src/cli/run_options.rs request
         src/cli/run_options.rs seconds
         crates/rimbench-cases/src/runs/request.rs put
         crates/rimbench-cases/src/runs/spec.rs resolve
         crates/rimbench-cases/src/runs/spec.rs resolve_for
         crates/rimbench-cases/src/runs/spec.rs grid
         crates/rimbench-core/src/cosim/communication_grid.rs CommunicationGrid::new
         crates/rimbench-cases/src/runs/simulation.rs simulate_inside
         crates/rimbench-cases/src/runs/simulation.rs run
         crates/rimbench-cases/src/runs/spec.rs setup
         crates/rimbench-core/src/schemes/coupling.rs coupling.run
         crates/rimbench-core/src/cosim/macro_loop.rs cosimulate
         crates/rimbench-core/src/cosim/macro_loop.rs macro_steps
         crates/rimbench-core/src/cosim/step_size_control.rs StepSizeControl::new
         crates/rimbench-core/src/cosim/step_size_control.rs control.after
         crates/rimbench-core/src/cosim/communication_grid.rs grid.step",
    ),
    (
        "an impulse, from the solver that finds it to the trace that holds its force",
        9,
        "crates/rimbench-contact/src/complementarity/checked.rs solve
         crates/rimbench-core/src/mechanics/contact_stepper/step_contacts.rs solve calls
         crates/rimbench-core/src/mechanics/contact_stepper.rs solve_contacts calls
         crates/rimbench-core/src/mechanics/contact_stepper/observables.rs observe .impulses
         crates/rimbench-core/src/mechanics/non_smooth_mechanics.rs observe calls
         crates/rimbench-core/src/cosim/capabilities.rs observe
         crates/rimbench-cases/src/cases/recorder.rs record calls
         crates/rimbench-core/src/cosim/trajectory.rs push_row
         crates/rimbench-core/src/cosim/trajectory.rs rows
         crates/rimbench-results/src/trace.rs write_trace calls",
    ),
    (
        "a figure, from its TOML to SVG",
        10,
        "crates/rimbench-figures/src/figures/mod.rs parse
         crates/rimbench-figures/src/figures/mod.rs checked
         crates/rimbench-figures/src/figures/check.rs check::check
         crates/rimbench-figures/src/figures/keys.rs keys_of
         crates/rimbench-figures/src/figures/mod.rs make
         crates/rimbench-figures/src/figures/mod.rs drawn
         crates/rimbench-figures/src/figures/mod.rs draw
         crates/rimbench-figures/src/figures/xy_figure.rs figure.draw
         crates/rimbench-figures/src/figures/xy_figure.rs medians
         crates/rimbench-figures/src/figures/xy_figure.rs with_range
         crates/rimbench-figures/src/figures/statistics.rs over_phases
         crates/rimbench-figures/src/chart.rs Series::new
         crates/rimbench-figures/src/figure.rs draw_if_it_fits
         crates/rimbench-figures/src/figure.rs drawn
         crates/rimbench-figures/src/figure.rs draw
         crates/rimbench-figures/src/data.rs data::draw
         crates/rimbench-figures/src/data.rs draw_inside
         crates/rimbench-figures/src/drawing.rs drawing.line
         crates/rimbench-figures/src/vector.rs vector::write
         crates/rimbench-figures/src/vector.rs svg",
    ),
];

/// Functions of few lines that have the name of a stay and call one of it: sides that stand for others, and solvers with a solver inside.
/// One more would be a layer that a walk does not count.
const OTHERS: [&str; 9] = [
    "coulomb.rs solve",
    "dense.rs solve",
    "lent_actuator.rs step",
    "model_contacts.rs rows",
    "pressure_coupling.rs observe",
    "pressure_coupling.rs step",
    "published_driver.rs step",
    "solvers.rs solve",
    "subsystem.rs step",
];

/// How many files a walk passes, and what is wrong with it.
fn walked(code: &Code, stays: &str) -> (usize, Vec<String>) {
    let (mut faults, mut bodies, mut files) = (Vec::new(), Vec::new(), BTreeSet::new());
    for stay in stays.lines().map(str::trim) {
        let [file, call, how @ ..] = &stay.split(' ').collect::<Vec<_>>()[..] else { panic!("{stay}") };
        let name = call.rsplit(['.', ':']).next().unwrap_or_default();
        let own = code.get(*file).map_or(Vec::new(), |text| functions(text));
        let own: Vec<&str> = own.into_iter().filter(|(found, _)| *found == name).map(|(_, body)| body).collect();
        let joined = |(earlier, body): &(&str, Vec<&str>)| match how {
            [] => body.iter().any(|body| calls(body, call)),
            ["calls"] => own.iter().any(|own| calls(own, earlier)),
            [field] => [&own, body].iter().all(|bodies| bodies.iter().any(|body| body.contains(field))),
            _ => false,
        };
        if own.is_empty() {
            faults.push(format!("{stay}: there is no such function"));
        } else if !(files.is_empty() || files.contains(file) || bodies.iter().any(joined)) {
            faults.push(format!("{stay}: is not joined to what comes before it"));
        }
        files.insert(*file);
        bodies.push((*call, own));
    }
    (files.len(), faults)
}

#[test]
fn a_macro_step_and_an_impulse_pass_nine_files_and_a_figure_ten() {
    let code = code();
    for (what, most, stays) in WALKS {
        let (files, faults) = walked(&code, stays);
        assert!(faults.is_empty(), "{what}:\n{}", faults.join("\n"));
        assert!(files <= most, "{what} passes {files} files, at most {most}");
        // A layer with another name between two stays, or a stay that is left out, is a joint that is lost.
        let list: Vec<&str> = stays.lines().map(str::trim).collect();
        let alone =
            |at: &usize| list.iter().filter(|stay| stay.split(' ').next() == list[*at].split(' ').next()).count() == 1;
        for at in (1..list.len() - 1).filter(alone) {
            let call = list[at].split(' ').nth(1).unwrap();
            let between = |text: &String| {
                text.replace(&format!("{call}("), &format!("layer_before_{}(", call.replace(['.', ':'], "_")))
            };
            let changed: Code = code.iter().map(|(file, text)| (file.clone(), between(text))).collect();
            assert!(!walked(&changed, stays).1.is_empty(), "{what}: a layer before {call} is not seen");
        }
    }
}

#[test]
fn no_function_that_is_walked_is_forwarded_by_one_of_its_name() {
    let stays = WALKS.iter().flat_map(|(_, _, stays)| stays.lines().map(str::trim));
    let stays: Vec<Vec<&str>> = stays.map(|stay| stay.split(' ').collect()).collect();
    let names: BTreeSet<&str> = stays.iter().filter_map(|stay| stay[1].rsplit(['.', ':']).next()).collect();
    let code = code();
    let mut found = BTreeSet::new();
    for (file, text) in &code {
        for (name, body) in functions(text).into_iter().filter(|(name, _)| *name != "new" && names.contains(name)) {
            let is_stay = stays.iter().any(|stay| stay[0] == file && stay[1].ends_with(name));
            if !is_stay && body.lines().count() <= 4 && calls(body, name) {
                found.insert(format!("{} {name}", file.rsplit('/').next().unwrap_or_default()));
            }
        }
    }
    assert_eq!(found, OTHERS.map(str::to_owned).into());
}

/// Places at which what fails in the numerics is no error, each with what it becomes.
const TAKEN: [(&str, &str, &str); 5] = [
    ("crates/rimbench-contact/src/complementarity/sparse_active_set.rs", "pivot", "another way to solve it"),
    (
        "crates/rimbench-core/src/mechanics/contact_stepper/observables.rs",
        "reduce_for_model",
        "no number; the step that follows fails",
    ),
    ("crates/rimbench-cases/src/cases/opening.rs", "try_sides", "left to the run, which fails with its reason"),
    ("crates/rimbench-cases/src/cases/opening.rs", "try_steps", "the same"),
    ("crates/rimbench-cases/src/cases/opening.rs", "step", "the same"),
];

/// Names that functions elsewhere have as well.
const OF_OTHERS: [&str; 8] = ["attempt", "check", "copied", "find", "new", "of", "read", "try_clone"];

/// Functions of the numerics, whose failures end a run, by name.
fn fallible(code: &Code) -> BTreeSet<&str> {
    let numerics =
        |file: &&String| ["contact", "core", "cases"].iter().any(|name| file.contains(&format!("rimbench-{name}/")));
    let all = code.iter().filter(|(file, _)| numerics(file)).flat_map(|(file, text)| {
        functions(text).into_iter().filter(move |(_, code)| {
            let head = code.split('{').next().unwrap_or_default();
            let returned = head.rsplit_once("->").map_or("", |(_, returned)| returned);
            let fails = ["Failure>", "Unsolved>"].iter().any(|error| returned.contains(error));
            fails || file.ends_with("runs/predicted_growth.rs") && returned.contains("Result<")
        })
    });
    all.map(|(name, _)| name).filter(|name| !OF_OTHERS.contains(name)).collect()
}

/// Where a call of one of these functions is followed by what makes a failure a value, or stands where it is dropped: line and name.
fn swallowed<'a>(text: &str, fallible: &BTreeSet<&'a str>) -> Vec<(usize, &'a str)> {
    const AFTER: [&str; 6] = [".ok()", ".unwrap_or", ".is_ok", ".is_err()", ".map_or", ".or("];
    let mut found = Vec::new();
    for name in fallible {
        for (at, call) in text.match_indices(&format!("{name}(")) {
            if text[..at].ends_with(is_word) || text[..at].ends_with("fn ") {
                continue;
            }
            let mut depth = 1;
            let end = text[at + call.len()..].find(|c: char| {
                depth += i32::from("([{".contains(c)) - i32::from(")]}".contains(c));
                depth == 0
            });
            let after = text[at + call.len() + end.map_or(0, |end| end + 1)..].trim_start();
            let before = &text[text[..at].rfind([';', '{', '}']).map_or(0, |end| end + 1)..at];
            let dropped = ["let _ =", "let Ok(", "drop("].iter().any(|word| before.contains(word));
            if dropped || AFTER.iter().any(|word| after.starts_with(word)) {
                found.push((text[..at].matches('\n').count() + 1, *name));
            }
        }
    }
    found
}

#[test]
fn what_fails_in_the_numerics_is_told_and_made_a_value_at_five_places_only() {
    let code = code();
    let fallible = fallible(&code);
    let (mut faults, mut taken) = (Vec::new(), BTreeSet::new());
    for (file, text) in
        code.iter().filter(|(file, _)| !file.contains("rimbench-fmi/") && !file.contains("rimbench-python/"))
    {
        for (line, name) in swallowed(text, &fallible) {
            match TAKEN.iter().position(|(place, own, _)| place == file && *own == name) {
                Some(place) => drop(taken.insert(place)),
                None => faults.push(format!("{file}:{line}: a failure of `{name}` is made a value: hand it on")),
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(fallible.len() > 60 && taken.len() == TAKEN.len(), "{} functions, {taken:?}", fallible.len());
    let names = BTreeSet::from(["linearise"]);
    for bad in [
        "linearise(spec).ok()??",
        "let _ = linearise((1, 2));",
        "linearise(a)\n    .unwrap_or_default()",
        "if let Ok(x) = linearise(a) {",
    ] {
        assert_eq!(swallowed(bad, &names).len(), 1, "{bad}");
    }
    for good in ["linearise(spec)?.ok()", "let x = linearise(a).map_err(f)?; let y = z.ok();"] {
        assert!(swallowed(good, &names).is_empty(), "{good}");
    }
}
