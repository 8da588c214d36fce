//! The options that determine a run as flags, shared by the commands that make runs: one flag per option of a request.

use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use rimbench::error::{Error, Result};
use rimbench::runs::{Given, OptionOf, RunOption, RunRequest};

/// Options that name one run among those that a command makes itself when it scans.
const SCANNED: [&str; 2] = ["macro_step_s", "phase"];

/// Case, scheme and everything else that determines a run; without macro step and phase where the command goes through
/// those.
#[derive(Debug, Clone, Default)]
pub struct RunOptions<const SCANS: bool, const ONE_SCHEME: bool = true> {
    /// Keys with what was given, a time in seconds.
    given: Vec<(&'static str, Given)>,
    /// Parameters of the case, each as `key=value`.
    set: Vec<String>,
}

impl<const SCANS: bool, const ONE_SCHEME: bool> RunOptions<SCANS, ONE_SCHEME> {
    /// What was asked for.
    pub(super) fn request(&self) -> Result<RunRequest> {
        let mut request = RunRequest::default();
        request.put_all(&self.given)?;
        request.set = assignments(&self.set)?;
        Ok(request)
    }

    fn options() -> impl Iterator<Item = &'static RunOption> {
        RunRequest::OPTIONS.iter().filter(|option| !(SCANS && SCANNED.contains(&option.key)))
    }
}

/// Reads parameters of the case, each as `key=value`.
pub(super) fn assignments(texts: &[String]) -> Result<Vec<(String, String)>> {
    let mut set: Vec<(String, String)> = Vec::with_capacity(texts.len());
    for assignment in texts {
        let (key, value) = assignment
            .split_once('=')
            .ok_or_else(|| Error::invalid("--set", assignment, "key=value, for example box_mass_kg=250"))?;
        let (key, value) = (key.trim().to_owned(), value.trim().to_owned());
        if let Some((_, earlier)) = set.iter().find(|(known, _)| *known == key) {
            return Err(Error::invalid("--set", assignment, format!("each key once; {key} is {earlier} already")));
        }
        set.push((key, value));
    }
    Ok(set)
}

/// The flag of an option: its key without the unit of time.
fn flag(key: &'static str) -> String {
    key.strip_suffix("_s").unwrap_or(key).replace('_', "-")
}

/// Whether an option takes a time, which may be typed with its unit.
fn is_time(option: &RunOption) -> bool {
    option.key.ends_with("_s")
}

/// What stands above options in the help.
fn heading(of: OptionOf) -> &'static str {
    match of {
        OptionOf::Run => "What is run",
        OptionOf::Scheme => "The scheme",
        OptionOf::Loop => "The macro loop: how both sides step and exchange",
        OptionOf::Model => "The interface model",
    }
}

/// The options of a request as they would be typed.
pub(super) fn typed(request: &RunRequest) -> String {
    let mut words = String::new();
    for (key, value) in request.given() {
        words += &format!(" --{} {value}", flag(key));
    }
    for (key, value) in &request.set {
        words += &format!(" --set {key}={value}");
    }
    words
}

impl<const SCANS: bool, const ONE_SCHEME: bool> Args for RunOptions<SCANS, ONE_SCHEME> {
    fn augment_args(command: Command) -> Command {
        let command = Self::options().fold(command, |command, option| {
            let arg = Arg::new(option.key).long(flag(option.key)).value_name(option.takes).help(option.about);
            let arg = if is_time(option) { arg.value_name("TIME").value_parser(seconds) } else { arg };
            let required = option.key == "case" || option.key == "scheme" && ONE_SCHEME;
            command.arg(arg.required(required).help_heading(heading(option.of)))
        });
        let help = "A parameter of the case, key=value (see `rimbench list parameters`); may be repeated";
        command.arg(
            Arg::new("set")
                .long("set")
                .value_name("KEY=VALUE")
                .action(ArgAction::Append)
                .help(help)
                .help_heading(heading(OptionOf::Run)),
        )
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<const SCANS: bool, const ONE_SCHEME: bool> FromArgMatches for RunOptions<SCANS, ONE_SCHEME> {
    fn from_arg_matches(matches: &ArgMatches) -> std::result::Result<Self, clap::Error> {
        let mut options = RunOptions::default();
        options.update_from_arg_matches(matches)?;
        Ok(options)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> std::result::Result<(), clap::Error> {
        let given = |option: &'static RunOption| {
            let value = match is_time(option) {
                true => Given::from(*matches.get_one::<f64>(option.key)?),
                false => Given::from(matches.get_one::<String>(option.key)?),
            };
            Some((option.key, value))
        };
        self.given = Self::options().filter_map(given).collect();
        self.set = matches.get_many::<String>("set").into_iter().flatten().cloned().collect();
        Ok(())
    }
}

/// Units of time that may be typed, with how many make a second.
/// The letter of micro is the sign of that name, U+00B5, or the Greek one, U+03BC.
const TIMES: [(&str, f64); 7] =
    [("ns", 1e9), ("us", 1e6), ("\u{b5}s", 1e6), ("\u{3bc}s", 1e6), ("ms", 1e3), ("min", 1.0 / 60.0), ("s", 1.0)];

/// Reads a time as it is typed, `5ms`, `200us`, `0.005` or `5e-3`; without a unit it is in seconds.
///
/// # Errors
/// A sentence that says what would be valid.
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let unit = TIMES.iter().find_map(|(unit, per_second)| Some((text.strip_suffix(unit)?, per_second)));
    let (number, per_second) = unit.unwrap_or((text, &1.0));
    // Division rounds as decimal notation does: 5ms and 0.005 are the same number.
    let value = number.trim_end().parse::<f64>().ok().map(|value| value / per_second);
    value.ok_or_else(|| "a time such as 5ms, 200us or 0.005, which is in seconds".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_with_and_without_a_unit() {
        for (text, wanted) in [
            ("5ms", 0.005),
            ("200us", 2e-4),
            ("200 \u{b5}s", 2e-4),
            ("200\u{3bc}s", 2e-4),
            ("0.005", 0.005),
            ("5e-3", 0.005),
            ("2s", 2.0),
            ("2min", 120.0),
        ] {
            assert_eq!(seconds(text), Ok(wanted), "{text}");
        }
        for text in ["fast", "5mm", "ms", "", "5 m s"] {
            assert!(seconds(text).unwrap_err().contains("5ms"), "{text}");
        }
    }
}
