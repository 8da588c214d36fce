//! What a description says of a coupled variable or of the experiment is obeyed, or refused by name; what a case file
//! names is found.
#![cfg(target_os = "linux")]

use crate::faulty_guest::{Guest, MASS, POSITION, SPRING, case, inside, last, refused, run, traced, write_case};
use crate::program::assert_has;
use std::fs;
use std::path::Path;

/// What an attribute comes to.
enum Then<'a> {
    /// Bad input, in these words.
    Refused(&'a [&'a str]),
    /// A run like one without it, and these words of a note.
    Runs(&'a [&'a str]),
    /// A run that fails with these words.
    Fails(&'a [&'a str]),
}
use Then::{Fails, Refused, Runs};

/// Of the spring's force, in the words of FMI 3.0 (in FMI 2.0 a type has them).
const FORCE: &str = "valueReference=\"2\" causality=\"output\" variability=\"continuous\" initial=\"calculated\"";
/// Of the position that the spring takes.
const TAKEN: &str = "<Float64 name=\"x\" valueReference=\"0\" causality=\"input\" variability=\"continuous\"";
/// Of a parameter that nothing sets.
const DAMPING: &str = "<Float64 name=\"d\"";
const SLAVE: &str = "<CoSimulation";
const EXPERIMENT: &str = "<UnitDefinitions>";
const DEPENDS: &str = "dependencies=\"0 1\"";

#[test]
fn each_attribute_of_what_is_coupled_is_obeyed_or_refused_by_name() {
    let Some(folder) = case(&MASS, &SPRING, &[]) else { return };
    let as_it_is = last(folder.path(), POSITION);
    for (from, to, then) in [
        ("fmiVersion=\"3.0\"", "fmiVersion=\"3.0-beta.2\"", Refused(&["fmiVersion = 3.0-beta.2", "2.0, 3.0"])),
        (
            SLAVE,
            "<CoSimulation hasEventMode=\"maybe\"",
            Refused(&["<CoSimulation> hasEventMode = maybe", "true, false"]),
        ),
        (
            "StepSize=\"true\"",
            "StepSize=\"maybe\"",
            Refused(&["canHandleVariableCommunicationStepSize = maybe", "true, false"]),
        ),
        (
            SLAVE,
            "<CoSimulation needsExecutionTool=\"true\"",
            Runs(&["spring.fmu: it drives a tool", "needsExecutionTool"]),
        ),
        (SLAVE, "<CoSimulation canStopEarly=\"true\"", Runs(&["canStopEarly", "no attribute of FMI 3.0"])),
        (
            SLAVE,
            "<CoSimulation providesIntermediateUpdate=\"true\" mightReturnEarlyFromDoStep=\"true\" hasEventMode=\"true\"",
            Runs(&[]),
        ),
        (
            EXPERIMENT,
            "<DefaultExperiment startTime=\"soon\"/><UnitDefinitions>",
            Refused(&["<DefaultExperiment> startTime = soon"]),
        ),
        (
            EXPERIMENT,
            "<DefaultExperiment stopTime=\"0.1\" tolerance=\"1e-6\" stepSize=\"0.1\"/><UnitDefinitions>",
            Runs(&[]),
        ),
        (
            EXPERIMENT,
            "<DefaultExperiment startTime=\"10\"/><UnitDefinitions>",
            Runs(&["time is 10 when a run begins", "startTime"]),
        ),
        (
            DEPENDS,
            "dependencies=\"0 77\"",
            Refused(&["<Output valueReference=\"2\"> dependencies = 77 names no variable"]),
        ),
        (
            DEPENDS,
            "dependencies=\"0 1\" dependenciesKind=\"fixed\"",
            Refused(&["dependenciesKind has 1 words", "2 dependencies"]),
        ),
        (
            DEPENDS,
            "dependencies=\"0 1\" dependenciesKind=\"fixed some\"",
            Refused(&["dependenciesKind = fixed some", "tunable"]),
        ),
        (FORCE, "valueReference=\"2\" causality=\"Output\"", Refused(&["variable `f`: causality = Output", "output"])),
        (FORCE, "valueReference=\"two\" causality=\"output\"", Refused(&["variable `f`: valueReference = \"two\""])),
        (FORCE, "causality=\"output\"", Refused(&["variable `f` has no valueReference"])),
        (
            FORCE,
            "valueReference=\"2\" causality=\"output\" variability=\"often\"",
            Refused(&["variability = often", "discrete"]),
        ),
        (
            FORCE,
            "valueReference=\"2\" causality=\"output\" variability=\"fixed\"",
            Refused(&["variability = fixed", "continuous"]),
        ),
        (FORCE, "valueReference=\"2\" causality=\"output\" variability=\"discrete\"", Runs(&[])),
        (
            FORCE,
            "valueReference=\"2\" causality=\"output\" initial=\"known\"",
            Refused(&["initial = known", "exact, approx"]),
        ),
        (
            FORCE,
            "valueReference=\"2\" causality=\"output\" clocks=\"5\"",
            Refused(&["`f` has clocks = 5", "event mode"]),
        ),
        (
            FORCE,
            "valueReference=\"2\" causality=\"output\" start=\"x\"",
            Refused(&["variable `f`: start = x", "a number"]),
        ),
        (
            FORCE,
            "valueReference=\"2\" causality=\"output\" intermediateUpdate=\"often\"",
            Refused(&["intermediateUpdate = often"]),
        ),
        (
            FORCE,
            "valueReference=\"2\" causality=\"output\" derivative=\"77\"",
            Refused(&["`f`: derivative = 77 names no variable"]),
        ),
        (
            FORCE,
            "valueReference=\"2\" causality=\"output\" relativeQuantity=\"so\"",
            Refused(&["relativeQuantity = so"]),
        ),
        (
            FORCE,
            "valueReference=\"2\" causality=\"output\" min=\"5\" max=\"3\"",
            Refused(&["min = 5 is above max = 3"]),
        ),
        (
            FORCE,
            "valueReference=\"2\" causality=\"output\" varibility=\"discrete\"",
            Runs(&["`f` has varibility", "no attribute"]),
        ),
        (FORCE, "valueReference=\"2\" causality=\"output\" start=\"1 2\"", Refused(&["`f`: start = 1 2", "one value"])),
        (
            FORCE,
            "valueReference=\"2\" causality=\"output\" start=\"20\" max=\"10\"",
            Refused(&["`f`: start = 20", "at most 10 (max)"]),
        ),
        (
            FORCE,
            "valueReference=\"2\" causality=\"output\" derivative=\"2\"",
            Refused(&["`f`: derivative = 2 is the variable itself"]),
        ),
        (
            FORCE,
            "valueReference=\"2\" causality=\"output\" derivative=\"0\"",
            Refused(&["`f`: derivative = 0 names `x` in `m`", "its own unit is `N`", "that of `x` per second"]),
        ),
        (
            DAMPING,
            "<Float64 derivative=\"77\" name=\"d\"",
            Runs(&["spring.fmu: variable `d`", "not used: derivative = 77"]),
        ),
        (DAMPING, "<Float64 min=\"1\" name=\"d\"", Runs(&["`d`, which is not used: start = 0", "at least 1 (min)"])),
        (
            "</ModelVariables>",
            "<Float64 name=\"g\" valueReference=\"2\"/></ModelVariables>",
            Runs(&["`g`, which is not used: valueReference = 2 is that of another variable"]),
        ),
        (
            "</ModelVariables>",
            "<Float64 name=\"f\" valueReference=\"22\"/></ModelVariables>",
            Refused(&["two variables have the name `f`"]),
        ),
        (
            "</ModelVariables>",
            "<Float64 name=\"g\" valueReference=\"22\"><Dimension start=\"4294967296\"/><Dimension \
             start=\"4294967296\"/></Float64></ModelVariables>",
            Runs(&["`g`, which is not used: <Dimension> [4294967296, 4294967296]", "at most 100000000 values"]),
        ),
        (
            "</ModelVariables>",
            "<Float64 name=\"g\" valueReference=\"22\" start=\"1 2\"><Dimension start=\"3\"/></Float64></ModelVariables>",
            Runs(&["`g`, which is not used: start = 1 2 is 2 values", "one value, or 3"]),
        ),
        (
            "<Output valueReference=\"2\"",
            "<Output valueReference=\"0\"",
            Runs(&["is `x` of causality input, and no output"]),
        ),
        ("<BaseUnit m=\"1\"/>", "<BaseUnit m=\"1\" mm=\"3\"/>", Runs(&["unit `m` has mm = 3, which is no base unit"])),
        ("<Unit name=\"m\">", "<Unit><BaseUnit/></Unit><Unit name=\"m\">", Refused(&["a <Unit> has no name"])),
        ("<Unit name=\"m\">", "<Unit name=\"N\"/><Unit name=\"m\">", Refused(&["two units have the name `N`"])),
        (
            "<ModelVariables><Float64 name=\"x\"",
            "<TypeDefinitions><Float64Type name=\"Way\" unit=\"m\" min=\"low\"/></TypeDefinitions><ModelVariables><Float64 \
             declaredType=\"Way\" name=\"x\"",
            Refused(&["variable `x`: its declared type `Way` has min = low"]),
        ),
        (
            "<ModelVariables><Float64 name=\"x\"",
            "<TypeDefinitions><Float64Type name=\"Way\" unit=\"m\" relativeQuantity=\"so\"/></TypeDefinitions><ModelVariables><Float64 \
             declaredType=\"Way\" name=\"x\"",
            Refused(&["its declared type `Way` has relativeQuantity = so"]),
        ),
        (
            "<ModelVariables>",
            "<TypeDefinitions><EnumerationType name=\"Kind\"><Item name=\"a\" value=\"one\"/></EnumerationType></TypeDefinitions>\
             <ModelVariables><Enumeration name=\"kind\" valueReference=\"13\" declaredType=\"Kind\"/>",
            Runs(&["`kind`, which is not used: its declared type `Kind` has <Item> value = one"]),
        ),
        (
            "<Float64 name=\"f\"",
            "<Int32 name=\"f\"",
            Refused(&["variable `f` is of type Int32", "Float64 (Real), Float32"]),
        ),
        ("<Float64 name=\"f\"", "<Float32 name=\"f\"", Runs(&["variable `f` is of type Float32", "seven digits"])),
        (
            TAKEN,
            "<Float32 name=\"x\" valueReference=\"0\" causality=\"input\"",
            Runs(&["variable `x` is of type Float32"]),
        ),
        (
            TAKEN,
            "<Float64 name=\"x\" valueReference=\"0\" causality=\"input\" variability=\"constant\"",
            Refused(&["variability = constant"]),
        ),
        (
            TAKEN,
            "<Float64 name=\"x\" valueReference=\"0\" causality=\"input\" initial=\"calculated\"",
            Refused(&["initial = calculated"]),
        ),
        (
            TAKEN,
            "<Float64 name=\"x\" valueReference=\"0\" causality=\"input\" max=\"high\"",
            Refused(&["max = high", "a number"]),
        ),
        (TAKEN, "<Float64 name=\"x\" valueReference=\"0\" causality=\"input\" max=\"0.5\" min=\"-0.1\"", Runs(&[])),
        (
            TAKEN,
            "<Float64 name=\"x\" valueReference=\"0\" causality=\"input\" max=\"0.05\"",
            Refused(&["input `x` = 0.1", "at most 0.05 (max)"]),
        ),
        (
            TAKEN,
            "<Float64 name=\"x\" valueReference=\"0\" causality=\"input\" min=\"0.0\"",
            Fails(&["input `x` = -", "at least 0 (min)"]),
        ),
    ] {
        let changes = [(from, to)];
        let faults: &[&str] = if to.contains("startTime=\"10\"") { &["START=10"] } else { &[] };
        // Only the reference of the mechanics' own would meet what an input comes to, were it judged by another.
        Guest { changes: &changes, faults, ..SPRING }.packed(&folder.path().join("spring.fmu")).unwrap();
        match then {
            Refused(words) => assert_has(&refused(folder.path()), &[words, &["spring.fmu"]].concat()),
            Runs(words) => {
                let (said, shown) = run(folder.path(), "--scheme zero-order-hold --trace trace.csv");
                assert_eq!(said["outcome"], "completed", "{to}: {said:#}");
                assert_has(&shown, words);
                assert!((traced(folder.path(), POSITION) - as_it_is).abs() < 1e-7, "{to}");
            }
            Fails(words) => {
                let shown = refused(folder.path());
                assert_has(&shown, &[words, &["spring.fmu", "has no reference"]].concat());
            }
        }
    }
    // In FMI 2.0 a type has an element of its own, and what is named is named by its place.
    for (from, to, words) in [
        ("<Real unit=\"N\"/>", "<Real unit=\"N\" min=\"low\"/>", "variable `f`: min = low"),
        ("<Real unit=\"N\"/>", "<Real unit=\"N\" start=\"1 2\"/>", "variable `f`: start = 1 2 is 2 values"),
        ("<Real unit=\"N\"/>", "<Real unit=\"N\" derivative=\"9\"/>", "variable `f`: derivative = 9 names no variable"),
        ("<Real unit=\"N\"/>", "<Real unit=\"N\" derivative=\"1\"/>", "variable `f`: derivative = 1 names `x` in `m`"),
        ("<Real unit=\"N\"/>", "<Integer/>", "variable `f` is of type Int32 (Integer"),
        ("dependencies=\"1 2\"", "dependencies=\"1 0\"", "<Unknown index=\"3\"> dependencies = 0 names no variable"),
        ("initial=\"calculated\"", "initial=\"calculated\" variability=\"tunable\"", ""),
    ] {
        let changes = [(from, to)];
        let version = 2;
        let spring = Guest { version, changes: &changes, ..SPRING };
        if !words.is_empty() {
            spring.packed(&folder.path().join("spring.fmu")).unwrap();
            assert_has(&refused(folder.path()), &["spring.fmu", words]);
        }
    }
}

#[test]
fn a_start_value_or_a_parameter_is_one_that_the_fmu_says_it_may_be() {
    let fixed = "causality=\"parameter\" variability=\"fixed\"";
    let kind = format!(
        "<Enumeration name=\"kind\" valueReference=\"13\" declaredType=\"Kind\" {fixed} start=\"1\"/></ModelVariables>"
    );
    let types = "<TypeDefinitions><EnumerationType name=\"Kind\"><Item name=\"a\" value=\"1\"/><Item name=\"b\" value=\"2\"/>\
                 </EnumerationType></TypeDefinitions><ModelVariables>";
    let changes = [
        ("</ModelVariables>", &*kind),
        ("<ModelVariables>", types),
        ("<Float64 name=\"d\"", "<Float64 min=\"0\" max=\"10\" name=\"d\""),
    ];
    let spring = Guest { changes: &changes, faults: &["ARRAYS"], ..SPRING };
    let Some(folder) = case(&MASS, &spring, &[]) else { return };
    let fmu = "fmu = \"spring.fmu\"";
    for (more, words) in [
        ("start = { kind = 2, d = 10.0 }", ""),
        ("start = { kind = 7 }", "variable `kind` = 7 is not valid; valid: an item of its enumeration, 1, 2"),
        ("start = { d = -1.0 }", "variable `d` = -1 is not valid; valid: at least 0 (min)"),
        ("start = { x = 0.2 }", "variable `x` is coupled and has a start value as well"),
        ("[parameters.x]\ndefault = 1.0\nactuator = \"x\"", "is coupled and has [parameters.x] as well"),
        (
            "[parameters.d]\ndefault = 11.0\nactuator = \"d\"",
            "`d` = 11 by [parameters.d] is not valid; valid: at most 10",
        ),
    ] {
        write_case(folder.path(), &[(fmu, &format!("{fmu}\n{more}"))]);
        if words.is_empty() {
            assert_eq!(run(folder.path(), "--scheme zero-order-hold").0["outcome"], "completed");
        } else {
            assert_has(
                &refused(folder.path()).replace("help: use ", "; valid: "),
                &["spring.fmu", &words.replace("; valid: ", "\n; valid: ")],
            );
        }
    }
}

#[test]
fn an_output_that_is_exact_begins_with_what_it_is_given() {
    for version in [2, 3] {
        let exact = [("initial=\"calculated\"", "initial=\"exact\"")];
        let mass = Guest { version, changes: &exact, ..MASS };
        let fmu = "fmu = \"mass.fmu\"";
        let Some(folder) = case(&mass, &SPRING, &[(fmu, &format!("{fmu}\nstart = {{ x = 0.2 }}"))]) else { return };
        let far = last(folder.path(), POSITION);
        write_case(folder.path(), &[]);
        // It is linear.
        assert!((far - 2.0 * last(folder.path(), POSITION)).abs() < 1e-12, "{version}");
    }
}

#[test]
fn instances_have_names_of_their_own_in_one_process_and_in_many_threads() {
    for version in [2, 3] {
        let mass = Guest { version, faults: &["UNIQUE_NAME"], ..MASS };
        let same = [("micro_step_s", "process = \"same\"\nmicro_step_s")];
        let Some(folder) = case(&mass, &SPRING, &same) else { return };
        let sweep = "question = \"?\"\nmacro_steps_s = [1e-3, 2e-3, 4e-3]\nphases = 4\n[[cases]]\nfile = \"case.toml\"\n[[schemes]]\nscheme = \
                     \"zero-order-hold\"\n";
        fs::write(folder.path().join("sweep.toml"), sweep).unwrap();
        let output = inside(folder.path()).args(["run", "sweep.toml", "--out", "out", "--jobs", "4"]).output().unwrap();
        let shown = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{shown}");
        let rows = fs::read_to_string(folder.path().join("out/runs.csv")).unwrap();
        assert_eq!(rows.matches(",completed,").count(), 12, "{rows}");
    }
}

#[test]
fn an_fmu_that_calls_exit_in_our_process_ends_it_with_a_message_and_no_success() {
    for version in [2, 3] {
        let spring = Guest { version, faults: &["EXIT_AT=0.15"], ..SPRING };
        let same = [("micro_step_s", "process = \"same\"\nmicro_step_s"), ("duration_s = 0.2", "duration_s = 0.1")];
        let Some(folder) = case(&MASS, &spring, &same) else { return };
        let sweep = |duration: &str| {
            format!(
                "question = \"?\"\nmacro_steps_s = [1e-3, 2e-3]\nduration_s = {duration}\n[[cases]]\nfile = \"case.toml\"\n[[schemes]]\nscheme = \
                 \"zero-order-hold\"\n"
            )
        };
        let ran = |file: &str, text: &str| {
            fs::write(folder.path().join(file), text).unwrap();
            let output = inside(folder.path()).args(["run", file, "--out", "out", "--jobs", "1"]).output().unwrap();
            (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
        };
        assert_eq!(ran("sweep.toml", &sweep("0.1")).0, Some(0));
        let before = records(folder.path());
        let longer = sweep("0.1") + "duration_s = 0.2\n";
        let (code, shown) = ran("sweep.toml", &longer);
        assert_eq!(code, Some(1), "{shown}");
        assert_has(&shown, &["spring.fmu: the FMU of the actuator ended this program", "process = \"own\""]);
        // Rows that were there still are.
        assert!(before.iter().all(|row| records(folder.path()).contains(row)) && before.len() > 1);
        // In a process of its own it is one that failed.
        write_case(folder.path(), &[]);
        assert_has(&refused(folder.path()), &["spring.fmu: its process ended (exit status: 0)"]);
    }
}

/// The lines of what a folder of results has recorded.
pub fn records(folder: &Path) -> Vec<String> {
    let files = crate::program::files(&folder.join("out/records"));
    files
        .iter()
        .flat_map(|file| fs::read_to_string(file).unwrap_or_default().lines().map(str::to_owned).collect::<Vec<_>>())
        .collect()
}

#[test]
fn where_an_fmu_fails_without_a_word_its_log_is_named() {
    for version in [2, 3] {
        for (faults, words) in
            [(&["SILENT_AT=0.1"], "DoStep returned Error"), (&["NO_INSTANCE"], "no instance can be made")]
        {
            let Some(folder) = case(&Guest { version, faults, ..MASS }, &SPRING, &[]) else { return };
            assert_has(&refused(folder.path()), &["mass.fmu", words, "it does not say why; `log = true`"]);
            write_case(folder.path(), &[("fmu = \"mass.fmu\"", "fmu = \"mass.fmu\"\nlog = true")]);
            let shown = refused(folder.path());
            assert!(shown.contains("it does not say why") && !shown.contains("`log = true`"), "{shown}");
        }
    }
}

#[test]
fn lines_of_a_log_stay_lines_when_several_workers_write() {
    let Some(folder) = case(&Guest { faults: &["WARNS_AT=0.02"], ..MASS }, &SPRING, &[]) else { return };
    write_case(folder.path(), &[("fmu = \"mass.fmu\"", "fmu = \"mass.fmu\"\nlog = true")]);
    let sweep = "question = \"?\"\nmacro_steps_s = [1e-3]\nphases = 8\n[[cases]]\nfile = \"case.toml\"\n[[schemes]]\nscheme = \
                 \"zero-order-hold\"\n";
    fs::write(folder.path().join("sweep.toml"), sweep).unwrap();
    let output = inside(folder.path()).args(["run", "sweep.toml", "--out", "out", "--jobs", "8"]).output().unwrap();
    let shown = String::from_utf8_lossy(&output.stderr).into_owned();
    let lines: Vec<&str> = shown.lines().filter(|line| line.contains("step refused")).collect();
    assert!(lines.len() > 1000, "{}: {shown}", lines.len());
    let whole = |line: &&&str| {
        line.starts_with("mass.fmu: step refused at t = ") && line.ends_with(": not the time that was expected")
            || line.starts_with("warning: mass.fmu returned Warning: ")
    };
    let torn: Vec<&&str> = lines.iter().filter(|line| !whole(line)).collect();
    assert!(torn.is_empty(), "{} of {}: {:?}", torn.len(), lines.len(), torn.first());
}

#[test]
fn a_case_file_is_found_by_a_link_and_what_is_none_says_what_one_is() {
    let Some(folder) = case(&MASS, &SPRING, &[]) else { return };
    let path = |name: &str| folder.path().join(name);
    let as_it_is = last(folder.path(), POSITION);
    // What a link names is beside the file, and an experiment finds its case file likewise.
    fs::create_dir(path("deep")).unwrap();
    for name in ["mass.fmu", "spring.fmu", "case.toml"] {
        fs::rename(path(name), path("deep").join(name)).unwrap();
    }
    std::os::unix::fs::symlink("deep/case.toml", path("case.toml")).unwrap();
    assert_eq!(last(folder.path(), POSITION), as_it_is);
    let sweep = "question = \"?\"\nmacro_steps_s = [1e-3]\n[[cases]]\nfile = \"case.toml\"\n[[schemes]]\nscheme = \"zero-order-hold\"\n\
                 [[claims]]\nid = \"it-runs\"\nby = \"ours\"\ntext = \"it runs\"\nscheme = \"zero-order-hold\"\nmetric = \"completed\"\n\
                 statistic = \"mean\"\nexpect = \">= 1\"\nfinding = \"reproduced\"\n";
    fs::write(path("deep/sweep.toml"), sweep).unwrap();
    std::os::unix::fs::symlink("deep/sweep.toml", path("linked.toml")).unwrap();
    let call = |arguments: &str| {
        let output = inside(folder.path()).args(arguments.split_whitespace()).output().unwrap();
        let [said, shown] = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
        (output.status.code(), said + &shown)
    };
    let results = format!("results/{}", folder.path().file_name().unwrap().to_str().unwrap());
    for (arguments, words) in [
        ("run linked.toml --out away/of/it".to_owned(), "1 of 1 runs stored"),
        ("report away/of/it".to_owned(), "report.html"),
        (format!("run linked.toml --out {results}/linked"), "1 of 1 runs stored"),
        (format!("report {results}/linked"), "report.html"),
        (format!("verify {}", path("linked.toml").display()), "1 claim: every verdict is the recorded one"),
        ("list parameters --case case.toml".to_owned(), "fmu_digest"),
    ] {
        let (code, said) = call(&arguments);
        assert_eq!(code, Some(0), "{arguments}: {said}");
        assert!(said.contains(words) && !said.contains("are not checked"), "{arguments}: {said}");
    }
    // Another FMU cannot be made of it.
    let (code, said) = call("fmu --case case.toml --side mechanics --out again.fmu");
    assert!(code == Some(2) && said.contains("come from outside") && !path("again.fmu").exists(), "{said}");
    // The same file by the option is the same case.
    assert_eq!(call("--case-file case.toml run linked.toml --out away/of/it").0, Some(0));
    for (text, words) in [
        ("file = \"case.toml\"\nname = \"other\"", &["`other`", "pair, as the file has it"] as &[&str]),
        ("file = \"none.toml\"", &["none.toml", "cannot be read"]),
        ("name = \"pair\"", &["unknown case `pair`"]),
        ("set = { a = 1.0 }", &["name = nothing", "file = \"….toml\""]),
        ("file = \"case.toml\"\n[[cases]]\nfile = \"twin.toml\"", &["another case of that name", "line 3"]),
    ] {
        let twin = fs::read_to_string(path("deep/case.toml")).unwrap().replace("duration_s = 0.2", "duration_s = 0.1");
        fs::write(path("deep/twin.toml"), twin).unwrap();
        fs::write(path("deep/odd.toml"), sweep.replace("file = \"case.toml\"", text)).unwrap();
        let (code, said) = call("run deep/odd.toml --out odd");
        assert_eq!(code, Some(2), "{text}: {said}");
        assert_has(&said, words);
    }
    for (name, words) in [
        ("x.ssp", "an archive of SSP"),
        ("System.SSD", "a system of SSP"),
        ("deep/mass.fmu", "an FMU"),
        ("a.py", "Python"),
    ] {
        if !name.contains('/') {
            fs::write(path(name), "PK").unwrap();
        }
        for arguments in [
            "simulate --scheme zero-order-hold --case",
            "limit --scheme zero-order-hold --case",
            "list cases --case-file",
        ] {
            let (code, said) = call(&format!("{arguments} {name}"));
            assert_eq!(code, Some(2), "{said}");
            assert_has(&said, &[name, words, "no case file", "names two FMUs"]);
        }
    }
    // It is said where what is missing was looked for.
    fs::remove_file(path("deep/mass.fmu")).unwrap();
    let shown = refused(folder.path());
    assert_has(&shown, &["mass.fmu: cannot be read: it is not in", "deep, where [mechanics] of case.toml names it"]);
}
