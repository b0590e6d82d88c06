//! `pellicle completions`: scripts that complete commands, options and file names in a shell.

use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};

use super::{Cli, print};
use crate::error::Error;

/// Print a script that completes commands and options in a shell
#[derive(Args)]
#[command(after_help = "Examples:
  pellicle completions bash > ~/.local/share/bash-completion/completions/pellicle
  pellicle completions zsh > ~/.zfunc/_pellicle
  pellicle completions fish > ~/.config/fish/completions/pellicle.fish")]
pub struct CompletionsArgs {
    /// The shell that will read it
    #[arg(value_name = "SHELL", value_enum)]
    shell: Shell,
}

pub fn run(args: &CompletionsArgs) -> Result<(), Error> {
    let mut script = Vec::new();
    generate(args.shell, &mut Cli::command(), "pellicle", &mut script);
    print(&String::from_utf8_lossy(&script))
}
