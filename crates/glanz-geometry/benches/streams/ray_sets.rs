//! Sets of rays for batches: a picture in tiles, and random lines.

use glanz_math::{Bounds3, DVec3, Ray};

/// Side of a tile, pixels.
pub(crate) const TILE: usize = 64;

/// Values of the pixels of a picture of this size, given line by line, in the order of tiles.
pub(crate) fn tiles<T: Copy>(lines: &[T], [width, height]: [usize; 2]) -> Vec<T> {
    let corners = (0..height).step_by(TILE).flat_map(|y| (0..width).step_by(TILE).map(move |x| (x, y)));
    let pixels = corners.flat_map(|(x, y)| {
        (y..(y + TILE).min(height))
            .flat_map(move |row| (x..(x + TILE).min(width)).map(move |column| row * width + column))
    });
    pixels.filter_map(|pixel| lines.get(pixel).copied()).collect()
}

/// Lines through two points of a ball around the surface.
pub(crate) fn random_lines(bounds: &Bounds3, count: usize) -> Vec<Ray> {
    let mut state = 1_u64;
    let mut unit = || {
        state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (center, radius) = (bounds.center(), 0.5 * bounds.diagonal().length());
    let mut point = || loop {
        let p = 2.0 * DVec3::new(unit(), unit(), unit()) - 1.0;
        if p.length_squared() <= 1.0 {
            return center + radius * p;
        }
    };
    (0..count)
        .map(|_| {
            let (a, b) = (point(), point());
            let direction = (b - a).normalize();
            Ray::new(a - 2.0 * radius * direction, direction)
        })
        .collect()
}
