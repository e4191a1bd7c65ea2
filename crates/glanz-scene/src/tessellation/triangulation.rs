//! Triangles of a patch, as close to its surface as the settings demand.
//!
//! # Source
//! The constrained Delaunay triangulation is that of the crate `spade`. Points are added in the middle of edges and triangles that are too far from the
//! surface, as in @chew1993, but the test is the distance from the surface instead of the shape.

use std::collections::{BTreeMap, HashMap, HashSet, VecDeque};

use glanz_job::CancelFlag;
use glanz_math::{DVec2, DVec3};
use spade::handles::{FixedVertexHandle, InnerTag};
use spade::{
    ConstrainedDelaunayTriangulation, HasPosition, HierarchyHintGenerator, Point2, PositionInTriangulation,
    Triangulation,
};

use super::flat_triangles::flip_flat;
use super::grid::{grid_scale, straight_breaks};
use super::outline::Outline;
use super::outline_constraints::OutlineConstraints;
use super::patch::MeshPatch;
use super::triangle_fit::TriangleFit;
use super::{TessellationFaultKind, TessellationSettings};

/// Largest number of points of a patch.
const MAX_POINTS: usize = 1 << 20;

/// A vertex of the triangulation.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshSite {
    pub(super) uv: DVec2,
    pub(super) at: Point2<f64>,
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

pub(super) type SiteTriangulation =
    ConstrainedDelaunayTriangulation<MeshSite, (), (), (), HierarchyHintGenerator<f64>>;
pub(super) type SiteFace<'a> = spade::handles::FaceHandle<'a, InnerTag, MeshSite, (), spade::CdtEdge<()>, ()>;
type SiteHandle<'a> = spade::handles::VertexHandle<'a, MeshSite, (), spade::CdtEdge<()>, ()>;

/// The triangulation of the outline of a patch.
pub(super) struct PatchTriangulation {
    sites: SiteTriangulation,
    scale: DVec2,
    pub(super) outline: OutlineConstraints,
    /// Parameters between which the surface is nearly straight.
    grid: [Vec<f64>; 2],
}

/// The triangles of a patch.
#[derive(Debug, Default)]
pub(super) struct TriangulatedPatch {
    /// Vertices with unit normals.
    pub(super) vertices: Vec<MeshSite>,
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
            outline: OutlineConstraints::default(),
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
        made.outline = OutlineConstraints::new(&mut made.sites, outline, &handles);
        made.add_turned(patch, settings);
        made
    }

    fn site(&self, patch: &MeshPatch, uv: DVec2, vertex: Option<u32>, point: DVec3) -> MeshSite {
        let [low, _] = patch.window();
        let at = (uv - low) * self.scale;
        MeshSite { uv, at: Point2::new(at.x, at.y), vertex, point, normal: patch.normal(uv) }
    }

    /// Gives vertices the numbers of those that stand for them.
    pub(super) fn rename(&mut self, mut representative: impl FnMut(u32) -> u32) {
        let handles: Vec<FixedVertexHandle> = self.sites.fixed_vertices().collect();
        for handle in handles {
            let site = self.sites.vertex_data_mut(handle);
            site.vertex = site.vertex.map(&mut representative);
        }
    }

    /// Number of faces whose middles tell how often the outline goes around them.
    const VOTES: usize = 16;

    /// How often the outline goes around each face, by its index; `None` where it does not tell.
    fn windings(&self, patch: &MeshPatch) -> Vec<Option<i32>> {
        let count = self.sites.num_all_faces();
        let Some(trim) = &patch.trim else { return vec![Some(1); count] };
        let mut winding: Vec<Option<i32>> = vec![None; count];
        if self.outline.is_incomplete {
            for face in self.sites.inner_faces() {
                winding[face.index()] = Some(i32::from(trim.region.contains(middle(&face))));
            }
            return winding;
        }
        let mut largest: Vec<SiteFace<'_>> = self.sites.inner_faces().collect();
        largest.sort_by(|a, b| b.area().total_cmp(&a.area()));
        let Some(&start) = largest.first() else { return winding };
        winding[start.index()] = Some(0);
        let mut queue = VecDeque::from([start]);
        while let Some(face) = queue.pop_front() {
            let Some(here) = winding[face.index()] else { continue };
            for edge in face.adjacent_edges() {
                let Some(next) = edge.rev().face().as_inner() else { continue };
                if winding[next.index()].is_none() {
                    let [from, to] = [edge.from().index(), edge.to().index()];
                    let change = |ends: [usize; 2]| self.outline.changes.get(&ends).copied().unwrap_or(0);
                    winding[next.index()] = Some(here - change([from, to]) + change([to, from]));
                    queue.push_back(next);
                }
            }
        }
        // Where chords are coarse, even the middle of a large face may be on the other side of the curve: what most area says counts.
        let mut votes: BTreeMap<i32, f64> = BTreeMap::new();
        for face in largest.iter().take(Self::VOTES) {
            if let Some(here) = winding[face.index()] {
                *votes.entry(patch.winding(middle(face)) - here).or_default() += face.area();
            }
        }
        let first = votes.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(first, _)| first);
        winding.into_iter().map(|here| here.map(|here| here + first)).collect()
    }

    /// Whether each face, by its index, is a part of the patch.
    fn inside(&self, patch: &MeshPatch) -> Vec<bool> {
        self.windings(patch).into_iter().map(|winding| winding.is_some_and(|winding| winding > 0)).collect()
    }

    /// Notes the faces that lie between chords in the wrong order, which need not cross.
    fn add_turned(&mut self, patch: &MeshPatch, settings: TessellationSettings) {
        /// Parts of the deviation: two chords are no farther on the wrong sides of each other.
        const APART: f64 = 2.0;
        let windings = self.windings(patch);
        for face in self.sites.inner_faces() {
            let Some(winding) = windings[face.index()].filter(|winding| !(0..=1).contains(winding)) else {
                continue;
            };
            let height = height(&face.vertices().map(|corner| corner.data().point));
            if height <= APART * settings.deviation {
                let edges = face.adjacent_edges().map(|edge| edge.vertices().map(|end| end.index()));
                let corners = face.vertices().map(|corner| corner.fix());
                // As often as the outline goes around them, so that no side is open.
                let [a, b, c] = corners;
                let corners = if winding < 0 { [a, c, b] } else { corners };
                let missing = if winding < 0 { winding.unsigned_abs() } else { winding as u32 - 1 } as usize;
                if self.outline.add_flaps(corners, missing) {
                    self.outline.add_conflict(edges, height);
                }
            }
        }
    }

    /// Adds points until the triangles are close enough to the surface.
    pub(super) fn fill(
        mut self,
        patch: &MeshPatch,
        settings: TessellationSettings,
        cancel: &CancelFlag,
    ) -> TriangulatedPatch {
        /// Each round halves the triangles that are not close enough.
        const ROUNDS: usize = 40;
        self.add_grid(patch, cancel);
        let mut close: HashSet<[usize; 3]> = HashSet::new();
        let mut done = TriangulatedPatch::default();
        let height = self.outline.conflicts.iter().map(|conflict| conflict.height).fold(0.0, f64::max);
        done.deviation = height;
        if self.outline.is_incomplete || height > settings.deviation {
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
                if cancel.is_cancelled() {
                    return done;
                }
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
        self.collect(patch, settings, &deviation, far, done)
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
            let _ = self.sites.insert(site);
        }
    }

    /// Adds the inner points of the grid that are not next to the outline.
    fn add_grid(&mut self, patch: &MeshPatch, cancel: &CancelFlag) {
        /// Parts of the steps of the grid: distance from the outline, and of points of a row.
        const NEAR: f64 = 0.3;
        let [us, vs] = &self.grid;
        if us.len() < 3 || vs.len() < 3 || us.len().saturating_mul(vs.len()) > MAX_POINTS {
            return;
        }
        let inside = self.inside(patch);
        let row = |&v: &f64| us.iter().map(|&u| patch.point(DVec2::new(u, v))).collect();
        let rows: Vec<Vec<DVec3>> = vs.iter().take_while(|_| !cancel.is_cancelled()).map(row).collect();
        // Rows become shorter towards a pole.
        let step = |i: usize| {
            let chord = |row: &Vec<DVec3>| row[i].distance(row[i - 1]);
            rows.iter().map(chord).fold(0.0, f64::max)
        };
        let steps: Vec<f64> = (1..us.len()).map(step).collect();
        let mut wanted = Vec::new();
        for (row, &v) in rows.iter().zip(vs).skip(1).take(vs.len() - 2) {
            if cancel.is_cancelled() {
                return;
            }
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
        settings: TessellationSettings,
        deviations: &HashMap<[usize; 3], f64>,
        far: f64,
        mut done: TriangulatedPatch,
    ) -> TriangulatedPatch {
        let inside = self.inside(patch);
        let mut numbers: HashMap<usize, u32> = HashMap::new();
        for face in self.sites.inner_faces().filter(|face| inside[face.index()]) {
            let far = deviations.get(&face_key(&face)).copied().unwrap_or(far);
            if done.add(face.vertices(), &mut numbers, patch.flipped) {
                done.deviation = done.deviation.max(far);
            }
        }
        for corners in &self.outline.flaps {
            done.add(corners.map(|corner| self.sites.vertex(corner)), &mut numbers, patch.flipped);
        }
        let flipped = flip_flat(patch, &done.vertices, &mut done.triangles, settings);
        done.deviation = done.deviation.max(flipped);
        done
    }
}

impl TriangulatedPatch {
    /// Adds a triangle, unless two of its corners are the same vertex of the group.
    fn add(
        &mut self,
        corners: [SiteHandle<'_>; 3],
        numbers: &mut HashMap<usize, u32>,
        flipped: bool,
    ) -> bool {
        let [a, b, c] = corners.map(|corner| corner.data().vertex);
        // At poles and across bridged gaps.
        if a.is_some() && (a == b || a == c) || b.is_some() && b == c {
            return false;
        }
        let flat = {
            let [a, b, c] = corners.map(|corner| corner.data().point);
            (b - a).cross(c - a).normalize_or_zero() * if flipped { -1.0 } else { 1.0 }
        };
        let triangle = corners.map(|corner| {
            let next = self.vertices.len() as u32;
            let number = *numbers.entry(corner.index()).or_insert(next);
            if number == next {
                let site = *corner.data();
                let normal = if site.normal == DVec3::ZERO { flat } else { site.normal };
                self.vertices.push(MeshSite { normal, ..site });
            }
            number
        });
        self.triangles.push(triangle);
        true
    }
}

/// The middle of a face in the parameters.
fn middle(face: &SiteFace<'_>) -> DVec2 {
    face.vertices().iter().map(|vertex| vertex.data().uv).sum::<DVec2>() / 3.0
}

/// The smallest height of a triangle.
pub(super) fn height(&[a, b, c]: &[DVec3; 3]) -> f64 {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    if longest > 0.0 { (b - a).cross(c - a).length() / longest } else { 0.0 }
}

/// The corners of a face in ascending order.
fn face_key(face: &SiteFace<'_>) -> [usize; 3] {
    let mut key = face.vertices().map(|vertex| vertex.index());
    key.sort_unstable();
    key
}
