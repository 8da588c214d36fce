//! The file a corpus is kept in: compact, exact to the bit, with a checksum.
//!
//! All numbers little-endian, lengths unsigned:
//!
//! ```text
//! file      magic "RIMLCP1\n", with friction "RIMFRI1\n" · u32 number of stretches · stretches · SHA-256 of everything before (32 bytes)
//! stretch   u16 length of the source · source, UTF-8 · u64 first · u32 number of problems · problems
//! problem   u16 n · with friction n coefficients as f64 · u8 kind of matrix · matrix of n or 2n rows · right-hand side as n or 2n f64
//! matrix    kind 0: that of the problem before (same stretch)
//!           kind 1: upper triangle by rows, the rest by symmetry; kind 2: all entries by rows
//!           kinds 1, 2: one bit per entry, lowest bit first, set where the entry is not +0; then those entries as f64
//! ```
//! Contacts of a pile touch few others: most entries of a large matrix are zero and take one bit.

use super::contact_problem::{Corpus, Problem, Stretch};
use rimbench_core::error::{Error, Result};
use rimbench_results::atomic_file::write_atomically;
use sha2::{Digest, Sha256};
use std::path::Path;
use std::sync::Arc;

const CHECKSUM: usize = 32;
const SAME: u8 = 0;
const TRIANGLE: u8 = 1;
const FULL: u8 = 2;

impl<const FRICTION: bool> Corpus<FRICTION> {
    /// Writes the file.
    ///
    /// # Errors
    /// [`Error::File`] if it cannot be written, or if a number does not fit the format.
    pub fn write(&self, path: &Path) -> Result<()> {
        let bytes =
            self.to_bytes().ok_or_else(|| Error::file(path, "a problem above 65535 contacts has no place in it"))?;
        write_atomically(path, |file| file.write_all(&bytes))
    }

    /// Reads the file.
    ///
    /// # Errors
    /// [`Error::File`] saying what is wrong with it: missing, another format, cut short, or damaged.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|error| Error::file(path, error))?;
        Corpus::from_bytes(&bytes).map_err(|message| Error::file(path, message))
    }

    /// The bytes of the file; `None` if a length does not fit.
    pub fn to_bytes(&self) -> Option<Vec<u8>> {
        let mut bytes = Problem::<FRICTION>::MAGIC.to_vec();
        bytes.extend(u32::try_from(self.stretches.len()).ok()?.to_le_bytes());
        for stretch in &self.stretches {
            bytes.extend(u16::try_from(stretch.source.len()).ok()?.to_le_bytes());
            bytes.extend(stretch.source.as_bytes());
            bytes.extend(stretch.first.to_le_bytes());
            bytes.extend(u32::try_from(stretch.problems.len()).ok()?.to_le_bytes());
            let mut before: Option<&Problem<FRICTION>> = None;
            for problem in &stretch.problems {
                bytes.extend(u16::try_from(problem.contacts()).ok()?.to_le_bytes());
                problem.friction.iter().for_each(|mu| bytes.extend(mu.to_le_bytes()));
                match before {
                    Some(before) if same_bits(&before.h, &problem.h) => bytes.push(SAME),
                    _ => put_matrix(&problem.h, problem.unknowns(), &mut bytes),
                }
                problem.b.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
                before = Some(problem);
            }
        }
        let checksum = Sha256::digest(&bytes);
        bytes.extend(&checksum[..]);
        Some(bytes)
    }

    /// Reads the bytes of the file; says what is wrong with them.
    ///
    /// # Errors
    /// One sentence.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let (friction, option) = if FRICTION { (" with friction", " --friction") } else { ("", "") };
        let magic = Problem::<FRICTION>::MAGIC;
        if !bytes.starts_with(magic) {
            let magic = String::from_utf8_lossy(&magic[..7]);
            return Err(format!("is not a corpus of contact problems{friction} (it should begin with `{magic}`)"));
        }
        let wrong = |what: &str| format!("{what}; `rimbench solvers --harvest{option}` makes it anew");
        let (content, checksum) = bytes.split_at(bytes.len().saturating_sub(CHECKSUM));
        if Sha256::digest(content)[..] != *checksum {
            return Err(wrong("is cut short or damaged: its checksum does not fit"));
        }
        let mut reader = Reader { rest: content.strip_prefix(magic).unwrap_or_default() };
        let corpus = reader.corpus().filter(|_| reader.rest.is_empty());
        corpus.ok_or_else(|| wrong("contradicts its own format although its checksum fits"))
    }
}

/// Equal to the last bit, so that what is read is what was written.
pub(super) fn same_bits(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

/// Bytes that a matrix takes.
pub(super) fn matrix_bytes(h: &[f64], n: usize) -> usize {
    let mut bytes = Vec::new();
    put_matrix(h, n, &mut bytes);
    bytes.len()
}

fn put_matrix(h: &[f64], n: usize, bytes: &mut Vec<u8>) {
    let symmetric = (0..n).all(|i| (0..i).all(|j| h[i * n + j].to_bits() == h[j * n + i].to_bits()));
    bytes.push(if symmetric { TRIANGLE } else { FULL });
    let entries: Vec<f64> = if symmetric { triangle(n).map(|(i, j)| h[i * n + j]).collect() } else { h.to_vec() };
    for chunk in entries.chunks(8) {
        bytes.push(chunk.iter().enumerate().fold(0, |bits, (k, entry)| bits | u8::from(entry.to_bits() != 0) << k));
    }
    entries.iter().filter(|entry| entry.to_bits() != 0).for_each(|entry| bytes.extend(entry.to_le_bytes()));
}

/// Row and column of each entry of the upper triangle, by rows.
fn triangle(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |i| (i..n).map(move |j| (i, j)))
}

/// Takes numbers off the front of a slice; `None` where it is too short.
struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    fn bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.rest.split_at_checked(count)?;
        self.rest = rest;
        Some(head)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.bytes(N)?.try_into().ok()
    }

    fn number(&mut self) -> Option<f64> {
        self.array().map(f64::from_le_bytes)
    }

    fn length(&mut self) -> Option<usize> {
        self.array().map(u16::from_le_bytes).map(usize::from)
    }

    fn numbers(&mut self, count: usize) -> Option<Vec<f64>> {
        (0..count).map(|_| self.number()).collect()
    }

    fn corpus<const FRICTION: bool>(&mut self) -> Option<Corpus<FRICTION>> {
        let count = u32::from_le_bytes(self.array()?);
        (0..count).map(|_| self.stretch()).collect::<Option<_>>().map(|stretches| Corpus { stretches })
    }

    fn stretch<const FRICTION: bool>(&mut self) -> Option<Stretch<FRICTION>> {
        let length = self.length()?;
        let source = std::str::from_utf8(self.bytes(length)?).ok()?.to_owned();
        let first = u64::from_le_bytes(self.array()?);
        let count = u32::from_le_bytes(self.array()?);
        let mut problems: Vec<Problem<FRICTION>> = Vec::new();
        for _ in 0..count {
            let n = self.length()?;
            let unknowns = Problem::<FRICTION>::UNKNOWNS * n;
            let friction = self.numbers(if FRICTION { n } else { 0 })?;
            let h = self.matrix(unknowns, problems.last())?;
            let b = self.numbers(unknowns)?;
            let sound = friction.iter().all(|mu| *mu >= 0.0) && h.iter().chain(&b).all(|x| x.is_finite());
            problems.push(sound.then_some(Problem { h, b, friction })?);
        }
        (!problems.is_empty()).then_some(Stretch { source, first, problems })
    }

    fn matrix<const F: bool>(&mut self, n: usize, before: Option<&Problem<F>>) -> Option<Arc<[f64]>> {
        let kind = self.array::<1>()?[0];
        match kind {
            SAME => before.filter(|before| before.unknowns() == n).map(|before| Arc::clone(&before.h)),
            TRIANGLE => {
                let entries = self.entries(n * (n + 1) / 2)?;
                let mut h = vec![0.0; n * n];
                for ((i, j), entry) in triangle(n).zip(entries) {
                    (h[i * n + j], h[j * n + i]) = (entry, entry);
                }
                Some(h.into())
            }
            FULL => self.entries(n * n).map(Into::into),
            _ => None,
        }
    }

    fn entries(&mut self, count: usize) -> Option<Vec<f64>> {
        let bits = self.bytes(count.div_ceil(8))?;
        (0..count).map(|k| if bits[k / 8] >> (k % 8) & 1 == 1 { self.number() } else { Some(0.0) }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::contact_problem::{FrictionalCorpus, FrictionalProblem};
    use super::*;

    fn stretch<const F: bool>(source: &str, first: u64, problems: Vec<Problem<F>>) -> Stretch<F> {
        Stretch { source: source.to_owned(), first, problems }
    }

    fn corpus() -> Corpus {
        let problem = |h: &[f64], b: &[f64]| Problem { h: h.into(), b: b.to_vec(), friction: Vec::new() };
        let chain = [2.0, -1.0, 0.0, -1.0, 2.0, -1.0, 0.0, -1.0, 2.0];
        let first = vec![problem(&chain, &[-1.0, 0.5, 3e-300]), problem(&chain, &[0.0; 3]), problem(&[0.0], &[-0.0])];
        let rounded = vec![problem(&[1.0, -0.0, 0.0, 1.0], &[f64::MIN_POSITIVE, -1.0]), problem(&[], &[])];
        Corpus { stretches: vec![stretch("row δ = 1", 7, first), stretch("", u64::MAX, rounded)] }
    }

    fn frictional(h: &[f64], b: [f64; 2], mu: f64) -> FrictionalProblem {
        FrictionalProblem { h: h.into(), b: b.to_vec(), friction: vec![mu] }
    }

    fn with_friction() -> FrictionalCorpus {
        let h = [1.0 / 3.0, -0.1, -0.1, f64::MIN_POSITIVE];
        let full = frictional(&[2.0, -0.0, 0.0, 2.0], [1e300, -5e-324], 0.0);
        let first = vec![frictional(&h, [-1.0, 0.1], 0.3), frictional(&h, [-0.0, 3e-17], 0.3), full];
        Corpus { stretches: vec![stretch("block μ = 0.3", 7, first)] }
    }

    fn check<const F: bool>(corpus: &Corpus<F>, counts: (usize, usize)) {
        let bytes = corpus.to_bytes().unwrap();
        let read = Corpus::<F>::from_bytes(&bytes).unwrap();
        assert_eq!(read, *corpus);
        // Zeros of both signs are equal; the bytes are not.
        assert_eq!(read.to_bytes().unwrap(), bytes);
        assert!(Arc::ptr_eq(&read.stretches[0].problems[0].h, &read.stretches[0].problems[1].h));
        assert_eq!((read.len(), read.largest()), counts);
        for position in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[position] ^= 0x10;
            assert!(Corpus::<F>::from_bytes(&damaged).is_err(), "byte {position}");
            assert!(Corpus::<F>::from_bytes(&bytes[..position]).is_err(), "cut at {position}");
        }
        assert!(Corpus::<F>::from_bytes(b"case,H\n").unwrap_err().contains("it should begin with `RIM"));
    }

    #[test]
    fn what_is_read_is_what_was_written_to_the_last_bit_and_every_damaged_byte_is_noticed() {
        check(&corpus(), (5, 3));
        check(&with_friction(), (3, 1));
        assert_eq!(corpus().of_source("row").len(), 3);
    }

    #[test]
    fn nonsense_under_a_valid_checksum_is_refused() {
        // One stretch that promises a problem whose matrix is that of the one before, which does not exist.
        let mut bytes = Problem::<false>::MAGIC.to_vec();
        bytes.extend([1, 0, 0, 0, 0, 0]);
        bytes.extend([0; 8]);
        bytes.extend([1, 0, 0, 0, 1, 0, SAME]);
        bytes.extend(1.0_f64.to_le_bytes());
        let checksum = Sha256::digest(&bytes);
        bytes.extend(&checksum[..]);
        assert!(Corpus::<false>::from_bytes(&bytes).unwrap_err().starts_with("contradicts"));
        // Numbers that no problem has.
        for problem in [frictional(&[1.0; 4], [0.0; 2], -0.3), frictional(&[f64::NAN; 4], [0.0; 2], 0.3)] {
            let bytes = Corpus { stretches: vec![stretch("", 0, vec![problem])] }.to_bytes().unwrap();
            assert!(FrictionalCorpus::from_bytes(&bytes).unwrap_err().starts_with("contradicts"));
        }
    }
}
