//! Numbers as people read them, and round numbers along axes.

use std::ops::Range;

pub use glanz_job::grouped;

/// Significant digits that people see; programs get all.
const DIGITS: i32 = 4;

/// Sizes of numbers that labels write without a power of ten.
const PLAIN: Range<f64> = 1e-4..1e6;

/// `count` with the singular or the plural of a noun.
#[must_use]
pub fn plural(count: u64, one: &str, several: &str) -> String {
    format!("{} {}", grouped(count), if count == 1 { one } else { several })
}

/// A number to four significant digits; where it is very large or small, three and a power of ten.
#[must_use]
pub fn significant(number: f64) -> String {
    if number == 0.0 || !number.is_finite() {
        return number.to_string();
    }
    let exponent = number.abs().log10().floor() as i32;
    match exponent {
        -3..=6 => format!("{number:.*}", usize::try_from(DIGITS - 1 - exponent).unwrap_or(0)),
        _ => format!("{number:.2e}"),
    }
}

/// A number to four significant digits, without zeros at its end.
#[must_use]
pub fn concise(number: f64) -> String {
    let digits = (DIGITS - 1) as usize;
    exact(format!("{number:.digits$e}").parse().unwrap_or(number), PLAIN)
}

/// A length in metres for people: to a centimetre, below 0.1 m to four significant digits, below a micrometre 0.
#[must_use]
pub fn metres(length: f64) -> String {
    match length.abs() {
        0.0..1e-6 => "0.00".to_owned(),
        1e-6..0.1 => concise(length),
        _ => format!("{length:.2}"),
    }
}

/// A number that is not negative for a crowded table: whole from 10 on, two significant digits below.
#[must_use]
pub fn brief(number: f64) -> String {
    let size = number.abs();
    let digits = |number: f64| 1.0 - number.log10().floor();
    if number == 0.0 || !number.is_finite() {
        number.to_string()
    } else if (1e-3..9.95).contains(&size) {
        // What is rounded up to the next power of ten has a digit less.
        let rounded: f64 = format!("{size:.*}", digits(size) as usize).parse().unwrap_or(size);
        format!("{number:.*}", digits(rounded) as usize)
    } else if (9.95..1e6).contains(&size) {
        format!("{number:.0}")
    } else {
        format!("{number:.1e}")
    }
}

/// The shortest decimal number that reads back as the same, as a power of ten unless its size is 0 or in `plain`.
#[must_use]
pub fn exact(number: f64, plain: Range<f64>) -> String {
    let size = number.abs();
    if size == 0.0 || plain.contains(&size) { number.to_string() } else { format!("{number:e}") }
}

/// A duration in words of the largest fitting unit: `3.2 s`, `4 min 05 s`, `2 h 10 min`.
#[must_use]
pub fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..60 => format!("{seconds:.1} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

/// `digits` times ten to `power`, with its label.
pub(crate) fn decimal(digits: &str, power: i32) -> (f64, String) {
    // Parsing decimal digits gives the nearest number; multiplying by powers of ten would not.
    let value: f64 = format!("{digits}e{power}").parse().unwrap_or(0.0);
    (value, exact(value, PLAIN))
}

/// Multiples of 1, 2 or 5 times a power of ten within [`low`, `high`] with their labels: about `intervals` intervals or
/// somewhat fewer; none unless `low` lies below `high` and both are finite.
#[must_use]
pub fn ticks(low: f64, high: f64, intervals: f64) -> Vec<(f64, String)> {
    let rough = (high - low) / intervals;
    if !(rough.is_finite() && rough > 0.0) {
        return Vec::new();
    }
    let power = 10.0_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= rough).unwrap_or(rough);
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(|i| (i as f64 * step, tick_label(i as f64 * step, step))).collect()
}

/// The label of a multiple of `step`, above 0: as many digits as it takes to tell it from the next.
#[must_use]
pub fn tick_label(value: f64, step: f64) -> String {
    let place = step.log10().floor() as i32;
    let count = |digits: i32| usize::try_from(digits).unwrap_or(0);
    if value.abs() >= 1e6 || (value != 0.0 && step < 1e-4) {
        format!("{value:.*e}", count(value.abs().log10().floor() as i32 - place))
    } else if value == 0.0 && step < 1e-4 {
        "0".to_owned()
    } else {
        format!("{value:.*}", count(-place))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn lengths_of_small_things_keep_their_digits() {
        let shown = [6.0, 0.127, 0.05, -0.012_345_6, -1e-17, 2e-5].map(metres);
        assert_eq!(shown, ["6.00", "0.13", "0.05", "-0.01235", "0.00", "2e-5"]);
        assert_eq!([9.8766e-4, 1.234_56e-5].map(metres), ["0.0009877", "1.235e-5"]);
        assert_eq!([600.0, 318.31, 12_345.6, 0.0].map(concise), ["600", "318.3", "12350", "0"]);
        assert_eq!([1.234_56e7, f64::INFINITY].map(concise), ["1.235e7", "inf"]);
    }

    fn labels(low: f64, high: f64) -> Vec<String> {
        ticks(low, high, 7.0).into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round_numbers_within_the_range() {
        assert_eq!(labels(0.0, 1.0), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(-130.0, 480.0), ["-100", "0", "100", "200", "300", "400"]);
        assert_eq!(labels(1e6, 1.26e6), ["1.00e6", "1.05e6", "1.10e6", "1.15e6", "1.20e6", "1.25e6"]);
        assert_eq!(labels(0.0, 5e-6), ["0", "1e-6", "2e-6", "3e-6", "4e-6", "5e-6"]);
        for (low, high) in [(1.0, 1.0), (2.0, 1.0), (0.0, f64::INFINITY), (f64::NAN, 1.0)] {
            assert_eq!(ticks(low, high, 7.0), []);
        }
    }

    #[test]
    fn numbers_keep_four_digits_whatever_their_size() {
        for (number, shown) in
            [(0.0, "0"), (0.012_345, "0.01235"), (123_456.0, "123456"), (1.5e-7, "1.50e-7"), (3e9, "3.00e9")]
        {
            assert_eq!(significant(number), shown);
        }
    }

    #[test]
    fn crowded_numbers_are_short() {
        for (number, shown) in [
            (0.0, "0"),
            (499.6, "500"),
            (12.34, "12"),
            (9.87, "9.9"),
            (9.96, "10"),
            (0.0123, "0.012"),
            (0.996, "1.0"),
            (2e7, "2.0e7"),
        ] {
            assert_eq!(brief(number), shown);
        }
    }

    #[test]
    fn counts_and_durations_are_easy_to_read() {
        assert_eq!(
            (grouped(0), grouped(999), grouped(1_234_567)),
            ("0".into(), "999".into(), "1 234 567".into())
        );
        assert_eq!(plural(1, "root", "roots"), "1 root");
        assert_eq!(plural(3, "root", "roots"), "3 roots");
        assert_eq!(duration(3.24), "3.2 s");
        assert_eq!(duration(245.2), "4 min 05 s");
        assert_eq!(duration(7800.0), "2 h 10 min");
    }

    proptest! {
        #[test]
        fn exact_numbers_read_back_as_they_are(bits: u64) {
            let number = f64::from_bits(bits);
            let text = exact(number, 1e-5..1e16);
            let back: f64 = text.parse().unwrap();
            prop_assert!(back.to_bits() == bits || number.is_nan() && back.is_nan());
            prop_assert!(text.len() <= 25);
        }
    }
}
