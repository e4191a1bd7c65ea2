//! The graphics state, which directives change and `AttributeBegin` saves.

use std::collections::BTreeMap;
use std::rc::Rc;

use glanz_math::DMat4;
use glanz_scene::description::{EmissionDescription, SurfaceMedia};

use crate::pbrt::color_space::ColorSpace;
use crate::pbrt::parameters::Parameter;
use crate::source::Span;

/// Largest depth of nested `AttributeBegin`, `TransformBegin`, `ObjectBegin` and `Import`.
pub(crate) const MAX_NESTING: usize = 256;

/// Parameters that shapes, lights, materials, media and textures inherit from `Attribute` (version 4).
#[derive(Clone, Debug, Default)]
pub(crate) struct Attributes {
    pub(crate) shape: Rc<Vec<Parameter>>,
    pub(crate) light: Rc<Vec<Parameter>>,
    pub(crate) material: Rc<Vec<Parameter>>,
    pub(crate) medium: Rc<Vec<Parameter>>,
    pub(crate) texture: Rc<Vec<Parameter>>,
}

impl Attributes {
    /// The list for a target of `Attribute`.
    pub(crate) fn of(&mut self, target: &str) -> Option<&mut Rc<Vec<Parameter>>> {
        Some(match target {
            "shape" => &mut self.shape,
            "light" => &mut self.light,
            "material" => &mut self.material,
            "medium" => &mut self.medium,
            "texture" => &mut self.texture,
            _ => return None,
        })
    }
}

/// The graphics state.
#[derive(Clone, Debug)]
pub(crate) struct GraphicsState {
    /// The current transformation: from the frame of the following objects to that of the world or, before `WorldBegin`, from the
    /// world to the camera. For animated transformations, that at the start of the exposure.
    pub(crate) ctm: DMat4,
    /// Whether transformations apply to the start of the exposure.
    pub(crate) start_active: bool,
    /// Whether normals are reversed.
    pub(crate) reverse_orientation: bool,
    /// Index of the material; `None` for the default material.
    pub(crate) material: Option<usize>,
    /// The media on both sides of shapes.
    pub(crate) media: SurfaceMedia,
    /// Emission of shapes.
    pub(crate) emission: Option<Rc<EmissionDescription>>,
    /// Colour space of `rgb`.
    pub(crate) color_space: ColorSpace,
    /// Defaults for parameters.
    pub(crate) attributes: Attributes,
}

impl Default for GraphicsState {
    fn default() -> Self {
        Self {
            ctm: DMat4::IDENTITY,
            start_active: true,
            reverse_orientation: false,
            material: None,
            media: SurfaceMedia::default(),
            emission: None,
            color_space: ColorSpace::Rec709,
            attributes: Attributes::default(),
        }
    }
}

/// State that a block restores at its end.
#[derive(Clone, Debug)]
pub(crate) enum SavedState {
    /// Everything: `AttributeBegin`, `ObjectBegin`.
    All(GraphicsState),
    /// The transformation: `TransformBegin`.
    Transform(DMat4, bool),
}

/// One open level.
#[derive(Clone, Debug)]
pub(crate) struct BlockLevel {
    /// The directive that opened it.
    pub(crate) opened_by: &'static str,
    /// Position.
    pub(crate) place: Span,
    /// The state that it restores.
    pub(crate) saved: SavedState,
}

/// The state and what is saved.
#[derive(Clone, Debug, Default)]
pub(crate) struct StateStack {
    pub(crate) now: GraphicsState,
    pub(crate) levels: Vec<BlockLevel>,
    /// Named frames, as transformations to the world.
    pub(crate) named_frames: BTreeMap<String, DMat4>,
}

impl StateStack {
    /// Multiplies the current transformation by `matrix`, which is applied first.
    pub(crate) fn concatenate(&mut self, matrix: DMat4) {
        if self.now.start_active {
            self.now.ctm *= matrix;
        }
    }

    /// Replaces the current transformation.
    pub(crate) fn replace(&mut self, matrix: DMat4) {
        if self.now.start_active {
            self.now.ctm = matrix;
        }
    }

    /// Restores the state that a level saved.
    pub(crate) fn restore(&mut self, saved: SavedState) {
        match saved {
            SavedState::All(state) => self.now = state,
            SavedState::Transform(ctm, start_active) => {
                self.now.ctm = ctm;
                self.now.start_active = start_active;
            }
        }
    }
}
