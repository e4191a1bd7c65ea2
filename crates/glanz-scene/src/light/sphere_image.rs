//! Pictures over all directions.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glanz_job::ScratchFileError;
use glanz_math::{DVec2, DVec3};
use glanz_sampling::warp;
use glanz_shading::texture::MipMap;

use super::flat_image::CELL_WEIGHTS;
use crate::description::SphereMapping;

/// Rows from which on a sum over pixels stands for an integral over the interpolated picture: its error decreases with the square of their number.
const FINE_ROWS: usize = 256;

/// A picture over all directions around a point.
///
/// Pixels that are negative or not finite count as black.
#[derive(Clone, Debug)]
pub struct SphereImage {
    mapping: SphereMapping,
    width: usize,
    height: usize,
    /// Rows from the top; a vector, which a slice would be copied from.
    texels: Arc<Vec<[f32; 3]>>,
}

/// A pixel of a [`SphereImage`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereTexel {
    /// Unit direction of its middle.
    pub direction: DVec3,
    /// Its solid angle, sr.
    pub solid_angle: f64,
    /// Its value, linear Rec. 709.
    pub rgb: [f32; 3],
}

impl SphereImage {
    /// The picture over all directions.
    ///
    /// # Errors
    /// [`ScratchFileError`] if the picture is in a file that cannot be read.
    pub fn try_new(picture: &MipMap, mapping: SphereMapping) -> Result<Self, ScratchFileError> {
        let positive = |x: f32| if x > 0.0 && x.is_finite() { x } else { 0.0 };
        let mut texels = picture.to_rgb()?;
        texels.iter_mut().for_each(|rgb| *rgb = rgb.map(positive));
        let [width, height] = picture.size();
        Ok(Self { mapping, width, height, texels: Arc::new(texels) })
    }

    /// A square picture of `function` of unit directions, at the middles of `size` times `size` pixels; its values are not negative.
    pub(super) fn of(mapping: SphereMapping, size: usize, function: impl Fn(DVec3) -> [f32; 3]) -> Self {
        let place = |i| (DVec2::new((i % size) as f64, (i / size) as f64) + 0.5) / size as f64;
        let texels = (0..size * size).map(|i| function(mapping.direction(place(i)))).collect();
        Self { mapping, width: size, height: size, texels: Arc::new(texels) }
    }

    /// Pixels per row.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Its mapping to directions.
    #[must_use]
    pub fn mapping(&self) -> SphereMapping {
        self.mapping
    }

    /// The value in a unit direction, interpolated between the four nearest pixels.
    #[must_use]
    pub fn lookup(&self, direction: DVec3) -> [f32; 3] {
        let at = self.mapping.place(direction) * DVec2::new(self.width as f64, self.height as f64) - 0.5;
        let corner = at.floor();
        let share = (at - corner).as_vec2();
        let (column, row) = (corner.x as i64, corner.y as i64);
        let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| self.wrapped(column + x, row + y));
        std::array::from_fn(|i| {
            let (top, bottom) = (a[i] + share.x * (b[i] - a[i]), c[i] + share.x * (d[i] - c[i]));
            (top + share.y * (bottom - top)).max(0.0)
        })
    }

    /// The pixel at this column and row, which may lie up to the size of the picture beyond its border.
    fn wrapped(&self, column: i64, row: i64) -> [f32; 3] {
        let (width, height) = (self.width as i64, self.height as i64);
        let (mut column, mut row) = (column, row);
        match self.mapping {
            SphereMapping::LatitudeLongitude => {
                // Beyond a pole the meridian continues on the other side.
                if !(0..height).contains(&row) {
                    row = if row < 0 { -1 - row } else { 2 * height - 1 - row };
                    column += width / 2;
                }
                column = column.rem_euclid(width);
            }
            SphereMapping::EqualArea => {
                // The two halves of each side are the same line of the sphere.
                if !(0..width).contains(&column) {
                    column = if column < 0 { -1 - column } else { 2 * width - 1 - column };
                    row = height - 1 - row;
                }
                if !(0..height).contains(&row) {
                    row = if row < 0 { -1 - row } else { 2 * height - 1 - row };
                    column = width - 1 - column;
                }
            }
        }
        self.texels.get((row * width + column) as usize).copied().unwrap_or([0.0; 3])
    }

    /// The mean of [`SphereImage::lookup`] over a pixel, by its coordinates in the picture.
    pub(super) fn mean_of_cell(&self, column: usize, row: usize) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (y, weight_y) in CELL_WEIGHTS {
            for (x, weight_x) in CELL_WEIGHTS {
                let rgb = self.wrapped(column as i64 + x, row as i64 + y);
                for (sum, value) in sum.iter_mut().zip(rgb) {
                    *sum += weight_x * weight_y * f64::from(value);
                }
            }
        }
        sum
    }

    /// Solid angle of each pixel of a row, sr.
    pub(super) fn solid_angle(&self, row: usize) -> f64 {
        self.mapping.band(row, self.height) / self.width as f64
    }

    /// All pixels, row by row.
    pub fn texels(&self) -> impl Iterator<Item = SphereTexel> + '_ {
        let size = DVec2::new(self.width as f64, self.height as f64);
        self.texels.iter().enumerate().map(move |(i, &rgb)| {
            let (column, row) = (i % self.width, i / self.width);
            let place = (DVec2::new(column as f64, row as f64) + 0.5) / size;
            SphereTexel { direction: self.mapping.direction(place), solid_angle: self.solid_angle(row), rgb }
        })
    }

    /// The mean over all directions.
    #[must_use]
    pub fn mean(&self) -> [f32; 3] {
        self.integral(|_| 1.0).map(|sum| (sum / (4.0 * PI)) as f32)
    }

    /// Irradiance on a surface that faces z, by a picture of radiance.
    #[must_use]
    pub fn irradiance(&self) -> [f64; 3] {
        let fine = (self.height < FINE_ROWS)
            .then(|| Self::of(self.mapping, FINE_ROWS, |direction| self.lookup(direction)));
        fine.as_ref().unwrap_or(self).integral(|direction| direction.z.max(0.0))
    }

    /// Integral over solid angle of the picture times a weight by unit direction.
    fn integral(&self, weight: impl Fn(DVec3) -> f64) -> [f64; 3] {
        self.texels().fold([0.0; 3], |sum, texel| {
            let weight = texel.solid_angle * weight(texel.direction);
            std::array::from_fn(|i| sum[i] + weight * f64::from(texel.rgb[i]))
        })
    }
}

impl SphereMapping {
    /// The unit direction at a point of [0, 1]^2, from the upper left corner.
    #[must_use]
    pub fn direction(self, place: DVec2) -> DVec3 {
        match self {
            Self::LatitudeLongitude => {
                let ((sin, z), (y, x)) = ((PI * place.y).sin_cos(), (TAU * place.x).sin_cos());
                DVec3::new(sin * x, sin * y, z)
            }
            Self::EqualArea => warp::equal_area_sphere(place),
        }
    }

    /// The point in [0, 1)^2 of a unit direction.
    #[must_use]
    pub fn place(self, direction: DVec3) -> DVec2 {
        match self {
            Self::LatitudeLongitude => {
                let polar = direction.truncate().length().atan2(direction.z) / PI;
                let turn = warp::uniform_sphere_inverse(direction).y;
                DVec2::new(turn, polar.min(1.0 - f64::EPSILON / 2.0))
            }
            Self::EqualArea => warp::equal_area_sphere_inverse(direction),
        }
    }

    /// Solid angle of one of `rows` rows, sr; in an equal-area picture the mean of all, as each pixel has the same.
    pub(super) fn band(self, row: usize, rows: usize) -> f64 {
        let rows = rows as f64;
        match self {
            // cos a - cos b = 2 sin((a + b) / 2) sin((b - a) / 2), without cancellation.
            Self::LatitudeLongitude => {
                2.0 * TAU * (PI * (row as f64 + 0.5) / rows).sin() * (0.5 * PI / rows).sin()
            }
            Self::EqualArea => 4.0 * PI / rows,
        }
    }
}

#[cfg(test)]
mod tests {
    use glanz_light::Pixels;

    use super::*;

    const MAPPINGS: [SphereMapping; 2] = [SphereMapping::LatitudeLongitude, SphereMapping::EqualArea];

    fn image(pixels: &Pixels, mapping: SphereMapping) -> SphereImage {
        SphereImage::try_new(&MipMap::try_new(pixels).unwrap(), mapping).unwrap()
    }

    /// A picture of the directions themselves, moved into [0, 2].
    fn of_directions(mapping: SphereMapping, width: u32, height: u32) -> SphereImage {
        let rgb: Vec<[f32; 3]> = (0..width * height)
            .map(|i| {
                let place = DVec2::new(f64::from(i % width) + 0.5, f64::from(i / width) + 0.5);
                let direction = mapping.direction(place / DVec2::new(f64::from(width), f64::from(height)));
                (direction.as_vec3() + 1.0).to_array()
            })
            .collect();
        image(&Pixels::try_from_rgb(width, height, &rgb).unwrap(), mapping)
    }

    fn spread(i: u32) -> DVec3 {
        let x = |step: f64| (0.5 + f64::from(i) * step).fract();
        warp::uniform_sphere(DVec2::new(x(0.754_877_666), x(0.569_840_296)))
    }

    #[test]
    fn lookup_of_a_picture_of_directions_is_the_direction_also_across_borders() {
        // A pixel spans about 0.05; interpolation of curved coordinates errs by the square of that, but on the axes and the border of the
        // square, where the map bends, by a fraction of it.
        for (mapping, width, height, tolerance) in
            [(SphereMapping::LatitudeLongitude, 128, 64, 2e-3), (SphereMapping::EqualArea, 96, 96, 2e-2)]
        {
            let image = of_directions(mapping, width, height);
            let near_poles = [0.0, 1e-3, 0.02].map(|x| DVec3::new(x, -0.5 * x, 1.0).normalize());
            let near_poles = near_poles.into_iter().flat_map(|d| [d, -d, DVec3::new(d.y, d.z, d.x)]);
            for direction in (0..20_000).map(spread).chain(near_poles) {
                let found = DVec3::from_array(image.lookup(direction).map(f64::from)) - 1.0;
                assert!((found - direction).abs().max_element() < tolerance, "{direction}: {found}");
            }
        }
    }

    #[test]
    fn z_is_up_and_x_is_where_rows_start() {
        let near = |mapping: SphereMapping, x: f64, y: f64, expected: DVec3| {
            assert!((mapping.direction(DVec2::new(x, y)) - expected).length() < 1e-12, "{x} {y}");
        };
        near(SphereMapping::LatitudeLongitude, 0.3, 0.0, DVec3::Z);
        near(SphereMapping::LatitudeLongitude, 0.0, 0.5, DVec3::X);
        near(SphereMapping::LatitudeLongitude, 0.25, 0.5, DVec3::Y);
        near(SphereMapping::EqualArea, 0.5, 0.5, DVec3::Z);
        near(SphereMapping::EqualArea, 0.0, 0.0, -DVec3::Z);
        near(SphereMapping::EqualArea, 1.0, 0.5, DVec3::X);
        near(SphereMapping::EqualArea, 0.5, 1.0, DVec3::Y);
    }

    #[test]
    fn places_and_directions_are_inverse() {
        for mapping in MAPPINGS {
            for direction in (0..5000).map(spread).chain([DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Z]) {
                let place = mapping.place(direction);
                assert!(place.min_element() >= 0.0 && place.max_element() < 1.0);
                assert!((mapping.direction(place) - direction).length() < 1e-7);
            }
        }
    }

    #[test]
    fn solid_angles_add_up_to_the_sphere() {
        for mapping in MAPPINGS {
            let image = of_directions(mapping, 48, 48);
            let whole: f64 = image.texels().map(|texel| texel.solid_angle).sum();
            assert!((whole - 4.0 * PI).abs() < 1e-12);
        }
    }

    #[test]
    fn even_picture_has_the_irradiance_of_a_sky() {
        for mapping in MAPPINGS {
            let pixels = Pixels::try_from_rgb(64, 64, &[[1.0, 2.0, 0.0]; 4096]).unwrap();
            for (found, expected) in image(&pixels, mapping).irradiance().into_iter().zip([PI, 2.0 * PI, 0.0])
            {
                // Sums over 4096 pixels by their middles.
                assert!((found - expected).abs() <= 2e-3 * expected, "{mapping:?}: {found} {expected}");
            }
        }
    }

    #[test]
    fn irradiance_of_a_small_picture_is_that_of_its_interpolation() {
        // Two rows: light (1, 2, 3) down to 45 degrees from the pole, then less and less of it to 135. pi times the integral of sin 2t by the
        // polar angle t is pi / 2 to 45 degrees, and with the factor 3/2 - 2t / pi it is pi / 4 + 1/2 from there to the horizon.
        let pixels = Pixels::try_from_rgb(1, 2, &[[1.0, 2.0, 3.0], [0.0; 3]]).unwrap();
        let image = image(&pixels, SphereMapping::LatitudeLongitude);
        for (found, times) in image.irradiance().into_iter().zip([1.0, 2.0, 3.0]) {
            let expected = times * (0.75 * PI + 0.5);
            assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
        }
    }

    #[test]
    fn mean_of_a_sky_over_black_ground_is_half_the_sky() {
        for (mapping, is_sky) in [
            (SphereMapping::LatitudeLongitude, (|i| i < 200) as fn(u32) -> bool),
            // The upper half of the square is the half of y < 0.
            (SphereMapping::EqualArea, |i| i < 200),
        ] {
            let rgb: Vec<[f32; 3]> =
                (0..400).map(|i| if is_sky(i) { [2.0, 4.0, 6.0] } else { [0.0; 3] }).collect();
            let image = image(&Pixels::try_from_rgb(20, 20, &rgb).unwrap(), mapping);
            for (found, expected) in image.mean().iter().zip([1.0, 2.0, 3.0]) {
                assert!((found - expected).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn pole_has_less_weight_than_the_equator_except_in_equal_area_maps() {
        let of = |width: u32, height: u32, mapping| {
            let count = width * height;
            let rgb: Vec<[f32; 3]> = (0..count).map(|i| [f32::from(u8::from(i < width)); 3]).collect();
            let pixels = Pixels::try_from_rgb(width, height, &rgb).unwrap();
            f64::from(image(&pixels, mapping).mean()[0])
        };
        // The cap within 60 degrees of the pole: (1 - cos 60) / 2.
        assert!((of(6, 3, SphereMapping::LatitudeLongitude) - 0.25).abs() < 1e-7);
        assert!((of(3, 3, SphereMapping::EqualArea) - 1.0 / 3.0).abs() < 1e-7);
    }

    #[test]
    fn pixels_that_are_no_light_are_black() {
        let rgb = [[f32::NAN, -1.0, f32::INFINITY], [1.0; 3]];
        let pixels = Pixels::try_from_rgb(2, 1, &rgb).unwrap();
        let image = image(&pixels, SphereMapping::LatitudeLongitude);
        assert_eq!(image.mean(), [0.5; 3]);
    }
}
