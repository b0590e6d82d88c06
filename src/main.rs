//! The `pellicle` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    pellicle::cli::main()
}
