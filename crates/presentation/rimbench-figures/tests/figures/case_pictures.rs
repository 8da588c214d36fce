//! Pictures of cases and schemes: those of the pages, and the moving one of the readme.

use crate::{files, page_of, root};
use rimbench_cases::cases::Case;
use rimbench_core::cosim::{Bounds, Outcome, StopFlag, Trajectory};
use rimbench_figures::case_picture::{Motion, picture};
use rimbench_figures::film::{Take, film};
use rimbench_figures::render::svg;
use rimbench_figures::scheme_picture::timeline;
use rimbench_figures::style::Styles;
use rimbench_runs::catalogue::Catalogue;
use rimbench_runs::{Reference, RunRequest, simulate};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// What a case looks like at the start, by a run of one macro step.
fn case_picture(catalogue: &Catalogue, case: &Case) -> String {
    let drawing = (case.drawing)(&case.default_parameters()).expect("a drawing");
    let macro_step_s = case.defaults.macro_step_s;
    let request =
        RunRequest { duration_s: Some(macro_step_s), ..RunRequest::of(case.name.to_string(), "zero-order-hold") };
    let spec = request.resolve(catalogue).unwrap().with_drawn_coordinates();
    let run = simulate(&spec, Bounds::default(), None, StopFlag::never()).unwrap().trajectory;
    let value =
        |column: &str| run.columns().iter().position(|name| name == column).map_or(f64::NAN, |at| run.data()[at]);
    svg(&picture(case, &drawing, &value))
}

/// `RIMBENCH_FILL_PAGES=1` writes them.
#[test]
fn every_page_of_a_case_or_a_scheme_shows_its_picture_and_each_picture_is_shown() {
    let (catalogue, write) = (Catalogue::standard(), std::env::var_os("RIMBENCH_FILL_PAGES").is_some());
    type Make<'a> = Box<dyn Fn() -> String + 'a>;
    let cases = catalogue.cases().iter().map(|case| {
        let make: Make = Box::new(|| case_picture(&catalogue, case));
        ("cases", &case.name, make)
    });
    let timelines = catalogue.schemes().iter().map(|scheme| {
        let make: Make = Box::new(|| svg(&timeline(scheme).unwrap()));
        ("schemes", &scheme.name, make)
    });
    let (mut faults, mut shown) = (Vec::new(), BTreeSet::new());
    for (folder, name, make) in cases.chain(timelines) {
        let Some(page) = page_of(folder, name) else { continue };
        let made = make();
        assert!(!made.contains("NaN"), "{name}");
        let path = root().join(format!("docs/{folder}/pictures/{name}.svg"));
        if write {
            std::fs::write(&path, &made).unwrap();
        }
        if std::fs::read_to_string(&path).ok().as_ref() != Some(&made) {
            faults.push(format!("{} is not what the code says of it", path.display()));
        }
        // A case can be tried where it is shown.
        let live =
            if folder == "cases" { format!("](../../results/paper/report.html#case={name})") } else { String::new() };
        if !std::fs::read_to_string(&page).unwrap().contains(&format!("](pictures/{name}.svg){live}")) {
            faults.push(format!("{} does not show {name}, or does not link to it", page.display()));
        }
        shown.insert(path);
    }
    let kept = ["cases", "schemes"].map(|folder| files(&root().join("docs").join(folder).join("pictures"), "svg"));
    let moving = |path: &&PathBuf| path.parent().is_some_and(|folder| folder.ends_with("moving"));
    let strangers = kept.iter().flatten().filter(|path| !shown.contains(*path) && !moving(path));
    faults.extend(strangers.map(|path| format!("{} is the picture of nothing", path.display())));
    assert!(faults.is_empty(), "RIMBENCH_FILL_PAGES=1 makes them: {faults:#?}");
    let glossary = std::fs::read_to_string(root().join("docs/glossary.md")).unwrap();
    assert!(glossary.contains("](schemes/pictures/"), "the glossary shows no timeline");
}

/// The wedge box touches down with a hold, the smooth and the non-smooth model; `RIMBENCH_FILL_PAGES=1` writes it.
#[test]
fn the_moving_picture_of_the_readme_is_what_the_code_draws_and_small() {
    const ENLARGED: f64 = 10.0;
    let (catalogue, styles) = (Catalogue::standard(), Styles::standard());
    let spec = |scheme: &str, margin: &str| {
        let mut request = RunRequest::of("wedge-box", scheme);
        request.put("macro_step_s", "0.005").unwrap();
        if !margin.is_empty() {
            request.put("contact_detection", margin).unwrap();
        }
        request.resolve(&catalogue).unwrap()
    };
    let column = |of: &Trajectory, name: &str| {
        let at = of.index_of(name).unwrap();
        Ok(of.rows().map(|row| row[at]).collect::<Vec<f64>>())
    };
    let of_all = spec("rim-nonsmooth", "");
    let of = (of_all.case.drawing)(&of_all.parameters).unwrap();
    let reference = Reference::compute(&of_all, StopFlag::never()).unwrap();
    let take = |scheme: &str, margin: &str, more: &str| {
        let spec = spec(scheme, margin);
        let run = simulate(&spec, reference.bounds(&spec).unwrap(), None, StopFlag::never()).unwrap();
        let outcome = &run.report.outcome;
        let failed = if let Outcome::Diverged { at_s, .. } = outcome { Some(*at_s) } else { None };
        Take {
            name: format!("{}{more}", styles.shown_name(scheme)),
            color: styles.of_label(scheme).color,
            motion: Motion::of(&of, column, [&run.trajectory, &reference.trajectory], ENLARGED).unwrap(),
            failed: failed.map(|at| (at, format!("{} at {at:.3} s", outcome.name()))),
        }
    };
    let takes = [
        take("zero-order-hold", "", ""),
        take("rim-smooth", "margin:1e-3", ", margin 1 mm"),
        take("rim-nonsmooth", "", ""),
    ];
    let failed: Vec<bool> = takes.iter().map(|take| take.failed.is_some()).collect();
    assert_eq!(failed, [true, true, false]);
    let still = Motion::of(&of, column, [&reference.trajectory; 2], 1.0).unwrap();
    let [begin, fall, land] = [(0, 8, 20), (30, 6, 20), (162, 20, 1)]
        .map(|(from, count, by)| (0..count).map(move |k| 0.01 * f64::from(from + by * k)));
    let instants: Vec<f64> = begin.map(|t| 0.1 * t).chain(fall).chain(land).collect();
    let words = "The macro step is 5 ms. Thin outline: the reference; differences from it are drawn 10 times larger.";
    let made =
        film((&of, &still), &takes, (&instants, instants.len() - 7), ["A box is pushed off a ledge and lands", words]);
    let path = root().join("docs/cases/pictures/moving/wedge-box.svg");
    if std::env::var_os("RIMBENCH_FILL_PAGES").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, &made).unwrap();
    }
    assert!(!made.contains("NaN") && made.len() < 150_000, "{} bytes", made.len());
    assert!(std::fs::read_to_string(&path).ok() == Some(made), "RIMBENCH_FILL_PAGES=1 makes it");
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    assert!(readme.contains("](docs/cases/pictures/moving/wedge-box.svg)"));
}
