//! The command line of rimbench: parse, call, print. Exit code 2 means bad input, said in one clear error;
//! exit code 1 a check that did not hold.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    match cli::Cli::read().run() {
        Ok(code) => code,
        Err(error) => {
            eprintln!("{}", cli::error_text(&format!("{error:#}")));
            ExitCode::from(2)
        }
    }
}
