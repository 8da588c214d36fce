//! Numbers and tables of pages, filled from files.

use crate::root;
use rimbench_core::error::Result;
use rimbench_figures::{TableList, fill_page, has_markers};
use rimbench_results::kept::{PooledSets, keep};
use rimbench_runs::catalogue::Catalogue;
use std::path::Path;

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

/// Columns of a summary and of other files, as lists of tables have them.
const LIST: &str = r#"
[table."study/x/by-step".grid]
cell = "force_error_rms_n_median"
across = { column = "macro_step_s", unit = "ms", values = [5, 10] }
digits = 3

[table."work/solvers".list]
file = "work.csv"
columns = [
    { column = "solver" },
    { column = "pivots", fold = "sum", heading = "work" },
    { column = "worst", fold = "max", unit = "%" },
]
names = { one = "first" }

[table."work/two".list]
file = "work.csv"
only = { worst = { below = 0.3 }, solver = { not = ["one"] } }
columns = [{ column = "solver" }, { column = "worst" }]

[value."study/x/error"]
column = "position_error_rms_m_median"
only = { label = "a", macro_step_s = 0.005 }

[value."study/x/claims"]
file = "claims.csv"
column = "id"
fold = "count"
"#;

fn list(text: &str) -> TableList {
    TableList::parse("t.toml".as_ref(), text).unwrap()
}

/// The tables of a list, made in a folder, one behind the other.
fn made(text: &str, results: &Path) -> Result<String> {
    let list = list(text);
    list.tables().map(|id| table_of(&list, &id, results)).collect()
}

/// A table as a page has it.
fn table_of(list: &TableList, id: &str, results: &Path) -> Result<String> {
    let page = fill_page("page.md".as_ref(), &format!("<!-- table {id} --><!-- /table -->"), results, list)?;
    let (_, inside) = page.split_once("-->\n\n").unwrap();
    Ok(inside.split_once("\n<!--").unwrap().0.to_owned())
}

#[test]
fn markers_are_filled_and_what_is_around_them_stays() {
    let (folder, list) = (results(), list(LIST));
    let filled = |text: &str| fill_page("page.md".as_ref(), text, folder.path(), &list);
    let page = "It has <!-- value id=study/x/error unit=mm -->?<!-- /value -->, and \
                <!-- value claim=study/x:floor unit=N -->?<!-- /value --> of \
                <!-- value id=study/x/claims -->?<!-- /value -->:\
                <!-- table study/x/by-step --><!-- /table -->.";
    let once = filled(page).unwrap();
    let text: String = once.split("<!--").map(|part| part.split_once("-->").map_or(part, |(_, text)| text)).collect();
    let table = "| scheme | 5 ms | 10 ms |\n|---|---|---|\n| a | 16.6 | 30.0 (1) |\n| b | 8.30 | – |";
    assert_eq!(text, format!("It has 1.2 mm, and 43 N of 1:\n\n{table}\n\n."));
    assert_eq!(filled(&once).unwrap(), once);
    assert!(has_markers(&once) && !has_markers("no <!-- remark -->"));
    let example = "```text\n<!-- value claim=nothing -->\n```\n";
    assert_eq!(filled(example).unwrap(), example);
}

#[test]
fn a_table_says_how_many_completed_where_not_all_did() {
    let (folder, list) = (results(), list(LIST));
    let table = table_of(&list, "study/x/by-step", folder.path()).unwrap();
    assert_eq!(table, "| scheme | 5 ms | 10 ms |\n|---|---|---|\n| a | 16.6 | 30.0 (1) |\n| b | 8.30 | – |\n");
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
    let table = |keys: &str| {
        made(&format!("[table.\"study/x/t\".grid]\ncell = \"force_error_rms_n_median\"\n{keys}"), folder.path())
    };
    let steps = "across = { column = \"macro_step_s\", unit = \"ms\" }";
    let names = "names = { \"c=1 soft\" = \"soft stops\", set = \"stops\" }";
    let sets = table(&format!("lines.column = \"set\"\n{steps}\nonly = {{ label = \"a\" }}\n{names}"));
    assert_eq!(sets.unwrap(), "| stops | 5 ms |\n|---|---|\n| soft stops | 1.5 |\n| hard | 2.5 |\n");
    let labels =
        "lines.column = \"set\"\nacross = { column = \"label\", values = [\"b\", \"a\"] }\nnames.b = \"better\"";
    assert_eq!(
        table(labels).unwrap(),
        "| set | better | a |\n|---|---|---|\n| c=1 soft | 3.5 | 1.5 |\n| hard | 4.5 | 2.5 |\n"
    );
    // Sets that have a parameter, and the largest of their values.
    let some = format!("lines = {{ column = \"set\", values = [\"c=1\"] }}\nfold = \"max\"\n{steps}");
    assert_eq!(table(&some).unwrap(), "| set | 5 ms |\n|---|---|\n| c=1 | 3.5 |\n");
    let error = table(&format!("lines.column = \"label\"\n{steps}")).unwrap_err().to_string();
    assert!(error.contains("`study/x/t`") && error.contains("2 rows have `a` and `0.005`: say one"), "{error}");
}

/// With friction one scheme had no runs, and the share of its rival was that of more machines.
#[test]
fn a_table_of_shares_says_of_how_many_runs_and_has_one_set_of_them_for_all_schemes() {
    let folder = results();
    let own = folder.path().join("study/x");
    let row = |row: &str| format!("{row},0.005,,completed,0.01\n");
    let rows = ["a,box,", "b,box,", "a,crane,", "b,crane,", "a,box,friction=0.3"].map(row).concat();
    let header = "label,case,set,macro_step_s,step_tolerance,outcome,force_error_rms_of_event_peak";
    std::fs::write(own.join("runs.csv"), format!("{header}\n{rows}")).unwrap();
    keep(&own, &PooledSets::new(), &"0".repeat(64)).unwrap();
    let table = |keys: &str| {
        let steps = "across = { column = \"macro_step_s\", unit = \"ms\" }";
        let cell =
            format!("[table.\"study/x/t\".grid]\ncell = \"usable\"\nof = \"runs\"\nunit = \"%\"\n{steps}\n{keys}");
        made(&cell, folder.path())
    };
    let refused = table("").unwrap_err().to_string();
    assert!(refused.contains("the shares of `b` and `0.005` are of other runs than those beside them"), "{refused}");
    let shares = table("only.set = { not = [\"friction=0.3\"] }").unwrap();
    assert_eq!(shares, "| scheme, of 2 runs | 5 ms |\n|---|---|\n| a | 100 |\n| b | 100 |\n");
    // Cases are not the same runs, and are not meant to be.
    let cases = table("lines.column = \"case\"\nonly.label = \"a\"").unwrap();
    assert!(cases.starts_with("| case, of 1 to 2 runs | 5 ms |\n"), "{cases}");
}

#[test]
fn claims_are_counted_over_all_experiments_that_are_kept() {
    let folder = results();
    for (name, text) in [("paper", "experiment,id\nfig1,a\nfig2,b\n"), ("published/c", "experiment,id\nc,a\n")] {
        std::fs::create_dir_all(folder.path().join(name)).unwrap();
        std::fs::write(folder.path().join(name).join("claims.csv"), text).unwrap();
    }
    let other = folder.path().join("study/x/claims.csv");
    let list = list("[value]\n\"all/claims\" = { file = \"claims.csv\", column = \"id\", fold = \"count\" }\n");
    let filled = || fill_page("p.md".as_ref(), "<!-- value id=all/claims --><!-- /value -->", folder.path(), &list);
    let error = filled().unwrap_err().to_string();
    assert!(error.contains("has other columns than") && error.contains("study/x/claims.csv"), "{error}");
    std::fs::write(other, "experiment,id\nx,a\n").unwrap();
    assert!(filled().unwrap().contains("-->4<!--"));
}

#[test]
fn rows_of_other_files_are_chosen_folded_and_held_against_each_other() {
    let folder = results();
    let work = "solver,from,pivots,worst\none,1,3,1e-9\none,65,7,2e-9\ntwo,1,5,0.5\ntwo,65,,0.25\n";
    std::fs::create_dir(folder.path().join("work")).unwrap();
    std::fs::write(folder.path().join("work/work.csv"), work).unwrap();
    let tables = list(LIST);
    let table = |id: &str| table_of(&tables, id, folder.path()).unwrap();
    let solvers = "| solver | work | worst |\n|---|---|---|\n| first | 10 | 2.0e-7 |\n| two | 5 | 50 |\n";
    assert_eq!(table("work/solvers"), solvers);
    assert_eq!(table("work/two"), "| solver | worst |\n|---|---|\n| two | 0.25 |\n");
    let value = |keys: &str, unit: &str| {
        let list = list(&format!("[value.\"work/v\"]\nfile = \"work.csv\"\n{keys}"));
        let page = format!("<!-- value id=work/v {unit} -->?<!-- /value -->");
        fill_page("p".as_ref(), &page, folder.path(), &list)
    };
    for (keys, unit, said) in [
        ("column = \"pivots\"\nfold = \"sum\"\nonly.solver = \"one\"", "", "10"),
        ("column = \"pivots\"\nfold = \"count\"\nonly.worst = { below = 0.3 }", "", "2"),
        ("column = \"worst\"\nonly = { solver = \"two\", from = 65.0 }", "unit=%", "25 %"),
        ("column = \"solver\"\nonly.worst = 0.5", "", "two"),
    ] {
        let made = value(keys, unit).unwrap();
        assert!(made.contains(&format!("-->{said}<!--")), "{keys}: {made}");
    }
    for (keys, said) in [
        ("column = \"pivots\"\nonly.solver = \"one\"", "2 rows are of `work/v`"),
        ("column = \"pivots\"\nonly.solver = \"on\"", "`one`"),
        ("column = \"pivot\"\nonly.worst = 0.5", "pivots"),
        ("column = \"pivots\"\nonly.pivots.below = 1", "no row meets `only` (pivots)"),
    ] {
        let error = value(keys, "").unwrap_err().to_string();
        assert!(error.contains(said), "{keys}: {error}");
    }
}

/// What a table calls its lines is for readers: no name that is typed, and no label of an experiment.
#[test]
fn no_shipped_table_calls_a_line_by_an_identifier() {
    let list: toml::Table =
        toml::from_str(&std::fs::read_to_string(root().join("paper/tables.toml")).unwrap()).unwrap();
    let (catalogue, mut names) = (Catalogue::standard(), 0);
    for (id, table) in list["table"].as_table().unwrap() {
        let kinds = table.as_table().unwrap().values().filter_map(|kind| kind.get("names")?.as_table());
        for (of, name) in kinds.flatten() {
            let name = name.as_str().unwrap();
            let typed =
                catalogue.schemes().iter().find(|known| known.name.contains('-') && name.contains(&*known.name));
            assert!(typed.is_none() && !name.contains('/'), "{id}: {of} is called {name}");
            names += 1;
        }
    }
    assert!(names > 20, "only {names} names are seen");
}

#[test]
fn what_cannot_be_filled_is_named_with_its_line() {
    let (folder, list) = (results(), list(LIST));
    for (marker, said) in [
        ("<!-- value id=study/x/eror --><!-- /value -->", "`study/x/error`"),
        ("<!-- value unit=N --><!-- /value -->", "one of `claim="),
        ("<!-- value claim=study/x:flor --><!-- /value -->", "`floor`"),
        ("<!-- value claim=study/x --><!-- /value -->", "group/name:id"),
        ("<!-- value claim=study/x:floor colour=red --><!-- /value -->", "colour"),
        ("<!-- value claim=study/x:floor digits=0 --><!-- /value -->", "1 to 8"),
        ("<!-- value claim=study/x:floor -->", "is not closed"),
        ("<!-- value claim=study/x:floor unit=ft --><!-- /value -->", "ft"),
        ("<!-- table study/x/none --><!-- /table -->", "unknown table `study/x/none`"),
    ] {
        let error =
            fill_page("page.md".as_ref(), &format!("one\n{marker}"), folder.path(), &list).unwrap_err().to_string();
        assert!(error.contains("page.md: line 2") && error.contains(said), "{marker}: {error}");
    }
}

#[test]
fn what_is_wrong_in_a_list_is_named_with_line_key_and_what_is_valid() {
    for (from, to, line, said) in [
        ("digits = 3", "digits = 9", 5, "by-step: digits = 9 is not valid; valid: a whole number from 1 to 8"),
        ("digits = 3", "digit = 3", 5, "unknown field `digit`"),
        ("\"ms\"", "\"ft\"", 4, "across: unit: unknown unit `ft`"),
        ("fold = \"sum\"", "fold = \"mean\"", 11, "`sum`, `max`, `count`"),
        (".list]", ".lists]", 7, "unknown variant `lists`, expected one of `grid`, `list`, `budgets`"),
        ("below = 0.3", "over = 0.3", 18, "only: worst: unknown field `over`, expected one of `not`, `among`, `below`"),
        (
            "label = \"a\"",
            "label = true",
            23,
            "only: label = true is not valid; valid: a text, a number, or { not = […]",
        ),
        ("\"work/two\"", "\"two\"", 16, "folder/name"),
        ("column = \"id\"\n", "", 25, "missing field `column`"),
    ] {
        let error = TableList::parse("t.toml".as_ref(), &LIST.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(error.contains(&format!("t.toml: line {line}, ")) && error.contains(said), "{to}: {error}");
    }
    let folder = results();
    for (from, to, said) in [
        ("[5, 10]", "[6]", "0 rows have `a` and `6`"),
        ("force_error_rms_n_median", "force_error", "force_error_rms_n_median"),
        ("study/x/by-step", "study/y/by-step", "digest.toml"),
    ] {
        let error = made(&LIST.replacen(from, to, 1), folder.path()).unwrap_err().to_string();
        assert!(error.contains(said), "{to}: {error}");
    }
}
