//! Missed deadlines of a real-time run, from a log of its computing times.

use rimbench_core::cosim::{Channel, CommunicationGrid, MOST_LATE};

/// Share of a macro step by which a row may stand beside the beginning of one.
const BESIDE: f64 = 1e-2;

/// A log of computing times with the deadline D (s) of a macro step.
///
/// ```text
/// time_s,computing_time_s      one row per macro step; a macro step that took c is late by ⌈c/D⌉ − 1 steps
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct DeadlineLog {
    deadline: f64,
    /// Line, time and computing time.
    rows: Vec<(u64, f64, f64)>,
}

impl DeadlineLog {
    /// Reads the text of a log.
    ///
    /// # Errors
    /// Says what is wrong with the log, and in which line, or with the deadline.
    pub fn read(text: &str, deadline: f64) -> Result<Self, String> {
        if !(deadline.is_finite() && deadline > 0.0) {
            return Err(format!("deadline = {deadline} s is not valid; valid: a time above 0 s"));
        }
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
        let header = reader.headers().map_err(|error| error.to_string())?.clone();
        let place = |name: &str| {
            let mut found = (0..header.len()).filter(|column| &header[*column] == name);
            match (found.next(), found.next()) {
                (Some(column), None) => Ok(column),
                (Some(_), Some(_)) => Err(format!("has two columns `{name}`; valid: one")),
                (None, _) => {
                    Err(format!("has no column `{name}`; valid: time_s and computing_time_s, one row per macro step"))
                }
            }
        };
        let (time, computing) = (place("time_s")?, place("computing_time_s")?);
        let mut rows: Vec<(u64, f64, f64)> = Vec::new();
        for row in reader.records() {
            let row = row.map_err(|error| error.to_string())?;
            let line = row.position().map_or(0, csv::Position::line);
            let number = |column: usize| {
                let number = row.get(column).and_then(|cell| cell.parse().ok());
                let number = number.filter(|number: &f64| number.is_finite());
                number.ok_or_else(|| format!("line {line}: column `{}` needs a number of seconds", &header[column]))
            };
            let (time, computing) = (number(time)?, number(computing)?);
            if let Some((_, before, _)) = rows.last().filter(|(_, before, _)| time <= *before) {
                return Err(format!(
                    "line {line}: time_s = {time} goes back from {before}; rows are in the order of time"
                ));
            }
            if computing < 0.0 {
                return Err(format!("line {line}: computing_time_s = {computing}; valid: 0 or more"));
            }
            if (computing / deadline).ceil() - 1.0 > f64::from(MOST_LATE) {
                return Err(format!(
                    "line {line}: computing_time_s = {computing}; valid: at most {MOST_LATE} deadlines"
                ));
            }
            rows.push((line, time, computing));
        }
        if rows.is_empty() {
            return Err("has no rows; valid: one row per macro step".to_owned());
        }
        Ok(DeadlineLog { deadline, rows })
    }

    /// Adds the macro steps that missed the deadline to those of a channel, for a run on a grid. The row of a macro
    /// step is that of its time divided by H. Returns what is to be said of a log that is longer or shorter than the
    /// run.
    ///
    /// # Errors
    /// Says which row belongs to no macro step, or which macro step has none; that the channel has missed steps
    /// already.
    pub fn replay(&self, grid: &CommunicationGrid, channel: &mut Channel) -> Result<Option<String>, String> {
        if !channel.missed.is_empty() {
            return Err("missed macro steps are given besides: give one of the two".to_owned());
        }
        let (macro_step, count) = (grid.macro_step(), grid.macro_steps());
        for (expected, (line, time, computing)) in self.rows.iter().enumerate() {
            let step = (time / macro_step).round();
            let valid = format!("a row for each macro step of {macro_step} s, the first at time_s = 0");
            if (time / macro_step - step).abs() > BESIDE {
                return Err(format!("line {line}: time_s = {time} is between macro steps; valid: {valid}"));
            }
            if step != expected as f64 {
                return Err(format!(
                    "line {line}: time_s = {time} is macro step {step}, and macro step {expected} has no row; valid: {valid}"
                ));
            }
            let late = (computing / self.deadline).ceil() - 1.0;
            if late >= 1.0 && expected < count {
                channel.missed.push((expected as u32, late as u32));
            }
        }
        let rows = self.rows.len();
        Ok(match rows {
            _ if rows > count => {
                Some(format!("has {rows} macro steps and the run {count}: those beyond its end are left out"))
            }
            _ if rows < count => {
                Some(format!("has {rows} macro steps and the run {count}: those beyond its end are in time"))
            }
            _ => None,
        })
    }
}
