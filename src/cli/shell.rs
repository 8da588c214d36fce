//! `rimbench completions`: what shells and `man` know of the command line, made from the command line itself.

use super::{command, print};
use clap::Args;
use clap_complete::Shell;
use clap_mangen::Man;
use rimbench::error::Error;

/// Arguments of `completions`.
#[derive(Debug, Args)]
pub struct Completions {
    /// The shell
    #[arg(required_unless_present = "man")]
    shell: Option<Shell>,
    /// The manual page of the program, or of a command
    #[arg(long, value_name = "COMMAND", num_args = 0..=1, conflicts_with = "shell")]
    man: Option<Option<String>>,
}

impl Completions {
    pub(super) fn run(self) -> anyhow::Result<()> {
        let (mut program, mut text) = (command(), Vec::new());
        if let Some(shell) = self.shell {
            clap_complete::generate(shell, &mut program, "rimbench", &mut text);
            return print(&String::from_utf8(text)?);
        }
        program.build();
        let page = match self.man.flatten() {
            None => program,
            Some(name) => {
                let known: Vec<_> = program.get_subcommands().filter(|command| !command.is_hide_set()).collect();
                let found = known.iter().find(|command| command.get_name() == name);
                let names = known.iter().map(|command| command.get_name());
                clap::Command::clone(found.ok_or_else(|| Error::unknown("command", &name, names))?)
            }
        };
        Man::new(page).render(&mut text)?;
        print(String::from_utf8(text)?.trim_end())
    }
}
