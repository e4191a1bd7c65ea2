//! Candela distributions of whole optics as photometric files.

use std::path::Path;

use glanz_formats::photometry::write::{self, Header};
use glanz_formats::photometry::{AngularSystem, IntensityDistribution, Names, Symmetry};
use glanz_illumination::FarField;

use super::IlluminateOutcome;
use crate::error::{Error, FileFault};
use crate::file;

/// Supported formats of photometric output files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PhotometricFormat {
    Ies,
    Ldt,
}

fn format(path: &Path) -> Result<PhotometricFormat, Error> {
    let is = |name| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(name));
    if is("ies") {
        return Ok(PhotometricFormat::Ies);
    }
    if is("ldt") { Ok(PhotometricFormat::Ldt) } else { Err(FileFault::Extension("luminaires").of(path)) }
}

/// Refuses an extension that is not that of a supported photometric format.
///
/// # Errors
/// [`Error::File`] with [`FileFault::Extension`].
pub fn check_far_field_path(path: &Path) -> Result<(), Error> {
    format(path).map(|_| ())
}

impl IlluminateOutcome {
    /// Writes the candela distribution of all light that leaves the scene, as EULUMDAT (.ldt) or IES (.ies); -z is gamma 0.
    ///
    /// # Errors
    /// [`Error::NoFarField`] if directions were not counted, [`Error::File`].
    pub fn save_far_field(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        let far = self.far_field().ok_or(Error::NoFarField)?;
        file::write(path, &bytes(path, &self.report.title, far)?)
    }
}

fn bytes(path: &Path, title: &str, far: &FarField) -> Result<Vec<u8>, Error> {
    let format = format(path)?;
    let (mut planes, gammas) = (far.grid.planes(), far.grid.gammas());
    // The first plane is repeated to close the circle.
    planes.push(360.0);
    let rows = (0..planes.len()).flat_map(|plane| (0..gammas.len()).map(move |gamma| far.at(plane, gamma)));
    let candela = rows.collect();
    let distribution =
        IntensityDistribution::try_new(AngularSystem::C, Symmetry::None, &planes, gammas, candela)
            .map_err(Error::of_file(path))?;
    let program = format!("Glanz {}", glanz_job::current_version());
    let names = Names { luminaire: title.to_owned(), ..Names::default() };
    let header = Header { names, laboratory: program, ..Header::default() };
    let written = match format {
        PhotometricFormat::Ies => write::ies(&distribution, &header),
        PhotometricFormat::Ldt => write::ldt(&distribution, &header),
    };
    written.map_err(Error::of_file(path))
}
