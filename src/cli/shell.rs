//! What shells and `man` know of the command line, made from the command line itself: `rimbench list completions`, `list manual`.

use super::{command, print};
use clap::ValueEnum;
use clap_complete::Shell;
use clap_mangen::Man;
use rimbench::error::Error;

/// Prints what a shell needs to complete commands and options.
pub(super) fn print_completions(shell: Option<&str>) -> anyhow::Result<()> {
    let names = Shell::value_variants().iter().map(ToString::to_string).collect::<Vec<_>>();
    let name = shell.unwrap_or_default();
    let shell: Shell = name.parse().map_err(|_| Error::unknown("shell", name, names.iter().map(String::as_str)))?;
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut command(), "rimbench", &mut text);
    print(&String::from_utf8(text)?)
}

/// Prints the manual page of the program, or of a command.
pub(super) fn print_manual(name: Option<&str>) -> anyhow::Result<()> {
    let (mut program, mut text) = (command(), Vec::new());
    program.build();
    let page = match name {
        None => program,
        Some(name) => {
            let known: Vec<_> = program.get_subcommands().filter(|command| !command.is_hide_set()).collect();
            let found = known.iter().find(|command| command.get_name() == name);
            let names = known.iter().map(|command| command.get_name());
            clap::Command::clone(found.ok_or_else(|| Error::unknown("command", name, names))?)
        }
    };
    Man::new(page).render(&mut text)?;
    print(String::from_utf8(text)?.trim_end())
}
