//! `rimbench limit`: the largest stable macro step.

use super::run_options::{RunOptions, resolved};
use super::{Format, complain, json_number, print, table};
use clap::{Args, ValueEnum};
use rimbench::catalogue::Catalogue;
use rimbench::error::Error;
use rimbench::harness::{
    Cache, StabilityLimit, logarithmic_grid, phase_ensemble, spectral_stability_limit, stability_limit,
};
use rimbench::runs::RunRequest;
use serde_json::{Map, Value, json};

/// Arguments of `limit`.
#[derive(Debug, Args)]
pub struct Limit {
    #[command(flatten)]
    run: RunOptions<true>,
    /// Smallest macro step of the scan, s
    #[arg(long, value_name = "S", default_value_t = 1e-4, allow_negative_numbers = true)]
    from: f64,
    /// Largest macro step of the scan, s
    #[arg(long, value_name = "S", default_value_t = 0.1, allow_negative_numbers = true)]
    to: f64,
    /// Macro steps per decade of the scan
    #[arg(long, value_name = "N", default_value_t = 12)]
    per_decade: usize,
    /// Number of phases of the ensemble; a macro step is stable if all of them are
    #[arg(long, value_name = "K", default_value_t = 1)]
    phases: usize,
    /// Run to the end, or take the spectral radius of the macro-step map (linear cases)
    #[arg(long, value_enum, default_value_t = Method::Run)]
    method: Method,
    /// How to print
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
}

/// How stability is judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Method {
    /// A run must complete within bounds.
    Run,
    /// The spectral radius must not exceed one.
    Spectral,
}

impl Limit {
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<()> {
        if !(1..=10_000).contains(&self.phases) {
            return Err(Error::invalid("phases", self.phases, "a whole number from 1 to 10000").into());
        }
        let grid = logarithmic_grid(self.from, self.to, self.per_decade)?;
        // The coarsest macro step must fit into the duration.
        let request = RunRequest { macro_step_s: Some(self.to), ..self.run.request()? };
        let coarsest = resolved(&request, catalogue)?;
        let fixed_micro_step = request.micro_step_s.is_some();
        let found = match self.method {
            Method::Run => {
                let phases = phase_ensemble(self.phases);
                let cache = Cache::of_user();
                let found = stability_limit(&coarsest, &grid, &phases, fixed_micro_step, &cache)?;
                complain(&cache);
                found
            }
            Method::Spectral => spectral_stability_limit(&coarsest, &grid, fixed_micro_step)?,
        };
        match self.format {
            Format::Json => print(&serde_json::to_string_pretty(&facts(&found))?),
            Format::Table => print_table(&found),
        }
    }
}

fn facts(found: &StabilityLimit) -> Value {
    let optional = |step: Option<f64>| step.map_or(Value::Null, json_number);
    let fractions = found.points.iter().map(|point| {
        json!({
            "macro_step_s": point.macro_step,
            "fraction_stable": point.fraction_stable,
            "failure": point.failure,
            "spectral_radius": point.spectral_radius,
        })
    });
    let mut facts = Map::new();
    facts.insert("stability_limit_s".into(), optional(found.last_stable.filter(|_| found.first_unstable.is_some())));
    facts.insert("last_stable_s".into(), optional(found.last_stable));
    facts.insert("first_unstable_s".into(), optional(found.first_unstable));
    facts.insert("fraction_stable".into(), fractions.collect());
    Value::Object(facts)
}

fn print_table(found: &StabilityLimit) -> anyhow::Result<()> {
    let mut table = table(&["H (ms)", "fraction stable", "first failure"]);
    for point in &found.points {
        let failure = point.failure.clone().unwrap_or_default();
        table.add_row([format!("{:.4}", point.macro_step * 1e3), format!("{:.3}", point.fraction_stable), failure]);
    }
    print(&table.to_string())?;
    print(&match (found.last_stable, found.first_unstable) {
        (Some(stable), Some(unstable)) => {
            format!("Stability limit: stable up to {:.4} ms, first unstable at {:.4} ms", stable * 1e3, unstable * 1e3)
        }
        (Some(stable), None) => format!("Stable over the whole scan, up to {:.4} ms", stable * 1e3),
        (None, _) => "Unstable from the smallest macro step of the scan on".to_owned(),
    })
}
