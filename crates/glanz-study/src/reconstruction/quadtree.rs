//! Quadtrees of elements that are small where light changes.

use glanz_light::Spectrum;
use glanz_radiosity::elements::{Element, Elements, ParameterPatch, Patch};

/// Largest depth: the number of times that sides are halved.
const DEEPEST: u32 = 24;

/// Largest number of leaves.
const MAX_LEAVES: usize = 1 << 22;

/// Conditions for the division of an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct QuadtreeSettings {
    /// Largest difference between the values of the four quarters of an element that is not divided, in the units of the values;
    /// 0 or more.
    pub(super) threshold: f64,
    /// Number of levels that are always divided, because the few rays of large elements may miss shadows.
    pub(super) first: u32,
    /// Largest number of levels, at most 24; elements of that level are not tested.
    pub(super) deepest: u32,
}

/// Error of the division of a face.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum QuadtreeError {
    /// A threshold below 0 or not finite, or invalid levels.
    #[error(
        "the quadtree has the threshold {threshold} and the levels {first} to {deepest}; the threshold must be 0 or more, \
         and the levels ascending and at most {DEEPEST}"
    )]
    Settings {
        /// Largest difference of values.
        threshold: f64,
        /// Levels that are always divided.
        first: u32,
        /// Largest number of levels.
        deepest: u32,
    },
    /// There would be more leaves than can be stored.
    #[error("the quadtree has more than {limit} elements; choose a larger threshold or fewer levels")]
    TooFine {
        /// Largest number of elements.
        limit: usize,
    },
}

/// An element that is not divided further.
#[derive(Clone, Debug)]
pub(super) struct ElementLeaf {
    pub(super) element: Element,
    pub(super) value: Spectrum,
    /// Number of times that the side of the face was halved.
    pub(super) level: u32,
}

/// One side of a face, divided where light changes.
#[derive(Clone, Debug)]
pub(super) struct ElementQuadtree {
    /// Elements that cover what trimming leaves of the side exactly once; those of a quarter are contiguous.
    pub(super) leaves: Vec<ElementLeaf>,
    /// Number of computed values, including those of elements that were divided later.
    pub(super) trials: usize,
}

impl ElementQuadtree {
    /// Divides one side of a face: surface (a number in [`Elements::surfaces`]), face, and whether it is the back.
    ///
    /// An element is divided into quarters of its parameters if the values of these differ by more than a threshold in some band.
    /// Every `value` is computed once. A face that does not exist has no leaves.
    ///
    /// # Errors
    /// Those of `value`; [`QuadtreeError::Settings`] for invalid settings, [`QuadtreeError::TooFine`] for too many leaves.
    ///
    /// # Source
    /// @pietrek2001 section 4.7.1.
    pub(super) fn new<E: From<QuadtreeError>>(
        elements: &Elements<'_>,
        (surface, face, back): (u32, u32, bool),
        settings: &QuadtreeSettings,
        value: impl FnMut(&Element) -> Result<Spectrum, E>,
    ) -> Result<Self, E> {
        let QuadtreeSettings { threshold, first, deepest } = *settings;
        if !(threshold >= 0.0 && threshold.is_finite() && first <= deepest && deepest <= DEEPEST) {
            return Err(QuadtreeError::Settings { threshold, first, deepest }.into());
        }
        let tree = Self { leaves: Vec::new(), trials: 0 };
        let placed = elements.surfaces.get(surface as usize).filter(|placed| face < placed.faces());
        let Some(placed) = placed else { return Ok(tree) };
        let mut builder = QuadtreeBuilder { elements, settings, value, tree };
        for domain in ParameterPatch::of_face(&placed.face_domain(face)) {
            if let Some(root) = elements.element(Patch { surface, face, back, domain }) {
                let root = builder.leaf(root, 0)?;
                builder.divide(root)?;
            }
        }
        Ok(builder.tree)
    }
}

/// State of a division.
struct QuadtreeBuilder<'a, F> {
    elements: &'a Elements<'a>,
    settings: &'a QuadtreeSettings,
    value: F,
    tree: ElementQuadtree,
}

impl<E: From<QuadtreeError>, F: FnMut(&Element) -> Result<Spectrum, E>> QuadtreeBuilder<'_, F> {
    /// An element with its value.
    fn leaf(&mut self, element: Element, level: u32) -> Result<ElementLeaf, E> {
        self.tree.trials += 1;
        let value = (self.value)(&element)?;
        Ok(ElementLeaf { element, value, level })
    }

    /// Adds a leaf, or those that it is divided into.
    fn divide(&mut self, leaf: ElementLeaf) -> Result<(), E> {
        if leaf.level < self.settings.deepest {
            let mut quarters = Vec::with_capacity(4);
            for quarter in self.elements.quarters(&leaf.element) {
                quarters.push(self.leaf(quarter, leaf.level + 1)?);
            }
            if leaf.level < self.settings.first || spread(&quarters) > self.settings.threshold {
                return quarters.into_iter().try_for_each(|quarter| self.divide(quarter));
            }
        }
        if self.tree.leaves.len() == MAX_LEAVES {
            return Err(QuadtreeError::TooFine { limit: MAX_LEAVES }.into());
        }
        self.tree.leaves.push(leaf);
        Ok(())
    }
}

/// Largest difference between two of the values in some band; 0 for less than two.
fn spread(leaves: &[ElementLeaf]) -> f64 {
    let Some(first) = leaves.first() else { return 0.0 };
    let (low, high) = leaves.iter().fold((first.value, first.value), |(low, high), leaf| {
        (low.zip(leaf.value, f32::min), high.zip(leaf.value, f32::max))
    });
    f64::from((high - low).max_component())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use glanz_math::{DVec2, DVec3};
    use glanz_radiosity::elements::ElementSettings;
    use glanz_radiosity::form_factor::exchange;
    use glanz_scene::description::{GeometryDescription, MaterialKind, ShapeDescription};
    use glanz_scene::{Scene, SceneBuilder};

    use super::*;

    const SETTINGS: QuadtreeSettings = QuadtreeSettings { threshold: 0.05, first: 2, deepest: 6 };

    /// Shapes with their reflectance and the radiance of their front.
    fn scene(shapes: Vec<(ShapeDescription, f32, f32)>) -> Scene {
        let add_shape =
            |builder: SceneBuilder, (shape, reflectance, radiance): (ShapeDescription, f32, f32)| {
                let shape = if radiance > 0.0 { shape.emitting(radiance) } else { shape };
                builder.shape(shape, MaterialKind::diffuse(reflectance))
            };
        shapes.into_iter().fold(SceneBuilder::new(), add_shape).resolve().unwrap().0
    }

    fn divided(
        elements: &Elements<'_>,
        face: (u32, u32, bool),
        settings: &QuadtreeSettings,
        light: impl Fn(&Element) -> f64,
    ) -> ElementQuadtree {
        let light = |element: &Element| Ok::<_, QuadtreeError>(Spectrum::splat(light(element) as f32));
        ElementQuadtree::new(elements, face, settings, light).unwrap()
    }

    fn area(tree: &ElementQuadtree) -> f64 {
        tree.leaves.iter().map(|leaf| leaf.element.area).sum()
    }

    /// A square, a sphere, a triangle and a five-sided facet.
    fn shapes() -> Vec<(ShapeDescription, f64)> {
        let prism = {
            let side = |k: f64| (DVec3::new((k * TAU / 5.0).cos(), (k * TAU / 5.0).sin(), 0.0), 1.0);
            let mut half_spaces: Vec<_> = [0.0, 1.0, 2.0, 3.0, 4.0].map(side).into();
            half_spaces.extend([(DVec3::Z, 1.0), (-DVec3::Z, 1.0)]);
            ShapeDescription::from(GeometryDescription::Polyhedron { half_spaces })
        };
        let triangle = ShapeDescription::mesh(vec![DVec3::ZERO, DVec3::X * 2.0, DVec3::Y], vec![[0, 1, 2]]);
        vec![
            (ShapeDescription::parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y), 1.0),
            (ShapeDescription::sphere(1.0), 4.0 * PI),
            (triangle, 1.0),
            // Its five sides are 2 tan(36 degrees) wide and 2 high.
            (prism, 4.0 * (PI / 5.0).tan()),
        ]
    }

    #[test]
    fn constant_light_divides_nothing_beyond_the_first_levels() {
        for (shape, expected) in shapes() {
            let scene = scene(vec![(shape, 0.5, 0.0)]);
            let elements = Elements::new(&scene, &ElementSettings { side: 9.0 }).unwrap();
            for first in [0, 2] {
                let settings = QuadtreeSettings { first, ..SETTINGS };
                let tree = divided(&elements, (0, 0, true), &settings, |_| 0.7);
                let roots = tree.leaves.iter().filter(|leaf| leaf.level != first).count();
                assert_eq!(roots, 0);
                assert!(tree.leaves.len().is_multiple_of(4_usize.pow(first)));
                assert!(tree.leaves.iter().all(|leaf| leaf.element.patch.back));
            }
            let fine = QuadtreeSettings { first: 4, ..SETTINGS };
            let found = area(&divided(&elements, (0, 0, false), &fine, |_| 0.7));
            assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
        }
    }

    #[test]
    fn step_is_followed_to_the_deepest_level_and_nowhere_else() {
        for (shape, _) in shapes() {
            let scene = scene(vec![(shape, 0.5, 0.0)]);
            let elements = Elements::new(&scene, &ElementSettings { side: 9.0 }).unwrap();
            // A step along a line through the parameters; elements have its mean over samples.
            let above = |uv: DVec2| 0.8 * uv.x + uv.y - 0.63;
            let light = |element: &Element| {
                let mut parts = vec![element.patch.domain];
                for _ in 0..3 {
                    parts = parts.iter().flat_map(ParameterPatch::quarters).collect();
                }
                parts.iter().filter(|part| above(part.center()) > 0.0).count() as f64 / parts.len() as f64
            };
            let tree = divided(&elements, (0, 0, false), &SETTINGS, light);
            let mut crossed = 0;
            for leaf in &tree.leaves {
                let heights: Vec<f64> = leaf.element.patch.domain.corners().into_iter().map(above).collect();
                let across = heights.iter().any(|&h| h > 0.0) && heights.iter().any(|&h| h < 0.0);
                // Corners that the line cuts off may be too small for the samples.
                let value = f64::from(leaf.value.max_component());
                if across && (0.1..0.9).contains(&value) {
                    assert_eq!(leaf.level, SETTINGS.deepest, "{:?}", leaf.element.patch);
                    crossed += 1;
                }
                // Elements are small only beside a sibling that the line crosses.
                let side = leaf.element.patch.domain.corners();
                let reach = side.iter().map(|c| c.distance(side[0])).fold(0.0, f64::max);
                let distance = heights.iter().fold(f64::INFINITY, |d, h| d.min(h.abs())) / 1.28;
                if leaf.level > SETTINGS.first {
                    assert!(distance <= 1.01 * reach, "{:?}", leaf.element.patch);
                }
            }
            assert!(crossed > 20, "{crossed}");
            // Four trials for each tested element, and the roots.
            assert!(tree.trials > tree.leaves.len());
            let whole = QuadtreeSettings { first: 6, ..SETTINGS };
            let expected = area(&divided(&elements, (0, 0, false), &whole, light));
            assert!((area(&tree) / expected - 1.0).abs() < 1e-2);
        }
    }

    #[test]
    fn hard_shadow_is_followed_with_form_factors() {
        // A lamp of 1 cm, 2 m above the floor; half as high a panel whose shadow ends at x = 0.3.
        let (x, y) = (DVec3::X, DVec3::Y);
        let scene = scene(vec![
            (ShapeDescription::parallelogram(DVec3::ZERO, x, y), 0.5, 0.0),
            (ShapeDescription::parallelogram(DVec3::new(0.495, 0.495, 2.0), y * 0.01, x * 0.01), 0.0, 1e4),
            (ShapeDescription::parallelogram(DVec3::new(-1.6, -2.0, 1.0), x * 2.0, y * 5.0), 0.0, 0.0),
        ]);
        let elements = Elements::new(&scene, &ElementSettings { side: 9.0 }).unwrap();
        let lamp = elements.list.iter().find(|element| !element.emission.is_black()).unwrap();
        let light = |element: &Element| {
            let received = exchange(&elements, lamp, element) / element.area;
            Ok::<_, QuadtreeError>(lamp.emission * received as f32)
        };
        let full = light(&elements.list[0]).unwrap().max_component();
        let floor = elements.list.iter().find(|e| e.polygon.is_some() && e.center.normal.z > 0.9).unwrap();
        let face = (floor.patch.surface, floor.patch.face, false);
        let settings = QuadtreeSettings { threshold: 0.1 * f64::from(full), ..SETTINGS };
        let tree = ElementQuadtree::new(&elements, face, &settings, light).unwrap();
        assert!((area(&tree) - 1.0).abs() < 1e-12);
        for leaf in &tree.leaves {
            let corners = leaf.element.patch.domain.corners();
            let (low, high) = (corners[0].x, corners[2].x);
            if low < 0.298 && high > 0.302 {
                assert_eq!(leaf.level, SETTINGS.deepest, "{low} {high}");
            } else if (low - 0.3).min(0.3 - high) > 0.1 {
                assert_eq!(leaf.level, SETTINGS.first, "{low} {high}");
            }
            assert_eq!(high < 0.297, leaf.value.is_black() && high < 0.3, "{low} {high}");
        }
    }

    #[test]
    fn errors_of_values_and_invalid_settings_are_reported() {
        let stop = || QuadtreeError::TooFine { limit: 7 };
        let scene = scene(vec![(ShapeDescription::parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y), 0.5, 0.0)]);
        let elements = Elements::new(&scene, &ElementSettings { side: 1.0 }).unwrap();
        let with = |settings: QuadtreeSettings| {
            ElementQuadtree::new(&elements, (0, 0, false), &settings, |_| {
                Ok::<_, QuadtreeError>(Spectrum::ONE)
            })
            .err()
        };
        for (threshold, first, deepest) in [(-1.0, 0, 1), (f64::NAN, 0, 1), (0.1, 3, 2), (0.1, 0, 25)] {
            let refused = with(QuadtreeSettings { threshold, first, deepest });
            assert!(matches!(refused, Some(QuadtreeError::Settings { .. })), "{threshold} {first} {deepest}");
        }
        let stopped = ElementQuadtree::new(&elements, (0, 0, false), &SETTINGS, |_| Err(stop()));
        assert_eq!(stopped.err(), Some(stop()));
        let nowhere = ElementQuadtree::new(&elements, (9, 0, false), &SETTINGS, |_| Err(stop()));
        assert!(nowhere.unwrap().leaves.is_empty());
    }
}
