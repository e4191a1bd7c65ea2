//! Picture files.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use glanz_formats::image::{self, Format};
use glanz_light::Tone;

use super::picture::Picture;
use crate::error::{Error, FileFault};
use crate::file;

impl Picture {
    /// Writes the picture in the format of the extension: OpenEXR, PNG (light above 1 is clipped), Radiance HDR or PFM.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        self.save_with(path, &Tone::default())
    }

    /// As [`Picture::save`], with an exposure and a tone curve for PNG.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn save_with(&self, path: impl AsRef<Path>, tone: &Tone) -> Result<(), Error> {
        let path = path.as_ref();
        let format = picture_format(path)?;
        file::write(path, &self.encoded(path, format, tone)?)
    }

    /// Writes the picture to a stream, which is called `name` in errors.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn write_to(
        &self,
        stream: &mut dyn io::Write,
        name: &Path,
        format: Format,
        tone: &Tone,
    ) -> Result<(), Error> {
        let bytes = self.encoded(name, format, tone)?;
        stream.write_all(&bytes).and_then(|()| stream.flush()).map_err(Error::of_file(name))
    }

    fn encoded(&self, path: &Path, format: Format, tone: &Tone) -> Result<Vec<u8>, Error> {
        image::write(&self.pixels()?, format, tone, &attributes(self)).map_err(Error::of_file(path))
    }
}

/// Header attributes of an EXR file: only those that the picture depends on, so that equal pictures are equal files.
fn attributes(picture: &Picture) -> BTreeMap<String, String> {
    let identity = picture.identity();
    let mut entries = vec![
        ("software", format!("Glanz {}", identity.version)),
        ("glanz.integrator", identity.integrator.to_string()),
        ("glanz.sampler", identity.sampler.name().to_owned()),
        ("glanz.samples", picture.film().samples().to_string()),
        ("glanz.seed", identity.seed.to_string()),
    ];
    if let Some(level) = identity.film.noise {
        entries.push(("glanz.noise", level.error().to_string()));
        entries.push(("glanz.mean_samples", picture.film().mean_samples().to_string()));
    }
    if picture.is_denoised() {
        entries.push(("glanz.denoised", "true".to_owned()));
    }
    entries.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

/// The format in which a picture is written to `path`.
///
/// # Errors
/// [`Error::File`] with [`FileFault::Extension`] if the extension is not that of a supported format.
pub fn picture_format(path: &Path) -> Result<Format, Error> {
    Format::from_path(path)
        .filter(|format| matches!(format, Format::Exr | Format::Png | Format::Hdr | Format::Pfm))
        .ok_or_else(|| FileFault::Extension("pictures").of(path))
}
