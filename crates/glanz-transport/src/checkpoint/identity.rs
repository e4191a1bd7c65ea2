//! The identity of a picture in bytes.

use glanz_sampling::SamplerKind;
use glanz_scene::description::{FilterDescription, FilterKind};

use super::CheckpointError;
use crate::aov::AovSet;
use crate::codec::{Decoder, Encoder};
use crate::film::FilmFormat;
use crate::identity::PictureIdentity;
use crate::integrator::IntegratorSettings;
use crate::noise::NoiseLevel;
use crate::pixel_rect::PixelRect;

pub(super) fn encode_identity(e: &mut Encoder, identity: &PictureIdentity) {
    e.text(&identity.version);
    e.u128(identity.scene);
    let film = &identity.film;
    for value in film.resolution.into_iter().chain(film.crop.min).chain(film.crop.size) {
        e.u32(value);
    }
    e.u8(film.aovs.to_bits());
    e.u8(u8::from(film.signed));
    e.u8(u8::from(film.passes));
    e.u8(u8::from(film.splats));
    e.u32(film.noise.map_or(0, NoiseLevel::millionths));
    encode_filter(e, &identity.filter);
    e.text(&identity.integrator.full_name());
    e.u32(identity.integrator.max_depth);
    e.u8(u8::from(identity.integrator.light_sampling) | u8::from(identity.integrator.spectral) << 1);
    e.u32(identity.integrator.branching);
    e.text(identity.sampler.name());
    e.u64(identity.seed);
    e.u32(identity.samples_per_pixel);
    // A hash of 0 stands for none; one in 2^128 guides has this hash.
    e.u128(identity.guide.unwrap_or_default());
}

pub(super) fn decode_identity(d: &mut Decoder<'_>) -> Result<PictureIdentity, CheckpointError> {
    let cut = || CheckpointError::Content("its header");
    let version = d.text().ok_or_else(cut)?.to_owned();
    let scene = d.u128().ok_or_else(cut)?;
    let film = decode_format(d).ok_or_else(cut)?;
    let filter = decode_filter(d).ok_or(CheckpointError::Content("its filter"))?;
    let name = d.text().ok_or_else(cut)?;
    let max_depth = d.u32().ok_or_else(cut)?;
    let flags = d.u8().filter(|flags| flags & !3 == 0).ok_or_else(cut)?;
    let branching = d.u32().ok_or_else(cut)?;
    let integrator =
        IntegratorSettings::by_name(name, max_depth, [1, 2].map(|bit| flags & bit != 0), branching)
            .ok_or(CheckpointError::Content("an integrator this program does not have"))?;
    let sampler = d.text().and_then(SamplerKind::from_name);
    let sampler = sampler.ok_or(CheckpointError::Content("a sampler this program does not have"))?;
    let seed = d.u64().ok_or_else(cut)?;
    let samples_per_pixel = d.u32().ok_or_else(cut)?;
    let guide = Some(d.u128().ok_or_else(cut)?).filter(|&hash| hash != 0);
    Ok(PictureIdentity { scene, film, filter, integrator, sampler, seed, samples_per_pixel, guide, version })
}

fn decode_format(d: &mut Decoder<'_>) -> Option<FilmFormat> {
    Some(FilmFormat {
        resolution: [d.u32()?, d.u32()?],
        crop: PixelRect { min: [d.u32()?, d.u32()?], size: [d.u32()?, d.u32()?] },
        aovs: AovSet::from_bits(d.u8()?),
        signed: d.u8()? != 0,
        passes: d.u8()? != 0,
        splats: d.u8()? != 0,
        noise: match d.u32()? {
            0 => None,
            millionths => Some(NoiseLevel::try_new(f64::from(millionths) / 1e6)?),
        },
    })
}

fn encode_filter(e: &mut Encoder, filter: &FilterDescription) {
    let (tag, parameters) = match filter.kind {
        FilterKind::Box => (0, [0.0; 2]),
        FilterKind::Triangle => (1, [0.0; 2]),
        FilterKind::Gaussian { sigma } => (2, [sigma, 0.0]),
        FilterKind::Mitchell { b, c } => (3, [b, c]),
        FilterKind::Cylinder => (4, [0.0; 2]),
        FilterKind::Pyramid => (5, [0.0; 2]),
        FilterKind::Cone => (6, [0.0; 2]),
        FilterKind::Sinc { tau } => (7, [tau, 0.0]),
    };
    e.u8(tag);
    parameters.into_iter().chain(filter.radius).for_each(|v| e.f64(v));
}

fn decode_filter(d: &mut Decoder<'_>) -> Option<FilterDescription> {
    let tag = d.u8()?;
    let (p, q) = (d.f64()?, d.f64()?);
    let kind = match tag {
        0 => FilterKind::Box,
        1 => FilterKind::Triangle,
        2 => FilterKind::Gaussian { sigma: p },
        3 => FilterKind::Mitchell { b: p, c: q },
        4 => FilterKind::Cylinder,
        5 => FilterKind::Pyramid,
        6 => FilterKind::Cone,
        7 => FilterKind::Sinc { tau: p },
        _ => return None,
    };
    Some(FilterDescription { kind, radius: [d.f64()?, d.f64()?] })
}
