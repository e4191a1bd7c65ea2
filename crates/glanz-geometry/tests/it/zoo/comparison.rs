//! Compares the hits of the library with the reference, ray by ray.

use std::f64::consts::TAU;

use glanz_geometry::{Hit, RaySurface};
use glanz_math::{DVec3, Ray};

use super::reference::{DomainRelation, IsolatedRoots, RootBox, solve};
use super::test_surface::TestSurface;

/// Faults of the hits of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HitFault {
    /// A root that every neighbouring ray has is missing.
    Missed,
    /// A root is reported more than once.
    Doubled,
    /// A hit where no neighbouring ray has a root.
    Invented,
    /// A hit is off the surface or the ray by more than 1e-9 of the size.
    Position,
    /// The unit normal is off by more than 1e-7.
    Normal,
    /// `intersect`, `occluded` and `all_hits` disagree.
    Queries,
}

impl HitFault {
    pub const ALL: [Self; 6] =
        [Self::Missed, Self::Doubled, Self::Invented, Self::Position, Self::Normal, Self::Queries];
}

/// Comparison of the hits of one ray with the reference.
#[derive(Default)]
pub struct RayComparison {
    pub faults: Vec<(HitFault, String)>,
    /// Largest error of a position, relative to the size, and of a unit normal.
    pub position: f64,
    pub normal: f64,
    /// Number of certified roots in front of the origin and inside the domain, and of groups of all other boxes.
    pub roots: u64,
    pub groups: u64,
}

/// Largest distance of a hit's parameters from the box of its root: the rounding of u and v themselves.
const LAST_BITS: f64 = 4.0 * f64::EPSILON;

/// Number of rays around one with an uncertain root, and their distance from it in thicknesses.
const NEIGHBOURS: usize = 8;
const NEIGHBOUR_DISTANCE: f64 = 1024.0;

/// Divisor of the thickness for separating roots that cannot be separated with certainty.
const FINER: f64 = 64.0;

/// Distance along the ray, relative to the size, within which roots may be one: a ray that misses a tangency by `NEIGHBOUR_DISTANCE`
/// thicknesses has its roots a hundred-thousandth of the radius of curvature apart.
const SAME_ROOT: f64 = 1e-4;

struct ComparedRay<'a> {
    tested: &'a TestSurface,
    ray: &'a Ray,
    /// Metres per unit of t.
    length: f64,
    thickness: f64,
}

/// Boxes that may contain a root, close together along the ray.
struct RootGroup<'a> {
    members: Vec<&'a RootBox>,
    /// Metres along the ray.
    from: f64,
    to: f64,
}

impl ComparedRay<'_> {
    fn range(&self, bounds: &RootBox) -> [f64; 2] {
        [bounds.t.low * self.length, bounds.t.high * self.length]
    }

    fn ahead(&self, bounds: &RootBox) -> bool {
        self.range(bounds)[0] > 4.0 * self.thickness
    }

    fn behind(&self, bounds: &RootBox) -> bool {
        self.range(bounds)[1] < -4.0 * self.thickness
    }

    fn holds(&self, bounds: &RootBox, hit: &Hit) -> bool {
        let [low, high] = self.range(bounds);
        let s = hit.t * self.length;
        let along = 1e-9 * self.tested.size;
        hit.face as usize == bounds.patch
            && bounds.u.widened(LAST_BITS).contains(hit.u)
            && bounds.v.widened(LAST_BITS).contains(hit.v)
            && low - along <= s
            && s <= high + along
    }

    /// Groups of the uncertain boxes that are not behind the origin, joined where they overlap along the ray.
    fn groups<'a>(&self, unclear: impl Iterator<Item = &'a RootBox>) -> Vec<RootGroup<'a>> {
        let mut sorted: Vec<&RootBox> = unclear.filter(|bounds| !self.behind(bounds)).collect();
        sorted.sort_by(|a, b| a.t.low.total_cmp(&b.t.low));
        let mut groups: Vec<RootGroup<'_>> = Vec::new();
        for bounds in sorted {
            let [from, to] = self.range(bounds);
            match groups.last_mut() {
                Some(last) if from <= last.to + 1e-9 * self.tested.size => {
                    last.members.push(bounds);
                    last.to = last.to.max(to);
                }
                _ => groups.push(RootGroup { members: vec![bounds], from, to }),
            }
        }
        groups
    }

    /// Smallest and largest number of roots that neighbouring rays have near `group`, besides those certified for this ray.
    fn neighbour_counts(&self, group: &RootGroup<'_>, found: &IsolatedRoots) -> [usize; 2] {
        let margin = SAME_ROOT * self.tested.size;
        let there = |bounds: &RootBox| {
            let [from, to] = self.range(bounds);
            from <= group.to + margin && to >= group.from - margin
        };
        let inside = |found: &IsolatedRoots| {
            found
                .roots
                .iter()
                .filter(|(bounds, relation)| *relation == DomainRelation::Inside && there(bounds))
                .count()
        };
        let own = inside(found);
        let (x, y) = self.ray.direction.normalize().any_orthonormal_pair();
        let mut range = [usize::MAX, 0];
        for k in 0..NEIGHBOURS {
            let (sin, cos) = (TAU * (k as f64 + 0.37) / NEIGHBOURS as f64).sin_cos();
            let moved = (x * cos + y * sin) * (NEIGHBOUR_DISTANCE * self.thickness);
            let neighbour = Ray::new(self.ray.origin + moved, self.ray.direction);
            let near = solve(&self.tested.patches, &neighbour, self.thickness);
            let certain = inside(&near).saturating_sub(own);
            let unclear = near
                .roots
                .iter()
                .filter(|(bounds, relation)| *relation == DomainRelation::Border && there(bounds));
            let unclear = unclear.count() + near.clusters.iter().filter(|bounds| there(bounds)).count();
            range = [range[0].min(certain), range[1].max(certain + unclear)];
        }
        range
    }

    /// Largest number of roots of this ray in `group`, with a thickness that covers little more than the rounding of the
    /// reference.
    fn largest_count(&self, group: &RootGroup<'_>) -> usize {
        let found = solve(&self.tested.patches, self.ray, self.thickness / FINER);
        let there = |bounds: &RootBox| {
            let [from, to] = self.range(bounds);
            from <= group.to && to >= group.from
        };
        let roots: Vec<_> =
            found.roots.iter().map(|(bounds, _)| bounds).filter(|bounds| there(bounds)).collect();
        let clusters: Vec<_> = found.clusters.iter().filter(|bounds| there(bounds)).collect();
        roots.len() + count_chains(&clusters)
    }
}

/// Number of chains of overlapping boxes.
fn count_chains(boxes: &[&RootBox]) -> usize {
    let touch = |a: &RootBox, b: &RootBox| a.patch == b.patch && a.u.overlaps(b.u) && a.v.overlaps(b.v);
    let mut open: Vec<&RootBox> = boxes.to_vec();
    let mut count = 0;
    while let Some(first) = open.pop() {
        count += 1;
        let mut chain = vec![first];
        while let Some(link) = chain.pop() {
            let (near, far) = open.into_iter().partition(|other| touch(link, other));
            open = far;
            chain.extend::<Vec<_>>(near);
        }
    }
    count
}

/// Compares the `hits` of the library for one ray with the reference.
pub fn compare(tested: &TestSurface, ray: &Ray, hits: &[Hit], found: &IsolatedRoots) -> RayComparison {
    let case = ComparedRay { tested, ray, length: ray.direction.length(), thickness: tested.thickness(ray) };
    let mut comparison = RayComparison::default();
    let mut used = vec![false; hits.len()];
    let mut fault = |fault, what: String| comparison.faults.push((fault, what));
    for (bounds, _) in found
        .roots
        .iter()
        .filter(|(bounds, relation)| *relation == DomainRelation::Inside && case.ahead(bounds))
    {
        comparison.roots += 1;
        let mut count = 0;
        for (used, _) in used.iter_mut().zip(hits).filter(|(_, hit)| case.holds(bounds, hit)) {
            count += 1;
            *used = true;
        }
        match count {
            0 => fault(HitFault::Missed, format!("the root {bounds:?}")),
            1 => {}
            _ => fault(HitFault::Doubled, format!("the root {bounds:?}")),
        }
    }
    let at_start = |relation: DomainRelation, bounds: &RootBox| {
        relation == DomainRelation::Border || !case.ahead(bounds)
    };
    let unclear =
        found.roots.iter().filter(|(bounds, relation)| at_start(*relation, bounds)).map(|(bounds, _)| bounds);
    let groups = case.groups(unclear.chain(&found.clusters));
    comparison.groups += groups.len() as u64;
    for group in &groups {
        let mut own = Vec::new();
        for (used, hit) in used.iter_mut().zip(hits).filter(|(used, _)| !**used) {
            if group.members.iter().any(|bounds| case.holds(bounds, hit)) {
                *used = true;
                own.push(*hit);
            }
        }
        if own.len() != 1 {
            let started = group.from <= 4.0 * case.thickness;
            let [least, most] = case.neighbour_counts(group, found);
            let describe = || format!("{} to {most} at {:?}: {own:?}", least, group.members[0]);
            if own.len() < least && !started {
                fault(HitFault::Missed, describe());
            } else if own.len() > most.max(1).max(case.largest_count(group)) || has_duplicates(&own) {
                fault(HitFault::Doubled, describe());
            }
        }
    }
    for (hit, _) in hits.iter().zip(&used).filter(|(_, used)| !**used) {
        fault(HitFault::Invented, format!("{hit:?}"));
    }
    measure(&case, hits, &mut comparison);
    queries(&case, hits, &mut comparison);
    comparison
}

/// Whether two hits have the same parameters up to rounding.
fn has_duplicates(hits: &[Hit]) -> bool {
    let same = |a: &Hit, b: &Hit| a.face == b.face && (a.u - b.u).abs().max((a.v - b.v).abs()) < 1e-12;
    hits.iter().enumerate().any(|(k, a)| hits[..k].iter().any(|b| same(a, b)))
}

fn measure(case: &ComparedRay<'_>, hits: &[Hit], comparison: &mut RayComparison) {
    let ComparedRay { tested, ray, .. } = case;
    for hit in hits {
        let Some(patch) = tested.patches.get(hit.face as usize) else { continue };
        let [s, su, sv] = patch.tangent(hit.u, hit.v);
        let point = tested.surface.point(ray, hit);
        let off_surface = point.position.distance(s);
        let off_ray = (s - ray.origin).cross(ray.direction).length() / case.length;
        let off_point = s.distance(ray.at(hit.t));
        let off = off_surface.max(off_ray).max(off_point) / tested.size;
        comparison.position = comparison.position.max(off);
        if !(off < 1e-9) {
            let what = format!("{hit:?}: {off_surface:e} {off_ray:e} {off_point:e} m");
            comparison.faults.push((HitFault::Position, what));
        }
        let n = su.cross(sv);
        // Elsewhere the surface has no normal, or f64 has too few digits for it.
        if n.length() > 1e-6 * tested.size * tested.size {
            let off = normal_error(point.normal, n.normalize(), tested.oriented);
            comparison.normal = comparison.normal.max(off);
            if !(off < 1e-7) {
                comparison.faults.push((HitFault::Normal, format!("{hit:?}: {off:e}")));
            }
        }
    }
}

fn normal_error(found: DVec3, expected: DVec3, oriented: bool) -> f64 {
    let side = if oriented || found.dot(expected) > 0.0 { 1.0 } else { -1.0 };
    found.distance(expected * side)
}

fn queries(case: &ComparedRay<'_>, hits: &[Hit], comparison: &mut RayComparison) {
    let ComparedRay { tested, ray, .. } = case;
    let first = tested.surface.intersect(ray, f64::INFINITY);
    let agree = match (first, hits.first()) {
        (None, None) => true,
        (Some(found), Some(first)) => found.t == first.t && hits.contains(&found),
        _ => false,
    };
    if !agree {
        comparison.faults.push((HitFault::Queries, format!("intersect gives {first:?}, all_hits {hits:?}")));
    }
    let occluded = tested.surface.occluded(ray, f64::INFINITY);
    if occluded != first.is_some() {
        comparison
            .faults
            .push((HitFault::Queries, format!("occluded gives {occluded}, intersect {first:?}")));
    }
}
