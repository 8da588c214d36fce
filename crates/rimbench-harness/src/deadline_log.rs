//! Missed deadlines of a real-time run, from a log of its computing times.

use rimbench_core::cosim::{Channel, MOST_LATE};

/// Adds the macro steps of a log that missed the deadline D (s) to those of a channel.
///
/// ```text
/// time_s,computing_time_s      one row per macro step; a macro step that took c is late by ⌈c/D⌉ − 1 steps
/// ```
///
/// # Errors
/// Says what is wrong with the log, and in which line; what is wrong with the deadline, or that the channel has missed steps already.
pub fn replay_log(text: &str, deadline: f64, channel: &mut Channel) -> Result<(), String> {
    if !(deadline.is_finite() && deadline > 0.0) {
        return Err(format!("deadline = {deadline} s is not valid; valid: a time above 0 s"));
    }
    if !channel.missed.is_empty() {
        return Err("missed macro steps are given besides: give one of the two".to_owned());
    }
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let header = reader.headers().map_err(|error| error.to_string())?.clone();
    let place = |name: &str| {
        let found = header.iter().position(|column| column == name);
        found.ok_or_else(|| {
            format!("has no column `{name}`; valid: time_s and computing_time_s, one row per macro step")
        })
    };
    let (time, computing) = (place("time_s")?, place("computing_time_s")?);
    let mut before = f64::NEG_INFINITY;
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
        if late > f64::from(MOST_LATE) {
            return Err(format!("line {line}: computing_time_s = {computing}; valid: at most {MOST_LATE} deadlines"));
        }
        if late >= 1.0 {
            channel.missed.push((index, late as u32));
        }
    }
    Ok(())
}
