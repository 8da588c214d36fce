//! One file per subcommand.

mod advise;
mod collect;
mod everything;
mod figures;
mod fmu;
mod interruption;
mod json;
mod judge;
mod limit;
mod list;
mod pack;
mod paper;
mod perf;
mod plan;
mod progress;
mod project;
mod rank;
mod report;
mod reproduce;
mod run;
mod run_options;
mod screen;
mod simulate;
mod submit;
mod summary;
mod verify;

pub use simulate::parts_of_error;

use anyhow::Context;
use clap::{Arg, ArgAction, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};
use rimbench::cases::Case;
use rimbench::catalogue::{Catalogue, SchemeFile};
use rimbench::checksums::sha256_of_file;
use rimbench::error::{Error, Result};
use rimbench::figures::number;
use rimbench::figures::report::measured;
use rimbench::fmi::import::{ProbeQuality, Programs, SideNotes, WORKER, read_case, read_scheme, standard_output};
use rimbench::harness::{Cache, CheckedClaim, Damaged, Verdict, in_shell, named_python};
use rimbench::numerics_version::NUMERICS_VERSION;
use screen::{Mood, headline, paragraph, width};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::OnceLock;

/// Benchmark of non-iterative co-simulation of mechanical systems with contact.
#[derive(Debug, Parser)]
#[command(name = "rimbench", version = version(), about)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Make a case of FMUs, as the file says; may be repeated
    #[arg(long, value_name = "FILE.toml", global = true)]
    case_file: Vec<PathBuf>,
    /// Add a coupling scheme, a class of Python in a file; may be repeated
    #[arg(long, value_name = "FILE.py:CLASS", global = true)]
    scheme_file: Vec<String>,
    /// Say nothing of how far a command has come
    #[arg(long, short, global = true)]
    quiet: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run one co-simulation and print its outcome, metrics and counters
    Simulate(simulate::Simulate),
    /// Find the largest stable macro step of a scheme on a case
    Limit(limit::Limit),
    /// Say which scheme and macro step are cheapest within an error
    Advise(advise::Advise),
    /// Run what is missing of an experiment, here or on a cluster
    Run(run::Run),
    /// Check the claims of experiments against their stored results
    Verify(verify::Verify),
    /// Write one page of any results, or draw their figures, set the paper
    Report(report::ReportCommand),
    /// Reproduce the source paper's figures and claims, from nothing
    Reproduce(reproduce::Reproduce),
    /// List what there is, by name
    List(list::List),
    /// Write what completes these commands in a shell, for it to source
    Completions {
        /// Which shell
        shell: clap_complete::Shell,
    },
    /// Write one side of a case as an FMU, for other masters
    Fmu(fmu::Fmu),
    /// Write a problem as a folder that others take part with, without this program
    Pack(pack::Pack),
    /// Score a trajectory from anywhere by a problem pack
    Judge(judge::Judge),
    /// Rank rows of experiments and entries of others by their errors
    Rank(rank::Rank),
    /// Record the program's own performance, and compare records or git revisions
    Perf(perf::Perf),
    /// Drive an FMU for another process of this program
    #[command(name = WORKER, hide = true)]
    FmuWorker,
}

/// Commands by what a person wants.
const GROUPS: [(&str, &[&str]); 6] = [
    ("One run", &["simulate", "limit", "advise"]),
    ("Many runs", &["run", "verify", "report"]),
    ("The paper", &["reproduce"]),
    ("What there is", &["list", "completions"]),
    ("To and from others", &["fmu", "pack", "judge", "rank"]),
    ("Speed", &["perf"]),
];

/// The command line, with its commands in groups.
fn command() -> clap::Command {
    let command = with_negative_numbers(Cli::command());
    let mut commands = String::new();
    for (title, names) in GROUPS {
        commands += &format!("\n{title}:\n");
        for command in names.iter().filter_map(|name| command.find_subcommand(name)) {
            let about = command.get_about().map(ToString::to_string).unwrap_or_default();
            commands += &format!("  {:<12} {}\n", command.get_name(), paragraph(&about, 15));
        }
    }
    let template = format!("{{about}}\n\n{{usage-heading}} {{usage}}\n{commands}\nOptions:\n{{options}}");
    // A line or two for each option, however help is asked for.
    let help = Arg::new("help").short('h').long("help").action(ArgAction::HelpShort).help("Print help").global(true);
    command.disable_help_flag(true).arg(help).help_template(template).term_width(width())
}

/// Takes a number below 0 for the value that it is, not for an option that there is not.
fn with_negative_numbers(command: clap::Command) -> clap::Command {
    let of = |arg: Arg| {
        let takes = arg.get_action().takes_values();
        arg.allow_negative_numbers(takes)
    };
    command.mut_args(of).mut_subcommands(with_negative_numbers)
}

/// Exit code after Ctrl-C, as shells have it.
const INTERRUPTED: u8 = 130;

/// Exit code of a command that was asked one thing: 0 if there is an answer, whichever it is, and 1 if there is none.
fn answered(is: bool) -> ExitCode {
    if is { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// How to print.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// For reading.
    Table,
    /// For programs: a number that is infinite or none is null, and `not_finite` beside it says which it was.
    Json,
}

/// Ends the program with what is wrong with the command line, said as every other error is, or with what was asked for.
fn refuse(error: &clap::Error) -> ! {
    use clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand as Help;
    if !error.use_stderr() || error.kind() == Help {
        error.exit()
    }
    let text = error.render().to_string();
    let mut parts = text.trim_start_matches("error: ").split("\n\n");
    let wrong = parts.next().unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ");
    // What the standard library says of a number, with what would be one.
    let wrong = [
        ("invalid digit found in string", "a whole number from 0 is needed"),
        ("number too large to fit in target type", "a smaller number is needed"),
        ("invalid float literal", "a number is needed"),
    ]
    .into_iter()
    .fold(wrong, |wrong, (said, needed)| wrong.replace(said, needed));
    let tip = text.lines().find_map(|line| line.trim().strip_prefix("tip: ")).map(|tip| format!("{tip}; "));
    let usage = text.split("Usage: ").nth(1).and_then(|usage| usage.split(['[', '<', '-', '\n']).next());
    let help = format!("{}`{} --help` lists what there is", tip.unwrap_or_default(), usage.unwrap_or(program()).trim());
    eprintln!("error: {}\nhelp: {}", paragraph(&wrong, 7), paragraph(&help, 6));
    std::process::exit(2)
}

/// The name of this program, as it is typed.
fn program() -> &'static str {
    static NAME: OnceLock<String> = OnceLock::new();
    NAME.get_or_init(|| {
        let typed = std::env::args_os().next().map(PathBuf::from);
        let name = typed.as_deref().and_then(Path::file_stem).map(|name| name.to_string_lossy().into_owned());
        name.unwrap_or_else(|| "rimbench".to_owned())
    })
}

/// Revision of the sources, and version of the digits: what a result depends on.
fn version() -> String {
    let revision = option_env!("RIMBENCH_GIT_REVISION").unwrap_or("unknown");
    let short = revision.get(..12).unwrap_or(revision);
    format!("{} (revision {short}, numerics {NUMERICS_VERSION})", env!("CARGO_PKG_VERSION"))
}

impl Cli {
    /// Reads the command line; ends the program if that cannot be, or if help was asked for.
    pub fn read() -> Self {
        let read = command().try_get_matches().and_then(|matches| Cli::from_arg_matches(&matches));
        read.unwrap_or_else(|error| refuse(&error))
    }

    /// Runs the chosen command and says with which code to exit.
    ///
    /// # Errors
    /// Bad input, or a place that cannot be written.
    pub fn run(self, mut catalogue: Catalogue) -> anyhow::Result<ExitCode> {
        if matches!(self.command, Command::FmuWorker) {
            rimbench::fmi::import::serve()?;
            return Ok(ExitCode::SUCCESS);
        }
        progress::be_quiet(self.quiet);
        interruption::listen()?;
        let mut code = None;
        if catalogue.has_added() {
            let program = std::env::current_exe().context("this program cannot find itself")?;
            let digest = sha256_of_file(&program).with_context(|| format!("{}: cannot be read", program.display()))?;
            catalogue.say_code(code.insert(digest[..16].to_owned()));
        }
        let notes = &SideNotes::default();
        let of_files = notes.clone();
        catalogue.read_cases_by(move |file| case_of(&of_files, file));
        catalogue
            .read_schemes_by(|file| read_scheme(file, &Programs { python: named_python(), ..Programs::default() }));
        self.case_file.iter().try_for_each(|file| add_case_file(&mut catalogue, notes, file).map(drop))?;
        self.scheme_file.iter().try_for_each(|text| add_scheme_file(&mut catalogue, text).map(drop))?;
        // Arguments that other processes of this program need as well.
        let cases = self.case_file.iter().map(|file| ("--case-file", file.clone()));
        let schemes = self.scheme_file.iter().map(|file| ("--scheme-file", PathBuf::from(file)));
        let files: Vec<(&str, PathBuf)> = cases.chain(schemes).collect();
        let catalogue = &catalogue;
        match self.command {
            Command::Simulate(command) => return command.run(catalogue, notes),
            Command::Limit(command) => return command.run(catalogue),
            Command::Advise(command) => {
                return command.run(catalogue, files.iter().map(|(option, file)| file_option(option, file)).collect());
            }
            Command::Run(command) => return command.run(catalogue, notes, &files),
            Command::Verify(command) => return command.run(catalogue),
            Command::Report(command) => return command.run(catalogue),
            Command::Reproduce(command) => return command.run(catalogue),
            Command::List(command) => command.run(catalogue)?,
            Command::Completions { shell } => {
                let mut text = Vec::new();
                clap_complete::generate(shell, &mut command(), program(), &mut text);
                print(String::from_utf8_lossy(&text).trim_end())?;
            }
            Command::Fmu(_) if !self.scheme_file.is_empty() => {
                let why = "--scheme-file: an FMU is one side of a case; the scheme is the master's, and goes into none";
                return Err(Error::Incompatible(why.to_owned()).into());
            }
            Command::Fmu(command) => command.run(catalogue)?,
            Command::Pack(command) => command.run(catalogue)?,
            Command::Judge(command) => return command.run(),
            Command::Rank(command) => return command.run(catalogue),
            Command::Perf(command) => return command.run(catalogue, code.as_deref()),
            Command::FmuWorker => {}
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// An error as it is printed; what goes by the name of a flag is called so.
pub fn error_text(message: &str) -> String {
    let command = Cli::command();
    let flags = command.get_subcommands().flat_map(|command| command.get_arguments());
    let flags: Vec<String> = flags.filter_map(|flag| flag.get_long().map(str::to_owned)).collect();
    let typed = std::env::args().filter_map(|arg| Some(arg.strip_prefix("--")?.split('=').next()?.to_owned()));
    screen::error(message, &flags, &typed.collect::<Vec<_>>())
}

/// The exit code of an error: 2 for bad input, and 1 for a reference that took longer than it may, which is no answer.
pub fn exit_code(error: &anyhow::Error) -> ExitCode {
    match error.downcast_ref() {
        Some(Error::Overdue { .. }) => answered(false),
        _ => ExitCode::from(2),
    }
}

/// Reads the case that a file makes of FMUs, of which something may be to be said after a run.
fn case_of(notes: &SideNotes, file: &Path) -> Result<Case> {
    // FMUs in processes of their own: those of this program.
    let program = std::env::current_exe()
        .map_err(|error| Error::file(file, format!("this program cannot find itself: {error}")))?;
    let worker = Some(vec![program, WORKER.into()]);
    read_case(file, Programs { worker, python: named_python(), notes: notes.clone() })
}

/// Adds the case that a file makes of FMUs; returns its name.
fn add_case_file(catalogue: &mut Catalogue, notes: &SideNotes, file: &Path) -> Result<String> {
    let case = case_of(notes, file)?;
    let name = case.name.to_string();
    catalogue.add_case(case).map_err(|error| Error::file(file, error))?;
    Ok(name)
}

/// Adds the scheme that a class in a file is; returns its name.
fn add_scheme_file(catalogue: &mut Catalogue, text: &str) -> Result<String> {
    let expected = "a file of Python and a class in it, as in mine.py:MidHold";
    let file = SchemeFile::parse(text).ok_or_else(|| Error::invalid("--scheme-file", text, expected))?;
    catalogue.add_scheme_of_file(&file)?;
    Ok(file.name)
}

/// A file as it is given by an option, behind other words of a command.
fn file_option(option: &str, file: &Path) -> String {
    format!(" {}", in_shell(&[option.to_owned(), file.display().to_string()]))
}

/// The same catalogue, with a case in it where that is given as a file that makes it of FMUs, and a scheme where it is
/// given as a class in a file.
fn with_files<'a>(
    catalogue: &'a Catalogue,
    notes: &SideNotes,
    case: &mut Option<String>,
    scheme: &mut Option<String>,
) -> Result<Cow<'a, Catalogue>> {
    let mut catalogue = Cow::Borrowed(catalogue);
    if let Some(file) = case.as_ref().filter(|name| is_file_of_case(&catalogue, name)) {
        *case = Some(add_case_file(catalogue.to_mut(), notes, Path::new(file))?);
    }
    if let Some(text) = scheme.as_ref().filter(|name| is_file_of_scheme(name)) {
        *scheme = Some(add_scheme_file(catalogue.to_mut(), text)?);
    }
    Ok(catalogue)
}

/// Whether a case is given as a file and not by a name: names have neither dots nor separators.
fn is_file_of_case(catalogue: &Catalogue, name: &str) -> bool {
    catalogue.case(name).is_err() && (name.contains(['.', '/', '\\']) || Path::new(name).is_file())
}

/// Whether a scheme is given as a class in a file and not by a name.
fn is_file_of_scheme(name: &str) -> bool {
    name.contains(".py")
}

/// Prints to standard output; a reader that closed the pipe early is no error.
fn print(text: &str) -> anyhow::Result<()> {
    use std::io::{ErrorKind, Write};
    let text = text.replace(number::TIED, " ");
    let written = match standard_output() {
        // An FMU in this process has the usual one.
        Some(mut ours) => writeln!(ours, "{text}"),
        None => writeln!(std::io::stdout().lock(), "{text}"),
    };
    match written {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        result => Ok(result.context("standard output: cannot be written")?),
    }
}

/// Prints a value as JSON, for programs.
fn print_json(value: &impl serde::Serialize) -> anyhow::Result<()> {
    print(&serde_json::to_string_pretty(value)?)
}

/// Names the rows that could not be read, the first of many.
fn damaged_lines(damaged: &[Damaged]) -> Vec<String> {
    const TOLD: usize = 20;
    let line =
        |place: &Damaged| format!("{place}: the row is damaged, and its run is computed again if it belongs here");
    let more = damaged.len().saturating_sub(TOLD);
    let more = (more > 0).then(|| format!("… and {more} more rows that are damaged"));
    damaged.iter().take(TOLD).map(line).chain(more).collect()
}

/// How good what FMUs were probed for is, a line for each of them.
fn probe_lines(probed: &BTreeMap<PathBuf, ProbeQuality>) -> Vec<String> {
    let line = |(file, quality): (&PathBuf, &ProbeQuality)| {
        let ProbeQuality { count, median, largest } = quality;
        format!(
            "{} was probed {count} times for how its outputs move: half of the relative errors are at most {median:.1e}, the largest is \
             {largest:.1e} (estimated from two step sizes)",
            file.display()
        )
    };
    probed.iter().map(line).collect()
}

/// Says what is wrong with the cache of references, if anything is: without it every command computes them again.
fn warn_of_cache(cache: &Cache) {
    if let Some(error) = cache.fault() {
        eprintln!("note: the cache of references is of no use here: {error}");
    }
}

/// Claims with what was measured, two lines or more each.
fn claims_list(claims: &[CheckedClaim]) -> String {
    let mut lines = Vec::with_capacity(2 * claims.len());
    for claim in claims {
        let changed = match claim.finding {
            _ if claim.differs() => format!(", recorded as {}", claim.finding),
            Verdict::NotMeasured if claim.verdict != Verdict::NotMeasured => ", not recorded yet".to_owned(),
            _ => String::new(),
        };
        let superseded = if claim.superseded.is_empty() { "" } else { ", superseded" };
        let mood = match claim.verdict {
            _ if claim.differs() => Mood::Bad,
            Verdict::Reproduced => Mood::Good,
            _ => Mood::Open,
        };
        lines.push(headline(&claim.id, &format!("{}{changed}", claim.verdict), mood));
        let text = &claim.text;
        let said = format!("{text} ({}{superseded}): {}", claim.by, measured(claim, 2));
        lines.push(format!("  {}", paragraph(&said, 2)));
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimbench::claims::Claimant;

    /// "is 0.9, expected ≥ 0.9, not reproduced" was 0.895.
    #[test]
    fn a_measured_value_is_told_from_its_bound() {
        let mut claim = CheckedClaim {
            experiment: String::new(),
            id: "seen".to_owned(),
            by: Claimant::Ours,
            text: "a peak".to_owned(),
            quantity: "median of ratio".to_owned(),
            measured: Some(0.895_24),
            low: Some(0.816),
            high: Some(0.9004),
            without_exact: None,
            expected: "≥ 0.9".to_owned(),
            verdict: Verdict::NotReproduced,
            finding: Verdict::NotReproduced,
            superseded: String::new(),
            variant_of: String::new(),
            numbers_known: false,
            runs: 2,
            failed: 0,
            run_ids: Vec::new(),
        };
        let said = |claim: &CheckedClaim| claims_list(std::slice::from_ref(claim)).replace(['\n', number::TIED], " ");
        assert!(said(&claim).contains("is 0.895 [0.82, 0.9004], expected ≥ 0.9"), "{}", said(&claim));
        (claim.measured, claim.expected) = (Some(0.994), "≥ 0.995".to_owned());
        assert!(said(&claim).contains("is 0.99 ") && said(&claim).contains("≥ 0.995"), "{}", said(&claim));
    }
}
