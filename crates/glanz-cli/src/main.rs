//! The command line of Glanz: from arguments to exit code.

mod arguments;
mod baking;
mod checkpoint_file;
mod command;
mod guide_file;
mod illumination;
mod light_file;
mod light_maps;
mod outputs;
mod plan;
mod report;
mod saving;
mod scene_file;
mod surface_light;
mod view;

use std::process::ExitCode;

use glanz_terminal::{Ending, exit_code, interrupt, messages, progress};

use arguments::{Arguments, Command};
use messages::{Failure, Messages};

fn main() -> ExitCode {
    let arguments: Arguments = match glanz_terminal::parse() {
        Ok(arguments) => arguments,
        Err(code) => return code,
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
        Command::Study { .. } => (
            Messages::new(false),
            Err(Failure::usage("studies are a program of their own")
                .with_help("cargo run --release -p glanz-study -- newton --out newton")),
        ),
        Command::View(view) => {
            let messages = Messages::new(view.quiet);
            (messages, command::view::run(&view, messages))
        }
        Command::Compare(compare) => (Messages::new(false), command::compare::run(&compare)),
        Command::Completions { shell } => (Messages::new(false), command::shell::completions(shell)),
        Command::Man { command } => (Messages::new(false), command::shell::manual(command.as_deref())),
    };
    exit_code(messages, outcome)
}
