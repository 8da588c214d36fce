//! `rimbench advise`: which step, which scheme?

use super::interruption::Interruption;
use super::number::{percent, quantity, with_digits};
use super::progress::Progress;
use super::run::use_threads;
use super::run_options::{RunOptions, seconds as time, typed};
use super::screen::{Mood, command_row, headline, paragraph, row};
use super::{
    Format, INTERRUPTED, file_option, is_file_of_case, is_file_of_scheme, print, print_json, program, warn_of_cache,
    with_files,
};
use clap::Args;
use rimbench::atomic_file::{check_writable_file, write_atomically};
use rimbench::catalogue::Catalogue;
use rimbench::error::Error;
use rimbench::fmi::import::{SideNotes, master_script};
use rimbench::harness::{
    Advice, Cache, Choice, Information, METRIC, Question, USUAL_PRICES, advise, as_a_master, budget_of, prices_of,
    share_of_peak, steps_to_try,
};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `advise`.
#[derive(Debug, Args)]
pub struct Advise {
    #[command(flatten)]
    run: RunOptions<true, false>,
    /// Rms force error allowed at every phase, of the peak force of the reference: 1% or 0.01
    #[arg(long, value_name = "E", allow_hyphen_values = true, required_unless_present = "exchanges")]
    error: Option<String>,
    /// Instead of an error: so many exchanges per second of simulated time, with --mechanics-steps so many steps of the
    /// mechanics per second; what errs least?
    #[arg(long, value_name = "X", allow_hyphen_values = true, conflicts_with_all = ["error", "from", "to", "per_decade", "costs"])]
    exchanges: Option<f64>,
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
    /// Write the advice for two FMUs as a script for FMPy, where its scheme is a hold or an extrapolation
    #[arg(long, value_name = "FILE.py")]
    write_master: Option<PathBuf>,
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
        let case_file = fixed.case.clone().filter(|name| is_file_of_case(catalogue, name)).map(PathBuf::from);
        if let Some(script) = &self.write_master {
            if case_file.is_none() {
                let found = fixed.case.clone().unwrap_or_default();
                let valid = "with --write-master a case file (.toml) that names two FMUs (docs/guide/fmi.md)";
                return Err(Error::invalid("case", found, valid).into());
            }
            check_writable_file(script)?;
        }
        if let Some(file) = fixed.case.as_ref().filter(|name| is_file_of_case(catalogue, name)) {
            files += &file_option("--case-file", file.as_ref());
        }
        if let Some(file) = fixed.scheme.as_ref().filter(|name| is_file_of_scheme(name)) {
            files += &file_option("--scheme-file", file.as_ref());
        }
        let catalogue = &*with_files(catalogue, &SideNotes::default(), &mut fixed.case, &mut fixed.scheme)?;
        let (budget, macro_steps) = match self.exchanges {
            None => (None, steps_to_try(catalogue, &fixed, [self.from, self.to], self.per_decade)?),
            Some(exchanges) => {
                let (budget, macro_steps) = budget_of(catalogue, &mut fixed, exchanges)?;
                (Some(budget), macro_steps)
            }
        };
        let prices = match self.costs.as_deref() {
            None => prices_of(catalogue, &fixed)?,
            Some(&[e, m, u, l]) => [e, m, u, l],
            Some(costs) => return Err(Error::invalid("costs", format!("{costs:?}"), "four numbers: E,M,U,L").into()),
        };
        use_threads(self.jobs)?;
        let interruption = Interruption::listen(false);
        let progress = Progress::begin("advise", None);
        if catalogue.case(fixed.case.as_deref().unwrap_or_default())?.waits {
            progress.about(format!(
                "sides from outside at up to {} phases each; --phases, --duration and --scheme ask for less",
                self.phases
            ));
        }
        let cache = Cache::of_user();
        let information =
            Information { model: !self.no_model, feedback: !self.no_feedback, repetition: !self.real_time };
        let question = Question {
            catalogue,
            fixed: &fixed,
            error: self.error.as_deref().map_or(Ok(f64::INFINITY), share_of_peak)?,
            budget,
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
        let master = match (&self.write_master, &advice.advised, &case_file) {
            (Some(script), Some(choice), Some(case)) => Some(write_master(catalogue, script, choice, case)?),
            _ => None,
        };
        let command = |choice: &Choice| format!("{} simulate{}{files}", program(), typed(&choice.request));
        match self.format {
            Format::Table => print(&text(&question, &advice, master, command)?)?,
            Format::Json => print_json(&facts(&question, &advice, master, command)?)?,
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// Writes the advice as a script; says that it was written, or why it was not.
fn write_master(catalogue: &Catalogue, script: &Path, choice: &Choice, case: &Path) -> anyhow::Result<String> {
    let run = choice.request.resolve(catalogue)?;
    match master_script(case, &run, &as_a_master(&run), choice.worst_error.unwrap_or(f64::NAN)) {
        Ok(text) => {
            write_atomically(script, |file| file.write_all(text.as_bytes()))?;
            Ok(format!("written to {}; `python {0}` prints its error", script.display()))
        }
        Err(Error::Incompatible(why)) => Ok(why),
        Err(error) => Err(error.into()),
    }
}

fn text(
    question: &Question<'_>,
    advice: &Advice,
    master: Option<String>,
    command: impl Fn(&Choice) -> String,
) -> anyhow::Result<String> {
    let set: String = question.fixed.set.iter().map(|(key, value)| format!(" · {key} = {value}")).collect();
    let case = question.fixed.case.as_deref().unwrap_or_default();
    let about = match question.budget {
        None => format!("{case}{set} · rms force error at most {} of the peak", percent(question.error)),
        Some([exchanges, steps]) => format!("{case}{set} · {exchanges} exchanges, {steps} mechanics steps per second"),
    };
    let step = |choice: &Choice| with_digits(choice.macro_step_s, "s", 4);
    let error = |choice: &Choice| percent(choice.worst_error.unwrap_or(f64::NAN));
    let verdict = |choice: &Choice| (format!("{} at {}", choice.way, step(choice)), Mood::Good);
    let (verdict, mood) = advice.advised.as_ref().map_or(("none".to_owned(), Mood::Bad), verdict);
    let mut lines = vec![headline(&about, &verdict, mood)];
    if let Some(choice) = &advice.advised {
        let worst =
            if advice.phases == 1 { "phase 1".to_owned() } else { format!("the worst of {} phases", advice.phases) };
        lines.push(row(
            "advised",
            &format!("{} at {}: error {} at {worst}{}", choice.way, step(choice), error(choice), spent(choice)),
        ));
        if let Some(doubled) = &advice.doubled {
            lines.push(row("limited by", &limit(choice, doubled)));
        }
        let run = choice.request.resolve(question.catalogue)?;
        lines.push(row("as a master", &as_a_master(&run)));
        let (time, count) = (choice.time_per_macro_step_s, run.communication_points().macro_steps());
        let [time, total] = [time, count as f64 * time].map(|time| quantity(time, "s"));
        let of = choice.time_is_of;
        lines.push(row("computing time", &format!("{time} per macro step, {total} in all ({of} time)")));
    }
    if let Some((choice, advised)) = advice.runner_up.as_ref().zip(advice.advised.as_ref()) {
        let Choice { way, form, .. } = choice;
        let more = match question.budget {
            None => format!(", {} more work", percent(choice.cost / advised.cost - 1.0)),
            Some(_) => spent(choice),
        };
        let said = format!("{way}, {form}, at {}: error {}{more}", step(choice), error(choice));
        lines.push(row("runner-up", &said));
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
    lines.extend(master.map(|said| row("master", &said)));
    lines.push(format!("{} runs", advice.runs_made));
    Ok(lines.join("\n"))
}

/// What a choice spends.
fn spent(choice: &Choice) -> String {
    let [exchanges, steps] = choice.spent_per_s.map(f64::ceil);
    format!(", for {exchanges} exchanges and {steps} mechanics steps per second")
}

/// What limits the best of a budget: what twice the one or the other would come to.
fn limit(best: &Choice, doubled: &[Choice; 2]) -> String {
    let error = |choice: &Choice| choice.worst_error.unwrap_or(f64::NAN);
    let [exchanges, steps] = doubled.each_ref().map(|choice| error(choice) < 0.95 * error(best));
    let what = match (exchanges, steps) {
        (true, true) if error(&doubled[0]) < error(&doubled[1]) => "exchanges, then mechanics steps",
        (true, true) => "mechanics steps, then exchanges",
        (true, false) => "exchanges",
        (false, true) => "mechanics steps",
        (false, false) => "neither",
    };
    let said = ["exchanges", "mechanics steps"].into_iter().zip(doubled).map(|(name, choice)| {
        let Choice { form, macro_step_s, .. } = choice;
        let of = format!("{} with twice the {name}", percent(error(choice)));
        let is_other = error(choice) < error(best);
        if is_other { format!("{of} ({form}, H = {})", with_digits(*macro_step_s, "s", 4)) } else { of }
    });
    format!("{what}: {}", said.collect::<Vec<_>>().join(", "))
}

fn facts(
    question: &Question<'_>,
    advice: &Advice,
    master: Option<String>,
    command: impl Fn(&Choice) -> String,
) -> anyhow::Result<Value> {
    let mut facts = serde_json::to_value(advice)?;
    advice.advised.iter().for_each(|choice| facts["advised"]["command"] = command(choice).into());
    advice.runner_up.iter().for_each(|choice| facts["runner_up"]["command"] = command(choice).into());
    advice.finer.iter().for_each(|choice| facts["finer"]["command"] = command(choice).into());
    facts["case"] = json!(question.fixed.case);
    facts["metric"] = json!(METRIC);
    facts["error"] = json!(question.error);
    question.budget.iter().for_each(|budget| facts["budget_per_s"] = json!(budget));
    master.into_iter().for_each(|said| facts["master"] = said.into());
    facts["macro_steps_s"] = json!(question.macro_steps);
    facts["costs"] = json!(question.prices);
    Ok(facts)
}
