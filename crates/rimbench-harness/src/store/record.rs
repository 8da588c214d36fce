//! A record as it stands in its line.

use rimbench_results::checksums::sha256;

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

impl Record {
    /// The record of a line that is whole.
    pub(super) fn parse(line: &str) -> Option<Self> {
        let (sum, payload) = line.split_once(' ')?;
        if checksum(payload) != sum {
            return None;
        }
        let parts: Vec<&str> = payload.split('\t').collect();
        let [run_id, findings, costs, provenance, trace, limit] = parts[..] else { return None };
        let trace = match trace.split_once(' ') {
            None if trace.is_empty() => None,
            None => return None,
            Some((every_s, sha256)) => Some(TraceMark { every_s: every_s.parse().ok()?, sha256: sha256.to_owned() }),
        };
        let wall_limit_s = if limit.is_empty() { None } else { Some(limit.parse().ok()?) };
        let [run_id, findings, costs, provenance] = [run_id, findings, costs, provenance].map(str::to_owned);
        Some(Record { run_id, findings, costs, provenance, trace, wall_limit_s })
    }

    /// Wall time that the run was given before it was ended, s; infinite if it came to an end.
    pub(super) fn allowed_s(&self) -> f64 {
        self.wall_limit_s.unwrap_or(f64::INFINITY)
    }
}

/// The cells of one part of a record.
pub(crate) fn cells_of(part: &str) -> Option<csv::StringRecord> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(part.as_bytes());
    reader.records().next()?.ok()
}

/// One CSV row without its line end. Control characters become spaces: a row is one line, and a record one of tabs.
pub(crate) fn row<T: AsRef<str>>(cells: &[T]) -> String {
    // Most have nothing that would have to be quoted.
    let plain = |cell: &T| !cell.as_ref().contains(|c: char| c.is_control() || c == ',' || c == '"');
    if cells.len() > 1 && cells.iter().all(plain) {
        let mut row = String::with_capacity(cells.iter().map(|cell| cell.as_ref().len() + 1).sum());
        for (index, cell) in cells.iter().enumerate() {
            row += if index == 0 { "" } else { "," };
            row += cell.as_ref();
        }
        return row;
    }
    let mut writer = csv::WriterBuilder::new().from_writer(Vec::new());
    let cells = cells.iter().map(|cell| cell.as_ref().replace(char::is_control, " "));
    // Writing to memory cannot fail.
    let bytes = writer.write_record(cells).ok().and_then(|()| writer.into_inner().ok()).unwrap_or_default();
    String::from_utf8_lossy(&bytes).trim_end_matches('\n').to_owned()
}

/// The line of a record, with its end.
pub(super) fn line_of(record: &Record) -> String {
    let Record { run_id, findings, costs, provenance, trace, wall_limit_s } = record;
    let trace = trace.as_ref().map(|trace| format!("{:?} {}", trace.every_s, trace.sha256)).unwrap_or_default();
    let limit = wall_limit_s.map(|limit| format!("{limit:?}")).unwrap_or_default();
    let payload = [run_id, findings, costs, provenance, trace.as_str(), limit.as_str()].join("\t");
    format!("{} {payload}\n", checksum(&payload))
}

/// The first half of the digits of the SHA-256.
pub(super) fn checksum(payload: &str) -> String {
    sha256(payload)[..16].to_owned()
}
