//! Which number has which colour.

use super::field::Field;
use super::palette::Palette;
use super::svg::steps;
use crate::LuxMap;

/// From where on light is so uneven that equal steps would show little but its peak: largest over mean.
const UNEVEN: f64 = 30.0;

/// What a logarithmic scale shows below its upper end, as a factor; what is darker has the lowest colour.
const DEPTH: f64 = 1e-4;

/// A scale of colours over numbers in lux.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    low: f64,
    high: f64,
    logarithmic: bool,
    palette: Palette,
}

impl Scale {
    /// For the illuminances of all of `maps`: from 0, or from the least where all are alike within a factor of 2; up
    /// to the largest. Equal steps are equal differences, but equal factors where the largest is more than 30 times
    /// the mean and what is lit is not all alike; such a scale reaches down to the least, at most by a factor of 10^4.
    #[must_use]
    pub fn of(maps: &[&LuxMap]) -> Self {
        let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
        let (mut least, mut flux, mut area) = (f64::INFINITY, 0.0, 0.0);
        let fields: Vec<Field> = maps.iter().map(|map| Field::of(map)).collect();
        for (lux, cell) in fields.iter().flat_map(Field::shown) {
            (low, high) = (low.min(lux), high.max(lux));
            least = if lux > 0.0 { least.min(lux) } else { least };
            (flux, area) = (flux + lux * cell, area + cell);
        }
        let palette = Palette::Viridis;
        if high <= 0.0 {
            return Self { low: 0.0, high: 1.0, logarithmic: false, palette };
        }
        if high * area > UNEVEN * flux {
            // Where all that is lit is alike, there is nothing to tell apart by factors.
            if least < 0.5 * high {
                return Self { low: least.max(DEPTH * high), high, logarithmic: true, palette };
            }
        }
        // Differences that are only roundings are none.
        let is_even = 2.0 * low > high && high - low > 1e-6 * high;
        Self { low: if is_even { low } else { 0.0 }, high, logarithmic: false, palette }
    }

    /// For differences, from -`extent` to `extent` lx; an extent of 0 is taken as 1.
    #[must_use]
    pub fn of_differences(extent: f64) -> Self {
        let extent = if extent > 0.0 && extent.is_finite() { extent } else { 1.0 };
        Self { low: -extent, high: extent, logarithmic: false, palette: Palette::CoolWarm }
    }

    /// Where equal steps are equal factors: the number below which all has the lowest colour, lx.
    #[must_use]
    pub fn floor(&self) -> Option<f64> {
        self.logarithmic.then_some(self.low)
    }

    /// Where a number lies between the ends, which are 0 and 1.
    #[must_use]
    pub fn place(&self, lux: f64) -> f64 {
        let place = if self.logarithmic {
            (lux / self.low).ln() / (self.high / self.low).ln()
        } else {
            (lux - self.low) / (self.high - self.low)
        };
        place.clamp(0.0, 1.0)
    }

    /// The colour of a number as sRGB bytes.
    #[must_use]
    pub fn colour(&self, lux: f64) -> [u8; 3] {
        self.palette.colour(self.place(lux))
    }

    /// The colour at a place in [0, 1].
    #[must_use]
    pub fn colour_at(&self, place: f64) -> [u8; 3] {
        self.palette.colour(place)
    }

    /// Places in [0, 1] with round numbers, ascending, `about` so many.
    #[must_use]
    pub fn ticks(&self, about: f64) -> Vec<(f64, String)> {
        if !self.logarithmic {
            let ticks = steps(self.low, self.high, about);
            return ticks.into_iter().map(|(lux, label)| (self.place(lux), label)).collect();
        }
        let mut ticks = Vec::new();
        let decades = (self.high / self.low).log10();
        let digits: &[&str] = if 3.0 * decades <= about { &["1", "2", "5"] } else { &["1"] };
        for power in self.low.log10().floor() as i32..=self.high.log10().floor() as i32 {
            for digit in digits {
                let (lux, label) = round(digit, power);
                if (self.low..=self.high).contains(&lux) {
                    ticks.push((self.place(lux), label));
                }
            }
        }
        ticks
    }
}

/// `digits` times ten to `power`, and as people write it.
pub(crate) fn round(digits: &str, power: i32) -> (f64, String) {
    // Reading decimal digits gives the number next to them; multiplying by powers of ten would not.
    let value: f64 = format!("{digits}e{power}").parse().unwrap_or(0.0);
    (value, plain(value))
}

/// A number with all its digits, as a power of ten where it is very large or small.
pub(crate) fn plain(value: f64) -> String {
    if value == 0.0 || (1e-4..1e6).contains(&value.abs()) { format!("{value}") } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_math::DVec3;

    fn map(lux: &[f64]) -> LuxMap {
        LuxMap {
            name: "m".into(),
            cells: [lux.len() as u32, 1],
            size: [1.0, 1.0],
            positions: vec![DVec3::ZERO; lux.len()],
            areas: vec![1.0; lux.len()],
            lux: lux.to_vec(),
            errors: vec![0.0; lux.len()],
        }
    }

    fn labels(scale: Scale, about: f64) -> Vec<String> {
        scale.ticks(about).into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn scale_begins_at_darkness_unless_light_is_even() {
        let scale = Scale::of(&[&map(&[10.0, 100.0]), &map(&[200.0])]);
        assert_eq!(
            (scale.place(0.0), scale.place(50.0), scale.place(200.0), scale.place(1e9)),
            (0.0, 0.25, 1.0, 1.0)
        );
        let even = Scale::of(&[&map(&[150.0, 200.0])]);
        assert_eq!((even.place(150.0), even.place(175.0)), (0.0, 0.5));
        // Equal everywhere: the upper end of a scale from 0.
        assert_eq!(Scale::of(&[&map(&[7.0, 7.0])]).place(7.0), 1.0);
        for dark in [Scale::of(&[&map(&[0.0])]), Scale::of(&[])] {
            assert_eq!(
                (dark.place(0.0), labels(dark, 2.0)),
                (0.0, vec!["0.0".into(), "0.5".into(), "1.0".into()])
            );
        }
    }

    #[test]
    fn a_peak_asks_for_equal_factors() {
        let mut lux = [1.0; 100];
        lux[7] = 1000.0;
        // Largest over mean is 1000 * 100 / 1099.
        let scale = Scale::of(&[&map(&lux)]);
        assert!((scale.place(10.0) - 1.0 / 3.0).abs() < 1e-15 && scale.place(0.0) == 0.0);
        assert_eq!(labels(scale, 7.0), ["1", "10", "100", "1000"]);
        assert_eq!(labels(scale, 9.0), ["1", "2", "5", "10", "20", "50", "100", "200", "500", "1000"]);
        assert_eq!(scale.floor(), Some(1.0));
        // 10^4 below 3 * 10^7, whatever is darker.
        lux[7] = 3e7;
        assert_eq!(labels(Scale::of(&[&map(&lux)]), 6.0), ["10000", "100000", "1e6", "1e7"]);
        lux = [0.0; 100];
        lux[7] = 3e7;
        assert_eq!(Scale::of(&[&map(&lux)]).place(1.5e7), 0.5);
    }

    #[test]
    fn nothing_changed_is_the_middle_of_differences() {
        let scale = Scale::of_differences(8.0);
        assert_eq!((scale.place(-8.0), scale.place(0.0), scale.place(4.0)), (0.0, 0.5, 0.75));
        assert_eq!(Scale::of_differences(0.0).place(0.0), 0.5);
    }
}
