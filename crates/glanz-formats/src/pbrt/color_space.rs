//! Colour spaces of `rgb` values (`ColorSpace`, version 4).

use glanz_light::rgb::xyz_to_rgb;
use glanz_math::{DMat3, DVec3};

/// The colour spaces of pbrt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) enum ColorSpace {
    /// sRGB, linear: Rec. 709.
    #[default]
    Rec709,
    /// Rec. 2020.
    Rec2020,
    /// Display P3.
    DciP3,
    /// ACES 2065-1.
    Aces,
}

impl ColorSpace {
    /// The colour space by its name in a scene.
    pub(crate) fn of_name(name: &str) -> Option<Self> {
        Some(match name {
            "srgb" => Self::Rec709,
            "rec2020" => Self::Rec2020,
            "dci-p3" => Self::DciP3,
            "aces2065-1" => Self::Aces,
            _ => return None,
        })
    }

    /// Chromaticities of red, green, blue and white.
    fn chromaticities(self) -> [[f64; 2]; 4] {
        const D65: [f64; 2] = [0.3127, 0.3290];
        match self {
            Self::Rec709 => [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], D65],
            Self::Rec2020 => [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046], D65],
            Self::DciP3 => [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060], D65],
            Self::Aces => [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.0770], [0.32168, 0.33767]],
        }
    }

    /// The same colour in linear Rec. 709, with white preserved; components outside its gamut become 0.
    ///
    /// The primaries are weighted so that (1, 1, 1) is the space's white of luminance 1, and that white is then taken
    /// for D65 band by band. For ACES, whose white is near D60, this is the simplest of chromatic adaptations.
    pub(crate) fn to_rec709(self, rgb: [f64; 3]) -> [f64; 3] {
        if self == Self::Rec709 {
            return rgb;
        }
        let [r, g, b, w] = self.chromaticities().map(|[x, y]| DVec3::new(x, y, 1.0 - x - y));
        let primaries = DMat3::from_cols(r, g, b);
        let weights = primaries.inverse() * (w / w.y);
        let of = |rgb: DVec3| DVec3::from_array(xyz_to_rgb((primaries * (weights * rgb)).to_array()));
        (of(DVec3::from_array(rgb)) / of(DVec3::ONE)).max(DVec3::ZERO).to_array()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPACES: [ColorSpace; 4] =
        [ColorSpace::Rec709, ColorSpace::Rec2020, ColorSpace::DciP3, ColorSpace::Aces];

    #[test]
    fn white_stays_white_in_every_space() {
        for space in SPACES {
            for x in space.to_rec709([0.5; 3]) {
                assert!((x - 0.5).abs() < 1e-12, "{space:?}");
            }
        }
    }

    #[test]
    fn green_of_rec2020_has_the_published_conversion_clipped() {
        // ITU-R BT.2087: the second column of the matrix from Rec. 2020 to Rec. 709 is (-0.5876, 1.1329, -0.1006).
        let [r, g, b] = ColorSpace::Rec2020.to_rec709([0.0, 1.0, 0.0]);
        assert_eq!((r, b), (0.0, 0.0));
        assert!((g - 1.1329).abs() < 1e-4);
        // Adding half a white brings red into the gamut: 0.6 - 0.5876.
        let [r, _, _] = ColorSpace::Rec2020.to_rec709([0.6, 1.6, 0.6]);
        assert!((r - 0.0124).abs() < 1e-4);
    }
}
