//! Several sides from outside around one mechanics, each with rows, rates and steps of its own.

use crate::exported_fmus::exported;
use crate::fmi::trace;
use crate::program::{assert_has, refused, rimbench};
use std::fs;
use std::path::Path;

/// The gripper: the same file twice, of which each has one cylinder coupled.
const CASE: &str = r#"name = "jaws"
duration_s = 0.2
macro_step_s = 2e-3
micro_step_s = 5e-5
[mechanics]
fmu = "mechanics.fmu"
[[actuator]]
fmu = "actuator.fmu"
rows = [1]
[[actuator]]
fmu = "actuator.fmu"
rows = [2]
"#;

fn write(folder: &Path, head: &str) -> String {
    let row = |jaw: &str| {
        let names = ["length_m", "velocity_m_s", "force_n"].map(|name| format!("{jaw}_{name}"));
        let ends = format!("position = {:?}\nvelocity = {:?}\nforce = {:?}\n", names[0], names[1], names[2]);
        format!("[[interface]]\ncolumns = {names:?}\n[interface.mechanics]\n{ends}[interface.actuator]\n{ends}")
    };
    let file = folder.join("jaws.toml");
    fs::write(&file, format!("{head}{}{}", row("left"), row("right"))).unwrap();
    file.display().to_string()
}

#[test]
fn several_fmus_have_the_digits_of_the_bonds_of_the_case_they_are_made_of() {
    let folder = exported("gripper", &[]);
    let own = ["--duration", "0.2", "--macro-step", "2e-3", "--scheme", "rim-nonsmooth-gap"];
    let with = |more: &[&'static str]| own.into_iter().chain(more.iter().copied()).collect::<Vec<_>>();
    let assert_same = |file: &str, asked: &[&'static str], known: &[&'static str]| {
        let [known, found] =
            [("gripper", known), (file, asked)].map(|(case, more)| trace(folder.path(), case, &with(more)));
        for name in ["left_force_n", "right_force_n", "left_length_m", "right_velocity_m_s"] {
            assert!(found[name].len() > 20, "{asked:?}");
            assert_eq!(found[name], known[name], "{asked:?}: {name}");
        }
    };
    let file = write(folder.path(), CASE);
    assert_same(&file, &[], &[]);
    // Each in a process of its own, as above, or all in this one.
    let case = format!("process = \"same\"\n{CASE}");
    let file = write(folder.path(), &case);
    let in_turn = ["--partition", "each", "--known", "held", "--order", "2;1"];
    assert_same(&file, &in_turn, &in_turn);
    // Rates and steps of the file are those of its runs, unless these say otherwise.
    let rows = "rows = [2]\nevery = 2\nmicro_step_s = 1e-4\nstart = { longest_step_s = 0.0 }";
    let file = write(folder.path(), &case.replace("rows = [2]", rows));
    assert_same(&file, &[], &["--partition", "each", "--every", "1,2", "--bond-micro-steps", "5e-5,1e-4"]);
    assert_same(
        &file,
        &["--every", "1/2"],
        &["--partition", "each", "--every", "1/2", "--bond-micro-steps", "5e-5,1e-4"],
    );
    assert_same(&file, &["--partition", "1+2"], &["--partition", "1+2"]);
    // Schemes that have no bonds move both as one.
    rimbench().args(["simulate", "--scheme", "monolithic", "--case", &file]).assert().success();
}

#[test]
fn an_actuator_of_several_rows_is_not_divided() {
    let folder = exported("gripper", &[]);
    let file = write(
        folder.path(),
        &CASE.replace("[[actuator]]\nfmu = \"actuator.fmu\"\nrows = [2]\n", "").replace("rows = [1]\n", ""),
    );
    let run = |partition: &str| {
        let own = ["--scheme", "rim-nonsmooth-gap", "--duration", "0.1", "--partition", partition, "--case", &file];
        let ran = rimbench().arg("simulate").args(own).output().unwrap();
        String::from_utf8_lossy(&ran.stdout).into_owned()
    };
    assert_has(&run("1|2"), &["not run", "partition = 1|2 divides an actuator, that of rows 1, 2"]);
    assert_has(&run("1+2"), &["completed"]);
}

#[test]
fn rows_and_steps_that_do_not_go_together_are_refused_by_table_and_row() {
    let folder = exported("gripper", &[]);
    let wrong = [
        ("rows = [2]", "rows = [1, 2]", "row 1 of [[interface]] is in rows of [[actuator]] 1 and of [[actuator]] 2"),
        ("rows = [2]", "rows = [3]", "rows of [[actuator]] 2 = [3] is not valid"),
        ("rows = [2]", "rows = [0]", "rows of [[actuator]] 2 = [0] is not valid"),
        ("rows = [2]", "rows = []", "[[actuator]] 2 has no rows"),
        ("rows = [2]\n", "", "[[actuator]] 2 has no rows"),
        ("rows = [2]", "rows = [2]\nevery = 0", "[[actuator]] 2: every = 0 is not valid"),
        ("rows = [2]", "rows = [2]\nevery = \"2/1\"", "[[actuator]] 2: every = 2/1 is not valid"),
        ("rows = [1]", "rows = [1]\nevery = [1]", "valid: a whole number from 1 on, or \"1/n\""),
        ("rows = [2]", "rows = [2]\nmicro_step_s = 1", "micro_step_s of [[actuator]] 2 = 1 is not valid"),
        ("rows = [2]", "rows = [2]\nmicro_step_s = 0", "micro_step_s of [[actuator]] 2 = 0 is not valid"),
        ("rows = [2]", "rows = [2]\nrow = 3", "unknown field `row`"),
        ("fmu = \"actuator.fmu\"\nrows = [2]", "fmu = \"none.fmu\"\nrows = [2]", "where [[actuator]] 2 of"),
        ("fmu = \"actuator.fmu\"\nrows = [2]", "rows = [2]", "[[actuator]] 2 is no side"),
        ("[[actuator]]\nfmu = \"actuator.fmu\"\nrows = [2]\n", "", "rows of [actuator] is not valid"),
        ("rows = [2]", "rows = [2]\n[[actuator]]\nfmu = \"actuator.fmu\"\nrows = [3]", "numbers from 1 to 2"),
    ];
    for (piece, by, said) in wrong {
        let head = CASE.replacen(piece, by, 1);
        let file = write(folder.path(), &head);
        let message = refused(rimbench().args(["simulate", "--scheme", "zero-order-hold", "--case", &file]));
        assert_has(&message, &["jaws.toml", said]);
    }
    let said = |text: &str| {
        let file = folder.path().join("jaws.toml");
        fs::write(&file, text).unwrap();
        refused(rimbench().args(["simulate", "--scheme", "zero-order-hold", "--case"]).arg(&file))
    };
    let good = fs::read_to_string(write(folder.path(), CASE)).unwrap();
    let last = good.rsplit("[[interface]]").next().unwrap();
    assert_has(&said(&format!("{good}[[interface]]{last}")), &["row 3 of [[interface]] is in rows of no [[actuator]]"]);
    let (head, tail) = (CASE.split("[mechanics]").next().unwrap(), good.split_once("[[interface]]").unwrap().1);
    let none = format!("{head}actuator = []\n[mechanics]\nfmu = \"mechanics.fmu\"\n[[interface]]{tail}");
    assert_has(&said(&none), &["no actuator"]);
    let twice = |names: &str| format!("{good}[parameters.a]\ndefault = 1.0\nactuator = {names}\n");
    assert_has(&said(&twice("[\"a\"]")), &["[parameters.a] actuator", "a list of 2"]);
}
