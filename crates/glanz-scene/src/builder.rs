//! Scenes in code.

use glanz_math::DMat4;

use crate::description::{
    CameraDescription, Description, GroupDescription, InstanceDescription, LightDescription,
    MaterialDescription, MaterialKind, ShapeDescription,
};
use crate::error::{SceneError, SceneErrorKind, SceneWarning};
use crate::scene::Scene;

/// Builds a scene from code, as a file would describe it.
///
/// Materials and groups that are used several times have names. A name has to be added before it is used; one that is unknown is
/// an error of [`SceneBuilder::resolve`].
/// ```
/// use glanz_math::{DMat4, DVec3, Ray};
/// use glanz_scene::SceneBuilder;
/// use glanz_scene::description::{MaterialKind, ShapeDescription};
///
/// let pair = |group: SceneBuilder| {
///     let ball = ShapeDescription::sphere(0.5);
///     group.shape(ball.clone(), "red").shape(ball.translated([0.0, 0.0, 1.0]), MaterialKind::mirror(0.9))
/// };
/// let (scene, _) = SceneBuilder::new()
///     .material("red", MaterialKind::diffuse([0.8, 0.1, 0.1]))
///     .group("pair", pair)
///     .instance("pair", DMat4::from_translation(DVec3::X))
///     .instance("pair", DMat4::from_translation(-DVec3::X))
///     .resolve()?;
/// let hit = scene.intersect(&Ray::new(DVec3::new(1.0, 0.0, 9.0), -DVec3::Z), f64::INFINITY);
/// assert_eq!(hit.map(|hit| hit.t), Some(7.5));
/// # Ok::<(), glanz_scene::SceneError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct SceneBuilder {
    /// The group under construction is its world.
    description: Description,
    /// The first use of an unknown name.
    error: Option<SceneErrorKind>,
}

/// The material of a shape: its name in the scene, or a new one without a name.
#[derive(Clone, Debug)]
pub enum ShapeMaterial {
    /// A material added by [`SceneBuilder::material`].
    Named(String),
    /// A new material.
    New(Box<MaterialKind>),
}

impl From<&str> for ShapeMaterial {
    fn from(name: &str) -> Self {
        Self::Named(name.to_owned())
    }
}

impl From<MaterialKind> for ShapeMaterial {
    fn from(kind: MaterialKind) -> Self {
        Self::New(Box::new(kind))
    }
}

impl From<Description> for SceneBuilder {
    /// Continues a description, such as one that was read from a file.
    fn from(description: Description) -> Self {
        Self { description, error: None }
    }
}

impl SceneBuilder {
    /// An empty scene with the default camera, at the origin and looking along +z.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the camera.
    #[must_use]
    pub fn camera(mut self, camera: CameraDescription) -> Self {
        self.description.camera = camera;
        self
    }

    /// Sets the size of the picture, pixels.
    #[must_use]
    pub fn resolution(mut self, width: u32, height: u32) -> Self {
        self.description.film.resolution = [width, height];
        self
    }

    /// Adds a material with a name; a later one of the same name takes its place in shapes to come.
    #[must_use]
    pub fn material(mut self, name: impl Into<String>, kind: MaterialKind) -> Self {
        self.description.materials.push(MaterialDescription { name: name.into(), ..kind.into() });
        self
    }

    /// Adds a shape to the world, or to the group under construction.
    #[must_use]
    pub fn shape(self, shape: impl Into<ShapeDescription>, material: impl Into<ShapeMaterial>) -> Self {
        self.shapes([shape], material)
    }

    /// Adds shapes of one material to the world, or to the group under construction.
    #[must_use]
    pub fn shapes(
        mut self,
        shapes: impl IntoIterator<Item = impl Into<ShapeDescription>>,
        material: impl Into<ShapeMaterial>,
    ) -> Self {
        let material = match self.material_index(material.into()) {
            Ok(index) => index,
            Err(name) => return self.unknown("material", name),
        };
        let shapes = shapes.into_iter().map(|shape| ShapeDescription { material, ..shape.into() });
        self.description.world.shapes.extend(shapes);
        self
    }

    fn material_index(&mut self, material: ShapeMaterial) -> Result<usize, String> {
        let materials = &mut self.description.materials;
        match material {
            ShapeMaterial::New(kind) => {
                materials.push((*kind).into());
                Ok(materials.len() - 1)
            }
            ShapeMaterial::Named(name) => materials.iter().rposition(|known| known.name == name).ok_or(name),
        }
    }

    /// Adds a group with a name, which holds what `contents` adds and which instances copy.
    #[must_use]
    pub fn group(mut self, name: impl Into<String>, contents: impl FnOnce(Self) -> Self) -> Self {
        let outer = std::mem::take(&mut self.description.world);
        self = contents(self);
        let group = std::mem::replace(&mut self.description.world, outer);
        self.description.groups.push(GroupDescription { name: name.into(), ..group });
        self
    }

    /// Adds a copy of a group to the world, or to the group under construction.
    #[must_use]
    pub fn instance(mut self, group: &str, to_parent: DMat4) -> Self {
        let known = self.description.groups.iter().rposition(|known| known.name == group);
        let Some(group) = known else { return self.unknown("group", group.to_owned()) };
        self.description.world.instances.push(InstanceDescription {
            name: String::new(),
            group,
            to_parent,
            location: None,
        });
        self
    }

    /// Adds a light that is not a surface.
    #[must_use]
    pub fn light(mut self, light: LightDescription) -> Self {
        self.description.lights.push(light);
        self
    }

    /// Changes anything else of the description, such as the filter or the crop window.
    #[must_use]
    pub fn edit(mut self, change: impl FnOnce(&mut Description)) -> Self {
        change(&mut self.description);
        self
    }

    fn unknown(mut self, what: &'static str, name: String) -> Self {
        self.error.get_or_insert(SceneErrorKind::Name { what, name });
        self
    }

    /// The scene as plain data, with default settings for film, filter, sampler and integrator unless they were set.
    ///
    /// # Errors
    /// [`SceneErrorKind::Name`] if a material or a group was used that had not been added.
    pub fn describe(self) -> Result<Description, SceneError> {
        match self.error {
            None => Ok(self.description),
            Some(kind) => Err(SceneError { location: None, kind }),
        }
    }

    /// The scene, with warnings about what was repaired or left out; see [`Scene::resolve`].
    ///
    /// # Errors
    /// Those of [`SceneBuilder::describe`] and [`Scene::resolve`].
    pub fn resolve(self) -> Result<(Scene, Vec<SceneWarning>), SceneError> {
        Scene::resolve(self.describe()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_of_one_named_material_share_it_and_groups_hold_their_own() {
        let ball = || ShapeDescription::sphere(1.0);
        let description = SceneBuilder::new()
            .material("grey", MaterialKind::diffuse(0.5))
            .shape(ball(), "grey")
            .group("inner", |group| group.shape(ball(), "grey"))
            .group("outer", |group| {
                group.shape(ball(), MaterialKind::Interface).instance("inner", DMat4::IDENTITY)
            })
            .instance("outer", DMat4::IDENTITY)
            .shape(ball(), "grey")
            .describe()
            .unwrap();
        assert_eq!(description.materials.len(), 2);
        let shapes = |group: &GroupDescription| group.shapes.iter().map(|shape| shape.material).collect();
        let materials: Vec<Vec<usize>> =
            description.groups.iter().chain([&description.world]).map(shapes).collect();
        assert_eq!(materials, [vec![0], vec![1], vec![0, 0]]);
        assert_eq!((description.groups[1].instances[0].group, description.world.instances[0].group), (0, 1));
    }

    #[test]
    fn the_first_unknown_name_is_reported() {
        let ball = ShapeDescription::sphere(1.0);
        let builder = SceneBuilder::new().shape(ball, "gold").instance("chair", DMat4::IDENTITY);
        let message = builder.resolve().unwrap_err().to_string();
        assert_eq!(message, "there is no material \"gold\"; add it before it is used");
        // A group under construction is not known yet.
        let builder = SceneBuilder::new().group("loop", |group| group.instance("loop", DMat4::IDENTITY));
        assert!(matches!(builder.describe().unwrap_err().kind, SceneErrorKind::Name { what: "group", .. }));
    }
}
