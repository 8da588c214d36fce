//! The report: a Markdown source with places to fill, made into one HTML file that needs no other.

use super::claims_table::claims_markdown;
use super::figures::FigureList;
use super::live_part;
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;
use rimbench_results::results_table::ResultsTable;
use std::fmt::Write;
use std::path::Path;

const STYLE: &str = "body{max-width:76rem;margin:2rem auto;padding:0 1rem;font:16px/1.55 Inter,Helvetica,Arial,sans-serif}\
table{border-collapse:collapse;font-size:14px;margin:1rem 0}td,th{border-bottom:1px solid;\
padding:.35rem .6rem;text-align:left;vertical-align:top}figure{margin:2rem 0}figure svg{width:100%;height:auto}\
figcaption{font-size:14px}code{font-size:90%}";

/// Fills the Markdown source, given as name and text, and writes `claims.md` and `report.html` below `results/<group>`.
///
/// ```text
/// {{claims}}        the table of claims
/// {{try}}           the part that simulates in the browser
/// {{figure:ID}}     the figure with its caption and the names of its files
/// {{reference}}     uncertainty and order of the reference
/// {{parameters}}    the parameters of the case
/// ```
/// # Errors
/// [`Error::File`] for a figure or table that is not there, or a place with no such name.
pub fn write_report(source: (&Path, &str), results: &Path, group: &str, figures: &FigureList) -> Result<()> {
    let (source, text) = source;
    let folder = results.join(group);
    let claims = claims_markdown(&folder.join("claims.csv"))?;
    write(&folder.join("claims.md"), &claims)?;
    let mut filled = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("{{") {
        let (place, tail) =
            after.split_once("}}").ok_or_else(|| Error::file(source, "has a place `{{` without an end `}}`"))?;
        filled.push_str(before);
        match place.split_once(':') {
            None if place == "claims" => filled.push_str(&claims),
            None if place == "try" => filled.push_str(live_part::SECTION),
            None if place == "reference" => filled.push_str(&reference_table(&folder)?),
            None if place == "parameters" => filled.push_str(&parameter_table(&folder)?),
            Some(("figure", id)) => filled.push_str(&figure(results, figures, id)?),
            _ => return Err(Error::file(source, format!("has an unknown place `{place}`"))),
        }
        rest = tail;
    }
    filled.push_str(rest);
    let mut html = String::new();
    let options = pulldown_cmark::Options::ENABLE_TABLES;
    pulldown_cmark::html::push_html(&mut html, pulldown_cmark::Parser::new_ext(&filled, options));
    // A wide table scrolls by itself on a narrow screen.
    let html = html.replace("<table>", "<div class=\"table\"><table>").replace("</table>", "</table></div>");
    let scripts = if text.contains("{{try}}") { live_part::scripts() } else { String::new() };
    let page = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <title>rimbench: reproduction</title>\
         <style>{STYLE}{}</style></head>\n<body>\n<main>\n{html}</main>\n{scripts}</body></html>\n",
        live_part::STYLE
    );
    write(&folder.join("report.html"), &page)
}

/// A figure as HTML, with its SVG inside.
fn figure(results: &Path, figures: &FigureList, id: &str) -> Result<String> {
    let ids = || figures.figures.iter().map(|figure| figure.id.as_str());
    let entry =
        figures.figures.iter().find(|figure| figure.id == id).ok_or_else(|| Error::unknown("figure", id, ids()))?;
    let path = results.join(&entry.experiment).join("figures").join(format!("{id}.svg"));
    let svg = std::fs::read_to_string(&path).map_err(|error| Error::file(&path, format!("cannot be read: {error}")))?;
    let svg: String = svg.lines().filter(|line| !line.starts_with("<?xml") && !line.trim().is_empty()).collect();
    Ok(format!(
        "<figure id=\"{id}\">{svg}<figcaption>{} <em>Source: results/{}/{}; experiments/{}.toml.</em></figcaption></figure>",
        entry.caption, entry.experiment, entry.source, entry.experiment
    ))
}

fn reference_table(folder: &Path) -> Result<String> {
    let table = ResultsTable::read(&folder.join("fig2/reference.csv"))?;
    let names = ["column", "rms_uncertainty", "observed_order", "finest_step_s"];
    let columns: Vec<usize> = names.iter().map(|name| table.column(name)).collect::<Result<_>>()?;
    let mut text = String::from("| quantity | rms uncertainty | observed order |\n|---|---|---|\n");
    for row in 0..table.len() {
        let (uncertainty, order) = (table.number(row, columns[1]), table.number(row, columns[2]));
        if table.text(row, columns[0]).starts_with("actuator_") {
            let _ = writeln!(text, "| `{}` | {uncertainty:.2e} | {order:.2} |", table.text(row, columns[0]));
        }
    }
    Ok(text)
}

fn parameter_table(folder: &Path) -> Result<String> {
    let table = ResultsTable::read(&folder.join("fig2/parameters.csv"))?;
    let columns: Vec<usize> =
        ["parameter", "value", "unit", "source"].iter().map(|name| table.column(name)).collect::<Result<_>>()?;
    let mut text = String::from("| parameter | value | unit | source |\n|---|---|---|---|\n");
    for row in 0..table.len() {
        let cells: Vec<&str> = columns.iter().map(|&column| table.text(row, column)).collect();
        let _ = writeln!(text, "| `{}` | {} | {} | {} |", cells[0], cells[1], cells[2], cells[3]);
    }
    Ok(text)
}

fn write(path: &Path, text: &str) -> Result<()> {
    write_atomically(path, |file| file.write_all(text.as_bytes()))
}
