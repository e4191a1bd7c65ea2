//! The brightest element shoots first (@cohen1988).

use std::cmp::Ordering;

use glanz_light::{Spectrum, Wavelengths};
use rayon::prelude::*;

use crate::elements::{Element, Elements};
use crate::form_factor::{FormFactors, counted};

/// A solution that grows better with every element that shoots, and can be looked at any time.
///
/// Form factors are computed when they are needed and not kept: memory grows with the number of elements only.
#[derive(Clone, Debug, PartialEq)]
pub struct Progressive {
    /// Radiosity of each element so far.
    radiosity: Vec<Spectrum>,
    /// What of it has not been sent yet.
    unshot: Vec<Spectrum>,
    /// Flux of all emitters, as luminance times area.
    emitted: f64,
    rays: u64,
}

impl Progressive {
    /// At the beginning: emitters have not shot.
    #[must_use]
    pub fn new(elements: &Elements<'_>) -> Self {
        let emission: Vec<Spectrum> = elements.list.iter().map(|element| element.emission).collect();
        let mut new = Self { radiosity: emission.clone(), unshot: emission, emitted: 0.0, rays: 0 };
        new.emitted = new.unshot_flux(elements);
        new
    }

    /// The element with the most light shoots it at all that see it. `false` if there is none that has any.
    pub fn shoot(&mut self, elements: &Elements<'_>) -> bool {
        let list = &elements.list;
        let Some(from) = self.brightest(list) else { return false };
        let shooter = &list[from];
        let received: Vec<(f64, u64)> = list
            .par_iter()
            .enumerate()
            .map(|(j, to)| {
                let mut rays = 0;
                let exchanged = if j == from { 0.0 } else { counted(elements, shooter, to, &mut rays) };
                (exchanged / to.area, rays)
            })
            .collect();
        let light = std::mem::replace(&mut self.unshot[from], Spectrum::BLACK);
        for (j, (share, rays)) in received.into_iter().enumerate() {
            self.rays += rays;
            self.receive(list, j, light * share as f32);
        }
        true
    }

    /// The same with form factors of `elements` that are known already: no rays, and little time.
    pub fn shoot_known(&mut self, elements: &Elements<'_>, factors: &FormFactors) -> bool {
        let list = &elements.list;
        let Some(from) = self.brightest(list) else { return false };
        let light = std::mem::replace(&mut self.unshot[from], Spectrum::BLACK);
        for &(j, factor) in factors.row(from) {
            if let Some(to) = list.get(j as usize) {
                let share = f64::from(factor) * list[from].area / to.area;
                self.receive(list, j as usize, light * share as f32);
            }
        }
        true
    }

    /// The element with the most light to send.
    fn brightest(&self, list: &[Element]) -> Option<usize> {
        let flux = |i: usize| luminance(self.unshot[i]) * list[i].area;
        let from = (0..list.len()).max_by(|&i, &j| flux(i).total_cmp(&flux(j)).then(j.cmp(&i)))?;
        (flux(from).partial_cmp(&0.0) == Some(Ordering::Greater)).then_some(from)
    }

    fn receive(&mut self, list: &[Element], number: usize, light: Spectrum) {
        let sent = list[number].reflectance * light;
        self.radiosity[number] += sent;
        self.unshot[number] += sent;
    }

    /// Share of the emitted flux that is still to be sent: 1 at first, more where light surfaces pass it on, and 0 in the end.
    #[must_use]
    pub fn left(&self, elements: &Elements<'_>) -> f64 {
        if self.emitted > 0.0 { self.unshot_flux(elements) / self.emitted } else { 0.0 }
    }

    /// Rays that told what sees what.
    #[must_use]
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Radiosity of each element so far.
    #[must_use]
    pub fn radiosity(&self) -> &[Spectrum] {
        &self.radiosity
    }

    /// Radiosity of each element with an estimate of what is still on its way, spread evenly: only to look at.
    ///
    /// All elements are taken to see one another in proportion to their areas (@cohen1988 section 4), but for those that no light has
    /// met yet: the outsides of a room are none of it.
    #[must_use]
    pub fn with_ambient(&self, elements: &Elements<'_>) -> Vec<Spectrum> {
        let (mut area, mut unshot, mut reflected) = (0.0, Spectrum::BLACK, Spectrum::BLACK);
        let lights = self.radiosity.iter().zip(&self.unshot);
        let lit = elements.list.iter().zip(lights).filter(|(_, (radiosity, _))| !radiosity.is_black());
        for (element, (_, &light)) in lit {
            area += element.area;
            unshot += light * element.area as f32;
            reflected += element.reflectance * element.area as f32;
        }
        if area <= 0.0 {
            return self.radiosity.clone();
        }
        let per = (1.0 / area) as f32;
        let mean = (reflected * per).map(|rho| 1.0 / (1.0 - rho.min(0.99)));
        let ambient = unshot * per * mean;
        let guess = |element: &Element, radiosity: Spectrum| {
            if radiosity.is_black() { radiosity } else { radiosity + element.reflectance * ambient }
        };
        elements.list.iter().zip(&self.radiosity).map(|(element, &found)| guess(element, found)).collect()
    }

    fn unshot_flux(&self, elements: &Elements<'_>) -> f64 {
        elements.list.iter().zip(&self.unshot).map(|(element, &light)| luminance(light) * element.area).sum()
    }
}

fn luminance(light: Spectrum) -> f64 {
    f64::from(light.luminance(&Wavelengths::default()))
}
