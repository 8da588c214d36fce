//! The end of what a process has printed, kept so that it can be quoted when the process fails.

use std::io::{BufRead, BufReader, Read};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// How much of it is repeated, characters.
const LONGEST: usize = 300;

/// How long the thread that reads may be behind.
const BEHIND: Duration = Duration::from_millis(20);

/// What a process has printed last.
pub(crate) struct LastWords(Arc<Mutex<String>>);

impl LastWords {
    /// Reads what a process prints until that ends.
    pub(crate) fn of(printed: impl Read + Send + 'static) -> Self {
        let kept = Arc::new(Mutex::new(String::new()));
        let words = LastWords(Arc::clone(&kept));
        std::thread::spawn(move || keep_last(BufReader::new(printed), &kept));
        words
    }

    /// Repeats it, behind a semicolon, if there is anything; the process is to have ended.
    pub(crate) fn quoted(&self) -> String {
        std::thread::sleep(BEHIND);
        let printed = self.0.lock().map(|printed| printed.trim().to_owned()).unwrap_or_default();
        if printed.is_empty() { String::new() } else { format!("; it printed: {printed}") }
    }
}

fn keep_last(from: impl BufRead, kept: &Mutex<String>) {
    for line in from.split(b'\n').map_while(std::result::Result::ok) {
        let Ok(mut kept) = kept.lock() else { return };
        let line = String::from_utf8_lossy(&line);
        kept.extend(line.chars().map(|c| if c.is_control() { ' ' } else { c }).chain([' ']));
        let beyond = kept.chars().count().saturating_sub(LONGEST);
        if beyond > 0 {
            *kept = kept.chars().skip(beyond).collect();
        }
    }
}
