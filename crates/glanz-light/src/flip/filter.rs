//! The separable filters of FLIP: one kernel along rows, one along columns.

use std::f64::consts::PI;

/// Weights at the offsets -radius ..= radius.
pub(super) struct Kernel(Vec<f32>);

impl Kernel {
    fn radius(&self) -> usize {
        self.0.len() / 2
    }

    /// Values of `f` at the offsets from -radius to radius.
    fn sampled(radius: usize, f: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..=2 * radius).map(|i| f(i as f64 - radius as f64)).collect()
    }

    fn scaled(values: &[f64], factor: f64) -> Self {
        Self(values.iter().map(|v| (v * factor) as f32).collect())
    }

    /// Scales positive weights to the sum 1 and negative ones to -1.
    fn balanced(values: &[f64]) -> Self {
        let sum = |sign: f64| values.iter().map(|v| (v * sign).max(0.0)).sum::<f64>();
        let (positive, negative) = (sum(1.0), sum(-1.0));
        Self(values.iter().map(|&v| (v / if v > 0.0 { positive } else { negative }) as f32).collect())
    }
}

/// Contrast sensitivity of the eye: kernels for Y, Cx and the two Gaussians whose sum is that for Cz.
///
/// # Source
/// @andersson2020 table 1 and equation 5: sums of a sqrt(pi/b) exp(-pi^2 d^2 / b), d in degrees. Each of the two kernels
/// of a product has the square root of the amplitude.
pub(super) fn spatial_kernels(pixels_per_degree: f64) -> [Kernel; 4] {
    const Y: f64 = 0.0047;
    const CX: f64 = 0.0053;
    const CZ: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];
    // Three standard deviations of the widest.
    let radius = (3.0 * (CZ[0].1 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as usize;
    let sampled = |b: f64, amplitude: f64| {
        Kernel::sampled(radius, |i| amplitude * (-(PI * i / pixels_per_degree).powi(2) / b).exp())
    };
    let normalised = |b: f64| {
        let values = sampled(b, 1.0);
        Kernel::scaled(&values, 1.0 / values.iter().sum::<f64>())
    };
    let [wide, narrow] = CZ.map(|(a, b)| sampled(b, (a * (PI / b).sqrt()).sqrt()));
    let squared_sum = |values: &[f64]| values.iter().sum::<f64>().powi(2);
    let factor = 1.0 / (squared_sum(&wide) + squared_sum(&narrow)).sqrt();
    [normalised(Y), normalised(CX), Kernel::scaled(&wide, factor), Kernel::scaled(&narrow, factor)]
}

/// A Gaussian as wide as the eye's feature detectors (0.082 degrees), its first and its second derivative.
///
/// # Source
/// @andersson2020 section 4.2.
pub(super) fn feature_kernels(pixels_per_degree: f64) -> [Kernel; 3] {
    let deviation = 0.5 * 0.082 * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as usize;
    let gauss = |i: f64| (-i * i / (2.0 * deviation * deviation)).exp();
    let smooth = Kernel::sampled(radius, gauss);
    let first = Kernel::sampled(radius, |i| -i * gauss(i));
    let second = Kernel::sampled(radius, |i| (i * i / (deviation * deviation) - 1.0) * gauss(i));
    let sum = smooth.iter().sum::<f64>();
    [Kernel::scaled(&smooth, 1.0 / sum), Kernel::balanced(&first), Kernel::balanced(&second)]
}

/// The plane filtered with `along_row` and then with `along_column`; the values of the border are repeated beyond it.
pub(super) fn blur(
    plane: &[f32],
    width: usize,
    height: usize,
    along_row: &Kernel,
    along_column: &Kernel,
) -> Vec<f32> {
    let mut rows = vec![0.0_f32; plane.len()];
    let radius = along_row.radius();
    let mut padded = Vec::with_capacity(width + 2 * radius);
    for (row, out) in plane.chunks_exact(width).zip(rows.chunks_exact_mut(width)) {
        let (Some(&first), Some(&last)) = (row.first(), row.last()) else { continue };
        padded.clear();
        padded.extend(std::iter::repeat_n(first, radius));
        padded.extend_from_slice(row);
        padded.extend(std::iter::repeat_n(last, radius));
        for (offset, &weight) in along_row.0.iter().enumerate() {
            add_scaled(out, &padded[offset..offset + width], weight);
        }
    }
    let mut result = vec![0.0_f32; plane.len()];
    let radius = along_column.radius();
    for (y, out) in result.chunks_exact_mut(width).enumerate() {
        for (offset, &weight) in along_column.0.iter().enumerate() {
            let from = (y + offset).saturating_sub(radius).min(height - 1);
            add_scaled(out, &rows[from * width..(from + 1) * width], weight);
        }
    }
    result
}

fn add_scaled(to: &mut [f32], from: &[f32], weight: f32) {
    for (t, f) in to.iter_mut().zip(from) {
        *t += weight * f;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(kernel: &Kernel) -> f64 {
        kernel.0.iter().map(|&w| f64::from(w)).sum()
    }

    #[test]
    fn spatial_kernels_preserve_flat_colours() {
        let [y, cx, cz1, cz2] = spatial_kernels(67.0);
        assert!((sum(&y) - 1.0).abs() < 1e-6 && (sum(&cx) - 1.0).abs() < 1e-6);
        assert!((sum(&cz1).powi(2) + sum(&cz2).powi(2) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn derivative_kernels_sum_to_zero() {
        let [smooth, first, second] = feature_kernels(67.0);
        assert!((sum(&smooth) - 1.0).abs() < 1e-6);
        assert!(sum(&first).abs() < 1e-6 && sum(&second).abs() < 1e-6);
    }

    #[test]
    fn blur_repeats_the_border() {
        let kernel = Kernel(vec![0.25, 0.5, 0.25]);
        let delta = Kernel(vec![1.0]);
        assert_eq!(blur(&[4.0, 0.0, 8.0], 3, 1, &kernel, &delta), [3.0, 3.0, 6.0]);
        assert_eq!(blur(&[4.0, 0.0, 8.0], 1, 3, &delta, &kernel), [3.0, 3.0, 6.0]);
        assert_eq!(blur(&[4.0], 1, 1, &kernel, &kernel), [4.0]);
    }
}
