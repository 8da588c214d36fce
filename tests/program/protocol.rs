//! Programs in any language: the page's own examples have the digits of what is built in, and a program that fails costs one run.

use crate::program::rimbench;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// Says whether there is a Python to run programs with; where there is none, these tests have nothing to test.
fn no_python() -> bool {
    let there = Command::new("python3").arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    let missing = !there.is_ok_and(|status| status.success());
    if missing {
        eprintln!("skipped: there is no python3 on the path");
    }
    missing
}

/// Blocks of the page in one language, in order.
fn blocks(language: &str) -> Vec<String> {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/guide/protocol.md");
    let page = fs::read_to_string(page).unwrap();
    let opening = format!("```{language}\n");
    page.split(&opening).skip(1).map(|rest| rest.split("```").next().unwrap().to_owned()).collect()
}

/// A folder with the programs of the page and the files that name them.
fn of_the_page() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let ([scheme, side], [scheme_file, case_file]) = (&blocks("python")[..], &blocks("toml")[..]) else {
        panic!("the page has other blocks than it had")
    };
    // The page promises as much.
    assert!(scheme.lines().count() < 60 && side.lines().count() < 60);
    write("extrapolate.py", scheme);
    write("mass.py", side);
    write("linear.toml", scheme_file);
    let hold = scheme_file.replace("linear-in-python", "hold-in-python").replace("\"1\"]", "\"0\"]");
    write("hold.toml", &hold);
    write("mass.toml", case_file);
    folder
}

fn path(folder: &TempDir, name: &str) -> String {
    folder.path().join(name).to_str().unwrap().to_owned()
}

/// One run, with what it says and its trace.
fn run(arguments: &[&str]) -> (Value, String) {
    let folder = tempfile::tempdir().unwrap();
    let trace = folder.path().join("trace.csv");
    let output = rimbench()
        .args(["simulate", "--format", "json", "--trace"])
        .arg(&trace)
        .args(arguments)
        .assert()
        .success()
        .get_output()
        .stdout
        .clone();
    (serde_json::from_slice(&output).unwrap(), fs::read_to_string(trace).unwrap())
}

/// Columns of a trace, cells as they stand there.
fn columns(trace: &str) -> Vec<Vec<&str>> {
    let rows: Vec<Vec<&str>> = trace.lines().map(|line| line.split(',').collect()).collect();
    (0..rows[0].len()).map(|column| rows.iter().map(|row| row[column]).collect()).collect()
}

#[test]
fn the_scheme_of_the_page_has_the_digits_of_the_built_in_holds() {
    if no_python() {
        return;
    }
    let folder = of_the_page();
    for (file, built_in) in [("hold.toml", "zero-order-hold"), ("linear.toml", "first-order-hold")] {
        let file = path(&folder, file);
        // Sides that hold and sides that integrate polynomials; micro steps; all three sequences; steps that are taken again.
        for more in [
            &["--case", "bouncing-ball", "--duration", "0.5", "--macro-step", "2e-3", "--micro-step", "5e-4"]
                as &[&str],
            &["--case", "linear-oscillator", "--duration", "0.2", "--macro-step", "1e-3", "--phase", "0.3"],
            &["--case", "linear-oscillator", "--duration", "0.1", "--sequence", "gauss-seidel-mechanics-first"],
            &["--case", "wedge-box", "--duration", "0.05", "--macro-step", "1e-3", "--force-return", "mean"],
        ] {
            let (own, own_trace) = run(&[&["--scheme", &file], more].concat());
            let (known, trace) = run(&[&["--scheme", built_in], more].concat());
            assert!(own_trace == trace, "{file} {more:?}");
            assert!(trace.lines().count() > 20, "{more:?}");
            assert_eq!(own["outcome"], "completed", "{own:#}");
            assert_eq!(own["position_error_rms_m"], known["position_error_rms_m"]);
            assert_ne!(own["run_id"], known["run_id"]);
            // One exchange per macro step, two where the mechanics goes first.
            let exchanges = own["program_exchanges"].as_object().unwrap().values().next().unwrap();
            let times = if more.contains(&"gauss-seidel-mechanics-first") { 2 } else { 1 };
            assert_eq!(
                exchanges["count"].as_u64(),
                known["macro_steps"].as_u64().map(|steps| times * steps),
                "{more:?}"
            );
            assert!(exchanges["p50_s"].as_f64().unwrap() <= exchanges["p99_s"].as_f64().unwrap());
            assert!(known.get("program_exchanges").is_none());
        }
    }
}

#[test]
fn the_side_of_the_page_has_the_digits_of_the_built_in_one() {
    if no_python() {
        return;
    }
    let folder = of_the_page();
    let file = path(&folder, "mass.toml");
    let more = ["--set", "integrator=semi-implicit-euler", "--set", "mass_2_kg=1.7", "--macro-step", "2e-3"];
    // The second takes steps again, on copies.
    for scheme in ["zero-order-hold", "iterated-quasi-newton"] {
        let run = |case: &str| run(&[&["--scheme", scheme, "--case", case, "--duration", "0.3"], &more[..]].concat());
        let ((own, own_trace), (known, trace)) = (run(&file), run("linear-oscillator"));
        let (own_columns, known_columns) = (columns(&own_trace), columns(&trace));
        for column in &own_columns {
            assert!(known_columns.contains(column), "{scheme}: {}", column[0]);
        }
        assert!(own_columns.len() > 4 && own_columns[0].len() > 100);
        assert_eq!(own["outcome"], "completed", "{own:#}");
        for metric in ["position_error_rms_m", "force_error_rms_n", "interface_residual_j"] {
            assert_eq!(own[metric], known[metric], "{scheme} {metric}");
            assert!(own[metric].as_f64().unwrap() != 0.0, "{metric}");
        }
    }
    // What it does not offer is said.
    let (skipped, _) = run(&["--scheme", "rim-smooth", "--case", &file, "--duration", "0.3"]);
    assert_eq!(skipped["outcome"], "skipped");
    assert!(skipped["reason"].as_str().unwrap().contains("offers no reduced interface model"), "{skipped:#}");
}

#[test]
fn a_program_that_is_edited_is_another_run() {
    if no_python() {
        return;
    }
    let folder = of_the_page();
    let id = |arguments: &[&str]| run(arguments).0["run_id"].as_str().unwrap().to_owned();
    let scheme = path(&folder, "hold.toml");
    let of_scheme = || id(&["--case", "linear-oscillator", "--duration", "0.01", "--scheme", &scheme]);
    let case = path(&folder, "mass.toml");
    let of_case = || id(&["--case", &case, "--duration", "0.01", "--scheme", "zero-order-hold"]);
    let before = [of_scheme(), of_case()];
    assert_eq!(before, [of_scheme(), of_case()]);
    for (name, file) in [("extrapolate.py", 0), ("mass.py", 1)] {
        let text = fs::read_to_string(folder.path().join(name)).unwrap();
        fs::write(folder.path().join(name), format!("# edited\n{text}")).unwrap();
        assert_ne!(before[file], [of_scheme(), of_case()][file]);
    }
}

#[test]
fn an_experiment_has_schemes_and_cases_that_are_programs_by_their_names() {
    if no_python() {
        return;
    }
    let folder = of_the_page();
    let sweep = "question = \"?\"\nmacro_steps_s = [1e-3, 2e-3]\nduration_s = 0.05\n[[cases]]\nname = \"mass-in-python\"\n\
                 [[cases]]\nname = \"linear-oscillator\"\n[[schemes]]\nscheme = \"hold-in-python\"\n[[schemes]]\nscheme = \"nepce\"\n";
    fs::write(folder.path().join("sweep.toml"), sweep).unwrap();
    let files = [path(&folder, "mass.toml"), path(&folder, "hold.toml"), path(&folder, "sweep.toml")];
    let output = rimbench()
        .args(["--case-file", &files[0], "--scheme-file", &files[1], "run", &files[2], "--out", &path(&folder, "out")])
        .assert()
        .success()
        .get_output()
        .stdout
        .clone();
    let said = String::from_utf8(output).unwrap();
    assert!(said.contains("8 of 8 runs stored") && said.contains("exchanges with `python3 mass.py`"), "{said}");
    let rows = fs::read_to_string(folder.path().join("out/runs.csv")).unwrap();
    assert_eq!(rows.matches("completed").count(), 8, "{rows}");
}

#[test]
fn an_advice_on_a_case_with_a_program_for_a_side_says_what_it_lacks() {
    if no_python() {
        return;
    }
    let folder = of_the_page();
    let case = path(&folder, "mass.toml");
    let limits = ["--from", "1e-2", "--to", "2e-2", "--per-decade", "2", "--phases", "1", "--kept-aside", "1"];
    let output = rimbench()
        .args(["advise", "--error", "5%", "--duration", "0.5", "--format", "json", "--case", &case])
        .args(["--scheme", "true-acceleration-linear"])
        .args(limits)
        .assert()
        .success()
        .get_output()
        .stdout
        .clone();
    // Lines of text know no derivatives, and no interface model comes of them.
    let advice: Value = serde_json::from_slice(&output).unwrap();
    assert!(advice["answer"].as_str().unwrap().starts_with("None: no scheme in any form"), "{advice}");
    let fallen = advice["fallen"].as_array().unwrap();
    let lacks = |fallen: &Value| fallen["reason"] == "skipped: the mechanics offers no reduced interface model";
    assert!(!fallen.is_empty() && fallen.iter().all(lacks), "{fallen:?}");
}

/// A scheme that is good until its fifth exchange, and a side that is good until its fifth step.
const FAULTY: &str = r#"
import json, os, subprocess, sys, time
fault, role = sys.argv[1], sys.argv[2]
count = 0
hello = {"protocol": "rimbench-line", "version": 1, "role": role}
for line in sys.stdin:
    q = json.loads(line)
    a = {}
    if q["ask"] == "hello":
        a = dict(hello) if role == "scheme" else {**hello, "inputs": q["inputs"], "outputs": q["outputs"]}
        if fault == "version": a["version"] = 2
        if fault == "role": a["role"] = "actuator"
        if fault == "no-hello": print("ready", flush=True); continue
        if fault == "slip": a["sampels"] = 1
        if fault == "names": a["outputs"] = [["x", "m"], ["v", "mm/s"]]
        if fault == "other":
            # Once in a folder it is this, once that.
            a["state"] = os.path.exists("once")
            open("once", "w").close()
        if fault in ("state", "wide"): a["state"] = True
        if fault == "hello-id": print(json.dumps(a), flush=True); continue
    elif q["ask"] == "begin":
        if fault == "begin": sys.exit("no licence")
        a = {"y": [0.0, -100.0]}
    elif q["ask"] == "state":
        if fault == "state": sys.exit("no room")
        # Longer than any number of a machine.
        a = {"state": {"generator": 2**127 + 1, "x": -0.0}}
    elif q["ask"] == "restore":
        if q["state"] != {"generator": 2**127 + 1, "x": -0.0}: a = {"error": f"this is not mine: {q['state']}"}
    else:
        count += 1
        if role == "scheme":
            a = {to: {"polynomials": [[y] for y in q[of]["y"]]} for to, of in (("mechanics", "actuator"), ("actuator", "mechanics"))}
        else:
            a = {"y": [0.0, -100.0]}
        a["id"] = q["id"]
        # What was said at the fifth comes once more, when the sixth is waited for, and the answer to that behind it.
        if fault == "late" and count == 5: before = a
        if fault == "late" and count == 6: print(json.dumps(before), flush=True)
        if fault == "behind" and count == 20: print(json.dumps(a), flush=True)
        if count == 5:
            if fault == "crash": raise ValueError("lost my way")
            if fault == "killed": os.kill(os.getpid(), 9)
            if fault == "leaves": sys.exit(0)
            if fault == "hang":
                child = subprocess.Popen(["sleep", "1000"])
                open("child", "w").write(str(child.pid))
                time.sleep(1000)
            if fault == "half": sys.stdout.write('{"mechanics"'); sys.stdout.flush(); time.sleep(1000)
            if fault == "text": print("step 5 is done", flush=True); continue
            if fault == "twice": print(json.dumps(a), flush=True)
            if fault == "closes": os.close(1); time.sleep(1000)
            if fault == "words": a = {"error": "the pump is dry"}
            if fault == "nothing": a = {}
            if fault == "list": a = []
            if fault == "no-id": del a["id"]; print(json.dumps(a), flush=True); continue
            if fault == "id-text": a["id"] = str(a["id"]); print(json.dumps(a), flush=True); continue
            if fault == "endless":
                for _ in range(200): sys.stderr.write("x" * 1000000)
                sys.exit(3)
            if fault == "key": a["polynomial"] = 1
            for name, bad in (("nan", float("nan")), ("inf", float("inf"))):
                if fault == name: a = json.loads(json.dumps(a).replace("-100.0", str(bad)) .replace("nan", "NaN").replace("inf", "Infinity")) if role != "scheme" else {**a, "mechanics": {"polynomials": [[bad]]}}
            if fault == "huge": print(json.dumps(a).replace("[[", "[[1e999, ", 1).replace('"y": [', '"y": [1e999, '), flush=True); continue
            if fault == "sizes": a = {**a, "mechanics": {"polynomials": [[1.0], [2.0]]}} if role == "scheme" else {"y": [1.0]}
            if fault == "powers": a["mechanics"] = {"polynomials": [[1.0, 2.0, 3.0, 4.0, 5.0]]}
            if fault == "pieces": a["mechanics"] = {"pieces": []}
            if fault == "both": a["mechanics"] = {"pieces": [[1.0]], "polynomials": [[1.0]]}
    if isinstance(a, dict): a["id"] = q["id"]
    try:
        print(json.dumps(a), flush=True)
    except OSError:
        pass
"#;

/// A folder with that program, and the file that names it.
fn faulty(fault: &str, role: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("faulty.py"), FAULTY).unwrap();
    let command = format!("command = [\"python3\", \"faulty.py\", \"{fault}\", \"{role}\"]\n");
    let patience = if ["hang", "half"].contains(&fault) { "answer_within_s = 0.5\n" } else { "" };
    let text = match role {
        "scheme" => format!("name = \"faulty\"\n{command}{patience}"),
        _ => format!(
            "name = \"faulty\"\nlike = \"linear-oscillator\"\nreference = \"original\"\n{patience}[{role}]\n{command}"
        ),
    };
    let file = folder.path().join("faulty.toml");
    fs::write(&file, text).unwrap();
    (folder, file)
}

fn arguments<'a>(role: &str, file: &'a Path) -> Vec<&'a str> {
    let file = file.to_str().unwrap();
    let (case, scheme) = if role == "scheme" { ("linear-oscillator", file) } else { (file, "zero-order-hold") };
    vec!["--case", case, "--scheme", scheme, "--duration", "0.02", "--macro-step", "1e-3", "--micro-step", "1e-3"]
}

#[test]
fn a_program_that_fails_costs_one_run_and_says_why() {
    if no_python() {
        return;
    }
    for (fault, role, words) in [
        ("crash", "scheme", &["ended at `inputs` (exit status: 1)"] as &[&str]),
        ("crash", "mechanics", &["ended at `step` (exit status: 1)"]),
        ("killed", "scheme", &["signal: 9"]),
        ("leaves", "scheme", &["ended at `inputs`", "exit status: 0"]),
        ("hang", "mechanics", &["no answer to `step` within 0.5 s"]),
        ("half", "scheme", &["no answer to `inputs` within 0.5 s"]),
        ("closes", "scheme", &["no longer answers `inputs`"]),
        ("text", "scheme", &["is wrong: no line of JSON: ", "it said: step 5 is done"]),
        // Whichever of both is seen first.
        ("twice", "mechanics", &["answer to `step` is wrong"]),
        ("late", "scheme", &["`id` is 7; valid: 8, that of the request", "it said: {"]),
        ("late", "mechanics", &["`id` is 7; valid: 8, that of the request"]),
        ("no-id", "scheme", &["`id` is missing; valid: 7"]),
        ("id-text", "mechanics", &["invalid type: string \"7\""]),
        ("endless", "scheme", &["ended at `inputs` (exit status: 3)"]),
        ("words", "mechanics", &["refuses `step`: the pump is dry"]),
        ("nothing", "scheme", &["`mechanics` is missing"]),
        ("nothing", "mechanics", &["`y` is missing"]),
        ("list", "scheme", &["answer to `inputs` is wrong: it is no object of JSON", "it said: []"]),
        ("key", "scheme", &["unknown field `polynomial`"]),
        ("nan", "scheme", &["no line of JSON", "JSON has finite numbers only", "NaN"]),
        ("inf", "mechanics", &["no line of JSON", "JSON has finite numbers only", "Infinity"]),
        ("huge", "mechanics", &["number out of range"]),
        ("sizes", "scheme", &["2 `polynomials` of the mechanics instead of 1"]),
        ("sizes", "mechanics", &["`y` has 1 numbers instead of 2"]),
        ("powers", "scheme", &["5 coefficients in a polynomial of the mechanics", "valid: 1 to 4"]),
        ("pieces", "scheme", &["0 `pieces` of the mechanics"]),
        ("both", "scheme", &["either `polynomials` or `pieces`"]),
        ("begin", "scheme", &["ended at `begin` (exit status: 1)"]),
    ] {
        let (folder, file) = faulty(fault, role);
        let (said, _) = run(&arguments(role, &file));
        assert_eq!(said["outcome"], "subsystem-failed", "{fault} {role}: {said:#}");
        let reason = said["reason"].as_str().unwrap();
        assert!(
            words.iter().chain(&["python3 faulty.py"]).all(|word| reason.contains(word)),
            "{fault} {role}: {reason}"
        );
        assert!(!reason.contains('\n'), "{reason}");
        // Of what it printed nothing is recorded.
        let printed = ["Traceback", "ValueError", "no licence", "xxx"];
        assert!(!printed.iter().any(|word| reason.contains(word)), "{reason}");
        // What it had started has ended with it.
        if fault == "hang" {
            let child = fs::read_to_string(folder.path().join("child")).unwrap();
            let there = Command::new("ps").args(["-o", "stat=", "-p", &child]).output().unwrap();
            let state = String::from_utf8(there.stdout).unwrap();
            // Whose parent is gone is buried by whoever is the first process here, sooner or later.
            assert!(state.trim().is_empty() || state.starts_with('Z'), "{state}");
        }
    }
}

#[test]
fn what_a_program_prints_is_shown_and_not_recorded() {
    if no_python() {
        return;
    }
    for (fault, role, words) in [
        ("crash", "scheme", "` printed:\n  Traceback (most recent call last):\n"),
        ("crash", "mechanics", "\n  ValueError: lost my way\n"),
        ("begin", "scheme", "`python3 faulty.py begin scheme` printed:\n  no licence\n"),
        ("behind", "scheme", "`python3 faulty.py behind scheme` said more than it was asked: {"),
    ] {
        let (_folder, file) = faulty(fault, role);
        let output = rimbench().arg("simulate").args(arguments(role, &file)).assert().success().get_output().clone();
        let (said, shown) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
        assert!(shown.contains(words), "{fault} {role}: {shown}");
        // What is said behind the last reply comes too late to change anything.
        assert_eq!(said.contains("subsystem-failed"), fault != "behind", "{said}");
        assert!(!said.contains("Traceback") && !said.contains("no licence"), "{said}");
    }
}

#[test]
fn a_state_comes_back_as_it_was_said_and_one_that_is_not_given_is_a_failure() {
    if no_python() {
        return;
    }
    let doubling = ["--step-control", "step-doubling", "--step-tolerance", "1e-3"];
    for (fault, role, outcome) in [
        ("wide", "scheme", "completed"),
        ("state", "scheme", "subsystem-failed"),
        ("state", "mechanics", "subsystem-failed"),
    ] {
        let (_folder, file) = faulty(fault, role);
        let (said, _) = run(&[&arguments(role, &file)[..], &doubling[..]].concat());
        assert_eq!(said["outcome"], outcome, "{role}: {said:#}");
        if fault == "state" {
            let reason = said["reason"].as_str().unwrap();
            assert!(reason.contains("ended at `state` (exit status: 1)"), "{reason}");
        }
    }
}

#[test]
fn what_is_wrong_with_a_program_from_the_start_is_one_error_with_its_file() {
    if no_python() {
        return;
    }
    let refused = |role: &str, file: &Path| {
        let output = rimbench().arg("simulate").args(arguments(role, file)).assert().code(2).get_output().clone();
        let message = String::from_utf8(output.stderr).unwrap();
        // What the program printed stands before the error.
        let (printed, error) = message.split_at(message.find("error: ").unwrap());
        assert!(output.stdout.is_empty() && error.trim_end().lines().count() == 1, "{message}");
        assert!(printed.is_empty() || printed.contains(" printed:\n"), "{message}");
        assert!(error.contains("faulty.toml"), "{message}");
        message
    };
    for (fault, role, words) in [
        ("version", "scheme", &["`version` is 2; valid: 1"] as &[&str]),
        ("version", "mechanics", &["[mechanics]", "`version` is 2; valid: 1"]),
        ("role", "scheme", &["`role` is \"actuator\"; valid: \"scheme\""]),
        ("no-hello", "scheme", &["no line of JSON", "it said: ready"]),
        ("hello-id", "scheme", &["answer to `hello` is wrong: `id` is missing; valid: 1"]),
        ("slip", "scheme", &["unknown field `sampels`", "`samples`"]),
        (
            "names",
            "mechanics",
            &["`outputs` = [[\"x\", \"m\"], [\"v\", \"mm/s\"]]", "valid: [[\"x2_m\", \"m\"], [\"v2_m_s\", \"m/s\"]]"],
        ),
        ("begin", "mechanics", &["ended at `begin`", "no licence"]),
        ("other", "mechanics", &["describes itself otherwise than before"]),
    ] {
        let (_folder, file) = faulty(fault, role);
        let message = refused(role, &file);
        assert!(words.iter().all(|word| message.contains(word)), "{fault} {role}: {message}");
    }
    let (_folder, file) = faulty("none", "scheme");
    let good = fs::read_to_string(&file).unwrap();
    for (from, to, words) in [
        ("\"python3\"", "\"no-such-program\"", "`no-such-program faulty.py none scheme` cannot be started"),
        ("\"python3\"", "\"./faulty.sh\"", "cannot be started"),
        ("[\"python3\", \"faulty.py\", \"none\", \"scheme\"]", "[]", "command has no words"),
        ("name = \"faulty\"", "name = \"Faulty\"", "kebab-case"),
        ("name = \"faulty\"", "name = \"nepce\"", "not taken yet"),
        ("name = \"faulty\"", "name = \"faulty\"\nfiles = [\"none.py\"]", "none.py: cannot be read"),
        ("name = \"faulty\"", "name = \"faulty\"\nfiles = [\"/dev/zero\"]", "/dev/zero: is no regular file"),
        ("name = \"faulty\"", "name = \"faulty\"\nanswer_within_s = 0", "answer_within_s = 0 is not valid"),
        ("name = \"faulty\"", "name = \"faulty\"\ncomand = 1", "unknown field `comand`"),
    ] {
        fs::write(&file, good.replace(from, to)).unwrap();
        let output = rimbench().arg("simulate").args(arguments("scheme", &file)).assert().code(2).get_output().clone();
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains(words) && message.trim_end().lines().count() == 1, "{to}: {message}");
    }
    let (_folder, file) = faulty("none", "mechanics");
    let good = fs::read_to_string(&file).unwrap();
    for (from, to, words) in [
        ("like = \"linear-oscillator\"", "like = \"linear-oscilator\"", "did you mean `linear-oscillator`"),
        ("like = \"linear-oscillator\"\nreference", "reference", "reference is said of a case that is `like` another"),
        ("like = \"linear-oscillator\"\nreference = \"original\"\n", "", "has no `duration_s`"),
        ("[mechanics]", "[mechanics]\nobserve = [\"x\"]", "no `observe`"),
        ("[mechanics]", "[mechanics]\nfmu = \"x.fmu\"", "no `fmu`"),
        ("[mechanics]", "[parameters.mass_2_kg]\ndefault = 1.0\n[mechanics]", "has a parameter of that name"),
        ("[mechanics]", "[mechanics]\nstart = { a = nan }", "start of [mechanics]: a"),
        ("[mechanics]", "[parameters.program_digest]\ndefault = 1.0\n[mechanics]", "is taken"),
    ] {
        fs::write(&file, good.replace(from, to)).unwrap();
        let message = refused("mechanics", &file);
        assert!(message.contains(words), "{to}: {message}");
    }
}

/// A scheme that says what it holds in pieces, or asks for all that there is to know and holds.
const KNOWS: &str = r#"
import json, sys
for line in sys.stdin:
    q = json.loads(line)
    a = {}
    if q["ask"] == "hello":
        a = {"protocol": "rimbench-line", "version": 1, "role": "scheme"}
        if sys.argv[1] == "all": a["needs"] = ["interface_model", "rates", "force_displacement"]
    elif q["ask"] == "inputs":
        y = {side: q[side]["y"] for side in ("mechanics", "actuator")}
        if sys.argv[1] == "all":
            model, rates, h = q["mechanics"]["interface_model"], q["actuator"]["rates"], q["step"]["length_s"]
            assert model["position"] + model["w"] == y["mechanics"], (model, y)
            assert [len(row) for row in model["H"]] == [1] and model["H"][0][0] > 0 and len(model["a"]) == 1, model
            assert (model["gap"], model["closed"]) == ([], []) and 0 < model["mechanics_step_s"] <= h, model
            assert [len(rates[name]) for name in ("rate", "feedthrough", "rate_gain")] == [1, 2, 2], rates
            assert rates["feedthrough"][0] < 0, rates
        parts = q["step"]["actuator_steps"]
        a = {to: {"pieces": [y[of]] * parts} for to, of in (("mechanics", "actuator"), ("actuator", "mechanics"))}
    a["id"] = q["id"]
    print(json.dumps(a), flush=True)
"#;

#[test]
fn pieces_models_and_rates_are_said_as_they_are() {
    if no_python() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("knows.py"), KNOWS).unwrap();
    let more = ["--case", "linear-oscillator", "--duration", "0.1", "--macro-step", "2e-3", "--micro-step", "5e-4"];
    let (_, held) = run(&[&["--scheme", "zero-order-hold"], &more[..]].concat());
    for what in ["pieces", "all"] {
        let text = format!("name = \"knows\"\ncommand = [\"python3\", \"knows.py\", \"{what}\"]\n");
        fs::write(folder.path().join("knows.toml"), text).unwrap();
        let (said, trace) = run(&[&["--scheme", &path(&folder, "knows.toml")], &more[..]].concat());
        assert_eq!(said["outcome"], "completed", "{said:#}");
        assert!(trace == held, "{what}");
        assert!(trace.lines().count() > 40);
    }
}

/// The two masses of a small case: one that gives its interface model, and a spring with its rates.
const MASS: &str = r#"
import json, sys
M, K = 2.0, 50.0
for line in sys.stdin:
    q = json.loads(line)
    a = {}
    if q["ask"] == "hello":
        a = {"protocol": "rimbench-line", "version": 1, "role": "mechanics", "inputs": q["inputs"], "outputs": q["outputs"]}
        a |= {"interface_model": {"contacts": 0}, "state": True}
    elif q["ask"] == "begin":
        x, v = 0.01, -0.0
        a = {"y": [x, v]}
    elif q["ask"] == "step":
        v += q["length_s"] * (q["u"][0] - K * x) / M
        x += q["length_s"] * v
        a = {"y": [x, v]}
    elif q["ask"] == "interface_model":
        a = {"H": [[1 / M]], "a": [-K * x / M], "w": [v], "position": [x]}
    elif q["ask"] == "state":
        a = {"state": [x, v]}
    elif q["ask"] == "restore":
        x, v = q["state"]
    print(json.dumps(a | {"id": q["id"]}), flush=True)
"#;

const SPRING: &str = r#"
import json, math, sys
K, C = 400.0, 3.0
seen = 0
for line in sys.stdin:
    q = json.loads(line)
    a = {}
    if q["ask"] == "hello":
        a = {"protocol": "rimbench-line", "version": 1, "role": "actuator", "inputs": q["inputs"], "outputs": q["outputs"]}
        a |= {"direct_feedthrough": True, "rates": True, "state": True}
    elif q["ask"] in ("outputs", "step"):
        # The sign of a velocity that is nothing comes over as it is.
        if seen == 0 and math.copysign(1.0, q["u"][1]) > 0: a = {"error": f"the first velocity is {q['u'][1]}"}
        else: a = {"y": [-K * q["u"][0] - C * q["u"][1]]}
        seen += 1
    elif q["ask"] == "rates":
        a = {"rate": [0.0], "feedthrough": [-K, -C], "rate_gain": [0.0, 0.0]}
    elif q["ask"] == "state":
        a = {"state": [seen]}
    print(json.dumps(a | {"id": q["id"]}), flush=True)
"#;

#[test]
fn a_side_with_an_interface_model_and_one_with_rates_run_schemes_that_ask_for_them() {
    if no_python() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("mass.py"), MASS).unwrap();
    fs::write(folder.path().join("spring.py"), SPRING).unwrap();
    let ends = "position = \"x\"\nvelocity = \"v\"\nforce = \"f\"\n";
    let text = format!(
        "name = \"two-programs\"\nduration_s = 0.5\nmacro_step_s = 1e-2\nmicro_step_s = 1e-3\n[mechanics]\ncommand = [\"python3\", \
         \"mass.py\"]\n[actuator]\ncommand = [\"python3\", \"spring.py\"]\n[[interface]]\n[interface.mechanics]\n{ends}\
         [interface.actuator]\n{ends}"
    );
    fs::write(folder.path().join("case.toml"), text).unwrap();
    let case = path(&folder, "case.toml");
    let error = |scheme: &str| {
        let (said, trace) = run(&["--case", &case, "--scheme", scheme, "--mechanics-steps", "all"]);
        assert_eq!(said["outcome"], "completed", "{scheme}: {said:#}");
        assert!(trace.lines().nth(1).unwrap().contains(",-0.0,"), "{trace}");
        said["position_error_rms_m"].as_f64().unwrap()
    };
    let held = error("zero-order-hold");
    for scheme in ["rim-smooth", "rim-nonsmooth-gap", "interface-jacobian"] {
        assert!(error(scheme) < 0.3 * held, "{scheme}: {} against {held}", error(scheme));
    }
    let (skipped, _) = run(&["--case", &case, "--scheme", "rim-smooth", "--model-motion", "piecewise"]);
    assert_eq!(skipped["outcome"], "skipped", "{skipped:#}");
    assert!(skipped["reason"].as_str().unwrap().contains("does not say where its geometry has kinks"), "{skipped:#}");
}

/// Files as they stand in a page, and slips in them, against the schema that the program prints.
#[test]
fn the_files_of_the_pages_keep_to_their_schemas_and_slips_do_not() {
    let validator = |kind: &str| {
        let said = rimbench().args(["schema", kind]).assert().success().get_output().stdout.clone();
        jsonschema::draft202012::new(&serde_json::from_slice(&said).unwrap()).unwrap()
    };
    let read = |text: &str| serde_json::to_value(toml::from_str::<toml::Value>(text).unwrap()).unwrap();
    let (scheme, case) = (validator("scheme"), validator("case"));
    let [scheme_file, case_file] = &blocks("toml")[..] else { panic!("the page has other blocks than it had") };
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/guide/fmi.md")).unwrap();
    let fmus = page.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    assert!(scheme.is_valid(&read(scheme_file)) && case.is_valid(&read(case_file)));
    assert!(
        case.is_valid(&read(fmus)),
        "{:?}",
        case.iter_errors(&read(fmus)).map(|e| e.to_string()).collect::<Vec<_>>()
    );
    for (validator, text, from, to) in [
        (&scheme, scheme_file.as_str(), "command", "comand"),
        (&scheme, scheme_file, "linear-in-python", "Linear"),
        (&scheme, scheme_file, "10.0", "0.0"),
        (&scheme, scheme_file, "[\"python3\", \"extrapolate.py\", \"1\"]", "[]"),
        (&case, case_file, "linear-oscillator", "linear-oscilator"),
        (&case, case_file, "\"original\"", "\"mine\""),
        (&case, case_file, "like = ", "about = "),
        (&case, case_file, "command = ", "needs = "),
        (&case, fmus, "duration_s = 0.5", "duration_s = -0.5"),
        (&case, fmus, "macro_step_s = 1e-3", ""),
        (&case, fmus, "fmu = \"actuator.fmu\"", "fmu = \"actuator.fmu\"\ncommand = [\"x\"]"),
        (&case, fmus, "factor = 1.0", "factor = 0.0"),
        (&case, fmus, "factor = 1.0", "factor = 1.0, offset = 2.0"),
    ] {
        assert!(text.contains(from), "{from}");
        assert!(!validator.is_valid(&read(&text.replacen(from, to, 1))), "{from}");
    }
}
