//! Where the record of each run lies: 40 bytes per run, and no second copy while logs are read.

use rayon::prelude::*;

/// A run id, filled up with zeros.
pub(super) type Key = [u8; 16];

/// The key of a run id; none of a text that is none, being longer.
pub(super) fn key(run_id: &str) -> Option<Key> {
    let mut key = Key::default();
    key.get_mut(..run_id.len())?.copy_from_slice(run_id.as_bytes());
    Some(key)
}

/// Where a record lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    /// Number of the log.
    pub(super) file: u32,
    /// Bytes of its line, the end aside.
    pub(super) length: u32,
    /// Where in the log.
    pub(super) offset: u64,
    /// Wall time after which the run was ended, s; infinite if it came to an end.
    pub(super) allowed_s: f64,
}

/// Entries below which it is not worth the while to look for runs that are there twice.
const FEW: usize = 1 << 16;

/// Places by run id. Of several records of a run the one that says most stands, of equals the newest.
#[derive(Debug, Default)]
pub(super) struct Index {
    /// Ordered by key, the first `settled` of them.
    entries: Vec<(Key, Place)>,
    settled: usize,
}

impl Index {
    /// Takes over the records of a log; logs come in the order of their numbers.
    pub(super) fn take_over(&mut self, mut records: Vec<(Key, Place)>) {
        // Doubling would take twice what is needed.
        self.entries.reserve_exact(records.len().max(self.entries.len() / 8));
        self.entries.append(&mut records);
        // Runs that are stored again and again must not add up.
        if self.entries.len() > FEW + 2 * self.settled {
            self.settle();
        }
    }

    /// Puts the entries in order, one per run. Must be called before anything is looked for.
    pub(super) fn settle(&mut self) {
        self.entries.par_sort_unstable_by_key(|(key, place)| (*key, place.file, place.offset));
        self.entries.dedup_by(|(later, place), (key, stands)| {
            let same = later == key;
            if same && place.allowed_s >= stands.allowed_s {
                *stands = *place;
            }
            same
        });
        self.settled = self.entries.len();
    }

    pub(super) fn len(&self) -> usize {
        self.entries.len()
    }

    pub(super) fn get(&self, run_id: &str) -> Option<&Place> {
        let key = key(run_id)?;
        let at = self.entries.binary_search_by(|(known, _)| known.cmp(&key)).ok()?;
        Some(&self.entries[at].1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Taken over a log at a time and settled in between, it says what a look at all records in their order says.
    #[test]
    fn however_often_it_is_settled_the_record_that_says_most_stands() {
        let log = |file: u32| -> Vec<(Key, Place)> {
            let of = |nth: u64| {
                // Some runs in every log, some ended by a limit that differs from log to log.
                let id = format!("{:016x}", (nth * 7919 + u64::from(file) * 131) % 50_000);
                let allowed_s =
                    if (nth + u64::from(file)).is_multiple_of(3) { f64::INFINITY } else { ((nth * 31) % 5) as f64 };
                (key(&id).unwrap(), Place { file, length: 1, offset: nth, allowed_s })
            };
            (0..30_000).map(of).collect()
        };
        let mut index = Index::default();
        let mut plain: std::collections::HashMap<Key, Place> = std::collections::HashMap::new();
        for file in 0..12 {
            for (key, place) in log(file) {
                let known = plain.entry(key).or_insert(place);
                if place.allowed_s >= known.allowed_s {
                    *known = place;
                }
            }
            index.take_over(log(file));
            assert!(index.entries.len() <= FEW + 2 * 50_000 + 30_000, "{} entries", index.entries.len());
        }
        index.settle();
        assert_eq!(index.len(), plain.len());
        for (key, place) in &plain {
            assert_eq!(index.get(std::str::from_utf8(key).unwrap()), Some(place));
        }
        assert_eq!(index.get("0123"), None);
        assert_eq!(index.get("longer than sixteen bytes"), None);
    }
}
