//! Identity of a picture: everything it depends on.

use glanz_job::JobIdentity;
use glanz_sampling::SamplerKind;
use glanz_scene::description::FilterDescription;

use crate::film::FilmFormat;
use crate::integrator::IntegratorSettings;

/// Everything on which the bits of a picture depend, except the set of samples.
///
/// Two films may be merged if their identities agree.
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
    /// The sampler.
    pub sampler: SamplerKind,
    /// Seed of the samples.
    pub seed: u64,
    /// Planned samples per pixel. Relevant only for samplers that divide the pixel into this number of strata.
    pub samples_per_pixel: u32,
    /// Hash over the file of a fixed guide or of stored light; `None` without one, or if the picture has its own guide or
    /// light.
    pub guide: Option<u128>,
    /// Version of the program that rendered the samples.
    pub version: String,
}

impl PictureIdentity {
    /// Whether the sampler's strata depend on the planned number of samples.
    #[must_use]
    pub fn plan_matters(&self) -> bool {
        matches!(self.sampler, SamplerKind::Stratified | SamplerKind::Regular)
    }

    /// Hash of a guide or of light from a file.
    fn given(&self) -> (&'static str, String) {
        let (what, otherwise) = match self.integrator.shows_stored_light() {
            true => ("the file of light", "made anew"),
            false => ("the guide", "learnt"),
        };
        (what, self.guide.map_or_else(|| otherwise.to_owned(), |hash| format!("{hash:032x}")))
    }

    /// The planned number of samples, if it is relevant.
    fn plan(&self) -> String {
        if self.plan_matters() { self.samples_per_pixel.to_string() } else { String::new() }
    }
}

impl JobIdentity for PictureIdentity {
    const FOREIGN: &'static str = "it is of another picture";

    fn fields(&self) -> Vec<(&'static str, String)> {
        let ([width, height], [x, y], [w, h]) =
            (self.film.resolution, self.film.crop.min, self.film.crop.size);
        // The text of an `f64` represents every bit but the sign of NaN.
        vec![
            ("the Glanz version", self.version.clone()),
            ("the scene (content hash)", format!("{:032x}", self.scene)),
            ("the picture size", format!("{width} x {height}")),
            ("the crop window", format!("{w} x {h} pixels at ({x}, {y})")),
            (
                "the noise level",
                self.film.noise.map_or_else(|| "none".to_owned(), |noise| noise.error().to_string()),
            ),
            ("the list of extra channels", self.film.aovs.to_string()),
            ("the filter", format!("{:?}", self.filter)),
            ("the integrator", self.integrator.to_string()),
            ("the sampler", self.sampler.name().to_owned()),
            ("the seed", self.seed.to_string()),
            ("the number of samples planned per pixel", self.plan()),
            self.given(),
        ]
    }
}
