//! Commands that are parts of others, or went, and options that went: a sentence for each that says the way to go.

use rimbench::runs::RunRequest;

/// Name and sentence.
const GONE: [(&str, &str); 13] = [
    ("plan", "`rimbench run FILE --dry-run` prints the runs of an experiment"),
    ("submit", "`rimbench run FILE --engine slurm` or `--engine hyperqueue` hands what is missing to a cluster"),
    ("collect", "`rimbench run FILE --collect DIR…` merges shards"),
    ("figures", "`rimbench report --figures` draws the figures"),
    ("rank", "`rimbench report --ranking` ranks the scheme rows"),
    ("paper", "`rimbench report --pdf` sets the technical report"),
    ("check-advice", "`rimbench advise --check` says how right advices are"),
    ("corpus", "`rimbench solvers --harvest` harvests the contact problems of runs"),
    ("schema", "`rimbench list experiment-schema` and `rimbench list case-schema` print JSON Schemas"),
    ("man", "`rimbench completions --man` prints the manual page"),
    (
        "import",
        "`sha256sum --check SHA256SUMS` checks a data package, and `rimbench run` its `experiment.toml` computes it again",
    ),
    ("--measure-costs", "prices are `--exchanges-cost`, `--mechanics-cost`, `--micro-cost` and `--model-cost`"),
    ("check-submission", "a scheme of somebody else joins by a pull request, as CONTRIBUTING.md says"),
];

/// Says the way to go without a command or a flag, if it is one that there was.
pub(super) fn way_to_go(word: &str) -> Option<String> {
    if let Some((name, way)) = GONE.iter().find(|(name, _)| *name == word) {
        let kind = if name.starts_with("--") { "option" } else { "command" };
        return Some(format!("there is no {kind} `{name}`: {way}"));
    }
    RunRequest::gone(&word.strip_prefix("--")?.replace('-', "_")).map(|sentence| sentence.to_string())
}
