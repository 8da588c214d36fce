//! What the program carries with it, so that it works from any folder: the experiments, the list of figures, and the source
//! of the report, as they were when it was built.

/// Experiment files, each as its path in the source (`experiments/<group>/<name>.toml`) and its text, by path.
pub const EXPERIMENTS: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/experiments.rs"));

/// The list of figures: path and text.
pub const FIGURES: (&str, &str) = ("paper/figures.toml", include_str!("../paper/figures.toml"));

/// The source of the report: path and text.
pub const REPORT: (&str, &str) = ("paper/report.md", include_str!("../paper/report.md"));

/// The experiments of one group, each with its path and text.
pub fn experiments_of(group: &str) -> impl Iterator<Item = (&'static str, &'static str)> {
    let in_group = move |path: &str| path.split('/').rev().nth(1) == Some(group);
    EXPERIMENTS.iter().copied().filter(move |(path, _)| in_group(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_experiment_of_the_source_is_carried_with_its_text() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut count = 0;
        for group in std::fs::read_dir(root.join("experiments")).unwrap().map(|entry| entry.unwrap()) {
            for file in std::fs::read_dir(group.path()).into_iter().flatten().map(|entry| entry.unwrap().path()) {
                if file.extension().is_some_and(|extension| extension == "toml") {
                    let name = file.file_name().unwrap().to_str().unwrap();
                    let path = format!("experiments/{}/{name}", group.file_name().to_str().unwrap());
                    let carried = EXPERIMENTS.iter().find(|(known, _)| *known == path);
                    assert_eq!(
                        carried.map(|(_, text)| *text),
                        Some(&*std::fs::read_to_string(&file).unwrap()),
                        "{path}"
                    );
                    count += 1;
                }
            }
        }
        assert_eq!(count, EXPERIMENTS.len());
        assert!(experiments_of("paper").count() >= 4 && experiments_of("nope").count() == 0);
    }
}
