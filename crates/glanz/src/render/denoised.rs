//! Removal of noise from finished pictures.

use glanz_denoise::{DenoiseError, Denoiser, NoisyPicture};
use glanz_job::{ProgressSink, Silent};
use glanz_light::Pixels;
use glanz_transport::{Aov, AovSet};

use super::picture::Picture;
use crate::error::Error;
use crate::event::Warning;
use crate::job_options::JobOptions;
use crate::running_job::RunningJob;

/// The channels that [`denoise`] needs.
pub(super) const CHANNELS: AovSet = AovSet::NONE.with(Aov::Albedo).with(Aov::ShadingNormal);

/// The picture with colours without noise, under its lines; with noise and a warning if the job is cancelled.
///
/// # Errors
/// [`Error::Unsaved`] with the picture as it was.
pub(super) fn denoise(
    mut picture: Picture,
    denoiser: &Denoiser,
    job: &mut RunningJob<'_>,
) -> Result<Picture, Error> {
    match colors_without_noise(&picture, denoiser, job) {
        Ok(colors) => picture.denoised = Some(colors),
        Err(Error::Denoise(DenoiseError::Interrupted(_))) => {
            job.warn(Warning::NotDenoised);
            picture.warnings.append(&mut job.warnings);
        }
        Err(error) => {
            return Err(Error::Unsaved { picture: Box::new(picture), error: Box::new(error) });
        }
    }
    Ok(picture)
}

fn colors_without_noise(
    picture: &Picture,
    denoiser: &Denoiser,
    job: &mut RunningJob<'_>,
) -> Result<Vec<[f32; 3]>, Error> {
    job.options.cancel.check().map_err(DenoiseError::from)?;
    let film = picture.film();
    let noisy = noisy_picture(&film.to_pixels_without_edges()?, &film.hit_shares()?);
    let JobOptions { sink, cancel, threads, .. } = &mut job.options;
    let mut silent = Silent;
    let sink: &mut dyn ProgressSink = match sink {
        Some(sink) => &mut **sink,
        None => &mut silent,
    };
    let mut colors = denoiser.denoise(noisy, *threads, sink, cancel)?;
    if let Some(edges) = film.edges() {
        edges.draw_over(&mut colors);
    }
    Ok(colors)
}

/// The input of the denoiser. `pixels`: with the channels of [`CHANNELS`]; `hit_shares`: as [`Film::hit_shares`](glanz_transport::Film::hit_shares).
pub(crate) fn noisy_picture(pixels: &Pixels, hit_shares: &[f32]) -> NoisyPicture {
    // Channels are means over hits; features of the denoiser are means over all samples, as the colour is.
    let features = |names| -> Vec<[f32; 3]> {
        let means = planes(pixels, names).into_iter().zip(hit_shares);
        means.map(|(mean, share)| mean.map(|x| x * share)).collect()
    };
    NoisyPicture {
        size: [pixels.width(), pixels.height()],
        color: planes(pixels, ["R", "G", "B"]),
        albedo: features(["Albedo.R", "Albedo.G", "Albedo.B"]),
        normal: features(["Ns.X", "Ns.Y", "Ns.Z"]),
    }
}

/// Three channels of a picture, pixel by pixel.
fn planes(pixels: &Pixels, names: [&str; 3]) -> Vec<[f32; 3]> {
    let planes = names.map(|name| pixels.channel(name).unwrap_or_default());
    (0..pixels.len()).map(|i| planes.map(|plane| plane.get(i).copied().unwrap_or_default())).collect()
}
