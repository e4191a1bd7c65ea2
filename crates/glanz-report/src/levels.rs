//! Round levels for contours.

use crate::number::decimal;

/// Number of levels that is aimed at; the result may have half as many, or half as many again.
const WANTED: usize = 8;

/// Largest number of levels at equal factors.
const MOST: usize = 10;

/// Ratio of the largest value to the least from which on levels have equal factors between them.
const WIDE: f64 = 10.0;

/// Least level, as a factor of the largest value.
const DEPTH: f64 = 1e-3;

/// The scale of illuminances of EN 12464-1 (@en12464): each about 1.5 times the one before, the least difference that is
/// noticeable.
const STANDARD: &[&str] = &["1", "1.5", "2", "3", "5", "7.5"];

/// Round numbers between `low` and `high`, with their labels, ascending: steps of 1, 2, 2.5 or 5 times a power of ten
/// where the largest is less than 10 times the least, else illuminances of EN 12464-1 or every second or so of them.
///
/// None if `low` and `high` are equal to within rounding.
#[must_use]
pub fn levels(low: f64, high: f64) -> Vec<(f64, String)> {
    // Differences of a few roundings are none.
    if !(high > 0.0 && high.is_finite() && high - low > 1e-9 * high) {
        return Vec::new();
    }
    if high < WIDE * low {
        return evenly(low, high);
    }
    let from = low.max(DEPTH * high);
    let powers = from.log10().floor() as i32..=high.log10().floor() as i32;
    let of = |digits: &[&str]| -> Vec<(f64, String)> {
        let all = powers.clone().flat_map(|power| digits.iter().map(move |d| decimal(d, power)));
        all.filter(|(level, _)| *level > from && *level < high).collect()
    };
    let sets = [STANDARD, &["1", "2", "5"], &["1", "3"]];
    sets.into_iter().map(of).find(|levels| levels.len() <= MOST).unwrap_or_else(|| of(&["1"]))
}

/// Multiples of the round step whose number is nearest to [`WANTED`].
fn evenly(low: f64, high: f64) -> Vec<(f64, String)> {
    let power = ((high - low) / WANTED as f64).log10().floor() as i32;
    let steps = [("1", power), ("2", power), ("2.5", power), ("5", power), ("1", power + 1)];
    let multiples = |(digits, power): (&str, i32)| -> Vec<(f64, String)> {
        let (step, _) = decimal(digits, power);
        let (first, last) = ((low / step).floor() as i64, (high / step).ceil() as i64);
        // Whole multiples of tenths of the power, so that decimals stay exact.
        let tenths = |i: i64| (i as f64 * digits.parse::<f64>().unwrap_or(1.0) * 10.0).round();
        let all = (first..=last).map(|i| decimal(&tenths(i).to_string(), power - 1));
        all.filter(|(level, _)| *level > low && *level < high).collect()
    };
    let all = steps.into_iter().map(multiples);
    all.min_by_key(|levels| levels.len().abs_diff(WANTED)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64) -> Vec<String> {
        levels(low, high).into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn levels_are_those_people_know() {
        assert_eq!(labels(0.4, 16.0), ["0.5", "0.75", "1", "1.5", "2", "3", "5", "7.5", "10", "15"]);
        assert_eq!(labels(0.0, 1100.0), ["2", "5", "10", "20", "50", "100", "200", "500", "1000"]);
        assert_eq!(labels(480.0, 2000.0), ["600", "800", "1000", "1200", "1400", "1600", "1800"]);
        assert_eq!(labels(480.0, 520.0), ["485", "490", "495", "500", "505", "510", "515"]);
        assert_eq!(labels(0.00011, 0.0008), ["0.0002", "0.0003", "0.0004", "0.0005", "0.0006", "0.0007"]);
        assert_eq!(
            labels(3e6, 4e6),
            ["3.1e6", "3.2e6", "3.3e6", "3.4e6", "3.5e6", "3.6e6", "3.7e6", "3.8e6", "3.9e6"]
        );
    }

    #[test]
    fn there_are_five_to_twelve_levels_within_every_range() {
        for i in 0..400 {
            let high = 10.0_f64.powf(-4.0 + 0.025 * f64::from(i));
            for ratio in [0.0, 0.001, 0.01, 0.03, 0.099, 0.11, 0.3, 0.7, 0.95, 0.999] {
                let levels = levels(ratio * high, high);
                assert!((5..=12).contains(&levels.len()), "{ratio} {high}: {levels:?}");
                assert!(levels.iter().all(|(level, _)| *level > ratio * high && *level < high));
                assert!(levels.windows(2).all(|pair| pair[0].0 < pair[1].0));
            }
        }
    }

    #[test]
    fn where_all_is_alike_there_is_no_level() {
        for (low, high) in [(0.0, 0.0), (5.0, 5.0), (f64::NAN, 1.0), (0.0, f64::INFINITY), (7.0, 1.0)] {
            assert_eq!(levels(low, high), []);
        }
    }
}
