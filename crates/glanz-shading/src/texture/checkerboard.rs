//! Checkerboards of two textures.

use glanz_math::DVec3;

use super::{SpectrumInput, TextureCoordinates, TextureMapping, TexturePoint};

/// Two textures alternating in unit squares of a flat, or unit cubes of a [`TextureMapping::Solid`] mapping.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkerboard {
    /// Input in cells whose numbers have an even sum.
    pub even: SpectrumInput,
    /// Input in the other cells.
    pub odd: SpectrumInput,
    /// Coordinates in cells.
    pub mapping: TextureMapping,
}

impl Checkerboard {
    /// Whether the point lies in one of the cells of [`Checkerboard::odd`].
    #[must_use]
    pub fn is_odd(&self, at: &TexturePoint) -> bool {
        let TextureCoordinates { position: DVec3 { x, y, z }, solid } = self.mapping.coordinates(at);
        // A number that is not finite has no cell.
        let is_odd = |x: f64| x.is_finite() && x.floor().rem_euclid(2.0) != 0.0;
        is_odd(x) ^ is_odd(y) ^ (solid && is_odd(z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_light::Spectrum;
    use glanz_math::{DVec2, Transform};

    fn board(mapping: TextureMapping) -> Checkerboard {
        Checkerboard { even: Spectrum::ONE.into(), odd: Spectrum::BLACK.into(), mapping }
    }

    fn uv(u: f64, v: f64) -> TexturePoint {
        TexturePoint::new(DVec2::new(u, v), DVec3::ZERO)
    }

    #[test]
    fn cells_alternate_on_both_sides_of_zero() {
        let board = board(TextureMapping::default());
        for (u, v, odd) in [
            (0.5, 0.5, false),
            (1.5, 0.5, true),
            (1.5, 1.5, false),
            (-0.5, 0.5, true),
            (-0.5, -0.5, false),
            (0.0, 1.0, true),
        ] {
            assert_eq!(board.is_odd(&uv(u, v)), odd, "({u}, {v})");
        }
    }

    #[test]
    fn solid_board_alternates_along_all_axes() {
        let board = board(TextureMapping::Solid { to_texture: Transform::IDENTITY });
        let at = |x, y, z| board.is_odd(&TexturePoint::new(DVec2::ZERO, DVec3::new(x, y, z)));
        assert!(!at(0.5, 0.5, 0.5));
        assert!(at(0.5, 0.5, 1.5));
        assert!(!at(1.5, 0.5, 1.5));
        assert!(at(1.5, 1.5, 1.5));
    }

    #[test]
    fn infinite_and_huge_coordinates_have_a_cell() {
        let board = board(TextureMapping::default());
        for u in [1e300, f64::INFINITY, f64::NAN, -1e18] {
            assert!(!board.is_odd(&uv(u, 0.5)), "{u}");
        }
    }
}
