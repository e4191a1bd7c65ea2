//! Samples follow the stated density, and the density integrates to 1.

use glanz_geometry::{AreaSample, Hit, SurfacePoint};
use glanz_math::{DVec2, DVec3, Ray};

use super::case::ContractCase;
use super::harness::{check_on_surface, tangents};
use super::rays::Pcg;

const SAMPLES: usize = 20_000;
/// Cells per side of the chi-square grid, and quadrature points per side of a cell.
const CELLS: usize = 8;
const POINTS: usize = 6;
/// Quantile of the normal distribution of a significance of 1e-6.
const QUANTILE: f64 = 4.753;

/// Checks `sample` and `area_pdf`.
pub fn check(case: &ContractCase, pcg: &mut Pcg) -> Result<(), String> {
    let surface = &case.surface;
    if !case.samples {
        return match surface.sample(pcg.pair()) {
            None => Ok(()),
            Some(sample) => Err(format!("should have no samples, gives {sample:?}")),
        };
    }
    let mut counts = [[0.0_f64; CELLS]; CELLS];
    let (mut sum, mut sum_of_squares) = (0.0, 0.0);
    let last = 1.0_f64.next_down();
    let corners = [DVec2::ZERO, DVec2::new(last, 0.0), DVec2::new(0.0, last), DVec2::new(last, last)];
    for i in 0..SAMPLES + corners.len() {
        let xi = corners.get(i).copied().unwrap_or_else(|| pcg.pair());
        let sample = surface.sample(xi).ok_or(format!("no sample for {xi:?}"))?;
        if surface.sample_area(xi) != Some(AreaSample::from(sample)) {
            return Err(format!("without parameters, {:?} differs from {sample:?}", surface.sample_area(xi)));
        }
        check_on_surface(case, &sample.point).map_err(|what| format!("sample of {xi:?}: {what}"))?;
        let pdf = surface.area_pdf(&sample.hit, &sample.point).ok_or("area_pdf is None")?.0;
        if !((pdf - sample.pdf.0).abs() <= 1e-9 * pdf) && pdf != sample.pdf.0 {
            return Err(format!("area_pdf is {pdf}: {sample:?}"));
        }
        if i < corners.len() {
            continue;
        }
        if let Some(position) = &case.position {
            let there = position(sample.point.uv);
            if there.distance(sample.point.position) > 1e-9 * case.size {
                return Err(format!("the parameters belong to {there:?}: {sample:?}"));
            }
        }
        let cell = |x: f64| ((x * CELLS as f64) as usize).min(CELLS - 1);
        counts[cell(sample.point.uv.x)][cell(sample.point.uv.y)] += 1.0;
        sum += 1.0 / pdf;
        sum_of_squares += 1.0 / (pdf * pdf);
    }
    check_area(case, sum, sum_of_squares)?;
    if let Some(position) = case.position.as_deref() {
        check_density(case, position, &counts)?;
    }
    Ok(())
}

/// Checks that the mean of 1 / pdf is the area.
fn check_area(case: &ContractCase, sum: f64, sum_of_squares: f64) -> Result<(), String> {
    let Some(area) = case.area else { return Ok(()) };
    let n = SAMPLES as f64;
    let mean = sum / n;
    let variance = (sum_of_squares / n - mean * mean).max(0.0);
    let standard_error = (variance / n).sqrt();
    if (mean - area).abs() > 4.0 * standard_error + 1e-6 * area {
        return Err(format!("1/pdf has the mean {mean} +- {standard_error}, the area is {area}"));
    }
    Ok(())
}

/// Checks that the density integrates to 1 over the parameters, and to the fraction of samples over each cell.
fn check_density(
    case: &ContractCase,
    position: &dyn Fn(DVec2) -> DVec3,
    counts: &[[f64; CELLS]; CELLS],
) -> Result<(), String> {
    let n = SAMPLES as f64;
    let (mut total, mut chi_square, mut freedom) = (0.0_f64, 0.0_f64, -1.0_f64);
    let (mut rest_expected, mut rest_seen) = (0.0, 0.0);
    for (i, column) in counts.iter().enumerate() {
        for (j, &seen) in column.iter().enumerate() {
            let share = fraction_of_cell(case, position, i, j)?;
            total += share;
            if n * share < 8.0 {
                // Too few for a normal approximation: pooled.
                rest_expected += n * share;
                rest_seen += seen;
                continue;
            }
            chi_square += (seen - n * share).powi(2) / (n * share);
            freedom += 1.0;
        }
    }
    if rest_expected >= 8.0 {
        chi_square += (rest_seen - rest_expected).powi(2) / rest_expected;
        freedom += 1.0;
    }
    if (total - 1.0).abs() > 2e-3 {
        return Err(format!("the density integrates to {total}"));
    }
    // Wilson and Hilferty 1931.
    let ninth = 2.0 / (9.0 * freedom);
    let limit = freedom * (1.0 - ninth + QUANTILE * ninth.sqrt()).powi(3);
    if chi_square > limit {
        return Err(format!("chi-square {chi_square} with {freedom} degrees of freedom, limit {limit}"));
    }
    Ok(())
}

fn fraction_of_cell(
    case: &ContractCase,
    position: &dyn Fn(DVec2) -> DVec3,
    i: usize,
    j: usize,
) -> Result<f64, String> {
    let side = (CELLS * POINTS) as f64;
    let mut share = 0.0;
    for k in 0..POINTS * POINTS {
        let at = |cell: usize, k: usize| ((cell * POINTS + k) as f64 + 0.5) / side;
        let uv = DVec2::new(at(i, k / POINTS), at(j, k % POINTS));
        let [du, dv] = tangents(position, uv);
        let element = du.cross(dv).length();
        if !(element > 0.0) {
            continue;
        }
        let (hit, point) = look_up(case, position(uv), du.cross(dv) / element)
            .ok_or_else(|| format!("no hit at the parameters {uv:?}"))?;
        let pdf = case.surface.area_pdf(&hit, &point).ok_or("area_pdf is None")?.0;
        share += pdf * element / (side * side);
    }
    Ok(share)
}

/// The surface at a point that is known to lie on it, by a ray along the normal there.
fn look_up(case: &ContractCase, p: DVec3, normal: DVec3) -> Option<(Hit, SurfacePoint)> {
    let ray = Ray::new(p + normal * (0.01 * case.size), -normal);
    let mut hits = Vec::new();
    case.surface.all_hits(&ray, f64::INFINITY, &mut hits);
    let found = hits.iter().map(|h| (*h, case.surface.point(&ray, h)));
    let nearest = found.min_by(|a, b| a.1.position.distance(p).total_cmp(&b.1.position.distance(p)))?;
    (nearest.1.position.distance(p) < 1e-6 * case.size).then_some(nearest)
}
