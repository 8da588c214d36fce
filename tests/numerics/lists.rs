//! What the catalogue lists: names that stand once, parameters with their ranges, columns that have a source, drawings,
//! limits of memory.

use crate::support::*;
use rimbench::cases::{CoupledSystem, DerivedColumn, InterfaceColumns, Shape};
use rimbench::catalogue::Catalogue;
use rimbench::error::Error;
use rimbench::name::check_new_name;
use rimbench::parameter::Parameter;
use rimbench::solver_entry::SolverEntry;
use std::collections::BTreeSet;

#[test]
fn every_name_stands_once_and_is_found() {
    let catalogue = Catalogue::standard();
    let names: [Vec<&str>; 3] = [
        catalogue.cases().iter().map(|case| &*case.name).collect(),
        catalogue.schemes().iter().map(|scheme| &*scheme.name).collect(),
        catalogue.solvers().iter().map(|solver| &*solver.name).collect(),
    ];
    for list in names {
        for (index, name) in list.iter().enumerate() {
            assert!(check_new_name("entry", name, list[..index].iter().copied()).is_ok(), "{name}");
        }
    }
    let message = catalogue.case("wedge-bax").unwrap_err().to_string();
    assert!(message.contains("did you mean `wedge-box`"), "{message}");
}

#[test]
fn what_is_added_is_found_and_what_cannot_be_is_refused() {
    let mut catalogue = Catalogue::standard();
    let mine = |name: String| SchemeEntry { name: name.into(), ..SchemeEntry::clone(&schemes()[0]) };
    // A name made at run time, as a script would make it.
    catalogue.add_scheme(mine(format!("my-{}", "scheme"))).unwrap();
    assert_eq!(catalogue.scheme("my-scheme").unwrap().name, "my-scheme");
    assert!(catalogue.add_scheme(mine("my-scheme".to_owned())).unwrap_err().to_string().contains("not taken yet"));
    assert!(catalogue.add_scheme(mine("My Scheme".to_owned())).unwrap_err().to_string().contains("kebab-case"));
    let gain = Some(Gain { about: "".into(), default: 2.0, range: [0.0, 1.0] });
    let absurd = SchemeEntry { gain, ..mine("absurd".to_owned()) };
    assert!(catalogue.add_scheme(absurd).unwrap_err().to_string().contains("default gain of absurd"));
    // Another catalogue knows nothing of it.
    assert!(Catalogue::standard().scheme("my-scheme").is_err());
}

#[test]
fn a_parameter_is_declared_once_and_a_study_draws_valid_values() {
    let mut studied = 0;
    for case in cases() {
        let names: BTreeSet<&Name> = case.parameters.iter().map(|parameter| &parameter.name).collect();
        assert_eq!(names.len(), case.parameters.len(), "{}: a parameter stands twice", case.name);
        for Parameter { name, study, only_with, .. } in &case.parameters {
            for [choice, needed] in *only_with {
                case.default_parameters().set(choice, &needed.replace("> 0", "1")).unwrap();
            }
            let Some([least, most]) = study else { continue };
            let mut parameters = case.default_parameters();
            assert!(least < most, "{}: {name}", case.name);
            [least, most].into_iter().for_each(|value| parameters.set(name, &format!("{value:?}")).unwrap());
            studied += 1;
        }
    }
    assert!(studied > 100, "only {studied} sensible ranges");
}

#[test]
fn every_case_of_an_experiment_has_a_drawing_and_all_read_their_columns_and_fix_points_to_frames_of_their_own() {
    for case in cases() {
        let Some(drawing) = (case.drawing)(&case.default_parameters()) else {
            assert!(!is_published(&case.name), "{} is in an experiment and has no drawing", case.name);
            continue;
        };
        assert!(!drawing.columns().is_empty() && drawing.title.iter().all(|text| !text.is_empty()), "{}", case.name);
        let known = |column: &str| case.trace_columns.iter().chain(&case.drawing_columns).any(|name| name == column);
        for column in drawing.columns() {
            assert!(known(column), "{}: {column}", case.name);
        }
        let mut above = Vec::new();
        for frame in &drawing.frames {
            assert!(frame.parent.is_none_or(|parent| above.contains(&parent)), "{}: {}", case.name, frame.name);
            above.push(frame.name);
        }
        let fixed = drawing.shapes.iter().flat_map(Shape::points).filter_map(|point| point.1);
        assert!(fixed.into_iter().all(|frame| above.contains(&frame)), "{}", case.name);
    }
}

fn refused(change: impl FnOnce(&mut Case, &mut CoupledSystem)) -> String {
    let mut case = Case::clone(wedge_box_case());
    let mut system = usual_system(&case);
    change(&mut case, &mut system);
    Recorder::new(&case, &mut system).map(drop).unwrap_err().to_string()
}

#[test]
fn a_column_that_nobody_offers_is_refused_by_name() {
    let message = refused(|case, _| case.trace_columns.push("gap_flour_m".into()));
    assert!(message.contains("column gap_flour_m has no source; there are time_s, "), "{message}");
    let message = refused(|case, _| case.interface_columns = vec![InterfaceColumns::new("x_m", "v_m_s", "f_n")]);
    assert!(message.contains("column x_m is used and not among those recorded"), "{message}");
    let message = refused(|_, system| {
        system.derived.push(DerivedColumn::new("actuator_force_n", ["energy_j"], |row| row[0]));
    });
    assert!(message.contains("column energy_j is used"), "{message}");
}

#[test]
fn a_case_beyond_memory_is_refused_with_what_it_needs_and_the_limit() {
    let (case, parameters) = case_with("disc-row", &[("discs", "2500")]);
    // Every entry is kept: at least the 5002² of one matrix, 0.19 GiB, a score of times.
    let Err(Error::InvalidValue { key, found, expected }) = (case.build)(&parameters, &SolverEntry::lemke()) else {
        panic!("5001 contacts with every entry kept are refused");
    };
    assert_eq!((key.as_str(), found.as_str()), ("disc-row: discs", "2500"));
    assert!(expected.contains("4.0 GiB") && expected.contains("5001 contacts"), "{expected}");
}
