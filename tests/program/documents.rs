//! The documents: links lead somewhere, tests that they name exist, everything that runs by name has its page, and numbers that
//! they repeat are those of the committed files.

pub use crate::prose::{documents, files, prose, read, root};
use crate::support::{cases, schemes};
use rimbench::cases::ReferenceMethod;
use rimbench::catalogue::Catalogue;
use rimbench::claims::{CheckedClaim, Claimant, Verdict, read_claims};
use rimbench::figures::{claims_markdown, fill_page, without_filled};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Longest line, in characters; a table's row is one line.
const LONGEST_LINE: usize = 120;
/// Longest METHODOLOGY.md, in lines: a contract is read in one go.
const LONGEST_CONTRACT: usize = 150;

/// Targets of the links of a line, in either form.
fn links(line: &str) -> impl Iterator<Item = &str> {
    let named = line.strip_prefix('[').and_then(|rest| rest.split_once("]: ")).map(|(_, target)| target);
    line.split("](").skip(1).filter_map(|rest| rest.split(')').next()).chain(named)
}

/// The anchors of a text, as forges make them of headings.
fn anchors(text: &str) -> BTreeSet<String> {
    let slug = |heading: &str| {
        let kept = heading.trim().to_lowercase();
        let kept = kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    prose(text).filter_map(|(_, line)| line.strip_prefix('#')).map(|rest| slug(rest.trim_start_matches('#'))).collect()
}

/// What is wrong with a link of a document, if anything.
fn fault(document: &Path, link: &str) -> Option<String> {
    if link.contains("://") {
        return None;
    }
    let (file, anchor) = link.split_once('#').map_or((link, None), |(file, anchor)| (file, Some(anchor)));
    let target = if file.is_empty() { document.to_owned() } else { document.parent().unwrap().join(file) };
    if !target.exists() {
        return Some("leads nowhere".to_owned());
    }
    let anchor = anchor?;
    (!anchors(&read(&target)).contains(anchor)).then(|| format!("no heading is `{anchor}`"))
}

#[test]
fn every_link_of_the_documents_leads_somewhere() {
    let (mut faults, mut seen) = (Vec::new(), 0);
    for document in documents() {
        for (number, line) in prose(&read(&document)) {
            for link in links(line) {
                seen += 1;
                faults.extend(
                    fault(&document, link).map(|what| format!("{}:{number}: {link} {what}", document.display())),
                );
            }
        }
    }
    assert!(seen > 300, "only {seen} links found: the check reads nothing");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_check_must_see_a_link_that_leads_nowhere() {
    let readme = root().join("README.md");
    assert_eq!(fault(&readme, "docs/guide/last-run.md").unwrap(), "leads nowhere");
    assert_eq!(fault(&readme, "#as-a-shared-library").unwrap(), "no heading is `as-a-shared-library`");
    assert_eq!(fault(&readme, "#use-it"), None);
    assert_eq!(links("see [a](b.md), and ![c](d.png)").collect::<Vec<_>>(), ["b.md", "d.png"]);
    assert_eq!(links("[a]: b.md").collect::<Vec<_>>(), ["b.md"]);
    assert_eq!(prose("one\n```sh\n[two](x)\n```\nthree").map(|(number, _)| number).collect::<Vec<_>>(), [1, 5]);
    assert!(anchors("## What `a_b` is, in H").contains("what-a_b-is-in-h"));
}

#[test]
fn every_page_is_in_the_summary_and_the_reverse() {
    let book = root().join("docs");
    let summary = read(&book.join("SUMMARY.md"));
    let listed: BTreeSet<PathBuf> = summary.lines().flat_map(links).map(|link| book.join(link)).collect();
    let pages = files(&book, "md").into_iter().filter(|page| !page.ends_with("SUMMARY.md")).collect();
    assert_eq!(listed, pages);
}

#[test]
fn lines_are_short_and_so_is_the_contract() {
    let too_long = |document: &PathBuf| {
        let text = read(document);
        // Markers do not show.
        let shown = |line: &str| {
            line.split("<!--").map(|part| part.split_once("-->").map_or(part, |(_, shown)| shown)).collect()
        };
        let long = prose(&text).filter(|(_, line)| {
            let shown: String = shown(line);
            !line.starts_with('|') && !line.starts_with("![") && shown.chars().count() > LONGEST_LINE
        });
        long.map(|(number, _)| format!("{}:{number}", document.display())).collect::<Vec<_>>()
    };
    let found: Vec<String> = documents().iter().flat_map(too_long).collect();
    assert!(found.is_empty(), "longer than {LONGEST_LINE} characters:\n{}", found.join("\n"));
    assert!(read(&root().join("METHODOLOGY.md")).lines().count() <= LONGEST_CONTRACT);
}

/// The page of a case or a scheme, below its folder of the book: that of its family, to which the list of the folder leads, or its own; none of
/// one that no experiment has judged yet.
pub fn page_of(folder: &str, name: &str) -> Option<PathBuf> {
    let folder = root().join("docs").join(folder);
    let row = format!("| [{name}](");
    let list = read(&folder.join("README.md"));
    let listed = list.lines().find_map(|line| line.strip_prefix(&row)?.split(')').next());
    let page = folder.join(listed.map_or_else(|| format!("{name}.md"), str::to_owned));
    (listed.is_some() || page.is_file()).then_some(page)
}

#[test]
fn every_case_and_scheme_that_an_experiment_names_has_a_page_and_each_page_is_of_one() {
    let cases = cases().iter().map(|case| ("cases", case.name.clone().into_owned()));
    let schemes = schemes().iter().map(|scheme| ("schemes", scheme.name.clone().into_owned()));
    let experiments: String = files(&root().join("experiments"), "toml").iter().map(|file| read(file)).collect();
    let mut missing = Vec::new();
    let mut pages = BTreeSet::from(["README.md", "options.md"].map(str::to_owned));
    for (folder, name) in cases.chain(schemes) {
        match page_of(folder, &name) {
            Some(page) if page.is_file() && read(&page).contains(&name) => {
                pages.insert(page.file_name().unwrap().to_string_lossy().into_owned());
            }
            Some(page) => missing.push(format!("{} does not name {name}", page.display())),
            None if experiments.contains(&format!("\"{name}\"")) => missing.push(format!("no page of {name}")),
            None => {}
        }
    }
    let own = ["cases", "schemes"].into_iter().flat_map(|folder| files(&root().join("docs").join(folder), "md"));
    let strangers = own.filter(|page| !pages.contains(&*page.file_name().unwrap().to_string_lossy()));
    missing.extend(strangers.map(|page| format!("{} is the page of nothing in the catalogue", page.display())));
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}

/// Whether a word may be the name of a test: a sentence has at least five words.
fn is_sentence(word: &str) -> bool {
    word.matches('_').count() >= 4 && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}

#[test]
fn every_test_that_a_document_names_exists() {
    let folders = ["crates", "src", "tests"].map(|folder| root().join(folder));
    let code: String = folders.iter().flat_map(|folder| files(folder, "rs")).map(|file| read(&file)).collect();
    let (mut missing, mut seen) = (Vec::new(), 0);
    for document in documents() {
        for (number, line) in prose(&read(&document)) {
            for sentence in line.split('`').skip(1).step_by(2).filter(|word| is_sentence(word)) {
                seen += 1;
                // Columns and keys may be as long; they are known to the code in quotes.
                let known = [format!("fn {sentence}("), format!("\"{sentence}\""), format!("{sentence}: ")];
                if !known.iter().any(|known| code.contains(known)) {
                    missing.push(format!("{}:{number}: {sentence}", document.display()));
                }
            }
        }
    }
    assert!(seen > 30, "only {seen} names of tests found: the check reads nothing");
    assert!(missing.is_empty(), "no such test:\n{}", missing.join("\n"));
}

/// Blocks of Rust in a text: number of the line before, whether it is quoted (`rust,ignore`), lines without their indentation.
fn programs(text: &str) -> Vec<(usize, bool, Vec<&str>)> {
    let (mut found, mut inside) = (Vec::new(), false);
    for (index, line) in text.lines().map(str::trim).enumerate() {
        match line.strip_prefix("```") {
            Some("") => inside = false,
            Some(language) if language.starts_with("rust") => {
                inside = true;
                found.push((index + 1, language == "rust,ignore", Vec::new()));
            }
            Some(_) => {}
            None if inside => found.last_mut().expect("inside a block").2.push(line),
            None => {}
        }
    }
    found
}

#[test]
fn rust_code_of_the_documents_is_compiled_or_quoted_from_what_is() {
    let folders = ["crates", "examples"].map(|folder| root().join(folder));
    let code: Vec<String> = folders.iter().flat_map(|folder| files(folder, "rs")).map(|file| read(&file)).collect();
    let code: Vec<Vec<&str>> = code.iter().map(|text| text.lines().map(str::trim).collect()).collect();
    let (compiled, mut faults, mut seen) = (read(&root().join("src/lib.rs")), Vec::new(), [0, 0]);
    for document in documents() {
        let (text, name) = (read(&document), document.strip_prefix(root()).unwrap().display().to_string());
        for (number, quoted, lines) in programs(&text) {
            seen[usize::from(quoted)] += 1;
            if quoted && !code.iter().any(|file| file.windows(lines.len()).any(|window| window == lines)) {
                faults.push(format!("{name}:{number}: quoted from no source file"));
            }
            if !quoted && !compiled.contains(&format!("include_str!(\"../{name}\")")) {
                faults.push(format!("{name}:{number}: src/lib.rs does not compile this page"));
            }
        }
    }
    assert!(seen[0] >= 3 && seen[1] >= 8, "only {seen:?} blocks of Rust found: the check reads nothing");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_readme_counts_the_committed_claims() {
    let claims = read_claims(&root().join("results/paper/claims.csv")).unwrap();
    // Claims that others have replaced are kept, and counted nowhere; variants of one statement count once.
    for claim in claims.iter().filter(|claim| !claim.variant_of.is_empty()) {
        let id = claim.variant_of.rsplit('/').next().unwrap();
        let is_of = |other: &CheckedClaim| other.id == id && other.counts() && other.by == claim.by;
        assert!(claims.iter().any(is_of), "{} of {id}", claim.id);
    }
    let count = |by: &[Claimant]| {
        let own = claims.iter().filter(|claim| claim.counts() && by.contains(&claim.by));
        (own.clone().filter(|claim| claim.verdict == Verdict::Reproduced).count(), own.count())
    };
    let [all, paper, ours] = [&[Claimant::Paper, Claimant::Ours][..], &[Claimant::Paper], &[Claimant::Ours]].map(count);
    let sentence = format!(
        "**{} of {} statements reproduce**: {} of {} from the paper, {} of {} from this project.",
        all.0, all.1, paper.0, paper.1, ours.0, ours.1
    );
    let readme = read(&root().join("README.md"));
    assert!(readme.contains(&sentence), "README.md does not say: {sentence}");
    assert!(readme.contains("](results/paper/claims.md)"), "README.md does not link to the table of claims");
    assert_eq!(claims_markdown(&claims), read(&root().join("results/paper/claims.md")));
    let replaced = claims.iter().filter(|claim| !claim.superseded.is_empty()).count();
    let page = read(&root().join("results/paper/report.html"));
    let sentence = format!("<strong>{} of {} claims reproduce</strong>", all.0, all.1);
    assert!(page.contains(&sentence) && page.contains(&format!("{replaced} more are superseded")), "{sentence}");
}

/// How a reference is made is said by the case itself: the code fills in what a page says, with `RIMBENCH_FILL_PAGES=1`.
#[test]
fn every_case_page_says_how_its_reference_is_made() {
    let catalogue = Catalogue::standard();
    let (mut faults, mut said) = (Vec::new(), 0);
    for page in files(&root().join("docs/cases"), "md") {
        let (text, mut made) = (read(&page), String::new());
        let mut parts = text.split("<!-- reference case=");
        let mut own = parts.next().unwrap().to_owned();
        made += &own;
        for part in parts {
            let (name, rest) = part.split_once(" -->").unwrap();
            let (_, behind) = rest.split_once("<!-- /reference -->").unwrap();
            let case = catalogue.case(name).unwrap();
            let sentence = match (case.reference)(&case.default_parameters()).unwrap() {
                ReferenceMethod::Refined => "The reference is monolithic, by the semi-implicit rule.",
                ReferenceMethod::EventDriven => "The reference steps both sides from event to event.",
                ReferenceMethod::Own(_) => "The reference is an integrator of its own.",
                ReferenceMethod::Exact(_) => "The reference is a closed form.",
            };
            made += &format!("<!-- reference case={name} -->{sentence}<!-- /reference -->{behind}");
            own += behind;
            said += 1;
        }
        if own.to_lowercase().replace('\n', " ").contains("is monolithic") {
            faults.push(format!("{} says by hand how its reference is made", page.display()));
        }
        if made != text {
            match std::env::var_os("RIMBENCH_FILL_PAGES") {
                Some(_) => fs::write(&page, made).unwrap(),
                None => faults.push(format!("{}: set RIMBENCH_FILL_PAGES=1", page.display())),
            }
        }
    }
    assert!(said >= 20, "{said} sentences: the check reads nothing");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// What is between markers is made by `rimbench reproduce --everything`; or here, from what is kept, with `RIMBENCH_FILL_PAGES=1`.
#[test]
fn every_number_between_markers_is_that_of_the_data() {
    let mut faults = Vec::new();
    let mut filled = 0;
    let write = std::env::var_os("RIMBENCH_FILL_PAGES").is_some();
    for document in documents() {
        let text = read(&document);
        if without_filled(&text) == text {
            continue;
        }
        filled += 1;
        match fill_page(&document, &text, &root().join("results")) {
            Ok(made) if made == text => {}
            Ok(made) if write => fs::write(&document, made).unwrap(),
            Ok(_) => faults.push(format!("{}: other numbers than the data has", document.display())),
            Err(error) => faults.push(error.to_string()),
        }
    }
    assert!(filled >= 1, "no page has markers");
    assert!(faults.is_empty(), "{}\nRIMBENCH_FILL_PAGES=1 fills them from what is kept", faults.join("\n"));
}

/// Pages that repeat what others have published, between `<!-- cited -->` and `<!-- /cited -->`.
const CITING: [&str; 2] = ["published-crane.md", "published-oscillators.md"];
/// Numbers before these are conditions.
const UNITS_OF_TIME: [&str; 5] = ["ms", "µs", "s", "min", "h"];
/// Numbers before these are too, in a sentence that says that it is about a margin.
const UNITS_OF_A_MARGIN: [&str; 2] = ["mm", "µm"];

/// Text with what is between two others left out, line ends excepted.
fn without(text: &str, open: &str, close: &str) -> String {
    let (mut left, mut rest) = (String::new(), text);
    while let Some((before, behind)) = rest.split_once(open) {
        let (inside, after) = behind.split_once(close).unwrap_or((behind, ""));
        left += before;
        left.extend(inside.chars().filter(|c| *c == '\n'));
        rest = after;
    }
    left + rest
}

/// Numerals of a page that may be results, with their sentences. Conditions may be typed by hand: a number before a unit of time, the
/// numbers of a list that ends so, what follows `=`, a margin; and the number of an item of a list.
fn typed_results(page: &str) -> Vec<String> {
    let shown: Vec<&str> = page.split("\n\n").filter(|block| !block.starts_with('#')).collect();
    let unnumbered = |line: &str| {
        let item = line.trim_start().trim_start_matches(|c: char| c.is_ascii_digit());
        item.strip_prefix(". ").map_or_else(|| line.to_owned(), |item| format!("- {item}")) + "\n"
    };
    let text = prose(&shown.join("\n\n")).map(|(_, line)| unnumbered(line)).collect::<String>();
    let text = [("<!--", "-->"), ("`", "`"), ("![", "]"), ("](", ")")]
        .into_iter()
        .fold(text, |text, (open, close)| without(&text, open, close));
    // A sentence, an item or a cell ends there.
    let text = text.replace(" | ", " .\n").replace(". ", ".\n").replace("\n\n", ".\n").replace("\n- ", ".\n");
    text.split(".\n")
        .filter(|sentence| numerals_of_results(sentence))
        .map(|sentence| sentence.trim().to_owned())
        .collect()
}

/// Whether one of the numerals of a sentence is no condition.
fn numerals_of_results(sentence: &str) -> bool {
    let words: Vec<&str> = sentence.split([' ', '\n', '\u{a0}', '–', '/']).filter(|word| !word.is_empty()).collect();
    let bare = |word: &str| word.trim_matches(|c: char| !c.is_alphanumeric() && c != '%').to_owned();
    let numeral =
        |word: &str| word.trim_start_matches(|c: char| !c.is_alphanumeric()).starts_with(|c: char| c.is_ascii_digit());
    (0..words.len()).any(|at| {
        if !numeral(words[at]) || at > 0 && matches!(words[at - 1], "=" | "≤" | "≥") {
            return false;
        }
        // What stands behind the list of which it is one.
        let behind = words[at + 1..].iter().find(|word| !numeral(word) && !matches!(**word, "to" | "and" | "or"));
        let unit = behind.map(|word| bare(word)).unwrap_or_default();
        let margin = sentence.contains("margin") && UNITS_OF_A_MARGIN.contains(&&*unit);
        !(margin || UNITS_OF_TIME.contains(&&*unit))
    })
}

#[test]
fn no_number_of_a_result_is_typed_by_hand() {
    let mut faults = Vec::new();
    for page in files(&root().join("docs/results"), "md") {
        let name = page.file_name().unwrap().to_string_lossy().into_owned();
        let text = without_filled(&read(&page));
        let cited = without(&text, "<!-- cited -->", "<!-- /cited -->");
        assert!(cited == text || CITING.contains(&&*name), "{name} is no page on data of others");
        faults.extend(typed_results(&cited).into_iter().map(|sentence| format!("{name}: {sentence}")));
    }
    let rule = "a number of a result comes from a marker (docs/development/regenerate.md), or is not said";
    assert!(faults.is_empty(), "{rule}:\n{}", faults.join("\n"));
}

#[test]
fn the_check_must_see_a_number_of_a_result() {
    for condition in [
        "At 5 ms, at 0.5 to 20 ms, at 1, 2 and 5 ms and with H = 5 it is so.\n\n1. With a margin of 1 mm `x 7` locks.",
        "## Part 2\n\nA [first](page-2.md) one: ![of 3](a4.svg).\n\n```sh\nrun 5\n```\n<!-- note 6 -->\n2. M1 is κ₀.",
        "| at 10 ms | μ = 0.3 |\n|---|---|\n| one | two |",
    ] {
        assert_eq!(typed_results(condition), Vec::<String>::new(), "{condition}");
    }
    for (result, sentence) in [
        ("It is fine. The error is\n16.6 N at 5 ms.", "The error is\n16.6 N at 5 ms"),
        ("All is well: 5 mm at a margin.\nBut 1 mm here.", "But 1 mm here"),
        ("| a | 7 % | c |\n|---|---|---|", "7 %"),
        ("1. Of 13 fail at 5 ms", "- Of 13 fail at 5 ms"),
        ("12 of 13 fail at 5 ms", "12 of 13 fail at 5 ms"),
    ] {
        assert!(typed_results(result).iter().any(|found| found == sentence), "{result}: {:?}", typed_results(result));
    }
}
