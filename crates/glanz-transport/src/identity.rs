//! What a picture depends on.

use glanz_sampling::SamplerKind;
use glanz_scene::description::FilterDescription;

use crate::film::FilmFormat;
use crate::integrator::IntegratorSettings;

/// Everything the bits of a picture depend on, except which samples were taken.
///
/// Two films may be joined if their identities agree.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureIdentity {
    /// Hash over the content of the scene: its file and all that it refers to.
    pub scene: u128,
    /// Size, crop and channels.
    pub film: FilmFormat,
    /// The pixel filter.
    pub filter: FilterDescription,
    /// The integrator with its settings.
    pub integrator: IntegratorSettings,
    /// How samples are spread.
    pub sampler: SamplerKind,
    /// Seed of the samples.
    pub seed: u64,
    /// Planned samples per pixel. Of meaning for samplers that divide the pixel into as many strata only.
    pub samples_per_pixel: u32,
    /// Hash over the file of a guide that does not change, or of the light that is shown; `None` without one, or if the picture learns or
    /// makes its own.
    pub guide: Option<u128>,
    /// Version of the program that took the samples.
    pub version: String,
}

/// The first thing in which two pictures differ.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("it is of another picture: {what} is {found}, not {wanted}")]
pub struct Mismatch {
    /// What differs.
    pub what: &'static str,
    /// As it is in the picture looked at.
    pub found: String,
    /// As it is in the picture wanted.
    pub wanted: String,
}

impl PictureIdentity {
    /// The version of this program.
    #[must_use]
    pub fn current_version() -> String {
        env!("CARGO_PKG_VERSION").to_owned()
    }

    /// Whether the sampler's strata depend on the planned number of samples.
    #[must_use]
    pub fn plan_matters(&self) -> bool {
        matches!(self.sampler, SamplerKind::Stratified | SamplerKind::Regular)
    }

    /// Whether this is the picture `wanted`.
    ///
    /// # Errors
    /// [`Mismatch`] with the first difference.
    pub fn check(&self, wanted: &Self) -> Result<(), Mismatch> {
        let text = |i: &Self| {
            let ([width, height], [x, y], [w, h]) = (i.film.resolution, i.film.crop.min, i.film.crop.size);
            // Numbers are compared by the text shown, which for `f64` tells every bit but the sign of NaN.
            [
                ("the Glanz version", i.version.clone()),
                ("the scene (content hash)", format!("{:032x}", i.scene)),
                ("the picture size", format!("{width} x {height}")),
                ("the crop window", format!("{w} x {h} pixels at ({x}, {y})")),
                ("the list of extra channels", i.film.aovs.to_string()),
                ("the filter", format!("{:?}", i.filter)),
                ("the integrator", i.integrator.to_string()),
                ("the sampler", i.sampler.name().to_owned()),
                ("the seed", i.seed.to_string()),
                ("the number of samples planned per pixel", i.plan()),
                i.given(),
            ]
        };
        for ((what, found), (_, wanted)) in text(self).into_iter().zip(text(wanted)) {
            if found != wanted {
                return Err(Mismatch { what, found, wanted });
            }
        }
        Ok(())
    }

    /// What was given in a file, or made or learnt by the way.
    fn given(&self) -> (&'static str, String) {
        let (what, otherwise) = match self.integrator.shows_stored_light() {
            true => ("the file of light", "made anew"),
            false => ("the guide", "learnt"),
        };
        (what, self.guide.map_or_else(|| otherwise.to_owned(), |hash| format!("{hash:032x}")))
    }

    /// The planned number of samples, where it matters.
    fn plan(&self) -> String {
        if self.plan_matters() { self.samples_per_pixel.to_string() } else { String::new() }
    }
}
