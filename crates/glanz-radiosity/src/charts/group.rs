//! Flat faces that share a chart.

use std::collections::HashMap;

use glanz_geometry::FaceDomain;
use glanz_math::{DVec2, DVec3, Frame};
use glanz_scene::PlacedSurface;

use super::flat::{Flat, FlatTriangle};

/// Cosines of the angles between the first face of a chart and the others, tried one after the other until nothing overlaps: 31 and
/// 0.1 degrees.
const COSINES: [f64; 2] = [0.857_167_300_702, 0.999_998_5];

/// Edges at most that are tried as directions of a chart's sides.
const EDGES: usize = 256;

/// Places per side at which overlap is looked for.
const LOOK: u32 = 128;

/// A flat face in the world.
struct Face {
    face: u32,
    shape: u32,
    normal: DVec3,
    parameters: Vec<DVec2>,
    corners: Vec<DVec3>,
}

/// Groups of `faces` of a surface, which are polygons, each laid flat.
pub(super) fn groups(surface: &PlacedSurface<'_>, faces: &[u32]) -> Vec<Flat> {
    let faces: Vec<Face> = faces.iter().filter_map(|&face| Face::new(surface, face)).collect();
    let neighbours = neighbours(&faces);
    let all: Vec<usize> = (0..faces.len()).collect();
    let mut flat = Vec::new();
    for group in grown(&faces, &neighbours, &all, COSINES[0]) {
        let laid = lay(&faces, &group);
        if !overlaps(&laid) {
            flat.push(laid);
            continue;
        }
        for group in grown(&faces, &neighbours, &group, COSINES[1]) {
            let laid = lay(&faces, &group);
            if overlaps(&laid) {
                flat.extend(group.iter().map(|&face| lay(&faces, &[face])));
            } else {
                flat.push(laid);
            }
        }
    }
    flat
}

impl Face {
    /// `None` for one without area, or of which trimming leaves nothing.
    fn new(surface: &PlacedSurface<'_>, face: u32) -> Option<Self> {
        let FaceDomain::Polygon(parameters) = surface.face_domain(face) else { return None };
        let at = |uv: DVec2| surface.at(face, uv, false).map(|at| at.at.point.position);
        let of_corners: Option<Vec<DVec3>> = parameters.iter().map(|&uv| at(uv)).collect();
        let corners = match of_corners {
            Some(corners) => corners,
            None => extrapolated(&parameters, at)?,
        };
        let spans = |i: usize| (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]);
        let area: DVec3 = (1..corners.len().checked_sub(1)?).map(spans).sum();
        let normal = area.try_normalize()?;
        Some(Self { face, shape: surface.shape(face), normal, parameters, corners })
    }
}

/// Corners of a flat face of which only a part is there: the map from parameters is affine.
fn extrapolated(parameters: &[DVec2], at: impl Fn(DVec2) -> Option<DVec3>) -> Option<Vec<DVec3>> {
    let middle = parameters.iter().copied().sum::<DVec2>() / parameters.len() as f64;
    let n = 24;
    let mut kept: Vec<(DVec2, DVec3)> = Vec::new();
    for pair in parameters.iter().zip(parameters.iter().cycle().skip(1)) {
        for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
            let (a, b) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
            let uv = middle + a * (*pair.0 - middle) + b * (*pair.1 - middle);
            kept.extend(at(uv).map(|position| (uv, position)));
        }
    }
    let &(o, origin) = kept.first()?;
    let far = |&&(uv, _): &&(DVec2, DVec3)| uv.distance_squared(o);
    let &(a, a_at) = kept.iter().max_by(|x, y| far(x).total_cmp(&far(y)))?;
    let beside = |&&(uv, _): &&(DVec2, DVec3)| (uv - o).perp_dot(a - o).abs();
    let &(b, b_at) = kept.iter().max_by(|x, y| beside(x).total_cmp(&beside(y)))?;
    let area = (a - o).perp_dot(b - o);
    let map = |uv: DVec2| {
        let (s, t) = ((uv - o).perp_dot(b - o) / area, (a - o).perp_dot(uv - o) / area);
        origin + s * (a_at - origin) + t * (b_at - origin)
    };
    (area != 0.0).then(|| parameters.iter().map(|&uv| map(uv)).collect())
}

/// For each face those that share an edge with it and belong to the same shape.
fn neighbours(faces: &[Face]) -> Vec<Vec<usize>> {
    let key = |p: DVec3| (p + 0.0).to_array().map(f64::to_bits);
    let mut edges: HashMap<[[u64; 3]; 2], Vec<usize>> = HashMap::new();
    for (number, face) in faces.iter().enumerate() {
        for (&a, &b) in face.corners.iter().zip(face.corners.iter().cycle().skip(1)) {
            let (a, b) = (key(a), key(b));
            edges.entry(if a < b { [a, b] } else { [b, a] }).or_default().push(number);
        }
    }
    let mut neighbours = vec![Vec::new(); faces.len()];
    for sharing in edges.values() {
        for &a in sharing {
            let others = sharing.iter().filter(|&&b| b != a && faces[b].shape == faces[a].shape);
            neighbours[a].extend(others.copied());
        }
    }
    for list in &mut neighbours {
        list.sort_unstable();
    }
    neighbours
}

/// Connected groups of `members` whose normals are within an angle of that of their first one.
fn grown(faces: &[Face], neighbours: &[Vec<usize>], members: &[usize], cosine: f64) -> Vec<Vec<usize>> {
    let mut free = vec![false; faces.len()];
    for &member in members {
        free[member] = true;
    }
    let mut groups = Vec::new();
    for &seed in members {
        if !std::mem::take(&mut free[seed]) {
            continue;
        }
        let mut group = vec![seed];
        let mut next = 0;
        while let Some(&face) = group.get(next) {
            next += 1;
            for &other in &neighbours[face] {
                if free[other] && faces[other].normal.dot(faces[seed].normal) >= cosine {
                    free[other] = false;
                    group.push(other);
                }
            }
        }
        groups.push(group);
    }
    groups
}

/// The faces seen along the normal of the first, turned so that they fill their box best.
fn lay(faces: &[Face], group: &[usize]) -> Flat {
    let normal = faces[group[0]].normal;
    let frame = Frame::from_z(normal);
    let flat = |p: DVec3| frame.to_local(p - faces[group[0]].corners[0]).truncate();
    let mut triangles = Vec::new();
    let mut edges: Vec<DVec2> = Vec::new();
    for face in group.iter().map(|&i| &faces[i]) {
        let corners: Vec<DVec2> = face.corners.iter().map(|&p| flat(p)).collect();
        for i in 1..corners.len() - 1 {
            let pick = |list: &[DVec2]| [list[0], list[i], list[i + 1]];
            triangles.push(FlatTriangle {
                face: face.face,
                corners: pick(&corners),
                parameters: pick(&face.parameters),
            });
        }
        if edges.len() < EDGES {
            let ends = corners.iter().zip(corners.iter().cycle().skip(1));
            edges.extend(ends.filter_map(|(&a, &b)| (b - a).try_normalize()));
        }
    }
    let room = |&along: &DVec2| {
        let (low, high) = triangles
            .iter()
            .flat_map(|t| t.corners)
            .map(|p| DVec2::new(p.dot(along), along.perp_dot(p)))
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
        (high - low).element_product()
    };
    let best = edges.iter().copied().min_by(|a, b| room(a).total_cmp(&room(b))).unwrap_or(DVec2::X);
    for triangle in &mut triangles {
        triangle.corners = triangle.corners.map(|p| DVec2::new(p.dot(best), best.perp_dot(p)));
    }
    let shrink = group.iter().map(|&i| faces[i].normal.dot(normal)).fold(1.0, f64::min);
    Flat::new(triangles, shrink)
}

/// Whether a point lies within two triangles.
fn overlaps(flat: &Flat) -> bool {
    if flat.triangles().len() < 2 {
        return false;
    }
    let places = (0..LOOK).flat_map(|i| (0..LOOK).map(move |j| (i, j)));
    places.into_iter().any(|(i, j)| {
        // Off any line that corners may lie on.
        let share = DVec2::new(f64::from(i) + 0.437, f64::from(j) + 0.561) / f64::from(LOOK);
        flat.holders(share * flat.size()).nth(1).is_some()
    })
}
