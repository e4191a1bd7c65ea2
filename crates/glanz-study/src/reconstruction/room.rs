//! The six scenes, and the light on their floors.

use glanz_formats::{Options, load_str};
use glanz_job::CancelFlag;
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::DVec3;
use glanz_radiosity::elements::{Element, ElementSettings, Elements, ParameterPatch};
use glanz_radiosity::form_factor::exchange;
use glanz_radiosity::reconstruct::{ParameterCell, ParameterCells};
use glanz_scene::Scene;

use super::exact::ExactFloor;
use super::quadtree::{ElementQuadtree, QuadtreeSettings};
use crate::study::StudyError;

/// Number of the floor among the shapes of the scene file.
const FLOOR: u32 = 0;

/// Number of times that lamp or element are halved for form factors: rays between parts detect borders of shadows that rays
/// between wholes miss (document 003, section 5.7.6, `FFRay`). Once for the small textures of tests.
pub(super) fn halved(size: [usize; 2]) -> u32 {
    if size[0].max(size[1]) < 200 { 1 } else { 3 }
}

/// Side of a part of a lamp, metres.
const LAMP: f64 = 0.04;

/// A scene with its name in document 003.
#[derive(Debug)]
pub(super) struct Setup {
    /// As the document numbers it.
    pub(super) number: &'static str,
    /// Of its file.
    pub(super) name: &'static str,
    pub(super) description: &'static str,
    /// Whether the shadow is hard.
    pub(super) hard: bool,
    text: &'static str,
}

macro_rules! setup {
    ($number:literal, $name:literal, $description:literal, $hard:literal) => {
        Setup {
            number: $number,
            name: $name,
            description: $description,
            hard: $hard,
            text: include_str!(concat!("../../scenes/reconstruction/", $name, ".pbrt")),
        }
    };
}

/// The scenes of section 4.7.
pub(super) static SETUPS: [Setup; 6] = [
    setup!("1", "soft_parallel", "soft, parallel to the elements", false),
    setup!("2", "soft_diagonal", "soft, diagonal", false),
    setup!("3a", "hard_parallel_on", "hard, on borders of elements", true),
    setup!("3b", "hard_parallel_off", "hard, parallel, through the middles of elements", true),
    setup!("4a", "hard_diagonal_on", "hard, diagonal through corners of elements", true),
    setup!("4b", "hard_diagonal_off", "hard, diagonal, off the corners", true),
];

impl Setup {
    /// The scene.
    ///
    /// # Errors
    /// [`StudyError::Unreadable`], [`StudyError::Scene`].
    pub(super) fn scene(&self) -> Result<Scene, StudyError> {
        let name = format!("{}.pbrt", self.name);
        let loaded = load_str(&name, self.text, &Options::default())
            .map_err(|diagnostics| StudyError::Unreadable(diagnostics.to_string()))?;
        Ok(Scene::resolve(loaded.description)?.0)
    }
}

/// A scene in elements: lamps, blockers and the floor.
pub(super) struct FloorScene<'a> {
    elements: Elements<'a>,
    lamps: Vec<Lamp>,
    floor: Element,
}

/// A lamp with the parts for its form factors.
struct Lamp {
    whole: Element,
    parts: Vec<Element>,
    /// Number of times that the receiving elements are halved.
    halved: u32,
}

impl Lamp {
    fn new(elements: &Elements<'_>, whole: &Element, halved: u32) -> Self {
        let levels = (whole.area.sqrt() / LAMP).log2().ceil().clamp(0.0, f64::from(halved)) as u32;
        let parts = parts(elements, whole, levels);
        Self { whole: whole.clone(), parts, halved: halved - levels }
    }

    /// Share of the lamp's radiosity that arrives per area of an element.
    fn share(&self, elements: &Elements<'_>, element: &Element) -> f64 {
        let receiving = parts(elements, element, self.halved);
        let pairs = receiving.iter().flat_map(|to| self.parts.iter().map(move |from| (from, to)));
        pairs.map(|(from, to)| exchange(elements, from, to)).sum::<f64>() / element.area
    }
}

/// The parts of an element after `levels` halvings.
fn parts(elements: &Elements<'_>, whole: &Element, levels: u32) -> Vec<Element> {
    let mut parts = vec![whole.clone()];
    for _ in 0..levels {
        parts = parts.iter().flat_map(|part| elements.quarters(part)).collect();
    }
    parts
}

/// A divided floor with a value for each cell.
pub(super) struct DividedFloor {
    pub(super) cells: ParameterCells,
    /// Number of computed values.
    pub(super) trials: usize,
}

impl<'a> FloorScene<'a> {
    /// # Errors
    /// A scene without a flat floor.
    pub(super) fn new(scene: &'a Scene, halved: u32) -> Result<Self, StudyError> {
        // Each face is one element: lamps are small, and the floor is divided later.
        let side = 2.0 * scene.bounds().diagonal().length();
        let elements = Elements::new(scene, &ElementSettings { side })?;
        let shining = elements.list.iter().filter(|e| !e.emission.is_black());
        let lamps = shining.map(|lamp| Lamp::new(&elements, lamp, halved)).collect();
        let is_floor = |e: &&Element| {
            let surface = elements.surfaces.get(e.patch.surface as usize);
            surface.is_some_and(|s| s.shape(e.patch.face) == FLOOR) && !e.patch.back && e.polygon.is_some()
        };
        let floor = elements.list.iter().find(is_floor).cloned();
        let floor =
            floor.ok_or_else(|| StudyError::Unreadable("the first shape is no flat floor".to_owned()))?;
        Ok(Self { elements, lamps, floor })
    }

    /// Radiosity of a part of the floor from the lamps alone, by form factors.
    fn radiosity(&self, element: &Element) -> Spectrum {
        let from = |lamp: &Lamp| lamp.whole.emission * lamp.share(&self.elements, element) as f32;
        self.lamps.iter().map(from).sum::<Spectrum>() * element.reflectance
    }

    /// The floor divided where light changes, with values relative to `unit`.
    ///
    /// # Errors
    /// [`StudyError::Interrupted`] if `cancel` is raised, or [`StudyError::Quadtree`].
    pub(super) fn divided(
        &self,
        settings: &QuadtreeSettings,
        unit: f64,
        cancel: &CancelFlag,
    ) -> Result<DividedFloor, StudyError> {
        let patch = self.floor.patch;
        let settings = QuadtreeSettings { threshold: settings.threshold * unit, ..*settings };
        let value = |element: &Element| {
            cancel.check()?;
            Ok::<_, StudyError>(self.radiosity(element))
        };
        let side = (patch.surface, patch.face, patch.back);
        let tree = ElementQuadtree::new(&self.elements, side, &settings, value)?;
        let wavelengths = Wavelengths::default();
        let cell = |part: ParameterPatch, value: Spectrum| match part {
            ParameterPatch::Rectangle { min, max } => {
                let value = DVec3::splat(f64::from(value.luminance(&wavelengths)) / unit);
                Some(ParameterCell { min, max, value })
            }
            ParameterPatch::Triangle(_) => None,
        };
        let cells =
            tree.leaves.iter().filter_map(|leaf| cell(leaf.element.patch.domain, leaf.value)).collect();
        Ok(DividedFloor { cells: ParameterCells::try_new(cells)?, trials: tree.trials })
    }

    /// The floor's light in closed form.
    pub(super) fn exact(&self) -> ExactFloor {
        let luminance = |light: Spectrum| f64::from(light.luminance(&Wavelengths::default()));
        let reflectance = luminance(self.floor.reflectance);
        let lamps = self.lamps.iter().filter_map(|Lamp { whole, .. }| {
            Some((whole.polygon.clone()?, reflectance * luminance(whole.emission)))
        });
        let is_floor = |e: &Element| {
            (e.patch.surface, e.patch.face) == (self.floor.patch.surface, self.floor.patch.face)
        };
        let others = self.elements.list.iter().filter(|e| !e.patch.back && !is_floor(e));
        let blockers = others.filter_map(|e| e.polygon.clone()).collect();
        ExactFloor::new(self.floor.polygon.clone().unwrap_or_default(), lamps.collect(), blockers)
    }
}
