//! Errors of a picture against a reference, pixel by pixel; [`crate::flip`] has the visible ones.

use crate::pixels::Pixels;

/// Errors of comparing two pictures.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CompareError {
    /// The pictures differ in size.
    #[error("the picture has {} x {} pixels, the reference {} x {}; they must be equal", test.0, test.1, reference.0, reference.1)]
    Size {
        /// Width and height of the picture under test.
        test: (u32, u32),
        /// Width and height of the reference.
        reference: (u32, u32),
    },
    /// One of the pictures has neither the channels R, G, B nor the channel Y.
    #[error("a picture has no channels R, G and B; these or Y are needed")]
    NoColour,
    /// No pixel is finite in both pictures.
    #[error("no pixel is finite in both pictures; at least one is needed")]
    NothingFinite,
    /// Pixels per degree of the eye's field that are not positive or above a million.
    #[error("the resolution is {0} pixels per degree; it must be positive and at most 1000000")]
    Resolution(f64),
}

/// The colours of a picture.
pub(crate) struct PictureColours {
    pub(crate) size: (u32, u32),
    pub(crate) rgb: Vec<[f32; 3]>,
}

/// Colours of the picture under test and of the reference.
pub(crate) fn rgb_pair(
    test: &Pixels,
    reference: &Pixels,
) -> Result<(PictureColours, PictureColours), CompareError> {
    let size = |p: &Pixels| (p.width(), p.height());
    if size(test) != size(reference) {
        return Err(CompareError::Size { test: size(test), reference: size(reference) });
    }
    let colours = |p: &Pixels| {
        p.to_rgb().map(|rgb| PictureColours { size: size(p), rgb }).ok_or(CompareError::NoColour)
    };
    Ok((colours(test)?, colours(reference)?))
}

/// Errors of a picture against a reference, over the R, G and B of all pixels that are finite in both.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureComparison {
    /// Pixels that were compared.
    pub compared: usize,
    /// Pixels left out because the picture under test is infinite or NaN there.
    pub excluded_test: usize,
    /// Pixels left out because only the reference is infinite or NaN there.
    pub excluded_reference: usize,
    /// Square root of the mean squared error.
    pub rmse: f64,
    /// Mean of the squared error over (squared reference + epsilon), channel by channel (@rousselle2011 section 5,
    /// where epsilon is 0.01).
    pub relative_mse: f64,
    /// Mean absolute error.
    pub mean_absolute: f64,
    /// Largest absolute error of a channel.
    pub max_error: f64,
    /// Column and row of the first pixel with it.
    pub max_at: (u32, u32),
    /// `rmse` with the values above 1 set to 1 in both pictures: errors in light that a display shows as white do not
    /// count (@pietrek2001 section 3.4.1.2).
    pub clipped_rmse: f64,
    /// Mean of each channel of the picture under test.
    pub mean_test: [f64; 3],
    /// Mean of each channel of the reference.
    pub mean_reference: [f64; 3],
}

/// The usual `epsilon` of [`compare`].
pub const RELATIVE_EPSILON: f64 = 0.01;

/// Compares `test` with `reference`. `epsilon` (positive, usually [`RELATIVE_EPSILON`]) keeps `relative_mse` finite
/// where the reference is dark; its unit is that of the values, squared.
///
/// # Errors
/// [`CompareError::Size`], [`CompareError::NoColour`] or [`CompareError::NothingFinite`].
pub fn compare(test: &Pixels, reference: &Pixels, epsilon: f64) -> Result<PictureComparison, CompareError> {
    let width = test.width() as usize;
    let (test, reference) = rgb_pair(test, reference)?;
    let mut sums = ErrorSums::default();
    for (i, (t, r)) in test.rgb.iter().zip(&reference.rgb).enumerate() {
        if !t.iter().all(|v| v.is_finite()) {
            sums.excluded_test += 1;
        } else if !r.iter().all(|v| v.is_finite()) {
            sums.excluded_reference += 1;
        } else {
            sums.add(i, t.map(f64::from), r.map(f64::from), epsilon);
        }
    }
    if sums.compared == 0 {
        return Err(CompareError::NothingFinite);
    }
    let pixels = sums.compared as f64;
    let values = 3.0 * pixels;
    Ok(PictureComparison {
        compared: sums.compared,
        excluded_test: sums.excluded_test,
        excluded_reference: sums.excluded_reference,
        rmse: (sums.squared / values).sqrt(),
        relative_mse: sums.relative / values,
        mean_absolute: sums.absolute / values,
        max_error: sums.max_error,
        max_at: ((sums.max_at % width) as u32, (sums.max_at / width) as u32),
        clipped_rmse: (sums.clipped / values).sqrt(),
        mean_test: sums.test.map(|s| s / pixels),
        mean_reference: sums.reference.map(|s| s / pixels),
    })
}

/// Sums of the errors and values of the compared pixels.
#[derive(Default)]
struct ErrorSums {
    compared: usize,
    excluded_test: usize,
    excluded_reference: usize,
    squared: f64,
    relative: f64,
    absolute: f64,
    clipped: f64,
    max_error: f64,
    max_at: usize,
    test: [f64; 3],
    reference: [f64; 3],
}

impl ErrorSums {
    fn add(&mut self, index: usize, test: [f64; 3], reference: [f64; 3], epsilon: f64) {
        if self.compared == 0 {
            self.max_at = index;
        }
        self.compared += 1;
        for c in 0..3 {
            let (t, r) = (test[c], reference[c]);
            let error = (t - r).abs();
            self.squared += error * error;
            self.relative += error * error / (r * r + epsilon);
            self.absolute += error;
            self.clipped += (t.min(1.0) - r.min(1.0)).powi(2);
            self.test[c] += t;
            self.reference[c] += r;
            if error > self.max_error {
                self.max_error = error;
                self.max_at = index;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(rgb: &[[f32; 3]]) -> Pixels {
        Pixels::try_from_rgb(rgb.len() as u32, 1, rgb).unwrap()
    }

    #[test]
    fn errors_of_two_pixels_equal_those_computed_by_hand() {
        let reference = picture(&[[0.0, 1.0, 2.0], [0.5, 0.5, 4.0]]);
        let test = picture(&[[0.5, 1.0, 1.0], [0.5, 0.25, 8.0]]);
        let found = compare(&test, &reference, 0.01).unwrap();
        // Differences: 0.5 0 1 0 0.25 4; squares 0.25 0 1 0 0.0625 16.
        let squares: f64 = 0.25 + 1.0 + 0.0625 + 16.0;
        assert!((found.rmse - (squares / 6.0).sqrt()).abs() < 1e-12);
        assert!((found.mean_absolute - 5.75 / 6.0).abs() < 1e-12);
        let relative = 0.25 / 0.01 + 1.0 / 4.01 + 0.0625 / 0.26 + 16.0 / 16.01;
        assert!((found.relative_mse - relative / 6.0).abs() < 1e-12);
        // Clipped: 0.5 0 0 0 0.25 0, since 1 and 2, 4 and 8 are all shown as 1.
        assert!((found.clipped_rmse - (0.3125_f64 / 6.0).sqrt()).abs() < 1e-12);
        assert_eq!((found.max_error, found.max_at), (4.0, (1, 0)));
        assert_eq!(found.mean_test, [0.5, 0.625, 4.5]);
        assert_eq!(found.mean_reference, [0.25, 0.75, 3.0]);
        assert_eq!((found.compared, found.excluded_test, found.excluded_reference), (2, 0, 0));
    }

    #[test]
    fn infinite_pixels_are_counted_and_left_out() {
        let reference = picture(&[[1.0; 3], [f32::INFINITY, 0.0, 0.0], [2.0; 3], [f32::NAN; 3]]);
        let test = picture(&[[f32::NAN, 1.0, 1.0], [1.0; 3], [2.5; 3], [f32::NAN; 3]]);
        let found = compare(&test, &reference, 0.01).unwrap();
        assert_eq!((found.compared, found.excluded_test, found.excluded_reference), (1, 2, 1));
        assert_eq!((found.rmse, found.max_at), (0.5, (2, 0)));
        let nothing = picture(&[[f32::NAN; 3]]);
        assert_eq!(compare(&nothing, &nothing, 0.01), Err(CompareError::NothingFinite));
    }

    #[test]
    fn equal_pictures_have_no_error() {
        let picture = picture(&[[0.1, 2.0, -3.0], [0.0; 3]]);
        let found = compare(&picture, &picture, 0.01).unwrap();
        assert_eq!(
            (found.rmse, found.relative_mse, found.max_error, found.clipped_rmse),
            (0.0, 0.0, 0.0, 0.0)
        );
    }

    #[test]
    fn pictures_of_different_sizes_or_without_colour_are_refused() {
        let one = picture(&[[0.0; 3]]);
        let two = picture(&[[0.0; 3]; 2]);
        assert_eq!(compare(&one, &two, 0.01), Err(CompareError::Size { test: (1, 1), reference: (2, 1) }));
        assert_eq!(compare(&Pixels::try_new(1, 1).unwrap(), &one, 0.01), Err(CompareError::NoColour));
    }

    #[test]
    fn grey_picture_is_compared_with_a_coloured_one() {
        let mut grey = Pixels::try_new(1, 1).unwrap();
        grey.add_channel("Y", vec![1.0]).unwrap();
        assert_eq!(compare(&grey, &picture(&[[1.0, 1.0, 0.0]]), 0.01).unwrap().max_error, 1.0);
    }
}
