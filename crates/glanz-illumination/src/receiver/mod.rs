//! Receivers: grids of cells on surfaces.

mod coverage;
mod faces;
mod flat;
mod parameters;
mod receivers;
mod shape_occurrence;

use glanz_math::{DVec2, DVec3};
use glanz_scene::description::{MAX_RECEIVER_CELLS, ReceiverSide};
use glanz_scene::{HitLocation, PlacedSurface, Scene};

use coverage::covered_shares;
use faces::FaceCells;
use flat::FlatGrid;
pub(crate) use flat::{clipped, face_corners, holds, middle, signed_area};
use parameters::ParameterGrid;
pub use receivers::{ReceiverHit, Receivers};
use shape_occurrence::ShapeOccurrence;

/// Share of a cell that the surface fills, below which it is a sliver: points on it are not searched, and goals of errors do not count it.
pub(crate) const SMALLEST_SHARE: f64 = 0.05;

/// Largest number of triangles of a curved mesh, whose cells are its triangles.
const FACES_LIMIT: usize = 1 << 22;

/// Resolution of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GridResolution {
    /// Numbers of cells along both directions.
    Cells([u32; 2]),
    /// Number of cells along the longer direction; along the other, cells of about the same length.
    Longer(u32),
    /// Cells of about this length, metres.
    Texel(f64),
}

impl GridResolution {
    /// Cells along both directions of a receiver of this size, metres; at least 1 and at most [`MAX_RECEIVER_CELLS`].
    fn cells(self, size: DVec2) -> [u32; 2] {
        let texel = match self {
            Self::Cells(cells) => return cells.map(|n| n.clamp(1, MAX_RECEIVER_CELLS)),
            Self::Longer(n) => size.max_element() / f64::from(n.max(1)),
            Self::Texel(texel) => texel,
        };
        // The cell length is adjusted to divide the side. A cast from NaN gives 0.
        (size / texel).to_array().map(|n| (n.round() as u32).clamp(1, MAX_RECEIVER_CELLS))
    }
}

/// Request for a receiver on a shape.
#[derive(Clone, Debug, PartialEq)]
pub struct ReceiverRequest {
    /// Its name.
    pub name: String,
    /// Number of the shape in the order of the scene file.
    pub shape: u32,
    /// The counted side; each of two sides becomes a receiver of its own.
    pub side: ReceiverSide,
    /// Resolution.
    pub fineness: GridResolution,
}

impl ReceiverRequest {
    /// Receivers that a scene declares; those without cells get the default resolution.
    #[must_use]
    pub fn of_scene(scene: &Scene, fineness: GridResolution) -> Vec<Self> {
        let asked = scene.receivers().iter().map(|receiver| Self {
            name: receiver.name().to_owned(),
            shape: receiver.shape(),
            side: receiver.side(),
            fineness: receiver.cells().map_or(fineness, GridResolution::Cells),
        });
        asked.collect()
    }
}

/// Errors of building a receiver.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ReceiverError {
    /// A shape without parameters, or an unbounded one.
    #[error("receiver \"{0}\" has no end or no parameters, so it cannot be divided into cells")]
    NoParameters(String),
    /// The shape does not exist or has no area.
    #[error("receiver \"{0}\" has no area")]
    NoArea(String),
    /// A mesh with too many triangles.
    #[error(
        "receiver \"{name}\" is a curved mesh of {faces} triangles; {FACES_LIMIT} at most can count light"
    )]
    TooMany {
        /// The receiver.
        name: String,
        /// Number of its triangles.
        faces: usize,
    },
}

/// A point of a receiver with its normal and area element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiverPoint {
    /// Metres.
    pub position: DVec3,
    /// Unit normal on the counted side.
    pub normal: DVec3,
    /// Area per unit of the cell's own square, m^2.
    pub area_element: f64,
}

/// A grid of cells on one surface.
///
/// A plane shape has square cells; its second direction is up, or north if it is horizontal, as seen from the
/// counted side. Other surfaces are divided by their parameters; the cells of meshes, whose parameters start anew on every triangle, are
/// the triangles. Boxes and polyhedra have one receiver per facet.
#[derive(Clone, Debug)]
pub struct Receiver {
    name: String,
    shape: u32,
    /// Number of the surface, and of its face if it is one facet of several.
    surface: u32,
    face: Option<u32>,
    /// Whether light on the side opposite to the normal counts.
    back: bool,
    cells: [u32; 2],
    size: DVec2,
    layout: ReceiverLayout,
    areas: Vec<f64>,
    /// Covered shares of the cells.
    covered: Vec<f64>,
    positions: Vec<DVec3>,
}

#[derive(Clone, Debug)]
enum ReceiverLayout {
    FlatGrid(FlatGrid),
    ParameterGrid(ParameterGrid),
    FaceCells(FaceCells),
}

impl ReceiverLayout {
    fn size(&self, surface: &PlacedSurface<'_>) -> DVec2 {
        match self {
            Self::FlatGrid(flat) => flat.size(),
            Self::ParameterGrid(parameters) => parameters.size(surface),
            Self::FaceCells(faces) => DVec2::new(f64::from(faces.len()), 1.0),
        }
    }
}

impl Receiver {
    fn try_new(
        request: &ReceiverRequest,
        name: String,
        found: &ShapeOccurrence<'_>,
        back: bool,
    ) -> Result<Self, ReceiverError> {
        let layout = found.layout(&name, back)?;
        let size = layout.size(&found.surface);
        let cells = match &layout {
            ReceiverLayout::FaceCells(faces) => [faces.len(), 1],
            _ => request.fineness.cells(size),
        };
        let (areas, positions) = match &layout {
            ReceiverLayout::FlatGrid(flat) => (flat.areas(cells), flat.centers(cells)),
            ReceiverLayout::ParameterGrid(parameters) => parameters.measure(&found.surface, cells),
            ReceiverLayout::FaceCells(faces) => faces.measure(&found.surface),
        };
        if areas.iter().all(|&area| area <= 0.0) {
            return Err(ReceiverError::NoArea(name));
        }
        let (shape, surface, face) = (request.shape, found.number, found.face);
        let covered = vec![0.0; areas.len()];
        Ok(Self { name, shape, surface, face, back, cells, size, layout, areas, covered, positions })
    }

    /// Excludes what other things cover.
    fn exclude_covered(&mut self, scene: &Scene, placed: &[PlacedSurface<'_>]) {
        self.covered = covered_shares(scene, placed, self);
        self.areas.iter_mut().zip(&self.covered).for_each(|(area, covered)| *area *= 1.0 - covered);
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The number of its shape in the order of the scene file.
    #[must_use]
    pub fn shape(&self) -> u32 {
        self.shape
    }

    /// Its number among [`Scene::placed_surfaces`].
    #[must_use]
    pub fn surface(&self) -> u32 {
        self.surface
    }

    /// The face of its surface that it is, if it is one facet of several.
    pub(crate) fn face(&self) -> Option<u32> {
        self.face
    }

    /// Whether its cells are rows and columns; those of a curved mesh are its triangles.
    pub(crate) fn is_grid(&self) -> bool {
        !matches!(self.layout, ReceiverLayout::FaceCells(_))
    }

    /// The lower left corner of a flat receiver, metres, and its unit directions across and up; `None` if it is curved or trimmed.
    pub(crate) fn flat_frame(&self) -> Option<[DVec3; 3]> {
        match &self.layout {
            ReceiverLayout::FlatGrid(flat) => Some(flat.frame()),
            _ => None,
        }
    }

    /// Cells along both directions.
    #[must_use]
    pub fn cells(&self) -> [u32; 2] {
        self.cells
    }

    /// Number of cells.
    #[must_use]
    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// Always `false`: a receiver has at least one cell.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.areas.is_empty()
    }

    /// Lengths along both directions through the middle, metres.
    #[must_use]
    pub fn size(&self) -> DVec2 {
        self.size
    }

    /// Areas of the cells, m^2, row by row, without what other things cover; 0 where there is nothing of the surface.
    #[must_use]
    pub fn areas(&self) -> &[f64] {
        &self.areas
    }

    /// Share of each cell that things cover which stand on the receiver or reach through it, [0, 1].
    #[must_use]
    pub fn covered(&self) -> &[f64] {
        &self.covered
    }

    /// Middles of the cells in the world, metres.
    #[must_use]
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Whether [`Receiver::place`] finds the points of a cell; if not, or only a few of them, particles alone measure its light.
    #[must_use]
    pub fn has_places(&self, cell: usize) -> bool {
        match &self.layout {
            ReceiverLayout::ParameterGrid(parameters) => parameters.has_places(),
            ReceiverLayout::FlatGrid(flat) => {
                let square = flat.size() / DVec2::from(self.cells.map(f64::from));
                self.even_area(cell).is_some_and(|area| area >= SMALLEST_SHARE * square.element_product())
            }
            ReceiverLayout::FaceCells(_) => true,
        }
    }

    /// Area of the surface per unit of the square of each of its cells where that is the same everywhere: on flat receivers.
    pub(crate) fn even_area(&self, cell: usize) -> Option<f64> {
        let covered = self.covered.get(cell).copied().unwrap_or_default();
        let area = self.areas.get(cell).copied().unwrap_or_default();
        (matches!(self.layout, ReceiverLayout::FlatGrid(_)) && covered < 1.0).then(|| area / (1.0 - covered))
    }

    /// The point of a cell by its own parameters in [0, 1]^2; `None` where there is no surface.
    ///
    /// `surface`: that of [`Receiver::surface`].
    #[must_use]
    pub fn place(&self, surface: &PlacedSurface<'_>, cell: usize, at: DVec2) -> Option<ReceiverPoint> {
        let point = match &self.layout {
            ReceiverLayout::FlatGrid(flat) => flat.place(self.cells, cell, at),
            ReceiverLayout::ParameterGrid(parameters) => parameters.place(surface, self.cells, cell, at),
            ReceiverLayout::FaceCells(faces) => faces.place(surface, cell, at),
        }?;
        let normal = if self.back { -point.normal } else { point.normal };
        Some(ReceiverPoint { normal, ..point })
    }

    /// Whether light on the side opposite to the normal counts.
    #[must_use]
    pub fn is_back(&self) -> bool {
        self.back
    }

    /// Grid coordinates of a point, [0, 1]^2; `None` if cells are faces.
    #[inline]
    fn share(&self, at: &HitLocation) -> Option<DVec2> {
        match &self.layout {
            ReceiverLayout::FlatGrid(flat) => Some(flat.share(at.position)),
            ReceiverLayout::ParameterGrid(parameters) => Some(parameters.share(at.uv)),
            ReceiverLayout::FaceCells(_) => None,
        }
    }

    /// The cell that a ray met.
    #[inline]
    fn locate(&self, at: &HitLocation) -> Option<usize> {
        if let ReceiverLayout::FaceCells(faces) = &self.layout {
            return faces.cell(at.place.face);
        }
        let share = self.share(at)?;
        let index = |share: f64, n: u32| ((share * f64::from(n)) as u32).min(n - 1) as usize;
        let [nx, ny] = self.cells;
        Some(index(share.y, ny) * nx as usize + index(share.x, nx))
    }

    /// Cells whose middles surround a point of the receiver, with the weights of bilinear interpolation between them, whose sum is 1. Values are constant
    /// in the outer half of the cells at the border, and in cells that are faces.
    #[must_use]
    pub fn interpolation(&self, at: &HitLocation) -> Option<[(usize, f64); 4]> {
        let Some(share) = self.share(at) else {
            return self.locate(at).map(|cell| [(cell, 1.0), (cell, 0.0), (cell, 0.0), (cell, 0.0)]);
        };
        let along = |share: f64, n: u32| {
            let x = (share * f64::from(n) - 0.5).clamp(0.0, f64::from(n - 1));
            let first = x.floor();
            [(first as usize, 1.0 - (x - first)), ((first as usize + 1).min(n as usize - 1), x - first)]
        };
        let [nx, ny] = self.cells;
        let ([a, b], [c, d]) = (along(share.x, nx), along(share.y, ny));
        Some([(a, c), (b, c), (a, d), (b, d)].map(|((i, s), (j, t))| (j * nx as usize + i, s * t)))
    }
}
