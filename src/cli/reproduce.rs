//! `rimbench reproduce`: the main job. Experiments, results, figures, claims, report, from nothing, or from rows that
//! this very program has stored.

use super::everything::{Kept, everything, write_both};
use super::progress::Progress;
use super::project::Project;
use super::report::write_page;
use super::screen::paragraph;
use super::summary::count_not_completed;
use super::{claims_list, print, warn_of_cache};
use clap::Args;
use rayon::prelude::*;
use rimbench::BUILD;
use rimbench::atomic_file::check_writable_folder;
use rimbench::catalogue::Catalogue;
use rimbench::cosim::StopFlag;
use rimbench::error::Result;
use rimbench::figures::style::Styles;
use rimbench::harness::{Cache, CheckedClaim, Job, Verdict, check_fresh_claims, claims_score, run_job};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// The group of experiments that this command runs.
const GROUP: &str = "paper";

/// Arguments of `reproduce`.
#[derive(Debug, Args)]
pub struct Reproduce {
    /// Folder for results [default: results, or results/quick with --quick]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Fewer phases and macro steps
    #[arg(long)]
    quick: bool,
    /// Make runs again that this very program has stored in the folder
    #[arg(long, conflicts_with = "everything")]
    fresh: bool,
    /// All experiments, figures, tables and pages instead of the paper's, resuming what is stored, held against what is
    /// kept
    #[arg(long, conflicts_with = "quick")]
    everything: bool,
    /// With --everything: only this experiment, for example study/friction; may be given several times
    #[arg(long, value_name = "GROUP/NAME", requires = "everything", conflicts_with_all = ["quick", "fresh"])]
    only: Vec<String>,
}

impl Reproduce {
    /// Exit code 1 if something that is kept came out otherwise.
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<ExitCode> {
        if self.everything {
            return everything(catalogue, &self.out.unwrap_or_else(|| PathBuf::from("results")), &self.only);
        }
        let started = Instant::now();
        let default = if self.quick { "results/quick" } else { "results" };
        let out = self.out.unwrap_or_else(|| PathBuf::from(default));
        let project = Project::find();
        let (experiments, figures) = (project.experiments(GROUP)?, project.figures()?);
        let runs = experiments.iter().map(|experiment| Ok(experiment.plan(catalogue, self.quick)?.len()));
        let total: usize = runs.sum::<Result<usize>>()?;
        check_writable_folder(&out)?;

        let drawn = figures.of_part(Some(GROUP));
        let kept = Kept::look(&out, &experiments, &drawn, &[], (true, false)).there();
        let progress = Progress::begin("reproduce", Some(total));
        let group = out.join(GROUP);
        let cache = Cache::of_user();
        let mut claims: Vec<CheckedClaim> = Vec::new();
        let mut not_completed = 0;
        for experiment in &experiments {
            progress.about(experiment.name());
            let folder = group.join(experiment.name());
            let (quick, fresh) = (self.quick, self.fresh);
            let job = Job::new(experiment, catalogue, &folder, &cache, &BUILD);
            let job = Job { quick, fresh, of_this_program: true, ..job };
            let summary = run_job(job, &|step| progress.after(step), StopFlag::never())?;
            not_completed += count_not_completed(&folder)?;
            progress.group_done(&format!(
                "{}: {} runs computed, {} of them did not complete, as data; {} were stored by this program",
                experiment.name(),
                summary.computed,
                summary.not_completed,
                summary.reused
            ));
            claims.extend(check_fresh_claims(experiment, catalogue, &folder)?);
        }
        progress.about("drawing figures");
        write_both(&group, &claims)?;
        let styles = Styles::of(catalogue.schemes().iter().map(|scheme| &**scheme));
        drawn.par_iter().try_for_each(|figure| figure.make(&out, &styles).map(drop))?;
        let (page, ..) = write_page(catalogue, &group)?;
        progress.end();
        warn_of_cache(&cache);

        let open = |claim: &&CheckedClaim| claim.superseded.is_empty() && claim.verdict != Verdict::Reproduced;
        let listed: Vec<CheckedClaim> = claims.iter().filter(open).cloned().collect();
        let all = claims.iter().filter(|claim| claim.counts()).count();
        let main = listed.iter().filter(|claim| claim.counts()).count();
        if !listed.is_empty() {
            let variants =
                if main < listed.len() { format!(", {} with variants", listed.len()) } else { String::new() };
            print(&paragraph(&format!("{main} of {all} claims do not reproduce{variants}:"), 0))?;
        }
        print(&claims_list(&listed))?;
        let remade = kept.remade();
        if remade.files > 0 {
            remade.differing.iter().try_for_each(|sentence| print(sentence))?;
            let same = remade.files - remade.differing.len();
            let said = "kept files came out to the byte, the page but for its line with day, commit and machine";
            print(&paragraph(&format!("{same} of {} {said}", remade.files), 0))?;
        }
        let said = format!(
            "{}. {total} runs ({not_completed} of them did not complete, as data) in {:.1} s.",
            claims_score(claims.iter()),
            started.elapsed().as_secs_f64(),
        );
        print(&paragraph(&said, 0))?;
        print(&format!("Report: {}", page.display()))?;
        Ok(if remade.differing.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
    }
}
