//! A slow reference solver, independent of the code under test: signs of the implicit function along the ray.

use glanz_math::{DVec3, Ray};

use super::case::ContractCase;

/// A crossing of the continued surface.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceRoot {
    /// Ray parameter.
    pub t: f64,
    /// Bound on the error of `t`, metres along the ray.
    pub tolerance: f64,
    /// Whether the surface must report it.
    pub status: RootStatus,
}

/// Whether the surface must report a root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RootStatus {
    /// Must be reported: on the kept part, not tangential, not near a singular point.
    Hit,
    /// Must not be reported.
    Clipped,
    /// Undecided: tangential, at the border of the kept part, or at a singular point.
    Undecided,
}

/// The crossings beyond a distance.
pub struct ReferenceRoots {
    /// In ascending order.
    pub roots: Vec<ReferenceRoot>,
    /// Whether the ray passes so close to the surface without crossing that roots may have been missed.
    pub near_miss: bool,
}

/// The ray, parameterized by arc length from the point nearest to the middle of the ball.
struct CenteredRay {
    origin: DVec3,
    direction: DVec3,
    /// Ray parameter of `origin`, and ray parameter per metre.
    t_shift: f64,
    t_scale: f64,
}

impl CenteredRay {
    fn new(case: &ContractCase, ray: &Ray) -> Self {
        let length = ray.direction.length();
        let t_shift = (case.center - ray.origin).dot(ray.direction) / (length * length);
        let at = |o: f64, d: f64| t_shift.mul_add(d, o);
        Self {
            origin: DVec3::new(
                at(ray.origin.x, ray.direction.x),
                at(ray.origin.y, ray.direction.y),
                at(ray.origin.z, ray.direction.z),
            ),
            direction: ray.direction / length,
            t_shift,
            t_scale: 1.0 / length,
        }
    }

    fn at(&self, s: f64) -> DVec3 {
        self.origin + self.direction * s
    }
}

/// All crossings of `ray` with the continued surface of `case` at more than `beyond` metres from the origin.
///
/// `hits`: the t reported by the surface, ascending. They are not trusted, but signs between them are tested too, since a pair of
/// crossings in a corner may be closer together than the samples.
pub fn roots(case: &ContractCase, ray: &Ray, beyond: f64, hits: &[f64]) -> ReferenceRoots {
    let line = CenteredRay::new(case, ray);
    let mut found = ReferenceRoots { roots: Vec::new(), near_miss: false };
    // Slightly more than the ball, so that the ends are never on the surface.
    let radius = 1.05 * case.size;
    let half_chord = (radius * radius - line.origin.distance_squared(case.center)).max(0.0).sqrt();
    let start = (beyond - line.t_shift / line.t_scale).max(-half_chord);
    if !(start < half_chord) {
        return found;
    }
    let f = |s: f64| (case.implicit)(line.at(s));
    let s_of = |i: usize| start + (half_chord - start) * (i as f64 / (case.resolution - 1) as f64);
    let between = hits.windows(2).map(|pair| (0.5 * (pair[0] + pair[1]) - line.t_shift) / line.t_scale);
    let kink =
        |&(normal, offset): &(DVec3, f64)| (offset - normal.dot(line.origin)) / normal.dot(line.direction);
    let further = between.chain(case.kinks.iter().map(kink)).filter(|s| (start..half_chord).contains(s));
    let mut places: Vec<f64> = (0..case.resolution).map(s_of).chain(further).collect();
    places.sort_by(f64::total_cmp);
    let samples: Vec<(f64, f64)> = places.into_iter().map(|s| (s, f(s))).collect();
    let slope = case.gradient(line.at(start)).length();
    // The ray starts on the surface: it touches it, or the first root is undecided.
    found.near_miss |= samples[0].1.abs() <= 1e-10 * case.size * slope
        || case.distance_to_singular(line.at(start)) < 1e-5 * case.size;
    if !case.ridges.is_empty() {
        // Where lines of self-intersection meet, crossings may be closer together than samples.
        let spacing = s_of(1) - start;
        let passes =
            |p: &DVec3| (*p - line.origin).reject_from_normalized(line.direction).length() < 4.0 * spacing;
        found.near_miss |= case.singular.iter().any(passes);
    }
    let mut crossings = Vec::new();
    for (i, pair) in samples.windows(2).enumerate() {
        if pair[0].1 * pair[1].1 < 0.0 {
            crossings.push(bisect(&f, pair[0].0, pair[1].0));
        } else if i > 0 && pair[0].1 == 0.0 {
            // A sample on the surface: a crossing if the signs differ, otherwise the ray touches the surface or lies in it.
            if samples[i - 1].1 * pair[1].1 < 0.0 {
                crossings.push(pair[0].0);
            } else {
                found.near_miss = true;
            }
        } else if i > 0 {
            search_extremum(case, &line, &f, &samples[i - 1..=i + 1], &mut crossings, &mut found.near_miss);
        } else {
            // The start may be so close to the surface that the ray crosses it before the first sample.
            let first = start + 1e-9 * case.size;
            let three = [pair[0], (first, f(first)), pair[1]];
            search_extremum(case, &line, &f, &three, &mut crossings, &mut found.near_miss);
        }
    }
    crossings.sort_by(f64::total_cmp);
    let origin_distance = ray.origin.distance(case.center);
    for (i, &s) in crossings.iter().enumerate() {
        let gap = |j: usize| crossings.get(j).map_or(f64::INFINITY, |&other| (other - s).abs());
        let nearest = gap(i + 1).min(if i > 0 { gap(i - 1) } else { f64::INFINITY });
        found.roots.push(classify(case, &line, s, nearest, origin_distance));
    }
    found
}

/// Searches between three samples of one sign for a pair of crossings.
fn search_extremum(
    case: &ContractCase,
    line: &CenteredRay,
    f: &impl Fn(f64) -> f64,
    three: &[(f64, f64)],
    crossings: &mut Vec<f64>,
    near_miss: &mut bool,
) {
    let &[(s0, f0), (_, f1), (s2, f2)] = three else { return };
    if f0 * f1 <= 0.0 || f1 * f2 <= 0.0 || f1.abs() > f0.abs() || f1.abs() > f2.abs() {
        return;
    }
    let sign = f1.signum();
    let (mut a, mut b) = (s0, s2);
    for _ in 0..60 {
        let (l, r) = (a + 0.382 * (b - a), b - 0.382 * (b - a));
        let (fl, fr) = (sign * f(l), sign * f(r));
        if fl < 0.0 || fr < 0.0 {
            let inside = if fl < 0.0 { l } else { r };
            crossings.push(bisect(f, s0, inside));
            crossings.push(bisect(f, inside, s2));
            return;
        }
        if fl < fr {
            b = r;
        } else {
            a = l;
        }
    }
    let p = line.at(0.5 * (a + b));
    let slope = case.gradient(p).length();
    // A distance of 1e-10 sizes of the tangent point is below what a hit must resolve.
    *near_miss |= f(0.5 * (a + b)).abs() <= 1e-10 * case.size * slope
        || case.distance_to_singular(p) < 1e-5 * case.size;
}

fn bisect(f: &impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let negative = f(a) < 0.0;
    for _ in 0..100 {
        let middle = 0.5 * (a + b);
        if middle <= a || middle >= b {
            break;
        }
        if (f(middle) < 0.0) == negative {
            a = middle;
        } else {
            b = middle;
        }
    }
    0.5 * (a + b)
}

fn classify(
    case: &ContractCase,
    line: &CenteredRay,
    s: f64,
    nearest: f64,
    origin_distance: f64,
) -> ReferenceRoot {
    let p = line.at(s);
    let gradient = case.gradient(p);
    let cos = gradient.dot(line.direction).abs() / gradient.length();
    let noise = case.noise / gradient.length();
    let tolerance = (1e-12 * case.size + 4e-16 * origin_distance + noise) / cos.max(1e-12);
    let border = (case.kept)(p);
    // Twice the step of the differences: across an edge they mix two gradients. Two crossings closer together than the
    // rounding of the function moves either may be there or not.
    let status = if nearest < tolerance.max(1e-5 * case.size)
        || cos < 1e-5
        || case.distance_to_singular(p) < 2e-5 * case.size
        || !(border.abs() > 1e-9 * case.size + 10.0 * tolerance)
    {
        RootStatus::Undecided
    } else if border > 0.0 {
        RootStatus::Hit
    } else {
        RootStatus::Clipped
    };
    ReferenceRoot { t: line.t_shift + s * line.t_scale, tolerance: tolerance.min(case.size), status }
}
