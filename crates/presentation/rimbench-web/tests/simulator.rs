//! The simulator of the page: the program's digits, in words and numbers.

use rimbench_cases::cases::{coordinate_column, offered_steps_ms};
use rimbench_core::cosim::{Bounds, StopFlag};
use rimbench_runs::catalogue::Catalogue;
use rimbench_runs::metrics::USABLE;
use rimbench_runs::{Reference, RunRequest, believed, evaluate, simulate, simulate_inside, what_happens};
use rimbench_web::{Answer, Simulator};

const RUN: &str = "run\ncase wedge-box\nscheme rim-nonsmooth-gap\nmacro_step_s 5e-3\nmechanics_step_s 1e-3\nphase 0.5\nset.box_mass_kg 180\n";

fn value<'a>(answer: &'a Answer, key: &str) -> &'a str {
    let line = answer.words.lines().find(|line| line.split(' ').next() == Some(key));
    line.and_then(|line| line.split_once(' ')).map_or("", |(_, value)| value)
}

#[test]
fn a_run_is_that_of_the_program_to_the_bit() {
    let mut simulator = Simulator::default();
    let answer = simulator.answer(RUN);
    assert_eq!(value(&answer, "outcome"), "completed", "{}", answer.words);
    let request = RunRequest {
        macro_step_s: Some(5e-3),
        mechanics_step_s: Some(1e-3),
        phase: Some(0.5),
        set: vec![("box_mass_kg".to_owned(), "180".to_owned())],
        ..RunRequest::of("wedge-box", "rim-nonsmooth-gap")
    };
    let spec = request.resolve(&Catalogue::standard()).unwrap();
    assert_eq!(value(&answer, "run_id"), spec.id());
    let result = simulate_inside(&spec, Bounds::default(), None, StopFlag::never()).unwrap();
    assert_eq!(answer.numbers, result.trajectory.data());
    assert_eq!(value(&answer, "columns").split(' ').count(), result.trajectory.columns().len());
    assert_eq!(value(&answer, "without_peak"), "");
}

#[test]
fn a_belief_stands_below_what_happens_in_a_step_that_was_asked_for_and_in_a_shorter_one() {
    let (mut simulator, catalogue) = (Simulator::default(), Catalogue::standard());
    for step in [10e-3, 4e-3] {
        let answer = simulator
            .answer(&format!("believe 0.3\ncase wedge-box-reversal\nscheme rim-nonsmooth\nmacro_step_s {step}\n"));
        let request = RunRequest::of("wedge-box-reversal", "rim-nonsmooth").at_macro_step(step);
        let spec = request.resolve(&catalogue).unwrap().with_drawn_coordinates();
        let from = what_happens(&spec, &catalogue, 0.3, StopFlag::never()).unwrap();
        let (happens, belief) = answer.numbers.split_at(answer.numbers.len() / 2);
        let bits = |numbers: &[f64]| numbers.iter().map(|value| value.to_bits()).collect::<Vec<u64>>();
        assert_eq!(bits(belief), bits(believed(&spec, &from).unwrap().data()), "{step}");
        let near = |(own, right): (&f64, &f64)| own == right || (own - right).abs() <= 1e-9 * right.abs().max(1.0);
        assert!(happens.iter().zip(from.happens.data()).all(near) && happens.len() == belief.len(), "{step}");
    }
    let refused = simulator.answer("believe soon\ncase wedge-box-reversal\n").words;
    assert!(refused.contains("believe SECONDS"), "{refused}");
}

/// Machines whose errors were off by up to 22 times when the page's reference was four times as coarse as the program's
/// and of unknown uncertainty; and one of which the program does not know the force to a tenth.
#[test]
fn an_error_in_the_page_is_that_of_the_program_to_a_tenth() {
    let mut simulator = Simulator::default();
    for (case, scheme, step) in [
        ("wedge-box", "rim-nonsmooth-gap", "5e-3"),
        ("packed-box", "rim-nonsmooth", "6e-3"),
        ("rocking-block", "zero-order-hold", "1e-3"),
        ("slider-crank", "rim-nonsmooth", "0.6e-3"),
        ("random-body", "zero-order-hold", "2.5e-3"),
    ] {
        let request = RunRequest { macro_step_s: Some(step.parse().unwrap()), ..RunRequest::of(case, scheme) };
        let spec = request.resolve(&Catalogue::standard()).unwrap();
        let answer = simulator.answer(&format!("run\ncase {case}\nscheme {scheme}\nmacro_step_s {step}\n"));
        let reference = Reference::compute(&spec, StopFlag::never()).unwrap();
        let result = simulate(&spec, reference.bounds(&spec).unwrap(), None, StopFlag::never()).unwrap();
        let of_program = evaluate(&spec, result, &reference).unwrap();
        assert_eq!(value(&answer, "outcome"), of_program.outcome.name(), "{case}");
        assert_eq!(value(&answer, "without_peak"), reference.without_peak(&spec.case).unwrap_or(""), "{case}");
        for key in ["force_error_rms_of_peak", "touch_down_peak_ratio"] {
            let (own, right) = (value(&answer, key).parse().ok(), of_program.found.metric(key));
            let near = |own: f64, right: f64| (own - right).abs() <= 0.1 * right;
            let same = own.is_some() == right.is_some() && own.zip(right).is_none_or(|(own, right)| near(own, right));
            assert!(same, "{case}: {key} {own:?} in the page, {right:?} in the program");
        }
        let known: f64 = value(&answer, "reference_force_uncertainty_n").parse().unwrap();
        let program = of_program.found.reference_uncertainty[0].unwrap();
        let error = of_program.found.metric("force_error_rms_n").unwrap();
        assert!(known <= (0.11 * error).max(program), "{case}: known to {known} N, an error of {error} N");
    }
}

#[test]
fn a_reference_serves_all_runs_of_its_parameters_and_no_others() {
    let mut simulator = Simulator::default();
    let mut reference = |of: &str| simulator.answer(&of.replacen("run", "reference", 1)).numbers;
    let first = reference(RUN);
    assert!(first == reference(&RUN.replace("5e-3", "2e-3").replace("rim-nonsmooth-gap", "zero-order-hold")));
    assert!(first != reference(&RUN.replace("180", "220")));
}

#[test]
fn nonsense_is_one_error_that_says_what_would_be_valid() {
    let mut simulator = Simulator::default();
    for (request, named) in [
        ("dance", "reference"),
        ("", "run"),
        ("run\ncase wedge-bx\nscheme zero-order-hold", "wedge-box"),
        ("run\ncase wedge-box\nscheme zero-order-hold\nmacro_step_s much", "a number"),
        ("run\ncase wedge-box\nscheme zero-order-hold\nmacro_step_s -1", "macro_step_s"),
        ("run\ncase wedge-box\nscheme zero-order-hold\nset.box_mass_kg -3", "box_mass_kg"),
    ] {
        let answer = simulator.answer(request);
        assert!(answer.words.starts_with("error ") && answer.words.lines().count() == 1, "{}", answer.words);
        assert!(answer.words.contains(named), "{request}: {}", answer.words);
        assert!(answer.numbers.is_empty());
    }
}

#[test]
fn cases_are_listed_in_json_with_the_schemes_they_are_not_run_with() {
    let words = Simulator::default().answer("cases").words;
    let cases: serde_json::Value = serde_json::from_str(&words).unwrap();
    assert_eq!(cases[0]["name"], "wedge-box");
    assert!(cases[0]["drawing"]["shapes"].as_array().is_some_and(|shapes| shapes.len() > 3));
    assert!(cases.as_array().unwrap().iter().all(|case| case["refused"].is_array()));
}

/// Heaps, rows and chains have no columns for their bodies: the page is given coordinates, of runs and of what they are
/// held against.
#[test]
fn bodies_of_heaps_and_rows_move() {
    let mut simulator = Simulator::default();
    let mut of_bodies = 0;
    for case in Catalogue::standard().cases() {
        let Some(drawing) = (case.drawing)(&case.default_parameters()) else { continue };
        let coordinates = drawing.coordinates();
        if coordinates.is_empty() {
            continue;
        }
        of_bodies += 1;
        let lines = format!("case {}\nscheme rim-nonsmooth\nmacro_step_s 2e-3", case.name);
        for request in [format!("run\n{lines}"), format!("reference\n{lines}")] {
            let answer = simulator.answer(&request);
            let columns: Vec<&str> = value(&answer, "columns").split(' ').collect();
            let rows: Vec<&[f64]> = answer.numbers.chunks_exact(columns.len()).collect();
            let moves = |index: &&usize| {
                let name = coordinate_column(**index);
                let at = columns.iter().position(|column| *column == name);
                let at = at.unwrap_or_else(|| panic!("{}: {name} is not among {columns:?}", case.name));
                rows.iter().any(|row| (row[at] - rows[0][at]).abs() > 1e-6)
            };
            // Discs of a row stay on the floor.
            let moving = coordinates.iter().filter(moves).count();
            assert!(2 * moving >= coordinates.len(), "{}: {moving} of {}", case.name, coordinates.len());
        }
        // What a run is does not depend on who looks.
        let request = RunRequest { macro_step_s: Some(2e-3), ..RunRequest::of(case.name.to_string(), "rim-nonsmooth") };
        let spec = request.resolve(&Catalogue::standard()).unwrap();
        assert_eq!(spec.with_drawn_coordinates().id(), spec.id());
        assert_eq!(value(&simulator.answer(&format!("run\n{lines}")), "run_id"), spec.id());
    }
    assert_eq!(of_bodies, 3);
}

/// Two pictures with one sign show nothing of the schemes.
#[test]
fn a_case_is_first_shown_at_a_step_at_which_its_two_schemes_come_out_differently() {
    let mut simulator = Simulator::default();
    let catalogue = Catalogue::standard();
    // A case without a picture in the book has not been looked at yet.
    let pictures = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../docs/cases/pictures");
    for case in catalogue.cases().iter().filter(|case| pictures.join(format!("{}.svg", case.name)).is_file()) {
        let Some(drawing) = (case.drawing)(&case.default_parameters()) else { continue };
        let shown = case.shown_step_ms;
        assert!(offered_steps_ms(case.defaults.macro_step_s).contains(&shown), "{}: {shown}", case.name);
        let signs = drawing.schemes.map(|scheme| {
            let answer =
                simulator.answer(&format!("run\ncase {}\nscheme {scheme}\nmacro_step_s {shown}e-3", case.name));
            let error: f64 = value(&answer, "force_error_rms_of_peak").parse().unwrap_or(f64::INFINITY);
            match value(&answer, "outcome") {
                "completed" if error <= USABLE => "usable",
                "completed" => "completes",
                "" => panic!("{}: {}", case.name, answer.words),
                _ => "fails",
            }
        });
        assert_ne!(signs[0], signs[1], "{} at {shown} ms with {:?}", case.name, drawing.schemes);
    }
}

#[test]
fn all_schemes_are_listed_with_what_they_are() {
    let answer = Simulator::default().answer("schemes");
    assert!(answer.words.contains("scheme zero-order-hold plain\n"));
    assert!(answer.words.contains("scheme rim-nonsmooth-gap model\n"));
    assert_eq!(answer.words.lines().count(), Catalogue::standard().schemes().len());
}
