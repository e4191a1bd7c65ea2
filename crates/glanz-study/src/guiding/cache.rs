//! Cache in the output folder, from which an interrupted study continues.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use glanz_formats::image::{self, Encoding, Format};
use glanz_job::{CheckpointLock, JobIdentity, write_atomically, write_atomically_with};
use glanz_light::{Pixels, Tone};
use glanz_transport::{Checkpoint, Film, PictureIdentity};

use super::curve::{CurvePoint, PictureError};
use crate::study::StudyError;

/// Name of the folder within that of the report.
const FOLDER: &str = "kept";

/// Names of the columns of a run's file.
const COLUMNS: &str = "kind,samples,wall_s,processor_s,l2,modified_l2";

/// Last line of a run's file.
const END: &str = "end\n";

/// Name of the attribute of a picture that identifies it.
const ABOUT: &str = "glanz.study";

/// Measurements of one run of a method.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct RunResult {
    /// Error of the picture as it grew.
    pub(super) curve: Vec<CurvePoint>,
    /// Error of pictures by frozen guides; `samples` counts those learnt from, times are those of the picture.
    pub(super) frozen: Vec<CurvePoint>,
}

impl RunResult {
    /// The points of `curve` and `frozen` with these numbers of samples; `None` if one is missing.
    pub(super) fn part(&self, curve: &[u32], frozen: &[u32]) -> Option<Self> {
        let pick = |points: &[CurvePoint], samples: &[u32]| -> Option<Vec<CurvePoint>> {
            samples.iter().map(|&n| points.iter().find(|p| p.samples == n).copied()).collect()
        };
        Some(Self { curve: pick(&self.curve, curve)?, frozen: pick(&self.frozen, frozen)? })
    }

    /// Text of the file; `about` (one line) lists everything the run depends on.
    fn to_text(&self, about: &str) -> String {
        let mut text = format!("{about}\n{COLUMNS}\n");
        for (kind, points) in [("curve", &self.curve), ("frozen", &self.frozen)] {
            for CurvePoint { samples, wall, processors, error } in points {
                let PictureError { plain, shown } = error;
                let _ = writeln!(text, "{kind},{samples},{wall},{processors},{plain},{shown}");
            }
        }
        text + END
    }

    /// Parses the text of [`RunResult::to_text`]; `None` for any other text.
    fn from_text(text: &str, about: &str) -> Option<Self> {
        let mut lines = text.strip_suffix(END)?.lines();
        if lines.next() != Some(about) || lines.next() != Some(COLUMNS) {
            return None;
        }
        let mut run = Self::default();
        for line in lines {
            let mut cells = line.split(',');
            let points = match cells.next()? {
                "curve" => &mut run.curve,
                "frozen" => &mut run.frozen,
                _ => return None,
            };
            let samples = cells.next()?.parse().ok()?;
            let numbers: Vec<f64> = cells.map(|cell| cell.parse().ok()).collect::<Option<_>>()?;
            let &[wall, processors, plain, shown] = numbers.as_slice() else { return None };
            points.push(CurvePoint { samples, wall, processors, error: PictureError { plain, shown } });
        }
        Some(run)
    }
}

/// The cache folder; `None` disables caching.
#[derive(Clone, Debug)]
pub(super) struct ResultCache(Option<PathBuf>);

impl ResultCache {
    /// The cache in the folder `out`, or a disabled one.
    ///
    /// # Errors
    /// [`StudyError::File`] if the folder cannot be created.
    pub(super) fn within(out: Option<&Path>) -> Result<Self, StudyError> {
        let Some(folder) = out.map(|out| out.join(FOLDER)) else { return Ok(Self(None)) };
        glanz_job::make_folder(&folder).map_err(|source| failed(&folder, source))?;
        Ok(Self(Some(folder)))
    }

    fn path(&self, name: &str, extension: &str) -> Option<PathBuf> {
        Some(self.0.as_ref()?.join(format!("{name}.{extension}")))
    }

    /// The cached run `name`, if `about` is equal.
    pub(super) fn run(&self, name: &str, about: &str) -> Option<RunResult> {
        RunResult::from_text(&std::fs::read_to_string(self.path(name, "csv")?).ok()?, about)
    }

    /// Stores the run `name`.
    ///
    /// # Errors
    /// [`StudyError::File`].
    pub(super) fn store_run(&self, name: &str, about: &str, run: &RunResult) -> Result<(), StudyError> {
        let Some(path) = self.path(name, "csv") else { return Ok(()) };
        Ok(write_atomically(&path, run.to_text(about).as_bytes())?)
    }

    /// Claims the checkpoint `name` until the result is dropped, so that no other process adds to it meanwhile.
    ///
    /// # Errors
    /// [`StudyError::File`] if another process has it, or it cannot be locked.
    pub(super) fn claim(&self, name: &str) -> Result<Option<CheckpointLock>, StudyError> {
        let Some(path) = self.path(name, "glanz") else { return Ok(None) };
        CheckpointLock::acquire(&path).map_err(|error| failed(&path, std::io::Error::other(error)))
    }

    /// The film of the checkpoint `name`, if there is one.
    ///
    /// # Errors
    /// [`StudyError::Cache`] for a file that is not a checkpoint of this picture; it may have cost hours, and is not overwritten.
    pub(super) fn film(&self, name: &str, wanted: &PictureIdentity) -> Result<Option<Film>, StudyError> {
        let Some(path) = self.path(name, "glanz").filter(|path| path.exists()) else { return Ok(None) };
        let bytes = std::fs::read(&path).map_err(|source| failed(&path, source))?;
        let refused = |why: String| StudyError::Cache { path: path.display().to_string(), why };
        let checkpoint = Checkpoint::from_bytes(&bytes).map_err(|error| refused(error.to_string()))?;
        checkpoint.identity.check(wanted).map_err(|mismatch| refused(mismatch.to_string()))?;
        Ok(Some(checkpoint.film))
    }

    /// Stores a film as a checkpoint.
    ///
    /// # Errors
    /// [`StudyError::File`].
    pub(super) fn store_film(
        &self,
        name: &str,
        identity: &PictureIdentity,
        film: &Film,
    ) -> Result<(), StudyError> {
        let Some(path) = self.path(name, "glanz") else { return Ok(()) };
        Ok(write_atomically_with(&path, |out| Checkpoint::write(identity, film, out))?)
    }

    /// The cached picture `name` with its number of samples per pixel, if `about` is equal.
    pub(super) fn picture(&self, name: &str, about: &str) -> Option<(Pixels, u64)> {
        let bytes = std::fs::read(self.path(name, "exr")?).ok()?;
        let image = image::read(&bytes, None, Encoding::Srgb).ok()?;
        let (samples, found) = image.attributes.get(ABOUT)?.split_once(' ')?;
        (found == about).then_some((image.pixels, samples.parse().ok()?))
    }

    /// Stores a picture with `samples` per pixel.
    ///
    /// # Errors
    /// [`StudyError::File`].
    pub(super) fn store_picture(
        &self,
        name: &str,
        about: &str,
        pixels: &Pixels,
        samples: u64,
    ) -> Result<(), StudyError> {
        let Some(path) = self.path(name, "exr") else { return Ok(()) };
        let attributes = BTreeMap::from([(ABOUT.to_owned(), format!("{samples} {about}"))]);
        let bytes = image::write(pixels, Format::Exr, &Tone::default(), &attributes)?;
        Ok(write_atomically(&path, &bytes)?)
    }
}

fn failed(path: &Path, source: std::io::Error) -> StudyError {
    StudyError::File { path: path.display().to_string(), source }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> RunResult {
        let point = |samples| CurvePoint {
            samples,
            wall: 0.1 + f64::from(samples),
            processors: 1.0 / 3.0,
            error: PictureError { plain: 1e-9, shown: 1e-30 },
        };
        RunResult { curve: [1, 2, 4].map(point).into(), frozen: vec![point(4)] }
    }

    #[test]
    fn runs_come_back_with_every_digit() {
        let run = example();
        assert_eq!(RunResult::from_text(&run.to_text("this, that"), "this, that"), Some(run));
    }

    #[test]
    fn runs_of_something_else_or_damaged_are_not_taken() {
        let text = example().to_text("this");
        assert_eq!(RunResult::from_text(&text, "that"), None);
        assert_eq!(RunResult::from_text(&text[..text.len() - 12], "this"), None);
        assert_eq!(RunResult::from_text(&text.replace("frozen", "melted"), "this"), None);
        assert_eq!(RunResult::from_text("", "this"), None);
    }

    #[test]
    fn a_checkpoint_is_claimed_by_one_at_a_time() {
        let out = std::env::temp_dir().join(format!("glanz-study-claims-{}", std::process::id()));
        let cache = ResultCache::within(Some(&out)).unwrap();
        let claim = cache.claim("reference").unwrap();
        assert!(claim.is_some());
        let error = cache.claim("reference").unwrap_err().to_string();
        assert!(error.ends_with("is writing this checkpoint"), "{error}");
        drop(claim);
        assert!(cache.claim("reference").is_ok());
        assert!(ResultCache(None).claim("reference").unwrap().is_none());
        std::fs::remove_dir_all(&out).unwrap();
    }

    #[test]
    fn a_longer_run_holds_a_shorter_one() {
        let run = example();
        let part = run.part(&[1, 4], &[]).unwrap();
        assert_eq!((part.curve.len(), part.frozen.len(), part.curve[1].samples), (2, 0, 4));
        assert_eq!((run.part(&[1, 8], &[]), run.part(&[1], &[2])), (None, None));
    }
}
