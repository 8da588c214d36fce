//! The ranking: that the page says what the committed tables say.

use std::collections::BTreeMap;
use std::path::Path;

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
    assert!(claims.len() >= 6 && claims.iter().all(|claim| claim["verdict"] == claim["finding"]), "{claims:?}");
    let open: Vec<&str> =
        claims.iter().filter(|claim| claim["verdict"] != "reproduced").map(|own| &*own["id"]).collect();
    assert_eq!(open, ["linear-ahead-of-the-hold"]);
}
