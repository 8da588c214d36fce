//! The technical report, as far as it can be checked without setting it: it types no number of a result, what it names
//! exists, and every picture can be read aloud. What needs the typesetter is in `.ci/paper`.

use crate::program::{assert_has, rimbench, root, said, stand_in};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Constants of the method that a sentence may have, as the documentation has them: contact margins, the bound of
/// divergence, the threshold of a lift-off, the level of an interval, and the slope from which on an order counts as
/// two.
const CONSTANTS: [&str; 11] =
    ["0.1 s", "1 µm", "10 µm", "30 µm", "0.1 mm", "0.3 mm", "1 mm", "3 mm", "3 times", "95 %", "1.9"];

/// How the headings of the appendix are numbered.
const NUMBERING: &str = "A.1";

/// Sources without a DOI that could be verified.
const WITHOUT_DOI: [&str; 5] = ["raoofian", "raoofian2024", "moreau1988", "delayrim2024", "eguillon2019"];

/// Groups of experiments, as their names begin.
const GROUPS: [&str; 3] = ["paper/", "published/", "study/"];

fn read(path: &str) -> String {
    crate::program::read(root().join(path))
}

/// A Typst source taken apart: what is left of it without comments, strings, raw text and formulas, whose places are
/// blank there, and the strings, each with its line.
struct Source {
    rest: String,
    strings: Vec<(usize, String)>,
}

impl Source {
    fn of(text: &str) -> Self {
        let (mut rest, mut strings) = (String::new(), Vec::new());
        let mut line = 1;
        let mut letters = text.chars().peekable();
        while let Some(letter) = letters.next() {
            let before = rest.chars().last();
            match letter {
                '/' if letters.peek() == Some(&'/') && before != Some(':') => {
                    while letters.peek().is_some_and(|next| *next != '\n') {
                        letters.next();
                    }
                }
                '"' | '`' | '$' if before != Some('\\') => {
                    let (start, mut inside) = (line, String::new());
                    let mut escaped = false;
                    for next in letters.by_ref() {
                        line += usize::from(next == '\n');
                        if next == letter && !escaped {
                            break;
                        }
                        escaped = next == '\\' && !escaped;
                        inside.push(next);
                    }
                    rest.push('\u{2300}');
                    rest.extend(inside.matches('\n').map(|_| '\n'));
                    if letter != '$' {
                        strings.push((start, inside));
                    }
                }
                _ => {
                    line += usize::from(letter == '\n');
                    rest.push(letter);
                }
            }
        }
        Source { rest, strings }
    }

    /// Blanks what stands between the brackets that open after each occurrence of a word.
    fn without_arguments_of(&self, word: &str) -> String {
        let mut rest: Vec<char> = self.rest.chars().collect();
        let word: Vec<char> = word.chars().collect();
        let mut at = 0;
        while at + word.len() <= rest.len() {
            if rest[at..].starts_with(&word) {
                let mut depth = 0;
                at += word.len() - 1;
                loop {
                    match rest[at] {
                        '(' => depth += 1,
                        ')' => depth -= 1,
                        '\n' => {}
                        _ => rest[at] = ' ',
                    }
                    if depth == 0 {
                        break;
                    }
                    at += 1;
                }
            }
            at += 1;
        }
        rest.into_iter().collect()
    }
}

/// Whether a number may stand where it does in a source: which run is meant, how it is written, or in the key of a
/// source; never what came out.
fn names_a_run_or_a_form(line: &str, at: usize) -> bool {
    let (before, behind) = (&line[..at], line[at..].trim_start_matches(|c: char| c.is_ascii_digit() || c == '.'));
    let step_list =
        line.starts_with("#let ") && before.split(" = ").next().is_some_and(|name| name.ends_with("-steps"));
    let source =
        before.rsplit(|c: char| !c.is_alphanumeric() && c != '@').next().is_some_and(|word| word.starts_with('@'));
    let keys = ["ms(", "h: ", "digits: ", "scale: ", "#set page(columns: ", "#counter(heading).update("];
    step_list
        || source
        || keys.iter().any(|key| before.ends_with(key))
        || behind.starts_with("fr") && !behind[2..].starts_with(char::is_alphanumeric)
}

/// Numbers that are typed where a result would be.
fn typed_numbers(text: &str) -> Vec<String> {
    let source = Source::of(text);
    let mut found = Vec::new();
    // What `holds` asks are bounds, not results.
    for (index, line) in source.without_arguments_of("#holds(").lines().enumerate() {
        let mut inside = false;
        for (at, letter) in line.char_indices() {
            let begins = letter.is_ascii_digit() && !inside;
            inside = letter.is_ascii_digit() || inside && letter == '.';
            if begins && !names_a_run_or_a_form(line, at) {
                found.push(format!("line {}: {}", index + 1, line.trim()));
            }
        }
    }
    let (experiments, names) = (experiments(), names());
    for (line, string) in &source.strings {
        // Invisible letters are written by their code.
        let plain = string.replace("\\u{a0}", "").replace("\\u{200b}", "");
        let setting = |part: &str| part.split_once('=').is_some_and(|(key, _)| !key.contains(char::is_numeric));
        let is_name = names.contains(&format!("\"{plain}\"")) || names.contains(&format!("/{plain}\""));
        let known = is_name
            || experiments.contains(&plain)
            || CONSTANTS.contains(&&*plain)
            || plain == NUMBERING
            || plain.trim().split(' ').all(setting);
        if plain.contains(|c: char| c.is_ascii_digit()) && !known {
            found.push(format!("line {line}: \"{string}\""));
        }
    }
    found
}

/// The texts in which the names of rows and figures stand, in quotes.
fn names() -> String {
    rimbench::shipped::EXPERIMENTS.iter().map(|(_, text)| *text).chain([rimbench::shipped::FIGURES.1]).collect()
}

/// Folders <group>/<name> of results.
fn experiments() -> BTreeSet<String> {
    let folders = |path: PathBuf| fs::read_dir(path).into_iter().flatten().map(|entry| entry.unwrap().path());
    folders(root().join("results"))
        .flat_map(folders)
        .filter(|path| path.join("digest.toml").is_file())
        .map(|path| path.strip_prefix(root().join("results")).unwrap().to_str().unwrap().replace('\\', "/"))
        .collect()
}

#[test]
fn the_report_types_no_number_of_a_result() {
    let found = typed_numbers(&read("paper/paper.typ"));
    assert!(found.is_empty(), "numbers are read from results, not typed:\n{}", found.join("\n"));
}

#[test]
fn the_check_must_see_a_typed_number() {
    for typed in [
        "The error is 17 N.",
        "The error is\n#newtons(17.3).",
        "#let error = 17",
        "#constant(\"17 N\")",
        "It completes at `31` of them.",
        "#cell(select(field, h: 5)) of 31",
    ] {
        assert_eq!(typed_numbers(typed).len(), 1, "{typed}");
    }
    for read in [
        "// 17 N",
        "#force(stability, \"rim-nonsmooth/1mm\", h: 5)",
        "#let map-steps = (1, 5, 10)",
        "$ x = 1/2 $",
        "#holds(\n  middle(rows) < 0.5 * (middle(others) + 1),\n) and so on",
        "columns: (1fr, auto), at #ms(0.5)",
        "#constant(\"95 %\") of friction \"friction=0.3\"",
    ] {
        assert_eq!(typed_numbers(read), Vec::<String>::new(), "{read}");
    }
}

#[test]
fn what_the_report_names_exists() {
    let source = Source::of(&read("paper/paper.typ"));
    let there = experiments();
    let mut named = 0;
    for (line, string) in &source.strings {
        if GROUPS.iter().any(|group| string.starts_with(group)) && !string.contains(['*', '.']) {
            assert!(there.contains(string), "line {line}: no results of {string}");
            named += 1;
        }
    }
    assert!(named > 10, "only {named} experiments are named: the check reads nothing");

    let listed: BTreeSet<String> = Source::of(&read("paper/results.typ"))
        .strings
        .into_iter()
        .map(|(_, string)| string)
        .filter(|string| GROUPS.iter().any(|group| string.starts_with(group)))
        .collect();
    assert_eq!(listed, there, "the list of experiments in paper/results.typ");

    // Pictures, by the two strings that follow each call.
    let text = read("paper/paper.typ");
    let mut pictures = 0;
    for call in text.split("#picture(").skip(1) {
        let mut quoted = call.split('"').skip(1).step_by(2);
        let (experiment, id) = (quoted.next().unwrap(), quoted.next().unwrap());
        let svg = read(&format!("results/{experiment}/figures/{id}.svg"));
        assert!(svg.contains("font-family=\"Inter,"), "{id}: another typeface than that of the program comes first");
        let own = call.split("#picture(").next().unwrap();
        let alternative = own.split("alt: \"").nth(1).and_then(|rest| rest.split('"').next()).unwrap_or_default();
        assert!(alternative.len() > 80, "{id}: no alternative text, or a short one: {alternative:?}");
        pictures += 1;
    }
    assert!(pictures >= 4);
    for formula in text.split("#displayed(").skip(1) {
        assert!(formula.trim_start().starts_with('"'), "a formula without words: {}", formula.lines().next().unwrap());
    }
}

#[test]
fn every_reference_of_the_report_leads_somewhere() {
    let source = Source::of(&read("paper/paper.typ"));
    let word = |rest: &str| -> String { rest.chars().take_while(|c| c.is_alphanumeric() || *c == '-').collect() };
    let of_list = |rest: &str| -> Option<String> {
        let name = word(rest.strip_prefix('<')?);
        (!name.is_empty() && rest[1 + name.len()..].starts_with('>')).then_some(name)
    };
    let mut labels = BTreeSet::new();
    for (at, _) in source.rest.match_indices('<') {
        if let Some(label) = of_list(&source.rest[at..]) {
            assert!(labels.insert(label.clone()), "<{label}> stands twice");
        }
    }
    let bibliography = read("paper/references.bib");
    let entries: Vec<(&str, &str)> =
        bibliography.split("\n@").map(|entry| (entry.split(['{', ',']).nth(1).unwrap_or_default(), entry)).collect();
    let keys: BTreeSet<String> = entries.iter().map(|(key, _)| (*key).to_owned()).collect();
    let used: BTreeSet<String> = source
        .rest
        .match_indices('@')
        .map(|(at, _)| word(&source.rest[at + 1..]))
        .filter(|name| !name.is_empty())
        .collect();
    assert!(used.len() > 20, "only {} references are used: the check reads nothing", used.len());
    for name in &used {
        assert!(labels.contains(name) || keys.contains(name), "@{name} leads nowhere");
    }
    for key in &keys {
        assert!(used.contains(key), "{key} is in the bibliography and not cited");
    }
    for (key, entry) in entries {
        let doi = entry.split("doi = {").nth(1).and_then(|rest| rest.split('}').next());
        assert_eq!(doi.is_none(), WITHOUT_DOI.contains(&key), "{key}: {doi:?}");
        assert!(doi.is_none_or(|doi| doi.starts_with("10.") && doi.contains('/')), "{key}: {doi:?}");
    }
}

fn paper(programs: &Path, out: &Path, code: i32) -> String {
    let mut command = rimbench();
    command.current_dir(root()).env("PATH", programs).args(["report", "--pdf", "--out"]).arg(out);
    said(&mut command, code)
}

#[test]
fn without_the_typesetter_one_error_says_how_to_get_it() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("paper.pdf");
    let message = paper(folder.path(), &out, 2);
    assert!(message.lines().count() == 1 && !out.exists(), "{message}");
    assert_has(&message, &["pip install typst", "python3 paper/build.py", "paper/paper.typ"]);
    let elsewhere = said(rimbench().current_dir(folder.path()).args(["report", "--pdf"]), 2);
    assert_has(&elsewhere, &["folder of the project"]);
}

/// What stands in for the compiler here gets what it needs, and what it says is passed on.
#[cfg(unix)]
#[test]
fn the_compiler_gets_the_source_the_typeface_and_the_standard() {
    let folder = tempfile::tempdir().unwrap();
    let (program, out) = (folder.path().join("typst"), folder.path().join("paper.pdf"));
    stand_in(&program, "for last; do :; done; echo \"$@\" >\"$last\"");
    paper(folder.path(), &out, 0);
    let told = crate::program::read(&out);
    let typeface = "--font-path crates/presentation/rimbench-figures/src/font";
    assert_has(&told, &["compile --root .", typeface, "--pdf-standard ua-1 paper/paper.typ"]);
    stand_in(&program, "echo 'paper.typ: this sentence is no longer true' >&2; exit 1");
    assert_has(&paper(folder.path(), &out, 2), &["no longer true"]);
    assert_eq!(crate::program::read(&out), told, "an older report is left as it was");
}
