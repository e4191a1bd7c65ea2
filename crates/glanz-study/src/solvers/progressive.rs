//! Progressive refinement: the brightest element shoots first (@cohen1988).

use std::cmp::Ordering;

use glanz_light::{Spectrum, Wavelengths};
use glanz_radiosity::elements::{Element, Elements};
use glanz_radiosity::form_factor::{FormFactors, exchange_counting_rays};
use rayon::prelude::*;

/// A radiosity solution that improves with every element that shoots.
///
/// Form factors are computed when they are needed and not stored: memory is proportional to the number of elements.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Progressive {
    /// Radiosity of each element so far.
    radiosity: Vec<Spectrum>,
    /// The unshot part of it.
    unshot: Vec<Spectrum>,
    /// Flux of all emitters, as luminance times area.
    emitted: f64,
    rays: u64,
}

impl Progressive {
    /// The state in which no emitter has shot.
    pub(super) fn new(elements: &Elements<'_>) -> Self {
        let emission: Vec<Spectrum> = elements.list.iter().map(|element| element.emission).collect();
        let mut new = Self { radiosity: emission.clone(), unshot: emission, emitted: 0.0, rays: 0 };
        new.emitted = new.unshot_flux(elements);
        new
    }

    /// Shoots the light of the element with the most unshot flux to all elements that see it. `false` if no light is unshot.
    pub(super) fn shoot(&mut self, elements: &Elements<'_>) -> bool {
        let list = &elements.list;
        let Some(from) = self.brightest(list) else { return false };
        let shooter = &list[from];
        let received: Vec<(f64, u64)> = list
            .par_iter()
            .enumerate()
            .map(|(j, to)| {
                let mut rays = 0;
                let exchanged =
                    if j == from { 0.0 } else { exchange_counting_rays(elements, shooter, to, &mut rays) };
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

    /// As [`Progressive::shoot`] with known form factors of `elements`, without rays.
    pub(super) fn shoot_known(&mut self, elements: &Elements<'_>, factors: &FormFactors) -> bool {
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

    /// The element with the most unshot flux.
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

    /// Unshot share of the emitted flux: 1 at first, 0 at the end, and possibly more than 1 in between for high reflectances.
    pub(super) fn left(&self, elements: &Elements<'_>) -> f64 {
        if self.emitted > 0.0 { self.unshot_flux(elements) / self.emitted } else { 0.0 }
    }

    /// Shadow rays so far.
    pub(super) fn rays(&self) -> u64 {
        self.rays
    }

    /// Radiosity of each element so far.
    pub(super) fn radiosity(&self) -> &[Spectrum] {
        &self.radiosity
    }

    /// Radiosity of each element with an ambient term, an estimate of the unshot light, for display only.
    ///
    /// Elements are assumed to see one another in proportion to their areas (@cohen1988 section 4), except for those that have
    /// received no light yet, such as the outsides of a room.
    pub(super) fn with_ambient(&self, elements: &Elements<'_>) -> Vec<Spectrum> {
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

#[cfg(test)]
mod tests {
    use glanz_job::CancelFlag;
    use glanz_radiosity::elements::ElementSettings;
    use glanz_radiosity::solve::{GaussSeidelSettings, gauss_seidel};
    use glanz_scene::description::MaterialKind;
    use glanz_scene::{Scene, SceneBuilder};

    use super::*;
    use crate::solvers::furnace::walls;

    fn elements(scene: &Scene) -> Elements<'_> {
        Elements::new(scene, &ElementSettings { side: 1.0 }).unwrap()
    }

    /// A room of which the ceiling shines.
    fn room() -> Scene {
        let [left, right, front, back, floor, ceiling] = walls();
        let shapes = [left, right, front, back, floor, ceiling.emitting(1.0)];
        SceneBuilder::new().shapes(shapes, MaterialKind::diffuse(0.6)).resolve().unwrap().0
    }

    #[test]
    fn shooting_comes_to_what_gathering_finds() {
        let scene = room();
        let elements = elements(&scene);
        let factors = FormFactors::new(&elements, &CancelFlag::default()).unwrap();
        let gathered =
            gauss_seidel(&elements.list, &factors, &GaussSeidelSettings::default(), &CancelFlag::default())
                .unwrap();
        let mut shot = Progressive::new(&elements);
        assert!((shot.left(&elements) - 1.0).abs() < 1e-12);
        let mut count = 0;
        while shot.left(&elements) > 1e-4 && shot.shoot(&elements) {
            count += 1;
            assert!(count < 5000);
        }
        for ((element, &a), &b) in elements.list.iter().zip(&gathered.radiosity).zip(shot.radiosity()) {
            let (a, b) = (luminance(a), luminance(b));
            assert!((a - b).abs() < 1e-3 * a.max(0.1), "{:?}: {a} {b}", element.patch);
        }
    }

    #[test]
    fn known_form_factors_shoot_as_new_ones_do() {
        let scene = room();
        let elements = elements(&scene);
        let factors = FormFactors::new(&elements, &CancelFlag::default()).unwrap();
        let (mut new, mut known) = (Progressive::new(&elements), Progressive::new(&elements));
        for _ in 0..40 {
            assert!(new.shoot(&elements) && known.shoot_known(&elements, &factors));
        }
        for (&a, &b) in new.radiosity().iter().zip(known.radiosity()) {
            assert!((luminance(a) - luminance(b)).abs() < 1e-5, "{a:?} {b:?}");
        }
        // Inside a convex room about 16 rays show that a pair is fully visible; the other side of a wall takes none.
        let inside = elements.list.iter().filter(|element| !element.patch.back).count() as u64;
        assert!(factors.rays() > 0 && factors.rays() <= 16 * inside * inside / 2);
        assert!(new.rays() > 0 && known.rays() == 0);
    }

    #[test]
    fn ambient_term_guesses_what_is_on_its_way() {
        // After the ceiling has shot, the estimate is nearer to the end than what has arrived.
        let scene = room();
        let elements = elements(&scene);
        let factors = FormFactors::new(&elements, &CancelFlag::default()).unwrap();
        let end =
            gauss_seidel(&elements.list, &factors, &GaussSeidelSettings::default(), &CancelFlag::default())
                .unwrap()
                .radiosity;
        let mut shot = Progressive::new(&elements);
        for _ in 0..6 {
            assert!(shot.shoot(&elements));
        }
        let error = |found: &[Spectrum]| {
            let inside = elements.list.iter().zip(found.iter().zip(&end)).filter(|(e, _)| !e.patch.back);
            inside.map(|(e, (&a, &b))| e.area * (luminance(a) - luminance(b)).powi(2)).sum::<f64>().sqrt()
        };
        let (without, with) = (error(shot.radiosity()), error(&shot.with_ambient(&elements)));
        assert!(with < 0.5 * without, "{with} {without}");
    }
}
