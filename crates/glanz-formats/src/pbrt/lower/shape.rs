//! `Shape`.

use std::f64::consts::TAU;

use glanz_job::Resource;
use glanz_math::{DMat4, DVec2, DVec3};
use glanz_scene::description::{
    AlphaDescription, EmissionDescription, FloatParameter, GeometryDescription, ShapeDescription,
};

use super::{EntityState, Lowering};
use crate::file_list::FileKind;
use crate::model::face_count;
use crate::nearest::nearest;
use crate::pbrt::parameters::{Parameter, ParameterList, shortened};
use crate::ply;
use crate::source::{MISSING_FILE, ParseResult, Span};

/// Names of the shapes, for suggestions.
const SHAPES: &[&str] = &[
    "sphere",
    "cylinder",
    "cone",
    "paraboloid",
    "hyperboloid",
    "disk",
    "trianglemesh",
    "plymesh",
    "bilinearmesh",
    "loopsubdiv",
    "twosheetedhyperboloid",
    "plane",
    "algebraic",
    "torus",
    "polyhedron",
    "box",
    "nurbs",
    "bezierpatch",
    "beziertriangle",
    "patchmesh",
    "curve",
    "heightfield",
    "step",
    "iges",
    "gltf",
    "obj",
    "stl",
];

impl Lowering {
    /// Adds a shape.
    pub(crate) fn shape(
        &mut self,
        kind: &str,
        mut list: ParameterList,
        context: &EntityState,
    ) -> ParseResult<()> {
        if matches!(kind, "step" | "iges") {
            return self.cad_shape(list, context);
        }
        if kind == "gltf" {
            return self.gltf_shape(list, context);
        }
        let place = list.place;
        let design = self.design_of_shape(kind, &mut list, context)?;
        let surfaces = match kind {
            "bezierpatch" | "patchmesh" if list.has("filename") => self.patch_file(&mut list)?,
            "obj" | "stl" => self.mesh_file(kind, &mut list)?,
            "curve" => self.curve(&mut list)?,
            _ => Vec::from_iter(self.geometry(kind, &mut list)?),
        };
        if surfaces.is_empty() {
            return Ok(());
        }
        let alpha = self.alpha(&mut list)?;
        let trim = self.trim(&mut list)?;
        let solid = list.integer_from("solid", 0, &mut self.reporter)?;
        let receiver = self.receiver(&mut list)?;
        self.check_free(&design, &list)?;
        list.finish(&mut self.reporter);
        let material = match context.material {
            Some(index) => index,
            None => self.default_material(&place),
        };
        let emission = context.emission.as_deref().cloned();
        if let (Some(_), Some(object)) = (&emission, &mut self.object) {
            object.lights = surfaces.iter().map(face_count).fold(object.lights, usize::saturating_add);
        }
        self.check_power(kind, emission.as_ref(), surfaces.len(), &place)?;
        let offset = DMat4::from_translation(design.offset);
        self.add_design(design, &surfaces)?;
        for geometry in surfaces {
            let shape = ShapeDescription {
                geometry,
                to_parent: context.ctm * offset,
                reverse_orientation: context.reverse_orientation,
                material,
                media: context.media,
                emission: emission.clone(),
                trim: trim.clone(),
                solid,
                receiver: receiver.clone(),
                alpha,
                location: Some(place.location),
            };
            self.reporter.spend(&place, Resource::Objects, 1)?;
            self.reporter.spend(&place, Resource::Memory, shape.bytes())?;
            self.current_group().shapes.push(shape);
        }
        Ok(())
    }

    /// Refuses an emission whose power many surfaces would have to share.
    pub(super) fn check_power(
        &mut self,
        kind: &str,
        emission: Option<&EmissionDescription>,
        surfaces: usize,
        place: &Span,
    ) -> ParseResult<()> {
        if surfaces <= 1 || emission.is_none_or(|emission| emission.power.is_none()) {
            return Ok(());
        }
        let message = format!("shape {kind:?}: it has {surfaces} surfaces, which cannot share one power");
        let help = Some("give the light its radiance \"L\", or one shape per surface".to_owned());
        Err(self.reporter.error_with_help(place, "light-power", message, help))
    }

    /// The surface; `None`, after a report, if there is no substitute.
    fn geometry(&mut self, kind: &str, list: &mut ParameterList) -> ParseResult<Option<GeometryDescription>> {
        let made = match kind {
            "sphere" => {
                let radius = self.float(list, "radius", 1.0)?;
                let z = self.z_range(list, [-radius, radius])?;
                GeometryDescription::Sphere { radius, z, phi_max: self.phi_max(list)? }
            }
            "cylinder" => GeometryDescription::Cylinder {
                radius: self.float(list, "radius", 1.0)?,
                z: self.z_range(list, [-1.0, 1.0])?,
                phi_max: self.phi_max(list)?,
            },
            "cone" => GeometryDescription::Cone {
                radius: self.float(list, "radius", 1.0)?,
                height: self.float(list, "height", 1.0)?,
                phi_max: self.phi_max(list)?,
            },
            "paraboloid" => GeometryDescription::Paraboloid {
                radius: self.float(list, "radius", 1.0)?,
                z: self.z_range(list, [0.0, 1.0])?,
                phi_max: self.phi_max(list)?,
            },
            "hyperboloid" => GeometryDescription::Hyperboloid {
                p1: list.vec3("p1", &mut self.reporter)?.unwrap_or(DVec3::ZERO),
                p2: list.vec3("p2", &mut self.reporter)?.unwrap_or(DVec3::ONE),
                phi_max: self.phi_max(list)?,
            },
            "disk" => GeometryDescription::Disk {
                height: self.float(list, "height", 0.0)?,
                radius: self.float(list, "radius", 1.0)?,
                inner_radius: self.float(list, "innerradius", 0.0)?,
                phi_max: self.phi_max(list)?,
            },
            "trianglemesh" => self.triangle_mesh(list)?,
            "loopsubdiv" => self.loop_subdivision(list)?,
            "bilinearmesh" => self.bilinear_mesh(list)?,
            "plymesh" => self.ply_mesh(list)?,
            "twosheetedhyperboloid" | "plane" | "algebraic" | "torus" | "polyhedron" | "box" => {
                self.extension(kind, list)?
            }
            "nurbs" | "bezierpatch" | "beziertriangle" | "patchmesh" => self.freeform(kind, list)?,
            other => {
                self.left_out(other, list);
                return Ok(None);
            }
        };
        Ok(Some(made))
    }

    /// Warns that a shape has no substitute.
    fn left_out(&mut self, kind: &str, list: &ParameterList) {
        let known = SHAPES.contains(&kind);
        let what = if known { "is not available yet" } else { "is unknown" };
        let message = format!("shape {:?} {what} and left out", shortened(kind));
        let help =
            nearest(kind, SHAPES.iter().copied()).filter(|_| !known).map(|n| format!("did you mean {n:?}?"));
        match help {
            Some(help) if !self.reporter.strict => {
                self.reporter.warning_with_help(&list.place, "stand-in-shape", message, Some(help));
            }
            _ => self.stand_in(&list.place, "stand-in-shape", message),
        }
    }

    pub(super) fn float(
        &mut self,
        list: &mut ParameterList,
        name: &'static str,
        default: f64,
    ) -> ParseResult<f64> {
        list.float_or(name, default, &mut self.reporter)
    }

    /// `zmin` and `zmax`, in either order as in pbrt.
    pub(super) fn z_range(&mut self, list: &mut ParameterList, default: [f64; 2]) -> ParseResult<[f64; 2]> {
        let a = self.float(list, "zmin", default[0])?;
        let b = self.float(list, "zmax", default[1])?;
        Ok([a.min(b), a.max(b)])
    }

    /// `phimax`, degrees, clamped to [0, 360] as in pbrt, or `phimaxradians`; in radians.
    pub(super) fn phi_max(&mut self, list: &mut ParameterList) -> ParseResult<f64> {
        if let Some(radians) = list.float("phimaxradians", &mut self.reporter)? {
            return Ok(radians.clamp(0.0, TAU));
        }
        Ok(self.float(list, "phimax", 360.0)?.clamp(0.0, 360.0).to_radians())
    }

    /// The opacity: `alpha`, and as a factor for shadow rays `shadowalpha` of version 3.
    pub(super) fn alpha(&mut self, list: &mut ParameterList) -> ParseResult<Option<AlphaDescription>> {
        let opacity = self.optional_float(list, "alpha")?;
        let shadow = self.optional_float(list, "shadowalpha")?;
        let given = |opacity: Option<FloatParameter>| opacity.unwrap_or(FloatParameter::Value(1.0));
        let alpha = AlphaDescription { opacity: given(opacity), shadow: given(shadow) };
        Ok((opacity.is_some() || shadow.is_some()).then_some(alpha))
    }

    fn triangle_mesh(&mut self, list: &mut ParameterList) -> ParseResult<GeometryDescription> {
        let (p, positions) = self.positions(list)?;
        let indices = self.corners::<3>(list, &p, positions.len())?;
        let normals = self.vertex_normals(list, positions.len())?;
        let uvs = self.vertex_uvs(list, positions.len())?;
        list.ignore(&["S", "faceIndices", "discarddegenerateUVs"]);
        Ok(GeometryDescription::Triangles { positions, indices, normals, uvs })
    }

    fn bilinear_mesh(&mut self, list: &mut ParameterList) -> ParseResult<GeometryDescription> {
        let (p, positions) = self.positions(list)?;
        let indices = self.corners::<4>(list, &p, positions.len())?;
        for name in ["N", "uv", "emissionfilename"] {
            let place = list.value_place(name);
            if list.take(name).is_some() {
                let message = format!(
                    "shape \"bilinearmesh\": {name:?} is not available yet; the patches' own stand in"
                );
                self.stand_in(&place, "stand-in-shape", message);
            }
        }
        list.ignore(&["faceIndices"]);
        Ok(GeometryDescription::Bilinear { positions, indices })
    }

    pub(super) fn positions(&mut self, list: &mut ParameterList) -> ParseResult<(Parameter, Vec<DVec3>)> {
        if let Some(found) = list.vec3s("P", &mut self.reporter)? {
            return Ok(found);
        }
        let message = format!("{} has no points \"P\"", list.subject);
        Err(self.reporter.error(&list.place, "parameter-missing", message))
    }

    /// Groups of `N` vertex indices. Without `indices`, `N` points form one face.
    pub(super) fn corners<const N: usize>(
        &mut self,
        list: &mut ParameterList,
        points: &Parameter,
        count: usize,
    ) -> ParseResult<Vec<[u32; N]>> {
        let Some((p, indices)) = list.integers("indices", &mut self.reporter)? else {
            if count == N {
                return Ok(vec![std::array::from_fn(|i| i as u32)]);
            }
            let message = format!("{} has {count} points and no \"indices\"", list.subject);
            return Err(self.reporter.error(&points.place, "parameter-missing", message));
        };
        if !indices.len().is_multiple_of(N) {
            let n = indices.len();
            let message = format!(
                "{}: parameter \"indices\" has {n} values; a multiple of {N} is needed",
                list.subject
            );
            return Err(self.reporter.error(&p.value_place, "parameter-count", message));
        }
        let limit = i64::try_from(count).unwrap_or(i64::MAX);
        if let Some(wrong) = indices.iter().position(|&i| i64::from(i) >= limit || i < 0) {
            let (value, face) = (indices.get(wrong).copied().unwrap_or_default(), wrong / N);
            let message = format!("{}: face {face} refers to point {value}; there are {count}", list.subject);
            let help = Some("points are counted from 0".to_owned());
            return Err(self.reporter.error_with_help(&p.value_place, "vertex-index", message, help));
        }
        Ok(indices.chunks_exact(N).map(|c| std::array::from_fn(|i| c[i].unsigned_abs())).collect())
    }

    fn vertex_normals(&mut self, list: &mut ParameterList, count: usize) -> ParseResult<Option<Vec<DVec3>>> {
        let Some((p, normals)) = list.vec3s("N", &mut self.reporter)? else { return Ok(None) };
        if normals.len() == count {
            return Ok(Some(normals));
        }
        self.not_per_vertex(list, &p, normals.len(), count);
        Ok(None)
    }

    /// `uv`, also called `st`.
    fn vertex_uvs(&mut self, list: &mut ParameterList, count: usize) -> ParseResult<Option<Vec<DVec2>>> {
        let st = list.vec2s("st", &mut self.reporter)?;
        let Some((p, uvs)) = list.vec2s("uv", &mut self.reporter)?.or(st) else { return Ok(None) };
        if uvs.len() == count {
            return Ok(Some(uvs));
        }
        self.not_per_vertex(list, &p, uvs.len(), count);
        Ok(None)
    }

    /// Warns that values were ignored because their number differs from that of the points.
    fn not_per_vertex(&mut self, list: &ParameterList, p: &Parameter, found: usize, count: usize) {
        let message = format!(
            "{}: {:?} is given for {found} points, but there are {count}; it is left out",
            list.subject, p.name
        );
        self.stand_in(&p.value_place, "vertex-count", message);
    }

    fn ply_mesh(&mut self, list: &mut ParameterList) -> ParseResult<GeometryDescription> {
        let Some((p, name)) = list.text_parameter("filename", &mut self.reporter)? else {
            let message = "shape \"plymesh\" has no \"string filename\"";
            return Err(self.reporter.error(&list.place, "parameter-missing", message));
        };
        let place = list.value_place("displacement");
        if list.take("displacement").is_some() {
            let message =
                "shape \"plymesh\": \"displacement\" is not available yet; the smooth surface stands in";
            self.stand_in(&place, "stand-in-bumps", message);
        }
        list.ignore(&["edgelength"]);
        let (path, bytes) = match self.read_file(&name, FileKind::Mesh) {
            Ok(read) => read,
            Err(problem) => {
                let message = format!("shape \"plymesh\": {problem}");
                return Err(self.reporter.error(&p.value_place, MISSING_FILE, message));
            }
        };
        match ply::read_with(&bytes, &self.finder.budget) {
            Ok(mesh) => {
                if mesh.skipped_faces > 0 {
                    let message = format!(
                        "shape \"plymesh\": {} faces of {name:?} have fewer than three corners and are left out",
                        mesh.skipped_faces
                    );
                    self.reporter.warning(&p.value_place, "ply-faces", message);
                }
                let ply::PlyMesh { positions, normals, uvs, triangles: indices, .. } = mesh;
                Ok(GeometryDescription::Triangles { positions, indices, normals, uvs })
            }
            Err(error) => {
                let between = match error.position {
                    ply::PlyPosition::Text { .. } => ":",
                    ply::PlyPosition::Byte(_) => ": ",
                };
                let message = format!("shape \"plymesh\": {}{between}{error}", path.display());
                Err(self.reporter.error(&p.value_place, "ply", message))
            }
        }
    }
}
