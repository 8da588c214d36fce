//! Numbers and tables of pages, filled from files.

use rimbench_core::error::Result;
use rimbench_figures::{fill_page, without_filled};
use rimbench_results::kept::{PooledSets, keep};

fn results() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("study/x");
    std::fs::create_dir_all(&own).unwrap();
    let runs = "run_id,label,case,set,macro_step_s,step_tolerance,outcome,force_error_rms_n,position_error_rms_m\n\
                1,a,box,,0.005,,completed,16.6,0.00123\n2,a,box,,0.01,,completed,30,2e-3\n3,a,box,,0.01,,diverged,,\n\
                4,b,box,,0.005,,completed,8.3,1e-3\n5,b,box,,0.01,,diverged,1e9,1\n";
    std::fs::write(own.join("runs.csv"), runs).unwrap();
    keep(&own, &PooledSets::new(), &"0".repeat(64)).unwrap();
    let claims = "experiment,id,text,measured,low,high,expected,verdict\nx,floor,t,43.26,40,50,≥ 2,reproduced\n";
    std::fs::write(own.join("claims.csv"), claims).unwrap();
    folder
}

fn filled(text: &str) -> Result<String> {
    fill_page("page.md".as_ref(), text, results().path())
}

#[test]
fn markers_are_filled_and_what_is_around_them_stays() {
    let page = "It has <!-- value file=study/x/summary.csv column=position_error_rms_m_median \
                where=\"label=a; macro_step_s=0.005\" unit=mm -->?<!-- /value -->, and \
                <!-- value claim=study/x:floor unit=N -->?<!-- /value --> of \
                <!-- value file=study/x/claims.csv column=count -->?<!-- /value -->.";
    let once = filled(page).unwrap();
    let text: String = once.split("<!--").map(|part| part.split_once("-->").map_or(part, |(_, text)| text)).collect();
    assert_eq!(text, "It has 1.2 mm, and 43 N of 1.");
    assert_eq!(filled(&once).unwrap(), once);
    assert_eq!(without_filled(&once), "It has , and  of .");
    let example = "```text\n<!-- value claim=nothing -->\n```\n";
    assert_eq!(filled(example).unwrap(), example);
}

#[test]
fn a_table_says_how_many_completed_where_not_all_did() {
    let table = filled(
        "<!-- table file=study/x/summary.csv lines=label across=\"macro_step_s in ms: 5; 10\" \
                        cell=force_error_rms_n_median digits=3 --><!-- /table -->",
    )
    .unwrap();
    assert!(
        table.contains("\n| scheme | 5 ms | 10 ms |\n|---|---|---|\n| a | 16.6 | 30.0 (1) |\n| b | 8.30 | – |\n"),
        "{table}"
    );
    let claims = filled("<!-- table claims=study/x -->\n<!-- /table -->").unwrap();
    assert!(claims.contains("| t | 43.3 | ≥ 2 | reproduced |"), "{claims}");
}

#[test]
fn lines_may_be_other_than_schemes_and_names_other_than_identifiers() {
    let folder = results();
    let own = folder.path().join("study/x");
    let runs = "label,case,set,macro_step_s,step_tolerance,outcome,force_error_rms_n\n\
                a,box,c=1 soft,0.005,,completed,1.5\na,box,hard,0.005,,completed,2.5\n\
                b,box,c=1 soft,0.005,,completed,3.5\nb,box,hard,0.005,,completed,4.5\n";
    std::fs::write(own.join("runs.csv"), runs).unwrap();
    keep(&own, &PooledSets::new(), &"0".repeat(64)).unwrap();
    let table = |marker: &str| {
        let marker =
            format!("<!-- table file=study/x/summary.csv cell=force_error_rms_n_median {marker} --><!-- /table -->");
        fill_page("p".as_ref(), &marker, folder.path())
    };
    let steps = "across=\"macro_step_s in ms\"";
    let made = table(&format!("lines=set {steps} where=label=a names=\"c=1 soft=soft stops; set=stops\"")).unwrap();
    assert!(made.contains("\n| stops | 5 ms |\n|---|---|\n| soft stops | 1.5 |\n| hard | 2.5 |\n"), "{made}");
    let made = table("lines=set across=\"label: b; a\" names=\"b=better\"").unwrap();
    assert!(made.contains("\n| set | better | a |\n|---|---|---|\n| c=1 soft | 3.5 | 1.5 |\n"), "{made}");
    let error = table(&format!("lines=label {steps}")).unwrap_err().to_string();
    assert!(error.contains("2 rows have `a` and `0.005`: say one"), "{error}");
}

#[test]
fn rows_of_other_files_are_chosen_folded_and_held_against_each_other() {
    let folder = results();
    let work = "solver,from,pivots,worst\none,1,3,1e-9\none,65,7,2e-9\ntwo,1,5,0.5\ntwo,65,,0.25\n";
    std::fs::write(folder.path().join("work.csv"), work).unwrap();
    let filled = |text: &str| fill_page("p".as_ref(), text, folder.path());
    let made = filled(
        "<!-- table file=work.csv columns=\"solver; sum pivots as work; max worst in %\" names=\"one=first\" -->\
         <!-- /table -->",
    );
    let lines = "\n| solver | work | max worst |\n|---|---|---|\n| first | 10 | 2.0e-7 |\n| two | 5 | 50 |\n";
    assert!(made.as_ref().unwrap().contains(lines), "{made:?}");
    let made =
        filled("<!-- table file=work.csv columns=\"solver; worst\" where=\"from>1; solver!=one\" --><!-- /table -->");
    assert!(made.as_ref().unwrap().contains("|---|---|\n| two | 0.25 |\n\n"), "{made:?}");
    for (keys, said) in [
        ("column=\"sum pivots\" where=solver=one", "10"),
        ("column=count where=\"worst<0.3\"", "3"),
        ("column=worst where=\"solver=two; from=65.0\" unit=%", "25 %"),
        ("column=solver where=\"worst=0.5\"", "two"),
    ] {
        let made = filled(&format!("<!-- value file=work.csv {keys} -->?<!-- /value -->")).unwrap();
        assert!(made.contains(&format!("-->{said}<!--")), "{keys}: {made}");
    }
    for (keys, said) in [
        ("column=pivots where=solver=one", "2 rows meet `solver=one`"),
        ("column=pivots where=solver=on", "`one`"),
        ("column=pivot", "pivots"),
        ("column=\"mean pivots\"", "sum"),
        ("column=pivots where=\"pivots>9\"", "no row meets"),
    ] {
        let error = filled(&format!("<!-- value file=work.csv {keys} --><!-- /value -->")).unwrap_err().to_string();
        assert!(error.contains(said), "{keys}: {error}");
    }
}

#[test]
fn what_cannot_be_filled_is_named_with_its_line() {
    for (marker, said) in [
        ("<!-- value file=study/x/summary.csv column=runs where=label=c --><!-- /value -->", "`c`"),
        ("<!-- value file=study/x/summary.csv --><!-- /value -->", "lacks `column`"),
        ("<!-- value column=runs --><!-- /value -->", "lacks `file`"),
        (
            "<!-- table file=study/x/summary.csv cell=runs lines=label across=\"macro_step_s in ms: 6\" --><!-- /table -->",
            "`6`",
        ),
        ("<!-- value claim=study/x:flor --><!-- /value -->", "`floor`"),
        ("<!-- value claim=study/x --><!-- /value -->", "group/name:id"),
        ("<!-- value claim=study/x:floor colour=red --><!-- /value -->", "colour"),
        ("<!-- value file=study/y/summary.csv column=runs --><!-- /value -->", "digest.toml"),
        ("<!-- value claim=study/x:floor -->", "is not closed"),
        ("<!-- value claim=study/x:floor unit=ft --><!-- /value -->", "ft"),
    ] {
        let error = filled(&format!("one\n{marker}")).unwrap_err().to_string();
        assert!(error.contains("page.md: line 2") && error.contains(said), "{marker}: {error}");
    }
}
