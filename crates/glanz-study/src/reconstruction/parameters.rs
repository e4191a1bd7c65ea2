//! Exponents other than those of document 003.

use glanz_radiosity::reconstruct::{Border, Interpolation};

use super::measure::{SceneResult, errors, texture};
use super::method::{FloorDivision, InterpolationMethod, SCATTERED, name};
use crate::study::{Settings, StudyError};
use glanz_report::number::significant;
use glanz_report::{Table, TableCell};

/// Interpolations measured on the elements of all scenes.
const TRIED: [Interpolation; 7] = [
    Interpolation::Shepard { exponent: 2.0 },
    SCATTERED[0],
    Interpolation::Shepard { exponent: 6.0 },
    Interpolation::Shepard { exponent: 8.0 },
    SCATTERED[1],
    Interpolation::Multiquadrics { exponent: -0.5 },
    SCATTERED[2],
];

/// Errors with other exponents.
pub(super) struct ExponentComparison {
    pub(super) table: Table,
    /// Exponent and division of Shepard's method with the mean L2 error over all scenes, and the same for natural neighbours.
    means: Vec<(Interpolation, FloorDivision, f64)>,
}

impl ExponentComparison {
    /// L2 errors with border samples.
    ///
    /// # Errors
    /// [`StudyError::Interrupted`].
    pub(super) fn measure(
        outcomes: &[SceneResult],
        size: [usize; 2],
        settings: &Settings,
    ) -> Result<Self, StudyError> {
        let mut table = Table::new(
            "parameters",
            "L2 errors with other exponents than document 003's (4 for Shepard's method, 1/2 for multiquadrics), with border samples.",
            &[
                ("division", "division"),
                ("interpolation", "interpolation"),
                ("exponent", "exponent"),
                ("scene_1", "1"),
                ("scene_2", "2"),
                ("scene_3a", "3a"),
                ("scene_3b", "3b"),
                ("scene_4a", "4a"),
                ("scene_4b", "4b"),
            ],
        );
        let mut means = Vec::new();
        for division in FloorDivision::ALL {
            for interpolation in TRIED {
                let exponent = match interpolation {
                    Interpolation::Shepard { exponent } | Interpolation::Multiquadrics { exponent } => {
                        Some(exponent)
                    }
                    _ => None,
                };
                let mut row: Vec<TableCell> =
                    vec![division.name().into(), name(interpolation).into(), exponent.into()];
                let mut sum = 0.0;
                for outcome in outcomes {
                    settings.cancel.check()?;
                    let method = InterpolationMethod { interpolation, border: Border::Sampled };
                    let l2 = l2(outcome, division, method, size)?;
                    sum += l2.unwrap_or(0.0);
                    row.push(l2.into());
                }
                means.push((interpolation, division, sum / outcomes.len().max(1) as f64));
                table.push(row);
            }
        }
        Ok(Self { table, means })
    }

    /// The finding as a sentence.
    pub(super) fn finding(&self) -> String {
        let of = |division: FloorDivision| {
            let shepard = self
                .means
                .iter()
                .filter(|(i, d, _)| *d == division && matches!(i, Interpolation::Shepard { .. }));
            let best = shepard.min_by(|a, b| a.2.total_cmp(&b.2));
            let exponent = match best {
                Some((Interpolation::Shepard { exponent }, ..)) => *exponent,
                _ => f64::NAN,
            };
            let natural = self.means.iter().find(|(i, d, _)| *d == division && *i == SCATTERED[2]);
            format!(
                "{}: exponent {exponent} with a mean L2 error of {} over the scenes, compared with {} for natural neighbours",
                division.name(),
                significant(best.map_or(f64::NAN, |b| b.2)),
                significant(natural.map_or(f64::NAN, |n| n.2))
            )
        };
        format!("The best exponents of Shepard's method are: {}.", FloorDivision::ALL.map(of).join("; "))
    }
}

fn l2(
    outcome: &SceneResult,
    division: FloorDivision,
    method: InterpolationMethod,
    size: [usize; 2],
) -> Result<Option<f64>, StudyError> {
    let Some(of) = outcome.divisions.iter().find(|of| of.division == division) else { return Ok(None) };
    // Reuses the main measurements.
    if let Some(made) = of.of(method.interpolation, method.border) {
        return Ok(Some(made.errors[1]));
    }
    let texture = texture(method, &of.divided.cells, size)?;
    let texels: Vec<f64> = texture.texels().iter().map(|texel| texel.x).collect();
    Ok(Some(errors(&texels, &outcome.reference.texels)[1]))
}
