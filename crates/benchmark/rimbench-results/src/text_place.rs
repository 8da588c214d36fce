//! Where in a text of TOML something is wrong: line, column and what is written there.

use rimbench_core::error::shortened;
use std::ops::Range;

/// Characters of a line that a message repeats.
const REPEATED: usize = 80;

/// Returns the line of a byte of a text, from 1.
pub fn line_of(text: &str, place: usize) -> usize {
    1 + text.bytes().take(place).filter(|byte| *byte == b'\n').count()
}

/// Formats what is wrong at a place of a text: line, column, the beginning of the text there, and the message.
pub fn said_at(text: &str, place: Option<Range<usize>>, message: &str) -> String {
    let message = in_words_of_toml(&message.trim_end().replace('\n', "; "));
    // What the whole text has not stands nowhere in it.
    let nowhere = |place: &Range<usize>| place.start == 0 && message.starts_with("missing field");
    let place = place.filter(|place| text.is_char_boundary(place.start) && !nowhere(place));
    let Some(place) = place else { return shortened_line(&message) };
    let before = &text[..place.start];
    let column = 1 + before.rsplit('\n').next().unwrap_or_default().chars().count();
    // The whole line where it is short, else what follows the place.
    let start = before.rfind('\n').map_or(0, |end| end + 1);
    let line = text[start..].lines().next().unwrap_or_default();
    let here =
        if line.chars().count() <= REPEATED { line } else { text[place.start..].lines().next().unwrap_or_default() };
    // As in a path of Windows.
    let escaped = line.contains('"') && line.contains('\\') && message.contains("escape");
    let hint = if escaped {
        "; in double quotes a backslash begins an escape: write a path with `/`, or in single quotes"
    } else {
        ""
    };
    let message = shortened_line(&message) + hint;
    format!("line {}, column {column}: `{}`: {message}", line_of(text, place.start), shortened(here.trim()))
}

/// What a message calls by its type in this program, as TOML calls it.
fn in_words_of_toml(message: &str) -> String {
    const WORDS: [(&str, &str); 12] = [
        ("expected f64", "expected a number"),
        ("expected usize", "expected a whole number from 0"),
        ("expected u64", "expected a whole number from 0"),
        ("expected u32", "expected a whole number from 0"),
        ("expected u16", "expected a whole number from 0"),
        ("expected i64", "expected a whole number"),
        ("expected a sequence", "expected a list"),
        ("expected a map", "expected a table"),
        ("type: sequence", "type: list"),
        ("type: map", "type: table"),
        ("type: floating point", "type: number"),
        (" as i128, expected any valid TOML value", ", expected one of at most 9223372036854775807"),
    ];
    let said = WORDS.iter().fold(message.to_owned(), |said, (from, to)| said.replace(from, to));
    let Some((before, rest)) = said.split_once("expected struct ") else { return said };
    let after = rest.find(|c: char| !c.is_alphanumeric()).map_or("", |end| &rest[end..]);
    format!("{before}expected a table{after}")
}

/// Cuts a message that may repeat the text it is about.
fn shortened_line(message: &str) -> String {
    match message.char_indices().nth(6 * REPEATED) {
        Some((end, _)) => format!("{}…", &message[..end]),
        None => message.to_owned(),
    }
}
