//! The radius of density estimates, from the size of pixels.

use glanz_math::DVec2;
use glanz_scene::Scene;

/// The radius in pixels: about a dozen photons in the disk if there are as many as pixels and all arrive in the picture.
const PIXELS: f64 = 2.0;

/// Largest radius as a part of the diagonal of the scene, for pictures of few pixels.
const LARGEST: f64 = 1.0 / 200.0;

/// Number of rays along each side of the picture.
const RAYS: u32 = 16;

/// Radius, metres: some pixels, as seen at the median of the distances of surfaces from the camera. `None` if no surface is seen and none has an extent.
pub(super) fn of_pixels(scene: &Scene, resolution: [u32; 2]) -> Option<f64> {
    let size = DVec2::from(resolution.map(f64::from));
    let places = (0..RAYS * RAYS).map(|i| DVec2::from([i % RAYS, i / RAYS].map(f64::from)) + 0.5);
    let mut pixels: Vec<f64> =
        places.filter_map(|place| pixel(scene, place / f64::from(RAYS) * size)).collect();
    pixels.sort_by(f64::total_cmp);
    let seen = pixels.get(pixels.len() / 2).map(|pixel| PIXELS * pixel);
    let bounds = scene.bounds();
    // A plane has a bound of no extent.
    let largest = Some(LARGEST * bounds.diagonal().length()).filter(|&r| !bounds.is_empty() && r > 0.0);
    let radius = match (seen, largest) {
        (Some(seen), Some(largest)) => Some(seen.min(largest)),
        (seen, largest) => seen.or(largest),
    };
    radius.filter(|&r| r > 0.0)
}

/// The size of a pixel on the surface that is seen at the film point `film`, metres.
fn pixel(scene: &Scene, film: DVec2) -> Option<f64> {
    let ray = |film| Some(scene.camera().ray(film, DVec2::splat(0.5))?.ray);
    let (own, next) = (ray(film)?, ray(film + DVec2::X)?);
    let hit = scene.intersect(&own, f64::INFINITY)?;
    Some((own.at(hit.t) - next.at(hit.t)).length())
}
