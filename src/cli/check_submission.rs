//! `rimbench check-submission`: a third party's scheme, computed once more by us.

use super::import::{say, seed_of_clock};
use super::{complain, print};
use clap::Args;
use rimbench::BUILD;
use rimbench::catalogue::Catalogue;
use rimbench::cosim::StopFlag;
use rimbench::error::Error;
use rimbench::fmi::program::read_scheme;
use rimbench::harness::{Cache, DECLARATION, Declaration, Workplace, accept, check_package};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Arguments of `check-submission`.
#[derive(Debug, Args)]
pub struct CheckSubmission {
    /// Folder of the submission (see docs/guide/submissions.md)
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// How many runs of each package to compute once more
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    sample: u32,
    /// Chooses which; if not given, as the clock says
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Seconds that all of it may take
    #[arg(long, value_name = "SECONDS", default_value_t = 600, value_parser = clap::value_parser!(u64).range(1..))]
    limit: u64,
    /// Where to put what holds, so that it joins the ranking: results/submissions; nothing is put anywhere if not given
    #[arg(long, value_name = "DIR")]
    accept: Option<PathBuf>,
}

impl CheckSubmission {
    /// Ends with exit code 1 if anything comes out differently.
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<ExitCode> {
        // All that the program does takes of it, from its first word on.
        let over = stop_after(Duration::from_secs(self.limit));
        let declaration = Declaration::read(&self.folder, catalogue)?;
        let of_declaration = |error: Error| match error {
            error @ Error::File { .. } => error,
            error => Error::file(self.folder.join(DECLARATION), error),
        };
        declaration.check_places(&self.folder)?;
        declaration.check_patience(&self.folder)?;
        let scheme = read_scheme(&self.folder.join(&declaration.scheme))?;
        declaration.check_scheme(&scheme).map_err(of_declaration)?;
        let mut catalogue = catalogue.clone();
        catalogue.add_scheme(scheme)?;
        print(&format!(
            "{}: {} ({}); information `{}`, {}",
            declaration.name,
            declaration.about,
            declaration.authors.join("; "),
            declaration.information,
            match declaration.tuned.len() {
                0 => "nothing tuned".to_owned(),
                _ => format!("tuned on {}", declaration.tuned_on().into_iter().collect::<Vec<_>>().join(", ")),
            }
        ))?;
        let seed = self.seed.unwrap_or_else(seed_of_clock);
        let (scratch, cache) = (tempfile::tempdir()?, Cache::of_user());
        let workplace = Workplace { catalogue: &catalogue, scratch: scratch.path(), cache: &cache, build: &BUILD };
        let (mut checked, mut holds) = (Vec::new(), true);
        for name in &declaration.packages {
            let stop = StopFlag::new(&over);
            let sample = (self.sample as usize, seed);
            let package = stop
                .check()
                .map_err(|_| Error::Stopped)
                .and_then(|()| check_package((&self.folder, name), &declaration, workplace, sample, &checked, stop));
            let package = package.map_err(|error| match error {
                Error::Stopped => Error::file(
                    self.folder.join(name),
                    format!("took longer than --limit {} s: give it more, or a smaller --sample", self.limit),
                ),
                error => error,
            })?;
            print(&format!("{name}: {}, {} runs, every file as it was written", package.experiment, package.runs))?;
            if !package.changed.is_empty() {
                print(&format!("not as this program writes them from these results: {}", package.changed.join(", ")))?;
            }
            package.reruns.iter().try_for_each(say)?;
            let differ = package.reruns.iter().filter(|rerun| !rerun.differing.is_empty()).count();
            let equal = package.reruns.len() - differ;
            print(&format!(
                "{} runs computed once more (--seed {seed}): {equal} equal to the digit, {differ} not",
                package.reruns.len()
            ))?;
            holds &= package.holds();
            checked.push(package);
        }
        complain(&cache);
        if !holds {
            print("The submission does not hold.")?;
            return Ok(ExitCode::FAILURE);
        }
        match &self.accept {
            None => print("The submission holds. --accept DIR puts its rows where the ranking finds them.")?,
            Some(folder) => {
                let place = accept(&declaration, &checked, seed, folder)?;
                print(&format!("The submission holds: {}. Rank it with: rimbench rank", place.display()))?;
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// A flag that goes up by itself. The program may end before.
fn stop_after(limit: Duration) -> Arc<AtomicBool> {
    let over = Arc::new(AtomicBool::new(false));
    let raised = over.clone();
    std::thread::spawn(move || {
        std::thread::sleep(limit);
        raised.store(true, Ordering::Relaxed);
    });
    over
}
