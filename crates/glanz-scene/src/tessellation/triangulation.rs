//! Triangles of a patch, as close to its surface as the settings demand.
//!
//! # Source
//! The constrained Delaunay triangulation is that of the crate `spade`. Points are added in the middle of edges and triangles that are too far from the
//! surface, as in @chew1993, but the test is the distance from the surface instead of the shape.

use std::collections::{HashMap, HashSet, VecDeque};

use glanz_math::{DVec2, DVec3};
use spade::handles::{FixedVertexHandle, InnerTag};
use spade::{
    ConstrainedDelaunayTriangulation, HasPosition, HierarchyHintGenerator, Point2, PositionInTriangulation,
    Triangulation,
};

use super::grid::{grid_scale, straight_breaks};
use super::outline::Outline;
use super::patch::MeshPatch;
use super::triangle_fit::TriangleFit;
use super::{TessellationFaultKind, TessellationSettings};

/// Largest number of points of a patch.
const MAX_POINTS: usize = 1 << 20;

/// A vertex of the triangulation.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshSite {
    pub(super) uv: DVec2,
    at: Point2<f64>,
    /// The vertex of the group; `None` inside.
    pub(super) vertex: Option<u32>,
    pub(super) point: DVec3,
    pub(super) normal: DVec3,
}

impl HasPosition for MeshSite {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.at
    }
}

type SiteTriangulation = ConstrainedDelaunayTriangulation<MeshSite, (), (), (), HierarchyHintGenerator<f64>>;
pub(super) type SiteFace<'a> = spade::handles::FaceHandle<'a, InnerTag, MeshSite, (), spade::CdtEdge<()>, ()>;

/// The triangulation of the outline of a patch.
pub(super) struct PatchTriangulation {
    sites: SiteTriangulation,
    scale: DVec2,
    /// How much larger the winding number is on the left of an edge, by its ends.
    changes: HashMap<[usize; 2], i32>,
    /// Whether segments of the outline cross.
    pub(super) crosses: bool,
    /// Parameters between which the surface is nearly straight.
    grid: [Vec<f64>; 2],
}

/// The triangles of a patch.
#[derive(Debug, Default)]
pub(super) struct TriangulatedPatch {
    /// Points inside.
    pub(super) inner: Vec<DVec3>,
    /// Vertices with their number in the group, and unit normals; those without number are the points inside, in their order.
    pub(super) vertices: Vec<(Option<u32>, DVec3)>,
    /// Counterclockwise in the parameters.
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) deviation: f64,
    pub(super) fault: Option<TessellationFaultKind>,
}

impl PatchTriangulation {
    /// `positions`: those of the vertices of the group.
    pub(super) fn new(
        patch: &MeshPatch,
        outline: &Outline,
        positions: &[DVec3],
        settings: TessellationSettings,
    ) -> Self {
        let grid = [0, 1].map(|axis| straight_breaks(patch, axis, settings));
        let mut made = Self {
            sites: SiteTriangulation::new(),
            scale: grid_scale(patch, &grid),
            changes: HashMap::new(),
            crosses: false,
            grid,
        };
        let handles: Vec<Option<FixedVertexHandle>> = outline
            .points
            .iter()
            .map(|point| {
                let position = positions.get(point.vertex as usize).copied().unwrap_or(DVec3::NAN);
                let site = made.site(patch, point.uv, Some(point.vertex), position);
                made.sites.insert(site).ok()
            })
            .collect();
        for &[from, to] in &outline.segments {
            let handle = |i: u32| handles.get(i as usize).copied().flatten();
            let (Some(from), Some(to)) = (handle(from), handle(to)) else {
                made.crosses = true;
                continue;
            };
            if from != to {
                made.constrain(from, to);
            }
        }
        made
    }

    fn site(&self, patch: &MeshPatch, uv: DVec2, vertex: Option<u32>, point: DVec3) -> MeshSite {
        let [low, _] = patch.window();
        let at = (uv - low) * self.scale;
        MeshSite { uv, at: Point2::new(at.x, at.y), vertex, point, normal: patch.normal(uv) }
    }

    fn constrain(&mut self, from: FixedVertexHandle, to: FixedVertexHandle) {
        let edges = self.sites.try_add_constraint(from, to);
        self.crosses |= edges.is_empty();
        for edge in edges {
            let edge = self.sites.directed_edge(edge);
            *self.changes.entry([edge.from().index(), edge.to().index()]).or_insert(0) += 1;
        }
    }

    /// Whether each face, by its index, is a part of the patch.
    fn inside(&self, patch: &MeshPatch) -> Vec<bool> {
        let count = self.sites.num_all_faces();
        let Some(trim) = &patch.trim else { return vec![true; count] };
        let middle =
            |face: &SiteFace<'_>| face.vertices().iter().map(|vertex| vertex.data().uv).sum::<DVec2>() / 3.0;
        let mut inside = vec![false; count];
        if self.crosses {
            for face in self.sites.inner_faces() {
                inside[face.index()] = trim.region.contains(middle(&face));
            }
            return inside;
        }
        let largest = self.sites.inner_faces().max_by(|a, b| a.area().total_cmp(&b.area()));
        let Some(start) = largest else { return inside };
        let mut winding: Vec<Option<i32>> = vec![None; count];
        winding[start.index()] = Some(patch.winding(middle(&start)));
        let mut queue = VecDeque::from([start]);
        while let Some(face) = queue.pop_front() {
            let Some(here) = winding[face.index()] else { continue };
            inside[face.index()] = here > 0;
            for edge in face.adjacent_edges() {
                let Some(next) = edge.rev().face().as_inner() else { continue };
                if winding[next.index()].is_none() {
                    let [from, to] = [edge.from().index(), edge.to().index()];
                    let change = |ends: [usize; 2]| self.changes.get(&ends).copied().unwrap_or(0);
                    winding[next.index()] = Some(here - change([from, to]) + change([to, from]));
                    queue.push_back(next);
                }
            }
        }
        inside
    }

    /// Adds points until the triangles are close enough to the surface.
    pub(super) fn fill(mut self, patch: &MeshPatch, settings: TessellationSettings) -> TriangulatedPatch {
        /// Each round halves the triangles that are not close enough.
        const ROUNDS: usize = 40;
        self.add_grid(patch);
        let mut close: HashSet<[usize; 3]> = HashSet::new();
        let mut done = TriangulatedPatch::default();
        if self.crosses {
            done.fault = Some(TessellationFaultKind::CrossingBorder);
        }
        let mut deviation: HashMap<[usize; 3], f64> = HashMap::new();
        let mut far = 0.0_f64;
        for _ in 0..ROUNDS {
            let inside = self.inside(patch);
            let mut wanted: Vec<DVec2> = Vec::new();
            let mut known: HashSet<[u64; 2]> = HashSet::new();
            far = 0.0;
            for face in self.sites.inner_faces().filter(|face| inside[face.index()]) {
                let key = face_key(&face);
                if close.contains(&key) {
                    continue;
                }
                let fit = TriangleFit::new(patch, &face, settings);
                match fit.divide_at {
                    Some(uv) => {
                        far = far.max(fit.deviation);
                        if known.insert(uv.to_array().map(f64::to_bits)) {
                            wanted.push(uv);
                        }
                    }
                    None => {
                        close.insert(key);
                        deviation.insert(key, fit.deviation);
                    }
                }
            }
            if wanted.is_empty() {
                break;
            }
            if self.sites.num_vertices() + wanted.len() > MAX_POINTS {
                break;
            }
            let before = self.sites.num_vertices();
            for uv in wanted {
                self.add(patch, uv);
            }
            if self.sites.num_vertices() == before {
                break;
            }
        }
        if far > settings.deviation {
            done.fault = Some(TessellationFaultKind::Coarse { deviation: far });
        }
        self.collect(patch, &deviation, far, done)
    }

    /// Adds a point inside, unless it is on the outline.
    fn add(&mut self, patch: &MeshPatch, uv: DVec2) {
        let site = self.site(patch, uv, None, patch.point(uv));
        if !site.point.is_finite() {
            return;
        }
        let free = match self.sites.locate(site.at) {
            PositionInTriangulation::OnFace(_) => true,
            PositionInTriangulation::OnEdge(edge) => !self.sites.directed_edge(edge).is_constraint_edge(),
            _ => false,
        };
        if free {
            self.crosses |= self.sites.insert(site).is_err();
        }
    }

    /// Adds the inner points of the grid that are not next to the outline.
    fn add_grid(&mut self, patch: &MeshPatch) {
        /// Parts of the steps of the grid: distance from the outline, and of points of a row.
        const NEAR: f64 = 0.3;
        let [us, vs] = &self.grid;
        if us.len() < 3 || vs.len() < 3 || us.len().saturating_mul(vs.len()) > MAX_POINTS {
            return;
        }
        let inside = self.inside(patch);
        let rows: Vec<Vec<DVec3>> =
            vs.iter().map(|&v| us.iter().map(|&u| patch.point(DVec2::new(u, v))).collect()).collect();
        // Rows become shorter towards a pole.
        let step = |i: usize| {
            let chord = |row: &Vec<DVec3>| row[i].distance(row[i - 1]);
            rows.iter().map(chord).fold(0.0, f64::max)
        };
        let steps: Vec<f64> = (1..us.len()).map(step).collect();
        let mut wanted = Vec::new();
        for (row, &v) in rows.iter().zip(vs).skip(1).take(vs.len() - 2) {
            let mut last = row[0];
            for ((&u, &point), &step) in us.iter().zip(row).skip(1).take(us.len() - 2).zip(&steps) {
                if point.distance(last) < NEAR * step {
                    continue;
                }
                last = point;
                let uv = DVec2::new(u, v);
                let site = self.site(patch, uv, None, point);
                let PositionInTriangulation::OnFace(face) = self.sites.locate(site.at) else { continue };
                let face = self.sites.face(face);
                let borders = face.adjacent_edges().into_iter().filter(|edge| edge.is_constraint_edge());
                let at = DVec2::new(site.at.x, site.at.y);
                let place = |p: Point2<f64>| DVec2::new(p.x, p.y);
                let apart =
                    |edge: spade::handles::DirectedEdgeHandle<'_, MeshSite, (), spade::CdtEdge<()>, ()>| {
                        let [from, to] = edge.positions().map(place);
                        (to - from).perp_dot(at - from).abs() / (to - from).length()
                    };
                let near_border = borders.map(apart).fold(f64::INFINITY, f64::min) < NEAR;
                let near_corner = face.positions().iter().any(|&p| place(p).distance(at) < NEAR);
                if inside[face.index()] && !near_border && !near_corner {
                    wanted.push(uv);
                }
            }
        }
        for uv in wanted {
            self.add(patch, uv);
        }
    }

    /// The triangles of the patch; `deviations`: of those that are close enough, `far`: of the others.
    fn collect(
        &self,
        patch: &MeshPatch,
        deviations: &HashMap<[usize; 3], f64>,
        far: f64,
        mut done: TriangulatedPatch,
    ) -> TriangulatedPatch {
        let inside = self.inside(patch);
        let mut numbers: HashMap<usize, u32> = HashMap::new();
        for face in self.sites.inner_faces().filter(|face| inside[face.index()]) {
            let corners = face.vertices();
            let [a, b, c] = corners.map(|corner| corner.data().vertex);
            // At poles and across bridged gaps.
            if a.is_some() && (a == b || a == c) || b.is_some() && b == c {
                continue;
            }
            done.deviation = done.deviation.max(deviations.get(&face_key(&face)).copied().unwrap_or(far));
            let flat = {
                let [a, b, c] = corners.map(|corner| corner.data().point);
                (b - a).cross(c - a).normalize_or_zero() * if patch.flipped { -1.0 } else { 1.0 }
            };
            let triangle = corners.map(|corner| {
                let next = done.vertices.len() as u32;
                let number = *numbers.entry(corner.index()).or_insert(next);
                if number == next {
                    let MeshSite { vertex, point, normal, .. } = *corner.data();
                    if vertex.is_none() {
                        done.inner.push(point);
                    }
                    done.vertices.push((vertex, if normal == DVec3::ZERO { flat } else { normal }));
                }
                number
            });
            done.triangles.push(triangle);
        }
        done
    }
}

/// The corners of a face in ascending order.
fn face_key(face: &SiteFace<'_>) -> [usize; 3] {
    let mut key = face.vertices().map(|vertex| vertex.index());
    key.sort_unstable();
    key
}
