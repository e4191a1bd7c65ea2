//! Housekeeping of the workspace; `cargo xtask` lists its commands.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command line prints")]

mod checks;
mod chromium;
mod layers;
mod nightly;
mod publish;
mod references;
mod scenes;
mod setup;
mod suite;
mod web;
mod words;
mod workspace;

use std::path::Path;
use std::process::ExitCode;

const USAGE: &str = "\
Usage: cargo xtask COMMAND

  test [STEP...]       what a change needs: format, layers, references, words, clippy, docs, tests, web, browser
  nightly [PART...]    everything heavy: heavy, browser, benches, publish, and the parts below
  setup                installs what the checks need beyond Rust; `test` does it, too
  layers               dependencies between crates, against the layers of docs/ARCHITECTURE.md
  references           every @key cited in the sources against docs/references.bib
  words [--report]     banned names, openings and phrases in sources and documents; --report: a list that is no failure
  publish --dry-run    packages every crate and builds it from its package
  pbrt-scenes DIR      loads every pbrt scene below DIR with `glanz info`, one line each

Parts of nightly, optimised, with the numbers they have unless others are named:
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let result = match *words.as_slice() {
        ["test", ref steps @ ..] => return checks::test(steps).unwrap_or_else(|why| usage(&why)),
        ["nightly", ref parts @ ..] => return nightly::nightly(parts).unwrap_or_else(|why| usage(&why)),
        ["setup"] => setup::install(),
        ["layers"] => layers::check(),
        ["references"] => references::check(),
        ["words"] => words::check(),
        ["words", "--report"] => words::report(),
        ["publish", "--dry-run"] => publish::dry_run(),
        ["pbrt-scenes", folder] => scenes::load_all(Path::new(folder)),
        ["help" | "--help" | "-h"] => {
            println!("{USAGE}{}", nightly::help());
            return ExitCode::SUCCESS;
        }
        [] => return usage("a command is missing"),
        [name, ref options @ ..] => match nightly::part(name, options) {
            Some(code) => return code.unwrap_or_else(|why| usage(&why)),
            None => return usage(&format!("unknown command \"{}\"", words.join(" "))),
        },
    };
    match result {
        Ok(text) => {
            println!("{text}");
            ExitCode::SUCCESS
        }
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::FAILURE
        }
    }
}

fn usage(complaint: &str) -> ExitCode {
    eprintln!("error: {complaint}\n\n{USAGE}{}", nightly::help());
    ExitCode::from(2)
}
