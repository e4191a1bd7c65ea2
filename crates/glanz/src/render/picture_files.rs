//! Picture files.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Seek};
use std::path::Path;

use glanz_formats::image::{self, Format, ImageError, RowPicture};
use glanz_job::ScratchFile;
use glanz_light::Tone;
use glanz_transport::{FilmError, FilmFormat, channel_names};

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
        match (self.is_in_file(), file::is_pipe(path)) {
            (true, false) => self.save_rows(path, format, tone),
            (true, true) => {
                let mut spooled = self.spooled(path, format, tone)?;
                file::write_with(path, |out| io::copy(&mut spooled, out).map(drop))
            }
            (false, _) => file::write(path, &self.encoded(path, format, tone)?),
        }
    }

    /// Writes the picture to a stream, which is called `name` in errors.
    ///
    /// # Errors
    /// [`Error::File`]; [`Error::Film`] if the temporary file of a large picture failed.
    pub fn write_to(
        &self,
        stream: &mut dyn io::Write,
        name: &Path,
        format: Format,
        tone: &Tone,
    ) -> Result<(), Error> {
        let written = match self.is_in_file() {
            true => io::copy(&mut self.spooled(name, format, tone)?, stream).map(drop),
            false => stream.write_all(&self.encoded(name, format, tone)?),
        };
        written.and_then(|()| stream.flush()).map_err(Error::of_file(name))
    }

    fn encoded(&self, path: &Path, format: Format, tone: &Tone) -> Result<Vec<u8>, Error> {
        image::write(&self.pixels()?, format, tone, &attributes(self)).map_err(Error::of_file(path))
    }

    /// Writes the file with some rows in memory at a time.
    fn save_rows(&self, path: &Path, format: Format, tone: &Tone) -> Result<(), Error> {
        let mut refused = None;
        let written = file::write_file_with(path, |out| self.write_rows(out, format, tone, &mut refused));
        refused.map_or(written, |error| Err(Error::of_file(path)(error)))
    }

    /// A temporary file without a name that holds the bytes of the picture, at its beginning; written with some rows in memory at a time. Some formats
    /// return to earlier bytes, which streams cannot.
    fn spooled(&self, name: &Path, format: Format, tone: &Tone) -> Result<File, Error> {
        let FilmFormat { crop, aovs, .. } = *self.film().format();
        let bytes = 4 * channel_names(aovs).len() as u64 * crop.len();
        let scratch = ScratchFile::try_new(0).map_err(FilmError::from)?;
        let failed = |error: io::Error| Error::Film(scratch.error(&error, bytes).into());
        let mut file = scratch.stream().map_err(FilmError::from)?;
        let mut refused = None;
        let written = self.write_rows(&mut file, format, tone, &mut refused).and_then(|()| file.rewind());
        match refused {
            Some(error) => Err(Error::of_file(name)(error)),
            None => written.map(|()| file).map_err(failed),
        }
    }

    /// Writes the bytes of the picture to an empty file; `refused`: an error other than that of the file.
    fn write_rows(
        &self,
        out: &mut File,
        format: Format,
        tone: &Tone,
        refused: &mut Option<ImageError>,
    ) -> io::Result<()> {
        let film = self.film();
        let picture = RowPicture {
            size: film.format().crop.size,
            channels: &channel_names(film.format().aovs),
            tone,
            attributes: &attributes(self),
        };
        let rows = |rows| film.rows_to_pixels(rows).map_err(io::Error::other);
        image::write_rows(&picture, format, out, rows).map_err(|error| match error {
            ImageError::Write(error) => error,
            other => io::Error::other(refused.insert(other).to_string()),
        })
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

#[cfg(test)]
mod tests {
    use std::env;

    use glanz_scene::SceneBuilder;
    use glanz_scene::description::{LightDescription, MaterialKind, ShapeDescription};
    use glanz_transport::AovSet;

    use super::*;
    use crate::{LoadedScene, RenderOptions};

    #[test]
    fn files_of_films_in_files_are_those_of_films_in_memory() {
        let folder = env::temp_dir().join(format!("glanz-rows-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let scene = SceneBuilder::new()
            .resolution(23, 37)
            .light(LightDescription::infinite([0.7, 0.5, 0.2]))
            .shape(ShapeDescription::sphere(1.0).translated([0.3, 0.2, 3.0]), MaterialKind::diffuse(0.5))
            .describe()
            .unwrap();
        let picture = |film_memory| {
            let options = RenderOptions { aovs: AovSet::ALL, film_memory, ..RenderOptions::default() };
            LoadedScene::from_description("ball", scene.clone())
                .render()
                .options(options)
                .samples(2)
                .run()
                .unwrap()
        };
        let (whole, rows) = (picture(None), picture(Some(0)));
        assert!(rows.is_in_file() && !whole.is_in_file());
        for name in ["a.exr", "a.png", "a.hdr", "a.pfm"] {
            let path = folder.join(name);
            let saved = |picture: &Picture| {
                picture.save(&path).unwrap();
                std::fs::read(&path).unwrap()
            };
            assert!(saved(&whole) == saved(&rows), "{name}");
            let mut streamed: Vec<u8> = Vec::new();
            let format = picture_format(&path).unwrap();
            rows.write_to(&mut streamed, Path::new("stream"), format, &Tone::default()).unwrap();
            assert!(streamed == saved(&whole), "{name}");
        }
        let learning = RenderOptions {
            film_memory: Some(0),
            integrator: Some("guided".to_owned()),
            ..RenderOptions::default()
        };
        let refused = LoadedScene::from_description("ball", scene.clone()).render().options(learning).run();
        assert!(refused.unwrap_err().to_string().contains("1 MB of memory, and 0 MB may be used"));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
