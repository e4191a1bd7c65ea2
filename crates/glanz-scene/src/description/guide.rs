//! Settings of path guiding.

use std::fmt;
use std::str::FromStr;

use super::pass_lengths::{PassLengths, PassLengthsError};

/// Basis functions of the densities of directions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum GuideBasis {
    /// Haar's orthonormal boxes.
    #[default]
    Haar,
    /// B-splines of this degree, 0 to [`GuideBasis::HIGHEST_DEGREE`].
    Spline(u32),
}

impl GuideBasis {
    /// Highest degree of splines.
    pub const HIGHEST_DEGREE: u32 = 3;
}

impl fmt::Display for GuideBasis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Haar => f.write_str("haar"),
            Self::Spline(degree) => write!(f, "spline{degree}"),
        }
    }
}

/// The guide of document 003: a grid of cells on each surface, each with a density on one scale.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct GridSettings {
    /// Cells along each of the two parameters of a surface, 1 to [`GridSettings::MOST_CELLS`].
    pub cells: u32,
    /// Basis functions of a density.
    pub basis: GuideBasis,
    /// Finest scale, 0 to [`GridSettings::FINEST_SCALE`]: 2^scale segments along each axis of the hemisphere.
    pub scale: u32,
    /// Whether density and BSDF sample half of the diffuse directions each; otherwise the density samples all.
    pub mixture: bool,
    /// Whether densities start on scale 0 and become finer from pass to pass; otherwise they start on the finest.
    pub hierarchical: bool,
    /// Training passes; `None`: an unlimited number, each with twice as many samples as the one before.
    pub passes: Option<PassLengths>,
}

impl GridSettings {
    /// Largest number of cells along a parameter.
    pub const MOST_CELLS: u32 = 64;
    /// Finest scale.
    pub const FINEST_SCALE: u32 = 6;
}

impl Default for GridSettings {
    /// The best settings of document 003: 8 x 8 cells, Haar's basis, scale 3, the density alone, on one scale; an unlimited number of passes.
    fn default() -> Self {
        Self {
            cells: 8,
            basis: GuideBasis::Haar,
            scale: 3,
            mixture: false,
            hierarchical: false,
            passes: None,
        }
    }
}

/// A guide with its settings.
///
/// As text: `tree`, or the keys of a grid with their values, such as
/// `grid=8,basis=haar,scale=3,mixture=off,hierarchical=off,passes=1-2-4`; keys that are left out have the values of
/// [`GridSettings::default`], but `grid` is required.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum GuideSettings {
    /// Adaptive cells and directions, with a fitted mixture weight beside the BSDF.
    #[default]
    Tree,
    /// A fixed grid.
    Grid(GridSettings),
}

/// An error in the text of guide settings.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GuideSettingsError {
    /// Neither `tree` nor a list of keys.
    #[error("\"{0}\" is not a guide; use \"tree\", or keys with values such as grid=8,basis=haar,scale=3")]
    Form(String),
    /// An unknown key.
    #[error("the key \"{0}\" of a guide is unknown; use grid, basis, scale, mixture, hierarchical or passes")]
    Key(String),
    /// A duplicate key.
    #[error("the key \"{0}\" is given twice; keep one")]
    Twice(String),
    /// A value that is not allowed.
    #[error("{key} is \"{value}\"; it must be {allowed}")]
    Value {
        /// The key.
        key: &'static str,
        /// The given value.
        value: String,
        /// The allowed values.
        allowed: String,
    },
    /// Keys without `grid`.
    #[error("grid=N is missing; add the number of cells along each parameter of a surface, 1 to {most}", most = GridSettings::MOST_CELLS)]
    NoGrid,
}

impl FromStr for GuideSettings {
    type Err = GuideSettingsError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if text == "tree" {
            return Ok(Self::Tree);
        }
        let mut settings = GridSettings::default();
        let mut seen = Vec::new();
        for item in text.split(',') {
            let form = || GuideSettingsError::Form(text.to_owned());
            let (key, value) = item.split_once('=').ok_or_else(form)?;
            if seen.contains(&key) {
                return Err(GuideSettingsError::Twice(key.to_owned()));
            }
            seen.push(key);
            match key {
                "grid" => settings.cells = parse_number("grid", value, 1, GridSettings::MOST_CELLS)?,
                "basis" => settings.basis = parse_basis(value)?,
                "scale" => settings.scale = parse_number("scale", value, 0, GridSettings::FINEST_SCALE)?,
                "mixture" => settings.mixture = parse_switch("mixture", value)?,
                "hierarchical" => settings.hierarchical = parse_switch("hierarchical", value)?,
                "passes" => settings.passes = Some(parse_passes(value)?),
                _ => return Err(GuideSettingsError::Key(key.to_owned())),
            }
        }
        if seen.contains(&"grid") { Ok(Self::Grid(settings)) } else { Err(GuideSettingsError::NoGrid) }
    }
}

fn value_error(key: &'static str, value: &str, allowed: String) -> GuideSettingsError {
    GuideSettingsError::Value { key, value: value.to_owned(), allowed }
}

fn parse_number(key: &'static str, value: &str, least: u32, most: u32) -> Result<u32, GuideSettingsError> {
    let number = value.parse().ok().filter(|n| (least..=most).contains(n));
    number.ok_or_else(|| value_error(key, value, format!("a whole number from {least} to {most}")))
}

fn parse_switch(key: &'static str, value: &str) -> Result<bool, GuideSettingsError> {
    match value {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err(value_error(key, value, "on or off".to_owned())),
    }
}

fn parse_passes(value: &str) -> Result<PassLengths, GuideSettingsError> {
    value.parse().map_err(|error: PassLengthsError| value_error("passes", value, error.to_string()))
}

fn parse_basis(value: &str) -> Result<GuideBasis, GuideSettingsError> {
    let splines = (0..=GuideBasis::HIGHEST_DEGREE).map(GuideBasis::Spline);
    let all: Vec<GuideBasis> = [GuideBasis::Haar].into_iter().chain(splines).collect();
    all.iter().find(|basis| basis.to_string() == value).copied().ok_or_else(|| {
        let names: Vec<String> = all.iter().map(GuideBasis::to_string).collect();
        value_error("basis", value, format!("one of {}", names.join(", ")))
    })
}

impl fmt::Display for GridSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let switch = |on| if on { "on" } else { "off" };
        let Self { cells, basis, scale, mixture, hierarchical, passes } = *self;
        write!(f, "grid={cells},basis={basis},scale={scale}")?;
        write!(f, ",mixture={},hierarchical={}", switch(mixture), switch(hierarchical))?;
        passes.map_or(Ok(()), |passes| write!(f, ",passes={passes}"))
    }
}

impl fmt::Display for GuideSettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tree => f.write_str("tree"),
            Self::Grid(grid) => grid.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_of_settings_is_read_back() {
        for basis in [GuideBasis::Haar, GuideBasis::Spline(0), GuideBasis::Spline(3)] {
            for (mixture, hierarchical, passes) in
                [(true, false, None), (false, true, PassLengths::new(&[1, 2]))]
            {
                let grid = GridSettings { cells: 64, basis, scale: 0, mixture, hierarchical, passes };
                let settings = GuideSettings::Grid(grid);
                assert_eq!(settings.to_string().parse(), Ok(settings));
            }
        }
        assert_eq!("tree".parse(), Ok(GuideSettings::Tree));
        assert_eq!(GuideSettings::Tree.to_string(), "tree");
    }

    #[test]
    fn keys_come_in_any_order_and_may_be_left_out() {
        let written: GuideSettings = "mixture=on,basis=spline2,grid=4".parse().unwrap();
        let expected =
            GridSettings { cells: 4, basis: GuideBasis::Spline(2), mixture: true, ..GridSettings::default() };
        assert_eq!(written, GuideSettings::Grid(expected));
        assert_eq!(written.to_string(), "grid=4,basis=spline2,scale=3,mixture=on,hierarchical=off");
    }

    #[test]
    fn errors_name_the_allowed_values() {
        for (text, told) in [
            ("", "\"tree\""),
            ("forest", "\"tree\""),
            ("grid", "grid=8"),
            ("grid=8,,", "grid=8"),
            ("grid=0", "from 1 to 64"),
            ("grid=65", "from 1 to 64"),
            ("grid=-1", "from 1 to 64"),
            ("grid=8,basis=linear", "haar, spline0, spline1, spline2, spline3"),
            ("grid=8,basis=spline4", "haar, spline0"),
            ("grid=8,scale=7", "from 0 to 6"),
            ("grid=8,scale=1.5", "from 0 to 6"),
            ("grid=8,mixture=yes", "on or off"),
            ("grid=8,hierarchical=", "on or off"),
            ("grid=8,passes=1-0", "1-2-4"),
            ("grid=8,depth=2", "hierarchical"),
            ("grid=8,grid=8", "twice"),
            ("scale=2", "grid=N"),
        ] {
            let error = text.parse::<GuideSettings>().unwrap_err().to_string();
            assert!(error.contains(told), "{text}: {error}");
        }
    }
}
