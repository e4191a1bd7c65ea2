//! Compares the hits of the library with the reference, ray by ray.

use std::f64::consts::TAU;

use glanz_geometry::{Hit, RaySurface};
use glanz_math::{DVec3, Ray};

use super::animal::Animal;
use super::reference::{Found, Place, Zone, solve};

/// What can be wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A root that every ray next to this one has is not there.
    Missed,
    /// A root is there more than once.
    Doubled,
    /// A hit where no ray next to this one has a root.
    Invented,
    /// More than 1e-9 of the size off the surface or off the ray.
    Position,
    /// More than 1e-7 off the normal.
    Normal,
    /// `intersect`, `occluded` and `all_hits` tell different things.
    Queries,
}

impl Fault {
    pub const ALL: [Self; 6] =
        [Self::Missed, Self::Doubled, Self::Invented, Self::Position, Self::Normal, Self::Queries];
}

/// What was seen at one ray.
#[derive(Default)]
pub struct Verdict {
    pub faults: Vec<(Fault, String)>,
    /// Largest errors, of the size and of the unit normal.
    pub position: f64,
    pub normal: f64,
    /// Certified roots ahead and inside; groups of what is at a border or in a cluster.
    pub roots: u64,
    pub groups: u64,
}

/// Parameters by which a hit may be off its box: roundings of u and v themselves.
const LAST_BITS: f64 = 4.0 * f64::EPSILON;

/// Rays around one that is too close to call, and how many thicknesses they are off.
const NEIGHBOURS: usize = 8;
const NEIGHBOUR_DISTANCE: f64 = 1024.0;

/// By how much a ray is taken thinner to tell roots apart that are not to be told apart for certain.
const FINER: f64 = 64.0;

/// What is this close, of the size along the ray, may be one place: a ray that misses a tangency by `NEIGHBOUR_DISTANCE`
/// thicknesses has its roots a hundred-thousandth of the radius of curvature apart.
const ONE_PLACE: f64 = 1e-4;

struct Case<'a> {
    animal: &'a Animal,
    ray: &'a Ray,
    /// Metres per unit of t.
    length: f64,
    thickness: f64,
}

/// Something that may or may not be a root.
struct Group<'a> {
    members: Vec<&'a Place>,
    /// Metres along the ray.
    from: f64,
    to: f64,
}

impl Case<'_> {
    fn range(&self, place: &Place) -> [f64; 2] {
        [place.t.low * self.length, place.t.high * self.length]
    }

    fn ahead(&self, place: &Place) -> bool {
        self.range(place)[0] > 4.0 * self.thickness
    }

    fn behind(&self, place: &Place) -> bool {
        self.range(place)[1] < -4.0 * self.thickness
    }

    fn holds(&self, place: &Place, hit: &Hit) -> bool {
        let [low, high] = self.range(place);
        let s = hit.t * self.length;
        let along = 1e-9 * self.animal.size;
        hit.face as usize == place.patch
            && place.u.widened(LAST_BITS).contains(hit.u)
            && place.v.widened(LAST_BITS).contains(hit.v)
            && low - along <= s
            && s <= high + along
    }

    /// Everything unclear and not behind, joined where it may be one place.
    fn groups<'a>(&self, unclear: impl Iterator<Item = &'a Place>) -> Vec<Group<'a>> {
        let mut sorted: Vec<&Place> = unclear.filter(|place| !self.behind(place)).collect();
        sorted.sort_by(|a, b| a.t.low.total_cmp(&b.t.low));
        let mut groups: Vec<Group<'_>> = Vec::new();
        for place in sorted {
            let [from, to] = self.range(place);
            match groups.last_mut() {
                Some(last) if from <= last.to + 1e-9 * self.animal.size => {
                    last.members.push(place);
                    last.to = last.to.max(to);
                }
                _ => groups.push(Group { members: vec![place], from, to }),
            }
        }
        groups
    }

    /// How many roots the rays around this one have at the place of `group`, beside those that are certified of this one: at
    /// least, and at most.
    fn around(&self, group: &Group<'_>, found: &Found) -> [usize; 2] {
        let margin = ONE_PLACE * self.animal.size;
        let there = |place: &Place| {
            let [from, to] = self.range(place);
            from <= group.to + margin && to >= group.from - margin
        };
        let inside = |found: &Found| {
            found.roots.iter().filter(|(place, zone)| *zone == Zone::Inside && there(place)).count()
        };
        let own = inside(found);
        let (x, y) = self.ray.direction.normalize().any_orthonormal_pair();
        let mut range = [usize::MAX, 0];
        for k in 0..NEIGHBOURS {
            let (sin, cos) = (TAU * (k as f64 + 0.37) / NEIGHBOURS as f64).sin_cos();
            let moved = (x * cos + y * sin) * (NEIGHBOUR_DISTANCE * self.thickness);
            let neighbour = Ray::new(self.ray.origin + moved, self.ray.direction);
            let near = solve(&self.animal.patches, &neighbour, self.thickness);
            let certain = inside(&near).saturating_sub(own);
            let unclear = near.roots.iter().filter(|(place, zone)| *zone == Zone::Border && there(place));
            let unclear = unclear.count() + near.clusters.iter().filter(|place| there(place)).count();
            range = [range[0].min(certain), range[1].max(certain + unclear)];
        }
        range
    }

    /// How many roots there may be at the place of `group` for this very ray, if rounding is left out but for that of the
    /// reference itself.
    fn finely(&self, group: &Group<'_>) -> usize {
        let found = solve(&self.animal.patches, self.ray, self.thickness / FINER);
        let there = |place: &Place| {
            let [from, to] = self.range(place);
            from <= group.to && to >= group.from
        };
        let roots: Vec<_> = found.roots.iter().map(|(place, _)| place).filter(|place| there(place)).collect();
        let clusters: Vec<_> = found.clusters.iter().filter(|place| there(place)).collect();
        roots.len() + separate(&clusters)
    }
}

/// How many boxes there are that do not overlap, chains of them being one.
fn separate(boxes: &[&Place]) -> usize {
    let touch = |a: &Place, b: &Place| a.patch == b.patch && a.u.overlaps(b.u) && a.v.overlaps(b.v);
    let mut open: Vec<&Place> = boxes.to_vec();
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

/// The verdict about one ray whose hits the library says to be `hits`.
pub fn judge(animal: &Animal, ray: &Ray, hits: &[Hit], found: &Found) -> Verdict {
    let case = Case { animal, ray, length: ray.direction.length(), thickness: animal.thickness(ray) };
    let mut verdict = Verdict::default();
    let mut used = vec![false; hits.len()];
    let mut fault = |fault, what: String| verdict.faults.push((fault, what));
    for (place, _) in found.roots.iter().filter(|(place, zone)| *zone == Zone::Inside && case.ahead(place)) {
        verdict.roots += 1;
        let mut count = 0;
        for (used, _) in used.iter_mut().zip(hits).filter(|(_, hit)| case.holds(place, hit)) {
            count += 1;
            *used = true;
        }
        match count {
            0 => fault(Fault::Missed, format!("the root {place:?}")),
            1 => {}
            _ => fault(Fault::Doubled, format!("the root {place:?}")),
        }
    }
    let at_start = |zone: Zone, place: &Place| zone == Zone::Border || !case.ahead(place);
    let unclear = found.roots.iter().filter(|(place, zone)| at_start(*zone, place)).map(|(place, _)| place);
    let groups = case.groups(unclear.chain(&found.clusters));
    verdict.groups += groups.len() as u64;
    for group in &groups {
        let mut own = Vec::new();
        for (used, hit) in used.iter_mut().zip(hits).filter(|(used, _)| !**used) {
            if group.members.iter().any(|place| case.holds(place, hit)) {
                *used = true;
                own.push(*hit);
            }
        }
        if own.len() != 1 {
            let started = group.from <= 4.0 * case.thickness;
            let [least, most] = case.around(group, found);
            let tell = || format!("{} to {most} at {:?}: {own:?}", least, group.members[0]);
            if own.len() < least && !started {
                fault(Fault::Missed, tell());
            } else if own.len() > most.max(1).max(case.finely(group)) || twins(&own) {
                fault(Fault::Doubled, tell());
            }
        }
    }
    for (hit, _) in hits.iter().zip(&used).filter(|(_, used)| !**used) {
        fault(Fault::Invented, format!("{hit:?}"));
    }
    measure(&case, hits, &mut verdict);
    queries(&case, hits, &mut verdict);
    verdict
}

/// Whether two hits have the same parameters but for rounding.
fn twins(hits: &[Hit]) -> bool {
    let same = |a: &Hit, b: &Hit| a.face == b.face && (a.u - b.u).abs().max((a.v - b.v).abs()) < 1e-12;
    hits.iter().enumerate().any(|(k, a)| hits[..k].iter().any(|b| same(a, b)))
}

fn measure(case: &Case<'_>, hits: &[Hit], verdict: &mut Verdict) {
    let Case { animal, ray, .. } = case;
    for hit in hits {
        let Some(patch) = animal.patches.get(hit.face as usize) else { continue };
        let [s, su, sv] = patch.tangent(hit.u, hit.v);
        let point = animal.surface.point(ray, hit);
        let off_surface = point.position.distance(s);
        let off_ray = (s - ray.origin).cross(ray.direction).length() / case.length;
        let off_place = s.distance(ray.at(hit.t));
        let off = off_surface.max(off_ray).max(off_place) / animal.size;
        verdict.position = verdict.position.max(off);
        if !(off < 1e-9) {
            let what = format!("{hit:?}: {off_surface:e} {off_ray:e} {off_place:e} m");
            verdict.faults.push((Fault::Position, what));
        }
        let n = su.cross(sv);
        // Elsewhere the surface has no normal, or f64 has not enough digits of it.
        if n.length() > 1e-6 * animal.size * animal.size {
            let off = normal_error(point.normal, n.normalize(), animal.oriented);
            verdict.normal = verdict.normal.max(off);
            if !(off < 1e-7) {
                verdict.faults.push((Fault::Normal, format!("{hit:?}: {off:e}")));
            }
        }
    }
}

fn normal_error(found: DVec3, expected: DVec3, oriented: bool) -> f64 {
    let side = if oriented || found.dot(expected) > 0.0 { 1.0 } else { -1.0 };
    found.distance(expected * side)
}

fn queries(case: &Case<'_>, hits: &[Hit], verdict: &mut Verdict) {
    let Case { animal, ray, .. } = case;
    let first = animal.surface.intersect(ray, f64::INFINITY);
    let agree = match (first, hits.first()) {
        (None, None) => true,
        (Some(found), Some(first)) => found.t == first.t && hits.contains(&found),
        _ => false,
    };
    if !agree {
        verdict.faults.push((Fault::Queries, format!("intersect gives {first:?}, all_hits {hits:?}")));
    }
    let occluded = animal.surface.occluded(ray, f64::INFINITY);
    if occluded != first.is_some() {
        verdict.faults.push((Fault::Queries, format!("occluded gives {occluded}, intersect {first:?}")));
    }
}
