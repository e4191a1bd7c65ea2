//! The command line of Glanz: from arguments to exit code.

mod arguments;
mod baking;
mod checkpoint_file;
mod command;
mod guide_file;
mod illumination;
mod interrupt;
mod light_file;
mod light_maps;
mod messages;
mod outputs;
mod plan;
mod progress;
mod report;
mod scene_file;
mod surface_light;
mod view;

use std::process::ExitCode;

use clap::Parser;

use arguments::{Arguments, Command};
use messages::Messages;

/// Exit code for wrong usage.
const WRONG_USAGE: u8 = 2;

/// How a command ended that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ending {
    /// Everything was done.
    Done,
    /// Everything was done, and the answer is no.
    Refused,
    /// The user wanted an end; what there was is saved.
    Interrupted,
}

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help and version come this way too, with the code 0.
            let _ = error.print();
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(WRONG_USAGE));
        }
    };
    let (messages, outcome) = match arguments.command {
        Command::Demo(demo) => {
            let messages = Messages::new(demo.options.talk.quiet);
            (messages, command::demo::run(&demo, messages))
        }
        Command::Render(render) => {
            let messages = Messages::new(render.options.talk.quiet);
            (messages, command::render::run(&render, messages))
        }
        Command::Bake(bake) => {
            let messages = Messages::new(bake.talk.quiet);
            (messages, command::bake::run(&bake, messages))
        }
        Command::Illuminate(illuminate) => {
            let messages = Messages::new(illuminate.talk.quiet);
            (messages, command::illuminate::run(&illuminate, messages))
        }
        Command::Merge(merge) => {
            let messages = Messages::new(merge.talk.quiet);
            (messages, command::merge::run(&merge, messages))
        }
        Command::Info(info) => {
            let messages = Messages::new(false);
            (messages, command::info::run(&info, messages))
        }
        Command::Study(study) => {
            let messages = Messages::new(study.talk.quiet);
            (messages, command::study::run(&study, messages))
        }
        Command::View(view) => {
            let messages = Messages::new(view.quiet);
            (messages, command::view::run(&view, messages))
        }
        Command::Compare(compare) => (Messages::new(false), command::compare::run(&compare)),
        Command::Completions { shell } => (Messages::new(false), command::shell::completions(shell)),
        Command::Man { command } => (Messages::new(false), command::shell::manual(command.as_deref())),
    };
    match outcome {
        Ok(Ending::Done) => ExitCode::SUCCESS,
        Ok(Ending::Refused) => ExitCode::FAILURE,
        Ok(Ending::Interrupted) => ExitCode::from(interrupt::EXIT_CODE),
        Err(failure) => {
            messages.error(&failure);
            if failure.usage { ExitCode::from(WRONG_USAGE) } else { ExitCode::FAILURE }
        }
    }
}
