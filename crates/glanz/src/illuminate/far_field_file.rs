//! Candela distributions of whole optics as photometric files.

use std::path::Path;

use glanz_formats::photometry::Names;
use glanz_formats::photometry::write::{self, Header};
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
    /// Between its angles, which are those of [`IlluminateOptions::far_field`](super::IlluminateOptions::far_field), intensities are to be
    /// interpolated linearly, as readers do: then they have the flux of the light that left the scene.
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
    let distribution = far.distribution().map_err(Error::of_file(path))?;
    let program = format!("Glanz {}", glanz_job::current_version());
    let names = Names { luminaire: title.to_owned(), ..Names::default() };
    let header = Header { names, laboratory: program, ..Header::default() };
    let written = match format {
        PhotometricFormat::Ies => write::ies(&distribution, &header),
        PhotometricFormat::Ldt => write::ldt(&distribution, &header),
    };
    written.map_err(Error::of_file(path))
}

#[cfg(test)]
mod tests {
    use glanz_formats::photometry;
    use glanz_illumination::{Receivers, Tally, TraceGoal, TraceSettings, adapted_grid, trace};
    use glanz_job::{CancelFlag, Silent};
    use glanz_math::DVec3;
    use glanz_scene::SceneBuilder;
    use glanz_scene::description::LightDescription;

    use super::*;

    #[test]
    fn files_read_back_have_flux_peak_and_beam_of_the_report() {
        // A cone of half angle 1 degree, tilted by 37 degrees in the plane C 90, and one straight down.
        let (sin, cos) = 37.0_f64.to_radians().sin_cos();
        for axis in [DVec3::new(0.0, sin, -cos), DVec3::NEG_Z] {
            let light = LightDescription::spot(DVec3::ZERO, axis, [1.0_f64.to_radians(); 2], 5.0);
            let (scene, _) = SceneBuilder::new().light(light).resolve().unwrap();
            let (receivers, goal) =
                (Receivers::default(), TraceGoal { particles: Some(200_000), ..TraceGoal::default() });
            let settings = TraceSettings { seed: 1, max_events: 9, threads: 1, goal, part: None };
            let tally =
                Tally::new(&receivers, adapted_grid(&scene, &settings, &CancelFlag::default()).unwrap());
            let outcome =
                trace(&scene, &receivers, &settings, tally, &mut Silent, &CancelFlag::default()).unwrap();
            let (far, escaped) = (outcome.tally.far_field().unwrap(), outcome.tally.balance().escaped);
            let summary = far.summary().unwrap();
            for name in ["lamp.ies", "lamp.ldt"] {
                let file = photometry::read(&bytes(Path::new(name), "lamp", &far).unwrap()).unwrap();
                assert_eq!(file.warnings, []);
                let found = file.photometry.distribution;
                assert!(
                    (found.flux() / escaped - 1.0).abs() < 1e-6,
                    "{name}: {} lm, not {escaped}",
                    found.flux()
                );
                // Intensities have eight digits.
                assert!((found.peak() / summary.peak - 1.0).abs() < 1e-7, "{name}");
                let beam = found.beam().unwrap();
                let angles = beam.beam_angles.into_iter().chain(beam.field_angles);
                let expected = summary.beam_angles.into_iter().chain(summary.field_angles);
                assert!(angles.zip(expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-4), "{name}: {beam:?}");
                let axis_of_beam = found.direction(beam.middle[0], beam.middle[1]);
                assert!(axis_of_beam.angle_between(axis).to_degrees() < 0.02, "{name}: {beam:?}");
            }
        }
    }
}
