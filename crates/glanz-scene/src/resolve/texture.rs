//! Resolves textures and their pictures.

use std::sync::Arc;

use glanz_job::ResourceBudget;
use glanz_light::{SpectralDistribution, Spectrum, Wavelengths};
use glanz_shading::Textures;
use glanz_shading::parameter::ParameterResolver;
use glanz_shading::texture::{
    Bilerp, Checkerboard, DirectionMix, Dots, FloatInput, Fractal, ImageTexture, Marble, MipMap,
    SpectralConstant, SpectrumInput, Texture, TextureId, TextureMapping,
};

use super::{spend, transform};
use crate::alpha::AlphaTest;
use crate::description::{
    AlphaDescription, Description, DescriptionForm, FloatParameter, Location, MappingDescription,
    SpectrumParameter, TextureDescription, TextureKind,
};
use crate::error::{SceneError, SceneErrorKind};
use crate::light::picture_of;

/// The textures of a scene, and their ids by the index in the description.
pub(super) struct ResolvedTextures {
    pub(super) textures: Arc<Textures>,
    ids: Vec<TextureId>,
}

/// Resolves parameters of the description to inputs of shading.
pub(super) struct InputResolver<'a> {
    ids: &'a [TextureId],
    wavelengths: &'a Wavelengths,
    location: Option<Location>,
}

impl InputResolver<'_> {
    fn id(&self, index: usize) -> Result<TextureId, SceneError> {
        self.ids.get(index).copied().ok_or(SceneError {
            location: self.location,
            kind: SceneErrorKind::Reference { what: "texture", index, count: self.ids.len() },
        })
    }

    /// The opacity of a shape; `None` if it is opaque.
    pub(super) fn alpha(
        &self,
        alpha: &AlphaDescription,
        textures: &Arc<Textures>,
    ) -> Result<Option<AlphaTest>, SceneError> {
        let test = AlphaTest {
            textures: Arc::clone(textures),
            opacity: self.number(&alpha.opacity)?,
            shadow: self.number(&alpha.shadow)?,
        };
        Ok((!test.is_opaque()).then_some(test))
    }

    /// A spectrum without upper bound.
    fn unbounded(&self, input: &SpectrumParameter) -> Result<SpectrumInput, SceneError> {
        Ok(match input {
            SpectrumParameter::Value(value) => constant(value, value.unbounded(self.wavelengths)),
            SpectrumParameter::Texture(index) => SpectrumInput::Texture(self.id(*index)?),
        })
    }

    pub(super) fn number(&self, input: &FloatParameter) -> Result<FloatInput, SceneError> {
        Ok(match input {
            FloatParameter::Value(value) => FloatInput::Constant(*value),
            FloatParameter::Texture(index) => FloatInput::Texture(self.id(*index)?),
        })
    }
}

/// The same spectrum everywhere, of which `rgb` are the values in RGB.
fn constant(value: &SpectralDistribution, rgb: Spectrum) -> SpectrumInput {
    // The same value everywhere is grey.
    let is_flat = matches!(value, SpectralDistribution::Sampled(samples) if samples.is_flat());
    if value.is_spectral() && !is_flat {
        SpectrumInput::Spectral(Arc::new(SpectralConstant { rgb, distribution: value.clone() }))
    } else {
        SpectrumInput::Constant(rgb)
    }
}

impl ParameterResolver<DescriptionForm> for InputResolver<'_> {
    fn fraction_input(&self, input: &SpectrumParameter) -> Option<SpectrumInput> {
        match input {
            SpectrumParameter::Value(value) => Some(constant(value, value.reflectance(self.wavelengths))),
            SpectrumParameter::Texture(_) => self.spectrum_input(input),
        }
    }

    fn spectrum_input(&self, input: &SpectrumParameter) -> Option<SpectrumInput> {
        self.unbounded(input).ok()
    }

    fn float_input(&self, input: &FloatParameter) -> Option<FloatInput> {
        self.number(input).ok()
    }
}

impl ResolvedTextures {
    pub(super) fn inputs<'a>(
        &'a self,
        wavelengths: &'a Wavelengths,
        location: Option<Location>,
    ) -> InputResolver<'a> {
        InputResolver { ids: &self.ids, wavelengths, location }
    }
}

pub(super) fn textures(
    description: &Description,
    wavelengths: &Wavelengths,
    budget: &ResourceBudget,
) -> Result<ResolvedTextures, SceneError> {
    let (mut textures, mut ids) = (Textures::new(), Vec::new());
    for texture in &description.textures {
        spend(budget, 0, size_of::<Texture>() as u64, texture.location)?;
        let built = self::texture(
            description,
            texture,
            &InputResolver { ids: &ids, wavelengths, location: texture.location },
        )?;
        ids.push(textures.add(built).map_err(|reason| texture_error(texture, reason))?);
    }
    Ok(ResolvedTextures { textures: textures.into(), ids })
}

fn texture_error(texture: &TextureDescription, reason: impl ToString) -> SceneError {
    let kind = SceneErrorKind::Texture { name: texture.name.clone(), reason: reason.to_string() };
    SceneError { location: texture.location, kind }
}

fn texture(
    description: &Description,
    texture: &TextureDescription,
    inputs: &InputResolver<'_>,
) -> Result<Texture, SceneError> {
    Ok(match &texture.kind {
        TextureKind::Constant(value) => match inputs.unbounded(value)? {
            SpectrumInput::Constant(value) => Texture::Constant(value),
            other => Texture::Scale(other, SpectrumInput::Constant(Spectrum::ONE)),
        },
        TextureKind::Scale(a, b) => Texture::Scale(inputs.unbounded(a)?, inputs.unbounded(b)?),
        TextureKind::Mix { a, b, amount } => {
            Texture::Mix { a: inputs.unbounded(a)?, b: inputs.unbounded(b)?, amount: inputs.number(amount)? }
        }
        TextureKind::Checkerboard { even, odd, mapping } => Texture::Checkerboard(Checkerboard {
            even: inputs.unbounded(even)?,
            odd: inputs.unbounded(odd)?,
            mapping: self::mapping(mapping, texture.location)?,
        }),
        TextureKind::Image { image, mapping, wrap, filter, scale, invert } => {
            let image = self::image(description, texture, *image)?;
            Texture::Image(ImageTexture {
                image,
                mapping: self::mapping(mapping, texture.location)?,
                wrap: *wrap,
                filter: *filter,
                scale: *scale,
                invert: *invert,
            })
        }
        TextureKind::Uv(mapping) => Texture::Uv(self::mapping(mapping, texture.location)?),
        TextureKind::Bilerp { corners: [a, b, c, d], mapping } => Texture::Bilerp(Bilerp {
            corners: [inputs.unbounded(a)?, inputs.unbounded(b)?, inputs.unbounded(c)?, inputs.unbounded(d)?],
            mapping: self::mapping(mapping, texture.location)?,
        }),
        TextureKind::Dots { inside, outside, mapping } => Texture::Dots(Dots {
            inside: inputs.unbounded(inside)?,
            outside: inputs.unbounded(outside)?,
            mapping: self::mapping(mapping, texture.location)?,
        }),
        TextureKind::Fractal { kind, mapping } => {
            Texture::Fractal(Fractal { kind: *kind, mapping: self::mapping(mapping, texture.location)? })
        }
        &TextureKind::Marble { octaves, roughness, scale, variation, ref mapping } => {
            let mapping = self::mapping(mapping, texture.location)?;
            Texture::Marble(Marble { octaves, roughness, scale, variation, mapping })
        }
        TextureKind::DirectionMix { along, across, direction } => Texture::DirectionMix(DirectionMix {
            along: inputs.unbounded(along)?,
            across: inputs.unbounded(across)?,
            direction: direction
                .try_normalize()
                .ok_or_else(|| texture_error(texture, "the direction has no length; give it one"))?,
        }),
    })
}

/// The picture with this index, whose values must be finite.
fn image(
    description: &Description,
    texture: &TextureDescription,
    index: usize,
) -> Result<MipMap, SceneError> {
    let located = |kind| SceneError { location: texture.location, kind };
    let picture = picture_of(&description.images, index).map_err(located)?;
    picture.check_finite().map_err(|reason| texture_error(texture, reason))?;
    Ok(picture.clone())
}

fn mapping(mapping: &MappingDescription, location: Option<Location>) -> Result<TextureMapping, SceneError> {
    mapping.try_map(|to_texture| transform(*to_texture, "texture", location))
}
