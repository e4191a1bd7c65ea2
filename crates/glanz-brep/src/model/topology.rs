//! Faces, edges, bodies and assemblies.

use std::fmt;

use glanz_math::{DMat4, DVec2, DVec3};

use super::curve::Curve;
use super::surface::{FaceSurface, Placement};

/// The number by which the file refers to an entity: `#120` in STEP, the directory entry in IGES.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EntityId(pub u64);

impl fmt::Display for EntityId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "#{}", self.0)
    }
}

/// The contents of a CAD file.
#[derive(Clone, Debug, Default)]
pub struct BrepModel {
    /// Surfaces; several faces may share one.
    pub surfaces: Vec<SurfaceEntry>,
    /// Vertices, metres.
    pub vertices: Vec<DVec3>,
    /// Edges.
    pub edges: Vec<Edge>,
    /// Faces.
    pub faces: Vec<Face>,
    /// Parts; one may only have occurrences of those before it.
    pub parts: Vec<Part>,
    /// What the file shows: occurrences of parts in the world.
    pub roots: Vec<Occurrence>,
    /// Colours that items have in some occurrences only. Where several are about one item, that of the outer occurrence counts, and of those
    /// the first.
    pub overrides: Vec<StyleOverride>,
    /// Distance below which points of the file are meant to coincide, metres; the largest of its contexts.
    pub uncertainty: f64,
    /// The unit of length of the file, metres: the first, where it has several.
    pub length_unit: Option<f64>,
}

/// A surface with its place in the file.
#[derive(Clone, Debug)]
pub struct SurfaceEntry {
    /// The surface.
    pub surface: FaceSurface,
    /// Its number in the file.
    pub entity: EntityId,
}

/// A part of a curve between two vertices.
#[derive(Clone, Debug)]
pub struct Edge {
    /// Index of the vertex at its start.
    pub start: usize,
    /// Index of the vertex at its end; that of the start on a closed edge.
    pub end: usize,
    /// Its curve in space; `None` if the file has none, which is a straight edge.
    pub curve: Option<Curve<DVec3>>,
    /// Whether it runs from start to end along the parameter of the curve.
    pub same_sense: bool,
    /// Its curves in the parameters of surfaces, two on the seam of a closed one.
    pub parameter_curves: Vec<ParameterCurve>,
    /// Its number in the file.
    pub entity: EntityId,
}

/// A curve in the parameters of a surface (a pcurve), running as the curve of its edge.
#[derive(Clone, Debug)]
pub struct ParameterCurve {
    /// Index of the surface.
    pub surface: usize,
    /// The curve, in metres and radians as the surface has them.
    pub curve: Curve<DVec2>,
}

/// An edge with the sense in which a loop runs through it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OrientedEdge {
    /// Index of the edge.
    pub edge: usize,
    /// Whether the loop runs from its start to its end.
    pub forward: bool,
}

/// A closed boundary of a face.
#[derive(Clone, Debug)]
pub struct FaceBound {
    /// The loop. Seen from the side to which the normal of the face points, material is on its left.
    pub boundary: BoundaryLoop,
    /// Whether the file calls it the outer bound.
    pub outer: bool,
    /// Its number in the file.
    pub entity: EntityId,
}

/// A closed chain.
#[derive(Clone, Debug)]
pub enum BoundaryLoop {
    /// Edges, each of which starts where the one before ends.
    Edges(Vec<OrientedEdge>),
    /// A single point, as the apex of a cone, by the index of its vertex.
    Vertex(usize),
    /// The border of the surface, which is bounded: that of its range, or of its domain.
    Border,
}

impl BrepModel {
    /// The corners of a loop of edges that are straight because they have no curves; `None` for other loops, and for
    /// edges or vertices that the model lacks.
    #[must_use]
    pub fn polygon(&self, boundary: &BoundaryLoop) -> Option<Vec<DVec3>> {
        let BoundaryLoop::Edges(oriented) = boundary else { return None };
        let corner = |&OrientedEdge { edge, forward }: &OrientedEdge| {
            let edge = self.edges.get(edge).filter(|edge| edge.curve.is_none())?;
            self.vertices.get(if forward { edge.start } else { edge.end }).copied()
        };
        oriented.iter().map(corner).collect()
    }
}

impl Placement {
    /// The frame in the plane of the largest of some polygons; its z axis is the normal for which that polygon runs counter-clockwise.
    /// `None` if no polygon has an area.
    #[must_use]
    pub fn of_polygons(polygons: &[Vec<DVec3>]) -> Option<Self> {
        let polygons = polygons.iter().filter_map(|corners| corners.split_first());
        let areas = polygons.map(|(&origin, rest)| {
            let pairs = rest.iter().zip(rest.iter().skip(1));
            let area: DVec3 = pairs.map(|(a, b)| (*a - origin).cross(*b - origin)).sum();
            (area, origin, rest)
        });
        let largest = areas.max_by(|a, b| a.0.length_squared().total_cmp(&b.0.length_squared()));
        let (area, origin, rest) = largest?;
        let towards = rest.first().map_or(DVec3::ZERO, |next| *next - origin);
        Some(Self::from_axis(origin, area.try_normalize()?, towards))
    }
}

/// A bounded part of a surface.
#[derive(Clone, Debug)]
pub struct Face {
    /// Index of its surface.
    pub surface: usize,
    /// Whether its normal is that of the surface.
    pub same_sense: bool,
    /// Its boundary; empty for a whole closed surface.
    pub bounds: Vec<FaceBound>,
    /// Its name; may be empty.
    pub name: String,
    /// Its colour, where the file gives one to the face.
    pub style: Option<ColorStyle>,
    /// Its layer; may be empty.
    pub layer: String,
    /// Its number in the file.
    pub entity: EntityId,
}

/// Colour and transparency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorStyle {
    /// Red, green, blue from 0 to 1, as the file gives them (meant for a screen: sRGB).
    pub rgb: [f64; 3],
    /// 0: opaque, 1: invisible.
    pub transparency: f64,
}

/// Connected faces.
#[derive(Clone, Debug, Default)]
pub struct Shell {
    /// Indices of the faces; those with `true` have their normal reversed.
    pub faces: Vec<(usize, bool)>,
    /// Whether the file says that the shell encloses a volume, and all its faces were read.
    pub closed: bool,
    /// Its number in the file.
    pub entity: EntityId,
}

/// A solid, or a surface model.
#[derive(Clone, Debug, Default)]
pub struct Body {
    /// Its name; may be empty.
    pub name: String,
    /// Its shells: of a solid the outer one and then the voids, whose normals point into them.
    pub shells: Vec<Shell>,
    /// Whether it is a solid.
    pub solid: bool,
    /// Its colour, for faces without one.
    pub style: Option<ColorStyle>,
    /// Its layer; may be empty.
    pub layer: String,
    /// Its number in the file.
    pub entity: EntityId,
}

/// A component: bodies, and occurrences of other parts, in one frame.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// Bodies of its own.
    pub bodies: Vec<Body>,
    /// Placed parts.
    pub occurrences: Vec<Occurrence>,
    /// Its number in the file.
    pub entity: EntityId,
}

/// A placed copy of a part.
#[derive(Clone, Debug)]
pub struct Occurrence {
    /// Index of the part.
    pub part: usize,
    /// From the frame of the part to that of its parent; rigid, perhaps with a uniform scale or a reflection.
    pub to_parent: DMat4,
    /// Its name; may be empty.
    pub name: String,
    /// Its colour, for what is inside without one.
    pub style: Option<ColorStyle>,
    /// Its number in the file.
    pub entity: EntityId,
}

/// A colour in the context of an occurrence, whatever colours there are inside.
#[derive(Clone, Debug, PartialEq)]
pub struct StyleOverride {
    /// The numbers of occurrences, each of which is in the part of the one before. None: wherever no other override is about the item.
    pub path: Vec<EntityId>,
    /// The number of what it colours: a face, a shell, a body or an occurrence inside the last occurrence, or that itself.
    pub item: EntityId,
    /// The colour.
    pub style: ColorStyle,
}
