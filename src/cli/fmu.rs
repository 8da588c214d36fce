//! `rimbench fmu`: one side of a case for other masters.

use super::run_options::{assignments, seconds};
use super::screen::paragraph;
use super::{print, with_file};
use clap::{Args, ValueEnum};
use rimbench::atomic_file::{check_writable_file, write_atomically};
use rimbench::catalogue::Catalogue;
use rimbench::cosim;
use rimbench::error::Error;
use rimbench::fmi::export::{find_library, golden_run, pack};
use rimbench::fmi::import::SideNotes;
use rimbench::runs::RunRequest;
use rimbench::trace::write_trace;
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
    /// The FMU to be written; beside it goes FILE.csv, what the side heard and said in a run with zero-order hold
    #[arg(long, value_name = "FILE.fmu")]
    out: PathBuf,
    /// Communication step of that run, and the one that the FMU suggests, s
    #[arg(long, value_name = "TIME", value_parser = seconds)]
    macro_step: Option<f64>,
    /// Simulated time of that run, s
    #[arg(long, value_name = "TIME", value_parser = seconds)]
    duration: Option<f64>,
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

impl Fmu {
    pub(super) fn run(self, catalogue: &Catalogue) -> anyhow::Result<()> {
        let mut request = RunRequest {
            set: assignments(&self.set)?,
            macro_step_s: self.macro_step,
            duration_s: self.duration,
            ..RunRequest::of(self.case, "zero-order-hold")
        };
        let catalogue = with_file(catalogue, &SideNotes::default(), &mut request.case)?;
        let spec = request.resolve(&catalogue)?;
        spec.prepare()?;
        let side = match self.side {
            Side::Mechanics => cosim::Side::Mechanics,
            Side::Actuator => cosim::Side::Actuator,
        };
        if self.out.extension().is_none_or(|extension| extension != "fmu") {
            return Err(Error::invalid("--out", self.out.display(), "the name of a file that ends in .fmu").into());
        }
        let golden = self.out.with_extension("csv");
        check_writable_file(&self.out)?;
        check_writable_file(&golden)?;
        let program = std::env::current_exe().unwrap_or_default();
        let (library, bytes) = find_library(self.library.as_deref(), &program)?;
        let packed = pack(&spec, side, &bytes)?;
        let (trajectory, outcome) = golden_run(&spec, side)?;
        let was_there = self.out.exists();
        write_atomically(&self.out, |file| file.write_all(&packed))?;
        // One without the other is half of what was asked for.
        write_trace(&golden, &trajectory, None).inspect_err(|_| {
            let _ = (!was_there).then(|| std::fs::remove_file(&self.out));
        })?;
        let (out, size, library) = (self.out.display(), packed.len(), library.display());
        let (points, step_ms) = (trajectory.len(), 1e3 * spec.macro_step);
        let heard = format!("{} ({points} communication points, H = {step_ms} ms; {outcome})", golden.display());
        print(&paragraph(&format!("{out} ({size} bytes, library {library})"), 4))?;
        print(&paragraph(&heard, 4))
    }
}
