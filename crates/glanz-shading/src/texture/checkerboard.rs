//! Checkerboards of two textures.

use glanz_math::DVec3;

use super::{SpectrumInput, TextureMapping, TexturePoint};

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
    /// Fraction of the footprint in [`Checkerboard::odd`] cells; 0 or 1 without a footprint.
    ///
    /// The average over a box is exact: the pattern is a product of square waves, one per axis.
    #[must_use]
    pub fn odd_fraction(&self, at: &TexturePoint) -> f32 {
        let coordinates = self.mapping.coordinates(at);
        let DVec3 { x, y, z } = coordinates.position;
        let z = if coordinates.solid { wave(z, coordinates.width) } else { 1.0 };
        (0.5 - 0.5 * wave(x, coordinates.width) * wave(y, coordinates.width) * z) as f32
    }
}

/// Mean over an interval of length `width` around `x` of the wave that is 1 on even and -1 on odd unit intervals.
fn wave(x: f64, width: f64) -> f64 {
    // A number that is not finite has no cell; a large f64 has no fraction, and neither has the footprint.
    if !x.is_finite() {
        return 1.0;
    }
    if width == f64::INFINITY {
        return 0.0;
    }
    let half = 0.5 * width;
    if !(x - half < x && x < x + half) {
        return if x.floor().rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
    }
    // The integral of the wave from 0 is a triangle between 0 and 1.
    let triangle = |x: f64| 1.0 - (x.rem_euclid(2.0) - 1.0).abs();
    (triangle(x + half) - triangle(x - half)) / width
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
            (0.5, 0.5, 0.0),
            (1.5, 0.5, 1.0),
            (1.5, 1.5, 0.0),
            (-0.5, 0.5, 1.0),
            (-0.5, -0.5, 0.0),
            (0.0, 1.0, 1.0),
        ] {
            assert_eq!(board.odd_fraction(&uv(u, v)), odd, "({u}, {v})");
        }
    }

    #[test]
    fn solid_board_alternates_along_all_axes() {
        let board = board(TextureMapping::Solid { to_texture: Transform::IDENTITY });
        let at = |x, y, z| board.odd_fraction(&TexturePoint::new(DVec2::ZERO, DVec3::new(x, y, z)));
        assert_eq!(at(0.5, 0.5, 0.5), 0.0);
        assert_eq!(at(0.5, 0.5, 1.5), 1.0);
        assert_eq!(at(1.5, 0.5, 1.5), 0.0);
        assert_eq!(at(1.5, 1.5, 1.5), 1.0);
    }

    #[test]
    fn footprints_are_averaged_exactly() {
        let board = board(TextureMapping::default());
        // A square of side 1 around (1, 0.5): half even, half odd.
        assert_eq!(board.odd_fraction(&uv(1.0, 0.5).with_footprint(1.0, 0.0)), 0.5);
        // Side 0.5 around (0.875, 0.5): x in [0.625, 1.125], of which a quarter lies in the odd cell.
        assert_eq!(board.odd_fraction(&uv(0.875, 0.5).with_footprint(0.5, 0.0)), 0.25);
        // Many cells.
        assert!((board.odd_fraction(&uv(0.3, 0.4).with_footprint(100.0, 0.0)) - 0.5).abs() < 1e-4);
    }

    #[test]
    fn infinite_and_huge_coordinates_give_a_fraction() {
        let board = board(TextureMapping::default());
        for u in [1e300, f64::INFINITY, f64::NAN, -1e18] {
            for width in [0.0, 1.0, f64::INFINITY] {
                let fraction = board.odd_fraction(&uv(u, 0.5).with_footprint(width, 0.0));
                assert!((0.0..=1.0).contains(&fraction), "u {u}, width {width}: {fraction}");
            }
        }
    }
}
