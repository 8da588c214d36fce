//! Every output goes through one function, which replaces regular files only.

use crate::program::{call, printed, rimbench, root, said};
use crate::support::sources;

/// What makes, replaces or removes a file, with the files of the program that may: outputs are written in one place;
/// the store appends to logs of its own names.
const MAKERS: [(&str, &[&str]); 7] = [
    ("fs::write(", &[]),
    // What a process that is started says, in a file of its own.
    ("File::create", &["src/cli/submit.rs"]),
    ("fs::rename(", &[]),
    (".persist(", &["rimbench-results/src/atomic_file.rs", "rimbench-harness/src/cache.rs"]),
    ("OpenOptions::new(", &["rimbench-results/src/atomic_file.rs", "rimbench-harness/src/store.rs"]),
    ("fs::copy(", &[]),
    ("csv::Writer::from_path", &[]),
];

#[test]
fn no_file_is_written_but_by_the_function_that_spares_devices_pipes_and_links() {
    let root = root();
    let mut seen = 0;
    let mut faults = Vec::new();
    for (path, text) in sources(&root.join("src")).into_iter().chain(sources(&root.join("crates"))) {
        let path = path.to_string_lossy().replace('\\', "/");
        if !path.contains("/src/") {
            continue;
        }
        for (number, line) in text.lines().enumerate() {
            let code = line.split("//").next().unwrap_or_default();
            for (maker, allowed) in MAKERS.iter().filter(|(maker, _)| code.contains(maker)) {
                seen += 1;
                if !allowed.iter().any(|file| path.ends_with(file)) {
                    faults.push(format!("{path}:{}: `{maker}`: write through atomic_file", number + 1));
                }
            }
        }
    }
    assert!(seen >= 3, "only {seen} found: the check reads nothing");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The path of the folder that the program was built in is no part of what it does; a bench is run where it was built.
#[test]
fn no_file_of_the_program_looks_for_the_folder_it_was_built_in() {
    let root = root();
    let all = sources(&root.join("src")).into_iter().chain(sources(&root.join("crates")));
    let faults: Vec<_> = all
        .filter(|(path, _)| {
            let elsewhere =
                |part: std::path::Component| ["benches", "tests"].iter().any(|name| part.as_os_str() == *name);
            !path.ends_with("build.rs") && !path.components().any(elsewhere)
        })
        .filter(|(_, text)| text.contains("CARGO_MANIFEST_DIR"))
        .map(|(path, _)| path)
        .collect();
    assert!(faults.is_empty(), "{faults:?}");
}

/// The standard output by its name: first the trace, then what is printed. (Pipes and links are followed in
/// `atomic_file`.)
#[cfg(unix)]
#[test]
fn a_trace_goes_to_the_standard_output_where_that_is_named() {
    for name in ["/dev/stdout", "/dev/fd/1"] {
        let line = "simulate --case linear-oscillator --scheme zero-order-hold --duration 0.1 --trace";
        let text = printed(&mut call(&format!("{line} {name}")));
        assert!(text.starts_with("time_s,") && text.contains("metric"), "{name}: {text}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_standard_output_that_is_full_is_named() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = crate::program::process().args(["list", "cases"]).stdout(full).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && said.contains("standard output: cannot be written: "), "{said}");
}

/// Every option that names an output, given something of the wrong kind: a folder for a file, a file for a folder.
#[test]
fn an_output_of_the_wrong_kind_is_refused_at_once_and_left_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let (file, inner) = (folder.path().join("file"), folder.path().join("folder"));
    std::fs::write(&file, "precious").unwrap();
    std::fs::create_dir(&inner).unwrap();
    std::fs::write(inner.join("kept"), "precious").unwrap();
    let experiment = folder.path().join("one.toml");
    let text = "question = \"?\"\nmacro_steps_s = [5e-3]\n[[cases]]\nname = \"linear-oscillator\"\n[[schemes]]\n\
                scheme = \"zero-order-hold\"\n";
    std::fs::write(&experiment, text).unwrap();
    let [file_name, folder_name, experiment] = [&file, &inner, &experiment].map(|path| path.to_str().unwrap());
    for arguments in [
        &["simulate", "--case", "wedge-box", "--scheme", "rim-smooth", "--trace", folder_name] as &[&str],
        &["perf", "record", "--history", folder_name],
        &["perf", "record", "--history", file_name],
        &["run", experiment, "--out", file_name],
        &["reproduce", "--quick", "--out", file_name],
    ] {
        let message = said(rimbench().current_dir(folder.path()).args(arguments), 2);
        assert!(message.contains("error: ") && message.lines().count() <= 2, "{arguments:?}: {message}");
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "precious", "{arguments:?}");
        let left: Vec<_> = std::fs::read_dir(&inner).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left, ["kept"], "{arguments:?}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3, "{arguments:?}");
    }
}
