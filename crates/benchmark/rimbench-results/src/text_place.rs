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
    let message = message.trim_end().replace('\n', "; ");
    let Some(place) = place.filter(|place| text.is_char_boundary(place.start)) else { return shortened_line(&message) };
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

/// Cuts a message that may repeat the text it is about.
fn shortened_line(message: &str) -> String {
    match message.char_indices().nth(6 * REPEATED) {
        Some((end, _)) => format!("{}…", &message[..end]),
        None => message.to_owned(),
    }
}
