//! Requirements of standards, and verdicts on them.

use std::fmt;

use glanz_report::number::significant;
use glanz_report::{FactList, Table, TableCell};

use crate::report::printable;

/// A quantity that a requirement limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum LightingCriterion {
    /// Maintained mean illuminance, lx.
    MeanIlluminance,
    /// Uniformity U0: least over mean illuminance.
    Uniformity,
    /// Unified glare rating.
    GlareRating,
    /// Maintained mean cylindrical illuminance, lx.
    CylindricalIlluminance,
    /// Maintained mean luminance, cd/m^2.
    MeanLuminance,
    /// Overall uniformity of the luminance: least over mean.
    OverallUniformity,
    /// Longitudinal uniformity of the luminance: least over largest along the middle of a lane.
    LongitudinalUniformity,
    /// Threshold increment, per cent.
    ThresholdIncrement,
    /// Edge illuminance ratio.
    EdgeIlluminanceRatio,
    /// Least illuminance, lx.
    LeastIlluminance,
    /// Largest maintained mean illuminance, lx.
    LargestMeanIlluminance,
    /// Largest over least illuminance; infinite, which is null in JSON, if there is a dark point.
    MaximumToMinimum,
    /// Largest luminous intensity in a range of directions, cd.
    Intensity,
}

impl LightingCriterion {
    /// Symbol in reports.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::MeanIlluminance => "Em",
            Self::Uniformity => "U0",
            Self::GlareRating => "UGR",
            Self::CylindricalIlluminance => "Ez",
            Self::MeanLuminance => "L",
            Self::OverallUniformity => "Uo",
            Self::LongitudinalUniformity => "Ul",
            Self::ThresholdIncrement => "fTI",
            Self::EdgeIlluminanceRatio => "REI",
            Self::LeastIlluminance => "Emin",
            Self::LargestMeanIlluminance => "Em, at most",
            Self::MaximumToMinimum => "Emax / Emin",
            Self::Intensity => "Imax",
        }
    }

    /// Unit; empty for ratios.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::MeanIlluminance
            | Self::LargestMeanIlluminance
            | Self::CylindricalIlluminance
            | Self::LeastIlluminance => "lx",
            Self::MeanLuminance => "cd/m2",
            Self::ThresholdIncrement => "%",
            Self::Intensity => "cd",
            _ => "",
        }
    }

    /// Whether the limit is the largest allowed value; otherwise the smallest.
    #[must_use]
    pub fn is_upper_limit(self) -> bool {
        matches!(
            self,
            Self::GlareRating
                | Self::ThresholdIncrement
                | Self::LargestMeanIlluminance
                | Self::MaximumToMinimum
                | Self::Intensity
        )
    }
}

/// A limit of a standard.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Requirement {
    /// The quantity.
    pub criterion: LightingCriterion,
    /// The limit, in the unit of the criterion.
    pub limit: f64,
    /// Standard and clause, or the row of its table.
    pub source: String,
}

/// Outcome of the comparison of a value with a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum VerdictOutcome {
    /// The whole interval of the value is on the allowed side of the limit.
    Met,
    /// None of it is.
    NotMet,
    /// The limit lies within the interval.
    Undecided,
}

impl fmt::Display for VerdictOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Met => "met",
            Self::NotMet => "not met",
            Self::Undecided => "undecided",
        })
    }
}

/// The verdict on a requirement.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct RequirementVerdict {
    /// What is lit: a zone, a wall, the road.
    pub zone: String,
    /// The requirement.
    #[serde(flatten)]
    pub requirement: Requirement,
    /// The value, in the unit of the criterion; minus infinity for UGR without glare, which is null in JSON.
    pub value: f64,
    /// Interval of the value; both ends are the value where it has no error.
    pub interval: [f64; 2],
    /// The outcome.
    pub outcome: VerdictOutcome,
}

impl RequirementVerdict {
    /// Compares a value, with its interval, with the limit. A value or interval that is no number is undecided.
    #[must_use]
    pub fn new(zone: impl Into<String>, requirement: Requirement, value: f64, interval: [f64; 2]) -> Self {
        let sign = if requirement.criterion.is_upper_limit() { -1.0 } else { 1.0 };
        let [a, b] = interval.map(|end| sign * (end - requirement.limit));
        let outcome = if value.is_nan() {
            VerdictOutcome::Undecided
        } else if a >= 0.0 && b >= 0.0 {
            VerdictOutcome::Met
        } else if a < 0.0 && b < 0.0 {
            VerdictOutcome::NotMet
        } else {
            VerdictOutcome::Undecided
        };
        Self { zone: zone.into(), requirement, value, interval, outcome }
    }
}

/// Verdicts as a table.
#[must_use]
pub fn verdict_table(verdicts: &[RequirementVerdict]) -> Table {
    let columns = [
        ("zone", "zone"),
        ("criterion", "quantity"),
        ("value", "value"),
        ("interval", "within"),
        ("limit", "limit"),
        ("outcome", "verdict"),
        ("source", "requirement"),
    ];
    let mut table = Table::new("verdicts", "Requirements", &columns);
    for verdict in verdicts {
        let requirement = &verdict.requirement;
        let (symbol, unit) = (requirement.criterion.symbol(), requirement.criterion.unit());
        let name = if unit.is_empty() { symbol.to_owned() } else { format!("{symbol}, {unit}") };
        let sign = if requirement.criterion.is_upper_limit() { "<=" } else { ">=" };
        let [low, high] = verdict.interval.map(significant);
        let (value, interval) = match verdict.value {
            value if value.is_nan() => (TableCell::Missing, TableCell::Missing),
            f64::NEG_INFINITY => (TableCell::from("no glare"), TableCell::Missing),
            // Without an error there is no interval.
            value if verdict.interval == [value; 2] => {
                (TableCell::Text(significant(value)), TableCell::Missing)
            }
            value => (TableCell::Text(significant(value)), TableCell::Text(format!("{low} to {high}"))),
        };
        table.push([
            TableCell::Text(printable(&verdict.zone)),
            TableCell::Text(name),
            value,
            interval,
            TableCell::Text(format!("{sign} {}", shown_limit(requirement.limit))),
            TableCell::Text(verdict.outcome.to_string()),
            TableCell::Text(requirement.source.clone()),
        ]);
    }
    table
}

/// A limit as standards write it, unless that is a fraction without end.
fn shown_limit(limit: f64) -> String {
    let exact = limit.to_string();
    if exact.len() <= 6 { exact } else { significant(limit) }
}

/// Figures of an installation as a table.
pub(super) fn installation_table(facts: &FactList) -> Table {
    facts.table("installation", "Installation", "installation", |_| true)
}

/// A task of EN 12464-1 with its requirements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightingTask {
    /// Row of the tables of the standard.
    pub reference: &'static str,
    /// The task.
    pub name: &'static str,
    /// Required maintained mean illuminance of the task area, lx.
    pub illuminance: f64,
    /// Least uniformity U0 of the task area.
    pub uniformity: f64,
    /// Largest UGR.
    pub glare_rating: f64,
    /// Least general colour rendering index Ra, which a photometric file does not prove.
    pub color_rendering: f64,
    /// Required maintained mean cylindrical illuminance, lx.
    pub cylindrical: f64,
    /// Required maintained mean illuminance of walls, lx.
    pub walls: f64,
    /// Required maintained mean illuminance of the ceiling, lx.
    pub ceiling: f64,
}

/// Tasks of offices, EN 12464-1:2021 table 34.
///
/// # Source
/// @en12464, which was not available; the values are those of open summaries by makers of luminaires, and only rows on which they agree are here.
pub const OFFICE_TASKS: [LightingTask; 5] = [
    task("34.1", "filing, copying", [300.0, 0.40, 19.0], [100.0, 100.0, 75.0]),
    task("34.2", "writing, typing, reading, data processing", [500.0, 0.60, 19.0], [150.0, 150.0, 100.0]),
    task("34.3", "technical drawing", [750.0, 0.70, 16.0], [150.0, 150.0, 100.0]),
    task("34.4", "CAD work stations", [500.0, 0.60, 19.0], [150.0, 150.0, 100.0]),
    task("34.5.1", "conference and meeting rooms", [500.0, 0.60, 19.0], [150.0, 150.0, 100.0]),
];

const fn task(
    reference: &'static str,
    name: &'static str,
    [illuminance, uniformity, glare_rating]: [f64; 3],
    [cylindrical, walls, ceiling]: [f64; 3],
) -> LightingTask {
    let color_rendering = 80.0;
    LightingTask {
        reference,
        name,
        illuminance,
        uniformity,
        glare_rating,
        color_rendering,
        cylindrical,
        walls,
        ceiling,
    }
}

/// Least uniformity U0 of walls, ceiling and of cylindrical illuminance in EN 12464-1.
pub const ROOM_UNIFORMITY: f64 = 0.10;

impl LightingTask {
    /// The task with a reference of [`OFFICE_TASKS`].
    #[must_use]
    pub fn of_reference(reference: &str) -> Option<Self> {
        OFFICE_TASKS.into_iter().find(|task| task.reference == reference)
    }

    /// A requirement of the task.
    #[must_use]
    pub fn requirement(&self, criterion: LightingCriterion, limit: f64) -> Requirement {
        Requirement { criterion, limit, source: self.clause() }
    }

    /// Standard and reference.
    fn clause(&self) -> String {
        format!("EN 12464-1:2021, {}", self.reference)
    }

    /// Standard, reference and name.
    #[must_use]
    pub fn label(&self) -> String {
        format!("{}: {}", self.clause(), self.name)
    }
}

/// Required mean illuminance of the immediate surrounding area, lx, for that of the task area.
///
/// # Source
/// @en12464, the table of the clause on illuminance of surrounding areas, by open summaries: 500 for 750 and more, 300 for 500, 200 for 300, 150 for 200, and that of
/// the task area below.
#[must_use]
pub fn surrounding_illuminance(task: f64) -> f64 {
    let steps = [(750.0, 500.0), (500.0, 300.0), (300.0, 200.0), (200.0, 150.0)];
    steps.into_iter().find(|(of_task, _)| task >= *of_task).map_or(task, |(_, surrounding)| surrounding)
}

/// Largest distance of the points of a grid, metres, on an area with these sides, metres: p = 0.2 * 5^lg d, at most 10 m, where d is the longer side, or the shorter one
/// if the longer is at least twice as long.
///
/// # Source
/// EN 12464-1, clause on illuminance grids (@en12464), by open summaries.
#[must_use]
pub fn grid_spacing([a, b]: [f64; 2]) -> f64 {
    let (shorter, longer) = (a.min(b), a.max(b));
    // Twice but for rounding is twice.
    let length = if longer >= (2.0 - 1e-9) * shorter { shorter } else { longer };
    (0.2 * 5.0_f64.powf(length.log10())).min(10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn requirement(criterion: LightingCriterion, limit: f64) -> Requirement {
        Requirement { criterion, limit, source: "test".to_owned() }
    }

    #[test]
    fn verdict_is_undecided_while_the_limit_is_within_the_interval() {
        use LightingCriterion::{GlareRating, MeanIlluminance};
        for (criterion, limit, interval, outcome) in [
            (MeanIlluminance, 500.0, [500.0, 510.0], VerdictOutcome::Met),
            (MeanIlluminance, 500.0, [499.0, 510.0], VerdictOutcome::Undecided),
            (MeanIlluminance, 500.0, [480.0, 499.9], VerdictOutcome::NotMet),
            (GlareRating, 19.0, [18.0, 19.0], VerdictOutcome::Met),
            (GlareRating, 19.0, [18.9, 19.1], VerdictOutcome::Undecided),
            (GlareRating, 19.0, [19.1, 19.2], VerdictOutcome::NotMet),
            (GlareRating, 19.0, [f64::NEG_INFINITY; 2], VerdictOutcome::Met),
            (MeanIlluminance, 500.0, [f64::NAN; 2], VerdictOutcome::Undecided),
        ] {
            let value = 0.5 * (interval[0] + interval[1]);
            let verdict = RequirementVerdict::new("desk", requirement(criterion, limit), value, interval);
            assert_eq!(verdict.outcome, outcome, "{verdict:?}");
        }
    }

    #[test]
    fn names_of_files_cannot_control_the_terminal() {
        let limit = requirement(LightingCriterion::Intensity, 500.0);
        let verdict = RequirementVerdict::new("\u{1b}[2Jlamp", limit, 400.0, [400.0; 2]);
        let mut facts = FactList::default();
        facts.push("luminaire", "luminaire", "\u{1b}[2Jlamp");
        let text = verdict_table(&[verdict]).plain() + &installation_table(&facts).plain();
        assert!(!text.contains('\u{1b}') && text.contains("Imax, cd") && text.contains("met"), "{text}");
    }

    #[test]
    fn tasks_are_found_by_their_reference() {
        let task = LightingTask::of_reference("34.2").unwrap();
        assert_eq!((task.illuminance, task.uniformity, task.glare_rating), (500.0, 0.6, 19.0));
        assert_eq!((task.cylindrical, task.walls, task.ceiling), (150.0, 150.0, 100.0));
        assert_eq!(LightingTask::of_reference("34"), None);
    }

    #[test]
    fn surroundings_and_grids_follow_the_clauses() {
        let surrounding = [1000.0, 750.0, 500.0, 300.0, 200.0, 100.0].map(surrounding_illuminance);
        assert_eq!(surrounding, [500.0, 500.0, 300.0, 200.0, 150.0, 100.0]);
        // By the formula, with d = 1, 10, 100 m and beyond the largest distance; a corridor counts by its width.
        for (sides, spacing) in [
            ([1.0, 1.0], 0.2),
            ([10.0, 5.1], 1.0),
            ([60.0, 100.0], 5.0),
            ([1e4, 1e4], 10.0),
            ([19.0, 1.0], 0.2),
            ([10.0, 20.0], 1.0),
        ] {
            assert!((grid_spacing(sides) - spacing).abs() < 1e-12, "{sides:?}");
        }
    }
}
