//! Noise of an image.

use glanz_light::Pixels;

/// Shares of red, green and blue in the luminance of linear Rec. 709.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Root mean square of the standard errors of the pixels' luminance over the mean luminance.
///
/// `pixels`: with the channels R, G, B and Variance.R, .G, .B. The errors of the bands are taken as fully correlated, as they are where
/// noise is that of visibility or of the choice of a light; otherwise this is an upper bound. `None` if variances are missing or not known,
/// or all is black.
pub(crate) fn noise(pixels: &Pixels) -> Option<f64> {
    let [means, variances] = [["R", "G", "B"], ["Variance.R", "Variance.G", "Variance.B"]]
        .map(|names| names.map(|name| pixels.channel(name).unwrap_or_default()));
    let mut luminance = 0.0;
    let mut squares = 0.0;
    let [red, green, blue] = variances;
    for ((&red, &green), &blue) in red.iter().zip(green).zip(blue) {
        let bands = [red, green, blue].map(|v| f64::from(v).sqrt());
        let error: f64 = bands.iter().zip(LUMINANCE).map(|(band, share)| band * share).sum();
        squares += error * error;
    }
    for (band, share) in means.iter().zip(LUMINANCE) {
        luminance += share * band.iter().map(|&value| f64::from(value)).sum::<f64>();
    }
    let count = red.len() as f64;
    let noise = (squares / count).sqrt() / (luminance / count);
    (noise.is_finite() && noise >= 0.0).then_some(noise)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(mean: [f32; 2], variance: [f32; 2]) -> Pixels {
        let mut pixels = Pixels::try_new(2, 1).unwrap();
        for band in ["R", "G", "B"] {
            pixels.add_channel(band, mean.to_vec()).unwrap();
            pixels.add_channel(&format!("Variance.{band}"), variance.to_vec()).unwrap();
        }
        pixels
    }

    #[test]
    fn noise_is_the_root_mean_square_error_over_the_mean() {
        // Errors 0.3 and 0.4: root mean square sqrt(0.125). Mean 2.
        let found = noise(&picture([1.0, 3.0], [0.09, 0.16])).unwrap();
        assert!((found - 0.125_f64.sqrt() / 2.0).abs() < 1e-7, "{found}");
    }

    #[test]
    fn noise_of_black_or_of_one_sample_is_unknown() {
        assert_eq!(noise(&picture([0.0; 2], [0.0; 2])), None);
        assert_eq!(noise(&picture([1.0; 2], [f32::INFINITY; 2])), None);
        assert_eq!(noise(&Pixels::try_new(2, 1).unwrap()), None);
    }
}
