//! A small scene for the tests of the commands.

use super::support::Folder;

/// A small scene with lights (one in sight), metal, glass and shadows: every kind of path, at 24 x 18 pixels.
pub(crate) const SCENE: &str = r#"
LookAt 0 -6 2.5  0 0 0.8  0 0 1
Camera "perspective" "float fov" 35
Film "rgb" "integer xresolution" 24 "integer yresolution" 18 "string filename" "small.exr"
Sampler "zsobol" "integer pixelsamples" 8
Integrator "path" "integer maxdepth" 5
WorldBegin
LightSource "infinite" "rgb L" [0.2 0.25 0.3]
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [6 6 5]
  Translate 0 0 4
  Scale 1 1 -1
  Shape "disk" "float radius" 1
AttributeEnd
AttributeBegin
  AreaLightSource "diffuse" "rgb L" [4 4 4]
  Translate 0.2 -1.5 0.5
  Shape "sphere" "float radius" 0.3
AttributeEnd
Material "diffuse" "rgb reflectance" [0.6 0.5 0.4]
Shape "disk" "float radius" 20
Translate -1 0 1
Material "dielectric" "float eta" 1.5
Shape "sphere" "float radius" 0.9
Translate 2 0 -0.2
Material "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" "metal-Au-k"
Shape "cylinder" "float radius" 0.7 "float zmin" -0.8 "float zmax" 0.8
"#;

impl Folder {
    /// A folder that holds [`SCENE`] as `small.pbrt`.
    pub(crate) fn with_scene() -> Self {
        let folder = Self::new();
        folder.write("small.pbrt", SCENE);
        folder
    }

    pub(crate) fn remove(&self, name: &str) {
        std::fs::remove_file(self.path(name)).expect("a file of the test");
    }
}
