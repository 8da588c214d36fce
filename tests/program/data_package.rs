//! Results as others can cite, read and check them: what is in a package, that it gives back what it was made from, that a run comes out
//! again, and that whatever is wrong with one is said.

use crate::program::{rimbench, two_sets_with};
use jsonschema::Validator;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

const EXPERIMENT: &str = concat!(
    r#"
question = "What \"is\" in a package, and how does it come out?"
macro_steps_s = [5e-3, 2e-2]
phases = 2
duration_s = 2.0
trace_every_s = 1e-2
traces = ["rim-nonsmooth"]
"#,
    two_sets_with!("rim-nonsmooth"),
    r#"
# While its wedge sticks, its effective mass is infinite.
[[cases]]
name = "wedge-box-friction"

[[claims]]
id = "small"
by = "ours"
text = "The error is finite"
case = "wedge-box"
set = "box_mass_kg=210.0"
scheme = "rim-nonsmooth"
metric = "force_error_rms_n"
expect = ">= 0"
finding = "reproduced"
"#
);

/// Runs: 2 sets and a case, 2 schemes, 2 macro steps, 2 phases.
const RUNS: usize = 24;

/// Results and a package of them, made once.
static MADE: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("packed.toml");
    std::fs::write(&file, EXPERIMENT).unwrap();
    rimbench().arg("run").arg(&file).arg("--out").arg(results(&folder)).assert().success();
    pack(&results(&folder), &folder.path().join("package"), &["--author", "Doe, Jane", "--author", "A group"])
        .success();
    folder
});

fn results(folder: &tempfile::TempDir) -> PathBuf {
    folder.path().join("packed")
}

fn package() -> PathBuf {
    MADE.path().join("package")
}

fn pack(results: &Path, out: &Path, options: &[&str]) -> assert_cmd::assert::Assert {
    rimbench().arg("export").arg(results).arg("--out").arg(out).args(options).assert()
}

fn read(path: impl AsRef<Path>) -> String {
    std::fs::read_to_string(path).unwrap()
}

fn copied(from: &Path) -> tempfile::TempDir {
    let to = tempfile::tempdir().unwrap();
    for name in files_of(from) {
        let target = to.path().join(&name);
        std::fs::create_dir_all(target.parent().unwrap()).unwrap();
        std::fs::copy(from.join(&name), target).unwrap();
    }
    to
}

/// Files below a folder, without the store.
fn files_of(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = [folder.to_owned(), folder.join("traces")]
        .iter()
        .flat_map(|folder| std::fs::read_dir(folder).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.is_file())
        .map(|path| path.strip_prefix(folder).unwrap().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// Replaces text in a file of a package, and its checksum with it unless `seal` is false.
fn edit(package: &Path, name: &str, from: &str, to: &str, seal: bool) {
    let before = read(package.join(name));
    assert!(before.contains(from), "{name} has no {from}");
    std::fs::write(package.join(name), before.replace(from, to)).unwrap();
    if seal {
        let sums: Vec<String> = read(package.join("SHA256SUMS"))
            .lines()
            .map(|line| {
                let name = line.split("  ").nth(1).unwrap();
                format!("{}  {name}\n", rimbench::checksums::sha256_of_file(&package.join(name)).unwrap())
            })
            .collect();
        std::fs::write(package.join("SHA256SUMS"), sums.concat()).unwrap();
    }
}

fn imported(package: &Path, options: &[&str]) -> (Option<i32>, String) {
    let output = rimbench().arg("import").arg(package).args(options).assert().get_output().clone();
    let said = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).concat();
    (output.status.code(), said)
}

#[test]
fn a_package_gives_back_the_results_to_the_byte_and_its_runs_come_out_again() {
    let out = tempfile::tempdir().unwrap();
    let out = out.path().join("packed");
    let (code, said) = imported(&package(), &["--sample", "4", "--out", out.to_str().unwrap()]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains(&format!("packed: {RUNS} runs")) && said.contains("4 equal to the digit, 0 not"), "{said}");
    let names = files_of(&out);
    assert!(names.len() > 6 + RUNS / 2, "{names:?}");
    for name in &names {
        assert_eq!(read(out.join(name)), read(results(&MADE).join(name)), "{name}");
    }
    // And they are results like others: nothing is left to compute.
    let file = out.parent().unwrap().join("packed.toml");
    std::fs::write(&file, EXPERIMENT).unwrap();
    let output = rimbench().arg("run").arg(&file).arg("--out").arg(&out).assert().success().get_output().clone();
    assert!(String::from_utf8_lossy(&output.stdout).contains(": 0 computed now"), "{output:?}");
}

#[test]
fn a_description_explains_every_file_and_every_column() {
    let description: Value = serde_json::from_str(&read(package().join("datapackage.json"))).unwrap();
    let resources = description["resources"].as_array().unwrap();
    let name_of = |resource: &Value| resource["path"].as_str().unwrap().to_owned();
    for table in ["runs.csv", "cost.csv", "provenance.csv", "parameters.csv", "reference.csv", "claims.csv"] {
        let resource = resources.iter().find(|resource| name_of(resource) == table).unwrap();
        let fields = resource["schema"]["fields"].as_array().unwrap();
        let names: Vec<&str> = fields.iter().map(|field| field["name"].as_str().unwrap()).collect();
        assert_eq!(read(package().join(table)).lines().next().unwrap(), names.join(","), "{table}");
        assert!(fields.iter().all(|field| !field["description"].as_str().unwrap().is_empty()), "{table}");
    }
    for resource in resources {
        let path = package().join(name_of(resource));
        assert_eq!(resource["bytes"].as_u64().unwrap(), path.metadata().unwrap().len(), "{path:?}");
        let sum = rimbench::checksums::sha256_of_file(&path).unwrap();
        assert_eq!(resource["hash"], format!("sha256:{sum}"), "{path:?}");
    }
    let mut names: Vec<&str> = resources.iter().map(|resource| resource["name"].as_str().unwrap()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), resources.len(), "two resources of one name");
    assert!(description["title"].as_str().unwrap().contains("\"is\""));
}

/// What a Table Schema calls each cell: read as any reader would that knows nothing of us.
#[test]
fn every_cell_is_of_the_type_that_its_column_claims() {
    let description: Value = serde_json::from_str(&read(package().join("datapackage.json"))).unwrap();
    let (mut cells, mut infinite) = (0, 0);
    for resource in description["resources"].as_array().unwrap() {
        let Some(fields) = resource["schema"]["fields"].as_array() else { continue };
        let mut table = csv::Reader::from_path(package().join(resource["path"].as_str().unwrap())).unwrap();
        for row in table.records() {
            let row = row.unwrap();
            for (cell, field) in row.iter().zip(fields).filter(|(cell, _)| !cell.is_empty()) {
                let special = ["INF", "-INF", "NaN"].contains(&cell);
                let plain =
                    cell.chars().all(|c| c.is_ascii_digit() || "+-.eE".contains(c)) && cell.parse::<f64>().is_ok();
                let good = match field["type"].as_str().unwrap() {
                    "number" => special || plain,
                    "integer" => cell.parse::<i64>().is_ok(),
                    "boolean" => ["true", "false"].contains(&cell),
                    "string" => true,
                    other => panic!("unknown type {other}"),
                };
                assert!(good, "{}: {} = {cell}", resource["path"], field["name"]);
                cells += 1;
                infinite += usize::from(cell.ends_with("INF"));
            }
        }
    }
    assert!(cells > 1000 && infinite > 0, "{cells} cells, {infinite} infinite");
}

#[test]
fn a_citation_can_be_read() {
    let text = read(package().join("CITATION.cff"));
    assert!(
        text.contains("family-names: \"Doe\"\n    given-names: \"Jane\"") && text.contains("name: \"A group\""),
        "{text}"
    );
    assert!(text.contains("license: CC-BY-4.0") && text.contains(r#"title: "What \"is\""#), "{text}");
    let readme = read(package().join("README.md"));
    assert!(readme.contains("pd.read_csv") && readme.contains("time series"), "{readme}");
}

#[test]
fn what_is_wrong_with_a_package_is_said() {
    let check = |edited: &dyn Fn(&Path), wanted: &str| {
        let copy = copied(&package());
        edited(copy.path());
        let (code, said) = imported(copy.path(), &["--sample", "1"]);
        assert_eq!(code, Some(2), "{wanted}: {said}");
        assert!(said.contains(wanted), "{wanted}: {said}");
    };
    let remove = |package: &Path, name: &str| std::fs::remove_file(package.join(name)).unwrap();
    check(&|package| remove(package, "datapackage.json"), "datapackage.json: cannot be read");
    check(&|package| remove(package, "SHA256SUMS"), "SHA256SUMS: is missing");
    check(&|package| remove(package, "cost.csv"), "cost.csv is missing");
    check(&|package| edit(package, "runs.csv", "completed", "compleated", false), "runs.csv has been changed");
    check(
        &|package| edit(package, "datapackage.json", "\"quick\"", "\"kwick\"", true),
        "is no data package of rimbench",
    );
    check(&|package| edit(package, "datapackage.json", "{", "", true), "is no data package");
    check(
        &|package| edit(package, "datapackage.json", "\"numerics_version\": ", "\"numerics_version\": 9", true),
        "rimbench.numerics_version = 9",
    );
    // Sealed again, so that only what it was made from tells.
    check(&|package| edit(package, "runs.csv", "completed", "compleated", true), "runs.csv has been changed");
    check(&|package| std::fs::write(package.join("extra.py"), "").unwrap(), "extra.py: is no part of the package");
    check(&|package| std::fs::write(package.join("traces/extra.csv"), "").unwrap(), "is no part of the package");
    check(&|package| edit(package, "results.sha256", "runs.csv", "../runs.csv", true), "is no list of checksums");
    // A refusal leaves nothing behind.
    let (copy, out) = (copied(&package()), tempfile::tempdir().unwrap());
    edit(copy.path(), "results.sha256", "runs.csv", "../runs.csv", true);
    assert_eq!(imported(copy.path(), &["--out", out.path().join("x").to_str().unwrap()]).0, Some(2));
    assert!(!out.path().join("x").exists());
    let (code, said) = imported(&package().join("missing"), &[]);
    assert!(code == Some(2) && said.contains("datapackage.json: cannot be read"), "{said}");
}

/// A result that was made up, sealed on every level, is found by computing it.
#[test]
fn a_number_that_was_made_up_does_not_come_out_again() {
    let forged = tempfile::tempdir().unwrap();
    let (results, out) = (forged.path().join("packed"), forged.path().join("package"));
    std::fs::create_dir(&results).unwrap();
    let copy = copied(&self::results(&MADE));
    for name in files_of(copy.path()) {
        let target = results.join(&name);
        std::fs::create_dir_all(target.parent().unwrap()).unwrap();
        std::fs::copy(copy.path().join(&name), target).unwrap();
    }
    let text = read(results.join("runs.csv"));
    let column = text.lines().next().unwrap().split(',').position(|name| name == "force_error_rms_n").unwrap();
    let forge = |line: &str| {
        let mut cells: Vec<&str> = line.split(',').collect();
        if line.contains(",completed,") {
            cells[column] = "1.5";
        }
        cells.join(",")
    };
    let lines: Vec<String> = text.lines().map(|line| forge(line) + "\n").collect();
    std::fs::write(results.join("runs.csv"), lines.concat()).unwrap();
    edit(&results, "experiment.toml", "question", "question", true);
    pack(&results, &out, &["--author", "Mallory"]).success();
    let (code, said) = imported(&out, &["--sample", "24"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("force_error_rms_n is ") && said.contains("1.5 in the package"), "{said}");
}

/// What is made of the results must be what they make: verdicts, texts, loaders.
#[test]
fn what_does_not_follow_from_the_results_is_named() {
    for (name, from, to) in [
        ("claims.csv", "reproduced", "not-reproduced"),
        ("load.py", "median", "mean"),
        ("datapackage.json", "\"unit\": \"N\"", "\"unit\": \"kN\""),
        ("README.md", "Results of", "Result of"),
    ] {
        let copy = copied(&package());
        edit(copy.path(), name, from, to, true);
        let (code, said) = imported(copy.path(), &["--sample", "1"]);
        assert_eq!(code, Some(1), "{name}: {said}");
        assert!(
            said.contains(&format!("not as this program writes them from these results: {name}")),
            "{name}: {said}"
        );
    }
}

/// Tables beside the runs, forged and sealed on every level.
#[test]
fn references_parameters_and_outcomes_that_were_made_up_do_not_come_out_again() {
    let forge = |name: &str, forged: &dyn Fn(&str) -> String| {
        let place = tempfile::tempdir().unwrap();
        let (copy, results) = (copied(&self::results(&MADE)), place.path().join("packed"));
        std::fs::rename(copy.keep(), &results).unwrap();
        let text = read(results.join(name));
        let (header, rows) = text.split_once('\n').unwrap();
        std::fs::write(results.join(name), format!("{header}\n{}", forged(rows))).unwrap();
        edit(&results, "experiment.toml", "question", "question", true);
        pack(&results, &place.path().join("package"), &["--author", "Mallory"]).success();
        imported(&place.path().join("package"), &["--sample", "2"])
    };
    let in_cell = |rows: &str, cell: usize, to: &str| -> String {
        rows.lines()
            .map(|line| {
                let mut cells: Vec<&str> = line.split(',').collect();
                cells[cell] = to;
                cells.join(",") + "\n"
            })
            .collect()
    };
    let outcome = read(results(&MADE).join("runs.csv")).lines().next().unwrap().split(',').position(|c| c == "outcome");
    for (name, forged) in [
        ("reference.csv", &(|rows: &str| in_cell(rows, 3, "1e-99")) as &dyn Fn(&str) -> String),
        ("parameters.csv", &|rows: &str| in_cell(rows, 3, "1")),
        ("runs.csv", &|rows: &str| in_cell(rows, outcome.unwrap(), "timeout")),
    ] {
        let (code, said) = forge(name, forged);
        assert_eq!(code, Some(1), "{name}: {said}");
        assert!(said.contains(if name == "runs.csv" { "outcome is" } else { name }), "{name}: {said}");
    }
}

#[test]
fn what_cannot_be_exported_is_one_error() {
    let folder = tempfile::tempdir().unwrap();
    let fresh = folder.path().join("package");
    let author: &[&str] = &["--author", "Doe, Jane"];
    let refused = |results: &Path, out: &Path, options: &[&str], wanted: &str| {
        let output = pack(results, out, options).code(2).get_output().clone();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains(wanted), "{wanted}: {said}");
        assert!(!fresh.exists(), "{wanted}: something was written");
    };
    let whole = results(&MADE);
    refused(&whole, &fresh, &[], "author = ");
    refused(&whole, &fresh, &["--author", "Doe", "--license", "do what you like"], "license = do what you like");
    refused(&whole, &fresh, &["--author", "Doe", "--released", "2023-02-29"], "released = 2023-02-29");
    refused(&whole, &whole, author, "is not empty");
    refused(&whole, &whole.join("package"), author, "lies in the results folder itself");
    refused(&whole, &whole.join("runs.csv"), author, "is no folder");
    refused(&folder.path().join("nothing"), &fresh, author, "nothing");
    // A run that is missing.
    let copy = copied(&whole);
    let text = read(copy.path().join("runs.csv"));
    let without_last: Vec<&str> = text.lines().take(RUNS).collect();
    std::fs::write(copy.path().join("runs.csv"), without_last.join("\n")).unwrap();
    refused(copy.path(), &fresh, author, "1 missing");
}

/// The published profile of descriptions, as far as it goes: names and shapes.
#[test]
fn a_description_keeps_to_the_profile() {
    let schema = serde_json::json!({
        "type": "object",
        "required": ["name", "resources", "licenses"],
        "properties": {
            "name": { "type": "string", "pattern": "^[-a-z0-9._/]+$" },
            "licenses": { "type": "array", "minItems": 1, "items": { "required": ["name"] } },
            "resources": { "type": "array", "minItems": 1, "items": {
                "required": ["name", "path"],
                "properties": {
                    "name": { "pattern": "^[-a-z0-9._/]+$" },
                    "path": { "pattern": "^(?![./~])(?!.*\\.\\.)[^\\\\]+$" },
                    "bytes": { "type": "integer" },
                    "schema": { "required": ["fields"], "properties": { "fields": { "type": "array", "items": {
                        "required": ["name", "type"],
                        "properties": { "type": { "enum": ["string", "number", "integer", "boolean"] } },
                    } } } },
                },
            } },
        },
    });
    let validator: Validator = jsonschema::draft202012::new(&schema).unwrap();
    let description: Value = serde_json::from_str(&read(package().join("datapackage.json"))).unwrap();
    let faults: Vec<String> = validator.iter_errors(&description).map(|error| error.to_string()).collect();
    assert!(faults.is_empty(), "{faults:?}");
}
