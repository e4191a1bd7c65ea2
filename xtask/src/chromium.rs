//! The browser that tests of the viewer drive: the one that is installed, or one from a package of npm.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use crate::setup::{find_program, in_target, run_quietly};

/// Its names, which the tests know, too.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// A package whose content is Chromium for Linux on x86-64, compressed: the program, OpenGL in software, and the libraries that a
/// system without a desktop lacks.
const PACKAGE: &str = "@sparticuz/chromium@133.0.0";

/// Run by Node.js in the folder of the package, since no other tool that is sure to be there reads Brotli.
const UNPACK: &str = "
const { createReadStream, createWriteStream } = require('node:fs');
const { createBrotliDecompress } = require('node:zlib');
const { pipeline } = require('node:stream/promises');
const files = { 'chromium.br': 'chromium', 'swiftshader.tar.br': 'swiftshader.tar', 'al2023.tar.br': 'libraries.tar' };
(async () => {
  for (const [from, to] of Object.entries(files))
    await pipeline(createReadStream('bin/' + from), createBrotliDecompress(), createWriteStream(to, { mode: 0o755 }));
})();
";

/// Starts the unpacked program with the libraries that came with it, behind those of the system.
const START: &str = r#"#!/bin/sh
here=$(dirname "$0")
LD_LIBRARY_PATH="${LD_LIBRARY_PATH:+$LD_LIBRARY_PATH:}$here:$here/libraries/lib" exec "$here/chromium" "$@"
"#;

/// The program: the one that `CHROMIUM` names, the first on the search path, or the one of the package.
pub(crate) fn find() -> Option<PathBuf> {
    if let Some(chosen) = std::env::var_os("CHROMIUM") {
        return Some(chosen.into());
    }
    let unpacked = in_target("chromium/start.sh");
    NAMES.iter().find_map(|name| find_program(name)).or_else(|| unpacked.is_file().then_some(unpacked))
}

/// Whether the package is for this machine.
pub(crate) fn has_package() -> bool {
    cfg!(all(target_os = "linux", target_arch = "x86_64"))
}

/// Gets the package and unpacks it below the folder of build outputs.
///
/// # Errors
/// What failed.
pub(crate) fn install_package() -> Result<(), String> {
    if !has_package() {
        return Err("npm has no Chromium for this machine".to_owned());
    }
    let folder = in_target("chromium");
    let error = |error: std::io::Error| format!("{}: {error}", folder.display());
    // What an interrupted installation left.
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(folder.join("libraries")).map_err(error)?;
    let here = |program: &str, arguments: &[&str]| {
        run_quietly(Command::new(program).current_dir(&folder).args(arguments))
    };
    here("npm", &["pack", "--silent", PACKAGE])?;
    let archive = fs::read_dir(&folder).map_err(error)?.flatten().map(|entry| entry.file_name());
    let archive = archive.filter_map(|name| name.into_string().ok()).find(|name| name.ends_with(".tgz"));
    let archive = archive.as_deref().ok_or("npm pack gave no archive")?;
    here("tar", &["-xzf", archive, "--strip-components=1"])?;
    here("node", &["-e", UNPACK])?;
    here("tar", &["-xf", "swiftshader.tar"])?;
    here("tar", &["-xf", "libraries.tar", "-C", "libraries"])?;
    let start = folder.join("start.sh.part");
    here("rm", &["-r", archive, "bin", "build", "swiftshader.tar", "libraries.tar"])?;
    fs::write(&start, START).map_err(error)?;
    here("chmod", &["755", "start.sh.part"])?;
    run_quietly(Command::new(&start).arg("--version"))?;
    fs::rename(&start, folder.join("start.sh")).map_err(error)
}
