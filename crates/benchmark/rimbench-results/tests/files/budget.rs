//! What budgets buy, from rows of runs.

use rimbench_results::budget::{Budgets, best_within, budget_csv, forms_of, ratio_within};
use rimbench_results::kept::PooledSets;
use rimbench_results::run_table::RunTable;
use rimbench_results::selection::{ALL, Runs};
use std::path::Path;

const HEADER: &str = "case,set,label,macro_step_s,outcome,ended_at_s,macro_steps,mechanics_micro_steps,\
                      force_error_inside_rms_n,force_error_rms_n,force_error_rms_of_peak";

/// Two machines whose forces peak at 100 N; runs of 1 s.
fn table() -> RunTable {
    let mut rows = String::new();
    for (case, times) in [("a", 1.0), ("b", 2.0)] {
        for (label, step, outcome, points, steps, error) in [
            ("x/1", 0.01, "completed", 100, 100, 4.0),
            ("x/1", 0.005, "completed", 200, 200, 2.0),
            // One phase has a macro step more, within what a budget may be exceeded by.
            ("x/1", 0.005, "completed", 201, 201, 3.0),
            ("x/4", 0.01, "completed", 100, 400, 1.0),
            // Best where it completes, and it does not at every phase.
            ("y/1", 0.01, "completed", 100, 100, 0.1),
            ("y/1", 0.01, "diverged", 100, 100, 0.1),
            ("y/2", 0.01, "completed", 100, 200, 3.0),
            ("z/split/1", 0.01, "completed", 100, 150, 0.5),
        ] {
            let error = times * error;
            rows +=
                &format!("{case},,{label},{step},{outcome},1.0,{points},{steps},{error},{error},{}\n", error / 100.0);
        }
    }
    RunTable::parse(Path::new("runs.csv"), &format!("{HEADER}\n{rows}")).unwrap()
}

#[test]
fn the_best_form_of_a_way_is_within_its_budget_and_completes_at_every_phase() {
    let table = table();
    let runs = Runs::of(&table);
    let error = |row: usize| runs.run(row).found.metric("force_error_inside_rms_n").unwrap();
    let forms = &forms_of(&runs, error)[&["a", ""]];
    let best = |budget| -> Vec<(&str, f64)> {
        best_within(forms, budget).into_iter().map(|form| (form.way, form.error)).collect()
    };
    assert_eq!(best([100.0, 100.0]), [("x", 4.0)]);
    assert_eq!(best([100.0, 200.0]), [("z/split", 0.5), ("y", 3.0), ("x", 4.0)]);
    assert_eq!(best([200.0, 200.0]), [("z/split", 0.5), ("x", 2.5), ("y", 3.0)]);
    assert_eq!(best([200.0, 400.0])[1], ("x", 1.0));
    assert_eq!(ratio_within(forms, [200.0, 200.0], ["y", "x"]), Some(1.2));
    assert_eq!(ratio_within(forms, [100.0, 100.0], ["y", ALL]), Some(f64::INFINITY));
    assert_eq!(ratio_within(forms, [10.0, 10.0], ["x", ALL]), None);
}

#[test]
fn budgets_are_told_case_by_case_or_pooled_where_settings_are_drawn() {
    let budgets = Budgets { per_s: vec![[200.0, 200.0]], without: Some("split".to_owned()) };
    let told = budget_csv(&table(), &budgets, &PooledSets::new()).unwrap();
    let lines: Vec<&str> = told.lines().collect();
    assert_eq!(lines.len(), 1 + 2 * 3 + 2 * 2);
    assert_eq!(lines[1], "a,,200,200,,1,z/split,z/split/1,0.01,0.005,1.0,,,1,1");
    assert_eq!(lines[7], "a,,200,200,split,1,x,x/1,0.005,0.025,1.0,,,1,1");
    let pooled = ["a", "b"].map(|case| ((case.to_owned(), String::new()), String::new())).into();
    let told = budget_csv(&table(), &budgets, &pooled).unwrap();
    let without: Vec<&str> =
        told.lines().filter(|line| line.contains("split,1,x") || line.contains("split,2,y")).collect();
    assert_eq!(without, ["all,,200,200,split,1,x,,,,1.0,1.0,1.0,1.0,2", "all,,200,200,split,2,y,,,,1.2,1.2,1.2,0.0,2"]);
}
