//! The documents: links lead somewhere, everything that runs by name has its page, programs compile, and numbers that
//! they repeat are those of the committed files.

use crate::support::{cases, schemes};
use rimbench::cases::ReferenceMethod;
use rimbench::catalogue::Catalogue;
use rimbench::claims::{CheckedClaim, Claimant, Verdict, claims_score, read_claims};
use rimbench::figures::{TableList, claims_markdown, fill_page};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The project's folder.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The text of a file.
pub fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// All files with an extension below a folder.
pub fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let path = entry.path();
        // A link may lead back: `examples/examples` does.
        if entry.file_type().unwrap().is_dir() {
            found.extend(files(&path, extension));
        } else if path.extension().is_some_and(|own| own == extension) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Pages of the book, and the documents beside it.
fn documents() -> Vec<PathBuf> {
    let mut documents = files(&root().join("docs"), "md");
    documents.extend(["README.md", "METHODOLOGY.md", "CONTRIBUTING.md"].map(|name| root().join(name)));
    documents
}

/// The lines of a text with their numbers, without blocks of code.
fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut code = false;
    text.lines().enumerate().filter_map(move |(index, line)| {
        let fence = line.trim_start().starts_with("```");
        code ^= fence;
        (!fence && !code).then_some((index + 1, line))
    })
}

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
    // The page that simulates begins with the case of its address.
    if let Some(case) = anchor.strip_prefix("case=") {
        return (!cases().iter().any(|known| known.name == case)).then(|| format!("no case is `{case}`"));
    }
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
    assert_eq!(fault(&readme, "results/paper/report.html#case=wedge-box"), None);
    assert_eq!(fault(&readme, "results/paper/report.html#case=wedge").unwrap(), "no case is `wedge`");
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

/// The page of a case or a scheme, below its folder of the book: that of its family, to which the list of the folder
/// leads, or its own; none of one that no experiment has judged yet.
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

/// Blocks of Rust in a text: number of the line before, whether it is quoted (`rust,ignore`), lines without their
/// indentation.
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
    let (paper, all) = (count(&[Claimant::Paper]), count(&[Claimant::Paper, Claimant::PaperOurBound, Claimant::Ours]));
    let readme = without_markers(&read(&root().join("README.md")));
    for sentence in [
        format!("**{} of {} sentences of the paper reproduce**", paper.0, paper.1),
        format!("{} of all {} statements judged do, ours included", all.0, all.1),
    ] {
        assert!(readme.contains(&sentence), "README.md does not say: {sentence}");
    }
    assert!(readme.contains("](results/paper/claims.md)"), "README.md does not link to the table of claims");
    assert_eq!(claims_markdown(&claims), read(&root().join("results/paper/claims.md")));
    let replaced = claims.iter().filter(|claim| !claim.superseded.is_empty()).count();
    let page = read(&root().join("results/paper/report.html"));
    let sentence = format!("<strong>{}</strong>", claims_score(claims.iter()));
    assert!(
        sentence.contains(&format!("{} of {} sentences of the paper and {} of all {}", paper.0, paper.1, all.0, all.1))
    );
    assert!(page.contains(&sentence) && page.contains(&format!("{replaced} more are superseded")), "{sentence}");
}

/// A page as a reader sees it.
fn without_markers(page: &str) -> String {
    let shown = |part: &str| part.split_once("-->").map_or(part.to_owned(), |(_, shown)| shown.to_owned());
    page.split("<!--").map(shown).collect()
}

/// How a reference is made is said by the case itself: the code fills in what a page says, with
/// `RIMBENCH_FILL_PAGES=1`.
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

/// Tables and numbers between markers are made by `rimbench reproduce --everything`; or here, from what is kept, with
/// `RIMBENCH_FILL_PAGES=1`.
#[test]
fn every_number_between_markers_is_that_of_the_data() {
    let (list, results) = (TableList::read(&root().join("paper/tables.toml")).unwrap(), root().join("results"));
    let write = std::env::var_os("RIMBENCH_FILL_PAGES").is_some();
    let (mut faults, mut pages) = (Vec::new(), String::new());
    for document in documents() {
        let text = read(&document);
        match fill_page(&document, &text, &results, &list) {
            Ok(made) if made == text => {}
            Ok(made) if write => fs::write(&document, made).unwrap(),
            Ok(_) => faults.push(format!("{}: other numbers than the data has", document.display())),
            Err(error) => faults.push(error.to_string()),
        }
        pages += &text;
    }
    let unused = list.tables().filter(|id| !pages.contains(&format!("<!-- table {id} -->")));
    faults.extend(unused.map(|id| format!("table {id}: on no page")));
    let unused = list.values().filter(|id| !pages.contains(&format!("id={id} ")));
    faults.extend(unused.map(|id| format!("value {id}: on no page")));
    assert!(list.values().count() > 30 && list.tables().count() > 10, "the check reads nothing");
    assert!(faults.is_empty(), "{}\nRIMBENCH_FILL_PAGES=1 makes them from what is kept", faults.join("\n"));
}

#[test]
fn every_item_that_the_page_on_the_paper_names_must_exist() {
    let folder = root().join("docs/method");
    let page = read(&folder.join("from-the-paper-to-the-code.md"));
    let links = page.split("[`").skip(1).map(|rest| {
        let (item, rest) = rest.split_once("`](").expect("an item and its file");
        (item, rest.split_once(')').expect("a file").0)
    });
    let mut seen = 0;
    for (item, file) in links {
        let text = read(&folder.join(file));
        let declares = |line: &str| {
            let line = line.split("//").next().unwrap_or_default().trim_start();
            let kinds = ["fn ", "struct ", "enum ", "trait "];
            let named =
                |rest: &str| rest.strip_prefix(item).is_some_and(|rest| !rest.starts_with(char::is_alphanumeric));
            let variant = [format!("{item},"), format!("{item}(")].iter().any(|start| line.starts_with(start.as_str()));
            variant
                || line.strip_prefix("pub ").is_some_and(|field| field.starts_with(&format!("{item}:")))
                || kinds.iter().any(|kind| line.split_once(kind).is_some_and(|(_, rest)| named(rest)))
        };
        assert!(text.lines().any(declares), "{file} has no `{item}`");
        seen += 1;
    }
    assert!(seen > 30, "only {seen} items found");
}
