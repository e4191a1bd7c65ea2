//! Housekeeping of the workspace; `cargo xtask` lists its commands.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command line prints")]

mod checks;
mod chromium;
mod farm;
mod layers;
mod nightly;
mod publish;
mod python;
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

  test [STEP...]       the checks of a change: format, layers, references, words, clippy, docs, tests, web, browser
  nightly [PART...]    all long checks: heavy, browser, memory (valgrind), benches, publish, farm, python, and the parts below
  farm [JOB...]        jobs in parts by Open Job Description and Slurm, against single runs; GLANZ may name the program
  setup                installs the tools of the checks; `test` does so, too
  layers               dependencies between crates, against the layers of docs/ARCHITECTURE.md
  references           every @key cited in the sources against docs/references.bib
  words [--report]     banned names and phrases, and names with two definitions; with --report it only lists them
  publish --dry-run    packages every crate and builds it from its package
  python               builds the Python package into a fresh virtual environment, runs its tests and notebooks, checks its types
  pbrt-scenes DIR      loads every pbrt scene below DIR with `glanz info`, one line each

Parts of nightly, optimised, with their default numbers:
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let result = match *words.as_slice() {
        ["test", ref steps @ ..] => return checks::test(steps).unwrap_or_else(|why| usage(&why)),
        ["nightly", ref parts @ ..] => return nightly::nightly(parts).unwrap_or_else(|why| usage(&why)),
        ["farm", ref jobs @ ..] => return farm::run(jobs).unwrap_or_else(|why| usage(&why)),
        ["setup"] => setup::install(),
        ["layers"] => layers::check(),
        ["references"] => references::check(),
        ["words"] => words::check(),
        ["words", "--report"] => words::report(),
        ["publish", "--dry-run"] => publish::dry_run(),
        ["python"] => python::check(),
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
