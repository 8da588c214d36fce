//! Rows of runs: read once, selected, grouped and pooled.

use rimbench_results::run_table::RunTable;
use rimbench_results::selection::{ALL, Runs};
use rimbench_runs::Finding;
use std::path::Path;

fn table(text: &str) -> RunTable {
    RunTable::parse(Path::new("runs.csv"), text).unwrap()
}

const RUNS: &str = "label,case,set,macro_step_s,phase,outcome,velocity_error_rms_m_s,model_exact\n\
                    x,a,,0.001,0.5,completed,1,false\nx,a,,0.001,1.0,diverged,1e9,false\n\
                    x,a,m=2,0.002,0.5,completed,3,false\ny,b,,0.001,0.5,skipped,,true\n\
                    y,b,,0.002,0.5,completed,5,false";

#[test]
fn runs_are_selected_by_label_case_and_set() {
    let table = table(RUNS);
    let runs = Runs::of(&table);
    assert_eq!(runs.labels(&[]), ["x", "y"]);
    assert_eq!(runs.of_label("x").completed().rows(), [0, 2]);
    assert_eq!(runs.of_problem(Some("a"), Some("")).rows(), [0, 1]);
    assert_eq!(runs.of_problem(Some("a"), Some(ALL)).rows(), [0, 1, 2]);
    assert_eq!(runs.of_problem(None, None).problems().len(), 3);
    assert_eq!(runs.of_problem(None, Some("m=")).rows(), [0_usize; 0]);
    assert_eq!(runs.without_exact().rows(), [0, 1, 2]);
}

#[test]
fn a_set_is_named_or_where_none_has_the_name_by_words_of_it() {
    let table = table(
        "label,case,set,macro_step_s,outcome\nx,a,e=0.0 m=1,1,completed\nx,a,e=0.0 m=2,1,completed\n\
         x,a,e=0.3 m=1,1,completed\nx,b,e=0.0,1,completed\nx,b,e=0.0 m=1,1,completed",
    );
    let runs = Runs::of(&table);
    let rows = |case: &str, set: &str| runs.of_problem(Some(case), Some(set)).rows().to_vec();
    assert_eq!(rows("a", "e=0.0"), [0, 1]);
    assert_eq!(rows("a", "m=1 e=0.0"), [0]);
    assert_eq!(rows("b", "e=0.0"), [3]);
    assert_eq!((rows("a", ""), rows("a", "e=0")), (vec![], vec![]));
}

#[test]
fn what_did_not_complete_is_lost_and_in_no_pool() {
    let table = table(RUNS);
    let runs = Runs::of(&table);
    let error = Finding::named("velocity_error_rms_m_s").unwrap();
    let points = runs.over(|row| runs.macro_step_ms(row), |row| runs.value(row, error));
    assert_eq!((points[0].x, points[0].tally.failed_share(), points[0].pool.median()), (1.0, 0.5, Some(1.0)));
    assert_eq!((points[1].x, points[1].tally.failed_share(), points[1].pool.range()), (2.0, 0.0, Some([3.0, 5.0])));
    assert_eq!(runs.of_label("y").share_completed(), Some(1.0));
    assert_eq!(runs.with_rows(vec![3]).share_completed(), None);
    let groups = runs.by_key(|run| (run.problem()[0], run.macro_step_s.to_bits()));
    assert_eq!(groups.len(), 4);
    assert_eq!((groups[0].0.0, groups[0].1.rows()), ("a", &[0, 1][..]));
}

#[test]
fn what_gave_no_answer_is_no_failure_and_in_no_share() {
    let table = table(
        "label,case,set,macro_step_s,outcome\nx,a,,1,completed\nx,a,,1,timeout\nx,a,,1,panicked\nx,a,,1,diverged\n\
         x,a,,1,skipped\ny,a,,1,timeout",
    );
    let runs = Runs::of(&table);
    let tally = runs.of_label("x").tally();
    assert_eq!([tally.completed, tally.failed, tally.no_answer, tally.skipped], [1, 1, 2, 1]);
    assert_eq!((tally.failed_share(), tally.silent_share()), (0.5, 0.5));
    let only = runs.of_label("y");
    assert_eq!((only.share_completed(), only.tally().failed_share(), only.tally().silent_share()), (None, 0.0, 1.0));
}

#[test]
fn cases_are_drawn_or_phases_of_one_case() {
    let table = table(RUNS);
    let runs = Runs::of(&table);
    assert_eq!(runs.witnesses(&|problem| problem.concat()), [vec![0, 1], vec![2], vec![3, 4]]);
    assert_eq!(runs.of_problem(Some("a"), Some("")).witnesses(&|problem| problem.concat()), [vec![0], vec![1]]);
}

#[test]
fn an_error_has_the_floor_of_its_reference_in_its_own_unit() {
    let header = "label,case,set,macro_step_s,outcome,force_error_rms_n,force_error_rms_of_peak,velocity_error_rms_m_s,\
                  reference_force_uncertainty_n";
    let table = table(&format!("{header}\nx,a,,1,completed,1,0.01,1,0.1\nx,a,,1,completed,3,,,"));
    let [error, share, other] = ["force_error_rms_n", "force_error_rms_of_peak", "velocity_error_rms_m_s"]
        .map(|name| Finding::named(name).unwrap());
    let [known, unknown] = [0, 1].map(|row| &table.runs()[row].found);
    assert_eq!(known.floor(error), Some(0.1));
    assert!(unknown.floor(error).unwrap().is_nan());
    approx::assert_relative_eq!(known.floor(share).unwrap(), 1e-3, max_relative = 1e-14);
    // Without an uncertainty of its own, and where nothing is known of the reference.
    assert!(known.floor(other).is_none() && !known.has_order(other) && unknown.has_order(error));
}

#[test]
fn a_cell_that_is_none_is_refused_with_its_row_its_column_and_what_is_valid() {
    let refused = |header: &str, row: &str| {
        let text = format!("{header}\nx,a,,0.001,completed,1,2\n{row}\n");
        RunTable::parse(Path::new("my/runs.csv"), &text).unwrap_err().to_string()
    };
    let header = "label,case,set,macro_step_s,outcome,force_error_rms_n,exchanges";
    for (row, said) in [
        ("x,a,,1ms,completed,1,2", ["row 2", "macro_step_s", "= \"1ms\"", "a number"]),
        ("x,a,,0.001,done,1,2", ["row 2", "outcome", "`done`", "completed"]),
        ("x,a,,0.001,completed,high,2", ["row 2", "force_error_rms_n", "= \"high\"", "a number"]),
        ("x,a,,0.001,completed,1,", ["row 2", "exchanges", "= \"\"", "a number"]),
    ] {
        let error = refused(header, row);
        assert!(error.contains("my/runs.csv") && said.iter().all(|said| error.contains(said)), "{error}");
    }
    let no_head = refused("x,b,,0.002,completed,1,2", "x,b,,0.001,completed,1,2");
    assert!(no_head.contains("is no table of runs: its first line has none of the columns label, case"), "{no_head}");
    assert!(refused("label,case,sets,macro_step_s,outcome,a,b", "").contains("unknown column `set`"));
    let table = table("label,case,set,macro_step_s,delivery_up,outcome\nx,a,,0.001,delay:0.1,completed");
    assert_eq!(table.settings().collect::<Vec<_>>(), ["case", "set", "macro_step_s", "delivery_up"]);
    assert_eq!(&*table.runs()[0].settings[table.setting("delivery_up").unwrap()], "delay:0.1");
    assert!(table.check(Finding::FORCE_ERROR).unwrap_err().to_string().contains("unknown column `force_error_rms_n`"));
}
