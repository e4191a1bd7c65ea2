//! Photons by place.

use std::f64::consts::PI;

use glanz_math::glam::I64Vec3;
use glanz_math::{AreaPdf, DVec3, Ray};
use glanz_sampling::hash::combine;
use glanz_sampling::mis;
use glanz_scene::{LightId, Scene};

use super::Photon;
use super::trace::PhotonArrival;
use crate::integrator::Counters;

/// Smallest cosine between the normals at a photon and at a point that it lights, against leaks at corners.
const LEAST_NORMAL_COSINE: f32 = 0.8;

/// Largest distance of a photon from the tangent plane over the radius, against leaks through thin walls and at steps.
const THICKNESS: f64 = 0.25;

/// Photons of one sample number, in the buckets of a grid.
#[derive(Debug)]
pub struct PhotonMap {
    radius: f64,
    /// Number of photon paths.
    paths: u32,
    counters: Counters,
    /// The first photon of each bucket, and the end of the last one; a power of two of buckets.
    starts: Vec<u32>,
    /// World space, metres; by bucket, and within a bucket in the order of paths.
    positions: Vec<DVec3>,
    photons: Vec<Photon>,
}

impl PhotonMap {
    /// The map of what arrived, at positions in world space, metres, of a number of photon paths. `counters`: the rays traced for it.
    pub(super) fn new(radius: f64, paths: u32, arrivals: &[PhotonArrival], counters: Counters) -> Self {
        let buckets = arrivals.len().next_power_of_two();
        let bucket = |position: DVec3| bucket(cell(position, radius), buckets);
        let keys: Vec<usize> = arrivals.iter().map(|arrival| bucket(arrival.position)).collect();
        let mut starts = vec![0; buckets + 1];
        for &key in &keys {
            starts[key + 1] += 1;
        }
        for i in 0..buckets {
            starts[i + 1] += starts[i];
        }
        // Photons of a bucket keep their order.
        let (mut next, mut order) = (starts.clone(), vec![0; arrivals.len()]);
        for (i, &key) in keys.iter().enumerate() {
            order[next[key] as usize] = i;
            next[key] += 1;
        }
        let sorted = || order.iter().map(|&i| arrivals[i]);
        let positions = sorted().map(|arrival| arrival.position).collect();
        let photons = sorted().map(|arrival| arrival.photon).collect();
        Self { radius, paths, counters, starts, positions, photons }
    }

    /// Rays traced for the map, and before the first one to fit the density of emission.
    pub(crate) fn counters(&self) -> Counters {
        self.counters
    }

    /// Area of the disk of a density estimate, m^2.
    pub(crate) fn area(&self) -> f64 {
        PI * self.radius * self.radius
    }

    /// Calls `visit` for all photons that light the point `at` (world space, metres) of a surface with this unit normal, in a fixed order.
    pub(crate) fn visit(&self, at: DVec3, normal: DVec3, mut visit: impl FnMut(&Photon)) {
        let squared = self.radius * self.radius;
        for bucket in self.buckets_near(at) {
            let range = self.starts[bucket] as usize..self.starts[bucket + 1] as usize;
            for (position, photon) in self.positions[range.clone()].iter().zip(&self.photons[range]) {
                let offset = *position - at;
                if offset.length_squared() <= squared
                    && offset.dot(normal).abs() <= THICKNESS * self.radius
                    && normal.as_vec3().dot(photon.normal).abs() >= LEAST_NORMAL_COSINE
                {
                    visit(photon);
                }
            }
        }
    }

    /// The buckets of the eight cells that a ball about `at` may touch, each once.
    fn buckets_near(&self, at: DVec3) -> impl Iterator<Item = usize> {
        let low = cell(at - self.radius, self.radius);
        let mut near = [0; 8];
        for (i, near) in (0..).zip(&mut near) {
            let corner = low.wrapping_add(I64Vec3::new(i & 1, i >> 1 & 1, i >> 2));
            *near = bucket(corner, self.starts.len() - 1);
        }
        near.sort_unstable();
        let mut last = None;
        near.into_iter().filter(move |&bucket| last.replace(bucket) != Some(bucket))
    }

    /// Expected number of photons in the disk at a point over that of paths that continue there in the direction of the light and hit it, divided by the density of
    /// emission. `cosine`: between direction and normal; `pdf`: density per solid angle of the direction.
    pub(crate) fn odds(&self, cosine: f64, pdf: f64) -> f64 {
        f64::from(self.paths) * self.area() * cosine / pdf
    }

    /// Weight of `photon` where it has these [`PhotonMap::odds`], against paths that hit its light by chance.
    pub(crate) fn weight(odds: f64, photon: &Photon) -> f64 {
        mis::power(odds * f64::from(photon.emission), 1.0)
    }

    /// Weight of the light `id` against photons, where a path with these odds hits it along `ray`. `area_pdf`: density of the point on the light, if that is a surface.
    pub(crate) fn weight_of_hit(
        scene: &Scene,
        odds: f64,
        id: LightId,
        ray: &Ray,
        area_pdf: Option<AreaPdf>,
    ) -> f64 {
        let emission = scene.emission_pdf(id, ray.origin, ray.direction, area_pdf);
        mis::power(1.0, odds * emission * scene.emitter_probability(id))
    }
}

/// The cell of a position. A ball of `radius` touches two cells along each axis at most.
fn cell(position: DVec3, radius: f64) -> I64Vec3 {
    (position / (2.0 * radius)).floor().as_i64vec3()
}

/// The bucket of a cell, of a power of two of them.
fn bucket(cell: I64Vec3, buckets: usize) -> usize {
    let key = cell.to_array().into_iter().fold(0, |key, x| combine(key, x as u64));
    key as usize & (buckets - 1)
}

#[cfg(test)]
mod tests {
    use glanz_light::Spectrum;
    use glanz_math::glam::Vec3;
    use glanz_sampling::{PixelSampler, SamplerKind};

    use super::*;

    fn photon(number: u32, normal: Vec3) -> Photon {
        Photon { from: Vec3::Z, normal, flux: Spectrum::ONE, emission: 1.0, events: number }
    }

    #[test]
    fn visited_are_the_photons_of_the_disk_each_once() {
        let place = |i: u32| {
            let [x, y, z, _] = PixelSampler::new(SamplerKind::Independent, 1, 3, [0, 0], i).next_group();
            DVec3::new(x, y, 0.2 * z) - 0.5
        };
        let normal = |i: u32| if i.is_multiple_of(3) { Vec3::X } else { -Vec3::Z };
        let arrival = |i| PhotonArrival { path: i, position: place(i), photon: photon(i, normal(i)) };
        let arrivals: Vec<_> = (0..3000).map(arrival).collect();
        let radius = 0.13;
        let map = PhotonMap::new(radius, 1, &arrivals, Counters::default());
        let mut visits = 0;
        for i in 5000..5200 {
            let at = place(i);
            let mut seen = Vec::new();
            map.visit(at, DVec3::Z, |photon| seen.push(photon.events));
            visits += seen.len();
            seen.sort_unstable();
            let in_disk = |arrival: &&PhotonArrival| {
                let offset = arrival.position - at;
                offset.length() <= radius && offset.z.abs() <= THICKNESS * radius
            };
            let inside = arrivals.iter().filter(in_disk).map(|arrival| arrival.photon.events);
            assert_eq!(seen, inside.filter(|i| !i.is_multiple_of(3)).collect::<Vec<_>>());
        }
        assert!(visits > 1000, "{visits}");
    }

    #[test]
    fn places_beyond_the_integers_of_cells_are_searched() {
        let far = DVec3::new(1e12, -1e12, 1e12);
        let arrival = PhotonArrival { path: 0, position: far, photon: photon(7, Vec3::Z) };
        let map = PhotonMap::new(1e-9, 1, &[arrival], Counters::default());
        let mut seen = Vec::new();
        map.visit(far, DVec3::Z, |photon| seen.push(photon.events));
        assert_eq!(seen, [7]);
    }

    #[test]
    fn weights_of_photons_and_of_hits_add_up_to_one() {
        for odds in [0.0, 1e-3, 1.0, 1e3] {
            let photon = Photon { emission: 2.0, ..photon(0, Vec3::Z) };
            let hit = mis::power(1.0, odds * 2.0);
            assert!((PhotonMap::weight(odds, &photon) + hit - 1.0).abs() < 1e-12);
        }
        let unhittable = Photon { emission: f32::INFINITY, ..photon(0, Vec3::Z) };
        assert_eq!(PhotonMap::weight(1e-9, &unhittable), 1.0);
    }
}
