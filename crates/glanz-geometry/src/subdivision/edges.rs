//! Edges of a mesh of triangles, and the neighbours of its vertices.

use glanz_math::DVec3;

use crate::error::SurfaceError;

/// An edge of one triangle or two.
pub(super) struct SubdivisionEdge {
    pub(super) ends: [u32; 2],
    /// Corners of the triangles that are opposite to the edge.
    pub(super) opposite: (u32, Option<u32>),
    /// The sides of triangles that it is: three times the triangle plus the number of the corner at which the side starts.
    sides: (u32, Option<u32>),
}

/// Sum over the neighbours of a vertex; of one on a border over the two on the border.
#[derive(Clone, Copy, Default)]
pub(super) struct NeighborSum {
    pub(super) sum: DVec3,
    pub(super) count: u32,
    pub(super) is_border: bool,
}

/// Neighbours of a vertex, counterclockwise where corners of triangles are; from border to border if it is on one.
#[derive(Default)]
pub(super) struct VertexRing {
    pub(super) vertices: Vec<u32>,
    pub(super) is_border: bool,
}

/// The edges of a mesh.
pub(super) struct EdgeTable {
    edges: Vec<SubdivisionEdge>,
    /// The edge from each corner of a triangle to the next.
    of_sides: Vec<u32>,
    /// Number of edges at each vertex.
    valences: Vec<u32>,
    /// A corner at each vertex, counted as sides are; the last before the border if there is one.
    fan_starts: Vec<Option<u32>>,
}

/// The corner after a corner of a triangle, and the one before.
fn next(corner: u32) -> u32 {
    if corner % 3 == 2 { corner - 2 } else { corner + 1 }
}

fn previous(corner: u32) -> u32 {
    if corner.is_multiple_of(3) { corner + 2 } else { corner - 1 }
}

impl EdgeTable {
    /// # Errors
    /// [`SurfaceError::NotManifold`] if an edge has three triangles or two that pass it in the same direction, or a triangle has a corner twice.
    pub(super) fn try_new(triangles: &[[u32; 3]], vertices: usize) -> Result<Self, SurfaceError> {
        let corner = |corner: u32| vertex_at(triangles, corner);
        let mut sides: Vec<(u32, u32, u32)> = (0..3 * triangles.len() as u32)
            .map(|side| {
                let ends = [corner(side), corner(next(side))];
                (ends[0].min(ends[1]), ends[0].max(ends[1]), side)
            })
            .collect();
        sides.sort_unstable();
        let (mut edges, mut of_sides) = (Vec::with_capacity(sides.len() / 2), vec![0; sides.len()]);
        let (mut valences, mut fan_starts) = (vec![0; vertices], vec![None; vertices]);
        for same in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let not_manifold = |reason| SurfaceError::NotManifold { vertex: same[0].0, reason };
            let (first, second) = match *same {
                [(a, b, _)] if a == b => return Err(not_manifold("a triangle has it as two of its corners")),
                [(_, _, side)] => (side, None),
                [(_, _, a), (_, _, b)] if corner(a) != corner(b) => (a, Some(b)),
                [_, _] => return Err(not_manifold("two triangles pass an edge of it in the same direction")),
                _ => return Err(not_manifold("an edge of it has more than two triangles")),
            };
            let ends = [corner(first), corner(next(first))];
            for side in [Some(first), second].into_iter().flatten() {
                of_sides[side as usize] = edges.len() as u32;
                // The first side of a fan on a border has no neighbour.
                let start = &mut fan_starts[corner(side) as usize];
                if start.is_none() || second.is_none() {
                    *start = Some(side);
                }
            }
            for end in ends {
                valences[end as usize] += 1;
            }
            let opposite = |side| corner(previous(side));
            let (opposite, sides) = ((opposite(first), second.map(opposite)), (first, second));
            edges.push(SubdivisionEdge { ends, opposite, sides });
        }
        Ok(Self { edges, of_sides, valences, fan_starts })
    }

    pub(super) fn edges(&self) -> &[SubdivisionEdge] {
        &self.edges
    }

    /// The edges of a triangle, from each corner to the next.
    pub(super) fn of_face(&self, face: usize) -> [u32; 3] {
        [0, 1, 2].map(|side| self.of_sides[3 * face + side])
    }

    /// A corner at each vertex, if it has one, from which [`EdgeTable::ring`] starts.
    pub(super) fn fan_starts(&self) -> &[Option<u32>] {
        &self.fan_starts
    }

    /// The sums over the neighbours of all vertices.
    pub(super) fn neighbor_sums(&self, positions: &[DVec3]) -> Vec<NeighborSum> {
        let mut sums = vec![NeighborSum::default(); positions.len()];
        for edge in &self.edges {
            let is_border = edge.sides.1.is_none();
            for [from, to] in [edge.ends, [edge.ends[1], edge.ends[0]]] {
                let sum = &mut sums[from as usize];
                if is_border && !sum.is_border {
                    *sum = NeighborSum { is_border, ..NeighborSum::default() };
                }
                if sum.is_border == is_border {
                    sum.sum += positions[to as usize];
                    sum.count += 1;
                }
            }
        }
        sums
    }

    /// Replaces `ring` by the neighbours of the vertex at a corner of [`EdgeTable::fan_starts`].
    ///
    /// # Errors
    /// [`SurfaceError::NotManifold`] if the vertex has triangles beyond the fan of this corner.
    pub(super) fn ring(
        &self,
        triangles: &[[u32; 3]],
        start: u32,
        ring: &mut VertexRing,
    ) -> Result<(), SurfaceError> {
        let vertex = vertex_at(triangles, start);
        ring.vertices.clear();
        let mut corner = start;
        loop {
            ring.vertices.push(vertex_at(triangles, next(corner)));
            let side = previous(corner);
            match self.across(side) {
                Some(neighbor) if neighbor == start => {
                    ring.is_border = false;
                    break;
                }
                Some(neighbor) => corner = neighbor,
                None => {
                    ring.is_border = true;
                    ring.vertices.push(vertex_at(triangles, side));
                    break;
                }
            }
        }
        if ring.vertices.len() == self.valences[vertex as usize] as usize {
            return Ok(());
        }
        Err(SurfaceError::NotManifold { vertex, reason: "its triangles are more than one fan" })
    }

    /// The same edge as a side of the triangle beyond.
    fn across(&self, side: u32) -> Option<u32> {
        let (first, second) = self.edges[self.of_sides[side as usize] as usize].sides;
        if first == side { second } else { Some(first) }
    }
}

fn vertex_at(triangles: &[[u32; 3]], corner: u32) -> u32 {
    triangles[corner as usize / 3][corner as usize % 3]
}
