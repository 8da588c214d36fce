//! FMUs that the program writes come back as cases with the same digits, and everything that can be wrong with a case of FMUs is said in
//! one line.

use crate::program::rimbench;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Read, Write};
use std::path::{Path, PathBuf};
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

/// A folder with both sides of a case as FMUs, `mechanics.fmu` and `actuator.fmu`.
fn exported(case: &str, more: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for side in ["mechanics", "actuator"] {
        let out = folder.path().join(format!("{side}.fmu"));
        rimbench().args(["fmu", "--case", case, "--side", side, "--out"]).arg(out).args(more).assert().success();
    }
    folder
}

/// What a case file says of two FMUs that have their coupling variables by the names of columns.
pub fn case_file(columns: [&str; 3], head: &str) -> String {
    let [position, velocity, force] = columns;
    let ends = format!("position = \"{position}\"\nvelocity = \"{velocity}\"\nforce = \"{force}\"\n");
    format!(
        "name = \"of-fmus\"\n{head}\n[mechanics]\nfmu = \"mechanics.fmu\"\n[actuator]\nfmu = \"actuator.fmu\"\n[[interface]]\n\
         columns = {columns:?}\n[interface.mechanics]\n{ends}[interface.actuator]\n{ends}"
    )
}

fn trace(folder: &Path, case: &str, arguments: &[&str]) -> BTreeMap<String, Vec<String>> {
    let file = folder.join("trace.csv");
    let mut command = rimbench();
    command.args(["simulate", "--case", case]).args(arguments).arg("--trace").arg(&file).assert().success();
    let mut reader = csv::Reader::from_path(&file).unwrap();
    let names = reader.headers().unwrap().clone();
    let mut columns: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for record in reader.records() {
        for (name, cell) in names.iter().zip(&record.unwrap()) {
            columns.entry(name.to_owned()).or_default().push(cell.to_owned());
        }
    }
    columns
}

/// Writes a case of FMUs, and compares its traces to those of the case that they were made from, to the letter.
fn compared(case: &str, columns: [&str; 3], head: &str, set: &[&str], runs: &[&[&str]]) {
    let folder = exported(case, set);
    let file = folder.path().join("case.toml");
    fs::write(&file, case_file(columns, head)).unwrap();
    for run in runs {
        let own: Vec<&str> = run.iter().chain(set).copied().collect();
        let (known, found) = (trace(folder.path(), case, &own), trace(folder.path(), file.to_str().unwrap(), run));
        assert_eq!(found.len(), 5, "{:?}", found.keys());
        for (name, cells) in &found {
            assert!(cells.len() > 20, "{case} {run:?}");
            assert_eq!(Some(cells), known.get(name), "{case} {run:?}: {name}");
        }
    }
}

const CYLINDER: [&str; 3] = ["actuator_length_m", "actuator_velocity_m_s", "actuator_force_n"];
pub const CARRIAGE: [&str; 3] = ["interface_position_m", "interface_velocity_m_s", "actuator_force_n"];

#[test]
fn a_wedge_box_that_was_written_as_fmus_has_the_digits_of_the_case_it_was_written_from() {
    let head = "duration_s = 0.2\nmacro_step_s = 2e-3\nmicro_step_s = 5e-5\nreference_step_s = 5e-5";
    let long = ["--duration", "0.2", "--macro-step", "2e-3", "--scheme"];
    let with = |scheme: &'static str| long.into_iter().chain([scheme]).collect::<Vec<_>>();
    let runs = ["zero-order-hold", "rim-nonsmooth-gap", "rim-smooth", "iterated-aitken"].map(with);
    compared("wedge-box", CYLINDER, head, &["--set", "box_mass_kg=210"], &runs.each_ref().map(Vec::as_slice));
    // What bounces is told from what the mechanics' own steps make.
    let bouncing = with("rim-nonsmooth-gap");
    compared("wedge-box", CYLINDER, head, &["--set", "restitution=0.5"], &[&bouncing]);
}

#[test]
fn friction_and_kinks_of_an_interface_model_come_through_the_fmu_to_the_bit() {
    let head = "duration_s = 0.3\nmacro_step_s = 2e-3\nmicro_step_s = 5e-5\nreference_step_s = 5e-5";
    let long = ["--duration", "0.3", "--macro-step", "2e-3", "--micro-step", "5e-5"];
    let with = |more: &[&'static str]| long.iter().chain(more).copied().collect::<Vec<_>>();
    let gap = with(&["--scheme", "rim-nonsmooth-gap"]);
    let frictional = [
        gap.clone(),
        with(&["--scheme", "rim-nonsmooth"]),
        with(&["--scheme", "rim-smooth-active"]),
        with(&["--scheme", "rim-nonsmooth-gap", "--model-motion", "extrapolated"]),
    ];
    let frictional: Vec<&[&str]> = frictional.iter().map(Vec::as_slice).collect();
    compared("wedge-box-friction", CYLINDER, head, &[], &frictional);
    // Contacts that bounce, along the surface as well; and a coefficient that is larger at rest.
    let bouncing = ["--set", "restitution=0.3", "--set", "tangential_restitution=0.3"];
    compared("wedge-box-friction", CYLINDER, head, &bouncing, &[&gap]);
    compared("towed-block", CARRIAGE, head, &[], &[&gap]);
    // A box that comes to the corner of its ledge within a macro step.
    let (head, long) =
        (head.replace("0.3", "0.6"), ["--duration", "0.6", "--macro-step", "2e-3", "--micro-step", "5e-5"]);
    let moving =
        |motion: &'static str| [&long[..], &["--scheme", "rim-nonsmooth-gap", "--model-motion", motion]].concat();
    compared("wedge-box", CYLINDER, &head, &[], &[&moving("piecewise")]);
    let folder = tempfile::tempdir().unwrap();
    let [frozen, piecewise] = ["frozen", "piecewise"].map(|motion| trace(folder.path(), "wedge-box", &moving(motion)));
    assert_ne!(frozen, piecewise, "no kink lies within this run");
    // What is the mechanics' own affair cannot be changed from outside, and that is said.
    let folder = exported("towed-block", &[]);
    let file = folder.path().join("case.toml");
    fs::write(&file, case_file(CARRIAGE, &head)).unwrap();
    let mut command = rimbench();
    command.args(["simulate", "--scheme", "rim-nonsmooth", "--friction-law", "box", "--case"]).arg(&file);
    let refused = String::from_utf8(command.assert().code(2).get_output().stderr.clone()).unwrap();
    assert!(refused.contains("friction_law = box: mechanics: what friction an FMU has is its own"), "{refused}");
}

#[test]
fn a_case_in_the_same_process_has_the_same_digits() {
    let head = "duration_s = 0.3\nmacro_step_s = 1e-3\nmicro_step_s = 5e-4\nprocess = \"same\"";
    let run: &[&str] = &["--scheme", "zero-order-hold", "--duration", "0.3", "--macro-step", "1e-3"];
    compared("bouncing-ball", CARRIAGE, head, &[], &[run]);
}

#[test]
fn an_fmu_that_refuses_a_step_is_quoted_with_its_file() {
    let folder = exported("wedge-box", &[]);
    let file = folder.path().join("case.toml");
    // The piston comes to the end of its stroke.
    let text = case_file(CYLINDER, "duration_s = 0.3\nmacro_step_s = 5e-3\nmicro_step_s = 5e-4");
    let short = "fmu = \"actuator.fmu\"\nstart = { cylinder_length_m = 0.01 }";
    fs::write(&file, text.replacen("fmu = \"actuator.fmu\"", short, 1)).unwrap();
    let message = refusal(&file);
    for word in ["of-fmus has no reference", "actuator.fmu: DoStep returned Error", "is outside the model's range"] {
        assert!(message.contains(word), "{message}");
    }
}

#[test]
fn a_case_of_fmus_is_in_lists_and_experiments_by_its_name() {
    let folder = exported("bouncing-ball", &[]);
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let head =
        "duration_s = 0.1\nmacro_step_s = 1e-3\n[parameters.weight]\ndefault = 1.0\nmechanics = \"ball_mass_kg\"";
    let mass = rimbench().args(["list", "parameters", "--case", "bouncing-ball"]).output().unwrap().stdout;
    let mass = String::from_utf8(mass).unwrap();
    let mass = mass.split_whitespace().find(|word| word.ends_with("mass_kg")).unwrap().to_owned();
    fs::write(path("case.toml"), case_file(CARRIAGE, &head.replace("ball_mass_kg", &mass))).unwrap();
    fs::write(
        path("sweep.toml"),
        "question = \"?\"\nmacro_steps_s = [1e-3]\n[[cases]]\nname = \"of-fmus\"\nset = { weight = 2.5 }\n[[schemes]]\n\
         scheme = \"zero-order-hold\"\n[[schemes]]\nscheme = \"rim-nonsmooth\"\n",
    )
    .unwrap();
    rimbench()
        .args(["--case-file", &path("case.toml"), "run", &path("sweep.toml"), "--out", &path("results")])
        .assert()
        .success();
    let mut runs = csv::Reader::from_path(folder.path().join("results/runs.csv")).unwrap();
    let rows: Vec<BTreeMap<String, String>> = runs.deserialize().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 2);
    assert!(rows.iter().all(|row| row["outcome"] == "completed"), "{rows:?}");
    // A name that is taken is refused.
    let text = fs::read_to_string(path("case.toml")).unwrap();
    fs::write(path("taken.toml"), text.replace("of-fmus", "wedge-box")).unwrap();
    let message = refusal(Path::new(&path("taken.toml")));
    assert!(message.contains("wedge-box") && message.contains("not taken yet"), "{message}");
    // What the results belong to is among the parameters, so that another FMU's are not taken for them.
    let listed = rimbench()
        .args(["--case-file", &path("case.toml"), "list", "parameters", "--case", "of-fmus"])
        .output()
        .unwrap();
    assert!(String::from_utf8(listed.stdout).unwrap().contains("fmu_digest"));
}

/// The files of an archive, changed and packed again.
pub fn repacked(from: &Path, to: &Path, change: impl Fn(&str, Vec<u8>) -> Option<(String, Vec<u8>)>) {
    let mut archive = ZipArchive::new(Cursor::new(fs::read(from).unwrap())).unwrap();
    let mut out = ZipWriter::new(Cursor::new(Vec::new()));
    for index in 0..archive.len() {
        let mut file = archive.by_index(index).unwrap();
        let (name, mut bytes) = (file.name().unwrap().into_owned(), Vec::new());
        file.read_to_end(&mut bytes).unwrap();
        if let Some((name, bytes)) = change(&name, bytes) {
            out.start_file(name, SimpleFileOptions::default().unix_permissions(0o755)).unwrap();
            out.write_all(&bytes).unwrap();
        }
    }
    fs::write(to, out.finish().unwrap().into_inner()).unwrap();
}

/// An advice on a case file, as JSON.
fn advised(file: &Path) -> Value {
    let limits = ["--from", "2e-3", "--to", "2e-2", "--per-decade", "4", "--phases", "2", "--kept-aside", "2"];
    let mut command = rimbench();
    command.args(["advise", "--error", "5%", "--format", "json", "--case"]).arg(file).args(limits);
    serde_json::from_slice(&command.assert().success().get_output().stdout).unwrap()
}

/// What is advised, with its numbers again by the commands that are printed.
fn assert_advice_holds(advice: &Value) {
    let best = &advice["advised"];
    assert!(best["worst_error"].as_f64().unwrap() <= 0.05, "{best}");
    assert!(best["last_stable_s"].as_f64() >= best["macro_step_s"].as_f64(), "{best}");
    let run = &best["kept_aside"][1];
    for command in [&run["command"], &best["limit_command"]] {
        let typed: Vec<&str> = command.as_str().unwrap().split(' ').skip(1).collect();
        let output = rimbench().args(typed).args(["--format", "json"]).assert().success().get_output().stdout.clone();
        let facts: Value = serde_json::from_slice(&output).unwrap();
        if command == &run["command"] {
            assert_eq!((&facts["run_id"], &facts["force_error_rms_of_peak"]), (&run["run_id"], &run["error"]));
        }
    }
}

/// Schemes that have no form on a case, with why.
fn skipped(advice: &Value) -> BTreeMap<&str, &str> {
    let fallen = advice["fallen"].as_array().unwrap().iter();
    let reasons = fallen.map(|fallen| (fallen["scheme"].as_str().unwrap(), fallen["reason"].as_str().unwrap()));
    reasons.filter(|(_, reason)| reason.starts_with("skipped")).collect()
}

#[test]
fn a_case_of_fmus_is_advised_on_with_derivatives_and_without() {
    let folder = exported("impact-oscillator", &[]);
    let head = "duration_s = 0.3\nmacro_step_s = 1e-3\nmicro_step_s = 5e-4\nprocess = \"same\"";
    let text = case_file(CARRIAGE, head);
    let file = folder.path().join("case.toml");
    fs::write(&file, &text).unwrap();
    let advice = advised(&file);
    assert_advice_holds(&advice);
    // FMUs know of derivatives, and of no volumes of oil.
    assert_eq!(skipped(&advice).into_keys().collect::<Vec<_>>(), ["hydraulic-line"]);

    // The same FMUs without a word of derivatives. As long as their states can be kept and set they are probed, and what needs
    // derivatives runs; where they cannot, it falls, each with the reason, and something else is advised.
    let without = |state: bool| {
        move |name: &str, bytes: Vec<u8>| {
            if name != "modelDescription.xml" {
                return Some((name.to_owned(), bytes));
            }
            let mut text = String::from_utf8(bytes).unwrap().replace(" providesDirectionalDerivatives=\"true\"", "");
            assert!(text.contains(" canGetAndSetFMUState=\"true\""), "{text}");
            if state {
                text = text.replace(" canGetAndSetFMUState=\"true\"", " canGetAndSetFMUState=\"false\"");
            }
            let parts: Vec<&str> = text.split(" derivative=\"").collect();
            let behind = |part: &&str| part.split_once('"').unwrap().1.to_owned();
            let text = parts[0].to_owned() + &parts[1..].iter().map(behind).collect::<String>();
            Some((name.to_owned(), text.into_bytes()))
        }
    };
    let [probed, plain] = [("probed", false), ("plain", true)].map(|(kind, state)| {
        for side in ["mechanics", "actuator"] {
            let path = |name: &str| folder.path().join(format!("{name}.fmu"));
            repacked(&path(side), &path(&format!("{side}-{kind}")), without(state));
        }
        let file = folder.path().join(format!("{kind}.toml"));
        fs::write(&file, text.replace(".fmu\"", &format!("-{kind}.fmu\""))).unwrap();
        let advice = advised(&file);
        assert_advice_holds(&advice);
        advice
    });
    assert_eq!(skipped(&probed), skipped(&advice));
    let through_derivatives = ["interface-jacobian", "transmission-line"];
    for scheme in through_derivatives {
        let of_it = |part: &Value| part["scheme"] == scheme;
        // What meets the error at a higher cost shows no run that fails.
        let meets = |part: &Value| part["reason"].as_str().is_some_and(|reason| reason.starts_with("meets it"));
        let ran = |part: &Value| of_it(part) && (!part["run"].is_null() || meets(part));
        let chosen = ["advised", "runner_up"].iter().any(|role| of_it(&probed[role]));
        assert!(chosen || probed["fallen"].as_array().unwrap().iter().any(ran), "{scheme}: {probed}");
    }
    let skipped = skipped(&plain);
    for scheme in through_derivatives {
        assert!(skipped[scheme].contains("offers no directional derivatives"), "{skipped:?}");
    }
    assert!(!skipped.contains_key("zero-order-hold") && !skipped.contains_key("nepce"), "{skipped:?}");
}

/// An error of the program: one line, and the code of bad input.
fn refusal(case: &Path) -> String {
    let mut command = rimbench();
    command.args(["simulate", "--scheme", "zero-order-hold", "--case"]).arg(case);
    let output = command.assert().code(2).get_output().clone();
    assert!(output.stdout.is_empty());
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.starts_with("error: ") && message.trim_end().lines().count() == 1, "{message}");
    message
}

#[test]
fn whatever_is_wrong_with_a_case_of_fmus_is_said_in_one_line_with_its_file_and_variable() {
    let folder = exported("bouncing-ball", &[]);
    let place = |name: &str| folder.path().join(name);
    // Most of it is found before the library is loaded, which is large.
    let light = |name: &str, bytes: Vec<u8>| {
        let bytes = if name.starts_with("binaries") { b"no library".to_vec() } else { bytes };
        Some((name.to_owned(), bytes))
    };
    fs::rename(place("mechanics.fmu"), place("whole.fmu")).unwrap();
    repacked(&place("whole.fmu"), &place("mechanics.fmu"), light);
    repacked(&place("actuator.fmu"), &place("actuator.fmu"), light);
    let head = "duration_s = 0.1\nmacro_step_s = 1e-3\nprocess = \"same\"";
    let good = case_file(CARRIAGE, head);
    let case = place("case.toml");
    let refused = |text: &str| {
        fs::write(&case, text).unwrap();
        refusal(&case)
    };
    assert!(refusal(&place("none.toml")).contains("none.toml: cannot be read"));
    for (text, words) in [
        ("name = ".to_owned(), &["case.toml", "is no case of FMUs", "line 1"] as &[&str]),
        (good.replacen("fmu = \"mechanics.fmu\"", "command = [\"x\"]", 1), &["case.toml", "a side can be an FMU"]),
        ("name = \"x\"\nlike = \"wedge-box\"".to_owned(), &["case.toml", "a class in Python"]),
        (good.replace("of-fmus", "Of FMUs"), &["case.toml", "kebab-case"]),
        (good.replace("duration_s = 0.1", "duration_s = -1"), &["case.toml", "duration_s = -1"]),
        (good.replace("duration_s", "duraton_s"), &["case.toml", "duraton_s"]),
        (good.replacen("mechanics.fmu", "mechanic.fmu", 1), &["mechanic.fmu", "cannot be read"]),
        (good.replacen("mechanics.fmu", "case.toml", 1), &["case.toml", "no zip archive"]),
        (
            good.replacen("position = \"interface_position_m\"", "position = \"interface_positon_m\"", 1),
            &["mechanics.fmu", "unknown variable `interface_positon_m`", "did you mean `interface_position_m`"],
        ),
        (
            good.replacen("position = \"interface_position_m\"", "position = \"actuator_force_n\"", 1),
            &["mechanics.fmu", "`actuator_force_n` is of causality input", "must be output"],
        ),
        (
            good.replacen("position = \"interface_position_m\"", "position = \"interface_velocity_m_s\"", 1),
            &["mechanics.fmu", "`interface_velocity_m_s` is in `m/s`", "no unit like m"],
        ),
        (
            good.replacen("position = \"interface_position_m\"", "position = \"rim.a\"", 1),
            &["mechanics.fmu", "`rim.a` is not one number"],
        ),
        (
            good.replacen("fmu = \"mechanics.fmu\"", "fmu = \"mechanics.fmu\"\nstart = { serialisable = 1 }", 1),
            &["mechanics.fmu", "`serialisable`", "valid: true or false"],
        ),
        (
            good.replacen("fmu = \"mechanics.fmu\"", "fmu = \"mechanics.fmu\"\nobserve = [\"time_s\"]", 1),
            &["mechanics.fmu", "unknown variable `time_s`"],
        ),
        (
            good.replacen("fmu = \"mechanics.fmu\"", "fmu = \"mechanics.fmu\"\ndirect_feedthrough = true", 1).replacen(
                "fmu = \"actuator.fmu\"",
                "fmu = \"actuator.fmu\"\ndirect_feedthrough = true",
                1,
            ),
            &["case.toml", "algebraic loop", "direct_feedthrough = false"],
        ),
        (good.replace("duration_s = 0.1", "duration_s = 0.1\nmicro_step_s = 1"), &["case.toml", "micro_step_s = 1 "]),
        (
            good.replace("duration_s = 0.1", "duration_s = 0.1\nanswer_within_s = 1e-12"),
            &["case.toml", "answer_within_s", "at least 0.001 s"],
        ),
        (
            good.replacen(
                "force = \"actuator_force_n\"",
                "force = { variable = \"actuator_force_n\", factor = 1.0, offset = 3.0 }",
                1,
            ),
            &["case.toml", "{ variable = \"…\", factor = … }"],
        ),
        (
            format!("{good}\n[parameters.fmu_digest]\ndefault = 1.0\nmechanics = \"ball_mass_kg\""),
            &["case.toml", "[parameters.fmu_digest]", "is taken"],
        ),
        (good.split("[[interface]]").next().unwrap().to_owned(), &["case.toml", "interface"]),
    ] {
        let message = refused(&text);
        assert!(words.iter().all(|word| message.contains(word)), "{words:?}: {message}");
    }
    // FMUs that are not what they seem.
    let odd = place("odd.fmu");
    let with_odd = good.replacen("mechanics.fmu", "odd.fmu", 1);
    let described = |from: &'static str, to: &'static str| {
        move |name: &str, bytes: Vec<u8>| {
            if name != "modelDescription.xml" {
                return Some((name.to_owned(), bytes));
            }
            let text = String::from_utf8(bytes).unwrap();
            assert!(text.contains(from));
            Some((name.to_owned(), text.replacen(from, to, 1).into_bytes()))
        }
    };
    type Change = Box<dyn Fn(&str, Vec<u8>) -> Option<(String, Vec<u8>)>>;
    let changes: [(Change, &[&str]); 9] = [
        (
            Box::new(|name, bytes| (name != "modelDescription.xml").then(|| (name.to_owned(), bytes))),
            &["modelDescription.xml cannot be read"],
        ),
        (Box::new(described("<CoSimulation", "<Cosimulation")), &["modelDescription.xml", "not for co-simulation"]),
        (Box::new(described("fmiVersion=\"3.0\"", "fmiVersion=\"1.0\"")), &["fmiVersion = 1.0", "2.0, 3.0"]),
        (Box::new(described("<ModelVariables>", "<ModelVariables")), &["modelDescription.xml"]),
        (
            Box::new(described("<CoSimulation", "<CoSimulation canBeInstantiatedOnlyOncePerProcess=\"true\"")),
            &["may be in a process only once", "valid: process = \"own\""],
        ),
        (Box::new(described("instantiationToken=\"", "instantiationToken=\"0")), &["no instance can be made", "token"]),
        (
            Box::new(|name, bytes| {
                let name = if name.starts_with("binaries") { "binaries/m68k-amiga/rimbench_fmi.so" } else { name };
                Some((name.to_owned(), bytes))
            }),
            &["has no library `rimbench_fmi` for this platform", "m68k-amiga"],
        ),
        (
            Box::new(|name, bytes| {
                let bytes = if name.starts_with("binaries") { b"no library".to_vec() } else { bytes };
                Some((name.to_owned(), bytes))
            }),
            &["its library cannot be loaded"],
        ),
        (
            Box::new(|name, bytes| (name != "resources/rimbench.json").then(|| (name.to_owned(), bytes))),
            &["no instance can be made", "rimbench.json: cannot be read"],
        ),
    ];
    for (change, words) in changes {
        // Only an instance needs the library itself.
        let from = if words[0].starts_with("no instance") { "whole.fmu" } else { "mechanics.fmu" };
        repacked(&place(from), &odd, change);
        let message = refused(&with_odd);
        assert!(words.iter().chain(&["odd.fmu"]).all(|word| message.contains(word)), "{words:?}: {message}");
    }
}

#[test]
fn an_export_that_cannot_be_is_refused_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let text = folder.path().join("text");
    fs::write(&text, "no library").unwrap();
    let out = folder.path().join("out.fmu");
    let [out, text] = [&out, &text].map(|path| path.to_str().unwrap());
    let beyond: PathBuf = folder.path().join("no/such/out.fmu");
    for (arguments, wanted) in [
        (vec!["--case", "wedge-bax", "--out", out], "did you mean `wedge-box`"),
        (vec!["--case", "wedge-box", "--set", "box_mass_kg=-1", "--out", out], "box_mass_kg = -1 is not valid"),
        (vec!["--case", "wedge-box", "--out", text], "ends in .fmu"),
        (vec!["--case", "wedge-box", "--out", beyond.to_str().unwrap()], "there is no folder"),
        (vec!["--case", "wedge-box", "--library", text, "--out", out], "cargo build --release --package rimbench-fmi"),
        (vec!["--case", "wedge-box", "--library", "none", "--out", out], "none: is not there"),
    ] {
        let output =
            rimbench().args(["fmu", "--side", "mechanics"]).args(&arguments).assert().code(2).get_output().clone();
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains(wanted) && message.trim_end().lines().count() == 1, "{arguments:?}: {message}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "{arguments:?}");
    }
}

#[test]
fn a_scheme_that_is_a_program_is_refused_with_the_way_to_go() {
    for words in [
        &["simulate", "--case", "wedge-box", "--scheme", "mine.toml"][..],
        &["--scheme-file", "mine.toml", "list", "schemes"],
    ] {
        let output = rimbench().args(words).assert().code(2).get_output().clone();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains("mine.toml") && said.contains("a scheme a class in Python"), "{said}");
    }
}
