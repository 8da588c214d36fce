//! Missed deadlines of a real-time run, from a log of its computing times.

use super::number::seconds;
use clap::Args;
use rimbench::cosim::Channel;
use rimbench::error::{Error, Result};
use rimbench::input::read_text;
use std::path::PathBuf;

/// Options that replay a log.
#[derive(Debug, Args)]
pub struct DeadlineLog {
    /// Replay missed deadlines: a CSV file with the columns `time_s` and `computing_time_s`, one row per macro step
    #[arg(long, value_name = "FILE", requires = "deadline")]
    deadline_log: Option<PathBuf>,
    /// Time that a macro step may take
    #[arg(long, value_name = "TIME", value_parser = seconds, requires = "deadline_log")]
    deadline: Option<f64>,
}

impl DeadlineLog {
    /// Adds the macro steps that missed the deadline D to those of the channel. A macro step that took c is late by ⌈c/D⌉ − 1 steps.
    ///
    /// # Errors
    /// [`Error::File`] for a file that cannot be read, lacks a column, or has times that go back; [`Error::InvalidValue`] for a deadline
    /// that is no positive time.
    pub(super) fn apply(&self, channel: &mut Option<Channel>) -> Result<()> {
        let (Some(path), Some(deadline)) = (&self.deadline_log, self.deadline) else { return Ok(()) };
        if !(deadline.is_finite() && deadline > 0.0) {
            return Err(Error::invalid("--deadline", deadline, "a time above 0 s"));
        }
        let text = read_text(path)?;
        let missed = missed(&text, deadline).map_err(|why| Error::file(path, why))?;
        channel.get_or_insert_default().missed = missed;
        Ok(())
    }
}

/// Reads which macro steps of a log missed the deadline (s), and by how many macro steps each.
fn missed(text: &str, deadline: f64) -> std::result::Result<Vec<(u32, u32)>, String> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let header = reader.headers().map_err(|error| error.to_string())?.clone();
    let place = |name: &str| {
        let found = header.iter().position(|column| column == name);
        found.ok_or_else(|| {
            format!("has no column `{name}`; valid: time_s and computing_time_s, one row per macro step")
        })
    };
    let (time, computing) = (place("time_s")?, place("computing_time_s")?);
    let (mut missed, mut before) = (Vec::new(), f64::NEG_INFINITY);
    for (index, row) in (0_u32..).zip(reader.records()) {
        let row = row.map_err(|error| error.to_string())?;
        let line = row.position().map_or(0, csv::Position::line);
        let number = |column: usize| {
            let number = row.get(column).and_then(|cell| cell.parse().ok()).filter(|number: &f64| number.is_finite());
            number.ok_or_else(|| format!("line {line}: column `{}` needs a number of seconds", &header[column]))
        };
        let (time, computing) = (number(time)?, number(computing)?);
        if time <= before {
            return Err(format!("line {line}: time_s = {time} goes back from {before}; rows are in the order of time"));
        }
        if computing < 0.0 {
            return Err(format!("line {line}: computing_time_s = {computing}; valid: 0 or more"));
        }
        before = time;
        let late = (computing / deadline).ceil() - 1.0;
        if late >= 1.0 {
            missed.push((index, late as u32));
        }
    }
    Ok(missed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_macro_step_is_late_by_the_deadlines_that_it_missed() {
        let log = "time_s, computing_time_s\n0.0, 0.004\n0.005, 0.0051\n0.01, 0.005\n0.015, 0.0121\n";
        assert_eq!(missed(log, 5e-3).unwrap(), [(1, 1), (3, 2)]);
    }

    #[test]
    fn a_log_that_is_none_is_refused_with_its_line() {
        let refused = |text: &str| missed(text, 5e-3).unwrap_err();
        assert!(refused("time_s\n0\n").contains("no column `computing_time_s`"));
        assert!(refused("time_s,computing_time_s\n0.1,0\n0.05,0\n").contains("line 3: time_s = 0.05 goes back"));
        assert!(refused("time_s,computing_time_s\n0.1,x\n").contains("line 2: column `computing_time_s`"));
        assert!(refused("time_s,computing_time_s\n0.1,-1\n").contains("0 or more"));
    }
}
