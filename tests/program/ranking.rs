//! The ranking: that the committed tables follow from the committed summaries, and the page from the tables.

use crate::program::{read, root, rows_of};
use rimbench::catalogue::Catalogue;
use rimbench::harness::Ranking;
use std::collections::BTreeMap;

#[test]
fn the_committed_ranking_follows_from_the_committed_summaries() {
    let folder = tempfile::tempdir().unwrap();
    let ranking = Ranking::read(&root().join("experiments/ranking.toml")).unwrap();
    let (catalogue, results) = (Catalogue::standard(), root().join("results"));
    let found = ranking.write(&catalogue, &results, folder.path()).unwrap();
    assert_eq!((found.differing, found.notes), (Vec::new(), Vec::new()));
    for file in ["ranking.csv", "claims.csv", "SHA256SUMS"] {
        assert_eq!(read(folder.path().join(file)), read(results.join("ranking").join(file)), "{file}");
    }
}

/// What `docs/results/ranking.md` says in words; its numbers are between markers.
#[test]
fn the_findings_of_the_ranking_follow_from_its_rows_and_claims() {
    let rows = |name: &str| rows_of(root().join("results/ranking").join(name));
    let scores = |class: &str| -> BTreeMap<String, f64> {
        let own = rows("ranking.csv").into_iter().filter(|row| row["class"] == class && row["by"] == "authors");
        own.map(|row| (row["label"].clone(), row["score"].parse().unwrap())).collect()
    };
    let (samples, models) = (scores("samples"), scores("model"));
    let best = samples.values().copied().fold(f64::INFINITY, f64::min);
    assert_eq!(best, samples["zero-order-hold/mechanics-first"]);
    assert!(2 * models.values().filter(|own| **own < best).count() < models.len(), "a model is a guarantee");
    assert!(models["rim-nonsmooth"] < best);
    assert_eq!(models.values().copied().fold(0.0, f64::max), models["rim-smooth"]);
    for one_first in ["zero-order-hold/mechanics-first", "zero-order-hold/end", "zero-order-hold/gauss-seidel"] {
        assert!(samples["first-order-hold"] > samples[one_first], "{one_first}");
    }
    let claims = rows("claims.csv");
    let open: Vec<_> = claims.iter().filter(|claim| claim["verdict"] != "reproduced").map(|own| &own["id"]).collect();
    assert!(claims.len() >= 6 && open == ["linear-ahead-of-the-hold", "papers-model-ahead-of-own-step"], "{claims:?}");
}
