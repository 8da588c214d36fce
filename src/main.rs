//! The command line of rimbench: parse, call, print. Exit code 2 means bad input, said in one clear error;
//! exit code 1 a check that did not hold, or a run that gave no answer.

/// What the standard macro of this name does, but a reader that closed the pipe is no panic.
macro_rules! eprintln {
    ($($arguments:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($arguments)*);
    }};
}

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    match cli::Cli::read().run() {
        Ok(code) => code,
        Err(error) => {
            eprintln!("{}", cli::error_text(&format!("{error:#}")));
            cli::exit_code(&error)
        }
    }
}
