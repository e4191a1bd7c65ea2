//! Plots of interpolated steps, and of shadows along a line.

use glanz_math::{DVec2, DVec3};
use glanz_radiosity::reconstruct::{Border, Interpolant, Interpolation, ParameterCells};

use super::measure::SceneResult;
use super::method::{FloorDivision, InterpolationMethod, SCATTERED, name};
use crate::report::Figure;
use crate::study::StudyError;
use glanz_report::{Axis, Plot, ReferenceLine, Series, Table};

/// Cells along a side of the step, as in document 003.
const SIDE: usize = 8;

/// Points of a curve.
const POINTS: u32 = 400;

/// Lines of constant v: through the middles of a row of elements, and between two rows.
const LINES: [(f64, &str); 2] = [(7.0 / 16.0, "through middles"), (0.5, "between rows")];

/// 0 where u < 1/2, 1 elsewhere, in 8 x 8 cells.
fn step() -> Result<ParameterCells, StudyError> {
    let values: Vec<DVec3> =
        (0..SIDE * SIDE).map(|i| if i % SIDE < SIDE / 2 { DVec3::ZERO } else { DVec3::ONE }).collect();
    Ok(ParameterCells::grid([SIDE; 2], &values)?)
}

/// The step itself, with a jump between two cells.
fn stairs() -> Series {
    Series { name: "step".to_owned(), points: vec![[0.0, 0.0], [0.5, 0.0], [0.5, 1.0], [1.0, 1.0]] }
}

fn curve(name: impl Into<String>, f: &dyn Interpolant, v: f64) -> Series {
    let at = |i: u32| f64::from(i) / f64::from(POINTS);
    let points = (0..=POINTS).map(|i| [at(i), f.value(DVec2::new(at(i), v)).x]).collect();
    Series { name: name.into(), points }
}

/// Figures 4.4, 4.5, 4.7, 4.8 and 4.10, and the overshoot of each interpolation.
///
/// # Errors
/// [`StudyError::Reconstruct`].
pub(super) fn steps() -> Result<(Vec<Figure>, Table), StudyError> {
    let cells = step()?;
    let mut table = Table::new(
        "steps",
        "The step over 8 x 8 elements: overshoot of an interpolation above 1 or below 0, and width of its rise from 0.1 to \
         0.9 in elements, along a line through the middles of elements and along one between two rows.",
        &[
            ("interpolation", "interpolation"),
            ("exponent", "exponent"),
            ("overshoot_middles", "overshoot, through middles"),
            ("overshoot_between", "overshoot, between rows"),
            ("rise_middles", "rise, through middles"),
            ("rise_between", "rise, between rows"),
        ],
    );
    let shepard = |exponent| Interpolation::Shepard { exponent };
    let sheets: [(&str, &str, &[Interpolation]); 5] = [
        ("bilinear", "4.4", &[Interpolation::Bilinear]),
        ("spline", "4.5", &[Interpolation::Spline]),
        ("shepard", "4.7", &[shepard(1.0), shepard(2.0), shepard(4.0)]),
        ("multiquadrics", "4.8", &[Interpolation::Multiquadrics { exponent: 0.5 }]),
        ("natural", "4.10", &[Interpolation::NaturalNeighbour]),
    ];
    let mut figures = Vec::new();
    for (key, number, interpolations) in sheets {
        let mut series = vec![stairs()];
        for &interpolation in interpolations {
            let f = interpolation.of_cells(&cells, Border::Open)?;
            let exponent = match interpolation {
                Interpolation::Shepard { exponent } | Interpolation::Multiquadrics { exponent } => {
                    Some(exponent)
                }
                _ => None,
            };
            let curves = LINES.map(|(v, line)| {
                let label = match interpolation {
                    Interpolation::Shepard { exponent } => format!("exponent {exponent}, {line}"),
                    _ => line.to_owned(),
                };
                curve(label, f.as_ref(), v)
            });
            let over = curves
                .each_ref()
                .map(|c| c.points.iter().fold(0.0, |most: f64, p| most.max(p[1] - 1.0).max(-p[1])));
            let rises = curves.each_ref().map(rise);
            table.push([
                name(interpolation).into(),
                exponent.into(),
                over[0].into(),
                over[1].into(),
                rises[0].into(),
                rises[1].into(),
            ]);
            // The document shows Shepard's method along one line.
            let lines = if interpolations.len() > 1 { 1 } else { 2 };
            series.extend(curves.into_iter().take(lines));
        }
        let plot = Plot {
            title: format!("A step, {}", interpolations.first().map_or("", |i| name(*i))),
            x: Axis::linear("u"),
            y: Axis::linear("value"),
            series,
            reference_lines: Vec::new(),
        };
        let caption = format!(
            "A step over 8 x 8 elements along lines of constant v (document 003, figure {number}): through the middles of \
             elements (v = 7/16) and between two rows (v = 1/2)."
        );
        figures.push(Figure { name: format!("step_{key}"), plot, caption });
    }
    Ok((figures, table))
}

/// Width of the rise from the last point at or below 0.1 to the first above 0.9, in elements.
fn rise(curve: &Series) -> Option<f64> {
    let high = curve.points.iter().position(|p| p[1] > 0.9)?;
    let low = curve.points.get(..high)?.iter().rposition(|p| p[1] <= 0.1)?;
    Some((curve.points.get(high)?[0] - curve.points.get(low)?[0]) * SIDE as f64)
}

/// Reference and textures of a division along the row of texels through v = 1/2.
pub(super) fn profile(outcome: &SceneResult, division: FloorDivision, size: [usize; 2]) -> Option<Figure> {
    let of = outcome.divisions.iter().find(|of| of.division == division)?;
    let line = |name: &str, texels: &[f64]| {
        let row = texels.get(size[1] / 2 * size[0]..)?.get(..size[0])?;
        let at = |i: usize| (i as f64 + 0.5) / size[0] as f64;
        let points = row.iter().enumerate().map(|(i, x)| [at(i), *x]).collect();
        Some(Series { name: name.to_owned(), points })
    };
    let mut series = vec![line("reference", &outcome.reference.texels)?];
    let spline = InterpolationMethod { interpolation: Interpolation::Spline, border: Border::Open };
    let scattered =
        SCATTERED.map(|interpolation| InterpolationMethod { interpolation, border: Border::Sampled });
    for method in scattered.into_iter().chain([spline]) {
        if let Some(made) = of.of(method.interpolation, method.border) {
            series.extend(line(method.name(), &made.texels));
        }
    }
    let number = outcome.setup.number;
    Some(Figure {
        name: format!("profile_{}_{}", number, division.name()),
        plot: Plot {
            title: format!("Scene {number}, {}: along v = 1/2", division.name()),
            x: Axis::linear("u"),
            y: Axis::linear("radiosity, relative to the largest"),
            series,
            reference_lines: Vec::<ReferenceLine>::new(),
        },
        caption: format!(
            "Scene {number} ({}), {}: light along the line v = 1/2, with border samples.",
            outcome.setup.description,
            division.name()
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glanz_report::TableCell;

    #[test]
    fn steps_are_as_steep_and_as_even_as_theory_has_it() {
        let (figures, table) = steps().unwrap();
        assert_eq!(figures.len(), 5);
        let number = |row: usize, column: usize| match table.rows()[row][column] {
            TableCell::Number(number) => number,
            _ => f64::NAN,
        };
        // Bilinear: a ramp of one element, of which 0.8 lie between 0.1 and 0.9; to a step of the curve on each side.
        assert!((number(0, 4) - 0.8).abs() < 0.05 && number(0, 2).abs() < 1e-12);
        // Splines overshoot by 1/14 at most beside a step of natural ones (here of 8 values), multiquadrics somewhat less.
        assert!((0.05..0.15).contains(&number(1, 2)) && (0.02..0.15).contains(&number(5, 2)));
        for row in [2, 3, 4, 6] {
            assert!(number(row, 2).max(number(row, 3)) < 1e-9, "{row}");
        }
    }
}
