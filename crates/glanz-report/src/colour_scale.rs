//! Colours assigned to numbers.

use crate::number::{decimal, ticks};
use crate::palette::Palette;

/// Ratio of the largest number to the mean from which on a scale is logarithmic: equal steps would show only the peak.
const UNEVEN: f64 = 30.0;

/// Least lower end of a logarithmic scale, as a factor of its upper end.
const DEPTH: f64 = 1e-4;

/// A linear or logarithmic scale of colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourScale {
    low: f64,
    high: f64,
    logarithmic: bool,
    palette: Palette,
}

impl ColourScale {
    /// A scale of [`Palette::Viridis`] for numbers that are not negative, each with its weight: from 0, or from the
    /// least if all are within a factor of 2; up to the largest.
    ///
    /// The scale is linear, but logarithmic if the largest number is more than 30 times the weighted mean and the
    /// positive numbers differ by more than a factor of 2; it then reaches down to the least positive one, at most by a
    /// factor of 10^4.
    #[must_use]
    pub fn of(numbers: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
        let (mut least, mut sum, mut weights) = (f64::INFINITY, 0.0, 0.0);
        for (number, weight) in numbers {
            (low, high) = (low.min(number), high.max(number));
            least = if number > 0.0 { least.min(number) } else { least };
            (sum, weights) = (sum + number * weight, weights + weight);
        }
        let palette = Palette::Viridis;
        if high <= 0.0 {
            return Self { low: 0.0, high: 1.0, logarithmic: false, palette };
        }
        if high * weights > UNEVEN * sum && least < 0.5 * high {
            return Self { low: least.max(DEPTH * high), high, logarithmic: true, palette };
        }
        // Differences of a few roundings are none.
        let is_even = 2.0 * low > high && high - low > 1e-6 * high;
        Self { low: if is_even { low } else { 0.0 }, high, logarithmic: false, palette }
    }

    /// A linear scale of [`Palette::CoolWarm`] from -`extent` to `extent`; an extent that is not positive and finite is
    /// taken as 1.
    #[must_use]
    pub fn of_differences(extent: f64) -> Self {
        let extent = if extent > 0.0 && extent.is_finite() { extent } else { 1.0 };
        Self { low: -extent, high: extent, logarithmic: false, palette: Palette::CoolWarm }
    }

    /// The lower end of a logarithmic scale; smaller numbers have the lowest colour. `None` for a linear scale.
    #[must_use]
    pub fn floor(&self) -> Option<f64> {
        self.logarithmic.then_some(self.low)
    }

    /// The position of a number between the ends of the scale, which are 0 and 1; clamped.
    #[must_use]
    pub fn position(&self, number: f64) -> f64 {
        let position = if self.logarithmic {
            (number / self.low).ln() / (self.high / self.low).ln()
        } else {
            (number - self.low) / (self.high - self.low)
        };
        position.clamp(0.0, 1.0)
    }

    /// The colour of a number as sRGB bytes.
    #[must_use]
    pub fn colour(&self, number: f64) -> [u8; 3] {
        self.palette.colour(self.position(number))
    }

    /// The colour at a position in [0, 1] as sRGB bytes.
    #[must_use]
    pub fn colour_at(&self, position: f64) -> [u8; 3] {
        self.palette.colour(position)
    }

    /// Positions in [0, 1] of round numbers with their labels, ascending; about `count` of them.
    #[must_use]
    pub fn ticks(&self, count: f64) -> Vec<(f64, String)> {
        if !self.logarithmic {
            let ticks = ticks(self.low, self.high, count);
            return ticks.into_iter().map(|(number, label)| (self.position(number), label)).collect();
        }
        let mut ticks = Vec::new();
        let decades = (self.high / self.low).log10();
        let digits: &[&str] = if 3.0 * decades <= count { &["1", "2", "5"] } else { &["1"] };
        for power in self.low.log10().floor() as i32..=self.high.log10().floor() as i32 {
            for digit in digits {
                let (number, label) = decimal(digit, power);
                if (self.low..=self.high).contains(&number) {
                    ticks.push((self.position(number), label));
                }
            }
        }
        ticks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(numbers: &[f64]) -> ColourScale {
        ColourScale::of(numbers.iter().map(|number| (*number, 1.0)))
    }

    fn labels(scale: ColourScale, count: f64) -> Vec<String> {
        scale.ticks(count).into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn scale_begins_at_darkness_unless_light_is_even() {
        let scale = of(&[10.0, 100.0, 200.0]);
        assert_eq!(
            (scale.position(0.0), scale.position(50.0), scale.position(200.0), scale.position(1e9)),
            (0.0, 0.25, 1.0, 1.0)
        );
        let even = of(&[150.0, 200.0]);
        assert_eq!((even.position(150.0), even.position(175.0)), (0.0, 0.5));
        // Equal everywhere: the upper end of a scale from 0.
        assert_eq!(of(&[7.0, 7.0]).position(7.0), 1.0);
        for dark in [of(&[0.0]), of(&[])] {
            assert_eq!(
                (dark.position(0.0), labels(dark, 2.0)),
                (0.0, vec!["0.0".into(), "0.5".into(), "1.0".into()])
            );
        }
    }

    #[test]
    fn a_peak_asks_for_equal_factors() {
        let mut lux = [1.0; 100];
        lux[7] = 1000.0;
        // Largest over mean is 1000 * 100 / 1099.
        let scale = of(&lux);
        assert!((scale.position(10.0) - 1.0 / 3.0).abs() < 1e-15 && scale.position(0.0) == 0.0);
        assert_eq!(labels(scale, 7.0), ["1", "10", "100", "1000"]);
        assert_eq!(labels(scale, 9.0), ["1", "2", "5", "10", "20", "50", "100", "200", "500", "1000"]);
        assert_eq!(scale.floor(), Some(1.0));
        // 10^4 below 3 * 10^7, whatever is darker.
        lux[7] = 3e7;
        assert_eq!(labels(of(&lux), 6.0), ["10000", "100000", "1e6", "1e7"]);
        lux = [0.0; 100];
        lux[7] = 3e7;
        assert_eq!(of(&lux).position(1.5e7), 0.5);
    }

    #[test]
    fn nothing_changed_is_the_middle_of_differences() {
        let scale = ColourScale::of_differences(8.0);
        assert_eq!((scale.position(-8.0), scale.position(0.0), scale.position(4.0)), (0.0, 0.5, 0.75));
        assert_eq!(ColourScale::of_differences(0.0).position(0.0), 0.5);
    }
}
