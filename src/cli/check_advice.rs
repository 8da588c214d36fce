//! `rimbench advise --check`: how right an advice is, case by case.

use super::progress::Progress;
use super::screen::Table;
use rimbench::atomic_file::{check_writable_folder, write_atomically};
use rimbench::error::Result;
use rimbench::harness::{AdviceVerdict, CheckedAdvice, Choice, Question, check_advice};
use rimbench::runs::RunRequest;
use std::path::Path;

/// Columns of `advice.csv`.
const COLUMNS: [&str; 27] = [
    "case",
    "error",
    "phases",
    "kept_aside",
    "scheme",
    "form",
    "macro_step_s",
    "cost",
    "cost_one_step_on",
    "worst_error",
    "further_phases",
    "further_exceeded",
    "further_unstable",
    "further_worst_error",
    "runner_up",
    "runner_up_cost",
    "runner_up_worst_error",
    "runner_up_further_exceeded",
    "runner_up_further_unstable",
    "runner_up_further_worst_error",
    "exhaustive_scheme",
    "exhaustive_form",
    "exhaustive_macro_step_s",
    "exhaustive_cost",
    "verdict",
    "runs",
    "exhaustive_runs",
];

/// Asks a question for each of the errors, of its case or of all, each on its own `grid` of macro steps; returns what came of it in words.
///
/// # Errors
/// Those of [`check_advice`]; a folder that cannot be written.
pub(super) fn check(
    question: Question<'_>,
    errors: &[f64],
    grid: &dyn Fn(&RunRequest) -> Result<Vec<f64>>,
    further: usize,
    out: Option<&Path>,
    progress: &Progress,
) -> Result<String> {
    let names: Vec<String> = match &question.fixed.case {
        Some(name) => vec![question.catalogue.case(name)?.name.clone().into_owned()],
        None => question.catalogue.cases().iter().map(|case| case.name.clone().into_owned()).collect(),
    };
    out.map_or(Ok(()), check_writable_folder)?;
    let (mut rows, mut tally) = (Vec::new(), Tally::default());
    for (name, error) in names.iter().flat_map(|name| errors.iter().map(move |error| (name, *error))) {
        progress.about(format!("{name} {error}"));
        let fixed = RunRequest { case: Some(name.clone()), ..question.fixed.clone() };
        let macro_steps = grid(&fixed)?;
        let question = Question { fixed: &fixed, error, macro_steps: &macro_steps, ..question };
        let checked = check_advice(question, further)?;
        progress.group_done(&format!("{name} at {error}: {}", checked.verdict.name()));
        tally.take(&checked);
        rows.push(row(&question, &checked));
    }
    if let Some(folder) = out {
        write_atomically(&folder.join("advice.csv"), |file| {
            let mut writer = csv::Writer::from_writer(file);
            writer.write_record(COLUMNS)?;
            rows.iter().try_for_each(|row| writer.write_record(row))?;
            writer.flush()
        })?;
    }
    let shown = ["case", "error", "scheme", "macro_step_s", "cost", "further_exceeded", "further_unstable", "verdict"];
    let mut text = Table::new(&shown);
    for row in &rows {
        text.add_row(shown.map(|name| COLUMNS.iter().position(|column| *column == name).map_or("", |at| &row[at])));
    }
    Ok(format!("{text}\n{}", tally.said()))
}

fn row(question: &Question<'_>, checked: &CheckedAdvice) -> Vec<String> {
    let number = |value: f64| format!("{value:?}");
    let of = |choice: Option<&Choice>, say: &dyn Fn(&Choice) -> String| choice.map(say).unwrap_or_default();
    let scheme = |choice: &Choice| choice.request.scheme.clone().unwrap_or_default();
    let cost = |choice: &Choice| number(choice.cost);
    let worst = |choice: &Choice| number(choice.worst_error());
    let CheckedAdvice { advice, further, exhaustive, verdict } = checked;
    let [best, runner_up] = [advice.best.as_ref(), advice.runner_up.as_ref()];
    let looked = |nth: usize| {
        further.get(nth).map_or([(); 3].map(|()| String::new()), |further| {
            [further.exceeded.to_string(), further.unstable.to_string(), number(further.worst_error)]
        })
    };
    let mut row = vec![
        question.fixed.case.clone().unwrap_or_default(),
        number(question.error),
        question.phases.to_string(),
        question.kept_aside.to_string(),
        of(best, &scheme),
        of(best, &|choice| choice.form.clone()),
        of(best, &|choice| number(choice.macro_step)),
        of(best, &cost),
        best.and_then(|choice| choice.cost_one_step_on).map(number).unwrap_or_default(),
        of(best, &worst),
        further.first().map_or(0, |further| further.phases).to_string(),
    ];
    row.extend(looked(0));
    row.extend([of(runner_up, &scheme), of(runner_up, &cost), of(runner_up, &worst)]);
    row.extend(looked(1));
    let found = exhaustive.best.as_ref();
    row.extend([of(found, &scheme), of(found, &|choice| choice.form.clone())]);
    row.extend([of(found, &|choice| number(choice.macro_step)), of(found, &cost), verdict.name().to_owned()]);
    row.extend([advice, exhaustive].map(|advice| (advice.computed + advice.reused).to_string()));
    row
}

/// What holds for how many.
#[derive(Default)]
struct Tally {
    answers: usize,
    none: usize,
    verdicts: [usize; AdviceVerdict::NAMES.len()],
    choices: usize,
    exceeded: usize,
    unstable: usize,
}

impl Tally {
    fn take(&mut self, checked: &CheckedAdvice) {
        self.answers += 1;
        self.none += usize::from(checked.advice.best.is_none());
        let of = |verdict: AdviceVerdict| AdviceVerdict::NAMES.iter().position(|(_, known)| *known == verdict);
        if let Some(at) = of(checked.verdict) {
            self.verdicts[at] += 1;
        }
        self.choices += checked.further.len();
        self.exceeded += checked.further.iter().filter(|further| further.exceeded > 0).count();
        self.unstable += checked.further.iter().filter(|further| further.unstable > 0).count();
    }

    fn said(&self) -> String {
        let Tally { answers, none, choices, exceeded, unstable, .. } = self;
        let verdicts =
            AdviceVerdict::NAMES.iter().zip(self.verdicts).map(|((name, _), count)| format!("{name} {count}"));
        format!(
            "{answers} answers, {none} of them none. Exhaustive search: {}. At further phases, of {choices} choices: {exceeded} exceed \
             the error somewhere, {unstable} do not complete somewhere.",
            verdicts.collect::<Vec<_>>().join(", ")
        )
    }
}
