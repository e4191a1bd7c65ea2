//! Light on elements, and differences between two solutions.

use std::collections::HashMap;

use glanz_light::{Spectrum, Wavelengths};
use glanz_math::DVec2;
use glanz_radiosity::elements::{Element, Elements, ParameterPatch, Patch};

/// Side of a face: surface, face, back.
type FaceSide = (u32, u32, bool);

/// Reflected light of elements, as luminance; emitted light is left out because it is given.
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

    /// Whether the field belongs to these elements.
    pub(super) fn is_on(&self, elements: &Elements<'_>) -> bool {
        std::ptr::eq(self.list, elements.list.as_slice())
    }

    /// The light at a point of a side; `None` where there is no element.
    fn at(&self, side: FaceSide, uv: DVec2) -> Option<f64> {
        let holds = |&&number: &&usize| self.list.get(number).is_some_and(|e| e.patch.domain.contains(uv));
        let number = self.sides.get(&side)?.iter().find(holds)?;
        self.reflected.get(*number).copied()
    }

    /// Root mean square difference from `reference` over the area, relative to that of the reference.
    ///
    /// Compares means over the elements of the reference, sampled in parts after `levels` quarterings, so that a solution that is
    /// finer than the reference is not at a disadvantage.
    pub(super) fn error(&self, reference: &Self, levels: u32) -> f64 {
        let (mut difference, mut norm) = (0.0, 0.0);
        for (element, &expected) in reference.list.iter().zip(&reference.reflected) {
            let mut parts = vec![element.patch.domain];
            for _ in 0..levels {
                parts = parts.iter().flat_map(ParameterPatch::quarters).collect();
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
