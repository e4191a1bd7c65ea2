//! Pictures on a rectangle.

use glanz_job::ScratchFileError;
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::DVec2;
use glanz_shading::texture::MipMap;

/// Weights of a pixel and its neighbours in the mean of linear interpolation over the pixel: across half a pixel the weight of the neighbour falls
/// from 1/2 to 0.
pub(super) const CELL_WEIGHTS: [(i64, f64); 3] = [(-1, 0.125), (0, 0.75), (1, 0.125)];

/// A picture on the unit square, row 0 at y = 0; beyond its border it continues as at the border.
#[derive(Clone, Debug)]
pub(crate) struct FlatImage {
    width: usize,
    height: usize,
    texels: Vec<Spectrum>,
}

impl FlatImage {
    /// The picture of a value per pixel, by the pixel's middle.
    pub(super) fn new([width, height]: [usize; 2], value: impl Fn(DVec2) -> Spectrum) -> Self {
        let texels = (0..width * height).map(|i| value(middle([width, height], i))).collect();
        Self { width, height, texels }
    }

    /// The picture times `factor`; pixels that are negative or not finite count as black.
    ///
    /// # Errors
    /// [`ScratchFileError`] if the picture is in a file that cannot be read.
    pub(crate) fn of_picture(picture: &MipMap, factor: Spectrum) -> Result<Self, ScratchFileError> {
        let positive = |x: f32| if x > 0.0 && x.is_finite() { x } else { 0.0 };
        let texel = |rgb: [f32; 3]| factor * Spectrum::from_rgb(rgb.map(positive));
        let texels = picture.to_rgb()?.into_iter().map(texel).collect();
        let [width, height] = picture.size();
        Ok(Self { width, height, texels })
    }

    /// The picture with at most `most` pixels along each side: means of equal parts.
    pub(super) fn reduced(&self, most: usize) -> Self {
        let (width, height) = (self.width.min(most), self.height.min(most));
        let mut texels = vec![Spectrum::default(); width * height];
        for (i, &texel) in self.texels.iter().enumerate() {
            for (row, of_row) in overlaps(i / self.width, self.height, height) {
                for (column, of_column) in overlaps(i % self.width, self.width, width) {
                    if let Some(sum) = texels.get_mut(row * width + column) {
                        *sum += texel * (of_row * of_column) as f32;
                    }
                }
            }
        }
        Self { width, height, texels }
    }

    /// Columns and rows.
    pub(super) fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    fn texel(&self, column: i64, row: i64) -> Spectrum {
        let (width, height) = (self.width as i64, self.height as i64);
        let (column, row) = (column.clamp(0, width - 1), row.clamp(0, height - 1));
        self.texels.get((row * width + column) as usize).copied().unwrap_or_default()
    }

    /// The value at a place, interpolated between the four nearest pixels.
    pub(super) fn lookup(&self, place: DVec2) -> Spectrum {
        let at = place * DVec2::new(self.width as f64, self.height as f64) - 0.5;
        let corner = at.floor();
        let share = (at - corner).as_vec2();
        let row = |y: i64| {
            let (x, y) = (corner.x as i64, (corner.y as i64).saturating_add(y));
            self.texel(x, y).lerp(self.texel(x.saturating_add(1), y), share.x)
        };
        row(0).lerp(row(1), share.y)
    }

    /// For each pixel, its middle and the mean of [`FlatImage::lookup`] over it.
    pub(super) fn cells(&self) -> impl Iterator<Item = (DVec2, Spectrum)> + '_ {
        (0..self.texels.len()).map(|i| {
            let (column, row) = ((i % self.width) as i64, (i / self.width) as i64);
            let mean = CELL_WEIGHTS
                .iter()
                .flat_map(|&(y, of_row)| CELL_WEIGHTS.map(|(x, of_column)| (x, y, of_row * of_column)))
                .map(|(x, y, weight)| self.texel(column + x, row + y) * weight as f32)
                .sum();
            (middle([self.width, self.height], i), mean)
        })
    }

    /// The mean of the values, in RGB, times `weight`, by the middles of pixels.
    pub(super) fn mean(&self, weight: impl Fn(DVec2) -> f64) -> Spectrum {
        let mut sum = [0.0; 3];
        for (i, texel) in self.texels.iter().enumerate() {
            let weight = weight(middle(self.size(), i));
            let rgb = texel.to_rgb(&Wavelengths::Rgb);
            sum = std::array::from_fn(|band| sum[band] + weight * f64::from(rgb[band]));
        }
        Spectrum::from_rgb(sum.map(|sum: f64| (sum / self.texels.len() as f64) as f32))
    }
}

/// The one or two of `parts` equal parts of `count` pixels, at least as many, that pixel `i` lies in, with its shares of them.
fn overlaps(i: usize, count: usize, parts: usize) -> [(usize, f64); 2] {
    // In units of 1 / parts of a pixel, a part is `count` long.
    let (start, end) = (i * parts, (i + 1) * parts);
    let first = start / count;
    let border = end.min((first + 1) * count);
    [(first, border - start), (first + 1, end - border)]
        .map(|(part, length)| (part, length as f64 / count as f64))
}

/// The middle of pixel `i`.
fn middle([width, height]: [usize; 2], i: usize) -> DVec2 {
    (DVec2::new((i % width) as f64, (i / width) as f64) + 0.5) / DVec2::new(width as f64, height as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lookup_is_linear_between_middles_and_constant_at_the_border() {
        let image = FlatImage::new([4, 2], |at| Spectrum::ONE * (at.x + 10.0 * at.y) as f32);
        for (x, y, expected) in [(0.5, 0.5, 5.5), (0.3, 0.4, 4.3), (0.0, 0.0, 2.625), (1.0, 1.0, 8.375)] {
            let found = image.lookup(DVec2::new(x, y)).max_component();
            assert!((found - expected).abs() < 1e-5, "{x} {y}: {found}");
        }
        assert_eq!(image.lookup(DVec2::splat(1e30)), image.lookup(DVec2::ONE));
    }

    #[test]
    fn means_of_millions_of_pixels_are_precise() {
        for value in [0.7, 0.9] {
            let image = FlatImage::new([1024, 1024], |_| Spectrum::ONE * value);
            assert!((image.mean(|_| 1.0).max_component() / value - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn cells_are_means_of_the_interpolation() {
        let value = |at: DVec2| Spectrum::ONE * ((7.0 * at.x).sin().abs() + at.y * at.y) as f32;
        let image = FlatImage::new([5, 3], value);
        let n = 40;
        for (i, (middle, mean)) in image.cells().enumerate() {
            let corner = DVec2::new((i % 5) as f64, (i / 5) as f64);
            assert!((middle - (corner + 0.5) / DVec2::new(5.0, 3.0)).length() < 1e-15);
            // The midpoint rule is exact for functions that are linear in each half of the pixel.
            let sum: f64 = (0..n * n)
                .map(|j| {
                    let inside = DVec2::new(f64::from(j % n) + 0.5, f64::from(j / n) + 0.5) / f64::from(n);
                    f64::from(image.lookup((corner + inside) / DVec2::new(5.0, 3.0)).max_component())
                })
                .sum();
            assert!((sum / f64::from(n * n) - f64::from(mean.max_component())).abs() < 1e-5);
        }
    }
}
