//! FMUs that somebody else wrote, in C: what they offer is used, what they do not is said, and what goes wrong with
//! them costs one run.
#![cfg(target_os = "linux")]

use crate::program::{assert_has, process, rimbench, said};
use serde_json::Value;
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

const SOURCE: &str = include_str!("guest_fmu.c");

/// What a description says besides.
#[derive(Clone, Copy, Default)]
struct Offers {
    derivatives: bool,
    state: bool,
    model: bool,
}

fn variable(name: &str, reference: u32, rest: &str) -> String {
    format!("<Float64 name=\"{name}\" valueReference=\"{reference}\" {rest}/>")
}

/// The description of a side.
fn description(token: &str, offers: Offers) -> String {
    let spring = token == "spring";
    let (motion, force) = if spring { ("input", "output") } else { ("output", "input") };
    let causal = |causality: &str| {
        format!("causality=\"{causality}\"{}", if causality == "input" { " start=\"0\"" } else { "" })
    };
    let mut variables = variable("x", 0, &causal(motion));
    let derivative = |of: u32| if spring { String::new() } else { format!(" derivative=\"{of}\"") };
    variables += &variable("v", 1, &(causal(motion) + &derivative(0)));
    variables += &variable("f", 2, &causal(force));
    if !spring {
        variables += &variable("a", 3, "causality=\"output\" derivative=\"1\"");
    }
    for (name, reference) in [("mass", 4), ("fault", 5)] {
        variables += &variable(name, reference, "causality=\"parameter\" variability=\"fixed\" start=\"0\"");
    }
    if offers.model {
        let array = |name: &str, reference: u32, extents: &[usize]| {
            let extents: String = extents.iter().map(|extent| format!("<Dimension start=\"{extent}\"/>")).collect();
            format!("<Float64 name=\"{name}\" valueReference=\"{reference}\" causality=\"output\">{extents}</Float64>")
        };
        #[rustfmt::skip]
        let parts: [(&str, &[usize]); 10] = [
            ("rim.H", &[2, 2]), ("rim.a", &[2]), ("rim.w", &[2]), ("rim.position", &[1]), ("rim.gap", &[1]),
            ("rim.discretisation_approach", &[1]), ("rim.stabilisation", &[]), ("rim.restitution", &[]),
            ("rim.contact_stiffness", &[]), ("rim.contact_damping", &[]),
        ];
        for ((name, extents), reference) in parts.into_iter().zip(6..) {
            variables += &array(name, reference, extents);
        }
        variables += &variable("rim.step", 16, "causality=\"parameter\" variability=\"tunable\" start=\"1\"");
        variables += "<Boolean name=\"rim.at_bound\" valueReference=\"17\" causality=\"output\"><Dimension start=\"1\"/></Boolean>";
    }
    let Offers { derivatives, state, .. } = offers;
    format!(
        "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"guest\" instantiationToken=\"{token}\"><CoSimulation \
         modelIdentifier=\"guest\" canHandleVariableCommunicationStepSize=\"true\" canGetAndSetFMUState=\"{state}\" \
         providesDirectionalDerivatives=\"{derivatives}\"/><ModelVariables>{variables}</ModelVariables></fmiModelDescription>"
    )
}

/// A folder with the library, or none where there is no C compiler.
fn compiled() -> Option<TempDir> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("guest.c"), SOURCE).unwrap();
    let compiler = Command::new("cc")
        .args(["-shared", "-fPIC", "-O1", "-ffp-contract=off", "-o", "guest.so", "guest.c"])
        .current_dir(folder.path())
        .status();
    if !compiler.is_ok_and(|status| status.success()) {
        eprintln!("skipped: there is no C compiler `cc` on the path");
        return None;
    }
    Some(folder)
}

/// Writes both sides and a case of them.
fn case(folder: &Path, mass: Offers, spring: Offers, more: &str, of_mass: &str) -> String {
    let library = fs::read(folder.join("guest.so")).unwrap();
    for (token, offers) in [("mass", mass), ("spring", spring)] {
        let mut archive = ZipWriter::new(fs::File::create(folder.join(format!("{token}.fmu"))).unwrap());
        let mut put = |name: &str, bytes: &[u8]| {
            archive.start_file(name, SimpleFileOptions::default().unix_permissions(0o755)).unwrap();
            archive.write_all(bytes).unwrap();
        };
        put("modelDescription.xml", description(token, offers).as_bytes());
        put(&format!("binaries/{}-linux/guest.so", std::env::consts::ARCH), &library);
        if offers.model {
            let manifest = "<m fmi-ls-name=\"rimbench.reduced-interface\" fmi-ls-version=\"0.3.0\"/>";
            put("extra/rimbench.reduced-interface/fmi-ls-manifest.xml", manifest.as_bytes());
        }
        archive.finish().unwrap();
    }
    let ends = "position = \"x\"\nvelocity = \"v\"\nforce = \"f\"\n";
    let text = format!(
        "name = \"guests\"\nduration_s = 0.5\nmacro_step_s = 1e-2\nmicro_step_s = 1e-3\n{more}\n[mechanics]\nfmu = \"mass.fmu\"\n{of_mass}\n\
         [actuator]\nfmu = \"spring.fmu\"\ndirect_feedthrough = true\n[[interface]]\n[interface.mechanics]\n{ends}\
         [interface.actuator]\n{ends}"
    );
    let file = folder.join("case.toml");
    fs::write(&file, text).unwrap();
    file.to_str().unwrap().to_owned()
}

/// One run: what it says, its trace, and what is shown besides.
fn run(file: &str, arguments: &[&str]) -> (Value, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let trace = folder.path().join("trace.csv");
    let mut command = rimbench();
    command.args(["simulate", "--format", "json", "--case", file, "--trace"]).arg(&trace).args(arguments);
    // 1 where it gives no answer.
    let output = command.assert().code(&[0, 1][..]).get_output().clone();
    let shown = String::from_utf8(output.stderr).unwrap();
    (serde_json::from_slice(&output.stdout).unwrap(), fs::read_to_string(trace).unwrap(), shown)
}

/// The largest difference between two traces, of the largest number in each column.
fn apart(one: &str, other: &str) -> f64 {
    let rows = |trace: &str| -> Vec<Vec<f64>> {
        trace.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
    };
    let (one, other) = (rows(one), rows(other));
    assert_eq!(one.len(), other.len());
    let columns = (0..one[0].len()).map(|column| {
        let largest = one.iter().map(|row| row[column].abs()).fold(0.0, f64::max);
        let apart = one.iter().zip(&other).map(|(a, b)| (a[column] - b[column]).abs()).fold(0.0, f64::max);
        if apart == 0.0 { 0.0 } else { apart / largest }
    });
    columns.fold(0.0, f64::max)
}

const STATE: Offers = Offers { derivatives: false, state: true, model: false };
const DERIVATIVES: Offers = Offers { derivatives: true, state: false, model: false };
const NOTHING: Offers = Offers { derivatives: false, state: false, model: false };

#[test]
fn a_smooth_model_comes_from_derivatives_else_from_probing_else_not_at_all() {
    let Some(folder) = compiled() else { return };
    let made = |mass: Offers| case(folder.path(), mass, NOTHING, "process = \"same\"", "");
    let smooth = ["--scheme", "rim-smooth", "--mechanics-steps", "all"];
    let (given, of_derivatives, _) = run(&made(DERIVATIVES), &smooth);
    assert_eq!(given["outcome"], "completed", "{given:#}");
    assert!(given.get("probed_fmus").is_none());
    // It is better than none.
    let (held, _, _) = run(&made(DERIVATIVES), &["--scheme", "zero-order-hold", "--mechanics-steps", "all"]);
    let error = |said: &Value| said["position_error_rms_m"].as_f64().unwrap();
    assert!(error(&given) < 0.2 * error(&held), "{} {}", error(&given), error(&held));
    // The mass is linear: it answers over its own step as it then steps, which derivatives do not.
    let (probed, of_probing, _) = run(&made(STATE), &smooth);
    assert_eq!(probed["outcome"], "completed", "{probed:#}");
    let quality = probed["probed_fmus"].as_object().unwrap().values().next().unwrap();
    assert_eq!(quality["count"], 50);
    let estimate = quality["error_max"].as_f64().unwrap();
    let apart = apart(&of_derivatives, &of_probing);
    assert!(estimate < 1e-6 && apart > 0.0 && apart < 0.1, "{apart} {estimate}");
    // Answers over another step than its own are off, and that is told.
    let (finer, _, _) = run(&case(folder.path(), STATE, NOTHING, "process = \"same\"", "probe_step_s = 1e-4"), &smooth);
    let finer = finer["probed_fmus"].as_object().unwrap().values().next().unwrap()["error_max"].as_f64().unwrap();
    assert!(finer > 1e-4, "{finer} {estimate}");
    // Contacts within are not contacts that open; there is nothing to choose from.
    for (arguments, words) in [
        (&["--scheme", "rim-nonsmooth"] as &[&str], "is a smooth one, whose contacts neither open nor close"),
        (&["--scheme", "rim-smooth", "--contact-detection", "margin:1e-3"], "contact_detection = margin:1e-3: "),
    ] {
        let (said, _, _) = run(&made(STATE), arguments);
        assert_eq!(said["outcome"], "skipped", "{arguments:?}: {said:#}");
        assert!(said["reason"].as_str().unwrap().contains(words), "{arguments:?}: {said:#}");
    }
    let (said, _, _) = run(&made(NOTHING), &smooth);
    assert_eq!(said["outcome"], "skipped");
    let reason = said["reason"].as_str().unwrap();
    assert!(reason.contains("no reduced interface model: its FMU has none, no directional derivatives"), "{reason}");
    assert!(reason.contains("cannot be probed"), "{reason}");
    // The same of an actuator.
    let jacobian = ["--scheme", "interface-jacobian"];
    let (said, _, _) = run(&made(DERIVATIVES), &jacobian);
    let reason = said["reason"].as_str().unwrap();
    assert!(reason.contains("offers no directional derivatives of its outputs: its FMU has no"), "{reason}");
    let (said, _, _) = run(&case(folder.path(), STATE, STATE, "", ""), &jacobian);
    assert_eq!(said["outcome"], "completed", "{said:#}");
    assert_eq!(said["probed_fmus"].as_object().unwrap().len(), 2, "{said:#}");
}

#[test]
fn derivatives_that_are_not_those_of_the_motion_are_called_so() {
    let Some(folder) = compiled() else { return };
    for state in [true, false] {
        for (fault, words) in
            [("6.0", "is 0, where"), ("7.0", "10.0 times"), ("8.0", "as of mm for m"), ("9.0", "reversed")]
        {
            // What answers less in steps one after the other, which cannot be taken again, may be stiff.
            if !state && fault == "7.0" {
                continue;
            }
            let offers = Offers { state, ..DERIVATIVES };
            let file = case(folder.path(), offers, NOTHING, "", &format!("start = {{ fault = {fault} }}"));
            let mut command = rimbench();
            let output = command.args(["simulate", "--scheme", "rim-smooth", "--case", &file]).assert().code(2);
            let shown = String::from_utf8(output.get_output().stderr.clone()).unwrap();
            assert_has(&shown, &["mass.fmu", "derivative", words]);
        }
    }
}

#[test]
fn truths_of_c_and_the_sign_of_nothing_are_read_as_they_are_meant() {
    let Some(folder) = compiled() else { return };
    let model = Offers { model: true, ..STATE };
    let traced = |truth: &str| {
        let start = format!("start = {{ fault = {truth} }}");
        let (said, trace, _) =
            run(&case(folder.path(), model, NOTHING, "", &start), &["--scheme", "rim-smooth-active"]);
        assert_eq!(said["outcome"], "completed", "{said:#}");
        trace
    };
    // 6 where it is below, 1, and 0 for ever.
    let [six, one, none] = ["0.0", "3.0", "4.0"].map(traced);
    assert!(six.lines().nth(1).unwrap().contains(",-0.0,"), "{six}");
    assert_eq!(six, one);
    assert_ne!(six, none);
}

#[test]
fn an_fmu_that_hangs_or_crashes_costs_one_run_and_what_it_printed_is_shown_only() {
    let Some(folder) = compiled() else { return };
    for (fault, words) in [("1.0", "no answer within 0.5 s"), ("2.0", "its process ended (signal: 6")] {
        let file = case(folder.path(), STATE, STATE, "answer_within_s = 0.5", "");
        // Its own reference would meet the fault: it is switched on for the run only.
        let text = fs::read_to_string(&file).unwrap();
        fs::write(&file, format!("{text}[parameters.fault]\ndefault = 0.0\nmechanics = \"fault\"\n")).unwrap();
        let began = Instant::now();
        let mut command = rimbench();
        command.args(["simulate", "--format", "json", "--case", &file, "--scheme", "zero-order-hold", "--set"]);
        // The reference of that parameter meets it first: an error of the command, with the same words.
        let shown = said(command.arg(format!("fault={fault}")), 2);
        assert!(began.elapsed() < Duration::from_secs(60));
        assert_has(&shown, &[words, "mass.fmu` printed:\n  /home/somebody/model.c: fault"]);
        let error = shown.lines().find(|line| line.starts_with("error: ")).unwrap();
        assert!(error.contains("mass.fmu") && !error.contains("somebody"), "{error}");
    }
}

#[test]
fn a_worker_ends_with_the_program_that_started_it_and_leaves_nothing() {
    let Some(folder) = compiled() else { return };
    let place = tempfile::tempdir().unwrap();
    let mark = folder.path().join("hangs");
    let file = case(folder.path(), STATE, STATE, "answer_within_s = 600", "start = { fault = 1.0 }");
    let mut child = process()
        .env("TMPDIR", place.path())
        .env("GUEST_MARK", &mark)
        .args(["simulate", "--case", &file, "--scheme", "zero-order-hold"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let workers = || -> Vec<String> {
        let all = Command::new("ps").args(["-eo", "pid=,stat=,args="]).output().unwrap();
        let all = String::from_utf8_lossy(&all.stdout).into_owned();
        // Which of the workers are those of this test their unpacked libraries say.
        let of_here = |line: &&str| {
            let pid = line.split_whitespace().next().unwrap_or_default();
            let maps = fs::read_to_string(format!("/proc/{pid}/maps")).unwrap_or_default();
            line.contains("fmu-worker") && maps.contains(place.path().to_str().unwrap())
        };
        all.lines().filter(of_here).map(str::to_owned).collect()
    };
    let wait_until = |what: &str, done: &dyn Fn() -> bool| {
        let began = Instant::now();
        while !done() {
            assert!(began.elapsed() < Duration::from_secs(120), "{what}");
            std::thread::sleep(Duration::from_millis(20));
        }
    };
    wait_until("nothing hangs", &|| mark.exists());
    assert!(!workers().is_empty());
    child.kill().unwrap();
    child.wait().unwrap();
    wait_until("a worker is left", &|| workers().is_empty());
    wait_until("files are left", &|| fs::read_dir(place.path()).unwrap().count() == 0);
}
