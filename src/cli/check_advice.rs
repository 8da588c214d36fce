//! `rimbench check-advice`: how right `advise` is, case by case.

use super::advise::{macro_steps, share};
use super::interruption::Interruption;
use super::progress::Progress;
use super::run::use_threads;
use super::{INTERRUPTED, complain, print, table};
use clap::Args;
use rimbench::atomic_file::{check_writable_folder, write_atomically};
use rimbench::catalogue::Catalogue;
use rimbench::cosim::Outcome;
use rimbench::error::{Error, Result};
use rimbench::harness::{
    AdviceVerdict, Budget, Cache, CheckedAdvice, Choice, Information, Prices, Question, Step, check_advice,
};
use rimbench::runs::RunRequest;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `check-advice`.
#[derive(Debug, Args)]
pub struct CheckAdvice {
    /// Only this case; may be repeated [default: all]
    #[arg(long, value_name = "NAME")]
    case: Vec<String>,
    /// Error to ask for, as `advise` takes it; may be repeated
    #[arg(long, value_name = "E", default_values_t = ["1%".to_owned(), "5%".to_owned()])]
    error: Vec<String>,
    /// Phases at which the error must be met
    #[arg(long, value_name = "K", default_value_t = 4)]
    phases: usize,
    /// Further phases that what is advised must stand
    #[arg(long, value_name = "K", default_value_t = 28)]
    kept_aside: usize,
    /// Phases behind those, which no search sees
    #[arg(long, value_name = "K", default_value_t = 16, value_parser = clap::value_parser!(u16).range(1..=1000))]
    further: u16,
    /// Write advice.csv to a folder; the same everywhere
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Number of threads [default: one per core]
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
}

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

impl CheckAdvice {
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<ExitCode> {
        let errors = self.error.iter().map(|error| share(error)).collect::<Result<Vec<f64>>>()?;
        let names: Vec<String> = match self.case.as_slice() {
            [] => catalogue.cases().iter().map(|case| case.name.clone().into_owned()).collect(),
            named => {
                named.iter().map(|name| Ok(catalogue.case(name)?.name.clone().into_owned())).collect::<Result<_>>()?
            }
        };
        self.out.as_deref().map_or(Ok(()), check_writable_folder)?;
        use_threads(self.jobs)?;
        let interruption = Interruption::listen();
        let progress = Progress::begin("check-advice", 0);
        let cache = Cache::of_user();
        let told = |step: Step<'_>| match step {
            Step::ToDo(count) => progress.to_do(count),
            Step::Done(outcome) => progress.done(*outcome == Outcome::Completed),
        };
        let mut rows = Vec::new();
        let mut tally = Tally::default();
        for (name, error) in names.iter().flat_map(|name| errors.iter().map(move |error| (name, *error))) {
            progress.about(format!("{name} {error}"));
            let fixed = RunRequest { case: Some(name.clone()), ..RunRequest::default() };
            let grid = macro_steps(catalogue, &fixed, None, None, 10)?;
            let question = Question {
                catalogue,
                fixed: &fixed,
                error,
                information: Information::default(),
                prices: Prices::default(),
                macro_steps: &grid,
                phases: self.phases,
                kept_aside: self.kept_aside,
                exhaustive: false,
                budget: Budget::default(),
                cache: &cache,
                progress: &told,
                stop: interruption.flags().soon,
            };
            let checked = match check_advice(question, self.further.into()) {
                Err(Error::Stopped) => {
                    progress.end();
                    print("Stopped. All runs are stored; the same command goes on from there.")?;
                    return Ok(ExitCode::from(INTERRUPTED));
                }
                checked => checked?,
            };
            progress.group_done(&format!("{name} at {error}: {}", checked.verdict.name()));
            tally.take(&checked);
            rows.push(row(&question, &checked));
        }
        progress.end();
        complain(&cache);
        if let Some(folder) = &self.out {
            write_atomically(&folder.join("advice.csv"), |file| {
                let mut writer = csv::Writer::from_writer(file);
                writer.write_record(COLUMNS)?;
                rows.iter().try_for_each(|row| writer.write_record(row))?;
                writer.flush()
            })?;
        }
        let shown =
            ["case", "error", "scheme", "macro_step_s", "cost", "further_exceeded", "further_unstable", "verdict"];
        let mut text = table(&shown);
        for row in &rows {
            text.add_row(shown.map(|name| COLUMNS.iter().position(|column| *column == name).map_or("", |at| &row[at])));
        }
        print(&format!("{text}\n{}", tally.said()))?;
        Ok(ExitCode::SUCCESS)
    }
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
