//! Groups of flat faces that share a chart.

use std::collections::HashMap;

use glanz_geometry::FaceDomain;
use glanz_math::{DVec2, DVec3, Frame};
use glanz_scene::PlacedSurface;

use super::flat_sheet::{FlatSheet, FlatTriangle};

/// Cosines of the largest angles between the first face of a group and the others, 31 and 0.1 degrees, tried in turn until nothing
/// overlaps.
const ANGLE_COSINES: [f64; 2] = [0.857_167_300_702, 0.999_998_5];

/// Largest number of edges that are tried as directions of a chart's sides.
const MAX_EDGES: usize = 256;

/// Largest number of faces that share an edge and are neighbours there: pairs of more would take too much memory.
const MAX_SHARING: usize = 64;

/// Points per side at which overlap is tested.
const OVERLAP_POINTS: u32 = 128;

/// A flat face in space.
struct ChartFace {
    face: u32,
    shape: u32,
    normal: DVec3,
    parameters: Vec<DVec2>,
    corners: Vec<DVec3>,
}

/// Groups of polygonal faces of a surface, each projected onto a plane.
pub(super) fn groups(surface: &PlacedSurface<'_>, faces: &[u32]) -> Vec<FlatSheet> {
    let faces: Vec<ChartFace> = faces.iter().filter_map(|&face| ChartFace::new(surface, face)).collect();
    let neighbours = neighbours(&faces);
    let all: Vec<usize> = (0..faces.len()).collect();
    let mut flat = Vec::new();
    for group in grow_groups(&faces, &neighbours, &all, ANGLE_COSINES[0]) {
        let sheet = project(&faces, &group);
        if !overlaps(&sheet) {
            flat.push(sheet);
            continue;
        }
        for group in grow_groups(&faces, &neighbours, &group, ANGLE_COSINES[1]) {
            let sheet = project(&faces, &group);
            if overlaps(&sheet) {
                flat.extend(group.iter().map(|&face| project(&faces, &[face])));
            } else {
                flat.push(sheet);
            }
        }
    }
    flat
}

impl ChartFace {
    /// `None` for a face without area, or of which trimming leaves nothing.
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

/// Corners of a flat face that is partly trimmed away, by its affine map from parameters.
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

/// Numbers of the faces of the same shape that share an edge with each face.
fn neighbours(faces: &[ChartFace]) -> Vec<Vec<usize>> {
    let key = |p: DVec3| (p + 0.0).to_array().map(f64::to_bits);
    let mut edges: HashMap<[[u64; 3]; 2], Vec<usize>> = HashMap::new();
    for (number, face) in faces.iter().enumerate() {
        for (&a, &b) in face.corners.iter().zip(face.corners.iter().cycle().skip(1)) {
            let (a, b) = (key(a), key(b));
            edges.entry(if a < b { [a, b] } else { [b, a] }).or_default().push(number);
        }
    }
    let mut neighbours = vec![Vec::new(); faces.len()];
    for sharing in edges.values().filter(|sharing| sharing.len() <= MAX_SHARING) {
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

/// Connected groups of `members` whose normals are within an angle of that of the first one of their group.
fn grow_groups(
    faces: &[ChartFace],
    neighbours: &[Vec<usize>],
    members: &[usize],
    cosine: f64,
) -> Vec<Vec<usize>> {
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

/// Projects the faces along the normal of the first one, rotated so that their bounds are smallest.
fn project(faces: &[ChartFace], group: &[usize]) -> FlatSheet {
    let normal = faces[group[0]].normal;
    let frame = Frame::from_z(normal);
    let to_plane = |p: DVec3| frame.to_local(p - faces[group[0]].corners[0]).truncate();
    let mut triangles = Vec::new();
    let mut edges: Vec<DVec2> = Vec::new();
    for face in group.iter().map(|&i| &faces[i]) {
        let corners: Vec<DVec2> = face.corners.iter().map(|&p| to_plane(p)).collect();
        for i in 1..corners.len() - 1 {
            let pick = |list: &[DVec2]| [list[0], list[i], list[i + 1]];
            triangles.push(FlatTriangle {
                face: face.face,
                corners: pick(&corners),
                parameters: pick(&face.parameters),
            });
        }
        if edges.len() < MAX_EDGES {
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
    FlatSheet::new(triangles, shrink)
}

/// Whether a point lies within two triangles.
fn overlaps(flat: &FlatSheet) -> bool {
    if flat.triangles().len() < 2 {
        return false;
    }
    let places = (0..OVERLAP_POINTS).flat_map(|i| (0..OVERLAP_POINTS).map(move |j| (i, j)));
    places.into_iter().any(|(i, j)| {
        // Irregular offsets avoid lines through corners.
        let share = DVec2::new(f64::from(i) + 0.437, f64::from(j) + 0.561) / f64::from(OVERLAP_POINTS);
        flat.triangles_at(share * flat.size()).nth(1).is_some()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edge_of_many_faces_makes_few_neighbours() {
        let face = |face: u32| {
            let corners = vec![DVec3::ZERO, DVec3::Z, DVec3::new(1.0, f64::from(face), 0.0)];
            ChartFace { face, shape: 0, normal: DVec3::Y, parameters: Vec::new(), corners }
        };
        let count =
            |n: u32| neighbours(&(0..n).map(face).collect::<Vec<_>>()).iter().map(Vec::len).sum::<usize>();
        assert_eq!((count(2), count(3)), (2, 6));
        assert!(count(2000) <= 2000 * MAX_SHARING);
    }
}
