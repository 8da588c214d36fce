//! Bounds of the prose: length of the README, width of code blocks, numbers, semicolons and colons per word, worn phrases, a figure on
//! each page of results. Needs the standard library only, so that it also runs without a build of the workspace:
//!
//! ```text
//! rustc --edition 2024 --test tests/program/prose.rs -o target/prose && target/prose --nocapture
//! RIMBENCH_PROSE=docs/cases target/prose --nocapture          lists what one folder or page exceeds, bounded or not
//! ```

use std::fs;
use std::path::{Path, PathBuf};

/// Folders and files that are held to the bounds: the start of a path.
const HELD: [&str; 4] = ["CONTRIBUTING.md", "METHODOLOGY.md", "README.md", "docs/"];

/// Most words that README.md shows, code and tables included.
const README_WORDS: usize = 800;
/// Most rows of a table in README.md.
const README_ROWS: usize = 10;
/// Most columns of a block of code: what a page of 830 pixels shows.
const CODE_COLUMNS: usize = 90;
/// Most numbers per 100 words of prose on a page of results.
const NUMBERS_PER_100: usize = 8;
/// Most semicolons and colons per 1000 words of prose, rounded up to whole ones per page.
const SEMICOLONS_PER_1000: usize = 3;
const COLONS_PER_1000: usize = 6;

/// Phrases with a plainer form (docs/glossary.md), in lower case.
const WORN: [&str; 30] = [
    "afresh",
    "anew",
    "but for",
    "end return",
    "end returned",
    "for want of",
    "is gone",
    "is what",
    "last to",
    "lasts to",
    "lies beside",
    "mean return",
    "mean returned",
    "nobody",
    "of ours",
    "of yours",
    "profile returned",
    "so are",
    "so do",
    "so does",
    "so is",
    "somebody",
    "stand beside",
    "stands above",
    "stands beside",
    "stands in",
    "what is returned",
    "what returns",
    "whatever",
    "whoever",
];

pub fn root() -> &'static Path {
    Path::new(option_env!("CARGO_MANIFEST_DIR").unwrap_or("."))
}

pub fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// All files with an extension below a folder.
pub fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path, extension));
        } else if path.extension().is_some_and(|own| own == extension) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Pages of the book, and the documents beside it.
pub fn documents() -> Vec<PathBuf> {
    let mut documents = files(&root().join("docs"), "md");
    documents.extend(["README.md", "METHODOLOGY.md", "CONTRIBUTING.md"].map(|name| root().join(name)));
    documents
}

/// The lines of a text with their numbers, without those of code.
pub fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    split_code(text).filter(|(_, _, code)| !code).map(|(number, line, _)| (number, line))
}

/// The lines of a text with their numbers, and whether they are code; the fences are in neither.
fn split_code(text: &str) -> impl Iterator<Item = (usize, &str, bool)> {
    let mut code = false;
    text.lines().enumerate().filter_map(move |(index, line)| {
        let fence = line.trim_start().starts_with("```");
        code ^= fence;
        (!fence).then_some((index + 1, line, code))
    })
}

/// Text with what is between two others replaced by a third, line ends kept.
fn replace_between(text: &str, open: &str, close: &str, by: &str) -> String {
    let (mut left, mut rest) = (String::new(), text);
    while let Some((before, behind)) = rest.split_once(open) {
        let (inside, after) = behind.split_once(close).unwrap_or((behind, ""));
        left += before;
        left += by;
        left.extend(inside.chars().filter(|c| *c == '\n'));
        rest = after;
    }
    left + rest
}

/// What a reader sees of Markdown: without comments, tags, pictures and targets of links; a quoted name is the word `code`.
fn shown(text: &str) -> String {
    let lines: String = split_code(text).map(|(_, line, code)| format!("{}\n", if code { "" } else { line })).collect();
    [("<!--", "-->", ""), ("`", "`", "code"), ("<", ">", ""), ("![", ")", ""), ("](", ")", "")]
        .into_iter()
        .fold(lines, |text, (open, close, by)| replace_between(&text, open, close, by))
}

/// The sentences of a page: without code, tables and headings, as words.
fn words_of_prose(text: &str) -> Vec<String> {
    let item = |line: &str| {
        let behind = line.trim_start().trim_start_matches(|c: char| c.is_ascii_digit());
        behind.strip_prefix(". ").unwrap_or(line).to_owned()
    };
    let text = shown(text);
    let lines = text.lines().filter(|line| !line.starts_with(['|', '#']) && !line.starts_with("[^"));
    lines.flat_map(|line| item(line).split_whitespace().map(str::to_owned).collect::<Vec<_>>()).collect()
}

/// Whether a word is a numeral, with its sign and brackets.
fn is_number(word: &str) -> bool {
    word.trim_start_matches(|c: char| !c.is_alphanumeric()).starts_with(|c: char| c.is_ascii_digit())
}

/// Worn phrases among words, and errors told as possessions ("has 36 N").
fn worn(words: &[String]) -> Vec<String> {
    let bare = |word: &String| word.trim_matches(|c: char| !c.is_alphanumeric()).to_lowercase();
    let ends = |word: &String| word.ends_with(['.', ';', ':', ',']);
    let mut found = Vec::new();
    for at in 0..words.len() {
        let context = || words[at.saturating_sub(2)..words.len().min(at + 6)].join(" ");
        let is = |phrase: &&str| {
            let length = phrase.split(' ').count();
            at + length <= words.len()
                && phrase.split(' ').zip(&words[at..]).all(|(part, word)| part == bare(word))
                && !words[at..at + length - 1].iter().any(ends)
        };
        found.extend(WORN.iter().filter(|phrase| is(phrase)).map(|phrase| format!("`{phrase}`: … {} …", context())));
        if let [verb, number, unit, ..] = &words[at..]
            && matches!(&*bare(verb), "has" | "have" | "had")
            && is_number(number)
            && matches!(
                unit.trim_end_matches(|c: char| c.is_ascii_punctuation() && c != '%'),
                "N" | "kN" | "%" | "times"
            )
        {
            found.push(format!("an error is no possession: … {} …", context()));
        }
    }
    found
}

/// Names of tests and paths of test files in what a page shows, pictures and targets of links left out.
fn names_of_tests(text: &str) -> Vec<String> {
    let lines: String = prose(text).map(|(_, line)| format!("{line}\n")).collect();
    let lines = [("<!--", "-->"), ("](", ")")]
        .into_iter()
        .fold(lines, |text, (open, close)| replace_between(&text, open, close, ""));
    let names = lines.split('`').skip(1).step_by(2).map(str::to_owned);
    let of_a_test = |name: &String| {
        let sentence = name.matches('_').count() >= 4
            && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
        sentence || name.ends_with("_test") || name.starts_with("tests/") && name.ends_with(".rs")
    };
    names.filter(of_a_test).collect()
}

/// All that a document exceeds, one line each. Its name is the path from the root.
fn offences(name: &str, text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (number, line, code) in split_code(text) {
        let columns = line.chars().count();
        if code && columns > CODE_COLUMNS {
            found.push(format!("{name}:{number}: {columns} columns of code, at most {CODE_COLUMNS}"));
        }
    }
    let words = words_of_prose(text);
    // Quarters of a bound are worth nothing to a reader: short pages may have the next whole number.
    let allowed = |per_1000: usize| (per_1000 * words.len()).div_ceil(1000);
    for (what, sign, per_1000) in [("semicolons", ';', SEMICOLONS_PER_1000), ("colons", ':', COLONS_PER_1000)] {
        let count = words.iter().filter(|word| word.trim_end_matches(['*', ')', '"']).ends_with(sign)).count();
        if count > allowed(per_1000) {
            let most = allowed(per_1000);
            found.push(format!("{name}: {count} {what} in {} words, at most {most}", words.len()));
        }
    }
    found.extend(worn(&words).into_iter().map(|what| format!("{name}: {what}")));
    if name == "README.md" {
        let everything = split_code(text).filter(|(_, _, code)| *code).map(|(_, line, _)| line).collect::<Vec<_>>();
        let all = shown(text) + &everything.join("\n");
        let count = all.split_whitespace().filter(|word| word.chars().any(char::is_alphanumeric)).count();
        if count > README_WORDS {
            found.push(format!("{name}: {count} words, at most {README_WORDS}"));
        }
        let tables = text.split("\n\n").map(|block| block.lines().filter(|line| line.starts_with('|')).count());
        let rows = tables.max().unwrap_or(0).saturating_sub(2);
        if rows > README_ROWS {
            found.push(format!("{name}: a table of {rows} rows, at most {README_ROWS}"));
        }
    }
    if name.starts_with("docs/results/") {
        let numbers = words.iter().filter(|word| is_number(word)).count();
        if 100 * numbers > NUMBERS_PER_100 * words.len() {
            let rate = 100.0 * numbers as f64 / words.len() as f64;
            found.push(format!("{name}: {rate:.1} numbers per 100 words, at most {NUMBERS_PER_100}"));
        }
        found.extend(names_of_tests(text).into_iter().map(|test| format!("{name}: the text names a test, `{test}`")));
        let riddles = prose(text).filter(|(_, line)| line.starts_with('#') && line.ends_with('?'));
        found.extend(riddles.map(|(number, line)| format!("{name}:{number}: a heading that asks: {line}")));
        if !text.contains("![") && !name.ends_with("/README.md") {
            found.push(format!("{name}: no figure"));
        }
    }
    found
}

#[test]
fn prose_is_within_its_bounds() {
    let asked = std::env::var("RIMBENCH_PROSE").ok();
    let held = |name: &str| match &asked {
        Some(start) => name.starts_with(start),
        None => HELD.iter().any(|start| name.starts_with(start)),
    };
    let mut found = Vec::new();
    for document in documents() {
        let name = document.strip_prefix(root()).unwrap().display().to_string();
        if held(&name) {
            found.extend(offences(&name, &read(&document)));
        }
    }
    assert!(found.is_empty(), "{} places to rewrite (docs/glossary.md):\n{}", found.len(), found.join("\n"));
}

/// What a file shows that is no page: texts in quotes and, in the command line, its comments, which are its help; all of the paper.
fn shown_of(name: &str, text: &str) -> String {
    if name.ends_with(".typ") || name.ends_with(".html") {
        return text
            .lines()
            .filter(|line| !line.trim_start().starts_with("//"))
            .map(|line| format!("{line}\n"))
            .collect();
    }
    let help = |line: &str| name.starts_with("src/cli/") && line.starts_with("/// ");
    let (mut shown, mut code) = (String::new(), String::new());
    for line in text.lines().map(str::trim_start) {
        match line {
            _ if help(line) => shown += &format!("{}\n", &line[4..]),
            _ if line.starts_with("//") || line.starts_with('#') => {}
            _ => code += &format!("{line}\n"),
        }
    }
    // Tests show nothing. Within a text a line may be broken.
    let code = code.split("mod tests {").next().unwrap_or_default();
    let code = code.replace("\\\n", "").replace("'\"'", "").replace("\\\"", "'");
    code.split('"').skip(1).step_by(2).for_each(|text| shown += &format!("{text}.\n"));
    shown
}

/// Claims, captions, the paper, the page, screens and errors keep the word list of the book.
#[test]
fn what_is_shown_outside_the_book_has_no_worn_phrase_either() {
    let mut shown = files(&root().join("experiments"), "toml");
    shown.extend(["paper/figures.toml", "paper/paper.typ"].map(|name| root().join(name)));
    shown.extend(files(&root().join("crates/rimbench-figures/page"), "html"));
    shown.extend(files(&root().join("src"), "rs"));
    for part in fs::read_dir(root().join("crates")).unwrap() {
        shown.extend(files(&part.unwrap().path().join("src"), "rs"));
    }
    let mut found = Vec::new();
    for file in shown {
        let name = file.strip_prefix(root()).unwrap().display().to_string();
        let text = shown_of(&name, &read(&file));
        let words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
        found.extend(worn(&words).into_iter().map(|what| format!("{name}: {what}")));
    }
    assert!(found.is_empty(), "{} places to rewrite (docs/glossary.md):\n{}", found.len(), found.join("\n"));
}

#[test]
fn the_bounds_must_see_what_exceeds_them() {
    let one = |name: &str, text: &str, what: &str| {
        let found = offences(name, text);
        assert!(found.len() == 1 && found[0].contains(what), "{text}: {found:?}");
    };
    let filler = "word ".repeat(200);
    let figure = "![a](b.svg)";
    one("docs/a.md", &format!("```text\n{}\n```", "x".repeat(91)), "91 columns");
    one("docs/a.md", &format!("{filler} The hold has 36 N at 5 ms."), "possession");
    one("docs/a.md", &format!("{filler} Tables are made\nanew."), "`anew`");
    one("docs/a.md", &format!("{filler} a; b; c."), "2 semicolons");
    one("docs/a.md", &format!("{filler} a: b: c: d."), "3 colons");
    one(
        "docs/results/a.md",
        "Errors of 5 and <!-- value claim=study/x:y -->6 N<!-- /value --> in words and figures ![a](b.svg).",
        "numbers per 100",
    );
    one("docs/results/a.md", &format!("{figure} `tests/numerics/a.rs`"), "names a test");
    one("docs/results/a.md", &format!("{figure} `the_hold_is_stable_up_to`"), "names a test");
    one("docs/results/a.md", &format!("## Is it luck?\n\n{figure}"), "a heading that asks");
    one("docs/results/a.md", "Words.", "no figure");
    let worn_in = |name: &str, text: &str| {
        let words: Vec<String> = shown_of(name, text).split_whitespace().map(str::to_owned).collect();
        worn(&words).len()
    };
    assert_eq!(worn_in("a.rs", "// anew\nlet a = \"runs are \\\n    made anew\";\n/// anew\n"), 1);
    assert_eq!(worn_in("src/cli/a.rs", "    /// Runs are made anew\nfn anew() {}\n"), 1);
    assert_eq!(worn_in("a.toml", "# anew\ntext = \"whatever the phase\"\n"), 1);
    assert_eq!(worn_in("a.typ", "// anew\nThe hold has 5 N, and it is gone.\n"), 2);
    one("README.md", &"word ".repeat(801), "801 words");
    let row = "| a | b |\n";
    one("README.md", &format!("{row}|---|---|\n{}", row.repeat(11)), "11 rows");
    let fine = format!(
        "{filler}`a; b` [36](x:y) <!-- c: d --> at 5 ms.\n\n1. Item.\n\n| has 36 N |\n|---|\n\n```sh\nanew\n```\n"
    );
    assert_eq!(offences("docs/results/a.md", &format!("{fine}{figure}")), Vec::<String>::new());
}
