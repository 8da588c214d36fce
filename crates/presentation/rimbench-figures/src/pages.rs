//! Numbers in pages: what stands between two markers is filled from results, so that no page is older than its data.
//!
//! ```text
//! <!-- value claim=study/x:floor unit=N -->43 N<!-- /value -->            what a claim measured
//! <!-- value id=study/x/completed -->8<!-- /value -->                     a value of the list of tables
//! <!-- table study/x/by-step -->                                          a table of that list
//! …
//! <!-- /table -->
//! ```

use crate::tables::{TableList, Unit, claims_of};
use rimbench_core::error::{Error, Result, shortened};
use std::path::Path;

/// What a marker asks for.
const KINDS: [&str; 2] = ["value", "table"];

/// Fills all markers of a page from the results in a folder.
///
/// # Errors
/// [`Error::File`] with page, line and what is wrong: a marker that is not closed, a key, a value, a claim or a table
/// that is not there; a summary that is missing or damaged.
pub fn fill_page(page: &Path, text: &str, results: &Path, tables: &TableList) -> Result<String> {
    let mut filled = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, kind, behind)) = next_marker(rest) {
        let wrong = |error: String| {
            let line = 1 + text[..text.len() - rest.len() + before.len()].matches('\n').count();
            Error::file(page, format!("line {line}: {error}"))
        };
        let (asked, inside) = behind.split_once("-->").ok_or_else(|| wrong("a marker without its end".to_owned()))?;
        let close = format!("<!-- /{kind} -->");
        let (old, after) =
            inside.split_once(&close).ok_or_else(|| wrong(format!("`{kind}` is not closed by `{close}`")))?;
        if next_marker(old).is_some() {
            return Err(wrong(format!("`{kind}` is not closed by `{close}` before the next marker")));
        }
        let made = match kind {
            "value" => value(asked, results, tables),
            _ => tables.table(asked.trim(), results).map(|table| format!("\n\n{table}\n")),
        };
        filled += &rest[..rest.len() - inside.len()];
        filled += &made.map_err(|error| wrong(error.to_string()))?;
        filled += &close;
        rest = after;
    }
    Ok(filled + rest)
}

/// Fills what stands in braces in a text, as in `{claim=study/x:floor unit=N}`, with what claims in a folder of results
/// measured.
///
/// # Errors
/// [`Error::File`] with the text and what is wrong with it.
pub fn fill_text(text: &str, results: &Path) -> Result<String> {
    let (mut filled, mut rest) = (String::new(), text);
    while let Some((before, behind)) = rest.split_once('{') {
        let wrong = |error: String| Error::file(results, format!("cannot fill `{}`: {error}", shortened(text)));
        let (asked, after) = behind.split_once('}').ok_or_else(|| wrong("`{` is not closed by `}`".to_owned()))?;
        let number = value(asked, results, &TableList::default()).map_err(|error| wrong(error.to_string()))?;
        filled += before;
        filled += &number;
        rest = after;
    }
    Ok(filled + rest)
}

/// Whether a page has markers.
pub fn has_markers(text: &str) -> bool {
    next_marker(text).is_some()
}

/// What stands before the next marker, its kind, and what stands behind that word. In a block of code a marker is an
/// example.
fn next_marker(text: &str) -> Option<(&str, &'static str, &str)> {
    let (mut at, mut code) = (0, false);
    for line in text.split_inclusive('\n') {
        if line.starts_with("```") {
            code = !code;
        }
        let found = KINDS.iter().filter_map(|kind| Some((line.find(&format!("<!-- {kind} "))?, *kind)));
        if let Some((place, kind)) = found.min().filter(|_| !code) {
            let place = at + place;
            return Some((&text[..place], kind, &text[place + "<!-- ".len() + kind.len()..]));
        }
        at += line.len();
    }
    None
}

/// What a claim measured, or a value of the list.
fn value(asked: &str, results: &Path, tables: &TableList) -> Result<String> {
    let (mut claim, mut id, mut unit, mut digits) = (None, None, Unit::default(), 2);
    for word in asked.split_whitespace() {
        let (key, value) = word.split_once('=').ok_or_else(|| Error::invalid("marker", word, "key=value"))?;
        match key {
            "claim" => claim = Some(value),
            "id" => id = Some(value),
            "unit" => unit = Unit::named(value)?,
            "digits" => {
                let number = value.parse().ok().filter(|digits| (1..=8).contains(digits));
                digits = number.ok_or_else(|| Error::invalid("digits", value, "1 to 8"))?;
            }
            _ => return Err(Error::unknown("key", key, ["claim", "id", "unit", "digits"])),
        }
    }
    let number = match (claim, id) {
        (Some(claim), None) => unit.written(measured(claim, results)?, digits),
        (None, Some(id)) => tables.value(id, results, unit, digits)?,
        _ => {
            return Err(Error::invalid(
                "marker",
                asked.trim(),
                "one of `claim=group/name:id` and `id=group/name/value`",
            ));
        }
    };
    Ok(unit.behind(number))
}

/// What a claim `group/name:id` measured.
fn measured(claim: &str, results: &Path) -> Result<f64> {
    let (experiment, id) = claim.rsplit_once(':').ok_or_else(|| Error::invalid("claim", claim, "`group/name:id`"))?;
    let (claims, rows) = claims_of(results, experiment)?;
    let ids = claims.column("id")?;
    let row = rows.iter().copied().find(|&row| claims.text(row, ids) == id);
    let known = rows.iter().map(|&row| claims.text(row, ids));
    let row = row.ok_or_else(|| Error::unknown("claim", id, known))?;
    Ok(claims.number(row, claims.column("measured")?))
}
