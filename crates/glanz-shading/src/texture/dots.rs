//! Random polka dots.

use glanz_math::{DVec2, DVec3};

use super::noise::noise;
use super::{SpectrumInput, TextureMapping, TexturePoint};

/// Radius of a dot, in cells.
const RADIUS: f64 = 0.35;

/// Largest distance of the middle of a dot from that of its cell, by which it stays within the cell.
const MAX_SHIFT: f64 = 0.5 - RADIUS;

/// Dots in about half of the unit squares around points of integers.
///
/// # Source
/// @pbrt4 `InsidePolkaDot`.
#[derive(Clone, Debug, PartialEq)]
pub struct Dots {
    /// Input inside of dots.
    pub inside: SpectrumInput,
    /// Input between them.
    pub outside: SpectrumInput,
    /// Coordinates in cells.
    pub mapping: TextureMapping,
}

impl Dots {
    /// Whether the point lies in a dot.
    #[must_use]
    pub fn is_inside(&self, at: &TexturePoint) -> bool {
        let st = self.mapping.coordinates(at).position.truncate();
        let cell = (st + 0.5).floor();
        let random = |s: f64, t: f64| noise(DVec3::new(cell.x + s, cell.y + t, 0.5));
        if random(0.5, 0.5) <= 0.0 {
            return false;
        }
        let center = cell + MAX_SHIFT * DVec2::new(random(1.5, 2.8), random(4.5, 9.8));
        (st - center).length_squared() < RADIUS * RADIUS
    }
}

#[cfg(test)]
mod tests {
    use glanz_light::Spectrum;

    use super::*;

    fn is_inside(s: f64, t: f64) -> bool {
        let (inside, outside) = (Spectrum::ONE.into(), Spectrum::BLACK.into());
        let dots = Dots { inside, outside, mapping: TextureMapping::default() };
        dots.is_inside(&TexturePoint::new(DVec2::new(s, t), DVec3::ZERO))
    }

    #[test]
    fn every_cell_has_the_area_of_a_whole_dot_or_none() {
        const STEPS: u32 = 100;
        let (mut with_dot, mut cells) = (0, 0);
        for (s, t) in (-10..10).flat_map(|s| (-10..10).map(move |t| (s, t))) {
            let offset = |i: u32| (f64::from(i) + 0.5) / f64::from(STEPS) - 0.5;
            let points = (0..STEPS * STEPS).map(|i| (offset(i % STEPS), offset(i / STEPS)));
            let inside = points.filter(|(x, y)| is_inside(f64::from(s) + x, f64::from(t) + y)).count();
            let share = inside as f64 / f64::from(STEPS * STEPS);
            let dot = std::f64::consts::PI * RADIUS * RADIUS;
            assert!(share == 0.0 || (share - dot).abs() < 0.01, "{s}, {t}: {share}");
            cells += 1;
            with_dot += u32::from(share > 0.0);
        }
        assert!((0.4..0.6).contains(&(f64::from(with_dot) / f64::from(cells))), "{with_dot} of {cells}");
    }

    #[test]
    fn coordinates_that_are_not_finite_lie_outside() {
        assert!(!is_inside(f64::NAN, 0.0) && !is_inside(f64::INFINITY, 1.0));
    }
}
