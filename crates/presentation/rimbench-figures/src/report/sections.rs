//! Head, text, studies, and what is missing.

use super::store::{Made, Study};
use super::{DATE_LINE, Report, claims, folded, grid};
use crate::days::day_of;
use crate::live_part;
use crate::vector::escaped;
use rimbench_core::error::{Error, Result};
use rimbench_core::numerics_version::NUMERICS_VERSION;
use rimbench_results::results_table::{ResultsTable, read_table};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;
use std::time::UNIX_EPOCH;

impl Report<'_> {
    /// Everything from the beginning of the body to the end of the last section but one.
    pub(super) fn body(&self, packed: bool) -> Result<String> {
        let (lead, text) = match self.text {
            Some((source, text)) => {
                let at = text.find("\n## ").map_or(text.len(), |at| at + 1);
                (self.filled(source, &text[..at])?, self.filled(source, &text[at..])?)
            }
            None => Default::default(),
        };
        let shown = self.in_text();
        let claims = claims::section(self);
        let grid = grid::section(&self.studies);
        let studies = self.studies_section(&shown, packed);
        // What simulates is an example; on a page that is not about the example, what was found comes first.
        let is_paper = !text.is_empty();
        let (live, found) = (("try", "Simulator", true), ("claims", "Claims", !claims.is_empty()));
        let skip = if claims.is_empty() { ("main", "what was found") } else { ("claims", "the claims") };
        let question = match &self.studies[..] {
            [study] if !is_paper && !study.question.is_empty() => format!("<p>{}</p>\n", escaped(&study.question)),
            _ => String::new(),
        };
        let parts = [
            if is_paper { live } else { ("studies", "Studies", true) },
            ("paper", "The paper, remade", !text.is_empty()),
            found,
            ("grid", "Largest accurate step", !grid.is_empty()),
            if is_paper { ("studies", "Studies", true) } else { live },
            ("runs", "Runs", true),
            ("missing", "What is missing", true),
        ];
        // Of much, only what is far down.
        let is_far = |anchor: &str| ["claims", "studies", "runs", "missing"].contains(&anchor);
        let contents = parts.iter().filter(|(anchor, _, there)| *there && (!self.is_long() || is_far(anchor)));
        let contents: String =
            contents.map(|(anchor, title, _)| format!("<li><a href=\"#{anchor}\">{title}</a></li>")).collect();
        let is_long = self.is_long();
        let paper = match text.as_str() {
            "" => String::new(),
            _ => format!("<section id=\"paper\">\n{}</section>\n", folded(is_long, "The paper, remade", &text)),
        };
        let runs = if is_long {
            live_part::RUNS.replace("id=\"runs-fold\" open", "id=\"runs-fold\"")
        } else {
            live_part::RUNS.to_owned()
        };
        let skip = format!("<a class=\"skip\" href=\"#{}\">Skip to {}</a>\n", skip.0, skip.1);
        let (title, live, made) = (self.title(), live_part::SECTION, self.made());
        let about = format!(
            "{lead}{question}{}{made}<nav aria-label=\"Contents\"><ul>{contents}</ul></nav>\n",
            claims::marks(self)
        );
        let beginning = match is_paper {
            // The first screen is the question, the simulator and the score.
            true => {
                let (score, around) = (claims::short_score(self), around(&title));
                let link = if score.is_empty() { score } else { format!("<a href=\"#claims\">{score}</a>") };
                format!(
                    "<header class=\"brand\"><h1>rimbench: {title}</h1>{around} {link}</header>\n<main id=\"main\">\n{live}\n<div>\n{about}</div>\n"
                )
            }
            false => {
                format!("<header>\n<h1>rimbench: {title}</h1>\n{about}</header>\n<main id=\"main\">\n")
            }
        };
        // Figures first, each with its claims folded under it; the table of all claims is behind them.
        let found =
            if is_paper { format!("{paper}{claims}{grid}{studies}") } else { format!("{studies}{claims}{grid}{live}") };
        Ok(format!("{skip}{beginning}{found}{runs}"))
    }

    /// Whether there is so much that a reader first sees what there is: parts are folded.
    pub(super) fn is_long(&self) -> bool {
        self.studies.len() > 8
    }

    /// Figures that the text shows.
    pub(super) fn in_text(&self) -> BTreeSet<&str> {
        self.text.map(|(_, text)| places(text)).unwrap_or_default()
    }

    /// Where the numbers come from, in one line of the page.
    fn made(&self) -> String {
        let all =
            |column: &str| self.studies.iter().flat_map(|study| study.provenance(column)).collect::<BTreeSet<_>>();
        let dirty = if all("git_dirty").contains("true") { " and changes to it" } else { "" };
        let named = |title: &str, values: BTreeSet<String>| match values.len() {
            0 => String::new(),
            1..=3 => format!("{title} {}", escaped(&values.into_iter().collect::<Vec<_>>().join(", "))),
            count => format!("{count} different values of {title}"),
        };
        let newest = self
            .studies
            .iter()
            .filter_map(|study| study.folder.join("runs.csv").metadata().ok()?.modified().ok())
            .max();
        let date = newest.map_or_else(
            || "rows not kept".to_owned(),
            |time| format!("of {}", day_of(time.duration_since(UNIX_EPOCH).map_or(0, |elapsed| elapsed.as_secs()))),
        );
        let count: usize = self.studies.iter().map(Study::count).sum();
        let runs = if count == 1 { "1 run".to_owned() } else { format!("{count} runs") };
        let studies =
            if self.studies.len() == 1 { "1 study".to_owned() } else { format!("{} studies", self.studies.len()) };
        format!(
            "{DATE_LINE}{runs} in {studies}, {date}{}. Page written by {}, numerics version {NUMERICS_VERSION}.</p>\n",
            [("commit", "git_revision", dirty), ("compiler", "rustc", ""), ("machine", "cpu", "")]
                .map(|(title, column, more)| (named(title, all(column)), more))
                .into_iter()
                .filter(|(said, _)| !said.is_empty())
                .map(|(said, more)| format!("; {said}{more}"))
                .collect::<String>(),
            escaped(&self.program),
        )
    }

    /// The text with its places filled, as HTML.
    ///
    /// ```text
    /// {{figure:ID}}     the figure with its caption, in a paragraph of its own
    /// {{reference}}     uncertainty and order of the reference
    /// {{parameters}}    the parameters of the case
    /// ```
    fn filled(&self, source: &Path, text: &str) -> Result<String> {
        let (mut html, mut filled) = (String::new(), String::new());
        let mut rest = text;
        while let Some((before, after)) = rest.split_once("{{") {
            let (place, tail) =
                after.split_once("}}").ok_or_else(|| Error::file(source, "has a place `{{` without an end `}}`"))?;
            filled.push_str(before);
            match place.split_once(':') {
                None if place == "reference" => {
                    filled.push_str(&self.table("paper/fig2", "reference.csv", reference_table))
                }
                None if place == "parameters" => {
                    // A long list is folded; its HTML stands between two pieces of the text.
                    push_markdown(&mut html, &filled);
                    filled.clear();
                    let mut table = String::new();
                    push_markdown(&mut table, &self.table("paper/fig2", "parameters.csv", parameter_table));
                    html.push_str(&folded(table.contains("<table>"), "All parameters of the wedge box", &table));
                }
                // Markup of the text is never passed on, so that a figure stands between two pieces of it.
                Some(("figure", id)) => match self.figure_of_text(source, id)? {
                    Ok(figure) => {
                        push_markdown(&mut html, &filled);
                        filled.clear();
                        html.push_str(&figure);
                    }
                    Err(reason) => filled.push_str(&not_shown(&reason)),
                },
                _ => return Err(Error::file(source, format!("has an unknown place `{place}`"))),
            }
            rest = tail;
        }
        filled.push_str(rest);
        push_markdown(&mut html, &filled);
        // A wide table scrolls by itself on a narrow screen, and a keyboard reaches it.
        let mut parts = html.split("<table>");
        let mut scrolled = parts.next().unwrap_or_default().to_owned();
        for (index, part) in parts.enumerate() {
            let name = format!("Table {}", index + 1);
            let _ = write!(
                scrolled,
                "<div class=\"table\" tabindex=\"0\" role=\"region\" aria-label=\"{name}\"><table>{part}"
            );
        }
        Ok(scrolled.replace("</table>", "</table></div>"))
    }

    /// A figure, or why there is none of results that are not here.
    fn figure_of_text(&self, source: &Path, id: &str) -> Result<std::result::Result<String, String>> {
        let mut all = self.studies.iter().flat_map(|study| study.figures.iter().map(move |made| (study, made)));
        if let Some((study, made)) = all.find(|(_, (known, _, _))| known == id) {
            let first = study.figures.first().is_some_and(|(first, ..)| first == id);
            let claims = if first { claims::under(study) } else { String::new() };
            return Ok(Ok(figure(study, made, false) + &claims));
        }
        match self.listed.iter().find(|(known, _)| known == id) {
            Some((_, experiment)) => Ok(Err(format!("no results of {experiment}"))),
            None => {
                let known = self.listed.iter().map(|(id, _)| id.as_str());
                Err(Error::file(source, Error::unknown("figure", id, known)))
            }
        }
    }

    fn table(&self, study: &str, file: &str, make: fn(&ResultsTable) -> Result<String>) -> String {
        let Some(known) = self.studies.iter().find(|known| known.name == study && known.is_shipped) else {
            return not_shown(&format!("no results of {study}"));
        };
        if !known.folder.join(file).exists() {
            return format!("`rimbench run {}` makes this table.\n", known.file());
        }
        let made = read_table(&known.folder.join(file)).and_then(|table| make(&table));
        made.unwrap_or_else(|error| not_shown(&known.said(&error)))
    }

    /// Study by study, without figures that the text has shown.
    fn studies_section(&self, shown: &BTreeSet<&str>, packed: bool) -> String {
        let mut text = String::from(
            "<section id=\"studies\"><h2>Studies</h2>\n<p class=\"scripted\" hidden><label>Highlight in all figures \
             <select id=\"highlight\"><option value=\"\">nothing</option></select></label></p>\n",
        );
        for study in &self.studies {
            let count = study.count();
            let outcomes: Vec<String> =
                study.outcomes().into_iter().map(|(outcome, count)| format!("{count} {outcome}")).collect();
            let planned = match study.planned {
                Some(planned) if planned > count => format!(" of {planned} planned"),
                _ => String::new(),
            };
            let (anchor, name, question) =
                (study.anchor(), escaped(&study.name.replace('_', " ")), escaped(&study.question));
            let head = match self.is_long() {
                true => format!(
                    "<details class=\"fold study\" id=\"{anchor}\"><summary>{name} <span>{question}</span></summary>"
                ),
                false => format!("<section id=\"{anchor}\" class=\"study\"><h3>{name}</h3>\n<p>{question}</p>"),
            };
            let _ = write!(
                text,
                "{head}\n<p class=\"soft\">{count} runs{planned}: {}. {}</p>\n",
                match (&study.kept, &outcomes[..]) {
                    (Some(_), _) => "rows are not kept, and this command makes them".to_owned(),
                    (None, []) => "none".to_owned(),
                    (None, outcomes) => outcomes.join(", "),
                },
                study.command("run"),
            );
            for remark in &study.remarks {
                let _ = writeln!(text, "<p class=\"note\">{}</p>", escaped(remark));
            }
            let is_above = |(id, ..): &&Made| shown.contains(id.as_str());
            for made in study.figures.iter().filter(|made| !is_above(made)) {
                text.push_str(&figure(study, made, packed));
            }
            let above: Vec<String> =
                study.figures.iter().filter(is_above).map(|(id, ..)| claims::link_to(id)).collect();
            if !above.is_empty() {
                let _ = writeln!(text, "<p class=\"soft\">See {}.</p>", above.join(", "));
            }
            if !study.figures.first().as_ref().is_some_and(is_above) {
                text.push_str(&claims::under(study));
            }
            if let Some((_, summary)) = &study.kept {
                let _ = writeln!(
                    text,
                    "<details class=\"kept\" data-study=\"{anchor}\"><summary>Summary: {} rows of medians</summary><noscript>See {name}/summary.csv.</noscript></details>",
                    summary.len()
                );
            }
            text.push_str(if self.is_long() { "</details>\n" } else { "</section>\n" });
        }
        text + "</section>\n"
    }
}

/// What is around a page with the paper in it, as a checkout has it; `.ci/site` puts in what a site has. Below other
/// folders it is unknown.
fn around(title: &str) -> String {
    let (up, pdf) = match title {
        "paper" => ("../..", "paper.pdf"),
        "results" => ("..", "paper/paper.pdf"),
        _ => return String::new(),
    };
    format!(
        "<nav aria-label=\"Around this page\"><a href=\"{up}/docs/README.md\">Book</a> <a href=\"{pdf}\">Report (PDF)</a> \
         <a href=\"{up}/README.md\">Source</a> <a href=\"{METHOD}\">The method’s paper</a></nav>"
    )
}

/// The article on the method; of the contribution that is reproduced no address is known.
const METHOD: &str =
    "https://asmedigitalcollection.asme.org/computationalnonlinear/article-abstract/19/7/071006/1197206";

/// Figures that a text shows.
fn places(text: &str) -> BTreeSet<&str> {
    text.split("{{figure:").skip(1).filter_map(|rest| rest.split_once("}}")).map(|(id, _)| id).collect()
}

/// A figure as HTML, with its SVG inside or a place for it, or why there is none.
fn figure(study: &Study, (id, caption, made): &Made, packed: bool) -> String {
    let picture = match made {
        Ok(picture) => picture,
        Err(reason) => {
            let name = escaped(&id.replace('_', " "));
            return format!("<p class=\"note\">Figure {name} is not drawn: {}.</p>\n\n", escaped(reason));
        }
    };
    let (name, caption) = (escaped(&study.name), escaped(caption));
    let (class, inside) = match packed {
        true => ("plot packed", format!("<noscript>Without scripts see {name}/figures/{id}.svg.</noscript>")),
        // A blank or broken line would end the block of HTML in a text.
        false => ("plot", picture.svg().replace('\n', "")),
    };
    let live = study.addresses.get(id).map_or(String::new(), |address| {
        format!(" · <a class=\"live\" href=\"#{}\" hidden>Open these runs in the simulator</a>", escaped(address))
    });
    let source = if study.is_shipped { format!("experiments/{name}.toml") } else { name.clone() };
    format!(
        "<figure id=\"figure-{id}\" class=\"{class}\"><div class=\"canvas\" tabindex=\"0\">{inside}</div><figcaption>{caption} \
         <em>From the results of {source}.</em> <a href=\"#figure-{id}\">Link to this figure</a>{live}</figcaption></figure>\n\n"
    )
}

/// What is missing, whatever the reason.
pub(super) fn missing(report: &Report<'_>, left_out: &[String]) -> String {
    let mut items: Vec<String> = left_out.iter().map(|remark| escaped(remark)).collect();
    for study in &report.studies {
        let own = study.missing();
        items
            .extend(own.iter().map(|item| {
                format!("<a href=\"#{}\">{}</a>: {}", study.anchor(), escaped(&study.name), escaped(item))
            }));
    }
    let without = |test: fn(&Study) -> bool, what: &str| {
        let names: Vec<String> =
            report.studies.iter().filter(|study| test(study)).map(|study| escaped(&study.name)).collect();
        (!names.is_empty()).then(|| format!("{what}: {}", names.join(", ")))
    };
    items.extend(without(
        |study| !study.folder.join("traces").is_dir() && study.runs.is_some(),
        "No traces are stored of",
    ));
    items.extend(without(|study| study.figures.is_empty() && study.runs.is_some(), "No figure is listed for"));
    let no_claim = |study: &Study| study.claims.is_empty() && study.unchecked.is_none() && study.runs.is_some();
    items.extend(without(no_claim, "No claim is recorded for"));
    let list: String = items.into_iter().map(|item| format!("<li>{item}</li>\n")).collect();
    let list = if list.is_empty() { "<p>Nothing.</p>\n".to_owned() } else { format!("<ul>\n{list}</ul>\n") };
    format!("<section id=\"missing\"><h2>What is missing</h2>\n{list}</section>\n")
}

/// Appends Markdown as HTML. Whatever stands in it as HTML is left out: no cell of a file becomes markup.
fn push_markdown(html: &mut String, text: &str) {
    use pulldown_cmark::{Event, Options, Parser};
    let events = Parser::new_ext(text, Options::ENABLE_TABLES);
    pulldown_cmark::html::push_html(
        html,
        events.filter(|event| !matches!(event, Event::Html(_) | Event::InlineHtml(_))),
    );
}

/// Text of a file as Markdown that shows it as it is, in one line.
fn marked(text: &str) -> String {
    let mut marked = String::new();
    for letter in text.chars() {
        match letter {
            '\r' | '\n' => marked.push(' '),
            letter if letter.is_ascii_punctuation() => marked.extend(['\\', letter]),
            letter => marked.push(letter),
        }
    }
    marked
}

fn not_shown(reason: &str) -> String {
    format!("*Not shown: {}.*\n", marked(reason))
}

fn reference_table(table: &ResultsTable) -> Result<String> {
    let names = ["column", "rms_uncertainty", "observed_order"];
    let columns: Vec<usize> = names.iter().map(|name| table.column(name)).collect::<Result<_>>()?;
    let mut text = String::from("| quantity | rms uncertainty | observed order |\n|---|---|---|\n");
    for row in 0..table.len() {
        let (uncertainty, order) = (table.number(row, columns[1]), table.number(row, columns[2]));
        let name = table.text(row, columns[0]);
        if let (true, Some((words, unit))) = (name.starts_with("actuator_"), claims::column_in_words(name)) {
            let words = marked(&words);
            let _ = writeln!(text, "| {words} | {uncertainty:.2e} {unit} | {order:.2} |");
        }
    }
    Ok(text)
}

fn parameter_table(table: &ResultsTable) -> Result<String> {
    let columns: Vec<usize> =
        ["parameter", "value", "unit", "source"].iter().map(|name| table.column(name)).collect::<Result<_>>()?;
    let mut text = String::from("| parameter | value | unit | source |\n|---|---|---|---|\n");
    for row in 0..table.len() {
        let cells: Vec<&str> = columns.iter().map(|&column| table.text(row, column)).collect();
        let [value, unit, source] = [cells[1], cells[2], cells[3]].map(marked);
        // Of code only these two end it; no parameter's name has them.
        let name = cells[0].replace(['`', '|', '\r', '\n'], "?");
        let _ = writeln!(text, "| `{name}` | {value} | {unit} | {source} |");
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_in_a_file_never_becomes_markup() {
        for hostile in [
            "<script>alert(1)</script>",
            "<img src=x onerror=alert(1)>",
            "[x](javascript:alert(1))",
            "a | b\n\n<b>c",
            "`<i>`",
            "&lt;",
        ] {
            let table = format!("| a | b |\n|---|---|\n| {} | end |\n", marked(hostile));
            for text in [table, not_shown(hostile)] {
                let mut html = String::new();
                push_markdown(&mut html, &text);
                for markup in ["<script", "<img", "<a ", "<b>", "<i>"] {
                    assert!(!html.contains(markup), "{html}");
                }
                // Shown as it is, not dropped.
                let said = escaped(&hostile.replace('\n', " "));
                assert!(
                    html.contains(&said) || html.contains(&said.replace("&quot;", "\"")),
                    "{said} is not in {html}"
                );
                assert!(!html.contains("<table>") || html.contains("<td>end</td>"), "{html}");
            }
            let mut html = String::new();
            push_markdown(&mut html, &format!("before {hostile} after\n\n{hostile}\n"));
            assert!(!html.contains("<script") && !html.contains("<img"), "{html}");
        }
    }
}
