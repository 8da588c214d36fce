//! The command line as a user meets it: contracts of names and keys, and one clear error for each kind of bad input.

use crate::program::{assert_has, assert_refused, call, json, printed, refused, rimbench, rows_of, said};
use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;

fn simulate(line: &str) -> Command {
    call(&format!("simulate --case wedge-box {line}"))
}

/// The facts of a run of the wedge box.
fn facts(line: &str) -> Value {
    json(&mut simulate(&format!("--format json {line}")))
}

fn listed(what: &str) -> Vec<Value> {
    let Value::Array(list) = json(&mut call(&format!("list {what} --format json"))) else { panic!("{what}: no list") };
    list
}

/// The only linear case that is asked for its spectral radius here.
const SPECTRAL: &str = "limit --case linear-oscillator --scheme zero-order-hold --method spectral --set variant=1 \
                        --set coupling=displacement-displacement --from 1e-3 --format json";

#[test]
fn a_run_reports_outcome_metrics_and_counters_as_json() {
    let facts = facts("--scheme rim-nonsmooth --macro-step 5e-3");
    assert_eq!(facts["outcome"], "completed");
    assert_eq!(facts["diverged_at_s"], Value::Null);
    for metric in listed("metrics") {
        // What only friction has is not said of a case that has none.
        let said = facts.get(metric["name"].as_str().unwrap()).is_some();
        assert_eq!(said, metric["where"] == "" || metric["where"] == "the error is divided", "{metric}");
    }
    assert_eq!(facts["macro_steps"], 500);
    assert_eq!(facts["actuator_micro_steps"], 50_000);
    assert_eq!(facts["mechanics_micro_steps"], 500);
    // One contact problem per micro step, and none for the sake of a diagnostic; most of them have the active set of
    // the last one.
    let [solved, parametric] =
        ["scheme_lcp_solves", "scheme_parametric_steps"].map(|name| facts[name].as_u64().unwrap());
    assert_eq!(solved + parametric, 50_000);
    assert!(solved < 1000, "{solved} problems solved");
    for (key, value) in [("mechanics_steps", "1"), ("redundancy", "drop"), ("model_motion", "frozen")] {
        assert_eq!(facts[key], value, "{key}");
    }
    assert_eq!(facts["parameters"]["box_mass_kg"], 200.0);
    assert_eq!(facts["run_id"].as_str().unwrap().len(), 16);
}

#[test]
fn a_log_is_replayed_and_what_samples_cannot_be_is_one_error() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("times.csv");
    std::fs::write(&log, "time_s,computing_time_s\n0,0.001\n0.005,0.011\n").unwrap();
    let replayed =
        format!("--scheme nepce --macro-step 5e-3 --duration 0.1 --deadline 5ms --deadline-log {}", log.display());
    assert_eq!(facts(&replayed)["delivery_up"], "delay:0,missed:1*2");
    assert!(printed(&mut simulate(&replayed)).lines().next().unwrap().contains("samples late, delay:0,missed:1*2"));
    std::fs::write(&log, "time_s,computing_time_s\n0.005,0.001\n0,0.011\n").unwrap();
    assert_has(&refused(&mut simulate(&replayed)), &["times.csv", "line 3: time_s = 0 goes back from 0.005"]);
    // What the log says has places of its own in messages, and what is asked for besides is named as it was given.
    std::fs::write(&log, "time_s,computing_time_s\n0,0.001\n0.0075,0.011\n").unwrap();
    assert_has(&refused(&mut simulate(&replayed)), &["times.csv", "line 3: time_s = 0.0075 is between macro steps"]);
    std::fs::write(&log, "time_s,computing_time_s\n0,0.001\n0.005,0.011\n").unwrap();
    let late = refused(&mut simulate(&format!("{replayed} --delivery-up delay:900")));
    assert!(late.contains("--delivery-up = delay:900 is not valid"), "{late}");
    let all = "simulate --case wedge-box --macro-step 5e-3 --scheme";
    assert_refused(
        all,
        &[
            ("nepce --delivery-up delay:500", "delay and jitter below the 500 macro steps"),
            ("nepce --delivery-down loss:1", "from 0 to below 1"),
            ("iterated-aitken --delivery-up delay:1", "does not iterate"),
        ],
    );
}

#[test]
fn a_load_that_turns_round_while_samples_age_is_told_of_models_that_are_run_forward() {
    let said = |late: &str| {
        let car = "simulate --case half-car --scheme rim-nonsmooth-gap --macro-step 5ms --duration 1 --delivery-up";
        printed(&mut call(&format!("{car} {late}")))
    };
    let turns = "late samples      free acceleration turns round while they age: compare raw";
    for (late, told) in [("delay:10", true), ("delay:2", false), ("delay:10 --late-samples raw", false)] {
        let screen = said(late);
        assert_eq!(screen.contains(turns), told, "{late}: {screen}");
        assert!(screen.lines().all(|line| line.chars().count() <= 80), "{screen}");
    }
}

#[test]
fn steps_placed_by_the_model_are_asked_for_by_name_and_refused_without_a_model() {
    let placed = "--macro-step 5e-3 --duration 0.3 --step-control model-defect --step-tolerance 1e-3";
    let facts = facts(&format!("--scheme rim-nonsmooth-gap {placed}"));
    assert_eq!((&facts["outcome"], &facts["step_control"]), (&"completed".into(), &"model-defect".into()));
    assert!(facts["model_defect_rank"].is_number(), "{}", facts["model_defect_rank"]);
    assert_eq!(facts["exchanges"].as_u64(), facts["macro_steps"].as_u64().map(|steps| steps + 1));
    let message = refused(&mut simulate(&format!("--scheme zero-order-hold {placed}")));
    assert_has(&message, &["step-control = model-defect: scheme `zero-order-hold` has no reduced"]);
}

#[test]
fn what_determines_a_run_is_a_column_of_its_table_and_a_key_of_its_json() {
    let folder = tempfile::tempdir().unwrap();
    let experiment = folder.path().join("tuned.toml");
    let text = r#"
        question = "Does the table tell one gain from none?"
        macro_steps_s = [1e-2]
        [[cases]]
        name = "linear-oscillator"
        [[schemes]]
        scheme = "energy-leak-damper"
        gain = 0.5
        [[schemes]]
        scheme = "zero-order-hold"
    "#;
    std::fs::write(&experiment, text).unwrap();
    let out = folder.path().join("tuned");
    rimbench().arg("run").arg(&experiment).arg("--out").arg(&out).assert().success();
    let mut reader = csv::Reader::from_path(out.join("runs.csv")).unwrap();
    let header = reader.headers().unwrap().clone();
    let column = |name: &str| header.iter().position(|column| column == name).unwrap_or_else(|| panic!("{name}"));
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let gains: Vec<&str> = rows.iter().map(|row| &row[column("gain")]).collect();
    assert_eq!(gains, ["0.5", ""]);
    let line = "simulate --case linear-oscillator --scheme energy-leak-damper --gain 0.5 --macro-step 1e-2";
    let facts = json(&mut call(&format!("{line} --format json")));
    assert_eq!(facts["gain"], 0.5);
    assert_eq!(facts["run_id"], rows[0][column("run_id")]);
    // Every fact of a run stands in both; a key of one kind of scheme only is empty for the others.
    for name in ["redundancy", "model_motion", "mechanics_steps", "force_return", "sequence", "solver", "phase"] {
        column(name);
        assert!(facts.get(name).is_some(), "{name}");
    }
}

#[test]
fn rows_of_an_audited_experiment_say_by_parts_what_a_model_created_and_change_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let rows = |audit: &str| {
        let (file, out) = (folder.path().join("model.toml"), folder.path().join("model"));
        let text = format!(
            "question = \"?\"\nmacro_steps_s = [1e-3, 5e-3]\n{audit}\n[[cases]]\nname = \"bouncing-ball\"\n[[schemes]]\n\
             scheme = \"rim-smooth\"\n[[schemes]]\nscheme = \"zero-order-hold\"\n"
        );
        std::fs::write(&file, text).unwrap();
        rimbench().arg("run").arg(file).arg("--out").arg(&out).assert().success();
        rows_of(out.join("runs.csv"))
    };
    // In one folder: a run with an audit is another one, of which the other columns are the same.
    let (plain, audited) = (rows(""), rows("audit = true"));
    assert_eq!(rows(""), plain);
    for (plain, audited) in plain.iter().zip(&audited) {
        let same = |(key, cell): (&String, &String)| {
            (*cell == audited[key]) == (key != "run_id" || audited["audit"].is_empty())
        };
        assert!(plain.iter().all(same) && !plain.contains_key("audit") && !plain.contains_key("heaviness_max"));
        let (hold, number) = (audited["scheme"] == "zero-order-hold", |key: &str| audited[key].parse::<f64>());
        assert_eq!(audited["largest_jump_j"].is_empty(), hold);
        if hold {
            continue;
        }
        let parts = ["by_jump", "by_first_moment", "by_contacts", "unfrozen"];
        let parts = parts.map(|part| number(&format!("created_{part}_j")).unwrap());
        let size = parts.iter().fold(number("work_sent_j").unwrap().abs(), |sum, part| sum + part.abs());
        let rest = parts.iter().sum::<f64>() + number("interface_residual_j").unwrap();
        assert!(parts[0].abs() > 1.0 && rest.abs() < 1e-13 * size, "{parts:?}: {rest:e}");
    }
    let only_a_hold = "question = \"?\"\naudit = true\nmacro_steps_s = [1e-3]\n[[cases]]\nname = \"bouncing-ball\"\n[[schemes]]\nscheme = \"nepce\"\n";
    let file = folder.path().join("hold.toml");
    std::fs::write(&file, only_a_hold).unwrap();
    assert_has(&refused(rimbench().arg("run").arg(file)), &["audit = true: no scheme has an interface model"]);
}

#[test]
fn what_a_run_is_said_to_be_is_so_of_that_run() {
    let of = |line: &str| printed(&mut call(line)).split_whitespace().collect::<Vec<_>>().join(" ");
    // Numbers of a run that diverges are those of all its steps.
    let diverged = of("simulate --case wedge-box --scheme zero-order-hold --macro-step 5ms");
    assert_has(&diverged, &["diverged at 125 ms", "peak of 1.01 kN; what follows is up to 160 ms"]);
    // What is no number is neither created nor lost, and so is what there was no step for.
    let beyond = of("simulate --case random-body --scheme zero-order-hold --macro-step 20ms");
    assert_has(&beyond, &["what the interface created or lost is no finite number"]);
    assert!(!beyond.contains("not a number"), "{beyond}");
    let mut late = call("simulate --case wedge-box --scheme zero-order-hold --wall-limit 1e-9");
    assert!(!String::from_utf8_lossy(&late.output().unwrap().stdout).contains("energy"));
    // No jump gains, and the mass does.
    let heavy = of("simulate --case wedge-box --scheme rim-nonsmooth --macro-step 5ms --audit --belief mass:3");
    assert_has(&heavy, &["no jump to the mechanics gained energy; its mass created 1.37 J in all"]);
    // What nothing bounds is not stable because it is finite.
    let scan = "--from 1ms --to 10ms --per-decade 3 --relative-tolerance 0.5";
    let finite = of(&format!("limit --case random-body --scheme zero-order-hold {scan}"));
    assert!(finite.starts_with("finite up to") && finite.contains("not held against a reference"), "{finite}");
    // A linear case that grows slowly, and a prediction that is not of late samples.
    let slow = of(&format!("limit --case linear-oscillator --scheme zero-order-hold {scan}"));
    assert_has(
        &slow,
        &["stable up to", "spectral radius unstable from the smallest macro step on (--method spectral)"],
    );
    let sound = of(&format!("limit --case quarter-car --scheme zero-order-hold {scan}"));
    assert!(!sound.contains("spectral"), "{sound}");
    let predicted = |line: &str| of(&format!("limit --case wedge-box --scheme zero-order-hold {scan} {line}"));
    assert!(predicted("").contains("predicted"));
    for line in ["--delivery-up delay:1", "--step-control energy-residual --step-tolerance 1e-3"] {
        assert!(!predicted(line).contains("predicted"), "{line}");
    }
    // Truths are truths in JSON.
    let facts = facts("--scheme rim-nonsmooth --macro-step 5ms --audit");
    assert_eq!((&facts["audit"], &facts["model_exact"]), (&Value::Bool(true), &Value::Bool(false)));
}

#[test]
fn options_go_by_the_names_that_were_typed() {
    let said = |line: &str| refused(&mut simulate(&format!("--scheme rim-nonsmooth {line}")));
    for (line, wanted) in [
        ("--duration 1ms", "--macro-step = 0.005, the default, is not valid"),
        ("--macro-step 5 --duration 1", "--macro-step = 5 is not valid"),
        ("--macro-step 1ns", "--macro-step = 0.000000001 is not valid"),
        ("--micro-step 1ns", "--micro-step = 0.000000001 is not valid"),
        ("--mechanics-step 5ns --duration 10", "--mechanics-step = 0.000000005 is not valid"),
        ("--mechanics-steps 1000000 --duration 10", "--mechanics-steps = 1000000 is not valid"),
        ("--delivery-down delay:-1", "--delivery-down = delay:-1 is not valid"),
        ("--mechanics-steps 5 --mechanics-step 1ms", "--mechanics-steps = 5 and --mechanics-step = 0.001: give one"),
        (
            "--min-macro-step 1ms",
            "--min-macro-step is given but nothing controls the step: add --step-control energy-residual",
        ),
    ] {
        assert_has(&said(line), &[wanted]);
    }
}

#[test]
fn a_number_that_is_none_is_told_with_what_is_needed() {
    for (line, wanted) in [
        ("run x.toml --jobs -1", "invalid value '-1' for '--jobs <N>': a whole number from 0 is needed"),
        ("run x.toml --jobs 1.5", "a whole number from 0 is needed"),
        ("run x.toml --jobs 99999999999999999999999", "a smaller number is needed"),
        ("limit --case wedge-box --scheme nepce --per-decade -1", "for '--per-decade"),
        ("limit --case wedge-box --scheme nepce --relative-tolerance x", "a number is needed"),
    ] {
        let message = refused(&mut call(line)).split_whitespace().collect::<Vec<_>>().join(" ");
        assert_has(&message, &[wanted]);
        assert!(!message.contains("-- -1"), "{message}");
    }
}

#[test]
fn what_needs_another_option_is_not_passed_over_where_a_third_excludes_that() {
    for line in [
        "report results --out page.html",
        "report --open --out page.html",
        "report --open --group paper",
        "report --open --file a.toml",
        "report --pdf --group paper",
        "run x.toml --first-shard 0 --places 0-1",
        "run x.toml --first-shard 0 --dry-run",
        "run x.toml --all --jobs 2",
        "run x.toml --all --shard 1/2",
        "run x.toml --format json --fresh",
        "run x.toml --chunk-time 1s --jobs 2",
        "run x.toml --cpus 2 --collect a",
        "run x.toml --at-once 2 --shard 1/2",
        "run x.toml --exclusive --fresh",
        "run x.toml --jobs 2 -- --mem=1G",
        "reproduce --quick --only study/friction",
    ] {
        let message = refused(&mut call(line));
        assert!(message.contains("cannot be used with") || message.contains("not provided"), "{line}: {message}");
    }
}

#[test]
fn a_diverged_run_is_a_result_with_exit_code_zero() {
    let facts = facts("--scheme zero-order-hold --macro-step 5e-3");
    assert_eq!(facts["outcome"], "diverged");
    assert!(facts["diverged_at_s"].as_f64().unwrap() < 0.25);
    assert!(facts["reason"].as_str().unwrap().contains("actuator_force_n"));
}

#[test]
fn a_trace_has_the_columns_of_the_contract() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trace.csv");
    simulate("--scheme rim-nonsmooth --macro-step 5e-3 --phase 0.3 --trace").arg(&path).assert().success();
    let mut reader = csv::Reader::from_path(&path).unwrap();
    let header: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let contract = "time_s, box_x_m, box_y_m, box_angle_rad, actuator_length_m, actuator_velocity_m_s, actuator_force_n, \
         force_to_mechanics_n, pressure_1_pa, pressure_2_pa, effective_mass_kg, gap_right_wedge_m, gap_left_wedge_m, \
         gap_disc_ledge_m, gap_disc_floor_m, closed_contacts, rank_h_uu";
    // What drawings need stands behind.
    assert!(header.join(", ").starts_with(contract), "{header:?}");
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    // One row per communication point: start, 0.3 H, then every H, and the end.
    let times: Vec<f64> = rows.iter().map(|row| row[0].parse().unwrap()).collect();
    for (found, wanted) in times.iter().zip([0.0, 0.0015, 0.0065]) {
        approx::assert_abs_diff_eq!(*found, wanted, epsilon = 1e-15);
    }
    assert_eq!(*times.last().unwrap(), 2.5);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
}

#[test]
fn options_reach_the_run() {
    let changed = |extra: &str| facts(&format!("--scheme rim-nonsmooth-gap --duration 0.8 {extra}"));
    for (extra, fact, wanted) in [
        ("--mechanics-steps 5 --force-return profile", "mechanics_micro_steps", Value::from(800)),
        ("--mechanics-steps all", "mechanics_micro_steps", Value::from(16_000)),
        ("--mechanics-step 1ms", "mechanics_micro_steps", Value::from(800)),
        ("--mechanics-step 1ms", "mechanics_step_s", Value::from(1e-3)),
        ("--micro-step 1e-4", "actuator_micro_steps", Value::from(8_000)),
        ("--sequence jacobi", "force_return", Value::from("held")),
        ("--force-return end", "sequence", Value::from("gauss-seidel")),
    ] {
        assert_eq!(changed(extra)[fact], wanted, "{extra}");
    }
    let error = |extra: &str| changed(extra)["force_error_rms_n"].clone();
    for extra in ["--set box_mass_kg=250", "--phase 0.3", "--model-motion extrapolated"] {
        assert_ne!(error(extra), error(""), "{extra}");
    }
}

#[test]
fn lists_have_the_promised_keys() {
    for what in ["cases", "schemes", "solvers", "metrics", "parameters"] {
        let list = listed(what);
        assert!(!list.is_empty());
        for entry in list {
            assert!(entry["name"].is_string() && entry["about"].is_string(), "{what}: {entry}");
        }
        if what != "parameters" {
            call(&format!("list {what}")).assert().success();
        }
    }
    // All parameters of all cases are some nine hundred lines.
    let output = call("list parameters").output().unwrap();
    assert!(output.status.code() == Some(2) && String::from_utf8_lossy(&output.stderr).contains("needs a case"));
    let output = call("list parameters --case wedge-box").output().unwrap();
    assert!(String::from_utf8_lossy(&output.stdout).contains("200.0 kg · "), "{output:?}");
}

#[test]
fn what_is_wrong_with_a_command_line_is_said_as_every_error_is() {
    for (words, wanted) in [
        ("frobnicate", ["frobnicate", "`rimbench --help` lists"]),
        ("simulate --cse wedge-box", ["--cse", "similar argument exists: '--case'"]),
        ("simulate --case wedge-box", ["--scheme", "`rimbench simulate --help` lists"]),
        ("list everything", ["parameters", "`rimbench --help` lists"]),
    ] {
        let output = call(words).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).replace("\n      ", " ");
        assert_eq!(output.status.code(), Some(2), "{words}");
        assert!(said.starts_with("error: ") && said.contains("\nhelp: ") && !said.contains("For more"), "{said}");
        assert!(wanted.iter().all(|wanted| said.contains(wanted)), "{words}: {said}");
    }
    let version = call("--version").output().unwrap();
    assert!(String::from_utf8_lossy(&version.stdout).contains(", numerics "), "{version:?}");
    let parameters = listed("parameters --case wedge-box");
    let names: Vec<&str> = parameters.iter().map(|entry| entry["name"].as_str().unwrap()).collect();
    let promised = "box_mass_kg disc_mass_kg disc_radius_m disc_pin_x_m disc_pin_y_m wedge_tip_x_m wedge_tip_y_m \
                    ledge_height_m ledge_lead_m ramp_slope attachment_x_m attachment_y_m ground_pin_x_m piston_area_m2 \
                    cylinder_length_m viscous_friction_n_s_m valve_area_m2 spool_final stabilisation";
    for key in promised.split_whitespace() {
        assert!(names.contains(&key), "{key}");
    }
    for entry in parameters {
        assert!(entry["unit"].is_string() && entry["source"].is_string() && !entry["default"].is_null(), "{entry}");
    }
}

#[test]
fn a_cache_that_is_damaged_or_cannot_be_written_costs_time_not_results() {
    let folder = tempfile::tempdir().unwrap();
    let run = |cache: &Path| {
        let mut command = simulate("--scheme rim-nonsmooth --duration 0.2 --format json");
        let mut facts = json(command.env("RIMBENCH_CACHE", cache));
        let note = String::from_utf8(command.assert().get_output().stderr.clone()).unwrap();
        assert_eq!(note.contains("note: the cache of references is of no use here"), cache.is_file(), "{note}");
        let machine = |key: &str| {
            key.starts_with("latency_") || ["wall_s", "real_time_factor", "missed_deadlines"].contains(&key)
        };
        facts.as_object_mut().unwrap().retain(|key, _| !machine(key));
        facts
    };
    let first = run(folder.path());
    for entry in std::fs::read_dir(folder.path()).unwrap() {
        let path = entry.unwrap().path();
        let mut bytes = std::fs::read(&path).unwrap();
        bytes.truncate(bytes.len() / 2);
        std::fs::write(&path, bytes).unwrap();
    }
    assert_eq!(run(folder.path()), first);
    let unusable = folder.path().join("file");
    std::fs::write(&unusable, "").unwrap();
    assert_eq!(run(&unusable), first);
}

#[test]
fn the_stability_limit_has_the_promised_keys_and_is_bracketed() {
    let limit = |line: &str| json(&mut call(&format!("limit --format json {line}")));
    let run = limit("--case wedge-box --scheme zero-order-hold --duration 0.4 --phases 2");
    let (stable, unstable) = (run["last_stable_s"].as_f64().unwrap(), run["first_unstable_s"].as_f64().unwrap());
    assert!(1e-3 < stable && unstable < 3e-3 && unstable / stable <= 1.01, "{stable} {unstable}");
    assert_eq!(run["stability_limit_s"], run["last_stable_s"]);
    // What the screen says beside the limit is there as well.
    assert!(run["bounded"] == true && run["predicted_stable_s"].is_number() && run["spectral_stable_s"].is_null());
    let points = run["fraction_stable"].as_array().unwrap();
    for point in points {
        let (step, fraction) = (point["macro_step_s"].as_f64().unwrap(), point["fraction_stable"].as_f64().unwrap());
        assert!(step > stable || fraction == 1.0, "{point}");
    }
    // The spectral radius of a linear case.
    assert!(json(&mut call(&format!("{SPECTRAL} --to 1e-2")))["fraction_stable"][0]["spectral_radius"].is_number());
    let refusal = said(&mut call("limit --case wedge-box --scheme zero-order-hold --method spectral"), 2);
    assert!(refusal.contains("not linear"), "{refusal}");
}

/// Every place of a JSON document where there is an object, with the object.
fn objects<'a>(value: &'a Value, found: &mut Vec<&'a serde_json::Map<String, Value>>) {
    match value {
        Value::Object(object) => {
            found.push(object);
            object.iter().filter(|(key, _)| *key != "not_finite").for_each(|(_, value)| objects(value, found));
        }
        Value::Array(values) => values.iter().for_each(|value| objects(value, found)),
        _ => {}
    }
}

#[test]
fn what_is_not_finite_is_null_in_json_and_named_beside_it() {
    // A locked interface has an infinite effective mass.
    let documents = [
        "simulate --case wedge-box --scheme rim-smooth --contact-detection margin:1e-3 --macro-step 5e-3 --format json",
        "simulate --case linear-oscillator --scheme rim-nonsmooth-gap --format json",
        "list parameters --format json",
        &format!("{SPECTRAL} --to 1e-2"),
    ]
    .map(|line| json(&mut call(line)));
    let mut named = 0;
    for document in &documents {
        let mut found = Vec::new();
        objects(document, &mut found);
        assert!(!found.is_empty());
        for object in found {
            for (key, value) in object {
                let text = value.as_str().unwrap_or_default().to_lowercase();
                assert!(!["inf", "-inf", "infinity", "nan"].contains(&text.as_str()), "{key}: {value}");
            }
            let not_finite = object.get("not_finite").and_then(|map| map.as_object());
            for (key, text) in not_finite.into_iter().flatten() {
                assert!(object[key].is_null(), "{key} has a value and none");
                assert!(["inf", "-inf", "nan"].contains(&text.as_str().unwrap()), "{key}: {text}");
                named += 1;
            }
        }
    }
    assert!(named > 0, "nothing infinite among them: the check sees nothing");
}

#[test]
fn a_limit_is_found_by_the_default_scan_of_every_duration_and_as_closely_as_one_likes() {
    // 1.2 ms long: macro steps up to 0.1 s would be none.
    let bar = "limit --case elastic-bar --scheme zero-order-hold";
    let scan = json(&mut call(&format!("{bar} --per-decade 2 --relative-tolerance 0.5 --format json")));
    let steps: Vec<f64> =
        scan["fraction_stable"].as_array().unwrap().iter().map(|at| at["macro_step_s"].as_f64().unwrap()).collect();
    assert!(steps.len() >= 3 && steps.iter().all(|step| *step <= 1.2e-4), "{steps:?}");
    let spectral =
        |tolerance: &str| call(&format!("{SPECTRAL} --to 1e-1 --per-decade 4 --relative-tolerance {tolerance}"));
    let width = |tolerance: &str| {
        let found = json(&mut spectral(tolerance));
        let (stable, unstable) = (found["last_stable_s"].as_f64(), found["first_unstable_s"].as_f64());
        stable.zip(unstable).map(|(stable, unstable)| unstable / stable - 1.0)
    };
    if let (Some(wide), Some(narrow)) = (width("0.1"), width("1e-6")) {
        assert!(wide <= 0.1 && wide > 1e-3 && narrow <= 1e-6, "{wide} {narrow}");
    }
    for tolerance in ["0", "-1", "nan", "1e-300", "2"] {
        let message = refused(&mut spectral(tolerance));
        assert!(message.contains("relative-tolerance = ") && message.len() < 200, "{message}");
    }
}

#[test]
fn a_run_without_claims_shows_medians_and_failures_by_case_scheme_and_step_and_goes_on_in_plain_lines() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("plain.toml");
    let text = "question = \"?\"\nmacro_steps_s = [1e-3, 5e-3]\nphases = 2\nduration_s = 0.5\n[[cases]]\nname = \"wedge-box\"\n\
                [[schemes]]\nscheme = \"zero-order-hold\"\n[[schemes]]\nscheme = \"rim-nonsmooth\"\n";
    std::fs::write(&file, text).unwrap();
    let run = || printed(rimbench().arg("run").arg(&file).arg("--out").arg(folder.path().join("out")));
    // The second start computes nothing, and still tells of all that is stored.
    for _ in 0..2 {
        let printed = run();
        let row = |label: &str, step: &str| {
            let found = printed.lines().find(|line| line.starts_with(label) && line.contains(step));
            found.unwrap_or_else(|| panic!("no row of {label} at {step}: {printed}")).to_owned()
        };
        assert!(row("rim-nonsmooth", " 5 ms ").contains("2/2"), "{printed}");
        assert!(row("zero-order-hold", " 5 ms ").contains("0/2, 2 failed"), "{printed}");
        assert!(printed.contains("Of all 8 runs of plain, 2 did not complete."), "{printed}");
    }
}

#[test]
fn a_range_of_more_macro_steps_than_there_may_be_runs_is_refused_wherever_it_is_given() {
    let huge = "--from 1e-300 --to 1e300 --per-decade 1000";
    for (command, to) in [("limit --scheme zero-order-hold", "1e300"), ("limit --scheme rim-smooth", "1e-1")] {
        let range = huge.replace("1e300", to);
        let said = refused(&mut call(&format!("{command} --case bouncing-ball {range}")));
        assert!(said.contains("at most 100000 macro steps between"), "{said}");
    }
    let said = refused(&mut call("advise --case bouncing-ball --error 1% --from 1e-300 --to 1 --per-decade 1000"));
    assert!(said.contains("at most 100000 macro steps between"), "{said}");
}

#[test]
fn a_run_is_plotted_beside_its_reference_and_a_belief_is_traced_per_micro_step() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let plotted = "--scheme rim-nonsmooth --macro-step 5e-3 --plot";
    simulate(plotted).arg(place("run.svg")).assert().success();
    let svg = std::fs::read_to_string(place("run.svg")).unwrap();
    assert_has(&svg, &["actuator length (m)", "actuator force (N)", "contact closed", "1 right wedge", "reference"]);
    simulate(plotted).arg(place("run.png")).assert().success();
    assert!(std::fs::read(place("run.png")).unwrap().starts_with(b"\x89PNG"));
    assert_has(&refused(simulate(plotted).arg(place("run.jpg"))), &["run.jpg", "must end in .svg, .png or .pdf"]);
    if !cfg!(feature = "pdf") {
        assert_has(&refused(simulate(plotted).arg(place("run.pdf"))), &["run.pdf", "--features pdf"]);
    }
    let believed = "--scheme rim-nonsmooth --macro-step 5e-3 --believe-at";
    simulate(&format!("{believed} 1.695s --trace")).arg(place("belief.csv")).assert().success();
    let belief = std::fs::read_to_string(place("belief.csv")).unwrap();
    assert!(belief.starts_with("time_s,") && belief.lines().count() == 1 + 101, "{belief}");
    let late = refused(simulate(&format!("{believed} 2.5s --trace")).arg(place("late.csv")));
    assert!(late.contains("ends within 2.5 s") && !place("late.csv").exists(), "{late}");
}
