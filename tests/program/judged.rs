//! Nothing of the book stands unjudged: each scheme and case with a page, and each value of an option that experiments
//! ask for, is in a row that a claim or a figure names.

use crate::documents::{files, page_of};
use crate::program::{read, root};
use rimbench::cases::Purpose;
use rimbench::error::Error;
use rimbench::runs::RunRequest;
use std::collections::BTreeSet;
use toml::{Table, Value};

/// What rows that are named hold: pairs of a key of a row, or `case`, and its value without its number.
type Named = BTreeSet<(String, String)>;

fn tables<'t>(table: &'t Table, key: &str) -> impl Iterator<Item = &'t Table> {
    table.get(key).and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_table)
}

fn texts<'t>(table: &'t Table, key: &str) -> Vec<&'t str> {
    match table.get(key) {
        Some(Value::String(text)) => vec![text],
        Some(Value::Array(list)) => list.iter().filter_map(Value::as_str).collect(),
        _ => Vec::new(),
    }
}

/// `margin:1e-3` is `margin`, `mean:shares` is itself: a number is no name.
fn without_number(text: &str) -> &str {
    match text.split_once(':') {
        Some((name, number)) if number.starts_with(|c: char| c.is_ascii_digit() || c == '<') => name,
        _ => text,
    }
}

/// The names of scheme rows that figures of an experiment have; `None` of one that has all.
fn drawn(figures: &Table, experiment: &str) -> Vec<Option<Vec<String>>> {
    let of_experiment = tables(figures, "figure").filter(|figure| texts(figure, "experiment") == [experiment]);
    of_experiment
        .map(|figure| {
            let mut labels = Vec::new();
            for part in std::iter::once(figure).chain(tables(figure, "panels")) {
                ["labels", "series", "schemes"].iter().for_each(|key| labels.extend(texts(part, key)));
            }
            (!labels.is_empty()).then(|| labels.into_iter().map(str::to_owned).collect())
        })
        .collect()
}

/// All that is in a row that a claim or a figure names, with the cases of experiments that have one.
fn named() -> Named {
    let figures: Table = read(root().join("paper/figures.toml")).parse().unwrap();
    let mut named = Named::new();
    for group in ["paper", "published", "study"] {
        for file in std::fs::read_dir(root().join("experiments").join(group)).unwrap() {
            let path = file.unwrap().path();
            // What stands in folders are cases and sides.
            if path.is_dir() {
                continue;
            }
            let experiment: Table = read(&path).parse().unwrap();
            let drawn = drawn(&figures, &format!("{group}/{}", path.file_stem().unwrap().to_str().unwrap()));
            let mut labels: BTreeSet<&str> = BTreeSet::new();
            for claim in tables(&experiment, "claims") {
                labels.extend(texts(claim, "scheme"));
                labels.extend(texts(claim, "relative_to"));
            }
            if labels.is_empty() && drawn.is_empty() {
                continue;
            }
            for case in tables(&experiment, "cases") {
                named.extend(texts(case, "name").into_iter().map(|name| ("case".to_owned(), name.to_owned())));
            }
            for row in tables(&experiment, "schemes") {
                let label = *texts(row, "label").first().unwrap_or(&texts(row, "scheme")[0]);
                let in_figure = |labels: &Option<Vec<String>>| {
                    labels.as_ref().is_none_or(|labels| labels.iter().any(|drawn| drawn == label))
                };
                if labels.contains(label) || drawn.iter().any(in_figure) {
                    let keys = row.keys().flat_map(|key| texts(row, key).into_iter().map(move |text| (key, text)));
                    named.extend(keys.map(|(key, text)| (key.clone(), without_number(text).to_owned())));
                    // A table has parts by name, of which one may be a name itself.
                    for (key, parts) in row.iter().filter_map(|(key, value)| Some((key, value.as_table()?))) {
                        let part =
                            |(part, value): (&String, &Value)| (key.clone(), value.as_str().unwrap_or(part).to_owned());
                        named.extend(parts.iter().map(part));
                    }
                    // What contacts in space have beside a row that asks for another.
                    let is_asked = |row: &Table| row.contains_key("friction_rows");
                    if !is_asked(row) && tables(&experiment, "schemes").into_iter().any(is_asked) {
                        named.insert(("friction_rows".to_owned(), "cone".to_owned()));
                    }
                    if let Some(delivery) = row.get("delivery").and_then(Value::as_table) {
                        let texts =
                            delivery.iter().filter_map(|(key, value)| Some((key.clone(), value.as_str()?.to_owned())));
                        named.extend(texts);
                        named.extend(delivery.keys().map(|key| (format!("delivery_{key}"), String::new())));
                        // What a model does with late samples if nothing is asked for.
                        let usual = (!delivery.contains_key("late_samples")).then(|| "catch-up".to_owned());
                        named.extend(usual.map(|usual| ("late_samples".to_owned(), usual)));
                    }
                }
            }
        }
    }
    named
}

#[test]
fn each_scheme_case_and_value_of_an_option_is_named_by_a_claim_or_a_figure() {
    let catalogue = rimbench::everything().unwrap();
    let named = named();
    let has = |key: &str, name: &str| named.contains(&(key.to_owned(), name.to_owned()));
    let mut missing: Vec<String> = Vec::new();
    let mut judge = |key: &str, name: &str, elsewhere: bool| {
        if !elsewhere && !has(key, name) {
            missing.push(format!("{key} {name}"));
        }
    };
    // Schemes without a claim in either direction would do as a figure only: the monolithic solution is what others are
    // held against.
    catalogue.schemes().iter().for_each(|scheme| {
        judge("scheme", &scheme.name, &*scheme.name == "monolithic" || page_of("schemes", &scheme.name).is_none());
    });
    // Cases that time solvers are in benches, or on the page of performance.
    let timed = ["benches/scaling.rs", "docs/performance/README.md"].map(|file| read(root().join(file))).concat();
    for case in catalogue.cases() {
        let elsewhere = case.purpose == Purpose::Speed && timed.contains(&*case.name);
        judge("case", &case.name, elsewhere || page_of("cases", &case.name).is_none());
    }
    let solvers = read(root().join("benches/solvers.rs"));
    for solver in catalogue.solvers() {
        judge("solver", &solver.name, solvers.contains(&solver.name.replace('-', "_")));
    }
    // What runs have that ask for nothing is in every row.
    let usual: Vec<_> = catalogue.schemes().iter().map(|scheme| RunRequest::of("wedge-box", &*scheme.name)).collect();
    let id = |request: &RunRequest| request.resolve(&catalogue).ok().map(|run| run.id());
    let asks_for_nothing = |request: &RunRequest, key: &str, value: &str| {
        let mut asked = request.clone();
        asked.put(key, value).is_ok() && id(&asked).is_some_and(|asked| Some(asked) == id(request))
    };
    let experiments: String = files(&root().join("experiments"), "toml").iter().map(read).collect();
    let mut options = 0;
    // These have parts with numbers, and no values by name.
    let parts = ["delivery_up", "delivery_down", "belief", "mass_learning", "perturbation", "trials"];
    assert!(parts[..2].iter().all(|key| has(key, "")) && has("belief", "mass"));
    let others = [&["case", "scheme", "solver"][..], &parts].concat();
    for option in RunRequest::OPTIONS.iter().filter(|option| !others.contains(&option.key)) {
        if !["\n", " ", "{"].iter().any(|before| experiments.contains(&format!("{before}{} =", option.key))) {
            continue;
        }
        let Err(Error::UnknownName { valid, .. }) = RunRequest::default().put(option.key, "no name of a value") else {
            continue;
        };
        options += 1;
        for value in &valid {
            let value = without_number(value);
            let is_usual = usual.iter().any(|request| asks_for_nothing(request, option.key, value));
            judge(option.key, value, is_usual);
        }
    }
    assert!(options >= 7, "{options} options with names");
    assert!(missing.is_empty(), "judged by no claim and drawn in no figure: {missing:#?}");
}
