//! From a boundary representation to the description of a scene.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use glanz_brep::boundary::BoundaryCurve;
use glanz_brep::face::{FaceGeometry, FaceTrim, TrimmedFace, TrimmedFaces};
use glanz_brep::model::{Body, BrepModel, ColorStyle, Occurrence, Part};
use glanz_geometry::spline::NurbsSurface;
use glanz_light::rgb::srgb_decode;
use glanz_math::DMat4;
use glanz_scene::description::{
    EmissionDescription, GeometryDescription, GroupDescription, InstanceDescription, MaterialDescription,
    NurbsDescription, ShapeDescription, TrimCurveDescription, TrimDescription, TrimEdgeDescription,
    TrimLoopDescription,
};
use glanz_scene::studio::{CAD_GREY, cad_material};
use glanz_scene::{Description, Location};

use super::describe_edges::BodyEdges;
use super::occurrence_colors::{ActiveOverrides, ColorKey, OverrideIndex};

/// Selection and appearance of what a description shows of a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct CadSettings {
    /// Name of the parts and occurrences that are shown, where they are in the whole; `None`: all.
    pub(crate) part: Option<String>,
    /// Materials by the name of a face, a body, an occurrence or a part; the innermost counts, and an occurrence before its part.
    pub(crate) materials: BTreeMap<String, usize>,
    /// Material of the others; `None`: the colors of the file.
    pub(crate) others: Option<usize>,
    /// Emission of all faces.
    pub(crate) emission: Option<Rc<EmissionDescription>>,
}

/// What parts and faces take over from the occurrences around them.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
struct InheritedStyle {
    color: Option<ColorKey>,
    overrides: ActiveOverrides,
    material: Option<usize>,
    shown: bool,
}

/// A part and the style that its occurrences bring.
type GroupKey = (usize, InheritedStyle);

/// Copies of the model in different colors, at most, without [`FREE_COPIES`]: beyond, occurrences bring no colors.
const MAX_COPIES: usize = 32;

/// Control points and instances that are copied in any case.
const FREE_COPIES: usize = 100_000;

/// Colors and paths that are handed on from occurrences to those inside of them in any case: about a second of work.
const FREE_STEPS: usize = 20_000_000;

/// A scene made of what a file shows: parts are groups, their occurrences instances. Faces that were refused are left out.
///
/// A part whose occurrences bring different styles has a group for each of them; one without surfaces has none.
pub(super) struct CadScene<'a> {
    model: &'a BrepModel,
    faces: &'a TrimmedFaces,
    settings: &'a CadSettings,
    /// That of all shapes in the input.
    location: Option<Location>,
    description: &'a mut Description,
    overrides: OverrideIndex<'a>,
    groups: HashMap<GroupKey, Option<usize>>,
    /// Control points and instances that may still be copied for different colors.
    copies_left: usize,
    /// Colors and paths that may still be handed on.
    steps_left: usize,
    /// The face of each shape of each group, by its index.
    pub(super) faces_of_groups: Vec<Vec<usize>>,
    materials: HashMap<Option<ColorKey>, usize>,
    /// Number of closed shells so far.
    solids: u32,
}

impl<'a> CadScene<'a> {
    pub(super) fn new(
        (model, faces): (&'a BrepModel, &'a TrimmedFaces),
        settings: &'a CadSettings,
        location: Option<Location>,
        description: &'a mut Description,
    ) -> Self {
        let occurrences: usize = model.parts.iter().map(|part| part.occurrences.len()).sum();
        let all = faces.faces.iter().flatten().map(size).sum::<usize>() + occurrences + model.roots.len();
        Self {
            model,
            faces,
            settings,
            location,
            description,
            overrides: OverrideIndex::new(&model.overrides),
            groups: HashMap::new(),
            copies_left: all.saturating_mul(MAX_COPIES).saturating_add(FREE_COPIES),
            steps_left: all.saturating_mul(MAX_COPIES).saturating_add(FREE_STEPS),
            faces_of_groups: Vec::new(),
            materials: HashMap::new(),
            solids: 0,
        }
    }

    /// The group of the whole file, which is not part of the description, and the face of each of its shapes. Those inside are added.
    ///
    /// What occurs once, in the frame of the world, is the group itself.
    pub(super) fn whole(&mut self) -> (GroupDescription, Vec<usize>) {
        let outside = InheritedStyle { shown: self.settings.part.is_none(), ..InheritedStyle::default() };
        match self.model.roots.as_slice() {
            [only] if only.to_parent == DMat4::IDENTITY => {
                let Some(part) = self.model.parts.get(only.part) else { return Default::default() };
                let style = self.inherited(&outside, only, part);
                self.group(part, &style)
            }
            roots => {
                let instances = self.instances(roots, &outside);
                (GroupDescription { instances, ..GroupDescription::default() }, Vec::new())
            }
        }
    }

    /// The material that the settings give to what has one of these names.
    fn named_material(&self, names: [&str; 2]) -> Option<usize> {
        names.iter().find_map(|name| self.settings.materials.get(*name)).copied()
    }

    /// Whether colors of occurrences are left out, because there would be too many copies of parts, or too many colors to hand on.
    pub(super) fn is_exhausted(&self) -> bool {
        self.copies_left == 0 || self.steps_left == 0
    }

    fn inherited(
        &mut self,
        outside: &InheritedStyle,
        occurrence: &Occurrence,
        part: &Part,
    ) -> InheritedStyle {
        let names = [occurrence.name.as_str(), part.name.as_str()];
        let shown = self.settings.part.as_deref().is_some_and(|name| names.contains(&name));
        let inside = InheritedStyle {
            material: self.named_material(names).or(outside.material),
            shown: outside.shown || shown,
            ..InheritedStyle::default()
        };
        // Without use colors would make groups that differ in nothing else.
        if self.settings.others.is_some() || self.is_exhausted() {
            return inside;
        }
        let steps = self.overrides.steps(&outside.overrides, occurrence.entity);
        self.steps_left = self.steps_left.saturating_sub(steps);
        InheritedStyle {
            color: occurrence.style.map(ColorKey::from).or(outside.color),
            overrides: self.overrides.inside(&outside.overrides, occurrence.entity),
            ..inside
        }
    }

    fn instances(
        &mut self,
        occurrences: &[Occurrence],
        outside: &InheritedStyle,
    ) -> Vec<InstanceDescription> {
        let mut instances = Vec::with_capacity(occurrences.len());
        for occurrence in occurrences {
            let Some(part) = self.model.parts.get(occurrence.part) else { continue };
            let style = self.inherited(outside, occurrence, part);
            let key = (occurrence.part, style);
            let group = if let Some(&group) = self.groups.get(&key) {
                group
            } else {
                // Parts refer to parts before them only, so that this ends.
                let (group, faces) = self.group(part, &key.1);
                let number = (!group.shapes.is_empty() || !group.instances.is_empty()).then(|| {
                    self.description.groups.push(group);
                    self.faces_of_groups.push(faces);
                    self.description.groups.len() - 1
                });
                self.groups.insert(key, number);
                number
            };
            let Some(group) = group else { continue };
            let (name, to_parent) = (occurrence.name.clone(), occurrence.to_parent);
            instances.push(InstanceDescription { name, group, to_parent, location: self.location });
        }
        instances
    }

    /// The group of a part, and the face of each of its shapes.
    fn group(&mut self, part: &Part, style: &InheritedStyle) -> (GroupDescription, Vec<usize>) {
        // Before those inside, so that groups without a shape count, too.
        self.copies_left = self.copies_left.saturating_sub(1 + style.overrides.len());
        let mut group = GroupDescription { name: part.name.clone(), ..GroupDescription::default() };
        let mut faces = Vec::new();
        for body in part.bodies.iter().filter(|_| style.shown) {
            self.body(body, style, &mut group, &mut faces);
        }
        group.instances = self.instances(&part.occurrences, style);
        let sizes = faces.iter().filter_map(|face| self.faces.faces.get(*face)?.as_ref().ok());
        let polylines = group.edges.iter().map(|edge| edge.points.len());
        let made = sizes.map(size).sum::<usize>() + group.instances.len() + polylines.sum::<usize>();
        self.copies_left = self.copies_left.saturating_sub(made);
        (group, faces)
    }

    fn body(
        &mut self,
        body: &Body,
        inherited: &InheritedStyle,
        group: &mut GroupDescription,
        faces: &mut Vec<usize>,
    ) {
        // A shell without some of its faces bounds no volume; the voids of a solid bound the same as its outer shell.
        let made = |&(index, _): &(usize, bool)| matches!(self.faces.faces.get(index), Some(Ok(_)));
        let closed: Vec<bool> =
            body.shells.iter().map(|shell| shell.closed && shell.faces.iter().all(made)).collect();
        let solid = (body.solid && closed.iter().all(|&closed| closed)).then(|| self.next_solid());
        let polylines = self.faces.edges.as_deref();
        let mut edges = polylines.map(|_| BodyEdges::default());
        for (shell, closed) in body.shells.iter().zip(closed) {
            let number = solid.or_else(|| (closed && !body.solid).then(|| self.next_solid()));
            for &(index, reversed) in &shell.faces {
                let (Some(face), Some(Ok(trimmed))) =
                    (self.model.faces.get(index), self.faces.faces.get(index))
                else {
                    continue;
                };
                let named = self.named_material([&face.name, &body.name]).or(inherited.material);
                let material = match named.or(self.settings.others) {
                    Some(material) => material,
                    None => {
                        let items = [face.entity, shell.entity, body.entity];
                        let overriding = self.overrides.color(&inherited.overrides, items);
                        let own = face.style.or(body.style).map(ColorKey::from);
                        self.color_material(overriding.or(own).or(inherited.color))
                    }
                };
                if let Some(edges) = &mut edges {
                    edges.add(group.shapes.len(), trimmed, reversed);
                }
                faces.push(index);
                group.shapes.push(ShapeDescription {
                    to_parent: trimmed.to_part,
                    reverse_orientation: trimmed.reversed != reversed,
                    material,
                    trim: trimmed.trim.as_ref().map(|cut| trim(cut, self.model)),
                    solid: number,
                    emission: self.settings.emission.as_deref().cloned(),
                    location: self.location,
                    ..geometry(trimmed).into()
                });
            }
        }
        if let Some((edges, polylines)) = edges.zip(polylines) {
            edges.describe(self.model, (polylines, &self.faces.widths), &mut group.edges);
        }
    }

    /// The number of a solid that no shape has yet.
    fn next_solid(&mut self) -> u32 {
        self.solids += 1;
        self.solids - 1
    }

    fn color_material(&mut self, color: Option<ColorKey>) -> usize {
        if let Some(&number) = self.materials.get(&color) {
            return number;
        }
        let (rgb, transparency) = color.map_or((CAD_GREY, 0.0), |color| {
            let style = ColorStyle::from(color);
            (style.rgb.map(|c| srgb_decode(c as f32)), style.transparency as f32)
        });
        let material = MaterialDescription::from(cad_material(rgb, transparency));
        self.description.materials.push(material);
        let number = self.description.materials.len() - 1;
        self.materials.insert(color, number);
        number
    }
}

/// The size of a shape: its control points, and those of its boundary.
fn size(face: &TrimmedFace) -> usize {
    let points = match &face.geometry {
        FaceGeometry::Spline(surface) => surface.control_points().len(),
        _ => 1,
    };
    let loops = face.trim.iter().flat_map(|trim| &trim.loops);
    loops.flatten().fold(points, |points, curve| points + curve.points.len())
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

fn trim(trim: &FaceTrim, model: &BrepModel) -> TrimDescription {
    let curve = |curve: &BoundaryCurve| TrimCurveDescription {
        degree: curve.degree,
        knots: curve.knots.clone(),
        points: curve.points.iter().map(|point| point.to_array()).collect(),
        width: Some(curve.width),
        edge: trim_edge(curve, model),
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

fn trim_edge(curve: &BoundaryCurve, model: &BrepModel) -> Option<TrimEdgeDescription> {
    let number = curve.edge?;
    let edge = model.edges.get(number)?;
    let small = |index: usize| u32::try_from(index).ok();
    Some(TrimEdgeDescription {
        edge: small(number)?,
        vertices: [small(edge.start)?, small(edge.end)?],
        range: curve.range,
    })
}
