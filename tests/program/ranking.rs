//! The ranking: what the command writes of an experiment, and that the page says what the committed tables say.

use crate::program::rimbench;
use std::collections::BTreeMap;
use std::path::Path;

fn read(path: impl AsRef<Path>) -> String {
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn rows_are_ranked_by_what_they_need_to_know_and_a_chosen_gain_counts_as_tuned() {
    let folder = tempfile::tempdir().unwrap();
    let text = "question = \"?\"\nmacro_steps_s = [1e-3, 2e-3]\nphases = 2\nduration_s = 0.5\n[[cases]]\nname = \"bouncing-ball\"\n\
                [[schemes]]\nscheme = \"zero-order-hold\"\n[[schemes]]\nscheme = \"rim-nonsmooth-gap\"\n\
                [[schemes]]\nscheme = \"nepce\"\ngain = 0.25\n";
    std::fs::create_dir(folder.path().join("own")).unwrap();
    std::fs::write(folder.path().join("own/sweep.toml"), text).unwrap();
    std::fs::write(folder.path().join("mine.toml"), "question = \"?\"\nexperiments = [\"own/sweep.toml\"]\n").unwrap();
    let called = |words: &[&str]| rimbench().current_dir(folder.path()).args(words).assert().success();
    called(&["run", "own/sweep.toml"]);
    let output = called(&["report", "--ranking=mine.toml"]).get_output().clone();
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("samples, tuned:") && said.contains("3 rows over 4 problems of 1 cases"), "{said}");
    let table = read(folder.path().join("results/ranking/ranking.csv"));
    let classes: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let classes: Vec<[&str; 3]> = classes.iter().map(|row| [row[0], row[1], row[4]]).collect();
    let expected =
        [["samples", "", "zero-order-hold"], ["samples", "bouncing-ball", "nepce"], ["model", "", "rim-nonsmooth-gap"]];
    assert_eq!(classes, expected, "{table}");
}

fn rows_of(name: &str) -> Vec<BTreeMap<String, String>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("results/ranking").join(name);
    csv::Reader::from_path(path).unwrap().deserialize().map(Result::unwrap).collect()
}

/// What `docs/results/ranking.md` says in words; its numbers are between markers.
#[test]
fn the_findings_of_the_ranking_follow_from_its_rows_and_claims() {
    let rows = rows_of("ranking.csv");
    let score = |class: &str, label: &str| -> f64 {
        let own = rows.iter().find(|row| row["class"] == class && row["label"] == label);
        own.unwrap_or_else(|| panic!("no {label} in {class}"))["score"].parse().unwrap()
    };
    let scores = |class: &str| -> Vec<f64> {
        rows.iter().filter(|row| row["class"] == class).map(|row| row["score"].parse().unwrap()).collect()
    };
    let (samples, models) = (scores("samples"), scores("model"));
    let best = samples.iter().copied().fold(f64::INFINITY, f64::min);
    assert_eq!(best, score("samples", "zero-order-hold/mechanics-first"));
    assert!(2 * models.iter().filter(|own| **own < best).count() < models.len(), "a model is a guarantee");
    assert!(score("model", "rim-nonsmooth") < best);
    assert_eq!(models.iter().copied().fold(0.0, f64::max), score("model", "rim-smooth"));
    for one_first in ["zero-order-hold/mechanics-first", "zero-order-hold/end", "zero-order-hold/gauss-seidel"] {
        assert!(score("samples", "first-order-hold") > score("samples", one_first), "{one_first}");
    }
    let claims = rows_of("claims.csv");
    assert!(claims.len() >= 7 && claims.iter().all(|claim| claim["verdict"] == claim["finding"]), "{claims:?}");
    let open: Vec<&str> =
        claims.iter().filter(|claim| claim["verdict"] != "reproduced").map(|own| &*own["id"]).collect();
    assert_eq!(open, ["linear-ahead-of-the-hold"]);
}
