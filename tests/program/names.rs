//! What the documents call by name is there: commands with their options, schemes, cases, experiments.

use crate::conveniences::{commands, said};
use crate::documents::{documents, files, prose, read, root};
use rimbench::catalogue::Catalogue;
use rimbench::metrics::METRICS;
use std::collections::{BTreeMap, BTreeSet};

/// Names with hyphens that are no words of this program: data of others, what the reader makes, a target of the compiler.
const OF_OTHERS: &str = "lim-crane osp-quarter-truck siconos-planar siconos-space my-case my-scheme box-of-fmus data-series wasm32-unknown-unknown";

/// Experiments that stand for any, or that the reader makes.
const ANY: [&str; 2] = ["study/x", "study/heavy_box"];

/// What there is.
struct Known {
    catalogue: Catalogue,
    commands: Vec<String>,
    options: BTreeSet<String>,
    source: String,
}

impl Known {
    fn find() -> Self {
        let commands = commands();
        assert!(commands.len() <= 10, "{commands:?}");
        let parts = ["record", "compare"].map(|part| said(&["perf", part, "--help"]));
        let help: String = commands.iter().map(|command| said(&[command, "--help"])).chain(parts).collect();
        let words =
            help.split(|c: char| c.is_whitespace() || "[]<>=,.".contains(c)).filter(|word| word.starts_with("--"));
        let options = words.map(str::to_owned).collect();
        let files = ["crates", "src"].iter().flat_map(|folder| files(&root().join(folder), "rs"));
        let is_code = |line: &&str| !line.trim_start().starts_with("//");
        let source = files.map(|file| read(&file).lines().filter(is_code).collect::<Vec<_>>().join("\n")).collect();
        Known { catalogue: rimbench::everything().unwrap(), commands, options, source }
    }

    /// What is wrong with the arguments of a call of the program.
    fn of_call(&self, arguments: &str) -> Vec<String> {
        let words = arguments.split_whitespace().take_while(|word| !["#", "--", "|", ">", "\\"].contains(word));
        let words: Vec<&str> = words.map(|word| word.split('=').next().unwrap_or_default()).collect();
        let plain = |word: &str| word.starts_with(|c: char| c.is_ascii_lowercase()) && !word.contains('.');
        let mut faults = Vec::new();
        if let Some(command) = words.first().filter(|word| plain(word))
            && *command != "help"
            && !self.commands.iter().any(|known| known == command)
        {
            faults.push(format!("no command `{command}`"));
        }
        let unknown = words.iter().filter(|word| word.starts_with("--") && !self.options.contains(**word));
        faults.extend(unknown.map(|option| format!("no option `{option}`")));
        let named = words.windows(2).filter(|pair| plain(pair[1]) && !OF_OTHERS.contains(pair[1]));
        faults.extend(named.filter_map(|pair| match pair[0] {
            "--scheme" => self.catalogue.scheme(pair[1]).err().map(|error| error.to_string()),
            "--case" => self.catalogue.case(pair[1]).err().map(|error| error.to_string()),
            _ => None,
        }));
        faults
    }

    /// What is wrong with a word of code that may be a name: it is that of nothing.
    fn of_word(&self, word: &str) -> Option<String> {
        let known = self.catalogue.scheme(word).is_ok()
            || self.catalogue.case(word).is_ok()
            || METRICS.iter().any(|metric| metric.name == word)
            || self.source.contains(&format!("\"{word}\""))
            || root().join("crates").join(word).is_dir()
            || OF_OTHERS.contains(word);
        let is_type = word.starts_with(|c: char| c.is_ascii_uppercase()) && word.contains(|c: char| c.is_lowercase());
        let known = known || is_type && self.source.contains(word);
        ((word.contains('-') || is_type) && !known).then(|| format!("`{word}` is the name of nothing"))
    }
}

/// Experiments that a line names: as files anywhere, or by group and name in a word of code.
fn experiments<'a>(line: &'a str, words: &[&'a str]) -> Vec<&'a str> {
    let files = line.split("experiments/").skip(1).filter_map(|rest| rest.split_once(".toml")).map(|(name, _)| name);
    let of_group = |word: &&&str| ["paper/", "published/", "study/"].iter().any(|group| word.starts_with(group));
    let named = words.iter().filter(of_group).copied();
    let is_name = |name: &&str| name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || "_/".contains(c));
    files.chain(named).filter(is_name).filter(|name| !name.ends_with('/') && name.split('/').count() == 2).collect()
}

#[test]
fn what_the_documents_call_by_name_is_there() {
    let known = Known::find();
    let (mut faults, mut seen, mut judged) = (Vec::new(), [0; 3], BTreeMap::new());
    for document in documents() {
        let text = read(&document);
        let of_prose: BTreeSet<usize> = prose(&text).map(|(number, _)| number).collect();
        for (number, line) in text.lines().enumerate().map(|(index, line)| (index + 1, line)) {
            let is_prose = of_prose.contains(&number);
            let spans = line.split('`').skip(1).step_by(2);
            let code: Vec<&str> = if is_prose { spans.collect() } else { vec![line.trim()] };
            let mut found = Vec::new();
            for part in &code {
                if let Some(arguments) = part.strip_prefix("rimbench ").filter(|rest| !rest.starts_with(' ')) {
                    seen[0] += 1;
                    found.extend(known.of_call(arguments));
                }
                let word = part.split('/').next().unwrap_or_default();
                let is_word = |c: char| c.is_ascii_alphanumeric() || c == '-';
                let is_name =
                    word.starts_with(|c: char| c.is_ascii_lowercase() || (c.is_ascii_uppercase() && *part == word));
                if is_prose && is_name && word.chars().all(is_word) {
                    seen[1] += 1;
                    let fault = judged.entry(word.to_owned()).or_insert_with(|| known.of_word(word));
                    found.extend(fault.clone());
                }
            }
            for name in experiments(line, &code) {
                seen[2] += 1;
                let there = root().join(format!("experiments/{name}.toml")).is_file();
                found.extend((!there && !ANY.contains(&name)).then(|| format!("no experiment `{name}`")));
            }
            faults.extend(found.into_iter().map(|fault| format!("{}:{number}: {fault}", document.display())));
        }
    }
    assert!(seen.iter().all(|count| *count > 40), "only {seen:?} names found: the check reads nothing");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
