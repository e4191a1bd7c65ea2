//! The command line of Glanz: from arguments to exit code.

mod arguments;
mod browser;
mod command;
mod command_error;
mod file_help;
mod input;
mod job;
mod notes;
mod outputs;
mod report;
mod scene_file;

use std::process::ExitCode;

use glanz_terminal::exit_code;
use glanz_terminal::messages::{CommandError, Messages};

use arguments::{Arguments, Command};

fn main() -> ExitCode {
    let arguments: Arguments = match glanz_terminal::parse() {
        Ok(arguments) => arguments,
        Err(code) => return code,
    };
    let (messages, outcome) = match arguments.command {
        Command::Demo(demo) => {
            let messages = demo.render.job.verbosity.messages();
            (messages, command::demo::run(&demo, messages))
        }
        Command::Render(render) => {
            let messages = render.render.job.verbosity.messages();
            (messages, command::render::run(&render, messages))
        }
        Command::Bake(bake) => {
            let messages = bake.job.verbosity.messages();
            (messages, command::bake::run(&bake, messages))
        }
        Command::Illuminate(illuminate) => {
            let messages = illuminate.job.verbosity.messages();
            (messages, command::illuminate::run(&illuminate, messages))
        }
        Command::Road(road) => {
            let messages = Messages::new(false);
            (messages, command::road::run(&road, messages))
        }
        Command::Optimize(optimize) => {
            let messages = optimize.job.verbosity.messages();
            (messages, command::optimize::run(&optimize, messages))
        }
        Command::Merge(merge) => {
            let messages = merge.verbosity.messages();
            (messages, command::merge::run(&merge, messages))
        }
        Command::Info(info) => {
            let messages = Messages::new(false);
            (messages, command::info::run(&info, messages))
        }
        Command::Study { .. } => (
            Messages::new(false),
            Err(CommandError::usage("the studies are a separate program")
                .with_help("cargo run --release -p glanz-study -- newton --out newton")),
        ),
        Command::View(view) => {
            let messages = Messages::new(view.quiet);
            (messages, command::view::run(&view, messages))
        }
        Command::Convert(convert) => {
            let messages = convert.verbosity.messages();
            (messages, command::convert::run(&convert, messages))
        }
        Command::Compare(compare) => {
            let messages = Messages::new(false);
            (messages, command::compare::run(&compare, messages))
        }
        Command::Completions { shell } => (Messages::new(false), command::shell::completions(shell)),
        Command::Man { command } => (Messages::new(false), command::shell::manual(command.as_deref())),
    };
    exit_code(messages, outcome)
}
