//! Pictures as textures.

use glanz_light::Spectrum;
use glanz_math::DVec2;

use super::{ImageFilter, ImageWrap, MipMap, TextureMapping, TexturePoint};

/// A picture mapped to surfaces.
#[derive(Clone, Debug)]
pub struct ImageTexture {
    /// The picture.
    pub image: MipMap,
    /// Coordinates; the picture fills [0, 1]^2, (0, 0) is its lower left corner.
    pub mapping: TextureMapping,
    /// Values outside the picture.
    pub wrap: ImageWrap,
    /// Interpolation between pixels.
    pub filter: ImageFilter,
    /// Factor on every value.
    pub scale: f32,
    /// Whether the value is 1 minus the scaled value.
    pub invert: bool,
}

impl ImageTexture {
    /// Whether it averages over footprints.
    #[must_use]
    pub fn uses_footprints(&self) -> bool {
        matches!(self.filter, ImageFilter::Trilinear | ImageFilter::Anisotropic { .. })
            && self.image.levels() > 1
    }

    /// The value at a point, never negative.
    #[must_use]
    pub fn evaluate(&self, at: &TexturePoint) -> Spectrum {
        let st = self.mapping.coordinates(at).position.truncate();
        let footprint = match &at.footprint {
            Some(footprint) if self.uses_footprints() => self.mapping.footprint(at, footprint),
            _ => [DVec2::ZERO; 2],
        };
        let rgb = self.image.lookup(st, footprint, self.wrap, self.filter).map(|x| {
            let x = self.scale * x;
            if self.invert { (1.0 - x).max(0.0) } else { x.max(0.0) }
        });
        Spectrum::from_rgb(rgb)
    }
}

#[cfg(test)]
mod tests {
    use glanz_light::{Pixels, Wavelengths};
    use glanz_math::{DVec2, DVec3};

    use super::*;

    #[test]
    fn scale_and_invert_apply_to_values() {
        let texture = |scale, invert| ImageTexture {
            image: MipMap::try_new(&Pixels::try_from_rgb(1, 1, &[[0.25; 3]]).unwrap()).unwrap(),
            mapping: TextureMapping::default(),
            wrap: ImageWrap::Repeat,
            filter: ImageFilter::Bilinear,
            scale,
            invert,
        };
        let at = TexturePoint::new(DVec2::splat(0.5), DVec3::ZERO);
        let red = |t: ImageTexture| t.evaluate(&at).to_rgb(&Wavelengths::Rgb)[0];
        assert_eq!(red(texture(2.0, false)), 0.5);
        assert_eq!(red(texture(2.0, true)), 0.5);
        assert_eq!(red(texture(1.0, true)), 0.75);
        assert_eq!(red(texture(8.0, true)), 0.0);
    }
}
