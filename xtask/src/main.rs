//! Housekeeping of the workspace; `cargo xtask` lists what it can do.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command line talks to its user")]

mod layers;
mod references;
mod scenes;
mod steps;
mod web;
mod workspace;

use std::path::Path;
use std::process::ExitCode;

const USAGE: &str = "\
Usage: cargo xtask COMMAND

  test [STEP...]       every check of the project: format, clippy, layers, references, web, docs, browser, tests
  layers               which crate uses which, against the floors of docs/ARCHITECTURE.md
  references           every @key cited in the sources against docs/references.bib
  contract [--rays N]  the surface contract with N random rays per surface kind (default 10000000), optimised
  zoo [--rays N] [--adversarial M] [--patches FILE...]
                       rays against the reference over the zoo of patches (default 10000000 and 1000000), optimised
  seam [--rays N]      rays across the seam of two trimmed faces (default 100000000), optimised
  unbiased [--samples N]
                       Z-test of `guided` and `light` against `path` in all scenes with N samples per pixel (default 16384), optimised
  bake [--points N] [--samples M]
                       light maps of scenes/rooms/vase.pbrt against path tracing at N points with M paths each (default 1000 and
                       8192), optimised
  soak [--pages N] [--seconds S]
                       N pages that come, orbit, misbehave and leave `glanz view` for S seconds (default 100 and 300), optimised
  pbrt-scenes DIR      loads every pbrt scene below DIR with `glanz info` and lists what came of it";

/// Rays per surface kind of `cargo xtask contract`: what a release is checked with.
const CONTRACT_RAYS: u64 = 10_000_000;

/// Random and hard rays of `cargo xtask zoo`: what a release is checked with.
const ZOO_RAYS: [u64; 2] = [10_000_000, 1_000_000];

/// Rays of `cargo xtask seam`: what a release is checked with.
const SEAM_RAYS: u64 = 100_000_000;

/// Samples per pixel of `cargo xtask unbiased`.
const UNBIASED_SAMPLES: u32 = 16_384;

/// Points and paths of `cargo xtask bake`.
const BAKE: [u32; 2] = [1000, 8192];

/// Pages and seconds of `cargo xtask soak`.
const SOAK: [u32; 2] = [100, 300];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match *words.as_slice() {
        ["test", ref steps @ ..] => match steps::test(steps) {
            Ok(code) => return code,
            Err(complaint) => return usage(&complaint),
        },
        ["layers"] => layers::check().map_err(|breaches| breaches.join("\n")),
        ["references"] => references::check().map_err(|missing| missing.join("\n")),
        ["contract"] => steps::contract(CONTRACT_RAYS),
        ["contract", "--rays", count] => match count.parse() {
            Ok(rays) => steps::contract(rays),
            Err(_) => return usage(&format!("\"{count}\" is not a number of rays")),
        },
        ["zoo", ref options @ ..] => match zoo_options(options) {
            Ok(([rays, adversarial], patches)) => steps::zoo(rays, adversarial, patches),
            Err(complaint) => return usage(&complaint),
        },
        ["seam"] => steps::seam(SEAM_RAYS),
        ["seam", "--rays", count] => match count.parse() {
            Ok(rays) => steps::seam(rays),
            Err(_) => return usage(&format!("\"{count}\" is not a number of rays")),
        },
        ["unbiased"] => steps::unbiased(UNBIASED_SAMPLES),
        ["unbiased", "--samples", count] => match count.parse() {
            Ok(samples) => steps::unbiased(samples),
            Err(_) => return usage(&format!("\"{count}\" is not a number of samples")),
        },
        ["bake", ref options @ ..] => match two_numbers(["--points", "--samples"], BAKE, options) {
            Ok(counts) => steps::bake(counts),
            Err(complaint) => return usage(&format!("bake: {complaint}")),
        },
        ["soak", ref options @ ..] => match two_numbers(["--pages", "--seconds"], SOAK, options) {
            Ok(counts) => steps::soak(counts),
            Err(complaint) => return usage(&format!("soak: {complaint}")),
        },
        ["pbrt-scenes", folder] => scenes::load_all(Path::new(folder)),
        ["help" | "--help" | "-h"] => {
            println!("{USAGE}");
            return ExitCode::SUCCESS;
        }
        [] => return usage("a command is missing"),
        _ => return usage(&format!("unknown command \"{}\"", words.join(" "))),
    };
    match outcome {
        Ok(said) => {
            println!("{said}");
            ExitCode::SUCCESS
        }
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::FAILURE
        }
    }
}

/// Random rays, hard rays, and files of patches.
fn zoo_options<'a>(mut options: &'a [&'a str]) -> Result<([u64; 2], &'a [&'a str]), String> {
    let mut counts = ZOO_RAYS;
    loop {
        options = match *options {
            [] => return Ok((counts, &[])),
            ["--patches", ref files @ ..] if !files.is_empty() => return Ok((counts, files)),
            [name @ ("--rays" | "--adversarial"), count, ref rest @ ..] => {
                let slot = usize::from(name == "--adversarial");
                counts[slot] = count.parse().map_err(|_| format!("\"{count}\" is not a number of rays"))?;
                rest
            }
            [other, ..] => return Err(format!("the zoo knows no \"{other}\" there")),
        };
    }
}

/// Two numbers that options of these names set, in any order, or what they are otherwise.
fn two_numbers(names: [&str; 2], otherwise: [u32; 2], mut options: &[&str]) -> Result<[u32; 2], String> {
    let mut numbers = otherwise;
    loop {
        options = match *options {
            [] => return Ok(numbers),
            [name, number, ref rest @ ..] if names.contains(&name) => {
                let slot = usize::from(name == names[1]);
                numbers[slot] = number.parse().map_err(|_| format!("\"{number}\" is not a number"))?;
                rest
            }
            [other, ..] => return Err(format!("\"{other}\" is not known there")),
        };
    }
}

fn usage(complaint: &str) -> ExitCode {
    eprintln!("error: {complaint}\n\n{USAGE}");
    ExitCode::from(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_of_the_zoo_come_in_any_order_with_the_files_last() {
        assert_eq!(zoo_options(&[]), Ok((ZOO_RAYS, &[][..])));
        let words = ["--adversarial", "5", "--rays", "7", "--patches", "a.rib", "b.txt"];
        assert_eq!(zoo_options(&words), Ok(([7, 5], &["a.rib", "b.txt"][..])));
        for wrong in [&["--rays"][..], &["--rays", "many"], &["--patches"], &["7"]] {
            assert!(zoo_options(wrong).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn two_numbers_come_in_any_order_and_keep_what_is_not_said() {
        let read = |words: &[&str]| two_numbers(["--pages", "--seconds"], [100, 300], words);
        assert_eq!(read(&[]), Ok([100, 300]));
        assert_eq!(read(&["--seconds", "5"]), Ok([100, 5]));
        assert_eq!(read(&["--seconds", "5", "--pages", "7"]), Ok([7, 5]));
        for wrong in [&["--pages"][..], &["--pages", "many"], &["--points", "7"], &["7"]] {
            assert!(read(wrong).is_err(), "{wrong:?}");
        }
    }
}
