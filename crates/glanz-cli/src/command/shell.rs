//! `glanz completions` and `glanz man`, for packages of the program.

use clap::CommandFactory;
use glanz_terminal::CommandOutcome;
use glanz_terminal::messages::CommandError;

use crate::arguments::Arguments;
use crate::report;

/// Prints the completion script of `shell`.
pub(crate) fn completions(shell: clap_complete::Shell) -> Result<CommandOutcome, CommandError> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "glanz", &mut script);
    report::print_text(&String::from_utf8_lossy(&script))?;
    Ok(CommandOutcome::Done)
}

/// Prints the manual page of the program, or of one of its commands.
pub(crate) fn manual(command: Option<&str>) -> Result<CommandOutcome, CommandError> {
    let mut definition = Arguments::command();
    definition.build();
    let page = match command {
        None => definition,
        Some(name) => match definition.find_subcommand(name) {
            Some(command) => command.clone(),
            None => return Err(CommandError::usage(format!("there is no command \"{name}\""))),
        },
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page)
        .render(&mut text)
        .map_err(|error| CommandError::new(format!("manual page: {error}")))?;
    report::print_text(&String::from_utf8_lossy(&text))?;
    Ok(CommandOutcome::Done)
}
