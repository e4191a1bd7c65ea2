//! The command line and its help.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Parser, ValueHint};
use glanz_sampling::exact::MAX_TERMS;
use glanz_study::studies;
use glanz_terminal::Verbosity;
use glanz_terminal::values::{one_of, seconds, size};

/// Samples per pixel that a film can hold.
const MAX_SAMPLES: i64 = MAX_TERMS as i64;

/// Largest number of rays: a study holds all rays of a group in memory.
const MAX_RAYS: u64 = 30_000_000;

/// Largest number of elements for form factors of all pairs.
const MAX_ELEMENTS: i64 = 50_000;

const HELP: &str = "\
A study writes report.md with its tables (CSV), plots (SVG) and pictures (PNG) into the folder
of --out, which is created if necessary, and prints its summary. All figures except times depend
only on the options and the seed. Ctrl-C ends a study with exit status 130 and without output;
guiding caches its measurements and continues from them when it is called again.

Examples:
  glanz-study                                            list the studies
  glanz-study newton --out newton
  glanz-study tessellation --out triangles --size 640x360 --triangles 1250,20000
  glanz-study guiding --out guiding --rooms uplights --samples 64 --references 1024";

/// Repeats the measurements of the documents behind Glanz; lists the studies if none is named.
#[derive(Debug, Parser)]
#[command(name = "glanz-study", version, max_term_width = 98, after_help = HELP)]
pub(crate) struct StudyArguments {
    /// Study to run
    #[arg(value_name = "NAME", requires = "out", value_parser = one_of(studies().iter().map(|study| study.name)))]
    pub(crate) name: Option<String>,
    /// Folder for the report
    #[arg(short, long, value_name = "DIR", requires = "name", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// Number of random rays or particles (newton, reflector)
    #[arg(long, value_name = "N", requires = "name", value_parser = clap::value_parser!(u64).range(1..=MAX_RAYS))]
    pub(crate) rays: Option<u64>,
    /// Size of the pictures in pixels (tessellation, guiding, reconstruction)
    #[arg(long, value_name = "WxH", requires = "name", value_parser = size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Triangles per surface, each twice a square (tessellation)
    #[arg(long, value_name = "LIST", requires = "name", value_delimiter = ',')]
    pub(crate) triangles: Option<Vec<u64>>,
    /// Scene files, or names of those in scenes/rooms (guiding, solvers)
    #[arg(long, value_name = "LIST", requires = "name", value_delimiter = ',')]
    pub(crate) rooms: Option<Vec<String>>,
    /// Methods to compare with path: tree, or grids by basis, cells and scale, such as haar-8-3 (guiding)
    #[arg(long, value_name = "LIST", requires = "name", value_delimiter = ',')]
    pub(crate) methods: Option<Vec<String>>,
    /// Samples per pixel at which curves end, a power of two (guiding)
    #[arg(long, value_name = "N", requires = "name", value_parser = clap::value_parser!(u32).range(1..=MAX_SAMPLES))]
    pub(crate) samples: Option<u32>,
    /// Samples per pixel of reference pictures (guiding)
    #[arg(long, value_name = "N", requires = "name", value_parser = clap::value_parser!(u32).range(1..=MAX_SAMPLES))]
    pub(crate) references: Option<u32>,
    /// Largest number of elements for form factors of all pairs (solvers)
    #[arg(long, value_name = "N", requires = "name", value_parser = clap::value_parser!(u32).range(1..=MAX_ELEMENTS))]
    pub(crate) elements: Option<u32>,
    /// Number of runs with different seeds, over which errors are averaged (guiding)
    #[arg(long, value_name = "N", requires = "name", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) rounds: Option<u32>,
    /// Render time of each picture of the side-by-side comparison, seconds (guiding)
    #[arg(long, value_name = "SECONDS", requires = "name", value_parser = seconds)]
    pub(crate) time: Option<Duration>,
    /// Number of threads (guiding, reflector, solvers)
    #[arg(long, value_name = "N", requires = "name", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
    /// Repeat all measurements of the document, which takes many hours (guiding)
    #[arg(long, requires = "name")]
    pub(crate) full: bool,
    /// Seed of random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) verbosity: Verbosity,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn definition_is_consistent() {
        StudyArguments::command().debug_assert();
    }

    #[test]
    fn nonsense_is_wrong_usage() {
        for line in [
            "glanz-study alchemy --out a",
            "glanz-study newton",
            "glanz-study --out a",
            "glanz-study newton --out a --rays 0",
            "glanz-study tessellation --out a --triangles many",
            "glanz-study guiding --out a --samples 0",
            "glanz-study guiding --rooms open",
            "glanz-study solvers --out a --elements 0",
        ] {
            let parsed = StudyArguments::try_parse_from(line.split(' '));
            assert_eq!(parsed.map(|_| ()).map_err(|e| e.exit_code()), Err(2), "{line}");
        }
    }
}
