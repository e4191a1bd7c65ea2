//! Splines through given points.

use glanz_math::DVec3;
use glanz_math::bspline::Knots;
use glanz_math::glam::DVec4;

use super::basis::BasisFunctions;
use super::curve::NurbsCurve;
use super::knots::{KnotVector, check_degree};
use super::polygon::ControlPoint;
use super::surface::NurbsSurface;
use crate::error::{SurfaceError, finite};

/// The LU factors of the matrix of all basis functions at the interpolation parameters.
///
/// The matrix is totally positive: elimination without pivoting is stable, keeps the band, and no pivot is zero.
///
/// # Source
/// @deboor1977; solvability: @pumberger2010 theorem 2.1.2.4 (Schoenberg and Whitney).
struct CollocationMatrix {
    degree: usize,
    /// Row i holds the columns i - degree to i + degree; the factors of elimination are left of the diagonal.
    band: Vec<f64>,
}

impl CollocationMatrix {
    fn try_new(knots: &KnotVector, parameters: &[f64]) -> Result<Self, SurfaceError> {
        let (p, count, expected) = (knots.degree(), parameters.len(), knots.count());
        if count != expected {
            let parameter = "interpolation parameters";
            return Err(SurfaceError::CountMismatch { parameter, count, expected });
        }
        let [start, end] = knots.domain();
        let mut band = vec![0.0; count * (2 * p + 1)];
        for (i, &value) in parameters.iter().enumerate() {
            finite("interpolation parameter", value)?;
            let basis = BasisFunctions::at(knots, value);
            let (first, row) = (basis.first(), basis.values());
            let is_positive = i >= first && i <= first + p && row[i - first] > 0.0;
            if !is_positive || value < start || value > end {
                // N_i must not vanish at parameter i.
                let (min, max) = (knots.knots()[i].max(start), knots.knots()[i + p + 1].min(end));
                return Err(SurfaceError::OutOfRange {
                    parameter: "interpolation parameter",
                    value,
                    min,
                    max,
                });
            }
            for (j, n) in (first..=first + p).zip(row) {
                band[i * (2 * p + 1) + j + p - i] = n;
            }
        }
        for pair in parameters.windows(2) {
            if pair[0] >= pair[1] {
                let parameter = "the interval between interpolation parameters";
                return Err(SurfaceError::EmptyRange { parameter, min: pair[0], max: pair[1] });
            }
        }
        let mut matrix = Self { degree: p, band };
        matrix.eliminate(count)?;
        Ok(matrix)
    }

    /// Index of the entry (i, j) in the band.
    fn at(&self, i: usize, j: usize) -> usize {
        i * (2 * self.degree + 1) + j + self.degree - i
    }

    fn eliminate(&mut self, count: usize) -> Result<(), SurfaceError> {
        for k in 0..count {
            let pivot = self.band[self.at(k, k)];
            if pivot.is_nan() || pivot <= 0.0 {
                let reason = "the interpolation parameters are too close together, pivot";
                return Err(SurfaceError::Degenerate { reason, value: pivot });
            }
            let end = (k + self.degree).min(count - 1);
            for i in k + 1..=end {
                let factor = self.band[self.at(i, k)] / pivot;
                let position = self.at(i, k);
                self.band[position] = factor;
                for j in k + 1..=end {
                    let (from, to) = (self.at(k, j), self.at(i, j));
                    self.band[to] -= factor * self.band[from];
                }
            }
        }
        Ok(())
    }

    /// The control points of the spline that takes these values, one per parameter.
    fn solve<P: ControlPoint>(&self, values: &[P]) -> Vec<P> {
        let mut found = values.to_vec();
        let (p, count) = (self.degree, values.len());
        for i in 1..count {
            for k in i.saturating_sub(p)..i {
                found[i] = found[i] - found[k] * self.band[self.at(i, k)];
            }
        }
        for i in (0..count).rev() {
            for j in i + 1..=(i + p).min(count - 1) {
                found[i] = found[i] - found[j] * self.band[self.at(i, j)];
            }
            found[i] = found[i] * (1.0 / self.band[self.at(i, i)]);
        }
        found
    }
}

/// Clamped knots at averages of the parameters, for which interpolation at the parameters is possible.
///
/// # Errors
/// [`SurfaceError::OutOfRange`] for the degree, [`SurfaceError::TooFew`] parameters, and those of [`KnotVector::try_new`].
///
/// # Source
/// @pumberger2010 section 2.1.2, second remark; @piegl1997 eq. 9.8.
pub fn averaged_knots(degree: usize, parameters: &[f64]) -> Result<KnotVector, SurfaceError> {
    check_degree(degree)?;
    let (count, min) = (parameters.len(), degree + 1);
    if count < min {
        return Err(SurfaceError::TooFew { parameter: "points to interpolate", count, min });
    }
    let means = parameters[1..count - 1].windows(degree).map(|w| w.iter().sum::<f64>() / degree as f64);
    let ends = [parameters[0], parameters[count - 1]];
    KnotVector::try_new(degree, Knots::clamped(degree, ends, means.take(count - degree - 1)))
}

/// Parameters from 0 to 1 in proportion to the lengths of the chords; `None` if all points coincide.
fn chord_parameters(points: impl Iterator<Item = DVec3>) -> Option<Vec<f64>> {
    let mut previous = None;
    let mut length = 0.0;
    let mut lengths = Vec::new();
    for point in points {
        length += previous.map_or(0.0, |p: DVec3| p.distance(point));
        previous = Some(point);
        lengths.push(length);
    }
    (length > 0.0 && length.is_finite()).then(|| lengths.into_iter().map(|l| l / length).collect())
}

/// The mean of the chord parameters of several rows of points.
fn mean_parameters(rows: impl Iterator<Item = Option<Vec<f64>>>) -> Result<Vec<f64>, SurfaceError> {
    let mut used = 0.0;
    let mut sums: Vec<f64> = Vec::new();
    for row in rows.flatten() {
        sums.resize(row.len(), 0.0);
        sums.iter_mut().zip(row).for_each(|(s, x)| *s += x);
        used += 1.0;
    }
    if sums.is_empty() {
        return Err(SurfaceError::Degenerate {
            reason: "the points to interpolate coincide, chord length",
            value: 0.0,
        });
    }
    Ok(sums.into_iter().map(|s| s / used).collect())
}

impl NurbsCurve {
    /// The spline with these knots that passes through `points` (metres) at `parameters`, all weights 1.
    ///
    /// The Greville abscissae of the knots are always valid parameters.
    ///
    /// # Errors
    /// [`SurfaceError::CountMismatch`] unless there are `knots.count()` parameters and points, [`SurfaceError::NotFinite`],
    /// [`SurfaceError::EmptyRange`] if the parameters do not ascend, [`SurfaceError::OutOfRange`] for a parameter where the basis
    /// function of the same number is not positive, [`SurfaceError::Degenerate`] if rounding makes the system singular.
    pub fn interpolate_at(
        knots: KnotVector,
        parameters: &[f64],
        points: &[DVec3],
    ) -> Result<Self, SurfaceError> {
        check_points(points.len(), knots.count(), points.iter().flat_map(DVec3::to_array))?;
        let found = CollocationMatrix::try_new(&knots, parameters)?.solve(points);
        Self::from_knots(knots, found.into_iter().map(|p| p.extend(1.0)).collect())
    }

    /// A spline of this degree through `points` (metres) over [0, 1], with chord-length parameters and averaged knots, all
    /// weights 1.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] for the degree, [`SurfaceError::TooFew`] points for it, [`SurfaceError::NotFinite`],
    /// [`SurfaceError::Degenerate`] if all points coincide, and those of [`NurbsCurve::interpolate_at`], such as
    /// [`SurfaceError::EmptyRange`] if neighbours coincide.
    pub fn interpolate(degree: usize, points: &[DVec3]) -> Result<Self, SurfaceError> {
        check_points(points.len(), points.len(), points.iter().flat_map(DVec3::to_array))?;
        let parameters = mean_parameters(std::iter::once(chord_parameters(points.iter().copied())))?;
        Self::interpolate_at(averaged_knots(degree, &parameters)?, &parameters, points)
    }
}

impl NurbsSurface {
    /// The surface with these knots that passes through point `i * count_v + j` (metres) at parameter i in u and j in v, all
    /// weights 1.
    ///
    /// # Errors
    /// Those of [`NurbsCurve::interpolate_at`] in each direction.
    ///
    /// # Source
    /// @pumberger2010 section 2.1.2; departure: `Q = A P B^T`.
    pub fn interpolate_at(
        [knots_u, knots_v]: [KnotVector; 2],
        [parameters_u, parameters_v]: [&[f64]; 2],
        points: &[DVec3],
    ) -> Result<Self, SurfaceError> {
        let count = knots_u.count().saturating_mul(knots_v.count());
        check_points(points.len(), count, points.iter().flat_map(DVec3::to_array))?;
        let net = interpolating_net([&knots_u, &knots_v], [parameters_u, parameters_v], points)?;
        Self::from_knots(knots_u, knots_v, net.into_iter().map(|point| point.extend(1.0)).collect())
    }

    /// The rational surface with these knots that passes through homogeneous points `(w x, w y, w z, w)` (coordinates in metres), point
    /// `i * count_v + j` at parameter i in u and j in v.
    ///
    /// # Errors
    /// Those of [`NurbsSurface::interpolate_at`], and [`SurfaceError::NotPositive`] for a weight of a control point.
    pub fn interpolate_homogeneous_at(
        [knots_u, knots_v]: [KnotVector; 2],
        parameters: [&[f64]; 2],
        points: &[DVec4],
    ) -> Result<Self, SurfaceError> {
        let count = knots_u.count().saturating_mul(knots_v.count());
        check_points(points.len(), count, points.iter().flat_map(DVec4::to_array))?;
        let net = interpolating_net([&knots_u, &knots_v], parameters, points)?;
        Self::from_knots(knots_u, knots_v, net)
    }

    /// A surface of these degrees over the unit square through `counts[0]` times `counts[1]` points (metres, point (i, j) at
    /// `i * counts[1] + j`), with parameters from the mean chord lengths of rows and columns and averaged knots, all
    /// weights 1.
    ///
    /// # Errors
    /// [`SurfaceError::OutOfRange`] for a degree, [`SurfaceError::TooFew`] points for it, [`SurfaceError::CountMismatch`],
    /// [`SurfaceError::NotFinite`], [`SurfaceError::Degenerate`] if all points of all rows or columns coincide, and those of
    /// [`NurbsSurface::interpolate_at`], such as [`SurfaceError::EmptyRange`] if neighbouring rows or columns coincide.
    pub fn interpolate(
        [degree_u, degree_v]: [usize; 2],
        counts: [usize; 2],
        points: &[DVec3],
    ) -> Result<Self, SurfaceError> {
        let [count_u, count_v] = counts;
        check_points(points.len(), count_u.saturating_mul(count_v), points.iter().flat_map(DVec3::to_array))?;
        let row = |i: usize| chord_parameters((0..count_v).map(move |j| points[i * count_v + j]));
        let column = |j: usize| chord_parameters((0..count_u).map(move |i| points[i * count_v + j]));
        let u = mean_parameters((0..count_v).map(column))?;
        let v = mean_parameters((0..count_u).map(row))?;
        let knots = [averaged_knots(degree_u, &u)?, averaged_knots(degree_v, &v)?];
        Self::interpolate_at(knots, [&u, &v], points)
    }
}

/// The control points of the spline that takes the value `i * count_v + j` at parameter i in u and j in v.
fn interpolating_net<P: ControlPoint>(
    [knots_u, knots_v]: [&KnotVector; 2],
    [parameters_u, parameters_v]: [&[f64]; 2],
    points: &[P],
) -> Result<Vec<P>, SurfaceError> {
    let (count_u, count_v) = (knots_u.count(), knots_v.count());
    let in_u = CollocationMatrix::try_new(knots_u, parameters_u)?;
    let in_v = CollocationMatrix::try_new(knots_v, parameters_v)?;
    let rows: Vec<Vec<P>> = points.chunks_exact(count_v).map(|row| in_v.solve(row)).collect();
    let columns: Vec<Vec<P>> =
        (0..count_v).map(|j| in_u.solve(&rows.iter().map(|row| row[j]).collect::<Vec<_>>())).collect();
    let columns = &columns;
    Ok((0..count_u).flat_map(|i| (0..count_v).map(move |j| columns[j][i])).collect())
}

fn check_points(
    count: usize,
    expected: usize,
    mut coordinates: impl Iterator<Item = f64>,
) -> Result<(), SurfaceError> {
    if count != expected {
        return Err(SurfaceError::CountMismatch { parameter: "points to interpolate", count, expected });
    }
    coordinates.try_for_each(|value| finite("point to interpolate", value).map(|_| ()))
}
