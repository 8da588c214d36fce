//! `rimbench advise`: which step, which scheme?

use super::advise_text::{Asked, json};
use super::interruption::Interruption;
use super::number::seconds as time;
use super::progress::Progress;
use super::run::use_threads;
use super::run_options::RunOptions;
use super::{Format, INTERRUPTED, complain, file_option, print, with_files};
use clap::Args;
use rimbench::catalogue::Catalogue;
use rimbench::error::{Error, Result};
use rimbench::harness::{
    Budget, Cache, Information, Prices, Question, Step, advise, logarithmic_grid, longest_macro_step,
    shortest_macro_step,
};
use rimbench::runs::RunRequest;
use std::process::ExitCode;
use std::time::Duration;

/// Arguments of `advise`.
#[derive(Debug, Args)]
pub struct Advise {
    #[command(flatten)]
    run: RunOptions<true, false>,
    /// Rms force error allowed at every phase, of the peak force of the reference: 1% or 0.01
    #[arg(long, value_name = "E", allow_hyphen_values = true)]
    error: String,
    /// Cost of one exchange, in micro steps [default: as measured, 9]
    #[arg(long, value_name = "X", allow_negative_numbers = true, conflicts_with = "real_time")]
    exchanges_cost: Option<f64>,
    /// Cost of one mechanics step with its contact problem, in micro steps [default: as measured, 13]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    mechanics_cost: Option<f64>,
    /// Cost of one micro step of the actuator [default: 1]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    micro_cost: Option<f64>,
    /// Cost of one contact problem of an interface model, in micro steps [default: as measured, 1.5]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    model_cost: Option<f64>,
    /// Only schemes that never take a step again, at what work costs in this program
    #[arg(long)]
    real_time: bool,
    /// Only schemes that need no interface model of the mechanics
    #[arg(long)]
    no_model: bool,
    /// No force goes back to the mechanics within its own macro step, no derivative of it is known, no step is taken again
    #[arg(long)]
    no_feedback: bool,
    /// Smallest macro step that is tried, s [default: 1e-4, or a hundredth of the largest if that is less]
    #[arg(long, value_name = "TIME", value_parser = time, allow_negative_numbers = true)]
    from: Option<f64>,
    /// Largest macro step that is tried, s [default: 0.1, or a tenth of the duration if that is less]
    #[arg(long, value_name = "TIME", value_parser = time, allow_negative_numbers = true)]
    to: Option<f64>,
    /// Macro steps per decade
    #[arg(long, value_name = "N", default_value_t = 10)]
    per_decade: usize,
    /// Phases at which the error must be met
    #[arg(long, value_name = "K", default_value_t = 4)]
    phases: usize,
    /// Further phases that only what is advised must stand
    #[arg(long, value_name = "K", default_value_t = 28)]
    kept_aside: usize,
    /// Try every macro step at which a scheme would be cheaper, also beyond one at which it missed the error
    #[arg(long)]
    exhaustive: bool,
    /// Stop searching after so many seconds; a run under way is not ended
    #[arg(long, value_name = "TIME", value_parser = time, allow_negative_numbers = true)]
    budget: Option<f64>,
    /// Stop searching after so many runs, stored ones included
    #[arg(long, value_name = "N")]
    most_runs: Option<usize>,
    /// Number of threads [default: one per core]
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
    /// Why not the others, the runs, and what the answer rests on
    #[arg(long, conflicts_with = "format")]
    all: bool,
    /// How to print
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
}

impl Advise {
    /// `files` are the options by which files of cases were given.
    pub(super) fn run(self, catalogue: &Catalogue, mut files: String) -> anyhow::Result<ExitCode> {
        let mut fixed = self.run.request()?;
        if let Some(file) = fixed.case.as_ref().filter(|name| name.ends_with(".toml")) {
            files += &file_option("--case-file", file.as_ref());
        }
        let catalogue = &*with_files(catalogue, &mut fixed)?;
        let error = share(&self.error)?;
        let usual = Prices::default();
        let prices = Prices {
            exchange: self.exchanges_cost.unwrap_or(usual.exchange),
            mechanics_solve: self.mechanics_cost.unwrap_or(usual.mechanics_solve),
            micro_step: self.micro_cost.unwrap_or(usual.micro_step),
            model_solve: self.model_cost.unwrap_or(usual.model_solve),
        };
        let macro_steps = macro_steps(catalogue, &fixed, self.from, self.to, self.per_decade)?;
        let budget = Budget { wall: self.budget.map(seconds).transpose()?, runs: self.most_runs };
        use_threads(self.jobs)?;
        let interruption = Interruption::listen();
        let progress = Progress::begin("advise", None);
        let cache = Cache::of_user();
        let told = |step: Step| match step {
            // How many runs a search takes is known when it is done.
            Step::ToDo(_) => {}
            Step::Done(outcome) => progress.done(outcome),
        };
        let question = Question {
            catalogue,
            fixed: &fixed,
            error,
            information: Information {
                model: !self.no_model,
                feedback: !self.no_feedback,
                repetition: !self.real_time,
            },
            prices,
            macro_steps: &macro_steps,
            phases: self.phases,
            kept_aside: self.kept_aside,
            exhaustive: self.exhaustive,
            budget,
            cache: &cache,
            progress: &told,
            stop: interruption.flags().soon,
        };
        let advice = match advise(question) {
            Err(Error::Stopped) => {
                progress.end();
                print("Stopped. All runs are stored; the same command goes on from there.")?;
                return Ok(ExitCode::from(INTERRUPTED));
            }
            advice => advice?,
        };
        progress.end();
        complain(&cache);
        let asked = Asked { question: &question, advice: &advice, files: &files };
        match self.format {
            Format::Table if self.all => print(&asked.everything())?,
            Format::Table => print(&asked.first_screen())?,
            Format::Json => print(&serde_json::to_string_pretty(&json(&asked))?)?,
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Macro steps, evenly spread in logarithms, of as few digits as keep them apart.
fn macro_steps(
    catalogue: &Catalogue,
    fixed: &RunRequest,
    from: Option<f64>,
    to: Option<f64>,
    per_decade: usize,
) -> Result<Vec<f64>> {
    let case = catalogue.case(fixed.case.as_deref().unwrap_or_default())?;
    let duration = fixed.duration_s.unwrap_or(case.defaults.duration_s);
    let to = to.unwrap_or_else(|| longest_macro_step(duration));
    if to > duration {
        return Err(Error::invalid("to", to, format!("at most the duration, {duration} s")));
    }
    let steps = logarithmic_grid(from.unwrap_or_else(|| shortest_macro_step(to)), to, per_decade)?;
    let digits = if per_decade <= 12 { 1 } else { 4 };
    let mut rounded: Vec<f64> = steps
        .iter()
        .map(|step| format!("{step:.digits$e}").parse::<f64>().unwrap_or(*step).clamp(steps[0], to))
        .collect();
    rounded.dedup();
    Ok(rounded)
}

/// Reads `1%` or `0.01`; a number without the sign is below 1, because `1` may mean either.
fn share(text: &str) -> Result<f64> {
    let (number, unit) = text.trim().strip_suffix('%').map_or((text.trim(), 1.0), |number| (number.trim(), 0.01));
    let number: Option<f64> = number.parse().ok().map(|number: f64| number * unit);
    let most = if unit < 1.0 { 1.0 } else { 1.0_f64.next_down() };
    number.filter(|share| *share > 0.0 && *share <= most).ok_or_else(|| {
        let expected = "a share of the peak force above 0, as `1%` (at most `100%`) or as a number below 1, 0.01";
        Error::invalid("error", text, expected)
    })
}

/// Reads a budget.
fn seconds(seconds: f64) -> Result<Duration> {
    let wall = Duration::try_from_secs_f64(seconds).ok().filter(|wall| !wall.is_zero());
    wall.ok_or_else(|| Error::invalid("budget", seconds, "a time from 1e-9 s to 1e18 s"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_is_read_as_percent_or_number_and_nonsense_is_refused() {
        assert_eq!((share("2%").unwrap(), share(" 0.5 % ").unwrap(), share("0.02").unwrap()), (0.02, 0.005, 0.02));
        for text in ["0", "0%", "-1%", "nan", "inf", "one", "%", "", "101%", "1", "1.5"] {
            let message = share(text).unwrap_err().to_string();
            assert!(message.contains("a share of the peak force"), "{text}: {message}");
        }
    }
}
