//! `rimbench advise`: which step, which scheme?

use super::interruption::Interruption;
use super::number::{percent, quantity, with_digits};
use super::progress::Progress;
use super::run::use_threads;
use super::run_options::{RunOptions, seconds as time, typed};
use super::screen::{Mood, command_row, headline, paragraph, row};
use super::{Format, INTERRUPTED, file_option, is_file_of_case, print, print_json, warn_of_cache, with_file};
use clap::Args;
use rimbench::catalogue::Catalogue;
use rimbench::error::Error;
use rimbench::fmi::import::SideNotes;
use rimbench::harness::{
    Advice, Cache, Choice, Information, METRIC, Question, USUAL_PRICES, advise, prices_of, share_of_peak, steps_to_try,
};
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
    /// Costs of an exchange, a mechanics step, a micro step and a model solve [default: 9,13,1,1.5; sides from outside
    /// as measured]
    #[arg(long, value_name = "E,M,U,L", value_delimiter = ',')]
    costs: Option<Vec<f64>>,
    /// Only schemes that never take a step again, at what work costs in this program
    #[arg(long)]
    real_time: bool,
    /// Only schemes that need no interface model of the mechanics
    #[arg(long)]
    no_model: bool,
    /// No force goes back to the mechanics within its own macro step, no derivative of it is known, no step is taken
    /// again
    #[arg(long)]
    no_feedback: bool,
    /// Smallest macro step that is tried, s [default: 1e-4, or a hundredth of the largest if that is less]
    #[arg(long, value_name = "TIME", value_parser = time)]
    from: Option<f64>,
    /// Largest macro step that is tried, s [default: 0.1, or a tenth of the duration if that is less]
    #[arg(long, value_name = "TIME", value_parser = time)]
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
    /// How to print
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
}

impl Advise {
    /// `files` are the options by which files of cases were given.
    pub(super) fn run(self, catalogue: &Catalogue, mut files: String) -> anyhow::Result<ExitCode> {
        let mut fixed = self.run.request()?;
        if let Some(file) = fixed.case.as_ref().filter(|name| is_file_of_case(catalogue, name)) {
            files += &file_option("--case-file", file.as_ref());
        }
        let catalogue = &*with_file(catalogue, &SideNotes::default(), &mut fixed.case)?;
        let macro_steps = steps_to_try(catalogue, &fixed, [self.from, self.to], self.per_decade)?;
        let prices = match self.costs.as_deref() {
            None => prices_of(catalogue, &fixed)?,
            Some(&[e, m, u, l]) => [e, m, u, l],
            Some(costs) => return Err(Error::invalid("costs", format!("{costs:?}"), "four numbers: E,M,U,L").into()),
        };
        use_threads(self.jobs)?;
        let interruption = Interruption::listen(false);
        let progress = Progress::begin("advise", None);
        let cache = Cache::of_user();
        let information =
            Information { model: !self.no_model, feedback: !self.no_feedback, repetition: !self.real_time };
        let question = Question {
            catalogue,
            fixed: &fixed,
            error: share_of_peak(&self.error)?,
            information,
            prices,
            macro_steps: &macro_steps,
            phases: self.phases,
            cache: &cache,
            progress: &|step| progress.after(step),
            stop: interruption.flags().soon,
        };
        let advice = advise(question);
        progress.end();
        let advice = match advice {
            Err(Error::Stopped) => return Ok(ExitCode::from(INTERRUPTED)),
            advice => advice?,
        };
        warn_of_cache(&cache);
        let command = |choice: &Choice| format!("rimbench simulate{}{files}", typed(&choice.request));
        match self.format {
            Format::Table => print(&text(&question, &advice, command))?,
            Format::Json => print_json(&facts(&question, &advice, command)?)?,
        }
        Ok(ExitCode::SUCCESS)
    }
}

fn text(question: &Question<'_>, advice: &Advice, command: impl Fn(&Choice) -> String) -> String {
    let set: String = question.fixed.set.iter().map(|(key, value)| format!(" · {key} = {value}")).collect();
    let case = question.fixed.case.as_deref().unwrap_or_default();
    let about = format!("{case}{set} · rms force error at most {} of the peak", percent(question.error));
    let usual = question.catalogue.case(case).map_or(f64::NAN, |case| case.defaults.duration_s);
    let duration_s = question.fixed.duration_s.unwrap_or(usual);
    let step = |choice: &Choice| with_digits(choice.macro_step_s, "s", 4);
    let verdict = |choice: &Choice| (format!("{} at {}", choice.scheme, step(choice)), Mood::Good);
    let (verdict, mood) = advice.advised.as_ref().map_or(("none".to_owned(), Mood::Bad), verdict);
    let mut lines = vec![headline(&about, &verdict, mood)];
    for (label, choice) in [("advised", &advice.advised), ("runner-up", &advice.runner_up)] {
        let Some(choice) = choice else { continue };
        let Choice { scheme, form, time_is_of, .. } = choice;
        lines.push(row(label, &format!("{scheme}, {form}, H = {}", step(choice))));
        let (error, cost) = (percent(choice.worst_error.unwrap_or(f64::NAN)), with_digits(choice.cost, "-", 3));
        let unit = if question.prices == USUAL_PRICES { "micro steps" } else { "units of price" };
        lines.push(row("", &format!("error {error}, worst of {} phases; cost {cost} {unit}", question.phases)));
        let time = quantity(choice.time_per_macro_step_s, "s");
        let count = (duration_s / choice.macro_step_s).ceil();
        let total = quantity(count * choice.time_per_macro_step_s, "s");
        lines.push(row("computing time", &format!("{time} per macro step, {total} in all ({time_is_of} time)")));
    }
    if let Some((advised, finer)) = advice.advised.as_ref().zip(advice.finer.as_ref()) {
        let (Choice { scheme, form, .. }, error) = (finer, percent(finer.worst_error.unwrap_or(f64::NAN)));
        let dearer = with_digits(finer.cost / advised.cost, "-", 2);
        let said = format!(
            "error {error} at {dearer} times the cost, of what was tried: {scheme}, {form}, H = {}",
            step(finer)
        );
        lines.push(row("exchange", &said));
    }
    if question.prices != USUAL_PRICES {
        let [exchange, mechanics, micro, model] = question.prices.map(|price| with_digits(price, "-", 2));
        let prices = format!("exchange {exchange}, mechanics step {mechanics}, micro step {micro}, model {model}");
        lines.push(row("prices", &format!("{prices}; unit: a micro step of the wedge box")));
    }
    lines.extend(advice.notes.iter().map(|note| format!("  {}", paragraph(note, 2))));
    lines.extend(advice.advised.as_ref().map(|choice| command_row("try it", &command(choice))));
    lines.push(format!("{} runs", advice.runs_made));
    lines.join("\n")
}

fn facts(question: &Question<'_>, advice: &Advice, command: impl Fn(&Choice) -> String) -> anyhow::Result<Value> {
    let mut facts = serde_json::to_value(advice)?;
    advice.advised.iter().for_each(|choice| facts["advised"]["command"] = command(choice).into());
    advice.runner_up.iter().for_each(|choice| facts["runner_up"]["command"] = command(choice).into());
    advice.finer.iter().for_each(|choice| facts["finer"]["command"] = command(choice).into());
    facts["case"] = json!(question.fixed.case);
    facts["metric"] = json!(METRIC);
    facts["error"] = json!(question.error);
    facts["phases"] = json!(question.phases);
    facts["macro_steps_s"] = json!(question.macro_steps);
    facts["costs"] = json!(question.prices);
    Ok(facts)
}
