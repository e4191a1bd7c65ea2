//! From a boundary representation to the description of a scene.

use std::collections::HashMap;

use glanz_brep::boundary::BoundaryCurve;
use glanz_brep::face::{FaceGeometry, FaceTrim, TrimmedFace, TrimmedFaces};
use glanz_brep::model::{Body, BrepModel, ColorStyle, Occurrence, Part};
use glanz_geometry::spline::NurbsSurface;
use glanz_light::rgb::srgb_decode;
use glanz_math::DMat4;
use glanz_scene::Description;
use glanz_scene::description::{
    GeometryDescription, GroupDescription, InstanceDescription, MaterialDescription, NurbsDescription,
    ShapeDescription, TrimCurveDescription, TrimDescription, TrimLoopDescription,
};
use glanz_scene::studio::{CAD_GREY, cad_material};

/// Adds what the file shows to a description: parts as groups, their occurrences as instances. Faces that were refused are left out.
///
/// A part whose occurrences bring different colors has a group for each of them. What occurs once, in the frame of the world, belongs
/// to the world itself. Returns the face of each shape, by its index: shapes of the groups in their order, then those of the world.
pub(super) fn describe(model: &BrepModel, faces: &TrimmedFaces, description: &mut Description) -> Vec<usize> {
    let mut scene = CadScene {
        model,
        faces,
        description,
        groups: HashMap::new(),
        faces_of_groups: Vec::new(),
        materials: HashMap::new(),
        solids: 0,
    };
    let (world, faces_of_world) = match model.roots.as_slice() {
        [only] if only.to_parent == DMat4::IDENTITY => {
            model.parts.get(only.part).map(|part| scene.group(part, only.style)).unwrap_or_default()
        }
        roots => (
            GroupDescription { instances: scene.instances(roots, None), ..GroupDescription::default() },
            Vec::new(),
        ),
    };
    scene.description.world.shapes.extend(world.shapes);
    scene.description.world.instances.extend(world.instances);
    scene.faces_of_groups.into_iter().chain([faces_of_world]).flatten().collect()
}

/// A color as a key: its bits.
type StyleKey = Option<[u64; 4]>;

struct CadScene<'a> {
    model: &'a BrepModel,
    faces: &'a TrimmedFaces,
    description: &'a mut Description,
    /// Groups by part and the color that its occurrences bring.
    groups: HashMap<(usize, StyleKey), usize>,
    /// The face of each shape of each group, by its index.
    faces_of_groups: Vec<Vec<usize>>,
    materials: HashMap<StyleKey, usize>,
    /// Number of closed shells so far.
    solids: u32,
}

impl CadScene<'_> {
    fn instances(
        &mut self,
        occurrences: &[Occurrence],
        inherited: Option<ColorStyle>,
    ) -> Vec<InstanceDescription> {
        let mut instances = Vec::with_capacity(occurrences.len());
        for occurrence in occurrences {
            let Some(part) = self.model.parts.get(occurrence.part) else { continue };
            let style = occurrence.style.or(inherited);
            let key = (occurrence.part, style_key(style));
            let group = if let Some(&group) = self.groups.get(&key) {
                group
            } else {
                // Parts refer to parts before them only, so that this ends.
                let (group, faces) = self.group(part, style);
                self.description.groups.push(group);
                self.faces_of_groups.push(faces);
                let number = self.description.groups.len() - 1;
                self.groups.insert(key, number);
                number
            };
            instances.push(InstanceDescription { group, to_parent: occurrence.to_parent, location: None });
        }
        instances
    }

    /// The group of a part, and the face of each of its shapes.
    fn group(&mut self, part: &Part, inherited: Option<ColorStyle>) -> (GroupDescription, Vec<usize>) {
        let (mut shapes, mut faces) = (Vec::new(), Vec::new());
        for body in &part.bodies {
            self.body(body, inherited, &mut shapes, &mut faces);
        }
        let instances = self.instances(&part.occurrences, inherited);
        (GroupDescription { name: part.name.clone(), shapes, instances }, faces)
    }

    fn body(
        &mut self,
        body: &Body,
        inherited: Option<ColorStyle>,
        shapes: &mut Vec<ShapeDescription>,
        faces: &mut Vec<usize>,
    ) {
        // The voids of a solid bound the same volume as its outer shell.
        let solid = body.solid.then(|| {
            self.solids += 1;
            self.solids - 1
        });
        for shell in &body.shells {
            let number = solid.or_else(|| {
                shell.closed.then(|| {
                    self.solids += 1;
                    self.solids - 1
                })
            });
            for &(index, reversed) in &shell.faces {
                let (Some(face), Some(Ok(trimmed))) =
                    (self.model.faces.get(index), self.faces.faces.get(index))
                else {
                    continue;
                };
                let material = self.material(face.style.or(body.style).or(inherited));
                faces.push(index);
                shapes.push(ShapeDescription {
                    to_parent: trimmed.to_part,
                    reverse_orientation: trimmed.reversed != reversed,
                    material,
                    trim: trimmed.trim.as_ref().map(trim),
                    solid: number,
                    ..geometry(trimmed).into()
                });
            }
        }
    }

    fn material(&mut self, style: Option<ColorStyle>) -> usize {
        let key = style_key(style);
        if let Some(&number) = self.materials.get(&key) {
            return number;
        }
        let (rgb, transparency) = style.map_or((CAD_GREY, 0.0), |style| {
            (style.rgb.map(|c| srgb_decode(c as f32)), style.transparency as f32)
        });
        let material = MaterialDescription::from(cad_material(rgb, transparency));
        self.description.materials.push(material);
        let number = self.description.materials.len() - 1;
        self.materials.insert(key, number);
        number
    }
}

fn style_key(style: Option<ColorStyle>) -> StyleKey {
    style.map(|ColorStyle { rgb: [r, g, b], transparency }| [r, g, b, transparency].map(f64::to_bits))
}

fn geometry(face: &TrimmedFace) -> GeometryDescription {
    match face.geometry {
        FaceGeometry::Plane { x, y } => GeometryDescription::Plane { x, y },
        FaceGeometry::Cylinder { radius, z, phi_max } => GeometryDescription::Cylinder { radius, z, phi_max },
        FaceGeometry::Cone { radius, height, phi_max } => {
            GeometryDescription::Cone { radius, height, phi_max }
        }
        FaceGeometry::Sphere { radius, z, phi_max } => GeometryDescription::Sphere { radius, z, phi_max },
        FaceGeometry::Torus { major_radius, minor_radius, phi_max } => {
            GeometryDescription::Torus { major_radius, minor_radius, phi_max }
        }
        FaceGeometry::Spline(ref surface) => GeometryDescription::Nurbs(nurbs(surface)),
    }
}

fn nurbs(surface: &NurbsSurface) -> NurbsDescription {
    let (u, v) = (surface.knots_u(), surface.knots_v());
    NurbsDescription {
        degree_u: u.degree(),
        degree_v: v.degree(),
        knots_u: u.knots().to_vec(),
        knots_v: v.knots().to_vec(),
        points: surface.control_points().iter().map(|point| point.to_array()).collect(),
        domain: None,
    }
}

fn trim(trim: &FaceTrim) -> TrimDescription {
    let curve = |curve: &BoundaryCurve| TrimCurveDescription {
        degree: curve.degree,
        knots: curve.knots.clone(),
        points: curve.points.iter().map(|point| point.to_array()).collect(),
        width: Some(curve.width),
    };
    let [u, v] = trim.domain;
    TrimDescription {
        loops: trim
            .loops
            .iter()
            .map(|l| TrimLoopDescription { curves: l.iter().map(curve).collect() })
            .collect(),
        scale: trim.scale.to_array(),
        domain: Some([[u[0], v[0]], [u[1], v[1]]]),
    }
}
