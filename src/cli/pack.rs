//! `rimbench pack`: a problem as a folder that others take part with, without this program.

use super::project::Project;
use super::run_options::{assignments, seconds};
use super::screen::paragraph;
use super::{print, warn_of_cache};
use clap::Args;
use rimbench::atomic_file::{check_writable_folder, write_atomically};
use rimbench::catalogue::Catalogue;
use rimbench::cosim::{Side, StopFlag};
use rimbench::error::Error;
use rimbench::fmi::export::{Fmi, find_library, pack, side_name, system_structure, zipped};
use rimbench::harness::{Cache, PROBLEMS, Problem, obtain_reference, pack_files};
use rimbench::runs::{RunRequest, RunSpec};
use std::path::{Path, PathBuf};

/// Arguments of `pack`.
#[derive(Debug, Args)]
pub struct Pack {
    /// Case by name (see `rimbench list cases`)
    #[arg(long, value_name = "NAME", required_unless_present = "ranking", conflicts_with = "ranking")]
    case: Option<String>,
    /// All problems of the ranking, each in a folder of its own, and problems.csv with what the ranking asks of them
    #[arg(long, conflicts_with_all = ["set", "duration"])]
    ranking: bool,
    /// A parameter of the case, key=value (see `rimbench list parameters`); may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Simulated time
    #[arg(long, value_name = "TIME", value_parser = seconds)]
    duration: Option<f64>,
    /// Folder to be written; FOLDER.zip beside it has all of it but FMUs
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// Write no FMUs: they need the library beside this program
    #[arg(long)]
    no_fmus: bool,
    /// The library that goes into FMUs [default: that beside this program]
    #[arg(long, value_name = "FILE", conflicts_with = "no_fmus")]
    library: Option<PathBuf>,
}

impl Pack {
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<()> {
        let mut ranked: Vec<RunSpec> = Vec::new();
        for file in Project::find().ranking()?.experiments() {
            ranked.extend(Project::experiment(&file)?.problems(catalogue)?);
        }
        let mut wanted: Vec<(PathBuf, RunSpec)> = Vec::new();
        match self.case {
            Some(case) => {
                let request = RunRequest {
                    set: assignments(&self.set)?,
                    duration_s: self.duration,
                    ..RunRequest::of(case, "zero-order-hold")
                };
                wanted.push((self.out.clone(), request.resolve(catalogue)?));
            }
            None => {
                for spec in &ranked {
                    if !wanted.iter().any(|(_, known)| known.shares_reference_with(spec)) {
                        let unlimited = spec.with(|own| own.wall_limit = None)?;
                        wanted.push((self.out.join(&*spec.case.name), unlimited));
                    }
                }
            }
        }
        let program = std::env::current_exe().unwrap_or_default();
        let library = match self.no_fmus {
            true => None,
            false => Some(find_library(self.library.as_deref(), &program)?.1),
        };
        let cache = Cache::of_user();
        let mut peaks = "case,set,peak_over_event_peak\n".to_owned();
        for (folder, spec) in &wanted {
            let reference = obtain_reference(spec, &cache, StopFlag::never())?;
            let (problem, rows) = Problem::of(spec, &reference, &ranked)?;
            if let Some(ratio) = problem.peak_over_event_peak() {
                peaks += &format!("{},{},{ratio:?}\n", problem.problem, problem.set);
            }
            let files = pack_files(spec, &problem, &rows)?;
            let zip = zipped(&files).map_err(|error| Error::file(folder, error))?;
            let mut all = files;
            if let Some(bytes) = &library {
                all.extend(fmus(spec, bytes)?);
            }
            check_place(folder)?;
            for (name, bytes) in &all {
                let path = folder.join(name);
                check_writable_folder(path.parent().unwrap_or(folder))?;
                write_atomically(&path, |file| file.write_all(bytes))?;
            }
            let archive = folder.with_extension("zip");
            write_atomically(&archive, |file| file.write_all(&zip))?;
            let text = format!(
                "{} ({} files), {} ({} kB), version {}",
                folder.display(),
                all.len(),
                archive.display(),
                zip.len().div_ceil(1000),
                problem.version
            );
            print(&paragraph(&text, 4))?;
        }
        if self.ranking {
            write_atomically(&self.out.join(PROBLEMS), |file| file.write_all(peaks.as_bytes()))?;
        }
        warn_of_cache(&cache);
        Ok(())
    }
}

/// Refuses a folder with files of something else.
fn check_place(folder: &Path) -> anyhow::Result<()> {
    let is_there = std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
    if is_there && !folder.join("score.json").is_file() {
        return Err(Error::file(
            folder,
            "holds files that are of no problem pack: name another folder, or an empty one",
        )
        .into());
    }
    Ok(())
}

/// FMUs of both sides for both versions of the standard, and the system that they make.
fn fmus(spec: &RunSpec, library: &[u8]) -> anyhow::Result<Vec<(String, Vec<u8>)>> {
    let mut files = Vec::new();
    let mut system = vec![("SystemStructure.ssd".to_owned(), system_structure(spec)?.into_bytes())];
    for side in Side::BOTH {
        let name = side_name(side);
        files.push((format!("{name}.fmu"), pack(spec, side, Fmi::Three, library)?));
        let two = pack(spec, side, Fmi::Two, library)?;
        system.push((format!("resources/{name}.fmu"), two.clone()));
        files.push((format!("fmi2/{name}.fmu"), two));
    }
    let packed = zipped(&system).map_err(|error| Error::Incompatible(error.to_string()))?;
    files.push(("system.ssp".to_owned(), packed));
    Ok(files)
}
