//! `rimbench completions` and `rimbench man`: what shells and `man` know of the command line, made from the command line itself.

use super::{Cli, print};
use clap::{Args, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;
use rimbench::error::Error;

/// Arguments of `completions`.
#[derive(Debug, Args)]
pub struct Completions {
    /// The shell
    shell: Shell,
}

impl Completions {
    pub(super) fn run(self) -> anyhow::Result<()> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "rimbench", &mut script);
        print(&String::from_utf8(script)?)
    }
}

/// Arguments of `man`.
#[derive(Debug, Args)]
pub struct ManPage {
    /// Page of this command instead of that of the program
    command: Option<String>,
}

impl ManPage {
    pub(super) fn run(self) -> anyhow::Result<()> {
        let mut program = Cli::command();
        program.build();
        let page = match &self.command {
            None => program,
            Some(name) => {
                let known = program.find_subcommand(name).filter(|command| !command.is_hide_set()).cloned();
                let names = program.get_subcommands().filter(|command| !command.is_hide_set());
                known.ok_or_else(|| Error::unknown("command", name, names.map(clap::Command::get_name)))?
            }
        };
        let mut text = Vec::new();
        Man::new(page).render(&mut text)?;
        print(String::from_utf8(text)?.trim_end())
    }
}
