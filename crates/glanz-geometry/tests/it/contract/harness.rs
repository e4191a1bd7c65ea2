//! Checks of the contract.

use glanz_geometry::{BoundedRay, Hit, ShadingPoint, SurfacePoint};
use glanz_math::rounding::offset_origin;
use glanz_math::{DVec2, DVec3, Ray};

use super::case::ContractCase;
use super::rays::{ContractRays, Pcg};
use super::sampling;
use super::solver::{self, ReferenceRoots, RootStatus};

/// Derivatives are compared at every 16th hit: differences cost a hundred evaluations.
const DERIVATIVES_EVERY: u64 = 16;

/// Counts for one kind of surface.
#[derive(Default)]
struct ContractTally {
    rays: u64,
    hits: u64,
    spawned: u64,
    breaches: u64,
    first_breaches: Vec<String>,
}

impl ContractTally {
    fn breach(&mut self, message: impl FnOnce() -> String) {
        self.breaches += 1;
        if self.first_breaches.len() < 8 {
            self.first_breaches.push(message());
        }
    }
}

/// Runs the contract over all `cases` of a kind.
///
/// Panics with the first breaches, rays in full precision.
pub fn check_kind(kind: &str, seed: u64, cases: &[ContractCase]) {
    let wanted = std::env::var("GLANZ_CONTRACT_RAYS").ok().and_then(|n| n.parse().ok()).unwrap_or(4000_u64);
    let per_case = wanted.div_ceil(cases.len() as u64);
    let mut tally = ContractTally::default();
    for (i, case) in cases.iter().enumerate() {
        let mut pcg = Pcg::new(seed * 1000 + i as u64);
        let (mut batch, mut sizes) = (Vec::new(), &BATCHES[..]);
        for family in ContractRays::ALL {
            for _ in 0..per_case {
                let ray = family.ray(case, &mut pcg);
                tally.rays += 1;
                if let Err(what) = check_ray(case, &ray, &mut pcg, &mut tally) {
                    tally.breach(|| format!("{} ({family:?}): {what}\n    {ray:?}", case.name));
                }
                batch.push(bounded(case, ray, tally.rays));
                if batch.len() == LARGEST_BATCH {
                    check_batches(case, &batch, sizes, &mut tally);
                    batch.clear();
                    // The first in all sizes, the others in one.
                    let next = (tally.rays / LARGEST_BATCH as u64) as usize % BATCHES.len();
                    sizes = &BATCHES[next..=next];
                }
            }
        }
        check_batches(case, &batch, sizes, &mut tally);
        if let Err(what) = sampling::check(case, &mut pcg) {
            tally.breach(|| format!("{} (sampling): {what}", case.name));
        }
    }
    println!(
        "contract {kind}: {} cases, {} rays, {} hits, {} spawned rays, {} breaches",
        cases.len(),
        tally.rays,
        tally.hits,
        tally.spawned,
        tally.breaches
    );
    assert!(tally.hits * 20 > tally.rays, "{kind}: too few rays hit the surface for a meaningful test");
    assert!(tally.breaches == 0, "{kind}: {} breaches\n{}", tally.breaches, tally.first_breaches.join("\n"));
}

/// The sizes in which rays are traced as batches again.
const BATCHES: [usize; 4] = [1, 7, 64, LARGEST_BATCH];
const LARGEST_BATCH: usize = 4096;

/// The ray without end, or with an end before, at or behind its first hit.
fn bounded(case: &ContractCase, ray: Ray, number: u64) -> BoundedRay {
    let end = |t: f64| match number % 4 {
        0 => f64::INFINITY,
        1 => 0.9 * t,
        2 => t,
        _ => t.next_up(),
    };
    BoundedRay::new(ray, case.surface.intersect(&ray, f64::INFINITY).map_or(f64::INFINITY, |hit| end(hit.t)))
}

/// Checks that batches of these sizes give the bits of single rays.
fn check_batches(case: &ContractCase, rays: &[BoundedRay], sizes: &[usize], tally: &mut ContractTally) {
    let surface = &case.surface;
    let closest = |BoundedRay { ray, t_max }: &BoundedRay| surface.intersect(ray, *t_max);
    let single: Vec<_> = rays.iter().map(closest).collect();
    let blocked: Vec<_> =
        rays.iter().map(|BoundedRay { ray, t_max }| surface.occluded(ray, *t_max)).collect();
    let (mut hits, mut occluded) = (Vec::new(), Vec::new());
    for &size in sizes {
        for ((rays, single), blocked) in rays.chunks(size).zip(single.chunks(size)).zip(blocked.chunks(size))
        {
            surface.closest_batch(rays, &mut hits);
            surface.occluded_batch(rays, &mut occluded);
            if hits != single || occluded != blocked {
                let differs = (0..rays.len()).find(|&i| hits[i] != single[i] || occluded[i] != blocked[i]);
                let ray = differs.map(|i| (rays[i], hits[i], single[i], occluded[i]));
                tally.breach(|| format!("{} (batches of {size}): {ray:?}", case.name));
            }
        }
    }
}

fn check_ray(case: &ContractCase, ray: &Ray, pcg: &mut Pcg, tally: &mut ContractTally) -> Result<(), String> {
    let mut hits = Vec::new();
    case.surface.all_hits(ray, f64::INFINITY, &mut hits);
    tally.hits += hits.len() as u64;
    check_queries_agree(case, ray, &hits)?;
    for hit in &hits {
        let point = case.surface.point(ray, hit);
        check_point(case, ray, hit, &point)?;
        if tally.hits.is_multiple_of(DERIVATIVES_EVERY) {
            check_derivatives(case, hit, &point)?;
        }
        if case.distance_to_singular(point.position) > 1e-3 * case.size {
            tally.spawned += 1;
            check_spawned(case, &point, pcg)?;
        }
    }
    check_roots(case, ray, &hits)
}

/// Checks that `intersect`, `occluded` and `all_hits` agree and respect the range of t.
fn check_queries_agree(case: &ContractCase, ray: &Ray, hits: &[Hit]) -> Result<(), String> {
    let surface = &case.surface;
    if !hits.iter().all(|h| h.t > 0.0 && h.t.is_finite() && h.u.is_finite() && h.v.is_finite()) {
        return Err(format!("a hit is out of range: {hits:?}"));
    }
    // A ray may enter by one face and leave by another in the same point of an edge.
    if !hits
        .windows(2)
        .all(|pair| pair[0].t < pair[1].t || (pair[0].t == pair[1].t && pair[0].face != pair[1].face))
    {
        return Err(format!("all_hits does not ascend: {hits:?}"));
    }
    let first = surface.intersect(ray, f64::INFINITY);
    if !is_first_of(first, hits) {
        return Err(format!("intersect gives {first:?}, all_hits {hits:?}"));
    }
    if surface.occluded(ray, f64::INFINITY) != first.is_some() {
        return Err(format!("occluded disagrees with {first:?}"));
    }
    for hit in hits {
        for t_max in [hit.t, hit.t.next_up()] {
            let inside = hits.iter().filter(|h| h.t < t_max).count();
            let mut again = vec![Hit::new(-7.0, 0.0, 0.0, 9)];
            surface.all_hits(ray, t_max, &mut again);
            if again[0].t != -7.0 || again[1..] != hits[..inside] {
                return Err(format!("all_hits with t_max = {t_max:?} gives {again:?} of {hits:?}"));
            }
            let nearest = surface.intersect(ray, t_max);
            if !is_first_of(nearest, &hits[..inside]) || surface.occluded(ray, t_max) != (inside > 0) {
                return Err(format!("intersect with t_max = {t_max:?} gives {nearest:?} of {hits:?}"));
            }
        }
    }
    Ok(())
}

/// Whether `found` is the first of `hits`, or another face with the same t.
fn is_first_of(found: Option<Hit>, hits: &[Hit]) -> bool {
    match (found, hits.first()) {
        (None, None) => true,
        (Some(found), Some(first)) => found.t == first.t && hits.contains(&found),
        _ => false,
    }
}

/// Checks that the hit lies on ray and surface and within the bounds, and that its frame is valid.
pub fn check_point(case: &ContractCase, ray: &Ray, hit: &Hit, point: &SurfacePoint) -> Result<(), String> {
    let p = point.position;
    let [dndu, dndv] = case.surface.normal_derivatives(hit, point);
    let finite = [p, point.error, point.normal, point.shading_normal, point.dpdu, point.dpdv, dndu, dndv];
    if !finite.iter().all(|v| v.is_finite()) || !point.uv.is_finite() {
        return Err(format!("not finite: {hit:?} {point:?}"));
    }
    // Distant hits of infinite surfaces have fewer digits.
    let reach = 1e-9 * case.size + 1e-15 * p.distance(case.center);
    let on_ray = (p - ray.origin).cross(ray.direction).length() / ray.direction.length();
    let along = p.distance(ray.at(hit.t));
    if on_ray > reach || along > reach {
        return Err(format!("{on_ray:e} m beside the ray, {along:e} m from its point: {hit:?} {point:?}"));
    }
    let location = case.surface.location(ray, hit);
    let turned = location.normal.normalize_or_zero().distance(point.normal) > 1e-15;
    if (location.position, location.uv) != (p, point.uv) || turned {
        return Err(format!("{location:?} differs from {point:?}"));
    }
    // A mesh leaves out the derivative, which belongs to one triangle.
    let shading = case.surface.shading_point(ray, hit);
    let expected = ShadingPoint { dpdu: shading.dpdu, ..ShadingPoint::from(*point) };
    if shading != expected || ![point.dpdu, DVec3::ZERO].contains(&shading.dpdu) {
        return Err(format!("for shading, {shading:?} differs from {point:?}"));
    }
    check_on_surface(case, point)
}

/// Checks that the point lies on the surface and in the bounds, the error bound is valid, and normal and tangents agree.
pub fn check_on_surface(case: &ContractCase, point: &SurfacePoint) -> Result<(), String> {
    let (p, size) = (point.position, case.size);
    let gradient = case.gradient(p).length();
    // Near singular points the gradient vanishes, and rounding hides the zero of the function.
    let regular = case.distance_to_singular(p) > 1e-4 * size && case.noise <= 1e-9 * size * gradient;
    if regular {
        let distance = (case.implicit)(p).abs() / gradient;
        // 4e-15: what the implicit function itself can resolve.
        let bound = point.normal.abs().dot(point.error) + 4e-15 * (size + case.center.length());
        if distance > 1e-9 * size || distance > bound {
            return Err(format!("{distance:e} m off the surface, bound {bound:e}: {point:?}"));
        }
        let cos = case.gradient(p).dot(point.normal).abs() / gradient;
        if cos < 1.0 - 1e-8 {
            return Err(format!("the normal is not that of the surface (cos {cos}): {point:?}"));
        }
    }
    if !((case.kept)(p) >= -1e-9 * size) {
        return Err(format!("on the part clipped away by {:e} m: {point:?}", (case.kept)(p)));
    }
    if !case.surface.bounds().contains(p) {
        return Err(format!("outside the bounds {:?}: {point:?}", case.surface.bounds()));
    }
    if !(point.error.min_element() >= 0.0 && point.error.max_element() <= 1e-9 * size) {
        return Err(format!("the error bound is negative or too large: {point:?}"));
    }
    for n in [point.normal, point.shading_normal] {
        if (n.length() - 1.0).abs() > 1e-14 {
            return Err(format!("the normal is not of unit length: {point:?}"));
        }
    }
    for tangent in [point.dpdu, point.dpdv] {
        if regular && tangent.dot(point.normal).abs() > 1e-7 * tangent.length() {
            return Err(format!("a tangent leaves the tangent plane: {point:?}"));
        }
    }
    Ok(())
}

/// Derivative of `f` by central differences of fourth order.
pub fn difference(f: impl Fn(f64) -> DVec3, h: f64) -> DVec3 {
    ((f(h) - f(-h)) * 8.0 - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h)
}

/// Both tangents at `uv` by differences of the parameterization.
pub fn tangents(position: &dyn Fn(DVec2) -> DVec3, uv: DVec2) -> [DVec3; 2] {
    // Rounding 1e-12, truncation below 1e-12 for one turn of a circle: ((2 pi)^5 h^4 / 30).
    let h = 1e-4;
    [DVec2::X, DVec2::Y].map(|axis| difference(|s| position(uv + axis * s), h))
}

fn check_derivatives(case: &ContractCase, hit: &Hit, point: &SurfacePoint) -> Result<(), String> {
    let Some(position) = case.position.as_deref() else { return Ok(()) };
    // Far out on an infinite surface the parameters have too few digits for differences; at a degenerate point they may belong to
    // another point.
    if point.position.distance(case.center) > 2.0 * case.size
        || case.distance_to_degenerate(point.position) < 1e-12 * case.size
    {
        return Ok(());
    }
    let there = position(point.uv);
    if there.distance(point.position) > 1e-9 * case.size {
        return Err(format!("the parameters belong to {there:?}: {point:?}"));
    }
    if case.distance_to_degenerate(point.position) < 0.2 * case.size {
        return Ok(());
    }
    let [du, dv] = tangents(position, point.uv);
    for (what, expected, found) in [("dpdu", du, point.dpdu), ("dpdv", dv, point.dpdv)] {
        if expected.distance(found) > 1e-7 * (expected.length() + case.size) {
            return Err(format!("{what} should be {expected:?}: {point:?}"));
        }
    }
    let orientation = du.cross(dv).dot(point.normal).signum();
    let normal = |uv: DVec2| {
        let [a, b] = tangents(position, uv);
        a.cross(b).normalize() * orientation
    };
    let [dndu, dndv] = case.surface.normal_derivatives(hit, point);
    for (what, axis, found) in [("dndu", DVec2::X, dndu), ("dndv", DVec2::Y, dndv)] {
        let expected = difference(|s| normal(point.uv + axis * s), 1e-3);
        if expected.distance(found) > 1e-4 * (expected.length() + 1.0) {
            return Err(format!("{what} should be {expected:?}: {point:?}"));
        }
    }
    Ok(())
}

/// Checks that the surface reports the roots of the reference solver.
fn check_roots(case: &ContractCase, ray: &Ray, hits: &[Hit]) -> Result<(), String> {
    // A ray that starts on the surface up to rounding may or may not hit it at once.
    let height = (case.implicit)(ray.origin).abs() / case.gradient(ray.origin).length();
    let starts_on_surface =
        !(height > 1e-9 * case.size) || case.distance_to_singular(ray.origin) < 1e-5 * case.size;
    let beyond = if starts_on_surface { 1e-6 * case.size } else { 0.0 };
    compare(case, ray, hits, &solver::roots(case, ray, beyond, &claimed(hits)), beyond)
}

fn claimed(hits: &[Hit]) -> Vec<f64> {
    hits.iter().map(|h| h.t).collect()
}

fn compare(
    case: &ContractCase,
    ray: &Ray,
    hits: &[Hit],
    found: &ReferenceRoots,
    beyond: f64,
) -> Result<(), String> {
    let length = ray.direction.length();
    let counted: Vec<&Hit> = hits
        .iter()
        .filter(|h| h.t * length > beyond && ray.at(h.t).distance(case.center) < 1.05 * case.size)
        .collect();
    for root in found.roots.iter().filter(|r| r.status == RootStatus::Hit) {
        if !counted.iter().any(|h| (h.t - root.t).abs() * length <= 2.0 * root.tolerance) {
            return Err(format!("the root {root:?} is missing in {hits:?}"));
        }
    }
    let sure = !found.near_miss && found.roots.iter().all(|r| r.status != RootStatus::Undecided);
    let expected = found.roots.iter().filter(|r| r.status == RootStatus::Hit).count();
    if sure && counted.len() != expected {
        return Err(format!("{hits:?} should be {:?}", found.roots));
    }
    Ok(())
}

/// Checks that a ray started by `offset_origin` does not hit its own point, and hits everything else.
fn check_spawned(case: &ContractCase, point: &SurfacePoint, pcg: &mut Pcg) -> Result<(), String> {
    let mut direction = pcg.direction();
    while direction.dot(point.normal).abs() < 0.01 {
        direction = pcg.direction();
    }
    let origin = offset_origin(point.position, point.error, point.normal, direction);
    let spawned = Ray::new(origin, direction * 10_f64.powf(pcg.between(-3.0, 3.0)));
    let length = spawned.direction.length();
    let mut hits = Vec::new();
    case.surface.all_hits(&spawned, f64::INFINITY, &mut hits);
    let rises = case.gradient(point.position).dot(direction);
    if case.convex && rises > 0.0 && !hits.is_empty() {
        return Err(format!("a ray that leaves meets {hits:?}: {spawned:?} from {point:?}"));
    }
    // After 1e-7 of the size, the sign shows whether another sheet lies between.
    let near = 1e-7 * case.size;
    let there = (case.implicit)(origin + direction * near);
    if there * rises <= 0.0 {
        return Ok(());
    }
    if hits.iter().any(|h| h.t * length < near) {
        return Err(format!("a spawned ray meets its own point {hits:?}: {spawned:?} from {point:?}"));
    }
    for hit in &hits {
        check_point(case, &spawned, hit, &case.surface.point(&spawned, hit))?;
    }
    compare(case, &spawned, &hits, &solver::roots(case, &spawned, near, &claimed(&hits)), near)
        .map_err(|what| format!("spawned {spawned:?} from {point:?}: {what}"))
}
