//! The program with what is built in. A crate of one's own calls the same with more in its catalogue.

use std::process::ExitCode;

fn main() -> ExitCode {
    rimbench::main(rimbench::everything())
}
