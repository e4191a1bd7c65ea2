//! Meshes: primitives as triangles.

use glanz_job::{MemoryReservation, Resource};
use glanz_math::{DVec2, DVec3};
use glanz_scene::description::{GeometryDescription, ShapeDescription, SurfaceMedia};

use super::GltfReader;
use super::accessor::{Accessor, ElementType};
use super::error::GltfError;
use super::json::{JsonObject, JsonPath};
use super::material::GltfMaterial;
use crate::finder::entry_bytes;
use crate::model::repetition;

const SCALAR: ElementType = ElementType { names: &["SCALAR"], floats: false };
const VEC2: ElementType = ElementType { names: &["VEC2"], floats: true };
pub(super) const VEC3: ElementType = ElementType { names: &["VEC3"], floats: true };
pub(super) const VEC4: ElementType = ElementType { names: &["VEC4"], floats: true };
const COLOR: ElementType = ElementType { names: &["VEC3", "VEC4"], floats: true };

/// Modes of primitives: those before are points and lines.
const TRIANGLES: usize = 4;
const TRIANGLE_STRIP: usize = 5;
const TRIANGLE_FAN: usize = 6;

/// Compression of primitives that is not read, and the remedy.
const DRACO: &str = "KHR_draco_mesh_compression";
pub(super) const DRACO_HELP: &str =
    "compression by Draco is not read; convert the file first: gltf-transform copy FILE plain.glb";

/// Bytes of an element of an accessor: a vector of numbers of eight bytes.
const BYTES_PER_ELEMENT: u64 = 24;

/// Bytes of a corner: the number of its vertex.
const BYTES_PER_CORNER: u64 = 4;

/// Bytes of a triangle.
const BYTES_PER_TRIANGLE: u64 = 12;

/// The message for a file whose primitives use the same elements again and again.
const TOO_MUCH: &str = "the elements of the file are used too often; give primitives the same mesh instead of the same accessors";

/// Triangles over the vertices that they use.
struct UsedVertices {
    /// Numbers of the vertices in the accessors, ascending.
    used: Vec<u32>,
    /// Triples of positions in `used`.
    triangles: Vec<[u32; 3]>,
}

impl UsedVertices {
    fn new(corners: &[[u32; 3]], count: usize) -> Self {
        let mut used: Vec<u32> = corners.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        let position = |vertex: u32| used.binary_search(&vertex).unwrap_or_default() as u32;
        let all_used = used.len() == count;
        let triangles = corners.iter().map(|t| if all_used { *t } else { t.map(position) }).collect();
        Self { used, triangles }
    }

    /// Bytes of a value for each vertex.
    fn bytes<T>(&self) -> u64 {
        (size_of::<T>() as u64).saturating_mul(self.used.len() as u64)
    }

    /// The values of an accessor at the vertices.
    fn values<const N: usize, T>(
        &self,
        accessor: &Accessor<'_>,
        default: [f64; N],
        convert: impl Fn([f64; N]) -> T,
    ) -> Vec<T> {
        self.used.iter().map(|&vertex| convert(accessor.vector(vertex as usize, default))).collect()
    }
}

/// Corners of the triangles of a primitive, and whether some corners are left over.
fn triangles(mode: usize, corners: &[u32]) -> (Vec<[u32; 3]>, bool) {
    let triangles = match mode {
        TRIANGLES => return (corners.as_chunks().0.to_vec(), !corners.len().is_multiple_of(3)),
        TRIANGLE_STRIP => corners
            .windows(3)
            .enumerate()
            .map(|(i, t)| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[0], t[2], t[1]] })
            .collect(),
        _ => {
            let first = corners.first().copied().unwrap_or_default();
            corners.get(1..).unwrap_or_default().windows(2).map(|pair| [pair[0], pair[1], first]).collect()
        }
    };
    (triangles, corners.len() < 3)
}

/// Checks that an attribute has a value for each of `count` vertices.
fn check_count(
    attributes: &JsonObject<'_>,
    name: &str,
    accessor: &Accessor<'_>,
    count: usize,
) -> Result<(), GltfError> {
    match accessor.count() {
        found if found == count => Ok(()),
        found => Err(attributes.error(name, format!("{found} elements for {count} vertices"))),
    }
}

impl<'a> GltfReader<'a, '_> {
    /// The shapes of a mesh, in its frame. `from`: the node that names it.
    pub(super) fn mesh(
        &mut self,
        number: usize,
        from: &JsonPath<'_>,
    ) -> Result<Vec<ShapeDescription>, GltfError> {
        let document = self.document;
        document.element("meshes", number, from, |mesh| {
            let path = mesh.path().name("primitives");
            let mut shapes = Vec::new();
            for (i, primitive) in mesh.list("primitives")?.iter().enumerate() {
                let path = path.index(i);
                let shape = self.primitive(&JsonObject::try_new(primitive, &path)?)?;
                if shape.is_some() {
                    self.spend_object(entry_bytes::<ShapeDescription>(""), &path)?;
                }
                shapes.extend(shape);
            }
            Ok(shapes)
        })
    }

    /// The shape of a primitive; `None`, after a report, if it has no triangles.
    fn primitive(&mut self, primitive: &JsonObject<'_>) -> Result<Option<ShapeDescription>, GltfError> {
        let mode = primitive.count("mode")?.unwrap_or(TRIANGLES);
        if mode > TRIANGLE_FAN {
            return Err(primitive.error("mode", format!("the mode {mode} is unknown")));
        }
        let left_out = |this: &mut Self, what: &str| {
            this.reader.stand_in("gltf-primitive", None, format!("{}: {what}", primitive.path()));
            Ok(None)
        };
        if mode < TRIANGLES {
            return left_out(self, "points and lines are left out");
        }
        primitive.object_or_empty("attributes", |attributes| {
            let Some(positions) = self.attribute(&attributes, "POSITION", VEC3)? else {
                return left_out(self, "a primitive without positions is left out");
            };
            if !positions.is_stored() && primitive.extension(DRACO, |found| Ok(found.is_some()))? {
                return Err(primitive.fault(DRACO_HELP));
            }
            let count = positions.count();
            let corners = self.corners(primitive, count)?;
            let most = if mode == TRIANGLES { corners.len() / 3 } else { corners.len() };
            // The corners, their triangles twice, and the sorted vertices.
            let working = BYTES_PER_CORNER.saturating_mul(corners.len() as u64)
                + (3 * BYTES_PER_TRIANGLE).saturating_mul(most as u64);
            let _working = self.reserve(working, primitive.path())?;
            let (triangles, has_rest) = triangles(mode, &corners);
            if has_rest {
                left_out(self, "corners that make no triangle are left out")?;
            }
            if triangles.is_empty() {
                return Ok(None);
            }
            self.spend(BYTES_PER_TRIANGLE.saturating_mul(triangles.len() as u64), primitive.path())?;
            let vertices = UsedVertices::new(&triangles, count);
            let material = self.material(primitive.count("material")?, primitive)?;
            self.report_attributes(primitive, &attributes, &vertices, count)?;
            let geometry = self.geometry(&attributes, &positions, vertices, &material)?;
            let GltfMaterial { index, emission, alpha, medium: inside, .. } = material;
            let media = SurfaceMedia { inside, outside: None };
            Ok(Some(ShapeDescription { material: index, emission, alpha, media, ..geometry.into() }))
        })
    }

    /// The accessor of an attribute.
    pub(super) fn attribute(
        &mut self,
        attributes: &JsonObject<'_>,
        name: &str,
        needed: ElementType,
    ) -> Result<Option<Accessor<'a>>, GltfError> {
        let Some(number) = attributes.count(name)? else { return Ok(None) };
        self.accessor(number, needed, &attributes.path().name(name)).map(Some)
    }

    /// Numbers of the vertices at the corners, all below `count`.
    fn corners(&mut self, primitive: &JsonObject<'_>, count: usize) -> Result<Vec<u32>, GltfError> {
        let Some(number) = primitive.count("indices")? else {
            self.count_elements(count, primitive.path())?;
            self.reserve(BYTES_PER_CORNER.saturating_mul(count as u64), primitive.path())?;
            return Ok((0..count as u32).collect());
        };
        let path = primitive.path().name("indices");
        let indices = self.accessor(number, SCALAR, &path)?;
        self.count_elements(indices.count(), &path)?;
        // Here they only have to fit.
        self.reserve(BYTES_PER_CORNER.saturating_mul(indices.count() as u64), &path)?;
        let corners: Vec<u32> = (0..indices.count()).map(|i| indices.number(i)).collect();
        match corners.iter().position(|&corner| corner as usize >= count) {
            Some(wrong) => {
                let corner = corners.get(wrong).copied().unwrap_or_default();
                Err(path.error(format!("index {wrong} is vertex {corner}; there are {count}")))
            }
            None => Ok(corners),
        }
    }

    fn geometry(
        &mut self,
        attributes: &JsonObject<'_>,
        positions: &Accessor<'_>,
        vertices: UsedVertices,
        material: &GltfMaterial,
    ) -> Result<GeometryDescription, GltfError> {
        let of_vertices =
            |accessor: &Accessor<'_>, name: &str| check_count(attributes, name, accessor, positions.count());
        let normals = match self.attribute(attributes, "NORMAL", VEC3)? {
            Some(accessor) => {
                of_vertices(&accessor, "NORMAL")?;
                self.spend(vertices.bytes::<DVec3>(), attributes.path())?;
                let finite = |n: DVec3| if n.is_finite() { n } else { DVec3::ZERO };
                Some(vertices.values(&accessor, [0.0; 3], |n| finite(n.into())))
            }
            None => None,
        };
        let uvs = match material.uv {
            Some(uv) => {
                let name = format!("TEXCOORD_{}", uv.set);
                match self.attribute(attributes, &name, VEC2)? {
                    Some(accessor) => {
                        of_vertices(&accessor, &name)?;
                        self.spend(vertices.bytes::<DVec2>(), attributes.path())?;
                        let mut uvs = vertices.values(&accessor, [0.0; 2], |found| {
                            let DVec2 { x, y } = uv.transform.apply(found.into());
                            // Pictures have their origin at the top here.
                            if x.is_finite() && y.is_finite() { DVec2::new(x, 1.0 - y) } else { DVec2::ZERO }
                        });
                        self.place_in_picture(&mut uvs, material, attributes);
                        Some(uvs)
                    }
                    None => {
                        let message = format!("{}: a textured primitive has no {name}", attributes.path());
                        self.reader.stand_in("gltf-coordinates", None, message);
                        None
                    }
                }
            }
            None => None,
        };
        self.spend(vertices.bytes::<DVec3>(), attributes.path())?;
        let points: Vec<DVec3> = vertices.values(positions, [0.0; 3], DVec3::from);
        if let Some(wrong) = points.iter().position(|point| !point.is_finite()) {
            let vertex = vertices.used.get(wrong).copied().unwrap_or_default();
            return Err(attributes.error("POSITION", format!("vertex {vertex} is not finite")));
        }
        Ok(GeometryDescription::Triangles { positions: points, indices: vertices.triangles, normals, uvs })
    }

    /// Moves the coordinates of a picture of emitted light, which does not repeat, by whole pictures, or reports that this does not suffice.
    fn place_in_picture(&mut self, uvs: &mut [DVec2], material: &GltfMaterial, attributes: &JsonObject<'_>) {
        if !material.is_repeated {
            return;
        }
        match repetition(uvs).filter(|whole| *whole == DVec2::ZERO || material.is_periodic) {
            Some(whole) => uvs.iter_mut().for_each(|uv| *uv -= whole),
            None => {
                let message = format!(
                    "{}: the emissive texture does not repeat; its border continues",
                    attributes.path()
                );
                self.reader.stand_in("gltf-emission", None, message);
            }
        }
    }

    /// Reports what the description cannot represent. `count`: number of vertices, of which some are used.
    fn report_attributes(
        &mut self,
        primitive: &JsonObject<'_>,
        attributes: &JsonObject<'_>,
        vertices: &UsedVertices,
        count: usize,
    ) -> Result<(), GltfError> {
        if let Some(colors) = self.attribute(attributes, "COLOR_0", COLOR)? {
            check_count(attributes, "COLOR_0", &colors, count)?;
            let is_white = |vertex: u32| colors.vector(vertex as usize, [1.0; 4]) == [1.0; 4];
            if !vertices.used.iter().copied().all(is_white) {
                let message = format!("{}: vertex colours are not available and left out", primitive.path());
                self.reader.stand_in("gltf-colors", None, message);
            }
        }
        if primitive.has("targets") {
            let message =
                format!("{}: morph targets are not read; the base mesh stands in", primitive.path());
            self.reader.stand_in("gltf-morph", None, message);
        }
        Ok(())
    }

    fn accessor(
        &mut self,
        number: usize,
        needed: ElementType,
        path: &JsonPath<'_>,
    ) -> Result<Accessor<'a>, GltfError> {
        let accessor = Accessor::open((self.document, self.buffers), number, needed, path)?;
        self.use_elements(accessor.replaced(), path)?;
        Ok(accessor)
    }

    /// Takes memory off the budget.
    pub(super) fn spend(&self, bytes: u64, path: &JsonPath<'_>) -> Result<(), GltfError> {
        let budget = &self.reader.finder.budget;
        let spent = budget.check().and_then(|()| budget.spend(Resource::Memory, bytes));
        spent.map_err(|end| path.error(end.to_string()))
    }

    /// Takes a shape, instance or light with its memory off the budget.
    pub(super) fn spend_object(&self, bytes: u64, path: &JsonPath<'_>) -> Result<(), GltfError> {
        let spent = self.reader.finder.budget.spend(Resource::Objects, 1);
        spent.map_err(|end| path.error(end.to_string()))?;
        self.spend(bytes, path)
    }

    /// Reserves memory of the budget.
    fn reserve(&self, bytes: u64, path: &JsonPath<'_>) -> Result<MemoryReservation, GltfError> {
        self.reader.finder.budget.reserve(bytes).map_err(|end| path.error(end.to_string()))
    }

    /// Counts elements that are used, so that the time is in proportion to the size of the file.
    fn count_elements(&mut self, count: usize, path: &JsonPath<'_>) -> Result<(), GltfError> {
        self.elements_left = self.elements_left.checked_sub(count).ok_or_else(|| path.error(TOO_MUCH))?;
        Ok(())
    }

    /// Counts elements that are used, and takes their memory off the budget.
    pub(super) fn use_elements(&mut self, count: usize, path: &JsonPath<'_>) -> Result<(), GltfError> {
        self.count_elements(count, path)?;
        self.spend(BYTES_PER_ELEMENT.saturating_mul(count as u64), path)
    }
}
