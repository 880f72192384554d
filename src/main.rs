//! Entry point of the program.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(diptych::program::main(std::env::args_os()))
}
