//! FMUs that the program writes come back as cases with the same digits, and everything that can be wrong with a case
//! of FMUs is said in one line.

use crate::exported_fmus::{CARRIAGE, case_file, exported, repacked, without_library};
use crate::program::{assert_has, json, printed, refused, rimbench, rows_of};
use rimbench::cosim::Quantity;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Read};
use std::path::Path;
use tempfile::TempDir;
use zip::ZipArchive;

pub fn trace(folder: &Path, case: &str, arguments: &[&str]) -> BTreeMap<String, Vec<String>> {
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
    compared_of("3.0", case, columns, head, set, runs);
}

fn compared_of(version: &str, case: &str, columns: [&str; 3], head: &str, set: &[&str], runs: &[&[&str]]) {
    let folder = exported(case, &[&["--fmi", version], set].concat());
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

#[test]
fn a_wedge_box_that_was_written_as_fmus_has_the_digits_of_the_case_it_was_written_from() {
    let head = "duration_s = 0.15\nmacro_step_s = 2e-3\nmicro_step_s = 5e-5\nreference_step_s = 5e-5";
    let long = ["--duration", "0.15", "--macro-step", "2e-3", "--scheme"];
    let with = |scheme: &'static str| long.into_iter().chain([scheme]).collect::<Vec<_>>();
    let runs = ["zero-order-hold", "rim-nonsmooth-gap", "rim-smooth", "iterated-aitken"].map(with);
    compared("wedge-box", CYLINDER, head, &["--set", "box_mass_kg=210"], &runs.each_ref().map(Vec::as_slice));
    // What bounces is told from what the mechanics' own steps make.
    let bouncing = with("rim-nonsmooth-gap");
    compared("wedge-box", CYLINDER, head, &["--set", "restitution=0.5"], &[&bouncing]);
    // The model puts right what the disc's joint drifts in a step, and is one of the box all the same.
    let head =
        "duration_s = 0.7\nmacro_step_s = 1e-2\nmicro_step_s = 5e-5\nreference_step_s = 5e-5\nprocess = \"same\"";
    let long = ["--scheme", "rim-nonsmooth-gap", "--duration", "0.7", "--macro-step", "1e-2"];
    compared("wedge-box", CYLINDER, head, &[], &[&long]);
}

#[test]
fn fmus_for_fmi_2_have_the_digits_of_those_for_3_under_every_scheme_that_needs_no_interface_model() {
    let times = "duration_s = 0.15\nmacro_step_s = 2e-3\nmicro_step_s = 5e-5\nreference_step_s = 5e-5";
    let heads = [times.to_owned(), format!("{times}\nprocess = \"same\"")];
    let long = ["--duration", "0.15", "--macro-step", "2e-3", "--micro-step", "5e-5", "--scheme"];
    let with = |scheme: &'static str| long.into_iter().chain([scheme]).collect::<Vec<_>>();
    let runs = ["zero-order-hold", "first-order-hold", "iterated-aitken"].map(with);
    let runs = runs.each_ref().map(Vec::as_slice);
    compared_of("2.0", "wedge-box", CYLINDER, &heads[0], &["--set", "box_mass_kg=210"], &runs);
    compared_of("2.0", "rocking-block", CYLINDER, &heads[1], &[], &runs);
    compared_of("2.0", "wedge-box-two-ledges", CYLINDER, &heads[1], &[], &runs[..1]);
    compared_of("2.0", "impact-oscillator", CARRIAGE, &heads[1], &[], &runs[..1]);
    // Rates and directional derivatives, which the case itself has as well, and parameters that are set.
    let parameter = "process = \"same\"\n[parameters.mass]\ndefault = 200.0\nmechanics = \"box_mass_kg\"";
    let seen = ["2.0", "3.0"].map(|version| {
        let folder = exported("wedge-box", &["--fmi", version]);
        let file = folder.path().join("case.toml");
        fs::write(&file, case_file(CYLINDER, &format!("{times}\n{parameter}"))).unwrap();
        let run = |scheme| [&with(scheme)[..], &["--set", "mass=230"]].concat();
        ["nepce", "energy-leak-damper"].map(|scheme| trace(folder.path(), file.to_str().unwrap(), &run(scheme)))
    });
    assert_eq!(seen[0], seen[1]);
}

/// The resources of an FMU for FMI 2.0 are told by a URI, in which a path of any name is written.
#[test]
fn an_fmu_for_fmi_2_finds_its_resources_in_a_folder_of_any_name_and_says_what_it_refuses_to_the_masters_logger() {
    let folder = exported("wedge-box", &["--fmi", "2.0"]);
    let odd = folder.path().join("a b%20é 100%");
    fs::create_dir(&odd).unwrap();
    let file = folder.path().join("case.toml");
    let text = case_file(CYLINDER, "duration_s = 0.3\nmacro_step_s = 5e-3\nmicro_step_s = 5e-4");
    let refusal_with = |start: &str| {
        let with = format!("fmu = \"actuator.fmu\"\nstart = {{ {start} }}");
        fs::write(&file, text.replacen("fmu = \"actuator.fmu\"", &with, 1)).unwrap();
        let mut command = rimbench();
        command.env("TMPDIR", &odd).args(["simulate", "--scheme", "zero-order-hold", "--case"]).arg(&file);
        refused(&mut command)
    };
    let step = ["actuator.fmu: DoStep returned Error", "is outside the model's range"];
    assert_has(&refusal_with("cylinder_length_m = 0.01"), &step);
    // A per cent sign in what is said is no format.
    assert_has(&refusal_with("cylinder_length_m = -1.0"), &["actuator.fmu", "cylinder_length_m = -1"]);
    assert_has(&refusal_with("wait_s = -1.0"), &["actuator.fmu", "wait_s", "0"]);
    assert_has(&refusal_with("serialisable = 1"), &["actuator.fmu", "`serialisable`", "true or false"]);
}

#[test]
fn an_fmu_for_fmi_2_has_no_time_no_arrays_and_no_interface_model_which_the_exporter_says() {
    let place = tempfile::tempdir().unwrap();
    let out = place.path().join("mechanics.fmu");
    let export = |version: &str| {
        let mut command = rimbench();
        command.args(["fmu", "--case", "wedge-box", "--side", "mechanics", "--duration", "0.01", "--fmi", version]);
        let output = command.arg("--out").arg(&out).output().unwrap();
        assert!(output.status.success());
        (String::from_utf8(output.stderr).unwrap(), description(&out))
    };
    let (said, text) = export("2.0");
    assert_has(&said, &["note: FMI 2.0 has no arrays", "rim.*", "--fmi 3.0"]);
    assert!(
        !text.contains("name=\"rim.") && !text.contains("name=\"time\"") && !text.contains("independent"),
        "{text}"
    );
    let names = |text: &str| text.matches(" valueReference=").count();
    let (said, whole) = export("3.0");
    assert!(said.is_empty() && whole.contains("name=\"rim.H\"") && names(&whole) > names(&text), "{said}");
}

/// What an FMU says of itself.
fn description(file: &Path) -> String {
    let mut archive = ZipArchive::new(Cursor::new(fs::read(file).unwrap())).unwrap();
    let mut text = String::new();
    archive.by_name("modelDescription.xml").unwrap().read_to_string(&mut text).unwrap();
    text
}

#[test]
fn friction_of_an_interface_model_come_through_the_fmu_to_the_bit() {
    let head =
        "duration_s = 0.3\nmacro_step_s = 2e-3\nmicro_step_s = 5e-5\nreference_step_s = 5e-5\nprocess = \"same\"";
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
    // Edges that are plastic while the beak rebounds.
    compared("woodpecker", CARRIAGE, head, &[], &[&gap]);
}

/// Of each case that can be exported, as it is.
#[test]
fn what_every_exported_case_says_of_its_motion_adds_up() {
    let mut opened = 0;
    let everything = rimbench::everything().unwrap();
    for case in everything.cases().iter().filter(|case| case.interface_columns.len() == 1) {
        // What exchanges displacements alone is no mechanics under a force.
        let sides = (case.build)(&case.default_parameters(), &everything.solvers()[0]).unwrap().sides;
        if sides.mechanics.ports().inputs.iter().any(|input| input.quantity != Quantity::Force) {
            continue;
        }
        let folder = tempfile::tempdir().unwrap();
        let written = ["mechanics", "actuator"].iter().all(|side| {
            let out = folder.path().join(format!("{side}.fmu"));
            let mut command = rimbench();
            command.args(["fmu", "--case", &case.name, "--side", side, "--out"]).arg(out);
            command.output().unwrap().status.success()
        });
        if !written {
            continue;
        }
        let row = &case.interface_columns[0];
        let (h, micro) = (case.defaults.macro_step_s, case.defaults.micro_step_s);
        let head = format!(
            "process = \"same\"\nduration_s = {}\nmacro_step_s = {h}\nmicro_step_s = {micro}\nreference_step_s = {micro}",
            4.0 * h
        );
        let file = folder.path().join("case.toml");
        fs::write(&file, case_file([&row.position, &row.velocity, &row.force].map(|name| &**name), &head)).unwrap();
        let mut command = rimbench();
        let output =
            command.arg("--case-file").arg(&file).args(["list", "parameters", "--case", "of-fmus"]).output().unwrap();
        assert!(output.status.success(), "{}: {}", case.name, String::from_utf8_lossy(&output.stderr));
        opened += 1;
    }
    assert!(opened > 20, "{opened} cases can be exported");
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
    let wanted = ["of-fmus has no reference", "actuator.fmu: DoStep returned Error", "is outside the model's range"];
    assert_has(&refusal(&file), &wanted);
}

#[test]
fn an_exported_side_starts_with_what_the_other_says_and_has_no_output_but_numbers() {
    for (side, version) in ["mechanics", "actuator"].into_iter().zip(["3.0", "2.0"]) {
        let folder = exported("wedge-box", &["--macro-step", "1e-3", "--duration", "0.01", "--fmi", version]);
        let text = description(&folder.path().join(format!("{side}.fmu")));
        let row = rows_of(folder.path().join(format!("{side}_in.csv"))).swap_remove(0);
        let (mut inputs, mut outputs) = (0, 0);
        for line in text.lines() {
            let attribute =
                |name: &str| line.split_once(&format!(" {name}=\"")).and_then(|(_, rest)| rest.split('"').next());
            match attribute("causality") {
                Some("input") => {
                    let start: f64 = attribute("start").unwrap().parse().unwrap();
                    assert_eq!(start, row[attribute("name").unwrap()].parse::<f64>().unwrap(), "{side}: {line}");
                    inputs += 1;
                }
                Some("output") => {
                    assert!(
                        (line.contains("<Float64") || line.contains("<Real")) && !line.contains("<Dimension"),
                        "{side}: {line}"
                    );
                    outputs += 1;
                }
                _ => {}
            }
        }
        assert!(inputs > 0 && outputs > 0, "{text}");
    }
}

#[test]
fn a_case_of_fmus_is_in_lists_and_experiments_by_its_name() {
    let folder = exported("bouncing-ball", &[]);
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let head =
        "duration_s = 0.1\nmacro_step_s = 1e-3\n[parameters.weight]\ndefault = 1.0\nmechanics = \"ball_mass_kg\"";
    let mass = printed(rimbench().args(["list", "parameters", "--case", "bouncing-ball"]));
    let mass = mass.split_whitespace().find(|word| word.ends_with("mass_kg")).unwrap();
    fs::write(path("case.toml"), case_file(CARRIAGE, &head.replace("ball_mass_kg", mass))).unwrap();
    fs::write(
        path("sweep.toml"),
        "question = \"?\"\nmacro_steps_s = [1e-3]\n[[cases]]\nname = \"of-fmus\"\nset = { weight = 2.5 }\n[[schemes]]\n\
         scheme = \"zero-order-hold\"\n[[schemes]]\nscheme = \"rim-nonsmooth\"\n",
    )
    .unwrap();
    let of_case = |more: &[&str]| printed(rimbench().args(["--case-file", &path("case.toml")]).args(more));
    of_case(&["run", &path("sweep.toml"), "--out", &path("results")]);
    let rows = rows_of(folder.path().join("results/runs.csv"));
    assert_eq!(rows.len(), 2);
    assert!(rows.iter().all(|row| row["outcome"] == "completed"), "{rows:?}");
    // A name that is taken is refused.
    let text = fs::read_to_string(path("case.toml")).unwrap();
    fs::write(path("taken.toml"), text.replace("of-fmus", "wedge-box")).unwrap();
    assert_has(&refusal(Path::new(&path("taken.toml"))), &["wedge-box", "not taken yet"]);
    // What the results belong to is among the parameters, so that another FMU's are not taken for them.
    assert_has(&of_case(&["list", "parameters", "--case", "of-fmus"]), &["fmu_digest"]);
}

/// A file of an FMU, its description changed.
fn redescribed(name: &str, bytes: Vec<u8>, change: impl Fn(String) -> String) -> Option<(String, Vec<u8>)> {
    let described = name == "modelDescription.xml";
    let bytes = if described { change(String::from_utf8(bytes).unwrap()).into_bytes() } else { bytes };
    Some((name.to_owned(), bytes))
}

/// An advice on a case file, as JSON.
fn advised(file: &Path, scheme: &[&str]) -> Value {
    let limits = ["--from", "2e-3", "--to", "2e-2", "--per-decade", "4", "--phases", "4"];
    let mut command = rimbench();
    json(command.args(["advise", "--error", "5%", "--format", "json", "--case"]).arg(file).args(limits).args(scheme))
}

/// What is advised, with its numbers again by the command that is printed.
fn assert_advice_holds(advice: &Value) {
    let best = &advice["advised"];
    assert!(best["worst_error"].as_f64().unwrap() <= 0.05, "{best}");
    let typed: Vec<&str> = best["command"].as_str().unwrap().split(' ').skip(1).collect();
    let facts = json(rimbench().args(typed).args(["--format", "json"]));
    assert_eq!((&facts["run_id"], &facts["force_error_rms_of_peak"]), (&best["run_id"], &best["worst_error"]));
}

/// Why a scheme cannot be run on a case, if it cannot.
fn skipped(file: &Path, scheme: &str) -> Option<String> {
    let advice = advised(file, &["--scheme", scheme]);
    let none = advice["notes"].to_string().contains("No form could be run");
    none.then(|| advice["skipped"].to_string())
}

#[test]
fn a_case_of_fmus_is_advised_on_with_derivatives_and_without() {
    let folder = exported("impact-oscillator", &[]);
    let head = "duration_s = 0.3\nmacro_step_s = 1e-3\nmicro_step_s = 5e-4\nprocess = \"same\"";
    let text = case_file(CARRIAGE, head);
    let file = folder.path().join("case.toml");
    fs::write(&file, &text).unwrap();
    assert_advice_holds(&advised(&file, &[]));
    // FMUs know of derivatives, and of no volumes of oil; these have one row.
    let through_derivatives = ["interface-jacobian", "transmission-line"];
    assert!(["hydraulic-line", "rim-split"].iter().all(|scheme| skipped(&file, scheme).is_some()));
    assert_eq!(through_derivatives.map(|scheme| skipped(&file, scheme)), [None, None]);

    // The same FMUs without a word of derivatives. As long as their states can be kept and set they are probed, and
    // what needs derivatives runs; where they cannot, it falls, each with the reason, and something else is advised.
    let without = |text: String, state: bool| {
        let mut text = text.replace(" providesDirectionalDerivatives=\"true\"", "");
        assert!(text.contains(" canGetAndSetFMUState=\"true\""), "{text}");
        if state {
            text = text.replace(" canGetAndSetFMUState=\"true\"", " canGetAndSetFMUState=\"false\"");
        }
        let parts: Vec<&str> = text.split(" derivative=\"").collect();
        let behind = |part: &&str| part.split_once('"').unwrap().1.to_owned();
        parts[0].to_owned() + &parts[1..].iter().map(behind).collect::<String>()
    };
    let [probed, plain] = [("probed", false), ("plain", true)].map(|(kind, state)| {
        for side in ["mechanics", "actuator"] {
            let path = |name: &str| folder.path().join(format!("{name}.fmu"));
            let change = |name: &str, bytes| redescribed(name, bytes, |text| without(text, state));
            repacked(&path(side), &path(&format!("{side}-{kind}")), change);
        }
        let file = folder.path().join(format!("{kind}.toml"));
        fs::write(&file, text.replace(".fmu\"", &format!("-{kind}.fmu\""))).unwrap();
        assert_advice_holds(&advised(&file, &[]));
        file
    });
    assert_eq!(through_derivatives.map(|scheme| skipped(&probed, scheme)), [None, None]);
    for scheme in through_derivatives {
        assert!(skipped(&plain, scheme).unwrap().contains("offers no directional derivatives"), "{scheme}");
    }
    assert_eq!(["zero-order-hold", "nepce"].map(|scheme| skipped(&plain, scheme)), [None, None]);
}

/// A case whose mechanics says nothing of itself but positions and velocities, and perhaps takes steps of one length
/// only.
fn stripped(case: &str, more: &[(&str, &str)]) -> TempDir {
    let folder = exported(case, &["--macro-step", "1e-3"]);
    let path = |name: &str| folder.path().join(name);
    repacked(&path("mechanics.fmu"), &path("bare.fmu"), |name, bytes| {
        if name.ends_with("fmi-ls-manifest.xml") {
            return None;
        }
        redescribed(name, bytes, |text| {
            let text = text.replace(" providesDirectionalDerivatives=\"true\"", "");
            let text = more.iter().fold(text, |text, (from, to)| {
                assert!(text.contains(from), "{from}");
                text.replace(from, to)
            });
            let parts: Vec<&str> = text.split(" derivative=\"").collect();
            let behind = |part: &&str| part.split_once('"').unwrap().1.to_owned();
            parts[0].to_owned() + &parts[1..].iter().map(behind).collect::<String>()
        })
    });
    fs::rename(path("bare.fmu"), path("mechanics.fmu")).unwrap();
    let head =
        "duration_s = 0.3\nmacro_step_s = 5e-3\nmicro_step_s = 5e-5\nreference_step_s = 5e-5\nprocess = \"same\"";
    fs::write(path("case.toml"), case_file(CYLINDER, head)).unwrap();
    folder
}

fn simulated(case: &Path, scheme: &str, more: &[&str]) -> Value {
    let mut command = rimbench();
    command.args(["simulate", "--format", "json", "--scheme", scheme, "--case"]).arg(case).args(more);
    serde_json::from_slice(&command.output().unwrap().stdout).unwrap()
}

#[test]
fn a_bare_mechanics_that_contacts_hold_is_asked_over_its_own_step_and_no_round_off_stops_it() {
    for case in ["wedge-box-friction", "wedge-box-reversal"] {
        let folder = stripped(case, &[]);
        let file = folder.path().join("case.toml");
        let probed = simulated(&file, "rim-smooth", &[]);
        assert_eq!(probed["outcome"], "completed", "{case}: {probed:#}");
        let quality = probed["probed_fmus"].as_object().unwrap().values().next().unwrap();
        // What is foreseen is what comes, but where the force decides a contact.
        assert!(quality["count"] == 60 && quality["error_p50"].as_f64().unwrap() < 1e-3, "{case}: {quality:#}");
        // A step and three trials of each macro step, and those of the model that nothing follows.
        assert_eq!(probed["mechanics_micro_steps"], 60 + 3 * 61, "{case}");
        // Asked while the actuator steps it is the case itself.
        let asked = simulated(&file, "rim-answers", &[]);
        let known = simulated(Path::new(case), "rim-answers", &["--macro-step", "5e-3", "--duration", "0.3"]);
        for name in ["outcome", "trials_per_step", "second_tangents", "mechanics_micro_steps"] {
            assert_eq!(asked[name], known[name], "{case}, {name}");
        }
        let [asked, known] = [asked, known].map(|run| run["force_error_rms_n"].as_f64().unwrap());
        // References of both are computed on two ways, to far less than a newton.
        assert!((asked - known).abs() < 0.1 * known + 1e-3, "{case}: {asked} {known}");
    }
}

#[test]
fn a_bare_mechanics_of_one_step_is_asked_by_that_and_one_without_state_is_told_what_remains() {
    let variable = "canHandleVariableCommunicationStepSize=\"true\"";
    let folder = stripped("wedge-box-reversal", &[(variable, "canHandleVariableCommunicationStepSize=\"false\"")]);
    let file = folder.path().join("case.toml");
    for scheme in ["rim-smooth", "rim-answers"] {
        let said = simulated(&file, scheme, &[]);
        assert_eq!(said["outcome"], "completed", "{scheme}: {said:#}");
    }
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, text.replace("\"mechanics.fmu\"", "\"mechanics.fmu\"\nprobe_step_s = 1e-3")).unwrap();
    let message = refusal(&file);
    assert_has(&message, &["probe_step_s = 0.001", "canHandleVariableCommunicationStepSize", "use none"]);

    let state = "canGetAndSetFMUState=\"true\"";
    let folder = stripped("wedge-box-reversal", &[(state, "canGetAndSetFMUState=\"false\"")]);
    for scheme in ["rim-smooth", "rim-answers"] {
        let said = simulated(&folder.path().join("case.toml"), scheme, &[]);
        assert_eq!(said["outcome"], "skipped", "{scheme}");
        assert_has(said["reason"].as_str().unwrap(), &["what remains are schemes", "zero-order-hold"]);
    }
}

/// An error of the program: one line and perhaps one of help, and the code of bad input.
fn refusal(case: &Path) -> String {
    let mut command = rimbench();
    command.args(["simulate", "--scheme", "zero-order-hold", "--case"]).arg(case);
    let message = refused(&mut command);
    assert!(message.lines().count() <= 2, "{message}");
    message
}

/// A piece of a good case file, what stands in its place, and what all is said of that.
const REPLACED: &str = r#"
of-fmus | Of FMUs | case.toml & kebab-case
duration_s = 0.1 | duration_s = -1 | case.toml & duration_s = -1
duration_s | duraton_s | case.toml & duraton_s
duration_s = 0.1 | duration_s = 0.1\nmicro_step_s = 1 | case.toml & micro_step_s = 1 is
duration_s = 0.1 | duration_s = 0.1\nanswer_within_s = 1e-12 | case.toml & answer_within_s & at least 0.001 s
mechanics.fmu | mechanic.fmu | mechanic.fmu & cannot be read
mechanics.fmu | case.toml | case.toml & no zip archive
position = "interface_position_m" | position = "interface_positon_m" | mechanics.fmu & unknown variable `interface_positon_m` & `interface_position_m`
position = "interface_position_m" | position = "actuator_force_n" | mechanics.fmu & `actuator_force_n` is of causality input & must be output
position = "interface_position_m" | position = "interface_velocity_m_s" | mechanics.fmu & `interface_velocity_m_s` is in `m/s` & no unit like m
position = "interface_position_m" | position = "rim.a" | mechanics.fmu & `rim.a` is of causality local & must be output
"mechanics.fmu" | "mechanics.fmu"\nstart = { serialisable = 1 } | mechanics.fmu & `serialisable` & true or false
"mechanics.fmu" | "mechanics.fmu"\nobserve = ["time_s"] | mechanics.fmu & unknown variable `time_s`
force = "actuator_force_n" | force = { variable = "actuator_force_n", factor = 1.0, offset = 3.0 } | case.toml & { variable = "…", factor = … }
"#;

#[test]
fn whatever_is_wrong_with_a_case_of_fmus_is_said_in_one_line_with_its_file_and_variable() {
    let folder = exported("bouncing-ball", &[]);
    let place = |name: &str| folder.path().join(name);
    // Most of it is found before the library is loaded, which is large.
    fs::rename(place("mechanics.fmu"), place("whole.fmu")).unwrap();
    repacked(&place("whole.fmu"), &place("mechanics.fmu"), without_library);
    repacked(&place("actuator.fmu"), &place("actuator.fmu"), without_library);
    let good = case_file(CARRIAGE, "duration_s = 0.1\nmacro_step_s = 1e-3\nprocess = \"same\"");
    let case = place("case.toml");
    let assert_said = |text: &str, words: &[&str]| {
        fs::write(&case, text).unwrap();
        assert_has(&refusal(&case), words);
    };
    assert_has(&refusal(&place("none.toml")), &["none.toml: cannot be read"]);
    for (text, words) in [
        ("name = ", &["is no case of FMUs", "line 1"] as &[&str]),
        (good.split("[[interface]]").next().unwrap(), &["interface"]),
        (
            &format!("{good}\n[parameters.fmu_digest]\ndefault = 1.0\nmechanics = \"ball_mass_kg\""),
            &["[parameters.fmu_digest]", "is taken"],
        ),
        (
            &format!("{good}\n[parameters.phase]\ndefault = 1.0\nmechanics = \"ball_mass_kg\""),
            &["[parameters.phase]", "use another"],
        ),
    ] {
        assert_said(text, &[words, &["case.toml"]].concat());
    }
    // The good one with one piece replaced, and what is then said of which file.
    for row in REPLACED.trim().lines() {
        let [piece, by, words] = row.split(" | ").collect::<Vec<_>>().try_into().unwrap();
        assert!(good.contains(piece), "{row}");
        assert_said(&good.replacen(piece, &by.replace("\\n", "\n"), 1), &words.split(" & ").collect::<Vec<_>>());
    }
    let looped = good.replace(".fmu\"", ".fmu\"\ndirect_feedthrough = true");
    assert_said(&looped, &["case.toml", "algebraic loop", "direct_feedthrough = false"]);
    // FMUs that are not what they seem.
    let odd = place("odd.fmu");
    let with_odd = good.replacen("mechanics.fmu", "odd.fmu", 1);
    type Change<'a> = &'a dyn Fn(&str, Vec<u8>) -> Option<(String, Vec<u8>)>;
    let assert_odd = |from: &str, change: Change<'_>, words: &[&str]| {
        repacked(&place(from), &odd, change);
        assert_said(&with_odd, &[words, &["odd.fmu"]].concat());
    };
    // Only an instance needs the library itself.
    let token = "instantiationToken=\"";
    for (fmu, from, to, words) in [
        (
            "mechanics.fmu",
            "<CoSimulation",
            "<Cosimulation",
            &["modelDescription.xml", "not for co-simulation"] as &[&str],
        ),
        ("mechanics.fmu", "fmiVersion=\"3.0\"", "fmiVersion=\"1.0\"", &["fmiVersion = 1.0", "2.0, 3.0"]),
        ("mechanics.fmu", "<ModelVariables>", "<ModelVariables", &["modelDescription.xml"]),
        (
            "mechanics.fmu",
            "<CoSimulation",
            "<CoSimulation canBeInstantiatedOnlyOncePerProcess=\"true\"",
            &["may be in a process only once", "process = \"own\""],
        ),
        ("whole.fmu", token, &format!("{token}0"), &["no instance can be made", "token"]),
    ] {
        let described = |text: String| {
            assert!(text.contains(from));
            text.replacen(from, to, 1)
        };
        assert_odd(fmu, &|name, bytes| redescribed(name, bytes, described), words);
    }
    let lacks = |lost: &'static str| move |name: &str, bytes| (name != lost).then(|| (name.to_owned(), bytes));
    assert_odd("mechanics.fmu", &lacks("modelDescription.xml"), &["modelDescription.xml cannot be read"]);
    let words = ["no instance can be made", "rimbench.json: cannot be read"];
    assert_odd("whole.fmu", &lacks("resources/rimbench.json"), &words);
    assert_odd("mechanics.fmu", &without_library, &["its library cannot be loaded"]);
    let elsewhere = |name: &str, bytes| {
        let name = if name.starts_with("binaries") { "binaries/m68k-amiga/rimbench_fmi.so" } else { name };
        Some((name.to_owned(), bytes))
    };
    assert_odd("mechanics.fmu", &elsewhere, &["has no library `rimbench_fmi` for this platform", "m68k-amiga"]);
}

#[test]
fn an_export_that_cannot_be_is_refused_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let text = folder.path().join("text");
    fs::write(&text, "no library").unwrap();
    let out = folder.path().join("out.fmu");
    let [out, text] = [&out, &text].map(|path| path.to_str().unwrap());
    let beyond = folder.path().join("no/such/out.fmu");
    let assert_refused = |line: &str, wanted: &str| {
        let message = refused(rimbench().args(["fmu", "--side", "mechanics", "--case"]).args(line.split_whitespace()));
        assert!(message.contains(wanted) && message.lines().count() <= 2, "{line}: {message}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "{line}");
    };
    assert_refused(&format!("wedge-bax --out {out}"), "did you mean `wedge-box`");
    assert_refused(&format!("wedge-box --set box_mass_kg=-1 --out {out}"), "box_mass_kg = -1 is not valid");
    assert_refused(&format!("wedge-box --out {text}"), "ends in .fmu");
    assert_refused(&format!("wedge-box --out {}", beyond.display()), "there is no folder");
    let library = "cargo build --release --package rimbench-fmi";
    assert_refused(&format!("wedge-box --library {text} --out {out}"), library);
    assert_refused(&format!("wedge-box --library none --out {out}"), "none: is not there");
    assert_refused(&format!("wedge-box --fmi 1.0 --out {out}"), "[possible values: 2.0, 3.0]");
    for version in ["2.0", "3.0"] {
        let space = "contacts with friction in space are not exported";
        assert_refused(&format!("tripod --fmi {version} --out {out}"), space);
    }
    // All files or none.
    #[cfg(target_os = "linux")]
    {
        std::os::unix::fs::symlink("/dev/full", folder.path().join("out_ref.csv")).unwrap();
        let mut command = rimbench();
        command.args(["fmu", "--case", "wedge-box", "--side", "actuator", "--duration", "0.01", "--out", out]);
        assert!(refused(&mut command).contains("out_ref.csv: cannot be written"));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "the text and the link");
    }
}

#[test]
fn a_text_of_somebody_else_beside_an_fmu_is_left_and_one_of_this_program_is_that_of_every_fmu() {
    let place = tempfile::tempdir().unwrap();
    let readme = place.path().join("Readme.txt");
    let export = |side: &str| {
        let mut command = rimbench();
        command.args(["fmu", "--case", "bouncing-ball", "--duration", "0.01", "--side", side, "--out"]);
        let output = command.arg(place.path().join(format!("{side}.fmu"))).output().unwrap();
        assert!(output.status.success());
        (fs::read_to_string(&readme).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let (own, _) = export("mechanics");
    assert_eq!(export("actuator"), (own, String::new()));
    fs::write(&readme, "mine").unwrap();
    let (text, said) = export("mechanics");
    assert_eq!(text, "mine");
    assert_has(&said, &["note: ", "Readme.txt is not of this program, and is left as it is"]);
}
