//! What else the machine does while runs are timed.

use std::time::{Duration, Instant};

/// Cores that other programs may keep busy before times count as disturbed: what a quiet desktop does is below.
const QUIET: f64 = 0.25;

/// Time over which counts in hundredths of a second say something.
const SHORTEST: Duration = Duration::from_millis(200);

/// Load of the machine, where it tells.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Load {
    /// Average number of processes that ran or waited over the last minute, as the machine says it: this program's own
    /// threads included.
    pub one_minute: String,
    /// Cores that everything but this program kept busy since the last look.
    pub others: Option<f64>,
}

impl Load {
    /// What times measured meanwhile are worth: `quiet`, `loaded`, or `unknown` where the machine does not tell.
    pub fn verdict(&self) -> &'static str {
        match self.others {
            None => "unknown",
            Some(others) if others <= QUIET => "quiet",
            Some(_) => "loaded",
        }
    }
}

/// Time in which processors were busy, s, since whenever.
#[derive(Debug, Clone, Copy)]
struct Busy {
    all: f64,
    own: f64,
}

/// Looks at the machine now and then.
#[derive(Debug)]
pub(super) struct Meter {
    period: Duration,
    last: Option<Busy>,
    looked: Instant,
    load: Load,
}

impl Meter {
    /// Begins to look, at most once in a period.
    pub(super) fn start(period: Duration) -> Self {
        let load = Load { one_minute: one_minute(), others: None };
        Meter { period, last: busy(), looked: Instant::now(), load }
    }

    /// The load over the period that ended last; of the first one as soon as something can be said.
    pub(super) fn read(&mut self) -> Load {
        let elapsed = self.looked.elapsed();
        if elapsed >= self.period || (self.load.others.is_none() && elapsed >= SHORTEST) {
            let now = busy();
            let others = |before: Busy, now: Busy| {
                ((now.all - before.all - (now.own - before.own)) / elapsed.as_secs_f64()).max(0.0)
            };
            let others = self.last.zip(now).map(|(before, now)| others(before, now));
            self.load = Load { one_minute: one_minute(), others };
            (self.last, self.looked) = (now, Instant::now());
        }
        self.load.clone()
    }
}

fn one_minute() -> String {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split(' ').next().unwrap_or_default().to_owned()
}

/// Reads the counts that Linux keeps, in ticks of 1/100 s on all its machines.
fn busy() -> Option<Busy> {
    let all = busy_of_all(&std::fs::read_to_string("/proc/stat").ok()?)?;
    let own = busy_of_process(&std::fs::read_to_string("/proc/self/stat").ok()?)?;
    Some(Busy { all: all / 100.0, own: own / 100.0 })
}

/// From `/proc/stat`: `cpu  user nice system idle iowait irq softirq steal …`, of which idle and iowait are no work.
fn busy_of_all(text: &str) -> Option<f64> {
    let line = text.lines().find_map(|line| line.strip_prefix("cpu "))?;
    let ticks: Vec<f64> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
    let [user, nice, system, _idle, _iowait, irq, softirq, steal, ..] = ticks[..] else { return None };
    Some(user + nice + system + irq + softirq + steal)
}

/// From `/proc/self/stat`: user and system time are words 14 and 15; the second is a name in brackets that may hold anything.
fn busy_of_process(text: &str) -> Option<f64> {
    let (_, after_name) = text.rsplit_once(')')?;
    let mut words = after_name.split_whitespace().skip(11);
    let (user, system): (f64, f64) = (words.next()?.parse().ok()?, words.next()?.parse().ok()?);
    Some(user + system)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_read_from_what_linux_says() {
        let stat = "cpu  100 20 30 4000 500 6 7 8 0 0\ncpu0 1 2 3 4 5 6 7 8 0 0\nintr 5\n";
        assert_eq!(busy_of_all(stat), Some(171.0));
        assert_eq!(busy_of_all("intr 5\n"), None);
        let own = "42 (a) b) R 1 2 3 4 5 6 7 8 9 10 250 50 0 0 20 0 3 0 99 1 2";
        assert_eq!(busy_of_process(own), Some(300.0));
        assert_eq!(busy_of_process("42 (a) R 1"), None);
    }

    #[test]
    fn times_are_marked_by_what_others_did() {
        let verdict = |others| Load { one_minute: String::new(), others }.verdict();
        assert_eq!([None, Some(0.0), Some(0.2), Some(1.5)].map(verdict), ["unknown", "quiet", "quiet", "loaded"]);
    }

    /// Own work is not that of others: with a thread at work all the time, others cannot have had more than the rest.
    #[test]
    fn the_work_of_this_program_is_taken_off() {
        let (Some(before), began) = (busy(), Instant::now()) else { return };
        while began.elapsed() < Duration::from_millis(300) {
            std::hint::black_box(());
        }
        let after = busy().unwrap();
        let (all, own) = (after.all - before.all, after.own - before.own);
        assert!(own > 0.0 && all - own > -0.1, "{own} s of {all} s");
    }
}
