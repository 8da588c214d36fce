//! The file that problems with friction are kept in: text, exact to the bit, with a checksum.
//!
//! ```text
//! rimbench contact problems with friction, 1
//! stretch <first> <number of problems> <source>
//! problem <n>
//! mu <n numbers>
//! H same | H symmetric <upper triangle by rows> | H full <all entries by rows>      [n; t], 2n×2n
//! b <2n numbers>
//! …
//! sha256 <of everything before, with its line ends>
//! ```
//! Every number is the shortest that reads back as the same double.

use super::contact_problem::{Corpus, FrictionalProblem, Stretch};
use super::format::{same_bits, triangle};
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;
use sha2::{Digest, Sha256};
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

const TITLE: &str = "rimbench contact problems with friction, 1";
const CHECKSUM: &str = "sha256 ";
/// More contacts than a problem of the file can have: what is read must not ask for all memory.
const MOST_CONTACTS: usize = 1024;

impl Corpus<FrictionalProblem> {
    /// Writes the file.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written.
    pub fn write_text(&self, path: &Path) -> Result<()> {
        write_atomically(path, |file| file.write_all(self.to_text().as_bytes()))
    }

    /// Reads the file.
    ///
    /// # Errors
    /// [`Error::File`] saying what is wrong with it: missing, another format, cut short, damaged, or not a problem.
    pub fn read_text(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|error| Error::file(path, error))?;
        let text = String::from_utf8(bytes).map_err(|_| Error::file(path, another_format()))?;
        Corpus::from_text(&text).map_err(|message| Error::file(path, message))
    }

    /// Returns what the file holds.
    pub fn to_text(&self) -> String {
        let mut text = format!("{TITLE}\n");
        for Stretch { source, first, problems } in &self.stretches {
            // A source has no line ends: it is made of names and numbers.
            let source = source.replace(['\n', '\r'], " ");
            line(&mut text, format_args!("stretch {first} {} {source}", problems.len()), &[]);
            let mut before: Option<&FrictionalProblem> = None;
            for problem in problems {
                put_problem(&mut text, problem, before);
                before = Some(problem);
            }
        }
        let checksum = checksum(&text);
        text + CHECKSUM + &checksum + "\n"
    }

    /// Reads what the file holds; says what is wrong with it.
    ///
    /// # Errors
    /// One sentence.
    pub fn from_text(text: &str) -> Result<Self, String> {
        if !text.starts_with(TITLE) {
            return Err(another_format());
        }
        let damaged =
            "is cut short or damaged: its checksum does not fit; `rimbench solvers --harvest --friction` makes it anew";
        let (content, found) = text.rsplit_once(CHECKSUM).ok_or(damaged)?;
        if checksum(content) != found.trim_end() {
            return Err(damaged.to_owned());
        }
        let mut reader = Reader { lines: content.lines().enumerate().skip(1).peekable(), at: 1 };
        let mut stretches = Vec::new();
        while reader.lines.peek().is_some() {
            stretches.push(reader.stretch().map_err(|what| format!("line {}: {what}", reader.at))?);
        }
        Ok(Corpus { stretches })
    }
}

fn another_format() -> String {
    format!("is not a corpus of contact problems with friction (it should begin with `{TITLE}`)")
}

fn checksum(text: &str) -> String {
    Sha256::digest(text.as_bytes()).iter().fold(String::new(), |text, byte| text + &format!("{byte:02x}"))
}

/// Writes a line; a string takes whatever it is given.
fn line(text: &mut String, head: std::fmt::Arguments<'_>, numbers: &[f64]) {
    let mut put = |part: std::fmt::Arguments<'_>| text.write_fmt(part).unwrap_or_default();
    put(head);
    numbers.iter().for_each(|number| put(format_args!(" {number:e}")));
    put(format_args!("\n"));
}

fn put_problem(text: &mut String, problem: &FrictionalProblem, before: Option<&FrictionalProblem>) {
    let FrictionalProblem { h, b, friction } = problem;
    let size = b.len();
    line(text, format_args!("problem {}", friction.len()), &[]);
    line(text, format_args!("mu"), friction);
    if before.is_some_and(|before| same_bits(&before.h, h)) {
        line(text, format_args!("H same"), &[]);
    } else if (0..size).all(|i| (0..i).all(|j| h[i * size + j].to_bits() == h[j * size + i].to_bits())) {
        let upper: Vec<f64> = triangle(size).map(|(i, j)| h[i * size + j]).collect();
        line(text, format_args!("H symmetric"), &upper);
    } else {
        line(text, format_args!("H full"), h);
    }
    line(text, format_args!("b"), b);
}

struct Reader<'a, L: Iterator<Item = (usize, &'a str)>> {
    lines: std::iter::Peekable<L>,
    /// Line read last, from 1.
    at: usize,
}

impl<'a, L: Iterator<Item = (usize, &'a str)>> Reader<'a, L> {
    /// What follows `key` on the next line.
    fn after(&mut self, key: &str) -> Result<&'a str, String> {
        let (index, line) = self.lines.next().ok_or_else(|| format!("`{key}` is missing"))?;
        self.at = index + 1;
        let rest = line.strip_prefix(key).filter(|rest| rest.is_empty() || rest.starts_with(' '));
        rest.map(str::trim_start).ok_or_else(|| format!("`{key}` is expected here"))
    }

    fn stretch(&mut self) -> Result<Stretch<FrictionalProblem>, String> {
        let head = self.after("stretch")?;
        let mut words = head.splitn(3, ' ');
        let first = words.next().and_then(|word| word.parse().ok()).ok_or("a stretch needs the number of its first")?;
        let count: usize =
            words.next().and_then(|word| word.parse().ok()).ok_or("a stretch needs its number of problems")?;
        let source = words.next().unwrap_or_default().to_owned();
        let mut problems: Vec<FrictionalProblem> = Vec::new();
        for _ in 0..count {
            let problem = self.problem(problems.last())?;
            problems.push(problem);
        }
        if problems.is_empty() {
            Err("a stretch without problems".to_owned())
        } else {
            Ok(Stretch { source, first, problems })
        }
    }

    fn problem(&mut self, before: Option<&FrictionalProblem>) -> Result<FrictionalProblem, String> {
        let contacts = self.after("problem")?;
        let n: usize = contacts
            .parse()
            .ok()
            .filter(|n| (1..=MOST_CONTACTS).contains(n))
            .ok_or_else(|| format!("`{contacts}` is not a number of contacts from 1 to {MOST_CONTACTS}"))?;
        let size = 2 * n;
        let friction = numbers(self.after("mu")?, n)?;
        if let Some(mu) = friction.iter().find(|mu| **mu < 0.0) {
            return Err(format!("a coefficient of friction of {mu}, below 0"));
        }
        let matrix = self.after("H")?;
        let h: Arc<[f64]> = if matrix == "same" {
            let before = before.filter(|before| before.b.len() == size);
            before.map(|before| before.h.clone()).ok_or("there is no problem of that size before")?
        } else if let Some(upper) = matrix.strip_prefix("symmetric ") {
            let mut h = vec![0.0; size * size];
            for ((i, j), entry) in triangle(size).zip(numbers(upper, size * (size + 1) / 2)?) {
                (h[i * size + j], h[j * size + i]) = (entry, entry);
            }
            h.into()
        } else if let Some(all) = matrix.strip_prefix("full ") {
            numbers(all, size * size)?.into()
        } else {
            return Err("a matrix is `same`, `symmetric` or `full`".to_owned());
        };
        Ok(FrictionalProblem { h, b: numbers(self.after("b")?, size)?, friction })
    }
}

/// So many finite numbers.
fn numbers(text: &str, count: usize) -> Result<Vec<f64>, String> {
    let number = |word: &str| {
        let number = word.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| format!("`{word}` is not a finite number"))
    };
    let numbers = text.split(' ').map(number).collect::<Result<Vec<f64>, _>>()?;
    if numbers.len() == count { Ok(numbers) } else { Err(format!("{} numbers instead of {count}", numbers.len())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corpus() -> Corpus<FrictionalProblem> {
        let h: Arc<[f64]> = vec![1.0 / 3.0, -0.1, -0.1, f64::MIN_POSITIVE].into();
        let problem = |b: [f64; 2]| FrictionalProblem { h: h.clone(), b: b.to_vec(), friction: vec![0.3] };
        let full =
            FrictionalProblem { h: vec![2.0, -0.0, 0.0, 2.0].into(), b: vec![1e300, -5e-324], friction: vec![0.0] };
        let stretch = |source: &str, first, problems| Stretch { source: source.to_owned(), first, problems };
        Corpus {
            stretches: vec![
                stretch("block μ = 0.3 H=0.005 mechanics", 7, vec![problem([-1.0, 0.1]), problem([-0.0, 3e-17])]),
                stretch("", u64::MAX, vec![full]),
            ],
        }
    }

    #[test]
    fn what_is_read_is_what_was_written_to_the_last_bit() {
        let (corpus, text) = (corpus(), corpus().to_text());
        let read = Corpus::from_text(&text).unwrap();
        assert_eq!(read, corpus);
        // Zeros of both signs are equal; the texts are not.
        assert_eq!(read.to_text(), text);
        assert!(Arc::ptr_eq(&read.stretches[0].problems[0].h, &read.stretches[0].problems[1].h));
        assert_eq!((read.len(), read.largest(), read.of_source("block").len()), (3, 1, 2));
    }

    #[test]
    fn every_single_damaged_byte_is_noticed() {
        let text = corpus().to_text();
        // The line end after the checksum says nothing.
        for position in 0..text.len() - 1 {
            let mut damaged = text.clone().into_bytes();
            damaged[position] ^= 0x01;
            if let Ok(damaged) = String::from_utf8(damaged) {
                assert!(Corpus::from_text(&damaged).is_err(), "byte {position}");
            }
            assert!(text.get(..position).is_none_or(|cut| Corpus::from_text(cut).is_err()), "cut at {position}");
        }
    }

    #[test]
    fn nonsense_under_a_valid_checksum_is_refused_with_its_line() {
        for (content, wanted) in [
            ("stretch 0 1 a\nproblem 1\nmu 0.3\nH same\nb 1 1\n", "line 5: there is no problem"),
            ("stretch 0 1 a\nproblem 1\nmu -0.3\n", "line 4: a coefficient of friction of -0.3"),
            ("stretch 0 1 a\nproblem 1\nmu nan\n", "line 4: `nan` is not a finite number"),
            ("stretch 0 1 a\nproblem 0\n", "line 3: `0` is not a number of contacts"),
            ("stretch 0 1 a\nproblem 99999999999\n", "line 3: `99999999999` is not"),
            ("stretch 0 1 a\nproblem 1\nmu 0.3\nH symmetric 1 1\n", "line 5: 2 numbers instead of 3"),
            ("stretch 0 1 a\nproblem 1\nmu 0.3\n", "`H` is missing"),
            ("stretch 0 0 a\n", "line 2: a stretch without problems"),
            ("strech 0 0 a\n", "line 2: `stretch` is expected here"),
        ] {
            let content = format!("{TITLE}\n{content}");
            let text = format!("{content}{CHECKSUM}{}\n", checksum(&content));
            let said = Corpus::from_text(&text).unwrap_err();
            assert!(said.contains(wanted), "{said}");
        }
        assert!(Corpus::from_text("RIMLCP1").unwrap_err().contains("should begin with"));
    }
}
