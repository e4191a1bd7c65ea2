//! Rays of a camera that a surface fills, in order and at random.

use glanz_math::{Bounds3, DVec3, Ray};

/// Camera rays line by line, from obliquely above, the box filling the picture. Their numbers are `f32` values, so that
/// single-precision programs trace the same rays.
pub(crate) fn camera_rays(bounds: &Bounds3, width: u32, height: u32) -> Vec<Ray> {
    let (center, size) = (bounds.center(), bounds.diagonal().length());
    let eye = center + DVec3::new(0.5, -1.0, 0.9).normalize() * (1.1 * size);
    let forward = (center - eye).normalize();
    let right = forward.cross(DVec3::Z).normalize();
    let up = right.cross(forward);
    let aspect = f64::from(height) / f64::from(width);
    let short = |v: DVec3| v.as_vec3().as_dvec3();
    let pixel = |i: u32, of: u32| (f64::from(i) + 0.5) / f64::from(of) - 0.5;
    let ray = |x, y| {
        let direction = forward + right * pixel(x, width) - up * (aspect * pixel(y, height));
        Ray::new(short(eye), short(direction.normalize()))
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| ray(x, y)).collect()
}

/// The items in an order that depends on their number alone: shuffled by Fisher and Yates with splitmix64.
pub(crate) fn shuffled<T>(mut items: Vec<T>) -> Vec<T> {
    let mut state = 1_u64;
    for i in (1..items.len()).rev() {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = state;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        items.swap(i, ((x ^ (x >> 31)) % (i as u64 + 1)) as usize);
    }
    items
}
