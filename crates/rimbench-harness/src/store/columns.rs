//! The columns that records were written with, and records written with others.

use super::record::{Record, cells_of, row};
use std::fmt;

/// Names of the columns of a record: findings, costs and provenance.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Columns([Vec<String>; 3]);

impl Columns {
    /// Takes the names of the three parts in turn; they hold neither spaces nor commas.
    pub fn of<'a>(parts: impl IntoIterator<Item = impl IntoIterator<Item = &'a str>>) -> Self {
        let mut columns = Columns([const { Vec::new() }; 3]);
        for (own, names) in columns.0.iter_mut().zip(parts) {
            own.extend(names.into_iter().map(str::to_owned));
        }
        columns
    }

    /// Where the cells of these columns stand in records that were written with others.
    pub(super) fn places_in(&self, written: &Columns) -> Places {
        if self == written {
            return Places(None);
        }
        let place = |of: &[String], name: &String| of.iter().position(|other| other == name);
        let parts = [0, 1, 2].map(|part| {
            let (own, other) = (&self.0[part], &written.0[part]);
            (other.len(), own.iter().map(|name| place(other, name)).collect())
        });
        Places(Some(parts))
    }
}

impl fmt::Display for Columns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.each_ref().map(|names| names.join(",")).join(" "))
    }
}

/// Of each part how many cells were written, and which of them stands in each column now; none where all are as they are now.
pub(super) struct Places(Option<[(usize, Vec<Option<usize>>); 3]>);

impl Places {
    /// Gives a record the columns of now; none of one that has not the cells it was written with.
    pub(super) fn rearrange(&self, record: Record) -> Option<Record> {
        let Some([findings, costs, provenance]) = &self.0 else { return Some(record) };
        Some(Record {
            findings: rearranged(&record.findings, findings)?,
            costs: rearranged(&record.costs, costs)?,
            provenance: rearranged(&record.provenance, provenance)?,
            ..record
        })
    }
}

fn rearranged(cells: &str, (written, places): &(usize, Vec<Option<usize>>)) -> Option<String> {
    let cells = cells_of(cells).filter(|cells| cells.len() == *written)?;
    Some(row(&places.iter().map(|place| place.map_or("", |place| &cells[place])).collect::<Vec<_>>()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_written_before_a_metric_was_added_is_read_with_that_cell_empty() {
        let record = Record {
            run_id: "aa".to_owned(),
            findings: "failed,\"too long, too far\",3".to_owned(),
            costs: "0.5".to_owned(),
            provenance: "aa,abc".to_owned(),
            trace: None,
            wall_limit_s: None,
        };
        let written = Columns::of([vec!["outcome", "reason", "gone"], vec!["wall_s"], vec!["run_id", "revision"]]);
        let now = Columns::of([vec!["outcome", "added", "reason"], vec!["wall_s"], vec!["run_id", "revision"]]);
        let read = now.places_in(&written).rearrange(record.clone()).unwrap();
        assert_eq!(read, Record { findings: "failed,,\"too long, too far\"".to_owned(), ..record.clone() });
        assert_eq!(written.places_in(&written).rearrange(record.clone()), Some(record.clone()));
        let short = Record { findings: "failed".to_owned(), ..record };
        assert_eq!(now.places_in(&written).rearrange(short), None);
    }
}
