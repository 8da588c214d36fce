//! What the program carries with it, so that it works from any folder: the experiments, the list of figures, and the
//! source of the report, as they were when it was built.

/// Experiment files, each as its path in the source (`experiments/<group>/<name>.toml`) and its text, by path.
pub const EXPERIMENTS: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/experiments.rs"));

/// The ranking of schemes: path and text.
pub const RANKING: (&str, &str) = ("experiments/ranking.toml", include_str!("../experiments/ranking.toml"));

/// The list of figures: path and text.
pub const FIGURES: (&str, &str) = ("paper/figures.toml", include_str!("../paper/figures.toml"));

/// The keys of a list of figures: the page of the book.
pub const FIGURE_KEYS: &str = include_str!("../docs/guide/figure-keys.md");

/// The source of the report: path and text.
pub const REPORT: (&str, &str) = ("paper/report.md", include_str!("../paper/report.md"));

/// The experiments of one group, each with its path and text.
pub fn experiments_of(group: &str) -> impl Iterator<Item = (&'static str, &'static str)> {
    let in_group = move |path: &str| path.split('/').rev().nth(1) == Some(group);
    EXPERIMENTS.iter().copied().filter(move |(path, _)| in_group(path))
}
