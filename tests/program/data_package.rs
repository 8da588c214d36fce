//! Results as others can cite and load them: what is in a package, and that what cannot be exported is said.

use crate::program::{assert_has, copy, executable, files, read, rimbench, said, two_sets_with};
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
    let authors = ["--author", "Doe, Jane", "--author", "A group"];
    pack(&results(&folder), &folder.path().join("package"), &authors, 0);
    folder
});

fn results(folder: &tempfile::TempDir) -> PathBuf {
    folder.path().join("packed")
}

fn package() -> PathBuf {
    MADE.path().join("package")
}

fn pack(results: &Path, out: &Path, options: &[&str], code: i32) -> String {
    said(rimbench().arg("export").arg(results).arg("--out").arg(out).args(options), code)
}

#[test]
fn a_description_explains_every_file_and_every_column() {
    let description: Value = serde_json::from_str(&read(package().join("datapackage.json"))).unwrap();
    let resources = description["resources"].as_array().unwrap();
    let name_of = |resource: &Value| resource["path"].as_str().unwrap().to_owned();
    for table in
        ["runs.csv", "cost.csv", "provenance.csv", "parameters.csv", "settings.csv", "reference.csv", "claims.csv"]
    {
        let resource = resources.iter().find(|resource| name_of(resource) == table).unwrap();
        let fields = resource["schema"]["fields"].as_array().unwrap();
        let names: Vec<&str> = fields.iter().map(|field| field["name"].as_str().unwrap()).collect();
        assert_eq!(read(package().join(table)).lines().next().unwrap(), names.join(","), "{table}");
        assert!(fields.iter().all(|field| !field["description"].as_str().unwrap().is_empty()), "{table}");
        if table != "claims.csv" {
            let stored = read(results(&MADE).join(table));
            assert_eq!(read(package().join(table)).replace("INF", "inf"), stored, "{table}");
        }
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
    let author = "family-names: \"Doe\"\n    given-names: \"Jane\"";
    assert_has(&text, &[author, "name: \"A group\"", "license: CC-BY-4.0", r#"title: "What \"is\""#]);
    let readme = read(package().join("README.md"));
    assert_has(&readme, &["pd.read_csv", "time series"]);
}

/// A limit on the size of files stands in for a full disk.
#[cfg(unix)]
#[test]
fn an_export_onto_a_full_disk_leaves_nothing_that_looks_like_a_package() {
    let folder = tempfile::tempdir().unwrap();
    let [new, empty] = ["new", "empty"].map(|name| folder.path().join(name));
    std::fs::create_dir(&empty).unwrap();
    for out in [&new, &empty] {
        let [program, from, to] = [&executable(), &results(&MADE), out].map(|path| path.display().to_string());
        let script = format!("trap '' XFSZ; ulimit -f 8; exec {program} export {from} --out {to} --author Doe");
        let output = std::process::Command::new("bash").args(["-c", &script]).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        assert_has(&String::from_utf8_lossy(&output.stderr), &["cannot be written"]);
        assert_eq!(out.exists(), out == &empty);
        assert_eq!(files(out), [""; 0].map(PathBuf::from));
    }
}

#[test]
fn what_cannot_be_exported_is_one_error() {
    let folder = tempfile::tempdir().unwrap();
    let fresh = folder.path().join("package");
    let author: &[&str] = &["--author", "Doe, Jane"];
    let refused = |results: &Path, out: &Path, options: &[&str], wanted: &str| {
        assert_has(&pack(results, out, options, 2), &[wanted]);
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
    let copied = folder.path().join("copied");
    copy(&whole, &copied);
    let text = read(copied.join("runs.csv"));
    let without_last: Vec<&str> = text.lines().take(RUNS).collect();
    std::fs::write(copied.join("runs.csv"), without_last.join("\n")).unwrap();
    refused(&copied, &fresh, author, "1 missing");
}
