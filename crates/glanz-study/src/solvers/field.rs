//! Light on elements, and how far two such are apart.

use std::collections::HashMap;

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::DVec2;
use glanz_radiosity::elements::{Element, Elements, Part, Patch};

/// Side of a face.
type FaceSide = (u32, u32, bool);

/// What elements send back of what they receive, as luminance; light of their own is left out, which all solvers know.
pub(super) struct Field<'a> {
    list: &'a [Element],
    reflected: Vec<f64>,
    sides: HashMap<FaceSide, Vec<usize>>,
}

fn luminance(light: Spectrum) -> f64 {
    f64::from(light.luminance(&Wavelengths::default()))
}

fn side(patch: &Patch) -> FaceSide {
    (patch.surface, patch.face, patch.back)
}

impl<'a> Field<'a> {
    pub(super) fn new(elements: &'a Elements<'_>, radiosity: &[Spectrum]) -> Self {
        let reflected = elements.list.iter().zip(radiosity);
        let reflected = reflected.map(|(element, &light)| luminance(light - element.emission)).collect();
        let mut sides: HashMap<FaceSide, Vec<usize>> = HashMap::new();
        for (number, element) in elements.list.iter().enumerate() {
            sides.entry(side(&element.patch)).or_default().push(number);
        }
        Self { list: &elements.list, reflected, sides }
    }

    /// Whether it is light on these elements.
    pub(super) fn is_on(&self, elements: &Elements<'_>) -> bool {
        std::ptr::eq(self.list, elements.list.as_slice())
    }

    /// The light at a place of a side; `None` where there is no element.
    fn at(&self, side: FaceSide, uv: DVec2) -> Option<f64> {
        let holds = |&&number: &&usize| self.list.get(number).is_some_and(|e| e.patch.part.holds(uv));
        let number = self.sides.get(&side)?.iter().find(holds)?;
        self.reflected.get(*number).copied()
    }

    /// Root of the mean over areas of the squared difference from `reference`, per that of the reference.
    ///
    /// Compared are means over the elements of the reference, of its parts after so many `levels` of quarters: what is finer than the reference is not
    /// blamed for that.
    pub(super) fn error(&self, reference: &Self, levels: u32) -> f64 {
        let (mut difference, mut norm) = (0.0, 0.0);
        for (element, &expected) in reference.list.iter().zip(&reference.reflected) {
            let mut parts = vec![element.patch.part];
            for _ in 0..levels {
                parts = parts.iter().flat_map(Part::quarters).collect();
            }
            let side = side(&element.patch);
            let found: Vec<f64> = parts.iter().filter_map(|part| self.at(side, part.center())).collect();
            if !found.is_empty() {
                let found = found.iter().sum::<f64>() / found.len() as f64;
                difference += element.area * (found - expected).powi(2);
                norm += element.area * expected.powi(2);
            }
        }
        (difference / norm).sqrt()
    }
}

/// The same for two solutions on the same elements.
pub(super) fn error_of(list: &[Element], found: &[Spectrum], expected: &[Spectrum]) -> f64 {
    let (mut difference, mut norm) = (0.0, 0.0);
    for (element, (&found, &expected)) in list.iter().zip(found.iter().zip(expected)) {
        difference += element.area * luminance(found - expected).powi(2);
        norm += element.area * luminance(expected - element.emission).powi(2);
    }
    (difference / norm).sqrt()
}
