//! A closed box whose walls all emit and reflect alike: its radiosity is E / (1 - rho) everywhere.

use glanz_job::Silent;
use glanz_light::{Spectrum, Wavelengths};
use glanz_math::DVec3;
use glanz_radiosity::elements::{Element, ElementSettings, Elements};
use glanz_radiosity::form_factor::FormFactors;
use glanz_radiosity::solve::{GaussSeidelSettings, HierarchicalSettings, gauss_seidel, hierarchical};
use glanz_scene::description::{MaterialKind, ShapeDescription};
use glanz_scene::{Scene, SceneBuilder};

use super::measure::{LEFT, SolverKind};
use super::progressive::Progressive;
use crate::study::{Settings, StudyError};

/// Reflectances of the walls.
const REFLECTANCES: [f32; 3] = [0.3, 0.6, 0.9];

/// Sides of the box and of its elements, metres.
const SIZE: DVec3 = DVec3::new(3.0, 2.0, 2.5);
const SIDE: f64 = 0.6;

/// Bound of the hierarchical solver.
const BOUND: f64 = 1e-3;

/// Result of a solver for a box.
pub(super) struct Furnace {
    pub(super) reflectance: f64,
    pub(super) solver: SolverKind,
    pub(super) elements: usize,
    /// Mean over areas, and smallest and largest value of an element, relative to E / (1 - rho).
    pub(super) mean: f64,
    pub(super) range: [f64; 2],
    /// Smallest and largest sum of the form factors of an element.
    pub(super) sums: Option<[f64; 2]>,
    /// Unshot share of the emitted light.
    pub(super) left: Option<f64>,
}

/// Solves all boxes by all solvers.
///
/// # Errors
/// [`StudyError::Interrupted`].
pub(super) fn measure(settings: &Settings) -> Result<Vec<Furnace>, StudyError> {
    let mut furnaces = Vec::new();
    for reflectance in REFLECTANCES {
        settings.cancel.check()?;
        let scene = scene(reflectance)?;
        let expected = std::f64::consts::PI / (1.0 - f64::from(reflectance));
        let elements = Elements::new(&scene, &ElementSettings { side: SIDE })?;
        let factors = FormFactors::new(&elements, &settings.cancel)?;
        let solution =
            gauss_seidel(&elements.list, &factors, &GaussSeidelSettings::default(), &settings.cancel)?;
        let inside = (0..elements.list.len()).filter(|&i| elements.list.get(i).is_some_and(is_inside));
        let sums = range(inside.map(|i| factors.sum(i)));
        let one = |solver, elements: &Elements<'_>, radiosity: &[Spectrum]| {
            Furnace::new(f64::from(reflectance), solver, &elements.list, radiosity, expected)
        };
        furnaces.push(Furnace { sums: Some(sums), ..one(SolverKind::Full, &elements, &solution.radiosity) });
        let mut shot = Progressive::new(&elements);
        while shot.left(&elements) > LEFT && shot.shoot_known(&elements, &factors) {}
        let left = Some(shot.left(&elements));
        furnaces.push(Furnace { left, ..one(SolverKind::Progressive, &elements, shot.radiosity()) });
        let start = Elements::new(&scene, &ElementSettings { side: SIZE.max_element() })?;
        let method = HierarchicalSettings { bound: BOUND, ..HierarchicalSettings::default() };
        let solution = hierarchical(start, &method, &mut Silent, &settings.cancel)
            .map_err(|error| StudyError::Unreadable(error.to_string()))?;
        settings.cancel.check()?;
        furnaces.push(one(SolverKind::Hierarchical, &solution.elements, &solution.radiosity));
    }
    Ok(furnaces)
}

fn is_inside(element: &Element) -> bool {
    !element.patch.back
}

fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, 0.0], |[low, high], value| [low.min(value), high.max(value)])
}

impl Furnace {
    fn new(
        reflectance: f64,
        solver: SolverKind,
        list: &[Element],
        radiosity: &[Spectrum],
        expected: f64,
    ) -> Self {
        let value = |light: &Spectrum| f64::from(light.luminance(&Wavelengths::default())) / expected;
        let inside = || list.iter().zip(radiosity).filter(|(element, _)| is_inside(element));
        let (sum, area) = inside().fold((0.0, 0.0), |(sum, area), (element, light)| {
            (sum + element.area * value(light), area + element.area)
        });
        Self {
            reflectance,
            solver,
            elements: inside().count(),
            mean: sum / area,
            range: range(inside().map(|(_, light)| value(light))),
            sums: None,
            left: None,
        }
    }
}

/// The box, with the fronts of its walls inside.
fn scene(reflectance: f32) -> Result<Scene, StudyError> {
    let walls = walls().map(|wall| wall.emitting(1.0));
    Ok(SceneBuilder::new().shapes(walls, MaterialKind::diffuse(reflectance)).resolve()?.0)
}

/// The walls of the box: -x, +x, -y, +y, -z, +z.
pub(super) fn walls() -> [ShapeDescription; 6] {
    let [x, y, z] = [DVec3::X * SIZE.x, DVec3::Y * SIZE.y, DVec3::Z * SIZE.z];
    let walls =
        [(DVec3::ZERO, y, z), (x, z, y), (DVec3::ZERO, z, x), (y, x, z), (DVec3::ZERO, x, y), (z, y, x)];
    walls.map(|(corner, u, v)| ShapeDescription::parallelogram(corner, u, v))
}
