//! What is written for people and programs.

use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

use glanz_formats::image::{self, Format, write_atomically};
use glanz_illumination::LuxMap;
use glanz_illumination::report::{LuxReport, csv, false_colour, isolux, lux_pixels, lux_scale};
use glanz_light::{Pixels, Tone};

use super::Found;
use crate::messages::Failure;

/// The report for programs.
pub(crate) const REPORT: &str = "report.json";

/// Makes the folder if it is not there.
///
/// # Errors
/// Why it cannot be.
pub(crate) fn make_folder(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::new(format!("{}: cannot be made: {error}", folder.display())))
}

/// Writes `bytes` and says the name of the file.
///
/// # Errors
/// Why it cannot be written.
pub(crate) fn write(path: &Path, bytes: &[u8], written: &mut Vec<String>) -> Result<(), Failure> {
    write_atomically(path, bytes).map_err(|error| Failure::new(error.to_string()))?;
    written.push(path.display().to_string());
    Ok(())
}

/// Writes all that was found of a design into a folder; returns the names of the files.
///
/// # Errors
/// What cannot be written.
pub(crate) fn write_all(folder: &Path, found: &Found) -> Result<Vec<String>, Failure> {
    make_folder(folder)?;
    let mut written = Vec::new();
    let report = &found.report;
    write_reports(folder, report, &mut written)?;
    let mut names = Names::default();
    for map in &report.maps {
        write_map(folder, &names.file_of(&map.name, ""), map, &mut written)?;
    }
    for map in &found.integrated {
        write_map(folder, &names.file_of(&map.name, " integrated"), map, &mut written)?;
    }
    Ok(written)
}

fn write_reports(folder: &Path, report: &LuxReport, written: &mut Vec<String>) -> Result<(), Failure> {
    let mut json = serde_json::to_string_pretty(report)
        .map_err(|error| Failure::new(format!("{}: {error}", folder.join(REPORT).display())))?;
    json.push('\n');
    write(&folder.join("report.html"), report.html().as_bytes(), written)?;
    write(&folder.join(REPORT), json.as_bytes(), written)?;
    write(&folder.join("summary.txt"), report.text().as_bytes(), written)
}

fn write_map(folder: &Path, name: &str, map: &LuxMap, written: &mut Vec<String>) -> Result<(), Failure> {
    let path = |extension: &str| -> PathBuf { folder.join(format!("{name}.{extension}")) };
    let scale = lux_scale(&[map]);
    write(&path("csv"), csv(map).as_bytes(), written)?;
    write(&path("svg"), isolux(map, &scale).as_bytes(), written)?;
    let failed =
        |path: &Path, error: &dyn std::fmt::Display| Failure::new(format!("{}: {error}", path.display()));
    let exr = path("exr");
    let pixels = lux_pixels(map).map_err(|error| failed(&exr, &error))?;
    write(&exr, &encoded(&pixels, Format::Exr, &exr)?, written)?;
    let png = path("png");
    let pixels = false_colour(map, &scale).map_err(|error| failed(&png, &error))?;
    write(&png, &encoded(&pixels, Format::Png, &png)?, written)
}

fn encoded(pixels: &Pixels, format: Format, path: &Path) -> Result<Vec<u8>, Failure> {
    let attributes =
        BTreeMap::from([("software".to_owned(), format!("Glanz {}", env!("CARGO_PKG_VERSION")))]);
    image::write(pixels, format, &Tone::default(), &attributes)
        .map_err(|error| Failure::new(format!("{}: {error}", path.display())))
}

/// File names for receivers, none twice.
#[derive(Default)]
pub(crate) struct Names(HashSet<String>);

impl Names {
    /// Letters, digits, `-`, `_`, `.` and `=` stay, all else becomes `-`; names are told apart without regard to case, as some
    /// file systems do.
    pub(crate) fn file_of(&mut self, name: &str, more: &str) -> String {
        let keep = |c: char| if c.is_alphanumeric() || "-_.=".contains(c) { c } else { '-' };
        let plain: String = format!("{name}{more}").chars().take(100).map(keep).collect();
        let plain = plain.trim_start_matches(['.', '-']);
        let plain = if plain.is_empty() { "receiver" } else { plain };
        let mut file = plain.to_owned();
        let mut number = 2;
        while !self.0.insert(file.to_lowercase()) {
            file = format!("{plain}-{number}");
            number += 1;
        }
        file
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_are_tame_and_differ() {
        let mut names = Names::default();
        assert_eq!(names.file_of("wall x=10", ""), "wall-x=10");
        assert_eq!(names.file_of("../Wall x=10", ""), "Wall-x=10-2");
        assert_eq!(names.file_of("wall x=10", " integrated"), "wall-x=10-integrated");
        assert_eq!(names.file_of("..", ""), "receiver");
        assert_eq!(names.file_of("/", ""), "receiver-2");
        assert_eq!(names.file_of("Größe", ""), "Größe");
    }
}
