//! `rimbench fmu`: one side of a case for other masters.

use super::progress::say;
use super::run_options::{assignments, seconds};
use super::screen::paragraph;
use super::{print, with_files};
use clap::{Args, ValueEnum};
use rimbench::atomic_file::{check_writable_file, write_atomically};
use rimbench::catalogue::Catalogue;
use rimbench::cosim;
use rimbench::error::Error;
use rimbench::fmi::export::{Fmi, README, ReferenceFiles, Variables, check_case, find_library, pack, reference_files};
use rimbench::fmi::import::SideNotes;
use rimbench::runs::RunRequest;
use std::path::PathBuf;

/// Arguments of `fmu`.
#[derive(Debug, Args)]
pub struct Fmu {
    /// Case by name (see `rimbench list cases`)
    #[arg(long, value_name = "NAME")]
    case: String,
    /// Which of its sides
    #[arg(long, value_enum)]
    side: Side,
    /// A parameter of the case, key=value (see `rimbench list parameters`); may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// The FMU to be written; beside it go FILE_in.csv and FILE_ref.csv, what the side heard and said in a run with
    /// zero-order hold, FILE_ref.opt, its steps, and Readme.txt
    #[arg(long, value_name = "FILE.fmu")]
    out: PathBuf,
    /// Communication step of that run, and the one that the FMU suggests, s
    #[arg(long, value_name = "TIME", value_parser = seconds)]
    macro_step: Option<f64>,
    /// Simulated time of that run, s
    #[arg(long, value_name = "TIME", value_parser = seconds)]
    duration: Option<f64>,
    /// Version of the standard that it is for
    #[arg(long, value_enum, value_name = "VERSION", default_value_t = Version::Three)]
    fmi: Version,
    /// The library that goes into the FMU [default: that beside this program]
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Side {
    /// Forces in, positions and velocities out.
    Mechanics,
    /// Positions and velocities in, forces out.
    Actuator,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Version {
    /// No arrays, and so no interface model; for masters that take nothing later.
    #[value(name = "2.0", alias = "2")]
    Two,
    /// All that the side offers.
    #[value(name = "3.0", alias = "3")]
    Three,
}

/// Most bytes of a file that the FMI project takes.
const MOST_BYTES: usize = 1_000_000;

impl Fmu {
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<()> {
        let mut request = RunRequest {
            set: assignments(&self.set)?,
            macro_step_s: self.macro_step,
            duration_s: self.duration,
            ..RunRequest::of(self.case, "zero-order-hold")
        };
        let catalogue = with_files(catalogue, &SideNotes::default(), &mut request.case, &mut None)?;
        let spec = request.resolve(&catalogue)?;
        check_case(&spec.case)?;
        spec.prepare()?;
        let side = match self.side {
            Side::Mechanics => cosim::Side::Mechanics,
            Side::Actuator => cosim::Side::Actuator,
        };
        if self.out.extension().is_none_or(|extension| extension != "fmu") {
            return Err(Error::invalid("--out", self.out.display(), "the name of a file that ends in .fmu").into());
        }
        let fmi = match self.fmi {
            Version::Two => Fmi::Two,
            Version::Three => Fmi::Three,
        };
        let model = self.out.file_stem().unwrap_or_default().to_string_lossy();
        let beside = |name: &str| self.out.with_file_name(name);
        let foreign = std::fs::read(beside(README)).is_ok_and(|text| !ReferenceFiles::is_readme(&text));
        check_writable_file(&self.out)?;
        let program = std::env::current_exe().unwrap_or_default();
        let (library, bytes) = find_library(self.library.as_deref(), &program)?;
        let packed = pack(&spec, side, fmi, &bytes)?;
        let ReferenceFiles { mut files, points, outcome } = reference_files(&spec, side, &model)?;
        files.retain(|(name, _)| !(foreign && name == README));
        files.insert(0, (self.out.file_name().unwrap_or_default().to_string_lossy().into_owned(), packed));
        let files: Vec<(PathBuf, Vec<u8>)> = files.into_iter().map(|(name, bytes)| (beside(&name), bytes)).collect();
        files.iter().try_for_each(|(path, _)| check_writable_file(path))?;
        // All files or none: those written are removed if one fails.
        let mut written = Vec::new();
        for (path, bytes) in &files {
            let was_there = path.exists();
            write_atomically(path, |file| file.write_all(bytes)).inspect_err(|_| {
                written.iter().for_each(|path| drop(std::fs::remove_file(path)));
            })?;
            written.extend((!was_there).then_some(path));
        }
        let size = files[0].1.len();
        print(&paragraph(&format!("{} ({size} bytes, library {})", self.out.display(), library.display()), 4))?;
        let run = format!("{points} communication points, H = {} ms; {outcome}", 1e3 * spec.macro_step);
        let names: Vec<String> = files[1..].iter().map(|(path, _)| path.display().to_string()).collect();
        print(&paragraph(&format!("{} ({run})", names.join(", ")), 4))?;
        if fmi == Fmi::Two && Variables::of(&spec.case, side, &spec.parameters, Fmi::Three)?.has_model() {
            say("note: FMI 2.0 has no arrays: the interface model (rim.*) is left out; `--fmi 3.0` has it");
        }
        if foreign {
            say(&format!("note: {} is not of this program, and is left as it is", beside(README).display()));
        }
        for (path, _) in files[1..].iter().filter(|(_, bytes)| bytes.len() > MOST_BYTES) {
            say(&format!("note: {} is larger than 1 MB, more than the FMI project takes", path.display()));
        }
        Ok(())
    }
}
