//! A record as it stands in its line.

use sha2::{Digest, Sha256};

/// Digits of a checksum.
pub(super) const CHECKSUM: usize = 16;

/// One finished run: what was found, as cells of the three files, without line ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// [`RunSpec::id`](rimbench_cases::runs::RunSpec::id).
    pub run_id: String,
    /// Cells of `runs.csv` behind the settings.
    pub findings: String,
    /// Cells of `cost.csv` behind the settings.
    pub costs: String,
    /// Row of `provenance.csv`.
    pub provenance: String,
    /// The trace that was written with it.
    pub trace: Option<TraceMark>,
    /// Wall time that the run was given and that was not enough, s; none for a run that came to an end.
    pub wall_limit_s: Option<f64>,
}

/// By what a trace is known again.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceMark {
    /// Distance of its rows, s.
    pub every_s: f64,
    /// SHA-256 of the file.
    pub sha256: String,
}

/// A record that is read where it lies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line<'a> {
    pub(crate) run_id: &'a str,
    pub(crate) findings: &'a str,
    pub(crate) costs: &'a str,
    pub(crate) provenance: &'a str,
    /// Distance of the rows of the trace, s, and its SHA-256.
    pub(crate) trace: Option<(f64, &'a str)>,
    pub(crate) wall_limit_s: Option<f64>,
}

impl<'a> Line<'a> {
    /// The record of a line that is whole.
    pub(super) fn parse(line: &'a str) -> Option<Self> {
        let (sum, payload) = line.split_once(' ')?;
        if checksum(payload) != sum.as_bytes() {
            return None;
        }
        let mut parts = payload.split('\t');
        let mut next = || parts.next();
        let [run_id, findings, costs, provenance, trace, limit] =
            [next()?, next()?, next()?, next()?, next()?, next()?];
        if next().is_some() {
            return None;
        }
        let trace = match trace.split_once(' ') {
            None if trace.is_empty() => None,
            None => return None,
            Some((every_s, sha256)) => Some((every_s.parse().ok()?, sha256)),
        };
        let wall_limit_s = if limit.is_empty() { None } else { Some(limit.parse().ok()?) };
        Some(Line { run_id, findings, costs, provenance, trace, wall_limit_s })
    }

    pub(super) fn to_record(self) -> Record {
        let Line { run_id, findings, costs, provenance, trace, wall_limit_s } = self;
        let [run_id, findings, costs, provenance] = [run_id, findings, costs, provenance].map(str::to_owned);
        let trace = trace.map(|(every_s, sha256)| TraceMark { every_s, sha256: sha256.to_owned() });
        Record { run_id, findings, costs, provenance, trace, wall_limit_s }
    }
}

/// The line of a record, with its end.
pub(super) fn line_of(record: &Record) -> String {
    let Record { run_id, findings, costs, provenance, trace, wall_limit_s } = record;
    let trace = trace.as_ref().map(|trace| format!("{:?} {}", trace.every_s, trace.sha256)).unwrap_or_default();
    let limit = wall_limit_s.map(|limit| format!("{limit:?}")).unwrap_or_default();
    let payload = [run_id, findings, costs, provenance, trace.as_str(), limit.as_str()].join("\t");
    format!("{} {payload}\n", String::from_utf8_lossy(&checksum(&payload)))
}

/// The first half of the digits of the SHA-256.
fn checksum(payload: &str) -> [u8; CHECKSUM] {
    let digest = Sha256::digest(payload);
    std::array::from_fn(|place| {
        let half = digest[place / 2] >> (4 * ((place + 1) % 2)) & 15;
        b"0123456789abcdef"[usize::from(half)]
    })
}
