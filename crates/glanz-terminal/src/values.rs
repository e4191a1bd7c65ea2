//! Parsers of the values of options.

use std::ops::Range;
use std::time::Duration;

use clap::builder::PossibleValuesParser;

/// Parser of names, which help and completions list.
pub fn one_of(names: impl Iterator<Item = &'static str>) -> PossibleValuesParser {
    PossibleValuesParser::new(names)
}

/// On or off.
pub fn switch(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("it must be on or off".to_owned()),
    }
}

/// A time above 0.
pub fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "it must be a number of seconds".to_owned())?;
    if seconds <= 0.0 {
        return Err("it must be above 0".to_owned());
    }
    Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string())
}

/// Width and height in pixels.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let form = || "it must be width and height in pixels, such as 640x480".to_owned();
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(form)?;
    let side = |text: &str| text.parse::<u32>().ok().filter(|&n| n > 0).ok_or_else(form);
    Ok([side(width)?, side(height)?])
}

/// Samples from one number to another.
pub fn sample_range(text: &str) -> Result<Range<u32>, String> {
    let form = || "it must be two numbers, such as 0..32".to_owned();
    let (start, end) = text.split_once("..").ok_or_else(form)?;
    let number = |text: &str| text.parse::<u32>().map_err(|_| form());
    let range = number(start)?..number(end)?;
    if range.is_empty() {
        return Err("the second number must be larger than the first".to_owned());
    }
    Ok(range)
}

/// An exposure.
pub fn stops(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|x: &f32| x.is_finite()).ok_or_else(|| "it must be a number".to_owned())
}

/// A number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|x: &f64| *x > 0.0 && x.is_finite())
        .ok_or_else(|| "it must be a number above 0".to_owned())
}

/// A number of 0 or more.
pub fn bound(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| *x >= 0.0).ok_or_else(|| "it must be a number of 0 or more".to_owned())
}
