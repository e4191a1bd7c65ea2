//! Numbers and spectra that vary over surfaces.
//!
//! [`Textures`] owns all of them. A texture may refer to those added before it, never to itself or to later ones: there
//! are no cycles, and the cost of an evaluation is bounded when it is added.

pub mod bilerp;
pub mod checkerboard;
pub mod direction_mix;
pub mod dots;
pub mod footprint;
pub mod fractal;
pub mod image;
pub mod mapping;
pub mod marble;
mod mip_level;
pub mod mip_map;
pub mod noise;
pub mod spectral_constant;
mod texels;
mod texture_cache;

use std::sync::Arc;

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::{DVec2, DVec3};

pub use bilerp::Bilerp;
pub use checkerboard::Checkerboard;
pub use direction_mix::DirectionMix;
pub use dots::Dots;
pub use footprint::TextureFootprint;
pub use fractal::{Fractal, FractalKind};
pub use image::ImageTexture;
pub use mapping::{TextureCoordinates, TextureMapping};
pub use marble::Marble;
pub use mip_map::{ImageFilter, ImageWrap, MipMap, MipMapError};
pub use spectral_constant::SpectralConstant;
pub use texture_cache::TextureCache;

/// A point at which a texture is evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexturePoint {
    /// Texture coordinates of the surface.
    pub uv: DVec2,
    /// The point in the world, metres.
    pub position: DVec3,
    /// Unit normal of the surface in the world, of either sign; zero if it is not known.
    pub normal: DVec3,
    /// The footprint over which pictures are averaged; `None` for the point alone.
    pub footprint: Option<TextureFootprint>,
}

impl TexturePoint {
    /// A point without extent and normal.
    #[must_use]
    pub const fn new(uv: DVec2, position: DVec3) -> Self {
        Self { uv, position, normal: DVec3::ZERO, footprint: None }
    }

    /// The same point of a surface with this unit normal.
    #[must_use]
    pub const fn with_normal(self, normal: DVec3) -> Self {
        Self { normal, ..self }
    }

    /// The same point with a footprint.
    #[must_use]
    pub const fn with_footprint(self, footprint: Option<TextureFootprint>) -> Self {
        Self { footprint, ..self }
    }
}

/// A texture in [`Textures`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TextureId(u32);

/// A spectrum, the same everywhere or textured.
#[derive(Clone, Debug, PartialEq)]
pub enum SpectrumInput {
    /// The same everywhere, in linear Rec. 709.
    Constant(Spectrum),
    /// The same everywhere, by wavelength.
    Spectral(Arc<SpectralConstant>),
    /// The spectrum of a texture.
    Texture(TextureId),
}

impl From<Spectrum> for SpectrumInput {
    fn from(value: Spectrum) -> Self {
        Self::Constant(value)
    }
}

impl From<f32> for SpectrumInput {
    /// Grey.
    fn from(value: f32) -> Self {
        Self::Constant(Spectrum::from_rgb([value; 3]))
    }
}

/// A number, the same everywhere or textured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FloatInput {
    /// The same everywhere.
    Constant(f32),
    /// The mean over red, green and blue of a texture.
    Texture(TextureId),
}

impl From<f32> for FloatInput {
    fn from(value: f32) -> Self {
        Self::Constant(value)
    }
}

/// The closed set of textures. A texture of numbers holds them as grey spectra.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Texture {
    /// The same everywhere.
    Constant(Spectrum),
    /// Product of two inputs.
    Scale(SpectrumInput, SpectrumInput),
    /// `(1 - amount) a + amount b`; the amount is not clamped.
    Mix {
        /// Value for `amount` 0.
        a: SpectrumInput,
        /// Value for `amount` 1.
        b: SpectrumInput,
        /// Weight of `b`.
        amount: FloatInput,
    },
    /// Two inputs alternating in squares or cubes.
    Checkerboard(Checkerboard),
    /// A picture.
    Image(ImageTexture),
    /// The fractions of the coordinates as red and green.
    Uv(TextureMapping),
    /// Four inputs interpolated between the corners of a square.
    Bilerp(Bilerp),
    /// Two inputs, one in random dots.
    Dots(Dots),
    /// A sum of noise.
    Fractal(Fractal),
    /// Marble.
    Marble(Marble),
    /// Two inputs mixed by the direction of the surface.
    DirectionMix(DirectionMix),
}

impl Texture {
    fn inputs(&self) -> [Option<TextureId>; 4] {
        let of = |input: &SpectrumInput| match input {
            SpectrumInput::Texture(id) => Some(*id),
            SpectrumInput::Constant(_) | SpectrumInput::Spectral(_) => None,
        };
        match self {
            Self::Constant(_) | Self::Image(_) | Self::Uv(_) | Self::Fractal(_) | Self::Marble(_) => {
                [None; 4]
            }
            Self::Scale(a, b) => [of(a), of(b), None, None],
            Self::Checkerboard(board) => [of(&board.even), of(&board.odd), None, None],
            Self::Dots(dots) => [of(&dots.inside), of(&dots.outside), None, None],
            Self::DirectionMix(mix) => [of(&mix.along), of(&mix.across), None, None],
            Self::Bilerp(bilerp) => bilerp.corners.each_ref().map(of),
            Self::Mix { a, b, amount } => {
                let amount = match amount {
                    FloatInput::Texture(id) => Some(*id),
                    FloatInput::Constant(_) => None,
                };
                [of(a), of(b), amount, None]
            }
        }
    }
}

/// An error of [`Textures::add`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TextureError {
    /// A reference to a texture that was not added before.
    #[error("the texture refers to texture {0}, which is not among the {1} added before it; add that first")]
    Unknown(u32, usize),
    /// An evaluation that would take too many others.
    #[error("one evaluation of the texture would take {0} evaluations; at most {max} are allowed", max = Textures::MAX_EVALUATIONS)]
    Cost(u64),
    /// More than 2^32 textures.
    #[error("the scene has more than 2^32 textures; remove some")]
    Full,
}

/// All textures of a scene.
#[derive(Clone, Debug, Default)]
pub struct Textures {
    textures: Vec<Texture>,
    /// Number of evaluations per evaluation, including itself.
    costs: Vec<u64>,
}

impl Textures {
    /// Largest number of textures that one evaluation may evaluate; also bounds the depth of the recursion.
    pub const MAX_EVALUATIONS: u64 = 1000;

    /// An empty list.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a texture that may refer to those added before.
    ///
    /// # Errors
    /// [`TextureError::Unknown`] if it refers to a texture that was not added before, [`TextureError::Cost`] if an evaluation would take more
    /// than [`Textures::MAX_EVALUATIONS`], [`TextureError::Full`] after 2^32 textures.
    pub fn add(&mut self, texture: Texture) -> Result<TextureId, TextureError> {
        let mut cost = 1;
        for id in texture.inputs().into_iter().flatten() {
            cost += self.costs.get(id.0 as usize).ok_or(TextureError::Unknown(id.0, self.costs.len()))?;
        }
        if cost > Self::MAX_EVALUATIONS {
            return Err(TextureError::Cost(cost));
        }
        let id = u32::try_from(self.textures.len()).map_err(|_| TextureError::Full)?;
        self.textures.push(texture);
        self.costs.push(cost);
        Ok(TextureId(id))
    }

    /// Number of textures.
    #[must_use]
    pub fn len(&self) -> usize {
        self.textures.len()
    }

    /// Whether there are no textures.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.textures.is_empty()
    }

    /// The texture `id`; `None` if it belongs to other [`Textures`].
    #[must_use]
    pub fn get(&self, id: TextureId) -> Option<&Texture> {
        self.textures.get(id.0 as usize)
    }

    /// Whether a texture averages over footprints.
    #[must_use]
    pub fn use_footprints(&self) -> bool {
        self.textures
            .iter()
            .any(|texture| matches!(texture, Texture::Image(image) if image.uses_footprints()))
    }

    /// The value of `input` at a point; black for a texture of other [`Textures`].
    #[must_use]
    pub fn spectrum(&self, input: &SpectrumInput, at: &TexturePoint, wavelengths: &Wavelengths) -> Spectrum {
        match input {
            SpectrumInput::Constant(value) => value.upsampled(wavelengths),
            SpectrumInput::Spectral(constant) => constant.at(wavelengths),
            SpectrumInput::Texture(id) => self.evaluate(*id, at, wavelengths),
        }
    }

    /// The value of `input` at a point, the same at all wavelengths; 0 for a texture of other [`Textures`].
    #[must_use]
    pub fn float(&self, input: &FloatInput, at: &TexturePoint) -> f32 {
        match input {
            FloatInput::Constant(value) => *value,
            FloatInput::Texture(id) => self.evaluate(*id, at, &Wavelengths::Rgb).mean(&Wavelengths::Rgb),
        }
    }

    /// Recursion ends: ids only point backwards, and the depth is at most [`Textures::MAX_EVALUATIONS`].
    fn evaluate(&self, id: TextureId, at: &TexturePoint, wavelengths: &Wavelengths) -> Spectrum {
        let Some(texture) = self.get(id) else {
            return Spectrum::BLACK;
        };
        let spectrum = |input: &SpectrumInput| self.spectrum(input, at, wavelengths);
        match texture {
            Texture::Constant(value) => value.upsampled(wavelengths),
            Texture::Scale(a, b) => spectrum(a) * spectrum(b),
            Texture::Mix { a, b, amount } => spectrum(a).lerp(spectrum(b), self.float(amount, at)),
            Texture::Checkerboard(board) if board.is_odd(at) => spectrum(&board.odd),
            Texture::Checkerboard(board) => spectrum(&board.even),
            Texture::Image(image) => image.evaluate(at).upsampled(wavelengths),
            Texture::Uv(mapping) => {
                let st = mapping.coordinates(at).position;
                let rgb = [(st.x - st.x.floor()) as f32, (st.y - st.y.floor()) as f32, 0.0];
                Spectrum::from_rgb(rgb).upsampled(wavelengths)
            }
            Texture::Bilerp(bilerp) => {
                let weights = bilerp.weights(at);
                bilerp.corners.iter().zip(weights).map(|(corner, weight)| spectrum(corner) * weight).sum()
            }
            Texture::Dots(dots) if dots.is_inside(at) => spectrum(&dots.inside),
            Texture::Dots(dots) => spectrum(&dots.outside),
            Texture::Fractal(fractal) => Spectrum::one(wavelengths) * fractal.evaluate(at),
            Texture::Marble(marble) => marble.evaluate(at).upsampled(wavelengths),
            Texture::DirectionMix(mix) => {
                spectrum(&mix.across).lerp(spectrum(&mix.along), mix.along_fraction(at))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RGB: Wavelengths = Wavelengths::Rgb;

    fn point() -> TexturePoint {
        TexturePoint::new(DVec2::new(0.25, 0.75), DVec3::ZERO)
    }

    fn rgb(textures: &Textures, id: TextureId) -> [f32; 3] {
        textures.spectrum(&SpectrumInput::Texture(id), &point(), &RGB).to_rgb(&RGB)
    }

    #[test]
    fn scale_and_mix_are_products_and_weighted_sums() {
        let mut textures = Textures::new();
        let a = textures.add(Texture::Constant(Spectrum::from_rgb([0.5, 1.0, 0.0]))).unwrap();
        let half = SpectrumInput::Constant(Spectrum::from_rgb([0.5, 0.25, 1.0]));
        let scaled = textures.add(Texture::Scale(SpectrumInput::Texture(a), half.clone())).unwrap();
        assert_eq!(rgb(&textures, scaled), [0.25, 0.25, 0.0]);
        let amount = textures.add(Texture::Constant(Spectrum::from_rgb([0.25; 3]))).unwrap();
        let mix = Texture::Mix { a: SpectrumInput::Texture(a), b: half, amount: FloatInput::Texture(amount) };
        let mixed = textures.add(mix).unwrap();
        assert_eq!(rgb(&textures, mixed), [0.5, 0.8125, 0.25]);
        assert_eq!(textures.float(&FloatInput::Texture(amount), &point()), 0.25);
    }

    #[test]
    fn direction_mix_weighs_by_the_cosine_to_either_side() {
        let mut textures = Textures::new();
        let mix =
            DirectionMix { along: Spectrum::ONE.into(), across: Spectrum::BLACK.into(), direction: DVec3::Y };
        let input = FloatInput::Texture(textures.add(Texture::DirectionMix(mix)).unwrap());
        for degrees in [0.0, 30.0, 90.0, 120.0, 180.0_f64] {
            let angle = degrees.to_radians();
            let at = point().with_normal(DVec3::new(angle.sin(), angle.cos(), 0.0));
            let expected = angle.cos().abs() as f32;
            assert!((textures.float(&input, &at) - expected).abs() < 1e-7, "{degrees}");
        }
    }

    #[test]
    fn bilerp_is_exact_at_corners_and_has_their_mean() {
        let mut textures = Textures::new();
        let corners = [1.0, 2.0, 4.0, 9.0].map(|x| Spectrum::from_rgb([x; 3]).into());
        let bilerp = Texture::Bilerp(Bilerp { corners, mapping: TextureMapping::default() });
        let input = FloatInput::Texture(textures.add(bilerp).unwrap());
        let at = |u: f64, v: f64| textures.float(&input, &TexturePoint::new(DVec2::new(u, v), DVec3::ZERO));
        assert_eq!([at(0.0, 0.0), at(0.0, 1.0), at(1.0, 0.0), at(1.0, 1.0)], [1.0, 2.0, 4.0, 9.0]);
        // 1 / 4 * (3 / 4 * 1 + 1 / 4 * 2) and so on: s = 3 / 4, t = 1 / 4.
        assert_eq!(at(0.75, 0.25), 0.25 * (0.75 + 0.25 * 2.0) + 0.75 * (0.75 * 4.0 + 0.25 * 9.0));
        let middle = |i: u32| (f64::from(i) + 0.5) / 8.0;
        let mean = (0..64).map(|i| at(middle(i % 8), middle(i / 8))).sum::<f32>() / 64.0;
        assert!((mean - 4.0).abs() < 1e-5, "{mean}");
    }

    #[test]
    fn colors_become_spectra_and_numbers_stay() {
        let wavelengths = Wavelengths::Sampled(glanz_light::SampledWavelengths::sample(0.4));
        let mut textures = Textures::new();
        let uv = textures.add(Texture::Uv(TextureMapping::default())).unwrap();
        let color = Spectrum::from_rgb([0.25, 0.75, 0.0]).upsampled(&wavelengths);
        assert_eq!(textures.spectrum(&SpectrumInput::Texture(uv), &point(), &wavelengths), color);
        assert!((color - Spectrum::from_rgb([0.25, 0.75, 0.0])).max_component() > 0.1);
        let at = point();
        let evaluator = crate::parameter::TextureEvaluator::new(&textures, &at, &wavelengths);
        assert_eq!(evaluator.float(&FloatInput::Texture(uv)), 1.0 / 3.0);
        assert_eq!(evaluator.spectrum(&SpectrumInput::from(0.3)), Spectrum::splat(0.3));
    }

    #[test]
    fn uv_shows_the_fractions_of_the_coordinates() {
        let mut textures = Textures::new();
        let mapping = TextureMapping::Uv { scale: DVec2::splat(5.0), offset: DVec2::ZERO };
        let uv = textures.add(Texture::Uv(mapping)).unwrap();
        assert_eq!(rgb(&textures, uv), [0.25, 0.75, 0.0]);
    }

    #[test]
    fn references_to_unknown_textures_are_refused() {
        let mut textures = Textures::new();
        let itself = SpectrumInput::Texture(TextureId(0));
        let refused = textures.add(Texture::Scale(itself.clone(), itself));
        assert_eq!(refused, Err(TextureError::Unknown(0, 0)));
        assert!(textures.is_empty());
        let foreign = textures.spectrum(&SpectrumInput::Texture(TextureId(9)), &point(), &RGB);
        assert_eq!(foreign, Spectrum::BLACK);
    }

    #[test]
    fn textures_of_doubling_cost_are_refused() {
        let mut textures = Textures::new();
        let mut last = textures.add(Texture::Constant(Spectrum::ONE)).unwrap();
        // Costs 1, 3, 7, ... 2^k - 1: the ninth product still has 1023 > 1000.
        let error = loop {
            let both = SpectrumInput::Texture(last);
            match textures.add(Texture::Scale(both.clone(), both)) {
                Ok(id) => last = id,
                Err(error) => break error,
            }
        };
        assert_eq!(error, TextureError::Cost(1023));
        assert_eq!(textures.len(), 9);
        assert_eq!(rgb(&textures, last), [1.0; 3]);
    }

    #[test]
    fn longest_chain_can_be_evaluated() {
        let mut textures = Textures::new();
        let mut last = textures.add(Texture::Constant(Spectrum::ONE)).unwrap();
        let one = SpectrumInput::Constant(Spectrum::ONE);
        for _ in 1..Textures::MAX_EVALUATIONS {
            last = textures.add(Texture::Scale(SpectrumInput::Texture(last), one.clone())).unwrap();
        }
        assert_eq!(rgb(&textures, last), [1.0; 3]);
        let refused = textures.add(Texture::Scale(SpectrumInput::Texture(last), one.clone()));
        assert_eq!(refused, Err(TextureError::Cost(1001)));
    }
}
