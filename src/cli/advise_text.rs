//! An advice in words and as JSON.

use super::json::Object;
use super::number::{percent, with_digits};
use super::run_options::typed;
use super::screen::{Mood, Table, command_row, headline, paragraph, row};
use rimbench::harness::{Advice, Choice, Fallen, METRIC, Prices, Probe, Question, milliseconds};
use rimbench::runs::RunRequest;
use serde_json::Value;
use std::collections::BTreeMap;

/// What was asked and what came of it.
pub(super) struct Asked<'a> {
    pub(super) question: &'a Question<'a>,
    pub(super) advice: &'a Advice,
    /// Options that name the files of cases and schemes, as they are typed.
    pub(super) files: &'a str,
}

impl Asked<'_> {
    /// The answer in a sentence; why there is none, where there is none.
    fn headline(&self) -> String {
        let Asked { question, advice, .. } = self;
        let error = percent(question.error);
        if let Some(best) = &advice.best {
            let scheme = best.request.scheme.as_deref().unwrap_or_default();
            let advised = format!("`{scheme}` ({}) at H = {}", best.form, milliseconds(best.macro_step));
            return match advice.open {
                0 => format!("Take {advised}."),
                open => format!("Best found within the budget: {advised}; {open} forms are open."),
            };
        }
        if let (Some(_), [only]) = (&question.fixed.scheme, advice.fallen.as_slice())
            && only.request.is_none()
        {
            return format!("None: `{}` does not compete: {}.", only.scheme, only.reason);
        }
        if let Some(uncertainty) = advice.reference_uncertainty.filter(|own| *own >= question.error) {
            return format!(
                "None can be told: the reference itself is uncertain by {} of its peak, and an error of {error} is less.",
                percent(uncertainty)
            );
        }
        if advice.open > 0 {
            return format!("None found before the budget was spent: {} forms are open.", advice.open);
        }
        if advice.timed_out > 0 {
            return format!(
                "None found: {} forms took longer than the wall limit, which says nothing about their error.",
                advice.timed_out
            );
        }
        let [from, to] = [question.macro_steps.first(), question.macro_steps.last()]
            .map(|step| step.copied().map_or_else(String::new, milliseconds));
        format!("None: no scheme in any form meets an error of {error} at every phase between H = {from} and {to}.")
    }

    /// What the numbers rest on.
    fn grounds(&self) -> Vec<String> {
        let Asked { question, advice, .. } = self;
        let Question { phases, kept_aside, macro_steps, prices, .. } = question;
        let mut grounds = vec![format!(
            "The error is the rms of the interface force over communication points, relative to the peak force of the reference \
             (`{METRIC}`), the largest over {phases} phases; what is advised also stood {kept_aside} phases kept aside."
        )];
        if let (Some(peak), Some(uncertainty)) = (advice.reference_peak_n, advice.reference_uncertainty) {
            let mut said =
                format!("The reference has a peak of {peak:.4} N and is uncertain by {} of it", percent(uncertainty));
            if 3.0 * uncertainty > question.error {
                said += ": more than a third of the error asked for, so take the advice with care";
            }
            grounds.push(said + ".");
        }
        let [exchange, mechanics, micro, model] = prices.list();
        grounds.push(format!(
            "Cost = {exchange} × exchanges + {mechanics} × mechanics solves + {micro} × micro steps + {model} × model solves. By \
             default these are instructions of the wedge box over those of a micro step."
        ));
        if let [first, .., last] = macro_steps {
            grounds.push(format!(
                "{} macro steps were open, a factor of {:.2} apart; options and gains are the schemes' own.",
                macro_steps.len(),
                (last / first).powf(1.0 / (macro_steps.len() - 1) as f64)
            ));
        }
        if [&advice.best, &advice.runner_up]
            .into_iter()
            .flatten()
            .any(|choice| choice.runs.iter().any(|run| run.model_exact))
        {
            grounds.push(
                "Here the model is the mechanics itself (`model_exact`): of a mechanics that it only approximates, expect more."
                    .to_owned(),
            );
        }
        if advice.open > 0 {
            grounds.push(format!(
                "The budget was spent before the search was done: {} forms are open, and one of them may be cheaper.",
                advice.open
            ));
        }
        if advice.timed_out > 0 {
            grounds.push(format!(
                "{} forms took longer than the wall limit: nothing is known of them, and one of them may be cheaper.",
                advice.timed_out
            ));
        }
        grounds.push(format!("{} runs were made, {} were stored.", advice.computed, advice.reused));
        grounds
    }

    fn limit(&self, choice: &Choice) -> String {
        let factor = choice.limit.last_stable / choice.macro_step;
        match (choice.limit.first_unstable, &choice.limit.failure) {
            (Some(unstable), Some(failure)) => format!(
                "stable up to {} ({factor:.1} times H); at {}: {failure}",
                milliseconds(choice.limit.last_stable),
                milliseconds(unstable)
            ),
            _ => format!(
                "stable up to {}, the largest tried ({factor:.1} times H)",
                milliseconds(choice.limit.last_stable)
            ),
        }
    }

    /// The command that looks for the limit more closely.
    fn limit_command(&self, choice: &Choice) -> String {
        let request = RunRequest { macro_step_s: None, phase: None, ..choice.request.clone() };
        let to = choice.limit.first_unstable.unwrap_or(choice.limit.last_stable);
        let phases = self.question.phases;
        format!(
            "rimbench limit{}{} --from {:?} --to {to:?} --phases {phases}",
            typed(&request),
            self.files,
            choice.macro_step
        )
    }
}

/// The run of a choice as it would be typed; `files` are options that name files.
fn command(request: &RunRequest, run: &Probe, files: &str) -> String {
    let (macro_step_s, phase) = (Some(run.macro_step), Some(run.phase));
    format!("rimbench simulate{}{files}", typed(&RunRequest { macro_step_s, phase, ..request.clone() }))
}

impl Asked<'_> {
    /// What was asked, and whether there is an answer.
    fn title(&self) -> String {
        let case = self.question.fixed.case.as_deref().unwrap_or_default();
        let set: String = self.question.fixed.set.iter().map(|(key, value)| format!(" · {key} = {value}")).collect();
        let verdict = match &self.advice.best {
            Some(best) => {
                let scheme = best.request.scheme.as_deref().unwrap_or_default();
                let mood = if self.advice.open == 0 { Mood::Good } else { Mood::Open };
                (format!("{scheme} at {}", milliseconds(best.macro_step)), mood)
            }
            None => ("none".to_owned(), Mood::Bad),
        };
        let about = format!("{case}{set} · rms force error at most {} of the peak", percent(self.question.error));
        headline(&about, &verdict.0, verdict.1)
    }

    /// The advice, its error and cost, the runner-up and the command to run.
    pub(super) fn first_screen(&self) -> String {
        let mut lines = vec![self.title()];
        if self.advice.best.is_none() || self.advice.open > 0 {
            lines.push(format!("  {}", paragraph(&self.headline().replace('`', ""), 2)));
        }
        for (label, choice) in [("advised", &self.advice.best), ("runner-up", &self.advice.runner_up)] {
            let Some(choice) = choice else { continue };
            let scheme = choice.request.scheme.as_deref().unwrap_or_default();
            lines.push(row(label, &format!("{scheme}, {}, H = {}", choice.form, milliseconds(choice.macro_step))));
            let phases = choice.runs.len() + choice.kept_aside.len();
            let numbers = format!(
                "error {} at the worst of {phases} phases; cost {}",
                percent(choice.worst_error()),
                with_digits(choice.cost, "-", 3)
            );
            lines.push(row("", &numbers));
            if label == "advised" {
                let stable = milliseconds(choice.limit.last_stable);
                let unstable = choice.limit.first_unstable.map(|step| format!(", unstable at {}", milliseconds(step)));
                lines.push(row("", &format!("stable up to {stable}{}", unstable.unwrap_or_default())));
            }
        }
        if let Some(best) = &self.advice.best
            && let Some(run) = dearest(best)
        {
            lines.push(command_row("try it", &command(&best.request, run, self.files)));
        }
        let runs = self.advice.computed + self.advice.reused;
        lines.push(paragraph(
            &format!("{runs} runs of this one machine · --all for the others, the runs and their prices"),
            0,
        ));
        lines.join("\n")
    }

    /// The first screen, and everything else for reading.
    pub(super) fn everything(&self) -> String {
        let Asked { advice, .. } = self;
        let mut parts = vec![self.first_screen()];
        if advice.best.is_some() {
            parts.push(self.side_by_side());
        }
        for (name, choice) in [("Advised", &advice.best), ("Runner-up", &advice.runner_up)] {
            let Some(choice) = choice else { continue };
            let mut table = Table::new(&["run id", "phase", "error"]);
            for run in choice.runs.iter().chain(&choice.kept_aside) {
                let error = run.error.map_or_else(|| "–".to_owned(), percent);
                table.add_row([run.run_id.clone(), format!("{:.4}", run.phase), error]);
            }
            let again = dearest(choice).map(|run| command(&choice.request, run, self.files)).unwrap_or_default();
            let [again, limit] = [again, self.limit_command(choice)].map(|text| command_row("", &text));
            parts.push(format!("{name}: runs\n{table}\n{again}\n{limit}"));
        }
        let mut table = Table::new(&["scheme", "form", "why not", "run id"]);
        for fallen in nearest(&advice.fallen) {
            let id = fallen.run.as_ref().map_or("–", |run| &run.run_id);
            let form = if fallen.form.is_empty() { "–" } else { &fallen.form };
            table.add_row([&fallen.scheme, form, &fallen.reason, id]);
        }
        let others = "Why not the others: of each scheme the form that came nearest; all are in the JSON.";
        parts.push(format!("{}\n{table}", paragraph(others, 0)));
        let grounds = self.grounds().iter().map(|ground| format!("- {}", paragraph(ground, 2))).collect::<Vec<_>>();
        parts.push(format!("What this rests on\n{}", grounds.join("\n")));
        parts.join("\n\n")
    }

    /// What is advised beside the runner-up.
    fn side_by_side(&self) -> String {
        let choices = [&self.advice.best, &self.advice.runner_up];
        let mut table = Table::new(&["", "advised", "runner-up"]);
        let mut row = |name: &str, of: &dyn Fn(&Choice) -> String| {
            let [best, other] = choices.map(|choice| choice.as_ref().map_or_else(|| "none".to_owned(), of));
            table.add_row([name.to_owned(), best, other]);
        };
        row("scheme", &|choice| choice.request.scheme.clone().unwrap_or_default());
        row("form", &|choice| choice.form.clone());
        row("H", &|choice| milliseconds(choice.macro_step));
        row("error, worst phase", &|choice| percent(worst(&choice.runs)));
        row("error, phases kept aside", &|choice| percent(worst(&choice.kept_aside)));
        row("cost", &|choice| format!("{:.0}", choice.cost));
        for (kind, name) in Prices::NAMES.iter().enumerate() {
            row(&format!("{name}s"), &|choice| choice.work.counts()[kind].to_string());
        }
        row("stability", &|choice| self.limit(choice));
        if choices.iter().any(|choice| choice.as_ref().is_some_and(|choice| choice.spectral_radius.is_some())) {
            row("spectral radius", &|choice| {
                choice.spectral_radius.map_or_else(|| "–".to_owned(), |radius| format!("{radius:.6}"))
            });
        }
        table.to_string()
    }
}

/// The run with the largest error.
fn dearest(choice: &Choice) -> Option<&Probe> {
    let error = |run: &&Probe| run.error.unwrap_or(0.0);
    choice.runs.iter().chain(&choice.kept_aside).max_by(|a, b| error(a).total_cmp(&error(b)))
}

/// Of each scheme the form that came nearest: the cheapest that meets the error, else that with the least error.
fn nearest(fallen: &[Fallen]) -> Vec<&Fallen> {
    let key = |fallen: &Fallen| {
        let error = fallen.run.as_ref().filter(|run| run.completed()).and_then(|run| run.error);
        (fallen.cost.unwrap_or(f64::INFINITY), error.unwrap_or(f64::INFINITY))
    };
    let mut places: BTreeMap<&str, usize> = BTreeMap::new();
    let mut nearest: Vec<&Fallen> = Vec::new();
    for fallen in fallen {
        let place = *places.entry(&fallen.scheme).or_insert(nearest.len());
        match nearest.get_mut(place) {
            Some(known) if key(fallen) < key(known) => *known = fallen,
            Some(_) => {}
            None => nearest.push(fallen),
        }
    }
    nearest
}

/// Writes an advice for programs.
pub(super) fn json(asked: &Asked<'_>) -> Value {
    let Asked { question, advice, .. } = asked;
    let mut object = Object::default();
    object.put("case", question.fixed.case.clone());
    object.put("set", question.fixed.set.iter().map(|(key, value)| format!("{key}={value}")).collect::<Vec<_>>());
    object.put("metric", METRIC);
    object.number("error", question.error);
    object.put("phases", question.phases);
    object.put("kept_aside_phases", question.kept_aside);
    object.put("macro_steps_s", question.macro_steps);
    object.put("costs", prices_json(&question.prices));
    object.number("reference_peak_n", advice.reference_peak_n);
    object.number("reference_uncertainty_of_peak", advice.reference_uncertainty);
    object.put("answer", asked.headline());
    for (key, choice) in [("advised", &advice.best), ("runner_up", &advice.runner_up)] {
        object.put(key, choice.as_ref().map_or(Value::Null, |choice| choice_json(asked, choice)));
    }
    object.put("fallen", advice.fallen.iter().map(|fallen| fallen_json(fallen, asked.files)).collect::<Vec<_>>());
    object.put("open_forms", advice.open);
    object.put("timed_out_forms", advice.timed_out);
    object.put("runs_made", advice.computed);
    object.put("runs_stored", advice.reused);
    object.put("notes", asked.grounds());
    object.into()
}

fn choice_json(asked: &Asked<'_>, choice: &Choice) -> Value {
    let mut object = Object::default();
    object.put("scheme", choice.request.scheme.clone());
    object.put("form", choice.form.clone());
    object.number("macro_step_s", choice.macro_step);
    object.number("worst_error", choice.worst_error());
    object.number("cost", choice.cost);
    object.number("cost_one_step_on", choice.cost_one_step_on);
    for (key, count) in
        ["exchanges", "mechanics_solves", "micro_steps", "model_solves"].iter().zip(choice.work.counts())
    {
        object.number(*key, count);
    }
    object.number("last_stable_s", choice.limit.last_stable);
    object.number("first_unstable_s", choice.limit.first_unstable);
    object.put("failure_there", choice.limit.failure.clone());
    object.put("run_there", choice.limit.run_id.clone());
    object.number("spectral_radius", choice.spectral_radius);
    object.put("limit_command", asked.limit_command(choice));
    let runs =
        |runs: &[Probe]| runs.iter().map(|run| probe_json(&choice.request, run, asked.files)).collect::<Vec<_>>();
    object.put("runs", runs(&choice.runs));
    object.put("kept_aside", runs(&choice.kept_aside));
    object.into()
}

fn probe_json(request: &RunRequest, run: &Probe, files: &str) -> Value {
    let mut object = Object::default();
    object.put("run_id", run.run_id.as_str());
    object.number("macro_step_s", run.macro_step);
    object.number("phase", run.phase);
    object.put("outcome", run.outcome.as_str());
    object.number("error", run.error);
    object.put("command", command(request, run, files));
    object.into()
}

fn fallen_json(fallen: &Fallen, files: &str) -> Value {
    let mut object = Object::default();
    object.put("scheme", fallen.scheme.as_str());
    object.put("form", fallen.form.as_str());
    object.put("reason", fallen.reason.as_str());
    object.number("cost", fallen.cost);
    let run = fallen.request.as_ref().zip(fallen.run.as_ref()).map(|(request, run)| probe_json(request, run, files));
    object.put("run", run.unwrap_or(Value::Null));
    object.into()
}

pub(super) fn prices_json(prices: &Prices) -> Value {
    let mut object = Object::default();
    for (name, price) in Prices::NAMES.iter().zip(prices.list()) {
        object.number(name.replace(' ', "_"), price);
    }
    object.into()
}

fn worst(runs: &[Probe]) -> f64 {
    runs.iter().filter_map(|run| run.error).fold(0.0, f64::max)
}
