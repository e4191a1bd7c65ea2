//! Triangles compared with the surface that they approximate (document 002 section 7).

mod picture;
mod report;
mod setup;
mod surface;

use self::picture::difference_picture;
use self::report::{GAIN, SurfaceOutcome, build_report};
use self::setup::TessellationSetup;
use crate::report::Report;
use crate::study::{Settings, StudyError, StudyProgress};
use glanz_report::number::grouped;

/// Triangles per surface: those of document 002, and two numbers for a modern machine.
const TRIANGLES: [u64; 7] = [1250, 5000, 11_250, 20_000, 31_250, 125_000, 2_000_000];

/// Pixels of the pictures in document 002.
const SIZE: [u32; 2] = [1920, 1080];

/// Numbers of surfaces.
const SURFACES: [usize; 2] = [1, 3];

/// Runs the study.
///
/// # Errors
/// [`StudyError::Interrupted`], or numbers of triangles that are not twice a square.
pub(crate) fn run(settings: &Settings, progress: &mut StudyProgress<'_>) -> Result<Report, StudyError> {
    settings.cancel.check()?;
    let size = settings.size.unwrap_or(SIZE);
    let counts = settings.triangles.clone().unwrap_or_else(|| TRIANGLES.to_vec());
    let mut grids = counts.iter().map(|&count| grid(count)).collect::<Result<Vec<u32>, _>>()?;
    grids.sort_unstable();
    grids.dedup();
    // The work grows with the number of pictures.
    let parts = (SURFACES.len() * (grids.len() + 3)) as f64;
    let mut done = 0.0;
    let mut report_progress = |what: String| {
        progress.report(done / parts, &what);
        done += 1.0;
    };
    let mut results = Vec::new();
    let mut pictures = Vec::new();
    for surfaces in SURFACES {
        let noun = if surfaces == 1 { "surface" } else { "surfaces" };
        report_progress(format!("{surfaces} {noun}, exact"));
        let setup = TessellationSetup::new(surfaces, size, settings)?;
        let mut cases = Vec::new();
        let mut coarsest = None;
        for &n in &grids {
            report_progress(format!(
                "{surfaces} {noun}, {} triangles each",
                grouped(2 * u64::from(n).pow(2))
            ));
            let (case, pixels) = setup.triangles(n)?;
            coarsest.get_or_insert(pixels);
            cases.push((n, case));
        }
        report_progress(format!("{surfaces} {noun}, smallest sufficient number of triangles"));
        let smallest = setup.smallest(&cases)?;
        report_progress(format!("{surfaces} {noun}, differences"));
        if let Some(coarsest) = coarsest {
            let difference = difference_picture(&setup.pixels, &coarsest, GAIN)?;
            pictures.push((surfaces, setup.pixels, coarsest, difference));
        }
        let cases = cases.into_iter().map(|(_, case)| case).collect();
        let (length, coverage) = (setup.hits.silhouette_length(), setup.hits.coverage());
        results.push(SurfaceOutcome { surfaces, exact: setup.exact, cases, smallest, length, coverage });
    }
    let report = build_report(&results, pictures, size, settings);
    progress.report(1.0, "done");
    Ok(report)
}

/// Cells along a side of a surface of `count` triangles.
fn grid(count: u64) -> Result<u32, StudyError> {
    let n = (count / 2).isqrt();
    let bad = StudyError::Setting {
        name: "triangles",
        value: count.to_string(),
        needed: "twice the square of a number from 2 to 4096",
    };
    match u32::try_from(n) {
        Ok(small @ 2..=4096) if 2 * n * n == count => Ok(small),
        _ => Err(bad),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::StudyProgress;
    use glanz_job::Silent;
    use glanz_report::TableCell;

    #[test]
    fn numbers_of_triangles_are_twice_a_square() {
        assert_eq!(grid(1250).unwrap(), 25);
        assert_eq!(grid(2_000_000).unwrap(), 1000);
        for bad in [0, 2, 1251, 2000, u64::MAX] {
            assert!(matches!(grid(bad), Err(StudyError::Setting { name: "triangles", .. })), "{bad}");
        }
    }

    #[test]
    fn report_has_a_row_for_every_picture() {
        let settings =
            Settings { size: Some([48, 27]), triangles: Some(vec![200, 72]), ..Settings::default() };
        let report = run(&settings, &mut StudyProgress::new(&mut Silent)).unwrap();
        let kinds: Vec<&TableCell> = report.summary().rows().iter().map(|row| &row[2]).collect();
        let count = |n: u64| TableCell::Count(n);
        assert_eq!(
            kinds,
            [&TableCell::Missing, &count(72), &count(200), &TableCell::Missing, &count(216), &count(600)]
        );
    }
}
