//! `pellicle man`: manual pages.

use clap::{Args, Command, CommandFactory};
use clap_mangen::Man;

use super::{Cli, print};
use crate::error::Error;

/// Print a manual page
#[derive(Args)]
#[command(after_help = "Examples:
  pellicle man | man -l -
  pellicle man render | man -l -
  pellicle man > ~/.local/share/man/man1/pellicle.1")]
pub struct ManArgs {
    /// The command to explain, like `render` [default: the program as a whole]
    #[arg(value_name = "COMMAND")]
    command: Option<String>,
}

pub fn run(args: &ManArgs) -> Result<(), Error> {
    let mut program = Cli::command();
    program.build();
    let page = match &args.command {
        None => program,
        Some(name) => {
            let known: Vec<&str> = program.get_subcommands().map(Command::get_name).collect();
            let unknown = || Error::Usage(format!("no command `{name}`; there are {}", known.join(", ")));
            let command = program.find_subcommand(name).ok_or_else(unknown)?;
            command.clone()
        }
    };
    let title = args.command.as_ref().map_or("pellicle".to_owned(), |name| format!("pellicle-{name}"));
    // The machine that the page is made on is of no interest to who reads it.
    let mut text = Vec::new();
    match Man::new(page.long_version(env!("CARGO_PKG_VERSION"))).title(title).render(&mut text) {
        Ok(()) => print(&String::from_utf8_lossy(&text)),
        Err(error) => Err(Error::Usage(format!("the page cannot be written: {error}"))),
    }
}
