//! Output files of a calculation.

use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

use glanz_formats::image::{self, Format, ImageError};
use glanz_illumination::report::{
    LuxComparison, LuxReport, csv, false_colour, isolux, lux_pixels, lux_scale,
};
use glanz_illumination::{LuxMap, Receivers};
use glanz_light::Tone;

use super::{IlluminateMethod, IlluminateOutcome};
use crate::error::Error;
use crate::file;

/// The JSON report.
pub(super) const REPORT: &str = "report.json";

/// All reports.
const REPORTS: [&str; 3] = ["report.html", REPORT, "summary.txt"];

/// The files of a comparison.
const COMPARISON: [&str; 2] = ["comparison.html", "comparison.txt"];

/// The extensions of the files of a map.
const MAP_EXTENSIONS: [&str; 4] = ["csv", "svg", "exr", "png"];

impl IlluminateOutcome {
    /// Writes reports and maps into a folder, which is created if necessary; returns the files.
    ///
    /// The reports are `report.html`, `report.json` and `summary.txt`; each receiver has a table (CSV), its numbers as a picture (EXR),
    /// false colours (PNG) and isolux lines (SVG). The maps of equal calculations have the same bytes. Reports also have times, rates, the machine and the
    /// date ([`LuxReport::facts`]); if the variable `SOURCE_DATE_EPOCH` was set (seconds since 1970) when the calculation ended, they have that date only.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn save(&self, folder: impl AsRef<Path>) -> Result<Vec<PathBuf>, Error> {
        let folder = folder.as_ref();
        let mut files = ReportFolder { folder, written: self.save_reports(folder)? };
        for (name, map) in self.named_maps() {
            files.write_map(&name, map)?;
        }
        Ok(files.written)
    }

    /// As [`IlluminateOutcome::save`], of the reports alone: after the maps, a ray file adds its facts to them.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn save_reports(&self, folder: impl AsRef<Path>) -> Result<Vec<PathBuf>, Error> {
        let mut files = ReportFolder::try_new(folder.as_ref())?;
        files.write_reports(&self.report)?;
        Ok(files.written)
    }

    /// All maps with the names of their files, without extensions.
    fn named_maps(&self) -> Vec<(String, &LuxMap)> {
        let names = |maps: &'_ [LuxMap]| maps.iter().map(|map| map.name.clone()).collect::<Vec<_>>();
        let named = map_names(&names(&self.report.maps), &names(&self.integrated));
        named.into_iter().zip(self.report.maps.iter().chain(&self.integrated)).collect()
    }
}

/// Names of the files of maps, without extensions: of those of one method, and of those by integration beside them.
fn map_names(counted: &[String], integrated: &[String]) -> Vec<String> {
    let mut names = FileNames::default();
    let counted = counted.iter().map(|name| (name, ""));
    let integrated = integrated.iter().map(|name| (name, " integrated"));
    counted.chain(integrated).map(|(name, more)| names.of_map(name, more)).collect()
}

/// The files that [`IlluminateOutcome::save`] writes into this folder for a calculation by `method`.
pub(super) fn result_paths(
    folder: &Path,
    receivers: &Receivers,
    method: IlluminateMethod,
) -> impl Iterator<Item = PathBuf> {
    let names: Vec<String> = receivers.as_slice().iter().map(|receiver| receiver.name().to_owned()).collect();
    let integrated = if method == IlluminateMethod::Both { names.as_slice() } else { &[] };
    let maps = map_names(&names, integrated).into_iter();
    let maps = maps.flat_map(|name| MAP_EXTENSIONS.map(|extension| format!("{name}.{extension}")));
    let names: Vec<String> = REPORTS.map(str::to_owned).into_iter().chain(maps).collect();
    names.into_iter().map(|name| folder.join(name))
}

/// Writes two designs, into the folders `a` and `b` of `folder`, and their comparison; returns the files.
///
/// # Errors
/// [`Error::File`].
pub fn save_comparison(
    folder: impl AsRef<Path>,
    [a, b]: [&IlluminateOutcome; 2],
) -> Result<Vec<PathBuf>, Error> {
    let folder = folder.as_ref();
    let mut files = ReportFolder::try_new(folder)?;
    let comparison = LuxComparison::between(&a.report, &b.report);
    for (name, text) in COMPARISON.into_iter().zip([comparison.html(), comparison.text()]) {
        files.write(name, text.as_bytes())?;
    }
    for (design, folder) in [a, b].into_iter().zip(comparison_folders(folder)) {
        files.written.extend(design.save(folder)?);
    }
    Ok(files.written)
}

/// The files that [`save_comparison`] writes into this folder, beside those of the designs.
#[must_use]
pub fn comparison_paths(folder: &Path) -> [PathBuf; 2] {
    COMPARISON.map(|name| folder.join(name))
}

/// The folders of the two designs that [`save_comparison`] creates in this folder.
#[must_use]
pub fn comparison_folders(folder: &Path) -> [PathBuf; 2] {
    ["a", "b"].map(|name| folder.join(name))
}

/// Output folder with its files.
struct ReportFolder<'a> {
    folder: &'a Path,
    written: Vec<PathBuf>,
}

impl<'a> ReportFolder<'a> {
    /// Creates the folder if it does not exist.
    fn try_new(folder: &'a Path) -> Result<Self, Error> {
        file::make_folder(folder)?;
        Ok(Self { folder, written: Vec::new() })
    }

    fn write(&mut self, name: &str, bytes: &[u8]) -> Result<(), Error> {
        let path = self.folder.join(name);
        file::write(&path, bytes)?;
        self.written.push(path);
        Ok(())
    }

    fn write_picture(&mut self, name: &str, bytes: Result<Vec<u8>, ImageError>) -> Result<(), Error> {
        self.write(name, &bytes.map_err(Error::of_file(&self.folder.join(name)))?)
    }

    fn write_reports(&mut self, report: &LuxReport) -> Result<(), Error> {
        let json = serde_json::to_string_pretty(report);
        let mut json = json.map_err(Error::of_file(&self.folder.join(REPORT)))?;
        json.push('\n');
        let texts = [report.html(), json, report.text()];
        REPORTS.into_iter().zip(texts).try_for_each(|(name, text)| self.write(name, text.as_bytes()))
    }

    fn write_map(&mut self, name: &str, map: &LuxMap) -> Result<(), Error> {
        let scale = lux_scale(&[map]);
        self.write(&format!("{name}.csv"), csv(map).as_bytes())?;
        self.write(&format!("{name}.svg"), isolux(map, &scale).as_bytes())?;
        let software = format!("Glanz {}", glanz_job::current_version());
        let attributes = BTreeMap::from([("software".to_owned(), software)]);
        let lux = image::write(&lux_pixels(map)?, Format::Exr, &Tone::default(), &attributes);
        self.write_picture(&format!("{name}.exr"), lux)?;
        let colours = false_colour(map, &scale)?;
        let png = image::write_srgb8(colours.width(), colours.height(), colours.pixels());
        self.write_picture(&format!("{name}.png"), png)
    }
}

/// Unique file names for receivers.
#[derive(Default)]
pub(super) struct FileNames(HashSet<String>);

impl FileNames {
    /// The name for a map: letters, digits, `-`, `_`, `.` and `=` are kept, all others become `-`. Names that differ only in case count
    /// as equal, as in some file systems.
    pub(super) fn of_map(&mut self, name: &str, more: &str) -> String {
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
        let mut names = FileNames::default();
        assert_eq!(names.of_map("wall x=10", ""), "wall-x=10");
        assert_eq!(names.of_map("../Wall x=10", ""), "Wall-x=10-2");
        assert_eq!(names.of_map("wall x=10", " integrated"), "wall-x=10-integrated");
        assert_eq!(names.of_map("..", ""), "receiver");
        assert_eq!(names.of_map("/", ""), "receiver-2");
        assert_eq!(names.of_map("Größe", ""), "Größe");
    }
}
