//! Lighting classes of roads.

use std::str::FromStr;

use crate::planning::requirement::{LightingCriterion, Requirement};

/// A lighting class of EN 13201-2:2015.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RoadClass {
    /// M1 to M6, for motor traffic: luminance.
    M(u8),
    /// C0 to C5, for conflict areas: mean illuminance and uniformity.
    C(u8),
    /// P1 to P6, for pedestrians: mean and least illuminance, and the largest mean.
    P(u8),
}

impl FromStr for RoadClass {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = text.get(1..).and_then(|number| number.parse::<u8>().ok());
        match (text.get(..1), number) {
            (Some("M" | "m"), Some(n @ 1..=6)) => Ok(Self::M(n)),
            (Some("C" | "c"), Some(n @ 0..=5)) => Ok(Self::C(n)),
            (Some("P" | "p"), Some(n @ 1..=6)) => Ok(Self::P(n)),
            _ => Err("it must be a class of EN 13201-2: M1 to M6, C0 to C5 or P1 to P6".to_owned()),
        }
    }
}

impl std::fmt::Display for RoadClass {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::M(n) => write!(f, "M{n}"),
            Self::C(n) => write!(f, "C{n}"),
            Self::P(n) => write!(f, "P{n}"),
        }
    }
}

impl RoadClass {
    /// Limits of the class on a dry road.
    ///
    /// # Source
    /// EN 13201-2:2015, tables 1 to 3 (@en13201), which were not available; the values are those of open summaries.
    #[must_use]
    pub fn requirements(self) -> Vec<Requirement> {
        use LightingCriterion::{
            EdgeIlluminanceRatio, LargestMeanIlluminance, LeastIlluminance, LongitudinalUniformity,
            MeanIlluminance, MeanLuminance, OverallUniformity, ThresholdIncrement, Uniformity,
        };
        let limits: Vec<(LightingCriterion, f64)> = match self {
            Self::M(n) => {
                let [luminance, overall, longitudinal, increment, edge] = match n {
                    1 => [2.0, 0.40, 0.70, 10.0, 0.35],
                    2 => [1.5, 0.40, 0.70, 10.0, 0.35],
                    3 => [1.0, 0.40, 0.60, 15.0, 0.30],
                    4 => [0.75, 0.40, 0.60, 15.0, 0.30],
                    5 => [0.50, 0.35, 0.40, 15.0, 0.30],
                    _ => [0.30, 0.35, 0.40, 20.0, 0.30],
                };
                vec![
                    (MeanLuminance, luminance),
                    (OverallUniformity, overall),
                    (LongitudinalUniformity, longitudinal),
                    (ThresholdIncrement, increment),
                    (EdgeIlluminanceRatio, edge),
                ]
            }
            Self::C(n) => {
                let lux = [50.0, 30.0, 20.0, 15.0, 10.0, 7.5].get(usize::from(n)).copied().unwrap_or(7.5);
                vec![(MeanIlluminance, lux), (Uniformity, 0.40)]
            }
            Self::P(n) => {
                let lux = [15.0, 10.0, 7.5, 5.0, 3.0, 2.0];
                let mean = lux.get(usize::from(n).saturating_sub(1)).copied().unwrap_or(2.0);
                // A fifth of the mean in all classes. The note of the table: for uniformity, the mean is at most 1.5 times that of the class.
                vec![
                    (MeanIlluminance, mean),
                    (LeastIlluminance, 0.2 * mean),
                    (LargestMeanIlluminance, 1.5 * mean),
                ]
            }
        };
        let source = format!("EN 13201-2:2015, {self}");
        limits
            .into_iter()
            .map(|(criterion, limit)| Requirement { criterion, limit, source: source.clone() })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_have_their_limits() {
        let limits = |class: &str| -> Vec<f64> {
            let class: RoadClass = class.parse().unwrap();
            class.requirements().iter().map(|requirement| requirement.limit).collect()
        };
        assert_eq!(limits("M3"), [1.0, 0.4, 0.6, 15.0, 0.3]);
        assert_eq!(limits("m6"), [0.3, 0.35, 0.4, 20.0, 0.3]);
        assert_eq!(limits("C0"), [50.0, 0.4]);
        assert_eq!(limits("C5"), [7.5, 0.4]);
        assert_eq!(limits("P1"), [15.0, 3.0, 22.5]);
        assert_eq!(limits("P6"), [2.0, 0.4, 3.0]);
        for text in ["M0", "M7", "C6", "P0", "X1", "", "M", "M3.5", "µ1"] {
            assert!(text.parse::<RoadClass>().is_err(), "{text}");
        }
        assert_eq!(RoadClass::C(2).requirements()[0].source, "EN 13201-2:2015, C2");
    }
}
