//! Elements that are small where light changes.

use glanz_light::Spectrum;
use glanz_scene::PlacedSurface;

use super::{Element, ElementError, Elements, LIMIT, Patch, element, face_parts};

/// Deepest level that can be asked for: sides are halved as often.
const DEEPEST: u32 = 24;

/// When an element is divided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadtreeSettings {
    /// Largest difference between the values of the four quarters of an element that is left whole, in the units of the values;
    /// 0 or more.
    pub threshold: f64,
    /// Levels that are divided in any case: a shadow between the places where large elements look is not seen by them.
    pub first: u32,
    /// Levels at most, 24 or fewer; elements of that level are not tried.
    pub deepest: u32,
}

/// An element that was left whole.
#[derive(Clone, Debug)]
pub struct Leaf {
    /// Where it is.
    pub element: Element,
    /// Its value.
    pub value: Spectrum,
    /// How often the side of the face was halved.
    pub level: u32,
}

/// One side of a face, divided where light changes.
#[derive(Clone, Debug)]
pub struct Quadtree {
    /// Elements that cover what trimming leaves of it once; those of a quarter follow one another.
    pub leaves: Vec<Leaf>,
    /// Values that were computed, those of elements that were divided later included.
    pub trials: usize,
}

impl Elements<'_> {
    /// The quarters of an element, without those that trimming leaves nothing of.
    #[must_use]
    pub fn quarters(&self, whole: &Element) -> Vec<Element> {
        let Some(placed) = self.surfaces.get(whole.patch.surface as usize) else { return Vec::new() };
        let parts = whole.patch.part.quarters().into_iter();
        parts.filter_map(|part| element(self.scene, placed, Patch { part, ..whole.patch })).collect()
    }

    /// Divides one side of a face of a surface by what `value` says of its parts.
    ///
    /// An element is divided into quarters of its parameters if the values of these, computed on trial, differ from one another by
    /// more than a threshold in some lane. The values of the quarters are kept: each is computed once.
    ///
    /// `surface`: a number in [`Elements::surfaces`]. No leaves come of a face that is not there.
    ///
    /// # Errors
    /// That of `value`, and [`ElementError::Division`] or [`ElementError::TooFine`] for settings that make no sense or too many
    /// elements.
    ///
    /// # Source
    /// @pietrek2001 section 4.7.1.
    pub fn refined<E: From<ElementError>>(
        &self,
        (surface, face, back): (u32, u32, bool),
        settings: &QuadtreeSettings,
        value: impl FnMut(&Element) -> Result<Spectrum, E>,
    ) -> Result<Quadtree, E> {
        let QuadtreeSettings { threshold, first, deepest } = *settings;
        if !(threshold >= 0.0 && threshold.is_finite() && first <= deepest && deepest <= DEEPEST) {
            return Err(ElementError::Division { threshold, first, deepest }.into());
        }
        let tree = Quadtree { leaves: Vec::new(), trials: 0 };
        let Some(placed) = self.surfaces.get(surface as usize).filter(|placed| face < placed.faces()) else {
            return Ok(tree);
        };
        let mut division = Division { elements: self, placed, settings, value, tree };
        for part in face_parts(placed, face) {
            if let Some(root) = division.tried(Patch { surface, face, back, part }, 0)? {
                division.divide(root)?;
            }
        }
        Ok(division.tree)
    }
}

/// A division on its way.
struct Division<'a, F> {
    elements: &'a Elements<'a>,
    placed: &'a PlacedSurface<'a>,
    settings: &'a QuadtreeSettings,
    value: F,
    tree: Quadtree,
}

impl<E: From<ElementError>, F: FnMut(&Element) -> Result<Spectrum, E>> Division<'_, F> {
    /// A patch with its value; `None` where trimming leaves nothing.
    fn tried(&mut self, patch: Patch, level: u32) -> Result<Option<Leaf>, E> {
        let Some(element) = element(self.elements.scene, self.placed, patch) else { return Ok(None) };
        self.tree.trials += 1;
        let value = (self.value)(&element)?;
        Ok(Some(Leaf { element, value, level }))
    }

    /// Keeps a leaf, or those that it is divided into.
    fn divide(&mut self, leaf: Leaf) -> Result<(), E> {
        if leaf.level < self.settings.deepest {
            let mut quarters = Vec::with_capacity(4);
            for part in leaf.element.patch.part.quarters() {
                quarters.extend(self.tried(Patch { part, ..leaf.element.patch }, leaf.level + 1)?);
            }
            if leaf.level < self.settings.first || spread(&quarters) > self.settings.threshold {
                return quarters.into_iter().try_for_each(|quarter| self.divide(quarter));
            }
        }
        if self.tree.leaves.len() == LIMIT {
            return Err(ElementError::TooFine { limit: LIMIT }.into());
        }
        self.tree.leaves.push(leaf);
        Ok(())
    }
}

/// Largest difference between two of the values in some lane; that of too few is 0.
fn spread(leaves: &[Leaf]) -> f64 {
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
    use glanz_scene::description::{GeometryDescription, ShapeDescription};

    use super::*;
    use crate::elements::{ElementSettings, Part};
    use crate::form_factor::exchange;
    use crate::scenes::{parallelogram, scene};

    const SETTINGS: QuadtreeSettings = QuadtreeSettings { threshold: 0.05, first: 2, deepest: 6 };

    fn refined(
        elements: &Elements<'_>,
        face: (u32, u32, bool),
        settings: &QuadtreeSettings,
        light: impl Fn(&Element) -> f64,
    ) -> Quadtree {
        let light = |element: &Element| Ok::<_, ElementError>(Spectrum::splat(light(element) as f32));
        elements.refined(face, settings, light).unwrap()
    }

    fn area(tree: &Quadtree) -> f64 {
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
            (parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y), 1.0),
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
                let tree = refined(&elements, (0, 0, true), &settings, |_| 0.7);
                let roots = tree.leaves.iter().filter(|leaf| leaf.level != first).count();
                assert_eq!(roots, 0);
                assert!(tree.leaves.len().is_multiple_of(4_usize.pow(first)));
                assert!(tree.leaves.iter().all(|leaf| leaf.element.patch.back));
            }
            let fine = QuadtreeSettings { first: 4, ..SETTINGS };
            let found = area(&refined(&elements, (0, 0, false), &fine, |_| 0.7));
            assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
        }
    }

    #[test]
    fn quarters_of_an_element_fill_it() {
        for (shape, _) in shapes() {
            let scene = scene(vec![(shape, 0.5, 0.0)]);
            let elements = Elements::new(&scene, &ElementSettings { side: 0.7 }).unwrap();
            for whole in &elements.list {
                let quarters = elements.quarters(whole);
                let area: f64 = quarters.iter().map(|quarter| quarter.area).sum();
                assert!(quarters.len() == 4 && (area / whole.area - 1.0).abs() < 1e-2);
                assert!(quarters.iter().all(|quarter| quarter.patch.back == whole.patch.back));
            }
        }
    }

    #[test]
    fn step_is_followed_to_the_deepest_level_and_nowhere_else() {
        for (shape, _) in shapes() {
            let scene = scene(vec![(shape, 0.5, 0.0)]);
            let elements = Elements::new(&scene, &ElementSettings { side: 9.0 }).unwrap();
            // On a line through the parameters; a part of it has the mean over places in it.
            let above = |uv: DVec2| 0.8 * uv.x + uv.y - 0.63;
            let light = |element: &Element| {
                let mut parts = vec![element.patch.part];
                for _ in 0..3 {
                    parts = parts.iter().flat_map(Part::quarters).collect();
                }
                parts.iter().filter(|part| above(part.center()) > 0.0).count() as f64 / parts.len() as f64
            };
            let tree = refined(&elements, (0, 0, false), &SETTINGS, light);
            let mut crossed = 0;
            for leaf in &tree.leaves {
                let heights: Vec<f64> = leaf.element.patch.part.corners().into_iter().map(above).collect();
                let across = heights.iter().any(|&h| h > 0.0) && heights.iter().any(|&h| h < 0.0);
                // A corner that the line cuts off may be too small to matter.
                let value = f64::from(leaf.value.max_component());
                if across && (0.1..0.9).contains(&value) {
                    assert_eq!(leaf.level, SETTINGS.deepest, "{:?}", leaf.element.patch);
                    crossed += 1;
                }
                // Elements are as small only beside a brother that the line crosses.
                let side = leaf.element.patch.part.corners();
                let reach = side.iter().map(|c| c.distance(side[0])).fold(0.0, f64::max);
                let distance = heights.iter().fold(f64::INFINITY, |d, h| d.min(h.abs())) / 1.28;
                if leaf.level > SETTINGS.first {
                    assert!(distance <= 1.01 * reach, "{:?}", leaf.element.patch);
                }
            }
            assert!(crossed > 20, "{crossed}");
            // Four for each that was divided or tried in vain, and the roots.
            assert!(tree.trials > tree.leaves.len());
            let whole = QuadtreeSettings { first: 6, ..SETTINGS };
            let expected = area(&refined(&elements, (0, 0, false), &whole, light));
            assert!((area(&tree) / expected - 1.0).abs() < 1e-2);
        }
    }

    #[test]
    fn hard_shadow_is_followed_with_form_factors() {
        // A lamp of 1 cm, 2 m above the floor; half as high a panel whose shadow ends at x = 0.3.
        let (x, y) = (DVec3::X, DVec3::Y);
        let scene = scene(vec![
            (parallelogram(DVec3::ZERO, x, y), 0.5, 0.0),
            (parallelogram(DVec3::new(0.495, 0.495, 2.0), y * 0.01, x * 0.01), 0.0, 1e4),
            (parallelogram(DVec3::new(-1.6, -2.0, 1.0), x * 2.0, y * 5.0), 0.0, 0.0),
        ]);
        let elements = Elements::new(&scene, &ElementSettings { side: 9.0 }).unwrap();
        let lamp = elements.list.iter().find(|element| !element.emission.is_black()).unwrap();
        let light = |element: &Element| {
            let received = exchange(&elements, lamp, element) / element.area;
            Ok::<_, ElementError>(lamp.emission * received as f32)
        };
        let full = light(&elements.list[0]).unwrap().max_component();
        let floor = elements.list.iter().find(|e| e.polygon.is_some() && e.center.normal.z > 0.9).unwrap();
        let face = (floor.patch.surface, floor.patch.face, false);
        let settings = QuadtreeSettings { threshold: 0.1 * f64::from(full), ..SETTINGS };
        let tree = elements.refined(face, &settings, light).unwrap();
        assert!((area(&tree) - 1.0).abs() < 1e-12);
        for leaf in &tree.leaves {
            let corners = leaf.element.patch.part.corners();
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
    fn errors_of_values_and_senseless_settings_are_told() {
        let scene = scene(vec![(parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y), 0.5, 0.0)]);
        let elements = Elements::new(&scene, &ElementSettings { side: 1.0 }).unwrap();
        let with = |settings: QuadtreeSettings| {
            elements.refined((0, 0, false), &settings, |_| Ok::<_, ElementError>(Spectrum::ONE)).err()
        };
        for (threshold, first, deepest) in [(-1.0, 0, 1), (f64::NAN, 0, 1), (0.1, 3, 2), (0.1, 0, 25)] {
            let refused = with(QuadtreeSettings { threshold, first, deepest });
            assert!(matches!(refused, Some(ElementError::Division { .. })), "{threshold} {first} {deepest}");
        }
        let stopped = elements.refined((0, 0, false), &SETTINGS, |_| Err(ElementError::Side(7.0)));
        assert_eq!(stopped.err(), Some(ElementError::Side(7.0)));
        let nowhere = elements.refined((9, 0, false), &SETTINGS, |_| Err(ElementError::Side(7.0)));
        assert!(nowhere.unwrap().leaves.is_empty());
    }
}
