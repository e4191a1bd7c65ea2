//! Picture files.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use glanz_formats::image::{self, Format, ImageError, RowPicture};
use glanz_light::Tone;
use glanz_transport::channel_names;

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
        if self.is_in_file() && !file::is_pipe(path) {
            return self.save_rows(path, format, tone);
        }
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

    /// Writes the file with some rows in memory at a time.
    fn save_rows(&self, path: &Path, format: Format, tone: &Tone) -> Result<(), Error> {
        let film = self.film();
        let picture = RowPicture {
            size: film.format().crop.size,
            channels: &channel_names(film.format().aovs),
            tone,
            attributes: &attributes(self),
        };
        let mut refused = None;
        let written = file::write_file_with(path, |out| {
            let rows = |rows| film.rows_to_pixels(rows).map_err(io::Error::other);
            image::write_rows(&picture, format, out, rows).or_else(|error| match error {
                ImageError::Write(error) => Err(error),
                other => Err(io::Error::other(refused.insert(other).to_string())),
            })
        });
        refused.map_or(written, |error| Err(Error::of_file(path)(error)))
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
    use glanz_scene::SceneBuilder;
    use glanz_scene::description::{LightDescription, MaterialKind, ShapeDescription};
    use glanz_transport::AovSet;

    use super::*;
    use crate::{LoadedScene, RenderOptions};

    #[test]
    fn files_of_films_in_files_are_those_of_films_in_memory() {
        let folder = std::env::temp_dir().join(format!("glanz-rows-{}", std::process::id()));
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
