//! `rimbench advise`: which step, which scheme?

use super::interruption::Interruption;
use super::number::{percent, quantity, with_digits};
use super::progress::Progress;
use super::run::use_threads;
use super::run_options::{RunOptions, seconds as time, typed};
use super::screen::{Mood, Table, command_row, headline, paragraph, row};
use super::{Format, INTERRUPTED, file_option, print, print_json, warn_of_cache, with_files};
use clap::Args;
use rimbench::catalogue::Catalogue;
use rimbench::error::{Error, Result};
use rimbench::fmi::import::SideNotes;
use rimbench::harness::{
    Advice, AdviceRow, Cache, Information, METRIC, Met, Probe, Question, Step, USUAL_PRICES, WORK, advise,
    logarithmic_grid, longest_macro_step, measured_prices, milliseconds, shortest_macro_step,
};
use rimbench::runs::RunRequest;
use serde_json::{Value, json};
use std::process::ExitCode;

/// Arguments of `advise`.
#[derive(Debug, Args)]
pub struct Advise {
    #[command(flatten)]
    run: RunOptions<true, false>,
    /// Rms force error allowed at every phase, of the peak force of the reference: 1% or 0.01
    #[arg(long, value_name = "E", allow_hyphen_values = true)]
    error: String,
    /// Costs of an exchange, of a mechanics step with its contact problem, of a micro step of the actuator, and of a contact problem of
    /// an interface model [default: 9,13,1,1.5; with a side from outside as measured]
    #[arg(long, value_name = "E,M,U,L", value_delimiter = ',', allow_negative_numbers = true)]
    costs: Option<Vec<f64>>,
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
    #[arg(long, value_name = "K", default_value_t = 32)]
    phases: usize,
    /// Number of threads [default: one per core]
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
    /// Why not the others
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
        let catalogue = &*with_files(catalogue, &SideNotes::default(), &mut fixed)?;
        let macro_steps = self.macro_steps(catalogue, &fixed)?;
        let four = |costs: Vec<f64>| Error::invalid("costs", format!("{costs:?}"), "four numbers: E,M,U,L");
        let asked = self.costs.clone().map(|costs| <[f64; 4]>::try_from(costs).map_err(four)).transpose()?;
        let prices = asked.map_or_else(|| prices(catalogue, &fixed), Ok)?;
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
            error: share(&self.error)?,
            information: Information {
                model: !self.no_model,
                feedback: !self.no_feedback,
                repetition: !self.real_time,
            },
            prices,
            macro_steps: &macro_steps,
            phases: self.phases,
            cache: &cache,
            progress: &told,
            stop: interruption.flags().soon,
        };
        let advice = advise(question);
        progress.end();
        let advice = match advice {
            Err(Error::Stopped) => return Ok(ExitCode::from(INTERRUPTED)),
            advice => advice?,
        };
        warn_of_cache(&cache);
        let asked = Asked { question: &question, advice: &advice, files: &files };
        match self.format {
            Format::Table => print(&asked.text(self.all))?,
            Format::Json => print_json(&asked.json())?,
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Macro steps, evenly spread in logarithms, of as few digits as keep them apart.
    fn macro_steps(&self, catalogue: &Catalogue, fixed: &RunRequest) -> Result<Vec<f64>> {
        let case = catalogue.case(fixed.case.as_deref().unwrap_or_default())?;
        let duration = fixed.duration_s.unwrap_or(case.defaults.duration_s);
        let to = self.to.unwrap_or_else(|| longest_macro_step(duration));
        if to > duration {
            return Err(Error::invalid("to", to, format!("at most the duration, {duration} s")));
        }
        let steps = logarithmic_grid(self.from.unwrap_or_else(|| shortest_macro_step(to)), to, self.per_decade)?;
        let digits = if self.per_decade <= 12 { 1 } else { 4 };
        let short = |step: &f64| format!("{step:.digits$e}").parse().unwrap_or(*step).clamp(steps[0], to);
        let mut rounded: Vec<f64> = steps.iter().map(short).collect();
        rounded.dedup();
        Ok(rounded)
    }
}

/// What work costs unless it is said: of a case of our own what is known, of sides from outside what is measured.
fn prices(catalogue: &Catalogue, fixed: &RunRequest) -> Result<[f64; 4]> {
    let case = catalogue.case(fixed.case.as_deref().unwrap_or_default())?;
    if !case.waits {
        return Ok(USUAL_PRICES);
    }
    let scheme = fixed.scheme.clone().or_else(|| Some("zero-order-hold".to_owned()));
    measured_prices(&RunRequest { scheme, ..fixed.clone() }.resolve(catalogue)?)
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

/// What was asked and what came of it.
struct Asked<'a> {
    question: &'a Question<'a>,
    advice: &'a Advice,
    files: &'a str,
}

impl Asked<'_> {
    /// The rows that are advised, each with where it meets the error.
    fn chosen(&self) -> impl Iterator<Item = (&AdviceRow, &Met)> {
        let rows = self.advice.chosen.iter().map(|&row| &self.advice.rows[row]);
        rows.filter_map(|row| Some((row, row.met.as_ref()?)))
    }

    /// The other rows.
    fn others(&self) -> impl Iterator<Item = &AdviceRow> {
        self.advice.rows.iter().enumerate().filter(|(row, _)| !self.advice.chosen.contains(row)).map(|(_, row)| row)
    }

    /// What has to be said of the answer, or why there is none.
    fn remarks(&self) -> Vec<String> {
        let Asked { question, advice, .. } = self;
        let (error, steps) = (percent(question.error), question.macro_steps);
        let [from, to] = [steps[0], steps[steps.len() - 1]].map(milliseconds);
        let mut said = Vec::new();
        match (self.chosen().next(), advice.reference_peak_n.zip(advice.reference_uncertainty)) {
            (Some((_, met)), Some((_, uncertainty))) => {
                if met.is_largest {
                    said.push(format!("{to} is the largest macro step that was tried: --to asks for larger ones."));
                }
                if 3.0 * uncertainty > question.error {
                    let uncertainty = percent(uncertainty);
                    said.push(format!("The reference is uncertain by {uncertainty} of its peak, which is much of {error}."));
                }
                if met.runs.iter().any(|run| run.model_exact) {
                    said.push("Here the model is the mechanics itself (model_exact): where it is not, expect more.".to_owned());
                }
            }
            _ if advice.rows.is_empty() && advice.refused.len() == 1 => {
                let (scheme, reason) = &advice.refused[0];
                said.push(format!("None: {scheme} does not compete: {reason}."));
            }
            (_, None) => said.push(
                "None can be told: the interface carries no force to speak of, and errors are relative to its peak.".to_owned(),
            ),
            (_, Some((_, uncertainty))) if uncertainty >= question.error => said.push(format!(
                "None can be told: the reference itself is uncertain by {} of its peak, and an error of {error} is less.",
                percent(uncertainty)
            )),
            _ => said.push(format!("None: no form of a scheme meets an error of {error} at every phase between H = {from} and {to}.")),
        }
        match advice.rows.iter().filter(|row| row.no_answer(true) && row.met.is_none()).count() {
            0 => {}
            forms => said
                .push(format!("{forms} forms took longer than the wall limit, which says nothing about their error.")),
        }
        said
    }

    /// The run of a row as it would be typed.
    fn command(&self, row: &AdviceRow, macro_step: f64, run: &Probe) -> String {
        let request = RunRequest { macro_step_s: Some(macro_step), phase: Some(run.phase), ..row.request.clone() };
        format!("rimbench simulate{}{}", typed(&request), self.files)
    }

    fn text(&self, all: bool) -> String {
        let Asked { question, advice, .. } = self;
        let set: String = question.fixed.set.iter().map(|(key, value)| format!(" · {key} = {value}")).collect();
        let case = question.fixed.case.as_deref().unwrap_or_default();
        let about = format!("{case}{set} · rms force error at most {} of the peak", percent(question.error));
        let answer = self.chosen().next().map(|(row, met)| (scheme(row), met));
        let outside = self.chosen().any(|(row, _)| row.first.case.waits);
        let mut lines = vec![match answer {
            Some((scheme, met)) => {
                headline(&about, &format!("{scheme} at {}", milliseconds(met.macro_step)), Mood::Good)
            }
            None => headline(&about, "none", Mood::Bad),
        }];
        for (label, (of, met)) in ["advised", "runner-up"].into_iter().zip(self.chosen()) {
            lines.push(row(label, &format!("{}, {}, H = {}", scheme(of), of.form(), milliseconds(met.macro_step))));
            let error = percent(met.worst().and_then(|run| run.error).unwrap_or(f64::NAN));
            let cost = with_digits(met.cost, "-", 3);
            lines.push(row("", &format!("error {error} at the worst of {} phases; cost {cost}", met.runs.len())));
        }
        let mut times = self.chosen().filter_map(|(_, met)| Some(quantity(met.time_per_step_s()?, "s")));
        if let Some(time) = times.next() {
            let other = times.next().map_or(String::new(), |time| format!(", runner-up {time}"));
            let kind = if outside { "wall time" } else { "processor time" };
            lines.push(row("computing time", &format!("{time} per macro step{other} ({kind})")));
            if question.prices != USUAL_PRICES {
                let price = |place: usize| with_digits(question.prices[place], "-", 2);
                let [exchange, mechanics, micro, model] = std::array::from_fn(price);
                let prices =
                    format!("exchange {exchange}, mechanics step {mechanics}, micro step {micro}, model {model}");
                lines.push(row("prices", &prices));
            }
        }
        lines.extend(self.remarks().iter().map(|remark| format!("  {}", paragraph(remark, 2))));
        if let Some((of, met)) = self.chosen().next()
            && let Some(run) = met.worst()
        {
            lines.push(command_row("try it", &self.command(of, met.macro_step, run)));
        }
        let rest = if all { "" } else { " · --all for the others" };
        let runs = format!("{} runs{rest}", advice.runs);
        lines.push(paragraph(&runs, 0));
        if all {
            let mut table = Table::new(&["scheme", "form", "why not", "run id"]);
            for other in self.others() {
                let id = other.missed.as_ref().and_then(|(.., run)| run.as_ref()).map_or("–", |run| &run.run_id);
                table.add_row([scheme(other), &other.form(), &other.reason(), id]);
            }
            advice.refused.iter().for_each(|(scheme, reason)| table.add_row([scheme, "–", reason, "–"]));
            lines.push(format!("\nWhy not the others\n{table}"));
        }
        lines.join("\n")
    }

    fn json(&self) -> Value {
        let Asked { question, advice, .. } = self;
        let run = |row: &AdviceRow, macro_step: f64, run: &Probe| {
            let command = self.command(row, macro_step, run);
            let outcome = run.outcome.name();
            json!({ "run_id": run.run_id, "phase": run.phase, "outcome": outcome, "error": run.error, "command": command })
        };
        let mut chosen = self.chosen().map(|(row, met)| {
            let mut choice = json!({
                "scheme": scheme(row),
                "form": row.form(),
                "macro_step_s": met.macro_step,
                "is_largest_tried": met.is_largest,
                "worst_error": met.worst().and_then(|run| run.error),
                "cost": met.cost,
                "time_per_macro_step_s": met.time_per_step_s(),
                "time_is_of": if row.first.case.waits { "wall" } else { "processor" },
                "runs": met.runs.iter().map(|of| run(row, met.macro_step, of)).collect::<Vec<_>>(),
            });
            WORK.iter().zip(met.work).for_each(|(key, count)| choice[*key] = count.into());
            choice
        });
        let (advised, runner_up) = (chosen.next(), chosen.next());
        let others = self.others().map(|row| {
            let run = row.missed.as_ref().and_then(|(step, _, missed)| Some(run(row, *step, missed.as_ref()?)));
            let cost = row.met.as_ref().map(|met| met.cost);
            json!({ "scheme": scheme(row), "form": row.form(), "reason": row.reason(), "cost": cost, "run": run })
        });
        let refused = advice.refused.iter().map(|(scheme, reason)| json!({ "scheme": scheme, "reason": reason }));
        json!({
            "case": question.fixed.case,
            "metric": METRIC,
            "error": question.error,
            "phases": question.phases,
            "macro_steps_s": question.macro_steps,
            "costs": question.prices,
            "reference_peak_n": advice.reference_peak_n,
            "reference_uncertainty_of_peak": advice.reference_uncertainty,
            "advised": advised,
            "runner_up": runner_up,
            "fallen": others.chain(refused).collect::<Vec<_>>(),
            "runs_made": advice.runs,
            "notes": self.remarks(),
        })
    }
}

fn scheme(row: &AdviceRow) -> &str {
    row.request.scheme.as_deref().unwrap_or_default()
}

#[test]
fn a_share_is_read_as_percent_or_number_and_nonsense_is_refused() {
    assert_eq!((share("2%").unwrap(), share(" 0.5 % ").unwrap(), share("0.02").unwrap()), (0.02, 0.005, 0.02));
    for text in ["0", "0%", "-1%", "nan", "inf", "one", "%", "", "101%", "1", "1.5"] {
        let message = share(text).unwrap_err().to_string();
        assert!(message.contains("a share of the peak force"), "{text}: {message}");
    }
}
