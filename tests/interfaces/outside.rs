//! Sides from outside are not believed: an FMU with one fault, switched on by name, is found out, heard or set right,
//! for FMI 2.0 and 3.0.
#![cfg(target_os = "linux")]

use crate::faulty_guest::{
    Guest, MASS, POSITION, SIDES, SPRING, case, inside, last, output, python, refused, run, write_case,
};
use crate::program::assert_has;
use serde_json::Value;
use std::fs;
use std::path::Path;

#[test]
fn a_state_that_does_not_come_back_leaves_plain_schemes_and_skips_the_others_with_the_reason() {
    for version in [2, 3] {
        for faults in [&["FORGETS_V"], &["SHALLOW"]] {
            let Some(folder) = case(&Guest { version, faults, ..MASS }, &SPRING, &[]) else { return };
            for scheme in ["rim-smooth", "rim-answers", "iterated-aitken"] {
                let (said, _) = run(folder.path(), &format!("--scheme {scheme}"));
                assert_eq!(said["outcome"], "skipped", "{faults:?} {scheme}: {said:#}");
                let reason = said["reason"].as_str().unwrap();
                assert_has(reason, &["the state of the mechanics does not come back", "zero-order-hold"]);
            }
            let (said, _) = run(folder.path(), "--scheme zero-order-hold");
            assert_eq!(said["outcome"], "completed", "{said:#}");
        }
        // The same without a fault.
        let Some(folder) = case(&Guest { version, ..MASS }, &Guest { version, ..SPRING }, &[]) else { return };
        for scheme in ["rim-smooth", "iterated-aitken", "interface-jacobian"] {
            let (said, _) = run(folder.path(), &format!("--scheme {scheme}"));
            assert_eq!(said["outcome"], "completed", "{scheme}: {said:#}");
        }
    }
}

#[test]
fn a_force_with_the_wrong_sign_is_found_with_states_and_without() {
    for state in [true, false] {
        let Some(folder) = case(&Guest { state, ..MASS }, &SPRING, &[]) else { return };
        let reversed = "{ variable = \"f\", factor = -1.0 } }\nactuator";
        write_case(folder.path(), &[("\"f\" }\nactuator", reversed)]);
        assert_has(&refused(folder.path()), &["mass.fmu", "the sign of the force is reversed", "factor = -1"]);
        // Of the actuator it may be meant.
        write_case(
            folder.path(),
            &[(
                "actuator = { position = \"x\", velocity = \"v\", force = \"f\"",
                "actuator = { position = \"x\", \
                   velocity = \"v\", force = { variable = \"f\", factor = -1.0 }",
            )],
        );
        let shown = String::from_utf8_lossy(&output(folder.path(), "--scheme zero-order-hold").stderr).into_owned();
        assert_has(&shown, &["note: ", "case.toml", "the actuator", "its sign is reversed"]);
        // Both count it the other way round: signals do not mind, a model does.
        let minus = ("force = \"f\"", "force = { variable = \"f\", factor = -1.0 }");
        write_case(folder.path(), &[minus, minus]);
        let (said, shown) = run(folder.path(), "--scheme zero-order-hold");
        assert_eq!(said["outcome"], "completed", "{said:#}");
        assert_has(&shown, &["note: ", "a factor of -1 on both sides"]);
        if state {
            let (said, _) = run(folder.path(), "--scheme rim-smooth");
            assert_has(said["reason"].as_str().unwrap(), &["the sign of the force is reversed", "zero-order-hold"]);
        }
    }
}

/// What the help of an error says to use.
fn help(shown: &str) -> &str {
    shown.lines().find_map(|line| line.strip_prefix("help: use ")).unwrap_or_else(|| panic!("no help: {shown}"))
}

#[test]
fn whoever_does_what_a_help_says_gets_a_right_run() {
    let exact = 0.1 * f64::cos(2.0);
    for (version, state) in [(2, true), (3, true), (3, false)] {
        let plain = Guest { version, state, ..MASS };
        let Some(folder) = case(&plain, &Guest { version, ..SPRING }, &[]) else { return };
        // Within the FMU, and in the case file of one that is right.
        for (name, variable, fault) in
            [("position", "x", "X_TIMES=-1"), ("velocity", "v", "V_TIMES=-1"), ("force", "f", "F_TIMES=-1")]
        {
            let of_file = format!("{name} = {{ variable = \"{variable}\", factor = -1.0 }}");
            let as_it_is = format!("{name} = \"{variable}\"");
            for (faults, written) in [(&[fault][..], &as_it_is), (&[], &of_file)] {
                Guest { faults, ..plain }.packed(&folder.path().join("mass.fmu")).unwrap();
                write_case(folder.path(), &[(&as_it_is, written)]);
                let shown = refused(folder.path());
                assert_has(&shown, &["mass.fmu", name, "reversed"]);
                write_case(folder.path(), &[(&as_it_is, help(&shown))]);
                let found = last(folder.path(), POSITION);
                assert!((found - exact).abs() < 5e-3, "FMI {version}, {faults:?}: {found} {exact}");
            }
        }
    }
}

#[test]
fn a_position_or_a_velocity_in_another_unit_is_called_so_and_so_is_a_clock() {
    for (version, fault, words) in [
        (2, "X_TIMES=1000", ["position and velocity do not add up", "as of mm for m"]),
        (3, "V_TIMES=1000", ["position and velocity do not add up", "as of mm for m"]),
        (3, "TIME_MS", ["position and velocity do not add up", "its clock"]),
        (2, "X_TIMES=0", ["the position is none", "stands"]),
        (3, "V_TIMES=0", ["the velocity is none", "is 0"]),
    ] {
        let faults = [fault];
        let Some(folder) = case(&Guest { version, faults: &faults, ..MASS }, &SPRING, &[]) else { return };
        assert_has(&refused(folder.path()), &[&["mass.fmu"], &words[..]].concat());
    }
}

#[test]
fn a_reference_that_is_beyond_every_machine_is_none_and_has_no_limit() {
    for version in [2, 3] {
        let Some(folder) = case(&Guest { version, faults: &["HUGE_BELOW=5e-4"], ..MASS }, &SPRING, &[]) else { return };
        assert_has(&refused(folder.path()), &["has no reference", "interface_force_n is uncertain by"]);
        let limit =
            inside(folder.path()).args(["limit", "--case", "case.toml", "--scheme", "zero-order-hold"]).output();
        let limit = limit.unwrap();
        assert_eq!(limit.status.code(), Some(2));
        assert_has(&String::from_utf8_lossy(&limit.stderr), &["has no reference"]);
    }
    // What runs away by itself has a reference, and no limit either.
    let Some(folder) = case(&MASS, &Guest { faults: &["F_TIMES=-1"], ..SPRING }, &[("0.2", "1.0")]) else { return };
    let limit =
        inside(folder.path()).args(["limit", "--case", "case.toml", "--scheme", "zero-order-hold"]).output().unwrap();
    assert_eq!(limit.status.code(), Some(2));
    assert_has(&String::from_utf8_lossy(&limit.stderr), &["has no stability limit", "runs away by itself"]);
    // In runs of an experiment it is data.
    let grid = "question = \"?\"\nmacro_steps_s = [1e-3]\n[[cases]]\nname = \"pair\"\n[[schemes]]\nscheme = \"zero-order-hold\"\n";
    let Some(folder) = case(&Guest { faults: &["HUGE_BELOW=5e-4"], ..MASS }, &SPRING, &[]) else { return };
    fs::write(folder.path().join("grid.toml"), grid).unwrap();
    let output =
        inside(folder.path()).args(["--case-file", "case.toml", "run", "grid.toml", "--out", "out"]).output().unwrap();
    assert!(output.status.code().is_some_and(|code| code < 2), "{}", String::from_utf8_lossy(&output.stderr));
    let rows = fs::read_to_string(folder.path().join("out/runs.csv")).unwrap();
    assert!(rows.contains(",skipped,") && rows.contains("has no reference"), "{rows}");
}

#[test]
fn sides_begin_with_what_the_other_one_says_and_are_told_when_the_run_ends() {
    for version in [2, 3] {
        // Unstretched where the mass is when initialisation ends.
        let spring = Guest { version, faults: &["REST_AT_START"], ..SPRING };
        let Some(folder) = case(&Guest { version, faults: &["NEEDS_STOP"], ..MASS }, &spring, &[]) else { return };
        assert_eq!(last(folder.path(), "interface_force_n"), 0.0);
    }
}

#[test]
fn what_an_fmu_says_is_heard() {
    for version in [2, 3] {
        let Some(folder) = case(&Guest { version, faults: &["WARNS_AT=0.15"], ..MASS }, &SPRING, &[]) else { return };
        let (said, shown) = run(folder.path(), "--scheme zero-order-hold");
        let warnings = said["fmu_warnings"].as_object().unwrap().values().next().unwrap().as_u64().unwrap();
        assert!((48..=51).contains(&warnings), "{said:#}");
        assert_has(&shown, &["mass.fmu returned Warning", "not the time that was expected"]);
        // With the arguments of printf, in FMI 2.0 as well.
        MASS_FAILS.with(version).packed(&folder.path().join("mass.fmu")).unwrap();
        assert_has(&refused(folder.path()), &["step refused at t = 0.1", ": no solution"]);
        // With its log switched on it is shown as it comes.
        write_case(folder.path(), &[("fmu = \"mass.fmu\"", "fmu = \"mass.fmu\"\nlog = true")]);
        assert_has(&refused(folder.path()), &["mass.fmu: step refused at t = 0.1"]);
    }
    // It does not come to the end of its steps, and says so.
    let Some(folder) = case(&Guest { faults: &["LAGS", "H_INT=7e-4"], ..MASS }, &SPRING, &[]) else { return };
    assert_has(&refused(folder.path()), &["mass.fmu", "lastSuccessfulTime"]);
}

const MASS_FAILS: Guest<'_> = Guest { faults: &["FAIL_AT=0.1"], ..MASS };

impl<'a> Guest<'a> {
    fn with(&self, version: u32) -> Guest<'a> {
        Guest { version, faults: self.faults, changes: self.changes, role: self.role, state: self.state }
    }
}

const PARAMETER: &str = "<Float64 name=\"d\"";

#[test]
fn descriptions_mean_what_they_say() {
    let end = "</UnitDefinitions>";
    let unit = "<Unit name=\"ms\"><BaseUnit s=\"1\" factor=\"0.001\"/></Unit></UnitDefinitions>";
    let time = |unit: &str| {
        format!(
            "<ModelVariables><Float64 name=\"time\" valueReference=\"20\" causality=\"independent\" variability=\"continuous\" unit=\"{unit}\"/>"
        )
    };
    let (in_ms, in_weeks) = (time("ms"), time("week"));
    let changes = [(end, unit), ("<ModelVariables>", &*in_ms)];
    let Some(folder) = case(&Guest { faults: &["TIME_MS"], changes: &changes, ..MASS }, &SPRING, &[]) else { return };
    let exact = 0.1 * f64::cos(2.0);
    assert!((last(folder.path(), POSITION) - exact).abs() < 5e-3);
    // A unit of time that nobody knows.
    Guest { changes: &[("<ModelVariables>", &*in_weeks)], ..MASS }.packed(&folder.path().join("mass.fmu")).unwrap();
    assert_has(&refused(folder.path()), &["independent variable `time`", "`week`", "no offset"]);
    // A difference has no offset.
    let offset = "<Unit name=\"m\"><BaseUnit m=\"1\" offset=\"5\"/>";
    let relative =
        [("<Unit name=\"m\"><BaseUnit m=\"1\"/>", offset), ("unit=\"m\"", "relativeQuantity=\"true\" unit=\"m\"")];
    Guest { changes: &relative, ..MASS }.packed(&folder.path().join("mass.fmu")).unwrap();
    assert!((last(folder.path(), POSITION) - exact).abs() < 5e-3);
    Guest { changes: &relative[..1], ..MASS }.packed(&folder.path().join("mass.fmu")).unwrap();
    assert!(last(folder.path(), POSITION).abs() > 1.0);
    // A type that there is not.
    Guest { changes: &[(PARAMETER, "<Float64 declaredType=\"Damping\" name=\"d\"")], ..MASS }
        .packed(&folder.path().join("mass.fmu"))
        .unwrap();
    assert_has(&refused(folder.path()), &["variable `d`", "`Damping`", "not among <TypeDefinitions>"]);
    // One variable for two things.
    MASS.packed(&folder.path().join("mass.fmu")).unwrap();
    for (from, to) in [
        ("fmu = \"mass.fmu\"", "fmu = \"mass.fmu\"\nstart = { f = 1.0 }"),
        ("velocity = \"v\"", "velocity = { variable = \"x\", factor = 1.0 }"),
    ] {
        write_case(folder.path(), &[(from, to)]);
        let said = refused(folder.path());
        assert!(
            ["is coupled and has a start value", "no unit like m/s"].iter().any(|words| said.contains(words)),
            "{said}"
        );
    }
    let alias = [("unit=\"m/s\"/>", "unit=\"m/s\"><Alias name=\"v2\"/></Float64>"), ("unit=\"m\"/>", "/>")];
    Guest { changes: &alias, ..MASS }.packed(&folder.path().join("mass.fmu")).unwrap();
    write_case(
        folder.path(),
        &[("position = \"x\"", "position = { variable = \"v\", factor = 1.0 }"), ("unit", "unit")][..0],
    );
    let two = "[[interface]]\nmechanics = { position = \"x\", velocity = \"v2\", force = \"f\" }\nactuator = { position = \"x\", velocity = \
               \"v\", force = \"f\" }\n[[interface]]";
    write_case(folder.path(), &[("[[interface]]", two)]);
    assert_has(&refused(folder.path()), &["is named in two places of the case"]);
}

#[test]
fn legal_fmus_are_not_refused() {
    let Some(folder) = case(&MASS, &SPRING, &[]) else { return };
    let path = |name: &str| folder.path().join(name);
    let as_it_is = last(folder.path(), POSITION);
    let same = |changes: &[(&str, &str)]| {
        write_case(folder.path(), changes);
        assert_eq!(last(folder.path(), POSITION), as_it_is, "{changes:?}");
    };
    // Aliases.
    let alias = [(
        "initial=\"calculated\" unit=\"m\"/>",
        "initial=\"calculated\" unit=\"m\"><Alias name=\"flange.s\"/></Float64>",
    )];
    Guest { changes: &alias, ..MASS }.packed(&path("mass.fmu")).unwrap();
    same(&[("position = \"x\"", "position = \"flange.s\"")]);
    same(&[("fmu = \"mass.fmu\"", "fmu = \"mass.fmu\"\nobserve = [\"flange.s\"]")]);
    // Arrays, enumerations and whole numbers of all widths.
    MASS.packed(&path("mass.fmu")).unwrap();
    let fixed = "causality=\"parameter\" variability=\"fixed\"";
    let more = format!(
        "<Float64 name=\"table\" valueReference=\"12\" {fixed} start=\"1 2 3\"><Dimension start=\"3\"/></Float64>\
         <Int64 name=\"many\" valueReference=\"7\" {fixed} start=\"0\"/><Enumeration name=\"kind\" valueReference=\"13\" \
         declaredType=\"Kind\" {fixed} start=\"1\"/></ModelVariables>"
    );
    let types = "<TypeDefinitions><EnumerationType name=\"Kind\"/></TypeDefinitions><ModelVariables>";
    let changes = [("</ModelVariables>", &*more), ("<ModelVariables>", types)];
    Guest { changes: &changes, faults: &["ARRAYS"], ..SPRING }.packed(&path("spring.fmu")).unwrap();
    let spring = |more: &str| [("fmu = \"spring.fmu\"".to_owned(), format!("fmu = \"spring.fmu\"\n{more}"))];
    for more in [
        "start = { table = [1.0, 2.0, 4.0], many = 3, kind = 2 }",
        "start = { \"table[2]\" = 5.0 }",
        "observe = [\"table[3]\", \"many\"]",
    ] {
        let [(from, to)] = &spring(more);
        same(&[(from, to)]);
    }
    let [(from, to)] = &spring("start = { table = [1.0] }");
    write_case(folder.path(), &[(from, to)]);
    assert_has(&refused(folder.path()), &["variable `table` has 3 values", "a list of 3"]);
    // A wish of FMI 3.0.
    let wish = [("<CoSimulation", "<CoSimulation fixedInternalStepSize=\"0.1\"")];
    Guest { changes: &wish, ..SPRING }.packed(&path("spring.fmu")).unwrap();
    same(&[]);
    assert_has(&run(folder.path(), "--scheme zero-order-hold").1, &["note: ", "fixedInternalStepSize"]);
    // A side that turns has a lever; without one it is said what to do.
    SPRING.packed(&path("spring.fmu")).unwrap();
    let turns = [
        (
            "</UnitDefinitions>",
            "<Unit name=\"rad\"><BaseUnit rad=\"1\"/></Unit><Unit name=\"rad/s\"><BaseUnit rad=\"1\" s=\"-1\"/></Unit></UnitDefinitions>",
        ),
        ("unit=\"m\"/>", "unit=\"rad\"/>"),
        ("unit=\"m/s\"/>", "unit=\"rad/s\"/>"),
    ];
    Guest { changes: &turns, ..MASS }.packed(&path("mass.fmu")).unwrap();
    write_case(folder.path(), &[]);
    assert_has(&refused(folder.path()), &["`x` is in `rad`", "the lever as a factor"]);
    same(&[(
        "position = \"x\", velocity = \"v\"",
        "position = { variable = \"x\", factor = 1.0 }, velocity = { variable = \"v\", factor = 1.0 }",
    )]);
}

#[test]
fn an_fmu_that_takes_no_step_for_good_while_one_may_go_back_moves() {
    for version in [2, 3] {
        let Some(folder) = case(&Guest { version, faults: &["REPEATS"], ..MASS }, &SPRING, &[]) else { return };
        assert!((last(folder.path(), POSITION) - 0.1 * f64::cos(2.0)).abs() < 5e-3);
        // Steps from which one does go back it does not take.
        let (said, _) = run(folder.path(), "--scheme iterated-aitken");
        assert_has(said["reason"].as_str().unwrap(), &["the state of the mechanics does not come back"]);
    }
}

#[test]
fn sides_couple_by_velocity_and_force_alone() {
    // A damper on a mass: x is the integral of the velocity on either side.
    let Some(folder) = case(&MASS, &SPRING, &[]) else { return };
    let damper = ("fmu = \"spring.fmu\"", "fmu = \"spring.fmu\"\nstart = { k = 0.0, d = 3.0 }");
    let moving = ("fmu = \"mass.fmu\"", "fmu = \"mass.fmu\"\nstart = { x0 = 0.1 }");
    let no_position = ("actuator = { position = \"x\", ", "actuator = { ");
    write_case(folder.path(), &[damper, moving, no_position]);
    assert_eq!(last(folder.path(), POSITION), 0.1);
    // The integral is the position, wherever it starts.
    write_case(folder.path(), &[("mechanics = { position = \"x\"", "mechanics = { position = { start = 0.1 }")]);
    let integral = last(folder.path(), POSITION);
    write_case(folder.path(), &[]);
    let own = last(folder.path(), POSITION);
    assert!((integral - own).abs() < 1e-3, "{integral} {own}");
    write_case(folder.path(), &[("mechanics = { position = \"x\", ", "mechanics = { ")]);
    assert_has(&refused(folder.path()), &["the mechanics has no position", "start = …"]);
    // Schemes with derivatives and a model as well.
    write_case(
        folder.path(),
        &[damper, ("mechanics = { position = \"x\"", "mechanics = { position = { start = 0.1 }"), no_position],
    );
    for scheme in ["rim-smooth", "interface-jacobian", "iterated-aitken"] {
        let (said, _) = run(folder.path(), &format!("--scheme {scheme}"));
        assert_eq!(said["outcome"], "completed", "{scheme}: {said:#}");
    }
}

#[test]
fn what_an_fmu_in_our_process_does_to_it_is_set_back() {
    let plain = case(&MASS, &SPRING, &[("[mechanics]", "process = \"same\"\n[mechanics]")]);
    let Some(plain) = plain else { return };
    let (known, _) = run(plain.path(), "--scheme zero-order-hold");
    for fault in ["CHDIR", "PRINT", "LOCALE", "FPE", "FTZ"] {
        Guest { faults: &[fault], ..SPRING }.packed(&plain.path().join("spring.fmu")).unwrap();
        // The trace is written to where it is asked for, and the standard output holds nothing but the answer.
        let (said, shown) = run(plain.path(), "--scheme zero-order-hold --trace here.csv");
        assert_eq!(said["force_error_rms_n"], known["force_error_rms_n"], "{fault}");
        assert!(fs::remove_file(plain.path().join("here.csv")).is_ok(), "{fault}");
        assert_eq!(shown.contains("step at"), fault == "PRINT", "{shown}");
    }
    // In the middle of a long run as well: the other side steps where it began. All threads share a folder, so that
    // there is one only.
    Guest { faults: &["WANDERS_AT=0.1"], ..SPRING }.packed(&plain.path().join("spring.fmu")).unwrap();
    Guest { faults: &["AT_HOME"], ..MASS }.packed(&plain.path().join("mass.fmu")).unwrap();
    let mut alone = inside(plain.path());
    alone.env("RAYON_NUM_THREADS", "1").args([
        "simulate",
        "--case",
        "case.toml",
        "--scheme",
        "zero-order-hold",
        "--format",
        "json",
    ]);
    let output = alone.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(said["force_error_rms_n"], known["force_error_rms_n"], "{said:#}");
    // Instances that share what they are made of.
    Guest { faults: &["SHARED"], ..MASS }.packed(&plain.path().join("mass.fmu")).unwrap();
    assert_has(&refused(plain.path()), &["mass.fmu", "instances share", "process = \"own\""]);
}

#[test]
fn what_a_case_file_says_that_cannot_be_is_refused_with_the_file() {
    let Some(folder) = case(&MASS, &SPRING, &[]) else { return };
    for (from, to, wanted) in [
        ("reference_step_s = 4e-4", "reference_step_s = 5.0", "reference_step_s = 5e0 is not valid"),
        ("reference_step_s = 4e-4", "reference_step_s = 1e-12", "reference_step_s = 1e-12 is not valid"),
        ("\nmicro_step_s = 1e-3", "\nmicro_step_s = 1e-12", "micro_step_s = 0.000000000001 is not valid"),
        ("duration_s = 0.2", "duration_s = 1e-4", "macro_step_s = 0.001 is not valid"),
        ("duration_s = 0.2", "duration_s = 1e300", "macro_step_s = 0.001 is not valid"),
        ("name = \"pair\"", "name = \"wedge-box\"", "name of the case = `wedge-box` is not valid"),
        ("\"v\"", "{ variable = \"v\", factor = nan }", "factor of `v` = NaN is not valid"),
        ("\"v\"", "{ variable = \"v\", factor = -0.0 }", "factor of `v` = -0 is not valid"),
        ("fmu = \"mass.fmu\"", "fmu = \"\"", "fmu of [mechanics] = \"\" is not valid"),
        ("fmu = \"mass.fmu\"", "fmu = \"mass.fmu\"\nneeds = [\"\"]", "needs of [mechanics] = \"\" is not valid"),
    ] {
        write_case(folder.path(), &[(from, to)]);
        assert_has(&refused(folder.path()), &["case.toml: ", wanted]);
    }
}

#[test]
fn what_a_side_costs_is_measured_and_advice_is_at_these_prices() {
    // What sleeps 300 µs in each step costs more than many micro steps, whatever else the machine does.
    let Some(folder) = case(&Guest { faults: &["SLOW_US=300"], ..MASS }, &SPRING, &[]) else { return };
    let advise = |options: &str| -> Value {
        let mut command = inside(folder.path());
        command.args([
            "advise",
            "--case",
            "case.toml",
            "--error",
            "20%",
            "--format",
            "json",
            "--scheme",
            "zero-order-hold",
        ]);
        command.args(["--from", "5e-3", "--to", "1e-2", "--per-decade", "2", "--phases", "1"]);
        let output = command.args(options.split_whitespace()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let said = advise("");
    assert!(said["costs"][1].as_f64().unwrap() > 100.0, "{said:#}");
    assert_eq!(said["advised"]["time_is_of"], "wall", "{said:#}");
    // Three solutions of the reference aside, each of its steps has waited.
    assert!(said["advised"]["time_per_macro_step_s"].as_f64().unwrap() > 3e-4, "{said:#}");
    assert_eq!(advise("--costs 1,2,3,4")["costs"], serde_json::json!([1.0, 2.0, 3.0, 4.0]));
}

#[test]
fn a_case_file_declares_the_scale_below_which_a_force_is_nothing() {
    let scale =
        |force: &str| format!("scale = {{ position_m = 0.1, velocity_m_s = 1.0, force_n = {force} }}\n[mechanics]");
    let Some(folder) = case(&MASS, &SPRING, &[("[mechanics]", &scale("10.0"))]) else { return };
    assert!(run(folder.path(), "--scheme zero-order-hold").0["force_error_rms_of_peak"].is_number());
    write_case(folder.path(), &[("[mechanics]", &scale("1e15"))]);
    let (said, _) = run(folder.path(), "--scheme zero-order-hold");
    assert_eq!(said["outcome"], "completed", "{said:#}");
    assert!(said["force_error_rms_of_peak"].is_null(), "{said:#}");
    for force in ["0.0", "-1.0", "nan"] {
        write_case(folder.path(), &[("[mechanics]", &scale(force))]);
        assert_has(&refused(folder.path()), &["case.toml", "force_n of scale", "above 0"]);
    }
}

/// Every fault on either side, in both versions of the standard and either process, with schemes that ask for ever
/// more.
#[test]
#[ignore = "a sweep of minutes: .ci/sweeps"]
fn a_fault_outside_ends_as_the_right_number_or_as_a_reason() {
    let faults = [
        "AT_HOME",
        "CHDIR",
        "ENDS_AT=0.1",
        "EXACT_TIME",
        "FAIL_AT=0.1",
        "FORGETS_V",
        "INF_AT=0.1",
        "LAGS",
        "LOCALE",
        "LONGEST=5e-4",
        "NAN_AT=0.1",
        "NAN_BELOW=3e-4",
        "NEEDS_STOP",
        "PRINT",
        "REPEATS",
        "SHALLOW",
        "SHARED",
        "START=0",
        "TRUNCATES",
        "WANDERS_AT=0.1",
    ];
    let schemes = ["zero-order-hold", "rim-smooth", "interface-jacobian", "true-acceleration", "iterated-aitken"];
    for version in [2, 3] {
        let (mass, spring) = (Guest { version, ..MASS }, Guest { version, ..SPRING });
        let Some(folder) = case(&mass, &spring, &[]) else { return };
        let error = |said: &Value| said["force_error_rms_n"].as_f64();
        let known = schemes.map(|scheme| error(&run(folder.path(), &format!("--scheme {scheme}")).0).unwrap());
        for process in ["own", "same"] {
            write_case(folder.path(), &[("[mechanics]", &format!("process = \"{process}\"\n[mechanics]"))]);
            for (fault, of_mass) in faults.iter().flat_map(|fault| [(fault, true), (fault, false)]) {
                // A spring that keeps its input where the mass keeps its state is another spring, and no faulty one.
                if (*fault, of_mass) == ("SHARED", false) {
                    continue;
                }
                let faulty = |guest: &Guest<'_>, here: bool| {
                    let faults: &[&str] = if here { &[fault] } else { &[] };
                    Guest { faults, ..*guest }.packed(&folder.path().join(format!("{}.fmu", guest.role))).unwrap();
                };
                faulty(&mass, of_mass);
                faulty(&spring, !of_mass);
                for (scheme, known) in schemes.iter().zip(known) {
                    let output = output(folder.path(), &format!("--scheme {scheme} --format json"));
                    let shown = String::from_utf8_lossy(&output.stderr).into_owned();
                    let what = format!("FMI {version}, {process}, {fault}, of the mass: {of_mass}, {scheme}: {shown}");
                    match output.status.code() {
                        Some(2) => assert!(shown.starts_with("error: "), "{what}"),
                        Some(0 | 1) => {
                            let said: Value = serde_json::from_slice(&output.stdout).expect(&what);
                            if said["outcome"] == "completed" {
                                // As far as the reference says that it is known.
                                let (error, own) = (error(&said).expect(&what), &said["reference_force_uncertainty_n"]);
                                let own = own.as_f64().expect(&what);
                                assert!(
                                    (error - known).abs() < 0.1 * known + 3.0 * own,
                                    "{what}: {error} ± {own}, {known}"
                                );
                            } else {
                                assert!(said["reason"] != "", "{what}: {said:#}");
                            }
                        }
                        code => panic!("{what}: {code:?}"),
                    }
                }
            }
        }
    }
}

/// Signs, units, sizes, times and counts of what a mass tells and takes, at each door of a case file.
#[test]
#[ignore = "a sweep of minutes: .ci/sweeps"]
fn a_fault_outside_of_sign_unit_size_time_or_count_is_named_at_every_door() {
    let schemes = ["zero-order-hold", "rim-smooth", "iterated-aitken"];
    let exact = 0.1 * f64::cos(2.0);
    let mut silent = Vec::new();
    let mut judge = |what: String, folder: &Path| {
        for scheme in schemes {
            let output = output(folder, &format!("--scheme {scheme} --format json"));
            let shown = String::from_utf8_lossy(&output.stderr).into_owned();
            let said: Option<Value> = serde_json::from_slice(&output.stdout).ok();
            let completed = said.as_ref().is_some_and(|said| said["outcome"] == "completed");
            let right = || (last(folder, POSITION) - exact).abs() < 5e-3;
            match output.status.code() {
                Some(2) if shown.starts_with("error: ") => {}
                Some(0 | 1) if !completed || right() => {}
                code => silent.push(format!("{what}, {scheme}: {code:?} {shown}")),
            }
        }
    };
    let sizes = ["-1", "1000", "0.001", "57.29578", "-1000", "5", "0.2", "0", "1e208", "1e-208"];
    for version in [2, 3] {
        for state in [true, false] {
            for fault in ["X_TIMES", "V_TIMES"] {
                for size in sizes {
                    let fault = format!("{fault}={size}");
                    let Some(folder) = case(&Guest { version, state, faults: &[&fault], ..MASS }, &SPRING, &[]) else {
                        return;
                    };
                    judge(format!("FMI {version}, {fault}, state {state}"), folder.path());
                }
            }
            // Of a force a size is that of another machine: only its sign can be told.
            for fault in ["F_TIMES=-1", "TIME_MS", "TRUNCATES", "LAGS", "HUGE_BELOW=5e-4"] {
                let Some(folder) = case(&Guest { version, state, faults: &[fault], ..MASS }, &SPRING, &[]) else {
                    return;
                };
                judge(format!("FMI {version}, {fault}, state {state}"), folder.path());
            }
        }
    }
    if python().is_some() {
        let Some(folder) = case(&MASS, &SPRING, &[]) else { return };
        let sized = |part: &str, size: &str| {
            format!(
                "{SIDES}\nclass Sized(Mass):\n    part, size = {part:?}, {size}\n    def outputs(self, u):\n        return (self.x * \
                 (self.size if self.part == 'x' else 1), self.v * (self.size if self.part == 'v' else 1))\n    def step(self, t, u, h):\n\
                 \x20       super().step(t, (u[0] * (self.size if self.part == 'f' else 1),), h * (self.size if self.part == 't' else 1))\n    \
                 def interface_model(self, h):\n        x, v = self.outputs(())\n        return {{'H': [[self.size if self.part == 'H' else \
                 1.0]], 'a': [self.size * 1e3 if self.part == 'a' else 0.0], 'w': [v], 'position': [x], 'gap': []}}\n"
            )
        };
        write_case(folder.path(), &[("fmu = \"mass.fmu\"", "python = \"sides.py\"\nclass = \"Sized\"")]);
        for part in ["x", "v", "f", "t", "H", "a"] {
            for size in sizes {
                // Beside a push of 1 m/s² and more a little acceleration is none, and what never answers may wait or be
                // held.
                let never = ["f", "t"].contains(&part) && size == "0";
                if never
                    || (part == "a" && ["0", "1e-208", "0.001", "0.2"].contains(&size))
                    || (part == "t" && size == "-1")
                {
                    continue;
                }
                fs::write(folder.path().join("sides.py"), sized(part, size)).unwrap();
                judge(format!("Python, {part} times {size}"), folder.path());
            }
        }
    }
    assert!(silent.is_empty(), "{} say nothing:\n{}", silent.len(), silent.join("\n"));
}

/// An interpreter with a physics engine takes a second to start.
#[test]
fn a_plan_starts_a_class_of_python_once_for_each_further_setting() {
    let Some(folder) = case(&MASS, &SPRING, &[]).filter(|_| python().is_some()) else { return };
    let counted = "class Counted(Mass):\n    def __init__(self, parameters):\n        super().__init__(parameters)\n        \
                   open(\"starts\", \"a\").write(\".\")\n";
    fs::write(folder.path().join("sides.py"), format!("{SIDES}\n\n{counted}")).unwrap();
    write_case(folder.path(), &[("fmu = \"mass.fmu\"", "python = \"sides.py\"\nclass = \"Counted\"")]);
    let text = fs::read_to_string(folder.path().join("case.toml")).unwrap() + "[parameters.k]\ndefault = 100.0\n";
    fs::write(folder.path().join("case.toml"), text).unwrap();
    let starts = |settings: &str| {
        let grid = format!(
            "question = \"?\"\nmacro_steps_s = [1e-3, 2e-3]\n[[cases]]\nfile = \"case.toml\"\nset = {{ k = [{settings}] }}\n\
             [[schemes]]\nscheme = \"rim-smooth\"\n[[schemes]]\nscheme = \"rim-nonsmooth\"\n"
        );
        fs::write(folder.path().join("grid.toml"), grid).unwrap();
        let _ = fs::remove_file(folder.path().join("starts"));
        let output = inside(folder.path()).args(["run", "grid.toml", "--dry-run"]).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        fs::read(folder.path().join("starts")).unwrap().len()
    };
    assert_eq!(starts("1.0, 2.0, 3.0, 4.0"), starts("1.0") + 3);
}

#[test]
fn a_class_of_python_is_a_side_beside_an_fmu_and_beside_another_class() {
    if python().is_none() {
        eprintln!("skipped: there is no Python `python3` on the path");
        return;
    }
    let Some(folder) = case(&MASS, &SPRING, &[]) else { return };
    let known = last(folder.path(), POSITION);
    fs::write(folder.path().join("sides.py"), SIDES).unwrap();
    let class = |name: &str| format!("python = \"sides.py\"\nclass = \"{name}\"");
    let [mass, spring, forgets] = ["Mass", "Spring", "Forgets"].map(class);
    let (of_mass, of_spring) = ("fmu = \"mass.fmu\"", "fmu = \"spring.fmu\"");
    for changes in [&[(of_mass, &*mass)][..], &[(of_spring, &*spring)], &[(of_mass, &*mass), (of_spring, &*spring)]] {
        write_case(folder.path(), changes);
        let found = last(folder.path(), POSITION);
        assert!((found - known).abs() < 1e-12, "{changes:?}: {found} {known}");
    }
    let [_, soft] = ["iterated-aitken", "rim-smooth"].map(|scheme| {
        let (said, _) = run(folder.path(), &format!("--scheme {scheme}"));
        assert_eq!(said["outcome"], "completed", "{scheme}: {said:#}");
        said["force_error_rms_n"].clone()
    });
    // Two classes have the doors that two FMUs have.
    let call = |arguments: &str| {
        let output = inside(folder.path()).args(arguments.split_whitespace()).output().unwrap();
        assert!(output.status.success(), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
    };
    let grid =
        "question = \"?\"\nmacro_steps_s = [1e-3]\n[[cases]]\nname = \"pair\"\n[[schemes]]\nscheme = \"rim-smooth\"\n";
    fs::write(folder.path().join("grid.toml"), grid).unwrap();
    call("--case-file case.toml run grid.toml --out out");
    assert!(fs::read_to_string(folder.path().join("out/runs.csv")).unwrap().contains(",completed,"));
    call("--case-file case.toml report out");
    // What it takes from a parameter of the case.
    let text = fs::read_to_string(folder.path().join("case.toml")).unwrap();
    fs::write(folder.path().join("case.toml"), text + "[parameters.k]\ndefault = 100.0\n").unwrap();
    assert_ne!(run(folder.path(), "--scheme rim-smooth --set k=200").0["force_error_rms_n"], soft);
    // One whose copies share what they are made of, one whose model is another's, one that raises.
    write_case(folder.path(), &[(of_mass, &*forgets)]);
    let (said, _) = run(folder.path(), "--scheme iterated-aitken");
    assert_has(said["reason"].as_str().unwrap(), &["the state of the mechanics does not come back", "zero-order-hold"]);
    // Said of what its motion is not, a text for a number, a factor for what knows its own units.
    for (name, words) in [
        ("Reversed", "the velocity is reversed"),
        ("Millimetres", "the position is wrong"),
        ("Heavy", "H of the model is 0.100 times"),
        ("Pushed", "a of the model"),
        ("Texts", "instead of a number"),
    ] {
        write_case(folder.path(), &[(of_mass, &*class(name))]);
        assert_has(&refused(folder.path()), &["sides.py", words]);
    }
    write_case(folder.path(), &[(of_mass, &*mass), ("\"v\"", "{ variable = \"v\", factor = -1.0 }")]);
    assert_has(&refused(folder.path()), &["sides.py", "factor = -1"]);
    // What turns false during a run is the fault of its side.
    write_case(folder.path(), &[(of_mass, &*class("Turns"))]);
    let (said, _) = run(folder.path(), "--scheme rim-smooth");
    assert_eq!(said["outcome"], "subsystem-failed", "{said:#}");
    assert_has(
        said["reason"].as_str().unwrap(),
        &["position, row 0, is 5", "a fault of this side, and not of the scheme"],
    );
    assert_eq!(run(folder.path(), "--scheme zero-order-hold").0["outcome"], "completed");
    for (name, words) in [
        ("Stale", "w of the interface, row 0, is"),
        ("Backwards", "the sign of the force is reversed: H[0, 0] = -1"),
        ("NotFinite", "H has NaN"),
    ] {
        write_case(folder.path(), &[(of_mass, &*class(name))]);
        let (said, _) = run(folder.path(), "--scheme rim-smooth");
        assert_eq!(said["outcome"], "skipped", "{name}: {said:#}");
        assert_has(said["reason"].as_str().unwrap(), &[words, "zero-order-hold"]);
    }
    assert_eq!(run(folder.path(), "--scheme zero-order-hold").0["outcome"], "completed");
    // Rows of an engine come and go, as many as there is room for, over steps that are no shorter than its own.
    let quick = class("Quick");
    let rows = |mass: &str, arguments: &str| {
        write_case(folder.path(), &[(of_mass, &*class(mass)), (of_spring, &*quick)]);
        let (said, _) = run(folder.path(), arguments);
        (said["outcome"].as_str().unwrap().to_owned(), said["reason"].as_str().unwrap().to_owned())
    };
    for arguments in ["--scheme rim-nonsmooth --contacts-act mechanics-step", "--scheme interface-mass"] {
        assert_eq!(rows("Stopped", arguments).0, "completed", "{arguments}");
    }
    let (outcome, reason) = rows("Crowded", "--scheme rim-nonsmooth");
    assert_has(&reason, &["the engine has 3 rows at once", "there is room for 2", "engine_rows=3"]);
    assert_eq!(outcome, "subsystem-failed");
    let (outcome, reason) = rows("Stopped", "--scheme rim-nonsmooth --macro-step 2e-4 --micro-step 1e-4");
    assert_has(&reason, &["its own step of 5e-4 s", "steps of 2e-4 s"]);
    assert_eq!(outcome, "skipped");
    assert_eq!(rows("Mass", "--scheme interface-jacobian").0, "completed");
    write_case(folder.path(), &[(of_mass, &*mass), (of_spring, &*spring)]);
    assert_eq!(run(folder.path(), "--scheme interface-jacobian").0["outcome"], "skipped");
    write_case(folder.path(), &[(of_mass, &*class("Raises"))]);
    assert_has(&refused(folder.path()), &["ValueError: no solution", "sides.py, line "]);
    write_case(folder.path(), &[(of_mass, "python = \"case.toml\"\nclass = \"Mass\"")]);
    assert_has(&refused(folder.path()), &["is no file of Python: its name does not end in .py"]);
    write_case(folder.path(), &[(of_mass, &*class("Nobody"))]);
    assert_has(&refused(folder.path()), &["sides.py", "Nobody"]);
}
