//! The end of what a process has printed, kept for the person who wants to know why the process failed.

#![cfg_attr(not(unix), allow(dead_code, reason = "processes of their own need a Unix"))]

use std::collections::BTreeSet;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{ErrorKind, Read, Write};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How much of it is kept, bytes.
const KEPT: usize = 1 << 12;
/// Bytes read at once: a process that prints without an end must not fill our memory.
const CHUNK: usize = 1 << 12;

/// How long the thread that reads may be behind.
const BEHIND: Duration = Duration::from_millis(20);

/// What a process has printed last.
pub(crate) struct LastWords(Arc<Mutex<Vec<u8>>>);

impl LastWords {
    /// Reads what a process prints until that ends.
    pub(crate) fn of(printed: impl Read + Send + 'static) -> Self {
        let kept = Arc::new(Mutex::new(Vec::new()));
        let words = LastWords(Arc::clone(&kept));
        std::thread::spawn(move || keep_last(printed, &kept));
        words
    }

    /// Shows it, if there is anything, to the person in front of the program; the process is to have ended.
    pub(crate) fn show(&self, who: &str) {
        let printed = self.text();
        if !printed.is_empty() {
            tell_once(&format!("`{who}` printed:\n  {}\n", printed.replace('\n', "\n  ")));
        }
    }

    fn text(&self) -> String {
        std::thread::sleep(BEHIND);
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let text = String::from_utf8_lossy(&kept);
        text.trim().chars().map(|c| if c.is_control() && c != '\n' && c != '\t' { ' ' } else { c }).collect()
    }
}

/// Writes words to the standard error, unless the same were written before: a thousand runs may fail in one way.
pub(crate) fn tell_once(words: &str) {
    static TOLD: Mutex<BTreeSet<u64>> = Mutex::new(BTreeSet::new());
    let mut hash = DefaultHasher::new();
    words.hash(&mut hash);
    if TOLD.lock().unwrap_or_else(PoisonError::into_inner).insert(hash.finish()) {
        // Where nobody listens nobody is told.
        let _ = std::io::stderr().lock().write_all(words.as_bytes());
    }
}

fn keep_last(mut from: impl Read, kept: &Mutex<Vec<u8>>) {
    let mut chunk = vec![0; CHUNK];
    loop {
        match from.read(&mut chunk) {
            Ok(0) => return,
            Ok(count) => {
                let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
                kept.extend_from_slice(&chunk[..count]);
                let beyond = kept.len().saturating_sub(KEPT);
                kept.drain(..beyond);
            }
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(_) => return,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_words_without_an_end_the_last_are_kept() {
        let kept = Mutex::new(Vec::new());
        let printed = std::io::repeat(b'x').take(10_000_000).chain(&b"\x1b[2J\nthe end\n"[..]);
        keep_last(printed, &kept);
        let words = LastWords(Arc::new(kept));
        let room = words.0.lock().unwrap().capacity();
        assert!(room <= 4 * (KEPT + CHUNK), "{room}");
        assert!(words.text().ends_with("x [2J\nthe end"), "{}", words.text());
    }
}
